"""Replayed scenarios: whether a run shows what it was declared to show, and for which rules."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from trackmarshal.records.runs import RunSummary, TruthFacts
from trackmarshal.records.specs import SpecItem
from trackmarshal.trace.files import Hashes, lacking, way_out
from trackmarshal.trace.findings import Finding, Place, error, warning
from trackmarshal.trace.model import Project, Scenario
from trackmarshal.trace.spec import Spec
from trackmarshal.units import moment


@dataclass(frozen=True, slots=True)
class Showing:
    """What a run shows about some rules: a status, a sentence, the rules evaluated and those violated in it.

    unjudged: rules that were evaluated as well, of which no ground truth says when they have to fire.
    """

    status: str  #: "covered", "partial", "missing", "failed" or "stale"
    detail: str
    evaluated: tuple[str, ...] = ()
    fired: tuple[str, ...] = ()
    unjudged: tuple[str, ...] = ()


def showing(scenario: Scenario, rules: Sequence[SpecItem], spec: Spec, hashes: Hashes) -> Showing:
    """What the run of a scenario shows about these rules."""
    run = _held(scenario, spec, hashes)
    if isinstance(run, Showing):
        return run
    names = {rule.name for rule in rules}
    said = spec.facts(run)
    facts = [said[name] for name in sorted(names) if name in said]
    evaluated = tuple(entry.rule for entry in facts if entry.number("satisfied", "violated"))
    fired = tuple(entry.rule for entry in facts if entry.number("violated"))
    wrong = _wrong(_judging(run, names))
    if wrong:  # whatever else the run was to show
        return Showing("failed", wrong, evaluated, fired)
    match scenario.expect:
        case "ground_truth":
            due = tuple(entry.rule for entry in facts if entry.due)
            return _against_truth(run, names, evaluated, fired, due, bool(facts))
        case "no_fire":
            if run.fired:
                return Showing("failed", _fired(run), evaluated, fired)
            if not evaluated:
                return _undecided(bool(facts))
            if scenario.origin != "field":
                return Showing(
                    "partial",
                    f"nothing fired, but the recording is {scenario.origin}, not from the field",
                    evaluated,
                )
            return Showing(
                "covered", f"nothing fired in {run.cycles} cycles{_kept(scenario, run, hashes)}", evaluated
            )
        case "fire":
            quiet = _quiet(scenario, run)
            if quiet:
                return Showing("failed", f"{quiet} did not fire", evaluated, fired)
            if not fired:
                return Showing("partial", "fired as expected, but by no rule of this requirement", evaluated)
            return Showing("covered", "fired as expected", evaluated, fired)
        case _:
            raise ValueError(f"unknown expectation {scenario.expect!r}")


def as_a_whole(scenario: Scenario, spec: Spec, hashes: Hashes) -> Showing:
    """What the run of a scenario shows about what no rule evaluates, such as that nothing fires where it must not: all of its rules together."""
    run = _held(scenario, spec, hashes)
    if isinstance(run, Showing):
        return run
    wrong = _wrong(run.ground_truth)
    if wrong:
        return Showing("failed", wrong)
    match scenario.expect:
        case "ground_truth":
            if run.unexpected:
                return Showing("failed", _unexpected(run))
            if not run.ground_truth:
                return Showing("missing", "the recording carries no ground truth")
            return Showing(
                "covered",
                f"{run.cycles} cycles, inside the ground truth ({', '.join(sorted(run.ground_truth))})",
            )
        case "no_fire":
            if run.fired:
                return Showing("failed", _fired(run))
            if scenario.origin != "field":
                return Showing(
                    "partial", f"nothing fired, but the recording is {scenario.origin}, not from the field"
                )
            idle = [
                entry.rule for entry in spec.facts(run).values() if not entry.number("satisfied", "violated")
            ]
            told = f"nothing fired in {run.cycles} cycles{_kept(scenario, run, hashes)}"
            if idle:
                some = ", ".join(f"`{rule}`" for rule in sorted(idle)[:3]) + ", ..." * (len(idle) > 3)
                return Showing(
                    "partial",
                    f"{told}, but {len(idle)} {'rule was' if len(idle) == 1 else 'rules were'} not evaluated in it: {some}",
                )
            return Showing("covered", told)
        case "fire":
            quiet = _quiet(scenario, run)
            return (
                Showing("failed", f"{quiet} did not fire")
                if quiet
                else Showing("covered", "fired as expected")
            )
        case _:
            raise ValueError(f"unknown expectation {scenario.expect!r}")


def _held(scenario: Scenario, spec: Spec, hashes: Hashes) -> RunSummary | Showing:
    """The run of a scenario, if it is there and up to date; else what keeps it from showing anything."""
    run = spec.runs.get(scenario.path)
    if not scenario.expect:
        return Showing("missing", "what it is to show is not known")
    if hashes.get(scenario.path) is None:
        return Showing("missing", f"the recording {lacking(scenario.path, hashes)}")
    if run is None:
        return Showing("missing", "not run")
    stale = staleness(scenario, run, spec, hashes)
    return Showing("stale", stale) if stale else run


def staleness(scenario: Scenario | None, run: RunSummary, spec: Spec, hashes: Hashes) -> str:
    """Why the run of a scenario, or of what none declares, says nothing of what there is now; empty where it does."""
    stale = spec.run_staleness(run, hashes.get(run.scenario))
    return stale or ("" if scenario is None else _changed(scenario, run, hashes))


def _absent(scenario: Scenario, run: RunSummary, hashes: Hashes) -> list[str]:
    """What a kept run was made from and is not here."""
    return [path for path in sorted(run.made_from) if hashes.get(path) is None] if scenario.kept else []


def _changed(scenario: Scenario, run: RunSummary, hashes: Hashes) -> str:
    """Why a kept run is of other files than there are; empty where it is not. Evaluated are specs, so those are compared by their meaning."""
    if not scenario.kept:
        return ""
    if not run.made_from:
        return "it does not say what it was made from"
    for path, digest in sorted(run.made_from.items()):
        actual = hashes.get(path)
        if actual is not None and actual != digest and not path.endswith(".spec"):
            return f"`{path}` has changed since"
    return ""


def _again(scenario: Scenario) -> str:
    """How a run that is kept is made."""
    return f"run `trackmarshal import log --map {scenario.path} --keep {scenario.kept}`"


def _kept(scenario: Scenario, run: RunSummary, hashes: Hashes) -> str:
    """What is said beside a kept run."""
    if not scenario.kept:
        return ""
    absent = _absent(scenario, run, hashes)
    return f" (run of {run.created[:10]}" + (f", whose `{absent[0]}` is not here)" if absent else ")")


def _against_truth(
    run: RunSummary, names: set[str], evaluated: tuple[str, ...], fired: tuple[str, ...], due: tuple[str, ...], asked: bool
) -> Showing:  # fmt: skip
    truths = _judging(run, names)
    if run.unexpected:
        return Showing("failed", _unexpected(run), evaluated, fired)
    if not run.ground_truth:
        return Showing("missing", "the recording carries no ground truth")
    if not evaluated:
        return _undecided(asked)
    judged = {name for truth in truths.values() for name in truth.rules}
    unjudged = tuple(name for name in evaluated if name in run.uncovered and name not in judged)
    if unjudged:
        said = f"{_count(evaluated)} evaluated, but no ground truth was declared of {', '.join(unjudged)}"
        # What nobody judged shows nothing, whatever other runs show of the other rules.
        left = set(evaluated) - set(unjudged)
        loud = tuple(name for name in fired if name in left)
        return Showing("partial", said, tuple(sorted(left)), loud, unjudged)
    if not truths:
        return Showing(
            "partial", f"{_count(evaluated)} evaluated, but no ground truth judges them", evaluated
        )
    within = (
        f"{_count(evaluated)} evaluated in {run.cycles} cycles, inside the ground truth ({', '.join(truths)})"
    )
    if not fired:
        return Showing(
            "partial", f"{within}, none was violated: no critical situation for this requirement", evaluated
        )
    if not due:
        return Showing(
            "partial", f"{within}, which leaves free whether {', '.join(fired)} had to fire", evaluated, fired
        )
    return Showing("covered", f"{within}, {', '.join(due)} fired where it had to", evaluated, fired)


def _undecided(asked: bool) -> Showing:
    """Of a run that did not ask these rules, or in which each was inactive, undefined or open all the time."""
    if asked:
        return Showing("missing", "none of its rules was satisfied or violated in any cycle")
    return Showing("missing", "none of its rules was evaluated")


def _count(rules: Sequence[str]) -> str:
    return "1 rule was" if len(rules) == 1 else f"{len(rules)} rules were"


def _judging(run: RunSummary, names: set[str]) -> dict[str, TruthFacts]:
    """The ground truth of a run that judges any of these rules, by its kind."""
    return {
        kind: truth
        for kind, truth in sorted(run.ground_truth.items())
        if not truth.rules or names & set(truth.rules)
    }


def _wrong(truths: Mapping[str, TruthFacts]) -> str:
    """What verdicts of a run contradict; empty where all lie within."""
    outside = ((kind, truth) for kind, truth in sorted(truths.items()) if not truth.inside)
    return "; ".join(_contradiction(kind, truth) for kind, truth in outside)


def _unexpected(run: RunSummary) -> str:
    """Of a run that was unsafe by what no ground truth speaks of."""
    return f"unsafe at {moment(run.unexpected[0])} s, of which no ground truth says what to expect"


def _contradiction(kind: str, truth: TruthFacts) -> str:
    where = f": {truth.violations[0]}" if truth.violations else ""
    more = f" and {len(truth.violations) - 1} more" if len(truth.violations) > 1 else ""
    which = f"ground truth of {kind}" if kind.startswith("rule ") else f"{kind} ground truth"
    return f"outside the {which}{where}{more}"


def _fired(run: RunSummary) -> str:
    who = sorted(
        (entry.first_violation or 0.0, entry.rule) for entry in run.rules if entry.number("violated")
    )
    return f"fired: `{who[0][1]}` at {moment(who[0][0])} s" if who else "fired"


def _quiet(scenario: Scenario, run: RunSummary) -> str:
    """The rules of `by` that were not violated, as a list; empty when the run fired as it should."""
    loud = {entry.rule for entry in run.rules if entry.number("violated")}
    quiet = [f"`{name}`" for name in scenario.by if name not in loud]
    return ", ".join(quiet) if quiet else "" if run.fired else "the Supervisor"


def _of_run(code: str, message: str, scenario: Scenario, run: RunSummary) -> Finding:
    """A finding about what a run came to, which rests on the rules that it was evaluated with."""
    rules = tuple(facts.rule for facts in run.rules)
    return Finding(code, "error", message, scenario.path.place, "", str(scenario.path), rests_on=rules)


def _outside(scenario: Scenario, run: RunSummary) -> Iterator[Finding]:
    """T243 for each kind of rules that the ground truth of the recording contradicts."""
    for kind, truth in sorted(run.ground_truth.items()):
        if not truth.inside:
            yield _of_run(
                "T243", f"the run of `{scenario.path}` is {_contradiction(kind, truth)}", scenario, run
            )


def _by_default(run: RunSummary, spec: Spec, path: str, place: Place | None) -> Iterator[Finding]:
    """Assumptions that hold in a run because an input that their monitor reads is the spec's default (T249)."""
    for name, rules in sorted(run.defaults.items()):
        resting = [
            rule for rule in rules.split(", ") if rule in spec.by_name and spec.by_name[rule].kind == "assume"
        ]
        if resting:
            message = f"`{path}` does not have `{name}`, so {' and '.join(resting)} is judged on the default of the spec"
            help_ = f'record it, or give it in the recording with a reason: `"given": {{"{name}": ..}}`, `"because": {{"{name}": ".."}}`'
            yield error("T249", message, place, help_, path)


