"""One C function a rule: first taking everything for known, then, only where something is not, with worst and best cases."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from trackmarshal.backends.c.expressions import Value, Writer
from trackmarshal.backends.c.layout import Layout, roots
from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.signs import signs_alone
from trackmarshal.backends.c.slots import assign
from trackmarshal.backends.c.statements import Block, prune, render
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo

#: How deep formulas may be nested; the generator goes down by calls.
DEEPEST = 900


@dataclass(frozen=True)
class RuleCode:
    """The functions of a rule, and what the report says about them."""

    rule: RuleInfo
    c_name: str
    text: str
    series: int
    libm: frozenset[str]
    #: A function that says the formula's value at every sample, for the binding; empty for rules without a timeline.
    along: str
    #: For every block of the function for known values: the signals whose loops it lies in, and its statements.
    operations: tuple[tuple[tuple[str, ...], int], ...]


def rule_code(plan: Layout, rule: RuleInfo) -> RuleCode:
    """Write a rule; raises TrackmarshalError E470 for what has no C counterpart."""
    try:
        quick, full = _function(plan, rule, True), _function(plan, rule, False)
        along = None if rule.along is None else _along(plan, rule)
    except RecursionError as error:
        span = rule.span
        raise TrackmarshalError(
            "E470", f"rule `{rule.name}` is nested too deeply", file=span.file.path, line=span.line
        ) from error
    name = plan.rule_names[rule.name]
    body = [
        f"/* {comment(rule.name)}: {comment(rule.title)}. Margin in {comment(rule.unit)}. {comment(_trace(rule))} */",
        *_signature(quick, name, "_known", "bool"),
        *_signature(full, name, "_any", "void"),
        *_entry(plan, rule, name),
    ]
    series = max(writer.series for writer in (quick, full, along) if writer is not None)
    text = "" if along is None else "\n".join(_along_signature(plan, along, rule, name))
    return RuleCode(
        rule, name, "\n".join(body), series, frozenset(quick.libm | full.libm), text, tuple(_operations(quick.root, ()))
    )  # fmt: skip


def _trace(rule: RuleInfo) -> str:
    wanted = ", ".join(name for name, _ in rule.satisfies) or "no requirement"
    return f"{wanted}; {rule.span.file.path}:{rule.span.line}"


def _operations(block: Block, around: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], int]]:
    """Every block with the signals that it and the blocks around it loop over, and how many values it computes."""
    if block.head.startswith("for"):
        around = (*around, *(axis.signal for axis in block.binds if isinstance(axis, ir.Axis)))
    own = sum(
        1
        for item in block.body
        if not isinstance(item, Block) and (item.target is not None or "[" in item.text)
    )
    yield around, own
    for item in block.body:
        if isinstance(item, Block):
            yield from _operations(item, around)


def _function(plan: Layout, rule: RuleInfo, known: bool) -> Writer:
    writer = Writer(plan, rule, known)
    root = writer.root
    assert rule.formula is not None
    if known:
        writer.add(root, "bool suspect = false;")
    formula, active = rule.formula, rule.active
    value: Value
    applies: Value | None
    if isinstance(formula, ir.Quantify) and isinstance(active, ir.Quantify) and formula.axis is active.axis:
        value, applies = writer.quantify([formula, active], root)
    else:
        value = writer.formula(formula, root)
        applies = None if active is None else writer.formula(active, root)
    inactive = "" if applies is None else f"!{applies.best_sat}"
    if known:
        writer.add(root, "if (suspect) { return false; }")
        writer.add(
            root,
            f"tm_decide(out, {inactive or 'false'}, {value.worst_sat}, {value.best_sat}, {value.worst_margin}, {value.best_margin});",
        )
        writer.add(root, "return true;")
    else:
        writer.add(
            root,
            f"tm_decide(out, {inactive or 'false'}, {value.worst_sat}, {value.best_sat}, {value.worst_margin}, {value.best_margin});",
        )
    prune(root)
    if known:
        signs_alone(root)
    writer.series = assign(root)
    return writer


def _along(plan: Layout, rule: RuleInfo) -> Writer:
    """The formula at every sample of the rule's timeline."""
    assert isinstance(rule.formula, ir.First)
    axis, operand = rule.formula.axis, rule.formula.operand
    writer = Writer(plan, rule, False)
    loop = writer.root.open(f"for (size_t i0 = 0u; i0 < {writer.count(axis)}; ++i0)")
    loop.binds[axis] = "i0"
    value = writer.formula(operand, loop)
    arguments = f"{value.worst_sat}, {value.best_sat}, {value.worst_margin}, {value.best_margin}"
    writer.add(loop, f"tm_decide(&out[i0], false, {arguments});")
    writer.root.close(loop)
    prune(writer.root)
    writer.series = assign(writer.root)
    return writer


