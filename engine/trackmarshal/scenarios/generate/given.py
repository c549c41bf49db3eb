"""What a declaration says of signals and of fields of cars: constants, tables over time, expressions in the spec language."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackmarshal.scenarios.generate.document import Item
from trackmarshal.units import moment

_TIME = re.compile(r"(\d+(?:\.\d+)?) s")
_HOW = "one of `value`, `at` (`{0 s: .., 12 s: ..}`), `is` (an expression) and, of an archive, `column`"
#: Times of cycles are whole nanoseconds.
_SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class Member:
    """A member of an enumeration, where a formula holds; "" wherever none does that stands above it."""

    name: str
    formula: str
    item: Item


@dataclass(frozen=True, slots=True)
class Given:
    """One value in every cycle: a table with the time [s] from which each row holds, an expression, members of an enumeration with the
    formula of each, or a column of an archive."""

    name: str
    item: Item
    times: tuple[float, ...] = ()
    values: tuple[Any, ...] = ()
    expression: str = ""
    members: tuple[Member, ...] = ()
    column: str = ""

    @property
    def constant(self) -> bool:
        """Whether it is the same in all cycles, and known to be."""
        return len(self.times) == 1

    def at(self, t: float) -> Any:
        """The value at a time [s] of the recording, of a table."""
        return self.values[self._row(t)]

    def _row(self, t: float) -> int:
        return max(0, bisect_right(self.times, t + _SLACK) - 1)

    def over(self, times: Sequence[float]) -> list[Any]:
        """The value at each time [s], of a table; raises D251 where a row holds at none of them: what it declares would never be."""
        idle = set(range(len(self.times))) - {self._row(t) for t in times}
        if idle:
            row = min(idle)
            message = f"no cycle has the value from {moment(self.times[row])} s on"
            what = (
                "move the row, or leave it out" if row else "the first row is what holds in the first cycle"
            )
            help_ = f"cycles are from {moment(times[0])} to {moment(times[-1])} s: {what}"
            raise self.item.wrong(message, help_, "D251")
        return [self.at(t) for t in times]


@dataclass(frozen=True, slots=True)
class GivenSignal:
    """A signal as a whole, or the fields of a record one by one."""

    name: str
    item: Item
    whole: Given | None
    fields: tuple[Given, ...]

    @property
    def asks(self) -> bool:
        """Whether an expression gives it, or one of its fields."""
        return any(each.expression or each.members for each in (self.whole, *self.fields) if each)


def specs(items: list[Item], folder: Path) -> list[tuple[Path, Item]]:
    """The files of the specs that declare what is given; raises D151 for what is no path of a spec."""
    found = []
    for item in items:
        name = item.text()
        # What comes from elsewhere does not choose any file to be opened and quoted in a message.
        if Path(name).is_absolute() or Path(name).suffix != ".spec" or "\0" in name:
            raise item.wrong(f"`{name}` is no path of a spec", "a .spec file, relative to this one")
        if not (folder / name).is_file():
            raise item.wrong(f"`{name}` is not there", "a .spec file, relative to this one")
        found.append((folder / name, item))
    return found


def signals(item: Item) -> tuple[GivenSignal, ...]:
    """The signals that a declaration gives; raises D151 and D251."""
    return tuple(_signal(name, each) for name, each in item.any_fields().items())


def _signal(name: str, item: Item) -> GivenSignal:
    if item.is_map() and "fields" in (inside := item.any_fields()):
        if len(inside) > 1:
            raise item.wrong("`fields` stands beside something else", "give the whole signal, or its fields")
        return GivenSignal(name, item, None, fields(inside["fields"]))
    return GivenSignal(
        name, item, given(name, item, f"{_HOW}; of a `state` also `fields`, with these for each"), ()
    )


def fields(item: Item) -> tuple[Given, ...]:
    """Fields by name; raises D151 and D251."""
    return tuple(given(name, each) for name, each in item.any_fields().items())


def given(name: str, item: Item, help_: str = _HOW) -> Given:
    """One value: a map that says how it is given. Raises D151 and D251."""
    if not item.is_map():
        return Given(name, item, (0.0,), (item.value(),))
    inside = item.any_fields()
    if len(inside) != 1 or not inside.keys() <= {"value", "at", "is", "column"}:
        raise item.wrong("it is not said how the value is given", help_)
    ((how, what),) = inside.items()
    readers: dict[str, Callable[[], Given]] = {
        "value": lambda: Given(name, what, (0.0,), (what.value(),)),
        "at": lambda: _table(name, what),
        "is": lambda: (
            Given(name, what, members=_members(what))
            if what.is_map()
            else Given(name, what, expression=what.text())
        ),
        "column": lambda: Given(name, what, column=what.text()),
    }
    return readers[how]()


#: In place of the last member's formula.
OTHERWISE = "otherwise"


def _members(item: Item) -> tuple[Member, ...]:
    """Rows `yellow: 'a formula'`, the last `green: otherwise`, so that there is a value in every cycle."""
    found = [Member(name, each.text(), each) for name, each in item.any_fields().items()]
    if [member.formula == OTHERWISE for member in found] != [False] * (len(found) - 1) + [True]:
        help_ = "`{yellow: 'a formula', green: otherwise}`: the first that holds, and last what else it is"
        raise item.wrong("it is not said which member there is when no formula holds", help_, "D251")
    return (*found[:-1], Member(found[-1].name, "", found[-1].item))


def _table(name: str, item: Item) -> Given:
    """Rows `12 s: value`; the first from 0 s on, so that there is a value in every cycle."""
    times: list[float] = []
    values: list[Any] = []
    for key, each in item.any_fields().items():
        found = _TIME.fullmatch(key)
        if found is None:
            raise each.wrong(f"`{key}` is no time", "write times in seconds: `12 s: yellow`", "D251")
        t = float(found[1])
        if not times and t != 0.0:
            raise each.wrong("what holds before is not said", "the first row is of `0 s`", "D251")
        if times and t <= times[-1]:
            raise each.wrong(f"{t:g} s does not come after {times[-1]:g} s", "sort the rows by time", "D251")
        times.append(t)
        values.append(each.value())
    if not times:
        raise item.wrong("the table is empty", "the first row is of `0 s`", "D251")
    return Given(name, item, tuple(times), tuple(values))
