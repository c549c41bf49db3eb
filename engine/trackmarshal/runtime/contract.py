"""The input contract of a spec as the Supervisor's door checks it: which signals, and who of them plays which part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, SignalType, Spec

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
    """The contract that cycles have to keep for these rules; raises E482 for a spec that cannot be supervised with."""
    plan = _part(spec, PLAN, "trajectory", _PLAN_FIELDS)
    ego = _part(spec, EGO, "state", _EGO_FIELDS)
    time = plan.field("t")
    if time is None or not time.increasing:
        raise _unfit("`plan.t` is not declared increasing")
    read = {signal for rule in rules for signal, _ in rule.reads}
    shared = [ego, *(info for name, info in spec.signals.items() if name in read and name not in (PLAN, EGO))]
    events = [name for name in spec.events if name in read]
    return Contract(
        plan, tuple(shared), tuple(e for e in events if e != IS_EMERGENCY), IS_EMERGENCY in events
    )


def _part(spec: Spec, name: str, kind: str, needed: dict[str, str]) -> SignalType:
    signal = spec.signals.get(name)
    if signal is None or signal.kind != kind or signal.many:
        raise _unfit(f"the spec has no signal `{name}` that is a {kind}")
    for field, unit in needed.items():
        info = signal.field(field)
        if info is None or info.kind != "number" or info.unit != unit or info.default is not None:
            raise _unfit(f"`{name}` has no field `{field}` in {unit} without a default")
    return signal


def _unfit(message: str) -> TrackmarshalError:
    return TrackmarshalError(
        "E482",
        message,
        help="a Supervisor needs `signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, ... }` and "
        "`signal ego : state { x: m, y: m, heading: rad, ... }`",
    )
