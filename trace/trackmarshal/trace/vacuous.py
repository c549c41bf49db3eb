"""Rules and monitors that are green because nothing was held against them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from trackmarshal.records import RunSummary
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.model import Project, Scenario
from trackmarshal.trace.spec import Spec, item_place


def check(project: Project, spec: Spec) -> Iterator[Finding]:
    """T229 for what never applied in any run, T249 for monitors that watched defaults."""
    declared = {str(scenario.path): scenario for scenario in project.scenarios}
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
    yield from _by_default(runs, declared, spec)


def _by_default(runs: Sequence[tuple[str, RunSummary]], declared: Mapping[str, Scenario], spec: Spec) -> Iterator[Finding]:
    for name, item in spec.by_name.items():
        found = [(path, run.defaulted[name]) for path, run in runs if name in run.defaulted]
        if found:
            shown = ", ".join(f"`{field}`" for field in sorted({field for _, fields in found for field in fields}))
            number = "1 run" if len(found) == 1 else f"{len(found)} runs"
            message = f"`{name}` watched the default of {shown} in {number}, whose recording does not give it"
            help_ = "let recordings give it, and strike the default: what is watched is said by somebody"
            also = tuple((declared[path].path.place, f"`{path}`") for path, _ in found)
            yield Finding("T249", "warning", message, item_place(item), help_, name, also, tuple(path for path, _ in found))


__all__ = ["check"]
