/* Stretches of a timeline: sweeps that are looked at together, with a list of the segments that may be near any of them. */

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
