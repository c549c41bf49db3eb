"""What recordings say of a demand, and which of their samples a picture shows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading.drawing.demand import BROKEN, HOLDS, Demand, Floats
from trackmarshal.reading.drawing.points import Places, Points
from trackmarshal.reading.drawing.quantities import Undrawable
from trackmarshal.runtime.frame import Frame
from trackmarshal.scenarios.overrides import known_tables
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.supervised import frames

#: Cells across and up of which each shows one sample that meets the demand: the one with the least margin.
CELLS = (128, 96)
#: Places across and up that are told apart: of samples that are against the demand, all that differ in them are shown.
PLACES = 1000


class Thinned(NamedTuple):
    """(n, 2) places in a picture, each from 0 to 1. held: of samples that meet the demand; broken: of those that do not, at the edge where they lie beyond.

    seen: how many there were of each; beyond: how many of them lie outside.
    """

    held: Floats
    broken: Floats
    seen: tuple[int, int]
    beyond: tuple[int, int]


def recorded(
    recordings: Iterable[tuple[Recording, Evaluator]], demands: Mapping[str, Demand]
) -> Mapping[str, dict[str, Points | None]]:
    """By rule and recording that it is replayed with, its places; None for a recording that does not fit the rules that it is to be replayed with,
    or is replayed with another rule of that name."""
    found: dict[str, dict[str, Points | None]] = {name: {} for name in demands}
    looking: dict[tuple[int, str], Places | None] = {}
    kept: list[Spec] = []  # an id is one spec's as long as that is there
    for recording, evaluator in recordings:
        kept.append(evaluator.spec)
        chosen = [rule for rule in evaluator.rules if rule.name in demands]
        try:
            seen = list(_seen(recording, evaluator)) if chosen else []
        except TrackmarshalError:  # which is said by whoever replays it
            for rule in chosen:
                found[rule.name][recording.name] = None
            continue
        for rule in chosen:
            key = id(evaluator.spec), rule.name
            if key not in looking:
                looking[key] = _places(rule, evaluator.spec, demands[rule.name])
            places = looking[key]
            found[rule.name][recording.name] = None if places is None else places.of(seen)
    return found


def _places(rule: RuleInfo, spec: Spec, like: Demand) -> Places | None:
    """The places of a rule as a recording is replayed with it; None where it has other inputs than the one that is drawn."""
    try:
        made = Demand(rule, spec, like.added)
    except (Undrawable, KeyError):
        return None
    labels = [[one.label for one in demand.quantities] for demand in (made, like)]
    return Places(made) if labels[0] == labels[1] else None


def _seen(recording: Recording, evaluator: Evaluator) -> Iterator[Frame]:
    tables, _ = known_tables(recording, evaluator.spec)
    for frame in frames(recording, evaluator, tables):
        for _, one in frame.seen():
            yield one


def thinned(points: Points, axes: Sequence[int], spans: Sequence[tuple[float, float]]) -> Thinned:
    """The samples that are shown; what is against the demand always is."""
    places = np.array(
        [(points.values[number] - low) / (high - low) for number, (low, high) in zip(axes, spans)]
    )
    if len(axes) == 1:
        places = np.array([places[0], np.full(places.shape[1], 0.5)])
    inside = ((places >= 0.0) & (places <= 1.0)).all(axis=0)
    held, broken = points.codes == HOLDS, points.codes == BROKEN
    against = np.unique(np.round(np.clip(places[:, broken], 0.0, 1.0) * PLACES), axis=1) / PLACES
    return Thinned(
        _nearest(places[:, held & inside], points.margins[held & inside]).T,
        against.T,
        (int(held.sum()), int(broken.sum())),
        (int((held & ~inside).sum()), int((broken & ~inside).sum())),
    )


def _nearest(places: Floats, margins: Floats) -> Floats:
    """Of each cell, the place with the least margin; in the order of cells."""
    columns, rows = CELLS
    cells = np.minimum((places[0] * columns).astype(np.intp), columns - 1) + columns * np.minimum((places[1] * rows).astype(np.intp), rows - 1)  # fmt: skip
    order = np.lexsort((places[1], places[0], margins, cells))
    first = np.ones(len(order), dtype=bool)
    first[1:] = cells[order][1:] != cells[order][:-1]
    return places[:, order[first]]
