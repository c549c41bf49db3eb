"""Pairs of rules that say the same thing in two ways, by the definitions of the language."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from support.generated.choices import Choices
from support.generated.formulas import Scope
from support.generated.inputs import Inputs
from support.generated.modules import ModuleWriter
from support.generated.vocabulary import TIMELINES


@dataclass(frozen=True)
class Laws:
    """A module with the rules `left_K` and `right_K` of each law, and cases.

    laws: what each one is called, and whether margins are equal too (else only verdicts are).
    """

    text: str
    cases: tuple[dict[str, Any], ...]
    laws: tuple[tuple[str, bool], ...]


#: Laws of two formulas p and q: left, right, whether their margins are equal too.
CONNECTIVES = (
    ("not (not {p})", "{p}", True),
    ("not ({p} and {q})", "(not {p}) or (not {q})", True),
    ("not ({p} or {q})", "(not {p}) and (not {q})", True),
    ("{p} implies {q}", "(not {p}) or {q}", True),
    ("{p} iff {q}", "not ({p} xor {q})", True),
    ("{p} xor {q}", "{q} xor {p}", True),
    ("{p} and {q}", "{q} and {p}", True),
    ("{p} or ({q} and {p})", "{p}", True),
    ("{p} iff {q}", "({p} and {q}) or ((not {p}) and (not {q}))", False),
)
#: Laws of two numbers a and b of one dimension.
COMPARISONS = (
    ("{a} < {b}", "not ({a} >= {b})", True),
    ("{a} <= {b}", "not ({a} > {b})", True),
    ("{a} == {b}", "not ({a} != {b})", True),
    ("{a} < {b}", "{b} > {a}", True),
    ("{a} in [{b}, {a}]", "({b} <= {a}) and ({a} <= {a})", True),
    ("abs({a} - {b}) >= abs({b} - {a})", "abs({b} - {a}) <= abs({a} - {b})", True),
)
#: Laws of a formula p of the variable x, and a guard g, over a domain.
QUANTIFIERS = (
    ("not (for all x in {d} where {g}: {p})", "exists x in {d} where {g}: (not {p})", True),
    ("for all x in {d} where {g}: {p}", "for all x in {d}: ({g} implies {p})", False),
    ("exists x in {d} where {g}: {p}", "exists x in {d}: ({g} and {p})", False),
    ("for all x in {d} where true: {p}", "for all x in {d}: {p}", True),
    ("for all x in {d}: {p}", "(for all x in {d}: {p}) and (for all x in {d} where {g}: {p})", True),
)
#: Laws of formulas p and q along a timeline, w a window (or none).
TIME = (
    ("not (always{w} {p})", "eventually{w} (not {p})", True),
    ("not (historically{w} {p})", "once{w} (not {p})", True),
    ("true until{w} {p}", "eventually{w} {p}", True),
    ("true since{w} {p}", "once{w} {p}", True),
    ("not (next {p})", "weak next (not {p})", True),
    ("not (previous {p})", "weak previous (not {p})", True),
    ("rising({p})", "{p} and (weak previous (not {p}))", True),
    ("falling({p})", "(not {p}) and (weak previous {p})", True),
    ("always{w} ({p} and {q})", "(always{w} {p}) and (always{w} {q})", True),
    ("{p} until {q}", "{q} or ({p} and (next ({p} until {q})))", True),
    ("{p} since {q}", "{q} or ({p} and (previous ({p} since {q})))", True),
    ("always {p}", "{p} and (weak next (always {p}))", True),
    ("once {p}", "{p} or (previous (once {p}))", True),
)


def laws(choices: Choices, depth: int = 2, cases: int = 3) -> Laws:
    """All laws of connectives and comparisons, and of quantifiers and time, on formulas of one scope."""
    module = ModuleWriter(choices)
    module.signals()
    writer = module.writer
    timeline = choices.pick(TIMELINES)
    fields = module.world.signals[timeline].dimensions()
    scope = replace(Scope().bind("s", fields, True), timeline=True, axes=1)
    p, q = writer.formula(depth, scope), writer.formula(depth, scope)
    a, b = (writer.number(dimension, depth - 1, scope) for dimension in [(1, 0), (1, 0)])
    domain = choices.pick(writer.domains)
    inner = replace(scope.bind("x", module.world.signals[domain].dimensions(), False), axes=2)
    guard, body = writer.formula(depth - 1, inner), writer.formula(depth, inner)
    named = [
        *((left.format(p=p, q=q), right.format(p=p, q=q), same) for left, right, same in CONNECTIVES),
        *((left.format(a=a, b=b), right.format(a=a, b=b), same) for left, right, same in COMPARISONS),
        *((left.format(d=domain, g=guard, p=body), right.format(d=domain, g=guard, p=body), same) for left, right, same in QUANTIFIERS),
    ]  # fmt: skip
    for left, right, same in TIME:
        window = writer.window()
        named.append((left.format(p=p, q=q, w=window), right.format(p=p, q=q, w=window), same))
    for index, (left, right, _) in enumerate(named):
        for side, condition in (("left", left), ("right", right)):
            module.lines += [
                f'rule {side}_{index} "one of two"',
                f"  along {timeline} as s",
                f"  require {condition}",
            ]
    inputs = Inputs(choices, module.world)
    dirt = [choices.pick((0, 0, 8, 20)) for _ in range(choices.integer(1, cases))]
    made = tuple(inputs.case(index, percent) for index, percent in enumerate(dirt))
    return Laws(module.text, made, tuple((f"{left}  ==  {right}", same) for left, right, same in named))
