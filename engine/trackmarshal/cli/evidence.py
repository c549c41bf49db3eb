"""Evidence of the engine as records: what specs say, what tests and runs came to, kept in the project's results folder."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from trackmarshal import __version__
from trackmarshal.files import digest, write_whole
from trackmarshal.records.results_file import Record, ResultsFile, load, save
from trackmarshal.records.runs import RuleFacts, RunSummary, TruthFacts
from trackmarshal.records.specs import Ref, SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.ir.spec import Spec
    from trackmarshal.meaning import Meaning
    from trackmarshal.runtime.verdict import Said
    from trackmarshal.scenarios.labels import Label
    from trackmarshal.scenarios.replay import Replay
    from trackmarshal.testing.boundary import Distances
    from trackmarshal.testing.cases import PreparedTest
    from trackmarshal.testing.run import Outcome

#: So many of the times at which a run was unsafe though nothing said that it may be.
_FIRST = 10
#: As long as an evaluator is there.
_MEANINGS: WeakKeyDictionary[Evaluator, Meaning] = WeakKeyDictionary()


def now() -> str:
    """The time with its offset, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def spec_items(meaning: Meaning) -> list[SpecItem]:
    """Rules and assumptions as the matrix sees them; those that read what has an error of its own are left out, as those with one are."""
    from trackmarshal.meaning import whole
    from trackmarshal.testing.run import has_boundary

    return [
        SpecItem(
            rule.kind, rule.name, rule.title, _refs(rule.satisfies), _refs(rule.assuming), rule.span.file.path, rule.span.line,
            rule.span.column, meaning.fingerprint(rule), rule.severity, rule.source, rule.owner, rule.evidence,
            rule.formula is not None, has_boundary(rule), meaning.rule(rule),
        )
        for rule in meaning.spec.rules
        if whole(meaning.spec, rule)
    ]  # fmt: skip


def spec_parts(
    spec: Spec, items: Iterable[SpecItem], shipped: Collection[str] = (), tests: Iterable[PreparedTest] = ()
) -> list[SpecPart]:
    """What rules and assumptions read, and every cycle is held against, parameters that the numbers of tests are made of, all constraints, and the limits of
    the Supervisor, as the matrix sees them."""
    from trackmarshal.meaning import in_order, of, restricted
    from trackmarshal.runtime.contract import EGO, PLAN
    from trackmarshal.units import in_full

    read = {name for item in items for name in item.inputs}
    read |= {f"param {name}" for test in tests for name in test.told.reads}
    read |= {f"signal {name}" for name in (PLAN, EGO)}
    found: list[tuple[str, str, Any, str]] = []
    for name, param in spec.params.items():
        low, high = (("" if end is None else in_full(end, param.unit)) for end in (param.lower, param.upper))
        within = f", from {low}" * bool(low) + f", up to {high}" * bool(high)
        found.append(("param", name, param, in_full(param.value, param.unit) + within))
    for name, table in spec.tables.items():
        unit = f" {table.units[0]} to {table.units[1]}"
        found.append(("table", name, table, f"{len(table.knots)} knots,{unit}"))
    found += [
        ("place", name, place, f"{place.kind} of {len(place.points)} points")
        for name, place in spec.places.items()
    ]
    for name, signal in spec.signals.items():
        found.append(("signal", name, signal, ", ".join(field.name for field in signal.fields_)))
    used = [(kind, name, info, shown) for kind, name, info, shown in found if f"{kind} {name}" in read]
    for constraint in spec.constraints:
        if constraint.span.file.path in shipped and not any(
            f"{kind} {name}" in read for name in restricted(constraint) for kind in ("param", "table")
        ):
            continue  # of shipped rules that nobody here claims
        text = " ".join(constraint.span.text.partition(" because ")[0].split()).removeprefix("constrain ")
        used.append(("constraint", text, constraint, ""))
    used += [("rulebook", book.name, book, _order(book.relations)) for book in spec.rulebooks]
    parts = [
        SpecPart(
            kind,
            name,
            of(info),
            shown,
            info.span.file.path,
            info.span.line,
            info.span.column,
            restricted(info) if kind == "constraint" else (),
            of(in_order(info)) if kind == "signal" else "",
            (info.source or "") if kind == "param" else "",
        )
        for kind, name, info, shown in used
    ]
    return [*parts, *_limits(spec)]


