/* A whole step of a Supervisor as most of them are, in one call from Python: a cycle is read, the step taken, and the Decision made of a cycle
   that is safe. Whatever else comes is for Python, which goes on from where this has left off.

   Between two steps a planner has had all caches, so nothing costs as much as touching memory and code: what is needed is fetched ahead,
   attributes are read where they stand, and what few ask of a decision is not made before it is asked for. */
#include "call.h"
#include "gather.h"

/* The words of what is said (`binding.SAID`). */
typedef struct {
  int64_t serial;
  int64_t state;
  int64_t safe;
  int64_t driven;
  int64_t first;
  int64_t driven_number;
  double driven_t;
  int64_t stored;
  int64_t stored_number;
  double stored_t;
  int64_t lost;
  double now;
  double finished;
  double valid_until;
  int64_t judged;
  int64_t fault_count;
  int64_t reason_count;
  int64_t more;
} said_words;

/* Memory that a step will read. */
typedef struct {
  const char *begin;
  int64_t size;
} stretch;

/* Types and objects that never change. real: float; whole: int. */
typedef struct {
  PyObject *cycle;
  PyObject *whole;
  PyObject *real;
  PyObject *decision;
  PyObject *plan;
  PyObject *frame;
  PyObject *arena;
  PyObject *judged;
  PyObject *said;
  PyObject *driving;
  PyObject *emergency;
  PyObject *drive;
  PyObject *no_text;
  PyObject *none_of_them;
  PyObject *nan;
  PyObject *explaining;
  PyObject *advisory;
} constants;

/* Where attributes stand in the memory of their objects; of a tuple the first item, of a float its number, of bytes the first byte. */
typedef struct {
  int64_t number;
  int64_t t;
  int64_t driving;
  int64_t emergency;
  int64_t signals;
  int64_t plan_of;
  int64_t plan_candidate;
  int64_t plan_number;
  int64_t plan_t;
  int64_t frame_settings;
  int64_t frame_arena;
  int64_t frame_lines;
  int64_t frame_closed;
  int64_t frame_events;
  int64_t said_explaining;
  int64_t said_advisory;
  int64_t said_frame;
  int64_t said_copied;
  int64_t items;
  int64_t real;
  int64_t bytes;
} places;

/* What a cycle is held against, in a tuple that Python makes when the cycles before were alike: ids that are known of each signal, what the
   others were, the shape of arenas, and the settings, lines, closed and events of frames. */
enum { KNOWN, REMEMBERED, SHAPE, SETTINGS, LINES, CLOSED, EVENTS };

/* One Supervisor's. said: with outcome bytes of margins and verdicts behind it. expected: what is said of a cycle like those before, which has
   `armed`; NULL: every cycle is for Python. steps, last: how many were taken, and the clock's last reading. stored: a list of the trajectory
   that may be fallen back to, or None. left: a list of the clock's reading; the frame, or the decision where it is to be recorded; number and
   stamp: None for what is not left. decides: whether no rule is advisory. taker: the thread that is taking a step, 0: none. */
typedef struct {
  const reading *reading;
  calling *calling;
  const constants *is;
  const places *at;
  const said_words *said;
  int64_t outcome;
  const stretch *stretches;
  int64_t stretch_count;
  PyObject *armed;
  int64_t expected;
  int64_t steps;
  double last;
  PyObject *stored;
  PyObject *left;
  int64_t decides;
  int64_t recorded;
  uint64_t taker;
} quick;

static PyObject *member(const void *object, int64_t place) {
  PyObject *found;
  memcpy(&found, (const char *)object + place, sizeof found);
  return found;
}

/* Put an object into a place that is empty; it is held there. */
static void put(void *object, int64_t place, PyObject *item) {
  Py_IncRef(item);
  memcpy((char *)object + place, &item, sizeof item);
}

static PyObject *item(const quick *q, PyObject *tuple, int64_t index) {
  return member(tuple, q->at->items + (index * (int64_t)sizeof(PyObject *)));
}

static double number_of(const quick *q, PyObject *real) {
  double number;
  memcpy(&number, (const char *)real + q->at->real, sizeof number);
  return number;
}

/* Have on its way what every step reads, in the order in which it does. */
static void fetch_ahead(const quick *q) {
  for (int64_t k = 0; k < q->stretch_count; ++k) {
    for (int64_t at = 0; at < q->stretches[k].size; at += LINE) { FETCH(q->stretches[k].begin + at); }
    KEPT;
  }
}

static PyObject *plan_of(const quick *q, PyObject *candidate, PyObject *number, PyObject *t, PyObject *frame) {
  PyObject *made = PyType_GenericAlloc(q->is->plan, 0);
  if (made != NULL) {
    put(made, q->at->plan_candidate, candidate);
    put(made, q->at->plan_number, number);
    put(made, q->at->plan_t, t);
    put(made, q->at->plan_of, frame);
  }
  return made;
}

