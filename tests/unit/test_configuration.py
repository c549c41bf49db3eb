"""Another vehicle is another file: configuration modules replace values of the same name, and nothing else."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import pytest

from support.project import command, run_command
from support.shared import REPOSITORY
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import load

FREE_LAP = REPOSITORY / "specs" / "scenarios" / "free_lap.tmrec.jsonl"
SPEC = """module rules
signal plan : series { t: s increasing, v: m/s }
param v_max : m/s = 50 m/s in [0, 100]
table limit(v: m/s) -> m/s^2 = linear clamp | 0 m/s: 5 m/s^2 |
rule slow for all p in plan require p.v <= v_max
"""


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "rules.spec"
    path.write_text(SPEC, encoding="utf-8")
    return path


def configured(spec: Path, text: str) -> float:
    settings = spec.with_name("vehicle.spec")
    settings.write_text("module vehicle\n" + text, encoding="utf-8")
    return load(spec, [settings]).params["rules.v_max"].value


def test_values_are_replaced_in_si_and_ranges_stay(spec: Path) -> None:
    assert configured(spec, "param v_max : km/h = 36 km/h\n") == 10.0
    assert load(spec).params["rules.v_max"].value == 50.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("param v_mx : m/s = 1 m/s\n", "declares no parameter `v_mx`"),
        ("param v_max : m = 1 m\n", "is in m, the spec declares it in m/s"),
        ("param v_max : m/s = 101 m/s\n", "outside the range"),
        ("table limit(v: m) -> m/s^2 = linear clamp | 0 m: 5 m/s^2 |\n", "other units"),
        ("zone pits = polygon (0 m, 0 m) (1 m, 0 m) (0 m, 1 m)\n", "declares no place `pits`"),
    ],
)
def test_what_does_not_fit_is_refused(spec: Path, text: str, said: str) -> None:
    with pytest.raises(TrackmarshalError, match="E402") as caught:
        configured(spec, text)
    assert said in caught.value.message


def test_a_configuration_changes_the_fingerprint(spec: Path) -> None:
    settings = spec.with_name("vehicle.spec")
    settings.write_text("module vehicle\nparam v_max : m/s = 49 m/s\n", encoding="utf-8")
    assert load(spec, [settings]).fingerprint != load(spec).fingerprint


def test_the_command_line_counts_more_than_the_recording() -> None:
    """The recording is of a car with more grip than the compact one."""
    recording = str(REPOSITORY / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    plain = command(REPOSITORY, "replay", recording)[1]
    compact = command(
        REPOSITORY, "replay", recording, "--with", str(REPOSITORY / "specs" / "vehicles" / "compact.spec")
    )[1]
    assert "friction" not in plain
    assert "friction" in compact


@pytest.mark.parametrize(
    "vehicle", sorted((REPOSITORY / "specs" / "vehicles").glob("*.spec")), ids=lambda path: path.stem
)
def test_gaps_count_on_no_more_than_the_vehicle_can_do(vehicle: Path) -> None:
    """Another vehicle's tyres, brakes and drive train, and not the braking and the response of the one that the rules were written with."""
    spec = load(REPOSITORY / "specs" / "supervisor", [vehicle])
    of = {name.rpartition(".")[2]: info.value for name, info in spec.params.items()}
    grip = of["mu"] * of["g"]
    assert of["b_rear"] <= min(of["b_max"], grip)
    assert of["b_lateral"] <= 0.65 * grip
    assert of["a_loc"] <= grip
    assert max(spec.tables["vehicles.devbot.ax_max"].values) <= of["a_response"]


IGNORED = {
    "rule `slower`": 'rule slower "slower"\n  for all p in plan\n  require p.v <= 1 m/s\n',
    "assumption": 'assume A-SLOW "slow"\n  owner "somebody"\n',
    "constrain": "constrain v_max <= 3 m/s\n",
    "shape `small`": "shape small = { v: m/s }\n",
    "scale": "scale m/s = 3 m/s\n",
    "signal": "signal other : state { v: m/s }\n",
    "event": 'event blue_flag "shown"\n',
    "rulebook": 'rulebook order "order"\n  slow ~ slow\n',
    "test of `slow`": 'test slow "slow"\n  given plan = line(v: 1 m/s, length: 1 m)\n  expect satisfied\n',
    "define `limit`": "define limit(a: m) -> m = a + 1 m\n",
    "predicate `fine`": "predicate fine(a: m) = a < 1 m\n",
}


