/* Elements that may be absent, and are known again. */

/** Who is known again, and who gets which place, of elements that may be absent: in `place` where something is remembered of each, or
    TM_NO_PLACE (it is new), TM_MAYBE_NEW (it may be one that found no place) or TM_WITHOUT; in `next` its place from now on. */
static void tm_lives_begin(tm_life *life, size_t room, tm_lives *all, bool first, int64_t forget, int64_t now, const uint64_t *id, size_t count,
                           size_t *place, size_t *next, size_t *parts) {
  size_t free = 0u;
  bool sure;
  if (first) {
    all->lost = false;
  }
  sure = !all->lost || ((all->cycles > 0u) && ((now - all->t) > forget));
  for (size_t k = 0u; k < room; ++k) {
    bool there = false;
    for (size_t i = 0u; i < count; ++i) {
      there = there || (id[i] == life[k].id);
    }
    life[k].kept = !first && life[k].used &&
                   (there ? ((life[k].cycles == 0u) || ((now - life[k].seen) <= forget)) : ((now - life[k].seen) < forget));
    life[k].taken = life[k].kept;
  }
  for (size_t i = 0u; i < count; ++i) {
    next[i] = TM_NO_PLACE;
    for (size_t k = 0u; (k < room) && (next[i] == TM_NO_PLACE); ++k) {
      if (life[k].kept && (life[k].id == id[i])) {
        next[i] = k;
      }
    }
    place[i] = next[i];
  }
  all->sure = sure;
  all->without = 0u;
  for (size_t i = 0u; i < count; ++i) {
    if (next[i] == TM_NO_PLACE) {
      while ((free < room) && life[free].taken) {
        ++free;
      }
      if (free < room) {
        next[i] = free;
        life[free].taken = true;
        place[i] = sure ? TM_NO_PLACE : TM_MAYBE_NEW;
      } else {
        place[i] = TM_WITHOUT;
        ++all->without;
      }
    }
  }
  ++*parts;
}

/** The present cycle is past: who was there, and for how many cycles others have been absent. */
static void tm_lives_next(tm_life *life, size_t room, tm_lives *all, int64_t now, uint64_t missed, const uint64_t *id, size_t count,
                          const size_t *next, size_t *parts) {
  for (size_t k = 0u; k < room; ++k) {
    life[k].used = life[k].kept;
    life[k].cycles += 1u + missed;
  }
  for (size_t i = 0u; i < count; ++i) {
    if (next[i] != TM_NO_PLACE) {
      life[next[i]].id = id[i];
      life[next[i]].used = true;
      life[next[i]].seen = now;
      life[next[i]].cycles = 0u;
    }
  }
  if (all->without > 0u) {
    all->lost = true;
    all->t = now;
    all->cycles = 0u;
  } else if (all->lost && !all->sure) {
    ++all->cycles;
  } else {
    all->lost = false;
  }
  ++*parts;
}

/** How many cycles lie between the last one of an element and this one, and when that was. */
static uint64_t tm_absent(const tm_life *life, size_t room, size_t place, uint64_t missed, int64_t *last) {
  uint64_t cycles = missed;
  if (place < room) {
    cycles += life[place].cycles;
    *last = life[place].seen;
  }
  return cycles;
}
