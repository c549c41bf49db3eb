"""JSON texts to plain values, strictly: no name twice, no constants but those asked for, no crash on any input."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any, Never, TypeVar

from trackmarshal.doubles import double

T = TypeVar("T")


class BadJson(ValueError):
    """Not the JSON that was expected; the message says why, the caller knows where."""


def named_twice(names: Iterable[T]) -> T | None:
    """The first name that stands there again, None where none does; in one pass, since a file may have a million of them."""
    seen: set[T] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


def _pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    value = dict(pairs)
    if len(value) != len(pairs):
        raise BadJson(f"the name {named_twice(name for name, _ in pairs)!r:.60} stands twice in one object")
    return value


def _no_constant(name: str) -> Never:
    raise BadJson(f"`{name}` is not JSON")


def _nan(_name: str) -> float:
    return math.nan


#: Made once: a text is often one line of thousands. By whether constants are read.
_DECODERS = {
    constants: json.JSONDecoder(parse_constant=_nan if constants else _no_constant, object_pairs_hook=_pairs)
    for constants in (False, True)
}


def parse(text: str, *, constants: bool = False) -> Any:
    """One JSON text to its value. With `constants`, NaN, Infinity and -Infinity are read, all as NaN.

    Raises BadJson, also for nesting and for digits without end.
    """
    if text.startswith("\ufeff"):  # of which decoders know nothing
        raise BadJson("a byte order mark stands elsewhere than at the start of a file")
    try:
        value = _DECODERS[constants].decode(text)
        return _whole(value) if "\\u" in text else value
    except BadJson:
        raise
    except json.JSONDecodeError as error:
        raise BadJson(f"{error.msg} at character {error.pos + 1}") from error
    except RecursionError as error:
        raise BadJson("nested too deeply") from error
    except ValueError as error:  # an integer with thousands of digits
        raise BadJson(str(error)) from error


def _whole(value: Any) -> Any:
    """A value; raises BadJson where it has an escaped half of a pair of surrogates, which is no character and cannot be printed."""
    try:
        json.dumps(value, ensure_ascii=False).encode()
    except UnicodeEncodeError as error:
        raise BadJson("half a pair of surrogates is no character") from error
    return value


def strict(data: bytes) -> Any:
    """What a file of JSON says that has no NaN and no name twice in an object, of which readers take the one or the other; raises ValueError, where it is
    no JSON with the line (`JSONDecodeError`), also for nesting without end."""
    try:
        value = json.loads(data.decode("utf-8"), parse_constant=_no_number, object_pairs_hook=_no_twins)
    except RecursionError as error:  # what it says differs by the version of Python
        raise ValueError("nested too deeply") from error
    return _whole(value) if b"\\u" in data else value


def _no_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        raise ValueError(f"`{named_twice(name for name, _ in pairs):.60}` is there twice in one object")
    return made


def _no_number(word: str) -> Never:
    raise ValueError(f"{word} is not strict JSON")


def number(value: Any) -> float:
    """A JSON number as float (true and false are none); beyond the range of double it is infinite."""
    if type(value) is float:
        return value
    if type(value) is int:
        return double(value)
    raise BadJson(f"{kind(value)} stands where a number is expected")


def kind(value: Any) -> str:
    """What a JSON value is, in words for a message."""
    if isinstance(value, bool):
        return f"the truth value {str(value).lower()}"
    if isinstance(value, str):
        return f"the text {value[:40]!r}"
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if value is None:
        return "null"
    return f"{value!r:.40}"
