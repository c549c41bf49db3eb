"""Declarations as pieces, each on lines of its own: a header, clauses, fields, rows, points."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from trackmarshal.node import Node
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import is_unit
from trackmarshal.syntax.notation import EXPRESSION, POSTFIX, SUM, Notation, quoted
from trackmarshal.syntax.wrapping import WIDTH, Wrapping, end_column, new_line

#: Where the bodies of clauses start, in rules and assumptions, and in tests.
CLAUSE_COLUMN = 12
TEST_COLUMN = 9
#: A value or a range wider than this does not push what stands after its neighbours to the right.
WIDEST = 40


class Piece(NamedTuple):
    """A text that comments stand before and after; `start` and `end` are its place in the source, -1 if not known."""

    text: str
    indent: int = 2
    start: int = -1
    end: int = -1


class Laid(NamedTuple):
    """A declaration: its pieces, and a denser text for when no comment stands between them."""

    pieces: list[Piece]
    compact: str | None = None


class Columns(NamedTuple):
    """Widths that neighbours share."""

    name: int = 0
    unit: int = 0
    value: int = 0
    range: int = 0


class Layout:
    """Lays out declarations in one notation."""

    def __init__(self, notation: Notation) -> None:
        self._n = notation
        self._w = Wrapping(notation)

    def lay(self, item: ast.Item, columns: Columns) -> Laid:
        """The pieces of a declaration; raises TypeError for a node that has no layout."""
        handler = _ITEMS.get(type(item))
        if handler is None:
            raise TypeError(f"no layout for a {type(item).__name__}")
        laid = handler(self, item, columns)
        return laid if isinstance(laid, Laid) else Laid([Piece(laid, 0)])

    def columns(self, run: Sequence[ast.Item]) -> Columns:
        """The common widths of declarations of one kind that follow each other without a blank line."""
        name = max(
            (len(self._n.name(item.name)) for item in run if isinstance(item, (ast.Param, ast.Signal))),
            default=0,
        )
        params = [item for item in run if isinstance(item, ast.Param)]
        return Columns(
            name,
            max((len(self._n.unit(item.unit)) for item in params), default=0),
            _widest(
                self._n.expr(item.value, SUM) for item in params if item.range or item.source is not None
            ),
            _widest(self._range(item.range) for item in params if item.range and item.source is not None),
        )

    def _range(self, range_: ast.Range) -> str:
        return self._n.range(range_.lower, range_.upper)

    # Declarations of one piece --------------------------------------------------------------------------------

    def _module(self, item: ast.ModuleName, columns: Columns) -> str:
        return f"module {item.name}"

    def _use(self, item: ast.Use, columns: Columns) -> str:
        return f"use {item.name}"

    def _reference(self, item: ast.Reference, columns: Columns) -> str:
        return f"reference {self._n.name(item.name)} = {quoted(item.text)}"

    def _titled(self, keyword: str, name: str, title: str) -> str:
        return f"{keyword} {self._n.name(name)}" + (f" {quoted(title)}" if title else "")

    def _event(self, item: ast.Event, columns: Columns) -> str:
        return self._titled("event", item.name, item.text)

    def _course(self, item: ast.Course, columns: Columns) -> str:
        head = f"course {self._n.name(item.name)} = {self._n.name(item.lived.name)} for "
        return f"{head}{self._w.lay(item.bound, SUM, len(head))} then {self._n.name(item.planned.name)}"

    def _enum(self, item: ast.Enum, columns: Columns) -> Laid:
        head = f"{self._titled('enum', item.name, item.text)} {{"
        names = [self._n.name(member.name) for member in item.members]
        pieces = [Piece(head, 0), *(_placed(f"{name},", member) for name, member in zip(names, item.members))]
        pieces.append(Piece("}", 0, item.span.end - 1, item.span.end))
        filled = self._w.fill([(name, None) for name in names], len(head) + 1, 2, 2)
        return Laid(pieces, f"{head} {filled} }}")

    def _param(self, item: ast.Param, columns: Columns) -> str:
        name, unit = self._n.name(item.name).ljust(columns.name), self._n.unit(item.unit).ljust(columns.unit)
        head = f"param {name} : {unit} = "
        value = self._w.lay(item.value, SUM, len(head))
        source = "" if item.source is None else f"source {quoted(item.source)}"
        limits = "" if item.range is None else self._range(item.range)
        text = head + (value.ljust(columns.value) if limits or source else value)
        if limits:
            text = self._w.append(text, 0, limits.ljust(columns.range) if source else limits, 2)
        return self._w.append(text, 0, source, 2) if source else text

    def _param_record(self, item: ast.ParamRecord, columns: Columns) -> Laid:
        head = f"param {self._n.name(item.name)} : {self._n.name(item.shape)} = {{"
        entries = [self._param_field(entry) for entry in item.entries]
        pieces = [Piece(head, 0), *(_placed(f"{text},", entry) for text, entry in zip(entries, item.entries))]
        pieces.append(Piece("}", 0, item.span.end - 1, item.span.end))
        flat = f"{head} {', '.join(entries)} }}"
        return Laid(pieces, flat if len(flat) <= WIDTH and "\n" not in flat else None)

    def _param_field(self, entry: ast.ParamField) -> str:
        lead = f"{self._n.name(entry.name)}: "
        text = lead + self._w.lay(entry.value, SUM, 2 + len(lead))
        if entry.range is not None:
            text = self._w.append(text, 2, self._range(entry.range), 4)
        return text if entry.source is None else self._w.append(text, 2, f"source {quoted(entry.source)}", 4)

    def _constrain(self, item: ast.Constrain, columns: Columns) -> str:
        head = "constrain "
        text = head + self._w.lay(item.condition, EXPRESSION, len(head))
        return text if item.because is None else self._w.append(text, 0, f"because {quoted(item.because)}", 2)

    def _scale(self, item: ast.Scale, columns: Columns) -> str:
        return f"scale {self._n.unit(item.unit)} = {self._n.expr(item.value)}"

    def _define(self, item: ast.Define, columns: Columns) -> str:
        head = f"{item.keyword} {self._n.name(item.name)}"
        if item.parameters:
            parameters = [(self._parameter(p), None) for p in item.parameters]
            head += f"({self._w.fill(parameters, len(head) + 1, len(head) + 1, 12)})"
        head += " =" if item.result is None else f" -> {self._n.unit(item.result)} ="
        level = SUM if item.keyword == "define" else EXPRESSION
        flat = self._n.expr(item.body, level)
        if end_column(head, 0) + 1 + len(flat) <= WIDTH:
            return f"{head} {flat}"
        return f"{head}{new_line(2)}{self._w.lay(item.body, level, 2)}"

    def _parameter(self, one: ast.Parameter) -> str:
        text = f"{self._n.name(one.name)}: {self._type(one.type)}"
        return text if one.default is None else f"{text} = {self._n.expr(one.default, SUM)}"

    # Declarations that hold lists -----------------------------------------------------------------------------

    def _signal(self, item: ast.Signal, columns: Columns) -> Laid:
        head = f"signal {self._n.name(item.name).ljust(columns.name)} : {'set of ' if item.many else ''}{item.kind}"
        told = [("capacity", item.capacity), ("forget", item.forget)]
        tail = "".join(f" {word} {self._n.expr(value)}" for word, value in told if value is not None)
        if not item.fields_:
            return Laid([Piece(head + tail, 0)])
        fields = [self._field(field) for field in item.fields_]
        pieces = [Piece(f"{head} {{", 0)]
        pieces += [_placed(f"{text},", field) for text, field in zip(fields, item.fields_)]
        pieces.append(Piece(f"}}{tail}", 0, item.span.end - 1, item.span.end))
        return Laid(pieces, self._filled(f"{head} {{ ", fields, tail))

    def _filled(self, opened: str, fields: list[str], tail: str = "") -> str:
        filled = self._w.fill([(text, None) for text in fields], len(opened), len(opened), 2 + len(tail))
        return f"{opened}{filled} }}{tail}"

    def _type(self, kind: str) -> str:
        return self._n.unit(kind) if is_unit(kind) else self._n.name(kind)

    def _shape(self, item: ast.Shape, columns: Columns) -> Laid:
        head = f"{self._titled('shape', item.name, item.text)} = "
        head += f"{self._n.name(item.base)} with {{" if item.base else "{"
        fields = [self._field(field) for field in item.fields_]
        pieces = [Piece(head, 0), *(_placed(f"{text},", field) for text, field in zip(fields, item.fields_))]
        pieces.append(Piece("}", 0, item.span.end - 1, item.span.end))
        return Laid(pieces, self._filled(f"{head} ", fields))

    def _field(self, field: ast.Field) -> str:
        text = f"{self._n.name(field.name)}: {self._type(field.type)}"
        text += " increasing" if field.increasing else ""
        text += "" if field.range is None else f" {self._range(field.range)}"
        return text + ("" if field.default is None else f" default {self._n.expr(field.default)}")

    def _table(self, item: ast.Table, columns: Columns) -> Laid:
        head = f"table {self._n.name(item.name)}({self._n.name(item.argument)}: {self._n.unit(item.unit)}"
        if item.second is not None:
            head += f", {self._n.name(item.second.name)}: {self._n.unit(item.second.unit)}"
        head += f") -> {self._n.unit(item.result)} = {', '.join(map(self._way, item.ways))}"
        rows = self._rows(item)
        pieces = [Piece(head, 0)]
        if len(rows) > len(item.rows) and item.second is not None:
            pieces.append(_placed(rows[0], item.second))
        pieces += [_between(text, (row[0], row[-1])) for text, row in zip(rows[-len(item.rows) :], item.rows)]
        pieces[-1] = pieces[-1]._replace(text=f"{pieces[-1].text} |")
        if item.second is None:
            filled = self._w.fill([(row, None) for row in rows], 2, 2, 2, "")
        else:  # as a data sheet has it, whatever its width
            filled = new_line(2).join(rows)
        compact = f"{head}{new_line(2)}{filled} |"
        if item.source is not None:
            source = f"source {quoted(item.source)}"
            pieces.append(Piece(source, 2, item.span.end - len(quoted(item.source)), item.span.end))
            compact += new_line(2) + source
        return Laid(pieces, compact)

    def _way(self, way: ast.Way) -> str:
        length = "" if way.length is None else f" {self._n.expr(way.length)}"
        return f"{way.reading}{way.outside and ' '}{way.outside}{length}"

    def _rows(self, item: ast.Table) -> list[str]:
        """`| knot: value`; of a table of two arguments in columns, below the row of the second one's knots."""
        texts = [[self._n.expr(cell) for cell in row] for row in item.rows]
        if item.second is None:
            return [f"| {row[0]}: {', '.join(row[1:])}" for row in texts]
        if item.second.knots:
            texts.insert(0, [self._n.name(item.second.label), *map(self._n.expr, item.second.knots)])
        heads = [f"{row[0]}:" for row in texts]
        lines = [[head, *(f"{cell}," for cell in row[1:-1]), row[-1]] for head, row in zip(heads, texts)]
        widths = [
            max(len(line[at]) for line in lines if at < len(line)) for at in range(max(map(len, lines)))
        ]
        return [
            "| " + " ".join(cell.ljust(widths[at]) for at, cell in enumerate(line)).rstrip() for line in lines
        ]

    def _place(self, item: ast.Place, columns: Columns) -> Laid:
        head = self._titled(item.kind, item.name, item.text) + (" = polygon" if item.kind == "zone" else " =")
        points = [f"({self._n.expr(x)}, {self._n.expr(y)})" for x, y in item.points]
        pieces = [Piece(head, 0), *(_between(text, point) for text, point in zip(points, item.points))]
        flat = f"{head} {' '.join(points)}"
        filled = new_line(2) + self._w.fill([(point, None) for point in points], 2, 2, 0, "")
        return Laid(pieces, flat if len(flat) <= WIDTH else head + filled)

    def _stretch(self, item: ast.Stretch, columns: Columns) -> str:
        head = f"{self._titled('stretch', item.name, item.text)} on {self._n.expr(item.line, POSTFIX)} ="
        ends = f"{self._n.expr(item.start, SUM)} to {self._n.expr(item.end, SUM)}"
        return (
            f"{head} {ends}" if end_column(head, 0) + 1 + len(ends) <= WIDTH else f"{head}{new_line(2)}{ends}"
        )

    # Declarations with clauses --------------------------------------------------------------------------------

    def _assume(self, item: ast.Assume, columns: Columns) -> Laid:
        return self._with_clauses(self._titled("assume", item.name, item.title), item.clauses)

    def _rule(self, item: ast.Rule, columns: Columns) -> Laid:
        return self._with_clauses(self._titled("rule", item.name, item.title), item.clauses)

    def _with_clauses(self, head: str, clauses: tuple[ast.Clause, ...]) -> Laid:
        return Laid([Piece(head, 0), *(_placed(self.clause(clause), clause) for clause in clauses)])

    def clause(self, clause: ast.Clause) -> str:
        """A clause of a rule or an assumption; raises TypeError for a node that has no layout."""
        handler = _CLAUSES.get(type(clause))
        if handler is None:
            raise TypeError(f"no layout for a {type(clause).__name__}")
        keyword, body = handler(self, clause)
        return keyword.ljust(CLAUSE_COLUMN - 2) + body

    def _satisfies(self, clause: ast.Satisfies) -> tuple[str, str]:
        return "satisfies", self._ids(clause.ids)

    def _assuming(self, clause: ast.Assuming) -> tuple[str, str]:
        return "assuming", self._ids(clause.ids)

    def _ids(self, ids: tuple[ast.Name, ...]) -> str:
        return self._w.fill(
            [(self._n.name(name.name), None) for name in ids], CLAUSE_COLUMN, CLAUSE_COLUMN, 0
        )

    def _source(self, clause: ast.SourceClause) -> tuple[str, str]:
        if clause.reference is None:
            return "source", quoted(clause.locator)
        name = self._n.name(clause.reference.name)
        if clause.quoted:
            return "source", f"{name} {quoted(clause.locator)}"
        word, blank, numbers = clause.locator.partition(" ")
        return "source", f"{name} {self._n.name(word)}{blank}{numbers}".rstrip()

    def _because(self, clause: ast.Because) -> tuple[str, str]:
        return "because", quoted(clause.text)

    def _severity(self, clause: ast.Severity) -> tuple[str, str]:
        return "severity", self._n.name(clause.word)

    def _allow(self, clause: ast.Allow) -> tuple[str, str]:
        codes = self._ids(clause.codes)
        return "allow", self._w.append(
            codes, CLAUSE_COLUMN, f"because {quoted(clause.reason)}", CLAUSE_COLUMN + 2, 1
        )

    def _evidence(self, clause: ast.Evidence) -> tuple[str, str]:
        return "evidence", quoted(clause.path)

    def _owner(self, clause: ast.Owner) -> tuple[str, str]:
        return "owner", quoted(clause.text)

    def _bind(self, clause: ast.Bind) -> tuple[str, str]:
        text = self._n.bound(clause)
        if clause.where is not None:
            text = self._w.where(text, clause.where, CLAUSE_COLUMN, CLAUSE_COLUMN + 2, 0)
        if clause.by is not None:  # wider than the column of clauses
            return f"{self._n.quantifier(clause)} ", text
        return self._n.sign(clause.quantifier), text

    def _except(self, clause: ast.Except) -> tuple[str, str]:
        text = self._w.lay(clause.condition, EXPRESSION, CLAUSE_COLUMN)
        return "except", self._w.append(text, CLAUSE_COLUMN, quoted(clause.reason), CLAUSE_COLUMN + 2)

    def _let(self, clause: ast.Let) -> tuple[str, str]:
        head = f"{self._n.name(clause.name)} = "
        return "let", head + self._w.lay(clause.value, EXPRESSION, CLAUSE_COLUMN + len(head))

    def _along(self, clause: ast.Along) -> tuple[str, str]:
        at = "" if clause.at is None else f" at {self._n.name(clause.at.name)}"
        return "along", f"{self._n.name(clause.signal.name)} as {self._n.name(clause.name)}{at}"

    def _whenever(self, clause: ast.Whenever) -> tuple[str, str]:
        return "whenever", self._w.lay(clause.condition, EXPRESSION, CLAUSE_COLUMN)

    def _within(self, clause: ast.WithinTime) -> tuple[str, str]:
        return "within", self._w.lay(clause.bound, SUM, CLAUSE_COLUMN)

    def _require(self, clause: ast.Require) -> tuple[str, str]:
        return clause.keyword, self._w.lay(clause.condition, EXPRESSION, CLAUSE_COLUMN)

    def _state(self, item: ast.State, columns: Columns) -> Laid:
        states = ", ".join(map(self._state_name, item.states))
        head = f"state {self._n.name(item.name)} : {{ {states} }}"
        if item.binder:
            head += f" for each {self._n.name(item.binder)} {self._n.sign('in')} {self._n.name(item.domain)}"
        head += f" starts {self._n.name(item.start.name)}"
        if item.bridges is not None:
            head += f" bridges {self._n.expr(item.bridges, SUM)}"
        pieces = [Piece(head, 0)]
        width = _widest(self._n.name(one.target.name) for one in item.transitions)
        for one in item.transitions:
            origin = f"from {self._n.names(tuple(name.name for name in one.sources))} " if one.sources else ""
            lead = f"becomes {self._n.name(one.target.name).ljust(width)} {origin}when "
            text = lead + self._w.lay(one.condition, EXPRESSION, 2 + len(lead))
            end = one.condition.__dict__["span"].end if one.kept else one.span.end
            pieces.append(Piece(text, 2, one.span.start, end))
            for keep in one.kept:
                start = f"  remember {self._n.name(keep.name)} = "
                pieces.append(_placed(start + self._w.lay(keep.value, SUM, 2 + len(start)), keep))
        return Laid(pieces)

    def _state_name(self, name: ast.StateName) -> str:
        return f"{'final ' if name.final else ''}{self._n.name(name.name)}"

    def _rulebook(self, item: ast.Rulebook, columns: Columns) -> Laid:
        pieces = [Piece(self._titled("rulebook", item.name, item.title), 0)]
        if item.base is not None:
            pieces.append(_placed(f"{item.base.how} {self._n.name(item.base.name.name)}", item.base))
        for number, chain in enumerate(item.chains):
            names = [self._n.name(name.name) for name in chain.names]
            parts = names[:1] + [f"{relation} {name}" for relation, name in zip(chain.relations, names[1:])]
            comma = "," if number < len(item.chains) - 1 else ""
            text = self._w.fill([(part, None) for part in parts], 2, 4, len(comma), "")
            pieces.append(_placed(text + comma, chain))
        return Laid(pieces)

    def _test(self, item: ast.Test, columns: Columns) -> Laid:
        pieces = [Piece(self._titled("test", item.rule, item.title), 0)]
        pieces += [_placed(self._step(step), step) for step in item.steps]
        return Laid([*pieces, _placed(self._expect(item.expect), item.expect)])

    def _step(self, step: ast.Given | ast.After) -> str:
        return f"after  {self._n.expr(step.time, SUM)}" if isinstance(step, ast.After) else self._given(step)

    def _given(self, given: ast.Given) -> str:
        start = f"given  {self._n.name(given.name)} = "
        text = start + self._w.value(given.value, 2 + len(start), 2)
        if not given.changes:
            return text
        changes: list[tuple[str, ast.Expr | None]] = []
        for change in given.changes:
            index = "" if change.index is None else f"[{change.index}]"
            changes.append((f"{self._n.name(change.field)}{index} = {self._n.expr(change.value, SUM)}", None))
        flat = ", ".join(prefix for prefix, _ in changes)
        if end_column(text, 2) + len(" with ") + len(flat) <= WIDTH:
            return f"{text} with {flat}"
        indent = TEST_COLUMN + 2
        return f"{text}{new_line(indent)}with " + self._w.fill(changes, indent + 5, indent + 5, 0)

    def _expect(self, expect: ast.Expect) -> str:
        parts = [f"expect {self._n.name(expect.verdict)}"]
        if expect.margin is not None:
            margin = self._n.expr(expect.margin, SUM)
            about = "about " if expect.tolerance is not None or margin.startswith("about") else ""
            within = "" if expect.tolerance is None else f" within {self._n.expr(expect.tolerance, SUM)}"
            parts.append(f"margin {about}{margin}{within}")
        if expect.binder is not None:
            parts.append(f"at {self._n.name(expect.binder)} = {expect.at}")
        return self._w.fill([(part, None) for part in parts], 2, TEST_COLUMN, 0)


