"""Files on disk: opening nothing but regular ones, and walking folders without leaving anything out."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import stat
import zlib
from collections.abc import Container
from pathlib import Path
from typing import BinaryIO

#: Entries below a folder that are looked at; a link to the root of a disk has more.
MOST_ENTRIES = 200_000

#: How pointers of Git LFS and git-annex begin, which stand in the place of contents that were not fetched.
POINTERS = (b"version https://git-lfs.github.com/spec/", b"/annex/objects/")

#: What git writes before and behind both sides of what it could not merge.
_SIDES = [re.compile(sign + rb"{7}(?:[ \t\r][^\n]*)?$", re.MULTILINE) for sign in (rb"^<", rb"^>")]
UNMERGED = "git left a merge to be settled by hand here, and nobody did"
SETTLE = "keep what is right of both sides, and take the lines `<<<<<<<`, `=======` and `>>>>>>>` out"

_KINDS = (
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def open_regular(path: Path) -> BinaryIO:
    """A regular file, or a link to one, open for reading; raises OSError for anything else, ValueError for a NUL in the path.

    A pipe would be waited for, a device may have no end: neither is ever opened to be read.
    """
    _refuse_special(os.stat(path).st_mode, path)
    # What is there may have changed since: then opening it does not wait, and it is looked at again.
    flags = (
        os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
    )
    descriptor = os.open(path, flags)
    try:
        _refuse_special(os.fstat(descriptor).st_mode, path)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_regular(path: Path, most: int = -1) -> bytes:
    """The bytes of a regular file, at most `most` of them; raises as `open_regular` does."""
    with open_regular(path) as stream:
        return stream.read(most)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file whole or not at all: beside it first, of which nothing is left behind. Raises OSError, with the file's own name.

    Where a link stands, what it leads to is written, and the link stays. What is no file, such as `/dev/stdout`, is written to as it is. Of a file
    that is there, permissions stay, and one that must not be written is not.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(data)
        return
    target = Path(os.path.realpath(path))
    # Names have an end, and processes that share a folder may have one number, each in a container of its own.
    draft = target.with_name(f".{target.name[:50]}.{os.urandom(8).hex()}")
    try:
        if target.is_symlink():
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        if target.exists():
            if not os.access(target, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            draft.touch(0o600)  # nobody reads it meanwhile who must not
            with contextlib.suppress(OSError):  # a disk without permissions
                draft.chmod(stat.S_IMODE(target.stat().st_mode))
        draft.write_bytes(data)
        draft.replace(target)
    except BaseException as error:  # also where somebody interrupts
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def other_there(path: Path, mark: bytes | None) -> bool:
    """Whether an output would take the place of something else: of a file that is not empty, and has the mark of its kind nowhere in its first
    4,096 bytes, unpacked; of any where there is no mark. Who mistypes a name does not lose what is there."""
    if not path.is_file():
        return False
    head = read_regular(path, 4096)
    if head[:2] == b"\x1f\x8b":
        with contextlib.suppress(zlib.error):
            head = zlib.decompressobj(31).decompress(head, 4096)
    return bool(head) and (mark is None or mark not in head)


def digest(data: bytes) -> str:
    """The sha256 of what a file holds. A text holds the same whichever ends of lines a checkout gave it: they are taken for `\\n`."""
    if b"\r\n" in data and b"\0" not in data:
        with contextlib.suppress(UnicodeDecodeError):  # packed or binary: every byte counts
            data.decode("utf-8")
            data = data.replace(b"\r\n", b"\n")
    return hashlib.sha256(data).hexdigest()


def unmerged(data: bytes) -> int:
    """The line of a text from which on git left both sides of a merge; 0 where there is none."""
    begun, ended = _SIDES
    # The pattern is tried at every byte, and nearly no text has what it begins with.
    found = begun.search(data) if b"<" * 7 in data else None
    return data.count(b"\n", 0, found.start()) + 1 if found and ended.search(data, found.end()) else 0


def fetching(path: Path) -> str:
    """How to get what a submodule of git holds that is not checked out, where the path leads into one; empty where it does not."""
    for folder in (path, *path.parents):
        with contextlib.suppress(OSError, ValueError):
            if not folder.is_dir():
                continue
            if any(folder.iterdir()):
                return ""
            folder = folder.resolve()
            for top in folder.parents:
                text = (top / ".gitmodules").read_text("utf-8") if (top / ".gitmodules").is_file() else ""
                name = folder.relative_to(top).as_posix()
                if re.search(rf'^\s*path\s*=\s*"?{re.escape(name)}"?\s*$', text, re.MULTILINE):
                    return f"the submodule `{name}` is not checked out: `git submodule update --init {name}`"
    return ""


def below(folder: Path, suffixes: Container[str]) -> tuple[list[Path], list[OSError]]:
    """Files with one of these suffixes, in upper or lower case, in a folder and all folders in it, in the order of their names.

    Links to folders are followed; each folder is entered once, by its own path where it has one here. With the files comes what kept others
    from being found: folders that cannot be read, links that lead nowhere, more than MOST_ENTRIES. Where an editor has a file open, Emacs puts a
    link beside it, `.#NAME`, that leads nowhere: that is no file.
    """
    found: list[Path] = []
    problems: list[OSError] = []
    entered: set[tuple[int, int]] = set()
    waiting, links = [folder], list[Path]()
    seen = 0
    while waiting or links:
        current = waiting.pop() if waiting else links.pop(0)
        try:
            here = os.stat(current)
            if (here.st_dev, here.st_ino) in entered:
                continue
            entered.add((here.st_dev, here.st_ino))
            with os.scandir(current) as opened:
                entries = sorted(opened, key=lambda entry: entry.name)
        except OSError as problem:
            problems.append(problem)
            continue
        seen += len(entries)
        if seen > MOST_ENTRIES:
            message = f"more than {MOST_ENTRIES} files and folders; does a link lead out of the project?"
            return sorted(found), [*problems, OSError(errno.E2BIG, message, str(folder))]
        for entry in entries:
            path = current / entry.name
            named = path.suffix.lower() in suffixes
            if not named and path.is_dir():
                (links if entry.is_symlink() else waiting).append(path)
            elif entry.is_symlink() and not path.exists():
                if not entry.name.startswith(".#" if named else "."):
                    problems.append(OSError(errno.ENOENT, "a symbolic link that leads nowhere", str(path)))
            elif named:
                found.append(path)
    return sorted(found), problems


def _refuse_special(mode: int, path: Path) -> None:
    if stat.S_ISREG(mode):
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    kind = next((name for test, name in _KINDS if test(mode)), "something else")
    raise OSError(errno.EINVAL, f"{kind}, not a regular file", str(path))
