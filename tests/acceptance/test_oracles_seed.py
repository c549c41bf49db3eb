"""The paper's worked cases through `eval`, by both evaluators, with the shipped rules and overridden parameters."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from support import seed
from support.command import BACKENDS, arguments, close, evaluate, number, read_lines, write_cases
from support.shared import SUPERVISOR, oracle

Data = dict[str, Any]
#: Kind -> how many cases, how they become data, which rules they are for.
KINDS: dict[str, tuple[int, Callable[[Data], Data], list[str]]] = {
    "trajectory": (200, seed.trajectory, list(seed.TRAJECTORY_RULES.values())),
    "rss_eq1": (150, seed.following, ["rss_eq1", "safe_gap"]),
    "rect_rect": (80, seed.rectangles, ["contact"]),
    "corridor": (70, seed.corridor, ["static_collision"]),
}
#: A trajectory with a NaN at one sample and too much acceleration at another. The oracle stops at the NaN; the
#: language does not: what is violated at one sample is violated, whatever is missing at another (false and undefined = false).
VIOLATED_BESIDE_NAN = {(279, "friction"), (279, "ax_max")}


@cache
def cases(kind: str) -> tuple[Data, ...]:
    found = tuple(case for case in oracle("seed_dev.json")["cases"] if case["kind"] == kind)
    assert len(found) == KINDS[kind][0]
    return found


class Runs:
    """One run of the command for each kind and backend."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._done: dict[tuple[str, str], list[Data]] = {}

    def __call__(self, kind: str, backend: str) -> Iterator[tuple[Data, Data]]:
        """Each case with the line that the command wrote for it."""
        given = cases(kind)
        _, convert, rules = KINDS[kind]
        if (kind, backend) not in self._done:
            data = [convert(case) for case in given]
            self._done[kind, backend] = evaluate(self._folder, SUPERVISOR, data, rules, backend)
        return zip(given, self._done[kind, backend], strict=True)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(tmp_path_factory.mktemp("seed"))


def test_nothing_is_left_out() -> None:
    assert {case["kind"] for case in oracle("seed_dev.json")["cases"]} == set(KINDS)
    assert sum(count for count, _, _ in KINDS.values()) == len(oracle("seed_dev.json")["cases"]) == 500


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("check", seed.TRAJECTORY_RULES)
def test_trajectory(runs: Runs, backend: str, check: str) -> None:
    """Verdict, margin and deciding sample of each check of S-1-A-3 to S-1-A-6."""
    wrong = []
    for case, line in runs("trajectory", backend):
        wanted, found = case["expect"][check], line["rules"][seed.TRAJECTORY_RULES[check]]
        fits = _undefined if wanted["margin"] is None else _decided
        if (case["id"], check) in VIOLATED_BESIDE_NAN:
            fits = _violated_elsewhere
        if not fits(found, wanted):
            wrong.append((case["id"], wanted, found))
    assert not wrong


def _decided(found: Data, wanted: Data) -> bool:
    return (
        found["verdict"] == ("satisfied" if wanted["safe"] else "violated")
        and close(number(found["margin"]), wanted["margin"])
        and ("index" not in wanted or found["witness"] == {"p": wanted["index"]})
    )


def _undefined(found: Data, wanted: Data) -> bool:
    assert not wanted["safe"]
    at = {"p": wanted["index"]}
    return (found["verdict"], found["margin"], found["witness"]) == ("undefined", "nan", at)


def _violated_elsewhere(found: Data, wanted: Data) -> bool:
    assert wanted["margin"] is None
    assert not wanted["safe"]
    elsewhere: bool = found["witness"]["p"] != wanted["index"]
    return found["verdict"] == "violated" and number(found["margin"]) < 0.0 and elsewhere


@pytest.mark.parametrize("backend", BACKENDS)
def test_decision(runs: Runs, backend: str) -> None:
    """The paper's conjunction: safe only if all checks are."""
    assert [line["safe"] for _, line in runs("trajectory", backend)] == [
        case["expect"]["safe"] for case in cases("trajectory")
    ]


