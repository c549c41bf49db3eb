"""The typed tree back to the syntax tree that it was made of: what is lost on the way is missing here."""

from __future__ import annotations

from typing import Any, assert_never

from trackmarshal import typed
from trackmarshal.node import Node
from trackmarshal.syntax import ast


def called(function: str, *args: Any) -> ast.Call:
    return ast.Call(function, tuple(map(written, args)), ("",) * len(args))


def call_of(node: typed.CalledNumber | typed.CalledFormula) -> ast.Expr:
    """A call, whose body has to be the definition's own."""
    assert isinstance(node.symbol.item, ast.Define)
    assert written(node.body) == plain(node.symbol.item.body)
    name = node.symbol.name
    return called(name, *node.arguments) if node.symbol.item.parameters else ast.Name(name)


def machine(node: typed.Machine) -> ast.Expr:
    """What is asked for its state, whose guards have to be those of its declaration."""
    item = node.symbol.item
    assert isinstance(item, ast.State)
    assert [written(one.guard) for one in node.transitions] == [
        plain(one.condition) for one in item.transitions
    ]
    assert item.bridges is not None or not node.bridges
    for made, one in zip(node.transitions, item.transitions):
        assert [written(keep.value) for keep in made.kept] == [plain(keep.value) for keep in one.kept]
    if node.element is None:
        return ast.Name(node.symbol.name)
    assert isinstance(node.element, typed.NamedRecord)
    assert node.element.value is not None
    return called(node.symbol.name, node.element.value)


def window_of(window: typed.Window | None) -> ast.Window | None:
    return None if window is None else ast.Window(written(window.lower), written(window.upper))


def bound(range_: typed.Range) -> dict[str, Any]:
    consecutive = len(range_.names) > 1
    return {"consecutive": consecutive, "names": range_.names, "domain": written(range_.domain)}


def written(node: typed.Value) -> ast.Expr:
    """The expression of a typed one, infix calls as plain ones."""
    match node:
        case typed.NumberNode():
            return number(node)
        case typed.FormulaNode():
            return formula(node)
        case typed.MemberNode():
            return member(node)
        case typed.Count():
            return count(node)
        case _:
            return thing(node)


def member(node: typed.AnyMember) -> ast.Expr:
    match node:
        case typed.MemberField():
            return ast.Attribute(written(node.record), node.name)
        case typed.Member() | typed.NamedMember():
            return ast.Name(node.name)
        case _:
            assert_never(node)


def case_of(node: typed.NumberCase | typed.FormulaCase) -> ast.Expr:
    branches = [
        ast.Branch(() if one.rest else tuple(map(ast.Member, one.members)), written(one.value))
        for one in node.branches
    ]
    return ast.Case(member(node.subject), tuple(branches))


def number(node: typed.Number) -> ast.Expr:
    match node:
        case typed.Literally():
            return ast.Number(node.text, node.unit)
        case typed.Pi():
            return ast.Name("pi")
        case typed.Parameter():
            record = node.symbol.item
            name = ast.Name(node.symbol.name)
            return (
                ast.Attribute(ast.Name(record.name), name.name)
                if isinstance(record, ast.ParamRecord)
                else name
            )
        case typed.Field():
            return ast.Attribute(written(node.record), node.name)
        case typed.Negative():
            return ast.Unary("-", number(node.operand))
        case typed.Arithmetic():
            return ast.Binary(node.op, number(node.left), number(node.right))
        case typed.Power():
            return ast.Binary("^", number(node.base), number(node.exponent))
        case typed.Function():
            return called(node.name, *node.arguments)
        case typed.Choice():
            return ast.IfElse(formula(node.condition), number(node.then), number(node.otherwise))
        case typed.NumberCase():
            return case_of(node)
        case typed.TableValue():
            return called(node.symbol.name, *node.arguments)
        case typed.OnLine():
            return called(node.function, node.point, node.line)
        case typed.StationGap():
            return called("station_gap", node.line, node.start, node.end)
        case typed.Kept():
            asked = machine(node.machine)
            return ast.Attribute(asked, node.name) if node.name else ast.Call("time_in", (asked,), ("",))
        case typed.Folded():
            return ast.Folded(
                function=node.op, body=None if node.body is None else number(node.body), **bound(node.range),
                where=None if node.where is None else formula(node.where),
                otherwise=None if node.otherwise is None else number(node.otherwise),
            )  # fmt: skip
        case typed.CalledNumber():
            return call_of(node)
        case typed.NamedNumber():
            return ast.Name(node.name)
        case _:
            assert_never(node)


