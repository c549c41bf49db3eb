"""Rules and assumptions: their clauses to one formula, and what they trace to."""

from __future__ import annotations

import hashlib
from typing import assert_never

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import QUANTIFIERS, known
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import RuleInfo, SignalType
from trackmarshal.semantics.advice import warnings
from trackmarshal.semantics.overrun import misused
from trackmarshal.semantics.errors import (
    AllowsNothing,
    Ambiguous,
    ClauseProblem,
    UnknownName,
    UnknownReference,
    UnusedVariable,
)  # fmt: skip
from trackmarshal.semantics.expressions import Context, Expressions
from trackmarshal.semantics.scope import Symbol
from trackmarshal.semantics.values import Broken, FormulaValue, Poison, SignalValue
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import TIME, parse_unit

SEVERITIES = ("minor", "major", "critical")


class RuleBuilder:
    """Turns one declaration into a RuleInfo; what is wrong goes to the expressions' diagnostics."""

    def __init__(self, expressions: Expressions, ctx: Context) -> None:
        self.x = expressions
        self.ctx = ctx

    def build(self, item: ast.Rule | ast.Assume, assumptions: set[str]) -> RuleInfo | None:
        """The rule; None where an error keeps it from having a meaning."""
        kind = "rule" if isinstance(item, ast.Rule) else "assume"
        before = len(self.x.found)
        self._placement(item, kind)
        text = {"source": "", "because": "", "severity": "major", "evidence": "", "owner": ""}
        satisfies: list[tuple[str, Span]] = []
        assuming: list[tuple[str, Span]] = []
        for clause in item.clauses:
            match clause:
                case ast.Satisfies():
                    satisfies += [(name.name, name.span) for name in clause.ids]
                case ast.Assuming():
                    assuming += [(name.name, name.span) for name in clause.ids]
                case ast.SourceClause():
                    text["source"] = self._source(clause)
                case ast.Because():
                    text["because"] = clause.text
                case ast.Severity():
                    text["severity"] = clause.word
                    if clause.word not in SEVERITIES:
                        hint = (
                            close_matches(clause.word, SEVERITIES)
                            or f"write {', '.join(SEVERITIES[:-1])} or {SEVERITIES[-1]}"
                        )
                        self.x.found.append(
                            UnknownReference(
                                _last_word(clause.span, clause.word), f"`{clause.word}` is no severity", hint
                            )
                        )
                case ast.Evidence():
                    text["evidence"] = clause.path
                case ast.Owner():
                    text["owner"] = clause.text
        for name, span in assuming:
            if name not in assumptions:
                unknown = self.ctx.scope.unknown(name, span, "assumption", "")
                if unknown.modules:
                    self.x.found.append(unknown)
                    continue
                problem = f"no assumption `{name}` is declared in what is checked together"
                hint = (
                    close_matches(name, assumptions)
                    or f"declare it: `assume {name}`, or add a `use` of its module"
                )
                self.x.found.append(UnknownReference(span, problem, hint))
        formula, active, along = self._formula(item)
        if any(
            isinstance(d, UnknownName) for d in self.x.found[before:]
        ):  # which may be the variable, misspelt
            self.x.found[before:] = [d for d in self.x.found[before:] if not isinstance(d, UnusedVariable)]
        self._allow(item, before)
        if any(d.level == "error" for d in self.x.found[before:]):
            return None
        if formula is None and kind == "rule":
            return None
        return RuleInfo(
            item.name, kind, item.title, self.ctx.scope.module, formula, active, along, margin_unit(formula), tuple(satisfies),
            tuple(assuming), text["source"], text["because"], text["severity"], text["evidence"], text["owner"], reads(formula),
            fingerprint(item, formula), item.span.head,
        )  # fmt: skip

    def _allow(self, item: ast.Rule | ast.Assume, before: int) -> None:
        """Leave out the warnings that the rule allows, and report what it allows for nothing."""
        known = warnings() - {"W303"}
        allowed = [code for clause in item.clauses if isinstance(clause, ast.Allow) for code in clause.codes]
        names = {code.name for code in allowed}
        given = {d.code for d in self.x.found[before:] if d.level == "warning"}
        self.x.found[before:] = [
            d for d in self.x.found[before:] if d.level != "warning" or d.code not in names & known
        ]
        for code in allowed:
            if code.name not in known:
                hint = close_matches(code.name, known) or f"the warnings are {', '.join(sorted(known))}"
                self.x.found.append(
                    UnknownReference(code.span, f"`{code.name}` is no warning that can be allowed", hint)
                )
            elif code.name not in given and not any(d.level == "error" for d in self.x.found[before:]):
                self.x.found.append(AllowsNothing(code.span, code.name))

    def _placement(self, item: ast.Rule | ast.Assume, kind: str) -> None:
        """Which clauses may stand here, how often, and in what order."""
        a_kind = "a rule" if kind == "rule" else "an assumption"
        singles: dict[type[ast.Clause], str] = {
            ast.Require: "monitor" if kind == "assume" else "require", ast.Along: "along", ast.Because: "because", ast.Severity: "severity",
            ast.Evidence: "evidence", ast.Owner: "owner", ast.Whenever: "whenever", ast.WithinTime: "within",
        }  # fmt: skip
        for clause_type, word in singles.items():
            clauses = [c for c in item.clauses if isinstance(c, clause_type)]
            for extra in clauses[1:]:
                hint = (
                    "join the conditions with `and`, or write two rules"
                    if clause_type is ast.Require
                    else "keep one of them"
                )
                self._problem(
                    extra, f"`{word}` stands once in {a_kind}", hint, clauses[0].__dict__["span"].head
                )
        requires = [c for c in item.clauses if isinstance(c, ast.Require)]
        if kind == "rule" and not requires:
            self.x.found.append(
                ClauseProblem(
                    item.span.head, f"rule `{item.name}` requires nothing", "add a `require` clause"
                )
            )
        if kind == "assume" and not requires:
            for clause in item.clauses:
                if isinstance(
                    clause, (ast.Bind, ast.Let, ast.Except, ast.Along, ast.Whenever, ast.WithinTime)
                ):
                    self._problem(
                        clause,
                        "there is no `monitor` that this clause would be about",
                        "add a `monitor`, or remove the clause",
                    )
        for require in requires:
            if (require.keyword == "monitor") != (kind == "assume"):
                right = "monitor" if kind == "assume" else "require"
                self._problem(require, f"{a_kind} states its condition with `{right}`", f"write `{right}`")
        if kind == "rule":
            for clause in item.clauses:
                if isinstance(clause, (ast.Evidence, ast.Owner)):
                    self._problem(
                        clause,
                        "evidence and owner belong to an assumption",
                        "move it to the `assume` it is about",
                    )
        bound = False
        for clause in item.clauses:
            if isinstance(clause, ast.Bind):
                bound = True
            elif isinstance(clause, ast.Along) and bound:
                self._problem(clause, "`along` comes before the quantifiers", "move it up")
            elif isinstance(clause, ast.Except) and not bound:
                self._problem(
                    clause,
                    "`except` leaves elements out of a quantifier's range",
                    "put a `for all` before it, or use `whenever`",
                )
            elif isinstance(clause, ast.WithinTime):
                if not any(isinstance(c, ast.Whenever) for c in item.clauses):
                    self._problem(clause, "`within` is the deadline of a `whenever`", "add a `whenever` before it")
                if any(isinstance(c, ast.Along) for c in item.clauses):
                    hint = "along a timeline, write `eventually[0 s, ...]`"
                    self._problem(clause, "`within` counts the cycles of the run, not the samples of a timeline", hint)
            elif isinstance(clause, ast.Whenever) and bound:
                self._problem(clause, "`whenever` comes before the quantifiers", "move it up, or use `where`")
            if (
                requires
                and clause is not requires[0]
                and isinstance(
                    clause, (ast.Bind, ast.Let, ast.Except, ast.Along, ast.Whenever, ast.WithinTime)
                )
            ):
                if clause.__dict__["span"].start > requires[0].span.start:
                    self._problem(
                        clause,
                        "this clause comes after the condition that it is about",
                        "move it before the condition",
                    )

    def _problem(self, clause: ast.Clause, problem: str, hint: str, first: Span | None = None) -> None:
        self.x.found.append(ClauseProblem(clause.__dict__["span"].head, problem, hint, first))

    def _source(self, clause: ast.SourceClause) -> str:
        if clause.reference is None:
            return clause.locator
        name, span, scope = clause.reference.name, clause.reference.span, self.ctx.scope
        symbol = scope.look_up(name, span, "reference", set())
        if isinstance(symbol, Symbol) and isinstance(symbol.item, ast.Reference):
            return f"{symbol.item.text}, {clause.locator}" if clause.locator else symbol.item.text
        if isinstance(symbol, Ambiguous) or (isinstance(symbol, UnknownName) and symbol.modules):
            self.x.found.append(symbol)
        elif symbol is not None:
            references = [
                n for n in scope.names() if isinstance(getattr(scope.find(n), "item", None), ast.Reference)
            ]
            hint = close_matches(name, references) or f'declare it: `reference {name} = "..."`'
            self.x.found.append(
                UnknownReference(span, f"no reference `{name}` is declared here or in a used module", hint)
            )
        return ""

    def _formula(
        self, item: ast.Rule | ast.Assume
    ) -> tuple[ir.Formula | None, ir.Formula | None, ir.Axis | None]:
        """The whole formula, where the rule applies, and its timeline. Errors of all clauses are reported."""
        steps: list[tuple[ast.Clause, ir.Axis | None, ir.Formula | None]] = []
        ctx, body, failed = self.ctx, None, False
        clauses = [
            c
            for c in item.clauses
            if isinstance(
                c, (ast.Bind, ast.Except, ast.Let, ast.Along, ast.Whenever, ast.WithinTime, ast.Require)
            )
        ]
        deadline: tuple[float, Span] | None = None
        for position, clause in enumerate(clauses):
            self.x.expansions = 0
            try:
                match clause:
                    case ast.Along():
                        signal = self.x.value(clause.signal, ctx)
                        if (
                            not isinstance(signal, SignalValue)
                            or not signal.signal.sequence
                            or not _has_time(signal.signal)
                        ):
                            hint = "a timeline is a trajectory or a series with a column `t: s increasing`"
                            self.x.fail(
                                ClauseProblem(
                                    clause.signal.span, f"`{clause.signal.name}` is no timeline", hint
                                )
                            )
                        bound, names = self.x.axis(clause.signal, (clause.name,), False, clause.span, ctx)
                        ctx = ctx.bind(names, 1, bound)
                        steps.append((clause, bound, None))
                    case ast.Bind():
                        axis, names = self.x.range_of(clause, ctx)
                        failed |= axis is None
                        ctx = ctx.bind(names, 1)
                        self.x.check_used(
                            clause.names, (clause.where, *clauses[position + 1 :]), clause.span.head
                        )
                        guard = self.x.formula(clause.where, ctx).node if clause.where is not None else None
                        steps.append((clause, axis, guard))
                    case ast.Except() | ast.Whenever():
                        steps.append((clause, None, self.x.formula(clause.condition, ctx).node))
                    case ast.Let():
                        self.x.check_new(clause.name, clause.span, ctx)
                        value = self.x.value(clause.value, ctx)
                        ctx = ctx.bind({clause.name: value})
                    case ast.WithinTime():
                        deadline = self.x.deadline(clause.bound, ctx), clause.span
                    case ast.Require():
                        body = self.x.formula(clause.condition, ctx).node
                        if deadline is not None:
                            limit, at = deadline
                            body = self.x.over_run("eventually", (body,), 0.0, limit, False, at, ctx).node
            except (Poison, RecursionError) as error:
                failed = True
                if isinstance(error, RecursionError):
                    self.x.too_deep(clause.__dict__["span"].head)
                if isinstance(
                    clause, (ast.Let, ast.Along)
                ):  # a broken name, so that the clauses below are still checked
                    timeline = (
                        self.x.make(ir.Axis, "", "samples", 1, 0) if isinstance(clause, ast.Along) else None
                    )
                    ctx = ctx.bind({clause.name: Broken()}, 0, timeline)
        if failed or body is None:
            return None, None, None
        # The timeline is the outermost axis, whether `whenever`, which knows nothing of it, stands before it or after it.
        steps.sort(key=lambda step: not isinstance(step[0], ast.Along))
        formula, active, along = self._nest(_with_exceptions(steps, self.x), body)
        problem = misused(formula, active) if along is None else None
        if problem is not None:
            self.x.found.append(problem)
            return None, None, None
        return formula, active, along

    def _nest(
        self, steps: list[tuple[ast.Clause, ir.Axis | None, ir.Formula | None]], body: ir.Formula
    ) -> tuple[ir.Formula, ir.Formula | None, ir.Axis | None]:
        make = self.x.make
        active: ir.Formula | None = None
        along: ir.Axis | None = None
        for clause, axis, guard in reversed(steps):
            if isinstance(clause, ast.Bind):
                assert axis is not None
                body = make(
                    ir.Quantify, known(clause.quantifier, QUANTIFIERS), axis, guard, body, clause.names
                )
                # An empty `for all` demands nothing; an empty `exists` has not found what it demands, and an
                # element whose own demand is empty is found: whatever lies below an `exists`, it is never idle.
                if clause.quantifier == "for all":
                    active = make(
                        ir.Quantify, "exists", axis, guard, active or make(ir.Truth, True), clause.names
                    )
                else:
                    active = None
            elif isinstance(clause, ast.Whenever):
                assert guard is not None
                body = make(ir.Guarded, guard, body)
                active = guard if active is None else make(ir.Connective, "and", guard, active)
            elif isinstance(clause, ast.Along):
                assert axis is not None
                body, along = make(ir.First, axis, clause.name, body), axis
                active = make(ir.First, axis, clause.name, active) if active is not None else None
            else:
                raise AssertionError(f"unknown clause {type(clause).__name__}")
        return body, active, along


