/* Temporal operators of monitors: a sample at a time. */

/** The place of a sample in a ring. */
static size_t tm_ring(size_t i) {
  return i % TM_MAX_ONLINE;
}

/** Take a candidate for the least key into a queue, and drop those that it makes superfluous; `stays`: no candidate ever leaves. */
static void tm_online_candidate(tm_flow *f, tm_candidates *queue, size_t index, double key, bool stays) {
  if (stays && (f->head < f->tail) && (queue->key[tm_ring(f->head)] <= key)) {
    return;
  }
  while ((f->head < f->tail) && (queue->key[tm_ring(f->tail - 1u)] >= key)) {
    --f->tail;
  }
  queue->index[tm_ring(f->tail)] = index;
  queue->key[tm_ring(f->tail)] = key;
  ++f->tail;
}

/** The least key of the candidates from a sample on; infinite where there is none. */
static double tm_online_least(tm_flow *f, const tm_candidates *queue, size_t from) {
  while ((f->head < f->tail) && (queue->index[tm_ring(f->head)] < from)) {
    ++f->head;
  }
  return (f->head < f->tail) ? queue->key[tm_ring(f->head)] : TM_INF;
}

/** Whether the samples up to a time are all there: a later one is, or none will come. */
static bool tm_online_over(const double *t, size_t have, size_t count, bool finished, double until) {
  return finished || ((have < count) && !(t[tm_ring(have)] <= until));
}

/** always, eventually: every sample's value as soon as its window is over. `have` values of the operand are known. */
static void tm_online_ahead(tm_flow *f, tm_candidates *queue, const double *t, size_t have, size_t count, bool finished, double a,
                            double b, bool least, const tm_stream *x, tm_stream *y) {
  const double sign = least ? 1.0 : -1.0;
  while (f->next < have) {
    const double now = t[tm_ring(f->next)];
    while ((f->begin < have) && ((f->begin < f->next) || !((now + a) <= t[tm_ring(f->begin)]))) {
      if ((f->begin < f->end) && (x->sat[tm_ring(f->begin)] != least)) {
        --f->decisive;
      }
      ++f->begin;
    }
    if (f->end < f->begin) {
      f->end = f->begin;
    }
    while ((f->end < have) && (t[tm_ring(f->end)] <= (now + b))) {
      tm_online_candidate(f, queue, f->end, sign * x->margin[tm_ring(f->end)], false);
      if (x->sat[tm_ring(f->end)] != least) {
        ++f->decisive;
      }
      ++f->end;
    }
    if ((f->end == have) && !tm_online_over(t, have, count, finished, now + b)) {
      return;
    }
    y->margin[tm_ring(f->next)] = (sign * tm_online_least(f, queue, f->begin)) + 0.0;
    y->sat[tm_ring(f->next)] = (f->decisive == 0u) == least;
    ++f->next;
  }
}

/** historically, once: every sample's value at once. */
static void tm_online_back(tm_flow *f, tm_candidates *queue, const double *t, size_t have, double a, double b, bool least,
                           const tm_stream *x, tm_stream *y) {
  const double sign = least ? 1.0 : -1.0;
  while (f->next < have) {
    const double now = t[tm_ring(f->next)];
    while ((f->end <= f->next) && (t[tm_ring(f->end)] <= (now - a))) {
      tm_online_candidate(f, queue, f->end, sign * x->margin[tm_ring(f->end)], b == TM_INF);
      if (x->sat[tm_ring(f->end)] != least) {
        ++f->decisive;
      }
      ++f->end;
    }
    while ((b != TM_INF) && (f->begin < f->end) && !((now - b) <= t[tm_ring(f->begin)])) {
      if (x->sat[tm_ring(f->begin)] != least) {
        --f->decisive;
      }
      ++f->begin;
    }
    y->margin[tm_ring(f->next)] = (sign * tm_online_least(f, queue, f->begin)) + 0.0;
    y->sat[tm_ring(f->next)] = (f->decisive == 0u) == least;
    ++f->next;
  }
}

/** Nothing is composed yet: the step that changes nothing. */
static void tm_online_rest(tm_flow *f) {
  f->rest_goal = -TM_INF;
  f->rest_hold = TM_INF;
  f->rest_goal_sat = false;
  f->rest_hold_sat = true;
}

