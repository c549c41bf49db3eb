"""Hazards, goals, design elements, persons, reviews and their like, and the schema of links, as their documents say them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from datetime import date

from trackmarshal.trace import model
from trackmarshal.trace.values import Placed, Table

#: The lists of each document, and the kind of node that each of their entries is.
LISTS = {
    "hazards": (("domains", "operational design domain"), ("hazards", "hazard"), ("safety_goals", "safety goal")),
    "design": (("elements", "design element"), ("methods", "method")),
    "assurance": (("persons", "person"), ("tools", "tool"), ("malfunctions", "malfunction"), ("analyses", "analysis"), ("reviews", "review"), ("works", "work"), ("indicators", "indicator")),
}  # fmt: skip
#: Fields that are links, and their kinds.
_LINKS = {
    "arises_from": "arises_from", "operates_in": "operates_in", "prevents": "prevents", "part_of": "part_of", "used_for": "used_for",
    "of": "examines", "by": "made_by", "document": "backed_by", "owner": "owned_by", "claims": "indicates",
    "of_tool": "malfunction_of", "shown_in": "backed_by",
}  # fmt: skip
#: Fields of requirements that are links beside those that the matrix has always known.
OF_REQUIREMENTS = ("achieves", "allocated_to", "verified_by", "independence")


def entries(documents: Iterable[Table], kind: str) -> Iterator[model.Entry]:
    """The entries of all documents of a kind that have an id."""
    for document in documents:
        for field, node in LISTS[kind]:
            for table in document.tables(field):
                if table.text("id"):
                    yield _entry(table, node)


def _entry(table: Table, kind: str) -> model.Entry:
    attributes: dict[str, str] = {}
    links: list[tuple[str, Placed]] = []
    versions: list[tuple[Placed, str]] = []
    ranges: list[tuple[Placed, str, str]] = []
    for name, value in table.items():
        if name in ("id", "title", "made"):
            continue
        if name == "of" and kind == "review":
            versions = [(t.text("id"), t.text("fingerprint")) for t in value if t.text("id")]
            links += [("reviews", id_) for id_, _ in versions]
        elif name == "ranges":
            ranges = [
                (t.text("quantity"), str(t.text("from")), str(t.text("to")))
                for t in value
                if t.text("from") and t.text("to")
            ]
            attributes |= {f"range of {quantity}": f"{low} to {high}" for quantity, low, high in ranges}
        elif name in _LINKS:
            links += [(_LINKS[name], target) for target in (value if isinstance(value, list) else [value])]
        elif isinstance(value, list):
            attributes[name] = " ".join(map(str, value))
        else:
            attributes[name] = str(value)
    made = table.get("made")
    if isinstance(made, date):
        attributes["made"] = made.isoformat()
    title = table.text("title") or f"review of {', '.join(id_ for id_, _ in versions)}"
    return model.Entry(
        kind, table.text("id"), title, attributes, tuple(links), made, tuple(versions), tuple(ranges)
    )


def of_requirement(table: Table) -> tuple[tuple[str, Placed], ...]:
    """The links of a requirement beside those that its record names."""
    links = [(name, target) for name in OF_REQUIREMENTS for target in table.texts(name)]
    owner = table.text("owner")
    return (*links, ("owned_by", owner)) if owner else tuple(links)


def schema(table: Table) -> model.Schema:
    """Which links are needed and permitted."""
    needs = tuple(
        _need(str(node.text("kind")), need)
        for node in table.tables("nodes")
        if node.text("kind")
        for need in node.tables("needs")
    )
    permitted = tuple(
        model.Permitted(t.text("link"), t.texts("from"), t.texts("to"))
        for t in table.tables("permitted")
        if t.text("link")
    )
    methods = tuple(
        model.Method(t.text("name"), t.text("means"), tuple(map(_way, t.tables("any_of"))))
        for t in table.tables("methods")
        if t.text("name")
    )
    reviewed = tuple(
        model.Reviewed(str(t.text("kind")), t.texts("ids"), t.text("from_asil"))
        for t in table.tables("reviewed")
        if t.text("kind")
    )
    return model.Schema(
        needs, permitted, methods if "methods" in table else None, reviewed if "reviewed" in table else None
    )


def _need(kind: str, t: Table) -> model.Need:
    return model.Need(
        kind, t.place, tuple(map(_way, t.tables("any_of"))), t.texts("ids"), t.text("from_asil"), t.texts("stages"), t.text("counts"), t.text("if_any"),
        t.get("obsolete", False), _where(t.tables("where")), t.text("level") or "error", t.text("code"), t.text("says"), t.text("help"),
    )  # fmt: skip


def _way(t: Table) -> model.Way:
    return model.Way(
        t.place, t.text("link"), t.text("reaches"), t.text("field"), t.texts("kinds"), _where(t.tables("where")),
        t.get("at_least", 1), t.get("at_most"), t.text("every"), t.text("unless"),
    )  # fmt: skip


def _where(tables: Sequence[Table]) -> tuple[model.Condition, ...]:
    return tuple(model.Condition(t.text("attribute"), t.texts("is")) for t in tables if t.text("attribute"))


__all__ = ["LISTS", "entries", "of_requirement", "schema"]
