"""What a project demands, and what shows it, as the baseline holds it: entries by kind and name, each a table of texts and lists."""

from __future__ import annotations

import hashlib
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import TypeAlias

from trackmarshal.records.tests import ExternalTest
from trackmarshal.trace import sections
from trackmarshal.trace.files import Hashes, among, naming
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph import schema
from trackmarshal.trace.graph.conditions import in_si
from trackmarshal.trace.graph.graph import Graph
from trackmarshal.trace.graph.reviewed import unreviewed
from trackmarshal.trace.model import Project, TestReport
from trackmarshal.trace.outside import Outside
from trackmarshal.trace.spec import Spec

#: A field's value: a text, or texts in order, each once.
Value: TypeAlias = str | list[str]
Entry: TypeAlias = dict[str, Value]
#: The kind of the entries that say that nobody has reviewed something (`unreviewed requirement RR-1`).
UNREVIEWED = "unreviewed"
#: By kind and name (`requirement RR-1`), what it is.
Content: TypeAlias = dict[str, Entry]
#: Stands for what a scenario is replayed with where nobody knows it: its specs have errors, or the recording is not there.
UNKNOWN = ["?"]
#: And where no configuration gives it any: earlier baselines say nothing then.
_OWN_VALUES = ["the values of its specs"]
#: What the name of a field ends with that says what another one comes to, however that is written: in place of it, it is compared where both contents have it.
WORKED_OUT = ", worked out"
#: What entries of tests of other runners begin with, and what their names may end with.
_EXTERNAL = "external-tests "
#: The field of a section that holds its heading.
HEADING = "heading"
#: Those of them that name the requirement no more.
UNMARKED = "no longer naming it"
#: How many of them were not skipped, in any of their parameters.
RAN = "not skipped"
#: What the names of fields end with that say how many tests of a kind each rule has.
_A_RULE = " tests a rule"
#: A function as pytest and JUnit call it, with its parameters behind it, in which brackets need not match.
_FUNCTION = re.compile(r"([\w:.]+)\[.*\]", re.DOTALL)
#: Of evidence, which methods it answers of which requirements.
ANSWERS = "answers"
#: Kinds of entries of which the title is what they are about: who somebody is, which program it is, what is counted, what goes wrong, what is done, by what rules cite.
_NAMED = ("person", "tool", "indicator", "malfunction", "method", "work")
#: Entries that may be in several pieces; of others of one name the first counts, and the second is an error (T130).
_TOGETHER = ("gate ", "evidence ")


def counted(kind: str, field: str) -> bool:
    """Whether a field of entries of a kind holds a number."""
    return field in ("number", RAN) if kind == "external-tests" else field.endswith(_A_RULE)


def content(project: Project, spec: Spec, hashes: Hashes, graph: Graph, outside: Outside) -> Content:
    """All of it as it is now, in an order of its own; of reports of other runners that could not be read, nothing (`carried`)."""
    found: Content = {}
    for key, entry in (
        *_documents(project, hashes),
        *_v_model(project, spec, hashes),
        *_specs(spec, hashes),
        *_external(project, outside),
        *_reviews(project, graph),
    ):
        said = {name: value for name, value in entry.items() if value}
        if key in found and key.startswith(_TOGETHER):
            found[key] = _both(found[key], said)
        found.setdefault(key, said)
    return dict(sorted(found.items()))


def carried(before: Content, now: Content, there: Mapping[str, frozenset[str]]) -> Content:
    """What there is now, with what was accepted where nobody knows what there is: of reports of other runners that were not read, such as in a fresh checkout, and of what scenarios are replayed with where they are not.

    there: `reported`. A test that a requirement had, and that is still in its report, was not renamed: it names the requirement no more.
    """
    now = {
        key: _known(entry, before.get(key, {})) if UNKNOWN in entry.values() else entry
        for key, entry in now.items()
    }
    now |= {
        key: {**entry, UNMARKED: left}
        for key, entry in now.items()
        if key.startswith(_EXTERNAL)
        and (left := _unmarked(before.get(key, {}), entry, there.get(_report(key))))
    }
    read = {_report(key) for key in now if key.startswith(_EXTERNAL)}
    kept = {
        key: entry
        for key, entry in before.items()
        if key.startswith(_EXTERNAL) and _report(key) not in read and _report(key) in now
    }
    return dict(sorted({**now, **kept}.items())) if kept else now


