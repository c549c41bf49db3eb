"""Spec files as text: what is refused, and where characters are."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmarshal.errors import TrackmarshalError
from trackmarshal.source import MAX_BYTES, SourceFile, Span, decode, read


def refused(data: bytes) -> TrackmarshalError:
    with pytest.raises(TrackmarshalError) as caught:
        decode("a.spec", data)
    assert caught.value.file == "a.spec"
    assert caught.value.help
    return caught.value


@pytest.mark.parametrize("text", ["module a\n", "module a", "-- é\nmodule a\n", "module a\t\n"])
def test_line_ends_and_byte_order_marks_make_no_difference(text: str) -> None:
    plain = decode("a.spec", text.encode())
    for data in (
        text.replace("\n", "\r\n").encode(),
        text.replace("\n", "\r").encode(),
        text.encode("utf-8-sig"),
        text.replace("\n", "\r\n").encode("utf-8-sig"),
    ):
        assert decode("a.spec", data).text == plain.text == text


@pytest.mark.parametrize("data", [b"", b"\n", b"\xef\xbb\xbf", b" \t\r\n\r\n", b"\xef\xbb\xbf\r\n"])
def test_nothing_is_refused(data: bytes) -> None:
    assert (refused(data).code, refused(data).line) == ("E003", 1)


@pytest.mark.parametrize(
    ("data", "line"),
    [
        (b"\xff", 1),
        (b"module a\n-- caf\xe9\n", 2),
        (b"module a\r\n\r\n\xc3", 3),
        ("module a\n".encode("utf-16"), 1),
        (b"\xed\xa0\x80", 1),  # a lone surrogate
        (b"\xc0\x80", 1),  # NUL, overlong
    ],
)
def test_what_is_not_utf_8_is_refused_with_its_line(data: bytes, line: int) -> None:
    assert (refused(data).code, refused(data).line) == ("E004", line)


@pytest.mark.parametrize("char", ["\0", "\x1b", "\x0c", "\x0b", "\x7f", "\x85", "\u202e", "\u2066"])
def test_characters_that_a_screen_does_not_show_are_refused(char: str) -> None:
    error = refused(f"module a\n\n-- a{char}b\n".encode())
    assert (error.code, error.line) == ("E005", 3)
    assert f"U+{ord(char):04X}" in error.message


def test_letters_of_all_languages_are_not() -> None:
    text = "module a -- 速度 ≤ μ é\u0301 \U0001f600\n"
    assert decode("a.spec", text.encode()).text == text


def test_reading_a_file(tmp_path: Path) -> None:
    path = tmp_path / "a.spec"
    path.write_bytes(b"module a\r\n")
    assert read(path).text == "module a\n"
    assert read(path, "shown.spec").path == "shown.spec"


def test_a_file_that_is_not_there_or_no_file_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "none.spec", tmp_path, tmp_path / "a" / "b.spec", Path("a\0b.spec")):
        with pytest.raises(TrackmarshalError) as caught:
            read(path)
        assert (caught.value.code, caught.value.file) == ("E001", str(path))
        assert caught.value.help


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.spec"
    path.write_text("module a\n")
    path.chmod(0)
    with pytest.raises(TrackmarshalError) as caught:
        read(path)
    path.chmod(stat.S_IRUSR | stat.S_IWUSR)
    assert caught.value.code == "E001"


def test_a_file_too_large_is_refused_before_it_is_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "large.spec"
    with path.open("wb") as stream:
        stream.truncate(10 * MAX_BYTES)
    with pytest.raises(TrackmarshalError) as caught:
        read(path)
    assert caught.value.code == "E002"
    path.write_bytes(b"-" * MAX_BYTES)
    assert len(read(path).text) == MAX_BYTES


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no /dev/zero on this system")
def test_a_device_without_an_end_is_refused() -> None:
    with pytest.raises(TrackmarshalError) as caught:
        read(Path("/dev/zero"))
    assert caught.value.code == "E001"


@given(st.text(alphabet="ab \n\té", min_size=1))
def test_positions_are_those_of_the_lines(text: str) -> None:
    file = SourceFile("a.spec", text)
    lines = text.split("\n")
    for offset in range(len(text) + 1):
        line, column = file.position(offset)
        before = text[:offset]
        assert (line, column) == (before.count("\n") + 1, offset - (before.rfind("\n") + 1) + 1)
        assert file.line(line) == lines[line - 1]
    assert file.line(len(lines) + 1) == ""


def test_spans() -> None:
    file = SourceFile("a.spec", "rule speed_limit speed\n  require v < 3\n")
    whole = Span(file, 0, len(file.text))
    assert whole.head.text == "rule speed_limit speed"
    assert whole.word("speed").start == 17  # not the one inside speed_limit
    assert whole.word("nowhere").text == whole.head.text
    assert (whole.word("require").line, whole.word("require").column) == (2, 3)
    assert str(whole.word("v")) == "a.spec:2:11"
    assert whole.word("require").to(whole.word("v")).text == "require v"
    one_line = Span(SourceFile("a.spec", "rule"), 0, 4)
    assert one_line.head.text == "rule"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ('gap(o, -- the near one, "so"\n  2 m) -- in all\n', "gap(o, 2 m)"),
        ('o.near "a -- b" -- c "d"', 'o.near "a -- b"'),
        ("a - b", "a - b"),
    ],
)
def test_a_stretch_in_one_line_has_no_comments(text: str, shown: str) -> None:
    """In one line, a comment takes what stands below it with it: `explain` said "by gap(o, -- the near one 2 m)"."""
    assert Span(SourceFile("a.spec", text), 0, len(text)).in_line == shown
