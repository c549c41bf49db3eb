"""What formulas over the run may be about."""

from __future__ import annotations

from typing import assert_never

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import outside_machines, over_run, recalled, recalls, sets
from trackmarshal.semantics.errors.expressions import OverRunProblem
from trackmarshal.source import Span

#: The longest window over the run [ns]: a thousand hours.
LONGEST = 3_600_000 * 10**9


def misused(*formulas: ir.Formula | None) -> OverRunProblem | None:
    """The first thing that is wrong with temporal operators over the run in some formulas; None where nothing is."""
    for formula in formulas:
        if formula is None or not over_run(formula):
            continue
        for node in ir.below(formula):
            problem = _of_operator(node) if isinstance(node, ir.Remembered) else _of_other(node)
            if problem is not None:
                return problem
    return None


def misused_along(axis: ir.Axis, *formulas: ir.Formula | None) -> OverRunProblem | None:
    """The first thing in the formulas of a rule that lives along a timeline that is about the run; None where nothing is."""
    for formula in formulas:
        if formula is None or not over_run(formula):
            continue
        for node in ir.below(formula):
            if isinstance(node, ir.Kept):
                said, span, hint = f"what `{_short(node.machine)}` keeps", _place(formula), ""
            elif isinstance(node, ir.InState):
                said, span, hint = f"`{_short(node.machine)}`", node.span, ""
            elif isinstance(node, ir.Remembered):
                said, span = f"`{_called(node)}` before `along`", node.span
                hint = f"below `along` it looks along `{axis.signal}`; for the run, "
            else:
                continue
            problem = f"{said} is about the run, and this rule lives along `{axis.signal}`"
            return OverRunProblem(span, problem, f"{hint}write two rules, one for each")
    return None


def _short(machine: ir.Machine) -> str:
    return machine.name.rpartition(".")[2]


def _called(node: ir.Remembered) -> str:
    match node:
        case ir.OverRun():
            # `rising(p)` and `falling(p)` are made of `previous`, which nobody wrote.
            word = node.span.text.partition("(")[0].strip()
            return word if word in typed.EDGES else node.op
        case ir.Counted():
            return "count"
        case ir.InState():
            return "is"
        case _:
            assert_never(node)


def _of_operator(node: ir.Remembered) -> OverRunProblem | None:
    # No sample is known again in another cycle: the quantifier that binds it was looked at first, and refused.
    if any(axis.kind == "samples" for axis in sets(node)):
        raise AssertionError(f"`{node.span.text}` binds a sample over the run")
    if (
        isinstance(node, ir.Counted)
        and node.upper is None
        and any(_waits(part) for operand in node.operands for part in ir.below(operand))
    ):
        hint = "give it a window: `count(p, last: 10 s)`"
        return OverRunProblem(
            node.span, "`count` over what looks ahead would have to remember the whole run", hint
        )
    lasting = next((axis for axis in sets(node) if axis.forget), None)
    if lasting is not None and node.past and any(_waits(part) for part in ir.below(node)):
        hint = "let it look back alone, or declare no `forget`"
        return OverRunProblem(
            node.span,
            f"`{_called(node)}` looks back at what looks ahead, of elements of `{lasting.signal}` that may be absent",
            hint,
        )
    if isinstance(node, ir.OverRun) and not node.past and node.op != "next" and node.upper is None:
        hint = f"give it a window: `{node.op}[0 s, 5 s]`"
        return OverRunProblem(node.span, f"`{node.op}` without a bound is never decided over the run", hint)
    if node.upper is not None and node.upper > LONGEST:
        return OverRunProblem(
            node.span, "the window of a temporal operator over the run is longer than a thousand hours"
        )
    return None


def _waits(node: ir.AnyNode) -> bool:
    return isinstance(node, ir.OverRun) and not node.past


def _of_other(node: ir.AnyNode) -> OverRunProblem | None:
    if isinstance(node, (ir.Not, ir.Connective, ir.Guarded)):
        return None
    if isinstance(node, ir.Quantify) and node.axis.kind == "elements":
        return None
    if isinstance(node, ir.Formula) and recalls(node):
        of_all = next(
            (fold for fold in outside_machines(node) if isinstance(fold, ir.Fold) and _of_each(fold)), None
        )
        if of_all is not None:
            what = (
                "which element is nearest"
                if of_all.op == "nearest"
                else f"a number of all elements of `{of_all.axis.signal}`"
            )
            machine = _short(recalled(node)[0].machine)
            hint = f"of one element it is known: write `for all ... in {of_all.axis.signal} where ...`"
            return OverRunProblem(
                _place(node), f"what `{machine}` keeps of each element cannot decide {what}", hint
            )
        bound = next((kept for kept in recalled(node) if not set(sets(kept)) <= set(sets(node))), None)
        if bound is not None:
            hint = (
                f"put the quantifier over `{bound.machine.axis.signal}` outside" if bound.machine.axis else ""
            )
            machine = _short(bound.machine)
            return OverRunProblem(
                _place(node),
                f"what `{machine}` keeps of an element cannot stand inside a quantifier over samples",
                hint,
            )
    for child in ir.operands(node) if isinstance(node, (ir.Num, ir.Formula)) else ():
        for part in outside_machines(child):
            if isinstance(part, ir.Remembered):
                nearest = any(
                    isinstance(fold, ir.Fold) and fold.op == "nearest" and part in outside_machines(fold)
                    for fold in outside_machines(child)
                )
                what = "which element is nearest" if nearest else "a number"
                what = "a sample" if isinstance(node, ir.Quantify) else what
                hint = (
                    "only formulas, and quantifiers over sets, can be put together from what was or will be"
                )
                return OverRunProblem(part.span, f"`{_called(part)}` over the run cannot decide {what}", hint)
    return None


def _of_each(fold: ir.Fold) -> bool:
    """Whether a number of many asks what machines keep of each of them."""
    asked = [part for part in (fold.guard, fold.body) if part is not None]
    return any(
        isinstance(part, ir.Kept) and fold.axis in sets(part)
        for each in asked
        for part in outside_machines(each)
    )


def _place(node: ir.Formula) -> Span:
    """Where something in a formula is written that says where it stands."""
    found: list[Span] = [part.__dict__["span"] for part in outside_machines(node) if "span" in part.__dict__]
    return found[0]