def _known(entry: Entry, before: Entry) -> Entry:
    """An entry with what was accepted in place of what nobody knows; nothing where nothing was."""
    said = {name: before.get(name, "") if value == UNKNOWN else value for name, value in entry.items()}
    return {name: value for name, value in said.items() if value}


def _report(key: str) -> str:
    """The entry of the report that tests of another runner are in."""
    return f"report {key.partition(' in ')[2]}"


def _unmarked(before: Entry, now: Entry, there: frozenset[str] | None) -> list[str]:
    """The tests that named a requirement when it was accepted, and do not any more though they are there."""
    known = {name for field in ("tests", UNMARKED) for name in before.get(field, ())}
    return sorted((known - {*now.get("tests", ())}) & (there or frozenset()))


def reported(project: Project, outside: Outside) -> dict[str, frozenset[str]]:
    """By report of another runner all tests in it, whatever they name."""
    return {
        f"report {report.path} at {report.stage}": frozenset(map(_called, _in(report, outside)))
        for report in project.junit
    }


def _in(report: TestReport, outside: Outside) -> Iterator[ExternalTest]:
    """The tests of a report, or of the reports in a folder."""
    for test, stage, _ in outside.tests:
        if stage == report.stage and among(test.report, report.path):
            yield test


def _called(test: ExternalTest) -> str:
    """A test without its parameters."""
    return f"{test.suite}: {_unparametrized(test.name)}"


def _unparametrized(name: str) -> str:
    """A name without the brackets that it ends in; of a sentence, which may begin with others, such as `[R-1] stops [wet]`, the last ones alone."""
    function = _FUNCTION.fullmatch(name)
    if function or not name.endswith("]"):
        return function[1] if function else name
    depth = 0
    for place in range(len(name) - 1, 0, -1):
        depth += (name[place] == "]") - (name[place] == "[")
        if depth == 0:
            return name[:place]
    return name


def _external(project: Project, outside: Outside) -> Iterator[tuple[str, Entry]]:
    """The tests of other runners that show something of a requirement, by the report that they are in, and how many: tests get other names, and are parametrized otherwise."""
    for report in project.junit:
        named: dict[str, set[str]] = defaultdict(set)
        skipped: dict[str, set[str]] = defaultdict(set)
        for test in _in(report, outside):
            for id_ in test.requirements:
                named[id_].add(_called(test))
                if test.outcome == "skipped":
                    skipped[id_].add(_called(test))
        for id_, tests in named.items():
            if id_ in project.by_id and project.by_id[id_].demanded:
                yield (
                    f"{_EXTERNAL}{id_} in {report.path} at {report.stage}",
                    {"number": str(len(tests)), RAN: str(len(tests - skipped[id_])), "tests": sorted(tests)},
                )


def _both(one: Entry, other: Entry) -> Entry:
    """What two entries of one name ask for together, such as two demands on a stage, so that the loss of either is noticed."""
    return other | {
        name: _list([*value, *more])
        if isinstance(value, list) and isinstance(more := other.get(name, []), list)
        else value
        for name, value in one.items()
    }


def _reviews(project: Project, graph: Graph) -> Iterator[tuple[str, Entry]]:
    """The closed list of what no person has reviewed: each by the kind and the name that its own entry would have."""
    for kind, id_ in unreviewed(graph, schema.of(project).reviewed or ()):
        yield f"{UNREVIEWED} {kind.replace(' ', '-')} {id_}", {}


