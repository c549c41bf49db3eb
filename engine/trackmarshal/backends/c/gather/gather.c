/* Numbers out of Python's dicts of numpy arrays.

   Only what is exactly as it is mostly is taken: dicts, arrays of float64 of one axis, floats. For anything else the answer is -1, and
   Python has a closer look. The caller holds Python's lock.

   What is read stands all over the memory: first all of it is looked up, then fetched, then copied, so that one waits for memory once and not
   for every array. */
#include "gather.h"

typedef struct { /* the beginning of numpy's array, the same since numpy 1.0 */
  PyObject head;
  const char *data;
  int ndim;
  const Py_ssize_t *shape;
  const Py_ssize_t *strides;
  PyObject *base;
  PyObject *dtype;
} array;
typedef struct { /* the beginning of what numpy's arrays say of their entries */
  PyObject head;
  PyObject *entry;
  char kind;
  char type;
  char order; /* '=' for this machine's */
} entries;

/* What is looked up and held: of each signal its dict and its ids, the fields, the others; and the words, in the making. Code of a caller's
   that runs meanwhile may have the same reader read something else. */
typedef struct {
  PyObject **signals;
  PyObject **ids;
  PyObject **fields;
  PyObject **others;
  uint64_t *words;
} holding;

static void fetch(const void *object) {
  FETCH(object);
  FETCH((const char *)object + LINE - 1);
}

/* Hold what is found in a dict: looking for the next thing may run code of the caller's, which may take it out of there. */
static PyObject *found(PyObject *dict, PyObject *name, PyObject **place) {
  PyObject *value = PyDict_GetItemWithError(dict, name);
  if (value != NULL) {
    Py_IncRef(value);
    fetch(value);
  }
  *place = value;
  return value;
}

/* Look the fields of all signals up; whether they are all there, and nothing else is. A key that is no field is for Python to name. */
static int looked_up(const reading *r, const holding *h) {
  int64_t field = 0;
  for (int64_t s = 0; s < r->count; ++s) {
    Py_ssize_t seen = 0;
    if (h->signals[s]->type != r->types->dict) { return 0; }
    for (int64_t f = 0; f < r->signals[s].width; ++f, ++field) {
      if (found(h->signals[s], r->names[field], &h->fields[field]) != NULL) {
        ++seen;
      } else if (!r->optional[field] || (PyErr_Occurred() != NULL)) {
        return 0;
      }
    }
    if (!r->signals[s].record && (r->signals[s].least == 0) && (found(h->signals[s], r->types->id, &h->ids[s]) != NULL)) { ++seen; }
    if ((PyErr_Occurred() != NULL) || (seen != PyDict_Size(h->signals[s])) || (r->signals[s].named && (h->ids[s] == NULL))) { return 0; }
  }
  return 1;
}

/* Whether it is an array of one axis of float64, as this machine has them. */
static int is_column(const reading *r, const array *one) {
  return (one->head.type == r->types->array) && (one->ndim == 1) &&
         ((one->dtype == r->types->float64) ||
          ((one->dtype->type == r->types->float64->type) && (((const entries *)one->dtype)->order == '=')));
}

/* Whether all that are no records are columns. Fetch where they say how long they are, then what is in them. */
static int fetched(const reading *r, const holding *h) {
  for (int step = 0; step < 2; ++step) {
    int64_t field = 0;
    for (int64_t s = 0; s < r->count; ++s) {
      for (int64_t f = 0; f < r->signals[s].width; ++f, ++field) {
        const array *one = (const array *)h->fields[field];
        if ((one == NULL) || r->signals[s].record) { continue; }
        if (step == 0) {
          if (!is_column(r, one)) { return 0; }
          FETCH(one->shape);
          FETCH(one->data);
        } else if ((one->strides[0] == (Py_ssize_t)sizeof(double)) && (one->shape[0] <= (Py_ssize_t)r->signals[s].most)) {
          for (Py_ssize_t at = LINE; at < one->shape[0] * (Py_ssize_t)sizeof(double); at += LINE) { FETCH(one->data + at); }
        } else { /* what is spread out is fetched as it is copied */
        }
      }
    }
  }
  return 1;
}

