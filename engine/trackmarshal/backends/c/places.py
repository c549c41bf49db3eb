"""Tracks, zones and lines of a program: their place in the context, how they get there, from C and from Python."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.c.layout import Layout, Shape
from trackmarshal.backends.c.names import comment, distinct
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.lines import Line

if TYPE_CHECKING:
    from trackmarshal.backends.c.program import Library

_UNSUPPORTED = 4


def has_geometry(plan: Layout) -> bool:
    if plan.shapes:  # of lanes also where no rule asks for them: the door does
        return True
    formulas = [root for rule in plan.rules for root in (rule.formula, rule.active) if root is not None]
    return any(
        isinstance(node, ir.Geometry | ir.Along | ir.OnLane) for root in formulas for node in ir.below(root)
    )


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


def _setters(plan: Layout) -> dict[str, str]:
    """Signal or place -> name of the C function that sets it."""
    names = distinct([*sources(plan), *(shape.key[1] for shape in own_places(plan))], _TAKEN)
    return {name: f"tm_set_{c_name}" for name, c_name in names.items()}


def setter(plan: Layout, name: str) -> str:
    """The function that sets a signal's lines, or a place."""
    return _setters(plan)[name]


def _bordered(plan: Layout, signal: str) -> bool:
    return plan.spec.signals[signal].kind == "corridor" or is_lanes(plan, signal)


def is_lanes(plan: Layout, name: str) -> bool:
    """Whether a signal or place is a set of lanes."""
    return name in plan.spec.signals and plan.spec.signals[name].many


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
    ]
    found += [
        "  tm_ends ends[TM_SEGMENTS];",
        "  tm_outline outline[TM_SEGMENTS / 8u];",
        "  tm_boxes blocks[TM_SEGMENTS / 64u];",
        "  tm_boxes groups[TM_SEGMENTS / 512u];",
    ]
    found.append("  tm_box part_box[TM_SEGMENTS / 512u];")
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
    setters_ = _setters(plan)
    for shape in plan.shapes.values():
        if shape.many:
            yield from _initial_lanes(plan, shape)
            continue
        place = f"c->shapes.{shape.c_name}"
        yield f"  {place}.first = TM_FIRST_{shape.c_name.upper()};"
        yield f"  {place}.count = 0u;"
        yield f"  {place}.length = 0.0;"
        yield f"  {place}.usable = false;"
        yield f"  {place}.closed = false;"
        yield f"  tm_unknown(&{place});"
        for name in ("x", "y", "heading", "ahead", "aside"):
            yield f"  {place}.{name} = 0.0;"
        if plan.lines:
            yield f"  tm_forget(&{place});"
    for shape in own_places(plan):
        count = len(plan.spec.places[shape.key[1]].points)
        yield f"  if ({setters_[shape.key[1]]}(c, tm_{shape.c_name}_points, {count}u) != TM_OK) {{ status = TM_UNUSABLE; }}"


def _initial_lanes(plan: Layout, shape: Shape) -> Iterator[str]:
    """The same of a shape for each lane."""
    yield "  for (size_t lane = 0u; lane <= TM_MAX_ELEMENTS; ++lane) {"
    yield f"    tm_shape *shape = &c->shapes.{shape.c_name}[lane];"
    first = f"TM_FIRST_{shape.c_name.upper()} + (lane * TM_ROUND({_capacity(shape)}))"
    yield f"    shape->first = (lane < TM_MAX_ELEMENTS) ? ({first}) : 0u;"
    yield "    shape->count = 0u;"
    yield "    shape->length = 0.0;"
    yield "    shape->usable = false;"
    yield "    shape->closed = false;"
    yield "    tm_unknown(shape);"
    for name in ("x", "y", "heading", "ahead", "aside"):
        yield f"    shape->{name} = 0.0;"
    if plan.lines:
        yield "    tm_forget(shape);"
    yield "  }"


def _signatures(plan: Layout) -> Iterator[tuple[str, str, str]]:
    """(signal or place, C signature, comment)."""
    names = _setters(plan)
    for signal in sources(plan):
        span = comment(str(plan.spec.signals[signal].span))
        if is_lanes(plan, signal):
            args = (
                "size_t lane, const double *left, size_t left_count, const double *right, size_t right_count"
            )
            yield (
                signal,
                f"tm_status {names[signal]}(tm_context *c, {args})",
                f"Set the borders of one of `{comment(signal)}`, by its number, x and y in m by turns; {span}",
            )
        elif _bordered(plan, signal):
            args = (
                "const double *left, size_t left_count, const double *right, size_t right_count, bool closed"
            )
            yield (
                signal,
                f"tm_status {names[signal]}(tm_context *c, {args})",
                f"Set the borders of `{comment(signal)}`, x and y in m by turns; {span}",
            )
        else:
            yield (
                signal,
                f"tm_status {names[signal]}(tm_context *c, const double *points, size_t count)",
                f"Set the line `{comment(signal)}`, x and y in m by turns; {span}",
            )
    for shape in own_places(plan):
        place = plan.spec.places[shape.key[1]]
        yield (
            shape.key[1],
            f"tm_status {names[shape.key[1]]}(tm_context *c, const double *points, size_t count)",
            (f"Replace the {place.kind} `{comment(place.name)}`; {comment(str(place.span))}"),
        )


