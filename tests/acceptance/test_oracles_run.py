"""Temporal formulas cycle by cycle over a run: in every cycle the robustness and the verdict that independent tools computed along a timeline."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from support.command import number
from support.formulas import spell
from support.length import amount
from support.shared import oracle
from trackmarshal.cli.main import main
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.record.reading import Run, read
from trackmarshal.runtime.verdict import About
from trackmarshal.supervision import box_of, nearest, rerun, supervisor

#: Cycles are one second apart, as the oracles' samples are.
ENGINES = ("reference", "numpy")
Entry = dict[str, Any]
#: The most cycles of a trace, and more than any formula looks ahead.
LONGEST, REACH = amount(150, 300), 20


def spec_of(entry: Entry) -> str:
    fields = ", ".join(f"{name}: 1" for name in sorted(entry["trace"]))
    return f'module m\nsignal s : state {{ {fields} }}\nrule f "an oracle formula"\n  require {spell(entry["formula"])}\n'


def cycle(entry: Entry, k: int) -> Entry:
    return {
        "id": k,
        "t": float(k),
        "signals": {"s": {name: column[k] for name, column in entry["trace"].items()}},
    }


def over_run(entry: Entry, engine: str) -> list[list[About]]:
    """By cycle, everything that was said about it: of what is open, of a verdict that was decided, of a margin that became final."""
    evaluator = Evaluator(loads(spec_of(entry)), backend=engine)
    count = len(next(iter(entry["trace"].values())))
    run, said = evaluator.over_run(), [list[About]() for _ in range(count)]
    for k in range(count):
        result = run.step(evaluator.read(cycle(entry, k))).rules["f"]
        for one in result.about or (About(k, result.verdict, result.margin, True),):
            said[one.cycle].append(one)  # type: ignore[call-overload]
    for one in run.end().get("f", ()):
        said[one.cycle].append(one)  # type: ignore[call-overload]
    return said


def bounded(entry: Entry) -> bool:
    """Whether a formula has a meaning over a run: what looks ahead has a bound. Anything else that is wrong with it is raised."""
    try:
        loads(spec_of(entry))
    except TrackmarshalError as error:
        assert "is never decided over the run" in str(error), entry["rtamt_text"]
        return False
    return True


@pytest.mark.parametrize(
    ("engine", "every"),
    [("reference", 10), ("numpy", 8), ("c", 30)]
    + [pytest.param(engine, 1, marks=pytest.mark.acceptance) for engine in (*ENGINES, "c")],
)
def test_robustness(engine: str, every: int) -> None:
    entries = [entry for entry in oracle("stl_dev.json")["entries"][::every] if bounded(entry)]
    assert len(entries) >= 172 // every - 5
    for entry in entries:
        said = over_run(entry, engine)
        finals = [[one for one in each if one.final] for each in said]
        assert [len(each) for each in finals] == [1] * len(said), entry["rtamt_text"]
        wanted = [number(value) for value in entry["robustness"]]
        assert [each[0].margin for each in finals] == wanted, entry["rtamt_text"]
        for each in said:
            verdicts = [one.verdict for one in each if one.verdict != "open"]
            assert len(set(verdicts)) == 1, f"a verdict that was decided changed: {entry['rtamt_text']}"
            if wanted[each[0].cycle] != 0.0 and not {"iff", "xor"} & set(entry["ops"]):  # type: ignore[call-overload]
                assert verdicts[0] == ("satisfied" if wanted[each[0].cycle] > 0.0 else "violated")  # type: ignore[call-overload]
            # A margin that was said before it was final says no more than what is sure.
            for early in each[:-1]:
                if early.verdict == "satisfied":
                    assert early.margin <= each[-1].margin
                elif early.verdict == "violated":
                    assert early.margin >= each[-1].margin


@pytest.mark.parametrize("engine", ENGINES)
def test_verdicts(engine: str) -> None:
    """Every Boolean verdict that R2U2 gave."""
    entries = [entry for entry in oracle("mltl_r2u2_vectors.json")["entries"] if bounded(entry)]
    assert len(entries) >= 25
    for whole in entries:
        # A few traces are 10,000 cycles long: their beginnings will do.
        entry = {**whole, "trace": {name: column[:LONGEST] for name, column in whole["trace"].items()}}
        said = over_run(entry, engine)
        for k, holds in enumerate(entry["verdicts"][: LONGEST - REACH]):
            assert said[k][-1].verdict == ("satisfied" if holds else "violated"), (entry["text"], k)


@pytest.mark.parametrize("every", [12, pytest.param(1, marks=pytest.mark.acceptance)])
def test_generated_c(every: int) -> None:
    """Of the formulas that look back alone, what generated C says in each cycle."""
    entries = [entry for entry in oracle("stl_dev.json")["entries"] if entry["past_only"]][::every]
    assert len(entries) >= 60 // every
    for entry in entries:
        said = over_run(entry, "c")
        wanted = [number(value) for value in entry["robustness"]]
        assert [[one.margin for one in each] for each in said] == [[value] for value in wanted], entry[
            "rtamt_text"
        ]


SUPERVISED = """signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad }
"""
STANDS: Entry = {"t": [0.0, 9.0], **{name: [0.0, 0.0] for name in ("x", "y", "heading", "v")}}


def recorded(entry: Entry, backend: str, path: Path) -> tuple[Run, Spec]:
    """A run of a Supervisor, with the oracle's signals beside a car that stands: its record, with a snapshot every few cycles."""
    spec = loads(spec_of(entry).replace("module m\n", f"module m\n{SUPERVISED}"))
    now = 0.0
    limits = dict.fromkeys(("longest_gap", "oldest", "budget", "blind"), 1e9)
    made = supervisor(spec, None, backend, limits, lambda: now, path, snapshots=5)
    count = len(next(iter(entry["trace"].values())))
    for k in range(count):
        now = float(k)
        signals = {**cycle(entry, k)["signals"], "ego": {"x": 0.0, "y": 0.0, "heading": 0.0}}
        assert not made.step(Cycle(k, now, STANDS, STANDS, signals)).faults
    made.close()
    assert made.record_error == ""
    return read(path.read_bytes(), str(path)), spec


