"""Run the rules over recordings: both candidates of every cycle, what is driven, and the ground truth.

Recordings are `.tmrec.jsonl` (this tool's own format, also `.gz`), `.saa` (ScenarioArchitect), or declared scenarios (`.yaml`), of which they are
generated. With --out, what was said in each cycle and a summary of each run are written; evidence for the traceability matrix are runs that `trace` and
`assess` make. The exit status is 1 when a run is outside of its ground truth, or unsafe where it has
none. A record of a run (`.arrows`) is run again at the recorded times: the exit status is 1 when a decision is not the recorded one.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.giving import choose_given, refuse_given, with_given
from trackmarshal.cli.options import choose_backend, choose_rules
from trackmarshal.cli.output import dump, number, plain, progress, rule_json, say, table
from trackmarshal.cli.project import find_project, optional_project, project_of
from trackmarshal.errors import TrackmarshalError
from trackmarshal.library import of_its_name, shipped_values
from trackmarshal.runtime.verdict import decides
from trackmarshal.units import beside, moment

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.ir.spec import Spec
    from trackmarshal.runtime.verdict import RuleResult
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.scenarios.replay import CycleOutcome, Replay
    from trackmarshal.semantics.compile import Compiled

#: A signal that a cycle does not have.
_ABSENT = re.compile(r"D211 (\w+): it is not there")

CODES = {
    "E431": ("a configuration that a recording names is not there", "A recording's `use` names configuration modules (a vehicle, a track) by their path from the project, or from the recording's own folder, or a shipped one by its module, `vehicles.devbot`."),
    "E432": (
        "a recording names what is not its to name",
        "Recordings come from elsewhere, so what they name is not simply opened: `use` holds relative paths of .spec files inside the project "
        "(without a project: inside the recording's folder), whatever links lie on the way, and modules of shipped vehicles and tracks, where the project has no other one of that name, and nothing else.",
    ),
    "E433": (
        "a name that is no file name",
        "`replay --out` calls its files by the recording's name, which has to be one that stays in that folder, and another one for each run.",
    ),
    "E434": (
        "no one record to export",
        "`--mcap` exports the record of a run of the Supervisor, which has every decision and its reasons; a recording has none yet. One record makes one file: of "
        "several, each would take the place of the one before.",
    ),
    "E436": (
        "a place that a replay cannot start at",
        "`--from 120` starts at the cycle that is number 120 in the record, from 0 as differences count them; `--from 12.0s` at the first one whose stamp is so late. Recordings "
        "start at their beginning, and so do `--mcap` and `--out`, which need all cycles.",
    ),
}  # fmt: skip


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scenarios",
        nargs="+",
        metavar="SCENARIO",
        help="recordings: .tmrec.jsonl or .saa; declarations: .yaml; records: .arrows",
    )
    parser.add_argument(
        "--spec",
        action="append",
        metavar="SPEC",
        help="spec file or folder (repeatable; default: the project's)",
    )
    choose_rules(parser, "evaluate")
    choose_backend(parser, None, "default: numpy; for a record, its own")
    choose_given(parser)
    parser.add_argument("--mcap", metavar="FILE", help="export a record of a run for Foxglove")
    parser.add_argument(
        "--from",
        dest="begin",
        metavar="CYCLE|TIME",
        help="of a record: start there, at the snapshot before (120, or 12.0s)",
    )
    parser.add_argument("--out", metavar="DIR", help="write the lines and a summary of each run here")
    parser.add_argument(
        "--rulebook", metavar="NAME", help="compare both candidates of each cycle, and several recordings, by this rulebook"
    )  # fmt: skip
    parser.add_argument("--format", choices=("text", "jsonl"), default="text")


def run(args: argparse.Namespace) -> int:
    from trackmarshal.cli.collecting import seldom

    with seldom():
        return _all(args)


def _all(args: argparse.Namespace) -> int:
    from trackmarshal.cli.preferring import Runs
    from trackmarshal.cli.record import is_record, replay_record
    from trackmarshal.evaluation import load
    from trackmarshal.rulebooks.order import rulebook
    from trackmarshal.scenarios import load as load_recording

    spec_path, *more = map(Path, args.spec) if args.spec else [default_spec(find_project(args))]
    project = optional_project(args)
    status = 0
    settings = [Path(p) for p in args.settings]
    written: set[str] = set()
    order = rulebook(load([spec_path, *more], settings, project), args.rulebook) if args.rulebook else None
    compared = Runs(args.format)
    if args.mcap and len(args.scenarios) > 1:
        raise TrackmarshalError(
            "E434",
            f"`--mcap` makes one file of one record, and {len(args.scenarios)} are to be replayed",
            help="replay each by itself, with a file of its own",
        )
    for path in args.scenarios:
        if is_record(path):
            spec = load([spec_path, *more], settings, project)
            _alone(args, path)
            status = max(
                status,
                replay_record(path, spec, args.backend, args.format, args.quiet, args.mcap, args.begin),
            )
            if not args.out and order is None:
                continue
        elif args.begin is not None:
            raise TrackmarshalError(
                "E436",
                "`--from` starts in a record of a run, and this is none",
                file=path,
                help="replay it from its beginning",
            )
        elif args.mcap:
            raise TrackmarshalError(
                "E434",
                "`--mcap` exports the record of a run, and this is none",
                file=path,
                help='run it under a Supervisor that records (`tm.supervisor(spec, record="run.arrows")`, docs/supervisor.md), then '
                "`trackmarshal replay run.arrows --mcap FILE`",
            )
        recording = overruled(load_recording(path), spec_path, settings, more)
        recording = with_given(recording, args.given, args.because)
        if args.out:
            _claim(recording, written)
        evaluator = evaluator_for(
            recording, spec_path, settings, project, args.rule, args.backend or "numpy", more=more
        )
        brief = args.format == "text" and not args.out and order is None
        outcome = run_one(recording, evaluator, args.quiet, brief)
        if args.format == "jsonl":
            if not args.quiet:
                say(*by_default(outcome.recording, evaluator), file=sys.stderr)
            for line in json_lines(outcome):
                print(line)
        else:
            say(*summary(outcome, evaluator))
        if order is not None:
            say(*compared.of_candidates(order, outcome))
            compared.add(order, outcome)
        if args.out:
            from trackmarshal.cli.evidence import write_run

            write_run(Path(args.out), outcome, evaluator, json_lines(outcome))
        if not outcome.met:
            status = max(status, 1)
    say(*compared.of_all())
    return status


def _alone(args: argparse.Namespace, path: str) -> None:
    """Refuse `--from` beside what needs every cycle, and inputs and rules beside a record, which has those of its run; raises E436 and E437."""
    refuse_given(args, path)
    if args.rule and not args.out and args.rulebook is None:
        raise TrackmarshalError(
            "E437", "a record of a run has the rules of that run", file=path, help="leave out `--rule`; with `--out`, its cycles are run as a recording"
        )  # fmt: skip
    for name, given in (("--mcap", args.mcap), ("--out", args.out), ("--rulebook", args.rulebook)):
        if args.begin is not None and given:
            raise TrackmarshalError(
                "E436",
                f"`{name}` needs all cycles of the record",
                file=path,
                help=f"leave out `--from`, or `{name}`",
            )


def overruled(
    recording: Recording, spec_path: Path, settings: list[Path], more: Sequence[Path] = ()
) -> Recording:
    """The recording without the vehicle values that the command line sets: what a person says now counts more."""
    from trackmarshal.configuration import setting_names

    names = setting_names([spec_path, *more], settings)
    params = {name: value for name, value in recording.params.items() if name not in names}
    tables = {name: rows for name, rows in recording.tables.items() if name not in names}
    return replace(recording, params=params, tables=tables)


def default_spec(project: Path) -> Path:
    """The spec that the project's v-model names for replay."""
    from trackmarshal.trace import requirements

    return project / requirements.load(project, []).default_spec


