/* A step of a Supervisor in C, called from Python by its stable ABI (3.11 and later): names are declared here, so no header is needed.

   Python is let go on while the step runs; it is asked for the clock. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct _object PyObject;
typedef struct _state PyThreadState;
typedef ptrdiff_t Py_ssize_t;
typedef PyObject *(*function)(PyObject *self, PyObject *const *given, Py_ssize_t count);
typedef struct {
  const char *name;
  function run;
  int flags;
  const char *doc;
} PyMethodDef;

extern PyObject *PyExc_Exception;
extern PyObject *PyExc_ValueError;
PyThreadState *PyEval_SaveThread(void);
void PyEval_RestoreThread(PyThreadState *state);
PyObject *PyObject_CallNoArgs(PyObject *callable);
PyObject *PyNumber_Float(PyObject *object);
double PyFloat_AsDouble(PyObject *object);
long long PyLong_AsLongLong(PyObject *number);
void *PyLong_AsVoidPtr(PyObject *number);
PyObject *PyLong_FromVoidPtr(void *address);
PyObject *PyLong_FromLongLong(long long number);
int PyBytes_AsStringAndSize(PyObject *bytes, char **data, Py_ssize_t *size);
PyObject *PyErr_Occurred(void);
int PyErr_ExceptionMatches(PyObject *kind);
void PyErr_Clear(void);
void PyErr_SetString(PyObject *kind, const char *message);
void Py_DecRef(PyObject *object);
PyObject *PyCFunction_NewEx(PyMethodDef *definition, PyObject *self, PyObject *module);

enum { FASTCALL = 0x0080 };

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

/* One stepper's: its step and what that is called with, where a cycle's words go, how many signals of it are columns, Python's clock. */
typedef struct {
  void (*step)(const void *bound);
  const void *bound;
  unsigned char *words;
  int64_t signals;
  PyObject *clock;
  PyThreadState *state;
} calling;

/* What the clock says, as float() takes it; NaN where it fails. What is no Exception goes on to whoever asked for the step. */
double clock_reading(void *user) {
  calling *c = (calling *)user;
  double reading = -1.0;
  PyObject *said;
  PyObject *number;
  PyEval_RestoreThread(c->state);
  said = (PyErr_Occurred() == NULL) ? PyObject_CallNoArgs(c->clock) : NULL;
  number = (said == NULL) ? NULL : PyNumber_Float(said);
  if (number != NULL) { reading = PyFloat_AsDouble(number); }
  if (PyErr_Occurred() != NULL) {
    const uint64_t nan = UINT64_C(0x7ff8000000000000);
    memcpy(&reading, &nan, sizeof reading);
    if (PyErr_ExceptionMatches(PyExc_Exception)) { PyErr_Clear(); }
  }
  if (number != NULL) { Py_DecRef(number); }
  if (said != NULL) { Py_DecRef(said); }
  c->state = PyEval_SaveThread();
  return reading;
}

/* Put a cycle's number, stamp, arrival and columns among its words, where they are given, and take the step. The columns are those of an arena
   (`runtime.frame.Arena`), in which it is said where they are. */
static PyObject *call(PyObject *self, PyObject *const *given, Py_ssize_t count) {
  calling *c = (calling *)PyLong_AsVoidPtr(self);
  if (count == 4) {
    head own = {1, 1, 1, 0, 0.0, 0.0, 0u, 0u};
    columns *signals = (columns *)(void *)(c->words + sizeof own);
    const size_t begin = sizeof(uint64_t);
    char *arena = NULL;
    Py_ssize_t size = 0;
    own.number = PyLong_AsLongLong(given[0]);
    own.t = PyFloat_AsDouble(given[1]);
    own.now = PyFloat_AsDouble(given[2]);
    if ((PyErr_Occurred() != NULL) || (PyBytes_AsStringAndSize(given[3], &arena, &size) != 0)) { return NULL; }
    if ((size_t)size < begin + ((size_t)c->signals * sizeof *signals)) {
      PyErr_SetString(PyExc_ValueError, "an arena of other signals");
      return NULL;
    }
    memcpy(c->words, &own, sizeof own);
    memcpy(signals, arena + begin, (size_t)c->signals * sizeof *signals);
    for (int64_t s = 0; s < c->signals; ++s) { signals[s].numbers += (uint64_t)(uintptr_t)arena; }
  }
  c->state = PyEval_SaveThread();
  c->step(c->bound);
  PyEval_RestoreThread(c->state);
  return (PyErr_Occurred() == NULL) ? PyLong_FromLongLong(0) : NULL;
}

/* The function that calls one stepper's step; a new reference. */
PyObject *made(calling *c) {
  static PyMethodDef definition = {"call", (function)call, FASTCALL, NULL};
  PyObject *self = PyLong_FromVoidPtr(c);
  PyObject *function = (self == NULL) ? NULL : PyCFunction_NewEx(&definition, self, NULL);
  if (self != NULL) { Py_DecRef(self); }
  return function;
}
