"""A cell of the matrix: how far one requirement is covered at one stage, and by what."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from trackmarshal.records.specs import SpecItem
from trackmarshal.trace import design, external, faults
from trackmarshal.trace.files import Hashes, demanding
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph.graph import Graph, Key, Link
from trackmarshal.trace.model import Project, Requirement, Stage, matches
from trackmarshal.trace.outside import Outside
from trackmarshal.trace.runs import Showing, as_a_whole, showing
from trackmarshal.trace.spec import Spec, item_place

#: From worst to best; `waived` stands where a gap is answered for.
STATUSES = ("failed", "stale", "missing", "partial", "waived", "covered")
#: Kinds of items that come up from the requirements below.
FROM_BELOW = frozenset(
    {"rule", "monitor", "assumption", "test", "run", "fault", "external test", "code", "design", "analysis"}
)


@dataclass(frozen=True, slots=True)
class Item:
    """One thing that counts in a cell, or ought to."""

    kind: str  #: interface, requirement, adoption, document, rule, monitor, assumption, test, run, fault, external test, code, design element, analysis or waiver
    name: str
    title: str
    status: str
    detail: str = ""
    place: Place | None = None


@dataclass(frozen=True, slots=True)
class Cell:
    """The coverage of a requirement at a stage."""

    status: str
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True)
class Ground:
    """Everything that cells are made from."""

    project: Project
    spec: Spec
    hashes: Hashes
    graph: Graph
    outside: Outside

    def out_of(self, key: Key, kind: str) -> list[Link]:
        """The links of a kind that stand at a node; those of a second declaration of it do not count."""
        return [k for k in self.graph.out_of(key) if k.kind == kind and k.state != "ambiguous"]

    def into(self, key: Key, kind: str) -> list[Link]:
        """The links of a kind that lead to a node and hold, one from each other node that is demanded."""
        found: dict[Key, Link] = {}
        for link in self.graph.into(key):
            if link.kind == kind and link.state == "covers" and self.graph.nodes[link.source].demanded:
                found.setdefault(link.source, link)
        return list(found.values())

    def satisfying(self, requirement: str) -> list[SpecItem]:
        """The rules and assumptions that satisfy a requirement."""
        return [self.spec.by_name[k.source[1]] for k in self.into(("requirement", requirement), "satisfies")]

    def evaluated(self, requirement: str) -> list[SpecItem]:
        """Its rules, and its assumptions that are monitored."""
        return [item for item in self.satisfying(requirement) if item.kind == "rule" or item.monitored]

    def children(self, requirement: str) -> list[str]:
        """The requirements that refine one."""
        return [link.source[1] for link in self.into(("requirement", requirement), "refines")]


def combined(statuses: Iterable[str]) -> str | None:
    """One status for several things that are all needed; None for nothing."""
    present = set(statuses)
    unknown = present.difference(STATUSES)
    if unknown:
        raise ValueError(f"unknown status {sorted(unknown)}")
    if not present:
        return None
    for status in ("failed", "stale"):
        if status in present:
            return status
    if present <= {"covered", "waived"}:
        return "waived" if "waived" in present else "covered"
    return "missing" if present == {"missing"} else "partial"


def cell(ground: Ground, requirement: Requirement, stage: Stage, below: Mapping[str, Cell]) -> Cell | None:
    """The cell before waivers; None where the stage does not ask. `below`: this stage's cells of children."""
    items: list[Item] = []
    statuses: list[str] = []
    for kind in stage.counts:
        status, found = _KINDS[kind](ground, requirement, stage)
        items += found
        if status is not None:
            statuses.append(status)
    if not FROM_BELOW.isdisjoint(stage.counts):
        for name, own in below.items():
            child = ground.project.by_id[name]
            lacking = (i.detail for i in own.items if i.status != "covered" and i.detail)
            detail = "" if own.status == "covered" else next(lacking, "")
            items.append(Item("requirement", name, child.title, own.status, detail, child.place))
            statuses.append(own.status)
    status = combined(statuses)
    if status is None:
        return None if stage.if_any else Cell("missing", ())
    return Cell(status, tuple(items))


def item_kind(item: SpecItem) -> str:
    """What is evaluated: a rule, or the monitor of an assumption."""
    return "rule" if item.kind == "rule" else "monitor"


Proof = tuple[str | None, list[Item]]


def _together(items: list[Item]) -> Proof:
    return combined(item.status for item in items), items


