"""The day of the gate: an old commit's waivers hold as they did then, and tests that were not run yet show nothing."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from datetime import date
from pathlib import Path

import pytest

from golden.trace.cases import HERE
from support.project import command
from trackmarshal.cli.days import day, doubts
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records.results_file import ResultsFile, save
from trackmarshal.records.tests import ExternalTest

WAIVER = """waivers:
  - id: W-1
    stages: [TST-1]
    requirements: [SYS-*, SW-*]
    justification: The test bench is not there yet.
    residual_risk: None, as nothing is sold before it is there.
    owner: P-1
    approver: P-2
    granted: 2020-01-01
    expires: 2020-12-31
"""


def git(folder: Path, *arguments: str, when: str = "2020-06-01T12:00:00 +0200") -> None:
    given = ("-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false")
    dated = {**os.environ, "GIT_COMMITTER_DATE": when, "GIT_AUTHOR_DATE": "2001-01-01T00:00:00 +0000"}
    subprocess.run(["git", *given, *arguments], cwd=folder, check=True, capture_output=True, env=dated)


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The warehouse robot, with a waiver of a year that is over."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "repository" / "robot"
    shutil.copytree(HERE / "warehouse", root)
    with (root / "requirements" / "v-model.yaml").open("a", encoding="utf-8") as file:
        file.write(WAIVER)
    assert command(root, "trace", "--accept-baseline")[0] == 0
    git(root.parent, "init", "-q")
    git(root.parent, "add", "-A")
    git(root.parent, "commit", "-qm", "first")
    return root


def test_the_day_of_the_commit_is_the_gate_s(robot: Path) -> None:
    assert "T231" in command(robot, "trace", "--gate")[1]
    assert "T231" not in command(robot, "trace", "--gate", "--day", "commit")[1]
    git(robot, "commit", "-q", "--allow-empty", "-m", "second", when="2021-01-01T00:30:00 +0200")
    assert "T231" in command(robot, "trace", "--gate", "--day", "commit")[1]
    assert "T231" not in command(robot, "trace", "--gate", "--day", "2020-12-31")[1]


def test_the_pages_of_an_assessment_have_the_day_of_the_commit(robot: Path) -> None:
    """Who builds a release of then again has its evidence as it was, and not with waivers that expired since."""
    matrix = robot / "out" / "assess" / "matrix.json"
    command(robot, "assess")
    assert "T231" in matrix.read_text("utf-8")
    command(robot, "assess", "--day", "commit")
    assert "T231" not in matrix.read_text("utf-8")
    status, _, err = command(robot, "assess", "--day", "2020-02-30")
    assert (status, "T348" in err) == (2, True)


def test_questions_and_the_argument_have_the_day_that_is_said(robot: Path) -> None:
    """Beside a question, `--day` went unheard: what is waived was counted as of today."""
    shutil.rmtree(robot / "out")  # so that no test was run
    for words in (("trace", "--statistics"), ("gsn",)):
        now, then = (command(robot, *words, *more)[1] for more in ((), ("--day", "commit")))
        assert now != then
        assert command(robot, *words, "--day", "2020-12-31")[1] == then
        status, _, err = command(robot, *words, "--day", "2020-02-30")
        assert (status, "T348" in err) == (2, True)
    assert "waived" in command(robot, "trace", "--statistics", "--day", "commit")[1]


def test_a_commit_is_not_made_before_those_that_it_comes_after(robot: Path) -> None:
    """Dated back, it would have a waiver hold that has expired."""
    git(robot, "commit", "-q", "--allow-empty", "-m", "second", when="2021-01-01T00:30:00 +0200")
    git(robot, "commit", "-q", "--allow-empty", "-m", "third", when="2020-07-01T12:00:00 +0200")
    assert day("commit", robot) == date(2021, 1, 1)
    assert "T231" in command(robot, "trace", "--gate", "--day", "commit")[1]


def test_a_history_that_is_cut_off(robot: Path, tmp_path: Path) -> None:
    """Dated back, a commit had a waiver hold that has expired, in the clone of one commit that continuous integration mostly has."""
    for when, now in (("2021-01-01T00:30:00 +0200", "second"), ("2020-07-01T12:00:00 +0200", "third")):
        git(robot, "commit", "-q", "--allow-empty", "-m", now, when=when)
    assert doubts("commit", day("commit", robot), robot) == []
    git(tmp_path, "clone", "-q", "--depth", "1", robot.parent.as_uri(), "clone")
    clone = tmp_path / "clone" / "robot"
    assert day("commit", clone) == date(2020, 7, 1)
    (found,) = doubts("commit", day("commit", clone), clone)
    assert (found.code, found.level) == ("T348", "warning")
    assert "2020-07-01" in found.message
    assert doubts("2020-07-01", date(2020, 7, 1), clone) == doubts(None, date.today(), clone) == []
    out = command(clone, "trace", "--as-is", "--day", "commit")[1]
    assert "warning[T348]" in out
    for words in (
        ("trace", "--statistics", "--day"),
        ("gsn", "--day"),
        ("case", "--format", "html", "--out", str(tmp_path), "--day"),
    ):
        assert "warning[T348]" in command(clone, *words, "commit")[2]
        assert "T348" not in command(clone, *words, "2020-07-01")[2]
    made = command(clone, "case", "--format", "html", "--out", str(tmp_path))  # as of the commit
    assert "warning[T348]" in made[2]


def test_a_history_that_is_as_long_as_was_asked_for(robot: Path, tmp_path: Path) -> None:
    """Git calls that clone shallow, too, and nothing of it is cut off."""
    git(robot, "commit", "-q", "--allow-empty", "-m", "second", when="2021-01-01T00:30:00 +0200")
    git(tmp_path, "clone", "-q", "--depth", "2", robot.parent.as_uri(), "clone")
    clone = tmp_path / "clone" / "robot"
    assert doubts("commit", day("commit", clone), clone) == []


def test_a_commit_that_is_yet_to_come(robot: Path) -> None:
    """Of the one that is checked out nobody knows the day; one before it, of a clock that was wrong, changes nothing."""
    git(robot, "commit", "-q", "--allow-empty", "-m", "second", when="2098-01-01T12:00:00 +0200")
    with pytest.raises(TrackmarshalError, match="2098-01-01, which is yet to come") as caught:
        day("commit", robot)
    assert caught.value.code == "T348"
    git(robot, "commit", "-q", "--allow-empty", "-m", "third", when="2020-07-01T12:00:00 +0200")
    assert day("commit", robot) == date(2020, 7, 1)


def test_the_report_says_the_day(robot: Path) -> None:
    assert command(robot, "trace", "--day", "commit")[1].startswith(
        "traceability of warehouse robot, 2020-06-01\n"
    )


def test_the_clock_s_day(robot: Path) -> None:
    assert day(None, robot) == date.today()


@pytest.mark.parametrize("said", ["2020-02-30", "yesterday", "", "20200601", "2020-W23-1"])
def test_what_is_no_day(said: str, robot: Path) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        day(said, robot)
    assert caught.value.code == "T348"
    assert command(robot, "trace", f"--day={said}")[0] == 2


def test_without_a_commit(robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    shutil.rmtree(robot.parent / ".git")
    status, _, err = command(robot, "trace", "--day", "commit")
    assert (status, "T348" in err) == (2, True)
    assert "git: not a git repository" in err
    monkeypatch.setenv("PATH", str(tmp_path))
    err = command(robot, "trace", "--day", "commit")[2]
    assert "T348" in err
    assert "git cannot be run" in err


def test_a_repository_in_which_nothing_is_committed(robot: Path) -> None:
    """Git's help was on how to tell revisions from paths."""
    shutil.rmtree(robot.parent / ".git")
    git(robot.parent, "init", "-q")
    err = command(robot, "trace", "--day", "commit")[2]
    assert "does not have any commits yet" in err
    assert "help: name a day" in err


