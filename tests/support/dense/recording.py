"""Recordings of `shared/data/planner`, read from their JSON lines alone: nothing of the engine is asked.

The format is described in docs/scenarios.md ("The own format"); beside each recording lies what the planner itself said in each cycle.
"""

from __future__ import annotations

import gzip
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]

#: What the planner says of its own computer, and not of the plan.
SLOW = "One trajectory generation iteration took more than"
#: The recordings, and those in which the car is alone.
NAMES = ("berlin", "modena", "berlin_cars", "modena_cars")
ALONE = NAMES[:2]


@dataclass(frozen=True)
class Cycle:
    """One cycle: the car's pose and speed, the others, and the columns of both candidates, in SI."""

    index: int
    t: float
    ego: Mapping[str, float]
    objects: Sequence[Mapping[str, Any]]
    candidates: Mapping[str, Columns]
    action: str
    warning: str


@dataclass(frozen=True)
class Recording:
    """left, right: (n, 2), without the first point repeated."""

    name: str
    left: Floats
    right: Floats
    closed: bool
    cycles: tuple[Cycle, ...]


def read(folder: Path, name: str) -> Recording:
    """Raises AssertionError where the file is not what its header says."""
    with gzip.open(folder / f"{name}.tmrec.jsonl.gz", "rt", encoding="utf-8") as file:
        header, *lines = [json.loads(line) for line in file]
    said = [json.loads(line) for line in (folder / f"{name}.said.jsonl").read_text("utf-8").splitlines()]
    assert (header["format"], header["version"], header["name"]) == ("trackmarshal-recording", 1, name)
    assert [line["t"] for line in lines] == [line["t"] for line in said]
    track = header["track"]
    return Recording(
        name,
        np.array(track["left"], dtype=np.float64),
        np.array(track["right"], dtype=np.float64),
        bool(track["closed"]),
        tuple(_cycle(index, line, note) for index, (line, note) in enumerate(zip(lines, said, strict=True))),
    )


def _cycle(index: int, line: Mapping[str, Any], note: Mapping[str, str]) -> Cycle:
    candidates = {
        name: {field: np.array(values, dtype=np.float64) for field, values in columns.items()}
        for name, columns in line["candidates"].items()
    }
    assert set(candidates) == {"driving", "emergency"}
    return Cycle(
        index, line["t"], line["ego"], line["objects"], candidates, note["action"], warning(note["said"])
    )


def warning(said: str) -> str:
    """What the planner warns of, without its remarks on computing time; "" where it warns of nothing."""
    parts = [part.strip() for part in re.split(r"\s\|\s", said)]
    return " | ".join(part for part in parts if part and SLOW not in part)
