"""Records of runs, checked and in numbers again: what all pages and pictures are drawn from."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.units import from_si

FORMAT, VERSION = "trackmarshal-run", 1
#: Letters of verdicts in records, and how pages name them. `-`: the cycle has no such candidate.
VERDICTS = {"s": "satisfied", "v": "violated", "u": "undefined", "i": "inactive", "o": "open", "-": "absent"}
UNSAFE = "vuo"
CANDIDATES = ("driving", "emergency")
DECISIONS = {"drive": "drive", "previous_emergency": "previous emergency", "no_safe_trajectory": "none safe"}
#: Fields of a rule that are taken from a record as they are.
RULE_FIELDS = ("name", "title", "what", "kind", "requirements", "unit", "because", "source", "span", "text")
#: A cycle's verdict holds until the next cycle, but not longer than this many usual cycles: then the record has a gap.
LONGEST_HOLD = 2.5
#: A margin below this share of the rule's median margin counts as near the bound.
NEAR = 0.25


@dataclass(frozen=True)
class Lane:
    """One rule on one candidate: a letter and a margin a cycle, in the rule's unit, the cycle of the least margin, where it fired."""

    verdict: str
    margin: list[float]
    least: Mapping[str, Any] | None
    firings: Sequence[Mapping[str, Any]]

    @property
    def fired(self) -> bool:
        return bool(self.firings)

    @cached_property
    def measured(self) -> list[float]:
        """Finite margins of the cycles in which the rule held or was violated."""
        return [m for m, letter in zip(self.margin, self.verdict) if letter in "sv" and math.isfinite(m)]


@dataclass(frozen=True)
class Rule:
    """A rule or a monitored assumption, with its lanes by candidate."""

    name: str
    title: str
    what: str
    kind: str
    requirements: Sequence[str]
    unit: str
    because: str
    source: str
    span: str
    text: str
    lanes: Mapping[str, Lane]
    #: The spec's scale for what it measures, in `unit`; None where it declares none.
    scale: float | None = None

    @property
    def fired(self) -> bool:
        return any(lane.fired for lane in self.lanes.values())

    @property
    def first(self) -> float:
        """When it first fired; infinite where it never did."""
        return min(
            (number(f["from"]) for lane in self.lanes.values() for f in lane.firings), default=math.inf
        )

    @cached_property
    def nearness(self) -> float:
        """The smallest margin as a share of the median one, over the candidates; infinite where the median is not positive.

        A margin that always is 0 (a trajectory that is made to end at rest) says nothing over time.
        """
        known = [margins for lane in self.lanes.values() if (margins := lane.measured)]
        return min(
            (max(0.0, min(margins)) / median(margins) for margins in known if median(margins) > 0.0),
            default=math.inf,
        )

    @property
    def matters(self) -> bool:
        """Whether its margins are drawn: it fired, or came near its bound."""
        return self.fired or self.nearness <= NEAR


