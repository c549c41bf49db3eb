"""The shipped specs from a project of somebody else: found by `use`, after its own, and traced as far as it demands something."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import trackmarshal as tm
from support.project import run_command
from support.shared import REPOSITORY
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.library import LIBRARY
from trackmarshal.semantics.compile import compile_paths


def module(folder: Path, name: str, text: str) -> Path:
    path = folder.joinpath(*name.split(".")).with_suffix(".spec")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"module {name}\n\n{text}", "utf-8")
    return path


def uses(folder: Path, *names: str) -> Path:
    return module(folder, "own", "\n".join(f"use {name}" for name in names) + "\n")


def test_every_shipped_module_can_be_used(tmp_path: Path) -> None:
    names = [
        ".".join(path.relative_to(LIBRARY).with_suffix("").parts)
        for path in sorted(LIBRARY.rglob("*.spec"))
        if "variants" not in path.parts and "vehicles" not in path.parts and "tracks" not in path.parts
    ]
    assert "supervisor.collision" in names
    for name in (*names, "vehicles.av21", "tracks.northfield", "prelude.rss"):
        more = () if name == "supervisor.assumptions" else ("supervisor.assumptions",)
        assert [str(d) for d in compile_paths([uses(tmp_path, *more, name)]).errors] == [], name


def test_a_new_project_takes_the_shipped_rules_as_the_tutorial_says(tmp_path: Path) -> None:
    car = tmp_path / "car"
    assert run_command("init", str(car), "--quiet")[0] == 0
    page = (REPOSITORY / "docs" / "tutorial.md").read_text("utf-8")
    said = page[page.index("- The shipped rules of a Supervisor") :]
    uses(car / "specs", "supervisor.collision", "supervisor.assumptions")
    assert {error.code for error in compile_paths([car / "specs"]).errors} >= {"E215"}
    for step in ("`use supervisor.interface` in place of `use signals`", "remove `specs/signals.spec`"):
        assert step in said
    (car / "specs" / "signals.spec").unlink()
    for path in (car / "specs").rglob("*.spec"):
        path.write_text(
            path.read_text("utf-8").replace("use signals\n", "use supervisor.interface\n"), "utf-8"
        )
    assert [str(error) for error in compile_paths([car / "specs"]).errors] == []


def test_rules_are_those_of_the_checkout(tmp_path: Path) -> None:
    shared = load(uses(tmp_path, "supervisor.assumptions", "supervisor.collision"), shown_from=tmp_path)
    shipped = load(REPOSITORY / "specs" / "supervisor")
    prints = {rule.name: rule.fingerprint for rule in shipped.rules}
    assert {rule.name: rule.fingerprint for rule in shared.rules}.items() <= prints.items()
    assert Evaluator(shared, ["safe_gap"]).rules[0].span.file.path == "library/supervisor/collision.spec"


def test_a_projects_own_module_comes_first(tmp_path: Path) -> None:
    module(tmp_path, "vehicles.devbot", "param v_max : m/s = 7 m/s\n")
    assert load(uses(tmp_path, "vehicles.devbot")).params["vehicles.devbot.v_max"].value == 7.0


def test_two_of_one_name_are_an_error(tmp_path: Path) -> None:
    """The library's rules use the library's vehicle: which of the two was meant, nobody can tell."""
    module(tmp_path, "vehicles.devbot", "param v_max : m/s = 7 m/s\n")
    compiled = compile_paths(
        [uses(tmp_path, "vehicles.devbot", "supervisor.assumptions", "supervisor.conduct")]
    )
    assert "two files are module `vehicles.devbot`" in [error.message for error in compiled.errors]


def test_a_copy_of_shipped_rules_in_a_folder_of_another_name_is_told_where_to_lie(tmp_path: Path) -> None:
    """What uses `supervisor.interface` reads the library's, wherever a copy lies that its name does not lead to."""
    copied = REPOSITORY / "specs" / "supervisor"
    for name in ("interface", "assumptions"):
        source = (copied / f"{name}.spec").read_text(encoding="utf-8")
        for folder in ("mine", "supervisor"):
            (tmp_path / folder).mkdir(exist_ok=True)
            (tmp_path / folder / f"{name}.spec").write_text(source, encoding="utf-8")
    (error,) = compile_paths([tmp_path / "mine" / "interface.spec", copied / "interface.spec"]).errors
    said = "`use supervisor.interface` reads supervisor/interface.spec: keep interface.spec there, or rename its module"
    assert error.help == said
    assert not compile_paths([tmp_path / "supervisor"]).errors


def test_what_a_project_does_not_demand_is_not_asked_of_it(tmp_path: Path) -> None:
    assert run_command("init", str(tmp_path), "--quiet")[0] == 0
    (tmp_path / "specs" / "signals.spec").unlink()
    speed = tmp_path / "specs" / "speed.spec"
    speed.write_text(speed.read_text("utf-8").replace("use signals", "use supervisor.interface"), "utf-8")
    uses(tmp_path / "specs", "supervisor.assumptions", "supervisor.collision")
    project = ("--project", str(tmp_path))
    assert run_command("check", *project)[0] == 0
    accept = ("--accept-baseline", "--by", "Ann Author", "--reason", "other signals")
    assert run_command("trace", *accept, *project)[0] == 0
    assert run_command("trace", "--gate", *project)[0] == 0
    requirement = (tmp_path / "requirements" / "requirements.yaml").read_text("utf-8")
    claimed = requirement.replace("R-1", "S-1-A-3").replace(
        "metrics: [speed_limit]", "assumptions: [A-LOCALISATION]"
    )
    (tmp_path / "requirements" / "claimed.yaml").write_text(claimed, "utf-8")
    status, out, _ = run_command("trace", "--gate", *project)
    assert status == 1
    assert "the assumption `A-LOCALISATION` has no evidence" in out


