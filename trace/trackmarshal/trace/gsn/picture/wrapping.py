"""Text in lines of a width, by the widths of letters of DejaVu Sans: the widest of the fonts that pictures ask for, so that lines fit in whichever there is."""

from __future__ import annotations

import re

#: Advance widths in thousandths of the font's size, as DejaVu Sans has them.
_BY_WIDTH = {
    275: "'", 278: 'ijl', 295: 'IJ', 318: ' ,.', 337: '/:;\\|', 352: 'f', 361: '-', 390: '()[]', 392: 't', 401: '!', 411: 'r', 460: '"', 500: '*_`', 521: 's', 525: 'z', 531: '?', 550: 'c', 557: 'L', 575: 'F', 579: 'k', 592: 'vxy', 603: 'P', 611: 'TY', 612: 'o', 613: 'a', 615: 'e', 632: 'E', 635: 'Sbdgpqhnu', 636: '$0123456789{}', 656: 'K', 685: 'AVXZB', 698: 'CR', 732: 'U', 750: 'HN', 775: 'DG', 787: 'OQ&', 818: 'w', 838: '#+<=>^~', 863: 'M', 950: '%', 974: 'm', 989: 'W', 1000: '@',
}  # fmt: skip
_WIDTHS = {char: width for width, chars in _BY_WIDTH.items() for char in chars}
#: Of other letters: of Latin, Greek and Cyrillic ones at most so much but for a few, of all others as much as a square.
_LETTER, _SQUARE = 850, 1000
_BOLD = 1.13
#: Where a long word may be broken.
_JOINTS = re.compile(r"(?<=[/_.:,-])")


def width(text: str, size: float, bold: bool = False) -> float:
    """The width of a text in a font of a size, in the same unit."""
    thousandths = sum(_WIDTHS.get(char, _LETTER if char < "\u0500" else _SQUARE) for char in text)
    return thousandths * size / 1000 * (_BOLD if bold else 1.0)


def wrapped(text: str, room: float, size: float, most: int, bold: bool = False) -> list[str]:
    """The text in lines that fit, at most so many, the last one with an ellipsis where there is more. Raises ValueError where no letter fits."""
    if room < size:
        raise ValueError(f"a line of {room} for a font of {size}")
    lines = [""]
    for word in text.split():
        for number, part in enumerate(_pieces(word, room, size, bold)):
            joined = f"{lines[-1]} {part}" if lines[-1] and number == 0 else lines[-1] + part
            if width(joined, size, bold) <= room:
                lines[-1] = joined
            else:
                lines.append(part)
    if len(lines) <= most:
        return lines
    last = lines[most - 1]
    while last and width(f"{last}…", size, bold) > room:
        last = last[:-1]
    return [*lines[: most - 1], f"{last.rstrip()}…"]


def _pieces(word: str, room: float, size: float, bold: bool) -> list[str]:
    """A word, in pieces where it is too long for a line: at joints, or else anywhere."""
    if width(word, size, bold) <= room:
        return [word]
    found: list[str] = []
    for part in filter(None, _JOINTS.split(word)):
        piece = ""
        for char in part:
            if width(piece + char, size, bold) > room:
                found.append(piece)
                piece = ""
            piece += char
        found.append(piece)
    return found


__all__ = ["width", "wrapped"]
