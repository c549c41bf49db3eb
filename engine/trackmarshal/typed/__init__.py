"""The typed tree: what rules mean, close to what is written. Names are resolved, every number has its dimension; definitions,
tables, parameters and `let` names are still there, and so are the order of terms and the words of the author.

Formulas, English, editors and analyses stand on it; `lowering` makes the core of it that evaluators run. The unions are closed:
a `match` over one ends in `assert_never`.
"""

from __future__ import annotations

from typing import TypeAlias

from trackmarshal.typed.base import (
    COMPARISONS,
    CONNECTIVES,
    EDGES,
    STEPS,
    Changing,
    Comparing,
    Joining,
    Stepping,
    Typed,
    below,
)
from trackmarshal.typed.formulas import (
    Boolean,
    BooleanField,
    CalledFormula,
    Chained,
    ClearOf,
    Comparison,
    Connective,
    Count,
    CountComparison,
    Edge,
    Event,
    Formula,
    FormulaNode,
    Inside,
    InState,
    InZone,
    Keep,
    Machine,
    NamedFormula,
    Not,
    Quantified,
    Step,
    Temporal,
    Transition,
    Until,
    Window,
    Within,
)
from trackmarshal.typed.numbers import (
    FOLDINGS,
    Arithmetic,
    CalledNumber,
    Choice,
    Field,
    Folded,
    Folding,
    Function,
    Kept,
    LineFunction,
    Literally,
    NamedNumber,
    Negative,
    Number,
    NumberNode,
    OnLine,
    Parameter,
    Pi,
    Power,
    StationGap,
    TableValue,
    literal,
    whole_exponent,
)
from trackmarshal.typed.rules import Along, Clause, Deadline, Except, ForEach, Let, Require, Rule, Whenever
from trackmarshal.typed.symbol import Symbol
from trackmarshal.typed.things import (
    Area,
    AreaNode,
    Border,
    CalledLine,
    Centre,
    Corridor,
    Footprint,
    FootprintAt,
    Line,
    LineNode,
    NamedArea,
    NamedLine,
    NamedRecord,
    NamedRegion,
    NamedSignal,
    Path,
    PlacedLine,
    Range,
    Record,
    RecordNode,
    Region,
    RegionNode,
    Sample,
    Signal,
    SignalLine,
    SignalNode,
    State,
    Swept,
    SweptSample,
    TheRun,
    TimeAxis,
    Variable,
    WholeSignal,
    Zone,
)

#: Anything an expression can stand for.
Value: TypeAlias = Number | Count | Formula | WholeSignal | Record | Line | Area | Region

__all__ = [
    "COMPARISONS", "CONNECTIVES", "EDGES", "FOLDINGS", "STEPS", "Along", "Area", "AreaNode", "Arithmetic", "Boolean", "BooleanField", "Border",
    "CalledFormula", "CalledLine", "CalledNumber", "Centre", "Chained", "Changing", "Choice", "Clause", "ClearOf", "Comparing",
    "Comparison", "Connective", "Corridor", "Count", "CountComparison", "Deadline", "Edge", "Event", "Except", "Field", "Folded", "Folding", "Footprint", "FootprintAt", "ForEach", "Formula",
    "FormulaNode", "Function", "InState", "InZone", "Inside", "Joining", "Keep", "Kept", "Let", "Line", "LineFunction", "LineNode", "Literally", "Machine", "NamedArea",
    "NamedFormula", "NamedLine", "NamedNumber", "NamedRecord", "NamedRegion", "NamedSignal", "Negative", "Not", "Number",
    "NumberNode", "OnLine", "Parameter", "Path", "Pi", "PlacedLine", "Power", "Quantified", "Range", "Record", "RecordNode",
    "Region", "RegionNode", "Require", "Rule", "Sample", "Signal", "SignalLine", "SignalNode", "State", "StationGap", "Step",
    "Stepping", "Swept", "SweptSample", "Symbol", "TableValue", "Temporal", "TheRun", "TimeAxis", "Transition", "Typed", "Until", "Value", "Variable",
    "Whenever", "WholeSignal", "Window", "Within", "Zone", "below", "literal", "whole_exponent",
]  # fmt: skip
