/* What is called of Python, by its stable ABI (3.11 and later): names are declared here, so no header of Python's is needed.

   How objects begin is no part of that ABI; `objects.py` looks whether they do as is taken for granted, before anything is called. */
#ifndef TRACKMARSHAL_PYTHON_H
#define TRACKMARSHAL_PYTHON_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef ptrdiff_t Py_ssize_t;
typedef struct _state PyThreadState;
typedef struct _object PyObject;
struct _object {
  Py_ssize_t references;
  PyObject *type;
};
typedef PyObject *(*function)(PyObject *self, PyObject *const *given, Py_ssize_t count);
typedef struct {
  const char *name;
  function run;
  int flags;
  const char *doc;
} PyMethodDef;

extern PyObject _Py_NoneStruct;
extern PyObject _Py_TrueStruct;
extern PyObject _Py_FalseStruct;
extern PyObject *PyExc_Exception;
extern PyObject *PyExc_ValueError;
PyObject *PyDict_GetItemWithError(PyObject *dict, PyObject *key);
Py_ssize_t PyDict_Size(PyObject *dict);
PyObject *PyList_GetItem(PyObject *list, Py_ssize_t index);
int PyList_SetItem(PyObject *list, Py_ssize_t index, PyObject *item);
Py_ssize_t PyList_Size(PyObject *list);
PyObject *PyTuple_GetItem(PyObject *tuple, Py_ssize_t index);
Py_ssize_t PyTuple_Size(PyObject *tuple);
int PyUnicode_Compare(PyObject *one, PyObject *other);
PyObject *PyNumber_Float(PyObject *object);
PyObject *PyFloat_FromDouble(double number);
double PyFloat_AsDouble(PyObject *object);
long long PyLong_AsLongLong(PyObject *number);
void *PyLong_AsVoidPtr(PyObject *number);
PyObject *PyLong_FromVoidPtr(void *address);
PyObject *PyLong_FromLongLong(long long number);
PyObject *PyBytes_FromStringAndSize(const char *data, Py_ssize_t size);
char *PyBytes_AsString(PyObject *bytes);
int PyBytes_AsStringAndSize(PyObject *bytes, char **data, Py_ssize_t *size);
PyObject *PyType_GenericAlloc(PyObject *type, Py_ssize_t items);
PyObject *PyObject_CallNoArgs(PyObject *callable);
PyObject *PyCFunction_NewEx(PyMethodDef *definition, PyObject *self, PyObject *module);
PyObject *PyErr_Occurred(void);
int PyErr_ExceptionMatches(PyObject *kind);
void PyErr_Clear(void);
void PyErr_SetString(PyObject *kind, const char *message);
PyThreadState *PyEval_SaveThread(void);
void PyEval_RestoreThread(PyThreadState *state);
unsigned long PyThread_get_thread_ident(void);
void Py_IncRef(PyObject *object);
void Py_DecRef(PyObject *object);

enum { FASTCALL = 0x0080, LINE = 64 };

#if defined(__GNUC__)
#define FETCH(address) __builtin_prefetch(address)
#define KEPT __asm__ volatile("") /* a function that only fetches does nothing, as compilers see it */
#define INTERNAL __attribute__((visibility("hidden")))
#else
#define FETCH(address) ((void)(address))
#define KEPT
#define INTERNAL
#endif

#endif
