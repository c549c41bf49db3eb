"""Tests that say which requirements they verify: `@pytest.mark.verifies("S-1-B-1")`.

pytest loads this by itself where trackmarshal is installed; trackmarshal never does. Ids that the project does not demand are errors of collection. What a
test verifies becomes properties of pytest's own `--junitxml`, and records with `--trackmarshal-results PATH`, also under pytest-xdist.
"""

from __future__ import annotations

import os
import sysconfig
import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, wraps
from inspect import isawaitable, iscoroutinefunction, isgenerator
from pathlib import Path
from typing import Any
from unittest import TestCase

import pytest

VERIFIES = "verifies"
#: Whether a test failed so far, and what its property says of it.
_FAILED = pytest.StashKey[bool]()
_SAID = pytest.StashKey[str]()
#: Whether all was set up for a test that was not called yet.
_READY = pytest.StashKey[bool]()
#: By path from pytest's root directory, the sha256 of what files of tests held when they were collected: a test may run long after that, and
#: its file be another one by then. Where records are written.
_HELD = pytest.StashKey[dict[str, str]]()
#: The attribute of a report that has those of its test; pytest-xdist carries it from its workers.
_CARRIED = "trackmarshal_held"


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("trackmarshal")
    group.addoption(
        "--trackmarshal-results",
        metavar="PATH",
        help="write what came of tests that verify requirements (JSON)",
    )
    group.addoption(
        "--trackmarshal-project", metavar="DIR", help="the project whose requirements tests verify (default: the one around rootdir)"
    )  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", f"{VERIFIES}(*ids): the requirements that a test verifies")
    path = config.getoption("--trackmarshal-results")
    if path and not hasattr(
        config, "workerinput"
    ):  # workers of pytest-xdist report to the one that started them
        if not __debug__:
            said = "--trackmarshal-results: Python runs with -O, so that asserts do nothing, and what passes shows nothing"
            raise pytest.UsageError(said)
        config.pluginmanager.register(_Results(config, Path(path).absolute()), "trackmarshal-results")


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Tests get what they verify as properties; what is wrong with that fails the file or class that they stand in."""
    recorded = collector.config.getoption("--trackmarshal-results")
    if recorded and isinstance(collector, pytest.File):  # before it is imported
        _hold(collector.config, collector.nodeid)
    report = yield
    wrong: dict[str, None] = {}
    for item in report.result or ():
        if isinstance(item, pytest.Item):
            ids, said = _verified(item)
            item.user_properties += [(VERIFIES, id_) for id_ in ids]
            if ids and recorded:
                _hold(item.config, item.location[0])
            wrong |= dict.fromkeys(said)
    if wrong:
        report.outcome = "failed"
        report.longrepr = "\n".join(wrong)
        report.result = []
    return report


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A test says in a property what `--junitxml` does not tell from any other that passed: that it was expected to fail, that a plugin repeats it after it failed, that
    it was set up and never called, as with `--setup-only`, or that asserts do nothing, since Python runs with `-O`."""
    report = yield
    before = item.stash.get(_SAID, "")
    said = before
    if report.when == "setup" and item.stash.get(_FAILED, False):
        said = "failed"
    elif not before and ((report.passed and hasattr(report, "wasxfail")) or not __debug__):
        said = "skipped"
    elif not before and report.when == "teardown" and item.stash.get(_READY, False):
        said = "error"
    if _names(item):
        held = item.config.stash.get(_HELD, {})
        files = (item.location[0], item.nodeid.partition("::")[0])
        setattr(report, _CARRIED, {file: held[file] for file in files if file in held})
    item.stash[_READY] = report.when == "setup" and report.passed
    item.stash[_FAILED] = item.stash.get(_FAILED, False) or report.failed
    if said != before:
        from trackmarshal.junit.reading import OUTCOME

        item.stash[_SAID] = said
        item.user_properties.append((OUTCOME, said))
        report.user_properties = list(item.user_properties)
    return report


