/* Operators over the run: steps and tallies of cycles, and the elements of which they are remembered. */

/** What may be anything. */
static tm_cases tm_unknown_any(void) {
  const tm_cases a = {-TM_INF, TM_INF, false, true};
  return a;
}

/** What reads the trajectory that is driven, where one is. */
static tm_cases tm_if_driven(bool driven, tm_cases a) {
  return driven ? a : tm_unknown_any();
}

/** The step of no cycle: it did not hold before, and what held would go on. */
static tm_steps tm_no_step(void) {
  const tm_steps a = {{-TM_INF, -TM_INF, false, false}, {TM_INF, TM_INF, true, true}};
  return a;
}

/** The step of a cycle of which nothing is known. */
static tm_steps tm_any_step(void) {
  const tm_steps a = {{-TM_INF, TM_INF, false, true}, {-TM_INF, TM_INF, false, true}};
  return a;
}

/** A newer step after an older one. */
static tm_steps tm_step_after(tm_steps newer, tm_steps older) {
  const tm_steps both = {tm_or_any(newer.goal, tm_and_any(newer.hold, older.goal)), tm_and_any(newer.hold, older.hold)};
  return both;
}

/** The tally of no cycle. */
static tm_tally tm_no_tally(void) {
  const tm_tally a = {0u, 0u, false, false};
  return a;
}

/** The tally of so many cycles of which nothing is known. */
static tm_tally tm_any_tally(uint64_t cycles, bool anew) {
  const tm_tally a = {0u, cycles, false, anew};
  return a;
}

/** The tally of one cycle. */
static tm_tally tm_tally_of(tm_cases counted, tm_cases reset) {
  const tm_tally a = {counted.worst_sat ? 1u : 0u, counted.best_sat ? 1u : 0u, reset.worst_sat, reset.best_sat};
  return a;
}

/** A newer tally and an older one: of what comes before the count starts anew, nothing counts. */
static tm_tally tm_tallied(tm_tally newer, tm_tally older) {
  const tm_tally both = {
      newer.sure + (newer.possibly_anew ? 0u : older.sure), newer.possible + (newer.surely_anew ? 0u : older.possible),
      newer.surely_anew || older.surely_anew, newer.possibly_anew || older.possibly_anew};
  return both;
}

/** A comparison whose margin lies between two; `at_zero`: it holds at zero. */
static tm_cases tm_told_between(double limit, double worst, double best, bool at_zero) {
  tm_cases a = {worst, best, (worst > 0.0) || (at_zero && (worst == 0.0)), (best > 0.0) || (at_zero && (best == 0.0))};
  return tm_finite(limit) ? a : tm_unknown_any();
}

/** The whole number of a tally that is nearest to a limit. */
static double tm_tally_near(tm_tally n, double limit) {
  const double low = (double)n.sure;
  const double high = (double)n.possible;
  const double whole = rint(limit);
  const double least = (whole > low) ? whole : low;
  return (least < high) ? least : high;
}

/** A number of cycles below a limit. */
static tm_cases tm_count_less(tm_tally n, double limit) {
  return tm_told_between(limit, limit - (double)n.possible, limit - (double)n.sure, false);
}

/** A number of cycles up to a limit. */
static tm_cases tm_count_at_most(tm_tally n, double limit) {
  return tm_told_between(limit, limit - (double)n.possible, limit - (double)n.sure, true);
}

/** A number of cycles above a limit. */
static tm_cases tm_count_greater(tm_tally n, double limit) {
  return tm_told_between(limit, (double)n.sure - limit, (double)n.possible - limit, false);
}

/** A number of cycles from a limit on. */
static tm_cases tm_count_at_least(tm_tally n, double limit) {
  return tm_told_between(limit, (double)n.sure - limit, (double)n.possible - limit, true);
}

/** The most that a tally may be away from a limit. */
static double tm_tally_far(tm_tally n, double limit) {
  return tm_greatest(fabs((double)n.sure - limit), fabs((double)n.possible - limit));
}

/** So many cycles. */
static tm_cases tm_count_equal(tm_tally n, double limit) {
  return tm_told_between(limit, -tm_tally_far(n, limit), -fabs(tm_tally_near(n, limit) - limit), true);
}

/** Any other number of cycles. */
static tm_cases tm_count_unequal(tm_tally n, double limit) {
  return tm_told_between(limit, fabs(tm_tally_near(n, limit) - limit), tm_tally_far(n, limit), false);
}

/** A time in whole nanoseconds, to the nearest; whether it is one that can be counted with. */
static bool tm_nanoseconds(double t, int64_t *found) {
  const double whole = rint(t * 1e9);
  const bool fits = fabs(whole) < 4e18;
  *found = fits ? (int64_t)whole : 0;
  return fits;
}

/** Whether ids are there, and no two of them alike. */
static bool tm_ids_differ(const uint64_t *id, size_t count) {
  bool distinct = (id != NULL) || (count == 0u);
  for (size_t i = 1u; (i < count) && distinct; ++i) {
    for (size_t k = 0u; k < i; ++k) {
      distinct = distinct && (id[k] != id[i]);
    }
  }
  return distinct;
}

/** The first element with an id that stands before it already. */
static size_t tm_id_again(const uint64_t *id, size_t count) {
  for (size_t i = 1u; i < count; ++i) {
    if (!tm_ids_differ(id, i + 1u)) {
      return i;
    }
  }
  return (size_t)-1;
}

/** The places of elements among those of the last cycle; TM_NO_PLACE for new ones. Most often each is where it was. */
static void tm_places_of(const uint64_t *id, size_t count, const uint64_t *known, const bool *used, size_t *place, size_t *parts) {
  for (size_t i = 0u; i < count; ++i) {
    size_t found = (used[i] && (known[i] == id[i])) ? i : TM_NO_PLACE;
    for (size_t k = 0u; (k < TM_MAX_ELEMENTS) && (found == TM_NO_PLACE); ++k) {
      if (used[k] && (known[k] == id[i])) {
        found = k;
      }
    }
    place[i] = found;
  }
  ++*parts;
}

/** The places from now on: those that are gone leave theirs, and new ones take what is free. */
static void tm_places_next(size_t count, bool *used, const size_t *place, size_t *next, size_t *parts) {
  size_t free = 0u;
  for (size_t k = 0u; k < TM_MAX_ELEMENTS; ++k) {
    used[k] = false;
  }
  for (size_t i = 0u; i < count; ++i) {
    next[i] = place[i];
    if (place[i] != TM_NO_PLACE) {
      used[place[i]] = true;
    }
  }
  for (size_t i = 0u; i < count; ++i) {
    if (next[i] == TM_NO_PLACE) {
      while (used[free]) {
        ++free;
      }
      next[i] = free;
      used[free] = true;
    }
  }
  ++*parts;
}
