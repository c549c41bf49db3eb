"""Specs on data: load a spec, choose rules and a backend, evaluate cases. The engine behind `eval` and `replay`."""

from __future__ import annotations

import hashlib
import math
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.configuration import configured, paths_of
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.ir.margins import undecided
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.ir.straight import Fields, curvatures, straightened
from trackmarshal.runtime.contract.tracks import places_of
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings
from trackmarshal.runtime.program import SAFE_CODES, Judged, Program, Rated
from trackmarshal.runtime.verdict import Briefly, CaseResult, RuleResult

if TYPE_CHECKING:
    from trackmarshal.batches import Batch
    from trackmarshal.over_run import Run
    from trackmarshal.runs import WholeRun
    from trackmarshal.runtime.door.cases import CasesReader

#: Evaluators by name, the default first; `auto` is generated C where that can be had, else numpy.
BACKENDS = ("numpy", "reference", "c", "auto")
#: Why generated C cannot be had: a rule, a compiler or an input that it has to do without.
_NO_C = ("E470", "E471", "E472", "E473")
#: Frames that are evaluated together.
CHUNK = 500
#: Curvatures that a case lacks that lacks none.
NOWHERE: Fields = frozenset()

CODES = {
    "E401": ("unknown rule", "`--rule` names a rule or an assumption of the spec."),
    "E404": (
        "nothing to evaluate",
        "The spec has no rules, or the assumption has no `monitor`. Of nothing it could only be said that nothing is violated; that is "
        "refused, since it would read as safe.",
    ),
    "E405": (
        "unknown backend",
        "Rules are evaluated by `numpy`, by the `reference`, by generated `c`, or by `auto`: generated C where it can be had, else numpy.",
    ),
    "E406": (
        "a rule without margins by sample",
        "Margins by sample are those of a rule that is evaluated `along` a timeline, or that asks something `for all` of its samples. "
        "What asks for one sample, compares two numbers, or speaks of objects first has no margin of its own at each sample. "
        "A rule that speaks of other cycles has none for cases by themselves.",
    ),
    "E403": (
        "constraints of the spec do not hold",
        "The parameters as configured break a `constrain` of the spec; its rules would be unsound.",
    ),
}


