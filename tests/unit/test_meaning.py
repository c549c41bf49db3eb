"""What results rest on: one changed comparison makes stale what rests on it and nothing else, and layout nothing at all."""

from __future__ import annotations

import re
import shutil
from functools import cache
from pathlib import Path

import pytest

from support.length import shared_out
from support.shared import REPOSITORY
from support.supervised import everything
from trackmarshal.cli.evidence import run_inputs, spec_items, spec_parts
from trackmarshal.cli.project import spec_folders
from trackmarshal.cli.sources import read_specs
from trackmarshal.evaluation import Evaluator, load, loads
from trackmarshal.ir.spec import Spec
from trackmarshal.meaning import Meaning, fingerprint_of_test, key
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.trace import requirements
from trackmarshal.trace.spec import changed as why_stale

Prints = dict[tuple[str, ...], str]


def prints(root: Path) -> tuple[Prints, Spec]:
    """What every rule and every test of a project rests on, as one hash each."""
    compiled, prepared, found = read_specs(root, requirements.load(root, []))
    assert [item for item in found if item.level == "error"] == []
    meaning = Meaning(compiled.spec)
    rules: Prints = {("rule", rule.name): meaning.fingerprint(rule) for rule in compiled.spec.rules}
    tests: Prints = {
        ("test", t.rule.name, t.title): key({**meaning.rule(t.rule), "test": fingerprint_of_test(t)})
        for t in prepared
    }
    return {**rules, **tests}, compiled.spec


@cache
def shipped() -> tuple[Prints, Spec]:
    return prints(REPOSITORY)


def copy(tmp_path: Path) -> Path:
    for name in ("specs", "requirements"):
        shutil.copytree(REPOSITORY / name, tmp_path / name)
    return tmp_path


def changed(before: Prints, after: Prints) -> set[tuple[str, ...]]:
    return {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}


def replaced(path: Path, old: str, new: str) -> None:
    text = path.read_text("utf-8")
    assert text.count(old) == 1, (path, old, text.count(old))
    path.write_text(text.replace(old, new), "utf-8")


@pytest.mark.parametrize("read", ["top", "brakes(ego.v)"])
def test_a_rule_rests_on_the_constraints_on_what_it_reads(read: str) -> None:
    """Data that brings a table, or a parameter, that breaks one of them is not safe."""

    def of(top: int, brakes: int) -> str:
        spec = loads(
            "module made\nsignal ego : state { v: m/s }\nparam top : m/s = 9 m/s\ntable brakes(v: m/s) -> m/s = linear clamp | 0 m/s: 9 m/s |\n"
            f"constrain top >= {top} m/s\nconstrain brakes(0 m/s) >= {brakes} m/s\n"
            f'rule r "r"\n  require ego.v <= {read}\n'
        )
        return Meaning(spec).fingerprint(spec.rules[0])

    assert (of(8, 7) != of(6, 7)) == (read == "top")
    assert (of(8, 7) != of(8, 5)) == (read != "top")


#: Those in the folders that v-model.yaml names: it leaves out a rulebook.
FOLDERS = spec_folders(REPOSITORY)
RULES = [
    rule.name
    for rule in everything().rules
    if rule.formula is not None
    and any(folder in (REPOSITORY / rule.span.file.path).parents for folder in FOLDERS)
]


@pytest.mark.parametrize("name", shared_out(RULES, 32))
def test_a_changed_rule_makes_stale_its_own_tests(name: str, tmp_path: Path) -> None:
    before, spec = shipped()
    rule = spec.rule(name)
    assert rule is not None
    path = copy(tmp_path) / rule.span.file.path
    clause = "monitor" if rule.kind == "assume" else "require"
    head, found, rest = rule.text.partition(f"\n  {clause} ")
    assert found, rule.text
    compared = re.search(r" (<=|>=|<|>) ", rest)
    if compared:
        other = {"<=": "<", ">=": ">", "<": "<=", ">": ">="}[compared[1]]
        rest = rest[: compared.start()] + f" {other} " + rest[compared.end() :]
    elif " in [" in rest:
        where, _, ends = rest.partition(" in [")
        rest = f"not ({where} in [" + ends.replace("]", "])", 1)
    else:  # one that asks where something is
        rest = re.sub(r"((?:\w|[.])+\([^()]*(?:\([^()]*\)[^()]*)*\)[^\n]*)", r"not (\1)", rest, count=1)
    replaced(path, rule.text, head + found + rest)
    after, _ = prints(tmp_path)
    assert changed(before, after) == {
        ("rule", name), *(test for test in before if test[:2] == ("test", name))
    }  # fmt: skip


