"""The pages that an assessment writes: an index, and one page a replayed run. Reads records; evaluates nothing."""

from trackmarshal.trace.report.pages import write_report

__all__ = ["write_report"]
