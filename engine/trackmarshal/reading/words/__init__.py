"""The fixed words of sentences: all that a language says, and no other module does. A language is a value of `Words`."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal.ir.nodes import JudgedAt
from trackmarshal.ir.operators import ArithmeticOp, FunctionName, TemporalOp, UntilOp
from trackmarshal.node import Node
from trackmarshal.reading.rule import Kind
from trackmarshal.typed import Changing, Comparing, Folding, Joining, Stepping
from trackmarshal.units import Dimension


class Words(Node):
    """Texts with places, `{a}`, in which phrases are put. Of pairs, the second one denies."""

    language: str
    #: What stands between two phrases, between the parts of a list, and before its last one.
    arithmetic: Mapping[ArithmeticOp, str]
    comparisons: Mapping[Comparing, tuple[str, str]]
    joined: Mapping[Joining, str]
    comma: str
    last: str
    last_of_many: str
    #: Functions of one number `{a}`, of two, and of a list of more.
    functions: Mapping[FunctionName, str]
    more: Mapping[FunctionName, str]
    minus: str
    pi: str
    square: str
    cube: str
    power: str
    #: A number or a condition that has a letter, where it is used, and what it is.
    condition: tuple[str, str]
    #: A choice: a value where a condition holds, one where no condition before it does, and the last one.
    where: str
    else_where: str
    otherwise: str
    among: str
    #: A field, and one beside a definition or a state machine of its name.
    field: str
    own_field: str
    parameter: str
    #: A record of parameters, and each of its fields.
    record: str
    setting: str
    table: str
    station: str
    offset: str
    direction: str
    distance: str
    station_gap: str
    folds: Mapping[Folding, tuple[str, str]]
    if_none: str
    kept: str
    time_in: str
    of: str
    of_several: str
    holds: tuple[str, str]
    holds_for: tuple[str, str]
    #: Of a Boolean field beside a definition of its name.
    own_holds_for: tuple[str, str]
    true: str
    false: str
    within: tuple[str, str]
    in_zone: tuple[str, str]
    in_stretch: tuple[str, str]
    between_stations: str
    #: What a stretch that has a name is one of.
    stretch: str
    inside: tuple[str, str]
    meets: tuple[str, str]
    clear_of: tuple[str, str]
    same: tuple[str, str]
    in_state: tuple[str, str]
    either: str
    but_not_both: str
    #: Quantifiers over one, several in a row, and the one of which something is least.
    every: str
    some: str
    some_several: str
    nearest: str
    some_nearest: str
    of_those: str
    sample: str
    samples: str
    element: str
    numbers: tuple[str, ...]
    for_which: str
    quantified: str
    existing: str
    #: Without a window, with one, and with one that begins now.
    temporal: Mapping[TemporalOp, tuple[str, str, str]]
    until: Mapping[UntilOp, tuple[str, str, str]]
    steps: Mapping[Stepping, str]
    weak_steps: Mapping[Stepping, str]
    edges: Mapping[Changing, str]
    count: str
    count_last: str
    count_since: str
    first: str
    last_sample: str
    border: str
    path: str
    centre: str
    footprint: str
    footprint_at: str
    swept_footprint: str
    swept_hull: str
    swept: str
    machine: str
    along: Mapping[JudgedAt, str]
    #: At which sample a rule along a timeline is judged, beside its formula.
    judged: Mapping[JudgedAt, str]
    whenever: str
    deadline: str
    #: What an `except` leaves out of all, and of those of which there has to be one, or of which one is nearest.
    except_why: str
    leaving_out: str
    colon: str
    here: str
    is_: str
    if_: str
    when: str
    event: str
    #: State machines: that it starts, of what it is where there are several, each of its transitions, and which of several is taken.
    starts: str
    of_each: str
    bridges: str
    becomes: str
    remembers: str
    in_order: str
    #: What was solved for a number, why it was not, and what was found on the evaluator instead: in which ranges the rule holds.
    solved: str
    unsolved: str
    reasons: Mapping[str, str]
    found: str
    nowhere: str
    everywhere: str
    interval: str
    untested: str
    #: Fields whose meaning is plain from their name and dimension.
    fields_: Mapping[tuple[str, Dimension], str]
    #: Headings and labels of what is shown.
    labels: Mapping[str, str]
    clauses: Mapping[Kind, str]
