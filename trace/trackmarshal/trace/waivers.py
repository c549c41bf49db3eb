"""Waivers as records: each is approved by somebody else than its owner, lasts a year at most, and says which gap it is about."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from datetime import date, timedelta

from trackmarshal.trace.findings import Finding, error
from trackmarshal.trace.gates import WAIVABLE
from trackmarshal.trace.model import Project, Requirement, Waiver, matches
from trackmarshal.trace.spec import Spec
from trackmarshal.trace.values import Placed

#: Kinds of items of specs and of entries, what they are called, and by which codes they may be the subjects of a waiver.
_SUBJECTS = (
    ("rule", "rule", frozenset({"T211", "T212"})),
    ("assume", "assumption", frozenset({"T208", "T211", "T212", "T252", "T253"})),
    ("operational design domain", "operational design domain", frozenset({"T254"})),
    ("analysis", "analysis", frozenset({"T253"})),
    ("review", "review", frozenset({"T253"})),
)


def check(project: Project, spec: Spec) -> Iterator[Finding]:
    """What is wrong with who approved a waiver, how long it holds, and how much it excuses (T234 to T236)."""
    persons = {plain(e.title): plain(e.id) for e in reversed(project.entries) if e.kind == "person"}
    for waiver in project.waivers:
        name = str(waiver.id)
        if waiver.approver and _one(waiver.approver, persons) == _one(waiver.owner, persons):
            message = f"the waiver `{name}` is approved by `{waiver.approver}`, who owns it"
            help_ = "have it approved by another role than the one that answers for the gap"
            yield error("T234", message, waiver.approver.place, help_, name)
        # A day that cannot be read was reported.
        if waiver.granted is not None and waiver.expires is not None:
            last = a_year_after(waiver.granted)
            if waiver.expires > last:
                message = f"the waiver `{name}` holds from {waiver.granted} until {waiver.expires}, more than a year"
                help_ = f"let it expire on {last} at the latest, and look at the gap again then"
                yield error("T235", message, waiver.id.place, help_, name)
        yield from _blanket(waiver, project, spec)


def a_year_after(day: date) -> date:
    """The same day a year later; the 28th for the 29th of February, the last day that there is where years end."""
    if day.year == date.max.year:
        return date.max
    try:
        return day.replace(year=day.year + 1)
    except ValueError:
        return (day - timedelta(days=1)).replace(year=day.year + 1)


def _one(who: str, persons: dict[str, str]) -> str:
    """Who somebody is: the id of a declared person, or else the name however it is written."""
    return persons.get(plain(who), plain(who))


def plain(name: str) -> str:
    """A name or an id, whatever its capitals and spaces, however its letters are written, and without what nobody sees of it."""
    letters = (c for c in unicodedata.normalize("NFKC", str(name)) if unicodedata.category(c) != "Cf")
    return " ".join("".join(letters).split()).casefold()


def _blanket(waiver: Waiver, project: Project, spec: Spec) -> Iterator[Finding]:
    """T236 for a waiver of everything: whoever grants one has looked at no gap in particular."""
    demanded = [r for r in project.by_id.values() if r.demanded]
    wild = [pattern for pattern in (*waiver.requirements, *waiver.subjects) if "*" in pattern]
    stages = {str(stage.id) for stage in project.stages}
    found: list[tuple[Placed, str]] = []
    for pattern in (*waiver.requirements, *waiver.subjects):
        id_, _, method = pattern.rpartition(":")
        if not pattern.strip("*:"):
            found.append((pattern, f"`{pattern}`, which is everything"))
        elif id_ and not id_.strip("*"):
            found.append((pattern, f"`{pattern}`, which is {method} of every requirement"))
    if wild and not found and len(demanded) > 1 and all(_excused(r, wild) for r in demanded):
        found.append((wild[0], "every requirement of the project"))
    fitting = [pattern for pattern in waiver.subjects if "*" in pattern]
    for called, codes, names in _subjects(project, spec, demanded):
        if (
            codes.intersection(waiver.codes)
            and len(names) > 1
            and all(matches(name, fitting) for name in names)
        ):
            found.append((fitting[0], f"every {called}"))
    if len(stages) > 1 and stages <= set(waiver.stages):
        found.append((waiver.stages[0], "every stage"))
    if set(waiver.codes) >= WAIVABLE:
        found.append((waiver.codes[0], "every code that can be waived"))
    if found:
        place, what = found[0]
        message = f"the waiver `{waiver.id}` is for {what}"
        yield error("T236", message, place.place, "name the gaps that somebody has looked at", str(waiver.id))


def _subjects(
    project: Project, spec: Spec, demanded: Sequence[Requirement]
) -> Iterator[tuple[str, frozenset[str], list[str]]]:
    """What there is of one kind: what it is called, the codes by which it may be the subject of a waiver, and how findings name it."""
    for kind, called, codes in _SUBJECTS:
        names = [item.name for item in spec.by_name.values() if item.kind == kind]
        yield called, codes, [*names, *(str(entry.id) for entry in project.entries if entry.kind == kind)]
    for word in dict.fromkeys(word for r in demanded for word in r.verification):
        names = [f"{r.id}:{word}" for r in demanded if word in r.verification]
        yield f"{word} that a requirement names", frozenset({"T255"}), names


def _excused(requirement: Requirement, patterns: Sequence[str]) -> bool:
    """Whether patterns fit a requirement, or each method that it names as T255 says it."""
    methods = [f"{requirement.id}:{word}" for word in requirement.verification]
    return matches(requirement.id, patterns) or (
        bool(methods) and all(matches(method, patterns) for method in methods)
    )


__all__ = ["a_year_after", "check", "plain"]
