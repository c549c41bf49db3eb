"""The input contract (S-2-C) as data: every door, in Python and in C, is made from these tables."""

# implements S-1-B-1: each demand on the input is an entry of a table

from trackmarshal.ir.reads import FOLLOWED, IS_DRIVEN, IS_EMERGENCY, PLAN
from trackmarshal.runtime.contract.checks import KINDS, Check, Kind
from trackmarshal.runtime.contract.conditions import Condition
from trackmarshal.runtime.contract.signals import (
    EGO,
    EVENT,
    ID,
    LINES,
    RECORD,
    SET,
    TIMELINE,
    Contract,
    Field,
    Signal,
    of_cases,
    of_cycles,
    supervised,
)

__all__ = [
    "EGO", "EVENT", "FOLLOWED", "ID", "IS_DRIVEN", "IS_EMERGENCY", "KINDS", "LINES", "PLAN", "RECORD", "SET", "TIMELINE", "Check", "Condition", "Contract", "Field",
    "Kind", "Signal", "of_cases", "of_cycles", "supervised",
]  # fmt: skip
