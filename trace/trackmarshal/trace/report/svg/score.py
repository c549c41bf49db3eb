"""The paper's Fig. 6 for any run: the score of each trajectory in its envelope, what is driven, and the margin of every requirement."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

from trackmarshal.trace.report.reading import CANDIDATES, Run, stretches
from trackmarshal.trace.report.scores import Score
from trackmarshal.trace.report.svg.axis import Axis, time_axis
from trackmarshal.trace.report.svg.bands import overall
from trackmarshal.trace.report.svg.element import fitted, short, svg, tag, text, text_width, title
from trackmarshal.trace.report.svg.margin_plot import (
    LEAST_GUTTER,
    Panel,
    margin_line,
    time_words,
    truth_behind,
)
from trackmarshal.trace.report.svg.timeline import Layout, drawn_row

TOP, FOOT = 8.0, 24.0
#: Heights of the score, and of one requirement; between them is a gap.
SCORE, STRIP, GAP = 58.0, 62.0, 12.0


@dataclass(frozen=True, slots=True)
class Bent(Axis):
    """From -infinity to infinity on a finite length: 1 is half-way from 0 to the end, 3 three quarters. 0 is the limit."""

    def at(self, value: float) -> float:
        share = math.copysign(1.0, value) if math.isinf(value) else value / (1.0 + abs(value))
        return self.start + (share + 1.0) / 2.0 * (self.stop - self.start)


def score_figure(run: Run, found: Sequence[Score], layout: Layout, key: str) -> str:
    """All of it on one axis of time; `key` makes the picture's ids unique on a page."""
    start = layout.gutter or LEAST_GUTTER
    across = time_axis(run.t, run.end, start, layout.width - layout.right)
    panel = Panel(TOP + layout.above, TOP + layout.above + SCORE)
    drawn, y = list(_total(run, across, layout, panel)), panel.foot + GAP
    row, y = drawn_row(overall(run).rows[-1], run, across, layout, y)
    drawn += row
    y += GAP / 2
    for number, score in enumerate(found):
        y += layout.above
        panel = Panel(y, y + STRIP)
        drawn += _requirement(run, score, across, layout, panel, f"{key}-{number}")
        y = panel.foot + GAP
    height = y + FOOT - GAP
    grid = [
        tag("line", x1=across.at(tick), x2=across.at(tick), y1=TOP, y2=y - GAP, class_="grid")
        for tick in across.ticks(layout.ticks)
    ]
    cursor = tag("line", x1=0.0, x2=0.0, y1=TOP, y2=y - GAP, class_="cursor", visibility="hidden")
    unsafe = {c: sum(value is False for value in run.safe[c]) for c in CANDIDATES}
    spoken = ", ".join(f"{c} trajectory unsafe in {n} of {run.cycles} cycles" for c, n in unsafe.items())
    return svg(
        layout.width, height, "Safety score s_tot and the margin of each requirement", f"{spoken}. The table below says the same in words.",
        [*grid, *drawn, *time_words(run, across, layout, height), cursor], class_="plot",
        data_x0=across.start, data_x1=across.stop, data_t0=across.low, data_t1=across.high,
    )  # fmt: skip


def _total(run: Run, across: Axis, layout: Layout, panel: Panel) -> Iterator[str]:
    """s_tot: whether all rules together call each candidate safe, and between which bounds the ground truth wants it."""
    up = Axis(-0.25, 1.25, panel.foot, panel.top)
    yield from truth_behind(run, run.whole_truth(), across, panel)
    x, y = (12.0, panel.top + 12) if layout.gutter else (layout.start, panel.top - 6)
    yield tag("text", "s", tag("tspan", "tot", dy=3, font_size=9), x=x, y=y, class_="group")
    yield text(x + 26, y, "all rules together", class_="tick")
    for value, words in ((1.0, "safe"), (0.0, "unsafe")):
        yield tag("line", x1=across.start, x2=across.stop, y1=up.at(value), y2=up.at(value), class_="grid")
        yield text(across.start - 6, up.at(value) + 4, words, class_="tick end")
    yield from _envelope(run, across, up, layout)
    for index, candidate in enumerate(CANDIDATES):
        steps: list[str] = []
        shift = 1.5 if index else -1.5
        for safe, first, last in stretches(run.safe[candidate]):
            if safe is not None:
                y = up.at(float(safe)) + shift
                joined = steps and run.safe[candidate][first - 1] is not None
                steps.append(
                    f"{'L' if joined else 'M'}{short(across.at(run.t[first]))} {short(y)}H{short(across.at(run.end[last]))}"
                )
        if steps:
            yield tag("path", title(f"{candidate} trajectory"), d="".join(steps), class_=f"line {candidate}")


def _envelope(run: Run, across: Axis, up: Axis, layout: Layout) -> Iterator[str]:
    """Between which bounds the ground truth wants the score, dotted, with what it asks for in words."""
    names = {True: "must be safe", False: "must be unsafe", None: "either"}
    truth = run.whole_truth()
    upper, lower = list[str](), list[str]()
    for value, first, last in stretches(truth):
        x0, x1 = across.at(run.t[first]), across.at(run.end[last])
        joint = "L" if upper else "M"
        upper.append(f"{joint}{short(x0)} {short(up.at(1.14 if value is not False else -0.14))}H{short(x1)}")
        lower.append(f"{joint}{short(x0)} {short(up.at(0.86 if value else -0.14))}H{short(x1)}")
        if text_width(names[value], layout.font) + 6 <= x1 - x0:
            yield text((x0 + x1) / 2, up.at(0.5) + 4, names[value], class_="tick middle")
    if any(value is not None for value in truth):
        yield tag(
            "path",
            title("envelope of the ground truth"),
            d="".join(upper + lower),
            class_="bound",
            fill="none",
        )


def _requirement(
    run: Run, score: Score, across: Axis, layout: Layout, panel: Panel, key: str
) -> Iterator[str]:
    up = Bent(-1.0, 1.0, panel.foot, panel.top)
    yield from truth_behind(run, run.asked_of(score.rules), across, panel)
    name = score.requirement or "without a requirement"
    if layout.gutter:
        room = layout.gutter - 52
        yield text(12.0, panel.top + 14, fitted(name, room, layout.font), class_="group")
        words = escape(fitted(score.title, room, layout.font))
        yield tag("text", title(score.title), words, x=12.0, y=panel.top + 30, class_="tick")
        yield text(
            12.0, panel.top + 46, f"{len(score.rules)} rule{'s' * (len(score.rules) != 1)}", class_="tick"
        )
    else:
        yield text(
            layout.start,
            panel.top - 6,
            fitted(f"{name}  {score.title}", layout.width - 24, layout.font),
            class_="group",
        )
    for value, words in ((1.0, "1"), (0.0, "0"), (-1.0, "−1")):
        y = up.at(value)
        yield tag(
            "line", x1=across.start, x2=across.stop, y1=y, y2=y, class_="bound" if value == 0 else "grid"
        )
        yield text(across.start - 6, y + 4, words, class_="tick end")
    yield tag(
        "rect",
        x=across.start,
        y=panel.top,
        width=across.stop - across.start,
        height=panel.foot - panel.top,
        class_="b-frame",
    )
    below = tag(
        "rect",
        x=across.start,
        y=up.at(0.0),
        width=across.stop - across.start,
        height=panel.foot - up.at(0.0) + 3,
    )
    yield tag("clipPath", below, id=f"{key}-below")
    for candidate, lane in score.lanes.items():
        yield from margin_line(run, candidate, lane, across, up, panel, key)
