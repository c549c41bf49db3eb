"""Warnings of formulas that say something else than they seem to."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class EndsEarly(Diagnostic):
    code = "W307"
    title = "a quantifier that ends before a connective"
    level = "warning"
    text = "`{word}` ends before `{op}`"
    label = "it goes no further than this"
    remedy = "put parentheses around this, or around all that it is about, `{op}` included"
    explanation = (
        "What a quantifier or `always` is about ends before the next connective: `for all o in objects: p implies q` is `(for all o in objects: p) implies "
        "q`, which demands q only where p holds of all of them; `for all o in objects: (p implies q)` demands it wherever p holds of one. `always p and q` is "
        "`(always p) and q`, which demands q of the present sample alone. Parentheses say which is meant."
    )

    span: Span
    word: str
    op: str


class JoinsConditions(Diagnostic):
    code = "W311"
    title = "two consequences that are one"
    level = "warning"
    text = "this `{joined}` joins a consequence and a condition: one `{op}` stands in the other"
    label = "this is one condition of the other `{op}`"
    remedy = "put parentheses around each `{op}` with its own condition and consequence, or around this where it is meant"
    explanation = (
        "`and` and `or` bind tighter than `implies`, `iff` and `xor`: `a implies b and c implies d` is `a implies ((b and c) implies d)`, which demands "
        "nothing of b. `(a implies b) and (c implies d)` demands both."
    )

    span: Span
    joined: str
    op: str


class GoesOn(Diagnostic):
    code = "W308"
    title = "a temporal operator that goes on behind parentheses"
    level = "warning"
    text = "`{word}` is about the whole comparison, and not about `({number})` alone"
    label = "all of this is asked of another cycle or sample"
    remedy = "put parentheses around all that it is about: `{word} (...)`; of a number there is no `{word}`"
    explanation = (
        "Temporal operators are about formulas, and go on behind parentheses to the end of the comparison: `previous (ego.v) - ego.v <= 3 m/s` is "
        "`previous ((ego.v) - ego.v <= 3 m/s)`, which compares a number with itself. Within a plan, two samples are compared by `for all consecutive p, q "
        "in plan`; a number of another cycle is what a `state` remembers."
    )

    span: Span
    word: str
    number: str


class MetByOthers(Diagnostic):
    code = "W313"
    title = "an `implies` that others meet"
    level = "warning"
    text = "this `implies` below `{word}` holds wherever its left side does not"
    label = "{consequence}"
    remedy = 'write `and` where both are to hold, `not (...) or ...` where this is meant, or say in the rule why: `allow W313 because "..."`'
    explanation = (
        "`p implies q` holds where p does not. A demand on all of them needs that; what looks for one, picks some, or leaves some out has hardly "
        "meant those for which p does not hold: `exists o in objects: (p implies q)` is true as soon as there is one of these, and `where p implies q` "
        "takes in all of them. So it is of `whenever`, `except`, `once`, `eventually`, of what stands behind `until` and `since`, of what a `count` of cycles "
        "counts or is `reset` by, and of what is to be met `within` a time."
    )

    span: Span
    word: str
    consequence: str


class SameEverywhere(Diagnostic):
    code = "W314"
    title = "what does not change along a timeline"
    level = "warning"
    text = "`{word}` looks along `{timeline}`, and this is the same at each of its samples"
    label = "of the present cycle, whichever sample it is asked at"
    remedy = (
        "for what earlier or later cycles bring, write a rule without `along`; for the present one, leave the operator out, or say in the rule why: "
        '`allow W314 because "..."`'
    )
    explanation = (
        "In a rule with `along`, temporal operators look from sample to sample of that timeline. Events, `ego`, and whatever else does not speak of the sample are "
        "those of the present cycle at each of them: `once[0 s, 10 s] demand` is `demand`, whatever was ten seconds ago. Over the run, cycle by cycle, a rule without "
        "`along` looks."
    )

    span: Span
    word: str
    timeline: str
