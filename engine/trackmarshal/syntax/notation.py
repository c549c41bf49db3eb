"""Expressions as text on one line, in ASCII or with mathematical signs, in parentheses where they are needed or were written."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from trackmarshal.syntax import ast
from trackmarshal.syntax.names import lettered
from trackmarshal.units import UNIT_PATTERN

# How tightly the grammar's rules bind, loosest first; the numbers are the rules of spec.lark.
(
    EXPRESSION, IMPLICATION, DISJUNCTION, CONJUNCTION, UNTIL, UNARY, COMPARISON, SUM, ADDITIVE, PRODUCT, FACTOR, POWER, POSTFIX,
) = range(1, 14)  # fmt: skip

#: Operator -> (its level, the level of its left operand, of its right operand). Comparisons would take an `if` without
#: parentheses, and people would not.
LEVELS = {
    "iff": (EXPRESSION, EXPRESSION, IMPLICATION), "xor": (EXPRESSION, EXPRESSION, IMPLICATION),
    "implies": (IMPLICATION, DISJUNCTION, IMPLICATION), "or": (DISJUNCTION, DISJUNCTION, CONJUNCTION),
    "and": (CONJUNCTION, CONJUNCTION, UNTIL),
    "<": (COMPARISON, ADDITIVE, ADDITIVE), "<=": (COMPARISON, ADDITIVE, ADDITIVE), ">": (COMPARISON, ADDITIVE, ADDITIVE), ">=": (COMPARISON, ADDITIVE, ADDITIVE),
    "==": (COMPARISON, ADDITIVE, ADDITIVE), "!=": (COMPARISON, ADDITIVE, ADDITIVE),
    "+": (ADDITIVE, ADDITIVE, PRODUCT), "-": (ADDITIVE, ADDITIVE, PRODUCT),
    "*": (PRODUCT, PRODUCT, FACTOR), "/": (PRODUCT, PRODUCT, FACTOR), "^": (POWER, POSTFIX, POSTFIX),
}  # fmt: skip

#: Whether a quantifier on their left goes on past them, W307 asks the author: parentheses that the formatter wrote would answer for him.
ASKED = ("implies", "iff", "xor")

_SIGNS = {"<=": "≤", ">=": "≥", "!=": "≠", "and": "∧", "or": "∨", "implies": "→", "iff": "↔", "*": "·", "not": "¬",
          "for all": "∀", "exists": "∃", "in": "∈"}  # fmt: skip
_SQUARE_OR_CUBE = re.compile(r"\^([23])(?![0-9])")
_BARE_NUMBER_END = re.compile(r"(?<![\w.])(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\Z")
_UNIT = re.compile(rf"{UNIT_PATTERN}\Z")


def quoted(text: str) -> str:
    """A string literal."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


