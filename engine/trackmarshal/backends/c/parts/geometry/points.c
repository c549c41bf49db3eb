/* Points beside a border: how far it is, and whether they lie in the region. */

/** The distance of a point from a segment; both are seen from (ox, oy). */
static double tm_segment_distance(const tm_segment *s, double ox, double oy, double x, double y) {
  const double rx = x - (s->ax - ox);
  const double ry = y - (s->ay - oy);
  const double product = (s->ex * rx) + (s->ey * ry);
  if ((0.0 < product) && (product < s->square)) {
    return fabs((s->ex * ry) - (s->ey * rx)) / s->length;
  }
  const double sx = x - (s->bx - ox);
  const double sy = y - (s->by - oy);
  const double start = (rx * rx) + (ry * ry);
  const double end = (sx * sx) + (sy * sy);
  return sqrt((end < start) ? end : start);
}

/** From a segment to the one beside it as long as that is nearer to a point, in one direction; the distance then. No more than so many: what
   is nearest is looked for after that, and not far any more. */
static double tm_downhill(const tm_context *c, const tm_shape *shape, double ox, double oy, double x, double y, bool forward, double best,
                          size_t *which) {
  const size_t last = forward ? (shape->first + shape->count - 1u) : shape->first;
  double least = best;
  for (size_t n = 0u; (n < 64u) && (*which != last); ++n) {
    const size_t next = forward ? (*which + 1u) : (*which - 1u);
    const tm_segment s = tm_segment_at(c, next);
    const double reach = tm_segment_distance(&s, ox, oy, x, y);
    if (!(reach < least)) {
      break;
    }
    least = reach;
    *which = next;
  }
  return least;
}

/** The distance of a point from a shape's segments, seen from (ox, oy), and the first of the nearest ones. */
static double tm_nearest(const tm_context *c, tm_shape *shape, double ox, double oy, double x, double y, size_t *which) {
  const tm_box at = {x + ox, y + oy, x + ox, y + oy};
  const tm_frame point = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  const tm_strip strip = tm_strip_of(&point, at.x0, at.y0);
  const size_t end = shape->first + shape->count;
  const size_t likely = shape->first + ((shape->hint < shape->count) ? shape->hint : 0u);
  const tm_segment first = tm_segment_at(c, likely);
  size_t nearest = likely;
  double best = tm_segment_distance(&first, ox, oy, x, y);
  best = tm_downhill(c, shape, ox, oy, x, y, true, best, &nearest);
  best = tm_downhill(c, shape, ox, oy, x, y, false, best, &nearest);
  const size_t begun = nearest;
  tm_box near = tm_grown(&at, best);
  tm_walk walk = tm_walk_near(shape, shape->first, &near);
  for (size_t i = tm_walk_next(c, &walk); i < end; i = tm_walk_next(c, &walk)) {
    const size_t stop = tm_block_end(i, end);
    unsigned looked = tm_strip_near(c, i, &strip, best);
    for (size_t k = i; (looked != 0u) && (k < stop); ++k) {
      if (((looked & 1u) != 0u) && (k != begun)) {
        const tm_segment s = tm_segment_at(c, k);
        const double reach = tm_segment_distance(&s, ox, oy, x, y);
        if ((reach < best) || ((reach == best) && (k < nearest))) {
          best = reach;
          nearest = k;
          near = tm_grown(&at, best);
          tm_walk_box(&walk, &near);
        }
      }
      looked >>= 1u;
    }
  }
  shape->hint = nearest - shape->first;
  *which = nearest;
  return best;
}

/** Whether a point that is not on the border lies inside a region: a ray along +x crosses the border an odd number of times. */
static bool tm_holds(const tm_context *c, const tm_shape *shape, double x, double y) {
  const tm_box ray = {x - 1e-3, y, TM_INF, y};
  const size_t end = shape->first + shape->count;
  bool inside = false;
  tm_walk walk = tm_walk_near(shape, shape->first, &ray);
  for (size_t i = tm_walk_next(c, &walk); i < end; i = tm_walk_next(c, &walk)) {
    const size_t stop = tm_block_end(i, end);
    for (size_t k = i; k < stop; ++k) {
      const tm_segment s = tm_segment_at(c, k);
      const bool upward = s.ay < s.by;
      const double low = upward ? s.ay : s.by;
      const double high = upward ? s.by : s.ay;
      if ((low <= y) && (y < high)) {
        const double ex = upward ? s.ex : -s.ex;
        const double ey = upward ? s.ey : -s.ey;
        const double ax = upward ? s.ax : s.bx;
        if (((ex * (y - low)) - (ey * (x - ax))) > 0.0) {
          inside = !inside;
        }
      }
    }
  }
  return inside;
}

/** The signed distance [m] of a point from the border of a region, positive inside; NaN for what is no point or region. */
static double tm_in_area(tm_context *c, tm_shape *shape, double x, double y) {
  size_t which = 0u;
  double reach;
  if (!shape->usable || !tm_usable(x) || !tm_usable(y)) {
    return TM_NAN;
  }
  reach = tm_nearest(c, shape, 0.0, 0.0, x, y, &which);
  return ((reach == 0.0) || tm_holds(c, shape, x, y)) ? reach : -reach;
}

/** A number of the sign of a point's signed distance from the border of a region: at once where it is off the region's box. */
static double tm_in_area_sign(tm_context *c, tm_shape *shape, double x, double y) {
  const tm_box *box = &shape->around;
  const bool off = tm_usable(x) && tm_usable(y) && ((x < box->x0) || (box->x1 < x) || (y < box->y0) || (box->y1 < y));
  return (shape->usable && off) ? -1.0 : tm_in_area(c, shape, x, y);
}
