"""Generated C: one Supervisor step, a batch, the kernel against one written by hand, temporal operators, compiling and loading.

Medians of CPU seconds. The step is all rules of S-1-A on a driving and an emergency trajectory of 50 points, 3 objects and borders of
2 x 1500 points, from numpy arrays. The call in C alone is timed in C, while the car drives on from cycle to cycle.
"""

from __future__ import annotations

import ctypes
import math
import os
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Container
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from measuring import THEN, WHEN_LIMITED, by_turns, emptied, median, memory
from numpy.typing import NDArray

from trackmarshal.backends.c.batch import prepared_columns, run_columns
from trackmarshal.backends.c.build import EXACT, FAST, SHARED, compiler, own_machine
from trackmarshal.backends.c.monitoring import Monitors
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.c.step import Stepper
from trackmarshal.evaluation import load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.frame import Columns, Names

ROOT = Path(__file__).resolve().parents[2]
SIX = ["friction", "turn_radius", "drive_acceleration", "braking_limit", "speed_limit", "pose_match"]
#: TRACKMARSHAL_STEPS=1000000 looks at a million steps.
STEPS = int(os.environ.get("TRACKMARSHAL_STEPS", "20000"))
LATE = f"C: Supervisor step, 99.9th percentile of {STEPS} to the median"
GROWTH = f"C: Supervisor, growth over {STEPS} steps"
CALL = "C: Supervisor step, the call in C"
CALL_THEN = f"{CALL}, {THEN}"
LIMITS = {
    "C: Supervisor step": 80e-6,
    CALL: 20e-6,
    CALL_THEN: 20e-6,
    f"{CALL}, caches emptied, to the same hot (ratio)": 2.5,
    f"{LATE} (ratio)": 4.0,
    f"{GROWTH}, memory": 100_000.0,
    "C: batch, six rules, a trajectory": 1.5e-6,
    "C: generated to hand-written (ratio)": 1.2,
    "C: compile the shipped spec, cold": 3.0,
    "C: generate and load the shipped spec, warm": 0.05,
    "C: always[0, 10 s] on 1,000,000 samples": 0.03,
    "C: until[0, 10 s] on 1,000,000 samples": 0.05,
    "C: always[0, 1 s] online, a sample": 0.3e-6,
    "C: always[0, 600 s] online, a sample": 0.3e-6,
    "C: until[0, 1 s] online, a sample": 0.3e-6,
    "C: until[0, 600 s] online, a sample": 0.3e-6,
}


def measure() -> dict[str, float]:
    spec = load([ROOT / "specs" / "supervisor"])
    result = _step(spec)
    result |= _call(spec)
    result |= _point_wise(spec)
    result |= _temporal()
    result |= _online()
    result |= _building(spec)
    return result


def program(spec: Spec, names: list[str] | None = None) -> CProgram:
    return CProgram(spec, [r for r in spec.rules if (r.kind == "rule" if names is None else r.name in names)])


def borders(count: int) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """A winding ring of 600 m radius, 12 m wide and more."""

    def ring(radius: float, phase: float) -> list[tuple[float, float]]:
        angles = [2 * math.pi * i / count for i in range(count)]
        return [
            (
                (radius + 3 * math.sin(60 * t + phase)) * math.cos(t),
                (radius + 3 * math.sin(60 * t + phase)) * math.sin(t),
            )
            for t in angles
        ]

    return ring(593.0, 0.0), ring(607.0, 1.0)


def plan(start: float, v: float, braking: float) -> dict[str, Any]:
    """50 samples on a circle of 600 m radius, from a station [m] on."""
    t = np.arange(50) * 0.1
    speed = np.maximum(v - braking * t, 0.0)
    stop = v / braking if braking else math.inf
    s = v * np.minimum(t, stop) - braking * np.minimum(t, stop) ** 2 / 2
    angle = (start + s) / 600.0
    return {
        "t": t, "s": s, "x": 600 * np.cos(angle), "y": 600 * np.sin(angle), "heading": angle + math.pi / 2, "kappa": np.full(50, 1 / 600.0),
        "v": speed, "a": np.where(speed > 0, -braking, 0.0), "grip": np.ones(50),
    }  # fmt: skip


