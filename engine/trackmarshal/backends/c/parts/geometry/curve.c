/* The way between two poses of given curvatures: cut into pieces, and how far it may be beyond them. */

/** How far beyond the hull of both footprints a vehicle reaches that passes anywhere in the circle around the chord, and points anywhere
   between both headings [m]. */
static double tm_at_random(const tm_curve *curve, double way, double corner) {
  const double gx = curve->ahead[1] - curve->ahead[0];
  const double gy = curve->aside[1] - curve->aside[0];
  const double sx = curve->ahead[1] + curve->ahead[0];
  const double sy = curve->aside[1] + curve->aside[0];
  const double turned = (gx * gx) + (gy * gy);
  const double swing = corner * (turned / (4.0 + (2.0 * sqrt((sx * sx) + (sy * sy)))));
  return swing + (tm_least(way, corner * sqrt(turned)) + (0.5 * way));
}

/** Cut the way between the first two poses of a curve into pieces; `kappa0`, `kappa1`: the curvatures at both [1/m]. */
static void tm_curve_of(double kappa0, double kappa1, double length, double width, tm_curve *curve) {
  const double x0 = curve->x[0];
  const double y0 = curve->y[0];
  const double dx = curve->x[1] - x0;
  const double dy = curve->y[1] - y0;
  const double square = (dx * dx) + (dy * dy);
  const double along0 = (dx * curve->ahead[0]) + (dy * curve->aside[0]);
  const double aside0 = (dx * curve->aside[0]) - (dy * curve->ahead[0]);
  const double along1 = (dx * curve->ahead[1]) + (dy * curve->aside[1]);
  const double aside1 = (dx * curve->aside[1]) - (dy * curve->ahead[1]);
  const double way = sqrt(square);
  const double corner = sqrt(((0.5 * length) * (0.5 * length)) + ((0.5 * width) * (0.5 * width)));
  curve->count = 1u;
  if ((square > 1e-12) && ((along0 * along1) > 0.0) && (fabs(aside0) <= fabs(along0)) && (fabs(aside1) <= fabs(along1))) {
    const double slope0 = aside0 / along0;
    const double slope1 = aside1 / along1;
    const double grow0 = 1.0 + (slope0 * slope0);
    const double grow1 = 1.0 + (slope1 * slope1);
    const double bent0 = (kappa0 * way) * (grow0 * sqrt(grow0));
    const double bent1 = (kappa1 * way) * (grow1 * sqrt(grow1));
    const double turn = slope1 - slope0;
    const double lean = 0.5 * (bent0 - bent1);
    const double sway = -3.0 * (slope0 + slope1);
    const double slip = fabs(lean - sway);
    const double steep = fabs(turn) + fabs(lean);
    const double off = fabs((0.5 * (bent0 + bent1)) - turn) + ((0.03125 * fabs(lean)) * (steep * steep));
    while ((curve->count < TM_PIECES) && ((0.014 * (double)curve->count) < (corner * steep))) {
      ++curve->count;
    }
    const double count = (double)curve->count;
    const double bulge = (way * (fabs(turn) + (fabs(sway) * (1.0 - (0.74 / count))))) +
                         (corner * ((2.0 * fabs(lean)) + (steep * steep)));
    curve->more = (bulge / ((8.0 * count) * count)) + (((0.0625 * (off + slip)) * way) + ((0.5 * corner) * off));
    curve->x[curve->count] = curve->x[1];
    curve->y[curve->count] = curve->y[1];
    curve->ahead[curve->count] = curve->ahead[1];
    curve->aside[curve->count] = curve->aside[1];
    for (size_t j = 1u; j < curve->count; ++j) {
      const double t = (double)j / count;
      const double rest = 1.0 - t;
      const double bump = t * (1.0 - t);
      const double slope = ((slope0 * rest) + (slope1 * t)) + (lean * bump);
      const double left = bump * ((slope0 * rest) - (slope1 * t));
      const double ex = dx - (slope * dy);
      const double ey = dy + (slope * dx);
      const double root = sqrt((ex * ex) + (ey * ey));
      const double size = (along0 < 0.0) ? -root : root;
      curve->x[j] = x0 + ((t * dx) - (left * dy));
      curve->y[j] = y0 + ((t * dy) + (left * dx));
      curve->ahead[j] = ex / size;
      curve->aside[j] = ey / size;
    }
  } else {
    curve->more = tm_at_random(curve, way, corner);
  }
  curve->more = (curve->more > 1e-9) ? curve->more : 0.0;
}

