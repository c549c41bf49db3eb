"""Checks of the contract as C functions: one for each set of kinds that a column or a line has to pass, generated from the kinds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from trackmarshal.backends.c.names import comment, literal
from trackmarshal.runtime.contract import Check, Kind

#: What capacities of limits are called in C.
CAPACITIES = {"samples": "TM_MAX_SAMPLES", "elements": "TM_MAX_ELEMENTS", "border": "TM_MAX_BORDER"}


def text(name: str) -> str:
    """A name of the spec as a C string."""
    return '"' + comment(name).replace('"', "'") + '"'


def breach(fault: str, signal: str, field: str, index: str = "TM_NOWHERE") -> str:
    """Statements that count a fault and add it."""
    return f"++look->breaches; tm_add(look->out, TM_FAULT_{fault.upper()}, {signal}, {field}, {index});"


class Helpers:
    """The functions that a door calls for columns and lines: `functions`, those that were asked for."""

    def __init__(self) -> None:
        self._names: dict[tuple[object, ...], str] = {}
        self.functions: list[str] = []

    def call(self, sort: str, given: str, checks: Sequence[Check], signal: str, field: str) -> str:
        """The call for `numbers`, `flags` or a `line` that has to pass these checks; signal and field as C has them."""
        constants = "".join(f", {value}" for check in checks for value in constants_of(check).values())
        return f"{self._name(sort, checks)}({given}, {signal}, {field}, look{constants});"

    def _name(self, sort: str, checks: Sequence[Check]) -> str:
        """The function for a column of numbers or flags, or a line, that has to pass these kinds of checks."""
        kinds = [check.kind for check in checks]
        bounds = tuple(
            next((name for name, value in check.constants if isinstance(value, str)), "") for check in checks
        )
        key = (sort, bounds, *map(id, kinds))
        if key not in self._names:
            self._names[key] = name = f"tm_{sort}_{len(self._names)}"
            constants = [[each for each, _ in check.constants] for check in checks]
            made = (
                _line(name, kinds, constants, bounds)
                if sort == "line"
                else _column(name, sort, kinds, constants)
            )
            self.functions += [*made, ""]
        return self._names[key]


def constants_of(check: Check, capacities: Mapping[str, str] = CAPACITIES) -> dict[str, str]:
    """C of a check's constants, by name."""
    return {
        name: f"(double){capacities[value]}" if isinstance(value, str) else literal(value)
        for name, value in check.constants
    }


def condition(check: Check, names: Mapping[str, str], capacities: Mapping[str, str]) -> str:
    return check.kind.holds.c({**names, **constants_of(check, capacities)})


def capacity(check: Check, capacities: Mapping[str, str]) -> str:
    """The index of a fault of a length: the capacity, where it is one."""
    most = dict(check.constants).get("most") if check.kind.fault == "over_capacity" else None
    if most is None:
        return "TM_NOWHERE"
    return capacities[most] if isinstance(most, str) else f"{int(most)}u"


def _signature(name: str, given: str, constants: Sequence[Sequence[str]]) -> str:
    numbers = "".join(f", double k{i}_{each}" for i, names in enumerate(constants) for each in names)
    return f"static void {name}({given}, const char *signal, const char *field, tm_look *look{numbers})"


def _own(index: int, kind: Kind, constants: Sequence[Sequence[str]], **names: str) -> str:
    return kind.holds.c({**names, **_names(index, constants)})


def _names(index: int, constants: Sequence[Sequence[str]]) -> dict[str, str]:
    return {each: f"k{index}_{each}" for each in constants[index]}


#: Entries that are looked at together.
BLOCK = 8


def _blocks(
    kinds: Sequence[Kind], constants: Sequence[Sequence[str]], values: Sequence[int]
) -> Iterator[str]:
    """How many entries pass, of the first blocks that do as a whole: mostly all. Without branches a compiler looks at several at once."""
    demands = [
        f"({demand} ? (uint64_t)1u : (uint64_t)0u)"
        for index in values
        for demand in kinds[index].holds.demands({"x": "x", **_names(index, constants)})
    ]
    yield "    uint64_t whole = 1u;"
    yield f"    while ((whole != 0u) && ((pass + {BLOCK}u) <= count)) {{"
    yield f"      for (size_t k = 0u; k < {BLOCK}u; ++k) {{"
    yield "        const double x = column[pass + k];"
    yield f"        whole &= {' & '.join(demands)};"
    yield "      }"
    yield f"      pass += (whole != 0u) ? {BLOCK}u : 0u;"
    yield "    }"