def cycle(at: float = 100.0) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """The driving trajectory from a station [m] on, the emergency one, and what they have in common."""
    ahead = np.array([60.0, 90.0, -40.0]) + at
    angle, here = ahead / 600.0, at / 600.0
    objects = {"x": 602 * np.cos(angle), "y": 602 * np.sin(angle), "heading": angle + math.pi / 2, "v": np.full(3, 45.0),
               "length": np.full(3, 4.7), "width": np.full(3, 2.8), "age": np.zeros(3)}  # fmt: skip
    empty = np.zeros(0)
    shared: dict[str, Any] = {
        "ego": {"x": 600 * math.cos(here), "y": 600 * math.sin(here), "heading": here + math.pi / 2, "v": 40.0, "age": 0.0},
        "objects": objects, "obstacles": dict.fromkeys(("x", "y", "heading", "length", "width"), empty),
    }  # fmt: skip
    return plan(at, 40.0, 0.0), plan(at, 40.0, 9.0), shared


def candidate() -> dict[str, Any]:
    """All signals as the driving trajectory is judged with."""
    driving, _, shared = cycle()
    return {**shared, "plan": driving, "emergency": False}


def _step(spec: Spec) -> dict[str, float]:
    """A step's median, its 99.9th percentile as a multiple of that, and what the process grows by meanwhile."""
    rules = [rule for rule in spec.rules if rule.kind == "rule"]
    now = 0.0
    source = generate(spec, rules, doored=True)
    stepper = Stepper(source, asdict(Limits()), lambda: now)
    driving, emergency, shared = cycle()
    given: dict[str, Any] = {"driving": driving, "emergency": emergency, **shared}
    columns = [_columns(source, name, given[name]) for name in stepper.words.columns]
    lines = [line(points) for points in borders(1500)]
    spent = np.ones(STEPS)  # in memory before the first step
    number = 0

    def one() -> None:
        nonlocal number, now
        number += 1
        now = 0.1 * number
        said = stepper.step(number, now, now, columns, lines, [True])
        assert said.judged, stepper.reasons(said)

    for _ in range(500):
        one()
    before = memory()
    for k in range(STEPS):
        begin = time.process_time_ns()
        one()
        spent[k] = time.process_time_ns() - begin
    grown = memory() - before
    middle, late = np.quantile(spent, [0.5, 0.999]) / 1e9
    return {
        "C: Supervisor step": float(middle),
        f"{LATE} (ratio)": float(late / middle),
        f"{GROWTH}, memory": float(grown),
    }


def _columns(source: Source, name: str, given: dict[str, Any]) -> Columns:
    """A signal as a frame has it."""
    item = source.plan.input("plan" if name in ("driving", "emergency") else name)
    names = [info.name for info, _ in item.fields]
    return Columns(Names(names), np.array([np.atleast_1d(given[name]) for name in names], dtype=np.float64))


class Calls:
    """Steps in C alone, timed in C. The car drives on by 4 m from cycle to cycle, so that no step is the one before again."""

    CYCLES = 64

    def __init__(self, spec: Spec, names: Container[str] | None = None) -> None:
        """names: of the rules that it has; all without."""
        timed = built("timed")
        rules = [rule for rule in spec.rules if rule.kind == "rule" and (names is None or rule.name in names)]
        source = generate(spec, rules, doored=True)
        stepper = self._stepper = Stepper(source, asdict(Limits()), lambda: 0.0)
        stepper.bind_clock(ctypes.cast(timed.timed_clock, ctypes.c_void_p).value or 0)
        lines = [line(points) for points in borders(1500)]
        width = stepper.width
        self._words = np.zeros(self.CYCLES * width, dtype=np.uint8)
        #: Columns of all cycles; they stay in memory.
        self._columns = []
        for k in range(self.CYCLES):
            driving, emergency, shared = cycle(4.0 * k)
            given: dict[str, Any] = {"driving": driving, "emergency": emergency, **shared}
            columns = [_columns(source, name, given[name]) for name in stepper.words.columns]
            self._columns += columns
            stepper.pack(self._words[k * width :], columns, lines, [True])
        self._number = ctypes.c_int64(1)
        self._run = timed.timed_steps
        self._run.restype = ctypes.c_size_t

    def run(self, steps: int) -> NDArray[np.float64]:
        """CPU seconds of so many steps, one after the other."""
        stepper, spent = self._stepper, np.ones(steps)
        size, pointer = ctypes.c_size_t, ctypes.c_void_p
        done = self._run(
            stepper.function, pointer(stepper.bound), ctypes.byref(self._number), size(steps), size(self.CYCLES),
            pointer(self._words.ctypes.data), size(stepper.width), pointer(stepper.judged), pointer(spent.ctypes.data),
        )  # fmt: skip
        assert done == steps, "a cycle was refused"
        return spent


