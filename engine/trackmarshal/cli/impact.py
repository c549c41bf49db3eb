"""`trace --impact`: the project as it is, held against a revision of it (docs/impact.md)."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.output import say
from trackmarshal.cli.project import MARKER
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.trace import Finding, Project
    from trackmarshal.trace.impact import Version


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--impact",
        metavar="REV",
        help="what changed since a revision of git, which evidence has to be made again, and in which order; runs nothing",
    )


def answer(root: Path, args: argparse.Namespace) -> int:
    """Print the impact; raises T363 for what is here, T361 and T363 for the revision, T169 for a format that it does not have."""
    from trackmarshal.cli.answers import commit
    from trackmarshal.cli.revisions import commit_of
    from trackmarshal.trace import baseline, impact
    from trackmarshal.trace.render import impact as shown

    if args.format not in shown.FORMATS:
        raise TrackmarshalError(
            "T169",
            f"an impact is not written as {args.format}",
            help="formats are " + ", ".join((*shown.FORMATS, "markdown")),
        )
    named = commit_of(args.impact, root)
    now = _now(root, args.quiet)
    with tempfile.TemporaryDirectory(prefix="trackmarshal-impact-") as folder:
        before = _then(args.impact, named, root, Path(folder).resolve())
        held = baseline.load(Path(folder).resolve(), before.project, [])
    lacking: list[Finding] = []
    accepted = baseline.load(root, now.project, lacking)
    if lacking and (held or (now.project.baseline and (root / now.project.baseline).exists())):
        raise _unknown(lacking[0])  # what has to be accepted by name would be left out, without a word
    made = impact.compared(before, now, accepted)
    between = shown.Between(
        args.impact, named, commit(root, now.project.specs), now.project.name or root.name
    )
    text = shown.render(made, between, args.format)
    if args.format == "text":
        say(*text.removesuffix("\n").split("\n"))
    else:
        print(text, end="")
    return 0


def _now(root: Path, quiet: bool) -> Version:
    """The project as it is, with the results that are there."""
    from trackmarshal.cli.assessment import assess
    from trackmarshal.meaning import tool
    from trackmarshal.trace import impact

    there = assess(root, run=False, quiet=quiet)
    said = there.facts
    made = impact.version(
        root, said.items, said.tests, said.fault_cases, said.parts, said.run_inputs, engine=tool(), results=there.results, runs=there.runs,
        fault_results=there.fault_results, findings=said.findings,
    )  # fmt: skip
    if made.wrong:
        raise _unknown(made.wrong[0])
    return made


def _unknown(first: Finding) -> TrackmarshalError:
    """That what is here cannot be compared, for what is wrong with it."""
    return TrackmarshalError(
        "T363",
        f"what is here has errors, so what it means is not known: {first.message} [{first.code}]",
        file=first.place.file if first.place else None,
        line=first.place.line if first.place else None,
        help="mend them first: `trackmarshal check`, `trackmarshal trace --as-is`",
    )


def _then(name: str, commit: str, root: Path, folder: Path) -> Version:
    """The project as it was, read out of git into a folder."""
    from trackmarshal.cli.revisions import read, read_more
    from trackmarshal.cli.sources import Sources
    from trackmarshal.trace import Finding, impact, requirements
    from trackmarshal.trace.findings import Place

    read(commit, root, folder, called=name)
    if not (folder / MARKER).is_file():
        raise TrackmarshalError(
            "T363",
            f"`{name}` has no {MARKER.as_posix()}, so there is no project to compare with",
            help="name a revision in which this folder is a project; where it was another folder, that is the commit that moved it, or a later one",
        )
    project = requirements.load(folder, [])
    named = [
        *(path for path in (project.baseline, project.closed_loop, project.case_templates, project.case_words) if path), *(s.path for s in project.scenarios), *(s.kept for s in project.scenarios if s.kept), *project.campaigns, *project.sources,
        *(e.path for e in project.evidence), *(b.evidence for b in project.backing), *(path for e in project.entries for kind, path in e.links if kind == "backed_by"),
    ]  # fmt: skip
    read_more(commit, root, folder, named, called=name)
    engine = _engine(name, commit, root, folder, project)
    try:
        sources = Sources(folder, project)
        said = sources.facts()
    except TrackmarshalError as problem:
        place = Place(problem.file or "", problem.line or 0)
        wrong = Finding(problem.code, "error", problem.message, place if problem.file else None)
        return impact.version(folder, (), (), (), (), {}, engine=engine, findings=[wrong])
    read_more(commit, root, folder, [item.evidence for item in said.items if item.evidence], called=name)
    return impact.version(
        folder, said.items, said.tests, said.fault_cases, said.parts, said.run_inputs, engine=engine, findings=said.findings,
    )  # fmt: skip


def _engine(name: str, commit: str, root: Path, folder: Path, project: Project) -> str:
    """The engine that made the evidence then: of its sources where the project has them, else as the baseline's last acceptance says; empty where neither does."""
    from trackmarshal.cli.revisions import read_more
    from trackmarshal.meaning.tool import HERE, tool_of
    from trackmarshal.trace import baseline

    if HERE.is_relative_to(root):
        sources = HERE.relative_to(root).as_posix()
        read_more(commit, root, folder, [sources], called=name)
        made = tool_of(folder / sources)
        if made:
            return made
    if project.baseline:
        read_more(commit, root, folder, [project.baseline], called=name)
    held = baseline.load(folder, project, [])
    return "" if held is None else held.acceptances[-1].engine


__all__ = ["answer", "configure"]
