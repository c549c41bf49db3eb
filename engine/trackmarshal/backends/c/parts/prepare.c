/** Nothing is known of a shape that is about to be prepared. */
static void tm_unknown(tm_shape *shape) {
  shape->hint = 0u;
  shape->near[0] = 0u;
  shape->near[1] = 0u;
  shape->turn_near = 0u;
  shape->known = false;
  shape->inside = false;
}

/** Outlines of every 8 segments of a shape whose boxes are made. Where one does not begin where the one before ends, there is none:
   NaN is near to everything. */
static void tm_outlines(tm_context *c, const tm_shape *shape) {
  const size_t end = shape->first + shape->count;
  for (size_t i = shape->first; i < end; i += 8u) {
    tm_outline *outline = &c->outline[i / 8u];
    const double x0 = (double)c->groups[i / 512u].x0[(i / 64u) & 7u];
    const double y0 = (double)c->groups[i / 512u].y0[(i / 64u) & 7u];
    const size_t stop = tm_block_end(i, end);
    bool torn = false;
    for (size_t k = 0u; k < 9u; ++k) {
      const tm_ends *s = &c->ends[((i + k) < stop) ? (i + k) : (stop - 1u)];
      const bool begins = (i + k) < stop;
      outline->x[k] = (float)((begins ? s->ax : s->bx) - x0);
      outline->y[k] = (float)((begins ? s->ay : s->by) - y0);
      if (begins && (k > 0u)) {
        torn = torn || !(c->ends[(i + k) - 1u].bx == s->ax) || !(c->ends[(i + k) - 1u].by == s->ay);
      }
    }
    for (size_t k = 0u; torn && (k < 9u); ++k) {
      outline->x[k] = (float)TM_NAN;
      outline->y[k] = (float)TM_NAN;
    }
  }
}

/** A box around nothing. */
static tm_box tm_no_box(void) {
  const tm_box box = {TM_INF, TM_INF, -TM_INF, -TM_INF};
  return box;
}

/** Let a box hold another one. */
static void tm_hold(tm_box *box, const tm_box *other) {
  box->x0 = tm_least(box->x0, other->x0);
  box->x1 = tm_greatest(box->x1, other->x1);
  box->y0 = tm_least(box->y0, other->y0);
  box->y1 = tm_greatest(box->y1, other->y1);
}

/** The box of a segment. */
static tm_box tm_box_of(const tm_ends *s) {
  const tm_box box = {tm_least(s->ax, s->bx), tm_least(s->ay, s->by), tm_greatest(s->ax, s->bx), tm_greatest(s->ay, s->by)};
  return box;
}

/** Put a box, in short, into one of eight places. */
static void tm_put_box(tm_boxes *boxes, size_t place, const tm_box *box) {
  boxes->x0[place] = tm_short_below(box->x0);
  boxes->y0[place] = tm_short_below(box->y0);
  boxes->x1[place] = tm_short_above(box->x1);
  boxes->y1[place] = tm_short_above(box->y1);
}

/** Boxes around every 8, 64 and 512 segments of a shape, and outlines. Places beyond its end hold a box around nothing. */
static void tm_index(tm_context *c, tm_shape *shape) {
  const size_t end = shape->first + shape->count;
  const tm_box nothing = tm_no_box();
  tm_box whole = nothing;
  for (size_t i = shape->first; i < end; i += 512u) {
    tm_box part = nothing;
    for (size_t j = i; j < (i + 512u); j += 64u) {
      tm_box group = nothing;
      for (size_t k = j; k < (j + 64u); k += 8u) {
        tm_box block = nothing;
        for (size_t m = k; (m < (k + 8u)) && (m < end); ++m) {
          const tm_box own = tm_box_of(&c->ends[m]);
          tm_hold(&block, &own);
        }
        tm_put_box(&c->blocks[j / 64u], (k / 8u) & 7u, &block);
        tm_hold(&group, &block);
      }
      tm_put_box(&c->groups[i / 512u], (j / 64u) & 7u, &group);
      tm_hold(&part, &group);
    }
    c->part_box[i / 512u] = part;
    tm_hold(&whole, &part);
  }
  shape->around = tm_grown(&whole, 1.0);
  tm_outlines(c, shape);
}

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

