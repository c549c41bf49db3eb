/* Signs of turns and meetings of segments, without rounding. */

/** Add the two parts of a product, exactly, to a sum kept as parts that do not overlap. */
static size_t tm_add_product(double *sum, size_t count, double a, double b) {
  const double split = 134217729.0; /* 2^27 + 1 */
  const double product = a * b;
  const double ca = split * a;
  const double a_high = ca - (ca - a);
  const double a_low = a - a_high;
  const double cb = split * b;
  const double b_high = cb - (cb - b);
  const double b_low = b - b_high;
  const double error = (a_low * b_low) - (((product - (a_high * b_high)) - (a_low * b_high)) - (a_high * b_low));
  const double terms[2] = {error, product};
  for (size_t k = 0u; k < 2u; ++k) {
    double rest = terms[k];
    for (size_t i = 0u; i < count; ++i) {
      const double total = rest + sum[i];
      const double back = total - rest;
      sum[i] = (rest - (total - back)) + (sum[i] - back);
      rest = total;
    }
    sum[count] = rest;
    ++count;
  }
  return count;
}

/** The exact sign of (a1 - a0) (b1 - b0) - (c1 - c0) (d1 - d0), of numbers that are zero or not tiny. */
static int tm_exact_sign(double a1, double a0, double b1, double b0, double c1, double c0, double d1, double d0) {
  const double first[4] = {a1, b1, c1, d1};
  const double second[4] = {a0, b0, c0, d0};
  double high[4];
  double low[4];
  double sum[16];
  size_t count = 0u;
  for (size_t i = 0u; i < 4u; ++i) {
    const double difference = first[i] - second[i];
    const double back = first[i] - difference;
    const double there = difference + back;
    high[i] = difference;
    low[i] = (first[i] - there) + (back - second[i]);
  }
  count = tm_add_product(sum, count, low[0], low[1]);
  count = tm_add_product(sum, count, low[0], high[1]);
  count = tm_add_product(sum, count, high[0], low[1]);
  count = tm_add_product(sum, count, high[0], high[1]);
  count = tm_add_product(sum, count, -low[2], low[3]);
  count = tm_add_product(sum, count, -low[2], high[3]);
  count = tm_add_product(sum, count, -high[2], low[3]);
  count = tm_add_product(sum, count, -high[2], high[3]);
  while (count > 0u) {
    --count;
    if (sum[count] > 0.0) {
      return 1;
    }
    if (sum[count] < 0.0) {
      return -1;
    }
  }
  return 0;
}

/** The exact sign of the turn a, b, c: 1 left, -1 right, 0 straight. */
static int tm_orientation(const double *a, const double *b, const double *p) {
  const double left = (b[0] - a[0]) * (p[1] - a[1]);
  const double right = (b[1] - a[1]) * (p[0] - a[0]);
  const double turn = left - right;
  if (fabs(turn) > (1e-15 * (fabs(left) + fabs(right)))) {
    return (turn > 0.0) ? 1 : -1;
  }
  return tm_exact_sign(b[0], a[0], p[1], a[1], b[1], a[1], p[0], a[0]);
}

/** Whether the way a, b, c turns round by exactly half a turn at b. */
static bool tm_folds_back(const double *a, const double *b, const double *p) {
  return (tm_orientation(a, b, p) == 0) && (tm_exact_sign(b[0], a[0], p[0], b[0], a[1], b[1], p[1], b[1]) < 0);
}

/** Whether the segments ab and pq have a point in common, decided exactly. */
static bool tm_meet(const double *a, const double *b, const double *p, const double *q) {
  for (size_t i = 0u; i < 2u; ++i) {
    const double ab_high = (a[i] > b[i]) ? a[i] : b[i];
    const double ab_low = (a[i] > b[i]) ? b[i] : a[i];
    const double pq_high = (p[i] > q[i]) ? p[i] : q[i];
    const double pq_low = (p[i] > q[i]) ? q[i] : p[i];
    if ((ab_high < pq_low) || (pq_high < ab_low)) {
      return false;
    }
  }
  return ((tm_orientation(a, b, p) * tm_orientation(a, b, q)) <= 0) && ((tm_orientation(p, q, a) * tm_orientation(p, q, b)) <= 0);
}
