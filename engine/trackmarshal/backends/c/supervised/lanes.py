"""The door of a Supervisor in C for sets of lanes: each lane has two borders that make a road; what is new is prepared for the rules."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.places import setter_names
from trackmarshal.backends.c.supervised.checks import breach, condition
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.runtime.contract import Signal
from trackmarshal.runtime.door.lines import NOWHERE
from trackmarshal.runtime.frame import Columns
from trackmarshal.runtime.lines import Line

#: The left and the right border of each lane of a set.
Lanes = tuple[tuple[Line, Line], ...]
#: What is found, by the variable that has the first lane of which it is so: the fault, and its field.
_FOUND = {
    "long_left": ("over_capacity", "left"),
    "long_right": ("over_capacity", "right"),
    "bad": ("bad_border", ""),
}

#: C of the field of a set without borders.
_SIDE = '(in->left == NULL) ? "left" : "right"'


def as_many(lanes: Lanes, columns: Columns | None) -> Lanes:
    """Lanes, one for each element of their set: those that are missing are nowhere."""
    count = 0 if columns is None else columns.count
    return (*lanes[:count], *((NOWHERE, NOWHERE) for _ in range(count - len(lanes))))


def lanes_of(given: Supervised, signal: Signal) -> Iterator[str]:
    """Definition of the function that looks at the lanes of a set. Whatever else is wrong with the set: rules read them beside it."""
    c_name = given.signals[signal.name]
    region = f"c->shapes.{given.layout.shapes['corridor', signal.name, ''].c_name}[i].usable"
    yield f"/* What the borders of each of `{comment(signal.name)}` have to be; where they are new, they are prepared for the rules. */"
    arguments = (
        f"tm_context *c, const tm_cycle *cycle, const tm_in_{c_name} *in, const char *signal, tm_look *look"
    )
    yield f"static void tm_lanes_{c_name}({arguments})"
    yield "{"
    for name in _FOUND:
        yield f"  size_t {name} = TM_NOWHERE;"
    fits = " && ".join(
        [
            "(in->count <= TM_MAX_ELEMENTS)",
            *(condition(check, {"n": "(double)in->count"}, given.capacities) for check in signal.checks),
        ]
    )
    yield f'  if ((in == NULL) || !({fits}) || tm_named(cycle, signal, "")) {{'
    yield "    /* there is no set */"
    yield "  } else if (((in->left == NULL) || (in->right == NULL)) && (in->count > 0u)) {"
    yield f"    {breach('missing', 'signal', _SIDE)}"
    yield "  } else {"
    yield "    for (size_t i = 0u; i < in->count; ++i) {"
    yield "      const tm_points *left = &in->left[i];"
    yield "      const tm_points *right = &in->right[i];"
    yield f"      tm_passed_lane *kept = &c->lanes.{c_name}[i];"
    yield "      const bool there = (left->points != NULL) && (right->points != NULL);"
    yield "      bool wrong = !there && !tm_named(cycle, signal, NULL);"
    for side in ("left", "right"):
        yield f"      if ({side}->count > TM_MAX_BORDER) {{"
        yield "        kept->set = false;"
        yield f"        long_{side} = (long_{side} == TM_NOWHERE) ? i : long_{side};"
        yield "      }"
    yield "      if (!there) {"
    yield "        kept->set = false;"
    yield "      } else if ((left->count <= TM_MAX_BORDER) && (right->count <= TM_MAX_BORDER)) {"
    again = " && ".join(
        f"({side}->id != 0u) && ({side}->id == kept->{side}.id) && ({side}->count == kept->{side}.count)"
        for side in ("left", "right")
    )
    yield f"        if (!(kept->set && {again})) {{"
    made = f"{setter_names(given.layout)[signal.name]}(c, i, left->points, left->count, right->points, right->count)"
    yield f"          const tm_status status = {made};"
    yield f"          kept->bad = (status != TM_UNSUPPORTED) && !{region};"
    for side in ("left", "right"):
        yield f"          kept->{side}.id = {side}->id;"
        yield f"          kept->{side}.count = {side}->count;"
    yield "          kept->set = true;"
    yield "        }"
    yield "        wrong = kept->bad;"
    yield "      } else {"
    yield "        /* it is too long */"
    yield "      }"
    yield "      bad = (wrong && (bad == TM_NOWHERE)) ? i : bad;"
    yield "    }"
    yield "  }"
    for name, (fault, field) in _FOUND.items():
        said = breach(fault, "signal", f'"{field}"', name)
        yield f"  if ({name} != TM_NOWHERE) {{ {said} }}"
    yield "  ++look->parts;"
    yield "}"
    yield ""
