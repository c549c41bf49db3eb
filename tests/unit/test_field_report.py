"""What the rules say of a log: causes that are shown or declared, margins, limits; the extract of a real drive; kept runs."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from support import field_logs
from support.schemas import hold
from trackmarshal.cli.main import main
from trackmarshal.cli.replay import evaluator_for
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.ir.spec import Spec
from trackmarshal.records import results_file
from trackmarshal.records.runs import RunSummary
from trackmarshal.scenarios import load as load_recording
from trackmarshal.scenarios.field import mapping
from trackmarshal.scenarios.field.build import Drive, as_it_is, build
from trackmarshal.scenarios.field.causes import firings, on_road
from trackmarshal.scenarios.field.header import header
from trackmarshal.scenarios.field.judged import CONTRACT, Judgement, judge
from trackmarshal.scenarios.field.limits import limits, params_of
from trackmarshal.scenarios.field.report import data, report, residuals
from trackmarshal.scenarios.replay import replay

ROOT = Path(__file__).resolve().parents[2]
EXTRACT = ROOT / "tests" / "field" / "lvms_25s.yaml"
RULES = ["static_collision", "speed_limit", "no_reversing", "acceleration_integrity", "safe_gap"]


def judged(
    where: Path, file: Path | None = None, rules: list[str] | None = None, raw: bool = False
) -> tuple[Drive, Judgement]:
    drive = build(mapping.read(where), file, raw)
    return drive, judge(drive.recording, Evaluator(spec(), rules))


@cache
def spec(*more: Path) -> Spec:
    specs = [ROOT / "specs" / "vehicles" / "av21.spec", ROOT / "specs" / "tracks" / "lvms.spec"]
    return load([ROOT / "specs" / "supervisor"], [*specs, *more])


@pytest.fixture(scope="module")
def extract() -> tuple[Drive, Judgement]:
    return judged(EXTRACT)


def a_standing_car_has_a_path() -> bool:
    """Whether this version of the rules gives a trajectory in one place a path (without one, `pose_on_path` is undefined there)."""
    plan = {
        "t": [0.0, 0.1],
        "s": [0.0, 0.0],
        "x": [1.0, 1.0],
        "y": [0.0, 0.0],
        "heading": [0.0, 0.0],
        "kappa": [0.0, 0.0],
        "v": [0.0, 0.0],
        "a": [0.0, 0.0],
    }
    ego = {"x": 1.0, "y": 0.0, "heading": 0.0, "v": 0.0}
    result = Evaluator(spec(), ["pose_on_path"]).case({"signals": {"plan": plan, "ego": ego}})
    return not result.rules["pose_on_path"].unsafe


def test_a_real_drive_fires_nothing(extract: tuple[Drive, Judgement]) -> None:
    """25 s of it, with jumps of the localisation and -0.35 m/s at standstill in what the rules see as the car's pose."""
    drive, found = extract
    assert min(cycle.ego["v"] for cycle in drive.recording.cycles) < -0.3
    fired = {(one.rule, one.begin < 17.0) for one in firings(drive, found)}
    assert fired == set() if a_standing_car_has_a_path() else fired == {("pose_on_path", False)}
    assert found.faults == {}


def test_the_same_drive_as_logged_fires_on_noise_and_says_so(extract: tuple[Drive, Judgement]) -> None:
    _, clean = extract
    raw = judged(EXTRACT, raw=True)
    found = firings(*raw, clean)
    by_rule = {one.rule: one.cause for one in found if one.rule != "pose_on_path"}
    assert {"acceleration_integrity", "no_reversing"} <= set(by_rule)
    assert set(by_rule.values()) == {"noise"}


