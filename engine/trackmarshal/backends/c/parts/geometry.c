/** Whether a number is a coordinate: finite, and not so large that doubles are coarse there. */
static bool tm_usable(double x) {
  return fabs(x) <= 1e9;
}

/** Whether a length and a width are those of a body. */
static bool tm_sized(double length, double width) {
  return tm_usable(length) && tm_usable(width) && (length >= 1e-6) && (width >= 1e-6);
}

/** The segment between two points. */
static tm_segment tm_between(double ax, double ay, double bx, double by) {
  tm_segment s;
  s.ax = ax;
  s.ay = ay;
  s.bx = bx;
  s.by = by;
  s.ex = bx - ax;
  s.ey = by - ay;
  s.square = (s.ex * s.ex) + (s.ey * s.ey);
  s.length = sqrt(s.square);
  return s;
}

/** A segment of a shape by its number: only its ends are kept. */
static tm_segment tm_segment_at(const tm_context *c, size_t i) {
  const tm_ends *ends = &c->ends[i];
  return tm_between(ends->ax, ends->ay, ends->bx, ends->by);
}

/** Whether two boxes meet. */
static bool tm_boxes_meet(const tm_box *a, const tm_box *b) {
  const int x = (a->x0 <= b->x1) & (b->x0 <= a->x1);
  const int y = (a->y0 <= b->y1) & (b->y0 <= a->y1);
  return (x & y) != 0;
}

/** A box grown by so much, and a little more: nothing nearer is missed for rounding. */
static tm_box tm_grown(const tm_box *box, double by) {
  const double more = by + 1e-5;
  tm_box result;
  result.x0 = box->x0 - more;
  result.x1 = box->x1 + more;
  result.y0 = box->y0 - more;
  result.y1 = box->y1 + more;
  return result;
}

/** A number that is not more than this one, in short. */
static float tm_short_below(double x) {
  return (float)(x - ((fabs(x) * 2.4e-7) + 1e-6));
}

/** A number that is not less than this one, in short. */
static float tm_short_above(double x) {
  return (float)(x + ((fabs(x) * 2.4e-7) + 1e-6));
}

/** Look for what is near to this box from now on; what was found already stays. */
static void tm_walk_box(tm_walk *walk, const tm_box *near) {
  walk->near = *near;
  walk->x0 = tm_short_below(near->x0);
  walk->y0 = tm_short_below(near->y0);
  walk->x1 = tm_short_above(near->x1);
  walk->y1 = tm_short_above(near->y1);
}

/** A walk over the blocks of eight segments of a shape whose boxes meet a box, from about the segment `from` on. */
static tm_walk tm_walk_near(const tm_shape *shape, size_t from, const tm_box *near) {
  tm_walk walk;
  tm_walk_box(&walk, near);
  walk.end = shape->first + shape->count;
  walk.block = walk.end;
  walk.part = from / 512u;
  walk.group = 0u;
  walk.groups = 0u;
  walk.blocks = 0u;
  return walk;
}

/** Which of eight boxes meet the box of a walk: a bit each. */
static unsigned tm_boxes_near(const tm_boxes *boxes, const tm_walk *walk) {
  static const int bit[8] = {1, 2, 4, 8, 16, 32, 64, 128};
  int found = 0;
  for (size_t k = 0u; k < 8u; ++k) {
    const int x = (boxes->x0[k] <= walk->x1) & (walk->x0 <= boxes->x1[k]);
    const int y = (boxes->y0[k] <= walk->y1) & (walk->y0 <= boxes->y1[k]);
    found |= ((x & y) != 0) ? bit[k] : 0;
  }
  return (unsigned)found;
}

/** The place of the lowest of eight bits, one of which is set. */
static size_t tm_lowest(unsigned bits) {
  static const unsigned char lowest[16] = {4, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0};
  const size_t low = lowest[bits & 15u];
  return (low < 4u) ? low : (4u + lowest[(bits >> 4u) & 15u]);
}

/** Where the next block of a walk begins; at its end, where the shape ends. */
static size_t tm_walk_next(const tm_context *c, tm_walk *walk) {
  while (walk->blocks == 0u) {
    while (walk->groups == 0u) {
      if ((walk->part * 512u) >= walk->end) {
        return walk->end;
      }
      if (tm_boxes_meet(&c->part_box[walk->part], &walk->near)) {
        walk->groups = tm_boxes_near(&c->groups[walk->part], walk);
      }
      ++walk->part;
    }
    walk->group = ((walk->part - 1u) * 8u) + tm_lowest(walk->groups);
    walk->groups &= walk->groups - 1u;
    walk->blocks = tm_boxes_near(&c->blocks[walk->group], walk);
  }
  const size_t block = (walk->group * 8u) + tm_lowest(walk->blocks);
  walk->blocks &= walk->blocks - 1u;
  return block * 8u;
}

/** Where the block of eight segments ends that a segment is in. */
static size_t tm_block_end(size_t i, size_t end) {
  const size_t stop = (i | 7u) + 1u;
  return (stop < end) ? stop : end;
}

/** A strip to look along for segments: a box along (ahead, aside) that is seen from a point. */
static tm_strip tm_strip_of(const tm_frame *frame, double ox, double oy) {
  tm_strip strip;
  strip.ox = ox;
  strip.oy = oy;
  strip.ahead = (float)frame->ahead;
  strip.aside = (float)frame->aside;
  strip.u0 = (float)frame->u0;
  strip.u1 = (float)frame->u1;
  strip.v0 = (float)frame->v0;
  strip.v1 = (float)frame->v1;
  strip.size = (fabs(frame->u0) + fabs(frame->u1)) + (fabs(frame->v0) + fabs(frame->v1));
  return strip;
}

/** Which of eight boxes along a strip may lie within `reach` of a box in it, (u0, u1, v0, v1): a bit each. NaN is near. */
static inline unsigned tm_strip_bits(const float *u0, const float *u1, const float *v0, const float *v1, const float *box, float reach) {
  static const int bit[8] = {1, 2, 4, 8, 16, 32, 64, 128};
  const float limit = reach * reach;
  int found = 0;
  for (size_t k = 0u; k < 8u; ++k) {
    const float front = u0[k] - box[1];
    const float rear = box[0] - u1[k];
    const float left = v0[k] - box[3];
    const float right = box[2] - v1[k];
    const float u = (front > rear) ? front : rear;
    const float v = (left > right) ? left : right;
    const float du = (u > 0.0f) ? u : 0.0f;
    const float dv = (v > 0.0f) ? v : 0.0f;
    found |= (((du * du) + (dv * dv)) > limit) ? 0 : bit[k];
  }
  return (unsigned)found;
}

/** Where a strip is for the block of segments from `i` on, and how wrong short numbers of it may be, and a little more [m]. */
static inline tm_strip_shift tm_strip_before(const tm_context *c, size_t i, const tm_strip *strip, double reach) {
  const tm_boxes *groups = &c->groups[i / 512u];
  const size_t group = (i / 64u) & 7u;
  const double dx = (double)groups->x0[group] - strip->ox;
  const double dy = (double)groups->y0[group] - strip->oy;
  const double extent = (double)((groups->x1[group] - groups->x0[group]) + (groups->y1[group] - groups->y0[group])) +
                        (fabs(dx) + fabs(dy));
  const tm_strip_shift shift = {(float)dx, (float)dy, 1e-4 + (1e-6 * ((extent + strip->size) + reach))};
  return shift;
}

