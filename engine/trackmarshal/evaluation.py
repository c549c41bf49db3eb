"""Specs on data: load a spec, choose rules and a backend, evaluate cases. The engine behind `eval` and `replay`."""

from __future__ import annotations

import hashlib
import math
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, cached_property
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.ir.margins import undecided
from trackmarshal.ir.spec import ParamInfo, PlaceInfo, RuleInfo, Spec, TableInfo, short_name
from trackmarshal.ir.straight import Fields, curvatures, straightened
from trackmarshal.runtime import saving
from trackmarshal.runtime.contract.tracks import places_of
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings
from trackmarshal.runtime.program import SAFE_CODES, Judged, Program, Rated
from trackmarshal.runtime.stamps import stamp_after
from trackmarshal.runtime.verdict import About, Briefly, CaseResult, RuleResult

if TYPE_CHECKING:
    from trackmarshal.batches import Batch
    from trackmarshal.runs import WholeRun
    from trackmarshal.runtime.door.cases import CasesReader
    from trackmarshal.semantics.compile import Compiled
    from trackmarshal.syntax import ast

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
    "E402": (
        "a configuration that does not fit",
        "A configuration is a module whose parameters, tables, zones and lines replace those of the same name in the spec; each "
        "must exist there, in one module of those that rules read, with the same unit's dimension, and lie inside the range that the spec declares. Rules, constraints and whatever "
        "else demands something would not be in force there, and are refused.",
    ),
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
            names, known = [rule.name for rule in self.rules], "program" in self.__dict__
            made = Evaluator(
                Spec(**{**parts, "fingerprint": digest}), names, self.backend if known else self.asked, self.declared
            )  # fmt: skip
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
        absent = sorted(frame.straight & self._curvatures)
        if absent:
            raise TrackmarshalError(
                "D211", f"`{absent[0][0]}.{absent[0][1]}` is not there, and rules follow it", help="in a run every cycle has it; zeros go straight"
            )  # fmt: skip

    def only(self, names: Sequence[str]) -> Evaluator:
        """Some of the rules, for the frames of all."""
        return Evaluator(self.spec, names, self.asked, self.declared)

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        """The outcome of frames. Where `auto` chose generated C and it does not hold one of them, numpy takes over."""
        with self.alone:
            return self._judge_all(frames)

    def _judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        if not all(frame.straight.isdisjoint(self._curvatures) for frame in frames):
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
        match self.asked:
            case "reference":
                return self._reference()
            case "numpy":
                return self._numpy()
            case "c" | "auto":
                try:
                    made = self._generated()
                except TrackmarshalError as error:
                    if self.asked != "auto" or error.code not in _NO_C:
                        raise
                    self._do_without_c(error)
                    return self.program
                return made
            case other:
                raise AssertionError(f"unknown backend {other}")

    def _generated(self) -> Program:
        from trackmarshal.backends.c.over_run.program import CRemembering
        from trackmarshal.backends.c.program import CProgram
        from trackmarshal.backends.over_run.program import remembers

        made = (CRemembering if any(map(remembers, self.rules)) else CProgram)(self.spec, self.rules)
        made.library_for()
        return made

    def _reference(self) -> Program:
        from trackmarshal.backends.over_run.program import Remembering, remembers
        from trackmarshal.backends.reference.evaluator import ReferenceProgram
        from trackmarshal.backends.reference.over_run import KeepingAll

        if not any(map(remembers, self.rules)):
            return ReferenceProgram(self.spec, self.rules)
        return Remembering(self.spec, self.rules, ReferenceProgram, KeepingAll)

    def _numpy(self) -> Program:
        from trackmarshal.backends.numpy.program import NumpyProgram
        from trackmarshal.backends.over_run.program import Remembering, remembers
        from trackmarshal.backends.over_run.streaming import Streaming

        if not any(map(remembers, self.rules)):
            return NumpyProgram(self.spec, self.rules)
        return Remembering(self.spec, self.rules, NumpyProgram, Streaming)

    def _do_without_c(self, error: TrackmarshalError) -> None:
        _say_why(error)
        for each in self._family:
            each.__dict__["program"] = each._numpy()

    def _broken(self, settings: Settings) -> tuple[str, ...]:
        return broken_constraints(self.spec, settings)


