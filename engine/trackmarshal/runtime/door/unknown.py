"""Names that nothing declares: a fault each, and what may have been meant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from functools import lru_cache
from typing import Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.runtime.faults import Fault, fault

#: Names that nothing declares for which something else is suggested; a flood of them takes no time.
MOST_SUGGESTED = 8


def refuse_unknown(
    label: str,
    given: Sequence[Mapping[Any, Any]],
    known: Set[str],
    faults: list[Fault],
    indexed: bool = False,
) -> None:
    """A fault for every key that nothing declares; indexed: these are records, of which the first with the key is named."""
    found: dict[str, list[int]] = {}
    for index, data in enumerate(given):
        if not data.keys() <= known:
            for key in data:
                if key not in known:
                    found.setdefault(_name(key), []).append(index)
    for place, (name, places) in enumerate(found.items()):
        hint = suggested(name, known) if place < MOST_SUGGESTED else ""
        more = f", and {len(places) - 1} more" if len(places) > 1 and indexed else ""
        message = f"nothing declares `{name}`{more}" if name else "a field is called by a text"
        at = places[0] if indexed else None
        faults.append(fault("unknown", label, name, at, message + (f"; {hint}" if hint else "")))


def _name(key: object) -> str:
    """A name that nothing declares, as it is called in faults: a long one by a name that nothing can have."""
    if type(key) is not str:
        return ""
    return key if len(key) <= 80 else f"{key[:79]}..."


def suggested(name: str, known: Iterable[str]) -> str:
    """What may have been meant, however it is spelt; empty for no idea."""
    return _suggested(name, tuple(sorted(known)))


@lru_cache(maxsize=256)
def _suggested(name: str, listed: tuple[str, ...]) -> str:
    """A recording asks the same in every cycle."""
    return close_matches(name, listed) or close_matches(name.lower(), listed)
