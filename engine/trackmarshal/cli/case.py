"""The safety case as a document, HTML and PDF: the verdict and what is open, requirements, rules, evidence, matrix; from the evidence that is there.

trackmarshal case --out DIR
trackmarshal case --out DIR --day 2026-11-30 --templates OWN
trackmarshal case --out DIR --words de

Nothing is run: `trackmarshal assess` brings the evidence up to date. The exit status is 1 when the gate fails, when the argument has an error, and
where no day is said, when a waiver has expired since the commit. The PDF needs the extra `pdf`; without
it, the HTML is written all the same.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.answers import commit
from trackmarshal.cli.days import COMMIT, day, warn
from trackmarshal.cli.drawing import drawings
from trackmarshal.cli.output import print_problem, say
from trackmarshal.cli.project import find_project, spec_folders
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import write_whole

if TYPE_CHECKING:
    from trackmarshal.cli.assessment import Assessment
    from trackmarshal.trace.case.inputs import Inputs
    from trackmarshal.trace.case.loop import Loop
    from trackmarshal.trace.case.model import Document
    from trackmarshal.trace.matrix import Matrix

NAME = "safety-case"
#: What was not run, or before something changed: tests, runs, faults.
_NOT_UP_TO_DATE = frozenset({"T216", "T217", "T218", "T241", "T242", "T261", "T262"})
#: So many letters that no font has are named.
UNSHOWN = 8
#: What is said where an extra is not installed, or a font lacks letters: the document comes without what it is for, and says so.
EXTRAS = frozenset({"T424", "T432", "T438"})


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", metavar="DIR", required=True, help=f"the folder of {NAME}.html and {NAME}.pdf"
    )
    parser.add_argument(
        "--day",
        "--today",
        metavar="DAY",
        help="the day as of which it is judged: YYYY-MM-DD, or `commit` (default, where there is one)",
    )
    parser.add_argument(
        "--templates", metavar="DIR", help="templates in place of ours (default: as v-model.yaml says)"
    )
    parser.add_argument(
        "--words",
        metavar="LANGUAGE|FILE",
        help="the language of fixed words, or a file of them (default: as v-model.yaml says, or en)",
    )
    parser.add_argument("--format", choices=("both", "html", "pdf"), default="both")


def run(args: argparse.Namespace) -> int:
    """Write the document; 1 where the gate fails, 2 where a document cannot be read. Raises T430, T431, T433 to T437, and T439."""
    from trackmarshal.trace.collector import no_collection

    with no_collection():
        return _run(args)


def _run(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.assessment import assess
    from trackmarshal.trace.case import html, typst

    root = find_project(args)
    found = assess(root, run=False, quiet=args.quiet)
    words = _words(args.words, found, root)
    given = replace(_inputs(found, root, _day(args.day, root)), asked=_asked(args))
    given = replace(given, lacking=any(one.code in _NOT_UP_TO_DATE for one in given.matrix.findings))
    folder = _templates(args.templates, found, root)
    problems: list[TrackmarshalError] = []
    document = _drawn(given, words, problems)
    made: dict[str, bytes] = {}
    if args.format in ("both", "html"):
        # Lone surrogates (from odd paths) have no encoding; a page must not fail on them.
        made[f"{NAME}.html"] = html.render(document, folder).encode("utf-8", "replace")
    if args.format in ("both", "pdf"):
        source = typst.source(document, folder)
        try:
            source, letters = typst.spelled(source)
            if letters:
                problems.append(_unshown(letters))
            made[f"{NAME}.pdf"] = typst.pdf(source, document.day)
        except TrackmarshalError as missing:
            problems.append(missing)
            if missing.code == "T433":
                made[f"{NAME}.typ"] = source.encode("utf-8", "replace")
    _write(Path(args.out), made)
    for problem in problems:
        print_problem(problem)
    matrix = given.matrix
    lapsed = [] if args.day is not None else list(_lapsed(given))
    for name, expired in lapsed:
        say(
            f"the waiver `{name}` expired on {expired}, after the commit; `--day` judges as of another day",
            file=sys.stderr,
        )
    gaps = [*trace.gate(matrix), *(one for one in given.argument.findings if one.level == "error")]
    if not args.quiet:
        say(
            *(str(Path(args.out) / name) for name in made),
            f"{matrix.project}: {matrix.verdict}",
            file=sys.stderr,
        )
        if given.lacking:
            say(
                "evidence is missing or stale: nothing is run here, `trackmarshal assess` does",
                file=sys.stderr,
            )
    lacking = [
        one for one in problems if one.code not in EXTRAS or (one.code == "T432" and args.format == "pdf")
    ]
    if matrix.unusable or lacking:
        return 2
    return 1 if gaps or lapsed else 0


def _inputs(found: Assessment, root: Path, as_of: date) -> Inputs:
    from trackmarshal import __version__, trace
    from trackmarshal.cli.recorded import recorded
    from trackmarshal.cli.sheets import rule_sheets
    from trackmarshal.evaluation import load
    from trackmarshal.meaning.tool import tool
    from trackmarshal.trace.case.inputs import Inputs
    from trackmarshal.trace.gsn.building import build

    said = found.facts
    matrix = found.matrix(as_of)
    broken = any(finding.level == "error" for finding in said.findings)
    # Of specs with errors, the matrix says what is wrong; their rules are named there, and not explained.
    spec = None if broken else load(spec_folders(root), [], root)
    sheets = {} if spec is None else dict(rule_sheets(spec, [item.name for item in said.items]))
    return Inputs(
        matrix, build(matrix, found.project, root), found.project, said.items, said.tests, found.results, found.runs,
        trace.fault_rows(said.fault_cases, found.fault_results), sheets, commit(root, found.project.specs),
        f"trackmarshal {__version__}", tool(), "" if spec is None else spec.fingerprint, _hashes(root, found.project.baseline),
        drawings(root, said, sheets, lambda: found.sources), _loop(matrix, found, root),
        recorded(root, {str(e.id): (e.id.place.file, e.id.place.line) for e in found.project.entries if e.kind == "review"}),
    )  # fmt: skip


def _asked(args: argparse.Namespace) -> str:
    """The options without which the same project comes to another document."""
    options = (("--words", args.words), ("--templates", args.templates))
    return shlex.join(word for name, value in options if value is not None for word in (name, value))


def _unshown(letters: str) -> TrackmarshalError:
    named = ", ".join(f"{letter} (U+{ord(letter):04X})" for letter in letters[:UNSHOWN])
    more = f" and {len(letters) - UNSHOWN} more" if len(letters) > UNSHOWN else ""
    return TrackmarshalError(
        "T438", f"the PDF has no font for {named}{more}, and has their numbers instead", help="the HTML has them; in titles and ids, other letters can be read on paper too"
    )  # fmt: skip


def _loop(matrix: Matrix, found: Assessment, root: Path) -> Loop | None:
    """The kept results of a closed loop that the project names; raises T437 for what is none."""
    from trackmarshal.trace.case.loop import read

    path = found.project.closed_loop
    if path is None:
        return None
    reviewed = dict.fromkeys(str(entry.path) for entry in found.project.evidence if entry.sha256)
    return read(
        root, str(path), matrix.graph.nodes["document", str(path)].attributes["fingerprint"], reviewed
    )


def _words(named: str | None, found: Assessment, root: Path) -> Mapping[str, str]:
    """The words that are asked for: a file by its path, in v-model.yaml from the project's folder. Raises T434 to T436."""
    from trackmarshal.trace.case.words.language import words

    if named is not None:
        return words(named, Path())
    return words(str(found.project.case_words or "en"), root)


