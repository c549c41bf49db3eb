"""What an edit of specs changes on recordings: verdicts, margins and decisions, rule by rule, and whether a rule got stricter or weaker.

It is told of what the recordings show, and of nothing else: `equal` means that no cycle of them tells the two apart.
"""

from trackmarshal.comparing.changes import (
    EQUAL,
    GONE,
    MIXED,
    NEW,
    NOT_COMPARABLE,
    STRICTER,
    WEAKER,
    Flip,
    Margins,
    Moment,
    RuleChange,
)
from trackmarshal.comparing.decisions import DecisionChange
from trackmarshal.comparing.judged import Judged, judge
from trackmarshal.comparing.pairs import Comparison, Pair, compare, compared, of_rule

__all__ = [
    "EQUAL", "GONE", "MIXED", "NEW", "NOT_COMPARABLE", "STRICTER", "WEAKER", "Comparison", "DecisionChange", "Flip", "Judged", "Margins", "Moment",
    "Pair", "RuleChange", "compare", "compared", "judge", "of_rule",
]  # fmt: skip
