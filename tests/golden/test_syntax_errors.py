"""What a rule author reads about each typical slip, word for word.

Each `syntax/NAME.spec` stands beside `syntax/NAME.txt`, what the text renderer says of it. After a change that is meant,
`TRACKMARSHAL_UPDATE_GOLDEN=1 pytest tests/golden` writes the texts anew; read the difference before it is committed.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from trackmarshal.diagnostics import text
from trackmarshal.diagnostics.base import Diagnostic, Diagnostics
from trackmarshal.node import Node
from trackmarshal.source import read
from trackmarshal.syntax import errors
from trackmarshal.syntax.format import format_text
from trackmarshal.syntax.parser import parse

FOLDER = Path(__file__).parent / "syntax"
SPECS = sorted(FOLDER.glob("*.spec"))
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"
#: Slips that are none.
WELL = {"error_in_a_comment_is_none"}


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_the_message_is_the_one_agreed_on(path: Path) -> None:
    said = text.render(parse(read(path, path.name))[1])
    expected = path.with_suffix(".txt")
    if UPDATE:
        expected.write_text(said, "utf-8", newline="\n")
    assert said == expected.read_text("utf-8")
    assert bool(said) == (path.stem not in WELL)


@pytest.mark.parametrize(
    "path", [path for path in SPECS if path.stem not in WELL], ids=lambda path: path.stem
)
def test_a_file_with_a_slip_is_not_laid_out(path: Path) -> None:
    with pytest.raises(Diagnostics) as caught:
        format_text(read(path, path.name))
    assert caught.value.items


def test_every_syntax_error_has_an_example() -> None:
    seen = {type(found) for path in SPECS for found in parse(read(path))[1]}
    declared = {
        kind
        for kind in vars(errors).values()
        if isinstance(kind, type) and issubclass(kind, Diagnostic) and kind is not Diagnostic
    }
    assert seen == declared
    assert all(issubclass(kind, Node) and kind.explanation and kind.title for kind in declared)


def test_no_expected_text_is_left_over() -> None:
    assert {path.stem for path in FOLDER.glob("*.txt")} == {path.stem for path in SPECS}
