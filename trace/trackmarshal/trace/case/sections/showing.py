"""What shows it: coverage of the stages, methods, tests, scenarios, faults, drives of real vehicles, runs in the closed loop, tests of other runners."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.records.runs import RunSummary
from trackmarshal.trace.case.model import Block, Code, Fixed, Given, Line, Made, Number, Part, Section, Status
from trackmarshal.trace.case.sections import driven, injected, looped
from trackmarshal.trace.case.writing import EMPTY, Writing, given, joined, written
from trackmarshal.trace.cells import STATUSES
from trackmarshal.trace.graph.graph import Node
from trackmarshal.trace.model import Scenario
from trackmarshal.units import moment


def verification(writing: Writing) -> Section:
    """Figures first, then what they count."""
    methods = writing.of_kind("method")
    return writing.section("verification", [
        writing.named("verification.stages", [_coverage(writing)]),
        *([writing.named("verification.methods", [_methods(writing, methods)])] if methods else []),
        writing.named("verification.tests", [_tests(writing)]),
        writing.named("verification.scenarios", list(_scenarios(writing))),
        writing.named("verification.field", list(driven.field(writing))),
        writing.named("verification.faults", list(injected.faults(writing))),
        writing.named("verification.loop", list(looped.closed_loop(writing))),
        writing.named("verification.others", list(_others(writing))),
    ])  # fmt: skip


def _coverage(writing: Writing) -> Block:
    """How many requirements each stage asks of, and how many cells have each status."""
    order = ("covered", *(status for status in reversed(STATUSES) if status != "covered"))
    columns = [("column.stage", 3.0), ("column.of", 1.0), *((f"status.{status}", 1.0) for status in order)]
    rows: list[list[Line]] = []
    for stage in writing.given.matrix.stages:
        id_ = str(stage.id)
        counted: list[Line] = [(writing.number("stages", id_, status),) for status in order]
        rows.append(
            [
                (writing.ref(("stage", id_)), Fixed(" "), Given(stage.title)),
                (writing.number("stages", id_),),
                *counted,
            ]
        )
    return writing.table(columns, rows)


def _methods(writing: Writing, methods: Sequence[Node]) -> Block:
    """How it is verified: what each method is, from which integrity level on a standard asks for it, and the requirements that it shows something about."""
    columns = (
        ("column.id", 1.0),
        ("column.title", 2.5),
        ("column.done", 3.5),
        ("column.asked_from", 1.2),
        ("column.from_where", 2.0),
        ("column.requirements", 2.0),
    )
    return writing.table(columns, (
        [
            (writing.ref(node.key),), given(node.title), written(node.attributes.get("description", ""), node.place),
            given(node.attributes.get("highly_recommended_from", "")), written(node.attributes.get("source", "")), writing.refs(n.key for n in writing.before(node.key, "verified_by")),
        ]
        for node in methods
    ), [node.key for node in methods])  # fmt: skip


def _tests(writing: Writing) -> Block:
    outcomes = ("passed", "failed", "error", "stale", "not run")
    return writing.facts([
        ("label.tests", (writing.number("nodes", "test"),)),
        *((f"label.tests_{outcome.replace(' ', '_')}", (writing.number("nodes", "test", outcome),)) for outcome in outcomes),
        ("label.rules_number", (writing.number("nodes", "rule"),)),
        ("label.assumptions_number", (writing.number("nodes", "assumption"),)),
    ])  # fmt: skip


def _scenarios(writing: Writing) -> Iterator[Block]:
    """Each recording with what its replay showed."""
    scenarios, runs = writing.given.project.scenarios, {run.scenario: run for run in writing.given.runs}
    if not scenarios:
        yield writing.missing("verification.no_scenarios")
    for one in scenarios:
        yield _scenario(writing, one, runs.get(str(one.path)))


def _scenario(writing: Writing, one: Scenario, run: RunSummary | None) -> Part:
    key = ("scenario", str(one.path))
    node = writing.graph.nodes.get(("run", str(one.path)))
    facts: list[tuple[str, Line]] = [
        ("label.stage", given(str(one.stage))),
        *(
            (("label.expect", writing.line(f"expect.{one.expect}")),) if one.expect else ()
        ),  # else it was reported where it stands
        ("label.origin", given(one.origin)),
    ]
    if run is None or node is None:
        return writing.part(
            (Given(one.title or str(one.path)),),
            [writing.facts(facts), writing.missing("verification.not_run")],
            key,
            level=3,
        )
    facts += [
        ("label.outcome", (driven.came_to(writing, node),)),
        ("label.cycles", (writing.said_number(node, "cycles"),)),
        ("label.fired", writing.line(f"fired.{node.attributes['fired']}")),
        ("label.evaluated", writing.refs(n.key for n in writing.beyond(node.key, "evaluates"))),
        ("label.truth", _truth(writing, one, run)),
        ("label.recording", (Code(run.source_hash),)),
    ]
    return writing.part(
        (Given(one.title or str(one.path)), Fixed(" "), Code(str(one.path))),
        [writing.facts(facts)],
        key,
        level=3,
    )


def _truth(writing: Writing, one: Scenario, run: RunSummary) -> Line:
    """By each ground truth, whether all verdicts lie within it, and where they do not; then what none of them judges."""
    lines: list[Line] = []
    for kind, truth in run.ground_truth.items():
        state = Status(
            "covered" if truth.inside else "failed",
            writing.words["truth.inside" if truth.inside else "truth.outside"],
        )
        said = joined([(Made(one),) for one in truth.violations], "; ")
        lines.append((Made(kind), Fixed(" "), state, *((Fixed(": "), *said) if said else EMPTY)))
    if one.expect == "ground_truth" and run.unexpected:
        first = Number(f"unexpected/{run.scenario}", moment(run.unexpected[0]))
        lines.append((Status("failed"), Fixed(": "), *writing.line("truth.unexpected", first=first)))
    if run.uncovered:
        rules = joined([(Code(rule),) for rule in run.uncovered])
        lines.append(writing.line("truth.uncovered", rules=rules))
    return joined(lines) or writing.line("truth.none")


#: Of reports of other runners that were not read, as they are not there, hold no test, or are none, or as nothing can be looked for in their names.
_UNREAD = frozenset({"T330", "T331", "T332", "T333", "T334", "T335", "T340", "T290"})


def _others(writing: Writing) -> Iterator[Block]:
    """Tests of other runners that name a requirement. Of a report that was not read, nobody knows whether there are any."""
    told = {str(f.subject) for f in writing.given.matrix.findings if f.code in _UNREAD}
    unread = [
        given(path)
        for path in dict.fromkeys(str(report.path) for report in writing.given.project.junit)
        if path in told
    ]
    if unread:
        yield writing.missing("verification.others_unread", reports=joined(unread))
    nodes = writing.of_kind("external test")
    if not nodes:
        if not unread:
            yield writing.missing("verification.no_others")
        return
    columns = (
        ("column.test", 5.0),
        ("column.tool", 1.2),
        ("column.requirements", 2.0),
        ("column.outcome", 1.4),
    )
    yield writing.table(columns, (
        [
            (Code(node.id),), given(node.attributes.get("tool", "")), writing.refs(n.key for n in writing.beyond(node.key, "confirms")),
            (Status(node.attributes["outcome"]), *((Fixed(": "), Made(node.title)) if node.title else EMPTY)),
        ]
        for node in nodes
    ))  # fmt: skip


__all__ = ["verification"]
