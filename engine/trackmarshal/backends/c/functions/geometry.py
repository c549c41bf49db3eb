"""Lines, lanes, areas and sweeps: what is asked of them, as calls of functions of geometry."""

from __future__ import annotations

from typing import assert_never

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.naming import whose
from trackmarshal.backends.c.functions.writer import Writer
from trackmarshal.backends.c.names import identifier
from trackmarshal.ir import nodes as ir

#: Numbers of what is swept straight: two poses, length and width. Curvatures come after them.
_STRAIGHT = 8


def on_line(writer: Writer, what: str, line: ir.Line, *arguments: c.Expr) -> c.Expr:
    """A call of a function of a line."""
    if line.kind == "path":
        x, y = (writer.field(line.name, name) for name in ("x", "y"))
        return writer.call(
            f"tm_path_{what}", x, y, c.Member(writer.input(line.name), "count", False), *arguments
        )
    return writer.call(f"tm_line_{what}", *shape(writer, line), *arguments)


def shape(writer: Writer, item: ir.Line | ir.Area) -> tuple[c.Expr, c.Expr]:
    """The context, and the place of a line or region in it."""
    shapes = c.Member(writer.name("context"), "shapes", True)
    return c.Name("context"), c.Address(c.Member(shapes, writer.plan.shape(item).c_name, False))


def on_lane(writer: Writer, node: ir.OnLane, at: c.Scope) -> c.Expr:
    """What is asked of a lane by its number; of one that is not there, nothing is known."""
    shapes = c.Member(writer.name("context"), "shapes", True)
    every = c.Member(shapes, writer.plan.shape(node).c_name, False)
    count = c.Member(writer.input(node.signal), "count", False)
    lane = writer.call("tm_lane_at", every, count, writer.number(node.lane, at))
    given = [writer.number(each, at) for each in node.ends]
    match node.what:
        case "inside" | "meets":
            way = "curved" if len(given) > _STRAIGHT else "swept"
            bound = [c.Name("TM_INF")] if node.what == "inside" else []
            return writer.call(f"tm_{way}_{node.what}", writer.name("context"), lane, *given, *bound)
        case "station" | "offset" | "direction":
            call = writer.call("tm_line_project", writer.name("context"), lane, *given)
            key = ("lane", writer.plan.shape(node), node.lane, *node.ends)
            return c.Member(_projection(writer, key, call, node, at), node.what, False)
        case "distance" | "gap":
            return writer.call(f"tm_line_{node.what}", writer.name("context"), lane, *given)
        case "room":
            return writer.call("tm_line_stretch_room", writer.name("context"), lane, *given)
        case _:
            assert_never(node.what)


def projected(writer: Writer, node: ir.Projected, at: c.Scope) -> c.Expr:
    """The name of a point's projection, made once: its station, offset and direction are three nodes."""
    x, y = writer.number(node.x, at), writer.number(node.y, at)
    key = ("projection", node.line, node.x, node.y)
    return _projection(writer, key, on_line(writer, "project", node.line, x, y), node, at)


def _projection(writer: Writer, key: tuple[object, ...], call: c.Expr, node: ir.Num, at: c.Scope) -> c.Expr:
    home = writer.home(writer.facts.free(node), at)
    for scope in at.chain():  # as far out as that, what is known is about the same point
        if key in scope.known:
            return scope.known[key]
        if scope is home:
            break
    known = writer.declare(at, "tm_projection", call, identifier(f"projection_{whose(writer, node, at)}"))
    at.known[key] = known
    return known


def distance(writer: Writer, node: ir.Geometry, at: c.Scope) -> c.Expr:
    """The signed distance of a geometric predicate."""
    given = [writer.number(each, at) for each in writer.facts.operands(node) if isinstance(each, ir.Num)]
    bound = writer.bounds.get(node, c.Name("TM_INF"))
    match node:
        case ir.SweptClear():
            return (
                writer.call("tm_curved_clear", *given, bound)
                if node.bend
                else writer.call("tm_swept_clear", *given)
            )
        case ir.SweptInside():
            function = "tm_curved_inside" if node.bend else "tm_swept_inside"
            return writer.call(function, *shape(writer, node.area), *given, bound)
        case ir.InArea():
            alone = writer.known and node not in writer.margins
            return writer.call(
                "tm_in_area_sign" if alone else "tm_in_area", *shape(writer, node.area), *given
            )
        case _:
            assert_never(node)
