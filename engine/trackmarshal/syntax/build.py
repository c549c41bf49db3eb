"""What the parser finds to syntax tree: one method a grammar rule, called from the leaves up."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.errors import MixedChain, TooDeep, UnexpectedText, UnknownClause, UnknownUnit
from trackmarshal.syntax.foreign_units import unit_hint
from trackmarshal.syntax.grammar import WORD_CHARACTERS
from trackmarshal.syntax.keywords import CLAUSES
from trackmarshal.syntax.lalr import Token
from trackmarshal.syntax.names import spelled
from trackmarshal.units import UNIT_PATTERN

#: All words that start a clause.
CLAUSE_WORDS = tuple(dict.fromkeys(word for words in CLAUSES.values() for word in words))

#: Where a node starts and ends in its declaration, in characters.
Meta = tuple[int, int]

_NUMBER = re.compile(r"(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")

#: A unit; in place of one, a field may have the name of an enumeration.
_UNIT = re.compile(rf"(?:1|{UNIT_PATTERN})(?![{WORD_CHARACTERS}])")
#: What is said of members that stand before `else` without a value.
_ELSE = "`else` is for all that are not named: leave the others out, or give them a value"

#: Comparisons of which several may stand in a row: those that lead the same way.
_DIRECTIONS = ({"<", "<="}, {">", ">="})

#: Signs beside their ASCII forms.
_PLAIN = {
    "≤": "<=", "≥": ">=", "≠": "!=", "·": "*", "−": "-", "∧": "and", "∨": "or", "¬": "not", "→": "implies", "↔": "iff",
    "²": "^2", "³": "^3",
}  # fmt: skip


def plain(text: str) -> str:
    """An operator's ASCII form."""
    return _PLAIN.get(text, str(text))


def plain_unit(text: str) -> str:
    """A unit with ASCII exponents and products."""
    return str(text).replace("²", "^2").replace("³", "^3").replace("·", "*")


@lru_cache(maxsize=10_000)
def _number_and_unit(text: str) -> tuple[str, str]:
    """A quantity's parts: the data of tests have the same ones again and again."""
    number = _NUMBER.match(text)
    if number is None:
        raise AssertionError(f"a quantity without a number: {text}")
    return number.group(), plain_unit(text[number.end() :].strip())


def is_unit(text: str) -> bool:
    """Whether the type of a field is a unit: a closed list, of which no other name is one."""
    return _UNIT.match(text) is not None


def _type(text: str) -> str:
    """A unit with ASCII exponents and products, or a name as it is spelled."""
    unit = plain_unit(text)
    return unit if is_unit(unit) else spelled(text)


def unquoted(token: Any) -> str:
    """The text of a string token, or the empty string where it is absent."""
    return "" if token is None else str(token)[1:-1].replace('\\"', '"').replace("\\\\", "\\")