def _interface(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    items = []
    key, nodes = ("requirement", str(requirement.id)), ground.graph.nodes
    issues = [nodes[link.source] for link in ground.into(key, "leads_to")]
    for link in ground.out_of(key, "derived_from"):
        name = link.target[1]
        interface = nodes.get(link.target)
        if interface is None:
            items.append(Item("interface", name, "", "missing", "no such interface", link.place))
            continue
        answered = [issue.title for issue in issues if issue.attributes["interface"] == name]
        if answered:
            items.append(
                Item("interface", name, interface.title, "covered", " ".join(answered), interface.place)
            )
        else:
            analysed = ground.into(link.target, "found_at")
            detail = "no issue of it leads here" if analysed else "not analysed"
            items.append(Item("interface", name, interface.title, "missing", detail, interface.place))
    return _together(items)


def _parent(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    items = []
    for link in ground.out_of(("requirement", str(requirement.id)), "refines"):
        above, name = ground.graph.nodes.get(link.target), link.target[1]
        if above is None or not above.demanded:
            detail = "no such requirement" if above is None else "demanded no longer"
            items.append(Item("requirement", name, "", "missing", detail, link.place))
        else:
            items.append(Item("requirement", name, above.title, "covered", "refines it", above.place))
    return _together(items)


def _adoption(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    if not requirement.adopted:
        return None, []
    return _together(
        [Item("adoption", requirement.source, "", "covered", requirement.adopted, requirement.place)]
    )


def _document(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    items = []
    for entry in ground.project.evidence:
        if entry.stage == stage.id and matches(requirement.id, entry.requirements):
            actual = ground.hashes.get(entry.path)
            if not actual:
                status, detail = "missing", "not there" if actual is None else "says nothing"
            elif demanding(entry.path) in ground.hashes:
                status, detail = "missing", "says what is demanded"
            elif entry.sha256 and actual != entry.sha256:
                status, detail = "stale", "changed since it was reviewed"
            elif (str(entry.path), str(requirement.id)) in ground.outside.denials:
                status, detail = "partial", "says that there is none"
            else:
                status, detail = "covered", ""
            items.append(Item("document", entry.path, entry.title, status, detail, Place(entry.path)))
    return _together(items)


def _rule(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    def judge(item: SpecItem) -> tuple[str, str]:
        return "covered", "; ".join(filter(None, (item.source, _beside(ground, item))))

    return _linked(ground, requirement, "rule", "metrics", judge)


def _monitor(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    def judge(item: SpecItem) -> tuple[str, str]:
        if not item.monitored:
            return "missing", "has no monitor"
        return "covered", _beside(ground, item) or "watched while driving"

    return _linked(ground, requirement, "monitor", "assumptions", judge)


def _beside(ground: Ground, item: SpecItem) -> str:
    """That a rule is none of those that everything is evaluated with, as runs of scenarios without specs of their own tell; empty where it is one, or no such run is there."""
    plain = [
        run
        for scenario in ground.project.scenarios
        if not scenario.specs and (run := ground.spec.runs.get(str(scenario.path)))
    ]
    if not plain or any(item.name in ground.spec.facts(run) for run in plain):
        return ""
    return f"not in {ground.project.default_spec}: evaluated where its spec is loaded beside that"


def _assumption(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    def judge(item: SpecItem) -> tuple[str, str]:
        lacks = [
            f"no {name}" for name, there in (("owner", item.owner), ("monitor", item.monitored)) if not there
        ]
        if not item.evidence:
            lacks.append("no evidence")
        elif not ground.hashes.get(item.evidence):
            there = ground.hashes.get(item.evidence) is not None
            lacks.append(f"`{item.evidence}` {'says nothing' if there else 'is not there'}")
        elif demanding(item.evidence) in ground.hashes:
            lacks.append(f"`{item.evidence}` says what is demanded")
        elif (item.evidence, item.name) in ground.outside.denials:
            lacks.append(f"`{item.evidence}` says that there is no evidence")
        return ("partial", ", ".join(lacks)) if lacks else ("covered", f"{item.owner}; {item.evidence}")

    return _linked(ground, requirement, "assumption", "assumptions", judge)


def _linked(
    ground: Ground,
    requirement: Requirement,
    kind: str,
    wanted: str,
    judge: Callable[[SpecItem], tuple[str, str]],
) -> Proof:
    """Rules (or assumptions) that satisfy a requirement, and those that it names, by links of the kind `wanted`, and that don't."""
    items = []
    key, of_kind = ("requirement", str(requirement.id)), "rule" if kind == "rule" else "assumption"
    linked = [item for item in ground.satisfying(requirement.id) if (item.kind == "rule") == (kind == "rule")]
    for item in linked:
        status, detail = judge(item)
        items.append(Item(kind, item.name, item.title, status, detail, item_place(item)))
    there = {item.name for item in linked}
    for link in ground.out_of(key, wanted):
        if link.target[1] not in there:
            detail = f"no {of_kind} of this name satisfies it"
            items.append(Item(kind, link.target[1], "", "missing", detail, link.place))
    return _together(items)


def _test(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    spec, items = ground.spec, []
    for rule in ground.evaluated(requirement.id):
        key = ("rule" if rule.kind == "rule" else "assumption", rule.name)
        tests = [link for link in ground.graph.into(key) if link.kind == "tests"]
        if not tests:
            items.append(
                Item(item_kind(rule), rule.name, rule.title, "missing", "has no test", item_place(rule))
            )
        for test in tests:
            title = ground.graph.nodes[test.source].title
            result = spec.results.get((rule.name, title))
            stale = "" if result is None else spec.staleness(result)
            if result is None:
                status, detail = "missing", "not run"
            elif stale:
                status, detail = "stale", stale
            elif result.outcome == "passed":
                status, detail = "covered", "passed"
            else:
                status, detail = (
                    "failed",
                    f"{result.outcome}: {result.message}" if result.message else result.outcome,
                )
            items.append(Item("test", rule.name, title, status, detail, test.place))
    return _together(items)


def _run(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    rules = ground.evaluated(requirement.id)
    if not rules:
        return _whole_run(ground, requirement, stage)
    items: list[Item] = []
    seen: list[Showing] = []
    for scenario in ground.project.scenarios:
        if scenario.stage == stage.id and matches(requirement.id, scenario.requirements):
            shows = showing(scenario, rules, ground.spec, ground.hashes)
            seen.append(shows)
            items.append(
                Item("run", scenario.path, scenario.title, shows.status, shows.detail, Place(scenario.path))
            )
    if not seen:
        return None, []
    evaluated = {name for shows in seen for name in shows.evaluated}
    unjudged = {name for shows in seen for name in shows.unjudged}
    for rule in rules:
        if evaluated and rule.name not in evaluated:
            items.append(
                Item(
                    item_kind(rule),
                    rule.name,
                    rule.title,
                    "missing",
                    "judged by a ground truth in none of these runs"
                    if rule.name in unjudged
                    else "satisfied or violated in none of these runs",
                    item_place(rule),
                )
            )
    return _over_runs(seen, {rule.name for rule in rules}, evaluated), items


def _whole_run(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    """Runs for a requirement that no rule evaluates: of scenarios that name it, each as a whole. They add to each other.

    One that some stage asks rules of lacks them: runs of other rules stand in for nothing.
    """
    stages = ground.project.stages
    if any("rule" in asks.counts and matches(requirement.id, asks.applies_to) for asks in stages):
        return None, []
    items = []
    for scenario in ground.project.scenarios:
        named = [pattern for pattern in scenario.requirements if pattern != "*"]
        if scenario.stage == stage.id and matches(requirement.id, named):
            shows = as_a_whole(scenario, ground.spec, ground.hashes)
            place = Place(scenario.path)
            items.append(Item("run", scenario.path, scenario.title, shows.status, shows.detail, place))
    found = {item.status for item in items}
    status = next((s for s in ("failed", "stale", "covered") if s in found), combined(found))
    return status, items


def _fault(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    items = []
    for case in ground.spec.faults_of.get(requirement.id, ()):
        status, detail = faults.verdict(case, ground.spec)
        items.append(Item("fault", case.id, case.title, status, detail, Place(case.campaign, case.line)))
    return _together(items)


def _external_test(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    items = []
    for found in ground.outside.tests_of.get(requirement.id, ()):
        if found.stage == stage.id:
            status, detail = external.verdict(found.test)
            items.append(
                Item("external test", found.test.name, found.test.suite, status, detail, found.place)
            )
    return _together(items)


def _code(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    markers = ground.outside.markers_of.get(requirement.id, ())
    return _together(
        [Item("code", m.place.file, "", "covered", "says it implements it", m.place) for m in markers]
    )


def _design(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    return _together([Item("design element", *said) for said in design.elements(ground, requirement.id)])


def _analysis(ground: Ground, requirement: Requirement, stage: Stage) -> Proof:
    return _together([Item("analysis", *said) for said in design.analyses(ground, requirement.id)])


def _over_runs(seen: Sequence[Showing], rules: set[str], evaluated: set[str]) -> str:
    """Runs add to each other: every rule has to be evaluated in one of them, and one of them has to be conclusive."""
    for status in ("failed", "stale"):
        if any(shows.status == status for shows in seen):
            return status
    if evaluated == rules and any(shows.status == "covered" for shows in seen):
        return "covered"
    return "partial" if evaluated else "missing"


_KINDS: dict[str, Callable[[Ground, Requirement, Stage], Proof]] = {
    "interface": _interface,
    "parent": _parent,
    "adoption": _adoption,
    "document": _document,
    "rule": _rule,
    "monitor": _monitor,
    "assumption": _assumption,
    "test": _test,
    "run": _run,
    "fault": _fault,
    "external test": _external_test,
    "code": _code,
    "design": _design,
    "analysis": _analysis,
}
