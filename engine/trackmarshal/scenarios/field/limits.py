"""How far each parameter of a rule was from making it fire: the first value at which it would have, by bisection on the evaluator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.nodes import Param, below
from trackmarshal.ir.spec import ParamInfo, RuleInfo, remembers
from trackmarshal.runtime.frame import Frame, Settings
from trackmarshal.runtime.program import Program
from trackmarshal.runtime.verdict import UNSAFE, VERDICTS
from trackmarshal.scenarios.field.judged import Judgement, rated

_UNSAFE = [VERDICTS.index(name) for name in UNSAFE]
#: Frames that are looked at before all of them are.
_FEW = 150
#: Halvings: a range is known to a part in a million.
_STEPS = 20
#: How often frames that turn out to fire earlier are added.
_ROUNDS = 6


@dataclass(frozen=True, slots=True)
class Limit:
    """A parameter of a rule, its value, and the nearest ones below and above at which the rule would have fired, in SI; None where it does not
    up to the end of the declared range. `why`: why nothing was looked for; empty where it was."""

    rule: str
    param: str
    unit: str
    value: float
    below: float | None = None
    above: float | None = None
    lower: float | None = None
    upper: float | None = None
    why: str = ""


def limits(judged: Judgement, quiet_from: int = 0) -> list[Limit]:
    """Every parameter that a rule reads, for every rule that was active and did not fire in the cycles from `quiet_from` on.

    Found is the edge nearest to the value if there is one edge on each side: a rule that fires between two values and not beyond is not
    looked for.
    """
    result: list[Limit] = []
    frames = judged.frames[quiet_from:]
    unsafe, active = judged.unsafe[quiet_from:], judged.active[quiet_from:]
    for number, rule in enumerate(judged.evaluator.rules):
        names = params_of(rule)
        infos = [judged.evaluator.spec.params[name] for name in names]
        if not infos:
            result.append(Limit(rule.name, "", "", math.nan, why="it has no parameter"))
            continue
        if not active[:, :, number].any():
            result.append(
                Limit(
                    rule.name,
                    "",
                    "",
                    math.nan,
                    why="it had nothing to say: nothing that it speaks of was there",
                )
            )
            continue
        if unsafe[:, :, number].any():
            result.append(Limit(rule.name, "", "", math.nan, why="it fires with the values as they are"))
            continue
        if remembers(rule):
            why = "it is about cycles before, too: each value would be a run of its own"
            result.append(Limit(rule.name, "", "", math.nan, why=why))
            continue
        alone = Evaluator(judged.evaluator.spec, [rule.name], "numpy")
        # those with the least margins, and some of all the others
        order = np.argsort(
            np.nanmin(
                np.where(
                    np.isnan(judged.margins[quiet_from:, :, number]),
                    np.inf,
                    judged.margins[quiet_from:, :, number],
                ),
                axis=1,
            )
        )
        few = list(
            dict.fromkeys([*order[:_FEW].tolist(), *range(0, len(frames), max(1, len(frames) // _FEW))])
        )
        search = _Search(alone.program, frames, few)
        result += [_limit(rule, info, search) for info in infos]
    return result


def params_of(rule: RuleInfo) -> list[str]:
    """Qualified names of the parameters that a rule reads, definitions of its own included."""
    found: set[str] = set()
    for formula in (rule.formula, rule.active):
        if formula is not None:
            found |= {node.name for node in below(formula) if isinstance(node, Param)}
    return sorted(found)


def _limit(rule: RuleInfo, info: ParamInfo, search: _Search) -> Limit:
    short = info.short
    low = None if info.lower is None else search.edge(info.name, info.value, info.lower)
    high = None if info.upper is None else search.edge(info.name, info.value, info.upper)
    why = "" if info.lower is not None and info.upper is not None else "no range is declared for it"
    return Limit(rule.name, short, info.unit, info.value, low, high, info.lower, info.upper, why)


class _Search:
    """One rule on frames with other values of its parameters."""

    def __init__(self, program: Program, frames: Sequence[Frame], few: Sequence[int]) -> None:
        self._program, self._frames, self._few = program, frames, list(few)

    def edge(self, name: str, value: float, end: float) -> float | None:
        """The value nearest to `value` towards `end` at which the rule fires; None where it does not even at the end."""
        if value == end:
            return None
        looked = list(self._few)
        if not self._fires(looked, name, end).any():
            fires = self._fires(range(len(self._frames)), name, end)
            if not fires.any():
                return None
            looked = np.flatnonzero(fires)[:_FEW].tolist()
        for _ in range(_ROUNDS):
            quiet, loud = value, end
            for _ in range(_STEPS):
                middle = 0.5 * (quiet + loud)
                if self._fires(looked, name, middle).any():
                    loud = middle
                else:
                    quiet = middle
            earlier = np.flatnonzero(self._fires(range(len(self._frames)), name, quiet))
            if not len(earlier):
                return loud
            looked = earlier[:_FEW].tolist()
            end = quiet
        return loud

    def _fires(self, places: Sequence[int], name: str, value: float) -> NDArray[np.bool_]:
        """(places,) whether a candidate is unsafe with this value."""
        made: dict[int, Settings] = {}
        frames = []
        for place in places:
            frame = self._frames[place]
            settings = made.get(id(frame.settings))
            if settings is None:
                settings = replace(frame.settings, params={**frame.settings.params, name: value})
                made[id(frame.settings)] = settings
            frames.append(replace(frame, settings=settings))
        codes, _ = rated(self._program, frames, 1)
        fires: NDArray[np.bool_] = np.asarray(np.isin(codes[:, :, 0], _UNSAFE).any(axis=1))
        return fires
