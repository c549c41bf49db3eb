"""What a drive shows about the rules: firings by cause, how often, the least margins, and how far parameters were from firing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.scenarios.field.build import Drive, standing_time
from trackmarshal.scenarios.field.candidates import stretches
from trackmarshal.scenarios.field.causes import CAUSES, Firing, firings, unheard
from trackmarshal.scenarios.field.judged import Judgement
from trackmarshal.scenarios.field.limits import Limit
from trackmarshal.scenarios.field.smoother import Motion
from trackmarshal.scenarios.recording import CANDIDATES
from trackmarshal.units import from_si, written

Floats = NDArray[np.float64]
FORMAT = "trackmarshal-field-report"
VERSION = 1
#: s: what the times of cycles are rounded to, which are those of rows.
_ROUNDED = 1e-6


@dataclass(frozen=True, slots=True)
class Rate:
    """How often a rule fired for a cause: firings, cycles in them, and firings by hour and by kilometre (None where nothing was driven)."""

    rule: str
    cause: str
    firings: int
    cycles: int
    per_hour: float
    per_km: float | None


@dataclass(frozen=True, slots=True)
class Margin:
    """The least margin of a rule for a candidate, SI, in a cycle that is not put down to the map; `said`: how people read it."""

    rule: str
    candidate: str
    margin: float
    unit: str
    said: str
    t: float


@dataclass(frozen=True, slots=True)
class Report:
    """Everything; `logged`: rates of the log as it is, without its declared noise; None where that was not looked at."""

    drive: Drive
    hours: float
    km: float
    residuals: dict[str, dict[str, float]]
    firings: list[Firing]
    rates: list[Rate]
    logged: list[Rate] | None
    margins: list[Margin]
    silent: list[str]
    limits: list[Limit] | None
    begin: float
    end: float
    cycles: int
    #: What there is to know of the log and of its mapping beside that.
    notes: list[str]


def report(
    drive: Drive,
    judged: Judgement,
    logged: tuple[Drive, Judgement] | None = None,
    limits: list[Limit] | None = None,
) -> Report:
    """`logged`: the same log without smoother, for what noise makes of the rules; its cycles are the same ones."""
    found = firings(drive, judged)
    begin, end = float(judged.times[0]), float(judged.times[-1])
    hours = (end - begin + 1.0 / drive.mapping.rate) / 3600.0
    km = _way(drive.motion, begin, end) / 1000.0
    as_logged = [] if logged is None else firings(*logged, judged)
    raw = None if logged is None else _rates(as_logged, hours, km)
    notes = [*drive.recording.notes, *unheard(drive, judged, [*found, *as_logged])]
    margins, silent = _margins(judged, found)
    return Report(
        drive, hours, km, residuals(drive, begin, end), found, _rates(found, hours, km), raw, margins, silent, limits, begin, end,
        len(judged.times), notes,
    )  # fmt: skip


def _way(motion: Motion, begin: float, end: float) -> float:
    """How far the car went between two times, m: ahead and back alike."""
    turns = [float(motion.t[last]) for _, last, _ in stretches(motion.s)]
    times = [begin, *(t for t in turns if begin < t < end), end]
    return float(np.abs(np.diff(np.interp(times, motion.t, motion.s))).sum())


def residuals(drive: Drive, begin: float = 0.0, end: float = math.inf) -> dict[str, dict[str, float]]:
    """What the log is apart from the motion in a part of it: along and beside the heading, heading, speed; deviation, 99.9 % and the most.

    `lag`, s: how late the speed column follows a change of speed (least squares over the moving part).
    """
    log, motion = drive.log, drive.motion
    part = (log.t >= begin - _ROUNDED) & (log.t <= end + _ROUNDED)
    dx, dy, c, s = log.x - motion.x, log.y - motion.y, np.cos(motion.heading), np.sin(motion.heading)
    columns = {
        "along": dx * c + dy * s, "beside": dy * c - dx * s, "heading": np.angle(np.exp(1j * (log.heading - motion.heading))),
        "speed": log.v - motion.v,
    }  # fmt: skip
    result: dict[str, dict[str, float]] = {}
    for name, column in columns.items():
        values = column[part]
        result[name] = {
            "deviation": float(values.std()), "p999": float(np.quantile(np.abs(values), 0.999)), "most": float(np.abs(values).max()),
        }  # fmt: skip
    moving = part & ~motion.standing
    if np.count_nonzero(moving) > 3:
        terms = np.column_stack([np.ones(np.count_nonzero(moving)), -motion.a[moving], motion.v[moving]])
        found = np.linalg.lstsq(terms, columns["speed"][moving], rcond=None)[0]
        rest = columns["speed"][moving] - terms @ found
        result["speed"] |= {
            "lag": float(found[1]),
            "scale": float(found[2]),
            "beside_lag": float(np.abs(rest).max()),
        }
    return result


def _rates(found: Sequence[Firing], hours: float, km: float) -> list[Rate]:
    keys = sorted({(one.rule, one.cause) for one in found}, key=lambda key: (key[0], CAUSES.index(key[1])))
    result = []
    for rule, cause in keys:
        own = [one for one in found if (one.rule, one.cause) == (rule, cause)]
        per_km = len(own) / km if km > 0.001 else None
        result.append(Rate(rule, cause, len(own), sum(one.cycles for one in own), len(own) / hours, per_km))
    return result


def _margins(judged: Judgement, found: Sequence[Firing]) -> tuple[list[Margin], list[str]]:
    """The least margins, and the rules that had nothing to say."""
    margins, silent = [], []
    for number, rule in enumerate(judged.evaluator.rules):
        if not judged.active[:, :, number].any():
            silent.append(rule.name)
            continue
        left_out = np.zeros(len(judged.times), np.bool_)
        for one in found:
            if one.rule == rule.name and one.cause == CAUSES[0]:
                left_out |= (judged.times >= one.begin) & (judged.times <= one.end)
        for candidate, name in enumerate(CANDIDATES):
            said = (
                judged.active[:, candidate, number]
                & ~left_out
                & np.isfinite(judged.margins[:, candidate, number])
            )
            if not said.any():
                continue
            places = np.flatnonzero(said)
            place = int(places[np.argmin(judged.margins[places, candidate, number])])
            result = judged.result(place, candidate, number)
            text = written(result.margin, result.unit, result.shown)
            margins.append(
                Margin(rule.name, name, result.margin, result.unit, text, float(judged.times[place]))
            )
    return margins, silent


def data(made: Report) -> dict[str, Any]:
    """As strict JSON takes it."""
    mapping, drive = made.drive.mapping, made.drive
    return {
        "format": FORMAT, "version": VERSION, "name": mapping.name,
        "log": {"path": drive.log.path, "sha256": drive.log.sha256, "origin": drive.log.origin},
        "made_from": drive.sources, "notes": made.notes,
        "from": made.begin, "to": made.end, "cycles": made.cycles, "rate": mapping.rate, "hours": made.hours, "km": made.km,
        "standing": standing_time(drive.motion), "smoother": drive.smoother, "noise": drive.noise.named(),
        "innovations": {name: float(value) for name, value in drive.motion.innovations.items()}, "residuals": made.residuals,
        "firings": [
            {"rule": f.rule, "candidates": list(f.candidates), "from": f.begin, "to": f.end, "cycles": f.cycles, "cause": f.cause,
             "because": f.because, "worst": _number(f.worst[2])}
            for f in made.firings
        ],
        "rates": [_rate(rate) for rate in made.rates],
        "rates_as_logged": None if made.logged is None else [_rate(rate) for rate in made.logged],
        "margins": [
            {"rule": m.rule, "candidate": m.candidate, "margin": _number(m.margin), "unit": m.unit, "shown": m.said, "t": m.t}
            for m in made.margins
        ],
        "silent": made.silent,
        "limits": None if made.limits is None else [
            {"rule": one.rule, "param": one.param, "unit": one.unit, "value": _number(one.value), "below": one.below, "above": one.above,
             "range": [one.lower, one.upper], "why": one.why}
            for one in made.limits
        ],
    }  # fmt: skip


def _rate(rate: Rate) -> dict[str, Any]:
    return {
        "rule": rate.rule, "cause": rate.cause, "firings": rate.firings, "cycles": rate.cycles, "per_hour": rate.per_hour, "per_km": rate.per_km,
    }  # fmt: skip


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def text(made: Report, table: Any) -> Iterator[str]:
    """Lines for people; `table` lays out rows below their heads."""
    yield (
        f"{made.drive.mapping.name}: {made.cycles} cycles from {made.begin:g} to {made.end:g} s: {made.hours:.4g} h, {made.km:.4g} km"
    )
    yield from made.notes
    rows = [
        [name, *(f"{stats[key]:.3g}" for key in ("deviation", "p999", "most"))]
        for name, stats in made.residuals.items()
    ]
    yield ""
    yield from table(rows, ["log apart from motion", "deviation", "99.9 %", "most"])
    speed = made.residuals["speed"]
    if "lag" in speed:
        yield (
            f"the speed column follows {1000 * speed['lag']:.0f} ms late, reads {100 * speed['scale']:+.2g} %, and is at most {speed['beside_lag']:.3g} m/s beside that"
        )
    yield ""
    if made.logged is not None:
        yield "firings of the log as it is:"
        yield from _table_of(made.logged, table)
        yield ""
    yield "firings with the declared noise:" if made.drive.smoother else "firings:"
    yield from _table_of(made.rates, table)
    for one in made.firings:
        why = f" ({one.because})" if one.because else ""
        yield f"  {one.begin:g} to {one.end:g} s: {one.rule}, {' and '.join(one.candidates) or 'the cycle'}, {one.cause}{why}"
    yield ""
    yield from table(
        [[m.rule, m.candidate, m.said, f"{m.t:g}"] for m in made.margins],
        ["rule", "candidate", "least margin", "at s"],
    )
    if made.silent:
        yield f"not shown by this drive, as nothing that they speak of was there: {', '.join(made.silent)}"
    if made.limits is not None:
        yield ""
        yield from table(
            list(_limit_rows(made.limits)),
            ["rule", "parameter", "value", "fires from (less)", "fires from (more)"],
        )


def _table_of(rates: Sequence[Rate], table: Any) -> Iterable[str]:
    if not rates:
        return ["  none"]
    rows = [
        [
            r.rule,
            r.cause,
            str(r.firings),
            str(r.cycles),
            f"{r.per_hour:.3g}",
            "-" if r.per_km is None else f"{r.per_km:.3g}",
        ]
        for r in rates
    ]
    lines: list[str] = table(rows, ["rule", "cause", "firings", "cycles", "per hour", "per km"])
    return lines


def _limit_rows(limits: Sequence[Limit]) -> Iterator[list[str]]:
    for one in limits:
        if not one.param:
            yield [one.rule, "-", "-", one.why, ""]
            continue
        cells = [
            "-" if end is None else f"not down to {_in(end, one)}" if edge is None and end == one.lower
            else f"not up to {_in(end, one)}" if edge is None else _in(edge, one)
            for edge, end in ((one.below, one.lower), (one.above, one.upper))
        ]  # fmt: skip
        yield [one.rule, one.param, _in(one.value, one), *cells]


def _in(value: float, limit: Limit) -> str:
    number = from_si(value, limit.unit)
    return f"{number:.4g}" if limit.unit == "1" else f"{number:.4g} {limit.unit}"
