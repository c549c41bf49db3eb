"""A report of a test runner, read: what each of its tests came to, and which requirements it names.

The file is input from elsewhere: document types and entities are refused, size and depth are bounded, and nothing that is not known is taken for
a pass.
"""

from __future__ import annotations

import codecs
import hashlib
import re
from dataclasses import replace
from pathlib import Path
from xml.parsers import expat

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import read_regular
from trackmarshal.junit.suite import AGAIN, Case, Suite
from trackmarshal.records.tests import ExternalTest

#: The largest report that is read.
MAX_BYTES = 64_000_000
#: How deep elements may nest; suites in suites need a few.
MAX_DEPTH = 60
#: The longest name of a test or a suite.
MAX_NAME = 4_000
#: How often a report may name requirements by what suites say of all of their tests.
MAX_NAMED = 5_000_000
#: The property, or attribute, by which a test or a suite names requirements.
VERIFIES = "verifies"
#: The property by which a test says what it came to where a report has no element for that: pytest writes of one that was expected to fail, and passed,
#: as of any other that passed.
OUTCOME = "trackmarshal-outcome"
#: The property by which Ginkgo says of a suite whether it passed: it may run out of time, or be focused, without a test that failed.
_SUCCEEDED = "SuiteSucceeded"
#: The property by which Qt Test says who wrote a report. Before Qt 6 it lists a test that skips without a word for that; by its source it lists so from then on
#: what failed as it was expected to, or is in its BLACKLIST.
_QT = "QTestVersion"
#: Roots of what stands among reports in a folder and is none: TestNG's own results of tests that Maven reports, coverage (coverage.py, gcovr), findings of linters.
_BESIDE = frozenset({"testng-results", "coverage", "checkstyle"})
#: With a document type: coverage, and what TestNG would run again. A `<suite>` without one may be of tests.
_BESIDE_TYPED = _BESIDE | {"suite"}

#: The root of what Maven's Failsafe leaves beside its reports, on the run as a whole. Of a run in which nothing broke it gives no result, or 254 where there
#: was no test; either may stand beside what a process said that ended.
_SUMMARY = "failsafe-summary"
_NOTHING_BROKE = frozenset({"", "null", "254"})

#: What may stand in a suite; `failure` and `error` there are about what all of its tests need.
_IN_SUITE = frozenset({"testsuite", "testcase", "properties", "system-out", "system-err", "failure", "error"})
_DECLARED = re.compile(
    rb"""(?:\xef\xbb\xbf)?<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]*)["']"""
)
_IN_UTF8 = "have the test runner write UTF-8; its tests count for nothing as it is"
_FAILED = frozenset({"failure", "rerunFailure", "flakyFailure"})
_ERROR = frozenset({"error", "rerunError", "flakyError"})
_SAYS = _FAILED | _ERROR | {"skipped"}
_SILENT = frozenset({"system-out", "system-err"})


