"""What does not fit the contract, in words, with what to do about it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackmarshal.integration.mapped import HELPERS, Mapped
from trackmarshal.integration.mapping import UNSURE, Column
from trackmarshal.integration.records import placed
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.door.door import Door
from trackmarshal.runtime.faults import name_of
from trackmarshal.scenarios.field.log import MOVING
from trackmarshal.scenarios.field.sides import are_exchanged, exchanged
from trackmarshal.scenarios.inputs import with_default
from trackmarshal.trajectories.rest import cut, first_at_rest

#: A fault at the door -> what to do.
ADVICE = {
    "missing": "send it",
    "wrong_length": "every column has one entry a sample",
    "too_short": "a trajectory has two samples at least; tm.cut_at_rest makes them of one that stands",
    "not_increasing": "times increase from sample to sample; where the car stands, tm.cut_at_rest ends the trajectory",
    "not_finite": "leave out what is not known where it has a default; never send NaN",
    "out_of_range": "is it in the unit that the contract declares?",
    "over_capacity": "declare it in the module `supervisor.limits`, give `limits` at the start, or tm.resample",
    "starts_elsewhere": "both candidates begin where the car is at the stamp; make both from the same pose, in the same cycle",
    "not_at_rest": "an emergency trajectory ends at rest; tm.cut_at_rest ends it there where it creeps on",
    "late": "send a cycle in every period, or declare a larger `longest_gap`; `t_next`, `t_unseen`, `response` and `response_other` of the rules have to cover it, too",
    "repeated": "count every cycle, and stamp it when its data was taken",
    "out_of_order": "send cycles in the order of their stamps",
    "duplicate": "ids tell objects apart; each stands once",
    "bad_border": "a border has two points at least",
    "wrong_track": "name the places of this track with --with",
}  # fmt: skip


#: A car that moved further than this in a cycle, in m, has left where its plan began.
MOVED = 1.0
#: A trajectory that begins later than this after the stamp, in s, has not begun by it: `t_loc` of the rules on trajectories.
BEGUN = 0.01


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that does not fit. level: `broken` (a person has to decide), `convert` (the suggested mapping mends it), `note`."""

    level: str
    about: str
    words: str
    help: str = ""

    def __str__(self) -> str:
        return f"{self.about}: {self.words}" + (f"\n     -> {self.help}" if self.help else "")


