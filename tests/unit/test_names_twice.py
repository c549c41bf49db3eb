"""Objects of JSON in which a name stands twice: told by every reader, and found in one pass however many names there are."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmarshal.cli import choose, evaluate
from trackmarshal.errors import TrackmarshalError
from trackmarshal.json_text import BadJson, named_twice, parse, strict
from trackmarshal.trace.exchange import csv_text, needs
from trackmarshal.trace.exchange.refused import Refused

#: A name that stands twice, after many that do not.
LATE = "{" + ",".join(f'"k{number}": 1' for number in range(2000)) + ', "k1999": 2}'


class Counted(str):
    """A name that counts how often it is compared."""

    __slots__ = ()
    compared = 0

    def __eq__(self, other: object) -> bool:
        Counted.compared += 1
        return str.__eq__(self, other)

    def __hash__(self) -> int:
        return str.__hash__(self)


@given(st.lists(st.text(max_size=2)))
def test_the_first_that_stands_there_again(names: list[str]) -> None:
    again = [name for place, name in enumerate(names) if name in names[:place]]
    assert named_twice(names) == (again[0] if again else None)


def test_in_one_pass() -> None:
    names = [Counted(f"k{number}") for number in range(3000)] + [Counted("k2999")]
    Counted.compared = 0
    assert named_twice(names) == "k2999"
    assert Counted.compared < 2 * len(names)


def test_every_reader_tells_it(tmp_path: Path) -> None:
    with pytest.raises(BadJson, match="the name 'k1999' stands twice"):
        parse(LATE)
    with pytest.raises(ValueError, match="`k1999` is there twice"):
        strict(LATE.encode())
    with pytest.raises(TrackmarshalError, match="the key `k1999` stands twice"):
        evaluate._parse(LATE.encode())
    with pytest.raises(Refused, match="`k1999` is there twice"):
        needs._parsed(LATE, "needs.json")
    columns = ",".join(f"k{number}" for number in range(2000))
    with pytest.raises(Refused, match="`k1999` is there twice"):
        csv_text.read(f"{columns},k1999\n".encode(), "in.csv")
    with pytest.raises(TrackmarshalError, match="two candidates are called `k1999`"):
        choose._check_names([*columns.split(","), "k1999"], "in.jsonl")
