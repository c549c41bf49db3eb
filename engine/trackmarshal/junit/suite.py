"""Suites and tests of a report while it is read: what they say of themselves, in the words of several runners."""

from __future__ import annotations

import re
from collections.abc import Mapping

from trackmarshal.records.tests import ExternalTest

#: What `status` and `result` say of a test: GoogleTest, CTest and others write one even where nothing failed.
_PASSED = frozenset({"", "run", "passed", "pass", "success", "successful", "completed", "ok", "executed"})
_NOT_RUN = frozenset({"notrun", "disabled", "skipped", "suppressed", "pending", "ignored", "todo", "inconclusive"})  # fmt: skip
_FAILED = frozenset({"fail", "failed", "failure"})
#: What suites call tests that were not run, beside `skipped` and `disabled`: nose, pytest of old, and adapters of other frameworks.
_LEFT_OUT = (
    "skipped",
    "disabled",
    "skip",
    "skips",
    "ignored",
    "pending",
    "notrun",
    "not_run",
    "suppressed",
    "inconclusive",
    "todo",
)
#: What suites call tests that failed, beside `failures` and `errors`, which other runners add up; some count the same tests twice.
_BROKEN = ("failed", "failure", "error", "aborted", "crashed", "timeouts", "timedout", "timed_out", "flakes", "flaky")  # fmt: skip
#: Attributes whose word says what came of a test, or of a suite.
_WORDS = ("status", "result", "outcome", "verdict", "conclusion")
#: Attributes by which some say yes or no of a test, and what came of it where they say so.
_FLAGS = {
    "skipped": (True, "skipped"), "ignored": (True, "skipped"), "disabled": (True, "skipped"), "executed": (False, "skipped"),
    "success": (False, "failed"), "passed": (False, "failed"), "failed": (True, "failed"),
    "aborted": (True, "failed"), "crashed": (True, "failed"), "timedout": (True, "failed"), "timed_out": (True, "failed"),
}  # fmt: skip
_YES, _NO = frozenset({"true", "1", "yes"}), frozenset({"false", "0", "no"})
#: What Catch2 writes of hosts, in versions 2 and 3.
_CATCH2 = "tbd"
#: What Catch2 writes of a test that may fail, or should, where it did.
_MAY_FAIL = "TEST_CASE tagged with !mayfail"
#: The root of what pytest writes. It counts subtests, which it does not list.
_PYTEST = "pytest tests"
#: The suite of what pytest before 8.4 writes, whose root has no name. Of a test whose fixtures break behind it, it counts that it passed, too.
_PYTEST_BEFORE = ("", "pytest")
#: What pytest says of such a test.
_BEHIND = "failed on teardown"
#: When GoogleTest says that a test began that never did, in whichever time zone.
_NEVER = re.compile(r"(1970-01-01|1969-12-31)T\d\d:(00|15|30|45):00(\.0+)?Z?")
AGAIN = "write it anew with the test runner; its tests count for nothing as it is"
_SHOULD_FAIL = "Catch2 counts a test that is tagged `[!shouldfail]` and passes as failed, and lists it as passed, and with `-w NoAssertions` one without assertions too: take the tag away, and assert something"
_DOCTEST = (
    "doctest lists tests that took too long, and those that should fail and do not, as if they had passed",
    "let CTest run its tests, as `doctest_discover_tests` does, and name that report",
)
_PENDING = "if mocha-junit-reporter wrote it, give it the option `includePending=true`; otherwise write it anew; its tests count for nothing as it is"
_SUBTESTS = "if it has subtests, which pytest before 8.4 counts and does not list, have a newer one write it, or `--trackmarshal-results`; otherwise write it anew; its tests count for nothing as it is"
#: The attributes of root, suite and test as Meson writes them, in its order; from 1.10 on, it begins names of tests with the project's.
_MESON = (
    ("tests", "errors", "failures"),
    ("name", "tests", "errors", "failures", "skipped", "time"),
    ("name", "classname", "time"),
)
_TIMED_OUT = "let Meson 1.10 or later write it; its tests count for nothing as it is"
#: The attributes of root and suite as bats writes them. It counts tests that ended, and lists those that began.
_BATS = (("time",), ("name", "tests", "failures", "errors", "skipped", "time", "timestamp", "hostname"))
_REPLACED = "bats lists a test that was killed, or that ends in `exec`, as one that ended as the test before: mend it, and write the report anew; its tests count for nothing as it is"
#: From worst to best.
_ORDER = ("error", "failed", "skipped", "passed")