def test_the_report_is_strict_json_and_says_all(extract: tuple[Drive, Judgement]) -> None:
    drive, found = extract
    made = data(report(drive, found, None, None))
    text = json.loads(json.dumps(made, allow_nan=False))
    assert text["cycles"] == len(drive.recording.cycles)
    assert text["km"] == pytest.approx(0.278, abs=0.005)
    assert "Rauch" in text["smoother"]
    assert text["log"]["sha256"] in text["notes"][0]
    assert {"safe_gap", "contact", "zone_speed_limit"} <= set(text["silent"])
    assert 0.02 < text["residuals"]["speed"]["lag"] < 0.1
    margins = {(m["rule"], m["candidate"]): m["margin"] for m in text["margins"]}
    assert 1.0 < margins["static_collision", "driving"] < 1.5


def drive_of(folder: Path, more: str = "", **columns: Any) -> tuple[Path, Path]:
    log = {**field_logs.straight(30.0, 10.0), **columns}
    return field_logs.write(folder, log, field_logs.MAP.replace("rate: 10}", "rate: 5}") + more)


def test_a_mapping_names_a_shipped_vehicle_by_its_module(tmp_path: Path) -> None:
    """A project that was made with the package has no path of it. What comes with the engine is none of the files that a kept run is made of."""
    where, log = drive_of(tmp_path)
    file = mapping.read(where)
    by_path = build(file, log)
    by_name = build(replace(file, vehicle="vehicles.av21"), log)
    assert by_name.recording.cycles == by_path.recording.cycles
    assert (by_path.recording.use[0], by_name.recording.use[0]) == (
        "specs/vehicles/av21.spec",
        "vehicles.av21",
    )
    left_out = by_path.sources.keys() - by_name.sources.keys()
    assert [Path(path).name for path in left_out] == ["av21.spec"]
    assert any("friction limit of vehicles.av21" in note for note in by_name.recording.notes)
    with pytest.raises(TrackmarshalError, match=r"`vehicles\.none` is not there"):
        build(replace(file, vehicle="vehicles.none"), log)
    own = where.parent / "vehicles" / "av21.spec"  # its `specs` is a link to those of this project
    own.parent.mkdir()
    own.write_text("module vehicles.av21\nparam mu : 1 = 1\n", "utf-8")
    with pytest.raises(TrackmarshalError, match=r"`vehicles\.av21` is shipped, and another module"):
        build(replace(file, vehicle="vehicles.av21"), log)


def test_what_breaks_the_contract_in_many_cycles_is_one_firing(extract: tuple[Drive, Judgement]) -> None:
    """An input that the log does not have is missing in all of them: one firing, as of a rule. Another fault, or a cycle between, begins another one."""
    drive, found = extract
    missing, fast = "D211 ego.gear: it is not there", "D212 plan.v[{}]: {} is above 84"
    faults = {
        0: missing,
        1: missing,
        2: missing,
        3: fast.format(4, 85),
        4: fast.format(5, 86),
        7: fast.format(1, 85),
    }
    broken = [one for one in firings(drive, replace(found, faults=faults)) if one.rule == CONTRACT]
    t = found.times
    assert [(one.begin, one.end, one.cycles) for one in broken] == [
        (t[0], t[2], 3),
        (t[3], t[4], 2),
        (t[7], t[7], 1),
    ]
    assert [one.because for one in broken] == [missing, fast.format(4, 85), fast.format(1, 85)]


def test_a_way_back_is_driven_too(tmp_path: Path) -> None:
    """20 s ahead and 20 s back to where it began: rates were by the 0 km between the two ends."""
    t = np.arange(400) / 10.0
    v, y = 8.0 * np.sin(np.pi * t / 20.0), 160.0 / np.pi * (1.0 - np.cos(np.pi * t / 20.0))
    columns = {"time": t, "x": 0.0 * t, "y": y, "heading": 0.0 * t + np.pi / 2, "v": v, "yaw": 0.0 * t}
    where, file = field_logs.write(tmp_path, columns)
    drive, found = judged(where, file, ["no_reversing"])
    made = report(drive, found)
    assert made.km == pytest.approx(0.2037, abs=0.01)
    (rate,) = made.rates
    assert rate.per_km == pytest.approx(rate.firings / made.km)