@pytest.mark.parametrize("what", IGNORED)
@pytest.mark.parametrize("verb", ["eval", "compile", "replay"])
def test_what_would_not_be_in_force_is_refused(what: str, verb: str, spec: Path, tmp_path: Path) -> None:
    """A rule in a configuration demanded nothing, without a word."""
    needs = ("rule `slower`", "rulebook", "test of `slow`")
    # A module that uses another one may not declare a parameter of it again.
    head = "module vehicle\n" + ("use rules\n" if what in needs else "param v_max : m/s = 4 m/s\n")
    (tmp_path / "vehicle.spec").write_text(head + IGNORED[what], encoding="utf-8")
    (tmp_path / "cases.jsonl").write_text('{"signals": {"plan": {"t": [0], "v": [1]}}}\n')
    arguments = {
        "eval": ["eval", str(spec), "--data", str(tmp_path / "cases.jsonl")],
        "compile": ["compile", str(spec), "--out", str(tmp_path / "out")],
        "replay": ["replay", str(FREE_LAP), "--spec", str(spec)],
    }
    status, _, err = run_command(*arguments[verb], "--with", str(tmp_path / "vehicle.spec"))
    assert status == 2
    assert "error[E402]" in err, err
    assert "would not be in force" in err
    assert what in err
    line = head.count("\n") + 1
    assert f"vehicle.spec:{line}" in err
    assert "help: " in err
    assert not (tmp_path / "out").exists()


def test_a_rule_in_a_module_that_a_configuration_uses_is_refused_too(spec: Path, tmp_path: Path) -> None:
    (tmp_path / "more.spec").write_text(SPEC.replace("module rules", "module more").replace("slow", "slower"))
    with pytest.raises(TrackmarshalError, match="E402") as caught:
        configured(spec, "use more\n")
    assert "more.spec" in str(caught.value.file)


def test_a_configuration_may_use_what_its_values_are_made_of(spec: Path, tmp_path: Path) -> None:
    """Definitions that its values need, and a module of the spec itself, whose values stay as they are."""
    assert configured(spec, "define half(a: m/s) -> m/s = a / 2\nparam v_max : m/s = half(60 m/s)\n") == 30.0
    (tmp_path / "base.spec").write_text("module base\nparam w : m = 3 m\nrule odd require w > 1 m\n")
    spec.write_text(SPEC.replace("module rules\n", "module rules\nuse base\n"), encoding="utf-8")
    first = tmp_path / "first.spec"
    first.write_text("module first\nparam w : m = 2 m\n")
    second = tmp_path / "second.spec"
    second.write_text("module second\nuse base\nparam v_max : m/s = 5 * w / 1 s\n")
    made = load(spec, [first, second])
    assert made.params["base.w"].value == 2.0  # not back to 3
    assert made.params["rules.v_max"].value == 15.0


@pytest.mark.parametrize(
    ("slow", "fast"),
    [
        ("param v_max : m/s = 5 m/s", "param v_max : m/s = 49 m/s"),
        ("table grip(v: m/s) -> 1 = linear clamp | 0 m/s: 1 |", "table grip(v: m/s) -> 1 = linear clamp | 0 m/s: 2 |"),
        ("zone pit = polygon (0 m, 0 m) (1 m, 0 m) (1 m, 1 m)", "zone pit = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m)"),
    ],
)  # fmt: skip
def test_a_folder_of_vehicles_is_no_configuration(slow: str, fast: str, tmp_path: Path) -> None:
    """Of two files of a folder that set one name, the last one by their names counted: a car that was partly each of them."""
    spec = tmp_path / "rules.spec"
    spec.write_text(f"{SPEC}{slow}\n".replace("param v_max : m/s = 5 m/s\n", ""), "utf-8")
    cars = tmp_path / "cars"
    cars.mkdir()
    for name, said in (("a", slow), ("b", fast)):
        (cars / f"{name}.spec").write_text(f"module {name}\n{said}\n", "utf-8")
    with pytest.raises(TrackmarshalError, match=r"E402.*is set otherwise at .*b\.spec:2") as found:
        load(spec, [cars])
    assert (found.value.file, found.value.line) == (str(cars / "a.spec"), 2)
    (cars / "b.spec").write_text(f"module b\n{slow}\n", "utf-8")
    assert load(spec, [cars])