class Run:
    """Cases as the cycles of one run. `step` takes them in order; `end` says what was open after the last one."""

    def __init__(self, evaluator: Evaluator, saved: Sequence[str] | None = None) -> None:
        self._evaluator = evaluator
        self._memory = evaluator.program.start()
        self._last: int | None = None
        if saved is not None:
            self._restore(saved)

    def save(self) -> list[str]:
        """What the rules remember now, as lines of JSON (docs/memory.md). Raises TrackmarshalError E486 for an evaluator that saves none, and
        for a cycle whose name is neither a whole number nor a text."""
        kind, of = self._of()
        pieces: list[saving.Piece] = [["run", self._last]]
        return saving.whole(
            saving.Saving(kind, of, chain(pieces, saving.save(self._evaluator.program, self._memory)))
        )

    def _restore(self, saved: Sequence[str]) -> None:
        pieces = saving.opened(saved, *self._of())
        try:
            (last,) = pieces.next("run", 1)
            self._last = None if last is None else saving.checked(last, int)
            self._memory = saving.restored(self._evaluator.program, pieces)
            pieces.end()
        except saving.NOT_SAVED as error:
            raise saving.damaged(str(error)) from error

    def _of(self) -> tuple[str, str]:
        """Who can restore it, and the hash of all that it rests on."""
        program = self._evaluator.program
        kind, words = saving.kept_by(program)
        return kind, saving.meaning(program.spec, [rule.name for rule in program.rules], words, more="run")

    def step(self, frame: Frame, series: bool = False) -> CaseResult:
        """The result of the next cycle. Raises TrackmarshalError D206 for a stamp that is none, or not after the last one, D211 for a curvature that
        is not there."""
        with self._coming(frame):
            program = self._evaluator.program
            judged = program.judge(self._memory, frame)
            self._memory = program.commit(self._memory, frame, None)
            ((_, rated),) = judged.rated.items()
            return self._evaluator.result(frame, rated, series)

    def remember(self, frame: Frame) -> None:
        """The next cycle, of which only what is remembered of it is asked. Raises TrackmarshalError as `step`."""
        with self._coming(frame):
            self._memory = self._evaluator.program.commit(self._memory, frame, None)

    @contextmanager
    def _coming(self, frame: Frame) -> Iterator[None]:
        """With a frame that can follow."""
        if not isinstance(frame, Frame):
            raise wrong_type("a frame is what `Evaluator.read` makes of a case", frame)
        self._evaluator.refuse_straight(frame)
        with self._evaluator.alone:
            self._last = stamp_after(frame, self._last)
            yield

    def missed(self) -> None:
        """A cycle that could not be read: a gap."""
        self._memory = self._evaluator.program.missed(self._memory)

    def end(self) -> Mapping[str, tuple[About, ...]]:
        """By rule, what is said of cycles that were open."""
        return self._evaluator.program.end(self._memory)


def broken_constraints(spec: Spec, settings: Settings = NO_SETTINGS) -> tuple[str, ...]:
    """Constraints of a spec that do not hold with its own values, or with those of settings: nothing evaluated with them is safe."""
    from trackmarshal.backends.reference.evaluator import Reference

    values = Reference(spec, Frame(settings=settings))
    broken = []
    for constraint in spec.constraints:
        if not spec.declares(
            constraint.formula
        ):  # that is an error of the spec, and no rule that reads it is evaluated
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
    given = _paths(paths)
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


def configured(
    compiled: Compiled, configuration: str | Path | Iterable[str | Path], shown_from: Path | None
) -> Spec:
    """A compiled spec with the values of configuration modules put in; raises Diagnostics for what is wrong with any of them."""
    compiled.raise_errors()
    spec = compiled.spec
    for path in _paths(configuration):
        spec = configure(spec, _settings(path, shown_from, compiled))
    return spec


def _paths(given: str | Path | Iterable[str | Path]) -> list[Path]:
    """One path or several; raises TypeError."""
    paths = [given] if isinstance(given, (str, Path)) else given
    if not isinstance(paths, Iterable):
        raise wrong_type("files and folders are a path or a list of paths", given)
    paths = list(paths)
    for path in paths:
        if not isinstance(path, (str, Path)):
            raise wrong_type("a path is a text or a `Path`", path)
    return [Path(path) for path in paths]


def _check_shown_from(folder: Path | None) -> None:
    if folder is not None and not isinstance(folder, (str, Path)):
        raise wrong_type("`shown_from` is a folder", folder)