def test_what_means_the_same_makes_nothing_stale(tmp_path: Path) -> None:
    path = copy(tmp_path) / "specs/supervisor/trajectory.spec"
    rule = shipped()[1].rule("friction")
    assert rule is not None
    replaced(path, f'"{rule.title}"', '"another title"')
    text = path.read_text("utf-8").replace("\n\n", "\n\n\n").replace("  require ", "  require\n    ")
    path.write_text("-- a comment\n" + text, "utf-8")
    assert changed(shipped()[0], prints(tmp_path)[0]) == set()


def test_a_parameter_is_noticed_where_it_is_read(tmp_path: Path) -> None:
    root = copy(tmp_path)
    spec = shipped()[1]
    path = root / spec.params["vehicles.devbot.mu"].span.file.path
    text = path.read_text("utf-8")
    line = next(line for line in text.splitlines() if line.startswith("param mu "))
    path.write_text(text.replace(line, re.sub(r"= *[0-9.]+", "= 1.3", line, count=1)), "utf-8")
    stale = changed(shipped()[0], prints(root)[0])
    assert ("rule", "friction") in stale
    assert ("rule", "turn_radius") not in stale
    named = {one[1] for one in stale}
    assert named == {
        rule.name for rule in spec.rules if "param vehicles.devbot.mu" in Meaning(spec).rule(rule)
    }


def test_the_contract_of_a_signal_is_noticed(tmp_path: Path) -> None:
    root = copy(tmp_path)
    spec = shipped()[1]
    field = spec.field("plan", "grip")
    assert field is not None
    path = root / field.span.file.path
    text = path.read_text("utf-8").splitlines(keepends=True)
    line = text[field.span.line - 1]
    text[field.span.line - 1] = line.replace("[0, 1]", "[0, 0.9]").replace("default 1", "default 0.9")
    assert text[field.span.line - 1] != line
    path.write_text("".join(text), "utf-8")
    stale = {name[1] for name in changed(shipped()[0], prints(root)[0])}
    assert stale == {rule.name for rule in spec.rules if any(of == "plan" for of, _ in rule.reads)}


def test_the_text_of_a_test_is_noticed_and_its_layout_is_not(tmp_path: Path) -> None:
    root = copy(tmp_path)
    path = root / "specs/supervisor/conduct.spec"
    text = path.read_text("utf-8")
    first = re.search(r'test speed_limit "([^"]*)"\n(.*?)\n\n', text, re.S)
    assert first is not None
    body = first[0]
    assert "expect satisfied" in body
    path.write_text(text.replace(body, body.replace("expect satisfied", "expect   violated")), "utf-8")
    assert changed(shipped()[0], prints(root)[0]) == {("test", "speed_limit", first[1])}
    path.write_text(
        text.replace(body, body.replace("\n", "\n\n", 1).replace("  given ", "    given ")), "utf-8"
    )
    assert changed(shipped()[0], prints(root)[0]) == set()


def test_a_rule_that_reads_what_has_an_error(tmp_path: Path) -> None:
    """Its parameter is no number of its dimension, which is said; that the rule reads it is no reason to break down."""
    path = tmp_path / "m.spec"
    path.write_text(
        'module m\nsignal ego : state { v: m/s }\nparam top : m/s = 3\nrule slow "s"\n  require ego.v <= top\n',
        "utf-8",
    )
    compiled = compile_paths([path], tmp_path)
    assert [one.code for one in compiled.found if one.level == "error"] == ["E302"]
    assert "param m.top" in Meaning(compiled.spec).rule(compiled.spec.rules[0])


