"""Why a rule said what it said, in words and numbers: in one cycle, and over a run."""
