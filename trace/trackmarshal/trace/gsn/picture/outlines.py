"""The outlines of elements and the ends of links, after the GSN Community Standard, version 3."""

from __future__ import annotations

import math
from collections.abc import Sequence

from trackmarshal.trace.gsn.picture.boxes import DIAMOND, LEAN, LINE, PAD, Box
from trackmarshal.trace.gsn.picture.content import Shown
from trackmarshal.trace.report.svg.element import points, short, tag

Point = tuple[float, float]
INK = "#16202a"
#: An arrow's length and half its width.
ARROW, HALF = 9.0, 3.6


def outline(shown: Shown, box: Box, at: Point, fill: str, stroke: str) -> list[str]:
    """The outline of an element around a centre, with what marks it. Raises ValueError for an unknown kind."""
    (x, y), w, h = at, box.width, box.height
    left, right, top, low = x - w / 2, x + w / 2, y - h / 2, y + h / 2
    drawn = {"fill": fill, "stroke": stroke, "stroke_width": 1.4}
    match shown.element.kind:
        case "goal":
            found = [tag("rect", x=left, y=top, width=w, height=h, **drawn)]
        case "counter goal":
            found = [tag("rect", x=left, y=top, width=w, height=h, stroke_dasharray="5 3", **drawn)]
        case "strategy":
            corners = [(left + LEAN / 2, top), (right + LEAN / 2, top), (right - LEAN / 2, low), (left - LEAN / 2, low)]  # fmt: skip
            found = [tag("path", d=points(corners, closed=True), **drawn)]
        case "context":
            found = [tag("rect", x=left, y=top, width=w, height=h, rx=min(18.0, h / 2), **drawn)]
        case "solution":
            found = [tag("circle", cx=x, cy=y, r=w / 2, **drawn)]
        case "counter solution":
            found = [tag("circle", cx=x, cy=y, r=w / 2, stroke_dasharray="5 3", **drawn)]
        case "assumption" | "justification" as kind:
            letter = tag("text", kind[0].upper(), x=right - 10, y=low - 2, fill=INK, font_weight="bold")
            found = [tag("ellipse", cx=x, cy=y, rx=w / 2, ry=h / 2, **drawn), letter]
        case other:
            raise ValueError(f"unknown kind of elements {other!r}")
    if shown.away and shown.element.kind in ("goal", "context"):
        line = low - len(box.module) * LINE - PAD / 2 - 3
        found += [tag("path", d=points([(left, line), (right, line)]), **{**drawn, "fill": "none"}), folder(left + 6, line + 5, stroke)]  # fmt: skip
    if shown.element.public and not shown.away:
        found.append(folder(right - 18, top + 4, stroke))
    if shown.element.undeveloped:
        half = DIAMOND / 2
        found.append(tag("path", d=points([(x, low), (x + half, low + half), (x, low + DIAMOND), (x - half, low + half)], closed=True), fill="#ffffff", stroke=stroke, stroke_width=1.4))  # fmt: skip
    return found


def folder(x: float, y: float, stroke: str) -> str:
    """The sign of a module: a folder with its tab."""
    corners = [(x, y + 9), (x, y), (x + 5, y), (x + 5, y + 3), (x + 12, y + 3), (x + 12, y + 9)]
    return tag("path", d=points(corners, closed=True), fill="#ffffff", stroke=stroke, stroke_width=1.0)


def cross(box: Box, at: Point, colour: str) -> str:
    """What strikes out a defeated element."""
    (x, y), w, h = at, box.width / 2, box.height / 2
    d = points([(x - w, y - h), (x + w, y + h)]) + points([(x - w, y + h), (x + w, y - h)])
    return tag("path", d=d, stroke=colour, stroke_width=2.2, fill="none")


def link(kind: str, curve: Sequence[Point]) -> list[str]:
    """A link along a curve: solid head for support, hollow for context, dashed with an open head for challenges. Raises ValueError for others."""
    end, before = curve[-1], next(p for p in reversed(curve) if p != curve[-1])
    long = math.hypot(end[0] - before[0], end[1] - before[1])
    along = (end[0] - before[0]) / long, (end[1] - before[1]) / long
    tip = end[0] + along[0] * ARROW, end[1] + along[1] * ARROW
    sides = [(end[0] - along[1] * HALF * s, end[1] + along[0] * HALF * s) for s in (1, -1)]
    d = f"M{_at(curve[0])}C" + " ".join(_at(p) for p in curve[1:])
    line = {"fill": "none", "stroke": INK, "stroke_width": 1.1}
    match kind:
        case "supported_by":
            return [tag("path", d=d, **line), tag("path", d=points([sides[0], tip, sides[1]], closed=True), fill=INK)]  # fmt: skip
        case "in_context_of":
            head = tag("path", d=points([sides[0], tip, sides[1]], closed=True), fill="#ffffff", stroke=INK, stroke_width=1.1)  # fmt: skip
            return [tag("path", d=d, **line), head]
        case "challenges":
            reach = f"{d} L{_at(tip)}"
            return [tag("path", d=reach, stroke_dasharray="4 3", **line), tag("path", d=points([sides[0], tip, sides[1]]), **line)]  # fmt: skip
        case other:
            raise ValueError(f"unknown kind of links {other!r}")


def _at(point: Point) -> str:
    return f"{short(point[0])} {short(point[1])}"


__all__ = ["INK", "cross", "folder", "link", "outline"]
