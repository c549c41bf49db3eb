"""What a list of requirements loses when another one is written over it: requirements that are dropped, ASILs that are lowered, links and fields that are gone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from trackmarshal.trace.exchange.content import FIELDS, LISTS, Document
from trackmarshal.trace.findings import Finding, Place, error, warning
from trackmarshal.trace.graph.kinds import OBSOLETE
from trackmarshal.trace.graph.said import LEVEL
from trackmarshal.trace.reading import document
from trackmarshal.trace.values import Placed, Table

#: So many names of what is gone are shown of a field, and so many requirements that lose something in one.
_SHOWN = 5
_HELP = "name the field of the other tool that has it (`--field`), or write it anew afterwards"


class _Less(NamedTuple):
    """What a requirement loses in a field: entries of a list, or all that it says (none)."""

    id: Placed
    field: str
    gone: tuple[str, ...]
    place: Place

    def __str__(self) -> str:
        more = f" and {len(self.gone) - _SHOWN} more" if len(self.gone) > _SHOWN else ""
        named = ", ".join(f"`{one}`" for one in self.gone[:_SHOWN])
        return f"`{self.field}`" + (f" {named}{more}" if named else "")


def lost(documents: Sequence[Document], files: Sequence[tuple[Path, str]]) -> Iterator[Finding]:
    """T365 for each requirement of the files, (path, as it is shown), that the documents written over them lack, give a lower ASIL, demand no longer, or
    leave without links or fields that it has, and for each list of requirements that loses its source, or cannot be read whole; an error for each file that is
    none, which is not written over."""
    now = {str(one.text("id")): one for document in documents for one in document.requirements}
    less: list[_Less] = []
    for path, shown in files:
        wrong: list[Finding] = []
        read = document(path, shown, wrong)
        if read is None or read[0] != "requirements":
            what = "no list of requirements" if read is None else f"the document `{read[0]}`"
            message = f"what would be written over is {what}"
            help_ = "choose another name in the other tool or with `--out`, or remove the file first"
            yield error("T365", message, Place(shown), help_)
            continue
        if wrong:
            message = "what is written over is no list of requirements that can be read whole: what it loses is not known"
            yield warning("T365", message, Place(shown), "look at it before it is gone")
        source = read[1].text("source")
        if source and all(source != document.table.text("source") for document in documents):
            message = f"the list loses where it comes from: `{' '.join(source.split())[:60]}`"
            yield warning("T365", message, source.place, "write it anew afterwards")
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
            if now[id_].text("status") == OBSOLETE != before.text("status"):
                message = f"`{id_}` is demanded no longer: its status is `obsolete`"
                place = before.text("status").place
                yield warning("T365", message, place, "take its status over as it is, if it is", str(id_))
            less += _less(before, now[id_])
    yield from _told(less, len(now))


def _less(before: Table, now: Table) -> Iterator[_Less]:
    """The fields, and the entries of lists, that are not there any more."""
    id_ = before.text("id")
    for name in FIELDS:
        if name in LISTS:
            left = tuple(str(one) for one in dict.fromkeys(before.texts(name)) if one not in now.texts(name))
            if left:
                yield _Less(id_, name, left, before.texts(name)[0].place)
        elif before.get(name) and not now.get(name):
            yield _Less(id_, name, (), id_.place)
    gone = before.get("foreign", {}).keys() - now.get("foreign", {}).keys()
    if gone:
        yield _Less(id_, "foreign", tuple(sorted(gone)), id_.place)


def _told(less: Iterable[_Less], there: int) -> Iterator[Finding]:
    """T365 for what is less: of each requirement once, and of a field in which many lose something, as where the other tool has none of it, once for all."""
    by_field: dict[str, list[_Less]] = defaultdict(list)
    for one in less:
        by_field[one.field].append(one)
    by_id: dict[str, list[_Less]] = defaultdict(list)
    for name, all_ in by_field.items():
        if len(all_) > _SHOWN:
            first = all_[0]
            message = f"{len(all_)} of {there} requirements lose something in `{name}`, such as `{first.id}`: {first}"
            yield warning("T365", message, first.place, _HELP, str(first.id))
        else:
            for one in all_:
                by_id[str(one.id)].append(one)
    for id_, lost_ in by_id.items():
        message = f"`{id_}` loses {'; '.join(map(str, lost_))}"
        yield warning("T365", message, lost_[0].place, _HELP, id_)


def _below(asil: str, before: str) -> bool:
    """Whether a level is below another: what it demands by itself, or what it was decomposed from."""
    return any(new < old for new, old in zip(_levels(asil), _levels(before)))


def _levels(asil: str) -> tuple[int, ...]:
    """The level itself and the one that it was decomposed from, which is itself for most; nothing where none is said."""
    own, _, whole = asil.rstrip(")").partition("(")
    return (LEVEL[own], LEVEL[whole or own]) if asil else ()
