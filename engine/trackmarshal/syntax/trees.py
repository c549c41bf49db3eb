"""Syntax trees kept in the user's cache, by what they were made from: the text, and this tool's own sources.

Building the parser and parsing take most of the time of a `check`; a tree that was parsed before takes a millisecond. Only trees
without any finding are kept. A file of the cache that cannot be read is ignored, and made anew.
"""

from __future__ import annotations

import hashlib
import io
import os
import pickle
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from trackmarshal.cache import cache_folder
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import SourceFile
from trackmarshal.syntax import ast
from trackmarshal.syntax.parser import parse

#: Kept trees; beyond this the oldest are dropped.
KEPT = 400


def parse_kept(file: SourceFile) -> tuple[ast.Module, list[Diagnostic]]:
    """Like `parse`, from the cache where the same text was parsed before."""
    folder = cache_folder()
    if folder is None:
        return parse(file)
    key = hashlib.sha256(_tool_digest() + file.text.encode()).hexdigest()
    path = folder / f"tree-{key}.pickle"
    tree = _load(path, file)
    if tree is not None:
        return tree, []
    tree, found = parse(file)
    if not found:
        _store(path, tree, file)
    return tree, found


@cache
def _tool_digest() -> bytes:
    """A hash of everything that decides what a tree looks like."""
    here = Path(__file__).parent
    digest = hashlib.sha256(sys.version.encode())
    for source in sorted([*here.glob("*.py"), *here.glob("*.lark"), *here.parent.glob("*.py")]):
        digest.update(source.read_bytes())
    return digest.digest()


class _Writer(pickle.Pickler):
    """Leaves the source file out: spans get the one that is being read."""

    def persistent_id(self, obj: Any) -> str | None:
        return "file" if isinstance(obj, SourceFile) else None


class _Reader(pickle.Unpickler):
    """Puts a source file in, and builds nothing but nodes of the tree and spans."""

    def __init__(self, data: bytes, file: SourceFile) -> None:
        super().__init__(io.BytesIO(data))
        self._file = file

    def persistent_load(self, pid: str) -> SourceFile:
        return self._file

    def find_class(self, module: str, name: str) -> Any:
        if module == "trackmarshal.syntax.ast" or (module, name) == ("trackmarshal.source", "Span"):
            return super().find_class(module, name)
        if (module, name) in (
            ("copyreg", "__newobj__"),
            ("copyreg", "_reconstructor"),
            ("builtins", "object"),
        ):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} is no part of a tree")


def _load(path: Path, file: SourceFile) -> ast.Module | None:
    try:
        tree = _Reader(path.read_bytes(), file).load()
    except Exception:  # a damaged or foreign file: parse instead
        return None
    return tree if isinstance(tree, ast.Module) else None


def _store(path: Path, tree: ast.Module, file: SourceFile) -> None:
    """Write in a private file and swap, so that a parallel reader never sees half a tree."""
    buffer = io.BytesIO()
    try:
        _Writer(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(tree)
        descriptor, name = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(buffer.getvalue())
        os.replace(name, path)
        kept = sorted(path.parent.glob("tree-*.pickle"), key=lambda p: p.stat().st_mtime)
        for old in kept[: max(0, len(kept) - KEPT)]:
            old.unlink(missing_ok=True)
    except (OSError, RecursionError):
        return