class Known:
    """What recordings of one project share: evaluators, by all that they are made of, and compiled specs, by their paths and the project.

    before: specs that have been compiled already, of which those may use the same modules.
    """

    def __init__(self, before: Compiled | None = None) -> None:
        self._before = before
        self.evaluators: dict[object, Evaluator] = {}
        self._compiled: dict[object, Compiled] = {}

    def compile(self, paths: tuple[Path, ...], project: Path | None) -> Compiled:
        """The specs of these paths, read at the first call; never raises for what is wrong with them."""
        from trackmarshal.semantics.compile import compile_paths

        found = self._compiled.get((paths, project))
        if found is None:
            found = self._compiled[paths, project] = compile_paths(paths, project, self._before)
        return found


def evaluator_for(
    recording: Recording, spec_path: Path, settings: list[Path], project: Path | None, rules: list[str] | None, backend: str,
    folder: Path | None = None, more: Sequence[Path] = (), known: Known | None = None,
) -> Evaluator:  # fmt: skip
    """The chosen rules with the vehicle and track that the recording and the command line name.

    `folder` is where the recording lies, when its `source` is no path from here; `more` are specs beside the one.
    With `known`, recordings with the same specs and configuration share an evaluator, and those with the same specs what was compiled.
    """
    from trackmarshal.configuration import configured
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.fields import check_fields, declared_names
    from trackmarshal.scenarios.overrides import known_params, known_tables

    used = configuration(recording, project, folder)
    within = project or project_of(folder or Path(recording.source).parent)
    made_of = (
        (spec_path, *more),
        (*used, *settings),
        project,
        None if rules is None else tuple(rules),
        backend,
    )
    known = known or Known()
    evaluator = known.evaluators.get(made_of)
    if evaluator is None:
        spec: Spec = configured(known.compile((spec_path, *more), project), [*used, *settings], project)
        evaluator = Evaluator(spec, rules, backend, lambda: declared_names([spec, *project_specs(within)]))
        known.evaluators[made_of] = evaluator
    check_fields(recording, evaluator.spec, lambda: project_specs(within))
    tables, _ = known_tables(recording, evaluator.spec)
    try:
        given = evaluator.reader.settings(
            {"params": known_params(recording, evaluator.spec), "tables": tables}
        )
    except TrackmarshalError as error:
        error.file = error.file or recording.source
        if error.code == "D203" and PurePath(recording.source).suffix in (".yaml", ".yml"):
            # Nobody wrote these names: a vehicle whose numbers stand in a declaration overrides what the shipped ones are made of.
            error.help = f"{error.help}; a `vehicle` that stands in a declaration says itself what it overrides: `params: {{}}` in it for nothing"
        raise
    if given.broken:
        raise TrackmarshalError(
            "E403",
            given.broken[0],
            help="change the parameters in the spec, the configuration or the recording",
        )
    return evaluator


