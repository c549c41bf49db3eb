"""The base of every error that trackmarshal reports to a person."""

from __future__ import annotations

from pathlib import PurePath


class TrackmarshalError(Exception):
    """An input that cannot be used, said with its place, a stable code and a way out.

    `code` is stable across releases (`trackmarshal explain CODE`), `file` and `line` (1-based) say where,
    `help` what to do about it.
    """

    def __init__(
        self,
        code: str,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        help: str | None = None,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.file = file
        self.line = line
        self.help = help

    def __str__(self) -> str:
        place = "" if self.file is None else self.file + ("" if self.line is None else f":{self.line}") + ": "
        tail = "" if self.help is None else f"\n  help: {self.help}"
        return f"{place}error[{self.code}]: {self.message}{tail}"


def wrong_type(wanted: str, given: object) -> TypeError:
    """For an argument of a public function that is something else than it takes: a mistake of the program that calls it, and of no file."""
    if given is None:
        return TypeError(f"{wanted}, not None")
    short = isinstance(given, str | int | float | PurePath)
    return TypeError(f"{wanted}, not {type(given).__name__}{f' {str(given)!r:.80}' if short else ''}")
