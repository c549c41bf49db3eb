"""Faults that are planted into a small complete project are found, each as one cause; edits that mean nothing are not.

One in ten is planted every day, all of them at length.
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.length import shared_out
from support.planted import answers, documents, evidence, harmless, specs
from support.planted.edits import (
    BASELINE,
    STORE,
    Edit,
    Fault,
    Harmless,
    accepted,
    add,
    agreed,
    all_of,
    committed,
    cut,
    git,
    gone,
    moved,
    put,
    run_git,
    swap,
)
from support.planted.project import causes, judged, make
from support.project import command
from trackmarshal.cli import acceptances

FAULTS = [*documents.FAULTS, *specs.FAULTS, *evidence.FAULTS, *answers.FAULTS]
EDITS = [*harmless.EDITS, *answers.EDITS]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project as it was accepted, with its evidence."""
    return make(tmp_path_factory.mktemp("planted"))


@pytest.fixture
def project(made: Path, tmp_path: Path) -> Iterator[Path]:
    """A copy to edit."""
    yield shutil.copytree(made, tmp_path / "elsewhere" / made.name)
    shutil.rmtree(tmp_path)


def test_the_table_is_long_enough() -> None:
    assert len(FAULTS) >= 120
    assert len(EDITS) >= 40
    names = [*(fault.name for fault in FAULTS), *(edit.name for edit in EDITS)]
    twice = [name for name, number in Counter(names).items() if number > 1]
    assert twice == []


def test_as_it_is_the_gate_passes(project: Path) -> None:
    assert judged(project) == (0, [])
    assert judged(project, rerun=True) == (0, [])


@pytest.mark.parametrize("fault", shared_out(FAULTS, 10), ids=lambda fault: fault.name)
def test_a_planted_fault_is_one_cause(fault: Fault, project: Path) -> None:
    fault.edit(project)
    status, found = judged(project, fault.rerun, fault.today)
    assert causes(found) == [(fault.code, fault.subject)], found
    assert status == fault.status


@pytest.mark.parametrize("edit", shared_out(EDITS, 10), ids=lambda edit: edit.name)
def test_a_harmless_edit_is_none(edit: Harmless, project: Path) -> None:
    """What is new is told as a note, since its removal would go unnoticed."""
    edit.edit(project)
    status, found = judged(project)
    assert [(f["code"], f["message"]) for f in found if f["level"] != "note"] == []
    assert {f["code"] for f in found} <= {"T226"}
    assert status == 0


@pytest.mark.parametrize(
    "name",
    [
        "a title of a rule",
        "a title of a test",
        "rules in another order",
        "the baseline moved with all that was accepted",
        "another folder of the repository, with all that was accepted",
        "another folder of the repository, and something accepted",
        "another project in the repository, which is gone",
        "the baseline with the ends of lines of Windows",
        "a report that may be missing, accepted when nobody was asked for a name",
        "the baseline taken back over an acceptance, restored, and less accepted by name",
        "a requirement struck with its entry, there again, and struck by name",
        "an acceptance merged",
        "less accepted twice, and more again, in one commit",
        "acceptances of two branches, and one more of both",
        "acceptances of two branches, and one more of both, merged where they began",
        "acceptances of two branches, and one more on top of the other's",
        "acceptances of two branches, and one more on top of the other's, not committed",
        "acceptances of two branches, and one more on top of the other's, merged where they began",
    ],
)
def test_what_is_worded_otherwise_comes_out_again(name: str, project: Path) -> None:
    """Running everything again accuses nobody of an edit that results do not depend on."""
    next(edit for edit in EDITS if edit.name == name).edit(project)
    assert judged(project, rerun=True) == (0, [])


def test_two_faults_are_two_causes(project: Path) -> None:
    """What they have in common, an open cell, hides neither."""
    swap("specs/rules.spec", "expect violated, margin -1 m/s^2", "expect satisfied")(project)
    swap("requirements/requirements.yaml", "no faster than 12 m/s", "no faster than 13 m/s")(project)
    put("docs/planner.md", b"x")(project)
    status, found = judged(project)
    assert sorted(causes(found)) == [
        ("T225", "S-1"),
        ("T373", "docs/planner.md at S-2-A"),
        ("T374", "braking"),
    ]
    assert status == 1


