"""Steps of a Supervisor in C on a file, and a C program that plays them: every column in memory of its own that ends where it ends."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from trackmarshal.backends.c.glue import glue
from trackmarshal.backends.c.said import Said
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.step import Stepper
from trackmarshal.backends.c.supervised.binding import HEAD
from trackmarshal.backends.c.supervised.interface import LIMITS
from trackmarshal.runtime.frame import Columns
from trackmarshal.runtime.lines import Line


class Taped(Stepper):
    """Writes down what every step is given, what the clock says, and what was decided."""

    takes_arenas = False

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.tape = bytearray()
        self.said = bytearray()

    def _configure(self, limits: Any, params: Any, tables: Any) -> None:
        super()._configure(limits, params, tables)
        self.limits = limits

    def step(self, number: Any, t: Any, now: float, columns: Sequence[Columns | None], lines: Sequence[Line], closed: Any = (),
             events: Any = (), found: Any = (), arena: Any = None, lanes: Any = ()) -> Said:  # fmt: skip
        assert not lanes, "a tape has none"
        said = super().step(number, t, now, columns, lines, closed, events, found, arena)
        self._write(found, said)
        for entry in columns:
            if entry is not None:
                numbers = entry.values.tobytes()
                flags = b"" if entry.flags is None else entry.flags.tobytes()
                self.tape += struct.pack("=qq", len(numbers), len(flags)) + numbers + flags
        for line in lines:
            self.tape += struct.pack("=q", 16 * len(line)) + line.points.tobytes()
        return said

    def none_came(self, now: float, found: Any = ()) -> Said:
        said = super().none_came(now, found)
        self._write(found, said)
        return said

    def _write(self, found: Any, said: Said) -> None:
        self.tape += self._in
        self.tape += struct.pack("=d", said.finished)
        for name, signal, field, index in found:
            texts = [text.encode() + b"\0" for text in (signal, field)]
            numbers = (self.name_number(name), -1 if index is None else index, *map(len, texts))
            self.tape += struct.pack("=qqqq", *numbers) + b"".join(texts)
        self.said += self._out.raw + self.margins.tobytes() + self.verdicts.tobytes()
        for one in self.reasons(said):
            self.said += (
                f"{one.name} {one.signal} {one.field} {one.index} {one.rule} {one.candidate}\n".encode()
            )

    @staticmethod
    def name_number(name: str) -> int:
        from trackmarshal.backends.c.supervised.interface import FAULT_NAMES

        return FAULT_NAMES.index(name)


def player(source: Source) -> str:
    """The program around the rules: its arguments are the tape, and the file for what is decided."""
    from trackmarshal.backends.c.supervised.interface import FAULT_NAMES

    names = ", ".join(f'"{name}"' for name in FAULT_NAMES)
    assert len(HEAD) == 8
    apart = glue(source).replace(
        f'#include "{source.name}.c"', f'#include "{source.name}.h"', 1
    )  # a unit of its own
    return (
        f"{apart}\nstatic const char *const names[] = {{{names}}};\n#define LIMITS {len(LIMITS)}\n{_PROGRAM}"
    )


def files(source: Source) -> dict[str, str]:
    """The program's files."""
    return {f"{source.name}.h": source.header, f"{source.name}.c": source.source, "player.c": player(source)}


