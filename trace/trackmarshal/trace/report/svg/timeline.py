"""The verdict timeline (the paper's Fig. 6, as bands): ground truth, candidates, decision, then a row a rule."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape

from trackmarshal.trace.report.reading import Run, stretches
from trackmarshal.trace.report.svg.axis import Axis, time_axis
from trackmarshal.trace.report.svg.bands import Lane, Row, Segment, overall, rule_groups
from trackmarshal.trace.report.svg.element import fitted, short, svg, tag, text, text_width, title
from trackmarshal.trace.report.words import clock, count


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes in pixels; without a gutter, labels stand above their rows."""

    width: float
    gutter: float
    lane: float
    font: float
    ticks: int
    right: float = 12.0

    @property
    def above(self) -> float:
        return 0.0 if self.gutter else self.font + 5.0

    @property
    def start(self) -> float:
        return self.gutter or 16.0


WIDE = Layout(width=1000.0, gutter=236.0, lane=11.0, font=12.0, ticks=16)
NARROW = Layout(width=380.0, gutter=0.0, lane=11.0, font=12.0, ticks=7)
HEAD, GROUP_HEAD, GAP = 24.0, 24.0, 6.0
#: Size of the words inside bands, as in the page's style; they are bold.
SMALL = 9.5
#: More stretches than this in one lane are drawn as columns of COLUMN pixels, without words and notes.
MOST_SEGMENTS, COLUMN = 80, 2.0


def timeline(run: Run, layout: Layout, requirement_titles: Mapping[str, str]) -> str:
    """The picture of one run; all times of one column line up with those of the margin plots."""
    groups = [overall(run), *rule_groups(run, requirement_titles)]
    axis = time_axis(run.t, run.end, layout.start, layout.width - layout.right)
    body: list[str] = []
    y = HEAD
    for group in groups:
        body.append(text(4.0, y + 16.0, fitted(group.heading, layout.width - 8, layout.font), class_="group"))
        y += GROUP_HEAD
        for row in group.rows:
            drawn, y = drawn_row(row, run, axis, layout, y)
            body += drawn
    height = y + HEAD
    grid = list(_time_ticks(run, axis, layout, height))
    description = f"{count(run.cycles, 'cycle')}; {count(len(run.fired), 'rule')} fired. The table below says the same in words."
    return svg(
        layout.width, height, f"Verdict timeline of {run.name}", description, [*grid, *body, _cursor(height)], class_="plot",
        data_x0=axis.start, data_x1=axis.stop, data_t0=axis.low, data_t1=axis.high,
    )  # fmt: skip


def _time_ticks(run: Run, axis: Axis, layout: Layout, height: float) -> Iterator[str]:
    ticks = axis.ticks(layout.ticks)
    for tick in ticks:
        x = axis.at(tick)
        yield tag("line", x1=x, x2=x, y1=HEAD - 4, y2=height - HEAD + 4, class_="grid")
        words = clock(tick) + (f" {run.time_unit}" if tick == ticks[-1] else "")
        for y in (HEAD - 8, height - 8):
            yield text(
                min(x, layout.width - text_width(words, layout.font) / 2 - 1), y, words, class_="tick middle"
            )


def drawn_row(row: Row, run: Run, axis: Axis, layout: Layout, y: float) -> tuple[list[str], float]:
    """The row's elements, and where the next one starts."""
    lane_height = layout.lane + (4.0 if len(row.lanes) == 1 else 0.0)
    height = lane_height * len(row.lanes) + (len(row.lanes) - 1)
    drawn: list[str] = []
    if layout.gutter:
        words = fitted(row.label, layout.gutter - 28, layout.font)
        drawn.append(
            tag("text", title(row.note), escape(words), x=12.0, y=y + height / 2 + 4, class_="label")
        )
    else:
        drawn.append(
            tag(
                "text",
                title(row.note),
                escape(fitted(row.label, layout.width - 16, layout.font)),
                x=layout.start,
                y=y + layout.font - 1,
                class_="label",
            )
        )
        y += layout.above
    for lane in row.lanes:
        if lane.mark:
            drawn.append(text(layout.start - 12, y + lane_height - 2.5, lane.mark, class_="mark"))
        drawn += _lane(lane, run, axis, y, lane_height)
        y += lane_height + 1
    return drawn, y - 1 + GAP + (6.0 if any(lane.flags for lane in row.lanes) else 0.0)


