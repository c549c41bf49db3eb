"""The input contract of a program with a Supervisor: its signals with their C names, and what they are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.backends.c.layout import Input, Layout, layout
from trackmarshal.backends.c.names import distinct
from trackmarshal.backends.c.supervised.checks import CAPACITIES
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import (
    EVENT,
    FOLLOWED,
    IS_DRIVEN,
    IS_EMERGENCY,
    LINES,
    PLAN,
    SET,
    Contract,
    Signal,
    of_cycles,
    supervised,
)


@dataclass(frozen=True)
class Supervised:
    """A contract and its C names.

    signals: of signals and events other than `plan`, in contract order. lines: (signal, field) to the member of the signal's
    struct, "" being the line of a signal that is one.
    """

    contract: Contract
    layout: Layout
    plan: Input
    signals: dict[str, str]
    lines: dict[tuple[str, str], str]

    @property
    def inputs(self) -> list[Signal]:
        """Timelines, sets and records."""
        return [signal for signal in self.contract.signals if signal.form not in (LINES, EVENT)]

    @property
    def lanes(self) -> list[Signal]:
        """Sets of lanes, each of which has two borders; they are inputs, too."""
        return [signal for signal in self.inputs if signal.lines]

    @property
    def limited(self) -> bool:
        """Whether some sets are held to the limit `elements` while there is room for more in others, which declare a capacity."""
        return (
            len({signal.capacity is None for signal in self.layout.spec.signals.values() if signal.many}) == 2
        )

    @property
    def capacities(self) -> dict[str, str]:
        """What capacities of limits are called in C."""
        return {**CAPACITIES, "elements": "TM_LIMIT_ELEMENTS"} if self.limited else CAPACITIES

    @property
    def events(self) -> list[Signal]:
        return [signal for signal in self.contract.signals if signal.form == EVENT]

    @property
    def borders(self) -> list[Signal]:
        """Signals that are lines, or made of lines."""
        return [signal for signal in self.contract.signals if signal.form == LINES]


def unfit(spec: Spec) -> str:
    """Why no Supervisor can be made of a spec; empty where one can."""
    if PLAN not in spec.signals:
        return f"it declares no trajectory `{PLAN}`"
    try:
        supervised(spec)
    except TrackmarshalError as error:
        return error.message
    return ""


def supervised_layout(spec: Spec, rules: Sequence[RuleInfo]) -> tuple[Layout, Supervised]:
    """What rules, contract and constraints need together. Raises TrackmarshalError E482 for a spec that cannot be supervised with,
    E470 for a signal that C has no counterpart of."""
    spec = supervised(spec)
    contract = of_cycles(spec, rules)
    inputs = [signal.name for signal in contract.signals if signal.form not in (LINES, EVENT)]
    plan = layout(spec, rules, (PLAN, *inputs))
    known = {PLAN, FOLLOWED, IS_EMERGENCY, IS_DRIVEN, *(signal.name for signal in contract.signals)}
    if not plan.inputs.keys() <= known:
        raise AssertionError(f"rules read {', '.join(plan.inputs.keys() - known)} without saying so")
    assert contract.plan is not None
    for signal in (contract.plan, *contract.signals):
        if signal.form not in (LINES, SET) and signal.lines:
            span = spec.signals[signal.name].span
            raise TrackmarshalError(
                "E470",
                f"the signal `{signal.name}` has lines inside of it",
                file=span.file.path,
                line=span.line,
            )
    _constrain(plan)
    names = {name: item.c_name for name, item in plan.inputs.items()}
    others = [signal.name for signal in contract.signals if signal.name not in names]
    names |= distinct(others, [name.casefold() for name in names.values()])
    lines: dict[tuple[str, str], str] = {}
    for signal in contract.signals:
        if signal.form == LINES:
            members = distinct([field.name or "line" for field in signal.lines], ["closed"])
            lines |= {(signal.name, field.name): members[field.name or "line"] for field in signal.lines}
    return plan, Supervised(
        contract, plan, plan.input(PLAN), {s.name: names[s.name] for s in contract.signals}, lines
    )


def _constrain(plan: Layout) -> None:
    """Add the parameters and tables that the spec's constraints speak of."""
    nodes = [node for constraint in plan.spec.constraints for node in ir.below(constraint.formula)]
    params = {node.name for node in nodes if isinstance(node, ir.Param)} | plan.params.keys()
    tables = {node.table for node in nodes if isinstance(node, ir.Lookup | ir.GridLookup)}
    plan.params = distinct(name for name in plan.spec.params if name in params)
    plan.put_tables(tables | plan.tables.keys() | plan.grids.keys())
