"""The documents of a project held against each other: ids, references, derivation, integrity levels."""

from __future__ import annotations

import posixpath
from collections.abc import Iterable, Iterator, Mapping, Sequence

from trackmarshal.trace import wording
from trackmarshal.trace.files import Hashes
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error, warning
from trackmarshal.trace.model import Interface, Project, matches
from trackmarshal.trace.values import Placed
from trackmarshal.trace.waivers import plain

_ALIKE = str.maketrans({"O": "0", "I": "1", "L": "1", "S": "5", "B": "8", "Z": "2"})
_NOWHERE = Place("")


def check(project: Project) -> Iterator[Finding]:
    """Everything that can be said without a spec (T130 to T149)."""
    named = [("requirement", r.id) for r in project.requirements]
    yield from _named_uniquely([*named, *((entry.kind, entry.id) for entry in project.entries)])
    yield from _unique("interface", (i.id for i in project.interfaces))
    yield from _unique("issue", (issue.id for i in project.interfaces for issue in i.issues))
    yield from _unique("subsystem", (s.id for s in project.subsystems))
    yield from _unique("stage", (s.id for s in project.stages))
    yield from _unique("waiver", (w.id for w in project.waivers))
    if project.argument is not None:
        yield from _unique("defeater", (defeater.id for defeater in project.argument.defeaters))
        yield from _unique("confidence point", (id_ for id_, *_ in project.argument.confidence))
    yield from _twice("scenario", (s.path for s in project.scenarios))
    yield from _persons(project)
    yield from _twice("campaign", project.campaigns)
    yield from _twice("report", (j.path for j in project.junit), [j.stage for j in project.junit])
    if project.modelled is not None:
        yield from _model(project)
    for requirement in project.requirements:
        yield from wording.check(requirement)
    yield from _v_model(project)


def _twice(what: str, paths: Iterable[Placed], stages: Sequence[str] = ()) -> Iterator[Finding]:
    """Files, of which none may be named twice (at one stage, where there are stages): the second would say something else of it unseen."""
    first: dict[tuple[str, str], Placed] = {}
    for number, path in enumerate(paths):
        stage = stages[number] if stages else ""
        before = first.setdefault((posixpath.normpath(path), stage), path)
        if what != "report" and before != path:
            continue  # one file under two paths is told by what is in it
        if before is not path:
            message = f"the {what} `{path}` is named twice" + f" at `{stage}`" * bool(stage)
            also = ((before.place, "first named here"),)
            help_ = "keep one of the entries"
            yield Finding("T130", "error", message, path.place, help_, str(path), also, (str(before),))


def _persons(project: Project) -> Iterator[Finding]:
    """Persons with one name, however it is written: whoever has two ids could review, or approve, what is his own."""
    first: dict[str, Placed] = {}
    for person in (entry for entry in project.entries if entry.kind == "person"):
        before = first.setdefault(plain(person.title), person.id)
        if before != person.id:
            message = f"the person `{person.id}` has the name of the person `{before}`, {person.title}"
            also = ((before.place, "the other one"),)
            help_ = "strike one of them; where there are two, say which in their names"
            yield Finding("T130", "error", message, person.id.place, help_, str(person.id), also)


def recordings(project: Project, hashes: Hashes) -> Iterator[Finding]:
    """Recordings and campaigns that stand under two paths (T130): one of them could count as from the field, and is no second case; faults would count twice."""
    yield from _copies("scenario", (s.path for s in project.scenarios), hashes)
    yield from _copies("campaign", project.campaigns, hashes)


def _copies(what: str, paths: Iterable[Placed], hashes: Hashes) -> Iterator[Finding]:
    first: dict[str, Placed] = {}
    for path in paths:
        digest = hashes.get(path)
        before = path if digest is None else first.setdefault(digest, path)
        if before != path:
            message = f"the {what} `{path}` is the {what} `{before}` under another path"
            also = ((before.place, "the other one"),)
            help_ = "keep one of the entries"
            yield Finding("T130", "error", message, path.place, help_, str(path), also, (str(before),))


def _unique(what: str, ids: Iterable[Placed]) -> Iterator[Finding]:
    yield from _named_uniquely((what, id_) for id_ in ids)


