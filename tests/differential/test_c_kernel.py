"""The yardstick: the kernel written by hand gives the answers of the generated one, on the same inputs."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from trackmarshal.backends.c.batch import run_columns
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import load
from trackmarshal.runtime.verdict import VERDICTS

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")
ROOT = Path(__file__).resolve().parents[2]
#: The generated rules in the order of the kernel's margins.
ORDER = ("friction", "turn_radius", "drive_acceleration", "braking_limit", "speed_limit", "pose_match", "eq1")


def bench(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "benchmarks"))
    found = importlib.util.spec_from_file_location("bench_c", ROOT / "tests" / "benchmarks" / "bench_c.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_same_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Margins to rounding (the two sum in different orders), verdicts exactly."""
    module = bench(monkeypatch)
    by_hand, made = module.ByHand(load([ROOT / "specs" / "supervisor"])), module.with_rss()
    numbers = {rule.name: made.number(rule) for rule in made.rules}
    rng = np.random.default_rng(3)
    seen: set[tuple[str, str]] = set()
    for _ in range(300):
        driving: dict[str, Any] = module.candidate()
        plan = driving["plan"] = dict(driving["plan"])
        plan["v"] = np.abs(rng.normal(rng.uniform(0, 120), 3, size=50))
        plan["a"] = rng.normal(0, rng.choice([0.5, 5.0, 12.0]), size=50)
        plan["kappa"] = rng.normal(0, rng.choice([0.001, 0.02, 0.1]), size=50)
        plan["grip"] = rng.uniform(0.8, 1.0, size=50)
        driving["ego"] = {
            **driving["ego"],
            "x": plan["x"][20] + rng.normal(0, 4),
            "y": plan["y"][20] + rng.normal(0, 4),
        }
        front = {"gap": rng.uniform(0, 120), "v": rng.uniform(0, 80), "ego": rng.uniform(0, 80)}
        values = {**driving, "front": front}
        verdicts, margins = run_columns(
            made,
            {(n, f): np.array([values[n][f]]) for n, f, _ in made.order.columns},
            {(n, f): np.array([values[n][f]]) for n, f in made.order.numbers},
        )
        for name, margin in zip(ORDER, by_hand.prepared(driving, front, 1)(), strict=True):
            verdict, other = VERDICTS[verdicts[0, numbers[name]]], float(margins[0, numbers[name]])
            assert math.isclose(margin, other, rel_tol=1e-9, abs_tol=1e-9), name
            assert verdict == ("satisfied" if margin >= 0.0 else "violated"), name
            seen.add((name, verdict))
    assert seen == {(name, verdict) for name in ORDER for verdict in ("satisfied", "violated")}
