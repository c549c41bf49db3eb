"""What an assessment shows is used again where nothing changed that it was made from, and nowhere else."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from support.project import run_command
from support.shared import REPOSITORY
from support.start import new_project
from trackmarshal.cli import sources

tool = import_module("trackmarshal.meaning.tool")  # the package calls its function so
SPEC = "specs/speed.spec"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new project in a folder of its own, which is the current one, with a cache of its own."""
    root = tmp_path / "car"
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    new_project(root, tmp_path / "cache")
    monkeypatch.chdir(root)
    return root


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is done, as it is done: specs compiled, tests run, scenarios replayed."""
    done: list[str] = []

    class Listening(sources.Sources):
        def __init__(self, *args):  # type: ignore[no-untyped-def]
            done.append("compiled")
            super().__init__(*args)

        def test(self, *args):  # type: ignore[no-untyped-def]
            done.append("tested")
            return super().test(*args)

        def replay(self, *args):  # type: ignore[no-untyped-def]
            done.append("replayed")
            return super().replay(*args)

    monkeypatch.setattr("trackmarshal.cli.assessment.Sources", Listening)
    return done


def pages(root: Path) -> dict[str, str]:
    """Everything that was written, but for when."""
    folder = root / "out/assess"
    found = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {
        name: re.sub(r"20\d\d-\d\d-\d\dT[\d:]+\+00:00", "", path.read_text("utf-8"))
        for name, path in found.items()
    }


def test_an_unchanged_project_is_shown_again_with_nothing_made(project: Path, made: list[str]) -> None:
    first = run_command("assess")
    assert "replayed" in made
    before = pages(project)
    assert any(name.startswith("runs/") for name in before)
    made.clear()
    shutil.rmtree(project / "out/assess")
    assert run_command("assess") == first
    assert made == []
    assert pages(project) == before


def test_a_file_whose_name_no_document_can_hold(project: Path) -> None:
    """Bytes that are no UTF-8, as an archive of another system leaves them."""
    (project / "requirements" / os.fsdecode(b"caf\xe9.yaml")).touch()  # empty, so that it is named
    status, _, err = run_command("assess")
    assert (status, "internal error" in err) == (2, False)  # a document that cannot be used
    assert "caf?.yaml" in (project / "out/assess/matrix.md").read_text("utf-8")
    status, sarif, _ = run_command("trace", "--as-is", "--format", "sarif")
    assert (status, '"requirements/caf%E9.yaml"' in sarif) == (2, True)


def _replaced(name: str, old: str, new: str) -> Callable[[Path], None]:
    def edit(root: Path) -> None:
        path = root / name
        text = path.read_text("utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), "utf-8")

    return edit


def _kept_by_hand(root: Path) -> None:
    (path,) = (root.parent / "cache").glob("shown-*.json")
    held = path.read_bytes()
    changed = held.replace(b'"met": true', b'"met":false', 1)
    assert changed != held
    path.write_bytes(changed)


@pytest.mark.parametrize(
    ("edit", "expected"),
    [
        (_replaced("specs/scenarios/too_fast.yaml", "s: 20,", "s: 21,"), {"compiled", "replayed"}),
        (_replaced("specs/tracks/straight.yaml", "width: 10", "width: 11"), {"compiled", "replayed"}),
        (_replaced(SPEC, "module ", "-- a comment, and all lines stand elsewhere\nmodule "), {"compiled", "replayed"}),
        (_replaced(SPEC, "p.v <= v_event", "p.v < v_event"), {"compiled", "tested", "replayed"}),
        (_kept_by_hand, {"compiled", "replayed"}),
    ],
    ids=["a bit of the scenario", "a bit of its track", "a comment", "a comparison", "what was kept"],
)  # fmt: skip
def test_whatever_changed_is_made_anew(
    edit: Callable[[Path], None], expected: set[str], project: Path, made: list[str]
) -> None:
    run_command("assess")
    made.clear()
    edit(project)
    run_command("assess")
    assert set(made) == expected


def test_what_is_kept_rests_on_the_sources_of_the_matrix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which of a checkout lie elsewhere: an answer of what read a project before was kept when that was edited."""
    copy, found = tmp_path / "matrix", tool.find_spec
    shutil.copytree(REPOSITORY / "trace/trackmarshal/trace", copy, ignore=shutil.ignore_patterns("*.pyc"))
    before = tool.whole(), tool.tool()
    elsewhere = SimpleNamespace(submodule_search_locations=[str(copy)])
    monkeypatch.setattr(
        tool, "find_spec", lambda name: elsewhere if name == "trackmarshal.trace" else found(name)
    )
    said = []
    try:
        for text in (b"", b"# otherwise\n"):
            with (copy / "matrix.py").open("ab") as file:
                file.write(text)
            for kept in (tool.whole, tool.tool, tool._own):
                kept.cache_clear()
            said.append((tool.whole(), tool.tool()))
    finally:
        for kept in (tool.whole, tool.tool, tool._own):
            kept.cache_clear()
    assert said[0] == before
    assert (said[1][0] != before[0], said[1][1]) == (True, before[1])


