/* Numbers out of Python's dicts of numpy arrays, by Python's stable ABI (3.11 and later): its names are declared here, so no header is needed.

   Only what is exactly as it is mostly is taken: dicts, arrays of float64 of one axis, floats. For anything else the answer is -1, and
   Python has a closer look. The caller holds Python's lock. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct _object PyObject;
typedef ptrdiff_t Py_ssize_t;
typedef struct {
  void *buf;
  PyObject *obj;
  Py_ssize_t len;
  Py_ssize_t itemsize;
  int readonly;
  int ndim;
  char *format;
  Py_ssize_t *shape;
  Py_ssize_t *strides;
  Py_ssize_t *suboffsets;
  void *internal;
} Py_buffer;

PyObject *PyDict_GetItemWithError(PyObject *dict, PyObject *key);
Py_ssize_t PyDict_Size(PyObject *dict);
PyObject *PyList_GetItem(PyObject *list, Py_ssize_t index);
PyObject *PyObject_Type(PyObject *object);
int PyObject_GetBuffer(PyObject *object, Py_buffer *view, int flags);
void PyBuffer_Release(Py_buffer *view);
double PyFloat_AsDouble(PyObject *object);
PyObject *PyErr_Occurred(void);
void PyErr_Clear(void);
void Py_DecRef(PyObject *object);

enum {
  STRIDED_WITH_FORMAT = 0x0004 | 0x0010 | 0x0008, /* PyBUF_FORMAT, PyBUF_STRIDES (with PyBUF_ND) */
  WRITABLE = 0x0001 /* PyBUF_WRITABLE, of bytes in order */
};

/* What is wanted of one signal: how many fields, whether it is a record of floats, the most entries, the fewest. */
typedef struct {
  int64_t width;
  int64_t record;
  int64_t most;
  int64_t least;
} wanted;

/* Types by place: dict, numpy's array, float, numpy's float64; then the text "id". */
static int is_a(PyObject *object, PyObject *type) {
  PyObject *own = PyObject_Type(object);
  Py_DecRef(own);
  return own == type;
}

/* Copy a column; its length, or -1. */
static Py_ssize_t column(PyObject *array, PyObject *type, double *out, Py_ssize_t room) {
  Py_buffer view;
  Py_ssize_t count = -1;
  if (!is_a(array, type)) { return -1; }
  if (PyObject_GetBuffer(array, &view, STRIDED_WITH_FORMAT) != 0) {
    PyErr_Clear();
    return -1;
  }
  if ((view.ndim == 1) && (view.itemsize == (Py_ssize_t)sizeof(double)) && (view.format != NULL) && (strcmp(view.format, "d") == 0) &&
      (view.shape[0] <= room)) {
    const char *from = (const char *)view.buf;
    count = view.shape[0];
    if (view.strides[0] == (Py_ssize_t)sizeof(double)) {
      if (count > 0) { memcpy(out, from, (size_t)count * sizeof(double)); }
    } else {
      for (Py_ssize_t i = 0; i < count; ++i) { memcpy(&out[i], from + (i * view.strides[0]), sizeof(double)); }
    }
  }
  PyBuffer_Release(&view);
  return count;
}

/* The numbers of all signals, each as (fields, entries), one after the other; `words` get of each where they are, 0, and the entries.
   How many numbers, or -1.

   names and defaults: of all fields, one signal after the other; a field that is `optional` may be left out. */
static int64_t numbers(PyObject *raws, const wanted *signals, int64_t signal_count, PyObject *const *names, const double *defaults,
                       const unsigned char *optional, PyObject *const *types, double *out, uint64_t *words) {
  double *at = out;
  int64_t field = 0;
  for (int64_t s = 0; s < signal_count; ++s) {
    const wanted *one = &signals[s];
    const double *begin = at;
    PyObject *given = PyList_GetItem(raws, (Py_ssize_t)s);
    Py_ssize_t count = one->record ? 1 : -1;
    Py_ssize_t seen = 0;
    if ((given == NULL) || !is_a(given, types[0])) {
      PyErr_Clear();
      return -1;
    }
    for (int64_t f = 0; f < one->width; ++f, ++field) {
      PyObject *value = PyDict_GetItemWithError(given, names[field]);
      if (value == NULL) {
        if (PyErr_Occurred() != NULL) {
          PyErr_Clear();
          return -1;
        }
        if (!optional[field] || (count < 0)) { return -1; }
        for (Py_ssize_t i = 0; i < count; ++i) { *at++ = defaults[field]; }
        continue;
      }
      ++seen;
      if (one->record) {
        if (!is_a(value, types[2]) && !is_a(value, types[3])) { return -1; }
        *at++ = PyFloat_AsDouble(value);
      } else {
        const Py_ssize_t n = column(value, types[1], at, (count < 0) ? (Py_ssize_t)one->most : count);
        if ((n < 0) || ((count >= 0) && (n != count))) { return -1; }
        count = n;
        at += n;
      }
    }
    if (!one->record && (one->least == 0)) { /* of a set: only its elements have ids */
      PyObject *ids = PyDict_GetItemWithError(given, types[4]);
      if (ids != NULL) { ++seen; } else if (PyErr_Occurred() != NULL) { PyErr_Clear(); return -1; }
    }
    /* A key that is no field is for Python to name. */
    if ((seen != PyDict_Size(given)) || (count < (Py_ssize_t)one->least)) { return -1; }
    words[3 * s] = (uint64_t)(uintptr_t)begin;
    words[(3 * s) + 1] = 0u;
    words[(3 * s) + 2] = (uint64_t)count;
  }
  return (int64_t)(at - out);
}

/* The same, into an array of Python's that has room for the most. */
int64_t gather(PyObject *raws, const wanted *signals, int64_t signal_count, PyObject *const *names, const double *defaults,
               const unsigned char *optional, PyObject *const *types, PyObject *array, uint64_t *words) {
  Py_buffer view;
  int64_t count;
  if (PyObject_GetBuffer(array, &view, WRITABLE) != 0) {
    PyErr_Clear();
    return -1;
  }
  count = numbers(raws, signals, signal_count, names, defaults, optional, types, (double *)view.buf, words);
  PyBuffer_Release(&view);
  return count;
}