class _OneAtATime:
    """A lock that one thread may take again; a copy is another one."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def __deepcopy__(self, _: object) -> _OneAtATime:
        return _OneAtATime()


class Evaluator:
    """Chosen rules of a spec, ready for data.

    backend: one of BACKENDS. declared: names (`objects`, `ego.kappa`) that cases may have besides those of the spec, asked for only when
    one turns up. Raises TrackmarshalError E401, E404 or E405; E470 to E472 where generated C is asked for and cannot be had.
    """

    def __init__(
        self, spec: Spec, names: Iterable[str] | None = None, backend: str = "numpy",
        declared: Callable[[], frozenset[str]] = frozenset,
    ) -> None:  # fmt: skip
        from trackmarshal.backends.results import chosen_rules

        if not isinstance(spec, Spec):
            raise wrong_type("a spec is what `load` and `loads` return", spec)
        if not callable(declared):
            raise wrong_type("`declared` is a function", declared)
        if names is not None and not isinstance(names, str):
            if not isinstance(names, Iterable):
                raise wrong_type("the rules are a list of names", names)
            names = tuple(names)  # of what can be gone through once, too
        if not isinstance(backend, str) or backend not in BACKENDS:
            help_ = close_matches(str(backend), BACKENDS) or f"there are {', '.join(BACKENDS)}"
            raise TrackmarshalError("E405", f"there is no backend `{backend!s:.40}`", help=help_)
        if isinstance(names, str):  # which is a sequence of letters
            raise TrackmarshalError(
                "E401", f"`{names}` is one text", help=f"give a list of rules: [{names!r}]"
            )
        for name in names or ():
            _check_rule(spec, name)
        self.spec = spec
        self.rules: list[RuleInfo] = chosen_rules(spec, names)
        if not self.rules:
            raise TrackmarshalError(
                "E404", "the spec has no rule to evaluate", help="without a rule, anything would be safe"
            )
        self.asked = backend
        self.declared = cache(declared)
        #: Columns that a case may leave out, without a default: what is swept along them is then swept straight.
        self._curvatures = frozenset(
            (name, column)
            for name, column in curvatures(self.rules)
            if (field := spec.signals[name].field(column)) is None or field.default is None
        )
        self._straight: dict[Fields, Evaluator] = {}
        #: This one, and those of its rules that sweep straight: they evaluate with one backend.
        self._family = [self]
        #: Held while cases are read or evaluated: reader and program keep what they are at in memory of their own.
        self.alone = _OneAtATime()

    @cached_property
    def reader(self) -> CasesReader:
        """What reads cases for the rules."""
        from trackmarshal.runtime.door.cases import CasesReader

        reads = {pair for rule in self.rules for pair in rule.reads}
        return CasesReader(self.spec, reads, self.declared, self._broken, places_of(self.spec, self.rules))

    def read(self, raw: object) -> Frame:
        """A case from plain data; raises TrackmarshalError."""
        (frame,) = self.read_all([raw])
        return frame

    def read_all(self, raws: Iterable[object]) -> list[Frame]:
        """Cases from plain data in one go: the same as `read` of each, cheaper; raises TrackmarshalError."""
        if not isinstance(raws, Iterable):
            raise wrong_type("cases are a list of them", raws)
        with self.alone:
            return self._read_all(raws)

    def _read_all(self, raws: Iterable[object]) -> list[Frame]:
        if not self._curvatures:
            return self.reader.read_all(raws)
        straight: dict[int, Frame] = {}

        def others() -> Iterator[object]:
            for place, raw in enumerate(raws):  # each is read before the next is asked for
                absent = self._absent(raw.get("signals")) if isinstance(raw, Mapping) else NOWHERE
                if absent:
                    frame = straight[place] = self._without(absent).reader.read(raw)
                    frame.straight = absent
                else:
                    yield raw

        found = self.reader.read_all(others())
        for place, frame in straight.items():  # ascending: whatever comes before it is there
            found.insert(place, frame)
        return found

    def _absent(self, *given: object) -> Fields:
        """Curvatures for which signals, by name, have no column, though they have others; null is a column."""
        if all(type(signals) is dict and self._lacks_none(signals) for signals in given):
            return NOWHERE
        held = [signals for signals in given if isinstance(signals, Mapping)]
        absent = set()
        for name, column in self._curvatures:
            columns = [signals[name] for signals in held if isinstance(signals.get(name), Mapping)]
            if columns and not any(column in one for one in columns):
                absent.add((name, column))
        return frozenset(absent)

    def _lacks_none(self, signals: dict[Any, Any]) -> bool:
        """Whether signals have all curvatures, as dicts that are nothing else: a question that takes a third of the time."""
        for name, column in self._curvatures:
            if type(columns := signals.get(name)) is not dict or column not in columns:
                return False
        return True

    def _without(self, absent: Fields) -> Evaluator:
        """The same rules for cases without some curvatures: what would follow them goes straight."""
        if absent not in self._straight:
            rules = [straightened(rule, absent) for rule in self.spec.rules]
            parts = {**{name: getattr(self.spec, name) for name in Spec.fields}, "rules": tuple(rules)}
            digest = hashlib.sha256(" ".join(rule.fingerprint for rule in rules).encode()).hexdigest()
            names = [rule.name for rule in self.rules]
            made = Evaluator(Spec(**{**parts, "fingerprint": digest}), names, self._taken, self.declared)
            made._family, made.alone = self._family, self.alone
            self._family.append(made)
            self._straight[absent] = made
        return self._straight[absent]

    def case(self, raw: object, series: bool = False) -> CaseResult:
        """One case from plain data, `{"signals": {..}}`, and what the rules say of it, with witnesses; raises TrackmarshalError."""
        with self.alone:
            (result,) = self.evaluate([self.read(raw)], series)
        return result

    def batch(
        self, signals: Mapping[str, Any], shared: Mapping[str, Any] | None = None, params: Mapping[str, Any] | None = None,
        tables: Mapping[str, Any] | None = None, places: Mapping[str, Any] | None = None,
    ) -> Batch:  # fmt: skip
        """Many cases as arrays, in declared units, and what the rules say of them.

        signals: by signal and field, arrays with an axis for cases: (cases, samples) of timelines, (cases, elements) of sets, (cases,) of
        records, and of events by themselves. A column without that axis, and a signal of which no column has it, is the same in all cases;
        so is everything in `shared`, as a case has it. params, tables and places override the spec's; a parameter may be (cases,).
        Cases pass the same door as by themselves. Raises TrackmarshalError: D202 to D205.
        """
        from trackmarshal.batches import Batch
        from trackmarshal.runtime.door.arrays import ArraysReader

        absent = self._absent(signals, shared)
        if absent:
            return self._without(absent).batch(signals, shared, params, tables, places)
        given = {"params": params, "tables": tables, "places": places}
        with self.alone:
            return Batch(self, ArraysReader(self.reader).read(signals, shared, given), CHUNK)

    def evaluate(self, frames: Iterable[Frame], series: bool = False) -> Iterator[CaseResult]:
        """The results of cases, in order, with witnesses."""
        frames = list(frames) if isinstance(frames, Iterable) else [frames]
        for frame in frames:
            if not isinstance(frame, Frame):
                raise wrong_type("a frame is what `read` makes of a case", frame)
        for start in range(0, len(frames), CHUNK):
            for judged in self.judge_all(frames[start : start + CHUNK]):
                for name, rated in judged.rated.items():
                    yield self.result(judged.about, rated, series, name)

    def over_run(self, saved: Sequence[str] | None = None) -> Run:
        """A run to which cases are given as its cycles, one after the other: rules remember.

        saved: what `Run.save` gave; the run then goes on from there. Raises TrackmarshalError D163 for a snapshot that is damaged, D164 for
        one of another spec or evaluator, E486 for an evaluator that saves none.
        """
        from trackmarshal.over_run import Run

        return Run(self, saved)

    def whole_run(
        self, params: Mapping[str, Any] | None = None, tables: Mapping[str, Any] | None = None,
        places: Mapping[str, Any] | None = None, straight: Fields = NOWHERE,
    ) -> WholeRun:  # fmt: skip
        """A run to which many cycles are given at once, as arrays: see `WholeRun.step`. Its cycles are evaluated with numpy.

        params, tables and places override the spec's, the same in all cycles. straight: curvatures (signal, column) that the arrays do not have.
        """
        from trackmarshal.runs import WholeRun
        from trackmarshal.runtime.door.arrays import ArraysReader

        if straight:
            return self._without(straight).whole_run(params, tables, places)
        given = {"params": params, "tables": tables, "places": places}
        return WholeRun(self, given, ArraysReader(self.reader).read)

    def refuse_straight(self, frame: Frame) -> None:
        """Raise TrackmarshalError D211 for a cycle of a run that lacks a curvature which rules follow: cases may, and go straight then, but no cycle
        is judged otherwise than those before it."""
        if not self.takes(frame):
            absent = sorted(frame.straight & self._curvatures)
            raise TrackmarshalError(
                "D211", f"`{absent[0][0]}.{absent[0][1]}` is not there, and rules follow it", help="in a run every cycle has it; zeros go straight"
            )  # fmt: skip

    def takes(self, frame: Frame) -> bool:
        """Whether a frame has all curvatures that rules follow, as every cycle of a run does."""
        return frame.straight.isdisjoint(self._curvatures)

    def only(self, names: Sequence[str]) -> Evaluator:
        """Some of the rules, for the frames of all."""
        return Evaluator(self.spec, names, self._taken, self.declared)

    @property
    def _taken(self) -> str:
        """The backend of others that evaluate with this one: where it has to do without generated C, they do, too."""
        return "numpy" if "program" in self.__dict__ and self.backend == "numpy" else self.asked

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        """The outcome of frames. Where `auto` chose generated C and it does not hold one of them, numpy takes over."""
        with self.alone:
            return self._judge_all(frames)

    def _judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        if not all(map(self.takes, frames)):
            return self._judge_apart(frames)
        try:
            return self.program.judge_all(frames)
        except TrackmarshalError as error:
            if self.asked != "auto" or error.code not in _NO_C:
                raise
            self._do_without_c(error)
            return self.program.judge_all(frames)

    def _judge_apart(self, frames: Sequence[Frame]) -> list[Judged]:
        """The outcome of frames some of which lack curvatures: those that are alike together."""
        alike: dict[Fields, list[int]] = {}
        for place, frame in enumerate(frames):
            alike.setdefault(frame.straight & self._curvatures, []).append(place)
        found: dict[int, Judged] = {}
        for absent, places in alike.items():
            evaluator = self._without(absent) if absent else self
            found |= zip(places, evaluator.judge_all([frames[place] for place in places]))
        return [found[place] for place in range(len(frames))]

    def result(
        self, frame: Frame, rated: Rated, series: bool = False, candidate: str = "", brief: bool = False
    ) -> CaseResult:
        """One outcome, rule by rule, with the faults of its frame, and the constraints that do not hold.

        brief: of rules that are not against it the verdict and the margin alone; what decided them is not looked for.
        """
        with self.alone:
            return self._result(frame, rated, series, candidate, brief)

    def _result(self, frame: Frame, rated: Rated, series: bool, candidate: str, brief: bool) -> CaseResult:
        faults = [
            str(f)
            for f in frame.faults
            if not candidate or f.signal not in frame.candidates or f.signal == candidate
        ]
        rules: Mapping[str, RuleResult]
        if brief:
            against = {
                self.rules[place].name: rated.explain(place, series)
                for place, code in enumerate(rated.verdicts)
                if code not in SAFE_CODES
            }
            rules = Briefly(self._in_brief, rated.verdicts, rated.margins, against)
        else:
            rules = {rule.name: rated.explain(place, series) for place, rule in enumerate(self.rules)}
        return CaseResult(frame.id, rules, tuple(faults), frame.settings.broken)

    @cached_property
    def _in_brief(self) -> dict[str, tuple[int, RuleResult]]:
        """By name each rule's number, and what it says where it does not apply, in the unit of its margin where nobody looks for what decided."""
        return {
            rule.name: (
                place,
                RuleResult(rule.name, "inactive", math.inf, undecided(rule.unit), advisory=rule.advisory),
            )
            for place, rule in enumerate(self.rules)
        }

    @property
    def sweeps(self) -> bool:
        """Whether rules follow curvatures that a case may leave out."""
        return bool(self._curvatures)

    @property
    def backend(self) -> str:
        """What evaluates: the program's own name."""
        name: str = self.identity["backend"]
        return name

    @property
    def identity(self) -> Mapping[str, Any]:
        """What rates, as a record names it. Generated C that was asked for is known without being compiled: a Supervisor that is all C has
        a program of its own, and never takes this one."""
        from trackmarshal.backends.results import identity

        if self.asked == "c":
            return identity(self.spec, "c", self.rules)
        return self.program.identity

    @cached_property
    def program(self) -> Program:
        """The compiled rules; the same program serves every batch."""
        from trackmarshal.backends import programs

        match self.asked:
            case "reference":
                return programs.reference(self.spec, self.rules)
            case "numpy":
                return programs.numpy(self.spec, self.rules)
            case "c" | "auto":
                try:
                    return programs.generated(self.spec, self.rules)
                except TrackmarshalError as error:
                    if self.asked != "auto" or error.code not in _NO_C:
                        raise
                    self._do_without_c(error)
                    return self.program
            case other:
                raise AssertionError(f"unknown backend {other}")

    def _do_without_c(self, error: TrackmarshalError) -> None:
        from trackmarshal.backends import programs

        _say_why(error)
        for each in self._family:
            each.__dict__["program"] = programs.numpy(each.spec, each.rules)

    def _broken(self, settings: Settings) -> tuple[str, ...]:
        return broken_constraints(self.spec, settings)


