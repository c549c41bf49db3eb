"""Whatever is neither number nor formula, as layouts: signals, records, members, lines, areas, footprints, state machines."""

from __future__ import annotations

from abc import abstractmethod
from typing import assert_never

from trackmarshal import typed
from trackmarshal.reading import layout as at
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.scope import Scope


class Things(Scope):
    """Writes the things of one rule."""

    @abstractmethod
    def number(self, node: typed.Number, least: int = 0) -> Layout:
        """A number; `least`: in parentheses, where it holds together less than this."""

    def field(self, record: typed.Record, name: str) -> Layout:
        """`v` of `p`, with the record as its index."""
        return self.names.field(self.record(record), name)

    def signal(self, node: typed.WholeSignal) -> Layout:
        match node:
            case typed.Signal():
                return at.Name(node.signal.name)
            case typed.NamedSignal():
                if not self.inside or node.value is None:
                    return self.local(node.name)
                with self.left():
                    return self.signal(node.value)
            case _:
                assert_never(node)

    def record(self, node: typed.Record) -> Layout:
        match node:
            case typed.State():
                return at.Name(node.signal.name)
            case typed.ParameterRecord():
                return at.Name(node.symbol.name)
            case typed.Sample():
                of, which = self.signal(node.of), "first" if node.index == 0 else "last"
                return (
                    at.Name(f"{of.text}.{which}") if isinstance(of, at.Name) else at.Index(of, at.Word(which))
                )
            case typed.Variable():
                return at.Name(self.variable(node.range, node.offset))
            case typed.NamedRecord():
                if not self.inside or node.value is None:
                    return self.local(node.name)
                with self.left():
                    return self.record(node.value)
            case _:
                assert_never(node)

    def member(self, node: typed.AnyMember) -> Layout:
        match node:
            case typed.Member():
                return self.names.of("member", node.name, node.name)
            case typed.MemberField():
                return self.field(node.record, node.name)
            case typed.NamedMember():
                if not self.inside or node.value is None:
                    return self.local(node.name)
                with self.left():
                    return self.member(node.value)
            case _:
                assert_never(node)

    def line(self, node: typed.Line) -> Layout:
        match node:
            case typed.PlacedLine():
                return self.named("place", node.symbol)
            case typed.SignalLine():
                return at.Name(node.signal.name)
            case typed.Border():
                return at.Index(at.Name(node.field), self.signal(node.of))
            case typed.LaneSide():
                return at.Index(at.Name(node.field), self.record(node.of))
            case typed.Path():
                return self.signal(node.of)
            case typed.Centre():
                return self.area(node.of)
            case typed.CalledLine():
                return at.Call(at.Word(node.function), (self.line(node.line),))
            case typed.NamedLine():
                if not self.inside or node.value is None:
                    return self.local(node.name)
                with self.left():
                    return self.line(node.value)
            case _:
                assert_never(node)

    def area(self, node: typed.Area) -> Layout:
        match node:
            case typed.Zone():
                return self.named("place", node.symbol)
            case typed.Corridor():
                return self.signal(node.of)
            case typed.Lane():
                return self.record(node.of)
            case typed.NamedArea():
                if not self.inside or node.value is None:
                    return self.local(node.name)
                with self.left():
                    return self.area(node.value)
            case _:
                assert_never(node)

    def region(self, node: typed.Region) -> Layout:
        match node:
            case typed.Footprint():
                return at.Call(at.Word("footprint"), (self.record(node.body),))
            case typed.FootprintAt():
                return at.Call(at.Word("footprint"), (self.record(node.pose), *self._box(node)))
            case typed.SweptSample():
                return at.Call(at.Word(node.function), (self.record(node.sample), *self._box(node)))
            case typed.Swept():
                ends = self.record(node.start), self.record(node.end)
                return at.Call(at.Word("swept"), (*ends, *self._box(node)))
            case typed.NamedRegion():
                if not self.inside or node.value is None:
                    return self.local(node.name)
                with self.left():
                    return self.region(node.value)
            case _:
                assert_never(node)

    def _box(self, node: typed.FootprintAt | typed.SweptSample | typed.Swept) -> tuple[Layout, Layout]:
        return self.number(node.length), self.number(node.width)

    def machine(self, node: typed.Machine) -> Layout:
        """A state machine, of which element it is."""
        head = self.named("machine", node.symbol)
        if node.element is None:
            return head
        element = node.element
        if isinstance(element, typed.NamedRecord) and element.value is not None:
            element = element.value  # what is asked about; the name is the machine's own
        return at.Call(head, (self.record(element),))
