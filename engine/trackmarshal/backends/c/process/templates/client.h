/* The planner's side: hands cycles to a Supervisor that is a process of its own, and takes its decisions. docs/process.md. */
#ifndef TML_CLIENT_H
#define TML_CLIENT_H

#include "mailbox.h"

#include <sys/types.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  tml_region cycles;     /* of shared memory */
  tml_region decisions;
  uint64_t decision_seen;
  uint64_t beat_seen;
  int socket;            /* of datagrams; -1: none */
  tml_waiting how;
  pid_t process;         /* whose it is: a copy in a fork of it sends nothing */
  uint64_t session;
  uint64_t sequence;
  double fixed;          /* s, the clock, where it is simulated; NaN: the machine's */
  uint64_t refused[TML_CAUSES]; /* messages that came and were not taken */
  tml_message out;
#if TML_LINES > 0
  struct {
    uint64_t id;         /* the caller's, of the points that were sent last */
    size_t count;        /* of these points */
    uint64_t version;    /* 0: none was sent, or the Supervisor has it no more */
    uint64_t sent;       /* versions so far */
  } lines[TML_LINES];
#endif
} tml_client;

bool tml_client_memory_of(tml_client *client, uint64_t layout, size_t size, const char *name, tml_waiting how, const char **why);
bool tml_client_datagrams_of(tml_client *client, uint64_t layout, size_t size, unsigned port, const char **why);
/* Connect over shared memory, which a Supervisor has made, or to a port of this machine. False: `why` says what is wrong, also where the
   functions that are linked are another program's, whose clients have other members. */
static inline bool tml_client_memory(tml_client *client, const char *name, tml_waiting how, const char **why) {
  return tml_client_memory_of(client, TML_LAYOUT, sizeof(tml_client), name, how, why);
}
static inline bool tml_client_datagrams(tml_client *client, unsigned port, const char **why) {
  return tml_client_datagrams_of(client, TML_LAYOUT, sizeof(tml_client), port, why);
}
/* Simulated time: what the clock shows from now on, s. */
void tml_client_time(tml_client *client, double now);
/* Hand over a cycle (`now` of it is not read); the sequence of its message. Lines go along when their ids change. 0: it could not be sent, or
   this is a fork of the process that connected, which would count on with the same numbers: it connects anew. */
uint64_t tml_client_send(tml_client *client, const tm_cycle *cycle);
/* Say that time has passed. */
bool tml_client_tick(tml_client *client);
/* Wait for the decision about a message, and no other one, at most so many seconds. False: none came. */
bool tml_client_answer(tml_client *client, uint64_t sequence, double seconds, tml_message *decision);
/* Whatever has come: a decision, or else a sign of life. False: nothing. */
bool tml_client_hear(tml_client *client, tml_message *into, size_t *size);
void tml_client_close(tml_client *client);

#ifdef __cplusplus
}
#endif
#endif
