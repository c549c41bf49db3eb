/* What rules that look ahead say of the cycles that are kept, as far as that is known. */

/** What is known of one cycle, and will stay so. */
static tm_known tm_known_now(tm_cases value) {
  const tm_known known = {value, true};
  return known;
}

/** What may still become anything. */
static tm_known tm_not_yet(void) {
  const tm_known known = {tm_unknown_any(), false};
  return known;
}

/** not p. */
static tm_known tm_not_known(tm_known p) {
  const tm_known known = {tm_not_any(p.value), p.final};
  return known;
}

/** p and q. */
static tm_known tm_and_known(tm_known p, tm_known q) {
  const tm_known known = {tm_and_any(p.value, q.value), p.final && q.final};
  return known;
}

/** p or q. */
static tm_known tm_or_known(tm_known p, tm_known q) {
  const tm_known known = {tm_or_any(p.value, q.value), p.final && q.final};
  return known;
}

/** p xor q. */
static tm_known tm_xor_known(tm_known p, tm_known q) {
  const tm_known known = {tm_xor_any(p.value, q.value), p.final && q.final};
  return known;
}

/** Whenever p, q. */
static tm_known tm_whenever_known(tm_known p, tm_known q) {
  const tm_known known = {tm_whenever_any(p.value, q.value), p.final && q.final};
  return known;
}

/** One more of those that all have to hold, where p. */
static void tm_for_all_known(tm_known *all, tm_known p, tm_known q) {
  tm_for_all_where_any(&all->value, p.value, q.value);
  all->final = all->final && p.final && q.final;
}

/** One more of those of which one has to hold, where p. */
static void tm_exists_known(tm_known *some, tm_known p, tm_known q) {
  tm_exists_where_any(&some->value, p.value, q.value);
  some->final = some->final && p.final && q.final;
}

/** The slot of a cycle that is kept, by its place from the oldest on. */
static size_t tm_slot(const tm_track *track, size_t place) {
  const size_t slot = track->oldest + place;
  return (slot < track->room) ? slot : (slot - track->room);
}

/** Whether what a track is about was in a cycle already when it began: that it is no new one there. */
static bool tm_goes_on(const tm_track *track, size_t place) {
  const size_t at = tm_slot(track, place) * track->stride;
  return (track->there == NULL) || (track->there[at] && !track->fresh[at]);
}

/** Whether there was a cycle before the oldest that is kept. */
static bool tm_before_oldest(const tm_track *track) {
  return (track->first > 0u) && tm_goes_on(track, 0u);
}

/** The value of an operand about a cycle. */
static tm_known tm_given(const tm_track *track, tm_operand p, size_t place) {
  return p.value[tm_slot(track, place) * p.stride];
}

/** One more cycle of a window, or on the way to it, from one's own outwards. */
static void tm_take(tm_progress *so_far, tm_window_kind kind, tm_cases p, tm_cases q, bool inside) {
  if (inside && (kind == TM_SOME)) {
    so_far->value = tm_or_any(so_far->value, p);
  } else if (inside && (kind == TM_EVERY)) {
    so_far->value = tm_and_any(so_far->value, p);
  } else if (inside) {
    so_far->value = tm_or_any(so_far->value, tm_and_any(so_far->held, q));
  } else {
    /* it is only on the way */
  }
  if (kind == TM_HELD) {
    so_far->held = tm_and_any(so_far->held, p);
  }
}

/** A window that holds nothing yet. */
static tm_progress tm_begun(tm_window_kind kind, uint64_t own) {
  const tm_progress begun = {(kind == TM_EVERY) ? tm_true_any() : tm_false_any(), tm_true_any(), own};
  return begun;
}

/** eventually, always, until: the value about a cycle, as far as cycles go. What cannot change any more is taken up in `so_far`. */
static tm_known tm_ahead_of(const tm_track *track, tm_window_kind kind, size_t own, int64_t lower, int64_t upper, tm_operand p,
                            tm_operand q, tm_progress *so_far, bool keep) {
  const int64_t t = track->t[tm_slot(track, own)];
  const int64_t low = t + lower;
  const int64_t high = t + upper;
  tm_progress now = *so_far;
  tm_known known;
  bool final = true;
  bool over = false;
  size_t place = (size_t)(now.next - track->first);
  while (!over && (place < track->count)) {
    const size_t slot = tm_slot(track, place);
    if ((place > own) && !tm_goes_on(track, place)) {
      over = true; /* what it is about is gone */
    } else {
      if ((place > own) && (track->missed[slot] > 0u)) {
        const bool inside = (track->t[tm_slot(track, place - 1u)] < high) && (track->t[slot] > low);
        tm_take(&now, kind, tm_unknown_any(), tm_unknown_any(), inside);
      }
      if (track->t[slot] > high) {
        over = true;
      } else {
        const tm_known left = tm_given(track, p, place);
        const tm_known right = tm_given(track, q, place);
        tm_take(&now, kind, left.value, right.value, track->t[slot] >= low);
        final = final && left.final && right.final;
        ++place;
        if (final && keep) {
          now.next = track->first + (uint64_t)place;
          *so_far = now;
        }
      }
    }
  }
  if (!over && !track->ended && (track->t[tm_slot(track, track->count - 1u)] < high)) {
    tm_take(&now, kind, tm_unknown_any(), tm_unknown_any(), true); /* what is to come */
    final = false;
  }
  known.value = now.value;
  known.final = final;
  return known;
}

