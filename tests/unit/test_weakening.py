"""A rule that is not what the baseline holds is told to be weaker or stronger, by margins on what the project recorded."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from support.project import command, run_command
from trackmarshal.cli.answers import Answers
from trackmarshal.cli.assessment import assess
from trackmarshal.cli.weakening import Weakening
from trackmarshal.store import FILE
from trackmarshal.trace.values import Placed

RULE = "  require   p.v <= v_event\n"
SLACK = 'param slack : m/s = 0 m/s in [-50, 50]  source "of nobody"\n'


def git(folder: Path, *arguments: str) -> None:
    given = ("user.name=n", "user.email=e", "commit.gpgsign=false", "protocol.file.allow=always")
    settings = [word for setting in given for word in ("-c", setting)]
    subprocess.run(["git", *settings, *arguments], cwd=folder, check=True, capture_output=True)


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new project with a parameter of its own, its baseline accepted and committed, in a folder of a repository; what it can be run with is there."""
    root = tmp_path_factory.mktemp("repository") / "car"
    assert run_command("init", str(root))[0] == 0
    spec = root / "specs" / "speed.spec"
    text = spec.read_text("utf-8").replace(RULE, "  require   p.v <= v_event + slack\n")
    spec.write_text(text.replace("rule speed_limit", SLACK + "\nrule speed_limit"), "utf-8")
    assert command(root, "trace", "--accept-baseline", "--by", "Ann", "--reason", "a parameter")[0] == 0
    git(root.parent, "init", "-q")
    git(root.parent, "add", "-A")
    git(root.parent, "commit", "-qm", "first")
    return root


