"""Rules over the run on many cycles at once: windows along the cycles, with what crosses from one piece of the run to the next."""
