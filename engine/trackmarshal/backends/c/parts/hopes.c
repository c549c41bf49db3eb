/* What may still come of rules that look ahead: what is sure whatever comes, and what is said of a cycle by that. */

/** What is known for sure, and will stay so. */
static tm_hope tm_certain_hope(bool holds) {
  const tm_hope hope = {holds, !holds};
  return hope;
}

/** What may still become anything. */
static tm_hope tm_any_hope(void) {
  const tm_hope hope = {true, true};
  return hope;
}

/** What is settled: neither where it is not known. */
static tm_hope tm_hope_of(tm_known settled) {
  const tm_hope hope = {settled.value.worst_sat, !settled.value.best_sat};
  return hope;
}

/** not p. */
static tm_hope tm_not_hope(tm_hope p) {
  const tm_hope hope = {p.fails, p.holds};
  return hope;
}

/** p and q. */
static tm_hope tm_and_hope(tm_hope p, tm_hope q) {
  const tm_hope hope = {p.holds && q.holds, p.fails || q.fails};
  return hope;
}

/** p or q. */
static tm_hope tm_or_hope(tm_hope p, tm_hope q) {
  const tm_hope hope = {p.holds || q.holds, p.fails && q.fails};
  return hope;
}

/** p xor q. */
static tm_hope tm_xor_hope(tm_hope p, tm_hope q) {
  const tm_hope hope = {(p.holds && q.fails) || (p.fails && q.holds), (p.holds && q.holds) || (p.fails && q.fails)};
  return hope;
}

/** One more of those that all have to hold, where p. */
static void tm_for_all_hope(tm_hope *all, tm_hope p, tm_hope q) {
  *all = tm_and_hope(*all, tm_or_hope(tm_not_hope(p), q));
}

/** One more of those of which one has to hold, where p. */
static void tm_exists_hope(tm_hope *some, tm_hope p, tm_hope q) {
  *some = tm_or_hope(*some, tm_and_hope(p, q));
}

/** always p, of which one's own cycle is all that has been seen. */
static tm_hope tm_always_hope(tm_hope p) {
  const tm_hope hope = {p.holds, true};
  return hope;
}

/** eventually p, of the same. */
static tm_hope tm_eventually_hope(tm_hope p) {
  const tm_hope hope = {true, p.fails};
  return hope;
}

/** p until q, of the same, where that is in the window. */
static tm_hope tm_until_hope(tm_hope p, tm_hope q) {
  const tm_hope hope = {p.holds || q.holds, q.fails};
  return hope;
}

/** What is said about one cycle, of which the formula has a value, and so has where it applies. */
static tm_about tm_about_cycle(tm_known formula, tm_known applies) {
  const bool settled = formula.final && applies.final;
  tm_about said = {{TM_NAN, TM_OPEN}, settled, settled};
  tm_decide(&said.result, false, formula.value.worst_sat, formula.value.best_sat, formula.value.worst, formula.value.best);
  if (!applies.value.best_sat) {
    said.result.verdict = TM_INACTIVE;
    said.result.margin = TM_INF;
    said.final = applies.final;
  } else if (!said.final && ((said.result.verdict == TM_UNDEFINED) ||
                             ((said.result.verdict == TM_SATISFIED) && !applies.value.worst_sat))) {
    said.result.verdict = TM_OPEN;
    said.result.margin = TM_NAN;
  } else {
    /* it is decided */
  }
  return said;
}

/** How bad a verdict is: 0 is the worst. */
static unsigned tm_rank(tm_verdict verdict) {
  unsigned rank = 0u;
  switch (verdict) {
    case TM_INACTIVE:
      rank = 4u;
      break;
    case TM_SATISFIED:
      rank = 3u;
      break;
    case TM_OPEN:
      rank = 2u;
      break;
    case TM_UNDEFINED:
      rank = 1u;
      break;
    case TM_VIOLATED:
    default:
      rank = 0u;
      break;
  }
  return rank;
}

/** The worse of what is said of two cycles. */
static void tm_worse(tm_result *worst, bool *any, tm_result other) {
  const unsigned mine = tm_rank(worst->verdict);
  const unsigned others = tm_rank(other.verdict);
  const double margin = isnan(worst->margin) ? 0.0 : worst->margin;
  const double less = isnan(other.margin) ? 0.0 : other.margin;
  if (!*any || (others < mine) || ((others == mine) && (less < margin))) {
    *worst = other;
  }
  *any = true;
}
