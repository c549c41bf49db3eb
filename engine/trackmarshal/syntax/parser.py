"""Text to syntax tree, one declaration at a time, reporting the errors of all of them."""

from __future__ import annotations

import os
import re
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.errors import StrayText
from trackmarshal.syntax.keywords import DECLARATIONS, RESERVED
from trackmarshal.syntax.names import GREEK

if TYPE_CHECKING:
    from lark import Lark

# Where a declaration starts: its keyword in column 1, or what looks like one with a misspelt keyword.
_START = re.compile(
    rf"^(?:(?P<keyword>{'|'.join(DECLARATIONS)})\b"
    rf'|(?!(?:{"|".join(sorted(RESERVED))})\b)(?P<word>[A-Za-z_][A-Za-z0-9_]*)[ \t]+["A-Za-z_])',
    re.MULTILINE,
)
_BLANK = re.compile(r"(?:[ \t\n]+|--[^\n]*)*")

# The signs and the words that tell the two styles of writing apart; each has a counterpart in the other style.
_NOT_CODE = re.compile(
    r'"(?:[^"\\\n]|\\.)*"|--[^\n]*|^(?:module|use)\b[^\n]*|\b[A-Z][A-Za-z0-9]*-[A-Za-z0-9-]+', re.MULTILINE
)
_LETTER = f"[A-Za-z0-9{''.join(GREEK)}]"
_SIGN = re.compile(rf"[≤≥≠·²³√∀∃∈∧∨¬→↔]|(?<!{_LETTER})[{''.join(GREEK)}](?!{_LETTER})")
_WORD = re.compile(
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
    return ast.Module(tuple(items), is_unicode(text), Span(file, 0, len(text))), found


def parse_item(file: SourceFile, start: int, end: int, found: list[Diagnostic]) -> ast.Item | None:
    """Parse the declaration between two offsets; errors go into `found`."""
    from lark.exceptions import UnexpectedInput

    from trackmarshal.syntax.build import Builder, Refused

    try:
        tree = parser().parse(file.text[start:end])
        item = Builder(file, start, MAX_DEPTH).build(tree)
    except UnexpectedInput as error:
        from trackmarshal.syntax.mistakes import explained

        found.append(explained(error, file, start, end))
        return None
    except Refused as error:
        found.append(error.diagnostic)
        return None
    if not isinstance(item, ast.Item):
        raise AssertionError(f"the grammar built a {type(item).__name__}")
    return item


def _stray(file: SourceFile, start: int) -> StrayText:
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
        else close_matches(word, DECLARATIONS)
    )
    return StrayText(span, f"`{word}`", column_1, hint or f"the keywords are {', '.join(DECLARATIONS)}")


@cache
def parser() -> Lark:
    """The parser of one declaration, from the user's cache where there is one."""
    return make_parser(_cache_file())


def grammar() -> str:
    """The grammar's text as lark reads it: words end at word ends, units and reserved words are closed lists."""
    from trackmarshal.units import UNIT_PATTERN

    text = (Path(__file__).with_name("spec.lark")).read_text("utf-8")
    words = sorted(set(re.findall(r'"([a-z]+)"', re.sub(r"//[^\n]*", "", text))))
    text = re.sub(r'"([a-z]+)"', lambda match: f"_{match[1].upper()}", text)
    text += "".join(f"_{word.upper()}.1: /{word}@B/\n" for word in words)
    letters, reserved = "".join(GREEK), "|".join(sorted(RESERVED))
    # Spelled out: \w and \b take ² for a letter.
    text = text.replace("@B", "(?![A-Za-z0-9_@G])").replace("@R", reserved)
    return text.replace("@U", UNIT_PATTERN).replace("@G", letters)


def make_parser(cache_file: str | None = None, strict: bool = False) -> Lark:
    """The LALR(1) parser; `strict` refuses ambiguities of the grammar (slow, for the tests)."""
    from lark import Lark

    return Lark(
        grammar(),
        parser="lalr",
        lexer="contextual",
        start="item",
        propagate_positions=True,
        maybe_placeholders=True,
        cache=cache_file or False,
        strict=strict,
    )


def _cache_file() -> str | None:
    """Where the built tables are kept; None where no folder can be written."""
    from trackmarshal.cache import cache_folder

    folder = cache_folder()
    if folder is None:
        return None
    import hashlib

    import lark

    key = hashlib.sha256((grammar() + lark.__version__).encode()).hexdigest()[:16]
    target = folder / f"grammar-{key}.lark"
    if not target.exists():
        # Lark writes in place: build in a private file first, so that a parallel reader never sees half a table.
        descriptor, name = tempfile.mkstemp(dir=folder, suffix=".tmp")
        os.close(descriptor)
        os.unlink(name)
        make_parser(name)
        os.replace(name, target)
    return str(target)


def is_unicode(text: str) -> bool:
    """Whether mathematical signs come first in the file; the formatter keeps one style throughout."""
    code = _NOT_CODE.sub("", text)
    sign, word = _SIGN.search(code), _WORD.search(code)
    return sign is not None and (word is None or sign.start() < word.start())
