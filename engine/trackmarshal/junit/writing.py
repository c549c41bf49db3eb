"""Results as a report in the XML that test runners write, for whoever shows such reports beside a change."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

#: What no XML 1.0 document may hold, not even escaped.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_WORDS = {"failed": "failure", "error": "error", "skipped": "skipped"}


@dataclass(frozen=True, slots=True)
class Line:
    """One test of a report. `outcome`: "passed", "failed", "error" or "skipped"; `kind` is what failed, in a word."""

    suite: str
    group: str  #: what it is about: readers sort by it
    name: str
    outcome: str = "passed"
    message: str = ""
    kind: str = ""
    file: str = ""
    line: int = 0
    verifies: tuple[str, ...] = ()


def render(name: str, lines: Iterable[Line]) -> str:
    """The report: suites in the order in which they occur first, tests in theirs. Raises KeyError for an unknown outcome."""
    suites: dict[str, list[Line]] = {}
    for line in lines:
        suites.setdefault(line.suite, []).append(line)
    every = [line for members in suites.values() for line in members]
    body = "".join(_suite(suite, members) for suite, members in suites.items())
    return f'<?xml version="1.0" encoding="utf-8"?>\n<testsuites{_head(name, every)}>\n{body}</testsuites>\n'


def _suite(name: str, lines: list[Line]) -> str:
    skipped = _attribute("skipped", sum(line.outcome == "skipped" for line in lines))
    return f" <testsuite{_head(name, lines)}{skipped}>\n{''.join(map(_test, lines))} </testsuite>\n"


def _head(name: str, lines: list[Line]) -> str:
    number = {outcome: sum(line.outcome == outcome for line in lines) for outcome in ("failed", "error")}
    counts = (
        ("name", name),
        ("tests", len(lines)),
        ("failures", number["failed"]),
        ("errors", number["error"]),
    )
    return "".join(_attribute(*count) for count in counts)


def _test(line: Line) -> str:
    place = _attribute("file", line.file) if line.file else ""
    place += _attribute("line", line.line) if line.file and line.line else ""
    head = f"  <testcase{_attribute('classname', line.group)}{_attribute('name', line.name)}{place}"
    inner = ""
    if line.verifies:
        said = "".join(
            f"<property{_attribute('name', 'verifies')}{_attribute('value', id_)}/>" for id_ in line.verifies
        )
        inner += f"   <properties>{said}</properties>\n"
    if line.outcome != "passed":
        word = _WORDS[line.outcome]
        where = (
            f"{line.file}:{line.line}: " if line.file and line.line else f"{line.file}: " if line.file else ""
        )
        kind = _attribute("type", line.kind) if line.kind else ""
        text = "" if word == "skipped" else escape(_fit(f"{where}{line.message}"))
        inner += f"   <{word}{_attribute('message', line.message)}{kind}>{text}</{word}>\n"
    return f"{head}>\n{inner}  </testcase>\n" if inner else f"{head}/>\n"


def _attribute(name: str, value: object) -> str:
    return f" {name}={quoteattr(_fit(str(value)))}"


def _fit(text: str) -> str:
    """Text with what XML cannot hold as `\\x1b`."""
    return _FORBIDDEN.sub(lambda found: found[0].encode("unicode_escape").decode(), text)
