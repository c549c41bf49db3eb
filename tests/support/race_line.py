"""Race lines (TU Munich's CSV files) as closed sequences of samples, and trajectories cut from them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

Columns = dict[str, list[float]]


def read(path: Path) -> Columns:
    """The samples of one lap: x, y, heading, kappa, v, a. The file's last line repeats its first one and is left out.

    The file's heading is 0 along +y; the line lies `alpha` m from the reference line along its normal vector.
    """
    lines = path.read_text(encoding="utf-8").splitlines()
    names = [name.strip() for name in lines[2].lstrip("# ").split(";")]
    rows = [dict(zip(names, map(float, line.split(";")), strict=True)) for line in lines[3:]]
    same = ("x_ref_m", "y_ref_m", "vx_racetraj_mps", "ax_racetraj_mps2", "kappa_racetraj_radpm")
    assert all(rows[0][name] == rows[-1][name] for name in same), "the line is not closed"
    lap = rows[:-1]
    return {
        "x": [row["x_ref_m"] + row["alpha_m"] * row["x_normvec_m"] for row in lap],
        "y": [row["y_ref_m"] + row["alpha_m"] * row["y_normvec_m"] for row in lap],
        "heading": [row["psi_racetraj_rad"] + math.pi / 2.0 for row in lap],
        "kappa": [row["kappa_racetraj_radpm"] for row in lap],
        "v": [row["vx_racetraj_mps"] for row in lap],
        "a": [row["ax_racetraj_mps2"] for row in lap],
    }


def cut(lap: Columns, points: int) -> Iterator[tuple[list[int], Columns]]:
    """Trajectories of so many samples, with each sample's place in the lap; the last one goes on into the next lap."""
    count = len(lap["v"])
    for start in range(0, count, points):
        places = [index % count for index in range(start, start + points)]
        yield places, {name: [column[place] for place in places] for name, column in lap.items()}
