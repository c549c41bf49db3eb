"""What an edit changes on recordings, held against what the recordings' own numbers say."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import trackmarshal as tm
from support.schemas import hold
from trackmarshal.cli.diff import _renamed as renamed_by
from trackmarshal.cli.main import main
from trackmarshal.comparing import (
    EQUAL,
    GONE,
    MIXED,
    NEW,
    NOT_COMPARABLE,
    STRICTER,
    WEAKER,
    Pair,
    RuleChange,
    compare,
    compared,
    judge,
)
from trackmarshal.comparing.changes import Column, changed
from trackmarshal.comparing.render import data, markdown, text
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.scenarios.recording import CANDIDATES, Recording
from trackmarshal.scenarios.recording_io import write

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "golden" / "diff"
CUT_IN = ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl"
SPEC = """module m
signal plan : trajectory {{ t: s increasing, v: m/s in [-10, 150], a: m/s^2 in [-50, 50] }}
{rules}
"""


@cache
def recording() -> Recording:
    """A shipped recording without its vehicle, which the small specs here do not know."""
    return replace(
        tm.load_recording(str(CUT_IN.with_name("free_lap.tmrec.jsonl"))), params={}, tables={}, use=()
    )


def evaluator(*rules: str) -> tm.Evaluator:
    return tm.Evaluator(tm.loads(SPEC.format(rules="\n".join(rules))))


def slow(limit: str, name: str = "slow") -> str:
    return f'rule {name} "Slow" for all p in plan require p.v <= {limit}'


def fastest() -> np.ndarray:
    """(cycles, candidates): the greatest speed of each, m/s, from the file itself."""
    return np.array(
        [[max(cycle.candidates[name]["v"]) for name in CANDIDATES] for cycle in recording().cycles]
    )


def only(old: tm.Evaluator, new: tm.Evaluator) -> RuleChange:
    (change,) = compare(old, new, [recording()])
    return change


def limits() -> tuple[float, float]:
    """Two speeds between which some cycles lie, and not all."""
    low, high = np.quantile(fastest(), [0.3, 0.7])
    return float(low), float(high)


def test_the_same_is_equal() -> None:
    change = only(evaluator(slow("40 m/s")), evaluator(slow("40 m/s")))
    assert (change.word, change.changed, change.flips, change.margins) == (EQUAL, 0, (), None)
    assert change.cycles == 2 * len(recording().cycles)


def test_a_lower_limit_is_stricter_and_a_higher_one_weaker() -> None:
    low, high = limits()
    there = fastest()
    turned = (there > low) & (there <= high)
    assert 0 < turned.sum() < turned.size
    for limit, before, word, way in [
        (low, high, STRICTER, ("satisfied", "violated")),
        (high, low, WEAKER, ("violated", "satisfied")),
    ]:
        change = only(evaluator(slow(f"{before!r} m/s")), evaluator(slow(f"{limit!r} m/s")))
        assert change.word == word
        assert {(flip.old, flip.new) for flip in change.flips} == {way}
        for place, name in enumerate(CANDIDATES):
            cycles = sum(flip.cycles for flip in change.flips if flip.candidate == name)
            assert cycles == turned[:, place].sum()
            inside = {
                cycle.t for flip in change.flips if flip.candidate == name for a, b in flip.spans
                for cycle in recording().cycles if a <= cycle.t <= b
            }  # fmt: skip
            assert inside == {cycle.t for cycle, yes in zip(recording().cycles, turned[:, place]) if yes}
        deltas = (limit - there) - (before - there)
        assert change.margins is not None
        assert change.changed == change.margins.cycles == there.size
        assert change.margins.least == deltas.min()
        assert change.margins.most == deltas.max()
        assert change.margins.median == np.median(deltas)


def test_on_the_boundary_the_verdict_alone_turns() -> None:
    """`<=` becomes `<`: margins stay, and of a margin of zero the verdict turns."""
    limit = float(fastest()[3, 0])
    change = only(evaluator(slow(f"{limit!r} m/s")), evaluator(slow(f"{limit!r} m/s").replace("<=", "<")))
    assert change.word == STRICTER
    assert change.margins is None
    assert change.changed == sum(flip.cycles for flip in change.flips) == (fastest() == limit).sum()


def test_both_ways_is_mixed() -> None:
    middle = float(np.median(fastest()))
    mirrored = f'rule slow "" for all p in plan require {2 * middle!r} m/s - p.v >= p.v'
    assert only(evaluator(slow(f"{middle!r} m/s")), evaluator(mirrored)).word == MIXED


def test_another_unit_is_not_comparable() -> None:
    change = only(
        evaluator(slow("40 m/s")), evaluator('rule slow "" for all p in plan require p.a <= 4 m/s^2')
    )
    assert change.word == NOT_COMPARABLE
    assert change.margins is None
    assert change.changed > 0


BOTH = 'rule slow "" for all p in plan require p.v <= {} and {} <= {}'


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ((BOTH.format("32 m/s", "p.a", "5 m/s^2"),), (BOTH.format("31 m/s", "p.a", "5 m/s^2"),), STRICTER),
        ((BOTH.format("32 m/s", "p.a", "5 m/s^2"),), (BOTH.format("32 m/s", "p.t", "90 s"),), NOT_COMPARABLE),
        (
            ("scale m/s = 5 m/s", BOTH.format("32 m/s", "p.a", "5 m/s^2")),
            ("scale m/s = 5 m/s", BOTH.format("31 m/s", "p.a", "5 m/s^2")),
            STRICTER,
        ),
        (
            ("scale m/s = 5 m/s", BOTH.format("32 m/s", "p.a", "5 m/s^2")),
            ("scale m/s = 500 m/s", BOTH.format("32 m/s", "p.a", "5 m/s^2")),
            NOT_COMPARABLE,
        ),
    ],
)
def test_margins_of_other_dimensions_or_scales_are_not_comparable(
    old: tuple[str, ...], new: tuple[str, ...], word: str
) -> None:
    """A rule that demands the same was called stricter where each of its margins is divided by more."""
    before, after = evaluator(*old), evaluator(*new)
    change = only(before, after)
    assert (change.word, change.margins is None) == (word, word == NOT_COMPARABLE)
    said = " ".join(text(compared([Pair(judge(before, recording()), judge(after, recording()))])))
    assert not re.search(r"\d (mixed|scaled)\b", said.partition("rules:")[0]), said


def test_new_gone_and_renamed() -> None:
    old = evaluator(slow("40 m/s"), slow("30 m/s", "a"), slow("20 m/s", "b"))
    new = evaluator(slow("40 m/s"), slow("30 m/s", "c"), slow("10 m/s", "d"))
    found = {change.name: change for change in compare(old, new, [recording()])}
    assert {name: (change.word, change.was) for name, change in found.items()} == {
        "slow": (EQUAL, ""), "c": (EQUAL, "a"), "d": (NEW, ""), "b": (GONE, ""),
    }  # fmt: skip
    assert found["d"].unsafe == (fastest() > 10).sum()
    assert found["b"].unsafe == (fastest() > 20).sum()
    told = {change.name: change for change in compare(old, new, [recording()], {"b": "d"})}
    assert (told["d"].word, told["d"].was) == (STRICTER, "b")
    assert not compared([Pair(judge(old, recording()), judge(new, recording()))]).equal


def test_two_of_the_same_formula_are_no_renaming() -> None:
    old = evaluator(slow("40 m/s"), slow("30 m/s", "a"))
    new = evaluator(slow("40 m/s"), slow("30 m/s", "c"), slow("30 m/s", "d"))
    assert [(change.name, change.word) for change in compare(old, new, [recording()])] == [
        ("slow", EQUAL),
        ("c", NEW),
        ("d", NEW),
        ("a", GONE),
    ]


def test_a_rule_that_only_warns_is_weaker() -> None:
    old, new = (
        evaluator(slow("40 m/s"), slow("10 m/s", "a")),
        evaluator(slow("40 m/s"), slow("10 m/s", "a") + " severity advisory"),
    )
    for before, after, word in [(old, new, WEAKER), (new, old, STRICTER)]:
        made = compared([Pair(judge(before, recording()), judge(after, recording()))])
        assert made.rules[1].word == word
        assert made.rules[1].changed == 0
        assert made.rules[1].severity is not None
        assert sum(one.cycles for one in made.decisions) > 0
        assert not made.equal


def test_later_verdicts_of_rules_over_the_run_count() -> None:
    """What looks ahead is open in its own cycle; the verdict that it gets later is what is compared."""
    rules = [
        f'rule soon "" require eventually[0 s, 0.5 s] (for all p in plan: p.v <= {limit} m/s)'
        for limit in (1000, 0)
    ]
    change = only(evaluator(rules[0]), evaluator(rules[1]))
    assert change.word == STRICTER
    assert {(flip.old, flip.new) for flip in change.flips} >= {("satisfied", "violated")}


def test_every_change_has_a_direction_or_is_not_comparable() -> None:
    """Every pair of verdicts and margins by hand: what is undefined is no less against a candidate than what is violated."""
    rule = evaluator(slow("40 m/s")).rules[0]
    nan, inf = float("nan"), float("inf")
    cases = [
        ("satisfied", 1.0, "satisfied", 1.0, EQUAL), ("satisfied", 1.0, "satisfied", 0.5, STRICTER), ("satisfied", 1.0, "violated", -1.0, STRICTER),
        ("satisfied", 0.0, "violated", 0.0, STRICTER), ("violated", 0.0, "satisfied", 0.0, WEAKER), ("satisfied", 1.0, "undefined", nan, STRICTER),
        ("undefined", nan, "satisfied", 1.0, WEAKER), ("undefined", nan, "undefined", nan, EQUAL), ("undefined", nan, "violated", -1.0, NOT_COMPARABLE),
        ("violated", -1.0, "undefined", nan, NOT_COMPARABLE), ("inactive", inf, "satisfied", 1.0, STRICTER), ("satisfied", 1.0, "inactive", inf, WEAKER),
        ("inactive", inf, "satisfied", inf, NOT_COMPARABLE), ("open", nan, "satisfied", 1.0, NOT_COMPARABLE), ("violated", -1.0, "open", nan, NOT_COMPARABLE), ("open", nan, "open", nan, EQUAL),
        ("inactive", inf, "inactive", inf, EQUAL), ("violated", -inf, "violated", -inf, EQUAL), ("satisfied", 0.0, "satisfied", -0.0, EQUAL),
    ]  # fmt: skip
    for was, before, is_, after, word in cases:
        both = (
            np.ones((1, 2), np.bool_),
            np.full((1, 2), VERDICTS.index(was), np.uint8),
            np.full((1, 2), VERDICTS.index(is_), np.uint8),
        )
        column = Column("r", np.zeros(1), *both, np.full((1, 2), before), np.full((1, 2), after))
        change = changed(rule, rule, [column])
        assert change.word == word, (was, before, is_, after)
        assert bool(change.changed or change.undecided) == (word != EQUAL)
    assert changed(rule, rule, []).word == NOT_COMPARABLE


@pytest.mark.parametrize("format", ["txt", "md", "json"])
def test_formats(format: str) -> None:
    """Word for word."""
    old = evaluator(
        slow("32 m/s"),
        slow("31 m/s", "a"),
        slow("33 m/s", "b"),
        slow("32.5 m/s", "warns"),
        slow("40 m/s", "same"),
    )
    new = evaluator(
        slow("30 m/s"),
        slow("31 m/s", "a_2"),
        slow("29 m/s", "d"),
        slow("32.5 m/s", "warns") + " severity advisory",
        slow("40 m/s", "same"),
    )
    made = compared([Pair(judge(old, recording()), judge(new, recording()))])
    lines = {"txt": text, "md": markdown}.get(format)
    actual = ("\n".join(lines(made)) if lines else json.dumps(data(made), indent=1)) + "\n"
    path = GOLDEN / f"comparison.{format}"
    if os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1":
        path.parent.mkdir(exist_ok=True)
        path.write_text(actual, encoding="utf-8")
    assert actual == path.read_text(encoding="utf-8")


def git(folder: Path, *arguments: str) -> None:
    identity = [
        "-c",
        "user.name=n",
        "-c",
        "user.email=e",
        "-c",
        "commit.gpgsign=false",
        "-c",
        "protocol.file.allow=always",
    ]
    subprocess.run(["git", *identity, *arguments], cwd=folder, check=True, capture_output=True)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with a project in a folder of it, committed."""
    root = tmp_path / "repository" / "project"
    for name in ("requirements", "specs/supervisor", "specs/vehicles", "specs/tracks", "specs/variants"):
        shutil.copytree(ROOT / name, root / name)
    (root / "specs" / "scenarios").mkdir()
    shutil.copy(CUT_IN, root / "specs" / "scenarios")
    git(root.parent, "init", "-q")
    git(root.parent, "add", "-A")
    git(root.parent, "commit", "-qm", "first")
    monkeypatch.chdir(root)
    return root


