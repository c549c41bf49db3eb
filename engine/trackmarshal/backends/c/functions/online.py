"""Rules along a timeline as monitors: a sample at a time, in memory of a fixed size, with the values that the whole timeline gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import assert_never

from trackmarshal.backends.c import parts
from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.expressions import Expressions
from trackmarshal.backends.c.functions.timelines import bound, operands_of, truth
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.rendering import render
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import FieldType, RuleInfo

#: Samples that a monitor holds: as many as fall into its longest window, and a few.
CAPACITY = 1024
_POINTWISE = (
    ir.Const, ir.Param, ir.Column, ir.Arith, ir.Neg, ir.Func, ir.Choose, ir.Lookup, ir.GridLookup, ir.Truth, ir.Flag, ir.Compare, ir.Not,
    ir.Connective, ir.Guarded, ir.Temporal, ir.Until, ir.Shift, ir.Axis,
)  # fmt: skip


@dataclass(frozen=True)
class Monitor:
    """The C of one rule's monitor."""

    rule: RuleInfo
    c_name: str
    #: What a sample has.
    fields: tuple[tuple[FieldType, str], ...]
    #: How many operators it keeps, and of them, in its memory.
    operators: int
    streams: int
    queues: int
    stacks: int
    text: str


def monitors(plan: Layout) -> list[Monitor]:
    """A monitor of every rule that can be judged a sample at a time."""
    return [monitor(plan, rule) for rule in plan.rules if obstacle(rule) is None]


def obstacle(rule: RuleInfo) -> str | None:
    """Why a rule cannot be judged a sample at a time; None where it can."""
    if rule.along is None or not isinstance(rule.formula, ir.At):
        return "it has no timeline"
    if rule.formula.place != "first":
        return f"it is judged at the {rule.formula.place} sample"
    _, operand = _top(rule)
    for node in ir.below(operand):
        if not isinstance(node, _POINTWISE):
            return f"it reads more than the present sample ({type(node).__name__})"
        if isinstance(node, (ir.Column, ir.Flag)) and (node.axis is not rule.formula.axis or node.offset):
            return "it reads more than the present sample"
        if isinstance(node, (ir.Temporal, ir.Until)) and not node.past and node.upper is None:
            return f"`{node.op}` without an upper bound inside a formula is decided at the end only"
    return None


def _top(rule: RuleInfo) -> tuple[Extreme | None, ir.Formula]:
    """`always` or `eventually` over all of the timeline, if that is what the rule is, and what stands in it."""
    assert isinstance(rule.formula, ir.At)
    operand = rule.formula.operand
    if isinstance(operand, ir.Temporal) and not operand.past and operand.upper is None and not operand.lower:
        return operand.extreme, operand.operand
    return None, operand


_M = c.Name("monitor")


class _OnlineWriter(Expressions):
    """Values at one sample: columns and operators' values come from the monitor's rings."""

    #: Where operators' values are: the streams of the worst and the best case.
    streams: dict[ir.Formula, tuple[int, int]]

    def column(self, node: ir.Column | ir.Flag, at: c.Scope) -> c.Expr:
        assert node.axis is not None
        ring = c.Member(
            c.Member(_M, "ring", True), self.plan.field_name(node.axis.signal, node.field or ""), False
        )
        return c.Element(ring, self.ring(self.index(node.axis, at)))

    def timed(self, node: ir.Timed, at: c.Scope) -> c.Expr:
        streams = [_stream(number) for number in self.streams[node]]
        return self.over("streamed", *streams, self.ring(self.index(node.axis, at)))

    def ring(self, index: c.Expr) -> c.Expr:
        """The place of a sample in a ring."""
        return self.call("tm_ring", index)

    def until(self, axis: ir.Axis, index: c.Expr, name: str) -> c.Scope:
        """A scope that takes an index as far as `have`."""
        condition, step = c.Binary("<", index, c.Name("have")), c.Unary("++", index)
        loop = self.root.open(lambda body: c.For("", condition, step, body))
        loop.binds[axis] = index
        loop.binders[axis] = (name,)
        return loop

    def have(self, inner: list[int]) -> None:
        """Set `have` to the samples for which all of some operators are known."""
        have = c.Name("have")
        self.add(self.root, c.Assign(have, c.Member(_M, "count", True)))
        for number in inner:
            following = c.Member(_part("flow", 2 * number), "next", False)
            self.add(self.root, c.If(c.Binary("<", following, have), (c.Assign(have, following),)))


