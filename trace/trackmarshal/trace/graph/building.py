"""The graph of a project, made once of its documents, the engine's records and the hashes of files."""

from __future__ import annotations

import hashlib
import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping

from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import DriveFacts, RunSummary
from trackmarshal.records.specs import SpecItem
from trackmarshal.records.tests import ExternalTest, TestResult
from trackmarshal.trace import faults, runs
from trackmarshal.trace.external import External, worst
from trackmarshal.trace.files import Hashes, demanding
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph import works
from trackmarshal.trace.graph.graph import Graph, Key, Link, Node
from trackmarshal.trace.graph.kinds import LINKS, NODES
from trackmarshal.trace.model import Entry, Project, Requirement, matches
from trackmarshal.trace.outside import Outside
from trackmarshal.trace.spec import Spec, item_place
from trackmarshal.trace.values import Placed
from trackmarshal.units import moment

_KIND = {"rule": "rule", "assume": "assumption"}
#: What the engine calls what rules read or rest on, and what that is here. Other inputs of a rule are no things with a name.
_USED = {
    "param": "parameter",
    "table": "table",
    "place": "place",
    "signal": "signal",
    "constraint": "constraint",
    "rulebook": "rulebook",
}


#: What is decided of hazards and goals, and read by whoever reviews them.
_RATED = {
    "hazard": ("severity", "exposure", "controllability", "asil"),
    "safety goal": ("asil", "safe_state", "tolerance"),
}
#: And what else is read by whoever judges whether what is demanded, or rated, is right: each by its name, so that nothing moves from the one to the other.
#: Titles and owners name things and people; links are the baseline's.
_READ = {
    "requirement": ("asil", "verification", "source", "adopted", "rationale"),
    "hazard": ("rationale",),
    "analysis": ("open",),
}


#: Of these, all that is declared is read.
_DECLARED = (
    "operational design domain",
    "design element",
    "method",
    "tool",
    "malfunction",
    "indicator",
    "work",
    "waiver",
)


def build(project: Project, spec: Spec, hashes: Hashes, around: Outside | None = None) -> Graph:
    """The graph; a link whose target does not exist is in it, and says so."""
    return _Building(project, spec, hashes, around or Outside()).graph()


def fingerprint(node: Node) -> str:
    """The fingerprint of what a node says: the engine's or the file's; else the SHA-256 of its statement, situation, description or title, with what hazards
    and goals are rated as, and what else is read of requirements and hazards.

    How the lines of a text are broken does not matter, nor the order of methods.
    """
    said = node.attributes
    texts = (said.get(name, "") for name in ("statement", "situation", "description"))
    text = next(filter(None, texts), node.title)
    more = [said[name] for name in _RATED.get(node.kind, ()) if name in said]
    more += [
        f"{name}: {', '.join(sorted(said[name].split(', '))) if name == 'verification' else said[name]}"
        for name in _READ.get(node.kind, ())
        if said.get(name)
    ]
    text = "\n".join((text, *more))
    return said.get("fingerprint") or hashlib.sha256(" ".join(text.split()).encode()).hexdigest()


def version(node: Node) -> str:
    """The fingerprint that a review names of what it read: that of the node, and, where this is of its text alone, of what else it says."""
    more = [node.says] if node.says else []
    if node.kind in _DECLARED:
        more += [f"{name}: {text}" for name, text in sorted(node.attributes.items()) if name != "owner"]
    own = fingerprint(node)
    return hashlib.sha256("\n".join([own, *more]).encode()).hexdigest() if more else own


def _record(said: TestResult | RunSummary | FaultResult | ExternalTest, *apart: str) -> str:
    """The sha256 of a result as it is recorded, but for where it stands and when it was made."""
    data = {name: value for name, value in said.to_json().items() if name not in apart}
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()