/* How many entries each signal has, and where its numbers are to be; how many bytes there are, or -1 where columns do not fit together. */
static Py_ssize_t laid_out(const reading *r, const holding *h) {
  Py_ssize_t at = (Py_ssize_t)(sizeof(uint64_t) * (size_t)(1 + (3 * r->count)));
  int64_t field = 0;
  for (int64_t s = 0; s < r->count; ++s) {
    const wanted *one = &r->signals[s];
    Py_ssize_t count = one->record ? 1 : -1;
    for (int64_t f = 0; f < one->width; ++f, ++field) {
      const array *value = (const array *)h->fields[field];
      if (one->record || (value == NULL)) {
        if (count < 0) { return -1; } /* nothing says how often a default is wanted */
      } else {
        if ((value->shape[0] > (Py_ssize_t)one->most) || ((count >= 0) && (value->shape[0] != count))) { return -1; }
        count = value->shape[0];
      }
    }
    if (count < (Py_ssize_t)one->least) { return -1; }
    h->words[3 * s] = (uint64_t)at;
    h->words[(3 * s) + 1] = 0u;
    h->words[(3 * s) + 2] = (uint64_t)count;
    at += (Py_ssize_t)one->width * count * (Py_ssize_t)sizeof(double);
  }
  return at;
}

/* Copy the numbers of all signals, each as (fields, entries), one after the other; whether all of records are floats. */
static int copied(const reading *r, const holding *h, char *data) {
  int64_t field = 0;
  for (int64_t s = 0; s < r->count; ++s) {
    const Py_ssize_t count = (Py_ssize_t)h->words[(3 * s) + 2];
    double *at = (double *)(void *)(data + h->words[3 * s]);
    for (int64_t f = 0; f < r->signals[s].width; ++f, ++field, at += count) {
      PyObject *value = h->fields[field];
      const array *column = (const array *)value;
      if (value == NULL) {
        for (Py_ssize_t i = 0; i < count; ++i) { at[i] = r->defaults[field]; }
      } else if (r->signals[s].record) {
        if ((value->type != r->types->real) && (value->type != r->types->numpy_real)) { return 0; }
        *at = PyFloat_AsDouble(value);
      } else if (column->strides[0] == (Py_ssize_t)sizeof(double)) {
        if (count > 0) { memcpy(at, column->data, (size_t)count * sizeof(double)); }
      } else {
        for (Py_ssize_t i = 0; i < count; ++i) { memcpy(&at[i], column->data + (i * column->strides[0]), sizeof(double)); }
      }
    }
  }
  return 1;
}

/* Which signals have ids; REFUSED where they are not the texts that are known of them, in a list. */
static int64_t with_ids(const reading *r, const holding *h, PyObject *known) {
  int64_t have = 0;
  for (int64_t s = 0; s < r->count; ++s) {
    PyObject *ids = h->ids[s];
    PyObject *before = (ids == NULL) ? NULL : PyTuple_GetItem(known, (Py_ssize_t)s);
    const Py_ssize_t count = (Py_ssize_t)h->words[(3 * s) + 2];
    if (ids == NULL) { continue; }
    if ((before == NULL) || (ids->type != r->types->list) || (PyList_Size(ids) != count) || (PyTuple_Size(before) != count)) { return REFUSED; }
    for (Py_ssize_t i = 0; i < count; ++i) {
      PyObject *one = PyList_GetItem(ids, i);
      PyObject *other = PyTuple_GetItem(before, i);
      if ((one != other) && ((one->type != r->types->text) || (PyUnicode_Compare(one, other) != 0))) { return REFUSED; }
    }
    have |= (int64_t)1 << (s + IDS);
  }
  return have;
}