def test_a_log_as_it_is_leads_back_where_the_car_reverses(tmp_path: Path) -> None:
    """A way that went on growing would be braked ahead, on a path that lies behind."""
    t = np.arange(300) / 10.0
    log = {
        "time": t,
        "x": 0.0 * t,
        "y": 300.0 - 5.0 * t,
        "heading": 0.0 * t + np.pi / 2,
        "v": 0.0 * t - 5.0,
        "yaw": 0.0 * t,
    }
    where, file = field_logs.write(tmp_path, log)
    drive = build(mapping.read(where), file, raw=True)
    assert drive.motion.s[-1] == pytest.approx(-5.0 * t[-1])
    braked = drive.recording.cycles[0].candidates["emergency"]
    assert (braked["v"][0], braked["v"][-1]) == (-5.0, 0.0)
    assert braked["y"][-1] < braked["y"][0]


def test_a_gap_of_the_map_is_shown_and_declared(tmp_path: Path) -> None:
    """The road begins at y = 60 m, which the car reaches after 14 s. Declared is the gap until 12 s: what is left is real."""
    gap = "gaps: [{from: 0, to: 12, because: a start that nobody surveyed}]\n"
    where, file = drive_of(tmp_path, gap)
    for side, x in (("left", -10), ("right", 10)):
        (tmp_path / f"{side}.csv").write_text(f"{x},60\n{x},400\n", encoding="utf-8")
    found = [one for one in firings(*judged(where, file, RULES)) if one.rule == "static_collision"]
    assert [(one.cause, one.because) for one in found] == [
        ("map gap", "a start that nobody surveyed"),
        ("real", ""),
    ]
    assert found[0].begin == 0.0
    assert found[0].end == pytest.approx(12.0, abs=0.21)
    assert 13.5 < found[1].end < 14.5


def test_a_declared_gap_excuses_nothing_where_the_car_was_on_the_map(tmp_path: Path) -> None:
    """A pinch of the road from y = 200 m on, inside of which the car's middle is and its corners, too; the car drives on past it."""
    gap = "gaps: [{from: 0, to: 29, because: not surveyed}]\n"
    where, file = drive_of(tmp_path, gap)
    (tmp_path / "left.csv").write_text(
        "-10,-50\n-10,200\n-1.05,200\n-1.05,201\n-10,201\n-10,400\n", encoding="utf-8"
    )
    assert [one for one in firings(*judged(where, file, RULES)) if one.rule == "static_collision"] == []
    (tmp_path / "left.csv").write_text(
        "-10,-50\n-10,200\n-0.9,200\n-0.9,201\n-10,201\n-10,400\n", encoding="utf-8"
    )
    found = [one for one in firings(*judged(where, file, RULES)) if one.rule == "static_collision"]
    assert {one.cause for one in found} == {"map gap"}


def test_a_declared_gap_excuses_nothing_before_the_plans_that_lead_into_it(tmp_path: Path) -> None:
    """Two pinches of the road, at 20 m and at 200 m: the gap is at the second one."""
    where, file = drive_of(tmp_path, "gaps: [{from: 15, to: 29, because: not surveyed}]\n")
    pinches = [(-0.9, y) for y in (20, 21)], [(-0.9, y) for y in (200, 201)]
    left = [(-10, -50), (-10, 20), *pinches[0], (-10, 21), (-10, 200), *pinches[1], (-10, 201), (-10, 400)]
    (tmp_path / "left.csv").write_text("".join(f"{x},{y}\n" for x, y in left), encoding="utf-8")
    found = firings(*judged(where, file, ["static_collision"]))
    assert [(one.cause, one.begin < 11.0) for one in found] == [("real", True), ("map gap", False)]


