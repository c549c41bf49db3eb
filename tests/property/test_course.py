"""Rules along a course: what was driven and what is planned, against an evaluator of its own that knows samples and gaps as intervals of milliseconds."""

from __future__ import annotations

import math
from functools import cache
from operator import eq, ge, gt, le, lt, ne
from typing import Any, NamedTuple

from hypothesis import given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal.evaluation import Evaluator, loads

SIGNALS = """module m
signal ego : state { v: m/s, on: bool, w: m }
signal plan : trajectory { t: s increasing, v: m/s, on: bool, k: 1/m }
event flag
course driven = ego for 0.5 s then plan
"""
#: Worst and best case: whether it holds.
Kleene = tuple[bool, bool]
UNKNOWN: Kleene = (False, True)
OPERATORS = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq, "!=": ne}
PLACES = {"": "now", " at now": "now", " at last": "last"}


class Cycle(NamedTuple):
    """Its stamp [ms]; cycles missing before it; speed (None: not known), whether it is on; the plan: ms after the stamp, speed, on."""

    at: int
    missed: int
    v: float | None
    on: bool
    flag: bool
    plan: tuple[tuple[int, float, bool], ...]


class Element(NamedTuple):
    begin: int
    end: int
    v: float | None
    on: bool | None
    missing: int = 1


speeds = st.sampled_from([-2.0, -1.0, 0.0, 1.0, 2.0])


@st.composite
def cycles(draw: st.DrawFn) -> list[Cycle]:
    found, at = list[Cycle](), 0
    for _ in range(draw(st.integers(1, 9))):
        steps = draw(st.lists(st.sampled_from([50, 100, 200]), min_size=1, max_size=4))
        t, plan = draw(st.sampled_from([-100, 0, 0, 30])), []
        for step in steps:
            plan.append((t, draw(speeds), draw(st.booleans())))
            t += step
        plan.append((t, draw(speeds), draw(st.booleans())))
        v = draw(st.one_of(speeds, speeds, st.none()))
        missed = draw(st.sampled_from([0, 0, 0, 1, 3]))
        at += draw(st.sampled_from([100, 100, 200, 250, 600])) * (1 + missed)
        found.append(Cycle(at, missed, v, draw(st.booleans()), draw(st.booleans()), tuple(plan)))
    return found


def _compared() -> tuple[st.SearchStrategy[Any], ...]:
    return st.sampled_from(sorted(OPERATORS)), st.integers(0, 4), st.booleans()


@cache
def formulas(depth: int) -> st.SearchStrategy[Any]:
    """Formulas as tuples; bounds in ms."""
    leaf = st.sampled_from([("v>", -1.0), ("v>", 0.0), ("v<=", 1.0), ("on",), ("flag",)])
    if depth == 0:
        return leaf
    one = formulas(depth - 1)
    bounds = st.one_of(
        st.none(), st.tuples(st.integers(0, 6), st.integers(0, 6)).map(lambda ab: (50 * ab[0], 50 * sum(ab)))
    )
    return st.one_of(
        leaf,
        st.tuples(st.just("not"), one),
        st.tuples(st.sampled_from(["and", "or"]), one, one),
        st.tuples(st.sampled_from(["once", "historically", "eventually", "always"]), bounds, one),
        st.tuples(st.sampled_from(["since", "until"]), bounds, one, one),
        st.tuples(
            st.just("count"), one, st.just("last"), st.integers(0, 12).map(lambda n: 50 * n), *_compared()
        ),
        st.tuples(st.just("count"), one, st.just("reset"), one, *_compared()),
        st.tuples(st.just("count"), one, st.just(""), st.none(), *_compared()),
        st.tuples(st.sampled_from(["previous", "next", "weak previous", "weak next", "rising"]), one),
    )


