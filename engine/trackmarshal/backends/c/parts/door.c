/** Say what breaks the contract; false. */
static bool tm_refuse(tm_fault *fault, tm_fault_name name, const char *signal, const char *field, size_t index) {
  fault->name = name;
  fault->signal = signal;
  fault->field = field;
  fault->index = index;
  return false;
}

/** Whether a number is in its range; NaN and infinities are in none. */
static bool tm_admit_number(tm_fault *fault, const char *signal, const char *field, double x, double low, double high) {
  if ((x >= low) && (x <= high)) {
    return true;
  }
  return tm_refuse(fault, tm_finite(x) ? TM_FAULT_OUT_OF_RANGE : TM_FAULT_NOT_FINITE, signal, field, TM_NOWHERE);
}

/** Whether all numbers of a column are in their range. */
static bool tm_admit_column(tm_fault *fault, const char *signal, const char *field, const double *column, size_t count,
                            double low, double high) {
  bool fine = true;
  if ((column == NULL) && (count > 0u)) {
    return tm_refuse(fault, TM_FAULT_MISSING, signal, field, TM_NOWHERE);
  }
  for (size_t i = 0u; i < count; ++i) {
    fine = fine && (column[i] >= low) && (column[i] <= high);
  }
  for (size_t i = 0u; (i < count) && !fine; ++i) {
    if (!tm_admit_number(fault, signal, field, column[i], low, high)) {
      fault->index = i;
      return false;
    }
  }
  return true;
}

/** Whether the numbers of a column, which are in their range, increase. */
static bool tm_admit_increasing(tm_fault *fault, const char *signal, const char *field, const double *column, size_t count) {
  for (size_t i = 1u; i < count; ++i) {
    if (!(column[i - 1u] < column[i])) {
      return tm_refuse(fault, TM_FAULT_NOT_INCREASING, signal, field, i);
    }
  }
  return true;
}

/** Whether all flags of a column have a value. */
static bool tm_admit_flags(tm_fault *fault, const char *signal, const char *field, const tm_flag *column, size_t count) {
  if ((column == NULL) && (count > 0u)) {
    return tm_refuse(fault, TM_FAULT_MISSING, signal, field, TM_NOWHERE);
  }
  for (size_t i = 0u; i < count; ++i) {
    if (tm_missing(column[i])) {
      return tm_refuse(fault, TM_FAULT_NOT_FINITE, signal, field, i);
    }
  }
  return true;
}

/** Whether a flag has a value. */
static bool tm_admit_flag(tm_fault *fault, const char *signal, const char *field, tm_flag flag) {
  return !tm_missing(flag) || tm_refuse(fault, TM_FAULT_MISSING, signal, field, TM_NOWHERE);
}

/** Whether a signal has at least so many entries, and not more than there is room for. */
static bool tm_admit_count(tm_fault *fault, const char *signal, const char *field, size_t count, size_t least, size_t most) {
  if (count > most) {
    return tm_refuse(fault, TM_FAULT_OVER_CAPACITY, signal, field, most);
  }
  return (count >= least) || tm_refuse(fault, TM_FAULT_TOO_SHORT, signal, field, TM_NOWHERE);
}

/** Whether a border or line is one: two points or more, all finite, no more than there is room for. */
static bool tm_admit_line(tm_fault *fault, const char *signal, const char *field, const double *points, size_t count, size_t most) {
  if (count > most) {
    return tm_refuse(fault, TM_FAULT_OVER_CAPACITY, signal, field, most);
  }
  if ((points == NULL) && (count > 0u)) {
    return tm_refuse(fault, TM_FAULT_MISSING, signal, field, TM_NOWHERE);
  }
  if (count < 2u) {
    return tm_refuse(fault, TM_FAULT_BAD_BORDER, signal, field, TM_NOWHERE);
  }
  for (size_t i = 0u; i < (2u * count); ++i) {
    if (!tm_finite(points[i])) {
      return tm_refuse(fault, TM_FAULT_NOT_FINITE, signal, field, i / 2u);
    }
  }
  return true;
}

/** Whether a cycle's stamp and number go on from those of the last cycle whose stamp was in order. */
static bool tm_admit_stamp(tm_door *door, const tm_stamp *stamp, tm_fault *fault) {
  const double since = stamp->t - door->t;
  const bool first = !door->begun;
  bool fine = true;
  if (!tm_finite(stamp->now)) {
    return tm_refuse(fault, TM_FAULT_BAD_CLOCK, "cycle", "now", TM_NOWHERE);
  }
  if (!tm_finite(stamp->t)) {
    fine = tm_refuse(fault, TM_FAULT_NOT_FINITE, "cycle", "t", TM_NOWHERE);
  } else if (!first && (fabs(since) <= door->limits.shortest_gap)) {
    fine = tm_refuse(fault, TM_FAULT_REPEATED, "cycle", "t", TM_NOWHERE);
  } else if (!first && (since < 0.0)) {
    fine = tm_refuse(fault, TM_FAULT_OUT_OF_ORDER, "cycle", "t", TM_NOWHERE);
  } else if ((stamp->t - stamp->now) > door->limits.clock_tolerance) {
    fine = tm_refuse(fault, TM_FAULT_EARLY, "cycle", "t", TM_NOWHERE);
  } else {
    if (!first && ((door->number == INT64_MAX) || (stamp->number != (door->number + 1)))) {
      fine = tm_refuse(fault,
                       (stamp->number == door->number)  ? TM_FAULT_REPEATED
                       : (stamp->number > door->number) ? TM_FAULT_SKIPPED
                                                        : TM_FAULT_OUT_OF_ORDER,
                       "cycle", "number", TM_NOWHERE);
    } else if (!first && (since > door->limits.longest_gap)) {
      fine = tm_refuse(fault, TM_FAULT_LATE, "cycle", "t", TM_NOWHERE);
    } else if ((stamp->now - stamp->t) > door->limits.oldest) {
      fine = tm_refuse(fault, TM_FAULT_STALE, "cycle", "t", TM_NOWHERE);
    } else {
      /* in order and in time */
    }
    door->begun = true;
    door->t = stamp->t;
    door->number = stamp->number;
  }
  return fine;
}

/** Whether the emergency trajectory starts where the driving one does, and ends at rest; both have passed by themselves. */
static bool tm_admit_candidates(const tm_limits *limits, double dx, double dy, double turn, double faster, double last,
                                size_t samples, tm_fault *fault) {
  if (!(hypot(dx, dy) <= limits->start_distance)) {
    return tm_refuse(fault, TM_FAULT_STARTS_ELSEWHERE, "emergency", (fabs(dx) >= fabs(dy)) ? "x" : "y", 0u);
  }
  if (!(fabs(remainder(turn, 6.283185307179586)) <= limits->start_turn)) {
    return tm_refuse(fault, TM_FAULT_STARTS_ELSEWHERE, "emergency", "heading", 0u);
  }
  if (!(fabs(faster) <= limits->start_speed)) {
    return tm_refuse(fault, TM_FAULT_STARTS_ELSEWHERE, "emergency", "v", 0u);
  }
  if (!(fabs(last) <= limits->rest_speed)) {
    return tm_refuse(fault, TM_FAULT_NOT_AT_REST, "emergency", "v", samples - 1u);
  }
  return true;
}