def test_a_person_may_put_it_down_to_a_rule(tmp_path: Path) -> None:
    word = "findings: [{rule: speed_limit, from: 0, to: 18, cause: rule, because: no limit on this day}]\n"
    where, file = drive_of(tmp_path, word)
    drive = build(mapping.read(where), file)
    (tmp_path / "slow.spec").write_text("module slow\n\nparam v_max : m/s = 10 m/s\n", encoding="utf-8")
    slow = spec(tmp_path / "slow.spec")
    assert firings(drive, judge(drive.recording, Evaluator(spec(), ["speed_limit"]))) == []
    found = firings(drive, judge(drive.recording, Evaluator(slow, ["speed_limit"])))
    assert [one.cause for one in found] == ["rule", "real"]


@pytest.mark.parametrize(
    ("said", "notes"),
    [
        ("findings: [{rule: speed_limit, from: 0, to: 18, cause: rule, because: of B}]", []),
        ("findings: [{rule: speed_limit, from: 0, to: 18, cause: real, because: of B}]", []),
        (
            "findings: [{rule: speed_limits, from: 0, to: 18, cause: rule, because: of B}]",
            ["speed_limits", "no such rule", "did you mean `speed_limit`"],
        ),
        (
            "findings: [{rule: no_reversing, from: 0, to: 18, cause: rule, because: of B}]",
            ["no_reversing", "does not fire", "of B"],
        ),
        ("findings: [{rule: speed_limit, from: 9000, to: 9001, cause: rule, because: of B}]", []),
        ("findings: [{rule: static_collision, from: 0, to: 18, cause: rule, because: not asked}]", []),
        ("gaps: [{from: 3, to: 4, because: of G}]", []),
    ],
)
def test_a_word_on_firings_to_which_none_answers_is_told(
    tmp_path: Path, said: str, notes: list[str]
) -> None:  # fmt: skip
    where, file = drive_of(tmp_path, f"{said}\n")
    drive = build(mapping.read(where), file)
    (tmp_path / "slow.spec").write_text("module slow\n\nparam v_max : m/s = 10 m/s\n", encoding="utf-8")
    asked = judge(drive.recording, Evaluator(spec(tmp_path / "slow.spec"), ["speed_limit", "no_reversing"]))
    told = data(report(drive, asked))["notes"][len(drive.recording.notes) :]
    assert len(told) == bool(notes)
    assert all(word in told[0] for word in notes)


def test_a_gap_of_the_map_that_explains_nothing_is_told(tmp_path: Path) -> None:
    where, file = drive_of(tmp_path, "gaps: [{from: 3, to: 4, because: a lane that is no longer there}]\n")
    drive = build(mapping.read(where), file)
    told = report(drive, judge(drive.recording, Evaluator(spec(), ["static_collision"]))).notes
    assert (
        told[-1]
        == "gaps: from 3 to 4 s, no rule that was asked fires for that (a lane that is no longer there)"
    )


def test_limits_are_where_closed_forms_say(tmp_path: Path) -> None:
    """At 15 m/s on a road of 20 m, no rule is near: it would fire from a top speed of 15 m/s down, and from a car 20 m wide up."""
    where, file = drive_of(tmp_path)
    _, found = judged(
        where, file, ["speed_limit", "static_collision", "no_reversing", "safe_gap", "ends_at_rest"]
    )
    made = {(one.rule, one.param): one for one in limits(found)}
    assert made["speed_limit", "v_max"].below == pytest.approx(15.0, abs=0.01)
    assert made["speed_limit", "v_max"].above is None
    width = made["static_collision", "width"]
    assert (width.below, width.above) == (None, None)  # 5 m at most are declared for a width
    assert made["ends_at_rest", "v_rest"].below is None  # it is at rest exactly
    assert "no parameter" in made["no_reversing", ""].why
    assert "nothing to say" in made["safe_gap", ""].why
    (tmp_path / "left.csv").write_text("-2,-50\n-2,400\n", encoding="utf-8")
    drive, narrow = judged(where, file, ["static_collision"])
    (_, width) = sorted(limits(narrow), key=lambda one: one.param)
    assert width.above == pytest.approx(4.0, abs=0.02)  # twice the 2 m to the left border
    assert firings(drive, narrow) == []


