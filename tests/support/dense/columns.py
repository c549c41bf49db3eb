"""Whether the columns of a trajectory say the same thing, each from the others: positions, arc length, heading, curvature, speed, time.

Tolerances are those of TrajectorySupervisor (TU Munich), as specs/supervisor/trajectory.spec names them: 10 % of arc length, 0.05 1/m,
0.2 m/s^2; that of time is 5 % of a step and 5 ms, that of heading 0.1 rad in the middle of a step. Ranges are those of specs/supervisor/interface.spec.
"""

from __future__ import annotations

import numpy as np

from support.dense import curve
from support.dense.recording import Columns

#: Steps shorter than this say nothing, m.
SHORTEST = 0.01
RANGES = {"heading": (-1000.0, 1000.0), "kappa": (-1.0, 1.0), "v": (-10.0, 150.0), "a": (-100.0, 50.0)}


def disagreements(columns: Columns) -> dict[str, bool]:
    """By column: whether it contradicts the others anywhere."""
    chord = curve.chords(columns)
    counts = chord >= SHORTEST
    s, v, a, t, psi, kappa = (columns[name] for name in ("s", "v", "a", "t", "heading", "kappa"))
    way = np.where(counts, chord, 1.0)
    length = np.where(counts, curve.pieces(columns, 51).lengths, 1.0)
    bearing = np.arctan2(np.diff(columns["y"]), np.diff(columns["x"]))
    turn = curve.turned(np.diff(psi)) / way
    needed = np.diff(np.square(v)) / (2.0 * way)
    least, most = np.minimum(a[:-1], a[1:]), np.maximum(a[:-1], a[1:])
    # The first and the last step are left out: accelerations there are often continued from the side.
    inner = counts & (np.arange(len(chord)) > 0) & (np.arange(len(chord)) < len(chord) - 1)
    pace = (np.abs(v[:-1]) + np.abs(v[1:])) / 2.0
    # A crawl of less than 1 cm/s over a whole step is as good as standing: its time means nothing.
    drives = counts & (pace > 0.01)
    lasts = way / np.where(drives, pace, 1.0)
    disagree = {
        "arc length": counts & (np.abs(np.diff(s) - length) > 0.1 * length),
        "heading": counts
        & (np.abs(curve.turned(bearing - psi[:-1] - curve.turned(np.diff(psi)) / 2.0)) > 0.1),
        "curvature": counts & (np.abs(turn - (kappa[:-1] + kappa[1:]) / 2.0) > 0.05),
        "acceleration": inner & ((needed < least - 0.2) | (needed > most + 0.2)),
        "time": drives & (np.abs(np.diff(t) - lasts) > 0.05 * lasts + 0.005),
    }
    return {name: bool(where.any()) for name, where in disagree.items()}


def out_of_range(columns: Columns) -> bool:
    """Whether any value is outside what the contract declares, or time does not go on."""
    outside = any(
        bool(((columns[name] < low) | (columns[name] > high)).any()) for name, (low, high) in RANGES.items()
    )
    return outside or bool((np.diff(columns["t"]) <= 0.0).any())
