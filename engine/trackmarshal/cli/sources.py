"""A project's specs, scenarios and faults, ready to be evaluated."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli import campaigns, evidence
from trackmarshal.cli.facts import Facts
from trackmarshal.records.faults import FaultResult
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult

if TYPE_CHECKING:
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.scenarios.replay import Replay
    from trackmarshal.semantics.compile import Compiled
    from trackmarshal.testing.boundary import Distances
    from trackmarshal.testing.cases import PreparedTest
    from trackmarshal.trace import Finding, Project


def read_specs(root: Path, project: Project) -> tuple[Compiled, list[PreparedTest], list[Diagnostic]]:
    """The project's specs and tests, and what is wrong with the specs; raises for files that cannot be read.

    A rule with an error is left out, so whatever it was to cover is a gap, beside the error itself.
    """
    from trackmarshal.cli.check import unconstrained
    from trackmarshal.cli.project import spec_folders
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.testing.cases import prepare

    compiled = compile_paths(spec_folders(root, project), root)
    if compiled.failures:
        raise compiled.failures[0]
    prepared, found = prepare(compiled)
    return compiled, prepared, [*compiled.found, *found, *unconstrained(compiled)]


#: What a place in a spec belongs to: a declaration by its name, a test by its rule and title.
_MODULE = re.compile(r"^module[ \t]+([\w.]+)", re.MULTILINE)
_DECLARATION = re.compile(
    r'^(constrain|assume|rule|test|param|table|signal|define|predicate|rulebook|zone|line|state|event)[ \t]+([\w.-]+)(?:[ \t]+"([^"\n]*)")?',
    re.MULTILINE,
)


class Sources:
    """Everything that results are made from. Specs with errors are not replayed: what would run is not what the project demands."""

    def __init__(self, root: Path, project: Project) -> None:
        from trackmarshal.cli.replay import Known
        from trackmarshal.meaning import Meaning, whole

        self.root, self.project = root, project
        self.compiled, prepared, self.found = read_specs(root, project)
        self.prepared = [test for test in prepared if whole(self.compiled.spec, test.rule)]
        self.broken = any(item.level == "error" for item in self.found)
        self.meaning = Meaning(self.compiled.spec)
        self.distances = distances(project)
        self._shared = Known(self.compiled)
        #: By scenario, the hash of the files that it names.
        self._named: dict[str, str] = {}

    def facts(self) -> Facts:
        """What the matrix is made of, without results."""
        from trackmarshal.cli.check import unknown_requirements

        items, tests = self._of_project()
        # Where a rule stands in the matrix, the matrix itself says what is wrong with its links.
        seen = {(item.file, ref.line, ref.column) for item in items for ref in item.satisfies}
        loose = (
            link
            for link in unknown_requirements(self.compiled, self.root)
            if (link.span.file.path, link.span.line, link.span.column) not in seen
        )
        wrong = [
            _finding(item, self.compiled.spec.signals)
            for item in (*self.found, *loose)
            if item.level == "error"
        ]
        wrong += self._invented()
        inputs = {
            shown: evidence.run_inputs(
                evaluator,
                None if shown in self._kept else evidence.file_hash(self.root / shown),
                self._named.get(shown, ""),
            )
            for shown, (_, evaluator) in self._scenarios.items()
        }
        names = {item.name for item in items}
        read_by = [test for test in self.prepared if test.rule.name in names]
        parts = [
            *evidence.spec_parts(self.compiled.spec, items, self._shipped, read_by),
            *self._replayed(),
        ]
        return Facts(items, parts, tests, inputs, campaigns.cases(self._campaigns), wrong)

    def _replayed(self) -> Iterator[SpecPart]:
        """What scenarios and campaigns are replayed with beside their own files: values of configurations; and the recording of a campaign."""
        from trackmarshal.meaning import sha256

        spec = self.root / self.project.default_spec
        own = {str(scenario.path): scenario.specs for scenario in self.project.scenarios}
        said = {
            shown: evidence.configured(
                evaluator,
                self._shared.compile((spec, *(self.root / str(s) for s in own[shown])), self.root).spec,
            )
            for shown, (_, evaluator) in self._scenarios.items()
        }
        for each in self._campaigns:
            if each.evaluator is not None:
                values = evidence.configured(each.evaluator, self._shared.compile((spec,), self.root).spec)
                said[each.shown] = [*each.replayed(own), *values]
        for shown, lines in said.items():
            if lines:
                yield SpecPart("replay", shown, sha256(*lines), "\n".join(lines), "", 0, 0)

    def _invented(self) -> Iterable[Finding]:
        """Scenarios that are generated here, and are called from the field (T127): no vehicle was there."""
        from trackmarshal.trace.findings import error

        for scenario in self.project.scenarios:
            recording, _ = self._scenarios.get(str(scenario.path), (None, None))
            if recording is not None and recording.generated and scenario.origin == "field":
                message = f"`{scenario.path}` is generated from a declaration, so it is not from the field"
                help_ = "say `origin: synthetic`"
                yield error("T127", message, scenario.path.place, help_, str(scenario.path))

    def test(self, wanted: Iterable[SpecTest], facts: Facts) -> Iterable[TestResult]:
        """The results of these tests, each of them run."""
        from trackmarshal.testing.run import run_tests

        named = {(test.rule, test.title): test for test in wanted}
        first: dict[tuple[str, str], PreparedTest] = {}
        for test in self.prepared:
            first.setdefault((test.rule.name, test.title), test)
        chosen = [test for key, test in first.items() if key in named]
        for outcome in run_tests(self.compiled.spec, chosen, distances=self.distances):
            rule = outcome.test.rule
            inputs = facts.of_test(named[rule.name, outcome.test.title])
            yield evidence.test_result(outcome, inputs, self.meaning.fingerprint(rule))

    def replay(
        self, shown: str, facts: Facts, quiet: bool, keep: bool = False
    ) -> tuple[RunSummary, Replay, Evaluator, dict[str, float]]:
        """The run of a scenario, and the parameters in force in it, in SI. keep: for its page, which explains it."""
        from trackmarshal.cli.replay import run_one
        from trackmarshal.scenarios.overrides import known_params

        recording, evaluator = self._scenarios[shown]
        outcome = run_one(recording, evaluator, quiet, brief=True, keep=keep)
        digest = facts.run_inputs[shown]["recording"]
        changed = evaluator.reader.settings({"params": known_params(recording, evaluator.spec)}).params
        summary = evidence.run_summary(
            outcome, evaluator, shown, digest, facts.run_inputs[shown].get("named", "")
        )
        params = {name: float(changed.get(name, info.value)) for name, info in evaluator.spec.params.items()}
        return summary, outcome, evaluator, params

    def put_in(self, wanted: Iterable[tuple[str, str]], quiet: bool) -> Iterable[FaultResult]:
        """What comes of these faults, by campaign and id; those that cannot be put in are left out."""
        return campaigns.run(self._campaigns, set(wanted), quiet)

    @property
    def recorded(self) -> dict[str, tuple[Recording, Evaluator]]:
        """By scenario that is there, its recording and the rules that it is replayed with; none where the specs have errors."""
        return self._scenarios

    @cached_property
    def _campaigns(self) -> list[campaigns.Prepared]:
        return campaigns.prepare(self.root, self.project, self.broken, self._shared)

    @cached_property
    def _kept(self) -> frozenset[str]:
        return frozenset(kept_runs(self.project))

    @cached_property
    def _scenarios(self) -> dict[str, tuple[Recording, Evaluator]]:
        """Every scenario's recording and the rules that it is replayed with; those that are not there are left to the matrix."""
        from trackmarshal.cli.recordings import recorded
        from trackmarshal.cli.replay import evaluator_for
        from trackmarshal.scenarios.field.header import header
        from trackmarshal.scenarios.field.mapping import read

        result: dict[str, tuple[Recording, Any]] = {}
        for scenario in () if self.broken else self.project.scenarios:
            shown = str(scenario.path)
            path = self.root / shown
            if path.is_file():
                # Of a log that need not be here, the mapping alone says what it is evaluated with.
                if scenario.kept:
                    recording = header(read(path, shown))
                else:
                    recording, self._named[shown] = recorded(self.root, path, shown)
                more = [self.root / str(spec) for spec in scenario.specs]
                spec = self.root / self.project.default_spec
                evaluator = evaluator_for(
                    recording, spec, [], self.root, None, "numpy", path.parent, more, self._shared
                )
                result[shown] = (recording, evaluator)
        return result

    @cached_property
    def _shipped(self) -> frozenset[str]:
        """Files that came with the package. What is called as one, and is the project's own, is none."""
        from trackmarshal.semantics.modules import from_library

        modules = [
            (module.file.path, from_library(module, self.root))
            for module in self.compiled.library.modules.values()
        ]
        own = {path for path, is_shipped in modules if not is_shipped}
        return frozenset(path for path, is_shipped in modules if is_shipped) - own

    def _of_project(self) -> tuple[list[SpecItem], list[SpecTest]]:
        """What the specs say, as the matrix sees it: all of the project's own, and of the shipped rules that it uses those that satisfy
        one of its requirements, with what they assume. The others are evaluated all the same; nobody answers for them here."""
        from trackmarshal.cli.check import demanded

        items, tests = (
            evidence.spec_items(self.meaning),
            evidence.spec_tests(self.compiled.spec, self.prepared, self.distances),
        )
        shipped = self._shipped
        if not shipped:
            return items, tests
        known, _ = demanded(self.root)
        linked = [
            replace(item, satisfies=tuple(ref for ref in item.satisfies if ref.id in known))
            if item.file in shipped
            else item
            for item in items
        ]
        assumed = {
            ref.id for item in linked if item.satisfies or item.file not in shipped for ref in item.assuming
        }
        claimed = [
            item for item in linked if item.file not in shipped or item.satisfies or item.name in assumed
        ]
        names = {item.name for item in claimed}
        return claimed, [test for test in tests if test.rule in names]


