"""Fields of a JSON object, read by their kind: what is missing, or of another kind, is T290."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeVar

from trackmarshal.errors import TrackmarshalError

HELP = "delete it: `trackmarshal import log --keep` makes the run of a log anew, `pytest --trackmarshal-results` what came of tests"
T = TypeVar("T")
_REQUIRED: Any = object()


class Fields:
    """Typed access to a JSON object; raises T290 for what is missing or of the wrong kind."""

    def __init__(self, data: object, what: str) -> None:
        if not isinstance(data, dict):
            raise refused(f"{what}: an object is expected, not {_kind(data)}")
        self.data: dict[str, Any] = data
        self.what = what

    def text(self, name: str, default: str = _REQUIRED) -> str:
        return self._get(name, default, str, "a text")

    def word(self, name: str, known: Sequence[str]) -> str:
        value = self.text(name)
        if value not in known:
            raise refused(f"{self.what}: `{name}` is `{value}`, known are {', '.join(known)}")
        return value

    def names(self, known: Sequence[str], said: str) -> list[str]:
        """The names of all that there is, which are known as what is `said`."""
        for name in self.data:
            if name not in known:
                raise refused(f"{self.what}: `{name}` is no {said}")
        return list(self.data)

    def flag(self, name: str, default: bool = _REQUIRED) -> bool:
        return self._get(name, default, bool, "true or false")

    def count(self, name: str, default: int = _REQUIRED) -> int:
        value: int = self._get(name, default, int, "a whole number")
        if isinstance(value, bool) or value < 0:
            raise refused(f"{self.what}: `{name}` must be a whole number from 0")
        return value

    def time(self, name: str) -> float | None:
        value = self.data.get(name)
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise refused(f"{self.what}: `{name}` must be a number or null, not {_kind(value)}")
        try:
            return None if value is None else float(value)
        except OverflowError as error:  # a whole number of hundreds of digits
            raise refused(f"{self.what}: `{name}` is beyond the range of IEEE double") from error

    def finite(self, name: str) -> float:
        value = self.time(name)
        if value is None or not math.isfinite(value):
            raise refused(f"{self.what}: `{name}` must be a finite number")
        return value

    def array(self, name: str) -> list[Any]:
        value: list[Any] = self._get(name, [], list, "a list")
        return value

    def table(self, name: str, default: dict[str, Any] = _REQUIRED) -> dict[str, Any]:
        value: dict[str, Any] = self._get(name, default, dict, "an object")
        return value

    def numbers(self, name: str) -> tuple[float, ...]:
        """Numbers; none where it is not there."""
        found = self.array(name)
        if not all(type(each) in (int, float) for each in found):
            raise refused(f"{self.what}: `{name}` must be a list of numbers")
        return tuple(map(float, found))

    def ranges(self, name: str) -> dict[str, tuple[float, float]]:
        """Two numbers by name, the lower one first; none where it is not there."""
        found = {}
        for key, ends in self.table(name, {}).items():
            if not (
                isinstance(ends, list)
                and [type(end) in (int, float) for end in ends] == [True, True]
                and ends[0] <= ends[1]
            ):
                raise refused(f"{self.what}: `{name}` holds something else than ranges")
            found[key] = (float(ends[0]), float(ends[1]))
        return found

    def words(self, name: str) -> dict[str, str]:
        """Texts by name; none where it is not there."""
        value: dict[str, Any] = self._get(name, {}, dict, "an object")
        if not all(isinstance(item, str) for item in value.values()):
            raise refused(f"{self.what}: `{name}` holds something else than texts")
        return dict(value)

    def texts(self, name: str) -> tuple[str, ...]:
        items = self.array(name)
        if not all(isinstance(item, str) for item in items):
            raise refused(f"{self.what}: `{name}` must be a list of texts")
        return tuple(items)

    def _get(self, name: str, default: T, kind: type[T], said: str) -> T:
        value = self.data.get(name, default)
        if value is _REQUIRED:
            raise refused(f"{self.what}: `{name}` is missing")
        if not isinstance(value, kind):
            raise refused(f"{self.what}: `{name}` must be {said}, not {_kind(value)}")
        return value


def _kind(value: object) -> str:
    names = {
        dict: "an object",
        list: "a list",
        str: "a text",
        bool: "a Boolean",
        int: "a number",
        float: "a number",
    }
    return names.get(type(value), "null")


def refused(message: str) -> TrackmarshalError:
    """T290, of a file that whoever reads it names."""
    return TrackmarshalError("T290", message, help=HELP)
