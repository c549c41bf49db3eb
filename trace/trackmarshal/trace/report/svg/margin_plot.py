"""Margins over a run: a line a candidate, the bound at zero, and the ground truth behind them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from trackmarshal.trace.report.reading import CANDIDATES, Lane, Rule, Run, stretches
from trackmarshal.trace.report.svg.axis import Axis, margin_axis, time_axis
from trackmarshal.trace.report.svg.element import svg, tag, text, text_width, title
from trackmarshal.trace.report.svg.timeline import Layout
from trackmarshal.trace.report.words import clock, plain, quantity, spoken_unit

HEIGHT, TOP, BOTTOM = 150.0, 10.0, 22.0


class Panel(NamedTuple):
    """Where one plot is in a picture, from its top to its foot, in pixels."""

    top: float
    foot: float


PANEL = Panel(TOP, HEIGHT - BOTTOM)
#: Room for the numbers of the vertical axis where the timeline has no gutter.
LEAST_GUTTER = 52.0
#: Beginnings of firings that are marked with a dot, for each candidate.
MOST_DOTS = 20


def margin_plot(run: Run, rule: Rule, layout: Layout, key: str) -> str:
    """The margins of one rule; `key` makes the picture's ids unique on a page."""
    start = layout.gutter or LEAST_GUTTER
    across = time_axis(run.t, run.end, start, layout.width - layout.right)
    values = [
        m for lane in rule.lanes.values() for m, letter in zip(lane.margin, lane.verdict) if letter in "sv"
    ]
    up = margin_axis(values, HEIGHT - BOTTOM, TOP)
    parts = [
        *truth_behind(run, run.asked_of([rule]), across, PANEL),
        *_grid(run, rule, across, up, layout),
    ]
    below = tag(
        "rect", x=start, y=up.at(0.0), width=across.stop - start, height=HEIGHT - BOTTOM - up.at(0.0) + 3
    )
    parts.append(tag("clipPath", below, id=f"{key}-below"))
    for candidate, lane in rule.lanes.items():
        parts += margin_line(run, candidate, lane, across, up, PANEL, key)
    parts.append(
        tag("line", x1=0.0, x2=0.0, y1=TOP, y2=HEIGHT - BOTTOM, class_="cursor", visibility="hidden")
    )
    known = [v for v in values if math.isfinite(v)]
    span = (
        f"margins from {quantity(min(known), rule.unit)} to {quantity(max(known), rule.unit)}"
        if known
        else "no finite margin"
    )
    scale = ", logarithmic on both sides of zero" if up.linear is not None else ""
    return svg(
        layout.width, HEIGHT, f"Margin of {rule.name}", f"{span}{scale}; below zero is violated.", parts, class_="plot",
        data_x0=across.start, data_x1=across.stop, data_t0=across.low, data_t1=across.high,
    )  # fmt: skip


def truth_behind(run: Run, truth: Sequence[bool | None], across: Axis, panel: Panel) -> Iterator[str]:
    """The ground truth as a tint, where it says anything."""
    for value, first, last in stretches(truth):
        if value is not None:
            x0, x1 = across.at(run.t[first]), across.at(run.end[last])
            words = f"ground truth: must be {'safe' if value else 'unsafe'}, {clock(run.t[first])} to {clock(run.t[last])} {run.time_unit}"
            yield tag(
                "rect",
                title(words),
                x=x0,
                y=panel.top,
                width=x1 - x0,
                height=panel.foot - panel.top,
                class_=f"g-{'safe' if value else 'unsafe'}",
            )


def _grid(run: Run, rule: Rule, across: Axis, up: Axis, layout: Layout) -> Iterator[str]:
    for tick in across.ticks(layout.ticks):
        yield tag("line", x1=across.at(tick), x2=across.at(tick), y1=TOP, y2=HEIGHT - BOTTOM, class_="grid")
    yield from time_words(run, across, layout, HEIGHT)
    for value in up.ticks(5):
        y = up.at(value)
        yield tag(
            "line", x1=across.start, x2=across.stop, y1=y, y2=y, class_="bound" if value == 0 else "grid"
        )
        yield text(across.start - 6, y + 4, plain(value, 3), class_="tick end")
    if layout.gutter:
        yield text(
            12,
            TOP + 10,
            f"margin in {spoken_unit(rule.unit)}" if rule.unit != "1" else "margin",
            class_="tick",
        )
        yield text(12, TOP + 26, "logarithmic away from 0" if up.linear is not None else "", class_="tick")


