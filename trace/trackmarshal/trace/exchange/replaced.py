"""What a list of requirements loses when another one is written over it: requirements that are dropped, ASILs that are lowered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from trackmarshal.trace import requirements
from trackmarshal.trace.exchange.content import Document
from trackmarshal.trace.findings import Finding, Place, error, warning
from trackmarshal.trace.graph.said import LEVEL


def lost(documents: Sequence[Document], files: Sequence[tuple[Path, str]]) -> Iterator[Finding]:
    """T365 for each requirement of the files, (path, as it is shown), that the documents written over them lack or give a lower ASIL, and for
    each list of requirements that cannot be read whole; an error for each file that is none, which is not written over."""
    now = {str(one.text("id")): one for document in documents for one in document.requirements}
    for path, shown in files:
        wrong: list[Finding] = []
        read = requirements.document(path, shown, wrong)
        if read is None or read[0] != "requirements":
            what = "no list of requirements" if read is None else f"the document `{read[0]}`"
            message = f"what would be written over is {what}"
            help_ = "choose another name in the other tool or with `--out`, or remove the file first"
            yield error("T365", message, Place(shown), help_)
            continue
        if wrong:
            message = "what is written over is no list of requirements that can be read whole: what it loses is not known"
            yield warning("T365", message, Place(shown), "look at it before it is gone")
        for before in read[1].tables("requirements"):
            id_ = before.text("id")
            if id_ not in now:
                message = f"`{id_}` is dropped: it is in the file that is written over, and not in what is taken over"
                yield warning(
                    "T365",
                    message,
                    id_.place,
                    "export it to the other tool first, if it is to stay",
                    str(id_),
                )
                continue
            asil, old = now[id_].text("asil"), before.text("asil")
            if _below(asil, old):
                message = f"the ASIL of `{id_}` is lowered from {old} to {asil}"
                yield Finding(
                    "T365", "warning", message, asil.place, "", str(id_), ((old.place, f"{old} here"),)
                )


def _below(asil: str, before: str) -> bool:
    """Whether a level is below another: what it demands by itself, or what it was decomposed from."""
    return any(new < old for new, old in zip(_levels(asil), _levels(before)))


def _levels(asil: str) -> tuple[int, ...]:
    """The level itself and the one that it was decomposed from, which is itself for most; nothing where none is said."""
    own, _, whole = asil.rstrip(")").partition("(")
    return (LEVEL[own], LEVEL[whole or own]) if asil else ()
