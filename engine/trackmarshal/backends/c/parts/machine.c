/** The last sample of a trajectory, whose times count from `stamp`, that is due by now, 0 before all. */
static void tm_due_by(const double *t, size_t count, double stamp, double now, size_t *first) {
  *first = 0u;
  for (size_t i = 0u; i < count; ++i) {
    if ((t[i] + stamp) <= now) {
      *first = i;
    }
  }
}

/** Where a trajectory is at a time, straight between its samples. Nothing is changed where it does not cover the time, but `posed`. */
static void tm_pose_at(const double *due, const double *x, const double *y, const double *heading, size_t count, double t,
                       tm_pose *pose) {
  size_t i = 0u;
  if ((count < 2u) || !((due[0] <= t) && (t <= due[count - 1u]))) {
    pose->posed = 0;
  } else {
    for (size_t k = 1u; (k + 1u) < count; ++k) {
      if (due[k] <= t) {
        i = k;
      }
    }
    const double step = due[i + 1u] - due[i];
    const double share = (step > 0.0) ? ((t - due[i]) / step) : 1.0;
    pose->x = x[i] + (share * (x[i + 1u] - x[i]));
    pose->y = y[i] + (share * (y[i + 1u] - y[i]));
    pose->heading = heading[i] + (share * remainder(heading[i + 1u] - heading[i], 6.283185307179586));
  }
}
