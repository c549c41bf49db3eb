"""Temporal formulas through `eval --series`: every sample's robustness and verdict as independent tools computed it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from support.command import BACKENDS, evaluate, number
from support.formulas import module, series
from support.shared import oracle

Entries = dict[str, dict[str, Any]]
Result = dict[str, dict[str, Any]]


def entries(name: str) -> Entries:
    """The oracle's entries by the name of the rule that each becomes."""
    return {f"f{index}": entry for index, entry in enumerate(oracle(name)["entries"])}


def results(folder: Path, formulas: Entries, backend: str) -> Result:
    """All formulas as rules of one spec, all traces in one case: one run of the command."""
    spec = folder / "formulas.spec"
    rules = {rule: (sorted(entry["trace"]), entry["formula"]) for rule, entry in formulas.items()}
    spec.write_text(module("formulas", rules), encoding="utf-8")
    signals = {series(rule): timeline(entry["trace"]) for rule, entry in formulas.items()}
    (line,) = evaluate(folder, spec, [{"id": 0, "signals": signals}], list(formulas), backend, "--series")
    found: Result = line["rules"]
    assert list(found) == list(formulas)
    return found


def timeline(trace: dict[str, list[float]]) -> dict[str, list[float]]:
    """A trace with its samples one second apart."""
    (count,) = {len(column) for column in trace.values()}
    return {"t": [float(k) for k in range(count)], **trace}


#: By backend, how many formulas there is one of: C takes its time to compile, and has them all in `make acceptance`.
SHARES = [
    pytest.param((backend, 1), id=backend, marks=[pytest.mark.acceptance] if backend == "c" else [])
    for backend in BACKENDS
] + [pytest.param(("c", 8), id="c-some")]


@pytest.fixture(scope="module", params=SHARES)
def found(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Result:
    """What a backend makes of the formulas with a robustness."""
    backend, every = request.param
    formulas = entries("stl_dev.json")
    assert len(formulas) == 200
    chosen = dict(list(formulas.items())[::every])
    return results(tmp_path_factory.mktemp("stl"), chosen, backend)


def test_robustness(found: Result) -> None:
    """Every sample exactly, infinities too; the rule's own margin is the first sample's."""
    formulas = entries("stl_dev.json")
    wrong = {}
    for rule in found:
        entry = formulas[rule]
        wanted = [number(value) for value in entry["robustness"]]
        margins = [number(value) for value in found[rule]["series"]["margin"]]
        if margins != wanted or number(found[rule]["margin"]) != wanted[0]:
            wrong[entry["id"]] = (entry["rtamt_text"], margins, wanted)
    assert not wrong


def test_sign_of_robustness(found: Result) -> None:
    """Where the robustness is not zero, its sign is the verdict of the sample.

    Not for `iff` and `xor`: their robustness measures how different two margins are, not two verdicts.
    """
    formulas = {
        r: e for r, e in entries("stl_dev.json").items() if r in found and not {"iff", "xor"} & set(e["ops"])
    }
    decided = 0
    for rule, entry in formulas.items():
        for verdict, value in zip(found[rule]["series"]["verdict"], entry["robustness"], strict=True):
            if number(value) != 0.0:
                assert verdict == ("satisfied" if number(value) > 0.0 else "violated"), entry["rtamt_text"]
                decided += 1
    assert decided > 5 * len(found)


@pytest.mark.parametrize("backend", BACKENDS)
def test_verdicts(backend: str, tmp_path: Path) -> None:
    """Every Boolean verdict that R2U2 gave."""
    formulas = entries("mltl_r2u2_vectors.json")
    assert len(formulas) == 32
    found = results(tmp_path, formulas, backend)
    wrong = {}
    for rule, entry in formulas.items():
        wanted = ["satisfied" if holds else "violated" for holds in entry["verdicts"]]
        verdicts = found[rule]["series"]["verdict"][: len(wanted)]
        if verdicts != wanted or found[rule]["verdict"] != wanted[0]:
            wrong[entry["id"]] = (entry["text"], verdicts, wanted)
    assert not wrong