def formula(node: typed.Formula) -> ast.Expr:
    match node:
        case typed.Boolean():
            return ast.Boolean(node.value)
        case typed.Event():
            return ast.Name(node.symbol.name)
        case typed.BooleanField():
            return ast.Attribute(written(node.record), node.name)
        case typed.Comparison():
            return ast.Binary(node.op, number(node.left), number(node.right))
        case typed.Connective():
            return ast.Binary(node.op, formula(node.left), formula(node.right))
        case typed.Chained():
            return ast.Chained(tuple(map(number, node.operands)), node.ops)
        case typed.Within():
            return ast.Within(number(node.value), number(node.lower), number(node.upper))
        case typed.InZone():
            return ast.InZone(written(node.point), node.zone.symbol.name)
        case typed.InStretch() if node.symbol is not None:
            return ast.InStretch(written(node.place), node.symbol.name)
        case typed.InStretch():
            return ast.BetweenStations(
                written(node.place), written(node.line), number(node.start), number(node.end)
            )
        case typed.Inside():
            return called("inside", node.region, node.area)
        case typed.Meets():
            return called("meets", node.region, node.area)
        case typed.ClearOf():
            return called("clear_of", node.region, node.other)
        case typed.Not():
            return ast.Unary("not", formula(node.operand))
        case typed.Quantified():
            where = None if node.where is None else formula(node.where)
            return ast.Quantified(
                quantifier=node.quantifier, **bound(node.range), where=where, body=formula(node.body),
                by=None if node.by is None else number(node.by),
            )  # fmt: skip
        case typed.Temporal():
            return ast.Temporal(node.op, formula(node.operand), window_of(node.window))
        case typed.Step():
            return ast.Temporal(node.op, formula(node.operand), None, node.weak)
        case typed.Until():
            return ast.Until(node.op, formula(node.left), formula(node.right), window_of(node.window))
        case typed.Edge():
            return called(node.op, node.operand)
        case typed.CountComparison():
            counted, limit = count(node.count), number(node.limit)
            return ast.Binary(node.op, *((limit, counted) if node.turned else (counted, limit)))
        case typed.InState():
            return ast.Call("is", (machine(node.machine), ast.Name(node.state)), ("", ""))
        case typed.IsMember():
            return ast.Call("is", (member(node.left), member(node.right)), ("", ""))
        case typed.FormulaCase():
            return case_of(node)
        case typed.CalledFormula():
            return call_of(node)
        case typed.NamedFormula():
            return ast.Name(node.name)
        case _:
            assert_never(node)


def count(node: typed.Count) -> ast.Expr:
    arguments, names = [formula(node.counted)], [""]
    if node.window is not None:
        arguments.append(written(node.window.upper))
        names.append("last")
    if node.reset is not None:
        arguments.append(formula(node.reset))
        names.append("reset")
    return ast.Call("count", tuple(arguments), tuple(names))


def thing(node: typed.WholeSignal | typed.Record | typed.Line | typed.Area | typed.Region) -> ast.Expr:
    match node:
        case (
            typed.Variable()
            | typed.NamedSignal()
            | typed.NamedRecord()
            | typed.NamedLine()
            | typed.NamedArea()
        ):
            return ast.Name(node.name)
        case typed.NamedRegion():
            return ast.Name(node.name)
        case typed.ParameterRecord():
            return ast.Name(node.symbol.name)
        case typed.Signal() | typed.State() | typed.SignalLine():
            return ast.Name(node.signal.name)
        case typed.Sample():
            return ast.Attribute(thing(node.of), "first" if node.index == 0 else "last")
        case typed.LaneSide():
            return ast.Attribute(thing(node.of), node.field)
        case typed.Border():
            return ast.Attribute(thing(node.of), node.field)
        case typed.PlacedLine() | typed.Zone():
            return ast.Name(node.symbol.name)
        case typed.Path() | typed.Centre() | typed.Corridor() | typed.Lane():
            return thing(node.of)
        case typed.CalledLine():
            return called(node.function, node.line)
        case typed.Footprint():
            return called("footprint", node.body)
        case typed.FootprintAt():
            return called("footprint", node.pose, node.length, node.width)
        case typed.SweptSample():
            return called(node.function, node.sample, node.length, node.width)
        case typed.Swept():
            return called("swept", node.start, node.end, node.length, node.width)
        case _:
            assert_never(node)


def clause(node: typed.Clause) -> ast.Clause:
    match node:
        case typed.Along():
            (name,) = node.range.names
            at = ast.Name(node.place) if node.said else None
            return ast.Along(ast.Name(node.range.signal.name), name, at)
        case typed.Whenever():
            return ast.Whenever(formula(node.condition))
        case typed.Deadline():
            return ast.WithinTime(number(node.limit))
        case typed.ForEach():
            where = None if node.where is None else formula(node.where)
            by = None if node.by is None else number(node.by)
            return ast.Bind(quantifier=node.quantifier, **bound(node.range), where=where, by=by)
        case typed.Except():
            return ast.Except(formula(node.condition), node.reason)
        case typed.Let():
            return ast.Let(node.name, written(node.value))
        case typed.Require():
            return ast.Require(node.keyword, formula(node.condition))
        case _:
            assert_never(node)


def plain(node: Any) -> Any:
    """A syntax tree with infix calls as plain ones, which is all that is not compared."""
    if isinstance(node, tuple):
        return tuple(map(plain, node))
    if not isinstance(node, Node):
        return node
    if isinstance(node, ast.Infix):
        return ast.Call(node.predicate, (plain(node.left), plain(node.right)), ("", ""))
    return type(node)(**{name: plain(node.__dict__[name]) for name in node.compared})


#: The clauses that a rule's meaning is made of.
MEANT = (ast.Bind, ast.Except, ast.Let, ast.Along, ast.Whenever, ast.WithinTime, ast.Require)


def differences(rule: typed.Rule, item: ast.Rule | ast.Assume) -> list[str]:
    """Where the clauses of a typed rule are not those of its syntax tree, in their order."""
    wanted = [plain(part) for part in item.clauses if isinstance(part, MEANT)]
    found = [clause(part) for part in rule.clauses]
    return [f"{a}\n{b}" for a, b in zip(found, wanted) if a != b] + ["length"] * (len(found) != len(wanted))
