"""Rules that C works out for several samples at once say what the reference says, however many that are and wherever a number is missing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from support.agreement import compiled, outcomes, read, results, same
from trackmarshal.backends.c import build
from trackmarshal.backends.c.source import Source, generated
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")

SPEC = """module several

use prelude.frames

signal plan : trajectory { t: s increasing, x: m, y: m, v: m/s, a: m/s^2 }
signal ego : state { x: m, v: m/s }

rule slow "every sample, with a function of the ego's beside"
  for all p in plan
  require p.v * abs(p.a) / 2 m/s^2 <= max(ego.v, 3 m/s)
rule near "one of them"
  require exists p in plan: (abs(p.x - ego.x) <= 2 m and p.v >= 5 m/s)
rule steady "in range, where there may be a division by zero beside it"
  for all   consecutive p, q in plan
  where     distance(p, q) >= 1 m
  require   (q.v^2 - p.v^2) / (2 * distance(p, q)) >= -4 m/s^2 and p.a <= 5 m/s^2
rule close "the same where the range leaves out its limit"
  for all   consecutive p, q in plan
  where     distance(p, q) < 1 m
  require   abs(p.v - q.v) <= 1 m/s
rule both "two loops and a number that is chosen"
  require (for all consecutive o, p, q in plan: (distance(o, q) <= (if p.v < 2 m/s then 3 m else 9 m)))
          and (exists p in plan where p.a > 0 m/s^2: (p.v >= 4 m/s))
rule ahead "in range, in the middle of a formula: whether it applies is not asked beside it; those out of range break it"
  require (for all p in plan where p.x < 2 m: (p.v >= 5 m/s)) and ego.v <= 9 m/s
rule none "of those in range, nothing is asked"
  for all p in plan where p.a > 0 m/s^2
  require true
"""


def cases() -> Iterator[dict[str, Any]]:
    """Timelines of none to ten samples, whole, and with a number missing, or an infinite one, in each place of each column."""
    for count in range(11):
        columns = {
            "t": [0.1 * k for k in range(count)],
            "x": [0.9 * k + 0.3 * (k % 3) - 0.5 * (k > 4) for k in range(count)],
            "y": [0.0 if k in (2, 3) else 0.2 * (k % 2) for k in range(count)],
            "v": [math.fabs(6.5 - k) for k in range(count)],
            "a": [-0.5 if k % 4 else 1.5 for k in range(count)],
        }
        if count > 4:
            columns["x"][4], columns["y"][4] = columns["x"][3], columns["y"][3]  # no way at all
        changed = [(name, at) for name in ("x", "v", "a") for at in range(count)]
        for number, change in enumerate([None, *changed]):
            plan = {name: list(column) for name, column in columns.items()}
            if change is not None:
                plan[change[0]][change[1]] = math.nan if number % 3 else math.inf
            yield {"id": f"{count}-{number}", "signals": {"plan": plan, "ego": {"x": 3.0, "v": 6.0}}}


@pytest.mark.parametrize("several", [1, 2, 4])
def test_says_what_the_reference_says(several: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def library(source: Source, capacities: Mapping[str, int]) -> Path:
        assert "tm_put_where(" in source.source
        return build.library(source, {**capacities, "TM_SEVERAL": several})

    monkeypatch.setattr("trackmarshal.backends.c.library.library", library)
    spec = compiled(SPEC)
    frames = read(spec, list(cases()))
    assert len(frames) > 150
    said = outcomes(Evaluator(spec, None, "c"), frames)
    seen = set()
    for frame, own, wanted in zip(
        frames, said, results(spec, frames, "reference", series=False), strict=True
    ):
        for name, rule in wanted.rules.items():
            seen.add((name, rule.verdict))
            assert own[name][0] == rule.verdict, (frame.id, name)
            assert same(own[name][1], rule.margin), (frame.id, name)
    assert {verdict for _, verdict in seen} == {"satisfied", "violated", "undefined", "inactive"}


def test_members_of_enumerations_are_not_worked_out_for_several_samples_at_once() -> None:
    """Their margins are infinite, which counts as not known there: all would be worked out twice."""
    head = "module made\nenum gear { park, drive }\nsignal plan : trajectory { t: s increasing, x: m, g: gear }\n"
    for text, several in (
        ("for all p in plan\n  require p.g is drive or p.x <= 2 m", False),
        ("exists p in plan\n  require p.x <= 2 m and (p.g is drive and p.x >= 1 m)", False),
        ("for all p in plan where p.g is drive\n  require p.x <= 2 m", False),
        ("require exists p in plan where p.g is drive: (p.x <= 2 m)", True),
        ("for all p in plan\n  require (if p.g is drive then p.x else 2 * p.x) <= 2 m", True),
    ):
        spec = compiled(f'{head}rule r "that"\n  {text}\n')
        assert ("tm_several " in generated(spec, spec.rules).source) == several, text


@pytest.mark.parametrize(
    ("step", "first", "last"),
    [("{0} + {0} * 0.5", "p.x", "{0} <= 2 m"), ("{0} and {0}", "p.x <= 2 m", "{0}"), ("{0} or {0}", "p.x <= 2 m", "{0}")],
)  # fmt: skip
def test_what_names_the_one_before_twice_is_gone_through_once(step: str, first: str, last: str) -> None:
    """There are 2^40 ways to the bottom."""
    lets = "".join(f"  let y{n + 1} = {step.format(f'y{n}')}\n" for n in range(40))
    spec = compiled(
        "module made\nsignal plan : trajectory { t: s increasing, x: m }\n"
        f'rule r "that"\n  for all p in plan\n  let y0 = {first}\n{lets}  require {last.format("y40")}\n'
    )
    assert "tm_several " in generated(spec, spec.rules).source
