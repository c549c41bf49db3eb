"""Who is who in a set, in generated C, where ids stay what they are: Python numbers elements anew that were gone, other callers do not."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from trackmarshal.backends.c.build import EXACT, compiler
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import loads

SOURCE = Path(__file__).with_name("known_again.c")
SPEC = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad }
signal objects : set of object { x: m }
rule f "made up"
  for all o in objects
  require weak previous o.x < 5 m
"""


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_each_element_is_known_again_in_the_next_cycle_and_no_later(tmp_path: Path) -> None:
    spec = loads(SPEC)
    made = generate(spec, spec.rules, doored=True)
    (tmp_path / "supervisor.h").write_text(made.header, encoding="utf-8")
    (tmp_path / "supervisor.c").write_text(made.source, encoding="utf-8")
    command = compiler()
    assert command is not None
    target = tmp_path / "known_again"
    flags = [*EXACT, "-w", "-DTM_MAX_ELEMENTS=5u", f"-I{tmp_path}"]
    subprocess.run([*command, *flags, "-o", target, SOURCE, "-lm"], check=True)
    said = subprocess.run([target, "20000"], check=True, capture_output=True, text=True).stdout.split()
    cycles, twice, missed, mistaken = map(int, said)
    assert 1000 < twice < cycles - 1000
    assert (missed, mistaken) == (0, 0)
