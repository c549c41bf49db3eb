"""What a firing comes from: the map, noise, the rule, or something real. Nothing is put down to a cause that is not shown or declared."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.scenarios.field.build import Drive
from trackmarshal.scenarios.field.judged import CONTRACT, Judgement
from trackmarshal.scenarios.recording import CANDIDATES

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
MAP, NOISE, RULE, REAL = "map gap", "noise", "rule", "real"
CAUSES = (MAP, NOISE, RULE, REAL)


@dataclass(frozen=True, slots=True)
class Firing:
    """A rule that made a candidate unsafe in consecutive cycles from begin to end, s, for one cause; worst: cycle, candidate and margin."""

    rule: str
    candidates: tuple[str, ...]
    begin: float
    end: float
    cycles: int
    cause: str
    because: str
    worst: tuple[int, int, float]


def firings(drive: Drive, judged: Judgement, clean: Judgement | None = None) -> list[Firing]:
    """Every firing of a run, in order of time; of consecutive cycles with one cause, one.

    `clean` is the same drive with its declared noise: what does not fire there, in the same cycle, is noise. A firing of a rule that reads the
    road is a gap of the map where the mapping declares one and the car itself, in the part of it that the trajectory is about, had a
    corner off the road. A person's word in `findings` counts after that, and what is left is real.
    """
    found: list[Firing] = []
    unsafe = judged.unsafe
    off = _Off(drive, judged)
    for number, rule in enumerate(judged.evaluator.rules):
        fired = np.flatnonzero(unsafe[:, :, number].any(axis=1))
        road = reads_road(rule, judged.evaluator.spec)
        quiet = clean_of(clean, number, len(judged.times))
        causes = [
            (int(place), *_cause(drive, judged, rule.name, int(place), off if road else None, bool(quiet[place])))
            for place in fired
        ]  # fmt: skip
        found += _grouped(judged, rule.name, number, causes)
    return sorted([*found, *_breaches(drive, judged, clean)], key=lambda one: (one.begin, one.rule))


def unheard(drive: Drive, judged: Judgement, found: Iterable[Firing]) -> list[str]:
    """What the mapping says of firings, and no firing answers to: a word that is no longer needed, or was meant for another rule or time.

    `found`: the firings of all ways in which the log was looked at. Of rules that were not asked, and of times that were not, nothing is said.
    """
    mapping, spec = drive.mapping, judged.evaluator.spec
    known, asked = [rule.name for rule in spec.rules], {rule.name for rule in judged.evaluator.rules}
    begin, end = float(judged.times[0]), float(judged.times[-1])
    said = list(found)
    of_road = any(reads_road(rule, spec) for rule in judged.evaluator.rules)
    notes = []
    for gap in mapping.gaps:
        looked = of_road and gap.begin <= end + mapping.horizon and begin <= gap.end
        if looked and not any(one.cause == MAP and one.because == gap.because for one in said):
            notes.append(
                f"gaps: from {gap.begin:g} to {gap.end:g} s, no rule that was asked fires for that ({gap.because})"
            )
    for finding in mapping.findings:
        what = f"findings: {finding.rule} from {finding.begin:g} to {finding.end:g} s"
        if finding.rule != CONTRACT and finding.rule not in known:
            help_ = close_matches(finding.rule, known)
            notes.append(f"{what}: there is no such rule{f'; {help_}' if help_ else ''}")
        elif finding.rule in {CONTRACT, *asked} and finding.begin <= end and begin <= finding.end:
            answers = (finding.rule, finding.cause, finding.because)
            if not any((one.rule, one.cause, one.because) == answers for one in said):
                notes.append(f"{what}: it does not fire there, or for another cause ({finding.because})")
    return notes


def _breaches(drive: Drive, judged: Judgement, clean: Judgement | None) -> list[Firing]:
    """What breaks the input contract: of consecutive cycles with one cause and one kind of fault of one field, one, with the first one's words."""
    found: list[Firing] = []
    last: tuple[int, str, str, str] | None = None
    for place, fault in sorted(judged.faults.items()):
        cause, because = _cause(
            drive, judged, CONTRACT, place, None, clean is not None and place not in clean.faults
        )
        what = fault.partition(":")[0].partition("[")[0]  # code and field: numbers differ from cycle to cycle
        t = float(judged.times[place])
        if last == (place - 1, cause, because, what):
            found[-1] = replace(found[-1], end=t, cycles=found[-1].cycles + 1)
        else:
            found.append(Firing(CONTRACT, (), t, t, 1, cause, because or fault, (place, 0, float("nan"))))
        last = place, cause, because, what
    return found


def clean_of(clean: Judgement | None, rule: int, cycles: int) -> Flags:
    """(cycles,) where a rule does not fire with the declared noise; nowhere, where that was not looked at."""
    if clean is None:
        return np.zeros(cycles, np.bool_)
    return np.asarray(~clean.unsafe[:, :, rule].any(axis=1))