class Notation:
    """One of the two styles of writing."""

    def __init__(self, unicode: bool) -> None:
        self.unicode = unicode

    def name(self, name: str) -> str:
        return lettered(name) if self.unicode else name

    def names(self, names: tuple[str, ...]) -> str:
        return ", ".join(map(self.name, names))

    def unit(self, unit: str) -> str:
        if not self.unicode:
            return unit
        return _SQUARE_OR_CUBE.sub(lambda m: "²" if m[1] == "2" else "³", unit).replace("*", "·")

    def sign(self, word: str) -> str:
        """An operator or quantifier."""
        return _SIGNS.get(word, word) if self.unicode else word

    def range(self, lower: ast.Expr, upper: ast.Expr) -> str:
        return f"{self.sign('in')} [{self.expr(lower, SUM)}, {self.expr(upper, SUM)}]"

    def window(self, window: ast.Window | None) -> str:
        return "" if window is None else f"[{self.expr(window.lower, SUM)}, {self.expr(window.upper, SUM)}]"

    def binder(self, node: ast.Quantified | ast.Bind) -> str:
        """`for all p in plan`, without its condition."""
        return f"{self.quantifier(node)} {self.bound(node)}"

    def quantifier(self, node: ast.Quantified | ast.Bind) -> str:
        """`for all`, or `for nearest`."""
        sign = self.sign(node.quantifier)
        return sign if node.by is None else f"{'for' if sign == 'for all' else sign} nearest"

    def bound(self, node: ast.Quantified | ast.Bind | ast.Folded) -> str:
        """`p in plan`; of the nearest also by what it is that."""
        consecutive = "consecutive " if node.consecutive else ""
        text = f"{consecutive}{self.names(node.names)} {self.sign('in')} {self.expr(node.domain, POSTFIX)}"
        if isinstance(node, ast.Folded) or node.by is None:
            return text
        return f"{text} by {self.expr(node.by, SUM)}"

    def expr(self, node: ast.Expr, level: int = EXPRESSION) -> str:
        """An expression where the grammar wants one that binds at least as tightly as `level`."""
        return self.enclosed(node, level_of(node) < level)

    def enclosed(self, node: ast.Expr, needed: bool) -> str:
        """An expression, in parentheses where they are needed or its author wrote them."""
        text = self.bare(node)
        return f"({text})" if needed or ast.is_parenthesised(node) else text

    def bare(self, node: ast.Expr) -> str:
        """An expression without parentheses around it."""
        handler = _HANDLERS.get(type(node))
        if handler is None:
            raise TypeError(f"no notation for a {type(node).__name__}")
        return handler(self, node)

    def _number(self, node: ast.Number) -> str:
        return f"{node.text} {self.unit(node.unit)}" if node.unit else node.text

    def _boolean(self, node: ast.Boolean) -> str:
        return "true" if node.value else "false"

    def _name(self, node: ast.Name) -> str:
        return self.name(node.name)

    def _attribute(self, node: ast.Attribute) -> str:
        return f"{self.base(node.value)}.{self.name(node.name)}"

    def base(self, node: ast.Expr) -> str:
        """What `.name` or an exponent follows; a unit would take up the exponent."""
        return self.enclosed(
            node, level_of(node) < POSTFIX or (isinstance(node, ast.Number) and node.unit != "")
        )

    def argument(self, name: str, value: ast.Expr) -> str:
        return f"{self.name(name)}: {self.expr(value)}" if name else self.expr(value)

    def function(self, node: ast.Call) -> str:
        """The function's name, or the root sign."""
        if self.unicode and node.function == "sqrt" and len(node.args) == 1 and not any(node.names):
            return "√"
        return self.name(node.function)

    def _call(self, node: ast.Call) -> str:
        return f"{self.function(node)}({', '.join(map(self.argument, argument_names(node), node.args))})"

    def predicate_left(self, node: ast.Infix) -> str:
        """The left side of `a behind b`; a predicate with a unit's name must not become a unit."""
        left = self.expr(node.left, ADDITIVE)
        return f"({left})" if _UNIT.match(node.predicate) and _BARE_NUMBER_END.search(left) else left

    def _infix(self, node: ast.Infix) -> str:
        return f"{self.predicate_left(node)} {self.name(node.predicate)} {self.expr(node.right, ADDITIVE)}"

    def prefix(self, node: ast.Unary) -> str:
        """`not ` or `-`."""
        return f"{self.sign('not')} " if node.op == "not" else "-"

    def parenthesised(self, node: ast.Unary) -> bool:
        """Whether the operand of `not` and `-` stands in parentheses."""
        if node.op == "not":
            # `not a in zone z` could be read without them, and would be misread.
            return level_of(node.operand) < UNARY or level_of(node.operand) in (COMPARISON, SUM)
        # Two minus signs would start a comment.
        return level_of(node.operand) <= FACTOR

    def _unary(self, node: ast.Unary) -> str:
        return self.prefix(node) + self.enclosed(node.operand, self.parenthesised(node))

    def operand(self, node: ast.Expr, level: int, last: bool) -> str:
        """An operand; whose end cannot be seen, like a quantifier's, stands in parentheses unless it is the last."""
        return self.enclosed(node, level_of(node) < level or (not last and open_ended(node)))

    def _binary(self, node: ast.Binary) -> str:
        if node.op == "^":
            return self.base(node.left) + self.exponent(node.right)
        _, left, right = LEVELS[node.op]
        first = self.operand(node.left, left, node.op in ASKED)
        return f"{first} {self.sign(node.op)} {self.operand(node.right, right, True)}"

    def _chained(self, node: ast.Chained) -> str:
        first, *rest = node.operands
        return self.expr(first, ADDITIVE) + "".join(
            f" {self.sign(op)} {self.expr(operand, ADDITIVE)}" for op, operand in zip(node.ops, rest)
        )

    def exponent(self, node: ast.Expr) -> str:
        if ast.is_parenthesised(node):
            return f"^{self.expr(node)}"
        if self.unicode and isinstance(node, ast.Number) and node.text in ("2", "3") and not node.unit:
            return "²" if node.text == "2" else "³"
        if isinstance(node, ast.Unary) and node.op == "-":
            return f"^-{self.expr(node.operand, POSTFIX)}"
        return f"^{self.expr(node, POSTFIX)}"

    def _if_else(self, node: ast.IfElse) -> str:
        then, otherwise = self.operand(node.then, SUM, False), self.expr(node.otherwise, SUM)
        return f"if {self.expr(node.condition)} then {then} else {otherwise}"

    def branch(self, node: ast.Branch) -> str:
        """`green, blue: `, or `else: `."""
        return f"{self.names(tuple(name.name for name in node.members)) or 'else'}: "

    def _case(self, node: ast.Case) -> str:
        branches = ", ".join(self.branch(each) + self.expr(each.value) for each in node.branches)
        return f"case {self.expr(node.value, POSTFIX)} {{ {branches} }}"

    def _within(self, node: ast.Within) -> str:
        return f"{self.expr(node.value, ADDITIVE)} {self.range(node.lower, node.upper)}"

    def _in_zone(self, node: ast.InZone) -> str:
        return f"{self.expr(node.value, ADDITIVE)} {self.sign('in')} zone {self.name(node.zone)}"

    def _in_stretch(self, node: ast.InStretch) -> str:
        return f"{self.expr(node.value, ADDITIVE)} {self.in_stretch(node)}"

    def in_stretch(self, node: ast.InStretch) -> str:
        """`in stretch chicane`."""
        return f"{self.sign('in')} stretch {self.name(node.stretch)}"

    def _between_stations(self, node: ast.BetweenStations) -> str:
        return f"{self.expr(node.value, ADDITIVE)} {self.between_stations(node)}"

    def between_stations(self, node: ast.BetweenStations) -> str:
        """`in stretch(track, 4900 m, 120 m)`."""
        parts = self.expr(node.line, POSTFIX), self.expr(node.start, SUM), self.expr(node.end, SUM)
        return f"{self.sign('in')} stretch({', '.join(parts)})"

    def temporal(self, node: ast.Temporal) -> str:
        """`weak next`, `always[0 s, 1 s]`."""
        return f"{'weak ' if node.weak else ''}{node.op}{self.window(node.window)}"

    def _temporal(self, node: ast.Temporal) -> str:
        return f"{self.temporal(node)} {self.expr(node.operand, UNARY)}"

    def _until(self, node: ast.Until) -> str:
        left = self.operand(node.left, UNARY, False)
        return f"{left} {node.op}{self.window(node.window)} {self.operand(node.right, UNARY, True)}"

    def _quantified(self, node: ast.Quantified) -> str:
        where = "" if node.where is None else f" where {self.expr(node.where)}"
        return f"{self.binder(node)}{where}: {self.expr(node.body, UNARY)}"

    def folded_parts(self, node: ast.Folded) -> list[str]:
        """What stands between the parentheses, in parts between which a line may end."""
        where = [] if node.where is None else [f"where {self.expr(node.where)}"]
        otherwise = [] if node.otherwise is None else [f"else {self.expr(node.otherwise, SUM)}"]
        if node.body is None:
            return [self.bound(node), *where, *otherwise]
        return [self.expr(node.body), f"for {self.bound(node)}", *where, *otherwise]

    def _folded(self, node: ast.Folded) -> str:
        return f"{self.name(node.function)}({' '.join(self.folded_parts(node))})"

    def _record(self, node: ast.RecordValue) -> str:
        entries = ", ".join(map(self.argument, node.names, node.values))
        return f"{{ {entries} }}" if entries else "{}"

    def _list(self, node: ast.ListValue) -> str:
        return f"[{', '.join(map(self.expr, node.values))}]"


