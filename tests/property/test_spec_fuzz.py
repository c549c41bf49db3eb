"""Spec files with anything done to them: read, refused or reported, and never a crash."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from trackmarshal.cli.check import examine
from trackmarshal.diagnostics import text
from trackmarshal.semantics.compile import compile_paths

#: One of everything.
SPEC = """module everything
use prelude.frames
reference paper = "A paper"
signal plan : trajectory {
  t: s increasing, s: m, x: m, y: m, heading: rad, kappa: 1/m in [-1, 1], v: m/s in [-1, 100], a: m/s^2,
  grip: 1 in [0, 1.5] default 1, ready: bool
}
signal ego : state { x: m, y: m, heading: rad, v: m/s, age: s in [0, 10] default 0 s }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m }
signal track : corridor { left: polyline, right: polyline }
event flag "a flag"
param mass : kg = 1160 kg in [900, 1400] source "a test"
param v_max : m/s = 300 km/h
param half : m/s = v_max / 2
constrain half <= v_max because "it is half"
table ax_max(v: m/s) -> m/s^2 = linear clamp | 0 m/s: 6 m/s^2 | 72 m/s: 2.5 m/s^2 |
zone pit "the pit" = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m)
line start = (0 m, 0 m) (0 m, 9 m)
define stop(v: m/s, a: m/s^2) -> m = v^2 / (2 * a)
predicate slower(a: moving, b: moving) = a.v < b.v
assume A-FRESH "fresh"
  owner "somebody"
  evidence "proof.pdf"
  monitor ego.age <= 100 ms
rule speed "a limit"
  satisfies S-1
  source paper eq 1
  assuming A-FRESH
  severity minor
  for all p in plan where p in zone pit and p.ready
  require p.v <= v_max and abs(p.a) <= ax_max(p.v)
rule gap "a gap"
  because "it is safe"
  whenever flag
  for all o in objects where o slower ego
  except o.v < 0 m/s "it comes"
  let needed = if ego.v > 1 m/s then stop(ego.v, 8 m/s^2) else 0 m
  require distance(o, ego) > needed or exists q in plan: (distance_to(q, start) < 1 m)
rule response "in time"
  along plan as p
  require always (p.a < -8 m/s^2 implies eventually[0 s, 0.5 s] p.v < 60 m/s) and not rising(p.v > 3 m/s)
rule room "inside"
  for all consecutive p, q in plan
  require swept(p, q, 4 m, 2 m) inside track and swept_footprint(p, 4 m, 2 m) clear_of footprint(ego, 4 m, 2 m)
rulebook order "an order" gap > speed ~ response, room > response
test speed "slow"
  given plan = line(v: 20 m/s, points: 5) with v[3] = nan, ready = true
  given mass = 1000 kg
  expect undefined, at p = 3
test gap "alone"
  given ego = { x: 0 m, y: 0 m, heading: 0, v: 20 m/s }
  given objects = []
  given flag = true
  expect inactive, margin inf
"""
TOKENS = re.findall(r'"[^"\n]*"|--[^\n]*|[A-Za-z_][\w-]*|[0-9][0-9.]*|\s+|<=|>=|->|.', SPEC)
#: What tokens are replaced by, beside each other.
SPARE = [
    "", "nan", "inf", "1e999", "1e-999", "0", "-", "m/s", "kg", "for all", "not", "(", ")", "[", "]", "{", "}", ",", ":",
    "nothing", "plan", "ego", "objects", "track", "always", "until", "\n", "\nrule", "\nparam x : m = x", "\t", "é", "≤", "x",
    "state s starts a becomes b when flag", '"', "--", "stop", "in zone", "p.v", "^", "^9", "3 m", "true", "zone", "within 5 s",
]  # fmt: skip


def checked(folder: Path, content: str) -> str:
    path = folder / "everything.spec"
    path.write_text(content, "utf-8")
    return text.render(examine(compile_paths([path], folder), None))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def test_nothing_is_wrong_with_the_spec_itself(folder: Path) -> None:
    assert checked(folder, SPEC) == ""


edits = st.lists(
    st.tuples(st.integers(0, len(TOKENS) - 1), st.sampled_from(SPARE) | st.sampled_from(TOKENS)),
    min_size=1,
    max_size=4,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(edits)
def test_tokens_replaced_by_others(folder: Path, edits: list[tuple[int, str]]) -> None:
    tokens = list(TOKENS)
    for index, replacement in edits:
        tokens[index] = replacement
    checked(folder, "".join(tokens))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.integers(0, len(SPEC)), st.integers(0, 40), st.text(max_size=3))
def test_characters_cut_out_and_put_in(folder: Path, start: int, length: int, replacement: str) -> None:
    try:
        replacement.encode()
    except UnicodeEncodeError:
        replacement = ""
    checked(folder, SPEC[:start] + replacement + SPEC[start + length :])


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.integers(0, SPEC.count("\n")), min_size=1, max_size=5))
def test_lines_left_out(folder: Path, gone: list[int]) -> None:
    checked(folder, "\n".join(line for i, line in enumerate(SPEC.split("\n")) if i not in gone))
