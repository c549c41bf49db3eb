"""The small records that the engine writes and `trackmarshal.trace` reads: specs, tests and runs as facts.

They travel as JSON: as results in the evidence store (`trackmarshal.store`), or one `ResultsFile` a file. Files are UTF-8,
strict JSON; paths in them are relative to the project, with forward slashes; times are ISO 8601 with an offset.
Fields are added over time and never renamed: readers ignore fields that they do not know and refuse files of a newer
version. Nothing here imports more than the standard library.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import read_regular, write_whole
from trackmarshal.json_text import named_twice

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

ITEM_KINDS = ("rule", "assume")
VERDICTS = ("satisfied", "violated", "undefined", "inactive", "open")
OUTCOMES = ("passed", "failed", "error")
#: What a test of another runner came to; only `passed` shows anything.
EXTERNAL_OUTCOMES = (*OUTCOMES, "skipped")


class Ref(NamedTuple):
    """A name that a spec mentions, and where: line and column from 1."""

    id: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class SpecItem:
    """A rule or an assumption of a spec, as far as traceability is concerned."""

    kind: str  #: "rule" or "assume"
    name: str
    title: str
    satisfies: tuple[Ref, ...]
    assuming: tuple[Ref, ...]
    file: str
    line: int
    column: int
    fingerprint: str  #: sha256 of what it means and of all that it reads
    severity: str = ""
    source: str = ""
    owner: str = ""  #: assumptions: who answers for it
    evidence: str = ""  #: assumptions: path of the record that backs it
    monitored: bool = (
        True  #: whether something is evaluated: always for rules, with a `monitor` for assumptions
    )
    compares: bool = True  #: whether it compares numbers, so that a test can sit exactly on its boundary
    #: sha256 by kind and name (`rule x`, `param y`, `signal z`) of all that `fingerprint` is made of; empty where that is not known
    inputs: Mapping[str, str] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "name": self.name, "title": self.title,
            "satisfies": [list(ref) for ref in self.satisfies], "assuming": [list(ref) for ref in self.assuming],
            "file": self.file, "line": self.line, "column": self.column, "fingerprint": self.fingerprint,
            "severity": self.severity, "source": self.source, "owner": self.owner, "evidence": self.evidence,
            "monitored": self.monitored, "compares": self.compares, "inputs": dict(self.inputs),
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> SpecItem:
        f = _Fields(data, "spec item")
        return cls(
            f.word("kind", ITEM_KINDS), f.text("name"), f.text("title", ""), f.refs("satisfies"), f.refs("assuming"),
            f.text("file"), f.count("line"), f.count("column"), f.text("fingerprint"), f.text("severity", ""),
            f.text("source", ""), f.text("owner", ""), f.text("evidence", ""), f.flag("monitored", True), f.flag("compares", True),
            f.words("inputs"),
        )  # fmt: skip


PART_KINDS = ("param", "table", "place", "signal", "constraint", "rulebook", "limit", "replay")


@dataclass(frozen=True, slots=True)
class SpecPart:
    """What rules read or rest on: a parameter, table, place or signal, or a constraint, which is called by its text; an order of rules; a limit of the Supervisor;
    or what a scenario or a campaign is replayed with beside its own file, a line each, which is called by the path of that.

    file: empty for a limit that no spec declares, so that it has its default, and for what is replayed.
    """

    kind: str
    name: str
    fingerprint: str  #: sha256 of what it means
    shown: str  #: as people read it, on one line
    file: str
    line: int
    column: int
    of: tuple[str, ...] = ()  #: the parameters and tables that a constraint restricts
    meant: str = ""  #: of a signal: the same as `fingerprint`, in whatever order its fields stand
    source: str = ""  #: of a parameter: where it comes from

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "name": self.name, "fingerprint": self.fingerprint, "shown": self.shown, "file": self.file,
            "line": self.line, "column": self.column, "of": list(self.of), "meant": self.meant,
            "source": self.source,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> SpecPart:
        f = _Fields(data, "spec part")
        return cls(
            f.word("kind", PART_KINDS), f.text("name"), f.text("fingerprint"), f.text("shown", ""), f.text("file"), f.count("line"),
            f.count("column"), f.texts("of"), f.text("meant", ""), f.text("source", ""),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class SpecTest:
    """A test written in a spec, not yet run."""

    rule: str
    title: str
    expects: str  #: a verdict
    boundary: bool  #: whether it expects a margin of 0 within a tolerance that is small against `distance`
    file: str
    line: int
    column: int
    fingerprint: str = ""  #: sha256 of what it gives and expects, worked out; empty where that is not known
    text: str = ""  #: sha256 of what is written of that
    distance: str = (
        ""  #: where it expects about 0: by how much limits are moved to see that it fails, as people read it
    )
    within: str = ""  #: the tolerance about 0, as people read it
    meant: str = ""  #: sha256 of what `text` comes to, parameters by name; empty where that is not known

    def made_from(self, rule: Mapping[str, str], engine: str) -> dict[str, str]:
        """All that its result is made from, by kind and name; `rule` is what its rule is made from."""
        moved = {"distance": self.distance} if self.boundary else {}
        return {**rule, "test": self.fingerprint, "engine": engine, **moved}

    def to_json(self) -> dict[str, Any]:
        return {
            "rule": self.rule, "title": self.title, "expects": self.expects, "boundary": self.boundary,
            "file": self.file, "line": self.line, "column": self.column, "fingerprint": self.fingerprint,
            "text": self.text, "distance": self.distance, "within": self.within, "meant": self.meant,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> SpecTest:
        f = _Fields(data, "spec test")
        return cls(
            f.text("rule"), f.text("title", ""), f.word("expects", VERDICTS), f.flag("boundary", False),
            f.text("file"), f.count("line"), f.count("column"), f.text("fingerprint", ""),
            f.text("text", ""), f.text("distance", ""), f.text("within", ""), f.text("meant", ""),
        )  # fmt: skip


def not_on_it(title: str, narrow: bool, distance: str, within: str, unmoved: str) -> str:
    """Why a test that expects a margin of about 0 does not stand on the boundary of its rule; empty where it does.

    narrow: whether `within`, its tolerance, is small against `distance`, by which limits are moved. unmoved: which way they can be moved
    so that it passes all the same.
    """
    if not narrow:
        return f'"{title}" takes any margin within {within} for 0, which is not small against {distance}'
    return f'"{title}" passes as well where the limits are {distance} {unmoved}' if unmoved else ""


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
        f = _Fields(data, "test result")
        return cls(
            f.text("rule"), f.text("title", ""), f.word("outcome", OUTCOMES), f.text("fingerprint"), f.text("message", ""),
            f.text("file"), f.count("line"), f.words("inputs"), f.text("unmoved", ""),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class RuleFacts:
    """What one rule said in one run: per candidate how often each verdict, and when it was first violated (s).

    `due` counts the cycles in which it was violated and the ground truth that judges it was unsafe.
    """

    rule: str
    fingerprint: str
    counts: Mapping[str, Mapping[str, int]]
    first_violation: float | None = None
    due: int = 0

    def number(self, *verdicts: str) -> int:
        """How many evaluations came to one of these verdicts, over all candidates."""
        return sum(count.get(verdict, 0) for count in self.counts.values() for verdict in verdicts)

    def to_json(self) -> dict[str, Any]:
        counts = {candidate: dict(count) for candidate, count in self.counts.items()}
        first = self.first_violation
        return {
            "rule": self.rule,
            "fingerprint": self.fingerprint,
            "counts": counts,
            "first_violation": first,
            "due": self.due,
        }

    @classmethod
    def from_json(cls, data: object) -> RuleFacts:
        f = _Fields(data, "rule facts")
        counts: dict[str, dict[str, int]] = {}
        for candidate, value in f.table("counts").items():
            inner = _Fields(value, f"rule facts: counts of `{candidate}`")
            counts[candidate] = {inner.verdict(verdict): inner.count(verdict) for verdict in inner.data}
        return cls(
            f.text("rule"), f.text("fingerprint"), counts, f.time("first_violation"), f.count("due", 0)
        )


@dataclass(frozen=True, slots=True)
class TruthFacts:
    """How a run compares with one kind of its ground truth (`dynamic`, `static`)."""

    inside: bool
    violations: tuple[
        str, ...
    ] = ()  #: where verdict and ground truth contradict each other, one sentence each
    rules: tuple[str, ...] = ()  #: the rules that this truth judges; empty: all

    def to_json(self) -> dict[str, Any]:
        return {"inside": self.inside, "violations": list(self.violations), "rules": list(self.rules)}

    @classmethod
    def from_json(cls, data: object) -> TruthFacts:
        f = _Fields(data, "ground truth")
        return cls(f.flag("inside"), f.texts("violations"), f.texts("rules"))


@dataclass(frozen=True, slots=True)
class LeastMargin:
    """The least margin of a rule for a candidate in a drive, outside of gaps of the map."""

    rule: str
    candidate: str
    margin: float  #: SI
    shown: str  #: how people read it, with its unit
    t: float  #: s from the first row of the log

    def to_json(self) -> dict[str, Any]:
        return {
            "rule": self.rule,
            "candidate": self.candidate,
            "margin": self.margin,
            "shown": self.shown,
            "t": self.t,
        }

    @classmethod
    def from_json(cls, data: object) -> LeastMargin:
        f = _Fields(data, "least margin")
        return cls(f.text("rule"), f.text("candidate"), f.finite("margin"), f.text("shown"), f.finite("t"))


@dataclass(frozen=True, slots=True)
class DriveFacts:
    """How long and how far a real vehicle was driven in a run, how often rules fired in it, and how near they came to it."""

    hours: float
    km: float
    firings: Mapping[str, int]  #: by rule, stretches of cycles in which it fired and the map was no cause
    least: tuple[LeastMargin, ...]

    def to_json(self) -> dict[str, Any]:
        return {
            "hours": self.hours,
            "km": self.km,
            "firings": dict(self.firings),
            "least": [one.to_json() for one in self.least],
        }

    @classmethod
    def from_json(cls, data: object) -> DriveFacts:
        f = _Fields(data, "drive")
        firings = _Fields(f.table("firings"), "firings of a drive")
        hours, km = f.finite("hours"), f.finite("km")
        if hours <= 0 or km < 0:
            raise _refused("drive: it takes time, and no way backwards")
        return cls(
            hours, km, {rule: firings.count(rule) for rule in firings.data},
            tuple(LeastMargin.from_json(one) for one in f.array("least")),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A replayed scenario: what was run, with which spec, and what came of it."""

    scenario: str  #: path relative to the project, as v-model.yaml declares it
    source_hash: str  #: sha256 of the scenario file's bytes
    spec_fingerprint: str
    cycles: int
    rules: tuple[RuleFacts, ...]
    ground_truth: Mapping[str, TruthFacts]
    fired: bool  #: whether any cycle was rated unsafe
    created: str
    #: sha256 by path (from the project, also out of it) of what the recording was made from, where it was made of a log
    made_from: Mapping[str, str] = field(default_factory=dict)
    #: rules of which no ground truth was declared, where the recording has any
    uncovered: tuple[str, ...] = ()
    #: sha256 by kind and name of all that it was made from beside the recording: `rule x` with all that this one reads, `engine`
    inputs: Mapping[str, str] = field(default_factory=dict)
    #: what the recording has in place of the spec's values, each with its reason, as people read it
    overrides: tuple[str, ...] = ()
    #: `plan.grip: A-FRICTION, friction`: an input that the recording lacks, and the rules that judge the spec's default instead
    defaults: Mapping[str, str] = field(default_factory=dict)
    #: by `signal.field`, between which values it was in the recording, in SI
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    #: of a run of a real vehicle's log: what the drive was, and how near rules came to firing
    drive: DriveFacts | None = None
    #: times [s] at which something was unsafe of which no ground truth says what to expect, the first ones
    unexpected: tuple[float, ...] = ()

    def to_json(self) -> dict[str, Any]:
        return {
            "scenario": self.scenario, "source_hash": self.source_hash, "spec_fingerprint": self.spec_fingerprint,
            "cycles": self.cycles, "rules": [facts.to_json() for facts in self.rules],
            "ground_truth": {kind: truth.to_json() for kind, truth in self.ground_truth.items()},
            "fired": self.fired, "created": self.created, "made_from": dict(self.made_from),
            "uncovered": list(self.uncovered), "inputs": dict(self.inputs), "overrides": list(self.overrides),
            "defaults": dict(self.defaults), "ranges": {name: list(ends) for name, ends in self.ranges.items()},
            **({"drive": self.drive.to_json()} if self.drive is not None else {}),
            **({"unexpected": list(self.unexpected)} if self.unexpected else {}),
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> RunSummary:
        f = _Fields(data, "run summary")
        return cls(
            f.text("scenario"), f.text("source_hash"), f.text("spec_fingerprint"), f.count("cycles"),
            tuple(RuleFacts.from_json(item) for item in f.array("rules")),
            {kind: TruthFacts.from_json(item) for kind, item in f.table("ground_truth").items()},
            f.flag("fired"), f.text("created"), f.words("made_from"),
            f.texts("uncovered"), f.words("inputs"), f.texts("overrides"), f.words("defaults"), f.ranges("ranges"),
            DriveFacts.from_json(f.data["drive"]) if "drive" in f.data else None,
            f.numbers("unexpected"),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class FaultCase:
    """A fault that a campaign declares, put in or not."""

    campaign: str  #: path relative to the project
    id: str
    title: str
    requirement: str
    line: int
    fingerprint: str  #: sha256 of all that its outcome depends on; empty when that is not known
    open: str = ""  #: why it cannot be put in
    says: str = ""  #: sha256 of what is put in, when, and what is expected
    begin: float | None = (
        None  #: the first cycle that is changed, s; None where it is not put in, or changes nothing
    )

    def to_json(self) -> dict[str, Any]:
        return {
            "campaign": self.campaign, "id": self.id, "title": self.title, "requirement": self.requirement, "line": self.line,
            "fingerprint": self.fingerprint, "open": self.open, "says": self.says, "begin": self.begin,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> FaultCase:
        f = _Fields(data, "fault")
        return cls(
            f.text("campaign"), f.text("id"), f.text("title"), f.text("requirement"), f.count("line"), f.text("fingerprint"),
            f.text("open", ""), f.text("says", ""), f.time("begin"),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class FaultResult:
    """What the Supervisor did about a fault: what found it, in which cycle (s) first, and what was driven then."""

    campaign: str
    id: str
    outcome: str  #: "passed": as expected, or "failed"
    fingerprint: str
    by: tuple[str, ...] = ()  #: rules and faults of the first unsafe cycle, the expected one first
    code: str = ""  #: the code of the first, if it is a fault
    first: float | None = None
    last: float | None = None
    driven: str = ""
    since: float | None = None  #: of which cycle the trajectory is that was driven instead
    lost: str = ""  #: why nothing stored was driven from `lost_at` on
    lost_at: float | None = None
    message: str = ""  #: how it differs from what was expected

    def to_json(self) -> dict[str, Any]:
        return {
            "campaign": self.campaign, "id": self.id, "outcome": self.outcome, "fingerprint": self.fingerprint, "by": list(self.by),
            "code": self.code, "first": self.first, "last": self.last, "driven": self.driven, "since": self.since, "lost": self.lost,
            "lost_at": self.lost_at, "message": self.message,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> FaultResult:
        f = _Fields(data, "fault result")
        return cls(
            f.text("campaign"), f.text("id"), f.word("outcome", OUTCOMES), f.text("fingerprint"), f.texts("by"), f.text("code", ""),
            f.time("first"), f.time("last"), f.text("driven", ""), f.time("since"), f.text("lost", ""), f.time("lost_at"),
            f.text("message", ""),
        )  # fmt: skip


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
        f = _Fields(data, "external test")
        return cls(
            f.text("suite"), f.text("name"), f.texts("requirements"), f.word("outcome", EXTERNAL_OUTCOMES), f.text("message", ""),
            f.text("file", ""), f.count("line", 0), f.time("duration"), f.text("tool", ""), f.text("created", ""),
            f.text("report", ""), f.count("report_line", 0), f.text("report_hash", ""), f.text("file_hash", ""),
            f.text("collected", ""), f.text("collected_hash", ""),
        )  # fmt: skip


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
        f = _Fields(data, "results file")
        if f.text("format", "") != FORMAT:
            raise _refused(f"not a results file: its format is not `{FORMAT}`")
        version = f.count("version")
        if version > VERSION:
            raise _refused(f"version {version} is newer than this program, which reads up to {VERSION}")
        holds = f.word("holds", tuple(_READERS))
        items = tuple(_READERS[holds](item) for item in f.array("items"))
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
            raise _refused(f"larger than {MAX_BYTES // 1_000_000} MB")
        return ResultsFile.from_json(strict(read_regular(path)))
    except TrackmarshalError as error:
        raise TrackmarshalError("T290", error.message, file=name, help=_HELP) from error
    except OSError as error:
        raise TrackmarshalError("T290", error.strerror or str(error), file=name, help=_HELP) from error
    except (ValueError, RecursionError) as error:
        line = error.lineno if isinstance(error, json.JSONDecodeError) else None
        reason = error.msg if isinstance(error, json.JSONDecodeError) else str(error)
        raise TrackmarshalError(
            "T290", f"not strict JSON: {reason}", file=name, line=line, help=_HELP
        ) from error


_HELP = "delete it: `trackmarshal import log --keep` makes the run of a log anew, `pytest --trackmarshal-results` what came of tests"
T = TypeVar("T")
_REQUIRED: Any = object()


class _Fields:
    """Typed access to a JSON object; raises T290 for what is missing or of the wrong kind."""

    def __init__(self, data: object, what: str) -> None:
        if not isinstance(data, dict):
            raise _refused(f"{what}: an object is expected, not {_kind(data)}")
        self.data: dict[str, Any] = data
        self.what = what

    def text(self, name: str, default: str = _REQUIRED) -> str:
        return self._get(name, default, str, "a text")

    def word(self, name: str, known: Sequence[str]) -> str:
        value = self.text(name)
        if value not in known:
            raise _refused(f"{self.what}: `{name}` is `{value}`, known are {', '.join(known)}")
        return value

    def verdict(self, name: str) -> str:
        if name not in VERDICTS:
            raise _refused(f"{self.what}: `{name}` is no verdict")
        return name

    def flag(self, name: str, default: bool = _REQUIRED) -> bool:
        return self._get(name, default, bool, "true or false")

    def count(self, name: str, default: int = _REQUIRED) -> int:
        value: int = self._get(name, default, int, "a whole number")
        if isinstance(value, bool) or value < 0:
            raise _refused(f"{self.what}: `{name}` must be a whole number from 0")
        return value

    def time(self, name: str) -> float | None:
        value = self.data.get(name)
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise _refused(f"{self.what}: `{name}` must be a number or null, not {_kind(value)}")
        try:
            return None if value is None else float(value)
        except OverflowError as error:  # a whole number of hundreds of digits
            raise _refused(f"{self.what}: `{name}` is beyond the range of IEEE double") from error

    def finite(self, name: str) -> float:
        value = self.time(name)
        if value is None or not math.isfinite(value):
            raise _refused(f"{self.what}: `{name}` must be a finite number")
        return value

    def array(self, name: str) -> list[Any]:
        value: list[Any] = self._get(name, [], list, "a list")
        return value

    def table(self, name: str, default: dict[str, Any] = _REQUIRED) -> dict[str, Any]:
        value: dict[str, Any] = self._get(name, default, dict, "an object")
        return value

    def numbers(self, name: str) -> tuple[float, ...]:
        """Numbers; none where it is not there."""
        found = self.array(name)
        if not all(type(each) in (int, float) for each in found):
            raise _refused(f"{self.what}: `{name}` must be a list of numbers")
        return tuple(map(float, found))

    def ranges(self, name: str) -> dict[str, tuple[float, float]]:
        """Two numbers by name, the lower one first; none where it is not there."""
        found = {}
        for key, ends in self.table(name, {}).items():
            if not (
                isinstance(ends, list)
                and [type(end) in (int, float) for end in ends] == [True, True]
                and ends[0] <= ends[1]
            ):
                raise _refused(f"{self.what}: `{name}` holds something else than ranges")
            found[key] = (float(ends[0]), float(ends[1]))
        return found

    def words(self, name: str) -> dict[str, str]:
        """Texts by name; none where it is not there."""
        value: dict[str, Any] = self._get(name, {}, dict, "an object")
        if not all(isinstance(item, str) for item in value.values()):
            raise _refused(f"{self.what}: `{name}` holds something else than texts")
        return dict(value)

    def texts(self, name: str) -> tuple[str, ...]:
        items = self.array(name)
        if not all(isinstance(item, str) for item in items):
            raise _refused(f"{self.what}: `{name}` must be a list of texts")
        return tuple(items)

    def refs(self, name: str) -> tuple[Ref, ...]:
        items = self.array(name)
        for item in items:
            if not (isinstance(item, list) and [type(part) for part in item] == [str, int, int]):
                raise _refused(f"{self.what}: `{name}` must be a list of [id, line, column]")
        return tuple(Ref(*item) for item in items)

    def _get(self, name: str, default: T, kind: type[T], said: str) -> T:
        value = self.data.get(name, default)
        if value is _REQUIRED:
            raise _refused(f"{self.what}: `{name}` is missing")
        if not isinstance(value, kind):
            raise _refused(f"{self.what}: `{name}` must be {said}, not {_kind(value)}")
        return value


def _texts(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise _refused("a list of texts is expected")
    return tuple(value)


def _kind(value: object) -> str:
    names = {
        dict: "an object",
        list: "a list",
        str: "a text",
        bool: "a Boolean",
        int: "a number",
        float: "a number",
    }
    return names.get(type(value), "null")


def _refused(message: str) -> TrackmarshalError:
    return TrackmarshalError("T290", message, help=_HELP)


def strict(data: bytes) -> Any:
    """What JSON says that has no NaN, no name twice in an object, of which readers take the one or the other, and no half of a pair of surrogates, which
    nobody can print; raises ValueError, also for nesting without end."""
    try:
        value = json.loads(data.decode("utf-8"), parse_constant=_no_constant, object_pairs_hook=_no_twins)
    except RecursionError as error:  # what it says differs by the version of Python
        raise ValueError("nested too deeply") from error
    if b"\\u" in data:
        try:
            json.dumps(value, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise ValueError("half a pair of surrogates is no character") from error
    return value


def _no_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        raise ValueError(f"`{named_twice(name for name, _ in pairs):.60}` is there twice in one object")
    return made


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is not strict JSON")
