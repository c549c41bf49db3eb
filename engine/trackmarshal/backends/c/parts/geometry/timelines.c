/* What a vehicle sweeps along a whole timeline inside a region: the least margin, stretch by stretch. */

/** The way from a sample of a timeline to the one after it: a curve, or straight where `kappa` is NULL. */
static void tm_way(tm_shape *shape, const double *x, const double *y, const double *heading, const double *kappa, size_t from,
                   size_t to, double length, double width, tm_curve *curve) {
  tm_straight(shape, x[from], y[from], heading[from], x[to], y[to], heading[to], curve);
  if (kappa != NULL) {
    tm_curve_of(kappa[from], kappa[to], length, width, curve);
  }
}

/** The gap between a border segment and the sweep that passes nearest to it, to begin with: none of a timeline's margins that
   is greater matters. */
static double tm_first_gap(tm_context *c, tm_shape *shape, size_t which, const double *x, const double *y, const double *heading,
                           const double *kappa, size_t n, double length, double width) {
  const tm_ends *s = &c->ends[shape->first + which];
  tm_curve curve;
  double best = TM_INF;
  double nearest = TM_INF;
  bool entered = false;
  size_t at = 0u;
  for (size_t i = 0u; i < n; ++i) {
    const double dx = x[i] - s->ax;
    const double dy = y[i] - s->ay;
    const double square = (dx * dx) + (dy * dy);
    if (square < nearest) {
      nearest = square;
      at = i;
    }
  }
  tm_way(shape, x, y, heading, kappa, tm_before(at, 1u), at, length, width, &curve);
  for (size_t j = 0u; (j < curve.count) && !entered; ++j) {
    tm_sweep sweep;
    tm_sweep_piece(&curve, j, length, width, best, &sweep);
    (void)tm_sweep_nearer(c, shape->first + which, &sweep);
    best = sweep.best;
    entered = sweep.entered;
  }
  if (!entered && (best <= (2.0 * length))) {
    return best - curve.more;
  }
  shape->hint = which;
  return tm_curve_inside(c, shape, &curve, length, width, TM_INF);
}

/** The margin [m] of a way in a stretch, of which these listed segments are near; one that is not below `bound` need not be exact. */
static double tm_way_listed(tm_context *c, tm_shape *shape, const tm_stretch *stretch, unsigned long near, const tm_curve *curve,
                            double length, double width, double bound, bool inside) {
  double least = tm_curve_limit(curve, bound);
  shape->inside = inside;
  for (size_t j = 0u; j < curve->count; ++j) {
    tm_sweep sweep;
    tm_sweep_piece(curve, j, length, width, least, &sweep);
    tm_sweep_listed(c, shape, stretch, near, &sweep);
    least = tm_least(least, tm_sweep_margin(c, shape, &sweep, shape->inside, (curve->x[j] + curve->x[j + 1u]) / 2.0,
                                            (curve->y[j] + curve->y[j + 1u]) / 2.0));
  }
  return least - curve->more;
}

/** The least signed margin [m] of what a vehicle sweeps from sample to sample of a timeline inside a region; NaN where one has none.
   `kappa`: the curvatures there [1/m]; NULL where it goes straight.
   Sweeps are looked at eight at a time: what stays farther from the border than the least gap so far is inside if its first pose is. */
static double tm_timeline_inside(tm_context *c, tm_shape *shape, const double *x, const double *y, const double *heading,
                                 const double *kappa, size_t n, double length, double width) {
  double best;
  bool inside = false;
  if (!shape->usable || !tm_sized(length, width) || (n < 1u)) {
    return TM_NAN;
  }
  for (size_t i = 0u; i < n; ++i) {
    if (!tm_usable(x[i]) || !tm_usable(y[i]) || !tm_usable(heading[i]) || ((kappa != NULL) && !tm_usable(kappa[i]))) {
      return TM_NAN;
    }
  }
  /* Candidates come by turns: each begins where its margin was least in the cycle before. */
  shape->turn_near = (shape->turn_near == 0u) ? 1u : 0u;
  size_t *hint = &shape->near[shape->turn_near];
  *hint = (*hint < shape->count) ? *hint : 0u;
  best = tm_first_gap(c, shape, *hint, x, y, heading, kappa, n, length, width);
  size_t stop = 0u;
  for (size_t first = 0u; first < n; first = stop) {
    const size_t from = tm_before(first, 1u);
    stop = tm_stretch_end(x, y, heading, n, from, first, length);
    tm_stretch stretch;
    tm_stretch_of(&stretch, &x[from], &y[from], &heading[from], stop - from, length, width);
    stretch.widest = 0.0;
    if (kappa != NULL) {
      tm_stretch_reaches(&stretch, &kappa[from], stop - from, length, width);
    }
    stretch.count = TM_STRETCH_LIST + 1u;
    if (stretch.widest < TM_INF) {
      tm_stretch_list(c, shape, &stretch, tm_greatest(best, 1e-3) + stretch.widest);
    }
    if ((stretch.count == 0u) && (inside || tm_holds(c, shape, x[from], y[from]))) {
      inside = true;
      continue;
    }
    for (size_t i = first; i < stop; ++i) {
      const size_t k = tm_before(i, 1u);
      const bool listed = stretch.count <= TM_STRETCH_LIST;
      unsigned long near = 0u;
      tm_curve curve;
      double margin;
      shape->hint = *hint;
      if (listed) {
        const size_t p = k - from;
        const size_t q = i - from;
        const double reach = tm_greatest(best, 1e-3) + ((kappa != NULL) ? stretch.reach[i - from] : 0.0);
        near = tm_stretch_near(&stretch, p, q, reach);
        if (near != 0u) {
          near = tm_stretch_nearer(&stretch, p, q, length, width, reach, near);
        }
        if ((near == 0u) && (inside || tm_holds(c, shape, x[k], y[k]))) {
          inside = true;
          continue;
        }
      }
      tm_way(shape, x, y, heading, kappa, k, i, length, width, &curve);
      if (listed) {
        margin = tm_way_listed(c, shape, &stretch, near, &curve, length, width, best, inside);
      } else {
        shape->inside = inside;
        shape->x = x[k];
        shape->y = y[k];
        margin = tm_curve_inside(c, shape, &curve, length, width, best);
      }
      inside = shape->inside;
      if (margin < best) {
        best = margin;
        *hint = shape->hint;
      }
    }
  }
  shape->inside = false;
  return best;
}
