"""Tests that say which requirements they verify: `@pytest.mark.verifies("S-1-B-1")`.

pytest loads this by itself where trackmarshal is installed; trackmarshal never does. Ids that the project does not demand are errors of collection. What a
test verifies becomes properties of pytest's own `--junitxml`, and records with `--trackmarshal-results PATH`, also under pytest-xdist.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import pytest

from trackmarshal.pytest_plugin.ids import VERIFIES, names_ids, verified
from trackmarshal.pytest_plugin.results import CARRIED, Results
from trackmarshal.pytest_plugin.showing import (
    pytest_pyfunc_call,
    pytest_runtest_call,
    pytest_runtest_setup,
    pytest_runtest_teardown,
)

#: pytest finds hooks by their names in this module; those of a plugin of their own could be left out, and what shows nothing would pass.
__all__ = [
    "pytest_addoption", "pytest_configure", "pytest_make_collect_report", "pytest_pyfunc_call", "pytest_runtest_call", "pytest_runtest_makereport",
    "pytest_runtest_setup", "pytest_runtest_teardown",
]  # fmt: skip

#: Whether a test failed so far, and what its property says of it.
_FAILED = pytest.StashKey[bool]()
_SAID = pytest.StashKey[str]()
#: Whether all was set up for a test that was not called yet.
_READY = pytest.StashKey[bool]()
#: By path from pytest's root directory, the sha256 of what files of tests held when they were collected: a test may run long after that, and
#: its file be another one by then. Where records are written.
_HELD = pytest.StashKey[dict[str, str]]()


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
    # Workers of pytest-xdist report to the one that started them.
    if path and not hasattr(config, "workerinput"):
        if not __debug__:
            said = "--trackmarshal-results: Python runs with -O, so that asserts do nothing, and what passes shows nothing"
            raise pytest.UsageError(said)
        config.pluginmanager.register(Results(config, Path(path).absolute()), "trackmarshal-results")


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
            ids, said = verified(item)
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
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
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
    if names_ids(item):
        held = item.config.stash.get(_HELD, {})
        files = (item.location[0], item.nodeid.partition("::")[0])
        setattr(report, CARRIED, {file: held[file] for file in files if file in held})
    item.stash[_READY] = report.when == "setup" and report.passed
    item.stash[_FAILED] = item.stash.get(_FAILED, False) or report.failed
    if said != before:
        from trackmarshal.junit.reading import OUTCOME

        item.stash[_SAID] = said
        item.user_properties.append((OUTCOME, said))
        report.user_properties = list(item.user_properties)
    return report


def _hold(config: pytest.Config, file: str) -> None:
    """Note what a file of tests holds, by its path from pytest's root directory, the first time that it is asked for; empty where it cannot be read."""
    from trackmarshal.files import digest, read_regular

    held = config.stash.setdefault(_HELD, {})
    if file not in held:
        try:
            held[file] = digest(read_regular(config.rootpath / file))
        except (OSError, ValueError):
            held[file] = ""