def prototypes(plan: Layout, supervised: bool = False) -> Iterator[str]:
    """Declarations of the header; in a Supervisor, borders and lines come with each cycle."""
    done: set[str] = set()
    for name, signature, what in _signatures(plan):
        if name not in done and not (supervised and name in plan.spec.signals):
            done.add(name)
            yield f"/* {what}. TM_UNUSABLE, TM_UNSUPPORTED: rules that need it are undefined. */"
            yield f"{signature};"


def calls(plan: Layout, members: dict[tuple[str, str], str]) -> dict[str, str]:
    """By signal: C of the call that sets its shapes from `in`, whose members lines are."""
    names = _setters(plan)
    found = {}
    for name in sources(plan):
        if is_lanes(plan, name):  # each lane by itself: see `lanes`
            continue
        lines = ("left", "right") if _bordered(plan, name) else ("",)
        given = [f"in->{members[name, line]}" for line in lines]
        args = ", ".join(f"{line}.points, {line}.count" for line in given)
        found[name] = f"{names[name]}(c, {args}{', in->closed' if _bordered(plan, name) else ''})"
    return found


def setters(plan: Layout, supervised: bool = False) -> Iterator[str]:
    """Definitions of the functions that set shapes; those of signals are the Supervisor's own, where there is one."""
    done: set[str] = set()
    for name, signature, _ in _signatures(plan):
        if name in done:
            continue
        done.add(name)
        shapes = sources(plan).get(name) or [shape for shape in own_places(plan) if shape.key[1] == name]
        bordered = name in plan.spec.signals and _bordered(plan, name)
        limit = "TM_MAX_PLACE" if name not in plan.spec.signals else "TM_MAX_BORDER"
        yield ""
        yield ("static " if supervised and name in plan.spec.signals else "") + signature
        yield "{"
        yield "  tm_status worst = TM_OK;"
        yield "  tm_status status;"
        many = is_lanes(plan, name)
        if many:
            yield "  if (lane >= TM_MAX_ELEMENTS) {"
            yield "    return TM_OVER_CAPACITY;"
            yield "  }"
        over = f"(left_count > {limit}) || (right_count > {limit})" if bordered else f"count > {limit}"
        refused = [(over, "TM_OVER_CAPACITY")]
        if not supervised or name not in plan.spec.signals:  # its door has looked
            lines = (
                [(side, f"{side}_count") for side in ("left", "right")] if bordered else [("points", "count")]
            )
            none = [f"(({points} == NULL) && ({count} > 0u))" for points, count in lines]
            refused.append((" || ".join(none), "TM_UNUSABLE"))
        for refusal, status in refused:
            yield f"  if ({refusal}) {{"
            for shape in shapes:
                yield f"    c->shapes.{shape.c_name}{'[lane]' if many else ''}.usable = false;"
            yield f"    return {status};"
            yield "  }"
        for shape in shapes:
            yield f"  status = {_make(shape)};"
            yield "  if (status > worst) { worst = status; }"
        if bordered and all(shape.kind == "signal" for shape in shapes):
            for side in {"left", "right"} - {shape.key[2] for shape in shapes}:
                yield f"  (void){side};"
        yield "  return worst;"
        yield "}"


def _make(shape: Shape) -> str:
    target = f"c, &c->shapes.{shape.c_name}{'[lane]' if shape.many else ''}"
    closed = "false" if shape.many else "closed"
    both = f"left, left_count, right, right_count, {closed}"
    if shape.kind == "corridor":
        return f"tm_make_corridor({target}, {both})"
    if shape.kind == "centre":
        return f"tm_make_centre({target}, {both})"
    if shape.kind == "zone":
        return f"tm_make_polygon({target}, points, count)"
    if shape.kind == "signal" and shape.key[2]:
        return f"tm_make_line({target}, {shape.key[2]}, {shape.key[2]}_count, {closed})"
    if shape.kind in ("place", "signal"):
        return f"tm_make_line({target}, points, count, false)"
    raise AssertionError(f"unknown shape {shape.kind}")


def _ordered(plan: Layout) -> list[str]:
    return [*sources(plan), *dict.fromkeys(shape.key[1] for shape in own_places(plan))]


def glue(plan: Layout) -> Iterator[str]:
    """The binding: shapes by number; a second list of points for corridors."""
    names = _setters(plan)
    yield "int tmg_set_place(void *context, size_t index, const double *left, size_t left_count, const double *right,"
    yield "                  size_t right_count, int closed) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  (void)c; (void)left; (void)left_count; (void)right; (void)right_count; (void)closed;"
    yield "  switch (index) {"
    for i, name in enumerate(_ordered(plan)):
        if is_lanes(plan, name):
            continue
        args = (
            "left, left_count, right, right_count, closed != 0"
            if name in plan.spec.signals and _bordered(plan, name)
            else "left, left_count"
        )
        yield f"    case {i}: return (int){names[name]}(c, {args});"
    yield "    default: return -1;"
    yield "  }"
    yield "}"
    if lanes(plan):
        yield from _lane_glue(plan)


