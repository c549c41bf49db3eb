"""What the parser stumbles over, in words for rule authors. Read only when there is an error."""

from __future__ import annotations

import re

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax.build import CLAUSE_WORDS
from trackmarshal.syntax.errors import (
    BadText,
    Unclosed,
    UnexpectedEnd,
    UnexpectedText,
    UnknownClause,
    UnknownUnit,
)
from trackmarshal.syntax.expectation import spoken, spoken_kinds
from trackmarshal.syntax.foreign_units import unit_hint
from trackmarshal.syntax.keywords import CLAUSES, DECLARATIONS, RESERVED
from trackmarshal.syntax.lalr import Unexpected, accepted
from trackmarshal.syntax.names import GREEK
from trackmarshal.syntax.slips import FOREIGN_WORDS, hint_for, open_brackets
from trackmarshal.units import UNITS

_NOT_CODE = re.compile(r'"(?:[^"\\\n]|\\.)*"|--[^\n]*')
_WORD = re.compile(rf"[A-Za-z_{''.join(GREEK)}][A-Za-z0-9_{''.join(GREEK)}]*")
_UNIT_TEXT = re.compile(r"[^\W\d_]+(?:\^-?[0-9]+|[²³])?(?:[/*·][^\W\d_]+(?:\^-?[0-9]+|[²³])?)*")
_AFTER_NUMBER = re.compile(
    r"(?<![\w.])(?<![A-Za-z0-9]-)(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?[ \t]*(?=[^\W\d_])"
)
_NUMBER_BEFORE = re.compile(r"((?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)[ \t]*\Z")
#: A name where it is declared, by an item or a clause.
_DECLARED = r"^(?:param|define|table|signal|event)[ \t]+{0}\b|^[ \t]+let[ \t]+{0}[ \t]*="
_UNIT_MORE = re.compile(r"[\^²³*][^\s,()\[\]{}|]*")
_ONE_UNIT = re.compile(r"[^\W\d_]+")


def explained(error: Unexpected, file: SourceFile, base: int, end: int) -> Diagnostic:
    """The diagnostic for what the parser met between two offsets of a file."""
    start, found = base + error.start, error.found
    if found == "":
        start = end
    elif found is None:  # no terminal at all: the word or the character there
        word = _WORD.match(file.text, start)
        found = word.group() if word else file.text[start]
    return Mistake(file, base, start, found).diagnostic()


