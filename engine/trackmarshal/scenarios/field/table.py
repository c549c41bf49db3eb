"""Numbers out of delimited text: the columns that a mapping asks for, each row with its line."""

from __future__ import annotations

import csv
import io
import math
import re
import unicodedata
from collections.abc import Mapping as AnyMapping
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content
from trackmarshal.scenarios.field.mapping import Column
from trackmarshal.scenarios.fields import suggestion

Floats = NDArray[np.float64]
_DELIMITERS = {",": ",", ";": ";", "tab": "\t"}
#: A cell of a number is short; what is longer is another file.
_LONGEST = 1000
#: A number as it is written where the comma stands before decimals.
_COMMA = re.compile(r"[-+]?\d{0,20},\d{1,20}([eE][-+]?\d{1,3})?")
#: What stands between thousands: commas, apostrophes, blanks; and a number that is written so.
_SIGNS = r"[,'\u2019 \u00a0\u2009\u202f]"
_GROUPED = re.compile(rf"[-+]?[1-9]\d{{0,2}}({_SIGNS}\d{{3}}){{1,6}}(\.\d{{0,20}})?")


def read(
    data: bytes, shown: str, columns: AnyMapping[str, Column], delimiter: str
) -> tuple[dict[str, Floats], NDArray[np.int64]]:
    """(rows,) of each column, as in the file, and the line of each row. Raises D126, D170 and D171 with the line.

    The first line names the columns (a `#` before it is no part of a name), unless the mapping counts them. Names that are the same
    text to a reader are the same name, however their letters are put together (Unicode, NFC).
    """
    text = content.text(data, shown)
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise TrackmarshalError(
            "D171", "a NUL stands in the text", file=shown, line=line, help="was it cut off?"
        )
    numbers, lines = [], []
    sign = _DELIMITERS[delimiter]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=sign, strict=True)
    places: list[int] | None = None
    width = last = 0
    try:
        for cells in reader:
            if not cells or (len(cells) == 1 and not cells[0].strip()):
                last = reader.line_num
                continue
            if places is None:
                places, is_header = _places(cells, reader.line_num, shown, columns, delimiter)
                width = len(cells)
                if is_header:
                    last = reader.line_num
                    continue
            if reader.line_num > last + 1:
                _no_rows_in_cells(cells, places, sign, shown, last + 1)
            last = reader.line_num
            if len(cells) != width:
                message = f"{len(cells)} cells, the first line has {width}"
                help_ = "was the line cut off?"
                if len(cells) > width and delimiter == ",":
                    help_ = "is a comma in its numbers? They have a point: `1.5`"
                raise _wrong(message, shown, reader.line_num, help_)
            numbers.append([_number(cells, place, shown, reader.line_num) for place in places])
            lines.append(reader.line_num)
    except csv.Error as error:
        raise _wrong(str(error), shown, reader.line_num, "is this delimited text?") from error
    if not numbers:
        raise TrackmarshalError(
            "D126", "there is no row of numbers", file=shown, line=1, help="was it cut off?"
        )
    table = np.array(numbers, dtype=np.float64)
    return {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(columns)}, np.array(lines)


def _no_rows_in_cells(cells: list[str], places: list[int], delimiter: str, shown: str, line: int) -> None:
    """Raise D171 where a cell that begins with a quotation mark goes on over lines with the numbers of rows, to the next one further below.

    A cell of several lines of text is one.
    """
    for at, cell in enumerate(cells):
        inner = cell.splitlines()
        if len(inner) < 2:
            continue

        def numbers(text: str, wanted: list[int]) -> bool:
            parts = text.split(delimiter)
            return all(each < len(parts) and not math.isnan(_finite(parts[each].strip())) for each in wanted)

        # The cell begins within one row and ends within another: only both say so, as a note may end with a number.
        ends = numbers(inner[0], [p - at for p in places if p > at])
        ends = ends and numbers(inner[-1], [p for p in places if p < at])
        if ends or any(numbers(text, places) for text in inner[1:-1]):
            message = "a cell in quotation marks has rows of numbers in it"
            help_ = "is a quotation mark not closed? Take it out, or write it twice: those rows would be lost"
            raise _wrong(message, shown, line, help_)


def _places(
    cells: list[str], line: int, shown: str, columns: AnyMapping[str, Column], delimiter: str
) -> tuple[list[int], bool]:
    """Where the columns stand, and whether this line is a header."""
    counted = {type(column.name) is int for column in columns.values()}
    if len(counted) > 1:
        help_ = "name all columns, or count all of them, from 1, where the file has no header"
        raise TrackmarshalError(
            "D170", "some columns are named and some are counted", file=shown, line=line, help=help_
        )
    if counted == {True}:
        places = [int(column.name) - 1 for column in columns.values()]
        if max(places) >= len(cells):
            message = f"there is no column {max(places) + 1}: the first line has {len(cells)} cells"
            raise TrackmarshalError(
                "D170", message, file=shown, line=line, help=f"is `{delimiter}` what divides them?"
            )
        return places, False
    names = [_plain(cell) for cell in cells]
    if names:
        names[0] = names[0].removeprefix("#").strip()
    result = []
    for meaning, column in columns.items():
        wanted = _plain(str(column.name))
        count = names.count(wanted)
        if count != 1:
            message = f"the header has {'no' if count == 0 else 'more than one'} column `{wanted:.60}`, which is to be `{meaning}`"
            listed = ", ".join(f"`{name:.40}`" for name in islice(names, 12))
            help_ = f"{suggestion(wanted, names)} the header has {listed}".strip()
            other = next((name for name, sign in _DELIMITERS.items() if sign in names[0]), None)
            if len(names) == 1 and other is not None:
                help_ = (
                    f"is `{other}` what divides the columns? The mapping says so with `delimiter: '{other}'`"
                )
            if count > 1:
                help_ = "give each a name of its own in the header"
            raise TrackmarshalError("D170", message, file=shown, line=line, help=help_)
        result.append(names.index(wanted))
    return result, True


def _plain(name: str) -> str:
    return unicodedata.normalize("NFC", name).strip()


def _number(cells: list[str], place: int, shown: str, line: int) -> float:
    cell = cells[place].strip()
    value = _finite(cell)
    if math.isnan(value):
        # `from` and `to` of the mapping are no way out: noise is that of the whole file
        help_ = "take the row out of the file, or mend it; a missing number is not guessed"
        if _GROUPED.fullmatch(cell):
            help_ = f"numbers have no sign between thousands: `{re.sub(_SIGNS, '', cell)}`"
            if cell.count(",") == 1 and "." not in cell:  # who writes so may mean either
                help_ += f"; and a point before decimals: `{cell.replace(',', '.')}`"
        elif _COMMA.fullmatch(cell):
            help_ = f"numbers have a point: `{cell.replace(',', '.')}`"
        raise _wrong(f"column {place + 1}: {cell!r:.40} is no finite number", shown, line, help_)
    return value


def _finite(cell: str) -> float:
    """The number in a cell; NaN for what is none, and for one that is not finite."""
    try:
        # Python's own `1_000` is nothing that a log means
        value = float(cell) if len(cell) <= _LONGEST and "_" not in cell else math.nan
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def _wrong(message: str, shown: str, line: int, help: str) -> TrackmarshalError:
    return TrackmarshalError("D171", message, file=shown, line=line, help=help)
