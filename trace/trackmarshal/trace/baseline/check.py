"""What became weaker since the baseline was accepted, as findings."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping

from trackmarshal.trace import sections
from trackmarshal.trace.baseline.change import Change
from trackmarshal.trace.baseline.changes import Tell, changes
from trackmarshal.trace.baseline.content import UNREVIEWED, Content, Entry
from trackmarshal.trace.baseline.file import Baseline
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.kinds import OBSOLETE
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec, item_place

_HELP = 'restore it, or accept it by name: `trackmarshal trace --accept-baseline --by "NAME" --reason "..."`'
#: Of what was not there.
_NEW_HELP = f"take it away, or {_HELP.partition(', or ')[2]}"
_UNREVIEWED_HELP = f"have it reviewed (`reviews` in a document `assurance`); or {_HELP.partition(', or ')[2]}"
#: Of changes that have one finding, for so many it is told in it whether they are weaker; of all in the places beside it.
_TOLD = 3
#: Of what vehicles and the ground truth of a scenario may be made.
_MADE_OF = ("rule", "assumption", "param", "table", "place", "signal")
#: What the kinds of entries are called.
_CALLED = {
    "param": "parameter", "place": "place", "evidence": "evidence", "gate": "gate", "project": "project's settings", "external-tests": "count of external tests",
    "infeasible": "pair without an interface", "confidence": "confidence point",
}  # fmt: skip
_PLURAL = {
    "evidence": "evidence",
    "analysis": "analyses",
    "count of external tests": "counts of external tests",
    "pair without an interface": "pairs without an interface",
}
#: The codes of what is gone, and of what reads differently; T376 of hazards, goals, design, reviews and their like.
_GONE = {
    "requirement": "T223", "interface": "T224", "infeasible": "T224", "rule": "T222", "assumption": "T222", "test": "T221", "scenario": "T228", "fault": "T265",
    "stage": "T371", "gate": "T371", "project": "T371", "evidence": "T373", "param": "T372", "table": "T372", "place": "T372",
    "signal": "T372", "constraint": "T372", "rulebook": "T372", "limit": "T372", "report": "T373", "section": "T373", "issue": "T224",
    "external-tests": "T221",
}  # fmt: skip
_OTHER = {
    "requirement": "T376", "interface": "T224", "rule": "T370", "assumption": "T370", "test": "T374", "scenario": "T375", "fault": "T265",
    "stage": "T371", "gate": "T371", "project": "T371", "evidence": "T373", "param": "T372", "table": "T372", "place": "T372",
    "signal": "T372", "constraint": "T372", "rulebook": "T372", "limit": "T372", "waiver": "T377", "issue": "T224",
    "infeasible": "T224", "subsystem": "T224", "report": "T373", "section": "T373", UNREVIEWED: "T382", "external-tests": "T221", "campaign": "T265",
}  # fmt: skip
_OF_FIELD = {
    ("requirement", "statement"): "T225", ("requirement", "derived_from"): "T224", ("requirement", "refines"): "T224",
    ("rule", "satisfies"): "T227", ("assumption", "satisfies"): "T227",
    ("assumption", "evidence sha256"): "T373", ("analysis", "evidence sha256"): "T373", ("review", "evidence sha256"): "T373",
    ("analysis", "link examines"): "T373",
    ("rule", "source"): "T376", ("assumption", "source"): "T376", ("param", "source"): "T376",
}  # fmt: skip


def check(
    baseline: Baseline | None, now: Content, project: Project, spec: Spec, tell: Tell | None = None
) -> Iterator[Finding]:
    """What is gone, or less, or reads differently since the baseline was accepted; a note of what is new (T221 to T228, T265, T370 to T377).

    tell: whether a rule got weaker or stronger, where that is known.
    """
    if baseline is None:
        return
    places = _places(project, spec)
    here = Place(str(project.baseline))
    found = list(changes(baseline.content, now, tell))
    lost = {change.name: change.key for change in found if not change.field and change.before}
    listed = any(key.startswith(f"{UNREVIEWED} ") for key in baseline.content)
    # A limit that no spec declares any more has its default.
    struck = {change.key for change in found if change.kind == "limit" and change.key not in places}
    for code, group in _grouped((change for change in found if change.weaker), listed, struck):
        at = [places.get(change.key.removeprefix(f"{UNREVIEWED} "), here) for change in group]
        also = tuple((place, str(change)) for place, change in zip(at[1:], group[1:]))
        # Without a subject it would be about the settings, as which specs are read, of which may come that others are gone.
        name = group[0].key if group[0].kind == "gate" and not group[0].name else group[0].name
        if group[0].kind in ("test", UNREVIEWED):
            name = name.partition(": ")[0] if group[0].kind == "test" else name.partition(" ")[2]
        message = (
            _said(group[0])
            if len(group) == 1
            else f"{_said(group[0])}; so it is with {len(group) - 1} other{'s' if len(group) > 2 else ''}"
        )
        told = [
            f"`{change.name}`: {change.told}" if len(group) > 1 else change.told
            for change in group
            if change.told
        ]
        message = "; ".join(
            [message, *told[:_TOLD], *([f"and {len(told) - _TOLD} more"] if len(told) > _TOLD else [])]
        )
        about = dict.fromkeys(
            word for change in group for word in _names(change, baseline.content.get(change.key, {}))
        )
        about |= {
            name: None
            for change in group
            if change.name in lost
            for name in _linked(baseline.content.get(change.key, {})) & lost.keys()
        }
        gone = all(
            (not change.field and bool(change.before)) or change.after == OBSOLETE or change.key in struck
            for change in group
        )
        rests_on = tuple(
            dict.fromkeys(name for change in group for name in _around(baseline.content, change))
        )
        new = all(not change.field and not change.before for change in group)
        help_ = _UNREVIEWED_HELP if code == "T382" else _NEW_HELP if new else _HELP
        yield Finding(code, "error", message, at[0], help_, name, also, tuple(about), rests_on, gone)
    yield from _others([change for change in found if not change.weaker], now, here)


def _names(change: Change, before: Entry) -> Iterator[str]:
    """What a change is about: the entry, of tests also the rule, of what shows something also the stage and what it shows that of, and of lists what left or came."""
    yield change.name
    first, _, last = change.name.partition(
        {"test": ": ", "gate": ", ", "evidence": " at ", "report": " at "}.get(change.kind, "\0")
    )
    yield first
    stage = before.get("stage", "") or (
        last if change.kind in ("evidence", "report") else first if change.kind in ("gate", "stage") else ""
    )
    if stage:
        yield f"at {stage}"
    if change.kind == UNREVIEWED:
        yield change.name.partition(" ")[2]
    if change.kind == "person":  # as owners are named
        yield str(before.get("title", ""))
    if change.kind == "fault":
        yield from change.name.rsplit(" ", 1)
    if change.kind == "external-tests":
        id_, _, report = change.name.partition(" in ")
        yield id_
        yield from report.rsplit(" at ", 1)[:1]
    if change.kind == "limit":  # as a rule that reads it calls it
        yield f"supervisor.limits.{change.name}"
    if change.kind == "rulebook":
        yield from re.findall(r"[\w-]+", f"{change.before} {change.after}")
    if change.listed:
        yield from re.findall("`([^`]*)`", f"{change.before} {change.after}")
    if change.kind == "section":
        yield change.name.rpartition("#")[2]
    if change.kind in ("evidence", "fault", "review", "analysis"):  # what it was evidence of lacks it
        for field in ("requirements", "requirement", "link reviews", "link examines"):
            value = before.get(field, ())
            yield from [value] if isinstance(value, str) else value


def _linked(entry: Entry) -> set[str]:
    """The things that an entry names."""
    return {name for value in entry.values() if isinstance(value, list) for name in value}


def _around(before: Content, change: Change) -> Iterator[str]:
    """Of a parameter, a table, a place or a signal, the rules and assumptions that read it; of files that a scenario names, the rules and what they read, by which its vehicles and its ground truth may be made; of a rule that is gone, what it read; of what is not reviewed, the reviews that were about it."""
    for key, entry in before.items():
        if change.key in entry.get("reads", ()):
            yield key.partition(" ")[2]
        if change.kind == UNREVIEWED and change.name.partition(" ")[2] in entry.get("link reviews", ()):
            yield key.partition(" ")[2]
    if (change.kind, change.field) == ("scenario", "named"):
        yield from (key.partition(" ")[2] for key in before if key.partition(" ")[0] in _MADE_OF)
    if not change.field:
        yield from (name.partition(" ")[2] for name in before.get(change.key, {}).get("reads", ()))


def _grouped(
    found: Iterable[Change], listed: bool, struck: Container[str]
) -> Iterator[tuple[str, list[Change]]]:
    """Changes by code, those together that one edit makes: of a shared definition, of what tests are given, of a hazard that levels follow.

    listed: the baseline lists things that nobody reviewed. Where it lists none, all that are so now are told as one: nobody has been asked so far.
    struck: the limits of the Supervisor that no spec declares any more.
    """
    groups: dict[tuple[str, str], list[Change]] = defaultdict(list)
    for change in found:
        code = _code(change)
        one = "" if code == "T370" and change.field == "meaning" else change.key
        if change.kind == "external-tests":  # one test may be of several requirements
            one = change.name.partition(" in ")[2]
        elif code in ("T374", "T221"):
            one = change.name.partition(": ")[0]
        elif change.kind == "issue":
            one = f"interface {change.name.rpartition('.')[0]}"
        elif change.field == "asil":
            one = "asil"
        elif (change.kind, change.field) == ("subsystem", "role"):  # exactly one is the vehicle
            one = "role"
        elif change.key in struck:
            one = "limit"
        elif change.field in ("replayed with", "rules"):  # of a configuration, or a spec, that several share
            one = f"{change.before} {change.after}"
        elif (change.kind == "gate" and not change.field) or (change.kind == UNREVIEWED and not listed):
            one = change.kind
        groups[code, one].append(change)
    for (code, _), group in groups.items():
        yield code, group


def _code(change: Change) -> str:
    if not change.field:
        return (_GONE if change.before else _OTHER).get(change.kind, "T376")
    return _OF_FIELD.get((change.kind, change.field)) or _OTHER.get(change.kind, "T376")


def _said(change: Change) -> str:
    kind = _CALLED.get(change.kind, change.kind)
    name = f"the {kind.replace('-', ' ')}" + (f" `{change.name}`" if change.name else "")
    if change.kind == "test":
        rule, _, title = change.name.partition(": ")
        name = f'the test "{title}" of `{rule}`'
    if change.kind == UNREVIEWED:
        what, _, id_ = change.name.partition(" ")
        return f"nobody has reviewed the {what.replace('-', ' ')} `{id_}` as it is now, and the baseline does not list it as unreviewed"
    if not change.field:
        return f"{name} is gone since the baseline" if change.before else f"{name} is new since the baseline"
    if not change.what and not change.before:
        return f"{name} says something else than when the baseline was accepted"
    if change.listed:
        fewer, more = change.before, change.after
        had = f"had {fewer} under `{change.field}` when the baseline was accepted"
        has = f"has {more} under `{change.field}`, and had not when the baseline was accepted"
        if fewer and more:
            return f"{name} {had}, and now has {more}"
        return f"{name} {had if fewer else has}"
    what = change.what if change.what not in ("", change.field) else f"`{change.field}`"
    of = "" if change.field == "says" else f"the {what} of "
    if not (change.before or change.after):
        return f"{of}{name} changed since the baseline was accepted"
    return f"{of}{name} was {change.before or 'nothing'} when the baseline was accepted, and is {change.after or 'nothing'}"


def _others(found: list[Change], now: Content, place: Place) -> Iterator[Finding]:
    """One note of all that is new, or more than before."""
    new = Counter(
        _CALLED.get(change.kind, change.kind.replace("-", " "))
        for change in found
        if not change.field and change.after
    )
    said = [
        f"{number} {kind if number == 1 else _PLURAL.get(kind, f'{kind}s')}"
        for kind, number in sorted(new.items())
    ]
    off = [
        f"`{change.name.partition(' ')[2]}`"
        for change in found
        if change.kind == UNREVIEWED and change.name in now
    ]
    more = [
        str(change) for change in found if (change.field or not change.after) and change.kind != UNREVIEWED
    ]
    parts = [f"new since the baseline: {', '.join(said)}"] if said else []
    parts += (
        [
            f"no less than before: {'; '.join(more[:3])}"
            + (f"; and {len(more) - 3} more" if len(more) > 3 else "")
        ]
        if more
        else []
    )
    if off:
        left = f" and {len(off) - 3} more" if len(off) > 3 else ""
        parts.append(f"off the list of what nobody has reviewed: {', '.join(off[:3])}{left}")
    if parts:
        message = f"{'; '.join(parts)}; until that is accepted, its removal goes unnoticed"
        yield Finding("T226", "note", message, place, "accept it with `trackmarshal trace --accept-baseline`")


def _places(project: Project, spec: Spec) -> Mapping[str, Place]:
    """Where each entry stands now."""
    found: dict[str, Place] = {}
    found |= {f"requirement {r.id}": r.place for r in project.requirements}
    found |= {f"interface {i.id}": i.id.place for i in project.interfaces}
    found |= {f"subsystem {part.id}": part.id.place for part in project.subsystems}
    found |= {f"issue {issue.id}": issue.id.place for i in project.interfaces for issue in i.issues}
    found |= {f"stage {stage.id}": stage.id.place for stage in project.stages}
    found |= {f"gate {d.stage}, {d.at_least}": d.stage.place for d in project.gate}
    if project.gate:
        found["gate"] = project.gate[0].stage.place
    found |= {f"scenario {s.path}": s.path.place for s in project.scenarios}
    found |= {f"campaign {path}": path.place for path in project.campaigns}
    found |= {f"evidence {e.path} at {e.stage}": e.path.place for e in project.evidence}
    found |= {f"report {report.path} at {report.stage}": report.path.place for report in project.junit}
    for id_ in project.by_id:
        found |= {f"external-tests {id_} in {r.path} at {r.stage}": r.path.place for r in project.junit}
    found |= {f"waiver {w.id}": w.id.place for w in project.waivers}
    found |= {f"section {sections.key(path, r)}": at.place for at, _, path, r in sections.allocated(project)}
    for item in spec.by_name.values():
        found[f"{'rule' if item.kind == 'rule' else 'assumption'} {item.name}"] = item_place(item)
    found |= {f"test {test.rule}: {test.title}": item_place(test) for test in spec.tests}
    found |= {
        f"{part.kind} {part.name}": Place(part.file, part.line, part.column)
        for part in spec.parts
        if part.file
    }
    found |= {f"fault {case.campaign} {case.id}": Place(case.campaign, case.line) for case in spec.faults}
    found |= {f"{entry.kind.replace(' ', '-')} {entry.id}": entry.id.place for entry in project.entries}
    if project.argument is not None:
        found |= {f"defeater {d.id}": d.id.place for d in project.argument.defeaters}
        found |= {f"confidence {id_}": id_.place for id_, *_ in project.argument.confidence}
    if project.place:
        found["project"] = project.place
    return found