/* The frame of an arena's bytes, whose columns are made when somebody asks for them (`Frame.unread`). */
static PyObject *frame_of(const quick *q, PyObject *armed, PyObject *bytes) {
  PyObject *arena = PyType_GenericAlloc(q->is->arena, 2);
  PyObject *made = (arena == NULL) ? NULL : PyType_GenericAlloc(q->is->frame, 0);
  if (arena != NULL) {
    put(arena, q->at->items, bytes);
    put(arena, q->at->items + (int64_t)sizeof(PyObject *), item(q, armed, SHAPE));
  }
  if (made != NULL) {
    put(made, q->at->frame_settings, item(q, armed, SETTINGS));
    put(made, q->at->frame_arena, arena);
    put(made, q->at->frame_lines, item(q, armed, LINES));
    put(made, q->at->frame_closed, item(q, armed, CLOSED));
    put(made, q->at->frame_events, item(q, armed, EVENTS));
  }
  if (arena != NULL) { Py_DecRef(arena); }
  return made;
}

/* What was said of a frame, to be taken apart when somebody asks. */
static PyObject *judged_of(const quick *q, PyObject *frame) {
  PyObject *copied = PyBytes_FromStringAndSize((const char *)(q->said + 1), (Py_ssize_t)q->outcome);
  PyObject *said = (copied == NULL) ? NULL : PyType_GenericAlloc(q->is->said, 0);
  PyObject *made = (said == NULL) ? NULL : PyType_GenericAlloc(q->is->judged, 2);
  if (said != NULL) {
    put(said, q->at->said_explaining, q->is->explaining);
    put(said, q->at->said_advisory, q->is->advisory);
    put(said, q->at->said_frame, frame);
    put(said, q->at->said_copied, copied);
  }
  if (made != NULL) {
    put(made, q->at->items, frame);
    put(made, q->at->items + (int64_t)sizeof(PyObject *), said);
  }
  if (said != NULL) { Py_DecRef(said); }
  if (copied != NULL) { Py_DecRef(copied); }
  return made;
}

/* The Decision of a cycle that is safe; NULL and an error where there is no memory. Its emergency trajectory is stored from now on. */
static PyObject *decided(const quick *q, PyObject *number, PyObject *t, PyObject *now, PyObject *frame) {
  enum { FIELDS = 15 };
  PyObject *driving = plan_of(q, q->is->driving, number, t, frame);
  PyObject *emergency = (driving == NULL) ? NULL : plan_of(q, q->is->emergency, number, t, frame);
  PyObject *judged = (emergency == NULL) ? NULL : judged_of(q, frame);
  PyObject *finished = (judged == NULL) ? NULL : PyFloat_FromDouble(q->said->finished);
  PyObject *until = (finished == NULL) ? NULL : PyFloat_FromDouble(q->said->valid_until);
  PyObject *made = (until == NULL) ? NULL : PyType_GenericAlloc(q->is->decision, FIELDS);
  if (made != NULL) {
    PyObject *const none = q->is->none_of_them;
    PyObject *const fields[FIELDS] = {
        number, t, now, finished, q->is->drive, &_Py_TrueStruct, driving, emergency, until, q->is->no_text, none, none, &_Py_FalseStruct, judged, none};
    for (int64_t k = 0; k < FIELDS; ++k) { put(made, q->at->items + (k * (int64_t)sizeof(PyObject *)), fields[k]); }
    Py_IncRef(emergency);
    (void)PyList_SetItem(q->stored, 0, emergency);
  }
  for (int64_t k = 0; k < 5; ++k) {
    PyObject *const own[5] = {until, finished, judged, emergency, driving};
    if (own[k] != NULL) { Py_DecRef(own[k]); }
  }
  return made;
}

/* Whether a cycle is safe, nothing is said against it, and what is driven and stored is of this very cycle. */
static int all_well(const quick *q, int64_t number, double t, double now) {
  enum { DRIVE = 1, THIS = 1 };
  const said_words *s = q->said;
  return (s->serial == q->steps) && (s->safe == 1) && (s->judged == 1) && (s->state == DRIVE) && (s->driven == THIS) && (s->driven_number == number) &&
         (s->driven_t == t) && (s->stored == 1) && (s->stored_number == number) && (s->stored_t == t) && (s->now == now) && (s->lost == 0) &&
         (s->fault_count == 0) && (s->reason_count == 0) && (s->more == 0);
}

/* A cycle's own: what its attributes are, held, and its number. */
typedef struct {
  PyObject *number;
  PyObject *t;
  PyObject *given[3];
  int64_t count;
} held_cycle;

/* Hold a cycle's attributes, which code of the caller's that runs meanwhile may change; whether it is a Cycle, with number and stamp as they
   should be (`door.stamp_of`). */
static int hold(const quick *q, PyObject *cycle, held_cycle *own) {
  const places *at = q->at;
  const int64_t attributes[5] = {at->number, at->t, at->driving, at->emergency, at->signals};
  PyObject **const into[5] = {&own->number, &own->t, &own->given[0], &own->given[1], &own->given[2]};
  int whole = 1;
  memset(own, 0, sizeof *own);
  if (cycle->type != q->is->cycle) { return 0; }
  for (int64_t k = 0; k < 5; ++k) {
    *into[k] = member(cycle, attributes[k]);
    if (*into[k] != NULL) {
      Py_IncRef(*into[k]);
    } else {
      whole = 0;
    }
  }
  if (!whole || (own->number->type != q->is->whole) || (own->t->type != q->is->real)) { return 0; }
  own->count = PyLong_AsLongLong(own->number);
  if ((own->count == -1) && (PyErr_Occurred() != NULL)) {
    PyErr_Clear();
    return 0;
  }
  return own->count != INT64_MIN;
}

