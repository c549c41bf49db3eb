"""Distances of which only the sign is used, as in a guard: for these a point off the box of a region is outside, and that is all."""

from __future__ import annotations

import re

from trackmarshal.backends.c.statements import Block

_DISTANCE = re.compile(r"const double (d\d+) = tm_in_area\((.*)\);")


def signs_alone(root: Block) -> None:
    """Ask for the sign alone wherever, what nothing reads being removed, nothing else is read."""
    statements = list(root.statements())
    for statement in statements:
        match = _DISTANCE.fullmatch(statement.text)
        if match is None:
            continue
        name = match.group(1)
        sign = re.compile(rf"suspect \|= tm_wild\({name}\);|const bool s\d+ = {name} >= 0\.0;")
        readers = [other.text for other in statements if name in other.uses]
        if readers and all(sign.fullmatch(text) for text in readers):
            statement.text = f"const double {name} = tm_in_area_sign({match.group(2)});"
