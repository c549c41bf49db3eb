"""Operating conditions that are claimed, held against what recordings have of them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from trackmarshal.records.runs import RunSummary
from trackmarshal.trace.findings import Finding, error
from trackmarshal.trace.graph.graph import Graph
from trackmarshal.trace.graph.said import called
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec
from trackmarshal.trace.values import Placed
from trackmarshal.units import UNIT_PATTERN, parse_unit, show, to_si, written

#: Two numbers that differ by less than this share of the range are the same: recordings are written with so many digits.
_SAME = 1e-6
_NUMBER = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?")
_UNIT = re.compile(rf"(?:1|{UNIT_PATTERN})(?:[*/·]{UNIT_PATTERN})*")


def check(graph: Graph, project: Project, spec: Spec) -> Iterator[Finding]:
    """T254 for every range of a domain that no recording reaches both ends of; T124 and T127 for what is no range; T130 for a second one of a quantity, of which the baseline and the safety case hold one."""
    declared = {str(scenario.path) for scenario in project.scenarios}
    runs = [run for path, run in sorted(spec.runs.items()) if path in declared]
    # What was not run is told as that; where nothing is to be run, or no settings could be read, nobody else tells it, or that is what is wrong.
    known = bool(runs) or bool(project.stages and not declared)
    for entry in project.entries:
        first: dict[str, Placed] = {}
        for quantity, low, high in entry.ranges:
            before = first.setdefault(str(quantity), quantity)
            if before is not quantity:
                message = f"{called((entry.kind, str(entry.id)))} claims `{quantity}` twice"
                also = ((before.place, "the first time here"),)
                yield Finding(
                    "T130", "error", message, quantity.place, "keep one of the ranges", str(entry.id), also
                )
                continue
            wrong = _wrong(low, high)
            if wrong:
                code, message, help_ = wrong
                said = f"the range of `{quantity}` {message}"
                yield error(code, said, quantity.place, help_, str(entry.id))
                continue
            message = _short(runs, quantity, low, high) if known else ""
            if message:
                node = graph.nodes[entry.kind, str(entry.id)]
                help_ = "record or generate a scenario there, or claim less"
                rests_on = (
                    *sorted(declared),
                    *(f"at {stage.id}" for stage in project.stages if "run" in stage.counts),
                )
                yield Finding(
                    "T254", "error", f"{called(node.key)} claims `{quantity}` from {low} to {high}, {message}", quantity.place, help_, node.id,
                    rests_on=rests_on,
                )  # fmt: skip


def _wrong(low: str, high: str) -> tuple[str, str, str] | None:
    """Code, message and help where two ends make no range."""
    for end in (low, high):
        number, unit = _split(end)
        if not _UNIT.fullmatch(unit):
            return "T124", f"has an end `{end}`, and there is no unit `{unit}`", "such as `12 m/s`"
        if not math.isfinite(to_si(number, unit)):
            return "T124", f"has an end `{end}`, which is beyond all numbers", "claim what can be driven"
    (start, unit), (end_, other_unit) = _split(low), _split(high)
    if parse_unit(unit)[2] != parse_unit(other_unit)[2]:
        return (
            "T127",
            f"is from {low} to {high}, which are not of one dimension",
            "give both ends units of it",
        )
    if to_si(start, unit) > to_si(end_, other_unit):
        return "T127", f"is from {low} to {high}, which is less", "begin with the lower end"
    return None


def _short(runs: list[RunSummary], quantity: str, low: str, high: str) -> str:
    """How far the recordings fall short of a claimed range; empty where they do not."""
    seen = [run.ranges[quantity] for run in runs if quantity in run.ranges]
    if not seen:
        return "and no recording has it"
    least, most = min(one for one, _ in seen), max(other for _, other in seen)
    (start, unit), (end, other_unit) = _split(low), _split(high)
    begin, finish = to_si(start, unit), to_si(end, other_unit)
    slack = _SAME * max(abs(begin), abs(finish), abs(finish - begin))
    if least <= begin + slack and most >= finish - slack:
        return ""
    return (
        f"and the recordings have it from {written(least, '', unit, 6)} to {written(most, '', other_unit, 6)}"
    )


def in_si(text: str) -> str:
    """A quantity, or a range from one `to` another, in SI: `0.5 s` for `500 ms`; empty for what is none."""
    ends = [end.partition(" ") for end in text.split(" to ")]
    if not all(_NUMBER.fullmatch(number) and _UNIT.fullmatch(unit) for number, _, unit in ends):
        return ""
    return " to ".join(
        f"{to_si(float(number), unit)!r} {show(parse_unit(unit)[2])}" for number, _, unit in ends
    )


def _split(text: str) -> tuple[float, str]:
    """Number and unit."""
    number, _, unit = text.partition(" ")
    return float(number), unit or "1"


__all__ = ["check", "in_si"]
