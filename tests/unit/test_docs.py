"""The examples in the documentation are specs that compile, and their tests pass."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.backends.c.source import generate
from trackmarshal.cli.main import main
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.scenarios import load
from trackmarshal.scenarios.supervised import cycles
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.builders import BUILDERS
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = [
    pytest.param(block, id=f"{page.name}-{number}")
    for page in sorted((ROOT / "docs").glob("*.md"))
    for number, block in enumerate(re.findall(r"```spec\n(.*?)```", page.read_text("utf-8"), re.DOTALL))
]


PROGRAMS = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "supervisor.md").read_text("utf-8"), re.DOTALL)


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 2
    assert len(PROGRAMS) >= 2


def test_the_page_about_generated_c_shows_what_is_generated() -> None:
    page = (ROOT / "docs" / "generated-c.md").read_text("utf-8")
    blocks = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    spec = compile_paths([ROOT / "specs" / "supervisor"], ROOT).spec
    (friction,) = (code for code in generate(spec, spec.rules).rules if code.rule.name == "friction")
    assert f"{friction.text.rstrip()}\n" in blocks


def test_programs_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The programs of docs/supervisor.md, one after the other, where the project's specs are."""
    (tmp_path / "specs").symlink_to(ROOT / "specs")
    monkeypatch.chdir(tmp_path)
    for program in PROGRAMS:
        if "import pyarrow" in program:
            pytest.importorskip("pyarrow", reason="shows how another tool reads a record")
        exec(compile(program, "docs/supervisor.md", "exec"), {})
    said = capsys.readouterr().out
    assert "previous_emergency" in said
    assert "safe_gap violated" in said
    assert "emergency of" in said


def test_the_page_about_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The program of docs/process.md. A recording is held to no pace, so the limits are those of `replay`."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    (program,) = re.findall(
        r"```python\n(.*?)```", (ROOT / "docs" / "process.md").read_text("utf-8"), re.DOTALL
    )
    (tmp_path / "specs").symlink_to(ROOT / "specs")
    monkeypatch.chdir(tmp_path)
    # Two runs of the tests on one machine do not meet in one memory.
    own = program.replace("docs-example", f"docs-example-{os.getpid()}")
    exec(compile(own, "docs/process.md", "exec"), {})
    said = capsys.readouterr().out
    assert "previous_emergency" in said
    assert "safe_gap violated" in said
    assert said.splitlines()[-1] == "fallback silent"


def test_the_page_about_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The programs of docs/python.md, one after the other; what they say is what the page says, and the picture is the page's."""
    plt = pytest.importorskip("matplotlib.pyplot", reason="draws the page's picture")
    plt.switch_backend("agg")
    page = (ROOT / "docs" / "python.md").read_text("utf-8")
    (tmp_path / "specs").symlink_to(ROOT / "specs")
    monkeypatch.chdir(tmp_path)
    scope: dict[str, Any] = {}
    said = []
    for program in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(compile(program, "docs/python.md", "exec"), scope)
        said += capsys.readouterr().out.splitlines()
    assert re.findall(r"It prints `(.*?)`", page) == [said[1]]
    assert said[-1] == "safe_gap is violated from t = 10.4 s to 12.1 s"
    assert "t = 10.4: previous_emergency" in said
    margins, batch = scope["margins"], scope["batch"]
    assert ((margins < 0).any(axis=1) == (batch.verdicts["friction"] == "violated")).all()
    assert 0 < batch.safe.sum() < len(batch)
    assert scope["cycle_of"](0, 0.0, {}, {}, {}, []).signals["track"]["left"] is scope["left"]
    drawn, shown = plt.imread("margins.png"), plt.imread(ROOT / "docs" / "pictures" / "margins.png")
    assert drawn.shape == shown.shape
    assert abs(drawn - shown).mean() < 0.01  # other versions set letters otherwise


