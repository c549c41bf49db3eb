"""Specs for the tests of readings: one with everything that the shipped rules and the examples of the pages do not have."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading.rule import read
from trackmarshal.reading.terminal import text
from trackmarshal.semantics.compile import compile_paths

ROOT = Path(__file__).resolve().parents[2]
HEAD = """module made
enum flag { green, yellow, red }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s, a: m/s^2, hot: bool }
signal ego : state { x: m, y: m, heading: rad, v: m/s, flag: flag, wet: bool }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m }
signal lanes : set of lane { left: polyline, right: polyline }
signal track : corridor { left: polyline, right: polyline }
signal border : polyline
event blue_flag "shown"
param top : m/s = 180 km/h  in [0, 200]
param s : s = 2 s
param kappa : 1/m = 0.01 1/m
zone pit = polygon (0 m, 0 m) (10 m, 0 m) (10 m, 5 m)
line start = (0 m, 0 m) (0 m, 10 m)
table ax_max(v: m/s) -> m/s^2 = linear clamp
  | 0 m/s: 6 m/s^2 | 50 m/s: 2 m/s^2 |
define ahead(p: moving, o: moving) -> m = (o.x - p.x) + 0 m
predicate behind(o: moving, p: moving) = ahead(o, p) > 0 m
"""
#: One rule for each kind of node that only some rules have, by name.
RULES = """
rule whole "everything"
  whenever blue_flag
  along plan as p
  for all o in objects where o.v >= 1 m/s
    except o behind p "it looks out for itself"
  let fast = p.v^2 / 2
  require always[0 s, 1 s] (p.v > top implies rising(p.hot) or 0 m <= ahead(p, o) < 5 m)
      and p.a in [-8 m/s^2, ax_max(p.v)] and fast < 100 m^2/s^2 and clear_of(swept_footprint(p, 5 m, 2 m), footprint(o))

rule named "names for things that are neither numbers nor formulas"
  let waved = ego.flag
  let here = footprint(ego, 5 m, 2 m)
  let slow = ego.v < 10 m/s
  let room = track
  let box = pit
  for all o in objects
  require (waved is red implies slow) and here clear_of footprint(o) and (waved is yellow or here inside room or here inside box)
      and swept(ego, o, 5 m, 2 m) inside track

rule sides "of lanes, of a track, of lines"
  for all l in lanes
  let edge = track.left
  require distance_to(ego, l.left) + distance_to(ego, edge) >= 1 m and distance_to(ego, start) > 0 m and offset(ego, border) < 5 m
      and station(ego, path(plan)) >= 0 m and direction(ego, centre(track)) <= pi and not (ego in zone pit)

rule cases "by the member of an enumeration"
  require ego.v <= (case ego.flag { green: top, yellow: 20 m/s, else: 10 m/s }) and (case ego.flag { green, yellow: true, red: ego.wet })

rule timed "operators along a timeline"
  along plan as p
  require (p.v < 10 m/s until[0 s, 2 s] p.a < 0 m/s^2) xor (next (p.hot) iff weak previous (falling(p.hot)))
      and (p.v >= 0 m/s since p.hot) and not (eventually p.v > 50 m/s)

rule functions "of numbers"
  for all p in plan
  require min(p.v, top, 3 m/s) - max(p.v, -top) <= hypot(p.v, sign(p.a) * top) * pow(abs(p.kappa / kappa), 1.5) + floor(p.v / top) * top
      and exp(p.v / top) > log(2) + tanh(1) - ceil(0.5) * round(1.5)^-2 and atan2(p.x - ego.x, p.y) < sin(1) + sqrt(2) * (1 - (2 - 3))
"""


def spec_of(folder: Path, written: str, head: str = HEAD) -> Spec:
    """A spec without errors."""
    path = folder / "made.spec"
    path.write_text(head + written, "utf-8")
    made = compile_paths([path], folder)
    assert [(found.code, str(found.span), vars(found)) for found in made.errors] == []
    return made.spec


def rule_of(folder: Path, written: str, head: str = HEAD) -> tuple[RuleInfo, Spec]:
    """The last rule of a spec."""
    spec = spec_of(folder, written, head)
    return spec.rules[-1], spec


def demanded(folder: Path, condition: str, before: str = "") -> str:
    """A condition as it is shown on one line."""
    rule, spec = rule_of(folder, f'rule r "r"\n{before}  require {condition}\n')
    return text(read(rule, spec).clauses[-1].formula)


def examples() -> Iterator[str]:
    """The specs of all pages."""
    for page in sorted((ROOT / "docs").glob("*.md")):
        yield from re.findall(r"```spec\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
