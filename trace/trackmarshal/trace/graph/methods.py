"""Methods of verification: each that a requirement names is answered by evidence of its kind. Which kinds there are, the schema of links says."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from typing import TYPE_CHECKING

from trackmarshal.trace.files import among
from trackmarshal.trace.findings import Finding, did_you_mean, error
from trackmarshal.trace.graph import schema
from trackmarshal.trace.graph.graph import Graph, Node
from trackmarshal.trace.model import Project, matches
from trackmarshal.trace.values import Placed

if TYPE_CHECKING:
    from trackmarshal.trace.outside import Outside

CODE = "T255"


def unknown(project: Project) -> Iterator[Finding]:
    """T123 for methods that the schema of links does not have: of requirements, and of evidence that is to answer them."""
    known = {str(method.name) for method in schema.of(project).methods or ()}
    for word in (
        *(word for r in project.requirements for word in r.verification),
        *(word for e in project.evidence for word in e.methods),
        *(word for j in project.junit for word in j.methods),
    ):
        if word not in known:
            help_ = did_you_mean(word, known) or "known are " + ", ".join(sorted(known))
            yield error("T123", f"`{word}` is no method of verification", word.place, help_)


def check(graph: Graph, project: Project, asking: schema.Asking, around: Outside) -> Iterator[Finding]:
    """T255 for every method of a requirement that nothing answers; a warning where what may answer it was not run."""
    own = schema.of(project)
    known = {str(method.name): method for method in own.methods or ()}
    reports = [entry.path for entry in project.junit if entry.if_there and not _tests_of(entry.path, around)]
    # A run that is kept is made by hand: of one that is not there nobody knows whether it ever will be.
    scenarios = [s.path for s in project.scenarios if not s.kept and ("run", str(s.path)) not in graph.nodes]
    for node in graph.by_kind.get("requirement", ()):
        requirement = project.by_id[node.id]
        for word in dict.fromkeys(requirement.verification) if node.demanded else ():
            method = known.get(word)
            if method is None:
                continue  # reported where it was read
            if asking.met(node, method.any_of) or _named(word, node.id, project, around):
                continue
            kinds = {str(kind) for way in method.any_of for kind in (way.reaches, *way.kinds)}
            waiting = [
                *(reports if "external test" in kinds else ()),
                *(e.path for e in project.junit if word in e.methods and e.path in reports),
                *(scenarios if "run" in kinds else ()),
            ]
            message = f"`{node.id}` is to be verified by {word} ({method.means}), and no evidence of that kind is linked with it"
            if waiting:
                message += f"; `{waiting[0]}` was not run"
            help_ = "link it, name the method under `methods` of evidence that is of that kind, or have somebody answer for the gap"
            yield Finding(
                CODE, "warning" if waiting else "error", message, word.place, help_, f"{node.id}:{word}", about=(node.id,),
                rests_on=tuple(dict.fromkeys((*map(str, waiting), *_written_in(graph, node, kinds)))),
            )  # fmt: skip


def _written_in(graph: Graph, node: Node, kinds: Container[str]) -> list[str]:
    """The documents of what would answer a method if they were there: of the things of these kinds that a requirement is linked with."""
    links = (*graph.out_of(node.key), *graph.into(node.key))
    ends = [end for link in links for end in (link.source, link.target) if end[0] in kinds]
    return [link.target[1] for end in ends for link in graph.out_of(end) if link.kind == "backed_by"]


def _named(word: str, id_: str, project: Project, around: Outside) -> bool:
    """Whether evidence that names a method is linked with a requirement: a document, or a test of such a report."""
    if any(word in entry.methods and matches(id_, entry.requirements) for entry in project.evidence):
        return True
    reports = [entry.path for entry in project.junit if word in entry.methods]
    return any(
        _of(found.test.report, reports)
        for found in around.tests_of.get(id_, ())
        if found.test.outcome != "skipped"
    )


def _tests_of(path: str, around: Outside) -> bool:
    return any(_of(found.test.report, (path,)) for found in around.tests)


def _of(report: str, paths: Sequence[str | Placed]) -> bool:
    """Whether a report is one of these, or in one of these folders."""
    return any(among(report, path) for path in paths)


__all__ = ["check", "unknown"]
