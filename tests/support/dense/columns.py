"""Whether the columns of a trajectory say the same thing, each from the others: positions, arc length, heading, curvature, speed, time.

Tolerances are those of TrajectorySupervisor (TU Munich), as specs/supervisor/trajectory.spec names them: 10 % of arc length, 0.5 rad, 0.05 1/m,
0.2 m/s^2; that of time is 5 % of a step and 5 ms.
"""

from __future__ import annotations

import numpy as np

from support.dense import curve
from support.dense.recording import Columns

#: Steps shorter than this say nothing, m.
SHORTEST = 0.01


def disagreements(columns: Columns) -> dict[str, bool]:
    """By column: whether it contradicts the others anywhere."""
    chord = curve.chords(columns)
    counts = chord >= SHORTEST
    s, v, a, t, psi, kappa = (columns[name] for name in ("s", "v", "a", "t", "heading", "kappa"))
    if not counts.any():
        return dict.fromkeys(("arc length", "heading", "curvature", "acceleration", "time"), False)
    part = curve.pieces(columns, 51)
    length = np.where(counts, part.lengths, 1.0)
    bearing = np.arctan2(np.diff(columns["y"]), np.diff(columns["x"]))
    turn = curve.turned(np.diff(psi)) / np.where(counts, chord, 1.0)
    needed = np.diff(np.square(v)) / (2.0 * np.where(counts, chord, 1.0))
    least, most = np.minimum(a[:-1], a[1:]), np.maximum(a[:-1], a[1:])
    # The first and the last step are left out: accelerations there are often continued from the side.
    inner = counts & (np.arange(len(chord)) > 0) & (np.arange(len(chord)) < len(chord) - 1)
    pace = (np.abs(v[:-1]) + np.abs(v[1:])) / 2.0
    lasts = chord / np.where(pace > 1e-9, pace, np.inf)
    return {
        "arc length": bool((counts & (np.abs(np.diff(s) - length) > 0.1 * length)).any()),
        "heading": bool((counts & (np.abs(curve.turned(bearing - psi[:-1])) > 0.5)).any()),
        "curvature": bool((counts & (np.abs(turn - (kappa[:-1] + kappa[1:]) / 2.0) > 0.05)).any()),
        "acceleration": bool((inner & ((needed < least - 0.2) | (needed > most + 0.2))).any()),
        "time": bool((counts & (np.abs(np.diff(t) - lasts) > 0.05 * lasts + 0.005)).any()),
    }
