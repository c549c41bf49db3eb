/* Points and stations along the path of a trajectory, which comes with each cycle and is not prepared. */

/** Whether two points are one. */
static bool tm_same(double ax, double ay, double bx, double by) {
  return (fabs(ax - bx) <= 1e-9) && (fabs(ay - by) <= 1e-9);
}

/** The index of the next point of a path after `i` that is another one; the count where there is none. */
static size_t tm_path_next(const double *px, const double *py, size_t n, size_t i) {
  size_t j = i + 1u;
  while ((j < n) && tm_same(px[j], py[j], px[i], py[i])) {
    ++j;
  }
  return j;
}

/** Whether a path has two or more points, all of them usable. */
static bool tm_path_there(const double *px, const double *py, size_t n) {
  for (size_t i = 0u; i < n; ++i) {
    if (!tm_usable(px[i]) || !tm_usable(py[i])) {
      return false;
    }
  }
  return n >= 2u;
}

/** Whether the points of a path are usable, and at least two are different. */
static bool tm_path_usable(const double *px, const double *py, size_t n) {
  return tm_path_there(px, py, n) && (tm_path_next(px, py, n, 0u) < n);
}

/** Station, offset and direction of a point along the path of a trajectory. */
static tm_projection tm_path_project(const double *px, const double *py, size_t n, double x, double y) {
  tm_projection result;
  tm_segment nearest;
  double best = TM_INF;
  double station = 0.0;
  double before = 0.0;
  bool first = true;
  bool last = true;
  if (!tm_usable(x) || !tm_usable(y) || !tm_path_usable(px, py, n)) {
    return tm_nowhere();
  }
  nearest = tm_between(px[0], py[0], px[0], py[0]);
  size_t i = 0u;
  size_t j = tm_path_next(px, py, n, 0u);
  while (j < n) {
    const tm_segment s = tm_between(px[i], py[i], px[j], py[j]);
    const double reach = tm_segment_distance(&s, 0.0, 0.0, x, y);
    const size_t next = tm_path_next(px, py, n, j);
    if (reach < best) {
      best = reach;
      nearest = s;
      station = before;
      first = i == 0u;
      last = next >= n;
    }
    before += s.length;
    i = j;
    j = next;
  }
  result = tm_beside(&nearest, best, !first, !last, x, y);
  result.station = station + result.station;
  result.direction = atan2(nearest.ey, nearest.ex);
  return result;
}

/** The distance [m] of a point from the path of a trajectory; of one that stays in one place, from that place. */
static double tm_path_distance(const double *px, const double *py, size_t n, double x, double y) {
  double best = TM_INF;
  if (!tm_usable(x) || !tm_usable(y) || !tm_path_there(px, py, n)) {
    return TM_NAN;
  }
  size_t i = 0u;
  size_t j = tm_path_next(px, py, n, 0u);
  if (j >= n) {
    const double dx = x - px[0];
    const double dy = y - py[0];
    best = sqrt((dx * dx) + (dy * dy));
  }
  while (j < n) {
    const bool far = ((0.999999 * fabs(x - px[i])) > (best + fabs(px[j] - px[i]))) ||
                     ((0.999999 * fabs(y - py[i])) > (best + fabs(py[j] - py[i])));
    if (!far) {
      const tm_segment s = tm_between(px[i], py[i], px[j], py[j]);
      best = tm_least(best, tm_segment_distance(&s, 0.0, 0.0, x, y));
    }
    i = j;
    j = tm_path_next(px, py, n, j);
  }
  return best;
}

/** How far one station of a path lies ahead of another [m]. */
static double tm_path_gap(const double *px, const double *py, size_t n, double from, double to) {
  if (!tm_finite(from) || !tm_finite(to) || !tm_path_usable(px, py, n)) {
    return TM_NAN;
  }
  return to - from;
}

/** How far inside the stretch from `start` ahead to `end` a station of a path lies [m]; negative: outside. */
static double tm_path_stretch_room(const double *px, const double *py, size_t n, double station, double start, double end) {
  if (!tm_finite(station) || !tm_finite(start) || !tm_finite(end) || !tm_path_usable(px, py, n)) {
    return TM_NAN;
  }
  return (start <= end) ? tm_least(station - start, end - station) : TM_NAN;
}
