"""`import requirements --force`: what a file loses that is written over is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.cli.main import main

HEAD = "id,title,statement,rationale,status,asil,verification,source\n"
V_MODEL = "document: v-model\ntitle: T\nproject: {name: P, specs: [specs]}\nstages:\n  - {id: S-1, title: T, shows: T, applies_to: ['*'], counts: [rule]}\n"


def table(levels: dict[str, str]) -> str:
    """Requirements by id and ASIL, as another tool exports them."""
    return HEAD + "".join(f"{id_},A,It shall.,B,draft,{asil},test,C\n" for id_, asil in levels.items())


def taken(
    before: dict[str, str], after: dict[str, str], capsys: pytest.CaptureFixture[str], *options: str
) -> tuple[int, str]:
    """What is said on standard error when a list is written over by another; the status."""
    Path("in.csv").write_text(table(before))
    assert main(["import", "requirements", "in.csv"]) == 0
    Path("in.csv").write_text(table(after))
    capsys.readouterr()
    status = main(["import", "requirements", "in.csv", *options])
    return status, capsys.readouterr().err


@pytest.fixture(params=["a project", "no project"], autouse=True)
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "requirements").mkdir()
    if request.param == "a project":
        (tmp_path / "requirements" / "v-model.yaml").write_text(V_MODEL)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_requirements_that_are_dropped_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    status, err = taken(
        {"AB-1": "D", "AB-2": "QM", "AB-3": "A"}, {"AB-2": "QM", "AB-4": "A"}, capsys, "--force"
    )
    assert status == 0
    assert err.count("warning[T365]") == 2
    for id_ in ("AB-1", "AB-3"):
        assert f"`{id_}` is dropped" in err
        place = next(text for text in err.splitlines() if f"`{id_}`" in text)
        assert place.startswith("requirements/in.yaml:")
    assert "AB-2" not in err
    assert "AB-4" not in err


@pytest.mark.parametrize(
    ("before", "after", "named"),
    [
        ("D", "C", True), ("A", "QM", True), ("D", "B(D)", True), ("B(D)", "B(C)", True), ("B(D)", "B", True), ("B(D)", "QM(D)", True),
        ("C", "C", False), ("C", "D", False), ("QM", "A", False), ("B", "B(D)", False), ("QM(D)", "B(D)", False),
    ],
)  # fmt: skip
def test_an_asil_that_is_lowered_is_named(
    before: str, after: str, named: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    status, err = taken({"AB-1": before, "AB-2": "D"}, {"AB-1": after, "AB-2": "D"}, capsys, "--force")
    assert status == 0
    assert (f"the ASIL of `AB-1` is lowered from {before} to {after}" in err) == named
    assert err.count("T365") == named


@pytest.mark.parametrize(("source", "named"), [('"a\nregulation"', False), ("", True), ("another one", True)])
def test_where_a_list_comes_from_is_not_lost_without_a_word(
    source: str, named: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """Most tools have no such thing."""
    row = "AB-1,A,It shall.,B,draft,D,test,C"
    for said in ('"a\nregulation"', source):
        Path("in.csv").write_text(f"document_source,{HEAD}{said},{row}\n")
        capsys.readouterr()
        assert main(["import", "requirements", "in.csv", "--force"]) == 0
    told = "requirements/in.yaml:3:9: warning[T365]: the list loses where it comes from: `a regulation`"
    assert (told in capsys.readouterr().err) == named


def test_it_is_said_before_anything_is_written_too(capsys: pytest.CaptureFixture[str]) -> None:
    status, err = taken({"AB-1": "D"}, {"AB-2": "D"}, capsys)
    assert status == 2
    assert "`AB-1` is dropped" in err
    assert "E412" in err
    assert "AB-1" in Path("requirements/in.yaml").read_text()


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no list of requirements"),
        ("document: system-model\ntitle: T\n", "the document `system-model`"),
        (V_MODEL, "the document `v-model`"),
        ("document: requirements\ntitle: [\n", "no list of requirements"),
    ],
)
def test_a_file_that_is_no_list_of_requirements_is_not_written_over(
    text: str, what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("other.yaml").write_text(text)
    Path("in.csv").write_text(table({"AB-1": "D"}))
    assert main(["import", "requirements", "in.csv", "--out", "other.yaml", "--force"]) == 2
    assert f"other.yaml: error[T365]: what would be written over is {what}" in capsys.readouterr().err
    assert Path("other.yaml").read_text() == text


def test_a_list_that_cannot_be_read_whole_is_written_over_with_a_warning(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("other.yaml").write_text("document: requirements\ntitle: T\nrequirements:\n  - {id: AB-1}\n")
    Path("in.csv").write_text(table({"AB-1": "D"}))
    assert main(["import", "requirements", "in.csv", "--out", "other.yaml", "--force"]) == 0
    assert "other.yaml: warning[T365]" in capsys.readouterr().err


def test_a_list_that_is_called_as_the_v_model_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever names lists in the other tool does not know which files there are here."""
    Path("requirements/v-model.yaml").write_text(V_MODEL)
    lists = f"document,{HEAD}" + "".join(
        f"{name},{id_},A,It shall.,B,draft,QM,test,C\n"
        for name, id_ in (("v-model", "AB-1"), ("doors", "AB-2"))
    )
    Path("in.csv").write_text(lists)
    assert main(["import", "requirements", "in.csv", "--force"]) == 2
    assert "requirements/v-model.yaml: error[T365]" in capsys.readouterr().err
    assert Path("requirements/v-model.yaml").read_text() == V_MODEL
    assert not Path("requirements/doors.yaml").exists()


