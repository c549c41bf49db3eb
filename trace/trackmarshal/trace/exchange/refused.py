"""A file of another tool that cannot be used, and text out of bytes."""

from __future__ import annotations

from trackmarshal.errors import TrackmarshalError


class Refused(TrackmarshalError):
    """What is wrong with the file as a whole, or with one place of it."""

    def __init__(self, code: str, message: str, file: str, line: int = 0, help: str = "") -> None:
        super().__init__(code, message, file=file or None, line=line or None, help=help or None)


def decoded(data: bytes, shown: str, help: str = "save the file as UTF-8") -> str:
    """The text of a file in UTF-8, with or without byte order mark; raises T350 for another encoding and for an empty file."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        message = f"byte {data[problem.start]:#04x} at offset {problem.start} is not UTF-8"
        raise Refused("T350", message, shown, line, help) from None
    if not text.strip():
        raise Refused("T350", "the file is empty", shown, 1, "export it again")
    return text
