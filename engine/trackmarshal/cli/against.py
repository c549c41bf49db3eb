"""`--against`: which baseline the matrix page holds what is here against (docs/traceability.md)."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.trace import Matrix, Project
    from trackmarshal.trace.baseline import Content
    from trackmarshal.trace.render.page.beside import Compared

CODES = {
    "T364": (
        "a baseline that nothing can be held against",
        "`--against` names a baseline, or two of them with `..` between: a file that `trace --accept-baseline` wrote, or a revision of git whose baseline is "
        "meant. There is no such file, it is no baseline, or that revision has none. The page of the matrix shows the differences, no other format does.",
    ),
}
#: Between the names of two baselines, as git has it.
BETWEEN = ".."


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--against", metavar="REV|FILE",
        help="on the page: what differs from this baseline, or between two, A..B (default: from the one that is accepted)",
    )  # fmt: skip


def compared(named: str, root: Path, project: Project, matrix: Matrix) -> Compared:
    """What differs between the baselines that are named, or between the one and what is here. Raises T361 and T364."""
    from trackmarshal.trace.baseline import changes
    from trackmarshal.trace.render.page.beside import Compared

    whole = (root / named).is_file() or Path(named).is_file()
    before, between, after = (named, "", "") if whole else named.partition(BETWEEN)
    held = _content(before, root, project)
    now = _content(after, root, project) if after else matrix.content
    called = after or ("HEAD" if between else "what is here")
    if between and not after:  # as git has it: up to the commit that is here
        now = _content("HEAD", root, project)
    return Compared(before, called, tuple(changes(held, now)))


def _content(named: str, root: Path, project: Project) -> Content:
    """What the baseline holds in a file, or in a revision."""
    from trackmarshal.cli.revisions import commit_of, read_more
    from trackmarshal.trace.baseline import DEFAULT

    if not named:
        raise TrackmarshalError(
            "T364", "`--against` names no baseline", help="name a file, or a revision such as `v1.0`"
        )
    for path in (Path(named), root / named):
        if path.is_file():
            return _read(path, named)
    shown = str(project.baseline or DEFAULT)
    commit = commit_of(named, root)
    with tempfile.TemporaryDirectory(prefix="trackmarshal-against-") as folder:
        into = Path(folder).resolve()
        read_more(commit, root, into, [shown], called=named)
        if not (into / shown).is_file():
            raise TrackmarshalError(
                "T364",
                f"`{named}` has no baseline `{shown}`",
                help="name a revision in which one was accepted",
            )
        return _read(into / shown, f"{named}:{shown}")


def _read(path: Path, called: str) -> Content:
    from trackmarshal.trace.baseline import read

    try:
        return read(path).content
    except (OSError, ValueError, RecursionError) as problem:
        said = problem.strerror if isinstance(problem, OSError) else str(problem) or type(problem).__name__
        raise TrackmarshalError(
            "T364",
            f"`{called}` is no baseline: {said}",
            file=called,
            help="name a file that `trace --accept-baseline` wrote",
        ) from problem


__all__ = ["CODES", "compared", "configure"]
