"""Campaigns of faults as evidence: what is declared, and what came of it, as records."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli import evidence
from trackmarshal.cli.output import progress
from trackmarshal.records import FaultCase, FaultResult

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.faults.campaign import Outcome
    from trackmarshal.scenarios.faults.declaration import Campaign
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.trace import Project

FAULTS = "faults.json"


@dataclass(frozen=True, slots=True)
class Prepared:
    """A campaign with its recording and rules; None where these cannot be used, and its faults count as not put in."""

    shown: str
    campaign: Campaign
    recording: Recording | None
    evaluator: Evaluator | None
    source_hash: str

    def fingerprint(self, number: int) -> str:
        """Of what the outcome of a fault depends on now; empty where it cannot be put in."""
        from trackmarshal.runtime.cycle import Limits
        from trackmarshal.scenarios.faults.campaign import fingerprint

        fault = self.campaign.faults[number]
        if self.evaluator is None or fault.open:
            return ""
        spec = self.evaluator.spec
        return fingerprint(self.campaign, fault, self.source_hash, spec.fingerprint, Limits.of(spec))


def prepare(root: Path, project: Project, broken: bool, shared: dict[object, Evaluator]) -> list[Prepared]:
    """The project's campaigns; those that are not there are left to the matrix. With `broken` specs, none can be run.

    `shared` are evaluators that are there already, as `evaluator_for` knows them.
    """
    from trackmarshal.cli.replay import evaluator_for
    from trackmarshal.scenarios import load as load_recording
    from trackmarshal.scenarios.faults.declaration import load

    found = []
    for shown in map(str, project.campaigns):
        if not (root / shown).is_file():
            continue
        campaign = load(root / shown, shown)
        path = (root / shown).parent / campaign.recording
        recording, evaluator, digest = None, None, ""
        if path.is_file() and not broken:
            recording = load_recording(path, str(Path(shown).parent / campaign.recording))
            spec = root / project.default_spec
            evaluator = evaluator_for(recording, spec, [], root, None, "numpy", path.parent, (), shared)
            digest = evidence.file_hash(path)
        found.append(Prepared(shown, campaign, recording, evaluator, digest))
    return found


def cases(prepared: list[Prepared]) -> list[FaultCase]:
    """Every declared fault."""
    return [
        FaultCase(each.shown, fault.id, fault.title, fault.requirement, fault.line, each.fingerprint(number), fault.open)
        for each in prepared
        for number, fault in enumerate(each.campaign.faults)
    ]  # fmt: skip


def run(prepared: list[Prepared], old: list[FaultResult], everything: bool, quiet: bool) -> list[FaultResult]:
    """Outcomes of all faults that can be put in: the old ones where nothing that they depend on has changed, else new ones."""
    from trackmarshal.scenarios.faults.campaign import Bench

    known = {(result.campaign, result.id): result for result in old}
    results = []
    for each in prepared:
        bench: Bench | None = None
        for number, fault in progress(list(enumerate(each.campaign.faults)), each.campaign.name, quiet):
            print_ = each.fingerprint(number)
            before = known.get((each.shown, fault.id))
            if before is not None and before.fingerprint == print_ and not everything:
                results.append(before)
            elif print_ and each.recording is not None and each.evaluator is not None:
                bench = bench or Bench(each.recording, each.evaluator)
                results.append(_result(each.shown, bench.run(each.campaign, fault), print_))
    return results


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
