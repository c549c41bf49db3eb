"""A project's specs, tests and scenario runs, brought up to date: what `trace` and `assess` have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli import acceptances, evidence
from trackmarshal.cli.answers import Answers
from trackmarshal.cli.facts import Facts, facts
from trackmarshal.cli.kept import opened, written
from trackmarshal.cli.shown import Shown, kept
from trackmarshal.cli.sources import Sources, kept_runs
from trackmarshal.files import SETTLE, UNMERGED
from trackmarshal.records.faults import FaultResult
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.store import Entry

if TYPE_CHECKING:
    from trackmarshal.cli.weakening import Weakening
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.replay import Replay
    from trackmarshal.trace import Finding, Matrix, Project, Tell
    from trackmarshal.trace.baseline import Content


@dataclass(slots=True)
class Assessment:
    """Everything that the matrix is made of; where something had to be run, what it was run from, and the replays."""

    root: Path
    project: Project
    facts: Facts
    results: list[TestResult]
    runs: list[RunSummary]
    fault_results: list[FaultResult]
    #: What is wrong with the evidence store and the history of the baseline, what is not known of the day, and that files were written meanwhile.
    store_found: list[Finding]
    replays: list[tuple[RunSummary, Replay, Evaluator]]
    #: What was kept to be shown, where replays were asked for and need not be made.
    shown: Shown | None
    _making: _Making
    _answers: Answers
    #: Whether anything may be run.
    _runs: bool
    _told: Weakening | None = None

    @property
    def sources(self) -> Sources:
        """The project's specs, compiled."""
        return self._making.sources

    def matrix(self, today: date | None = None) -> Matrix:
        """The traceability matrix of all this on a day, that of the clock if none is given; errors of specs are findings of it."""
        from trackmarshal import trace
        from trackmarshal.meaning.tool import tool

        said = self.facts
        return trace.build(
            self.root, said.items, said.tests, self.results, self.runs, today or date.today(), engine=tool(), run_inputs=said.run_inputs,
            findings=[*said.findings, *self.store_found], fault_cases=said.fault_cases, fault_results=self.fault_results,
            parts=said.parts, tell=self.weakening(),
        )  # fmt: skip

    @property
    def compiled(self) -> Sources | None:
        """The project's specs, where they had to be compiled already."""
        return self._making.compiled

    @property
    def compiled_first(self) -> bool:
        """Whether the facts were made from these sources, and not kept from an earlier start."""
        return self._making.told

    def entries(self) -> dict[tuple[str, str], Entry]:
        """The entries of the evidence store that count, by kind and subject."""
        said, store = self.facts, self._answers.store
        wanted = [("test", f"{test.rule}: {test.title}", said.of_test(test)) for test in said.tests]
        wanted += [("run", shown, inputs) for shown, inputs in said.run_inputs.items()]
        wanted += [
            ("fault", f"{case.campaign} {case.id}", {"fault": case.fingerprint}) for case in said.fault_cases
        ]
        found = {}
        for kind, subject, inputs in wanted:
            entry = store.find(kind, subject, inputs) or store.latest(kind, subject)
            if entry is not None:
                found[kind, subject] = entry
        return found

    def weakening(self) -> Tell:
        """Says whether rules that are not those of the baseline got weaker; what that takes is made when it is asked."""

        def tell(before: Content, keys: Sequence[str]) -> Mapping[str, str]:
            from trackmarshal.cli.weakening import Weakening

            if self._told is None:
                sources = self._making.sources if self._runs else None
                self._told = Weakening(self.root, self.project, self.facts, self._answers, sources)
            return self._told(before, keys)

        return tell


def assess(
    root: Path, *, run: bool, again: bool = False, replays: bool = False, quiet: bool = True
) -> Assessment:
    """Read a project and its evidence; with `run`, first run tests, scenarios and faults that the store has no result of from the same inputs.

    again: run all of them, and tell what came out differently than the store says. replays: replay all scenarios, for what is shown of them,
    unless that was kept.
    """
    from trackmarshal.trace import reading, requirements

    with opened(root) as read:
        project = requirements.load(root, [])
    # Others may add to the store meanwhile: what it said is what it says.
    answers = Answers(root, root / project.results, again, project.specs)
    made = _Making(root, project, quiet)
    with opened(root) as later:
        if again:
            said = made.facts()
        else:
            folders = [*map(str, project.specs or ["specs"]), reading.FOLDER]
            files = [str(path) for path in (*(s.path for s in project.scenarios), *project.campaigns)]
            said = facts(root, folders, files, made.facts)
        results = list(_tests(answers, said, made if run else None))
        shown = kept(root, said.state, results) if replays and not again else None
        runs = list(_runs(answers, said, made if run else None, replays and shown is None))
        faults = list(_faults(answers, said, made if run else None))
    # Of what was written since it was first read, nobody knows which of both a result is of, and which its inputs say.
    others = written(root, later | read)
    if others:
        said = replace(said, state="")
    dropped = bool(others) and answers.drop()
    answers.write()
    found = _of_store(answers, root)
    if others:
        found.append(_of_both(others, dropped))
    if again and project.baseline:
        found += acceptances.check(root, str(project.baseline))
    runs += _kept_runs(root, project)
    return Assessment(
        root, project, said, results, runs, faults, found, made.replays, shown, made, answers, run
    )


