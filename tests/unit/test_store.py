"""The evidence store: what is in it comes out again, and what was changed in it does not."""

from __future__ import annotations

import json
import os
from hashlib import sha256
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmarshal.errors import TrackmarshalError
from trackmarshal.store import FILE, Entry, Store

TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
ENTRIES = st.builds(
    Entry, st.sampled_from(["test", "run", "fault"]), TEXTS, st.dictionaries(TEXTS, TEXTS, max_size=3),
    st.dictionaries(TEXTS, st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | TEXTS, max_size=4),
    TEXTS, TEXTS, TEXTS, TEXTS, st.dictionaries(TEXTS, st.floats(allow_nan=False, allow_infinity=False), max_size=2),
)  # fmt: skip


def entry(subject: str = "a: b", outcome: str = "passed", **inputs: str) -> Entry:
    return Entry(
        "test", subject, inputs, {"outcome": outcome}, "tool 1", "c0ffee", "here", "2026-01-01T00:00:00+00:00"
    )


@given(entries=st.lists(ENTRIES, max_size=6))
def test_what_is_written_is_read(entries: list[Entry], tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("store")
    Store(folder).add(entries[:2])
    Store(folder).add(entries[2:])
    store = Store(folder)
    assert store.broken == []
    for one in entries:
        same = [e for e in entries if (e.kind, e.subject, e.inputs) == (one.kind, one.subject, one.inputs)]
        found = store.find(one.kind, one.subject, one.inputs)
        assert found is not None
        assert found.text() == same[-1].text()
        last = store.latest(one.kind, one.subject)
        assert last is not None
        assert (
            last.text() == [e for e in entries if (e.kind, e.subject) == (one.kind, one.subject)][-1].text()
        )


def test_results_are_found_by_all_of_their_inputs(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.add([entry(rule="1"), entry(rule="2", outcome="failed")])
    assert store.find("test", "a: b", {"rule": "1"}) is not None
    assert store.find("test", "a: b", {"rule": "1", "param": "3"}) is None
    assert store.find("test", "a: b", {}) is None
    assert store.find("run", "a: b", {"rule": "1"}) is None
    latest = store.latest("test", "a: b")
    assert latest is not None
    assert latest.result == {"outcome": "failed"}


@pytest.mark.parametrize("edit", [
    lambda line: line.replace(b"failed", b"passed"),
    lambda line: line[:-1],
    lambda line: line + b" ",
    lambda line: line.replace(b'"', b"'", 1),
    lambda line: b"{}",
    lambda line: b"\xff\xfe",
    lambda line: line.replace(b"0", b"1", 1) if line[8:9] == b"0" else line[:8] + b"0" + line[9:],
], ids=["a result", "cut", "a blank", "a quote", "empty", "no text", "its name"])  # fmt: skip
def test_an_entry_that_was_changed_counts_for_nothing(tmp_path: Path, edit) -> None:  # type: ignore[no-untyped-def]
    Store(tmp_path).add([entry("first"), entry("second", "failed"), entry("third")])
    path = tmp_path / FILE
    lines = path.read_bytes().split(b"\n")
    assert edit(lines[1]) != lines[1]
    lines[1] = edit(lines[1])
    path.write_bytes(b"\n".join(lines))
    store = Store(tmp_path)
    assert [one.line for one in store.broken] == [2]
    assert store.latest("test", "second") is None
    assert store.latest("test", "first")
    assert store.latest("test", "third")


def test_what_was_cut_in_the_middle_of_a_line_takes_nothing_with_it(tmp_path: Path) -> None:
    Store(tmp_path).add([entry("first"), entry("second")])
    path = tmp_path / FILE
    path.write_bytes(path.read_bytes()[:-40])
    Store(tmp_path).add([entry("third")])
    store = Store(tmp_path)
    assert [one.line for one in store.broken] == [2]
    assert store.latest("test", "third") is not None


def test_an_entry_of_another_shape_is_named_even_with_its_hash(tmp_path: Path) -> None:
    for number, rest in enumerate(
        (
            {"kind": "test"},
            {**json.loads(entry().text()), "kind": "wish"},
            {**json.loads(entry().text()), "inputs": 3},
            {**json.loads(entry().text()), "result": ["passed"]},
            {**json.loads(entry().text()), "commit": 7},
        )
    ):
        rest.pop("id", None)
        said = json.dumps(rest)[1:].encode()
        line = b'{"id": "' + sha256(said).hexdigest().encode() + b'", ' + said
        (tmp_path / FILE).write_bytes(line + b"\n")
        assert [one.why for one in Store(tmp_path).broken] == ["it is no entry of this version"], number


def test_those_before_one_that_is_refused_count_again(tmp_path: Path) -> None:
    """Each has its hash; what the last one says is none of this version's results."""
    store = Store(tmp_path)
    store.add([entry(rule="1"), entry(rule="2"), entry(rule="1", outcome="wished")])
    wrong = store.find("test", "a: b", {"rule": "1"})
    assert wrong is not None
    store.refuse(wrong)
    left = store.find("test", "a: b", {"rule": "1"}), store.latest("test", "a: b")
    assert [one and (one.result, one.inputs) for one in left] == [
        ({"outcome": "passed"}, {"rule": "1"}),
        ({"outcome": "passed"}, {"rule": "2"}),
    ]
    assert [one.why for one in store.broken] == ["it is no entry of this version"]


def test_the_hash_is_that_of_the_rest_of_the_line(tmp_path: Path) -> None:
    line = entry().text()
    said = json.loads(line)
    assert said["id"] == entry().id == sha256(line[line.index(b", ") + 2 :]).hexdigest()


def test_a_store_that_is_no_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / FILE).mkdir()
    with pytest.raises(TrackmarshalError) as caught:
        Store(tmp_path)
    assert caught.value.code == "T295"


@pytest.mark.skipif(os.name != "posix", reason="limits of a process are POSIX's")
def test_a_full_disk_leaves_no_part_of_an_entry(tmp_path: Path) -> None:
    """It passed for a line that somebody had changed, and the gate was red until that was taken out by hand."""
    import resource

    store = Store(tmp_path)
    store.add([entry("first")])
    before = store.path.read_bytes()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 100, hard))
    try:
        with pytest.raises(OSError, match="too large"):
            store.add([entry("second"), entry("third")])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert store.path.read_bytes() == before
    assert store.latest("test", "second") is None
    store.add([entry("third")])
    assert Store(tmp_path).broken == []