def _check_rule(spec: Spec, name: object) -> None:
    """Raise E401 or E404 for what is no rule of a spec, or has nothing to evaluate."""
    if not isinstance(name, str):
        raise wrong_type("the name of a rule is a text", name)
    rule = spec.rule(name)
    if rule is None:
        known = [rule.name for rule in spec.rules]
        raise TrackmarshalError(
            "E401",
            f"the spec has no rule `{name}`",
            help=close_matches(name, known) or ", ".join(known),
        )
    if rule.formula is None:
        raise TrackmarshalError(
            "E404", f"`{name}` has no condition to evaluate", help="add a `monitor` to the assumption"
        )


def broken_constraints(spec: Spec, settings: Settings = NO_SETTINGS) -> tuple[str, ...]:
    """Constraints of a spec that do not hold with its own values, or with those of settings: nothing evaluated with them is safe."""
    from trackmarshal.backends.reference.evaluator import Reference

    values = Reference(spec, Frame(settings=settings))
    broken = []
    for constraint in spec.constraints:
        # What reads names that there are not is an error of the spec, and no rule that reads it is evaluated.
        if not spec.declares(constraint.formula):
            continue
        if values.truth(constraint.formula, {}).verdict != "satisfied":
            because = f": {constraint.because}" if constraint.because else ""
            broken.append(
                f"{constraint.span} `{constraint.span.text.split('because')[0].strip()}` does not hold{because}"
            )
    return tuple(broken)


