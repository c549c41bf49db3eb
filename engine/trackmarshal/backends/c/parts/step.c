/** The outcome of a step of which nothing more is known: every rule is undefined. */
static void tm_begin(tm_look *look) {
  tm_decision *out = look->out;
  out->now = TM_NAN;
  out->finished = TM_NAN;
  out->valid_until = TM_NAN;
  out->judged = false;
  out->stored = false;
  out->stored_number = 0;
  out->stored_t = TM_NAN;
  out->fault_count = 0u;
  out->reason_count = 0u;
  out->more = false;
  for (size_t i = 0u; i < TM_RULES; ++i) {
    out->driving.rule[i].verdict = TM_UNDEFINED;
    out->driving.rule[i].margin = TM_NAN;
    out->emergency.rule[i].verdict = TM_UNDEFINED;
    out->emergency.rule[i].margin = TM_NAN;
  }
  ++look->parts;
}

/** The cycle's arrival on the clock; whether there is a cycle, and a Supervisor to take it. */
static void tm_arrive(tm_context *c, const tm_cycle *cycle, tm_look *look) {
  tm_read(c, (cycle == NULL) ? TM_NAN : cycle->now, look, &look->out->now);
  look->out->valid_until = look->out->now + c->limits.longest_gap;
  if (c->configured != TM_MADE) {
    ++look->breaches;
    tm_add(look->out, TM_FAULT_NOT_CONFIGURED, "supervisor", "", TM_NOWHERE);
  }
  if ((cycle != NULL) && !cycle->came && (cycle->found_count > 0u)) {
    tm_found(cycle, look);
  } else if ((cycle == NULL) || !cycle->came) {
    ++look->breaches;
    tm_add(look->out, TM_FAULT_MISSING_CYCLE, "cycle", "", TM_NOWHERE);
  } else {
    /* the door looks at it */
  }
  ++look->parts;
}

/** The watchdog: a verdict that comes late is none. */
static void tm_watch(tm_context *c, tm_clock clock, void *user, tm_look *look) {
  double finished = TM_NAN;
  if (clock != NULL) {
    finished = clock(user);
  }
  look->out->finished = finished;
  tm_read(c, finished, look, &finished);
  if (!((finished - look->out->now) <= c->limits.budget)) {
    ++look->breaches;
    tm_add(look->out, TM_FAULT_OVERRUN, "cycle", "", TM_NOWHERE);
  }
  c->marks.watchdog = c->serial;
}

/** A part of the step did not run. */
static void tm_incomplete(tm_look *look, const char *part) {
  look->doubt = true;
  ++look->breaches;
  tm_add(look->out, TM_FAULT_INCOMPLETE, "supervisor", part, TM_NOWHERE);
}

/** Results as they are before rules run: undefined, by a margin that no rule gives. */
static void tm_expect(tm_output *output, tm_look *look) {
  for (size_t i = 0u; i < TM_RULES; ++i) {
    output->rule[i].verdict = TM_UNDEFINED;
    output->rule[i].margin = TM_DID_NOT_RUN;
  }
  ++look->expected;
}

/** Whether a rule ran, and whether it makes a candidate unsafe, which an advisory one does not. */
static void tm_weigh(const tm_result *result, bool advisory, size_t *known, size_t *against) {
  const bool safe = (result->verdict == TM_SATISFIED) || (result->verdict == TM_INACTIVE) || (result->verdict == TM_OPEN);
  const bool undefined = (result->verdict == TM_UNDEFINED) && !(result->margin == TM_DID_NOT_RUN);
  if (safe || undefined || (result->verdict == TM_VIOLATED)) {
    ++*known;
  }
  if (!safe && !advisory) {
    ++*against;
  }
}

