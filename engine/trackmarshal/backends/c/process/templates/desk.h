/* The Supervisor behind its messages, without any input or output: a message in, a decision out. docs/process.md. */
#ifndef TML_DESK_H
#define TML_DESK_H

#include "messages.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Everything that is kept. One desk serves one thread. */
typedef struct {
  tm_context context;
  tm_decision said;
  tml_message out;        /* the last message that was made */
  uint64_t session;       /* own */
  bool simulated;         /* the clock is that of the messages */
  double read;            /* s, that clock */
  uint64_t client;        /* session of the newest client; 0: none yet */
  uint64_t taken_last;    /* sequence of its last cycle or tick */
  uint64_t decided;       /* decisions that were made */
  uint64_t beats;
  uint64_t taken;
  uint64_t refused[TML_CAUSES];
  uint64_t wanted;        /* lines that the last cycle named and that are not known */
  double overdue;         /* s, when the next cycle will be; NaN or infinite: never */
  uint64_t ids;           /* counts lines that were taken */
#if TML_LINES > 0
  struct {
    tml_line in;
    uint64_t version;     /* 0: none is known */
    uint64_t id;
  } lines[TML_LINES];
  tml_message fetched;    /* the last line that was asked for */
#endif
} tml_desk;

/* What asks for a line of a version that the desk does not know, before the cycle that names it is decided; NULL: nobody is asked.
   True where a message was put into `into`, of `size` bytes. */
typedef bool (*tml_fetch)(void *user, size_t slot, tml_message *into, size_t *size);

/* Start anew. False: the configuration that was compiled in cannot stand; `which` names what of it. */
bool tml_desk_start(tml_desk *desk, uint64_t session, bool simulated, const char **which);
/* The desk's clock, s: the machine's monotonic clock, or that of the messages. */
double tml_desk_clock(const tml_desk *desk);
/* One message that came. Where it is a cycle that is taken, it is decided about: `desk->out` is the decision, and true is returned. */
bool tml_desk_take(tml_desk *desk, const tml_message *message, size_t size, tml_fetch fetch, void *user, tml_cause *cause);
/* Whether a cycle is overdue by now; then this is decided about, and `desk->out` is the decision. */
bool tml_desk_overdue(tml_desk *desk);
/* Make a sign of life in `desk->out`. */
void tml_desk_beat(tml_desk *desk);

#ifdef __cplusplus
}
#endif
#endif
