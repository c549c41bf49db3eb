"""The argument of a project: its templates filled in, with what people say against it, its modules and how far each element is supported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from trackmarshal.trace.collector import no_collection
from trackmarshal.trace.findings import Finding, in_order
from trackmarshal.trace.gsn import checks, document
from trackmarshal.trace.gsn.case import Case
from trackmarshal.trace.gsn.challenges import with_challenges
from trackmarshal.trace.gsn.filling import Filling
from trackmarshal.trace.gsn.modules import in_modules
from trackmarshal.trace.gsn.statuses import with_statuses
from trackmarshal.trace.gsn.subjects import Subjects
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.model import Project


def build(matrix: Matrix, project: Project, root: Path) -> Case:
    """The argument, and in its findings all that is wrong with it (T153, T400 to T423).

    matrix: of the project that has its documents in `project` and its files below `root`. Equal inputs make equal arguments.
    """
    with no_collection():
        own, shipped = project.argument, document.default()
        templates = own.templates if own is not None and own.templates else shipped.templates
        top = own.top if own is not None and own.top else shipped.top
        groups = (own.groups if own is not None else "") or shipped.groups
        filling = Filling(matrix.graph, Subjects(matrix, project, root), templates)
        filling.fill(top, top.place)
        case = Case(matrix.project, filling.elements, tuple(filling.links), findings=tuple(filling.findings))
        if own is not None:
            persons = {
                said for node in matrix.graph.by_kind.get("person", ()) for said in (node.id, node.title)
            }
            case = with_challenges(case, own, persons)
        whole = not filling.findings  # a template that is not right leaves out what it was to make
        found: list[Finding] = [*case.findings, *(checks.of_requirements(case, matrix) if whole else ())]
        case = with_statuses(in_modules(case, groups, filling.beginnings))
        return replace(case, findings=in_order(checks.folded([*found, *checks.check(case, whole)])))


__all__ = ["build"]