def _call(spec: Spec) -> dict[str, float]:
    """A step's call in C: one after the other, and each with caches emptied."""
    calls, then = Calls(spec), Calls(spec, WHEN_LIMITED)
    both = [(np.median(calls.run(STEPS // 10)), np.median(then.run(STEPS // 10))) for _ in range(10)]
    hot, of_then = map(float, np.median(both, axis=0))
    cold = emptied(lambda: float(calls.run(1)[0]))
    return {
        CALL: hot,
        CALL_THEN: of_then,
        f"{CALL}, caches emptied": cold,
        f"{CALL}, caches emptied, to the same hot (ratio)": cold / hot,
    }


def _point_wise(spec: Spec) -> dict[str, float]:
    made = program(spec, SIX)
    cases = 10_000
    driving = candidate()
    columns = {(n, f): np.tile(driving[n][f], (cases, 1)) for n, f, _ in made.order.columns}
    numbers = {(n, f): np.full(cases, driving[n][f]) for n, f in made.order.numbers}
    result = {
        "C: batch, six rules, a trajectory": median(lambda: run_columns(made, columns, numbers), 15) / cases
    }
    seven, by_hand = by_turns(_with_rss(driving), ByHand(spec).prepared(driving, FRONT, RUNS), 101)
    seven, by_hand = seven / RUNS, by_hand / RUNS
    return result | {
        "C: six rules and RSS generated, a trajectory": seven,
        "C: six rules and RSS by hand, a trajectory": by_hand,
        "C: generated to hand-written (ratio)": seven / by_hand,
    }


def with_rss() -> CProgram:
    """What the hand-written kernel computes, generated: six rules, and eq. (1) with the gap given."""
    text = (
        "module bench_rss\nuse prelude.rss\n"
        "signal front : state { gap: m, v: m/s, ego: m/s }\n"
        "param rho : s = 0.2 s\nparam a_rho : m/s^2 = 6 m/s^2\nparam b : m/s^2 = 13 m/s^2\n"
        'rule eq1 "Eq. (1)"\n'
        "  require rss_eq1(front.gap, front.ego, front.v, rho, a_rho, b, b) > 0 m\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench_rss.spec"
        path.write_text(text, encoding="utf-8")
        return program(load([ROOT / "specs" / "supervisor", path]), [*SIX, "eq1"])


#: Gap to the vehicle in front, its speed, and the car's own.
FRONT = {"gap": 55.3, "v": 45.0, "ego": 40.0}


#: So often a kernel is run for one measurement.
RUNS = 10_000


def _with_rss(driving: dict[str, Any]) -> Callable[[], object]:
    """What the hand-written kernel computes, on one trajectory again and again, as there."""
    made = with_rss()
    # Few enough cases at once that the binding's own arrays stay in the cache: the kernel by hand has none.
    cases = 500
    columns = {
        (n, f): np.broadcast_to(driving[n][f], (cases, len(driving[n][f]))) for n, f, _ in made.order.columns
    }
    values = {**driving, "front": FRONT}
    numbers = {(n, f): np.full(cases, values[n][f]) for n, f in made.order.numbers}
    some = prepared_columns(made, columns, numbers)
    return lambda: [some() for _ in range(RUNS // cases)]


class _Limits(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_double) for name in ("mass", "mu", "g", "r_min", "drag", "drive_factor", "b_max", "v_max", "d_loc",
                                               "response", "a_response", "b_rear", "b_front")),
        ("knots", ctypes.c_size_t), ("knot", ctypes.c_void_p), ("value", ctypes.c_void_p),
    ]  # fmt: skip


def built(name: str) -> ctypes.CDLL:
    """A C file beside this one, built with the same flags as generated code."""
    command = compiler()
    assert command is not None, "no C compiler"
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"{name}.so"
        source = Path(__file__).with_name(f"{name}.c")
        made = [*command, *EXACT, *FAST, *own_machine(), *SHARED, "-o", str(target), str(source), "-lm"]
        subprocess.run(made, check=True)
        return ctypes.CDLL(str(target))


class ByHand:
    """The hand-written kernel."""

    def __init__(self, spec: Spec) -> None:
        self._dll = built("kernel")
        short = {name.rpartition(".")[2]: info.value for name, info in spec.params.items()}
        table = next(info for name, info in spec.tables.items() if name.endswith("ax_max"))
        self._table = np.array(table.knots), np.array(table.values)
        self._limits = _Limits(
            *(short[{"r_min": "R_min"}.get(name, name)] for name, *_ in _Limits._fields_[:13]),
            len(self._table[0]),
            *(column.ctypes.data for column in self._table),
        )

    def prepared(self, driving: dict[str, Any], front: dict[str, float], runs: int) -> Callable[[], Any]:
        """A function that runs it so many times on one trajectory, and gives its seven margins."""
        margins = np.zeros(7)
        columns = [driving["plan"][name] for name in ("x", "y", "kappa", "v", "a", "grip")]
        ego = driving["ego"]
        arguments = (
            ctypes.c_size_t(runs), ctypes.byref(self._limits), ctypes.c_size_t(len(columns[0])),
            *(ctypes.c_void_p(column.ctypes.data) for column in columns),
            *map(ctypes.c_double, (ego["x"], ego["y"], front["ego"], front["gap"], front["v"])), ctypes.c_void_p(margins.ctypes.data),
        )  # fmt: skip

        def run() -> Any:
            self._dll.kernel_many(*arguments)
            return margins

        return run


def _temporal() -> dict[str, float]:
    formulas = {
        "always[0, 10 s]": "always[0 s, 10 s] (p.p > 0)",
        "until[0, 10 s]": "(p.p > 0) until[0 s, 10 s] (p.q > 0)",
    }
    rng = np.random.default_rng(1)
    samples = 1_000_000
    columns = {
        ("log", "t"): np.arange(samples, dtype=np.float64)[None] * 0.01,
        ("log", "p"): rng.normal(size=(1, samples)),
        ("log", "q"): rng.normal(size=(1, samples)),
    }
    result = {}
    for name, formula in formulas.items():
        spec = _one_rule(formula)
        made = program(spec)
        result[f"C: {name} on 1,000,000 samples"] = median(partial(run_columns, made, columns), 7)
    return result


def _online() -> dict[str, float]:
    """A sample at a time, 100 a second: windows of 100 and of 60,000 samples."""
    rng = np.random.default_rng(1)
    samples = 200_000
    log = {"t": np.arange(samples) * 0.01, "p": rng.normal(size=samples), "q": rng.normal(size=samples) - 3.0}
    result = {}
    for window in ("1 s", "600 s"):
        for name, formula in (
            ("always", f"always[0 s, {window}] (p.p > 0)"),
            ("until", f"(p.p > -5) until[0 s, {window}] (p.q > 0)"),
        ):
            spec = _one_rule(formula)
            monitors = Monitors(spec, spec.rules, 65_536)
            taken = median(partial(monitors.run, "r", log), 7)
            result[f"C: {name}[0, {window}] online, a sample"] = taken / samples
    return result


def _one_rule(formula: str) -> Spec:
    text = "module bench\nsignal log : series { t: s increasing, p: 1, q: 1 }\n"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.spec"
        path.write_text(f'{text}rule r "bench"\n  along log as p\n  require {formula}\n', encoding="utf-8")
        return load([path])


def _building(spec: Spec) -> dict[str, float]:
    before = os.environ.get("TRACKMARSHAL_CACHE")
    spent = []
    try:
        for _ in range(3):
            with tempfile.TemporaryDirectory() as folder:
                os.environ["TRACKMARSHAL_CACHE"] = folder
                begin = os.times()
                program(spec).library_for()
                end = os.times()
                spent.append(sum(end[:4]) - sum(begin[:4]))
                warm = median(lambda: program(spec).library_for(), 5)
    finally:
        if before is None:
            del os.environ["TRACKMARSHAL_CACHE"]
        else:
            os.environ["TRACKMARSHAL_CACHE"] = before
    return {
        "C: compile the shipped spec, cold": statistics.median(spent),
        "C: generate and load the shipped spec, warm": warm,
    }


if __name__ == "__main__":
    for name, value in measure().items():
        print(f"{value * 1e6:14.2f} us  {name}" if "ratio" not in name else f"{value:14.2f}     {name}")
