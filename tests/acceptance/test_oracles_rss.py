"""Safe distances of a reference RSS library through `eval`, by both evaluators, with the shipped rules."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from support import rss
from support.command import BACKENDS, evaluate, number
from support.shared import SUPERVISOR, oracle

pytestmark = pytest.mark.verifies("S-1-A-2")

#: How many cases of each kind the library accepted.
ACCEPTED = {"longitudinal_same_direction": 395, "longitudinal_opposite_direction": 198, "lateral": 404}
#: The library calls a gap longer than the safe distance only if it is so by more than this, in m.
PRECISION = 1e-3


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kind", rss.RULES)
def test_distances(kind: str, backend: str, tmp_path: Path) -> None:
    """margin = gap - safe distance, to 2 mm; the verdict is the library's but for its comparison's tolerance."""
    content = oracle("rss_dev.json")
    tolerance = content["tolerance"]["abs"]
    cases: list[dict[str, Any]] = [c for c in content["cases"] if c["kind"] == kind and c["accepted"]]
    assert len(cases) == ACCEPTED[kind]
    rule = rss.RULES[kind]
    lines = evaluate(tmp_path, SUPERVISOR, [rss.data(case) for case in cases], [rule], backend)
    wrong = []
    for case, line in zip(cases, lines, strict=True):
        found = line["rules"][rule]
        margin = number(found["margin"])
        fits = abs(case["inputs"]["distance"] - margin - case["safe_distance"]) <= tolerance
        fits = fits and found["verdict"] == ("satisfied" if margin > 0.0 else "violated")
        if case["check_accepted"]:
            fits = fits and case["is_safe"] == (margin > PRECISION)
        if not fits:
            wrong.append((case, found))
    assert not wrong
