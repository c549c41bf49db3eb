"""Recorded runs that are killed: python killed_runs.py FOLDER COUNT SEED.

Each run is a child of this process (a fork, so that nothing is loaded twice): it steps a Supervisor through the shipped scenario in real time
order and reports every completed step by one byte through a pipe. After a random time it gets SIGKILL. For each, a line: file, bytes reported.
"""

from __future__ import annotations

import json
import math
import os
import random
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path

from trackmarshal.evaluation import Evaluator, load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.scenarios import load as load_recording
from trackmarshal.scenarios.supervised import cycles
from trackmarshal.supervision import rulebox

ROOT = Path(__file__).resolve().parents[2]


def spec() -> Spec:
    return load([ROOT / "specs" / "supervisor"], [ROOT / "specs" / "tracks" / "northfield.spec"])


def run(supervisor: Supervisor, given: list[Cycle], pipe: int) -> None:
    """Steps, stamped with the clock as it is, until the end or the kill."""
    for cycle in given:
        supervisor.step(replace(cycle, t=time.monotonic()))
        os.write(pipe, b".")


def main(folder: Path, count: int, seed: int) -> None:
    rng = random.Random(seed)
    recording = load_recording(ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    made = spec()
    tables = {name: rows for name, rows in recording.tables.items() if name == "ax_max"}
    box = rulebox(Evaluator(made), recording.params, tables)
    given = list(cycles(recording))
    limits = Limits(shortest_gap=0.0, longest_gap=math.inf, budget=math.inf)
    started = time.monotonic()
    warm = box.supervisor(limits)
    for cycle in given:
        warm.step(replace(cycle, t=time.monotonic()))
    whole = time.monotonic() - started
    for number in range(count):
        path = folder / f"{number}.arrows"
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reading)
            supervisor = box.supervisor(limits)
            supervisor.recorder = Record(
                path, supervisor.door.contract, limits, box.identity, saving=supervisor.saving, every=20
            )
            run(supervisor, given, writing)
            os._exit(0)
        os.close(writing)
        time.sleep(rng.uniform(0.0, 1.1 * whole))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        completed = 0
        while data := os.read(reading, 65536):
            completed += len(data)
        os.close(reading)
        print(json.dumps({"file": path.name, "completed": completed}), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
