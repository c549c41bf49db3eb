"""Tracks, zones and lines of a program: their place in the context, how they get there, from C and from Python."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
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


def uses_paths(plan: Layout) -> bool:
    """Whether a rule projects onto the path of a trajectory."""
    return any(
        isinstance(n, ir.Line) and n.kind == "path"
        for r in plan.rules
        if r.formula is not None
        for n in ir.below(r.formula)
    )


def has_geometry(plan: Layout) -> bool:
    formulas = [root for rule in plan.rules for root in (rule.formula, rule.active) if root is not None]
    return any(isinstance(node, ir.Geometry | ir.Along) for root in formulas for node in ir.below(root))


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


def _bordered(plan: Layout, signal: str) -> bool:
    return plan.spec.signals[signal].kind == "corridor"


def types(plan: Layout) -> Iterator[str]:
    """Type definitions of the header."""
    if not has_geometry(plan):
        return
    yield "/* A directed segment from (ax, ay) to (bx, by), its vector, squared length and length; m. */"
    yield "typedef struct {"
    yield "  double ax;\n  double ay;\n  double bx;\n  double by;\n  double ex;\n  double ey;\n  double square;\n  double length;"
    yield "} tm_segment;"
    yield ""
    yield "/* Where a segment begins and ends; m. */"
    yield "typedef struct {\n  double ax;\n  double ay;\n  double bx;\n  double by;\n} tm_ends;"
    yield ""
    yield "/* A box along the axes; m. */"
    yield "typedef struct {\n  double x0;\n  double y0;\n  double x1;\n  double y1;\n} tm_box;"
    yield ""
    yield "/* A convex polygon, counter-clockwise: corners, vectors of the sides, their squared lengths and lengths; m. */"
    yield "typedef struct {"
    yield "  size_t count;"
    for name in ("x", "y", "gx", "gy", "square", "length"):
        yield f"  double {name}[16];"
    yield "} tm_hull;"
    yield ""
    yield "/* A box along a direction of cosine `ahead` and sine `aside`: from u0 to u1 along it, from v0 to v1 to its left; m. */"
    yield "typedef struct {\n  double ahead;\n  double aside;\n  double u0;\n  double u1;\n  double v0;\n  double v1;\n} tm_frame;"
    yield ""
    yield "/* Eight boxes along the axes, in short: none smaller than what it is around; m. */"
    yield "typedef struct {\n  float x0[8];\n  float y0[8];\n  float x1[8];\n  float y1[8];\n} tm_boxes;"
    yield ""
    yield "/* A walk over those blocks of eight segments whose boxes meet a box: parts of 512 to come, bits for the groups of 64 in the last one,"
    yield "   bits for the blocks in the last group; `block`: where the last block begins. */"
    yield "typedef struct {"
    yield "  tm_box near;\n  float x0;\n  float y0;\n  float x1;\n  float y1;\n  size_t part;\n  size_t group;\n  size_t block;\n  size_t end;\n  unsigned groups;\n  unsigned blocks;"
    yield "} tm_walk;"
    yield ""
    yield "/* Where eight segments in a row begin, and where the last one ends, in m from the lower left corner of the box of their 64,"
    yield "   in short: segments that are farther away than this shows need not be looked at. */"
    yield "typedef struct {\n  float x[9];\n  float y[9];\n} tm_outline;"
    yield ""
    yield "/* A frame seen from a point (ox, oy), in short; `size`: no less than its numbers; m. */"
    yield "typedef struct {"
    yield "  double ox;\n  double oy;\n  float ahead;\n  float aside;\n  float u0;\n  float u1;\n  float v0;\n  float v1;\n  double size;"
    yield "} tm_strip;"
    yield ""
    yield "/* An outline along a strip, and what may be wrong with it; m. */"
    yield "typedef struct {\n  float u[9];\n  float v[9];\n  double slack;\n} tm_beside_strip;"
    yield ""
    yield "/* A stretch of a timeline: at most so many sweeps are held against a border at once, and so many segments listed beside them. */"
    yield "#define TM_STRETCH 16u"
    yield "#define TM_STRETCH_LIST 24u"
    yield ""
    yield "/* A pose along a stretch: where [m], turned by how much [rad], and what its footprint takes at most, to each side [m]. */"
    yield "typedef struct {\n  double u;\n  double v;\n  double turn;\n  double along;\n  double across;\n} tm_posed;"
    yield ""
    yield "/* Poses seen from the one in their middle, at (ox, oy), and along it; the segments near to them by their numbers in the context, with"
    yield "   their ends and boxes along the stretch, in short, and what may be wrong with these; m. */"
    yield "typedef struct {"
    yield "  double ox;\n  double oy;\n  tm_frame frame;\n  tm_posed pose[TM_STRETCH + 1u];\n  double slack;\n  size_t count;\n  size_t at[TM_STRETCH_LIST];"
    yield "  double reach[TM_STRETCH + 1u]; /* how far what is swept up to a pose may be beyond the straight way */\n  double widest; /* of those */"
    for name in ("ua", "va", "ub", "vb", "u0", "u1", "v0", "v1"):
        yield f"  float {name}[TM_STRETCH_LIST];"
    yield "} tm_stretch;"
    yield ""
    yield "/* The way from one pose to another: the poses where its pieces begin and end, at most so many, and how far beyond the hulls of"
    yield "   these a vehicle may reach; m. */"
    yield "#define TM_PIECES 32u"
    yield "typedef struct {"
    for name in ("x", "y", "ahead", "aside"):
        yield f"  double {name}[TM_PIECES + 1u];"
    yield "  size_t count;\n  double more;"
    yield "} tm_curve;"
    yield ""
    yield "/* What is swept along a piece of a curve, seen from its first pose at (ox, oy): the box around it along the second one, the corners"
    yield "   of both and their hull if they are made; the nearest border so far, and whether one entered; m. */"
    yield "typedef struct {"
    yield "  const tm_curve *curve;\n  size_t piece;\n  double length;\n  double width;"
    yield "  double ox;\n  double oy;\n  double x[8];\n  double y[8];\n  tm_frame frame;\n  tm_hull hull;"
    yield "  double best;\n  bool placed;\n  bool built;\n  bool entered;"
    yield "} tm_sweep;"
    yield ""
    yield "/* Where a point is along a line: station and offset in m (positive to the left), direction in rad. */"
    yield "typedef struct {\n  double station;\n  double offset;\n  double direction;\n} tm_projection;"
    yield ""
    if not plan.shapes:
        return
    if plan.lines:
        yield "/* A point, where it is along a line, and the segment of the line that is nearest. */"
        yield "typedef struct {\n  double x;\n  double y;\n  tm_projection at;\n  size_t segment;\n} tm_projected;"
        yield ""
    yield "/* A prepared line or region: its segments in the context. */"
    yield "typedef struct {"
    yield "  size_t first;\n  size_t count;\n  size_t hint; /* the segment that was nearest last */\n  double length; /* m */"
    yield "  size_t near[2]; /* the segments that were nearest to the last timelines, which come by turns */\n  size_t turn_near;"
    yield "  bool usable;\n  bool closed;"
    yield "  bool known; /* the cosine and sine of a heading */\n  bool inside; /* well inside lies (x, y) */"
    yield "  double x;\n  double y;\n  double heading;\n  double ahead; /* cosine */\n  double aside; /* sine */"
    if plan.lines:
        yield "  tm_projected recent[8]; /* of a line: the points that were projected last */\n  size_t turn;"
    yield "} tm_shape;"
    yield ""
    if plan.lines:
        yield "/* The station at which a segment of a line begins [m], and its direction [rad]. */"
        yield "typedef struct {\n  double station;\n  double direction;\n} tm_along;"
        yield ""
    if any(shape.kind == "corridor" for shape in plan.shapes.values()):
        yield "/* Where a segment of a figure of eight is crossed; most of them that one may have. */"
        yield "typedef struct {\n  double x;\n  double y;\n  double along;\n  size_t side;\n} tm_cut;"
        yield ""
        yield "#define TM_MAX_CUTS 32u"
        yield ""
    yield "#define TM_ROUND(n) ((((n) + 511u) / 512u) * 512u)"
    offset = "0u"
    for shape in (*plan.lines, *plan.regions):
        name = f"TM_FIRST_{shape.c_name.upper()}"
        yield f"#define {name} ({offset})"
        offset = f"{name} + TM_ROUND({_capacity(shape)})"
        if plan.lines and shape is plan.lines[-1]:
            yield f"#define TM_LINE_SEGMENTS ({offset})"
    yield f"#define TM_SEGMENTS ({offset})"
    yield ""


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
        *(f"    tm_shape {shape.c_name};" for shape in plan.shapes.values()),
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


def initial(plan: Layout) -> Iterator[str]:
    """Statements of tm_init."""
    setters_ = _setters(plan)
    for shape in plan.shapes.values():
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


def _signatures(plan: Layout) -> Iterator[tuple[str, str, str]]:
    """(signal or place, C signature, comment)."""
    names = _setters(plan)
    for signal in sources(plan):
        span = comment(str(plan.spec.signals[signal].span))
        if _bordered(plan, signal):
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
        over = f"(left_count > {limit}) || (right_count > {limit})" if bordered else f"count > {limit}"
        yield f"  if ({over}) {{"
        for shape in shapes:
            yield f"    c->shapes.{shape.c_name}.usable = false;"
        yield "    return TM_OVER_CAPACITY;"
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
    target = f"c, &c->shapes.{shape.c_name}"
    both = "left, left_count, right, right_count, closed"
    if shape.kind == "corridor":
        return f"tm_make_corridor({target}, {both})"
    if shape.kind == "centre":
        return f"tm_make_centre({target}, {both})"
    if shape.kind == "zone":
        return f"tm_make_polygon({target}, points, count)"
    if shape.kind == "signal" and shape.key[2]:
        return f"tm_make_line({target}, {shape.key[2]}, {shape.key[2]}_count, closed)"
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
        args = (
            "left, left_count, right, right_count, closed != 0"
            if name in plan.spec.signals and _bordered(plan, name)
            else "left, left_count"
        )
        yield f"    case {i}: return (int){names[name]}(c, {args});"
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

    def put(self, case: Frame) -> None:
        """Raises TrackmarshalError E473 for a track that the C geometry refuses."""
        for index, name in enumerate(self._names):
            given = self._given(case, name)
            before = self._now[index]
            if before is None or len(before) != len(given) or any(a is not b for a, b in zip(before, given)):
                self._status[index] = self._put(index, given)
                self._now[index] = given
            if self._status[index] in (1, _UNSUPPORTED):
                raise TrackmarshalError(
                    "E473",
                    f"the C geometry refuses `{name}` of case {case.id!r}",
                    help="choose another backend",
                )

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


def _flat(points: Line | Sequence[tuple[float, float]]) -> array[float]:
    if isinstance(points, Line):
        return array("d", points.points.tobytes()) or array("d", [0.0])
    return array("d", chain.from_iterable(points)) or array("d", [0.0])
