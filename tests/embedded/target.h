/* What the target gives: time in ticks of the processor's clock, and the stack. */
#ifndef TARGET_H
#define TARGET_H

#include <stdint.h>

uint64_t ticks(void);

#endif
