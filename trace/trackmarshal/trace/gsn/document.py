"""The document `argument`: templates that the argument is made of, defeaters that people raise, confidence points. The one that comes with the program is argument.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from trackmarshal.trace import tree
from trackmarshal.trace.documents_argument import ARGUMENT
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.gsn.kinds import ITSELF
from trackmarshal.trace.model import Condition
from trackmarshal.trace.values import Placed, Reader, Table

DEFAULT = Path(__file__).with_name("argument.yaml")


@dataclass(frozen=True, slots=True)
class Step:
    """From an element to others."""

    place: Place
    template: Placed
    over: Placed
    where: tuple[Condition, ...]
    without: tuple[Placed, ...]
    if_any: str
    cites: Placed
    module: Placed


@dataclass(frozen=True, slots=True)
class Template:
    """What makes elements."""

    name: Placed
    element: str
    about: str
    id: Placed
    text: Placed
    supported_by: tuple[Step, ...]
    in_context_of: tuple[Step, ...]
    challenged_by: tuple[Step, ...]
    undeveloped: str
    module: bool

    @property
    def steps(self) -> tuple[tuple[str, tuple[Step, ...]], ...]:
        """Its steps by the kind of links that they make; of challenges the links lead back to the element."""
        return (("in_context_of", self.in_context_of), ("challenges", self.challenged_by), ("supported_by", self.supported_by))  # fmt: skip


@dataclass(frozen=True, slots=True)
class Defeater:
    """What somebody says against an element."""

    id: Placed
    challenges: Placed
    text: str
    evidence: bool
    owner: str
    state: str
    answer: str


@dataclass(frozen=True, slots=True)
class Argument:
    """The document; where it has no templates, those of the program are meant."""

    top: Placed
    groups: str
    templates: tuple[Template, ...]
    defeaters: tuple[Defeater, ...]
    confidence: tuple[tuple[Placed, Placed, Placed, str], ...]


@cache
def default() -> Argument:
    """The templates that come with the program; raises ValueError if they are damaged."""
    found: list[Finding] = []
    node = tree.parse(DEFAULT.read_bytes(), DEFAULT.name, found)
    table = Reader(DEFAULT.name, found).table(node, ARGUMENT, "the document") if node is not None else None
    if table is None or found:
        raise ValueError(f"{DEFAULT} is damaged: {'; '.join(map(str, found))}")
    return argument(table)


def argument(t: Table) -> Argument:
    """The document as records."""
    templates = tuple(_template(one) for one in t.tables("templates") if one.text("name"))
    defeaters = tuple(
        Defeater(
            d.text("id"), d.text("challenges"), d.text("text"), d.get("evidence", False), d.text("owner"), d.text("state"), d.text("answer")
        )
        for d in t.tables("defeaters")
        if d.text("id")
    )  # fmt: skip
    points = tuple(
        (p.text("id"), p.text("at"), p.text("to"), str(p.text("text")))
        for p in t.tables("confidence")
        if p.text("id")
    )
    return Argument(t.text("top"), t.text("groups"), templates, defeaters, points)


def _template(t: Table) -> Template:
    steps = {name: tuple(map(_step, t.tables(name))) for name in ("supported_by", "in_context_of", "challenged_by")}  # fmt: skip
    return Template(
        t.text("name"), t.text("element"), t.text("about"), t.text("id"), t.text("text"), **steps,
        undeveloped=t.text("undeveloped") or "never", module=t.get("module", False),
    )  # fmt: skip


def _step(t: Table) -> Step:
    where = tuple(Condition(c.text("attribute"), c.texts("is")) for c in t.tables("where"))
    return Step(
        t.place, t.text("template"), t.text("over") or Placed.at(ITSELF, t.place), where, t.texts("without"), t.text("if_any"),
        t.text("cites"), t.text("module"),
    )  # fmt: skip