/** Which of the block of segments from `i` on may lie within `reach` of a strip: a bit each. */
static unsigned tm_strip_near(const tm_context *c, size_t i, const tm_strip *strip, double reach) {
  const float *x = c->outline[i / 8u].x;
  const float *y = c->outline[i / 8u].y;
  const tm_strip_shift shift = tm_strip_before(c, i, strip, reach);
  const float box[4] = {strip->u0, strip->u1, strip->v0, strip->v1};
  float u0[8];
  float u1[8];
  float v0[8];
  float v1[8];
  for (size_t k = 0u; k < 8u; ++k) { /* what two segments share is computed for both: eight at once take no longer */
    const float ua = (strip->ahead * (x[k] + shift.dx)) + (strip->aside * (y[k] + shift.dy));
    const float va = (strip->ahead * (y[k] + shift.dy)) - (strip->aside * (x[k] + shift.dx));
    const float ub = (strip->ahead * (x[k + 1u] + shift.dx)) + (strip->aside * (y[k + 1u] + shift.dy));
    const float vb = (strip->ahead * (y[k + 1u] + shift.dy)) - (strip->aside * (x[k + 1u] + shift.dx));
    u0[k] = (ua < ub) ? ua : ub;
    u1[k] = (ua < ub) ? ub : ua;
    v0[k] = (va < vb) ? va : vb;
    v1[k] = (va < vb) ? vb : va;
  }
  return tm_strip_bits(u0, u1, v0, v1, box, (float)(reach + shift.slack));
}

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

/** The four corners of the box at a point, heading along (ahead, aside), seen from (ox, oy), counter-clockwise from the front left. */
static void tm_footprint(double px, double py, double ahead, double aside, double length, double width, double ox, double oy,
                         double *x, double *y) {
  const double fx = (0.5 * length) * ahead;
  const double fy = (0.5 * length) * aside;
  const double lx = -((0.5 * width) * aside);
  const double ly = (0.5 * width) * ahead;
  const double cx = px - ox;
  const double cy = py - oy;
  x[0] = cx + (fx + lx);
  y[0] = cy + (fy + ly);
  x[1] = cx - (fx - lx);
  y[1] = cy - (fy - ly);
  x[2] = cx - (fx + lx);
  y[2] = cy - (fy + ly);
  x[3] = cx + (fx - lx);
  y[3] = cy + (fy - ly);
}

/** Append a point to a half of a convex hull, and drop those that it makes superfluous; returns the new count. */
static size_t tm_hull_point(tm_hull *hull, size_t first, size_t count, double x, double y) {
  while (count >= (first + 2u)) {
    const double ax = hull->x[count - 2u];
    const double ay = hull->y[count - 2u];
    const double ex = hull->x[count - 1u] - ax;
    const double ey = hull->y[count - 1u] - ay;
    if (((ex * (y - ay)) - (ey * (x - ax))) > 0.0) {
      break;
    }
    --count;
  }
  hull->x[count] = x;
  hull->y[count] = y;
  return count + 1u;
}

/** The convex hull of eight points, counter-clockwise, with its sides. */
static void tm_convex_hull(const double *px, const double *py, tm_hull *hull) {
  double x[8] = {0.0};
  double y[8] = {0.0};
  size_t n = 0u;
  size_t count = 0u;
  for (size_t i = 0u; i < 8u; ++i) { /* sorted; of equal ones, the first stays the first */
    size_t at = i;
    while ((at > 0u) && ((px[i] < x[at - 1u]) || ((px[i] == x[at - 1u]) && (py[i] < y[at - 1u])))) {
      x[at] = x[at - 1u];
      y[at] = y[at - 1u];
      --at;
    }
    x[at] = px[i];
    y[at] = py[i];
  }
  for (size_t i = 0u; i < 8u; ++i) {
    if ((n == 0u) || (x[i] != x[n - 1u]) || (y[i] != y[n - 1u])) {
      x[n] = x[i];
      y[n] = y[i];
      ++n;
    }
  }
  for (size_t i = 0u; i < n; ++i) {
    count = tm_hull_point(hull, 0u, count, x[i], y[i]);
  }
  --count;
  const size_t first = count;
  for (size_t i = n; i > 0u; --i) {
    count = tm_hull_point(hull, first, count, x[i - 1u], y[i - 1u]);
  }
  --count;
  hull->count = count;
  for (size_t i = 0u; i < count; ++i) {
    const size_t next = ((i + 1u) < count) ? (i + 1u) : 0u;
    hull->gx[i] = hull->x[next] - hull->x[i];
    hull->gy[i] = hull->y[next] - hull->y[i];
    hull->square[i] = (hull->gx[i] * hull->gx[i]) + (hull->gy[i] * hull->gy[i]);
    hull->length[i] = sqrt(hull->square[i]);
  }
}

/** How far a point lies inside a convex polygon: its distance from the nearest side's line, negative outside. */
static double tm_depth(const tm_hull *hull, double x, double y) {
  double depth = TM_INF;
  for (size_t i = 0u; i < hull->count; ++i) {
    const double side = (hull->gx[i] * (y - hull->y[i])) - (hull->gy[i] * (x - hull->x[i]));
    depth = tm_least(depth, side / hull->length[i]);
  }
  return depth;
}

/** The distance of a point from the outline of a convex polygon. */
static double tm_hull_distance(const tm_hull *hull, double x, double y) {
  double best = TM_INF;
  for (size_t i = 0u; i < hull->count; ++i) {
    const size_t next = ((i + 1u) < hull->count) ? (i + 1u) : 0u;
    const double rx = x - hull->x[i];
    const double ry = y - hull->y[i];
    const double product = (hull->gx[i] * rx) + (hull->gy[i] * ry);
    double reach;
    if ((0.0 < product) && (product < hull->square[i])) {
      reach = fabs((hull->gx[i] * ry) - (hull->gy[i] * rx)) / hull->length[i];
    } else {
      const double sx = x - hull->x[next];
      const double sy = y - hull->y[next];
      const double start = (rx * rx) + (ry * ry);
      const double end = (sx * sx) + (sy * sy);
      reach = sqrt((end < start) ? end : start);
    }
    best = tm_least(best, reach);
  }
  return best;
}

/** Whether a segment, seen from (ox, oy), has a point strictly inside a convex polygon. */
static bool tm_enters(const tm_segment *s, double ox, double oy, const tm_hull *hull) {
  const double ax = s->ax - ox;
  const double ay = s->ay - oy;
  const double bx = s->bx - ox;
  const double by = s->by - oy;
  double low = TM_INF;
  double high = -TM_INF;
  for (size_t i = 0u; i < hull->count; ++i) {
    const double turn = (s->ex * (hull->y[i] - ay)) - (s->ey * (hull->x[i] - ax));
    low = tm_least(low, turn);
    high = tm_greatest(high, turn);
  }
  if (!((low < 0.0) && (0.0 < high))) {
    return false;
  }
  for (size_t i = 0u; i < hull->count; ++i) {
    const double at_start = (hull->gx[i] * (ay - hull->y[i])) - (hull->gy[i] * (ax - hull->x[i]));
    const double at_end = (hull->gx[i] * (by - hull->y[i])) - (hull->gy[i] * (bx - hull->x[i]));
    if ((at_start <= 0.0) && (at_end <= 0.0)) {
      return false;
    }
  }
  return true;
}

