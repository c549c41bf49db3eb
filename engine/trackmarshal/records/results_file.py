"""Files of records, all of one kind each: written whole or not at all, and read with every field looked at (T290)."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import read_regular, write_whole
from trackmarshal.json_text import named_twice, strict
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.fields import HELP, Fields, refused
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import ExternalTest, TestResult

FORMAT = "trackmarshal-results"
VERSION = 1
#: The largest results file that is read.
MAX_BYTES = 64_000_000

CODES = {
    "T290": (
        "a results file that cannot be read",
        "A file of records, a run that is kept (`import log --keep`) or what came of tests (`pytest --trackmarshal-results`), is not what writes "
        "such: no JSON, another format, a newer version, or a record with a field missing or of the wrong kind. Its contents count for nothing. "
        "Delete it, or write it again.",
    ),
}  # fmt: skip

Record = SpecItem | SpecPart | SpecTest | TestResult | RunSummary | FaultCase | FaultResult | ExternalTest

_READERS: dict[str, Callable[[object], Record]] = {
    "spec_items": SpecItem.from_json,
    "spec_parts": SpecPart.from_json,
    "spec_tests": SpecTest.from_json,
    "test_results": TestResult.from_json,
    "runs": RunSummary.from_json,
    "fault_cases": FaultCase.from_json,
    "fault_results": FaultResult.from_json,
    "external_tests": ExternalTest.from_json,
}


@dataclass(frozen=True, slots=True)
class ResultsFile:
    """The envelope of a results file: `items` are all of the one kind that `holds` names."""

    holds: str  #: "spec_items", "spec_parts", "spec_tests", "test_results", "runs", "fault_cases", "fault_results" or "external_tests"
    items: tuple[Record, ...]
    tool_version: str
    created: str

    def to_json(self) -> dict[str, Any]:
        return {
            "format": FORMAT, "version": VERSION, "tool_version": self.tool_version, "created": self.created,
            "holds": self.holds, "items": [item.to_json() for item in self.items],
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> ResultsFile:
        f = Fields(data, "results file")
        if f.text("format", "") != FORMAT:
            raise refused(f"not a results file: its format is not `{FORMAT}`")
        version = f.count("version")
        if version > VERSION:
            raise refused(f"version {version} is newer than this program, which reads up to {VERSION}")
        holds = f.word("holds", tuple(_READERS))
        items = tuple(_READERS[holds](item) for item in f.array("items"))
        twice = named_twice(item.scenario for item in items if isinstance(item, RunSummary))
        if twice is not None:
            raise refused(f"two runs of `{twice}`, and nothing says which one counts")
        return cls(holds, items, f.text("tool_version"), f.text("created"))


def save(path: Path, file: ResultsFile) -> None:
    """Write a results file, whole or not at all, creating its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(file.to_json(), ensure_ascii=False, allow_nan=False, indent=1) + "\n"
    write_whole(path, text.encode("utf-8"))


def load(path: Path, shown: str | None = None) -> ResultsFile:
    """Read a results file; raises T290. `shown` is the path that reports print."""
    name = shown or str(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise refused(f"larger than {MAX_BYTES // 1_000_000} MB")
        return ResultsFile.from_json(strict(read_regular(path)))
    except TrackmarshalError as error:
        raise TrackmarshalError("T290", error.message, file=name, help=HELP) from error
    except OSError as error:
        raise TrackmarshalError("T290", error.strerror or str(error), file=name, help=HELP) from error
    except (ValueError, RecursionError) as error:
        line = error.lineno if isinstance(error, json.JSONDecodeError) else None
        reason = error.msg if isinstance(error, json.JSONDecodeError) else str(error)
        raise TrackmarshalError(
            "T290", f"not strict JSON: {reason}", file=name, line=line, help=HELP
        ) from error
