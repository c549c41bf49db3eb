"""Which warnings there are."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.semantics.warnings import formulas, numbers, vacuity

#: The codes of all.
WARNINGS = frozenset(
    kind.code
    for module in (formulas, numbers, vacuity)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Diagnostic) and kind is not Diagnostic
)