def _named_uniquely(ids: Iterable[tuple[str, Placed]]) -> Iterator[Finding]:
    """Things, each with what it is, of which no two have one id, or ids that are easily taken for each other."""
    first: dict[str, tuple[str, Placed]] = {}
    alike: dict[str, tuple[str, Placed]] = {}
    for what, id_ in ids:
        if id_ in first:
            other, before = first[id_]
            also = ((before.place, "first given here"),)
            message = (
                f"the {what} `{id_}` is given twice"
                if other == what
                else f"the {what} `{id_}` has the id of the {other} `{id_}`"
            )
            yield Finding("T130", "error", message, id_.place, "give one of them another id", str(id_), also)
            continue
        first[id_] = (what, id_)
        skeleton = id_.upper().translate(_ALIKE)
        if skeleton in alike:
            other, before = alike[skeleton]
            said = f"the {what}s" if other == what else f"the {other} and the {what}"
            message = f"{said} `{before}` and `{id_}` are easily taken for each other"
            also = ((before.place, "the other one"),)
            yield Finding("T131", "error", message, id_.place, "give one of them another id", str(id_), also)
        else:
            alike[skeleton] = (what, id_)


def _model(project: Project) -> Iterator[Finding]:
    """The system model: every pair considered, every interface of the vehicle analysed and leading somewhere."""
    place = project.modelled or _NOWHERE
    vehicles = [s for s in project.subsystems if s.role == "vehicle"]
    if len(vehicles) != 1:
        said = "no subsystem is" if not vehicles else "more than one subsystem is"
        at = vehicles[1].id.place if vehicles else place
        help_ = "give exactly one subsystem the role `vehicle`"
        about = tuple(str(s.id) for s in vehicles or project.subsystems)
        yield Finding("T145", "error", f"{said} the vehicle", at, help_, about=about)
    known = {str(s.id) for s in project.subsystems}
    pairs = (*(i.id for i in project.interfaces), *(i.between for i in project.infeasible))
    for name in pairs:
        for end in name.split("-"):
            if end not in known:
                help_ = did_you_mean(end, known) or "known are " + ", ".join(sorted(known))
                yield error(
                    "T146", f"`{name}` is to join `{end}`, which is no subsystem", name.place, help_, name
                )
    yield from _pairs(project)
    for interface in project.interfaces:
        yield from _interface(interface, project)
    joined = {frozenset(name.split("-")) for name in pairs}
    subsystems = sorted(
        project.subsystems, key=lambda s: s.role != "vehicle"
    )  # so that pairs are named vehicle first
    for number, one in enumerate(subsystems):
        for other in subsystems[number + 1 :]:
            if frozenset((str(one.id), str(other.id))) not in joined:
                message = f"whether `{one.id}` and `{other.id}` meet is not said"
                help_ = f"add the interface `{one.id}-{other.id}`, or say under `infeasible` why they don't"
                yield error("T144", message, other.id.place, help_, f"{one.id}-{other.id}")
    if project.vehicle and not any(i.id == project.vehicle for i in project.interfaces):
        message = f"the properties of `{project.vehicle}` itself are not analysed"
        yield error("T144", message, place, f"add the interface `{project.vehicle}`", project.vehicle)


def _pairs(project: Project) -> Iterator[Finding]:
    """Subsystems of which it is said twice whether they meet (T130): as an interface and as a pair without one, for two reasons, or in both orders."""
    first: dict[tuple[str, ...], Placed] = {}
    called = [("interface", i.id) for i in project.interfaces]
    interfaces = {str(id_) for _, id_ in called}
    for what, pair in (*called, *(("pair without an interface", i.between) for i in project.infeasible)):
        before = first.setdefault(tuple(sorted(pair.split("-"))), pair)
        if before is pair or (
            what == "interface" and before == pair
        ):  # interfaces have ids, which are looked at
            continue
        other = "interface" if str(before) in interfaces else "pair without an interface"
        message = f"the {what} `{pair}` is the {other} `{before}` again"
        also = ((before.place, "first said here"),)
        yield Finding("T130", "error", message, pair.place, "keep one of the entries", str(pair), also)