def test_the_page_about_reports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its program, where the project's specs are; and the pages that it writes are there."""
    page = (ROOT / "docs" / "reports.md").read_text("utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "specs").symlink_to(ROOT / "specs")
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "docs/reports.md", "exec"), {})
    assert re.findall(r"It prints `(.*?)`", page) == capsys.readouterr().out.splitlines()
    assert "cut-ins" in Path("pages/index.html").read_text("utf-8")
    assert "safe_gap" in Path("pages/runs/cut_in.html").read_text("utf-8")


def test_the_page_about_python_names_all_of_it() -> None:
    page = (ROOT / "docs" / "python.md").read_text("utf-8")
    assert [name for name in tm.__all__ if f"`{name}`" not in page] == []


def test_the_page_about_memory(capsys: pytest.CaptureFixture[str]) -> None:
    page = (ROOT / "docs" / "memory.md").read_text("utf-8")
    programs = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    outputs = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    for program, output in zip(programs, outputs, strict=True):
        exec(compile(program, "docs/memory.md", "exec"), {})
        assert capsys.readouterr().out == output


def test_the_page_about_rulebooks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its spec, candidates, command and program, in one folder; and its C, as a strict compiler reads it."""
    page = (ROOT / "docs" / "rulebooks.md").read_text("utf-8")
    blocks: dict[str, list[str]] = {}
    for language, text in re.findall(r"```(\w+)\n(.*?)```", page, re.DOTALL):
        blocks.setdefault(language, []).append(text)
    monkeypatch.chdir(tmp_path)
    Path("lanes.spec").write_text(blocks["spec"][0], "utf-8")
    Path("candidates.jsonl").write_text(blocks["json"][0], "utf-8")
    assert main(blocks["sh"][0].split()[1:]) == 1
    assert capsys.readouterr().out == blocks["text"][0]
    exec(compile(blocks["python"][0], "docs/rulebooks.md", "exec"), {})
    assert capsys.readouterr().out == blocks["text"][1]
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    assert main(["compile", "lanes.spec", "--target", "c", "--out", ".", "--quiet"]) == 0
    Path("option.c").write_text(blocks["c"][0])
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-c"]
    for file in ("option.c", "supervisor.c"):
        subprocess.run(["cc", *flags, file], check=True)


def test_the_page_about_scenarios(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its command, of a scenario that is about rules beside the project's: without these it is outside of its ground truth."""
    page = (ROOT / "docs" / "scenarios.md").read_text("utf-8")
    (command,) = re.findall(r"`trackmarshal (replay [^`]*late_brakes[^`]*)`", page)
    monkeypatch.chdir(ROOT)
    assert main(command.split()) == 0
    assert "takeup_friction" in capsys.readouterr().out


def test_the_page_about_taking_up() -> None:
    """What docs/takeup.md says of the shipped scenarios: in which cycles the rules as shipped refuse the emergency trajectory."""
    page = (ROOT / "docs" / "takeup.md").read_text("utf-8")
    ((lacks, of),) = re.findall(r"`free_lap` lacks it in (\d+) of (\d+) cycles", page)
    spec = tm.load([ROOT / "specs" / "supervisor", ROOT / "specs" / "fallback"])
    rules = [rule.name for rule in spec.rules if rule.name.startswith("takeup_")]
    assert len(rules) == 5
    evaluator = tm.Evaluator(spec, rules)

    def refused(name: str) -> tuple[set[float], int]:
        run = tm.replay(tm.load_recording(ROOT / "specs" / "scenarios" / name), evaluator)
        return {time for rule in rules for time in run.unsafe_times("emergency", rule)}, len(run.cycles)

    times, cycles_there = refused("free_lap.tmrec.jsonl")
    assert (len(times), cycles_there) == (int(lacks), int(of))
    for name in ("overreach", "late_brakes"):
        mistakes = re.findall(
            r"\{begin: (.*?), end: (.*?),", (ROOT / "specs" / "scenarios" / f"{name}.yaml").read_text("utf-8")
        )
        times, _ = refused(f"{name}.tmrec.jsonl.gz")
        assert times
        assert all(any(float(begin) <= time <= float(end) for begin, end in mistakes) for time in times)


