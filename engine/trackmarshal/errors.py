"""The base of every error that trackmarshal reports to a person."""

from __future__ import annotations


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
