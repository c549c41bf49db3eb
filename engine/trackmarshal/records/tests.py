"""What tests came to: those of specs, and those of other runners."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from trackmarshal.records.fields import Fields

OUTCOMES = ("passed", "failed", "error")
#: What a test of another runner came to; only `passed` shows anything.
EXTERNAL_OUTCOMES = (*OUTCOMES, "skipped")


@dataclass(frozen=True, slots=True)
class TestResult:
    """What a test came to, and of what."""

    __test__ = False  # for pytest: not a test class

    rule: str
    title: str
    outcome: str  #: "passed", "failed" or "error"
    fingerprint: str  #: of the rule that was tested
    message: str
    file: str
    line: int
    #: sha256 by kind and name of all that it was made from: the rule's inputs, `test`, `engine`; empty where only `fingerprint` is known
    inputs: Mapping[str, str] = field(default_factory=dict)
    unmoved: str = ""  #: of a test on its rule's boundary: "looser", "stricter" or both, where it passes as well with limits moved so

    def to_json(self) -> dict[str, Any]:
        return {
            "rule": self.rule, "title": self.title, "outcome": self.outcome, "fingerprint": self.fingerprint,
            "message": self.message, "file": self.file, "line": self.line, "inputs": dict(self.inputs), "unmoved": self.unmoved,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> TestResult:
        f = Fields(data, "test result")
        return cls(
            f.text("rule"), f.text("title", ""), f.word("outcome", OUTCOMES), f.text("fingerprint"), f.text("message", ""),
            f.text("file"), f.count("line"), f.words("inputs"), f.text("unmoved", ""),
        )  # fmt: skip


class Titled(Protocol):
    """A test, as far as it has a title."""

    @property
    def title(self) -> str: ...


_Test = TypeVar("_Test", bound=Titled)


def apart(tests: Iterable[_Test], says: Callable[[_Test], str]) -> tuple[list[_Test], tuple[str, ...]]:
    """Of the tests of a rule those that differ in more than their titles, and what the others repeat: a copy shows nothing more.

    says: the fingerprint of what a test gives and expects; empty where that is not known.
    """
    first: dict[str, _Test] = {}
    own, again = [], []
    for test in tests:
        said = says(test)
        other = first.setdefault(said, test) if said else test
        if other is test:
            own.append(test)
        else:
            again.append(f'"{test.title}" is "{other.title}" under another title')
    return own, tuple(again)


def not_on_it(title: str, narrow: bool, distance: str, within: str, unmoved: str) -> str:
    """Why a test that expects a margin of about 0 does not stand on the boundary of its rule; empty where it does.

    narrow: whether `within`, its tolerance, is small against `distance`, by which limits are moved. unmoved: which way they can be moved
    so that it passes all the same.
    """
    if not narrow:
        return f'"{title}" takes any margin within {within} for 0, which is not small against {distance}'
    return f'"{title}" passes as well where the limits are {distance} {unmoved}' if unmoved else ""


@dataclass(frozen=True, slots=True)
class ExternalTest:
    """What a test of another runner came to, and which requirements it says it verifies."""

    suite: str
    name: str
    requirements: tuple[str, ...]
    outcome: str  #: "passed", "failed", "error" or "skipped"
    message: str = ""
    file: str = ""  #: of the test, as its runner wrote it; empty when it did not
    line: int = 0  #: from 1; 0: not known
    duration: float | None = None  #: in s
    tool: str = ""
    created: str = ""  #: when it was run, as its runner wrote it
    report: str = ""  #: the file that says so, from the project's folder
    report_line: int = 0
    report_hash: str = ""  #: sha256 of that file's bytes
    file_hash: str = (
        ""  #: sha256 of what the file of the test held when it ran; empty where its runner does not say
    )
    collected: str = ""  #: where its class stands, if that inherits it from a class in another file
    collected_hash: str = ""  #: the same of that file

    def to_json(self) -> dict[str, Any]:
        return {
            "suite": self.suite, "name": self.name, "requirements": list(self.requirements), "outcome": self.outcome,
            "message": self.message, "file": self.file, "line": self.line, "duration": self.duration, "tool": self.tool,
            "created": self.created, "report": self.report, "report_line": self.report_line, "report_hash": self.report_hash,
            "file_hash": self.file_hash, "collected": self.collected, "collected_hash": self.collected_hash,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> ExternalTest:
        f = Fields(data, "external test")
        return cls(
            f.text("suite"), f.text("name"), f.texts("requirements"), f.word("outcome", EXTERNAL_OUTCOMES), f.text("message", ""),
            f.text("file", ""), f.count("line", 0), f.time("duration"), f.text("tool", ""), f.text("created", ""),
            f.text("report", ""), f.count("report_line", 0), f.text("report_hash", ""), f.text("file_hash", ""),
            f.text("collected", ""), f.text("collected_hash", ""),
        )  # fmt: skip
