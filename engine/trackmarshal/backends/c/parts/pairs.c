/* Pairs of elements of which something is remembered. */

/** The places of pairs of elements, of which each has one of its own, or TM_NO_PLACE: all seconds of a first one lie together. */
static void tm_pairs_of(const size_t *first, size_t first_count, const size_t *second, size_t second_count, size_t room,
                        size_t place[][TM_MAX_ELEMENTS], size_t *parts) {
  for (size_t i = 0u; i < first_count; ++i) {
    for (size_t k = 0u; k < second_count; ++k) {
      const bool both = (first[i] != TM_NO_PLACE) && (second[k] != TM_NO_PLACE);
      place[i][k] = both ? ((first[i] * room) + second[k]) : TM_NO_PLACE;
    }
  }
  ++*parts;
}

/** The same of elements that may be absent. A pair that was never there together is new, and maybe no new one where one of both is not surely
    new: `sure` says of those that have a place whether nothing was before. */
static void tm_pairs_begin(const tm_pair *pair, const size_t *first, const bool *first_sure, size_t first_room, size_t first_count,
                           const size_t *second, const bool *second_sure, size_t second_room, size_t second_count,
                           size_t place[][TM_MAX_ELEMENTS], size_t *parts) {
  for (size_t i = 0u; i < first_count; ++i) {
    const size_t p = first[i];
    const bool sure = (p < first_room) ? first_sure[p] : (p == TM_NO_PLACE);
    for (size_t k = 0u; k < second_count; ++k) {
      const size_t q = second[k];
      const bool both = sure && ((q < second_room) ? second_sure[q] : (q == TM_NO_PLACE));
      if ((p == TM_WITHOUT) || (q == TM_WITHOUT)) {
        place[i][k] = TM_WITHOUT;
      } else if ((p < first_room) && (q < second_room) && pair[(p * second_room) + q].used) {
        place[i][k] = (p * second_room) + q;
      } else {
        place[i][k] = both ? TM_NO_PLACE : TM_MAYBE_NEW;
      }
    }
  }
  ++*parts;
}

/** The present cycle is past: who was there together, and for how many cycles other pairs have not been. */
static void tm_pairs_next(tm_pair *pair, const tm_life *first, size_t first_room, const size_t *first_next, size_t first_count,
                          const tm_life *second, size_t second_room, const size_t *second_next, size_t second_count, int64_t now,
                          uint64_t missed, size_t *parts) {
  for (size_t p = 0u; p < first_room; ++p) {
    for (size_t q = 0u; q < second_room; ++q) {
      tm_pair *each = &pair[(p * second_room) + q];
      each->used = each->used && first[p].kept && second[q].kept;
      each->cycles += 1u + missed;
    }
  }
  for (size_t i = 0u; i < first_count; ++i) {
    for (size_t k = 0u; k < second_count; ++k) {
      if ((first_next[i] != TM_NO_PLACE) && (second_next[k] != TM_NO_PLACE)) {
        tm_pair *each = &pair[(first_next[i] * second_room) + second_next[k]];
        each->used = true;
        each->seen = now;
        each->cycles = 0u;
      }
    }
  }
  ++*parts;
}

/** Of the elements whose life begins, whether nothing was before it. */
static void tm_pairs_sure(const size_t *place, const size_t *next, size_t count, bool *sure, size_t *parts) {
  for (size_t i = 0u; i < count; ++i) {
    if ((place[i] >= TM_WITHOUT) && (next[i] != TM_NO_PLACE)) {
      sure[next[i]] = place[i] == TM_NO_PLACE;
    }
  }
  ++*parts;
}

/** How many cycles lie between the last one in which a pair was there and this one, and when that was. */
static uint64_t tm_pairs_absent(const tm_pair *pair, size_t room, size_t place, uint64_t missed, int64_t *last) {
  uint64_t cycles = missed;
  if (place < room) {
    cycles += pair[place].cycles;
    *last = pair[place].seen;
  }
  return cycles;
}
