"""`watch`: a round after every save, one for files that are saved together, none for nothing, and a clean end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.project import run_command
from trackmarshal.cli.main import main
from trackmarshal.cli.watch import state, watch


class Ended(Exception):
    """No more looks."""


def rounds(folder: Path, script: list[Callable[[], object]]) -> list[dict[str, str]]:
    """What lay in the folder at each round, where one thing of the script happens at each look."""
    seen: list[dict[str, str]] = []
    steps = iter(script)

    def look() -> None:
        seen.append({path.name: path.read_text("utf-8") for path in sorted(folder.iterdir())})

    def sleep(_: float) -> None:
        step = next(steps, None)
        if step is None:
            raise Ended
        step()

    with pytest.raises(Ended):
        watch([folder], look, sleep)
    return seen


def test_a_save_makes_a_round_and_nothing_makes_none(tmp_path: Path) -> None:
    file = tmp_path / "a.spec"
    file.write_text("1")
    quiet = [lambda: None] * 3
    assert rounds(tmp_path, [*quiet]) == [{"a.spec": "1"}]
    found = rounds(tmp_path, [*quiet, lambda: file.write_text("22"), *quiet, file.unlink, *quiet])
    assert found == [{"a.spec": "1"}, {"a.spec": "22"}, {}]


def test_a_save_in_a_folder_that_a_link_leads_to_makes_a_round(tmp_path: Path) -> None:
    shared, specs = tmp_path / "shared", tmp_path / "specs"
    shared.mkdir()
    specs.mkdir()
    (shared / "a.spec").write_text("1")
    (specs / "shared").symlink_to(shared)
    before = state([specs])
    (shared / "a.spec").write_text("22")
    assert state([specs]) != before


def test_saves_in_a_row_make_one_round(tmp_path: Path) -> None:
    file, other = tmp_path / "a.spec", tmp_path / "b.yaml"
    file.write_text("1")
    saves = [lambda: file.write_text("22"), lambda: other.write_text("333"), lambda: file.write_text("4444")]
    found = rounds(tmp_path, [*saves, lambda: None, lambda: None, lambda: None])
    assert found == [{"a.spec": "1"}, {"a.spec": "4444", "b.yaml": "333"}]


def test_a_save_during_a_round_makes_another(tmp_path: Path) -> None:
    file = tmp_path / "a.spec"
    file.write_text("1")
    seen: list[str] = []

    def look() -> None:
        seen.append(file.read_text())
        if seen == ["1"]:
            file.write_text("22")

    def sleep(_: float) -> None:
        if len(seen) == 2:
            raise Ended

    with pytest.raises(Ended):
        watch([tmp_path], look, sleep)
    assert seen == ["1", "22"]


def test_only_specs_and_requirements_are_watched(tmp_path: Path) -> None:
    for name in ("a.spec", "b.yaml", "c.json", "d.spec~"):
        (tmp_path / name).write_text("x")
    assert sorted(Path(name).name for name in state([tmp_path, tmp_path / "gone"])) == ["a.spec", "b.yaml"]


def test_a_folder_that_goes_away_while_it_is_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As another branch is checked out: `watch` ended, with an error."""
    gone, scandir = tmp_path / "gone", os.scandir
    gone.mkdir()
    (tmp_path / "a.spec").write_text("module a\n")

    def going(path: Any = ".") -> Any:
        if gone.exists() and Path(path) == gone:
            gone.rmdir()
        return scandir(path)

    monkeypatch.setattr(os, "scandir", going)
    assert [Path(name).name for name in state([tmp_path])] == ["a.spec"]
    assert not gone.exists()


def test_a_quiet_round_is_quiet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a round, what `check` sums up is no result; that all is well is."""
    file = tmp_path / "a.spec"
    file.write_text("module a\n\nparam top: m/s = 2 m/s\n", "utf-8")

    monkeypatch.setattr("trackmarshal.cli.watch.watch", lambda _, look_into: look_into())
    monkeypatch.chdir(tmp_path)
    said = {}
    for quiet in ([], ["--quiet"]):
        main(["watch", str(file), *quiet])
        said[len(quiet)] = capsys.readouterr().out
    assert "1 module" in said[0]
    assert "1 module" not in said[1]
    assert all("-- all well; watching" in text for text in said.values())


def test_it_goes_on_after_a_syntax_error_and_ends_with_0(tmp_path: Path) -> None:
    """The command itself: green, broken, green again, Ctrl-C."""
    assert run_command("init", str(tmp_path), "--quiet")[0] == 0
    said = tmp_path / "said.txt"
    # Who starts the tests in the background ignores Ctrl-C, and so would their children.
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    code += "import sys; from trackmarshal.cli.main import main; sys.exit(main())"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with said.open("w") as out:
        process = subprocess.Popen(
            [sys.executable, "-c", code, "watch", "--project", str(tmp_path)],
            stdout=out, stderr=subprocess.STDOUT, env=environment,
        )  # fmt: skip
        try:
            spec = tmp_path / "specs" / "speed.spec"
            text = spec.read_text("utf-8")
            until(said, "-- all well; watching", 1)
            spec.write_text(f"{text}\nrule\n", "utf-8")
            until(said, "-- check: not yet; watching", 1)
            spec.write_text(text.replace("expect violated", "expect satisfied"), "utf-8")
            until(said, "-- test: not yet; watching", 1)
            spec.write_text(text, "utf-8")
            until(said, "-- all well; watching", 2)
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 0
        finally:
            process.kill()
            process.wait()
    told = said.read_text("utf-8")
    assert "error[E102]" in told
    assert "too fast at one sample" in told
    assert told.endswith("stopped\n")
    assert "Traceback" not in told


def until(file: Path, text: str, times: int) -> None:
    end = time.monotonic() + 120.0
    while file.read_text("utf-8").count(text) < times:
        assert time.monotonic() < end, file.read_text("utf-8")
        time.sleep(0.05)