def _has_time(signal: SignalType) -> bool:
    """Whether a timeline has a column of times that the input contract holds to increase."""
    field = signal.field("t")
    return (
        field is not None
        and field.kind == "number"
        and field.increasing
        and parse_unit(field.unit)[2] == TIME
    )


def _with_exceptions(
    steps: list[tuple[ast.Clause, ir.Axis | None, ir.Formula | None]], x: Expressions
) -> list[tuple[ast.Clause, ir.Axis | None, ir.Formula | None]]:
    """Each `except` joined to the guard of the quantifier before it."""
    result: list[tuple[ast.Clause, ir.Axis | None, ir.Formula | None]] = []
    for clause, axis, guard in steps:
        if isinstance(clause, ast.Except):
            place = max((i for i, step in enumerate(result) if isinstance(step[0], ast.Bind)), default=None)
            if place is None:
                continue  # reported with the clauses' places
            bind, bound, before = result[place]
            assert guard is not None
            allowed = x.make(ir.Not, guard)
            result[place] = (
                bind,
                bound,
                allowed if before is None else x.make(ir.Connective, "and", before, allowed),
            )
        else:
            result.append((clause, axis, guard))
    return result


def margin_unit(formula: ir.Formula | None) -> str:
    """The unit of all of a formula's comparisons; "mixed" where they differ, "1" where there are none."""
    units = set() if formula is None else margin_units(formula)
    if not units:
        return "1"
    return units.pop() if len(units) == 1 else "mixed"


