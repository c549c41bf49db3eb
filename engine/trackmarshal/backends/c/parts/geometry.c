/** Whether a number is a coordinate: finite, and not so large that doubles are coarse there. */
static bool tm_usable(double x) {
  return fabs(x) <= 1e9;
}

/** Whether a length and a width are those of a body. */
static bool tm_sized(double length, double width) {
  return tm_usable(length) && tm_usable(width) && (length >= 1e-6) && (width >= 1e-6);
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

/** Whether a segment lies beside a box altogether. */
static inline bool tm_beside_box(const tm_segment *s, const tm_box *box) {
  const int x = ((s->ax < box->x0) & (s->bx < box->x0)) | ((s->ax > box->x1) & (s->bx > box->x1));
  const int y = ((s->ay < box->y0) & (s->by < box->y0)) | ((s->ay > box->y1) & (s->by > box->y1));
  return (x | y) != 0;
}

/** The next segment at or after `i` of a shape whose boxes all meet a box; else the end. */
static size_t tm_next_near(const tm_context *c, const tm_shape *shape, size_t i, const tm_box *box) {
  const size_t end = shape->first + shape->count;
  while ((i < end) && ((i & 7u) == 0u)) {
    if (((i & 511u) == 0u) && !tm_boxes_meet(&c->part_box[i / 512u], box)) {
      i += 512u;
    } else if (((i & 63u) == 0u) && !tm_boxes_meet(&c->group_box[i / 64u], box)) {
      i += 64u;
    } else if (!tm_boxes_meet(&c->block_box[i / 8u], box)) {
      i += 8u;
    } else {
      return i;
    }
  }
  return (i < end) ? i : end;
}

/** Where the block of eight segments ends that a segment is in. */
static size_t tm_block_end(size_t i, size_t end) {
  const size_t stop = (i | 7u) + 1u;
  return (stop < end) ? stop : end;
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

/** The distance of a point from a shape's segments, seen from (ox, oy), and the first of the nearest ones. */
static double tm_nearest(const tm_context *c, tm_shape *shape, double ox, double oy, double x, double y, size_t *which) {
  const tm_box at = {x + ox, y + oy, x + ox, y + oy};
  size_t nearest = shape->first + ((shape->hint < shape->count) ? shape->hint : 0u);
  double best = tm_segment_distance(&c->segment[nearest], ox, oy, x, y);
  const size_t end = shape->first + shape->count;
  tm_box near = tm_grown(&at, best);
  size_t i = tm_next_near(c, shape, shape->first, &near);
  while (i < end) {
    const size_t stop = tm_block_end(i, end);
    for (; i < stop; ++i) {
      if (!tm_beside_box(&c->segment[i], &near)) {
        const double reach = tm_segment_distance(&c->segment[i], ox, oy, x, y);
        if ((reach < best) || ((reach == best) && (i < nearest))) {
          best = reach;
          nearest = i;
          near = tm_grown(&at, best);
        }
      }
    }
    i = tm_next_near(c, shape, i, &near);
  }
  shape->hint = nearest - shape->first;
  *which = nearest;
  return best;
}

/** Whether a point that is not on the border lies inside a region: a ray along +x crosses the border an odd number of times. */
static bool tm_holds(const tm_context *c, const tm_shape *shape, double x, double y) {
  const double slack = 1e-3;
  const size_t end = shape->first + shape->count;
  bool inside = false;
  size_t i = shape->first;
  while (i < end) {
    const tm_box *part = &c->part_box[i / 512u];
    const tm_box *group = &c->group_box[i / 64u];
    const tm_box *block = &c->block_box[i / 8u];
    if (((i & 511u) == 0u) && ((y < part->y0) || (y > part->y1) || (x > (part->x1 + slack)))) {
      i += 512u;
    } else if (((i & 63u) == 0u) && ((y < group->y0) || (y > group->y1) || (x > (group->x1 + slack)))) {
      i += 64u;
    } else if (((i & 7u) == 0u) && ((y < block->y0) || (y > block->y1) || (x > (block->x1 + slack)))) {
      i += 8u;
    } else {
      const tm_segment *s = &c->segment[i];
      const bool upward = s->ay < s->by;
      const double low = upward ? s->ay : s->by;
      const double high = upward ? s->by : s->ay;
      if ((low <= y) && (y < high)) {
        const double ex = upward ? s->ex : -s->ex;
        const double ey = upward ? s->ey : -s->ey;
        const double ax = upward ? s->ax : s->bx;
        if (((ex * (y - low)) - (ey * (x - ax))) > 0.0) {
          inside = !inside;
        }
      }
      ++i;
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
  const tm_box at = {x, y, x, y};
  const tm_box near = tm_grown(&at, 1.0);
  const size_t end = shape->first + shape->count;
  if (shape->usable && tm_usable(x) && tm_usable(y)) {
    bool off = true;
    for (size_t i = shape->first; off && (i < end); i += 512u) {
      off = !tm_boxes_meet(&c->part_box[i / 512u], &near);
    }
    if (off) {
      return -1.0;
    }
  }
  return tm_in_area(c, shape, x, y);
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
  for (size_t i = 0u; i < 8u; ++i) {
    size_t at = n;
    bool known = false;
    for (size_t j = 0u; j < n; ++j) {
      known = known || ((x[j] == px[i]) && (y[j] == py[i]));
    }
    if (known) {
      continue;
    }
    while ((at > 0u) && ((px[i] < x[at - 1u]) || ((px[i] == x[at - 1u]) && (py[i] < y[at - 1u])))) {
      x[at] = x[at - 1u];
      y[at] = y[at - 1u];
      --at;
    }
    x[at] = px[i];
    y[at] = py[i];
    ++n;
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

/** Make the hull of a sweep, unless it is made. */
static void tm_sweep_hull(tm_sweep *sweep) {
  if (!sweep->built) {
    tm_convex_hull(sweep->x, sweep->y, &sweep->hull);
    sweep->built = true;
  }
}

/** The distance of a sweep (its eight corners, its sides) from one border segment that does not enter it; where it is more
   than the nearest so far, something more than that. */
static double tm_sweep_gap(tm_sweep *sweep, const tm_segment *s) {
  const double ax = s->ax - sweep->ox;
  const double ay = s->ay - sweep->oy;
  const double bx = s->bx - sweep->ox;
  const double by = s->by - sweep->oy;
  double line = TM_INF;
  double ends = TM_INF;
  double reach;
  double best;
  tm_segment start;
  for (size_t i = 0u; i < 8u; ++i) {
    const double rx = sweep->x[i] - ax;
    const double ry = sweep->y[i] - ay;
    const double product = (s->ex * rx) + (s->ey * ry);
    if ((0.0 < product) && (product < s->square)) {
      line = tm_least(line, fabs((s->ex * ry) - (s->ey * rx)));
    } else {
      const double sx = sweep->x[i] - bx;
      const double sy = sweep->y[i] - by;
      ends = tm_least(ends, tm_least((rx * rx) + (ry * ry), (sx * sx) + (sy * sy)));
    }
  }
  reach = tm_least(line / s->length, sqrt(ends));
  best = tm_least(sweep->best, reach);
  start = *s;
  start.bx = s->ax;
  start.by = s->ay;
  if (tm_frame_apart(&sweep->frame, &start, sweep->ox, sweep->oy) <= (best * best)) {
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
  for (size_t i = tm_next_near(c, shape, shape->first, &near); i < end; i = tm_next_near(c, shape, i + 1u, &near)) {
    const tm_segment *s = &c->segment[i];
    worst = tm_greatest(worst, tm_depth(hull, s->ax - ox, s->ay - oy));
  }
  if (worst == 0.0) {
    for (size_t i = tm_next_near(c, shape, shape->first, &near); i < end; i = tm_next_near(c, shape, i + 1u, &near)) {
      const tm_segment *s = &c->segment[i];
      if (tm_enters(s, ox, oy, hull)) {
        worst = tm_greatest(worst, tm_middle_depth(s, ox, oy, hull));
      }
    }
  }
  return tm_least(-2.2250738585072014e-308, -worst);
}

/** The boxes around eight points seen from (ox, oy): one along the axes, not seen from there, and one along (ahead, aside). */
static void tm_bound_points(const double *x, const double *y, double ox, double oy, tm_box *box, tm_frame *frame) {
  box->x0 = TM_INF;
  box->x1 = -TM_INF;
  box->y0 = TM_INF;
  box->y1 = -TM_INF;
  frame->u0 = TM_INF;
  frame->u1 = -TM_INF;
  frame->v0 = TM_INF;
  frame->v1 = -TM_INF;
  for (size_t i = 0u; i < 8u; ++i) {
    const double u = (frame->ahead * x[i]) + (frame->aside * y[i]);
    const double v = (frame->ahead * y[i]) - (frame->aside * x[i]);
    box->x0 = tm_least(box->x0, x[i]);
    box->x1 = tm_greatest(box->x1, x[i]);
    box->y0 = tm_least(box->y0, y[i]);
    box->y1 = tm_greatest(box->y1, y[i]);
    frame->u0 = tm_least(frame->u0, u);
    frame->u1 = tm_greatest(frame->u1, u);
    frame->v0 = tm_least(frame->v0, v);
    frame->v1 = tm_greatest(frame->v1, v);
  }
  box->x0 += ox;
  box->x1 += ox;
  box->y0 += oy;
  box->y1 += oy;
}

/** What is swept between two poses: its corners seen from the first one, and the boxes around it. */
static void tm_sweep_between(tm_shape *shape, double x0, double y0, double heading0, double x1, double y1, double heading1,
                             double length, double width, double bound, tm_sweep *sweep) {
  double ahead0;
  double aside0;
  if (shape->known && (heading0 == shape->heading)) { /* the last pose of one sweep is the first one of the next */
    ahead0 = shape->ahead;
    aside0 = shape->aside;
  } else {
    ahead0 = cos(heading0);
    aside0 = sin(heading0);
  }
  if (!shape->known || !(heading1 == shape->heading)) {
    shape->ahead = cos(heading1);
    shape->aside = sin(heading1);
  }
  shape->heading = heading1;
  shape->known = true;
  sweep->ox = x0;
  sweep->oy = y0;
  sweep->frame.ahead = shape->ahead;
  sweep->frame.aside = shape->aside;
  tm_footprint(x0, y0, ahead0, aside0, length, width, x0, y0, &sweep->x[0], &sweep->y[0]);
  tm_footprint(x1, y1, shape->ahead, shape->aside, length, width, x0, y0, &sweep->x[4], &sweep->y[4]);
  tm_bound_points(sweep->x, sweep->y, x0, y0, &sweep->box, &sweep->frame);
  sweep->best = (bound > 0.0) ? bound : 0.0;
  sweep->built = false;
  sweep->entered = false;
}

/** Look at a border segment; whether it is nearer to the sweep than all that were looked at. */
static bool tm_sweep_nearer(tm_sweep *sweep, const tm_segment *s) {
  const double apart = tm_frame_apart(&sweep->frame, s, sweep->ox, sweep->oy);
  double reach;
  if (!(apart <= (sweep->best * sweep->best))) {
    return false;
  }
  if (apart == 0.0) {
    tm_sweep_hull(sweep);
    if (tm_enters(s, sweep->ox, sweep->oy, &sweep->hull)) {
      sweep->entered = true;
      return false;
    }
  }
  reach = tm_sweep_gap(sweep, s);
  if (reach < sweep->best) {
    sweep->best = reach;
    return true;
  }
  return false;
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
  strip.size = (float)((fabs(frame->u0) + fabs(frame->u1)) + (fabs(frame->v0) + fabs(frame->v1)));
  return strip;
}

/** What the numbers of a strip and of an outline, which are short, may be wrong by, and a little more [m]. */
static float tm_strip_slack(const tm_strip *strip, const tm_box *group, float dx, float dy) {
  const float extent = (float)((group->x1 - group->x0) + (group->y1 - group->y0));
  return ((extent + strip->size) + ((dx < 0.0f) ? -dx : dx) + ((dy < 0.0f) ? -dy : dy)) * 2e-6f + 1e-4f;
}

/** Which of the eight segments from `i` on may lie within `reach` of a strip: a bit each. */
static unsigned tm_strip_near(const tm_context *c, size_t i, const tm_strip *strip, double reach) {
  const tm_outline *outline = &c->outline[i / 8u];
  const tm_box *group = &c->group_box[i / 64u];
  const float dx = (float)(group->x0 - strip->ox);
  const float dy = (float)(group->y0 - strip->oy);
  const float more = (float)reach + tm_strip_slack(strip, group, dx, dy);
  const float limit = more * more;
  float u[9];
  float v[9];
  float apart[8];
  unsigned found = 0u;
  for (size_t k = 0u; k < 8u; ++k) {
    const float x = outline->x[k] + dx;
    const float y = outline->y[k] + dy;
    u[k] = (strip->ahead * x) + (strip->aside * y);
    v[k] = (strip->ahead * y) - (strip->aside * x);
  }
  u[8] = (strip->ahead * (outline->x[8] + dx)) + (strip->aside * (outline->y[8] + dy));
  v[8] = (strip->ahead * (outline->y[8] + dy)) - (strip->aside * (outline->x[8] + dx));
  for (size_t k = 0u; k < 8u; ++k) {
    const float front = ((u[k] < u[k + 1u]) ? u[k] : u[k + 1u]) - strip->u1;
    const float rear = strip->u0 - ((u[k] < u[k + 1u]) ? u[k + 1u] : u[k]);
    const float left = ((v[k] < v[k + 1u]) ? v[k] : v[k + 1u]) - strip->v1;
    const float right = strip->v0 - ((v[k] < v[k + 1u]) ? v[k + 1u] : v[k]);
    const float du = (front > rear) ? front : rear;
    const float dv = (left > right) ? left : right;
    const float beside_u = (du > 0.0f) ? du : 0.0f;
    const float beside_v = (dv > 0.0f) ? dv : 0.0f;
    apart[k] = (beside_u * beside_u) + (beside_v * beside_v);
  }
  for (size_t k = 0u; k < 8u; ++k) {
    found |= (apart[k] > limit) ? 0u : (1u << k);
  }
  return found;
}

/** The signed margin of a sweep for which all of the border that may matter was looked at. `from_inside`: its first pose is well inside;
   then so is all of it where nothing of the border lies in it. */
static double tm_sweep_margin(tm_context *c, tm_shape *shape, tm_sweep *sweep, bool from_inside, double x, double y) {
  shape->inside = false;
  if (sweep->entered || !((from_inside && (sweep->best > 1e-3)) || tm_holds(c, shape, x, y))) {
    tm_sweep_hull(sweep);
    return tm_outside(c, shape, sweep->ox, sweep->oy, sweep->x, sweep->y, &sweep->hull, &sweep->box);
  }
  shape->inside = sweep->best > 1e-3;
  return sweep->best;
}

/** The signed margin [m] of what a vehicle sweeps between two poses inside a region; NaN for what is none.
   Margins above `bound` need not be exact: the caller takes the least of many, and has found `bound` already. */
static double tm_swept_inside(tm_context *c, tm_shape *shape, double x0, double y0, double heading0, double x1, double y1,
                              double heading1, double length, double width, double bound) {
  tm_sweep sweep;
  if (!shape->usable || !tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) ||
      !tm_usable(heading1) || !tm_sized(length, width)) {
    return TM_NAN;
  }
  const bool from_inside = shape->inside && (x0 == shape->x) && (y0 == shape->y);
  shape->x = x1;
  shape->y = y1;
  tm_sweep_between(shape, x0, y0, heading0, x1, y1, heading1, length, width, bound, &sweep);
  const size_t end = shape->first + shape->count;
  const size_t likely = shape->first + ((shape->hint < shape->count) ? shape->hint : 0u);
  /* What was nearest last time is near this time, and leaves little to look at. */
  (void)tm_sweep_nearer(&sweep, &c->segment[likely]);
  const tm_strip strip = tm_strip_of(&sweep.frame, x0, y0);
  tm_box near = tm_grown(&sweep.box, sweep.best);
  size_t i = tm_next_near(c, shape, shape->first, &near);
  while ((i < end) && !sweep.entered) {
    const size_t stop = tm_block_end(i, end);
    unsigned looked = tm_strip_near(c, i, &strip, sweep.best);
    for (; (i < stop) && !sweep.entered; ++i) {
      if (((looked & 1u) != 0u) && (i != likely) && tm_sweep_nearer(&sweep, &c->segment[i])) {
        near = tm_grown(&sweep.box, sweep.best);
        shape->hint = i - shape->first;
      }
      looked >>= 1u;
    }
    if (!sweep.entered) {
      i = tm_next_near(c, shape, i, &near);
    }
  }
  return tm_sweep_margin(c, shape, &sweep, from_inside, (x0 + x1) / 2.0, (y0 + y1) / 2.0);
}

/** Of the segments of a shape, those that may lie within `reach` of a strip, with their boxes along it; their number, or one more
   than there is room for. */
static size_t tm_strip_list(const tm_context *c, const tm_shape *shape, const tm_frame *frame, double ox, double oy, double reach,
                            tm_beside_strip *list) {
  const size_t end = shape->first + shape->count;
  const tm_strip strip = tm_strip_of(frame, ox, oy);
  const double u = (frame->u0 + frame->u1) / 2.0;
  const double v = (frame->v0 + frame->v1) / 2.0;
  const double x = ox + ((frame->ahead * u) - (frame->aside * v));
  const double y = oy + ((frame->aside * u) + (frame->ahead * v));
  const double along = (frame->u1 - frame->u0) / 2.0;
  const double across = (frame->v1 - frame->v0) / 2.0;
  const double wide = (fabs(frame->ahead) * along) + (fabs(frame->aside) * across);
  const double high = (fabs(frame->aside) * along) + (fabs(frame->ahead) * across);
  const tm_box box = {x - wide, y - high, x + wide, y + high};
  const tm_box near = tm_grown(&box, reach);
  size_t count = 0u;
  for (size_t i = tm_next_near(c, shape, shape->first, &near); i < end; i = tm_next_near(c, shape, tm_block_end(i, end), &near)) {
    const size_t stop = tm_block_end(i, end);
    unsigned looked = tm_strip_near(c, i, &strip, reach);
    for (size_t k = i; (k < stop) && (looked != 0u); ++k) {
      if ((looked & 1u) != 0u) {
        const tm_segment *s = &c->segment[k];
        if (count == TM_STRIP_LIST) {
          return count + 1u;
        }
        const double ua = (frame->ahead * (s->ax - ox)) + (frame->aside * (s->ay - oy));
        const double ub = (frame->ahead * (s->bx - ox)) + (frame->aside * (s->by - oy));
        const double va = (frame->ahead * (s->ay - oy)) - (frame->aside * (s->ax - ox));
        const double vb = (frame->ahead * (s->by - oy)) - (frame->aside * (s->bx - ox));
        list[count].at = k - shape->first;
        list[count].u0 = tm_least(ua, ub);
        list[count].u1 = tm_greatest(ua, ub);
        list[count].v0 = tm_least(va, vb);
        list[count].v1 = tm_greatest(va, vb);
        ++count;
      }
      looked >>= 1u;
    }
  }
  return count;
}

/** Which of listed segments may lie within `reach` of the box of a sweep in the same strip: a bit each. */
static unsigned long tm_strip_bits(const tm_frame *box, const tm_beside_strip *list, size_t count, double reach) {
  const double more = reach + 1e-5;
  unsigned long bits = 0u;
  for (size_t k = 0u; k < count; ++k) {
    const double u = tm_greatest(list[k].u0 - box->u1, box->u0 - list[k].u1);
    const double v = tm_greatest(list[k].v0 - box->v1, box->v0 - list[k].v1);
    const double du = (u > 0.0) ? u : 0.0;
    const double dv = (v > 0.0) ? v : 0.0;
    if (((du * du) + (dv * dv)) <= (more * more)) {
      bits |= 1ul << k;
    }
  }
  return bits;
}

/** The box of a pose along a direction, seen from (ox, oy): a little larger than its footprint, whose heading need not be known well. */
static tm_frame tm_pose_box(const tm_frame *along, double ox, double oy, double heading, double px, double py, double pose,
                            double length, double width) {
  tm_frame box = *along;
  const double off = fabs(pose - heading);
  const double turn = (off < 1.0) ? off : 1.0; /* at least the sine */
  const double u = (along->ahead * (px - ox)) + (along->aside * (py - oy));
  const double v = (along->ahead * (py - oy)) - (along->aside * (px - ox));
  const double half_u = 0.5 * (length + (width * turn));
  const double half_v = 0.5 * (width + (length * turn));
  box.u0 = u - half_u;
  box.u1 = u + half_u;
  box.v0 = v - half_v;
  box.v1 = v + half_v;
  return box;
}

/** Let a box hold another one along the same direction. */
static void tm_box_holds(tm_frame *box, const tm_frame *other) {
  box->u0 = tm_least(box->u0, other->u0);
  box->u1 = tm_greatest(box->u1, other->u1);
  box->v0 = tm_least(box->v0, other->v0);
  box->v1 = tm_greatest(box->v1, other->v1);
}

/** The gap between a border segment and the sweep that passes nearest to it, to begin with: none of a timeline's margins that
   is greater matters. */
static double tm_first_gap(tm_context *c, tm_shape *shape, size_t which, const double *x, const double *y, const double *heading,
                           size_t n, double length, double width) {
  const tm_segment *s = &c->segment[shape->first + which];
  tm_sweep sweep;
  double nearest = TM_INF;
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
  const size_t before = tm_before(at, 1u);
  tm_sweep_between(shape, x[before], y[before], heading[before], x[at], y[at], heading[at], length, width, TM_INF, &sweep);
  (void)tm_sweep_nearer(&sweep, s);
  if (!sweep.entered && (sweep.best <= (2.0 * length))) {
    return sweep.best;
  }
  shape->hint = which;
  return tm_swept_inside(c, shape, x[before], y[before], heading[before], x[at], y[at], heading[at], length, width, TM_INF);
}

/** The least signed margin [m] of what a vehicle sweeps from sample to sample of a timeline inside a region; NaN where one has none.
   Sweeps are looked at eight at a time: what stays farther from the border than the least gap so far is inside if its first pose is. */
static double tm_timeline_inside(tm_context *c, tm_shape *shape, const double *x, const double *y, const double *heading, size_t n,
                                 double length, double width) {
  double best;
  bool inside = false;
  if (!shape->usable || !tm_sized(length, width) || (n < 1u)) {
    return TM_NAN;
  }
  for (size_t i = 0u; i < n; ++i) {
    if (!tm_usable(x[i]) || !tm_usable(y[i]) || !tm_usable(heading[i])) {
      return TM_NAN;
    }
  }
  /* Candidates come by turns: each begins where its margin was least in the cycle before. */
  shape->turn_near = (shape->turn_near == 0u) ? 1u : 0u;
  size_t *hint = &shape->near[shape->turn_near];
  *hint = (*hint < shape->count) ? *hint : 0u;
  best = tm_first_gap(c, shape, *hint, x, y, heading, n, length, width);
  for (size_t first = 0u; first < n; first += 8u) {
    const size_t stop = ((n - first) < 8u) ? n : (first + 8u);
    const size_t from = tm_before(first, 1u);
    const size_t middle = from + ((stop - from) / 2u);
    tm_frame box[9];
    tm_frame all;
    tm_beside_strip list[TM_STRIP_LIST];
    all.ahead = cos(heading[middle]);
    all.aside = sin(heading[middle]);
    all.u0 = TM_INF;
    all.u1 = -TM_INF;
    all.v0 = TM_INF;
    all.v1 = -TM_INF;
    for (size_t i = from; i < stop; ++i) {
      box[i - from] = tm_pose_box(&all, x[middle], y[middle], heading[middle], x[i], y[i], heading[i], length, width);
    }
    for (size_t i = from; i < stop; ++i) {
      tm_box_holds(&all, &box[i - from]);
    }
    const size_t count = tm_strip_list(c, shape, &all, x[middle], y[middle], tm_greatest(best, 1e-3), list);
    if ((count == 0u) && (inside || tm_holds(c, shape, x[from], y[from]))) {
      inside = true;
      continue;
    }
    for (size_t i = first; i < stop; ++i) {
      const size_t before = tm_before(i, 1u);
      tm_frame swept = box[before - from];
      unsigned long near = 0u;
      double margin;
      tm_box_holds(&swept, &box[i - from]);
      if (count <= TM_STRIP_LIST) {
        near = tm_strip_bits(&swept, list, count, tm_greatest(best, 1e-3));
        if ((near == 0u) && (inside || tm_holds(c, shape, x[before], y[before]))) {
          inside = true;
          continue;
        }
      }
      shape->hint = *hint;
      if (count <= TM_STRIP_LIST) {
        tm_sweep sweep;
        tm_sweep_between(shape, x[before], y[before], heading[before], x[i], y[i], heading[i], length, width, best, &sweep);
        for (size_t k = 0u; (near != 0u) && !sweep.entered; ++k) {
          if (((near & 1ul) != 0u) && tm_sweep_nearer(&sweep, &c->segment[shape->first + list[k].at])) {
            shape->hint = list[k].at;
          }
          near >>= 1u;
        }
        margin = tm_sweep_margin(c, shape, &sweep, inside, (x[before] + x[i]) / 2.0, (y[before] + y[i]) / 2.0);
      } else {
        shape->inside = inside;
        shape->x = x[before];
        shape->y = y[before];
        margin = tm_swept_inside(c, shape, x[before], y[before], heading[before], x[i], y[i], heading[i], length, width, best);
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

/** The signed distance [m] of what a vehicle sweeps between two poses from a box at rest; NaN for what is none. */
static double tm_swept_clear(double x0, double y0, double heading0, double x1, double y1, double heading1, double length,
                             double width, double box_x, double box_y, double box_heading, double box_length,
                             double box_width) {
  double x[8];
  double y[8];
  tm_hull a;
  tm_hull b;
  double ways;
  double best = TM_INF;
  if (!tm_usable(x0) || !tm_usable(y0) || !tm_usable(heading0) || !tm_usable(x1) || !tm_usable(y1) || !tm_usable(heading1) ||
      !tm_usable(box_x) || !tm_usable(box_y) || !tm_usable(box_heading) || !tm_sized(length, width) ||
      !tm_sized(box_length, box_width)) {
    return TM_NAN;
  }
  tm_footprint(x0, y0, cos(heading0), sin(heading0), length, width, x0, y0, &x[0], &y[0]);
  tm_footprint(x1, y1, cos(heading1), sin(heading1), length, width, x0, y0, &x[4], &y[4]);
  tm_convex_hull(x, y, &a);
  tm_footprint(box_x, box_y, cos(box_heading), sin(box_heading), box_length, box_width, x0, y0, &x[0], &y[0]);
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

/** Station [m], offset [m, positive to the left] and direction [rad] of a point along a line. Many rules ask for the same few points. */
static tm_projection tm_line_project(tm_context *c, tm_shape *line, double x, double y) {
  size_t k = 0u;
  double reach;
  tm_projection result;
  if (!line->usable || !tm_usable(x) || !tm_usable(y)) {
    return tm_nowhere();
  }
  for (size_t i = 0u; i < 8u; ++i) {
    if ((line->recent[i].x == x) && (line->recent[i].y == y)) {
      return line->recent[i].at;
    }
  }
  reach = tm_nearest(c, line, 0.0, 0.0, x, y, &k);
  result = tm_beside(&c->segment[k], reach, line->closed || (k > line->first),
                     line->closed || ((k + 1u) < (line->first + line->count)), x, y);
  result.station = c->along[k].station + result.station;
  if (line->closed && (result.station >= line->length)) {
    result.station = 0.0;
  }
  result.direction = c->along[k].direction;
  if ((x != 0.0) && (y != 0.0)) { /* both zeros are equal, yet not the same */
    line->recent[line->turn].x = x;
    line->recent[line->turn].y = y;
    line->recent[line->turn].at = result;
    line->turn = (line->turn + 1u) & 7u;
  }
  return result;
}

/** Forget the points that were projected on a line. */
static void tm_forget(tm_shape *line) {
  line->turn = 0u;
  for (size_t i = 0u; i < 8u; ++i) {
    line->recent[i].x = TM_NAN;
    line->recent[i].y = TM_NAN;
    line->recent[i].at = tm_nowhere();
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

/** Whether two points are one. */
static bool tm_same(double ax, double ay, double bx, double by) {
  return (fabs(ax - bx) <= 1e-9) && (fabs(ay - by) <= 1e-9);
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

/** The index of the next point of a path after `i` that is another one; the count where there is none. */
static size_t tm_path_next(const double *px, const double *py, size_t n, size_t i) {
  size_t j = i + 1u;
  while ((j < n) && tm_same(px[j], py[j], px[i], py[i])) {
    ++j;
  }
  return j;
}

/** Whether the points of a path are usable, and at least two are different. */
static bool tm_path_usable(const double *px, const double *py, size_t n) {
  for (size_t i = 0u; i < n; ++i) {
    if (!tm_usable(px[i]) || !tm_usable(py[i])) {
      return false;
    }
  }
  return (n > 0u) && (tm_path_next(px, py, n, 0u) < n);
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

/** The distance [m] of a point from the path of a trajectory. */
static double tm_path_distance(const double *px, const double *py, size_t n, double x, double y) {
  double best = TM_INF;
  if (!tm_usable(x) || !tm_usable(y) || !tm_path_usable(px, py, n)) {
    return TM_NAN;
  }
  size_t i = 0u;
  size_t j = tm_path_next(px, py, n, 0u);
  while (j < n) {
    const tm_segment s = tm_between(px[i], py[i], px[j], py[j]);
    best = tm_least(best, tm_segment_distance(&s, 0.0, 0.0, x, y));
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
