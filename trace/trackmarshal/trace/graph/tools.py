"""Confidence in tools: that the level follows from the classes, and that what a fault of each could do is described."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.trace.findings import Finding, error
from trackmarshal.trace.graph.graph import Graph, Node
from trackmarshal.trace.graph.said import called


def by_table_3(impact: str, detection: str) -> str:
    """The tool confidence level by ISO 26262-8, table 3; "" where the detection is not given and counts. Raises ValueError for other classes."""
    if impact not in ("TI1", "TI2") or detection not in ("", "TD1", "TD2", "TD3"):
        raise ValueError(f"{impact!r} and {detection!r} are no classes of tools")
    if impact == "TI1":
        return "TCL1"
    return f"TCL{detection[2:]}" if detection else ""


def check(graph: Graph) -> Iterator[Finding]:
    """T176 and T177."""
    for tool in graph.by_kind.get("tool", ()):
        yield from _level(tool)
        described = any(link.kind == "malfunction_of" for link in graph.into(tool.key))
        if tool.attributes.get("impact") == "TI2" and not described:
            message = f"a fault of {called(tool.key)} could do harm, and no malfunction of it is described"
            yield error(
                "T177", message, tool.place, "describe what it could do, under `malfunctions`", tool.id
            )


def _level(tool: Node) -> Iterator[Finding]:
    said = tool.attributes
    level, impact, detection = (said.get(name, "") for name in ("confidence", "impact", "detection"))
    if not impact:
        return  # nothing is argued; what is claimed is shown as it stands
    due = by_table_3(impact, detection)
    if not due:
        message = f"{called(tool.key)} has the impact {impact}, and no error detection is given"
        yield error("T176", message, tool.place, "add `detection`: TD1, TD2 or TD3", tool.id)
    elif level != due:
        make = "TI1 makes" if impact == "TI1" else f"{impact} and {detection} make"
        has = f"the confidence level {level}" if level else "no confidence level"
        message = f"{called(tool.key)} has {has}; {make} it {due}"
        yield error("T176", message, tool.place, f"write `confidence: {due}`, or classify it anew", tool.id)


__all__ = ["by_table_3", "check"]
