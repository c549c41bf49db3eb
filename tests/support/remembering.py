"""The shipped Supervisor with rules that remember beside its own."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import trackmarshal as tm
from support.shared import REPOSITORY
from trackmarshal.ir.spec import Spec

RULES = """module supervisor.remembering
use supervisor.interface

rule was_driven "" require historically[0.02 s, 0.3 s] plan.first.v > 1 m/s
rule turned "" require not once[0 s, 0.2 s] rising(plan.last.kappa > 0.1 1/m)
rule came "" for all o in objects except not previous o.x > ego.x "" require o.x > ego.x - 5 m
rule nearby "" for all o in objects require count(o.x - ego.x < 60 m, last: 0.3 s) <= 4
rule someone "" require once[0 s, 1 s] (exists o in objects: o.v > 10 m/s)
rule went_on "" require ego.v > 5 m/s since[0 s, 2 s] plan.first.t < 0.05 s
rule all_of "" require historically[0 s, 0.25 s] (for all p in plan: p.a <= 20 m/s^2)
rule anew "" require count(ego.y > 1 m, reset: rising(ego.y < 0.8 m)) <= 3
rule soon "" whenever plan.first.v > 20 m/s within 0.15 s require plan.first.v < 24 m/s
rule keeps "" for all o in objects require always[0 s, 0.2 s] (o.x > ego.x - 5 m or previous o.x > ego.x)
rule follows "" require once (next ego.v > 5 m/s)

event driven ""
rule driven_on "" severity advisory require count(driven, last: 1 s) <= 8

course lived = ego for 0.4 s then plan
rule slows "" along lived as c require historically[0 s, 0.3 s] c.v <= 24 m/s or eventually[0 s, 1 s] c.v <= 22 m/s
rule one_turn "" along lived as c require always count(rising(c.heading > 0.01 rad), last: 0.4 s) <= 1
rule goes_on "" along lived as c at last require c.v > 1 m/s since[0 s, 3 s] c.x > 5 m
rule steps "" along lived as c whenever previous c.v > 20 m/s require count(c.y > 1 m, reset: rising(c.y < 0.8 m)) <= 3
"""
#: Of pairs: of objects, and of objects and obstacles, which may be absent for a while.
PAIRS = """
rule fell_back "" for all a in objects for all b in objects where a.x < b.x require not once[0 s, 0.3 s] a.x > b.x - 45 m
rule met "" for all o in objects for all c in obstacles except rising(o.x > c.x) "" require count(o.x > c.x, last: 0.3 s) <= 2
rule since_then "" for all a in obstacles for all b in obstacles require a.x <= b.x + 25 m since[0 s, 0.5 s] b.y > 0 m
rule apart "" for all c in obstacles for all o in objects require always[0 s, 0.2 s] (c.x > o.x - 100 m or previous c.y > o.y)
"""
LASTING = "capacity 8 forget 0.25 s"
NAMES = tuple(line.split()[1] for line in RULES.splitlines() if line.startswith("rule"))
NAMES_OF_PAIRS = tuple(line.split()[1] for line in PAIRS.splitlines() if line.startswith("rule"))


def sources(folder: Path, pairs: bool = False) -> Path:
    """The folder of its specs, written below one that is empty. pairs: with rules of pairs of elements beside the others."""
    left_out = shutil.ignore_patterns("*.jsonl*", "*.json")
    own: Path = shutil.copytree(REPOSITORY / "specs", folder / "specs", ignore=left_out) / "supervisor"
    (own / "remembering.spec").write_text(RULES + PAIRS * pairs, encoding="utf-8")
    if pairs:
        given = (own / "interface.spec").read_text(encoding="utf-8")
        lasting, found = re.subn(r"(signal obstacles : set of object \{[^}]*\})", rf"\1 {LASTING}", given)
        assert found == 1
        (own / "interface.spec").write_text(lasting, encoding="utf-8")
    return own


def remembering(folder: Path, pairs: bool = False) -> Spec:
    """It, compiled."""
    # Places in files are relative, as those of a project: the same rules elsewhere are the same program, compiled once.
    return tm.load([sources(folder, pairs)], [], folder)
