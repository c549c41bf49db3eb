"""Write a small project that is green from the start: signals, a rule with tests, its requirement, a scenario, the gate, and a CI workflow.

Nothing is asked, and nothing that is there is changed. `trackmarshal new` adds the next piece.
"""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from trackmarshal.cli.output import say


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder", nargs="?", metavar="DIR", help="made if need be (default: the current folder)"
    )


def run(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.sources import Sources
    from trackmarshal.meaning import tool
    from trackmarshal.start.project import BASELINE, init
    from trackmarshal.start.writing import refuse_present
    from trackmarshal.trace import requirements

    root = Path(args.folder or args.project or ".")
    refuse_present(root, [BASELINE])
    written = init(root)
    made = Sources(root.resolve(), requirements.load(root.resolve(), [])).facts()
    path, _ = trace.accept_baseline(
        root.resolve(), made.items, made.tests, [], made.parts, made.run_inputs, engine=tool()
    )
    written.append(path)
    if not args.quiet:
        say(*(f"wrote {root / path.resolve().relative_to(root.resolve())}" for path in written))
        go = [] if root.resolve() == Path.cwd().resolve() else [f"cd {shlex.quote(str(root))}"]
        say("next:", *(f"  {line}" for line in (*go, "trackmarshal test", "trackmarshal trace --gate")))
    return 0
