"""What people answer: a text that says nothing is no answer, and a review that fell is told for itself."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from support.planted.project import SOURCE
from support.project import command
from support.safety_case import edit

NEEDS, PEOPLE = "requirements/requirements.yaml", "requirements/assurance.yaml"
REVIEW = "  - {{id: RV-2, of: [{{id: {id}, fingerprint: '{print}'}}], by: [P-4], made: 2026-03-01, outcome: {outcome}}}\nworks:\n"


@pytest.fixture
def shuttle(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SOURCE, tmp_path / "shuttle"))


def findings(project: Path, *codes: str) -> list[dict[str, object]]:
    _, out, _ = command(project, "trace", "--as-is", "--format", "json")
    return [found for found in json.loads(out)["findings"] if found["code"] in codes]


@pytest.mark.parametrize(
    ("answer", "nothing"), [("-", True), ("...", True), ("?!", True), ("7", False), ("是", False)]
)
def test_an_answer_without_a_word_is_none(shuttle: Path, answer: str, nothing: bool) -> None:
    """A defeater that was answered by `-` defeated nothing any more."""
    said = f"document: argument\ntitle: t\ndefeaters:\n  - {{id: D-1, challenges: S-3, text: Nobody measured it., owner: P-2, state: answered, answer: '{answer}'}}\n"
    (shuttle / "requirements/argument.yaml").write_text(said, "utf-8")
    found = [f["message"] for f in findings(shuttle, "T126")]
    assert found == [f"`answer` says no more than `{answer}`"] * nothing


@pytest.mark.parametrize(
    ("print_", "outcome", "code"), [("0" * 64, "accepted", "T167"), ("", "open", "T168")]
)
def test_a_review_that_fell_does_not_follow_from_a_method_that_nothing_answers(
    shuttle: Path, print_: str, outcome: str, code: str
) -> None:
    """It is why nothing answers, and was shown with `--verbose` alone, as were those of requirements nearby."""
    edit(
        shuttle,
        NEEDS,
        "    verification: [test, fault injection]\n    metrics: [braking]\n",
        "    verification: [review]\n    metrics: [braking]\n",
    )
    edit(shuttle, PEOPLE, "works:\n", REVIEW.format(id="S-2", print=print_ or "1" * 64, outcome=outcome))
    (method,) = [f for f in findings(shuttle, "T255") if "`S-2`" in str(f["message"])]
    fallen = [f for f in findings(shuttle, code) if "RV-2" in str(f["message"])]
    assert [f["cause"] for f in fallen] == [None]
    assert method["cause"] is None


def test_a_person_is_one_whatever_nobody_sees_in_the_name(shuttle: Path) -> None:
    """With a space of no width in it, whoever answers for a thing reviewed it as somebody else."""
    edit(shuttle, PEOPLE, "title: Vera Verifier", 'title: "Dana\\u200b Driver"')
    (found,) = [f["message"] for f in findings(shuttle, "T130")]
    assert str(found).startswith("the person `P-4` has the name of the person `P-1`")


@pytest.mark.parametrize(
    ("file", "old", "new", "field"),
    [
        ("hazards", "tolerance: 500 ms", "tolerance: 0.0 ms", "`tolerance` is `0.0 ms`"),
        ("assurance", "at most 1 in 100 km", "at most 1 in 0 km", "`threshold` is `at most 1 in 0 km`"),
        ("hazards", "tolerance: 500 ms", "tolerance: 0.5 s", ""),
        ("assurance", "at most 1 in 100 km", "at most 0 in 0.5 h", ""),
    ],
)
def test_no_interval_and_no_mileage_is_none(shuttle: Path, file: str, old: str, new: str, field: str) -> None:
    edit(shuttle, f"requirements/{file}.yaml", old, new)
    found = [str(f["message"]) for f in findings(shuttle, "T124")]
    assert [said.startswith(field) for said in found] == [True] * bool(field)


def test_what_is_wrong_with_the_name_of_a_method_is_said(shuttle: Path) -> None:
    """`HIL test` was said to be none such as `fault injection`, which tells nobody that its capitals are why."""
    edit(shuttle, NEEDS, "    verification: [test, fault injection]\n    metrics: [braking]\n", "    verification: [test, HIL test]\n    metrics: [braking]\n")  # fmt: skip
    (found,) = [str(f["message"]) for f in findings(shuttle, "T124")]
    assert "`HIL test`" in found
    assert "small letters" in found
