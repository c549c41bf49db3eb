"""Declarations of scenarios: YAML to what is to be generated. docs/scenarios.md lists all keys."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from trackmarshal.scenarios import content
from trackmarshal.scenarios.generate import document, road
from trackmarshal.scenarios.generate.candidates import Braking
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.limits import Vehicle
from trackmarshal.scenarios.generate.motion import Move
from trackmarshal.scenarios.generate.road import Road

MAX_CYCLES = 20_000


@dataclass(frozen=True, slots=True)
class Driver:
    """A car's declared motion; it is generated from `item`, which errors point at."""

    id: str
    vehicle: Vehicle
    start: tuple[float, float]
    v: float
    acceleration: list[list[float]]
    moves: list[Move]
    item: Item


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
    age: float
    params: dict[str, float]
    tables: dict[str, list[list[float]]]
    use: tuple[str, ...]
    notes: tuple[str, ...]


def load(path: Path, shown: str) -> Declaration:
    """Read a scenario declaration and the track it names (relative to it). Raises D120, D124, D126, D150 to D152."""
    item = document.read(content.read(path, shown), shown)
    fields = item.fields(
        ("format", "version", "name", "track", "duration", "step", "vehicle", "ego", "plan", "emergency"),
        ("notes", "others", "object_age", "params", "tables", "use"),
    )
    road.expect(fields, "trackmarshal-scenario")
    track = fields["track"].text()
    vehicle = _vehicle(fields["vehicle"])
    step = fields["step"].number(0.001, 10.0)
    count = round(fields["duration"].number(step, 36_000.0) / step) + 1
    if count > MAX_CYCLES:
        raise fields["duration"].wrong(
            f"{count} cycles", f"at most {MAX_CYCLES}; shorten it or widen the step"
        )
    plan = fields["plan"].fields(("points", "horizon"))
    others = [_driver(other, vehicle) for other in (fields["others"].items() if "others" in fields else ())]
    ids = [other.id for other in others]
    for other in others:
        if ids.count(other.id) > 1:
            raise other.item.wrong(f"the id `{other.id}` stands twice", "ids are unique")
    params = fields["params"].any_fields() if "params" in fields else {}
    tables = fields["tables"].any_fields() if "tables" in fields else {}
    return Declaration(
        name=fields["name"].text(),
        road=road.load(path.parent / track, str(Path(shown).parent / track)),
        times=[round(i * step, 9) for i in range(count)],
        ego=_driver(fields["ego"], vehicle),
        others=others,
        points=plan["points"].count(2, 1000),
        horizon=plan["horizon"].number(0.1, 60.0),
        braking=_braking(fields["emergency"], vehicle),
        age=fields["object_age"].number(0.0, 10.0) if "object_age" in fields else 0.0,
        params={name: value.number() for name, value in params.items()},
        tables={name: value.rows() for name, value in tables.items()},
        use=tuple(value.text() for value in (fields["use"].items() if "use" in fields else ())),
        notes=tuple(value.text() for value in (fields["notes"].items() if "notes" in fields else ())),
    )


def _vehicle(item: Item) -> Vehicle:
    fields = item.fields(("length", "width", "turn_radius", "brake", "grip", "drive"))
    return Vehicle(
        length=fields["length"].number(0.1, 50.0),
        width=fields["width"].number(0.1, 10.0),
        turn_radius=fields["turn_radius"].number(0.1, 1000.0),
        brake=fields["brake"].number(0.1, 100.0),
        grip=fields["grip"].number(0.1, 100.0),
        drive=fields["drive"].rows(),
    )


def _driver(item: Item, vehicle: Vehicle) -> Driver:
    fields = item.fields(("start",), ("id", "acceleration", "moves"))
    start = fields["start"].fields(("s", "d", "v"))
    moves: list[Move] = []
    for move in fields["moves"].items() if "moves" in fields else ():
        found = move.fields(("begin", "end", "to"))
        begin, end = found["begin"].number(0.0), found["end"].number(0.0)
        if end <= begin or (moves and begin < moves[-1].end):
            message = f"a move from {begin:g} s to {end:g} s does not fit in"
            raise move.wrong(message, "moves follow each other and take time")
        moves.append(Move(begin, end, found["to"].number(-100.0, 100.0)))
    return Driver(
        id=fields["id"].text() if "id" in fields else "ego",
        vehicle=vehicle,
        start=(start["s"].number(), start["d"].number(-100.0, 100.0)),
        v=start["v"].number(0.5, 200.0),
        acceleration=fields["acceleration"].rows() if "acceleration" in fields else [[0.0, 0.0]],
        moves=moves,
        item=item,
    )


def _braking(item: Item, vehicle: Vehicle) -> Braking:
    fields = item.fields(("points", "deceleration", "grip_share"))
    return Braking(
        points=fields["points"].count(2, 1000),
        deceleration=fields["deceleration"].number(0.5, vehicle.brake),
        grip=fields["grip_share"].number(0.1, 1.0) * vehicle.grip,
    )
