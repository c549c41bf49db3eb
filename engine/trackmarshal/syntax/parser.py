"""Text to syntax tree, one declaration at a time, reporting the errors of all of them."""

from __future__ import annotations

import re

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.comments import comments_of
from trackmarshal.syntax.errors import StrayText, UnexpectedText
from trackmarshal.syntax.keywords import DECLARATIONS, RESERVED
from trackmarshal.syntax.names import GREEK

# Where a declaration starts: its keyword in column 1, or what looks like one with a misspelt keyword.
_START = re.compile(
    rf"^(?:(?P<keyword>{'|'.join(DECLARATIONS)})\b"
    rf'|(?!(?:{"|".join(sorted(RESERVED))})\b)(?P<word>[A-Za-z_][A-Za-z0-9_]*)[ \t]+["A-Za-z_])',
    re.MULTILINE,
)
# A comment without a blank behind a number, a name or a bracket, and before one. It begins with what is looked for, so that a text without it is
# passed over at once, and not tried at every letter.
_MINUSES = re.compile(r"--(?<=[\w)\]}%²³]--)(?=[\w.(])")
_BLANK = re.compile(r"(?:[ \t\n]+|--[^\n]*)*")

# The signs and the words that tell the two styles of writing apart; each has a counterpart in the other style. Most files have letters alone,
# so nobody waits for these patterns.
_NOT_CODE = r'(?m)"(?:[^"\\\n]|\\.)*"|--[^\n]*|^(?:module|use)\b[^\n]*|\b[A-Z][A-Za-z0-9]*-[A-Za-z0-9-]+'
_LETTER = f"[A-Za-z0-9{''.join(GREEK)}]"
_SIGN = rf"[≤≥≠·²³√∀∃∈∧∨¬→↔]|(?<!{_LETTER})[{''.join(GREEK)}](?!{_LETTER})"
_WORD = (
    r"<=|>=|!=|\^[23](?![\w.]|[ \t]+[A-Za-z1%])|\b(?:and|or|not|implies|iff|exists)\b|\bfor[ \t]+all\b|\bin\b"
)

#: Deepest nesting of an expression. Every later pass may recurse this far.
MAX_DEPTH = 120


def parse(file: SourceFile) -> tuple[ast.Module, list[Diagnostic]]:
    """Parse a whole file; a declaration with an error is left out of the tree and reported."""
    text = file.text
    items: list[ast.Item] = []
    found: list[Diagnostic] = []
    starts = list(_START.finditer(text))
    head = _BLANK.match(text)
    first = head.end() if head else 0
    if first < (starts[0].start() if starts else len(text)):
        found.append(_stray(file, first))
    stray = False
    for match, end in zip(starts, [*(m.start() for m in starts[1:]), len(text)]):
        if match["keyword"] is None:
            hint = close_matches(match["word"], DECLARATIONS)
            if hint or not stray:  # of a pasted paragraph, one line is reported
                found.append(_stray(file, match.start()))
            stray = True
            continue
        stray = False
        item = parse_item(file, match.start(), end, found)
        if item is not None:
            items.append(item)
    found += _two_minuses(file)
    return ast.Module(tuple(items), is_unicode(text), Span(file, 0, len(text))), found


def parse_item(file: SourceFile, start: int, end: int, found: list[Diagnostic]) -> ast.Item | None:
    """Parse the declaration between two offsets; errors go into `found`."""
    from trackmarshal.syntax import lalr
    from trackmarshal.syntax.build import Builder, Refused

    text = file.text[start:end]
    try:
        try:
            item = lalr.parse(text, Builder(file, start, MAX_DEPTH), MAX_DEPTH)
        except Refused as refused:
            lalr.parse(text, None, MAX_DEPTH)  # what does not even parse is reported as that
            found.append(refused.diagnostic)
            return None
    except lalr.Unexpected as error:
        from trackmarshal.syntax.mistakes import explained

        found.append(explained(error, file, start, end))
        return None
    if not isinstance(item, ast.Item):
        raise AssertionError(f"the grammar built a {type(item).__name__}")
    return item


def _two_minuses(file: SourceFile) -> list[Diagnostic]:
    """Comments that read as two minus signs: of `a--1 m`, what stands behind `a` would be lost without a word."""
    if _MINUSES.search(file.text) is None:  # mostly
        return []
    starts = [comment.start for comment in comments_of(file.text)]
    spans = [Span(file, start, start + 2) for start in starts if _MINUSES.match(file.text, start)]
    hint = "two minus signs begin a comment: put the second one in parentheses, as in `a - (-1 m)`, or a blank before the comment"
    return [UnexpectedText(span, "`--`", "a blank before a comment", hint) for span in spans]


def _stray(file: SourceFile, start: int) -> StrayText:
    # With dozens of patterns, for which nobody else waits.
    from trackmarshal.syntax.slips import FOREIGN_DECLARATIONS

    match = re.compile(r"[A-Za-z_][A-Za-z0-9_]*|[^\s\w]+|\S").match(file.text, start)
    word = match.group() if match else file.text[start]
    span = Span(file, start, start + len(word))
    column_1 = "a declaration starts with its keyword in column 1"
    if word in DECLARATIONS:
        if span.column == 1:
            return StrayText(span, f"`{file.text[start:].split(maxsplit=1)[0]}`", column_1)
        return StrayText(span, f"an indented `{word}`", column_1, "remove the blanks before it")
    hint = (
        "a comment starts with `--`"
        if word.startswith(("#", "//", "/*"))
        else FOREIGN_DECLARATIONS.get(word) or close_matches(word, DECLARATIONS)
    )
    return StrayText(span, f"`{word}`", column_1, hint or f"the keywords are {', '.join(DECLARATIONS)}")


def is_unicode(text: str) -> bool:
    """Whether mathematical signs come first in the file; the formatter keeps one style throughout."""
    if text.isascii():
        return False
    code = re.sub(_NOT_CODE, "", text)
    sign, word = re.search(_SIGN, code), re.search(_WORD, code)
    return sign is not None and (word is None or sign.start() < word.start())