#: Rules of which each rests on something of its own.
THINGS = """module own
enum flag { green, yellow, red }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal race : state { flag: flag }
signal rain : state { fall: 1 in [0, 9] }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m } capacity 4 forget 0.3 s
param most : m/s = 30 m/s in [1, 90]
constrain most <= 80 m/s because "no faster"
table sheet(x: m) -> m/s = linear clamp | 0 m: 5 m/s | 9 m: 6 m/s |
zone pit "a square" = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m) (0 m, 9 m)
course driven = ego for 0.4 s then plan
define faster(v: m/s) -> m/s = v * 1.1
rule limited "by a parameter" require ego.v <= most
rule listed "by a table" require ego.v <= sheet(ego.x)
rule parked "in a zone" require ego in zone pit
rule flagged "under a flag" whenever race.flag is yellow require ego.v <= 9 m/s
rule warned "of no weight" severity advisory require ego.v <= 10 m/s
rule worded "by a definition" require faster(ego.v) <= 11 m/s
rule dry "in the dry" require rain.fall <= 3
rule lived "along a course" along driven as c require historically[0 s, 0.3 s] c.v <= 24 m/s
rule apart "from each" for all o in objects require historically o.x >= 3 m
"""


@pytest.mark.parametrize(
    ("old", "new", "stale"),
    [
        ("30 m/s in", "31 m/s in", {"limited"}),
        ("[1, 90]", "[1, 95]", {"limited"}),
        ("most <= 80", "most <= 85", {"limited"}),
        ("9 m: 6 m/s", "9 m: 7 m/s", {"listed"}),
        ("linear clamp", "linear", {"listed"}),
        ("(9 m, 9 m)", "(9 m, 8 m)", {"parked"}),
        ("green, yellow, red", "yellow, green, red", {"flagged"}),
        ("green, yellow, red", "green, yellow, red, blue", {"flagged"}),
        ("severity advisory ", "", {"warned"}),
        ("v * 1.1", "v * 1.2", {"worded"}),
        ("[0, 9]", "[0, 8]", {"dry"}),
        ("for 0.4 s then", "for 0.5 s then", {"lived"}),
        ("forget 0.3 s", "forget 0.2 s", {"apart"}),
        ("capacity 4", "capacity 5", {"apart"}),
        ("a square", "four corners", set()),
        ("no faster", "that is enough", set()),
        ("by a parameter", "by a number", set()),
    ],
)
def test_whatever_a_rule_rests_on_makes_it_stale_and_no_other(old: str, new: str, stale: set[str]) -> None:
    assert THINGS.count(old) == 1

    def read(text: str) -> dict[str, str]:
        meaning = Meaning(loads(text))
        return {rule.name: meaning.fingerprint(rule) for rule in meaning.spec.rules}

    before, after = read(THINGS), read(THINGS.replace(old, new))
    assert {name for name in before if before[name] != after[name]} == stale


def test_runs_rest_on_the_recording_what_it_names_and_the_limits(tmp_path: Path) -> None:
    """Each by itself, beside the rules; what a Supervisor is held to is declared by the project."""

    def inputs(limit: str, *given: str) -> dict[str, str]:
        (tmp_path / "own.spec").write_text(
            "module own\nuse supervisor.limits\nsignal ego : state { v: m/s }\nrule slow\n  require ego.v <= 9 m/s\n",
            "utf-8",
        )
        (tmp_path / "supervisor").mkdir(exist_ok=True)
        (tmp_path / "supervisor" / "limits.spec").write_text(
            f"module supervisor.limits\nparam start_distance : m = {limit}\n", "utf-8"
        )
        return run_inputs(Evaluator(load(tmp_path)), *given)

    before = inputs("0.1 m", "a", "b")
    assert why_stale(before, inputs("0.1 m", "a", "b")) == ""
    assert why_stale(before, inputs("0.2 m", "a", "b")) == "the limits of the Supervisor have changed since"
    assert why_stale(before, inputs("0.1 m", "c", "b")) == "the recording has changed since"
    assert why_stale(before, inputs("0.1 m", "a", "c")) == "a file that the scenario names has changed since"


def test_what_every_cycle_is_held_against_is_noticed_where_no_rule_reads_it() -> None:
    """Of a project whose rules read the plan alone, runs held on when the range of the car's own speed became one that their cycles break."""

    def inputs(most: int, demand: str) -> dict[str, str]:
        text = "module own\nsignal plan : trajectory { t: s, x: m, y: m, heading: rad, v: m/s }\n"
        text += f"signal ego : state {{ x: m, y: m, heading: rad, v: m/s in [0, {most}] }}\n"
        return run_inputs(Evaluator(loads(f"{text}rule slow\n  require {demand} <= 9 m/s\n")), "recording")

    wide, narrow = (inputs(most, "plan.first.v") for most in (150, 5))
    assert why_stale(wide, narrow) == "the signal `ego` has changed since"
    assert (
        why_stale(*(inputs(most, "plan.first.v + ego.v") for most in (150, 5)))
        == "the rule `slow` has changed since"
    )
    assert inputs(150, "ego.v").keys() >= {"signal plan"}


