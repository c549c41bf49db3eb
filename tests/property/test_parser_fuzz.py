"""Whatever the bytes, the parser answers with declarations and diagnostics, and in work that grows with the text."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from random import Random
from types import FrameType

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal.diagnostics import github, sarif, text
from trackmarshal.diagnostics import json as json_format
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.errors import TrackmarshalError
from trackmarshal.source import SourceFile, decode
from trackmarshal.syntax import ast
from trackmarshal.syntax.format import format_text
from trackmarshal.syntax.parser import parse

SAMPLE = (Path(__file__).parent / "strategies" / "sample.spec").read_text("utf-8")
unhurried = settings(deadline=None)
_PIECES = (
    *"()[]{}|:,.;=<>!&^*/+-~\"'\\#@?%\t\n \u00a0\u2028²√≤∈−“κο²",
    "--", "==", "<=", "->", "&&", "\n\n", "\nrule ", "\nparam ", "module", "for all ", "exists ", " in ", "60 mph", "5 m/s^^2", "1e",
    "require ", "until", "always[", "if ", " then ", " else ", "\u202e", "\U0001f3ce", "e\u0301", "速度", '"', "rul x", "set of", "½",
)  # fmt: skip


def answer(file: SourceFile) -> None:
    """Parse, and hold the answer against what every caller relies on."""
    module, found = parse(file)
    assert all(isinstance(item, ast.Item) for item in module.items)
    for diagnostic in found:
        assert isinstance(diagnostic, Diagnostic)
        assert diagnostic.span.file is file
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(file.text)
        assert diagnostic.message
        assert diagnostic.pointer
    assert text.render(found).count("error[") >= len(found)
    assert len(json.loads(json_format.render(found))) == len(found)
    assert len(json.loads(sarif.render(found))["runs"][0]["results"]) == len(found)
    assert len(github.render(found).splitlines()) == len(found)
    if not found:
        laid_out = format_text(file)
        assert format_text(SourceFile(file.path, laid_out)) == laid_out


@unhurried
@given(st.binary(max_size=300))
@example(b"\xff\xfe\x00r\x00u\x00l\x00e")
@example(b"rule \xe2\x88")
@example(b"")
@example(b"module m\nrule r require " + b"(" * 5000)
@example(b"module m\nrule r require " + b"not " * 5000 + b"a")
@example(b"module m\nrule r require " + b"-" * 5000)
@example(b"module m\nrule r require " + b"a + " * 5000 + b"a")
@example(b"module m\nrule r require a" + b"^" * 50)
@example(b'module m\nevent e "' + b"\\" * 5001)
@example(b"module m\nparam p : " + b"m/" * 5000)
@example(b"module m\nrule r require 5 " + b"m/" * 5000 + b"!")
@example(b"module m\nrule r require " + b"9" * 5000 + b"x")
@example(b"rule\n" * 3000)
@example(b"a b\n" * 3000)
def test_any_bytes(data: bytes) -> None:
    try:
        file = decode("fuzz.spec", data)
    except TrackmarshalError:
        return
    answer(file)


@unhurried
@given(st.lists(st.sampled_from(_PIECES), max_size=30).map("".join))
def test_any_signs_in_a_rule(signs: str) -> None:
    answer(SourceFile("fuzz.spec", f"module m\nrule r\n  require {signs}"))


@settings(deadline=None, max_examples=amount(30, 300))
@given(st.randoms(use_true_random=False), st.integers(1, 4))
def test_a_damaged_spec(random: Random, wounds: int) -> None:
    damaged = SAMPLE
    for _ in range(wounds):
        at = random.randrange(len(damaged) + 1)
        length = random.choice([0, 1, 1, 3, 20])
        piece = random.choice([*_PIECES, "", damaged[at : at + length]])
        damaged = damaged[:at] + piece * random.choice([1, 1, 2]) + damaged[at + length :]
    answer(SourceFile("fuzz.spec", damaged))


@unhurried
@given(st.integers(0, len(SAMPLE)))
def test_a_truncated_spec(length: int) -> None:
    answer(SourceFile("fuzz.spec", SAMPLE[:length]))


def calls(file: SourceFile) -> int:
    """The function calls that parsing makes: work, without a clock."""
    count = 0

    def note(frame: FrameType, event: str, arg: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        parse(file)
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize(
    "unit",
    [
        SAMPLE,
        "rule r\n  require a = b\n",
        "rul r\n",
        "rule r\n  require (((\n",
        "signal p : series { " + "x: m, " * 30 + "y: m }\n",
        "param v : m/s = 60 mph\n",
    ],
)
def test_the_work_grows_with_the_length(unit: str) -> None:
    parse(SourceFile("warm.spec", unit))
    once = calls(SourceFile("once.spec", unit * 5))
    assert calls(SourceFile("four.spec", unit * 20)) < 4.5 * once


def test_one_long_declaration_is_linear() -> None:
    def signal(fields: int) -> SourceFile:
        return SourceFile("long.spec", "signal p : series { " + "x: m in [0, 1], " * fields + "y: m }\n")

    parse(signal(1))
    assert calls(signal(4000)) < 4.5 * calls(signal(1000))
