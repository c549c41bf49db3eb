"""Rules and assumptions: what their clauses mean, and what they trace to."""

from __future__ import annotations

import hashlib
from collections import Counter
from typing import Literal, assert_never

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.description import describe
from trackmarshal.ir.margins import MIXED, SCALED, margin_unit, measured_units
from trackmarshal.ir.operators import QUANTIFIERS, known
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import ADVISORY, CourseInfo, RuleInfo, SignalType
from trackmarshal.lowering.rules import Lowered, lower_rule
from trackmarshal.semantics.advice.formulas import met_by_others
from trackmarshal.semantics.advice.starting import never_starts
from trackmarshal.semantics.advice.vacuity import vacuous
from trackmarshal.semantics.declarations.courses import judged_at
from trackmarshal.semantics.errors.names import Ambiguous, UnknownName, UnknownReference
from trackmarshal.semantics.errors.rules import ClauseProblem
from trackmarshal.semantics.expressions.checking import Context, Expressions, any_timeline
from trackmarshal.semantics.expressions.quantifiers import check_new, check_used, range_of, timeline
from trackmarshal.semantics.expressions.temporal import deadline
from trackmarshal.semantics.expressions.values import Broken, Local, Poison, named, span_of
from trackmarshal.semantics.overrun import misused, misused_along
from trackmarshal.semantics.warnings.codes import WARNINGS
from trackmarshal.semantics.warnings.vacuity import AllowsNothing, NothingFound, UnusedVariable
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import TIME, parse_unit

SEVERITIES = (ADVISORY, "minor", "major", "critical")
_KEYWORDS: tuple[Literal["require", "monitor"], ...] = ("require", "monitor")


#: The clauses that set the scene for a rule's condition.
_SCENE = (ast.Bind, ast.Except, ast.Let, ast.Along, ast.Whenever, ast.WithinTime)


#: So many levels of a rule's core every pass and every evaluator can go down, the stack of whoever calls them counted.
MOST_LEVELS = 300


