"""What the requirements folder of a project comes to: its documents as typed records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from trackmarshal.trace import entries, model
from trackmarshal.trace.collector import no_collection
from trackmarshal.trace.documents import DOCUMENTS
from trackmarshal.trace.findings import Finding, Place, error
from trackmarshal.trace.graph import methods
from trackmarshal.trace.gsn import document as gsn
from trackmarshal.trace.reading import FOLDER, Documents, documents
from trackmarshal.trace.values import Placed, Table

V_MODEL = f"{FOLDER}/v-model.yaml"


#: What was made last, and of what.
_last: tuple[Documents, model.Project, tuple[Finding, ...]] | None = None


def load(root: Path, found: list[Finding]) -> model.Project:
    """Everything under `requirements/`; what is wrong goes to `found` (T101 to T129), what can be read is kept."""
    global _last  # noqa: PLW0603 - one project, the last one
    read = documents(root, found)
    if _last is None or _last[0] is not read:
        misread: list[Finding] = []
        with no_collection():
            _last = (read, _project(read, misread), tuple(misread))
    _, project, wrong = _last
    found += wrong
    return project


def _project(read: Documents, found: list[Finding]) -> model.Project:
    tables = {kind: read.of(kind) for kind in DOCUMENTS}
    for kind in ("system-model", "v-model", "link-schema", "argument"):
        for extra in tables[kind][1:]:
            message = f"a second {kind}; the first is {tables[kind][0].place.file}"
            found.append(error("T129", message, extra.place, "merge the two"))
    for table in tables["v-model"][:1]:
        if table.place.file != V_MODEL:
            help_ = "move it there: its history is followed, and what is accepted with it"
            found.append(error("T112", f"the v-model is not in {V_MODEL}", table.place, help_))
    if not tables["v-model"]:
        found.append(
            error(
                "T112",
                "the project has no v-model document",
                Place(V_MODEL),
                "write one; it makes the folder a project",
            )
        )
    project = _settings(tables["v-model"][0]) if tables["v-model"] else model.Project()
    requirements = tuple(
        _requirement(t) for d in tables["requirements"] for t in d.tables("requirements") if t.text("id")
    )
    beside = tuple(entry for kind in entries.LISTS for entry in entries.entries(tables[kind], kind))
    schema = entries.schema(tables["link-schema"][0]) if tables["link-schema"] else None
    argument = gsn.argument(tables["argument"][0]) if tables["argument"] else None
    project = replace(
        project, requirements=requirements, entries=beside, schema=schema, argument=argument, by_id={}
    )
    for requirement in requirements:
        project.by_id.setdefault(str(requirement.id), requirement)
    found += methods.unknown(project)
    return _with_model(project, tables["system-model"][0]) if tables["system-model"] else project


def _requirement(t: Table) -> model.Requirement:
    return model.Requirement(
        t.text("id"), t.text("title"), t.text("statement"), t.text("rationale"), t.texts("derived_from"), t.texts("refines"),
        t.text("adopted"), t.text("status"), t.text("asil"), t.texts("verification"), t.texts("metrics"), t.texts("assumptions"),
        t.text("source"), t.text("owner"), entries.of_requirement(t), tuple(sorted(t.get("not_verified_by", {}).items())),
    )  # fmt: skip


def _with_model(project: model.Project, t: Table) -> model.Project:
    subsystems = tuple(
        model.Subsystem(s.text("id"), s.text("title"), s.text("role"), s.text("description"))
        for s in t.tables("subsystems")
        if s.text("id")
    )
    interfaces = tuple(_interface(i) for i in t.tables("interfaces") if i.text("id"))
    infeasible = tuple(
        model.Infeasible(i.text("between"), i.text("reason"))
        for i in t.tables("infeasible")
        if i.text("between")
    )
    return replace(
        project, subsystems=subsystems, interfaces=interfaces, infeasible=infeasible, modelled=t.place
    )


def _interface(t: Table) -> model.Interface:
    flows = tuple(model.Flow(f.text("kind"), f.text("initiator"), f.text("what")) for f in t.tables("flows"))
    issues = tuple(model.Issue(i.text("id"), i.text("text"), i.texts("leads_to")) for i in t.tables("issues"))
    return model.Interface(t.text("id"), t.text("title"), flows, issues, t.text("rationale"))


def _settings(t: Table) -> model.Project:
    p = t.get("project")
    settings = p if isinstance(p, Table) else _nothing(t.place)
    tests = settings.get("tests_per_rule", {})
    return model.Project(
        name=settings.text("name"),
        place=settings.place,
        specs=settings.texts("specs"),
        default_spec=settings.text("default_spec"),
        results=settings.text("results") or "out/results",
        baseline=settings.text("baseline") or None,
        tests_per_rule=tuple(
            (verdict, tests.get(verdict, 1)) for verdict in ("satisfied", "violated", "boundary")
        ),
        boundary_distance=settings.texts("boundary_distance"),
        stages=tuple(_stage(s) for s in t.tables("stages") if s.text("id")),
        scenarios=tuple(
            _scenario(s) for s in settings.tables("scenarios") if s.text("path") and s.text("stage")
        ),
        campaigns=settings.texts("campaigns"),
        junit=tuple(
            model.TestReport(
                j.text("path"),
                j.text("stage"),
                j.text("tool"),
                j.text("names"),
                j.get("if_there", False),
                j.texts("methods"),
            )
            for j in settings.tables("junit")
            if j.text("path") and j.text("stage")
        ),
        sources=settings.texts("sources"),
        denials=settings.texts("denials"),
        closed_loop=settings.text("closed_loop") or None,
        case_words=settings.text("case_words") or None,
        case_templates=settings.text("case_templates") or None,
        evidence=tuple(_evidence(e) for e in t.tables("evidence") if e.text("path") and e.text("stage")),
        backing=tuple(
            model.Backing(b.text("name"), b.text("evidence"), b.text("owner"))
            for b in t.tables("assumptions")
            if b.text("name") and b.text("evidence")
        ),
        gate=tuple(
            model.Demand(d.text("stage"), d.texts("requirements"), d.text("at_least") or "covered")
            for d in t.tables("gate")
            if d.text("stage")
        ),
        waivers=tuple(_waiver(w) for w in t.tables("waivers") if w.text("id")),
    )


def _stage(t: Table) -> model.Stage:
    return model.Stage(
        t.text("id"),
        t.text("title"),
        t.text("shows"),
        t.texts("applies_to"),
        t.texts("counts"),
        t.get("if_any", False),
    )


def _scenario(t: Table) -> model.Scenario:
    return model.Scenario(
        t.text("path"), t.text("stage"), t.text("expect"), t.text("origin"), t.texts("by"),
        t.texts("requirements") or (Placed.at("*", t.place),), t.text("title"), t.texts("with"),
        t.text("kept") or None,
    )  # fmt: skip


def _evidence(t: Table) -> model.Evidence:
    return model.Evidence(
        t.text("path"),
        t.text("title"),
        t.text("stage"),
        t.texts("requirements"),
        t.text("sha256"),
        t.texts("methods"),
    )


def _waiver(t: Table) -> model.Waiver:
    return model.Waiver(
        t.text("id"), t.texts("stages"), t.texts("requirements"), t.texts("codes"), t.texts("subjects"), t.text("justification"),
        t.text("residual_risk"), t.text("owner"), t.text("approver"), t.get("granted"), t.get("expires"),
    )  # fmt: skip


def _nothing(place: Place) -> Table:
    table = Table()
    table.place = place
    return table
