"""A C program that plays a tape of messages and times to the emitted C, and says what that makes of them; and what Python makes of it.

A tape is a file of records: `M`, a length (u32) and bytes that came; `T` and a time (f64) at which the executing layer is asked.
"""

from __future__ import annotations

import math
import random
import struct
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

from support.cycles import cycle
from support.processes import Rig, Served
from support.supervised import shipped
from trackmarshal.backends.c.process.emit import WHYS, Emitted
from trackmarshal.backends.c.source import generate
from trackmarshal.ir.spec import Spec
from trackmarshal.process.executing import Executing
from trackmarshal.process.messages import Layout
from trackmarshal.runtime.cycle import Cycle, Limits

Record = bytes | float

#: What it prints of bytes: why they are not taken as what goes down, as what goes up, and by whoever executes; whether there was a decision. In the
#: end, how many were not taken by whoever executes, by cause.
PROGRAM = r"""
#include "executing.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef WITH_DESK
#include "desk.h"
static tml_desk desk;
#endif
static tml_executing executing;

static void bits(double x) {
  unsigned long long word = 0x7ff8000000000000ull;
  if (x == x) { memcpy(&word, &x, sizeof word); }
  printf(" %llx", word);
}

int main(int argc, char **argv) {
  FILE *tape = fopen(argv[1], "rb");
  int kind;
  (void)argc;
  if (tape == NULL) { return 1; }
  tml_executing_start(&executing, TML_SILENCE, true);
#ifdef WITH_DESK
  { const char *which; if (!tml_desk_start(&desk, 77, true, &which)) { return 1; } }
#endif
  while ((kind = getc(tape)) != EOF) {
    if (kind == 'T') {
      double now;
      tml_setpoint point;
      if (fread(&now, sizeof now, 1, tape) != 1) { return 1; }
      tml_executing_at(&executing, now, &point);
      printf("at %d %d %lld %lu", (int)point.action, (int)point.why, (long long)point.number, (unsigned long)point.index);
      bits(point.share);
      for (size_t k = 0; k < TML_PLAN_FIELDS; ++k) { bits(point.sample[k]); }
      putchar('\n');
    } else {
      unsigned int length;
      size_t most;
      tml_message *message;
      tml_cause down;
      tml_cause up;
      int decided = 0;
      if (fread(&length, sizeof length, 1, tape) != 1) { return 1; }
      most = (length > sizeof(tml_message)) ? length : sizeof(tml_message);
      message = malloc(most); /* what is beyond it, the sanitizer sees */
      memset(message, 0xa5, most);
      if (length > 0u && fread(message, 1, length, tape) != length) { return 1; }
      down = tml_look(message, length, false);
      if (down == TML_CAUSE_NONE) { down = tml_sound(message); }
      up = tml_look(message, length, true);
      if (up == TML_CAUSE_NONE) { up = tml_sound(message); }
#ifdef WITH_DESK
      {
        tml_cause cause;
        decided = tml_desk_take(&desk, message, length, NULL, NULL, &cause);
        if (decided) {
          const size_t size = desk.out.head.length;
          if (cause != TML_CAUSE_NONE || up != TML_CAUSE_NONE || message->head.kind != TML_CYCLE) { abort(); }
          if (tml_look(&desk.out, size, false) != TML_CAUSE_NONE || tml_sound(&desk.out) != TML_CAUSE_NONE) { abort(); }
          if (desk.out.decision.about_sequence != message->head.sequence) { abort(); }
          if (desk.out.decision.safe == 1) { decided = 2; }
        }
        if (tml_desk_overdue(&desk)) {
          if (desk.out.decision.safe == 1 || tml_sound(&desk.out) != TML_CAUSE_NONE) { abort(); }
        }
        tml_desk_beat(&desk);
        if (tml_look(&desk.out, desk.out.head.length, false) != TML_CAUSE_NONE || tml_sound(&desk.out) != TML_CAUSE_NONE) { abort(); }
      }
#endif
      printf("came %s %s %s %d\n", tml_causes[down], tml_causes[up], tml_causes[tml_executing_hear(&executing, message, length)], decided);
      free(message);
    }
  }
  printf("refused");
  for (size_t k = 1; k < TML_CAUSES; ++k) { printf(" %s %llu", tml_causes[k], (unsigned long long)executing.refused[k]); }
  putchar('\n');
  return fclose(tape);
}
"""