class RuleBuilder:
    """Turns one declaration into a RuleInfo; what is wrong goes to the expressions' diagnostics."""

    def __init__(self, expressions: Expressions, ctx: Context, interner: ir.Interner) -> None:
        self.x = expressions
        self.ctx = ctx
        self.interner = interner

    def build(self, item: ast.Rule | ast.Assume, assumptions: set[str]) -> RuleInfo | None:
        """The rule; None where an error keeps it from having a meaning."""
        try:
            return self._built(item, assumptions)
        except RecursionError:  # no clause is deep, and what a chain of `let` comes to is
            self.x.too_deep(item.span.head)
            return None

    def _built(self, item: ast.Rule | ast.Assume, assumptions: set[str]) -> RuleInfo | None:
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
                    text["source"] = "; ".join(filter(None, (text["source"], self._source(clause))))
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
                case _ if not isinstance(clause, (*_SCENE, ast.Require, ast.Allow)):  # which others read
                    raise AssertionError(f"unknown clause {type(clause).__name__}")
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
        rule = self._rule(item)
        if any(
            isinstance(d, UnknownName) for d in self.x.found[before:]
        ):  # which may be the variable, misspelt
            self.x.found[before:] = [d for d in self.x.found[before:] if not isinstance(d, UnusedVariable)]
        core: Lowered | None = None
        if rule is not None and not any(d.level == "error" for d in self.x.found[before:]):
            core = lower_rule(rule, self.interner)
            if self.interner.depth(core.formula) > MOST_LEVELS:
                self.x.too_deep(item.span.head)
                return None
            self.x.found += vacuous(core, rule, self.x.bounds)
            parts = core.formula, core.active
            over_run = misused(*parts) if core.along is None else misused_along(core.along, *parts)
            if over_run is not None:
                self.x.found.append(over_run)
            elif text["severity"] != ADVISORY:  # one that never decides keeps nobody from driving
                self.x.found += never_starts(core, rule, self.x.bounds.params)
        self._allow(item, before)
        if any(d.level == "error" for d in self.x.found[before:]):
            return None
        if rule is None and kind == "rule":
            return None
        unit = margin_unit(core.formula if core else None)
        if rule is not None and core is not None and unit == MIXED:
            measured = measured_units(core.formula)
            if len(measured) > 1 and any(self.x.scales.get(each, 1.0) != 1.0 for each in measured):
                core, unit = lower_rule(rule, self.interner, self.x.scales), SCALED
        formula, active, along = (core.formula, core.active, core.along) if core else (None, None, None)
        course = None if along is None else self.x.courses.get(along.signal)
        return RuleInfo(
            item.name, kind, item.title, self.ctx.scope.module, formula, active, along, unit, tuple(satisfies),
            tuple(assuming), text["source"], text["because"], text["severity"], text["evidence"], text["owner"], _read(formula, course),
            fingerprint(item, formula, course), item.span.head, rule, item.span.text.rstrip(),
            () if core is None else core.names, course,
        )  # fmt: skip

    def _allow(self, item: ast.Rule | ast.Assume, before: int) -> None:
        """Leave out the warnings that the rule allows, and report what it allows for nothing."""
        known = WARNINGS - {"W303", "W304"}
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
                if isinstance(clause, _SCENE):
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
        else:
            for clause in item.clauses:
                if isinstance(clause, ast.Severity) and clause.word == ADVISORY:
                    hint = "leave `severity` out, or make a rule of the monitor"
                    self._problem(clause, "rules rely on an assumption: its monitor decides", hint)
        bound = False
        for clause in item.clauses:
            if (
                isinstance(clause, _SCENE)
                and requires
                and clause.__dict__["span"].start > requires[0].span.start
            ):
                problem = "this clause comes after the condition that it is about"
                self._problem(clause, problem, "move it before the condition")
            elif isinstance(clause, ast.Bind):
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
                    hint = "add a `whenever` before it"
                    self._problem(clause, "`within` is the deadline of a `whenever`", hint)
                if any(isinstance(c, ast.Along) for c in item.clauses):
                    hint = "along a timeline, write `eventually[0 s, ...]`"
                    self._problem(
                        clause, "`within` counts the cycles of the run, not the samples of a timeline", hint
                    )
            elif isinstance(clause, ast.Whenever) and bound:
                self._problem(clause, "`whenever` comes before the quantifiers", "move it up, or use `where`")

    def _problem(self, clause: ast.Clause, problem: str, hint: str, first: Span | None = None) -> None:
        self.x.found.append(ClauseProblem(clause.__dict__["span"].head, problem, hint, first))

    def _source(self, clause: ast.SourceClause) -> str:
        if clause.reference is None:
            return clause.locator
        name, span, scope = clause.reference.name, clause.reference.span, self.ctx.scope
        symbol = scope.look_up(name, span, "reference", set())
        if isinstance(symbol, typed.Symbol) and isinstance(symbol.item, ast.Reference):
            return f"{symbol.item.text}, {clause.locator}" if clause.locator else symbol.item.text
        if isinstance(symbol, Ambiguous) or (isinstance(symbol, UnknownName) and symbol.modules):
            self.x.found.append(symbol)
        elif symbol is not None:
            hint = (
                close_matches(name, scope.names_of(ast.Reference))
                or f'declare it: `reference {name} = "..."`'
            )
            self.x.found.append(
                UnknownReference(span, f"no reference `{name}` is declared here or in a used module", hint)
            )
        return ""

    def _rule(self, item: ast.Rule | ast.Assume) -> typed.Rule | None:
        """What the rule means; None where it has no condition, or an error. Errors of all clauses are reported."""
        made: list[typed.Clause] = []
        ctx, failed = self.ctx, False
        quantifier: typed.ForEach | None = None
        #: What one is looked for by that meets the demand.
        sought = within = ""
        #: Those that are looked for, and what a `let` says of them.
        about = set[str]()
        #: The variables of the last quantifier, and what a `let` says of them.
        latest = set[str]()
        # Of those that stand below the condition that is said; what they bind is known in it all the same.
        scene = [c for c in item.clauses if isinstance(c, _SCENE)]
        clauses = [*scene, *(c for c in item.clauses if isinstance(c, ast.Require))]
        mentioned = [ast.names_in(clause) for clause in clauses]
        #: By name, how many clauses mention it.
        mentions = Counter(name for names in mentioned for name in names)
        for position, clause in enumerate(clauses):
            self.x.expansions = 0
            try:
                match clause:
                    case ast.Along():
                        range_, names = self._timeline(clause, ctx)
                        ctx = ctx.bind(names, 1, range_)
                        at = judged_at(clause, range_.signal, self.x)
                        made.append(typed.Along(range_, at, clause.at is not None, clause.span))
                    case ast.Bind():
                        over, names = range_of(clause, self.x, ctx)
                        failed |= over is None
                        ctx = ctx.bind(names, 1)
                        check_used(
                            self.x,
                            clause.names,
                            (clause.where, clause.by, *clauses[position + 1 :]),
                            clause.span.head,
                        )
                        self.x.advise(met_by_others("where", clause.where))
                        sought = clause.quantifier if clause.by is None else ""
                        about |= set(clause.names) if sought == "exists" else set()
                        latest = set(clause.names)
                        guard, by = self._range_condition(clause, ctx)
                        if over is not None:
                            word = known(clause.quantifier, QUANTIFIERS)
                            quantifier = typed.ForEach(word, over, guard, by, clause.span)
                            made.append(quantifier)
                    case ast.Except():
                        self.x.advise(met_by_others("except", clause.condition))
                        condition = self.x.formula(clause.condition, ctx)
                        if quantifier is not None:  # else it was reported with the clauses' places
                            self._leaves_out(clause, quantifier, bool(latest & mentioned[position]))
                            made.append(typed.Except(quantifier, condition, clause.reason, clause.span))
                    case ast.Whenever():
                        self.x.advise(met_by_others("whenever", clause.condition))
                        made.append(typed.Whenever(self.x.formula(clause.condition, ctx), clause.span))
                    case ast.WithinTime():
                        within = "within"
                        made.append(deadline(clause.bound, clause.span, self.x, ctx))
                    case ast.Let():
                        check_new(clause.name, clause.span, self.x, ctx)
                        about |= {clause.name} if about & mentioned[position] else set()
                        latest |= {clause.name} if latest & mentioned[position] else set()
                        if mentions[clause.name] == (
                            clause.name in mentioned[position]
                        ):  # by no other clause
                            self.x.found.append(UnusedVariable(clause.span.head, clause.name))
                        value = self.x.value(clause.value, ctx)
                        ctx = ctx.bind({clause.name: named(clause.name, value, span_of(value))})
                        made.append(typed.Let(clause.name, value, clause.span))
                    case ast.Require():
                        self.x.advise(
                            met_by_others(within or sought, clause.condition, None if within else about)
                        )
                        keyword = known(clause.keyword, _KEYWORDS)
                        made.append(
                            typed.Require(keyword, self.x.formula(clause.condition, ctx), clause.span)
                        )
                    case _:
                        assert_never(clause)
            except (Poison, RecursionError) as error:
                failed = True
                if isinstance(error, RecursionError):
                    self.x.too_deep(clause.__dict__["span"].head)
                if isinstance(
                    clause, (ast.Let, ast.Along)
                ):  # a broken name, so that the clauses below are still checked
                    timeline = any_timeline(clause.span) if isinstance(clause, ast.Along) else None
                    ctx = ctx.bind({clause.name: Broken()}, 0, timeline)
        if failed or not any(isinstance(clause, typed.Require) for clause in made):
            return None
        return typed.Rule(item.name, item.title, tuple(made), item.span)

    def _leaves_out(self, clause: ast.Except, quantifier: typed.ForEach, about_it: bool) -> None:
        """Warn of an exception that leaves out all or none of an `exists`."""
        if quantifier.quantifier == "exists" and not about_it:
            names = "`, `".join(quantifier.range.names)
            self.x.found.append(
                NothingFound(ast.span_of(clause.condition), names, quantifier.range.signal.name)
            )

    def _range_condition(
        self, clause: ast.Bind, ctx: Context
    ) -> tuple[typed.Formula | None, typed.Number | None]:
        """What is in a quantifier's range, and of what the least of it is meant."""
        guard, by = self.x.all(
            lambda: self.x.formula(clause.where, ctx) if clause.where is not None else None,
            lambda: self.x.number(clause.by, ctx) if clause.by is not None else None,
        )
        return guard, by

    def _timeline(self, clause: ast.Along, ctx: Context) -> tuple[typed.Range, dict[str, Local]]:
        signal = self.x.value(clause.signal, ctx)
        if (
            not isinstance(signal, typed.SignalNode)
            or not signal.signal.sequence
            or not _has_time(signal.signal)
        ):
            hint = "a timeline is a trajectory or a series with a column `t: s increasing`"
            self.x.fail(ClauseProblem(clause.signal.span, f"`{clause.signal.name}` is no timeline", hint))
        return timeline(signal, clause.name, clause.span, self.x, ctx)


