"""Templates filled in: from the project's top goal down, one element for each template and each thing that steps lead to with it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping

from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.graph.graph import Graph, Key, Node, holds
from trackmarshal.trace.graph.kinds import LINKS, WAYS
from trackmarshal.trace.graph.schema import fits
from trackmarshal.trace.gsn.case import Case, Element, Link, a_kind
from trackmarshal.trace.gsn.document import Step, Template
from trackmarshal.trace.gsn.kinds import ALL, BESIDE, COUNTER, ITSELF, OPEN, WALKS
from trackmarshal.trace.gsn.statuses import below_first
from trackmarshal.trace.gsn.subjects import Subjects

#: More elements of one template than this beside one element are one, which lists them.
JOINED = 3
_HOLE = re.compile(r"\{([A-Za-z_]+)\}")


class Filling:
    """Elements and links in the order in which they are come to; of what is wrong with templates, the findings."""

    def __init__(self, graph: Graph, subjects: Subjects, templates: Iterable[Template]) -> None:
        self._graph = graph
        self._subjects = subjects
        self.elements: dict[str, Element] = {}
        self.links: list[Link] = []
        self.findings: list[Finding] = []
        #: Elements at which a module may begin.
        self.beginnings: set[str] = set()
        self._made: dict[tuple[str, Key], str] = {}
        self._many: dict[tuple[str, tuple[Key, ...]], str] = {}
        self._todo: list[tuple[Template, Node, str]] = []
        self._templates: dict[str, Template] = {}
        for template in templates:
            if template.name in self._templates:
                message = f"a second template `{template.name}`"
                self.findings.append(error("T400", message, template.name.place, "give it another name"))
            self._templates.setdefault(str(template.name), template)
        self._steps = {id(step): self._fits(step, t) for t in self._templates.values() for _, steps in t.steps for step in steps}  # fmt: skip
        self._walks: Mapping[str, Callable[[Node], Iterator[Node]]] = {
            "cells": subjects.cells, "evidence": subjects.evidence, "gaps": subjects.gaps, "failures": subjects.failures,
            "waivers": subjects.waivers,
        }  # fmt: skip

    def fill(self, top: str, place: Place | None) -> None:
        """Everything below the top goal; raises nothing: what cannot be filled in is a finding (T400, T415, T416, T420)."""
        template = self._templates.get(top)
        if template is None or template.about != "project":
            why = "there is none" if template is None else f"it is about {a_kind(template.about)}"
            message = f"the top goal's template is to be `{top}`, about the project, and {why}"
            self.findings.append(error("T400", message, place, did_you_mean(top, self._templates)))
            return
        self._element(template, self._subjects.project)
        while self._todo:
            current, subject, id_ = self._todo.pop()
            for kind, steps in current.steps:
                for step in steps:
                    if self._steps[id(step)]:
                        self._step(kind, step, subject, id_)
        self._open_ends()

    def _open_ends(self) -> None:
        """Elements that nothing supports are left out, or marked as undeveloped, where their templates say so; what only they led to goes too."""
        ends = {t.name.place: t.undeveloped for t in self._templates.values()}
        case = Case("", self.elements, tuple(self.links))
        gone: set[str] = set()
        for id_ in below_first(case):
            element = self.elements[id_]
            if element.origin is None or any(t not in gone for t in case.targets(id_, "supported_by")):
                continue
            match ends[element.origin]:
                case "left-out":
                    gone.add(id_)
                case "open":
                    self.elements[id_] = element._replace(undeveloped=True)
                case "never" | "always":
                    pass
                case other:
                    raise ValueError(f"unknown word for ends {other!r}")
        if gone:
            self.links = [link for link in self.links if link.source not in gone and link.target not in gone]
            held = {end for link in self.links for end in (link.source, link.target)}
            beside = {
                link.target for g in gone for link in case.out.get(g, ()) if link.kind == "in_context_of"
            }
            beside |= {
                link.source for g in gone for link in case.into.get(g, ()) if link.kind == "challenges"
            }
            gone |= beside - held
            self.elements = {id_: e for id_, e in self.elements.items() if id_ not in gone}

    def _fits(self, step: Step, at: Template) -> bool:
        """Whether a step can be taken from things of a template's kind; else it is said (T400, T420)."""
        if bool(step.template) == bool(step.cites):
            message = (
                f"a step of the template `{at.name}` names neither a template nor what it cites, or both"
            )
            self.findings.append(error("T420", message, step.place, "give one of `template` and `cites`"))
            return False
        if step.cites:
            return True
        to = self._templates.get(step.template)
        if to is None:
            message = f"the template `{at.name}` leads to a template `{step.template}`, and there is none"
            self.findings.append(error("T400", message, step.template.place, did_you_mean(step.template, self._templates)))  # fmt: skip
            return False
        starts, ends = _reach(step.over, at.about, to.about)
        if (starts and at.about not in starts) or (ends and to.about not in ends):
            if starts and at.about not in starts:
                has = f"{a_kind(at.about)} has no `{step.over}`"
                help_ = "it has " + ", ".join(way for way in (ITSELF, ALL, *WALKS, *WAYS) if at.about in (_reach(way, at.about, to.about)[0] or (at.about,)))  # fmt: skip
            else:
                has = f"`{step.over}` leads to {' or '.join(ends)}, and the template `{to.name}` is about {a_kind(to.about)}"  # fmt: skip
                help_ = "name a template that is about that, or go another way"
            self.findings.append(error("T420", f"the template `{at.name}`: {has}", step.over.place, help_))
            return False
        return True

    def _step(self, kind: str, step: Step, subject: Node, at: str) -> None:
        if step.if_any and not self._graph.by_kind.get(step.if_any):
            return
        if step.cites:
            cited, module = _filled(step.cites, subject), _filled(step.module, subject)
            self._link(kind, at, safe(cited), step.place, safe(module) if module else "")
            return
        to = self._templates[step.template]
        found = [node for node in self._over(step, subject, to) if self._wanted(node, step)]
        if (to.element in BESIDE or kind == "challenges") and len(found) > JOINED:
            self._link(kind, at, self._joined(to, found, at), step.place)
            return
        for node in found:
            self._link(kind, at, self._element(to, node), step.place)

    def _link(self, kind: str, at: str, other: str, place: Place, cited: str = "") -> None:
        source, target = (other, at) if kind == "challenges" else (at, other)
        self.links.append(Link(kind, source, target, place, cited))

    def _over(self, step: Step, subject: Node, to: Template) -> Iterable[Node]:
        if step.over == ITSELF:
            return (subject,)
        if step.over == ALL:
            return (node for node in self._graph.by_kind.get(to.about, ()) if node.demanded)
        if step.over in WALKS:
            return self._walks[step.over](subject)
        kind, outward = WAYS[step.over]
        links = self._graph.out_of(subject.key) if outward else self._graph.into(subject.key)
        keys = dict.fromkeys(link.target if outward else link.source for link in links if link.kind == kind and holds(link))  # fmt: skip
        nodes = (self._graph.nodes[key] for key in keys)
        return (node for node in nodes if node.kind == to.about and node.demanded)

    def _wanted(self, node: Node, step: Step) -> bool:
        return fits(node, step.where) and not any(self._linked(node, way) for way in step.without)

    def _linked(self, node: Node, way: str) -> bool:
        """Whether a link of a kind holds at a node, and its other end is demanded."""
        kind, outward = WAYS[way]
        links = self._graph.out_of(node.key) if outward else self._graph.into(node.key)
        ends = (link.target if outward else link.source for link in links if link.kind == kind and holds(link))  # fmt: skip
        return any(self._graph.nodes[key].demanded for key in ends)

    def _element(self, template: Template, subject: Node) -> str:
        """The id of the element of a template about a thing, which is made when it is first come to."""
        key = (str(template.name), subject.key)
        if key in self._made:
            return self._made[key]
        id_ = self._id(_filled(template.id, subject), template, subject)
        self._made[key] = id_
        leaf, evidence = self._subjects.leaves.get(subject.key, ("", ()))
        shows = template.element == "solution"  # a claim about evidence is no evidence
        self.elements[id_] = Element(
            id_, str(template.element), _filled(template.text, subject), subject.place, template.name.place, subject.key,
            undeveloped=template.undeveloped == "always", evidence=evidence if shows else (),
            leaf=leaf if shows or not evidence else "", state=OPEN if template.element in COUNTER else "",
        )  # fmt: skip
        if template.module:
            self.beginnings.add(id_)
        self._todo.append((template, subject, id_))
        return id_

    def _id(self, wanted: str, template: Template, subject: Node) -> str:
        """An id as it is asked for; where another element has it, that is said (T416), unless only what it is made of made them one."""
        id_ = safe(wanted)
        if id_ not in self.elements:
            return id_
        if wanted == id_ and not _HOLE.search(wanted):
            message = f"`{id_}` is the id of two elements of the argument: one of the template `{template.name}` about the {subject.kind} `{subject.id}`, and another one"
            self.findings.append(error("T416", message, template.id.place, "let ids of templates differ"))
        return self._free(id_)

    def _joined(self, template: Template, found: list[Node], at: str) -> str:
        """One element for many that stand beside one; for the same ones elsewhere, the same."""
        key = (str(template.name), tuple(node.key for node in found))
        if key not in self._many:
            id_ = self._free(safe(f"{_filled(template.id, found[0])}-and-{len(found) - 1}-more"))
            texts = [f"({number}) {_filled(template.text, node)}" for number, node in enumerate(found, 1)]
            self.elements[id_] = Element(
                id_, str(template.element), " ".join(texts), self.elements[at].place, template.name.place,
                state=OPEN if template.element in COUNTER else "",
            )  # fmt: skip
            self._many[key] = id_
        return self._many[key]

    def _free(self, id_: str) -> str:
        """The id, with a number where another element has it."""
        if id_ not in self.elements:
            return id_
        number = 2
        while f"{id_}-{number}" in self.elements:
            number += 1
        return f"{id_}-{number}"


def _reach(over: str, at: str, to: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The kinds of things that a way starts at and leads to; none: any."""
    if over == ITSELF:
        return (to,), (at,)
    if over == ALL:
        return (), ()
    if over in WALKS:
        start, end = WALKS[over]
        return (start,), (end,)
    kind, outward = WAYS[over]
    ends = LINKS[kind].sources, LINKS[kind].targets
    return ends if outward else (ends[1], ends[0])


def _filled(text: str, subject: Node) -> str:
    """The text with what the subject says; names that it does not have, or says nothing under, stay in their braces."""
    said = {**subject.attributes, "id": subject.id, "title": subject.title}
    return _HOLE.sub(lambda match: said.get(match[1]) or match[0], str(text))


def safe(id_: str) -> str:
    """An id of letters, digits, `.`, `_` and `-`, so that it is one word in YAML, in a file's name and in a picture."""
    return re.sub(r"[^\w.{}-]+", "-", id_).strip("-") or "element"


__all__ = ["JOINED", "Filling", "safe"]
