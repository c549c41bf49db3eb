"""The traceability matrix: a pure function of the documents, the engine's records, the hashes of files, and the day."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date

from trackmarshal.trace import baseline as baselines
from trackmarshal.trace import (
    causes,
    consistency,
    cycles,
    faults,
    files,
    gates,
    links,
    outside,
    runs,
    tests,
    vacuous,
    waivers,
)
from trackmarshal.trace.cells import STATUSES, Cell, Ground, cell
from trackmarshal.trace.files import Hashes
from trackmarshal.trace.findings import Finding, in_order
from trackmarshal.trace.graph import (
    checks,
    conditions,
    integrity,
    intervals,
    methods,
    people,
    schema,
    tools,
    works,
)
from trackmarshal.trace.graph.building import build
from trackmarshal.trace.graph.graph import Graph, Key
from trackmarshal.trace.graph.reviewed import unreviewed
from trackmarshal.trace.model import Demand, Project, Requirement, Stage, Waiver, matches
from trackmarshal.trace.outside import Outside
from trackmarshal.trace.spec import Spec
from trackmarshal.trace.verdict import verdict

#: Findings that mean that a document could not be used as it is: reading, YAML, which document it is.
UNUSABLE = frozenset(f"T1{number:02}" for number in range(1, 14))
#: Codes before this one are of reading specs and documents.
_READ = "T130"


@dataclass(frozen=True, slots=True)
class Row:
    """A requirement and its cells by stage; stages that do not ask anything of it have none."""

    requirement: Requirement
    depth: int  #: how many requirements above it, along its first parents
    cells: Mapping[str, Cell]


@dataclass(frozen=True, slots=True)
class Matrix:
    """Requirements against stages, with all that was found on the way."""

    project: str
    today: date
    stages: tuple[Stage, ...]
    rows: tuple[Row, ...]
    graph: Graph
    waivers: tuple[Waiver, ...]
    findings: tuple[Finding, ...]
    counts: Mapping[str, int]  #: how many rules, assumptions, tests, results and runs went in
    demands: tuple[Demand, ...] = ()  #: what the gate demands of cells
    accepted: tuple[baselines.Acceptance, ...] = ()  #: of what became weaker, the last one last
    unreviewed: tuple[Key, ...] = ()  #: what is to be reviewed, and no person has reviewed as it is now
    #: By finding that follows from another one, that one; those that stand for themselves are not in it.
    causes: Mapping[Finding, Finding] = field(default_factory=dict)
    baseline: baselines.Baseline | None = None  #: that was accepted last
    content: baselines.Content = field(
        default_factory=dict
    )  #: what a baseline would hold that is accepted now
    #: By the identity of a cause what follows from it, once that was asked.
    _following: dict[int, list[Finding]] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def passes(self) -> bool:
        """Whether no finding is an error, so that the gate is open."""
        return not any(finding.level == "error" for finding in self.findings)

    @property
    def verdict(self) -> str:
        """The one verdict that every report prints: a word of `trackmarshal.trace.verdict`."""
        errors = sum(finding.level == "error" for finding in self.findings)
        return verdict(errors, self.reservations)

    @property
    def reservations(self) -> tuple[str, ...]:
        """What keeps a matrix without errors from a pass as such, each as a few words."""
        statuses = [cell.status for row in self.rows for cell in row.cells.values()]
        waived = statuses.count("waived")
        rest = len(statuses) - waived - statuses.count("covered")
        warnings = sum(finding.level == "warning" for finding in self.findings)
        excused = sum(finding.excused for finding in self.findings)
        said = (
            (waived, "{} cell is waived", "{} cells are waived"),
            (rest, "{} cell is not covered", "{} cells are not covered"),
            (excused, "{} finding is waived", "{} findings are waived"),
            (len(self.unreviewed), "nobody has reviewed {} thing", "nobody has reviewed {} things"),
            (warnings, "{} warning should be looked at", "{} warnings should be looked at"),
        )
        return tuple((one if n == 1 else more).format(n) for n, one, more in said if n)

    @property
    def standing(self) -> tuple[Finding, ...]:
        """The findings that stand for themselves: causes, and notes."""
        return tuple(finding for finding in self.findings if finding not in self.causes)

    def following(self, finding: Finding) -> tuple[Finding, ...]:
        """What follows from a finding, in order."""
        if self.causes and not self._following:
            for other in self.findings:
                cause = self.causes.get(other)
                if cause is not None:
                    self._following.setdefault(id(cause), []).append(other)
        return tuple(self._following.get(id(finding), ()))

    @property
    def unusable(self) -> bool:
        """Whether a document could not be read, so that the matrix lacks what it says."""
        return any(finding.code in UNUSABLE for finding in self.findings)

    @property
    def misread(self) -> tuple[Finding, ...]:
        """What is wrong with reading specs and documents: what could not be read is missing in the graph, and in all that is made of it."""
        return tuple(finding for finding in self.findings if finding.code < _READ)

    @property
    def coverage(self) -> dict[str, dict[str, int]]:
        """Per stage: how many requirements it asks of (`of`), and how many cells have each status."""
        table: dict[str, dict[str, int]] = {}
        for stage in self.stages:
            statuses = [row.cells[stage.id].status for row in self.rows if stage.id in row.cells]
            order = ("covered", *(s for s in reversed(STATUSES) if s != "covered"))
            count = {status: statuses.count(status) for status in order}
            table[str(stage.id)] = {"covered": count.pop("covered"), "of": len(statuses), **count}
        return table


def assemble(
    project: Project,
    spec: Spec,
    hashes: Hashes,
    baseline: baselines.Baseline | None,
    *,
    today: date,
    found: Iterable[Finding] = (),
    around: Outside | None = None,
    tell: baselines.Tell | None = None,
) -> Matrix:
    """The matrix; `found` is what reading the inputs brought to light, `around` what is known from outside of specs.

    tell: whether rules that are not those of the baseline got weaker, or stronger.
    """
    around = around or Outside()
    excuses = gates.Waivers(project, today)
    graph = build(project, spec, hashes, around)
    asking = schema.Asking(graph, project)
    cells = _cells(Ground(project, spec, hashes, graph, around), excuses)
    content = baselines.content(project, spec, hashes, graph, around)
    there = baselines.reported(project, around)
    content = baselines.carried({} if baseline is None else baseline.content, content, there)
    loose = [
        *consistency.check(project),
        *consistency.unasked(project, cells),
        *consistency.recordings(project, hashes),
        *checks.check(graph),
        *schema.check(graph, project, asking),
        *methods.check(graph, project, asking, around),
        *integrity.check(graph),
        *people.check(graph, project, today),
        *works.check(graph),
        *tools.check(graph),
        *conditions.check(graph, project, spec),
        *intervals.check(graph, spec),
        *vacuous.check(project, spec),
        *links.check(project, spec),
        *tests.check(project, spec),
        *baselines.check(baseline, content, project, spec, tell),
        *runs.check(project, spec, hashes),
        *faults.check(project, spec, hashes),
        *files.check(project, spec, hashes),
        *outside.check(project, spec, around),
        *waivers.check(project, spec),
    ]
    judged = [excuses.finding(finding) for finding in loose]
    findings = in_order([*found, *judged, *gates.check(project, cells), *excuses.check(cells)])
    rows = tuple(
        Row(requirement, depth, cells[requirement.id]) for requirement, depth in _in_order(project, graph)
    )
    counts = {
        "requirements": len(rows),
        "rules": sum(item.kind == "rule" for item in spec.items),
        "assumptions": sum(item.kind == "assume" for item in spec.items),
        "tests": len(spec.tests),
        "test_results": len(spec.results),
        "runs": len(spec.runs),
        "faults": sum(not case.open for case in spec.faults),
    }
    if project.junit:
        counts["external_tests"] = len(around.tests)
    if project.sources:
        counts["code_links"] = len(around.markers)
    return Matrix(
        project.name,
        today,
        project.stages,
        rows,
        graph,
        project.waivers,
        findings,
        counts,
        gates.demands(project),
        tuple(one for one in baseline.acceptances if one.weaker) if baseline else (),
        unreviewed(graph, schema.of(project).reviewed or ()),
        causes.causes(findings, graph, [(d.stage.place, f"{d.stage}, {d.at_least}") for d in project.gate]),
        baseline,
        content,
    )


def _in_order(project: Project, graph: Graph) -> list[tuple[Requirement, int]]:
    """Requirements in the order of files and lines, each followed by those that refine it (first parent counts)."""
    demanded = sorted((r for r in project.by_id.values() if r.demanded), key=lambda r: r.place)
    below: dict[str, list[Requirement]] = defaultdict(list)
    tops: list[Requirement] = []
    for requirement in demanded:
        links = graph.out_of(("requirement", str(requirement.id)))
        parent = next((k.target[1] for k in links if k.kind == "refines" and k.state == "covers"), None)
        (tops if parent is None else below[parent]).append(requirement)
    order: dict[str, int] = {}
    for top in [*tops, *demanded]:  # the second time round: members of cycles, which no top leads to
        stack = [(top, 0)]
        while stack:
            requirement, depth = stack.pop()
            if requirement.id not in order:
                order[str(requirement.id)] = depth
                stack += [(child, depth + 1) for child in reversed(below[requirement.id])]
    return [(project.by_id[name], depth) for name, depth in order.items()]


def _cells(ground: Ground, excuses: gates.Waivers) -> dict[str, dict[str, Cell]]:
    """The cells of every demanded requirement, those below first: what is open there shows above."""
    project = ground.project
    demanded = [str(r.id) for r in project.by_id.values() if r.demanded]
    parents = {
        name: [k.target[1] for k in ground.out_of(("requirement", name), "refines")] for name in demanded
    }
    asked = {str(s.id): {n for n in parents if matches(n, s.applies_to)} for s in project.stages}
    children = {name: ground.children(name) for name in parents}
    cells: dict[str, dict[str, Cell]] = {name: {} for name in parents}
    for name in cycles.children_first(parents):
        requirement = project.by_id[name]
        for stage in project.stages:
            if name in asked[stage.id]:
                made = cell(ground, requirement, stage, _below(name, str(stage.id), children, cells))
                if made is not None:
                    cells[name][str(stage.id)] = excuses.cell(made, requirement, stage)
    return cells


def _below(
    name: str, stage: str, children: Mapping[str, Sequence[str]], cells: Mapping[str, Mapping[str, Cell]]
) -> dict[str, Cell]:
    """The nearest cells of a stage below a requirement: what it asks nothing of hides nothing that is further down."""
    found: dict[str, Cell] = {}
    seen, todo = {name}, [*reversed(children[name])]
    while todo:
        child = todo.pop()
        if child in seen:
            continue
        seen.add(child)
        if stage in cells[child]:
            found[child] = cells[child][stage]
        else:
            todo += reversed(children[child])
    return found
