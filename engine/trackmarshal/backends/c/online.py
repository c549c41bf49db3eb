"""Rules along a timeline as monitors: a sample at a time, in memory of a fixed size, with the values that the whole timeline gives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import assert_never

from trackmarshal.backends.c import parts
from trackmarshal.backends.c.expressions import Value, Writer, extreme, neutral
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.statements import Block, prune, render
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import FieldType, RuleInfo

#: Samples that a monitor holds: as many as fall into its longest window, and a few.
CAPACITY = 1024
_POINTWISE = (
    ir.Const, ir.Param, ir.Column, ir.Arith, ir.Neg, ir.Func, ir.Choose, ir.Lookup, ir.Truth, ir.Flag, ir.Compare, ir.Not,
    ir.Connective, ir.Guarded, ir.Temporal, ir.Until, ir.Shift, ir.Axis,
)  # fmt: skip


@dataclass(frozen=True)
class Monitor:
    """The C of one rule's monitor."""

    rule: RuleInfo
    c_name: str
    fields: tuple[tuple[FieldType, str], ...]
    types: str
    prototypes: str
    text: str


def monitors(plan: Layout) -> list[Monitor]:
    """A monitor of every rule that can be judged a sample at a time."""
    return [monitor(plan, rule) for rule in plan.rules if obstacle(rule) is None]


def obstacle(rule: RuleInfo) -> str | None:
    """Why a rule cannot be judged a sample at a time; None where it can."""
    if rule.along is None or not isinstance(rule.formula, ir.First):
        return "it has no timeline"
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
    assert isinstance(rule.formula, ir.First)
    operand = rule.formula.operand
    if isinstance(operand, ir.Temporal) and not operand.past and operand.upper is None and not operand.lower:
        return operand.extreme, operand.operand
    return None, operand


class _OnlineWriter(Writer):
    """Values at one sample: columns and operators' values come from the monitor's rings."""

    streams: dict[ir.Formula, tuple[int, int]]

    def _column(self, node: ir.Column | ir.Flag, at: Block) -> str:
        assert node.axis is not None
        name = self.plan.field_name(node.axis.signal, node.field or "")
        return f"m->ring.{name}[tm_ring({self.index(node.axis, at)})]"

    def _formula(self, node: ir.Formula, at: Block) -> Value:
        if isinstance(node, ir.Timed):
            index = self.index(node.axis, at)
            texts = []
            for stream in self.streams[node]:
                texts += [f"m->stream[{stream}].{part}[tm_ring({index})]" for part in ("sat", "margin")]
            return self.value(at, *texts)
        return super()._formula(node, at)


def monitor(plan: Layout, rule: RuleInfo) -> Monitor:
    """Write a rule's monitor; raises TrackmarshalError E470 for a rule that cannot have one."""
    why = obstacle(rule)
    if why is not None:
        raise TrackmarshalError("E470", f"rule `{rule.name}` cannot be judged a sample at a time: {why}",
                                file=rule.span.file.path, line=rule.span.line)  # fmt: skip
    assert isinstance(rule.formula, ir.First)
    over, operand = _top(rule)
    axis = rule.formula.axis
    name = plan.rule_names[rule.name]
    others = set(plan.rule_names.values()) - {name}
    while (
        f"tm_online_{name}" in parts.functions() or name in others
    ):  # a rule called as an operator of ours is
        name = f"{name}_"
    nodes = _inner_first(operand)
    read = {node.field for node in ir.below(operand) if isinstance(node, (ir.Column, ir.Flag))}
    timed = any(isinstance(node, (ir.Temporal, ir.Until)) for node in nodes)
    fields = tuple(
        (info, c_name) for info, c_name in plan.input(axis.signal).fields
        if info.name in read or (timed and info.name == "t")
    )  # fmt: skip
    writer = _OnlineWriter(plan, rule, False)
    writer.streams = {}
    time = plan.field_name(axis.signal, "t") if timed else ""
    streams, queues, stacks = 0, 0, 0
    stages: list[str] = []
    oldest: list[str] = []
    for number, node in enumerate(nodes):
        operands = [node.left, node.right] if isinstance(node, ir.Until) else [node.operand]
        inputs = [(streams + 2 * k, streams + 2 * k + 1) for k in range(len(operands))]
        output = (streams + 2 * len(operands), streams + 2 * len(operands) + 1)
        stages += _stage(writer, axis, number, nodes, operands, inputs)
        for side in range(2):
            flow = f"&m->flow[{2 * number + side}]"
            given = [f"&m->stream[{pair[side]}]" for pair in inputs]
            queue = f"&m->queue[{queues}]" if isinstance(node, (ir.Temporal, ir.Until)) else ""
            queues += bool(queue)
            stack = f"&m->stack[{stacks}], &m->stack[{stacks + 1}]" if isinstance(node, ir.Until) else ""
            stacks += 2 * bool(stack)
            target = f"&m->stream[{output[side]}]"
            stages.append("  " + _step(node, number, flow, queue, stack, time, given, target))
        stays = "true" if isinstance(node, (ir.Temporal, ir.Until)) and node.upper is None else "false"
        oldest.append(f"tm_online_oldest(&m->flow[{2 * number}], {stays})")
        writer.streams[node] = output
        streams = output[1] + 1
    stages += _results(writer, axis, nodes, operand, over)
    types = _types(rule, name, fields, streams, 2 * len(nodes), queues, stacks)
    text = _functions(rule, name, fields, time, nodes, stages, oldest, over, queues)
    prototypes = [
        f"void tm_online_{name}_start(tm_online_{name} *m);",
        f"bool tm_online_{name}_push(tm_context *c, tm_online_{name} *m, const tm_sample_{name} *sample);",
        f"void tm_online_{name}_finish(tm_context *c, tm_online_{name} *m);",
    ]
    return Monitor(rule, name, fields, "\n".join(types), "\n".join(prototypes), "\n".join(text))


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


