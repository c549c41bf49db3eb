"""The shapes of values in requirements files: what is checked, and what requirements/schema.json is made from."""

from __future__ import annotations

import re
from collections.abc import Mapping as Table
from dataclasses import dataclass, field

#: An id that a spec can name in `satisfies`.
ID = r"[A-Z][A-Za-z0-9]*(-[A-Za-z0-9]+)+"
#: A subsystem, or an interface as the subsystems that it joins.
SUBSYSTEM = r"[A-Z][A-Z0-9]*"
INTERFACE = rf"{SUBSYSTEM}(-{SUBSYSTEM})?"
#: What only documents name.
WORD = r"[A-Za-z][A-Za-z0-9_-]*"
#: Ids, or ids with `*` for any characters.
PATTERN = r"[A-Za-z0-9*][A-Za-z0-9*_-]*"
#: A path inside the project: relative, forward slashes, no way out.
PATH = r"(?!/)(?!(.*/)?\.\.(/|$))[^\\:]*[^\\:/\s]"
HASH = r"[0-9a-f]{64}"
ASIL = r"(QM|[ABCD])(\((QM|[ABCD])\))?"

#: All that somebody wrote whose writing was put off.
_PUT_OFF = frozenset({"todo", "tbd", "tba", "tbc", "fixme"})
#: A text of so many characters says more than that.
MORE = 100


def says_nothing(text: str) -> bool:
    """Whether a text has neither a letter nor a digit, such as `-`, or says no more than that it is still to be written."""
    return put_off(text) or not any(map(str.isalnum, text))


def put_off(text: str) -> bool:
    """Whether a text says no more than that it is still to be written, whatever marks stand around that."""
    return len(text) < MORE and "".join(filter(str.isalnum, text)).lower() in _PUT_OFF


@dataclass(frozen=True, slots=True)
class Text:
    """Text that is not blank; `pattern`, if given, must match it whole, `said` says that in words.

    verbatim: words that are taken as they are, whatever they say: another tool's, and those that are looked for.
    """

    pattern: str = ""
    said: str = "a text"
    verbatim: bool = False

    def fits(self, text: str) -> bool:
        return not self.pattern or re.fullmatch(self.pattern, text) is not None


@dataclass(frozen=True, slots=True)
class Word:
    """One of a few words, each with its meaning."""

    choices: Table[str, str]


@dataclass(frozen=True, slots=True)
class Date:
    """A day, YYYY-MM-DD."""


@dataclass(frozen=True, slots=True)
class Count:
    """A whole number from 0."""


@dataclass(frozen=True, slots=True)
class Flag:
    """true or false."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """A mapping of free names to texts."""

    of: Text = field(default_factory=Text)


@dataclass(frozen=True, slots=True)
class Many:
    """A list."""

    of: Shape
    least: int = 0


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a record."""

    name: str
    shape: Shape
    description: str
    required: bool = True


@dataclass(frozen=True, slots=True)
class Record:
    """A mapping with known fields."""

    name: str
    description: str
    fields: tuple[Field, ...]
    by_name: dict[str, Field] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "by_name", {item.name: item for item in self.fields})


Shape = Text | Word | Date | Count | Flag | Pairs | Many | Record


def optional(name: str, shape: Shape, description: str) -> Field:
    return Field(name, shape, description, required=False)