def test_a_repository_that_git_does_not_trust(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a container that checks out as another user than it runs as: what git says, it says with what to do."""
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
    err = command(robot, "trace", "--day", "commit")[2]
    assert "T348" in err
    assert "detected dubious ownership" in err
    assert "git config --global --add safe.directory" in err


@pytest.mark.parametrize(
    "words", [("trace", "--as-is", "--day", "commit"), ("case", "--format", "html", "--out", "out")]
)
def test_git_speaks_of_a_path_that_the_locale_has_no_letters_for(robot: Path, words: tuple[str, ...]) -> None:
    """Whose words are not ASCII, as paths are in them, was an internal error where the locale is."""
    there = robot.parent.rename(robot.parent.with_name("Prüfstand")) / "robot"
    plain = {
        "LC_ALL": "C",
        "PYTHONCOERCECLOCALE": "0",
        "PYTHONUTF8": "0",
        "GIT_TEST_ASSUME_DIFFERENT_OWNER": "1",
    }
    done = subprocess.run(
        [sys.executable, "-m", "trackmarshal", *words], cwd=there, env={**os.environ, **plain}, capture_output=True, check=False,
    )  # fmt: skip
    assert b"internal error" not in done.stderr
    assert done.returncode == (2 if "trace" in words else 1), done.stderr


@pytest.mark.parametrize("if_there", [True, False])
def test_a_report_that_may_be_missing(if_there: bool, robot: Path) -> None:
    """Its tests were not run: what else there is decides. Where it is there, what failed fails the gate."""
    v_model = robot / "requirements" / "v-model.yaml"
    text = (
        v_model.read_text("utf-8")
        .replace("counts: [test]", "counts: [test, external test]")
        .replace(WAIVER, "")
    )
    entry = (
        "  junit: [{path: out/tests.json, stage: TST-1" + (", if_there: true" if if_there else "") + "}]\n"
    )
    v_model.write_text(text.replace("  default_spec: specs\n", f"  default_spec: specs\n{entry}"), "utf-8")
    assert (
        command(robot, "trace", "--accept-baseline", "--by", "Maria Motor", "--reason", "more is counted")[0]
        == 0
    )
    status, out, _ = command(robot, "trace", "--gate")
    assert (status, f"{'warning' if if_there else 'error'}[T330]" in out) == (int(not if_there), True)
    for outcome, wanted in (("passed", 0), ("failed", 1)):
        test = ExternalTest("t", "slow", ("SW-1",), outcome)
        save(
            robot / "out" / "tests.json",
            ResultsFile("external_tests", (test,), "1", "2026-01-01T00:00:00+00:00"),
        )
        status, out, _ = command(robot, "trace", "--gate")
        assert (status, "T330" in out, "T337" in out) == (wanted, False, bool(wanted))
