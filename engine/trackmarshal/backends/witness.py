"""Which comparison decided a formula, and at which sample or object: one descent for all evaluators."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.verdict import Truth, Witness

Env = dict[int, int]


class Values(Protocol):
    """What a descent asks of an evaluator, for one case."""

    def truth(self, node: ir.Formula, env: Env) -> Truth: ...

    def count(self, axis: ir.Axis) -> int: ...

    def times(self, axis: ir.Axis) -> Sequence[float]: ...

    def name(self, axis: ir.Axis, index: int) -> int | str: ...


#: A choice of where to go on: the formula, its environment, and the margin it contributes.
Branch = tuple[ir.Formula, Env, float]


class Descent:
    """Finds the deciding comparison of formulas of one case."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._names: dict[int, tuple[ir.Axis, tuple[str, ...]]] = {}
        #: The deciding comparison that was found last, and where it was evaluated.
        self.decisive: tuple[ir.Formula, Env] | None = None

    def find(self, node: ir.Formula | None) -> Witness | None:
        """The witness of a closed formula; None where nothing decides (an empty range, a constant)."""
        self._names, self.decisive = {}, None
        env: Env = {}
        while node is not None:
            step = self._step(node, env)
            if isinstance(step, Witness):
                self.decisive = (node, env)
                return step
            if step is None:
                return None
            node, env = step
        return None

    def _step(self, node: ir.Formula, env: Env) -> Witness | tuple[ir.Formula, Env] | None:
        match node:
            case ir.Compare() | ir.Geometry() | ir.Flag():
                return self._witness(node, env)
            case ir.Truth():
                return None
            case ir.Not():
                return node.operand, env
            case ir.Connective():
                return self._connective(node, env)
            case ir.Quantify():
                self._names[node.axis.level] = (node.axis, node.names)
                return self._quantify(node, env)
            case ir.Guarded():
                guard = self._values.truth(node.guard, env)
                if self._verdict(node, env) == "undefined" and self._verdict(node.body, env) != "undefined":
                    return node.guard, env
                return (node.body, env) if guard.best.sat else None
            case ir.First():
                self._names[node.axis.level] = (node.axis, (node.name,))
                return node.operand, {**env, node.axis.level: 0}
            case ir.Temporal():
                samples = self._window(node, env)
                pick = min if node.op in ("always", "historically") else max
                return self._pick(node, env, pick, ((node.operand, {**env, node.axis.level: j}, 1) for j in samples))
            case ir.Until():
                return self._until(node, env)
            case ir.Shift():
                sample = env[node.axis.level] + node.step
                inside = 0 <= sample < self._values.count(node.axis)
                return (node.operand, {**env, node.axis.level: sample}) if inside else None
            case ir.Edge():
                return self._edge(node, env)
            case _:
                raise AssertionError(f"unknown formula {type(node).__name__}")

    def _verdict(self, node: ir.Formula, env: Env) -> str:
        return self._values.truth(node, env).verdict

    def _witness(self, node: ir.Compare | ir.Geometry | ir.Flag, env: Env) -> Witness:
        binders: dict[str, int | str] = {}
        for level, (axis, names) in sorted(self._names.items()):
            if level in env:
                for offset, name in enumerate(names):
                    binders[name] = self._values.name(axis, env[level] + offset)
        unit = node.unit if isinstance(node, ir.Compare) else "m" if isinstance(node, ir.Geometry) else "1"
        return Witness(binders, self._values.truth(node, env).margin, unit, node.span)

    def _pick(
        self, node: ir.Formula, env: Env, pick: Callable[..., Branch], branches: Iterable[tuple[ir.Formula, Env, int]]
    ) -> tuple[ir.Formula, Env] | None:
        """The branch with the verdict of the whole (negated ones count reversed) and the deciding margin."""
        wanted = self._verdict(node, env)
        fitting: list[Branch] = []
        for child, inner, sign in branches:
            value = self._values.truth(child, inner)
            verdict = value.verdict if sign > 0 else _NEGATED[value.verdict]
            if verdict == wanted:
                fitting.append((child, inner, 0.0 if verdict == "undefined" else sign * value.margin))
        if not fitting:
            return None
        child, inner, _ = pick(fitting, key=lambda branch: branch[2])
        return child, inner

    def _connective(self, node: ir.Connective, env: Env) -> tuple[ir.Formula, Env] | None:
        left, right = (node.left, env, 1), (node.right, env, 1)
        if node.op == "and":
            return self._pick(node, env, min, (left, right))
        if node.op == "or":
            return self._pick(node, env, max, (left, right))
        if node.op == "implies":
            return self._pick(node, env, max, ((node.left, env, -1), right))
        undefined = [b for b in (left, right) if self._verdict(b[0], env) == "undefined"]
        return (undefined or [left])[0][:2]

    def _quantify(self, node: ir.Quantify, env: Env) -> tuple[ir.Formula, Env] | None:
        inside: list[tuple[ir.Formula, Env, int]] = []
        doubtful: list[tuple[ir.Formula, Env]] = []
        for index in range(self._values.count(node.axis)):
            inner = {**env, node.axis.level: index}
            guard = "satisfied" if node.guard is None else self._verdict(node.guard, inner)
            if guard == "satisfied":
                inside.append((node.body, inner, 1))
            elif guard == "undefined" and node.guard is not None:
                inside.append((node.body, inner, 1))
                doubtful.append((node.guard, inner))
        found = self._pick(node, env, min if node.quantifier == "for all" else max, inside)
        if found is None and self._verdict(node, env) == "undefined" and doubtful:
            return doubtful[0]
        return found

    def _window(self, node: ir.Temporal | ir.Until, env: Env) -> range:
        t, k = self._values.times(node.axis), env[node.axis.level]
        low, high = node.lower, node.upper
        if node.op in ("historically", "once", "since"):
            start = 0 if high is None else bisect_left(t, t[k] - high)
            return range(start, k + 1 if low is None else bisect_right(t, t[k] - low))
        stop = len(t) if high is None else bisect_right(t, t[k] + high)
        return range(k if low is None else bisect_left(t, t[k] + low), stop)

    def _until(self, node: ir.Until, env: Env) -> tuple[ir.Formula, Env] | None:
        k, level = env[node.axis.level], node.axis.level
        best: tuple[float, list[tuple[ir.Formula, Env, int]]] | None = None
        wanted = self._verdict(node, env)
        for j in self._window(node, env):
            held = range(k, j) if node.op == "until" else range(j + 1, k + 1)
            parts: list[tuple[ir.Formula, Env, int]] = [(node.right, {**env, level: j}, 1)]
            parts += [(node.left, {**env, level: i}, 1) for i in held]
            values = [self._values.truth(child, inner) for child, inner, _ in parts]
            worst = all(v.worst.sat for v in values)
            verdict = "satisfied" if worst else "undefined" if all(v.best.sat for v in values) else "violated"
            margin = min(v.worst.margin if verdict == "satisfied" else v.best.margin for v in values)
            if verdict == wanted and (best is None or (verdict != "undefined" and margin > best[0])):
                fitting = [p for p, v in zip(parts, values) if v.verdict == verdict]
                best = (margin, fitting)
        if best is None or not best[1]:
            return None
        return min(best[1], key=lambda p: 0.0 if wanted == "undefined" else self._values.truth(p[0], p[1]).margin)[:2]

    def _edge(self, node: ir.Edge, env: Env) -> tuple[ir.Formula, Env] | None:
        level = node.axis.level
        now, sign = (node.operand, env), 1 if node.op == "rising" else -1
        if env[level] == 0:
            return now
        before = {**env, level: env[level] - 1}
        return self._pick(node, env, min, ((node.operand, before, -sign), (node.operand, env, sign))) or now


_NEGATED = {"satisfied": "violated", "violated": "satisfied", "undefined": "undefined"}
