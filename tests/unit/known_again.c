/* Random elements that come and go, by ids: says how many cycles there were, how many had an id twice, in how many C found another one than is there,
   and how often an element was taken for another one, or for a new one. */
#include "supervisor.c"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define IDS 9u

static uint64_t state = 1u;

static size_t below(size_t limit) {
  state = (state * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
  return (size_t)((state >> 33) % limit);
}

int main(int count, char **words) {
  const long cycles = (count > 1) ? atol(words[1]) : 1000;
  uint64_t known[TM_MAX_ELEMENTS] = {0u};
  bool used[TM_MAX_ELEMENTS] = {false};
  size_t where[IDS]; /* the place of each id in the last cycle */
  long twice = 0;
  long missed = 0;
  long mistaken = 0;
  for (size_t k = 0u; k < IDS; ++k) { where[k] = TM_NO_PLACE; }
  for (long cycle = 0; cycle < cycles; ++cycle) {
    const size_t elements = below(TM_MAX_ELEMENTS + 1u);
    uint64_t id[TM_MAX_ELEMENTS];
    size_t place[TM_MAX_ELEMENTS];
    size_t next[TM_MAX_ELEMENTS];
    size_t parts = 0u;
    size_t seen[IDS] = {0u};
    size_t again = (size_t)-1;
    bool taken[TM_MAX_ELEMENTS] = {false};
    for (size_t i = 0u; i < elements; ++i) {
      id[i] = (uint64_t)below(IDS);
      again = ((seen[id[i]] > 0u) && (again == (size_t)-1)) ? i : again;
      ++seen[id[i]];
    }
    missed += (tm_ids_differ(id, elements) != (again == (size_t)-1)) ? 1 : 0;
    missed += (tm_id_again(id, elements) != again) ? 1 : 0;
    if (again != (size_t)-1) {
      ++twice;
      continue;
    }
    tm_places_of(id, elements, known, used, place, &parts);
    tm_places_next(elements, used, place, next, &parts);
    for (size_t i = 0u; i < elements; ++i) {
      mistaken += (place[i] != where[id[i]]) ? 1 : 0;
      mistaken += ((place[i] != TM_NO_PLACE) && (next[i] != place[i])) ? 1 : 0;
      mistaken += ((next[i] >= TM_MAX_ELEMENTS) || taken[next[i]] || !used[next[i]]) ? 1 : 0;
      taken[next[i]] = true;
      known[next[i]] = id[i];
    }
    for (size_t k = 0u; k < IDS; ++k) { where[k] = TM_NO_PLACE; }
    for (size_t i = 0u; i < elements; ++i) { where[id[i]] = next[i]; }
  }
  (void)printf("%ld %ld %ld %ld\n", cycles, twice, missed, mistaken);
  return 0;
}
