"""`init` and `new`: what they write is right at once, and nothing that is there is touched."""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path

import pytest
import yaml

from support import start
from support.project import run_command
from support.shared import REPOSITORY
from trackmarshal.cli.main import main
from trackmarshal.start.project import BASELINE, FILES, WORKFLOW
from trackmarshal.trace.baseline.file import digest


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new project in a folder of its own, which is the current one."""
    root = tmp_path / "car"
    start.new_project(root)
    monkeypatch.chdir(root)
    return root


def contents(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def test_it_is_green_from_the_start_and_decides_the_same_in_c(project: Path) -> None:
    start.green(run_command)
    decided = start.decisions(run_command)
    assert set(decided) == {"drive", "previous_emergency"}
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    assert start.compiled(run_command, project / "build" / "c") == decided


def test_one_folder_is_named_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", str(tmp_path / "one"), "--project", str(tmp_path / "other")]) == 2
    assert "give one of them" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_what_comes_next_is_a_command_for_a_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, _ = run_command("init", "my car")
    assert code == 0
    assert "  cd 'my car'\n" in out


def test_a_recording_does_not_take_the_place_of_its_declaration(project: Path) -> None:
    path = project / "specs" / "scenarios" / "too_fast.yaml"
    before = path.read_bytes()
    linked = project / "other.tmrec.jsonl"
    linked.symlink_to(path)
    for out in ("specs/scenarios/too_fast.yaml", "other.tmrec.jsonl"):
        code, _, err = run_command("scenario", "specs/scenarios/too_fast.yaml", "--out", out)
        assert code == 2
        assert "error[D120]: the declaration itself is no place for its recording" in err
    assert path.read_bytes() == before


def test_a_recording_in_another_folder_uses_the_same_specs(project: Path) -> None:
    """Where the path that is declared leads to another spec, whose limit nobody breaks, too."""
    declared = project / "specs" / "scenarios" / "too_fast.yaml"
    declared.write_text(declared.read_text("utf-8") + "use: [../event.spec]\n", "utf-8")
    (project / "specs" / "event.spec").write_text("module event\nparam v_event : m/s = 28 m/s\n", "utf-8")
    (project / "out" / "deep").mkdir(parents=True)
    (project / "out" / "event.spec").write_text("module event\nparam v_event : m/s = 99 m/s\n", "utf-8")
    for out, name in (
        ("specs/scenarios/r.tmrec.jsonl", "../event.spec"),
        ("out/deep/r.tmrec.jsonl", "../../specs/event.spec"),
        ("r.tmrec.jsonl", "specs/event.spec"),
    ):
        assert run_command("scenario", "specs/scenarios/too_fast.yaml", "--out", out)[0] == 0
        header = json.loads((project / out).read_text("utf-8").partition("\n")[0])
        assert header["use"] == [name]


def test_a_file_behind_a_link_that_leads_out_is_not_said_to_be_missing(project: Path) -> None:
    path = project / "specs" / "scenarios" / "too_fast.yaml"
    path.rename(project.parent / "elsewhere.yaml")
    path.symlink_to(project.parent / "elsewhere.yaml")
    code, out, _ = run_command("trace", "--gate")
    assert code == 1
    assert "too_fast.yaml: the recording is behind a link that leads out of the project\n" in out
    assert "error[T240]: the recording `specs/scenarios/too_fast.yaml` is behind a link that leads out" in out
    assert "help: put the file itself there, or strike the entry" in out
    path.unlink()
    assert "too_fast.yaml: the recording is not there\n" in run_command("trace", "--gate")[1]


def test_a_campaign_behind_a_link_that_leads_out_is_not_said_to_be_missing(project: Path) -> None:
    declared = project / "requirements" / "v-model.yaml"
    text = declared.read_text("utf-8")
    declared.write_text(
        text.replace("  scenarios:\n", "  campaigns: [specs/scenarios/faults.yaml]\n  scenarios:\n", 1),
        "utf-8",
    )
    nothing = (
        "format: trackmarshal-faults\nversion: 1\nname: few\nrecording: too_fast.yaml\nlead: 0.2\nfaults:\n"
    )
    nothing += "  - {id: F-1, title: Nothing, requirement: R-1, begin: 1, end: 1.2, change: [], expect: {}}\n"
    (project.parent / "faults.yaml").write_text(nothing, "utf-8")
    path = project / "specs" / "scenarios" / "faults.yaml"
    path.symlink_to(project.parent / "faults.yaml")
    out = run_command("trace", "--gate")[1]
    assert "error[T264]: the campaign `specs/scenarios/faults.yaml` is behind a link that leads out" in out
    assert "help: put the file itself there, or strike the entry" in out
    path.unlink()
    out = run_command("trace", "--gate")[1]
    assert "error[T264]: the campaign `specs/scenarios/faults.yaml` is not there" in out
    assert "help: restore it, or strike the entry" in out


def test_every_file_of_it_counts(project: Path) -> None:
    """Without its rule, a test, its requirement or its scenario the gate is red: it is green for a reason."""
    for name, old, new in (
        ("specs/speed.spec", "satisfies R-1", ""),
        ("specs/speed.spec", "expect violated", "expect satisfied"),
        ("specs/speed.spec", "p.v <= v_event", "p.v <= 2 * v_event"),
        ("requirements/requirements.yaml", "metrics: [speed_limit]", "metrics: [other]"),
        ("specs/scenarios/too_fast.yaml", "acceleration: [[0, 3]]", "acceleration: [[0, 0]]"),
    ):
        path = project / name
        text = path.read_text("utf-8")
        assert old in text
        path.write_text(text.replace(old, new), "utf-8")
        assert run_command("trace", "--gate")[0] == 1, (name, old)
        path.write_text(text, "utf-8")
    assert run_command("trace", "--gate")[0] == 0


def test_stages_are_called_as_a_project_likes(project: Path) -> None:
    """A process that is none of the V-model's has steps of its own names."""
    path = project / "requirements" / "v-model.yaml"
    text = path.read_text("utf-8")
    for old, new in (("S-1-B", "origin"), ("S-2-B", "v2"), ("S-3-B", "unit_tests"), ("S-4-A", "scenarios")):
        assert old in text
        text = text.replace(old, new)
    path.write_text(text + 'gate:\n  - {stage: unit_tests, requirements: ["*"]}\n', "utf-8")
    assert (
        run_command("trace", "--accept-baseline", "--by", "Ann Author", "--reason", "our own process")[0] == 0
    )
    start.green(run_command)
    status, out, _ = run_command("trace", "--format", "json")
    assert status == 0
    assert '"unit_tests"' in out
    path.write_text(text.replace("id: origin", "id: or igin"), "utf-8")
    assert "T124" in run_command("trace")[1]


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (None, [("T372", "with 1 other")]),
        (("module supervisor.limits\n", ""), [("E205", "which module")]),
        (("param samples", "samples"), [("E101", "unexpected")]),
        (("64 ", "63 "), [("T372", "63")]),
    ],
)
def test_limits_that_are_no_longer_declared_are_one_cause(
    edit: tuple[str, str] | None, told: list[tuple[str, str]], project: Path
) -> None:
    """The file is gone, or cannot be read: each limit has its default then."""
    path = project / "specs" / "supervisor" / "limits.spec"
    if edit is None:
        path.unlink()
    else:
        text = path.read_text("utf-8")
        assert edit[0] in text
        path.write_text(text.replace(*edit), "utf-8")
    status, out, _ = run_command("trace", "--gate", "--format", "json")
    assert status == 1
    found = [one for one in json.loads(out)["findings"] if one["level"] == "error" and not one.get("cause")]
    assert [one["code"] for one in found] == [code for code, _ in told]
    assert all(said in one["message"] for one, (_, said) in zip(found, told))


