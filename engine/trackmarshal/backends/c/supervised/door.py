"""The door of a Supervisor in C: generated from the contract, it finds every fault of a cycle and not just the first (S-2-C).

Each function leaves a part's mark when it ran to its end, and counts each fault beside adding it: a cycle in which a part is
missing is not safe.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.supervised.checks import Helpers, breach, capacity, condition, text
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.lanes import lanes_of
from trackmarshal.backends.c.supervised.machine import ego_of
from trackmarshal.backends.c.supervised.order import fit, order
from trackmarshal.runtime.contract import EGO, EVENT, ID, LINES, RECORD, SET, Field, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY

_NO_FIELD = '""'


class Door:
    """The door's C: `functions`, and how many parts of it have to run for a cycle without fault."""

    def __init__(self, given: Supervised, setters: Mapping[str, str]) -> None:
        self._given = given
        #: C of the call that prepares the borders or line of a signal, where rules need it.
        self._setters = setters
        self._helpers = Helpers()
        contract = given.contract
        assert contract.plan is not None
        plan = self._signal(contract.plan, given.plan.c_name)
        others = [line for signal in contract.signals for line in self._other(signal)]
        lanes = [line for signal in given.lanes for line in lanes_of(given, signal)]
        body = [*order(given), *plan, *fit(given), *others, *lanes, *self._whole()]
        self.functions = [*self._helpers.functions, *body]
        #: How many parts run up to the door's end: those of each candidate twice, order and fit, and two before the door.
        self.parts = (
            2 * self._parts_of(contract.plan)
            + sum(map(self._parts_of, contract.signals))
            + 4
            + len(given.lanes)
        )

    def _signal(self, signal: Signal, c_name: str) -> Iterator[str]:
        """A timeline, set or record."""
        fields = {info.name: name for info, name in self._input(signal).items()}
        record, capacities = signal.form == RECORD, self._given.capacities
        yield f"/* What `{comment(signal.name)}` has to be: its length, then its fields one by one. */"
        yield f"static void tm_signal_{c_name}(const tm_in_{c_name} *in, const char *signal, tm_look *look)"
        yield "{"
        yield "  if (in == NULL) {"
        yield f"    {breach('missing', 'signal', _NO_FIELD)}"
        for check in signal.checks:
            yield f"  }} else if (!{condition(check, {'n': '1.0' if record else '(double)in->count'}, capacities)}) {{"
            yield f"    {breach(check.kind.fault, 'signal', _NO_FIELD, capacity(check, capacities))}"
        if signal.form == SET:  # whatever it may have by its declaration
            yield "  } else if (in->count > TM_MAX_ELEMENTS) {"
            yield f"    {breach('over_capacity', 'signal', _NO_FIELD, 'TM_MAX_ELEMENTS')}"
        yield "  } else {"
        for field in (*signal.numbers, *signal.flags):
            sort = "flags" if field.kind == "bool" else "numbers"
            place = f"in->{fields[field.name]}"
            place = f"&{place}, 1u, false" if record else f"{place}, in->count, true"
            yield f"    {self._helpers.call(sort, place, field.checks, 'signal', text(field.name))}"
        if signal.named:
            yield "    if ((in->id == NULL) && (in->count > 0u)) {"
            yield f"      {breach('missing', 'signal', text(ID))}"
            yield "    } else if (!tm_ids_differ(in->id, in->count)) {"
            yield f"      {breach('duplicate', 'signal', text(ID), 'tm_id_again(in->id, in->count)')}"
            yield "    } else {"
            yield "      ++look->parts;"
            yield "    }"
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
            place = f"&in->{member}, &{kept}.{member}, &{kept}.set"
            yield f"    {self._helpers.call('line', place, field.checks, 'signal', text(field.name))}"
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
        return (
            1 + signal.named + len(signal.lines if signal.form == LINES else (*signal.numbers, *signal.flags))
        )

    def _input(self, signal: Signal) -> dict[Field, str]:
        given = self._given
        own = given.plan if signal.name == given.plan.name else given.layout.input(signal.name)
        names = {info.name: c_name for info, c_name in own.fields}
        return {field: names[field.name] for field in (*signal.numbers, *signal.flags)}

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
        for signal in given.lanes:
            c_name = given.signals[signal.name]
            yield f"  tm_lanes_{c_name}(c, cycle, cycle->signals.{c_name}, {text(signal.name)}, look);"
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
                yield f"    {self._helpers.call('flags', f'&{place}, 1u, false', field.checks, name, text(field.name))}"
        elif signal.form == LINES:
            yield f"    tm_signal_{c_name}(c, {place}, {name}, look);"
        else:
            yield f"    tm_signal_{c_name}({place}, {name}, look);"
        yield "  }"
        if signal.name == EGO:
            sure = f'!tm_named(cycle, {name}, NULL) && !tm_named(cycle, "signals", NULL)'
            yield f"  look->car.posed = (look->in_order && (look->breaches == before) && {sure}) ? 1 : 0;"
            yield from ego_of(self._given)
