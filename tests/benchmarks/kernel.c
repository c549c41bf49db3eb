/* The six point-wise rules on one trajectory as a good engineer writes them by hand: one loop, a margin a rule, NaN is unsafe.
   margins: friction [N], turn radius [1/m], drive [m/s^2], braking [m/s^2], speed [m/s], localisation [m], RSS gap [m].
   Returns 1 when all hold. The RSS rule is eq. (1) with the distance and the front vehicle's speed given. */
#include <math.h>
#include <stddef.h>

typedef struct {
  double mass, mu, g, r_min, drag, drive_factor, b_max, v_max, d_loc;
  double response, a_response, b_rear, b_front;
  size_t knots;
  const double *knot, *value;
} kernel_limits;

int kernel(const kernel_limits *l, size_t n, const double *x, const double *y, const double *kappa, const double *v, const double *a,
           const double *grip, double ego_x, double ego_y, double ego_v, double gap, double front_v, double *margins) {
  double friction = INFINITY, turn = INFINITY, drive = INFINITY, brake = INFINITY, speed = INFINITY, near = -INFINITY;
  double bad = 0.0;
  const double tightest = 1.0 / l->r_min;
  size_t at = 0;
  for (size_t i = 0; i < n; ++i) {
    const double lateral = v[i] * v[i] * kappa[i];
    const double force = a[i] + l->drag * (v[i] * v[i]) / l->mass; /* along the road, at the wheels, by mass */
    const double m0 = l->mu * grip[i] * l->mass * l->g - l->mass * sqrt(force * force + lateral * lateral);
    const double m1 = tightest - fabs(kappa[i]);
    const double dx = x[i] - ego_x, dy = y[i] - ego_y;
    const double m5 = l->d_loc - sqrt(dx * dx + dy * dy);
    double ax;
    if (v[i] <= l->knot[0]) {
      ax = l->value[0];
    } else if (v[i] >= l->knot[l->knots - 1]) {
      ax = l->value[l->knots - 1];
    } else {
      while (at > 0 && l->knot[at] > v[i]) { --at; }
      while (at + 2 < l->knots && l->knot[at + 1] <= v[i]) { ++at; }
      ax = l->value[at] + (l->value[at + 1] - l->value[at]) / (l->knot[at + 1] - l->knot[at]) * (v[i] - l->knot[at]);
    }
    const double m2 = l->drive_factor * ax - force;
    const double m3 = a[i] - -l->b_max;
    const double m4 = l->v_max - v[i];
    bad += (m0 + m1 + m2 + m3 + m4 + m5) * 0.0; /* NaN as soon as one is */
    if (m0 < friction) { friction = m0; }
    if (m1 < turn) { turn = m1; }
    if (m2 < drive) { drive = m2; }
    if (m3 < brake) { brake = m3; }
    if (m4 < speed) { speed = m4; }
    if (m5 > near) { near = m5; }
  }
  const double after = ego_v + l->response * l->a_response;
  const double rss = gap + front_v * front_v / (2.0 * l->b_front) -
                     (ego_v * l->response + l->a_response * (l->response * l->response) / 2.0 + after * after / (2.0 * l->b_rear));
  margins[0] = friction;
  margins[1] = turn;
  margins[2] = drive;
  margins[3] = brake;
  margins[4] = speed;
  margins[5] = near;
  margins[6] = rss;
  return bad == 0.0 && friction >= 0.0 && turn >= 0.0 && drive >= 0.0 && brake >= 0.0 && speed >= 0.0 && near >= 0.0 && rss > 0.0;
}

/* So many runs, so that a caller can time them without its own overhead. */
int kernel_many(size_t runs, const kernel_limits *l, size_t n, const double *x, const double *y, const double *kappa, const double *v,
                const double *a, const double *grip, double ego_x, double ego_y, double ego_v, double gap, double front_v, double *margins) {
  int safe = 0;
  for (size_t k = 0; k < runs; ++k) {
    safe += kernel(l, n, x, y, kappa, v, a, grip, ego_x, ego_y, ego_v, gap, front_v, margins);
  }
  return safe;
}
