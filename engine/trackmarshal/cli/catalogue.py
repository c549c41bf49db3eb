"""All error codes of all rooms, for `explain` and for SARIF."""

from __future__ import annotations

from importlib import import_module

#: Modules whose diagnostics or CODES belong to the catalogue.
_SOURCES = (
    "trackmarshal.source", "trackmarshal.store", "trackmarshal.syntax.errors", "trackmarshal.testing.errors", "trackmarshal.configuration", "trackmarshal.evaluation",
    "trackmarshal.semantics.errors.names", "trackmarshal.semantics.errors.expressions", "trackmarshal.semantics.errors.declarations", "trackmarshal.semantics.errors.rules",
    "trackmarshal.semantics.warnings.numbers", "trackmarshal.semantics.warnings.formulas", "trackmarshal.semantics.warnings.vacuity",
    "trackmarshal.cli.project", "trackmarshal.cli.places", "trackmarshal.cli.evaluate", "trackmarshal.cli.replay", "trackmarshal.cli.import_log",
    "trackmarshal.cli.explain", "trackmarshal.cli.revisions", "trackmarshal.cli.bench", "trackmarshal.testing.builders", "trackmarshal.testing.boundary",
    "trackmarshal.runtime.codes", "trackmarshal.rulebooks.candidates", "trackmarshal.scenarios.codes", "trackmarshal.start.codes", "trackmarshal.lanes.codes",
    "trackmarshal.trajectories.codes", "trackmarshal.integration.planner", "trackmarshal.backends.reference.temporal", "trackmarshal.backends.c.codes",
    "trackmarshal.trace.codes", "trackmarshal.trace.graph.paths", "trackmarshal.trace.report.codes", "trackmarshal.trace.exchange.codes", "trackmarshal.cli.giving",
    "trackmarshal.cli.days", "trackmarshal.trace.impact.codes", "trackmarshal.reading.formulas", "trackmarshal.reading.solving", "trackmarshal.reading.drawing.drawn", "trackmarshal.cli.drawing", "trackmarshal.trace.gsn.codes", "trackmarshal.trace.case.codes",
    "trackmarshal.cli.acceptances", "trackmarshal.cli.against",
)  # fmt: skip


def catalogue() -> dict[str, tuple[str, str]]:
    """Code -> (title, explanation), sorted by code; raises on a code that two rooms claim."""
    from trackmarshal.diagnostics.base import Diagnostic

    found: dict[str, tuple[str, str]] = {}
    for name in _SOURCES:
        module = import_module(name)
        own: dict[str, tuple[str, str]] = dict(getattr(module, "CODES", {}))
        for item in vars(module).values():
            if (
                isinstance(item, type)
                and issubclass(item, Diagnostic)
                and item.code
                and item.__module__ == name
            ):
                entry = (item.title, item.explanation)
                if own.setdefault(item.code, entry) != entry:
                    raise AssertionError(f"code {item.code} is claimed twice in {name}")
        for code, entry in own.items():
            if found.setdefault(code, entry) != entry:
                raise AssertionError(f"code {code} is claimed twice")
    return dict(sorted(found.items()))
