"""The compiled rules as Python runs them: the surface of the numpy program, the arithmetic of the reference."""

from __future__ import annotations

import ctypes
import math
from array import array
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from typing import Any

from trackmarshal.backends.c.capacities import capacities
from trackmarshal.backends.c.glue import Flat, flat
from trackmarshal.backends.c.library import Library, Result, fitting
from trackmarshal.backends.c.over_run.numbering import Numbering, lasting
from trackmarshal.backends.c.placing import PlaceSetter
from trackmarshal.backends.c.source import generated
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.over_run.lives import Without
from trackmarshal.backends.results import Outcomes, Stateless, rated
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings
from trackmarshal.runtime.program import Rated
from trackmarshal.runtime.verdict import VERDICTS, RuleResult


def _refused(case: Frame, status: int) -> TrackmarshalError:
    return TrackmarshalError("E473", f"the program refuses the input of case {case.id!r} (status {status})")


class CProgram(Stateless):
    """The compiled rules; `run` evaluates them on cases. Raises TrackmarshalError E470 to E473."""

    backend = "c"

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        super().__init__(spec, rules)
        self.source = generated(spec, rules)
        self.rules = self.source.plan.rules
        self.order: Flat = flat(self.source)
        self._kinds = set(capacities(self.source.plan))
        self._numbers = {rule.name: index for index, rule in enumerate(self.rules)}
        self._params = {name: index for index, name in enumerate(self.source.plan.params)}
        self._tables = {name: index for index, name in enumerate(self.source.plan.tables)}
        self._changed: set[str] = set()
        self._library: Library | None = None
        self._places: PlaceSetter | None = None
        self._numpy: NumpyProgram | None = None
        self.numbering = Numbering(lasting(spec))

    def outcomes(self, frames: Sequence[Frame]) -> list[Outcomes]:
        """What decided is not kept by generated code: where it is asked for, numpy's program looks for it."""
        verdicts, margins = self.run(frames)
        views = _Views(self._numpy_program, frames)
        width = len(self.rules)
        found = []
        for index, frame in enumerate(frames):
            part = slice(index * width, (index + 1) * width)
            codes, own = bytearray(verdicts[part].tobytes()), list(margins[part])
            for place, rule in enumerate(self.rules):
                if frame.faults and frame.unusable(rule.reads) is not None:
                    codes[place], own[place] = _UNDEFINED, math.nan
            values = partial(views.of, index)
            one = rated(self.rules, frame, values, bytes(codes), own)
            found.append(
                Outcomes(Rated(one.verdicts, one.margins, self._explained(one, frame), one.advisory), values)
            )
        return found

    def run(self, frames: Sequence[Frame]) -> tuple[array[int], array[float]]:
        """Codes and margins of all rules on all frames, one frame after the other."""
        count = len(self.rules)
        margins, verdicts = array("d", bytes(8 * count * len(frames))), array("b", bytes(count * len(frames)))
        for index, frame in enumerate(frames):
            self._one(
                frame, margins.buffer_info()[0] + 8 * count * index, verdicts.buffer_info()[0] + count * index
            )
        return verdicts, margins

    def _explained(self, one: Rated, frame: Frame) -> Callable[[int, bool], RuleResult]:
        """Explains with the series of generated code."""

        def explain(number: int, series: bool = False) -> RuleResult:
            result = one.explain(number, series)
            rule = self.rules[number]
            if result.series is None or frame.unusable(rule.reads) is not None:
                return result
            return replace(result, series=self.along(frame, rule))

        return explain

    def _numpy_program(self) -> NumpyProgram:
        if self._numpy is None:
            self._numpy = NumpyProgram(self.spec, self.rules)
        return self._numpy

    def number(self, rule: RuleInfo) -> int:
        """The place of a rule among the results."""
        return self._numbers[rule.name]

    def library_for(
        self, samples: int = 0, elements: int = 0, border: int = 0, place: int = 0, knots: int = 0
    ) -> Library:
        """The library, with a new context where the one at hand holds less than this."""
        wanted = {
            "TM_MAX_SAMPLES": samples,
            "TM_MAX_ELEMENTS": elements,
            "TM_MAX_BORDER": border,
            "TM_MAX_PLACE": place,
            "TM_MAX_KNOTS": knots,
            "TM_MAX_RATE": 0,
        }
        have = self._library
        if have is not None and all(have.sizes[name] >= wanted[name] for name in self._kinds):
            return have
        made = Library(self.source, fitting(self.source, wanted, have))
        if have is not None and self.order.timed:
            made.take_over(have)
        self._library = made  # not before: where there is none so large, the run goes on in the one at hand
        self._changed.clear()
        self._places = PlaceSetter(self.source.plan, self._library) if self.source.plan.shapes else None
        return self._library

    def room_for(self, frames: Sequence[Frame]) -> None:
        """Begin with memory for as many elements as one of these frames has."""
        counts = (self._count(frame, name) for frame in frames for name in self.order.ids)
        self.library_for(elements=max(counts, default=0))

    def reset(self, lib: Library) -> None:
        """Put the spec's own parameters and tables back."""
        self._override(NO_SETTINGS, lib, self._changed)
        self._changed.clear()

    def anew(self) -> CProgram:
        """The same program, which remembers nothing yet."""
        made = copy(self)
        made._changed, made._library, made._places = set(), None, None
        made.numbering = Numbering(lasting(self.spec))
        return made

    def remember(self, frame: Frame, driven: bool) -> None:
        """A frame is past, as it was driven. Raises TrackmarshalError E473 where more come than windows have room for."""
        lib, (counts, columns, numbers, flags, *_) = self._prepared(frame)
        if lib.dll.tmg_remember(lib.context, counts, columns, numbers, flags, driven):
            raise TrackmarshalError(
                "E473", f"windows over the run have room for {lib.sizes['TM_MAX_RATE']} cycles a second"
            )
        self.numbering.settle(frame.t)

    def skip(self, cycles: int) -> None:
        """Cycles were refused, or did not come."""
        if self._library is not None:
            self._library.dll.tmg_missed(self._library.context, cycles)

    def about(self, rule: RuleInfo, ended: bool = False) -> list[tuple[int, str, float, bool]]:
        """Of a rule that looks ahead, what it said in the frame that ran last: the cycle's number in the run, verdict, margin, and whether
        that is final. ended: of what was open after the last cycle, as none will come."""
        lib = self._library
        place = [one.name for one in self.source.plan.future.rules].index(rule.name)
        if lib is None:
            return []
        if ended:
            lib.dll.tmg_end(lib.context)
        room = int(lib.dll.tmg_room())
        number, margin = (ctypes.c_uint64 * room)(), (ctypes.c_double * room)()
        verdict, final = (ctypes.c_byte * room)(), (ctypes.c_byte * room)()
        found = lib.dll.tmg_about(lib.context, place, int(ended), number, verdict, margin, final)
        return [(number[k], VERDICTS[verdict[k]], margin[k], bool(final[k])) for k in range(found)]

    def without(self, frame: Frame) -> Without:
        """The elements of the frame that ran last for which there was no place."""
        found = dict[str, tuple[int, list[str]]]()
        for number, name in enumerate(self.source.plan.lasting):
            lib, ids = self.library_for(), frame.columns[name].ids[: self._count(frame, name)]
            lost = [each for at, each in enumerate(ids) if lib.dll.tmg_without(lib.context, number, at)]
            found[name] = self.spec.signals[name].capacity or 0, sorted(lost)
        return found

    def present(self) -> tuple[int, int]:
        """The numbers, in the run, of the oldest cycle that rules that look ahead keep, and of the present one."""
        lib = self._library
        return (0, 0) if lib is None else (lib.dll.tmg_oldest(lib.context), lib.dll.tmg_present(lib.context))

    def remembered(self) -> tuple[bytes, dict[str, dict[str, int]], int]:
        """What is kept from one cycle to the next: the bytes, the numbers of ids, and the number that comes next."""
        lib = self.library_for()
        start, size = lib.dll.tmg_remembered(), lib.dll.tmg_remembered_size()
        return (ctypes.string_at(lib.context + start, size), *self.numbering.taken())

    @property
    def elements(self) -> int:
        """How many elements of a set there is memory for; 0 where none is known again."""
        return self.library_for().sizes["TM_MAX_ELEMENTS"] if self.source.plan.named else 0

    def put_back(
        self, data: bytes, numbers: dict[str, dict[str, int]], following: int, elements: int
    ) -> None:
        """Go on from what was remembered, in memory for so many elements. Raises ValueError for bytes that are not of this program."""
        if elements > len(data):
            raise ValueError("each element takes more than a byte")
        lib = self.library_for(elements=elements)
        if len(data) != lib.dll.tmg_remembered_size():
            raise ValueError("these are not the bytes of this program")
        ctypes.memmove(lib.context + lib.dll.tmg_remembered(), data, len(data))
        self.numbering.put(numbers, following)

    def _one(self, case: Frame, margins: int, verdicts: int) -> None:
        lib, (counts, columns, numbers, flags, *_) = self._prepared(case)
        status = lib.dll.tmg_run(lib.context, 1, counts, columns, numbers, flags, margins, verdicts)
        if status != 0:
            raise _refused(case, status)

    def along(self, case: Frame, rule: RuleInfo) -> tuple[list[str], list[float]]:
        """Verdict and margin of a rule's formula at every sample of its timeline."""
        assert rule.along is not None
        lib, (counts, columns, numbers, flags, *_) = self._prepared(case)
        found = (Result * case.count(rule.along.signal))()
        status = lib.dll.tmg_along(lib.context, self.number(rule), counts, columns, numbers, flags, found)
        if status != 0:
            raise _refused(case, status)
        return [VERDICTS[result.verdict] for result in found], [result.margin for result in found]

    def _prepared(self, case: Frame) -> tuple[Library, tuple[Any, ...]]:
        """A library that holds the case, configured for it, and the addresses of its input; the rest keeps them alive."""
        order = self.order
        counts = [self._count(case, name) for name in order.counts]
        sequences = [n for n, name in zip(counts, order.counts) if self.spec.signals[name].sequence]
        elements = [n for n, name in zip(counts, order.counts) if not self.spec.signals[name].sequence]
        knots = max((len(rows[0]) for rows in case.settings.tables.values()), default=0)
        borders = [points for pairs in case.lanes.values() for pair in pairs for points in pair]
        border = max((len(points) for points in (*case.lines.values(), *borders)), default=0)
        place = max((len(points) for points in case.settings.places.values()), default=0)
        lib = self.library_for(max(sequences, default=0), max(elements, default=0), border, place, knots)
        self._configure(case, lib)
        kept = [_column(case, name, field) for name, field, _ in order.columns]
        for name in order.ids:
            count = self._count(case, name)
            ids = case.columns[name].ids if count else ()
            if len(ids) != count:
                raise TrackmarshalError(
                    "E473", f"not every element of `{name}` in case {case.id!r} has an id"
                )
            kept.append(self.numbering.of(name, ids))
        stamp = [math.nan if case.t is None else case.t] if order.timed else []
        given = (
            array("Q", counts),
            array("Q", [column.buffer_info()[0] for column in kept]),
            array("d", [*(case.value(name, field) for name, field in order.numbers), *stamp]),
            array("b", [_flag(case.flag(name, field)) for name, field in order.flags]),
        )
        return lib, (*(numbers.buffer_info()[0] for numbers in given), given, kept)

    def _count(self, case: Frame, name: str) -> int:
        """How many samples or elements a signal has; none where there are more than it declares, as its rules are undefined then."""
        count, most = case.count(name), self.spec.signals[name].capacity
        return 0 if most is not None and count > most else count

    def _configure(self, case: Frame, lib: Library) -> None:
        """Put a case's overrides into the context, and the spec's own values where the case before had others."""
        settings = case.settings
        self._override(settings, lib, self._changed | settings.params.keys() | settings.tables.keys())
        self._changed = {*settings.params, *settings.tables}
        if self._places is not None:
            self._places.put(case)

    def _override(self, settings: Settings, lib: Library, names: set[str]) -> None:
        for name in names:
            if name in self._params:
                lib.dll.tmg_set_param(
                    lib.context, self._params[name], settings.params.get(name, self.spec.params[name].value)
                )
            elif name in self._tables:
                info = self.spec.tables[name]
                rows = settings.tables.get(name, (info.knots, info.values))
                knots, values = array("d", rows[0]), array("d", rows[1])
                if lib.dll.tmg_set_table(
                    lib.context,
                    self._tables[name],
                    knots.buffer_info()[0],
                    values.buffer_info()[0],
                    len(knots),
                ):
                    raise TrackmarshalError("E473", f"the program refuses table `{name}`")


class _Views:
    """The values of all formulas on frames, as numpy computes them: once for all rules of a frame, and once for all frames as soon as a
    second one is asked about, since who explains two of them explains most."""

    def __init__(self, program: Callable[[], NumpyProgram], frames: Sequence[Frame]) -> None:
        self._program, self._frames = program, frames
        self._known: dict[int, CaseView] = {}

    def of(self, place: int) -> CaseView:
        """Of the frame at a place."""
        if place not in self._known:
            # The first one is looked at alone: of many frames often one is asked about, that which is unsafe.
            frames = {place: self._frames[place]} if not self._known else dict(enumerate(self._frames))
            run = self._program().run(list(frames.values()))
            self._known = {place: CaseView(run, index) for index, place in enumerate(frames)}
        return self._known[place]


def _column(frame: Frame, signal: str, field: str) -> Any:
    """A column as C takes it; never without memory, so that its address is one."""
    columns = frame.columns[signal]
    if field in columns.names.flags:
        return array("b", columns.column(field).tolist() or [0])
    return array("d", columns.listed(field) or [0.0])


def _flag(value: bool | None) -> int:
    return -1 if value is None else int(value)


#: Its place in VERDICTS.
_UNDEFINED = VERDICTS.index("undefined")
