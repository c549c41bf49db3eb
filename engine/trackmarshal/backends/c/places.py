"""Tracks, zones and lines of a program: what they are made of, and their place in the context."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from trackmarshal.backends.c.layout import Layout, Shape, is_lanes
from trackmarshal.backends.c.names import distinct
from trackmarshal.ir import nodes as ir


def has_geometry(plan: Layout) -> bool:
    if plan.shapes:  # of lanes also where no rule asks for them: the door does
        return True
    return any(isinstance(node, ir.Geometry | ir.Along | ir.OnLane) for node in plan.nodes)


def sources(plan: Layout) -> dict[str, list[Shape]]:
    """Signals that shapes are made of -> those shapes."""
    found: dict[str, list[Shape]] = {}
    for shape in plan.shapes.values():
        if shape.kind in ("corridor", "centre", "signal"):
            found.setdefault(shape.key[1], []).append(shape)
    return found


def own_places(plan: Layout) -> list[Shape]:
    """Shapes that the spec itself declares."""
    return [shape for shape in plan.shapes.values() if shape.kind in ("zone", "place")]


#: Names of functions `tm_set_...` of our own.
_TAKEN = ("table",)


def setter_names(plan: Layout) -> dict[str, str]:
    """Signal or place -> name of the C function that sets it."""
    names = distinct([*sources(plan), *(shape.key[1] for shape in own_places(plan))], _TAKEN)
    return {name: f"tm_set_{c_name}" for name, c_name in names.items()}


def bordered(plan: Layout, name: str) -> bool:
    """Whether a signal or place has two borders."""
    signal = plan.spec.signals.get(name)
    return signal is not None and (signal.kind == "corridor" or signal.many)


def lanes(plan: Layout) -> list[str]:
    """The sets of lanes whose borders rules read."""
    return [name for name in sources(plan) if is_lanes(plan.spec, name)]


def ordered(plan: Layout) -> list[str]:
    """Signals and places that have shapes, in the order of their numbers in the binding."""
    return [*sources(plan), *dict.fromkeys(shape.key[1] for shape in own_places(plan))]


def bytes_of_lanes(plan: Layout, sizes: Mapping[str, int]) -> int:
    """About how many bytes lanes take, by the capacities."""
    shapes = [shape for shape in plan.shapes.values() if shape.many]
    if not shapes:
        return 0
    points = sum(2 * sizes["TM_MAX_BORDER"] if shape.region else sizes["TM_MAX_BORDER"] for shape in shapes)
    return 64 * points * sizes["TM_MAX_ELEMENTS"]


def firsts(plan: Layout) -> tuple[list[tuple[str, str]], str]:
    """Where in the context the segments of each line and region begin: C name and C; and where the last ones end."""
    found, offset = [], "0u"
    for shape in (*plan.lines, *plan.regions):
        found.append((shape.c_name, offset))
        size = f"TM_ROUND({_capacity(shape)})"
        if shape.many:
            size = f"(TM_MAX_ELEMENTS * {size})"
        offset = f"TM_FIRST_{shape.c_name.upper()} + {size}"
    return found, offset


def _capacity(shape: Shape) -> str:
    return {"corridor": "2u * TM_MAX_BORDER", "zone": "TM_MAX_PLACE", "place": "TM_MAX_PLACE"}.get(
        shape.kind, "TM_MAX_BORDER"
    )


def members(plan: Layout) -> list[str]:
    """Members of the context."""
    if not plan.shapes:
        return []
    found = [
        "  struct {",
        *(_member(shape) for shape in plan.shapes.values()),
        "  } shapes;",
        "  tm_ends ends[TM_SEGMENTS];",
        "  tm_outline outline[TM_SEGMENTS / 8u];",
        "  tm_boxes blocks[TM_SEGMENTS / 64u];",
        "  tm_boxes groups[TM_SEGMENTS / 512u];",
        "  tm_box part_box[TM_SEGMENTS / 512u];",
    ]
    if plan.lines:
        found.append("  tm_along along[TM_LINE_SEGMENTS];")
    sizes = {_capacity(shape) for shape in plan.shapes.values()} | (
        {"2u * TM_MAX_BORDER"} if "centre" in {s.kind for s in plan.shapes.values()} else set()
    )
    found += [f"  double ring[2u * ({' + '.join(sorted(sizes))})]; /* while a shape is prepared */"]
    return found


def _member(shape: Shape) -> str:
    if shape.many:
        return f"    tm_shape {shape.c_name}[TM_MAX_ELEMENTS + 1u]; /* of each lane; the last one is none */"
    return f"    tm_shape {shape.c_name};"


def initial(plan: Layout) -> Iterator[str]:
    """Statements of tm_init."""
    for shape in plan.shapes.values():
        first, member = f"TM_FIRST_{shape.c_name.upper()}", f"c->shapes.{shape.c_name}"
        if shape.many:  # one for each lane
            yield "  for (size_t lane = 0u; lane <= TM_MAX_ELEMENTS; ++lane) {"
            yield f"    tm_shape *shape = &{member}[lane];"
            own = f"{first} + (lane * TM_ROUND({_capacity(shape)}))"
            yield f"    shape->first = (lane < TM_MAX_ELEMENTS) ? ({own}) : 0u;"
            yield from (f"    {line}" for line in _empty(plan, "shape->", "shape"))
            yield "  }"
        else:
            yield f"  {member}.first = {first};"
            yield from (f"  {line}" for line in _empty(plan, f"{member}.", f"&{member}"))
    names = setter_names(plan)
    for shape in own_places(plan):
        count = len(plan.spec.places[shape.key[1]].points)
        yield f"  if ({names[shape.key[1]]}(c, tm_{shape.c_name}_points, {count}u) != TM_OK) {{ status = TM_UNUSABLE; }}"


def _empty(plan: Layout, member: str, shape: str) -> Iterator[str]:
    """Statements that empty a shape; C of its members, and of its address."""
    yield f"{member}count = 0u;"
    yield f"{member}length = 0.0;"
    yield f"{member}usable = false;"
    yield f"{member}closed = false;"
    yield f"tm_unknown({shape});"
    for name in ("x", "y", "heading", "ahead", "aside"):
        yield f"{member}{name} = 0.0;"
    if plan.lines:
        yield f"tm_forget({shape});"