class Suite:
    """A suite that is open: what it says it holds, and what was found in it so far. Raises ValueError for a count that is none, and for a runner whose reports do not tell
    what passed, with what to do about it."""

    def __init__(self, attributes: Mapping[str, str], above: Suite | None, first: int) -> None:
        self.name: str = attributes.get("name", "") or (above.name if above else "")
        self.file: str = attributes.get("file", "") or (above.file if above else "")
        self.created: str = attributes.get("timestamp", "") or (above.created if above else "")
        self.first = first  #: the place of its first test among all
        self.requirements: list[str] = []
        self.tests = self.failing = self.skipping = 0
        self.at_once: list[int] = []  #: the places of its tests that passed and took no time at all
        self._root: str = above._root if above else attributes.get("name", "")
        #: Whether its counts are of assertions, as those of Catch2.
        self.asserts = attributes.get("hostname") == _CATCH2
        self.shape: tuple[tuple[str, ...], ...] = (*(above.shape if above else ()), tuple(attributes))
        self._perhaps_timed_out = (
            ""  #: a test that a Meson of before wrote, and that may not have come to its end
        )
        if "doctest_version" in attributes:
            raise ValueError(*_DOCTEST)
        self._above: Suite | None = above
        self._second: bool = above is not None and above._above is None
        self._broken = 0
        self._broke_behind = 0
        self._last: tuple[str, str] | None = None
        self._inner = False
        if above is not None:
            above._inner = True
        counts = ("tests", "failures", "errors", *_BROKEN, *_LEFT_OUT)
        self._said = {name: _count(attributes, name) for name in counts}
        self._counts = "tests" in attributes
        #: What it says came of it where that is no pass, with where it says so and the word.
        self._itself: list[tuple[str, str]] = []
        for name in _WORDS:
            self.status(name, attributes.get(name, ""))
        for name in ("success", "passed"):  # numbers of tests with other runners
            if attributes.get(name, "").strip().lower() in ("false", "no"):
                self._itself.append(("failed", f"`{name}` `{attributes[name]}`"))

    def status(self, name: str, word: str) -> None:
        """What came of it as a whole, by a word for that."""
        outcome = _outcome(word)
        if outcome != "passed":
            self._itself.append((outcome, f"`{name}` `{word}`"))

    def count(self, case: Case) -> None:
        """A test of it, or of a suite in it, is closed."""
        self.tests += 1
        self._broken += case.bad > 0
        if case.perhaps_timed_out:
            self._perhaps_timed_out = self._perhaps_timed_out or case.named[1]
        # One that failed before that is listed twice, and counted so.
        self._broke_behind += case.broke_behind and case.named != self._last
        self._last = case.named
        if not (self.asserts and case.excused):
            self.failing += case.bad
        # pytest counts each subtest that was skipped, and lists it in its test.
        several = self.asserts or self._root == _PYTEST
        self.skipping += case.skips if several else case.skips > 0

    def lacking(self) -> tuple[str, str]:
        """What it says it holds and does not list, and what to do about it; empty when there is nothing."""
        said = self._said
        before = (self._root, self.name) == _PYTEST_BEFORE
        listed = self.tests + (self._broke_behind if before else 0)
        if said["tests"] > listed and not self.asserts and self._root != _PYTEST:
            help_ = _PENDING if self._root == "Mocha Tests" else _SUBTESTS if before else AGAIN
            return f"the suite `{self.name}` says it has {said['tests']} tests, and lists {self.tests}", help_
        bad = max(said["failures"] + said["errors"], *(said[name] for name in _BROKEN))
        if bad > self.failing:
            help_ = _SHOULD_FAIL if self.asserts else AGAIN
            return f"the suite `{self.name}` says that {bad} tests failed, and lists {self.failing}", help_
        left_out = max(said[name] for name in _LEFT_OUT)  # some runners count the same tests in two of them
        if left_out > self.skipping:
            help_ = _PENDING if self._root == "Mocha Tests" else AGAIN
            message = (
                f"the suite `{self.name}` says that {left_out} tests were skipped, and lists {self.skipping}"
            )
            return message, help_
        for outcome, what in self._itself:
            contrary = self.tests > self.skipping if outcome == "skipped" else not self._broken
            if contrary:
                others = "tests that ran" if outcome == "skipped" else "no test that failed"
                return f"the suite `{self.name}` says of itself {what}, and lists {others}", AGAIN
        if self.shape == _BATS and self.tests > said["tests"]:
            return (
                f"the suite `{self.name}` says it has {said['tests']} tests, and lists {self.tests}",
                _REPLACED,
            )
        if self._perhaps_timed_out:
            message = f"the suite `{self.name}` lists `{self._perhaps_timed_out}` as passed, as Meson before 1.7 does of a test that did not end in time, too"
            return message, _TIMED_OUT
        return "", ""

    def to_do(self) -> bool:
        """Whether it lists tests beyond those that it counts and those that broke outside of them: jest-junit lists `test.todo` as if it had passed, and
        does not count it."""
        said = self._said
        outside = max(0, self._broken - said["failures"] - said["errors"])
        return (
            self._second
            and self._counts
            and not self._inner
            and not self.asserts
            and self.tests - outside > said["tests"]
        )