def _widest(texts: Iterable[str]) -> int:
    return max((len(text) for text in texts if len(text) <= WIDEST), default=0)


def _placed(text: str, node: Node) -> Piece:
    span = node.__dict__["span"]
    return Piece(text, 2, span.start, span.end)


def _between(text: str, pair: tuple[ast.Expr, ast.Expr]) -> Piece:
    return Piece(text, 2, pair[0].__dict__["span"].start, pair[1].__dict__["span"].end)


_ITEMS: dict[type[ast.Item], Callable[[Layout, Any, Columns], Laid | str]] = {
    ast.ModuleName: Layout._module, ast.Use: Layout._use, ast.Reference: Layout._reference, ast.Enum: Layout._enum, ast.Course: Layout._course, ast.Event: Layout._event,
    ast.Param: Layout._param, ast.ParamRecord: Layout._param_record, ast.Constrain: Layout._constrain, ast.Scale: Layout._scale, ast.Define: Layout._define, ast.Shape: Layout._shape, ast.Signal: Layout._signal,
    ast.Table: Layout._table, ast.Place: Layout._place, ast.Stretch: Layout._stretch, ast.Assume: Layout._assume, ast.Rule: Layout._rule,
    ast.State: Layout._state, ast.Rulebook: Layout._rulebook, ast.Test: Layout._test,
}  # fmt: skip

_CLAUSES: dict[type[ast.Clause], Callable[[Layout, Any], tuple[str, str]]] = {
    ast.Satisfies: Layout._satisfies, ast.Assuming: Layout._assuming, ast.SourceClause: Layout._source,
    ast.Because: Layout._because, ast.Severity: Layout._severity, ast.Evidence: Layout._evidence, ast.Owner: Layout._owner,
    ast.Bind: Layout._bind, ast.Except: Layout._except, ast.Let: Layout._let, ast.Along: Layout._along,
    ast.Allow: Layout._allow, ast.Whenever: Layout._whenever, ast.WithinTime: Layout._within, ast.Require: Layout._require,
}  # fmt: skip
