"""The numbers of a run's page are those of the rules, computed another way: by hand, by the reference, from the recording."""

from __future__ import annotations

import json
import math
import re
import statistics
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from support.report_runs import SPEC, cycle, evaluator, other, overtaking, recording
from trackmarshal.backends.over_run.history import History
from trackmarshal.backends.over_run.keeping import past
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.backends.results import outcome, rule_result
from trackmarshal.explaining.moments import MOST, MOST_REMEMBERED, chosen, told_moments
from trackmarshal.explaining.telling import told, told_over_run
from trackmarshal.runtime.verdict import RuleResult
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import replay
from trackmarshal.scenarios.run_record import run_record
from trackmarshal.scenarios.supervised import frame_at, run_until
from trackmarshal.trace.report.pages import write_report
from trackmarshal.trace.report.reading import Run, read_run
from trackmarshal.trace.report.run_view import run_context
from trackmarshal.trace.report.scores import score_rows, scores, size_of
from trackmarshal.trace.report.settings import setting_rows
from trackmarshal.trace.report.svg import score, timeline
from trackmarshal.trace.report.tables import fault_rows, margin_rows, ranges, truth_rows

TRUTH = (True,) * 8 + (None,) * 4 + (False,) * 20 + (None,) * 8


def record(folder: Path, run: Recording, text: str = SPEC) -> dict[str, Any]:
    rules = evaluator(folder, text)
    found = replay(run, rules, keep=True)
    whole = {**run_record(found, rules), "told": told_moments(found, rules)}
    made: dict[str, Any] = json.loads(json.dumps(whole, allow_nan=False))
    return made


def read(folder: Path, run: Recording, text: str = SPEC) -> Run:
    return read_run(record(folder, run, text))


def moments(made: dict[str, Any]) -> Iterator[tuple[str, str, int, list[str]]]:
    for entry in made["told"]:
        for number, lines in entry["cycles"].items():
            yield entry["rule"], entry["candidate"], int(number), lines


def test_what_is_told_is_what_the_reference_says_of_that_cycle(tmp_path: Path) -> None:
    """The page's run is evaluated by numpy, all cycles at once, and what decided is not looked for again."""
    # The candidates differ in their last sample, which `end` reads of both.
    text = SPEC + '\nrule end "Not too fast at the end"\n  require plan.last.v <= 50 m/s\n'
    run = overtaking()
    made = record(tmp_path, run, text)
    rules = evaluator(tmp_path, text)
    seen = 0
    for name, candidate, number, lines in moments(made):
        rule = next(rule for rule in rules.rules if rule.name == name)
        case = frame_at(run, rules, {}, number).of(candidate)
        values = Reference(rules.spec, case)
        result = rule_result(rule, case, values, outcome(rule, case, values)[:2])
        assert lines == told(rule, result, values)[3:]
        seen += 1
    assert seen > 40


def test_moments_of_a_run_are_told_as_each_by_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is found out of the cycles before one moment is not looked for again before the next."""
    text = SPEC + (
        "\nstate side : { ahead, level, behind } for each o in objects starts level\n"
        "  becomes ahead from level when o.x - ego.x > 12 m\n    remember gap = o.x - ego.x\n"
        "  becomes level from ahead, behind when abs(o.x - ego.x) <= 12 m\n"
        "  becomes behind from level when o.x - ego.x < -12 m\n    remember gap = o.x - ego.x\n"
        '\nrule beside "Not long beside another"\n  for all o in objects\n'
        "  require not (side(o) is level and time_in(side(o)) > 0.3 s)\n"
        '\nrule kept "As far as it was"\n  for all o in objects where not (side(o) is level)\n'
        "  require abs(o.x - ego.x - side(o).gap) <= 3 m\n"
        '\nrule soon "It is far away soon"\n  for all o in objects\n'
        "  require eventually[0 s, 0.5 s] abs(o.x - ego.x) > 12 m\n"
    )
    made = record(tmp_path, overtaking(), text)["told"]
    monkeypatch.setattr("trackmarshal.explaining.moments.History", lambda cycles, **_: History(cycles))
    assert record(tmp_path, overtaking(), text)["told"] == made
    several = {entry["rule"] for entry in made if len(entry["cycles"]) > 1}
    assert several >= {"beside", "kept", "soon"}


def test_a_moment_after_cycles_that_are_missing_is_told_as_explain_tells_it(tmp_path: Path) -> None:
    """Of a run's record, cycles lack that were lost on the way: the verdict is undefined there, and is not told by the cycle before them."""
    rule = '\nrule drove "It has been driving"\n  require weak previous ego.v > 0 m/s\n'
    whole = overtaking()
    there = [replace(each, missing=2 if number == 8 else 0) for number, each in enumerate(whole.cycles)]
    run = replace(whole, cycles=tuple(there))
    rules = evaluator(tmp_path, SPEC + rule)
    made = record(tmp_path, run, SPEC + rule)
    judged, before, missing = run_until(run, rules, {}, 8)
    place = [each.name for each in rules.rules].index("drove")
    found = {who: lines for name, who, number, lines in moments(made) if (name, number) == ("drove", 8)}
    assert found.keys() == {"driving", "emergency"}
    for candidate, lines in found.items():
        this = past(rules.spec, judged.about.of(candidate), missing)
        result = judged.rated[candidate].explain(place, False)
        assert result.verdict == "undefined"
        assert lines == told_over_run(rules.rules[place], result, History([*before, this]))[3:]