def test_the_unit_in_which_a_condition_is_told_is_noticed_where_no_rule_reads_it() -> None:
    """`rain.fallen` from 0 to 50 mm was reached by a recording of 5 that was made when 5 were cm, and went on being so."""

    def inputs(unit: str, recording: str | None) -> dict[str, str]:
        text = f"module own\nsignal ego : state {{ v: m/s }}\nsignal rain : state {{ fallen: {unit} }}\n"
        return run_inputs(Evaluator(loads(f"{text}rule slow\n  require ego.v <= 9 m/s\n")), recording)

    assert why_stale(inputs("cm", "a"), inputs("mm", "a")) == "the signal `rain` has changed since"
    assert inputs("mm", "a") == inputs("mm", "a")
    assert inputs("cm", None) == inputs("mm", None)


def test_a_kept_run_rests_on_what_its_vehicle_brakes_with() -> None:
    """The emergency trajectories of a log are made with it, and no rule need read it; other values of the vehicle make nothing."""

    def inputs(drag: str, doors: int, recording: str | None) -> dict[str, str]:
        text = f"module own\nparam mu : 1 = 0.9\nparam drag : kg/m = {drag}\nparam doors : 1 = {doors}\nsignal ego : state {{ v: m/s }}\n"
        return run_inputs(Evaluator(loads(f"{text}rule slow\n  require ego.v <= mu * 9 m/s\n")), recording)

    kept = inputs("0.5 kg/m", 4, None)
    assert kept.keys() == {"rule slow", "param own.drag"}  # what a rule reads is in what the rule rests on
    assert why_stale(kept, inputs("0.9 kg/m", 4, None)) == "the parameter `own.drag` has changed since"
    assert kept == inputs("0.5 kg/m", 2, None)
    assert inputs("0.5 kg/m", 4, "a") == inputs("0.9 kg/m", 4, "a")  # of recordings, trajectories are there


def test_what_every_cycle_is_held_against_is_held_by_the_baseline() -> None:
    """Its ranges could be taken away without a word, as no rule read them: the gate stayed open."""

    def parts(contract: str) -> dict[str, str]:
        text = "module own\nsignal plan : trajectory { t: s, x: m, y: m, heading: rad, v: m/s }\n"
        text += f"signal ego : state {{ x: m, y: m, heading: rad, v: m/s {contract} }}\nsignal rain : state {{ mm: 1 }}\n"
        spec = loads(f"{text}rule slow\n  require plan.first.v <= 9 m/s\n")
        found = spec_parts(spec, spec_items(Meaning(spec)))
        return {part.name: part.fingerprint for part in found if part.kind == "signal"}

    held, left_out = parts("in [0, 9]"), parts("")
    assert held.keys() == {"plan", "ego"}
    assert {name for name in held if held[name] != left_out[name]} == {"ego"}


def test_a_rule_that_the_ground_truth_no_longer_judges_makes_runs_stale(tmp_path: Path) -> None:
    """The generator knows rules by the first name of their module, which is no part of what a rule means: of one that had moved, a kept run still counted."""

    def inputs(module: str, rule: str = "slow") -> dict[str, str]:
        path = tmp_path / Path(*module.split(".")).with_suffix(".spec")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(
            f"module {module}\nsignal ego : state {{ v: m/s }}\nrule {rule}\n  require ego.v <= 9 m/s\n",
            "utf-8",
        )
        return run_inputs(Evaluator(load(path)), "recording")

    before, moved = inputs("supervisor.own"), inputs("own.rules")
    said = "which rules the ground truth of generated recordings judges has changed since"
    assert why_stale(before, moved) == said
    assert {name for name in before if before[name] != moved[name]} == {"judged"}
    assert inputs("supervisor.others") == before
    assert run_inputs(Evaluator(load(tmp_path / "own" / "rules.spec")), None).keys() == {"rule slow"}
