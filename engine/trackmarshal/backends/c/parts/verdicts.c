/* Verdicts from the worst and the best case of a formula. */

/** What a rule says where it has no value. */
static void tm_undefined(tm_result *out) {
  out->verdict = TM_UNDEFINED;
  out->margin = TM_NAN;
}

/** A verdict from the worst and the best case; the margin is the one that is sure, and of the two zeros it is 0.0. */
static void tm_decide(tm_result *out, bool inactive, bool worst, bool best, double worst_margin, double best_margin) {
  if (inactive) {
    out->verdict = TM_INACTIVE;
    out->margin = TM_INF;
  } else if (worst) {
    out->verdict = TM_SATISFIED;
    out->margin = worst_margin + 0.0;
  } else if (best) {
    tm_undefined(out);
  } else {
    out->verdict = TM_VIOLATED;
    out->margin = best_margin + 0.0;
  }
}