@pytest.mark.parametrize(
    ("file", "code", "subject"),
    [(evidence.HURRY, "T240", evidence.HURRY), ("docs/planner.md", "T250", "docs/planner.md")],
)
@pytest.mark.parametrize(
    ("edit", "also", "what"),
    [
        (cut("specs/rules.spec", "rule speed_limit", "rule braking"), "T222", "speed_limit"),
        (
            swap("requirements/requirements.yaml", "no faster than 12 m/s", "no faster than 13 m/s"),
            "T225",
            "S-1",
        ),
    ],
)
def test_where_a_file_is_not_there_nothing_else_was_changed_since(
    file: str, code: str, subject: str, edit: Edit, also: str, what: str, project: Path
) -> None:
    """It was told as a consequence that a rule is gone, and a statement another one, and met only when the file was there again."""
    all_of(gone(file), edit)(project)
    assert sorted(causes(judged(project)[1])) == [(also, what), (code, subject)]


UNTESTED = """
rule gentle "No harder than is comfortable"
  satisfies S-2
  for all   p in plan
  require   p.a >= -3 m/s^2
"""


@pytest.mark.parametrize(
    ("edit", "also"),
    [
        (swap("specs/signals.spec", "a: m/s^2 in [-20, 10]", "a: m/s^2 in [-90, 90]"), ("T372", "plan")),
        (cut("requirements/hazards.yaml", "    tolerance:", "\n"), ("T120", "")),
    ],
    ids=["a contract", "a goal without a tolerance"],
)
def test_that_a_rule_has_no_test_hides_behind_no_document(
    edit: Edit, also: tuple[str, str], project: Path
) -> None:
    """No goal, contract or statement is a reason for it: it was told as a consequence, and met only when these were mended."""
    all_of(edit, add("specs/rules.spec", UNTESTED))(project)
    found = causes(judged(project)[1])
    assert ("T211", "gentle") in found
    assert also in found


def test_a_test_of_another_rule_does_not_fail_since_a_rule_is_gone(project: Path) -> None:
    """From the rule to a contract that it read, and from there to whatever reads the same, a failed test of a new rule was told to follow."""
    failing = UNTESTED + '\ntest gentle "coasting"\n  given  plan = line(v: 5 m/s)\n  expect violated\n'
    all_of(
        cut("specs/rules.spec", "rule speed_limit", "rule braking"),
        cut("specs/rules.spec", 'test speed_limit "at the limit"', 'test braking "as hard'),
        swap("specs/signals.spec", "v: m/s in [-5, 30], a: m/s^2", "v: m/s in [-5, 40], a: m/s^2"),
        add("specs/rules.spec", failing),
    )(project)
    found = causes(judged(project)[1])
    assert ("T222", "speed_limit") in found
    assert ("T215", "gentle") in found


def test_a_gate_that_is_written_down_hides_nothing_that_is_gone(project: Path) -> None:
    """It is no setting of the project of which it comes that less is read."""
    next(f for f in evidence.FAULTS if f.name == "a gate where there was none").edit(project)
    cut("requirements/requirements.yaml", "  - id: S-9\n", "")(project)
    assert sorted(causes(judged(project)[1])) == [("T223", "S-9"), ("T371", "gate")]