static void let_go(held_cycle *own) {
  PyObject *const all[5] = {own->number, own->t, own->given[0], own->given[1], own->given[2]};
  for (int64_t k = 0; k < 5; ++k) {
    if (all[k] != NULL) { Py_DecRef(all[k]); }
  }
}

/* What comes of a cycle that is held, at the clock's reading: the Decision, or the frame where the step is taken and it is for Python to say
   what was decided; NULL where it is for Python to look closer, or with an error. */
static PyObject *taken(quick *q, PyObject *armed, const held_cycle *own, PyObject *now) {
  PyObject *const given[5] = {own->given[0], own->given[1], own->given[2], item(q, armed, KNOWN), item(q, armed, REMEMBERED)};
  PyObject *bytes = gathered(q->reading, given);
  PyObject *frame;
  PyObject *decision = NULL;
  const char *arena = (bytes == NULL) ? NULL : (const char *)bytes + q->at->bytes;
  const double clock = number_of(q, now);
  const double stamp = number_of(q, own->t);
  int64_t said = REFUSED;
  if (bytes != NULL) { memcpy(&said, arena, sizeof said); }
  frame = ((bytes != NULL) && (said == q->expected) && (q->armed == armed)) ? frame_of(q, armed, bytes) : NULL;
  if (bytes != NULL) { Py_DecRef(bytes); }
  if (frame == NULL) {
    PyErr_Clear(); /* where there was no memory for it: Python tries again */
    return NULL;
  }
  ++q->steps;
  step_of(q->calling, own->count, stamp, clock, arena);
  if ((PyErr_Occurred() == NULL) && q->decides && all_well(q, own->count, stamp, clock)) {
    decision = decided(q, own->number, own->t, now, frame);
    if (decision != NULL) {
      q->last = q->said->finished;
    } else {
      PyErr_Clear(); /* Python tries again */
    }
  }
  if ((decision == NULL) && (PyErr_Occurred() == NULL)) { return frame; }
  Py_DecRef(frame);
  return decision;
}

/* Leave Python what it goes on with. */
static void leave(const quick *q, PyObject *now, PyObject *made, const held_cycle *own) {
  PyObject *const left[4] = {now, made, own->number, own->t};
  for (Py_ssize_t k = 0; k < 4; ++k) {
    if (left[k] != NULL) {
      Py_IncRef(left[k]);
      (void)PyList_SetItem(q->left, k, left[k]);
    }
  }
}

/* What is driven, of a cycle; None where Python has to go on, with what is left, and to `release` in the end; False where a step is being taken:
   Python is let go on while C takes one, and what callers hand in has code of its own. */
static PyObject *step(PyObject *self, PyObject *const *given, Py_ssize_t count) {
  quick *q = (quick *)PyLong_AsVoidPtr(self);
  PyObject *armed = q->armed;
  PyObject *made = NULL;
  PyObject *now;
  held_cycle own;
  if (count != 1) {
    PyErr_SetString(PyExc_ValueError, "a step is of one cycle");
    return NULL;
  }
  if (q->taker != 0u) {
    Py_IncRef(&_Py_FalseStruct);
    return &_Py_FalseStruct;
  }
  q->taker = (uint64_t)PyThread_get_thread_ident();
  if (armed != NULL) {
    fetch_ahead(q);
    Py_IncRef(armed);
    now = clock_said(q->calling);
    if ((now == NULL) && (PyErr_Occurred() == NULL)) {
      now = q->is->nan;
      Py_IncRef(now);
    }
    if (now != NULL) {
      made = hold(q, given[0], &own) ? taken(q, armed, &own, now) : NULL;
      if ((PyErr_Occurred() == NULL) && ((made == NULL) || (made->type != q->is->decision) || q->recorded)) {
        leave(q, now, made, &own);
        if (made != NULL) { Py_DecRef(made); }
        made = NULL;
      }
      let_go(&own);
      Py_DecRef(now);
    }
    Py_DecRef(armed);
    if ((made != NULL) || (PyErr_Occurred() != NULL)) { q->taker = 0u; }
    if (PyErr_Occurred() != NULL) { return NULL; }
  }
  if (made == NULL) {
    made = &_Py_NoneStruct;
    Py_IncRef(made);
  }
  return made;
}

/* The function of one Supervisor; a new reference. */
PyObject *made_quick(quick *q) {
  static PyMethodDef definition = {"step", step, FASTCALL, NULL};
  PyObject *self = PyLong_FromVoidPtr(q);
  PyObject *function = (self == NULL) ? NULL : PyCFunction_NewEx(&definition, self, NULL);
  if (self != NULL) { Py_DecRef(self); }
  return function;
}
