"""Parts of a ZIP archive read in memory, with limits; nothing is ever extracted to disk."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content

MAX_MEMBERS = 1000
_ENCRYPTED = 0x1
#: What zipfile raises on damaged input, not all of it documented.
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    OSError,
    ValueError,
    struct.error,
    IndexError,
    OverflowError,
)
_FETCH = "fetch the file again; it was cut off or changed on its way"


class Archive:
    """The directory of a ZIP archive, checked against tricks: D122 to D125."""

    def __init__(self, data: bytes, shown: str) -> None:
        self.shown = shown
        if not data.startswith(b"PK"):
            raise self._error("D122", "not a ZIP archive", "a .saa file is a ZIP archive; is this one?")
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
        except (*_DAMAGE, NotImplementedError) as error:
            raise self._error("D122", f"the archive is damaged: {error}", _FETCH) from error
        before = min((m.header_offset for m in self._zip.infolist()), default=0)
        if (
            before
        ):  # the directory at the end knows nothing of the first of two archives that were put together
            message = f"{before} bytes stand before the first part that the archive names, and would be lost"
            raise self._error("D122", message, "are these two archives in one? Give each by itself")
        self._members = [m for m in self._zip.infolist() if not self._is_ballast(m)]
        if len(self._members) > MAX_MEMBERS:
            raise content.too_large(shown, f"{len(self._members)} parts", MAX_MEMBERS)
        for member in self._members:
            self._check(member)
        total = sum(member.file_size for member in self._members)
        if total > content.MAX_BYTES:
            raise content.too_large(shown, f"the parts unpack to {total} bytes")

    def _error(self, code: str, message: str, help: str) -> TrackmarshalError:
        return TrackmarshalError(code, message, file=self.shown, help=help)

    @staticmethod
    def _is_ballast(member: zipfile.ZipInfo) -> bool:
        """Folders, and the resource forks that macOS puts beside every file."""
        return member.is_dir() or member.filename.startswith("__MACOSX/")

    def _check(self, member: zipfile.ZipInfo) -> None:
        name = member.orig_filename
        parts = name.replace("\\", "/").split("/")
        if ".." in parts or parts[0] == "" or ":" in parts[0] or any(c < " " for c in name):
            raise self._error("D123", f"the name {name!r} leaves the archive's folder", "pack it anew")
        if content.suspicious(member.compress_size, member.file_size):
            what = f"{name}: {member.compress_size} bytes unpack to {member.file_size}"
            raise content.too_large(self.shown, what, content.believed(member.compress_size))

    def name_of(self, suffix: str) -> str | None:
        """The one part with this suffix (upper or lower case), None for none; D123 where there are several."""
        names = [m.filename for m in self._members if m.filename.lower().endswith(suffix)]
        if len(names) > 1:
            listed = ", ".join(names[:4])
            raise self._error("D123", f"{len(names)} parts end in {suffix}: {listed}", "keep one of them")
        return names[0] if names else None

    def read(self, name: str) -> bytes:
        """The content of a part; raises D122, D124 or D125. Counts while it unpacks, whatever size is declared."""
        member = next(m for m in self._members if m.filename == name)
        if member.flag_bits & _ENCRYPTED:
            raise self._error("D125", f"{name} is encrypted", "pack it without a password")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            message = f"{name} is packed by method {member.compress_type}"
            raise self._error("D125", message, "pack it with `deflate`")
        try:
            with self._zip.open(member) as stream:
                data = stream.read(member.file_size + 1)
        except (*_DAMAGE, NotImplementedError, RuntimeError) as error:
            raise self._error("D122", f"{name} is damaged: {error}", _FETCH) from error
        if len(data) != member.file_size:
            message = f"{name} has {len(data)} bytes, the archive declares {member.file_size}"
            raise self._error("D122", message, _FETCH)
        return data
