"""What the planner says, as the candidates of a cycle: conventions, columns, times, and where a trajectory begins and ends.

The planner counts headings from +y; its trajectories begin at the lattice's sample behind the car, have no times, and go on standing
where they end at rest. Candidates begin where the car is and end with the first sample at rest.
"""

from __future__ import annotations

import math

Columns = dict[str, list[float]]

#: Below this the planner means standing, m/s.
REST = 1e-9


def candidate(raw: Columns, x: float, y: float) -> Columns:
    """Columns t, s, x, y, heading, kappa, v, a of a trajectory of the planner's, from the place nearest to x, y on. t[0] is 0 s."""
    columns = {name: list(raw[name]) for name in ("s", "x", "y", "kappa", "v", "a")}
    columns["heading"] = [math.remainder(psi + math.pi / 2.0, math.tau) for psi in raw["psi"]]
    cut_at_rest(columns)
    cut_at(columns, x, y)
    columns["t"] = times(columns["s"], columns["v"])
    return columns


def cut_at_rest(columns: Columns) -> None:
    """Takes away what lies behind the first sample at rest; a car that stands keeps two samples in one place."""
    end = next((i for i, v in enumerate(columns["v"]) if v <= REST), None)
    if end is None:
        return
    if end == 0:
        moves = len(columns["v"]) > 1 and columns["v"][1] > REST
        if moves:  # it stands, and is to drive off
            later = next((i for i, v in enumerate(columns["v"]) if i and v <= REST), len(columns["v"]) - 1)
            for column in columns.values():
                del column[later + 1 :]
            return
        for name, column in columns.items():
            column[:] = [0.0, 0.0] if name in ("v", "a") else [column[0]] * 2
        return
    for column in columns.values():
        del column[end + 1 :]
    columns["v"][-1] = 0.0


def cut_at(columns: Columns, x: float, y: float) -> None:
    """Lets a trajectory begin at the place on it nearest to x, y, between its first samples; s counts on from 0 there."""
    i, share = _nearest(columns["x"], columns["y"], x, y)
    if share > 0.0:
        first = {name: _between(columns, name, i, share) for name in columns}
        first["a"] = columns["a"][i]
        first["x"], first["y"] = _on_curve(columns, i, share)
        for name, column in columns.items():
            column[:] = [first[name], *column[i + 1 :]]
    elif i:
        for column in columns.values():
            del column[:i]
    begin = columns["s"][0]
    columns["s"] = [s - begin for s in columns["s"]]


def times(s: list[float], v: list[float]) -> list[float]:
    """When each sample is reached from the first one on, at constant acceleration in between, s; a car that stands takes 0.1 s a sample."""
    t = [0.0]
    for i in range(1, len(s)):
        way, fast = s[i] - s[i - 1], v[i] + v[i - 1]
        t.append(t[-1] + (2.0 * way / fast if way > 0.0 and fast > 0.0 else 0.1))
    return t


def _nearest(xs: list[float], ys: list[float], x: float, y: float) -> tuple[int, float]:
    """Segment and share of the place nearest to a point; the last sample is never where a trajectory begins."""
    best, found = math.inf, (0, 0.0)
    for i in range(min(len(xs) - 1, 12)):  # the planner cuts at the sample behind the car
        dx, dy = xs[i + 1] - xs[i], ys[i + 1] - ys[i]
        square = dx * dx + dy * dy
        if square == 0.0:
            continue
        share = min(max(((x - xs[i]) * dx + (y - ys[i]) * dy) / square, 0.0), 1.0)
        apart = math.hypot(xs[i] + share * dx - x, ys[i] + share * dy - y)
        if apart < best:
            best, found = apart, (i, share)
    i, share = found
    if share > 0.999 and i + 2 < len(xs):  # no sliver of a segment
        return i + 1, 0.0
    return i, (share if 0.001 < share <= 0.999 else 0.0)


def _between(columns: Columns, name: str, i: int, share: float) -> float:
    p, q = columns[name][i], columns[name][i + 1]
    if name == "heading":
        return math.remainder(p + share * math.remainder(q - p, math.tau), math.tau)
    if name == "v":  # constant acceleration: the square is straight along the way
        return math.sqrt(max(p * p + share * (q * q - p * p), 0.0))
    return p + share * (q - p)


def _on_curve(columns: Columns, i: int, share: float) -> tuple[float, float]:
    """A place between two samples on the cubic that has their places and headings (Hermite)."""
    way = columns["s"][i + 1] - columns["s"][i]
    u = share
    h00, h10, h01, h11 = 2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, -2 * u**3 + 3 * u**2, u**3 - u**2
    found = []
    for name, part in (("x", math.cos), ("y", math.sin)):
        p, q = columns[name][i], columns[name][i + 1]
        found.append(
            h00 * p
            + h10 * way * part(columns["heading"][i])
            + h01 * q
            + h11 * way * part(columns["heading"][i + 1])
        )
    return found[0], found[1]
