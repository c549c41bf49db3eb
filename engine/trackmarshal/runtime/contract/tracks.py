"""Whose places rules read: those of a track hold there and nowhere else.

A module `tracks.NAME` has the places of the track NAME (`ir.spec.track_of`). Data names its track where it has the borders: `"track": {"name": NAME, "left": ..}`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from typing import Any
from weakref import WeakKeyDictionary

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec, track_of

#: Pairs of a place, by its qualified name, and the track that it is on.
Places = tuple[tuple[str, str], ...]


def places_of(spec: Spec, rules: Iterable[RuleInfo]) -> Places:
    """The places of named tracks that rules read, and stretches."""
    found: dict[str, str] = {}
    for rule in rules:
        for formula in (rule.formula, rule.active):
            for node in _placed(formula) if formula is not None else ():
                if isinstance(node, ir.StretchRoom):
                    if track := track_of(node.name.rpartition(".")[0]):
                        found[node.name] = track
                elif spec.places[node.name].track:
                    found[node.name] = spec.places[node.name].track
    return tuple(sorted(found.items()))


#: What `_placed` found, as long as a formula is there: each door of a spec asks.
_PLACED: WeakKeyDictionary[ir.Formula, tuple[ir.StretchRoom | ir.Area | ir.Line, ...]] = WeakKeyDictionary()


def _placed(formula: ir.Formula) -> tuple[ir.StretchRoom | ir.Area | ir.Line, ...]:
    """What is in a formula that stands at one place."""
    found = _PLACED.get(formula)
    if found is None:
        found = _PLACED[formula] = tuple(
            node
            for node in ir.below(formula)
            if isinstance(node, ir.StretchRoom)
            or (isinstance(node, ir.Area) and node.kind == "zone")
            or (isinstance(node, ir.Line) and node.kind == "place")
        )
    return found


def corridors_of(spec: Spec) -> tuple[str, ...]:
    """The signals that have borders, and with them the name of the track."""
    return tuple(name for name, info in spec.signals.items() if info.kind == "corridor")


def elsewhere(places: Places, name: str, given: Set[str] = frozenset()) -> str:
    """Which places are not on the track of that name, in words; empty where all are. `given`: places that data brought itself."""
    wrong: Mapping[str, Any] = {
        place: track for place, track in places if track != name and place not in given
    }
    if not wrong:
        return ""
    called = ", ".join(f"`{place.rpartition('.')[2]}`" for place in wrong)
    tracks = " and ".join(f"`{track}`" for track in dict.fromkeys(wrong.values()))
    return f"the track is `{name:.40}`, but {called} {'is' if len(wrong) == 1 else 'are'} on {tracks}"
