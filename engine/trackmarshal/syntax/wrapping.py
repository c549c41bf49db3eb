"""Expressions over several lines: broken at the loosest operators first, each level two columns deeper."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from trackmarshal.syntax import ast
from trackmarshal.syntax.notation import (
    ADDITIVE,
    ASKED,
    EXPRESSION,
    IMPLICATION,
    LEVELS,
    POSTFIX,
    SUM,
    UNARY,
    Notation,
    argument_names,
    level_of,
    open_ended,
)

#: The longest line, where that is possible: names and strings are not broken.
WIDTH = 110


def new_line(column: int) -> str:
    return "\n" + " " * column


def end_column(text: str, column: int) -> int:
    """The column after a text of one or more lines that starts at `column`."""
    _, line, last = text.rpartition("\n")
    return len(last) if line else column + len(last)


class Wrapping:
    """Lays out expressions from a column on; later lines carry their own indentation."""

    def __init__(self, notation: Notation) -> None:
        self.notation = notation

    def lay(self, node: ast.Expr, level: int, column: int, tail: int = 0) -> str:
        """An expression on one line if it and `tail` more characters fit, else on several."""
        return self._lay(node, level_of(node) < level, column, tail)

    def _lay(self, node: ast.Expr, parentheses: bool, column: int, tail: int) -> str:
        parentheses = parentheses or ast.is_parenthesised(node)
        flat = self.notation.bare(node)
        if column + len(flat) + 2 * parentheses + tail > WIDTH:
            handler = _HANDLERS.get(type(node))
            if handler is not None:
                inside = column + parentheses
                flat = handler(self, node, inside, tail + parentheses)
        return f"({flat})" if parentheses else flat

    def append(self, text: str, column: int, more: str, indent: int, blanks: int = 2) -> str:
        """A text, and blanks and more if that fits, else more on a line of its own."""
        if end_column(text, column) + blanks + len(more) <= WIDTH:
            return f"{text}{' ' * blanks}{more}"
        return f"{text.rstrip()}{new_line(indent)}{more}"

    def fill(
        self,
        parts: Iterable[tuple[str, ast.Expr | None]],
        column: int,
        indent: int,
        tail: int,
        separator: str = ",",
    ) -> str:
        """Parts, each a text or a text and an expression after it, on as few lines as they need."""
        text, at = "", column
        parts = list(parts)
        for number, (prefix, node) in enumerate(parts):
            after = len(separator) if number < len(parts) - 1 else tail
            flat = prefix + ("" if node is None else self.notation.expr(node))
            if number and at + 1 + len(flat) + after > WIDTH:
                text += new_line(indent)
                at = indent
            elif number:
                text += " "
                at += 1
            laid = prefix if node is None else prefix + self.lay(node, EXPRESSION, at + len(prefix), after)
            text += laid
            at = end_column(laid, at)
            if number < len(parts) - 1:
                text += separator
                at += len(separator)
        return text

    def _operand(self, node: ast.Expr, level: int, last: bool, column: int, tail: int = 0) -> str:
        return self._lay(node, level_of(node) < level or (not last and open_ended(node)), column, tail)

    def _binary(self, node: ast.Binary, column: int, tail: int) -> str:
        if node.op == "^":
            exponent = self.notation.exponent(node.right)
            if isinstance(node.left, ast.Number):
                return self.notation.base(node.left) + exponent
            return self.lay(node.left, POSTFIX, column, tail + len(exponent)) + exponent
        first, rest = _chain(node)
        level, left, right = LEVELS[node.op]
        text = self._operand(first, left, node.op in ASKED, column)
        inner = column + 2
        for number, (op, operand) in enumerate(rest):
            last = number == len(rest) - 1
            sign = self.notation.sign(op) + " "
            # Of `a implies b implies c`, b is a left operand too.
            wanted = left if level == IMPLICATION and not last else right
            text += new_line(inner) + sign
            text += self._operand(operand, wanted, True, inner + len(sign), tail if last else 0)
        return text

    def _chained(self, node: ast.Chained, column: int, tail: int) -> str:
        first, *rest = node.operands
        text, inner = self.lay(first, ADDITIVE, column), column + 2
        for number, (op, operand) in enumerate(zip(node.ops, rest), start=1):
            sign = self.notation.sign(op) + " "
            after = tail if number == len(rest) else 0
            text += new_line(inner) + sign + self.lay(operand, ADDITIVE, inner + len(sign), after)
        return text

    def _unary(self, node: ast.Unary, column: int, tail: int) -> str:
        prefix = self.notation.prefix(node)
        return prefix + self._lay(node.operand, self.notation.parenthesised(node), column + len(prefix), tail)

    def _temporal(self, node: ast.Temporal, column: int, tail: int) -> str:
        prefix = self.notation.temporal(node) + " "
        return prefix + self.lay(node.operand, UNARY, column + len(prefix), tail)

    def _until(self, node: ast.Until, column: int, tail: int) -> str:
        word = f"{node.op}{self.notation.window(node.window)} "
        left = self._operand(node.left, UNARY, False, column)
        return f"{left}{new_line(column + 2)}{word}" + self._operand(
            node.right, UNARY, True, column + 2 + len(word), tail
        )

    def _quantified(self, node: ast.Quantified, column: int, tail: int) -> str:
        head = self.notation.binder(node)
        if node.where is not None:
            head = self.where(head, node.where, column, column + 4, 1)
        return f"{head}:{new_line(column + 2)}" + self.lay(node.body, UNARY, column + 2, tail)

    def where(self, head: str, condition: ast.Expr, column: int, indent: int, tail: int) -> str:
        """A binder and its condition."""
        flat = self.notation.expr(condition)
        if end_column(head, column) + len(" where ") + len(flat) + tail <= WIDTH:
            return f"{head} where {flat}"
        return f"{head}{new_line(indent)}where " + self.lay(
            condition, EXPRESSION, indent + len("where "), tail
        )

    def _infix(self, node: ast.Infix, column: int, tail: int) -> str:
        # The predicate stays on the line of its left side: at a line's start it would look like a clause.
        name = self.notation.name(node.predicate)
        parentheses = level_of(node.left) < ADDITIVE or self.notation.predicate_left(
            node
        ) != self.notation.expr(node.left, ADDITIVE)
        left = self._lay(node.left, parentheses, column, 1 + len(name))
        return f"{left} {name}{new_line(column + 2)}" + self.lay(node.right, ADDITIVE, column + 2, tail)

    def _if_else(self, node: ast.IfElse, column: int, tail: int) -> str:
        lines, word = [], "if "
        while True:
            condition = self.notation.expr(node.condition)
            then = self.notation.operand(node.then, SUM, False)
            if column + len(f"{word}{condition} then {then}") <= WIDTH:
                lines.append(f"{word}{condition} then {then}")
            else:
                lines.append(word + self.lay(node.condition, EXPRESSION, column + len(word)))
                inner = column + 2
                lines.append("  then " + self._operand(node.then, SUM, False, inner + len("then ")))
            if not isinstance(node.otherwise, ast.IfElse) or ast.is_parenthesised(node.otherwise):
                break
            node, word = node.otherwise, "else if "
        lines.append("else " + self.lay(node.otherwise, SUM, column + len("else "), tail))
        return new_line(column).join(lines)

    def _case(self, node: ast.Case, column: int, tail: int) -> str:
        inner = column + 2
        lines = []
        for branch in node.branches:
            lead = self.notation.branch(branch)
            lines.append(lead + self.lay(branch.value, EXPRESSION, inner + len(lead), 1))
        head = f"case {self.notation.expr(node.value, POSTFIX)} {{{new_line(inner)}"
        return head + f",{new_line(inner)}".join(lines) + new_line(column) + "}"

    def _within(self, node: ast.Within, column: int, tail: int) -> str:
        value = self.lay(node.value, ADDITIVE, column)
        return f"{value}{new_line(column + 2)}{self.notation.range(node.lower, node.upper)}"

    def _in_zone(self, node: ast.InZone, column: int, tail: int) -> str:
        zone = f" {self.notation.sign('in')} zone {self.notation.name(node.zone)}"
        return self.lay(node.value, ADDITIVE, column, tail + len(zone)) + zone

    def _in_stretch(self, node: ast.InStretch, column: int, tail: int) -> str:
        stretch = f" {self.notation.in_stretch(node)}"
        return self.lay(node.value, ADDITIVE, column, tail + len(stretch)) + stretch

    def _between_stations(self, node: ast.BetweenStations, column: int, tail: int) -> str:
        value = self.lay(node.value, ADDITIVE, column)
        return f"{value}{new_line(column + 2)}{self.notation.between_stations(node)}"

    def _attribute(self, node: ast.Attribute, column: int, tail: int) -> str:
        name = f".{self.notation.name(node.name)}"
        if isinstance(node.value, ast.Number):
            return self.notation.base(node.value) + name
        return self.lay(node.value, POSTFIX, column, tail + len(name)) + name

    def _call(self, node: ast.Call, column: int, tail: int) -> str:
        head = self.notation.function(node) + "("
        return head + self._arguments(argument_names(node), node.args, column + len(head), tail + 1) + ")"

    def _folded(self, node: ast.Folded, column: int, tail: int) -> str:
        head = f"{self.notation.name(node.function)}("
        inner = column + len(head)
        lines = self.notation.folded_parts(node)
        if node.body is not None:
            lines[0] = self.lay(node.body, EXPRESSION, inner)
        if node.where is not None:
            place = len(lines) - (2 if node.otherwise is not None else 1)
            lines[place] = "where " + self.lay(node.where, EXPRESSION, inner + len("where "), tail + 1)
        return head + new_line(inner).join(lines) + ")"

    def _record(self, node: ast.RecordValue, column: int, tail: int) -> str:
        if not node.values:
            return "{}"
        return "{ " + self._arguments(node.names, node.values, column + 2, tail + 2) + " }"

    def _list(self, node: ast.ListValue, column: int, tail: int) -> str:
        return "[" + self._arguments(("",) * len(node.values), node.values, column + 1, tail + 1) + "]"

    def _arguments(self, names: tuple[str, ...], values: tuple[ast.Expr, ...], column: int, tail: int) -> str:
        return self.fill(self._named(names, values), column, column, tail)

    def _named(
        self, names: tuple[str, ...], values: tuple[ast.Expr, ...]
    ) -> list[tuple[str, ast.Expr | None]]:
        return [
            (f"{self.notation.name(name)}: " if name else "", value) for name, value in zip(names, values)
        ]

    def value(self, node: ast.Expr, column: int, indent: int, tail: int = 0) -> str:
        """What a test gives: on one line, or a record's fields and a list's records on lines of their own."""
        if column + len(self.notation.expr(node)) + tail <= WIDTH:
            return self.notation.expr(node)
        inner = indent + 2
        if isinstance(node, ast.RecordValue):
            parts = self._named(node.names, node.values)
            brackets = "{}"
        elif isinstance(node, ast.ListValue) and any(
            isinstance(value, ast.RecordValue) for value in node.values
        ):
            parts = self._named(("",) * len(node.values), node.values)
            brackets = "[]"
        elif isinstance(node, ast.ListValue):
            filled = self.fill(self._named(("",) * len(node.values), node.values), inner, inner, 0)
            return f"[{new_line(inner)}{filled}{new_line(indent)}]"
        else:
            return self.lay(node, EXPRESSION, column, tail)
        lines = [
            prefix + ("" if part is None else self.value(part, inner + len(prefix), inner, 1))
            for prefix, part in parts
        ]
        return (
            brackets[0] + new_line(inner) + f",{new_line(inner)}".join(lines) + new_line(indent) + brackets[1]
        )


def _chain(node: ast.Binary) -> tuple[ast.Expr, list[tuple[str, ast.Expr]]]:
    """Operators of one level in a row: the first operand, then each operator with the operand after it."""
    level, left, _ = LEVELS[node.op]
    rest: list[tuple[str, ast.Expr]] = []
    if level == IMPLICATION:
        first: ast.Expr = node.left
        while True:
            following = node.right
            if (
                not isinstance(following, ast.Binary)
                or following.op != node.op
                or ast.is_parenthesised(following)
            ):
                rest.append((node.op, following))
                return first, rest
            rest.append((node.op, following.left))
            node = following
    first = node
    while isinstance(first, ast.Binary) and LEVELS[first.op][0] == level:
        rest.append((first.op, first.right))
        first = first.left
        if left != level or open_ended(first) or ast.is_parenthesised(first):
            break
    return first, rest[::-1]


_HANDLERS: dict[type[ast.Expr], Callable[[Wrapping, Any, int, int], str]] = {
    ast.Binary: Wrapping._binary, ast.Chained: Wrapping._chained, ast.Unary: Wrapping._unary, ast.Temporal: Wrapping._temporal, ast.Until: Wrapping._until,
    ast.Quantified: Wrapping._quantified, ast.Infix: Wrapping._infix, ast.IfElse: Wrapping._if_else, ast.Case: Wrapping._case,
    ast.Within: Wrapping._within, ast.InZone: Wrapping._in_zone, ast.InStretch: Wrapping._in_stretch,
    ast.BetweenStations: Wrapping._between_stations, ast.Attribute: Wrapping._attribute, ast.Call: Wrapping._call,
    ast.Folded: Wrapping._folded, ast.RecordValue: Wrapping._record, ast.ListValue: Wrapping._list,
}  # fmt: skip
