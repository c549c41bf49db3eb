"""Geometry on a batch: arguments broadcast and flattened, one call for all cases that share a track."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from functools import cached_property, lru_cache, reduce
from itertools import accumulate
from typing import Any, assert_never

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy import logic, touching
from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime import geometry
from trackmarshal.runtime.lines import Line

Floats = NDArray[np.float64]

#: Prepared borders and lines that are kept; a run has one or two tracks.
KEPT = 32
#: Of more swept footprints than this of a trajectory those are sought that are nearest; of more in all, in a search with bounds.
FEW_FOOTPRINTS = 8
MANY = 400
#: So many footprints of a case are worth a look at which of them are near a box at all.
BOUNDED = 8
#: So many cases are asked by themselves for all their margins, before those of all are worked out.
ASKED = 4
#: With more cases than this it is worth looking for those that are like the one before.
FEW_CASES = 16
_prepared: OrderedDict[tuple[Any, ...], tuple[Any, Any]] = OrderedDict()


def swept_inside(batch: Batch, area: ir.Area, *args: Any) -> tuple[Any, Any]:
    """The worst and the best margin [m] of: a box (two poses, length, width) sweeps nothing but an area."""
    shape = np.broadcast(*args).shape
    if 0 in shape:  # of no object
        return _sides(np.empty(shape))
    owners = _owners(batch, area)
    if len(owners) == 1:
        margin = owners[0].margin_inside(*args).reshape(shape)
    else:
        margin = _ask(batch, area, "margin_inside", args, shape)[0]
    return _sides(_settled(owners, margin, args))


def _settled(owners: Sequence[Any], margin: Any, args: Sequence[Any]) -> Any:
    """Margins of swept footprints in the areas of all cases, or of one that they share: those next to zero are exact."""
    one = len(owners) == 1
    return touching.settled(
        margin, args, lambda at, row: touching.inside(owners[0 if one else at[0]].border, row)
    )


def swept_clear(*args: Any) -> tuple[Any, Any]:
    """The same of: what a box (two poses, length, width) sweeps is clear of another (a pose, length, width)."""
    shape = np.broadcast(*args).shape
    if 0 in shape:
        return _sides(np.empty(shape))
    margin = np.asarray(geometry.boxes_clear(*args))
    return _sides(touching.settled(margin, args, lambda at, row: touching.clear(row)))


def asked_clear(
    conditions: Sequence[Any], by_case: bool, floors: Sequence[Any], *args: Any
) -> tuple[Any, Any, bool]:
    """The same, of which only what may count is worked out, for a `for all` of it; the third value: whether anything was left out.

    conditions: arrays of what must hold for a margin to count; None says nothing. by_case: of the margins of a case that count, only the
    least does, where each is raised to the greatest of `floors`, arrays, if it is below that.
    """
    asked = None
    for condition in conditions:
        if condition is not None:
            asked = condition if asked is None else asked & condition
    if asked is not None and logic.nowhere(asked):
        return logic.INF, logic.INF, True
    shape = np.broadcast(*args).shape
    if 0 in shape:
        return (*_sides(np.empty(shape)), False)
    if asked is not None:
        if logic.full(asked):
            asked = None
        elif np.broadcast_shapes(asked.shape, shape) == shape:
            asked = np.broadcast_to(asked, shape)
        else:  # what does not vary may count for some and not for others
            asked, by_case = None, False
    # A margin that neither case nor element changes is one number, of no shape.
    by_case = by_case and shape != () and math.prod(shape) >= BOUNDED * shape[0]
    floor = None
    if by_case and floors:
        floor = reduce(np.maximum, floors)
        by_case = np.broadcast_shapes(floor.shape, shape) == shape
    margin = geometry.least_clear(args, asked, by_case, floor)
    margin = touching.settled(margin, args, lambda at, row: touching.clear(row))
    return (*_sides(margin), by_case or asked is not None)


def in_area(batch: Batch, area: ir.Area, x: Any, y: Any) -> tuple[Any, Any]:
    """The same of: a point is in an area."""
    shape = np.broadcast(x, y).shape
    return _sides(
        _ask(batch, area, "signed_distance", (x, y), shape)[0] if 0 not in shape else np.empty(shape)
    )


def _sides(margin: Any) -> tuple[Any, Any]:
    """The worst and the best margin of signed distances; NaN is none."""
    known = np.equal(margin, margin)  # NaN is not
    return (margin, margin) if logic.full(known) else logic.partly(margin, known)


class Least:
    """The margins of a predicate of which only the least along an axis is asked, and all of them on demand."""

    def __init__(
        self, exactly: Callable[[], Any], alone: Callable[[int], tuple[Any, Any]], few: bool = False
    ) -> None:
        """`exactly` gives all margins, `alone` the worst and the best ones of a single case. few: no case is asked by itself."""
        self._exactly, self._alone, self._few = exactly, alone, few
        self._asked: dict[int, logic.Value] = {}

    @cached_property
    def value(self) -> logic.Value:
        """The predicate's value everywhere; worked out when first asked for."""
        return logic.value(*_sides(self._exactly()), logic.AT_LEAST)

    def about(self, case: int) -> logic.Value:
        """The predicate's value in a case, or everywhere, once some have been asked for: of a long run mostly the worst cycle is."""
        if self._few or (case not in self._asked and len(self._asked) >= ASKED):
            return self.value
        found = self._asked.get(case)
        if found is None:
            found = self._asked[case] = logic.value(*self._alone(case), logic.AT_LEAST)
        return found

    def is_of_one(self, case: int) -> bool:
        """Whether what is said about a case is of that case alone."""
        return case in self._asked


