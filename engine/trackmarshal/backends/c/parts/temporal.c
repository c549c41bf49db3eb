/* Temporal operators: one pass over a timeline that is all there. */

/** Whether times are finite and strictly increase. */
static bool tm_times(const double *t, size_t n) {
  for (size_t i = 0u; i < n; ++i) {
    if (!tm_finite(t[i]) || ((i > 0u) && !(t[i - 1u] < t[i]))) {
      return false;
    }
  }
  return true;
}

/** A time in whole nanoseconds, to the nearest; one so far away that it would be infinite stands where it is not. */
static double tm_stamp(double t) {
  return rint(tm_greatest(-1e299, tm_least(1e299, t)) * 1e9);
}

/** Times in whole nanoseconds. */
static void tm_stamps(const double *t, size_t n, tm_series *into) {
  for (size_t i = 0u; i < n; ++i) {
    into->margin[i] = tm_stamp(t[i]);
  }
}

/** The time of a sample counted in an operator's direction; against the timeline, time runs negatively. */
static double tm_time(const double *t, size_t n, bool past, size_t j) {
  return past ? -t[(n - 1u) - j] : t[j];
}

/** Where a window begins to hold a sample that begins and ends so, counted in an operator's direction. */
static double tm_near_end(const double *begin, const double *end, size_t n, bool past, size_t j) {
  return past ? -begin[(n - 1u) - j] : end[j];
}

/** How far a window has to reach to hold a sample, counted in an operator's direction. */
static double tm_far_end(const double *begin, const double *end, size_t n, bool past, size_t j) {
  return past ? -end[(n - 1u) - j] : begin[j];
}

/** always, eventually, historically, once: the extreme over every window by a queue of candidates, linear in n. Samples of a course may be
   gaps, which begin and end: a part in the window is enough. Those of a timeline end where they begin. */
static void tm_extreme(tm_context *c, const double *begins, const double *ends, size_t n, double a, double b, bool past, bool least,
                       size_t from, size_t to) {
  const tm_series *x = &c->series[from];
  tm_series *y = &c->series[to];
  const double sign = least ? 1.0 : -1.0;
  size_t begin = 0u;
  size_t end = 0u;
  size_t head = 0u;
  size_t tail = 0u;
  size_t decisive = 0u; /* samples in the window that fail (least), or that hold */
  for (size_t k = 0u; k < n; ++k) {
    const double now = tm_time(begins, n, past, k);
    while ((begin < n) && ((begin < k) || !((now + a) <= tm_near_end(begins, ends, n, past, begin)))) {
      const size_t at = past ? ((n - 1u) - begin) : begin;
      if ((begin < end) && (x->sat[at] != least)) {
        --decisive;
      }
      ++begin;
    }
    if (end < begin) {
      end = begin;
    }
    while ((head < tail) && (c->queue[head] < begin)) {
      ++head;
    }
    while ((end < n) && (tm_far_end(begins, ends, n, past, end) <= (now + b))) {
      const size_t at = past ? ((n - 1u) - end) : end;
      const double key = sign * x->margin[at];
      while (head < tail) {
        const size_t last = c->queue[tail - 1u];
        if (!((sign * x->margin[past ? ((n - 1u) - last) : last]) >= key)) {
          break;
        }
        --tail;
      }
      c->queue[tail] = end;
      ++tail;
      if (x->sat[at] != least) {
        ++decisive;
      }
      ++end;
    }
    const size_t into = past ? ((n - 1u) - k) : k;
    double margin = TM_INF;
    if (head < tail) {
      const size_t best = c->queue[head];
      margin = sign * x->margin[past ? ((n - 1u) - best) : best];
    }
    y->margin[into] = (sign * margin) + 0.0;
    y->sat[into] = (decisive == 0u) == least;
  }
}

