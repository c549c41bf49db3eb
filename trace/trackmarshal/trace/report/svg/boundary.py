"""The boundary of a rule as a picture: where its demand is met in two of its inputs, or one, with its tests and what was recorded.

Sides are told apart by letter and by texture, tests by shape; colour says nothing that is not said so, too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from trackmarshal.trace.report.svg.axis import Axis, nice_ticks
from trackmarshal.trace.report.svg.element import CHARACTER, fitted, short, svg, tag, text, title

WIDTH, LEFT, RIGHT, TOP, FOOT = 640.0, 66.0, 14.0, 10.0, 44.0
#: How high the plane is, of two inputs and of one; a line of words below it, and their size.
HIGH, FLAT, LINE, SIZE = 340.0, 112.0, 15.0, 10.5
INDENT = 12.0
#: Where a line is broken, if it can be.
_AFTER = re.compile(r"(?<=[,;.:]) ")
FAMILY = "Arial, Helvetica, 'Liberation Sans', 'DejaVu Sans', sans-serif"
INK, SOFT, LINES = "#16202a", "#55626f", "#c3ccd4"
#: Ground and texture of each region.
_GROUNDS = {
    "holds": ("#eaf4ee", "#9cc7ad"),
    "broken": ("#fbe9e7", "#cf8a84"),
    "unknown": ("#eceff2", "#8d99a5"),
}
#: Of a test by what it expects.
_SHAPES = {"boundary": "M0-5.5L5.5 0L0 5.5L-5.5 0Z", "satisfied": "M-4.2 0a4.2 4.2 0 1 0 8.4 0a4.2 4.2 0 1 0-8.4 0Z", "violated": "M-3.9-3.9h7.8v7.8h-7.8Z"}  # fmt: skip
_TESTS, _CROSSES = "#1b3f8b", "#a11220"


class Picture(NamedTuple):
    """An SVG document, and its size in pixels."""

    svg: str
    wide: float
    high: float


def picture(drawing: Mapping[str, Any], words: Mapping[str, str], key: str) -> Picture:
    """What `trackmarshal.reading.drawing` says, drawn. words: those that begin with `drawing.`; key: makes the ids of the picture unique on a page."""
    plane = _Plane.of(drawing)
    below = list(_wrapped(_legend(drawing, words)))
    start = TOP + plane.high + FOOT
    high = start + LINE * (len(below) + 2) + 4
    name = words["drawing.name"].format(rule=drawing["rule"])
    parts = [
        *_textures(key),
        *_regions(drawing, plane, key),
        *_axes(drawing, plane),
        *_recorded(drawing, plane, words),
        *_boundaries(drawing, plane),
        *_letters(drawing, plane, words),
        *_tests(drawing, plane, words),
        *_signs(words, start),
    ]
    parts += [
        text(LEFT + indent, start + LINE * (2 + k), one, font_size=SIZE, fill=INK)
        for k, (indent, one) in enumerate(below)
    ]
    said = " ".join(_described(drawing, words))
    return Picture(svg(WIDTH, high, name, said, parts, font_family=FAMILY), WIDTH, high)


class _Plane(NamedTuple):
    """Where shares of the picture are."""

    across: Axis
    up: Axis
    high: float
    flat: bool

    @classmethod
    def of(cls, drawing: Mapping[str, Any]) -> _Plane:
        first, *second = drawing["axes"]
        high = HIGH if second else FLAT
        up = (
            Axis(second[0]["low"], second[0]["high"], TOP + high, TOP)
            if second
            else Axis(0.0, 1.0, TOP + high, TOP)
        )
        return cls(Axis(first["low"], first["high"], LEFT, WIDTH - RIGHT), up, high, not second)

    def at(self, place: Sequence[float]) -> tuple[float, float]:
        return LEFT + place[0] * (WIDTH - LEFT - RIGHT), TOP + (1.0 - place[1]) * self.high

    def path(self, places: Sequence[Sequence[float]], closed: bool = False) -> str:
        drawn = "L".join(f"{short(x)} {short(y)}" for x, y in map(self.at, places))
        return f"M{drawn}{'Z' if closed else ''}"


def _textures(key: str) -> Iterator[str]:
    dots = tag("circle", cx=3.0, cy=3.0, r=0.8, fill=_GROUNDS["holds"][1])
    stripes = tag("path", d="M-2 2L2-2M0 8L8 0M6 10L10 6", stroke=_GROUNDS["broken"][1], stroke_width=1.1)
    net = tag("path", d="M0 0L8 8M8 0L0 8", stroke=_GROUNDS["unknown"][1], stroke_width=0.8)
    sizes = {"holds": (12.0, dots), "broken": (8.0, stripes), "unknown": (8.0, net)}
    yield tag("defs", *(
        tag("pattern", tag("rect", width=size, height=size, fill=_GROUNDS[name][0]), drawn, id=f"{key}-{name}", width=size, height=size, patternUnits="userSpaceOnUse")
        for name, (size, drawn) in sizes.items()
    ))  # fmt: skip


def _regions(drawing: Mapping[str, Any], plane: _Plane, key: str) -> Iterator[str]:
    for name, region in drawing["regions"].items():
        whole = "".join(plane.path(around, closed=True) for around in region["around"])
        if whole:
            yield tag(
                "path", d=whole, fill=f"url(#{key}-{name})", fill_rule="evenodd", class_=f"region {name}"
            )


def _axes(drawing: Mapping[str, Any], plane: _Plane) -> Iterator[str]:
    low, right = TOP + plane.high, WIDTH - RIGHT
    for tick in nice_ticks(plane.across.low, plane.across.high, 8):
        x = plane.across.at(tick)
        yield tag("path", d=f"M{short(x)} {short(TOP)}V{short(low + 4)}", stroke=LINES, stroke_width=0.6)
        yield text(x, low + 16, f"{tick:g}", text_anchor="middle", font_size=SIZE, fill=SOFT)
    for tick in () if plane.flat else nice_ticks(plane.up.low, plane.up.high, 7):
        y = plane.up.at(tick)
        yield tag("path", d=f"M{short(LEFT - 4)} {short(y)}H{short(right)}", stroke=LINES, stroke_width=0.6)
        yield text(LEFT - 7, y + 3.6, f"{tick:g}", text_anchor="end", font_size=SIZE, fill=SOFT)
    yield tag("rect", x=LEFT, y=TOP, width=right - LEFT, height=plane.high, fill="none", stroke=SOFT)
    names = [_axis_name(one) for one in drawing["axes"]]
    yield text(
        (LEFT + right) / 2,
        low + 33,
        fitted(names[0], right - LEFT, 12),
        text_anchor="middle",
        font_size=12,
        fill=INK,
    )
    if not plane.flat:
        middle = TOP + plane.high / 2
        shown = fitted(names[1], plane.high, 12)
        yield text(
            14.0,
            middle,
            shown,
            text_anchor="middle",
            font_size=12,
            fill=INK,
            transform=f"rotate(-90 14 {short(middle)})",
        )


def _axis_name(axis: Mapping[str, Any]) -> str:
    return f"{axis['label']} [{axis['unit']}]" if axis["unit"] else str(axis["label"])


def _recorded(drawing: Mapping[str, Any], plane: _Plane, words: Mapping[str, str]) -> Iterator[str]:
    recorded = drawing["recorded"]
    if recorded is None:
        return
    row = 0.13
    held = "".join(
        f"M{short(x)} {short(y)}h.01"
        for x, y in (plane.at(_row(one, plane, row)) for one in recorded["held"])
    )
    if held:
        yield tag("path", title(words["drawing.held"]), d=held, stroke="#2f4858", stroke_width=2.4, stroke_linecap="round", fill="none", class_="held")  # fmt: skip
    crosses = "".join(f"M{short(x - 2.5)} {short(y - 2.5)}l5 5m0-5l-5 5" for x, y in (plane.at(_row(one, plane, row)) for one in recorded["broken"]))  # fmt: skip
    if crosses:
        yield tag("path", title(words["drawing.broken"]), d=crosses, stroke=_CROSSES, stroke_width=1.2, fill="none", class_="against")  # fmt: skip


def _row(place: Sequence[float], plane: _Plane, row: float) -> Sequence[float]:
    """Of one input, tests lie above what was recorded."""
    return (place[0], row) if plane.flat else place


def _boundaries(drawing: Mapping[str, Any], plane: _Plane) -> Iterator[str]:
    for one in drawing["others"]:
        d = "".join(map(plane.path, one["boundary"]))
        if d:
            yield tag("path", title(f"{one['letter']}: {one['with']}"), d=d, stroke=_TESTS, stroke_width=1.0, stroke_dasharray="5 3", fill="none", class_="other")  # fmt: skip
    d = "".join(map(plane.path, drawing["boundary"]))
    if d:
        yield tag(
            "path", d=d, stroke=INK, stroke_width=2.0, fill="none", stroke_linejoin="round", class_="boundary"
        )


def _letters(drawing: Mapping[str, Any], plane: _Plane, words: Mapping[str, str]) -> Iterator[str]:
    for name, region in drawing["regions"].items():
        if region["in"] is not None:
            x, y = plane.at(_row(region["in"], plane, 0.4))
            yield tag("circle", cx=x, cy=y, r=9.5, fill="#ffffff", stroke=INK, stroke_width=1.0)
            yield text(x, y + 4.5, words[f"drawing.letter.{name}"], text_anchor="middle", font_size=12.5, font_weight="bold", fill=INK)  # fmt: skip


def _tests(drawing: Mapping[str, Any], plane: _Plane, words: Mapping[str, str]) -> Iterator[str]:
    """Marks; letters after all of them, those at one place together."""
    row: dict[int, int] = {}
    letters: dict[tuple[int, int], list[str]] = {}
    for test in drawing["tests"]:
        x, y = plane.at(_row(test["at"], plane, 0.9))
        if plane.flat:  # those at one place lie below each other
            number = row[round(x / 8)] = row.get(round(x / 8), -1) + 1
            y += 11 * (number % 4)
        shape = "boundary" if test["boundary"] else test["expects"]
        beyond = words["drawing.beyond"] if test["beyond"] else ""
        said = f"{test['title']}: {words['drawing.' + shape]}{beyond}"
        yield tag("path", title(said), d=_SHAPES[shape], transform=f"translate({short(x)} {short(y)})", **_look(test["alike"]), class_=f"test {shape}")  # fmt: skip
        if test["letter"]:
            letters.setdefault((round(x), round(y)), []).append(test["letter"])
    for (at, up), several in letters.items():
        inside = -8 if at > WIDTH - RIGHT - 14 else 8
        shown = " ".join(dict.fromkeys(several))
        yield text(float(at + inside), float(up - 4), shown, font_size=11, font_weight="bold", fill=_TESTS, text_anchor="end" if inside < 0 else "start")  # fmt: skip


def _look(filled: bool) -> dict[str, object]:
    return {"fill": _TESTS if filled else "#ffffff", "stroke": "#ffffff" if filled else _TESTS, "stroke_width": 1.0 if filled else 1.6}  # fmt: skip


def _signs(words: Mapping[str, str], y: float) -> Iterator[str]:
    """What the shapes of tests mean."""
    x = LEFT
    for shape, drawn in _SHAPES.items():
        said = words[f"drawing.{shape}"]
        yield tag(
            "path", d=drawn, transform=f"translate({short(x + 5)} {short(y + LINE - 4)})", **_look(True)
        )
        yield text(x + 14, y + LINE, said, font_size=SIZE, fill=INK)
        x += 30 + len(said) * SIZE * CHARACTER
    yield text(x, y + LINE, words["drawing.hollow"], font_size=SIZE, fill=INK)


def _legend(drawing: Mapping[str, Any], words: Mapping[str, str]) -> Iterator[str]:
    """The lines below: what the letters mean, what the others are fixed at, how many samples there are."""
    yield words["drawing.letters"]
    if drawing["fixed"]:
        yield words["drawing.fixed"].format(
            values=", ".join(f"{name} = {value}" for name, value in drawing["fixed"])
        )
    for one in drawing["others"]:
        yield words["drawing.other"].format(letter=one["letter"], values=one["with"])
    if drawing["unusable"]:
        yield words["drawing.unusable"].format(names=", ".join(drawing["unusable"]))
    if drawing["hides"]:
        yield words["drawing.hides"]
    recorded = drawing["recorded"]
    if recorded is None:
        yield words["drawing.unrecorded"]
        return
    held, broken = recorded["seen"]
    yield words["drawing.seen"].format(runs=f"{drawing['runs']:,}", held=f"{held:,}", shown=f"{len(recorded['held']):,}", broken=f"{broken:,}")  # fmt: skip
    if any(recorded["beyond"]) or recorded["lost"]:
        yield words["drawing.rest"].format(held=f"{recorded['beyond'][0]:,}", broken=f"{recorded['beyond'][1]:,}", lost=f"{recorded['lost']:,}")  # fmt: skip


def _wrapped(lines: Iterator[str]) -> Iterator[tuple[float, str]]:
    """Lines that fit into the width, broken behind commas where that will do; and by how much each is moved in, as those are that go on."""
    most = int((WIDTH - LEFT - RIGHT - INDENT) / (SIZE * CHARACTER * 0.93))
    for line in lines:
        parts = [
            word for part in _AFTER.split(line) for word in ([part] if len(part) <= most else part.split(" "))
        ]
        made, indent = parts[0], 0.0
        for part in parts[1:]:
            if len(made) + 1 + len(part) > most:
                yield indent, made
                made, indent = part, INDENT
            else:
                made = f"{made} {part}"
        yield indent, made


def _described(drawing: Mapping[str, Any], words: Mapping[str, str]) -> Iterator[str]:
    """The picture in words, for those who do not see it."""
    names = [_axis_name(one) for one in drawing["axes"]]
    yield words["drawing.axes"].format(inputs=" / ".join(reversed(names)))
    yield from _legend(drawing, words)


__all__ = ["Picture", "picture"]
