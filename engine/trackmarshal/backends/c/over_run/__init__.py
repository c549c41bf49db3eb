"""Rules over the run in C: what their operators keep from one cycle to the next, in memory that is there before the first."""
