"""The door of a Supervisor in C: generated from the contract, it finds every fault of a cycle and not just the first (S-2-C).

Each function leaves a part's mark when it ran to its end, and counts each fault beside adding it: a cycle in which a part is
missing is not safe.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from trackmarshal.backends.c.contract import Supervised
from trackmarshal.backends.c.interface import LIMITS
from trackmarshal.backends.c.machine import ego_of
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.runtime.contract import EGO, EVENT, LINES, RECORD, Check, Field, Kind, Signal
from trackmarshal.runtime.contract.cycles import END, NUMBER, STAMP, START, TIMELY, Demand
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY

#: What capacities of limits are called in C.
CAPACITIES = {"samples": "TM_MAX_SAMPLES", "elements": "TM_MAX_ELEMENTS", "border": "TM_MAX_BORDER"}
_LIMITS = {name: f"c->limits.{name}" for name in LIMITS}


def text(name: str) -> str:
    """A name of the spec as a C string."""
    return '"' + comment(name).replace('"', "'") + '"'


def breach(fault: str, signal: str, field: str, index: str = "TM_NOWHERE") -> str:
    """Statements that count a fault and add it."""
    return f"++look->breaches; tm_add(look->out, TM_FAULT_{fault.upper()}, {signal}, {field}, {index});"


class Door:
    """The door's C: `functions`, and how many parts of it have to run for a cycle without fault."""

    def __init__(self, given: Supervised, setters: Mapping[str, str]) -> None:
        self._given = given
        #: C of the call that prepares the borders or line of a signal, where rules need it.
        self._setters = setters
        #: Functions for the checks of a column or line: what they are called, by the kinds of checks.
        self._columns: dict[tuple[object, ...], str] = {}
        self._helpers: list[str] = []
        contract = given.contract
        assert contract.plan is not None
        plan = self._signal(contract.plan, given.plan.c_name)
        others = [line for signal in contract.signals for line in self._other(signal)]
        body = [*self._order(), *plan, *self._fit(), *others, *self._whole()]
        self.functions = [*self._helpers, *body]
        #: How many parts run up to the door's end: those of each candidate twice, order and fit, and two before the door.
        self.parts = 2 * self._parts_of(contract.plan) + sum(map(self._parts_of, contract.signals)) + 4

    # Checks of values ------------------------------------------------------------------------------------------

    def _helper(self, sort: str, checks: Sequence[Check]) -> str:
        """The function for a column of numbers or flags, or a line, that has to pass these kinds of checks."""
        kinds = [check.kind for check in checks]
        bounds = tuple(
            next((name for name, value in check.constants if isinstance(value, str)), "") for check in checks
        )
        key = (sort, bounds, *map(id, kinds))
        if key not in self._columns:
            self._columns[key] = name = f"tm_{sort}_{len(self._columns)}"
            constants = [[each for each, _ in check.constants] for check in checks]
            made = (
                _line(name, kinds, constants, bounds)
                if sort == "line"
                else _column(name, sort, kinds, constants)
            )
            self._helpers += [*made, ""]
        return self._columns[key]

    def _signal(self, signal: Signal, c_name: str) -> Iterator[str]:
        """A timeline, set or record."""
        fields = {info.name: name for info, name in self._input(signal).items()}
        record = signal.form == RECORD
        yield f"/* What `{comment(signal.name)}` has to be: its length, then its fields one by one. */"
        yield f"static void tm_signal_{c_name}(const tm_in_{c_name} *in, const char *signal, tm_look *look)"
        yield "{"
        yield "  if (in == NULL) {"
        yield f"    {breach('missing', 'signal', _NO_FIELD)}"
        if not record:
            for check in signal.checks:
                yield f"  }} else if (!{_condition(check, {'n': '(double)in->count'})}) {{"
                yield f"    {breach(check.kind.fault, 'signal', _NO_FIELD, _capacity(check))}"
        yield "  } else {"
        for field in (*signal.numbers, *signal.flags):
            sort = "flags" if field.kind == "bool" else "numbers"
            helper = self._helper(sort, field.checks)
            place = (
                f"&in->{fields[field.name]}, 1u, false"
                if record
                else f"in->{fields[field.name]}, in->count, true"
            )
            constants = "".join(
                f", {value}" for check in field.checks for value in _constants(check).values()
            )
            yield f"    {helper}({place}, signal, {text(field.name)}, look{constants});"
        yield "  }"
        yield "  ++look->parts;"
        yield "}"
        yield ""

    def _other(self, signal: Signal) -> Iterator[str]:
        c_name = self._given.signals[signal.name]
        if signal.form == LINES:
            return self._lines(signal, c_name)
        return iter(()) if signal.form == EVENT else self._signal(signal, c_name)

    def _lines(self, signal: Signal, c_name: str) -> Iterator[str]:
        """A signal of lines: each is looked at where it may be another one, and prepared for the rules once it has passed."""
        kept = f"c->lines.{c_name}"
        closed = any(field.name for field in signal.lines)
        yield f"/* What `{comment(signal.name)}` has to be; where it is new, it is prepared for the rules. */"
        yield f"static void tm_signal_{c_name}(tm_context *c, const tm_in_{c_name} *in, const char *signal, tm_look *look)"
        yield "{"
        yield "  const size_t before = look->breaches;"
        yield "  if (in == NULL) {"
        yield f"    {breach('missing', 'signal', _NO_FIELD)}"
        yield "  } else {"
        for field in signal.lines:
            member = self._given.lines[signal.name, field.name]
            constants = "".join(
                f", {value}" for check in field.checks for value in _constants(check).values()
            )
            helper = self._helper("line", field.checks)
            yield f"    {helper}(&in->{member}, &{kept}.{member}, &{kept}.set, signal, {text(field.name)}, look{constants});"
        changed = f"!{kept}.set" + (f" || ({kept}.closed != in->closed)" if closed else "")
        yield f"    if ((look->breaches == before) && ({changed})) {{"
        if signal.name in self._setters:
            yield f"      (void){self._setters[signal.name]};"
        if closed:
            yield f"      {kept}.closed = in->closed;"
        yield f"      {kept}.set = true;"
        yield "    }"
        yield "  }"
        yield "  ++look->parts;"
        yield "}"
        yield ""

    def _parts_of(self, signal: Signal) -> int:
        """How many functions run for a signal that has no fault."""
        if signal.form == EVENT:
            return sum(1 for _ in signal.fields_)
        return 1 + len(signal.lines if signal.form == LINES else (*signal.numbers, *signal.flags))

    def _input(self, signal: Signal) -> dict[Field, str]:
        given = self._given
        own = given.plan if signal.name == given.plan.name else given.layout.input(signal.name)
        names = {info.name: c_name for info, c_name in own.fields}
        return {field: names[field.name] for field in (*signal.numbers, *signal.flags)}

    # Demands on cycles -----------------------------------------------------------------------------------------

    def _order(self) -> Iterator[str]:
        """Number and stamp."""
        stamp = {"t": "t", "now": "now", "since": "since", "begun": "stamped", **_LIMITS}
        number = {"number": "number", "last": "last", "begun": "numbered"}
        yield "/* Whether number and stamp go on from those of the last cycle whose stamp was in order, and the stamp is in time. */"
        yield "static void tm_door_order(tm_context *c, const tm_cycle *cycle, tm_look *look)"
        yield "{"
        yield "  const int stamped = c->stamped ? 1 : 0;"
        yield "  const int numbered = c->numbered ? 1 : 0;"
        yield "  const int64_t number = cycle->number;"
        yield "  const int64_t last = c->number;"
        yield "  const double t = cycle->t;"
        yield "  const double now = look->out->now;"
        yield "  const double since = c->stamped ? (t - c->stamp) : 0.0;"
        yield "  if (!cycle->stamped) {"
        yield f'    if (!tm_named(cycle, "cycle", "t")) {{ {breach("missing", _CYCLE, text("t"))} }}'
        yield from _chain(STAMP, stamp, "} else ")
        yield "  } else {"
        yield "    look->in_order = true;"
        for demand in TIMELY:
            yield f"    if (!{demand.holds.c(stamp)}) {{ {_breach(demand)} }}"
        yield "  }"
        yield "  if (!cycle->numbered) {"
        yield f'    if (!tm_named(cycle, "cycle", "number")) {{ {breach("missing", _CYCLE, text("number"))} }}'
        yield from _chain(NUMBER, number, "} else ")
        yield "  } else {"
        yield "    /* in order */"
        yield "  }"
        yield "  if (look->in_order) {"
        yield "    c->stamp = t;"
        yield "    c->stamped = true;"
        yield "    if (cycle->numbered) {"
        yield "      c->number = number;"
        yield "      c->numbered = true;"
        yield "    }"
        yield "  }"
        yield "  ++look->parts;"
        yield "}"
        yield ""

    def _fit(self) -> Iterator[str]:
        """What the candidates have to be together."""
        columns = {info.name: c_name for info, c_name in self._given.plan.fields}

        def apart(name: str) -> str:
            return f"d->{columns[name]}[0] - e->{columns[name]}[0]"

        names = {name: name for name in ("dx", "dy", "turn", "faster", "last")} | _LIMITS
        yield "/* Whether the emergency trajectory starts where the driving one does, and ends at rest; both have passed by themselves. */"
        yield f"static void tm_door_fit(const tm_context *c, const tm_in_{self._given.plan.c_name} *d, const tm_in_{self._given.plan.c_name} *e, tm_look *look)"
        yield "{"
        yield f"  const double dx = {apart('x')};"
        yield f"  const double dy = {apart('y')};"
        yield f"  const double turn = {apart('heading')};"
        yield f"  const double faster = {apart('v')};"
        yield f"  const double last = e->{columns['v']}[e->count - 1u];"
        for demands, index in ((START, "0u"), (END, "e->count - 1u")):
            for demand in demands:
                fault = breach(demand.fault, text(EMERGENCY), text(demand.field), index)
                yield f"  if (!{demand.holds.c(names)}) {{ {fault} }}"
        yield "  ++look->parts;"
        yield "}"
        yield ""

    # The whole -------------------------------------------------------------------------------------------------

    def _whole(self) -> Iterator[str]:
        given = self._given
        own = given.plan.c_name
        yield "/* The door: everything that is wrong with a cycle, first what whoever received it has found. */"
        yield "static void tm_door(tm_context *c, const tm_cycle *cycle, tm_look *look)"
        yield "{"
        yield "  size_t before;"
        yield "  if (cycle->found_count > 0u) {"
        yield "    tm_found(cycle, look);"
        yield "  }"
        yield "  tm_door_order(c, cycle, look);"
        yield "  before = look->breaches;"
        for name in (DRIVING, EMERGENCY):
            yield f'  if (!tm_named(cycle, "{name}", NULL)) {{ tm_signal_{own}(cycle->{name}, "{name}", look); }}'
        yield f'  if ((look->breaches == before) && !tm_named(cycle, "{DRIVING}", NULL) && !tm_named(cycle, "{EMERGENCY}", NULL)) {{'
        yield "    tm_door_fit(c, cycle->driving, cycle->emergency, look);"
        yield "  }"
        for signal in given.contract.signals:
            yield from self._call(signal)
        yield "  c->marks.door = c->serial;"
        yield "}"
        yield ""

    def _call(self, signal: Signal) -> Iterator[str]:
        c_name = self._given.signals[signal.name]
        place = f"cycle->signals.{c_name}"
        name = text(signal.name)
        if signal.name == EGO:
            yield "  before = look->breaches;"
        yield f"  if (!tm_named(cycle, {name}, NULL)) {{"
        if signal.form == EVENT:
            for field in signal.fields_:
                constants = "".join(
                    f", {value}" for check in field.checks for value in _constants(check).values()
                )
                yield f"    {self._helper('flags', field.checks)}(&{place}, 1u, false, {name}, {text(field.name)}, look{constants});"
        elif signal.form == LINES:
            yield f"    tm_signal_{c_name}(c, {place}, {name}, look);"
        else:
            yield f"    tm_signal_{c_name}({place}, {name}, look);"
        yield "  }"
        if signal.name == EGO:
            sure = f'!tm_named(cycle, {name}, NULL) && !tm_named(cycle, "signals", NULL)'
            yield f"  look->car.posed = (look->in_order && (look->breaches == before) && {sure}) ? 1 : 0;"
            yield from ego_of(self._given)