/** Below which margin of a piece that of the whole curve may be below `bound`, and a little more. */
static double tm_curve_limit(const tm_curve *curve, double bound) {
  return (bound + curve->more) + (1e-14 * (fabs(bound) + curve->more));
}

/** How far what is swept along a curve may be beyond the hull of both footprints, or more [m]; infinite where that is not known at once.
   (du, dv): the chord from one pose to the other, `way` long; (c0, s0), (c1, s1): cosines and sines of their turns, which may be wrong by 1e-5;
   b0, b1: the curvatures there, times the way. As in tm_curve_of, for slopes up to 0.25, where a tangent is at most 0.6 times the cube above its
   sine, and the power of 1.5 at most 1.7 times the square above 1. In short: of what is added up, nothing is less than what rounding makes of it. */
static inline float tm_curve_reach(float du, float dv, float way, float c0, float s0, float c1, float s1, float b0, float b1,
                                   float corner) {
  const float per = 1.0f / ((way > 1e-9f) ? way : 1e-9f);
  const float along0 = (du * c0) + (dv * s0);
  const float along1 = (du * c1) + (dv * s1);
  const float a0 = per * ((du * s0) - (dv * c0));
  const float a1 = per * ((du * s1) - (dv * c1));
  const float q0 = a0 * a0;
  const float q1 = a1 * a1;
  const float cubes = 0.6f * ((q0 * fabsf(a0)) + (q1 * fabsf(a1)));
  const float bent = 0.85f * ((q0 * fabsf(b0)) + (q1 * fabsf(b1)));
  const float turn = fabsf(a1 - a0) + cubes;
  const float lean = (0.5f * fabsf(b0 - b1)) + bent;
  const float sway = 3.0f * (fabsf(a0 + a1) + cubes);
  const float steep = turn + lean;
  const float off = fabsf((0.5f * (b0 + b1)) - (a1 - a0)) + ((cubes + bent) + ((0.03125f * lean) * (steep * steep)));
  /* An eighth of the bulge is that of the way; that of its pieces, if there are two or more, is at most a quarter of it (of the sway, 0.61). */
  const float bulge = (way * (turn + (0.335f * sway))) + (corner * ((2.0f * lean) + (steep * steep)));
  const float more = (((0.0625f * (off + (lean + sway))) * way) + ((0.5f * corner) * off)) + (0.15625f * bulge);
  const int small = (q0 <= 0.0625f) & (q1 <= 0.0625f) & (along0 > 2e-6f) & (along1 > 2e-6f) & (more < 1e30f);
  return (small != 0) ? ((1.001f * more) + (1e-4f * (corner + way))) : INFINITY;
}

/** The same for a vehicle that stands, as good as: it goes no farther than this in any direction, and turns by `turned` [rad]. */
static double tm_stand_reach(double du, double dv, double turned, double corner) {
  const double way = sqrt((du * du) + (dv * dv));
  return (way < 0.5e-6) ? ((1e-5 + (1.5 * way)) + ((0.25 * corner) * (turned * turned))) : TM_INF;
}

/** No more than the distance [m] of a box from what is swept along a curve, whatever the headings. (dx, dy): the chord; (bx, by): the box, seen
   from the first pose; `size`, `box_size`: length and width together, no less than twice the way to a corner. */
static double tm_curve_far(double dx, double dy, double bx, double by, double size, double box_size, double kappa0, double kappa1) {
  const double way = sqrt((dx * dx) + (dy * dy));
  const double mx = bx - (0.5 * dx);
  const double my = by - (0.5 * dy);
  const double corner = 0.5 * size;
  const double bent = (3.0 * way) * tm_greatest(fabs(kappa0), fabs(kappa1)); /* slopes are 1 at most */
  const double steep = 2.0 + bent;
  const double bulge = (8.0 * way) + (corner * ((2.0 * bent) + (steep * steep)));
  const double off = (2.0 + bent) + ((0.03125 * bent) * (steep * steep));
  const double more = (0.125 * bulge) + (((0.0625 * ((6.0 + bent) + off)) * way) + ((0.5 * corner) * off));
  return ((sqrt((mx * mx) + (my * my)) - (0.75 * way)) - (corner + (0.5 * box_size))) - (1.001 * more);
}