def reads_road(rule: RuleInfo, spec: Spec) -> bool:
    """Whether a rule reads borders or lines that a map has."""
    return any(
        spec.signals[name].kind in ("corridor", "polyline") for name, _ in rule.reads if name in spec.signals
    )


def _cause(
    drive: Drive, judged: Judgement, rule: str, place: int, off: _Off | None, calm: bool
) -> tuple[str, str]:
    if calm:
        return NOISE, "does not fire with the declared noise"
    t = float(judged.times[place])
    if off is not None:
        gap = off.gap(place)
        if gap:
            return MAP, gap
    for finding in drive.mapping.findings:
        if finding.rule == rule and finding.begin <= t <= finding.end:
            return finding.cause, finding.because
    return REAL, ""


def _grouped(judged: Judgement, rule: str, number: int, causes: list[tuple[int, str, str]]) -> list[Firing]:
    runs: list[list[tuple[int, str, str]]] = []
    for entry in causes:
        if runs and runs[-1][-1][0] == entry[0] - 1 and runs[-1][-1][1:] == entry[1:]:
            runs[-1].append(entry)
        else:
            runs.append([entry])
    return [_firing(judged, rule, number, run) for run in runs]


def _firing(judged: Judgement, rule: str, number: int, run: list[tuple[int, str, str]]) -> Firing:
    places = [entry[0] for entry in run]
    unsafe = judged.unsafe[places, :, number]
    margins = np.where(unsafe, judged.margins[places, :, number], np.inf)
    shown = np.where(
        np.isnan(margins), np.inf, margins
    )  # an undefined one is the worst only where nothing else is
    where = np.unravel_index(int(np.argmin(shown)), shown.shape)
    if not np.isfinite(shown[where]):
        where = np.unravel_index(int(np.argmax(unsafe)), unsafe.shape)
    row, candidate = int(where[0]), int(where[1])
    names = tuple(name for i, name in enumerate(CANDIDATES) if unsafe[:, i].any())
    begin, end = float(judged.times[places[0]]), float(judged.times[places[-1]])
    worst = (places[row], candidate, float(judged.margins[places[row], candidate, number]))
    return Firing(rule, names, begin, end, len(run), run[0][1], run[0][2], worst)


class _Off:
    """Where, in the declared gaps of the map, a corner of the car itself was off the road."""

    def __init__(self, drive: Drive, judged: Judgement) -> None:
        self._drive, self._judged = drive, judged
        self._times: Floats | None = None

    def gap(self, place: int) -> str:
        """Why the map is not to be believed about the trajectories of a cycle; empty where it is."""
        drive, t = self._drive, float(self._judged.times[place])
        until = t + drive.mapping.horizon
        for gap in drive.mapping.gaps:
            begin, end = max(t, gap.begin), min(until, gap.end)
            if begin > end:
                continue
            times = self._outside()
            if ((times >= begin) & (times <= end)).any():
                return gap.because
        return ""

    def _outside(self) -> Floats:
        """Times of rows of the log within declared gaps with a corner of the car off the road."""
        if self._times is None:
            log, params = self._drive.log, self._judged.evaluator.spec.params
            sizes = {info.short: info.value for info in params.values()}
            length, width = sizes.get("length", 0.0), sizes.get("width", 0.0)
            rows = np.zeros(len(log.t), np.bool_)
            for gap in self._drive.mapping.gaps:
                rows |= (log.t >= gap.begin) & (log.t <= gap.end)
            places = np.flatnonzero(rows)
            c, s = np.cos(log.heading[places]), np.sin(log.heading[places])
            off = np.zeros(len(places), np.bool_)
            for along, across in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                a, b = 0.5 * along * length, 0.5 * across * width
                off |= ~on_road(
                    log.x[places] + a * c - b * s, log.y[places] + a * s + b * c, self._drive.recording.track
                )
            self._times = log.t[places[off]]
        return self._times


def on_road(x: Floats, y: Floats, track: dict[str, object]) -> Flags:
    """(n,) whether points lie between the borders: inside one ring and not the other of a closed track, inside the one ring of an open one."""
    left, right = np.asarray(track["left"], dtype=float), np.asarray(track["right"], dtype=float)
    if track.get("closed"):
        return np.asarray(_inside(x, y, left) != _inside(x, y, right))
    return _inside(x, y, np.vstack([left, right[::-1]]))


def _inside(x: Floats, y: Floats, ring: Floats) -> Flags:
    """Even-odd rule: a ray to the right crosses the ring an odd number of times."""
    odd = np.zeros(len(x), np.bool_)
    for start in range(0, len(x), 500):
        px, py = x[start : start + 500, None], y[start : start + 500, None]
        ax, ay = ring[:, 0], ring[:, 1]
        bx, by = np.roll(ax, -1), np.roll(ay, -1)
        spans = (ay > py) != (by > py)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = ax + (py - ay) / (by - ay) * (bx - ax)
        odd[start : start + 500] = (spans & (px < crossing)).sum(axis=1) % 2 == 1
    return odd
