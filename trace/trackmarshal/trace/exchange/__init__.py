"""Requirements to other tools and back: ReqIF, needs.json of sphinx-needs, CSV (docs/exchange.md).

What a list of requirements says crosses whole: ids, texts, links, and what the other tool says beside it, which is kept under `foreign`. What is
not taken over is named. A file that cannot be used is refused, with its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from trackmarshal.files import read_regular
from trackmarshal.trace.exchange import csv_text, needs, reqif_file, yaml_text
from trackmarshal.trace.exchange.content import FIELDS, MAX_BYTES, Document, Naming, of_project, taken
from trackmarshal.trace.exchange.links import check
from trackmarshal.trace.exchange.refused import Refused
from trackmarshal.trace.exchange.replaced import lost
from trackmarshal.trace.exchange.reqif_file import reading, writing
from trackmarshal.trace.findings import Finding

#: Formats, and what names of their files end with.
FORMATS = {"reqif": ".reqif", "needs": ".json", "csv": ".csv"}


def export(documents: Sequence[Document], format: str, project: str, created: datetime) -> bytes:
    """The documents as a file of another tool; raises T352 for texts that the format has no place for, T359 without the package."""
    match format:
        case "reqif":
            return writing.write(documents, project, created, "")
        case "needs":
            return needs.write(documents, project, created)
        case "csv":
            return csv_text.write(documents, "")
        case _:
            raise ValueError(f"unknown format {format!r}")


def read(data: bytes, format: str, shown: str, naming: Naming, found: list[Finding]) -> list[Document]:
    """The documents in a file of another tool; what does not fit, and what is not taken over, goes to `found`, files that cannot be used raise (T350 to T359)."""
    match format:
        case "reqif":
            drafts = reading.read(data, shown, found, naming)
            naming = reqif_file.named(naming)
        case "needs":
            drafts = needs.read(data, shown, found, naming)
        case "csv":
            drafts = csv_text.read(data, shown)
        case _:
            raise ValueError(f"unknown format {format!r}")
    return taken(drafts, naming, shown, found)


def load(path: Path, shown: str) -> bytes:
    """The bytes of a file that is small enough; raises T350 for an archive, T351, OSError."""
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise Refused(
            "T351", f"{size} bytes, the limit is {MAX_BYTES}", shown, help="export fewer requirements at once"
        )
    data = read_regular(path)
    if data.startswith(b"PK\x03\x04"):
        raise Refused(
            "T350",
            "a ZIP archive, as `.reqifz` and the files of spreadsheets are",
            shown,
            help="unpack a `.reqifz`, and import the `.reqif` in it; save a table as `CSV UTF-8`",
        )
    return data


def format_of(path: Path) -> str:
    """The format that a file's name stands for; raises T360."""
    for format, suffix in FORMATS.items():
        if path.suffix.lower() == suffix:
            return format
    known = ", ".join(f"`{suffix}`" for suffix in FORMATS.values())
    raise Refused(
        "T360",
        f"`{path.name}` does not end with {known}: what it holds is not known",
        str(path),
        help="say it with `--format`",
    )


yaml = yaml_text.write

__all__ = [
    "FIELDS",
    "FORMATS",
    "Document",
    "Naming",
    "Refused",
    "check",
    "export",
    "format_of",
    "load",
    "lost",
    "of_project",
    "read",
    "yaml",
]
