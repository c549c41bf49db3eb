"""What an edit of specs changes on recordings: which verdicts, margins and decisions, where, and by how much (docs/diff.md).

trackmarshal diff main . --on specs/scenarios/*.tmrec.jsonl

OLD and NEW are spec files, folders with specs, projects, or git revisions. The exit status is 0 where nothing differs, 1 where something does.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.options import configure_with
from trackmarshal.cli.output import plain, progress, say, write
from trackmarshal.cli.project import MARKER, optional_project
from trackmarshal.errors import TrackmarshalError
from trackmarshal.json_text import named_twice

if TYPE_CHECKING:
    from trackmarshal.comparing import Judged
    from trackmarshal.scenarios.recording import Recording


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "old", metavar="OLD", help="a spec file or folder, a project, or a revision (`main`, `HEAD~1`)"
    )
    parser.add_argument("new", metavar="NEW", help="the same, such as `.` for the project as it is")
    parser.add_argument(
        "--on",
        nargs="+",
        required=True,
        metavar="RECORDING",
        help="recordings: .tmrec.jsonl or .saa; declarations: .yaml",
    )
    parser.add_argument(
        "--spec",
        metavar="PATH",
        help="in projects and revisions: the spec, from the project (default: the one that it replays with)",
    )
    parser.add_argument(
        "--renamed",
        action="append",
        default=[],
        metavar="OLD=NEW",
        help="a rule that has another name now (repeatable)",
    )
    configure_with(parser)
    parser.add_argument(
        "--format", choices=("text", "json", "md"), default="text", help="md: a comment for a merge request"
    )


def run(args: argparse.Namespace) -> int:
    from trackmarshal.comparing import Pair, compared
    from trackmarshal.comparing.render import markdown, text, to_json
    from trackmarshal.scenarios import load

    with tempfile.TemporaryDirectory(prefix="trackmarshal-diff-") as folder:
        sides = [
            _Side(name, args, Path(folder) / str(number)) for number, name in enumerate((args.old, args.new))
        ]
        if args.spec is not None and all(side.is_spec for side in sides):
            raise TrackmarshalError(
                "T362",
                f"`--spec {args.spec}` is of projects and revisions, and `{args.old}` and `{args.new}` are specs themselves",
                help="leave it out, or name what it is to be looked for in",
            )
        pairs = []
        for path in args.on:
            recording = load(path)
            old, new = (side.judge(recording, args.quiet) for side in sides)
            pairs.append(Pair(old, new))
            _note(old, new)  # also without progress: what is `equal` below rests on it
    made = compared(pairs, _renamed(args.renamed, pairs))
    if args.format == "json":
        print(to_json(made))
    elif args.format == "md":
        write("".join(f"{plain(line)}\n" for line in markdown(made)))
    else:
        say(*text(made))
    return int(not made.equal)


class _Side:
    """One of the two: its spec, and the project that it belongs to."""

    def __init__(self, name: str, args: argparse.Namespace, folder: Path) -> None:
        from trackmarshal.cli.replay import Known, default_spec
        from trackmarshal.cli.revisions import read

        self._home = optional_project(args)
        self._settings = [Path(path) for path in args.settings]
        self._known = Known()
        #: Whether it is a spec itself, and no project or revision, in which one has to be found.
        self.is_spec = False
        path = Path(name)
        if (path / MARKER).is_file():
            self._project: Path | None = path.resolve()
        elif path.exists():
            self._project, self._spec, self.is_spec = self._home, path, True
            return
        else:
            folder.mkdir()
            self._project = read(name, self._home or Path.cwd(), folder).resolve()
        if args.spec is None and not (self._project / MARKER).is_file():
            raise TrackmarshalError(
                "T362",
                f"`{name}` has no {MARKER.as_posix()}, which says what its spec is",
                help="name the spec with `--spec`, by its path from the project; where that was another folder, check it out with `git worktree add`, and name the folder there",
            )
        self._spec = self._project / args.spec if args.spec else default_spec(self._project)
        if not self._spec.exists():
            shown = args.spec or self._spec.relative_to(self._project).as_posix()
            raise TrackmarshalError(
                "T362",
                f"`{name}` has no `{shown}`",
                help="name a spec that both have with `--spec`, by its path from the project",
            )

    def judge(self, recording: Recording, quiet: bool) -> Judged:
        """A recording under this side's rules, with this side's vehicle and track where the recording names them."""
        from trackmarshal.cli.replay import evaluator_for, overruled
        from trackmarshal.comparing import judge

        folder = Path(recording.source).resolve().parent
        if self._project is not None and self._home is not None and folder.is_relative_to(self._home):
            folder = self._project / folder.relative_to(self._home)
        configured = overruled(recording, self._spec, self._settings)
        evaluator = evaluator_for(
            configured, self._spec, self._settings, self._project, None, "numpy", folder, (), self._known
        )

        def watch(chunks: Sequence[object]) -> object:
            return progress(chunks, recording.name, quiet)

        return judge(evaluator, configured, watch)  # type: ignore[arg-type]


def _note(old: Judged, new: Judged) -> None:
    """Say which edited values and which rules a recording does not show: that nothing differs on it says nothing of them. And where it was the
    record of a run under neither spec, or not all of one."""
    from trackmarshal.scenarios.fields import other_spec
    from trackmarshal.scenarios.overrides import hidden

    for _, one in hidden(new.recording, old.evaluator.spec, new.evaluator.spec):
        say(f"note: {new.recording.name} does not show an edit: it has {one}", file=sys.stderr)
    other = other_spec(new.recording, old.evaluator) and other_spec(new.recording, new.evaluator)
    if other:
        say(f"note: {new.recording.name}: {other}", file=sys.stderr)
    # Of the record of a run, that nothing differs on what is left of it says nothing of what is not.
    for note in new.recording.notes if new.recording.of_run is not None else ():
        say(f"note: {new.recording.name}: {note}", file=sys.stderr)
    unknown = [rule.name for rule in new.evaluator.rules if rule.name in old.unknown & new.unknown]
    if unknown:
        rules = ", ".join(f"`{name}`" for name in unknown)
        say(f"note: {new.recording.name} shows nothing of {rules}: undefined in every cycle", file=sys.stderr)


def _renamed(given: Sequence[str], pairs: Sequence[object]) -> dict[str, str]:
    from trackmarshal.comparing import Pair

    for names, side in zip(zip(*(text.partition("=")[::2] for text in given)), ("old", "new")):
        twice = named_twice(names)
        if twice is not None:
            raise TrackmarshalError(
                "T362", f"`--renamed` names the {side} rule `{twice}` twice", help="a rule has one other name"
            )
    renamed = dict(text.partition("=")[::2] for text in given)
    for old, new in renamed.items():
        for name, one in ((old, "old"), (new, "new")):
            judged = [getattr(pair, one) for pair in pairs if isinstance(pair, Pair)]
            if any(name not in [rule.name for rule in side.evaluator.rules] for side in judged):
                raise TrackmarshalError(
                    "T362",
                    f"`--renamed {old}={new}`: the {one} spec has no rule `{name}`",
                    help="OLD=NEW, the names as they stand in the specs",
                )
    return renamed