class Case:
    """A test that is open."""

    #: The longest message that is kept.
    MOST = 1_000

    def __init__(self, attributes: Mapping[str, str], suite: Suite, place: int) -> None:
        self._attributes = attributes
        self._suite = suite
        self._place = place
        self._outcome = "passed"
        self._message = ""
        self.requirements: list[str] = []
        self.failing = 0  #: how many failures and errors it names: some runners list several
        self.skips = 0  #: how often anything says that it was skipped, whatever else came of it
        self.excused = False  #: whether it was expected to fail
        self.broke_behind = False  #: whether its fixtures broke behind it
        for name in _WORDS:
            self.status(name, attributes.get(name, ""))
        for name in _FLAGS.keys() & attributes.keys():
            self._flag(name, attributes[name])
        if attributes.get("result") == "completed" and _NEVER.fullmatch(attributes.get("timestamp", "")):
            never = "it never began: that is what GoogleTest's time 1970-01-01 means, as where an Environment skips all tests; set the clock if it stood there"
            self.say("skipped", never)

    def status(self, name: str, word: str) -> None:
        """What it came to, by a word for that."""
        outcome = _outcome(word)
        self.skips += outcome == "skipped"
        if outcome:
            self._set(outcome, "")
        else:
            self._set("error", f"its {name} is `{word}`, of which it is not known whether that is a pass")

    def _flag(self, name: str, word: str) -> None:
        means, outcome = _FLAGS[name]
        said = word.strip().lower()
        if said not in _YES | _NO:
            self._set("error", f"its {name} is `{word}`, of which it is not known whether that is a pass")
        elif (said in _YES) == means:
            self.skips += outcome == "skipped"
            self._set(outcome, "")

    @property
    def bad(self) -> int:
        """How many failures and errors it stands for."""
        return max(self.failing, self._outcome in ("failed", "error"))

    @property
    def named(self) -> tuple[str, str]:
        """What it is called, and where."""
        return self._attributes.get("classname", ""), self._attributes.get("name", "")

    @property
    def perhaps_timed_out(self) -> bool:
        """Whether it passed by a report as a Meson writes it that does not tell that from what ran out of time."""
        classname, name = self.named
        return (
            self._outcome == "passed"
            and (*self._suite.shape, tuple(self._attributes)) == _MESON
            and classname == self._suite.name
            and not name.startswith(f"{classname}:")
        )

    @property
    def at_once(self) -> bool:
        """Whether it passed, and its runner says of its time no more than `0`."""
        return self._outcome == "passed" and self._attributes.get("time") == "0"

    def say(self, outcome: str, message: str, kind: str = "") -> None:
        """One of the elements that say what came of it, with its type."""
        self.failing += outcome != "skipped"
        self.broke_behind |= outcome == "error" and message.startswith(_BEHIND)
        if outcome == "skipped":
            self.skips += 1
            self.excused |= kind == "todo" or (self._suite.asserts and message == _MAY_FAIL)
        self._set(outcome, message)

    def explain(self, text: str) -> None:
        """The text of such an element, where it has no message."""
        self._message = self._message or text.strip()[: self.MOST]

    def _set(self, outcome: str, message: str) -> None:
        worse = _ORDER.index(outcome) < _ORDER.index(self._outcome)
        if worse or not self._message:
            self._message = message[: self.MOST]
        if worse:
            self._outcome = outcome

    def record(self, tool: str, report: str, digest: str) -> ExternalTest:
        a = self._attributes
        outcome, message = self._outcome, self._message
        if self.excused and outcome in ("failed", "error"):
            outcome = "skipped"
            message = f"it was expected to fail: {message}"[: self.MOST]
        return ExternalTest(
            a.get("classname", "") or self._suite.name, a.get("name", ""), tuple(dict.fromkeys(self.requirements)), outcome,
            message, a.get("file", "") or self._suite.file, _line(a.get("line", "")), _seconds(a.get("time", "")),
            tool, a.get("timestamp", "") or self._suite.created, report, self._place, digest,
        )  # fmt: skip


def _outcome(word: str) -> str:
    """What a word for what came of something means; empty where that is not known."""
    status = word.strip().lower()
    if status in _NOT_RUN:
        return "skipped"
    if status in _FAILED or status == "error":
        return "error" if status == "error" else "failed"
    return "passed" if status in _PASSED else ""


def _count(attributes: Mapping[str, str], name: str) -> int:
    text = attributes.get(name, "").strip()
    if not text or text.lower() in ("false", "no"):
        return 0
    if name in _BROKEN and text.lower() in ("true", "yes"):
        return 1
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise ValueError(f"`{name}` of a suite is `{text[:40]}`, no number of tests")
    return int(text)


def _line(text: str) -> int:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else 0


def _seconds(text: str) -> float | None:
    """A duration as runners write it, some with commas between thousands; None where it is no such number."""
    try:
        value = float(text.replace(",", ""))
    except ValueError:
        return None
    return value if 0.0 <= value < 1e12 else None
