"""Specs and data at random, made of `meaning`'s constructs: what is written, and what it means."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from support.fourth.meaning import (
    COMPARISONS,
    UNITS,
    Clause,
    Dim,
    Env,
    Formula,
    Num,
    Range,
    Table,
    Window,
    alike,
    arithmetic,
    cases,
    chain,
    chosen,
    comparison,
    conj,
    disj,
    edge,
    exists,
    extreme,
    field,
    flag,
    for_all,
    iff,
    implies,
    in_si,
    linked,
    literal,
    looked_up,
    many,
    member,
    minus,
    nearest,
    no,
    root,
    square,
    stepped,
    tally,
    unary,
    windowed,
    within,
)

SHADES = ("green", "yellow", "red")
M, S, KG, ONE, SPEED, ACC = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0), (1, -1, 0), (1, -2, 0)
#: Fields that are numbers, by signal.
FIELDS: dict[str, dict[str, Dim]] = {
    "plan": {"t": S, "x": M, "y": M, "heading": ONE, "v": SPEED, "a": ACC},
    "ego": {"x": M, "y": M, "heading": ONE, "v": SPEED, "mass": KG},
    "objects": {"x": M, "v": SPEED, "w": M},
    "course": {"t": S, "x": M, "y": M, "heading": ONE, "v": SPEED},
}
#: What `ego` and `plan` both have, and a course joins.
JOINED = ("x", "y", "heading", "v", "on", "tone")
_KINDS = {"plan": "trajectory", "ego": "state", "objects": "set of object"}
_PLAIN = {d: units[0] for d, units in UNITS.items()}


@dataclass(frozen=True)
class Scope:
    """What a formula sees: records by the signal that they are of; whether it may speak of other times."""

    records: tuple[tuple[str, str], ...]
    numbers: tuple[Num, ...] = ()
    formulas: tuple[Formula, ...] = ()
    time: bool = False
    ahead: bool = True

    def bound(self, names: tuple[str, ...], over: str) -> Scope:
        return replace(self, records=(*self.records, *((n, over) for n in names)))


class Writer:
    """`axis`: "alone" (one cycle), "along" (its plan), "course" (what was driven, and its plan) or "run". `exact`: numbers of which no rounding is asked."""

    def __init__(self, seed: int, axis: str, exact: bool) -> None:
        self.dice = random.Random(seed)
        self.axis, self.exact = axis, exact
        #: A cycle of a run that lacks something is a gap to all others; so it lacks nothing here.
        self.missing = 0.0 if axis in ("run", "course") else 0.04
        #: Whether rules over the run look ahead.
        self.ahead = True
        self.declared: list[str] = []
        self.units: dict[tuple[str, str], tuple[str, Fraction]] = {}
        self.named = 0
        self.scales: dict[Dim, float] = {}
        self.defaults: dict[tuple[str, str], Any] = {}
        self.definitions: list[Any] = []
        self.params: list[Num] = []
        self.tables: list[tuple[str, Table, Dim, Dim]] = []
        #: What else a rule may ask, of what it sees; None where it does not fit.
        self.asks: list[Callable[[Scope], Formula | None]] = []
        self._declare()

    # Declarations.

    def _unit(self, dim: Dim) -> tuple[str, Fraction]:
        return UNITS[dim][0] if self.exact else self.dice.choice(UNITS[dim])

    def _number(self) -> float:
        if self.exact:
            return self.dice.randint(-8, 8) / 2
        return round(self.dice.uniform(-30, 30), 1)

    def literal(self, dim: Dim) -> Num:
        if dim in UNITS:
            unit = self._unit(dim)
            size = abs(self._number())
            if not self.exact and unit[1] != 1 and unit[1] < 1:
                size = round(size / float(unit[1]), 1)
            return literal(dim, -size if self.dice.random() < 0.2 else size, unit)
        sign, power = next((1 if e > 0 else -1, (i, e)) for i, e in enumerate(dim) if e)
        step: Dim = tuple(sign if i == power[0] else 0 for i in range(3))  # type: ignore[assignment]
        rest: Dim = tuple(a - b for a, b in zip(dim, step))  # type: ignore[assignment]
        base: Dim = tuple(abs(e) for e in step)  # type: ignore[assignment]
        return arithmetic(self.literal(rest), "*" if sign > 0 else "/", literal(base, 2.0, _PLAIN[base]))

    def _declare(self) -> None:
        say = self.declared.append
        say("module m")
        say(f"enum shade {{ {', '.join(SHADES)} }}")
        for signal, kind in _KINDS.items():
            fields, parts = FIELDS[signal], []
            for name, dim in fields.items():
                unit = {"t": ("s", Fraction(1)), "heading": ("rad", Fraction(1))}.get(name) or self._unit(dim)
                self.units[signal, name] = unit
                text = f"{name}: {unit[0] or '1'}" + (" increasing" if name == "t" else "")
                if name in ("w", "mass"):
                    value = abs(self._number())
                    self.defaults[signal, name] = value
                    text += f" default {value!r}" + (f" {unit[0]}" if unit[0] else "")
                parts.append(text)
            parts += ["on: bool default true", "tone: shade default red"]
            if signal == "plan":
                parts[-2:] = ["on: bool", "tone: shade"]
            else:
                self.defaults[signal, "on"], self.defaults[signal, "tone"] = True, "red"
            say(f"signal {signal} : {kind} {{ {', '.join(parts)} }}")
        if self.dice.random() < 0.5:
            for dim in self.dice.sample([M, SPEED, ACC, S, KG], 2):
                self.scales[dim] = size = self.dice.choice([0.5, 1.0, 4.0])
                say(f"scale {_PLAIN[dim][0]} = {size!r} {_PLAIN[dim][0]}")
        for dim in (M, SPEED, ONE):
            name, unit = self._name("limit"), self._unit(dim)
            limit = literal(dim, self._number(), unit)
            say(f"param {name} : {unit[0] or '1'} = {limit.text}")
            self.params.append(replace(limit, text=name, level=5))
        for _ in range(2):
            self._table()
        for _ in range(3):
            self._definition()

    def _name(self, word: str) -> str:
        self.named += 1
        return f"{word}{self.named}"

    def _table(self) -> None:
        dim, result = self.dice.choice([M, SPEED, ONE]), self.dice.choice([M, SPEED, ACC])
        linear = not self.exact and self.dice.random() < 0.5
        outside = self.dice.choice(["", "clamp", "wrap"])
        places = sorted(self.dice.sample(range(16), self.dice.randint(2, 4)))
        period = literal(dim, 20.0, _PLAIN[dim])
        knots, texts = [], []
        for place in places:
            x, y = (
                literal(dim, float(place if outside == "wrap" else place - 8), self._unit(dim)),
                self.literal(result),
            )
            if not self.exact:
                x = literal(dim, float(place if outside == "wrap" else place - 8), _PLAIN[dim])
            knots.append((x.of({}), y.of({})))
            texts.append(f"{x.text}: {y.text}")
        name, way = self._name("table"), "linear" if linear else "step"
        outer = f" wrap {period.text}" if outside == "wrap" else f" {outside}" if outside else ""
        self.declared.append(
            f"table {name}(x: {_PLAIN[dim][0] or '1'}) -> {_PLAIN[result][0]} = {way}{outer} | {' | '.join(texts)} |"
        )
        self.tables.append((name, Table(tuple(knots), linear, outside, period.of({})), dim, result))

    def _definition(self) -> None:
        """A number or a formula of a number and a record; the number may have a default."""
        number, thing = self._name("n"), self._name("r")
        dim, signal = self.dice.choice([M, SPEED]), self.dice.choice(["ego", "objects"])
        given = Num(number, 5, dim, lambda env: float(env[number]), frozenset([number]))
        scope = Scope(((thing, signal),), (given,))
        shape, default = self._name("shape"), self.literal(dim)
        fields = [f"{n}: {_PLAIN[d][0] or '1'}" for n, d in FIELDS[signal].items()]
        self.declared.append(f"shape {shape} = {{ {', '.join([*fields, 'on: bool', 'tone: shade'])} }}")
        name, result = self._name("made"), self.dice.choice([None, M, SPEED, ACC])
        head = f"({number}: {_PLAIN[dim][0]} = {default.text}, {thing}: {shape})"
        head = f"({thing}: {shape}, {number}: {_PLAIN[dim][0]} = {default.text})"
        if result is None:
            body: Any = self.formula(scope, 2)
            self.declared.append(f"predicate {name}{head} = {body.text}")
        else:
            body = self.number(result, scope, 2)
            self.declared.append(f"define {name}{head} -> {_PLAIN[result][0]} = {body.text}")
        self.definitions.append((name, signal, thing, number, dim, default, result, body))

    def _called(self, scope: Scope, depth: int, wanted: Dim | None) -> Any:
        found = [(d, r) for d in self.definitions for r, of in scope.records if d[6] == wanted and d[1] == of]
        if not found:
            return None
        (name, _, thing, number, dim, default, _, body), given = self.dice.choice(found)
        how = self.dice.randint(0, 2)
        value = default if how == 0 else self.number(dim, scope, depth - 1)
        rest = ["", f", {value.text}", f", {number}: {value.text}"][how]

        def of(env: Env) -> Any:
            bound = env.get(given, ("", given))
            handed = {number: value.of(env)} if number in body.free else {}
            return body.of({**env, thing: bound, **handed})

        # What a definition is given and does not read is no part of what it comes to: an operator over the run is not about an element for its sake.
        names = body.free - {thing, number}
        names |= frozenset([given] if thing in body.free else []) | (
            value.free if number in body.free else frozenset()
        )
        return replace(body, text=f"{name}({given}{rest})", level=5, of=of, free=names)

    # Numbers.

    def number(self, dim: Dim, scope: Scope, depth: int) -> Num:
        leaves = [field(n, c, d) for n, of in scope.records for c, d in FIELDS[of].items() if d == dim]
        leaves += [n for n in (*scope.numbers, *self.params) if n.dim == dim]
        if depth <= 0 or self.dice.random() < 0.2:
            if leaves and self.dice.random() < 0.75:
                return self.dice.choice(leaves)
            return self.literal(dim)
        less = depth - 1
        ways = [
            "sum",
            "sum",
            "product",
            "minus",
            "abs",
            "extreme",
            "if",
            "case",
            "many",
            "called",
            "table",
            "square",
        ]
        if not self.exact:
            ways += ["quotient", "root"]
        if dim == ONE:
            ways += ["rounded", "count"]
        way = self.dice.choice(ways)
        still = replace(scope, time=scope.time and self.axis in ("along", "course"))

        def one(d: Dim = dim) -> Num:
            return self.number(d, scope, less)

        if way == "sum":
            return arithmetic(one(), self.dice.choice("+-"), one())
        if way == "product":
            factor = self.dice.choice([ONE, ONE, ONE, S, M])
            rest = (dim[0] - factor[0], dim[1] - factor[1], dim[2] - factor[2])
            if sum(map(abs, rest)) > 5:
                factor, rest = ONE, dim
            parts = [self.number(factor, scope, less), self.number(rest, scope, less)]
            self.dice.shuffle(parts)
            return arithmetic(parts[0], "*", parts[1])
        if way == "quotient":
            divisor = self.dice.choice([ONE, S, M, SPEED])
            rest = (dim[0] + divisor[0], dim[1] + divisor[1], dim[2] + divisor[2])
            if sum(map(abs, rest)) > 5:
                divisor, rest = ONE, dim
            return arithmetic(self.number(rest, scope, less), "/", self.number(divisor, scope, less))
        if way == "root" and sum(map(abs, dim)) <= 2:
            return root(one((2 * dim[0], 2 * dim[1], 2 * dim[2])))
        if way == "square" and all(e % 2 == 0 for e in dim):
            return square(one((dim[0] // 2, dim[1] // 2, dim[2] // 2)))
        if way == "minus":
            return minus(one())
        if way == "abs":
            return unary("abs", one())
        if way == "rounded":
            word = self.dice.choice(["floor", "ceil", "round", "sign"])
            return unary(word, one(self.dice.choice([M, SPEED]) if word == "sign" else ONE))
        if way == "extreme":
            return extreme(self.dice.choice(["min", "max"]), [one() for _ in range(self.dice.randint(2, 3))])
        if way == "if":
            return chosen(self.formula(still, less), one(), one())
        if way == "case":
            name = self.dice.choice(scope.records)[0]
            named = self.dice.sample(SHADES, self.dice.randint(1, 3))
            branches = {shade: one() for shade in named}
            if len(named) < 3:
                branches["else"] = one()
            return cases(name, "tone", branches)
        if way == "called":
            made = self._called(scope, depth, dim)
            return made if made is not None else one()
        if way == "table":
            fitting = [t for t in self.tables if t[3] == dim]
            if fitting:
                name, table, of, _ = self.dice.choice(fitting)
                return looked_up(name, table, dim, self.number(of, scope, less))
        if way in ("many", "count") and len(scope.records) < 4:
            rng, inner = self._range(replace(scope, time=still.time), less, pairs=way == "many")
            if way == "count":
                return many("count", rng, self.literal(ONE))
            word = self.dice.choice(["sum", "min", "max"])
            instead = None if word == "sum" else one()
            if rng.over == "plan" and rng.where is None and len(rng.names) < 3 and self.dice.random() < 0.5:
                instead = None
            return many(word, rng, self.number(dim, inner, less), instead)
        return one()

    # Formulas.

    def _range(self, scope: Scope, depth: int, over: str = "", pairs: bool = True) -> tuple[Range, Scope]:
        over = over or self.dice.choice(["objects"] if self.axis == "run" else ["objects", "plan"])
        several = pairs and self.dice.random() < 0.3 and over == "plan"
        names = tuple(self._name("q" if over == "plan" else "o") for _ in range(2 if several else 1))
        inner = scope.bound(names, over)
        if over == "plan" and self.axis == "run":
            inner = replace(inner, time=False)
        where = self.formula(replace(inner, ahead=False), depth) if self.dice.random() < 0.5 else None
        return Range(names, over, where), inner

    def formula(self, scope: Scope, depth: int) -> Formula:
        dice = self.dice
        if depth <= 0 or dice.random() < 0.15:
            return self._leaf(scope)
        less = depth - 1

        def one() -> Formula:
            return self.formula(scope, less)

        ways = [
            "leaf",
            "compare",
            "compare",
            "not",
            "and",
            "or",
            "implies",
            "iff",
            "all",
            "exists",
            "nearest",
            "called",
        ]
        if scope.time:
            ways += ["window", "window", "link", "step", "edge", "tally"] * 2
        way = dice.choice(ways)
        if way == "compare":
            dim = dice.choice([M, SPEED, ONE, ACC, S])
            a, b = self.number(dim, scope, less), self.number(dim, scope, less)
            how = dice.randint(0, 3)
            if how == 0:
                ops = dice.choice([("<", "<="), ("<=", "<="), (">", ">"), (">=", ">"), ("<", "<")])
                return chain(a, ops[0], b, ops[1], self.number(dim, scope, less))
            if how == 1:
                return within(a, b, self.number(dim, scope, less))
            return comparison(a, dice.choice(COMPARISONS), b)
        if way == "not":
            return no(one())
        if way == "and":
            return conj(one(), one())
        if way == "or":
            return disj(one(), one())
        if way == "implies":
            return implies(one(), one())
        if way == "iff":
            return iff(one(), one(), dice.choice(["iff", "xor"]))
        if way in ("all", "exists", "nearest") and len(scope.records) < 4:
            rng, inner = self._range(scope, less, "objects" if way == "nearest" else "", pairs=False)
            body = self.formula(inner, less)
            if way == "nearest":
                by = self.number(dice.choice([M, SPEED]), replace(inner, time=False), less)
                return nearest(rng, by, body, dice.choice(["for", "exists"]))
            return for_all(rng, body) if way == "all" else exists(rng, body)
        if way == "called":
            made = self._called(scope, depth, None)
            return made if made is not None else one()
        if way in ("window", "link"):
            pasts = ["once", "historically"] if way == "window" else ["since"]
            futures = ["always", "eventually"] if way == "window" else ["until"]
            word = dice.choice(pasts + futures * scope.ahead)
            window = self._window(self.axis == "run" and word in ("always", "eventually", "until"))
            if way == "window":
                return windowed(word, window, one())
            return linked(one(), word, window, one())
        if way == "step":
            return stepped(
                dice.choice(["previous", "weak previous"] + ["next", "weak next"] * scope.ahead), one()
            )
        if way == "edge":
            return edge(dice.choice(["rising", "falling"]), one())
        if way == "tally":
            inner = replace(scope, ahead=scope.ahead and self.axis != "run")
            p, number, op = self.formula(inner, less), dice.randint(0, 4), dice.choice(COMPARISONS)
            how = dice.randint(0, 2)
            if how == 1:
                size = self.time()
                return tally(p, op, number, last=Window(size[0], 0.0, size[1]))
            return tally(p, op, number, reset=self.formula(inner, less) if how == 2 else None)
        return self._leaf(scope)

    def time(self) -> tuple[str, float]:
        tenths = self.dice.randint(0, 12)
        if self.dice.random() < 0.5:
            return f"{tenths * 100} ms", tenths * 100e6
        return f"{tenths / 10!r} s", tenths * 100e6

    def _window(self, bounded: bool) -> Window:
        if not bounded and self.dice.random() < 0.3:
            return Window()
        low, high = sorted([self.time(), self.time()], key=lambda one: one[1])
        return Window(f"[{low[0]}, {high[0]}]", low[1], high[1])

    def _leaf(self, scope: Scope) -> Formula:
        if self.asks and scope.time and self.dice.random() < 0.6:
            asked = self.dice.choice(self.asks)(scope)
            if asked is not None:
                return asked
        name, _ = self.dice.choice(scope.records)
        way = self.dice.randint(0, 6)
        if way == 0:
            return flag(name, "on")
        if way == 1:
            return member(name, "tone", self.dice.choice(SHADES))
        if way == 2:
            return alike(name, "tone", self.dice.choice(scope.records)[0], "tone")
        if way == 3 and scope.formulas:
            return self.dice.choice(scope.formulas)
        dim = self.dice.choice([M, SPEED, ONE])
        a, b = self.number(dim, scope, 0), self.number(dim, scope, 1)
        return comparison(a, self.dice.choice(COMPARISONS), b)

    # Rules.

    def rule(self, name: str, depth: int) -> tuple[str, list[Clause], Formula]:
        scope = Scope((("ego", "ego"),), time=self.axis == "run", ahead=self.ahead)
        lines, clauses = [f'rule {name} "x"'], list[Clause]()
        if self.axis == "along":
            lines.append("along plan as p" + (" at last" if self.dice.random() < 0.5 else ""))
            scope = replace(scope, records=(*scope.records, ("p", "plan")), time=True)
        if self.axis == "course":
            lines.append(f"along driven as p{self.dice.choice(['', ' at now', ' at last'])}")
            scope = replace(scope, records=(*scope.records, ("p", "course")), time=True)
        for _ in range(self.dice.choice([0, 1, 1, 2])):
            word = self.dice.choice(
                ["whenever", "for all", "for all", "exists", "for nearest", "exists nearest"]
            )
            if word == "whenever" and not clauses:
                clauses.append(
                    Clause(word, self.formula(replace(scope, ahead=self.axis != "run"), depth - 2))
                )
            elif word != "whenever":
                past = replace(scope, ahead=self.axis != "run")
                rng, inner = self._range(past, depth - 2, "objects" if "nearest" in word else "")
                excepted = self.formula(inner, depth - 2) if self.dice.random() < 0.3 else None
                by = None
                if "nearest" in word:
                    by = self.number(M, replace(inner, time=False), 1)
                clauses.append(Clause(word, None, rng, excepted, by))
                scope = replace(inner, ahead=scope.ahead)
            else:
                continue
            lines.append(clauses[-1].text)
        for _ in range(self.dice.choice([0, 0, 1, 2])):
            let = self._name("let")
            if self.dice.random() < 0.5:
                number = self.number(self.dice.choice([M, SPEED]), replace(scope, time=False), 2)
                lines.append(f"let {let} = {number.text}")
                scope = replace(scope, numbers=(*scope.numbers, replace(number, text=let, level=5)))
            else:
                said = self.formula(scope, 2)
                lines.append(f"let {let} = {said.text}")
                scope = replace(scope, formulas=(*scope.formulas, replace(said, text=let, level=5)))
        require = self.formula(scope, depth)
        lines.append(f"require {require.text}")
        return "\n  ".join(lines), clauses, require

    # Data, as it is given and in SI.

    def _record(self, signal: str) -> tuple[dict[str, Any], dict[str, Any]]:
        given: dict[str, Any] = {}
        si: dict[str, Any] = {}
        for name in FIELDS[signal]:
            if name == "t":
                continue
            value: float | None = self._number()
            chance = self.dice.random()
            if chance < self.missing:
                value = self.dice.choice([None, math.nan])
            elif chance < 0.2 and (signal, name) in self.defaults and signal != "plan":
                si[name] = in_si(self.defaults[signal, name], self.units[signal, name][1])
                continue
            given[name] = value
            si[name] = math.nan if value is None else in_si(value, self.units[signal, name][1])
        for name, options in (("on", (True, False)), ("tone", SHADES)):
            said: Any = self.dice.choice(options)
            chance = self.dice.random()
            if chance < self.missing:
                said = None
            elif chance < 0.2 and (signal, name) in self.defaults:
                si[name] = self.defaults[signal, name]
                continue
            given[name] = si[name] = said
        return given, si

    def cycle(self, ids: list[int] | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """A cycle as data, and as `meaning` takes it."""
        ego, its = self._record("ego")
        given: dict[str, Any] = {"ego": ego}
        meant: dict[str, Any] = {"ego": its}
        samples = [self._record("plan") for _ in range(self.dice.randint(2, 6))]
        t, times = 0.0, []
        for _ in samples:
            times.append(t)
            t += self.dice.choice([0.1, 0.2, 0.2, 0.5, 1.0])
        columns = {c: [one[0][c] for one in samples] for c in samples[0][0]}
        given["plan"] = {"t": times, **columns}
        meant["plan"] = {j: {"t": at, **one[1]} for j, (at, one) in enumerate(zip(times, samples))}
        found = ids if ids is not None else list(range(self.dice.choice([0, 1, 1, 2, 3])))
        objects = [self._record("objects") for _ in found]
        given["objects"] = [
            {**one[0], **({"id": i} if ids is not None else {})} for i, one in zip(found, objects)
        ]
        meant["objects"] = {i: one[1] for i, one in zip(found, objects)}
        return given, meant