def test_numbers_by_hand_with_units(tmp_path: Path) -> None:
    """`near` asks for more than 10 m between the other's x and ours, which the recording says."""
    run = overtaking()
    checked = 0
    for name, _, number, lines in moments(record(tmp_path, run)):
        if name != "near":
            continue
        at = run.cycles[number]
        gap = abs(float(at.objects[0]["x"]) - float(at.ego["x"]))
        said = dict(line.strip().split(" = ") for line in lines if " = " in line and line.startswith("    "))
        assert said["left side"] == f"{gap:.9g} m"
        assert said["right side"] == "10 m"
        assert said["ego.x"] == f"{float(at.ego['x']):.9g} m"
        assert lines[0].strip() == "decided at o = blue"
        checked += 1
    assert checked > 20


def test_definitions_and_lets_have_their_units(tmp_path: Path) -> None:
    text = (
        SPEC
        + '\ndefine drop(v: m/s, b: m/s^2) = v^2 / (2 * b)\n\nrule stop "Stops in time"\n  for all o in objects\n'
        + "  let room = o.x - ego.x\n  require room > drop(ego.v, 8 m/s^2)\n"
    )
    lines = next(
        lines for name, _, _, lines in moments(record(tmp_path, overtaking(), text)) if name == "stop"
    )
    said = dict(line.strip().split(" = ") for line in lines if line.startswith("    "))
    assert said["drop"] == f"{20.0**2 / 16:.9g} m"
    assert said["room"].endswith(" m")
    assert said["ego.v"] == "20 m/s"


def results(letters: str) -> list[RuleResult | None]:
    names = {"s": "satisfied", "v": "violated", "u": "undefined", "i": "inactive"}
    sizes = {"s": 5.0, "v": -1.0, "u": math.nan, "i": math.inf}
    return [
        None if letter == "-" else RuleResult("r", names[letter], sizes[letter] - 0.01 * i, "m")
        for i, letter in enumerate(letters)
    ]


@pytest.mark.parametrize(
    ("letters", "expected"),
    [
        ("ssssss", [5]),  # the least margin
        ("iiii", []),
        ("sssvvvss", [2, 3, 4, 5, 6]),
        ("iisuis", [2, 3, 5]),
        ("--vv", [2, 3]),
    ],
)
def test_which_cycles_are_told(letters: str, expected: list[int]) -> None:
    assert chosen(results(letters), False) == expected


def test_of_too_many_cycles_the_ends_of_stretches_come_first() -> None:
    long = "s" * 5 + "v" * 300 + "s" * 5
    found = chosen(results(long), False)
    assert len(found) == MOST
    assert {4, 5, 304, 305} <= set(found)
    assert max(b - a for a, b in zip(found, found[1:])) < 12  # the others are spread over the stretch
    assert len(chosen(results("sv" * 200), False)) == MOST
    assert chosen(results("sssvvvss"), True) == [3, 5]
    assert len(chosen(results("sv" * 50), True)) == MOST_REMEMBERED


def test_untold_unsafe_cycles_are_counted(tmp_path: Path) -> None:
    run = recording([cycle(0.1 * i, 2.0 * i, [other("blue", 2.0 * i + 1.0)]) for i in range(100)])
    (near,) = (
        e for e in record(tmp_path, run)["told"] if e["rule"] == "near" and e["candidate"] == "driving"
    )
    assert len(near["cycles"]) + near["untold"] == 100
    assert near["untold"] == 100 - MOST