def _documents(project: Project, hashes: Hashes) -> Iterator[tuple[str, Entry]]:
    for r in project.requirements:
        yield f"requirement {r.id}", {
            "statement": _hash(r.statement), "asil": str(r.asil), "status": r.status, "derived_from": _list(r.derived_from),
            "refines": _list(r.refines), "verification": _list(r.verification), "metrics": _list(r.metrics),
            "assumptions": _list(r.assumptions), **_linked(r.links), "not_verified_by": _list(name for name, _ in r.not_verified_by),
            "source": " ".join(r.source.split()), "adopted": _hash(r.adopted) if r.adopted else "", **{f"reason against {name}": _hash(why) for name, why in r.not_verified_by},
        }  # fmt: skip
    for entry in project.entries:
        said = {name: _hash(text) if " " in text else text for name, text in entry.attributes.items()}
        said |= {
            f"{name}{WORKED_OUT}": worked
            for name, text in entry.attributes.items()
            if (worked := in_si(text))
        }
        if entry.kind in _NAMED:
            said["title"] = entry.title
        versions = [f"{of} {fingerprint}" for of, fingerprint in entry.versions]
        yield f"{entry.kind.replace(' ', '-')} {entry.id}", {
            **said, **_linked(entry.links), "of versions": _list(versions),
            # Of a design element, each section about a requirement is held by itself; tests that notice faults of tools change with every fault that is added.
            "evidence sha256": "" if entry.kind in ("design element", "malfunction") else "".join(hashes.get(path) or "" for kind, path in entry.links if kind == "backed_by"),
        }  # fmt: skip
    for part in project.subsystems:
        yield f"subsystem {part.id}", {
            "title": part.title, "description": _hash(part.description), "role": part.role,
        }  # fmt: skip
    for pair in project.infeasible:
        yield f"infeasible {pair.between}", {"reason": _hash(pair.reason)}
    if project.schema is not None:
        own = project.schema
        yield "link-schema", {
            "says": _hash(repr(_said((own.needs, own.permitted)))),
            "methods": "" if own.methods is None else _hash(repr(_said(own.methods))),
            "reviewed": "" if own.reviewed is None else _hash(repr(_said(own.reviewed))),
        }  # fmt: skip
    if project.argument is not None:
        made = project.argument
        yield "argument", {"templates": _hash(repr(_said((made.top, made.groups, made.templates))))}
        for d in made.defeaters:
            evidence = "yes" if d.evidence else "no"
            said = {"challenges": str(d.challenges), "state": d.state, "owner": d.owner, "evidence": evidence}
            yield (
                f"defeater {d.id}",
                {**said, "text": _hash(d.text), "answer": _hash(d.answer) if d.answer else ""},
            )
        for id_, at, to, text in made.confidence:
            yield f"confidence {id_}", {"at": str(at), "to": str(to), "text": _hash(text)}
    for i in project.interfaces:
        flows = [f"{flow.kind}, {flow.initiator}: {' '.join(flow.what.split())}" for flow in i.flows]
        yield f"interface {i.id}", {
            "leads_to": _list(i.leads_to), "flows": _list(flows), "rationale": _hash(i.rationale) if i.rationale else "",
        }  # fmt: skip
        for issue in i.issues:
            yield f"issue {issue.id}", {"text": _hash(issue.text), "leads_to": _list(issue.leads_to)}


def _held(path: str | None, hashes: Hashes) -> str:
    """The contents of a file or folder, or how it is called where it is none of the project."""
    return "" if path is None else hashes.get(str(path)) or str(path)


def _v_model(project: Project, spec: Spec, hashes: Hashes) -> Iterator[tuple[str, Entry]]:
    yield (
        "project",
        {
            "specs": _list(project.specs),
            "default_spec": project.default_spec,
            "campaigns": _list(project.campaigns),
            "sources": _list(project.sources),
            "denials": _list(project.denials),
            "boundary_distance": _list(project.boundary_distance),
            # What the safety case prints of all this, in which words, and what it shows of runs in a closed loop.
            "case templates": _held(project.case_templates, hashes),
            "case words": _held(project.case_words, hashes),
            "closed loop": _held(project.closed_loop, hashes),
            **{f"{side}{_A_RULE}": str(number) for side, number in project.tests_per_rule},
        },
    )
    for report in project.junit:
        yield f"report {report.path} at {report.stage}", {
            "tool": report.tool, "names": str(report.names), "may be missing": "yes" if report.if_there else "",
            "methods": _list(report.methods),
        }  # fmt: skip
    for stage in project.stages:
        once = "yes" if stage.if_any else ""
        yield f"stage {stage.id}", {
            "applies_to": _list(stage.applies_to), "counts": _list(stage.counts), "only if there is any": once,
            "shows": _hash(stage.shows),
        }  # fmt: skip
    for demand in project.gate:
        yield f"gate {demand.stage}, {demand.at_least}", {"requirements": _list(demand.requirements)}
    replayed = {part.name: part.shown.split("\n") for part in spec.parts if part.kind == "replay"}
    for campaign in project.campaigns:
        if campaign in replayed:
            yield f"campaign {campaign}", {"replayed with": _list(replayed[campaign])}
    for s in project.scenarios:
        yield f"scenario {s.path}", {
            "stage": str(s.stage), "expect": s.expect, "origin": s.origin, "by": _list(s.by), "requirements": _list(s.requirements),
            "with": _list(s.specs), "named": spec.run_inputs[str(s.path)].get("named", "") if str(s.path) in spec.run_inputs else UNKNOWN, "recording": hashes.get(s.path) or "", "replayed with": _list(replayed.get(str(s.path), _OWN_VALUES)) if str(s.path) in spec.run_inputs else UNKNOWN, "kept run": hashes.get(str(s.kept)) or "" if s.kept else "",
            "rules": _judging(spec.run_inputs[str(s.path)]) if str(s.path) in spec.run_inputs else UNKNOWN,
        }  # fmt: skip
    for e in project.evidence:
        yield (
            f"evidence {e.path} at {e.stage}",
            {
                "requirements": _list(e.requirements),
                "sha256": hashes.get(e.path) or "",
                "methods": _list(e.methods),
                # Entries of one page may answer different methods.
                ANSWERS: _list(f"{r}: {method}" for r in e.requirements for method in e.methods),
                "unnamed": sorted(
                    {*map(str, e.requirements)} & {*(hashes.get(naming(e.path)) or "").split()}
                ),
            },
        )
    for _, element, path, requirement in sections.allocated(project):
        yield f"section {sections.key(path, requirement)}", {
            "of": str(element.id), "contents": hashes.get(sections.key(path, requirement)) or "",
            HEADING: hashes.get(sections.heading(path, requirement)) or "",
        }  # fmt: skip
    for w in project.waivers:
        yield f"waiver {w.id}", {
            "stages": _list(w.stages), "requirements": _list(w.requirements), "codes": _list(w.codes), "subjects": _list(w.subjects),
            "justification": _hash(w.justification), "residual_risk": _hash(w.residual_risk) if w.residual_risk else "",
            "owner": w.owner, "approver": str(w.approver), "granted": w.granted.isoformat() if w.granted else "",
            "expires": w.expires.isoformat() if w.expires else "",
        }  # fmt: skip