_PROGRAM = r"""
#include <stdio.h>
#include <stdlib.h>

static void *taken(FILE *file, size_t bytes) { /* on the heap, ending where it ends */
  void *made = malloc(bytes == 0u ? 1u : bytes);
  if (made == NULL || fread(made, 1u, bytes, file) != bytes) { abort(); }
  return made;
}

static int64_t whole(FILE *file) {
  int64_t number;
  if (fread(&number, sizeof number, 1u, file) != 1u) { abort(); }
  return number;
}

static double finished;
static double read_clock(void *user) { (void)user; return finished; }

int main(int argc, char **argv) {
  FILE *tape = fopen(argc == 3 ? argv[1] : "", "rb");
  FILE *out = fopen(argc == 3 ? argv[2] : "", "wb");
  tm_context *context = malloc(sizeof *context);
  tm_decision *decision = malloc(sizeof *decision);
  double *margins = malloc(2u * TM_RULES * sizeof *margins);
  signed char *verdicts = malloc(2u * TM_RULES);
  tmg_cycle cycle;
  if (tape == NULL || out == NULL || context == NULL || decision == NULL || margins == NULL || verdicts == NULL) { return 2; }
  if (tm_init(context) != TM_OK) { return 3; }
  while (fread(&cycle, sizeof cycle, 1u, tape) == 1u) {
    enum { COLUMNS = sizeof cycle.columns / sizeof *cycle.columns, LINES = sizeof cycle.lines / sizeof *cycle.lines };
    void *kept[2 * COLUMNS + LINES] = {NULL};
    size_t count = 0u;
    const size_t found_count = (size_t)cycle.found_count;
    tm_fault *found = calloc(found_count + 1u, sizeof *found);
    tmg_said said;
    tmg_bound bound;
    if (found == NULL || fread(&finished, sizeof finished, 1u, tape) != 1u) { abort(); }
    for (size_t i = 0u; i < found_count; ++i) {
      int64_t given[4];
      for (size_t k = 0u; k < 4u; ++k) { given[k] = whole(tape); }
      found[i].name = (tm_fault_name)given[0];
      found[i].index = given[1] < 0 ? TM_NOWHERE : (size_t)given[1];
      found[i].signal = taken(tape, (size_t)given[2]);
      found[i].field = taken(tape, (size_t)given[3]);
    }
    cycle.found = (uint64_t)(uintptr_t)found;
    for (size_t i = 0u; cycle.came != 0 && i < COLUMNS; ++i) {
      if (cycle.columns[i].numbers != 0u) {
        const size_t numbers = (size_t)whole(tape);
        const size_t flags = (size_t)whole(tape);
        kept[count] = taken(tape, numbers);
        cycle.columns[i].numbers = (uint64_t)(uintptr_t)kept[count];
        kept[count + 1u] = taken(tape, flags);
        cycle.columns[i].flags = (uint64_t)(uintptr_t)kept[count + 1u];
        count += 2u;
      }
    }
    for (size_t i = 0u; cycle.came != 0 && i < LINES; ++i) {
      const size_t bytes = (size_t)whole(tape);
      kept[count] = taken(tape, bytes);
      cycle.lines[i].points = (uint64_t)(uintptr_t)kept[count];
      ++count;
    }
    bound.context = (uint64_t)(uintptr_t)context;
    bound.in = (uint64_t)(uintptr_t)&cycle;
    bound.clock = (uint64_t)(uintptr_t)read_clock;
    bound.out = (uint64_t)(uintptr_t)decision;
    bound.said = (uint64_t)(uintptr_t)&said;
    bound.margins = (uint64_t)(uintptr_t)margins;
    bound.verdicts = (uint64_t)(uintptr_t)verdicts;
    bound.user = 0u;
    tmg_step(&bound);
    (void)fwrite(&said, sizeof said, 1u, out);
    (void)fwrite(margins, sizeof *margins, 2u * TM_RULES, out);
    (void)fwrite(verdicts, 1u, 2u * TM_RULES, out);
    for (size_t i = 0u; i < decision->reason_count; ++i) {
      const tm_reason *one = &decision->reasons[i];
      (void)fprintf(out, "%s %s %s ", names[one->fault.name], one->fault.signal, one->fault.field);
      if (one->fault.index == TM_NOWHERE) { (void)fprintf(out, "None "); } else { (void)fprintf(out, "%lu ", (unsigned long)one->fault.index); }
      if (one->kind == TM_REASON_RULE) { (void)fprintf(out, "%lu ", (unsigned long)one->rule); } else { (void)fprintf(out, "None "); }
      (void)fprintf(out, "%d\n", (int)one->candidate);
    }
    for (size_t i = 0u; i < found_count; ++i) {
      free((void *)(uintptr_t)found[i].signal);
      free((void *)(uintptr_t)found[i].field);
    }
    free(found);
    for (size_t i = 0u; i < count; ++i) { free(kept[i]); }
  }
  free(context);
  free(decision);
  free(margins);
  free(verdicts);
  return (fclose(tape) == 0 && fclose(out) == 0) ? 0 : 4;
}
"""