def _drawn(given: Inputs, words: Mapping[str, str], problems: list[TrackmarshalError]) -> Document:
    """The document with the argument drawn; in words where the engine that lays it out is not installed."""
    from trackmarshal.trace.case.content import content

    try:
        return content(given, words)
    except TrackmarshalError as missing:
        if missing.code not in EXTRAS:
            raise
        problems.append(missing)
        return content(replace(given, draw=False), words)


def _day(said: str | None, root: Path) -> date:
    """The day that is said, or that of the project's commit; the clock's where neither is. Raises T348."""
    if said is None and not commit(root):
        return date.today()
    said = COMMIT if said is None else said
    found = day(said, root)
    warn(said, found, root)
    return found


def _lapsed(given: Inputs) -> Iterable[tuple[str, date]]:
    """Waivers that held on the day of the commit, and hold no longer."""
    now = date.today()
    for waiver in given.matrix.waivers:
        if waiver.holds(given.matrix.today) and waiver.expires is not None and waiver.expires < now:
            yield str(waiver.id), waiver.expires


def _templates(named: str | None, found: Assessment, root: Path) -> Path | None:
    """The folder of the project's own templates; raises T431 and T439."""
    from trackmarshal.trace.case.content import NAMES
    from trackmarshal.trace.case.templates import unused

    declared = found.project.case_templates
    if named is None and not declared:
        return None
    folder = Path(named) if named is not None else root / str(declared)
    if not folder.is_dir():
        file, line = (
            (None, None)
            if named is not None or declared is None
            else (declared.place.file, declared.place.line)
        )
        raise TrackmarshalError(
            "T431", f"there is no folder {folder}", file=file, line=line, help="name a folder with templates"
        )
    for name, meant in sorted(unused(folder, NAMES)):
        raise TrackmarshalError(
            "T439", f"the template `{name}` is used by nothing", file=str(folder / name),
            help=meant or "docs/safety-case.md lists the names of ours; one of your own is named by another one",
        )  # fmt: skip
    return folder


def _hashes(root: Path, baseline: object) -> dict[str, str]:
    """sha256 of the files below `requirements/`, and of the baseline."""
    from trackmarshal.cli.evidence import file_hash
    from trackmarshal.files import below
    from trackmarshal.trace.reading import FOLDER

    files, _ = below(root / FOLDER, (".yaml", ".yml"))
    paths = [*files, *([root / str(baseline)] if baseline and (root / str(baseline)).is_file() else [])]
    return {path.relative_to(root).as_posix(): file_hash(path) for path in paths}


def _write(folder: Path, made: Mapping[str, bytes]) -> None:
    """Each file whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in made.items():
        write_whole(folder / name, data)
