"""`--format junit` of `test` and `trace`, and paths in reports from the root of a repository of which the project is a folder."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from golden.trace.cases import HERE
from support.junit_schema import wrong
from support.project import command, run_command

SPEC = """module own.a

signal ego : state { v: m/s }

rule slow "not fast"
  satisfies R-1
  require   ego.v <= 10 m/s

test slow "slow"
  given  ego = { v: 5 m/s }
  expect satisfied

test slow "fast"
  given  ego = { v: 15 m/s }
  expect satisfied
"""
V_MODEL = """document: v-model
title: small
project: {name: small, specs: [specs], default_spec: specs, baseline: requirements/baseline.json}
stages:
  - {id: S-2, title: "rules & \\"more\\"", shows: its rules, applies_to: ["*"], counts: [rule]}
  - {id: S-3, title: tests, shows: its tests, applies_to: ["*"], counts: [test]}
gate:
  - {stage: S-2, requirements: ["*"]}
  - {stage: S-3, requirements: ["*"]}
"""
REQUIREMENTS = """document: requirements
title: all
requirements:
  - {id: R-1, title: slow, statement: The car shall be slow., rationale: it is safe, adopted: so it is, status: approved, asil: QM,
     verification: [test], source: us}
"""


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A repository with the project in its folder `cars/one`."""
    (tmp_path / ".git").mkdir()
    project = tmp_path / "cars" / "one"
    for path, text in (
        ("specs/a.spec", SPEC),
        ("requirements/v-model.yaml", V_MODEL),
        ("requirements/all.yaml", REQUIREMENTS),
    ):
        (project / path).parent.mkdir(parents=True, exist_ok=True)
        (project / path).write_text(text, "utf-8")
    assert command(project, "trace", "--accept-baseline")[0] == 0
    return tmp_path


def test_a_report_of_inline_tests(repository: Path) -> None:
    status, out, _ = command(repository / "cars" / "one", "test", "--format", "junit")
    assert status == 1
    assert wrong(out) == []
    cases = {(c.get("classname"), c.get("name")): c for c in ET.fromstring(out).iter("testcase")}
    good, bad = cases["slow", "slow"], cases["slow", "fast"]
    assert [(p.get("name"), p.get("value")) for p in good.iter("property")] == [("verifies", "R-1")]
    assert (good.get("file"), good.get("line"), good.find("failure")) == ("cars/one/specs/a.spec", "9", None)
    failure = bad.find("failure")
    assert failure is not None
    assert "expected satisfied" in failure.get("message", "")
    assert (failure.text or "").startswith("cars/one/specs/a.spec:13: ")
    lacking = cases["slow", "tests inside, outside and on its boundary"].find("failure")
    assert lacking is not None
    assert lacking.get("message") == "`slow` has no test outside and none on its boundary"


def test_a_report_of_the_gate(repository: Path) -> None:
    status, out, _ = command(repository / "cars" / "one", "trace", "--gate", "--format", "junit")
    assert status == 1
    assert wrong(out) == []
    suites = {
        s.get("name"): [(c.get("name"), c.find("failure") is not None) for c in s] for s in ET.fromstring(out)
    }
    assert suites['S-2 rules & "more"'] == [("R-1 slow", False)]
    assert suites["S-3 tests"] == [("R-1 slow", True)]
    assert (
        next(c.get("file") for c in ET.fromstring(out).iter("testcase")) == "cars/one/requirements/all.yaml"
    )
    assert "verifies" not in out  # it would be evidence for itself


@pytest.mark.parametrize("name", ["passing", "failing"])
def test_goldens_fit_the_schema(name: str) -> None:
    assert wrong((HERE / "renders" / f"{name}.xml").read_text("utf-8")) == []


def test_what_a_report_must_not_be() -> None:
    head = '<testsuite name="a" tests="1" failures="0" errors="0">'
    assert wrong(f'<testsuites>{head}<testcase name="t"/></testsuite></testsuites>') == []
    assert wrong(f"<testsuites>{head}</testsuite></testsuites>") == [
        "tests of <testsuite> is not what it holds"
    ]
    assert wrong('<testsuites><testcase name="t"/></testsuites>') == ["<testcase> in <testsuites>"]
    assert wrong('<testsuites time="1.2.3"/>') == ["<testsuites time='1.2.3'>"]


def test_annotations_are_beside_the_lines_of_the_repository(
    repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(repository)
    _, out, _ = run_command("test", "--project", "cars/one", "--format", "github")
    lines = out.splitlines()
    assert lines[0].startswith("::error file=cars/one/specs/a.spec,line=13,title=T215::slow: fast: ")
    assert lines[1].startswith(
        "::error file=cars/one/specs/a.spec,line=5,title=T212::`slow` has no test outside"
    )
    _, out, _ = run_command("trace", "--project", "cars/one", "--format", "github")
    assert "::error file=cars/one/specs/a.spec,line=" in out
    _, out, _ = run_command("trace", "--project", "cars/one", "--as-is", "--format", "sarif")
    uris = {
        r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        for r in json.loads(out)["runs"][0]["results"]
        if "locations" in r
    }
    assert uris >= {"cars/one/specs/a.spec", "cars/one/requirements/all.yaml"}
    assert all(uri.startswith("cars/one/") for uri in uris)


def test_findings_of_check(repository: Path) -> None:
    project = repository / "cars" / "one"
    spec = project / "specs" / "a.spec"
    spec.write_text(SPEC.replace("ego.v <=", "ego.w <="), "utf-8")
    inside = "specs/a.spec"
    for format_, relative, wanted in (
        ("github", None, f"cars/one/{inside}"), ("github", project, inside), ("github", repository / "cars", f"one/{inside}"),
        ("github", project / "specs", "a.spec"), ("github", project / "requirements", "../specs/a.spec"),
        ("sarif", None, f"cars/one/{inside}"), ("json", None, inside), ("json", repository, f"cars/one/{inside}"),
    ):  # fmt: skip
        more = [] if relative is None else ["--relative-to", str(relative)]
        status, out, _ = command(project, "check", "--format", format_, *more)
        assert status == 1
        if format_ == "github":
            assert f"file={wanted}," in out
        elif format_ == "json":
            assert json.loads(out)[0]["file"] == wanted
        else:
            location = json.loads(out)["runs"][0]["results"][0]["locations"][0]["physicalLocation"]
            assert location["artifactLocation"]["uri"] == wanted


def test_json_of_tests_counts_paths_from_where_it_is_told(repository: Path) -> None:
    project = repository / "cars" / "one"
    for more, wanted in (([], "specs/a.spec"), (["--relative-to", str(repository)], "cars/one/specs/a.spec")):
        _, out, _ = command(project, "test", "--format", "json", *more)
        assert {test["file"] for test in json.loads(out)["tests"]} == {wanted}


def test_without_a_repository_paths_count_from_the_project(repository: Path) -> None:
    (repository / ".git").rmdir()
    _, out, _ = command(repository / "cars" / "one", "test", "--format", "github")
    assert "file=specs/a.spec," in out


@pytest.mark.parametrize(
    ("verb", "more", "message"),
    [
        ("test", ["--format", "github", "--relative-to", "/none/here"], "there is no folder /none/here"),
        ("test", ["--relative-to", "."], "the format text has no paths"),
        ("trace", ["--format", "json", "--relative-to", "."], "the format json has no paths"),
    ],
)
def test_paths_relative_to_nothing(repository: Path, verb: str, more: list[str], message: str) -> None:
    status, _, err = command(repository / "cars" / "one", verb, *more)
    assert status == 2
    assert f"error[T346]: {message}" in err
