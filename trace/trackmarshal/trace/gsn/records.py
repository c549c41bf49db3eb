"""The argument as strict JSON: all modules, elements, links, evidence with hashes, and findings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from trackmarshal.trace.gsn.case import Case, Element, Module
from trackmarshal.trace.render.data import finding_record, span

FORMAT = "trackmarshal-argument"
VERSION = 1


def render(case: Case, modules: Sequence[Module]) -> str:
    """Some modules, each with its elements in order, and every link that stands at one of them."""
    own = {module.name for module in modules}
    data = {
        "format": FORMAT,
        "version": VERSION,
        "project": case.project,
        "top": next((e.id for e in case.tops if e.kind == "goal"), None),
        "modules": [{"name": m.name, "root": m.root, "title": m.title} for m in modules],
        "elements": [_element(e) for e in case.elements.values() if e.module in own],
        "links": [
            {"kind": k.kind, "source": k.source, "target": k.target, "span": span(k.place)}
            for k in case.links
            if k.source in case.elements and case.elements[k.source].module in own
        ],
        "confidence": [{"id": p.id, "at": p.at, "to": p.to or None, "text": p.text, "span": span(p.place)} for p in case.points],
        "findings": [finding_record(finding) for finding in case.findings],
    }  # fmt: skip
    return json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _element(e: Element) -> dict[str, Any]:
    return {
        "id": e.id, "kind": e.kind, "text": e.text, "module": e.module, "status": e.status or None, "state": e.state or None,
        "undeveloped": e.undeveloped, "public": e.public, "about": list(e.about) if e.about else None, "span": span(e.place),
        "evidence": [
            {"kind": one.kind, "name": one.name, "status": one.status, "sha256": one.sha256 or None, "span": span(one.place)} for one in e.evidence
        ],
    }  # fmt: skip


__all__ = ["render"]