def text(formula: Any) -> str:
    match formula:
        case ("v>", limit):
            return f"c.v > {limit!r} m/s" if limit >= 0 else f"c.v > -{-limit!r} m/s"
        case ("v<=", limit):
            return f"c.v <= {limit!r} m/s"
        case ("on",):
            return "c.on"
        case ("flag",):
            return "flag"
        case ("not", p):
            return f"(not {text(p)})"
        case ("and" | "or" as op, p, q):
            return f"({text(p)} {op} {text(q)})"
        case ("since" | "until" as op, window, p, q):
            return f"({text(p)} {op}{_window(window)} {text(q)})"
        case ("count", p, word, more, op, limit, turned):
            told = (
                f", last: {more / 1000!r} s" if word == "last" else f", reset: {text(more)}" if word else ""
            )
            counted = f"count({text(p)}{told})"
            return f"({limit} {op} {counted})" if turned else f"({counted} {op} {limit})"
        case ("rising", p):
            return f"rising({text(p)})"
        case (("previous" | "next" | "weak previous" | "weak next") as op, p):
            return f"({op} {text(p)})"
        case (op, window, p):
            return f"({op}{_window(window)} {text(p)})"
    raise AssertionError(formula)


def _window(bounds: tuple[int, int] | None) -> str:
    return "" if bounds is None else f"[{bounds[0] / 1000!r} s, {bounds[1] / 1000!r} s]"


def timeline(run: list[Cycle]) -> tuple[list[Element], int]:
    """The course in the last cycle, written down from its definition, and the place of the sample that is now."""
    now, found = run[-1].at, list[Element]()
    last, missed = None, 0
    for cycle in run:
        if cycle.v is None and cycle is not run[-1]:
            missed += 1 + cycle.missed
            continue
        missed += cycle.missed
        if last is not None and missed and cycle.at > now - 500:
            found.append(Element(last, cycle.at, None, None, missed))
        if cycle.at >= now - 500:
            found.append(Element(cycle.at, cycle.at, cycle.v, cycle.on))
        last, missed = cycle.at, 0
    at = len(found) - 1
    if run[-1].plan[-1][0] < 0:  # it was over before: nothing is known of what is planned
        return [Element(now, now, None, None)], 0
    return found + [Element(now + due, now + due, v, on) for due, v, on in run[-1].plan if due > 0], at


class Judge:
    """Strong Kleene logic over elements: a gap is in a window that overlaps it, and nothing is known in it."""

    def __init__(self, elements: list[Element], flag: bool) -> None:
        self.elements, self.flag = elements, flag

    def of(self, formula: Any, k: int) -> Kleene:
        element = self.elements[k]
        if element.begin < element.end:
            return UNKNOWN
        match formula:
            case ("v>", limit):
                return UNKNOWN if element.v is None else (element.v > limit,) * 2
            case ("v<=", limit):
                return UNKNOWN if element.v is None else (element.v <= limit,) * 2
            case ("on",):
                return UNKNOWN if element.on is None else (element.on,) * 2
            case ("flag",):
                return (self.flag,) * 2
            case ("not", p):
                worst, best = self.of(p, k)
                return not best, not worst
            case ("and", p, q):
                return _all([self.of(p, k), self.of(q, k)])
            case ("or", p, q):
                return _any([self.of(p, k), self.of(q, k)])
            case ("once" | "eventually" as op, window, p):
                return _any([self.of(p, j) for j in self._inside(k, window, op == "once")])
            case ("historically" | "always" as op, window, p):
                return _all([self.of(p, j) for j in self._inside(k, window, op == "historically")])
            case ("since", window, p, q):
                ways = [
                    [self.of(q, j), *(self.of(p, i) for i in range(j + 1, k + 1))]
                    for j in self._inside(k, window, True)
                ]
                return _any([_all(way) for way in ways])
            case ("until", window, p, q):
                ways = [
                    [self.of(q, j), *(self.of(p, i) for i in range(k, j))]
                    for j in self._inside(k, window, False)
                ]
                return _any([_all(way) for way in ways])
            case ("count", p, word, more, op, limit, turned):
                inside = self._inside(k, (0, more) if word == "last" else None, True)
                found = {0}  # all numbers that it may be, sample by sample, each way that is possible
                for j in inside:
                    worst, best = self.of(p, j)
                    again, may = self.of(more, j) if word == "reset" else (False, False)
                    kept = (set() if again else found) | ({0} if may else set())
                    most = self.elements[j].missing if best else 0
                    found = {one + n for one in kept for n in range(1 if worst else 0, most + 1)}
                said = [OPERATORS[op](*((limit, one) if turned else (one, limit))) for one in found]
                return all(said), any(said)
            case ("rising", p):
                return _all([self.of(p, k), self.of(("not", ("previous", p)), k)])
            case (("previous" | "weak previous") as op, p):
                return self.of(p, k - 1) if k else (op.startswith("weak"),) * 2
            case (("next" | "weak next") as op, p):
                return self.of(p, k + 1) if k + 1 < len(self.elements) else (op.startswith("weak"),) * 2
        raise AssertionError(formula)

    def _inside(self, k: int, window: tuple[int, int] | None, past: bool) -> list[int]:
        t = self.elements[k].begin
        low: float
        high: float
        low, high = (0, math.inf) if window is None else window
        if past:
            low, high = t - high, t - low
        else:
            low, high = t + low, t + high
        return [
            j
            for j, one in enumerate(self.elements)
            if (j <= k if past else j >= k)
            and (low <= one.begin <= high if one.begin == one.end else one.begin < high and one.end > low)
        ]


