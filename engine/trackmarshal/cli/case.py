"""The safety case as a document, HTML and PDF: the verdict and what is open, requirements, rules, evidence, matrix; from the evidence that is there.

trackmarshal case --out DIR
trackmarshal case --out DIR --today 2026-11-30 --templates OWN

Nothing is run: `trackmarshal assess` brings the evidence up to date. The exit status is 1 when the gate fails. The PDF needs the extra `pdf`; without
it, the HTML is written all the same.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.output import print_problem, say
from trackmarshal.cli.project import find_project, spec_folders
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.cli.assessment import Assessment
    from trackmarshal.ir.spec import Spec
    from trackmarshal.records import SpecItem
    from trackmarshal.trace.case.inputs import Inputs

NAME = "safety-case"


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", metavar="DIR", required=True, help=f"the folder of {NAME}.html and {NAME}.pdf")
    parser.add_argument(
        "--today", metavar="DATE", type=date.fromisoformat, help="the day as of which it is judged (default: that of the commit)"
    )
    parser.add_argument(
        "--templates", metavar="DIR", help="templates in place of ours (default: as v-model.yaml says)"
    )
    parser.add_argument("--format", choices=("both", "html", "pdf"), default="both")


def run(args: argparse.Namespace) -> int:
    """Write the document; 1 where the gate fails, 2 where a document cannot be read. Raises T430, T431 and T433."""
    from trackmarshal import trace
    from trackmarshal.cli.assessment import assess
    from trackmarshal.trace.case import html, typst
    from trackmarshal.trace.case.content import content

    root = find_project(args)
    found = assess(root, run=False, quiet=args.quiet)
    day = args.today or _day(root)
    given = _inputs(found, root, day)
    folder = _templates(args.templates, found, root)
    document = content(given)
    made: dict[str, bytes] = {}
    problem = None
    if args.format in ("both", "html"):
        # Lone surrogates (from odd paths) have no encoding; a page must not fail on them.
        made[f"{NAME}.html"] = html.render(document, folder).encode("utf-8", "replace")
    if args.format in ("both", "pdf"):
        source = typst.source(document, folder)
        try:
            made[f"{NAME}.pdf"] = typst.pdf(source, document.day)
        except TrackmarshalError as missing:
            problem = missing
            if missing.code == "T433":
                made[f"{NAME}.typ"] = source.encode("utf-8", "replace")
    _write(Path(args.out), made)
    if problem is not None:
        print_problem(problem)
    matrix = given.matrix
    lapsed = [] if args.today is not None else list(_lapsed(given))
    for name, expired in lapsed:
        say(f"the waiver `{name}` expired on {expired}, after the commit; `--today` judges as of another day", file=sys.stderr)
    gaps = trace.gate(matrix)
    if not args.quiet:
        say(*(str(Path(args.out) / name) for name in made), f"{matrix.project}: {matrix.verdict}", file=sys.stderr)
    if matrix.unusable or (problem is not None and (problem.code != "T432" or args.format == "pdf")):
        return 2
    return 1 if gaps or lapsed else 0


def _inputs(found: Assessment, root: Path, day: date) -> Inputs:
    from trackmarshal import __version__, trace
    from trackmarshal.cli.answers import commit
    from trackmarshal.evaluation import load
    from trackmarshal.meaning.tool import tool
    from trackmarshal.trace.case.inputs import Inputs

    said = found.facts
    matrix = found.matrix(day)
    broken = any(finding.level == "error" for finding in said.findings)
    # Of specs with errors, the matrix says what is wrong; their rules are named there, and not explained.
    spec = None if broken else load(spec_folders(root), [], root)
    return Inputs(
        matrix, found.project, said.items, said.tests, found.results, found.runs, found.fault_results,
        trace.fault_rows(said.fault_cases, found.fault_results), {} if spec is None else dict(_sheets(spec, said.items)), commit(root),
        f"trackmarshal {__version__}", tool(), "" if spec is None else spec.fingerprint, _hashes(root, found.project.baseline),
    )  # fmt: skip


def _sheets(spec: Spec, items: Iterable[SpecItem]) -> Iterable[tuple[str, Mapping[str, Any]]]:
    """By rule, what `show` says of it."""
    from trackmarshal.reading.data import data
    from trackmarshal.reading.rule import read
    from trackmarshal.reading.sheet import Sheet, spec_text
    from trackmarshal.reading.telling import tell
    from trackmarshal.reading.words.english import ENGLISH

    for item in items:
        rule = spec.rule(item.name)
        if rule is not None:
            has = rule.typed is not None
            sheet = Sheet(
                rule, ENGLISH, spec_text(rule), read(rule, spec) if has else None, tell(rule, spec, ENGLISH) if has else None, None, ()
            )  # fmt: skip
            yield item.name, data(sheet)


def _day(root: Path) -> date:
    """The day of the project's commit; the clock's where there is none."""
    said = ["git", "-C", str(root), "log", "-1", "--format=%cs"]
    try:
        return date.fromisoformat(subprocess.run(said, capture_output=True, text=True, check=True, timeout=20).stdout.strip())
    except (OSError, ValueError, subprocess.SubprocessError):
        return date.today()


def _lapsed(given: Inputs) -> Iterable[tuple[str, date]]:
    """Waivers that held on the day of the commit, and hold no longer."""
    now = date.today()
    for waiver in given.matrix.waivers:
        if waiver.granted <= given.matrix.today <= waiver.expires < now:
            yield str(waiver.id), waiver.expires


def _templates(named: str | None, found: Assessment, root: Path) -> Path | None:
    """The folder of the project's own templates; raises T431."""
    declared = found.project.case_templates
    if named is None and not declared:
        return None
    folder = Path(named) if named is not None else root / str(declared)
    if not folder.is_dir():
        file, line = (None, None) if named is not None or declared is None else (declared.place.file, declared.place.line)
        raise TrackmarshalError("T431", f"there is no folder {folder}", file=file, line=line, help="name a folder with templates")
    return folder


def _hashes(root: Path, baseline: object) -> dict[str, str]:
    """sha256 of the files below `requirements/`, and of the baseline."""
    from trackmarshal.cli.evidence import file_hash
    from trackmarshal.files import below
    from trackmarshal.trace.requirements import FOLDER

    files, _ = below(root / FOLDER, (".yaml", ".yml"))
    paths = [*files, *([root / str(baseline)] if baseline and (root / str(baseline)).is_file() else [])]
    return {path.relative_to(root).as_posix(): file_hash(path) for path in paths}


def _write(folder: Path, made: Mapping[str, bytes]) -> None:
    """Each file whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in made.items():
        draft = folder / f".{name}.{os.getpid()}"
        draft.write_bytes(data)
        draft.replace(folder / name)
