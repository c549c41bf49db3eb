"""Which element has which place in the memory of generated C: all sequences of a few cycles, at the brim of what there is room for."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from support.sanitized import FLAGS
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.parts import functions

#: Ids, of which as many as there is room for come in a cycle, in any order. Arrays are as long as what is in them, and not longer.
HARNESS = r"""
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#define TM_MAX_ELEMENTS 3
#define TM_NO_PLACE ((size_t)-1)
PARTS
typedef struct { uint64_t known[TM_MAX_ELEMENTS]; bool used[TM_MAX_ELEMENTS]; } kept;
static long cycles, wrong, again;

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
  kept none = {{0}, {false}};
  go_on(none, 2);
  printf("%ld %ld %ld\n", cycles, wrong, again);
  return 0;
}
"""


@pytest.mark.verifies("S-1-B-4")
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_each_has_its_own_and_keeps_it(tmp_path: Path) -> None:
    parts = "\n".join(functions()[name] for name in ("tm_places_of", "tm_places_next"))
    (tmp_path / "places.c").write_text(HARNESS.replace("PARTS", parts), encoding="utf-8")
    command = [*(compiler() or []), *FLAGS, "-w", "places.c", "-o", "places"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "places"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    cycles, wrong, again = map(int, done.stdout.split())
    assert cycles == 41 + 41**2 + 41**3
    assert wrong == 0
    assert again > 1000
