"""What is made of a project's files, kept from one start to the next for as long as the files are the same."""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from trackmarshal import cache as files_kept
from trackmarshal.cache import cache_folder
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import below, read_regular

T = TypeVar("T")


def kept(
    name: str,
    root: Path,
    folders: Iterable[str],
    files: Iterable[str],
    make: Callable[[], T],
    to_json: Callable[[T], Mapping[str, Any]],
    from_json: Callable[[Any], T],
) -> tuple[T, str]:
    """What is kept under a name, where everything that it was made from is as it was then; else made now, and kept. With it one hash of all
    that it was made from, empty where that is not known.

    folders: below which specs and requirements are looked for. files: what has to be looked at, whether it is there or not.
    """
    path, below_ = files_kept.of_project(name, root), sorted(folders)
    known = None if path is None else _read(path, root, below_)
    if known is not None:
        try:
            return from_json(known), known["state"]
        except (ValueError, KeyError, TypeError, TrackmarshalError):
            pass  # of another version of this program that has the same sources: made again
    looked_for = sorted(files)
    before = None if path is None else _there(root, below_, looked_for)
    with opened(root) as found:
        made = make()
    if path is None:
        return made, ""
    read = sorted({*found, *looked_for})
    state = _state(root, below_, read)
    # What was written while it was read, or came, may be of before or of after: nobody knows which, so it is not kept. Asked behind the hash: what is
    # written from here on is other than that.
    if _there(root, below_, looked_for) == before and not written(root, found):
        files_kept.keep(path, {"files": read, "state": state, **to_json(made)})
        return made, state
    return made, ""


def _there(root: Path, folders: list[str], files: list[str]) -> tuple[str, list[tuple[int, ...]]]:
    """Which specs and documents there are in folders, and what files are like, whether they are there or not."""
    return _state(root, folders, []), [_about(os.path.join(root, name)) for name in files]


#: What says of an `open` that it writes.
_WRITES = os.O_WRONLY | os.O_RDWR
#: How files of programs end, which have a hash of their own.
_PROGRAM = (".py", ".pyc", ".so")
#: Who wants to know which files are opened.
_LISTENING: list[Callable[[str], None]] = []


def _listen(event: str, args: tuple[Any, ...]) -> None:
    if _LISTENING and event == "open" and isinstance(args[0], str | bytes) and not args[2] & _WRITES:
        path = os.fsdecode(args[0])
        if path.endswith(_PROGRAM):  # mostly
            return
        path = os.path.realpath(path)
        for tell in _LISTENING:
            tell(path)


@cache
def _hook() -> None:
    """Listen for files that are opened. Nobody can stop listening, so it is done once."""
    sys.addaudithook(_listen)


@contextmanager
def opened(root: Path) -> Iterator[dict[str, tuple[int, ...]]]:
    """The files that are opened meanwhile to be read, and what each was like then: those below a project's folder by their paths from it, others,
    to which links and `..` lead, by their own. Without those of the cache, of Python and of this program, which has a hash of its own; of a project
    that lies in one of these itself, such as on a disk in memory below `/dev`, every file counts that is in none within it."""
    from trackmarshal.meaning.tool import HERE

    found: dict[str, tuple[int, ...]] = {}
    inside, program, *apart = (
        os.path.join(os.path.realpath(folder), "")
        for folder in (root, HERE, cache_folder() or os.devnull, "/dev", "/proc", "/sys")
    )
    within = tuple(folder for folder in apart if folder.startswith(inside) and folder != inside)
    aside = (*apart, program)

    def tell(path: str) -> None:
        passed_over = path.startswith(within if path.startswith(inside) else aside)
        if not passed_over and not path.endswith(_PROGRAM):
            found.setdefault(path.removeprefix(inside), _about(path))

    _hook()
    _LISTENING.append(tell)
    try:
        yield found
    finally:
        _LISTENING.remove(tell)


def written(root: Path, found: Mapping[str, tuple[int, ...]]) -> list[str]:
    """Of files that were `opened` those that are others now."""
    return [name for name, was in found.items() if _about(os.path.join(root, name)) != was]


def _about(path: str) -> tuple[int, ...]:
    """What is different of a file that was written, or is another one; nothing of one that is not there."""
    try:
        said = os.stat(path)
    except (OSError, ValueError):  # as of a path with a zero character
        return ()
    return said.st_ino, said.st_size, said.st_mtime_ns, said.st_ctime_ns


def _state(root: Path, folders: list[str], files: list[str]) -> str:
    """One hash of the contents of files, of the names of all that lies beside them, and of the specs and documents in folders, and where they are."""
    from trackmarshal.meaning.tool import whole

    digest = hashlib.sha256(whole().encode())

    def take(*said: object) -> None:
        digest.update(json.dumps([str(part) for part in said]).encode())

    for name in files:
        try:
            take(name, hashlib.sha256(read_regular(root / name)).hexdigest())
        except (OSError, ValueError) as error:
            take(name, type(error).__name__)
    for folder in sorted({os.path.dirname(name) for name in files}):
        try:
            take(folder, sorted(os.listdir(root / folder)))
        except (OSError, ValueError) as error:
            take(folder, type(error).__name__)
    for folder in folders:
        try:
            found, problems = below(root / folder, (".spec", ".yaml", ".yml"))
        except ValueError as error:  # what reads the project says what is wrong with it
            take(folder, type(error).__name__)
            continue
        take(folder, found, [problem.filename for problem in problems])
        # A link that leads elsewhere now has the same name as before.
        take(*map(os.path.realpath, sorted({path.parent for path in found})))
        take(*(os.path.realpath(path) for path in found if path.is_symlink()))
    return digest.hexdigest()


def _read(path: Path, root: Path, folders: list[str]) -> Any:
    """What is kept, if it is what was written, and made from what is there now; else None."""
    said = files_kept.kept(path)
    try:
        return said if said["state"] == _state(root, folders, said["files"]) else None
    except (KeyError, TypeError):
        return None


__all__ = ["kept", "opened", "written"]