def test_of_configurations_that_are_named_one_by_one_the_last_one_counts(spec: Path, tmp_path: Path) -> None:
    for name, speed in (("dry", 49), ("wet", 20)):
        (tmp_path / f"{name}.spec").write_text(f"module {name}\nparam v_max : m/s = {speed} m/s\n", "utf-8")
    dry, wet = tmp_path / "dry.spec", tmp_path / "wet.spec"
    assert load(spec, [dry, wet]).params["rules.v_max"].value == 20.0
    assert load(spec, [wet, dry]).params["rules.v_max"].value == 49.0


def test_a_module_of_the_spec_may_be_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "a.spec").write_text("module a\nparam w : m = 3 m\nrule odd require w > 1 m\n")
    (tmp_path / "b.spec").write_text("module b\nparam w : m = 2 m\nrule even require w > 1 m\n")
    assert load(tmp_path, [tmp_path / "b.spec"]).params["a.w"].value == 2.0


@pytest.mark.parametrize("kind", ["parameter", "table", "place"])
def test_a_name_of_several_modules_that_rules_read_is_refused(kind: str, tmp_path: Path) -> None:
    """What a car is capable of replaced the limit of the pit lane, too: 15 m/s became 50 m/s, without a word."""
    declared, read = {
        "parameter": ("param top : m/s = {} m/s", "ego.v <= top"),
        "table": ("table top(x: m) -> m/s = linear clamp | 0 m: {} m/s |", "ego.v <= top(ego.x)"),
        "place": (
            "zone top = polygon (0 m, 0 m) ({} m, 0 m) (0 m, 9 m)",
            "footprint(ego, 4 m, 2 m) inside top",
        ),
    }[kind]
    ego = "state { x: m, y: m, heading: rad, v: m/s }"
    text = "module {0}\n{1}\nsignal {0}_car : {2}\nrule {0}_slow require {3}\n"
    specs = tmp_path / "specs"
    specs.mkdir()
    for name, value in (("road", 60), ("pit", 15)):
        said = text.format(name, declared.format(value), ego, read.replace("ego", f"{name}_car"))
        (specs / f"{name}.spec").write_text(said, "utf-8")
    (specs / "other.spec").write_text(
        f"module other\n{declared.format(40)}\n", "utf-8"
    )  # which no rule reads
    car = tmp_path / "car.spec"
    car.write_text(f"module car\n{declared.format(50)}\n", "utf-8")
    with pytest.raises(TrackmarshalError, match=f"E402.*{kind} `top` .*`pit.top` and `road.top`"):
        load(specs, [car])
    # Nor does it say which one, by the name of a module of the spec; that module itself stays as it is.
    car.write_text(f"module road\n{declared.format(50)}\n", "utf-8")
    with pytest.raises(TrackmarshalError, match=f"E402.*{kind} `top` .*`pit.top` and `road.top`"):
        load(specs, [car])
    (specs / "pit.spec").unlink()
    assert len(load(specs, [car]).rules) == 1


@pytest.mark.parametrize(
    "slow",
    [
        "param slow : m/s = 0.9 * top",
        "param wet : m/s = 0.8 * top\nparam slow : m/s = min(wet, 10 m/s)",
        'param slow : m/s = 15 m/s\nconstrain top <= 20 m/s because "the lane is narrow"',
    ],
)
def test_what_others_read_for_a_rule_is_read(slow: str, tmp_path: Path) -> None:
    """A rule asks for the limit of the pit lane by what is made of it, or relies on what is to hold of it: it was no longer told from that of the road."""
    specs = tmp_path / "specs"
    specs.mkdir()
    for name, more, limit in (("road", "", "top"), ("pit", slow, "slow")):
        said = f"signal {name}_car : state {{ v: m/s }}\nparam top : m/s = 12 m/s\n{more}\nrule {name} require {name}_car.v <= {limit}\n"
        (specs / f"{name}.spec").write_text(f"module {name}\n{said}", "utf-8")
    car = tmp_path / "car.spec"
    car.write_text("module car\nparam top : m/s = 14 m/s\n", "utf-8")
    with pytest.raises(TrackmarshalError, match=r"E402.*parameter `top` .*`pit\.top` and `road\.top`"):
        load(specs, [car])


