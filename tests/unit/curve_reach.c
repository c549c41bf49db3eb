/* Random ways from pose to pose and points beside them: says how many points were asked for, how many are nearer to the curve than its
   straight hull and the shortcut's reach allow, and the greatest part of the reach that one took. Of boxes anywhere around any ways: how many were
   said to be apart at first sight, and how many of them are nearer than that. */
#include "supervisor.c"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t state = 1u;

static double between(double low, double high) {
  state = (state * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
  return low + ((high - low) * ((double)(state >> 11) / 9007199254740992.0));
}

/* Of any size. */
static double sized(double low, double high) {
  return (between(0.0, 1.0) < 0.5 ? -1.0 : 1.0) * low * pow(high / low, between(0.0, 1.0));
}

/* The distance of a point from the hull of a piece, 0 inside. */
static double away(const tm_curve *curve, size_t j, double length, double width, double x, double y) {
  tm_sweep sweep;
  tm_sweep_piece(curve, j, length, width, TM_INF, &sweep);
  tm_sweep_hull(&sweep);
  return (tm_depth(&sweep.hull, x - sweep.ox, y - sweep.oy) > 0.0) ? 0.0 : tm_hull_distance(&sweep.hull, x - sweep.ox, y - sweep.oy);
}

/* Whether a box is nearer to a way than is said of it at first sight; `told`: how often that is anything. */
static bool nearer_than_said(long *told) {
  const double length = between(1.0, 8.0);
  const double width = between(0.5, 3.0);
  const double box_length = between(0.5, 8.0);
  const double box_width = between(0.5, 3.0);
  const double way = fabs(sized(0.01, 12.0));
  const double chord = between(-3.0, 3.0);
  const double heading0 = chord + sized(1e-5, 3.0);
  const double heading1 = chord + sized(1e-5, 3.0);
  const double kappa0 = sized(1e-5, 0.5);
  const double kappa1 = sized(1e-5, 0.5);
  const double x1 = way * cos(chord);
  const double y1 = way * sin(chord);
  const double from = between(0.0, 1.0) * way;
  const double aside = sized(0.5, 60.0);
  const double box_x = (from * cos(chord)) - (aside * sin(chord));
  const double box_y = (from * sin(chord)) + (aside * cos(chord));
  const double far = tm_curve_far(x1, y1, box_x, box_y, length + width, box_length + box_width, kappa0, kappa1);
  const double exact = tm_curved_clear(0.0, 0.0, heading0, x1, y1, heading1, length, width, box_x, box_y, between(-3.0, 3.0), box_length,
                                       box_width, kappa0, kappa1, TM_INF);
  *told += (far > 0.0) ? 1 : 0;
  return (far > 0.0) && (exact < far);
}

int main(int count, char **words) {
  const long ways = (count > 1) ? atol(words[1]) : 1000;
  long asked = 0;
  long below = 0;
  double most = 0.0;
  for (long k = 0; k < ways; ++k) {
    const double length = between(1.0, 8.0);
    const double width = between(0.5, 3.0);
    const double way = fabs(sized(0.01, 12.0));
    const double chord = between(-3.0, 3.0);
    const int sort = (int)(k % 4);
    const double a0 = sized(1e-5, 0.25);
    const double a1 = (sort == 0) ? (-a0 * between(0.9, 1.1)) : sized(1e-5, 0.25); /* arcs, and anything */
    const double kappa0 = (sort < 2) ? (((a1 - a0) / way) * between(0.9, 1.1)) : sized(1e-5, 0.3);
    const double kappa1 = (sort < 2) ? (((a1 - a0) / way) * between(0.9, 1.1)) : (sort == 2) ? -kappa0 : sized(1e-5, 0.3);
    const double x1 = way * cos(chord);
    const double y1 = way * sin(chord);
    const double along = chord + between(-0.1, 0.1); /* of the stretch */
    tm_shape shape = {0};
    tm_curve straight;
    tm_straight(&shape, 0.0, 0.0, chord + a0, x1, y1, chord + a1, &straight);
    tm_curve curve = straight;
    tm_curve_of(kappa0, kappa1, length, width, &curve);
    const float du = (float)((cos(along) * x1) + (sin(along) * y1));
    const float dv = (float)((cos(along) * y1) - (sin(along) * x1));
    const float turn0 = (float)((chord + a0) - along);
    const float turn1 = (float)((chord + a1) - along);
    const float corner = (float)(0.5 * sqrt((length * length) + (width * width)));
    const double reach = (double)tm_curve_reach(du, dv, (float)way, tm_about_cosine(turn0), tm_about_sine(turn0), tm_about_cosine(turn1),
                                                tm_about_sine(turn1), (float)(kappa0 * way), (float)(kappa1 * way), corner);
    for (int m = 0; (m < 4) && (reach < TM_INF); ++m) {
      const double ahead = between(-length, way + length);
      const double aside = sized((0.5 * width) + 0.1, width + 3.0);
      const double x = (ahead * cos(chord)) - (aside * sin(chord));
      const double y = (ahead * sin(chord)) + (aside * cos(chord));
      const double gap = away(&straight, 0u, length, width, x, y);
      double margin = TM_INF;
      for (size_t j = 0u; j < curve.count; ++j) {
        margin = tm_least(margin, away(&curve, j, length, width, x, y) - curve.more);
      }
      if (gap > 0.0) {
        ++asked;
        below += ((gap - margin) > reach) ? 1 : 0;
        most = tm_greatest(most, (gap - margin) / reach);
      }
    }
  }
  long told = 0;
  long nearer = 0;
  for (long k = 0; k < (ways / 4); ++k) {
    nearer += nearer_than_said(&told) ? 1 : 0;
  }
  (void)printf("%ld %ld %.17g %ld %ld\n", asked, below, most, told, nearer);
  return 0;
}