/* Whether what is called so among the signals is the very object that is remembered, or a dict of these and no others. */
static int unchanged(const reading *r, PyObject *signals, PyObject *remembered, PyObject **place) {
  PyObject *names = PyTuple_GetItem(remembered, 1);
  PyObject *before = PyTuple_GetItem(remembered, 2);
  PyObject *given = found(signals, PyTuple_GetItem(remembered, 0), place);
  const Py_ssize_t count = PyTuple_Size(names);
  if (given == NULL) { return 0; }
  if (count == 0) { return given == PyTuple_GetItem(before, 0); }
  if ((given->type != r->types->dict) || (PyDict_Size(given) != count)) { return 0; }
  for (Py_ssize_t i = 0; i < count; ++i) {
    if (PyDict_GetItemWithError(given, PyTuple_GetItem(names, i)) != PyTuple_GetItem(before, i)) { return 0; }
  }
  return 1;
}

/* The bytes of a cycle; NULL for one that takes a closer look. */
static PyObject *read(const reading *r, const holding *h, PyObject *const *given, Py_ssize_t others, int same) {
  PyObject *signals = given[2];
  PyObject *bytes;
  int64_t said;
  Py_ssize_t size;
  for (int64_t f = 0; f < r->fields; ++f) { FETCH(r->names[f]); }
  for (int64_t s = 0; s < 2; ++s) {
    h->signals[s] = given[s];
    Py_IncRef(given[s]);
    fetch(given[s]);
  }
  if (signals->type != r->types->dict) { return NULL; }
  for (int64_t s = 2; s < r->count; ++s) {
    if (found(signals, r->called[s - 2], &h->signals[s]) == NULL) { return NULL; }
  }
  if (!looked_up(r, h) || !fetched(r, h)) { return NULL; }
  for (Py_ssize_t k = 0; k < others; ++k) { /* between fetching and copying */
    same = same && unchanged(r, signals, PyTuple_GetItem(given[4], k), &h->others[k]);
  }
  size = (PyErr_Occurred() == NULL) ? laid_out(r, h) : -1;
  said = (size < 0) ? REFUSED : with_ids(r, h, given[3]);
  bytes = (said == REFUSED) ? NULL : PyBytes_FromStringAndSize(NULL, size);
  if (bytes != NULL) {
    char *data = PyBytes_AsString(bytes);
    said |= same ? UNCHANGED : 0;
    said |= (same && (PyDict_Size(signals) == ((Py_ssize_t)r->count - 2 + others))) ? WHOLE : 0;
    memcpy(data, &said, sizeof said);
    memcpy(data + sizeof said, h->words, 3u * (size_t)r->count * sizeof *h->words);
    if (!copied(r, h, data)) {
      Py_DecRef(bytes);
      bytes = NULL;
    }
  }
  return bytes;
}

PyObject *gathered(const reading *r, PyObject *const *given) {
  const int remembers = (given[4]->type == r->types->tuple);
  const Py_ssize_t others = remembers ? PyTuple_Size(given[4]) : 0;
  const int64_t most = (2 * r->count) + r->fields + (int64_t)others;
  PyObject *held[most];
  uint64_t words[3 * r->count];
  const holding h = {held, &held[r->count], &held[2 * r->count], &held[(2 * r->count) + r->fields], words};
  PyObject *bytes;
  memset(held, 0, sizeof held);
  bytes = read(r, &h, given, others, remembers);
  if (bytes == NULL) { PyErr_Clear(); }
  for (int64_t k = 0; k < most; ++k) {
    if (held[k] != NULL) { Py_DecRef(held[k]); }
  }
  return bytes;
}

/* The bytes of a cycle, or None. */
static PyObject *gather(PyObject *self, PyObject *const *given, Py_ssize_t count) {
  const reading *r = (const reading *)PyLong_AsVoidPtr(self);
  PyObject *bytes = (count == 5) ? gathered(r, given) : NULL;
  if (bytes == NULL) {
    bytes = &_Py_NoneStruct;
    Py_IncRef(bytes);
  }
  return bytes;
}

/* The function for a reader of which all is known; a new reference. */
PyObject *made_gather(const reading *r) {
  static PyMethodDef definition = {"gather", gather, FASTCALL, NULL};
  PyObject *self = PyLong_FromVoidPtr((void *)(uintptr_t)r);
  PyObject *function = (self == NULL) ? NULL : PyCFunction_NewEx(&definition, self, NULL);
  if (self != NULL) { Py_DecRef(self); }
  return function;
}
