"""The baseline: what was accepted last, so that what is demanded and what shows it cannot weaken without a word.

It is a file beside the requirements, written by `accept` only, with who accepted each weakening and why. Additions need no acceptance.
"""

from trackmarshal.trace.baseline.accepting import accepted
from trackmarshal.trace.baseline.change import Change
from trackmarshal.trace.baseline.changes import Tell, changes
from trackmarshal.trace.baseline.check import check
from trackmarshal.trace.baseline.content import Content, carried, content, reported
from trackmarshal.trace.baseline.file import DEFAULT, Acceptance, Baseline, accept, load, read

__all__ = [
    "DEFAULT",
    "Acceptance",
    "Baseline",
    "Change",
    "Content",
    "Tell",
    "accept",
    "accepted",
    "carried",
    "changes",
    "check",
    "content",
    "load",
    "read",
    "reported",
]
