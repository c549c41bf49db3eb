"""From `init` to a green gate to compiled C: the steps, for whichever command runs them."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from unittest import mock

from support.project import run_command

#: `trackmarshal ...` in a folder: exit status, standard output, standard error.
Command = Callable[..., tuple[int, str, str]]
#: Warnings are errors, and arithmetic is as it is written.
STRICT = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
SCENARIO = "specs/scenarios/too_fast.yaml"


def new_project(root: Path, kept: Path | None = None) -> None:
    """What `init` writes to a folder that is not there, written by it once for each name; kept: where to put what it leaves in an empty cache."""
    for place, data in _written(root.name).items():
        top, _, rest = place.partition("/")
        folder = root if top == "project" else kept
        if folder is not None:
            (folder / rest).parent.mkdir(parents=True, exist_ok=True)
            (folder / rest).write_bytes(data)


@cache
def _written(name: str) -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as folder:
        top = Path(folder)
        with mock.patch.dict(os.environ, {"TRACKMARSHAL_CACHE": str(top / "kept")}):
            assert run_command("init", str(top / name))[0] == 0
        (top / name).rename(top / "project")
        return {
            path.relative_to(top).as_posix(): path.read_bytes() for path in top.rglob("*") if path.is_file()
        }


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