/** How deep in a convex polygon the middle of the part of a segment lies that is inside it. */
static double tm_middle_depth(const tm_segment *s, double ox, double oy, const tm_hull *hull) {
  const double ax = s->ax - ox;
  const double ay = s->ay - oy;
  const double bx = s->bx - ox;
  const double by = s->by - oy;
  double first = 0.0;
  double last = 1.0;
  double t;
  for (size_t i = 0u; i < hull->count; ++i) {
    const double start = (hull->gx[i] * (ay - hull->y[i])) - (hull->gy[i] * (ax - hull->x[i]));
    const double end = (hull->gx[i] * (by - hull->y[i])) - (hull->gy[i] * (bx - hull->x[i]));
    if (start < end) {
      first = tm_greatest(first, start / (start - end));
    } else if (start > end) {
      last = tm_least(last, start / (start - end));
    }
  }
  t = (first + last) / 2.0;
  return tm_depth(hull, ax + (t * s->ex), ay + (t * s->ey));
}

/** The squared distance of a segment, seen from (ox, oy), from a box along (ahead, aside), a little less than it is. */
static inline double tm_frame_apart(const tm_frame *frame, const tm_segment *s, double ox, double oy) {
  const double slack = 1e-5;
  const double ax = s->ax - ox;
  const double ay = s->ay - oy;
  const double bx = s->bx - ox;
  const double by = s->by - oy;
  const double ua = (frame->ahead * ax) + (frame->aside * ay);
  const double ub = (frame->ahead * bx) + (frame->aside * by);
  const double va = (frame->ahead * ay) - (frame->aside * ax);
  const double vb = (frame->ahead * by) - (frame->aside * bx);
  const double front = (((ua < ub) ? ua : ub) - frame->u1) - slack;
  const double rear = (frame->u0 - ((ua < ub) ? ub : ua)) - slack;
  const double left = (((va < vb) ? va : vb) - frame->v1) - slack;
  const double right = (frame->v0 - ((va < vb) ? vb : va)) - slack;
  const double u = (front > rear) ? front : rear;
  const double v = (left > right) ? left : right;
  const double du = (u > 0.0) ? u : 0.0;
  const double dv = (v > 0.0) ? v : 0.0;
  return (du * du) + (dv * dv);
}

/** The same of a point at (u, v) along the box, seen from where it is. */
static inline double tm_point_apart(const tm_frame *frame, double u, double v) {
  const double slack = 1e-5;
  const double du = tm_greatest(tm_greatest(u - frame->u1, frame->u0 - u) - slack, 0.0);
  const double dv = tm_greatest(tm_greatest(v - frame->v1, frame->v0 - v) - slack, 0.0);
  return (du * du) + (dv * dv);
}

/** Make the corners of a sweep, unless they are made. */
static void tm_sweep_corners(tm_sweep *sweep) {
  const tm_curve *curve = sweep->curve;
  const size_t j = sweep->piece;
  const size_t next = j + 1u;
  if (!sweep->placed) {
    tm_footprint(sweep->ox, sweep->oy, curve->ahead[j], curve->aside[j], sweep->length, sweep->width, sweep->ox, sweep->oy,
                 &sweep->x[0], &sweep->y[0]);
    tm_footprint(curve->x[next], curve->y[next], curve->ahead[next], curve->aside[next], sweep->length, sweep->width, sweep->ox,
                 sweep->oy, &sweep->x[4], &sweep->y[4]);
    sweep->placed = true;
  }
}

/** Make the hull of a sweep, unless it is made. */
static void tm_sweep_hull(tm_sweep *sweep) {
  tm_sweep_corners(sweep);
  if (!sweep->built) {
    tm_convex_hull(sweep->x, sweep->y, &sweep->hull);
    sweep->built = true;
  }
}

/** The line along a side of a sweep, from the rear of the first pose to the front of the second one, and by how far both footprints reach
   beyond it; made once for all that lies on that side. */
static const tm_side *tm_sweep_side(tm_sweep *sweep, bool left) {
  tm_side *side = &sweep->side[left ? 0u : 1u];
  if (!side->made) {
    const tm_curve *curve = sweep->curve;
    const size_t j = sweep->piece;
    const size_t next = j + 1u;
    const tm_frame *frame = &sweep->frame;
    const double sign = left ? 1.0 : -1.0;
    const double half_length = 0.5 * sweep->length;
    const double half_width = (0.5 * sweep->width) * sign;
    const double rear_x = -((half_length * curve->ahead[j]) + (half_width * curve->aside[j]));
    const double rear_y = (half_width * curve->ahead[j]) - (half_length * curve->aside[j]);
    const double front_x = (curve->x[next] - sweep->ox) + ((half_length * frame->ahead) - (half_width * frame->aside));
    const double front_y = (curve->y[next] - sweep->oy) + ((half_length * frame->aside) + (half_width * frame->ahead));
    const double ex = sign * (front_x - rear_x);
    const double ey = sign * (front_y - rear_y);
    const double forward = sweep->length * ((ex * curve->aside[j]) - (ey * curve->ahead[j]));
    const double inward = -((2.0 * half_width) * ((ex * curve->ahead[j]) + (ey * curve->aside[j])));
    const double backward = sweep->length * ((ey * frame->ahead) - (ex * frame->aside));
    const double inward_next = -((2.0 * half_width) * ((ex * frame->ahead) + (ey * frame->aside)));
    const double beyond = tm_greatest(tm_greatest(forward, 0.0) + tm_greatest(inward, 0.0),
                                      tm_greatest(backward, 0.0) + tm_greatest(inward_next, 0.0));
    side->rear_x = rear_x;
    side->rear_y = rear_y;
    side->ex = ex;
    side->ey = ey;
    side->beyond = beyond + ((fabs(ex) + fabs(ey)) * 1e-5);
    side->square = (ex * ex) + (ey * ey);
    side->made = true;
  }
  return side;
}

/** How far a point, seen from the origin of a sweep, is off the line along a side of it and all that reaches beyond: a little less than that, times
   the line's length. */
static inline double tm_side_off(const tm_side *side, double x, double y) {
  return ((side->ex * (y - side->rear_y)) - (side->ey * (x - side->rear_x))) - side->beyond;
}

/** Whether what is so far off the line along a side is farther from the sweep than `best`. */
static inline bool tm_side_far(const tm_side *side, double off, double best) {
  return (off > 0.0) && ((off * off) > (side->square * (best * best)));
}

/** Whether a point beside a sweep is farther from it than `best`, going by the side of the hull that it should be beside, between two corners one
   after the other, and by the corner that is farthest out from there. It is seen from the sweep's origin, and `u` along its frame. */
