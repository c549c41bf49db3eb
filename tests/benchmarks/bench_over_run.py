"""Rules over the run: a cycle in generated C, by itself and as a part of a Supervisor's step, and in Python. Medians of CPU seconds."""

from __future__ import annotations

import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from bench_c import Calls
from measuring import median

from trackmarshal.backends.c.build import EXACT, FAST, compiler
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import Evaluator, load, loads

ROOT = Path(__file__).resolve().parents[2]
SIGNALS = "module m\nsignal ego : state { v: m/s }\nsignal objects : set of object { x: m }\nevent flag\n"
ONE, OTHER = "require once[0 s, {0} s] ego.v > 5 m/s", "require ego.v > 5 m/s since[1 s, {0} s] flag"
EACH = "for all o in objects require once[0 s, 10 s] o.x > 5 m"
#: Twenty rules that remember, beside those of the Supervisor.
MORE = "".join(
    f'rule past_{i} "" require once[0 s, {i + 1} s] plan.first.v > 1 m/s\n'
    f'rule count_{i} "" require count(rising(ego.y > {i} m), last: 10 s) <= 3\n' for i in range(10)
)  # fmt: skip
LIMITS = {
    "over the run, C: once[0, 1 s], a cycle": 0.3e-6,
    "over the run, C: once[0, 600 s], a cycle": 0.3e-6,
    "over the run, C: since[1, 10 s], a cycle": 0.3e-6,
    "over the run, C: once[0, 10 s] of 32 objects, a cycle": 5e-6,
    "over the run, C: Supervisor step with 20 rules that remember, to that without (ratio)": 1.3,
}


def measure() -> dict[str, float]:
    result: dict[str, float] = {}
    if compiler() is not None:
        result |= {
            "over the run, C: once[0, 1 s], a cycle": alone(ONE.format(1)),
            "over the run, C: once[0, 600 s], a cycle": alone(ONE.format(600)),
            "over the run, C: since[1, 10 s], a cycle": alone(OTHER.format(10)),
            "over the run, C: once[0, 10 s] of 32 objects, a cycle": alone(EACH),
            "over the run, C: Supervisor step with 20 rules that remember, to that without (ratio)": beside(),
        }
    return result | {"over the run, numpy: once[0, 10 s], a cycle": in_python(ONE.format(10))}


def alone(rule: str) -> float:
    """One rule in C."""
    spec = loads(f'{SIGNALS}rule f "" {rule}\n')
    source = generate(spec, list(spec.rules))
    fill = "in.t = (double)k * 0.05;"
    if "ego" in source.plan.inputs:
        fill += " in.ego.v = (double)((k * 7919u) % 1000u) / 100.0;"
    if "flag" in source.plan.inputs:
        fill += " in.flag = ((k % 37u) == 0u) ? TM_TRUE : TM_FALSE;"
    if "objects" in source.plan.inputs:
        fill += " in.objects.count = 32u; in.objects.x = x; in.objects.id = id;"
        fill += " for (unsigned i = 0u; i < 32u; ++i) { x[i] = (double)(((k * 7919u) + (i * 31u)) % 1000u) / 100.0; }"
    driver = (Path(__file__).parent / "over_run.c.in").read_text(encoding="utf-8")
    driver = driver.replace("FILL", fill).replace("REMEMBER", "tm_remember(&context, &in, true);")
    found = compiler()
    assert found is not None
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (
            ("supervisor.h", source.header),
            ("supervisor.c", source.source),
            ("main.c", driver),
        ):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        subprocess.run(
            [*found, *EXACT, *FAST, "supervisor.c", "main.c", "-o", "run", "-lm"], cwd=folder, check=True
        )
        runs = [
            subprocess.run([f"{folder}/run"], capture_output=True, text=True, check=True) for _ in range(5)
        ]
    return statistics.median(float(run.stdout.split()[0]) for run in runs)


def beside() -> float:
    """A step's call in C with twenty rules that remember, to that without them, by turns."""
    with tempfile.TemporaryDirectory() as folder:
        left_out = shutil.ignore_patterns("*.jsonl*", "*.json")
        own = Path(shutil.copytree(ROOT / "specs", Path(folder) / "specs", ignore=left_out)) / "supervisor"
        plain = Calls(load([own]))
        (own / "more.spec").write_text(
            f"module supervisor.more\nuse supervisor.interface\n{MORE}", encoding="utf-8"
        )
        more = Calls(load([own]))
    for calls in (plain, more):
        calls.run(500)
    without, with_them = [], []
    for _ in range(40):
        without.append(float(np.median(plain.run(200))))
        with_them.append(float(np.median(more.run(200))))
    return statistics.median(with_them) / statistics.median(without)


def in_python(rule: str) -> float:
    """One rule, cycle by cycle, with numpy for its leaves."""
    evaluator = Evaluator(loads(f'{SIGNALS}rule f "" {rule}\n'))
    count = 200

    def run() -> None:
        going = evaluator.over_run()
        for k in range(count):
            going.step(evaluator.read({"t": 0.05 * k, "signals": {"ego": {"v": float(k % 7)}}}))

    return median(run, 5) / count
