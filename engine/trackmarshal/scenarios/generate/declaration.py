"""Declarations of scenarios: YAML to what is to be generated. docs/scenarios.md lists all keys."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from trackmarshal.scenarios import content
from trackmarshal.scenarios.generate import document, given, road, rule_truth
from trackmarshal.scenarios.generate.candidates import Braking
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.further import Further
from trackmarshal.scenarios.generate.given import Given
from trackmarshal.scenarios.generate.limits import Vehicle
from trackmarshal.scenarios.generate.motion import Move
from trackmarshal.scenarios.generate.planner import Mistake
from trackmarshal.scenarios.generate.road import Road, Widening
from trackmarshal.scenarios.generate.rule_truth import GivenTruth
from trackmarshal.scenarios.generate.static_truth import Zone
from trackmarshal.scenarios.generate.takeup_truth import Takeup
from trackmarshal.scenarios.generate.vehicle import vehicle as read_vehicle

MAX_CYCLES = 20_000


@dataclass(frozen=True, slots=True)
class Driver:
    """A car's declared motion; it is generated from `item`, which errors point at.

    An `oncoming` car comes the other way. Nothing new is heard of it from begin to end, s, of each of `silent`.
    """

    id: str
    vehicle: Vehicle
    start: tuple[float, float]
    v: float
    acceleration: list[list[float]]
    moves: list[Move]
    oncoming: bool
    silent: list[tuple[float, float]]
    item: Item
    fields: tuple[Given, ...] = ()


class Obstacle(NamedTuple):
    """What stands on the road: its centre's place s and d, and its size, m; it is turned as the road is."""

    id: str
    s: float
    d: float
    length: float
    width: float


@dataclass(frozen=True, slots=True)
class Declaration:
    """A scenario as declared, SI units throughout."""

    name: str
    road: Road
    times: list[float]
    ego: Driver
    others: list[Driver]
    points: int
    horizon: float
    braking: Braking
    takeup: Takeup | None
    mistakes: list[Mistake]
    pose_error: list[list[float]]
    obstacles: list[Obstacle]
    zones: list[Zone]
    speed: float | None
    step: float
    age: float
    params: dict[str, float]
    because: dict[str, str]
    tables: dict[str, list[list[float]]]
    use: tuple[str, ...]
    notes: tuple[str, ...]
    specs: list[tuple[Path, Item]]
    further: Further
    truth: tuple[GivenTruth, ...]