def distances(project: Project) -> Distances:
    """How far limits are moved to see that boundary tests fail, as the project says; raises T347."""
    from trackmarshal.testing.boundary import Distances

    return Distances({str(text): (text.place.file, text.place.line) for text in project.boundary_distance})


def kept_runs(project: Project) -> dict[str, str]:
    """By scenario, the file that its run is kept in: of logs that need not be part of the project."""
    return {str(scenario.path): str(scenario.kept) for scenario in project.scenarios if scenario.kept}


def _finding(item: Diagnostic, signals: Container[str]) -> Finding:
    """A diagnostic of a spec as a finding of the matrix. signals: those that there are, so that none of them is what is missed."""
    from trackmarshal.semantics.errors.expressions import DimensionMismatch
    from trackmarshal.trace import Finding, Place

    span = item.span
    before = span.file.text[: span.file.text.find("\n", span.start) + 1 or None]
    declared = _DECLARATION.findall(before)
    names: list[str] = []
    subject = ""
    if declared:
        kind, name, title = declared[-1]
        if kind == "test":
            names += [f"{name}: {title}", name]
        elif kind != "rulebook":
            subject = name
            module = _MODULE.search(before)
            names += [] if module is None else [f"{module[1]}.{name}"]  # as parameters and tables are called
    if span.text.replace("-", "_").isidentifier() and span.text not in signals:  # such as what there is not
        names.append(span.text)
    if isinstance(item, DimensionMismatch):
        names += [name for name, *_ in item.declared]
    place = Place(span.file.path, span.line, span.column)
    return Finding(
        item.code, item.level, item.message, place, item.help, subject, about=tuple(dict.fromkeys(names))
    )
