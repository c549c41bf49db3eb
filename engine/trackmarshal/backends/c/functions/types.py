"""Types that functions of rules are written with, as C."""

from __future__ import annotations

#: What formulas are in C: where everything is known, and where something is not.
TRUTH = """/* Whether a formula holds, and by how much; `doubt`: zero, or NaN where something that it needs is missing. */
typedef struct {
  double margin;
  bool sat;
  double doubt;
} tm_truth;
"""
CASES = """/* The margin of a formula and whether it holds, in the worst and in the best case of what is not known (strong Kleene logic). */
typedef struct {
  double worst;
  double best;
  bool worst_sat;
  bool best_sat;
} tm_cases;
"""
#: Formulas of several samples at once.
SEVERAL = """/* How many samples are worked out at once: as many as a register of the target holds. Results are the same for any number. */
#ifndef TM_SEVERAL
#ifdef __AVX__
#define TM_SEVERAL 4u
#else
#define TM_SEVERAL 1u
#endif
#endif

#if TM_SEVERAL > 1u
/* What holds of all samples, or of one, of each place of a pass by itself: the margin, and `doubt` as above; and what the samples of the
   present pass add: whether they are in range (1, -1), and the margin, NaN where that is not known. */
typedef struct {
  double margin[TM_SEVERAL];
  double doubt[TM_SEVERAL];
  double guard[TM_SEVERAL];
  double body[TM_SEVERAL];
} tm_several;
#endif
"""

#: How often formulas held in C.
TALLY = """/* How often something held, surely and possibly, and whether the count starts anew there. */
typedef struct {
  uint64_t sure;
  uint64_t possible;
  bool surely_anew;
  bool possibly_anew;
} tm_tally;
"""

#: Numbers of many in C, while they are worked out.
FOLD = """/* One number of many, so far; `place`: which one has it, -1.0 where there is none. */
typedef struct {
  double value;
  double place;
  bool some;
} tm_fold;
"""
