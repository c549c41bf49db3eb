/** x * x. */
static inline double tm_square(double x) {
  return x * x;
}

/** What is true of itself. */
static inline tm_truth tm_true(void) {
  const tm_truth a = {TM_INF, true, 0.0};
  return a;
}

/** What is false of itself. */
static inline tm_truth tm_false(void) {
  const tm_truth a = {-TM_INF, false, 0.0};
  return a;
}

/** A Boolean. */
static inline tm_truth tm_told(bool sat) {
  const tm_truth a = {sat ? TM_INF : -TM_INF, sat, 0.0};
  return a;
}

/** A flag of an input. */
static inline tm_truth tm_flagged(tm_flag flag) {
  const tm_truth a = {(flag == TM_TRUE) ? TM_INF : -TM_INF, flag == TM_TRUE, tm_missing(flag) ? TM_NAN : 0.0};
  return a;
}

/** A comparison that has this margin; one that shows an operand that may not be finite makes it unknown. */
static inline tm_truth tm_compared(bool sat, double margin) {
  const tm_truth a = {margin, sat, margin * 0.0};
  return a;
}

/** left < right. */
static inline tm_truth tm_less(double left, double right) {
  return tm_compared(left < right, right - left);
}

/** left <= right. */
static inline tm_truth tm_at_most(double left, double right) {
  return tm_compared(left <= right, right - left);
}

/** left > right. */
static inline tm_truth tm_greater(double left, double right) {
  return tm_compared(left > right, left - right);
}

/** left >= right. */
static inline tm_truth tm_at_least(double left, double right) {
  return tm_compared(left >= right, left - right);
}

/** left == right. */
static inline tm_truth tm_equal(double left, double right) {
  return tm_compared(left == right, -fabs(left - right));
}

/** left != right. */
static inline tm_truth tm_unequal(double left, double right) {
  return tm_compared(left != right, fabs(left - right));
}

/** Both are places of one member of an enumeration: a Boolean of two numbers. */
static inline tm_truth tm_is(double left, double right) {
  const tm_truth a = {(left == right) ? TM_INF : -TM_INF, left == right, (left * 0.0) + (right * 0.0)};
  return a;
}

/** A geometric predicate: its margin is a distance, and it holds where that is not negative. */
static inline tm_truth tm_apart_by(double distance) {
  return tm_compared(distance >= 0.0, distance);
}

/** A formula whose margin is divided by a scale. */
static inline tm_truth tm_scaled(tm_truth a, double scale) {
  const tm_truth b = {a.margin / scale, a.sat, a.doubt};
  return b;
}

/** not a. */
static inline tm_truth tm_not(tm_truth a) {
  const tm_truth b = {-a.margin, !a.sat, a.doubt};
  return b;
}

/** a and b: the lesser margin. */
static inline tm_truth tm_and(tm_truth a, tm_truth b) {
  const tm_truth both = {tm_least(a.margin, b.margin), a.sat && b.sat, a.doubt + b.doubt};
  return both;
}

/** a or b: the greater margin. */
static inline tm_truth tm_or(tm_truth a, tm_truth b) {
  const tm_truth either = {tm_greatest(a.margin, b.margin), a.sat || b.sat, a.doubt + b.doubt};
  return either;
}

/** a xor b. */
static inline tm_truth tm_xor(tm_truth a, tm_truth b) {
  const double apart = tm_greatest(tm_greatest(0.0, tm_apart(a.margin, b.margin)), tm_apart(b.margin, a.margin));
  const tm_truth one = {apart, (a.sat && !b.sat) || (b.sat && !a.sat), a.doubt + b.doubt};
  return one;
}

/** Whether a formula holds, for all that is known. */
static inline bool tm_may_hold(tm_truth a) {
  return a.sat || !(a.doubt == 0.0);
}

/** Whenever the guard holds, the body; nothing is demanded otherwise. */
static inline tm_truth tm_whenever(tm_truth guard, tm_truth body) {
  const tm_truth a = {guard.sat ? body.margin : TM_INF, !guard.sat || body.sat, guard.doubt + (guard.sat ? body.doubt : 0.0)};
  return a;
}

/** One more of those that all have to hold. */
static inline void tm_for_all(tm_truth *all, tm_truth body) {
  *all = tm_and(*all, body);
}

/** One more of those of which one has to hold. */
static inline void tm_exists(tm_truth *some, tm_truth body) {
  *some = tm_or(*some, body);
}

/** One more of those that all have to hold, if it is in range. */
static inline void tm_for_all_where(tm_truth *all, tm_truth guard, tm_truth body) {
  const tm_truth next = tm_and(*all, body);
  all->margin = guard.sat ? next.margin : all->margin;
  all->sat = guard.sat ? next.sat : all->sat;
  all->doubt = guard.doubt + (guard.sat ? next.doubt : all->doubt);
}

