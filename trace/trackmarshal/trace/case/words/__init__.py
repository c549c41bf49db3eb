"""The fixed words of the document: by language, from files that all have the same names; and the colours of statuses."""

from __future__ import annotations

from collections.abc import Mapping

#: Foreground and ground by the status of cells, on paper and in pictures; the pages have the same in their light dress.
COLOURS: Mapping[str, tuple[str, str]] = {
    "covered": ("#0b6b3a", "#dff3e6"), "waived": ("#1f5673", "#dcedf6"), "partial": ("#7a5200", "#fdf0cf"), "missing": ("#7a3d00", "#fce3cf"),
    "stale": ("#6a3d86", "#f0e4f7"), "failed": ("#a11220", "#fbdfe1"),
}  # fmt: skip

__all__ = ["COLOURS"]
