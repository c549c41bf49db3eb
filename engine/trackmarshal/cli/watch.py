"""Check and test on every save, until Ctrl-C, which ends it with exit status 0.

Each round says when it was, what is wrong, and in its last line whether all is well. A spec that cannot be read or parsed is a finding like any
other: the next save is looked at again. Files that are saved together make one round.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project, optional_project, spec_folders
from trackmarshal.files import below

#: Time between two looks, s, and for how long nothing may have changed before a round begins: editors save in several steps.
LOOK = 0.25
#: What is watched.
_SUFFIXES = (".spec", ".yaml", ".yml")
#: What a file looks like from outside: when it was written, and how long it is.
State = dict[str, tuple[int, int]]


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="spec files or folders (default: the project's specs and requirements)",
    )


def run(args: argparse.Namespace) -> int:
    watched = [Path(path) for path in args.paths]
    if not watched:
        root = find_project(args)
        watched = [*spec_folders(root), root / "requirements"]
    else:
        optional_project(args)
    try:
        watch(watched, lambda: _round(args))
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
    return 0


def watch(paths: Sequence[Path], look_into: Callable[[], None], sleep: Callable[[float], None] = time.sleep) -> None:  # fmt: skip
    """Call `look_into` now, and after every change below `paths` once nothing changes any more; until `sleep` or `look_into` raises."""
    seen: State | None = None
    while True:
        now = state(paths)
        while now != seen:
            if seen is not None:
                now = _settled(paths, now, sleep)
            seen = now
            look_into()
            now = state(paths)  # what was saved meanwhile is the next round's
        sleep(LOOK)


def _settled(paths: Sequence[Path], now: State, sleep: Callable[[float], None]) -> State:
    """The state once it stays the same from one look to the next."""
    while True:
        sleep(LOOK)
        later = state(paths)
        if later == now:
            return now
        now = later


def state(paths: Sequence[Path]) -> State:
    """Every watched file below some paths; one that goes away meanwhile is not there, nor is a folder."""
    found: State = {}
    for path in paths:
        for file in below(path, _SUFFIXES)[0] if path.is_dir() else [path]:
            try:
                about = file.stat()
            except OSError:
                continue
            found[str(file)] = (about.st_mtime_ns, about.st_size)
    return found


def _round(args: argparse.Namespace) -> None:
    """One round: check, and where that finds nothing, the tests."""
    from trackmarshal.cli.main import main

    project = ["--project", args.project] if args.project is not None else []
    quiet = ["--quiet"] if args.quiet else []
    say(f"-- {time.strftime('%H:%M:%S')}")
    for verb in ("check", "test"):
        status = main([verb, *args.paths, *project, *quiet])
        if status == 130:  # Ctrl-C, which `main` answers for other verbs
            raise KeyboardInterrupt
        if status == 141:  # who read it went away
            raise BrokenPipeError
        if status:
            say(f"-- {verb}: not yet; watching")
            break
    else:
        say("-- all well; watching")
    sys.stdout.flush()  # whoever reads it through a pipe is waiting for it
