"""Recordings and scenarios: read the own format and .saa, generate from declarations, ground truth.

`load` is the way in; nothing heavy is imported before it is called.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.files import POINTERS

if TYPE_CHECKING:
    from trackmarshal.scenarios.recording import Recording


def load(path: str | Path, shown: str | None = None) -> Recording:
    """Read a recording, or generate one from its declaration; what it is, is told by its content first.

    `shown` is the path that reports print. Raises D12x to D15x.
    """
    from trackmarshal.scenarios import content

    if not isinstance(path, str | Path):
        raise wrong_type("a recording is read from a path", path)
    if shown is not None and not isinstance(shown, str):
        raise wrong_type("`shown` is a text", shown)
    path = Path(path)
    shown = shown or str(path)
    suffix = path.suffix.lower()
    data = content.read(path, shown, help_=content.ANEW if suffix == ".arrows" else "")
    if data.startswith(POINTERS):
        message = (
            f"`{path.name}` was not fetched: it is the pointer that Git LFS or git-annex leaves in its place"
        )
        help_ = "`git lfs pull`, or `git annex get`; in CI, let the checkout fetch it (`lfs: true`)"
        raise TrackmarshalError("D121", message, file=shown, help=help_)
    if data.startswith((b"PK\x03\x04", b"PK\x05\x06")) or suffix == ".saa":
        from trackmarshal.scenarios import saa

        return saa.read(data, shown)
    if data.startswith(b"\xff\xff\xff\xff"):
        from trackmarshal.scenarios.supervised import recording_of

        return recording_of(data, path.stem, shown)
    if data.startswith(b"\x1f\x8b"):
        from trackmarshal.scenarios import recording_io

        unpacked = content.gunzip(data, shown)
        if unpacked.startswith(b"\xff\xff\xff\xff"):
            help_ = f"unpack it: `gzip -dc {path.name} > unpacked.arrows`"
            raise TrackmarshalError("D121", "this is the record of a run, packed", file=shown, help=help_)
        return recording_io.decode(unpacked, shown)
    if suffix == ".jsonl" or data.startswith(b'{"format":'):
        from trackmarshal.scenarios import recording_io

        return recording_io.decode(data, shown)
    if suffix in (".yaml", ".yml"):
        from trackmarshal.scenarios.field import mapping

        if content.is_of(data, mapping.FORMAT):
            from trackmarshal.scenarios.field.build import build

            return build(mapping.read(path, shown)).recording
        from trackmarshal.scenarios.generate import archived, generate

        if content.is_of(data, archived.FORMAT):
            return archived.load(path, shown)
        return generate(path, shown)
    help_ = (
        "recordings are .saa or .tmrec.jsonl (also .gz), declarations .yaml; "
        "`trackmarshal import log` makes one of a car's log (CSV, MCAP)"
    )
    if suffix == ".sas":
        help_ = "a .sas is a pickle and never opened; use the .saa archive that it came with"
    raise TrackmarshalError("D121", f"`{path.name}` is no recording", file=shown, help=help_)