def load(path: Path, shown: str) -> Declaration:
    """Read a scenario declaration and the track it names (relative to it). Raises D120, D124, D126, D150 to D152."""
    item = document.read(content.read(path, shown), shown)
    fields = road.expect(
        item,
        "trackmarshal-scenario",
        ("name", "track", "duration", "step", "vehicle", "ego", "plan", "emergency"),
        (
            *(
                "notes",
                "others",
                "object_age",
                "params",
                "tables",
                "because",
                "use",
                "specs",
                "signals",
                "truth",
            ),
            *("widenings", "obstacles", "limits", "mistakes", "pose_error", "takeup"),
        ),
    )
    track = fields["track"].text()
    if Path(track).is_absolute() or Path(track).suffix not in (".yaml", ".yml"):
        # What comes from elsewhere does not choose any file to be opened and quoted in a message.
        raise fields["track"].wrong(f"`{track}` is no path of a track", "a .yaml file, relative to this one")
    vehicle = read_vehicle(fields["vehicle"], path.parent)
    step = fields["step"].number(0.001, 10.0)
    count = round(fields["duration"].number(step, 36_000.0) / step) + 1
    if count > MAX_CYCLES:
        raise fields["duration"].wrong(
            f"{count} cycles", f"at most {MAX_CYCLES}; shorten it or widen the step"
        )
    times = [round(i * step, 9) for i in range(count)]
    plan = fields["plan"].fields(("points", "horizon"))
    ego = _driver(fields["ego"], vehicle, path.parent, (), ())
    others = [
        _driver(other, vehicle, path.parent, ("id",), ("oncoming", "silent"))
        for other in _list(fields, "others")
    ]
    ids = [other.id for other in others]
    for other in others:
        if ids.count(other.id) > 1:
            raise other.item.wrong(f"the id `{other.id}` stands twice", "ids are unique")
        for place, (begin, end) in enumerate(other.silent):
            overlaps = [since for since, till in other.silent[:place] if begin < till and since < end]
            if overlaps:
                message = f"it is silent from {max(begin, overlaps[0]):g} s on already"
                help_ = "stretches of `silent` do not overlap: write one for both"
                raise other.item.wrong(message, help_)
            if not any(begin < t < end for t in times):
                message = f"no cycle lies between {begin:g} and {end:g} s, so it is heard of in all"
                help_ = f"cycles are {step:g} s apart, from 0 to {times[-1]:g} s"
                raise other.item.wrong(message, help_)
    limits = fields["limits"].fields((), ("speed", "zones")) if "limits" in fields else {}
    widenings = tuple(_widening(item) for item in _list(fields, "widenings"))
    params = fields["params"].any_fields() if "params" in fields else {}
    tables = fields["tables"].any_fields() if "tables" in fields else {}
    obstacles = [_obstacle(item) for item in _list(fields, "obstacles")]
    standing = [obstacle.id for obstacle in obstacles]
    for name, item in zip(standing, _list(fields, "obstacles")):
        if standing.count(name) > 1:
            raise item.wrong(f"the id `{name}` stands twice", "ids are unique")
    further = _further(fields, ego, others)
    truth = rule_truth.entries(list(_list(fields, "truth")))
    return Declaration(
        name=fields["name"].text(),
        road=road.load(path.parent / track, str(Path(shown).parent / track), widenings),
        times=times,
        ego=ego,
        others=others,
        points=plan["points"].count(2, 1000),
        horizon=plan["horizon"].number(0.1, 60.0),
        braking=_braking(fields["emergency"], vehicle),
        takeup=_takeup(fields["takeup"]) if "takeup" in fields else None,
        mistakes=_mistakes([_mistake(item, vehicle) for item in _list(fields, "mistakes")], times, step),
        pose_error=fields["pose_error"].rows() if "pose_error" in fields else [[0.0, 0.0]],
        obstacles=obstacles,
        zones=[_zone(item) for item in _list(limits, "zones")],
        speed=limits["speed"].number(0.5, 200.0) if "speed" in limits else None,
        step=step,
        age=fields["object_age"].number(0.0, 10.0) if "object_age" in fields else 0.0,
        params={name: value.number() for name, value in params.items()},
        because=_because(fields, {*params, *tables}),
        tables={name: value.rows() for name, value in tables.items()},
        use=tuple(value.text() for value in _list(fields, "use")),
        notes=(
            *([f"the vehicle is that of {vehicle.spec}, whose values stand"] if vehicle.spec else []),
            *(value.said() for value in _list(fields, "notes")),
        ),
        specs=_specs(fields, path.parent, further, truth),
        further=further,
        truth=truth,
    )


def _because(fields: dict[str, Item], overridden: set[str]) -> dict[str, str]:
    """Why parameters and tables are overridden, by name."""
    return (
        {name: item.said() for name, item in fields["because"].fields((), sorted(overridden)).items()}
        if "because" in fields
        else {}
    )


def _further(fields: dict[str, Item], ego: Driver, others: list[Driver]) -> Further:
    obstacles = []
    for item in _list(fields, "obstacles"):
        found = item.any_fields()
        if "fields" in found:
            obstacles.append((found["id"].text(), given.fields(found["fields"])))
    return Further(
        given.signals(fields["signals"]) if "signals" in fields else (),
        ego.fields,
        tuple((other.id, other.fields) for other in others),
        tuple(obstacles),
    )


def _specs(
    fields: dict[str, Item], folder: Path, further: Further, truth: tuple[GivenTruth, ...]
) -> list[tuple[Path, Item]]:
    """The specs that signals, fields and rules come from; raises D151 where something is given and none is named."""
    found = given.specs(list(_list(fields, "specs")), folder)
    first = further.first or next((each.item for each in truth), None)
    if first is not None and not found:
        raise first.wrong("no spec says what this is", "name the specs that declare it under `specs`")
    return found


def _list(fields: dict[str, Item], name: str) -> Iterator[Item]:
    """The items of an optional list."""
    if name in fields:
        yield from fields[name].items()


def _driver(
    item: Item, vehicle: Vehicle, folder: Path, needed: tuple[str, ...], optional: tuple[str, ...]
) -> Driver:
    """A car; what is needed and optional beside what every car has: the car under test has no id, comes no other way, and is always heard of."""
    fields = item.fields((*needed, "start"), (*optional, "acceleration", "moves", "fields", "vehicle"))
    start = fields["start"].fields(("s", "d", "v"))
    return Driver(
        id=fields["id"].text() if "id" in fields else "ego",
        vehicle=read_vehicle(fields["vehicle"], folder) if "vehicle" in fields else vehicle,
        start=(start["s"].number(), start["d"].number(-100.0, 100.0)),
        v=start["v"].number(0.5, 200.0),
        acceleration=fields["acceleration"].rows() if "acceleration" in fields else [[0.0, 0.0]],
        moves=_moves(_list(fields, "moves")),
        oncoming=fields["oncoming"].flag() if "oncoming" in fields else False,
        silent=[_silence(stretch) for stretch in _list(fields, "silent")],
        item=item,
        fields=given.fields(fields["fields"]) if "fields" in fields else (),
    )