def _settings(path: Path, shown_from: Path | None, compiled: Compiled) -> Spec:
    """What a configuration module sets; raises Diagnostics, and E402 for what it holds that would be left out.

    Modules of the spec that it uses are in force already, with the values that they have there.
    """
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.semantics.modules import from_prelude

    made = compile_paths([path], shown_from)
    made.raise_errors()
    known = {module.path.resolve() for module in compiled.library.modules.values()}
    own = [module for module in made.library.modules.values() if module.path.resolve() not in known]
    _refuse_ignored([module.tree for module in own if not from_prelude(module)])
    files = {module.file.path for module in (*own, *(made.library.modules[name] for name in made.asked))}
    params, tables, places = made.spec.params, made.spec.tables, made.spec.places
    return Spec(
        {},
        {},
        {name: info for name, info in params.items() if info.span.file.path in files},
        {name: info for name, info in tables.items() if info.span.file.path in files},
        {name: info for name, info in places.items() if info.span.file.path in files},
        (),
        (),
        (),
        made.spec.fingerprint,
    )


def _refuse_ignored(trees: Sequence[ast.Module]) -> None:
    """Refuse everything in configuration modules that demands something, or means to: only values of theirs are used."""
    from trackmarshal.syntax import ast

    items = [item for tree in trees for item in tree.items]
    values = [
        item
        for item in items
        if isinstance(item, (ast.Param, ast.ParamRecord, ast.Table, ast.Place, ast.Define))
    ]
    nodes = [node for item in values for node in item.walk()]
    called = {node.function for node in nodes if isinstance(node, ast.Call)}
    called |= {node.name for node in nodes if isinstance(node, ast.Name)}
    for item in items:
        match item:
            case (
                ast.ModuleName()
                | ast.Use()
                | ast.Reference()
                | ast.Param()
                | ast.ParamRecord()
                | ast.Table()
                | ast.Place()
            ):
                continue
            case ast.Define():
                if item.name in called:
                    continue
                what = f"the {item.keyword} `{item.name}`"
            case ast.Rule():
                what = f"the rule `{item.name}`"
            case ast.Assume():
                what = f"the assumption `{item.name}`"
            case ast.Constrain():
                what = "a `constrain`"
            case ast.Shape():
                what = f"the shape `{item.name}`"
            case ast.Scale():
                what = "a `scale`"
            case ast.Signal():
                what = f"the signal `{item.name}`"
            case ast.Event():
                what = f"the event `{item.name}`"
            case ast.Course():
                what = f"the course `{item.name}`"
            case ast.Enum():
                what = f"the enumeration `{item.name}`"
            case ast.Stretch():
                what = f"the stretch `{item.name}`"
            case ast.State():
                what = f"the state `{item.name}`"
            case ast.Rulebook():
                what = f"the rulebook `{item.name}`"
            case ast.Test():
                what = f"a test of `{item.rule}`"
            case _:
                raise AssertionError(f"unknown declaration {type(item).__name__}")
        raise TrackmarshalError(
            "E402",
            f"a configuration holds {what}, which would not be in force",
            file=item.span.file.path,
            line=item.span.line,
            help="a configuration only sets values; move it to the spec, or name this file as a part of the spec",
        )


def setting_names(paths: Iterable[Path], configuration: Sequence[Path]) -> set[str]:
    """The names of everything that configuration modules set in a spec, in full and as in its module; raises as `load` does."""
    from trackmarshal.semantics.compile import compile_paths

    if not configuration:
        return set()
    compiled = compile_paths(paths)
    compiled.raise_errors()
    found = [_settings(path, None, compiled) for path in configuration]
    short = {
        short_name(info)
        for settings in found
        for kind in (settings.params, settings.tables, settings.places)
        for info in kind.values()
    }
    own = compiled.spec
    infos = (info for kind in (own.params, own.tables, own.places) for info in kind.values())
    return short | {info.name for info in infos if short_name(info) in short}


def configure(spec: Spec, settings: Spec) -> Spec:
    """The spec with the values of another module's parameters, tables and places in place of its own."""
    params, tables, places = dict(spec.params), dict(spec.tables), dict(spec.places)
    kinds: tuple[tuple[str, dict[str, Any], Mapping[str, Any]], ...] = (
        ("parameter", params, settings.params), ("table", tables, settings.tables), ("place", places, settings.places)
    )  # fmt: skip
    for kind, target, source in kinds:
        for info in source.values():
            _refuse_several(spec, kind, target, info)
            _replace(kind, target, info)
    digest = hashlib.sha256(spec.fingerprint.encode())
    for setting in (*params.values(), *tables.values(), *places.values()):
        digest.update(repr(setting).encode())
    return Spec(
        spec.signals,
        spec.events,
        params,
        tables,
        places,
        spec.constraints,
        spec.rules,
        spec.rulebooks,
        digest.hexdigest(),
        spec.scales,
        spec.courses,
    )