def _column(name: str, sort: str, kinds: Sequence[Kind], constants: Sequence[Sequence[str]]) -> Iterator[str]:
    """A function that finds the first entry of a column for each kind of check that fails; of one entry, the first kind counts."""
    value = "column[i]" if sort == "numbers" else "(double)column[i]"
    before = value.replace("[i]", "[i - 1u]")
    by_sort: dict[str, list[int]] = {"value": [], "step": []}
    for index, kind in enumerate(kinds):
        by_sort[kind.of].append(index)
    yield f"/* {'Numbers' if sort == 'numbers' else 'Flags'}: {', '.join(kind.fault for kind in kinds) or 'whether they are there'}. */"
    yield _signature(
        name,
        f"const {'double' if sort == 'numbers' else 'tm_flag'} *column, size_t count, bool indexed",
        constants,
    )
    yield "{"
    for index in range(len(kinds)):
        yield f"  size_t first{index} = TM_NOWHERE;"
    yield "  if ((column == NULL) && (count > 0u)) {"
    yield f"    {breach('missing', 'signal', 'field')}"
    yield "  } else {"
    if by_sort["value"]:
        yield "    size_t pass = 0u;"
        if sort == "numbers":
            yield from _blocks(kinds, constants, by_sort["value"])
        yield "    for (size_t i = pass; i < count; ++i) {"
        yield f"      const double x = {value};"
        for place, index in enumerate(by_sort["value"]):
            yield f"      {'} else ' if place else ''}if (!{_own(index, kinds[index], constants, x='x')}) {{"
            yield f"        if (first{index} == TM_NOWHERE) {{ first{index} = i; }}"
        if len(by_sort["value"]) > 1:
            yield "      } else {"
            yield "        /* it passes */"
        yield "      }"
        yield "    }"
    for index in by_sort["step"]:
        yield "    for (size_t i = 1u; i < count; ++i) {"
        yield f"      const double before = {before};"
        yield f"      const double x = {value};"
        yield f"      if (!{_own(index, kinds[index], constants, x='x', before='before')} && (first{index} == TM_NOWHERE)) {{ first{index} = i; }}"
        yield "    }"
    yield "  }"
    if not kinds:
        yield "  (void)indexed;"
    for index, kind in enumerate(kinds):
        fault = breach(kind.fault, "signal", "field", f"indexed ? first{index} : TM_NOWHERE")
        yield f"  if (first{index} != TM_NOWHERE) {{ {fault} }}"
    yield "  ++look->parts;"
    yield "}"


def _line(
    name: str, kinds: Sequence[Kind], constants: Sequence[Sequence[str]], bounds: Sequence[str]
) -> Iterator[str]:
    """A function that looks at a line unless it is the one that passed last; `set` tells whether what is prepared is made of it.

    bounds: for each kind, which constant is a capacity."""
    points = [index for index, kind in enumerate(kinds) if kind.of == "point"]
    yield f"/* A line: {', '.join(kind.fault for kind in kinds)}. */"
    yield _signature(name, "const tm_points *line, tm_passed *passed, bool *set", constants)
    yield "{"
    yield "  const double n = (double)line->count;"
    for index in points:
        yield f"  size_t first{index} = TM_NOWHERE;"
    yield "  if ((line->points != NULL) && (line->id != 0u) && (line->id == passed->id) && (line->count == passed->count)) {"
    yield "    /* it passed last time */"
    for index, kind in enumerate(kinds):
        if kind.of == "count":
            at = f"(size_t)k{index}_{bounds[index]}" if bounds[index] else "TM_NOWHERE"
            yield f"  }} else if (!{_own(index, kind, constants, n='n')}) {{"
            yield f"    {breach(kind.fault, 'signal', 'field', at)}"
        elif kind.of != "point":
            raise AssertionError(f"a line has no check of {kind.of}")
    yield "  } else if ((line->points == NULL) && (line->count > 0u)) {"
    yield f"    {breach('missing', 'signal', 'field')}"
    yield "  } else {"
    for index in points:
        yield f"    for (size_t i = 0u; (i < (2u * line->count)) && (first{index} == TM_NOWHERE); ++i) {{"
        yield "      const double x = line->points[i];"
        yield f"      if (!{_own(index, kinds[index], constants, x='x')}) {{ first{index} = i / 2u; }}"
        yield "    }"
    for place, index in enumerate(points):
        yield f"    {'} else ' if place else ''}if (first{index} != TM_NOWHERE) {{"
        yield f"      {breach(kinds[index].fault, 'signal', 'field', f'first{index}')}"
    if points:
        yield "    } else {"
    yield "      passed->id = line->id;"
    yield "      passed->count = line->count;"
    yield "      *set = false;"
    if points:
        yield "    }"
    yield "  }"
    if not any(kind.of == "count" for kind in kinds):
        yield "  (void)n;"
    yield "  ++look->parts;"
    yield "}"
