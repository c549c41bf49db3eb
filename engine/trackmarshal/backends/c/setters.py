"""What sets the tracks, zones and lines of a program: its functions in C, and the binding by which Python calls them."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.layout import Layout, Shape, is_lanes
from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.places import (
    bordered,
    lanes,
    ordered,
    own_places,
    setter_names,
    sources,
)


def _signatures(plan: Layout) -> Iterator[tuple[str, str, str]]:
    """(signal or place, C signature, comment)."""
    of_signals = sources(plan)
    for name, function in setter_names(plan).items():
        given = "const double *points, size_t count"
        if name not in of_signals:
            place = plan.spec.places[name]
            said = f"Replace the {place.kind} `{comment(name)}`; {comment(str(place.span))}"
        else:
            borders = "const double *left, size_t left_count, const double *right, size_t right_count"
            what = f"Set the line `{comment(name)}`, x"
            if is_lanes(plan.spec, name):
                given = f"size_t lane, {borders}"
                what = f"Set the borders of one of `{comment(name)}`, by its number, x"
            elif bordered(plan, name):
                given = f"{borders}, bool closed"
                what = f"Set the borders of `{comment(name)}`, x"
            said = f"{what} and y in m by turns; {comment(str(plan.spec.signals[name].span))}"
        yield name, f"tm_status {function}(tm_context *c, {given})", said


def prototypes(plan: Layout, supervised: bool = False) -> Iterator[str]:
    """Declarations of the header; in a Supervisor, borders and lines come with each cycle."""
    for name, signature, what in _signatures(plan):
        if not (supervised and name in plan.spec.signals):
            yield f"/* {what}. TM_UNUSABLE, TM_UNSUPPORTED: rules that need it are undefined. */"
            yield f"{signature};"


def calls(plan: Layout, members: dict[tuple[str, str], str]) -> dict[str, str]:
    """By signal: C of the call that sets its shapes from `in`, whose members lines are."""
    names = setter_names(plan)
    found = {}
    for name in sources(plan):
        if is_lanes(plan.spec, name):  # each lane by itself: see `lanes`
            continue
        lines = ("left", "right") if bordered(plan, name) else ("",)
        given = [f"in->{members[name, line]}" for line in lines]
        args = ", ".join(f"{line}.points, {line}.count" for line in given)
        found[name] = f"{names[name]}(c, {args}{', in->closed' if bordered(plan, name) else ''})"
    return found


def setters(plan: Layout, supervised: bool = False) -> Iterator[str]:
    """Definitions of the functions that set shapes; those of signals are the Supervisor's own, where there is one."""
    for name, signature, _ in _signatures(plan):
        shapes = sources(plan).get(name) or [shape for shape in own_places(plan) if shape.key[1] == name]
        two = bordered(plan, name)
        limit = "TM_MAX_PLACE" if name not in plan.spec.signals else "TM_MAX_BORDER"
        yield ""
        yield ("static " if supervised and name in plan.spec.signals else "") + signature
        yield "{"
        yield "  tm_status worst = TM_OK;"
        yield "  tm_status status;"
        many = is_lanes(plan.spec, name)
        if many:
            yield "  if (lane >= TM_MAX_ELEMENTS) {"
            yield "    return TM_OVER_CAPACITY;"
            yield "  }"
        over = f"(left_count > {limit}) || (right_count > {limit})" if two else f"count > {limit}"
        refused = [(over, "TM_OVER_CAPACITY")]
        if not supervised or name not in plan.spec.signals:  # its door has looked
            lines = [(side, f"{side}_count") for side in ("left", "right")] if two else [("points", "count")]
            none = [f"(({points} == NULL) && ({count} > 0u))" for points, count in lines]
            refused.append((" || ".join(none), "TM_UNUSABLE"))
        for refusal, status in refused:
            yield f"  if ({refusal}) {{"
            for shape in shapes:
                yield f"    c->shapes.{shape.c_name}{'[lane]' if many else ''}.usable = false;"
            yield f"    return {status};"
            yield "  }"
        for shape in shapes:
            yield f"  status = {make(shape)};"
            yield "  if (status > worst) { worst = status; }"
        if two and all(shape.kind == "signal" for shape in shapes):
            for side in {"left", "right"} - {shape.key[2] for shape in shapes}:
                yield f"  (void){side};"
        yield "  return worst;"
        yield "}"


def make(shape: Shape) -> str:
    """C of the call that prepares a shape of a setter's points."""
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


def glue(plan: Layout) -> Iterator[str]:
    """The binding: shapes by number; a second list of points for corridors."""
    names = setter_names(plan)
    yield "int tmg_set_place(void *context, size_t index, const double *left, size_t left_count, const double *right,"
    yield "                  size_t right_count, int closed) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  (void)c; (void)left; (void)left_count; (void)right; (void)right_count; (void)closed;"
    yield "  switch (index) {"
    for i, name in enumerate(ordered(plan)):
        if is_lanes(plan.spec, name):
            continue
        args = (
            "left, left_count, right, right_count, closed != 0"
            if bordered(plan, name)
            else "left, left_count"
        )
        yield f"    case {i}: return (int){names[name]}(c, {args});"
    yield "    default: return -1;"
    yield "  }"
    yield "}"
    if lanes(plan):
        yield from _lane_glue(plan)


def _lane_glue(plan: Layout) -> Iterator[str]:
    """The binding of the borders of lanes, set by set."""
    yield "int tmg_set_lane(void *context, size_t set, size_t lane, const double *left, size_t left_count, const double *right,"
    yield "                 size_t right_count) {"
    yield "  switch (set) {"
    for number, name in enumerate(lanes(plan)):
        setter = setter_names(plan)[name]
        yield f"    case {number}: return (int){setter}((tm_context *)context, lane, left, left_count, right, right_count);"
    yield "    default: return -1;"
    yield "  }"
    yield "}"
