"""Every code of this room."""

from __future__ import annotations

CODES: dict[str, tuple[str, str]] = {
    "T363": (
        "an impact that cannot be told",
        "`trace --impact` holds the project as it is against a revision of it. One of the two is no project, or the one that is here has errors in "
        "its specs or documents, so what it means is not known. A revision with errors is no obstacle: all that they hide counts as changed.",
    ),
}  # fmt: skip
