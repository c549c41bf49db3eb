"""Fault injection: what declarations may say, what changes do to a cycle, and how an outcome is held against what was expected."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from support.shared import REPOSITORY
from trackmarshal import scenarios
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.evaluation import load as load_spec
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.program import NOTHING
from trackmarshal.scenarios.faults.campaign import Bench, fingerprint
from trackmarshal.scenarios.faults.changes import change
from trackmarshal.scenarios.faults.declaration import Campaign, Fault, load
from trackmarshal.scenarios.faults.moment import Moment
from trackmarshal.scenarios.generate import document

SHIPPED = REPOSITORY / "specs" / "scenarios" / "faults.yaml"
HEAD = "format: trackmarshal-faults\nversion: 1\nname: few\nrecording: r.jsonl\nlead: 0.3\nfaults:\n"
FAULT = """  - id: F-1
    title: too fast
    requirement: RR-1
    begin: 2
    end: 2.2
    change: [{column: driving.v, set: 85}]
    expect: {by: speed_limit, first: 2, last: 2.2, driven: previous_emergency, from: 1.9}
"""


def moment() -> Moment:
    plan = {name: [0.0, 1.0, 2.0, 3.0] for name in ("t", "s", "x", "y", "heading", "kappa", "v", "a")}
    plan["heading"] = [0.0] * 4
    blue = {
        "id": "blue",
        "x": 30.0,
        "y": 0.0,
        "heading": 0.0,
        "v": 20.0,
        "length": 4.0,
        "width": 2.0,
        "age": 0.0,
    }
    track = {
        "left": [[float(i), 5.0] for i in range(9)],
        "right": [[float(i), -5.0] for i in range(9)],
        "closed": True,
    }
    signals = {
        "ego": {"x": 1.0, "y": 2.0, "heading": math.pi / 2, "v": 20.0},
        "objects": [blue],
        "obstacles": [],
        "track": track,
    }
    return Moment.of(Cycle(7, 3.0, plan, plan, signals))


def changed(text: str) -> Moment:
    """A moment after the change that a line declares."""
    made = moment()
    change(document.read(text.encode(), "f.yaml"))(made)
    return made


def same(one: Any, other: Any) -> bool:
    return repr(one) == repr(other)


def test_a_moment_shares_nothing_with_the_recording() -> None:
    plan = {"t": [0.0], "x": [1.0]}
    signals: dict[str, Any] = {
        "ego": {"x": 0.0},
        "objects": [{"x": 1.0}],
        "obstacles": [],
        "track": {"left": []},
    }
    made = Moment.of(Cycle(0, 0.0, plan, plan, signals))
    made.candidates["driving"]["x"][0] = 9.0
    made.signals["objects"][0]["x"] = 9.0
    made.signals["ego"]["x"] = 9.0
    assert (plan["x"], signals["objects"], signals["ego"]) == ([1.0], [{"x": 1.0}], {"x": 0.0})
    assert made.candidates["emergency"]["x"] == [1.0]


@pytest.mark.parametrize(
    ("text", "column", "expected"),
    [
        ("{column: driving.a, set: -9}", "a", [-9.0] * 4),
        ("{column: driving.a, samples: [1, 2], set: nan}", "a", [0.0, math.nan, math.nan, 3.0]),
        ("{column: driving.a, samples: [3, 3], set: -inf}", "a", [0.0, 1.0, 2.0, -math.inf]),
        ("{column: driving.a, samples: [2, 9], add: 0.5}", "a", [0.0, 1.0, 2.5, 3.5]),
        ("{column: driving.t, reverse: true}", "t", [3.0, 2.0, 1.0, 0.0]),
        ("{column: driving.v, keep: 3}", "v", [0.0, 1.0, 2.0]),
        ("{trajectory: driving, keep: 2}", "v", [0.0, 1.0]),
        ("{trajectory: driving, left: 3}", "y", [3.0, 4.0, 5.0, 6.0]),
        ("{trajectory: driving, drift: 9}", "y", [0.0, 2.0, 6.0, 12.0]),
        ("{trajectory: driving, refine: 7}", "v", [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]),
    ],
)
def test_changes_of_trajectories(text: str, column: str, expected: list[float]) -> None:
    made = changed(text)
    assert same(made.candidates["driving"][column], expected)
    assert made.candidates["emergency"] == moment().candidates["emergency"]


def test_refined_headings_turn_the_shorter_way_round() -> None:
    """From 3 rad to -3 rad it is a turn of 0.28 rad to the left, over pi: between them lay 0, which no car has there."""
    made = moment()
    made.candidates["driving"]["heading"] = [3.0, -3.0, -3.0, -2.8]
    change(document.read(b"{trajectory: driving, refine: 7}", "f.yaml"))(made)
    between = made.candidates["driving"]["heading"]
    assert [math.cos(angle) for angle in between[:3]] == pytest.approx([math.cos(3.0), -1.0, math.cos(3.0)])
    assert between[2:] == pytest.approx([-3.0, -3.0, -3.0, -2.9, -2.8])


def test_changes_that_take_away() -> None:
    assert "v" not in changed("{column: emergency.v, remove: true}").candidates["emergency"]
    assert set(changed("{trajectory: driving, remove: true}").candidates) == {"emergency"}
    assert changed("{trajectory: driving, remove: true}").cycle.driving is None
    assert "objects" not in changed("{signal: objects, remove: true}").signals
    assert "width" not in changed("{column: objects.width, remove: true}").signals["objects"][0]
    assert "v" not in changed("{field: ego.v, remove: true}").signals["ego"]


def test_changes_of_what_is_around() -> None:
    """The car stands at (1, 2) and looks along +y."""
    assert changed("{column: objects.age, set: 0.15}").signals["objects"][0]["age"] == 0.15
    blue = changed("{place: objects, ahead: 8, left: 3}").signals["objects"][0]
    assert [blue["x"], blue["y"], blue["heading"]] == pytest.approx([-2.0, 10.0, math.pi / 2])
    slower = moment()
    slower.signals["ego"]["v"] = 11.0
    change(document.read(b"{place: objects, ahead: 8, left: 3}", "f.yaml"))(slower)
    assert slower.signals["objects"][0]["v"] == 11.0  # as the car drives, and not as it did itself
    assert changed("{field: ego.v, add: 2}").signals["ego"]["v"] == 22.0
    ego = changed("{signal: ego, left: 3}").signals["ego"]
    assert [ego["x"], ego["y"], ego["heading"]] == pytest.approx([-2.0, 2.0, math.pi / 2])
    made = changed("{append: objects, id: g, ahead: 10, left: 0, turn: 180, length: 4, width: 2, v: 30}")
    ghost = made.signals["objects"][-1]
    assert [ghost["x"], ghost["y"], ghost["heading"]] == pytest.approx([1.0, 12.0, -math.pi / 2])
    assert (ghost["id"], ghost["v"]) == ("g", 30.0)
    many = changed("{append: obstacles, id: g, ahead: 10, left: 0, length: 4, width: 2, copies: 3}")
    assert [each["id"] for each in many.signals["obstacles"]] == ["g0", "g1", "g2"]


def test_changes_of_the_map() -> None:
    track = changed("{border: left, swap: [2, 4]}").signals["track"]
    assert [point[1] for point in track["left"]] == [5, 5, -5, -5, -5, 5, 5, 5, 5]
    assert [point[1] for point in track["right"]] == [-5, -5, 5, 5, 5, -5, -5, -5, -5]
    track = changed("{border: right, keep: [1, 2]}").signals["track"]
    assert (track["right"], len(track["left"]), track["closed"]) == ([[1, -5], [2, -5]], 9, False)
    track = changed("{border: left, set: nan}").signals["track"]
    assert math.isnan(track["left"][0][0])
    assert track["left"][1:] == moment().signals["track"]["left"][1:]


def test_changes_of_time_and_judge() -> None:
    assert changed("{cycle: lost}").lost
    assert changed("{cycle: silent}").silent
    assert changed("{cycle: number, add: -1}").cycle.number == 6
    assert changed("{cycle: number, add: 4294967296}").cycle.number == 7 + 2**32  # a counter of 32 bits
    assert changed("{cycle: t, add: -0.5}").cycle.t == 2.5
    assert changed("{cycle: arrival, add: 0.5}").arrival == 3.5
    assert changed("{cycle: clock, add: -1}").clock == -1.0
    assert changed("{judge: slow, delay: 0.06}").delay == 0.06
    assert changed("{judge: raises}").judge == "raises"


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("trackmarshal-faults", "trackmarshal-scenario", "'trackmarshal-scenario' is not 'trackmarshal-faults'"),
        ("version: 1", "version: 2", "out of range"),
        ("lead: 0.3\n", "", "`lead` is missing"),
        ("    title: too fast\n", "", "`title` is missing"),
        ("requirement: RR-1\n", "requirement: RR-1\n    open: because\n", "not known"),
        ("end: 2.2", "end: 1.9", "before it begins"),
        ("end: 2.2", "end: soon", "number"),
        ("by: speed_limit, ", "", "`by` is missing"),
        ("driven: previous_emergency", "driven: emergency", "not known"),
        (", from: 1.9", "", "which cycle's"),
        ("from: 1.9", "from: 1.9, lost: apart", "belong together"),
        ("from: 1.9", "from: 1.9, lost: bored, lost_at: 2", "not known"),
        ("{column: driving.v, set: 85}", "{columns: driving.v, set: 85}", "no change"),
        ("{column: driving.v, set: 85}", "{column: driving.v, field: ego.v, set: 85}", "no change"),
        ("{column: driving.v, set: 85}", "{column: driver.v, set: 85}", "not known"),
        ("{column: driving.v, set: 85}", "{column: driving, set: 85}", "not known"),
        ("{column: driving.v, set: 85}", "{column: driving.v, set: 85, add: 1}", "one operation"),
        ("{column: driving.v, set: 85}", "{column: driving.v}", "one operation"),
        ("{column: driving.v, set: 85}", "{column: driving.v, set: fast}", "number"),
        ("{column: driving.v, set: 85}", "{column: driving.v, set: [85]}", "a list stands where a number"),
        ("{column: driving.v, set: 85}", "{column: driving.v, set: {to: 85}}", "stands where a number"),
        ("{column: driving.v, set: 85}", "{column: driving.v, samples: [3, 1], set: 85}", "no range"),
        ("{column: driving.v, set: 85}", "{column: driving.v, remove: false}", "`false` changes nothing"),
        ("{column: driving.v, set: 85}", "{column: driving.v, reverse: false}", "`false` changes nothing"),
        ("{column: driving.v, set: 85}", "{signal: objects, remove: false}", "`false` changes nothing"),
        ("{column: driving.v, set: 85}", "{trajectory: driving, remove: false}", "`false` changes nothing"),
        ("{column: driving.v, set: 85}", "{column: driving.v, samples: [1, 2], remove: true}", "the whole column"),
        ("{column: driving.v, set: 85}", "{column: objects.v, samples: [0, 0], set: 85}", "for trajectories"),
        ("{column: driving.v, set: 85}", "{column: obstacles.x, keep: 1}", "for trajectories"),
        ("{column: driving.v, set: 85}", "{trajectory: driving}", "one operation"),
        ("{column: driving.v, set: 85}", "{trajectory: sideways, left: 1}", "not known"),
        ("{column: driving.v, set: 85}", "{trajectory: driving, keep: -3}", "out of range"),
        ("{column: driving.v, set: 85}", "{trajectory: driving, keep: 1.5}", "not a whole number"),
        ("{column: driving.v, set: 85}", "{trajectory: driving, refine: 1}", "out of range"),
        ("{column: driving.v, set: 85}", "{trajectory: driving, refine: 4.5}", "not a whole number"),
        ("{column: driving.v, set: 85}", "{cycle: number, add: 1.5}", "not a whole number"),
        ("{column: driving.v, set: 85}", "{signal: objects, left: 1}", "is the car's"),
        ("{column: driving.v, set: 85}", "{border: left, swap: [1]}", "no range"),
        ("{column: driving.v, set: 85}", "{border: left}", "one operation"),
        ("{column: driving.v, set: 85}", "{cycle: never}", "not known"),
        ("{column: driving.v, set: 85}", "{cycle: t}", "`add` is missing"),
        ("{column: driving.v, set: 85}", "{cycle: lost, add: 1}", "not known"),
        ("{column: driving.v, set: 85}", "{judge: sleeps}", "not known"),
        ("{column: driving.v, set: 85}", "{judge: slow}", "`delay` is missing"),
    ],
)  # fmt: skip
def test_wrong_declarations_are_refused(tmp_path: Path, old: str, new: str, part: str) -> None:
    text = HEAD + FAULT
    assert old in text
    (tmp_path / "f.yaml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(TrackmarshalError) as caught:
        load(tmp_path / "f.yaml", "f.yaml")
    assert caught.value.code == "D151", str(caught.value)
    assert part in caught.value.message, str(caught.value)
    assert caught.value.line is not None


def test_a_campaign_leads_to_the_page_that_is_about_faults(tmp_path: Path) -> None:
    (tmp_path / "f.yaml").write_text((HEAD + FAULT).replace("lead:", "led:", 1), encoding="utf-8")
    (tmp_path / "g.yaml").write_text(HEAD + FAULT.replace("{column: driving.v, set: 85}", "{cycle: t}", 1))
    for name in ("f.yaml", "g.yaml"):
        with pytest.raises(TrackmarshalError) as caught:
            load(tmp_path / name, name)
        assert "docs/scenarios.md" not in (caught.value.help or "")
    assert caught.value.help == "see docs/faults.md"


def test_an_id_stands_once(tmp_path: Path) -> None:
    (tmp_path / "f.yaml").write_text(HEAD + FAULT + FAULT, encoding="utf-8")
    with pytest.raises(TrackmarshalError, match="stands twice"):
        load(tmp_path / "f.yaml", "f.yaml")


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return load(SHIPPED, "faults.yaml")


@pytest.fixture(scope="module")
def bench(campaign: Campaign) -> Bench:
    recording = scenarios.load(SHIPPED.parent / campaign.recording)
    northfield = SHIPPED.parents[1] / "tracks" / "northfield.spec"
    return Bench(recording, Evaluator(load_spec([SHIPPED.parents[1] / "supervisor"], [northfield])))


def friction(campaign: Campaign) -> Fault:
    return next(fault for fault in campaign.faults if fault.expected and fault.expected.by == "friction")


@pytest.mark.parametrize(
    ("field", "value", "part"),
    [
        ("by", "contact", "found by friction, expected contact"),
        ("by", "missing", "found by friction, expected missing"),
        ("first", 2.1, "unsafe at 2 s; expected unsafe from 2.1 to 2.2 s"),
        (
            "last",
            3.0,
            "safe at 2.3 s, safe at 2.4 s, safe at 2.5 s, and 5 more cycles; expected unsafe from 2 to 3 s",
        ),
        ("last", 2.4, "safe at 2.3 s, safe at 2.4 s; expected unsafe from 2 to 2.4 s"),
        ("driven", "no_safe_trajectory", "driven is previous_emergency from 1.9 s"),
        ("since", 1.8, "driven is previous_emergency from 1.9 s, expected previous_emergency from 1.8 s"),
        ("lost", "expired", "the stored trajectory is kept"),
    ],
)
def test_every_difference_is_said(
    campaign: Campaign, bench: Bench, field: str, value: Any, part: str
) -> None:
    fault = friction(campaign)
    assert bench.run(campaign, fault).wrong == ""
    assert fault.expected is not None
    other = replace(fault.expected, **{field: value})
    if field == "lost":
        other = replace(other, lost_at=2.2)
    assert part in bench.run(campaign, replace(fault, expected=other)).wrong


@pytest.mark.parametrize(("field", "t"), [("first", 1.95), ("last", 2.25)])
def test_what_is_expected_at_a_time_of_no_cycle_was_not_found(
    campaign: Campaign, bench: Bench, field: str, t: Any
) -> None:
    fault = friction(campaign)
    assert fault.expected is not None
    found = bench.run(campaign, replace(fault, expected=replace(fault.expected, **{field: t})))
    assert f"nothing was decided at {t:g} s; expected unsafe from" in found.wrong


def test_what_is_expected_after_the_end_was_not_found(campaign: Campaign, bench: Bench) -> None:
    """Of a recording that ends at 2.2 s, no cycle shows that the car is unsafe until 99 s."""
    fault = replace(friction(campaign), end=99.0)
    short = copy.copy(bench)
    short._cycles = [cycle for cycle in bench._cycles if cycle.t < 2.25]
    assert short.run(campaign, fault).wrong == ""
    assert fault.expected is not None
    found = short.run(campaign, replace(fault, expected=replace(fault.expected, last=99.0)))
    assert found.wrong == "nothing was decided at 99 s; expected unsafe from 2 to 99 s"


def test_what_is_not_found_and_what_was_not_expected_is_said(campaign: Campaign, bench: Bench) -> None:
    fault = friction(campaign)
    quiet = bench.run(campaign, replace(fault, changes=()))
    assert quiet.wrong == "nothing was found; expected friction at 2 s"
    loud = bench.run(campaign, replace(fault, expected=None))
    assert loud.wrong == "unsafe at 2 s by friction, not at all expected"
    other = bench.run(campaign, replace(fault, requirement="S-1-A-5"))
    assert other.wrong == "friction satisfies S-1-A-4, expected S-1-A-5"
    assert bench.run(campaign, replace(fault, requirement="S-1-B-5")).wrong == ""  # which no rule satisfies


@pytest.mark.parametrize(
    "text",
    [
        "{column: driving.voltage, set: 1}",
        "{column: objects.colour, set: 1}",
        "{field: ego.mood, remove: true}",
        "{column: driving.t, keep: 0}",
    ],
)
def test_what_the_recording_does_not_have_cannot_be_changed(
    campaign: Campaign, bench: Bench, text: str
) -> None:
    broken = change(document.read(text.encode(), "f.yaml"))
    refine = change(document.read(b"{trajectory: driving, refine: 5}", "f.yaml"))
    fault = replace(friction(campaign), changes=(broken, refine))
    with pytest.raises(TrackmarshalError) as caught:
        bench.run(campaign, fault)
    assert (caught.value.code, caught.value.file, caught.value.line) == ("D153", "faults.yaml", fault.line)


@pytest.mark.parametrize(
    ("text", "idle"),
    [
        ("{column: driving.v, add: 0}", True),
        ("{trajectory: driving, keep: 1000}", True),
        ("{judge: slow, delay: 0.005}", True),
        ("{border: left, swap: [100000, 100001]}", True),
        ("{border: left, keep: [0, 100000]}", False),  # of a closed track it opens that
        ("{column: driving.v, add: 1.0e-9}", False),
        ("{append: obstacles, id: box, ahead: -500, left: 0, length: 1, width: 1}", False),
    ],
)
def test_a_fault_that_changes_nothing_shows_nothing(
    campaign: Campaign, bench: Bench, text: str, idle: bool
) -> None:
    changes = (change(document.read(text.encode(), "f.yaml")),)
    outcome = bench.run(campaign, replace(friction(campaign), changes=changes, expected=None))
    assert outcome.first is None
    assert outcome.wrong == ("it changes nothing: all cycles are as they were recorded" if idle else "")


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        (
            ("{trajectory: driving, keep: 1000}", "{column: driving.v, add: 1.0e-9}"),
            "change 1 of 2 changes nothing: all cycles are as without it",
        ),
        (
            ("{column: driving.v, add: 1}", "{column: driving.v, add: -1}"),
            "it changes nothing: all cycles are as they were recorded",
        ),
        (("{judge: slow, delay: 0.004}", "{column: driving.v, add: 1.0e-9}"), ""),
    ],
)
def test_each_change_of_a_fault_changes_something(
    campaign: Campaign, bench: Bench, texts: tuple[str, ...], said: str
) -> None:
    """One of which nothing came went unheard beside another one: what was found was not what the fault says."""
    changes = tuple(change(document.read(text.encode(), "f.yaml")) for text in texts)
    assert bench.run(campaign, replace(friction(campaign), changes=changes, expected=None)).wrong == said


@pytest.mark.parametrize(
    ("nowhere", "text"),
    [
        ("{field: ego.heading, set: inf}", "{signal: ego, left: 3}"),
        ("{column: driving.heading, set: inf}", "{trajectory: driving, left: 3}"),
    ],
)
def test_what_faces_nowhere_cannot_be_moved_to_the_left(
    campaign: Campaign, bench: Bench, nowhere: str, text: str
) -> None:
    changes = tuple(change(document.read(each.encode(), "f.yaml")) for each in (nowhere, text))
    with pytest.raises(TrackmarshalError, match="changes what is not there") as caught:
        bench.run(campaign, replace(friction(campaign), changes=changes))
    assert caught.value.code == "D153"


def test_a_recording_has_what_other_specs_declare() -> None:
    """`replay` takes such a recording; every cycle was refused (`unknown`), and every fault was found by that."""
    recording = scenarios.load(SHIPPED.parent / "cut_in.tmrec.jsonl")
    cycles = tuple(replace(each, ego={**each.ego, "load": 3.0}) for each in recording.cycles)
    spec = load_spec([SHIPPED.parents[1] / "supervisor"])
    evaluator = Evaluator(spec, ["speed_limit"], "numpy", lambda: frozenset({"ego.load"}))
    campaign = load(SHIPPED, "faults.yaml")
    idle = replace(friction(campaign), changes=(), expected=None)
    assert Bench(replace(recording, cycles=cycles), evaluator).run(campaign, idle).wrong == ""


def test_stamps_may_count_from_1970(tmp_path: Path) -> None:
    """No time of a campaign was later than 11 days: into the recording of a car whose clock is that of Unix, nothing could be put."""
    text = HEAD + FAULT
    for old, new in (("begin: 2\n", "begin: 1700000002\n"), ("end: 2.2", "end: 1700000002.2"), ("first: 2,", "first: 1700000002,"),
                     ("last: 2.2", "last: 1700000002.3"), ("from: 1.9", "from: 1700000001.9")):  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "far.yaml").write_text(text)
    far = load(tmp_path / "far.yaml", "far.yaml")
    recording = scenarios.load(SHIPPED.parent / "cut_in.tmrec.jsonl")
    cycles = tuple(replace(each, t=each.t + 1.7e9) for each in recording.cycles)
    bench = Bench(
        replace(recording, cycles=cycles),
        Evaluator(load_spec([SHIPPED.parents[1] / "supervisor"]), ["speed_limit"]),
    )
    outcome = bench.run(far, far.faults[0])
    assert (outcome.by, outcome.first) == (("starts_elsewhere",), 1700000002.0)
    assert outcome.since == pytest.approx(1700000001.9, abs=1e-6)
    assert outcome.wrong.endswith("safe at 1700000002.3 s; expected unsafe from 1700000002 to 1700000002.3 s")


def test_who_is_slow_takes_the_next_cycle_when_it_is_done(campaign: Campaign, bench: Bench) -> None:
    """The next cycle waits: a clock that would have to go back is another fault than the one that is put in."""
    slow = change(document.read(b"{judge: slow, delay: 0.25}", "f.yaml"))
    said, _ = bench._decisions(campaign, replace(friction(campaign), changes=(slow,), end=2.0, expected=None))
    faults = {round(t, 1): [name_of(each) for each in decision.faults] for t, decision in said}
    assert faults[2.0] == ["overrun"]
    assert faults[2.1] != []
    assert "bad_clock" not in [name for names in faults.values() for name in names]


def test_a_fault_may_say_that_nothing_is_put_in(campaign: Campaign, bench: Bench) -> None:
    """What fires then is a false alarm."""
    assert bench.run(campaign, replace(friction(campaign), changes=(), expected=None)).wrong == ""


def test_a_fault_at_a_time_that_the_recording_does_not_have(campaign: Campaign, bench: Bench) -> None:
    with pytest.raises(TrackmarshalError, match="no cycle in the time") as caught:
        bench.run(campaign, replace(friction(campaign), begin=20.0, end=20.1, expected=None))
    assert caught.value.code == "D153"


def test_decisions_that_differ_the_second_time_are_no_evidence(campaign: Campaign, bench: Bench) -> None:
    fault = friction(campaign)
    runs = iter([fault.changes, ()])

    class Wavering:
        """A change that is another one in the second run."""

        last = math.inf
        now: Any = ()

        def __call__(self, made: Moment) -> None:
            if made.t <= self.last:
                self.now = next(runs)
            self.last = made.t
            for each in self.now:
                each(made)

    outcome = bench.run(campaign, replace(fault, changes=(Wavering(),)))
    assert outcome.wrong == "the same cycles led to other decisions the second time"


def test_a_track_that_is_open_is_not_judged_as_the_closed_one(bench: Bench) -> None:
    """Its borders have the same points, and frames that are the same in every bit are judged once."""
    judging = bench._judging
    door = bench._box.supervisor(bench._limits).door
    frame = door.admit(0, bench._cycles[0], bench._cycles[0].t).frame
    again = replace(frame)
    opened = replace(frame, closed=dict.fromkeys(frame.closed, False))
    assert frame.closed == {"track": True}
    first, second, other = (judging.judge(NOTHING, each) for each in (frame, again, opened))
    assert first.rated is second.rated
    assert other.rated is not first.rated


def test_a_fingerprint_changes_with_all_that_counts(campaign: Campaign) -> None:
    one, other = campaign.faults[0], campaign.faults[2]
    prints = [
        fingerprint(campaign, one, "r", "s", Limits(), ()),
        fingerprint(campaign, other, "r", "s", Limits(), ()),
        fingerprint(campaign, one, "r2", "s", Limits(), ()),
        fingerprint(campaign, one, "r", "s2", Limits(), ()),
        fingerprint(campaign, one, "r", "s", Limits(apart=3.0), ()),
        fingerprint(replace(campaign, lead=1.0), one, "r", "s", Limits(), ()),
    ]
    assert len(set(prints)) == len(prints)
    assert fingerprint(load(SHIPPED, "elsewhere.yaml"), one, "r", "s", Limits(), ()) == prints[0]


def test_what_was_found_by_a_rule_of_another_requirement_is_found_out_anew(
    campaign: Campaign, bench: Bench
) -> None:
    """The link of a rule is no part of what it means: with another one, a fault that had been found by it counted as found."""
    fault, evaluator = friction(campaign), bench._box.evaluator
    (link, span), *_ = next(rule.satisfies for rule in evaluator.rules if rule.name == "friction")
    assert link == fault.requirement

    def linked(*links: str) -> Evaluator:
        spec = evaluator.spec
        own = {"satisfies": tuple((name, span) for name in links)}
        rules = [RuleInfo(**{**r.__dict__, **own}) if r.name == "friction" else r for r in spec.rules]
        return Evaluator(Spec(**{**spec.__dict__, "rules": tuple(rules)}))

    def known(evaluator: Evaluator) -> str:
        return fingerprint(campaign, fault, "r", "s", Limits(), evaluator.rules)

    other = copy.copy(bench)
    other._box = replace(bench._box, evaluator=linked("S-1-A-5"))
    assert other.run(campaign, fault).wrong == "friction satisfies S-1-A-5, expected S-1-A-4"
    assert known(linked("S-1-A-5")) != known(evaluator)
    assert known(linked("S-1-A-5", link)) == known(evaluator)  # which changes no outcome


def test_the_limits_are_those_of_the_project(campaign: Campaign, tmp_path: Path) -> None:
    """129 samples are too many for the shipped limits, and not for those of a project with longer plans."""
    fault = next(fault for fault in campaign.faults if "More samples than" in fault.title)
    planner = tmp_path / "planner.spec"
    planner.write_text("module planner\nparam samples : 1 = 200\n", encoding="utf-8")
    root = SHIPPED.parents[1]
    spec = load_spec([root / "supervisor"], [root / "tracks" / "northfield.spec", planner])
    made = Bench(scenarios.load(SHIPPED.parent / campaign.recording), Evaluator(spec))
    assert "over_capacity" not in made.run(campaign, fault).by
