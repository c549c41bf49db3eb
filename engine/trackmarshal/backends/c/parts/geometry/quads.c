/* Quadrilaterals between the points of two borders, pair by pair, and a track that is the union of them, as its borders cross: prepared. */

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