/** until: the samples of a window as steps x -> max(q, min(p, x)), composed in two stacks; values as windows are over. */
static void tm_online_until(tm_flow *f, tm_candidates *queue, tm_stream *goals, tm_stream *holds, const double *t, size_t have,
                            size_t count, bool finished, double a, double b, const tm_stream *p, const tm_stream *q, tm_stream *y) {
  while (f->next < have) {
    const double now = t[tm_ring(f->next)];
    while ((f->begin < have) && ((f->begin < f->next) || !((now + a) <= t[tm_ring(f->begin)]))) {
      if (f->begin >= f->next) { /* p has to hold there */
        tm_online_candidate(f, queue, f->begin, p->margin[tm_ring(f->begin)], false);
        if (!p->sat[tm_ring(f->begin)]) {
          ++f->decisive;
        }
      }
      ++f->begin;
    }
    if (f->stop < f->begin) {
      f->stop = f->begin;
    }
    while ((f->stop < have) && (t[tm_ring(f->stop)] <= (now + b))) {
      ++f->stop;
    }
    if ((f->stop == have) && !tm_online_over(t, have, count, finished, now + b)) {
      return;
    }
    if (f->begin >= f->mid) {
      double goal = -TM_INF;
      double hold = TM_INF;
      bool goal_sat = false;
      bool hold_sat = true;
      for (size_t j = f->stop; j > f->begin; --j) {
        const size_t at = tm_ring(j - 1u);
        goal = tm_greatest(q->margin[at], tm_least(p->margin[at], goal));
        hold = tm_least(p->margin[at], hold);
        goal_sat = q->sat[at] || (p->sat[at] && goal_sat);
        hold_sat = p->sat[at] && hold_sat;
        goals->margin[at] = goal;
        holds->margin[at] = hold;
        goals->sat[at] = goal_sat;
        holds->sat[at] = hold_sat;
      }
      f->mid = f->stop;
      tm_online_rest(f);
    } else {
      for (size_t j = f->end; j < f->stop; ++j) {
        const size_t at = tm_ring(j);
        f->rest_goal = tm_greatest(f->rest_goal, tm_least(f->rest_hold, q->margin[at]));
        f->rest_hold = tm_least(f->rest_hold, p->margin[at]);
        f->rest_goal_sat = f->rest_goal_sat || (f->rest_hold_sat && q->sat[at]);
        f->rest_hold_sat = f->rest_hold_sat && p->sat[at];
      }
    }
    f->end = f->stop;
    double margin = -TM_INF;
    bool sat = false;
    if (f->begin < f->end) {
      const size_t at = tm_ring(f->begin);
      margin = tm_greatest(goals->margin[at], tm_least(holds->margin[at], f->rest_goal));
      margin = tm_least(tm_online_least(f, queue, f->next), margin);
      sat = (goals->sat[at] || (holds->sat[at] && f->rest_goal_sat)) && (f->decisive == 0u);
    }
    y->margin[tm_ring(f->next)] = margin + 0.0;
    y->sat[tm_ring(f->next)] = sat;
    ++f->next;
    if ((f->next <= f->begin) && !p->sat[tm_ring(f->next - 1u)]) { /* it no longer counts */
      --f->decisive;
    }
  }
}

/** since: as until, the newest step outermost; every sample's value at once. */
static void tm_online_since(tm_flow *f, tm_candidates *queue, tm_stream *goals, tm_stream *holds, const double *t, size_t have,
                            double a, double b, const tm_stream *p, const tm_stream *q, tm_stream *y) {
  while (f->next < have) {
    const double now = t[tm_ring(f->next)];
    tm_online_candidate(f, queue, f->next, p->margin[tm_ring(f->next)], false);
    if (!p->sat[tm_ring(f->next)]) {
      ++f->decisive;
    }
    while ((f->end <= f->next) && (t[tm_ring(f->end)] <= (now - a))) {
      const size_t at = tm_ring(f->end);
      if (!p->sat[at]) {
        --f->decisive;
      }
      f->rest_goal = tm_greatest(q->margin[at], tm_least(p->margin[at], f->rest_goal));
      f->rest_hold = tm_least(p->margin[at], f->rest_hold);
      f->rest_goal_sat = q->sat[at] || (p->sat[at] && f->rest_goal_sat);
      f->rest_hold_sat = p->sat[at] && f->rest_hold_sat;
      ++f->end;
    }
    while ((b != TM_INF) && (f->begin < f->end) && !((now - b) <= t[tm_ring(f->begin)])) {
      ++f->begin;
    }
    if (f->begin > f->mid) {
      double goal = -TM_INF;
      double hold = TM_INF;
      bool goal_sat = false;
      bool hold_sat = true;
      for (size_t j = f->end; j > f->begin; --j) {
        const size_t at = tm_ring(j - 1u);
        goal = tm_greatest(goal, tm_least(hold, q->margin[at]));
        hold = tm_least(hold, p->margin[at]);
        goal_sat = goal_sat || (hold_sat && q->sat[at]);
        hold_sat = hold_sat && p->sat[at];
        goals->margin[at] = goal;
        goals->sat[at] = goal_sat;
        holds->margin[at] = hold;
        holds->sat[at] = hold_sat;
      }
      f->mid = f->end;
      tm_online_rest(f);
    }
    double margin = -TM_INF;
    bool sat = false;
    if (f->begin < f->end) {
      const size_t at = tm_ring(f->begin);
      const bool composed = f->begin < f->mid;
      margin = tm_greatest(f->rest_goal, tm_least(f->rest_hold, composed ? goals->margin[at] : -TM_INF));
      margin = tm_least(tm_online_least(f, queue, f->end), margin);
      sat = (f->rest_goal_sat || (f->rest_hold_sat && composed && goals->sat[at])) && (f->decisive == 0u);
    }
    y->margin[tm_ring(f->next)] = margin + 0.0;
    y->sat[tm_ring(f->next)] = sat;
    ++f->next;
  }
}

/** next, previous: the value one sample on or back; outside the timeline false, or true when weak. */
static void tm_online_shift(tm_flow *f, size_t have, bool finished, bool ahead, bool weak, const tm_stream *x, tm_stream *y) {
  while (f->next < have) {
    const bool outside = ahead ? ((f->next + 1u) >= have) : (f->next == 0u);
    if (ahead && outside && !finished) {
      return;
    }
    const size_t from = outside ? 0u : tm_ring(ahead ? (f->next + 1u) : (f->next - 1u));
    y->sat[tm_ring(f->next)] = outside ? weak : x->sat[from];
    y->margin[tm_ring(f->next)] = (outside ? (weak ? TM_INF : -TM_INF) : x->margin[from]) + 0.0;
    f->begin = f->next; /* what comes next may ask for this one */
    ++f->next;
  }
}

/** The oldest sample that an operator still needs. */
static size_t tm_online_oldest(const tm_flow *f, bool stays) {
  const size_t from = stays ? f->end : f->begin;
  return (from < f->next) ? from : f->next;
}