def _ways(info: TableInfo) -> list[Any]:
    """What a configuration cannot change of a table: how many arguments it has, of which dimension the second is, and how it is read."""
    from trackmarshal.units import parse_unit

    second = info.across
    axes = (
        [(info.way, None)] if second is None else [(info.way, None), (second.way, parse_unit(second.unit)[2])]
    )
    return [(way.steps, way.clamped, way.length > 0.0, dimension) for way, dimension in axes]


def _refuse_several(
    spec: Spec, kind: str, target: Mapping[str, ParamInfo | TableInfo | PlaceInfo], info: ParamInfo | TableInfo | PlaceInfo
) -> None:  # fmt: skip
    """Raise E402 for a name of several declarations that rules read: which of them is meant, nobody can tell, as of data (D203)."""
    short = short_name(info)
    # The configuration may be a module of the spec; another file of that module's name is none.
    itself = info.span.file.text
    meant = [
        name for name, old in target.items() if short_name(old) == short and old.span.file.text != itself
    ]
    if len(meant) < 2:  # mostly
        return
    from trackmarshal.ir import nodes as ir

    read = {
        node.table if isinstance(node, ir.Lookup | ir.GridLookup) else node.name
        for rule in spec.rules
        for formula in (rule.formula, rule.active)
        if formula is not None
        for node in ir.below(formula)
        if isinstance(node, ir.Param | ir.Lookup | ir.GridLookup | ir.Area | ir.Line)
    }
    several = sorted(read.intersection(meant))
    if len(several) > 1:
        raise TrackmarshalError(
            "E402",
            f"{kind} `{short}` is declared in several modules: {' and '.join(f'`{name}`' for name in several)}",
            file=f"{info.span.file.path}",
            line=info.span.line,
            help="rename all but the one that the configuration is to replace",
        )


def _replace(kind: str, target: dict[str, Any], info: ParamInfo | TableInfo | PlaceInfo) -> None:
    from trackmarshal.units import parse_unit

    short = short_name(info)
    matches = [known for known, old in target.items() if short_name(old) == short]
    place = f"{info.span.file.path}"
    if not matches:
        shorts = [short_name(old) for old in target.values()]
        raise TrackmarshalError(
            "E402",
            f"the spec declares no {kind} `{short}`",
            file=place,
            line=info.span.line,
            help=close_matches(short, shorts) or f"it declares {', '.join(shorts) or 'none'}",
        )
    for match in matches:
        old = target[match]
        problem = ""
        if isinstance(info, ParamInfo):
            low, high = old.lower, old.upper
            if parse_unit(info.unit)[2] != parse_unit(old.unit)[2]:
                problem = f"`{short}` is in {info.unit}, the spec declares it in {old.unit}"
            elif (low is not None and info.value < low) or (high is not None and info.value > high):
                problem = f"`{short}` is outside the range declared at {old.span}"
            new: Any = ParamInfo(match, info.value, old.unit, low, high, info.source, info.span, old.record)
        elif isinstance(info, TableInfo):
            if [parse_unit(u)[2] for u in info.units] != [parse_unit(u)[2] for u in old.units]:
                problem = f"table `{short}` has other units than the one declared at {old.span}"
            elif _ways(info) != _ways(old):
                problem = f"table `{short}` is read in another way than the one declared at {old.span}"
            new = TableInfo(match, info.knots, info.values, old.units, info.span, info.way, info.across)
        elif isinstance(info, PlaceInfo):
            if info.kind != old.kind:
                problem = f"`{short}` is a {info.kind}, the spec declares a {old.kind}"
            new = PlaceInfo(match, info.kind, info.points, info.span, info.track)
        else:
            raise AssertionError(f"unknown setting {type(info).__name__}")
        if problem:
            help_ = "a configuration changes values, within what the spec declares"
            raise TrackmarshalError("E402", problem, file=place, line=info.span.line, help=help_)
        target[match] = new