def argument_names(node: ast.Call) -> tuple[str, ...]:
    """The names of a call's arguments, one for each, empty where there is none."""
    return node.names or ("",) * len(node.args)


def open_ended(node: ast.Expr) -> bool:
    """Whether a reader would take what follows for a part of the expression: it ends in a quantifier or `else`."""
    while True:
        if isinstance(node, (ast.Quantified, ast.IfElse)):
            return True
        last: ast.Expr
        if isinstance(node, ast.Temporal) or (isinstance(node, ast.Unary) and node.op == "not"):
            last, level = node.operand, UNARY
        elif isinstance(node, ast.Binary) and LEVELS[node.op][0] <= COMPARISON:
            last, level = node.right, LEVELS[node.op][2]
        elif isinstance(node, ast.Until):
            last, level = node.right, UNARY
        elif isinstance(node, ast.Infix):
            last, level = node.right, ADDITIVE
        else:
            return False
        if level_of(last) < level or ast.is_parenthesised(last):
            return False
        node = last


def level_of(node: ast.Expr) -> int:
    """How tightly an expression binds by itself."""
    if isinstance(node, ast.Binary):
        return LEVELS[node.op][0]
    if isinstance(node, ast.Unary):
        return UNARY if node.op == "not" else FACTOR
    level = _NODE_LEVELS.get(type(node))
    if level is None:
        raise TypeError(f"no notation for a {type(node).__name__}")
    return level