static bool tm_corner_far(const tm_sweep *sweep, bool left, double u, double x, double y, double best) {
  static const size_t corner[2][4] = {{1u, 0u, 5u, 4u}, {2u, 3u, 6u, 7u}}; /* rear and front of both poses, left and right */
  const size_t *at = corner[left ? 0u : 1u];
  const tm_frame *frame = &sweep->frame;
  const double front = (frame->ahead * sweep->x[at[1]]) + (frame->aside * sweep->y[at[1]]);
  const double rear = (frame->ahead * sweep->x[at[2]]) + (frame->aside * sweep->y[at[2]]);
  const size_t one = at[(front < rear) ? 1u : 2u];
  const size_t other = at[(front < rear) ? 2u : 1u];
  const bool before = u < tm_least(front, rear);
  const bool after = u > tm_greatest(front, rear);
  const size_t from = before ? at[0] : (after ? other : one);
  const size_t to = before ? one : (after ? at[3] : other);
  const double ex = sweep->x[to] - sweep->x[from];
  const double ey = sweep->y[to] - sweep->y[from];
  const double nx = left ? -ey : ey;
  const double ny = left ? ex : -ex;
  double most = -TM_INF;
  for (size_t i = 0u; i < 8u; ++i) {
    most = tm_greatest(most, (nx * sweep->x[i]) + (ny * sweep->y[i]));
  }
  const double off = ((nx * x) + (ny * y)) - (most + (1e-5 * (fabs(ex) + fabs(ey))));
  return (off > 0.0) && ((off * off) > (((ex * ex) + (ey * ey)) * (best * best)));
}

/** The distance of some corners of a sweep, seen from its origin, from one border segment; where that is more than the nearest so far, something
   more than that. */
static inline double tm_corners_gap(const tm_segment *s, const double *x, const double *y, size_t count, double ax, double ay, double bx,
                                    double by) {
  double across[8];
  double ends[8];
  double line = TM_INF;
  double end = TM_INF;
  for (size_t i = 0u; i < count; ++i) {
    const double rx = x[i] - ax;
    const double ry = y[i] - ay;
    const double product = (s->ex * rx) + (s->ey * ry);
    const bool beside = ((0.0 < product) & (product < s->square)) != 0;
    const double sx = x[i] - bx;
    const double sy = y[i] - by;
    across[i] = beside ? fabs((s->ex * ry) - (s->ey * rx)) : TM_INF;
    ends[i] = beside ? TM_INF : tm_least((rx * rx) + (ry * ry), (sx * sx) + (sy * sy));
  }
  for (size_t i = 0u; i < count; ++i) {
    line = tm_least(line, across[i]);
    end = tm_least(end, ends[i]);
  }
  return tm_least(line / s->length, sqrt(end));
}

/** The distance of a sweep (its eight corners, its sides) from one border segment that does not enter it; where it is more
   than the nearest so far, something more than that. `side`: the one that it lies on; `off`: how far its start is off that. */
static double tm_sweep_gap(tm_sweep *sweep, const tm_segment *s, bool left, const tm_side *side, double off) {
  const double ax = s->ax - sweep->ox;
  const double ay = s->ay - sweep->oy;
  const double bx = s->bx - sweep->ox;
  const double by = s->by - sweep->oy;
  const tm_frame *frame = &sweep->frame;
  const double va = (frame->ahead * ay) - (frame->aside * ax);
  const double vb = (frame->ahead * by) - (frame->aside * bx);
  const double beyond = left ? (tm_least(va, vb) - sweep->right_most) : (sweep->left_least - tm_greatest(va, vb));
  double reach;
  if ((beyond - 1e-5) > sweep->best) { /* the corners of the other side are too far away */
    const size_t k = left ? 0u : 2u;
    const double x[4] = {sweep->x[k], sweep->x[k + 1u], sweep->x[k + 4u], sweep->x[k + 5u]};
    const double y[4] = {sweep->y[k], sweep->y[k + 1u], sweep->y[k + 4u], sweep->y[k + 5u]};
    reach = tm_corners_gap(s, x, y, 4u, ax, ay, bx, by);
  } else {
    reach = tm_corners_gap(s, sweep->x, sweep->y, 8u, ax, ay, bx, by);
  }
  const double best = tm_least(sweep->best, reach);
  const double ua = (frame->ahead * ax) + (frame->aside * ay);
  if (!tm_side_far(side, off, best) && (tm_point_apart(frame, ua, va) <= (best * best)) && !tm_corner_far(sweep, left, ua, ax, ay, best)) {
    tm_sweep_hull(sweep);
    reach = tm_least(reach, tm_hull_distance(&sweep->hull, ax, ay));
  }
  return reach;
}

/** The negative margin of a hull that is not inside: how far out its corners are, how deep in it the border is. */
static double tm_outside(tm_context *c, tm_shape *shape, double ox, double oy, const double *x, const double *y,
                         const tm_hull *hull, const tm_box *box) {
  const size_t end = shape->first + shape->count;
  const tm_box near = tm_grown(box, 0.0);
  double worst = 0.0;
  for (size_t i = 0u; i < 8u; ++i) {
    size_t which = 0u;
    const double reach = tm_nearest(c, shape, ox, oy, x[i], y[i], &which);
    if ((reach > 0.0) && !tm_holds(c, shape, x[i] + ox, y[i] + oy)) {
      worst = tm_greatest(worst, reach);
    }
  }
  for (size_t pass = 0u; (pass < 2u) && ((pass == 0u) || (worst == 0.0)); ++pass) {
    tm_walk walk = tm_walk_near(shape, shape->first, &near);
    for (size_t i = tm_walk_next(c, &walk); i < end; i = tm_walk_next(c, &walk)) {
      const size_t stop = tm_block_end(i, end);
      for (size_t k = i; k < stop; ++k) {
        const tm_segment s = tm_segment_at(c, k);
        if (pass == 0u) {
          worst = tm_greatest(worst, tm_depth(hull, s.ax - ox, s.ay - oy));
        } else if (tm_enters(&s, ox, oy, hull)) {
          worst = tm_greatest(worst, tm_middle_depth(&s, ox, oy, hull));
        } else {
          /* beside it */
        }
      }
    }
  }
  return tm_least(-2.2250738585072014e-308, -worst);
}

/** The box along the axes around eight points seen from (ox, oy); not seen from there. */
static tm_box tm_box_around(const double *x, const double *y, double ox, double oy) {
  tm_box box = {TM_INF, TM_INF, -TM_INF, -TM_INF};
  for (size_t i = 0u; i < 8u; ++i) {
    box.x0 = tm_least(box.x0, x[i]);
    box.x1 = tm_greatest(box.x1, x[i]);
    box.y0 = tm_least(box.y0, y[i]);
    box.y1 = tm_greatest(box.y1, y[i]);
  }
  box.x0 += ox;
  box.x1 += ox;
  box.y0 += oy;
  box.y1 += oy;
  return box;
}

/** The cosines and sines of two headings: the last pose of one sweep is the first one of the next. */
static void tm_units(tm_shape *shape, double heading0, double heading1, double *ahead, double *aside) {
  if (shape->known && (heading0 == shape->heading)) {
    ahead[0] = shape->ahead;
    aside[0] = shape->aside;
  } else {
    ahead[0] = cos(heading0);
    aside[0] = sin(heading0);
  }
  if (!shape->known || !(heading1 == shape->heading)) {
    shape->ahead = cos(heading1);
    shape->aside = sin(heading1);
  }
  shape->heading = heading1;
  shape->known = true;
  ahead[1] = shape->ahead;
  aside[1] = shape->aside;
}

