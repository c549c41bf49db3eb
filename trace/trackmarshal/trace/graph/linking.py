"""The links of a project: who names whom in its documents, its specs and its evidence, and whether what is named is there and as it was."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

from trackmarshal.records.specs import SpecItem
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph import works
from trackmarshal.trace.graph.fingerprints import version
from trackmarshal.trace.graph.graph import Key, Link, Node
from trackmarshal.trace.graph.keys import KIND, USED, external_key, uses
from trackmarshal.trace.graph.kinds import LINKS, NODES
from trackmarshal.trace.model import Project, Requirement, matches
from trackmarshal.trace.outside import Outside
from trackmarshal.trace.spec import Spec, item_place
from trackmarshal.trace.values import Placed


class Linking:
    """Links between nodes, which are all there; what has no node is named all the same, and the link says so."""

    def __init__(self, project: Project, spec: Spec, around: Outside, nodes: Mapping[Key, Node]) -> None:
        self.project, self.spec, self.around, self.nodes = project, spec, around, nodes
        self.found: list[Link] = []
        #: Of links to anything: by id, the kinds that have it; and persons by name.
        self._kinds_of: dict[str, list[str]] = defaultdict(list)
        self._persons: dict[str, str] = {}
        for node in nodes.values():
            self._kinds_of[node.id].append(node.kind)
            if node.kind == "person":
                self._persons.setdefault(node.title, node.id)
        self._works = [node for node in nodes.values() if node.kind == "work"]
        self._double = False
        self._known = {key: key for key in nodes}
        #: By interface, the requirements that its issues lead to.
        self._leading = {str(i.id): frozenset(i.leads_to) for i in reversed(project.interfaces)}

    def links(self) -> list[Link]:
        """All links, in order."""
        self._links_of_the_system()
        for requirement in self.project.requirements:
            self._links_of(requirement)
        for item in self.spec.items:
            self._links_of_item(item)
        self._links_of_evidence()
        for entry in self.project.entries:
            key = self._at((entry.kind, str(entry.id)), entry.id.place)
            self._given(key, entry.links, dict(entry.versions))
        self._double = False
        for waiver in self.project.waivers:
            key = ("waiver", str(waiver.id))
            self._fitting("excuses", key, waiver.requirements, waiver.id.place)
            self._owner(key, str(waiver.owner), waiver.id.place)
            self._owner(key, str(waiver.approver), waiver.approver.place, "approved_by")
        return self.found

    def _links_of_the_system(self) -> None:
        for interface in self.project.interfaces:
            name = str(interface.id)
            self._at(("interface", name), interface.id.place)
            for end in dict.fromkeys(interface.ends):
                self._link("joins", ("interface", name), ("subsystem", end), interface.id.place)
            for issue in interface.issues:
                key = self._at(("issue", str(issue.id)), issue.id.place)
                self._link("found_at", key, ("interface", name), issue.id.place)
                for target in issue.leads_to:
                    answer = self.project.by_id.get(target)
                    state = _answered(answer is not None, answer is not None and name in answer.derived_from)
                    self._link("leads_to", key, ("requirement", str(target)), target.place, state)

    def _links_of(self, r: Requirement) -> None:
        key = self._at(("requirement", str(r.id)), r.place)
        for source in r.derived_from:
            interface = self._leading.get(source)
            state = _answered(interface is not None, interface is not None and r.id in interface)
            self._link("derived_from", key, ("interface", str(source)), source.place, state)
        for parent in r.refines:
            self._link("refines", key, ("requirement", str(parent)), parent.place)
        for kind, names in (("metrics", r.metrics), ("assumptions", r.assumptions)):
            for name in names:
                target = LINKS[kind].targets[0]
                item = self.spec.by_name.get(name)
                there = item is not None and KIND[item.kind] == target
                answered = there and item is not None and any(ref.id == r.id for ref in item.satisfies)
                self._link(kind, key, (target, str(name)), name.place, _answered(there, answered))
        self._given(key, r.links)

    def _links_of_item(self, item: SpecItem) -> None:
        key = (KIND[item.kind], item.name)
        self._double = self.spec.by_name[item.name] is not item
        for ref in item.satisfies:
            place = Place(item.file, ref.line, ref.column)
            self._link("satisfies", key, ("requirement", ref.id), place)
        for ref in item.assuming:
            target = self.spec.by_name.get(ref.id)
            state = _answered(target is not None, target is not None and target.kind == "assume")
            self._link("assuming", key, ("assumption", ref.id), Place(item.file, ref.line, ref.column), state)
        for kind, name in uses(item):
            self._link("uses", key, (kind, name), item_place(item))
        if item.evidence:
            self._link("backed_by", key, ("document", item.evidence), item_place(item))
        self._owner(key, item.owner, item_place(item))
        for work in works.cited(item.source, self._works):
            self._link("cites", key, ("work", work), item_place(item))

    def _links_of_evidence(self) -> None:
        self._double = False
        for part in self.spec.parts:
            for name in part.of:
                kind = "table" if ("table", name) in self.nodes else "parameter"
                place = Place(part.file, part.line, part.column)
                self._link("restricts", (USED[part.kind], part.name), (kind, name), place)
        for test in self.spec.tests:
            item = self.spec.by_name.get(test.rule)
            target = ("rule" if item is None else KIND[item.kind], test.rule)
            self._link("tests", ("test", f"{test.rule}: {test.title}"), target, item_place(test))
        for result in self.spec.results.values():
            key, place = f"{result.rule}: {result.title}", Place(result.file, result.line)
            state = "outdated" if ("test", key) in self.nodes and self.spec.staleness(result) else ""
            self._link("result", ("result", key), ("test", key), place, state)
        for scenario in self.project.scenarios:
            shown = ("scenario", str(scenario.path))
            self._link("at", shown, ("stage", str(scenario.stage)), scenario.stage.place)
            named = [pattern for pattern in scenario.requirements if pattern != "*"]
            self._fitting("shows", shown, named, scenario.path.place)
        for run in self.spec.runs.values():
            ran, replayed, place = ("run", run.scenario), ("scenario", run.scenario), Place(run.scenario)
            state = "outdated" if self.nodes[ran].attributes["outcome"] == "stale" else ""
            self._link("replays", ran, replayed, place, state if replayed in self.nodes else "")
            for facts in run.rules:
                item = self.spec.by_name.get(facts.rule)
                if item is not None and facts.number("satisfied", "violated"):
                    self._link("evaluates", ran, (KIND[item.kind], item.name), place, state)
        for case in self.spec.faults:
            put_in, place = ("fault", f"{case.campaign} {case.id}"), Place(case.campaign, case.line)
            self._link("challenges", put_in, ("requirement", case.requirement), place)
        for external in self.around.tests:
            for id_ in external.test.requirements:
                self._link("confirms", external_key(external), ("requirement", id_), external.place)
        for marker in self.around.markers:
            code = ("code", marker.place.file)
            self._link("implements", code, ("requirement", marker.requirement), marker.place)
        for document in self.project.evidence:
            written = ("document", str(document.path))
            self._link("at", written, ("stage", str(document.stage)), document.stage.place)
            self._fitting("evidence", written, document.requirements, document.path.place)

    def _fitting(self, kind: str, key: Key, patterns: Iterable[Placed], place: Place) -> None:
        """A link to each demanded requirement that patterns fit."""
        wanted = tuple(patterns)
        for requirement in self.project.by_id.values():
            if requirement.demanded and matches(requirement.id, wanted):
                self._link(kind, key, ("requirement", str(requirement.id)), place)

    def _given(
        self, key: Key, links: Iterable[tuple[str, Placed]], versions: Mapping[Placed, str] | None = None
    ) -> None:
        """Links that a document writes down by their kinds; `versions`: fingerprints that their targets had."""
        for kind, target in links:
            if kind == "owned_by":
                self._owner(key, target, target.place)
                continue
            targets = LINKS[kind].targets or tuple(NODES)
            named, _, rest = target.partition(":")
            end, state = (named.replace("-", " "), rest.strip()), ""
            if end[0] not in targets or not rest:  # it names no kind before its id
                fitting = [k for k in self._kinds_of.get(target, ()) if k in targets and k != "result"]
                end = (fitting[0] if fitting else targets[0], str(target))
                state = "ambiguous" if len(fitting) > 1 else ""
            read, node = (versions or {}).get(target, ""), self.nodes.get(end)
            if not state and read and node is not None and read != version(node):
                state = "outdated"
            self._link(kind, key, end, target.place, state)

    def _owner(self, key: Key, owner: str, place: Place, kind: str = "owned_by") -> None:
        """Who answers for it, or approved it: a person, by id or by name. Without declared persons, any text does."""
        if owner and self._persons:
            person = owner if ("person", owner) in self.nodes else self._persons.get(owner, owner)
            self._link(kind, key, ("person", str(person)), place)

    def _link(self, kind: str, source: Key, target: Key, place: Place, state: str = "") -> None:
        """One more link; without `state` it covers where its target is, and is demanded."""
        if self._double:
            state = "ambiguous"
        elif not state:
            node = self.nodes.get(target)
            state = "orphaned" if node is None else "covers" if node.demanded else "unwanted"
        known = self._known  # one object for each key, however many links have it
        self.found.append(Link(kind, known.get(source, source), known.get(target, target), state, place))

    def _at(self, key: Key, place: Place) -> Key:
        """The record that the next links stand in. Where it is the second one with its id, it is open of which of the two they are."""
        self._double = self.nodes[key].place != place
        return key


def _answered(there: bool, answers: bool) -> str:
    """The state of a link whose target has to be of its kind, or to name its source: it does, is something else, or is not there."""
    return "covers" if answers else "unwanted" if there else "orphaned"
