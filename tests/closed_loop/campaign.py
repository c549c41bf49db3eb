"""Runs the campaign, or a part of it: `python -m closed_loop.campaign`. What has been run from the same origins is not run again.

--only P-01.modena.alone.fast ...   these runs (or prefixes of their names)
--declared                          the 24 runs of `make acceptance`
--jobs N                            so many at once (each has its planner)
--keep                              write results.json: needs all runs
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from closed_loop import places
from closed_loop.condition import FAULTS, Condition, declared, every
from closed_loop.link import PlannerProcess
from closed_loop.loop import Run
from closed_loop.origin import key, origins
from closed_loop.result import result
from closed_loop.road import Road
from closed_loop.supervising import AsProcess, Supervising


def run_all(conditions: Sequence[Condition], folder: Path, jobs: int = 1) -> None:
    """Runs what has no result in the folder yet, and writes one file a run."""
    folder.mkdir(parents=True, exist_ok=True)
    open_ = [condition for condition in conditions if not (folder / f"{condition.name}.json").exists()]
    shares = [
        ([c for c in open_ if c.track == track][i::jobs], folder)
        for track in places.TRACKS
        for i in range(jobs)
    ]
    shares = [share for share in shares if share[0]]
    if jobs == 1:
        for share in shares:
            _share(*share)
        return
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        pool.starmap(_share, shares, chunksize=1)


def _share(conditions: Sequence[Condition], folder: Path) -> None:
    """Runs on one track, with one planner."""
    road = Road.of(conditions[0].track)
    with PlannerProcess(road.name) as planner:
        for condition in conditions:
            begin = time.monotonic()
            found = result(condition, Run(condition, road, planner, supervise).go(), road)
            kept = folder / f"{condition.name}.json"
            kept.with_suffix(".part").write_text(json.dumps(found, indent=1), encoding="utf-8")
            kept.with_suffix(".part").rename(kept)
            reaction = found["reaction"]
            said = f"{reaction['found']} after {reaction['after']} s" if reaction else "no reaction"
            print(
                f"{condition.name:34} {found['outcome']:13} {said} ({time.monotonic() - begin:.0f} s)",
                flush=True,
            )


def supervise(road: Road) -> Supervising:
    """The Supervisor of a run, as a process. The seam: another one that steps, is told of silence, and closes goes here."""
    return AsProcess(road.signal)


def collect(conditions: Sequence[Condition], folder: Path) -> list[dict[str, Any]]:
    """The results of runs; raises FileNotFoundError where one is missing."""
    return [
        json.loads((folder / f"{condition.name}.json").read_text(encoding="utf-8"))
        for condition in sorted(conditions)
    ]


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="closed_loop.campaign", description="Faults in the closed loop.")
    parser.add_argument("--only", nargs="+", default=[""])
    parser.add_argument("--declared", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", action="store_true")
    args = parser.parse_args(argv)
    wanted = declared() if args.declared else list(every())
    chosen = [condition for condition in wanted if condition.name.startswith(tuple(args.only))]
    origin = origins()
    folder = places.RUNS / key(origin)  # of this very Supervisor: what is kept names its source
    run_all(chosen, folder, args.jobs)
    results = collect(chosen, folder)
    counts: dict[str, int] = {}
    for each in results:
        counts[each["outcome"]] = counts.get(each["outcome"], 0) + 1
    print(f"{len(results)} runs:", ", ".join(f"{count} {word}" for word, count in sorted(counts.items())))
    if args.keep:
        if len(results) != len(list(every())):
            print("results are kept whole or not at all", file=sys.stderr)
            return 2
        titles = {kind.id: kind.title for kind in FAULTS.values()}
        content = {
            "format": "trackmarshal-closed-loop",
            "version": 1,
            "origin": origin,
            "faults": titles,
            "runs": results,
        }
        places.RESULTS.write_text(
            json.dumps(content, indent=None, separators=(",", ":")).replace('{"name"', '\n{"name"') + "\n",
            encoding="utf-8",
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
