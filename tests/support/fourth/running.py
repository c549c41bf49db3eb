"""What the engine says of a spec of `writing`'s, and where it is not what `meaning` says."""

from __future__ import annotations

import math
from typing import Any

from support.fourth.meaning import Clause, Formula, Judged
from support.fourth.writing import Writer


def scales(writer: Writer, clauses: list[Clause], require: Formula) -> dict[Any, float]:
    """Margins are divided where several dimensions meet, of which one has a scale."""
    met = require.dims
    used = {writer.scales.get(d, 1.0) for d in met if d is not None}
    several = len({d for d in met if d is not None}) > 1
    return dict(writer.scales) if several and used != {1.0} else {}


def agree(ours: Judged, verdict: str, margin: float, exact: bool) -> bool:
    close = math.isclose(ours.margin, margin, rel_tol=1e-9, abs_tol=1e-9) or (
        math.isnan(ours.margin) and math.isnan(margin)
    )
    if verdict == ours.verdict:
        return close
    return not exact and abs(ours.margin) < 1e-9 and abs(margin) < 1e-9