class _Building:
    def __init__(self, project: Project, spec: Spec, hashes: Hashes, around: Outside) -> None:
        self.project, self.spec, self.hashes, self.around = project, spec, hashes, around
        self.nodes: dict[Key, Node] = {}
        self.found: list[Link] = []
        #: Of links to anything: by id, the kinds that have it; and persons by name.
        self._kinds_of: dict[str, list[str]] = defaultdict(list)
        self._persons: dict[str, str] = {}
        self._works: list[Node] = []
        self._double = False
        self._known: dict[Key, Key] = {}
        #: By interface, the requirements that its issues lead to.
        self._leading = {str(i.id): frozenset(i.leads_to) for i in reversed(project.interfaces)}

    def graph(self) -> Graph:
        self._system()
        self._requirements()
        self._specs()
        self._runs()
        self._outside()
        self._documents()
        for entry in self.project.entries:
            attributes = dict(entry.attributes)
            if entry.kind == "analysis":
                attributes["outcome"] = self._of_argument(entry)
                attributes["fingerprint"] = self._of_analysis(entry)
            if entry.made is not None:
                attributes["made"] = entry.made.isoformat()
            self._node(entry.kind, entry.id, entry.title, entry.id.place, attributes)
        self._known = {key: key for key in self.nodes}
        for node in self.nodes.values():
            self._kinds_of[node.id].append(node.kind)
            if node.kind == "person":
                self._persons.setdefault(node.title, node.id)
        self._works = [node for node in self.nodes.values() if node.kind == "work"]
        self._links()
        places = {("requirement", str(r.id)): r.asil.place for r in self.project.by_id.values()}
        return Graph(self.nodes, self.found, places)

    def _node(
        self,
        kind: str,
        id_: str,
        title: str,
        place: Place | None,
        attributes: Mapping[str, str],
        says: str = "",
    ) -> None:
        """One more node; of two with one key the first counts, as everywhere."""
        key = (kind, str(id_))
        if key not in self.nodes:
            self.nodes[key] = Node(kind, key[1], title, place, attributes, says)

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

    def _system(self) -> None:
        for part in self.project.subsystems:
            self._node("subsystem", part.id, part.title, part.id.place, {"role": part.role})
        for stage in self.project.stages:
            self._node("stage", stage.id, stage.title, stage.id.place, {"counts": ", ".join(stage.counts)})
        for interface in self.project.interfaces:
            self._node(
                "interface",
                interface.id,
                interface.title,
                interface.id.place,
                {"rationale": interface.rationale},
            )
            for issue in interface.issues:
                self._node("issue", issue.id, issue.text, issue.id.place, {"interface": str(interface.id)})

    def _requirements(self) -> None:
        for r in self.project.by_id.values():
            attributes = {
                "status": str(r.status), "asil": str(r.asil), "verification": ", ".join(r.verification), "adopted": str(r.adopted),
                "source": str(r.source), "owner": str(r.owner), "statement": str(r.statement), "rationale": r.rationale,
                "not_verified_by": " ".join(method for method, _ in r.not_verified_by),
            }  # fmt: skip
            self._node("requirement", r.id, r.title, r.place, attributes)

    def _specs(self) -> None:
        for item in self.spec.by_name.values():
            attributes = {
                "severity": item.severity, "owner": item.owner, "monitored": "yes" if item.monitored else "no",
                "source": item.source, "fingerprint": item.fingerprint,
            }  # fmt: skip
            self._node(_KIND[item.kind], item.name, item.title, item_place(item), attributes)
        for part in self.spec.parts:
            if part.kind in ("limit", "replay"):
                continue  # to which nothing is linked
            place = Place(part.file, part.line, part.column)
            self._node(
                _USED[part.kind],
                part.name,
                part.shown,
                place,
                {"fingerprint": part.fingerprint},
            )
        for item in self.spec.by_name.values():
            for kind, name in _uses(item):
                self._node(kind, name, "", None, {})
        for test in self.spec.tests:
            result = self.spec.results.get((test.rule, test.title))
            outcome = (
                "not run" if result is None else "stale" if self.spec.staleness(result) else result.outcome
            )
            attributes = {
                "expects": test.expects,
                "boundary": "yes" if test.boundary else "no",
                "outcome": outcome,
            }
            named = f"{test.rule}: {test.title}"
            self._node("test", named, test.title, item_place(test), attributes, test.fingerprint)
        for result in self.spec.results.values():
            place = Place(result.file, result.line)
            self._node(
                "result", f"{result.rule}: {result.title}", result.message, place,
                {"outcome": result.outcome, "sha256": _record(result, "file", "line")},
            )  # fmt: skip

    def _of_argument(self, entry: Entry) -> str:
        """What came of an analysis: it left something open, is written down nowhere, which a document that says that there is none is, or is complete.
        A document that says what is demanded is none."""
        if "open" in entry.attributes:
            return "open"
        paths = [str(path) for kind, path in entry.links if kind == "backed_by"]
        if any((path, str(entry.id)) in self.around.denials for path in paths):
            return "not written down"
        written = any(self.hashes.get(path) and demanding(path) not in self.hashes for path in paths)
        return "complete" if written else "not written down"

    def _of_analysis(self, entry: Entry) -> str:
        """The fingerprint of an analysis: its title, what it leaves open, and what stands in its document, which is what a review of it reads; "" without one."""
        held = [self.hashes.get(path) or "" for kind, path in entry.links if kind == "backed_by"]
        left = [f"open: {entry.attributes['open']}"] if "open" in entry.attributes else []
        said = [" ".join(text.split()) for text in (entry.title, *left)]
        return hashlib.sha256("\n".join([*said, *held]).encode()).hexdigest() if held else ""

    def _runs(self) -> None:
        for scenario in self.project.scenarios:
            attributes = {
                "stage": str(scenario.stage),
                "expect": str(scenario.expect),
                "origin": str(scenario.origin),
            }
            told = [
                str(scenario.expect),
                str(scenario.origin),
                *sorted(map(str, scenario.by)),
                "",
                *map(str, scenario.specs),
            ]
            says = " ".join([*told, self.hashes.get(str(scenario.path)) or ""])
            self._node("scenario", scenario.path, scenario.title, scenario.path.place, attributes, says)
        scenarios = {str(scenario.path): scenario for scenario in reversed(self.project.scenarios)}
        for run in self.spec.runs.values():
            stale = runs.staleness(scenarios.get(run.scenario), run, self.spec, self.hashes)
            declared = self.nodes.get(("scenario", run.scenario))
            attributes = {
                "fired": "yes" if run.fired else "no",
                "cycles": str(run.cycles),
                "outcome": "stale" if stale else "run",
                "sha256": _record(run, "created"),
                "expect": "" if declared is None else declared.attributes["expect"],
                "origin": "" if declared is None else declared.attributes["origin"],
            }
            if run.drive is not None:
                attributes |= dict(_driven(run.drive))
            self._node("run", run.scenario, "", None, attributes)
        for case in self.spec.faults:
            status, _ = faults.verdict(case, self.spec)
            attributes = {
                "campaign": case.campaign,
                "outcome": "open" if case.open else status,
                "put_in": "no" if case.begin is None else "yes",
            }
            put_in = self.spec.fault_results.get((case.campaign, case.id))
            if put_in is not None:
                attributes["sha256"] = _record(put_in)
                attributes |= dict(_found(case, put_in))
            self._node(
                "fault",
                f"{case.campaign} {case.id}",
                case.title,
                Place(case.campaign, case.line),
                attributes,
                case.says,
            )

    def _outside(self) -> None:
        for external in worst(self.around.tests):
            test = external.test
            attributes = {
                "outcome": test.outcome, "stage": str(external.stage), "tool": test.tool, "created": test.created,
                "report": test.report, "sha256": _record(test, "file", "line", "report_line", "created", "duration"),
            }  # fmt: skip
            self._node(*_external(external), test.message, external.place, attributes)
        for marker in self.around.markers:
            self._node("code", marker.place.file, "", marker.place, {})

    def _documents(self) -> None:
        for entry in self.project.evidence:
            attributes = {"stage": str(entry.stage), **self._document(str(entry.path))}
            self._node("document", entry.path, entry.title, entry.path.place, attributes)
        named = [(item.evidence, item_place(item)) for item in self.spec.by_name.values() if item.evidence]
        named += [
            (str(path), path.place)
            for e in self.project.entries
            for kind, path in e.links
            if kind == "backed_by"
        ]
        if self.project.closed_loop is not None:
            named.append((str(self.project.closed_loop), self.project.closed_loop.place))
        for path, place in named:
            self._node("document", path, "", place, self._document(path))
        for waiver in self.project.waivers:
            attributes = {
                "owner": str(waiver.owner), "approver": str(waiver.approver), "granted": waiver.granted.isoformat(),
                "expires": waiver.expires.isoformat(), "residual_risk": waiver.residual_risk, "stages": ", ".join(waiver.stages),
                "codes": ", ".join(waiver.codes), "subjects": ", ".join(waiver.subjects),
            }  # fmt: skip
            self._node("waiver", waiver.id, waiver.justification, waiver.id.place, attributes)

    def _document(self, path: str) -> dict[str, str]:
        """What a document has come to, by all that names it: as cells have it, the worst prevails."""
        there = self.hashes.get(path)
        reviewed = {entry.sha256 for entry in self.project.evidence if entry.path == path and entry.sha256}
        if not there or demanding(path) in self.hashes:
            outcome = "missing"
        elif reviewed - {there}:
            outcome = "changed"
        elif any(denying == path for denying, _ in self.around.denials):
            outcome = "partial"
        else:
            outcome = "there"
        return {"outcome": outcome, "fingerprint": there or ""}

    def _links(self) -> None:
        self._links_of_the_system()
        for requirement in self.project.requirements:
            self._links_of(requirement)
        for item in self.spec.items:
            self._links_of_item(item)
        self._links_of_evidence()
        for entry in self.project.entries:
            self._given(
                self._at((entry.kind, str(entry.id)), entry.id.place), entry.links, dict(entry.versions)
            )
        self._double = False
        for waiver in self.project.waivers:
            self._fitting("excuses", ("waiver", str(waiver.id)), waiver.requirements, waiver.id.place)
            self._owner(("waiver", str(waiver.id)), str(waiver.owner), waiver.id.place)
            self._owner(
                ("waiver", str(waiver.id)), str(waiver.approver), waiver.approver.place, "approved_by"
            )

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
                    state = (
                        "orphaned"
                        if answer is None
                        else "covers"
                        if name in answer.derived_from
                        else "unwanted"
                    )
                    self._link("leads_to", key, ("requirement", str(target)), target.place, state)

    def _links_of(self, r: Requirement) -> None:
        key = self._at(("requirement", str(r.id)), r.place)
        for source in r.derived_from:
            interface = self._leading.get(source)
            state = "orphaned" if interface is None else "covers" if r.id in interface else "unwanted"
            self._link("derived_from", key, ("interface", str(source)), source.place, state)
        for parent in r.refines:
            self._link("refines", key, ("requirement", str(parent)), parent.place)
        for kind, names in (("metrics", r.metrics), ("assumptions", r.assumptions)):
            for name in names:
                target = LINKS[kind].targets[0]
                item = self.spec.by_name.get(name)
                there = item is not None and _KIND[item.kind] == target
                answered = there and item is not None and any(ref.id == r.id for ref in item.satisfies)
                state = "covers" if answered else "unwanted" if there else "orphaned"
                self._link(kind, key, (target, str(name)), name.place, state)
        self._given(key, r.links)

    def _links_of_item(self, item: SpecItem) -> None:
        key = (_KIND[item.kind], item.name)
        self._double = self.spec.by_name[item.name] is not item
        for ref in item.satisfies:
            place = Place(item.file, ref.line, ref.column)
            self._link("satisfies", key, ("requirement", ref.id), place)
        for ref in item.assuming:
            target = self.spec.by_name.get(ref.id)
            state = "orphaned" if target is None else "covers" if target.kind == "assume" else "unwanted"
            self._link("assuming", key, ("assumption", ref.id), Place(item.file, ref.line, ref.column), state)
        for kind, name in _uses(item):
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
                self._link(
                    "restricts",
                    (_USED[part.kind], part.name),
                    (kind, name),
                    Place(part.file, part.line, part.column),
                )
        for test in self.spec.tests:
            item = self.spec.by_name.get(test.rule)
            target = ("rule" if item is None else _KIND[item.kind], test.rule)
            self._link("tests", ("test", f"{test.rule}: {test.title}"), target, item_place(test))
        for result in self.spec.results.values():
            key, place = f"{result.rule}: {result.title}", Place(result.file, result.line)
            state = "outdated" if ("test", key) in self.nodes and self.spec.staleness(result) else ""
            self._link("result", ("result", key), ("test", key), place, state)
        for scenario in self.project.scenarios:
            self._link(
                "at", ("scenario", str(scenario.path)), ("stage", str(scenario.stage)), scenario.stage.place
            )
            named = [pattern for pattern in scenario.requirements if pattern != "*"]
            self._fitting("shows", ("scenario", str(scenario.path)), named, scenario.path.place)
        for run in self.spec.runs.values():
            ran, place = ("run", run.scenario), Place(run.scenario)
            stale = self.nodes[ran].attributes["outcome"] == "stale"
            self._link(
                "replays",
                ran,
                ("scenario", run.scenario),
                place,
                "outdated" if stale and ("scenario", run.scenario) in self.nodes else "",
            )
            for facts in run.rules:
                item = self.spec.by_name.get(facts.rule)
                if item is not None and facts.number("satisfied", "violated"):
                    self._link(
                        "evaluates", ran, (_KIND[item.kind], item.name), place, "outdated" if stale else ""
                    )
        for case in self.spec.faults:
            put_in = ("fault", f"{case.campaign} {case.id}")
            self._link(
                "challenges", put_in, ("requirement", case.requirement), Place(case.campaign, case.line)
            )
        for external in self.around.tests:
            for id_ in external.test.requirements:
                self._link("confirms", _external(external), ("requirement", id_), external.place)
        for marker in self.around.markers:
            code = ("code", marker.place.file)
            self._link("implements", code, ("requirement", marker.requirement), marker.place)
        for document in self.project.evidence:
            self._link(
                "at", ("document", str(document.path)), ("stage", str(document.stage)), document.stage.place
            )
            self._fitting(
                "evidence", ("document", str(document.path)), document.requirements, document.path.place
            )

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
            wanted = (
                (named.replace("-", " "), rest.strip()) if named.replace("-", " ") in NODES and rest else None
            )
            if wanted is not None and wanted[0] in targets:
                end, state = wanted, ""
            else:
                fitting = [k for k in self._kinds_of.get(target, ()) if k in targets and k != "result"]
                end, state = (
                    (fitting[0] if fitting else targets[0], str(target)),
                    "ambiguous" if len(fitting) > 1 else "",
                )
            read, node = (versions or {}).get(target, ""), self.nodes.get(end)
            if not state and read and node is not None and read != version(node):
                state = "outdated"
            self._link(kind, key, end, target.place, state)

    def _owner(self, key: Key, owner: str, place: Place, kind: str = "owned_by") -> None:
        """Who answers for it, or approved it: a person, by id or by name. Without declared persons, any text does."""
        if owner and self._persons:
            person = owner if ("person", owner) in self.nodes else self._persons.get(owner, owner)
            self._link(kind, key, ("person", str(person)), place)


def _found(case: FaultCase, result: FaultResult) -> Iterator[tuple[str, str]]:
    """What found a fault, in which cycle, and how long after the first one that was changed, s."""
    yield "by", faults.found_by(result)
    if result.first is not None:
        yield "first", moment(result.first)
        if case.begin is not None:
            yield "after", f"{round(result.first - case.begin, 6):g}"


def _driven(drive: DriveFacts) -> Iterator[tuple[str, str]]:
    """What a drive of a real vehicle was, and how near each rule came to firing, in texts."""
    yield "hours", f"{drive.hours:.4g}"
    yield "km", f"{drive.km:.4g}"
    yield "firings", str(sum(drive.firings.values()))
    for one in drive.least:
        yield f"least {one.rule} {one.candidate}", one.shown


def _external(external: External) -> Key:
    """The key of a test of another runner."""
    return ("external test", f"{external.test.suite}: {external.test.name}")


def _uses(item: SpecItem) -> Iterator[tuple[str, str]]:
    """The parameters, tables, places and signals that a rule is made of, where the engine says so."""
    for called in sorted(item.inputs):
        kind, _, name = called.partition(" ")
        if kind in _USED:
            yield _USED[kind], name


__all__ = ["build", "fingerprint", "version"]
