"""`trackmarshal eval` as a person runs it: a file of cases in, lines of strict JSON out."""

from __future__ import annotations

import contextlib
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from support.schemas import hold
from trackmarshal.cli.main import main

#: What `eval --backend` offers that the oracles are held against.
BACKENDS = ("reference", "numpy", "c")
Case = dict[str, Any]


def write_cases(path: Path, cases: Sequence[Case]) -> Path:
    """Cases as JSON Lines; a number that strict JSON has no word for is a defect of the test."""
    text = "".join(json.dumps(case, allow_nan=False) + "\n" for case in cases)
    path.write_text(text, encoding="utf-8")
    return path


def arguments(spec: Path, data: Path, rules: Sequence[str], backend: str, *more: str) -> list[str]:
    """The command line behind `trackmarshal`."""
    chosen = [word for rule in rules for word in ("--rule", rule)]
    return ["eval", str(spec), "--data", str(data), *chosen, "--backend", backend, "--format", "jsonl", *more]


def read_lines(text: str) -> list[dict[str, Any]]:
    """Lines of strict JSON."""
    return [json.loads(line, parse_constant=_refuse) for line in text.splitlines()]


def evaluate(
    folder: Path, spec: Path, cases: Sequence[Case], rules: Sequence[str], backend: str, *more: str
) -> list[dict[str, Any]]:
    """One run of the command over all cases; one line a case, in order, none of them an error."""
    data = write_cases(folder / f"cases-{backend}.jsonl", cases)
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        status = main(arguments(spec, data, rules, backend, *more))
    hold(arguments(spec, data, rules, backend, *more), out.getvalue())
    lines = read_lines(out.getvalue())
    assert status < 2, [line for line in lines if "error" in line][:3]
    assert status == (0 if all(line["safe"] for line in lines) else 1)
    assert [line["id"] for line in lines] == [case["id"] for case in cases]
    return lines


def number(value: float | str) -> float:
    """A margin as the command writes it: infinities and NaN as words."""
    return float(value)


def close(value: float, wanted: float, relative: float = 1e-9) -> bool:
    """Equal to a relative tolerance; nothing is close to NaN."""
    return math.isclose(value, wanted, rel_tol=relative, abs_tol=0.0)


def _refuse(word: str) -> NoReturn:
    raise AssertionError(f"{word} is not strict JSON")
