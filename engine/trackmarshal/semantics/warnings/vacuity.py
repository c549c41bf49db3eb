"""Warnings of what says nothing: conditions that nothing or everything meets, and names that nothing asks for."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class UnusedVariable(Diagnostic):
    code = "E220"
    title = "a variable that is never used"
    level = "warning"
    text = "`{name}` is bound and never used"
    label = "nothing depends on it"
    explanation = (
        "A quantifier whose variable does not occur in its body says the same thing for every element. A `let` that no clause asks for, and a "
        "parameter that a definition does not look at, change nothing either: a name may be misspelt, or another thing be meant."
    )

    span: Span
    name: str


class NeverAsked(Diagnostic):
    code = "W304"
    title = "a state that nothing asks for"
    level = "warning"
    text = "nothing asks for the state `{name}`"
    label = "no rule depends on it"
    remedy = "remove it, or write a rule about it: `{name}{element} is ...`"
    explanation = "A machine that no rule and no definition asks for its state changes no verdict: a rule may have been forgotten, or a name misspelt."

    span: Span
    name: str
    element: str


class AllowsNothing(Diagnostic):
    code = "W303"
    title = "an allowance for nothing"
    level = "warning"
    text = "`allow {allowed}` allows nothing: there is no such warning here"
    label = "not needed"
    remedy = "remove it, so that it does not hide a warning later on"
    explanation = "A rule allows a warning that it does not give rise to. What was wrong may be mended; the next mistake would go unseen."

    span: Span
    allowed: str


class NeverHolds(Diagnostic):
    code = "W305"
    title = "a condition that never holds"
    level = "warning"
    text = "{what} never holds"
    label = "{consequence}"
    other_label = "nothing is left from here on"
    remedy = "mend it, or {otherwise}"
    explanation = (
        "No input that keeps the contract meets the condition, whatever parameters are set to within their ranges: a value outside of its declared "
        "range (perhaps in another unit), limits that exclude each other, or a denial of what is demanded further up. A `whenever` or a `where` like "
        "this turns its rule off without a word."
    )

    span: Span
    what: str
    consequence: str
    other: Span | None = None
    otherwise: str = 'say in the rule why this is meant: `allow W305 because "..."`'


class AlwaysHolds(Diagnostic):
    code = "W306"
    title = "a condition that always holds"
    level = "warning"
    text = "{what} always holds"
    label = "{consequence}"
    remedy = 'mend it, or say in the rule why this is meant: `allow W306 because "..."`'
    explanation = (
        "No input that keeps the contract is against the condition, whatever parameters are set to within their ranges: a rule that demands it is "
        "violated by nothing, and an exception like this leaves nothing over. A limit may be in another unit than it should, `or` stand for `and`, or "
        "the demand repeat what `whenever` or `where` asks already."
    )

    span: Span
    what: str
    consequence: str


class NoValue(Diagnostic):
    code = "W315"
    title = "a table that has no value"
    level = "warning"
    text = "the table `{table}` has no value {side} {end}, and what it is asked for may be {beyond}"
    label = "this is undefined there, which is never safe"
    remedy = (
        "say `clamp` behind how the table is read, so that the last value counts outside, give it more knots, leave these inputs out (`whenever`, `where`), or say in "
        'the rule why this is meant: `allow W315 because "..."`'
    )
    explanation = (
        "A table without `clamp` and without `wrap` has no value outside of its knots. Where the declared range of an input goes further, the rule is undefined "
        "there, which is never safe: a car that has a table of distances from 7.2 km/h on would not drive off."
    )

    span: Span
    table: str
    side: str
    end: str
    beyond: str


class NothingFound(Diagnostic):
    code = "W316"
    title = "an exception that leaves nothing to be found"
    level = "warning"
    text = "this exception is not about `{names}`: where it holds, all of `{domain}` are left out, and the rule is violated"
    label = "an `exists` of which nothing is left finds nothing"
    remedy = (
        "write `whenever not (...)` where the rule does not apply then, put it below the `for all` that it is about, or say in the rule why this is meant: "
        '`allow W316 because "..."`'
    )
    explanation = (
        "An `except` leaves elements out of the quantifier before it. Where it does not ask about the variables of that, it leaves out all of them or none: "
        "a `for all` then demands nothing, as was meant, and an `exists` finds nothing, which violates the rule. `exists p in plan`, `except emergency` is "
        "violated by every emergency trajectory."
    )

    span: Span
    names: str
    domain: str


class NeverStarts(Diagnostic):
    code = "W312"
    title = "a rule with which a Supervisor never starts"
    level = "warning"
    text = "nothing meets this demand as long as nothing was driven"
    label = "it asks for the `plan` of earlier cycles, of which there is none"
    remedy = (
        "say where it does not count, as in `not driven or ...` with an `event driven` (in a `count`, `driven and ...`), or say in the rule why this is meant: "
        '`allow W312 because "..."`'
    )
    explanation = (
        "In earlier cycles, `plan` is what was driven. Where that was nothing, it is undefined, and so is what asks for nothing else, as "
        "`historically[0 s, 1 s] plan.first.v < 5 m/s`: a Supervisor whose first cycle is not safe then drives in none, because nothing was driven before. "
        "A `count` takes each such cycle for one that may count: behind as many as its limit allows, nothing is known of it, and more of them follow."
    )

    span: Span
