"""The graph of a project, made once of its documents, the engine's records and the hashes of files: its nodes here, then what links them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping

from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import DriveFacts, RunSummary
from trackmarshal.records.tests import ExternalTest, TestResult
from trackmarshal.trace import faults, runs
from trackmarshal.trace.external import worst
from trackmarshal.trace.files import Hashes, demanding
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph.graph import Graph, Key, Node
from trackmarshal.trace.graph.keys import KIND, USED, external_key, uses
from trackmarshal.trace.graph.linking import Linking
from trackmarshal.trace.model import Entry, Project, day_said
from trackmarshal.trace.outside import Outside
from trackmarshal.trace.spec import Spec, item_place
from trackmarshal.units import moment


def build(project: Project, spec: Spec, hashes: Hashes, around: Outside | None = None) -> Graph:
    """The graph; a link whose target does not exist is in it, and says so."""
    around = around or Outside()
    nodes = _Nodes(project, spec, hashes, around).all()
    places = {("requirement", str(r.id)): r.asil.place for r in project.by_id.values()}
    return Graph(nodes, Linking(project, spec, around, nodes).links(), places)


class _Nodes:
    def __init__(self, project: Project, spec: Spec, hashes: Hashes, around: Outside) -> None:
        self.project, self.spec, self.hashes, self.around = project, spec, hashes, around
        self.nodes: dict[Key, Node] = {}

    def all(self) -> dict[Key, Node]:
        self._system()
        self._requirements()
        self._specs()
        self._runs()
        self._outside()
        self._documents()
        for entry in self.project.entries:
            attributes = dict(entry.attributes)
            if entry.kind == "analysis":
                attributes["outcome"] = self._of_argument(entry)
                attributes["fingerprint"] = self._of_analysis(entry)
            if entry.made is not None:
                attributes["made"] = entry.made.isoformat()
            self._node(entry.kind, entry.id, entry.title, entry.id.place, attributes)
        return self.nodes

    def _node(
        self,
        kind: str,
        id_: str,
        title: str,
        place: Place | None,
        attributes: Mapping[str, str],
        says: str = "",
    ) -> None:
        """One more node; of two with one key the first counts, as everywhere."""
        key = (kind, str(id_))
        if key not in self.nodes:
            self.nodes[key] = Node(kind, key[1], title, place, attributes, says)

    def _system(self) -> None:
        for part in self.project.subsystems:
            self._node("subsystem", part.id, part.title, part.id.place, {"role": part.role})
        for stage in self.project.stages:
            self._node("stage", stage.id, stage.title, stage.id.place, {"counts": ", ".join(stage.counts)})
        for interface in self.project.interfaces:
            said = {"rationale": interface.rationale}
            self._node("interface", interface.id, interface.title, interface.id.place, said)
            for issue in interface.issues:
                self._node("issue", issue.id, issue.text, issue.id.place, {"interface": str(interface.id)})

    def _requirements(self) -> None:
        for r in self.project.by_id.values():
            attributes = {
                "status": str(r.status), "asil": str(r.asil), "verification": ", ".join(r.verification), "adopted": str(r.adopted),
                "source": str(r.source), "owner": str(r.owner), "statement": str(r.statement), "rationale": r.rationale,
                "not_verified_by": " ".join(method for method, _ in r.not_verified_by),
            }  # fmt: skip
            self._node("requirement", r.id, r.title, r.place, attributes)

    def _specs(self) -> None:
        for item in self.spec.by_name.values():
            attributes = {
                "severity": item.severity, "owner": item.owner, "monitored": "yes" if item.monitored else "no",
                "source": item.source, "fingerprint": item.fingerprint,
            }  # fmt: skip
            self._node(KIND[item.kind], item.name, item.title, item_place(item), attributes)
        for part in self.spec.parts:
            if part.kind in ("limit", "replay"):
                continue  # to which nothing is linked
            place = Place(part.file, part.line, part.column)
            self._node(USED[part.kind], part.name, part.shown, place, {"fingerprint": part.fingerprint})
        for item in self.spec.by_name.values():
            for kind, name in uses(item):
                self._node(kind, name, "", None, {})
        for test in self.spec.tests:
            result = self.spec.results.get((test.rule, test.title))
            outcome = "not run" if result is None else result.outcome
            if result is not None and self.spec.staleness(result):
                outcome = "stale"
            boundary = "yes" if test.boundary else "no"
            attributes = {"expects": test.expects, "boundary": boundary, "outcome": outcome}
            named = f"{test.rule}: {test.title}"
            self._node("test", named, test.title, item_place(test), attributes, test.fingerprint)
        for result in self.spec.results.values():
            place = Place(result.file, result.line)
            self._node(
                "result", f"{result.rule}: {result.title}", result.message, place,
                {"outcome": result.outcome, "sha256": _record(result, "file", "line")},
            )  # fmt: skip

    def _of_argument(self, entry: Entry) -> str:
        """What came of an analysis: it left something open, is written down nowhere, which a document that says that there is none is, or is complete.
        A document that says what is demanded is none."""
        if "open" in entry.attributes:
            return "open"
        paths = [str(path) for kind, path in entry.links if kind == "backed_by"]
        if any((path, str(entry.id)) in self.around.denials for path in paths):
            return "not written down"
        written = any(self.hashes.get(path) and demanding(path) not in self.hashes for path in paths)
        return "complete" if written else "not written down"

    def _of_analysis(self, entry: Entry) -> str:
        """The fingerprint of an analysis: its title, what it leaves open, and what stands in its document, which is what a review of it reads; "" without one."""
        held = [self.hashes.get(path) or "" for kind, path in entry.links if kind == "backed_by"]
        left = [f"open: {entry.attributes['open']}"] if "open" in entry.attributes else []
        said = [" ".join(text.split()) for text in (entry.title, *left)]
        return hashlib.sha256("\n".join([*said, *held]).encode()).hexdigest() if held else ""

    def _runs(self) -> None:
        for scenario in self.project.scenarios:
            expect, origin = str(scenario.expect), str(scenario.origin)
            attributes = {"stage": str(scenario.stage), "expect": expect, "origin": origin}
            told = [expect, origin, *sorted(map(str, scenario.by)), "", *map(str, scenario.specs)]
            says = " ".join([*told, self.hashes.get(str(scenario.path)) or ""])
            self._node("scenario", scenario.path, scenario.title, scenario.path.place, attributes, says)
        scenarios = {str(scenario.path): scenario for scenario in reversed(self.project.scenarios)}
        for run in self.spec.runs.values():
            stale = runs.staleness(scenarios.get(run.scenario), run, self.spec, self.hashes)
            declared = self.nodes.get(("scenario", run.scenario))
            attributes = {
                "fired": "yes" if run.fired else "no",
                "cycles": str(run.cycles),
                "outcome": "stale" if stale else "run",
                "sha256": _record(run, "created"),
                "expect": "" if declared is None else declared.attributes["expect"],
                "origin": "" if declared is None else declared.attributes["origin"],
            }
            if run.drive is not None:
                attributes |= dict(_driven(run.drive))
            self._node("run", run.scenario, "", None, attributes)
        for case in self.spec.faults:
            status, _ = faults.verdict(case, self.spec)
            attributes = {
                "campaign": case.campaign,
                "outcome": "open" if case.open else status,
                "put_in": "no" if case.begin is None else "yes",
            }
            put_in = self.spec.fault_results.get((case.campaign, case.id))
            if put_in is not None:
                attributes["sha256"] = _record(put_in)
                attributes |= dict(_found(case, put_in))
            name, place = f"{case.campaign} {case.id}", Place(case.campaign, case.line)
            self._node("fault", name, case.title, place, attributes, case.says)

    def _outside(self) -> None:
        for external in worst(self.around.tests):
            test = external.test
            attributes = {
                "outcome": test.outcome, "stage": str(external.stage), "tool": test.tool, "created": test.created,
                "report": test.report, "sha256": _record(test, "file", "line", "report_line", "created", "duration"),
            }  # fmt: skip
            self._node(*external_key(external), test.message, external.place, attributes)
        for marker in self.around.markers:
            self._node("code", marker.place.file, "", marker.place, {})

    def _documents(self) -> None:
        for entry in self.project.evidence:
            attributes = {"stage": str(entry.stage), **self._document(str(entry.path))}
            self._node("document", entry.path, entry.title, entry.path.place, attributes)
        named = [(item.evidence, item_place(item)) for item in self.spec.by_name.values() if item.evidence]
        named += [
            (str(path), path.place)
            for e in self.project.entries
            for kind, path in e.links
            if kind == "backed_by"
        ]
        if self.project.closed_loop is not None:
            named.append((str(self.project.closed_loop), self.project.closed_loop.place))
        for path, place in named:
            self._node("document", path, "", place, self._document(path))
        for waiver in self.project.waivers:
            attributes = {
                "owner": str(waiver.owner), "approver": str(waiver.approver), "granted": day_said(waiver.granted),
                "expires": day_said(waiver.expires), "residual_risk": waiver.residual_risk, "stages": ", ".join(waiver.stages),
                "codes": ", ".join(waiver.codes), "subjects": ", ".join(waiver.subjects),
            }  # fmt: skip
            self._node("waiver", waiver.id, waiver.justification, waiver.id.place, attributes)

    def _document(self, path: str) -> dict[str, str]:
        """What a document has come to, by all that names it: as cells have it, the worst prevails."""
        there = self.hashes.get(path)
        reviewed = {entry.sha256 for entry in self.project.evidence if entry.path == path and entry.sha256}
        if not there or demanding(path) in self.hashes:
            outcome = "missing"
        elif reviewed - {there}:
            outcome = "changed"
        elif any(denying == path for denying, _ in self.around.denials):
            outcome = "partial"
        else:
            outcome = "there"
        return {"outcome": outcome, "fingerprint": there or ""}


def _record(said: TestResult | RunSummary | FaultResult | ExternalTest, *apart: str) -> str:
    """The sha256 of a result as it is recorded, but for where it stands and when it was made."""
    data = {name: value for name, value in said.to_json().items() if name not in apart}
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()


def _found(case: FaultCase, result: FaultResult) -> Iterator[tuple[str, str]]:
    """What found a fault, in which cycle, and how long after the first one that was changed, s."""
    yield "by", faults.found_by(result)
    if result.first is not None:
        yield "first", moment(result.first)
        if case.begin is not None:
            yield "after", f"{round(result.first - case.begin, 6):g}"


def _driven(drive: DriveFacts) -> Iterator[tuple[str, str]]:
    """What a drive of a real vehicle was, and how near each rule came to firing, in texts."""
    yield "hours", f"{drive.hours:.4g}"
    yield "km", f"{drive.km:.4g}"
    yield "firings", str(sum(drive.firings.values()))
    for one in drive.least:
        yield f"least {one.rule} {one.candidate}", one.shown