@dataclass(frozen=True, slots=True)
class Run:
    """A run as pages need it. `t` in s, one entry a cycle; `end` is until when a cycle is shown to hold."""

    record: Mapping[str, Any]
    name: str
    t: list[float]
    end: list[float]
    #: "s", or "cycles" where the record's times cannot be used.
    time_unit: str
    rules: Sequence[Rule]
    safe: Mapping[str, Sequence[bool | None]]
    truth: Mapping[str, Sequence[bool | None]]
    decision: Sequence[str]
    #: Points of the borders, those that are finite, by side.
    track: Mapping[str, Sequence[tuple[float, float]]]

    @property
    def cycles(self) -> int:
        return len(self.t)

    @property
    def unsafe_cycles(self) -> int:
        """Cycles in which a candidate is unsafe or missing: those in which the planned trajectory is not driven."""
        return sum(decision != "drive" for decision in self.decision)

    @property
    def fired(self) -> list[Rule]:
        """The rules that fired, in the order in which they first did."""
        return sorted((rule for rule in self.rules if rule.fired), key=lambda rule: rule.first)

    def first_firing(self) -> tuple[Rule, str, Mapping[str, Any]] | None:
        """The first firing of all: its rule, candidate and record."""
        found = [
            (f["cycles"][0], r, c, f) for r in self.rules for c, lane in r.lanes.items() for f in lane.firings
        ]
        return min(found, key=lambda item: item[0])[1:] if found else None

    def beginnings(self) -> dict[int, list[tuple[Rule, str, Mapping[str, Any]]]]:
        """The cycles in which a rule fires for the first time in the run, with rule, candidate and firing."""
        found: dict[int, list[tuple[Rule, str, Mapping[str, Any]]]] = {}
        for rule in self.rules:
            first = min((f["cycles"][0] for lane in rule.lanes.values() for f in lane.firings), default=None)
            for candidate, lane in rule.lanes.items():
                found_here = [(rule, candidate, f) for f in lane.firings if f["cycles"][0] == first]
                if first is not None and found_here:
                    found.setdefault(int(first), []).extend(found_here)
        return dict(sorted(found.items()))

    def kind_unsafe(self, kind: str) -> list[bool]:
        """Per cycle, whether the rules that one ground truth judges are against it: as the run says, else those of the kind."""
        for truth in self.record["truths"]:
            if truth["kind"] == kind and truth.get("unsafe"):
                return list(truth["unsafe"])
        lanes = [lane.verdict for rule in self.rules if rule.kind == kind for lane in rule.lanes.values()]
        return [any(letters[i] in UNSAFE for letters in lanes) for i in range(self.cycles)]

    def judged_by(self, rule: Rule) -> str:
        """The kind of the first ground truth that judges a rule."""
        judging = [t["kind"] for t in self.record["truths"] if rule.name in t.get("rules", ())]
        by_name = any("rules" in t for t in self.record["truths"])
        return judging[0] if judging else "" if by_name else rule.kind

    def asked_of(self, rules: Sequence[Rule]) -> list[bool | None]:
        """Per cycle what the ground truth asks of some rules: True where none of them may be against it, False where one of them has to be, as
        no other rule could be the one that is, None where it leaves both."""
        kinds = {rule.name: self.judged_by(rule) for rule in rules}
        others = {self.judged_by(rule) for rule in self.rules if rule.name not in kinds}
        truths = {kind: self.truth.get(kind) or [None] * self.cycles for kind in kinds.values()}
        alone = [truth for kind, truth in truths.items() if kind not in others]
        of_all = zip(*truths.values()) if truths else [()] * self.cycles
        of_alone = zip(*alone) if alone else [()] * self.cycles
        return [False if False in own else all(values) or None for own, values in zip(of_alone, of_all)]

    def whole_truth(self) -> list[bool | None]:
        """All kinds of ground truth together: unsafe where one says so, safe where all do, else free."""
        kinds = [truth for truth in self.truth.values() if any(value is not None for value in truth)]
        together = zip(*kinds) if kinds else []
        return [False if False in values else None if None in values else True for values in together]

    def by_requirement(self) -> dict[str, list[Rule]]:
        """Rules by the first requirement that they satisfy, in the order of the requirements' names; "" comes last."""
        groups: dict[str, list[Rule]] = {}
        for rule in self.rules:
            groups.setdefault(rule.requirements[0] if rule.requirements else "", []).append(rule)
        return dict(sorted(groups.items(), key=lambda item: (item[0] == "", item[0])))


def read_run(record: Mapping[str, Any]) -> Run:
    """A record, checked; raises T291."""
    name = str(record.get("scenario", "?"))
    if record.get("format") != FORMAT:
        raise _bad(name, f"its format is {record.get('format')!r}, not {FORMAT!r}")
    if record.get("version") != VERSION:
        raise _bad(name, f"its version is {record.get('version')!r}, this tool reads {VERSION}")
    try:
        return _run(name, record)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise _bad(name, f"{type(error).__name__}: {error}") from error


