"""Which engine makes results: its version, and what it is made of."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from trackmarshal import __version__

#: The folder of the sources.
HERE = Path(__file__).parent.parent
#: What takes no part in what a rule, a test, a run comes to. Of an installed program, `trace` lies beside what evaluates; of a checkout, elsewhere.
_NO_PART = ("cli", "start", "process", "explaining", "meaning", "diagnostics", "trace")
#: Of the command line, what does: what is written down of a run, and how it is run.
_PART = {("cli", name) for name in ("campaigns.py", "evidence.py", "operating.py", "replay.py")}
_KINDS = (".py", ".spec", ".lark", ".c", ".h", ".j2")
#: What it reads besides, of which no result is made: words, schemas, styles.
_DATA = (".css", ".js", ".json", ".tables", ".txt", ".yaml")


@cache
def tool() -> str:
    """`trackmarshal VERSION HASH`, the hash being that of the sources of what reads and evaluates rules, and of numpy's version."""
    return f"trackmarshal {__version__} {_sources(_own(HERE), _NO_PART, _KINDS)[:16]}"


def tool_of(folder: Path) -> str:
    """What `tool` says in a program whose sources are in another folder, such as one of an earlier commit; empty where they are not there."""
    try:
        version = re.search(r'^__version__ = "([^"]*)"$', (folder / "__init__.py").read_text("utf-8"), re.M)
    except (OSError, ValueError):
        return ""
    return f"trackmarshal {version[1]} {_sources(_hashes(folder), _NO_PART, _KINDS)[:16]}" if version else ""


@cache
def whole() -> str:
    """The hash of the sources and data of all of it, what reads projects included, and of numpy's version."""
    reading = find_spec("trackmarshal.trace")
    folders = reading.submodule_search_locations if reading is not None else None
    apart = [Path(folder) for folder in folders or () if not Path(folder).is_relative_to(HERE)]
    return _sources([each for folder in (HERE, *apart) for each in _own(folder)], (), _KINDS + _DATA)


def _numpy() -> bytes:
    """What says which numpy evaluates, without importing it; nothing where there is none."""
    found = find_spec("numpy")
    if found is None or found.origin is None:
        return b""
    return Path(found.origin).with_name("version.py").read_bytes()


def _sources(
    hashes: Iterable[tuple[tuple[str, ...], bytes]], without: tuple[str, ...], kinds: tuple[str, ...]
) -> str:
    digest = hashlib.sha256(_numpy())
    for parts, hashed in hashes:
        if parts[-1].endswith(kinds) and (parts[0] not in without or parts in _PART):
            digest.update("/".join(parts).encode() + b"\0" + hashed)
    return digest.hexdigest()


def _hashes(root: Path) -> list[tuple[tuple[str, ...], bytes]]:
    """The sources and data below a folder, each by the parts of its path from there, in order, with its hash."""
    found = []
    for folder, _, names in os.walk(root):
        within = Path(folder).relative_to(root).parts
        for name in names:
            if name.endswith(_KINDS + _DATA):
                with open(os.path.join(folder, name), "rb") as file:
                    found.append(((*within, name), hashlib.sha256(file.read()).digest()))
    return sorted(found)


@cache
def _own(here: Path) -> list[tuple[tuple[str, ...], bytes]]:
    """Those of this program, which are read once."""
    return _hashes(here)
