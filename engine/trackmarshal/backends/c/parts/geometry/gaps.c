/* How far a segment of the border is from a sweep, the hull of a vehicle at two poses: first by what is quick to say, then exactly. */

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
