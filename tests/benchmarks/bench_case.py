"""`case` on this project, HTML and PDF, from the evidence that is in its store, which is brought up to date first. CPU seconds of the command, and how large the files are."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from trackmarshal.trace.case.words.language import SHIPPED

ROOT = Path(__file__).resolve().parents[2]
BOTH = "case of this project, HTML and PDF"
#: What somebody who changed a word and wants to see it waits for.
LIMITS = {BOTH: 6.0}
_COMMAND = [sys.executable, "-m", "trackmarshal.cli.main"]


def measure() -> dict[str, float]:
    # Results come from the store of this checkout: what is not there yet is run here, and counts for nothing.
    subprocess.run([*_COMMAND, "trace", "--project", str(ROOT)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)  # fmt: skip
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
    return found


def _cost(out: Path, *arguments: str) -> float:
    """CPU seconds of a command; that the gate may fail is not its business."""
    command = [*_COMMAND, "case", "--project", str(ROOT), "--out", str(out), "--quiet", *arguments]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode in (0, 1), command
    return used.ru_utime + used.ru_stime