/** The corners of the quadrilateral from one pair of border points (left x, y, right x, y) to the next, without repetitions. */
static size_t tm_quad(const double *pair, const double *next, double *corners) {
  const double all[8] = {pair[2], pair[3], next[2], next[3], next[0], next[1], pair[0], pair[1]};
  return tm_distinct(all, 4u, true, corners);
}

/** Twice the signed area of a quadrilateral between pairs; NaN where it is not simple. */
static double tm_quad_area(const double *pair, const double *next) {
  double q[8];
  const size_t n = tm_quad(pair, next, q);
  double area = 0.0;
  if ((n < 3u) || ((n == 4u) && (tm_meet(&q[0], &q[2], &q[4], &q[6]) || tm_meet(&q[2], &q[4], &q[6], &q[0])))) {
    return TM_NAN;
  }
  for (size_t i = 1u; (i + 1u) < n; ++i) {
    const double *a = &q[2u * i];
    const double *b = &q[2u * (i + 1u)];
    area += ((a[0] - q[0]) * (b[1] - q[1])) - ((a[1] - q[1]) * (b[0] - q[0]));
  }
  return area;
}

/** Whether points of two borders, equally many, lie opposite each other: each quadrilateral from a pair to the next is simple, and all turn
    the same way round. */
static bool tm_opposite(const double *left, const double *right, size_t n, bool closed) {
  double last[4] = {0.0, 0.0, 0.0, 0.0};
  double most = -TM_INF;
  double least = TM_INF;
  const size_t end = (closed && (n > 0u)) ? (n + 1u) : n; /* of a lap, the first one comes again */
  for (size_t i = 0u; i < end; ++i) {
    const size_t k = 2u * ((i < n) ? i : 0u);
    const double pair[4] = {left[k], left[k + 1u], right[k], right[k + 1u]};
    if ((i > 0u) && tm_same(pair[0], pair[1], last[0], last[1]) && tm_same(pair[2], pair[3], last[2], last[3])) {
      continue;
    }
    if (i > 0u) {
      const double area = tm_quad_area(last, pair);
      if (!(area == area)) {
        return false;
      }
      most = tm_greatest(most, area);
      least = tm_least(least, area);
    }
    last[0] = pair[0];
    last[1] = pair[1];
    last[2] = pair[2];
    last[3] = pair[3];
  }
  return (least > 0.0) || (most < 0.0);
}

/** Whether a point lies in any quadrilateral between pairs but one. */
static bool tm_covered(const double *pairs, size_t n, size_t own, double x, double y) {
  for (size_t i = 0u; i < n; ++i) {
    const double *a = &pairs[4u * i];
    const double *b = &pairs[4u * (((i + 1u) < n) ? (i + 1u) : 0u)];
    const bool below = (a[1] > y) && (a[3] > y) && (b[1] > y) && (b[3] > y);
    const bool above = (a[1] < y) && (a[3] < y) && (b[1] < y) && (b[3] < y);
    if ((i != own) && !below && !above) {
      double q[8];
      const size_t count = tm_quad(a, b, q);
      if (tm_odd(q, count, x, y)) {
        return true;
      }
    }
  }
  return false;
}

