"""From `init` to a green gate to compiled C: the steps, for whichever command runs them."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

#: `trackmarshal ...` in a folder: exit status, standard output, standard error.
Command = Callable[..., tuple[int, str, str]]
#: Warnings are errors, and arithmetic is as it is written.
STRICT = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
SCENARIO = "specs/scenarios/too_fast.yaml"


def green(run: Command) -> None:
    """Everything that the project's own README asks for passes."""
    for words in (
        ("check",),
        ("fmt", "--check"),
        ("test",),
        ("assess",),
        ("trace", "--gate"),
        ("replay", SCENARIO),
    ):
        status, out, err = run(*words)
        assert status == 0, (words, out, err)


def decisions(run: Command) -> list[str]:
    """What is decided in each cycle of the scenario, by `replay`."""
    status, out, err = run("replay", SCENARIO, "--format", "jsonl")
    assert status == 0, err
    lines = [json.loads(line) for line in out.splitlines()]
    return [line["decision"] for line in lines if line["candidate"] == "driving"]


def compiled(run: Command, folder: Path) -> list[str]:
    """What is decided in each cycle of the scenario, by the generated C, compiled with warnings as errors."""
    status, _, err = run("compile", "--out", str(folder), "--cycles", SCENARIO)
    assert status == 0, err
    sources = ["main.c", "cycles.c", "supervisor.c"]
    made = subprocess.run(
        ["gcc", *STRICT, *sources, "-o", "example", "-lm"],
        check=False,
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert made.returncode == 0, made.stderr
    said = subprocess.run(
        [str(folder / "example"), "too_fast.cycles"], check=False, cwd=folder, capture_output=True, text=True
    )
    assert said.returncode == 0, said.stderr
    return [line.split()[1] for line in said.stdout.splitlines() if line.startswith("decision ")]