_CYCLE = '"cycle"'
_NO_FIELD = '""'


def _breach(demand: Demand) -> str:
    return breach(demand.fault, _CYCLE, text(demand.field))


def _chain(demands: Sequence[Demand], names: Mapping[str, str], before: str) -> Iterator[str]:
    """Branches of which the first demand that does not hold is taken."""
    for demand in demands:
        yield f"  {before}if (!{demand.holds.c(names)}) {{"
        yield f"    {_breach(demand)}"


def _constants(check: Check) -> dict[str, str]:
    """C of a check's constants, by name."""
    return {
        name: f"(double){CAPACITIES[value]}" if isinstance(value, str) else literal(value)
        for name, value in check.constants
    }


def _condition(check: Check, names: Mapping[str, str]) -> str:
    return check.kind.holds.c({**names, **_constants(check)})


def _capacity(check: Check) -> str:
    """The index of a fault of a length: the capacity, where it is one."""
    return next((CAPACITIES[value] for _, value in check.constants if isinstance(value, str)), "TM_NOWHERE")


def _signature(name: str, given: str, constants: Sequence[Sequence[str]]) -> str:
    numbers = "".join(f", double k{i}_{each}" for i, names in enumerate(constants) for each in names)
    return f"static void {name}({given}, const char *signal, const char *field, tm_look *look{numbers})"


def _own(index: int, kind: Kind, constants: Sequence[Sequence[str]], **names: str) -> str:
    return kind.holds.c({**names, **{each: f"k{index}_{each}" for each in constants[index]}})


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
        yield "    for (size_t i = 0u; i < count; ++i) {"
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
    yield "  if ((line->id != 0u) && (line->id == passed->id) && (line->count == passed->count)) {"
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