def configuration(recording: Recording, project: Path | None, folder: Path | None = None) -> list[Path]:
    """The configuration modules that a recording names, such as a track; raises E431."""
    near = folder or Path(recording.source).parent
    return [_setting(name, recording, near, project).resolve() for name in recording.use]


def _setting(name: str, recording: Recording, near: Path, project: Path | None) -> Path:
    """The configuration that a recording names: a spec of its project, or of the project at hand, or a shipped one; raises E431 and E432."""
    shipped = shipped_values(name)
    if shipped is not None and shipped.is_file():
        own = of_its_name(shipped, [near, *([] if project is None else [project])])
        if own is None:
            return shipped
        raise TrackmarshalError(
            "E432",
            f"`use` names `{name}`, which is shipped, and another module of the project",
            file=recording.source,
            help=f"name the project's own one by its path, `{Path(os.path.relpath(own, project or near)).as_posix()}`",
        )
    roots = [os.path.realpath(root) for root in (project, project_of(near) or near) if root is not None]
    folders = [] if PurePath(name).is_absolute() or "\0" in name else [near, project]
    places = [Path(os.path.realpath(folder / name)) for folder in folders if folder is not None]
    inside = [place for place in places if any(place.is_relative_to(root) for root in roots)]
    fitting = [place for place in inside if name.endswith(".spec") and place.suffix == ".spec"]
    found = next((place for place in fitting if place.is_file()), None)
    if found is not None:
        return found
    if len(fitting) < len(places) or not places:
        raise TrackmarshalError(
            "E432",
            f"`use` names `{name}`, which is no spec of the project",
            file=recording.source,
            help="name a .spec file inside the project, by a relative path, or a shipped one by its module, `vehicles.devbot`; another one is given with --with",
        )
    raise TrackmarshalError(
        "E431",
        f"`{name}` is neither beside the recording nor in the project",
        file=recording.source,
        help="correct the recording's `use`, or its place",
    )