@pytest.mark.parametrize("later", [False, True])
def test_a_unit_that_the_value_does_not_have_is_one_cause(later: bool, project: Path) -> None:
    """What uses the parameter as the value has it does not fit to what is declared, wherever that stands."""
    path = project / "specs" / "speed.spec"
    text = path.read_text("utf-8").replace("v_event : m/s", "v_event : m")
    if later:
        line = next(line for line in text.splitlines() if line.startswith("param"))
        text = text.replace("use signals\n", "use signals\nuse values\n").replace(line, "")
        (project / "specs" / "values.spec").write_text(f"module values\n{line}\n", "utf-8")
    path.write_text(text, "utf-8")
    found = json.loads(run_command("trace", "--gate", "--format", "json")[1])["findings"]
    assert [one["code"] for one in found if one["level"] == "error" and not one.get("cause")] == ["E302"]
    assert "E301" in [one["code"] for one in found]


def test_where_rules_and_parameters_come_from_is_held(project: Path) -> None:
    """Struck, it takes a name, and worded otherwise it is noted; where there was none, and in baselines of before, nothing is said."""
    path, baseline = project / "specs" / "speed.spec", project / "requirements" / "baseline.json"
    text = path.read_text("utf-8")
    cited = text.replace("satisfies R-1\n", 'satisfies R-1\n  source "concept, page 3"\n')
    old = baseline.read_text("utf-8")
    path.write_text(cited, "utf-8")
    assert run_command("trace", "--gate")[0] == 0
    assert run_command("trace", "--accept-baseline")[0] == 0  # more than before asks for no name
    for before, now in (
        ('  source "regulations of the event"', ""), ('  source "concept, page 3"\n', ""), ("concept, page 3", "TBD"),
        ("regulations of the event", "(to do)"),
    ):  # fmt: skip
        assert before in cited
        path.write_text(cited.replace(before, now), "utf-8")
        found = json.loads(run_command("trace", "--gate", "--format", "json")[1])["findings"]
        assert [one["code"] for one in found] == ["T376"], before
        assert "`source` of the" in found[0]["message"]
    path.write_text(cited.replace("concept, page 3", "concept, page 30"), "utf-8")
    found = json.loads(run_command("trace", "--gate", "--format", "json")[1])["findings"]
    assert [one["code"] for one in found] == ["T226"]
    assert "concept, page 30" in found[0]["message"]
    before_it_was_held = json.loads(old)
    for entry in before_it_was_held["content"].values():
        entry.pop("source", None)
    acceptance = before_it_was_held["acceptances"][-1]
    acceptance["after"] = digest(before_it_was_held["content"])
    baseline.write_text(json.dumps(before_it_was_held), "utf-8")
    path.write_text(text.replace('  source "regulations of the event"', ""), "utf-8")
    assert run_command("trace", "--gate")[0] == 0


