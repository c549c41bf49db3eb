"""The shipped specs that every project can `use`: rules of a Supervisor, vehicles, tracks, rulebooks.

An installed package has them as its folder `specs`; a checkout has them where they are written, in `specs`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_INSTALLED = _PACKAGE / "specs"
_CHECKOUT = _PACKAGE.parents[1] / "specs"

#: The folder in which the names of the shipped modules start.
LIBRARY = _INSTALLED if _INSTALLED.is_dir() else _CHECKOUT
#: Whether it came with the package, and so is nobody's project, wherever that is installed.
INSTALLED = LIBRARY is _INSTALLED

#: The modules of the library that are values, of a vehicle or of a track; `vehicles.spec` is a file.
_VALUES = re.compile(r"(?:vehicles|tracks)\.(?!spec$)[a-z]\w*")


def shipped_values(name: str) -> Path | None:
    """Where a shipped vehicle or track is, by its module (`vehicles.devbot`), if there is one of that name; None for what is no such name."""
    return LIBRARY / f"{name.replace('.', '/')}.spec" if _VALUES.fullmatch(name) else None


def of_its_name(shipped: Path, folders: Iterable[Path]) -> Path | None:
    """Another file that is a module of a shipped one's name, in one of these folders or in its `specs`; a copy is no other one."""
    path = shipped.relative_to(LIBRARY)
    places = (folder / below / path for folder in folders for below in ("specs", ""))
    return next((one for one in places if one.is_file() and one.read_bytes() != shipped.read_bytes()), None)
