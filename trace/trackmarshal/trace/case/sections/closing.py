"""The matrix, what the words mean, and how the document is made again."""

from __future__ import annotations

from collections.abc import Iterable

from trackmarshal.trace import verdict
from trackmarshal.trace.case.model import Block, Code, Fixed, Given, Line, Section, Status, Verbatim
from trackmarshal.trace.case.writing import Writing, given
from trackmarshal.trace.graph.kinds import NODES
from trackmarshal.trace.render.words import MEANINGS


def matrix(writing: Writing) -> Section:
    """Requirements against stages."""
    made = writing.given.matrix
    stages = [str(stage.id) for stage in made.stages]
    if not made.rows:
        return writing.section("matrix", [writing.missing("requirements.none")])
    meanings = writing.table((("column.stage", 1.0), ("column.title", 2.0), ("column.shows", 5.0)), (
        [(Given(str(stage.id)),), given(stage.title), given(" ".join(stage.shows.split()))] for stage in made.stages
    ), [("stage", stage) for stage in stages])  # fmt: skip
    blocks: list[Block] = [meanings]
    #: As many columns as fit on paper beside the requirement.
    for start in range(0, len(stages), 9):
        some = stages[start : start + 9]
        rows: list[list[Line]] = []
        for row in made.rows:
            cells: list[Line] = [
                (Status(row.cells[stage].status),) if stage in row.cells else (Fixed("–"),) for stage in some
            ]
            rows.append(
                [
                    (
                        writing.ref(("requirement", str(row.requirement.id))),
                        Fixed(" "),
                        Given(row.requirement.title),
                    ),
                    *cells,
                ]
            )
        table = writing.table([("column.requirement", 1.6), *(("column.stage", 1.0) for _ in some)], rows)
        blocks.append(type(table)((table.head[0], *some), table.rows, table.widths))
    return writing.section("matrix", blocks)


def glossary(writing: Writing) -> Section:
    """The terms of the document, the words of verdicts and statuses, and what is in the graph here."""
    columns = (("column.word", 2.0), ("column.meaning", 7.0))
    words = writing.words

    def told(those: Iterable[str]) -> Block:
        return writing.table(
            columns, ([(Status(word),), (Fixed(words[f"meaning.{word}"]),)] for word in those)
        )

    terms = sorted(
        {name.split(".")[1] for name in words if name.startswith("term.")},
        key=lambda name: words[f"term.{name}"].lower(),
    )
    kinds = writing.table(
        (("column.word", 2.0), ("column.meaning", 6.0), ("column.number", 1.0)),
        (
            [(Fixed(words[f"thing.{kind}"]),), (Fixed(words[f"what.{kind}"]),), (writing.number("nodes", kind),)]
            for kind in NODES if writing.of_kind(kind)
        ),
    )  # fmt: skip
    return writing.section("glossary", [
        writing.named("glossary.terms", [writing.table(columns, ([(Fixed(words[f"term.{name}"]),), (Fixed(words[f"term.{name}.means"]),)] for name in terms))]),
        writing.named("glossary.verdicts", [told(verdict.MEANINGS)]), writing.named("glossary.statuses", [told(MEANINGS)]),
        writing.named("glossary.kinds", [kinds]),
    ])  # fmt: skip


def again(writing: Writing) -> Section:
    """What went in, by hash, and the commands that come to the same bytes."""
    made = writing.given
    changed = made.commit.endswith("+")
    commands = [f"git checkout {made.commit}"] if made.commit and not changed else []
    commands += [
        "trackmarshal trace --gate --rerun",
        " ".join(
            filter(None, ("trackmarshal case --day", made.matrix.today.isoformat(), made.asked, "--out DIR"))
        ),
    ]
    how = writing.missing("again.lacking") if made.lacking else writing.paragraph("again.how")
    blocks: list[Block] = [how, Verbatim("\n".join(commands))]
    if changed:
        blocks.append(writing.missing("again.changed"))
    documents = [
        (node.id, node.attributes["fingerprint"])
        for node in writing.of_kind("document")
        if node.attributes.get("fingerprint")
    ]
    recordings = [(run.scenario, run.source_hash) for run in made.runs]
    hashed: list[tuple[str, list[tuple[str, str]]]] = [
        ("again.requirements", sorted(made.hashes.items())), ("again.documents", documents), ("again.recordings", sorted(recordings)),
        ("again.rules", [(item.name, item.fingerprint) for item in made.items]),
    ]  # fmt: skip
    for name, pairs in hashed:
        if pairs:
            rows = [[(Code(path),), (Code(digest),)] for path, digest in pairs]
            keys = [("document", path) for path, _ in pairs] if name == "again.documents" else []
            blocks.append(
                writing.named(name, [writing.table((("column.name", 3.0), ("column.sha", 5.0)), rows, keys)])
            )
    return writing.section("again", blocks)


__all__ = ["again", "glossary", "matrix"]
