/* A cycle's numbers in one place (gather.c), for what else stands in this library. */
#ifndef TRACKMARSHAL_GATHER_H
#define TRACKMARSHAL_GATHER_H

#include "python.h"

/* What is wanted of one signal: how many fields, whether it is a record of floats, the most entries, the fewest (0: a set, whose elements may
   have ids), and whether its elements must have ids. */
typedef struct {
  int64_t width;
  int64_t record;
  int64_t most;
  int64_t least;
  int64_t named;
} wanted;

/* Types, and the text "id". */
typedef struct {
  PyObject *dict;
  PyObject *list;
  PyObject *tuple;
  PyObject *text;
  PyObject *array;
  PyObject *real;
  PyObject *numpy_real;
  PyObject *float64;
  PyObject *id;
} types;

/* All that one reader needs. signals: the two candidates, then those that a cycle has by name, which `called` gives. names and defaults: of all
   fields, one signal after the other; a field that is `optional` may be left out. */
typedef struct {
  const wanted *signals;
  int64_t count;
  PyObject *const *called;
  int64_t fields;
  PyObject *const *names;
  const double *defaults;
  const unsigned char *optional;
  const types *types;
} reading;

/* What is said of a cycle: -1 for one that takes a closer look; else whether all others are as they are remembered, and whether there are no
   more signals; in the bits from IDS on, the signals that have ids. */
enum { REFUSED = -1, UNCHANGED = 1, WHOLE = 2, IDS = 2 };

/* Read a cycle: both candidates, its signals, the known ids of each signal, and what the others were, as (name, names within, objects), or None.
   Its bytes: what is said of it, of each signal where its numbers are in them, 0, and how many entries it has, then the numbers; NULL, without
   an error, for one that takes a closer look. */
INTERNAL PyObject *gathered(const reading *r, PyObject *const *given);

#endif