/** A rule that makes a candidate unsafe, as a reason. */
static void tm_blame(tm_decision *out, size_t rule, tm_candidate candidate, const tm_result *result) {
  if (out->reason_count < TM_MAX_REASONS) {
    tm_reason *reason = &out->reasons[out->reason_count];
    reason->kind = TM_REASON_RULE;
    reason->fault.name = TM_FAULT_NONE;
    reason->fault.signal = "";
    reason->fault.field = "";
    reason->fault.index = TM_NOWHERE;
    reason->rule = rule;
    reason->candidate = candidate;
    reason->result = *result;
    ++out->reason_count;
  } else {
    out->more = true;
  }
}

/** What the rules say: whether all of them ran, for both candidates, and how many are against the cycle. */
static void tm_rate(tm_context *c, tm_look *look) {
  tm_decision *out = look->out;
  tm_output *outputs[2] = {&out->driving, &out->emergency};
  size_t known = 0u;
  size_t against = 0u;
  for (size_t k = 0u; k < 2u; ++k) {
    for (size_t i = 0u; i < TM_RULES; ++i) {
      const size_t before = against;
      tm_weigh(&outputs[k]->rule[i], tm_advisory[i], &known, &against);
      if (against != before) {
        tm_blame(out, i, (k == 0u) ? TM_DRIVING : TM_EMERGENCY, &outputs[k]->rule[i]);
      }
    }
  }
  if ((known == (2u * TM_RULES)) && (look->expected == 2u) && (c->marks.judge == c->serial)) {
    look->against = against;
    c->marks.rating = c->serial;
  } else { /* not one known verdict a rule: there are none at all */
    out->judged = false;
    out->reason_count = 0u;
    out->more = false;
    for (size_t i = 0u; i < TM_RULES; ++i) {
      for (size_t k = 0u; k < 2u; ++k) {
        outputs[k]->rule[i].verdict = TM_UNDEFINED;
        outputs[k]->rule[i].margin = TM_NAN;
      }
    }
    tm_incomplete(look, "judge");
  }
}

/** Whether the cycle is safe: no fault, every part of the step ran, and no rule is against either candidate. */
static void tm_sound(tm_context *c, tm_look *look, bool asked) {
  if ((look->breaches == 0u) && ((c->marks.door != c->serial) || (look->parts != TM_PARTS))) {
    tm_incomplete(look, "door");
  }
  if (asked && look->out->judged && (c->marks.rating != c->serial)) {
    tm_incomplete(look, "judge");
  }
  if (asked && (c->marks.watchdog != c->serial)) {
    tm_incomplete(look, "watchdog");
  }
  if (look->breaches != look->out->fault_count) {
    tm_incomplete(look, "supervisor");
  }
  if (asked && (look->breaches == 0u) && (look->against == 0u) && (c->marks.rating == c->serial)) {
    c->marks.sound = c->serial;
  }
}

/** The state after this cycle. */
static void tm_advance(tm_context *c, const tm_cycle *cycle, tm_look *look) {
  tm_decision *out = look->out;
  double confirmed = c->stored.confirmed;
  size_t so = TM_SO_NONE;
  int next = -1;
  if ((c->marks.sound == c->serial) && (look->breaches == 0u)) {
    so = TM_SO_SAFE;
    tm_store(c, cycle);
    confirmed = out->now;
  } else if (c->stored.serial != 0u) {
    out->lost = TM_FAULT_UNCONFIRMED;
    tm_examine(c, look, &confirmed, &out->lost);
    so = (out->lost == TM_FAULT_NONE) ? TM_SO_HOLDS : TM_SO_LOST;
  } else {
    out->lost = TM_FAULT_NONE_STORED;
  }
  if ((size_t)c->state < TM_STATES) {
    next = tm_next[c->state][so];
  }
  if (next >= 0) {
    c->state = (tm_state)next;
    c->stored.confirmed = confirmed;
    if (so == TM_SO_LOST) {
      c->stored.serial = 0u;
    }
    c->marks.machine = c->serial;
  }
}

