"""Outcomes of tests that verify requirements, written as records at the end of a session."""

from __future__ import annotations

import os
import sysconfig
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from trackmarshal.pytest_plugin.ids import VERIFIES, project

#: The attribute of a report that has the hashes of its test's files; pytest-xdist carries it from its workers.
CARRIED = "trackmarshal_held"


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


class Results:
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
            held: dict[str, str] = getattr(report, CARRIED, {})
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
        root = project(self._config)
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
