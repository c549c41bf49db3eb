"""The engine on the recordings of a planner: which rules and which demands of the contract fire, by cycle and candidate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from support.shared import REPOSITORY, shared
from trackmarshal.cli.replay import evaluator_for
from trackmarshal.runtime.faults import NAMES
from trackmarshal.scenarios import load
from trackmarshal.scenarios.replay import replay

#: Candidates, as everything by candidate is keyed; demands on a cycle as a whole stand for both.
CANDIDATES = ("driving", "emergency")
Key = tuple[int, str]


@dataclass(frozen=True)
class Firing:
    """A rule, or a fault of the contract, that makes a candidate unsafe; a margin of NaN is undefined."""

    name: str
    margin: float


@dataclass(frozen=True)
class Run:
    """fired: by index of the cycle and candidate, where anything fired. rules: all that were judged."""

    name: str
    rules: tuple[str, ...]
    fired: dict[Key, tuple[Firing, ...]]


@cache
def run(name: str, share: float, every: int = 1, backend: str = "numpy") -> Run:
    """A recording with the limits of its car, and a share more of grip and drive; of its cycles each `every`th.

    Cycles are judged one by one, so that leaving some out changes nothing in the others (docs/supervisor.md, "The judge").
    """
    path = shared("data", "planner", f"{name}.tmrec.jsonl.gz")
    recording = load(path)
    wider = {"mu": recording.params["mu"] * (1.0 + share), "drive_factor": 1.0 + share}
    kept = recording.cycles[::every]
    recording = replace(recording, params={**recording.params, **wider}, cycles=kept)
    specs = REPOSITORY / "specs"
    evaluator = evaluator_for(recording, specs / "supervisor", [*_nowhere(path)], REPOSITORY, None, backend)
    outcome = replay(recording, evaluator, brief=True)
    fired: dict[Key, tuple[Firing, ...]] = {}
    for index, cycle in enumerate(outcome.cycles):
        assert set(cycle.results) == set(CANDIDATES)
        for candidate, result in cycle.results.items():
            rules = [Firing(n, r.margin) for n, r in result.rules.items() if r.unsafe]
            faults = [Firing(f"contract: {NAMES[fault.code]}", float("nan")) for fault in cycle.faults]
            if rules or faults:
                fired[index * every, candidate] = (*rules, *faults)
    return Run(name, tuple(rule.name for rule in evaluator.rules), fired)


def _nowhere(recording: Path) -> Sequence[Path]:
    """Places of a track, far away: the planner knows of none."""
    return [recording.parent / "ltpl_track.spec"]
