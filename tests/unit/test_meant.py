"""What a test comes to: what is written in another way is the same, and whatever another case is made of is not.

The case as data is what the test is run with; where no parameter takes part, both have to tell the same tests apart.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.meaning import fingerprint_of_test
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import PreparedTest, prepare

SPEC = """module m

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s, a: m/s^2 }
signal ego : state { x: m, v: m/s, on: bool }
signal objects : set of object { x: m, length: m in [0, 30] default 5 }
param v_max : m/s = 12 m/s in [1, 20]
shape of_limits = { slow: m/s, far: m }
param limits : of_limits = { slow: 3 m/s in [0, 9], far: 100 m in [0, 900] }
table bite(v: m/s) -> m/s^2 = linear clamp
  | 0 m/s: 6 m/s^2 | 20 m/s: 5 m/s^2 |
define fast = 12 m/s
define quick = 12 m/s
define twice(v: m/s) -> m/s = 2 * v

rule keep "Not too fast, and not too near"
  for all p in plan
  for all o in objects
  require p.v <= v_max and p.x + limits.far <= o.x and p.a <= bite(ego.v)

test keep "one"
"""
GIVEN = "given plan = line(v: 12 m/s)\n given objects = [{ x: 1 km, length: 5 m }, { x: 2 km }]\n given ego = { x: 0 m, v: 3 m/s, on: true }\n"
EXPECT = "expect satisfied, margin about 0 m/s within 1 mm/s, at p = 3\n"


def prepared(body: str, folder: Path) -> PreparedTest:
    folder.mkdir()
    path = folder / "m.spec"
    path.write_text(SPEC + " " + body.replace("\n", "\n "), "utf-8")
    compiled = compile_paths([path], folder)
    tests, found = prepare(compiled)
    assert [str(item.message) for item in (*compiled.found, *found) if item.level == "error"] == []
    (test,) = tests
    return test


def edited(*pairs: tuple[str, str]) -> str:
    text = GIVEN + EXPECT
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    ("pairs", "same"),
    [
        ([("12 m/s", "43.2 km/h"), ("1 mm/s", "0.001 m/s")], True),
        ([("12 m/s", "fast")], True),
        ([("12 m/s", "twice(6 m/s)")], True),
        ([("12 m/s", "4 * 3 m/s")], True),
        ([("x: 1 km, length: 5 m", "length: 5 m, x: 1000 m")], True),
        ([("at p = 3", "at p = 3.0")], True),
        ([("given plan = line(v: 12 m/s)\n", ""), ("on: true }\n", "on: true }\n given plan = line(v: 12 m/s)\n")], True),
        ([("12 m/s", "12 km/h")], False),
        ([("12 m/s", "twice(fast)")], False),
        ([("x: 1 km, length: 5 m", "x: 5 m, length: 30 m")], False),
        ([("{ x: 1 km, length: 5 m }, { x: 2 km }", "{ x: 2 km }, { x: 1 km, length: 5 m }")], False),
        ([("line(v: 12 m/s)", "line(v: 12 m/s) with v[2] = 13 m/s")], False),
        ([("line(v: 12 m/s)", "line(v: 12 m/s) with v[2] = nan")], False),
        ([("on: true", "on: false")], False),
        ([("given ego", "given v_max = 13 m/s\n given ego")], False),
        ([("given ego", "given limits = { slow: 2 m/s }\n given ego")], False),
        ([("given ego", "given bite = [[0 m/s, 6 m/s^2], [20 m/s, 4 m/s^2]]\n given ego")], False),
        ([("at p = 3", "at p = 2")], False),
        ([(", at p = 3", "")], False),
        ([("satisfied", "violated")], False),
        ([("about 0 m/s", "about 1 mm/s")], False),
        ([("within 1 mm/s", "within 2 mm/s")], False),
        ([("about 0 m/s within 1 mm/s", "about 0 m within 1 mm")], False),
    ],
)  # fmt: skip
def test_what_is_the_same_case_is_the_same(pairs: list[tuple[str, str]], same: bool, tmp_path: Path) -> None:
    one, other = prepared(edited(), tmp_path / "one"), prepared(edited(*pairs), tmp_path / "other")
    assert (one.told.meant == other.told.meant) is same
    assert (fingerprint_of_test(one) == fingerprint_of_test(other)) is same


def test_a_parameter_stands_by_its_name(tmp_path: Path) -> None:
    """Another value of it is no other test, and the number that it has is one."""
    named = prepared(edited(("12 m/s", "v_max")), tmp_path / "named")
    assert named.told.reads == {"m.v_max"}
    assert named.told.meant != prepared(edited(), tmp_path / "number").told.meant
    half = prepared(edited(("12 m/s", "v_max / 2 + limits.slow")), tmp_path / "half")
    assert half.told.reads == {"m.v_max", "m.limits.slow"}
    assert half.told.meant not in (
        named.told.meant,
        prepared(edited(("12 m/s", "v_max / 3 + limits.slow")), tmp_path / "third").told.meant,
    )