/** until, since: every window as a composition of the steps x -> max(q, min(p, x)), in two stacks; linear in n. Samples begin and end, as above. */
static void tm_held(tm_context *c, const double *begins, const double *ends, size_t n, double a, double b, bool past, size_t from_p,
                    size_t from_q, size_t to) {
  const tm_series *p = &c->series[from_p];
  const tm_series *q = &c->series[from_q];
  tm_series *y = &c->series[to];
  size_t begin = 0u;
  size_t end = 0u;
  size_t mid = 0u; /* steps from `begin` to `mid` are composed one by one in `goal` and `hold`, the rest in one */
  double rest_goal = -TM_INF;
  double rest_hold = TM_INF;
  bool rest_goal_sat = false;
  bool rest_hold_sat = true;
  size_t head = 0u; /* the queue holds candidates for the minimum of p before the window */
  size_t tail = 0u;
  size_t failing = 0u;
  for (size_t k = 0u; k < n; ++k) {
    const double now = tm_time(begins, n, past, k);
    if ((k > 0u) && (k <= begin)) { /* sample k - 1 no longer counts */
      const size_t gone = past ? ((n - 1u) - (k - 1u)) : (k - 1u);
      if (!p->sat[gone]) {
        --failing;
      }
    }
    while ((head < tail) && (c->queue[head] < k)) {
      ++head;
    }
    while ((begin < n) && ((begin < k) || !((now + a) <= tm_near_end(begins, ends, n, past, begin)))) {
      if (begin >= k) {
        const size_t at = past ? ((n - 1u) - begin) : begin;
        while (head < tail) {
          const size_t last = c->queue[tail - 1u];
          if (!(p->margin[past ? ((n - 1u) - last) : last] >= p->margin[at])) {
            break;
          }
          --tail;
        }
        c->queue[tail] = begin;
        ++tail;
        if (!p->sat[at]) {
          ++failing;
        }
      }
      ++begin;
    }
    size_t stop = (end < begin) ? begin : end;
    while ((stop < n) && (tm_far_end(begins, ends, n, past, stop) <= (now + b))) {
      ++stop;
    }
    if (begin >= mid) {
      double goal = -TM_INF;
      double hold = TM_INF;
      bool goal_sat = false;
      bool hold_sat = true;
      for (size_t j = stop; j > begin; --j) {
        const size_t at = past ? (n - j) : (j - 1u);
        goal = tm_greatest(q->margin[at], tm_least(p->margin[at], goal));
        hold = tm_least(p->margin[at], hold);
        goal_sat = q->sat[at] || (p->sat[at] && goal_sat);
        hold_sat = p->sat[at] && hold_sat;
        c->goal.margin[j - 1u] = goal;
        c->hold.margin[j - 1u] = hold;
        c->goal.sat[j - 1u] = goal_sat;
        c->hold.sat[j - 1u] = hold_sat;
      }
      mid = stop;
      rest_goal = -TM_INF;
      rest_hold = TM_INF;
      rest_goal_sat = false;
      rest_hold_sat = true;
    } else {
      for (size_t j = end; j < stop; ++j) {
        const size_t at = past ? ((n - 1u) - j) : j;
        rest_goal = tm_greatest(rest_goal, tm_least(rest_hold, q->margin[at]));
        rest_hold = tm_least(rest_hold, p->margin[at]);
        rest_goal_sat = rest_goal_sat || (rest_hold_sat && q->sat[at]);
        rest_hold_sat = rest_hold_sat && p->sat[at];
      }
    }
    end = stop;
    double margin = -TM_INF;
    bool sat = false;
    if (begin < end) {
      margin = tm_greatest(c->goal.margin[begin], tm_least(c->hold.margin[begin], rest_goal));
      sat = c->goal.sat[begin] || (c->hold.sat[begin] && rest_goal_sat);
      if (head < tail) {
        const size_t worst = c->queue[head];
        margin = tm_least(p->margin[past ? ((n - 1u) - worst) : worst], margin);
      }
      sat = sat && (failing == 0u);
    }
    const size_t into = past ? ((n - 1u) - k) : k;
    y->margin[into] = margin + 0.0;
    y->sat[into] = sat;
  }
}

/** next, previous: the value one sample on or back; outside the timeline false, or true when weak. */
static void tm_shift(tm_context *c, size_t n, bool ahead, bool weak, size_t from, size_t to) {
  const tm_series *x = &c->series[from];
  tm_series *y = &c->series[to];
  for (size_t k = 0u; k < n; ++k) {
    const bool inside = ahead ? ((k + 1u) < n) : (k > 0u);
    const size_t at = inside ? (ahead ? (k + 1u) : (k - 1u)) : k;
    y->sat[k] = inside ? x->sat[at] : weak;
    y->margin[k] = (inside ? x->margin[at] : (weak ? TM_INF : -TM_INF)) + 0.0;
  }
}
