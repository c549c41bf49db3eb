"""The emitted Supervisor on a Cortex-M7 (Arm's board MPS2+ with image AN500, emulated) decides what it decides here, bit for bit.

`make embedded` installs what this takes. The figures go to out/embedded; docs/embedded.md shows them.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import trackmarshal as tm
from support import embedded
from support.cycles import BRAKING, PERIOD, cycle, plan
from support.embedded import Difference, Ran
from support.emitted import SCENARIOS, emit, name_of
from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal.backends.c.calls import inexact
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.c.supervised.contract import unfit
from trackmarshal.evaluation import Evaluator, load

pytestmark = pytest.mark.acceptance
OUT = REPOSITORY / "out" / "embedded"
NORTHFIELD = REPOSITORY / "specs" / "tracks" / "northfield.spec"
DOCUMENT = REPOSITORY / "docs" / "embedded.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    missing = embedded.missing_tools()
    assert not missing, (
        f"{', '.join(missing)} not found: `make embedded` installs the packages, or says which"
    )
    made = tmp_path_factory.mktemp("embedded")
    record_full_load(made / "full_load.arrows")
    return emit(made, recordings=[*SCENARIOS, made / "full_load.arrows"])


@pytest.fixture(scope="module")
def source() -> Source:
    spec = load([SUPERVISOR], [NORTHFIELD], REPOSITORY)
    assert not unfit(spec)
    return generate(spec, Evaluator(spec, None, "reference").rules, doored=True)


@pytest.fixture(scope="module")
def runs(folder: Path) -> dict[str, tuple[Ran, Ran]]:
    """Every shipped scenario, here and on the board."""
    here, there = embedded.build(folder), embedded.cross_build(folder)
    found = {}
    for path in SCENARIOS:
        cycles = folder / f"{name_of(path)}.cycles"
        found[cycles.stem] = embedded.run(here, cycles), embedded.emulate(there, cycles)
    return found


@pytest.fixture(scope="module")
def full(folder: Path, runs: dict[str, tuple[Ran, Ran]]) -> tuple[Ran, Ran]:
    """A run with as much of everything as there is room for; every eighth cycle brings new borders."""
    assert runs
    cycles = folder / "full_load.cycles"
    return embedded.run(folder / "example", cycles), embedded.emulate(folder / "target.elf", cycles)


def record_full_load(path: Path) -> None:
    limits = tm.Limits(budget=1e9)
    now = 0.0
    spec = tm.load([SUPERVISOR], [NORTHFIELD], REPOSITORY)
    supervisor = tm.supervisor(spec, limits=limits, clock=lambda: now, record=path)
    x = np.linspace(-50.0, 2400.0, limits.border)
    for number in range(24):
        given = cycle(number, limits.elements, limits.elements)
        at = float(given.signals["ego"]["x"])
        given.driving.update(plan(at, 0.0, limits.samples))
        given.emergency.update(plan(at, BRAKING, limits.samples))
        for side, sign in (("left", 1.0), ("right", -1.0)):
            y = sign * (6.5 + 0.5 * np.sin(x / 50.0 + number // 8))
            given.signals["track"][side] = np.stack([x, y], axis=1)
        now = number * PERIOD
        assert supervisor.step(given).faults == ()
    supervisor.close()


def names(source: Source) -> list[str]:
    return [code.rule.name for code in source.rules]


def different(source: Source, runs: dict[str, tuple[Ran, Ran]]) -> list[Difference]:
    return [d for here, there in runs.values() for d in embedded.differences(here, there, names(source))]


@pytest.mark.verifies("S-1-B-1")
def test_a_full_load_is_decided_the_same(source: Source, full: tuple[Ran, Ran]) -> None:
    here, there = full
    assert sum(line.startswith("driving ") for line in here.lines) == len(there.instructions) == 24
    assert {d.rule for d in embedded.differences(here, there, names(source))} <= inexact(source).keys()


@pytest.mark.verifies("S-1-B-1")
@pytest.mark.parametrize("name", [name_of(path) for path in SCENARIOS])
def test_decisions_verdicts_and_exact_margins_are_the_same(
    name: str, source: Source, runs: dict[str, tuple[Ran, Ran]]
) -> None:
    here, there = runs[name]
    cycles = sum(line.startswith("decision ") for line in here.lines)
    assert cycles == len(there.instructions) > 90
    assert sum(line.startswith("driving ") for line in here.lines) == cycles
    found = list(embedded.differences(here, there, names(source)))
    assert {d.rule for d in found} <= inexact(source).keys(), found[:5]


def test_few_margins_differ_and_by_little(source: Source, runs: dict[str, tuple[Ran, Ran]]) -> None:
    """Of the rules that call sin, cos and their like: how many, and in which digits."""
    for difference in different(source, runs):
        x, y = (embedded.double(bits) for bits in (difference.here, difference.there))
        assert x == pytest.approx(y, rel=1e-9, abs=1e-9), difference


def test_what_may_differ_is_listed(source: Source) -> None:
    """The document names every rule of this kind with its functions, and no other."""
    text = DOCUMENT.read_text(encoding="utf-8")
    for name in names(source):
        functions = inexact(source).get(name)
        row = "" if functions is None else f"| {name} | {', '.join(functions)} |"
        rows = [line for line in text.splitlines() if line.startswith(f"| {name} |")]
        assert len(rows) == (functions is not None), name
        assert all(line.startswith(row) for line in rows), (rows, row)


def test_a_contracted_program_would_be_found_out(folder: Path, source: Source) -> None:
    """With fused multiplication and addition, which the processor has, margins differ that may not. The source forbids it, whatever flags say, and
    a program in which they are fused all the same tries that out, and does not begin."""
    cycles = folder / "overreach.cycles"
    here = embedded.run(folder / "example", cycles)
    text = (folder / "supervisor.c").read_text()
    forbidden, tried = '#pragma GCC optimize("fp-contract=off")', "- square) == 0.0"
    assert forbidden in text
    assert tried in text
    fused = text.replace(forbidden, "")
    (folder / "fused.c").write_text(fused)
    (folder / "untried.c").write_text(fused.replace(tried, "- square) <= 1.0"))
    for name, differ in (("supervisor", False), ("untried", True)):
        image = embedded.cross_build(folder, name, ("-ffp-contract=fast",), f"contracted-{name}")
        found = {d.rule for d in embedded.differences(here, embedded.emulate(image, cycles), names(source))}
        assert bool(found - inexact(source).keys()) == differ
    image = embedded.cross_build(folder, "fused", ("-ffp-contract=fast",), "contracted-fused")
    with pytest.raises(AssertionError, match="the compiler's flags make other arithmetic"):
        embedded.emulate(image, cycles)


def test_figures(
    folder: Path, source: Source, runs: dict[str, tuple[Ran, Ran]], full: tuple[Ran, Ran]
) -> None:
    """What a step costs, written down; nothing is demanded of it here."""
    found = [d for d in different(source, runs) if not d.of_reason]
    margins = 2 * sum(line.startswith("decision ") for here, _ in runs.values() for line in here.lines)
    rules = {
        name: {
            "functions": functions,
            "margins_that_differ": sum(d.rule == name for d in found),
            "of": margins,
            "largest_difference": max((d.size for d in found if d.rule == name), default=0.0),
        }
        for name, functions in inexact(source).items()
    }
    there = [there for _, there in runs.values()]
    figures = {
        "board": "mps2-an500 (Cortex-M7), emulated",
        "bytes": embedded.sizes(folder, folder / "target.elf", source),
        "stack": max(n for one in (*there, full[1]) for n in one.stack),
        "instructions": {
            "scenarios": embedded.instructions(there),
            "full_load": embedded.instructions([full[1]]),
        },
        "rules": rules,
    }
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "figures.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
