"""Whatever is neither number nor formula, as phrases: points, lines, areas, footprints, and what a quantifier ranges over."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import assert_never

from trackmarshal import typed
from trackmarshal.reading.words import Words
from trackmarshal.syntax import ast


class Phrases:
    """Phrases for the things of one rule. What an author named is called by that name.

    shared: names of several things, in modules that do not see each other. measured: names of definitions and machines, which are "of" something, or hold for it, too.
    """

    def __init__(self, words: Words, shared: frozenset[str], measured: frozenset[str]) -> None:
        self.words = words
        self.shared, self.measured = shared, measured

    def short(self, symbol: typed.Symbol) -> str:
        """A declared name without its module, or with it where the rule knows another thing by that name."""
        return symbol.qualified if symbol.name in self.shared else symbol.name

    @abstractmethod
    def atom(self, node: typed.Number) -> str:
        """A number as one word, or one that has a letter."""

    def listed(self, phrases: Sequence[str]) -> str:
        """`a`, `a and b`, `a, b, and c`."""
        *others, last = phrases
        if not others:
            return last
        joined = self.words.last if len(others) == 1 else self.words.last_of_many
        return joined.format(a=self.words.comma.join(others), b=last)

    def signal(self, node: typed.WholeSignal) -> str:
        match node:
            case typed.Signal():
                return called(node.signal.name)
            case typed.NamedSignal():
                return called(node.name)
            case _:
                assert_never(node)

    def record(self, node: typed.Record) -> str:
        match node:
            case typed.State():
                return plain(node.signal.name)
            case typed.ParameterRecord():
                return called(self.short(node.symbol))
            case typed.Sample():
                which = self.words.first if node.index == 0 else self.words.last_sample
                return which.format(a=self.signal(node.of))
            case typed.Variable():
                return node.name
            case typed.NamedRecord():
                return called(node.name)
            case _:
                assert_never(node)

    def field(self, record: typed.Record, name: str) -> str:
        """`the speed of p`: what a field is called where its name and its dimension say so, and nothing else is called so; else by its name."""
        kind = record.shape.get(name)
        known = self.words.fields_.get((name, kind)) if isinstance(kind, tuple) else None
        if known is None or (known != name and (known in record.shape or known in self.measured)):
            known = called(name)
        said = self.words.own_field if name in self.measured else self.words.field
        return said.format(a=known, b=self.record(record))

    def member(self, node: typed.AnyMember) -> str:
        match node:
            case typed.Member() | typed.NamedMember():
                return called(node.name)
            case typed.MemberField():
                return self.field(node.record, node.name)
            case _:
                assert_never(node)

    def line(self, node: typed.Line) -> str:
        match node:
            case typed.PlacedLine():
                return called(self.short(node.symbol))
            case typed.SignalLine():
                return called(node.signal.name)
            case typed.Border():
                return self.words.border.format(a=node.field, b=self.signal(node.of))
            case typed.LaneSide():
                return self.words.border.format(a=node.field, b=self.record(node.of))
            case typed.Path():
                return self.words.path.format(a=self.signal(node.of))
            case typed.Centre():
                return self.words.centre.format(a=self.area(node.of))
            case typed.CalledLine():
                return self.line(node.line)  # which says `path` or `centre` itself
            case typed.NamedLine():
                return called(node.name)
            case _:
                assert_never(node)

    def area(self, node: typed.Area) -> str:
        match node:
            case typed.Zone():
                return called(self.short(node.symbol))
            case typed.Corridor():
                return self.signal(node.of)
            case typed.Lane():
                return self.record(node.of)
            case typed.NamedArea():
                return called(node.name)
            case _:
                assert_never(node)

    def region(self, node: typed.Region) -> str:
        words = self.words
        match node:
            case typed.Footprint():
                return words.footprint.format(a=self.record(node.body))
            case typed.FootprintAt():
                return words.footprint_at.format(
                    a=self.record(node.pose), b=self.atom(node.length), c=self.atom(node.width)
                )
            case typed.SweptSample():
                match node.function:
                    case "swept_footprint":
                        said = words.swept_footprint
                    case "swept_hull":
                        said = words.swept_hull
                    case _:
                        assert_never(node.function)
                return said.format(
                    a=self.record(node.sample), b=self.atom(node.length), c=self.atom(node.width)
                )
            case typed.Swept():
                ends = {"a": self.record(node.start), "b": self.record(node.end)}
                return words.swept.format(**ends, c=self.atom(node.length), d=self.atom(node.width))
            case typed.NamedRegion():
                return called(node.name)
            case _:
                assert_never(node)

    def machine(self, node: typed.Machine) -> str:
        """`the role of o`."""
        if node.element is None:
            return called(self.short(node.symbol))
        element = node.element
        if isinstance(element, typed.NamedRecord) and element.value is not None:
            element = element.value
        return self.words.machine.format(a=called(self.short(node.symbol)), b=self.record(element))

    def ranged(self, range_: typed.Range) -> str:
        """`sample p of plan`, `two consecutive samples p and q of plan`, `o in objects`."""
        words, of = self.words, self.signal(range_.domain)
        if len(range_.names) > 1:
            number = len(range_.names)
            said = words.numbers[number] if number < len(words.numbers) else str(number)
            return words.samples.format(n=said, a=self.listed(range_.names), b=of)
        return (words.sample if range_.signal.sequence else words.element).format(a=range_.names[0], b=of)


def plain(name: str) -> str:
    """A name as words, where its parts are words; `v_max` and `tol_s` stay as they are, and so does the module before a name."""
    module, dot, own = name.rpartition(".")
    parts = own.split("_")
    return f"{module}{dot}{' '.join(parts)}" if min(len(parts[0]), len(parts[-1])) > 1 else name


def called(name: str) -> str:
    """A name as a noun: of several words, in quotes."""
    shown = plain(name)
    return f"“{shown}”" if " " in shown else shown


def parameters_of(symbol: typed.Symbol) -> tuple[str, ...]:
    """The names of what is given to a definition."""
    assert isinstance(symbol.item, ast.Define)
    return tuple(one.name for one in symbol.item.parameters)