/** What is driven in this state. */
static void tm_choose(tm_context *c, const tm_cycle *cycle, tm_look *look) {
  tm_decision *out = look->out;
  const bool safe = (c->marks.sound == c->serial) && (c->marks.store == c->serial) && (c->stored.serial == c->serial);
  out->state = c->state;
  out->stored = c->stored.serial != 0u;
  if (out->stored) {
    out->stored_number = c->stored.number;
    out->stored_t = c->stored.t;
  }
  if ((c->state == TM_STATE_DRIVE) && safe) {
    tm_due_by(cycle->driving->TM_PLAN_T, cycle->driving->count, cycle->t, out->now, &out->first);
    if (out->first < cycle->driving->count) {
      out->driven_number = cycle->number;
      out->driven_t = cycle->t;
      out->driven = TM_DRIVE_DRIVING;
      out->safe = true;
    }
  } else if (c->state == TM_STATE_PREVIOUS_EMERGENCY) {
    tm_due_by(c->stored.plan.TM_PLAN_T, c->stored.count, c->stored.t, out->now, &out->first);
    if (out->first < c->stored.count) {
      out->driven_number = c->stored.number;
      out->driven_t = c->stored.t;
      out->driven = TM_DRIVE_STORED;
    }
  } else {
    /* nothing is driven */
  }
}

/** Why nothing stored is driven, as the last reason; where there is no room for it, `lost` says it alone. */
static void tm_mourn(tm_decision *out) {
  if ((out->lost != TM_FAULT_NONE) && (out->reason_count < TM_MAX_REASONS)) {
    tm_add(out, out->lost, "supervisor", "", TM_NOWHERE);
    out->reasons[out->reason_count - 1u].kind = TM_REASON_LOST;
    --out->fault_count;
  }
}

void tm_step(tm_context *c, const tm_cycle *cycle, tm_clock clock, void *user, tm_decision *out)
{
  tm_look look = {0};
  bool asked = false;
  look.out = out;
  /* Whatever does not run after this, nothing is driven. */
  out->serial = 0u;
  out->state = TM_STATE_NO_SAFE_TRAJECTORY;
  out->safe = false;
  out->driven = TM_DRIVE_NOTHING;
  out->first = TM_NOWHERE;
  out->driven_number = 0;
  out->driven_t = TM_NAN;
  out->lost = TM_FAULT_NONE;
  out->fault_count = 0u;
  out->reason_count = 0u;
  out->judged = false;
  tm_begin(&look);
  if (c->made != TM_MADE) {
    tm_add(out, TM_FAULT_NOT_CONFIGURED, "supervisor", "", TM_NOWHERE);
    out->lost = TM_FAULT_NONE_STORED;
    return;
  }
  ++c->serial;
  out->serial = c->serial;
  tm_arrive(c, cycle, &look);
  if ((cycle != NULL) && cycle->came) {
    tm_door(c, cycle, &look);
  }
  if ((look.breaches == 0u) && (look.parts == TM_PARTS) && (c->marks.door == c->serial)) {
    asked = true;
    out->judged = true;
    look.against = 2u * TM_RULES;
    tm_expect(&out->driving, &look);
    tm_expect(&out->emergency, &look);
    tm_judge(c, cycle, &look);
    tm_rate(c, &look);
    tm_watch(c, clock, user, &look);
  }
  tm_sound(c, &look, asked);
  tm_advance(c, cycle, &look);
  if ((c->marks.machine == c->serial) && (look.breaches == out->fault_count)) {
    tm_choose(c, cycle, &look);
  }
  if ((out->driven == TM_DRIVE_NOTHING) &&
      ((c->marks.machine != c->serial) || (c->state == TM_STATE_DRIVE) || (c->state == TM_STATE_PREVIOUS_EMERGENCY))) {
    /* The machine did not run to its end: nothing that it keeps is relied on. */
    tm_incomplete(&look, "machine");
    c->state = TM_STATE_NO_SAFE_TRAJECTORY;
    c->stored.serial = 0u;
    out->state = c->state;
    out->stored = false;
    out->lost = TM_FAULT_NONE_STORED;
  }
  if (!out->safe) {
    tm_mourn(out);
  }
}