def read(path: Path, shown: str, tool: str = "") -> tuple[ExternalTest, ...]:
    """The tests of a report, in their order; raises T331 to T335, as `Beside` for what is no report but may stand among them, OSError. `shown` is the path that reports print."""
    data = read_regular(path, MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise _refused("T334", shown, f"larger than {MAX_BYTES // 1_000_000} MB", None, "split it")
    digest = hashlib.sha256(data).hexdigest()
    return tuple(_Reader(shown, tool, digest, _encoding(data)).read(data))


def _encoding(data: bytes) -> str | None:
    """UTF-8 where the file says so in a word of its own, such as `utf8`, which Python's ElementTree writes, and the parser takes for another one."""
    declared = _DECLARED.match(data)
    try:
        return "utf-8" if declared and codecs.lookup(declared[1].decode()).name == "utf-8" else None
    except LookupError:
        return None  # which the parser says


def ids_in(text: str) -> list[str]:
    """The ids that a property names, with commas or blanks between them."""
    return [word for word in re.split(r"[,;\s]+", text) if word]


class Beside(TrackmarshalError):
    """XML of a kind that stands beside reports, as its root says."""


class _Reader:
    """One pass over the events of the parser."""

    def __init__(self, shown: str, tool: str, digest: str, encoding: str | None) -> None:
        self._shown = shown
        self._tool = tool
        self._digest = digest
        self._path: list[str] = []
        self._suites: list[Suite] = []
        self._case: Case | None = None
        self._silent = 0  # how deep in what is passed over
        self._property: tuple[str, str] | None = None
        self._text = ""
        self._run: dict[str, str] = {}  #: what a summary says of it
        self._tests: list[ExternalTest] = []
        self._left = MAX_NAMED
        #: What suites name, the inner ones first: of the tests from a number up to another one. Properties of a suite may stand behind its tests.
        self._of_all: list[tuple[int, int, list[str]]] = []
        self._parser = expat.ParserCreate(encoding)
        self._parser.buffer_text = True
        self._parser.StartDoctypeDeclHandler = self._document_type
        self._parser.EntityDeclHandler = self._document_type
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters

    def read(self, data: bytes) -> list[ExternalTest]:
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            message = expat.ErrorString(error.code)
            raise _refused("T331", self._shown, f"not XML: {message}", error.lineno, AGAIN) from error
        except (ValueError, LookupError) as error:  # an encoding that is none
            raise _refused(
                "T331", self._shown, f"not XML that can be read: {error}", None, _IN_UTF8
            ) from error
        return self._named_by_suites()

    def _named_by_suites(self) -> list[ExternalTest]:
        """The tests with what their suites name, each made once: in suites of suites, the outer ones name little of tests that have much already."""
        named: list[list[str]] = [[] for _ in self._tests]
        for first, end, requirements in self._of_all:
            for names in named[first:end]:
                names += requirements
        return [
            replace(t, requirements=tuple(dict.fromkeys((*t.requirements, *names)))) if names else t
            for t, names in zip(self._tests, named)
        ]

    def _document_type(self, root: str, *_: object) -> None:
        raise self._fail(
            "T332", "a document type is declared", "remove `<!DOCTYPE ...>`", root in _BESIDE_TYPED
        )

    def _fail(self, code: str, message: str, help_: str, beside: bool = False) -> TrackmarshalError:
        kind = Beside if beside else TrackmarshalError
        return kind(code, message, file=self._shown, line=self._parser.CurrentLineNumber, help=help_)

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        parent = self._path[-1] if self._path else ""
        self._path.append(name)
        if len(self._path) > MAX_DEPTH:
            raise self._fail("T334", f"nested more than {MAX_DEPTH} deep", "is this a report of tests?")
        if self._silent:
            self._silent += 1
        elif not parent:
            if name == _SUMMARY:
                self._run = attributes
                return
            if name not in ("testsuites", "testsuite"):
                raise self._fail("T333", f"the root is <{name}>, not <testsuites>", AGAIN, name in _BESIDE)
            self._open(attributes)
        elif parent in ("testsuites", "testsuite"):
            self._in_suite(name, attributes)
        elif parent == "testcase":
            self._in_case(name, attributes)
        elif parent == "properties":
            if name == "property":
                self._property = (attributes.get("name", ""), attributes.get("value", ""))
                self._text = ""
            else:
                self._beside(name, parent)
        elif parent == "property":
            self._beside(name, parent)
        elif parent == _SUMMARY and name == "failureMessage":
            self._text = ""
        else:  # in a failure, which may hold more than text
            self._silent = 1

    def _summary(self) -> TrackmarshalError:
        """A run that broke off is said to have there alone: of tests that a process took with it, no report tells."""
        result, timeout = self._run.get("result", ""), self._run.get("timeout", "false")
        if result in _NOTHING_BROKE and timeout == "false" and not self._text.strip():
            return self._fail("T333", f"the root is <{_SUMMARY}>, not <testsuites>", AGAIN, True)
        message = f"Failsafe says that its run failed or broke off (`result` `{result}`, `timeout` `{timeout}`): there may be tests that it lists nowhere"
        return self._fail("T335", message, "mend what failed, and run it again")

    def _in_suite(self, name: str, attributes: dict[str, str]) -> None:
        if name not in _IN_SUITE:
            raise self._fail("T333", f"<{name}> in a suite is not known", AGAIN)
        if name == "testsuite":
            self._open(attributes)
        elif name == "testcase":
            self._named(attributes)
            self._case = Case(attributes, self._suites[-1], self._parser.CurrentLineNumber)
            self._case.requirements += ids_in(attributes.get(VERIFIES, ""))
        elif name in ("failure", "error"):
            said = attributes.get("message", "")
            about = {"name": "the suite as a whole", "classname": self._suites[-1].name}
            case = Case(about, self._suites[-1], self._parser.CurrentLineNumber)
            case.say("failed" if name == "failure" else "error", said)
            self._close(case)
            self._silent = 1
        elif name in _SILENT:
            self._silent = 1

    def _in_case(self, name: str, attributes: dict[str, str]) -> None:
        assert self._case is not None
        if name in _SAYS:
            outcome = "failed" if name in _FAILED else "error" if name in _ERROR else "skipped"
            said = attributes.get("message", "")
            if name.startswith("flaky"):
                said = f"passed only when it was repeated: {said}".rstrip(": ")
            self._case.say(outcome, said, attributes.get("type", ""))
            self._text = ""
        elif name in _SILENT:
            self._silent = 1
        elif name != "properties":
            self._case.say("error", f"<{name}> in a test is not known, so it is not known what came of it")
            self._silent = 1

    def _beside(self, name: str, parent: str) -> None:
        """What stands among properties: all but an outcome, which is one wherever it stands, is passed over."""
        if name in _SAYS and self._case is None:
            raise self._fail("T333", f"<{name}> in <{parent}> is not known", AGAIN)
        if name in _SAYS and self._case is not None:
            self._case.say(
                "error", f"<{name}> in <{parent}> is not known, so it is not known what came of it"
            )
        self._silent = 1

    def _end(self, name: str) -> None:
        self._path.pop()
        if self._silent:
            self._silent -= 1
        elif name == _SUMMARY:
            raise self._summary()
        elif name == "property" and self._property is not None:
            called, value = self._property
            if called == VERIFIES:
                self._here().extend(ids_in(value or self._text))
            elif called == OUTCOME and self._case is not None:
                self._case.status(OUTCOME, value)
            elif called == _SUCCEEDED and self._case is None and value != "true":
                self._suites[-1].status(_SUCCEEDED, value)
            elif called == _QT:
                message = "Qt Test lists tests that were skipped, or that failed and are in its BLACKLIST, as if they had passed"
                raise self._fail("T333", message, "let CTest run its tests, and name that report")
            self._property = None
        elif name in _SAYS and self._case is not None:
            self._case.explain(self._text)
        elif name == "testcase" and self._case is not None:
            self._close(self._case)
            self._case = None
        elif name in ("testsuite", "testsuites"):
            suite = self._suites.pop()
            lacking, help_ = suite.lacking()
            if lacking:
                raise self._fail("T335", lacking, help_)
            for place in suite.at_once if suite.to_do() else ():
                self._tests[place] = replace(self._tests[place], outcome="skipped", message=_TO_DO)
            self._left -= len(suite.requirements) * (len(self._tests) - suite.first)
            if self._left < 0:
                message = f"its suites name requirements of their tests more than {MAX_NAMED} times"
                raise self._fail("T334", message, "name at each test what it verifies")
            if suite.requirements:
                self._of_all.append((suite.first, len(self._tests), suite.requirements))

    def _characters(self, text: str) -> None:
        if not self._silent and len(self._text) < Case.MOST:
            self._text += text[: Case.MOST]

    def _here(self) -> list[str]:
        return self._suites[-1].requirements if self._case is None else self._case.requirements

    def _open(self, attributes: dict[str, str]) -> None:
        self._named(attributes)
        above = self._suites[-1] if self._suites else None
        try:
            suite = Suite(attributes, above, len(self._tests))
        except ValueError as error:
            message, help_ = (*error.args, AGAIN)[:2]
            raise self._fail("T333", message, help_) from error
        suite.requirements += ids_in(attributes.get(VERIFIES, ""))
        self._suites.append(suite)

    def _named(self, attributes: dict[str, str]) -> None:
        for name in ("name", "classname"):
            if len(attributes.get(name, "")) > MAX_NAME:
                raise self._fail("T334", f"a name of more than {MAX_NAME} characters", "shorten it")

    def _close(self, case: Case) -> None:
        for suite in self._suites:
            suite.count(case)
        if case.at_once:
            self._suites[-1].at_once.append(len(self._tests))
        self._tests.append(case.record(self._tool, self._shown, self._digest))


_TO_DO = "its suite lists more tests than it counts, as jest-junit does where there is a `test.todo`, and this one took no time: strike what is to do"


def _refused(code: str, shown: str, message: str, line: int | None, help_: str) -> TrackmarshalError:
    return TrackmarshalError(code, message, file=shown, line=line, help=help_)
