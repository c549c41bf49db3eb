"""What the engine reports, indexed: rules by requirement, tests by rule, results by test, runs by scenario."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping

from trackmarshal.records import FaultCase, FaultResult, RuleFacts, RunSummary, SpecItem, SpecTest, TestResult
from trackmarshal.trace.findings import Place

_WORST_FIRST = ("failed", "error", "passed")


def item_place(item: SpecItem | SpecTest) -> Place:
    return Place(item.file, item.line, item.column)


def _where(item: SpecItem | SpecTest) -> tuple[str, int, int]:
    return (item.file, item.line, item.column)


class Spec:
    """The engine's records, in an order of their own, so that what is made from them depends on nothing else."""

    def __init__(
        self,
        items: Iterable[SpecItem],
        tests: Iterable[SpecTest],
        results: Iterable[TestResult],
        runs: Iterable[RunSummary],
        fingerprint: str = "",
        run_fingerprints: Mapping[str, str] | None = None,
        fault_cases: Iterable[FaultCase] = (),
        fault_results: Iterable[FaultResult] = (),
    ) -> None:
        self.items = sorted(items, key=_where)
        self.tests = sorted(tests, key=_where)
        #: Of everything that tests evaluate; empty when the caller does not know it.
        self.fingerprint = fingerprint
        #: Of what each scenario is replayed with, by its path; scenarios that are missing are not compared.
        self.run_fingerprints = run_fingerprints or {}
        self.by_name: dict[str, SpecItem] = {}
        self.by_requirement: dict[str, list[SpecItem]] = defaultdict(list)
        for item in self.items:
            self.by_name.setdefault(item.name, item)
        for item in self.by_name.values():
            for id_ in dict.fromkeys(ref.id for ref in item.satisfies):
                self.by_requirement[id_].append(item)
        self.tests_of: dict[str, list[SpecTest]] = defaultdict(list)
        for test in self.tests:
            self.tests_of[test.rule].append(test)
        #: The worst of several results of one test: nothing says which of them is right.
        self.results: dict[tuple[str, str], TestResult] = {}
        for result in sorted(
            results, key=lambda r: (_WORST_FIRST.index(r.outcome), json.dumps(r.to_json(), sort_keys=True))
        ):
            self.results.setdefault((result.rule, result.title), result)
        self.runs: dict[str, RunSummary] = {}
        for run in sorted(runs, key=lambda r: (r.created, json.dumps(r.to_json(), sort_keys=True))):
            self.runs[run.scenario] = run
        self.faults = sorted(fault_cases, key=lambda case: (case.campaign, case.line))
        self.faults_of: dict[str, list[FaultCase]] = defaultdict(list)
        for case in self.faults:
            self.faults_of[case.requirement].append(case)
        #: The worst of several results of one fault.
        self.fault_results: dict[tuple[str, str], FaultResult] = {}
        for found in sorted(
            fault_results,
            key=lambda r: (_WORST_FIRST.index(r.outcome), json.dumps(r.to_json(), sort_keys=True)),
        ):
            self.fault_results.setdefault((found.campaign, found.id), found)
        self._facts: dict[str, dict[str, RuleFacts]] = {}
        self._stale: dict[tuple[str, str | None], str] = {}

    def rules(self, requirement: str) -> list[SpecItem]:
        """The rules that say they satisfy it."""
        return [item for item in self.by_requirement.get(requirement, ()) if item.kind == "rule"]

    def assumptions(self, requirement: str) -> list[SpecItem]:
        """The assumptions that say they satisfy it."""
        return [item for item in self.by_requirement.get(requirement, ()) if item.kind == "assume"]

    def evaluated(self, requirement: str) -> list[SpecItem]:
        """Its rules, and its assumptions that are monitored."""
        return [
            item for item in self.by_requirement.get(requirement, ()) if item.kind == "rule" or item.monitored
        ]

    def staleness(self, result: TestResult) -> str:
        """Why a result no longer says anything about the spec as it is now; empty when it does."""
        item = self.by_name.get(result.rule)
        if item is not None and result.fingerprint != item.fingerprint:
            return f"`{item.name}` has changed since"
        if self.fingerprint and result.spec_fingerprint and result.spec_fingerprint != self.fingerprint:
            return "the specs have changed since"
        return ""

    def facts(self, run: RunSummary) -> dict[str, RuleFacts]:
        """What each rule said in a run, by the rule's name."""
        if run.scenario not in self._facts:
            self._facts[run.scenario] = {entry.rule: entry for entry in run.rules}
        return self._facts[run.scenario]

    def run_staleness(self, run: RunSummary, source_hash: str | None) -> str:
        """Why a run no longer says anything about the spec and the recording as they are now; empty when it does."""
        key = (run.scenario, source_hash)
        if key not in self._stale:
            self._stale[key] = self._run_staleness(run, source_hash)
        return self._stale[key]

    def _run_staleness(self, run: RunSummary, source_hash: str | None) -> str:
        if source_hash is not None and run.source_hash != source_hash:
            return "the recording has changed since"
        for facts in run.rules:
            item = self.by_name.get(facts.rule)
            if item is not None and item.fingerprint != facts.fingerprint:
                return f"`{item.name}` has changed since"
        if self.run_fingerprints.get(run.scenario, run.spec_fingerprint) != run.spec_fingerprint:
            return "the specs have changed since"
        return ""
