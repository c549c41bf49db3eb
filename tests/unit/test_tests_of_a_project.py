"""`trackmarshal test` without a path runs the tests of the folders that the project names."""

from __future__ import annotations

from pathlib import Path

from support.project import command, run_command

V_MODEL = """document: v-model
title: small
project:
  name: small
  specs: [{specs}]
  default_spec: specs/own/a.spec
"""
SPEC = """module {name}.a

signal ego_{name} : state {{ v: m/s }}

rule slow_{name} "not fast"
  require ego_{name}.v <= 10 m/s

test slow_{name} "slow"
  given  ego_{name} = {{ v: 5 m/s }}
  expect {expected}
"""


def project(root: Path, specs: str) -> Path:
    (root / "requirements").mkdir(parents=True)
    (root / "requirements" / "v-model.yaml").write_text(V_MODEL.format(specs=specs), "utf-8")
    for name, expected in (("own", "satisfied"), ("other", "violated")):
        folder = root / "specs" / name
        folder.mkdir(parents=True)
        (folder / "a.spec").write_text(SPEC.format(name=name, expected=expected), "utf-8")
    return root


def test_of_the_folders_that_it_names(tmp_path: Path) -> None:
    assert (
        command(project(tmp_path / "one", "specs/own"), "test")[1]
        .splitlines()[-1]
        .startswith("1 passed, 0 failed")
    )
    assert (
        command(project(tmp_path / "all", "specs"), "test")[1]
        .splitlines()[-1]
        .startswith("1 passed, 1 failed")
    )


BOTH_SIDES = """module sides

signal ego : state { v: m/s }

rule slow "not fast"
  require ego.v <= 10 m/s

test slow "slow"
  given  ego = { v: 5 m/s }
  expect satisfied

test slow "on it"
  given  ego = { v: 10 m/s }
  expect satisfied, margin 0 m/s

test slow "fast"
  given  ego = { v: %s m/s }
  expect violated
"""


def test_a_test_that_fails_covers_nothing(tmp_path: Path) -> None:
    root = project(tmp_path, "specs/own")
    path = root / "specs" / "own" / "sides.spec"
    path.with_name("a.spec").unlink()
    path.write_text(BOTH_SIDES % 11, "utf-8")
    status, out, _ = command(root, "test")
    assert (status, out) == (0, "3 passed, 0 failed; 1 of 1 rules covered\n")
    path.write_text(BOTH_SIDES % 9, "utf-8")
    status, out, _ = command(root, "test")
    assert status == 1
    assert "slow  3      yes     NO       yes" in out
    assert out.endswith("2 passed, 1 failed; 0 of 1 rules covered\n")


OVER_RUN = """module stops

event order "a stop is ordered"
event answer "it is acknowledged"

rule answered "Within 5 s"
  whenever  order
  within    5 s
  require   answer

test answered "in time"
  given  order = true
  after  3 s
  given  order = false
  given  answer = true
  expect satisfied
"""


def test_a_cycle_that_counts_for_nothing_is_named(tmp_path: Path) -> None:
    """The first cycle has no `answer`, and so no order: "inactive" alone says nothing of it."""
    (tmp_path / "stops.spec").write_text(OVER_RUN, "utf-8")
    status, out, err = run_command("test", str(tmp_path / "stops.spec"))
    assert status == 1
    assert (
        "expected satisfied, got inactive, margin inf (nothing in its range; of the cycle at 0 s nothing is known: D211 answer: it is not there)"
        in out + err
    )
    (tmp_path / "stops.spec").write_text(
        OVER_RUN.replace("order = true\n", "order = true\n  given  answer = false\n"), "utf-8"
    )
    assert run_command("test", str(tmp_path / "stops.spec"))[1].splitlines()[-1].startswith("1 passed")