class Refused(Exception):
    """The grammar accepts the text and the language does not."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic)
        self.diagnostic = diagnostic


class Builder:
    """Builds the tree of one declaration that stands at offset `base` of `file`."""

    def __init__(self, file: SourceFile, base: int, limit: int) -> None:
        self._file = file
        self._base = base
        self._limit = limit

    def too_high(self, meta: Meta) -> None:
        raise Refused(TooDeep(self._span(meta).head, self._limit))

    def _span(self, meta: Meta) -> Span:
        return Span(self._file, self._base + meta[0], self._base + meta[1])

    def _at(self, token: Token) -> Span:
        start = self._base + token.start_pos
        return Span(self._file, start, start + len(token))

    def _name(self, token: Token) -> ast.Name:
        return ast.Name(spelled(token), self._at(token))

    # Declarations ---------------------------------------------------------------------------------------

    def item(self, meta: Meta, c: list[Any]) -> ast.Item:
        return c[0]  # type: ignore[no-any-return]

    def place(self, meta: Meta, c: list[Any]) -> ast.Place:
        return c[0]  # type: ignore[no-any-return]

    def dotted(self, meta: Meta, c: list[Any]) -> str:
        return ".".join(spelled(part) for part in c)

    def module(self, meta: Meta, c: list[Any]) -> ast.ModuleName:
        return ast.ModuleName(c[0], self._span(meta))

    def use(self, meta: Meta, c: list[Any]) -> ast.Use:
        return ast.Use(c[0], self._span(meta))

    def reference(self, meta: Meta, c: list[Any]) -> ast.Reference:
        return ast.Reference(spelled(c[0]), unquoted(c[1]), self._span(meta))

    def kind(self, meta: Meta, c: list[Any]) -> str:
        return str(c[0])

    field_type = parameter_type = kind

    def fields(self, meta: Meta, c: list[Any]) -> tuple[ast.Field, ...]:
        return tuple(item for item in c if item is not None)

    def field(self, meta: Meta, c: list[Any]) -> ast.Field:
        return ast.Field(spelled(c[0]), _type(c[1]), c[2] is not None, c[3], c[4], self._span(meta))

    def range(self, meta: Meta, c: list[Any]) -> ast.Range:
        return ast.Range(c[0], c[1], self._span(meta))

    def default(self, meta: Meta, c: list[Any]) -> ast.Expr:
        return c[0]  # type: ignore[no-any-return]

    def infinite(self, meta: Meta, c: list[Any]) -> ast.Expr:
        return ast.Name("inf", self._span(meta))

    def bound(self, meta: Meta, c: list[Any]) -> ast.Expr:
        return c[1] if c[0] is None else ast.Unary("-", c[1], self._span(meta))

    def signal(self, meta: Meta, c: list[Any]) -> ast.Signal:
        return ast.Signal(spelled(c[0]), c[2], c[1] is not None, c[3] or (), c[4], c[5], self._span(meta))

    def capacity(self, meta: Meta, c: list[Any]) -> ast.Expr:
        return c[0]  # type: ignore[no-any-return]

    forget = capacity

    def course(self, meta: Meta, c: list[Any]) -> ast.Course:
        return ast.Course(spelled(c[0]), self._name(c[1]), c[2], self._name(c[3]), self._span(meta))

    def enum(self, meta: Meta, c: list[Any]) -> ast.Enum:
        members = tuple(self._member(name) for name in c[2:] if name is not None)
        return ast.Enum(spelled(c[0]), unquoted(c[1]), members, self._span(meta))

    def event(self, meta: Meta, c: list[Any]) -> ast.Event:
        return ast.Event(spelled(c[0]), unquoted(c[1]), self._span(meta))

    def param(self, meta: Meta, c: list[Any]) -> ast.Param:
        name = spelled(c[0]) if c[1] is None else f"{spelled(c[0])}.{spelled(c[1])}"
        return ast.Param(name, plain_unit(c[2]), c[3], c[4], c[5], self._span(meta))

    def param_field(self, meta: Meta, c: list[Any]) -> ast.ParamField:
        return ast.ParamField(spelled(c[0]), c[1], c[2], c[3], self._span(meta))

    def param_unknown(self, meta: Meta, c: list[Any]) -> ast.Param:
        """A name where a unit belongs: only a record `{ ... }` has a shape."""
        name = spelled(c[1])
        raise Refused(UnknownUnit(self._at(c[1]), "unit", name, unit_hint(name, name, "")))

    def param_record(self, meta: Meta, c: list[Any]) -> ast.ParamRecord:
        entries = tuple(entry for entry in c[2:] if entry is not None)
        return ast.ParamRecord(spelled(c[0]), spelled(c[1]), entries, self._span(meta))

    def source_text(self, meta: Meta, c: list[Any]) -> str:
        return unquoted(c[0])

    def constrain(self, meta: Meta, c: list[Any]) -> ast.Constrain:
        return ast.Constrain(c[0], c[1].text if c[1] else None, self._span(meta))

    def scale(self, meta: Meta, c: list[Any]) -> ast.Scale:
        return ast.Scale(plain_unit(c[0]), c[1], self._span(meta))

    def point(self, meta: Meta, c: list[Any]) -> tuple[ast.Expr, ast.Expr]:
        return (c[0], c[1])

    def cells(self, meta: Meta, c: list[Any]) -> tuple[ast.Expr, ...]:
        return tuple(c)

    def row(self, meta: Meta, c: list[Any]) -> tuple[ast.Expr, ...]:
        return (c[0], *c[1])

    reading = kind

    def clamp(self, meta: Meta, c: list[Any]) -> tuple[str, ast.Expr | None]:
        return "clamp", None

    def wrap(self, meta: Meta, c: list[Any]) -> tuple[str, ast.Expr | None]:
        return "wrap", c[0]

    def way(self, meta: Meta, c: list[Any]) -> ast.Way:
        outside, length = c[1] or ("", None)
        return ast.Way(c[0], outside, length, self._span(meta))

    def ways(self, meta: Meta, c: list[Any]) -> tuple[ast.Way, ...]:
        return tuple(way for way in c if way is not None)

    def second(self, meta: Meta, c: list[Any]) -> ast.Second:
        return ast.Second(spelled(c[0]), plain_unit(c[1]), "", (), self._span(meta))

    def header(self, meta: Meta, c: list[Any]) -> ast.Second:
        return ast.Second("", "", spelled(c[0]), c[1], self._span(meta))

    def table(self, meta: Meta, c: list[Any]) -> ast.Table:
        second, header, rows = c[3], c[6], tuple(c[7:-1])
        if second is not None and header is not None:
            second = ast.Second(second.name, second.unit, header.label, header.knots, header.span)
        if second is None and header is not None:
            hint = f"a table of two arguments names both: `({spelled(c[1])}: {plain_unit(c[2])}, {header.label}: ...)`"
            raise Refused(UnexpectedText(header.span, "a row of names", "a row `| knot: value`", hint))
        return ast.Table(
            spelled(c[0]),
            spelled(c[1]),
            plain_unit(c[2]),
            plain_unit(c[4]),
            rows,
            c[-1],
            c[5],
            second,
            self._span(meta),
        )

    def zone(self, meta: Meta, c: list[Any]) -> ast.Place:
        return ast.Place("zone", spelled(c[0]), unquoted(c[1]), tuple(c[2:]), self._span(meta))

    def line(self, meta: Meta, c: list[Any]) -> ast.Place:
        return ast.Place("line", spelled(c[0]), unquoted(c[1]), tuple(c[2:]), self._span(meta))

    def stretch(self, meta: Meta, c: list[Any]) -> ast.Stretch:
        return ast.Stretch(spelled(c[0]), unquoted(c[1]), c[2], c[3], c[4], self._span(meta))

    def parameter(self, meta: Meta, c: list[Any]) -> ast.Parameter:
        return ast.Parameter(spelled(c[0]), _type(c[1]), c[2], self._span(meta))

    def parameters(self, meta: Meta, c: list[Any]) -> tuple[ast.Parameter, ...]:
        return tuple(c)

    def shape_field(self, meta: Meta, c: list[Any]) -> ast.Field:
        return ast.Field(spelled(c[0]), _type(c[1]), False, None, None, self._span(meta))

    def shape(self, meta: Meta, c: list[Any]) -> ast.Shape:
        fields = tuple(field for field in c[3:] if field is not None)
        base = "" if c[2] is None else spelled(c[2])
        return ast.Shape(spelled(c[0]), unquoted(c[1]), base, fields, self._span(meta))

    def define(self, meta: Meta, c: list[Any]) -> ast.Define:
        result = None if c[2] is None else plain_unit(c[2])
        return ast.Define("define", spelled(c[0]), c[1] or (), result, c[3], self._span(meta))

    def predicate(self, meta: Meta, c: list[Any]) -> ast.Define:
        return ast.Define("predicate", spelled(c[0]), c[1] or (), None, c[2], self._span(meta))

    def label(self, meta: Meta, c: list[Any]) -> ast.Name:
        return self._name(c[0])

    def assume(self, meta: Meta, c: list[Any]) -> ast.Assume:
        return ast.Assume(c[0].name, unquoted(c[1]), tuple(c[2:]), self._span(meta))

    def rule(self, meta: Meta, c: list[Any]) -> ast.Rule:
        return ast.Rule(c[0].name, unquoted(c[1]), tuple(c[2:]), self._span(meta))

    # Clauses ------------------------------------------------------------------------------------------------

    def satisfies(self, meta: Meta, c: list[Any]) -> ast.Satisfies:
        return ast.Satisfies(tuple(c), self._span(meta))

    def assuming(self, meta: Meta, c: list[Any]) -> ast.Assuming:
        return ast.Assuming(tuple(c), self._span(meta))

    def locator(self, meta: Meta, c: list[Any]) -> tuple[str, bool]:
        if str(c[0]).startswith('"'):
            return unquoted(c[0]), True
        return f"{spelled(c[0])} {', '.join(c[1:])}", False

    def source(self, meta: Meta, c: list[Any]) -> ast.SourceClause:
        if str(c[0]).startswith('"'):
            return ast.SourceClause(None, unquoted(c[0]), True, self._span(meta))
        locator, quoted = c[1] or ("", False)
        return ast.SourceClause(self._name(c[0]), locator, quoted, self._span(meta))

    def because(self, meta: Meta, c: list[Any]) -> ast.Because:
        return ast.Because(unquoted(c[0]), self._span(meta))

    def severity(self, meta: Meta, c: list[Any]) -> ast.Severity:
        return ast.Severity(spelled(c[0]), self._span(meta))

    def allow(self, meta: Meta, c: list[Any]) -> ast.Allow:
        return ast.Allow(tuple(self._name(code) for code in c[:-1]), unquoted(c[-1]), self._span(meta))

    def evidence(self, meta: Meta, c: list[Any]) -> ast.Evidence:
        return ast.Evidence(unquoted(c[0]), self._span(meta))

    def owner(self, meta: Meta, c: list[Any]) -> ast.Owner:
        return ast.Owner(unquoted(c[0]), self._span(meta))

    def quantifier(self, meta: Meta, c: list[Any]) -> str:
        return "exists" if str(c[0]) in ("exists", "∃") else "for all"

    def where(self, meta: Meta, c: list[Any]) -> ast.Expr:
        return c[0]  # type: ignore[no-any-return]

    def bind(self, meta: Meta, c: list[Any]) -> ast.Bind:
        names = tuple(spelled(name) for name in c[2:-2])
        return ast.Bind(c[0], c[1] is not None, names, c[-2], c[-1], None, self._span(meta))

    def nearest(self, meta: Meta, c: list[Any]) -> str:
        return "exists" if str(c[0]).startswith(("exists", "∃")) else "for all"

    def bind_nearest(self, meta: Meta, c: list[Any]) -> ast.Bind:
        return ast.Bind(c[0], False, (spelled(c[1]),), c[2], c[4], c[3], self._span(meta))

    def except_(self, meta: Meta, c: list[Any]) -> ast.Except:
        return ast.Except(c[0], unquoted(c[1]), self._span(meta))

    def let(self, meta: Meta, c: list[Any]) -> ast.Let:
        return ast.Let(spelled(c[0]), c[1], self._span(meta))

    def along(self, meta: Meta, c: list[Any]) -> ast.Along:
        at = None if c[2] is None else self._name(c[2])
        return ast.Along(self._name(c[0]), spelled(c[1]), at, self._span(meta))

    def whenever(self, meta: Meta, c: list[Any]) -> ast.Whenever:
        return ast.Whenever(c[0], self._span(meta))

    def within(self, meta: Meta, c: list[Any]) -> ast.WithinTime:
        return ast.WithinTime(c[0], self._span(meta))

    def require(self, meta: Meta, c: list[Any]) -> ast.Require:
        return ast.Require("require", c[0], self._span(meta))

    def monitor(self, meta: Meta, c: list[Any]) -> ast.Require:
        return ast.Require("monitor", c[0], self._span(meta))

    def state(self, meta: Meta, c: list[Any]) -> ast.State:
        states = tuple(part for part in c if isinstance(part, ast.StateName))
        transitions = tuple(part for part in c if isinstance(part, ast.Transition))
        binder, domain, start, bridges = (part for part in c[1 + len(states) : -len(transitions)])
        each = ("", "") if binder is None else (spelled(binder), spelled(domain))
        return ast.State(
            spelled(c[0]), states, *each, self._name(start), transitions, bridges, self._span(meta)
        )

    def state_name(self, meta: Meta, c: list[Any]) -> ast.StateName:
        return ast.StateName(spelled(c[1]), c[0] is not None, self._span(meta))

    def sources(self, meta: Meta, c: list[Any]) -> tuple[ast.Name, ...]:
        return tuple(map(self._name, c))

    def transition(self, meta: Meta, c: list[Any]) -> ast.Transition:
        return ast.Transition(self._name(c[0]), c[1] or (), c[2], tuple(c[3:]), self._span(meta))

    def keep(self, meta: Meta, c: list[Any]) -> ast.Keep:
        return ast.Keep(spelled(c[0]), c[1], self._span(meta))

    def rulebook(self, meta: Meta, c: list[Any]) -> ast.Rulebook:
        return ast.Rulebook(spelled(c[0]), unquoted(c[1]), c[2], tuple(c[3:]), self._span(meta))

    def base(self, meta: Meta, c: list[Any]) -> ast.Base:
        return ast.Base(str(c[0]), self._name(c[1]), self._span(meta))

    def chain(self, meta: Meta, c: list[Any]) -> ast.Chain:
        return ast.Chain(tuple(c[0::2]), tuple(str(token) for token in c[1::2]), self._span(meta))

    # Tests ----------------------------------------------------------------------------------------------------

    def test(self, meta: Meta, c: list[Any]) -> ast.Test:
        return ast.Test(c[0].name, unquoted(c[1]), tuple(c[2:-1]), c[-1], self._span(meta))

    def given(self, meta: Meta, c: list[Any]) -> ast.Given:
        return ast.Given(spelled(c[0]), c[1], c[2] or (), self._span(meta))

    def after(self, meta: Meta, c: list[Any]) -> ast.After:
        return ast.After(c[0], self._span(meta))

    def with_changes(self, meta: Meta, c: list[Any]) -> tuple[ast.Change, ...]:
        return tuple(c)

    def change(self, meta: Meta, c: list[Any]) -> ast.Change:
        return ast.Change(spelled(c[0]), None if c[1] is None else str(c[1]), c[2], self._span(meta))

    def at_value(self, meta: Meta, c: list[Any]) -> str:
        return str(c[0])

    def expect(self, meta: Meta, c: list[Any]) -> ast.Expect:
        binder = None if c[3] is None else spelled(c[3])
        return ast.Expect(spelled(c[0]), c[1], c[2], binder, c[4], self._span(meta))

    def entry(self, meta: Meta, c: list[Any]) -> tuple[str, ast.Expr]:
        return spelled(c[0]), c[1]

    def record(self, meta: Meta, c: list[Any]) -> ast.RecordValue:
        entries = [entry for entry in c if entry is not None]
        return ast.RecordValue(tuple(e[0] for e in entries), tuple(e[1] for e in entries), self._span(meta))

    def list_value(self, meta: Meta, c: list[Any]) -> ast.ListValue:
        return ast.ListValue(tuple(value for value in c if value is not None), self._span(meta))

    # Expressions ----------------------------------------------------------------------------------------------

    def literal(self, meta: Meta, c: list[Any]) -> ast.Number:
        text = str(c[0])
        if c[0].type == "NUMBER":
            return ast.Number(text, "", self._span(meta))
        return ast.Number(*_number_and_unit(text), self._span(meta))

    def name(self, meta: Meta, c: list[Any]) -> ast.Name:
        return self._name(c[0])

    def parenthesised(self, meta: Meta, c: list[Any]) -> ast.Expr:
        return ast.parenthesised(c[0])

    def true(self, meta: Meta, c: list[Any]) -> ast.Boolean:
        return ast.Boolean(True, self._span(meta))

    def false(self, meta: Meta, c: list[Any]) -> ast.Boolean:
        return ast.Boolean(False, self._span(meta))

    def binary(self, meta: Meta, c: list[Any]) -> ast.Binary:
        return ast.Binary(plain(c[1]), c[0], c[2], self._span(meta))

    def chained(self, meta: Meta, c: list[Any]) -> ast.Chained:
        ops = tuple(plain(op) for op in c[1::2])
        for first, op, token in zip(ops, ops[1:], c[3::2]):
            if not any({first, op} <= direction for direction in _DIRECTIONS):
                raise Refused(MixedChain(self._at(token), op, first, self._at(c[1])))
        return ast.Chained(tuple(c[0::2]), ops, self._span(meta))

    def prefix(self, meta: Meta, c: list[Any]) -> ast.Unary:
        return ast.Unary(plain(c[0]), c[1], self._span(meta))

    def _raised(self, expr: ast.Expr, meta: Meta) -> ast.Expr:
        """What an exponent belongs to: of `3 m ^2`, nobody sees whether to the quantity or to its unit."""
        if isinstance(expr, ast.Number) and expr.unit and not ast.is_parenthesised(expr):
            span, quantity = self._span(meta), expr.span.text
            power = "".join(span.text[len(quantity) :].split())
            hint = f"write `({quantity}){power}` for a power of it, and `{quantity}{power}` for its unit"
            raise Refused(
                UnexpectedText(
                    span, f"`{span.text}`", "an exponent of the quantity, or one of its unit", hint
                )
            )
        return expr

    def power(self, meta: Meta, c: list[Any]) -> ast.Binary:
        return ast.Binary("^", self._raised(c[0], meta), c[1], self._span(meta))

    def superscript(self, meta: Meta, c: list[Any]) -> ast.Binary:
        digit = ast.Number("2" if c[1] == "²" else "3", "", self._at(c[1]))
        return ast.Binary("^", self._raised(c[0], meta), digit, self._span(meta))

    def root(self, meta: Meta, c: list[Any]) -> ast.Call:
        return ast.Call("sqrt", (c[0],), ("",), self._span(meta))

    def named_argument(self, meta: Meta, c: list[Any]) -> tuple[str, ast.Expr]:
        return spelled(c[0]), c[1]

    def arguments(self, meta: Meta, c: list[Any]) -> list[tuple[str, ast.Expr]]:
        return [item if isinstance(item, tuple) else ("", item) for item in c]

    def call(self, meta: Meta, c: list[Any]) -> ast.Call:
        args = c[1] or []
        return ast.Call(spelled(c[0]), tuple(a[1] for a in args), tuple(a[0] for a in args), self._span(meta))

    def attribute(self, meta: Meta, c: list[Any]) -> ast.Attribute:
        return ast.Attribute(c[0], spelled(c[1]), self._span(meta))

    def if_else(self, meta: Meta, c: list[Any]) -> ast.IfElse:
        return ast.IfElse(c[0], c[1], c[2], self._span(meta))

    def _member(self, token: Token) -> ast.Member:
        return ast.Member(spelled(token), self._at(token))

    def branch(self, meta: Meta, c: list[Any]) -> ast.Member:
        return self._member(c[0])

    def branch_end(self, meta: Meta, c: list[Any]) -> ast.Branch:
        return ast.Branch((self._member(c[0]),), c[1], self._span(meta))

    def branch_else(self, meta: Meta, c: list[Any]) -> ast.Branch:
        return ast.Branch((), c[0], self._span(meta))

    def case(self, meta: Meta, c: list[Any]) -> ast.Case:
        """Members that stand before others, without a value of their own, have that of the next one."""
        branches: list[ast.Branch] = []
        waiting: list[ast.Member] = []
        for part in c[1:]:
            if isinstance(part, ast.Member):
                waiting.append(part)
            elif part is not None:
                if waiting and not part.members:
                    raise Refused(
                        UnexpectedText(
                            waiting[-1].span, f"`{waiting[-1].name}`", "a member with a value", _ELSE
                        )
                    )
                span = waiting[0].span.to(part.span) if waiting else part.span
                branches.append(ast.Branch((*waiting, *part.members), part.value, span))
                waiting = []
        if waiting:
            hint = f"write what it is then: `{waiting[-1].name}: ...`"
            raise Refused(
                UnexpectedText(waiting[-1].span, f"`{waiting[-1].name}`", "a member with a value", hint)
            )
        return ast.Case(c[0], tuple(branches), self._span(meta))

    def in_range(self, meta: Meta, c: list[Any]) -> ast.Within:
        return ast.Within(c[0], c[1], c[2], self._span(meta))

    def in_zone(self, meta: Meta, c: list[Any]) -> ast.InZone:
        return ast.InZone(c[0], spelled(c[1]), self._span(meta))

    def in_stretch(self, meta: Meta, c: list[Any]) -> ast.InStretch:
        return ast.InStretch(c[0], spelled(c[1]), self._span(meta))

    def between_stations(self, meta: Meta, c: list[Any]) -> ast.BetweenStations:
        return ast.BetweenStations(c[0], c[1], c[2], c[3], self._span(meta))

    def infix(self, meta: Meta, c: list[Any]) -> ast.Infix:
        where = self._at(c[1])
        if not self._file.text[self._file.text.rfind("\n", 0, where.start) + 1 : where.start].strip():
            # The first word of a line is where a clause starts: `requier x < 3` is not about a predicate `requier`.
            hint = close_matches(c[1], CLAUSE_WORDS, 0.75)
            if hint:
                raise Refused(UnknownClause(where, str(c[1]), hint))
        return ast.Infix(c[0], spelled(c[1]), c[2], self._span(meta))

    def window(self, meta: Meta, c: list[Any]) -> ast.Window:
        return ast.Window(c[0], c[1], self._span(meta))

    def temporal(self, meta: Meta, c: list[Any]) -> ast.Temporal:
        return ast.Temporal(str(c[0]), c[2], c[1], False, self._span(meta))

    def step(self, meta: Meta, c: list[Any]) -> ast.Temporal:
        return ast.Temporal(str(c[0]), c[1], None, False, self._span(meta))

    def weak_step(self, meta: Meta, c: list[Any]) -> ast.Temporal:
        return ast.Temporal(str(c[1]), c[2], None, True, self._span(meta))

    def until(self, meta: Meta, c: list[Any]) -> ast.Until:
        return ast.Until(str(c[1]), c[0], c[3], c[2], self._span(meta))

    def quantified(self, meta: Meta, c: list[Any]) -> ast.Quantified:
        names = tuple(spelled(name) for name in c[2:-3])
        return ast.Quantified(c[0], c[1] is not None, names, c[-3], c[-2], c[-1], None, self._span(meta))

    def quantified_nearest(self, meta: Meta, c: list[Any]) -> ast.Quantified:
        return ast.Quantified(c[0], False, (spelled(c[1]),), c[2], c[4], c[5], c[3], self._span(meta))

    def counted(self, meta: Meta, c: list[Any]) -> ast.Folded:
        if not isinstance(c[1], ast.Name) or ast.is_parenthesised(c[1]):
            span = c[1].__dict__["span"]
            hint = "a variable ranges over what is counted: `count(o in objects where ...)`"
            raise Refused(UnexpectedText(span, f"`{span.text}`", "a name", hint))
        name = c[1].name
        return ast.Folded(spelled(c[0]), None, False, (name,), c[2], c[3], None, self._span(meta))

    def folded(self, meta: Meta, c: list[Any]) -> ast.Folded:
        names = tuple(spelled(name) for name in c[3:-3])
        return ast.Folded(spelled(c[0]), c[1], c[2] is not None, names, c[-3], c[-2], c[-1], self._span(meta))