def test_where_requirements_come_from_is_held_too(project: Path) -> None:
    path = project / "requirements" / "requirements.yaml"
    text = path.read_text("utf-8")
    assert text.count("    source: this project\n") == 1
    for now, code in (("regulations, 3.2", "T226"), ("TBD", "T126")):
        path.write_text(text.replace("source: this project", f"source: {now}"), "utf-8")
        status, out, _ = run_command("trace", "--gate", "--format", "json")
        causes = [one for one in json.loads(out)["findings"] if one["cause"] is None]
        assert [one["code"] for one in causes] == [code]
        assert "source" in causes[0]["message"]
        assert status == (code == "T126")


def test_the_workflow_runs_what_the_readme_names(project: Path) -> None:
    workflow = yaml.safe_load((project / ".github/workflows/trackmarshal.yml").read_text("utf-8"))
    runs = [step["run"] for step in workflow["jobs"]["gate"]["steps"] if "run" in step]
    assert runs[0] == "python -m pip install trackmarshal"
    verbs = [line.split()[1] for line in runs[1:]]
    assert verbs == ["check", "fmt", "test", "assess", "trace"]
    # Without these, a baseline that was changed by hand, and its hash with it, passes.
    assert runs[-1].endswith("--gate --rerun")
    assert workflow["jobs"]["gate"]["steps"][0]["with"] == {"fetch-depth": 0}
    for line in runs[1:]:
        assert run_command(*line.split()[1:])[0] == 0, line
    readme = (project / "README.md").read_text("utf-8")
    assert readme.startswith("# car\n")
    assert [name for name in re.findall(r"\| `([^`]+)` \|", readme) if not (project / name).exists()] == []


