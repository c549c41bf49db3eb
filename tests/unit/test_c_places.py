"""Which element has which place in the memory of generated C: all sequences of a few cycles, at the brim of what there is room for, and beyond it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from support.sanitized import FLAGS
from trackmarshal.backends.c import build
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.parts import functions

pytestmark = [
    pytest.mark.verifies("S-1-B-4"),
    pytest.mark.skipif(compiler() is None, reason="no C compiler"),
]

#: Ids of four, of which up to three come in a cycle, in any order. Arrays are as long as what is in them, and not longer.
HEAD = r"""
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#define TM_MAX_ELEMENTS 3
#define TM_NO_PLACE ((size_t)-1)
#define TM_MAYBE_NEW ((size_t)-2)
#define TM_WITHOUT ((size_t)-3)
PARTS
static long cycles, wrong, again;
"""
TAIL = r"""
static void pick(kept before, uint64_t *given, size_t count, int left) {
  seen(before, given, count, left);
  for (uint64_t id = 1; count < TM_MAX_ELEMENTS && id <= 4; ++id) {
    bool there = false;
    for (size_t i = 0; i < count; ++i) there = there || given[i] == id;
    if (!there) { given[count] = id; pick(before, given, count + 1, left); }
  }
}

static void go_on(kept before, int left) { uint64_t given[TM_MAX_ELEMENTS]; pick(before, given, 0, left); }

int main(void) {
  kept none = {0};
  go_on(none, 2);
  printf("%ld %ld %ld\n", cycles, wrong, again);
  return 0;
}
"""
PRESENT = r"""
typedef struct { uint64_t known[TM_MAX_ELEMENTS]; bool used[TM_MAX_ELEMENTS]; } kept;
static void go_on(kept before, int left);

static void seen(kept now, const uint64_t *given, size_t count, int left) {
  const kept before = now;
  uint64_t *id = malloc(count * sizeof *id + (count == 0));
  size_t *place = malloc(count * sizeof *place + (count == 0)), *next = malloc(count * sizeof *next + (count == 0)), parts = 0;
  bool taken[TM_MAX_ELEMENTS] = {false};
  for (size_t i = 0; i < count; ++i) id[i] = given[i];
  tm_places_of(id, count, now.known, now.used, place, &parts);
  tm_places_next(count, now.used, place, next, &parts);
  ++cycles;
  wrong += parts != 2;
  for (size_t i = 0; i < count; ++i) {
    size_t where = TM_NO_PLACE;
    for (size_t k = 0; k < TM_MAX_ELEMENTS; ++k) if (before.used[k] && before.known[k] == id[i]) where = k;
    wrong += place[i] != where;
    if (next[i] >= TM_MAX_ELEMENTS) { ++wrong; continue; }
    wrong += taken[next[i]] || !now.used[next[i]] || (where != TM_NO_PLACE && next[i] != where);
    again += where != TM_NO_PLACE && where != i;
    taken[next[i]] = true;
    now.known[next[i]] = id[i];
  }
  for (size_t k = 0; k < TM_MAX_ELEMENTS; ++k) wrong += now.used[k] != taken[k];
  free(id); free(place); free(next);
  if (left > 0) go_on(now, left - 1);
}
"""
#: With room for two of them, which may be absent for up to 2 ns; the stamps of cycles are 1 ns or 3 ns apart.
ABSENT = r"""
#define ROOM 2
#define FORGET 2
typedef struct { tm_life life[ROOM]; tm_lives all; int64_t now, last[5]; size_t place[5]; bool known[5], there[5], any; } kept;

static void go_on(kept before, int left);

