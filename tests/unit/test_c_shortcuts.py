"""What generated C leaves out: sweeps of a timeline that cannot be the least, distances of which the sign counts, loops over one set,
what is asked of elements that are not in range."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import load

HEAD = """module short

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s }
signal boxes : set of object { x: m, y: m, length: m }
signal track : corridor { left: polyline, right: polyline }

param length : m = 4.7 m in [0.1, 1000]
zone z = polygon (0 m, 0 m) (30 m, 0 m) (30 m, 30 m)

"""
ONE, SINGLE = "tm_timeline_inside(", "tm_curved_inside("


def known(folder: Path, *rules: str) -> str:
    """The C that takes everything for known, of rules given by their clauses."""
    path = folder / "short.spec"
    texts = [f'rule r{i} "made up"\n{rule}\n' for i, rule in enumerate(rules)]
    path.write_text(HEAD + "\n".join(texts), encoding="utf-8")
    spec = load(path)
    source = generate(spec, spec.rules).source
    return "\n".join(
        re.findall(
            r"static (?:bool tm_rule_\w+_known|void tm_rules_\w+)\(.*?^\}", source, re.DOTALL | re.MULTILINE
        )
    )


@pytest.mark.parametrize(
    ("rule", "call"),
    [
        ("  for all p in plan\n  require swept_footprint(p, length, 2 m) inside track", ONE),
        ("  for all b in boxes\n  for all p in plan\n  require swept_footprint(p, b.length, 2 m) inside z", ONE),
        # Not of all samples, not the least, or not of one vehicle: one sweep after the other.
        ("  for all p in plan where p.v > 1 m/s\n  require swept_footprint(p, length, 2 m) inside track", SINGLE),
        ("  require exists p in plan: (swept_footprint(p, length, 2 m) inside track)", SINGLE),
        ("  for all p in plan\n  require swept_footprint(p, abs(p.x), 2 m) inside track", SINGLE),
        ("  for all p in plan\n  require swept_footprint(p, length, 2 m) inside track and p.v > 1 m/s", SINGLE),
    ],
)  # fmt: skip
def test_all_sweeps_of_a_timeline_at_once(tmp_path: Path, rule: str, call: str) -> None:
    text = known(tmp_path, rule)
    assert call in text
    assert {ONE: SINGLE, SINGLE: ONE}[call] not in text


def test_straight_sweeps_of_a_timeline_at_once(tmp_path: Path) -> None:
    text = known(tmp_path, "  for all p in plan\n  require swept_hull(p, length, 2 m) inside track")
    assert re.search(r"tm_timeline_inside\([^;]*heading, NULL, ", text)
    assert "tm_swept_inside(" in known(
        tmp_path, "  for all p in plan where p.v > 1 m/s\n  require swept_hull(p, length, 2 m) inside track"
    )


def test_sign_where_the_sign_counts(tmp_path: Path) -> None:
    assert "tm_in_area_sign(" in known(
        tmp_path, "  for all p in plan where p in zone z\n  require p.v < 9 m/s"
    )
    # Its margin is the rule's.
    assert "tm_in_area_sign(" not in known(tmp_path, "  for all p in plan\n  require p in zone z")


def test_rules_over_one_set_share_a_loop(tmp_path: Path) -> None:
    text = known(
        tmp_path,
        "  for all b in boxes\n  require offset(b, track) > 1 m",
        "  for all b in boxes where offset(b, track) < 3 m\n  require station(b, track) > 1 m",
    )
    assert "tm_rules_boxes_0" in text
    group = text[text.index("tm_rules_boxes_0") :]
    assert group.count("tm_line_project(") == 1
    # A path is projected on sample by sample: a loop of its own.
    assert "tm_rules_" not in known(tmp_path, *["  for all b in boxes\n  require offset(b, plan) > 1 m"] * 2)


IN_RANGE = "  for all p in plan where p.v > 1 m/s\n  require p.x / p.v < {} s"


def test_what_is_asked_of_elements_in_range_is_computed_for_them_alone(tmp_path: Path) -> None:
    text = known(tmp_path, IN_RANGE.format(9))
    (asked,) = re.findall(r"if \(tm_may_hold\(guard\)\) \{(.*?)\n    \}", text, re.DOTALL)
    assert asked.count(" / ") == text.count(" / ") == 1
    assert asked.count("tm_for_all_where(") == text.count("tm_for_all_where(") == 1
    # Nothing is computed: no branch.
    assert "tm_may_hold(" not in known(tmp_path, "  for all p in plan where p.v > 1 m/s\n  require p.x < 9 m")


def test_a_part_that_takes_long_is_asked_where_what_stands_before_it_may_hold(tmp_path: Path) -> None:
    guard = "p.v > 1 m/s and p.x > 0 m and sqrt(p.x * 1 m) < 9 m and offset(p, track) < 1 m"
    text = known(tmp_path, f"  for all p in plan where {guard}\n  require p.y < 9 m")
    first, root, second, projection = (text.index(each) for each in ("if (tm_may_hold(guard))", "sqrt(", "if (tm_may_hold(guard_2))", "tm_line_project("))  # fmt: skip
    assert first < root < second < projection
    # The other way round, there is nothing to wait for.
    turned = " and ".join(reversed(guard.split(" and ")))
    assert (
        known(tmp_path, f"  for all p in plan where {turned}\n  require p.y < 9 m").count("if (tm_may_hold(")
        == 1
    )


def test_rules_that_ask_something_of_the_same_elements_share_a_branch(tmp_path: Path) -> None:
    other = "  for all p in plan where p.v > 1 m/s\n  require p.y / p.v < 8 s"
    text = known(tmp_path, IN_RANGE.format(9), other)
    assert text.count("tm_may_hold(") == 1
    assert text.count(" / ") == 2
    # What somebody else reads, too, stands before it.
    shared = known(tmp_path, IN_RANGE.format(9), "  for all p in plan\n  require p.x / p.v < 90 s")
    assert shared.count(" / ") == 1
    assert "tm_may_hold(" not in shared or shared.index(" / ") < shared.index("tm_may_hold(")


def test_what_goes_with_a_memory_is_computed_in_every_cycle(tmp_path: Path) -> None:
    """A memory that some cycles leave out would take them for gaps."""
    path = tmp_path / "short.spec"
    rule = "  for all b in boxes where b.length > 1 m\n  require {}abs(b.x / b.length) < 9{}"
    sources = []
    for before, after in (("", ""), ("once(", ")")):
        path.write_text(f'{HEAD}rule r "made up"\n{rule.format(before, after)}\n', encoding="utf-8")
        spec = load(path)
        sources.append(generate(spec, spec.rules).source)
    plain, remembered = sources
    assert "if (tm_may_hold_any(" in plain
    assert "_now(context" in remembered
    assert "if (tm_may_hold_any(" not in remembered


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("p.v <= 3 m/s", True),
        ("p.v >= 3 m/s and (p.x <= 1 m or p.y >= 1 m)", True),
        ("swept_footprint(p, abs(p.x), 2 m) inside track", True),
        # Those do not hold where their margin is 0.
        ("p.v < 3 m/s", False),
        ("p.v <= 3 m/s and p.x > 1 m", False),
        ("not (p.v <= 3 m/s)", False),
    ],
)
def test_whether_a_rule_holds_is_told_by_its_margin_where_that_tells(
    tmp_path: Path, body: str, told: bool
) -> None:
    text = known(tmp_path, f"  for all p in plan\n  require {body}")
    assert ("tm_conclude_margin(" in text) == told
