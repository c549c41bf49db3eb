"""What elements of the argument are about: nodes of the link graph, and beside them the project, cells of the matrix, and what is in these."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from trackmarshal.trace import files, sections
from trackmarshal.trace.cells import Cell, Item
from trackmarshal.trace.gates import falls_short
from trackmarshal.trace.graph.fingerprints import fingerprint
from trackmarshal.trace.graph.graph import Graph, Key, Node
from trackmarshal.trace.gsn.case import RESERVED, SUPPORTED, UNSUPPORTED, Evidence, worst
from trackmarshal.trace.matrix import Matrix, Row
from trackmarshal.trace.model import Project, Stage

#: So many names stand in a text; of the others it says how many there are.
NAMED = 3
_MANY = {"analysis": "analyses", "code": "code"}
#: What is evidence of one cell only stands under it in the link graph by these kinds, whose node's id is the item's name.
_BY_NAME = frozenset(
    {"interface", "requirement", "document", "rule", "assumption", "design element", "analysis"}
)


class Subjects:
    """All things that the argument may be about, and how far cells are supported."""

    def __init__(self, matrix: Matrix, project: Project, root: Path) -> None:
        self._matrix = matrix
        self._graph: Graph = matrix.graph
        self._root = root
        self._sections = sections.hashes(root, project)
        self._stages = {str(stage.id): stage for stage in matrix.stages}
        self._rows = {str(row.requirement.id): row for row in matrix.rows}
        self._digests: dict[Key, str] = {}
        #: Of evidence and gaps: how they stand, and what they consist of.
        self.leaves: dict[Key, tuple[str, tuple[Evidence, ...]]] = {}
        self._cells: dict[Key, tuple[Row, Stage, Cell]] = {}

    @property
    def project(self) -> Node:
        """The project as a whole, with numbers of what it has."""
        by_kind = self._graph.by_kind
        numbers = {
            f"{kind.replace(' ', '_')}s": str(len(by_kind.get(kind, ())))
            for kind in ("subsystem", "interface", "issue", "hazard", "requirement", "rule")
        }
        name = self._matrix.project
        return Node("project", name, name, None, {"name": name, **numbers})

    def cells(self, requirement: Node) -> Iterator[Node]:
        """The cells of a requirement that say something of the requirement itself: not those in which nothing counts but what comes from below."""
        row = self._rows.get(requirement.id)
        if row is None:
            return
        above = self._above(requirement.id)
        for name, cell in row.cells.items():
            own = [item for item in cell.items if item.kind != "requirement" or item.name in above]
            if not own and cell.items:
                continue
            stage = self._stages[name]
            attributes = {
                "requirement": requirement.id, "requirement_title": requirement.title, "stage": name, "stage_title": stage.title,
                "shows": stage.shows, "status": cell.status, "asil": str(row.requirement.asil),
            }  # fmt: skip
            node = Node("cell", f"{requirement.id}.{name}", stage.title, requirement.place, attributes)
            self._cells[node.key] = row, stage, Cell(cell.status, tuple(own))
            yield node

    def evidence(self, cell: Node) -> Iterator[Node]:
        """What there is in a cell, as one thing."""
        row, stage, held = self._cells[cell.key]
        there = _there(held.items)
        if there:
            status = worst([self._standing(row, stage, held, item) for item in there])
            said = summary(there)
            node = Node("evidence", cell.id, said, cell.place, {**cell.attributes, "summary": said, "names": names(there)})  # fmt: skip
            found = tuple(
                Evidence(i.kind, _called(i), i.status, self._digest(i, row), i.place) for i in there
            )
            self.leaves[node.key] = status, found
            yield node

    def gaps(self, cell: Node) -> Iterator[Node]:
        """What is missing in a cell, as one thing; an empty cell lacks whatever the stage counts."""
        row, stage, held = self._cells[cell.key]
        lacking = _lacking(held.items)
        wanted = names(lacking) if lacking else " or ".join(stage.counts)
        if lacking or not [item for item in held.items if item.kind != "waiver"]:
            node = Node("gap", cell.id, wanted, cell.place, {**cell.attributes, "names": wanted})
            self.leaves[node.key] = self._short(row, stage, held), ()
            yield node

    def failures(self, cell: Node) -> Iterator[Node]:
        """What failed in a cell, as one thing."""
        failed = [item for item in self._cells[cell.key][2].items if item.status == "failed"]
        if failed:
            yield Node("failure", cell.id, names(failed), failed[0].place or cell.place, {**cell.attributes, "names": names(failed)})  # fmt: skip

    def waivers(self, cell: Node) -> Iterator[Node]:
        """The waivers that a cell needs."""
        for item in self._cells[cell.key][2].items:
            if item.kind == "waiver":
                yield self._graph.nodes["waiver", item.name]

    def _above(self, requirement: str) -> set[str]:
        """What a requirement refines: all others in its cells come from below."""
        links = self._graph.out_of(("requirement", requirement))
        return {link.target[1] for link in links if link.kind == "refines"}

    def _standing(self, row: Row, stage: Stage, cell: Cell, item: Item) -> str:
        """How far an item that is there supports what its cell is to show."""
        match item.status:
            case "covered":
                return SUPPORTED
            case "failed" | "stale":
                return UNSUPPORTED
            case "partial" | "waived":
                return SUPPORTED if cell.status == "covered" else self._short(row, stage, cell)
            case other:
                raise ValueError(f"an item that is there, and {other!r}")

    def _short(self, row: Row, stage: Stage, cell: Cell) -> str:
        """How far a cell is supported of which something is missing: the gate says whether that is bearable."""
        return UNSUPPORTED if falls_short(row.requirement, stage, cell, self._matrix.demands) else RESERVED

    def _digest(self, item: Item, row: Row) -> str:
        """The sha256 of an item of a cell; empty where nothing is known of what it says."""
        if item.kind == "adoption":
            return _sha(str(row.requirement.adopted))
        if item.kind == "code":
            return files.sha256(self._root, item.name) or ""
        key = self._key(item)
        if key not in self._digests:
            node = self._graph.nodes.get(key)
            self._digests[key] = "" if node is None else node.attributes.get("sha256") or fingerprint(node)
        own = self._digests[key]
        if (
            item.kind in ("design element", "analysis") and own
        ):  # with what is written down of it about this requirement
            paths = [str(link.target[1]) for link in self._graph.out_of(key) if link.kind == "backed_by"]
            return _sha(own, *(self._written(path, str(row.requirement.id)) for path in paths))
        if item.kind == "interface" and own:  # with what was found there and led here
            here = ("requirement", str(row.requirement.id))
            led = {link.source for link in self._graph.into(here) if link.kind == "leads_to"}
            found = [link.source for link in self._graph.into(key) if link.kind == "found_at" and link.source in led]  # fmt: skip
            return _sha(own, *(fingerprint(self._graph.nodes[issue]) for issue in found))
        return own

    def _written(self, path: str, requirement: str) -> str:
        """The sha256 of a document's section about a requirement, or else of the document."""
        document = self._graph.nodes.get(("document", path))
        there = "" if document is None else document.attributes.get("fingerprint", "")
        return self._sections.get(sections.key(path, requirement)) or there

    def _key(self, item: Item) -> Key:
        """The node whose text, record or file an item is."""
        match item.kind:
            case kind if kind in _BY_NAME:
                return (kind, item.name)
            case "monitor":
                return ("assumption", item.name)
            case "test":
                return ("result", f"{item.name}: {item.title}")
            case "run":
                return ("run", item.name)
            case "fault":
                assert item.place is not None  # where its campaign declares it
                return ("fault", f"{item.place.file} {item.name}")
            case "external test":
                return ("external test", f"{item.title}: {item.name}")
            case other:
                raise ValueError(f"unknown kind of items {other!r}")


