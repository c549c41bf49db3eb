"""A log and its mapping to a recording, with everything that the evidence has to name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path, PurePath

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import digest
from trackmarshal.library import of_its_name, shipped_values
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.scenarios import content
from trackmarshal.scenarios.field import candidates, smoother
from trackmarshal.scenarios.field import log as logs
from trackmarshal.scenarios.field.candidates import Braking
from trackmarshal.scenarios.field.header import given
from trackmarshal.scenarios.field.log import MOVING, Log
from trackmarshal.scenarios.field.mapping import BRAKING, Mapping
from trackmarshal.scenarios.field.noise import MOVING as MEASURED
from trackmarshal.scenarios.field.noise import Noise, estimate
from trackmarshal.scenarios.field.sides import are_exchanged, exchanged
from trackmarshal.scenarios.field.smoother import Motion
from trackmarshal.scenarios.inputs import filled
from trackmarshal.scenarios.recording import Cycle, Recording

Floats = NDArray[np.float64]
#: Poses that are held against the borders.
_LOOKED_AT = 200
#: m/s: a logged speed backwards that is slower may be noise of a car that stands.
_ROLLING = 0.5
#: Mean squared innovations of a filter beyond which its motion is not that of the log: it is off by ten standard deviations in all samples.
_UNEXPLAINED = 100.0


@dataclass(frozen=True, slots=True)
class Drive:
    """A log as it was read, its noise, the motion that the trajectories are cut out of, and the recording.

    smoother: its name; empty where the log stands as it is. sources: sha256 by path of all that the recording was made from.
    """

    mapping: Mapping
    log: Log
    noise: Noise
    motion: Motion
    recording: Recording
    smoother: str
    sources: dict[str, str]


def build(mapping: Mapping, path: Path | None = None, raw: bool = False) -> Drive:
    """The recording of a log; `path` in place of the one that the mapping names. `raw`: without smoother, whatever is declared.

    Raises D12x, D142, D151, D170 to D178; diagnostics of the vehicle's spec.
    """
    if path is None and mapping.log is None:
        message = "the mapping names no log"
        raise TrackmarshalError(
            "D178", message, file=mapping.source, help="give the file, or name it under `log`"
        )
    where = path if path is not None or mapping.log is None else logs.find(mapping, mapping.log)
    assert where is not None
    log = logs.read(mapping, where)
    noise = _noise(mapping, log)
    smooth = mapping.smoother and not raw
    motion = smoother.smooth(log, noise) if smooth else as_logged(log)
    _explained(mapping, motion)
    borders = [logs.border(mapping, border) for border in mapping.track]
    if borders[0] == borders[1]:  # of which none is on the wrong side
        raise TrackmarshalError(
            "D151", "track.right: this is the left border", file=mapping.source, line=mapping.track[1].file.line, help="name the file of the right one"
        )  # fmt: skip
    rows = _cycles(mapping, log)
    _on_their_sides(log, rows, borders)
    times = log.t[rows]
    driven = candidates.driving(motion, times, mapping.horizon, mapping.step)
    braking = _braking(mapping)
    try:
        braked = candidates.emergency(motion, times, mapping.step, braking)
    except candidates.NoRest as error:
        raise TrackmarshalError(
            "D151",
            f"with {100 * mapping.share:g} % of the friction limit, a car that brakes at {error.t:g} s still moves {candidates.LONGEST:g} s later",
            file=mapping.source,
            help="give it a larger `share` under `emergency`: where a bend takes all of it, only drag slows the car down",
        ) from None
    cycles = []
    for row, driving, emergency in zip(rows, driven, braked):
        if emergency is None:
            break  # nothing after this one stands in time either: the log ends
        ego = {
            "x": float(log.x[row]),
            "y": float(log.y[row]),
            "heading": float(log.heading[row]),
            "v": float(log.v[row]),
        }
        ego = {name: round(value, 6) for name, value in ego.items()}
        cycles.append(Cycle(round(float(log.t[row]), 6), ego, [], {DRIVING: driving, EMERGENCY: emergency}))
    if not cycles:
        message = (
            f"no cycle between {mapping.begin:g} s and the end has {mapping.horizon:g} s of driving after it"
        )
        raise TrackmarshalError(
            "D176", message, file=str(where), help="`time` says from when to when; `plan` how far ahead"
        )
    name = smoother.NAME if smooth else ""
    recording = Recording(
        mapping.name, mapping.source, tuple(cycles), {"left": borders[0], "right": borders[1], "closed": mapping.closed},
        use=(mapping.vehicle, *mapping.use), notes=tuple(_notes(mapping, log, noise, motion, name, len(cycles))),
        of_specs=repr(braking), **given(mapping),
    )  # fmt: skip
    return Drive(mapping, log, noise, motion, filled(recording), name, _sources(mapping, log))


def as_it_is(drive: Drive) -> Drive:
    """The same log without its smoother, in the same cycles: with its noise, a braking before its end may come to rest a cycle sooner or later."""
    raw = build(drive.mapping, Path(drive.log.path), raw=True)
    cycles = raw.recording.cycles[: len(drive.recording.cycles)]
    return replace(raw, recording=replace(raw.recording, cycles=cycles))


def _on_their_sides(log: Log, rows: NDArray[np.int64], borders: list[list[list[float]]]) -> None:
    """Raise D173 where the left border is right of the car that drives along it: in a frame that is mirrored, zones are elsewhere."""
    moving = rows[log.v[rows] > MOVING]
    some = moving[:: max(1, len(moving) // _LOOKED_AT)]
    left, right = (np.array(border) for border in borders)
    if are_exchanged(*exchanged(log.x[some], log.y[some], log.heading[some], left, right)):
        raise TrackmarshalError(
            "D173",
            "the left border is on the right of the car, and the right one on its left",
            file=log.path,
            help="exchange them in the mapping; or is y to the right of x, as in NED? Then x is north, and y is east",
        )


def as_logged(log: Log) -> Motion:
    """The log itself as a motion, with all its noise: acceleration and curvature are what its columns change by."""
    heading = np.unwrap(log.heading)
    back = np.maximum(log.v[1:], log.v[:-1]) < -_ROLLING
    steps = np.where(back, -1.0, 1.0) * np.hypot(np.diff(log.x), np.diff(log.y))
    s = np.concatenate([[0.0], np.cumsum(steps)])
    a = np.gradient(log.v, log.t)
    rate = log.yaw_rate if log.yaw_rate is not None else np.gradient(heading, log.t)
    slow = np.abs(log.v) < 0.1
    kappa = np.where(slow, 0.0, rate / np.where(slow, 1.0, log.v))
    return Motion(log.t, s, log.x, log.y, heading, log.v, a, kappa, np.zeros(len(s), np.bool_), {})


def _cycles(mapping: Mapping, log: Log) -> NDArray[np.int64]:
    """Rows of the log at the declared rate, each the first at or after its time, as far as the horizon lies in the log."""
    end = log.t[-1] - mapping.horizon
    if mapping.end is not None:
        end = min(end, mapping.end)
    wanted = np.arange(max(mapping.begin, log.t[0]), end, 1.0 / mapping.rate)
    rows = np.unique(np.searchsorted(log.t, wanted - 1e-6))
    found: NDArray[np.int64] = rows[log.t[rows] <= end]
    return found


def _noise(mapping: Mapping, log: Log) -> Noise:
    """What is declared, and for what is not, what the log's statistics say; raises D177."""
    found = estimate(log)
    if found is not None:
        return replace(found, **mapping.noise)
    try:
        return Noise(**mapping.noise)
    except TypeError:
        message = f"the car is faster than {MEASURED:g} m/s for less than ten seconds, or not for seconds on end: that tells nothing of its noise"
        help_ = "is the unit of time right, and that of the speed? Else declare all of `noise`: along, across, heading, speed, yaw_rate, jerk, lateral_jerk"
        raise TrackmarshalError("D177", message, file=mapping.source, help=help_) from None


