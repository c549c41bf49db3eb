/* Violations of rules beside each other: which candidate is better. */

/** The first number of a violation: 0 satisfied, inactive or open, 1 violated, 2 undefined, as is a verdict that is none. */
static int tm_violation_grade(const tm_result *result) {
  int grade = 2;
  if ((result->verdict == TM_SATISFIED) || (result->verdict == TM_INACTIVE) || (result->verdict == TM_OPEN)) {
    grade = 0;
  } else if (result->verdict == TM_VIOLATED) {
    grade = 1;
  } else {
    grade = 2;
  }
  return grade;
}

/** The second one: by how much; of what is undefined, or violated by a margin that is no number, infinitely. */
static double tm_violation_size(const tm_result *result) {
  const int grade = tm_violation_grade(result);
  double extent = 0.0;
  if (grade == 2) {
    extent = TM_INF;
  } else if (grade == 1) {
    if (result->margin < 0.0) {
      extent = -result->margin;
    } else if (result->margin >= 0.0) {
      extent = 0.0;
    } else {
      extent = TM_INF;
    }
  } else {
    extent = 0.0;
  }
  return extent;
}

/** 1 where the first is violated more than the second, -1 where less, 0 where alike. */
static int tm_violation_sign(const tm_result *first, const tm_result *second) {
  const int grades = tm_violation_grade(first) - tm_violation_grade(second);
  const double one = tm_violation_size(first);
  const double other = tm_violation_size(second);
  int sign = 0;
  if ((grades > 0) || ((grades == 0) && (one > other))) {
    sign = 1;
  } else if ((grades < 0) || (one < other)) {
    sign = -1;
  } else {
    sign = 0;
  }
  return sign;
}

/** How many rules of a group are violated as much as this. */
static size_t tm_violated_alike(const tm_ranks *ranks, size_t group, const tm_output *candidate, const tm_result *value) {
  size_t count = 0u;
  for (size_t i = ranks->first[group]; i < ranks->first[group + 1u]; ++i) {
    if (tm_violation_sign(&candidate->rule[ranks->rule[i]], value) == 0) {
      ++count;
    }
  }
  return count;
}

/** The same sign of rules that count as one, the worst of them first: decided by the greatest violation of which they have not equally many. */
static int tm_group_sign(const tm_ranks *ranks, size_t group, const tm_output *first, const tm_output *second) {
  const tm_result *greatest = NULL;
  int sign = 0;
  for (size_t side = 0u; side < 2u; ++side) {
    const tm_output *holder = (side == 0u) ? first : second;
    for (size_t i = ranks->first[group]; i < ranks->first[group + 1u]; ++i) {
      const tm_result *value = &holder->rule[ranks->rule[i]];
      const size_t ours = tm_violated_alike(ranks, group, first, value);
      const size_t theirs = tm_violated_alike(ranks, group, second, value);
      if ((ours != theirs) && ((greatest == NULL) || (tm_violation_sign(value, greatest) > 0))) {
        greatest = value;
        sign = (ours > theirs) ? 1 : -1;
      }
    }
  }
  return sign;
}

/** Whether every group of this sign is outranked by one of the opposite sign. */
static bool tm_made_up(const tm_ranks *ranks, const int *sign, int wanted) {
  bool all = true;
  for (size_t group = 0u; group < ranks->groups; ++group) {
    if (sign[group] == wanted) {
      bool some = false;
      for (size_t other = 0u; other < ranks->groups; ++other) {
        if (ranks->above[(group * ranks->groups) + other] && (sign[other] == -wanted)) {
          some = true;
        }
      }
      all = all && some;
    }
  }
  return all;
}

/** The first candidate beside the second. */
static tm_outcome tm_set_beside(const tm_ranks *ranks, const tm_output *first, const tm_output *second) {
  int sign[TM_RULES];
  bool differ = false;
  tm_outcome outcome = TM_INCOMPARABLE;
  for (size_t group = 0u; group < ranks->groups; ++group) {
    sign[group] = tm_group_sign(ranks, group, first, second);
    differ = differ || (sign[group] != 0);
  }
  if (!differ) {
    outcome = TM_EQUAL;
  } else if (tm_made_up(ranks, sign, 1)) {
    outcome = TM_BETTER;
  } else if (tm_made_up(ranks, sign, -1)) {
    outcome = TM_WORSE;
  } else {
    outcome = TM_INCOMPARABLE;
  }
  return outcome;
}

/** Which candidates no other one beats, and the first of them; `count` where there is no candidate. */
static size_t tm_pick(const tm_ranks *ranks, const tm_output *candidate, size_t count, bool *best) {
  size_t chosen = count;
  for (size_t i = 0u; i < count; ++i) {
    best[i] = true;
    for (size_t other = 0u; other < count; ++other) {
      if ((other != i) && (tm_set_beside(ranks, &candidate[other], &candidate[i]) == TM_BETTER)) {
        best[i] = false;
      }
    }
    if (best[i] && (chosen == count)) {
      chosen = i;
    }
  }
  return chosen;
}
