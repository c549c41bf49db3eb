"""Rules over the run on a million cycles at once: the whole rule, and what its operator takes beyond a rule that only says its formulas of each
cycle. CPU seconds."""

from __future__ import annotations

import time

import numpy as np

from trackmarshal.evaluation import Evaluator, loads

COUNT = 1_000_000
SIGNALS = "module m\nsignal ego : state { v: m/s, w: m/s }\n"
P, Q = "ego.v > 5 m/s", "ego.w < 1 m/s"
BACK = {
    "once[0 s, 3 s] p": f"once[0 s, 3 s] {P}",
    "once[1 s, 600 s] p": f"once[1 s, 600 s] {P}",
    "historically[0 s, 3 s] p": f"historically[0 s, 3 s] {P}",
    "p since[0 s, 3 s] q": f"{P} since[0 s, 3 s] {Q}",
    "p since[1 s, 600 s] q": f"{P} since[1 s, 600 s] {Q}",
    "rising(p)": f"rising({P})",
    "count(p, last: 3 s) <= 4": f"count({P}, last: 3 s) <= 4",
}
AHEAD = {
    "eventually[0 s, 3 s] p": f"eventually[0 s, 3 s] {P}",
    "always[0 s, 3 s] p": f"always[0 s, 3 s] {P}",
    "always[1 s, 600 s] p": f"always[1 s, 600 s] {P}",
    "p until[0 s, 3 s] q": f"{P} until[0 s, 3 s] {Q}",
    "q until[0 s, 3 s] p": f"{Q} until[0 s, 3 s] {P}",
    "q until[1 s, 600 s] p": f"{Q} until[1 s, 600 s] {P}",
}
#: What takes long where other numbers make more of a window count.
LONG = ("p since[1 s, 600 s] q", "always[1 s, 600 s] p", "p until[0 s, 3 s] q", "q until[1 s, 600 s] p")
LIMITS = {f"a million cycles: {name}": 0.05 for name in BACK | AHEAD}


def measure() -> dict[str, float]:
    random = np.random.default_rng(1)
    v, w = np.cumsum(random.normal(size=COUNT)) * 0.1, random.normal(size=COUNT)
    # Cycles that come a little late: no two windows are of one length.
    stamps = np.arange(COUNT) * 50_000_000 + random.integers(0, 2_000_000, COUNT)
    found = {}
    for name in BACK | AHEAD:
        whole, alone = _medians(name, stamps, {"ego": {"v": v, "w": w}})
        found[f"a million cycles: {name}"] = whole - alone
        found[f"a million cycles: {name}, the whole rule"] = whole
    for what, p in (
        ("p is noise", 5.0 + random.normal(size=COUNT)),
        ("p holds by more than any q", 1000.0 + v),
    ):
        for name in LONG:
            whole, alone = _medians(name, stamps, {"ego": {"v": p, "w": w}})
            found[f"a million cycles: {name}, where {what}"] = whole - alone
    return found


def _medians(name: str, stamps: np.ndarray, signals: dict[str, dict[str, np.ndarray]]) -> tuple[float, float]:
    """A rule, and one that only says its formulas of each cycle."""
    formula = (BACK | AHEAD)[name]
    plain = f"({P} or {Q})" if Q in formula else P
    # By turns, each first as often as second: who comes second finds memory that the first one has given back.
    spent: dict[str, list[float]] = {formula: [], plain: []}
    for k in range(8):
        for one in (formula, plain) if k % 2 else (plain, formula):
            spent[one].append(_seconds(one, stamps, signals))
    return float(np.median(spent[formula])), float(np.median(spent[plain]))


def _seconds(formula: str, stamps: np.ndarray, signals: dict[str, dict[str, np.ndarray]]) -> float:
    """A run of one rule."""
    used = {"ego": {name: column for name, column in signals["ego"].items() if f"ego.{name}" in formula}}
    run = Evaluator(loads(f'{SIGNALS}rule f "" require {formula}\n')).whole_run()
    begin = time.process_time()
    run.step(stamps, used)
    return time.process_time() - begin
