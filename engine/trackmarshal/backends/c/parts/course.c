/* Formulas and counts along a course: what was driven, and what is planned. */

/** What is said of a sample of a course; of a gap, nothing is known. */
static inline tm_truth tm_unless_missed(uint64_t missing, tm_truth a) {
  const tm_truth said = {a.margin, a.sat, (missing == 0u) ? a.doubt : TM_NAN};
  return said;
}

/** What is said of a sample of a course, or may be; of a gap, nothing is known. */
static inline tm_cases tm_unless_missed_any(uint64_t missing, tm_cases a) {
  return (missing > 0u) ? tm_unknown_any() : a;
}

/** How many samples one may be: of a gap, as many as cycles are missing. */
static uint64_t tm_weight(const uint64_t *missing, size_t k) {
  return ((missing != NULL) && (missing[k] > 0u)) ? missing[k] : 1u;
}

/** At how many samples something held, up to each of them, from as far back as a window goes. `missing` is NULL where there are no gaps. */
static void tm_tally_last(tm_context *c, const double *begins, const double *ends, const uint64_t *missing, size_t n, double b,
                          size_t from, size_t to) {
  const tm_series *x = &c->series[from];
  tm_series *y = &c->series[to];
  uint64_t count = 0u;
  size_t first = 0u;
  for (size_t k = 0u; k < n; ++k) {
    while ((first < k) && !((begins[k] - b) <= ends[first])) {
      count -= x->sat[first] ? tm_weight(missing, first) : 0u;
      ++first;
    }
    count += x->sat[k] ? tm_weight(missing, k) : 0u;
    y->margin[k] = (double)count;
    y->sat[k] = false;
  }
}

/** At how many samples something held, up to each of them, from the last one on with which the count starts anew. */
static void tm_tally_anew(tm_context *c, const uint64_t *missing, size_t n, size_t from, size_t reset, size_t to) {
  const tm_series *x = &c->series[from];
  const tm_series *anew = &c->series[reset];
  tm_series *y = &c->series[to];
  uint64_t count = 0u;
  for (size_t k = 0u; k < n; ++k) {
    count = (anew->sat[k] ? 0u : count) + (x->sat[k] ? tm_weight(missing, k) : 0u);
    y->margin[k] = (double)count;
    y->sat[k] = false;
  }
}

/** A count of samples, all of which are known. */
static inline double tm_tallied_at(const tm_series *counted, size_t i) {
  return counted->margin[i];
}

/** A count of samples: of those that surely count, and of those that may. */
static inline tm_tally tm_tallied_at_any(const tm_series *sure, const tm_series *possible, size_t i) {
  const tm_tally a = {(uint64_t)sure->margin[i], (uint64_t)possible->margin[i], false, false};
  return a;
}
