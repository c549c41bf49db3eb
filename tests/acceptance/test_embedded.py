"""The emitted Supervisor on a Cortex-M7 (Arm's board MPS2+ with image AN500, emulated) decides what it decides here, bit for bit.

`make embedded` installs what this takes. The figures go to out/embedded; docs/generated-c.md shows them.
"""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

from support import embedded
from support.embedded import Difference, Ran
from support.emitted import SCENARIOS, emit, name_of
from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal.backends.c.calls import EXACT, libm
from trackmarshal.backends.c.contract import can_be_supervised
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.evaluation import Evaluator, load

pytestmark = pytest.mark.acceptance
OUT = REPOSITORY / "out" / "embedded"
NORTHFIELD = REPOSITORY / "specs" / "tracks" / "northfield.spec"
DOCUMENT = REPOSITORY / "docs" / "generated-c.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    missing = embedded.missing_tools()
    assert not missing, (
        f"{', '.join(missing)} not found: `make embedded` installs the packages, or says which"
    )
    return emit(tmp_path_factory.mktemp("embedded"))


@pytest.fixture(scope="module")
def source() -> Source:
    spec = load([SUPERVISOR], [NORTHFIELD], REPOSITORY)
    assert can_be_supervised(spec)
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


def names(source: Source) -> list[str]:
    return [code.rule.name for code in source.rules]


def inexact(source: Source) -> dict[str, list[str]]:
    """Rules that call what each C library computes in its own way, and what it is."""
    found = {code.rule.name: sorted(set(libm(source, code)) - EXACT) for code in source.rules}
    return {name: functions for name, functions in found.items() if functions}


def different(source: Source, runs: dict[str, tuple[Ran, Ran]]) -> list[Difference]:
    return [d for here, there in runs.values() for d in embedded.differences(here, there, names(source))]


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
    """With fused multiplication and addition, which the processor has, margins differ that may not."""
    image = embedded.cross_build(folder, more=("-ffp-contract=fast",), out="contracted")
    cycles = folder / "overreach.cycles"
    here, there = embedded.run(folder / "example", cycles), embedded.emulate(image, cycles)
    found = {d.rule for d in embedded.differences(here, there, names(source))}
    assert found - inexact(source).keys()


def test_figures(folder: Path, source: Source, runs: dict[str, tuple[Ran, Ran]]) -> None:
    """What a step costs, written down; nothing is demanded of it here."""
    found = different(source, runs)
    margins = 2 * sum(line.startswith("decision ") for here, _ in runs.values() for line in here.lines)
    rules = {
        name: {
            "functions": functions,
            "margins_that_differ": (count := Counter(d.rule for d in found if not d.of_reason)[name]),
            "of": margins,
            "largest_difference": max((d.size for d in found if d.rule == name), default=0.0)
            if count
            else 0.0,
        }
        for name, functions in inexact(source).items()
    }
    figures = embedded.figures(folder, folder / "target.elf", [there for _, there in runs.values()])
    OUT.mkdir(parents=True, exist_ok=True)
    whole = {"board": "mps2-an500 (Cortex-M7), emulated", "figures": figures, "rules": rules}
    (OUT / "figures.json").write_text(json.dumps(whole, indent=2) + "\n", encoding="utf-8")
    assert figures["steps"] == sum(len(there.instructions) for _, there in runs.values())
    assert figures["instructions_most"] >= figures["instructions_median"] > 10_000
