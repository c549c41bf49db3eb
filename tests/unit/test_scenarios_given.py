"""Declarations give any signal that a spec declares, fields of cars, and the truth about single rules; what they cannot mean is refused."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.archives import HEADER, archive, row, scn
from support.length import shared_out
from support.project import run_command
from trackmarshal import scenarios
from trackmarshal.cli.evidence import run_summary
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.runtime.faults import fault
from trackmarshal.scenarios import recording_io
from trackmarshal.scenarios.generate import generate
from trackmarshal.scenarios.generate.document import read
from trackmarshal.scenarios.generate.given import given as read_given
from trackmarshal.scenarios.labels import Label, judged_by, kind_of, label
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import replay

SPEC = """module town

enum flag { green, yellow, red }
enum body { car, truck }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s, load: kg in [0, 500] default 0 kg }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m, body: body default car,
                                 closing: km/h default 0 km/h, near: bool default false }
signal obstacles : set of object { x: m, y: m, heading: rad, length: m, width: m, soft: bool default false }
signal track : corridor { left: polyline, right: polyline }
signal race : state { flag: flag, lap: 1 in [1, 9] default 1, rest: m default 0 m }
signal sectors : set of object { from: m, to: m }
signal wind : series { v: m/s }
signal gate : polyline
event emergency "the candidate is the emergency trajectory"
event rain "it rains"
event fast "it is fast"

define gap(o: point) -> m = sqrt((o.x - ego.x)^2 + (o.y - ego.y)^2)

rule slow_under_yellow "Slow under yellow"
  whenever  race.flag is yellow
  require   ego.v <= 10 m/s

rule apart "Not too near to a truck"
  for all   o in objects where o.body is truck
  require   gap(o) >= 15 m

rule no_rush "No hurry"
  for all   p in plan
  require   p.v <= 60 m/s

assume A-QUIET "Nobody is loud"
  owner     "us"
  evidence  "town.spec"
"""
TRACK = """format: trackmarshal-track
version: 1
name: lane
width: 12
pieces:
  - line: {length: 300}
"""
SCENE = """format: trackmarshal-scenario
version: 1
name: scene
track: lane.yaml
duration: 3
step: 0.5
vehicle: VEHICLE
ego:
  start: {s: 20, d: -2, v: 20}
  fields: {load: 120}
plan: {points: 10, horizon: 2.5}
emergency: {points: 10, deceleration: 9, grip_share: 0.95}
others:
  - id: blue
    start: {s: 60, d: 3, v: 10}
    fields:
      body: truck
      closing: {is: ego.v - o.v}
      near: {is: gap(o) < 25 m}
  - id: grey
    start: {s: 90, d: 3, v: 20}
obstacles:
  - {id: box, s: 200, d: -5, length: 1, width: 1, fields: {soft: true}}
specs: [town.spec]
signals:
  gate: [[150, -6], [150, 6]]
  race:
    fields:
      flag: {at: {0 s: green, 1 s: yellow, 2.5 s: red}}
      lap: 3
      rest: {is: 'distance_to(ego, gate)'}
  sectors: {at: {0 s: [], 2 s: [{id: a, from: 20, to: 50}]}}
  wind: {value: {v: [1, 2, 3]}}
  rain: {at: {0 s: false, 1.5 s: true}}
  fast: {is: 'once[0 s, 1 s] rain and ego.v > 15 m/s'}
truth:
  - {rule: slow_under_yellow, unsafe: [[1, 2]]}
  - {rule: apart, object: blue, unsafe: gap(o) < 15 m}
  - {rule: no_rush, as: static}
