/* Formulas of which all is known, and what rules say of them. */

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
