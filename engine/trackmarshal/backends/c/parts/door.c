/* Faults of a cycle, as the door of a Supervisor finds them. */

/** Add a fault to a decision; where there is no room, it is counted. */
static void tm_add(tm_decision *out, tm_fault_name name, const char *signal, const char *field, size_t index) {
  if (out->reason_count < TM_MAX_REASONS) {
    tm_reason *reason = &out->reasons[out->reason_count];
    reason->kind = TM_REASON_FAULT;
    reason->fault.name = name;
    reason->fault.signal = signal;
    reason->fault.field = field;
    reason->fault.index = index;
    reason->rule = 0u;
    reason->candidate = TM_DRIVING;
    reason->result.verdict = TM_UNDEFINED;
    reason->result.margin = TM_NAN;
    ++out->reason_count;
  } else {
    out->more = true;
  }
  ++out->fault_count;
}

/** Whether two texts are the same; one that is not there is none. */
static bool tm_same_text(const char *a, const char *b) {
  size_t i = 0u;
  if ((a == NULL) || (b == NULL)) {
    return false;
  }
  while ((a[i] == b[i]) && (a[i] != '\0')) {
    ++i;
  }
  return a[i] == b[i];
}

/** Whether faults that were found before name a signal, and, where one is asked for, a field of it. */
static bool tm_named(const tm_cycle *cycle, const char *signal, const char *field) {
  if (cycle->found == NULL) {
    return false;
  }
  for (size_t i = 0u; i < cycle->found_count; ++i) {
    if (tm_same_text(cycle->found[i].signal, signal) && ((field == NULL) || tm_same_text(cycle->found[i].field, field))) {
      return true;
    }
  }
  return false;
}

/** The faults that were found before, as the first ones. */
static void tm_found(const tm_cycle *cycle, tm_look *look) {
  if (cycle->found == NULL) {
    ++look->breaches;
    tm_add(look->out, TM_FAULT_MISSING, "found", "", TM_NOWHERE);
  }
  for (size_t i = 0u; (cycle->found != NULL) && (i < cycle->found_count); ++i) {
    const tm_fault *found = &cycle->found[i];
    ++look->breaches;
    tm_add(look->out, found->name, found->signal, found->field, found->index);
  }
}

/** Whether a reading of the clock can follow the last one: finite, and not before it. */
static void tm_read(tm_context *c, double reading, tm_look *look, double *now) {
  *now = TM_NAN;
  if (tm_finite(reading) && (reading >= c->reading)) {
    c->reading = reading;
    *now = reading;
  } else {
    ++look->breaches;
    tm_add(look->out, TM_FAULT_BAD_CLOCK, "clock", "", TM_NOWHERE);
  }
}