@pytest.mark.acceptance
def test_a_revision_beside_what_is_here(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    on = ["--on", "specs/scenarios/cut_in.tmrec.jsonl", "--quiet"]
    assert main(["diff", "HEAD", ".", *on]) == 0
    assert "equal" in capsys.readouterr().out
    conduct = project / "specs" / "supervisor" / "conduct.spec"
    conduct.write_text(
        conduct.read_text().replace("p.v <= min(v_event, v_max)", "p.v <= min(v_event, v_max) - 60 m/s")
    )
    assert main(["diff", "HEAD", ".", *on]) == 1
    assert capsys.readouterr().out.startswith("speed_limit: stricter, ")
    asked = ["diff", ".", "HEAD", *on, "--exit-zero", "--format", "json"]
    assert main(asked) == 0
    out = capsys.readouterr().out
    hold(asked, out)
    words = {rule["name"]: rule["word"] for rule in json.loads(out)["rules"]}
    assert words.pop("speed_limit") == "weaker"
    assert set(words.values()) == {"equal"}
    assert main(["diff", "HEAD", "specs/supervisor", *on, "--format", "md"]) == 1
    assert "| speed\\_limit | stricter" in capsys.readouterr().out
    assert not [path for path in project.parent.rglob("*") if "trackmarshal-diff" in path.name]


def test_an_edit_that_a_recording_does_not_show(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It has its own value in place of both: that nothing differs says nothing of the edit."""
    rules = """module m
signal plan : trajectory {{ t: s increasing, v: m/s }}
param top : m/s = {top} m/s in [0, 150] source "us"
param low : m/s = -1 m/s in [-10, 150] source "us"
table most(v: m/s) -> m/s = linear clamp
  | 0 m/s: 90 m/s | 100 m/s: {top} m/s |
  source "us"
rule r "r"
  for all p in plan
  require p.v in [low, top] and p.v <= most(p.v)
"""
    for name, top in (("old", 30), ("new", 29)):
        (tmp_path / f"{name}.spec").write_text(rules.format(top=top))
    sides = [str(tmp_path / f"{name}.spec") for name in ("old", "new")]
    recording = replace(tm.load_recording(CUT_IN), use=(), params={}, tables={})
    own = replace(recording, params={"top": 50.0, "low": -2.0}, tables={"most": [[0.0, 90.0], [100.0, 90.0]]})
    for one, name in ((recording, "plain"), (own, "own")):
        write(replace(one, name=name), tmp_path / f"{name}.tmrec.jsonl")
    assert main(["diff", *sides, "--on", str(tmp_path / "plain.tmrec.jsonl")]) == 1
    assert "note:" not in capsys.readouterr().err
    assert main(["diff", *sides, "--on", str(tmp_path / "own.tmrec.jsonl")]) == 0
    found = capsys.readouterr()
    assert found.out.startswith("rules: 1 equal")
    assert [line for line in found.err.splitlines() if line.startswith("note:")] == [
        "note: own does not show an edit: it has m.top = 50 m/s in place of 30 m/s and 29 m/s",
        "note: own does not show an edit: it has the table m.most in place of both",
    ]


def test_a_rule_of_which_a_recording_lacks_what_it_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Undefined on both sides is the same, whatever the edit."""
    rules = """module m
signal plan : trajectory {{ t: s increasing, v: m/s }}
signal weather : state {{ temperature: 1 }}
rule slow "r"
  for all p in plan
  require p.v <= 90 m/s
rule warm "r"
  require weather.temperature >= {least}
"""
    for name, least in (("old", 0), ("new", 30)):
        (tmp_path / f"{name}.spec").write_text(rules.format(least=least))
    sides = [str(tmp_path / f"{name}.spec") for name in ("old", "new")]
    recording = replace(tm.load_recording(CUT_IN), use=(), params={}, tables={})
    write(recording, tmp_path / "r.tmrec.jsonl")
    for quiet in ([], ["--quiet"]):
        assert main(["diff", *sides, "--on", str(tmp_path / "r.tmrec.jsonl"), *quiet]) == 0
        notes = [line for line in capsys.readouterr().err.splitlines() if line.startswith("note:")]
        assert notes == [f"note: {recording.name} shows nothing of `warm`: undefined in every cycle"]


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["nothing", "."], "T361"),
        (["--", "-x", "."], "T361"),
        ([".", ".", "--spec", "specs/other.spec"], "T362"),
        ([".", ".", "--renamed", "a=b"], "T362"),
        (["specs/supervisor", "specs/supervisor", "--spec", "specs/variants"], "T362"),
    ],
)
def test_what_cannot_be_compared(
    arguments: list[str], code: str, project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["diff", "--on", "specs/scenarios/cut_in.tmrec.jsonl", "--quiet", *arguments]) == 2
    assert f"error[{code}]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "said"),
    [(["a=b", "a=c"], "the old rule `a` twice"), (["a=c", "b=c"], "the new rule `c` twice")],
)
def test_a_rule_has_one_other_name(given: list[str], said: str) -> None:
    """Of `a=b` and `a=c` the last one counted."""
    with pytest.raises(tm.TrackmarshalError, match=said) as caught:
        renamed_by(given, [])
    assert caught.value.code == "T362"
    assert renamed_by(["a=b", "b=a"], []) == {"a": "b", "b": "a"}
    assert renamed_by([], []) == {}


def test_without_git_or_history(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    on = ["--on", str(CUT_IN), "--quiet"]
    git(project, "commit", "-q", "--allow-empty", "-m", "second")
    git(tmp_path, "clone", "-q", "--depth", "1", f"file://{project.parent}", "shallow")
    monkeypatch.chdir(tmp_path / "shallow" / "project")
    assert main(["diff", "HEAD~1", ".", *on]) == 2
    assert "the clone is shallow" in capsys.readouterr().err
    shutil.copytree(project, tmp_path / "plain")
    monkeypatch.chdir(tmp_path / "plain")
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    assert main(["diff", "HEAD", ".", *on]) == 2
    assert "no revision" in capsys.readouterr().err
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["diff", "HEAD", ".", *on]) == 2
    assert "git is missing" in capsys.readouterr().err
