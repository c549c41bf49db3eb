"""A module as SVG that needs nothing else: it stands alone, says all of it in words too, and fits on A4."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from trackmarshal.trace.gsn.case import RESERVED, SUPPORTED, UNSUPPORTED, Case, Element, Module
from trackmarshal.trace.gsn.kinds import UPHELD
from trackmarshal.trace.gsn.modules import ONE_ROW
from trackmarshal.trace.gsn.picture.boxes import FONT, LINE, PAD, Box, box
from trackmarshal.trace.gsn.picture.content import Content, Shown, content
from trackmarshal.trace.gsn.picture.layout import APART, Placed, laid_out
from trackmarshal.trace.gsn.picture.outlines import INK, cross, link, outline
from trackmarshal.trace.gsn.picture.said import described, evidence, heading, said
from trackmarshal.trace.gsn.picture.wrapping import width, wrapped
from trackmarshal.trace.gsn.statuses import defeated
from trackmarshal.trace.report.svg.element import short, tag

#: What is written of a status, and its colours: of outline and words, and of the ground. As on the pages of the matrix.
STATUS = {
    SUPPORTED: ("✓", "#0b6b3a", "#dff3e6"),
    RESERVED: ("◐", "#7a5200", "#fdf0cf"),
    UNSUPPORTED: ("✗", "#a11220", "#fbdfe1"),
}
_PLAIN = ("", "#3d4a56", "#ffffff")
_AGAINST = ("!", "#a11220", "#ffffff")
FAMILY = "Arial, Helvetica, 'Liberation Sans', Arimo, 'DejaVu Sans', sans-serif"
MARGIN, HEAD, FOOT = 14.0, 44.0, 26.0
#: A4 with a margin of 10 mm, the longer side first; a point is so many mm.
LONG, SHORT, MM = 277.0, 190.0, 25.4 / 72
_TOO_SMALL = 420.0
#: What strikes out a defeated element: dark enough to be seen in grey, light enough to read over.
STRUCK = "#e08a92"
#: Where letters would be smaller than this on A4, in points, it is tried with rows of fewer elements, and less room between rows.
SMALL, CLOSER = 7.0, ((ONE_ROW, 0.3), (3, APART), (3, 0.3), (2, 0.3))


def pictures(
    case: Case, modules: Sequence[Module], files: Mapping[str, str], words: Mapping[str, str]
) -> list[str]:
    """The picture of each of some modules, in order. files: the names of the modules' files, which away elements lead to; words: the fixed ones by
    name, as the safety case has them. Raises T424, T425.
    """
    contents = [content(case, module) for module in modules]
    boxes = [{id_: box(shown, words) for id_, shown in c.shown.items()} for c in contents]
    placed = laid_out(list(zip(contents, boxes)))
    for one_row, apart in CLOSER:
        small = [n for n, p in enumerate(placed) if _scale(*_size(p)) * FONT < SMALL]
        for n, other in zip(small, laid_out([(contents[n], boxes[n]) for n in small], one_row, apart)):
            placed[n] = max(placed[n], other, key=lambda p: _scale(*_size(p)))
    return [
        _picture(case, shown, sizes, places, files, words)
        for shown, sizes, places in zip(contents, boxes, placed)
    ]


def _picture(
    case: Case,
    shown: Content,
    boxes: Mapping[str, Box],
    placed: Placed,
    files: Mapping[str, str],
    words: Mapping[str, str],
) -> str:
    wide, high = _size(placed)
    dx, dy = (wide - placed.width) / 2, MARGIN + HEAD
    lines = [
        part for one in shown.links for part in _link(one.kind, placed.curves.get((one.source, one.target)))
    ]
    elements = [
        _element(case, one, boxes[id_], placed.centres[id_], files, words) for id_, one in shown.shown.items()
    ]
    name, told = heading(case, shown, words), described(shown, words)
    body = [
        tag("rect", x=0.0, y=0.0, width=wide, height=high, fill="#ffffff"),
        *_head(case, shown, wide, words),
        tag(
            "g",
            *lines,
            *elements,
            *_points(case, shown, boxes, placed, words),
            transform=f"translate({short(dx)} {short(dy)})",
        ),
        *_foot(high, words),
    ]
    scale = _scale(wide, high)
    opening = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{short(wide * MM * scale)}mm" height="{short(high * MM * scale)}mm" '
        f'viewBox="0 0 {short(wide)} {short(high)}" role="group" aria-labelledby="name said" font-family="{escape(FAMILY)}" font-size="{FONT}">'
    )
    named = [tag("title", escape(_text(name)), id="name"), tag("desc", escape(_text(told)), id="said")]
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', opening, *named, *body, "</svg>"]) + "\n"


def _size(placed: Placed) -> tuple[float, float]:
    """The size of a picture with its head, foot and margins, in points."""
    return max(placed.width + 2 * MARGIN, _TOO_SMALL), placed.height + 2 * MARGIN + HEAD + FOOT


def _scale(wide: float, high: float) -> float:
    """How much smaller than it is drawn a picture has to be to fit on A4, lying or standing; 1 at most."""
    lying, standing = min(LONG / wide, SHORT / high), min(SHORT / wide, LONG / high)
    return min(1.0, max(lying, standing) / MM)


def _head(case: Case, shown: Content, wide: float, words: Mapping[str, str]) -> list[str]:
    title = wrapped(heading(case, shown, words), wide - 2 * MARGIN, 13.0, 1, bold=True)
    below = wrapped(shown.module.title, wide - 2 * MARGIN, FONT, 1)
    return [
        _words(MARGIN, MARGIN + 13, title[0], font_size=13.0, font_weight="bold", fill=INK),
        _words(MARGIN, MARGIN + 29, below[0], fill="#55626f"),
    ]


def _foot(high: float, words: Mapping[str, str]) -> list[str]:
    """What the colours and signs mean, in one line."""
    found, x, y = [], MARGIN, high - MARGIN
    for status, (sign, stroke, fill) in STATUS.items():
        word = words[f"status.{status}"]
        found += [
            tag("rect", x=x, y=y - 9, width=12.0, height=11.0, fill=fill, stroke=stroke),
            _words(x + 16, y, f"{sign} {word}", fill=stroke, font_size=9.0),
        ]
        x += 24 + width(f"{sign} {word}", 9.0) + 8
    return found


def _link(kind: str, curve: Sequence[tuple[float, float]] | None) -> list[str]:
    return link(kind, curve) if curve else []


def _points(
    case: Case, shown: Content, boxes: Mapping[str, Box], placed: Placed, words: Mapping[str, str]
) -> list[str]:
    """Confidence points: a black square with its id, at an element's upper left corner or on a link."""
    found = []
    for point in case.points:
        curve = placed.curves.get((point.at, point.to))
        if point.to and curve:
            x, y = curve[len(curve) // 2]
        elif not point.to and point.at in shown.shown:
            (x, y), size = placed.centres[point.at], boxes[point.at]
            x, y = x - size.width / 2, y - size.height / 2
        else:
            continue  # it is in another picture
        told = _text(words["gsn.point"].format(id=point.id, text=point.text))
        square = tag("rect", x=x - 4, y=y - 4, width=8.0, height=8.0, fill=INK)
        halo = {"stroke": "#ffffff", "stroke_width": 2.5, "paint_order": "stroke"}  # over lines and outlines
        name = _words(x + 7, y - 2, point.id, font_size=9.0, fill=INK, **halo)
        found.append(tag("g", tag("title", escape(told)), square, name, role="img", aria_label=told))
    return found


def _element(
    case: Case,
    one: Shown,
    size: Box,
    at: tuple[float, float],
    files: Mapping[str, str],
    words: Mapping[str, str],
) -> str:
    element = one.element
    told = said(one, words)
    sign, stroke, fill = _colours(element)
    parts = [
        tag("title", escape(_text("\n".join([told, *evidence(element, words)])))),
        *outline(one, size, at, fill, stroke),
    ]
    if defeated(case, element.id):  # under the words, which stay readable
        parts.append(cross(size, at, STRUCK))
    x, y = at
    rows = len(size.name) + len(size.lines) + bool(size.status)
    split = one.away and element.kind in ("goal", "context")
    top = y - (rows + (0 if split else len(size.module))) * LINE / 2
    if split:
        top = y - size.height / 2 + PAD
    baseline = top + FONT * 0.95
    texts: list[tuple[str, dict[str, str | float]]] = [(line, {"font_weight": "bold"}) for line in size.name]
    texts += [(line, {}) for line in size.lines]
    if size.status:
        texts.append((f"{sign} {size.status}", {"font_weight": "bold", "fill": stroke, "font_size": 9.0}))
    gap = PAD / 2 + 3 if split else 0.0
    texts += [(line, {"font_size": FONT - 1, "fill": "#55626f"}) for line in size.module]
    for number, (line, how) in enumerate(texts):
        low = gap if number >= len(texts) - len(size.module) else 0.0
        parts.append(_words(x, baseline + number * LINE + low, line, text_anchor="middle", **{"fill": INK, **how}))  # fmt: skip
    drawn = tag("g", *parts, role="img", aria_label=_text(told))
    address = files.get(element.module) if one.away else None
    return tag("a", drawn, href=address) if address else drawn


def _colours(element: Element) -> tuple[str, str, str]:
    if element.status:
        return STATUS[element.status]
    if element.state:
        return _AGAINST if element.state != UPHELD else (STATUS[UNSUPPORTED][0], *STATUS[UNSUPPORTED][1:])
    return _PLAIN


def _words(x: float, y: float, words: str, **attributes: object) -> str:
    return tag("text", escape(_text(words)), x=x, y=y, **attributes)


def _text(words: str) -> str:
    """Text without what XML cannot hold."""
    return "".join(c if c in "\t\n" or ("\ud7ff" >= c >= " ") or "\ue000" <= c <= "\ufffd" or c >= "\U00010000" else "\ufffd" for c in words)  # fmt: skip


__all__ = ["STATUS", "pictures"]