# Scores ---------------------------------------------------------------------------------------------------------------


def test_scores_are_least_margins_by_the_median_of_each_rule(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking())
    run = read_run(made)
    sizes = {}
    for rule in made["rules"]:
        known = [
            m
            for lane in rule["candidates"].values()
            for m, letter in zip(lane["margin"], lane["verdict"])
            if letter in "sv" and m not in ("inf", "-inf", "nan", 0.0)
        ]
        sizes[rule["name"]] = statistics.median(map(abs, known)) if known else 1.0
    found = {one.requirement: one for one in scores(run, {})}
    assert list(found) == ["R-1", "R-2", "R-3", ""]
    for requirement, one in found.items():
        for candidate, lane in one.lanes.items():
            rules = [r for r in made["rules"] if (requirement or None) in (r["requirements"] or [None])]
            for i in range(run.cycles):
                each = [
                    float(r["candidates"][candidate]["margin"][i]) / sizes[r["name"]]
                    for r in rules
                    if r["candidates"][candidate]["verdict"][i] in "sv"
                ]
                if each:
                    assert lane.margin[i] == pytest.approx(min(each), rel=1e-12)
                    assert lane.margin[i] <= 0 if lane.verdict[i] == "v" else lane.margin[i] >= 0
                else:
                    assert math.isnan(lane.margin[i])


def test_the_specs_scale_is_used_where_there_is_one(tmp_path: Path) -> None:
    text = SPEC.replace("\nparam length", "\nscale m = 4 m\nparam length", 1)
    run = read(tmp_path, overtaking(), text)
    near, fast = (next(rule for rule in run.rules if rule.name == name) for name in ("near", "fast"))
    assert size_of(near).value == 4.0
    assert "spec" in size_of(near).source
    assert "median" in size_of(fast).source
    least = min(near.lanes["driving"].measured)
    assert min(
        next(s for s in scores(run, {}) if s.requirement == "R-2").lanes["driving"].margin
    ) == pytest.approx(least / 4.0)


def test_a_requirement_is_as_bad_as_its_worst_rule(tmp_path: Path) -> None:
    """R-2 has `near` and `fast`; what is undefined outweighs what holds, and what is violated both."""
    cycles = [
        cycle(0.0, 0.0, [other("a", 50.0)]),
        cycle(0.1, 2.0, [other("a", math.nan)]),
        cycle(0.2, 4.0, [other("a", 5.0)]),
    ]
    (found,) = (one for one in scores(read(tmp_path, recording(cycles)), {}) if one.requirement == "R-2")
    assert found.lanes["driving"].verdict == "suv"


def test_table_of_scores_names_the_rule_and_the_cycle(tmp_path: Path) -> None:
    run = read(tmp_path, overtaking())
    rows = {row["requirement"]: row for row in score_rows(run, scores(run, {"R-2": "Keep away"}))}
    assert rows["R-2"]["rule"] == "near"
    assert rows["R-2"]["margin"] == "−10 m"
    assert rows["R-2"]["when"] == "2 s, driving"
    assert rows["R-2"]["title"] == "Keep away"


def test_envelope_is_where_the_recording_declares_it(tmp_path: Path) -> None:
    run = read(tmp_path, overtaking(ground_truth={"dynamic": TRUTH}))
    picture = score.score_figure(run, scores(run, {}), timeline.WIDE, "s")
    x0, x1, t0, t1 = (
        float(re.findall(rf'data-{name}="([^"]+)"', picture)[0]) for name in ("x0", "x1", "t0", "t1")
    )
    (bound,) = re.findall(r'<path d="([^"]+)"[^>]*><title>envelope', picture) or re.findall(
        r'<path d="([^"]+)" class="bound"', picture
    )
    steps = {float(x) for x in re.findall(r"[ML]([0-9.]+) ", bound)}
    expected = {x0 + (t - t0) / (t1 - t0) * (x1 - x0) for t in (0.0, 0.8, 1.2, 3.2)}
    assert sorted(steps) == pytest.approx(sorted(expected), abs=0.02)
    (row,) = truth_rows(run)
    assert (
        row["words"]
        == "must be safe: 0 to 0.7; either: 0.8 to 1.1; must be unsafe: 1.2 to 3.1; either: 3.2 to 3.9"
    )
    # The other is within 10 m from 1 s to 3 s: only the last cycle of the truth is missed.
    assert row["verdict"] == "missed: 3.1"


