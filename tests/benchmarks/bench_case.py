"""`case` on this project, HTML and PDF, from the evidence that is in its store, which is brought up to date first; and the HTML of a project of
10,000 items. CPU seconds of the command, and how large the files are."""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path

from bench_trace import project
from measuring import command

from trackmarshal.trace.case.words.language import SHIPPED

BOTH = "case of this project, HTML and PDF"
MANY = "case of 10,000 items with 22,500 links, HTML alone"
#: What somebody who changed a word and wants to see it waits for.
LIMITS = {BOTH: 6.0, MANY: 15.0}


def measure() -> dict[str, float]:
    # Results come from the store of this checkout: what is not there yet is run here, and counts for nothing.
    command("trace")
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        found[BOTH] = statistics.median(_cost(out, "--format", "both") for _ in range(3))
        found["case of this project, HTML alone"] = statistics.median(_cost(out, "--format", "html") for _ in range(3))  # fmt: skip
        for name in ("html", "pdf"):
            found[f"case of this project, {name}: size in MB (ratio)"] = (out / f"safety-case.{name}").stat().st_size / 1e6  # fmt: skip
        for language in SHIPPED:
            if language != "en":
                found[f"case of this project, HTML alone, in `{language}`"] = _cost(out, "--format", "html", "--words", language)  # fmt: skip
        many = out / "many"
        project(many, 6667, 1667)
        command("trace", "--project", str(many))  # runs the tests
        _cost(
            out / "case", "--format", "html", "--project", str(many)
        )  # draws what can be drawn, and keeps it
        found[MANY] = statistics.median(
            _cost(out / "case", "--format", "html", "--project", str(many)) for _ in range(3)
        )
        found[f"{MANY}: size in MB (ratio)"] = (out / "case" / "safety-case.html").stat().st_size / 1e6
    return found


def _cost(out: Path, *arguments: str) -> float:
    """CPU seconds of the command."""
    return command("case", "--out", str(out), "--quiet", *arguments)[0]
