"""What a rule that is still to be written is about: a number of a signal that the project declares, with a limit inside its range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.ir.spec import FieldType, SignalType
    from trackmarshal.semantics.compile import Compiled

#: Samples before elements before records, each with the name of one in `for all`.
_KINDS = {"trajectory": "p", "object": "o", "state": ""}
#: Inside, limit and outside, in the field's unit, where its range leaves room for them.
_NUMBERS = (50.0, 100.0, 150.0)


@dataclass(frozen=True, slots=True)
class Subject:
    """A number of a signal, as a rule and its tests write it."""

    #: The module that declares the signal, and the signal's name.
    module: str
    signal: str
    #: The variable of `for all`, none for a record; the number; the limit with its unit.
    variable: str
    number: str
    limit: str
    #: What tests give: below the limit, exactly at it, above it.
    inside: str
    on: str
    outside: str
    #: The margin at the limit, with its unit.
    zero: str

    @property
    def over(self) -> bool:
        """Whether the rule is about every sample or element."""
        return bool(self.variable)


def subject(compiled: Compiled) -> Subject:
    """The first number of the signals, a speed if there is one. Raises E414 where there is none."""
    signal, field = _readable(compiled)
    inside, limit, outside = _numbers(field)
    variable = _KINDS[signal.kind]
    return Subject(
        _module_of(compiled, signal.name), signal.name, variable, f"{variable or signal.name}.{field.name}", limit,
        _given(signal, field, inside), _given(signal, field, limit), _given(signal, field, outside),
        "0" if field.unit == "1" else f"0 {field.unit}",
    )  # fmt: skip


def _readable(compiled: Compiled) -> tuple[SignalType, FieldType]:
    signals = [s for s in compiled.spec.signals.values() if s.kind in _KINDS]
    for signal in sorted(signals, key=lambda signal: list(_KINDS).index(signal.kind)):
        numbers = [
            f for f in signal.fields_ if f.kind == "number" and not f.increasing and f.enumeration is None
        ]
        if numbers:
            return signal, next((field for field in numbers if field.name == "v"), numbers[0])
    raise TrackmarshalError(
        "E414",
        "the project's specs declare no signal with a number, so there is nothing that a rule could read",
        help="declare one: `signal ego : state { v: m/s }`",
    )


def _numbers(field: FieldType) -> tuple[str, str, str]:
    """Inside, limit and outside with their unit, all in the field's range."""
    from trackmarshal.units import digits

    numbers = _NUMBERS
    if field.upper is not None and float(digits(field.upper, field.unit)) < max(numbers):
        high = float(digits(field.upper, field.unit))
        low = min(0.0, high - 1.0) if field.lower is None else float(digits(field.lower, field.unit))
        numbers = (low + (high - low) / 4, low + (high - low) / 2, low + (high - low) * 3 / 4)
    unit = "" if field.unit == "1" else f" {field.unit}"
    inside, limit, outside = (f"{number:g}{unit}" for number in numbers)
    return inside, limit, outside


def _given(signal: SignalType, field: FieldType, value: str) -> str:
    match signal.kind:
        case "trajectory":
            return f"{signal.name} = line(v: 20 m/s) with {field.name} = {value}"
        case "object":
            return f"{signal.name} = [{{ {field.name}: {value} }}]"
        case "state":
            return f"{signal.name} = {{ {field.name}: {value} }}"
    raise AssertionError(f"no test gives a {signal.kind}")


def _module_of(compiled: Compiled, signal: str) -> str:
    from trackmarshal.syntax import ast

    return next(
        name
        for name in compiled.order
        for item in compiled.library.modules[name].tree.items
        if isinstance(item, ast.Signal) and item.name == signal
    )
