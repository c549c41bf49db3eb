"""Errors of rules, assumptions and rulebooks."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class UnknownRequirement(Diagnostic):
    code = "E206"
    title = "satisfies nothing"
    text = "there is no requirement `{name}`"
    label = "not in the requirements of this project"
    remedy = "{hint}"
    explanation = "What a rule satisfies must exist in the project's requirements, else the traceability matrix would have a loose end."

    span: Span
    name: str
    hint: str = ""


class ClauseProblem(Diagnostic):
    code = "E213"
    title = "a clause is missing, double or misplaced"
    text = "{problem}"
    other_label = "the first one is here"
    remedy = "{hint}"
    explanation = (
        "A rule has exactly one `require`, an assumption at most one `monitor`, and the clauses that these are about come before "
        "them: first `whenever` and `along`, at most one each, then quantifiers, each followed by its `except` clauses."
    )

    span: Span
    problem: str
    hint: str = ""
    other: Span | None = None


class JudgedNowhere(Diagnostic):
    code = "E271"
    title = "a sample at which no rule can be judged"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "`along plan as p` judges a rule at the first sample of the timeline, `along plan as p at last` at the last one. Along a course, which "
        "begins in the past, a rule is judged at the sample that is now, unless it says `at last`."
    )

    span: Span
    problem: str
    hint: str = ""


class RulebookCycle(Diagnostic):
    code = "E216"
    title = "a rulebook that contradicts itself"
    text = "rule `{name}` outranks itself: {cycle}"
    label = "this closes the circle"
    remedy = "remove one of these relations, or give the rules equal rank with `~`"
    explanation = "`>` is strict: no rule may stand above itself, directly or over others of equal rank."

    span: Span
    name: str
    cycle: str


class RulebookBases(Diagnostic):
    code = "E244"
    title = "rulebooks that build on each other in a circle"
    text = "the rulebook `{name}` builds on itself: {cycle}"
    label = "this closes the circle"
    remedy = "let one of them stand by itself"
    explanation = "A rulebook `refines` or `extends` one that is complete without it."

    span: Span
    name: str
    cycle: str


class RulebookContradicts(Diagnostic):
    code = "E245"
    title = "a rulebook that contradicts the one that it builds on"
    text = "`{name}` would outrank itself: {cycle}"
    label = "this contradicts `{base}`"
    other_label = "this is how `{base}` ranks them"
    remedy = "leave it out, or write a rulebook of its own without `{base}`"
    explanation = (
        "What a rulebook `refines` or `extends` stays in force: a rule that outranks another one there still does, and rules that rank equal there "
        "still do. Rules that are not ranked there may be."
    )

    span: Span
    other: Span
    name: str
    cycle: str
    base: str


class RulebookNotRefined(Diagnostic):
    code = "E246"
    title = "a refinement that may take back a preference"
    text = "`{name}` is new to `{base}`, and not ranked below `{rule}`"
    label = "`{rule}` does not outrank it"
    other_label = "this promises to keep every preference of `{base}`"
    remedy = "rank it below all rules of `{base}`, or write `extends {base}`, which keeps the ranks and may take back preferences"
    explanation = (
        "A rulebook that `refines` another one keeps all its preferences: what is better there is better here. A rule that is new, and that not every "
        "rule of the other one outranks, could take one back: what is better there may be worse by the new rule alone."
    )

    span: Span
    other: Span
    name: str
    base: str
    rule: str