def configured(evaluator: Evaluator, own: Spec) -> list[str]:
    """The values that a configuration puts in place of those of a spec, as far as rules read them, a line each; places and tables by their hash."""
    from trackmarshal.meaning import of
    from trackmarshal.units import in_full

    meaning, spec = _meaning(evaluator), evaluator.spec
    read = {name for rule in evaluator.rules for name in meaning.rule(rule)}
    found = [
        f"{name} = {in_full(param.value, param.unit)}"
        for name, param in spec.params.items()
        if param is not own.params.get(name) and f"param {name}" in read
    ]
    for kind, ours, theirs in (("table", spec.tables, own.tables), ("place", spec.places, own.places)):
        found += [
            f"{name} = {kind} {of(info)}"
            for name, info in ours.items()
            if info is not theirs.get(name) and f"{kind} {name}" in read
        ]
    return sorted(found)


def _limits(spec: Spec) -> Iterator[SpecPart]:
    """What the Supervisor holds cycles and itself to, declared or not: a limit that is struck is the default again."""
    from trackmarshal.meaning import sha256
    from trackmarshal.runtime.cycle import LIMITS_MODULE, UNITS, Limits
    from trackmarshal.units import in_full

    limits = Limits.of(spec)
    for name, unit in UNITS.items():
        value = getattr(limits, name)
        declared = spec.params.get(f"{LIMITS_MODULE}.{name}")
        at = (
            ("", 0, 0)
            if declared is None
            else (declared.span.file.path, declared.span.line, declared.span.column)
        )
        yield SpecPart("limit", name, sha256(repr(value)), in_full(value, unit), *at)


def _order(relations: Iterable[tuple[str, str, str]]) -> str:
    """What a rulebook says, on one line."""
    return ", ".join(" ".join(relation) for relation in relations)


def _refs(pairs: Iterable[tuple[str, Any]]) -> tuple[Ref, ...]:
    return tuple(Ref(name, span.line, span.column) for name, span in pairs)


def spec_tests(spec: Spec, tests: Iterable[PreparedTest], distances: Distances) -> list[SpecTest]:
    """Tests as the matrix sees them."""
    from trackmarshal.meaning import fingerprint_of_test, sha256
    from trackmarshal.testing.boundary import near

    return [
        SpecTest(
            t.rule.name, t.title, t.verdict, stands.narrow, t.span.file.path, t.span.line, t.span.column, fingerprint_of_test(t), sha256(t.told.said),
            stands.distance, stands.within, sha256(t.told.meant),
        )
        for t in tests
        for stands in [near(t, spec, distances)]
    ]  # fmt: skip


def test_result(outcome: Outcome, inputs: Mapping[str, str], fingerprint: str) -> TestResult:
    """The outcome of a test, with all that it was made from; `fingerprint` is that of its rule."""
    test = outcome.test
    return TestResult(
        test.rule.name, test.title, outcome.outcome, fingerprint, outcome.message, test.span.file.path, test.span.line, inputs,
        outcome.unmoved,
    )  # fmt: skip


def file_hash(path: Path) -> str:
    """sha256 of what a file holds."""
    return digest(path.read_bytes())


def run_inputs(evaluator: Evaluator, recording: str | None, named: str = "") -> dict[str, str]:
    """What a replay rests on: the sha256 of the recording, and of the files that it names, each rule with all that it reads, signals that no rule
    reads, which every cycle is held against, or its conditions are told in, which rules the ground truth of generated recordings judges, the Supervisor's limits, the engine.

    Of a run that is kept because it cannot be made again at any time, the rules, the contract, and what the vehicle brakes with, by which emergency
    trajectories were made, alone (`recording` is None).
    """
    from dataclasses import astuple

    from trackmarshal.ir.spec import short_name
    from trackmarshal.meaning import of, sha256, tool
    from trackmarshal.runtime.contract import EGO, PLAN
    from trackmarshal.runtime.cycle import Limits
    from trackmarshal.scenarios.field.mapping import BRAKING
    from trackmarshal.scenarios.labels import known

    spec, read = evaluator.spec, {signal for rule in evaluator.rules for signal, _ in rule.reads}
    unread = [name for name in (PLAN, EGO) if name in spec.signals and name not in read]
    others = {f"signal {name}": of(spec.signals[name]) for name in unread}
    if recording is not None:
        limits = sha256(*(repr(value) for value in astuple(Limits.of(spec))))
        judged = sha256(*sorted(rule.name for rule in evaluator.rules if known(rule)))
        others |= {"recording": recording, "limits": limits, "judged": judged, "engine": tool()}
        # In whose units the ranges of its conditions are.
        others |= {f"signal {name}": of(info) for name, info in spec.signals.items() if name not in read}
        if named:
            others["named"] = named
    else:
        told = {name for rule in evaluator.rules for name in _meaning(evaluator).rule(rule)}
        braking = {f"param {name}": info for name, info in spec.params.items() if short_name(info) in BRAKING}
        others |= {name: of(info) for name, info in braking.items() if name not in told}
    return dict(_meaning(evaluator).run(evaluator.rules, others))


