"""The path of a trajectory by station: finely, with speeds, prolonged beyond its end, and the times at which it is driven."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.dense import curve
from support.dense.recording import Columns, Floats

#: Distance of points, m.
STEP = 0.1


@dataclass(frozen=True)
class Path:
    """Arrays of one length by station s [m], which starts at 0 and increases. v: the speeds that the trajectory says; 0 beyond its end.

    end: the station of the last sample.
    """

    s: Floats
    x: Floats
    y: Floats
    heading: Floats
    kappa: Floats
    v: Floats
    end: float

    def at(self, name: str, s: float | Floats) -> Floats:
        """A column at stations, straight between points; v: its square is."""
        column = getattr(self, name)
        if name == "v":
            return np.asarray(np.sqrt(np.interp(s, self.s, np.square(column))))
        return np.asarray(np.interp(s, self.s, column))

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """The station of the point nearest to a place, and how far to the left of the path the place is, m."""
        ax, ay, bx, by = self.x[:-1], self.y[:-1], np.diff(self.x), np.diff(self.y)
        square = bx * bx + by * by
        share = np.clip(((x - ax) * bx + (y - ay) * by) / square, 0.0, 1.0)
        dx, dy = x - (ax + share * bx), y - (ay + share * by)
        k = int((dx * dx + dy * dy).argmin())
        side = bx[k] * dy[k] - by[k] * dx[k]
        return float(self.s[k] + share[k] * (self.s[k + 1] - self.s[k])), float(
            np.copysign(np.hypot(dx[k], dy[k]), side)
        )

    def times(self, begin: float) -> tuple[Floats, Floats]:
        """Stations from `begin` on where the trajectory drives, and when it is there; acceleration is constant from point to point."""
        inner = self.s[(self.s > begin) & (self.s <= self.end)]
        stations = np.concatenate([[begin], inner])
        v = self.at("v", stations)
        pace = (v[1:] + v[:-1]) / 2.0
        goes = np.logical_and.accumulate(pace > 1e-6)
        lasts = np.diff(stations)[goes] / pace[goes]
        return stations[: 1 + len(lasts)], np.concatenate([[0.0], np.cumsum(lasts)])

    def after(self, begin: float, seconds: float | Floats) -> Floats:
        """The station so long after `begin`; at the end, or where it stands, it stays."""
        stations, times = self.times(begin)
        return np.asarray(np.interp(seconds, times, stations))


def path(columns: Columns, beyond: float = 0.0) -> Path:
    """With so many metres beyond the last sample, where the path goes on with its last curvature."""
    points = curve.points_for(columns, STEP)
    parts = curve.pieces(columns, points)
    going = np.flatnonzero(curve.chords(columns) > curve.SAME)
    rows: list[Floats] = []
    station = 0.0
    for i in going:
        step = np.hypot(np.diff(parts.x[i]), np.diff(parts.y[i]))
        s = station + np.concatenate([[0.0], np.cumsum(step)])
        square = (
            np.square(columns["v"][i]) * (1.0 - parts.share) + np.square(columns["v"][i + 1]) * parts.share
        )
        heading = np.unwrap(parts.heading[i])
        rows.append(np.stack([s, parts.x[i], parts.y[i], heading, parts.kappa[i], np.sqrt(square)])[:, :-1])
        station = float(s[-1])
    last = [columns[name][-1] for name in ("x", "y", "heading", "kappa", "v")]
    rows.append(np.array([[station], *([value] for value in last)]))
    if beyond > 0.0:
        rows.append(_beyond(station, last[0], last[1], last[2], last[3], beyond))
    s, x, y, heading, kappa, v = np.concatenate(rows, axis=1)
    return Path(s, x, y, np.unwrap(heading), kappa, v, station)


def _beyond(station: float, x: float, y: float, heading: float, kappa: float, length: float) -> Floats:
    """Points of an arc from a pose on."""
    way = np.linspace(0.0, length, 1 + int(np.ceil(length / STEP)))[1:]
    turn = kappa * way
    # Chord of the arc: its length and direction.
    chord = way * np.sinc(turn / 2.0 / np.pi)
    east, north = x + chord * np.cos(heading + turn / 2.0), y + chord * np.sin(heading + turn / 2.0)
    return np.stack(
        [station + way, east, north, heading + turn, np.full_like(way, kappa), np.zeros_like(way)]
    )