_NODE_LEVELS: dict[type[ast.Expr], int] = {
    ast.Number: POSTFIX, ast.Boolean: POSTFIX, ast.Name: POSTFIX, ast.Attribute: POSTFIX, ast.Call: POSTFIX,
    ast.Chained: COMPARISON, ast.Infix: COMPARISON, ast.IfElse: SUM, ast.Within: COMPARISON, ast.InZone: COMPARISON, ast.InStretch: COMPARISON,
    ast.BetweenStations: COMPARISON, ast.Temporal: UNARY,
    ast.Until: UNTIL, ast.Quantified: UNARY, ast.Folded: POSTFIX, ast.Case: POSTFIX, ast.RecordValue: POSTFIX, ast.ListValue: POSTFIX,
}  # fmt: skip

_HANDLERS: dict[type[ast.Expr], Callable[[Notation, Any], str]] = {
    ast.Number: Notation._number, ast.Boolean: Notation._boolean, ast.Name: Notation._name, ast.Attribute: Notation._attribute,
    ast.Call: Notation._call, ast.Infix: Notation._infix, ast.Unary: Notation._unary, ast.Binary: Notation._binary,
    ast.Chained: Notation._chained,
    ast.IfElse: Notation._if_else, ast.Case: Notation._case, ast.Within: Notation._within, ast.InZone: Notation._in_zone,
    ast.InStretch: Notation._in_stretch, ast.BetweenStations: Notation._between_stations,
    ast.Temporal: Notation._temporal, ast.Until: Notation._until, ast.Quantified: Notation._quantified,
    ast.Folded: Notation._folded, ast.RecordValue: Notation._record, ast.ListValue: Notation._list,
}  # fmt: skip
