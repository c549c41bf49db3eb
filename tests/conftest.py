"""What all tests share: how generated C is compiled that they ask for, with the optimization that ships, or, every day, mostly with none."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from support.length import AT_LENGTH
from trackmarshal.backends.c import build

settings.register_profile("daily", max_examples=40)
if not AT_LENGTH:
    settings.load_profile("daily")  # of those that do not say how many they need


# Collecting imports thousands of objects that stay, and tests make thousands that their last reference ends: looking for circles among
# them as often as Python does by itself takes a twentieth of all time.
gc.set_threshold(20_000, 20, 20)


def pytest_collection_finish() -> None:
    """Thousands of tests stay to the end: whoever collects garbage need not look at them each time."""
    gc.collect()
    gc.freeze()


#: Those that hold generated C as it ships against the other evaluators: the shipped rules on cases and recordings, Supervisors on runs and
#: faults, the numeric kernel, and some of the specs that are made up.
AS_SHIPPED = (
    "acceptance/test_oracles_rss.py", "acceptance/test_recordings.py", "differential/test_c_generated.py", "differential/test_c_kernel.py",
    "differential/test_c_shipped.py", "differential/test_c_supervisor.py",
)  # fmt: skip
assert all((Path(__file__).parent / file).is_file() for file in AS_SHIPPED)

#: What takes longest in `make acceptance`, the longest first: whoever begins one of them last waits for it alone.
LONGEST = (
    "property/test_door_fuzz.py", "differential/test_c_supervisor.py", "differential/test_c_over_run.py", "differential/test_c_forgetting.py",
    "differential/test_c_supervisor_remembers.py", "differential/test_c_course.py", "differential/test_c_geometry.py",
    "differential/test_c_generated.py",
)  # fmt: skip
assert all((Path(__file__).parent / file).is_file() for file in LONGEST)
#: Tests in parts that one worker would take too long for: each part goes to whoever is free.
IN_PARTS = ("test_every_mutation_is_named_with_its_field", "test_generated_runs")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """At length the longest come first; the others stay in their order."""
    if AT_LENGTH:
        places = {str(Path(__file__).parent / file): place for place, file in enumerate(LONGEST)}
        items.sort(
            key=lambda item: (places.get(str(item.path), len(places)), not item.name.startswith(IN_PARTS))
        )


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """At length, files stay together but for tests in parts."""
    if not AT_LENGTH or config.getoption("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class LoadParts(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file, _, name = nodeid.partition("::")
            return nodeid if name.startswith(IN_PARTS) else file

    return LoadParts(config, log)


@pytest.fixture(scope="module", autouse=True)
def optimization(request: pytest.FixtureRequest) -> Iterator[None]:
    """Nothing that a test of another file compares depends on it, and without it a compiler takes a quarter of the time.

    `make acceptance` compiles all as it ships. Commands in a process of their own always do.
    """
    with pytest.MonkeyPatch.context() as patch:
        if not AT_LENGTH and not str(request.path).endswith(AS_SHIPPED):
            patch.setattr(build, "FAST", ("-O0", *build.FAST[1:]))
        yield
