"""Which modules declare a name that a module does not see: those that are loaded, and the others of its project.

Modules that nobody uses are not parsed for this, only looked through for lines that begin a declaration. It happens on the way to an
error message, never without one.
"""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path

from trackmarshal.errors import TrackmarshalError
from trackmarshal.semantics.modules import Library, declared, module_path, modules_near, root_of
from trackmarshal.source import read

#: More modules than this are not named.
MOST_NAMED = 4
_USE = re.compile(r"^use[ \t]+([\w.]+)", re.MULTILINE)
#: What messages call a name that can be one kind of declaration only, and that kind's keywords.
_KEYWORDS = {
    "zone": {"zone"},
    "stretch": {"stretch"},
    "reference": {"reference"},
    "assumption": {"assume"},
    "shape": {"shape"},
}
_VALUES = {"signal", "event", "param", "table", "zone", "line", "stretch", "define", "predicate"}


class _Text:
    """A module's text, as far as it declares and uses something."""

    def __init__(self, text: str) -> None:
        self._text = text

    @cached_property
    def names(self) -> dict[str, str]:
        return declared(self._text)

    @cached_property
    def uses(self) -> list[str]:
        return _USE.findall(self._text)


class Elsewhere:
    """Finds the modules that declare a name."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self._texts: dict[Path, dict[str, _Text]] = {}

    def modules(self, name: str, what: str, user: str) -> tuple[str, ...]:
        """The modules that `user` could use for a name that messages call `what`, in the order of their names."""
        loaded = self._library.modules.get(user)
        if loaded is None:
            return ()
        root = root_of(loaded)
        texts = self._below(root)
        wanted = _KEYWORDS.get(what, _VALUES)
        found = [
            module for module, text in texts.items() if module != user and text.names.get(name) in wanted
        ]
        own = {use.name for use in loaded.uses}
        return tuple(sorted(m for m in found if m not in own and not _leads(m, user, texts)))[:MOST_NAMED]

    def _below(self, root: Path) -> dict[str, _Text]:
        """All modules that can be used from a folder, by their names."""
        if root not in self._texts:
            texts: dict[str, _Text] = {}
            for name in modules_near(root):
                loaded = self._library.modules.get(name)
                path = module_path(name, root)
                if loaded is not None and loaded.path.resolve() == path.resolve():
                    texts[name] = _Text(loaded.file.text)
                    continue
                try:
                    texts[name] = _Text(read(path).text)
                except TrackmarshalError:
                    continue  # nobody asked for it
            self._texts[root] = texts
        return self._texts[root]


def _leads(start: str, target: str, texts: dict[str, _Text]) -> bool:
    """Whether a module needs another one, which could then not use it."""
    seen: set[str] = set()
    stack = [start]
    while stack:
        module = stack.pop()
        if module == target:
            return True
        if module not in seen and module in texts:
            seen.add(module)
            stack += texts[module].uses
    return False
