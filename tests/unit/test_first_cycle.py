"""Inline tests of rules over the run."""

from __future__ import annotations

from pathlib import Path

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
