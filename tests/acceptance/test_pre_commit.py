"""The hooks run by pre-commit itself, which installs this project for them, in a repository of which the project is a folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.project import run_command
from support.shared import REPOSITORY

pytestmark = pytest.mark.acceptance


@pytest.fixture(scope="module")
def pre_commit(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, dict[str, str]]:
    """The command in an environment of its own, and the variables that it runs with."""
    folder = tmp_path_factory.mktemp("pre-commit")
    subprocess.run([sys.executable, "-m", "venv", "venv"], cwd=folder, check=True)
    words = [
        str(folder / "venv/bin/python"),
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "pre-commit",
    ]
    if subprocess.run(words, check=False).returncode != 0:
        pytest.skip("pip cannot get pre-commit")
    hidden = ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONHOME")
    plain = {name: value for name, value in os.environ.items() if name not in hidden}
    user = {
        f"GIT_{who}_{what}": "tests@here" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")
    }
    return str(folder / "venv/bin/pre-commit"), {**plain, **user, "PRE_COMMIT_HOME": str(folder / "home")}


def git(folder: Path, environment: dict[str, str], *words: str) -> None:
    subprocess.run(["git", *words], cwd=folder, env=environment, check=True, capture_output=True)


def committed(folder: Path, environment: dict[str, str]) -> None:
    git(folder, environment, "init", "--quiet")
    git(folder, environment, "add", "--all")
    git(folder, environment, "commit", "--quiet", "--message", "all")


def test_what_it_installs_holds_the_specs(pre_commit: tuple[str, dict[str, str]], tmp_path: Path) -> None:
    command, environment = pre_commit
    hooks, repository = tmp_path / "hooks", tmp_path / "repository"
    hooks.mkdir()
    for name in (
        ".pre-commit-hooks.yaml",
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "engine",
        "trace",
        "specs",
    ):
        source = REPOSITORY / name
        if source.is_dir():
            shutil.copytree(source, hooks / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, hooks / name)
    committed(hooks, environment)
    assert run_command("init", str(repository / "cars" / "one"))[0] == 0
    (repository / ".pre-commit-config.yaml").write_text(
        f"repos:\n- repo: {hooks}\n  rev: HEAD\n  hooks:\n  - id: trackmarshal-fmt\n"
        + "".join(
            f"  - id: trackmarshal-{verb}\n    args: [--project, cars/one]\n" for verb in ("check", "test")
        ),
        "utf-8",
    )
    committed(repository, environment)

    def run() -> tuple[int, str]:
        words = [command, "run", "--all-files", "--hook-stage", "pre-push"]
        done = subprocess.run(
            words, cwd=repository, env=environment, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout + done.stderr

    status, said = run()
    assert (status, said.count("Passed")) == (0, 3), said
    spec = next(
        path
        for path in (repository / "cars/one/specs").rglob("*.spec")
        if "expect satisfied" in path.read_text("utf-8")
    )
    spec.write_text(spec.read_text("utf-8").replace("expect satisfied", "expect   violated", 1), "utf-8")
    status, said = run()
    assert (status, said.count("Failed"), said.count("Passed")) == (1, 2, 1), said
    assert "files were modified by this hook" in said
    assert "expect violated" in spec.read_text("utf-8")
