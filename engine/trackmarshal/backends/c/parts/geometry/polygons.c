/* Rings of points, and the inside of a simple polygon: prepared. */

/** The points (x, y, x, y, ...) without repetitions of the last one kept, into `out`, which may be `points`; their count. */
static size_t tm_distinct(const double *points, size_t n, bool closed, double *out) {
  size_t kept = 0u;
  for (size_t i = 0u; i < n; ++i) {
    const double x = points[2u * i];
    const double y = points[(2u * i) + 1u];
    if ((kept == 0u) || !tm_same(x, y, out[2u * (kept - 1u)], out[(2u * (kept - 1u)) + 1u])) {
      out[2u * kept] = x;
      out[(2u * kept) + 1u] = y;
      ++kept;
    }
  }
  while (closed && (kept > 1u) && tm_same(out[2u * (kept - 1u)], out[(2u * (kept - 1u)) + 1u], out[0], out[1])) {
    --kept;
  }
  return kept;
}

/** Whether all coordinates are usable. */
static bool tm_all_usable(const double *points, size_t n) {
  for (size_t i = 0u; i < (2u * n); ++i) {
    if (!tm_usable(points[i])) {
      return false;
    }
  }
  return true;
}

/** Whether a coordinate is so near to zero, without being it, that products are not exact (below 2^-200 m). */
static bool tm_any_tiny(const double *points, size_t n) {
  for (size_t i = 0u; i < (2u * n); ++i) {
    if ((points[i] != 0.0) && (fabs(points[i]) < 6.223015277861142e-61)) {
      return true;
    }
  }
  return false;
}

/** Append a segment to a shape. */
static void tm_append(tm_context *c, tm_shape *shape, const double *a, const double *b) {
  tm_ends *ends = &c->ends[shape->first + shape->count];
  ends->ax = a[0];
  ends->ay = a[1];
  ends->bx = b[0];
  ends->by = b[1];
  ++shape->count;
}

/** Append sides of a ring of points to a region: its inside on their left, or, `flipped`, on their right. */
static void tm_add_ring(tm_context *c, tm_shape *shape, const double *points, size_t n, size_t sides, bool flipped) {
  double doubled = 0.0;
  for (size_t i = 0u; i < sides; ++i) {
    const double *a = &points[2u * i];
    const double *b = &points[2u * (((i + 1u) < n) ? (i + 1u) : 0u)];
    doubled += ((a[0] - points[0]) * (b[1] - points[1])) - ((a[1] - points[1]) * (b[0] - points[0]));
  }
  const bool forward = (doubled > 0.0) != flipped;
  for (size_t k = 0u; k < sides; ++k) {
    const size_t i = forward ? k : ((sides - 1u) - k);
    const double *a = &points[2u * i];
    const double *b = &points[2u * (((i + 1u) < n) ? (i + 1u) : 0u)];
    tm_append(c, shape, forward ? a : b, forward ? b : a);
  }
}

/** The next segment after `i` in the blocks of a walk that began no later. */
static size_t tm_walk_after(const tm_context *c, tm_walk *walk, size_t i) {
  const size_t next = i + 1u;
  if ((walk->block <= i) && (next < (walk->block + 8u))) {
    return next;
  }
  do {
    walk->block = tm_walk_next(c, walk);
  } while ((walk->block + 8u) <= next);
  return (walk->block > next) ? walk->block : next;
}

/** Whether two segments that are no neighbours meet, or a segment folds back on the one before it. */
static bool tm_crosses(const tm_context *c, const tm_shape *shape, size_t ring_sides) {
  const size_t end = shape->first + shape->count;
  for (size_t i = shape->first; i < end; ++i) {
    const size_t at = i - shape->first;
    const size_t start = (at < ring_sides) ? shape->first : (shape->first + ring_sides);
    const size_t stop = (at < ring_sides) ? (shape->first + ring_sides) : end;
    const tm_ends *s = &c->ends[i];
    const tm_ends *after = &c->ends[((i + 1u) < stop) ? (i + 1u) : start];
    const double a[2] = {s->ax, s->ay};
    const double b[2] = {s->bx, s->by};
    const double next[2] = {after->bx, after->by};
    const tm_box box = tm_box_of(s);
    if (tm_folds_back(a, b, next)) {
      return true;
    }
    tm_walk walk = tm_walk_near(shape, i, &box);
    for (size_t j = tm_walk_after(c, &walk, i); j < end; j = tm_walk_after(c, &walk, j)) {
      const tm_ends *other = &c->ends[j];
      const double p[2] = {other->ax, other->ay};
      const double q[2] = {other->bx, other->by};
      const bool neighbours = (j < stop) && (((j - i) == 1u) || ((j - i) == ((stop - start) - 1u)));
      if (!neighbours && tm_meet(a, b, p, q)) {
        return true;
      }
    }
  }
  return false;
}

/** Whether the ray from a point along +x crosses the ring an odd number of times. */
static bool tm_odd(const double *points, size_t n, double x, double y) {
  bool inside = false;
  for (size_t i = 0u; i < n; ++i) {
    const double *a = &points[2u * i];
    const double *b = &points[2u * (((i + 1u) < n) ? (i + 1u) : 0u)];
    const double *low = (a[1] < b[1]) ? a : b;
    const double *high = (a[1] < b[1]) ? b : a;
    if ((low[1] <= y) && (y < high[1]) && ((((high[0] - low[0]) * (y - low[1])) - ((high[1] - low[1]) * (x - low[0]))) > 0.0)) {
      inside = !inside;
    }
  }
  return inside;
}

/** Prepare the inside of a simple polygon. TM_UNUSABLE: it is none; what asks for it is undefined. */
static tm_status tm_make_polygon(tm_context *c, tm_shape *shape, const double *points, size_t n) {
  size_t count;
  shape->usable = false;
  shape->count = 0u;
  tm_unknown(shape);
  if (!tm_all_usable(points, n)) {
    return TM_UNUSABLE;
  }
  if (tm_any_tiny(points, n)) {
    return TM_UNSUPPORTED;
  }
  count = tm_distinct(points, n, true, c->ring);
  if (count < 3u) {
    return TM_UNUSABLE;
  }
  tm_add_ring(c, shape, c->ring, count, count, false);
  tm_index(c, shape);
  if (tm_crosses(c, shape, shape->count)) {
    return TM_UNUSABLE;
  }
  shape->usable = true;
  return TM_OK;
}