def _have(inner: list[int]) -> list[str]:
    lines = ["  have = m->count;"]
    for number in inner:
        next_ = f"m->flow[{2 * number}].next"
        lines.append(f"  if ({next_} < have) {{ have = {next_}; }}")
    return lines


def _stage(
    writer: _OnlineWriter, axis: ir.Axis, number: int, nodes: list[ir.Timed], operands: list[ir.Formula], inputs: list[tuple[int, int]]
) -> list[str]:  # fmt: skip
    """The operands of an operator at every sample for which they are known."""
    loop = Block(f"for (; m->given[{number}] < have; ++m->given[{number}])")
    loop.binds[axis] = f"m->given[{number}]"
    for operand, pair in zip(operands, inputs):
        value = writer.formula(operand, loop)
        for stream, (sat, margin) in zip(pair, value.sides):
            place = f"[tm_ring(m->given[{number}])]"
            writer.add(loop, f"m->stream[{stream}].sat{place} = {sat};")
            writer.add(loop, f"m->stream[{stream}].margin{place} = {margin};")
    prune(loop)
    return [*_have(_inner(operands, nodes)), *render(loop, 1)]


def _step(
    node: ir.Timed, number: int, flow: str, queue: str, stack: str, time: str, given: list[str], target: str
) -> str:  # fmt: skip
    have = f"m->given[{number}]"
    match node:
        case ir.Temporal() | ir.Until():
            window = (
                f"{literal(node.lower or 0.0)}, {literal(math.inf if node.upper is None else node.upper)}"
            )
            place = f"m->ring.{time}, {have}" + ("" if node.past else ", m->count, m->finished")
            if isinstance(node, ir.Until):
                name = "tm_online_since" if node.past else "tm_online_until"
                return (
                    f"{name}({flow}, {queue}, {stack}, {place}, {window}, {given[0]}, {given[1]}, {target});"
                )
            name = "tm_online_back" if node.past else "tm_online_ahead"
            least = "true" if node.extreme is Extreme.LEAST else "false"
            return f"{name}({flow}, {queue}, {place}, {window}, {least}, {given[0]}, {target});"
        case ir.Shift():
            ahead, weak = ("true" if node.step > 0 else "false"), ("true" if node.weak else "false")
            return f"tm_online_shift({flow}, {have}, m->finished, {ahead}, {weak}, {given[0]}, {target});"
        case _:
            assert_never(node)


def _results(
    writer: _OnlineWriter, axis: ir.Axis, nodes: list[ir.Timed], operand: ir.Formula, over: Extreme | None
) -> list[str]:
    loop = Block("for (; m->done < have; ++m->done)")
    loop.binds[axis] = "m->done"
    value = writer.formula(operand, loop)
    arguments = f"{value.worst_sat}, {value.best_sat}, {value.worst_margin}, {value.best_margin}"
    writer.add(loop, f"tm_decide(&m->result[tm_ring(m->done)], false, {arguments});")
    if over is not None:
        sign, pick = extreme(over)
        for side, (sat, margin) in zip(("worst", "best"), value.sides):
            writer.add(loop, f"m->{side}_sat = m->{side}_sat {sign} {sat};")
            writer.add(loop, f"m->{side}_margin = {pick}(m->{side}_margin, {margin});")
    prune(loop)
    return [*_have(_inner([operand], nodes)), *render(loop, 1)]


