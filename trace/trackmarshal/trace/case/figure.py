"""The system model as a picture: its parts on the diagonal, what passes between two of them where their row and column meet."""

from __future__ import annotations

from collections.abc import Sequence

from trackmarshal.trace.model import Interface, Subsystem
from trackmarshal.trace.report.svg.element import CHARACTER, svg, tag, text, title

_BOX, _GAP, _PAD = 104.0, 6.0, 8.0
_FAMILY = "Arial, Helvetica, 'Liberation Sans', 'DejaVu Sans', sans-serif"
_LINES, _SIZE = 3, 11.0


def chart(subsystems: Sequence[Subsystem], interfaces: Sequence[Interface], name: str) -> tuple[str, float]:
    """An N² chart as SVG, and the length of its sides: no line crosses another, however many parts there are."""
    ids = [str(one.id) for one in subsystems]
    place = {id_: number for number, id_ in enumerate(ids)}
    step = _BOX + _GAP
    size = 2 * _PAD + step * len(ids) - _GAP
    drawn: list[str] = []
    for number, one in enumerate(subsystems):
        at = _PAD + number * step
        drawn.append(_part(at, one))
    described = []
    for interface in interfaces:
        ends = interface.ends
        if len(ends) != 2 or not set(ends) <= place.keys() or ends[0] == ends[1]:
            continue
        row, column = sorted(place[end] for end in ends)
        drawn.append(_meeting(_PAD + column * step, _PAD + row * step, interface))
        described.append(f"{interface.id}: {interface.title}")
    description = "; ".join([*(f"{one.id}: {one.title}" for one in subsystems), *described])
    return svg(size, size, name, description, drawn, font_family=_FAMILY), size


def _part(at: float, one: Subsystem) -> str:
    vehicle = one.role == "vehicle"
    box = tag("rect", x=at, y=at, width=_BOX, height=_BOX, rx=6, fill="#dcedf6" if vehicle else "#f4f6f8", stroke="#1f5673", stroke_width=2 if vehicle else 1)  # fmt: skip
    middle = at + _BOX / 2
    said = [
        text(
            middle,
            at + 28,
            str(one.id),
            text_anchor="middle",
            font_size=16,
            font_weight="bold",
            fill="#16202a",
        )
    ]
    said += [
        text(middle, at + 48 + 14 * number, line, text_anchor="middle", font_size=_SIZE, fill="#16202a")
        for number, line in enumerate(_wrapped(one.title))
    ]
    return tag("g", title(f"{one.id}: {one.title}"), box, *said)


def _meeting(x: float, y: float, interface: Interface) -> str:
    """Where two parts meet: solid where it was analysed for issues, dashed where a reason stands in place of that."""
    box = tag("rect", x=x, y=y, width=_BOX, height=_BOX, rx=6, fill="#ffffff", stroke="#55626f", stroke_dasharray=None if interface.issues else "4 3")  # fmt: skip
    middle = x + _BOX / 2
    said = [
        text(
            middle,
            y + 28,
            str(interface.id),
            text_anchor="middle",
            font_size=14,
            font_weight="bold",
            fill="#16202a",
        )
    ]
    kinds = list(dict.fromkeys(flow.kind for flow in interface.flows))
    said += [
        text(middle, y + 48 + 14 * number, kind, text_anchor="middle", font_size=_SIZE, fill="#3d4a56") for number, kind in enumerate(kinds)
    ]  # fmt: skip
    return tag("g", title(f"{interface.id}: {interface.title}"), box, *said)


def _wrapped(words: str) -> list[str]:
    """At most three lines that fit into a box; what does not is cut, and stands whole in the table."""
    most = int((_BOX - 10) / (_SIZE * CHARACTER))
    lines = [""]
    for word in words.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > most:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    kept = [line if len(line) <= most else f"{line[: most - 1]}…" for line in lines[:_LINES]]
    if len(lines) > _LINES:
        kept[-1] = f"{kept[-1][: most - 1]}…"
    return kept


__all__ = ["chart"]
