"""Files of the project that evidence refers to, by their hashes."""

from __future__ import annotations

import hashlib
import json
import posixpath
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from trackmarshal.files import digest
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem
from trackmarshal.trace import sections
from trackmarshal.trace.findings import Finding, Place, error
from trackmarshal.trace.model import Entry, Evidence, Project
from trackmarshal.trace.reading import FOLDER
from trackmarshal.trace.spec import Spec, item_place
from trackmarshal.trace.values import Placed

#: sha256 by path; None where there is no such file, and empty for a document that says nothing.
Hashes = Mapping[str, str | None]


def hashes(root: Path, project: Project, items: Iterable[SpecItem]) -> Hashes:
    """The hashes of all files that evidence, scenarios, campaigns, assumptions and design name, and of sections about requirements."""
    paths = {str(s.path) for s in project.scenarios} | set(map(str, project.campaigns))
    paths |= {str(s.kept) for s in project.scenarios if s.kept}
    paths |= {str(project.closed_loop)} if project.closed_loop else set()
    paths |= {str(project.case_words)} if project.case_words else set()
    documents = {str(e.path) for e in project.evidence} | {str(path) for _, path in _written_down(project)}
    documents |= {item.evidence for item in items if item.evidence}
    found = {path: sha256(root, path) for path in sorted(paths)}
    found |= {path: _document(root, path) for path in sorted(documents)}
    found |= {
        led_out(path): ""
        for path in sorted(paths | documents)
        if found[path] is None and _outside(root, path)
    }
    found |= {demanding(path): "" for path in sorted(documents) if _demands(root, path, project)}
    about: dict[str, set[str]] = {}
    for e in project.evidence:
        about.setdefault(str(e.path), set()).update(map(str, e.requirements))
    found |= {naming(path): _unnamed(root, path, ids) for path, ids in about.items()}
    if project.case_templates:
        found[str(project.case_templates)] = _folder(root, str(project.case_templates))
    return {**found, **sections.hashes(root, project)}


def naming(path: str) -> str:
    """Where, beside hashes, the ids of the requirements stand that evidence at a path is about and does not name."""
    return f"{path}: not named"


def led_out(path: str) -> str:
    """Where, beside hashes, it stands that a path leads by a link to a file out of the project, which is none of it."""
    return f"{path}: out of the project"


def demanding(path: str) -> str:
    """Where, beside hashes, it stands that a document says what is demanded, which shows nothing of it."""
    return f"{path}: what is demanded"


def lacking(path: str, found: Hashes) -> str:
    """What a file that does not count lacks: nobody has to look for one that is there."""
    if led_out(path) in found:
        return "is behind a link that leads out of the project"
    return "is not there" if found.get(path) is None else "says nothing"


def way_out(path: str, found: Hashes) -> str:
    """What to do about a file that does not count."""
    return f"{'put the file itself there' if led_out(path) in found else 'restore it'}, or strike the entry"


def among(file: str, path: str) -> bool:
    """Whether a file is what a path names, or is in the folder that it names: files of a folder are named from the project, however that is written."""
    folder = posixpath.normpath(path)
    return file in (path, folder) or folder == "." or file.startswith(f"{folder}/")


def _outside(root: Path, path: str) -> bool:
    """Whether a path leads to a file out of the project."""
    return _bytes(root, path) is None and _bytes(root, path, outside=True) is not None


def _unnamed(root: Path, path: str, ids: Iterable[str]) -> str:
    text = (_bytes(root, path) or b"").decode("utf-8", "replace")
    return " ".join(id_ for id_ in sorted(ids) if not sections.names(text, id_))


def _folder(root: Path, folder: str) -> str | None:
    """One sha256 of all files below a folder, with their names; None where there is none."""
    base = root / folder
    files = sorted(path.relative_to(base).as_posix() for path in base.rglob("*") if path.is_file())
    said = json.dumps([(name, sha256(root, f"{folder}/{name}")) for name in files])
    return hashlib.sha256(said.encode()).hexdigest() if files else None


def _written_down(project: Project) -> Iterator[tuple[Entry, Placed]]:
    """The files in which analyses, reviews and design elements are written down."""
    for entry in project.entries:
        for kind, path in entry.links:
            if kind == "backed_by":
                yield entry, path


