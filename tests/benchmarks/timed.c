/* Runs of a generated step that are timed here, not by a caller whose own code and data would be in the figure. */
#define _POSIX_C_SOURCE 200809L
#include <stddef.h>
#include <stdint.h>
#include <time.h>

/* What the binding calls a step with: addresses, that of a cycle's words the second; and how those begin. */
typedef void step(const uint64_t *bound);
typedef struct {
  int64_t came;
  int64_t numbered;
  int64_t stamped;
  int64_t number;
  double t;
  double now;
} head;

static double reading;

/* The Supervisor's clock: a cycle's verdict is there when it comes. */
double timed_clock(void *user) {
  (void)user;
  return reading;
}

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One cycle after another, the given ones by turns: 0.1 s later each; the CPU seconds of each into `spent`. The cycles' words, `width`
   bytes of each, stand one after the other. Ends early, with the number of the step, where `judged` says that one was refused. */
size_t timed_steps(step *run, uint64_t *bound, int64_t *number, size_t steps, size_t cycles, unsigned char *words, size_t width,
                   const int64_t *judged, double *spent) {
  for (size_t i = 0; i < steps; ++i) {
    head *cycle = (head *)(void *)(words + ((size_t)*number % cycles) * width);
    cycle->number = *number;
    cycle->t = 0.1 * (double)*number;
    cycle->now = cycle->t;
    reading = cycle->t;
    bound[1] = (uint64_t)(uintptr_t)cycle;
    const double before = now();
    run(bound);
    spent[i] = now() - before;
    ++*number;
    if (*judged == 0) {
      return i;
    }
  }
  return steps;
}