def least(batch: Batch, area: ir.Area, *args: Any, axis: int, mask: Any) -> tuple[Any, Any, Least | None]:
    """The worst and the best margin of swept footprints in an area, of which only the least along an axis counts.

    Those that are greater than the least may differ from the truth. The third value knows the truth; None: the first two do.
    """
    shape = np.broadcast(*args).shape
    size = shape[axis] if shape else 1  # what all cases share may be one footprint
    if size <= FEW_FOOTPRINTS or math.prod(shape[axis:]) > size:
        return (*swept_inside(batch, area, *args), None)
    owners = _owners(batch, area)
    if len(owners) > 1:
        return (*swept_inside(batch, area, *args), None)
    counted = np.ones(shape, dtype=np.bool_) if mask is None else np.broadcast_to(mask, shape)
    flat: Any
    if math.prod(shape) <= MANY:
        flat, exact = owners[0].nearest_inside(args, size, counted.reshape(-1)), None
        if flat is None:
            return (*swept_inside(batch, area, *args), None)
    else:
        flat, exact = owners[0].least_inside(args, size, counted.reshape(-1))
    # What is next to zero is the least of its trajectory, or as good as: all that counts is exact there, and none is left out.
    margin = _settled(owners, flat.reshape(shape), args)

    def exactly() -> Any:
        if exact is None:
            return _settled(owners, owners[0].margin_inside(*args).reshape(shape), args)
        made = margin.copy()
        places = (~exact).nonzero()[0]
        body = (_flat(arg, shape) for arg in args)
        made.ravel()[places] = owners[0].margin_inside(
            *(arg if arg.ndim == 0 else arg[places] for arg in body)
        )
        return _settled(owners, made, args)

    def alone(case: int) -> tuple[Any, Any]:
        rows = (
            arg[case : case + 1] if arg.shape[:1] == shape[:1] and arg.ndim == len(shape) else arg
            for arg in args
        )
        return swept_inside(batch, area, *rows)

    return (*_sides(margin), Least(exactly, alone, exact is None))


def within(batch: Batch, area: ir.Area, x: Any, y: Any) -> tuple[Any, Any]:
    """Whether points are in an area, as margins that are infinite; cheap for points that are nowhere near it."""
    shape = np.broadcast(x, y).shape
    if 0 not in shape and not any(owner.near(x, y) for owner in _owners(batch, area)):
        margin = np.full(shape, -np.inf)
        return margin, margin
    worst, best = in_area(batch, area, x, y)
    decided = np.where(worst >= 0.0, np.inf, -np.inf)
    return decided, decided if best is worst else np.where(best >= 0.0, np.inf, -np.inf)


