"""Cases as plain data for a generated module: clean ones, and ones with everything that can be wrong with data."""

from __future__ import annotations

import math
from typing import Any

from support.generated.choices import Choices
from support.generated.places import Road
from support.generated.vocabulary import HUGE, PLAIN, TIMELINES, FieldInfo, World

_BAD: tuple[Any, ...] = (None, math.nan, math.inf, -math.inf, "nan", "inf", 10**400)


class Inputs:
    """Makes cases. `dirt` is how many percent of a case's values and columns are broken, 0 in most cases."""

    def __init__(self, choices: Choices, world: World, longest: int = 6) -> None:
        self.choices = choices
        self.world = world
        self.longest = longest
        self._road = Road(choices)

    def case(self, index: int, dirt: int) -> dict[str, Any]:
        """One case with its overrides."""
        signals: dict[str, Any] = {}
        for name, signal in self.world.signals.items():
            if self.choices.chance(dirt // 6):
                if self.choices.chance(50):
                    signals[name] = None
                continue
            if name in TIMELINES:
                signals[name] = self.timeline(name, dirt)
            elif signal.kind == "set of object":
                signals[name] = self.objects(name, dirt)
            else:
                signals[name] = self.record(signal.fields, dirt)
        if self.world.road:
            signals.update(self._road.signals(dirt))
        for name in self.world.events:
            signals[name] = self._flag(dirt)
        case: dict[str, Any] = {"id": index, "signals": signals}
        self._overrides(case)
        return case

    def value(self, info: FieldInfo, dirt: int) -> Any:
        """A value of a field, in its unit."""
        if info.dimension is None:
            return self._flag(dirt)
        if self.choices.chance(dirt):
            return self.choices.pick(_BAD if self.choices.chance(60) else HUGE)
        kind = self.choices.integer(0, 9)
        if kind < 6:
            value: Any = self.choices.pick(PLAIN)
        elif kind < 9:
            value = self.choices.real(-20.0, 20.0)
        else:
            value = self.choices.integer(-3, 12)
        if info.range is not None and not self.choices.chance(dirt):
            value = min(max(value, info.range[0]), info.range[1])
        return value

    def _flag(self, dirt: int) -> bool | None:
        if self.choices.chance(dirt):
            return None
        return self.choices.chance(50)

    def record(self, fields: dict[str, FieldInfo], dirt: int) -> dict[str, Any]:
        """A single record, or an element of a set."""
        result = {}
        for name, info in fields.items():
            if not self.choices.chance(dirt // 4) and not (
                info.default is not None and self.choices.chance(40)
            ):
                result[name] = self.value(info, dirt)
        return result

    def objects(self, name: str, dirt: int) -> list[dict[str, Any]]:
        """A set: often small, often empty."""
        fields = self.world.signals[name].fields
        elements = [self.record(fields, dirt) for _ in range(self.choices.pick((0, 1, 2, 3, 2, 3, 4)))]
        for number, element in enumerate(elements):
            if self.choices.chance(60):
                element["id"] = f"o{number}"
        return elements

    def timeline(self, name: str, dirt: int) -> dict[str, list[Any]]:
        """Columns of samples; a series may have a single one."""
        least = 1 if name == "trace" or self.choices.chance(dirt // 4) else 2
        count = self.choices.integer(least, self.longest)
        if self.choices.chance(dirt // 10):
            count = 0
        columns: dict[str, list[Any]] = {}
        for field, info in self.world.signals[name].fields.items():
            if self.choices.chance(dirt // 5) or (info.default is not None and self.choices.chance(40)):
                continue
            own = max(0, count - 1) if self.choices.chance(dirt // 8) else count
            columns[field] = (
                self.times(info, own, dirt)
                if info.increasing
                else [self.value(info, dirt) for _ in range(own)]
            )
        return columns

    def times(self, info: FieldInfo, count: int, dirt: int) -> list[Any]:
        """Increasing times, equidistant or not; with dirt they may stand still, go back or be missing."""
        scale = 1000.0 if info.unit == "ms" else 1.0
        time = self.choices.pick((0.0, 0.1, -3.7, 1e6))
        steps = self.choices.pick(((0.1,), (0.25,), (0.1, 0.5, 1.0, 0.25), (1.0,)))
        times: list[Any] = []
        for _ in range(count):
            times.append(time * scale)
            time += self.choices.pick(steps)
        if times and self.choices.chance(dirt // 2):
            at = self.choices.integer(0, count - 1)
            times[at] = self.choices.pick((times[0], None, math.nan, -1e9, math.inf))
        return times

    def _overrides(self, case: dict[str, Any]) -> None:
        params = {}
        for name, info in self.world.params.items():
            if self.choices.chance(25):
                low, high = (-5.0, 5.0) if info.low is None or info.high is None else (info.low, info.high)
                # Inside by a margin: a conversion to SI and back may move a bound by its last digit.
                params[name] = self.choices.real(low + 0.001, high - 0.001)
        if params:
            case["params"] = params
        tables = {}
        for name in self.world.tables:
            if self.choices.chance(20):
                knot, rows = self.choices.pick(PLAIN), []
                for _ in range(self.choices.integer(1, 4)):
                    rows.append([knot, self.choices.pick(PLAIN)])
                    knot += self.choices.pick((0.5, 1.0, 0.1))
                tables[name] = rows
        if tables:
            case["tables"] = tables
        places = {name: self._road.ring() for name in self.world.zones if self.choices.chance(15)}
        places |= {name: self._road.mark() for name in self.world.lines if self.choices.chance(15)}
        if places:
            case["places"] = places
