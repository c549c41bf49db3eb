"""What all tests share: how generated C is compiled that they ask for, with the optimization that ships, or, every day, mostly with none."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from support.length import AT_LENGTH
from support.once import compiled_once, drawn_once, generated_once
from trackmarshal.backends.c import build, report
from trackmarshal.cli import drawing
from trackmarshal.scenarios.generate import run as generating
from trackmarshal.semantics.compile import _Compiler

# How long one example takes says how busy the machine is, and nothing of what is tested.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
settings.register_profile("daily", max_examples=12)
if not AT_LENGTH:
    settings.load_profile("daily")  # of those that do not say how many they need
    _Compiler.run = compiled_once(_Compiler.run)  # type: ignore[method-assign]
    generating.run = generated_once(generating.run)
    drawing.drawings = drawn_once(drawing.drawings)


# Collecting imports thousands of objects that stay, and tests make thousands that their last reference ends: looking for circles among
# them as often as Python does by itself takes a twentieth of all time.
gc.set_threshold(20_000, 20, 20)


def pytest_collection_finish() -> None:
    """Thousands of tests stay to the end: whoever collects garbage need not look at them each time."""
    gc.collect()
    gc.freeze()


def pytest_sessionfinish() -> None:
    """Five times pytest looks for what was never closed: among what came since the last look, not among all that tests hold to the end."""
    gc.collect()
    gc.freeze()


#: Those that hold generated C as it ships against the other evaluators: the shipped rules on cases and recordings, and the numeric kernel.
#: The whole Supervisor as it ships is that of the emitted example, and of whatever is a command.
AS_SHIPPED = (
    "acceptance/test_oracles_rss.py", "acceptance/test_recordings.py", "differential/test_c_kernel.py",
    "differential/test_c_shipped.py",
)  # fmt: skip
ASKS_FOR_STACK = "unit/test_c_files.py"
assert all((Path(__file__).parent / file).is_file() for file in (*AS_SHIPPED, ASKS_FOR_STACK))

#: The files that take longest in `make acceptance`, the longest first: whoever begins one of them last waits for it alone. Each of their
#: tests goes to whoever is free.
LONGEST = (
    "differential/test_c_supervisor.py", "differential/test_c_generated.py", "property/test_door_fuzz.py", "differential/test_c_over_run.py",
    "differential/test_c_forgetting.py", "differential/test_c_supervisor_remembers.py", "differential/test_evaluators.py",
    "acceptance/test_gate.py", "acceptance/test_oracles_interstate.py", "property/test_types_fuzz.py", "differential/test_c_course.py", "differential/test_c_geometry.py",
    "differential/test_c_door.py", "acceptance/test_planner_rules.py", "acceptance/test_planner_limits.py", "property/test_forgetting.py",
    "property/test_process_fuzz.py", "acceptance/test_planner_takeup.py",
)  # fmt: skip
assert all((Path(__file__).parent / file).is_file() for file in LONGEST)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """At length the longest come first; the others stay in their order."""
    if AT_LENGTH:
        places = {str(Path(__file__).parent / file): place for place, file in enumerate(LONGEST)}
        items.sort(key=lambda item: places.get(str(item.path), len(places)))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """At length files stay together, but for the longest."""
    if not AT_LENGTH or config.getoption("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class LoadLongest(LoadFileScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return nodeid if file.endswith(LONGEST) else file

    return LoadLongest(config, log)


@pytest.fixture(scope="module", autouse=True)
def optimization(request: pytest.FixtureRequest) -> Iterator[None]:
    """Nothing that a test of another file compares depends on it, and without it a compiler takes a quarter of the time.

    `make acceptance` compiles all as it ships. Commands in a process of their own always do.

    How much stack is taken is asked in the tests of the report alone: for that, gcc compiles each program once more, and optimizes it.
    """
    with pytest.MonkeyPatch.context() as patch:
        if not AT_LENGTH and not str(request.path).endswith(ASKS_FOR_STACK):
            patch.setattr(report, "stack", lambda source: None)
        if not AT_LENGTH and not str(request.path).endswith(AS_SHIPPED):
            patch.setattr(build, "FAST", ("-O0", *build.FAST[1:]))
        yield
