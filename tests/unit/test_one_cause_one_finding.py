"""What follows from one missing declaration is told once, names the module that has it, and hides nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from trackmarshal.cli.check import examine
from trackmarshal.diagnostics import json as as_json
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.semantics.errors.names import UnknownName

VEHICLE = (
    "module vehicle\n" + "".join(f"param q{i} : m = {i + 1} m\n" for i in range(20)) + 'assume A-DRY "dry"\n'
)
RULES = "module rules\nsignal ego : state { x: m }\n" + "".join(
    f'rule r{i} "r"\n  assuming A-DRY\n  require ego.x < q{i}\n' for i in range(20)
)


def project(folder: Path, **texts: str) -> Path:
    for name, text in texts.items():
        (folder / f"{name}.spec").write_text(text, "utf-8")
    return folder


def test_a_missing_use_is_one_error_with_every_place(tmp_path: Path) -> None:
    """Of a file checked by itself: the module that declares the names is not even loaded."""
    found = examine(
        compile_paths([project(tmp_path, vehicle=VEHICLE, rules=RULES) / "rules.spec"], tmp_path), None
    )
    assert len(found) == 1
    (only,) = found
    assert isinstance(only, UnknownName)
    assert only.modules == ("vehicle",)
    assert only.help == "add `use vehicle`, which declares them"
    (record,) = json.loads(as_json.render(found))
    assert len(record["related"]) == 39  # 20 parameters, 20 times the assumption


def test_it_stands_whatever_else_is_wrong(tmp_path: Path) -> None:
    more = 'rule s "s"\n  require ego.x < nowhere and ego.x < 3 s and ego.x < q1\n'
    found = compile_paths(
        [project(tmp_path, vehicle=VEHICLE, rules=RULES + more) / "rules.spec"], tmp_path
    ).found
    assert [(d.code, d.span.text) for d in found] == [
        ("E201", "A-DRY"),
        ("E201", "nowhere"),
        ("E301", "ego.x"),
    ]


def test_with_the_use_nothing_is_left(tmp_path: Path) -> None:
    fixed = RULES.replace("module rules\n", "module rules\nuse vehicle\n")
    compiled = compile_paths([project(tmp_path, vehicle=VEHICLE, rules=fixed) / "rules.spec"], tmp_path)
    assert examine(compiled, None) == []


def test_each_file_that_lacks_a_use_is_told_so(tmp_path: Path) -> None:
    both = project(
        tmp_path, vehicle=VEHICLE, rules=RULES, others=RULES.replace("module rules", "module others").replace("rule r", "rule o")
    )  # fmt: skip
    found = compile_paths([both], tmp_path).found
    assert [(d.code, d.span.file.path) for d in found] == [("E201", "others.spec"), ("E201", "rules.spec")]


@pytest.mark.parametrize("broken", [b"\xff\xfe", b"module vehicle\nuse rules\nparam q0 : m = 1 m\n"])
def test_a_module_that_cannot_be_used_is_not_named(broken: bytes, tmp_path: Path) -> None:
    """One that cannot be read, and one that uses this module itself."""
    project(tmp_path, rules='module rules\nsignal ego : state { x: m }\nrule r "r"\n  require ego.x < q0\n')
    (tmp_path / "vehicle.spec").write_bytes(broken)
    (only,) = compile_paths([tmp_path / "rules.spec"], tmp_path).found
    assert only.help == "declare it, or `use` the module that declares it"


def test_a_variable_that_is_misspelt_is_not_unused_too(tmp_path: Path) -> None:
    text = 'module m\nsignal plan : trajectory { t: s increasing, v: m/s }\nrule r "r"\n  for all p in plan\n  require P.v < 3 m/s\n'
    (only,) = compile_paths([project(tmp_path, m=text) / "m.spec"], tmp_path).found
    assert (only.code, only.help) == ("E201", "did you mean `p`? Capital and small letters differ")


def test_capitals_come_before_what_is_merely_alike() -> None:
    assert close_matches("P", ["p", "q"]) == "did you mean `p`? Capital and small letters differ"
    assert close_matches("Ego", ["ego", "egos"]) == "did you mean `ego`? Capital and small letters differ"
    assert close_matches("egoo", ["ego"]) == "did you mean `ego`?"
    assert close_matches("x", ["y"]) == ""


def test_what_is_much_longer_is_not_what_was_meant() -> None:
    """Of what a signal shows, `red` was said to mean `proceed`."""
    assert close_matches("red", ["stop", "proceed"]) == ""
    assert close_matches("proceed", ["red"]) == ""
    assert close_matches("veh", ["vehicle"]) == "did you mean `vehicle`?"
    assert close_matches("proced", ["stop", "proceed"]) == "did you mean `proceed`?"
