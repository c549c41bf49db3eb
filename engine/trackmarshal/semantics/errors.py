"""Errors of names, types and dimensions."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class UnknownName(Diagnostic):
    code = "E201"
    title = "unknown name"
    text = "unknown {what} `{name}`{more}"
    label = "not declared here or in a used module"
    remedy = "{hint}"
    explanation = (
        "Every name must be declared in the module or in one that it uses (`use module.name`). Names of modules used by a "
        "used module are not visible. What one missing `use` or one missing declaration makes unknown is one error, with all places."
    )

    span: Span
    what: str
    name: str
    hint: str = ""
    #: The modules that declare it, one of which could be used.
    modules: tuple[str, ...] = ()
    more: str = ""
    others: tuple[Span, ...] = ()


class Duplicate(Diagnostic):
    code = "E202"
    title = "declared twice"
    text = "{what} `{name}` is declared twice"
    label = "declared again here"
    other_label = "first declared here"
    remedy = "rename one of them"
    explanation = "A name stands for one thing in a module; a rule's name is unique in everything that is checked together."

    span: Span
    other: Span
    what: str
    name: str


class Hides(Diagnostic):
    code = "E222"
    title = "a name that hides another one"
    text = "{what} `{name}` hides the {other_what} `{name}`{where}"
    label = "means something else from here on"
    other_label = "the {other_what} is declared here"
    remedy = "{hint}"
    explanation = (
        "Whatever is visible where a name is declared or bound has another name: of two declarations of one name, a reader takes "
        "one for the other, and a limit that was changed in one place stays what it was in the other. Signals and events are the "
        "same thing in every module, and may be declared again alike."
    )

    span: Span
    other: Span | None
    what: str
    name: str
    other_what: str
    where: str
    hint: str = "rename one of them"


class ModuleNotFound(Diagnostic):
    code = "E203"
    title = "module not found"
    text = "no module `{name}`"
    label = "looked for {path}"
    remedy = "{hint}"
    explanation = (
        "`use a.b` reads a/b.spec below the folder in which the project's modules start, and where there is none, the library's: "
        "`prelude.*`, `supervisor.*`, `vehicles.*`, `tracks.*` and others come with the tool."
    )

    span: Span
    name: str
    path: str
    hint: str = ""


class ImportCycle(Diagnostic):
    code = "E204"
    title = "modules use each other in a circle"
    text = "import cycle: {cycle}"
    label = "this `use` closes the circle"
    remedy = "{hint}"
    explanation = "Modules are read in an order in which each comes after those that it uses; a circle has no such order."

    span: Span
    cycle: str
    hint: str


class ModuleName(Diagnostic):
    code = "E205"
    title = "the module's name does not fit"
    text = "{problem}"
    other_label = "the other one is here"
    remedy = "{hint}"
    explanation = "A file starts with `module NAME`, once, and a module `a.b` lives in a/b.spec, so that `use a.b` finds it."

    span: Span
    problem: str
    hint: str = ""
    other: Span | None = None


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


class Ambiguous(Diagnostic):
    code = "E208"
    title = "a name with two meanings"
    text = "`{name}` is declared in {modules}"
    label = "which one?"
    other_label = "one is here"
    remedy = "rename one, or use only one of the modules"
    explanation = "Two used modules declare the same name; nothing is chosen silently."

    span: Span
    other: Span
    name: str
    modules: str
    others: tuple[Span, ...] = ()


class WrongArity(Diagnostic):
    code = "E209"
    title = "wrong number of arguments"
    text = "`{name}` takes {wanted}; {given}"
    label = "{given}"
    other_label = "declared here"
    remedy = "{hint}"
    explanation = "The number of arguments differs from the number of parameters of the definition or the built-in function."

    span: Span
    name: str
    wanted: str
    given: str
    other: Span | None = None
    hint: str = ""


class UnknownField(Diagnostic):
    code = "E210"
    title = "unknown field"
    text = "{what} has no field `{name}`"
    label = "it has: {known}"
    remedy = "{hint}"
    explanation = (
        "Only the fields that a signal's declaration lists can be read: they are the input contract."
    )

    span: Span
    what: str
    name: str
    known: str
    hint: str = ""
    others: tuple[Span, ...] = ()


class WrongKind(Diagnostic):
    code = "E211"
    title = "the wrong kind of thing"
    text = "expected {wanted}, found {found}"
    label = "this is {found}"
    remedy = "{hint}"
    explanation = "Numbers, formulas, records, regions and lines are different kinds of values; each place takes one of them."

    span: Span
    wanted: str
    found: str
    hint: str = ""


class Recursive(Diagnostic):
    code = "E212"
    title = "a definition that needs itself"
    text = "`{name}` is defined by itself"
    label = "{cycle}"
    remedy = "{how}"
    explanation = "Definitions are written out where they are used, so that every evaluation is bounded; recursion has no bound."

    span: Span
    name: str
    cycle: str
    how: str = "write it out without itself"


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


class UnknownMember(Diagnostic):
    code = "E247"
    title = "no such member"
    text = "`{enumeration}` has no member `{name}`"
    label = "it has: {known}"
    remedy = "{hint}"
    explanation = "An enumeration has the members that its declaration lists, and no others: what is asked for, and what data gives, is one of them."

    span: Span
    enumeration: str
    name: str
    known: str
    hint: str = ""


class CaseProblem(Diagnostic):
    code = "E248"
    title = "a case that does not say what holds for each member"
    text = "{problem}"
    other_label = "it is here already"
    remedy = "{hint}"
    explanation = (
        "A `case` has a value for each member of the enumeration, once: by name, or by `else` for all that are not named. Whoever adds a member "
        "is shown every `case` that does not say yet what it means there; an `else` says that no further member could matter."
    )

    span: Span
    problem: str
    hint: str = ""
    other: Span | None = None


class OverRunProblem(Diagnostic):
    code = "E223"
    title = "a formula over the run that has no meaning"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "Temporal operators in a rule without `along SIGNAL as NAME` range over the run, cycle by cycle. What they speak of has to be there in "
        "every cycle: the elements of a set have ids, by which they are known again; the samples of a trajectory have none. Whatever they say "
        "about a cycle has to be decided some time: operators that look ahead have a bound."
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


class UnknownReference(Diagnostic):
    code = "E219"
    title = "unknown word"
    text = "{problem}"
    remedy = "{hint}"
    explanation = "Some places take a word from a fixed list, or the name of a rule, an assumption or a reference declared elsewhere."

    span: Span
    problem: str
    hint: str = ""


class TooLarge(Diagnostic):
    code = "E221"
    title = "a formula that is too large"
    text = "written out, this is {size}"
    remedy = "{hint}"
    explanation = (
        "Definitions are written out where they are used. A chain of definitions of which each uses the one before twice doubles with "
        "every link; a bound keeps every pass and every evaluation predictable."
    )

    span: Span
    size: str
    hint: str = "let fewer definitions build on each other"


class DimensionMismatch(Diagnostic):
    code = "E301"
    title = "dimensions do not match"
    text = "cannot {action} {left} and {right}"
    label = "this is {left}"
    other_label = "this is {right}"
    remedy = "{hint}"
    explanation = (
        "Every quantity has a dimension over metre, second and kilogram (an angle is a plain number). Only equal dimensions can be "
        "compared, added or chosen between. The check happens once, when the spec is compiled; it costs nothing at run time."
    )

    span: Span
    other: Span
    action: str
    left: str
    right: str
    hint: str = ""
    others: tuple[Span, ...] = ()
    #: What is declared, on either side: its name, where, as what, and what it meets.
    declared: tuple[tuple[str, Span, str, str], ...] = ()


class WrongDimension(Diagnostic):
    code = "E302"
    title = "the wrong dimension"
    text = "{what} must be {wanted}, not {found}"
    label = "this is {found}"
    other_label = "{wanted} is declared here"
    remedy = "{hint}"
    explanation = "The place has a declared dimension, and the value has another one."

    span: Span
    other: Span | None
    what: str
    wanted: str
    found: str
    hint: str = ""


class BadValue(Diagnostic):
    code = "E306"
    title = "a value that cannot stand here"
    text = "{problem}"
    other_label = "{about}"
    remedy = "{hint}"
    explanation = (
        "Numbers are finite, parameters lie inside their range, ranges run from low to high, table knots ascend, windows of temporal "
        "operators are constant, not negative and run from low to high, exponents of quantities with a dimension are whole numbers."
    )

    span: Span
    problem: str
    other: Span | None = None
    hint: str = ""
    about: str = "the range is declared here"


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


class ExactlyEqual(Diagnostic):
    code = "W301"
    title = "measured numbers compared to the last bit"
    level = "warning"
    text = "`{op}` compares measured numbers to the last bit"
    label = "of noise, too"
    remedy = 'write `{instead}`, or say in the rule why this is meant: `allow W301 because "..."`'
    explanation = (
        "Two measurements of one thing hardly ever agree in all 53 bits: `==` is then violated, and `!=` satisfied, whatever the car does. "
        "Numbers that count something (fields with the unit 1, and what `floor` makes) are compared without this warning."
    )

    span: Span
    op: str
    instead: str


class BareAngle(Diagnostic):
    code = "W302"
    title = "a bare number used as an angle"
    level = "warning"
    text = "a number without a unit is used as an angle"
    label = "rad or deg?"
    other_label = "this is an angle"
    remedy = "{hint}"
    explanation = (
        "An angle is a plain number, in rad. A number without a unit is therefore taken for rad where it meets an angle, and `heading <= 90` "
        "holds for every heading. What a field, a parameter or a function gives in rad or deg is an angle, and so are sums and multiples of it. "
        "0 needs no unit."
    )

    span: Span
    other: Span | None
    hint: str
    #: What a test gives without a unit, several times.
    what: str = ""
    others: tuple[Span, ...] = ()


class BarePercentage(Diagnostic):
    code = "W309"
    title = "a bare number beside a percentage"
    level = "warning"
    text = "a number without a unit meets a percentage"
    label = "this is {percent}"
    other_label = "this is a percentage"
    remedy = "{hint}"
    explanation = (
        "A percentage is a plain number, a hundredth of what stands before the `%`. In a range and in a table a number without a unit is in the unit "
        "that is declared there; in a formula it is itself, so that `charge <= 90` holds for every charge. Numbers up to 1 are taken for what they are, "
        "shares of a whole, and so are multiples: `100 * charge <= 90` compares what it seems to."
    )

    span: Span
    other: Span
    percent: str
    hint: str


class NoShare(Diagnostic):
    code = "W318"
    title = "a percentage beside what is no share"
    level = "warning"
    text = "a percentage meets {what}"
    label = "this is a percentage"
    other_label = "this is {what}"
    remedy = "{hint}"
    explanation = (
        "Percentages, angles and counts are plain numbers, so that dimensions do not tell them apart. 100 % of a slope is 45 deg, and as a number it is 1, which is "
        "1 rad, 57 deg; `count(o in objects where p) <= 50 %` asks for no more than half an object."
    )

    span: Span
    other: Span | None
    what: str
    hint: str


class TurnsOver(Diagnostic):
    code = "W310"
    title = "headings compared across a whole turn"
    level = "warning"
    text = "two headings that are alike may differ by a whole turn here"
    label = "{told}"
    remedy = "write `angle_difference({first}, {second})`, of the module `prelude.frames`"
    explanation = (
        "Headings start anew after half a turn: what heads for 179 deg and what heads for -179 deg go almost the same way, and their difference is 358 deg. "
        "A rule that asks how far two headings are apart, how fast one turns, what lies between two, or which is the greater one, or chooses by it whom it is about, is then "
        "wrong about cars that drive side by side, and about one that drives on through 180 deg. "
        "`angle_difference` takes whole turns out; sines and cosines of a difference do without it."
    )

    span: Span
    first: str
    second: str
    told: str = "from 179 deg to -179 deg, this is 358 deg"


class LapsOver(Diagnostic):
    code = "W317"
    title = "stations compared across the finish line"
    level = "warning"
    text = "two stations that lie side by side may differ by a whole lap here"
    label = "over the finish line of a closed line, this is a lap too much, or too little"
    remedy = 'write `station_gap(LINE, {first}, {second})`, which goes the shorter way round, or say in the rule why this is meant: `allow W317 because "..."`'
    explanation = (
        "Stations of a closed line start anew at the finish line: who is 10 m behind it and who is 10 m ahead of it are 20 m apart, and their stations "
        "almost a lap. Which of two cars leads, and by how much, is then wrong once a lap. `station_gap` goes over the finish line; on an open line it is "
        "the difference."
    )

    span: Span
    first: str
    second: str


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