@pytest.mark.parametrize("changed", ["numpy", "evaluator"])
def test_another_evaluator_makes_everything_anew(
    changed: str, project: Path, made: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_command("assess")
    made.clear()
    if changed == "numpy":
        monkeypatch.setattr(tool, "_numpy", lambda: b"another version")
    else:
        copy = tmp_path / "engine"
        shutil.copytree(
            REPOSITORY / "engine/trackmarshal", copy, ignore=shutil.ignore_patterns("__pycache__")
        )
        file = copy / "backends/numpy/logic.py"
        file.write_bytes(file.read_bytes() + b"\n")
        monkeypatch.setattr(tool, "HERE", copy)
    tool.tool.cache_clear()
    tool.whole.cache_clear()
    try:
        run_command("assess")
    finally:
        tool.tool.cache_clear()
        tool.whole.cache_clear()
    assert set(made) == {"compiled", "tested", "replayed"}


def _drawings(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The scenarios of which a page is drawn, as they are."""
    from trackmarshal.trace.report import pages as report
    from trackmarshal.trace.report.run_view import run_context as before

    drawn: list[str] = []

    def listening(run: Any, titles: Any) -> dict[str, Any]:
        drawn.append(run.name)
        return before(run, titles)

    monkeypatch.setattr(report, "run_context", listening)
    return drawn


def _renamed(root: Path) -> None:
    """Another title of every requirement, of which no result is made."""
    for path in (root / "requirements").rglob("*.yaml"):
        path.write_text(re.sub(r"(?m)^(\s*title: )", r"\1Now ", path.read_text("utf-8")), "utf-8")


def _page_by_hand(root: Path) -> None:
    (path,) = (root.parent / "cache").glob("pages-*.json")
    held = path.read_bytes()
    changed = held.replace(b"driven", b"drivem", 1)
    assert changed != held
    path.write_bytes(changed)


@pytest.mark.parametrize(
    ("edit", "again"),
    [
        (lambda root: None, False),
        (_renamed, True),
        (_replaced("specs/scenarios/too_fast.yaml", "s: 20,", "s: 21,"), True),
        (_page_by_hand, True),
    ],
    ids=["nothing", "titles of requirements", "a bit of the scenario", "what was kept"],
)
def test_pages_of_runs_are_drawn_again_where_anything_on_them_changed(
    edit: Callable[[Path], None], again: bool, project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_command("assess")
    edit(project)
    drawn = _drawings(monkeypatch)
    run_command("assess")
    assert bool(drawn) is again
    found = pages(project)
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "nothing kept"))
    run_command("assess")
    assert pages(project) == found


def test_pages_of_runs_are_drawn_again_by_another_program(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_command("assess")
    drawn = _drawings(monkeypatch)
    monkeypatch.setattr("trackmarshal.cli.drawn.drawing", lambda: "another one")
    run_command("assess")
    assert drawn


def test_the_date_of_a_page_is_that_of_its_assessment(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_command("assess")
    drawn = _drawings(monkeypatch)
    monkeypatch.setattr("trackmarshal.cli.evidence.now", lambda: "2031-02-03T04:05:06+00:00")
    run_command("assess")
    assert drawn == []
    found = [path.read_text("utf-8") for path in (project / "out/assess/runs").glob("*.html")]
    assert found
    assert all(page.count("<footer>2031-02-03T04:05:06+00:00</footer>") == 1 for page in found)


def test_rules_on_the_page_of_the_matrix_are_those_of_now(project: Path, tmp_path: Path) -> None:
    run_command("assess")
    run_command("assess")  # with what the first one kept
    known = pages(project)["matrix.html"]
    _replaced(SPEC, "p.v <= v_event", "p.v < v_event")(project)
    run_command("assess")
    found = pages(project)["matrix.html"]
    assert "p.v &lt; v_event" in found or "p.v < v_event" in found or "p.v \\u003c v_event" in found
    assert found != known