def test_results_edited_by_hand_are_found_only_by_running_again(project: Path) -> None:
    """That is what the page on evidence says of hashes that were made again: it is not claimed to be noticed without."""
    fault = next(f for f in evidence.FAULTS if f.name == "a run that did not fire, its hash made again")
    fault.edit(project)
    assert judged(project)[0] == 0
    assert judged(project, rerun=True)[0] == 1


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("a shallow clone", "the history of the clone is cut"),
        ("no git", "not a git repository"),
        ("of somebody else", "detected dubious ownership"),
        ("never committed", "does not have any commits yet"),
    ],
)
def test_whoever_accepted_the_baseline_is_not_known(
    how: str, said: str, project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A warning of `--rerun`: nothing is wrong, and nothing shows that all is well."""
    match how:
        case "a shallow clone":
            (project / "docs" / "notes.md").write_text("# Notes\n", "utf-8")
            run_git(project, "add", ".")
            run_git(project, "commit", "-qm", "notes")
            run_git(tmp_path, "clone", "-q", "--depth", "1", f"file://{project}", "shallow")
            shutil.copytree(project / "out", tmp_path / "shallow" / "out", dirs_exist_ok=True)
            project = tmp_path / "shallow"
        case "no git":
            shutil.rmtree(project / ".git")
        case "of somebody else":  # as in a container that checks out as another user than it runs as
            monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
        case _:
            shutil.rmtree(project / ".git")
            run_git(project, "init", "-q")
    status, found = judged(project, rerun=True)
    assert causes(found) == [("T381", "")]
    assert (status, found[0]["level"]) == (0, "warning")
    assert said in found[0]["message"]
    assert ("safe.directory" in found[0]["help"]) == (how == "of somebody else")


def test_a_clone_without_contents_knows_of_no_acceptance(project: Path, tmp_path: Path) -> None:
    """What the baseline was is fetched when it is asked for: where that cannot be, all versions were taken for none, and one changed by hand was green."""
    fault = next(f for f in FAULTS if f.name == "a requirement struck with its entry, and something else accepted on top of it")  # fmt: skip
    fault.edit(project)
    run_git(project, "config", "uploadpack.allowFilter", "true")
    run_git(tmp_path, "clone", "-q", "--filter=blob:none", f"file://{project}", "partial")
    partial = tmp_path / "partial"
    shutil.copytree(project / "out", partial / "out", dirs_exist_ok=True)
    run_git(partial, "remote", "set-url", "origin", (tmp_path / "nowhere").as_uri())
    assert causes(judged(partial, rerun=True)[1]) == [("T381", "")]
    run_git(partial, "remote", "set-url", "origin", project.as_uri())
    assert causes(judged(partial, rerun=True)[1]) == [("T380", "")]


@pytest.mark.parametrize("where", ["the environment", "the settings"])
def test_nobody_hides_where_a_project_was(where: str, project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for part in ("requirements", "specs", "docs"):
        moved(part, f"campus/{part}")(project)
    cut("campus/requirements/requirements.yaml", "  - id: S-9\n", "")(project)
    (project / "campus" / BASELINE).unlink()
    all_of(lambda root: agreed(lambda _: None)(root / "campus"), git("add", "-A", "."), committed("moved"))(project)  # fmt: skip
    if where == "the environment":
        monkeypatch.setenv("GIT_LITERAL_PATHSPECS", "1")
    else:
        run_git(project, "config", "diff.relative", "true")
    assert causes(judged(project / "campus", rerun=True)[1]) == [("T380", "")]


@pytest.mark.parametrize(("number", "told"), [(4, []), (3, [("T381", "")])])
def test_versions_that_are_not_looked_at_are_told(
    number: int, told: list[tuple[str, str]], project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first one, and three more: what is older than those that are looked at, nobody knows."""
    monkeypatch.setattr(acceptances, "MOST", number)
    for line in "one", "two", "three":
        all_of(agreed(add("docs/planner.md", f"\n{line}\n")), committed(line))(project)
    status, found = judged(project, rerun=True)
    assert (status, causes(found)) == (0, told)


@pytest.mark.parametrize("way", [["campus"], ["vehicles/one", "vehicles/two"]])
@pytest.mark.parametrize("anew", [False, True])
def test_a_project_in_another_folder_has_the_history_that_it_had(
    way: list[str], anew: bool, project: Path
) -> None:
    """Down and beside; one that begins anew there, with less, does not."""
    here = "."
    for to in way:
        for part in ("requirements", "specs", "docs"):
            moved(f"{here}/{part}", f"{to}/{part}")(project)
        last = anew and to == way[-1]
        if last:
            cut(f"{to}/requirements/requirements.yaml", "  - id: S-9\n", "")(project)
            (project / to / BASELINE).unlink()
            status, _, err = command(project / to, "trace", "--accept-baseline")
            assert status == 0, err
        all_of(git("add", "-A", "."), committed("moved"))(project)
        here = to
    status, found = judged(project / way[-1], rerun=True)
    assert (status, causes(found)) == ((1, [("T380", "")]) if anew else (0, []))


def test_nothing_is_accepted_on_top_of_what_nobody_accepted(project: Path) -> None:
    """An entry struck by hand would be gone without a name, and the acceptance would say that nothing is less."""
    accepted(lambda held: held["content"].pop("requirement S-9"), rehash=False)(project)
    before = (project / BASELINE).read_bytes()
    status, _, err = command(project, "trace", "--accept-baseline", "--by", "Sam Safety", "--reason", "tidy")
    assert (status, "error[T379]" in err) == (2, True), err
    assert (project / BASELINE).read_bytes() == before


def test_a_baseline_restored_is_as_it_was(project: Path) -> None:
    """What was in between does not count any more, and what is accepted later counts."""
    before = (project / BASELINE).read_bytes()
    fault = next(
        f for f in evidence.FAULTS if f.name == "an entry of the baseline removed, its hash made again"
    )
    fault.edit(project)
    assert ("T380", "") in causes(judged(project, rerun=True)[1])
    all_of(put(BASELINE, before), committed("restored"))(project)
    assert judged(project, rerun=True) == (0, [])


def test_a_baseline_restored_and_accepted_at_once_is_as_it_was(project: Path) -> None:
    """As the message says; and so it stays when something else is accepted later."""
    before = (project / BASELINE).read_bytes()
    fault = next(
        f for f in evidence.FAULTS if f.name == "an entry of the baseline removed, its hash made again"
    )
    fault.edit(project)
    more = add("docs/planner.md", "\nmore\n")
    all_of(put(BASELINE, before), agreed(more), committed("restored"))(project)
    assert judged(project, rerun=True) == (0, [])
    all_of(agreed(more), committed("more"))(project)
    assert judged(project, rerun=True) == (0, [])


@pytest.mark.parametrize(
    "name",
    ["another folder of the repository, and a baseline", "another file named as the baseline, committed"],
)
def test_a_baseline_that_was_elsewhere_is_restored_as_the_message_says(name: str, project: Path) -> None:
    next(fault for fault in FAULTS if fault.name.startswith(name)).edit(project)
    (found,) = (one for one in judged(project, rerun=True)[1] if one["code"] == "T380")
    show, _, file = found["help"].partition("`git ")[2].partition("`")[0].partition(" > ")
    (project / file).write_text(run_git(project, *show.split()), "utf-8")
    all_of(agreed(lambda _: None), committed("restored"))(project)
    assert judged(project, rerun=True) == (0, [])


def test_no_rule_lacks_a_test_since_another_one_does(project: Path) -> None:
    """A run that fires where it may not leaves cells open: it was told as a consequence of the first rule without a test, and so were all others."""
    rules = "".join(
        f'\nrule {name} "Not so fast"\n  satisfies {id_}\n  for all   p in plan\n  require   p.v <= 9 m/s\n'
        for name, id_ in (("slow", "S-1"), ("slower", "S-4"))
    )
    one_side = '\ntest slow "at it"\n  given  plan = line(v: 9 m/s)\n  expect satisfied, margin 0 m/s\n'
    add("specs/rules.spec", rules + one_side)(project)
    found = causes(judged(project)[1])
    fired = ("T243", "specs/scenarios/hurry.tmrec.jsonl")  # of which open cells are the consequence
    assert {("T212", "slow"), ("T211", "slower"), fired} <= set(found)


def test_a_changed_scenario_hides_no_rule_without_a_test(project: Path) -> None:
    """It was told as a consequence: whoever accepted the scenario met it only then."""
    for name in ("a speed of a recording changed", "a rule without a test"):
        next(fault for fault in FAULTS if fault.name == name).edit(project)
    assert {code for code, _ in causes(judged(project)[1])} == {"T375", "T211"}


def test_nothing_is_written_but_results(project: Path) -> None:
    """A gate that changes what it judges would be none."""
    (project / STORE).unlink()
    judged(project)
    assert run_git(project, "status", "--porcelain").split() in ([], ["M", STORE])


def test_a_test_of_another_runner_is_skipped_where_a_waiver_answers_for_the_gap(project: Path) -> None:
    """The waiver answers for something else; that a test was skipped was a warning, and nobody was named for it."""
    agreed(all_of(evidence.REPORTED, evidence.HALF, evidence.verifying("")))(project)
    evidence.verifying("<skipped/>")(project)
    status, found = judged(project)
    assert (status, sorted(causes(found))) == (
        1,
        [("T221", f"S-2 in {evidence.REPORT} at S-3-B"), ("T338", "slow")],
    )
    agreed(lambda _: None)(project)
    assert (judged(project)[0], causes(judged(project)[1])) == (0, [("T338", "slow")])