def margin_units(formula: ir.Formula) -> set[str]:
    """The units of a formula's comparisons, one of which is that of its margin."""
    atoms = formula_atoms(formula)
    units = {n.unit for n in atoms if isinstance(n, ir.Compare)}
    return units | {"m" for n in atoms if isinstance(n, ir.Geometry)}


def formula_atoms(formula: ir.Formula) -> list[ir.Formula]:
    """The comparisons, flags and geometric predicates that decide a formula (guards choose, they don't decide)."""
    atoms: list[ir.Formula] = []
    stack: list[ir.Formula] = [formula]
    while stack:
        node = stack.pop()
        match node:
            case ir.Compare() | ir.Flag() | ir.SweptInside() | ir.SweptClear() | ir.InArea():
                atoms.append(node)
            case ir.Truth():
                pass
            case ir.Quantify() | ir.Guarded():
                stack.append(node.body)
            case ir.Connective() | ir.Until():
                stack += [node.left, node.right]
            case ir.Not() | ir.Temporal() | ir.Shift() | ir.Edge() | ir.First():
                stack.append(node.operand)
            case ir.OverRun():
                stack += node.operands
            case _:
                assert_never(node)
    return atoms


def fingerprint(item: ast.Item, formula: ir.Formula | None) -> str:
    """A hash of what the rule says: its syntax tree (so layout and comments don't count) and all it is made of."""
    digest = hashlib.sha256(repr(item).encode())
    if formula is not None:
        digest.update(describe(formula).encode())
    return digest.hexdigest()


