"""The document `argument`: templates that the argument is made of, defeaters that people raise, confidence points. The one that comes with the program is argument.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from trackmarshal.trace import tree
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.kinds import NODES, WAYS
from trackmarshal.trace.gsn.case import ANSWERED, KINDS, OPEN, UPHELD
from trackmarshal.trace.model import Condition
from trackmarshal.trace.shapes import ID, Field, Flag, Many, Record, Text, Word, optional
from trackmarshal.trace.values import Placed, Reader, Table

DEFAULT = Path(__file__).with_name("argument.yaml")
TEXT = Text()
NAME = Text(r"[a-z][a-z0-9-]*", "a name in small letters such as `safety-goal`")
#: What is no node of the link graph, and may have an element of the argument all the same.
BEYOND = {
    "project": "the project as a whole",
    "cell": "what a stage of the V-model asks of a requirement: a cell of the matrix",
    "evidence": "what there is in a cell",
    "gap": "what is missing in a cell",
    "failure": "what failed in a cell",
}
SUBJECTS = {**NODES, **BEYOND}
#: Ways from a thing to others beside the links of the graph: what stands at their start (none: anything), and what they lead to.
WALKS: dict[str, tuple[str, str]] = {
    "cells": ("requirement", "cell"),
    "evidence": ("cell", "evidence"),
    "gaps": ("cell", "gap"),
    "failures": ("cell", "failure"),
    "waivers": ("cell", "waiver"),
}
#: The thing itself, and all things of the kind that the template is about.
ITSELF, ALL = "itself", "all"

CONDITION = Record("subject_condition", "What an attribute of the thing has to be.", (
    Field("attribute", TEXT, "An attribute, such as `asil`, `status` or `outcome`."),
    Field("is", Many(TEXT, 1), "The values that fit; `*` stands for any characters."),
))  # fmt: skip

STEP = Record("step", "Elements that a template's element is linked to: one for each thing that the step leads to.", (
    optional("template", NAME, "The template of these elements."),
    optional("over", Word(dict.fromkeys((ITSELF, ALL, *WALKS, *WAYS), "")),
             "Links of the graph (or their converse), `itself`, `all` things of the template's kind, or what is in a cell: `cells`, `evidence`, `gaps`, `failures`, `waivers`."),
    optional("where", Many(CONDITION, 1), "Only to things of which all of this is true."),
    optional("without", Many(Word(dict.fromkeys(WAYS, "")), 1), "Only to things that have none of these links."),
    optional("if_any", Word(dict.fromkeys(NODES, "")), "Only in projects that have a thing of this kind."),
    optional("cites", TEXT, "In place of a template: the id of an element that another template makes."),
    optional("module", TEXT, "With `cites`: the module in which it has to be, as a public goal."),
))  # fmt: skip
_STEPS = Many(STEP, 1)

TEMPLATE = Record("template", "An element of the argument, for each thing that steps lead to with it. In its texts, `{id}`, `{title}` and any attribute of the thing stand for what it says.", (
    Field("name", NAME, "Unique in the document."),
    Field("element", Word(KINDS), "The kind of element."),
    Field("about", Word(SUBJECTS), "The kind of things that it is about."),
    Field("id", TEXT, "The element's id. gsn2x reads the kind off its first letters: G, S, Sn, C, A, J, CG, CSn."),
    Field("text", TEXT, "What it says."),
    optional("supported_by", _STEPS, "What supports it."),
    optional("in_context_of", _STEPS, "Contexts, assumptions and justifications."),
    optional("challenged_by", _STEPS, "Counter goals and counter solutions against it."),
    optional("undeveloped", Word({"never": "an end without support is an error", "open": "where nothing supports it", "always": "whatever supports it",
                              "left-out": "the element is left out where nothing supports it"}),
             "Whether it is marked as undeveloped; `never` if not given."),
    optional("module", Flag(), "true: where the argument does not fit into one picture, a module begins here."),
))  # fmt: skip

DEFEATER = Record("defeater", "Somebody says that an element of the argument does not hold.", (
    Field("id", Text(ID, "an id such as `D-1`"), "Unique."),
    Field("challenges", TEXT, "The element, by its id, or the thing that it is about: an id, or `kind:id`."),
    Field("text", TEXT, "Why it does not hold."),
    optional("evidence", Flag(), "true: it refers to evidence, and is drawn as a counter solution."),
    Field("owner", TEXT, "Who answers for it."),
    Field("state", Word({OPEN: "nobody has answered", ANSWERED: "it does not defeat the element, and `answer` says why", UPHELD: "the element is defeated"}), "What came of it."),
    optional("answer", TEXT, "Why the element holds all the same."),
))  # fmt: skip

POINT = Record("confidence", "An assurance claim point: where confidence is argued for by itself.", (
    Field("id", Text(ID, "an id such as `ACP-1`"), "Unique."),
    Field("at", TEXT, "The element, by its id."),
    optional("to", TEXT, "For a link: the element at its other end."),
    Field("text", TEXT, "Why there is confidence in it."),
))  # fmt: skip

ARGUMENT = Record("argument", "How the argument is made, in place of the templates that come with the program; what people say against it.", (
    Field("document", Word({"argument": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where it comes from."),
    optional("top", NAME, "The template of the top goal, which is about the project."),
    optional("groups", TEXT, "What a goal says that stands for several, where there are many side by side: `{first}` and `{last}` are ids, `{number}` says how many."),
    optional("templates", Many(TEMPLATE, 1), "Templates; those of the program if not given."),
    optional("defeaters", Many(DEFEATER, 1), "What people say against the argument."),
    optional("confidence", Many(POINT, 1), "Confidence points."),
))  # fmt: skip


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


__all__ = [
    "ALL", "ARGUMENT", "BEYOND", "DEFAULT", "ITSELF", "SUBJECTS", "WALKS", "Argument", "Defeater", "Step", "Template", "argument", "default",
]  # fmt: skip