def lanes(plan: Layout) -> list[str]:
    """The sets of lanes whose borders rules read."""
    return [name for name in sources(plan) if is_lanes(plan, name)]


def bytes_of_lanes(plan: Layout, sizes: Mapping[str, int]) -> int:
    """About how many bytes lanes take, by the capacities."""
    shapes = [shape for shape in plan.shapes.values() if shape.many]
    if not shapes:
        return 0
    points = sum(2 * sizes["TM_MAX_BORDER"] if shape.region else sizes["TM_MAX_BORDER"] for shape in shapes)
    return 64 * points * sizes["TM_MAX_ELEMENTS"]


def _lane_glue(plan: Layout) -> Iterator[str]:
    """The binding of the borders of lanes, set by set."""
    yield "int tmg_set_lane(void *context, size_t set, size_t lane, const double *left, size_t left_count, const double *right,"
    yield "                 size_t right_count) {"
    yield "  switch (set) {"
    for number, name in enumerate(lanes(plan)):
        setter = _setters(plan)[name]
        yield f"    case {number}: return (int){setter}((tm_context *)context, lane, left, left_count, right, right_count);"
    yield "    default: return -1;"
    yield "  }"
    yield "}"


class PlaceSetter:
    """Puts the tracks and places of cases into a context; the same points are prepared once."""

    def __init__(self, plan: Layout, library: Library) -> None:
        self._plan = plan
        self._library = library
        self._set = library.dll.tmg_set_place
        self._names = _ordered(plan)
        #: What is in the context now, by number; the spec's own places are there from the start.
        self._now: list[tuple[Any, ...] | None] = [None] * len(self._names)
        self._status = [0] * len(self._names)
        self._lanes = [
            LaneSetter(name, number, library, plan.spec.signals[name].capacity)
            for number, name in enumerate(lanes(plan))
        ]

    def put(self, case: Frame) -> None:
        """Raises TrackmarshalError E473 for a track that the C geometry refuses."""
        for each in self._lanes:
            each.put(case)
        for index, name in enumerate(self._names):
            if is_lanes(self._plan, name):
                continue
            given = self._given(case, name)
            before = self._now[index]
            if before is None or len(before) != len(given) or any(a is not b for a, b in zip(before, given)):
                self._status[index] = self._put(index, given)
                self._now[index] = given
            if self._status[index] in (1, _UNSUPPORTED):
                raise _refused(name, case)

    def _given(self, case: Frame, name: str) -> tuple[Any, ...]:
        if name not in self._plan.spec.signals:
            return (case.settings.places.get(name, self._plan.spec.places[name].points), (), False)
        if _bordered(self._plan, name):
            return case.corridor(name)
        return (case.line(name, ""), (), False)

    def _put(self, index: int, given: tuple[Any, ...]) -> int:
        left, right = _flat(given[0]), _flat(given[1])
        status: int = self._set(
            self._library.context,
            index,
            left.buffer_info()[0],
            len(given[0]),
            right.buffer_info()[0],
            len(given[1]),
            int(given[2]),
        )
        return status


class LaneSetter:
    """Puts the lanes of one set into a context; the same borders at the same place are prepared once. most: its capacity, if it declares one."""

    def __init__(self, name: str, number: int, library: Library, most: int | None = None) -> None:
        self._most = most
        self._name, self._number, self._library = name, number, library
        self._now: list[tuple[Line, Line]] = []
        self._status: list[int] = []

    def put(self, case: Frame) -> None:
        """Raises TrackmarshalError E473 for a lane that the C geometry refuses."""
        # Of more than it declares, the rules are undefined, and none is asked for.
        for lane, given in enumerate(case.lanes.get(self._name, ())[: self._most]):
            before = self._now[lane] if lane < len(self._now) else None
            if before is None or before[0] is not given[0] or before[1] is not given[1]:
                self._now[lane : lane + 1] = [given]
                self._status[lane : lane + 1] = [self._put(lane, given)]
            if self._status[lane] in (1, _UNSUPPORTED):
                raise _refused(self._name, case)

    def _put(self, lane: int, given: tuple[Line, Line]) -> int:
        left, right = (_flat(line) for line in given)
        status: int = self._library.dll.tmg_set_lane(
            self._library.context, self._number, lane, left.buffer_info()[0], len(given[0]), right.buffer_info()[0], len(given[1])
        )  # fmt: skip
        return status


def _refused(name: str, case: Frame) -> TrackmarshalError:
    return TrackmarshalError(
        "E473", f"the C geometry refuses `{name}` of case {case.id!r}", help="choose another backend"
    )


def _flat(points: Line | Sequence[tuple[float, float]]) -> array[float]:
    if isinstance(points, Line):
        return array("d", points.points.tobytes()) or array("d", [0.0])
    return array("d", chain.from_iterable(points)) or array("d", [0.0])