"""
VEHICLE = (
    """{length: 4, width: 2, turn_radius: 8, brake: 10, grip: 12, drive: [[0, 6]], params: {}, tables: {}}"""
)


@pytest.fixture(autouse=True)
def town(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("town.spec").write_text(SPEC)
    Path("lane.yaml").write_text(TRACK)


def scene(*changes: tuple[str, str]) -> Recording:
    text = SCENE.replace("VEHICLE", VEHICLE)
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    Path("scene.yaml").write_text(text)
    return generate("scene.yaml")


@pytest.mark.parametrize("after", ["", "\n  rain: false"])
def test_a_record_of_which_no_field_is_given_has_its_defaults_in_each_cycle(after: str) -> None:
    Path("town.spec").write_text(SPEC + "signal crew : state { ready: bool default true }\n")
    rain = "  rain: {at: {0 s: false, 1.5 s: true}}\n"
    fast = "  fast: {is: 'once[0 s, 1 s] rain and ego.v > 15 m/s'}\n"
    recording = scene((rain, ""), (fast, f"  crew: {{fields: {{}}}}{after}\n"))
    assert [round(cycle.t, 6) for cycle in recording.cycles] == [0, 0.5, 1, 1.5, 2, 2.5, 3]
    assert [recording.signals(cycle, "driving")["crew"] for cycle in recording.cycles] == [{}] * 7


def test_each_kind_of_signal_is_given() -> None:
    made = scene()
    times = [cycle.t for cycle in made.cycles]
    assert times == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    flags = [cycle.more["race"]["flag"] for cycle in made.cycles]
    assert flags == ["green", "green", "yellow", "yellow", "yellow", "red", "red"]
    assert [cycle.more["race"]["lap"] for cycle in made.cycles] == [3.0] * 7
    assert [len(cycle.more["sectors"]) for cycle in made.cycles] == [0, 0, 0, 0, 1, 1, 1]
    assert made.always == {"gate": [[150.0, -6.0], [150.0, 6.0]], "wind": {"v": [1.0, 2.0, 3.0]}}
    assert [cycle.more["rain"] for cycle in made.cycles] == [False] * 3 + [True] * 4
    assert [cycle.more["fast"] for cycle in made.cycles] == [False] * 3 + [True] * 4
    for cycle in made.cycles:
        assert cycle.more["race"]["rest"] == pytest.approx(150.0 - cycle.ego["x"], abs=1e-6)
        assert cycle.ego["load"] == 120.0
        blue, grey = cycle.objects
        assert blue["body"] == "truck"
        assert "body" not in grey
        assert blue["closing"] == pytest.approx(3.6 * (cycle.ego["v"] - blue["v"]), abs=1e-6)
        gap = math.hypot(blue["x"] - cycle.ego["x"], blue["y"] - cycle.ego["y"])
        assert blue["near"] is (gap < 25.0)
    assert made.obstacles[0]["soft"] is True
    assert made.params == {}
    assert made.tables == {}


def test_members_by_formulas_are_the_first_that_holds() -> None:
    made = scene(
        ("body: truck", "body: {is: {truck: gap(o) < 25 m, car: otherwise}}"),
        ("{at: {0 s: green, 1 s: yellow, 2.5 s: red}}", "{is: {red: rain, yellow: rain or ego.v > 19.9 m/s, green: otherwise}}"),
        ("  race:", "  rain: {at: {0 s: false, 1.5 s: true}}\n  race:"),
        ("  rain: {at: {0 s: false, 1.5 s: true}}\n  fast", "  fast"),
    )  # fmt: skip
    assert [cycle.more["race"]["flag"] for cycle in made.cycles] == ["yellow"] * 3 + ["red"] * 4
    for cycle in made.cycles:
        blue = cycle.objects[0]
        near = math.hypot(blue["x"] - cycle.ego["x"], blue["y"] - cycle.ego["y"]) < 25.0
        assert blue["body"] == ("truck" if near else "car")
    assert len({cycle.objects[0]["body"] for cycle in made.cycles}) == 2


def test_fields_of_cars_see_the_signals_that_are_given() -> None:
    """As an indicator that goes on where the sign says so; `signals` stands below the cars."""
    made = scene(
        ("{load: 120}", "{load: {is: 'if rain then 50 kg else race.lap * 7 kg'}}"),
        ("      closing: {is: ego.v - o.v}", "      closing: {is: 'if rain then 1 m/s else 2 m/s'}"),
        ("      rest: {is: 'distance_to(ego, gate)'}", "      rest: 4"),
    )
    assert [cycle.ego["load"] for cycle in made.cycles] == [21.0] * 3 + [50.0] * 4
    assert [cycle.objects[0]["closing"] for cycle in made.cycles] == [7.2] * 3 + [3.6] * 4


def test_what_is_not_worked_out_yet_is_said_to_be_that() -> None:
    """It was told that rules never read what is undefined, of a signal that stands there."""
    with pytest.raises(TrackmarshalError, match="fast: it is not there") as raised:
        scene(("{load: 120}", "{load: {is: 'if fast then 50 kg else 0 kg'}}"))
    assert raised.value.code == "D253"
    assert "no field of a car sees a signal of an expression" in (raised.value.help or "")


@pytest.mark.parametrize("name", ["driven", "emergency"])
def test_what_the_supervisor_tells_is_not_given(name: str) -> None:
    """An event of a project may be meant otherwise, as that the driver drives; what was given of it was lost without a word."""
    Path("town.spec").write_text(SPEC + 'event driven "the driver drives"\n')
    with pytest.raises(TrackmarshalError, match=f"`{name}` is told by the Supervisor") as raised:
        scene(("  rain:", f"  {name}: {{at: {{0 s: false, 1 s: true}}}}\n  rain:"))
    assert raised.value.code == "D250"
    assert raised.value.help == "give an event of your own another name"


def test_what_is_given_is_written_in_the_order_of_the_declaration() -> None:
    """What an expression gives comes later, and stands where it stood: the hash of a recording that is made again is the one that runs have."""
    made = scene()
    assert list(made.always) == ["gate", "wind"]
    assert {tuple(cycle.more) for cycle in made.cycles} == {("race", "sectors", "rain", "fast")}


def test_what_is_given_is_written_and_read_again() -> None:
    made = scene()
    again = recording_io.decode("\n".join(recording_io.encode(made)).encode(), "again")
    assert again == made


def test_truths_of_single_rules() -> None:
    made = scene()
    assert made.judged == {"no_rush": "static"}
    assert made.ground_truth["rule slow_under_yellow"] == (True, True, False, False, False, True, True)
    gaps = [math.hypot(c.objects[0]["x"] - c.ego["x"], c.objects[0]["y"] - c.ego["y"]) for c in made.cycles]
    assert made.ground_truth["rule apart for blue"] == tuple(gap >= 15.0 for gap in gaps)
    assert {True, False} == set(made.ground_truth["rule apart for blue"])


def replayed(*changes: tuple[str, str]) -> tuple[int, str]:
    scene(*changes)
    Path("requirements").mkdir(exist_ok=True)
    status, out, err = run_command("replay", "scene.yaml", "--spec", "town.spec", "--quiet")
    return status, out + err


def test_replay_judges_each_rule_by_its_own_truth() -> None:
    status, text = replayed()
    assert status == 0, text
    assert "ground truth, rule slow_under_yellow: inside (7 cycles judged)" in text
    assert "ground truth, rule apart for blue: inside (7 cycles judged)" in text
    assert "ground truth, static: inside" in text
    assert "ground truth, dynamic" not in text  # no rule here is of what the generator knows
    assert "no ground truth was declared" not in text


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        (
            "unsafe: [[1, 2]]",
            "unsafe: [[1, 2.5]]",
            "rule slow_under_yellow: OUTSIDE (7 cycles judged); missed at 2.5",
        ),
        ("unsafe: [[1, 2]]", "unsafe: [[1, 1.5]]", "false alarm at 2"),
        ("unsafe: [[1, 2]]", "unsafe: []", "false alarm at 1 to 2"),
        ("gap(o) < 15 m", "gap(o) < 30 m", "rule apart for blue: OUTSIDE (7 cycles judged); missed at"),
        # Of blue, which is the truck, nothing is said then; nor of the other trajectory.
        ("object: blue, unsafe", "object: grey, unsafe", "no ground truth says that it may be unsafe at"),
        ("slow_under_yellow, ", "slow_under_yellow, candidate: driving, ", "may be unsafe at 1 to 2 s"),
    ],
)
def test_replay_names_what_is_outside(old: str, new: str, part: str) -> None:
    status, text = replayed((old, new))
    assert status == 1, text
    assert part in text


def test_what_is_free_may_be_either() -> None:
    status, text = replayed(("unsafe: [[1, 2]]", "unsafe: [[1.5, 1.5]], free: [[1, 1], [2, 2.5]]"))
    assert status == 0, text
    assert "rule slow_under_yellow: inside (4 cycles judged)" in text


@pytest.mark.parametrize(
    ("truth", "due"),
    [((False, False, False), 3), ((None, False, None), 1), ((None, None, None), 0), ((True, True, False), 1)],
)
def test_a_rule_had_to_fire_where_its_truth_is_unsafe_and_nowhere_else(
    truth: tuple[bool | None, ...], due: int
) -> None:
    """It fires while the flag is yellow, from 1 s to 2 s: by what is left free there, the gate shows nothing (`due`)."""
    made, name = scene(), "rule slow_under_yellow"
    made = replace(made, ground_truth={**made.ground_truth, name: (True, True, *truth, True, True)})
    evaluator = Evaluator(load(["town.spec"]), ["slow_under_yellow"])
    (found,) = run_summary(replay(made, evaluator), evaluator, "scene.yaml", "0" * 64).rules
    assert (found.number("violated"), found.first_violation, found.due) == (6, 1.0, due)


def test_a_rule_of_which_nothing_is_declared_is_named_and_may_not_fire() -> None:
    status, text = replayed(("  - {rule: no_rush, as: static}\n", ""))
    assert status == 0
    assert "no ground truth was declared of no_rush" in text
    status, text = replayed(("  - {rule: slow_under_yellow, unsafe: [[1, 2]]}\n", ""))
    assert status == 1
    assert "no ground truth was declared of slow_under_yellow" in text
    assert "no ground truth says that it may be unsafe at 1 to 2 s" in text


def test_rules_that_are_judged_by_a_kind_leave_others_to_none() -> None:
    """Who says of one rule which kind it is of has said it of that one; of the others, the generator knows nothing."""
    made = replace(scene(), ground_truth={"static": (True,) * 7}, judged={"no_rush": "static"})
    spec = load(["town.spec"])
    judges = {rule.name: judged_by(rule, spec, made) for rule in spec.rules if rule.formula is not None}
    assert judges == {"slow_under_yellow": (), "apart": (), "no_rush": ("static",)}


def test_a_rule_about_what_stands_is_of_the_road() -> None:
    """Sets whose elements have no speed are no other vehicles: the ground truth of these says nothing of them."""
    text = SPEC + '\nrule clear "Clear"\n  for all o in obstacles\n  require o.width <= 3 m\n'
    Path("standing.spec").write_text(text.replace("module town", "module standing"))
    spec = load(["standing.spec"])
    kinds = {rule.name: kind_of(rule, spec) for rule in spec.rules if rule.name in ("clear", "apart")}
    assert kinds == {"clear": "static", "apart": "dynamic"}


def test_a_cycle_that_the_door_refuses_is_not_safe() -> None:
    """Whatever rules say of its candidates: a run in which that happens has not been quiet (`no_fire`)."""
    made = replace(scene(), ground_truth={}, judged={})
    outcome = replay(made, Evaluator(load(["town.spec"]), ["no_rush"]))
    assert not outcome.fired
    refused = replace(outcome.cycles[3], faults=(fault("skipped", "cycle", "number", None, "number 4"),))
    assert replace(outcome, cycles=(*outcome.cycles[:3], refused)).fired


def test_a_truth_of_a_rule_that_the_spec_lacks_is_refused() -> None:
    scene()
    Path("other.spec").write_text(
        SPEC.replace("module town", "module other").replace("rule apart", "rule far")
    )
    status, _, err = run_command("replay", "scene.yaml", "--spec", "other.spec")
    assert status == 2
    assert "D256" in err
    assert "apart" in err


@pytest.mark.parametrize(
    ("about", "part"),
    [
        ("apart for bleu", "`rule apart for bleu`, and no cycle has `bleu`"),
        ("no_rush of emergency", "`rule no_rush of emergency`, and no cycle has `emergency`"),
    ],
)
def test_a_truth_about_what_is_in_no_cycle_is_refused(about: str, part: str) -> None:
    """Nothing is ever against what is not there: the run was inside, and the rule was judged in every cycle."""
    made = scene()
    cycles = tuple(replace(one, candidates={"driving": one.candidates["driving"]}) for one in made.cycles)
    truth: dict[str, tuple[bool | None, ...]] = {f"rule {about}": (True,) * len(cycles)}
    made = replace(made, cycles=cycles, ground_truth=truth, judged={})
    with pytest.raises(TrackmarshalError, match=re.escape(part)) as caught:
        replay(made, Evaluator(load(["town.spec"])))
    assert caught.value.code == "D255"


@pytest.mark.parametrize(
    ("truth", "inside"),
    [((True,) * 7, None), ((True, None) + (True,) * 5, None), ((True,) * 6 + (False,), False)],
)
def test_what_judges_none_of_the_rules_is_no_evidence(
    truth: tuple[bool | None, ...], inside: bool | None
) -> None:
    """Of a spec without a rule about others, a truth about these was kept in all cycles, as in a run that was judged; one that asks for a rule is missed."""
    made = replace(scene(), ground_truth={"dynamic": truth}, judged={})
    outcome = replay(made, Evaluator(load(["town.spec"]), ["no_rush"]))
    assert [(one.kind, one.inside) for one in outcome.truths] == (
        [] if inside is None else [("dynamic", inside)]
    )
    assert outcome.met is (inside is None)
    assert outcome.uncovered == ("no_rush",)
    gone = replace(made.cycles[1], candidates={"driving": made.cycles[1].candidates["driving"]})
    lacking = replace(made, cycles=(made.cycles[0], gone, *made.cycles[2:]))
    unexpected = replay(lacking, Evaluator(load(["town.spec"]), ["no_rush"])).unexpected
    assert unexpected == (() if truth[1] is None else (gone.t,))


def test_a_rule_that_is_not_chosen_is_not_judged() -> None:
    scene()
    status, out, _ = run_command("replay", "scene.yaml", "--spec", "town.spec", "--rule", "apart", "--quiet")
    assert status == 0
    assert "slow_under_yellow" not in out


def test_a_vehicle_of_numbers_says_that_it_overrides_nothing() -> None:
    """Nobody wrote the names that it overrides otherwise: what is refused says where they come from."""
    status, text = replayed((", params: {}, tables: {}", ""))
    assert status == 2
    assert "D203" in text
    assert "`params: {}` in it for nothing" in text


def test_a_vehicle_of_its_own_file() -> None:
    body = VEHICLE.strip("{}").replace(", ", "\n").replace("length", "length", 1)
    Path("racer.yaml").write_text(
        "format: trackmarshal-vehicle\nversion: 1\nlength: 5\nwidth: 2\nturn_radius: 8\nbrake: 10\ngrip: 12\n"
        "drive: [[0, 6]]\nparams: {}\ntables: {}\n"
    )
    assert body
    made = scene((VEHICLE, "racer.yaml"), ("  - id: grey\n", f"  - id: grey\n    vehicle: {VEHICLE}\n"))
    assert [each["length"] for each in made.cycles[0].objects] == [5.0, 4.0]


REFUSED: list[tuple[str, str, str, str]] = [
    ("specs: [town.spec]\n", "", "D151", "no spec says what this is"),
    ("[town.spec]", "[/town.spec]", "D151", "no path of a spec"),
    ("[town.spec]", "[lane.yaml]", "D151", "no path of a spec"),
    ("[town.spec]", "[city.spec]", "D151", "not there"),
    ("  wind:", "  winds:", "D250", "`winds` is declared nowhere"),
    ("  wind:", "  ego:", "D250", "has its own place"),
    ("      lap: 3", "      laps: 3", "D250", "`laps` is declared nowhere as a field of `race`"),
    ("      body: truck", "      v: 3", "D250", "comes from the car's motion"),
    ("      body: truck", "      body: {is: ego.v}", "D250", "a member of an enumeration"),
    ("wind: {value: {v: [1, 2, 3]}}", "wind: {fields: {v: 3}}", "D250", "no fields that are given one by one"),
    ("wind: {value: {v: [1, 2, 3]}}", "wind: {is: ego.v}", "D250", "no value for the whole signal"),
    ("wind: {value: {v: [1, 2, 3]}}", "wind: {is: {a: ego.v > 1 m/s, b: otherwise}}", "D250", "no value for the whole"),
    ("lap: 3", "lap: {is: {a: ego.v > 1 m/s, b: otherwise}}", "D250", "`lap` has no members"),
    ("fast: {is: 'once[0 s, 1 s] rain and ego.v > 15 m/s'}", "fast: {is: {a: rain, b: otherwise}}", "D250", "`fast` has no members"),
    ("body: truck", "body: {is: {trucks: ego.v > 1 m/s, car: otherwise}}", "D250", "`trucks` is no member of"),
    ("body: truck", "body: {is: {truck: ego.v > 1 m/s, car: gap(o) < 25 m}}", "D251", "which member there is when no"),
    ("body: truck", "body: {is: {truck: otherwise, car: otherwise}}", "D251", "which member there is when no"),
    ("body: truck", "body: {is: {}}", "D251", "which member there is when no"),
    ("body: truck", "body: {is: {truck: gap(o), car: otherwise}}", "D252", "the expression has no meaning"),
    ("soft: true", "soft: {is: ego.v > 1 m/s}", "D151", "same in all cycles"),
    ("wind: {value: {v: [1, 2, 3]}}", "wind: {v: [1, 2, 3]}", "D151", "not said how the value is given"),
    ("rest: {is: 'distance_to(ego, gate)'}", "rest: {is: ego.v, at: {0 s: 1}}", "D151", "not said how"),
    ("{at: {0 s: false, 1.5 s: true}}", "{at: {1 s: false}}", "D251", "what holds before is not said"),
    ("{at: {0 s: false, 1.5 s: true}}", "{at: {0 s: false, 0.0 s: true}}", "D251", "does not come after"),
    ("{at: {0 s: false, 1.5 s: true}}", "{at: {0 s: false, 1500 ms: true}}", "D251", "`1500 ms` is no time"),
    ("{at: {0 s: false, 1.5 s: true}}", "{at: {}}", "D251", "the table is empty"),
    # What no cycle has went unheard: it never rained.
    ("{at: {0 s: false, 1.5 s: true}}", "{at: {0 s: false, 3.1 s: true}}", "D251", "no cycle has the value from 3.1 s on"),
    ("{at: {0 s: false, 1.5 s: true}}", "{at: {0 s: false, 1.6 s: true, 1.9 s: false}}", "D251", "no cycle has the value from 1.6 s on"),
    ("{is: ego.v - o.v}", "{is: ego.v - o.w}", "D252", "no field `w`"),
    ("{is: ego.v - o.v}", "{is: gap(o)}", "D252", "the expression has no meaning"),
    ("{is: ego.v - o.v}", "{is: ego.v -}", "D252", "the expression has no meaning"),
    ("{is: ego.v - o.v}", "{is: 1 m/s * (ego.v / (o.v - o.v))}", "D253", "no value at t = 0 s"),
    ("{is: 'once[0 s, 1 s] rain and ego.v > 15 m/s'}", "{is: 'eventually[0 s, 1 s] rain'}", "D253", "looks ahead"),
    ("      lap: 3", "      lap: 12", "D254", "at t = 0 s"),
    ("      lap: 3", "      lap: true", "D254", "at t = 0 s"),
    ("2.5 s: red", "2.5 s: blue", "D254", "at t = 2.5 s"),
    ("body: truck", "body: bus", "D254", "at t = 0 s"),
    ("{load: 120}", "{load: 501}", "D254", "at t = 0 s"),
    ("from: 20, to: 50}", "from: 20}", "D254", "at t = 2 s"),
    ("rule: apart", "rule: aparts", "D255", "no rule of the specs"),
    ("rule: no_rush", "rule: A-QUIET", "D255", "without a monitor"),
    ("object: blue, unsafe", "object: bleu, unsafe", "D255", "no object `bleu`"),
    ("unsafe: [[1, 2]]", "free: [[1, 2]]", "D255", "not said when the rule has to fire"),
    ("unsafe: [[1, 2]]", "unsafe: [[1, 2]], free: [[2, 3]]", "D255", "it is free, and unsafe"),
    ("unsafe: [[1, 2]]", "unsafe: [[1.1, 1.2]]", "D255", "no cycle lies in this stretch"),
    ("unsafe: [[1, 2]]", "unsafe: [[2, 1]]", "D151", "no stretch"),
    ("unsafe: [[1, 2]]", "candidate: mine, unsafe: [[1, 2]]", "D151", "`mine` is not known"),
    ("as: static}", "as: static, unsafe: []}", "D255", "`as` stands beside"),
    ("as: static}", "as: statics}", "D151", "`statics` is not known"),
    ("rule: apart, object: blue, unsafe: gap(o) < 15 m", "rule: no_rush, unsafe: []", "D255", "given twice"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "code", "part"), shared_out(REFUSED, 3))
def test_what_cannot_be_meant_is_refused(old: str, new: str, code: str, part: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        scene((old, new))
    assert caught.value.code == code, str(caught.value)
    assert part in caught.value.message, str(caught.value)
    assert caught.value.file == "scene.yaml"
    assert caught.value.line is not None


def test_errors_of_the_named_specs_are_said() -> None:
    Path("town.spec").write_text(SPEC + '\nrule broken "x"\n  require 1 m < 1 s\n')
    with pytest.raises(TrackmarshalError) as caught:
        scene()
    assert caught.value.code == "D252"
    assert "town.spec" in caught.value.message


rows = st.lists(st.tuples(st.integers(1, 60), st.integers(-9, 9)), max_size=6, unique_by=lambda row: row[0])


@given(rows, st.integers(0, 70))
@settings(deadline=None)
def test_a_table_holds_the_last_row_that_has_begun(table: list[tuple[int, int]], tenths: int) -> None:
    table = [(0, 5), *sorted(table)]
    text = "at: {" + ", ".join(f"{t / 10:g} s: {value}" for t, value in table) + "}"
    found = read_given("x", read(text.encode(), "x.yaml")).at(tenths / 10)
    assert found == [value for t, value in table if t <= tenths][-1]


def test_the_first_row_holds_before_zero_too() -> None:
    """Stamps of an archive may be negative: there, the last row held."""
    assert read_given("x", read(b"at: {0 s: 5, 3 s: 6}", "x.yaml")).over([-1.0, 0.0, 3.0]) == [5, 5, 6]


@pytest.mark.parametrize(
    ("table", "part", "help_"),
    [
        ("{0 s: 5, 12 s: 6}", "from 0 s on", "the first row is what holds in the first cycle"),
        ("{0 s: 5, 1700000001 s: 6}", "from 1700000001 s on", "move the row, or leave it out"),
    ],
)
def test_a_row_of_no_cycle_is_told_stamps_that_count_from_1970(table: str, part: str, help_: str) -> None:
    """They were 1.7e+09; and the row of `0 s`, which cannot be left out, was to be."""
    with pytest.raises(TrackmarshalError, match=part) as caught:
        read_given("x", read(f"at: {table}".encode(), "x.yaml")).over([1.7e9, 1.7e9 + 0.5])
    assert caught.value.help == f"cycles are from 1700000000 to 1700000000.5 s: {help_}"


words = st.text(st.characters(blacklist_categories=["Cs", "Z", "Cc"]), min_size=1, max_size=5)


@given(words, st.sampled_from(["", "driving", "emergency"]), st.text(min_size=0, max_size=9))
def test_labels_are_read_as_they_are_written(rule: str, candidate: str, about: str) -> None:
    made = Label(rule, candidate, about)
    if not any(each.isspace() for each in rule):
        assert label(str(made)) == made


@pytest.mark.parametrize(
    "name", ["dynamic", "static", "rule", "rule ", "rule a of nobody", "rule a for ", "rule a b"]
)
def test_other_names_are_no_labels(name: str) -> None:
    assert label(name) is None


# Archives ---------------------------------------------------------------------------------------------------------

ARCHIVED = """format: trackmarshal-archive
version: 1
name: packed
archive: scene.saa
specs: [town.spec]
ego: {load: {column: load}}
signals:
  race: {fields: {flag: {column: flag}, lap: 2}}
  sectors: {column: sectors}
  rain: {at: {0 s: false, 0.1 s: true}}
  fast: {is: rain and ego.v > 5 m/s}
