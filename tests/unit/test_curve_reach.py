"""How far the shortcuts of generated C take a curve to reach: never less than the margin of the curve asks for, and hardly more; and how far away they take a box to be."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from support.shared import SUPERVISOR
from trackmarshal.backends.c.build import EXACT, compiler
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import load

SOURCE = Path(__file__).with_name("curve_reach.c")


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_no_margin_of_a_curve_is_below_what_its_straight_hull_leaves(tmp_path: Path) -> None:
    spec = load([SUPERVISOR])
    made = generate(
        spec, [rule for rule in spec.rules if rule.name in ("static_collision", "obstacle_collision")]
    )
    (tmp_path / "supervisor.h").write_text(made.header, encoding="utf-8")
    (tmp_path / "supervisor.c").write_text(made.source, encoding="utf-8")
    command = compiler()
    assert command is not None
    target = tmp_path / "reach"
    subprocess.run([*command, *EXACT, "-O2", "-w", f"-I{tmp_path}", "-o", target, SOURCE, "-lm"], check=True)
    said = subprocess.run([target, "100000"], check=True, capture_output=True, text=True).stdout.split()
    asked, below, most = int(said[0]), int(said[1]), float(said[2])
    assert asked > 300_000
    assert below == 0
    assert 0.99 < most <= 1.0
    told, nearer = map(int, said[3:])
    assert told > 5_000
    assert nearer == 0
