"""What is known of a project from its evidence store, and what has to be found out anew: results are used again where all that they were
made from is the same."""

from __future__ import annotations

import json
import platform
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from trackmarshal.cli.evidence import now
from trackmarshal.cli.git import answer
from trackmarshal.errors import TrackmarshalError
from trackmarshal.store import Entry, Store

T = TypeVar("T")

#: What results of earlier versions do not say.
_LATER = ("ranges",)
#: What says where something stands, when it was made, or how the specs are worded, titles included, and not what came out.
_APART = ("file", "line", "created", "spec_fingerprint")
#: What a project is read from.
_READ = ("*.spec", "*.yaml", "*.yml", "*.tmrec.jsonl", "*.tmrec.jsonl.gz")
#: What is read of its requirements.
_DOCUMENTS = ["requirements/*.yaml", "requirements/*.yml"]
#: What stands in the order of the specs.
_IN_ANY_ORDER = ("rules",)


class Answers:
    """The results of a project: those of its store, and those that are found out now, which go there."""

    def __init__(self, root: Path, folder: Path, again: bool = False, specs: Iterable[object] = ()) -> None:
        """again: nothing that is in the store is used, and what comes out differently is told. specs: as `commit` takes them. Raises T295."""
        self._root = root
        self._specs = specs
        self._again = again
        self._new: list[Entry] = []
        self.store = Store(folder)
        #: Entries of the store that came out differently, and in what.
        self.unlike: list[tuple[Entry, str]] = []

    def known(
        self,
        kind: str,
        subject: str,
        inputs: Mapping[str, str],
        whatever: bool,
        read: Callable[[dict[str, Any]], T],
    ) -> T | None:
        """The result that was made from exactly these inputs, `whatever` it was made from if there is no other; None where there is none,
        and where all is to be run again. read: what it is, of what the store holds; what it cannot read is told as broken."""
        while (entry := self._entry(kind, subject, inputs, whatever)) is not None:
            try:
                return read(dict(entry.result))
            except (TrackmarshalError, KeyError):
                self.store.refuse(entry)
        return None

    def _entry(self, kind: str, subject: str, inputs: Mapping[str, str], whatever: bool) -> Entry | None:
        entry = None if self._again else self.store.find(kind, subject, inputs)
        return self.store.latest(kind, subject) if entry is None and whatever else entry

    def learn(
        self, kind: str, subject: str, inputs: Mapping[str, str], result: Mapping[str, Any], params: Mapping[str, float] | None = None
    ) -> None:  # fmt: skip
        """Take in what was found out; it is written by `write`."""
        before = self.store.find(kind, subject, inputs)
        if before is not None:
            unlike = [
                name for name in sorted({*before.result, *result})
                if name not in _APART and not (name in _LATER and name not in before.result)
                and _sorted(name, before.result.get(name)) != _sorted(name, result.get(name))
            ]  # fmt: skip
            if not unlike:
                return
            self.unlike.append((before, unlike[0]))
        made = now()
        self._new.append(
            Entry(kind, subject, dict(inputs), dict(result), "", "", "", made, dict(params or {}))
        )

    def drop(self) -> bool:
        """Take nothing in of what was found out since it was last written; whether there was anything."""
        dropped, self._new = bool(self._new), []
        return dropped

    def write(self) -> None:
        """Add what was found out to the store, with the tool, the commit and the machine that it was found with."""
        if self._new:
            from trackmarshal.meaning import tool

            by = {"tool": tool(), "commit": commit(self._root, self._specs), "platform": _platform()}
            try:
                self.store.add(entry.by(**by) for entry in self._new)
            except OSError as error:
                message = f"the evidence cannot be kept: {error.strerror or error}"
                help_ = "check its permissions and the space left; `trackmarshal trace --as-is` runs nothing, and reads the evidence that is there"
                raise TrackmarshalError("E411", message, file=str(self.store.path), help=help_) from error
            self._new = []


def _sorted(name: str, value: Any) -> Any:
    """A field to be compared: rules in an order that is not that of the specs."""
    if name not in _IN_ANY_ORDER or not isinstance(value, list):
        return value
    return sorted(json.dumps(each, sort_keys=True) for each in value)


def commit(root: Path, specs: Iterable[object] = ()) -> str:
    """The commit of a project's folder, `+` behind it where files that belong to it differ from it, or it lacks specs, documents or recordings that
    are here; empty where there is none. specs: the folders with specs, of which those count that git ignores, too, as they are read all the same."""
    folders = [str(one) for one in specs] or ["specs"]
    ignored = [f"{one}/*.spec" for one in folders if not {"..", "/"} & set(Path(one).parts)] + _DOCUMENTS
    others = ("ls-files", "--others", "--exclude-standard")
    try:
        head = answer(root, "rev-parse", "HEAD").strip()
        differs = answer(
            root, "status", "--porcelain", "--untracked-files=no", "--ignore-submodules=untracked", "."
        )
        more = (
            differs
            or answer(root, *others, "--", *_READ)
            or answer(root, *others, "--ignored", "--", *ignored)
        )
        return head + ("+" if more else "")
    except (OSError, subprocess.SubprocessError):
        return ""


def _platform() -> str:
    """The machine, and the versions of what numbers come from."""
    versions = [
        f"{name} {module.__version__}"
        for name in ("numpy", "shapely")
        if (module := sys.modules.get(name)) is not None
    ]
    return ", ".join([platform.platform(), f"Python {platform.python_version()}", *versions])
