/* Boxes and outlines of every eight segments of a shape, by which walks find what is near; made when it is prepared. */

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
