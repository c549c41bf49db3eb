"""The argument as goal structure: a picture a module, in the order from the top goal down."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from trackmarshal.trace.case.model import (
    Block,
    Code,
    Figure,
    Fixed,
    Line,
    Made,
    Section,
    Status,
    Verbatim,
)
from trackmarshal.trace.case.writing import Writing
from trackmarshal.trace.graph.graph import Key
from trackmarshal.trace.gsn import outline
from trackmarshal.trace.gsn.case import Case, Module

#: So many modules are shown, from the top goal down: more pictures than that nobody looks through, and `trackmarshal gsn --out` has all.
SHOWN = 200
#: A millimetre in points.
_MM = 72 / 25.4
_SIZE = re.compile(r'<svg [^>]*?width="([0-9.]+)mm" height="([0-9.]+)mm"')
_OPENING = '<?xml version="1.0" encoding="UTF-8"?>\n'


def argument(writing: Writing) -> Section:
    """Each module drawn; where nothing can be drawn, in words."""
    case = writing.given.argument
    pictures = drawn(case, writing.anchors, writing.words) if writing.given.draw else None
    blocks: list[Block] = [writing.paragraph("argument.how")]
    if len(case.modules) > 1:
        blocks.append(writing.named("argument.modules", [_named(writing, case.modules[:SHOWN], refs=True)]))
    if pictures is None:
        blocks.append(writing.missing("argument.undrawn"))
    for number, module in enumerate(case.modules[:SHOWN]):
        status = case.elements[module.root].status
        title: Line = (Code(module.name), Fixed(" "), *((Status(status),) if status else ()))
        shown: Block
        if pictures is None:
            shown = Verbatim(outline.render(case, [module]).rstrip())
        else:
            shown = Figure(pictures[number], module.title, *_size(pictures[number]))
        blocks.append(writing.part(title, [shown], ("module", module.name), level=3))
    if case.modules[SHOWN:]:
        blocks.append(writing.named("argument.rest", [_named(writing, case.modules[SHOWN:])]))
    return writing.section("argument", blocks)


def _named(writing: Writing, modules: Sequence[Module], refs: bool = False) -> Block:
    """Modules by name, with how far each is supported; refs: they stand elsewhere, and are linked."""
    elements = writing.given.argument.elements
    rows: list[list[Line]] = []
    for module in modules:
        status = elements[module.root].status  # what stands beside the argument has none
        name = writing.ref(("module", module.name)) if refs else Code(module.name)
        rows.append([(name,), (Status(status),) if status else (), (Made(module.title),)])
    columns = (("column.module", 2.0), ("column.status", 1.5), ("column.claim", 6.0))
    keys = [] if refs else [("module", module.name) for module in modules]
    return writing.table(columns, rows, keys)


def drawn(case: Case, anchors: Mapping[Key, str], words: Mapping[str, str]) -> list[str]:
    """The pictures of the modules that are shown, for a page that holds all of them: elements from elsewhere lead to their module's place there. Raises T424, T425."""
    from trackmarshal.trace.gsn.picture.svg import pictures

    places = {module.name: f"#{anchors['module', module.name]}" for module in case.modules}
    modules = case.modules[:SHOWN]
    return [_inside(svg, number) for number, svg in enumerate(pictures(case, modules, places, words))]


def _inside(svg: str, number: int) -> str:
    """A picture inside a page: without what begins a file, and with ids that no other picture there has."""
    said = svg.removeprefix(_OPENING)
    for alone, one_of_many in (
        ('aria-labelledby="name said"', f'aria-labelledby="name-{number} said-{number}"'),
        ('<title id="name">', f'<title id="name-{number}">'),
        ('<desc id="said">', f'<desc id="said-{number}">'),
    ):
        if said.count(alone) != 1:
            raise ValueError(f"a picture without one {alone}")
        said = said.replace(alone, one_of_many)
    return said


def _size(svg: str) -> tuple[float, float]:
    """Width and height in points."""
    found = _SIZE.search(svg)
    if found is None:
        raise ValueError("a picture without a size")
    return float(found[1]) * _MM, float(found[2]) * _MM


def undeveloped(writing: Writing) -> Block | None:
    """The elements of the argument that nobody has argued for yet; None where there are none."""
    open_ = [element for element in writing.given.argument.elements.values() if element.undeveloped]
    if not open_:
        return None
    columns = (("column.id", 2.5), ("column.claim", 6.0), ("column.module", 2.0))
    rows: list[list[Line]] = [
        [(Code(e.id),), (Made(e.text),), (writing.ref(("module", e.module)),)] for e in open_
    ]
    return writing.named("open.undeveloped", [writing.table(columns, rows)])


def wrong(writing: Writing) -> Block | None:
    """What is wrong with the argument; None where nothing is."""
    found = writing.given.argument.findings
    if not found:
        return None
    columns = (("column.code", 1.0), ("column.finding", 6.0), ("column.place", 3.0))
    rows = [
        [
            (Code(f.code), Fixed(" "), *writing.line(f"finding.{f.level}")),
            (Made(f.message),),
            (Code(str(f.place or "")),),
        ]
        for f in found
    ]
    return writing.named("open.argument", [writing.table(columns, rows)])


__all__ = ["argument", "drawn", "undeveloped", "wrong"]
