"""What pictures say in words, in the language that they are asked for in; what people and templates wrote stays as it is."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal.trace.gsn.case import Case, Element
from trackmarshal.trace.gsn.kinds import LINKS
from trackmarshal.trace.gsn.picture.boxes import standing
from trackmarshal.trace.gsn.picture.content import Content, Shown

#: So much evidence is listed where a pointer rests on a solution; all of it is in the export as JSON.
LISTED = 12


def heading(case: Case, shown: Content, words: Mapping[str, str]) -> str:
    """Project and module, and how far its claim is supported."""
    status = standing(case.elements[shown.module.root], words)
    said = words["gsn.heading"].format(project=case.project, module=shown.module.name)
    return f"{said}, {status}" if status else said


def described(shown: Content, words: Mapping[str, str]) -> str:
    """The picture in words: each element with what supports it, what it stands in the context of, what challenges it."""
    lines = []
    for id_, one in shown.shown.items():
        line = said(one, words)
        for kind in LINKS:
            others = [k.target for k in shown.links if k.source == id_ and k.kind == kind]
            line += f" {words[f'gsn.{kind}'].format(others=', '.join(others))}" if others else ""
        lines.append(line)
    return "\n".join(lines)


def said(one: Shown, words: Mapping[str, str]) -> str:
    """An element with its text, and in parentheses how it stands."""
    e = one.element
    text = e.text if e.text.endswith((".", ":")) else f"{e.text}."
    away = words["gsn.away"].format(module=e.module) if one.away else ""
    marks = [m for m in (standing(e, words), words["gsn.undeveloped"] if e.undeveloped else "", away) if m]
    kind = words[f"gsn.kind.{e.kind}"]
    return f"{kind} {e.id}: {text}" + (f" ({', '.join(marks)})" if marks else "")


def evidence(element: Element, words: Mapping[str, str]) -> list[str]:
    """The first pieces of evidence of a solution, with the beginnings of their hashes."""
    unknown = words["gsn.unknown"]
    shown = [
        f"{e.kind} {e.name}: {words[f'status.{e.status}']}, sha256 {e.sha256[:12] or unknown}"
        for e in element.evidence[:LISTED]
    ]
    more = len(element.evidence) - LISTED
    return [*shown, *([words["gsn.more"].format(number=more)] if more > 0 else [])]


__all__ = ["described", "evidence", "heading", "said"]
