"""Roads from pieces: a reference line of lines, arcs and clothoids, and its borders."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Protocol

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content
from trackmarshal.scenarios.curve import Pose, advance
from trackmarshal.scenarios.generate import document
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.recording import Track
from trackmarshal.scenarios.trajectory import wrap

#: How exactly a closed line has to meet its start, m and rad.
CLOSURE = 1e-6
MAX_LENGTH = 100_000.0


class Piece(NamedTuple):
    """A stretch of the reference line: curvature kappa at its start, changing by `sharpness` 1/m^2."""

    begin: float
    length: float
    start: Pose
    kappa: float
    sharpness: float

    def pose(self, s: float) -> Pose:
        return advance(self.start, self.kappa, self.sharpness, s - self.begin)

    def curvature(self, s: float) -> float:
        return self.kappa + self.sharpness * (s - self.begin)


class Widening(NamedTuple):
    """Ground beside the road that may be driven on, such as a pit lane: `by` m on one side ("left", "right").

    It begins at `begin` and ends at `end`, m along the road; `taper` is the length over which it opens and closes.
    """

    side: str
    begin: float
    end: float
    by: float
    taper: float

    def at(self, s: float) -> float:
        """How much wider the side is at s, m."""
        inside = min(s - self.begin, self.end - s)
        return self.by * min(1.0, max(0.0, inside / self.taper))


class Line(Protocol):
    """What a vehicle follows: a line with poses and curvatures by arc length."""

    def pose(self, s: float) -> Pose: ...

    def curvature(self, s: float) -> float: ...


class Road:
    """A road along a reference line, its middle, as wide everywhere but for widenings; s in m along it, d in m to its left."""

    def __init__(
        self,
        pieces: list[Piece],
        width: float,
        closed: bool,
        spacing: float,
        widenings: tuple[Widening, ...] = (),
        name: str = "",
    ) -> None:
        self.pieces = pieces
        self.name = name
        self.width = width
        self.closed = closed
        self.spacing = spacing
        self.widenings = widenings
        self._begins = [piece.begin for piece in pieces]
        self.length = pieces[-1].begin + pieces[-1].length

    def piece(self, s: float) -> tuple[Piece, float]:
        """The piece at s, and s on this lap. Raises D152 beyond the ends of an open road."""
        if self.closed:
            s = math.fmod(s, self.length)
            s = s + self.length if s < 0.0 else s
        elif not 0.0 <= s <= self.length:
            message = f"s = {s:.1f} m lies beyond the road, which is {self.length:.1f} m long"
            raise TrackmarshalError("D152", message, help="start later, end earlier, or lengthen the road")
        return self.pieces[max(0, bisect_right(self._begins, s) - 1)], s

    def pose(self, s: float) -> Pose:
        """The pose of the reference line at s."""
        piece, s = self.piece(s)
        return piece.pose(s)

    def curvature(self, s: float) -> float:
        """The curvature of the reference line at s, 1/m."""
        piece, s = self.piece(s)
        return piece.curvature(s)

    def edges(self, s: float) -> tuple[float, float]:
        """The offsets of the right and the left border at s, m."""
        s = self.piece(s)[1]
        wider = {"left": 0.0, "right": 0.0}
        for widening in self.widenings:
            wider[widening.side] += widening.at(s)
        return -0.5 * self.width - wider["right"], 0.5 * self.width + wider["left"]

    def borders(self) -> Track:
        """Both borders as polygons with a corner about every `spacing` m, corners exactly on the borders.

        The first points of a closed road are not repeated at its end.
        """
        count = max(2, math.ceil(self.length / self.spacing))
        last = count if self.closed else count + 1
        stations = [min(self.length, self.length * i / count) for i in range(last)]
        sides: Track = {"left": [], "right": []}
        for s in stations:
            x, y, heading = self.pose(s)
            right, left = self.edges(s)
            for side, d in (("left", left), ("right", right)):
                sides[side].append([round(x - d * math.sin(heading), 6), round(y + d * math.cos(heading), 6)])
        return {**sides, "closed": self.closed, **({"name": self.name} if self.name else {})}


class Backwards:
    """The reference line of a road, followed the other way; its arc length is `length - s`."""

    def __init__(self, road: Road) -> None:
        self._road = road

    def pose(self, s: float) -> Pose:
        x, y, heading = self._road.pose(self._road.length - s)
        return x, y, heading + math.pi

    def curvature(self, s: float) -> float:
        return -self._road.curvature(self._road.length - s)


def load(path: Path, shown: str, widenings: tuple[Widening, ...] = ()) -> Road:
    """The road of a track declaration (format trackmarshal-track). Raises D120, D124, D126, D150 to D152."""
    item = document.read(content.read(path, shown), shown)
    fields = expect(
        item, "trackmarshal-track", ("name", "width", "pieces"), ("closed", "start", "spacing", "repeat")
    )
    width = fields["width"].number(3.0, 100.0)
    closed = fields["closed"].flag() if "closed" in fields else False
    spacing = fields["spacing"].number(0.2, 50.0) if "spacing" in fields else 5.0
    repeat = fields["repeat"].count(1, 100) if "repeat" in fields else 1
    start = (0.0, 0.0, 0.0)
    if "start" in fields:
        place = fields["start"].fields(("x", "y", "heading"))
        start = (place["x"].number(), place["y"].number(), place["heading"].number(-7.0, 7.0))
    shapes = [shape for piece in fields["pieces"].items() for shape in _shapes(piece)]
    pieces, end = _lay(shapes * repeat, start, fields["pieces"], 0.5 * width)
    if closed:
        apart = math.hypot(end[0] - start[0], end[1] - start[1])
        if apart > CLOSURE or abs(wrap(end[2] - start[2])) > CLOSURE:
            turn = wrap(end[2] - start[2])
            message = f"the line ends {apart:.6g} m and {turn:.6g} rad from its start"
            raise fields["pieces"].wrong(message, "two equal halves of half a turn each always meet", "D152")
    return Road(pieces, width, closed, spacing, widenings, fields["name"].text())


def expect(item: Item, format_: str, needed: Iterable[str], optional: Iterable[str]) -> dict[str, Item]:
    """The fields of a document, which says that it has this format, in the one version there is."""
    item.expect(format_)
    fields = item.fields(("format", "version", *needed), optional)
    fields["version"].count(1, 1)
    return fields


class _Shape(NamedTuple):
    """length in m; end curvature in 1/m; a clothoid begins with the curvature that the line has there."""

    item: Item
    length: float
    begin: float | None
    end: float


def _shapes(piece: Item) -> list[_Shape]:
    """`line`, `arc` (with clothoids at both ends where `transition` is given) or `clothoid`."""
    found = piece.any_fields()
    if len(found) != 1:
        raise piece.wrong(f"{len(found)} keys", "a piece is one of line, arc, clothoid")
    kind, item = next(iter(found.items()))
    if kind == "line":
        return [_Shape(item, item.fields(("length",))["length"].number(0.1, MAX_LENGTH), 0.0, 0.0)]
    if kind == "clothoid":
        fields = item.fields(("length", "to_curvature"))
        length = fields["length"].number(0.1, MAX_LENGTH)
        return [_Shape(item, length, None, fields["to_curvature"].number(-1.0, 1.0))]
    if kind == "arc":
        fields = item.fields(("radius", "angle"), ("transition",))
        radius = fields["radius"].number()
        angle = math.radians(fields["angle"].number(0.1, 360.0))
        if abs(radius) < 1.0:
            raise fields["radius"].wrong(f"{radius:g} m is too tight", "positive turns left, negative right")
        transition = fields["transition"].number(0.0, 10_000.0) if "transition" in fields else 0.0
        length = angle * abs(radius) - transition  # both clothoids together turn by transition / radius
        if length < 0.0:
            message = f"clothoids of {transition:g} m turn by more than the angle"
            raise item.wrong(message, "shorten them, or widen radius or angle", "D152")
        kappa = 1.0 / radius
        ends = [_Shape(item, transition, 0.0, kappa)], [_Shape(item, transition, kappa, 0.0)]
        middle = [_Shape(item, length, kappa, kappa)]
        return [*ends[0], *middle, *ends[1]] if transition > 0.0 else middle
    raise item.wrong(f"`{kind}` is no piece", "a piece is one of line, arc, clothoid")


def _lay(shapes: list[_Shape], start: Pose, item: Item, half: float) -> tuple[list[Piece], Pose]:
    """Pieces end to end from the start, and the pose at the end."""
    pieces: list[Piece] = []
    pose, s, kappa = start, 0.0, 0.0
    for shape in shapes:
        begin = kappa if shape.begin is None else shape.begin
        if max(abs(begin), abs(shape.end)) * half >= 1.0:
            raise shape.item.wrong("the bend is tighter than half the width", "widen it", "D152")
        if shape.length > 0.0:
            sharpness = (shape.end - begin) / shape.length
            pieces.append(Piece(s, shape.length, pose, begin, sharpness))
            pose = advance(pose, begin, sharpness, shape.length)
            s += shape.length
        kappa = shape.end
        if s > MAX_LENGTH:
            raise item.wrong(f"the road is longer than {MAX_LENGTH:g} m", "shorten it", "D152")
    if not pieces:
        raise item.wrong("the list is empty", "a road needs pieces")
    return pieces, pose
