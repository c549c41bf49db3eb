"""The compiled rules as Python runs them: the surface of the numpy program, the arithmetic of the reference."""

from __future__ import annotations

import ctypes
import math
from array import array
from collections.abc import Iterator, Sequence
from typing import Any

from trackmarshal.backends.c.build import library
from trackmarshal.backends.c.glue import Flat, flat
from trackmarshal.backends.c.header import CAPACITIES, capacities
from trackmarshal.backends.c.places import PlaceSetter
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.numpy.program import Program, Run
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.verdict import VERDICTS, CaseResult

#: Sizes that programs are compiled with. Series cost memory for every sample, bounds of loops do not.
_CLASSES = (256, 4096, 65536, 1 << 20, 1 << 24)
_FREE = 1 << 24


class Library:
    """One compiled program with a context: what the binding exports, typed."""

    def __init__(self, source: Source, sizes: dict[str, int]) -> None:
        self.sizes = sizes
        self.dll = ctypes.CDLL(str(library(source, sizes)))
        size, pointer, number = ctypes.c_size_t, ctypes.c_void_p, ctypes.c_double
        self.dll.tmg_size.restype = size
        for name, kinds in {
            "tmg_init": [pointer],
            "tmg_set_param": [pointer, size, number],
            "tmg_set_table": [pointer, size, pointer, pointer, size],
            "tmg_set_place": [pointer, size, pointer, size, pointer, size, ctypes.c_int],
            "tmg_run": [pointer, size, pointer, pointer, pointer, pointer, pointer, pointer],
            "tmg_along": [pointer, size, pointer, pointer, pointer, pointer, pointer],
        }.items():
            getattr(self.dll, name).argtypes = kinds
            getattr(self.dll, name).restype = ctypes.c_int
        bytes_ = self.dll.tmg_size()
        self._memory = ctypes.create_string_buffer(bytes_ + 64)
        self.context = (ctypes.addressof(self._memory) + 63) & ~63
        self.status = self.dll.tmg_init(self.context)


class _Result(ctypes.Structure):
    """A `tm_result`."""

    _fields_ = [("margin", ctypes.c_double), ("verdict", ctypes.c_int)]


def _refused(case: Case, status: int) -> TrackmarshalError:
    return TrackmarshalError("E473", f"the program refuses the input of case {case.id!r} (status {status})")


