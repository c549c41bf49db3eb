/* What the example calls around every step where it is compiled with -DTM_PROBE. */
#ifndef PROBE_H
#define PROBE_H

void tm_probe_start(void);
void tm_probe_stop(void);

#endif
