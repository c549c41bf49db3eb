"""A log in SI and in this project's conventions, and whether it fits what its mapping says of it."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import digest
from trackmarshal.scenarios import content
from trackmarshal.scenarios.field import table
from trackmarshal.scenarios.field.mapping import Border, Column, Mapping, Named, unit_of

Floats = NDArray[np.float64]
#: What files begin with in which logs are kept too, and what they are.
_OTHERS = {
    b"PK\x03\x04": "an archive (zip, npz, xlsx)", b"SQLite format 3": "a database (SQLite, a bag of ROS 2)", b"#ROSBAG": "a bag of ROS 1",
    b"PAR1": "Parquet", b"ARROW1": "Arrow", b"\xff\xff\xff\xff": "Arrow", b"\x89HDF\r\n": "HDF5", b"\x93NUMPY": "an array of numpy",
    b"MATLAB 5.0": "a file of MATLAB", b"MDF  ": "MDF", b"ULog": "ULog", b"\x28\xb5\x2f\xfd": "what zstd packed",
    b"\xfd7zXZ": "what xz packed", b"BZh": "what bzip2 packed",
}  # fmt: skip
_OTHER_HELP = "export the log as CSV (gzip may pack it) or as MCAP with JSON"
#: Fewer rows are no log of a drive.
_FEWEST = 20
#: A gap in time that is longer than this, s, is a part of the log that is missing.
_LONGEST_GAP = 1.0
#: s: over this time a bend turns a heading by more than its noise does.
_BEND = 2.0
#: m/s: slower, a car's direction of travel is not seen in its positions.
MOVING = 2.0


@dataclass(frozen=True, slots=True)
class Log:
    """(n,) float64 in SI: time from the first row (which was at `origin`), place of the vehicle's middle, heading 0 along +x and
    counter-clockwise positive in (-pi, pi], speed, and yaw rate where there is one. `path` is where it lies, `sha256` what it holds, `left_out` what of
    its beginning is no row."""

    t: Floats
    x: Floats
    y: Floats
    heading: Floats
    v: Floats
    yaw_rate: Floats | None
    origin: float
    path: str
    sha256: str
    left_out: str = ""


def find(mapping: Mapping, named: Named) -> Path:
    """Where a file of the mapping lies: beside it, or where its path leads from there."""
    return Path(os.path.normpath(mapping.folder / named.path))


def read(mapping: Mapping, path: Path, shown: str | None = None) -> Log:
    """Read a log (CSV, also packed, or MCAP) by its mapping. Raises D12x, D142 and D170 to D176 with the line."""
    shown = shown or str(path)
    raw = checked(path, shown, mapping.log, mapping)
    data = content.gunzip(raw, shown) if raw.startswith(b"\x1f\x8b") else raw
    from trackmarshal.scenarios.field import mcap_log

    left_out = ""
    if data.startswith(mcap_log.MAGIC):
        columns, lines, left_out = mcap_log.read(data, shown, mapping.columns, mapping.hold)
    elif data.startswith(tuple(_OTHERS)):
        kind = next(kind for begin, kind in _OTHERS.items() if data.startswith(begin))
        raise TrackmarshalError(
            "D174",
            f"{kind} is neither delimited text nor MCAP",
            file=shown,
            help=_OTHER_HELP,
        )
    else:
        columns, lines = table.read(data, shown, mapping.columns, mapping.delimiter)
    si = {name: _si(values, mapping.columns[name]) for name, values in columns.items()}
    _in_order(si["t"], lines, shown)
    origin = float(si["t"][0])
    heading = mapping.heading_sign * si["heading"] + mapping.heading_zero * np.pi / 2
    heading = np.angle(np.exp(1j * heading))
    rate = mapping.heading_sign * si["yaw_rate"] if "yaw_rate" in si else None
    x, y = si["x"] + mapping.forward * np.cos(heading), si["y"] + mapping.forward * np.sin(heading)
    log = Log(
        si["t"] - origin,
        x,
        y,
        heading,
        si["v"],
        rate,
        origin,
        str(path),
        digest(raw),
        left_out,
    )
    _fits(log, shown)
    return log


def checked(path: Path, shown: str, named: Named | None, mapping: Mapping) -> bytes:
    """The bytes of a file, which holds what the mapping's hash is of; raises D120, D124, D175 and D178."""
    if named is not None and not path.exists() and path == find(mapping, named):
        message = "this file of the mapping is not here: nothing is said about it"
        raise TrackmarshalError(
            "D178",
            message,
            file=shown,
            help=f"{mapping.source}:{named.line} names it; it need not be part of the project",
        )
    raw = content.read(path, shown)
    # A text that a checkout gave other ends of lines is the file that is named.
    if named is not None and named.sha256 not in ("", hashlib.sha256(raw).hexdigest(), digest(raw)):
        message = "this is not the file that the mapping names: its hash is another"
        help_ = f"{mapping.source}:{named.line} has {named.sha256[:12]}..., the file {hashlib.sha256(raw).hexdigest()}"
        raise TrackmarshalError("D175", message, file=shown, help=help_)
    return raw


def border(mapping: Mapping, named: Border) -> list[list[float]]:
    """The points of a border, m. Raises as `read` does."""
    path = find(mapping, named.file)
    raw = checked(path, str(path), named.file, mapping)
    data = content.gunzip(raw, str(path)) if raw.startswith(b"\x1f\x8b") else raw
    columns, _ = table.read(data, str(path), {"x": named.x, "y": named.y}, named.delimiter)
    x, y = _si(columns["x"], named.x), _si(columns["y"], named.y)
    if len(x) < 2:
        raise TrackmarshalError(
            "D176", "a border of one point", file=str(path), help="two or more are needed"
        )
    return [[float(a), float(b)] for a, b in zip(x, y)]


