"""Whose margins a formula's own is made of, its unit, and the scales by which margins of different units are compared."""

from __future__ import annotations

from collections.abc import Iterable
from typing import assert_never

from trackmarshal.ir import nodes as ir

#: In place of a unit: comparisons of several dimensions, by their SI numbers; divided by the scales that the spec declares.
MIXED, SCALED = "mixed", "scaled"


def own_unit(unit: str) -> bool:
    """Whether all comparisons of a rule are in one unit, which this is."""
    return unit not in (MIXED, SCALED)


def undecided(unit: str) -> str:
    """The unit of a rule's margin where nothing says which comparison decided: of several dimensions, a plain number."""
    return unit if own_unit(unit) else "1"


def margin_unit(formula: ir.Formula | None) -> str:
    """The unit of all of a formula's comparisons; "mixed" where they differ, "1" where there are none."""
    units = set() if formula is None else margin_units(formula)
    if not units:
        return "1"
    return units.pop() if len(units) == 1 else MIXED


def margin_units(formula: ir.Formula) -> set[str]:
    """The units of a formula's comparisons, one of which is that of its margin; where cycles or samples are counted, it may be a plain number."""
    counts = any(isinstance(n, ir.Counted | ir.Tallied) for n in formula_atoms(formula))
    return measured_units(formula) | ({"1"} if counts else set())


def margin_shown(formula: ir.Formula, unit: str) -> str:
    """The unit in which all limits of a formula are written that its margin in this SI unit may be about; "" for SI, and where they are in several."""
    atoms = [n for n in formula_atoms(formula) if isinstance(n, ir.Compare) and n.op != "is"]
    written = {n.shown for n in atoms if n.unit == unit}
    return written.pop() if len(written) == 1 else ""


def measured_units(formula: ir.Formula) -> set[str]:
    """The units of what has a scale: counts of cycles and of samples have none."""
    atoms = formula_atoms(formula)
    units = {n.unit for n in atoms if isinstance(n, ir.Compare) and n.op != "is"}  # that one is a Boolean
    return units | {"m" for n in atoms if isinstance(n, ir.Geometry)}


def formula_atoms(formula: ir.Formula) -> list[ir.Formula]:
    """The comparisons, counts, flags and geometric predicates that decide a formula."""
    leaves = (node for node in deciding([formula]) if not _parts(node))
    return [node for node in leaves if not isinstance(node, ir.Truth | ir.InState)]  # these have no measure


def deciding(roots: Iterable[ir.Formula]) -> dict[ir.Formula, None]:
    """The formulas whose margin counts for that of one of the roots, each once, and the roots. Of others it is only asked whether they hold."""
    found: dict[ir.Formula, None] = {}
    stack = list(roots)
    while stack:
        node = stack.pop()
        if node not in found:
            found[node] = None
            stack += _parts(node)
    return found


def _parts(node: ir.Formula) -> tuple[ir.Formula, ...]:
    """The parts of a formula whose margins its own is made of: guards choose, and of what is counted it is asked whether it holds."""
    match node:
        case ir.Truth() | ir.Flag() | ir.Compare() | ir.SweptInside() | ir.SweptClear() | ir.InArea():
            return ()
        case ir.Quantify() | ir.Guarded():
            return (node.body,)
        case ir.Connective() | ir.Until():
            return (node.left, node.right)
        case ir.Not() | ir.Scaled() | ir.Temporal() | ir.Shift() | ir.At():
            return (node.operand,)
        case ir.OverRun():
            return node.operands
        case ir.Counted() | ir.Tallied() | ir.InState():
            return ()
        case _:
            assert_never(node)
