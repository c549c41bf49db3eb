"""Geometry on a batch: arguments broadcast and flattened, one call for all cases that share a track."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy import logic
from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime import geometry

Floats = NDArray[np.float64]

#: Prepared borders and lines that are kept; a run has one or two tracks.
KEPT = 32
_prepared: OrderedDict[tuple[Any, ...], tuple[Any, Any]] = OrderedDict()


def predicate(batch: Batch, node: ir.Geometry, args: Sequence[Any]) -> logic.Value:
    """A geometric predicate: its signed distance, holding where that is not negative."""
    shape = np.broadcast_shapes(*(np.shape(arg) for arg in args))
    if 0 in shape:  # of no object
        return logic.defined(np.empty(shape, dtype=np.bool_), np.empty(shape))
    if node.what == "swept_clear":
        margin = geometry.boxes_clear(*args)
    else:
        assert node.area is not None
        area = node.area
        if node.what == "in_area":
            margin = _by_case(batch, args, lambda c: _polygon(batch, c, area).signed_distance)
        elif area.kind == "zone":
            margin = _by_case(batch, args, lambda c: _polygon(batch, c, area).margin_inside)
        else:
            margin = _by_case(batch, args, lambda c: _corridor(batch, c, area.name).margin_inside)
    margin = np.asarray(margin)
    known = ~np.isnan(margin)
    if known.all():
        return logic.defined(margin >= 0.0, margin)
    return logic.partly(margin >= 0.0, margin, known)


def along(batch: Batch, node: ir.Along, args: Sequence[Any]) -> Any:
    """A number read off a line."""
    shape = np.broadcast_shapes(*(np.shape(arg) for arg in args))
    if 0 in shape:
        return np.empty(shape)
    line = node.line
    if line.kind == "path" and node.what == "distance":
        return _to_paths(batch, line.name, args)
    if node.what == "station_gap":
        return _by_case(batch, args, lambda c: _line(batch, c, line).gap)
    if node.what == "distance":
        return _by_case(batch, args, lambda c: _line(batch, c, line).distance)
    part = ("station", "offset", "direction").index(node.what)
    # Station, offset and direction of one point are three nodes; the projection is made once.
    key = (line, *(id(arg) for arg in args))
    known = batch.projections.get(key)
    if known is None:
        known = batch.projections[key] = (args, _by_case(batch, args, lambda c: _line(batch, c, line).project, parts=3))
    return known[1][part]


def fault(batch: Batch, index: int, area: ir.Area) -> str | None:
    """What makes an area unusable in one case."""
    prepared = _polygon(batch, index, area) if area.kind == "zone" else _corridor(batch, index, area.name)
    text: str | None = prepared.fault
    return text


def _by_case(batch: Batch, args: Sequence[Any], method: Callable[[int], Callable[..., Any]], parts: int = 1) -> Any:
    """Call a prepared object's method on flattened arguments, case by case unless all cases share the object."""
    arrays = list(np.broadcast_arrays(*args))
    shape = arrays[0].shape
    methods = [method(index) for index in range(batch.size)]
    owners = {id(getattr(m, "__self__", m)) for m in methods}
    if len(owners) == 1:
        return _shaped(methods[0](*(a.ravel() for a in arrays)), shape, parts)
    if not shape or shape[0] == 1:
        shape = (batch.size, *(shape[1:] if shape else (1,) * (batch.rank - 1)))
        arrays = [np.broadcast_to(a, shape) for a in arrays]
    rows = [_shaped(methods[i](*(a[i].ravel() for a in arrays)), shape[1:], parts) for i in range(batch.size)]
    if parts == 1:
        return np.stack(rows)
    return tuple(np.stack([row[part] for row in rows]) for part in range(parts))


def _shaped(result: Any, shape: tuple[int, ...], parts: int) -> Any:
    if parts == 1:
        return np.asarray(result).reshape(shape)
    return tuple(np.asarray(part).reshape(shape) for part in result)


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
    case = batch.cases[index]
    left, right, closed = case.lines[name, "left"], case.lines[name, "right"], case.closed.get(name, False)
    key = ("corridor", id(left), id(right), closed)
    corridor: geometry.Corridor = _keep(batch, key, (left, right), lambda: geometry.Corridor(_points(left), _points(right), closed))
    return corridor


def _polygon(batch: Batch, index: int, area: ir.Area) -> geometry.Polygon:
    points = batch.cases[index].places.get(area.name, batch.spec.places[area.name].points)
    polygon: geometry.Polygon = _keep(batch, ("polygon", id(points)), points, lambda: geometry.Polygon(_points(points)))
    return polygon


def _line(batch: Batch, index: int, line: ir.Line) -> geometry.Polyline:
    case = batch.cases[index]
    points: Any
    match line.kind:
        case "place":
            points, closed = case.places.get(line.name, batch.spec.places[line.name].points), False
        case "signal":
            points, closed = case.lines[line.name, line.field], case.closed.get(line.name, False)
        case "path":
            columns = case.columns[line.name]
            points = np.stack([np.asarray(columns["x"], dtype=float), np.asarray(columns["y"], dtype=float)], axis=1)
            return geometry.Polyline(points, False)
        case "centre":
            centre: geometry.Polyline = _corridor(batch, index, line.name).centre
            return centre
        case _:
            raise AssertionError(f"unknown line {line.kind}")
    made: geometry.Polyline = _keep(batch, ("line", id(points), closed), points, lambda: geometry.Polyline(_points(points), closed))
    return made


def _points(points: Any) -> Floats:
    return np.asarray(points, dtype=np.float64).reshape(-1, 2)


def _to_paths(batch: Batch, signal: str, args: Sequence[Any]) -> Any:
    """Distances of points to the paths of trajectories, all cases at once: (cases, 1, ...) against (cases, segments)."""
    x, y = np.broadcast_arrays(*args)
    lengths = batch.lengths(signal)
    px, py = batch.table(signal, "x"), batch.table(signal, "y")
    flat_x = np.broadcast_to(x.reshape(x.shape[0] if x.ndim else 1, -1), (batch.size, max(1, x.size // (x.shape[0] if x.ndim else 1))))
    flat_y = np.broadcast_to(y.reshape(y.shape[0] if y.ndim else 1, -1), flat_x.shape)
    distance = geometry.distance_to_paths(flat_x, flat_y, px, py, lengths)
    shape = (batch.size, *(x.shape[1:] if x.ndim else (1,) * (batch.rank - 1)))
    return distance.reshape(shape)


def known_objects() -> Iterator[Any]:
    """The prepared objects, for tests of the cache's bound."""
    yield from (made for _, made in _prepared.values())
