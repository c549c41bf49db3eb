"""Who answers, what was reviewed by whom and in which commit that stands, what nobody reviewed, what somebody accepted that is less, and the table that an
assessor signs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, repeat

from trackmarshal.trace.case.model import Blanks, Block, Code, Fixed, Given, Line, Number, Section, Status
from trackmarshal.trace.case.writing import EMPTY, Writing, given, made, written
from trackmarshal.trace.graph.graph import Node
from trackmarshal.trace.graph.reviewed import reviewed

#: Kinds of things that a second person may be expected to have read.
READ = (
    "operational design domain", "interface", "hazard", "safety goal", "analysis", "requirement", "design element", "rule", "assumption", "tool", "malfunction",
)  # fmt: skip
#: So many rows are left for signatures.
ROWS = 5


def people(writing: Writing) -> Section:
    """Persons, reviews, what has none, and room for signatures: no program fills in any of it."""
    blocks: list[Block] = list(_persons(writing))
    reviews = writing.of_kind("review")
    shown = [_reviews(writing, reviews)] if reviews else [writing.missing("people.no_reviews")]
    blocks.append(
        writing.named("people.reviews", [*shown, writing.paragraph("people.recorded")] if reviews else shown)
    )
    blocks.append(writing.named("people.unreviewed", list(_unreviewed(writing))))
    if writing.given.matrix.baseline is not None:  # without one, nobody knows what was less: T220 says so
        blocks.append(writing.named("people.accepted", list(_accepted(writing))))
    heads = ("column.name", "column.role", "column.organisation", "column.date", "column.signature")
    signed = Blanks(
        writing.line("people.sign"),
        tuple(writing.words[name] for name in heads),
        (2.4, 1.8, 1.8, 1.2, 2.8),
        ROWS,
    )
    blocks.append(writing.named("people.signatures", [signed]))
    return writing.section("people", blocks)


def _persons(writing: Writing) -> Iterator[Block]:
    persons = writing.of_kind("person")
    if not persons:
        yield writing.missing("lacking.person")
        return
    columns = (("column.id", 1.0), ("column.name", 3.0), ("column.role", 4.5), ("column.organisation", 1.5))
    yield writing.table(columns, (
        [(writing.ref(n.key),), given(n.title), given(n.attributes.get("role", "")), given(n.attributes.get("organisation", ""))] for n in persons
    ), [n.key for n in persons])  # fmt: skip


def _reviews(writing: Writing, reviews: Sequence[Node]) -> Block:
    columns = (
        ("column.id", 0.8), ("column.of_what", 2.6), ("column.by", 1.4), ("column.made", 1.2), ("column.outcome", 1.4), ("column.commit", 2.8),
    )  # fmt: skip
    return writing.table(columns, (
        [
            (writing.ref(n.key),), writing.refs(k.target for k in writing.graph.out_of(n.key) if k.kind == "reviews"),
            writing.refs(p.key for p in writing.beyond(n.key, "made_by")), given(n.attributes.get("made", "")),
            (Status(n.attributes.get("outcome", "open")),), _recorded(writing, n),
        ]
        for n in reviews
    ), [n.key for n in reviews])  # fmt: skip


def _recorded(writing: Writing, review: Node) -> Line:
    """The commit that a review stands in, by whom, and whether that is signed: what version control knows of a signature."""
    found = writing.given.recorded.get(review.id)
    if found is None or not found.commit:
        return writing.line("people.not_recorded")
    said = writing.line("people.commit_signed" if found.signed else "people.commit_unsigned")
    return (
        Code(found.commit),
        Fixed(", "),
        Given(found.author),
        Fixed(", "),
        Given(found.day),
        Fixed(", "),
        *said,
    )


def _unreviewed(writing: Writing) -> Iterator[Block]:
    """By kind, how many things no review accepted in the version that is here, and which."""
    rows: list[list[Line]] = []
    expected = {kind: [node for node in writing.of_kind(kind) if node.demanded] for kind in READ}
    for kind, nodes in expected.items():
        open_ = [node.key for node in nodes if not reviewed(writing.graph, node)]
        if open_:
            count = (
                Number(f"unreviewed/{kind}", str(len(open_))),
                Fixed(" / "),
                Number(f"read/{kind}", str(len(nodes))),
            )
            rows.append([(Fixed(writing.words[f"thing.{kind}"]),), count, writing.refs(open_)])
    if not any(expected.values()):
        yield writing.missing("people.nothing_to_read")
        return
    if not rows:
        yield writing.paragraph("people.all_reviewed")
        return
    yield writing.missing("people.unreviewed_how")
    yield writing.table((("column.kind", 1.6), ("column.number", 0.9), ("column.ids", 7.5)), rows)


def _accepted(writing: Writing) -> Iterator[Block]:
    """All that somebody accepted that is less, for which nothing fails any more. Who and why stand at the first of those that were accepted at once."""
    done = writing.given.matrix.accepted
    if not done:
        yield writing.paragraph("people.none_accepted")
        return
    yield writing.paragraph("people.accepted_how")
    columns = (
        ("column.made", 1.1),
        ("column.by", 1.4),
        ("column.justification", 2.5),
        ("column.less", 5.0),
    )
    yield writing.table(columns, (
        [*((given(one.on), given(one.by), written(one.reason)) if first else (EMPTY, EMPTY, EMPTY)), made(change)]
        for one in done for first, change in zip(chain((True,), repeat(False)), one.weaker)
    ))  # fmt: skip


__all__ = ["people"]
