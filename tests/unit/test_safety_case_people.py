"""What persons reviewed and signed, as version control knows it; what nobody reviewed; and the table that is left empty."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
import yaml

from support.project import command
from support.safety_case import Page, edit, html

WHO = {
    "GIT_AUTHOR_NAME": "Rolf Reader", "GIT_AUTHOR_EMAIL": "rolf@example.org", "GIT_AUTHOR_DATE": "2026-03-02T23:30:00-0500",
    "GIT_COMMITTER_NAME": "Maria Motor", "GIT_COMMITTER_EMAIL": "maria@example.org", "GIT_COMMITTER_DATE": "2026-03-03T09:00:00+0000",
    "GIT_CONFIG_GLOBAL": "/dev/null", "GIT_CONFIG_SYSTEM": "/dev/null", "PATH": "/usr/bin:/bin",
}  # fmt: skip


def git(project: Path, *arguments: str, text: str = "") -> str:
    done = subprocess.run(["git", *arguments], cwd=project, env=WHO, input=text, capture_output=True, text=True, check=True)  # fmt: skip
    return done.stdout.strip()


@pytest.fixture
def committed(warehouse: Path) -> Path:
    git(warehouse, "init", "-q")
    git(warehouse, "add", "requirements", "specs")
    git(warehouse, "commit", "-q", "-m", "what Rolf read")
    return warehouse


def review(page: Page, id_: str) -> str:
    """The row of a review, as it is read."""
    (row,) = re.findall(rf'<tr id="review-{id_}">(.*?)</tr>', page.html)
    return re.sub(r"<[^>]*>", " ", row)


def signed(project: Path) -> str:
    """The last commit with a signature put into it, by git's own format; nobody holds it against a key here."""
    head, _, message = git(project, "cat-file", "commit", "HEAD").partition("\n\n")
    head += "\ngpgsig -----BEGIN SSH SIGNATURE-----\n U1NIU0lHAAAA\n -----END SSH SIGNATURE-----"
    made = git(project, "hash-object", "-t", "commit", "-w", "--stdin", text=f"{head}\n\n{message}\n")
    git(project, "update-ref", "HEAD", made)
    return made


def test_a_review_names_the_commit_that_it_stands_in(committed: Path) -> None:
    commit = git(committed, "rev-parse", "HEAD")
    said = review(html(committed), "RV-1")
    assert commit in said
    assert "Rolf Reader" in said  # who wrote it, not who put it there
    assert "Maria Motor" not in said
    assert "2026-03-02" in said  # the day where the author was
    assert "commit without a signature" in said


def test_a_signed_commit_is_called_so(committed: Path) -> None:
    made = signed(committed)
    said = review(html(committed), "RV-1")
    assert made in said
    assert "signed commit" in said
    assert "without" not in said


def test_a_word_like_a_signature_in_the_message_is_none(committed: Path) -> None:
    git(committed, "commit", "-q", "--amend", "-m", "gpgsig -----BEGIN\n\ngpgsig mine")
    assert "commit without a signature" in review(html(committed), "RV-1")


def test_a_review_that_is_not_committed_stands_in_no_commit(warehouse: Path, committed: Path) -> None:
    edit(committed, "requirements/people.yaml", "  - id: RV-1\n", "  - title: anew\n    id: RV-1\n")
    assert "in no commit" in review(html(committed), "RV-1")


def test_whoever_changed_any_line_of_a_review_last_is_named(committed: Path) -> None:
    """Who wrote its first line did not write what it came to."""
    first = git(committed, "rev-parse", "HEAD")
    edit(committed, "requirements/people.yaml", "    outcome: accepted\n", "    outcome: accepted  # now\n")
    assert "in no commit" in review(html(committed), "RV-1")
    git(committed, "commit", "-qam", "accepted", "--author", "Dora Doer <dora@example.org>")
    said = review(html(committed), "RV-1")
    assert git(committed, "rev-parse", "HEAD") in said
    assert "Dora Doer" in said
    assert first not in said


def test_nobody_gets_another_name_by_a_file_of_the_project(committed: Path) -> None:
    """git calls authors as `.mailmap` has them, which whoever edits the project writes."""
    (committed / ".mailmap").write_text("Vera Verifier <vera@example.org> <rolf@example.org>\n", "utf-8")
    git(committed, "add", ".mailmap")
    git(committed, "commit", "-qm", "names")
    said = review(html(committed), "RV-1")
    assert "Rolf Reader" in said
    assert "Vera" not in said


def test_without_version_control_a_review_stands_in_no_commit(warehouse: Path) -> None:
    assert "in no commit" in review(html(warehouse), "RV-1")


