/* What a vehicle sweeps beside a box at rest: the signed distance. */

/** The largest over the sides of one convex polygon of the least way that the other lies in front of it, negated. */
static double tm_overlap(const tm_hull *a, const tm_hull *b) {
  double shortest = TM_INF;
  for (size_t i = 0u; i < a->count; ++i) {
    double way = -TM_INF;
    for (size_t j = 0u; j < b->count; ++j) {
      const double side = (a->gx[i] * (b->y[j] - a->y[i])) - (a->gy[i] * (b->x[j] - a->x[i]));
      way = tm_greatest(way, side / a->length[i]);
    }
    shortest = tm_least(shortest, way);
  }
  return shortest;
}

/** The straight way between two poses, as a curve of one piece. */
static void tm_straight_anew(double x0, double y0, double heading0, double x1, double y1, double heading1, tm_curve *curve) {
  curve->x[0] = x0;
  curve->y[0] = y0;
  curve->ahead[0] = cos(heading0);
  curve->aside[0] = sin(heading0);
  curve->x[1] = x1;
  curve->y[1] = y1;
  curve->ahead[1] = cos(heading1);
  curve->aside[1] = sin(heading1);
  curve->count = 1u;
  curve->more = 0.0;
}

/** The signed distance [m] of a piece of a curve from a box along (ahead, aside). */
static double tm_piece_clear(const tm_curve *curve, size_t j, double length, double width, double box_x, double box_y, double ahead,
                             double aside, double box_length, double box_width) {
  const size_t next = j + 1u;
  const double ox = curve->x[j];
  const double oy = curve->y[j];
  double x[8];
  double y[8];
  tm_hull a;
  tm_hull b;
  double ways;
  double best = TM_INF;
  tm_footprint(ox, oy, curve->ahead[j], curve->aside[j], length, width, ox, oy, &x[0], &y[0]);
  tm_footprint(curve->x[next], curve->y[next], curve->ahead[next], curve->aside[next], length, width, ox, oy, &x[4], &y[4]);
  tm_convex_hull(x, y, &a);
  tm_footprint(box_x, box_y, ahead, aside, box_length, box_width, ox, oy, &x[0], &y[0]);
  for (size_t i = 0u; i < 4u; ++i) {
    x[4u + i] = x[i];
    y[4u + i] = y[i];
  }
  tm_convex_hull(x, y, &b);
  ways = tm_least(tm_overlap(&a, &b), tm_overlap(&b, &a));
  if (ways > 0.0) {
    return -ways;
  }
  for (size_t i = 0u; i < a.count; ++i) {
    best = tm_least(best, tm_hull_distance(&b, a.x[i], a.y[i]));
  }
  for (size_t i = 0u; i < b.count; ++i) {
    best = tm_least(best, tm_hull_distance(&a, b.x[i], b.y[i]));
  }
  return best;
}

/** The signed distance [m] of what a vehicle sweeps straight between two poses from a box at rest; NaN for what is none. */
static double tm_swept_clear(double x0, double y0, double heading0, double x1, double y1, double heading1, double length,
                             double width, double box_x, double box_y, double box_heading, double box_length,
                             double box_width) {
  tm_curve curve;
  if (!tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) || !tm_usable(heading1) ||
      !tm_usable(box_x) || !tm_usable(box_y) || !tm_usable(box_heading) || !tm_sized(length, width) ||
      !tm_sized(box_length, box_width)) {
    return TM_NAN;
  }
  tm_straight_anew(x0, y0, heading0, x1, y1, heading1, &curve);
  return tm_piece_clear(&curve, 0u, length, width, box_x, box_y, cos(box_heading), sin(box_heading), box_length, box_width);
}

/** The same along a curve, of these curvatures at both poses [1/m]. Distances above `bound` need not be exact: the caller takes the least
   of many, and has found `bound` already. */
static double tm_curved_clear(double x0, double y0, double heading0, double x1, double y1, double heading1, double length,
                              double width, double box_x, double box_y, double box_heading, double box_length, double box_width,
                              double kappa0, double kappa1, double bound) {
  tm_curve curve;
  double ahead;
  double aside;
  double least;
  if (!tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) || !tm_usable(heading1) ||
      !tm_usable(box_x) || !tm_usable(box_y) || !tm_usable(box_heading) || !tm_usable(kappa0) || !tm_usable(kappa1) ||
      !tm_sized(length, width) || !tm_sized(box_length, box_width)) {
    return TM_NAN;
  }
  const double far = tm_curve_far(x1 - x0, y1 - y0, box_x - x0, box_y - y0, length + width, box_length + box_width, kappa0, kappa1);
  if (far > tm_greatest(bound, 0.0)) {
    return far;
  }
  tm_straight_anew(x0, y0, heading0, x1, y1, heading1, &curve);
  tm_curve_of(kappa0, kappa1, length, width, &curve);
  ahead = cos(box_heading);
  aside = sin(box_heading);
  least = tm_curve_limit(&curve, bound);
  for (size_t j = 0u; j < curve.count; ++j) {
    const double dx = curve.x[j + 1u] - curve.x[j];
    const double dy = curve.y[j + 1u] - curve.y[j];
    const double mx = (box_x - curve.x[j]) - (0.5 * dx);
    const double my = (box_y - curve.y[j]) - (0.5 * dy);
    /* Length and width together are no less than twice the way to a corner, and more than that by more than rounding. */
    const double around = 0.5 * (sqrt((dx * dx) + (dy * dy)) + ((length + width) + (box_length + box_width)));
    if ((sqrt((mx * mx) + (my * my)) - around) <= tm_greatest(least, 0.0)) {
      least = tm_least(least, tm_piece_clear(&curve, j, length, width, box_x, box_y, ahead, aside, box_length, box_width));
    }
  }
  return least - curve.more;
}
