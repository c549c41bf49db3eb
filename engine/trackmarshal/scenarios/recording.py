"""A recording: what the Supervisor saw, cycle by cycle, and what the truth was.

Plain data in SI units: columns are lists of float, heading 0 along +x and counter-clockwise positive, kappa > 0
turns left, a pose is the centre of the vehicle's rectangle.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.units import moment

if TYPE_CHECKING:
    from trackmarshal.runtime.record.reading import Run

#: A trajectory: equally long lists, by name.
Columns = dict[str, list[float]]
#: `left` and `right` are lists of [x, y]; a `closed` track goes on from the last point to the first.
Track = dict[str, Any]

#: What a trajectory has at least, in the order of the formats.
COLUMNS = ("t", "s", "x", "y", "heading", "kappa", "v", "a")
CANDIDATES = (DRIVING, EMERGENCY)
#: Ground truth is given apart for other vehicles, and for the road and the vehicle's own limits.
TRUTHS = ("dynamic", "static")


@dataclass(frozen=True, slots=True)
class Cycle:
    """One cycle of the Supervisor.

    t in s. ego: x, y, heading, v, mostly also kappa and a. objects: each with a text `id`, x, y, heading, v,
    length, width, mostly also age. candidates: columns by name, see CANDIDATES and COLUMNS. more: any other signal that a spec declares, by name. obstacles: those of
    this cycle, where they are others than those of the recording. missing: how many cycles of the run, before it, are not in the recording.
    """

    t: float
    ego: dict[str, float]
    objects: list[dict[str, Any]]
    candidates: dict[str, Columns]
    more: dict[str, Any] = field(default_factory=dict)
    obstacles: list[dict[str, Any]] | None = None
    missing: int = 0


def only(cycle: Cycle, name: str) -> Cycle:
    """The cycle with one of its objects."""
    return replace(cycle, objects=[each for each in cycle.objects if each["id"] == name])


@dataclass(frozen=True, slots=True)
class Recording:
    """Cycles on one track, with parameters and tables that override the spec's, and ground truth.

    ground_truth has one entry a cycle: True is safe, False is unsafe, None leaves any verdict free (the paper,
    section V-D); by kind, and by single rules (`rule one_move of driving for blue`). obstacles stand still for the whole run, but for
    cycles that have others: text `id`, x, y, heading, length, width. `use` names configuration specs to apply. `source`, the path as given, is no part of equality.
    """

    name: str
    source: str = field(compare=False)
    cycles: tuple[Cycle, ...]
    track: Track
    params: dict[str, float] = field(default_factory=dict)
    tables: dict[str, list[list[float]]] = field(default_factory=dict)
    ground_truth: dict[str, tuple[bool | None, ...]] = field(default_factory=dict)
    obstacles: list[dict[str, Any]] = field(default_factory=list)
    use: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    #: Signals besides those of the format that are the same in every cycle that does not give them anew.
    always: dict[str, Any] = field(default_factory=dict)
    #: Fields that the recording has beside what specs declare, by signal (`plan`, `ego`, `objects`, `obstacles`), and `tables`.
    extra: dict[str, tuple[str, ...]] = field(default_factory=dict)
    #: Rules that the ground truth of a kind judges, by name -> the kind, besides those that the generator knows of.
    judged: dict[str, str] = field(default_factory=dict)
    #: Inputs that its cycles did not have, `plan.grip`, and the number that is in all of them instead, in the declared unit.
    given: dict[str, float] = field(default_factory=dict)
    #: Why something is overridden or given: by the name of the parameter, table or input.
    because: dict[str, str] = field(default_factory=dict)
    #: What its cycles were made from besides its own file and data: the values that specs say of vehicles, in full.
    of_specs: str = field(default="", compare=False)
    #: Its parameters and tables that were made in SI, whatever units specs declare: (`params` or `tables`, name).
    in_si: frozenset[tuple[str, str]] = field(default=frozenset(), compare=False)
    #: Whether it was generated from a declaration, and nobody recorded it.
    generated: bool = field(default=False, compare=False)
    #: The record of a run that it was, where it was one, without its cycles: what that says of the spec, the members and the units of then.
    of_run: Run | None = field(default=None, compare=False)

    def standing(self, cycle: Cycle) -> list[dict[str, Any]]:
        """The obstacles of a cycle."""
        return self.obstacles if cycle.obstacles is None else cycle.obstacles

    def signals(self, cycle: Cycle, candidate: str) -> dict[str, Any]:
        """The signals of one check: plan, ego, objects, obstacles, track, and whether it is the emergency plan.

        Nothing is copied; `track` is the same object for every cycle. Raises D144.
        """
        plan = cycle.candidates.get(candidate)
        if plan is None:
            there = " and ".join(cycle.candidates)
            message = f"no candidate `{candidate}` at t = {moment(cycle.t)} s"
            raise TrackmarshalError("D144", message, file=self.source, help=f"there: {there}")
        return {
            "plan": plan,
            "ego": cycle.ego,
            "objects": cycle.objects,
            "obstacles": self.standing(cycle),
            "track": self.track,
            "emergency": candidate == "emergency",
            **self.always,
            **cycle.more,
        }