/** What is swept between the poses `j` and `j + 1` of a curve: where it is seen from, and the box around it along the second pose. */
static void tm_sweep_piece(const tm_curve *curve, size_t j, double length, double width, double bound, tm_sweep *sweep) {
  const size_t next = j + 1u;
  tm_frame *frame = &sweep->frame;
  const double ahead = curve->ahead[next];
  const double aside = curve->aside[next];
  const double dx = curve->x[next] - curve->x[j];
  const double dy = curve->y[next] - curve->y[j];
  const double u = (ahead * dx) + (aside * dy);
  const double v = (ahead * dy) - (aside * dx);
  const double turned = (ahead * curve->ahead[j]) + (aside * curve->aside[j]);
  const double cosine = fabs(turned);
  const double sine = fabs((ahead * curve->aside[j]) - (aside * curve->ahead[j]));
  const double along = 0.5 * ((length * cosine) + (width * sine));
  const double across = 0.5 * ((width * cosine) + (length * sine));
  frame->ahead = ahead;
  frame->aside = aside;
  frame->u0 = tm_least(-along, u - (0.5 * length));
  frame->u1 = tm_greatest(along, u + (0.5 * length));
  frame->v0 = tm_least(-across, v - (0.5 * width));
  frame->v1 = tm_greatest(across, v + (0.5 * width));
  /* Poses that are turned by a right angle and more have no sides. */
  const double inner = (turned > 0.0) ? (0.5 * ((length * sine) - (width * cosine))) : TM_INF;
  sweep->right_most = tm_greatest(inner, v - (0.5 * width));
  sweep->left_least = tm_least(-inner, v + (0.5 * width));
  sweep->side[0].made = false;
  sweep->side[1].made = false;
  sweep->curve = curve;
  sweep->piece = j;
  sweep->length = length;
  sweep->width = width;
  sweep->ox = curve->x[j];
  sweep->oy = curve->y[j];
  sweep->best = (bound > 0.0) ? bound : 0.0;
  sweep->placed = false;
  sweep->built = false;
  sweep->entered = false;
}

/** The straight way between two poses, as a curve of one piece. */
static void tm_straight(tm_shape *shape, double x0, double y0, double heading0, double x1, double y1, double heading1,
                        tm_curve *curve) {
  curve->x[0] = x0;
  curve->y[0] = y0;
  curve->x[1] = x1;
  curve->y[1] = y1;
  tm_units(shape, heading0, heading1, curve->ahead, curve->aside);
  curve->count = 1u;
  curve->more = 0.0;
}

/** Look at a border segment; whether it is nearer to the sweep than all that were looked at. */
static bool tm_sweep_nearer(const tm_context *c, size_t i, tm_sweep *sweep) {
  const tm_segment s = tm_segment_at(c, i);
  const double apart = tm_frame_apart(&sweep->frame, &s, sweep->ox, sweep->oy);
  double reach;
  if (!(apart <= (sweep->best * sweep->best))) {
    return false;
  }
  if (apart == 0.0) {
    tm_sweep_hull(sweep);
    if (tm_enters(&s, sweep->ox, sweep->oy, &sweep->hull)) {
      sweep->entered = true;
      return false;
    }
  }
  const double ax = s.ax - sweep->ox;
  const double ay = s.ay - sweep->oy;
  const bool left = ((sweep->frame.ahead * ay) - (sweep->frame.aside * ax)) > (0.5 * (sweep->frame.v0 + sweep->frame.v1));
  const tm_side *side = tm_sweep_side(sweep, left);
  const double start = tm_side_off(side, ax, ay);
  const double off = tm_least(start, tm_side_off(side, s.bx - sweep->ox, s.by - sweep->oy));
  if (tm_side_far(side, off, sweep->best)) {
    return false;
  }
  tm_sweep_corners(sweep);
  reach = tm_sweep_gap(sweep, &s, left, side, start);
  if (reach < sweep->best) {
    sweep->best = reach;
    return true;
  }
  return false;
}

/** The signed margin of a sweep for which all of the border that may matter was looked at. `from_inside`: its first pose is well inside;
   then so is all of it where nothing of the border lies in it. */
static double tm_sweep_margin(tm_context *c, tm_shape *shape, tm_sweep *sweep, bool from_inside, double x, double y) {
  shape->inside = false;
  if (sweep->entered || !((from_inside && (sweep->best > 1e-3)) || tm_holds(c, shape, x, y))) {
    tm_sweep_hull(sweep);
    const tm_box box = tm_box_around(sweep->x, sweep->y, sweep->ox, sweep->oy);
    return tm_outside(c, shape, sweep->ox, sweep->oy, sweep->x, sweep->y, &sweep->hull, &box);
  }
  shape->inside = sweep->best > 1e-3;
  return sweep->best;
}

/** The signed margin [m] of a piece of a curve inside a region.
   Margins above `bound` need not be exact: the caller takes the least of many, and has found `bound` already. */
static double tm_piece_inside(tm_context *c, tm_shape *shape, const tm_curve *curve, size_t j, double length, double width,
                              double bound) {
  tm_sweep sweep;
  const double x0 = curve->x[j];
  const double y0 = curve->y[j];
  const double x1 = curve->x[j + 1u];
  const double y1 = curve->y[j + 1u];
  const bool from_inside = shape->inside && (x0 == shape->x) && (y0 == shape->y);
  shape->x = x1;
  shape->y = y1;
  tm_sweep_piece(curve, j, length, width, bound, &sweep);
  tm_sweep_corners(&sweep);
  const size_t end = shape->first + shape->count;
  const size_t likely = shape->first + ((shape->hint < shape->count) ? shape->hint : 0u);
  /* What was nearest last time is near this time, and leaves little to look at. */
  (void)tm_sweep_nearer(c, likely, &sweep);
  const tm_strip strip = tm_strip_of(&sweep.frame, x0, y0);
  const tm_box box = tm_box_around(sweep.x, sweep.y, x0, y0);
  tm_box near = tm_grown(&box, sweep.best);
  tm_walk walk = tm_walk_near(shape, shape->first, &near);
  for (size_t i = tm_walk_next(c, &walk); (i < end) && !sweep.entered; i = tm_walk_next(c, &walk)) {
    const size_t stop = tm_block_end(i, end);
    unsigned looked = tm_strip_near(c, i, &strip, sweep.best);
    for (size_t k = i; (looked != 0u) && (k < stop) && !sweep.entered; ++k) {
      if (((looked & 1u) != 0u) && (k != likely) && tm_sweep_nearer(c, k, &sweep)) {
        near = tm_grown(&box, sweep.best);
        tm_walk_box(&walk, &near);
        shape->hint = k - shape->first;
      }
      looked >>= 1u;
    }
  }
  return tm_sweep_margin(c, shape, &sweep, from_inside, (x0 + x1) / 2.0, (y0 + y1) / 2.0);
}

/** The same of all pieces of a curve. */
static double tm_curve_inside(tm_context *c, tm_shape *shape, const tm_curve *curve, double length, double width, double bound) {
  double least = tm_curve_limit(curve, bound);
  for (size_t j = 0u; j < curve->count; ++j) {
    least = tm_least(least, tm_piece_inside(c, shape, curve, j, length, width, least));
  }
  return least - curve->more;
}

