/* Where a trajectory is at a time, and which place of its path is nearest: what the state machine of a Supervisor asks. */

/** The last sample of a trajectory, whose times count from `stamp`, that is due by now, 0 before all. */
static void tm_due_by(const double *t, size_t count, double stamp, double now, size_t *first) {
  *first = 0u;
  for (size_t i = 0u; i < count; ++i) {
    if ((t[i] + stamp) <= now) {
      *first = i;
    }
  }
}

/** How far along its path, straight between samples, a trajectory is at a time; whether it covers the time. */
static bool tm_station_at(const double *due, const double *x, const double *y, size_t count, double t, double *station) {
  size_t i = 0u;
  const bool covered = (count >= 2u) && (due[0] <= t) && (t <= due[count - 1u]);
  if (covered) {
    double along = 0.0;
    for (size_t k = 1u; (k + 1u) < count; ++k) {
      if (due[k] <= t) {
        i = k;
      }
    }
    for (size_t k = 0u; k < i; ++k) {
      const double dx = x[k + 1u] - x[k];
      const double dy = y[k + 1u] - y[k];
      along += sqrt((dx * dx) + (dy * dy));
    }
    const double step = due[i + 1u] - due[i];
    const double share = (step > 0.0) ? ((t - due[i]) / step) : 1.0;
    const double dx = x[i + 1u] - x[i];
    const double dy = y[i + 1u] - y[i];
    *station = along + (share * sqrt((dx * dx) + (dy * dy)));
  }
  return covered;
}

/** The place of a path that is nearest to (x, y), of those from station `least` to `most`; the first of equally near ones. */
static tm_spot tm_spot_near(const double *px, const double *py, const double *heading, const double *v, size_t count, double x, double y,
                          double least, double most) {
  tm_spot best = {TM_INF, TM_NAN, TM_NAN};
  double begin = 0.0;
  for (size_t i = 0u; (i + 1u) < count; ++i) {
    const double dx = px[i + 1u] - px[i];
    const double dy = py[i + 1u] - py[i];
    const double square = (dx * dx) + (dy * dy);
    const double length = sqrt(square);
    const double end = begin + length;
    if ((end >= least) && (begin <= most)) {
      double share = 0.0;
      if (square > 0.0) {
        const double low = (least - begin) / length;
        const double high = (most - begin) / length;
        share = (((x - px[i]) * dx) + ((y - py[i]) * dy)) / square;
        share = (low > share) ? low : share;
        share = (share < 0.0) ? 0.0 : share;
        share = (high < share) ? high : share;
        share = (share > 1.0) ? 1.0 : share;
      }
      const double ax = x - (px[i] + (share * dx));
      const double ay = y - (py[i] + (share * dy));
      const double away = sqrt((ax * ax) + (ay * ay));
      if (away < best.away) {
        best.away = away;
        best.heading = heading[i] + (share * remainder(heading[i + 1u] - heading[i], 6.283185307179586));
        best.v = v[i] + (share * (v[i + 1u] - v[i]));
      }
    }
    begin = end;
  }
  return best;
}