def test_with_its_noise_a_log_has_the_same_cycles(tmp_path: Path) -> None:
    """It ends at speed, and as it is brakings come to rest before that from two cycles more than smoothed: it was an internal error (IndexError)."""
    log = field_logs.noisy(field_logs.straight(20.0, 10.0), 4, 0.3, 0.02, 0.2, 0.02)
    where, file = field_logs.write(tmp_path, log, field_logs.MAP.replace("horizon: 2", "horizon: 0.2"))
    drive, found = judged(where, file, ["acceleration_integrity"])
    assert len(build(drive.mapping, file, raw=True).recording.cycles) == len(found.times) + 2
    raw = as_it_is(drive)
    logged = judge(raw.recording, found.evaluator)
    assert logged.times.tolist() == found.times.tolist()
    made = report(drive, found, (raw, logged))
    assert "noise" in {rate.cause for rate in made.logged or []}


def test_a_car_about_as_slow_as_noise_is_told_from_has_none(tmp_path: Path) -> None:
    """At 3 m/s, its noise takes the speed over the bound and back: for more than ten seconds in all, and for none on end. Its noise was NaN."""
    t = np.arange(600) / 10.0
    log = {
        "time": t,
        "x": 0.0 * t,
        "y": 3.0 * t,
        "heading": 0.0 * t + np.pi / 2,
        "v": 0.0 * t + 3.0,
        "yaw": 0.0 * t,
    }
    log["v"] += 0.2 * np.where(np.arange(600) % 4 < 2, 1.0, -1.0)
    where, file = field_logs.write(tmp_path, log)
    with pytest.raises(TrackmarshalError, match="or not for seconds on end") as found:
        build(mapping.read(where), file)
    assert found.value.code == "D177"


def test_a_drive_of_one_cycle(extract: tuple[Drive, Judgement]) -> None:
    """The times of rows are no whole microseconds, those of cycles are: between the first and the last cycle lay no row, an internal error."""
    drive, _ = extract
    place = next(place for place, cycle in enumerate(drive.recording.cycles) if cycle.t not in drive.log.t)
    t = drive.recording.cycles[place].t
    (row,) = np.flatnonzero(np.abs(drive.log.t - t) < 1e-6)
    apart = residuals(drive, t, t)["speed"]
    assert apart["most"] == pytest.approx(abs(drive.log.v[row] - drive.motion.v[row]))


def test_a_rule_over_the_run_sees_the_cycles_before(tmp_path: Path) -> None:
    """Each was judged as the first and only one of a run, and nothing fired. From the second second on, until two seconds after the car is fast."""
    where, file = drive_of(tmp_path)
    text = 'module recent\n\nuse supervisor.interface\n\nparam v_slow : m/s = 12 m/s in [0, 90]\n  source "made up"\n\n'
    text += 'rule long_fast "It has been fast"\n  require not once[1 s, 2 s] ego.v < v_slow\n'
    text += 'rule long_slow "It has not been too fast"\n  require not once[1 s, 2 s] ego.v > v_slow + 4 m/s\n'
    (tmp_path / "recent.spec").write_text(text, encoding="utf-8")
    drive = build(mapping.read(where), file)
    found = judge(drive.recording, Evaluator(load([tmp_path / "recent.spec"])))
    (one,) = firings(drive, found)
    slow = [cycle.t for cycle in drive.recording.cycles if cycle.ego["v"] < 12.0]
    assert (one.begin, one.end) == pytest.approx((slow[0] + 1.0, slow[-1] + 2.0), abs=0.21)
    assert found.result(one.worst[0], 0, 0).verdict == "violated"
    assert ["cycles before" in each.why for each in limits(found)] == [False, True]
    assert report(drive, found).rates[0].firings == 1


