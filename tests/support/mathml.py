"""Printed MathML read back: elements to signs in a row, signs to a tree, by the order of operations that everybody learns.

It knows nothing of what printed them: Greek letters by Unicode's own names, units and words as they are seen.
"""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

#: A piece of a formula, by its kind.
Tree = tuple[Any, ...]
Sign = tuple[Any, ...]
_RELATIONS = ("<", "≤", ">", "≥", "=", "≠", "∈", "⊆")


def signs(element: ElementTree.Element) -> list[Sign]:
    """An element as signs in a row; what stands above or below something else is a row of its own."""
    text = (element.text or "").strip().replace("\u2061", "").replace("\xa0", " ").strip()
    parts = list(element)
    match element.tag:
        case "mn":
            return [("number", text)]
        case "mi":
            return [("name", text)]
        case "mtext":
            return [("word", text)]
        case "mo":
            return [("sign", text, element.get("form", ""))] if text else []
        case "mspace":
            return []
        case "msub":
            return [("index", signs(parts[0]), signs(parts[1]))]
        case "msup":
            return [*signs(parts[0]), ("raised", signs(parts[1]))]
        case "mfrac":
            return [("fraction", signs(parts[0]), signs(parts[1]))]
        case "msqrt":
            return [("root", [sign for part in parts for sign in signs(part)])]
        case "munder":
            return [("under", signs(parts[0]), signs(parts[1]))]
        case "mtable" if element.get("class") == "cases":
            return [("cases", [[signs(cell) for cell in row] for row in parts])]
        case "mrow" if element.get("class") == "unit":
            return [("unit", _unit(parts))]
        case "math" | "mrow" | "mtable" | "mtr" | "mtd":
            return [sign for part in parts for sign in signs(part)]
        case _:
            raise ValueError(f"<{element.tag}>")


def _unit(parts: list[ElementTree.Element]) -> str:
    made = ""
    for part in parts:
        made += f"{part[0].text}^{part[1].text}" if part.tag == "msup" else str(part.text)
    return made


def plain(text: str) -> str:
    """A name as it is written in specs: κ is kappa."""
    if len(text) == 1 and not text.isascii():
        kind, _, letter = unicodedata.name(text).rpartition(" ")
        if kind == "GREEK SMALL LETTER":
            return letter.lower()
        if kind == "GREEK CAPITAL LETTER":
            return letter.capitalize()
    return text


