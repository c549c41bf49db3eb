"""Race lines (TU Munich's CSV files) as closed sequences of samples, and trajectories cut from them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

Columns = dict[str, list[float]]
Points = list[tuple[float, float]]


def rows_of(path: Path) -> list[dict[str, float]]:
    """The lines of one lap by the file's names. Its last line repeats its first one and is left out."""
    lines = path.read_text(encoding="utf-8").splitlines()
    names = [name.strip() for name in lines[2].lstrip("# ").split(";")]
    rows = [dict(zip(names, map(float, line.split(";")), strict=True)) for line in lines[3:]]
    same = ("x_ref_m", "y_ref_m", "vx_racetraj_mps", "ax_racetraj_mps2", "kappa_racetraj_radpm")
    assert all(rows[0][name] == rows[-1][name] for name in same), "the line is not closed"
    return rows[:-1]


def borders(path: Path) -> tuple[Points, Points]:
    """Left and right: from the reference line, by the widths and against and along the normal vector, which points to the right."""
    lap = rows_of(path)
    return tuple(  # type: ignore[return-value]
        [
            (row["x_ref_m"] + side * row[width] * row["x_normvec_m"], row["y_ref_m"] + side * row[width] * row["y_normvec_m"])
            for row in lap
        ]
        for side, width in ((-1.0, "width_left_m"), (1.0, "width_right_m"))
    )  # fmt: skip


def read(path: Path) -> Columns:
    """The samples of one lap: x, y, heading, kappa, v, a.

    The file's heading is 0 along +y; the line lies `alpha` m from the reference line along its normal vector.
    """
    lap = rows_of(path)
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
