"""Made-up logs with a known motion, and mappings for them: what a reader of logs is held against."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MAP = """\
format: trackmarshal-log-map
version: 1
name: made_up
columns:
  t: {column: time, unit: s}
  x: {column: x, unit: m}
  y: {column: y, unit: m}
  heading: {column: heading, unit: rad, zero: +x, turns: left}
  v: {column: v, unit: m/s}
  yaw_rate: {column: yaw, unit: rad/s}
time: {rate: 10}
track:
  left: {path: left.csv, x: 1, y: 2}
  right: {path: right.csv, x: 1, y: 2}
vehicle: specs/vehicles/av21.spec
use: [specs/tracks/lvms.spec]
plan: {horizon: 2, step: 0.1}
emergency: {share: 0.9}
"""
HEAD = ("time", "x", "y", "heading", "v", "yaw")


def straight(seconds: float = 30.0, rate: float = 25.0) -> dict[str, Floats]:
    """Along +y: 5 s at rest, 1.5 m/s^2 up to 15 m/s, and on."""
    t = np.arange(round(seconds * rate)) / rate
    v = np.clip(1.5 * (t - 5.0), 0.0, 15.0)
    until = np.clip(t - 5.0, 0.0, 10.0)
    y = 0.75 * until**2 + 15.0 * np.clip(t - 15.0, 0.0, None)
    return {
        "time": t,
        "x": np.zeros_like(t),
        "y": y,
        "heading": np.full_like(t, np.pi / 2),
        "v": v,
        "yaw": np.zeros_like(t),
    }


def ring(
    seconds: float = 40.0, rate: float = 25.0, radius: float = 100.0, v: float = 15.0
) -> dict[str, Floats]:
    """Round a circle about the origin, counter-clockwise."""
    t = np.arange(round(seconds * rate)) / rate
    angle = v / radius * t
    heading = np.angle(np.exp(1j * (angle + np.pi / 2)))
    return {
        "time": t, "x": radius * np.cos(angle), "y": radius * np.sin(angle), "heading": heading, "v": np.full_like(t, v),
        "yaw": np.full_like(t, v / radius),
    }  # fmt: skip


def noisy(
    log: dict[str, Floats], seed: int, place: float, heading: float, speed: float, yaw: float
) -> dict[str, Floats]:
    """The log with white noise of these deviations on its columns."""
    draw = np.random.default_rng(seed)
    spread = {"x": place, "y": place, "heading": heading, "v": speed, "yaw": yaw}
    return {
        name: column + spread.get(name, 0.0) * draw.standard_normal(len(column))
        for name, column in log.items()
    }


def text(log: dict[str, Floats], head: tuple[str, ...] = HEAD, end: str = "\n", delimiter: str = ",") -> str:
    """As CSV."""
    rows = zip(*(column.tolist() for column in log.values()))
    return end.join([delimiter.join(head), *(delimiter.join(map(repr, row)) for row in rows), ""])


def write(folder: Path, log: dict[str, Floats], mapping: str = MAP) -> tuple[Path, Path]:
    """The log, its mapping and a wide straight or round road, in a folder; specs are the project's. Returns mapping and log."""
    root = Path(__file__).resolve().parents[2]
    if not (folder / "specs").exists():
        (folder / "specs").symlink_to(root / "specs")
    (folder / "log.csv").write_bytes(text(log).encode())
    (folder / "map.yaml").write_text(mapping, encoding="utf-8")
    (folder / "left.csv").write_text("-10,-50\n-10,400\n", encoding="utf-8")
    (folder / "right.csv").write_text("10,-50\n10,400\n", encoding="utf-8")
    return folder / "map.yaml", folder / "log.csv"
