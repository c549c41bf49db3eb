"""Results as a chart of cells: things in rows against situations or times in columns, each cell with a sign and a colour that mean the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from trackmarshal.trace.case.words import COLOURS
from trackmarshal.trace.report.svg.element import fitted, svg, tag, text, text_width, title

_FAMILY = "Arial, Helvetica, 'Liberation Sans', 'DejaVu Sans', sans-serif"
_INK, _SOFT, _LINE = "#16202a", "#55626f", "#d5dbe1"
_SIZE, _HEAD, _ROW, _PAD, _GAP = 9.0, 7.0, 17.0, 4.0, 8.0


class Cell(NamedTuple):
    """said: what stands in it; look: the status of cells that it looks like; told: all of it in words, for who points at it or hears it."""

    said: str
    look: str
    told: str


class Legend(NamedTuple):
    """What a sign in the cells stands for."""

    sign: str
    look: str
    said: str


def grid(
    name: str, heads: Sequence[Sequence[str]], rows: Sequence[tuple[str, str]], cells: Mapping[tuple[int, int], Cell], legend: Sequence[Legend], wide: float,
    label: float,
) -> tuple[str, float, float]:  # fmt: skip
    """The chart as SVG, with its width and height in points.

    heads: lines above the columns, in each line a word a column; words that are alike beside each other stand once. rows: a short name and what it
    is. cells: by row and column. wide: the whole width; label: that of the names, both in points. What is too long for its place is cut; it stands whole beside the chart.
    """
    columns = max(map(len, heads), default=0)
    step = (wide - label - 2 * _PAD) / max(columns, 1)
    drawn: list[str] = []
    top = _PAD
    for line in heads:
        drawn += _head(line, top, label, step)
        top += _ROW - 3
    top += 2
    told: list[str] = []
    for number, (short, said) in enumerate(rows):
        y = top + number * _ROW
        drawn.append(tag("line", x1=_PAD, y1=y, x2=wide - _PAD, y2=y, stroke=_LINE, stroke_width=0.5))
        drawn.append(text(_PAD, y + 12, short, font_size=_SIZE, font_weight="bold", fill=_INK))
        at = _PAD + text_width(short, _SIZE) + 7
        drawn.append(tag("g", title(said), text(at, y + 12, fitted(said, label - at - 2, _SIZE), font_size=_SIZE, fill=_INK)))  # fmt: skip
        for column in range(columns):
            cell = cells.get((number, column))
            if cell is not None:
                drawn.append(_cell(cell, _PAD + label + column * step, y, step))
                told.append(cell.told)
    signs, high = _legend(legend, top + len(rows) * _ROW + _GAP, wide)
    drawn += signs
    return (
        svg(wide, high, name, "; ".join(told), drawn, font_family=_FAMILY, style=f"width: {wide:g}pt"),
        wide,
        high,
    )


def _head(line: Sequence[str], top: float, label: float, step: float) -> list[str]:
    drawn: list[str] = []
    start = 0
    for end in range(1, len(line) + 1):
        if end < len(line) and line[end] == line[start]:
            continue
        x, width = _PAD + label + start * step, (end - start) * step
        drawn.append(text(x + width / 2, top + 10, fitted(line[start], width - 2, _HEAD), text_anchor="middle", font_size=_HEAD, fill=_SOFT))  # fmt: skip
        if end - start > 1:
            drawn.append(tag("line", x1=x + 3, y1=top + 13, x2=x + width - 3, y2=top + 13, stroke=_LINE))
        start = end
    return drawn


def _cell(cell: Cell, x: float, y: float, step: float) -> str:
    ink, ground = COLOURS[cell.look]
    box = tag("rect", x=x + 1, y=y + 1.5, width=step - 2, height=_ROW - 3, rx=2, fill=ground)
    said = text(x + step / 2, y + 12, fitted(cell.said, step - 2, _SIZE), text_anchor="middle", font_size=_SIZE, fill=ink)  # fmt: skip
    return tag("g", title(cell.told), box, said)


def _legend(legend: Sequence[Legend], top: float, wide: float) -> tuple[list[str], float]:
    """What signs mean, in as many lines as it takes; and where it ends."""
    drawn: list[str] = []
    x = _PAD
    for sign, look, said in legend:
        ink, ground = COLOURS[look]
        width = text_width(sign, _SIZE) + 8
        whole = width + text_width(said, _SIZE) + 16
        if x > _PAD and x + whole > wide:
            x, top = _PAD, top + _ROW
        box = tag("rect", x=x, y=top + 1.5, width=width, height=_ROW - 3, rx=2, fill=ground)
        drawn += [box, text(x + width / 2, top + 12, sign, text_anchor="middle", font_size=_SIZE, fill=ink)]
        drawn.append(text(x + width + 4, top + 12, said, font_size=_SIZE, fill=_SOFT))
        x += whole
    return drawn, top + (_ROW if legend else 0) + _PAD


__all__ = ["Cell", "Legend", "grid"]
