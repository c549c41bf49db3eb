"""Campaigns of faults as evidence: what is declared, and what came of it, as records."""

from __future__ import annotations

import posixpath
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli import evidence
from trackmarshal.cli.output import progress
from trackmarshal.records.faults import FaultCase, FaultResult

if TYPE_CHECKING:
    from trackmarshal.cli.replay import Known
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.faults.campaign import Outcome
    from trackmarshal.scenarios.faults.declaration import Campaign
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.trace import Project


@dataclass(frozen=True, slots=True)
class Prepared:
    """A campaign with its recording and rules; None where these cannot be used, and its faults count as not put in."""

    shown: str
    campaign: Campaign
    recording: Recording | None
    evaluator: Evaluator | None
    source_hash: str
    #: One hash of what the recording is evaluated with.
    evaluated: str

    def replayed(self, scenarios: Collection[str]) -> list[str]:
        """What the faults are put into, a line each; the contents of the recording where it is none of the project's scenarios, which are held by themselves."""
        path = posixpath.normpath(posixpath.join(posixpath.dirname(self.shown), self.campaign.recording))
        contents = [] if path in scenarios else [f"contents {self.source_hash}"]
        return [f"recording {path}", *contents, f"lead {self.campaign.lead:g} s"]

    def fingerprint(self, number: int) -> str:
        """Of what the outcome of a fault depends on now; empty where it cannot be put in."""
        from trackmarshal.runtime.cycle import Limits
        from trackmarshal.scenarios.faults.campaign import fingerprint

        fault = self.campaign.faults[number]
        if self.evaluator is None or fault.open:
            return ""
        limits = Limits.of(self.evaluator.spec)
        return fingerprint(
            self.campaign, fault, self.source_hash, self.evaluated, limits, self.evaluator.rules
        )


def prepare(root: Path, project: Project, broken: bool, shared: Known) -> list[Prepared]:
    """The project's campaigns; those that are not there are left to the matrix. With `broken` specs, none can be run.

    `shared` is what is there already, as `evaluator_for` knows it.
    """
    if not project.campaigns:
        return []
    from trackmarshal.cli.recordings import recorded
    from trackmarshal.cli.replay import evaluator_for
    from trackmarshal.meaning import key
    from trackmarshal.scenarios.faults.declaration import load

    found = []
    for shown in map(str, project.campaigns):
        if not (root / shown).is_file():
            continue
        campaign = load(root / shown, shown)
        path = (root / shown).parent / campaign.recording
        recording, evaluator, digest, evaluated = None, None, "", ""
        if path.is_file() and not broken:
            recording, named = recorded(root, path, str(Path(shown).parent / campaign.recording))
            spec = root / project.default_spec
            evaluator = evaluator_for(recording, spec, [], root, None, "numpy", path.parent, (), shared)
            digest = evidence.file_hash(path)
            evaluated = key(evidence.run_inputs(evaluator, digest, named))
        found.append(Prepared(shown, campaign, recording, evaluator, digest, evaluated))
    return found


def cases(prepared: list[Prepared]) -> list[FaultCase]:
    """Every declared fault."""
    return [
        FaultCase(each.shown, fault.id, fault.title, fault.requirement, fault.line, each.fingerprint(number), fault.open, fault.says, None if fault.open or not fault.changes else fault.begin)
        for each in prepared
        for number, fault in enumerate(each.campaign.faults)
    ]  # fmt: skip


def run(prepared: list[Prepared], wanted: Collection[tuple[str, str]], quiet: bool) -> Iterator[FaultResult]:
    """Outcomes of faults, by campaign and id; those that cannot be put in are left out."""
    from trackmarshal.scenarios.faults.campaign import Bench

    for each in prepared:
        if each.recording is None or each.evaluator is None:
            continue
        todo = [
            n
            for n, fault in enumerate(each.campaign.faults)
            if (each.shown, fault.id) in wanted and not fault.open
        ]
        bench = Bench(each.recording, each.evaluator) if todo else None
        for number in progress(todo, each.campaign.name, quiet):
            if bench is not None:
                outcome = bench.run(each.campaign, each.campaign.faults[number])
                yield _result(each.shown, outcome, each.fingerprint(number))


def _result(shown: str, outcome: Outcome, fingerprint: str) -> FaultResult:
    from trackmarshal.runtime.faults import FAULTS as CODES

    expected = outcome.fault.expected
    by = outcome.by
    if expected is not None and expected.by in by:
        by = (expected.by, *(name for name in by if name != expected.by))
    return FaultResult(
        shown, outcome.fault.id, "failed" if outcome.wrong else "passed", fingerprint, by, CODES.get(by[0], "") if by else "",
        outcome.first, outcome.last, outcome.driven, outcome.since, outcome.lost, outcome.lost_at, outcome.wrong,
    )  # fmt: skip
