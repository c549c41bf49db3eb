"""What verbs print: strict JSON lines, problems on standard error, progress on a terminal."""

from __future__ import annotations

import io
import json
import math
import os
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO, TypeVar

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import other_there, read_regular, write_whole
from trackmarshal.runtime.verdict import About, RuleResult
from trackmarshal.units import written

if TYPE_CHECKING:
    from trackmarshal.trace import Finding, Matrix


def number(value: float) -> float | str:
    """A float for strict JSON: non-finite ones as words."""
    if math.isfinite(value):
        return value
    return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"


def count(number: int, one: str, many: str | None = None) -> str:
    """How many of something, in words of its own number: `1 gap`, `2 gaps`."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def told(gaps: Sequence[Finding], matrix: Matrix) -> str:
    """How many findings fail the gate: those that stand for themselves, and those that follow from them."""
    following = sum(finding in matrix.causes for finding in gaps)
    own = count(len(gaps) - following, "gap")
    return f"{own}, and {following} that follow{'s' if following == 1 else ''}" if following else own


def rule_json(result: RuleResult) -> dict[str, Any]:
    """A rule's result as `eval` and `replay` write it."""
    entry: dict[str, Any] = {
        "verdict": result.verdict,
        "margin": number(result.margin),
        "unit": result.unit,
        "shown": written(result.margin, result.unit, result.shown),
    }
    witness = result.witness
    entry["witness"] = witness.binders if witness is not None else {}
    if witness is not None:
        if witness.span is not None:
            entry["span"] = str(witness.span)
        shown = written(witness.margin, witness.unit, witness.shown)
        entry["decides"] = {"margin": number(witness.margin), "unit": witness.unit, "shown": shown}
    if result.advisory:
        entry["advisory"] = True
    if result.reason:
        entry["reason"] = result.reason
    if result.about:
        entry["about"] = [about_json(one) for one in result.about]
    if result.series is not None:
        verdicts, margins = result.series
        entry["series"] = {"verdict": verdicts, "margin": [number(m) for m in margins]}
    return entry


def about_json(about: About) -> dict[str, Any]:
    """What a rule over the run says of one cycle."""
    return {
        "cycle": about.cycle,
        "verdict": about.verdict,
        "margin": number(about.margin),
        "final": about.final,
    }


def dump(value: object) -> str:
    """One line of strict JSON; what a terminal would act on is written as JSON escapes it."""
    text = json.dumps(value, allow_nan=False, ensure_ascii=False)
    return text if text.isascii() and text.isprintable() else "".join(map(_in_json, text))


def plain(text: str) -> str:
    """Text of a file (a name, a title, a message) as one line that a terminal shows and never acts on.

    Characters that move the cursor, change colours, break the line or turn the direction of writing become `\\x1b`, `\\n`, `\\u202e`.
    """
    if text.isprintable():  # no character of those categories is
        return text
    return "".join(char.encode("unicode_escape").decode() if _acts(char) else char for char in text)


def say(*lines: str, file: TextIO | None = None) -> None:
    """Print lines for people: the one way of text to the terminal, where every control character is escaped."""
    for line in lines:
        print(plain(line), file=file)


def write(document: str) -> None:
    """Print what becomes a file, which is UTF-8 whatever the terminal has: XML and pages say so themselves, and others are read so."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8", errors="backslashreplace")
    print(document, end="")


def write_out(name: str, data: bytes, mark: bytes | None, what: str) -> None:
    """Write an output to a file; raises E412 where something else than such a thing is there, which has its mark in it: anything else where it has none."""
    path = Path(name)
    if other_there(path, mark) and read_regular(path) != data:
        message = f"{name} is there already" + (f", and is no {what}" if what else "")
        raise TrackmarshalError("E412", message, file=name, help="nothing was written; choose another name")
    write_whole(path, data)


def _acts(char: str) -> bool:
    return unicodedata.category(char) in ("Cc", "Cf", "Cs", "Zl", "Zp")


def _in_json(char: str) -> str:
    return json.dumps(char)[1:-1] if _acts(char) else char


def coloured() -> bool:
    """Whether what is said on standard error has colours: on a terminal that has them, where nobody wants none (no-color.org)."""
    return _watched() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def _watched() -> bool:
    """Whether what is said on standard error is read on a terminal; where there is none, nobody reads it."""
    return sys.stderr is not None and sys.stderr.isatty()


def print_problem(error: TrackmarshalError) -> None:
    """An error for a person, on standard error, with its excerpt where there is one."""
    from trackmarshal.diagnostics.text import render

    print(render([error], colour=coloured()), file=sys.stderr)


T = TypeVar("T")


def progress(items: Sequence[T], what: str, quiet: bool) -> Iterator[T]:
    """The items; on a terminal, after a second, with a bar on standard error."""
    if quiet or not _watched():
        yield from items
        return
    start, shown = monotonic(), False
    for index, item in enumerate(items):
        if monotonic() - start > 1.0:
            done = 30 * index // max(1, len(items))
            print(
                f"\r{plain(what)} [{'#' * done}{'.' * (30 - done)}] {index}/{len(items)}",
                end="",
                file=sys.stderr,
                flush=True,
            )
            shown = True
        yield item
    if shown:
        print("\r" + " " * 70 + "\r", end="", file=sys.stderr, flush=True)


def table(rows: Iterable[Sequence[str]], head: Sequence[str]) -> list[str]:
    """Lines with aligned columns for a terminal."""
    lines = [list(head), *[[plain(cell) for cell in row] for row in rows]]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines]
