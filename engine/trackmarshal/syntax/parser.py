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
from trackmarshal.syntax.errors import BadText, StrayText, TooDeep, UnexpectedEnd, UnexpectedText

if TYPE_CHECKING:
    from lark import Lark

#: The words that start a declaration, in column 1.
KEYWORDS = (
    "module", "use", "reference", "signal", "event", "param", "constrain", "table", "zone", "line", "define",
    "predicate", "assume", "rule", "state", "rulebook", "test",
)  # fmt: skip
_START = re.compile(rf"^(?:{'|'.join(KEYWORDS)})\b", re.MULTILINE)
_BLANK = re.compile(r"(?:[ \t\n]+|--[^\n]*)*")
_UNICODE = re.compile(r"[≤≥≠·²³√∀∃∈∧∨¬→↔−\u0370-\u03FF]")
_ASCII = re.compile(r"<=|>=|!=|\^[23]\b|\b(?:sqrt|and|or|not|implies|iff|exists)\b|\bfor[ \t]+all\b|\bin\b")

#: Deepest nesting of an expression. Every later pass may recurse this far.
MAX_DEPTH = 120


def parse(file: SourceFile) -> tuple[ast.Module, list[Diagnostic]]:
    """Parse a whole file; a declaration with an error is left out of the tree and reported."""
    text, items, found = file.text, [], []
    starts = [match.start() for match in _START.finditer(text)]
    head = _BLANK.match(text, 0)
    first = head.end() if head else 0
    if first < (starts[0] if starts else len(text)):
        word = re.match(r"\S+", text[first:])
        shown = word.group() if word else text[first]
        found.append(StrayText(Span(file, first, first + len(shown)), shown, close_matches(shown, KEYWORDS)))
    for start, end in zip(starts, [*starts[1:], len(text)]):
        item = parse_item(file, start, end, found)
        if item is not None:
            items.append(item)
    return ast.Module(tuple(items), _is_unicode(text), Span(file, 0, len(text))), found


def parse_item(file: SourceFile, start: int, end: int, found: list[Diagnostic]) -> ast.Item | None:
    """Parse the declaration between two offsets; errors go into `found`."""
    from lark.exceptions import UnexpectedInput

    from trackmarshal.syntax.build import Builder, DeeperThanLimit

    try:
        tree = _parser().parse(file.text[start:end])
        item = Builder(file, start, MAX_DEPTH).build(tree)
    except UnexpectedInput as error:
        found.append(_explained(error, file, start, end))
        return None
    except DeeperThanLimit as error:
        found.append(TooDeep(Span(file, error.start, error.end), MAX_DEPTH))
        return None
    if not isinstance(item, ast.Item):
        raise AssertionError(f"the grammar built a {type(item).__name__}")
    return item


@cache
def _parser() -> Lark:
    return make_parser(_cache_file())


def grammar() -> str:
    """The grammar's text with the closed list of units put in."""
    from trackmarshal.units import UNIT_PATTERN

    return (Path(__file__).with_name("spec.lark")).read_text("utf-8").replace("@U", UNIT_PATTERN)


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


def _is_unicode(text: str) -> bool:
    """Whether mathematical signs come first in the file; the formatter keeps one style throughout."""
    code = re.sub(r'"(?:[^"\\\n]|\\.)*"|--[^\n]*', "", text)
    sign, word = _UNICODE.search(code), _ASCII.search(code)
    return sign is not None and (word is None or sign.start() < word.start())


def _explained(error: Exception, file: SourceFile, base: int, end: int) -> Diagnostic:
    """What Lark says, in words for rule authors."""
    from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedToken

    if isinstance(error, UnexpectedToken) and error.token.type != "$END":
        start = base + (error.token.start_pos or 0)
        span = Span(file, start, start + len(error.token))
        expected = _spoken(error.accepts or error.expected)
        hint = ""
        if span.column == 1:
            hint = close_matches(str(error.token), KEYWORDS)
        elif error.token.type == "NAME":
            hint = close_matches(str(error.token), _words(error.accepts or error.expected))
        return UnexpectedText(span, f"`{error.token}`", expected, hint)
    if isinstance(error, UnexpectedCharacters):
        start = base + error.pos_in_stream
        if file.text[start] == '"':
            return BadText(Span(file, start, start + 1))
        return UnexpectedText(Span(file, start, start + 1), f"`{file.text[start]}`", _spoken(error.allowed or set()), _known_slips(file, start))
    if isinstance(error, (UnexpectedToken, UnexpectedEOF)):
        stop = base + len(file.text[base:end].rstrip())
        return UnexpectedEnd(Span(file, max(base, stop - 1), stop), _spoken(getattr(error, "accepts", None) or error.expected))
    raise error


def _known_slips(file: SourceFile, start: int) -> str:
    rest = file.text[start : start + 2]
    if rest.startswith("="):
        return "write `==` to compare"
    if rest in ("&&", "||"):
        return "write `and`, `or`"
    if rest.startswith("!"):
        return "write `not`"
    if rest.startswith(("#", "//")):
        return "a comment starts with `--`"
    return ""


_SPOKEN = {
    "NAME": "a name", "NUMBER": "a number", "QUANTITY": "a quantity", "STRING": "a string", "UNIT": "a unit", "ID": "an id",
    "COMPARE": "a comparison", "RPAR": "`)`", "LPAR": "`(`", "LSQB": "`[`", "RSQB": "`]`", "LBRACE": "`{`", "RBRACE": "`}`",
    "COLON": "`:`", "COMMA": "`,`", "EQUAL": "`=`", "VBAR": "`|`", "DOT": "`.`", "RELATION": "`>` or `~`",
    "__FOR_ALL": "`for all`", "_FOR_ALL": "`for all`", "_EXISTS": "`exists`", "_IN": "`in`", "SET": "`set of`",
    "PLUS": "an operator", "MINUS": "an operator", "TIMES": "an operator", "DIVIDE": "an operator",
    "SUPERSCRIPT": "an operator", "CIRCUMFLEX": "an operator",
    "AND": "`and`", "OR": "`or`", "IMPLIES": "`implies`", "IFF": "`iff`", "XOR": "`xor`", "NOT": "`not`",
    "UNTIL": "`until` or `since`", "TEMPORAL": "`always`, `eventually`, ...", "STEP": "`next` or `previous`",
    "$END": "the end of the declaration", "√": "`√`",
}  # fmt: skip
_OPERATORS = {"PLUS", "MINUS", "TIMES", "DIVIDE", "SUPERSCRIPT", "CIRCUMFLEX", "COMPARE", "IFF", "XOR", "IMPLIES", "OR", "AND",
              "UNTIL", "_IN", "DOT"}  # fmt: skip


def _words(terminals: set[str]) -> list[str]:
    return [name.lower() for name in terminals if name not in _SPOKEN]


def _spoken(terminals: set[str]) -> str:
    """A set of grammar terminals as words; the many operators of an expression as one."""
    if {"NUMBER", "QUANTITY", "NAME", "LPAR"} <= terminals:
        return "an expression"
    names = set(terminals)
    if len(names & _OPERATORS) > 3:
        names = (names - _OPERATORS - {"NAME"}) | {"PLUS"}
    spoken = sorted({_SPOKEN.get(name, f"`{name.lower().lstrip('_')}`") for name in names})
    if len(spoken) > 6:
        spoken = [*spoken[:6], "..."]
    return ", ".join(spoken[:-1]) + (" or " if len(spoken) > 1 else "") + spoken[-1] if spoken else "something else"
