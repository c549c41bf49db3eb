"""Rulebooks once more, from docs/rulebooks.md alone: what is ranked above what, which candidate is better, which are not beaten, and what contradicts itself."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

#: 0 kept, 1 violated, 2 undefined, and by how much.
Violation: TypeAlias = tuple[int, float]
Step: TypeAlias = tuple[str, str, str]


def violation(verdict: str, margin: float) -> Violation:
    if verdict == "violated":
        return 1, math.inf if math.isnan(margin) else max(0.0, -margin)
    return (2, math.inf) if verdict == "undefined" else (0, 0.0)


@dataclass(frozen=True)
class Book:
    """`chains`: rules and, between them, relations. What it builds on comes with `refines` or `extends`."""

    name: str
    chains: tuple[tuple[str, ...], ...]
    word: str = ""
    base: Book | None = None

    @property
    def text(self) -> str:
        builds = f"\n  {self.word} {self.base.name}\n " if self.base else ""
        return f"rulebook {self.name}{builds} {', '.join(' '.join(chain) for chain in self.chains)}"

    @property
    def own(self) -> set[str]:
        return {name for chain in self.chains for name in chain[::2]}

    @property
    def rules(self) -> set[str]:
        return self.own | (self.base.rules if self.base else set())

    @property
    def steps(self) -> list[Step]:
        ours = [
            (chain[i], chain[i + 1], chain[i + 2])
            for chain in self.chains
            for i in range(0, len(chain) - 2, 2)
        ]
        return [*(self.base.steps if self.base else []), *ours]

    def leads(self, upper: str, lower: str) -> bool:
        """Whether a way leads down from one to the other, of one step or more; to and fro over what ranks equal."""
        ways = [(a, b) for a, _, b in self.steps] + [(b, a) for a, how, b in self.steps if how != ">"]
        reached = {b for a, b in ways if a == upper}
        for _ in self.rules:
            reached |= {b for a, b in ways if a in reached}
        return lower in reached

    def above(self, upper: str, lower: str) -> bool:
        return self.leads(upper, lower) and not self.leads(lower, upper)

    @property
    def codes(self) -> set[str]:
        """With which of these it is refused; without any, it is not."""
        if any(how == ">" and self.leads(b, a) for a, how, b in self.steps):
            return {"E216", "E245"}
        if self.word == "refines" and self.base:
            old = self.base.rules
            if not all(self.above(one, new) for one in old for new in self.rules - old):
                return {"E246"}
        return set()

    @property
    def groups(self) -> list[set[str]]:
        """Rules that count as one."""
        found: list[set[str]] = []
        for rule in sorted(self.rules):
            group = {rule}
            for _ in self.rules:
                for a, how, b in self.steps:
                    if how == "&" and (a in group or b in group):
                        group |= {a, b}
            if group not in found:
                found.append(group)
        return found

    def better(
        self, mine: dict[str, Violation], theirs: dict[str, Violation], scales: dict[str, float]
    ) -> bool:
        def of(group: set[str], said: dict[str, Violation]) -> list[Violation]:
            sizes = scales if len(group) > 1 else {}
            return sorted(((said[r][0], said[r][1] / sizes.get(r, 1.0)) for r in group), reverse=True)

        pairs = [(min(group), of(group, mine), of(group, theirs)) for group in self.groups]
        gains = [rule for rule, ours, others in pairs if ours < others]
        losses = [rule for rule, ours, others in pairs if ours > others]
        return bool(gains or losses) and all(any(self.above(up, one) for up in gains) for one in losses)

    def outcome(
        self, mine: dict[str, Violation], theirs: dict[str, Violation], scales: dict[str, float]
    ) -> str:
        if self.better(mine, theirs, scales):
            return "better"
        if self.better(theirs, mine, scales):
            return "worse"
        groups = self.groups
        alike = all(
            sorted((mine[r][0], mine[r][1] / (scales[r] if len(group) > 1 else 1.0)) for r in group)
            == sorted((theirs[r][0], theirs[r][1] / (scales[r] if len(group) > 1 else 1.0)) for r in group)
            for group in groups
        )
        return "equal" if alike else "incomparable"

    def best(self, many: Sequence[dict[str, Violation]], scales: dict[str, float]) -> list[int]:
        return [i for i, one in enumerate(many) if not any(self.better(other, one, scales) for other in many)]


def book(dice: random.Random, name: str, rules: Sequence[str], base: Book | None = None) -> Book:
    """Mostly without a contradiction: `>` goes down between levels, which are alike for all books of these rules."""
    old = sorted(base.rules) if base else []
    word = dice.choice(["refines", "extends"]) if base else ""
    chains = []
    for _ in range(dice.randint(1, 3)):
        chain = [dice.choice(rules)]
        for _ in range(dice.randint(0, 3)):
            other = dice.choice([one for one in rules if one != chain[-1]])
            down = rules.index(chain[-1]) // 2 - rules.index(other) // 2
            how = dice.choice("~&") if down == 0 else ">"
            if down > 0 and dice.random() < 0.95:
                continue
            chain += [how, other]
        chains.append(tuple(chain))
    if word == "refines" and dice.random() < 0.8:  # what is new goes below all that is old
        new = sorted({name for chain in chains for name in chain[::2]} - set(old))
        chains += [(one, ">", below) for one in old for below in new]
    return Book(name, tuple(chains), word, base)