def project_specs(project: Path | None) -> list[Spec]:
    """All specs of a project, for what they declare; whatever is wrong with them is said elsewhere."""
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.trace import requirements

    if project is None:
        return []
    named = requirements.load(project, []).specs
    return [compile_paths([project / str(path) for path in named] or [project / "specs"], project).spec]


def _claim(recording: Recording, written: set[str]) -> None:
    """Take a recording's name for the files of its run; raises E433."""
    name = recording.name
    problem = ""
    if (
        not name.strip(" .")
        or name != plain(name)
        or name.startswith(".")
        or set(name) & {"/", "\\"}
        or len(name.encode()) > 200
    ):
        problem = "is no file name"
    elif name.casefold() in written:
        problem = (
            "is the name of another one of these recordings too: one run would be written over the other"
        )
    if problem:
        raise TrackmarshalError(
            "E433",
            f"the recording's name `{name}` {problem}",
            file=recording.source,
            help="rename it in the recording's first line: a word without slashes, that begins with no dot",
        )
    written.add(name.casefold())


def run_one(
    recording: Recording, evaluator: Evaluator, quiet: bool, brief: bool = False, keep: bool = False
) -> Replay:
    """Replay with a progress bar. brief: for a `summary` alone. keep: for pages, which explain it."""
    from trackmarshal.scenarios.fields import unnamed_track
    from trackmarshal.scenarios.motion import contradictions
    from trackmarshal.scenarios.overrides import unknown_params
    from trackmarshal.scenarios.replay import replay

    if not quiet:
        unnamed = unnamed_track(recording, evaluator)
        for told in [*([unnamed] if unnamed else []), *contradictions(recording)]:
            say(f"note: {recording.name}: {told}", file=sys.stderr)
    outcome = replay(
        recording, evaluator, lambda chunks: progress(chunks, recording.name, quiet), brief, keep
    )
    unknown = [("table", name) for name in outcome.ignored]
    unknown += [("parameter", name) for name in unknown_params(recording, evaluator.spec)]
    for kind, name in () if quiet else unknown:
        say(f"note: {recording.name}: its {kind} `{name}` is unknown to the spec", file=sys.stderr)
    return outcome


def json_lines(outcome: Replay) -> list[str]:
    """One line a cycle and candidate, as replay.schema.json describes."""
    from trackmarshal.cli.record import faults_json

    lines = []
    for cycle in outcome.cycles:
        for candidate, result in cycle.results.items():
            entry: dict[str, Any] = {
                "scenario": outcome.recording.name, "t": number(cycle.t), "candidate": candidate, "safe": result.safe,
                "rules": {name: rule_json(rule) for name, rule in result.rules.items()},
                "decision": cycle.decision, "decision_from": cycle.decision_from,
            }  # fmt: skip
            if result.faults:
                entry["faults"] = list(result.faults)
            if cycle.faults:
                entry["cycle_faults"] = faults_json(cycle.faults)
            lines.append(dump(entry))
    return lines


def by_default(recording: Recording, evaluator: Evaluator) -> list[str]:
    """Lines: inputs that the recording lacks, and which rules judge the spec's default instead."""
    from trackmarshal.scenarios.inputs import defaulted

    return [
        f"not in the recording: {name}, so the spec's default is judged by {', '.join(rules)}"
        for name, rules in defaulted(recording, evaluator.spec, evaluator.rules).items()
    ]


