"""Small bars of coverage: how many demands of a stage have which status."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal.trace.report.svg.element import svg, tag, title

#: Statuses of the matrix in the order of the bar, as pages name them; `other` is what no status is given for.
STATUSES = {
    "covered": "covered", "waived": "waived", "partial": "partial", "stale": "stale", "failed": "failed", "missing": "missing",
    "other": "not covered",
}  # fmt: skip


def coverage_bar(stage: str, counts: Mapping[str, int], of: int) -> str:
    """One bar; every status has a texture of its own, and the numbers stand beside it in words."""
    width, height = 240.0, 14.0
    parts = [tag("rect", x=0.5, y=0.5, width=width - 1, height=height - 1, class_="b-frame")]
    x = 0.0
    for status, amount in counts.items():
        if amount and of:
            share = width * amount / of
            parts.append(
                tag(
                    "rect",
                    title(f"{amount} {STATUSES[status]}"),
                    x=x,
                    y=0.0,
                    width=share,
                    height=height,
                    class_=f"c-{status}",
                )
            )
            x += share
    spoken = (
        ", ".join(f"{amount} {STATUSES[status]}" for status, amount in counts.items() if amount)
        or "nothing demanded"
    )
    return svg(width, height, f"Coverage of {stage}", spoken, parts, class_="bar")
