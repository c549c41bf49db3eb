"""Names of a spec as C identifiers, numbers as C literals, text that is safe in comments."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from functools import lru_cache

_PLAIN = re.compile(r"[ -~]*")
_KEYWORDS = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "_Bool",
        "bool",
        "true",
        "false",
        "count",
    ]
)


def identifier(name: str) -> str:
    """A C identifier for a name of a spec: lower case, what C does not know spelled out."""
    text = "".join(
        c if c.isascii() and (c.isalnum() or c == "_") else "_" if c in ".-" else f"u{ord(c):x}" for c in name
    )
    if text.casefold() in _KEYWORDS or text[:1].isdigit() or not text:
        text = f"{text}_" if text and not text[:1].isdigit() else f"n{text}"
    return text


def distinct(names: Iterable[str]) -> dict[str, str]:
    """Names to C identifiers, no two alike."""
    taken: set[str] = set()
    result: dict[str, str] = {}
    for name in names:
        base = made = identifier(name)
        number = 2
        while made in taken:
            made = f"{base}_{number}"
            number += 1
        taken.add(made)
        result[name] = made
    return result


def literal(value: float) -> str:
    """A double as a C constant expression of exactly that value."""
    if math.isnan(value):
        return "TM_NAN"
    if math.isinf(value):
        return "TM_INF" if value > 0 else "(-TM_INF)"
    text = repr(value)
    if not re.search(r"[.e]", text):
        text += ".0"
    return f"({text})" if text.startswith("-") else text


@lru_cache(maxsize=4096)
def comment(text: str) -> str:
    """Text inside a C comment: one line, printable ASCII, no comment marks."""
    flat = (
        " ".join(text.split())
        .replace("*/", "* /")
        .replace("/*", "/ *")
        .replace("\\", "/")
        .replace("??", "? ?")
    )
    return flat if _PLAIN.fullmatch(flat) else "".join(c if " " <= c <= "~" else "?" for c in flat)
