/* Lanes of a set: the one of a number, and how far what a vehicle sweeps reaches into one. */

/** The lane of a set by its number; where there is no such one, the last place, which no lane has. */
static tm_shape *tm_lane_at(tm_shape *lanes, size_t count, double lane) {
  const bool there = (lane >= 0.0) && (lane < (double)count);
  return &lanes[there ? (size_t)lane : TM_MAX_ELEMENTS];
}

/** The negative margin of a hull that is not outside a region: how far in it its corners are, how deep in the hull the border is. */
static double tm_within(tm_context *c, tm_shape *shape, const tm_sweep *sweep) {
  const size_t end = shape->first + shape->count;
  double worst = 0.0;
  for (size_t i = 0u; i < 8u; ++i) {
    size_t which = 0u;
    const double reach = tm_nearest(c, shape, sweep->ox, sweep->oy, sweep->x[i], sweep->y[i], &which);
    if ((reach > 0.0) && tm_holds(c, shape, sweep->x[i] + sweep->ox, sweep->y[i] + sweep->oy)) {
      worst = tm_greatest(worst, reach);
    }
  }
  for (size_t i = shape->first; i < end; ++i) {
    const tm_segment s = tm_segment_at(c, i);
    worst = tm_greatest(worst, tm_depth(&sweep->hull, s.ax - sweep->ox, s.ay - sweep->oy));
  }
  const bool passes = worst == 0.0; /* the border, between corners */
  for (size_t i = shape->first; passes && (i < end); ++i) {
    const tm_segment s = tm_segment_at(c, i);
    if (tm_enters(&s, sweep->ox, sweep->oy, &sweep->hull)) {
      worst = tm_greatest(worst, tm_middle_depth(&s, sweep->ox, sweep->oy, &sweep->hull));
    }
  }
  return tm_least(-2.2250738585072014e-308, -worst);
}

/** The signed margin [m] of a piece of a curve outside a region. */
static double tm_piece_outside(tm_context *c, tm_shape *shape, const tm_curve *curve, size_t j, double length, double width) {
  tm_sweep sweep;
  const double x = (curve->x[j] + curve->x[j + 1u]) / 2.0;
  const double y = (curve->y[j] + curve->y[j + 1u]) / 2.0;
  tm_sweep_piece(curve, j, length, width, TM_INF, &sweep);
  tm_sweep_corners(&sweep);
  tm_sweep_hull(&sweep);
  for (size_t i = shape->first; (i < (shape->first + shape->count)) && !sweep.entered; ++i) {
    (void)tm_sweep_nearer(c, i, &sweep);
  }
  return (sweep.entered || tm_holds(c, shape, x, y)) ? tm_within(c, shape, &sweep) : sweep.best;
}

/** How far what a vehicle sweeps straight between two poses reaches into a region [m]; negative: how far apart they are. NaN for what is none. */
static double tm_swept_meets(tm_context *c, tm_shape *shape, double x0, double y0, double heading0, double x1, double y1,
                             double heading1, double length, double width) {
  tm_curve curve;
  if (!shape->usable || !tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) ||
      !tm_usable(heading1) || !tm_sized(length, width)) {
    return TM_NAN;
  }
  tm_straight(shape, x0, y0, heading0, x1, y1, heading1, &curve);
  return -tm_piece_outside(c, shape, &curve, 0u, length, width);
}

/** The same along a curve, of these curvatures at both poses [1/m]. */
static double tm_curved_meets(tm_context *c, tm_shape *shape, double x0, double y0, double heading0, double x1, double y1,
                              double heading1, double length, double width, double kappa0, double kappa1) {
  tm_curve curve;
  double least = TM_INF;
  if (!shape->usable || !tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) ||
      !tm_usable(heading1) || !tm_usable(kappa0) || !tm_usable(kappa1) || !tm_sized(length, width)) {
    return TM_NAN;
  }
  tm_straight(shape, x0, y0, heading0, x1, y1, heading1, &curve);
  tm_curve_of(kappa0, kappa1, length, width, &curve);
  for (size_t j = 0u; j < curve.count; ++j) {
    least = tm_least(least, tm_piece_outside(c, shape, &curve, j, length, width));
  }
  return -(least - curve.more);
}
