"""Units as they are printed: factors with exponents and the signs between them."""

from __future__ import annotations

import re
from typing import NamedTuple

_RAISED = {"²": "2", "³": "3"}


class Factor(NamedTuple):
    """One factor: the sign before it ("": the first), its name, and its exponent ("": none)."""

    sign: str
    name: str
    exponent: str


def factors(unit: str) -> list[Factor]:
    """`m/s^2` as m and /s with the exponent 2."""
    made, sign = [], ""
    for part in re.findall(r"[*·/]|[^*·/]+", unit):
        if part in "*·/":
            sign = "/" if part == "/" else "·"
            continue
        name, _, exponent = part.partition("^")
        if name[-1] in _RAISED:
            name, exponent = name[:-1], _RAISED[name[-1]]
        made.append(Factor(sign, name, exponent))
    return made
