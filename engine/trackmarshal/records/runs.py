"""What came of the runs of scenarios: what each rule said, how that fits the ground truth, and how a real vehicle was driven."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trackmarshal.json_text import named_twice
from trackmarshal.records.fields import Fields, refused
from trackmarshal.records.specs import VERDICTS


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
        f = Fields(data, "rule facts")
        counts: dict[str, dict[str, int]] = {}
        for candidate, value in f.table("counts").items():
            inner = Fields(value, f"rule facts: counts of `{candidate}`")
            counts[candidate] = {
                verdict: inner.count(verdict) for verdict in inner.names(VERDICTS, "verdict")
            }
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
        f = Fields(data, "ground truth")
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
        f = Fields(data, "least margin")
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
        f = Fields(data, "drive")
        firings = Fields(f.table("firings"), "firings of a drive")
        hours, km = f.finite("hours"), f.finite("km")
        if hours <= 0 or km < 0:
            raise refused("drive: it takes time, and no way backwards")
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
        f = Fields(data, "run summary")
        rules = tuple(RuleFacts.from_json(item) for item in f.array("rules"))
        twice = named_twice(facts.rule for facts in rules)
        if twice is not None:
            raise refused(f"run summary: the rule `{twice}` is there twice")
        return cls(
            f.text("scenario"), f.text("source_hash"), f.text("spec_fingerprint"), f.count("cycles"), rules,
            {kind: TruthFacts.from_json(item) for kind, item in f.table("ground_truth").items()},
            f.flag("fired"), f.text("created"), f.words("made_from"),
            f.texts("uncovered"), f.words("inputs"), f.texts("overrides"), f.words("defaults"), f.ranges("ranges"),
            DriveFacts.from_json(f.data["drive"]) if "drive" in f.data else None,
            f.numbers("unexpected"),
        )  # fmt: skip
