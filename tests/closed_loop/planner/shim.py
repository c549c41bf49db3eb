"""What graph-ltpl 0.48 needs to run on today's packages, and simulated time in place of the machine's.

Imported before graph_ltpl, and only in the planner's own environment.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # as graph-ltpl's own example has it
os.environ["OMP_NUM_THREADS"] = "1"
os.environ["MPLBACKEND"] = "agg"

import builtins
import time

import numpy

#: Aliases of Python's own types that numpy 1.24 removed.
ALIASES = ("bool", "int", "float", "complex", "object", "str")


class Clock:
    """Simulated time, s. The planner reads `time.time()`: it has to be `Clock.now` before graph_ltpl is imported."""

    def __init__(self) -> None:
        self.t = 0.0

    def now(self) -> float:
        return self.t


def install() -> Clock:
    """Puts numpy's aliases back and replaces the clock of this process; returns the clock."""
    for name in ALIASES:
        if name not in numpy.__dict__:
            setattr(numpy, name, getattr(builtins, name))
    clock = Clock()
    time.time = clock.now
    return clock