def test_the_same_list_again_loses_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert taken({"AB-1": "B(D)"}, {"AB-1": "B(D)"}, capsys, "--force") == (0, "")


def written_over(
    before: str, after: str, capsys: pytest.CaptureFixture[str], ids: tuple[str, ...] = ("AB-1",)
) -> list[str]:
    """What is said where requirements with some fields, as YAML has them, are written over by a table with columns."""
    head = "document: requirements\ntitle: T\nrequirements:\n"
    record = "  - {{id: {}, title: T, statement: It shall., rationale: B, status: draft, asil: D, verification: [test, review], source: C{}}}\n"
    path = Path("requirements/in.yaml")
    path.write_text(head + "".join(record.format(id_, before) for id_ in ids))
    columns, values = after.split("|")
    rows = "".join(f"{id_},T,It shall.,B,D,C,{values}\n" for id_ in ids)
    Path("in.csv").write_text(f"id,title,statement,rationale,asil,source,{columns}\n{rows}")
    assert main(["import", "requirements", "in.csv", "--force"]) == 0
    return [line for line in capsys.readouterr().err.splitlines() if "T365" in line]


SAME = "status,verification|draft,test; review"


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("", "status,verification|draft,test", "`AB-1` loses `verification` `review`"),
        ("", "status,verification|obsolete,test; review", "`AB-1` is demanded no longer: its status is `obsolete`"),
        (", metrics: [a, b]", SAME, "`AB-1` loses `metrics` `a`, `b`"),
        (", metrics: [a, b]", "status,verification,metrics|draft,test; review,b", "`AB-1` loses `metrics` `a`"),
        (", achieves: [SG-1], allocated_to: [DE-1], independence: [AN-1], owner: Ada", SAME,
         "`AB-1` loses `achieves` `SG-1`; `allocated_to` `DE-1`; `independence` `AN-1`; `owner`"),
        (", foreign: {Ticket: '7', Team: x}", "status,verification,Team|draft,test; review,x", "`AB-1` loses `foreign` `Ticket`"),
        (", not_verified_by: {M-1: it is slow}", SAME, "`AB-1` loses `not_verified_by`"),
    ],
)  # fmt: skip
def test_links_and_fields_that_are_gone_are_named(
    before: str, after: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (line,) = written_over(before, after, capsys)
    assert line.startswith("requirements/in.yaml:4:")
    assert said in line
    assert written_over("", SAME, capsys) == []


def test_what_is_more_is_not_named(capsys: pytest.CaptureFixture[str]) -> None:
    more = "status,verification,metrics,owner,Team|approved,review; test; analysis,a,Ada,x"
    assert written_over("", more, capsys) == []


def test_a_column_that_is_not_there_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    many = tuple(f"AB-{number}" for number in range(40))
    (line,) = written_over(", metrics: [a]", SAME, capsys, many)
    assert "40 of 40 requirements lose something in `metrics`, such as `AB-0`: `metrics` `a`" in line
