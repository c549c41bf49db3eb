"""Whether a cycle keeps the contract of `support.typed`: read off docs/supervisor.md and the spec by hand, without any of the door's code.

Slow and plain: every value is looked at by itself. The answer is yes or no; what a breach is called is for other tests.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.lines import Line


class BreachError(Exception):
    """The contract is broken."""


def demand(holds: object) -> None:
    if not holds:
        raise BreachError


def number(value: Any) -> float:
    """A finite number."""
    demand(not issubclass(type(value), bool | np.bool_ | np.ma.core.MaskedConstant))
    if issubclass(type(value), np.generic) or type(value) is np.ndarray:
        demand(np.shape(value) == () and value.dtype.kind in "iuf")
        found = float(np.asarray(value).astype(np.float64))
    elif issubclass(type(value), float):
        found = float.fromhex(float.hex(value))
    elif issubclass(type(value), int):
        try:
            found = float(int.__add__(value, 0))
        except OverflowError:
            raise BreachError from None
    else:
        raise BreachError
    demand(math.isfinite(found))
    return found


def truth(value: Any) -> bool:
    if type(value) is np.ndarray:
        demand(value.shape == () and value.dtype == np.bool_)
        return bool(value[()])
    demand(value is True or value is False or type(value) is np.bool_)
    return bool(value)


def many(column: Any, one: Callable[[Any], Any], kinds: str) -> list[Any]:
    """The entries of a column, each as it has to be; kinds: of arrays that are taken."""
    if type(column) in (np.ndarray, np.memmap, np.ma.MaskedArray):
        demand(column.ndim == 1)
        hidden = type(column) is np.ma.MaskedArray
        if hidden:
            demand(not np.ma.getmaskarray(column).any())
        nobody = column.dtype.kind in "iuf" and len(column) == 0  # as numpy makes it of an empty list
        demand(column.dtype.kind in kinds or nobody or (column.dtype.kind == "O" and not hidden))
        return [one(np.ma.getdata(column)[i]) for i in range(len(column))]
    return [one(value) for value in stored(column)]


def stored(column: Any) -> list[Any]:
    """The entries of a list or tuple, whatever a derived class says of itself."""
    demand(issubclass(type(column), list | tuple))
    kind: Any = list if isinstance(column, list) else tuple
    return [kind.__getitem__(column, i) for i in range(kind.__len__(column))]


def numbers(column: Any) -> list[float]:
    return many(column, number, "iuf")


def name(value: Any) -> str:
    """An id."""
    if issubclass(type(value), str):
        return "".join(str.__getitem__(value, i) for i in range(str.__len__(value)))
    real = number(value)
    demand(type(value) is not np.ndarray)
    if issubclass(type(value), int | np.integer):
        whole = int.__add__(value, 0) if issubclass(type(value), int) else int(value)
        demand(-(2**63) <= whole < 2**63)
        return int.__repr__(whole)
    return float.__repr__(real)


def fields(given: Any, needed: set[str], others: set[str] = frozenset()) -> dict[str, Any]:  # type: ignore[assignment]
    """What a Mapping holds: all of these fields, and of others only those."""
    demand(issubclass(type(given), Mapping))
    found = {key: given[key] for key in given}
    demand(all(issubclass(type(key), str) for key in found))
    demand(needed <= found.keys() <= needed | others)
    return found


def within(values: list[float], low: float, high: float) -> None:
    demand(all(low <= value <= high for value in values))


def plan(given: Any, flags: bool) -> dict[str, list[float]]:
    held = fields(given, {"t", "x", "y", "heading", "v"} | ({"ready"} if flags else set()), {"grip"})
    ready = many(held.pop("ready"), truth, "b") if flags else numbers(held["t"])
    found = {key: numbers(column) for key, column in held.items()}
    demand(len({len(column) for column in (*found.values(), ready)}) == 1)
    demand(2 <= len(ready) <= 8)
    within(found["t"], 0.0, 100.0)
    within(found["v"], -10.0, 150.0)
    within(found.get("grip", []), 0.0, 150.0)
    demand(all(a < b for a, b in zip(found["t"], found["t"][1:])))
    return found


def elements(given: Any, flags: bool) -> None:
    needed, others = {"x", "w"} | ({"seen"} if flags else set()), {"id", "age"}
    if issubclass(type(given), list | tuple):
        records = [fields(one, needed, others) for one in stored(given)]
        demand(len(records) <= 4)
        names = []
        for index, one in enumerate(records):
            number(one["x"])
            within([number(one["w"])], -180.0, 180.0)
            within([number(one.get("age", 0.0))], 0.0, 10.0)
            truth(one.get("seen", True))
            names.append(str(index) if one.get("id") is None else name(one["id"]))
        demand(len(set(names)) == len(names))
        return
    held = fields(given, needed, others)
    lengths = {len(numbers(held["x"])), len(numbers(held["w"]))}
    if flags:
        lengths.add(len(many(held["seen"], truth, "b")))
    within(numbers(held["w"]), -180.0, 180.0)
    if "age" in held:
        lengths.add(len(numbers(held["age"])))
        within(numbers(held["age"]), 0.0, 10.0)
    if held.get("id") is not None:
        demand(type(held["id"]) not in (np.memmap, np.ma.MaskedArray))
        ids = many(held["id"], name, "iufU")
        lengths.add(len(ids))
        demand(len(set(ids)) == len(ids))
    demand(len(lengths) == 1 and lengths.pop() <= 4)


def line(given: Any) -> None:
    if type(given) is Line:
        points = [list(pair) for pair in given.points]
    elif type(given) in (np.ndarray, np.memmap, np.ma.MaskedArray) and given.dtype.kind != "O":
        demand(given.ndim == 2 and given.shape[1] == 2 and given.dtype.kind in "iuf")
        demand(not np.ma.getmaskarray(given).any())
        points = [[given[i, 0], given[i, 1]] for i in range(len(given))]
    else:
        rows = given.tolist() if type(given) is np.ndarray else given
        points = [numbers(row) for row in stored(rows)]
    demand(2 <= len(points) <= 8)
    for pair in points:
        demand(len(pair) == 2)
        number(pair[0])
        number(pair[1])


@dataclass
class Plain:
    """Number and stamp of the last cycle whose stamp was in order."""

    number: int | None = None
    t: float | None = None
    flags: bool = True
    shortest: float = 0.001
    ahead: float = 0.5

    def kept(self, cycle: Any, now: float) -> bool:
        """Whether a cycle keeps the contract; remembers its number and stamp."""
        if not isinstance(cycle, Cycle):
            return False
        fine = self._in_order(cycle, now)
        try:
            _shape(cycle, self.flags)
        except Exception:  # what fails to be read cannot be right
            fine = False
        return fine

    def _in_order(self, cycle: Cycle, now: float) -> bool:
        whole: int | None = None
        value = cycle.number
        if type(value) is np.ndarray and value.shape == () and value.dtype.kind in "iu":
            value = value[()]
        if issubclass(type(value), np.generic):
            whole = int(value) if value.dtype.kind in "iu" else None
        elif issubclass(type(value), int) and not issubclass(type(value), bool):
            whole = int.__add__(value, 0)
        if whole is not None and not -(2**63) < whole < 2**63:
            whole = None
        fine = whole is not None and (self.number is None or whole == self.number + 1)
        try:
            t = number(cycle.t)
        except Exception:
            return False
        if (self.t is not None and not t - self.t > self.shortest) or t - now > self.ahead:
            return False
        self.t = t
        if whole is not None:
            self.number = whole
        return fine


def _shape(cycle: Cycle, flags: bool) -> None:
    driving, emergency = plan(cycle.driving, flags), plan(cycle.emergency, flags)
    held = fields(cycle.signals, {"ego", "car", "objects", "track", "border", "wet"})
    ego = fields(held["ego"], {"x", "y", "heading"}, {"age"})
    within([number(ego.pop("age", 0.0))], 0.0, 1.0)
    for value in ego.values():
        number(value)
    car = fields(held["car"], {"gap", "on"} if flags else {"gap"}, {"load"})
    within([number(car["gap"])], 0.0, 500.0)
    number(car.get("load", 0.0))
    truth(car.get("on", True))
    elements(held["objects"], flags)
    track = fields(held["track"], {"left", "right"}, {"closed"})
    truth(track.get("closed", False))
    line(track["left"])
    line(track["right"])
    line(held["border"])
    truth(held["wet"])
    first = {key: driving[key][0] - emergency[key][0] for key in ("x", "y", "heading", "v")}
    demand(math.hypot(first["x"], first["y"]) <= 0.1)
    turn = math.fmod(abs(first["heading"]), math.tau)
    demand(min(turn, math.tau - turn) <= 0.05)
    demand(abs(first["v"]) <= 0.5)
    demand(abs(emergency["v"][-1]) <= 0.01)
