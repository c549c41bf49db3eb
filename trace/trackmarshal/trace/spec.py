"""What the engine reports, indexed: rules by requirement, tests by rule, results by test, runs by scenario."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping

from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import RuleFacts, RunSummary
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult
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
        engine: str = "",
        run_inputs: Mapping[str, Mapping[str, str]] | None = None,
        fault_cases: Iterable[FaultCase] = (),
        fault_results: Iterable[FaultResult] = (),
        parts: Iterable[SpecPart] = (),
    ) -> None:
        self.items = sorted(items, key=_where)
        self.tests = sorted(tests, key=_where)
        self.parts = sorted(parts, key=lambda part: (part.kind, part.name))
        #: Which engine evaluates now; empty when the caller does not know it.
        self.engine = engine
        #: Of what each scenario is replayed with now, by its path; scenarios that are missing are not compared.
        self.run_inputs = run_inputs or {}
        self.by_name: dict[str, SpecItem] = {}
        self.by_requirement: dict[str, list[SpecItem]] = defaultdict(list)
        for item in self.items:
            self.by_name.setdefault(item.name, item)
        for item in self.by_name.values():
            for id_ in dict.fromkeys(ref.id for ref in item.satisfies):
                self.by_requirement[id_].append(item)
        self.tests_of: dict[str, list[SpecTest]] = defaultdict(list)
        #: By rule and title; of two with one title the first counts.
        self.first_tests: dict[tuple[str, str], SpecTest] = {}
        for test in self.tests:
            self.tests_of[test.rule].append(test)
            self.first_tests.setdefault((test.rule, test.title), test)
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

    def staleness(self, result: TestResult) -> str:
        """Why a result no longer says anything about the spec as it is now; empty when it does."""
        item, test = self.by_name.get(result.rule), self.first_tests.get((result.rule, result.title))
        if item is None or test is None:
            return ""
        if not result.inputs:
            return f"`{item.name}` has changed since" if result.fingerprint != item.fingerprint else ""
        now = test.made_from(item.inputs, self.engine)
        if self.engine:
            return changed(result.inputs, now)
        return changed({**result.inputs, "engine": ""}, now)

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
        now = self.run_inputs.get(run.scenario)
        if now is None:
            return ""
        if run.inputs:
            return changed(run.inputs, now, deep=True)
        rules = {name: value for name, value in now.items() if name.startswith("rule ")}
        return changed({f"rule {facts.rule}": facts.fingerprint for facts in run.rules}, rules)


#: What the kinds of inputs are called.
_CALLED = {
    "rule": "the rule", "param": "the parameter", "table": "the table", "place": "the place", "signal": "the signal",
}  # fmt: skip
_WHOLE = {
    "constraints": "the constraints on its parameters and tables", "test": "what the test gives or expects", "engine": "the engine",
    "recording": "the recording", "named": "a file that the scenario names", "limits": "the limits of the Supervisor",
    "distance": "how far limits are moved", "judged": "which rules the ground truth of generated recordings judges",
}  # fmt: skip


def changed(before: Mapping[str, str], now: Mapping[str, str], *, deep: bool = False) -> str:
    """The first difference between what a result was made from and what there is, in words; empty where there is none.

    deep: the hash of a rule is also that of all that it reads, as of runs.
    """
    for name in sorted(before.keys() | now.keys(), key=lambda name: (not name.startswith("rule "), name)):
        if before.get(name) != now.get(name):
            kind, _, own = name.partition(" ")
            said = f"{_CALLED[kind]} `{own}`" if own else _WHOLE[kind]
            if deep and kind == "rule" and name in before and name in now:
                said += ", or something that it reads,"
            several = name in ("constraints", "limits")
            if name not in now:
                return f"it was made from {said}, which {'take' if several else 'takes'} no part any more"
            return f"{said} {'have' if several else 'has'} {'changed' if name in before else 'joined'} since"
    return ""
