"""What is run: each fault on each track, alone and in traffic, at three places of different speed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from closed_loop import faults_objects, faults_planner, faults_pose, faults_timing
from closed_loop.fault import Fault
from closed_loop.places import TRACKS

#: Stations of the race line, m, where faults begin: a bend of about 18 m/s, a straight at about 35 m/s, the end of the longest straight.
PLACES = {
    "modena": {"slow": 365.0, "middle": 905.0, "fast": 1960.0},
    "berlin": {"slow": 425.0, "middle": 800.0, "fast": 1085.0},
}
#: s from the start of a run to the first cycle that may be faulty.
BEGIN = 2.0

KINDS: tuple[type[Fault], ...] = (
    Fault, *faults_planner.FAULTS, *faults_pose.FAULTS, *faults_objects.FAULTS, *faults_timing.FAULTS,
)  # fmt: skip
FAULTS = {kind.id: kind for kind in KINDS}


@dataclass(frozen=True, order=True)
class Condition:
    """One run."""

    fault: str
    track: str
    traffic: bool
    place: str

    @property
    def name(self) -> str:
        """As results call it."""
        return f"{self.fault}.{self.track}.{'cars' if self.traffic else 'alone'}.{self.place}"

    @property
    def station(self) -> float:
        """Where the fault begins, m."""
        return PLACES[self.track][self.place]


def every() -> Iterator[Condition]:
    """All runs; those of one track follow each other."""
    for track in TRACKS:
        for fault in FAULTS:
            for traffic in (False, True):
                for place in PLACES[track]:
                    yield Condition(fault, track, traffic, place)


def declared() -> list[Condition]:
    """The 24 runs of `make acceptance`: other faults and other conditions one after the other, as many of each."""
    counted = [kind.id for kind in KINDS if kind.id != "none" and not kind.beyond][:24]
    places = tuple(PLACES["modena"])
    return sorted(
        Condition(fault, TRACKS[i % 2], i // 2 % 2 == 1, places[i % 3]) for i, fault in enumerate(counted)
    )