/** One more of those of which one has to hold, if it is in range. */
static inline void tm_exists_where(tm_truth *some, tm_truth guard, tm_truth body) {
  const tm_truth next = tm_or(*some, body);
  some->margin = guard.sat ? next.margin : some->margin;
  some->sat = guard.sat ? next.sat : some->sat;
  some->doubt = guard.doubt + (guard.sat ? next.doubt : some->doubt);
}

/** One of two numbers; NaN where what decides is not known. */
static inline double tm_select(tm_truth condition, double then, double otherwise) {
  return (condition.doubt == 0.0) ? (condition.sat ? then : otherwise) : TM_NAN;
}

/** Keep a sample of a series; `known` remembers whether all of them were. */
static inline void tm_keep(tm_series *series, size_t i, tm_truth a, bool *known) {
  series->margin[i] = a.margin;
  series->sat[i] = a.sat;
  *known = *known && (a.doubt == 0.0);
}

/** A sample of a series all of which is known. */
static inline tm_truth tm_kept(const tm_series *series, size_t i) {
  const tm_truth a = {series->margin[i], series->sat[i], 0.0};
  return a;
}

/** What a rule says, if all that it needs is known; whether that is so. */
static inline bool tm_conclude(tm_result *out, tm_truth applies, tm_truth holds) {
  const bool known = (applies.doubt + holds.doubt) == 0.0;
  if (known) {
    tm_decide(out, !applies.sat, holds.sat, holds.sat, holds.margin, holds.margin);
  }
  return known;
}

/** The same of what holds exactly where its margin is not negative. */
static inline bool tm_conclude_margin(tm_result *out, tm_truth applies, tm_truth holds) {
  const tm_truth told = {holds.margin, holds.margin >= 0.0, holds.doubt};
  return tm_conclude(out, applies, told);
}

/** How many times several samples go into so many, the last time with some again; none where there are fewer than that. */
static inline size_t tm_passes(size_t count) {
  return (count < TM_SEVERAL) ? 0u : ((count + (TM_SEVERAL - 1u)) / TM_SEVERAL);
}

/** The first sample of a pass: the last pass ends with the last sample. */
static inline size_t tm_pass_first(size_t pass, size_t count) {
  const size_t last = count - TM_SEVERAL;
  const size_t first = pass * TM_SEVERAL;
  return (first < last) ? first : last;
}

/** Several formulas' values, none of them known where there are samples, but too few for a pass. */
static inline tm_several tm_several_of(double margin, size_t count) {
  tm_several all;
  const double doubt = ((count > 0u) && (count < TM_SEVERAL)) ? TM_NAN : 0.0;
  for (size_t n = 0u; n < TM_SEVERAL; ++n) {
    all.margin[n] = margin;
    all.doubt[n] = doubt;
    all.guard[n] = 0.0;
    all.body[n] = 0.0;
  }
  return all;
}

/** Nothing yet of those that all have to hold. */
static inline tm_several tm_several_true(size_t count) {
  return tm_several_of(TM_INF, count);
}

/** Nothing yet of those of which one has to hold. */
static inline tm_several tm_several_false(size_t count) {
  return tm_several_of(-TM_INF, count);
}

/** The formula of one sample of a pass. Its margin says whether it holds, and NaN that this is not known. */
static inline void tm_put(tm_several *all, size_t n, tm_truth body) {
  all->body[n] = body.margin + body.doubt;
}

/** The same of a sample that may be in range. */
static inline void tm_put_where(tm_several *all, size_t n, tm_truth guard, tm_truth body) {
  all->guard[n] = tm_select(guard, 1.0, -1.0);
  all->body[n] = body.margin + body.doubt;
}

/** A pass more of those that all have to hold. */
static inline void tm_for_all_put(tm_several *all) {
  for (size_t n = 0u; n < TM_SEVERAL; ++n) {
    all->margin[n] = tm_least(all->margin[n], all->body[n]);
    all->doubt[n] += all->body[n] * 0.0;
  }
}

/** A pass more of those of which one has to hold. */
static inline void tm_exists_put(tm_several *some) {
  for (size_t n = 0u; n < TM_SEVERAL; ++n) {
    some->margin[n] = tm_greatest(some->margin[n], some->body[n]);
    some->doubt[n] += some->body[n] * 0.0;
  }
}

/** A pass more of those that all have to hold, if they are in range. */
static inline void tm_for_all_put_where(tm_several *all) {
  for (size_t n = 0u; n < TM_SEVERAL; ++n) {
    const bool there = all->guard[n] > 0.0;
    const double margin = there ? all->body[n] : TM_INF;
    const double doubt = there ? (all->body[n] * 0.0) : 0.0;
    all->margin[n] = tm_least(all->margin[n], margin);
    all->doubt[n] += (all->guard[n] * 0.0) + doubt;
  }
}

