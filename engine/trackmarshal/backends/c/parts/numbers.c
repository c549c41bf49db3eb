/* Numbers as specs mean them: comparisons, extremes, functions, one number of many, tables. */

/** Whether a number is finite. */
static bool tm_finite(double x) {
  return fabs(x) <= DBL_MAX;
}

/** Whether this was compiled for numbers as IEEE 754 has them: NaN equals nothing, infinities are beyond every number, both zeros make one
   when 0.0 is added, constants have all their digits, and sums, products and quotients are taken one by one as they are written. Of some
   flags (clang's -fno-honor-nans, -freciprocal-math, -ffp-contract=fast; gcc's -fsingle-precision-constant) no macro tells. */
static bool tm_as_written(void) {
  volatile double given = TM_NAN; /* volatile: worked out when it runs, with the code of all others */
  const double none = given;
  given = TM_INF;
  const double endless = given;
  given = -0.0;
  const double zero = given;
  given = 1e16;
  const double large = given;
  given = 1.0;
  const double one = given;
  given = 3.0;
  const double three = given;
  given = 10.0;
  const double ten = given;
  given = 1.0 + (1.0 / 1073741824.0); /* 1 + 2^-30: its square is rounded to 1 + 2^-29 */
  const double base = given;
  given = 1.0 + (1.0 / 536870912.0);
  const double square = given;
  return !(none == none) && !tm_finite(endless) && ((one / (zero + 0.0)) > 0.0) && !(((large + one) - large) > 0.0)
      && ((one / ten) == 0.1) && ((three / 10.0) == 0.3) && (((base * base) - square) == 0.0);
}

/** Whether a flag has no value. */
static bool tm_missing(tm_flag flag) {
  return (flag != TM_TRUE) && (flag != TM_FALSE);
}

/** The smaller of two numbers, 0.0 for both zeros; NaN where one is. Not fmin, which drops a NaN. */
static double tm_min(double a, double b) {
  const double lesser = (b < a) ? b : a; /* a, where one is NaN */
  return (b == b) ? (lesser + 0.0) : TM_NAN;
}

/** The greater of two numbers, 0.0 for both zeros; NaN where one is. */
static double tm_max(double a, double b) {
  const double greater = (b > a) ? b : a; /* a, where one is NaN */
  return (b == b) ? (greater + 0.0) : TM_NAN;
}

/** 1 for a number above zero, -1 for one below, 0.0 for both zeros; NaN for NaN. */
static double tm_sign(double x) {
  if (x > 0.0) {
    return 1.0;
  }
  return (x < 0.0) ? -1.0 : (x + 0.0);
}

/** The root of the sum of two squares, in these steps: the hypot of one C library is not that of another. */
static double tm_hypot(double a, double b) {
  return sqrt((a * a) + (b * b));
}

/** A power; NaN where an argument is, also where IEEE 754 has 1. */
static double tm_pow(double x, double y) {
  if (!(x == x) || !(y == y)) {
    return TM_NAN;
  }
  return pow(x, y);
}

/** The smaller of two margins, which are never NaN. */
static double tm_least(double a, double b) {
  return (b < a) ? b : a;
}

/** The greater of two margins, which are never NaN. */
static double tm_greatest(double a, double b) {
  return (b > a) ? b : a;
}

/** Which one of many, as a number. */
static double tm_ordinal(size_t index) {
  return (double)index;
}

/** Nothing of many, so far. */
static tm_fold tm_fold_none(void) {
  const tm_fold fold = {0.0, -1.0, false};
  return fold;
}

/** One more to add; `here`: 1.0 in range, 0.0 outside, NaN where that is not known. */
static void tm_fold_sum(tm_fold *fold, double here, double value) {
  if (!(here == 0.0)) {
    fold->value = fold->value + ((here == 1.0) ? value : TM_NAN);
  }
}

/** One more of which the least is wanted. */
static void tm_fold_least(tm_fold *fold, double here, double value) {
  if (!(here == 0.0)) {
    const double next = (here == 1.0) ? (value + 0.0) : TM_NAN;
    fold->value = fold->some ? tm_min(fold->value, next) : next;
    fold->some = true;
  }
}

/** One more of which the greatest is wanted. */
static void tm_fold_greatest(tm_fold *fold, double here, double value) {
  if (!(here == 0.0)) {
    const double next = (here == 1.0) ? (value + 0.0) : TM_NAN;
    fold->value = fold->some ? tm_max(fold->value, next) : next;
    fold->some = true;
  }
}

/** One more of which the place of the first least one is wanted: NaN where one is not known, or not finite. */
static void tm_fold_nearest(tm_fold *fold, double here, double value, size_t place) {
  if (!(here == 0.0)) {
    const bool first = (!fold->some) || (value < fold->value);
    if (!(here == 1.0) || !tm_finite(value)) {
      fold->place = TM_NAN;
    } else if (first && (fold->place == fold->place)) {
      fold->value = value;
      fold->place = (double)place;
    } else {
      /* another one is nearer, or it is not known */
    }
    fold->some = true;
  }
}

/** How far two margins are apart; equal infinities are not. */
static double tm_apart(double x, double y) {
  return (x == y) ? 0.0 : (x - y);
}

/** How many windows of `width` neighbours a timeline has. */
static size_t tm_windows(size_t count, size_t width) {
  return (count < width) ? 0u : ((count - width) + 1u);
}