def unreviewed(page: Page) -> dict[str, list[str]]:
    """By kind, the ids that are told not to be reviewed."""
    part = page.html.partition("<h2>Not reviewed</h2>")[2].partition("<h2>")[0]
    rows = re.findall(r'<td data-label="kind">(.*?)</td>.*?<td data-label="which">(.*?)</td>', part)
    return {kind: re.sub(r"<[^>]*>", "", ids).split(", ") for kind, ids in rows}


def expected(project: Path) -> dict[str, set[str]]:
    """All that there is to be read of some kinds, from the documents."""
    said = [yaml.safe_load(path.read_text("utf-8")) for path in (project / "requirements").glob("*.yaml")]
    fields = {"requirement": "requirements", "hazard": "hazards", "safety goal": "safety_goals", "design element": "elements"}  # fmt: skip
    return {
        kind: {one["id"] for document in said for one in document.get(field, ()) if one.get("status") != "obsolete"}
        for kind, field in fields.items()
    }  # fmt: skip


def test_what_nobody_reviewed_is_listed_and_counted(warehouse: Path) -> None:
    page = html(warehouse)
    found, there, numbers = unreviewed(page), expected(warehouse), dict(page.numbers)
    assert {kind: set(found[kind]) for kind in there} == {**there, "requirement": there["requirement"] - {"SYS-1"}}  # fmt: skip
    for kind, ids in there.items():
        assert numbers[f"read/{kind}"] == str(len(ids)), kind
        assert numbers[f"unreviewed/{kind}"] == str(len(found[kind])), kind
    assert "A program does not sign for one." in page.html


def test_a_review_of_another_version_counts_for_nothing(warehouse: Path) -> None:
    edit(warehouse, "requirements/needs.yaml", "more than 0.3 m/s.\n    rationale: Below", "more than 0.4 m/s.\n    rationale: Below")  # fmt: skip
    assert "SYS-1" in unreviewed(html(warehouse))["requirement"]


def test_a_review_that_found_something_has_accepted_nothing(warehouse: Path) -> None:
    """The page of open points lists it as the gate does: the section about people must not say otherwise."""
    edit(warehouse, "requirements/people.yaml", "outcome: accepted", "outcome: open")
    assert "SYS-1" in unreviewed(html(warehouse))["requirement"]


def test_the_table_for_signatures_is_there_and_empty(warehouse: Path) -> None:
    page = html(warehouse)
    (table,) = re.findall(r'<table class="blanks">(.*?)</table>', page.html, re.DOTALL)
    assert re.findall(r"<th>(.*?)</th>", table) == ["name", "role", "organisation", "date", "signature"]
    cells = re.findall(r"<td[^>]*>(.*?)</td>", table)
    assert len(cells) == 25
    assert set(cells) == {""}


def test_a_project_without_persons_has_room_for_signatures_too(warehouse: Path) -> None:
    (warehouse / "requirements/people.yaml").unlink()
    page = html(warehouse)
    assert "There are no reviews" in page.html
    assert "No persons" in page.html
    assert '<table class="blanks">' in page.html
    assert {"SYS-1", "SYS-2"} <= set(unreviewed(page)["requirement"])


def test_whatever_was_accepted_that_is_less_is_listed_with_who_and_why(warehouse: Path) -> None:
    """No finding tells of it any more, so that an assessor would not know."""
    assert "nothing was accepted by which less is demanded" in html(warehouse).html
    spec = "specs/robot.spec"
    text = (warehouse / spec).read_text("utf-8")
    tests = re.findall(r"^test \w+ \".*?(?=^\S|\Z)", text, re.DOTALL | re.MULTILINE)
    for one in tests[:2]:
        text = text.replace(one, "")
    (warehouse / spec).write_text(text, "utf-8")
    who = ("--by", "Rolf Reader", "--reason", "they said <b>the same</b>", "--day", "2026-05-02", "--quiet")
    assert command(warehouse, "trace", "--accept-baseline", *who)[0] == 0
    page = html(warehouse).html
    part = page[page.index("<h2>Accepted by name</h2>") : page.index("<h2>Signatures</h2>")]
    rows = [re.sub(r"<[^>]*>", "|", row) for row in re.findall(r"<tr>(.*?)</tr>", part)][1:]
    assert len(rows) == 2
    assert all(
        said in rows[0] for said in ("2026-05-02", "Rolf Reader", "they said &lt;b&gt;the same&lt;/b&gt;")
    )
    assert all(" is gone" in row and "test " in row for row in rows)