def test_scale_of_the_figure_keeps_the_order_and_the_limit() -> None:
    axis = score.Bent(-1.0, 1.0, 100.0, 0.0)
    values = [-math.inf, -5.0, -1.0, -1e-3, 0.0, 1e-3, 1.0, 3.0, math.inf]
    drawn = [axis.at(value) for value in values]
    assert drawn == sorted(drawn, reverse=True)
    assert (axis.at(0.0), axis.at(1.0), axis.at(3.0), axis.at(math.inf), axis.at(-math.inf)) == (
        50.0,
        25.0,
        12.5,
        0.0,
        100.0,
    )


# Parameters and stretches ---------------------------------------------------------------------------------------------


def test_parameters_in_force_with_what_they_replaced(tmp_path: Path) -> None:
    run = read(tmp_path, overtaking(params={"v_max": 19.0}, because={"v_max": "wet"}))
    rows = {row["name"]: row for row in setting_rows(run)["small"]}
    assert list(rows) == ["v_max"]  # nothing else is read by a rule
    assert rows["v_max"]["value"] == "19 m/s"
    assert rows["v_max"]["source"] == "wet"
    assert "in place of 30 m/s" in rows["v_max"]["replaced"]
    assert rows["v_max"]["rules"] == "fast"
    own = {row["name"]: row for row in setting_rows(read(tmp_path, overtaking()))["small"]}["v_max"]
    assert (own["value"], own["replaced"]) == ("30 m/s", "")
    assert "small.spec" in own["span"]


def test_parameters_have_six_digits_and_all_of_them_where_a_pointer_rests(tmp_path: Path) -> None:
    """A page says so, and how the number goes on; of one with few digits there is no more to be said."""
    assert SPEC.count("= 30 m/s") == 1
    made = record(tmp_path, overtaking(), SPEC.replace("= 30 m/s", "= 100 m/s / 3"))
    row = {row["name"]: row for row in setting_rows(read_run(made))["small"]}["v_max"]
    assert (row["value"], row["exact"]) == ("≈ 33.3333 m/s", "33.333333333333336 m/s")
    write_report(tmp_path / "out", [made], None, {}, [], {}, {})
    (page,) = (tmp_path / "out" / "runs").glob("*.html")
    assert 'title="33.333333333333336 m/s">≈ 33.3333 m/s</td>' in page.read_text("utf-8")
    own = {row["name"]: row for row in setting_rows(read(tmp_path, overtaking()))["small"]}["v_max"]
    assert own["exact"] == ""


def test_tables_of_stretches(tmp_path: Path) -> None:
    run = read(tmp_path, overtaking())
    near = next(rule for rule in run.rules if rule.name == "near")
    assert list(margin_rows(run, near)) == [
        ["0 to 0.9", "10 m to 1 m", "10 m to 1 m"],
        ["1 to 3", "0 m, least −10 m violated", "0 m, least −10 m violated"],
        ["3.1 to 3.9", "1 m to 9 m", "1 m to 9 m"],
    ]
    assert ranges(run, [run.t[i] for i in (1, 2, 3, 10, 38, 39)]) == ["0.1 to 0.3", "1", "3.8 to 3.9"]
    faults = [{"cycle": i, "t": 0.1 * i, "faults": ["x"] if i != 5 else ["y"]} for i in (2, 3, 5, 6)]
    assert [row["when"] for row in fault_rows(run, faults)] == ["0.2 to 0.3 s", "0.5 s", "0.6 s"]


def test_many_stretches_are_summed_up_not_dropped(tmp_path: Path) -> None:
    cycles = [cycle(0.1 * i, 0.0, [other("a", 5.0 if i % 2 else 50.0)]) for i in range(200)]
    run = read(tmp_path, recording(cycles))
    rows = list(margin_rows(run, next(rule for rule in run.rules if rule.name == "near")))
    assert len(rows) == 41
    assert rows[-1][0] == "4 to 19.9: 160 more stretches"
    assert rows[-1][1] == "40 m to −5 m violated"


def test_worst_cycles_of_firings_have_their_numbers(tmp_path: Path) -> None:
    context = run_context(read(tmp_path, overtaking()), {})
    row = next(row for row in context["firings"] if row["rule"].name == "near")
    assert ("left side", "0 m") in row["told"]
