"""The argument as text for a terminal: each module from its top goal down, indented."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.trace.gsn.case import Case, Element, Module
from trackmarshal.trace.gsn.picture.svg import STATUS
from trackmarshal.trace.render.words import printable

_SIGNS = {
    "goal": "", "strategy": "by: ", "solution": "shown by: ", "context": "context: ", "assumption": "assumption: ",
    "justification": "justification: ", "counter goal": "challenged by: ", "counter solution": "challenged by: ",
}  # fmt: skip


def render(case: Case, modules: Sequence[Module]) -> str:
    """Some modules, one line an element; what stands elsewhere is named with its module."""
    return "\n\n".join("\n".join(_module(case, module)) for module in modules) + "\n"


def _module(case: Case, module: Module) -> Iterator[str]:
    yield f"module {module.name}"
    seen: set[str] = set()
    roots = [module.root, *(e.id for e in case.members.get(module.name, ()))]
    for root in roots:
        todo = [(root, 1)] if root not in seen and root in case.elements else []
        while todo:
            id_, depth = todo.pop()
            element = case.elements.get(id_)
            if element is None:
                yield f"{'  ' * depth}{id_}: there is no such element"
                continue
            again = id_ in seen
            seen.add(id_)
            yield "  " * depth + printable(_line(element, module, again))
            if again or element.module != module.name:
                continue
            out = case.out.get(id_, ())
            beside = [k.target for k in out if k.kind == "in_context_of"]
            against = [k.source for k in case.into.get(id_, ()) if k.kind == "challenges"]
            below = [k.target for k in out if k.kind == "supported_by"]
            todo += [(other, depth + 1) for other in reversed([*beside, *against, *below])]


def _line(e: Element, module: Module, again: bool) -> str:
    sign = STATUS[e.status][0] if e.status else ""
    marks = [e.status or e.state, "undeveloped" if e.undeveloped else "", f"module {e.module}" if e.module != module.name else ""]  # fmt: skip
    marks.append("above" if again and e.module == module.name else "")
    said = ", ".join(mark for mark in marks if mark)
    return f"{sign} {_SIGNS[e.kind]}{e.id}: {e.text}{f' [{said}]' if said else ''}".lstrip()


__all__ = ["render"]
