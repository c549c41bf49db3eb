"""What `test` found, for machines: JSON, annotations beside the changed lines, and a report of tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from trackmarshal.cli.output import dump
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.junit.writing import Line
    from trackmarshal.testing.run import Coverage, Outcome

Where = Callable[[str], str] | None


def as_json(
    outcomes: Sequence[Outcome],
    covered: Sequence[Coverage],
    found: Sequence[Diagnostic | TrackmarshalError],
    where: Where,
) -> str:
    """One line of strict JSON."""
    from trackmarshal.diagnostics.json import records

    called = where or str
    return dump({
        "tests": [{"rule": o.test.rule.name, "title": o.test.title, "outcome": o.outcome, "message": o.message,
                   "file": called(o.test.span.file.path), "line": o.test.span.line} for o in outcomes],
        "coverage": [{"rule": c.rule.name, "tests": c.tests, "satisfied": c.satisfied, "violated": c.violated, "boundary": c.boundary,
                      "lacking": [side for side, _ in c.lacking]} for c in covered],
        "findings": records(found, where),
    })  # fmt: skip


def as_github(
    outcomes: Sequence[Outcome],
    covered: Sequence[Coverage],
    found: Sequence[Diagnostic | TrackmarshalError],
    where: Where,
) -> str:
    """A workflow command for each test that did not pass, each rule whose boundary is not covered, and each finding."""
    from trackmarshal.diagnostics.github import render

    bad = [
        TrackmarshalError(
            "T215", f"{o.test.rule.name}: {o.test.title}: {o.message}", file=o.test.span.file.path, line=o.test.span.line
        )
        for o in outcomes
        if o.outcome != "passed"
    ]  # fmt: skip
    partial = [
        TrackmarshalError("T212", lacks(c), file=c.rule.span.file.path, line=c.rule.span.line)
        for c in covered
        if not c.complete
    ]
    return render([*found, *bad, *partial], where)


def as_junit(
    outcomes: Sequence[Outcome],
    covered: Sequence[Coverage],
    found: Sequence[Diagnostic | TrackmarshalError],
    where: Where,
) -> str:
    """A suite for each file with a test for each inline test; `coverage` with one for each rule; `findings` for what else there is."""
    from trackmarshal.junit.writing import render

    return render("trackmarshal test", _lines(outcomes, covered, found, where or str))


def _lines(
    outcomes: Sequence[Outcome],
    covered: Sequence[Coverage],
    found: Sequence[Diagnostic | TrackmarshalError],
    called: Callable[[str], str],
) -> Iterator[Line]:
    from trackmarshal.junit.writing import Line

    for outcome in outcomes:
        rule, span = outcome.test.rule, outcome.test.span
        file = called(span.file.path)
        ids = tuple(dict.fromkeys(name for name, _ in rule.satisfies))
        yield Line(
            file,
            rule.name,
            outcome.test.title,
            outcome.outcome,
            outcome.message,
            "T215",
            file,
            span.line,
            ids,
        )
    for c in covered:
        file, line = called(c.rule.span.file.path), c.rule.span.line
        outcome_, said = ("passed", "") if c.complete else ("failed", lacks(c))
        yield Line(
            "coverage",
            c.rule.name,
            "tests inside, outside and on its boundary",
            outcome_,
            said,
            "T212",
            file,
            line,
        )
    for item in found:
        if isinstance(item, TrackmarshalError):
            file, line = called(item.file or ""), item.line or 0
        else:
            file, line = called(item.span.file.path), item.span.line
        yield Line("findings", item.code, item.message, "failed", item.message, item.code, file, line)


def lacks(c: Coverage) -> str:
    """What tests of a rule do not cover, in a sentence."""
    called = {"satisfied": "inside", "violated": "outside", "boundary": "on"}
    sides = [called[side] for side, _ in c.lacking]
    many = any(number > 1 for _, number in c.lacking)
    few, more = ("fewer tests than `tests_per_rule` asks for", "and") if many else ("no test", "and none")
    said = f"`{c.rule.name}` has {few} {f' {more} '.join(sides)} {'of ' if sides[-1] != 'on' else ''}its boundary"
    return "; ".join([said, *c.beside])