/** The signed margin [m] of what a vehicle sweeps straight between two poses inside a region; NaN for what is none. `bound`: as above. */
static double tm_swept_inside(tm_context *c, tm_shape *shape, double x0, double y0, double heading0, double x1, double y1,
                              double heading1, double length, double width, double bound) {
  tm_curve curve;
  if (!shape->usable || !tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) ||
      !tm_usable(heading1) || !tm_sized(length, width)) {
    return TM_NAN;
  }
  tm_straight(shape, x0, y0, heading0, x1, y1, heading1, &curve);
  return tm_piece_inside(c, shape, &curve, 0u, length, width, bound);
}

/** The same along a curve, of these curvatures at both poses [1/m]. */
static double tm_curved_inside(tm_context *c, tm_shape *shape, double x0, double y0, double heading0, double x1, double y1,
                               double heading1, double length, double width, double kappa0, double kappa1, double bound) {
  tm_curve curve;
  if (!shape->usable || !tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) ||
      !tm_usable(heading1) || !tm_usable(kappa0) || !tm_usable(kappa1) || !tm_sized(length, width)) {
    return TM_NAN;
  }
  tm_straight(shape, x0, y0, heading0, x1, y1, heading1, &curve);
  tm_curve_of(kappa0, kappa1, length, width, &curve);
  return tm_curve_inside(c, shape, &curve, length, width, bound);
}

/** Where a stretch ends that begins with the sweep `first` from the pose `from`: not far away, and not turned by much. */
static size_t tm_stretch_end(const double *x, const double *y, const double *heading, size_t n, size_t from, size_t first,
                             double length) {
  const double far = 8.0 * length;
  size_t stop = first + 1u;
  while ((stop < n) && ((stop - first) < TM_STRETCH)) {
    const double dx = x[stop] - x[from];
    const double dy = y[stop] - y[from];
    if ((((dx * dx) + (dy * dy)) > (far * far)) || (fabs(heading[stop] - heading[from]) > 0.15)) {
      break;
    }
    ++stop;
  }
  return stop;
}

/** About the cosine of an angle: up to 0.4 rad good to 1e-5, up to 0.25 rad to 1e-6. */
static double tm_about_cosine(double angle) {
  const double square = angle * angle;
  return 1.0 - (square * (0.5 - (square * (1.0 / 24.0))));
}

/** About the sine of an angle, as good as that. */
static double tm_about_sine(double angle) {
  const double square = angle * angle;
  return angle * (1.0 - ((square * (1.0 / 6.0)) * (1.0 - (square * 0.05))));
}

/** Poses seen along the one in their middle, and the box of them all. */
static void tm_stretch_of(tm_stretch *stretch, const double *x, const double *y, const double *heading, size_t count, double length,
                          double width) {
  const size_t middle = count / 2u;
  tm_frame *all = &stretch->frame;
  const double ox = x[middle];
  const double oy = y[middle];
  const double ahead = cos(heading[middle]);
  const double aside = sin(heading[middle]);
  for (size_t from = 0u; from < count; from += 4u) { /* four at once take no longer */
    double dx[4];
    double dy[4];
    double turned[4];
    for (size_t n = 0u; n < 4u; ++n) {
      const size_t i = ((from + n) < count) ? (from + n) : (count - 1u);
      dx[n] = x[i] - ox;
      dy[n] = y[i] - oy;
      turned[n] = heading[i] - heading[middle];
    }
    for (size_t n = 0u; n < 4u; ++n) {
      const size_t k = from + n;
      const double turn = turned[n];
      const double u = (ahead * dx[n]) + (aside * dy[n]);
      const double v = (ahead * dy[n]) - (aside * dx[n]);
      const double sine = tm_least(fabs(turn), 1.0); /* no less than that */
      const double along = 0.5 * (length + (width * sine));
      const double across = 0.5 * (width + (length * sine));
      stretch->turn[k] = turn;
      stretch->u[k] = u;
      stretch->v[k] = v;
      stretch->cosine[k] = (float)tm_about_cosine(turn);
      stretch->sine[k] = (float)tm_about_sine(turn);
      stretch->least_u[k] = (float)(u - along);
      stretch->most_u[k] = (float)(u + along);
      stretch->least_v[k] = (float)(v - across);
      stretch->most_v[k] = (float)(v + across);
    }
  }
  float u0 = INFINITY;
  float u1 = -INFINITY;
  float v0 = INFINITY;
  float v1 = -INFINITY;
  for (size_t k = 0u; k < count; ++k) {
    u0 = (stretch->least_u[k] < u0) ? stretch->least_u[k] : u0;
    u1 = (stretch->most_u[k] > u1) ? stretch->most_u[k] : u1;
    v0 = (stretch->least_v[k] < v0) ? stretch->least_v[k] : v0;
    v1 = (stretch->most_v[k] > v1) ? stretch->most_v[k] : v1;
  }
  stretch->ox = ox;
  stretch->oy = oy;
  all->ahead = ahead;
  all->aside = aside;
  all->u0 = (double)u0 - (fabs((double)u0) * 1.2e-7); /* no less than what was made short */
  all->u1 = (double)u1 + (fabs((double)u1) * 1.2e-7);
  all->v0 = (double)v0 - (fabs((double)v0) * 1.2e-7);
  all->v1 = (double)v1 + (fabs((double)v1) * 1.2e-7);
  const size_t behind = ((count + 3u) / 4u) * 4u; /* who looks at four ways at once reads it */
  stretch->cosine[behind] = 1.0f;
  stretch->sine[behind] = 0.0f;
}

/** How far what is swept along the ways of a stretch may be beyond the straight ones, and the most of these; `kappa`: the curvatures at its
   poses. */
static void tm_stretch_reaches(tm_stretch *stretch, const double *kappa, size_t count, double length, double width) {
  const double corner = 0.5 * sqrt((length * length) + (width * width));
  const float most = (float)corner;
  stretch->widest = 0.0;
  stretch->reach[0] = 0.0;
  for (size_t from = 0u; (from + 1u) < count; from += 4u) { /* four at once take no longer */
    float du[4];
    float dv[4];
    float way[4];
    float b0[4];
    float b1[4];
    float reach[4];
    for (size_t n = 0u; n < 4u; ++n) {
      const size_t k = from + n;
      const size_t i = ((k + 1u) < count) ? (k + 1u) : (count - 1u);
      const double u = stretch->u[i] - stretch->u[i - 1u];
      const double v = stretch->v[i] - stretch->v[i - 1u];
      const double chord = sqrt((u * u) + (v * v));
      du[n] = (float)u;
      dv[n] = (float)v;
      way[n] = (float)chord;
      b0[n] = (float)(kappa[i - 1u] * chord);
      b1[n] = (float)(kappa[i] * chord);
    }
    const float *cosine = &stretch->cosine[from];
    const float *sine = &stretch->sine[from];
    for (size_t n = 0u; n < 4u; ++n) {
      reach[n] = tm_curve_reach(du[n], dv[n], way[n], cosine[n], sine[n], cosine[n + 1u], sine[n + 1u], b0[n], b1[n], most);
    }
    for (size_t n = 0u; (n < 4u) && ((from + n + 1u) < count); ++n) {
      const size_t i = from + n + 1u;
      const bool little = (fabs(stretch->turn[i - 1u]) <= 0.4) && (fabs(stretch->turn[i]) <= 0.4);
      double beyond = (double)reach[n];
      if (!(beyond < TM_INF)) {
        beyond = tm_stand_reach(stretch->u[i] - stretch->u[i - 1u], stretch->v[i] - stretch->v[i - 1u],
                                stretch->turn[i] - stretch->turn[i - 1u], corner);
      }
      stretch->reach[i] = little ? beyond : TM_INF;
      stretch->widest = tm_greatest(stretch->widest, stretch->reach[i]);
    }
  }
}

