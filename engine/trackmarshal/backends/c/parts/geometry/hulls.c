/* Footprints of a vehicle and the convex hull of two of them; points and segments beside a hull, and in it. */

/** The four corners of the box at a point, heading along (ahead, aside), seen from (ox, oy), counter-clockwise from the front left. */
static void tm_footprint(double px, double py, double ahead, double aside, double length, double width, double ox, double oy,
                         double *x, double *y) {
  const double fx = (0.5 * length) * ahead;
  const double fy = (0.5 * length) * aside;
  const double lx = -((0.5 * width) * aside);
  const double ly = (0.5 * width) * ahead;
  const double cx = px - ox;
  const double cy = py - oy;
  x[0] = cx + (fx + lx);
  y[0] = cy + (fy + ly);
  x[1] = cx - (fx - lx);
  y[1] = cy - (fy - ly);
  x[2] = cx - (fx + lx);
  y[2] = cy - (fy + ly);
  x[3] = cx + (fx - lx);
  y[3] = cy + (fy - ly);
}

/** Append a point to a half of a convex hull, and drop those that it makes superfluous; returns the new count. */
static size_t tm_hull_point(tm_hull *hull, size_t first, size_t count, double x, double y) {
  while (count >= (first + 2u)) {
    const double ax = hull->x[count - 2u];
    const double ay = hull->y[count - 2u];
    const double ex = hull->x[count - 1u] - ax;
    const double ey = hull->y[count - 1u] - ay;
    if (((ex * (y - ay)) - (ey * (x - ax))) > 0.0) {
      break;
    }
    --count;
  }
  hull->x[count] = x;
  hull->y[count] = y;
  return count + 1u;
}

/** The convex hull of eight points, counter-clockwise, with its sides. */
static void tm_convex_hull(const double *px, const double *py, tm_hull *hull) {
  double x[8] = {0.0};
  double y[8] = {0.0};
  size_t n = 0u;
  size_t count = 0u;
  for (size_t i = 0u; i < 8u; ++i) { /* sorted; of equal ones, the first stays the first */
    size_t at = i;
    while ((at > 0u) && ((px[i] < x[at - 1u]) || ((px[i] == x[at - 1u]) && (py[i] < y[at - 1u])))) {
      x[at] = x[at - 1u];
      y[at] = y[at - 1u];
      --at;
    }
    x[at] = px[i];
    y[at] = py[i];
  }
  for (size_t i = 0u; i < 8u; ++i) {
    if ((n == 0u) || (x[i] != x[n - 1u]) || (y[i] != y[n - 1u])) {
      x[n] = x[i];
      y[n] = y[i];
      ++n;
    }
  }
  for (size_t i = 0u; i < n; ++i) {
    count = tm_hull_point(hull, 0u, count, x[i], y[i]);
  }
  --count;
  const size_t first = count;
  for (size_t i = n; i > 0u; --i) {
    count = tm_hull_point(hull, first, count, x[i - 1u], y[i - 1u]);
  }
  --count;
  hull->count = count;
  for (size_t i = 0u; i < count; ++i) {
    const size_t next = ((i + 1u) < count) ? (i + 1u) : 0u;
    hull->gx[i] = hull->x[next] - hull->x[i];
    hull->gy[i] = hull->y[next] - hull->y[i];
    hull->square[i] = (hull->gx[i] * hull->gx[i]) + (hull->gy[i] * hull->gy[i]);
    hull->length[i] = sqrt(hull->square[i]);
  }
}

/** How far a point lies inside a convex polygon: its distance from the nearest side's line, negative outside. */
static double tm_depth(const tm_hull *hull, double x, double y) {
  double depth = TM_INF;
  for (size_t i = 0u; i < hull->count; ++i) {
    const double side = (hull->gx[i] * (y - hull->y[i])) - (hull->gy[i] * (x - hull->x[i]));
    depth = tm_least(depth, side / hull->length[i]);
  }
  return depth;
}

/** The distance of a point from the outline of a convex polygon. */
static double tm_hull_distance(const tm_hull *hull, double x, double y) {
  double best = TM_INF;
  for (size_t i = 0u; i < hull->count; ++i) {
    const size_t next = ((i + 1u) < hull->count) ? (i + 1u) : 0u;
    const double rx = x - hull->x[i];
    const double ry = y - hull->y[i];
    const double product = (hull->gx[i] * rx) + (hull->gy[i] * ry);
    double reach;
    if ((0.0 < product) && (product < hull->square[i])) {
      reach = fabs((hull->gx[i] * ry) - (hull->gy[i] * rx)) / hull->length[i];
    } else {
      const double sx = x - hull->x[next];
      const double sy = y - hull->y[next];
      const double start = (rx * rx) + (ry * ry);
      const double end = (sx * sx) + (sy * sy);
      reach = sqrt((end < start) ? end : start);
    }
    best = tm_least(best, reach);
  }
  return best;
}

/** Whether a segment, seen from (ox, oy), has a point strictly inside a convex polygon. */
static bool tm_enters(const tm_segment *s, double ox, double oy, const tm_hull *hull) {
  const double ax = s->ax - ox;
  const double ay = s->ay - oy;
  const double bx = s->bx - ox;
  const double by = s->by - oy;
  double low = TM_INF;
  double high = -TM_INF;
  for (size_t i = 0u; i < hull->count; ++i) {
    const double turn = (s->ex * (hull->y[i] - ay)) - (s->ey * (hull->x[i] - ax));
    low = tm_least(low, turn);
    high = tm_greatest(high, turn);
  }
  if (!((low < 0.0) && (0.0 < high))) {
    return false;
  }
  for (size_t i = 0u; i < hull->count; ++i) {
    const double at_start = (hull->gx[i] * (ay - hull->y[i])) - (hull->gy[i] * (ax - hull->x[i]));
    const double at_end = (hull->gx[i] * (by - hull->y[i])) - (hull->gy[i] * (bx - hull->x[i]));
    if ((at_start <= 0.0) && (at_end <= 0.0)) {
      return false;
    }
  }
  return true;
}

/** How deep in a convex polygon the middle of the part of a segment lies that is inside it. */
static double tm_middle_depth(const tm_segment *s, double ox, double oy, const tm_hull *hull) {
  const double ax = s->ax - ox;
  const double ay = s->ay - oy;
  const double bx = s->bx - ox;
  const double by = s->by - oy;
  double first = 0.0;
  double last = 1.0;
  double t;
  for (size_t i = 0u; i < hull->count; ++i) {
    const double start = (hull->gx[i] * (ay - hull->y[i])) - (hull->gy[i] * (ax - hull->x[i]));
    const double end = (hull->gx[i] * (by - hull->y[i])) - (hull->gy[i] * (bx - hull->x[i]));
    if (start < end) {
      first = tm_greatest(first, start / (start - end));
    } else if (start > end) {
      last = tm_least(last, start / (start - end));
    }
  }
  t = (first + last) / 2.0;
  return tm_depth(hull, ax + (t * s->ex), ay + (t * s->ey));
}
