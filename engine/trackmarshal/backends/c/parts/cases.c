/* Formulas in the worst and in the best case of what is not known (strong Kleene logic). */

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
