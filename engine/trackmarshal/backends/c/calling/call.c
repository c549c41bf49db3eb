/* A step of a Supervisor in C, called from Python. Python is let go on while the step runs; it is asked for the clock. */
#include "call.h"

/* The words that every cycle begins with (`binding.HEAD`). */
typedef struct {
  int64_t came;
  int64_t numbered;
  int64_t stamped;
  int64_t number;
  double t;
  double now;
  uint64_t found;
  uint64_t found_count;
} head;

/* The words of a signal that is columns: where its numbers are, where its flags are, how many entries it has. */
typedef struct {
  uint64_t numbers;
  uint64_t flags;
  uint64_t count;
} columns;

/* Where an arena says where columns are. */
enum { BEGIN = sizeof(uint64_t) };

PyObject *clock_said(const calling *c) {
  PyObject *said = PyObject_CallNoArgs(c->clock);
  PyObject *number = (said == NULL) ? NULL : PyNumber_Float(said);
  if (said != NULL) { Py_DecRef(said); }
  if ((number == NULL) && PyErr_ExceptionMatches(PyExc_Exception)) { PyErr_Clear(); }
  return number;
}

/* What the clock says; NaN where it fails. What is no Exception goes on to whoever asked for the step. */
double clock_reading(void *user) {
  calling *c = (calling *)user;
  const uint64_t nan = UINT64_C(0x7ff8000000000000);
  double reading;
  PyObject *number;
  memcpy(&reading, &nan, sizeof reading);
  PyEval_RestoreThread(c->state);
  number = (PyErr_Occurred() == NULL) ? clock_said(c) : NULL;
  if (number != NULL) {
    reading = PyFloat_AsDouble(number);
    Py_DecRef(number);
  }
  c->state = PyEval_SaveThread();
  return reading;
}

static void run(calling *c) {
  c->state = PyEval_SaveThread();
  c->step(c->bound);
  PyEval_RestoreThread(c->state);
}

/* The columns are those of the arena, in which it is said where they are. */
void step_of(calling *c, int64_t number, double t, double now, const char *arena) {
  const head own = {1, 1, 1, number, t, now, 0u, 0u};
  columns *signals = (columns *)(void *)(c->words + sizeof own);
  memcpy(c->words, &own, sizeof own);
  memcpy(signals, arena + BEGIN, (size_t)c->signals * sizeof *signals);
  for (int64_t s = 0; s < c->signals; ++s) { signals[s].numbers += (uint64_t)(uintptr_t)arena; }
  run(c);
}

/* Take the step of a cycle's number, stamp, arrival and columns, where they are given, or of the words as they are. */
static PyObject *call(PyObject *self, PyObject *const *given, Py_ssize_t count) {
  calling *c = (calling *)PyLong_AsVoidPtr(self);
  if (count == 4) {
    char *arena = NULL;
    Py_ssize_t size = 0;
    const int64_t number = PyLong_AsLongLong(given[0]);
    const double t = PyFloat_AsDouble(given[1]);
    const double now = PyFloat_AsDouble(given[2]);
    if ((PyErr_Occurred() != NULL) || (PyBytes_AsStringAndSize(given[3], &arena, &size) != 0)) { return NULL; }
    if ((size_t)size < BEGIN + ((size_t)c->signals * sizeof(columns))) {
      PyErr_SetString(PyExc_ValueError, "an arena of other signals");
      return NULL;
    }
    step_of(c, number, t, now, arena);
  } else {
    run(c);
  }
  return (PyErr_Occurred() == NULL) ? PyLong_FromLongLong(0) : NULL;
}

/* The function that calls one stepper's step; a new reference. */
PyObject *made_call(calling *c) {
  static PyMethodDef definition = {"call", call, FASTCALL, NULL};
  PyObject *self = PyLong_FromVoidPtr(c);
  PyObject *function = (self == NULL) ? NULL : PyCFunction_NewEx(&definition, self, NULL);
  if (self != NULL) { Py_DecRef(self); }
  return function;
}