def of_structure(made: Mapped) -> Iterator[Finding]:
    """What is not there, what is called otherwise, what has to be converted."""
    if made.stamp is None:
        yield Finding(
            "broken",
            "stamp",
            "no number of the cycle counts its time",
            "stamp every cycle when its data was taken, in s",
        )
    elif made.stamp.converted:
        yield Finding(
            "convert",
            "stamp",
            f"`{made.stamp.column}` is in {made.stamp.unit}, not in s",
            made.stamp.code("stamp"),
        )
    if made.driving is None:
        yield Finding("broken", "driving", "there is no driving trajectory")
    if made.emergency is None:
        yield Finding(
            "broken", "emergency", "no trajectory is called so, or ends at rest in nine of ten cycles",
            "the Supervisor needs one in every cycle that brakes to rest; name it with --emergency PATH",
        )  # fmt: skip
    for path, name, own, others in {
        (p, n): (p, n, a, b) for one in made.founds for p, n, a, b in one.uneven
    }.values():
        yield Finding(
            "broken", path, f"`{name}` has {own} entries, the other columns {others}", ADVICE["wrong_length"]
        )
    for field in ("x", "y", "v"):
        if field not in made.plan:
            yield Finding(
                "broken",
                f"plan.{field}",
                "no column fits by name or numbers",
                "without it nothing can be computed",
            )
    for field in made.computed:
        yield Finding(
            "convert",
            f"plan.{field}",
            "no column fits by name or numbers; it follows from others",
            f"tm.{HELPERS[field]}, or tm.complete for all",
        )
    for where, fields in (
        ("plan", made.plan),
        ("ego", made.ego_fields),
        ("objects", made.object_fields),
        ("obstacles", made.obstacle_fields),
    ):
        for field, column in fields.items():
            yield from _of_column(f"{where}.{field}", column)
    for where, taken in (("objects", made.objects), ("obstacles", made.obstacles)):
        if taken is not None and taken in made.keyed:
            words = f"`{taken}` is a mapping by id, and the contract's is a list of records"
            yield Finding(
                "convert",
                where,
                words,
                f'[{{"id": name, **one}} for name, one in {taken.rpartition(".")[2]}.items()]',
            )
    if made.ego is None:
        yield Finding(
            "broken",
            "ego",
            "no record has x and y near the beginning of the plans",
            "send the pose of the car, as of the stamp",
        )
    else:
        for field in ("heading", "v"):
            if field not in made.ego_fields:
                yield Finding(
                    "broken",
                    f"ego.{field}",
                    f"`{made.ego or 'the cycle'}` has no number that is called like it",
                )
    if made.objects is None and made.no_objects is not None:
        words = f"`{made.no_objects}` is empty in all cycles, so its fields are not known: the adapter raises where it is not"
        yield Finding("note", "objects", words, "take cycles among other vehicles")
    elif made.objects is None and "objects" in made.contract:
        yield Finding(
            "broken", "objects", "no set of other vehicles was found", "send a list, also where it is empty"
        )
    elif made.objects is not None:
        for field in ("id", "heading", "length", "width"):
            if field not in made.object_fields and field in (made.contract["objects"] | {"id"}):
                yield Finding(
                    "broken", f"objects.{field}", f"`{made.objects}` has nothing that is called like it"
                )
    for path, named in placed(made.founds, made.plan).items():
        if path in (made.objects, made.obstacles):
            continue
        words = f"`{path}` has places and speeds as other vehicles have, and is not taken: the adapter would be blind to it"
        if "v" in named:
            yield Finding("broken", "objects", words, "send all that moves in one list")
        else:
            yield Finding("note", "objects", f"`{path}` has places, and is not taken")
    if made.obstacles is None and "obstacles" in made.contract:
        words = "no set of what stands on the road was found; an empty one is taken"
        yield Finding(
            "note", "obstacles", words, "send what perception knows of: cones, barriers, parked vehicles"
        )
    if (made.left is None or made.right is None) and "track" in made.contract:
        yield Finding(
            "broken",
            "track",
            "no two lines of points [x, y] are called left and right",
            "send the borders with the cycle, made once with tm.line",
        )


def _of_column(about: str, column: Column) -> Iterator[Finding]:
    if column.problem:
        yield Finding("broken", about, column.problem)
    elif column.said.endswith(UNSURE):
        yield Finding(
            "note",
            about,
            f"`{column.column}` is taken to be {column.words}: {column.said}",
            "take cycles through a bend, with braking",
        )
    if column.converted and not column.problem:
        yield Finding(
            "convert",
            about,
            f"`{column.column}` is {column.words} ({column.said})",
            column.code(f"{about.partition('.')[0]}[{column.column!r}]"),
        )


def of_motion(made: Mapped, times: Sequence[float]) -> Iterator[Finding]:
    """What the numbers of whole cycles show: where plans begin, how they end, whether they go on."""
    driving = [made.timeline(i, made.driving) for i in range(len(times))]
    emergency = [made.timeline(i, made.emergency) for i in range(len(times))]
    yield from _begins(made, driving)
    yield from _origin(made, driving)
    tails = [(longest, i) for i, p in enumerate(emergency) if (longest := _creeps(p)) is not None]
    if tails:
        longest, place = max(tails)
        yield Finding(
            "convert", "emergency", f"the last step to rest takes up to {longest:.3g} s (cycle {place}); in {len(tails)} cycles more than 2 s, and twice as long as "
            "it takes to brake on as before",
            "no car brakes so: tm.cut_at_rest(columns), before it is sent to the Supervisor and driven",
        )  # fmt: skip
    yield from _repeats(made, driving)
    yield from _sides(made, driving)