/** Put the places where border segments of a figure of eight cross into `cuts`; TM_UNUSABLE where they do anything else. */
static tm_status tm_eight_cuts(const tm_context *c, const tm_shape *shape, size_t rights, tm_cut *cuts, size_t *count) {
  const size_t end = shape->first + shape->count;
  *count = 0u;
  for (size_t i = shape->first; i < end; ++i) {
    const tm_segment way_s = tm_segment_at(c, i);
    const tm_segment *s = &way_s;
    const double a[2] = {s->ax, s->ay};
    const double b[2] = {s->bx, s->by};
    const tm_box box = tm_box_of(&c->ends[i]);
    tm_walk walk = tm_walk_near(shape, i, &box);
    for (size_t j = tm_walk_after(c, &walk, i); j < end; j = tm_walk_after(c, &walk, j)) {
      const tm_segment way_o = tm_segment_at(c, j);
      const tm_segment *o = &way_o;
      const double p[2] = {o->ax, o->ay};
      const double q[2] = {o->bx, o->by};
      const bool together = (i < (shape->first + rights)) == (j < (shape->first + rights));
      const size_t ring = (j < (shape->first + rights)) ? rights : (shape->count - rights);
      if (together && (((j - i) == 1u) || ((j - i) == (ring - 1u)))) {
        const bool follows = (b[0] == p[0]) && (b[1] == p[1]);
        if (follows ? tm_folds_back(a, b, q) : tm_folds_back(p, q, b)) {
          return TM_UNUSABLE;
        }
      } else if (tm_meet(a, b, p, q)) {
        const double turn = (s->ex * o->ey) - (s->ey * o->ex);
        double t;
        if ((tm_orientation(a, b, p) == 0) || (tm_orientation(a, b, q) == 0) || (tm_orientation(p, q, a) == 0) ||
            (tm_orientation(p, q, b) == 0)) {
          return TM_UNUSABLE;
        }
        if ((turn == 0.0) || ((*count + 2u) > TM_MAX_CUTS)) {
          return TM_UNSUPPORTED;
        }
        t = tm_least(1.0, tm_greatest(0.0, (((p[0] - a[0]) * o->ey) - ((p[1] - a[1]) * o->ex)) / turn));
        for (size_t k = 0u; k < 2u; ++k) {
          const tm_segment *way = (k == 0u) ? s : o;
          tm_cut *cut = &cuts[*count];
          cut->side = ((k == 0u) ? i : j) - shape->first;
          cut->x = a[0] + (t * s->ex);
          cut->y = a[1] + (t * s->ey);
          cut->along = (way->ex * (cut->x - way->ax)) + (way->ey * (cut->y - way->ay));
          ++*count;
        }
      } else {
        /* apart */
      }
    }
  }
  return TM_OK;
}