def _types(
    rule: RuleInfo, name: str, fields: tuple[tuple[FieldType, str], ...], streams: int, flows: int, queues: int, stacks: int
) -> Iterator[str]:  # fmt: skip
    from trackmarshal.backends.c.header import unit

    yield f"/* One sample for the monitor of {comment(rule.name)}. */"
    yield "typedef struct {"
    for info, c_name in fields:
        yield f"  {'tm_flag' if info.kind == 'bool' else 'double'} {c_name}; /* {unit(info)} */"
    if not fields:
        yield "  tm_flag unused;"
    yield f"}} tm_sample_{name};"
    yield ""
    yield f"/* The monitor of {comment(rule.name)}: samples so far, those whose value is final (the last TM_MAX_ONLINE are kept, sample i at"
    yield "   result[i % TM_MAX_ONLINE]), and the rule's verdict: open until it is decided. */"
    yield "typedef struct {"
    yield "  size_t count;\n  size_t done;\n  tm_result verdict;\n  bool finished;\n  bool broken; /* a sample did not fit */"
    yield "  bool worst_sat;\n  bool best_sat;\n  double worst_margin;\n  double best_margin;"
    if fields:
        yield "  struct {"
        for info, c_name in fields:
            yield f"    {'tm_flag' if info.kind == 'bool' else 'double'} {c_name}[TM_MAX_ONLINE];"
        yield "  } ring; /* the samples */"
    yield "  tm_result result[TM_MAX_ONLINE];"
    if flows:
        yield f"  size_t given[{flows // 2}];\n  tm_flow flow[{flows}];\n  tm_stream stream[{streams}];"
    if queues:
        yield f"  tm_candidates queue[{queues}];"
    if stacks:
        yield f"  tm_stream stack[{stacks}];"
    yield f"}} tm_online_{name};"
    yield ""


def _functions(
    rule: RuleInfo, name: str, fields: tuple[tuple[FieldType, str], ...], time: str, nodes: list[ir.Timed], stages: list[str],
    oldest: list[str], over: Extreme | None, queues: int,
) -> Iterator[str]:  # fmt: skip
    flows = 2 * len(nodes)
    yield f"/* Begin a timeline of {comment(rule.name)}. */"
    yield f"void tm_online_{name}_start(tm_online_{name} *m)"
    yield "{"
    yield "  m->count = 0u;\n  m->done = 0u;\n  m->finished = false;\n  m->broken = false;"
    yield "  m->verdict.verdict = TM_OPEN;\n  m->verdict.margin = TM_NAN;"
    start, margin = neutral(over or Extreme.GREATEST)
    yield f"  m->worst_sat = {start};\n  m->best_sat = {start};\n  m->worst_margin = {margin};\n  m->best_margin = {margin};"
    if flows:
        yield f"  for (size_t i = 0u; i < {flows}u; ++i) {{"
        yield "    m->given[i / 2u] = 0u;"
        for member in ("next", "begin", "end", "stop", "mid", "head", "tail", "decisive"):
            yield f"    m->flow[i].{member} = 0u;"
        yield "    tm_online_rest(&m->flow[i]);"
        yield "  }"
    yield "}"
    yield ""
    yield f"/* Take every operator of {comment(rule.name)} as far as the samples go. */"
    yield f"static void tm_online_{name}_advance(tm_context *c, tm_online_{name} *m)"
    yield "{"
    yield "  size_t have;"
    if not any("c->" in line for line in stages):
        yield "  (void)c;"
    yield from stages
    if over is None:
        yield "  if ((m->verdict.verdict == TM_OPEN) && (m->done > 0u)) { m->verdict = m->result[0]; }"
    else:
        worst, best = ("m->finished && m->worst_sat", "m->best_sat")
        if over is Extreme.GREATEST:
            worst, best = ("m->worst_sat", "!m->finished || m->best_sat")
        yield f"  if (m->finished || {'!m->best_sat' if over is Extreme.LEAST else 'm->worst_sat'}) {{"
        yield f"    tm_decide(&m->verdict, false, {worst}, {best}, m->worst_margin, m->best_margin);"
        yield "  }"
    yield "}"
    yield ""
    yield f"/* The next sample of {comment(rule.name)}. False: its time does not increase, or more samples than TM_MAX_ONLINE are needed at once;"
    yield "   nothing that is not final yet will be, the verdict is undefined. */"
    yield f"bool tm_online_{name}_push(tm_context *c, tm_online_{name} *m, const tm_sample_{name} *sample)"
    yield "{"
    yield "  size_t needed = m->done;"
    yield "  if (m->finished || m->broken) { return false; }"
    for text in oldest:
        yield f"  if ({text} < needed) {{ needed = {text}; }}"
    yield "  m->broken = ((m->count - needed) + 2u) >= TM_MAX_ONLINE;"
    if time:
        last = f"m->ring.{time}[tm_ring(m->count - 1u)]"
        yield f"  m->broken = m->broken || !tm_finite(sample->{time}) || ((m->count > 0u) && !({last} < sample->{time}));"
    yield "  if (m->broken) {"
    yield "    tm_undefined(&m->verdict);"
    yield "    return false;"
    yield "  }"
    for _, c_name in fields:
        yield f"  m->ring.{c_name}[tm_ring(m->count)] = sample->{c_name};"
    if not fields:
        yield "  (void)sample;"
    yield "  ++m->count;"
    yield f"  tm_online_{name}_advance(c, m);"
    yield "  return true;"
    yield "}"
    yield ""
    yield "/* No sample comes after this: windows end here. */"
    yield f"void tm_online_{name}_finish(tm_context *c, tm_online_{name} *m)"
    yield "{"
    yield "  if (!m->broken) {"
    yield "    m->finished = true;"
    yield f"    tm_online_{name}_advance(c, m);"
    yield "  }"
    yield "}"
    yield ""


