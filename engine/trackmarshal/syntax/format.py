"""The one layout of spec files: syntax tree and comments to text."""

from __future__ import annotations

from collections.abc import Sequence

from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.node import Node
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.comments import Comment, after_blank, code_before, comments_of
from trackmarshal.syntax.layout import Laid, Layout, Piece
from trackmarshal.syntax.notation import Notation
from trackmarshal.syntax.parser import parse

#: Declarations that may follow each other without a blank line, if the author wants that.
_GROUPS: dict[type[ast.Item], str] = {
    ast.ModuleName: "head", ast.Use: "head", ast.Reference: "head", ast.Enum: "inputs", ast.Signal: "inputs", ast.Event: "inputs",
    ast.Param: "numbers", ast.ParamRecord: "numbers", ast.Constrain: "numbers", ast.Scale: "numbers", ast.Table: "tables", ast.Place: "places", ast.Stretch: "places", ast.Shape: "definitions", ast.Define: "definitions",
    ast.Test: "tests",
}  # fmt: skip


def format_text(file: SourceFile) -> str:
    """The file in the one layout; raises Diagnostics if it does not parse.

    What comes out is read back: a text that would mean something else, or lose a comment or parentheses, is never returned.
    """
    module, found = parse(file)
    if found:
        raise Diagnostics(found)
    text = format_module(module, file)
    if text != file.text:
        again, broken = parse(SourceFile(file.path, text))
        kept = [c.text for c in comments_of(text)] == [c.text for c in comments_of(file.text)]
        if broken or again.items != module.items or not kept or not _parentheses_kept(module, again):
            raise AssertionError(f"{file.path}: the formatter changed the meaning, and its text is not used")
    return text


def _parentheses_kept(before: ast.Module, after: ast.Module) -> bool:
    """Whether all parentheses of one of two equal trees are in the other one too."""
    return all(
        ast.is_parenthesised(new) or not ast.is_parenthesised(old)
        for old, new in zip(before.walk(), after.walk())
        if isinstance(old, ast.Expr) and isinstance(new, ast.Expr)
    )


def format_module(module: ast.Module, file: SourceFile) -> str:
    """A tree in the one layout, with the comments of the file that it was read from."""
    layout = Layout(Notation(module.unicode))
    slots, rest = _distributed(module.items, file)
    lines: list[str] = []
    for run in _runs(slots):
        columns = layout.columns([slot.item for slot in run])
        for slot in run:
            lines += _slot_lines(slot, layout.lay(slot.item, columns), file, bool(lines))
    for number, comment in enumerate(rest):
        if comment.after_blank and (number or lines):
            lines.append("")
        lines.append(comment.text)
    return "".join(f"{line}\n" for line in lines)


class _Slot(Node):
    """A declaration with what belongs to it: comments above, within, behind and (indented) below, a blank line above."""

    item: ast.Item
    blank: bool
    above: tuple[Comment, ...]
    blank_below_above: bool
    within: tuple[Comment, ...]
    behind: Comment | None
    below: tuple[Comment, ...]


def _distributed(items: Sequence[ast.Item], file: SourceFile) -> tuple[list[_Slot], list[Comment]]:
    """Each declaration with its comments, and the comments after the last one."""
    waiting = comments_of(file.text)[::-1]
    slots: list[_Slot] = []
    for number, item in enumerate(items):
        if _span(item).file is not file:
            slots.append(_Slot(item, not _grouped(items, number), (), False, (), None, ()))
            continue
        start, end = _span(item).start, _span(item).end
        above = _taken(waiting, start)
        within = _taken(waiting, end)
        stop = _span(items[number + 1]).start if number + 1 < len(items) else len(file.text)
        behind = waiting.pop() if waiting and waiting[-1].start < stop and not waiting[-1].own_line else None
        below = []
        while waiting and waiting[-1].start < stop and not waiting[-1].outside:
            below.append(waiting.pop())
        separate = after_blank(file.text, start)
        blank = (above[0].after_blank if above else separate) or not _grouped(items, number)
        slots.append(
            _Slot(item, blank, tuple(above), bool(above) and separate, tuple(within), behind, tuple(below))
        )
    return slots, waiting[::-1]


def _taken(waiting: list[Comment], stop: int) -> list[Comment]:
    taken = []
    while waiting and waiting[-1].start < stop:
        taken.append(waiting.pop())
    return taken


def _grouped(items: Sequence[ast.Item], number: int) -> bool:
    if number == 0:
        return True
    group = _GROUPS.get(type(items[number]))
    return group is not None and group == _GROUPS.get(type(items[number - 1]))


def _runs(slots: Sequence[_Slot]) -> list[list[_Slot]]:
    """Declarations of one kind with no blank line between, which share columns."""
    runs: list[list[_Slot]] = []
    for slot in slots:
        if (
            runs
            and not slot.blank
            and not slot.blank_below_above
            and type(runs[-1][-1].item) is type(slot.item)
        ):
            runs[-1].append(slot)
        else:
            runs.append([slot])
    return runs


def _slot_lines(slot: _Slot, laid: Laid, file: SourceFile, follows: bool) -> list[str]:
    lines = [""] if slot.blank and follows else []
    for number, comment in enumerate(slot.above):
        if number and comment.after_blank:
            lines.append("")
        lines.append(comment.text)
    if slot.blank_below_above:
        lines.append("")
    lines += _woven(slot, laid, file)
    return lines + [f"  {comment.text}" for comment in slot.below]


def _woven(slot: _Slot, laid: Laid, file: SourceFile) -> list[str]:
    """The lines of a declaration with the comments that stand within and behind it."""
    pieces = _bounded(laid.pieces, slot, file) if slot.within else laid.pieces
    before: list[list[Comment]] = [[] for _ in pieces]
    behind: list[Comment | None] = [None for _ in pieces]
    for comment in slot.within:
        current = max(i for i, piece in enumerate(pieces) if piece.start <= comment.start)
        if comment.start < pieces[current].end:
            before[current].append(comment)
        elif (
            not comment.own_line
            and behind[current] is None
            and current + 1 < len(pieces)
            and not before[current + 1]
        ):
            behind[current] = comment
        else:
            before[min(current + 1, len(pieces) - 1)].append(comment)
    behind[-1] = slot.behind
    lines = [comment.text for comment in before[0]]
    if laid.compact is not None and not any(before[1:]) and not any(behind[:-1]):
        return [*lines, *_with(laid.compact, slot.behind).split("\n")]
    for number, piece in enumerate(pieces):
        if number:
            lines += [f"  {comment.text}" for comment in before[number]]
        lines += (" " * piece.indent + _with(piece.text, behind[number])).split("\n")
    return lines


def _with(text: str, comment: Comment | None) -> str:
    return text if comment is None else f"{text}  {comment.text}"


def _bounded(pieces: list[Piece], slot: _Slot, file: SourceFile) -> list[Piece]:
    """The pieces with the place of the header filled in from the source."""
    span = _span(slot.item)
    comments = list(slot.within)
    bounded = [*pieces]
    if len(pieces) == 1:
        return [pieces[0]._replace(start=span.start, end=span.end)]
    end = pieces[1].start
    while True:
        end = code_before(file.text, end, comments)
        if file.text[end - 1] not in "|(":
            break
        end -= 1
    bounded[0] = pieces[0]._replace(start=span.start, end=end)
    return bounded


def _span(item: ast.Item) -> Span:
    span: Span = item.__dict__["span"]
    return span
