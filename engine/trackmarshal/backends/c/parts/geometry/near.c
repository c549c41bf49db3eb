/* Segments of a shape, and which of them may be near: walks by the boxes around blocks of eight, strips that look along a direction. */

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