@pytest.fixture
def car(template: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    shutil.copytree(template.parent, tmp_path / "repository")
    return tmp_path / "repository" / "car"


def rule(car: Path, limit: str) -> None:
    path = car / "specs" / "speed.spec"
    text = path.read_text("utf-8")
    assert "p.v <= v_event + slack\n" in text
    path.write_text(text.replace("p.v <= v_event + slack\n", f"{limit}\n"), "utf-8")


def slack(car: Path, value: str) -> None:
    path = car / "specs" / "speed.spec"
    text = path.read_text("utf-8")
    path.write_text(text.replace("m/s = 0 m/s in", f"m/s = {value} m/s in"), "utf-8")


def findings(car: Path, code: str, *more: str) -> list[str]:
    out = command(car, "trace", "--format", "json", *more)[1]
    return [one["message"] for one in json.loads(out)["findings"] if one["code"] == code]


@pytest.mark.parametrize(
    ("limit", "told"),
    [
        ("p.v <= v_event + slack + 9 m/s", "; weaker: 62 of 62 recorded cycles differ, violated is satisfied in "),
        ("p.v <= v_event + slack - 9 m/s", "; stronger: 62 of 62 recorded cycles differ, satisfied is violated in "),
        ("2 * p.v <= v_event + slack + 30 m/s", "; both weaker and stronger: "),
        ("p.v <= slack + v_event", "; not told: no recorded cycle of 62 tells the two apart"),
    ],
)  # fmt: skip
def test_a_changed_rule(limit: str, told: str, car: Path) -> None:
    rule(car, limit)
    (message,) = findings(car, "T370")
    assert message.startswith(
        "the rule `speed_limit` says something else than when the baseline was accepted"
    )
    assert told in message


def test_margins_are_those_of_the_edit(car: Path) -> None:
    rule(car, "p.v <= v_event + slack + 2 m/s")
    assert "margins move by +2 m/s" in findings(car, "T370")[0]


@pytest.mark.parametrize(("value", "word"), [("3", "weaker"), ("-3", "stronger")])
def test_a_moved_threshold(value: str, word: str, car: Path) -> None:
    slack(car, value)
    (message,) = findings(car, "T372")
    assert (
        f", and is {value} m/s, from -50 m/s, up to 50 m/s; {word}: 62 of 62 recorded cycles differ"
        in message
    )


def test_a_threshold_that_the_recording_sets_itself(car: Path) -> None:
    """The scenario has a speed limit of its own, which stands in place of the one before and of the one now: that no cycle tells the two apart is no wonder."""
    path = car / "specs" / "speed.spec"
    path.write_text(path.read_text("utf-8").replace("= 30 m/s", "= 45 m/s"), "utf-8")
    (message,) = findings(car, "T372")
    own = "; nothing is told of that by `too_fast`, which has speed.v_event = 30 m/s in place of 30 m/s and 45 m/s"
    assert message.endswith(f"; not told: no recorded cycle of 62 tells the two apart{own}")
    # Of an edit that it shows, that is not said.
    slack(car, "3")
    path.write_text(path.read_text("utf-8").replace("= 45 m/s", "= 30 m/s"), "utf-8")
    assert "nothing is told" not in findings(car, "T372")[0]


def test_it_is_told_once_and_kept(car: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rule(car, "p.v <= v_event + slack + 2 m/s")
    first = findings(car, "T370")
    kept = [json.loads(line) for line in (car / "out" / "results" / FILE).read_text("utf-8").splitlines()]
    (entry,) = [one for one in kept if one["kind"] == "comparison"]
    assert (entry["subject"], entry["result"]["word"]) == ("speed_limit", "weaker")

    def refused(*_: object) -> None:
        raise AssertionError("compared again")

    monkeypatch.setattr(Weakening, "_compared", refused)
    assert findings(car, "T370") == first == findings(car, "T370", "--as-is")


def test_another_rule_is_one_more_reason_to_compare(car: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is driven is decided by all rules: what a comparison came to holds for these rules only."""
    compared: list[list[str]] = []
    whole = Weakening._compared

    def listening(self, wanted):  # type: ignore[no-untyped-def]
        compared.append([*wanted])
        return whole(self, wanted)

    monkeypatch.setattr(Weakening, "_compared", listening)
    rule(car, "p.v <= v_event + slack + 2 m/s")
    for _ in range(2):
        assert findings(car, "T370")
    assert compared == [["speed_limit"]]
    path = car / "specs" / "speed.spec"
    more = '\nrule slow "Slower"\n  satisfies R-1\n  for all   p in plan\n  require   p.v <= 99 m/s\n'
    path.write_text(path.read_text("utf-8") + more, "utf-8")
    assert findings(car, "T370")
    assert compared == [["speed_limit"]] * 2


def test_another_track_is_one_more_reason_to_compare(car: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scenario names its track in a file of its own: what had been compared on the old one was told of the new one."""
    rule(car, "p.v <= v_event + slack + 2 m/s")
    assert findings(car, "T370")
    asked: list[list[str]] = []

    def listening(_: Weakening, wanted: dict[str, object]) -> list[tuple[str, str, str, bool]]:
        asked.append([*wanted])
        return [(name, "not told", "nothing", False) for name in wanted]

    monkeypatch.setattr(Weakening, "_compared", listening)
    track = car / "specs" / "tracks" / "straight.yaml"
    track.write_text(track.read_text("utf-8").replace("length: 1000", "length: 900"), "utf-8")
    assert findings(car, "T370")
    assert asked == [["speed_limit"]]


def test_where_nothing_changed_nothing_is_asked(car: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise AssertionError("asked")

    monkeypatch.setattr(Weakening, "__call__", refused)
    path = car / "specs" / "speed.spec"
    path.write_text("-- a comment\n" + path.read_text("utf-8"), "utf-8")
    assert command(car, "trace", "--gate")[0] == 0


def test_as_is_runs_nothing(car: Path) -> None:
    rule(car, "p.v <= v_event + slack + 2 m/s")
    assert "; not told: nothing is run" in findings(car, "T370", "--as-is")[0]


def test_of_a_kept_run_it_is_said_that_it_tells_nothing(car: Path) -> None:
    """It has verdicts and no margins, and its recording need not be here."""
    found = assess(car, run=False)
    before = json.loads((car / "requirements" / "baseline.json").read_text("utf-8"))["content"]
    (scenario,) = found.project.scenarios
    kept = replace(scenario, kept=Placed.at("specs/away.run.json", scenario.path.place))
    for given, ending in (
        (scenario, "not told: nothing is run"),
        (kept, "which has verdicts and no margins"),
    ):
        project = replace(found.project, scenarios=(given,))
        answers = Answers(car, car / project.results, False)
        told = Weakening(car, project, found.facts, answers, None)(before, ["rule speed_limit"])
        assert told["rule speed_limit"].endswith(ending)
        assert (f"the kept run of `{scenario.path}`" in told["rule speed_limit"]) is (given is kept)


def test_it_stays_in_the_acceptance_and_in_reports(car: Path) -> None:
    rule(car, "p.v <= v_event + slack + 2 m/s")
    refused = command(car, "trace", "--accept-baseline")
    assert (refused[0], "(weaker: 62 of 62 recorded cycles differ" in refused[2]) == (2, True)
    assert command(car, "trace", "--accept-baseline", "--by", "Ann", "--reason", "wider by 2 m/s")[0] == 0
    last = json.loads((car / "requirements" / "baseline.json").read_text("utf-8"))["acceptances"][-1]
    assert last["by"] == "Ann"
    assert "rule speed_limit: it says something else (weaker: 62 of 62" in last["weaker"][0]
    for format in ("json", "md", "html"):
        out = command(car, "trace", "--format", format)[1].replace("\\", "")
        assert "wider by 2 m/s" in out
        assert "(weaker: 62 of 62 recorded cycles differ" in out


def test_specs_that_were_not_accepted_are_not_compared(car: Path) -> None:
    """An edit that was committed without the baseline is no version of what was accepted; the commit of the baseline is."""
    rule(car, "p.v <= v_event + slack + 1 m/s")
    git(car, "commit", "-qam", "wider, and nobody accepted it")
    rule_text = car / "specs" / "speed.spec"
    rule_text.write_text(rule_text.read_text("utf-8").replace("+ 1 m/s", "+ 2 m/s"), "utf-8")
    assert "margins move by +2 m/s" in findings(car, "T370")[0]


def test_a_baseline_that_is_in_no_commit(car: Path) -> None:
    rule(car, "p.v <= v_event + slack + 1 m/s")
    assert command(car, "trace", "--accept-baseline", "--by", "Ann", "--reason", "wider")[0] == 0
    rule_text = car / "specs" / "speed.spec"
    rule_text.write_text(rule_text.read_text("utf-8").replace("+ 1 m/s", "+ 2 m/s"), "utf-8")
    assert "; not told: the specs that were accepted are in no commit at hand" in findings(car, "T370")[0]


def test_without_git(car: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(car.parent.parent))
    shutil.rmtree(car.parent / ".git")
    slack(car, "3")
    (message,) = findings(car, "T372")
    assert message.endswith("; not told: git has no history of the project")


def test_in_a_shallow_clone(car: Path, tmp_path: Path) -> None:
    """The commit of the baseline is out of reach: what is there is compared only if it is what was accepted."""
    rule(car, "p.v <= v_event + slack + 1 m/s")
    git(car, "commit", "-qam", "wider, and nobody accepted it")
    git(tmp_path, "clone", "-q", "--depth", "1", f"file://{car.parent}", "shallow")
    assert "; not told: " in findings(tmp_path / "shallow" / "car", "T370")[0]


def test_a_parameter_that_several_rules_read(car: Path) -> None:
    path = car / "specs" / "speed.spec"
    more = '\nrule slow "Slower"\n  satisfies R-1\n  for all   p in plan\n  require   p.v <= 99 m/s - slack\n'
    path.write_text(path.read_text("utf-8") + more, "utf-8")
    assert command(car, "trace", "--accept-baseline")[0] == 0
    git(car, "commit", "-qam", "another rule")
    slack(car, "3")
    (message,) = findings(car, "T372")
    assert message.endswith("; weaker: `speed_limit`, stronger: `slow`")