def _all(values: list[Kleene]) -> Kleene:
    return all(worst for worst, _ in values), all(best for _, best in values)


def _any(values: list[Kleene]) -> Kleene:
    return any(worst for worst, _ in values), any(best for _, best in values)


def said(spec: str, backend: str, run: list[Cycle]) -> list[tuple[str, str, str]]:
    evaluator = Evaluator(loads(spec), backend=backend)
    going, found = evaluator.over_run(), []
    for number, cycle in enumerate(run):
        for _ in range(cycle.missed):
            going.missed()
        due, v, on = zip(*cycle.plan)
        plan = {"t": [one / 1000 for one in due], "v": v, "on": on, "k": [0.0] * len(v)}
        ego = {"v": math.nan if cycle.v is None else cycle.v, "on": cycle.on, "w": 0.0}
        signals = {"ego": ego, "plan": plan, "flag": cycle.flag}
        result = going.step(evaluator.read({"id": number, "t": cycle.at / 1000, "signals": signals})).rules[
            "f"
        ]
        where = "" if result.witness is None else str(result.witness.binders)
        margin = "nan" if math.isnan(result.margin) else float(result.margin).hex()
        found.append((result.verdict, margin, where))
    return found


def test_a_gap_has_one_witness() -> None:
    """In a gap nothing is known, whatever the parts of a formula come to there: found by chance, held by itself."""
    plan = ((-100, -2.0, False), (-50, -2.0, False))
    run = [
        Cycle(at=100, missed=0, v=-2.0, on=False, flag=False, plan=plan),
        Cycle(at=300, missed=1, v=None, on=False, flag=False, plan=plan),
    ]
    formula = ("once", None, ("and", ("v>", -1.0), ("once", (50, 50), ("v>", -1.0))))
    spec = f'{SIGNALS}rule f "x"\n  along driven as c\n  require {text(("or", formula, ("v>", 99.0)))}\n'
    reference = said(spec, "reference", run)
    assert reference == said(spec, "numpy", run)
    assert reference[1][0] == "undefined"


@given(formulas(3), st.sampled_from(sorted(PLACES)), cycles())
@settings(max_examples=amount(20, 600), deadline=None)
def test_a_course_is_what_was_and_what_is_planned(formula: Any, place: str, run: list[Cycle]) -> None:
    """A cycle with a speed that is not known breaks the contract: it is judged, and refused: a part of a gap for those that follow."""
    formula = ("or", formula, ("v>", 99.0))  # so that the variable is used
    spec = f'{SIGNALS}rule f "x"\n  along driven as c{place}\n  require {text(formula)}\n'
    reference = said(spec, "reference", run)
    assert reference == said(spec, "numpy", run)
    for number, cycle in enumerate(run):
        elements, now = timeline(run[: number + 1])
        k = {"now": now, "last": len(elements) - 1}[PLACES[place]]
        worst, best = Judge(elements, cycle.flag).of(formula, k)
        assert reference[number][0] == ("satisfied" if worst else "undefined" if best else "violated"), number
