"""A rule for readers as plain data, for other tools."""

from __future__ import annotations

from typing import Any

from trackmarshal.reading import mathml, typst
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.sheet import Sheet, about, beside, bounds, ends, equation, grid, origin, value, way
from trackmarshal.reading.terminal import text
from trackmarshal.units import in_full


def data(sheet: Sheet) -> dict[str, Any]:
    """The forms that the sheet has; numbers are in SI, with what people read beside them."""
    rule = sheet.rule
    made: dict[str, Any] = {
        "rule": rule.name, "title": rule.title, "kind": rule.kind, "declared": str(rule.span), "satisfies": [name for name, _ in rule.satisfies],
        "said": dict(about(rule, sheet.words)), "language": sheet.words.language,
    }  # fmt: skip
    if sheet.spec is not None:
        made["spec"] = sheet.spec
    if sheet.reading is not None:
        made["formula"] = _reading(sheet)
    if sheet.told is not None:
        made["words"] = {"demand": list(sheet.told.demand), "definitions": list(sheet.told.definitions)}
    if sheet.c is not None:
        made["c"] = sheet.c
    if sheet.limits:
        made["limits"] = [
            {"said": one.said, "formulas": [_printed(each) for each in one.formulas]} for one in sheet.limits
        ]
    return made


def _printed(piece: Layout) -> dict[str, str]:
    return {"text": text(piece), "mathml": mathml.formula(piece), "typst": typst.formula(piece)}


def _reading(sheet: Sheet) -> dict[str, Any]:
    reading, words = sheet.reading, sheet.words
    assert reading is not None
    return {
        "clauses": [
            {"kind": one.kind, "depth": one.depth, "said": beside(one, words), **_printed(one.formula)} for one in reading.clauses
        ],
        "definitions": [
            {"name": one.symbol.qualified, **_printed(equation(one.head, one.sign, one.body))} for one in reading.definitions
        ],
        "machines": [
            {
                **_printed(one.head), "states": list(one.states), "start": one.start, "bridges": one.bridges,
                "moves": [
                    {"from": list(move.sources), "to": move.target, "when": _printed(move.guard), "remembers": [_printed(kept) for kept in move.kept]}
                    for move in one.moves
                ],
            }
            for one in reading.machines
        ],
        "parameters": [
            {
                "name": one.info.name, "shown": text(one.shown), "value": one.info.value, "unit": one.info.unit, "written": value(one),
                "range": bounds(one, words), "from": origin(one, words), "overridden": one.overridden, "declared": str(one.declared.span),
                "ends": list(ends(one)), "source": one.info.source or "", "place": str(one.info.span),
                "replaced": in_full(one.declared.value, one.unit) if one.overridden else "",
            }
            for one in reading.settings
        ],
        "tables": [{"name": info.name, "shown": text(shown), "way": way(info), "rows": grid(info)} for shown, info in reading.tables],
        "places": [{"name": one.name, "kind": one.kind, "track": one.track, "points": [list(point) for point in one.points]} for one in reading.places],
        "inputs": [
            {"signal": signal, "field": name, "unit": "" if info is None else info.unit} for signal, name, info in reading.inputs
        ],
    }  # fmt: skip