@dataclass
class Parser:
    """Signs to a tree. Whatever is left over, or missing, raises."""

    row: list[Sign]
    place: int = 0

    def whole(self) -> Tree:
        made = self.implied()
        assert self.place == len(self.row), self.row[self.place :]
        return made

    def _next(self) -> Sign:
        return self.row[self.place] if self.place < len(self.row) else ("end",)

    def _take(self) -> Sign:
        found = self._next()
        self.place += 1
        return found

    def _is(self, kind: str, *texts: str) -> bool:
        found = self._next()
        return found[0] == kind and (not texts or found[1] in texts)

    def _expect(self, kind: str, text: str) -> None:
        found = self._take()
        assert found[:2] == (kind, text), (found, text, self.row)

    def equation(self) -> tuple[Tree, str, Tree]:
        """`f(a, b) = ..` or `f(a, b) ⇔ ..`."""
        head = self.atom()
        sign = self._take()[1]
        assert sign in ("=", "⇔"), sign
        return head, sign, self.whole()

    def implied(self) -> Tree:
        left = self.either()
        if self._is("sign", "⇒", "⇔", "⊕"):
            return ("joined", self._take()[1], left, self.either())
        return left

    def either(self) -> Tree:
        made = self.both()
        while self._is("sign", "∨"):
            self._take()
            made = ("joined", "∨", made, self.both())
        return made

    def both(self) -> Tree:
        made = self.denied()
        while self._is("sign", "∧"):
            self._take()
            made = ("joined", "∧", made, self.denied())
        return made

    def denied(self) -> Tree:
        if self._is("sign", "¬"):
            self._take()
            return ("not", self.denied())
        if self._is("sign", "∀", "∃"):
            return self.quantified(True)
        if self._is("word", "weak previous", "weak next", "previous", "next"):
            return ("step", self._take()[1], self.denied())
        if self._next()[0] == "index" and self._next()[1][0][0] == "word":
            _, base, index = self._take()
            window = Parser(index)
            window._expect("sign", "[")
            lower = window.sum()
            window._expect("sign", ",")
            return ("window", base[0][1], lower, window.sum(), self.denied())
        return self.compared()

    def quantified(self, body: bool) -> Tree:
        """`∀ p ∈ plan where c: body`; a clause has neither of the last two."""
        sign = self._take()[1]
        ranged = self.ranged()
        if not body:
            return ("quantified", sign, *ranged, None, None)
        where = None
        if self._is("word", "where"):
            self._take()
            where = self.implied()
        self._expect("sign", ":")
        return ("quantified", sign, *ranged, where, self.implied())

    def ranged(self) -> tuple[list[str], str]:
        if self._is("word", "consecutive"):
            self._take()
        names = [plain(self._take()[1])]
        while self._is("sign", ","):
            self._take()
            names.append(plain(self._take()[1]))
        self._expect("sign", "∈")
        return names, self._take()[1]

    def compared(self) -> Tree:
        operands, relations = [self.sum()], []
        while self._is("sign", *_RELATIONS) or (self._next()[0] == "word" and self._next()[1] not in _WORDS):
            relations.append(self._take()[1])
            if relations[-1] == "∈" and self._is("sign", "["):
                self._take()
                lower = self.sum()
                self._expect("sign", ",")
                upper = self.sum()
                self._expect("sign", "]")
                return ("between", operands[0], lower, upper)
            if relations[-1] == "∈" and self._is("word", "zone"):
                self._take()
                return ("in zone", operands[0], self._take()[1])
            operands.append(self.sum())
        return operands[0] if not relations else ("compared", operands, relations)

    def sum(self) -> Tree:
        made = self.product()
        while self._is("sign", "+", "−"):
            made = ("calculated", self._take()[1], made, self.product())
        return made

    def product(self) -> Tree:
        made = self.signed()
        while self._is("sign", "·", "/"):
            made = ("calculated", self._take()[1], made, self.signed())
        return made

    def signed(self) -> Tree:
        if self._is("sign", "−"):
            self._take()
            return ("minus", self.signed())
        made = self.atom()
        while self._next()[0] == "raised":
            made = ("power", made, Parser(self._take()[1]).whole())
        return made

    def atom(self) -> Tree:
        found = self._take()
        match found[0]:
            case "number":
                unit = self._take()[1] if self._next()[0] == "unit" else ""
                return ("quantity", found[1], unit)
            case "name":
                return self._called(("name", plain(found[1])))
            case "index":
                return self._called(_indexed(found[1], found[2]))
            case "fraction":
                return ("calculated", "/", Parser(found[1]).whole(), Parser(found[2]).whole())
            case "root":
                return ("called", "sqrt", [Parser(found[1]).whole()])
            case "under":
                names, domain, where = _range(Parser(found[2]))
                return ("fold", found[1][0][1], names, domain, where, self.product())
            case "cases":
                return ("cases", [(Parser(value).whole(), _condition(when)) for value, when in found[1]])
            case "word" if found[1] == "#":
                return self._gathered()
            case "word" if found[1] == "if":
                return self._branches()
            case "word" if found[1] in ("true", "false"):
                return ("truth", found[1] == "true")
            case "word" if self._is("sign", "("):  # a function whose arguments have lines of their own
                return self._called(("name", found[1]))
            case "sign":
                return self._fenced(found[1])
            case _:
                raise AssertionError((found, self.row))

    def _gathered(self) -> Tree:
        self._expect("sign", "{")
        names, domain, where = _range(self)
        self._expect("sign", "}")
        return ("fold", "#", names, domain, where, None)

    def _called(self, head: Tree) -> Tree:
        if not (self._is("sign", "(") and head[0] == "name"):
            return head
        self._take()
        given = [self._argument()]
        while self._is("sign", ","):
            self._take()
            given.append(self._argument())
        if self._is("word", "for"):  # a sum on several lines: sum(E for o in objects)
            self._take()
            names, domain, where = _range(self)
            self._expect("sign", ")")
            return ("fold", head[1], names, domain, where, given[0])
        self._expect("sign", ")")
        return ("called", head[1], given)

    def _argument(self) -> Tree:
        if self._is("word", "reset:", "last:"):
            return ("named", self._take()[1], self.implied())
        return self.implied()

    def _fenced(self, opening: str) -> Tree:
        if opening == "∑":
            self._expect("sign", "(")
            body = self.sum()
            self._expect("word", "for")
            names, domain, where = _range(self)
            self._expect("sign", ")")
            return ("fold", "∑", names, domain, where, body)
        if opening == "{":
            return self.atom()  # the rows of cases
        inside = self.implied()
        closing = {"(": ")", "|": "|", "⌊": "⌋", "⌈": "⌉"}[opening]
        self._expect("sign", closing)
        match opening:
            case "|":
                return ("called", "abs", [inside])
            case "⌊":
                return ("called", "floor", [inside])
            case "⌈":
                return ("called", "ceil", [inside])
            case _:
                return inside

    def _any(self) -> Tree:
        self._take()
        return ("any",)

    def _branches(self) -> Tree:
        """`if c then a else if d then b else e`, with the first word taken."""
        made: list[tuple[Tree, Tree | None]] = []
        while True:
            condition = self._any() if self._is("word", "there is any") else self.implied()
            self._expect("word", "then")
            made.append((self.implied(), condition))
            word = self._take()[1]
            if word == "else":
                made.append((self.implied(), None))
                return ("cases", made)
            assert word == "else if", word


_WORDS = ("where", "then", "else", "else if", "if", "for", "by")


def _range(parser: Parser) -> tuple[list[str], str, Tree | None]:
    names, domain = parser.ranged()
    where = None
    if parser._is("sign", ":"):
        parser._take()
        where = parser.implied()
    return names, domain, where


def _condition(row: list[Sign]) -> Tree | None:
    if row[0] == ("word", "else"):
        return None
    assert row[0] in (("word", "if"), ("word", "else if")), row
    return ("any",) if row[1:] == [("word", "there is any")] else Parser(row[1:]).whole()


def _indexed(base: list[Sign], index: list[Sign]) -> Tree:
    """A name with an upright index, or what a record has: its index is the record."""
    name = plain(base[0][1])
    words = [sign[1] for sign in index if sign[0] == "word"]
    others = [sign for sign in index if sign[0] != "word" and sign[:2] != ("sign", ",")]
    if words:
        name = "_".join([name, *(part.replace(", ", "_") for part in words)])
    return ("name", name) if not others else ("field", name, Parser(others).whole())


def read(markup: str) -> list[Sign]:
    """The signs of a `math` element."""
    return signs(ElementTree.fromstring(markup))
