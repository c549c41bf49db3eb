"""A rule evaluated as it is printed: MathML alone says what it demands, the values are those of a case.

A rule over the run is evaluated in the first cycle of a run, which is its last one, too: state machines take one step, windows hold one cycle.
Places along lines and whether what is swept lies somewhere are asked of the reference: that is geometry, not what is printed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

from support.mathml import Parser, Tree, read
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo

UNITS = {
    "": (1.0, 1.0), "m": (1.0, 1.0), "s": (1.0, 1.0), "m/s": (1.0, 1.0), "km/h": (1000.0, 3600.0), "m/s^2": (1.0, 1.0), "m^2/s^2": (1.0, 1.0), "rad": (1.0, 1.0),
    "ms": (1.0, 1000.0), "1/m": (1.0, 1.0), "%": (1.0, 100.0), "kg": (1.0, 1.0), "kg/m": (1.0, 1.0),
}  # fmt: skip


class Said(NamedTuple):
    """Whether something holds (None: nobody knows), and by how much."""

    sat: bool | None
    margin: float


class Element(NamedTuple):
    """A record of a signal: which one, 0 of a single one."""

    signal: str
    place: int


# Each formula is read once for all cases.


@cache
def _whole(mathml: str) -> Tree:
    return Parser(read(mathml)).whole()


@cache
def _equation(mathml: str) -> tuple[Tree, str, Tree]:
    return Parser(read(mathml)).equation()


@cache
def _quantified(mathml: str) -> Tree:
    return Parser(read(mathml)).quantified(False)


class Machinery:
    """One rule as printed (`data`), and one case in SI.

    undefined: whether something was undefined on the way; margins are then between two cases, which this does not follow.
    """

    def __init__(
        self, printed: dict[str, Any], rule: RuleInfo, values: Reference, case: dict[str, Any]
    ) -> None:
        self.printed, self.rule, self.values, self.case = printed, rule, values, case
        self.undefined = False
        self.functions: dict[str, tuple[list[str], Tree]] = {}
        for one in printed["definitions"]:
            head, _, body = _equation(one["mathml"])
            names = [part[1] for part in head[2]] if head[0] == "called" else []
            self.functions[head[1]] = (names, body)
        # By the whole name where something else is called so beside it, such as what a definition is given.
        self.params = {
            name: one["value"] for one in printed["parameters"] for name in (one["name"], _short(one["name"]))
        }
        self.params |= case.get("params", {})
        self.tables = {one["name"].rpartition(".")[2]: one["rows"] for one in printed["tables"]}
        self.machines = {_whole(one["mathml"])[1]: one for one in printed["machines"]}
        assert rule.formula is not None
        self.nodes = list(ir.below(rule.formula))

    # The rule ------------------------------------------------------------------------------------------------

    def verdict(self) -> tuple[str, float]:
        """The rule's verdict, and its margin where nothing was undefined."""
        said, active = self._clauses(self.printed["clauses"], {})
        if not active:
            return "inactive", math.inf
        if said.sat is None:
            return "undefined", math.nan
        return ("satisfied" if said.sat else "violated"), said.margin

    def _clauses(self, clauses: Sequence[dict[str, Any]], env: dict[str, Any]) -> tuple[Said, bool]:
        """What is demanded below a clause, and whether it applies to anything."""
        first, *others = clauses
        row = first["mathml"]
        match first["kind"]:
            case "whenever":
                guard = self.truth(_whole(row), env)
                assert guard.sat is not None
                return self._clauses(others, env) if guard.sat else (Said(True, math.inf), False)
            case "let":
                head, _, body = _equation(row)
                return self._clauses(others, {**env, head[1]: ("let", body, env)})
            case "require" | "monitor":
                return self.truth(_whole(row), env), True
            case "each":
                return self._each(_quantified(row), others, env)
            case kind:
                raise AssertionError(kind)

    def _each(
        self, quantifier: Tree, others: Sequence[dict[str, Any]], env: dict[str, Any]
    ) -> tuple[Said, bool]:
        _, sign, names, domain, _, _ = quantifier
        guards = []
        while others[0]["kind"] in ("where", "except"):
            guards.append((others[0]["kind"] == "where", _whole(others[0]["mathml"])))
            others = others[1:]
        found = []
        for inner in self._bound(names, domain, env):
            held = [self.truth(guard, inner) for _, guard in guards]
            if any(one.sat is None for one in held):
                self.undefined = True
            if all(one.sat is wanted for one, (wanted, _) in zip(held, guards)):
                found.append(self._clauses(others, inner))
        said = [one for one, _ in found]
        if sign == "∀":
            return _least(said), any(active for _, active in found)
        return _greatest(said), True

    def _bound(self, names: Sequence[str], domain: str, env: dict[str, Any]) -> list[dict[str, Any]]:
        count = self._count(domain)
        return [
            {**env, **{name: Element(domain, k + offset) for offset, name in enumerate(names)}, "": {**env.get("", {}), names[0]: k}}
            for k in range(count - len(names) + 1)
        ]  # fmt: skip

    def _count(self, domain: str) -> int:
        signal = self.case["signals"][domain]
        return len(signal) if isinstance(signal, list) else len(next(iter(signal.values())))

    # Formulas ------------------------------------------------------------------------------------------------

    def truth(self, tree: Tree, env: dict[str, Any]) -> Said:
        match tree[0]:
            case "truth":
                return Said(tree[1], math.inf if tree[1] else -math.inf)
            case "joined":
                left, right = self.truth(tree[2], env), self.truth(tree[3], env)
                return _joined(tree[1], left, right)
            case "not":
                return _not(self.truth(tree[1], env))
            case "quantified":
                _, sign, names, domain, where, body = tree
                each = [
                    self.truth(body, inner)
                    for inner in self._bound(names, domain, env)
                    if self._holds(where, inner)
                ]
                return _least(each) if sign == "∀" else _greatest(each)
            case "between":
                value, lower, upper = (self.number(part, env) for part in tree[1:])
                return _joined("∧", self._compared("≤", lower, value), self._compared("≤", value, upper))
            case "compared":
                return self._chain(tree[1], tree[2], env)
            case "window":
                _, operator, lower, _, operand = tree
                said = self.truth(operand, env)
                if self.number(lower, env) <= 0.0:
                    return said
                return _least([]) if operator in ("always", "historically") else _greatest([])
            case "step":
                self.truth(tree[2], env)
                return _least([]) if tree[1].startswith("weak") else _greatest([])
            case "called" if tree[1] in ("rising", "falling"):
                said = self.truth(tree[2][0], env)
                return said if tree[1] == "rising" else _not(said)
            case "in zone":
                return self._in_zone(tree[1], env)
            case "called":
                if tree[1] in self.functions:
                    return self.truth(self.functions[tree[1]][1], self._given(tree, env))
                raise AssertionError(tree)
            case "field":
                value = self._field(tree, env)
                assert isinstance(value, bool)
                return Said(value, math.inf if value else -math.inf)
            case "name":
                return self._named_truth(tree[1], env)
            case _:
                raise AssertionError(tree)

    def _holds(self, where: Tree | None, env: dict[str, Any]) -> bool:
        if where is None:
            return True
        said = self.truth(where, env)
        if said.sat is None:
            self.undefined = True
        return said.sat is True

    def _named_truth(self, name: str, env: dict[str, Any]) -> Said:
        if name in self.functions:
            return self.truth(self.functions[name][1], {"": env.get("", {})})
        value = self.case["signals"][name]
        assert isinstance(value, bool)
        return _known(value)

    def _chain(self, operands: list[Tree], relations: list[str], env: dict[str, Any]) -> Said:
        if relations == ["⊆"]:
            return self._asked(ir.SweptInside, env)
        if relations == ["clear of"]:
            return self._asked(ir.SweptClear, env)
        if operands[0][0] in ("called", "name") and operands[0][1] in self.machines:
            return _known(self._state(operands[0], env)[0]["state"] == operands[1][1])
        if relations == ["∈"]:
            return self._in_stretch(operands[0], operands[1], env)
        if relations[0] in self.functions:  # o behind ego
            return self.truth(("called", relations[0], operands), env)
        numbers = [self.number(one, env) for one in operands]
        said = [self._compared(sign, a, b) for sign, a, b in zip(relations, numbers, numbers[1:])]
        return _least(said)

    def _state(self, tree: Tree, env: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """In which state a machine is after the first cycle, and what its own name stands for."""
        machine = self.machines[tree[1]]
        inner: dict[str, Any] = {"": env.get("", {})}
        if tree[0] == "called":
            (own,) = _whole(machine["mathml"])[2]
            inner[own[1]] = self._record(tree[2][0], env)
        for move in machine["moves"]:
            if machine["start"] in move["from"]:
                said = self.truth(_whole(move["when"]["mathml"]), inner)
                assert said.sat is not None
                if said.sat:
                    return {"state": move["to"], "kept": move["remembers"]}, inner
        return {"state": machine["start"], "kept": []}, inner

    def _kept(self, name: str, tree: Tree, env: dict[str, Any]) -> float:
        state, inner = self._state(tree, env)
        for one in state["kept"]:
            head, _, body = _equation(one["mathml"])
            if head == ("name", name):
                return self.number(body, inner)
        return math.nan

    def _in_stretch(self, point: Tree, stretch: Tree, env: dict[str, Any]) -> Said:
        line = self._line(stretch[2][0])
        x, y = (ir.Const(float(self._field(("field", axis, point), env))) for axis in ("x", "y"))
        ends = [ir.Const(self.number(one, env)) for one in stretch[2][1:]]
        room = self.values.number(ir.StretchRoom(line, "", ir.Station(line, x, y), *ends), {})
        return self._compared("≤", 0.0, room)

    def _in_zone(self, point: Tree, env: dict[str, Any]) -> Said:
        """A rule names one zone, and may ask of several points whether they lie in it."""
        areas = {(node.area, node.span) for node in self.nodes if isinstance(node, ir.InArea)}
        assert len({area for area, _ in areas}) == 1, "which one is printed here is not known"
        area, span = next(iter(areas))
        x, y = (ir.Const(float(self._field(("field", axis, point), env))) for axis in ("x", "y"))
        value = self.values.truth(ir.InArea(x, y, area, span), {})
        if value.verdict == "undefined":
            self.undefined = True
            return Said(None, math.nan)
        return Said(value.verdict == "satisfied", value.worst.margin)

    def _compared(self, sign: str, a: float, b: float) -> Said:
        if not (math.isfinite(a) and math.isfinite(b)):
            self.undefined = True
            return Said(None, math.nan)
        match sign:
            case "<":
                return Said(a < b, b - a + 0.0)
            case "≤":
                return Said(a <= b, b - a + 0.0)
            case ">":
                return Said(a > b, a - b + 0.0)
            case "≥":
                return Said(a >= b, a - b + 0.0)
            case "=":
                return Said(a == b, -abs(a - b) + 0.0)
            case "≠":
                return Said(a != b, abs(a - b))
            case _:
                raise AssertionError(sign)

    def _asked(self, kind: type[ir.Formula], env: dict[str, Any]) -> Said:
        """A geometric predicate, of which a rule has one: its value is the reference's, at the variables as they are bound here."""
        nodes = [node for node in self.nodes if isinstance(node, kind)]
        assert len(nodes) == 1, "which one is printed here is not known"
        levels = {node.axis.level for node in self.nodes if isinstance(node, ir.Quantify)}
        bound = dict(enumerate(env.get("", {}).values()))
        assert len(bound) == len(levels)
        value = self.values.truth(nodes[0], bound)
        if value.verdict == "undefined":
            self.undefined = True
            return Said(None, math.nan)
        return Said(value.verdict == "satisfied", value.worst.margin)

    # Numbers -------------------------------------------------------------------------------------------------

    def number(self, tree: Tree, env: dict[str, Any]) -> float:
        match tree[0]:
            case "quantity":
                multiplier, divisor = UNITS[tree[2]]
                return float(tree[1]) * multiplier / divisor
            case "minus":
                return -self.number(tree[1], env)
            case "calculated":
                return _calculated(tree[1], self.number(tree[2], env), self.number(tree[3], env))
            case "power":
                return _power(self.number(tree[1], env), tree[2], lambda part: self.number(part, env))
            case "field":
                value = self._field(tree, env)
                return float(value)
            case "name":
                return self._named(tree[1], env)
            case "cases":
                return self._cases(tree[1], env)
            case "fold":
                return self._fold(tree, env)
            case "called":
                return self._called(tree, env)
            case _:
                raise AssertionError(tree)

    def _named(self, name: str, env: dict[str, Any]) -> float:
        if name in env:
            known = env[name]
            if isinstance(known, tuple) and known and known[0] == "let":
                return self.number(known[1], known[2])
            return float(known)
        if name in self.functions:
            return self.number(self.functions[name][1], {"": env.get("", {})})
        return math.pi if name == "pi" else float(self.params[name])

    def _record(self, tree: Tree, env: dict[str, Any]) -> Element:
        assert tree[0] == "name", tree
        name = tree[1]
        if name in env:
            found = env[name]
            assert isinstance(found, Element)
            return found
        signal, _, which = name.partition(".")
        if which:
            return Element(signal, 0 if which == "first" else self._count(signal) - 1)
        return Element(name, 0)

    def _field(self, tree: Tree, env: dict[str, Any]) -> Any:
        if tree[2][0] == "called" or (tree[2][0] == "name" and tree[2][1] in self.machines):
            return self._kept(tree[1], tree[2], env)
        record = self._record(tree[2], env)
        signal = self.case["signals"][record.signal]
        if isinstance(signal, list):
            return signal[record.place][tree[1]]
        value = signal[tree[1]]
        return value[record.place] if isinstance(value, list) else value

    def _given(self, tree: Tree, env: dict[str, Any]) -> dict[str, Any]:
        """What a definition is given: records as they are, numbers worked out."""
        names, _ = self.functions[tree[1]]
        inner: dict[str, Any] = {"": env.get("", {})}
        for name, part in zip(names, tree[2], strict=True):
            record = part[0] == "name" and (
                isinstance(env.get(part[1]), Element) or part[1].partition(".")[0] in self.case["signals"]
            )
            inner[name] = self._record(part, env) if record else self.number(part, env)
        return inner

    def _called(self, tree: Tree, env: dict[str, Any]) -> float:
        _, name, given = tree
        if name in self.functions:
            return self.number(self.functions[name][1], self._given(tree, env))
        if name == "time_in":
            self._state(given[0], env)
            return 0.0
        if name == "count":  # of one cycle; whether it is counted anew from there makes no difference
            return float(self.truth(given[0], env).sat is True)
        if name in self.tables:
            return _read(self.tables[name], self.number(given[0], env))
        if name in ("station", "offset", "direction", "distance_to"):
            return self._on_line(name, given[0], given[1], env)
        if name == "station_gap":
            line = self._line(given[0])
            ends = (ir.Const(self.number(one, env)) for one in given[1:])
            return self.values.number(ir.StationGap(line, *ends), {})
        return _function(name, [self.number(one, env) for one in given])

    def _on_line(self, name: str, point: Tree, line: Tree, env: dict[str, Any]) -> float:
        x, y = (ir.Const(float(self._field(("field", axis, point), env))) for axis in ("x", "y"))
        kinds: dict[str, Callable[[ir.Line, ir.Num, ir.Num], ir.Num]] = {
            "station": ir.Station,
            "offset": ir.Offset,
            "direction": ir.Direction,
            "distance_to": ir.Distance,
        }
        return self.values.number(kinds[name](self._line(line), x, y), {})

    def _line(self, tree: Tree) -> ir.Line:
        """A line by its name: of all lines of the rule the one that is called so."""
        name, field = (tree[2][1], tree[1]) if tree[0] == "field" else (tree[1], "")
        found = [
            node
            for node in self.nodes
            if isinstance(node, ir.Line) and (node.name, node.field) == (name, field)
        ]
        assert len(set(map(str, found))) == 1, (tree, found)
        return found[0]

    def _cases(self, branches: list[tuple[Tree, Tree | None]], env: dict[str, Any]) -> float:
        for value, condition in branches:
            if condition == ("any",):
                _, _, names, domain, where, _ = value
                if not any(self._holds(where, inner) for inner in self._bound(names, domain, env)):
                    continue
                return self.number(value, env)
            said = Said(True, math.inf) if condition is None else self.truth(condition, env)
            if said.sat is None:
                return math.nan
            if said.sat:
                return self.number(value, env)
        raise AssertionError("no branch")

    def _fold(self, tree: Tree, env: dict[str, Any]) -> float:
        _, head, names, domain, where, body = tree
        found = [
            1.0 if body is None else self.number(body, inner)
            for inner in self._bound(names, domain, env) if self._holds(where, inner)
        ]  # fmt: skip
        match head:
            case "#" | "∑":
                total = 0.0
                for one in found:
                    total += one
                return total
            case "min":
                return min(found)
            case "max":
                return max(found)
            case _:
                raise AssertionError(head)


def _short(name: str) -> str:
    return name.rpartition(".")[2]


def _known(sat: bool) -> Said:
    return Said(sat, math.inf if sat else -math.inf)


def _not(said: Said) -> Said:
    return Said(None if said.sat is None else not said.sat, -said.margin + 0.0)


def _least(said: Sequence[Said]) -> Said:
    if any(one.sat is False for one in said):
        sat: bool | None = False
    else:
        sat = None if any(one.sat is None for one in said) else True
    return Said(sat, min((one.margin for one in said), default=math.inf))


def _greatest(said: Sequence[Said]) -> Said:
    return _not(_least([_not(one) for one in said]))


def _joined(sign: str, left: Said, right: Said) -> Said:
    match sign:
        case "∧":
            return _least([left, right])
        case "∨":
            return _greatest([left, right])
        case "⇒":
            return _greatest([_not(left), right])
        case "⇔":
            if left.sat is None or right.sat is None:
                return Said(None, math.nan)
            apart = 0.0 if left.margin == right.margin else abs(left.margin - right.margin)
            return Said(left.sat == right.sat, -apart + 0.0)
        case "⊕":
            return _not(_joined("⇔", left, right))
        case _:
            raise AssertionError(sign)


def _calculated(sign: str, a: float, b: float) -> float:
    match sign:
        case "+":
            return a + b
        case "−":
            return a - b
        case "·":
            return a * b
        case "/":
            if b == 0.0:
                return math.nan
            return a / b
        case _:
            raise AssertionError(sign)


def _power(base: float, exponent: Tree, number: Any) -> float:
    """A whole power is a product, as the language says; another one the library's."""
    if exponent[0] == "quantity" and exponent[1].isdigit():
        product = base
        for _ in range(int(exponent[1]) - 1):
            product *= base
        return product
    try:
        return math.pow(base, number(exponent))
    except (ValueError, OverflowError):
        return math.nan


def _function(name: str, given: list[float]) -> float:
    match name:
        case "min" | "max":
            best = given[0]
            for one in given[1:]:
                best = min(best, one) if name == "min" else max(best, one)
            return best
        case "abs":
            return abs(given[0])
        case "sign":
            return 0.0 if given[0] == 0.0 else math.copysign(1.0, given[0])
        case "sqrt":
            return math.sqrt(given[0]) if given[0] >= 0.0 else math.nan
        case "floor":
            return float(math.floor(given[0])) if math.isfinite(given[0]) else math.nan
        case "sin" | "cos" | "hypot" | "atan2":
            value: float = getattr(math, name)(*given)
            return value
        case _:
            raise AssertionError(name)


def _read(rows: list[list[str]], at: float) -> float:
    """A table of one argument, linear between its knots and clamped outside, as its rows are shown."""
    first, result = (UNITS[unit] for unit in rows[0])
    knots = [(float(x) * first[0] / first[1], float(y) * result[0] / result[1]) for x, y in rows[1:]]
    if at <= knots[0][0]:
        return knots[0][1]
    for (x0, y0), (x1, y1) in zip(knots, knots[1:]):
        if at <= x1:
            return y0 + (y1 - y0) * ((at - x0) / (x1 - x0))
    return knots[-1][1]