/** A pass more of those of which one has to hold, if it is in range. */
static inline void tm_exists_put_where(tm_several *some) {
  for (size_t n = 0u; n < TM_SEVERAL; ++n) {
    const bool there = some->guard[n] > 0.0;
    const double margin = there ? some->body[n] : -TM_INF;
    const double doubt = there ? (some->body[n] * 0.0) : 0.0;
    some->margin[n] = tm_greatest(some->margin[n], margin);
    some->doubt[n] += (some->guard[n] * 0.0) + doubt;
  }
}

/** Whether all hold that were put in. */
static inline tm_truth tm_all_put(const tm_several *all) {
  double margin = all->margin[0];
  double doubt = all->doubt[0];
  for (size_t n = 1u; n < TM_SEVERAL; ++n) {
    margin = tm_least(margin, all->margin[n]);
    doubt += all->doubt[n];
  }
  const tm_truth a = {margin, margin >= 0.0, doubt};
  return a;
}

/** Whether one holds of those that were put in. */
static inline tm_truth tm_some_put(const tm_several *some) {
  double margin = some->margin[0];
  double doubt = some->doubt[0];
  for (size_t n = 1u; n < TM_SEVERAL; ++n) {
    margin = tm_greatest(margin, some->margin[n]);
    doubt += some->doubt[n];
  }
  const tm_truth a = {margin, margin >= 0.0, doubt};
  return a;
}

/** What is true of itself. */
static inline tm_cases tm_true_any(void) {
  const tm_cases a = {TM_INF, TM_INF, true, true};
  return a;
}

/** What is false of itself. */
static inline tm_cases tm_false_any(void) {
  const tm_cases a = {-TM_INF, -TM_INF, false, false};
  return a;
}

/** A Boolean. */
static inline tm_cases tm_told_any(bool sat) {
  const double margin = sat ? TM_INF : -TM_INF;
  const tm_cases a = {margin, margin, sat, sat};
  return a;
}

/** A flag of an input: a missing one may be either. */
static inline tm_cases tm_flagged_any(tm_flag flag) {
  const tm_cases a = {
      (flag == TM_TRUE) ? TM_INF : -TM_INF, (flag != TM_FALSE) ? TM_INF : -TM_INF, flag == TM_TRUE, flag != TM_FALSE};
  return a;
}

/** Something that has this margin if it is known; otherwise it may be anything. */
static inline tm_cases tm_cases_of(bool known, bool sat, double margin) {
  const tm_cases a = {known ? margin : -TM_INF, known ? margin : TM_INF, known && sat, !known || sat};
  return a;
}

/** A comparison: known where its operands are finite. */
static inline tm_cases tm_compared_any(double left, double right, bool sat, double margin) {
  return tm_cases_of(tm_finite(left) && tm_finite(right), sat, margin);
}

/** left < right. */
static inline tm_cases tm_less_any(double left, double right) {
  return tm_compared_any(left, right, left < right, right - left);
}

/** left <= right. */
static inline tm_cases tm_at_most_any(double left, double right) {
  return tm_compared_any(left, right, left <= right, right - left);
}

/** left > right. */
static inline tm_cases tm_greater_any(double left, double right) {
  return tm_compared_any(left, right, left > right, left - right);
}

/** left >= right. */
static inline tm_cases tm_at_least_any(double left, double right) {
  return tm_compared_any(left, right, left >= right, left - right);
}

/** left == right. */
static inline tm_cases tm_equal_any(double left, double right) {
  return tm_compared_any(left, right, left == right, -fabs(left - right));
}

/** left != right. */
static inline tm_cases tm_unequal_any(double left, double right) {
  return tm_compared_any(left, right, left != right, fabs(left - right));
}

/** Both are places of one member of an enumeration: a Boolean of two numbers. */
static inline tm_cases tm_is_any(double left, double right) {
  return tm_compared_any(left, right, left == right, (left == right) ? TM_INF : -TM_INF);
}

/** A geometric predicate: its margin is a distance, and it holds where that is not negative. */
static inline tm_cases tm_apart_by_any(double distance) {
  return tm_cases_of(distance == distance, distance >= 0.0, distance);
}

/** A formula whose margin is divided by a scale. */
static inline tm_cases tm_scaled_any(tm_cases a, double scale) {
  const tm_cases b = {a.worst / scale, a.best / scale, a.worst_sat, a.best_sat};
  return b;
}

/** not a: the worst case of one is the best case of the other. */
static inline tm_cases tm_not_any(tm_cases a) {
  const tm_cases b = {-a.best, -a.worst, !a.best_sat, !a.worst_sat};
  return b;
}

