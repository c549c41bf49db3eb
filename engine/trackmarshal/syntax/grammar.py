"""The grammar's text, and lark's parser of it: what the tables are made from, and what they are held against."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.syntax.keywords import RESERVED
from trackmarshal.syntax.names import GREEK
from trackmarshal.units import UNIT_PATTERN

if TYPE_CHECKING:
    from lark import Lark

#: What a declaration is, in spec.lark.
START = "item"

#: Letters and digits of names and words, Greek ones among them. Spelled out: \w and \b take ² for a letter.
WORD_CHARACTERS = f"A-Za-z0-9_{''.join(GREEK)}"
#: After this, a word has ended.
WORD_END = f"(?![{WORD_CHARACTERS}])"


def grammar() -> str:
    """The grammar's text as lark reads it: words end at word ends, units and reserved words are closed lists."""
    text = (Path(__file__).with_name("spec.lark")).read_text("utf-8")
    words = sorted(set(re.findall(r'"([a-z]+)"', re.sub(r"//[^\n]*", "", text))))
    text = re.sub(r'"([a-z]+)"', lambda match: f"_{match[1].upper()}", text)
    text += "".join(f"_{word.upper()}.1: /{word}@B/\n" for word in words)
    text = text.replace("@B", WORD_END).replace("@R", "|".join(sorted(RESERVED)))
    return text.replace("@U", UNIT_PATTERN).replace("@G", "".join(GREEK))


def make_parser(strict: bool = False) -> Lark:
    """Lark's own LALR(1) parser (slow to build); `strict` refuses ambiguities of the grammar."""
    from lark import Lark

    return Lark(
        grammar(),
        parser="lalr",
        lexer="contextual",
        start=START,
        propagate_positions=True,
        maybe_placeholders=True,
        strict=strict,
    )