def test_in_a_folder_of_a_repository_the_workflow_is_for_its_root(tmp_path: Path) -> None:
    """GitHub runs those of the root alone, and nothing says that it does not run another one."""
    root = tmp_path / "all of it" / "cars" / "one"
    (tmp_path / "all of it" / ".git").mkdir(parents=True)
    status, out, _ = run_command("init", str(root))
    to = tmp_path / "all of it" / ".github" / "workflows" / "trackmarshal-cars-one.yml"
    assert (status, out.splitlines()[-1]) == (
        0,
        f"GitHub runs no workflow from there: move {root / WORKFLOW} to {to}",
    )
    gate = yaml.safe_load((root / WORKFLOW).read_text("utf-8"))["jobs"]["gate"]
    assert gate["defaults"] == {"run": {"working-directory": "cars/one"}}
    assert gate["steps"][-1]["with"]["path"] == "cars/one/out/assess"


def test_it_asks_nothing_and_says_what_it_wrote(tmp_path: Path) -> None:
    status, out, err = run_command("init", str(tmp_path / "a" / "b"))
    assert (status, err) == (0, "")
    written = [
        line.removeprefix(f"wrote {tmp_path / 'a' / 'b'}/")
        for line in out.splitlines()
        if line.startswith("wrote")
    ]
    assert sorted(written) == sorted([*FILES, BASELINE])
    assert sorted(contents(tmp_path / "a" / "b")) == sorted(written)


def test_a_road_is_found_beside_what_is_no_file(project: Path) -> None:
    tracks = project / "specs" / "tracks"
    (tracks / ".#straight.yaml").symlink_to("somebody@here.1")  # Emacs has the file open
    assert run_command("new", "scenario", "first")[::2] == (0, "")
    os.mkfifo(tracks / "pipe.yaml")
    status, _, err = run_command("new", "scenario", "second")
    assert (status, "a named pipe, not a regular file" in err) == (2, True)


@pytest.mark.parametrize("name", [*FILES, BASELINE])
def test_init_overwrites_nothing(name: str, tmp_path: Path) -> None:
    there = tmp_path / name
    there.parent.mkdir(parents=True, exist_ok=True)
    there.symlink_to(tmp_path / "nowhere")  # a link to nothing is something too
    status, out, err = run_command("init", str(tmp_path))
    assert (status, out) == (2, "")
    assert "error[E412]" in err
    assert "help: nothing was written" in err
    assert contents(tmp_path) == {}


def test_a_folder_of_it_may_be_a_link(tmp_path: Path) -> None:
    (tmp_path / "car").mkdir()
    (tmp_path / "shared").mkdir()
    (tmp_path / "car" / "specs").symlink_to(tmp_path / "shared")
    status, out, err = run_command("init", str(tmp_path / "car"))
    assert (status, err) == (0, "")
    assert f"wrote {tmp_path / 'car' / 'specs' / 'speed.spec'}\n" in out


def test_what_cannot_be_written_as_a_whole_is_not_written(tmp_path: Path) -> None:
    (tmp_path / ".github").write_text("no folder", "utf-8")
    status, _, err = run_command("init", str(tmp_path))
    assert (status, "error[E411]" in err) == (2, True)
    assert contents(tmp_path) == {".github": b"no folder"}


