"""What the state machine keeps as pieces of plain data: its state, and the stored emergency trajectory to the bit."""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Iterator
from typing import Any

import numpy as np

from trackmarshal.runtime.cycle import EMERGENCY
from trackmarshal.runtime.frame import Columns, Names
from trackmarshal.runtime.machine import STATES, Held
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.saving import Piece, Pieces, checked, count, spelt, unspelt


def held_pieces(held: Held) -> Iterator[Piece]:
    """What is held after a step. Nothing of it changes: its pieces are made when they are asked for."""
    stored = held.stored
    yield ["held", held.state, spelt(held.confirmed), held.about, stored is not None]
    yield from plan_pieces(stored)


def held_of(pieces: Pieces) -> Held:
    """It again; raises ValueError, or what else comes of data that nobody saved."""
    state, confirmed, about, stored = pieces.next("held", 4)
    if state not in STATES or type(about) is not int:
        raise ValueError("no state of a Supervisor")
    plan = plan_of(pieces) if checked(stored, bool) else None
    return Held(state, plan, unspelt(confirmed), about)


def plan_pieces(plan: Plan | None) -> Iterator[Piece]:
    """A stored trajectory; nothing where there is none. What is made of it is made later: a plan does not change."""
    if plan is None:
        return
    columns = plan.columns
    names = columns.names
    numbers = _coded(columns.values, "<f8")
    flags = "" if columns.flags is None else _coded(columns.flags, "<i1")
    yield [
        "plan", plan.candidate, plan.number, spelt(plan.t), columns.count, list(names.numbers), list(names.flags), sorted(columns.absent),
        numbers, flags,
    ]  # fmt: skip


def plan_of(pieces: Pieces) -> Plan:
    """A trajectory that was stored; raises ValueError, or what else comes of data that nobody saved."""
    candidate, number, t, many, numbers, flags, absent, values, bits = pieces.next("plan", 9)
    if candidate != EMERGENCY or type(number) is not int or count(many) < 2:
        raise ValueError("no stored trajectory")
    names = Names(_words(numbers), _words(flags))
    if not {"t", "x", "y", "heading", "v"} <= set(names.numbers):
        raise ValueError("a trajectory without its columns")
    columns = Columns(
        names,
        _decoded(values, "<f8", (len(names.numbers), many)).astype(np.float64),
        None if bits == "" else _decoded(bits, "<i1", (len(names.flags), many)).astype(np.int8),
    )
    columns.absent = frozenset(_words(absent))
    columns.values.setflags(write=False)
    return Plan(candidate, number, unspelt(t), columns)


def _words(given: Any) -> list[str]:
    return [checked(each, str) for each in checked(given, list)]


def _coded(values: Any, kind: str) -> str:
    return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def _decoded(text: str, kind: str, shape: tuple[int, int]) -> Any:
    return np.frombuffer(b64decode(text, validate=True), dtype=kind).reshape(shape)