@pytest.mark.parametrize("backend", BACKENDS)
def test_eq1(runs: Runs, backend: str) -> None:
    """Eq. (1) as printed."""
    wrong = []
    for case, line in runs("rss_eq1", backend):
        wanted, found = case["expect"], line["rules"]["rss_eq1"]
        verdict = "satisfied" if wanted["safe"] else "violated"
        if found["verdict"] != verdict or not close(number(found["margin"]), wanted["margin"]):
            wrong.append((case["id"], wanted, found))
    assert not wrong


@pytest.mark.parametrize("backend", BACKENDS)
def test_original_rss(runs: Runs, backend: str) -> None:
    """The clamped distance of the original, and whether the gap is longer."""
    wrong = []
    for case, line in runs("rss_eq1", backend):
        wanted, found = case["expect"], line["rules"]["safe_gap"]
        verdict = "satisfied" if wanted["safe_original_rss"] else "violated"
        margin = case["inputs"]["d"] - wanted["d_min"]
        if found["verdict"] != verdict or not close(number(found["margin"]), margin):
            wrong.append((case["id"], wanted, found))
    assert not wrong


@pytest.mark.parametrize("backend", BACKENDS)
def test_eq1_is_guarded(runs: Runs, backend: str) -> None:
    """Where eq. (1) is unsound, safe_gap is violated (overlap) or the spec's constraint on braking is broken."""
    unsound = [(c, line) for c, line in runs("rss_eq1", backend) if c["expect"]["eq1_unsound_here"]]
    assert len(unsound) >= 5
    for case, line in unsound:
        assert line["rules"]["rss_eq1"]["verdict"] == "satisfied"
        if case["expect"]["overlap"]:
            assert line["rules"]["safe_gap"]["verdict"] == "violated"
        else:
            assert any("b_rear <= b_front" in text for text in line["constraints"])


@pytest.mark.parametrize("backend", BACKENDS)
def test_rectangles(runs: Runs, backend: str) -> None:
    """Separating axes: the gap between two boxes, and whether they overlap."""
    wrong = []
    for case, line in runs("rect_rect", backend):
        wanted, found = case["expect"], line["rules"]["contact"]
        verdict = "violated" if wanted["collides"] else "satisfied"
        if found["verdict"] != verdict or not close(number(found["margin"]), wanted["sat_gap"]):
            wrong.append((case["id"], wanted, found))
    assert not wrong


@pytest.mark.parametrize("backend", BACKENDS)
def test_corridor(runs: Runs, backend: str) -> None:
    """Inside a track: by how much. Not inside: violated, with a margin that is not positive."""
    wrong = []
    for case, line in runs("corridor", backend):
        wanted, found = case["expect"], line["rules"]["static_collision"]
        margin = number(found["margin"])
        if wanted["inside"]:
            fits = found["verdict"] == "satisfied" and close(margin, wanted["clearance"])
        else:
            fits = found["verdict"] == "violated" and margin < 0.0
        if not fits:
            wrong.append((case["id"], wanted, found))
    assert not wrong


def test_command_itself(runs: Runs, tmp_path: Path) -> None:
    """The command in a process of its own, with the default evaluator, writes what it writes here."""
    _, convert, rules = KINDS["trajectory"]
    data = write_cases(tmp_path / "cases.jsonl", [convert(case) for case in cases("trajectory")])
    command = [sys.executable, "-m", "trackmarshal.cli.main", *arguments(SUPERVISOR, data, rules, "numpy")]
    done = subprocess.run(command, capture_output=True, check=False, text=True, encoding="utf-8")
    assert (done.returncode, done.stderr) == (1, "")  # some of them are unsafe
    assert read_lines(done.stdout) == [line for _, line in runs("trajectory", "numpy")]
