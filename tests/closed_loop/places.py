"""Where things are: the repository, the shared data, the planner's environment, and what the loop keeps."""

from __future__ import annotations

from pathlib import Path

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
SHARED = REPOSITORY.parent / "shared"
PARAMS = SHARED / "data" / "planner" / "params"
#: The car that the planner plans for, as its data says it, and places of a track that are far away.
CAR_SPEC = SHARED / "data" / "planner" / "ltpl_car.spec"
TRACK_SPEC = SHARED / "data" / "planner" / "ltpl_track.spec"
RULES = REPOSITORY / "specs" / "supervisor"
#: Made by `make closed-loop`: the planner's environment, its lattices, results of single runs.
BUILD = REPOSITORY / "build" / "closed-loop"
PLANNER_PYTHON = BUILD / "venv" / "bin" / "python"
RUNS = BUILD / "runs"
#: Kept in the repository: all results, with the hashes of what they were made from.
RESULTS = HERE / "results.json"

TRACKS = ("modena", "berlin")


def race_line(track: str) -> Path:
    """The race line of a track."""
    return SHARED / "data" / "tracks" / f"ltpl_{track}.csv"


def graph(track: str) -> Path:
    """Where the planner keeps its lattice of a track."""
    return BUILD / f"{track}.pckl"
