/* Points and stations along a line that was prepared. */

/** Station, offset and direction of a point beside one segment; whether the line goes on before and after it. */
static tm_projection tm_beside(const tm_segment *s, double reach, bool more_before, bool more_after, double x, double y) {
  tm_projection result;
  const double rx = x - s->ax;
  const double ry = y - s->ay;
  const double product = (s->ex * rx) + (s->ey * ry);
  const double advance = product / s->length;
  const bool before = (advance <= 0.0) && more_before;
  const bool after = (product >= s->square) && more_after;
  result.station = advance;
  result.offset = ((s->ex * ry) - (s->ey * rx)) / s->length;
  result.direction = 0.0;
  if (before || after) {
    const bool right = (result.offset < 0.0) || ((result.offset == 0.0) && ((1.0 / result.offset) < 0.0));
    result.station = before ? 0.0 : s->length;
    result.offset = right ? -reach : reach;
  }
  return result;
}

/** What a projection is where there is none. */
static tm_projection tm_nowhere(void) {
  tm_projection result;
  result.station = TM_NAN;
  result.offset = TM_NAN;
  result.direction = TM_NAN;
  return result;
}

/** Where the projection of a point is kept: what is left of a sum of both coordinates, which spreads them about. */
static size_t tm_projected_place(double x, double y) {
  const double sum = (12.9898 * x) + (78.233 * y);
  return (size_t)((double)TM_PROJECTED * (sum - floor(sum))) % TM_PROJECTED;
}

/** How far a point that was projected is from another, squared; NaN where there is none. */
static double tm_projected_apart(const tm_projected *one, double x, double y) {
  return ((one->x - x) * (one->x - x)) + ((one->y - y) * (one->y - y));
}

/** The segment to begin with, looking for what is nearest to a point that will be kept at `place`: that of the point before it, as along a plan;
   where that was far away, that of another one which was not near the one before it either: in the cycle before, the car and the others. */
static size_t tm_line_hint(tm_shape *line, size_t place, double x, double y) {
  double nearest = tm_projected_apart(&line->recent[line->last], x, y);
  size_t hint = line->recent[line->last].segment;
  if (!(nearest < 400.0)) { /* 20 m */
    nearest = TM_INF;
    for (size_t i = 0u; i < TM_STARTS; ++i) {
      const tm_projected *start = &line->recent[line->starts[i]];
      const double apart = tm_projected_apart(start, x, y);
      if (apart < nearest) {
        nearest = apart;
        hint = start->segment;
      }
    }
    line->turn = (line->turn + 1u) % TM_STARTS;
    line->starts[line->turn] = place;
  }
  return hint;
}

/** Station [m], offset [m, positive to the left] and direction [rad] of a point along a line. Many rules ask for the same few points. */
static tm_projection tm_line_project(tm_context *c, tm_shape *line, double x, double y) {
  size_t k = 0u;
  double reach;
  tm_projection result;
  if (!line->usable || !tm_usable(x) || !tm_usable(y)) {
    return tm_nowhere();
  }
  const bool zero = (x == 0.0) || (y == 0.0); /* both zeros are equal, yet not the same */
  const size_t place = tm_projected_place(x, y);
  tm_projected *known = &line->recent[place];
  if ((known->x == x) && (known->y == y) && !zero) {
    return known->at;
  }
  line->hint = tm_line_hint(line, place, x, y);
  reach = tm_nearest(c, line, 0.0, 0.0, x, y, &k);
  const tm_segment s = tm_segment_at(c, k);
  result = tm_beside(&s, reach, line->closed || (k > line->first),
                     line->closed || ((k + 1u) < (line->first + line->count)), x, y);
  result.station = c->along[k].station + result.station;
  if (line->closed && (result.station >= line->length)) {
    result.station = 0.0;
  }
  result.direction = c->along[k].direction;
  known->x = x;
  known->y = y;
  known->at = result;
  known->segment = k - line->first;
  line->last = place;
  return result;
}

/** Forget the points that were projected on a line. */
static void tm_forget(tm_shape *line) {
  line->last = 0u;
  line->turn = 0u;
  for (size_t i = 0u; i < TM_STARTS; ++i) {
    line->starts[i] = 0u;
  }
  for (size_t i = 0u; i < TM_PROJECTED; ++i) {
    line->recent[i].x = TM_NAN;
    line->recent[i].y = TM_NAN;
    line->recent[i].at = tm_nowhere();
    line->recent[i].segment = 0u;
  }
}

/** The distance [m] of a point from a line. */
static double tm_line_distance(tm_context *c, tm_shape *line, double x, double y) {
  size_t k = 0u;
  if (!line->usable || !tm_usable(x) || !tm_usable(y)) {
    return TM_NAN;
  }
  return tm_nearest(c, line, 0.0, 0.0, x, y, &k);
}

/** How far one station lies ahead of another [m]; on a closed line the shorter way round. */
static double tm_line_gap(const tm_context *c, const tm_shape *line, double from, double to) {
  double gap;
  (void)c;
  if (!line->usable || !tm_finite(from) || !tm_finite(to)) {
    return TM_NAN;
  }
  gap = to - from;
  if (line->closed) {
    gap -= line->length * ceil((gap / line->length) - 0.5);
  }
  return gap;
}

/** A station of a closed line in [0, length). */
static double tm_on_lap(double station, double length) {
  double rest = fmod(station, length);
  if (rest < 0.0) {
    rest += length;
  }
  return (rest >= length) ? 0.0 : rest;
}

/** How far it is from one station in [0, length) ahead to another [m]. */
static double tm_ahead(double start, double end, double length) {
  const double way = end - start;
  return (start <= end) ? way : (way + length);
}

/** How far inside the stretch from `start` ahead to `end` a station lies, along the line [m]; negative: outside. */
static double tm_line_stretch_room(const tm_context *c, const tm_shape *line, double station, double start, double end) {
  double s;
  double a;
  double b;
  bool inside;
  (void)c;
  if (!line->usable || !tm_finite(station) || !tm_finite(start) || !tm_finite(end)) {
    return TM_NAN;
  }
  if (!line->closed) {
    return (start <= end) ? tm_least(station - start, end - station) : TM_NAN;
  }
  s = tm_on_lap(station, line->length);
  a = tm_on_lap(start, line->length);
  b = tm_on_lap(end, line->length);
  inside = (a < b) ? ((a <= s) && (s <= b)) : ((a <= s) || (s <= b));
  return inside ? tm_least(tm_ahead(a, s, line->length), tm_ahead(s, b, line->length))
                : -tm_least(tm_ahead(s, a, line->length), tm_ahead(b, s, line->length));
}