def test_what_is_said_of_a_drive_is_what_a_replay_says(tmp_path: Path) -> None:
    """And only of rules over the run it is kept: what was computed of every cycle was 40 kB each."""
    where, file = drive_of(tmp_path)
    text = "module recent\n\nuse supervisor.interface\n\nrule now require ego.v < 12 m/s\nrule before require not once[1 s, 2 s] ego.v > 12 m/s\n"
    (tmp_path / "recent.spec").write_text(text, encoding="utf-8")
    recording, evaluator = (
        build(mapping.read(where), file).recording,
        Evaluator(load([tmp_path / "recent.spec"])),
    )
    found = judge(recording, evaluator)
    assert all(each.keys() == {("driving", 1), ("emergency", 1)} for each in found.in_step)
    for place, cycle in enumerate(replay(recording, evaluator).cycles):
        said = [[repr(found.result(place, one, rule)) for rule in (0, 1)] for one in (0, 1)]
        assert said == [
            [repr(each.rules[name]) for name in ("now", "before")] for each in cycle.results.values()
        ]


def test_parameters_of_a_rule_are_those_that_its_formula_reads() -> None:
    names = {rule.name: {name.rpartition(".")[2] for name in params_of(rule)} for rule in spec().rules}
    assert names["speed_limit"] == {"v_event", "v_max"}
    assert {"mu", "g", "mass"} <= names["friction"]
    assert {"response", "b_rear", "length", "least_gap"} <= names["safe_gap"]  # through definitions


def test_on_road() -> None:
    import numpy as np

    ring = [[2.0, 2.0], [-2.0, 2.0], [-2.0, -2.0], [2.0, -2.0]]
    outer = [[2 * x, 2 * y] for x, y in ring]
    x, y = np.array([0.0, 3.0, 5.0]), np.array([0.0, 0.5, 0.0])
    assert on_road(x, y, {"left": ring, "right": outer, "closed": True}).tolist() == [False, True, False]
    assert on_road(x, y, {"left": [[0, 1], [9, 1]], "right": [[0, -1], [9, -1]]}).tolist() == [
        True,
        True,
        True,
    ]


def test_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    out = tmp_path / "made.tmrec.jsonl.gz"
    assert (
        main(
            ["import", "log", "--map", str(EXTRACT), "--to", "3", "--out", str(out), "--no-report", "--quiet"]
        )
        == 0
    )
    for more, said in (
        (["--limits", "--out", str(out)], "makes no report, which --limits would be of"),
        (
            ["--rule", "friction", "--format", "json", "--out", str(out)],
            "which --rule and --format json would",
        ),
        ([], "say with --out where it goes"),
    ):
        assert main(["import", "log", "--map", str(EXTRACT), "--no-report", *more]) == 2
        assert said in capsys.readouterr().err
    recording = load_recording(out)
    assert recording.use == ("specs/vehicles/av21.spec", "specs/tracks/lvms.spec")
    assert main(["replay", str(out)]) == 0
    said = capsys.readouterr().out
    assert "every trajectory is safe" in said
    asked = ["import", "log", "--map", str(EXTRACT), "--to", "3", "--rule", "speed_limit", "--format", "json"]
    for more in ([], ["--limits"]):
        assert main([*asked, *more]) == 0
        said = capsys.readouterr().out
        hold(asked, said)
        assert json.loads(said)["rates"] == []
    assert (
        main(["import", "log", "--map", str(EXTRACT), "--to", "3", "--keep", str(tmp_path / "run.json")]) == 2
    )
    assert "E435" in capsys.readouterr().err


@pytest.mark.parametrize("time", ["nan", "inf", "-1", "1e7"])
@pytest.mark.parametrize("option", ["--from", "--to"])
def test_a_time_that_is_none_of_a_log(option: str, time: str, capsys: pytest.CaptureFixture[str]) -> None:
    """From `nan` or `inf` on was an internal error, and to `nan` was to the end."""
    assert main(["import", "log", "--map", str(EXTRACT), f"{option}={time}"]) == 2
    assert f"{option} is a time from 0 to 1e+06 s, not {float(time):g}" in capsys.readouterr().err