#: Types that all monitors share.
TYPES = [
    "/* Capacity: samples that a monitor holds; a power of two is fastest. */",
    "#ifndef TM_MAX_ONLINE",
    f"#define TM_MAX_ONLINE {CAPACITY}u",
    "#endif",
    "",
    "/* A formula at the last samples of a timeline, sample i at [i % TM_MAX_ONLINE]. */",
    "typedef struct {\n  double margin[TM_MAX_ONLINE];\n  bool sat[TM_MAX_ONLINE];\n} tm_stream;",
    "",
    "/* Samples that may decide a window. */",
    "typedef struct {\n  size_t index[TM_MAX_ONLINE];\n  double key[TM_MAX_ONLINE];\n} tm_candidates;",
    "",
    "/* How far an operator has come: the next sample to be decided, its window, its queue of candidates. */",
    "typedef struct {",
    *(f"  size_t {name};" for name in ("next", "begin", "end", "stop", "mid", "head", "tail")),
    "  size_t decisive; /* samples that fail, or that hold */",
    "  double rest_goal;\n  double rest_hold;\n  bool rest_goal_sat;\n  bool rest_hold_sat;",
    "} tm_flow;",
    "",
]  # fmt: skip


def glue(found: list[Monitor]) -> Iterator[str]:
    """The binding: a monitor over columns, a sample at a time; results as they become final."""
    yield "size_t tmg_online_size(size_t monitor) {"
    yield "  switch (monitor) {"
    for i, item in enumerate(found):
        yield f"    case {i}u: return sizeof(tm_online_{item.c_name});"
    yield "    default: return 0u;"
    yield "  }"
    yield "}"
    for item in found:
        name = item.c_name
        yield f"static size_t tmg_pushed_{name}(tm_context *c, tm_online_{name} *m, size_t n, const void *const *columns, tm_result *out) {{"
        yield "  size_t read = 0u;"
        yield f"  tm_online_{name}_start(m);"
        yield "  (void)columns;"
        yield "  for (size_t i = 0u; i < n; ++i) {"
        yield f"    tm_sample_{name} sample;"
        for k, (info, c_name) in enumerate(item.fields):
            yield f"    sample.{c_name} = ((const {'tm_flag' if info.kind == 'bool' else 'double'} *)columns[{k}])[i];"
        if not item.fields:
            yield "    sample.unused = 0;"
        yield f"    if (!tm_online_{name}_push(c, m, &sample)) {{ break; }}"
        yield "    for (; read < m->done; ++read) { out[read] = m->result[tm_ring(read)]; }"
        yield "  }"
        yield f"  tm_online_{name}_finish(c, m);"
        yield "  for (; read < m->done; ++read) { out[read] = m->result[tm_ring(read)]; }"
        yield "  out[n] = m->verdict;"
        yield "  return read;"
        yield "}"
    yield "size_t tmg_online(void *context, size_t monitor, void *memory, size_t n, const void *const *columns, tm_result *out) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  (void)c; (void)memory; (void)n; (void)columns; (void)out;"
    yield "  switch (monitor) {"
    for i, item in enumerate(found):
        yield f"    case {i}u: return tmg_pushed_{item.c_name}(c, (tm_online_{item.c_name} *)memory, n, columns, out);"
    yield "    default: return 0u;"
    yield "  }"
    yield "}"