def _along_signature(plan: Layout, writer: Writer, rule: RuleInfo, name: str) -> list[str]:
    head, opening, *body = _signature(writer, name, "_along", "void")
    lines = [head, opening, *(line for line in body if line == "  (void)c;")]
    for times in _timed(plan, rule):
        count = times.rpartition(", ")[2]
        lines += [
            f"  if (!tm_times({times})) {{",
            f"    for (size_t i = 0u; i < {count}; ++i) {{ tm_undefined(&out[i]); }}",
            "    return;",
            "  }",
        ]
    return [*lines, *(line for line in body if line != "  (void)c;"), ""]


def _timed(plan: Layout, rule: RuleInfo) -> list[str]:
    """C of the times and their number of every timeline that temporal operators of a rule run along."""
    places = (
        (plan.input(node.axis.signal).c_name, plan.field_name(node.axis.signal, "t"))
        for root in roots(rule)
        for node in ir.below(root)
        if isinstance(node, (ir.Temporal, ir.Until))
    )
    return sorted({f"in->{signal}.{t}, in->{signal}.count" for signal, t in places})


def _signature(writer: Writer, name: str, suffix: str, result: str) -> list[str]:
    lines = list(render(writer.root))
    text = "\n".join(lines)
    head = f"static {result} tm_rule_{name}{suffix}(tm_context *c, const tm_input *in, tm_result *out)"
    unused = [f"  (void){p};" for p in ("c", "in") if f"{p}->" not in text and f"({p}," not in text]
    return [head, "{", *unused, *lines[1:]]


def _entry(plan: Layout, rule: RuleInfo, name: str) -> list[str]:
    lines = [f"static void tm_rule_{name}(tm_context *c, const tm_input *in, tm_result *out)", "{"]
    for times in _timed(plan, rule):
        lines += [f"  if (!tm_times({times})) {{", "    tm_undefined(out);", "    return;", "  }"]
    return [
        *lines,
        f"  if (!tm_rule_{name}_known(c, in, out)) {{",
        f"    tm_rule_{name}_any(c, in, out);",
        "  }",
        "}",
        "",
    ]


@dataclass(frozen=True)
class GroupCode:
    """Rules over one timeline or set whose functions for known values are joined in one loop."""

    rules: tuple[RuleInfo, ...]
    c_name: str
    text: str


def group_codes(plan: Layout) -> list[GroupCode]:
    """The groups of rules that can share a loop: what they compute alike is computed once, and the loop runs once."""
    found: dict[ir.Axis, list[RuleInfo]] = {}
    for rule in plan.rules:
        axis = _axis(rule)
        if axis is not None:
            found.setdefault(axis, []).append(rule)
    groups = [(axis, rules) for axis, rules in found.items() if len(rules) > 1]
    return [
        _group(plan, f"{plan.input(axis.signal).c_name}_{i}", rules) for i, (axis, rules) in enumerate(groups)
    ]


def _axis(rule: RuleInfo) -> ir.Axis | None:
    """The timeline or set that a rule quantifies over, if it does nothing else that loops; a projection on a prepared line does not."""
    formula, active = rule.formula, rule.active
    if not isinstance(formula, ir.Quantify):
        return None
    if active is not None and not (isinstance(active, ir.Quantify) and active.axis is formula.axis):
        return None
    looping = ir.Quantify | ir.First | ir.Timed | ir.Geometry
    inner = [
        node
        for root in roots(rule)
        for node in ir.below(root)
        if (isinstance(node, looping) and node is not root)
        or (isinstance(node, ir.Along) and node.line.kind == "path")
    ]
    return None if inner else formula.axis


def _group(plan: Layout, name: str, rules: list[RuleInfo]) -> GroupCode:
    writer = Writer(plan, rules[0], True)
    root = writer.root
    nodes: list[ir.Quantify] = []
    owners: list[RuleInfo] = []
    for rule in rules:
        for formula in roots(rule):
            assert isinstance(formula, ir.Quantify)
            nodes.append(formula)
            owners.append(rule)
    root.add("bool suspect = false;")
    values = writer.quantify(nodes, root, owners)
    by_rule: dict[str, list[Value]] = {}
    for rule, value in zip(owners, values):
        by_rule.setdefault(rule.name, []).append(value)
    root.add("if (suspect) { return false; }")
    for rule in rules:
        value, *active = by_rule[rule.name]
        inactive = f"!{active[0].best_sat}" if active else "false"
        arguments = f"{value.worst_sat}, {value.best_sat}, {value.worst_margin}, {value.best_margin}"
        root.add(
            f"tm_decide(&out->rule[TM_RULE_{plan.rule_names[rule.name].upper()}], {inactive}, {arguments});"
        )
    root.add("return true;")
    prune(root)
    lines = list(render(root))
    text = "\n".join(lines)
    unused = [f"  (void){p};" for p in ("c", "in") if f"{p}->" not in text and f"({p}," not in text]
    head = f"static bool tm_known_{name}(tm_context *c, const tm_input *in, tm_output *out)"
    names = ", ".join(rule.name for rule in rules)
    said = f"/* In one loop, taking everything for known: {comment(names)}. False where something is not. */"
    return GroupCode(tuple(rules), f"tm_known_{name}", "\n".join([said, head, "{", *unused, *lines[1:], ""]))