class CProgram:
    """The compiled rules; `run` evaluates them on cases. Raises TrackmarshalError E470 to E473."""

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        self.spec = spec
        self.source = generate(spec, rules)
        self.rules = self.source.plan.rules
        self.order: Flat = flat(self.source)
        self._kinds = set(capacities(self.source.plan))
        self._numbers = {rule.name: index for index, rule in enumerate(self.rules)}
        self._params = {name: index for index, name in enumerate(self.source.plan.params)}
        self._tables = {name: index for index, name in enumerate(self.source.plan.tables)}
        self._changed: set[str] = set()
        self._library: Library | None = None
        self._places: PlaceSetter | None = None
        self._numpy: Program | None = None

    def run(self, cases: Sequence[Case]) -> CRun:
        """Evaluate all rules on all cases."""
        count = len(self.rules)
        margins, verdicts = array("d", bytes(8 * count * len(cases))), array("b", bytes(count * len(cases)))
        for index, case in enumerate(cases):
            self._one(
                case, margins.buffer_info()[0] + 8 * count * index, verdicts.buffer_info()[0] + count * index
            )
        return CRun(self, cases, margins, verdicts)

    def values(self, cases: Sequence[Case]) -> Run:
        """The values of all formulas in them, as numpy computes them: what decided is not kept by generated code."""
        if self._numpy is None:
            self._numpy = Program(self.spec, self.rules)
        return self._numpy.run(cases)

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
        }
        have = self._library
        if have is not None and all(have.sizes[name] >= wanted[name] for name in self._kinds):
            return have
        sizes = {name: self._size(name, wanted[name]) for name in self._kinds}
        if have is not None:
            sizes = {name: max(size, have.sizes[name]) for name, size in sizes.items()}
        self._library = Library(self.source, sizes)
        self._changed.clear()
        self._places = PlaceSetter(self.source.plan, self._library) if self.source.plan.shapes else None
        return self._library

    def reset(self, lib: Library) -> None:
        """Put the spec's own parameters and tables back."""
        self._override(Case(), lib, self._changed)
        self._changed.clear()

    def _size(self, name: str, wanted: int) -> int:
        if name == "TM_MAX_ELEMENTS" or (name == "TM_MAX_SAMPLES" and not self.source.series):
            return _FREE
        least = max(wanted, 256)
        if name == "TM_MAX_KNOTS":
            least = max(
                wanted, CAPACITIES[name][0], *(len(self.spec.tables[table].knots) for table in self._tables)
            )
        if name == "TM_MAX_BORDER":
            least = max(wanted, CAPACITIES[name][0])
        if name == "TM_MAX_PLACE":
            least = max(wanted, *(len(p.points) for p in self.spec.places.values()))
        for size in _CLASSES:
            if size >= least:
                return size
        raise TrackmarshalError(
            "E473", f"{wanted} is more than the {_CLASSES[-1]} that generated programs hold"
        )

    def _one(self, case: Case, margins: int, verdicts: int) -> None:
        lib, (counts, columns, numbers, flags, *_) = self._prepared(case)
        status = lib.dll.tmg_run(lib.context, 1, counts, columns, numbers, flags, margins, verdicts)
        if status != 0:
            raise _refused(case, status)

    def along(self, case: Case, rule: RuleInfo) -> tuple[list[str], list[float]]:
        """Verdict and margin of a rule's formula at every sample of its timeline."""
        assert rule.along is not None
        lib, (counts, columns, numbers, flags, *_) = self._prepared(case)
        found = (_Result * case.counts[rule.along.signal])()
        status = lib.dll.tmg_along(lib.context, self.number(rule), counts, columns, numbers, flags, found)
        if status != 0:
            raise _refused(case, status)
        return [VERDICTS[result.verdict] for result in found], [result.margin for result in found]

    def _prepared(self, case: Case) -> tuple[Library, tuple[Any, ...]]:
        """A library that holds the case, configured for it, and the addresses of its input; the rest keeps them alive."""
        order = self.order
        counts = [case.counts[name] for name in order.counts]
        sequences = [n for n, name in zip(counts, order.counts) if self.spec.signals[name].sequence]
        elements = [n for n, name in zip(counts, order.counts) if not self.spec.signals[name].sequence]
        knots = max((len(rows[0]) for rows in case.tables.values()), default=0)
        border = max((len(points) for points in case.lines.values()), default=0)
        place = max((len(points) for points in case.places.values()), default=0)
        lib = self.library_for(max(sequences, default=0), max(elements, default=0), border, place, knots)
        self._configure(case, lib)
        kept = [_column(case.columns[name][field], flag) for name, field, flag in order.columns]
        given = (
            array("Q", counts),
            array("Q", [column.buffer_info()[0] for column in kept]),
            array("d", [case.scalars[name][field] for name, field in order.numbers]),
            array("b", [_flag(case.scalars[name][field]) for name, field in order.flags]),
        )
        return lib, (*(numbers.buffer_info()[0] for numbers in given), given, kept)

    def _configure(self, case: Case, lib: Library) -> None:
        """Put a case's overrides into the context, and the spec's own values where the case before had others."""
        self._override(case, lib, self._changed | case.params.keys() | case.tables.keys())
        self._changed = {*case.params, *case.tables}
        if self._places is not None:
            self._places.put(case)

    def _override(self, case: Case, lib: Library, names: set[str]) -> None:
        for name in names:
            if name in self._params:
                lib.dll.tmg_set_param(
                    lib.context, self._params[name], case.params.get(name, self.spec.params[name].value)
                )
            elif name in self._tables:
                info = self.spec.tables[name]
                rows = case.tables.get(name, (info.knots, info.values))
                knots, values = array("d", rows[0]), array("d", rows[1])
                if lib.dll.tmg_set_table(
                    lib.context,
                    self._tables[name],
                    knots.buffer_info()[0],
                    values.buffer_info()[0],
                    len(knots),
                ):
                    raise TrackmarshalError("E473", f"the program refuses table `{name}`")


class CRun:
    """The values of a program for some cases."""

    def __init__(
        self, program: CProgram, cases: Sequence[Case], margins: array[float], verdicts: array[int]
    ) -> None:
        self.program = program
        self.cases = cases
        self._margins = margins
        self._verdicts = verdicts

    def outcome(self, index: int, rule: RuleInfo) -> tuple[str, float]:
        """Verdict and margin of a rule in one case."""
        if self.cases[index].blocks(rule.reads):
            return "undefined", math.nan
        place = index * len(self.program.rules) + self.program.number(rule)
        return VERDICTS[self._verdicts[place]], self._margins[place]

    def verdicts(self, rule: RuleInfo) -> tuple[list[str], list[float]]:
        """Verdict and margin of a rule in each case, without witnesses."""
        pairs = [self.outcome(index, rule) for index in range(len(self.cases))]
        return [verdict for verdict, _ in pairs], [margin for _, margin in pairs]

    def results(self, series: bool = False) -> Iterator[CaseResult]:
        """The results of every case, with witnesses."""
        from trackmarshal.backends.c.witnesses import case_result

        values = self.program.values(self.cases)
        for index, case in enumerate(self.cases):
            yield case_result(self, index, case, values, series)


def evaluate(
    spec: Spec, rules: Sequence[RuleInfo], cases: Sequence[Case], series: bool = False
) -> Iterator[CaseResult]:
    """Evaluate rules on cases with generated C."""
    return CProgram(spec, rules).run(cases).results(series)


def _column(values: Sequence[Any], flag: bool) -> array[Any]:
    """A column as a C array; never without memory, so that its address is one."""
    if flag:
        return array("b", [_flag(value) for value in values] or [0])
    return array("d", values or [0.0])


def _flag(value: bool | None) -> int:
    return -1 if value is None else int(value)