class Mistake:
    """A text that does not parse: `found` at offset `start`, or the end of a declaration where it is empty."""

    def __init__(self, file: SourceFile, base: int, start: int, found: str) -> None:
        self.file = file
        self.base = base
        self.start = start
        self.found = found
        #: The declaration up to the error, without its strings and comments, which become blanks.
        self.before = _NOT_CODE.sub(lambda m: " " * len(m.group()), file.text[base:start])
        self.expected = accepted(file.text[base:start])

    def diagnostic(self) -> Diagnostic:
        """What is wrong, the most telling explanation first."""
        special = self._string() or self._unit() or self._clause() or self._bracket()
        if special is not None:
            return special
        hint = hint_for(self.file.text, self.start, self.found, self.before, self.expected)
        if not self.found:
            return UnexpectedEnd(self._last_code(), spoken(self.expected), hint)
        shown = (
            self.found
            if self.found.isprintable() and self.found != "\u00a0"
            else f"U+{ord(self.found[0]):04X}"
        )
        span = Span(self.file, self.start, self.start + len(self.found))
        return UnexpectedText(span, f"`{shown}`", spoken(self.expected), hint or self._misspelt(span))

    def _last_code(self) -> Span:
        """The last word or sign before the error."""
        code = re.search(r"(\w+|\S)\s*\Z", _comments_blanked(self.file.text[self.base : self.start]))
        if code is None:
            return Span(self.file, self.base, self.base + 1)
        return Span(self.file, self.base + code.start(1), self.base + code.end(1))

    def _string(self) -> Diagnostic | None:
        if not self.found.startswith('"') or len(self.found) > 1:
            return None
        line = self.file.text[self.start : self._line_end()]
        closed = re.match(r'"(?:[^"\\]|\\.)*"', line)
        if closed is None:
            span = Span(self.file, self.start, self.start + len(line.rstrip()))
            return BadText(
                span, "this string does not end on its line", 'no closing `"`', 'close it with `"`'
            )
        bad = re.search(r'\\[^"\\]', re.sub(r'\\["\\]', "xx", closed.group()))
        if bad is None:
            return None
        at = self.start + bad.start()
        hint = 'inside a string, write `\\\\` for a backslash and `\\"` for a quote'
        return BadText(
            Span(self.file, at, at + 2), f"unknown escape `{bad.group()}` in a string", "not an escape", hint
        )

    def _unit(self) -> Diagnostic | None:
        """A number followed by a word that is no unit, or no unit where a declaration wants one."""
        line_start = self.file.text.rfind("\n", 0, self.start) + 1
        if self.expected == {"UNIT"} or {"UNIT", "_POLYLINE"} <= self.expected:
            match = _UNIT_TEXT.match(self.file.text, self.start)
            return self._unit_in(match, bare=False) if match else None
        for number in _AFTER_NUMBER.finditer(self.file.text, line_start, self._line_end()):
            match = _UNIT_TEXT.match(self.file.text, number.end())
            if (
                match
                and max(number.start(), self.base) <= self.start <= match.end()
                and self._is_code(number.start())
            ):
                return self._unit_in(match, bare=True)
        # A word after a number may be taken for a predicate, and the error is noticed one word later.
        tail = re.search(r"(?<![\w.])[0-9.]+[ \t]*([^\W\d_]\w*)\s*\Z", self.before)
        if tail and self.before and tail[1] not in RESERVED:
            return self._unit_in(_UNIT_TEXT.match(self.file.text, self.base + tail.start(1)), bare=True)
        tail = re.search(r"(?::|->)[ \t]*([^\W\d_][^\s,)}]*)\Z", self.before + self.found)
        if tail and "/" in tail[1]:
            return self._unit_in(_UNIT_TEXT.match(self.file.text, self.base + tail.start(1)), bare=False)
        return None

    def _unit_in(self, match: re.Match[str] | None, bare: bool) -> Diagnostic | None:
        if match is None:
            return None
        for part in _ONE_UNIT.finditer(match.group()):
            name = part.group()
            if name in RESERVED and bare:
                return None
            if bare and name not in UNITS and part.start() == 0:
                factor = self._factor(match.start())
                if factor is not None:
                    return factor
            if name not in UNITS:
                at = match.start() + part.start()
                kinds = spoken_kinds(self.expected)
                what = "unit or kind" if kinds else "unit"
                hint = unit_hint(name, match.group(), kinds)
                return UnknownUnit(Span(self.file, at, at + len(name)), what, name, hint)
        more = _UNIT_MORE.match(self.file.text, match.end())
        if more and bare:
            whole = match.group() + more.group()
            span = Span(self.file, match.start(), match.start() + len(whole))
            return UnknownUnit(
                span, "unit", whole, "an exponent is written once, as in `m/s^2`, and is a whole number"
            )
        return None

    def _factor(self, start: int) -> Diagnostic | None:
        """A name after a number, which a product was meant by: one that no unit looks like, or that the file declares."""
        word, number = _WORD.match(self.file.text, start), _NUMBER_BEFORE.search(self.file.text, 0, start)
        if word is None or number is None:
            return None
        name = word.group()
        if "_" not in name and not re.search(_DECLARED.format(re.escape(name)), self.file.text, re.MULTILINE):
            return None
        hint = f"write `{number[1]} * {name}` to multiply"
        return UnexpectedText(Span(self.file, *word.span()), f"`{name}`", "an operator", hint)

    def _clause(self) -> Diagnostic | None:
        """A misspelt clause keyword, which the parser may have taken for a predicate."""
        line_start = self.file.text.rfind("\n", 0, self.start) + 1
        word = re.compile(r"[ \t]*([^\W\d]\w*)").match(self.file.text, line_start)
        first_line = line_start <= self.base
        if word is None or first_line or word.start(1) > self.start or word[1] in RESERVED:
            return None
        span = Span(self.file, *word.span(1))
        keyword = self.file.text[self.base :].split(maxsplit=1)[0]
        hint = FOREIGN_WORDS.get(word[1], "") or close_matches(word[1], CLAUSES.get(keyword, ()), 0.7)
        if (
            not hint
            and word.start(1) == self.start
            and keyword in CLAUSES
            and spoken(self.expected).startswith("a clause")
        ):
            words = ", ".join("for all" if word == "for" else word for word in CLAUSES[keyword])
            hint = f"the clauses of `{keyword}` are {words}"
        return UnknownClause(span, word[1], hint) if hint and span.column > 1 else None

    def _bracket(self) -> Diagnostic | None:
        """An opening bracket whose closing one is missing where a clause or the declaration ends."""
        if (
            self.found
            and self.found not in CLAUSE_WORDS
            and self.found not in DECLARATIONS
            and self.found not in ")]}"
        ):
            return None
        stack = open_brackets(self.before)
        if not stack:
            return None
        bracket, offset = stack[-1]
        closing = {"(": ")", "[": "]", "{": "}"}[bracket]
        if self.found == closing or (self.expected and not self.expected & _CLOSING):
            return None
        opened = Span(self.file, self.base + offset, self.base + offset + 1)
        if not self.found:
            return Unclosed(opened, bracket, f"`{closing}`", "after this", self._last_code())
        here = Span(self.file, self.start, self.start + len(self.found))
        return Unclosed(opened, bracket, f"`{closing}`", "before this", here)

    def _misspelt(self, span: Span) -> str:
        if span.column == 1:
            return close_matches(self.found, DECLARATIONS)
        if self.found in RESERVED:
            return ""
        words = [
            name.lstrip("_").lower() for name in self.expected if name.startswith("_") and name[1:].isalpha()
        ]
        return close_matches(self.found, words) if self.found.isidentifier() else ""

    def _is_code(self, offset: int) -> bool:
        return offset >= self.start or self.before[offset - self.base] == self.file.text[offset]

    def _line_end(self) -> int:
        stop = self.file.text.find("\n", self.start)
        return len(self.file.text) if stop < 0 else stop


_CLOSING = {"RPAR", "RSQB", "RBRACE"}


def _comments_blanked(text: str) -> str:
    return _NOT_CODE.sub(lambda m: " " * len(m.group()) if m.group().startswith("--") else m.group(), text)