def _interface(interface: Interface, project: Project) -> Iterator[Finding]:
    name = interface.id
    for flow in interface.flows:
        if flow.initiator != "mutual" and flow.initiator not in interface.ends:
            message = f"`{flow.initiator}` does not belong to the interface `{name}`"
            yield error("T147", message, flow.initiator.place, "one of its ends, or `mutual`", name)
    if not interface.issues:
        if project.vehicle in interface.ends:
            message = f"the interface `{name}` between the vehicle and its environment is not analysed"
            if len(interface.ends) == 1:
                message = f"the properties of the vehicle, `{name}`, are not analysed"
            help_ = (
                "add `issues`: what kind of issue with this interface could pose a risk to safe operation?"
            )
            yield error("T133", message, name.place, help_, name)
        elif not interface.rationale:
            yield error(
                "T133",
                f"why `{name}` is not analysed is not said",
                name.place,
                "add `issues` or a `rationale`",
                name,
            )
    for issue in interface.issues:
        if not issue.id.startswith(f"{name}."):
            yield error(
                "T134",
                f"the issue `{issue.id}` stands under `{name}`",
                issue.id.place,
                f"call it `{name}.1` or the like",
                name,
            )


def _v_model(project: Project) -> Iterator[Finding]:
    stages = {str(stage.id): stage for stage in project.stages}
    named = [
        *(s.stage for s in project.scenarios), *(e.stage for e in project.evidence), *(d.stage for d in project.gate),
        *(j.stage for j in project.junit), *(stage for w in project.waivers for stage in w.stages),
    ]  # fmt: skip
    for stage in named:
        if stage not in stages:
            help_ = did_you_mean(stage, stages) or "known are " + ", ".join(stages)
            yield error("T148", f"there is no stage `{stage}`", stage.place, help_, stage)
    ids = [str(r.id) for r in project.requirements if r.demanded]
    patterns = [
        *(p for s in project.stages for p in s.applies_to), *(p for s in project.scenarios for p in s.requirements),
        *(p for e in project.evidence for p in e.requirements), *(p for d in project.gate for p in d.requirements),
        *(p for w in project.waivers for p in w.requirements),
    ]  # fmt: skip
    for pattern in patterns:
        if not any(matches(id_, (pattern,)) for id_ in ids):
            yield warning(
                "T149", f"`{pattern}` fits no requirement", pattern.place, did_you_mean(pattern, ids), pattern
            )
    for demand in project.gate:
        asked = stages[demand.stage].applies_to if demand.stage in stages else ("*",)
        for pattern in demand.requirements:
            fitting = [id_ for id_ in ids if matches(id_, (pattern,))]
            if fitting and not any(matches(id_, asked) for id_ in fitting):
                message = f"the gate demands `{pattern}` at {demand.stage}, which asks nothing of it"
                help_ = f"add it to `applies_to` of {demand.stage}, or strike the demand"
                yield warning("T149", message, pattern.place, help_, pattern)
    for scenario in project.scenarios:
        if scenario.expect == "fire" and not scenario.by:
            yield error(
                "T127",
                f"`{scenario.path}` is to fire, but `by` does not say which rules",
                scenario.path.place,
                "add `by`",
            )
    for waiver in project.waivers:
        cells, findings = (
            bool(waiver.stages) + bool(waiver.requirements),
            bool(waiver.codes) + bool(waiver.subjects),
        )
        if (cells, findings) not in ((2, 0), (0, 2)):
            message = f"`{waiver.id}` says neither which cells nor which findings it waives"
            help_ = "give `stages` and `requirements`, or `codes` and `subjects`"
            if cells and findings:
                message = f"`{waiver.id}` is to waive cells and findings"
                help_ = (
                    "grant one for `stages` and `requirements`, and another one for `codes` and `subjects`"
                )
            yield error("T127", message, waiver.id.place, help_, waiver.id)


def unasked(project: Project, cells: Mapping[str, Mapping[str, object]]) -> Iterator[Finding]:
    """T149 for what is demanded and has no cell, nor has anything that refines it, at any depth: whatever shows it, or does not, the gate asks nothing of it."""
    asked = {id_ for id_, row in cells.items() if row}
    todo = list(asked)
    while todo:
        above = {up for up in map(str, project.by_id[todo.pop()].refines) if up in cells and up not in asked}
        asked |= above
        todo += above
    for id_ in cells if project.stages else ():  # where there are no stages, that is what is wrong
        if id_ not in asked:
            message = f"no stage asks anything of `{id_}`, nor of what refines it"
            help_ = "add it to `applies_to` of the stages that are to show it, or correct its id"
            yield warning("T149", message, project.by_id[id_].place, help_, id_)