def summary(outcome: Replay, evaluator: Evaluator) -> list[str]:
    """Lines: which rules fired when, what was driven, and how that compares with the ground truth."""
    from trackmarshal.scenarios.overrides import overrides
    from trackmarshal.scenarios.recording import CANDIDATES
    from trackmarshal.scenarios.replay import ACTIONS

    times = [cycle.t for cycle in outcome.cycles]
    rows = []
    against: dict[tuple[str, str], list[CycleOutcome]] = {}
    for cycle in outcome.cycles:
        for candidate, results in cycle.results.items():
            for one in results.against:
                against.setdefault((one.rule, candidate), []).append(cycle)
    for rule in evaluator.rules:
        for candidate in ("driving", "emergency"):
            unsafe = against.get((rule.name, candidate))
            if unsafe is None:
                continue
            worst = min(unsafe, key=lambda c: _badness(c.results[candidate].rules[rule.name]))
            result = worst.results[candidate].rules[rule.name]
            spans = _spans([c.t for c in unsafe], times)
            verdicts = "/".join(sorted({c.results[candidate].rules[rule.name].verdict for c in unsafe}))
            satisfies = ", ".join(name for name, _ in rule.satisfies)
            # Where nothing is known of a margin, what is known is the verdict.
            margin = (
                result.verdict
                if math.isnan(result.margin)
                else beside(result.margin, result.unit, result.shown) + decides(result)
            )
            where = str(result.witness.span) if result.witness and result.witness.span else result.reason
            rows.append(
                [
                    f"{rule.name} (advisory)" if rule.advisory else rule.name,
                    candidate,
                    verdicts,
                    spans,
                    f"{margin} at {moment(worst.t)} s",
                    satisfies,
                    where,
                ]
            )
    count = {kind: sum(c.decision == kind for c in outcome.cycles) for kind in ACTIONS}
    lines = [
        f"{outcome.recording.name}: {len(times)} cycles, "
        + ", ".join(f"{n} {kind}" for kind, n in count.items() if n)
    ]
    recording, spec = outcome.recording, evaluator.spec
    lines += [f"override: {one}" for one in overrides(recording, spec)]
    lines += [
        f"given in all cycles: {name} = {value:g}: {recording.because.get(name, '')}"
        for name, value in recording.given.items()
    ]
    lines += by_default(recording, evaluator)
    if rows:
        lines += table(
            rows, ["rule", "candidate", "verdict", "unsafe at s", "worst", "requirement", "decided by"]
        )
    if not outcome.fired:
        lines.append("every trajectory is safe")
    missing = [c.t for c in outcome.cycles if len(c.results) < len(CANDIDATES)]
    if missing:
        lines.append(f"a candidate is missing at {_spans(missing, times)} s")
    told = {f for c in outcome.cycles for r in c.results.values() for f in r.faults}
    faults = sorted(told | {str(f) for c in outcome.cycles for f in c.faults if not told})
    lines += [f"input: {fault}" for fault in faults[:10]] + (
        [f"input: ... {len(faults) - 10} more"] if len(faults) > 10 else []
    )
    absent = [found[1] for found in (_ABSENT.fullmatch(str(fault)) for fault in faults) if found]
    if absent and recording.source.endswith((".yaml", ".yml")):
        given = " and ".join(f"`{name}`" for name in absent)
        lines.append(f"  help: a declaration gives {given} under `signals`: docs/scenarios.md")
    for truth in outcome.truths:
        judged = f"{truth.judged} cycles judged"
        if truth.inside:
            lines.append(f"ground truth, {truth.kind}: inside ({judged})")
        else:
            lines.append(
                f"ground truth, {truth.kind}: OUTSIDE ({judged}); missed at {_spans(truth.missed, times)}, false alarm at {_spans(truth.false_alarms, times)}"
            )
    if outcome.uncovered:
        lines.append(f"no ground truth was declared of {', '.join(outcome.uncovered)}")
    if outcome.truths and outcome.unexpected:
        lines.append(f"no ground truth says that it may be unsafe at {_spans(outcome.unexpected, times)} s")
    return lines


def _badness(result: RuleResult) -> tuple[bool, float]:
    """Order of firings: violated by the most first, undefined ones (whose margin is NaN) last."""
    undefined = result.verdict == "undefined"
    return undefined, 0.0 if undefined else result.margin


def _spans(some: Sequence[float], times: Sequence[float]) -> str:
    """Those times of a run, what follows one another together: a false alarm in every cycle is one span."""
    from trackmarshal.scenarios.replay import intervals

    return (
        ", ".join(f"{moment(a)} to {moment(b)}" if a != b else moment(a) for a, b in intervals(some, times))
        or "none"
    )