def test_beside_a_spec_that_cannot_be_read_nothing_is_left_of_a_project(tmp_path: Path) -> None:
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "other.spec").write_bytes(b"module other\n\xff")
    status, out, err = run_command("init", str(tmp_path))
    assert (status, out, "error[E004]" in err) == (2, "", True)
    assert contents(tmp_path) == {"specs/other.spec": b"module other\n\xff"}


def test_a_name_that_yaml_and_markdown_could_stumble_over(tmp_path: Path) -> None:
    root = tmp_path / 'it\'s: "a" #{{ car }}\n'
    assert run_command("init", str(root))[0] == 0
    assert run_command("trace", "--gate", "--project", str(root))[0] == 0


def test_a_requirement_that_is_named_twice_stands_once_in_a_new_rule(project: Path) -> None:
    """The rule was written so that the gate refused it (T210)."""
    assert run_command("new", "rule", "slow", "--satisfies", "R-1", "--satisfies", "R-1")[0] == 0
    assert "satisfies R-1\n" in (project / "specs" / "slow.spec").read_text("utf-8")


def test_new_pieces_pass_check_and_turn_the_gate_red_until_they_are_covered(project: Path) -> None:
    before = contents(project)
    for words in (
        ("requirement", "R-2"),
        ("rule", "slow", "--satisfies", "R-2"),
        ("rulebook", "order"),
        ("scenario", "alone"),
    ):
        status, out, err = run_command("new", *words)
        assert (status, err) == (0, "")
        (written,) = re.findall(r"^wrote (.*)$", out, re.MULTILINE)
        assert re.search(r"^next: .", out, re.MULTILINE)
        assert "TODO" in (project / written).read_text("utf-8")
        assert run_command("check")[0] == 0, words
        assert run_command("fmt", "--check")[0] == 0, words
    assert run_command("replay", "specs/scenarios/alone.yaml")[0] == 0
    assert {name: contents(project)[name] for name in before} == before
    status, out, _ = run_command("trace", "--gate")
    assert status == 1
    assert "rule slow: has no test" in out
    # The tests that the comments show are those of the rule as it stands.
    path = project / "specs" / "slow.spec"
    path.write_text(re.sub(r"^-- (test|  )", r"\1", path.read_text("utf-8"), flags=re.MULTILINE), "utf-8")
    status, out, _ = run_command("test")
    assert (status, "2 of 2 rules covered" in out) == (0, True)
    assert run_command("fmt", "--check")[0] == 0


@pytest.mark.parametrize(
    ("signal", "required"),
    [
        ("signal gaps : set of object { x: m, y: m, length: m in [0.1, 30] }", "require   o.x <= 100 m"),
        ("signal ego : state { age: s in [0, 10] }", "require   ego.age <= 5 s"),
        ("signal plan : trajectory { t: s increasing, kappa: 1/m in [-1, 1] }", "require   p.kappa <= 0 1/m"),
    ],
)  # fmt: skip
def test_a_new_rule_reads_what_the_project_declares(signal: str, required: str, project: Path) -> None:
    for name in ("speed", "signals"):
        (project / "specs" / f"{name}.spec").unlink()
    (project / "specs" / "inputs.spec").write_text(f"module inputs\n\n{signal}\n", "utf-8")
    status, _, err = run_command("new", "rule", "bounded")
    assert (status, err) == (0, "")
    path = project / "specs" / "bounded.spec"
    text = path.read_text("utf-8")
    assert required in text
    path.write_text(re.sub(r"^-- (test|  )", r"\1", text, flags=re.MULTILINE), "utf-8")
    assert "1 of 1 rules covered" in run_command("test")[1]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("rule", "speed_limit"), "E412", "the project has a rule `speed_limit` already"),
        (("rule", "signals"), "E412", "specs/signals.spec is there already"),
        (("rule", "for"), "E413", "the language has another use for `for`"),
        (("rule", "keep-left"), "E413", "`keep-left` is no name for a rule"),
        (("rule", "../x"), "E413", "`../x` is no name for a rule"),
        (("rule", "prelude"), "E413", "`prelude` is no name for a rule"),
        (("rule", "x", "--satisfies", "R-9"), "E413", "the project has no requirement R-9"),
        (("scenario", "x", "--satisfies", "R-1"), "E413", "a scenario satisfies nothing"),
        (("scenario", "too_fast"), "E412", "specs/scenarios/too_fast.yaml is there already"),
        (("scenario", "a/b"), "E413", "`a/b` is no name for a scenario"),
        (("requirement", "R-1"), "E412", "the project has a requirement R-1 already"),
        (("requirement", "r1"), "E413", "`r1` is no id of a requirement"),
        (("rulebook", "1"), "E413", "`1` is no name for a rulebook"),
    ],
)
def test_names_that_cannot_be(words: tuple[str, ...], code: str, said: str, project: Path) -> None:
    before = contents(project)
    status, out, err = run_command("new", *words)
    assert (status, out) == (2, "")
    assert f"error[{code}]: {said}" in err
    assert "help: " in err
    assert contents(project) == before


