"""Every day, modules that are the same are compiled once in each process, and declarations that are the same drive once: commands that tests
run compile the shipped rules hundreds of times, each a tenth of a second, and generate the runs of some small projects as often. Boundaries of rules
are drawn once for copies of one project, too.

`make acceptance` does so each time.
"""

from __future__ import annotations

import os
import pickle
from collections import OrderedDict
from dataclasses import replace
from functools import wraps
from typing import Any

from trackmarshal import cache
from trackmarshal.cli import drawing
from trackmarshal.semantics.compile import Compiled, _Compiler

#: Fewer modules take less time than it takes to look after them; so many sets of modules are kept.
FEWEST, MOST = 7, 24


def compiled_once(run: Any) -> Any:
    """`_Compiler.run` that knows what it said of the same trees, read from the same places; what is wrong with files is said each time."""
    kept: OrderedDict[Any, tuple[Any, Compiled]] = OrderedDict()

    def again(self: _Compiler) -> Compiled:
        modules = self.library.modules
        if (
            len(self.order) < FEWEST
            or self.found
            or self.library.failures
            or self._compiled_before is not None
        ):
            return run(self)  # type: ignore[no-any-return]
        # Trees of the same text are one object while anybody has it, and whoever is kept here has it.
        trees = [one.tree for one in modules.values()]
        key = (
            self.asked, self.order, tuple((one.name, one.path, one.file.path, id(one.tree)) for one in modules.values()),
        )  # fmt: skip
        found = kept.get(key)
        if found is None:
            made: Compiled = run(self)
            if made.found:  # hints look at what else there is
                return made
            found = kept[key] = (trees, made)
            if len(kept) > MOST:
                kept.popitem(last=False)
        kept.move_to_end(key)
        return found[1]

    return again


def generated_once(run: Any) -> Any:
    """`generate.run.run` that knows what came of a declaration with the same content, but for the specs beside it, which it does not ask; everybody
    gets a recording of his own."""
    kept: OrderedDict[tuple[bytes, str], bytes] = OrderedDict()

    @wraps(run)
    def again(declared: Any, shown: str) -> Any:
        key = pickle.dumps(replace(declared, specs=[])), shown
        found = kept.get(key)
        if found is None:
            found = kept[key] = pickle.dumps(run(declared, shown))
            if len(kept) > MOST:
                kept.popitem(last=False)
        kept.move_to_end(key)
        return pickle.loads(found)

    return again


def drawn_once(run: Any) -> Any:
    """`cli.drawing.drawings` for which a project of which nothing is kept begins with what was drawn from the same: under its hash it would be kept, too.

    Where a test has a cache of its own, it may be about what is kept, and begins with nothing.
    """
    kept: dict[str, Any] = {}
    place = os.environ.get("TRACKMARSHAL_CACHE")

    @wraps(run)
    def again(root: Any, facts: Any, sheets: Any, sources: Any) -> Any:
        path = cache.of_project("drawings", root)
        if path is not None and not path.exists() and os.environ.get("TRACKMARSHAL_CACHE") == place:
            keys = drawing._keys(facts, sheets).values()
            cache.keep(path, {key: kept[key] for key in keys if key in kept})
        found = run(root, facts, sheets, sources)
        kept.update(
            (one["sha"], {key: part for key, part in one.items() if key != "sha"}) for one in found.values()
        )
        return found

    return again
