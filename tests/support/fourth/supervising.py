"""What a Supervisor drives, from docs/supervisor.md and docs/memory.md alone: of rules that look back, at random specs and cycles."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from support.fourth.meaning import (
    COMPARISONS,
    FALSE,
    TRUE,
    UNKNOWN,
    Clause,
    Env,
    Formula,
    Range,
    Value,
    comparison,
    course,
    exists,
    for_all,
    judged,
    member,
)
from support.fourth.meaning import field as column
from support.fourth.running import scales
from support.fourth.writing import JOINED, SHADES, SPEED, M, Scope, Writer

#: What a Supervisor tells rules of each cycle.
TOLD = 'event emergency "e"\nevent driven "d"'
#: A rule as its clauses, its demand, and whether it is advisory.
Rule = tuple[list[Clause], Formula, bool]


def of_the_plan(writer: Writer, scope: Scope) -> Formula:
    """Asks for what is, or was, driven: a quantifier over its samples, undefined where nothing was, or whether it is the emergency trajectory,
    or anything at all.

    Inside a quantifier over a set, all of that would be undefined, also where the set is empty: it stands below an operator of its own there.
    """
    dice = writer.dice
    if dice.random() < 0.15:
        return Formula("driven", 5, lambda env: FALSE if env["cycles"][env["k"]]["plan"] is None else TRUE)
    if dice.random() < 0.2:
        return Formula("emergency", 5, lambda env: TRUE if env["cycles"][env["k"]]["emergency"] else FALSE)
    name = f"s{writer.dice.randrange(10**6)}"
    rng = Range((name,), "plan")
    dim, of = dice.choice([(M, "x"), (SPEED, "v"), (SPEED, "v")])
    body = comparison(
        column(name, of, dim), dice.choice(COMPARISONS), writer.number(dim, replace(scope, time=False), 0)
    )
    if dice.random() < 0.2:
        body = member(name, "tone", dice.choice(SHADES))
    bound = dice.choice([for_all, exists])(rng, body)

    def asked(env: Env) -> Value:
        return UNKNOWN if env["cycles"][env["k"]]["plan"] is None else bound.of(env)

    inside = any(of == "objects" for _, of in scope.records)
    text = f"(once[0 s, 0 s] ({bound.text}))" if inside else f"({bound.text})"
    return Formula(text, 5, asked, bound.free - {"plan"}, bound.dims)


class Cycle(NamedTuple):
    """As `meaning` takes it but for its plan, which is one of both; None: refused, and what was driven goes on."""

    stamp: float
    signals: dict[str, Any] | None
    driving: dict[int, Any]
    emergency: dict[int, Any]


class Decided(NamedTuple):
    """`against`: rule and candidate, advisory rules too."""

    state: str
    against: frozenset[tuple[str, str]]


@dataclass
class Deciding:
    """All cycles that were accepted, with what was driven in them as their plan.

    along: of rules that live along the course, whether they are judged at its last sample. lasting: how far the course goes back, in ns.
    """

    writer: Writer
    rules: dict[str, Rule]
    forget: int
    along: dict[str, bool] = field(default_factory=dict)
    lasting: int = 0
    past: list[dict[str, Any]] = field(default_factory=list)
    missed: int = 0
    stored: tuple[float, dict[int, Any]] | None = None
    ever: bool = False

    def step(self, cycle: Cycle) -> Decided:
        against = frozenset[tuple[str, str]]()
        if cycle.signals is not None:
            against = frozenset(
                (name, candidate)
                for candidate in ("driving", "emergency")
                for name in self.rules
                if self._judged(cycle, candidate, name) in ("violated", "undefined")
            )
        binding = [name for name, _ in against if not self.rules[name][2]]
        if cycle.signals is not None and not binding:
            self.stored, self.ever = (cycle.stamp, cycle.emergency), True
            self._remember(cycle, cycle.driving, False)
            return Decided("drive", against)
        if self.stored is not None and cycle.stamp > self.stored[0] + max(
            s["t"] for s in self.stored[1].values()
        ):
            self.stored = None
        self._remember(cycle, self._held(cycle.stamp), self.stored is not None)
        if self.stored is not None:
            return Decided("previous_emergency", against)
        return Decided("no_safe_trajectory" if self.ever else "no_emergency_yet", against)

    def _judged(self, cycle: Cycle, candidate: str, name: str) -> str:
        clauses, require, _ = self.rules[name]
        now = self._seen(cycle, getattr(cycle, candidate), candidate == "emergency")
        env: Env = {
            "cycles": [*self.past, now],
            "k": len(self.past),
            "scales": scales(self.writer, clauses, require),
        }
        if name in self.along:
            items, here = course(env["cycles"], env["k"], self.lasting, JOINED)
            place = len(items) - 1 if self.along[name] else here
            env |= {"course": items, "along": "p", "p": ("course", place)}
        return judged(clauses, require, {**env, "forget": self.forget, "places": {}}).verdict

    def _seen(self, cycle: Cycle, plan: dict[int, Any] | None, emergency: bool) -> dict[str, Any]:
        assert cycle.signals is not None
        told = {
            "plan": plan,
            "emergency": emergency,
            "stamp": round(cycle.stamp * 1e9),
            "missed": self.missed,
        }
        return {**cycle.signals, **told}

    def _remember(self, cycle: Cycle, plan: dict[int, Any] | None, emergency: bool) -> None:
        if cycle.signals is None:
            self.missed += 1
            return
        self.past.append(self._seen(cycle, plan, emergency))
        self.missed = 0

    def _held(self, stamp: float) -> dict[int, Any] | None:
        """The stored trajectory from the sample before now on, its times counted from now."""
        if self.stored is None:
            return None
        begun, samples = self.stored
        first = max(j for j, one in samples.items() if begun + one["t"] <= stamp)
        return {j: {**one, "t": one["t"] + begun - stamp} for j, one in samples.items() if j >= first}
