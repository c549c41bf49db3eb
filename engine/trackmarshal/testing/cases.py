"""Inline tests to cases: what is given and what is expected, in SI; everything wrong is reported."""

from __future__ import annotations

import math
from typing import Any

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import RuleInfo, remembers
from trackmarshal.node import Node
from trackmarshal.semantics.causes import told_once
from trackmarshal.semantics.compile import Compiled
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import span_of
from trackmarshal.testing.errors import BadGiven, UnknownRuleOfTest
from trackmarshal.testing.expected import Expected, variables_of
from trackmarshal.testing.given import Given
from trackmarshal.testing.meant import Meant, Told


class PreparedTest(Node):
    """A test ready to run: the rule, the case as plain data, and what is expected in SI.

    later: of a test that goes on `after` its first cycle, the others: seconds since the first one, and all signals.
    """

    rule: RuleInfo
    title: str
    #: In SI whatever the declared units are: for an evaluator of `spec_in_si`.
    case: dict[str, Any]
    later: tuple[tuple[float, dict[str, Any]], ...]
    verdict: str
    margin: float | None
    tolerance: float
    #: Where the comparisons of a rule are in several units: the one in which the margin is expected; None for any.
    unit: str | None
    binder: str | None
    at: str | None
    #: Its text, and what that comes to.
    told: Told
    span: Span


def prepare(compiled: Compiled) -> tuple[list[PreparedTest], list[Diagnostic]]:
    """All tests that have a meaning, and what is wrong with the others."""
    prepared: list[PreparedTest] = []
    found = compiled.expressions.found
    before = len(found)
    titles: dict[tuple[str, str], Span] = {}
    for module in compiled.order:
        for item in compiled.library.modules[module].tree.items:
            if not isinstance(item, ast.Test):
                continue
            if (item.rule, item.title) in titles:
                first, hint = titles[item.rule, item.title], "say what this one shows"
                problem = "another test of this rule has the same title"
                found.append(BadGiven(item.span.head, problem, hint, first, "the first one is here"))
            titles.setdefault((item.rule, item.title), item.span.head)
            rule = compiled.spec.rule(item.rule)
            if rule is not None and rule.formula is None:
                found.append(UnknownRuleOfTest(item.span.head.word(item.rule), item.rule))
            try:
                test = _prepared(compiled, module, item, rule)
            except Poison:
                continue
            if test is not None:
                prepared.append(test)
    reported, found[before:] = found[before:], []
    return prepared, told_once(reported, compiled.found)


def _prepared(compiled: Compiled, module: str, item: ast.Test, rule: RuleInfo | None) -> PreparedTest | None:
    """The test; None for one of a rule that has errors of its own, or no formula: what it gives is checked all the same."""
    meant = Meant()
    reading = compiled, module, compiled.expressions.found, meant
    giving, expected = Given(*reading), Expected(*reading)
    case: dict[str, Any] = {"id": item.title, "signals": {}, "params": {}, "tables": {}, "places": {}}
    given: set[str] = set()
    later: list[tuple[float, dict[str, Any]]] = []

    def give(entry: ast.Given | ast.After) -> None:
        if isinstance(entry, ast.After):
            given.clear()
            t, before = later[-1] if later else (0.0, case["signals"])
            later.append((t + _after(giving, entry, rule), dict(before)))
            return
        if entry.name in given:
            giving.fail(entry.span, f"`{entry.name}` is given twice", "keep one of them")
        given.add(entry.name)
        if not later:
            giving.give(entry, case)
            return
        now: dict[str, Any] = {"signals": later[-1][1], "params": {}, "tables": {}, "places": {}}
        giving.give(entry, now)
        if now["params"] or now["tables"] or now["places"]:
            problem = f"`{entry.name}` stays as it is over a run"
            giving.fail(entry.span, problem, "give it before the first `after`")

    _, expect = compiled.expressions.all(
        lambda: compiled.expressions.each(give, item.steps), lambda: expected.of(item.expect, rule)
    )
    if rule is None or rule.formula is None:
        return None
    told = Told(item, meant, variables_of(rule.formula), expect.unit)
    return PreparedTest(
        rule, item.title, case, tuple(later), expect.verdict, expect.margin, expect.tolerance, expect.unit, expect.binder, expect.at,
        told, item.span.head,
    )  # fmt: skip


def _after(giving: Given, entry: ast.After, rule: RuleInfo | None) -> float:
    """How long after the cycle before the next one comes [s]."""
    if rule is not None and not remembers(rule):
        giving.fail(entry.span, f"`{rule.name}` speaks of one cycle alone", "a test for each cycle")
    seconds = giving.number(entry.time, "s", "the time of the next cycle")
    if not (math.isfinite(seconds) and nanoseconds(seconds) > 0):
        giving.fail(span_of(entry.time), "the next cycle comes later", "write a time above 0 s")
    return seconds
