"""The input contract with every unit an SI unit, for the cases of tests.

What a test gives is a number of the spec, and in SI when it is handed over. On a way through the unit that data comes in, it
could become the double beside it: some SI numbers are between the values of two neighbours in km/h.
"""

from __future__ import annotations

from trackmarshal.ir.spec import FieldType, ParamInfo, SignalType, Spec, TableInfo
from trackmarshal.units import parse_unit, show


def spec_in_si(spec: Spec) -> Spec:
    """The spec, reading data, parameters and tables in SI."""
    return Spec(
        **{
            **spec.__dict__,
            "signals": {name: _signal(signal) for name, signal in spec.signals.items()},
            "params": {name: _param(param) for name, param in spec.params.items()},
            "tables": {name: table_in_si(table) for name, table in spec.tables.items()},
        }
    )


def table_in_si(table: TableInfo) -> TableInfo:
    """The table, overridden in SI."""
    argument, result = table.units
    return TableInfo(**{**table.__dict__, "units": (unit_in_si(argument), unit_in_si(result))})


def unit_in_si(unit: str) -> str:
    """The SI unit of a unit's dimension."""
    return show(parse_unit(unit)[2])


def _signal(signal: SignalType) -> SignalType:
    return SignalType(**{**signal.__dict__, "fields_": tuple(map(_field, signal.fields_))})


def _field(field: FieldType) -> FieldType:
    unit = unit_in_si(field.unit) if field.kind == "number" else field.unit
    return FieldType(**{**field.__dict__, "unit": unit})


def _param(param: ParamInfo) -> ParamInfo:
    return ParamInfo(**{**param.__dict__, "unit": unit_in_si(param.unit)})
