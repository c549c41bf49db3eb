"""Pages of runs that were drawn before, kept in the user's cache: used again where what they show, what stands around it, and all that draws
them is as it was."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from functools import cache as once
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from trackmarshal import cache


class Drawn:
    """The pages of one assessment. A page is kept as what stands before and after its date."""

    def __init__(self, root: Path, shown: str) -> None:
        """shown: one hash of all that is shown of runs; where it is empty, nothing is known to be the same, and nothing is kept."""
        self._path = cache.of_project("pages", root) if shown else None
        self._shown = shown
        known = None if self._path is None else cache.kept(self._path)
        self._known: dict[str, Any] = known if isinstance(known, dict) else {}
        self._used: dict[str, tuple[str, str]] = {}

    def __call__(self, about: Sequence[object], draw: Callable[[], tuple[str, str]]) -> tuple[str, str]:
        """A page with this around its record: one that was kept, or drawn now."""
        if self._path is None:
            return draw()
        key = hashlib.sha256(json.dumps([self._shown, drawing(), *about]).encode()).hexdigest()
        try:
            before, after = map(str, self._known[key])
        except (KeyError, TypeError, ValueError):  # not there, or not as it is written here
            before, after = draw()
        self._used[key] = before, after
        return before, after

    def keep(self) -> None:
        """Keep the pages of this assessment for the next one, and no others."""
        if self._path is not None and self._used.keys() != self._known.keys():
            cache.keep(self._path, self._used)


@once
def drawing() -> str:
    """One hash of all that draws pages: the sources and templates of the reports, and what fills in these."""
    import trackmarshal.trace

    digest = hashlib.sha256()
    for here in (Path(trackmarshal.trace.__file__).parent, *map(_package, ("jinja2", "markupsafe"))):
        files = (os.path.join(folder, name) for folder, _, names in os.walk(here) for name in names)
        for file in sorted(files):
            if not file.endswith(".pyc"):
                held = hashlib.sha256(Path(file).read_bytes()).digest()
                digest.update(os.path.relpath(file, here).encode() + b"\0" + held)
    return digest.hexdigest()


__all__ = ["Drawn", "drawing"]


def _package(name: str) -> Path:
    """Where the sources of another package are, without importing it."""
    found = find_spec(name)
    assert found is not None, f"{name} is needed to draw pages"
    assert found.origin is not None, f"{name} is no package"
    return Path(found.origin).parent
