"""The trajectories of a log's cycles: what was driven next, and braking to rest on the same path at the friction limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmarshal.scenarios.field.smoother import Motion
from trackmarshal.scenarios.recording import Columns
from trackmarshal.scenarios.trajectory import REST_SPEED

Floats = NDArray[np.float64]
#: Step in which the braking is integrated, s.
_FINE = 0.01
#: s: braking that takes longer than this is none.
LONGEST = 60.0
#: m: a way back that is shorter is noise, or rolling back; a longer one is driven backwards.
_BACK = 0.5


@dataclass(frozen=True, slots=True)
class Braking:
    """What tyres and brakes of the vehicle take, in SI, already with the declared share: `grip` and `brake` in m/s^2, `drag` in 1/m (force
    by mass and v^2)."""

    grip: float
    brake: float
    drag: float


class NoRest(Exception):
    """What brakes from this time on, s, still moves after `LONGEST`, and the log goes on: no end of the log says that there is no braking."""

    def __init__(self, t: float) -> None:
        super().__init__(t)
        self.t = t


def driving(motion: Motion, times: Floats, horizon: float, step: float) -> list[Columns]:
    """What was driven from each time on, over the horizon, a sample every `step`; columns in SI, s and t from 0."""
    after: Floats = np.arange(round(horizon / step) + 1, dtype=np.float64) * step
    grid = times[:, None] + after
    rows = {
        name: np.interp(grid, motion.t, column)
        for name, column in (("s", motion.s), ("x", motion.x), ("y", motion.y), ("heading", motion.heading),
                             ("v", motion.v), ("a", motion.a), ("kappa", motion.kappa))
    }  # fmt: skip
    rows["s"] -= rows["s"][:, :1]
    backwards = (np.diff(rows["s"]) < 0.0).any(axis=1)  # a way grows in reverse, too
    rows["s"][backwards, 1:] = np.abs(np.diff(rows["s"][backwards])).cumsum(axis=1)
    return [
        _columns(after, *(rows[name][i] for name in ("s", "x", "y", "heading", "kappa", "v", "a")))
        for i in range(len(times))
    ]


def emergency(motion: Motion, times: Floats, step: float, braking: Braking) -> list[Columns | None]:
    """From each time on: braking on the path that was driven, with all the grip that the bend leaves, to rest, where the last sample is.

    Never faster than was driven at the same place, so that it also stops where the car did. Tyres brake with
    sqrt(grip^2 - (v^2 kappa)^2), at most with `brake`, and drag brings v^2 * drag on top. None where the log ends before it stands; raises `NoRest`
    where it does not stand although the log goes on, as in a bend that takes all the grip.

    Where the car turns back, one path ends and the next one begins: what was driven backwards is braked backwards, and what is driven after it is
    not on what was driven before.
    """
    found: list[Columns | None] = [None] * len(times)
    for begin, end, sign in stretches(motion.s):
        first, last = motion.t[begin], motion.t[end]
        turns = end < len(motion.t) - 1
        which = np.flatnonzero((times >= first) & ((times < last) | (not turns)))
        stretch = _part(motion, begin, end, sign)
        if turns:  # between two samples it stands
            stretch.v[-1] = 0.0
        for i, columns in zip(which, _one_way(stretch, times[which], step, braking, turns)):
            if columns is not None and sign < 0:
                columns |= {name: [0.0 - value for value in columns[name]] for name in ("v", "a")}
            found[i] = columns
    return found


def stretches(s: Floats) -> list[tuple[int, int, int]]:
    """First and last sample, and 1 or -1 for ahead or back: where the way leads one way, but for less than `_BACK`."""
    found, begin, furthest, sign = [], 0, 0, 1
    for i, value in enumerate(s.tolist()):
        gained = sign * (value - s[furthest])
        if gained >= 0.0:
            furthest = i
        elif gained < -_BACK:
            if furthest > begin:
                found.append((begin, furthest, sign))
            begin, furthest, sign = furthest, i, -sign
    return [*found, (begin, len(s) - 1, sign)]


def _part(motion: Motion, begin: int, end: int, sign: int) -> Motion:
    """A stretch of a motion, as if it led ahead."""
    part = slice(begin, end + 1)
    return Motion(
        motion.t[part], sign * motion.s[part], motion.x[part], motion.y[part], motion.heading[part], sign * motion.v[part],
        sign * motion.a[part], motion.kappa[part], motion.standing[part], motion.innovations,
    )  # fmt: skip


def _one_way(
    motion: Motion, times: Floats, step: float, braking: Braking, turns: bool
) -> list[Columns | None]:
    """As `emergency`, of a motion that leads ahead. `turns`: it stands at its end."""
    count = len(times)
    way, path = _path(motion)
    s = np.interp(times, motion.t, motion.s)
    v = np.maximum(np.interp(times, motion.t, motion.v), 0.0)
    every = max(1, round(step / _FINE))
    fine = step / every
    kept_s, kept_v = [s.copy()], [v.copy()]
    kept_a: list[Floats] = []
    end_t, end_s = np.where(v > REST_SPEED, np.nan, 0.0), s.copy()
    final_a = np.zeros(count)
    now = 0.0
    while np.isnan(end_t).any() and now < LONGEST:
        for _ in range(every):
            kappa = np.interp(s, way, path["kappa"])
            across = v * v * kappa
            tyres = np.minimum(np.sqrt(np.maximum(braking.grip**2 - across * across, 0.0)), braking.brake)
            rate = tyres + braking.drag * v * v
            slower = np.maximum(v - rate * fine, 0.0)
            ahead = s + 0.5 * (v + slower) * fine
            driven = np.maximum(np.interp(ahead, way, path["v"]), 0.0)
            slower = np.minimum(slower, driven)
            rate = (v - slower) / fine
            if now == 0.0 and not kept_a:
                kept_a.append(-rate)
            stops = np.isnan(end_t) & (slower <= REST_SPEED)
            # it stands within the step: as long as its speed lasts at this rate
            hardest = np.maximum(tyres + braking.drag * v * v, rate)
            rest = np.minimum(v / np.maximum(hardest, 1e-9), fine)
            end_t = np.where(stops, now + rest, end_t)
            end_s = np.where(stops, s + 0.5 * v * rest, end_s)
            final_a = np.where(stops, -hardest, final_a)
            going = np.isnan(end_t)
            s = np.where(going, s + 0.5 * (v + slower) * fine, end_s)
            v = np.where(going, slower, 0.0)
            last = rate
            now += fine
        kept_s.append(s.copy())
        kept_v.append(v.copy())
        kept_a.append(np.where(np.isnan(end_t), -last, final_a))
    if not kept_a:
        kept_a.append(np.zeros(count))
    moves = np.flatnonzero(np.isnan(end_t) & (s <= motion.s[-1]))
    if len(moves):
        raise NoRest(float(times[moves[0]]))
    if turns:
        end_s = np.minimum(end_s, motion.s[-1])
    all_s, all_v, all_a = np.array(kept_s), np.array(kept_v), np.array(kept_a)
    return [
        _braked(
            step,
            all_s[:, i],
            all_v[:, i],
            all_a[:, i],
            end_t[i],
            end_s[i],
            final_a[i],
            way,
            path,
            motion.s[-1],
        )
        for i in range(count)
    ]


def _braked(
    step: float, s: Floats, v: Floats, a: Floats, end_t: float, end_s: float, end_a: float, way: Floats, path: dict[str, Floats],
    most: float,
) -> Columns | None:  # fmt: skip
    """One braking, cut at rest."""
    if np.isnan(end_t) or end_s > most:
        return None
    if end_t == 0.0:  # it stands: one place, for one step
        t, s, v, a = np.array([0.0, step]), s[[0, 0]], np.zeros(2), np.zeros(2)
    else:
        end_t = max(float(end_t), 1e-3)  # times are rounded, and have to increase
        # a sample so shortly before the end says nothing more
        whole = int(np.ceil((end_t - 0.1 * step) / step))
        t = np.append(np.arange(max(whole, 1)) * step, end_t)
        s = np.append(s[: len(t) - 1], end_s)
        v = np.append(v[: len(t) - 1], 0.0)
        a = np.append(a[: len(t) - 1], end_a)
    x, y, heading, kappa = (np.interp(s, way, path[name]) for name in ("x", "y", "heading", "kappa"))
    return _columns(t, s - s[0], x, y, heading, kappa, v, a)


def _path(motion: Motion) -> tuple[Floats, dict[str, Floats]]:
    """Everything over the way, each place once: of a standstill, its last sample; where it rolled back, it does not go on."""
    furthest = np.maximum.accumulate(motion.s)
    keep = np.append(np.diff(furthest) > 0.0, True)
    columns = {"x": motion.x, "y": motion.y, "heading": motion.heading, "kappa": motion.kappa, "v": motion.v}
    return furthest[keep], {name: column[keep] for name, column in columns.items()}


def _columns(
    t: Floats, s: Floats, x: Floats, y: Floats, heading: Floats, kappa: Floats, v: Floats, a: Floats
) -> Columns:
    """As a recording has them: lists, headings in (-pi, pi]; rounded to a micrometre, which keeps files small."""
    wrapped = np.angle(np.exp(1j * heading))
    named = {"t": t, "s": s, "x": x, "y": y, "heading": wrapped, "kappa": kappa, "v": v, "a": a}
    return {
        name: [float(value) for value in np.round(column, 9 if name == "kappa" else 6)]
        for name, column in named.items()
    }
