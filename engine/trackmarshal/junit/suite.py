"""Suites and tests of a report while it is read: what they say of themselves, in the words of several runners."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal.records import ExternalTest

#: What `status` and `result` say of a test: GoogleTest, CTest and others write one even where nothing failed.
_PASSED = frozenset({"", "run", "passed", "pass", "success", "successful", "completed", "ok", "executed"})
_NOT_RUN = frozenset({"notrun", "disabled", "skipped", "suppressed", "pending", "ignored", "todo"})
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
#: Attributes by which some say yes or no of a test, and what came of it where they say so.
_FLAGS = {
    "skipped": (True, "skipped"), "ignored": (True, "skipped"), "disabled": (True, "skipped"), "executed": (False, "skipped"),
    "success": (False, "failed"), "passed": (False, "failed"), "failed": (True, "failed"),
}  # fmt: skip
_YES, _NO = frozenset({"true", "1", "yes"}), frozenset({"false", "0", "no"})
#: From worst to best.
_ORDER = ("error", "failed", "skipped", "passed")


class Suite:
    """A suite that is open: what it says it holds, and what was found in it so far. Raises ValueError for a count that is none."""

    def __init__(self, attributes: Mapping[str, str], above: Suite | None, first: int) -> None:
        self.name: str = attributes.get("name", "") or (above.name if above else "")
        self.file: str = attributes.get("file", "") or (above.file if above else "")
        self.created: str = attributes.get("timestamp", "") or (above.created if above else "")
        self.first = first  #: the place of its first test among all
        self.requirements: list[str] = []
        self.tests = self.failing = self.skipping = 0
        counts = ("tests", "failures", "errors", *_LEFT_OUT)
        self._said = {name: _count(attributes, name) for name in counts}

    def lacking(self) -> str:
        """What it says it holds and does not list; empty when there is nothing."""
        said = self._said
        if said["tests"] > self.tests:
            return f"the suite `{self.name}` says it has {said['tests']} tests, and lists {self.tests}"
        bad = said["failures"] + said["errors"]
        if bad > self.failing:
            return f"the suite `{self.name}` says that {bad} tests failed, and lists {self.failing}"
        left_out = max(said[name] for name in _LEFT_OUT)  # some runners count the same tests in two of them
        if left_out > self.skipping:
            return (
                f"the suite `{self.name}` says that {left_out} tests were skipped, and lists {self.skipping}"
            )
        return ""


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
        self.skipped = False  #: whether anything says so, whatever else came of it
        for name in ("status", "result"):
            self.status(name, attributes.get(name, ""))
        for name in _FLAGS.keys() & attributes.keys():
            self._flag(name, attributes[name])

    def status(self, name: str, word: str) -> None:
        """What it came to, by a word for that."""
        status = word.strip().lower()
        if status in _NOT_RUN:
            self.skipped = True
            self._set("skipped", "")
        elif status in _FAILED or status == "error":
            self._set("error" if status == "error" else "failed", "")
        elif status not in _PASSED:
            self._set("error", f"its {name} is `{word}`, of which it is not known whether that is a pass")

    def _flag(self, name: str, word: str) -> None:
        means, outcome = _FLAGS[name]
        said = word.strip().lower()
        if said not in _YES | _NO:
            self._set("error", f"its {name} is `{word}`, of which it is not known whether that is a pass")
        elif (said in _YES) == means:
            self.skipped |= outcome == "skipped"
            self._set(outcome, "")

    @property
    def bad(self) -> int:
        """How many failures and errors it stands for."""
        return max(self.failing, self._outcome in ("failed", "error"))

    def say(self, outcome: str, message: str) -> None:
        """One of the elements that say what came of it."""
        self.failing += outcome != "skipped"
        self.skipped |= outcome == "skipped"
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
        return ExternalTest(
            a.get("classname", "") or self._suite.name, a.get("name", ""), tuple(dict.fromkeys(self.requirements)), self._outcome,
            self._message, a.get("file", "") or self._suite.file, _line(a.get("line", "")), _seconds(a.get("time", "")),
            tool, a.get("timestamp", "") or self._suite.created, report, self._place, digest,
        )  # fmt: skip


def _count(attributes: Mapping[str, str], name: str) -> int:
    text = attributes.get(name, "").strip()
    if not text:
        return 0
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