class _Making:
    """What results are made from, read when the first one has to be."""

    def __init__(self, root: Path, project: Project, quiet: bool) -> None:
        self._root, self._project, self.quiet = root, project, quiet
        self.replays: list[tuple[RunSummary, Any, Any]] = []
        #: Whether facts were made.
        self.told = False

    @cached_property
    def sources(self) -> Sources:
        return Sources(self._root, self._project)

    @property
    def compiled(self) -> Sources | None:
        return self.sources if "sources" in vars(self) else None

    def facts(self) -> Facts:
        self.told = True
        return self.sources.facts()


def _tests(answers: Answers, said: Facts, made: _Making | None) -> Iterable[TestResult]:
    """The results of all tests: what is known, and where results can be made, those of all others."""
    todo, inputs = [], {}
    for test in said.tests:
        if (test.rule, test.title) in inputs:
            continue
        inputs[test.rule, test.title] = said.of_test(test)
        known = answers.known(
            "test", f"{test.rule}: {test.title}", inputs[test.rule, test.title], made is None, _standing(test)
        )
        if known is not None and (made is None or known.outcome == "passed"):
            yield known
        elif made is not None:
            todo.append(test)
    if todo and made is not None:
        for result in made.sources.test(todo, said):
            key = f"{result.rule}: {result.title}"
            answers.learn("test", key, inputs[result.rule, result.title], result.to_json())
            yield result


def _standing(test: SpecTest) -> Callable[[dict[str, Any]], TestResult]:
    """The result of a test, of what the store holds: where the test stands now."""
    return lambda said: TestResult.from_json({**said, "file": test.file, "line": test.line})


def _runs(answers: Answers, said: Facts, made: _Making | None, show: bool) -> Iterable[RunSummary]:
    """The runs of all scenarios but those that are kept: what is known, and where runs can be made, all others; to `show` them, all."""
    for shown, inputs in said.run_inputs.items():
        if "recording" not in inputs:
            continue
        known = answers.known("run", shown, inputs, made is None, RunSummary.from_json)
        if known is not None and not (show and made is not None):
            yield known
        elif made is not None:
            summary, outcome, evaluator, params = made.sources.replay(shown, said, made.quiet, show)
            made.replays.append((summary, outcome, evaluator))
            answers.learn("run", shown, inputs, summary.to_json(), params)
            yield summary


def _faults(answers: Answers, said: Facts, made: _Making | None) -> Iterable[FaultResult]:
    """What came of all faults: what is known, and where they can be put in, those of all others."""
    todo = {}
    for case in said.fault_cases:
        inputs = {"fault": case.fingerprint}
        known = answers.known(
            "fault", f"{case.campaign} {case.id}", inputs, made is None, FaultResult.from_json
        )
        if known is not None:
            yield known
        elif made is not None and case.fingerprint:
            todo[case.campaign, case.id] = inputs
    if todo and made is not None:
        for result in made.sources.put_in(todo, made.quiet):
            key = (result.campaign, result.id)
            answers.learn("fault", " ".join(key), todo[key], result.to_json())
            yield result


def _kept_runs(root: Path, project: Project) -> list[RunSummary]:
    return [
        run
        for shown, file in kept_runs(project).items()
        for run in evidence.kept(root / file, "runs")
        if run.scenario == shown
    ]


def _of_both(others: Sequence[str], dropped: bool) -> Finding:
    """That files are others than they were when they were read (T296). dropped: whether something was found out meanwhile."""
    from trackmarshal.trace.findings import Place, error

    more = f", and {len(others) - 1} more," if len(others) > 1 else ""
    kept = ": no result is kept as evidence" if dropped else ""
    message = f"`{others[0]}`{more} was written while it was read{kept}"
    return error("T296", message, Place(others[0]), "run this again once nothing writes to the project")


def _of_store(answers: Answers, root: Path) -> list[Finding]:
    """What is wrong with the evidence store (T293, T294)."""
    from trackmarshal.trace.findings import Place, error

    path = answers.store.path
    shown = path.relative_to(root).as_posix() if path.is_relative_to(root) else str(path)
    found = [
        error("T293", UNMERGED, Place(shown, line), SETTLE) if why is UNMERGED
        else error("T293", f"an entry of the evidence store was changed or cut: {why}", Place(shown, line),
                   "remove the line, and what it was the evidence of is run again", subject)
        for line, why, subject in answers.store.broken
    ]  # fmt: skip
    for entry, what in answers.unlike:
        message = f"the {entry.kind} `{entry.subject}` was run again from the same inputs, and its `{what}` is not what the evidence store says"
        help_ = f"find out how the entry came about: by {entry.tool}, {entry.made}"
        found.append(error("T294", message, Place(shown, entry.line), help_, entry.subject))
    return found
