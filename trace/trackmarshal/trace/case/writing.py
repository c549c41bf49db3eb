"""How sections come to their content: words by name, numbers by id, things of the graph by key."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from string import Formatter

from trackmarshal.records.specs import SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace.case.inputs import Inputs
from trackmarshal.trace.case.model import (
    Block,
    Facts,
    Fixed,
    Given,
    Line,
    Made,
    Missing,
    Number,
    Paragraph,
    Part,
    Piece,
    Ref,
    Section,
    Status,
    Table,
    Written,
)
from trackmarshal.trace.findings import LEVELS, Place
from trackmarshal.trace.graph.graph import Graph, Key, Node, holds
from trackmarshal.trace.graph.statistics import grouped, numbers

EMPTY: Line = ()


@dataclass(frozen=True)
class Writing:
    """What all sections are written with. Raises KeyError for words that the language lacks."""

    given: Inputs
    words: Mapping[str, str]
    anchors: Mapping[Key, str]

    @property
    def graph(self) -> Graph:
        return self.given.matrix.graph

    def line(self, name: str, /, **pieces: Piece | Line) -> Line:
        """Fixed words with pieces in their places."""
        made: list[Piece] = []
        for text, place, _, _ in Formatter().parse(self.words[name]):
            if text:
                made.append(Fixed(text))
            if place is not None:
                piece = pieces[place]
                made += piece if type(piece) is tuple else (piece,)  # type: ignore[arg-type]
        return tuple(made)

    def paragraph(self, name: str, /, **pieces: Piece | Line) -> Paragraph:
        return Paragraph(self.line(name, **pieces))

    def missing(self, name: str, /, **pieces: Piece | Line) -> Missing:
        return Missing(self.line(name, **pieces))

    def facts(self, rows: Iterable[tuple[str, Line]]) -> Facts:
        """Rows by the names of their labels; those that say nothing are left out."""
        return Facts(tuple((self.words[name], line) for name, line in rows if line))

    def table(
        self, columns: Sequence[tuple[str, float]], rows: Iterable[Sequence[Line]], keys: Iterable[Key] = ()
    ) -> Table:
        """columns: names of their words, and their shares of the width. keys: of the thing that each row is about, which has its place there."""
        made = tuple(tuple(row) for row in rows)
        anchors = tuple(self.anchors.get(key, "") for key in keys)
        return Table(
            tuple(self.words[name] for name, _ in columns),
            made,
            tuple(share for _, share in columns),
            anchors,
        )

    def part(self, title: Line, blocks: Iterable[Block], key: Key | None = None, level: int = 2) -> Part:
        return Part(title, tuple(blocks), "" if key is None else self.anchors.get(key, ""), level)

    def named(self, name: str, blocks: Iterable[Block], level: int = 2) -> Part:
        """A part whose heading is fixed words."""
        return Part((Fixed(self.words[name]),), tuple(blocks), level=level)

    def section(self, id_: str, blocks: Iterable[Block]) -> Section:
        return Section(id_, self.words[f"{id_}.title"], tuple(blocks), self.anchors["section", id_])

    # Numbers.

    @cached_property
    def _numbers(self) -> Mapping[str, Mapping[str, Mapping[str, int]]]:
        matrix = self.given.matrix
        found = {level: {"all": sum(one.level == level for one in matrix.findings)} for level in LEVELS}
        return {**grouped(numbers(matrix)), "findings": found}

    def number(self, table: str, of: str, what: str = "all") -> Number:
        """A number of the graph's statistics; what they leave out there is none of."""
        value = self._numbers.get(table, {}).get(of, {}).get(what, 0)
        return Number(f"{table}/{of}/{what}", str(value))

    def said_number(self, node: Node, attribute: str) -> Number:
        """A number that a node of the graph has as an attribute."""
        return Number(f"node/{node.kind}/{node.id}/{attribute}", node.attributes[attribute])

    # Tests, by their rules.

    @cached_property
    def tests_of(self) -> Mapping[str, Sequence[SpecTest]]:
        """The tests of each rule, in the order in which they stand."""
        found: dict[str, list[SpecTest]] = {}
        for test in self.given.tests:
            found.setdefault(test.rule, []).append(test)
        return found

    @cached_property
    def result_of(self) -> Mapping[tuple[str, str], TestResult]:
        """By rule and title, what a test came to."""
        return {(result.rule, result.title): result for result in self.given.results}

    # Things of the graph.

    def ref(self, key: Key) -> Ref:
        return Ref(key, key[1])

    def refs(self, keys: Iterable[Key]) -> Line:
        """Things, with commas between them."""
        return joined([(self.ref(key),) for key in dict.fromkeys(keys)])

    def beyond(self, key: Key, kind: str) -> list[Node]:
        """The nodes that links of a kind lead to from one, as far as they hold."""
        found = (
            self.graph.nodes.get(link.target)
            for link in self.graph.out_of(key)
            if link.kind == kind and holds(link)
        )
        return [node for node in found if node is not None]

    def before(self, key: Key, kind: str) -> list[Node]:
        """The nodes from which links of a kind lead to one, as far as they hold; what is demanded no longer serves, refines and answers nothing."""
        found = (
            self.graph.nodes.get(link.source)
            for link in self.graph.into(key)
            if link.kind == kind and holds(link)
        )
        return [node for node in found if node is not None and node.demanded]

    def file(self, document: Node) -> Line:
        """A file that backs something, with what it has come to in the matrix where that is not that it is there."""
        outcome = document.attributes["outcome"]
        ref: Line = (self.ref(document.key),)
        return ref if outcome == "there" else (*ref, Fixed(" "), Status(outcome))

    def files(self, key: Key) -> Line:
        """The files that back a thing."""
        return joined([self.file(document) for document in self.beyond(key, "backed_by")])

    def of_kind(self, kind: str) -> Sequence[Node]:
        return self.graph.by_kind.get(kind, ())

    def titled(self, node: Node) -> Line:
        """A node's id with its title."""
        return (self.ref(node.key), Fixed(" "), Given(node.title)) if node.title else (self.ref(node.key),)

    def review(self, key: Key) -> Line:
        """Who reviewed a thing, in which version, and what came of it; what nobody reviewed is said to be so."""
        found: list[Line] = []
        for link in self.graph.into(key):
            review = self.graph.nodes.get(link.source)
            if link.kind != "reviews" or review is None or not holds(link):
                continue
            said = (
                "review.outdated"
                if link.state == "outdated"
                else f"review.{review.attributes.get('outcome', 'open')}"
            )
            by = self.refs(node.key for node in self.beyond(review.key, "made_by"))
            found.append(
                self.line(
                    said, review=self.ref(review.key), by=by, made=Given(review.attributes.get("made", ""))
                )
            )
        return joined(found) if found else self.line("review.none")


def joined(lines: Sequence[Line], between: str = ", ") -> Line:
    """Lines one after the other."""
    made: list[Piece] = []
    for line in lines:
        if made and line:
            made.append(Fixed(between))
        made += line
    return tuple(made)


def written(text: str, place: Place | None = None) -> Line:
    """What a person wrote, if anything."""
    text = " ".join(text.split())
    return (Written(text, "" if place is None else _line(place)),) if text else EMPTY


def given(text: str) -> Line:
    return (Given(text),) if text else EMPTY


def made(text: str) -> Line:
    """What the program put together in words of its own, if anything."""
    return (Made(text),) if text else EMPTY


def _line(place: Place) -> str:
    """File and line: the column says nothing to a reader of paper."""
    return f"{place.file}:{place.line}" if place.line else place.file


__all__ = ["EMPTY", "Writing", "given", "joined", "made", "written"]
