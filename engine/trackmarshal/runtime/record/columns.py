"""Which columns a record has: of rows and times, of what came in by the contract, and of what was decided."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from trackmarshal.runtime.contract import EVENT, LINES, RECORD, SET, Contract, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.record.arrow import FLOAT, FLOATS, INT, TEXT, TEXTS, Column
from trackmarshal.units import is_si

FORMAT = "trackmarshal-record"
VERSION = 5
#: Of version 2, rows do not say their places; of version 3, not what cycles did not have; of version 4, an empty name of a track is none.
KNOWN = (2, 3, 4, VERSION)
ROW: Column = ("row", INT)
TIMES: tuple[Column, ...] = (
    ("number", INT),
    ("t", FLOAT),
    ("arrived", FLOAT),
    ("finished", FLOAT),
    ("missed", INT),
)
DECISION: tuple[Column, ...] = (
    ("state", TEXT), ("safe", INT), ("driven", TEXT), ("driven_number", INT), ("driven_t", FLOAT), ("lost", TEXT), ("faults", TEXT),
    ("violations", TEXT), ("verdicts.driving", TEXT), ("verdicts.emergency", TEXT), ("margins.driving", FLOATS), ("margins.emergency", FLOATS),
)  # fmt: skip
#: What an input column is: plan, column, number, ids, x, y, closed, name or event; its signal (or candidate), field, and kind.
Input = tuple[str, str, str, str]
#: What stands in a column of a kind where there is nothing to say.
_NOTHING: dict[str, Any] = {FLOATS: np.zeros(0), TEXT: "", TEXTS: (), FLOAT: math.nan, INT: -1}


def inputs_of(contract: Contract) -> list[Input]:
    """The columns of what comes in: candidates, signals, names of tracks also where no rule reads their borders, and events."""
    found: list[Input] = []
    assert contract.plan is not None
    for candidate in (DRIVING, EMERGENCY):
        found += [("plan", candidate, name, FLOATS) for name in _numbers(contract.plan)]
    for signal in contract.signals:
        if signal.form == LINES:
            found += [(axis, signal.name, line.name, FLOATS) for line in signal.lines for axis in ("x", "y")]
            found += [] if signal.lines[0].name == "" else [("closed", signal.name, "closed", INT)]
        elif signal.form == RECORD:
            found += [("number", signal.name, name, FLOAT) for name in _numbers(signal)]
        elif signal.form != EVENT:
            found += [("ids", signal.name, "id", TEXTS)] if signal.form == SET else []
            found += [("column", signal.name, name, FLOATS) for name in _numbers(signal)]
    found += [("name", signal, "name", TEXT) for signal in contract.corridors]
    return found + [("event", signal.name, "", INT) for signal in contract.signals if signal.form == EVENT]


def called(contract: Contract) -> list[tuple[str, Signal]]:
    """All that a cycle has, by what it is called there: both candidates, and the signals."""
    assert contract.plan is not None
    plans = [(name, contract.plan) for name in (DRIVING, EMERGENCY)]
    return plans + [(signal.name, signal) for signal in contract.signals]


def _numbers(signal: Signal) -> list[str]:
    return [field.name for field in signal.numbers]


def all_si(contract: Contract) -> bool:
    """Whether all fields are numbers in SI units, or borders of the road; anything else, lanes too, is kept as it came in, in `raw`."""
    assert contract.plan is not None
    fields = [(s, f) for s in (contract.plan, *contract.signals) if s.form != EVENT for f in s.fields_]
    return all(
        signal.form == LINES if field.kind == "polyline" else field.kind == "number" and is_si(field.unit)
        for signal, field in fields
    )


def columns_of(inputs: list[Input], version: int = VERSION) -> list[Column]:
    """All columns of a record of a version."""
    return [
        *([ROW] if version > 2 else []),
        *TIMES,
        ("raw", TEXT),
        *([("left_out", TEXT)] if version > 3 else []),
        *((_name(one), one[3]) for one in inputs),
        *DECISION,
    ]


def _name(one: Input) -> str:
    part, signal, field, _ = one
    return ".".join(filter(None, (signal, field, part if part in ("x", "y") else "")))


def empty(inputs: list[Input]) -> list[Any]:
    """The columns of what comes in of a row that has none of it."""
    return [_NOTHING[kind] for *_, kind in inputs]


def empty_decision() -> list[Any]:
    """The columns of a decision in a row that is no cycle."""
    return [_NOTHING[kind] for _, kind in DECISION]
