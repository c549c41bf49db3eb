"""Elements of SVG as text: escaped attributes, short numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from html import escape

#: Average width of a character, as a share of the font's size: to keep labels apart.
CHARACTER = 0.56


def tag(name: str, *children: str, **attributes: object) -> str:
    """An element; `class_` is `class`, other underscores are hyphens, None leaves an attribute out."""
    parts = [f' {_name(key)}="{_value(value)}"' for key, value in attributes.items() if value is not None]
    inside = "".join(children)
    return f"<{name}{''.join(parts)}>{inside}</{name}>" if inside else f"<{name}{''.join(parts)}/>"


def text(x: float, y: float, words: str, **attributes: object) -> str:
    """Words at a place; they are escaped."""
    return tag("text", escape(words), x=x, y=y, **attributes)


def title(words: str) -> str:
    """What is shown when a pointer rests on the element around it, and read by screen readers."""
    return tag("title", escape(words)) if words else ""


def svg(
    width: float, height: float, name: str, description: str, children: Iterable[str], **attributes: object
) -> str:
    """A picture with its name and text equivalent; it scales with its container. Stands alone as XML, too."""
    return tag(
        "svg", title(name), tag("desc", escape(description)), *children,
        xmlns="http://www.w3.org/2000/svg", viewBox=f"0 0 {short(width)} {short(height)}", role="img", aria_label=name,
        **{"width": width, "height": height, **attributes},
    )  # fmt: skip


def points(pairs: Iterable[tuple[float, float]], closed: bool = False) -> str:
    """The `d` of a path through points."""
    drawn = "L".join(f"{short(x)} {short(y)}" for x, y in pairs)
    return f"M{drawn}{'Z' if closed else ''}" if drawn else ""


def short(value: float) -> str:
    """A coordinate to a hundredth of a pixel."""
    rounded = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if rounded == "-0" else rounded


def thinned(pairs: Sequence[tuple[float, float]], least: float) -> list[tuple[float, float]]:
    """Points without those that are nearer than `least` to the last one kept; both ends stay."""
    kept = list(pairs[:1])
    for point in pairs[1:]:
        across, down = point[0] - kept[-1][0], point[1] - kept[-1][1]
        if across * across + down * down >= least * least:
            kept.append(point)
    if pairs and kept[-1] != pairs[-1]:
        kept.append(pairs[-1])
    return kept


def text_width(words: str, size: float) -> float:
    return len(words) * size * CHARACTER


def fitted(words: str, width: float, size: float) -> str:
    """Words cut to a width, with an ellipsis."""
    room = int(width / (size * CHARACTER))
    return words if len(words) <= room else words[: max(1, room - 1)] + "…"


@cache
def _name(key: str) -> str:
    return key.rstrip("_").replace("_", "-")


def _value(value: object) -> str:
    return short(value) if isinstance(value, float) else escape(str(value), quote=True)