def test_a_mapping_is_a_recording_too() -> None:
    """`replay` takes it as it takes a declaration."""
    recording = load_recording(EXTRACT)
    assert len(recording.cycles) == 220
    with pytest.raises(TrackmarshalError) as found:
        mapping.read(ROOT / "specs" / "scenarios" / "cut_in.yaml")
    assert found.value.code == "D151"


def test_a_mapping_is_read_from_wherever_its_project_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reports print its path from the project; from another folder, `assess` looked for it there, and found nothing (D120)."""
    monkeypatch.chdir(tmp_path)
    assert len(load_recording(EXTRACT, "tests/field/lvms_25s.yaml").cycles) == 220
    assert str(EXTRACT) in build(mapping.read(EXTRACT, "tests/field/lvms_25s.yaml")).sources


@pytest.mark.parametrize(
    ("said", "before"),
    [
        ('format: "trackmarshal-log-map"', b""),
        ("format: 'trackmarshal-log-map'   # of the oval", b""),
        ('"format":  trackmarshal-log-map', b""),
        ("format: trackmarshal-log-map", b"\xef\xbb\xbf"),
    ],
)
def test_a_mapping_is_known_however_yaml_writes_its_format(tmp_path: Path, said: str, before: bytes) -> None:
    """`import log` reads it; as a recording, it was taken for a scenario with a wrong key. That its log is not here shows what it is."""
    text = EXTRACT.read_text("utf-8").partition("\n")[2]
    assert text.startswith("format: trackmarshal-log-map\n")
    (tmp_path / "map.yaml").write_bytes(before + text.replace("format: trackmarshal-log-map", said).encode())
    with pytest.raises(TrackmarshalError, match="this file of the mapping is not here") as found:
        load_recording(tmp_path / "map.yaml")
    assert found.value.code == "D178"


def test_a_mapping_that_a_program_wrote_as_json_is_known(tmp_path: Path) -> None:
    """Which is YAML, too: with a comma behind its format, it was a scenario."""
    text = json.dumps(yaml.safe_load(EXTRACT.read_text("utf-8")), indent=2)
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(TrackmarshalError, match="this file of the mapping is not here"):
        load_recording(tmp_path / "map.yaml")


def test_a_kept_run_is_of_what_the_mapping_alone_says(
    extract: tuple[Drive, Judgement], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its fingerprint is that of the specs in force, known without the log; its paths are from the project."""
    monkeypatch.chdir(ROOT)
    kept = tmp_path / "run.json"
    status = main(["import", "log", "--map", str(EXTRACT), "--keep", str(kept), "--quiet"])
    (run,) = results_file.load(kept).items
    assert isinstance(run, RunSummary)
    declared = mapping.read(EXTRACT)
    evaluator = evaluator_for(
        header(declared), ROOT / "specs" / "supervisor", [], ROOT, None, "numpy", EXTRACT.parent
    )
    assert run.spec_fingerprint == evaluator.spec.fingerprint
    assert run.scenario == "tests/field/lvms_25s.yaml"
    assert (run.cycles, run.fired) == (220, status == 1)
    assert set(run.made_from) == {
        "tests/field/lvms_25s.yaml", "tests/field/lvms_25s.csv.gz", "tests/field/lvms_inner.csv", "tests/field/lvms_outer.csv",
        "specs/vehicles/av21.spec", "specs/tracks/lvms.spec",
    }  # fmt: skip
    assert run.made_from["tests/field/lvms_25s.csv.gz"] == extract[0].log.sha256
    counts = {facts.rule: facts.number("satisfied", "violated") for facts in run.rules}
    assert counts["static_collision"] == 440
    assert counts["safe_gap"] == 0
