"""The input contract of a spec as a table: which signals there are, with which fields, and what each has to pass."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.reads import FOLLOWED, IS_DRIVEN, IS_EMERGENCY, PLAN, known_again
from trackmarshal.ir.spec import FieldType, RuleInfo, SignalType, Spec
from trackmarshal.node import Node
from trackmarshal.runtime.contract.checks import Check, checks_of
from trackmarshal.runtime.contract.tracks import Places, corridors_of, places_of
from trackmarshal.source import SourceFile, Span

#: The car's own state.
EGO = "ego"
#: What the Supervisor itself reads, in SI units.
_PLAN_FIELDS = {"t": "s", "x": "m", "y": "m", "heading": "rad", "v": "m/s"}
_EGO_FIELDS = {"x": "m", "y": "m", "heading": "rad"}
_EGO_OPTIONAL = {"age": "s", "v": "m/s"}

#: What elements of a set are called, in data and among what rules read.
ID = "id"
TIMELINE, SET, RECORD, LINES, EVENT = "timeline", "set", "record", "lines", "event"


class Field(Node):
    """A field: `kind` number, bool or polyline; numbers come in `unit`; the default is in SI, that of a bool 1 or 0.

    needed: whether it has to be there; one that only orders samples need not. members: names of which a number is the place; empty for all others.
    """

    name: str
    kind: str
    unit: str
    default: float | None
    checks: tuple[Check, ...]
    needed: bool
    members: tuple[str, ...] = ()

    def checked(self, of: str) -> tuple[Check, ...]:
        """Its checks of values, steps, counts or points."""
        return tuple(check for check in self.checks if check.kind.of == of)


class Signal(Node):
    """A signal or event. form: timeline and set (columns), record (one value a field), lines, event (one Boolean).

    fields: those that are wanted, in the order of their declaration; a line that is the signal itself has the name "". checks:
    those of its length. declared: the names of all fields that it may have. named: whether elements of a set have to say what they are
    called, since rules know them again in other cycles.
    """

    name: str
    form: str
    fields_: tuple[Field, ...]
    checks: tuple[Check, ...]
    declared: frozenset[str]
    named: bool = False

    @property
    def numbers(self) -> tuple[Field, ...]:
        return tuple(field for field in self.fields_ if field.kind == "number")

    @property
    def flags(self) -> tuple[Field, ...]:
        return tuple(field for field in self.fields_ if field.kind == "bool")

    @property
    def lines(self) -> tuple[Field, ...]:
        return tuple(field for field in self.fields_ if field.kind == "polyline")


class Contract(Node):
    """What cycles, or cases, have to keep.

    plan: what each candidate has to be; None for cases, whose `plan` is a signal as any other. signals: all others, in the order
    of the spec, but for what comes with the candidates. known: the names of all signals and events. over_run: whether rules look at other
    cycles, so that stamps are counted with.
    """

    plan: Signal | None
    signals: tuple[Signal, ...]
    known: frozenset[str]
    #: The places of named tracks that rules read, and the signals that name the track.
    places: Places = ()
    corridors: tuple[str, ...] = ()
    over_run: bool = False

    def signal(self, name: str) -> Signal | None:
        return next((signal for signal in self.signals if signal.name == name), None)

    @property
    def numbers(self) -> dict[str, Field]:
        """The fields of the plan and of all other signals that are numbers, by signal and name (`ego.v`)."""
        signals = self.signals if self.plan is None else (self.plan, *self.signals)
        return {f"{signal.name}.{field.name}": field for signal in signals for field in signal.numbers}


def of_cases(spec: Spec, reads: Iterable[tuple[str, str]], places: Places = ()) -> Contract:
    """The contract of cases for rules that read these (signal, field) pairs: these fields, and the order of samples."""
    wanted: dict[str, set[str]] = {}
    for name, field in reads:
        wanted.setdefault(name, set()).add(field)
    signals = [
        _signal(info, wanted[name], info.many and ID in wanted[name])
        for name, info in spec.signals.items()
        if name in wanted
    ]
    events = [_event(name) for name in spec.events if name in wanted]
    return Contract(None, (*signals, *events), _names(spec), places, corridors_of(spec))


def of_cycles(spec: Spec, rules: Sequence[RuleInfo]) -> Contract:
    """The contract of cycles for these rules: every field of every signal that they or the Supervisor read.

    Raises E482 where the spec declares differently what the Supervisor reads, and where no rule decides.
    """
    spec = supervised(spec)
    if rules and all(rule.advisory for rule in rules):
        raise TrackmarshalError(
            "E482", "all of its rules are advisory, so that none decides", help="give one another severity"
        )
    read = {signal for rule in rules for signal, _ in rule.reads} | {EGO}
    own, told = {PLAN, FOLLOWED}, {IS_EMERGENCY, IS_DRIVEN}
    named = {signal for rule in rules for root in (rule.formula, rule.active) for signal in known_again(root)}
    signals = [
        _signal(info, None, name in named) for name, info in spec.signals.items() if name in read - own
    ]
    events = [_event(name) for name in spec.events if name in read - told]
    plan = _signal(spec.signals[PLAN], None)
    return Contract(
        plan,
        (*signals, *events),
        _names(spec),
        places_of(spec, rules),
        corridors_of(spec),
        any(rule.over_run or rule.course is not None for rule in rules),
    )


def supervised(spec: Spec) -> Spec:
    """The spec with all that the Supervisor itself reads declared; raises E482 where it is declared differently."""
    plan, ego = _part(spec, PLAN, "trajectory", _PLAN_FIELDS), _part(spec, EGO, "state", _EGO_FIELDS)
    for name, unit in _EGO_OPTIONAL.items():
        field = ego.field(name)
        if field is not None and (field.kind != "number" or field.unit != unit):
            raise _unfit(f"`ego.{name}` is declared in {field.unit or field.kind}, not in {unit}", field.span)
    if FOLLOWED in spec.signals:
        _fits(_part(spec, FOLLOWED, "trajectory", {}), plan)
    signals = spec.signals | {PLAN: plan, EGO: ego}
    return Spec(
        signals, spec.events, spec.params, spec.tables, spec.places, spec.constraints, spec.rules, spec.rulebooks, spec.fingerprint, spec.scales,
        spec.courses,
    )  # fmt: skip


def _names(spec: Spec) -> frozenset[str]:
    return frozenset((*spec.signals, *spec.events))


def _event(name: str) -> Signal:
    kind = FieldType("", "bool", "", False, None, None, None, Span(SourceFile("", ""), 0, 0))
    return Signal(name, EVENT, (_field(kind),), (), frozenset())


def _signal(info: SignalType, wanted: set[str] | None, named: bool = False) -> Signal:
    """A signal with the fields of these names, or with all, and those that are needed in any case: orders and borders."""
    form = SET if info.many else TIMELINE if info.sequence else RECORD if info.kind == "state" else LINES
    kinds = [
        kind for kind in info.fields_
        if wanted is None or kind.name in wanted or (form == TIMELINE and kind.increasing)
    ]  # fmt: skip
    if form == LINES:
        kinds = [kind for kind in kinds if kind.kind == "polyline"]
        given = {kind.name for kind in kinds}
        missing = ["left", "right"] if info.kind == "corridor" else [""]
        kinds += [_line(name, info.span) for name in missing if name not in given]
    fields = tuple(_field(kind, wanted is None or kind.name in wanted or form == LINES) for kind in kinds)
    checks = () if form == LINES else checks_of(info)
    return Signal(info.name, form, fields, checks, frozenset(kind.name for kind in info.fields_), named)


def _line(name: str, span: Span) -> FieldType:
    return FieldType(name, "polyline", "m", False, None, None, None, span)


def _field(kind: FieldType, needed: bool = True) -> Field:
    members = () if kind.enumeration is None else kind.enumeration.members
    return Field(kind.name, kind.kind, kind.unit, kind.default, checks_of(kind), needed, members)


def _part(spec: Spec, name: str, kind: str, needed: dict[str, str]) -> SignalType:
    """A signal as the spec declares it, with the fields that the Supervisor reads."""
    signal = spec.signals.get(name)
    nowhere = Span(SourceFile("", ""), 0, 0)
    if signal is None:
        signal = SignalType(name, kind, False, (), nowhere)
    if signal.kind != kind or signal.many:
        found = f"set of {signal.kind}" if signal.many else signal.kind
        raise _unfit(f"`{name}` is declared as a {found}, not as a {kind}", signal.span)
    fields = {field.name: field for field in signal.fields_}
    for field, unit in needed.items():
        info = fields.get(field, FieldType(field, "number", unit, False, None, None, None, nowhere))
        if info.kind != "number" or info.unit != unit:
            raise _unfit(
                f"`{name}.{field}` is declared in {info.unit or info.kind}, not in {unit}", info.span
            )
        if field == "t" and not info.increasing:
            info = FieldType(field, info.kind, unit, True, info.lower, info.upper, info.default, info.span)
        fields[field] = info
    return SignalType(name, kind, False, tuple(fields.values()), signal.span)


def _fits(followed: SignalType, plan: SignalType) -> None:
    """Raise E482 unless the driving trajectory has what a candidate has."""
    for field in followed.fields_:
        own = plan.field(field.name)
        if own is None or (own.kind, own.unit, own.enumeration) != (
            field.kind,
            field.unit,
            field.enumeration,
        ):
            raise _unfit(f"`{FOLLOWED}.{field.name}` is not declared as `{PLAN}.{field.name}` is", field.span)


def _unfit(message: str, span: Span) -> TrackmarshalError:
    """E482 at the place of what does not fit."""
    return TrackmarshalError(
        "E482",
        message,
        file=str(span.file.path),
        line=span.line,
        help="the Supervisor reads plan.t in s, x and y in m, heading in rad, v in m/s, and ego",
    )