@pytest.mark.parametrize(
    ("limit", "fault"), [("samples : 1 = 20", "over_capacity"), ("rest_speed : m/s = 0 m/s", "")]
)
def test_replay_and_car_have_the_limits_of_the_project(limit: str, fault: str, tmp_path: Path) -> None:
    """30 samples are planned: where 20 are declared, every cycle is refused, in a replay as in the car and in generated C."""
    assert run_command("init", str(tmp_path), "--quiet")[0] == 0
    limits = tmp_path / "specs" / "supervisor" / "limits.spec"
    limits.write_text(f"module supervisor.limits\n\nparam {limit}\n", "utf-8")
    project = ("--project", str(tmp_path))
    scenario = str(tmp_path / "specs" / "scenarios" / "too_fast.yaml")
    status, out, _ = run_command("replay", scenario, *project)
    assert status == (1 if fault else 0), out
    spec = tm.load(tmp_path / "specs")
    recording = tm.load_recording(scenario)
    now = 0.0
    supervisor = tm.supervisor(spec, clock=lambda: now, params=recording.params)
    given = next(iter(tm.cycles(recording)))
    refused = {reason.split()[0] for reason in supervisor.step(given).reasons if reason.startswith("over_")}
    assert refused == ({fault} if fault else set())
    out_folder = tmp_path / "c"
    assert run_command("compile", "--out", str(out_folder), *project)[0] == 0
    if fault:
        assert f"| `TM_MAX_SAMPLES` | {limit.rsplit(maxsplit=1)[-1]} |" in (
            out_folder / "report.md"
        ).read_text("utf-8")
    accept = ("--accept-baseline", "--by", "Ann Author", "--reason", "another planner")  # limits are held
    assert run_command("trace", "--gate", *project)[0] == 1
    assert run_command("trace", *accept, *project)[0] == 0
    assert run_command("trace", "--gate", *project)[0] == (1 if fault else 0)


def test_a_package_that_is_installed_below_the_project_is_not_its_own(tmp_path: Path) -> None:
    """An environment often stands in the folder of the project: what shipped rules satisfy is not asked of it even so."""
    packages = tmp_path / ".venv" / "packages"
    for root in ("engine", "trace"):  # with what Python compiled of it
        shutil.copytree(REPOSITORY / root / "trackmarshal", packages / "trackmarshal", dirs_exist_ok=True)
    for name in ("supervisor", "vehicles", "tracks"):
        shutil.copytree(REPOSITORY / "specs" / name, packages / "trackmarshal" / "specs" / name)
    code = "import sys; from trackmarshal.cli.main import main; sys.exit(main())"
    for words in (["init", str(tmp_path)], ["check", "--project", str(tmp_path)]):
        if words[0] == "check":
            text = "module ours\n\nuse supervisor.assumptions\nuse supervisor.collision\n"
            (tmp_path / "specs" / "ours.spec").write_text(text, "utf-8")
        done = subprocess.run(
            [sys.executable, "-c", code, *words], env={**os.environ, "PYTHONPATH": str(packages)}, cwd=tmp_path, check=False,
            capture_output=True, text=True,
        )  # fmt: skip
        assert "E206" not in done.stdout + done.stderr
        assert done.returncode == 0 or words[0] == "check", done.stdout + done.stderr


def test_what_is_called_as_a_shipped_file_is_the_projects_own(tmp_path: Path) -> None:
    """Shipped files are shown as `library/...`: a rule in such a file of the project is not let off the gate."""
    assert run_command("init", str(tmp_path), "--quiet")[0] == 0
    model = tmp_path / "requirements" / "v-model.yaml"
    model.write_text(model.read_text("utf-8").replace("specs: [specs]", "specs: [specs, library]"), "utf-8")
    module(
        tmp_path,
        "library.vehicles.devbot",
        'event stray "x"\n\nrule hidden "nobody asks for it"\n  require not stray\n',
    )
    run_command("assess", "--project", str(tmp_path), "--out", str(tmp_path / "out"), "--quiet")
    status, out, err = run_command("trace", "--gate", "--verbose", "--project", str(tmp_path))
    assert status == 1
    assert "the rule `hidden` has no test" in out + err


@pytest.mark.parametrize(
    ("read", "held"),
    [("b_rear", ["b_rear <= b_front"]), ("t_unseen", ["oldest + longest_gap <= t_unseen"]), ("response", [])],
)
def test_a_shipped_constraint_is_held_where_a_claimed_rule_reads_what_it_restricts(
    read: str, held: list[str]
) -> None:
    from trackmarshal.cli.evidence import spec_parts
    from trackmarshal.records.specs import SpecItem

    compiled = compile_paths([REPOSITORY / "specs" / "supervisor"])
    files = {constraint.span.file.path for constraint in compiled.spec.constraints}
    item = SpecItem(
        "rule", "mine", "title", (), (), "f", 1, 1, "0", inputs={f"param supervisor.collision.{read}": "x"}
    )
    found = [part.name for part in spec_parts(compiled.spec, [item], files) if part.kind == "constraint"]
    assert found == held
    every = {part.name for part in spec_parts(compiled.spec, [item]) if part.kind == "constraint"}
    assert every == {
        "b_rear <= b_front",
        "oldest + longest_gap <= t_next",
        "oldest + longest_gap <= t_unseen",
    }