def _part(name: str, number: int) -> c.Expr:
    """An element of an array of the monitor."""
    return c.Element(c.Member(_M, name, True), c.Literal(f"{number}u"))


def _stream(number: int) -> c.Expr:
    return c.Address(_part("stream", number))


def monitor(plan: Layout, rule: RuleInfo) -> Monitor:
    """Write a rule's monitor; raises TrackmarshalError E470 for a rule that cannot have one."""
    why = obstacle(rule)
    if why is not None:
        raise TrackmarshalError("E470", f"rule `{rule.name}` cannot be judged a sample at a time: {why}",
                                file=rule.span.file.path, line=rule.span.line)  # fmt: skip
    assert isinstance(rule.formula, ir.At)
    over, operand = _top(rule)
    axis = rule.formula.axis
    name = plan.rule_names[rule.name]
    others = set(plan.rule_names.values()) - {name}
    while (
        f"tm_online_{name}" in parts.functions() or name in others
    ):  # a rule called as an operator of ours is
        name = f"{name}_"
    writer = _OnlineWriter(plan, [rule], False, [operand])
    writer.root.names |= {"have", "sample"}
    writer.streams = {}
    operand = writer.formulas[0]
    nodes = _inner_first(operand)
    read = {node.field for node in ir.below(operand) if isinstance(node, (ir.Column, ir.Flag))}
    timed = any(isinstance(node, (ir.Temporal, ir.Until)) for node in nodes)
    fields = tuple(
        (info, c_name) for info, c_name in plan.input(axis.signal).fields
        if info.name in read or (timed and info.name == "t")
    )  # fmt: skip
    time = plan.field_name(axis.signal, "t") if timed else ""
    streams, queues, stacks = 0, 0, 0
    writer.add(writer.root, c.Declare("size_t", "have", c.Literal("0u"), False))
    for number, node in enumerate(nodes):
        operands = operands_of(node)
        inputs = [(streams + 2 * k, streams + 2 * k + 1) for k in range(len(operands))]
        output = (streams + 2 * len(operands), streams + 2 * len(operands) + 1)
        _stage(writer, rule.formula, number, nodes, operands, inputs)
        for side in range(2):
            given = [_stream(pair[side]) for pair in inputs]
            kept: list[c.Expr] = []
            if isinstance(node, (ir.Temporal, ir.Until)):
                kept.append(c.Address(_part("queue", queues)))
                queues += 1
            if isinstance(node, ir.Until):
                kept += [c.Address(_part("stack", stacks + k)) for k in range(2)]
                stacks += 2
            flow = c.Address(_part("flow", 2 * number + side))
            step = _step(node, number, flow, kept, given, _stream(output[side]))
            writer.add(writer.root, c.Evaluate(step))
        writer.streams[node] = output
        streams = output[1] + 1
    _results(writer, rule.formula, nodes, operand, over)
    context = {
        "rule": comment(rule.name), "name": name, "begin": f"tm_{'true' if over is Extreme.LEAST else 'false'}_any()", "flows": 2 * len(nodes),
        "advance": "\n".join(c.printed(_advance(writer, rule, name))), "time": time, "fields": [c_name for _, c_name in fields],
        "oldest": [
            (number, isinstance(node, (ir.Temporal, ir.Until)) and node.upper is None) for number, node in enumerate(nodes)
        ],
    }  # fmt: skip
    text = render("program/source/monitor.c.j2", context)
    return Monitor(rule, name, fields, len(nodes), streams, queues, stacks, text)


def _advance(writer: _OnlineWriter, rule: RuleInfo, name: str) -> c.Function:
    """The function that takes every operator as far as the samples go."""
    body = writer.root.statements([""])
    unused = () if "context" in writer.reads else (c.Evaluate(c.Name("context"), True),)
    said = (f"Take every operator of {comment(rule.name)} as far as the samples go.",)
    parameters = (("tm_context *", "context"), (f"tm_online_{name} *", "monitor"))
    return c.Function(said, "void", f"tm_online_{name}_advance", parameters, (*unused, *body))


def _inner_first(operand: ir.Formula) -> list[ir.Timed]:
    """The temporal operators of a formula, those inside others before them."""
    found: dict[ir.Num | ir.Formula, None] = {}
    stack: list[tuple[ir.Num | ir.Formula, bool]] = [(operand, False)]
    while stack:
        node, ready = stack.pop()
        if node in found:
            continue
        if ready:
            found[node] = None
            continue
        stack.append((node, True))
        stack += [(child, False) for child in ir.operands(node)]
    return [node for node in found if isinstance(node, ir.Timed)]


