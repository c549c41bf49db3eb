"""The binding of a Supervisor in C: a cycle as words of eight bytes, so that Python needs to know no struct."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.interface import LASTING, LIMITS
from trackmarshal.runtime.contract import RECORD, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY

#: Words of a cycle before its signals, and of what is said: name and kind, q for whole numbers, d for others.
HEAD = (("came", "q"), ("numbered", "q"), ("stamped", "q"), ("number", "q"), ("t", "d"), ("now", "d"), ("found", "Q"), ("found_count", "Q"))  # fmt: skip
SAID = (
    ("serial", "q"), ("state", "q"), ("safe", "q"), ("driven", "q"), ("first", "q"), ("driven_number", "q"), ("driven_t", "d"),
    ("stored", "q"), ("stored_number", "q"), ("stored_t", "d"), ("lost", "q"), ("now", "d"), ("finished", "d"), ("valid_until", "d"),
    ("judged", "q"), ("fault_count", "q"), ("reason_count", "q"), ("more", "q"),
)  # fmt: skip


@dataclass(frozen=True)
class Words:
    """The order of a cycle's words.

    After `HEAD`: for each of `columns` (the candidates first) the address of its numbers, (numbers, count) in C's order, 0 where it
    is missing, that of its flags, and its count; for each of `lines` (signal, field) address, count and id; for each of `ids`, sets
    whose elements are known again, the address of their numbers; for each of `lanes` that of address, count and id of the left borders, and
    then of the right ones; for each of `closed` and `events` a word.
    """

    columns: tuple[str, ...]
    lines: tuple[tuple[str, str], ...]
    ids: tuple[str, ...]
    closed: tuple[str, ...]
    events: tuple[str, ...]
    lanes: tuple[str, ...] = ()

    def place(self, signal: str) -> int:
        """Which of the columns are those of a signal, which may be called as a candidate is: those of the candidates come first."""
        return self.columns.index(signal, len((DRIVING, EMERGENCY)))

    @property
    def formats(self) -> tuple[str, str, str]:
        """For `struct`: of the head, the columns, and the rest."""
        head = "".join(kind for _, kind in HEAD)
        rest = (
            f"={3 * len(self.lines) + len(self.ids) + len(self.lanes)}Q{len(self.closed) + len(self.events)}q"
        )
        return f"={head}", f"={3 * len(self.columns)}Q", rest


def words(given: Supervised) -> Words:
    """The order for a program."""
    return Words(
        (DRIVING, EMERGENCY, *(signal.name for signal in given.inputs)),
        tuple(given.lines),
        tuple(signal.name for signal in given.inputs if signal.named),
        tuple(signal.name for signal in given.borders if _closed(signal)),
        tuple(signal.name for signal in given.events),
        tuple(signal.name for signal in given.lanes),
    )


def _closed(signal: Signal) -> bool:
    return any(field.name for field in signal.lines)


def glue(given: Supervised) -> Iterator[str]:
    """The C of the binding."""
    plan = given.layout
    yield "size_t tmg_decision_size(void) { return sizeof(tm_decision); }"
    yield "size_t tmg_reasons(void) { return offsetof(tm_decision, reasons); }"
    yield "size_t tmg_reason_size(void) { return sizeof(tm_reason); }"
    yield "/* Where the stored trajectory's columns begin in the context. */"
    yield "size_t tmg_stored(size_t field) {"
    yield "  switch (field) {"
    for place, (_, c_name) in enumerate(given.plan.fields):
        yield f"    case {place}u: return offsetof(tm_context, stored.plan.{c_name});"
    yield "    default: return 0u;"
    yield "  }"
    yield "}"
    yield "/* What a step leaves to the next: where each part of it stands in the context, and its size; 0 after the last. */"
    yield "size_t tmg_lasting(size_t part, size_t *size) {"
    yield "  switch (part) {"
    for place, name in enumerate((*LASTING, *(["run"] if plan.remembers else []))):
        yield f"    case {place}u: *size = sizeof(((tm_context *)0)->{name}); return offsetof(tm_context, {name});"
    yield "    default: *size = 0u; return 0u;"
    yield "  }"
    yield "}"
    yield "/* Limits, parameters; of tables knots, values and counts; what is wrong is named. */"
    yield "int tmg_configure(void *context, const double *limits, const double *params, const double *const *knots,"
    yield "                  const double *const *values, const size_t *counts, const char **which) {"
    yield "  tm_configuration given;"
    yield "  tm_configured said;"
    yield "  (void)params; (void)knots; (void)values; (void)counts;"
    yield "  tm_defaults(&given);"
    yield from (f"  given.limits.{name} = limits[{place}];" for place, name in enumerate(LIMITS))
    yield from (
        f"  given.params.{name} = params[{place}];" for place, name in enumerate(plan.params.values())
    )
    for place, name in enumerate(plan.tables.values()):
        yield f"  given.tables.{name}.knots = knots[{place}];"
        yield f"  given.tables.{name}.values = values[{place}];"
        yield f"  given.tables.{name}.count = counts[{place}];"
    yield "  said = tm_configure((tm_context *)context, &given);"
    yield "  *which = said.which;"
    yield "  return (int)said.status;"
    yield "}"
    yield from _structs(given)
    yield from _step(given)


_KINDS = {"q": "int64_t", "d": "double", "Q": "uint64_t"}


def _structs(given: Supervised) -> Iterator[str]:
    order = words(given)
    yield "typedef struct { uint64_t numbers; uint64_t flags; uint64_t count; } tmg_columns;"
    yield "typedef struct { uint64_t points; uint64_t count; uint64_t id; } tmg_line;"
    yield "typedef struct {"
    yield from (f"  {_KINDS[kind]} {name};" for name, kind in HEAD)
    yield f"  tmg_columns columns[{len(order.columns)}];"
    if order.lines:
        yield f"  tmg_line lines[{len(order.lines)}];"
    if order.ids:
        yield f"  uint64_t ids[{len(order.ids)}];"
    if order.lanes:
        yield f"  uint64_t lanes[{len(order.lanes)}];"
    if order.closed:
        yield f"  int64_t closed[{len(order.closed)}];"
    if order.events:
        yield f"  int64_t events[{len(order.events)}];"
    yield "} tmg_cycle;"
    yield "typedef struct {"
    yield from (f"  {_KINDS[kind]} {name};" for name, kind in SAID)
    yield "} tmg_said;"


def _step(given: Supervised) -> Iterator[str]:
    order = words(given)
    signals = [given.contract.plan, given.contract.plan, *given.inputs]
    yield "/* Addresses of the context, a cycle's words, the clock, a decision, where its words, margins and verdicts go, and what the clock gets. */"
    yield "typedef struct {"
    yield "  uint64_t context; uint64_t in; uint64_t clock; uint64_t out; uint64_t said; uint64_t margins; uint64_t verdicts; uint64_t user;"
    yield "} tmg_bound;"
    yield "void tmg_step(const tmg_bound *bound) {"
    yield "  const tmg_cycle *in = (const tmg_cycle *)(uintptr_t)bound->in;"
    yield "  tm_decision *out = (tm_decision *)(uintptr_t)bound->out;"
    yield "  tmg_said *said = (tmg_said *)(uintptr_t)bound->said;"
    yield "  double *margins = (double *)(uintptr_t)bound->margins;"
    yield "  signed char *verdicts = (signed char *)(uintptr_t)bound->verdicts;"
    yield "  tm_cycle cycle;"
    for place, (name, signal) in enumerate(zip(order.columns, signals)):
        assert signal is not None
        c_name = given.plan.c_name if place < 2 else given.signals[name]
        yield f"  tm_in_{c_name} columns_{place};"
    for signal in given.lanes:
        yield f"  tm_points lanes_{given.signals[signal.name]}[2][TM_MAX_ELEMENTS];"
    for signal in given.borders:
        yield f"  tm_in_{given.signals[signal.name]} lines_{given.signals[signal.name]};"
    for name in ("came", "numbered", "stamped"):
        yield f"  cycle.{name} = in->{name} != 0;"
    for name in ("number", "t", "now"):
        yield f"  cycle.{name} = in->{name};"
    yield "  cycle.found = (const tm_fault *)(uintptr_t)in->found;"
    yield "  cycle.found_count = (size_t)in->found_count;"
    for place, (name, signal) in enumerate(zip(order.columns, signals)):
        assert signal is not None
        target = f"cycle.{name}" if place < 2 else f"cycle.signals.{given.signals[name]}"
        yield from _columns(given, signal, place, target)
    for signal in given.borders:
        c_name = given.signals[signal.name]
        for field in signal.lines:
            own = f"lines_{c_name}.{given.lines[signal.name, field.name]}"
            line = f"in->lines[{order.lines.index((signal.name, field.name))}]"
            yield f"  {own}.points = (const double *)(uintptr_t){line}.points;"
            yield f"  {own}.count = (size_t){line}.count;"
            yield f"  {own}.id = {line}.id;"
        if _closed(signal):
            yield f"  lines_{c_name}.closed = in->closed[{order.closed.index(signal.name)}] != 0;"
        yield f"  cycle.signals.{c_name} = &lines_{c_name};"
    for place, name in enumerate(order.events):
        yield f"  cycle.signals.{given.signals[name]} = (tm_flag)in->events[{place}];"
    yield "  tm_step((tm_context *)(uintptr_t)bound->context, &cycle, (tm_clock)(uintptr_t)bound->clock, (void *)(uintptr_t)bound->user, out);"
    for name, kind in SAID:
        yield f"  said->{name} = {'' if kind == 'd' else '(int64_t)'}out->{name};"
    yield "  for (size_t r = 0; r < TM_RULES; ++r) {"
    for place, name in enumerate((DRIVING, EMERGENCY)):
        at = f"[r + {place} * TM_RULES]"
        yield f"    margins{at} = out->{name}.rule[r].margin;"
        yield f"    verdicts{at} = (signed char)out->{name}.rule[r].verdict;"
    yield "  }"
    yield "}"


def _columns(given: Supervised, signal: Signal, place: int, target: str) -> Iterator[str]:
    """A signal's struct out of the numbers and flags of a frame, which stand one row after the other."""
    source = given.plan if place < 2 else given.layout.input(signal.name)
    names = {info.name: c_name for info, c_name in source.fields}
    own, words_ = f"columns_{place}", f"in->columns[{place}]"
    record = signal.form == RECORD
    yield f"  if ({words_}.numbers != 0u || {words_}.flags != 0u) {{"
    yield f"    const double *numbers = (const double *)(uintptr_t){words_}.numbers;"
    yield f"    const tm_flag *flags = (const tm_flag *)(uintptr_t){words_}.flags;"
    yield f"    const size_t count = (size_t){words_}.count;"
    yield "    (void)numbers; (void)flags; (void)count;"
    if not record:
        yield f"    {own}.count = count;"
    for kind, fields in (("numbers", signal.numbers), ("flags", signal.flags)):
        for row, field in enumerate(fields):
            at = f"{kind}[{row}u]" if record else f"&{kind}[{row}u * count]"
            yield f"    {own}.{names[field.name]} = {at};"
    if signal.lines:
        yield from _lanes(given, signal, own)
    if signal.named:
        place = words(given).ids.index(signal.name)
        yield f"    {own}.id = (const uint64_t *)(uintptr_t)in->ids[{place}];"
    yield f"    {target} = &{own};"
    yield "  } else {"
    yield f"    {target} = NULL;"
    yield "  }"


def _lanes(given: Supervised, signal: Signal, own: str) -> Iterator[str]:
    """The borders of lanes, those of the left sides first."""
    made = f"lanes_{given.signals[signal.name]}"
    yield f"    const tmg_line *borders = (const tmg_line *)(uintptr_t)in->lanes[{words(given).lanes.index(signal.name)}];"
    yield "    for (size_t lane = 0; lane < count && lane < TM_MAX_ELEMENTS; ++lane) {"
    yield "      for (size_t side = 0; side < 2; ++side) {"
    yield "        const tmg_line *border = &borders[side * count + lane];"
    yield f"        {made}[side][lane].points = (const double *)(uintptr_t)border->points;"
    yield f"        {made}[side][lane].count = (size_t)border->count;"
    yield f"        {made}[side][lane].id = border->id;"
    yield "      }"
    yield "    }"
    yield f"    {own}.left = {made}[0];"
    yield f"    {own}.right = {made}[1];"
