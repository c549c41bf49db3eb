"""What rules over the run say in every cycle of a piece, and about which cycles: as `over_run.outcome` has it, on arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.logic import Value
from trackmarshal.backends.numpy.whole.elements import Indices
from trackmarshal.backends.numpy.whole.values import Bools, Floats, pairs
from trackmarshal.backends.over_run.outcome import RANK
from trackmarshal.runtime.verdict import VERDICTS, About

Codes = NDArray[np.uint8]
#: Codes of verdicts: their places in VERDICTS.
SATISFIED, VIOLATED, UNDEFINED, INACTIVE, OPEN = (
    np.uint8(VERDICTS.index(name)) for name in ("satisfied", "violated", "undefined", "inactive", "open")
)
#: What cycles say of themselves that are decided at once: nothing beside what is decided in them.
OTHER = INACTIVE
if VIOLATED != SATISFIED + 1:
    raise AssertionError("codes of verdicts are no longer counted on from that of what is satisfied")
#: By code, how bad a verdict is: 0 the worst.
BADNESS = np.array([RANK.index(name) for name in VERDICTS], dtype=np.uint8)
#: By how bad one is, its code.
_OF_BADNESS = np.argsort(BADNESS).astype(np.uint8)


@dataclass(eq=False)
class Saying:
    """What is said in some cycles about some, in the order in which it is said: (said,) each. cycle, about: their numbers, counted from the first
    of the run; codes: of verdicts; final: nothing to come can change the margin [SI]."""

    cycle: Indices
    about: Indices
    codes: Codes
    margins: Floats
    final: NDArray[np.bool_]

    def blocked(self, where: Bools, first: int) -> Saying:
        """The same, but in some cycles, counted from the number of the first, nothing is said but that each itself is undefined, and stays so."""
        blocked = where[self.cycle - first]
        kept = ~blocked | (self.about == self.cycle)
        blocked = blocked[kept]
        return Saying(
            self.cycle[kept], self.about[kept], np.where(blocked, UNDEFINED, self.codes[kept]),
            np.where(blocked, np.nan, self.margins[kept]), self.final[kept] | blocked,
        )  # fmt: skip

    def listed(self, name: Callable[[int], object] = int) -> list[tuple[int, About]]:
        """In which cycle what is said, in order, with cycles by what they are called."""
        every = zip(
            *(each.tolist() for each in (self.cycle, self.about, self.codes, self.margins, self.final))
        )
        return [
            (cycle, About(name(about), VERDICTS[code], margin, final))
            for cycle, about, code, margin, final in every
        ]


#: What is said, worked out when it is asked for; None: of each cycle about itself.
Said = Callable[[], Saying] | None


class Outcome(NamedTuple):
    """What a rule says in the cycles of a piece: codes of verdicts and margins, (cycles,); said: about which cycles, worked out when it is asked for; None: each about itself."""

    codes: Codes
    margins: Floats
    said: Said

    def blocked(self, where: Bools, first: int) -> Outcome:
        """The same, but undefined in some cycles, which say so of themselves alone. first: the number of the first cycle."""
        codes, margins = self.codes.copy(), self.margins.copy()
        codes[where], margins[where] = UNDEFINED, np.nan
        said = self.said
        return Outcome(codes, margins, None if said is None else lambda: said().blocked(where, first))


def following(parts: Sequence[Said]) -> Said:
    """What is said in cycles that follow one another."""
    given = [part for part in parts if part is not None]
    if not given:
        return None
    if len(given) != len(parts):
        raise AssertionError("a rule is decided at once, or it is not")

    def said() -> Saying:
        found = [part() for part in given]
        cycle, about = (
            np.concatenate([one.cycle for one in found]),
            np.concatenate([one.about for one in found]),
        )
        codes, margins = (
            np.concatenate([one.codes for one in found]),
            np.concatenate([one.margins for one in found]),
        )
        return Saying(cycle, about, codes, margins, np.concatenate([one.final for one in found]))

    return said


def decided(value: Value) -> tuple[Codes, Floats]:
    """(cycles,): the verdict that a value is, and the margin that is sure; a margin of zero is 0.0."""
    worst, best = pairs(value)
    if best is worst:
        # Of two codes that follow one another: numpy chooses between bytes as slowly as it does between numbers.
        return np.subtract(VIOLATED, worst[0], dtype=np.uint8), worst[1] + 0.0
    codes, margins = np.where(worst[0], SATISFIED, VIOLATED), np.where(worst[0], worst[1], best[1])
    margins += 0.0
    unsure = best[0] & ~worst[0]
    codes[unsure], margins[unsure] = UNDEFINED, np.nan
    return codes, margins


def agree(holds: Bools, margins: Floats) -> bool:
    """Whether no margin of what holds is below zero, and none of what does not above it; of `iff` and `xor` they may be."""
    apart = np.flatnonzero((margins > 0.0) != holds)
    return not margins.take(apart).any()


def at_once(formula: Value, active: Value | None) -> tuple[Codes, Floats]:
    """(cycles,): what a rule comes to that is settled in its own cycle."""
    codes, margins = decided(formula)
    if active is not None:
        idle = ~pairs(active)[1][0]
        codes[idle], margins[idle] = INACTIVE, np.inf
    return codes, margins


def together(own: Codes, place: Indices, codes: Codes, margins: Floats) -> tuple[Codes, Floats]:
    """(cycles,): the worst of what is said in each cycle, about itself or earlier ones: in which cycle (its place), the verdict, the margin. own:
    (cycles,) what each says of itself that is not decided in it, OPEN or UNDEFINED; OTHER: something is said of it."""
    count, waits = len(own), own != OTHER
    if count == len(place) and not waits.any():
        return codes, margins  # each says of itself alone
    if not (codes <= VIOLATED).all() or (own == UNDEFINED).any() or not agree(codes == SATISFIED, margins):
        return worst((own, np.where(waits, np.nan, np.inf)), place, codes, margins)
    # What is violated has the lesser margins, so that the least of all is one of the worst.
    least = np.full(count, np.inf)
    np.minimum.at(least, place, margins)
    violated = least < 0.0
    if not least.all():  # a margin of zero says nothing
        violated[place.compress(codes == VIOLATED)] = True
    open_ = waits > violated
    least[np.flatnonzero(open_)] = np.nan
    found = np.add(violated, SATISFIED, dtype=np.uint8)
    found += (OPEN - SATISFIED) * open_
    return found, least


def worst(own: tuple[Codes, Floats], place: Indices, codes: Codes, margins: Floats) -> tuple[Codes, Floats]:
    """(cycles,): of what each cycle says about itself, and what is decided in it of earlier ones (its place, the verdict, the margin), the worst.
    What `own` is made of becomes it."""
    bad, before = BADNESS.take(codes), BADNESS.take(own[0])
    least = before.copy()
    np.minimum.at(least, place, bad)
    worse = np.flatnonzero(least != before)
    own[0][worse], own[1][worse] = _OF_BADNESS.take(least.take(worse)), np.inf
    # Margins that are none stay so: of one verdict all or none are.
    said = np.flatnonzero(bad == least.take(place))
    with np.errstate(invalid="ignore"):
        np.minimum.at(own[1], place.take(said), margins.take(said))
    return own