@contextmanager
def _threads_hold(item: pytest.Item) -> Iterator[None]:
    """What fails in a thread meanwhile fails a test that is to verify something: pytest passes it with a warning, which a filter may ignore."""
    if not _names(item):
        yield
        return
    before, failed = threading.excepthook, list[str]()

    def noted(args: threading.ExceptHookArgs) -> None:
        # With `sys.exit()` a thread ends as it is to; with a status or a word, it says that something is wrong.
        if not (isinstance(args.exc_value, SystemExit) and args.exc_value.code in (None, 0)):
            failed.append(f"{args.exc_type.__name__}: {args.exc_value}")
        before(args)

    threading.excepthook = noted
    try:
        yield
    finally:
        threading.excepthook = before
    if failed:
        said = f"this test is to verify a requirement, and a thread failed in it: {failed[0]}"
        pytest.fail(said, pytrace=False)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None]:
    with _threads_hold(item):
        return (yield)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None]:
    with _threads_hold(item):
        return (yield)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, object, object]:
    """A function that returns something has failed: what was to be asserted is handed to pytest, which passes it with a warning. So has one that
    a hook took for itself and did not call, as for a dry run."""
    called, said = pyfuncitem.obj, _Said("nothing called it in this process, so that its body never began")
    if not _names(pyfuncitem):
        return (yield)
    pyfuncitem.obj = said.of(called)
    try:
        result = yield
    finally:
        pyfuncitem.obj = called
    said.hold()
    return result


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None]:
    """So has what a thread fails, a method of a `unittest.TestCase` that returns something, and one that is a coroutine of which the class knows nothing:
    its body never began."""
    case = getattr(item, "instance", None)
    with _threads_hold(item):
        # Another `run`, as that of Twisted's trial, makes of what it is given what it likes.
        if not (
            isinstance(case, TestCase) and _names(item) and type(case).run.__module__.startswith("unittest.")
        ):
            return (yield)
        assert isinstance(item, pytest.Function)
        called, said = item.obj, _Said()
        item.obj = said.of(called)
        setattr(case, item.name, item.obj)  # where a method is a coroutine, pytest leaves it to the class
        try:
            yield
        finally:
            item.obj = called
        said.hold()