def describe(root: ir.IR) -> str:
    """A formula's structure as text, each shared node once: equal texts, equal meanings."""
    numbers: dict[int, int] = {}
    lines: list[str] = []

    def visit(node: ir.IR) -> int:
        if id(node) in numbers:
            return numbers[id(node)]
        parts = []
        for name in node.compared:
            value = node.__dict__[name]
            if name == "shown":
                continue  # how a margin is shown is no part of what a formula means
            if isinstance(value, ir.IR):
                parts.append(f"#{visit(value)}")
            elif isinstance(value, tuple):
                parts.append(
                    "(" + " ".join(f"#{visit(v)}" if isinstance(v, ir.IR) else repr(v) for v in value) + ")"
                )
            else:
                parts.append(repr(value))
        numbers[id(node)] = len(numbers)
        lines.append(f"{type(node).__name__} {' '.join(parts)}")
        return numbers[id(node)]

    visit(root)
    return "\n".join(lines)


def _last_word(span: Span, word: str) -> Span:
    """Where the word stands that ends a clause."""
    return Span(span.file, span.end - len(word), span.end) if span.text.endswith(word) else span.head


__all__ = [
    "FormulaValue",
    "RuleBuilder",
    "describe",
    "fingerprint",
    "formula_atoms",
    "margin_unit",
    "margin_units",
    "reads",
]
