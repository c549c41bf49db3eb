"""The pages that an assessment writes: an index, and one page a replayed run. Reads records; evaluates nothing."""

from trackmarshal.trace.report.pages import page_addresses, write_report

__all__ = ["page_addresses", "write_report"]
