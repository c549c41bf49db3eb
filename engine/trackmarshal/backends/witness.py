"""Which comparison decided a formula, and at which sample or object: one descent for all evaluators."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol, assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.overrun import unbound
from trackmarshal.runtime.frame import Columns
from trackmarshal.runtime.kleene import UNDEFINED
from trackmarshal.runtime.timeline import measured
from trackmarshal.runtime.verdict import Truth, Witness

Env = dict[int, int]


class Sides(NamedTuple):
    """The values of a formula for all values of one variable: worst and best case, each whether it holds and its margin."""

    worst_sat: Sequence[bool]
    worst: Sequence[float]
    best_sat: Sequence[bool]
    best: Sequence[float]

    def verdict(self, index: int) -> str:
        return "satisfied" if self.worst_sat[index] else "undefined" if self.best_sat[index] else "violated"

    def margin(self, verdict: str, index: int) -> float:
        """The margin that counts for a verdict; 0 for an undefined one."""
        return (
            0.0
            if verdict == "undefined"
            else self.worst[index]
            if verdict == "satisfied"
            else self.best[index]
        )

    def first(self, wanted: str, indices: Iterable[int], least: bool) -> int | None:
        """The first index with a verdict and, of those with it, the least or greatest margin; None where it is nowhere."""
        if wanted == "undefined":  # without a margin, one is as good as another
            return next((i for i in indices if self.best_sat[i] and not self.worst_sat[i]), None)
        if wanted == "satisfied":
            fitting = [i for i in indices if self.worst_sat[i]]
            margins = self.worst
        else:
            fitting = [i for i in indices if not self.best_sat[i]]
            margins = self.best
        return (min if least else max)(fitting, key=margins.__getitem__, default=None)


def unknown_in(sides: Sides, gaps: Sequence[int]) -> Sides:
    """The same with nothing known of some values."""
    if not gaps:
        return sides
    worst_sat, worst = list(sides.worst_sat), list(sides.worst)
    best_sat, best = list(sides.best_sat), list(sides.best)
    for gap in gaps:
        worst_sat[gap], worst[gap], best_sat[gap], best[gap] = False, -math.inf, True, math.inf
    return Sides(worst_sat, worst, best_sat, best)


class Values(Protocol):
    """What a descent asks of an evaluator, for one case."""

    def truth(self, node: ir.Formula, env: Env) -> Truth: ...

    def sides(self, node: ir.Formula, axis: ir.Axis, env: Env) -> Sides: ...

    def count(self, axis: ir.Axis) -> int: ...

    def columns(self, axis: ir.Axis) -> Columns: ...

    def name(self, axis: ir.Axis, index: int) -> int | str: ...


class Descent:
    """Finds the deciding comparison of formulas of one case."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._names: dict[int, tuple[ir.Axis, tuple[str, ...]]] = {}
        #: Of variables that stand for something where the descent is, what they are of.
        self._axes: dict[int, ir.Axis] = {}
        #: The deciding comparison that was found last, and where it was evaluated.
        self.decisive: tuple[ir.Formula, Env] | None = None
        #: Where the way there led into a gap of a timeline: which, and the number of the sample.
        self.gap: tuple[str, int] | None = None

    def find(self, node: ir.Formula | None, env: Env | None = None) -> Witness | None:
        """The witness of a formula, for what its variables stand for; None where nothing decides (an empty range, a constant)."""
        self._names, self._axes, self.decisive, self.gap = {}, {}, None, None
        env = dict(env or {})
        while node is not None:
            self.gap = self.gap or self._in_gap(env)
            step = self._step(node, env)
            if isinstance(step, Witness):
                self.decisive = (node, env)
                return step
            if step is None:
                return None
            node, env = step
        return None

    def _step(self, node: ir.Formula, env: Env) -> Witness | tuple[ir.Formula, Env] | None:
        if isinstance(node, (ir.Temporal, ir.Until, ir.Shift, ir.Tallied, ir.At, ir.Quantify)):
            self._axes[node.axis.level] = node.axis
        match node:
            case ir.Compare() | ir.Flag() | ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return self._witness(node, env)
            case ir.Truth():
                return None
            case ir.Not() | ir.Scaled():
                return node.operand, env
            case ir.Connective():
                return self._connective(node, env)
            case ir.Quantify():
                self._names[node.axis.level] = (node.axis, node.names)
                return self._quantify(node, env)
            case ir.Guarded():
                guard = self._truth(node.guard, env)
                if self._verdict(node, env) == "undefined" and self._verdict(node.body, env) != "undefined":
                    return node.guard, env
                return (node.body, env) if guard.best.sat else None
            case ir.At():
                self._names[node.axis.level] = (node.axis, (node.name,))
                place = self._values.columns(node.axis).place(node.place)
                return node.operand, {**env, node.axis.level: place}
            case ir.Temporal():
                sides = self._values.sides(node.operand, node.axis, env)
                least = node.extreme is Extreme.LEAST
                found = sides.first(self._verdict(node, env), self._window(node, env), least)
                return None if found is None else (node.operand, {**env, node.axis.level: found})
            case ir.Until():
                return self._until(node, env)
            case ir.Shift():
                level = node.axis.level
                if self.gap is not None:  # nothing is known there, whatever comes before or after
                    return node.operand, env
                return (
                    None
                    if self._outside(node, env)
                    else (node.operand, {**env, level: env[level] + node.step})
                )
            case ir.Tallied():
                return self._tallied(node, env)
            case ir.OverRun() | ir.Counted() | ir.InState():
                return None
            case _:
                assert_never(node)

    def _truth(self, node: ir.Formula, env: Env) -> Truth:
        """The value of a formula; in a gap nothing is known, whatever it comes to there."""
        return self._values.truth(node, env) if self._in_gap(env) is None else UNDEFINED

    def _in_gap(self, env: Env) -> tuple[str, int] | None:
        """The timeline of which a variable stands for a gap, and which; None where none does."""
        for level, axis in self._axes.items():
            joined = self._values.columns(axis).joined
            if joined is not None and env.get(level) in joined.gaps:
                return axis.signal, env[level]
        return None

    def _verdict(self, node: ir.Formula, env: Env) -> str:
        return self._truth(node, env).verdict

    def _witness(self, node: ir.Compare | ir.Geometry | ir.Flag, env: Env) -> Witness:
        binders: dict[str, int | str] = {}
        for level, (axis, names) in sorted(self._names.items()):
            if level in env:
                for offset, name in enumerate(names):
                    binders[name] = self._values.name(axis, env[level] + offset)
        unit = node.unit if isinstance(node, ir.Compare) else "1" if isinstance(node, ir.Flag) else "m"
        shown = node.shown if isinstance(node, ir.Compare) else ""
        margin = self._truth(node, env).margin
        return Witness(binders, margin, unit, node.span, shown, _places(node, env), (node, env))

    def _pick(self, node: ir.Connective, env: Env, extreme: Extreme) -> tuple[ir.Formula, Env] | None:
        """The side with the verdict of the whole and the deciding margin; of equal ones the first that is about an input."""
        wanted = self._verdict(node, env)
        fitting: list[tuple[float, bool, ir.Formula]] = []
        for child in (node.left, node.right):
            value = self._truth(child, env)
            if value.verdict == wanted:
                margin = 0.0 if wanted == "undefined" else value.margin
                weight = margin if extreme is Extreme.LEAST else -margin
                fitting.append((weight, self._outside(child, env), child))
        if not fitting:
            return None
        return min(fitting, key=lambda side: side[:2])[2], env

    def _outside(self, node: ir.Formula, env: Env) -> bool:
        """Whether a formula is that of a sample which is not there: of what was before the first one, nothing decides."""
        if not isinstance(node, ir.Shift):
            return False
        return not 0 <= env[node.axis.level] + node.step < self._values.count(node.axis)

    def _connective(self, node: ir.Connective, env: Env) -> tuple[ir.Formula, Env] | None:
        match node.op:
            case "and":
                return self._pick(node, env, Extreme.LEAST)
            case "or":
                return self._pick(node, env, Extreme.GREATEST)
            case "xor" | "iff":
                sides = (node.left, node.right)
                undefined = [side for side in sides if self._verdict(side, env) == "undefined"]
                return (undefined or sides)[0], env
            case _:
                assert_never(node.op)

    def _quantify(self, node: ir.Quantify, env: Env) -> tuple[ir.Formula, Env] | None:
        level, inside = node.axis.level, range(self._values.count(node.axis))
        wanted = self._verdict(node, env)
        sides = self._values.sides(node.body, node.axis, env)
        least = node.extreme is Extreme.LEAST
        if node.guard is None:
            found = sides.first(wanted, inside, least)
            return None if found is None else (node.body, {**env, level: found})
        guard = self._values.sides(node.guard, node.axis, env)
        # By itself one decides this way; of which it is not known whether it is in range, one decides nothing, or makes all of it undefined.
        alone = node.extreme.decisive
        counted = guard.worst_sat if wanted == alone else guard.best_sat
        found = sides.first(wanted, [i for i in inside if counted[i]], least)
        if found is not None:
            return node.body, {**env, level: found}
        might = [i for i in inside if sides.verdict(i) == alone] if wanted == "undefined" else []
        doubtful = guard.first("undefined", might, least)
        return None if doubtful is None else (node.guard, {**env, level: doubtful})

    def _window(self, node: ir.Temporal | ir.Until | ir.Tallied, env: Env) -> range:
        begins, ends, low, high = measured(self._values.columns(node.axis), node.lower, node.upper)
        t, k = begins.tolist(), env[node.axis.level]
        e = t if ends is None else ends.tolist()
        if node.past:
            start = 0 if high is None else bisect_left(e, t[k] - high)
            return range(start, k + 1 if not low else bisect_right(t, t[k] - low))
        stop = len(t) if high is None else bisect_right(t, t[k] + high)
        return range(k if not low else bisect_left(e, t[k] + low), stop)

    def _tallied(self, node: ir.Tallied, env: Env) -> tuple[ir.Formula, Env] | None:
        """Of a count that is not known, the last sample of which it is not known whether it counts, or else whether the count starts anew with it; of any
        other count, no single sample decides."""
        if self._verdict(node, env) != "undefined":
            return None
        window, asked = self._window(node, env), [node.counted]
        if node.reset is not None:
            anew = self._values.sides(node.reset, node.axis, env).worst_sat
            window = range(next((j for j in reversed(window) if anew[j]), window.start), window.stop)
            asked.append(node.reset)
        for operand in asked:
            found = self._values.sides(operand, node.axis, env).first("undefined", reversed(window), True)
            if found is not None:
                return operand, {**env, node.axis.level: found}
        return None

    def _until(self, node: ir.Until, env: Env) -> tuple[ir.Formula, Env] | None:
        """At the sample of the window that decides, the right side or, where it was not held until then, the left one."""
        k, level = env[node.axis.level], node.axis.level
        window = self._window(node, env)
        if not window:
            return None
        wanted = self._verdict(node, env)
        left = self._values.sides(node.left, node.axis, env)
        right = self._values.sides(node.right, node.axis, env)
        outcomes: dict[int, float] = {}  # of the samples with the verdict of the whole
        held_sat, may_sat, held, most = (
            True,
            True,
            math.inf,
            math.inf,
        )  # of the left side, from k up to the sample
        ahead = not node.past
        for j in range(k, window.stop) if ahead else range(k, window.start - 1, -1):
            if j in window:
                holds, may = held_sat and right.worst_sat[j], may_sat and right.best_sat[j]
                if wanted == ("satisfied" if holds else "undefined" if may else "violated"):
                    outcomes[j] = min(held, right.worst[j]) if holds else min(most, right.best[j])
            held_sat, may_sat = held_sat and left.worst_sat[j], may_sat and left.best_sat[j]
            held, most = min(held, left.worst[j]), min(most, left.best[j])
        if not outcomes:
            return None
        at = min(outcomes) if wanted == "undefined" else max(sorted(outcomes), key=outcomes.__getitem__)
        before = left.first(wanted, range(k, at) if ahead else range(at + 1, k + 1), True)
        if right.verdict(at) == wanted and (
            before is None or right.margin(wanted, at) <= left.margin(wanted, before)
        ):
            return node.right, {**env, level: at}
        return None if before is None else (node.left, {**env, level: before})


def _places(node: ir.Formula, env: Env) -> tuple[tuple[str, int], ...]:
    """The samples and elements that a comparison reads, by signal and number (-1: the last), in order."""
    bound, fixed = _reads(node)
    found = {(signal, max(0, env[level] + offset)) for signal, level, offset in bound}
    return tuple(sorted(found | fixed))


@lru_cache(maxsize=4096)
def _reads(node: ir.Formula) -> tuple[set[tuple[str, int, int]], set[tuple[str, int]]]:
    """What a comparison reads: signal, level of the axis, offset; and what stands at one place, signal and number."""
    bound: set[tuple[str, int, int]] = set()
    fixed: set[tuple[str, int]] = set()
    for part in unbound(node):
        match part:
            case ir.Column():
                bound.add((part.axis.signal, part.axis.level, part.offset))
            case ir.Flag() if part.axis is not None:
                bound.add((part.signal, part.axis.level, part.offset))
            case ir.Sample():
                fixed.add((part.signal, part.index))
            case ir.Flag() if part.offset:
                fixed.add((part.signal, part.offset))
            case _:
                continue
    return bound, fixed
