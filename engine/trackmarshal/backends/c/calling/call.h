/* A step of a Supervisor in C (call.c), for what else stands in this library. */
#ifndef TRACKMARSHAL_CALL_H
#define TRACKMARSHAL_CALL_H

#include "python.h"

/* One stepper's: its step and what that is called with, where a cycle's words go, how many signals of it are columns, Python's clock. */
typedef struct {
  void (*step)(const void *bound);
  const void *bound;
  unsigned char *words;
  int64_t signals;
  PyObject *clock;
  PyThreadState *state;
} calling;

/* What the clock says, as float() takes it; NULL, or NULL and an error that is no Exception, where it fails. */
INTERNAL PyObject *clock_said(const calling *c);
/* Take the step of a cycle whose columns stand in an arena (`runtime.frame.Arena`). */
INTERNAL void step_of(calling *c, int64_t number, double t, double now, const char *arena);

#endif