def test_what_a_configuration_sets_is_made_of_nothing(tmp_path: Path) -> None:
    """Nobody is left then who would read the other one."""
    specs = tmp_path / "specs"
    specs.mkdir()
    (specs / "road.spec").write_text(SPEC.replace("v_max", "top").replace("rules", "road"), "utf-8")
    pit = "module pit\nevent pit\nparam top : m/s = 12 m/s\nparam slow : m/s = 0.9 * top\nrule calm require pit or slow <= 15 m/s\n"
    (specs / "pit.spec").write_text(pit, "utf-8")
    car = tmp_path / "car.spec"
    car.write_text("module car\nparam top : m/s = 14 m/s\nparam slow : m/s = 11 m/s\n", "utf-8")
    made = load(specs, [car]).params
    assert (made["road.top"].value, made["pit.slow"].value) == (14.0, 11.0)
    # So it is where another configuration sets it, in whichever order they are named.
    lane = tmp_path / "lane.spec"
    lane.write_text("module lane\nparam slow : m/s = 11 m/s\n", "utf-8")
    car.write_text("module car\nparam top : m/s = 14 m/s\n", "utf-8")
    for settings in ([car, lane], [lane, car]):
        made = load(specs, settings).params
        assert (made["road.top"].value, made["pit.slow"].value) == (14.0, 11.0)


TRAJECTORY = "trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }"
CONSTRAINED = SPEC.replace("series { t: s increasing, v: m/s }", TRAJECTORY)
CONSTRAINED += 'param slowest : m/s = 3 m/s\nconstrain slowest <= v_max because "it is the slowest"\n'


def refused(*arguments: str | Path) -> None:
    status, _, err = run_command(*map(str, arguments))
    assert status == 2
    assert "error[E403]" in err, err
    assert "slowest <= v_max" in err


def test_what_breaks_a_constraint_is_not_compiled(tmp_path: Path) -> None:
    """Neither by the spec's own values nor by those of a configuration."""
    (tmp_path / "good.spec").write_text(CONSTRAINED)
    (tmp_path / "bad.spec").write_text(CONSTRAINED.replace("50 m/s", "2 m/s"))
    (tmp_path / "car.spec").write_text("module car\nparam v_max : m/s = 1 m/s\n")
    refused("compile", tmp_path / "bad.spec", "--out", tmp_path / "out")
    refused("compile", tmp_path / "good.spec", "--with", tmp_path / "car.spec", "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    status, _, err = run_command(
        "compile", str(tmp_path / "good.spec"), "--out", str(tmp_path / "out"), "--quiet"
    )
    assert (status, err) == (0, "")


def test_what_breaks_a_constraint_is_not_tested(tmp_path: Path) -> None:
    (tmp_path / "bad.spec").write_text(CONSTRAINED.replace("50 m/s", "2 m/s"))
    status, _, err = run_command("test", str(tmp_path / "bad.spec"))
    assert status == 1
    assert "error[E307]" in err


@pytest.mark.parametrize("verb", ["replay", "explain"])
def test_the_recording_does_not_hide_a_constraint_that_the_command_line_breaks(
    verb: str, tmp_path: Path
) -> None:
    """Its own value would hold, but does not count."""
    head, *cycles = FREE_LAP.read_text().splitlines()
    made = json.loads(head)
    made.update(use=[], params={"v_max": 50.0}, tables={})
    (tmp_path / "run.tmrec.jsonl").write_text("\n".join([json.dumps(made), *cycles[:3]]) + "\n")
    (tmp_path / "good.spec").write_text(CONSTRAINED)
    (tmp_path / "car.spec").write_text("module car\nparam v_max : m/s = 1 m/s\n")
    what = ("--rule", "slow", "--at", "0") if verb == "explain" else ()
    arguments = (verb, tmp_path / "run.tmrec.jsonl", "--spec", tmp_path / "good.spec", *what)
    refused(*arguments, "--with", tmp_path / "car.spec")
    assert run_command(*map(str, arguments))[0] == 0