def check(project: Project, spec: Spec, hashes: Hashes) -> Iterator[Finding]:
    """What is wrong with scenarios and their runs (T240 to T249)."""
    declared = {str(scenario.path) for scenario in project.scenarios}
    for scenario in project.scenarios:
        place, path = scenario.path.place, str(scenario.path)
        run = spec.runs.get(path)
        if hashes.get(path) is None:
            message = f"the recording `{path}` {lacking(path, hashes)}"
            yield error("T240", message, place, way_out(path, hashes), path)
            continue
        if run is None:
            yield warning(
                "T241",
                f"`{path}` has not been run, which counts as not covered",
                place,
                _again(scenario) if scenario.kept else "run `trackmarshal assess`",
                path,
            )
            continue
        absent = _absent(scenario, run, hashes)
        if absent:
            message = f"the run of `{path}` is kept, and cannot be made again here: `{absent[0]}` is not here"
            more = f" (and {len(absent) - 1} more)" if len(absent) > 1 else ""
            yield Finding(
                "T248",
                "note",
                message + more,
                place,
                "its hash is in the run; fetch it to make the run again",
                path,
            )
        stale = staleness(scenario, run, spec, hashes)
        if stale:
            yield warning(
                "T242",
                f"the run of `{path}` is stale: {stale}",
                place,
                _again(scenario) if scenario.kept else "run `trackmarshal assess` again",
                path,
            )
        elif scenario.expect == "ground_truth":
            yield from _outside(scenario, run)
            if not run.ground_truth:
                message = (
                    f"the run of `{path}` is to lie within the ground truth, but the recording carries none"
                )
                yield error("T246", message, place, "label it, or expect something else of it", path)
            elif run.unexpected:
                yield _of_run("T243", f"the run of `{path}` is {_unexpected(run)}", scenario, run)
        elif scenario.expect == "no_fire":
            if run.fired:
                yield _of_run("T244", f"in `{path}` nothing may fire, but it {_fired(run)}", scenario, run)
            else:
                yield from _outside(scenario, run)
        elif scenario.expect == "fire":
            quiet = _quiet(scenario, run)
            if quiet:
                yield _of_run("T245", f"in `{path}`, {quiet} did not fire", scenario, run)
            else:
                yield from _outside(scenario, run)
        elif scenario.expect:  # one that cannot be read was reported where it stands
            raise ValueError(f"unknown expectation {scenario.expect!r}")
        if not stale:
            yield from _by_default(run, spec, path, place)
        for name in scenario.by:
            if name not in spec.by_name:
                yield error(
                    "T205",
                    f"`{path}` expects `{name}` to fire, but there is no such rule",
                    name.place,
                    "",
                    name,
                )
    for path in sorted(set(spec.runs) - declared):
        yield Finding(
            "T247",
            "note",
            f"the run of `{path}` counts for nothing: v-model.yaml does not declare it",
            None,
            "",
            path,
        )