/** The sample `steps` before one, or the first. */
static size_t tm_before(size_t index, size_t steps) {
  return (index < steps) ? 0u : (index - steps);
}

/** A table: linear between knots, clamped outside, NaN for an argument that is not finite. */
static inline double tm_lookup(tm_table *table, double x) {
  size_t low = table->last;
  size_t high = table->count - 1u;
  if ((low < high) && ((table->knot[low] < x) || ((low > 0u) && (table->knot[low] == x))) && (x < table->knot[low + 1u])) { /* between the knots of the last time */
    return table->value[low] + (table->slope[low] * (x - table->knot[low]));
  }
  low = 0u;
  if (!tm_finite(x)) {
    return TM_NAN;
  }
  if (x <= table->knot[0]) {
    return table->value[0];
  }
  if (x >= table->knot[high]) {
    return table->value[high];
  }
  while ((high - low) > 1u) {
    const size_t middle = low + ((high - low) / 2u);
    if (table->knot[middle] <= x) {
      low = middle;
    } else {
      high = middle;
    }
  }
  table->last = low;
  return table->value[low] + (table->slope[low] * (x - table->knot[low]));
}

/** A place of a period, from 0 up to its length; the remainder is exact. */
static double tm_wrapped(double x, double length) {
  double rest = fmod(x, length);
  if (rest < 0.0) {
    rest += length;
  }
  return (rest >= length) ? 0.0 : rest;
}

/** Where an argument lies among the knots of an axis; it is not known where the table has no value. */
static tm_table_spot tm_place_on(const tm_table_axis *axis, double argument) {
  const size_t last = axis->count - 1u;
  const double first = axis->knots[0];
  const double end = axis->knots[last];
  const bool periodic = axis->length > 0.0;
  tm_table_spot spot = {0u, 0u, 0.0, 0.0, argument, true};
  double x = argument;
  size_t low = 0u;
  size_t high = last;
  if (!tm_finite(x) || (periodic && ((first < 0.0) || !(end < axis->length)))) {
    spot.known = false;
    return spot;
  }
  if (periodic) {
    x = tm_wrapped(x, axis->length);
  }
  if (periodic && ((x < first) || (x >= end))) {
    spot.low = last;
    spot.high = axis->steps ? last : 0u;
    spot.start = end;
    spot.end = first + axis->length;
    spot.at = (x < first) ? (x + axis->length) : x;
  } else if ((!periodic) && (x <= first)) {
    spot.known = axis->clamped || (x == first);
  } else if ((!periodic) && (x >= end)) {
    spot.low = last;
    spot.high = last;
    spot.known = axis->clamped || axis->steps || (x == end);
  } else {
    while ((high - low) > 1u) {
      const size_t middle = low + ((high - low) / 2u);
      if (axis->knots[middle] <= x) {
        low = middle;
      } else {
        high = middle;
      }
    }
    spot.low = low;
    spot.high = axis->steps ? low : (low + 1u);
    spot.start = axis->knots[low];
    spot.end = axis->knots[low + 1u];
    spot.at = x;
  }
  return spot;
}

/** The value at a place, of those of its two knots. */
static double tm_value_at(const tm_table_spot *spot, double low, double high) {
  double value = low;
  if (spot->low != spot->high) {
    const double slope = (high - low) / (spot->end - spot->start);
    value = low + (slope * (spot->at - spot->start));
  }
  return value;
}

/** A table that is not `linear clamp`; NaN where it has no value. */
static double tm_read_table(const tm_table *table, bool steps, bool clamped, double length, double x) {
  const tm_table_axis axis = {table->knot, table->count, steps, clamped, length};
  const tm_table_spot spot = tm_place_on(&axis, x);
  return spot.known ? tm_value_at(&spot, table->value[spot.low], table->value[spot.high]) : TM_NAN;
}

/** A table of two arguments: along the columns in each of two rows, then along the rows; NaN where it has no value. */
static double tm_read_grid(const tm_table_grid *grid, double x, double y) {
  const tm_table_spot down = tm_place_on(&grid->rows, x);
  const tm_table_spot across = tm_place_on(&grid->columns, y);
  const double *first = &grid->cells[down.low * grid->columns.count];
  const double *second = &grid->cells[down.high * grid->columns.count];
  const double low = tm_value_at(&across, first[across.low], first[across.high]);
  const double high = tm_value_at(&across, second[across.low], second[across.high]);
  return (down.known && across.known) ? tm_value_at(&down, low, high) : TM_NAN;
}

/** Fill a table; false, and nothing is changed, for no row, too many, or knots that do not ascend. */
static bool tm_fill_table(tm_table *table, const double *knots, const double *values, size_t count) {
  if ((count == 0u) || (count > TM_MAX_KNOTS)) {
    return false;
  }
  for (size_t i = 0u; i < count; ++i) {
    if (!tm_finite(knots[i]) || !tm_finite(values[i]) || ((i > 0u) && !(knots[i - 1u] < knots[i]))) {
      return false;
    }
  }
  table->count = count;
  table->last = 0u;
  for (size_t i = 0u; i < count; ++i) {
    table->knot[i] = knots[i];
    table->value[i] = values[i];
    table->slope[i] = 0.0;
    if ((i + 1u) < count) {
      table->slope[i] = (values[i + 1u] - values[i]) / (knots[i + 1u] - knots[i]);
    }
  }
  return true;
}
