/* Runs of a generated step that are timed here, not by a caller whose own code and data would be in the figure. */
#define _POSIX_C_SOURCE 200809L
#include <stddef.h>
#include <stdint.h>
#include <time.h>

typedef int step(void *context, const int64_t *number, const double *times, const size_t *counts, const void *const *columns,
                 const double *numbers, const signed char *flags, double *margins, signed char *verdicts, void *fault);

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One cycle after another, the given ones by turns: 0.1 s later each; the CPU seconds of each into `spent`. The cycles' columns and
   numbers, `width` and `size` of them, stand one after the other. Ends early, with the number of the step, where one is refused. */
size_t timed_steps(step *run, void *context, int64_t *number, size_t steps, size_t cycles, const size_t *counts,
                   const void *const *columns, size_t width, const double *numbers, size_t size, const signed char *flags,
                   double *margins, signed char *verdicts, void *fault, double *spent) {
  for (size_t i = 0; i < steps; ++i) {
    const size_t k = (size_t)*number % cycles;
    const double times[2] = {0.1 * (double)*number, 0.1 * (double)*number};
    const double before = now();
    const int status = run(context, number, times, counts, columns + k * width, numbers + k * size, flags, margins, verdicts, fault);
    spent[i] = now() - before;
    ++*number;
    if (status != 0) {
      return i;
    }
  }
  return steps;
}