def _say_why(error: TrackmarshalError) -> None:
    """Tell the user who let us choose why it is not generated C."""
    reason = " ".join(error.message.split())
    print(f"note: numpy evaluates instead of generated C: {reason} [{error.code}]", file=sys.stderr)


def load(
    paths: str | Path | Iterable[str | Path],
    configuration: str | Path | Iterable[str | Path] = (),
    shown_from: Path | None = None,
) -> Spec:
    """Compile files and folders, with the values of configuration modules put in; raises Diagnostics."""
    from trackmarshal.semantics.compile import compile_paths

    _check_shown_from(shown_from)
    given = paths_of(paths)
    if not given:  # as of a pattern that fits nothing: a spec without rules would find nothing wrong
        raise TrackmarshalError(
            "E006", "there is no file to load", help="name a .spec file, or a folder with some"
        )
    return configured(compile_paths(given, shown_from), configuration, shown_from)


def loads(
    text: str, configuration: str | Path | Iterable[str | Path] = (), shown_from: Path | None = None
) -> Spec:
    """Compile a spec that is a text, in messages `<text>`, with the values of configuration modules put in; raises Diagnostics.

    It uses modules as a file of the current folder would: those below the folder, and those of the prelude.
    """
    from trackmarshal.semantics.compile import compile_text

    if not isinstance(text, str):
        raise wrong_type("the text of a spec is a text (`load` reads files)", text)
    _check_shown_from(shown_from)
    return configured(compile_text(text, shown_from), configuration, shown_from)


def _check_shown_from(folder: Path | None) -> None:
    if folder is not None and not isinstance(folder, (str, Path)):
        raise wrong_type("`shown_from` is a folder", folder)
