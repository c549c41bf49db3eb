"""Errors of declarations: of signals, parameters, tables, places and state machines."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class SignalConflict(Diagnostic):
    code = "E215"
    title = "two contracts for one signal"
    text = "signal `{name}` has two different declarations"
    label = "differs from the other one"
    other_label = "the other declaration"
    remedy = "declare it in one module and `use` that"
    explanation = "A signal of a given name is one thing in the car; modules checked together must agree on its contract."

    span: Span
    other: Span
    name: str


class LifetimeProblem(Diagnostic):
    code = "E580"
    title = "elements that cannot be known for so long"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "`signal objects : set of object { ... } capacity 32 forget 2 s`: no cycle has more than 32 elements, and rules over the run remember "
        "something of 32 at most, of those that are absent for up to two seconds, too. So `forget` is of sets with a capacity, which is a whole "
        "number from 1 to 1000."
    )

    span: Span
    problem: str
    hint: str = ""


class CourseProblem(Diagnostic):
    code = "E270"
    title = "a course that joins nothing"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "`course driven = ego for 10 s then plan` is one timeline of what was driven and what is planned: a record, as it was in the cycles of so "
        "long a time and as it is now, and then the samples of a trajectory that are due later. It has the fields that both have, in the same "
        "units. Rules live along it; it is no input, and nothing else can be done with it."
    )

    span: Span
    problem: str
    hint: str = ""


class ShapeProblem(Diagnostic):
    code = "E253"
    title = "a shape that cannot be"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "A shape lists fields: numbers by their units, `bool`, and members of enumerations. `a with { ... }` has those of the shape `a`, too. "
        "It has each field once, and is not made of itself."
    )

    span: Span
    problem: str
    hint: str = ""


class RecordProblem(Diagnostic):
    code = "E254"
    title = "a record of parameters that does not fit its shape"
    text = "{problem}"
    other_label = "{about}"
    remedy = "{hint}"
    explanation = (
        "`param limits : shape = { field: value, ... }` says what each field of the shape is, once. All fields are numbers, and each is a parameter "
        "of its own, with a range and a source if need be: `limits.field`."
    )

    span: Span
    problem: str
    hint: str
    other: Span | None = None
    about: str = "it stands here first"


class ScaleConflict(Diagnostic):
    code = "E252"
    title = "two scales for one dimension"
    text = "this scale for {dimension} contradicts another one"
    label = "another scale than there"
    other_label = "the other one"
    remedy = "declare it once, in a module that all others use"
    explanation = (
        "`scale` says how much of a dimension counts as 1 where margins of several dimensions are compared. It holds for everything that is "
        "checked together, whichever module declares it: two may say the same, and must not say different things."
    )

    span: Span
    other: Span
    dimension: str


class Unconstrained(Diagnostic):
    code = "E307"
    title = "a constraint does not hold"
    text = "this constraint does not hold: {values}"
    label = "does not hold"
    remedy = "{hint}"
    explanation = "`constrain` states what must hold between parameters for the rules to be sound; the values as set break it."

    span: Span
    values: str
    hint: str = ""


class TableShape(Diagnostic):
    code = "E250"
    title = "a table that does not fit its arguments"
    text = "{problem}"
    other_label = "as many values as knots here"
    remedy = "{hint}"
    explanation = (
        "A table of one argument has rows `| knot: value`. A table of two arguments begins with a row of the second one's knots, "
        "`| name: knot, knot`, and each row below it is a knot of the first one with as many values. How it is read is said once for all "
        "arguments, or once for each: `linear clamp, step`."
    )

    span: Span
    other: Span | None
    problem: str
    hint: str = ""


class TablePeriod(Diagnostic):
    code = "E251"
    title = "a table whose period cannot be"
    text = "{problem}"
    other_label = "the length of the period"
    remedy = "{hint}"
    explanation = (
        "`wrap LENGTH` repeats a table: what it says at a place x it says at x + LENGTH, too. Its knots lie in the first period, from 0 up to "
        "LENGTH, which is 0 again. LENGTH is above 0, and of the argument's dimension."
    )

    span: Span
    other: Span | None
    problem: str
    hint: str = ""


class BadPlace(Diagnostic):
    code = "E261"
    title = "a zone or a line that is none"
    text = "{problem}"
    label = "here"
    other_label = "this one, too"
    remedy = "{hint}"
    explanation = (
        "A zone is what one ring encloses: it has an area, and crosses or touches itself nowhere. A line leads from point to point; it may cross itself, "
        "but not run back over itself. Where a place is none, every rule that reads it would be undefined, so it is found before anything is driven. Of "
        "places that data brings, and that are none, rules are undefined, and points that repeat are dropped."
    )

    span: Span
    other: Span | None
    problem: str
    hint: str


class BackwardStretch(Diagnostic):
    code = "E260"
    title = "a stretch that leads backwards"
    text = "this stretch ends at {end}, before it begins at {start}"
    label = "behind the station at which it begins"
    other_label = "this line is open"
    remedy = "swap the two stations; only a closed line, such as a track's, goes on over the finish line"
    explanation = (
        "A stretch leads ahead from one station to another. On a closed line it goes on over the finish line where the second one is the lower "
        "number; an open line has an end there, and nothing lies in such a stretch. Where data brings the line or the stations, such a stretch "
        "leaves the rule undefined."
    )

    span: Span
    other: Span
    start: str
    end: str


class StateProblem(Diagnostic):
    code = "E217"
    title = "a state that never changes"
    text = "{problem}"
    remedy = "add a `becomes` that leads elsewhere, or remove the state"
    explanation = "A `state` that never leaves the value it starts with remembers nothing."

    span: Span
    problem: str


class UnreachableState(Diagnostic):
    code = "E241"
    title = "a state that is never entered"
    text = "`{name}` is never `{state}`"
    label = "nothing leads here"
    remedy = "add a `becomes {state}`, or remove it"
    explanation = (
        "From the state that a machine starts in, some way has to lead to each of the others. Where none does, a rule that asks for the state "
        "demands nothing, or is always broken, and nobody sees which."
    )

    span: Span
    name: str
    state: str


class NoReset(Diagnostic):
    code = "E242"
    title = "a state without a way out"
    text = "{problem}"
    other_label = "this leads out of it"
    remedy = "{hint}"
    explanation = (
        "A state that nothing leads out of is kept for the rest of the run, or of the life of the object. Mostly the `becomes` that resets it was "
        "forgotten; where it is meant, `final` says so."
    )

    span: Span
    problem: str
    hint: str
    other: Span | None = None


class NeverTaken(Diagnostic):
    code = "E243"
    title = "a transition that is never taken"
    text = "this `becomes {target}` is never taken"
    label = "whenever this may be taken, an earlier one is"
    other_label = "this one, for example"
    remedy = "put the narrower condition first, or remove one of them"
    explanation = (
        "In each cycle the guards are looked at in the order written, and the first one that holds is taken. Where an earlier transition leads "
        "from the same states on the same condition, or on a part of it, a later one never gets its turn."
    )

    span: Span
    other: Span
    target: str
