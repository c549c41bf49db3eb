"""What specs say, as far as traceability is concerned: rules and assumptions, what they rest on, and the tests that are written for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from trackmarshal.records.fields import Fields, refused

ITEM_KINDS = ("rule", "assume")
PART_KINDS = ("param", "table", "place", "signal", "constraint", "rulebook", "limit", "replay")
VERDICTS = ("satisfied", "violated", "undefined", "inactive", "open")


class Ref(NamedTuple):
    """A name that a spec mentions, and where: line and column from 1."""

    id: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class SpecItem:
    """A rule or an assumption of a spec, as far as traceability is concerned."""

    kind: str  #: "rule" or "assume"
    name: str
    title: str
    satisfies: tuple[Ref, ...]
    assuming: tuple[Ref, ...]
    file: str
    line: int
    column: int
    fingerprint: str  #: sha256 of what it means and of all that it reads
    severity: str = ""
    source: str = ""
    owner: str = ""  #: assumptions: who answers for it
    evidence: str = ""  #: assumptions: path of the record that backs it
    monitored: bool = (
        True  #: whether something is evaluated: always for rules, with a `monitor` for assumptions
    )
    compares: bool = True  #: whether it compares numbers, so that a test can sit exactly on its boundary
    #: sha256 by kind and name (`rule x`, `param y`, `signal z`) of all that `fingerprint` is made of; empty where that is not known
    inputs: Mapping[str, str] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "name": self.name, "title": self.title,
            "satisfies": [list(ref) for ref in self.satisfies], "assuming": [list(ref) for ref in self.assuming],
            "file": self.file, "line": self.line, "column": self.column, "fingerprint": self.fingerprint,
            "severity": self.severity, "source": self.source, "owner": self.owner, "evidence": self.evidence,
            "monitored": self.monitored, "compares": self.compares, "inputs": dict(self.inputs),
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> SpecItem:
        f = Fields(data, "spec item")
        return cls(
            f.word("kind", ITEM_KINDS), f.text("name"), f.text("title", ""), _refs(f, "satisfies"), _refs(f, "assuming"),
            f.text("file"), f.count("line"), f.count("column"), f.text("fingerprint"), f.text("severity", ""),
            f.text("source", ""), f.text("owner", ""), f.text("evidence", ""), f.flag("monitored", True), f.flag("compares", True),
            f.words("inputs"),
        )  # fmt: skip


def _refs(fields: Fields, name: str) -> tuple[Ref, ...]:
    items = fields.array(name)
    for item in items:
        if not (isinstance(item, list) and [type(part) for part in item] == [str, int, int]):
            raise refused(f"{fields.what}: `{name}` must be a list of [id, line, column]")
    return tuple(Ref(*item) for item in items)


@dataclass(frozen=True, slots=True)
class SpecPart:
    """What rules read or rest on: a parameter, table, place or signal, or a constraint, which is called by its text; an order of rules; a limit of the Supervisor;
    or what a scenario or a campaign is replayed with beside its own file, a line each, which is called by the path of that.

    file: empty for a limit that no spec declares, so that it has its default, and for what is replayed.
    """

    kind: str
    name: str
    fingerprint: str  #: sha256 of what it means
    shown: str  #: as people read it, on one line
    file: str
    line: int
    column: int
    of: tuple[str, ...] = ()  #: the parameters and tables that a constraint restricts
    meant: str = ""  #: of a signal: the same as `fingerprint`, in whatever order its fields stand
    source: str = ""  #: of a parameter: where it comes from

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "name": self.name, "fingerprint": self.fingerprint, "shown": self.shown, "file": self.file,
            "line": self.line, "column": self.column, "of": list(self.of), "meant": self.meant,
            "source": self.source,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> SpecPart:
        f = Fields(data, "spec part")
        return cls(
            f.word("kind", PART_KINDS), f.text("name"), f.text("fingerprint"), f.text("shown", ""), f.text("file"), f.count("line"),
            f.count("column"), f.texts("of"), f.text("meant", ""), f.text("source", ""),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class SpecTest:
    """A test written in a spec, not yet run."""

    rule: str
    title: str
    expects: str  #: a verdict
    boundary: bool  #: whether it expects a margin of 0 within a tolerance that is small against `distance`
    file: str
    line: int
    column: int
    fingerprint: str = ""  #: sha256 of what it gives and expects, worked out; empty where that is not known
    text: str = ""  #: sha256 of what is written of that
    distance: str = (
        ""  #: where it expects about 0: by how much limits are moved to see that it fails, as people read it
    )
    within: str = ""  #: the tolerance about 0, as people read it
    meant: str = ""  #: sha256 of what `text` comes to, parameters by name; empty where that is not known

    def made_from(self, rule: Mapping[str, str], engine: str) -> dict[str, str]:
        """All that its result is made from, by kind and name; `rule` is what its rule is made from."""
        moved = {"distance": self.distance} if self.boundary else {}
        return {**rule, "test": self.fingerprint, "engine": engine, **moved}

    def to_json(self) -> dict[str, Any]:
        return {
            "rule": self.rule, "title": self.title, "expects": self.expects, "boundary": self.boundary,
            "file": self.file, "line": self.line, "column": self.column, "fingerprint": self.fingerprint,
            "text": self.text, "distance": self.distance, "within": self.within, "meant": self.meant,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> SpecTest:
        f = Fields(data, "spec test")
        return cls(
            f.text("rule"), f.text("title", ""), f.word("expects", VERDICTS), f.flag("boundary", False),
            f.text("file"), f.count("line"), f.count("column"), f.text("fingerprint", ""),
            f.text("text", ""), f.text("distance", ""), f.text("within", ""), f.text("meant", ""),
        )  # fmt: skip
