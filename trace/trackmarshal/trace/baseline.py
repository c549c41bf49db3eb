"""The baseline: what was accepted last, so that a removal is noticed even where nothing else refers to what was removed.

It is a file beside the requirements, written by `accept` only. Additions need no acceptance: they are notes.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from trackmarshal.files import read_regular
from trackmarshal.records import FaultCase, SpecItem, SpecTest
from trackmarshal.trace.findings import Finding, Place, error, warning
from trackmarshal.trace.model import Project, Requirement
from trackmarshal.trace.spec import Spec, item_place

FORMAT = "trackmarshal-baseline"
VERSION = 1
MAX_BYTES = 16_000_000
_ACCEPT = "restore it, or accept the change with `trackmarshal trace --accept-baseline`"

Baseline = dict[str, Any]


def snapshot(
    project: Project, items: Sequence[SpecItem], tests: Sequence[SpecTest], faults: Sequence[FaultCase] = ()
) -> Baseline:
    """What there is now, as a baseline holds it."""
    spec = Spec(items, tests, (), ())
    return {
        "format": FORMAT,
        "version": VERSION,
        "requirements": {
            str(r.id): {
                "statement": _hash(r),
                "derived_from": sorted(r.derived_from),
                "refines": sorted(r.refines),
            }
            for r in sorted(project.requirements, key=lambda r: r.id)
        },
        "interfaces": {
            str(i.id): {"leads_to": sorted(i.leads_to)}
            for i in sorted(project.interfaces, key=lambda i: i.id)
        },
        "items": {
            name: {
                "kind": item.kind,
                "satisfies": sorted({ref.id for ref in item.satisfies}),
                "tests": sorted(test.title for test in spec.tests_of.get(name, ())),
            }
            for name, item in sorted(spec.by_name.items())
        },
        "scenarios": sorted(str(s.path) for s in project.scenarios),
        **({"faults": _faults(faults)} if faults else {}),
    }


def _faults(cases: Sequence[FaultCase]) -> dict[str, str]:
    """By campaign and id, the requirement that a fault is evidence for; apart, where it is not put in."""
    return {
        f"{case.campaign} {case.id}": f"open {case.requirement}" if case.open else case.requirement
        for case in sorted(cases, key=lambda case: (case.campaign, case.id))
    }


def accept(
    root: Path,
    project: Project,
    items: Sequence[SpecItem],
    tests: Sequence[SpecTest],
    faults: Sequence[FaultCase] = (),
) -> Path:
    """Write the baseline of a project anew, whole or not at all; returns its path."""
    path = root / (project.baseline or "requirements/baseline.json")
    text = json.dumps(snapshot(project, items, tests, faults), indent=1, ensure_ascii=False) + "\n"
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    draft.write_text(text, encoding="utf-8")
    draft.replace(path)
    return path


def load(root: Path, project: Project, found: list[Finding]) -> Baseline | None:
    """The accepted baseline, or None when the project has none; one that cannot be read is a finding (T220)."""
    if project.baseline is None:
        return None
    place = Place(str(project.baseline))
    try:
        path = root / project.baseline
        if path.stat().st_size > MAX_BYTES:
            raise ValueError(f"larger than {MAX_BYTES // 1_000_000} MB")
        data = json.loads(read_regular(path).decode("utf-8"))
        return _checked(data)
    except FileNotFoundError:
        message = "the project names a baseline, but there is none"
        found.append(
            error(
                "T220",
                message,
                project.baseline.place,
                "accept one with `trackmarshal trace --accept-baseline`",
            )
        )
    except (OSError, ValueError, RecursionError) as problem:
        said = problem.strerror if isinstance(problem, OSError) else str(problem) or type(problem).__name__
        found.append(
            error("T220", f"the baseline cannot be read: {said}", place, "restore it from version control")
        )
    return None


def _checked(data: object) -> Baseline:
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError(f"its format is not `{FORMAT}`")
    if data.get("version") != VERSION:
        raise ValueError(f"its version is not {VERSION}")
    fits = (
        isinstance(data.get("scenarios"), list)
        and all(isinstance(path, str) for path in data["scenarios"])
        and _fits(data.get("requirements"), ("derived_from", "refines"), ("statement",))
        and _fits(data.get("interfaces"), ("leads_to",), ())
        and _fits(data.get("items"), ("satisfies", "tests"), ("kind",))
        and isinstance(faults := data.get("faults", {}), dict)
        and all(isinstance(requirement, str) for requirement in faults.values())
    )
    if not fits:
        raise ValueError("it is not what `--accept-baseline` writes")
    return data


def _fits(table: object, lists: Sequence[str], texts: Sequence[str]) -> bool:
    return isinstance(table, dict) and all(
        isinstance(entry, dict)
        and all(isinstance(entry.get(name), str) for name in texts)
        and all(
            isinstance(entry.get(name), list) and all(isinstance(i, str) for i in entry[name])
            for name in lists
        )
        for entry in table.values()
    )


def check(baseline: Baseline | None, project: Project, spec: Spec) -> Iterator[Finding]:
    """What is gone, or reads differently, since the baseline was accepted (T221 to T228, T265)."""
    if baseline is None:
        return
    place = Place(str(project.baseline))
    for name, entry in baseline["requirements"].items():
        requirement = project.by_id.get(name)
        if requirement is None:
            yield error("T223", f"the requirement `{name}` is gone since the baseline", place, _ACCEPT, name)
            continue
        for field, now in (("derived_from", requirement.derived_from), ("refines", requirement.refines)):
            gone = sorted(set(entry[field]) - set(now))
            if gone:
                message = f"`{name}` had {_list(gone)} under `{field}` when the baseline was accepted"
                yield error("T224", message, requirement.place, _ACCEPT, name)
        if requirement.statement and entry["statement"] != _hash(requirement):
            rules = [item.name for item in spec.by_requirement.get(name, ())]
            review = (
                f"review {_list(rules)} against it, then accept it"
                if rules
                else "review what depends on it, then accept it"
            )
            message = (
                f"the statement of `{name}` has changed since the baseline: what was made from it is suspect"
            )
            yield warning("T225", message, requirement.statement.place, review, name)
    interfaces = {str(i.id): i for i in project.interfaces}
    for name, entry in baseline["interfaces"].items():
        interface = interfaces.get(name)
        if interface is None:
            yield error("T224", f"the interface `{name}` is gone since the baseline", place, _ACCEPT, name)
        elif set(entry["leads_to"]) - set(interface.leads_to):
            gone = sorted(set(entry["leads_to"]) - set(interface.leads_to))
            message = f"the interface `{name}` led to {_list(gone)} when the baseline was accepted"
            yield error("T224", message, interface.id.place, _ACCEPT, name)
    yield from _items(baseline, spec, place)
    for path in sorted(set(baseline["scenarios"]) - {str(s.path) for s in project.scenarios}):
        yield error("T228", f"the scenario `{path}` is gone since the baseline", place, _ACCEPT, path)
    faults = _faults(spec.faults)
    for name, requirement in baseline.get("faults", {}).items():
        if faults.get(name) not in (requirement, requirement.removeprefix("open ")):
            message = f"the fault `{name}` of `{requirement}` is gone since the baseline, or put in no longer"
            yield error("T265", message, place, _ACCEPT, name)
    yield from _additions(baseline, project, spec, place)


def _items(baseline: Baseline, spec: Spec, place: Place) -> Iterator[Finding]:
    for name, entry in baseline["items"].items():
        item = spec.by_name.get(name)
        if item is None or item.kind != entry["kind"]:
            said = "rule" if entry["kind"] == "rule" else "assumption"
            yield error("T222", f"the {said} `{name}` is gone since the baseline", place, _ACCEPT, name)
            continue
        gone = sorted(set(entry["satisfies"]) - {ref.id for ref in item.satisfies})
        if gone:
            message = f"`{name}` satisfied {_list(gone)} when the baseline was accepted"
            yield error("T227", message, item_place(item), _ACCEPT, name)
        have = Counter(test.title for test in spec.tests_of.get(name, ()))
        for title in sorted((Counter(entry["tests"]) - have).elements()):
            message = f'the test "{title}" of `{name}` is gone since the baseline'
            yield error("T221", message, item_place(item), _ACCEPT, name)


def _additions(baseline: Baseline, project: Project, spec: Spec, place: Place) -> Iterator[Finding]:
    known = Counter((name, title) for name, entry in baseline["items"].items() for title in entry["tests"])
    tests = Counter((test.rule, test.title) for test in spec.tests if test.rule in spec.by_name) - known
    added = {
        "requirement": len(set(project.by_id) - set(baseline["requirements"])),
        "rule": sum(
            item.kind == "rule" and name not in baseline["items"] for name, item in spec.by_name.items()
        ),
        "assumption": sum(
            item.kind == "assume" and name not in baseline["items"] for name, item in spec.by_name.items()
        ),
        "test": sum(tests.values()),
        "fault": len(set(_faults(spec.faults)) - set(baseline.get("faults", {}))),
    }
    said = [f"{number} {what}{'' if number == 1 else 's'}" for what, number in added.items() if number]
    if said:
        message = (
            f"new since the baseline: {', '.join(said)}; until that is accepted, a removal goes unnoticed"
        )
        help_ = "accept them with `trackmarshal trace --accept-baseline`"
        yield Finding("T226", "note", message, place, help_)


def _list(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _hash(requirement: Requirement) -> str:
    return hashlib.sha256(" ".join(requirement.statement.split()).encode()).hexdigest()