def _explained(mapping: Mapping, motion: Motion) -> None:
    """Raise D177 where the log is so far beside its motion that the noise is none of it: trajectories would be of another drive."""
    fits = {name: value for name, value in motion.innovations.items() if not value <= _UNEXPLAINED}
    if not fits:
        return
    name, value = next(iter(fits.items()))
    deviations = {
        "along": "`jerk`, `speed` and `along`",
        "turning": "`lateral_jerk`, `heading` and `yaw_rate`",
        "place": "`heading`, `speed`, `along` and `across`",
    }
    raise TrackmarshalError(
        "D177",
        f"the noise does not explain the log: mean squared innovations of {name} are {value:.3g}, and about 1 where it does",
        file=mapping.source,
        help=f"are units and signs of its columns right? Noise is taken from where the car is faster than {MEASURED:g} m/s: "
        f"where that is not like the rest, declare {deviations[name]} under `noise`",
    )


def _braking(mapping: Mapping) -> Braking:
    """The declared share of what the vehicle's spec says of tyres and brakes; raises D151 where it lacks something."""
    from trackmarshal.semantics.compile import compile_paths

    path = spec_of(mapping, mapping.vehicle)
    compiled = compile_paths([path])
    compiled.raise_errors()
    values = {info.short: info.value for info in compiled.spec.params.values()}
    missing = [name for name in BRAKING if name not in values]
    if missing:
        message = f"the vehicle `{mapping.vehicle}` has no parameter `{missing[0]}`"
        raise TrackmarshalError(
            "D151", message, file=mapping.source, help="mu, g, mass, drag and b_max say how it brakes"
        )
    share = mapping.share
    return Braking(
        share * values["mu"] * values["g"], share * values["b_max"], values["drag"] / values["mass"]
    )


