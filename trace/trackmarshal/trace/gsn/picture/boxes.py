"""How large elements are drawn: their text in lines, inside of the outline that their kind has."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from trackmarshal.trace.gsn.case import Element
from trackmarshal.trace.gsn.picture.content import Shown
from trackmarshal.trace.gsn.picture.wrapping import width, wrapped

#: In points: the font's size, the height of a line, the width of boxes, the room between outline and text.
FONT, LINE, BOX, PAD = 10.5, 13.0, 172.0, 8.0
#: How far the sides of a strategy lean.
LEAN = 14.0
#: The diamond of an undeveloped element, under it.
DIAMOND = 14.0
#: The most lines of text in an element; the whole text is its title.
LINES = 9
#: ... and in an oval one, which grows in both directions.
FEWER = 5
#: What a line of an id, and one of a status, takes beside the text.
ROUND = frozenset({"solution", "counter solution"})
OVAL = frozenset({"assumption", "justification"})


class Box(NamedTuple):
    """An element's size, in points, with its lines: of its id, its text, its module where it is away, and its status."""

    width: float
    height: float
    name: list[str]
    lines: list[str]
    module: list[str]
    status: str


def box(shown: Shown, words: Mapping[str, str]) -> Box:
    """The size of an element with its text; words: the fixed ones, by name. Raises ValueError for an unknown kind."""
    element = shown.element
    status = standing(element, words)
    module = words["gsn.in"].format(module=element.module) if shown.away else ""
    match element.kind:
        case "goal" | "counter goal" | "context":
            return _rectangle(shown, BOX, BOX - 2 * PAD, status, module)
        case "strategy":
            return _rectangle(shown, BOX, BOX - 2 * PAD - LEAN, status, module)
        case "solution" | "counter solution":
            return _circle(shown, status, module)
        case "assumption" | "justification":
            return _ellipse(shown, module)
        case other:
            raise ValueError(f"unknown kind of elements {other!r}")


def standing(element: Element, words: Mapping[str, str]) -> str:
    """How far an element is supported, or what came of a defeater, in words; empty where there is neither."""
    if element.status:
        return words[f"status.{element.status}"]
    return words[f"gsn.state.{element.state}"] if element.state else ""


def _rectangle(shown: Shown, wide: float, room: float, status: str, module_of: str) -> Box:
    name = wrapped(shown.element.id, room, FONT, 2, bold=True)
    lines = wrapped(shown.element.text, room, FONT, LINES)
    module = wrapped(module_of, room - 14, FONT - 1, 2) if module_of else []
    rows = len(name) + len(lines) + bool(status)
    return Box(wide, 2 * PAD + rows * LINE + (len(module) * LINE + 4 if module else 0), name, lines, module, status)  # fmt: skip


def _circle(shown: Shown, status: str, module_of: str) -> Box:
    """The smallest circle, in steps, whose chords are long enough for what stands at their height."""
    for diameter in range(96, 260, 6):
        room = diameter * 0.74
        name = wrapped(shown.element.id, room * 0.8, FONT, 2, bold=True)
        lines = wrapped(shown.element.text, room, FONT, LINES)
        module = wrapped(module_of, room * 0.8, FONT - 1, 2) if module_of else []
        rows = [*((line, True) for line in name), *((line, False) for line in lines), *((line, False) for line in module), *([(status, True)] if status else [])]  # fmt: skip
        if _inside(rows, diameter / 2 - 3, diameter / 2 - 3):
            return Box(float(diameter), float(diameter), name, lines, module, status)
    return Box(260.0, 260.0, name, lines, module, status)


def _ellipse(shown: Shown, module_of: str) -> Box:
    for height in range(64, 320, 8):
        wide = max(BOX, height * 1.7)
        room = wide * 0.74
        name = wrapped(shown.element.id, room * 0.8, FONT, 2, bold=True)
        lines = wrapped(shown.element.text, room, FONT, FEWER)
        module = wrapped(module_of, room * 0.8, FONT - 1, 2) if module_of else []
        rows = [*((line, True) for line in name), *((line, False) for line in [*lines, *module])]
        if _inside(rows, wide / 2 - 3, height / 2 - 3):
            break
    return Box(float(wide), float(height), name, lines, module, "")


def _inside(rows: list[tuple[str, bool]], across: float, up: float) -> bool:
    """Whether lines in the middle of an ellipse with these half axes lie in it, each with all of its height."""
    top = len(rows) * LINE / 2
    for number, (line, bold) in enumerate(rows):
        far = max(abs(top - number * LINE), abs(top - (number + 1) * LINE))
        if far > up or width(line, FONT, bold) / 2 > across * math.sqrt(1 - (far / up) ** 2):
            return False
    return True


__all__ = ["BOX", "DIAMOND", "FONT", "LEAN", "LINE", "OVAL", "PAD", "ROUND", "Box", "box", "standing"]
