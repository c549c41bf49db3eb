"""The public Python API: its names, specs that are texts, and batches of arrays, held against cases one by one."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.diagnostics.base import Diagnostics

SPEC = """
module batch

use prelude.frames

signal plan : trajectory {
  t: s increasing, x: m, y: m, v: km/h in [-10, 300], grip: 1 in [0, 1.5] default 1, ready: bool
}
signal ego : state { v: m/s in [-10, 150], age: s in [0, 10] default 0 s, on: bool }
signal objects : set of object { x: m, y: m, v: m/s in [-50, 50] }
signal track : corridor { left: polyline, right: polyline }
event flag
param v_max : km/h = 100 km/h in [0, 200]
constrain v_max <= 150 km/h

rule limit "limit"
  for all p in plan
  require p.v <= v_max

rule gripped "where there is grip"
  for all p in plan where p.grip >= 0.5
  require sqrt(p.v - 1 km/h * 20) <= 9 (m/s)^0.5

rule flagged "under the flag"
  whenever flag
  for all p in plan
  require p.v <= 60 km/h and p.ready

rule apart "away from all"
  for all p in plan, o in objects
  require hypot(p.x - o.x, p.y - o.y) >= 2 m

rule steady "from sample to sample"
  for all (p, q) in consecutive(plan)
  require abs(q.v - p.v) <= 30 km/h

rule soon "slow again within half a second"
  along plan
  require always[0 s, 0.5 s] (plan.v <= 110 km/h)

rule near "somewhere near"
  exists p in plan
  require abs(p.v - ego.v) <= 5 m/s

rule awake "on"
  require ego.on and ego.v >= 0 m/s
"""


def test_text():
    tm.loads(SPEC)
