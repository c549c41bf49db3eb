/* What a vehicle sweeps between two poses, straight or along a curve, inside a region: the signed margin. */

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