def test_the_readme_supervises(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The README's program, on the first cycle of the cut-in, as if it came now."""
    (program,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)
    recording = load(ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    first = next(cycles(recording))
    (tmp_path / "specs").symlink_to(ROOT / "specs")
    monkeypatch.chdir(tmp_path)
    limits = Limits(oldest=math.inf, budget=60.0)  # the machine that tests run on is no car
    monkeypatch.setattr(Limits, "of", lambda spec: limits)
    scope = {"cycle": replace(first, t=time.monotonic())}
    exec(compile(program, "README.md", "exec"), scope)
    decision: Any = scope["decision"]
    assert decision.reasons == ()
    assert decision.action == "drive"
    assert (tmp_path / "run.arrows").stat().st_size > 0


@pytest.mark.parametrize("text", EXAMPLES)
def test_example_compiles_and_passes_its_tests(text: str, tmp_path: Path) -> None:
    path = tmp_path / "example.spec"
    path.write_text(text, encoding="utf-8")
    compiled = compile_paths([path])
    assert [str(d) for d in compiled.found] == []  # nor what the same pages warn of
    tests, found = prepare(compiled)
    assert found == []
    assert [(o.test.title, o.message) for o in run_tests(compiled.spec, tests) if o.outcome != "passed"] == []


def test_every_declaration_and_clause_is_documented() -> None:
    from trackmarshal.syntax.keywords import DECLARATIONS

    page = (ROOT / "docs" / "language.md").read_text("utf-8")
    assert [word for word in DECLARATIONS if f"`{word}" not in page] == []


def test_every_builder_is_documented_with_its_arguments() -> None:
    """A row each, which names the arguments of its own, and their defaults; where it begins, all say alike."""
    page = (ROOT / "docs" / "language.md").read_text("utf-8")
    begins = {"x: 0 m", "y: 0 m", "heading: 0 rad"}
    assert all(f"`{one}`" in page for one in begins)
    assert [verdict for verdict in VERDICTS if f"`{verdict}`" not in page.partition("## Tests")[2]] == []
    for builder in BUILDERS.values():
        (row,) = re.findall(rf"^\| `{builder.name}` \|.*\| (.*) \|$", page, re.MULTILINE)
        told = set(re.findall(r"`(\w+)(?:: ([^`]*))?`", row))
        known = {
            (name, "" if one.default is None else f"{one.default:g} {one.unit}".removesuffix(" 1"))
            for name, one in builder.parameters.items()
        }
        assert told == {(name, value) for name, value in known if f"{name}: {value}" not in begins}, (
            builder.name
        )


def test_the_page_about_integration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """docs/integration.md word for word: its programs and commands in their order, in one folder; what it says they print, they print."""
    page = (ROOT / "docs" / "integration.md").read_text("utf-8")
    for name in ("specs", "requirements"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "adapter", raising=False)
    scope: dict[str, Any] = {}
    said, statuses = [], []
    for language, text in re.findall(r"```(python|sh)\n(.*?)```", page, re.DOTALL):
        if language == "python":
            exec(compile(text, "docs/integration.md", "exec"), scope)
        else:
            (command,) = text.strip().splitlines()
            assert command.startswith("trackmarshal ")
            statuses.append(main(command.split()[1:]))
        said.append(capsys.readouterr().out)
    assert statuses == [1, 0]
    everything = "".join(said)
    for line in re.findall(r"```text\n(.*?)```", page, re.DOTALL)[0].splitlines():
        assert line in everything
    for line in re.findall(r"It prints `(.*?)`", page):
        assert f"{line}\n" in everything
    assert "the adapter is all that it takes" in everything
    assert re.search(r"driving friction by \d+ N at sample \d+, s = \d+ m", everything)
    sys.modules.pop("adapter", None)
