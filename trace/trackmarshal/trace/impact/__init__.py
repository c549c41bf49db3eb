"""What an edit of a project means for its evidence: what changed since another version of it, what has to be made again, and in which order.

Two versions are held against each other by hashes of meaning, so that layout, comments and titles count for nothing. Nothing is evaluated.
"""

from trackmarshal.trace.impact.again import Task
from trackmarshal.trace.impact.changed import Changed
from trackmarshal.trace.impact.codes import CODES
from trackmarshal.trace.impact.compared import Impact, compared
from trackmarshal.trace.impact.version import Version, version

__all__ = ["CODES", "Changed", "Impact", "Task", "Version", "compared", "version"]
