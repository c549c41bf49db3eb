"""The input contract of a spec as the Supervisor's door checks it: which signals, and who of them plays which part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import FieldType, RuleInfo, SignalType, Spec
from trackmarshal.source import SourceFile, Span

#: The signal that a candidate stands for, the car's own state, and the event that tells the candidates apart.
PLAN, EGO, IS_EMERGENCY = "plan", "ego", "emergency"
#: What the Supervisor itself reads, in SI units.
_PLAN_FIELDS = {"t": "s", "x": "m", "y": "m", "heading": "rad", "v": "m/s"}
_EGO_FIELDS = {"x": "m", "y": "m", "heading": "rad"}


@dataclass(frozen=True, slots=True)
class Contract:
    """plan: the type of both candidates; shared: all other signals that rules read, and `ego`; events but `emergency`."""

    plan: SignalType
    shared: tuple[SignalType, ...]
    events: tuple[str, ...]
    tells_emergency: bool


def contract_of(spec: Spec, rules: Sequence[RuleInfo]) -> Contract:
    """The contract that cycles have to keep for these rules: the declared one, and what the Supervisor itself reads.

    Raises E482 where the spec declares the latter differently.
    """
    read = {signal for rule in rules for signal, _ in rule.reads}
    plan = _part(spec, PLAN, "trajectory", _PLAN_FIELDS)
    ego = _part(spec, EGO, "state", _EGO_FIELDS)
    shared = [ego, *(info for name, info in spec.signals.items() if name in read and name not in (PLAN, EGO))]
    events = [name for name in spec.events if name in read]
    return Contract(
        plan, tuple(shared), tuple(e for e in events if e != IS_EMERGENCY), IS_EMERGENCY in events
    )


def _part(spec: Spec, name: str, kind: str, needed: dict[str, str]) -> SignalType:
    """A signal as the spec declares it, with the fields that the Supervisor reads."""
    signal = spec.signals.get(name)
    nowhere = Span(SourceFile("", ""), 0, 0)
    if signal is None:
        signal = SignalType(name, kind, False, (), nowhere)
    if signal.kind != kind or signal.many:
        raise _unfit(f"`{name}` is declared as a {signal.kind}, not as a {kind}")
    fields = {field.name: field for field in signal.fields_}
    for field, unit in needed.items():
        info = fields.get(field, FieldType(field, "number", unit, False, None, None, None, nowhere))
        if info.kind != "number" or info.unit != unit:
            raise _unfit(f"`{name}.{field}` is declared in {info.unit or info.kind}, not in {unit}")
        if field == "t" and not info.increasing:
            info = FieldType(field, info.kind, unit, True, info.lower, info.upper, info.default, info.span)
        fields[field] = info
    return SignalType(name, kind, False, tuple(fields.values()), signal.span)


def _unfit(message: str) -> TrackmarshalError:
    return TrackmarshalError(
        "E482",
        message,
        help="the Supervisor reads plan.t in s, x and y in m, heading in rad, v in m/s, and ego",
    )