def _creeps(plan: dict[str, Any] | None) -> float | None:
    """How long the last step to rest takes, where that is longer than 2 s and cut at rest it is over in less than half; None otherwise, as where all steps are long.

    Samples that stand behind it are no part of it: nothing moves in them.
    """
    if plan is None or not {"t", "x", "y", "v"} <= plan.keys() or len(plan["t"]) < 2 or plan["v"][-1] != 0.0:
        return None
    columns = {name: list(map(float, values)) for name, values in plan.items()}
    rest = first_at_rest(columns["v"])
    if not rest:  # it stands all along
        return None
    step = columns["t"][rest] - columns["t"][rest - 1]
    sooner = columns["t"][rest] - cut(columns).columns["t"][-1]
    return step if step > 2.0 and sooner > step / 2.0 else None


def _sides(made: Mapped, driving: list[dict[str, Any] | None]) -> Iterator[Finding]:
    """Borders on the other side of the plan than they are called after."""
    wrong = looked = 0
    for place, plan in enumerate(driving):
        left, right = made.border(place, made.left), made.border(place, made.right)
        if left is None or right is None or plan is None or not {"x", "y", "heading", "v"} <= plan.keys():
            continue
        if not plan["v"][0] > MOVING or not np.isfinite([left.sum(), right.sum()]).all():
            continue
        found = exchanged(plan["x"][:1], plan["y"][:1], plan["heading"][:1], left, right)
        wrong, looked = wrong + found[0], looked + found[1]
    if are_exchanged(wrong, looked):
        yield Finding(
            "broken", "track", f"`{made.left}` is on the right of the plan and `{made.right}` on its left, in {wrong} of {looked} cycles",
            "exchange them; or, where y is to the right of x (NED, or a left-handed frame), exchange x and y, or turn y round: zones and lines of a track are "
            "where y is to the left",
        )  # fmt: skip


def _repeats(made: Mapped, driving: list[dict[str, Any] | None]) -> Iterator[Finding]:
    """Plans that are those of the cycle before: of a car that creeps they may be, of one that moved on they are not anew."""
    car = _car(made)
    same: list[tuple[int, float]] = []
    for place in range(1, len(driving)):
        a, b, was, here = driving[place - 1], driving[place], car[place - 1], car[place]
        if a is None or b is None or "v" not in b or np.abs(b["v"]).max() <= 0.5:
            continue
        if all(np.array_equal(a[name], b[name], equal_nan=True) for name in ("x", "y", "v")):
            same.append((place, math.nan if was is None or here is None else math.dist(was, here)))
    moved = [(place, way) for place, way in same if way > MOVED]
    if moved:
        far = max(way for _, way in moved)
        words = f"{len(moved)} cycles repeat the plan of the one before (first: cycle {moved[0][0]}), although the car moved by up to {far:.2g} m"
        yield Finding("broken", "driving", words, "plan anew in every cycle, or send none")
    elif same:
        words = f"{len(same)} cycles repeat the plan of the one before (first: cycle {same[0][0]}); the car hardly moved"
        yield Finding("note", "driving", words)


def _car(made: Mapped) -> list[tuple[float, float] | None]:
    """Where the car is in each cycle."""
    found: list[tuple[float, float] | None] = []
    for one in made.founds:
        record = one.records.get(made.ego) if made.ego is not None else None
        if record is None:
            found.append(None)
            continue
        x, y = (made.ego_fields[n] for n in ("x", "y"))
        found.append((x.convert(record.get(x.column, math.nan)), y.convert(record.get(y.column, math.nan))))
    return found


def _begins(made: Mapped, driving: list[dict[str, Any] | None]) -> Iterator[Finding]:
    apart = [
        (math.dist(here, _at_the_stamp(plan)), place)
        for place, (here, plan) in enumerate(zip(_car(made), driving))
        if here is not None and plan is not None and "x" in plan and "y" in plan
    ]
    if apart and max(apart)[0] > 0.5:
        far, place = max(apart)
        yield Finding(
            "note", "plan", f"at the stamp it is {float(np.median([d for d, _ in apart])):.2g} m from the car (median), at most {far:.2g} m (cycle {place})",
            "times count from the stamp: what is due then is where the car is, within the tolerances of S-1-A-3",
        )  # fmt: skip


