/* Quantifiers of which several samples are worked out at once, in passes over the timeline. */

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
