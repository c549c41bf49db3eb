"""Declarations of faults: which are put into which recording, and what the Supervisor is expected to do about each."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from trackmarshal.runtime.faults import FAULTS
from trackmarshal.scenarios import content
from trackmarshal.scenarios.faults.changes import Change, change
from trackmarshal.scenarios.generate import document
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.replay import ACTIONS
from trackmarshal.units import moment

#: Why nothing stored is driven, by name.
LOSSES = tuple(name for name, code in FAULTS.items() if code.startswith("D24"))
#: s: up to here, doubles tell stamps apart to a microsecond; those of Unix are at 1.8e9.
_FARTHEST = 4e9


@dataclass(frozen=True, slots=True)
class Expected:
    """What the Supervisor does: `by`, a rule or a fault of the door or the Supervisor, makes the cycles from first to last unsafe, s.

    In the first one, `driven` is driven, from the cycle at `since` (None: nothing is). From `lost_at` on nothing stored is
    driven any more, because of `lost`.
    """

    by: str
    first: float
    last: float
    driven: str
    since: float | None
    lost: str
    lost_at: float | None


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault in the cycles from begin to end, s; `expected` None: nothing may happen. `open`: why it is not injected."""

    id: str
    title: str
    requirement: str
    begin: float
    end: float
    changes: tuple[Change, ...]
    expected: Expected | None
    open: str
    line: int
    digest: str  #: sha256 of what is declared
    says: str = ""  #: sha256 of that without its title, and without what it is evidence for


@dataclass(frozen=True, slots=True)
class Campaign:
    """The faults of one file. lead: how long the run goes on before and after each fault, s."""

    name: str
    recording: str
    lead: float
    faults: tuple[Fault, ...]
    source: str = ""  #: the file, as reports print it


def load(path: Path, shown: str) -> Campaign:
    """Read a campaign; raises D120, D124, D126, D150 or D151."""
    item = document.read(content.read(path, shown), shown)
    item.expect("trackmarshal-faults")
    fields = item.fields(("format", "version", "name", "recording", "lead", "faults"))
    fields["version"].count(1, 1)
    faults = tuple(_fault(each) for each in fields["faults"].items())
    ids = [fault.id for fault in faults]
    for fault, each in zip(faults, fields["faults"].items()):
        if ids.count(fault.id) > 1:
            raise each.wrong(f"the id `{fault.id}` stands twice", "ids are unique")
    return Campaign(
        fields["name"].text(), fields["recording"].text(), fields["lead"].number(0.0, 100.0), faults, shown
    )


def _fault(item: Item) -> Fault:
    named = ("id", "title", "requirement")
    fields = item.fields(named, ("open", "begin", "end", "change", "expect"))
    if "open" in fields:
        item.fields((*named, "open"))
        begin, end, expected = 0.0, 0.0, None
        changes: tuple[Change, ...] = ()
    else:
        fields = item.fields((*named, "begin", "end", "change", "expect"))
        begin, end = _time(fields["begin"]), _time(fields["end"])
        if end < begin:
            raise item.wrong(
                f"it ends at {moment(end)} s, before it begins", "begin is the first cycle, end the last"
            )
        changes = tuple(change(each) for each in fields["change"].items())
        expected = _expected(fields["expect"])
    texts = [fields[name].text() for name in named]
    plain = item.plain()
    digest = _hash(plain)
    says = (
        _hash({name: value for name, value in plain.items() if name not in named})
        if isinstance(plain, dict)
        else digest
    )
    text = fields["open"].said() if "open" in fields else ""
    return Fault(texts[0], texts[1], texts[2], begin, end, changes, expected, text, item.line, digest, says)


def _expected(item: Item) -> Expected | None:
    fields = item.fields((), ("by", "first", "last", "driven", "from", "lost", "lost_at"))
    if not fields:
        return None
    fields = item.fields(("by", "first", "last", "driven"), ("from", "lost", "lost_at"))
    driven = fields["driven"].choice(ACTIONS[1:])
    since = _time(fields["from"]) if "from" in fields else None
    lost_at = _time(fields["lost_at"]) if "lost_at" in fields else None
    if (since is None) != (driven == ACTIONS[2]):
        raise item.wrong(
            "`from` says which cycle's trajectory is driven", f"give it, but not with {ACTIONS[2]}"
        )
    if (lost_at is None) != ("lost" not in fields):
        raise item.wrong("`lost` and `lost_at` belong together", "give both or none")
    lost = fields["lost"].choice(LOSSES) if "lost" in fields else ""
    first, last = _time(fields["first"]), _time(fields["last"])
    return Expected(fields["by"].text(), first, last, driven, since, lost, lost_at)


def _time(item: Item) -> float:
    """The stamp of a cycle [s]: recordings count from wherever the car's clock does."""
    return item.number(-_FARTHEST, _FARTHEST)


def _hash(plain: object) -> str:
    return hashlib.sha256(json.dumps(plain).encode()).hexdigest()