def _at_the_stamp(plan: dict[str, Any]) -> tuple[float, float]:
    """Where a trajectory is at its time 0, straight between samples; its nearer end where it does not cover that."""
    t = plan.get("t", np.arange(len(plan["x"])))
    x, y = (float(np.interp(0.0, t, plan[name])) for name in ("x", "y"))
    return x, y


def _origin(made: Mapped, driving: list[dict[str, Any] | None]) -> Iterator[Finding]:
    """Whether times count from the stamp, and cover it."""
    times = [(p["t"], place) for place, p in enumerate(driving) if p is not None and "t" in p]
    if not times:
        return
    first = np.array([float(t[0]) for t, _ in times])
    words = f"they begin {-first.max():.3g} to {-first.min():.3g} s before the stamp"
    if made.absolute:
        words = "they begin with the stamp" if np.abs(first).max() <= 1e-3 else words
        yield Finding(
            "convert", "plan.t", f"its times are absolute: {words}", "the contract's count from the stamp of the cycle: t - stamp"
        )  # fmt: skip
    beside = [(t, place) for t, place in times if t[0] > BEGUN or t[-1] < 0.0]
    if beside:
        t, place = beside[0]
        yield Finding(
            "broken", "plan.t", f"in {len(beside)} cycles its times do not cover the stamp (first: cycle {place}, {t[0]:.3g} to {t[-1]:.3g} s)",
            "times count from the stamp of the cycle: what is due at 0 s is where the car is then",
        )  # fmt: skip
    elif not made.absolute and np.abs(first).max() > 1e-9:
        yield Finding("note", "plan.t", words, "what is due at 0 s, at the stamp, is where the car is then")


def of_defaults(made: Mapped, spec: Spec, rules: Sequence[RuleInfo]) -> Iterator[Finding]:
    """What need not be sent, and is not: the contract is kept, and rules judge what nobody said."""
    taken = {
        "plan": {*made.plan, *made.computed},
        "ego": made.ego_fields,
        "objects": made.object_fields,
        "obstacles": made.obstacle_fields,
    }
    # Of what is not there, nothing is left to a default: an empty set is handed on, or it is broken.
    there = {"plan": made.driving, "ego": made.ego, "objects": made.objects, "obstacles": made.obstacles}
    for (signal, field), readers in with_default(spec, rules).items():
        if there[signal] is not None and field not in taken[signal]:
            words = f"nothing is taken for it: the adapter leaves it to the spec's default, which is judged by {', '.join(readers)}"
            yield Finding(
                "note", f"{signal}.{field}", words, "hand it on, unless the default is true of every cycle"
            )


def at_the_door(
    spec: Spec, rules: Sequence[RuleInfo], cycles: Sequence[Cycle], given: set[str]
) -> Iterator[Finding]:
    """The faults that the Supervisor's own door finds in the converted cycles; what was said of whole signals (`given`) is left out."""
    free = replace(Limits.of(spec), oldest=math.inf, clock_tolerance=math.inf)
    door = Door(of_cycles(spec, rules), free)
    seen: dict[tuple[str, str, str], list[Any]] = {}
    for cycle in cycles:
        for one in door.admit(-1, cycle, cycle.t).faults:
            seen.setdefault((name_of(one), one.signal, one.field), []).append((cycle.number, one))
    for (name, signal, field), found in seen.items():
        plan = signal in (DRIVING, EMERGENCY)
        if signal in given or f"{signal}.{field}" in given or (plan and f"plan.{field}" in given):
            continue
        if (
            plan and name == "missing" and given & {"plan.x", "plan.y", "plan.v"}
        ):  # all else follows from them
            continue
        number, first = found[0]
        many = f"in {len(found)} of {len(cycles)} cycles, first in cycle {number}"
        place = "" if first.index is None or name == "over_capacity" else f", at {first.index}"
        about = f"{signal}.{field}" if field else signal
        yield Finding(
            "broken", about, f"{name} ({first.code}) {many}{place}: {first.message}", ADVICE.get(name, "")
        )