truth:
  - {rule: slow_under_yellow, unsafe: []}
  - {rule: apart, as: dynamic}
  - {rule: no_rush, as: static}
"""


def packed(*changes: tuple[str, str], loads: tuple[str, str] = ("1", "2")) -> Recording:
    header = f"{HEADER};load;flag;sectors;note"
    rows = [
        f'{row(0.1 * i)};{load};"{flag}";[{{"from": {i}, "to": 9}}];of no use'
        for i, (load, flag) in enumerate(zip(loads, ("green", "yellow")))
    ]
    Path("scene.saa").write_bytes(archive(scn(*rows, header=header)))
    text = ARCHIVED
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    Path("packed.yaml").write_text(text)
    return scenarios.load("packed.yaml")


def test_an_archive_with_signals_of_its_own() -> None:
    made = packed()
    assert made.name == "packed"
    assert [cycle.more["race"] for cycle in made.cycles] == [
        {"flag": "green", "lap": 2.0},
        {"flag": "yellow", "lap": 2.0},
    ]
    assert [cycle.more["sectors"][0]["from"] for cycle in made.cycles] == [0.0, 1.0]
    assert [cycle.ego["load"] for cycle in made.cycles] == [1.0, 2.0]
    assert [(cycle.more["rain"], cycle.more["fast"]) for cycle in made.cycles] == [
        (False, False),
        (True, True),
    ]
    assert made.notes[0] == "column `note` is not known here and was not read"
    assert made.judged == {"apart": "dynamic", "no_rush": "static"}
    assert made.ground_truth["dynamic"] == (True, True)
    assert made.ground_truth["rule slow_under_yellow"] == (True, True)
    assert recording_io.decode("\n".join(recording_io.encode(made)).encode(), "again") == made


@pytest.mark.parametrize(
    ("old", "new", "code", "part"),
    [
        ("archive: scene.saa", "archive: /scene.saa", "D151", "no path of an archive"),
        ("archive: scene.saa", "archive: other.saa", "D120", "No such file"),
        ("archive: scene.saa", "archive: scene.saa\nsha256: abc", "D175", "its hash is another"),
        ("specs: [town.spec]", "specs: []", "D151", "no spec is named"),
        ("{column: load}", "{column: loads}", "D151", "there is no column `loads`"),
        ("{column: load}", "{column: time}", "D151", "there is no column `time`"),
        ("{column: load}", "{column: note}", "D128", "note:"),
        ("{column: load}", "{column: flag}", "D254", "at t = 0 s"),
        ("{column: flag}", "{column: load}", "D254", "at t = 0 s"),
        ("rule: apart", "rule: aparts", "D255", "no rule of the specs"),
    ],
)
def test_archives_that_do_not_fit_are_refused(old: str, new: str, code: str, part: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        packed((old, new), loads=("17", "2"))
    assert caught.value.code == code, str(caught.value)
    assert part in caught.value.message, str(caught.value)


def test_a_missing_number_of_an_archive_breaks_the_contract() -> None:
    with pytest.raises(TrackmarshalError) as caught:
        packed(loads=("1", "null"))
    assert caught.value.code == "D254"
    assert "at t = 0.1 s" in caught.value.message


def test_a_generated_scenario_has_no_columns() -> None:
    with pytest.raises(TrackmarshalError) as caught:
        scene(("      lap: 3", "      lap: {column: lap}"))
    assert caught.value.code == "D151"
    assert "there is no column `lap`" in caught.value.message


def test_a_state_that_is_given_without_a_word_is_told_of_fields() -> None:
    with pytest.raises(TrackmarshalError) as raised:
        scene(("    fields:\n      flag:", "      flag:"))
    assert raised.value.code == "D151"
    assert "`fields`" in (raised.value.help or "")