def project(batch: Batch, line: ir.Line, *points: tuple[Any, Any]) -> list[tuple[Any, ...]]:
    """Stations, offsets and directions along a line, of points x, y: of several arrays of points, asked about at once."""
    shapes = [np.broadcast(x, y).shape for x, y in points]
    owners = _owners(batch, line)
    if len(owners) > 1 or len(points) == 1:
        return [_projected(batch, line, point, shape) for point, shape in zip(points, shapes)]
    many = batch.size > FEW_CASES and all(shape[:1] == (batch.size,) for shape in shapes)
    size = batch.size if many else 1
    x, y = (
        np.concatenate([_all(p[k], shape).reshape(size, -1) for p, shape in zip(points, shapes)], axis=1)
        for k in (0, 1)
    )
    shape = x.shape
    x, y = x.reshape(-1), y.reshape(-1)
    if many:
        new, like = _repeated(x.reshape(shape), y.reshape(shape))
        answers = [part.take(like) for part in owners[0].project(x.take(new), y.take(new))]
    else:
        answers = [part.reshape(shape) for part in owners[0].project(x, y)]
    ends = list(accumulate(math.prod(shape) // size for shape in shapes))
    return [
        tuple(part[:, begin:end].reshape(shape) for part in answers)
        for begin, end, shape in zip([0, *ends], ends, shapes)
    ]


def _repeated(x: Floats, y: Floats) -> tuple[Any, Any]:
    """Of points (cases, n): the places, flattened, of those that differ in any bit from the same one of the case before, and for every point which
    of those it is like. A driving and an emergency trajectory see the same objects."""
    new = np.ones(x.shape, dtype=np.bool_)
    new[1:] = False
    for bits in (x.view(np.int64), y.view(np.int64)):
        new[1:] |= bits[1:] != bits[:-1]
    number = new.reshape(-1).cumsum().reshape(x.shape) - 1
    return new.reshape(-1).nonzero()[0], np.maximum.accumulate(np.where(new, number, 0), axis=0)


def _projected(
    batch: Batch, line: ir.Line, point: tuple[Any, Any], shape: tuple[int, ...]
) -> tuple[Any, ...]:
    return _ask(batch, line, "project", point, shape) if 0 not in shape else (np.empty(shape),) * 3


def distance(batch: Batch, line: ir.Line, x: Any, y: Any) -> Any:
    """Distances of points from a line."""
    shape = np.broadcast(x, y).shape
    if 0 in shape:
        return np.empty(shape)
    if line.kind == "path":
        return _to_paths(batch, line.name, (x, y), shape)
    return _ask(batch, line, "distance", (x, y), shape)[0]


def gap(batch: Batch, line: ir.Line, start: Any, end: Any) -> Any:
    """How far stations of a line lie ahead of others."""
    shape = np.broadcast(start, end).shape
    if 0 in shape:
        return np.empty(shape)
    owners = _owners(batch, line)
    if len(owners) == 1:  # number by number, of any shape
        return owners[0].gap(start, end).reshape(shape)
    return _ask(batch, line, "gap", (start, end), shape)[0]


def stretch_room(batch: Batch, line: ir.Line, station: Any, start: Any, end: Any) -> Any:
    """How far inside stretches of a line stations lie."""
    shape = np.broadcast(station, start, end).shape
    if 0 in shape:
        return np.empty(shape)
    return _ask(batch, line, "stretch_room", (station, start, end), shape)[0]


def fault(batch: Batch, index: int, area: ir.Area) -> str | None:
    """What makes an area unusable in one case."""
    owners = _owners(batch, area)
    text: str | None = owners[index if len(owners) > 1 else 0].fault
    return text


def _ask(
    batch: Batch, place: ir.Area | ir.Line, method: str, args: Sequence[Any], shape: tuple[int, ...]
) -> tuple[Any, ...]:
    """What a prepared place answers about flattened arguments: once if all cases share it, else case by case."""
    owners = _owners(batch, place)
    if len(owners) == 1:
        answer = getattr(owners[0], method)(*(_flat(arg, shape) for arg in args))
        return tuple(part.reshape(shape) for part in _parts(answer))
    shape = (batch.size, *(shape[1:] or (1,) * (batch.rank - 1)))
    whole = [arg if np.ndim(arg) == 0 else np.broadcast_to(arg, shape) for arg in args]
    rows = []
    for index, owner in enumerate(owners):
        answer = getattr(owner, method)(*(arg if np.ndim(arg) == 0 else arg[index].ravel() for arg in whole))
        rows.append([np.reshape(part, shape[1:]) for part in _parts(answer)])
    return tuple(np.stack(parts) for parts in zip(*rows))


def _flat(arg: Any, shape: tuple[int, ...]) -> Any:
    """An argument as a vector; a number stays one."""
    return arg if arg.ndim == 0 else _all(arg, shape)


def _all(arg: Any, shape: tuple[int, ...]) -> Any:
    return (arg if arg.shape == shape else np.broadcast_to(arg, shape)).reshape(-1)


def _parts(answer: Any) -> tuple[Any, ...]:
    return answer if isinstance(answer, tuple) else (answer,)


def _owners(batch: Batch, place: ir.Area | ir.Line) -> list[Any]:
    """The prepared object of every case, or a single one that all of them share."""
    owners = batch.owners.get(place)
    if owners is None:
        prepare = _area if isinstance(place, ir.Area) else _line
        given = _given(batch, place)
        if given.count(given[0]) == len(given):
            owners = [prepare(batch, 0, place)]  # type: ignore[arg-type]
        else:
            made: dict[Any, Any] = {}
            for index, data in enumerate(given):
                if data not in made:
                    made[data] = prepare(batch, index, place)  # type: ignore[arg-type]
            owners = [made[data] for data in given]
        batch.owners[place] = owners
    return owners


def _given(batch: Batch, place: ir.Area | ir.Line) -> list[Hashable]:
    """What each case has that the object of a place is made from: the same for those that share it."""
    name, cases = place.name, batch.cases
    match place.kind:
        case "zone" | "place":
            own = batch.spec.places[name].points
            return [id(case.settings.places.get(name, own)) for case in cases]
        case "corridor" | "centre":
            if name not in batch.roads:
                left, right = (name, "left"), (name, "right")
                batch.roads[name] = [
                    (id(c.lines[left]), id(c.lines[right]), c.closed.get(name, False)) for c in cases
                ]
            return batch.roads[name]
        case "signal":
            assert isinstance(place, ir.Line)
            line = name, place.field
            return [(id(case.lines[line]), case.closed.get(name, False)) for case in cases]
        case "path":
            return list(range(len(cases)))
        case _:
            assert_never(place.kind)


def _keep(batch: Batch, key: tuple[Any, ...], owner: Any, make: Callable[[], Any]) -> Any:
    """A prepared object for data that is the same object as before; `owner` keeps that data alive, so ids stay unique.

    The batch keeps all of its own, however many tracks it has; the last ones stay for the batches to come.
    """
    held = batch.prepared.get(key)
    if held is None:
        held = _prepared.get(key) or (owner, make())
        batch.prepared[key] = _prepared[key] = held
        _prepared.move_to_end(key)
        while len(_prepared) > KEPT:
            _prepared.popitem(last=False)
    return held[1]


def _corridor(batch: Batch, index: int, name: str) -> geometry.Corridor:
    left, right, closed = batch.cases[index].corridor(name)
    return _road(batch, left, right, closed)


def lane(batch: Batch, left: Line, right: Line) -> geometry.Corridor:
    """The road between the borders of a lane, open at both ends."""
    return _road(batch, left, right, False)


def _road(batch: Batch, left: Line, right: Line, closed: bool) -> geometry.Corridor:
    made: geometry.Corridor = _keep(
        batch, ("corridor", id(left), id(right), closed), (left, right),
        lambda: _between(left.points.tobytes(), right.points.tobytes(), closed),
    )  # fmt: skip
    return made


@lru_cache(maxsize=KEPT)
def _between(left: bytes, right: bytes, closed: bool) -> geometry.Corridor:
    """The road between borders of these points: many runs on one track have lines of their own, and it takes longest of all to prepare."""
    borders = [np.frombuffer(border, dtype=np.float64).reshape(-1, 2) for border in (left, right)]
    return geometry.Corridor(borders[0], borders[1], closed)


def polyline(batch: Batch, line: Line) -> geometry.Polyline:
    """A border of a lane."""
    made: geometry.Polyline = _keep(
        batch, ("line", id(line), False), line, lambda: geometry.Polyline(line.points, False)
    )
    return made


def _area(batch: Batch, index: int, area: ir.Area) -> geometry.Polygon | geometry.Corridor:
    if area.kind == "corridor":
        return _corridor(batch, index, area.name)
    points = batch.cases[index].settings.places.get(area.name, batch.spec.places[area.name].points)
    polygon: geometry.Polygon = _keep(
        batch, ("polygon", id(points)), points, lambda: geometry.Polygon(_points(points))
    )
    return polygon


def _line(batch: Batch, index: int, line: ir.Line) -> geometry.Polyline:
    case = batch.cases[index]
    points: Any
    match line.kind:
        case "place":
            points, closed = case.settings.places.get(line.name, batch.spec.places[line.name].points), False
        case "signal":
            points, closed = case.line(line.name, line.field), case.closed.get(line.name, False)
        case "path":
            columns = batch.own(line.name)[index]
            points = np.stack([columns.column("x"), columns.column("y")], axis=1)
            return geometry.Polyline(points, False)
        case "centre":
            centre: geometry.Polyline = _corridor(batch, index, line.name).centre
            return centre
        case _:
            assert_never(line.kind)
    made: geometry.Polyline = _keep(
        batch, ("line", id(points), closed), points, lambda: geometry.Polyline(_points(points), closed)
    )
    return made


def _points(points: Any) -> Floats:
    return points.points if isinstance(points, Line) else np.asarray(points, dtype=np.float64).reshape(-1, 2)


def _to_paths(batch: Batch, signal: str, args: Sequence[Any], shape: tuple[int, ...]) -> Any:
    """Distances of points to the paths of trajectories, all cases at once: (cases, points) against (cases, segments)."""
    shape = (batch.size, *(shape[1:] or (1,) * (batch.rank - 1)))
    points = np.empty((2, *shape))
    points[0], points[1] = args
    x, y = points.reshape(2, batch.size, -1)
    distance = geometry.distance_to_paths(
        x, y, batch.table(signal, "x"), batch.table(signal, "y"), batch.lengths(signal)
    )
    return distance.reshape(shape)