def _there(items: Sequence[Item]) -> list[Item]:
    return [item for item in items if item.status != "missing" and item.kind != "waiver"]


def _lacking(items: Sequence[Item]) -> list[Item]:
    """What is missing. Runs add to each other: what one of them did not evaluate, another one may have."""
    shown = any(item.kind == "run" and item.status == "covered" for item in items)
    return [item for item in items if item.status == "missing" and not (item.kind == "run" and shown)]


def _called(item: Item) -> str:
    return f"{item.name}: {item.title}" if item.kind == "test" and item.title else item.name


def names(items: Sequence[Item]) -> str:
    """The first items by name, with what is said of them, and how many more there are."""
    said = [f"{i.kind} {_called(i)}" + (f" ({i.detail})" if i.detail else "") for i in items[:NAMED]]
    more = f", and {len(items) - NAMED} more" if len(items) > NAMED else ""
    return ", ".join(said) + more


def summary(items: Sequence[Item]) -> str:
    """How many items of each kind, and how many of these are not as they should be."""
    parts = []
    for kind, number in Counter(item.kind for item in items).items():
        odd = Counter(item.status for item in items if item.kind == kind and item.status != "covered")
        noun = kind if number == 1 else _MANY.get(kind, f"{kind}s")
        said = ", ".join(f"{count} {status}" for status, count in sorted(odd.items()))
        parts.append(f"{number} {noun}" + (f" ({said})" if said else ""))
    return ", ".join(parts)


def _sha(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()


__all__ = ["NAMED", "Subjects", "names", "summary"]
