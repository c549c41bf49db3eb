"""Results of other test runners: read from the reports that v-model.yaml names, and what is wrong with them."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import below, digest, read_regular
from trackmarshal.junit import reading
from trackmarshal.records import results_file
from trackmarshal.records.tests import ExternalTest
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error, warning
from trackmarshal.trace.model import Project, TestReport
from trackmarshal.trace.values import Placed

_BY_TESTS = "run its tests again, with `pytest --trackmarshal-results`; they count for nothing as it is"
#: What a test came to that passed with another version of its file.
STALE = "stale"
#: What a test may have come to, from worst to best.
_ORDER = ("error", "failed", STALE, "skipped", "passed")
#: In a regular expression a group that is repeated, in its first group; escapes and sets of characters are passed over.
_REPEATED = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]|(\)(?:\s|\(\?#[^)]*\))*[*+{])", re.DOTALL)


class External(NamedTuple):
    """A test of another runner, the stage that it is evidence at, and where it stands."""

    test: ExternalTest
    stage: Placed
    place: Place


def load(root: Path, project: Project, found: list[Finding]) -> tuple[External, ...]:
    """The tests of all reports in their order; what is wrong with reading them goes to `found` (T290, T330 to T335, T340, T341)."""
    return tuple(external for entry in project.junit for external in _of(root, entry, found))


def verdict(test: ExternalTest) -> tuple[str, str]:
    """Status and sentence of a test; only what passed covers. Raises ValueError for an outcome that is none."""
    match test.outcome:
        case "passed":
            return "covered", "passed"
        case "failed" | "error":
            return "failed", f"{test.outcome}: {test.message}" if test.message else test.outcome
        case "stale":
            return "stale", test.message
        case "skipped":
            return "missing", f"skipped: {test.message}" if test.message else "skipped"
        case other:
            raise ValueError(f"unknown outcome {other!r}")


def worst(tests: Iterable[External]) -> Iterator[External]:
    """Of tests that are called the same, such as one in two reports, the one that came to the worst; in their order."""
    found: dict[tuple[str, str], External] = {}
    for external in tests:
        key = (external.test.suite, external.test.name)
        other = found.setdefault(key, external)
        if _ORDER.index(external.test.outcome) < _ORDER.index(other.test.outcome):
            found[key] = external
    yield from found.values()


def _of(root: Path, entry: TestReport, found: list[Finding]) -> Iterator[External]:
    try:
        pattern = _pattern(entry.names) if entry.names else None
    except ValueError as problem:
        message = f"`{entry.names}` {problem}"
        found.append(error("T340", message, entry.names.place, "such as `S_1_[AB]_[0-9]+`", entry.path))
        return
    tests: list[ExternalTest] = []
    before = len(found)
    files = _files(root, entry, found)
    for shown in files:
        try:
            tests += _read(root / shown, shown, entry.tool)
        except TrackmarshalError as problem:
            if isinstance(problem, reading.Beside) and shown != entry.path:
                continue
            place = Place(shown, problem.line or 0)
            # Records of other kinds are written by commands of ours, these by the tests themselves.
            help_ = _BY_TESTS if problem.code == "T290" else problem.help or ""
            found.append(error(problem.code, problem.message, place, help_, entry.path))
        except OSError as problem:
            found.append(
                error("T331", problem.strerror or str(problem), Place(shown), "make it readable", entry.path)
            )
    if files and not tests and len(found) == before:
        message = f"the test report `{entry.path}` holds no test, so its tests were not run"
        found.append(error("T330", message, entry.path.place, "run the tests that write it", entry.path))
    if pattern is not None:
        tests = [_named(test, pattern) for test in tests]
    if tests and not any(test.requirements for test in tests):
        help_ = "let tests name what they verify: a property `verifies`, or `names` here"
        message = f"none of the {len(tests)} tests in `{entry.path}` names a requirement"
        found.append(warning("T341", message, entry.path.place, help_, entry.path))
    here: dict[str, str] = {}
    held: dict[str, str] = {}
    for test in tests:
        if test.file not in here:
            here[test.file] = _in_project(root, test.file)
        file = here[test.file]
        ran = [(test.file, test.file_hash), (test.collected, test.collected_hash)]
        for path, digest_ in ran:
            if digest_ and path not in held:
                held[path] = _held(root, path)
        changed = [path for path, digest_ in ran if digest_ and digest_ != held[path]]
        if test.outcome == "passed" and changed:
            what = "its file has changed since it ran" if held[changed[0]] else f"`{changed[0]}` is not there"
            test = replace(test, outcome=STALE, message=what)
        yield External(
            test, entry.stage, Place(file, test.line) if file else Place(test.report, test.report_line)
        )


def _pattern(names: str) -> re.Pattern[str]:
    """The expression that finds ids; raises ValueError for what is none, or may take time without end."""
    try:
        pattern = re.compile(names)
    except re.error as problem:
        raise ValueError(f"is no regular expression: {problem}") from problem
    if any(match[1] for match in _REPEATED.finditer(names)):
        raise ValueError("repeats a group, so that one long name may be tried in endless ways")
    return pattern


def _files(root: Path, entry: TestReport, found: list[Finding]) -> list[str]:
    """The report, or all in the folder: some runners write a file for each suite."""
    path = root / entry.path
    if path.is_file():
        return [str(entry.path)]
    files, problems = below(path, (".xml", ".json")) if path.is_dir() else ([], [])
    files = [file for file in files if file.suffix.lower() != ".json" or _records(file)]
    for problem in problems:
        message = problem.strerror or str(problem)
        found.append(error("T330", message, entry.path.place, "make the folder readable", entry.path))
    if not files and not problems:
        help_ = "run the tests that write it, or strike the entry"
        what = "holds no report" if path.is_dir() else "is not there"
        message = f"the test report `{entry.path}` {what}, so its tests were not run"
        level = warning if entry.if_there else error
        found.append(level("T330", message, entry.path.place, help_, entry.path))
    return [file.relative_to(root).as_posix() for file in files]


def _records(path: Path) -> bool:
    """Whether a file among reports is one of ours, whole or broken off, whatever comes first in it: runners leave other JSON there."""
    try:
        return results_file.FORMAT.encode() in read_regular(path, results_file.MAX_BYTES)
    except OSError:
        return True  # it may be, and reading it says why it cannot be read


def _read(path: Path, shown: str, tool: str) -> tuple[ExternalTest, ...]:
    """A report in XML, or records of external tests."""
    if path.suffix.lower() != ".json":
        return reading.read(path, shown, tool)
    file = results_file.load(path, shown)
    sha256 = hashlib.sha256(read_regular(path)).hexdigest()
    return tuple(
        replace(
            item,
            tool=tool or item.tool,
            created=item.created or file.created,
            report=shown,
            report_hash=sha256,
        )
        for item in file.items
        if isinstance(item, ExternalTest)
    )


def _named(test: ExternalTest, pattern: re.Pattern[str]) -> ExternalTest:
    """With the requirements that its name holds: `_` stands there for `-`, which names of functions cannot hold."""
    called = f"{test.suite}::{test.name}"
    found = (
        (match[1] if pattern.groups and match[1] is not None else match[0]).replace("_", "-")
        for said in (called, called.replace("_", "-"))
        for match in pattern.finditer(said)
    )
    return replace(test, requirements=tuple(dict.fromkeys((*test.requirements, *filter(None, found)))))


def _in_project(root: Path, file: str) -> str:
    """The file of a test from the project's folder; empty where it is not one of the project."""
    try:
        path = (root / file).resolve()
        inside = bool(file) and path.is_relative_to(root.resolve()) and path.is_file()
        return path.relative_to(root.resolve()).as_posix() if inside else ""
    except (OSError, ValueError, RuntimeError):
        return ""