def test_nothing_to_begin_with(project: Path) -> None:
    (project / "specs" / "speed.spec").unlink()
    assert "error[E414]: there is no rule" in run_command("new", "rulebook", "order")[2]
    (project / "specs" / "signals.spec").unlink()
    assert "error[E414]: the project's specs declare no signal" in run_command("new", "rule", "x")[2]


def test_specs_with_errors_are_mended_first(project: Path) -> None:
    (project / "specs" / "speed.spec").write_text("module speed\n\nrule\n", "utf-8")
    status, _, err = run_command("new", "rule", "x")
    assert status == 2
    assert "specs/speed.spec:3" in err
    assert not (project / "specs" / "x.spec").exists()


def test_a_scenario_brings_a_road_where_there_is_none(project: Path) -> None:
    (project / "specs" / "tracks" / "straight.yaml").unlink()
    assert run_command("new", "scenario", "alone")[0] == 0
    assert (project / "specs" / "tracks" / "straight.yaml").is_file()
    assert run_command("replay", "specs/scenarios/alone.yaml")[0] == 0


def test_without_a_project_there_is_nothing_new(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, err = run_command("new", "rule", "x")
    assert (status, "error[E410]" in err) == (2, True)


def test_the_repository_knows_the_pieces_too() -> None:
    """`new` stands in any project; here only a name that is taken is tried."""
    status, _, err = run_command("new", "rule", "friction", "--project", str(REPOSITORY))
    assert (status, "error[E412]" in err) == (2, True)


def test_a_signal_of_ones_own_that_a_scenario_lacks_is_given_under_signals(project: Path) -> None:
    """Who declares a signal has every scenario fail with what is not there, and is told where it is given."""
    (project / "specs" / "flags.spec").write_text(
        'module flags\nenum flag { green, red }\nsignal race : state { flag: flag }\nrule go "g"\n  require race.flag is green\n'
    )
    scenario = project / "specs" / "scenarios" / "too_fast.yaml"
    assert "a declaration gives `race` under `signals`" in run_command("replay", str(scenario))[1]
    text = scenario.read_text("utf-8").replace("[../speed.spec]", "[../speed.spec, ../flags.spec]")
    scenario.write_text(f"{text}signals:\n  race: {{at: {{0 s: {{flag: green}}}}}}\n", "utf-8")
    status, said, _ = run_command("replay", str(scenario))
    assert status == 0
    assert "under `signals`" not in said


def test_a_safety_case_before_anything_was_run_says_who_runs_it(project: Path) -> None:
    asked = ("case", "--out", "case", "--format", "html")
    assert "`trackmarshal assess` does" in run_command(*asked)[2]
    assert run_command("assess")[0] == 0
    status, _, said = run_command(*asked)
    assert status == 0
    assert "assess" not in said
