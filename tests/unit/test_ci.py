"""The action, GitLab's template, the hooks, and docs/ci.md: what they say is run in a repository of which the project is a folder."""

from __future__ import annotations

import argparse
import importlib
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from golden.trace.cases import PROJECT
from support.junit_schema import wrong
from support.length import AT_LENGTH, at_length
from support.project import run_command
from support.shared import REPOSITORY
from trackmarshal.cli.main import VERBS, _common
from trackmarshal.junit import reading
from trackmarshal.trace import schema, sources

PAGE = (REPOSITORY / "docs" / "ci.md").read_text("utf-8")


def blocks(language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    return [text for of, text in found if of == language]


def loaded(path: str) -> Any:
    return yaml.safe_load((REPOSITORY / path).read_text("utf-8"))


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A repository with a new project in its folder `cars/one`, and the command on the path."""
    root = tmp_path / "repository"
    (root / ".git").mkdir(parents=True)
    assert run_command("init", str(root / "cars" / "one"))[0] == 0
    command = tmp_path / "bin" / "trackmarshal"
    command.parent.mkdir()
    command.write_text(
        f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m trackmarshal.cli.main "$@"\n', "utf-8"
    )
    command.chmod(0o755)
    return root


def break_a_test(repository: Path) -> None:
    spec = next(
        path
        for path in (repository / "cars/one/specs").rglob("*.spec")
        if "expect satisfied" in path.read_text("utf-8")
    )
    text = spec.read_text("utf-8")
    spec.write_text(text.replace("expect satisfied", "expect violated", 1), "utf-8")


def only_what_is_said(repository: Path) -> None:
    """Every day, a command of a step that writes a report does nothing but fail, as those do here."""
    command = repository.parent / "bin" / "trackmarshal"
    first, rest = command.read_text("utf-8").split("\n", 1)
    command.write_text(f'{first}\ncase "$*" in *"--format github"*) ;; *) exit 2 ;; esac\n{rest}', "utf-8")


def shell(repository: Path, script: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """As both services run a step."""
    import os

    environment = {
        **os.environ,
        **variables,
        "PATH": f"{repository.parent / 'bin'}{os.pathsep}{os.environ['PATH']}",
    }
    words = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script]
    return subprocess.run(words, cwd=repository, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.acceptance
@pytest.mark.parametrize("broken", [False, True])
def test_the_action(repository: Path, broken: bool) -> None:
    action = loaded("action.yml")
    assert action["runs"]["using"] == "composite"
    assert set(action["inputs"]) == {"project", "python-version", "reports"}
    if broken:
        break_a_test(repository)
    said = {}
    for step in action["runs"]["steps"]:
        for value in re.findall(r"\$\{\{(.*?)\}\}", str(step)):
            assert re.fullmatch(r" (inputs\.[\w-]+|!cancelled\(\)) ", value), value
        assert "${{" not in step.get("run", ""), "what is given from outside comes as a variable"
        if "run" in step and step["name"] != "install":
            given = {"PROJECT": "${{ inputs.project }}", "REPORTS": "${{ inputs.reports }}"}
            assert step["env"] == given
            assert step["shell"] == "bash"
            said[step["name"]] = shell(repository, step["run"], PROJECT="cars/one", REPORTS="trackmarshal")
    statuses = {name: done.returncode for name, done in said.items()}
    assert statuses == {"check": 0, "test": int(broken), "gate": int(broken)}, said
    reports = repository / "trackmarshal"
    assert sorted(path.name for path in reports.iterdir()) == [
        "check.sarif",
        "gate.xml",
        "matrix.html",
        "tests.xml",
        "trace.sarif",
    ]
    for name in ("tests.xml", "gate.xml"):
        text = (reports / name).read_text("utf-8")
        assert wrong(text) == []
        assert ("<failure" in text) == broken
        assert 'file="cars/one/' in text
    assert ("::error file=cars/one/specs/" in said["test"].stdout) == broken
    # What follows from the edited test, a cell that it no longer fills, is folded under it.
    assert ("::error file=cars/one/specs/" in said["gate"].stdout) == broken


@pytest.mark.acceptance
@pytest.mark.parametrize("broken", [False, True])
def test_the_job_of_gitlab(repository: Path, broken: bool) -> None:
    template = loaded("ci/gitlab.yml")
    job = template["trackmarshal"]
    if broken:
        break_a_test(repository)
    done = shell(repository, "\n".join(job["script"]), TRACKMARSHAL_PROJECT="cars/one")
    assert done.returncode == int(broken), done.stderr
    found = sorted(
        path.relative_to(repository).as_posix()
        for path in repository.glob(job["artifacts"]["reports"]["junit"])
    )
    assert found == ["trackmarshal-reports/gate.xml", "trackmarshal-reports/tests.xml"]
    assert all(("<failure" in (repository / path).read_text("utf-8")) == broken for path in found)
    assert set(template["variables"]) == {"TRACKMARSHAL_PROJECT", "TRACKMARSHAL_PACKAGE", "GIT_DEPTH"}


def test_the_image_of_gitlab_has_git() -> None:
    """Which holds the baseline against its versions; the small variants of python's images have none."""
    image = loaded("ci/gitlab.yml")["trackmarshal"]["image"]
    assert re.fullmatch(r"python:3\.[0-9]+", image)


def scripts() -> dict[str, str]:
    """What the services run in their shells, without installing."""
    steps = loaded("action.yml")["runs"]["steps"]
    action = {
        f"action: {step['name']}": step["run"]
        for step in steps
        if "run" in step and step["name"] != "install"
    }
    return {**action, "gitlab": "\n".join(loaded("ci/gitlab.yml")["trackmarshal"]["script"])}


@pytest.mark.parametrize("script", scripts())
def test_every_command_is_one(script: str, repository: Path) -> None:
    """With a stand-in that writes down its arguments: each is understood, names the project, and what it finds fails the job."""
    (repository.parent / "bin" / "trackmarshal").write_text(
        '#!/bin/sh\necho "$@" >> "$LOG"\ncase "$*" in *--exit-zero*) exit 0;; *) exit 1;; esac\n', "utf-8"
    )
    log = repository / "log"
    given = {"LOG": str(log), "PROJECT": "cars/one", "REPORTS": "reports", "TRACKMARSHAL_PROJECT": "cars/one"}
    done = shell(repository, scripts()[script], **given)
    assert done.returncode == 1, done.stderr
    for words in map(str.split, log.read_text("utf-8").splitlines()):
        module = importlib.import_module(
            f"trackmarshal.cli.{'run_tests' if words[0] == 'test' else words[0]}"
        )
        parser = argparse.ArgumentParser(exit_on_error=False)
        _common(parser)
        module.configure(parser)
        assert parser.parse_args(words[1:]).project == "cars/one"


@pytest.mark.parametrize(
    ("step", "file"),
    [
        ("check", "specs/speed.spec"), at_length("check", "requirements/requirements.yaml"), ("test", "specs/speed.spec"),
        at_length("gate", "specs/speed.spec"), ("gate", "requirements/requirements.yaml"),
    ],
)  # fmt: skip
def test_a_step_of_the_action_says_why_it_fails(step: str, file: str, repository: Path) -> None:
    """A file that cannot be read ended the step at its first command, whose words are in a report; the log had none."""
    (repository / "cars/one" / file).write_bytes(b"\xff")
    if not AT_LENGTH and step != "test":
        only_what_is_said(repository)
    done = shell(repository, scripts()[f"action: {step}"], PROJECT="cars/one", REPORTS="reports")
    assert done.returncode != 0
    assert "is not UTF-8" in done.stdout + done.stderr
    if step == "test":
        assert f"::error file=cars/one/{file}" in done.stdout
        report = (repository / "reports" / "tests.xml").read_text("utf-8")
        assert wrong(report) == []
        assert "E004" in report


def test_the_hooks() -> None:
    hooks = {hook["id"]: hook for hook in loaded(".pre-commit-hooks.yaml")}
    assert set(hooks) == set(re.findall(r"- id: (trackmarshal-\w+)", PAGE))
    for hook in hooks.values():
        assert hook["entry"].split()[1] in VERBS
        assert hook["language"] == "python"
        assert re.search(hook["files"], "cars/one/specs/a.spec")
        assert not re.search(hook["files"], "cars/one/a.py")
    check = re.compile(hooks["trackmarshal-check"]["files"])
    assert check.search("cars/one/requirements/deep/a.yaml")
    assert check.search("requirements/v-model.yaml")
    assert not check.search("docs/a.yaml")


def test_the_hooks_do_what_they_say(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hooks = {hook["id"]: hook["entry"].split()[1:] for hook in loaded(".pre-commit-hooks.yaml")}
    monkeypatch.chdir(repository)
    spec = next((repository / "cars/one/specs").rglob("*.spec")).relative_to(repository)
    text = (repository / spec).read_text("utf-8")
    (repository / spec).write_text(text + "\n\n\n", "utf-8")
    assert run_command(*hooks["trackmarshal-fmt"], str(spec))[0] == 0
    assert (repository / spec).read_text("utf-8") == text
    assert run_command(*hooks["trackmarshal-check"], "--project", "cars/one")[0] == 0
    break_a_test(repository)
    assert run_command(*hooks["trackmarshal-test"], "--project", "cars/one")[0] == 1


def test_the_commands_of_the_page(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    commands = [
        line for block in blocks("") for line in block.splitlines() if line.startswith("trackmarshal ")
    ]
    assert len(commands) == 2
    monkeypatch.chdir(repository)
    for command in commands:
        assert run_command(*shlex.split(command)[1:])[0] == 0


def test_what_the_page_declares_is_what_is_read() -> None:
    from jsonschema import Draft202012Validator

    declared = [data for block in blocks("yaml") for data in [yaml.safe_load(block)] if "project" in data]
    assert len(declared) == 1
    definitions = schema.schema()["$defs"]
    for entry in declared[0]["project"]["junit"]:
        Draft202012Validator(definitions["report"]).validate(entry)
    counts = definitions["stage"]["properties"]["counts"]
    Draft202012Validator(counts).validate(declared[0]["stages"][0]["counts"])


def test_the_report_of_the_page(tmp_path: Path) -> None:
    (block,) = blocks("xml")
    (tmp_path / "a.xml").write_text(f"<testsuite>{block}</testsuite>", "utf-8")
    (test,) = reading.read(tmp_path / "a.xml", "a.xml")
    assert (test.outcome, test.requirements) == ("passed", ("S-1-B-1", "S-1-B-4"))


def test_the_comments_of_the_page(tmp_path: Path) -> None:
    from trackmarshal import trace

    (block,) = (block for block in blocks("") if block.startswith("# implements"))
    shell_, block_comment, line_comment = block.splitlines()
    shutil.copytree(PROJECT, tmp_path / "project")
    v_model = tmp_path / "project" / "requirements" / "v-model.yaml"
    v_model.write_text(
        v_model.read_text("utf-8").replace("stages:\n", "  sources: [src]\nstages:\n", 1), "utf-8"
    )
    (tmp_path / "project" / "src").mkdir()
    for name, text in (("a.py", shell_), ("a.sh", shell_), ("a.c", block_comment), ("b.c", line_comment)):
        (tmp_path / "project" / "src" / name).write_text(text + "\n", "utf-8")
    project, _ = trace.load(tmp_path / "project")
    found = [
        (marker.place.file, marker.requirement) for marker in sources.load(tmp_path / "project", project, [])
    ]
    assert found == [
        ("src/a.c", "S-1-B-1"), ("src/a.c", "S-1-B-4"), ("src/a.py", "S-1-B-4"), ("src/a.sh", "S-1-B-4"), ("src/b.c", "S-1-B-1"),
    ]  # fmt: skip


def test_the_test_of_the_page() -> None:
    (block,) = blocks("python")
    names: dict[str, Any] = {}
    exec(compile(block, "docs/ci.md", "exec"), names)
    names["test_the_same_again"]()
    assert [mark.args for mark in names["test_the_same_again"].pytestmark] == [("S-1-B-1",)]
