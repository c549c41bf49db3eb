"""All that is shown of one rule: its forms, and the texts beside them that every format has."""

from __future__ import annotations

import math
from collections.abc import Iterator

from trackmarshal.ir.spec import PlaceInfo, RuleInfo, TableInfo
from trackmarshal.ir.tables import Way
from trackmarshal.node import Node
from trackmarshal.reading.layout import Chain, Joined, Layout, Sign
from trackmarshal.reading.rule import Reading, Setting, Shown
from trackmarshal.reading.telling import Told
from trackmarshal.reading.words import Words
from trackmarshal.source import SourceFile
from trackmarshal.syntax.format import format_text
from trackmarshal.units import digits, in_full


class Limit(Node):
    """What is said of a number that a rule was solved for: lines of text, and formulas below them."""

    said: str
    formulas: tuple[Layout, ...]


class Sheet(Node):
    """A rule for readers, in one language. Forms that were not asked for are None."""

    rule: RuleInfo
    words: Words
    spec: str | None
    reading: Reading | None
    told: Told | None
    c: str | None
    limits: tuple[Limit, ...]


def spec_text(rule: RuleInfo) -> str:
    """A rule in the one layout."""
    return format_text(SourceFile(str(rule.span.file.path), f"{rule.text.rstrip()}\n")).rstrip()


def about(rule: RuleInfo, words: Words) -> Iterator[tuple[str, str]]:
    """What a rule says of itself: labels and texts."""
    labels = words.labels
    if rule.satisfies:
        yield labels["satisfies"], words.comma.join(name for name, _ in rule.satisfies)
    if rule.severity:  # an advisory rule decides nothing, whatever it demands
        yield labels["severity"], rule.severity
    if rule.source:
        yield labels["source"], rule.source
    if rule.assuming:
        yield labels["assuming"], words.comma.join(name for name, _ in rule.assuming)
    if rule.because:
        yield labels["because"], rule.because


def beside(clause: Shown, words: Words) -> str:
    """What stands beside a clause: an author's reason, or where a rule along a timeline is judged; "" for most."""
    return (
        words.judged[clause.judged]
        if clause.judged is not None
        else f"“{clause.said}”"
        if clause.said
        else ""
    )


def value(setting: Setting) -> str:
    """The value in force, in the unit that it is written in."""
    return in_full(setting.info.value, setting.unit)


def ends(setting: Setting) -> tuple[str, str]:
    """The least and the greatest value that a configuration may choose, empty where there is none; the unit stands once."""
    lower, upper = (
        None if end is None or math.isinf(end) else end for end in (setting.info.lower, setting.info.upper)
    )
    least = "" if lower is None else (in_full if upper is None else digits)(lower, setting.unit)
    return least, "" if upper is None else in_full(upper, setting.unit)


def bounds(setting: Setting, words: Words) -> str:
    """Between which values a configuration may choose."""
    least, greatest = ends(setting)
    if least and greatest:
        return words.labels["range"].format(a=least, b=greatest)
    if least:
        return words.labels["at least"].format(a=least)
    return words.labels["at most"].format(a=greatest) if greatest else ""


def origin(setting: Setting, words: Words) -> str:
    """Where a value comes from: its source, and, where a configuration replaced the spec's, which one that was."""
    said = [setting.info.source] if setting.info.source else []
    if setting.overridden:
        was = in_full(setting.declared.value, setting.unit)
        said.append(words.labels["overridden"].format(a=setting.info.span, b=was))
    else:
        said.append(words.labels["declared"].format(a=setting.info.span))
    return "; ".join(said)


def grid(info: TableInfo) -> list[list[str]]:
    """A table's knots and values, in the units in which it is declared; the first row names these."""
    first, result = info.units
    if info.across is None:
        rows = [[digits(x, first), digits(y, result)] for x, y in zip(info.knots, info.values)]
        return [[first, result], *rows]
    columns = info.across.knots
    head = [f"{first}, {info.across.unit}: {result}", *(digits(one, info.across.unit) for one in columns)]
    return [
        head,
        *(
            [
                digits(x, first),
                *(digits(y, result) for y in info.values[k * len(columns) : (k + 1) * len(columns)]),
            ]
            for k, x in enumerate(info.knots)
        ),
    ]


def way(info: TableInfo) -> str:
    """How a table is read, as a spec says it: `linear clamp`, or of two arguments `step wrap 24 h, linear`."""
    ways = [(info.way, info.units[0])]
    if info.across is not None:
        ways.append((info.across.way, info.across.unit))
    return ", ".join(_way(*one) for one in ways)


def _way(way: Way, unit: str) -> str:
    outside = f" wrap {in_full(way.length, unit)}" if way.length else " clamp" if way.clamped else ""
    return ("step" if way.steps else "linear") + outside


def equation(head: Layout, sign: str, body: Layout) -> Layout:
    """`a = b` on one line, or on several."""
    return Chain(head, (Joined(Sign(sign), body),), True)


def placed(info: PlaceInfo, words: Words) -> str:
    """A zone or a line in a phrase: figures show what is where."""
    track = f", {info.track}" if info.track else ""
    return words.labels["points"].format(
        a=f"{info.kind} {info.name.rpartition('.')[2]}{track}", b=len(info.points)
    )