def time_words(run: Run, across: Axis, layout: Layout, height: float) -> Iterator[str]:
    """The times below a picture of some height."""
    ticks = across.ticks(layout.ticks)
    for tick in ticks:
        words = clock(tick) + (f" {run.time_unit}" if tick == ticks[-1] else "")
        x = min(across.at(tick), layout.width - text_width(words, layout.font) / 2 - 1)
        yield text(x, height - 7, words, class_="tick middle")


def margin_line(
    run: Run, candidate: str, lane: Lane, across: Axis, up: Axis, panel: Panel, key: str
) -> Iterator[str]:
    """The line with gaps where there is no margin, thick below the bound, dots where it fires, marks where undefined."""
    middles = [(a + b) / 2 for a, b in zip(run.t, run.end)] if run.cycles == 1 else run.t
    pieces: list[list[tuple[float, float]]] = [[]]
    for i, letter in enumerate(lane.verdict):
        if letter in "sv" and not math.isnan(lane.margin[i]):
            pieces[-1].append((middles[i], up.at(lane.margin[i])))
        elif pieces[-1]:
            pieces.append([])
    most = int(across.stop - across.start)
    path = "".join(_piece(piece, most, across) for piece in pieces if piece)
    if path:
        name = f"{key}-{candidate}"
        yield tag("defs", tag("path", id=name, d=path))
        yield tag("use", title(f"{candidate} trajectory"), href=f"#{name}", class_=f"line {candidate}")
        if "v" in lane.verdict:
            yield tag("use", href=f"#{name}", class_="line firing", clip_path=f"url(#{key}-below)")
    starts = [
        first
        for letter, first, _ in stretches(lane.verdict)
        if letter == "v" and not math.isnan(lane.margin[first])
    ]
    for first in starts[:MOST_DOTS]:
        note = title(f"{candidate}: violated from {clock(run.t[first])} {run.time_unit}")
        yield tag(
            "circle",
            note,
            cx=across.at(middles[first]),
            cy=up.at(lane.margin[first]),
            r=3.0,
            class_="firing-dot",
        )
    for letter, first, last in stretches(lane.verdict):
        if letter in "uo":
            x0, x1 = across.at(run.t[first]), across.at(run.end[last])
            word = "undefined" if letter == "u" else "open"
            y = panel.foot - (12.0 if candidate == CANDIDATES[0] else 6.0)
            note = title(f"{candidate}: {word} {clock(run.t[first])} to {clock(run.t[last])} {run.time_unit}")
            yield tag("rect", note, x=x0, y=y, width=max(x1 - x0, 1.5), height=5.0, class_=f"b-{word}")


def _piece(piece: Sequence[tuple[float, float]], most: int, across: Axis) -> str:
    """A stretch of line, of times and heights; a lone point becomes a dash that can be seen."""
    if len(piece) == 1:
        t, y = piece[0]
        return f"M{across.at(t) - 2:.1f} {y:.1f}h4"
    return "M" + "L".join(f"{across.at(t):.1f} {y:.1f}" for t, y in _bends(_extremes(piece, most)))


def _bends(piece: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The same line without points between two of the same height."""
    last = len(piece) - 1
    return [
        point
        for k, point in enumerate(piece)
        if k in (0, last) or not abs(piece[k - 1][1] - point[1]) < 0.05 > abs(piece[k + 1][1] - point[1])
    ]


def _extremes(piece: Sequence[tuple[float, float]], most: int) -> list[tuple[float, float]]:
    """At most about so many points: of each stretch of neighbours its lowest and its highest one."""
    if len(piece) <= most:
        return list(piece)
    size = math.ceil(2 * len(piece) / most)
    kept: list[tuple[float, float]] = []
    for start in range(0, len(piece), size):
        part = piece[start : start + size]
        kept += sorted({min(part, key=lambda p: p[1]), max(part, key=lambda p: p[1])})
    return kept
