"""Firings of a run as rows of a table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from trackmarshal.trace.report.reading import Rule, Run, number
from trackmarshal.trace.report.words import clock, count, decided_by, interval, measured, told

#: Firings of one rule on one candidate beyond these are summed up in one row.
MOST_FIRINGS = 6


def firing_rows(run: Run) -> Iterator[dict[str, Any]]:
    """A row a firing, in order of time; one for both candidates where all is equal, and one for the rest of a flickering rule."""
    rows: list[tuple[int, dict[str, Any]]] = []
    behind = {(entry["rule"], entry["candidate"]): entry["cycles"] for entry in run.record.get("told", ())}
    for rule in run.rules:
        of_rule: list[tuple[int, dict[str, Any]]] = []
        for candidate, lane in rule.lanes.items():
            for firing in lane.firings[:MOST_FIRINGS]:
                of_rule.append((firing["cycles"][0], _firing(rule, candidate, firing, behind)))
            rest = lane.firings[MOST_FIRINGS:]
            if rest:
                worst = min(rest, key=lambda f: _sortable(number(f["worst"]["margin"])))
                verdicts = dict.fromkeys(verdict for firing in rest for verdict in firing["verdicts"])
                ends = {"from": rest[0]["from"], "to": rest[-1]["to"]}
                row = _firing(rule, candidate, {**worst, **ends, "verdicts": tuple(verdicts)}, behind)
                row["more"] = f"{count(len(rest), 'more stretch', 'more stretches')} inside this interval"
                of_rule.append((rest[0]["cycles"][0], row))
        merged: list[tuple[int, dict[str, Any]]] = []
        for start, row in of_rule:
            twin = next((other for at, other in merged if at == start and _alike(other, row)), None)
            if twin is None:
                merged.append((start, row))
            else:
                twin["candidate"] = f"{twin['candidate']} and {row['candidate']}"
        rows += merged
    yield from (row for _, row in sorted(rows, key=lambda item: item[0]))


def _alike(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    return all(a[name] == b[name] for name in a if name not in ("candidate", "rule"))


def _firing(
    rule: Rule, candidate: str, firing: Mapping[str, Any], behind: Mapping[Any, Any]
) -> dict[str, Any]:
    worst = firing["worst"]
    lines = behind.get((rule.name, candidate), {}).get(str(worst["cycle"]), ())
    return {
        "rule": rule, "candidate": candidate, "interval": interval(number(firing["from"]), number(firing["to"])),
        "verdicts": " and ".join(firing["verdicts"]), "margin": measured(worst), "exact": worst["margin"],
        "t": clock(number(worst["t"])), "by": decided_by(worst), "span": worst["span"], "line": worst["line"], "more": "",
        "told": [told(line) for line in lines],
    }  # fmt: skip


def _sortable(margin: float) -> float:
    return math.inf if math.isnan(margin) else margin