def _held(root: Path, file: str) -> str:
    """The sha256 of what the file of a test holds now, wherever it is; empty where there is none."""
    try:
        return digest(read_regular(root / file))
    except (OSError, ValueError):
        return ""


#: What a requirement is that a test should not verify; of several, the second.
_UNKNOWN = ("which is no requirement", "which are no requirements")
_OBSOLETE = ("which is demanded no longer", "which are demanded no longer")


def check(project: Project, tests: tuple[External, ...]) -> Iterator[Finding]:
    """Tests of what is not demanded, that failed, that were skipped, or that ran as they are no more (T336 to T339, T383, T216)."""
    counting = {str(stage.id) for stage in project.stages if "external test" in stage.counts}
    stages = {str(stage.id) for stage in project.stages}
    for entry in project.junit:
        if entry.stage in stages and entry.stage not in counting:
            help_ = f"add `external test` to `counts` of {entry.stage}"
            message = f"`{entry.path}` is evidence at {entry.stage}, where external tests do not count"
            yield error("T339", message, entry.stage.place, help_, entry.path)
    skipped: dict[str, list[External]] = {}
    stale: dict[str, list[External]] = {}
    unnamed: dict[str, list[External]] = {}
    loose: dict[tuple[tuple[str, str], tuple[str, ...], str], list[External]] = {}
    for external in tests:
        test = external.test
        unknown = [id_ for id_ in test.requirements if id_ not in project.by_id]
        obsolete = [
            id_ for id_ in test.requirements if id_ in project.by_id and not project.by_id[id_].demanded
        ]
        for ids, why in ((unknown, _UNKNOWN), (obsolete, _OBSOLETE)):
            if ids:
                # Of several, a test is told by itself: who answers for one of them has not answered for the others.
                loose.setdefault((why, tuple(ids), test.name * (len(ids) > 1)), []).append(external)
        status, detail = verdict(test)
        if not test.requirements:
            if status == "failed":
                unnamed.setdefault(test.report, []).append(external)
            continue
        if status == "failed":
            message = f"the test `{test.name}` of `{test.suite}`: {detail}"
            yield error("T337", message, external.place, "", test.name)
        elif status == "missing":
            skipped.setdefault(test.report, []).append(external)
        elif status == "stale":
            stale.setdefault(test.report, []).append(external)
    # One cause for all tests of it: of a requirement that is struck, or whose file cannot be read, there may be hundreds.
    for (why, named, alone), those in loose.items():
        shown = ", ".join(f"`{id_}`" for id_ in named[:3])
        listed = (
            f"{shown} and {len(named) - 3} more" if len(named) > 3 else shown
        )  # a report may name thousands
        first, others = those[0].test, tuple(one.test.name for one in those[1:])
        which = f"the test `{first.name}` of `{first.suite}`"
        verifies = f"{which} and {len(others)} more verify" if others else f"{which} verifies"
        message = f"{verifies} {listed}, {why[len(named) > 1]}"
        help_ = did_you_mean(named[0], project.by_id) if why is _UNKNOWN else ""
        about = (*named[:3], first.name, *others)
        yield Finding("T336", "error", message, those[0].place, help_, alone or named[0], about=about)
    for report, those in skipped.items():
        said = "1 test was" if len(those) == 1 else f"{len(those)} tests were"
        message = f"{said} skipped in `{report}`, which counts as not covered"
        reasons = dict.fromkeys(one.test.message for one in those if one.test.message)
        help_ = "; ".join(["run what they need, or take the requirement away", *list(reasons)[:3]])
        yield warning("T338", message, those[0].place, help_, those[0].test.name)
    for report, those in unnamed.items():
        said = "1 test" if len(those) == 1 else f"{len(those)} tests"
        first = those[0].test
        message = f"{said} in `{report}` failed and named no requirement: `{first.name}` of `{first.suite}`: {verdict(first)[1]}"
        others = tuple(one.test.name for one in those[1:])
        help_ = "tests that do name one may depend on it, or may not have begun: mend it, and run them again"
        yield Finding("T383", "warning", message, those[0].place, help_, first.name, about=others)
    for report, those in stale.items():
        said = "1 test in `{}` is" if len(those) == 1 else f"{len(those)} tests in `{{}}` are"
        message = f"{said.format(report)} no longer what ran, which counts as not covered"
        others = tuple(one.test.name for one in those[1:])
        yield Finding(
            "T216", "warning", message, those[0].place, "run them again", those[0].test.name, about=others
        )
