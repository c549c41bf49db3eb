"""Links between requirements, rules, tests and results: each with its state, each loose end a finding."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from trackmarshal.records import SpecItem
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.model import Project, Requirement, matches
from trackmarshal.trace.spec import Spec, item_place

#: covers: both ends stand. orphaned: there is no such target. outdated: made from an older text of its target.
#: unwanted: the target asks for nothing of the kind. ambiguous: more than one thing has the target's name.
STATES = ("covers", "orphaned", "outdated", "unwanted", "ambiguous")


class Link(NamedTuple):
    """A link from what is below to what it answers for."""

    kind: str  #: "derived_from", "refines", "satisfies", "assuming", "tests", "result"
    source: str
    target: str
    state: str
    place: Place


def links(project: Project, spec: Spec) -> tuple[Link, ...]:
    """All links, in order."""
    return tuple(sorted({*_of_requirements(project), *_of_items(project, spec), *_of_tests(spec)}))


def _of_requirements(project: Project) -> Iterator[Link]:
    interfaces = {str(i.id): i for i in project.interfaces}
    for requirement in project.requirements:
        for source in requirement.derived_from:
            interface = interfaces.get(source)
            state = (
                "orphaned"
                if interface is None
                else "covers"
                if requirement.id in interface.leads_to
                else "unwanted"
            )
            yield Link("derived_from", str(requirement.id), str(source), state, source.place)
        for parent in requirement.refines:
            yield Link(
                "refines", str(requirement.id), str(parent), _state(project.by_id.get(parent)), parent.place
            )


def _state(requirement: Requirement | None) -> str:
    return "orphaned" if requirement is None else "covers" if requirement.demanded else "unwanted"


def _of_items(project: Project, spec: Spec) -> Iterator[Link]:
    for item in spec.items:
        twice = spec.by_name[item.name] is not item
        for ref in item.satisfies:
            state = "ambiguous" if twice else _state(project.by_id.get(ref.id))
            yield Link("satisfies", item.name, ref.id, state, Place(item.file, ref.line, ref.column))
        for ref in item.assuming:
            target = spec.by_name.get(ref.id)
            state = "orphaned" if target is None else "covers" if target.kind == "assume" else "unwanted"
            yield Link("assuming", item.name, ref.id, state, Place(item.file, ref.line, ref.column))


def _of_tests(spec: Spec) -> Iterator[Link]:
    for test in spec.tests:
        state = "covers" if test.rule in spec.by_name else "orphaned"
        yield Link("tests", f"{test.rule}: {test.title}", test.rule, state, item_place(test))
    known = {(test.rule, test.title) for test in spec.tests}
    for key, result in spec.results.items():
        state = "orphaned" if key not in known else "outdated" if spec.staleness(result) else "covers"
        yield Link(
            "result", result.outcome, f"{result.rule}: {result.title}", state, Place(result.file, result.line)
        )


def check(project: Project, spec: Spec) -> Iterator[Finding]:
    """Loose ends between requirements and specs (T201 to T210, T219)."""
    first: dict[str, SpecItem] = {}
    for item in spec.items:
        if item.name in first:
            also = ((item_place(first[item.name]), "declared here first"),)
            message = f"`{item.name}` is declared twice; which of the two counts is open"
            yield Finding("T209", "error", message, item_place(item), "rename one of them", item.name, also)
        first.setdefault(item.name, item)
        yield from _item(item, project, spec)
    asks_for_rules = tuple(p for stage in project.stages if "rule" in stage.counts for p in stage.applies_to)
    parents = {str(p) for r in project.requirements if r.demanded for p in r.refines}
    for requirement in project.requirements:
        if requirement.demanded:
            yield from _requirement(
                requirement, project, spec, requirement.id in parents, matches(requirement.id, asks_for_rules)
            )


def _item(item: SpecItem, project: Project, spec: Spec) -> Iterator[Finding]:
    said = f"the {'rule' if item.kind == 'rule' else 'assumption'} `{item.name}`"
    if not item.satisfies:
        help_ = "say which requirement it satisfies: `satisfies S-1-A-2`"
        yield error("T202", f"{said} satisfies no requirement", item_place(item), help_, item.name)
    seen: set[str] = set()
    for ref in item.satisfies:
        place = Place(item.file, ref.line, ref.column)
        target = project.by_id.get(ref.id)
        if ref.id in seen:
            yield error("T210", f"{said} satisfies `{ref.id}` twice", place, "name it once", item.name)
        elif target is None:
            help_ = did_you_mean(ref.id, project.by_id)
            yield error(
                "T201", f"{said} satisfies `{ref.id}`, which is no requirement", place, help_, item.name
            )
        elif not target.demanded:
            help_ = "drop the link, or the rule"
            yield error(
                "T203", f"{said} satisfies `{ref.id}`, which is demanded no longer", place, help_, item.name
            )
        seen.add(ref.id)
    for ref in item.assuming:
        assumed = spec.by_name.get(ref.id)
        if assumed is None or assumed.kind != "assume":
            help_ = did_you_mean(ref.id, (i.name for i in spec.items if i.kind == "assume"))
            place = Place(item.file, ref.line, ref.column)
            yield error(
                "T204", f"{said} relies on `{ref.id}`, which is no assumption", place, help_, item.name
            )
    if item.kind == "assume":
        lacks = [
            name
            for name, there in (
                ("owner", item.owner),
                ("monitor", item.monitored),
                ("evidence", item.evidence),
            )
            if not there
        ]
        if lacks:
            message = f"{said} has no {' and no '.join(lacks)}"
            help_ = "an assumption is somebody's, is watched while driving, and is backed by a record"
            yield error("T208", message, item_place(item), help_, item.name)


def _requirement(
    requirement: Requirement, project: Project, spec: Spec, is_parent: bool, asked: bool
) -> Iterator[Finding]:
    name = requirement.id
    for field, kind, said in (("metrics", "rule", "rule"), ("assumptions", "assume", "assumption")):
        listed = requirement.metrics if field == "metrics" else requirement.assumptions
        for wanted in listed:
            item = spec.by_name.get(wanted)
            if item is None or item.kind != kind:
                of_kind = [i.name for i in spec.items if i.kind == kind]
                help_ = did_you_mean(wanted, of_kind) or f"restore the {said}, or strike it from `{field}`"
                yield error(
                    "T205",
                    f"`{name}` names `{wanted}` under `{field}`, but there is no such {said}",
                    wanted.place,
                    help_,
                    wanted,
                )
            elif all(ref.id != name for ref in item.satisfies):
                also = ((item_place(item), f"`{wanted}` is here"),)
                message = (
                    f"`{name}` names `{wanted}` under `{field}`, but `{wanted}` does not satisfy `{name}`"
                )
                yield Finding(
                    "T206", "error", message, wanted.place, f"add `satisfies {name}` to it", str(wanted), also
                )
    if asked and not is_parent and name not in spec.by_requirement:
        help_ = f"write a rule with `satisfies {name}`"
        yield error("T207", f"`{name}` has no rule and no assumption", requirement.place, help_, name)
    items = spec.by_requirement.get(name, [])
    if requirement.asil not in ("", "QM") and items and all(item.severity == "advisory" for item in items):
        said = "an advisory rule" if len(items) == 1 else "advisory rules"
        message = f"`{name}` has ASIL {requirement.asil}, and is covered by {said} alone"
        help_ = f"give `{items[0].name}` another severity, or write a rule that decides"
        also = tuple((item_place(item), f"`{item.name}` is advisory") for item in items)
        yield Finding("T219", "error", message, requirement.place, help_, str(name), also)


__all__ = ["STATES", "Link", "check", "links"]
