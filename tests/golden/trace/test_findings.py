"""Every finding of the trace room, word for word, beside the edit that causes it."""

from __future__ import annotations

from pathlib import Path

import pytest

from golden.trace.cases import HERE, UPDATE, Small, apply
from support.length import AT_LENGTH
from trackmarshal import trace
from trackmarshal.cli.catalogue import catalogue

CASES = sorted((HERE / "findings").glob("*.case"))


def test_the_project_itself_has_none() -> None:
    matrix = Small().matrix()
    assert [str(finding) for finding in matrix.findings] == []
    assert matrix.passes
    assert trace.gate(matrix) == []


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.stem)
def test_case(case: Path, tmp_path: Path) -> None:
    text = case.read_text(encoding="utf-8")
    edits, _, expected = text.partition("expect\n")
    small = Small.copy(tmp_path)
    apply(small, edits.splitlines())
    matrix = small.matrix()
    actual = "".join(f"{finding}\n" for finding in matrix.findings)
    if UPDATE:
        case.write_text(f"{edits}expect\n{actual}", encoding="utf-8")
        expected = actual
    assert actual == expected
    assert f"[{case.stem[:4]}]" in actual, "a case is called by the code that it is about"
    assert matrix.passes == ("error[" not in actual)
    number = CASES.index(case)
    for place, kind in enumerate(trace.FORMATS):
        if AT_LENGTH or number % len(trace.FORMATS) == place:  # every day by turns
            trace.render(matrix, kind)  # no report stumbles over a finding


def test_every_code_has_a_case() -> None:
    raised = {"T378"}  # in tests/unit/test_trace_gate.py
    assert sorted(set(trace.CODES) - {case.stem[:4] for case in CASES} - raised) == []


def test_every_code_that_is_given_has_an_explanation() -> None:
    room = Path(trace.__file__).parent
    given = {word for path in room.rglob("*.py") for word in _codes(path.read_text(encoding="utf-8"))}
    assert sorted(given - set(catalogue())) == []


def _codes(text: str) -> set[str]:
    import re

    return set(re.findall(r'"(T[0-9]{3})"', text))
