"""Inline tests of rules over the run: their first cycle, and those after it."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests


def test_an_inline_test_is_the_first_cycle_of_a_run(tmp_path: Path) -> None:
    """It needs no stamp, and its objects no ids."""
    path = tmp_path / "brief.spec"
    path.write_text(
        """module brief
signal objects : set of object { x: m }
rule near "Not near for two cycles"
  for all   o in objects
  require   o.x > 1 m or previous o.x > 1 m
test near "far"
  given  objects = [{ x: 2 m }, { x: 1 m }]
  expect violated, margin 0 m
test near "far enough"
  given  objects = [{ x: 2 m }]
  expect satisfied, margin 1 m
""",
        "utf-8",
    )
    compiled = compile_paths([path])
    tests, found = prepare(compiled)
    assert (compiled.found, found) == ((), [])
    assert [(o.outcome, o.message) for o in run_tests(compiled.spec, tests)] == [("passed", "")] * 2


LATER = """module later
signal ego : state { v: m/s }
signal objects : set of object { x: m }
event yellow "a yellow flag is shown"
rule lasts "A flag counts for five seconds"
  whenever  once[0 s, 5 s] yellow
  require   ego.v <= 30 m/s
rule soon "Slow within two seconds"
  whenever  rising(yellow)
  within    2 s
  require   ego.v <= 30 m/s
rule apart "Whoever is there when the flag is shown is 9 m away within two seconds"
  whenever  rising(yellow)
  within    2 s
  for all   o in objects
  require   o.x >= 9 m
rule all_apart "At one time within two seconds, everybody is"
  whenever  rising(yellow)
  within    2 s
  require   for all o in objects: o.x >= 9 m
rule far "Never nearer than 3 m"
  for all   o in objects
  require   historically o.x >= 3 m
"""
BEGIN = "  given  yellow = true\n  given  ego = { v: 20 m/s }\n"
NOBODY = "  given  yellow = true\n  given  objects = []\n"
ONE_AND_THE_OTHER = (
    "  given  yellow = true\n  given  objects = [{ x: 5 m }, { x: 5 m }]\n  after  0.5 s\n  given  yellow = false\n"
    "  given  objects = [{ x: 9 m }, { x: 5 m }]\n  after  0.5 s\n  given  objects = [{ x: 5 m }, { x: 9 m }]\n"
    "  after  0.5 s\n  given  objects = [{ x: 5 m }, { x: 5 m }]\n"
)
FAST = "  given  yellow = false\n  given  ego = { v: 31 m/s }\n"


@pytest.mark.parametrize(
    ("rule", "steps", "expected"),
    [
        ("lasts", f"{BEGIN}  after  5 s\n{FAST}", "violated, margin -1 m/s"),
        ("lasts", f"{BEGIN}  after  5.001 s\n{FAST}", "inactive"),
        ("lasts", f"{BEGIN}  after  2.5 s\n  after  2.5 s\n{FAST}", "violated, margin -1 m/s"),
        ("lasts", f"{BEGIN}  after  1 s\n{FAST}  after  1 s\n  given  ego = {{ v: 29 m/s }}\n", "satisfied, margin 1 m/s"),
        ("soon", f"{BEGIN.replace('20', '40')}", "open"),
        ("soon", f"{BEGIN.replace('20', '40')}  after  1 s\n  after  1.001 s\n", "violated, margin -10 m/s"),
        ("soon", f"{BEGIN.replace('20', '40')}  after  1 s\n  given  ego = {{ v: 20 m/s }}\n", "satisfied, margin 10 m/s"),
        # A deadline under quantifiers is one for each who is there at first, by itself; one of a formula is for all of it.
        ("apart", f"{ONE_AND_THE_OTHER}  after  1 s\n", "inactive"),
        ("all_apart", f"{ONE_AND_THE_OTHER}  after  1 s\n", "violated, margin -4 m"),
        ("apart", f"{NOBODY}  after  2 s\n", "inactive"),
        ("all_apart", f"{NOBODY}", "satisfied"),
        ("far", "  given  objects = [{ x: 2 m }]\n  after  1 s\n  given  objects = [{ x: 5 m }]\n", "violated, margin -1 m"),
        ("far", "  given  objects = [{ x: 2 m }]\n  after  1 s\n  given  objects = []\n  after  1 s\n  given  objects = [{ x: 5 m }]\n",
         "satisfied, margin 2 m"),
    ],
)  # fmt: skip
def test_cycles_after_the_first_one(tmp_path: Path, rule: str, steps: str, expected: str) -> None:
    path = tmp_path / "later.spec"
    for said, outcome in ((expected, "passed"), ("undefined", "failed")):
        path.write_text(f'{LATER}test {rule} "x"\n{steps}  expect {said}\n', "utf-8")
        compiled = compile_paths([path])
        tests, found = prepare(compiled)
        assert (compiled.found, found) == ((), [])
        assert [one.outcome for one in run_tests(compiled.spec, tests)] == [outcome], (said, *tests)
