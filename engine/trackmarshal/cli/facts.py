"""What a project's specs, scenarios and campaigns say, as far as the matrix is concerned, kept from one start to the next.

To know that a rule has not changed, it need not be compiled again: the files are the same that were read then.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cache import cache_folder, replace
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import below, read_regular
from trackmarshal.records import FaultCase, SpecItem, SpecPart, SpecTest

if TYPE_CHECKING:
    from trackmarshal.trace import Finding


@dataclass(frozen=True)
class Facts:
    """Rules, what they read, tests, by scenario what it is replayed with, faults, and what is wrong with the specs."""

    items: list[SpecItem]
    parts: list[SpecPart]
    tests: list[SpecTest]
    run_inputs: dict[str, dict[str, str]]
    fault_cases: list[FaultCase]
    findings: list[Finding]

    @cached_property
    def _rules(self) -> dict[str, SpecItem]:
        """By name; of two with one name the first counts, as everywhere."""
        return {item.name: item for item in reversed(self.items)}

    def of_test(self, test: SpecTest) -> dict[str, str]:
        """What the result of a test is made from."""
        from trackmarshal.meaning.tool import tool

        return test.made_from(self._rules[test.rule].inputs, tool())


def facts(root: Path, folders: Iterable[str], files: Iterable[str], make: Callable[[], Facts]) -> Facts:
    """The facts of a project: those that are kept, where everything that they were made from is as it was then; else made now, and kept.

    folders: below which specs and requirements are looked for. files: what has to be looked at, whether it is there or not.
    """
    path, below_ = _path(root), sorted(folders)
    known = None if path is None else _kept(path, root, below_)
    if known is not None:
        return known
    with _opened(root) as opened:
        made = make()
    # What was written while it was read may be of before or of after: nobody knows which, so it is not kept.
    if path is not None and all(_about(os.path.join(root, name)) == was for name, was in opened.items()):
        _keep(path, root, below_, sorted({*opened, *files}), made)
    return made


def _path(root: Path) -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    return folder / f"facts-{hashlib.sha256(os.fsencode(root.resolve())).hexdigest()[:32]}.json"


#: Who wants to know which files are opened.
_LISTENING: list[Callable[[str], None]] = []


def _listen(event: str, args: tuple[Any, ...]) -> None:
    if _LISTENING and event == "open" and isinstance(args[0], str | bytes):
        path = os.path.realpath(os.fsdecode(args[0]))
        for tell in _LISTENING:
            tell(path)


@cache
def _hook() -> None:
    """Listen for files that are opened. Nobody can stop listening, so it is done once."""
    sys.addaudithook(_listen)


@contextmanager
def _opened(root: Path) -> Iterator[dict[str, tuple[int, ...]]]:
    """The files below a project's folder that are opened meanwhile, by their paths from it, and what each was like then; without those of Python
    and of the cache."""
    found: dict[str, tuple[int, ...]] = {}
    inside, apart = (
        os.path.join(os.path.realpath(root), ""),
        os.path.join(os.path.realpath(cache_folder() or os.devnull), ""),
    )

    def tell(path: str) -> None:
        if (
            path.startswith(inside)
            and not path.startswith(apart)
            and not path.endswith((".py", ".pyc", ".so"))
        ):
            found.setdefault(path.removeprefix(inside), _about(path))

    _hook()
    _LISTENING.append(tell)
    try:
        yield found
    finally:
        _LISTENING.remove(tell)


def _about(path: str) -> tuple[int, ...]:
    """What is different of a file that was written, or is another one; nothing of one that is not there."""
    try:
        said = os.stat(path)
    except OSError:
        return ()
    return said.st_ino, said.st_size, said.st_mtime_ns, said.st_ctime_ns


def _state(root: Path, folders: list[str], files: list[str]) -> str:
    """One hash of the contents of files, of the names of all that lies beside them, and of the specs and documents in folders."""
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
        except OSError as error:
            take(folder, type(error).__name__)
    for folder in folders:
        found, problems = below(root / folder, (".spec", ".yaml", ".yml"))
        take(folder, found, [problem.filename for problem in problems])
    return digest.hexdigest()


def _keep(path: Path, root: Path, folders: list[str], files: list[str], made: Facts) -> None:
    said = {
        "files": files, "state": _state(root, folders, files), "items": [item.to_json() for item in made.items],
        "parts": [part.to_json() for part in made.parts], "tests": [test.to_json() for test in made.tests], "run_inputs": made.run_inputs,
        "fault_cases": [case.to_json() for case in made.fault_cases],
        "findings": [[f.code, f.level, f.message, f.place, f.help, f.subject, f.also, f.about] for f in made.findings],
    }  # fmt: skip
    content = json.dumps(said).encode()
    replace(path, hashlib.sha256(content).hexdigest().encode() + b"\n" + content)


def _kept(path: Path, root: Path, folders: list[str]) -> Facts | None:
    """What is kept, if it is what was written, and made from what is there now."""
    from trackmarshal.trace import Finding, Place

    try:
        held = path.read_bytes()
        if hashlib.sha256(held[65:]).hexdigest().encode() != held[:64]:
            return None
        said = json.loads(held[65:])
        if said["state"] != _state(root, folders, said["files"]):
            return None
        return Facts(
            [SpecItem.from_json(item) for item in said["items"]],
            [SpecPart.from_json(part) for part in said["parts"]],
            [SpecTest.from_json(test) for test in said["tests"]],
            said["run_inputs"],
            [FaultCase.from_json(case) for case in said["fault_cases"]],
            [
                Finding(code, level, message, place and Place(*place), help_, subject, tuple((Place(*p), label) for p, label in also), tuple(about))
                for code, level, message, place, help_, subject, also, about in said["findings"]
            ],
        )  # fmt: skip
    except (OSError, ValueError, KeyError, TypeError, TrackmarshalError):
        return None