static void seen_at(kept now, const uint64_t *given, size_t count, int left) {
  uint64_t *id = malloc(count * sizeof *id + (count == 0));
  size_t *place = malloc(count * sizeof *place + (count == 0)), *next = malloc(count * sizeof *next + (count == 0)), parts = 0, left_over = 0;
  tm_life *life = malloc(sizeof now.life);
  bool here[5] = {false}, taken[ROOM] = {false};
  for (size_t k = 0; k < ROOM; ++k) life[k] = now.life[k];
  for (size_t i = 0; i < count; ++i) { id[i] = given[i]; here[id[i]] = true; }
  tm_lives_begin(life, ROOM, &now.all, !now.any, FORGET, now.now, id, count, place, next, &parts);
  for (int e = 1; e <= 4; ++e) {
    now.known[e] = now.known[e] && (here[e] ? now.there[e] || now.now - now.last[e] <= FORGET : now.now - now.last[e] < FORGET);
    if (now.known[e]) taken[now.place[e]] = true;
  }
  for (size_t i = 0; i < count; ++i) {
    if (now.known[id[i]]) {
      wrong += place[i] != now.place[id[i]] || next[i] != place[i];
      again += !now.there[id[i]];
    } else if (next[i] == TM_NO_PLACE) {
      wrong += place[i] != TM_WITHOUT;
      ++left_over;
    } else if (next[i] >= ROOM) {
      ++wrong;
    } else {
      wrong += taken[next[i]] || (place[i] != TM_NO_PLACE && place[i] != TM_MAYBE_NEW);
      taken[next[i]] = true;
    }
  }
  for (size_t k = 0; k < ROOM; ++k) wrong += left_over > 0 && !taken[k];
  wrong += now.all.without != left_over;
  tm_lives_next(life, ROOM, &now.all, now.now, 0, id, count, next, &parts);
  for (size_t i = 0; i < count; ++i) {
    if (next[i] < ROOM) { now.known[id[i]] = true; now.place[id[i]] = next[i]; now.last[id[i]] = now.now; }
  }
  for (int e = 1; e <= 4; ++e) now.there[e] = here[e] && now.known[e];
  for (size_t k = 0; k < ROOM; ++k) now.life[k] = life[k];
  wrong += parts != 2;
  now.any = true;
  ++cycles;
  free(id); free(place); free(next); free(life);
  if (left > 0) go_on(now, left - 1);
}

static void seen(kept now, const uint64_t *given, size_t count, int left) {
  kept later = now;
  now.now += 1;
  seen_at(now, given, count, left);
  if (left < 2) { later.now += 3; seen_at(later, given, count, left); }
}
"""
TYPES = Path(build.__file__).with_name("templates") / "program" / "over_run" / "types.h.j2"


def counted(text: str, names: list[str], folder: Path, types: Sequence[str] = ()) -> tuple[int, int, int]:
    """Cycles that were seen, what was wrong in them, and how often an element was known again where it was not to be expected."""
    parts = "\n".join([*types, *(functions()[name] for name in names)])
    (folder / "places.c").write_text(HEAD.replace("PARTS", parts) + text + TAIL, encoding="utf-8")
    command = [*(compiler() or []), *FLAGS, "-w", "places.c", "-o", "places"]
    subprocess.run(command, cwd=folder, check=True)
    done = subprocess.run([folder / "places"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    cycles, wrong, again = map(int, done.stdout.split())
    return cycles, wrong, again


def test_each_has_its_own_and_keeps_it(tmp_path: Path) -> None:
    cycles, wrong, again = counted(PRESENT, ["tm_places_of", "tm_places_next"], tmp_path)
    assert cycles == 41 + 41**2 + 41**3
    assert wrong == 0
    assert again > 1000


def test_who_is_absent_for_a_while_keeps_it_too(tmp_path: Path) -> None:
    types = re.findall(r"typedef struct \{[^{}]*\} tm_(?:life|lives);", TYPES.read_text(encoding="utf-8"))
    assert len(types) == 2
    cycles, wrong, again = counted(ABSENT, ["tm_lives_begin", "tm_lives_next"], tmp_path, types)
    assert cycles == 41 + 2 * 41**2 + 4 * 41**3
    assert wrong == 0
    assert again > 1000