def _run(name: str, record: Mapping[str, Any]) -> Run:
    t = [number(value) for value in record["t"]]
    unit = "s"
    if not all(math.isfinite(value) for value in t) or any(not a < b for a, b in itertools.pairwise(t)):
        t, unit = [float(i) for i in range(len(t))], "cycles"
    columns = {"decision": record["decision"], **{f"ego.{k}": v for k, v in record["ego"].items()}}
    columns |= {f"truths.{t['kind']}.unsafe": t["unsafe"] for t in record["truths"] if t.get("unsafe")}
    columns |= {f"ground_truth.{kind}": truth for kind, truth in record["ground_truth"].items()}
    for candidate in CANDIDATES:
        columns[f"{candidate}.safe"] = record["candidates"][candidate]["safe"]
        columns[f"{candidate}.paths"] = record["candidates"][candidate]["paths"]
    rules = []
    for entry in record["rules"]:
        lanes = {}
        shown = entry.get("shown") or "1"  # margins are shown in the unit in which the limit is written
        for candidate, lane in entry["candidates"].items():
            columns[f"{entry['name']}.{candidate}.verdict"] = lane["verdict"]
            columns[f"{entry['name']}.{candidate}.margin"] = lane["margin"]
            if unknown := set(lane["verdict"]) - set(VERDICTS):
                raise ValueError(f"unknown verdicts {sorted(unknown)}")
            margin = [math.nan if m is None else number(m) for m in lane["margin"]]
            if shown != "1":
                margin = [from_si(m, shown) for m in margin]
            lanes[candidate] = Lane(lane["verdict"], margin, lane["least"], lane["firings"])
        known = {field: entry[field] for field in RULE_FIELDS}
        scale = None if entry.get("scale") is None else from_si(number(entry["scale"]), shown)
        rules.append(Rule(**{**known, "unit": entry.get("shown") or entry["unit"]}, lanes=lanes, scale=scale))
    if unknown := set(record["decision"]) - set(DECISIONS):
        raise ValueError(f"unknown decisions {sorted(unknown)}")
    for column, values in columns.items():
        if len(values) != len(t):
            raise ValueError(f"{column} has {len(values)} entries for {len(t)} cycles")
    safe = {candidate: record["candidates"][candidate]["safe"] for candidate in CANDIDATES}
    track = {
        side: [(x, y) for x, y in map(_point, record["track"][side]) if math.isfinite(x) and math.isfinite(y)]
        for side in ("left", "right")
    }
    return Run(
        record, name, t, _ends(t), unit, rules, safe, record["ground_truth"], record["decision"], track
    )


def _point(pair: Sequence[object]) -> tuple[float, float]:
    x, y = pair
    return number(x), number(y)


def _ends(t: Sequence[float]) -> list[float]:
    if len(t) < 2:
        return [value + 0.1 for value in t]
    steps = [b - a for a, b in itertools.pairwise(t)]
    usual = median(steps)
    return [a + (step if step <= LONGEST_HOLD * usual else usual) for a, step in zip(t, [*steps, usual])]


def number(value: object) -> float:
    """A number of a record, its words for what is not finite included; raises ValueError for anything else."""
    if type(value) is float:  # nearly all are
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if value in ("nan", "inf", "-inf"):
        return float(str(value))
    raise ValueError(f"{value!r} is no number")


def stretches(values: Iterable[Any]) -> Iterator[tuple[Any, int, int]]:
    """Runs of equal neighbours: (value, first index, last index)."""
    first, current, index = 0, None, -1
    for index, value in enumerate(values):
        if index == 0:
            current = value
        elif value != current:
            yield current, first, index - 1
            first, current = index, value
    if index >= 0:
        yield current, first, index


def _bad(name: str, message: str) -> TrackmarshalError:
    return TrackmarshalError(
        "T291", f"run `{name}`: {message}", help="make the record with trackmarshal.scenarios.run_record"
    )