@pytest.mark.parametrize(
    ("backend", "every"),
    [("numpy", 12), ("reference", 20), ("c", 30)]
    + [pytest.param(backend, 1, marks=pytest.mark.acceptance) for backend in (*ENGINES, "c")],
)
def test_from_the_middle_of_a_record(backend: str, every: int, tmp_path: Path) -> None:
    """A replay that starts at a snapshot says in each cycle from there on what the oracle says; of the reference, one from the beginning."""
    entries = [entry for entry in oracle("stl_dev.json")["entries"] if entry["past_only"]][::every]
    assert len(entries) >= 60 // every
    for place, entry in enumerate(entries):
        run, spec = recorded(entry, backend, tmp_path / f"{place}.arrows")
        wanted = [number(value) for value in entry["robustness"]]
        box = box_of(run, spec)
        middle = len(wanted) // 2
        begin, _ = nearest(run, box, middle)
        assert (begin is None) == (
            backend == "reference" or not run.snapshots or run.snapshots[0].after > middle
        )
        first = 0 if begin is None else begin.after
        assert first > 0 or backend == "reference" or middle < 5
        margins = []
        for decision, differing in rerun(run, box, begin):
            assert not differing
            assert decision.judged is not None
            margins.append([float(rated.margins[0]) for rated in decision.judged.rated.values()])
        assert margins == [[value, value] for value in wanted[first:]], entry["rtamt_text"]


def test_what_looks_back_is_known_at_once() -> None:
    """Of the formulas that look back alone, every cycle says its own robustness, and nothing more is said of it later."""
    entries = [entry for entry in oracle("stl_dev.json")["entries"] if entry["past_only"]]
    assert len(entries) >= 60
    for entry in entries[::6]:
        for each in over_run(entry, "numpy"):
            assert [one.final for one in each] == [True], entry["rtamt_text"]


@pytest.mark.parametrize("engine", ENGINES)
def test_the_command(engine: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entry = next(
        e for e in oracle("stl_dev.json")["entries"] if {"until", "since"} <= set(e["ops"]) and bounded(e)
    )
    spec, data = tmp_path / "m.spec", tmp_path / "run.jsonl"
    spec.write_text(spec_of(entry), encoding="utf-8")
    count = len(next(iter(entry["trace"].values())))
    data.write_text("".join(json.dumps(cycle(entry, k)) + "\n" for k in range(count)), encoding="utf-8")
    command = ["eval", str(spec), "--data", str(data), "--backend", engine, "--format", "jsonl"]
    assert main([*command, "--exit-zero"]) == 2
    assert "E407" in capsys.readouterr().err
    assert main([*command, "--run", "--exit-zero"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    finals = {}
    for line in lines:
        for one in line["rules"]["f"]["about"] if "rules" in line else line["end"]["f"]:
            if one["final"]:
                finals[one["cycle"]] = number(one["margin"])
    assert [finals[k] for k in range(count)] == [number(value) for value in entry["robustness"]]
