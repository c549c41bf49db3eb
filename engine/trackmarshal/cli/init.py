"""Write a small project that is green from the start: signals, a rule with tests, its requirement, a scenario, the gate, and a CI workflow.

Nothing is asked, and nothing that is there is changed. `trackmarshal new` adds the next piece.
"""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from trackmarshal.cli.output import say
from trackmarshal.cli.places import repository


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder", nargs="?", metavar="DIR", help="made if need be (default: the current folder)"
    )
    parser.set_defaults(refuse=parser.error)


def run(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.sources import Sources
    from trackmarshal.meaning import tool
    from trackmarshal.start.project import BASELINE, WORKFLOW, init
    from trackmarshal.start.writing import refuse_present, taken_back
    from trackmarshal.trace import requirements

    if args.folder and args.project:
        args.refuse("DIR and --project name one folder each: give one of them")
    root = Path(args.folder or args.project or ".")
    refuse_present(root, [BASELINE])
    here = root.resolve()
    whole = repository(here) or here
    folder = here.relative_to(whole).as_posix() if here != whole else ""
    written = init(root, folder)
    with taken_back(written):  # specs that were there may be unreadable, and what is half a project is none
        made = Sources(root.resolve(), requirements.load(root.resolve(), [])).facts()
        trace.accept_baseline(
            root.resolve(), made.items, made.tests, [], made.parts, made.run_inputs, engine=tool()
        )
    written.append(root / BASELINE)
    if not args.quiet:
        say(*(f"wrote {path}" for path in written))
        go = [] if root.resolve() == Path.cwd().resolve() else [f"cd {shlex.quote(str(root))}"]
        say("next:", *(f"  {line}" for line in (*go, "trackmarshal test", "trackmarshal trace --gate")))
        if folder:  # several projects may be in it
            to = whole / Path(WORKFLOW).with_stem(f"trackmarshal-{folder.replace('/', '-')}")
            say(f"GitHub runs no workflow from there: move {root / WORKFLOW} to {to}")
    return 0
