"""The language once more: each construct as its text and its meaning, side by side.

Written from docs/language.md and docs/memory.md alone, and nothing is imported from the engine: the evaluators share one
parser, one type checker and one lowering, so none of them sees where those are wrong. Here nothing is parsed: what is
combined is a closure, what is printed is the text. Everything is brute force.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

#: Exponents of metre, second and kilogram.
Dim: TypeAlias = tuple[int, int, int]
Env: TypeAlias = dict[str, Any]
INF = math.inf


class Value(NamedTuple):
    """What a formula comes to in the worst and in the best case; they differ where something is not known."""

    sure: bool
    worst: float
    possible: bool
    best: float


UNKNOWN = Value(False, -INF, True, INF)
TRUE = Value(True, INF, True, INF)
FALSE = Value(False, -INF, False, -INF)


@dataclass(frozen=True)
class Num:
    text: str
    level: int  # 1 sums, 2 products, 3 minus, 4 powers, 5 all others
    dim: Dim
    of: Callable[[Env], float]
    free: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Formula:
    text: str
    level: int  # 1 implies, 2 or, 3 and, 4 what stands before its operand, 5 comparisons and all others; 0 none of these
    of: Callable[[Env], Value]
    free: frozenset[str] = frozenset()
    dims: frozenset[Dim | None] = frozenset()


def at(one: Num | Formula, level: int) -> str:
    return one.text if one.level >= level else f"({one.text})"


def free(*parts: Num | Formula) -> frozenset[str]:
    return frozenset().union(*(part.free for part in parts))


def dims(*parts: Formula) -> frozenset[Dim | None]:
    return frozenset().union(*(part.dims for part in parts))


# Logic: strong Kleene, with the margins of both cases.


def negated(p: Value) -> Value:
    return Value(not p.possible, -p.best, not p.sure, -p.worst)


def both(values: Iterable[Value]) -> Value:
    every = [TRUE, *values]
    return Value(
        all(v.sure for v in every), min(v.worst for v in every),
        all(v.possible for v in every), min(v.best for v in every),
    )  # fmt: skip


def either(values: Iterable[Value]) -> Value:
    return negated(both(negated(v) for v in values))


def _apart(a: float, b: float) -> float:
    return 0.0 if a == b else abs(a - b)


def same(p: Value, q: Value) -> Value:
    """`iff`: -|p - q|; the worst case is that of the greatest distance that is possible."""
    known = p.sure == p.possible and q.sure == q.possible
    farthest = max(_apart(p.worst, q.best), _apart(p.best, q.worst))
    overlap = p.worst <= q.best and q.worst <= p.best
    nearest = 0.0 if overlap else min(_apart(p.worst, q.best), _apart(p.best, q.worst))
    if not known:
        return Value(False, -farthest, True, -nearest)
    return Value(p.sure == q.sure, -farthest, p.sure == q.sure, -nearest)


def no(p: Formula) -> Formula:
    return Formula(f"not {at(p, 4)}", 4, lambda env: negated(p.of(env)), p.free, p.dims)


def conj(p: Formula, q: Formula) -> Formula:
    return Formula(
        f"{at(p, 3)} and {at(q, 4)}", 3, lambda env: both([p.of(env), q.of(env)]), free(p, q), dims(p, q)
    )


def disj(p: Formula, q: Formula) -> Formula:
    return Formula(
        f"{at(p, 2)} or {at(q, 3)}", 2, lambda env: either([p.of(env), q.of(env)]), free(p, q), dims(p, q)
    )


def implies(p: Formula, q: Formula) -> Formula:
    def of(env: Env) -> Value:
        return either([negated(p.of(env)), q.of(env)])

    return Formula(f"{at(p, 2)} implies {at(q, 1)}", 1, of, free(p, q), dims(p, q))


def iff(p: Formula, q: Formula, word: str) -> Formula:
    def of(env: Env) -> Value:
        alike = same(p.of(env), q.of(env))
        return alike if word == "iff" else negated(alike)

    return Formula(f"{at(p, 2)} {word} {at(q, 2)}", 0, of, free(p, q), dims(p, q))


# Numbers. NaN is no value.

UNITS: dict[Dim, tuple[tuple[str, Fraction], ...]] = {
    (1, 0, 0): (("m", Fraction(1)), ("km", Fraction(1000)), ("cm", Fraction(1, 100))),
    (0, 1, 0): (("s", Fraction(1)), ("ms", Fraction(1, 1000)), ("min", Fraction(60))),
    (0, 0, 1): (("kg", Fraction(1)),),
    (0, 0, 0): (("", Fraction(1)), ("%", Fraction(1, 100)), ("deg", Fraction(math.pi) / 180)),
    (1, -1, 0): (("m/s", Fraction(1)), ("km/h", Fraction(5, 18))),
    (1, -2, 0): (("m/s^2", Fraction(1)), ("km/h^2", Fraction(1000, 3600**2))),
    (2, 0, 0): (("m^2", Fraction(1)), ("km^2", Fraction(10**6))),
    (-1, 0, 0): (("1/m", Fraction(1)), ("1/km", Fraction(1, 1000))),
    (1, -2, 1): (("N", Fraction(1)), ("kN", Fraction(1000))),
    (2, -2, 0): (("m^2/s^2", Fraction(1)),),
}


def in_si(number: float, factor: Fraction) -> float:
    return float(Fraction(repr(number)) * factor) if math.isfinite(number) else number


def literal(dim: Dim, number: float, unit: tuple[str, Fraction]) -> Num:
    value = in_si(abs(number), unit[1])
    text = f"{abs(number)!r} {unit[0]}".strip()
    if number < 0.0:
        return Num(f"-{text}", 3, dim, lambda env: -value)
    return Num(text, 4 if unit[0] else 5, dim, lambda env: value)


def record(env: Env, name: str) -> dict[str, Any]:
    """Of a signal itself, of a sample of the plan (by its place) or of an element (by its id)."""
    cycle = env["cycles"][env["k"]]
    bound = env.get(name)
    if bound is None:
        found = cycle[name]
    elif bound[0] == "":  # what a definition is given
        found = cycle[bound[1]]
    elif bound[0] == "course":
        found = env["course"][bound[1]].env
    else:
        found = cycle[bound[0]][bound[1]]
    return found  # type: ignore[no-any-return]


def field(name: str, column: str, dim: Dim) -> Num:
    return Num(f"{name}.{column}", 5, dim, lambda env: record(env, name)[column], frozenset([name]))


def flag(name: str, column: str) -> Formula:
    def of(env: Env) -> Value:
        on = record(env, name)[column]
        return UNKNOWN if on is None else TRUE if on else FALSE

    return Formula(f"{name}.{column}", 5, of, frozenset([name]), frozenset())


def member(name: str, column: str, wanted: str) -> Formula:
    def of(env: Env) -> Value:
        found = record(env, name)[column]
        return UNKNOWN if found is None else TRUE if found == wanted else FALSE

    return Formula(f"{name}.{column} is {wanted}", 5, of, frozenset([name]), frozenset())


def alike(name: str, column: str, other: str, its: str) -> Formula:
    def of(env: Env) -> Value:
        a, b = record(env, name)[column], record(env, other)[its]
        return UNKNOWN if a is None or b is None else TRUE if a == b else FALSE

    return Formula(f"{name}.{column} is {other}.{its}", 5, of, frozenset([name, other]), frozenset())


def _quotient(a: float, b: float) -> float:
    if b != 0.0:
        return a / b
    return math.nan if a == 0.0 or math.isnan(a) else math.copysign(INF, a) * math.copysign(1.0, b)


_ARITHMETIC: dict[str, tuple[int, int, Callable[[float, float], float]]] = {
    "+": (1, 1, operator.add), "-": (1, 2, operator.sub), "*": (2, 2, operator.mul), "/": (2, 3, _quotient),
}  # fmt: skip


def arithmetic(a: Num, op: str, b: Num) -> Num:
    level, right, compute = _ARITHMETIC[op]
    sign = {"*": 1, "/": -1}.get(op, 0)
    dim = (a.dim[0] + sign * b.dim[0], a.dim[1] + sign * b.dim[1], a.dim[2] + sign * b.dim[2])
    text = f"{at(a, level)} {op} {at(b, max(right, level + 1))}"
    return Num(text, level, dim, lambda env: compute(a.of(env), b.of(env)), free(a, b))


def minus(a: Num) -> Num:
    return Num(f"-{at(a, 4)}", 3, a.dim, lambda env: -a.of(env), a.free)


def square(a: Num) -> Num:
    dim = (2 * a.dim[0], 2 * a.dim[1], 2 * a.dim[2])
    return Num(f"{at(a, 5)}^2", 4, dim, lambda env: a.of(env) * a.of(env), a.free)


def _root(x: float) -> float:
    return math.sqrt(x) if x >= 0.0 else math.nan


def _sign(x: float) -> float:
    return x if math.isnan(x) else float((x > 0.0) - (x < 0.0))


def root(a: Num) -> Num:
    dim = (a.dim[0] // 2, a.dim[1] // 2, a.dim[2] // 2)
    return Num(f"sqrt({a.text})", 5, dim, lambda env: _root(a.of(env)), a.free)


def _whole(how: Callable[[float], float]) -> Callable[[float], float]:
    return lambda x: float(how(x)) if math.isfinite(x) else x


ROUNDED: dict[str, Callable[[float], float]] = {
    "floor": _whole(math.floor),
    "ceil": _whole(math.ceil),
    "round": _whole(round),
    "sign": _sign,
    "abs": abs,
}


def unary(word: str, a: Num) -> Num:
    dim = a.dim if word == "abs" else (0, 0, 0)
    return Num(f"{word}({a.text})", 5, dim, lambda env: ROUNDED[word](a.of(env)), a.free)


def extreme(word: str, parts: list[Num]) -> Num:
    def of(env: Env) -> float:
        return _extreme(word, [part.of(env) for part in parts])

    return Num(f"{word}({', '.join(p.text for p in parts)})", 5, parts[0].dim, of, free(*parts))


def _extreme(word: str, values: list[float]) -> float:
    if any(math.isnan(v) for v in values):
        return math.nan
    return min(values) if word == "min" else max(values)


def chosen(c: Formula, a: Num, b: Num) -> Num:
    def of(env: Env) -> float:
        value = c.of(env)
        return a.of(env) if value.sure else math.nan if value.possible else b.of(env)

    return Num(f"if {at(c, 1)} then {at(a, 1)} else {at(b, 1)}", 0, a.dim, of, free(c, a, b))


def cases(name: str, column: str, branches: dict[str, Num]) -> Num:
    """A number for each member; `else` for all that are not named."""

    def of(env: Env) -> float:
        found = record(env, name)[column]
        return math.nan if found is None else branches.get(found, branches.get("else", FAILS)).of(env)

    parts = list(branches.values())
    text = ", ".join(f"{key}: {one.text}" for key, one in branches.items())
    return Num(f"case {name}.{column} {{ {text} }}", 5, parts[0].dim, of, free(*parts) | {name})


FAILS = Num("", 5, (0, 0, 0), lambda env: math.nan)


@dataclass(frozen=True)
class Table:
    """Knots in SI; how it is read between and outside them."""

    knots: tuple[tuple[float, float], ...]
    linear: bool
    outside: str  # "clamp", "wrap" or ""
    period: float = 0.0

    def read(self, x: float) -> float:
        knots = list(self.knots)
        if not math.isfinite(x):
            return math.nan
        if self.outside == "wrap":
            x -= math.floor(x / self.period) * self.period
            knots = [(a + n * self.period, p) for n in (-1, 0, 1) for a, p in knots]
        first, last = knots[0], knots[-1]
        if x < first[0]:
            return first[1] if self.outside == "clamp" else math.nan
        if x >= last[0]:
            beyond = x > last[0] and self.linear and self.outside != "clamp"
            return math.nan if beyond else last[1]
        (a, p), (b, q) = next(pair for pair in zip(knots, knots[1:]) if pair[0][0] <= x < pair[1][0])
        return p + (q - p) / (b - a) * (x - a) if self.linear else p


def looked_up(name: str, table: Table, dim: Dim, x: Num) -> Num:
    return Num(f"{name}({x.text})", 5, dim, lambda env: table.read(x.of(env)), x.free)


# Comparisons.

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")


def compared(a: float, op: str, b: float) -> Value:
    if not (math.isfinite(a) and math.isfinite(b)):
        return UNKNOWN
    margin = {"<": b - a, "<=": b - a, ">": a - b, ">=": a - b, "==": -abs(a - b), "!=": abs(a - b)}[op]
    holds = {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[op]
    return Value(holds, margin, holds, margin)


def scaled(env: Env, dim: Dim, value: Value) -> Value:
    scale = env["scales"].get(dim, 1.0) if env["scales"] else 1.0
    return value._replace(worst=value.worst / scale, best=value.best / scale)


def comparison(a: Num, op: str, b: Num) -> Formula:
    def of(env: Env) -> Value:
        return scaled(env, a.dim, compared(a.of(env), op, b.of(env)))

    return Formula(f"{at(a, 1)} {op} {at(b, 1)}", 5, of, free(a, b), frozenset([a.dim]))


def chain(a: Num, op: str, b: Num, op2: str, c: Num) -> Formula:
    """`0 m <= x < y` is `0 m <= x and x < y`."""

    def of(env: Env) -> Value:
        return both([comparison(a, op, b).of(env), comparison(b, op2, c).of(env)])

    return Formula(f"{at(a, 1)} {op} {at(b, 1)} {op2} {at(c, 1)}", 5, of, free(a, b, c), frozenset([a.dim]))


def within(x: Num, low: Num, high: Num) -> Formula:
    inside = chain(low, "<=", x, "<=", high)
    return replace(inside, text=f"{at(x, 1)} in [{low.text}, {high.text}]")


# Quantifiers and numbers of many.


@dataclass(frozen=True)
class Range:
    """`p in plan where c`, or `consecutive p, q in plan`."""

    names: tuple[str, ...]
    over: str
    where: Formula | None = None

    @property
    def text(self) -> str:
        names = ("consecutive " if len(self.names) > 1 else "") + ", ".join(self.names)
        return f"{names} in {self.over}" + (f" where {at(self.where, 1)}" if self.where else "")

    def of(self, env: Env) -> Iterator[tuple[Env, Value]]:
        """Each choice with whether it is in range."""
        places = list(env["cycles"][env["k"]][self.over])
        for start in range(len(places) - len(self.names) + 1):
            inner = {**env, **{n: (self.over, places[start + i]) for i, n in enumerate(self.names)}}
            yield inner, self.where.of(inner) if self.where else TRUE

    def unbound(self, *parts: Num | Formula) -> frozenset[str]:
        return free(*parts, *([self.where] if self.where else [])) - set(self.names) | {self.over}


def _where(p: Value) -> Value:
    """What is in range has no margin of its own."""
    return Value(p.sure, INF if p.sure else -INF, p.possible, INF if p.possible else -INF)


def for_all(rng: Range, p: Formula) -> Formula:
    def of(env: Env) -> Value:
        return both(either([negated(_where(c)), p.of(inner)]) for inner, c in rng.of(env))

    return Formula(f"for all {rng.text}: ({p.text})", 4, of, rng.unbound(p), p.dims)


def exists(rng: Range, p: Formula) -> Formula:
    def of(env: Env) -> Value:
        return either(both([_where(c), p.of(inner)]) for inner, c in rng.of(env))

    return Formula(f"exists {rng.text}: ({p.text})", 4, of, rng.unbound(p), p.dims)


def nearest(rng: Range, by: Num, p: Formula, word: str) -> Formula:
    def of(env: Env) -> Value:
        found = [(inner, c, by.of(inner)) for inner, c in rng.of(env) if c.possible]
        if not found:
            return TRUE if word == "for" else FALSE
        if all(c.sure and math.isfinite(number) for _, c, number in found):
            return p.of(min(found, key=lambda one: one[2])[0])
        if word == "for":
            return both(p.of(inner) for inner, _, _ in found)._replace(possible=True, best=INF)
        fails = not any(p.of(inner).possible for inner, _, _ in found)
        best = max(p.of(inner).best for inner, _, _ in found)
        return Value(False, -INF, not fails, best)

    names = Range(rng.names, rng.over)
    where = f" where {at(rng.where, 1)}" if rng.where else ""
    text = f"{word} nearest {names.text} by {at(by, 1)}{where}: ({p.text})"
    return Formula(text, 4, of, rng.unbound(p, by), p.dims)


def many(word: str, rng: Range, number: Num, instead: Num | None = None) -> Num:
    """`sum`, `min`, `max` and `count`."""

    def of(env: Env) -> float:
        found = [(c, number.of(inner)) for inner, c in rng.of(env) if c.possible]
        if not all(c.sure for c, _ in found):
            return math.nan
        values = [value for _, value in found]
        if word in ("min", "max"):
            if not values:
                return instead.of(env) if instead else math.nan
            return _extreme(word, values)
        total = 0.0
        for value in values:
            total += value if word == "sum" else 1.0
        return total

    if word == "count":
        return Num(f"count({rng.text})", 5, (0, 0, 0), of, rng.unbound())
    otherwise = f" else {at(instead, 1)}" if instead else ""
    names = rng.unbound(number) | (instead.free if instead else frozenset())
    return Num(f"{word}({at(number, 1)} for {rng.text}{otherwise})", 5, number.dim, of, names)


# Time. A timeline is a list of samples and gaps; of a gap nothing is known.


class Item(NamedTuple):
    begins: int  # ns; of a gap, the stamps around it
    ends: int
    env: Env | None  # None: a gap
    missed: int = 0


def timeline(env: Env, names: frozenset[str], ahead: bool = False) -> tuple[list[Item], int]:
    """All samples, and the place of the present one. Over the run, as long as all elements in `names` are there."""
    if "along" in env:
        name = env["along"]
        if "course" in env:
            on = [
                one._replace(env=one.env and {**env, name: ("course", j)})
                for j, one in enumerate(env["course"])
            ]
            return on, env[name][1]
        samples = record({**env, name: None}, "plan")
        times = [round(one["t"] * 1e9) for one in samples.values()]
        return [Item(t, t, {**env, name: ("plan", j)}) for j, t in enumerate(times)], env[name][1]
    cycles = env["cycles"]
    elements = [env[n] for n in sorted(names) if isinstance(env.get(n), tuple) and env[n][0] == "objects"]
    forget = env.get("forget", 0)
    there = [all(i in c[s] for s, i in elements) for c in cycles]
    items: list[Item] = []
    here, last, missed = -1, -1, 0
    for j, cycle in enumerate(cycles):
        stamp, missed = cycle["stamp"], missed + cycle["missed"]
        if not there[j]:
            missed += 1
            continue
        absent = last >= 0 and last < j - 1
        bridged = 0 < stamp - cycles[last]["stamp"] <= forget and not (ahead and here >= 0)
        if absent and not bridged:
            if here >= 0:
                break  # the life of what is asked for is over
            items = []
        elif last >= 0 and missed:
            items.append(Item(cycles[last]["stamp"], stamp, None, missed))
        if j == env["k"]:
            here = len(items)
        items.append(Item(stamp, stamp, {**env, "k": j}))
        last, missed = j, 0
    return items, here


def course(
    cycles: list[dict[str, Any]], k: int, lasting: int, fields: Iterable[str]
) -> tuple[list[Item], int]:
    """`driven = ego for lasting [ns] then plan` in the cycle k: what was driven, now, and what is planned, and the place of now."""
    now, found = cycles[k]["stamp"], list[Item]()
    for j, cycle in enumerate(cycles[: k + 1]):
        stamp = cycle["stamp"]
        if j and cycle["missed"] and stamp > now - lasting:
            found.append(Item(cycles[j - 1]["stamp"], stamp, None, cycle["missed"]))
        if stamp >= now - lasting:
            was = {"t": (stamp - now) / 1e9, **{name: cycle["ego"][name] for name in fields}}
            found.append(Item(stamp, stamp, was))
    here = len(found) - 1
    dues = [round(sample["t"] * 1e9) for sample in cycles[k]["plan"].values()]
    if dues[-1] < 0:  # it was over before
        nothing = {name: None if name in ("on", "tone") else math.nan for name in ("t", *fields)}
        return [Item(now, now, nothing)], 0
    for sample, due in zip(cycles[k]["plan"].values(), dues):
        if due > 0:
            will = {name: sample[name] for name in ("t", *fields)}
            found.append(Item(now + due, now + due, will))
    return found, here


def overlaps(item: Item, low: float, high: float) -> bool:
    if item.env is None:
        return item.ends > low and item.begins < high
    return low <= item.begins <= high


@dataclass(frozen=True)
class Window:
    """Bounds in ns, and as they are written."""

    text: str = ""
    low: float = 0.0
    high: float = INF

    def of(self, items: list[Item], here: int, ahead: bool) -> list[int]:
        now = items[here].begins
        places = range(here, len(items)) if ahead else range(here + 1)
        low, high = (now + self.low, now + self.high) if ahead else (now - self.high, now - self.low)
        return [j for j in places if overlaps(items[j], low, high)]


def _at(p: Formula, item: Item) -> Value:
    return UNKNOWN if item.env is None else p.of(item.env)


def windowed(word: str, window: Window, p: Formula) -> Formula:
    ahead, every = word in ("always", "eventually"), word in ("always", "historically")

    def of(env: Env) -> Value:
        items, here = timeline(env, p.free, ahead)
        values = [_at(p, items[j]) for j in window.of(items, here, ahead)]
        return both(values) if every else either(values)

    return Formula(f"{word}{window.text} {at(p, 4)}", 4, of, p.free, p.dims)


def linked(p: Formula, word: str, window: Window, q: Formula) -> Formula:
    """`since` and `until`."""
    ahead = word == "until"

    def of(env: Env) -> Value:
        items, here = timeline(env, free(p, q), ahead)
        found = []
        for j in window.of(items, here, ahead):
            between = range(here, j) if ahead else range(j + 1, here + 1)
            found.append(both([_at(q, items[j]), *(_at(p, items[i]) for i in between)]))
        return either(found)

    return Formula(f"{at(p, 5)} {word}{window.text} {at(q, 5)}", 0, of, free(p, q), dims(p, q))


def stepped(word: str, p: Formula) -> Formula:
    def of(env: Env) -> Value:
        items, here = timeline(env, p.free, "next" in word)
        j = here + (1 if "next" in word else -1)
        if not 0 <= j < len(items):
            return TRUE if "weak" in word else FALSE
        return _at(p, items[j])

    return Formula(f"{word} {at(p, 4)}", 4, of, p.free, p.dims)


def edge(word: str, p: Formula) -> Formula:
    def of(env: Env) -> Value:
        now = p.of(env)
        if word == "rising":
            return both([now, negated(stepped("previous", p).of(env))])
        return both([negated(now), stepped("weak previous", p).of(env)])

    return Formula(f"{word}({p.text})", 5, of, p.free, p.dims)


def tally(
    p: Formula, op: str, number: int, last: Window | None = None, reset: Formula | None = None
) -> Formula:
    """`count(p) <= 3`: an interval from sure to possible, compared."""
    parts = [p] if reset is None else [p, reset]

    def ranges(env: Env) -> tuple[int, int]:
        items, here = timeline(env, free(*parts))
        places = (last or Window()).of(items, here, False)
        sure = [int(_at(p, items[j]).sure) for j in range(len(items))]
        most = [int(_at(p, items[j]).possible) * max(1, items[j].missed) for j in range(len(items))]
        if reset is None:
            return sum(sure[j] for j in places), sum(most[j] for j in places)
        # Each sample at which the reset may have been the last one is a start.
        resets = [_at(reset, items[j]) for j in range(here + 1)]
        sets = [j for j in range(here + 1) if resets[j].sure]
        floor = max(sets, default=0)
        starts = [floor, *(j for j in range(floor, here + 1) if resets[j].possible)]
        # A reset within a gap may come after all of what the gap held.
        low = min(sum(sure[j : here + 1]) for j in starts)
        return low, max(sum(most[j : here + 1]) for j in starts)

    def of(env: Env) -> Value:
        low, high = ranges(env)
        values = [compared(float(n), op, float(number)) for n in range(low, high + 1)]
        return Value(
            all(v.sure for v in values), min(v.worst for v in values),
            any(v.possible for v in values), max(v.best for v in values),
        )  # fmt: skip

    rest = f", last: {last.text}" if last else f", reset: {reset.text}" if reset else ""
    return Formula(f"count({p.text}{rest}) {op} {number}", 5, of, free(*parts), frozenset([None]))


# Rules.


@dataclass(frozen=True)
class Clause:
    """`whenever p`, or a quantifier with what it excepts."""

    word: str  # whenever, for all, exists, for nearest, exists nearest
    guard: Formula | None = None
    rng: Range | None = None
    excepted: Formula | None = None
    by: Num | None = None

    @property
    def text(self) -> str:
        if self.guard is not None:
            return f"whenever {self.guard.text}"
        assert self.rng is not None
        bare = Range(self.rng.names, self.rng.over)
        by = f" by {self.by.text}" if self.by else ""
        where = f" where {self.rng.where.text}" if self.rng.where else ""
        text = f"{self.word} {bare.text}{by}{where}"
        return text + (f'\n  except {self.excepted.text} "why"' if self.excepted else "")


class Judged(NamedTuple):
    verdict: str
    margin: float


def judged(clauses: list[Clause], require: Formula, env: Env) -> Judged:
    value, active = _below(clauses, require, env)
    if not active:
        return Judged("inactive", INF)
    return verdict(value)


def verdict(value: Value) -> Judged:
    if value.sure:
        return Judged("satisfied", value.worst + 0.0)
    return Judged("undefined", math.nan) if value.possible else Judged("violated", value.best + 0.0)


def _below(clauses: list[Clause], require: Formula, env: Env) -> tuple[Value, bool]:
    """The value, and whether anything was asked at all."""
    if not clauses:
        return require.of(env), True
    clause, rest = clauses[0], clauses[1:]
    if clause.guard is not None:
        guard = clause.guard.of({**env, "scales": {}})
        value, active = _below(rest, require, env)
        return either([negated(_where(guard)), value]), active and guard.possible
    assert clause.rng is not None
    where = clause.rng.where
    if clause.excepted is not None:
        where = conj(where, no(clause.excepted)) if where else no(clause.excepted)
    rng = replace(clause.rng, where=where)
    inner = Formula("", 5, lambda e: _below(rest, require, e)[0])
    asked = [(e, c) for e, c in rng.of(env) if c.possible]
    if clause.by is not None and all(c.sure and math.isfinite(clause.by.of(e)) for e, c in asked):
        asked = sorted(asked, key=lambda one: clause.by.of(one[0]))[:1]  # type: ignore[union-attr]
    active = "exists" in clause.word or any(_below(rest, require, e)[1] for e, _ in asked)
    if clause.word == "for all":
        return for_all(rng, inner).of(env), active
    if clause.word == "exists":
        return exists(rng, inner).of(env), active
    assert clause.by is not None
    word = clause.word.split()[0]
    return nearest(rng, clause.by, inner, word).of(env), active