def _si(values: Floats, column: Column) -> Floats:
    multiplier, divisor, _ = unit_of(column.unit)
    return values * multiplier / divisor


def _in_order(t: Floats, lines: NDArray[np.int64], shown: str) -> None:
    if len(t) < _FEWEST:
        raise TrackmarshalError(
            "D176", f"{len(t)} rows are no log", file=shown, help=f"at least {_FEWEST} are needed"
        )
    steps = np.diff(t)
    bad = np.flatnonzero(steps <= 0.0)
    if len(bad):
        place = int(bad[0]) + 1
        message = f"time {t[place]:.6f} s does not come after {t[place - 1]:.6f} s"
        help_ = "sort the rows, and keep one of each time"
        if steps[place - 1] == 0.0 and not np.any(t % 1.0):
            # of two rows, none is one too many: the column is `sec` of a stamp, or was written with too few digits
            help_ = "all times are whole seconds: take a column that has their fractions, too"
        raise TrackmarshalError("D172", message, file=shown, line=int(lines[place]), help=help_)
    gaps = np.flatnonzero(steps > _LONGEST_GAP)
    if len(gaps):
        place = int(gaps[0]) + 1
        message = f"{steps[place - 1]:g} s without a row"
        help_ = "is the unit of time right? Else make a recording of each part"
        raise TrackmarshalError("D172", message, file=shown, line=int(lines[place]), help=help_)


def _fits(log: Log, shown: str) -> None:
    """Raise D173 where speed and heading contradict the positions by so much that unit or convention must be wrong.

    Compared are medians over the moving part of the log, which noise and jumps don't shift.
    """
    lag = max(1, round(0.5 / float(np.median(np.diff(log.t)))))
    if len(log.t) <= 2 * lag:
        return
    dx, dy = log.x[lag:] - log.x[:-lag], log.y[lag:] - log.y[:-lag]
    dt = log.t[lag:] - log.t[:-lag]
    seen = np.hypot(dx, dy) / dt
    said = 0.5 * (log.v[lag:] + log.v[:-lag])
    moving = seen > MOVING
    if np.count_nonzero(moving) < _FEWEST:
        # A log that is too short to compare shows neither.
        if np.median(np.abs(said)) > MOVING >= np.median(seen):
            raise _contradicts(
                "the speed column says that it drives, the positions do not move",
                shown,
                "is it the right column?",
            )
        return
    ratio = float(np.median(np.abs(said[moving]) / seen[moving]))
    if not 0.8 <= ratio <= 1.25:
        close = [
            (abs(np.log(ratio / f)) if ratio > 0.0 else np.inf, text)
            for f, text in (
                (3.6, "km/h"),
                (1 / 3.6, "m/s"),
                (2.2369, "mph"),
                (1000.0, "mm/s"),
            )
        ]
        best = min(close)
        help_ = (
            f"is its unit {best[1]}?" if best[0] < 0.2 else "are the units of time, place and speed right?"
        )
        raise _contradicts(f"the speed column is {ratio:.3g} times the speed of the positions", shown, help_)
    travel = np.arctan2(dy, dx) + np.pi * (said < 0.0)  # backwards, it goes where its tail points
    middle = log.heading[lag // 2 : len(travel) + lag // 2]
    off = np.angle(np.exp(1j * (travel - middle)))[moving]
    centre = float(np.angle(np.mean(np.exp(1j * off))))
    spread = float(np.median(np.abs(np.angle(np.exp(1j * (off - centre))))))
    if abs(centre) > 0.35 or spread > 0.35:
        quarter = round(centre / (np.pi / 2)) % 4
        steady = spread <= 0.35 and abs(centre - np.angle(np.exp(1j * quarter * np.pi / 2))) < 0.2
        help_ = (
            f"is it counted from another axis? Turned by {quarter * 90} deg it would fit" + (", and so would a speed of the other sign" if quarter == 2 else "") if steady
            else "is its unit deg or rad, and does it turn left or right?"
        )  # fmt: skip
        raise _contradicts(
            f"the heading is {np.degrees(centre):.0f} deg (spread {np.degrees(spread):.0f}) off the direction of travel",
            shown,
            help_,
        )
    if log.yaw_rate is not None:
        fit = _turns(log, log.yaw_rate)
        if not 0.5 <= fit <= 2.0:
            raise _contradicts(
                f"the yaw rate is {fit:.3g} times the change of the heading",
                shown,
                "are its unit and its sign right?",
            )


def _turns(log: Log, rate: Floats) -> float:
    """How many times the change of the heading the yaw rate adds up to, by the median over the bends; 1 for a log without any.

    A bend is what the noise of the heading does not turn by: on a straight, that would be all that there is, and no yaw rate goes with it.
    """
    lag = max(1, round(_BEND / float(np.median(np.diff(log.t)))))
    heading = np.unwrap(log.heading)
    noise = float(np.median(np.abs(np.diff(heading, 2)))) / (0.6745 * np.sqrt(6.0))
    added = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(log.t))])
    turned, said = heading[lag:] - heading[:-lag], added[lag:] - added[:-lag]
    way = np.hypot(log.x[lag:] - log.x[:-lag], log.y[lag:] - log.y[:-lag])
    bends = (way > MOVING * (log.t[lag:] - log.t[:-lag])) & (
        np.abs(turned) > max(0.03 * _BEND, 6.0 * np.sqrt(2.0) * noise)
    )
    return float(np.median(said[bends] / turned[bends])) if np.count_nonzero(bends) >= _FEWEST else 1.0


def _contradicts(message: str, shown: str, help: str) -> TrackmarshalError:
    return TrackmarshalError("D173", message, file=shown, help=help)