/** List the segments of a shape that may lie within `reach` of a stretch; their number is one more than there is room for where there
   are more. */
static void tm_stretch_list(const tm_context *c, const tm_shape *shape, tm_stretch *stretch, double reach) {
  const size_t end = shape->first + shape->count;
  const tm_frame *frame = &stretch->frame;
  const tm_strip strip = tm_strip_of(frame, stretch->ox, stretch->oy);
  const double u = (frame->u0 + frame->u1) / 2.0;
  const double v = (frame->v0 + frame->v1) / 2.0;
  const double x = stretch->ox + ((frame->ahead * u) - (frame->aside * v));
  const double y = stretch->oy + ((frame->aside * u) + (frame->ahead * v));
  const double along = (frame->u1 - frame->u0) / 2.0;
  const double across = (frame->v1 - frame->v0) / 2.0;
  const double wide = (fabs(frame->ahead) * along) + (fabs(frame->aside) * across);
  const double high = (fabs(frame->aside) * along) + (fabs(frame->ahead) * across);
  const tm_box box = {x - wide, y - high, x + wide, y + high};
  const tm_box near = tm_grown(&box, reach);
  stretch->count = 0u;
  stretch->slack = 0.0;
  for (size_t k = 0u; k < TM_STRETCH_LIST; ++k) {
    stretch->u0[k] = INFINITY;
    stretch->u1[k] = INFINITY;
    stretch->v0[k] = INFINITY;
    stretch->v1[k] = INFINITY;
  }
  tm_walk walk = tm_walk_near(shape, shape->first, &near);
  for (size_t i = tm_walk_next(c, &walk); i < end; i = tm_walk_next(c, &walk)) {
    const size_t stop = tm_block_end(i, end);
    const tm_strip_shift shift = tm_strip_before(c, i, &strip, reach);
    const tm_outline *outline = &c->outline[i / 8u];
    unsigned looked = tm_strip_near(c, i, &strip, reach);
    stretch->slack = tm_greatest(stretch->slack, shift.slack);
    for (size_t k = 0u; (looked != 0u) && ((i + k) < stop); ++k) {
      if ((looked & 1u) != 0u) {
        const size_t n = stretch->count;
        ++stretch->count;
        if (n == TM_STRETCH_LIST) {
          return;
        }
        const float ax = outline->x[k] + shift.dx;
        const float ay = outline->y[k] + shift.dy;
        const float bx = outline->x[k + 1u] + shift.dx;
        const float by = outline->y[k + 1u] + shift.dy;
        const float ua = (strip.ahead * ax) + (strip.aside * ay);
        const float va = (strip.ahead * ay) - (strip.aside * ax);
        const float ub = (strip.ahead * bx) + (strip.aside * by);
        const float vb = (strip.ahead * by) - (strip.aside * bx);
        stretch->at[n] = i + k;
        stretch->ua[n] = ua;
        stretch->va[n] = va;
        stretch->ub[n] = ub;
        stretch->vb[n] = vb;
        stretch->u0[n] = (ua < ub) ? ua : ub;
        stretch->u1[n] = (ua < ub) ? ub : ua;
        stretch->v0[n] = (va < vb) ? va : vb;
        stretch->v1[n] = (va < vb) ? vb : va;
      }
      looked >>= 1u;
    }
  }
}

/** Whether a segment between two points may lie within `reach` of a box along the same direction; NaN may. */
static bool tm_box_near(const tm_frame *box, double ua, double va, double ub, double vb, double reach) {
  const double front = ((ua < ub) ? ua : ub) - box->u1;
  const double rear = box->u0 - ((ua < ub) ? ub : ua);
  const double left = ((va < vb) ? va : vb) - box->v1;
  const double right = box->v0 - ((va < vb) ? vb : va);
  const double u = (front > rear) ? front : rear;
  const double v = (left > right) ? left : right;
  const double du = (u > 0.0) ? u : 0.0;
  const double dv = (v > 0.0) ? v : 0.0;
  return !(((du * du) + (dv * dv)) > (reach * reach));
}

/** Which of the listed segments may lie within `reach` of what is swept between two poses of a stretch, going by the stretch: a bit each. */
static unsigned long tm_stretch_near(const tm_stretch *stretch, size_t p, size_t q, double reach) {
  const float *u0 = stretch->least_u;
  const float *u1 = stretch->most_u;
  const float *v0 = stretch->least_v;
  const float *v1 = stretch->most_v;
  const float box[4] = {(u0[q] < u0[p]) ? u0[q] : u0[p], (u1[q] > u1[p]) ? u1[q] : u1[p], (v0[q] < v0[p]) ? v0[q] : v0[p],
                        (v1[q] > v1[p]) ? v1[q] : v1[p]};
  const float more = (float)(reach + stretch->slack);
  unsigned long bits = 0u;
  for (size_t k = 0u; k < stretch->count; k += 8u) {
    bits |= (unsigned long)tm_strip_bits(&stretch->u0[k], &stretch->u1[k], &stretch->v0[k], &stretch->v1[k], box, more) << k;
  }
  /* Of an infinite reach, what is not listed is as near as what is. */
  return bits & ((1ul << stretch->count) - 1ul);
}

/** Of these segments, those that may still be going by the direction in the middle between both poses, if that is turned by little from
   the stretch. */
static unsigned long tm_stretch_nearer(const tm_stretch *stretch, size_t p, size_t q, double length, double width,
                                       double reach, unsigned long near) {
  const double turn = 0.5 * (stretch->turn[p] + stretch->turn[q]);
  const double cosine = tm_about_cosine(turn);
  const double sine = tm_about_sine(turn);
  const double turned = tm_least(0.5 * fabs(stretch->turn[p] - stretch->turn[q]), 1.0); /* no less than its sine */
  const double along = 0.5 * (length + (width * turned));
  const double across = 0.5 * (width + (length * turned));
  const double pu = (cosine * stretch->u[p]) + (sine * stretch->v[p]);
  const double pv = (cosine * stretch->v[p]) - (sine * stretch->u[p]);
  const double qu = (cosine * stretch->u[q]) + (sine * stretch->v[q]);
  const double qv = (cosine * stretch->v[q]) - (sine * stretch->u[q]);
  const double most = ((fabs(stretch->u[p]) + fabs(stretch->u[q])) + (fabs(stretch->v[p]) + fabs(stretch->v[q]))) + ((length + width) + reach);
  const double more = (reach + stretch->slack) + (4e-6 * most); /* sine and cosine are good to 1e-6 */
  tm_frame own = stretch->frame;
  if (!(fabs(turn) <= 0.25)) {
    return near;
  }
  own.u0 = tm_least(pu, qu) - along;
  own.u1 = tm_greatest(pu, qu) + along;
  own.v0 = tm_least(pv, qv) - across;
  own.v1 = tm_greatest(pv, qv) + across;
  for (size_t k = 0u; (near >> k) != 0u; ++k) {
    if (((near >> k) & 1ul) != 0u) {
      const double ua = (double)stretch->ua[k];
      const double va = (double)stretch->va[k];
      const double ub = (double)stretch->ub[k];
      const double vb = (double)stretch->vb[k];
      if (!tm_box_near(&own, (cosine * ua) + (sine * va), (cosine * va) - (sine * ua), (cosine * ub) + (sine * vb),
                       (cosine * vb) - (sine * ub), more)) {
        near &= ~(1ul << k);
      }
    }
  }
  return near;
}