def _has_time(signal: SignalType) -> bool:
    """Whether a timeline has a column of times that the input contract holds to increase."""
    field = signal.field("t")
    return (
        field is not None
        and field.kind == "number"
        and field.increasing
        and parse_unit(field.unit)[2] == TIME
    )


def _read(formula: ir.Formula | None, course: CourseInfo | None) -> frozenset[tuple[str, str]]:
    """Which fields of which signals a rule reads; of a course, those of what it joins."""
    found = reads(formula)
    if course is None:
        return found
    own = {field for signal, field in found if signal == course.signal.name}
    joined = {(signal, field) for signal in (course.lived, course.planned) for field in own}
    both = {(course.planned, "t"), (course.planned, ""), (course.lived, "")}
    return frozenset({pair for pair in found if pair[0] != course.signal.name} | joined | both)


def fingerprint(item: ast.Item, formula: ir.Formula | None, course: CourseInfo | None = None) -> str:
    """A hash of what the rule says: its syntax tree (so layout and comments don't count) and all it is made of."""
    digest = hashlib.sha256(repr(item).encode())
    if formula is not None:
        digest.update(describe(formula).encode())
    if course is not None:
        digest.update(repr(course).encode())
    return digest.hexdigest()


def _last_word(span: Span, word: str) -> Span:
    """Where the word stands that ends a clause."""
    return Span(span.file, span.end - len(word), span.end) if span.text.endswith(word) else span.head


__all__ = ["SEVERITIES", "RuleBuilder", "fingerprint"]
