"""A small project that passes the gate, and cases: one edit of it, and the findings that come of that.

A case file says what to do with the project before `expect`, and which findings appear after it, word for word:

    edit FILE         lines `- old` are replaced by lines `+ new`; the old ones occur once
    write FILE        lines `+ new` become the file
    bytes FILE TEXT   the file becomes these bytes, a Python literal
    size FILE NUMBER  the file becomes that many blanks
    link FILE TARGET  the file becomes a symbolic link
    remove FILE
    today DATE        instead of 2026-06-02
    expect

UPDATE_GOLDEN=1 in the environment writes what comes out instead of comparing; read it before it is committed.
"""

from __future__ import annotations

import ast
import os
import shutil
from datetime import date
from pathlib import Path

from trackmarshal import trace
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records import results_file
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace.findings import Place, error

HERE = Path(__file__).parent
PROJECT = HERE / "project"
TODAY = date(2026, 6, 2)
UPDATE = os.environ.get("UPDATE_GOLDEN") == "1"


class Small:
    """The project, or an edited copy of it."""

    def __init__(self, root: Path = PROJECT) -> None:
        self.root = root
        self.today = TODAY

    @classmethod
    def copy(cls, folder: Path) -> Small:
        shutil.copytree(PROJECT, folder / "project")
        return cls(folder / "project")

    def replace(self, file: str, old: str, new: str) -> Small:
        """Replace a text that occurs exactly once."""
        path = self.root / file
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1, f"{old!r} occurs {text.count(old)} times in {file}"
        path.write_text(text.replace(old, new), encoding="utf-8")
        return self

    def matrix(self) -> trace.Matrix:
        """The matrix, from the records in `records/`, read as a results folder is."""
        held = self._held()
        items = [item for item in held if isinstance(item, SpecItem)]
        tests = [item for item in held if isinstance(item, SpecTest)]
        cases = [item for item in held if isinstance(item, FaultCase)]
        parts = [item for item in held if isinstance(item, SpecPart)]
        results, unread = self._results()
        runs = [item for item in results if isinstance(item, RunSummary)]
        return trace.build(
            self.root, items, tests, [item for item in results if isinstance(item, TestResult)], runs, self.today,
            run_inputs=self._inputs(items), findings=unread,
            fault_cases=cases, fault_results=[item for item in results if isinstance(item, FaultResult)], parts=parts,
        )  # fmt: skip

    def _inputs(self, items: list[SpecItem]) -> dict[str, dict[str, str]]:
        """What each run rests on."""
        return {
            run.scenario: {f"rule {item.name}": item.fingerprint for item in items}
            for run in self._results()[0]
            if isinstance(run, RunSummary)
        }

    def _results(self) -> tuple[list[results_file.Record], list[trace.Finding]]:
        """What came out, and what is wrong with the files that say so."""
        results: list[results_file.Record] = []
        unread: list[trace.Finding] = []
        for path in sorted((self.root / "records").glob("*.json")):
            shown = f"records/{path.name}"
            try:
                file = results_file.load(path, shown)
            except TrackmarshalError as problem:
                place = Place(shown, problem.line or 0)
                unread.append(error(problem.code, problem.message, place, problem.help or ""))
            else:
                results += file.items
        return results, unread

    def _held(self) -> list[results_file.Record]:
        held: list[results_file.Record] = []
        for pattern in ("spec_*.json", "fault_cases.json"):
            for path in sorted((self.root / "records").glob(pattern)):
                held += results_file.load(path).items
        return held

    def accept(self, by: str = "the safety manager") -> None:
        """Accept what there is now."""
        held = self._held()
        items = [item for item in held if isinstance(item, SpecItem)]
        trace.accept_baseline(
            self.root,
            items,
            [item for item in held if isinstance(item, SpecTest)],
            [item for item in held if isinstance(item, FaultCase)],
            [item for item in held if isinstance(item, SpecPart)],
            self._inputs(items), by=by, reason="a case", today=TODAY,
        )  # fmt: skip

    def parts(self) -> tuple[list[SpecItem], list[SpecTest], list[TestResult], list[RunSummary]]:
        """The records, one list a kind, as callers of `build` hold them."""
        held: list[results_file.Record] = []
        for path in sorted((self.root / "records").glob("*.json")):
            held += results_file.load(path).items
        return (
            [item for item in held if isinstance(item, SpecItem)],
            [item for item in held if isinstance(item, SpecTest)],
            [item for item in held if isinstance(item, TestResult)],
            [item for item in held if isinstance(item, RunSummary)],
        )


def apply(small: Small, lines: list[str]) -> None:
    """Do what the lines of a case say."""
    number = 0
    while number < len(lines):
        words = lines[number].split(" ", 2)
        number += 1
        old: list[str] = []
        new: list[str] = []
        while number < len(lines) and lines[number][:1] in ("-", "+"):
            (old if lines[number][0] == "-" else new).append(lines[number][2:] + "\n")
            number += 1
            if number < len(lines) and old and new and lines[number][:1] == "-":
                break  # another hunk of the same file
        path = small.root / words[1] if len(words) > 1 else small.root
        match words[0]:
            case "edit":
                small.replace(words[1], "".join(old), "".join(new))
                if number < len(lines) and lines[number][:1] == "-":
                    lines.insert(number, f"edit {words[1]}")
            case "write":
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text("".join(new), encoding="utf-8")
            case "bytes":
                path.write_bytes(ast.literal_eval(words[2]))
            case "size":
                path.write_text(" " * int(words[2]), encoding="utf-8")
            case "link":
                path.symlink_to(words[2])
            case "accept":
                small.accept()
            case "remove":
                path.unlink()
            case "today":
                small.today = date.fromisoformat(words[1])
            case "" | "#":
                pass
            case _:
                raise ValueError(f"unknown directive {words[0]!r}")


def compare(path: Path, actual: str) -> None:
    """Hold a text against a golden file."""
    if UPDATE:
        path.write_text(actual, encoding="utf-8")
    assert actual == path.read_text(encoding="utf-8")
