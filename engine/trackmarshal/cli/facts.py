"""What a project's specs, scenarios and campaigns say, as far as the matrix is concerned, kept from one start to the next.

To know that a rule has not changed, it need not be compiled again: the files are the same that were read then.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.kept import kept
from trackmarshal.records.faults import FaultCase
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest

if TYPE_CHECKING:
    from trackmarshal.trace import Finding


@dataclass(frozen=True)
class Facts:
    """Rules, what they read, tests, by scenario what it is replayed with, faults, and what is wrong with the specs."""

    items: list[SpecItem]
    parts: list[SpecPart]
    tests: list[SpecTest]
    run_inputs: dict[str, dict[str, str]]
    fault_cases: list[FaultCase]
    findings: list[Finding]
    #: One hash of all that they were made from; empty where that is not known.
    state: str = ""

    @cached_property
    def _rules(self) -> dict[str, SpecItem]:
        """By name; of two with one name the first counts, as everywhere."""
        return {item.name: item for item in reversed(self.items)}

    def of_test(self, test: SpecTest) -> dict[str, str]:
        """What the result of a test is made from."""
        from trackmarshal.meaning.tool import tool

        return test.made_from(self._rules[test.rule].inputs, tool())


def facts(root: Path, folders: Iterable[str], files: Iterable[str], make: Callable[[], Facts]) -> Facts:
    """The facts of a project: those that are kept, where everything that they were made from is as it was then; else made now, and kept.

    folders: below which specs and requirements are looked for. files: what has to be looked at, whether it is there or not.
    """
    made, state = kept("facts", root, folders, files, make, _said, _read)
    return replace(made, state=state)


def _said(made: Facts) -> Mapping[str, Any]:
    return {
        "items": [item.to_json() for item in made.items],
        "parts": [part.to_json() for part in made.parts], "tests": [test.to_json() for test in made.tests], "run_inputs": made.run_inputs,
        "fault_cases": [case.to_json() for case in made.fault_cases],
        "findings": [[f.code, f.level, f.message, f.place, f.help, f.subject, f.also, f.about] for f in made.findings],
    }  # fmt: skip


def _read(said: Any) -> Facts:
    from trackmarshal.trace import Finding, Place

    return Facts(
        [SpecItem.from_json(item) for item in said["items"]],
        [SpecPart.from_json(part) for part in said["parts"]],
        [SpecTest.from_json(test) for test in said["tests"]],
        said["run_inputs"],
        [FaultCase.from_json(case) for case in said["fault_cases"]],
        [
            Finding(code, level, message, place and Place(*place), help_, subject, tuple((Place(*p), label) for p, label in also), tuple(about))
            for code, level, message, place, help_, subject, also, about in said["findings"]
        ],
    )  # fmt: skip