def _lane(lane: Lane, run: Run, axis: Axis, y: float, height: float) -> Iterator[str]:
    if len(lane.segments) > MOST_SEGMENTS:
        yield from _dense(lane.segments, run, axis, y, height)
    else:
        for segment in lane.segments:
            x0, x1 = _span(segment, run, axis)
            words = next((w for w in segment.words if text_width(w, SMALL) * 1.1 + 4 <= x1 - x0), "")
            box = tag(
                "rect",
                title(segment.note),
                x=x0,
                y=y,
                width=max(x1 - x0, 1.2),
                height=height,
                class_=f"b-{segment.style}",
            )
            yield box
            if words:
                yield text((x0 + x1) / 2, y + height / 2 + 3.4, words, class_=f"w-{segment.style}")
    for flag in lane.flags:
        x0, x1 = _span(flag, run, axis)
        yield tag(
            "path",
            title(flag.note),
            d=f"M{short(x0)} {short(y + height + 2)}h{short(max(x1 - x0, 2))}v4h-{short(max(x1 - x0, 2))}Z",
            class_="b-outside",
        )


def _dense(segments: Sequence[Segment], run: Run, axis: Axis, y: float, height: float) -> Iterator[str]:
    """Columns of a few pixels, each with the worst that is in it, as one path a style: nothing unsafe is lost."""
    columns: dict[int, str] = {}
    for segment in segments:
        x0, x1 = _span(segment, run, axis)
        for column in range(
            int((x0 - axis.start) / COLUMN),
            max(int((x0 - axis.start) / COLUMN) + 1, math.ceil((x1 - axis.start) / COLUMN)),
        ):
            columns[column] = max(columns.get(column, ""), segment.style, key=_badness)
    paths: dict[str, list[str]] = {}
    for style, first, last in stretches(columns.get(i, "") for i in range(max(columns) + 1)):
        x, wide = axis.start + first * COLUMN, (last - first + 1) * COLUMN
        paths.setdefault(style, []).append(
            f"M{short(x)} {short(y)}h{short(wide)}v{short(height)}h-{short(wide)}"
        )
    for style, drawn in paths.items():
        if style:
            amount = sum(segment.style == style for segment in segments)
            yield tag(
                "path",
                title(count(amount, f"{style} stretch", f"{style} stretches")),
                d="".join(drawn),
                class_=f"b-{style}",
            )


def _badness(style: str) -> int:
    return _ORDER.index(style) if style in _ORDER else 0


#: From mildest to worst.
_ORDER = (
    "", "absent", "free", "inactive", "satisfied", "drive", "must-safe", "must-unsafe", "previous", "nothing", "open", "undefined",
    "violated",
)  # fmt: skip


def _span(segment: Segment, run: Run, axis: Axis) -> tuple[float, float]:
    return axis.at(run.t[segment.first]), axis.at(run.end[segment.last])


def _cursor(height: float) -> str:
    return tag(
        "line", x1=0.0, x2=0.0, y1=HEAD - 4, y2=height - HEAD + 4, class_="cursor", visibility="hidden"
    )


def strip(run: Run) -> str:
    """The decision of every cycle on one small band, for the index."""
    width, height = 260.0, 16.0
    group = overall(run)
    axis = time_axis(run.t, run.end, 0.0, width)
    parts = list(_lane(group.rows[-1].lanes[0], run, axis, 0.0, height)) if run.cycles else []
    return svg(
        width,
        height,
        f"What is driven in {run.name}",
        "; ".join(_spoken(group.rows[-1])),
        parts,
        class_="strip",
        preserveAspectRatio="none",
    )


def _spoken(row: Row) -> list[str]:
    return [segment.note for lane in row.lanes for segment in lane.segments[:20]]
