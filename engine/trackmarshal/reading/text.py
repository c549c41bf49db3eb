"""A rule for readers as lines for a terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from trackmarshal.reading.breaking import STEP
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.rule import MachineShown, Reading, Setting
from trackmarshal.reading.sheet import (
    Sheet,
    about,
    beside,
    bounds,
    equation,
    grid,
    origin,
    placed,
    value,
    way,
)
from trackmarshal.reading.telling import Told
from trackmarshal.reading.terminal import block, text
from trackmarshal.reading.words import Words

#: Letters on a line.
WIDTH = 110


def lines(sheet: Sheet, single: bool = False) -> Iterator[str]:
    """All that the sheet has; single: one form alone, without the heads of all."""
    words, rule = sheet.words, sheet.rule
    if not single:
        yield f"{rule.name}: {rule.title}"
        for label, said in about(rule, words):
            yield from _wrapped(f"{label}: {said}", 1, 1)
    for label, made in _forms(sheet):
        if not single:
            yield ""
            yield words.labels[label]
        yield from (f"{'' if single or not line else ' ' * STEP}{line}" for line in made)


def _forms(sheet: Sheet) -> Iterator[tuple[str, list[str]]]:
    if sheet.spec is not None:
        yield "spec", sheet.spec.splitlines()
    if sheet.reading is not None:
        yield "formula", list(_formula(sheet.reading, sheet.words))
    if sheet.told is not None:
        yield "english", list(_told(sheet.told))
    if sheet.c is not None:
        yield "c", sheet.c.splitlines()
    if sheet.limits:
        yield "limits", [line for one in sheet.limits for line in _limit(one.said, one.formulas)]
    if sheet.reading is not None and sheet.reading.settings:
        yield "parameters", list(_settings(sheet.reading.settings, sheet.words))


def _limit(said: str, formulas: Sequence[Layout]) -> Iterator[str]:
    yield from _wrapped(said, 0)
    for one in formulas:
        yield from block(one, WIDTH, 1)


def _wrapped(said: str, indent: int, hanging: int = 0) -> list[str]:
    moved = " " * STEP * indent
    return textwrap.wrap(
        said, WIDTH, initial_indent=moved, subsequent_indent=moved + " " * STEP * hanging, break_on_hyphens=False, break_long_words=False
    )  # fmt: skip


def _formula(reading: Reading, words: Words) -> Iterator[str]:
    for clause in reading.clauses:
        word = words.clauses[clause.kind]
        made = block(clause.formula, WIDTH - STEP * clause.depth - len(word))
        said = beside(clause, words)
        moved = " " * STEP * clause.depth
        yield f"{moved}{word} {made[0]}".rstrip() if word else f"{moved}{made[0]}"
        yield from (f"{moved}{' ' * (len(word) + 1 if word else 0)}{line}" for line in made[1:])
        if said:
            yield f"{moved}{' ' * (len(word) + 1)}{said}"
    if reading.definitions or reading.machines:
        yield words.labels["definitions"]
    for one in reading.definitions:
        yield from block(equation(one.head, one.sign, one.body), WIDTH, 1)
    for machine in reading.machines:
        yield from _machine(machine, words)
    for shown, table in reading.tables:
        yield f"{' ' * STEP}{text(shown)}: {way(table)}"
        rows = grid(table)
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        for row in rows:
            yield " " * 2 * STEP + "  ".join(cell.rjust(width) for cell, width in zip(row, widths)).rstrip()
    for place in reading.places:
        yield f"{' ' * STEP}{placed(place, words)}"


def _machine(machine: MachineShown, words: Words) -> Iterator[str]:
    labels, moved = words.labels, " " * STEP
    states = ", ".join(machine.states)
    bridges = f"; {labels['bridges']} {machine.bridges}" if machine.bridges else ""
    yield f"{moved}{text(machine.head)}: {states}; {labels['starts']} {machine.start}{bridges}"
    for one in machine.moves:
        yield f"{moved * 2}{labels['becomes']} {one.target} {labels['from']} {', '.join(one.sources)} {labels['when']}"
        yield from block(one.guard, WIDTH, 3)
        for kept in one.kept:
            yield f"{moved * 3}{labels['remember']} {text(kept)}"


def _told(told: Told) -> Iterator[str]:
    for paragraph in told.demand:
        yield from _wrapped(paragraph, 0)
    for paragraph in told.definitions:
        yield from _wrapped(paragraph, 1, 1)


def _settings(settings: Sequence[Setting], words: Words) -> Iterator[str]:
    rows = [(text(one.shown), value(one), bounds(one, words)) for one in settings]
    widths = [max(len(row[k]) for row in rows) for k in range(3)]
    for row, one in zip(rows, settings):
        columns = "  ".join(cell.ljust(width) for cell, width in zip(row, widths))
        yield f"{columns}  {origin(one, words)}".rstrip()