/** Append the parts of one border segment, cut where others cross it, that lie in no quadrilateral but its own; false: no room. */
static bool tm_eight_side(tm_context *c, tm_shape *shape, const double *pairs, size_t n, size_t own, size_t side, const double *a,
                          const double *b, const tm_cut *cuts, size_t count) {
  double points[2u * (TM_MAX_CUTS + 2u)];
  double order[TM_MAX_CUTS];
  size_t kept = 0u;
  for (size_t i = 0u; i < count; ++i) {
    if (cuts[i].side == side) {
      size_t at = kept;
      while ((at > 0u) && (cuts[i].along < order[at - 1u])) {
        order[at] = order[at - 1u];
        points[2u * (at + 1u)] = points[2u * at];
        points[(2u * (at + 1u)) + 1u] = points[(2u * at) + 1u];
        --at;
      }
      order[at] = cuts[i].along;
      points[2u * (at + 1u)] = cuts[i].x;
      points[(2u * (at + 1u)) + 1u] = cuts[i].y;
      ++kept;
    }
  }
  points[0] = a[0];
  points[1] = a[1];
  points[2u * (kept + 1u)] = b[0];
  points[(2u * (kept + 1u)) + 1u] = b[1];
  kept = tm_distinct(points, kept + 2u, false, points);
  for (size_t i = 0u; (i + 1u) < kept; ++i) {
    const double *p = &points[2u * i];
    const double *q = &points[2u * (i + 1u)];
    if (!tm_covered(pairs, n, own, (p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0)) {
      if (shape->count >= (2u * TM_MAX_BORDER)) {
        return false;
      }
      tm_append(c, shape, p, q);
    }
  }
  return true;
}

/** Prepare a closed track whose borders cross: the union of the quadrilaterals between paired points (a figure of eight). */
static tm_status tm_make_eight(tm_context *c, tm_shape *shape, const double *left, const double *right, size_t given) {
  double *pairs = c->ring;
  tm_cut cuts[TM_MAX_CUTS];
  size_t count = 0u;
  size_t n = 0u;
  size_t rights = 0u;
  double most = -TM_INF;
  double least = TM_INF;
  tm_status status;
  for (size_t i = 0u; i < given; ++i) {
    const double *l = &left[2u * i];
    const double *r = &right[2u * i];
    double *last = (n > 0u) ? &pairs[4u * (n - 1u)] : pairs;
    if ((n == 0u) || !tm_same(l[0], l[1], last[0], last[1]) || !tm_same(r[0], r[1], last[2], last[3])) {
      pairs[4u * n] = l[0];
      pairs[(4u * n) + 1u] = l[1];
      pairs[(4u * n) + 2u] = r[0];
      pairs[(4u * n) + 3u] = r[1];
      ++n;
    }
  }
  while ((n > 1u) && tm_same(pairs[4u * (n - 1u)], pairs[(4u * (n - 1u)) + 1u], pairs[0], pairs[1]) &&
         tm_same(pairs[(4u * (n - 1u)) + 2u], pairs[(4u * (n - 1u)) + 3u], pairs[2], pairs[3])) {
    --n;
  }
  if (n < 3u) {
    return TM_UNUSABLE;
  }
  for (size_t i = 0u; i < n; ++i) {
    const double *a = &pairs[4u * i];
    const double *b = &pairs[4u * (((i + 1u) < n) ? (i + 1u) : 0u)];
    const double area = tm_quad_area(a, b);
    for (size_t k = 0u; k < 4u; k += 2u) {
      if (((a[k] != b[k]) || (a[k + 1u] != b[k + 1u])) && tm_same(a[k], a[k + 1u], b[k], b[k + 1u])) {
        return TM_UNUSABLE;
      }
    }
    if (!(area == area)) {
      return TM_UNUSABLE;
    }
    most = tm_greatest(most, area);
    least = tm_least(least, area);
  }
  if (!((most < 0.0) || (least > 0.0))) {
    return TM_UNUSABLE;
  }
  if (most < 0.0) { /* left is right */
    for (size_t i = 0u; i < (4u * n); i += 4u) {
      for (size_t k = i; k < (i + 2u); ++k) {
        const double x = pairs[k];
        pairs[k] = pairs[k + 2u];
        pairs[k + 2u] = x;
      }
    }
  }
  shape->count = 0u;
  for (size_t pass = 0u; pass < 4u; ++pass) { /* both borders whole, to find where they cross; then in parts */
    const size_t at = ((pass & 1u) == 0u) ? 2u : 0u;
    size_t side = (at == 0u) ? rights : 0u;
    if (pass == 2u) {
      tm_index(c, shape);
      status = tm_eight_cuts(c, shape, rights, cuts, &count);
      if (status != TM_OK) {
        return status;
      }
      shape->count = 0u;
    }
    for (size_t k = 0u; k < n; ++k) {
      const size_t i = (at == 2u) ? k : ((n - 1u) - k);
      const double *here = &pairs[(4u * i) + at];
      const double *there = &pairs[(4u * (((i + 1u) < n) ? (i + 1u) : 0u)) + at];
      const double *a = (at == 2u) ? here : there;
      const double *b = (at == 2u) ? there : here;
      if ((a[0] != b[0]) || (a[1] != b[1])) {
        if (pass < 2u) {
          tm_append(c, shape, a, b);
        } else if (!tm_eight_side(c, shape, pairs, n, i, side, a, b, cuts, count)) {
          return TM_UNSUPPORTED;
        } else {
          /* appended */
        }
        ++side;
      }
    }
    if (pass == 0u) {
      rights = shape->count;
    }
  }
  if (shape->count == 0u) {
    return TM_UNUSABLE;
  }
  tm_index(c, shape);
  shape->usable = true;
  return TM_OK;
}

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