class _Said:
    """What came of calling the function of a test, noted in passing. uncalled: what is wrong where nothing does."""

    def __init__(self, uncalled: str = "") -> None:
        self._uncalled = uncalled
        self._wrong = ""

    def of(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function as one of its own kind: whoever runs it asks whether it is a coroutine."""
        if iscoroutinefunction(function):
            self._wrong = self._uncalled or (
                "nothing awaited it, so that its body never began: `unittest.IsolatedAsyncioTestCase` does"
            )

            @wraps(function)
            async def awaited(*args: object, **named: object) -> object:
                self._wrong = self._uncalled = ""
                return self._seen(await function(*args, **named))

            return awaited

        @wraps(function)
        def called(*args: object, **named: object) -> object:
            self._uncalled = ""
            return self._seen(function(*args, **named))

        return called

    def _seen(self, returned: object) -> object:
        if returned is not None:
            self._wrong = f"it returned something ({type(returned).__name__})"
            begun = not (isgenerator(returned) or isawaitable(returned))
            self._wrong += ", which asserts nothing: `assert` it" if begun else " whose body never began"
        return returned

    def hold(self) -> None:
        """Fail the test where what it did shows nothing."""
        wrong = self._wrong or self._uncalled
        if wrong:
            pytest.fail(f"this test is to verify a requirement, and {wrong}", pytrace=False)


def _hold(config: pytest.Config, file: str) -> None:
    """Note what a file of tests holds, by its path from pytest's root directory, the first time that it is asked for; empty where it cannot be read."""
    from trackmarshal.files import digest, read_regular

    held = config.stash.setdefault(_HELD, {})
    if file not in held:
        try:
            held[file] = digest(read_regular(config.rootpath / file))
        except (OSError, ValueError):
            held[file] = ""


def _names(item: pytest.Item) -> bool:
    """Whether a test names what it verifies."""
    return any(name == VERIFIES for name, _ in item.user_properties)


def _verified(item: pytest.Item) -> tuple[list[str], list[str]]:
    """The ids that a test names, nearest first, and what is wrong with them."""
    ids: dict[str, None] = {}
    wrong: list[str] = []
    for mark in item.iter_markers(VERIFIES):
        if mark.kwargs or not mark.args or not all(isinstance(id_, str) for id_ in mark.args):
            wrong.append('`verifies` takes ids of requirements: @pytest.mark.verifies("S-1-B-1")')
            continue
        ids |= dict.fromkeys(mark.args)
    known = _known(item.config) if ids else frozenset()
    other = _of_another(item) if ids else None
    if isinstance(known, str):
        wrong.append(known)
        ids = {}
    elif other is not None:  # which may have requirements of the same ids
        wrong.append(
            f"this verifies requirements of another project: run its tests by themselves, with --trackmarshal-project {other}"
        )
    else:
        wrong += [
            f"error[T336]: no requirement `{id_}` is demanded{_suggested(id_, known)}"
            for id_ in ids
            if id_ not in known
        ]
    if not wrong:  # where a test stands takes longer to find than all the rest
        return list(ids), []
    where = f"{item.location[0]}:{(item.location[1] or 0) + 1}"
    return list(ids), [f"{where}: {said}" for said in wrong]


def _suggested(id_: str, known: frozenset[str]) -> str:
    from trackmarshal.trace.findings import did_you_mean

    said = did_you_mean(id_, known)
    return f"; {said}" if said else ""


_KNOWN = pytest.StashKey[frozenset[str] | str]()


def _known(config: pytest.Config) -> frozenset[str] | str:
    """The ids of the project's requirements, or why they are not known."""
    if _KNOWN not in config.stash:
        from trackmarshal.trace import requirement_ids

        root = _project(config)
        if root is None:
            said = f"no project is around {config.rootpath}; name one with --trackmarshal-project DIR"
            config.stash[_KNOWN] = said
        else:
            config.stash[_KNOWN] = frozenset(map(str, requirement_ids(root)))
    known: frozenset[str] | str = config.stash[_KNOWN]
    return known


def _project(config: pytest.Config) -> Path | None:
    from trackmarshal.cli.project import MARKER, project_of

    named = config.getoption("--trackmarshal-project")
    if named is None:
        return project_of(config.rootpath)
    root: Path = (config.invocation_params.dir / named).resolve()
    if not (root / MARKER).is_file():
        raise pytest.UsageError(f"--trackmarshal-project: {root} has no {MARKER}")
    return root


def _of_another(item: pytest.Item) -> str | None:
    """Another project than that of this session in whose folder a test stands, from pytest's root directory; None where there is none."""
    own, root = _around(item.path.parent), _project(item.config)
    return None if own is None or own == root else Path(os.path.relpath(own, item.config.rootpath)).as_posix()


@cache
def _around(folder: Path) -> Path | None:
    """The project that a folder is in, or None; asked for each test."""
    from trackmarshal.cli.project import project_of

    return project_of(folder)


@dataclass(slots=True)
class _Seen:
    """What is known of a test so far."""

    ids: tuple[str, ...]
    file: str
    line: int
    held: str = ""  #: sha256 of what the file held when the test was collected
    collected: str = ""  #: the file of its class, where that inherits it from another file
    collected_held: str = ""
    outcome: str = ""
    message: str = ""
    duration: float = 0.0
    phases: set[str] = field(default_factory=set)


class _Results:
    """Outcomes of tests that verify requirements, kept until the end; only what ran from setup to teardown passed."""

    #: From worst to best.
    _ORDER = ("error", "failed", "skipped", "passed", "")

    def __init__(self, config: pytest.Config, path: Path) -> None:
        self._config = config
        self._path = path
        self._seen: dict[str, _Seen] = {}

    def pytest_sessionstart(self) -> None:
        """What an earlier session wrote is not what this one comes to, which may be killed before it writes."""
        if self._path.is_file():
            self._path.unlink()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        ids = tuple(str(value) for name, value in report.user_properties if name == VERIFIES)
        # What a worker of pytest-xdist took with it when it ended is told without a phase, and without properties.
        if not ids and report.when in ("setup", "call", "teardown"):
            return
        file, line, _ = report.location
        if report.nodeid not in self._seen:
            # What a class sets for tests that it inherits stands in its own file.
            collected = report.nodeid.partition("::")[0]
            if self._installed(file):
                file, line = collected, None
            own = "" if collected == Path(file).as_posix() else collected
            held: dict[str, str] = getattr(report, _CARRIED, {})
            self._seen[report.nodeid] = _Seen(
                ids, file, (line or 0) + 1, held.get(file, ""), own, held.get(own, "")
            )
        seen = self._seen[report.nodeid]
        seen.phases.add(report.when or "")
        seen.duration += report.duration
        outcome, message = _outcome(report)
        if self._ORDER.index(outcome) < self._ORDER.index(seen.outcome):
            seen.outcome, seen.message = outcome, message

    def pytest_sessionfinish(self) -> None:
        from datetime import UTC, datetime

        from trackmarshal import __version__
        from trackmarshal.records.results_file import ResultsFile, save
        from trackmarshal.records.tests import ExternalTest

        now = datetime.now(UTC).isoformat(timespec="seconds")
        items = []
        for nodeid, seen in sorted(self._seen.items()):
            suite, _, name = nodeid.partition("::")
            if seen.outcome == "passed" and not {"setup", "call", "teardown"} <= seen.phases:
                seen.outcome, seen.message = "error", "it did not run to its end"
            items.append(
                ExternalTest(
                    _whole(suite), _whole(name), tuple(dict.fromkeys(seen.ids)), seen.outcome, _whole(seen.message), self._shown(seen.file),
                    seen.line, seen.duration, f"pytest {pytest.__version__}", now, file_hash=seen.held,
                    collected=self._shown(seen.collected) if seen.collected else "", collected_hash=seen.collected_held,
                )
            )  # fmt: skip
        save(self._path, ResultsFile("external_tests", tuple(items), __version__, now))

    def _installed(self, file: str) -> bool:
        """Whether a file is of a package beside the project, as what hypothesis runs of a state machine: elsewhere it lies elsewhere, and
        which one it is was said where packages are pinned."""
        whole = (self._config.rootpath / file).resolve()
        return any(
            whole.is_relative_to(Path(sysconfig.get_path(kind)).resolve()) for kind in ("purelib", "platlib")
        )

    def _shown(self, file: str) -> str:
        """A path from the project's folder, where there is one."""
        root = _project(self._config)
        whole = self._config.rootpath / file
        return Path(os.path.relpath(whole, root)).as_posix() if root is not None else Path(file).as_posix()


def _whole(text: str) -> str:
    """A text without halves of pairs of surrogates, such as Python makes of bytes in names of files that are no UTF-8: no file can hold them."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _outcome(report: pytest.TestReport) -> tuple[str, str]:
    """What a phase of a test came to, in the words of records, and why."""
    match report.outcome:
        case "passed" if hasattr(
            report, "wasxfail"
        ):  # it shows nothing: who wrote it says that it cannot pass
            return "skipped", f"it was expected to fail, and passed: {report.wasxfail}"[:1_000]
        case "passed":
            return "passed", ""
        case "skipped":
            reason = (
                report.longrepr[2] if isinstance(report.longrepr, tuple) else getattr(report, "wasxfail", "")
            )
            return "skipped", str(reason)[:1_000]
        case "failed":
            crash = getattr(report.longrepr, "reprcrash", None)
            message = str(getattr(crash, "message", None) or report.longrepr)
            return ("failed" if report.when == "call" else "error"), message[:1_000]
        case other:  # a plugin repeats what failed, until it passes
            return "failed", f"passed only when it was repeated: {other}"