/** next: the value one cycle on; where none will come, false, or true when weak. */
static tm_known tm_one_ahead(const tm_track *track, size_t own, bool weak, tm_operand p) {
  const size_t place = own + 1u;
  tm_known known = tm_known_now(weak ? tm_true_any() : tm_false_any());
  if (place >= track->count) {
    if (!track->ended) {
      known = tm_not_yet();
    }
  } else if (tm_goes_on(track, place)) {
    known = (track->missed[tm_slot(track, place)] > 0u) ? tm_known_now(tm_unknown_any()) : tm_given(track, p, place);
  } else {
    /* what it is about is gone */
  }
  return known;
}

/** previous: the value one cycle back; before the first one, false, or true when weak. */
static tm_known tm_one_back(const tm_track *track, size_t own, bool weak, tm_operand p) {
  tm_known known = tm_known_now(weak ? tm_true_any() : tm_false_any());
  if ((own > 0u) && tm_goes_on(track, own)) {
    known = (track->missed[tm_slot(track, own)] > 0u) ? tm_known_now(tm_unknown_any()) : tm_given(track, p, own - 1u);
  } else if ((own == 0u) && tm_before_oldest(track)) {
    known = tm_known_now(tm_unknown_any());
  } else {
    /* it is the first */
  }
  return known;
}

/** once, historically, since over what looks ahead: the value about a cycle. */
static tm_known tm_back_from(const tm_track *track, tm_window_kind kind, size_t own, int64_t lower, int64_t upper, tm_operand p,
                             tm_operand q) {
  const int64_t t = track->t[tm_slot(track, own)];
  const int64_t low = t - upper;
  const int64_t high = t - lower;
  tm_progress now = tm_begun(kind, 0u);
  tm_known known;
  bool final = true;
  bool over = false;
  for (size_t left = own + 1u; (left > 0u) && !over; --left) {
    const size_t place = left - 1u;
    const size_t slot = tm_slot(track, place);
    if (track->t[slot] < low) {
      over = true;
    } else {
      const tm_known a = tm_given(track, p, place);
      const tm_known b = tm_given(track, q, place);
      tm_take(&now, kind, a.value, b.value, track->t[slot] <= high);
      final = final && a.final && b.final;
      if (!tm_goes_on(track, place)) {
        over = true; /* it was new there */
      } else if ((place > 0u) && (track->missed[slot] > 0u)) {
        const bool inside = (track->t[tm_slot(track, place - 1u)] < high) && (track->t[slot] > low);
        tm_take(&now, kind, tm_unknown_any(), tm_unknown_any(), inside);
      } else if ((place == 0u) && tm_before_oldest(track)) {
        tm_take(&now, kind, tm_unknown_any(), tm_unknown_any(), true); /* it is not kept any more */
      } else {
        /* one further back */
      }
    }
  }
  known.value = now.value;
  known.final = final;
  return known;
}

/** The same without a bound: from what it came to one cycle before. */
static tm_known tm_ever_back(const tm_track *track, tm_window_kind kind, size_t own, tm_operand p, tm_operand q, tm_operand before) {
  const tm_known a = tm_given(track, p, own);
  const tm_known b = tm_given(track, q, own);
  tm_progress now = tm_begun(kind, 0u);
  tm_known known;
  bool final = a.final && b.final;
  tm_take(&now, kind, a.value, b.value, true);
  if ((own > 0u) && tm_goes_on(track, own)) {
    const tm_known then = tm_given(track, before, own - 1u);
    if (track->missed[tm_slot(track, own)] > 0u) {
      tm_take(&now, kind, tm_unknown_any(), tm_unknown_any(), true);
    }
    tm_take(&now, kind, (kind == TM_HELD) ? tm_true_any() : then.value, then.value, true);
    final = final && then.final;
  } else if ((own == 0u) && tm_before_oldest(track)) {
    tm_take(&now, kind, tm_unknown_any(), tm_unknown_any(), true);
  } else {
    /* it is the first */
  }
  known.value = now.value;
  known.final = final;
  return known;
}

/** In how many cycles of a window something held that looks ahead. */
static tm_tally_known tm_count_from(const tm_track *track, size_t own, int64_t lower, int64_t upper, tm_operand p) {
  const int64_t t = track->t[tm_slot(track, own)];
  const int64_t low = t - upper;
  const int64_t high = t - lower;
  tm_tally_known all = {tm_no_tally(), true};
  bool over = false;
  for (size_t left = own + 1u; (left > 0u) && !over; --left) {
    const size_t place = left - 1u;
    const size_t slot = tm_slot(track, place);
    if (track->t[slot] < low) {
      over = true;
    } else {
      const tm_known a = tm_given(track, p, place);
      if (track->t[slot] <= high) {
        all.tally = tm_tallied(all.tally, tm_tally_of(a.value, tm_false_any()));
      }
      all.final = all.final && a.final;
      if (!tm_goes_on(track, place)) {
        over = true; /* it was new there */
      } else if ((place > 0u) && (track->missed[slot] > 0u)) {
        if ((track->t[tm_slot(track, place - 1u)] < high) && (track->t[slot] > low)) {
          all.tally = tm_tallied(all.tally, tm_any_tally(track->missed[slot], false));
        }
      } else if ((place == 0u) && tm_before_oldest(track)) {
        all.tally = tm_tallied(all.tally, tm_any_tally(UINT64_C(1) << 60u, false)); /* they are not kept any more */
      } else {
        /* one further back */
      }
    }
  }
  return all;
}
