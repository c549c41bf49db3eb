"""The units of a formula's margin, and the scales by which margins of different units are compared."""

from __future__ import annotations

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


def measured_units(formula: ir.Formula) -> set[str]:
    """The units of what has a scale: counts of cycles and of samples have none."""
    atoms = formula_atoms(formula)
    units = {n.unit for n in atoms if isinstance(n, ir.Compare) and n.op != "is"}  # that one is a Boolean
    return units | {"m" for n in atoms if isinstance(n, ir.Geometry)}


def formula_atoms(formula: ir.Formula) -> list[ir.Formula]:
    """The comparisons, counts, flags and geometric predicates that decide a formula (guards choose, they don't decide)."""
    atoms: list[ir.Formula] = []
    stack: list[ir.Formula] = [formula]
    while stack:
        node = stack.pop()
        match node:
            case (
                ir.Compare()
                | ir.Flag()
                | ir.SweptInside()
                | ir.SweptClear()
                | ir.InArea()
                | ir.Counted()
                | ir.Tallied()
            ):
                atoms.append(node)  # of a count, whatever is counted is measured in
            case ir.Truth():
                pass
            case ir.Quantify() | ir.Guarded():
                stack.append(node.body)
            case ir.Connective() | ir.Until():
                stack += [node.left, node.right]
            case ir.Not() | ir.Scaled() | ir.Temporal() | ir.Shift() | ir.At():
                stack.append(node.operand)
            case ir.OverRun():
                stack += node.operands
            case ir.InState():
                pass  # a Boolean
            case _:
                assert_never(node)
    return atoms
