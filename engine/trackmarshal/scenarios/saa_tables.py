"""The tables in a `.saa` archive: what drive and tyres can do over speed."""

from __future__ import annotations

import math

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content
from trackmarshal.scenarios.archive import Archive

Table = list[list[float]]
Tables = dict[str, Table]


def read(archive: Archive) -> Tables:
    """`ax_max` (m/s -> m/s^2) and `grip` (m/s -> the smaller of both directions, m/s^2), those that are there."""
    tables: Tables = {}
    name = archive.name_of("_ax_max_machines.csv")
    if name is not None:
        tables["ax_max"] = _rows(archive, name, 2)
    name = archive.name_of("_ggv.csv")
    if name is not None:
        tables["grip"] = [[v, min(ax, ay)] for v, ax, ay in _rows(archive, name, 3)]
    return tables


def _rows(archive: Archive, name: str, width: int) -> Table:
    """Rows of `width` finite numbers, the first strictly increasing; raises D131 with the line."""
    shown = f"{archive.shown}!{name}"
    rows: Table = []
    for line, text in enumerate(content.text(archive.read(name), shown).split("\n"), start=1):
        if not text.strip() or text.startswith("#"):
            continue
        try:
            row = [float(cell) for cell in text.split(",")]
        except ValueError as error:
            help_ = "rows of numbers such as `1.5`, with commas between"
            raise TrackmarshalError("D131", str(error), file=shown, line=line, help=help_) from error
        if len(row) != width or not all(map(math.isfinite, row)):
            message = f"{text.strip()[:60]!r} is no row of {width} finite numbers"
            raise TrackmarshalError(
                "D131", message, file=shown, line=line, help="see the header of the table"
            )
        if rows and row[0] <= rows[-1][0]:
            message = f"speed {row[0]:g} m/s does not come after {rows[-1][0]:g} m/s"
            raise TrackmarshalError("D131", message, file=shown, line=line, help="sort the rows by speed")
        rows.append(row)
    if not rows:
        raise TrackmarshalError(
            "D131", "the table has no rows", file=shown, help="take the file out or fill it"
        )
    return rows