def _meaning(evaluator: Evaluator) -> Meaning:
    """What the rules of an evaluator rest on: the same for all scenarios that share it."""
    from trackmarshal.meaning import Meaning

    found = _MEANINGS.get(evaluator)
    if found is None or found.spec is not evaluator.spec:
        found = _MEANINGS[evaluator] = Meaning(evaluator.spec)
    return found


def run_summary(
    outcome: Replay, evaluator: Evaluator, shown: str, source_hash: str, named: str = ""
) -> RunSummary:
    """A replay as a record; `shown` is the scenario's path from the project, `named` the hash of the files that it names."""
    from trackmarshal.cli import operating
    from trackmarshal.scenarios.inputs import defaulted
    from trackmarshal.scenarios.labels import judged_by, label
    from trackmarshal.scenarios.overrides import overrides
    from trackmarshal.units import moment

    inputs = run_inputs(evaluator, source_hash, named)
    facts, candidates = [], outcome.candidates
    truth_of = outcome.recording.ground_truth
    for rule in evaluator.rules:
        by = judged_by(rule, evaluator.spec, outcome.recording)
        rated = {name: outcome.said(name, rule.name) for name in candidates}
        due = {
            number
            for name in by
            for candidate, each in rated.items()
            if name in truth_of and _is_about(label(name), candidate)
            for number, (truth, one) in enumerate(zip(truth_of[name], each))
            if truth is False and _violated(one)
        }
        counts = {
            name: dict(Counter(one.verdict for one in each if one is not None))
            for name, each in rated.items()
        }
        against = [each for name, each in rated.items() if "violated" in counts[name]]
        first = next((c.t for c, *found in zip(outcome.cycles, *against) if any(map(_violated, found))), None)
        facts.append(RuleFacts(rule.name, inputs[f"rule {rule.name}"], counts, first, len(due)))
    truths = {}
    for judged in outcome.truths:
        said = [f"rated safe at {moment(t)} s, the ground truth is unsafe" for t in judged.missed]
        said += [f"rated unsafe at {moment(t)} s, the ground truth is safe" for t in judged.false_alarms]
        truths[judged.kind] = TruthFacts(judged.inside, tuple(said), judged.rules)
    return RunSummary(
        shown,
        source_hash,
        evaluator.spec.fingerprint,
        len(outcome.cycles),
        tuple(facts),
        truths,
        outcome.fired,
        now(),
        uncovered=outcome.uncovered,
        unexpected=outcome.unexpected[:_FIRST],
        inputs=inputs,
        ranges=operating.ranges(outcome.recording, evaluator.spec),
        overrides=tuple(map(str, overrides(outcome.recording, evaluator.spec))),
        defaults={
            name: ", ".join(rules)
            for name, rules in defaulted(outcome.recording, evaluator.spec, evaluator.rules).items()
        },
    )


def _violated(said: Said | None) -> bool:
    return said is not None and said.verdict == "violated"


def _is_about(truth: Label | None, candidate: str) -> bool:
    """Whether a truth judges a candidate."""
    return truth is None or truth.candidate in ("", candidate)


def write_run(folder: Path, outcome: Replay, evaluator: Evaluator, lines: Sequence[str]) -> None:
    """The lines of one run, and its summary, in a folder that the user names."""
    folder.mkdir(parents=True, exist_ok=True)
    source = Path(outcome.recording.source)
    write_whole(folder / f"{outcome.recording.name}.jsonl", ("\n".join(lines) + "\n").encode("utf-8"))
    summary = run_summary(outcome, evaluator, outcome.recording.source, file_hash(source))
    keep(folder / f"{outcome.recording.name}.run.json", "runs", [summary])


def keep(path: Path, holds: str, items: Sequence[Record]) -> None:
    """Write records of one kind."""
    save(path, ResultsFile(holds, tuple(items), __version__, now()))


def kept(path: Path, holds: str) -> list[Any]:
    """Records of one kind, or none where the file is not there; raises T290 for a file that cannot be read."""
    if not path.is_file():
        return []
    file = load(path)
    return list(file.items) if file.holds == holds else []
