"""The parameters and tables in force in a run, as rows of a table."""

from __future__ import annotations

from typing import Any

from trackmarshal.trace.report.reading import Run
from trackmarshal.trace.report.words import listed, spoken_unit
from trackmarshal.units import about


def setting_rows(run: Run) -> dict[str, list[dict[str, str]]]:
    """By the module that declares them: name, value with its unit, with all of its digits where that has not, where that is from, and which
    rules read it. Replaced ones say so."""
    groups: dict[str, list[dict[str, str]]] = {}
    for entry in run.record.get("in_force", ()):
        module, _, short = entry["name"].rpartition(".")
        groups.setdefault(module, []).append(
            {
                "name": short, "value": spoken_unit(_short(entry)), "exact": "" if _short(entry) == entry["written"] else spoken_unit(entry["written"]), "source": entry["source"] or "no source is given",
                "span": "" if entry["own"] else entry["span"], "replaced": _replaced(entry), "rules": _rules(entry["rules"]),
            }
        )  # fmt: skip
    return groups


def _short(entry: dict[str, Any]) -> str:
    """A number as sentences have it; what stands for a table is none."""
    written: str = entry["written"]
    return about(written) if entry["kind"] == "param" else written


def _replaced(entry: dict[str, Any]) -> str:
    """By whom a value was put in the place of the spec's own; empty where it is that."""
    if entry["own"]:
        return f"the recording's, in place of {spoken_unit(about(entry['own']) if entry['kind'] == 'param' else entry['own'])} ({entry['span']})"
    return f"from the configuration {entry['module']}, in place of the spec's own" if entry["module"] else ""


def _rules(names: list[str]) -> str:
    return listed(names) if len(names) <= 4 else f"{', '.join(names[:4])} and {len(names) - 4} more"
