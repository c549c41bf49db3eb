"""Archives of the ScenarioArchitect, made up: rows, texts and the ZIP around them."""

from __future__ import annotations

import io
import json
import math
import zipfile

HEADER = "time;x;y;heading;curv;vel;acc;ego_traj;ego_traj_em;object_array;safety_dyn;safety_stat"


def row(t: float = 0.0, **cells: str) -> str:
    """A cycle that drives along +x at 10 m/s (heading -pi/2 in the format's convention) and brakes to rest."""
    psi = -math.pi / 2.0
    driving = [[2.0 * i, 0.0, psi, 0.0, 10.0, 0.0] for i in range(4)]
    braking = [[2.0 * i, 0.0, psi, 0.0, v, 0.0] for i, v in enumerate((10.0, 5.0, 0.0, 0.0))]
    texts = {
        "time": str(t),
        "x": "0.0",
        "y": "0.0",
        "heading": str(psi),
        "curv": "0.0",
        "vel": "10.0",
        "acc": "0.5",
        "ego_traj": json.dumps(driving),
        "ego_traj_em": json.dumps(braking),
        "object_array": '[["veh_2", [30.0, 1.0, 0.0, 8.0, 4.7, 2.8]]]',
        "safety_dyn": "true",
        "safety_stat": "null",
    }
    return ";".join({**texts, **cells}.values())


def scn(*rows: str, header: str = HEADER, left: str = "[[0, 5], [50, 5]]") -> str:
    lines = [f"# bound_l:{left}", "# bound_r:[[0, -5], [50, -5]]", header, *(rows or (row(), row(0.1)))]
    return "\r\n".join(lines) + "\r\n"


def archive(text: str | bytes, name: str = "scene.scn", **others: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr(name, text)
        for suffix, content in others.items():
            packed.writestr(f"scene_{suffix}.csv", content)
    return stream.getvalue()