def spec_of(mapping: Mapping, name: str) -> Path:
    """A spec that the mapping names, from its folder or one above it, as the project's, or a shipped one by its module; raises D178."""
    shipped = shipped_values(name)
    folder = mapping.folder.absolute()
    if shipped is not None and shipped.is_file():
        own = of_its_name(shipped, (folder, *folder.parents))
        if own is None:
            return shipped
        raise TrackmarshalError(
            "D178",
            f"`{name}` is shipped, and another module of the project: {own}",
            file=mapping.source,
            help="name the project's own one by its path, from the mapping's folder or one above it",
        )
    for place in (folder, *folder.parents):
        if (place / name).is_file():
            return place / name
    message = f"the spec `{name}` is not there"
    raise TrackmarshalError(
        "D178",
        message,
        file=mapping.source,
        help="its path is from the mapping's folder, or from one above it; a shipped one has its module, `vehicles.devbot`",
    )


def _notes(mapping: Mapping, log: Log, noise: Noise, motion: Motion, name: str, count: int) -> list[str]:
    """What was done to the log, for whoever reads the recording."""
    noisy = ", ".join(f"{key} {value:.3g}" for key, value in noise.named().items())
    fits = ", ".join(f"{key} {value:.3g}" for key, value in motion.innovations.items())
    has = 1.0 / float(np.median(np.diff(log.t)))
    rate = (
        f"{mapping.rate:g} Hz" if has > 0.9 * mapping.rate else f"{has:.3g} Hz, which is all that the log has"
    )
    return [
        f"log {Path(log.path).name}, sha256 {log.sha256}, its time 0 at {log.origin:.6f} s",
        *([f"of the log, {log.left_out}"] if log.left_out else []),
        f"{count} cycles at {rate}; the driving trajectory is what was driven in the next {mapping.horizon:g} s, "
        f"a sample every {mapping.step:g} s",
        f"the emergency trajectory brakes to rest on the same path with {100 * mapping.share:g} % of the friction limit of {PurePath(mapping.vehicle).name.removesuffix('.spec')}",
        f"smoother: {name or 'none'}" + (f"; noise: {noisy}; mean squared innovations: {fits}" if name else ""),
        f"the car is where the log says, noise and all; it is taken to stand for {standing_time(motion):.1f} s",
    ]  # fmt: skip


def standing_time(motion: Motion) -> float:
    """s."""
    return float(np.diff(motion.t)[motion.standing[1:]].sum())


def _sources(mapping: Mapping, log: Log) -> dict[str, str]:
    files = [mapping.path, *(logs.find(mapping, border.file) for border in mapping.track)]
    # What is shipped comes with the engine, and lies elsewhere on each machine.
    files += [
        spec_of(mapping, name) for name in (mapping.vehicle, *mapping.use) if shipped_values(name) is None
    ]
    found = {log.path: log.sha256}
    return found | {str(path): digest(content.read(path, str(path))) for path in files}