def _inner(formulas: list[ir.Formula], nodes: list[ir.Timed]) -> list[int]:
    """Numbers of the outermost temporal operators inside formulas."""
    found: set[int] = set()
    stack: list[ir.Num | ir.Formula] = list(formulas)
    while stack:
        node = stack.pop()
        if isinstance(node, ir.Timed):
            found.add(nodes.index(node))
        else:
            stack += ir.operands(node)
    return sorted(found)


def _stage(
    writer: _OnlineWriter, first: ir.At, number: int, nodes: list[ir.Timed], operands: list[ir.Formula], inputs: list[tuple[int, int]]
) -> None:  # fmt: skip
    """The operands of an operator at every sample for which they are known."""
    writer.have(_inner(operands, nodes))
    index = _part("given", number)
    loop = writer.until(first.axis, index, first.name)
    for operand, pair in zip(operands, inputs):
        value = writer.formula(operand, loop)
        streams = [_stream(stream) for stream in pair]
        writer.add(loop, c.Evaluate(writer.over("stream", *streams, writer.ring(index), value)))
    writer.root.close(loop)


def _step(
    node: ir.Timed, number: int, flow: c.Expr, kept: list[c.Expr], given: list[c.Expr], target: c.Expr
) -> c.Expr:  # fmt: skip
    have = _part("given", number)
    finished = c.Member(_M, "finished", True)
    match node:
        case ir.Temporal() | ir.Until():
            ends = (0.0 if node.lower is None else node.lower, math.inf if node.upper is None else node.upper)
            window = [c.Literal(literal(bound(end))) for end in ends]
            place = [c.Member(_M, "stamp", True), have]
            if not node.past:
                place += [c.Member(_M, "count", True), finished]
            if isinstance(node, ir.Until):
                name = "tm_online_since" if node.past else "tm_online_until"
                return c.Call(name, (flow, *kept, *place, *window, *given, target))
            name = "tm_online_back" if node.past else "tm_online_ahead"
            return c.Call(
                name, (flow, *kept, *place, *window, truth(node.extreme is Extreme.LEAST), *given, target)
            )
        case ir.Shift():
            return c.Call(
                "tm_online_shift",
                (flow, have, finished, truth(node.step > 0), truth(node.weak), *given, target),
            )
        case _:
            assert_never(node)


def _results(
    writer: _OnlineWriter, first: ir.At, nodes: list[ir.Timed], operand: ir.Formula, over: Extreme | None
) -> None:
    writer.have(_inner([operand], nodes))
    done = c.Member(_M, "done", True)
    loop = writer.until(first.axis, done, first.name)
    value = writer.formula(operand, loop)
    if over is not None and not isinstance(value, c.Name):
        value = writer.declare(loop, writer.type, value, "holds")
    at = c.Address(c.Element(c.Member(_M, "result", True), writer.ring(done)))
    writer.add(loop, c.Evaluate(writer.over("conclude", at, writer.over("true"), value)))
    if over is not None:
        function = "for_all" if over is Extreme.LEAST else "exists"
        writer.add(loop, c.Evaluate(writer.over(function, c.Address(c.Member(_M, "all", True)), value)))
    writer.root.close(loop)
    writer.root.items += [(statement, "") for statement in _verdict(over)]


def _verdict(over: Extreme | None) -> list[c.Statement]:
    """The monitor's verdict, as soon as it is decided."""
    verdict = c.Member(_M, "verdict", True)
    if over is None:
        is_open = c.Binary("==", c.Member(verdict, "verdict", False), c.Name("TM_OPEN"))
        judged = c.Binary(">", c.Member(_M, "done", True), c.Literal("0u"))
        first = c.Element(c.Member(_M, "result", True), c.Literal("0"))
        return [c.If(c.Binary("&&", is_open, judged), (c.Assign(verdict, first),))]
    every, finished = c.Member(_M, "all", True), c.Member(_M, "finished", True)
    worst, best = c.Member(every, "worst_sat", False), c.Member(every, "best_sat", False)
    margins: list[c.Expr] = [c.Member(every, side, False) for side in ("worst", "best")]
    decided: c.Expr
    given: list[c.Expr]
    if over is Extreme.LEAST:
        decided, given = c.Unary("!", best), [c.Binary("&&", finished, worst), best]
    else:
        decided, given = worst, [worst, c.Binary("||", c.Unary("!", finished), best)]
    said = c.Call("tm_decide", (c.Address(verdict), truth(False), *given, *margins))
    return [c.If(c.Binary("||", finished, decided), (c.Evaluate(said),))]
