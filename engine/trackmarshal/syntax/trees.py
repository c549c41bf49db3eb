"""Syntax trees kept in the user's cache, by what they were made from: the text, and this tool's own sources.

Parsing is a fifth of the time of a `check`. Only trees without any finding are kept, each in a file of its own, as plain data below a
hash of it and of the file's name: one that is damaged, or stands under another one's name, is ignored and made anew.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import time
from functools import cache
from pathlib import Path

from trackmarshal.cache import cache_folder, replace
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import SourceFile
from trackmarshal.syntax import ast
from trackmarshal.syntax.packed import pack, unpack
from trackmarshal.syntax.parser import parse

#: Bytes of kept trees; beyond this, those that were not used for longest are dropped. A line of a spec takes about 250.
BUDGET = 200_000_000
#: After this many seconds a use is noted, so that most uses write nothing.
_NOTED = 86_400.0
#: What a process left behind that was ended while it wrote is swept up after as many seconds.
_ABANDONED = 3_600.0


def parse_kept(file: SourceFile) -> tuple[ast.Module, list[Diagnostic]]:
    """Like `parse`, from the cache where the same text was parsed before."""
    root = cache_folder()
    if root is None:
        return parse(file)
    key = hashlib.sha256(_tool_digest() + file.text.encode("utf-8", "surrogatepass")).hexdigest()
    path = root / "trees" / key
    tree = _load(path, file)
    if tree is not None:
        return tree, []
    tree, found = parse(file)
    if not found:
        _store(path, tree)
    return tree, found


@cache
def _tool_digest() -> bytes:
    """A hash of everything that decides what a tree looks like."""
    here = Path(__file__).parent
    digest = hashlib.sha256()
    names = ("*.py", "*.lark", "*.tables", "../node.py", "../source.py", "../units.py")
    for source in sorted(path for name in names for path in here.glob(name)):
        content = source.read_bytes()
        digest.update(f"{source.name} {len(content)} ".encode() + content)
    return digest.digest()


def _head(name: str, body: bytes) -> bytes:
    return f"trackmarshal tree {hashlib.sha256(name.encode() + body).hexdigest()}".encode()


def _load(path: Path, file: SourceFile) -> ast.Module | None:
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode) or about.st_size > BUDGET:
            return None
        head, _, body = path.read_bytes().partition(b"\n")
        if head != _head(path.name, body):
            return None
        tree = unpack(body, file)
    except (OSError, ValueError):
        return None
    if about.st_mtime < time.time() - _NOTED:
        with contextlib.suppress(OSError):
            os.utime(path)
    return tree


def _store(path: Path, tree: ast.Module) -> None:
    body = pack(tree)
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError:
        return
    if replace(path, _head(path.name, body) + b"\n" + body):
        _swept(path.parent)


@cache
def _swept(folder: Path) -> None:
    """Drop what is over the budget, once a process: looking at all files for each new one would cost more than parsing."""
    kept: list[tuple[float, int, str]] = []
    now = time.time()
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                about = entry.stat()
                abandoned = entry.name.endswith(".tmp") and about.st_mtime < now - _ABANDONED
                # A file takes at least a block of the disk.
                kept.append((0.0 if abandoned else about.st_mtime, max(about.st_size, 4096), entry.path))
    except OSError:
        return  # another process sweeps too
    total = sum(size for _, size, _ in kept)
    for used, size, name in sorted(kept):
        if used and total <= BUDGET:
            break
        total -= size
        with contextlib.suppress(OSError):
            os.unlink(name)
