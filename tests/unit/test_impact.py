"""`trace --impact`: what an edit means for the evidence, in a project of its own, in a folder of a repository."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from golden.trace.cases import HERE
from support.project import command, run_command
from trackmarshal.cli.answers import commit
from trackmarshal.files import digest
from trackmarshal.meaning.tool import _DATA, _KINDS, tool, tool_of, whole
from trackmarshal.meaning.tool import HERE as HERE_OF_ENGINE
from trackmarshal.records.results_file import ResultsFile, save
from trackmarshal.records.tests import ExternalTest
from trackmarshal.trace.impact.resting import order

GOLDEN = HERE.parent / "impact"
PAGE = HERE.parents[2] / "docs" / "impact.md"
UPDATE = os.environ.get("UPDATE_GOLDEN") == "1"


def git(folder: Path, *arguments: str) -> None:
    given = ("user.name=n", "user.email=e", "commit.gpgsign=false", "protocol.file.allow=always")
    settings = [word for setting in given for word in ("-c", setting)]
    subprocess.run(["git", *settings, *arguments], cwd=folder, check=True, capture_output=True)


def committed(root: Path) -> Path:
    """A project, in the first commit of a repository around it."""
    (root / ".gitignore").write_text("out\n", "utf-8")
    git(root.parent, "init", "-q")
    git(root.parent, "add", "-A")
    git(root.parent, "commit", "-qm", "first")
    return root


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The warehouse robot, whose baseline is accepted."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "repository" / "robot"
    shutil.copytree(HERE / "warehouse", root)
    assert command(root, "trace", "--accept-baseline")[0] == 0
    return committed(root)


@pytest.fixture
def car(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new project, which has a run."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "repository" / "car"
    root.parent.mkdir()
    assert run_command("init", str(root))[0] == 0
    return committed(root)


def edit(root: Path, file: str, old: str, new: str) -> None:
    path = root / file
    text = path.read_text("utf-8")
    assert text.count(old) >= 1, f"{file} has no {old!r}"
    path.write_text(text.replace(old, new), "utf-8")


def impact(root: Path, revision: str = "HEAD") -> dict[str, Any]:
    status, out, err = command(root, "trace", "--impact", revision, "--format", "json")
    assert status == 0, err
    return dict(json.loads(out))


def named(found: dict[str, Any], which: str = "again") -> list[str]:
    return [f"{one['kind']} {one['id']}" for one in found[which]]


def lower(root: Path) -> None:
    """The edit that docs/impact.md shows."""
    edit(root, "requirements/needs.yaml", "no more than 0.3 m/s", "no more than 0.2 m/s")
    edit(root, "specs/robot.spec", "0.3 m/s\n", "0.2 m/s\n")
    edit(root, "specs/robot.spec", "{ v: 0.3 m/s", "{ v: 0.2 m/s")


def without_commits(text: str) -> str:
    return re.sub(
        r"\b[0-9a-f]{12}([0-9a-f]{28}\+?)?(?=\W)", "0" * 12, text.replace(tool(), "trackmarshal 0.0.0")
    )


@pytest.mark.parametrize(
    ("format", "file"), [("text", "impact.txt"), ("json", "impact.json"), ("markdown", "impact.md")]
)
def test_the_formats(format: str, file: str, robot: Path) -> None:
    lower(robot)
    edit(
        robot,
        "requirements/needs.yaml",
        "hit a person at more than 0.3 m/s",
        "hit a person at more than 0.2 m/s",
    )
    status, out, err = command(robot, "trace", "--impact", "HEAD", "--format", format)
    assert (status, err) == (0, "")
    if UPDATE:
        (GOLDEN / file).write_text(without_commits(out), "utf-8")
    assert without_commits(out) == (GOLDEN / file).read_text("utf-8")


def test_a_scenario_that_is_gone_is_a_change(car: Path) -> None:
    (car / "specs" / "scenarios" / "too_fast.yaml").unlink()
    (one,) = impact(car)["changed"]
    assert (one["kind"], one["id"]) == ("scenario", "specs/scenarios/too_fast.yaml")
    assert "its contents changed (there is none any more)" in one["what"]


def test_what_is_gone_reaches_the_requirements_that_it_was_there_for(robot: Path) -> None:
    """With the rule, nothing evaluates `SW-2` any more, and `SYS-2` above it; a test that is gone showed something of both, too."""
    spec = robot / "specs" / "robot.spec"
    rules, _, tests = spec.read_text("utf-8").partition("test gentle")
    spec.write_text(
        rules + "test gentle" + tests.replace('test gentle "gentle"', "--", 1).partition("--")[0] + "",
        "utf-8",
    )
    found = impact(robot)
    assert {one["how"] for one in found["changed"]} == {"gone"}
    assert found["requirements"] == ["SW-2", "SYS-2"]
    rule = re.sub(r"rule gentle .*\n(?:  .*\n)+", "", rules)
    spec.write_text(rule, "utf-8")
    found = impact(robot)
    assert [(one["how"], one["id"]) for one in found["changed"]] == [("gone", "gentle")]
    assert found["requirements"] == ["SW-2", "SYS-2"]


def test_what_a_scenario_showed_is_in_doubt(car: Path) -> None:
    """Where it is another one, and where it is gone, whether it was run here or not."""
    with (car / "specs/scenarios/too_fast.yaml").open("a", encoding="utf-8") as file:
        file.write("\n")
    assert impact(car)["requirements"] == ["R-1"]
    git(car, "checkout", "-q", ".")
    text = (car / "requirements/v-model.yaml").read_text("utf-8")
    entry = re.search(r"  scenarios:\n(?:    .*\n)+", text)
    assert entry is not None
    edit(car, "requirements/v-model.yaml", entry[0], "")
    found = impact(car)
    assert ("scenario specs/scenarios/too_fast.yaml", "gone") in [(f"{one['kind']} {one['id']}", one["how"]) for one in found["changed"]]  # fmt: skip
    assert found["requirements"] == ["R-1"]


def test_a_spec_that_no_commit_has_is_a_change_that_is_not_in_it(robot: Path) -> None:
    """Results are made from it, and cannot be made again from the commit alone."""
    assert not commit(robot).endswith("+")
    (robot / "out" / "more").mkdir(parents=True, exist_ok=True)
    (robot / "out" / "more" / "a.yaml").write_text("made: here\n", "utf-8")  # which git is told to pass over
    assert not commit(robot).endswith("+")
    (robot / "specs" / "more.spec").write_text("module more\n", "utf-8")
    assert commit(robot).endswith("+")


def test_what_is_kept_out_of_archives_was_there_all_the_same(robot: Path) -> None:
    """git leaves out of an archive what `.gitattributes` says: all of that would be new, and nothing of it weaker."""
    (robot / ".gitattributes").write_text("*.spec export-ignore\n*.yaml export-ignore\n", "utf-8")
    git(robot, "add", ".gitattributes")
    git(robot, "commit", "-qm", "archives")
    assert impact(robot)["changed"] == []


def test_the_page(robot: Path) -> None:
    lower(robot)
    (shown,) = re.findall(r"```text\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert without_commits(command(robot, "trace", "--impact", "HEAD")[1]) == without_commits(shown)


def test_what_means_the_same_has_no_impact(robot: Path) -> None:
    edit(robot, "specs/robot.spec", "rule gentle", "-- a comment\nrule   gentle")
    edit(robot, "requirements/needs.yaml", "title: Gentle with a load", "title: Gently with a load")
    found = impact(robot)
    assert (found["changed"], found["again"], found["requirements"]) == ([], [], [])
    assert "nothing means something else" in command(robot, "trace", "--impact", "HEAD")[1]


def test_exactly_the_tests_of_a_changed_rule(robot: Path) -> None:
    edit(robot, "specs/robot.spec", "robot.a <= 1 m/s^2", "robot.a < 1 m/s^2")
    found = impact(robot)
    tests = [name for name in named(found) if name.startswith("test ")]
    assert sorted(tests) == [
        "test gentle: gentle",
        "test gentle: just gentle enough",
        "test gentle: too hard",
    ]
    assert found["requirements"] == ["SW-2", "SYS-2"]


def test_a_signal_that_all_rules_read(robot: Path) -> None:
    edit(robot, "specs/robot.spec", "{ v: m/s, a", "{ v: m/s in [0, 3], a")
    found = impact(robot)
    assert len([name for name in named(found) if name.startswith("test ")]) == 6
    assert "signal robot" in named(found, "changed")


def test_a_review_of_another_text_falls(robot: Path) -> None:
    edit(robot, "requirements/needs.yaml", "hit a person at", "ever hit a person at")
    found = impact(robot)
    assert found["reviews"] == ["RV-1"]
    assert "reviews that fall: RV-1" in command(robot, "trace", "--impact", "HEAD")[1]


def test_what_no_review_reads_makes_none_fall(robot: Path) -> None:
    """The gate holds a review by the fingerprint of what it read; so does the impact."""
    edit(
        robot,
        "requirements/needs.yaml",
        "    achieves: [SG-1]\n",
        "    achieves: [SG-1]\n    verified_by: [M-1]\n",
    )
    edit(robot, "requirements/design.yaml", "elements:", "methods:\n  - {id: M-1, title: driving}\nelements:")
    found = impact(robot)
    assert "requirement SYS-1" in named(found, "changed")
    assert found["reviews"] == []
    assert "T167" not in command(robot, "trace", "--verbose")[1]


def analysed(robot: Path, left: str) -> None:
    """An analysis of the hazard with its review, committed."""
    (robot / "docs").mkdir()
    (robot / "docs" / "hazards.md").write_text("# How people come near\n\nFrom between shelves.\n", "utf-8")
    assurance = robot / "requirements" / "analysed.yaml"
    assurance.write_text(
        "document: assurance\ntitle: What was analysed\nanalyses:\n"
        f"  - {{id: AN-1, title: Risks, method: hazard analysis, of: [HZ-1], by: [P-1], made: 2026-02-01, document: docs/hazards.md{left}}}\n"
        f"reviews:\n  - {{id: RV-2, of: [{{id: AN-1, fingerprint: '{'0' * 64}'}}], by: [P-2], made: 2026-03-01, outcome: accepted}}\n",
        "utf-8",
    )
    is_ = re.search(r"`fingerprint: '(\w+)'`", command(robot, "trace", "--verbose")[1])
    assert is_ is not None
    edit(robot, "requirements/analysed.yaml", "0" * 64, is_[1])
    assert command(robot, "trace", "--accept-baseline", "--by", "P-2", "--reason", "analysed")[0] == 0
    git(robot, "add", "-A")
    git(robot, "commit", "-qm", "analysed")
    assert "T167" not in command(robot, "trace", "--verbose")[1]


@pytest.mark.parametrize(
    ("before", "after"),
    [("", ", open: [Children.]"), (", open: [Children.]", ""), (", open: [Children.]", ", open: [Children., Dogs.]")],
)  # fmt: skip
def test_a_review_of_an_analysis_that_leaves_something_else_open_falls_for_the_gate_too(
    before: str, after: str, robot: Path
) -> None:
    analysed(robot, before)
    edit(robot, "requirements/analysed.yaml", f"docs/hazards.md{before}}}", f"docs/hazards.md{after}}}")
    assert impact(robot)["reviews"] == ["RV-2"]
    status, out, _ = command(robot, "trace", "--gate", "--verbose")
    assert status == 1
    assert "T167" in out
    assert "T382" in out


def test_what_others_rest_on_comes_first(robot: Path) -> None:
    """A hazard above all, and a rule below: whoever follows the list never judges something before what it rests on."""
    edit(
        robot, "requirements/hazards.yaml", "steps out between two shelves", "steps out between three shelves"
    )
    lower(robot)
    edit(robot, "requirements/needs.yaml", "hit a person at", "ever hit a person at")
    places = {name: place for place, name in enumerate(named(impact(robot)))}
    chain = ["safety goal SG-1", "requirement SW-1", "rule slow_near_people", "test slow_near_people: slow"]
    assert [places[name] for name in chain] == sorted(places[name] for name in chain)
    assert places["requirement SW-1"] < places["review RV-1"] < places["baseline requirements/baseline.json"]


def test_results_of_what_there_is_now(robot: Path) -> None:
    edit(robot, "specs/robot.spec", "robot.a <= 1 m/s^2", "robot.a <= 0.9 m/s^2")
    assert not any(task["made"] for task in impact(robot)["again"])
    command(robot, "trace")
    assert [task["made"] for task in impact(robot)["again"] if task["kind"] == "test"] == [True] * 3


def test_runs_and_recordings(car: Path) -> None:
    assert impact(car)["again"] == []
    scenario = "specs/scenarios/too_fast.yaml"
    edit(car, "specs/speed.spec", "<=", "<")
    kinds = {name.partition(" ")[0] for name in named(impact(car))}
    assert {"rule", "test", "run"} <= kinds
    git(car, "checkout", "-q", ".")
    (car / scenario).write_text((car / scenario).read_text("utf-8") + "\n", "utf-8")
    found = impact(car)
    assert [name for name in named(found) if not name.startswith("baseline")] == [f"run {scenario}"]
    assert "the recording has changed since" in found["again"][0]["why"]


def test_since_an_older_revision(robot: Path) -> None:
    lower(robot)
    git(robot, "commit", "-qam", "second")
    assert impact(robot)["changed"] == []
    assert "rule slow_near_people" in named(impact(robot, "HEAD~1"), "changed")


def test_a_revision_that_does_not_compile(robot: Path) -> None:
    edit(robot, "specs/robot.spec", "robot.a <= 1 m/s^2", "robot.a <= 1 m")
    git(robot, "commit", "-qam", "broken")
    git(robot, "checkout", "-q", "HEAD~1", "--", ".")
    found = impact(robot)
    assert len([name for name in named(found) if name.startswith("test ")]) == 6
    assert {task["why"] for task in found["again"] if task["kind"] == "test"} == {
        "what it was made from then is not known"
    }
    assert "specs/robot.spec:13" in found["unknown"][0]
    assert (
        "everything that rests on its specs counts as changed"
        in command(robot, "trace", "--impact", "HEAD")[1]
    )
    edit(robot, "specs/robot.spec", "rule gentle", "rool gentle")
    git(robot, "commit", "-qam", "worse")
    git(robot, "checkout", "-q", "HEAD~2", "--", ".")
    assert impact(robot)["unknown"]


def test_errors_in_what_is_here(robot: Path) -> None:
    edit(robot, "specs/robot.spec", "robot.a <= 1 m/s^2", "robot.a <= 1 m")
    status, _, err = command(robot, "trace", "--impact", "HEAD")
    assert (status, "T363" in err, "specs/robot.spec:13" in err) == (2, True, True)
    git(robot, "checkout", "-q", ".")
    edit(robot, "requirements/needs.yaml", "requirements:", "<<<<<<< HEAD\nrequirements:")
    status, _, err = command(robot, "trace", "--impact", "HEAD")
    assert (status, "T363" in err, "requirements/needs.yaml" in err) == (2, True, True)


def test_a_baseline_that_is_lost_or_was_changed_by_hand(robot: Path) -> None:
    """What has to be accepted by name is not left out for want of it."""
    path = robot / "requirements/baseline.json"
    held = path.read_bytes()
    for data in (None, held[:100], held.replace(b'"statement"', b'"statements"')):
        path.unlink()
        if data is not None:
            path.write_bytes(data)
        status, out, err = command(robot, "trace", "--impact", "HEAD")
        assert (status, out, "T363" in err, "baseline" in err) == (2, "", True, True)
        path.write_bytes(held)
    assert command(robot, "trace", "--impact", "HEAD")[0] == 0


def test_a_revision_of_which_archives_hold_nothing(robot: Path) -> None:
    """`.gitattributes` may keep all out of them that is asked for."""
    (robot / ".gitattributes").write_text("* export-ignore\n", "utf-8")
    git(robot, "add", ".")
    git(robot, "commit", "-qm", "no archives")
    status, out, err = command(robot, "trace", "--impact", "HEAD")
    assert (status, "nothing means something else" in out, err) == (0, True, "")


def test_files_of_the_safety_case_that_are_the_same(robot: Path) -> None:
    """They are read of the revision, too: what is not, seems to have changed."""
    edit(robot, "requirements/v-model.yaml", "project:\n", "project:\n  closed_loop: case/loop.json\n  case_words: case/fr.yaml\n  case_templates: case/printed\n")  # fmt: skip
    (robot / "case/printed").mkdir(parents=True)
    for name in ("loop.json", "fr.yaml", "printed/cover.html.j2"):
        (robot / "case" / name).write_text("{}", "utf-8")
    accept = ("--accept-baseline", "--by", "Maria Motor", "--reason", "another language", "--quiet")
    assert command(robot, "trace", *accept)[0] == 0
    git(robot, "add", ".")
    git(robot, "commit", "-qm", "a case")
    assert "nothing means something else" in command(robot, "trace", "--impact", "HEAD")[1]
    (robot / "case/printed/cover.html.j2").write_text("{{ }}", "utf-8")
    out = command(robot, "trace", "--impact", "HEAD")[1]
    assert "its case templates changed" in out
    assert "closed loop" not in out


@pytest.mark.parametrize("revision", ["nowhere", "-x", "", "HEAD:robot", "requirements"])
def test_what_is_no_revision(revision: str, robot: Path) -> None:
    status, out, err = command(robot, "trace", f"--impact={revision}")
    assert (status, out, "T361" in err) == (2, "", True)


def test_a_revision_without_the_project(robot: Path) -> None:
    git(robot, "checkout", "-q", "--orphan", "other")
    git(robot, "rm", "-rqf", "--cached", ".")
    (robot / "a").write_text("a", "utf-8")
    git(robot, "add", "a")
    git(robot, "commit", "-qm", "nothing")
    status, _, err = command(robot, "trace", "--impact", "other")
    assert (status, "T363" in err) == (2, True)


def test_a_project_that_was_moved_since(robot: Path) -> None:
    """Of a revision that has not the folder, git says that the working directory is untracked, and the history is as complete as it can be."""
    moved = robot.parent / "machines" / "robot"
    moved.parent.mkdir()
    git(robot.parent, "mv", "robot", "machines/robot")
    git(robot.parent, "commit", "-qm", "moved")
    status, _, err = command(moved, "trace", "--impact", "HEAD~1")
    assert (status, "T363" in err, "the commit that moved it" in err) == (2, True, True)
    assert command(moved, "trace", "--impact", "HEAD")[0] == 0
    status, _, err = command(moved, "diff", "HEAD~1", ".", "--on", "requirements/v-model.yaml")
    assert (status, "T362" in err, "git worktree add" in err) == (2, True, True)


def test_without_git_or_history(robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    git(robot, "commit", "-q", "--allow-empty", "-m", "second")
    git(tmp_path, "clone", "-q", "--depth", "1", f"file://{robot.parent}", "shallow")
    assert "the clone is shallow" in command(tmp_path / "shallow" / "robot", "trace", "--impact", "HEAD~1")[2]
    shutil.copytree(robot, tmp_path / "plain")
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    status, _, err = command(tmp_path / "plain", "trace", "--impact", "HEAD")
    assert (status, "T361" in err) == (2, True)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "git is missing" in command(robot, "trace", "--impact", "HEAD")[2]


@pytest.mark.parametrize(
    "more", [["--gate"], ["--accept-baseline"], ["--rerun"], ["--statistics"], ["--format", "html"], ["--from", "rule", "--to", "test"], ["--day", "commit"]]
)  # fmt: skip
def test_what_does_not_go_with_it(more: list[str], robot: Path) -> None:
    status, _, err = command(robot, "trace", "--impact", "HEAD", *more)
    assert (status, "T169" in err) == (2, True)


def test_a_new_document_and_source_code(robot: Path) -> None:
    (robot / "src").mkdir()
    (robot / "src" / "drive.py").write_text("# implements SW-1\nspeed = 0.3\n", "utf-8")
    test = ExternalTest("t", "slow", ("SW-1",), "passed")
    save(robot / "tests.json", ResultsFile("external_tests", (test,), "1", "2026-01-01T00:00:00+00:00"))
    edit(
        robot,
        "requirements/v-model.yaml",
        "  default_spec: specs\n",
        "  default_spec: specs\n  sources: [src]\n  junit: [{path: tests.json, stage: TST-1}]\n",
    )
    git(robot, "add", "-A")
    git(robot, "commit", "-qm", "code")
    assert impact(robot)["again"] == []
    edit(robot, "src/drive.py", "0.3", "0.5")
    found = impact(robot)
    assert named(found, "changed") == ["code src/drive.py"]
    assert named(found) == ["external test t: slow"]
    # A checkout with other ends of lines holds the same.
    (robot / "src" / "drive.py").write_bytes(b"# implements SW-1\r\nspeed = 0.3\r\n")
    assert impact(robot)["changed"] == []


def test_a_test_of_another_runner_whose_file_was_edited(robot: Path) -> None:
    """What the gate calls stale has to be made again, although no requirement changed."""
    ran = "def test_slow(): ...\n"
    (robot / "test_t.py").write_text(ran, "utf-8")
    test = ExternalTest("t", "slow", ("SW-1",), "passed", file="test_t.py", file_hash=digest(ran.encode()))
    save(robot / "tests.json", ResultsFile("external_tests", (test,), "1", "2026-01-01T00:00:00+00:00"))
    edit(
        robot,
        "requirements/v-model.yaml",
        "  default_spec: specs\n",
        "  default_spec: specs\n  junit: [{path: tests.json, stage: TST-1}]\n",
    )
    git(robot, "add", "-A")
    git(robot, "commit", "-qm", "tests")
    assert impact(robot)["again"] == []
    (robot / "test_t.py").write_text("def test_slow(): assert False\n", "utf-8")
    found = impact(robot)
    assert named(found) == ["external test t: slow"]
    assert found["again"][0]["why"] == "its file has changed since it ran"


@pytest.mark.parametrize("size", [2, 7])
def test_circles_have_an_order(size: int) -> None:
    """What rests on itself, however far around, is in the order once, and so is what rests on it."""
    keys = [("requirement", f"R-{number}") for number in range(size)]
    below = {key: {keys[number - 1]} for number, key in enumerate(keys)}
    below["test", "t"] = {keys[-1]}
    places = order(below)
    assert sorted(places.values()) == list(range(size + 1))
    assert places["test", "t"] > places[keys[-1]]


def of_engine(root: Path, engine: str | None) -> None:
    """The baseline accepted when that engine made the evidence; None: one that does not say."""
    path = root / "requirements" / "baseline.json"
    held = json.loads(path.read_text("utf-8"))
    assert held["acceptances"][-1].pop("engine") == tool()
    if engine is not None:
        held["acceptances"][-1]["engine"] = engine
    path.write_text(json.dumps(held), "utf-8")
    git(root, "add", "-A")
    git(root, "commit", "-qm", "accepted then")


def test_with_another_engine_all_that_it_evaluates_is_made_again(robot: Path) -> None:
    """Documents, reviews and rules are as they were."""
    tests = 0
    for path in (robot / "specs").glob("*.spec"):
        tests += len(re.findall(r"^test ", path.read_text("utf-8"), re.M))
    of_engine(robot, "trackmarshal 0.0.9 0123456789abcdef")
    found = impact(robot)
    assert [(one["kind"], one["how"]) for one in found["changed"]] == [("engine", "changed")]
    assert found["changed"][0]["what"] == [
        f"it was 0.0.9 0123456789abcdef, and is {tool().partition(' ')[2]}"
    ]
    assert found["engine"] == {"before": "trackmarshal 0.0.9 0123456789abcdef", "now": tool()}
    assert {(one["kind"], one["do"], one["why"]) for one in found["again"]} == {
        ("test", "run", "the engine has changed since")
    }
    assert len(found["again"]) == tests > 0
    assert "SW-1" in found["requirements"]


def test_with_another_engine_runs_are_made_again(car: Path) -> None:
    of_engine(car, "trackmarshal 0.0.9 0123456789abcdef")
    kinds = {one["kind"] for one in impact(car)["again"] if "engine" in one["why"]}
    assert kinds == {"test", "run"}


def test_an_engine_that_nobody_wrote_down_is_not_known(robot: Path) -> None:
    of_engine(robot, None)
    found = impact(robot)
    assert (found["changed"], found["again"], found["engine"]["before"]) == ([], [], None)
    for format in ("text", "markdown"):
        said = command(robot, "trace", "--impact", "HEAD", "--format", format)[1]
        assert "which engine made the evidence of `HEAD` is not known" in said


def test_the_engine_of_a_folder_of_sources(tmp_path: Path) -> None:
    """Of what evaluates, and of nothing else: the command line and its words come to no results, but for what writes down what a run came to."""
    there = shutil.copytree(HERE_OF_ENGINE, tmp_path / "trackmarshal", ignore=shutil.ignore_patterns("*.pyc"))
    assert tool_of(there) == tool()
    with (there / "cli" / "main.py").open("a", encoding="utf-8") as file:
        file.write("# nothing\n")
    (there / "trace").mkdir()  # as it is installed
    (there / "trace" / "matrix.py").write_text("# nothing\n")
    assert tool_of(there) == tool()
    written = there / "cli" / "evidence.py"
    before = written.read_bytes()
    written.write_bytes(before + b"# nothing\n")
    assert tool_of(there) != tool()
    written.write_bytes(before)
    with (there / "node.py").open("a", encoding="utf-8") as file:
        file.write("# nothing\n")
    assert tool_of(there).rpartition(" ")[0] == tool().rpartition(" ")[0]
    assert tool_of(there) != tool()
    edit(there, "__init__.py", '__version__ = "', '__version__ = "9.')
    assert tool_of(there).startswith("trackmarshal 9.")
    assert tool_of(tmp_path / "nowhere") == ""


def test_the_whole_program_is_also_what_it_reads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an installed program, answers that are kept rest on its schemas and lists of phrases; results of rules do not."""
    found = list[tuple[str, str]]()
    for phrases in ("not ready", "not ready\nuntested"):
        there = tmp_path / str(len(found))
        (there / "trace").mkdir(parents=True)
        (there / "__init__.py").write_text('__version__ = "9"\n', "utf-8")
        (there / "trace" / "denials.txt").write_text(phrases, "utf-8")
        monkeypatch.setattr(sys.modules[whole.__module__], "HERE", there)  # `tool` is a function of that name
        found.append((whole.__wrapped__(), tool_of(there)))
    (one, engine), (other, same) = found
    assert one != other
    assert engine == same
    both = [Path(__file__).parents[2] / part / "trackmarshal" for part in ("engine", "trace")]
    packaged = {path.suffix for folder in both for path in folder.rglob("*") if path.is_file()}
    assert packaged - {".pyc", ".typed", ""} == {*_KINDS, *_DATA}


def test_accepted_again_by_another_engine_is_one_acceptance_more(robot: Path) -> None:
    path = robot / "requirements" / "baseline.json"
    before = path.read_bytes()
    assert command(robot, "trace", "--accept-baseline")[0] == 0
    assert path.read_bytes() == before
    of_engine(robot, "trackmarshal 0.0.9 0123456789abcdef")
    assert command(robot, "trace", "--accept-baseline")[0] == 0
    first, second = json.loads(path.read_text("utf-8"))["acceptances"]
    assert (first["engine"], second["engine"]) == ("trackmarshal 0.0.9 0123456789abcdef", tool())
    assert (second["weaker"], first["after"]) == ([], second["after"])
