"""Why a rule did not apply: the `whenever` that did not hold, or what was left out of a quantifier's range, and for which reason."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol, assert_never

from trackmarshal import typed
from trackmarshal.backends.over_run.history import History
from trackmarshal.explaining.numbers import Env
from trackmarshal.explaining.trail import shortened
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import over_run, sets
from trackmarshal.lowering.rules import Level
from trackmarshal.runtime.verdict import Truth

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

#: The most elements that are told one by one.
MOST = 8


class Cycle(Protocol):
    """One cycle: what formulas come to in it."""

    @property
    def values(self) -> Reference: ...

    def truth(self, node: ir.Formula, env: Env) -> Truth: ...


class Alone(NamedTuple):
    """A cycle for rules that ask for no other."""

    values: Reference

    def truth(self, node: ir.Formula, env: Env) -> Truth:
        return self.values.truth(node, env)


class InRun(NamedTuple):
    """Cycle `place` of a run."""

    values: Reference
    history: History
    place: int

    def truth(self, node: ir.Formula, env: Env) -> Truth:
        if not over_run(node):
            return self.values.truth(node, env)
        here = self.history.cycles[self.place].ids
        ids = {axis.level: here[axis.signal][env[axis.level]] for axis in sets(node)}
        return self.history.value(node, self.place, ids).value


def why_inactive(levels: Sequence[Level], cycle: Cycle) -> list[str]:
    """A line for each clause on the way to the first that leaves nothing; none where all of them leave something."""
    return list(_told(levels, cycle, {}))


def _told(levels: Sequence[Level], cycle: Cycle, env: Env) -> Iterator[str]:
    for number, level in enumerate(levels):
        clause = level.clause
        match clause:
            case typed.Along():
                assert level.axis is not None
                env = {**env, level.axis.level: cycle.values.columns(level.axis).place(clause.place)}
            case typed.Whenever():
                assert level.guard is not None
                if not cycle.truth(level.guard, env).best.sat:
                    yield f"{shortened(clause.span)}: does not hold"
                    return
            case typed.ForEach():
                if clause.quantifier == "exists":
                    return
                inside, outside = _parted(level, cycle, env)
                yield from outside
                for each in inside:
                    yield from _told(levels[number + 1 :], cycle, each)
                return
            case _:
                assert_never(clause)


def _parted(level: Level, cycle: Cycle, env: Env) -> tuple[list[Env], list[str]]:
    """What variables stand for in range, and a line on what is not."""
    assert level.axis is not None
    assert isinstance(level.clause, typed.ForEach)
    text = shortened(level.clause.span)
    count = cycle.values.count(level.axis)
    if not count:
        return [], [f"{text}: there is none in `{level.axis.signal}`"]
    inside: list[Env] = []
    reasons: dict[str, list[str]] = {}
    for index in range(count):
        here = {**env, level.axis.level: index}
        reason = _left_out(level, cycle, here)
        if reason is None:
            inside.append(here)
        else:
            reasons.setdefault(reason, []).append(str(cycle.values.name(level.axis, index)))
    if level.by is not None and inside:
        by = level.by
        inside = [min(inside, key=lambda each: cycle.values.number(by, each))]
    return inside, [f"{text}: {_listed(names)}: {reason}" for reason, names in reasons.items()]


def _left_out(level: Level, cycle: Cycle, env: Env) -> str | None:
    if level.guard is not None and not cycle.truth(level.guard, env).best.sat:
        return "its `where` does not hold"
    for clause, condition in level.excepted:
        if cycle.truth(condition, env).worst.sat:
            return f"left out, {clause.reason}"
    return None


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return ", ".join(names[:MOST]) + more
