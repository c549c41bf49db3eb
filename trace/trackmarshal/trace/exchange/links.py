"""Ids and links of what crosses: each id once, and no link that leads nowhere."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from trackmarshal.trace.exchange.content import Document
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.model import Project
from trackmarshal.trace.values import Placed

_SAME = (
    "the same ones? Write them over that file: name it with `--out`, or rename it to what the list is called now, and add `--force`. "
    "Others? Give them ids of their own"
)


def check(
    documents: Sequence[Document],
    project: Project | None = None,
    without: Collection[str] = (),
    beside: bool = False,
) -> list[Finding]:
    """T355 for ids that are there twice, in the documents or in the project, T356 for links to nothing.

    `without` are the project's files that are about to be written anew; `beside`: the documents go where the project reads none. Interfaces are looked for where the project has a model.
    """
    found: list[Finding] = []
    there = (
        {str(one.id): one.place for one in project.requirements if one.place.file not in without}
        if project
        else {}
    )
    first: dict[str, Place] = dict(there)
    again: dict[str, list[Placed]] = {}
    for one in [one for document in documents for one in document.requirements]:
        id_ = one.text("id")
        if not id_:
            continue  # which is an error already
        if id_ in there and first[id_] is there[id_]:
            if not beside:
                again.setdefault(there[id_].file, []).append(id_)
            first[id_] = id_.place
        elif id_ in first:
            found.append(_twice(id_, first[id_], "", "give each requirement an id of its own"))
        first.setdefault(str(id_), id_.place)
    # A list that comes back under another name than it went out by is one mistake, whatever it holds.
    for file, ids in again.items():
        others = len(ids) - 1
        more = f", and so {'is' if others == 1 else 'are'} {others} more of `{file}`" if others else ""
        found.append(_twice(ids[0], there[ids[0]], more, _SAME))
    interfaces = (
        {str(interface.id) for interface in project.interfaces} if project and project.modelled else None
    )
    for one in [one for document in documents for one in document.requirements]:
        found += _lost(one.text("id"), "refines", one.texts("refines"), first)
        if interfaces is not None:
            found += _lost(one.text("id"), "derived_from", one.texts("derived_from"), interfaces)
    return found


def _twice(id_: Placed, first: Place, more: str, help_: str) -> Finding:
    message = f"the id `{id_}` is there twice{more}"
    return Finding("T355", "error", message, id_.place, help_, str(id_), ((first, "first given here"),))


def _lost(id_: Placed, name: str, targets: Sequence[Placed], known: Collection[str]) -> list[Finding]:
    help_ = "take it over too, or strike the link there"
    return [
        error(
            "T356",
            f"`{name}` of `{id_}` leads to `{target}`, which is not there",
            target.place,
            did_you_mean(target, known) or help_,
            str(id_),
        )
        for target in targets
        if target not in known
    ]