/** a and b: the lesser margin. */
static inline tm_cases tm_and_any(tm_cases a, tm_cases b) {
  const tm_cases both = {
      tm_least(a.worst, b.worst), tm_least(a.best, b.best), a.worst_sat && b.worst_sat, a.best_sat && b.best_sat};
  return both;
}

/** a or b: the greater margin. */
static inline tm_cases tm_or_any(tm_cases a, tm_cases b) {
  const tm_cases either = {
      tm_greatest(a.worst, b.worst), tm_greatest(a.best, b.best), a.worst_sat || b.worst_sat, a.best_sat || b.best_sat};
  return either;
}

/** a xor b. */
static inline tm_cases tm_xor_any(tm_cases a, tm_cases b) {
  const tm_cases one = {
      tm_greatest(tm_greatest(0.0, tm_apart(a.worst, b.best)), tm_apart(b.worst, a.best)),
      tm_greatest(tm_apart(a.best, b.worst), tm_apart(b.best, a.worst)),
      (a.worst_sat && !b.best_sat) || (b.worst_sat && !a.best_sat),
      !((a.worst_sat && b.worst_sat) || !(a.best_sat || b.best_sat))};
  return one;
}

/** Whether a formula holds, for all that is known. */
static inline bool tm_may_hold_any(tm_cases a) {
  return a.best_sat;
}

/** Whenever the guard holds, the body; nothing is demanded otherwise. */
static inline tm_cases tm_whenever_any(tm_cases guard, tm_cases body) {
  const tm_cases a = {
      guard.best_sat ? body.worst : TM_INF, guard.worst_sat ? body.best : TM_INF,
      !guard.best_sat || body.worst_sat, !guard.worst_sat || body.best_sat};
  return a;
}

/** One more of those that all have to hold. */
static inline void tm_for_all_any(tm_cases *all, tm_cases body) {
  *all = tm_and_any(*all, body);
}

/** One more of those of which one has to hold. */
static inline void tm_exists_any(tm_cases *some, tm_cases body) {
  *some = tm_or_any(*some, body);
}

/** One more of those that all have to hold; in the worst case, all that may be in range count. */
static inline void tm_for_all_where_any(tm_cases *all, tm_cases guard, tm_cases body) {
  const tm_cases next = tm_and_any(*all, body);
  all->worst = guard.best_sat ? next.worst : all->worst;
  all->worst_sat = guard.best_sat ? next.worst_sat : all->worst_sat;
  all->best = guard.worst_sat ? next.best : all->best;
  all->best_sat = guard.worst_sat ? next.best_sat : all->best_sat;
}

/** One more of those of which one has to hold; in the worst case, only those that surely are in range count. */
static inline void tm_exists_where_any(tm_cases *some, tm_cases guard, tm_cases body) {
  const tm_cases next = tm_or_any(*some, body);
  some->worst = guard.worst_sat ? next.worst : some->worst;
  some->worst_sat = guard.worst_sat ? next.worst_sat : some->worst_sat;
  some->best = guard.best_sat ? next.best : some->best;
  some->best_sat = guard.best_sat ? next.best_sat : some->best_sat;
}

/** One of two numbers; NaN where what decides is not known. */
static inline double tm_select_any(tm_cases condition, double then, double otherwise) {
  return condition.worst_sat ? then : (condition.best_sat ? TM_NAN : otherwise);
}

/** Keep a sample of two series, of the worst and the best case. */
static inline void tm_keep_any(tm_series *worst, tm_series *best, size_t i, tm_cases a) {
  worst->margin[i] = a.worst;
  worst->sat[i] = a.worst_sat;
  best->margin[i] = a.best;
  best->sat[i] = a.best_sat;
}

/** A sample of two series, of the worst and the best case. */
static inline tm_cases tm_kept_any(const tm_series *worst, const tm_series *best, size_t i) {
  const tm_cases a = {worst->margin[i], best->margin[i], worst->sat[i], best->sat[i]};
  return a;
}

/** Keep a sample of two streams, of the worst and the best case. */
static inline void tm_stream_any(tm_stream *worst, tm_stream *best, size_t i, tm_cases a) {
  worst->margin[i] = a.worst;
  worst->sat[i] = a.worst_sat;
  best->margin[i] = a.best;
  best->sat[i] = a.best_sat;
}

/** A sample of two streams, of the worst and the best case. */
static inline tm_cases tm_streamed_any(const tm_stream *worst, const tm_stream *best, size_t i) {
  const tm_cases a = {worst->margin[i], best->margin[i], worst->sat[i], best->sat[i]};
  return a;
}

/** What a rule says of the worst and the best case. */
static inline void tm_conclude_any(tm_result *out, tm_cases applies, tm_cases holds) {
  tm_decide(out, !applies.best_sat, holds.worst_sat, holds.best_sat, holds.worst, holds.best);
}
