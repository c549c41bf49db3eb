"""In an empty folder, with an installed wheel and no checkout: from `init` to a green gate to compiled C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from support import start
from support.shared import REPOSITORY
from support.started import started

pytestmark = pytest.mark.acceptance


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command of a fresh environment that has the wheel, with the pinned versions of what it needs."""
    folder = tmp_path_factory.mktemp("installed")
    pinned = {
        **plain_environment(),
        "PIP_CONSTRAINT": str(REPOSITORY / "constraints.txt"),
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
    }
    call([sys.executable, "-m", "venv", "venv"], folder, pinned)
    python = str(folder / "venv" / "bin" / "python")
    call(
        [python, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", "wheels", str(REPOSITORY)],
        folder,
        pinned,
    )
    (wheel,) = (folder / "wheels").glob("trackmarshal-*.whl")
    call([python, "-m", "pip", "install", "--quiet", str(wheel)], folder, pinned)
    return folder / "venv" / "bin" / "trackmarshal"


def plain_environment() -> dict[str, str]:
    """Nothing of the checkout, and none of its environment's packages."""
    hidden = ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONHOME")
    return {name: value for name, value in os.environ.items() if name not in hidden}


def call(words: list[str], folder: Path, environment: dict[str, str]) -> tuple[int, str, str]:
    done = subprocess.run(words, check=False, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode in (0, 1, 2), (words, done.stdout, done.stderr)
    if words[0] != "trackmarshal" and "trackmarshal" not in Path(words[0]).name:
        assert done.returncode == 0, (words, done.stdout, done.stderr)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def project(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    empty = tmp_path_factory.mktemp("empty")
    assert not any((folder / "pyproject.toml").exists() for folder in (empty, *empty.parents))
    status, out, err = call([str(installed), "init"], empty, plain_environment())
    assert (status, err) == (0, ""), out
    return empty


def command(installed: Path, project: Path) -> start.Command:
    return lambda *words: call([str(installed), *words], project, plain_environment())


def test_from_init_to_a_green_gate_to_compiled_c(installed: Path, project: Path) -> None:
    run = command(installed, project)
    start.green(run)
    assert (project / "out" / "assess" / "index.html").is_file()
    decided = start.decisions(run)
    assert set(decided) == {"drive", "previous_emergency"}
    assert start.compiled(run, project / "build" / "c") == decided


def test_the_shipped_specs_are_there(installed: Path, tmp_path: Path) -> None:
    names = (
        "prelude.rss",
        "supervisor.assumptions",
        "supervisor.collision",
        "supervisor.conduct",
        "vehicles.av21",
    )
    (tmp_path / "own.spec").write_text(
        "\n".join(["module own", "", *(f"use {name}" for name in names[:-1]), ""]), "utf-8"
    )
    (tmp_path / "car.spec").write_text(f"module car\n\nuse {names[-1]}\n", "utf-8")
    run = command(installed, tmp_path)
    for name in ("own", "car"):
        status, out, err = run("check", f"{name}.spec")
        assert (status, err) == (0, ""), err
        assert "0 errors" in out
    status, _, err = run("compile", "own.spec", "--out", "c", "--rule", "safe_gap")
    assert (status, err) == (0, "")
    assert "library/supervisor/collision.spec" in (tmp_path / "c" / "supervisor.c").read_text("utf-8")


def test_new_pieces(installed: Path, tmp_path: Path) -> None:
    assert call([str(installed), "init", "--quiet"], tmp_path, plain_environment())[0] == 0
    run = command(installed, tmp_path)
    for words in (
        ("requirement", "R-2"),
        ("rule", "slow", "--satisfies", "R-2"),
        ("rulebook", "order"),
        ("scenario", "alone"),
    ):
        assert run("new", *words)[0] == 0
    assert run("check")[0] == 0
    assert run("fmt", "--check")[0] == 0
    assert run("trace", "--gate")[0] == 1


def test_watch_ends_cleanly(installed: Path, project: Path) -> None:
    with started(installed, "watch", cwd=project, env=plain_environment()) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line == b"-- all well; watching\n":
                break
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