def test_explain_takes_the_command_lines_values_as_replay_does() -> None:
    """The recording is of a car with more grip than the compact one."""
    recording = str(REPOSITORY / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    compact = ("--with", str(REPOSITORY / "specs" / "vehicles" / "compact.spec"))
    arguments = ("explain", recording, "--rule", "friction", "--at", "11.2", "--candidate", "emergency")
    assert "mu = 1.32517839" in command(REPOSITORY, *arguments)[1]
    assert "mu = 0.9" in command(REPOSITORY, *arguments, *compact)[1]


@pytest.mark.parametrize("begin", [12.3456789, 1790000000.1234567])
def test_the_time_that_explain_proposes_is_one_that_it_takes(tmp_path: Path, begin: float) -> None:
    """Clocks of cars begin anywhere, and do not tick in tenths."""
    head, *cycles = FREE_LAP.read_text(encoding="utf-8").splitlines()
    made = json.loads(head) | {"use": []}
    shifted = [one | {"t": one["t"] + begin} for one in map(json.loads, cycles[:3])]
    run = tmp_path / "run.tmrec.jsonl"
    run.write_text("".join(json.dumps(line) + "\n" for line in [made, *shifted]), encoding="utf-8")
    track = str(REPOSITORY / "specs" / "tracks" / "northfield.spec")
    arguments = ("explain", str(run), "--rule", "friction", "--with", track, "--at")
    proposed = command(REPOSITORY, *arguments, f"{begin + 0.06}")[2].partition("the nearest is at ")[2]
    status, _, err = command(REPOSITORY, *arguments, proposed.split(" s")[0])
    assert status == 0, err
    assert float(proposed.split(" s")[0]) == pytest.approx(begin + 0.1, abs=1e-6)


def test_what_is_named_counts_more_than_a_recording_in_its_cycles_for_c_too(tmp_path: Path) -> None:
    (tmp_path / "rules.spec").write_text(
        "module rules\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        "param v_max : m/s = 50 m/s in [0, 100]\nrule slow for all p in plan require p.v <= v_max\n",
        encoding="utf-8",
    )
    (tmp_path / "vehicle.spec").write_text("module vehicle\nparam v_max : km/h = 36 km/h\n", encoding="utf-8")
    track = {"left": [[0, 5], [50, 5]], "right": [[0, -5], [50, -5]]}
    head = {
        "format": "trackmarshal-recording",
        "version": 1,
        "name": "r",
        "track": track,
        "params": {"v_max": 40},
    }
    still = {name: [0, 0] for name in ("y", "heading", "kappa", "a")}
    plan = {"t": [0, 1], "x": [0, 20], "v": [20, 20], **still}
    ego = {"x": 0, "y": 0, "heading": 0, "v": 20}
    cycle = {"t": 0, "ego": ego, "objects": [], "candidates": {"driving": plan, "emergency": plan}}
    recording = tmp_path / "r.tmrec.jsonl"
    recording.write_text(f"{json.dumps(head)}\n{json.dumps(cycle)}\n", encoding="utf-8")

    def compiled(*more: str) -> float:
        words = [
            "compile",
            str(tmp_path / "rules.spec"),
            "--cycles",
            str(recording),
            "--out",
            str(tmp_path / "c"),
        ]
        assert run_command(*words, *more)[0] == 0
        lines = (tmp_path / "c" / "r.cycles").read_text("utf-8").splitlines()
        (bits,) = [line.split()[1] for line in lines if line.startswith("rules.v_max ")]
        (value,) = struct.unpack(">d", bytes.fromhex(bits.zfill(16)))
        return float(value)

    assert compiled() == 40.0
    assert compiled("--with", str(tmp_path / "vehicle.spec")) == 10.0
