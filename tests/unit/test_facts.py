"""What is kept of a project's specs was read from what is there: a file that is written meanwhile leaves nothing behind."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from support.project import run_command
from trackmarshal.cli import facts
from trackmarshal.cli.recordings import recorded
from trackmarshal.library import LIBRARY
from trackmarshal.semantics.modules import Library


@pytest.mark.parametrize(
    "meanwhile", [None, "written", "gone", "another", "a new one", "one that was wanted"]
)
def test_what_is_written_while_it_is_read_is_not_kept(
    meanwhile: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "project"
    (root / "specs").mkdir(parents=True)
    spec, other = root / "specs" / "a.spec", root / "b.spec"
    spec.write_text("before")
    other.write_text("latter")  # as many letters
    made: list[str] = []

    def make() -> facts.Facts:
        made.append(spec.read_text())
        if meanwhile == "written":
            spec.write_text("after")
        elif meanwhile == "gone" and len(made) == 1:
            spec.unlink()
        elif meanwhile == "another" and other.exists():
            os.replace(other, spec)
        elif meanwhile == "a new one":  # which nobody has read
            (root / "specs" / "new.spec").write_text("new")
        elif meanwhile == "one that was wanted":
            (root / "wanted.jsonl").write_text("new")
        return facts.Facts([], [], [], {}, [], [])

    facts.facts(root, ["specs"], ["wanted.jsonl"], make)
    if meanwhile == "gone":
        spec.write_text("after")
    facts.facts(root, ["specs"], ["wanted.jsonl"], make)
    assert len(made) == (1 if meanwhile is None else 2)


def test_what_is_written_while_it_is_hashed_is_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What had been read before was kept under the hash of what was written then: for good, as nothing changed any more."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    spec = tmp_path / "project" / "specs" / "a.spec"
    spec.parent.mkdir(parents=True)
    spec.write_text("before")
    made: list[str] = []

    def make() -> facts.Facts:
        made.append(spec.read_text())
        return facts.Facts([], [], [], {}, [], [])

    def late(path: Path) -> bytes:
        spec.write_text("after")
        return path.read_bytes()

    monkeypatch.setattr("trackmarshal.cli.kept.read_regular", late)
    for _ in range(2):
        facts.facts(tmp_path / "project", ["specs"], [], make)
    assert made == ["before", "after"]


@pytest.mark.parametrize("cache", ["cache", ".", "project", "project/cache"])
def test_a_project_within_the_cache_is_read_again_too(
    cache: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever the cache is: files in it are passed over, those of a project are not, as those of one on a disk in memory below `/dev` are not."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / cache))
    spec = tmp_path / "project" / "specs" / "a.spec"
    spec.parent.mkdir(parents=True)
    made: list[str] = []

    def make() -> facts.Facts:
        made.append(spec.read_text())
        return facts.Facts([], [], [], {}, [], [])

    for text in ("before", "after"):
        spec.write_text(text)
        facts.facts(tmp_path / "project", ["specs"], [], make)
    assert made == ["before", "after"]


@pytest.mark.parametrize(
    "how", ["a folder", "a folder elsewhere now", "a file", "a file elsewhere now", "a path"]
)
def test_what_links_lead_to_is_read_again_when_it_is_another(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Specs that projects share lie outside of each, and a green cell must not outlive an edit of them."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root, shared, other = tmp_path / "project", tmp_path / "shared", tmp_path / "other"
    for folder in (root, shared, other):
        folder.mkdir()
        (folder / "a.spec").write_text(folder.name)
    specs = root / "specs"
    named = "specs"
    if how.startswith("a folder"):
        specs.symlink_to(shared)
    elif how.startswith("a file"):
        specs.mkdir()
        (specs / "a.spec").symlink_to(shared / "a.spec")
    else:
        named = "../shared"
    made: list[str] = []

    def make() -> facts.Facts:
        made.append((root / named / "a.spec").resolve().read_text())
        return facts.Facts([], [], [], {}, [], [])

    def asked() -> None:
        facts.facts(root, [named], [], make)

    asked()
    asked()
    assert made == ["shared"]
    link = specs if how.startswith("a folder") else specs / "a.spec"
    if how.endswith("elsewhere now"):
        link.unlink()
        link.symlink_to(other if link == specs else other / "a.spec")
    else:
        (shared / "a.spec").write_text("weaker")
    asked()
    assert made == ["shared", "other" if how.endswith("elsewhere now") else "weaker"]


def test_a_module_that_takes_the_place_of_a_shipped_one_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where nothing else was read of its folder, which is none that the project names: the gate went on with the library's vehicle."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "project"
    (root / "specs" / "vehicles").mkdir(parents=True)
    (root / "specs" / "vehicles" / "README.md").write_text("Vehicles are on their way.\n")
    (root / "specs" / "a.spec").write_text("module a\nuse vehicles.devbot\n")

    def make() -> facts.Facts:
        library = Library(root)
        library.load([root / "specs" / "a.spec"])
        own = library.modules["vehicles.devbot"].path.is_relative_to(root)
        return facts.Facts([], [], [], {"own": {"is": str(own)}}, [], [])

    assert facts.facts(root, ["specs/a.spec"], [], make).run_inputs["own"]["is"] == "False"
    (root / "specs" / "vehicles" / "devbot.spec").write_text("module vehicles.devbot\n")
    assert facts.facts(root, ["specs/a.spec"], [], make).run_inputs["own"]["is"] == "True"


def test_what_is_written_meanwhile_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that is written aside and gone again is none that facts were made from."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "project"
    (root / "specs").mkdir(parents=True)
    made: list[int] = []

    def make() -> facts.Facts:
        made.append(1)
        aside = tmp_path / "aside"
        aside.write_text("x")
        aside.unlink()
        return facts.Facts([], [], [], {}, [], [])

    facts.facts(root, ["specs"], [], make)
    facts.facts(root, ["specs"], [], make)
    assert made == [1]


def test_a_run_rests_on_what_a_spec_says_of_its_vehicle_and_on_its_truth(tmp_path: Path) -> None:
    """Neither has to be read by a rule: the one makes the trajectories, the other says which are to be unsafe."""
    root = tmp_path / "car"
    assert run_command("init", str(root))[0] == 0
    vehicle, scenario = root / "veh.spec", root / "specs" / "scenarios" / "too_fast.yaml"
    own = (LIBRARY / "vehicles" / "devbot.spec").read_text("utf-8").replace("vehicles.devbot", "veh", 1)
    speed = root / "specs" / "speed.spec"
    speed.write_text(speed.read_text("utf-8") + "\nparam due : m/s = 40 m/s\n", "utf-8")
    said = scenario.read_text("utf-8").replace("vehicle: vehicles.devbot", "vehicle: ../../veh.spec")
    scenario.write_text(said.replace("as: static", "unsafe: 'ego.v > due'"), "utf-8")

    def now() -> str:
        shown = "specs/scenarios/too_fast.yaml"
        return recorded(root, scenario, shown)[1]

    vehicle.write_text(own, "utf-8")
    first = now()
    vehicle.write_text(own + "\n-- measured twice\n", "utf-8")
    assert now() == first
    vehicle.write_text(re.sub(r"(param drag .*?= )0.854", r"\g<1>5", own), "utf-8")
    assert now() != first
    vehicle.write_text(own, "utf-8")
    speed.write_text(speed.read_text("utf-8").replace("= 40 m/s", "= 20 m/s"), "utf-8")
    assert now() != first


def test_a_run_rests_on_a_track_outside_of_the_project_too(tmp_path: Path) -> None:
    """What projects share is as much a part of the run as what lies beside the scenario; where it lies is not."""
    assert run_command("init", str(tmp_path / "car"))[0] == 0
    hashes = []
    for place, width in [("shared", 10), ("shared", 12), ("elsewhere", 12)]:
        track = tmp_path / "car" / "specs" / "tracks" / "straight.yaml"
        text = track.read_text("utf-8")
        outside = tmp_path / place / "straight.yaml"
        outside.parent.mkdir(exist_ok=True)
        outside.write_text(text.replace("width: 10", f"width: {width}"), "utf-8")
        track.unlink()
        track.symlink_to(outside)
        shown = "specs/scenarios/too_fast.yaml"
        hashes.append(recorded(tmp_path / "car", tmp_path / "car" / shown, shown)[1])
    assert "" not in hashes
    assert hashes[0] != hashes[1] == hashes[2]