def sources(root: Path, project: Project, runs: Iterable[RunSummary]) -> Hashes:
    """The hashes of what kept runs were made from, also out of the project: logs that are not part of it are there named by path.

    They were taken of the bytes; those of a text that a checkout gave other ends of lines are what it holds.
    """
    kept = {str(scenario.path) for scenario in project.scenarios if scenario.kept}
    found: dict[str, str | None] = {}
    for run in runs:
        for path, was in run.made_from.items() if run.scenario in kept else ():
            found[path] = _as_bytes(root, path)
            if found[path] not in (None, was):
                found[path] = sha256(root, path, outside=True)
    return found


def _as_bytes(root: Path, path: str) -> str | None:
    """The sha256 of a file's bytes, wherever it is, however long; None where there is none."""
    try:
        if not (root / path).is_file():
            return None
        with (root / path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError):
        return None


def sha256(root: Path, path: str, outside: bool = False) -> str | None:
    """The sha256 of what a file holds, None where there is none; `outside`: it may be out of the project."""
    data = _bytes(root, path, outside)
    return None if data is None else digest(data)


def _bytes(root: Path, path: str, outside: bool = False) -> bytes | None:
    """The bytes of a file of the project; None where there is none."""
    try:
        whole = (root / path).resolve()
        inside = outside or whole.is_relative_to(root.resolve())
        return whole.read_bytes() if inside and whole.is_file() else None
    except (OSError, ValueError, RuntimeError):  # the last: a link that leads to itself
        return None


def _document(root: Path, path: str) -> str | None:
    """The sha256 of a document; empty for one that says nothing, None where there is none."""
    data = _bytes(root, path)
    if data is None:
        return None
    markdown = path.lower().endswith((".md", ".markdown"))
    return "" if sections.silent(data, markdown) else digest(data)


def check(project: Project, spec: Spec, found: Hashes) -> Iterator[Finding]:
    """Evidence that is not there, says nothing, is not what was reviewed, or is what is demanded (T250 to T252, T256)."""
    for entry in project.evidence:
        actual = found.get(entry.path)
        if not actual:
            message = f"the evidence `{entry.path}` {lacking(entry.path, found)}"
            yield error("T250", message, entry.path.place, "write it, or strike the entry", entry.path)
        elif entry.sha256 and actual != entry.sha256:
            message = f"the evidence `{entry.path}` has changed since it was reviewed"
            help_ = f"review it again, then set `sha256: {actual}`"
            yield error("T251", message, entry.path.place, help_, entry.path)
        if demanding(entry.path) in found:
            yield _demanded(entry.path, f"of {_requirements(entry)}", entry.path.place, str(entry.path))
    for made, path in _written_down(project):
        if made.kind in ("analysis", "review") and demanding(path) in found:
            yield _demanded(path, f"of the {made.kind} `{made.id}`", path.place, str(made.id))
        if not found.get(path):
            message = f"the document `{path}` of the {made.kind} `{made.id}` {lacking(path, found)}"
            yield error("T250", message, path.place, "write it, or strike the entry", path)
    for item in spec.by_name.values():
        if item.kind == "assume" and demanding(item.evidence) in found:
            yield _demanded(item.evidence, f"of the assumption `{item.name}`", item_place(item), item.name)
        if item.kind == "assume" and item.evidence and not found.get(item.evidence):
            lacks = lacking(item.evidence, found)
            message = f"the evidence `{item.evidence}` of the assumption `{item.name}` {lacks}"
            yield error(
                "T252", message, item_place(item), "write it; paths are relative to the project", item.name
            )


def _demands(root: Path, path: str, project: Project) -> bool:
    """Whether a file, or what a link leads to, says what is demanded: a spec, one of the documents that stand in the folder of requirements, or the baseline of
    these."""
    try:
        whole = (root / path).resolve().relative_to(root.resolve())
    except (OSError, ValueError, RuntimeError):
        return False  # out of the project, which is said there
    baseline = PurePosixPath(project.baseline) if project.baseline else None
    return any(
        one.suffix.lower() == ".spec"
        or (one.parts[:1] == (FOLDER,) and one.suffix.lower() in (".yaml", ".yml"))
        or one == baseline
        for one in (PurePosixPath(path), whole)
    )


def _requirements(entry: Evidence) -> str:
    return ", ".join(f"`{pattern}`" for pattern in entry.requirements)


def _demanded(path: str, of: str, place: Place, subject: str) -> Finding:
    message = f"the evidence {of} is `{path}`, which says what is demanded: it names things and shows nothing of them"
    return error("T256", message, place, "name what shows that it is so", subject)
