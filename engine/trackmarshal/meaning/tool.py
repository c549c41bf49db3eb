"""Which engine makes results: its version, and what it is made of."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from trackmarshal import __version__

#: What takes no part in what a rule, a test, a run comes to.
_NO_PART = ("cli", "start", "process", "explaining", "meaning", "diagnostics")
_KINDS = (".py", ".spec", ".lark", ".c", ".h", ".j2")


@cache
def tool() -> str:
    """`trackmarshal VERSION HASH`, the hash being that of the sources of what reads and evaluates rules."""
    return f"trackmarshal {__version__} {_sources(_NO_PART)[:16]}"


@cache
def whole() -> str:
    """The hash of the sources of all of it, what reads projects included."""
    return _sources(())


def _sources(without: tuple[str, ...]) -> str:
    root = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        shown = path.relative_to(root)
        if path.suffix in _KINDS and shown.parts[0] not in without:
            digest.update(shown.as_posix().encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()
