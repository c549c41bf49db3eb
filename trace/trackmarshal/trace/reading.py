"""The requirements folder of a project as tables: every document that can be read, every error in one run.

What it all comes to is the business of `requirements`. Whoever wants no more than the ids that are demanded, as `check` does, does not
wait for the records of that.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import NamedTuple

from trackmarshal.files import below
from trackmarshal.trace import tree
from trackmarshal.trace.collector import no_collection
from trackmarshal.trace.documents import DOCUMENTS
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.graph.kinds import OBSOLETE
from trackmarshal.trace.values import Placed, Reader, Table

FOLDER = "requirements"


class Documents(NamedTuple):
    """What can be read: of each document its path from the project, which it is, its fields; and what is wrong with the others."""

    read: tuple[tuple[str, str, Table], ...]
    wrong: tuple[Finding, ...]

    def of(self, kind: str) -> list[Table]:
        return [table for _, each, table in self.read if each == kind]


#: What was read last, by the hashes of all that it was made from: commands ask for it from several places, and parsing takes long.
_last: tuple[dict[str, str], Documents] | None = None


def documents(root: Path, found: list[Finding]) -> Documents:
    """Everything under `requirements/`; what is wrong goes to `found` (T101 to T122)."""
    global _last  # noqa: PLW0603 - one project, the last one
    files = _bytes(root, found)
    hashes = {shown: hashlib.sha256(data).hexdigest() for shown, data in files.items()}
    if _last is None or _last[0] != hashes:
        wrong: list[Finding] = []
        with no_collection():
            each = [(shown, _document(data, shown, wrong)) for shown, data in files.items()]
        read = tuple((shown, *one) for shown, one in each if one is not None)
        _last = (hashes, Documents(read, tuple(wrong)))
    found += _last[1].wrong
    return _last[1]


def demanded(root: Path, found: list[Finding]) -> tuple[Placed, ...]:
    """The ids of all requirements that are demanded, for `satisfies`; files that cannot be read have none."""
    entries = (t for d in documents(root, found).of("requirements") for t in d.tables("requirements"))
    return tuple(t.text("id") for t in entries if t.text("id") and t.text("status") != OBSOLETE)


def document(path: Path, shown: str, found: list[Finding]) -> tuple[str, Table] | None:
    """One file, inside or outside a project: which document it is, its fields; None, and why in `found`, where it is none."""
    data = tree.read(path, shown, found)
    return None if data is None else _document(data, shown, found)


def _bytes(root: Path, found: list[Finding]) -> dict[str, bytes]:
    """The files of a project's requirements by their paths from its root."""
    read = {}
    for path in _files(root / FOLDER, root, found):
        shown = path.relative_to(root).as_posix()
        data = tree.read(path, shown, found)
        if data is not None:
            read[shown] = data
    return read


def _files(folder: Path, root: Path, found: list[Finding]) -> list[Path]:
    """The requirements files below a folder, links to folders followed; what may be one and cannot be read goes to `found` (T101)."""
    if not folder.is_dir():
        return []
    files, problems = below(folder, (".yaml", ".yml"))
    for problem in problems:
        shown = Path(os.fspath(problem.filename)).relative_to(root).as_posix()
        help_ = "every document in the folder counts: remove what is none, or make it readable"
        found.append(error("T101", problem.strerror or str(problem), Place(shown), help_))
    for path in files:
        if path.suffix.lower() != path.suffix:
            message = f"`{path.name}` is almost the name of a requirements file"
            shown = path.relative_to(root).as_posix()
            help_ = f"rename it to `{path.stem}{path.suffix.lower()}`, or give it another suffix"
            found.append(error("T101", message, Place(shown), help_))
    return [path for path in files if path.suffix.lower() == path.suffix]


def _document(data: bytes, shown: str, found: list[Finding]) -> tuple[str, Table] | None:
    node = tree.parse(data, shown, found)
    if node is None or isinstance(node, tree.Refused):
        return None
    place = Place(shown, node.line, node.column)
    if not isinstance(node, tree.Mapping):
        found.append(
            error("T113", "the document is no mapping", place, "start with `document: requirements`")
        )
        return None
    kind = node.entries.get("document")
    known = ", ".join(DOCUMENTS)
    if not isinstance(kind, tree.Scalar) or kind.text not in DOCUMENTS:
        said = (
            f"`document` cannot be `{kind.text}`"
            if isinstance(kind, tree.Scalar)
            else "which document this is, is not said"
        )
        help_ = (
            did_you_mean(kind.text, DOCUMENTS) if isinstance(kind, tree.Scalar) else ""
        ) or f"known are {known}"
        at = place if kind is None else Place(shown, kind.line, kind.column)
        found.append(error("T113", said, at, help_))
        return None
    table = Reader(shown, found).table(node, DOCUMENTS[kind.text], "the document")
    return None if table is None else (kind.text, table)