def _moves(items: Iterator[Item]) -> list[Move]:
    moves: list[Move] = []
    for item in items:
        found = item.fields(("begin", "end", "to"))
        begin, end = found["begin"].number(0.0), found["end"].number(0.0)
        if end <= begin or (moves and begin < moves[-1].end):
            message = f"a move from {begin:g} s to {end:g} s does not fit in"
            raise item.wrong(message, "moves follow each other and take time")
        moves.append(Move(begin, end, found["to"].number(-100.0, 100.0)))
    return moves


def _mistake(item: Item, vehicle: Vehicle) -> Mistake:
    fields = item.fields(("begin", "end"), ("acceleration", "moves", "deceleration"))
    if len(fields) == 2:
        raise item.wrong("nothing is planned otherwise", "give acceleration, moves, deceleration, or several")
    begin, end = fields["begin"].number(0.0), fields["end"].number(0.0)
    if end < begin:
        raise item.wrong(f"it ends at {end:g} s, before it begins", "begin is the first cycle, end the last")
    return Mistake(
        begin,
        end,
        fields["acceleration"].rows() if "acceleration" in fields else None,
        _moves(fields["moves"].items()) if "moves" in fields else None,
        fields["deceleration"].number(0.5, vehicle.brake) if "deceleration" in fields else None,
        item,
    )


def _mistakes(mistakes: list[Mistake], times: list[float], step: float) -> list[Mistake]:
    """Those that are made: one that no cycle makes changes nothing, and of two in one cycle, one would not be made."""
    made: set[float] = set()
    for one in mistakes:
        cycles = {t for t in times if one.is_made(t, step)}
        if not cycles:
            message = f"no cycle lies from {one.begin:g} to {one.end:g} s, so nothing is planned otherwise"
            raise one.item.wrong(message, f"cycles are {step:g} s apart, from 0 to {times[-1]:g} s")
        if made & cycles:
            message = f"in the cycle at {min(made & cycles):g} s, there is another mistake already"
            raise one.item.wrong(
                message, "one mistake may have acceleration, moves and deceleration together"
            )
        made |= cycles
    return mistakes


def _silence(item: Item) -> tuple[float, float]:
    begin, end = _stretch(item)
    if begin < 0.0:
        raise item.wrong("it begins before the recording", "a car has been heard of at 0 s")
    return begin, end


def _stretch(item: Item) -> tuple[float, float]:
    """Two numbers, from and to."""
    numbers = [number.number() for number in item.items()]
    if len(numbers) != 2 or numbers[0] >= numbers[1]:
        raise item.wrong("this is no stretch", "two numbers are expected, from and to: [4, 6]")
    return numbers[0], numbers[1]


def _obstacle(item: Item) -> Obstacle:
    fields = item.fields(("id", "s", "d", "length", "width"), ("fields",))
    return Obstacle(
        fields["id"].text(),
        fields["s"].number(),
        fields["d"].number(-100.0, 100.0),
        fields["length"].number(0.01, 100.0),
        fields["width"].number(0.01, 100.0),
    )


def _zone(item: Item) -> Zone:
    fields = item.fields(("s", "d", "speed"))
    return Zone(_stretch(fields["s"]), _stretch(fields["d"]), fields["speed"].number(0.5, 200.0))


def _widening(item: Item) -> Widening:
    fields = item.fields(("side", "begin", "end", "by", "taper"))
    side, begin, end = fields["side"].text(), fields["begin"].number(0.0), fields["end"].number(0.0)
    if side not in ("left", "right"):
        raise fields["side"].wrong(f"`{side}` is no side", "left or right")
    if end <= begin:
        raise item.wrong(f"from {begin:g} m to {end:g} m", "it ends behind its begin, on the same lap")
    return Widening(side, begin, end, fields["by"].number(0.1, 100.0), fields["taper"].number(1.0, 1000.0))


def _takeup(item: Item) -> Takeup:
    fields = item.fields(("window", "beyond"))
    return Takeup(fields["window"].number(0.0, 5.0), fields["beyond"].number(0.0, 50.0))


def _braking(item: Item, vehicle: Vehicle) -> Braking:
    fields = item.fields(("points", "deceleration", "grip_share"))
    return Braking(
        points=fields["points"].count(2, 1000),
        deceleration=fields["deceleration"].number(0.5, vehicle.brake),
        grip=fields["grip_share"].number(0.1, 1.0) * vehicle.grip,
        drag=vehicle.drag,
    )
