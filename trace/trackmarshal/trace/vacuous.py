"""Rules and monitors that are green because nothing was held against them."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.trace.findings import Finding
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec, item_place


def check(project: Project, spec: Spec) -> Iterator[Finding]:
    """T229 for what was evaluated in runs, and never applied."""
    declared = {str(scenario.path) for scenario in project.scenarios}
    runs = [(path, run) for path, run in sorted(spec.runs.items()) if path in declared]
    for name, item in spec.by_name.items():
        facts = [(path, spec.facts(run)[name]) for path, run in runs if name in spec.facts(run)]
        paths = tuple(path for path, _ in facts)
        if facts and not any(fact.number("satisfied", "violated", "undefined", "open") for _, fact in facts):
            said = "the rule" if item.kind == "rule" else "the monitor of"
            number = "the one run" if len(facts) == 1 else f"any of {len(facts)} runs"
            message = f"{said} `{name}` did not apply in any cycle of {number} that it was evaluated in"
            help_ = "record or generate a scenario in which it applies"
            yield Finding("T229", "warning", message, item_place(item), help_, name, rests_on=paths)


__all__ = ["check"]
