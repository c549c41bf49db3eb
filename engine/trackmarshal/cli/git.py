"""How git is asked about a project: of what is recorded, and of nothing that stands in its place on this machine: replaced objects, grafts, what was
counted of the commits before, another repository that the environment names, or an answer in another form, as somebody likes to read it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

#: Variables that lead git elsewhere than to the repository around a folder, or to other paths in it than are named; hooks of git set some for their own.
_ELSEWHERE = (
    "GIT_DIR",
    "GIT_COMMON_DIR",
    "GIT_WORK_TREE",
    "GIT_INDEX_FILE",
    "GIT_NAMESPACE",
    "GIT_SHALLOW_FILE",
    "GIT_REPLACE_REF_BASE",
    "GIT_CEILING_DIRECTORIES",
    "GIT_LITERAL_PATHSPECS",
    "GIT_GLOB_PATHSPECS",
    "GIT_NOGLOB_PATHSPECS",
    "GIT_ICASE_PATHSPECS",
)
#: In place of settings of whoever asks, as which it is read: signatures stand among commits, a file is followed to another one, paths are from
#: elsewhere, and of a merge it is not said what it changed.
_AS_IT_IS = (
    "core.commitGraph=false",
    "log.showSignature=false",
    "log.follow=false",
    "log.diffMerges=separate",
    "diff.relative=false",
)


def asking(folder: Path, *words: str) -> list[str]:
    """The command that asks git, in a folder, and takes no lock for it: what somebody else does there meanwhile would fail of that."""
    plain = [part for setting in _AS_IT_IS for part in ("-c", setting)]
    return ["git", "--no-replace-objects", "--no-optional-locks", *plain, "-C", str(folder), *words]


def surroundings() -> dict[str, str]:
    """The environment to ask it in."""
    kept = {name: value for name, value in os.environ.items() if name not in _ELSEWHERE}
    # A file that there cannot be: of one that is there, git says each time that grafts are of the past.
    return {**kept, "GIT_GRAFT_FILE": os.path.join(os.devnull, "none"), "LC_ALL": "C"}


def answer(folder: Path, *words: str, errors: str = "backslashreplace", timeout: float = 20.0) -> str:
    """What git answers, in a folder, whatever the locale is; errors: what becomes of bytes that it cannot read, as of paths in another encoding. Raises
    OSError or SubprocessError where git gives no answer."""
    return subprocess.run(
        asking(folder, *words), capture_output=True, text=True, errors=errors, check=True, timeout=timeout, env=surroundings()
    ).stdout  # fmt: skip


def cut(folder: Path) -> frozenset[str]:
    """The first commits that a shallow clone has of a longer history: to git, whatever is older was written in them. Raises as `answer` does."""
    path = folder / answer(folder, "rev-parse", "--git-path", "shallow").removesuffix("\n")
    first = path.read_text("utf-8").split() if path.is_file() else []
    if not first:
        return frozenset()
    # Where as many commits were asked for as there are, the very first one stands there, too. What is told here are parents as a commit has them.
    told = answer(folder, "rev-list", "--no-walk", "--ignore-missing", "--header", *first).split("\0")
    heads = (one.partition("\n\n")[0] for one in told)
    return frozenset(head.partition("\n")[0] for head in heads if "\nparent " in head)


def refused(problem: OSError | subprocess.SubprocessError) -> tuple[str, str]:
    """Why git gave no answer, in its own words: what is wrong, and what it says can be done about that; empty where it says nothing of it."""
    if isinstance(problem, OSError):
        return f"git cannot be run: {problem.strerror or type(problem).__name__}", "install git"
    if not isinstance(problem, subprocess.CalledProcessError):
        return "git does not answer in time", ""
    told = problem.stderr or ""
    lines = [
        line.strip()
        for line in (told if isinstance(told, str) else told.decode("utf-8", "replace")).split("\n")
    ]
    what, *more = [line for line in lines if line] or ["it says nothing"]
    return f"git: {what.removeprefix('fatal: ')}", " ".join(more)


__all__ = ["answer", "asking", "cut", "refused", "surroundings"]
