/* What a step costs on the target: ticks, and the most of the stack; printed one line a step after the example's own output. */
#include "probe.h"

#include <stdio.h>

#include "target.h"

#define PAINT 0xA5A5A5A5u
#define DEEPEST (64u * 1024u) /* bytes of stack that are watched */
#define NEAR 128u             /* bytes that the probe itself needs */

static uint64_t begun;
static uint32_t top;  /* the stack pointer when the step began */
static uint32_t most; /* bytes */

static inline uint32_t here(void) {
  uint32_t pointer;
  __asm__ volatile("mov %0, sp" : "=r"(pointer));
  return pointer;
}

void tm_probe_start(void) {
  top = here();
  for (volatile uint32_t *word = (uint32_t *)(top - DEEPEST); word < (uint32_t *)(top - NEAR); ++word) {
    *word = PAINT;
  }
  begun = ticks();
}

void tm_probe_stop(void) {
  const uint64_t spent = ticks() - begun;
  const volatile uint32_t *word = (uint32_t *)(top - DEEPEST);
  while ((word < (uint32_t *)(top - NEAR)) && (*word == PAINT)) {
    ++word;
  }
  most = top - (uint32_t)word;
  (void)printf("probe %lx %lx %lx\n", (unsigned long)(spent >> 32), (unsigned long)(spent & 0xFFFFFFFFu), (unsigned long)most);
}
