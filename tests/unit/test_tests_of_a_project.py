"""`trackmarshal test` without a path runs the tests of the folders that the project names."""

from __future__ import annotations

from pathlib import Path

from support.project import command

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