/** Look at those listed segments that are near to a sweep. */
static void tm_sweep_listed(const tm_context *c, tm_shape *shape, const tm_stretch *stretch, unsigned long near, tm_sweep *sweep) {
  for (size_t k = 0u; (near != 0u) && !sweep->entered; ++k) {
    if (((near & 1ul) != 0u) && tm_sweep_nearer(c, stretch->at[k], sweep)) {
      shape->hint = stretch->at[k] - shape->first;
    }
    near >>= 1u;
  }
}

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

/** The largest over the sides of one convex polygon of the least way that the other lies in front of it, negated. */
static double tm_overlap(const tm_hull *a, const tm_hull *b) {
  double shortest = TM_INF;
  for (size_t i = 0u; i < a->count; ++i) {
    double way = -TM_INF;
    for (size_t j = 0u; j < b->count; ++j) {
      const double side = (a->gx[i] * (b->y[j] - a->y[i])) - (a->gy[i] * (b->x[j] - a->x[i]));
      way = tm_greatest(way, side / a->length[i]);
    }
    shortest = tm_least(shortest, way);
  }
  return shortest;
}

/** The straight way between two poses, as a curve of one piece. */
static void tm_straight_anew(double x0, double y0, double heading0, double x1, double y1, double heading1, tm_curve *curve) {
  curve->x[0] = x0;
  curve->y[0] = y0;
  curve->ahead[0] = cos(heading0);
  curve->aside[0] = sin(heading0);
  curve->x[1] = x1;
  curve->y[1] = y1;
  curve->ahead[1] = cos(heading1);
  curve->aside[1] = sin(heading1);
  curve->count = 1u;
  curve->more = 0.0;
}

/** The signed distance [m] of a piece of a curve from a box along (ahead, aside). */
static double tm_piece_clear(const tm_curve *curve, size_t j, double length, double width, double box_x, double box_y, double ahead,
                             double aside, double box_length, double box_width) {
  const size_t next = j + 1u;
  const double ox = curve->x[j];
  const double oy = curve->y[j];
  double x[8];
  double y[8];
  tm_hull a;
  tm_hull b;
  double ways;
  double best = TM_INF;
  tm_footprint(ox, oy, curve->ahead[j], curve->aside[j], length, width, ox, oy, &x[0], &y[0]);
  tm_footprint(curve->x[next], curve->y[next], curve->ahead[next], curve->aside[next], length, width, ox, oy, &x[4], &y[4]);
  tm_convex_hull(x, y, &a);
  tm_footprint(box_x, box_y, ahead, aside, box_length, box_width, ox, oy, &x[0], &y[0]);
  for (size_t i = 0u; i < 4u; ++i) {
    x[4u + i] = x[i];
    y[4u + i] = y[i];
  }
  tm_convex_hull(x, y, &b);
  ways = tm_least(tm_overlap(&a, &b), tm_overlap(&b, &a));
  if (ways > 0.0) {
    return -ways;
  }
  for (size_t i = 0u; i < a.count; ++i) {
    best = tm_least(best, tm_hull_distance(&b, a.x[i], a.y[i]));
  }
  for (size_t i = 0u; i < b.count; ++i) {
    best = tm_least(best, tm_hull_distance(&a, b.x[i], b.y[i]));
  }
  return best;
}

/** The signed distance [m] of what a vehicle sweeps straight between two poses from a box at rest; NaN for what is none. */
static double tm_swept_clear(double x0, double y0, double heading0, double x1, double y1, double heading1, double length,
                             double width, double box_x, double box_y, double box_heading, double box_length,
                             double box_width) {
  tm_curve curve;
  if (!tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) || !tm_usable(heading1) ||
      !tm_usable(box_x) || !tm_usable(box_y) || !tm_usable(box_heading) || !tm_sized(length, width) ||
      !tm_sized(box_length, box_width)) {
    return TM_NAN;
  }
  tm_straight_anew(x0, y0, heading0, x1, y1, heading1, &curve);
  return tm_piece_clear(&curve, 0u, length, width, box_x, box_y, cos(box_heading), sin(box_heading), box_length, box_width);
}

/** The same along a curve, of these curvatures at both poses [1/m]. Distances above `bound` need not be exact: the caller takes the least
   of many, and has found `bound` already. */
static double tm_curved_clear(double x0, double y0, double heading0, double x1, double y1, double heading1, double length,
                              double width, double box_x, double box_y, double box_heading, double box_length, double box_width,
                              double kappa0, double kappa1, double bound) {
  tm_curve curve;
  double ahead;
  double aside;
  double least;
  if (!tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) || !tm_usable(heading1) ||
      !tm_usable(box_x) || !tm_usable(box_y) || !tm_usable(box_heading) || !tm_usable(kappa0) || !tm_usable(kappa1) ||
      !tm_sized(length, width) || !tm_sized(box_length, box_width)) {
    return TM_NAN;
  }
  const double far = tm_curve_far(x1 - x0, y1 - y0, box_x - x0, box_y - y0, length + width, box_length + box_width, kappa0, kappa1);
  if (far > tm_greatest(bound, 0.0)) {
    return far;
  }
  tm_straight_anew(x0, y0, heading0, x1, y1, heading1, &curve);
  tm_curve_of(kappa0, kappa1, length, width, &curve);
  ahead = cos(box_heading);
  aside = sin(box_heading);
  least = tm_curve_limit(&curve, bound);
  for (size_t j = 0u; j < curve.count; ++j) {
    const double dx = curve.x[j + 1u] - curve.x[j];
    const double dy = curve.y[j + 1u] - curve.y[j];
    const double mx = (box_x - curve.x[j]) - (0.5 * dx);
    const double my = (box_y - curve.y[j]) - (0.5 * dy);
    /* Length and width together are no less than twice the way to a corner, and more than that by more than rounding. */
    const double around = 0.5 * (sqrt((dx * dx) + (dy * dy)) + ((length + width) + (box_length + box_width)));
    if ((sqrt((mx * mx) + (my * my)) - around) <= tm_greatest(least, 0.0)) {
      least = tm_least(least, tm_piece_clear(&curve, j, length, width, box_x, box_y, ahead, aside, box_length, box_width));
    }
  }
  return least - curve.more;
}

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
