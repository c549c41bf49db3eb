/* From reset to main: floating point, data, a counter of time; files and arguments come from the host by semihosting. */
#include "target.h"

#include <stdlib.h>
#include <string.h>

#define CPACR (*(volatile uint32_t *)0xE000ED88u)    /* who may use the floating point unit */
#define SYST_CSR (*(volatile uint32_t *)0xE000E010u) /* SysTick: on, with interrupt, by the processor's clock */
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u) /* from where it counts down */
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u) /* where it is */
#define SYST_MOST 0xFFFFFFu
#define SYS_WRITE0 0x04u
#define SYS_GET_CMDLINE 0x15u
#define SYS_EXIT_EXTENDED 0x20u
#define APPLICATION_EXIT 0x20026u
#define FAULTED 99u
#define MOST_ARGUMENTS 7

extern uint32_t data_image[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
extern void initialise_monitor_handles(void); /* the C library's standard streams over semihosting */
extern int main(int argc, char **argv);

void reset(void);
void stuck(void);
void tick(void);
void _init(void);
void _fini(void);

static volatile uint32_t wraps; /* how often SysTick came to zero */

static const struct {
  uint32_t *stack;
  void (*exceptions[15])(void); /* from reset to SysTick; NULL where there is none */
} vectors __attribute__((section(".vectors"), used)) = {
  stack_top,
  {reset, stuck, stuck, stuck, stuck, stuck, NULL, NULL, NULL, NULL, stuck, stuck, NULL, stuck, tick},
};

static int host(uint32_t operation, const void *argument) {
  register uint32_t r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return (int)r0;
}

/* The C library calls these at start and end. */
void _init(void) {}
void _fini(void) {}

void tick(void) { ++wraps; }

/* Any exception of the processor: say so and end. */
void stuck(void) {
  const uint32_t reason[2] = {APPLICATION_EXIT, FAULTED};
  (void)host(SYS_WRITE0, "the processor took an exception\n");
  (void)host(SYS_EXIT_EXTENDED, reason);
  for (;;) {
  }
}

uint64_t ticks(void) {
  uint32_t before;
  uint32_t now;
  do {
    before = wraps;
    now = SYST_CVR;
  } while (before != wraps);
  return ((uint64_t)before * (SYST_MOST + 1u)) + (SYST_MOST - now);
}

void reset(void) {
  static char line[512];
  static char *arguments[MOST_ARGUMENTS + 1];
  const struct {
    char *text;
    uint32_t size;
  } wanted = {line, sizeof(line)};
  int count = 0;
  CPACR |= 0xFu << 20;
  __asm__ volatile("dsb\n isb");
  (void)memcpy(data_begin, data_image, (size_t)((char *)data_end - (char *)data_begin));
  (void)memset(bss_begin, 0, (size_t)((char *)bss_end - (char *)bss_begin));
  SYST_RVR = SYST_MOST;
  SYST_CVR = 0u;
  SYST_CSR = 7u;
  initialise_monitor_handles();
  if (host(SYS_GET_CMDLINE, &wanted) == 0) {
    for (char *word = strtok(line, " "); (word != NULL) && (count < MOST_ARGUMENTS); word = strtok(NULL, " ")) {
      arguments[count] = word;
      ++count;
    }
  }
  exit(main(count, arguments));
}
