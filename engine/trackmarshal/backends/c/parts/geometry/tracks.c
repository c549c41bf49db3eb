/* The region between two borders, a line, the line midway between borders: prepared. */

/** Prepare the region between two borders. TM_UNUSABLE: what asks for it is undefined. TM_UNSUPPORTED: coordinates that are all
   but zero, or a figure of eight that crosses itself too often; undefined too. */
static tm_status tm_make_corridor(tm_context *c, tm_shape *shape, const double *left, size_t left_count, const double *right,
                                  size_t right_count, bool closed) {
  double *ring = c->ring;
  size_t lefts;
  size_t rights;
  const size_t least = closed ? 3u : 2u;
  shape->usable = false;
  shape->count = 0u;
  tm_unknown(shape);
  shape->closed = closed;
  if (!tm_all_usable(left, left_count) || !tm_all_usable(right, right_count)) {
    return TM_UNUSABLE;
  }
  lefts = tm_distinct(left, left_count, closed, ring);
  rights = tm_distinct(right, right_count, closed, &ring[2u * lefts]);
  if ((lefts < least) || (rights < least)) {
    return TM_UNUSABLE;
  }
  if (tm_any_tiny(ring, lefts + rights)) {
    return TM_UNSUPPORTED;
  }
  double *other = &ring[2u * lefts];
  if (closed) {
    const bool left_inside = tm_odd(other, rights, ring[0], ring[1]);
    const bool right_inside = tm_odd(ring, lefts, other[0], other[1]);
    const bool left_is_inner = left_inside;
    const double *outer = left_is_inner ? other : ring;
    const double *inner = left_is_inner ? ring : other;
    const size_t outers = left_is_inner ? rights : lefts;
    const size_t inners = left_is_inner ? lefts : rights;
    tm_add_ring(c, shape, outer, outers, outers, false);
    tm_add_ring(c, shape, inner, inners, inners, true);
    tm_index(c, shape);
    if (tm_crosses(c, shape, outers)) {
      return (left_count == right_count) ? tm_make_eight(c, shape, left, right, left_count) : TM_UNUSABLE;
    }
    if (!left_inside && !right_inside) {
      return TM_UNUSABLE;
    }
  } else {
    size_t sides = (lefts - 1u) + (rights - 1u);
    size_t count;
    if (!tm_same(ring[0], ring[1], other[0], other[1])) {
      ++sides;
    }
    if (!tm_same(ring[2u * (lefts - 1u)], ring[(2u * (lefts - 1u)) + 1u], other[2u * (rights - 1u)],
                 other[(2u * (rights - 1u)) + 1u])) {
      ++sides;
    }
    for (size_t i = 0u; i < (rights / 2u); ++i) {
      const size_t j = (rights - 1u) - i;
      const double x = other[2u * i];
      const double y = other[(2u * i) + 1u];
      other[2u * i] = other[2u * j];
      other[(2u * i) + 1u] = other[(2u * j) + 1u];
      other[2u * j] = x;
      other[(2u * j) + 1u] = y;
    }
    count = tm_distinct(ring, lefts + rights, true, ring);
    if (count < sides) {
      sides = count;
    }
    tm_add_ring(c, shape, ring, count, sides, false);
    tm_index(c, shape);
    if (tm_crosses(c, shape, shape->count)) {
      return TM_UNUSABLE;
    }
  }
  shape->usable = true;
  return TM_OK;
}

/** Prepare a line. TM_UNUSABLE: what asks for it is undefined. */
static tm_status tm_make_line(tm_context *c, tm_shape *line, const double *points, size_t n, bool closed) {
  size_t count;
  double station = 0.0;
  line->usable = false;
  line->count = 0u;
  tm_unknown(line);
  line->closed = closed;
  tm_forget(line);
  if (!tm_all_usable(points, n)) {
    return TM_UNUSABLE;
  }
  count = tm_distinct(points, n, closed, c->ring);
  if (count < (closed ? 3u : 2u)) {
    return TM_UNUSABLE;
  }
  const size_t sides = closed ? count : (count - 1u);
  for (size_t k = 0u; k < sides; ++k) {
    const double *a = &c->ring[2u * k];
    const double *b = &c->ring[2u * (((k + 1u) < count) ? (k + 1u) : 0u)];
    const tm_segment s = tm_between(a[0], a[1], b[0], b[1]);
    tm_append(c, line, a, b);
    c->along[line->first + k].station = station;
    c->along[line->first + k].direction = atan2(s.ey, s.ex);
    station += s.length;
  }
  line->length = station;
  tm_index(c, line);
  line->usable = true;
  return TM_OK;
}

/** Prepare the line midway between two borders: midpoints of points that lie opposite each other, in pairs, or from each left point to the
    right border. */
static tm_status tm_make_centre(tm_context *c, tm_shape *line, const double *left, size_t left_count, const double *right,
                                size_t right_count, bool closed) {
  const bool paired = (left_count == right_count) && tm_all_usable(left, left_count) && tm_all_usable(right, right_count) &&
                      tm_opposite(left, right, left_count, closed);
  if (!paired) {
    if ((tm_make_line(c, line, right, right_count, closed) != TM_OK) || !tm_all_usable(left, left_count)) {
      line->usable = false;
      return TM_UNUSABLE;
    }
  }
  for (size_t i = 0u; i < left_count; ++i) {
    const double x = left[2u * i];
    const double y = left[(2u * i) + 1u];
    double to_x;
    double to_y;
    if (paired) {
      to_x = right[2u * i];
      to_y = right[(2u * i) + 1u];
    } else {
      size_t k = 0u;
      (void)tm_nearest(c, line, 0.0, 0.0, x, y, &k);
      const tm_segment nearest = tm_segment_at(c, k);
      const tm_segment *s = &nearest;
      const double rx = x - s->ax;
      const double ry = y - s->ay;
      const double sx = x - s->bx;
      const double sy = y - s->by;
      const double t = ((s->ex * rx) + (s->ey * ry)) / s->square;
      const bool at_start = sqrt((rx * rx) + (ry * ry)) <= sqrt((sx * sx) + (sy * sy));
      to_x = at_start ? s->ax : s->bx;
      to_y = at_start ? s->ay : s->by;
      if ((0.0 < t) && (t < 1.0)) {
        to_x = s->ax + (t * s->ex);
        to_y = s->ay + (t * s->ey);
      }
    }
    c->ring[2u * i] = (x + to_x) / 2.0;
    c->ring[(2u * i) + 1u] = (y + to_y) / 2.0;
  }
  return tm_make_line(c, line, c->ring, left_count, closed);
}