def compiled(folder: Path, flags: Sequence[str], desk: bool, spec: Spec | None = None) -> Path:
    """The program, with the emitted C of a spec's Supervisor as a process; the shipped one where none is given. desk: cycles are decided about, too."""
    spec = shipped() if spec is None else spec
    source = generate(spec, [rule for rule in spec.rules if rule.formula is not None], doored=True)
    files = {**Emitted(source, asdict(Limits())).files, "supervisor.h": source.header, "tape.c": PROGRAM}
    units = ["tape.c", "messages.c", "executing.c"]
    if desk:
        files["supervisor.c"] = source.source
        units += ["desk.c", "supervisor.c"]
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    defined = ["-DWITH_DESK"] if desk else []
    subprocess.run(
        ["cc", "-std=c99", "-ffp-contract=off", *flags, *defined, "-o", "tape", *units, "-lm"],
        cwd=folder,
        check=True,
    )
    return folder / "tape"


def played(program: Path, tape: Sequence[Record]) -> list[str]:
    """What the program prints of a tape."""
    path = program.parent / "tape.bin"
    with path.open("wb") as file:
        for one in tape:
            if isinstance(one, float):
                file.write(b"T" + struct.pack("<d", one))
            else:
                file.write(b"M" + struct.pack("<I", len(one)) + one)
    done = subprocess.run([program, path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.splitlines()


def expected(layout: Layout, tape: Sequence[Record]) -> list[str]:
    """What the program would print if it were Python; of what goes up, Python does not look at what is in it."""
    executing, actions, whys, lines = (
        Executing(layout, simulated=True),
        ("nothing", "drive", "fallback"),
        list(WHYS),
        [],
    )
    for one in tape:
        if isinstance(one, float):
            found = executing.at(one)
            nan = float("nan")
            sample = [found.sample[name] if found.sample is not None else nan for name in layout.plan]
            words = [actions.index(found.action), whys.index(found.why), found.number, found.index]
            lines.append(" ".join(["at", *map(str, words), _bits(found.share), *map(_bits, sample)]))
        else:
            lines.append(
                f"came {layout.look(one, up=False)[0]} {layout.look(one, up=True)[0]} {executing.hear(one)}"
            )
    told = (f"{cause} {executing.refused.get(cause, 0)}" for cause in layout.said["causes"][1:])
    return [*lines, " ".join(["refused", *told])]


def _bits(x: float) -> str:
    return "7ff8000000000000" if math.isnan(x) else f"{struct.unpack('<Q', struct.pack('<d', x))[0]:x}"


def recorded(served: Served, seed: int) -> tuple[list[bytes], list[bytes]]:
    """What went up and what came down in runs with restarts and broken cycles, all of one Supervisor's sessions."""
    up: list[bytes] = []
    down: list[bytes] = []

    class Heard:
        def __init__(self, channel: object) -> None:
            self._channel = channel

        def send(self, box: str, message: bytearray) -> bool:
            up.append(bytes(message))
            return bool(self._channel.send(box, message))  # type: ignore[attr-defined]

        def receive(self, seconds: float) -> bytes | None:
            data: bytes | None = self._channel.receive(seconds)  # type: ignore[attr-defined]
            if data is not None:
                down.append(data)
            return data

        def close(self) -> None:
            self._channel.close()  # type: ignore[attr-defined]

    rng = random.Random(seed)
    rig = Rig(served, Heard)
    for number in range(60):
        if number in (20, 40):
            served.kill()
            served.start()
        given = cycle(number)
        if rng.random() < 0.3:
            given = _spoilt(rng, number)
        rig.now = number / 10
        rig.client.answer(rig.send(number, given), 20.0)
        if rng.random() < 0.3:
            rig.later(rig.now + rng.choice([0.03, 0.16]))
    rig.close()
    return up, down


def _spoilt(rng: random.Random, number: int) -> Cycle:
    """A cycle that is not safe."""
    given = cycle(number)
    match rng.randrange(4):
        case 0:
            return replace(given, number=number + rng.choice([-1, 1]))
        case 1:
            given.driving["v"][rng.randrange(20)] = rng.choice([math.nan, math.inf, -1e9])
        case 2:
            given.emergency["v"][-1] = 3.0
        case _:
            given.signals["ego"]["x"] += 30.0
    return given
