/* Cycles of a file through a Supervisor that is a process of its own, in real time, timed from before a cycle is packed to when its
   decision has come and been checked. Arguments: file, how often it is gone through, s between cycles, sleep|spin, --shm NAME | --udp PORT. It prints a line a
   cycle: us until the decision, until its arrival at the process, and that the process itself took; the first cycles are left out. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "client.h"
#include "cycles.h"

static tml_client client;
static tml_message answer;

static double monotonic(void) {
  struct timespec now;
  (void)clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + (1e-9 * (double)now.tv_nsec);
}

int main(int argc, char **argv) {
  static tm_configuration configuration;
  const char *why = "";
  long number = 0;
  if (argc != 7) { return 2; }
  const int rounds = atoi(argv[2]);
  const double period = atof(argv[3]);
  const tml_waiting how = (strcmp(argv[4], "spin") == 0) ? TML_WAIT_SPIN : TML_WAIT_SLEEP;
  if (!((strcmp(argv[5], "--shm") == 0) ? tml_client_memory(&client, argv[6], how, &why)
                                        : tml_client_datagrams(&client, (unsigned)atoi(argv[6]), &why))) {
    (void)fprintf(stderr, "%s %s\n", argv[6], why);
    return 1;
  }
  for (int round = 0; round < rounds; ++round) {
    tm_cycle cycle;
    double finished;
    cycles_open(argv[1], &configuration);
    while (cycles_next(&cycle, &finished)) {
      const struct timespec pause = {0, (long)(1e9 * period)};
      if (period > 0.0) { (void)nanosleep(&pause, NULL); }
      const double begin = monotonic();
      cycle.number = number;
      cycle.t = begin;
      const uint64_t sequence = tml_client_send(&client, &cycle);
      if ((sequence == 0u) || !tml_client_answer(&client, sequence, 5.0, &answer)) { return 1; }
      const double end = monotonic();
      const tml_decision *said = &answer.decision;
      if (said->judged != 1) { return 3; }
      if (number >= 100) {
        (void)printf("%.2f %.2f %.2f\n", 1e6 * (end - begin), 1e6 * (said->now - begin), 1e6 * (answer.head.sent - said->now));
      }
      ++number;
    }
  }
  return (fflush(stdout) == 0) ? 0 : 1;
}