def _judging(inputs: Mapping[str, str]) -> list[str]:
    """The rules that are asked in a run, of what that is made from."""
    return sorted(name.removeprefix("rule ") for name in inputs if name.startswith("rule "))


def _specs(spec: Spec, hashes: Hashes) -> Iterator[tuple[str, Entry]]:
    for name, item in spec.by_name.items():
        yield f"{'rule' if item.kind == 'rule' else 'assumption'} {name}", {
            "satisfies": _list(ref.id for ref in item.satisfies), "assuming": _list(ref.id for ref in item.assuming),
            "severity": item.severity, "source": " ".join(item.source.split()), "owner": item.owner, "evidence": item.evidence,
            "evidence sha256": hashes.get(item.evidence) or "" if item.evidence else "",
            "meaning": item.inputs.get(f"rule {name}") or item.fingerprint, "reads": _list(set(item.inputs) - {f"rule {name}", "constraints"}),
        }  # fmt: skip
    for test in spec.tests:
        yield (
            f"test {test.rule}: {test.title}",
            {
                "expects": test.expects,
                "boundary": "yes" if test.boundary else "",
                "text": test.text or test.fingerprint,
                f"text{WORKED_OUT}": test.meant,
            },
        )
    for part in spec.parts:
        if part.kind == "replay":
            continue  # it stands with its scenario or campaign
        yield f"{part.kind} {part.name}", {
            "says": part.fingerprint, "shown": part.shown, f"says{WORKED_OUT}": part.meant, "source": " ".join(part.source.split()),
        }  # fmt: skip
    for case in spec.faults:
        yield (
            f"fault {case.campaign} {case.id}",
            {
                "requirement": case.requirement,
                "not put in": _hash(case.open) if case.open else "",
                "put in": "" if case.open else case.says,
            },
        )


def _linked(links: Iterable[tuple[str, str]]) -> dict[str, Value]:
    """Targets by kind of link."""
    found: dict[str, list[str]] = defaultdict(list)
    for kind, target in links:
        found[f"link {kind}"].append(target)
    return {kind: _list(targets) for kind, targets in found.items()}


def _said(value: object) -> object:
    """What a record says, without where it stands."""
    if isinstance(value, Place):
        return None
    if is_dataclass(value):
        return [_said(getattr(value, field.name)) for field in fields(value)]
    return [_said(one) for one in value] if isinstance(value, tuple) else str(value)


def _list(texts: Iterable[str]) -> list[str]:
    return sorted({str(text) for text in texts})


def _hash(text: str) -> str:
    """Of a text, however its lines are broken."""
    return hashlib.sha256(" ".join(text.split()).encode()).hexdigest()


#: The entry of an argument that is made of the program's templates, and says of what it holds nothing that other entries do not.
PLAIN_ARGUMENT: Entry = {"templates": _hash(repr(_said(("", "", ()))))}
