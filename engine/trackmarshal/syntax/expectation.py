"""Sets of grammar terminals as words: what the parser expected."""

from __future__ import annotations

from trackmarshal.syntax.keywords import CLAUSES

_SPOKEN = {
    "NAME": "a name", "NUMBER": "a number", "QUANTITY": "a quantity", "STRING": "a string", "UNIT": "a unit", "ID": "an id",
    "COMPARE": "a comparison", "RPAR": "`)`", "LPAR": "`(`", "LSQB": "`[`", "RSQB": "`]`", "LBRACE": "`{`", "RBRACE": "`}`",
    "COLON": "`:`", "COMMA": "`,`", "EQUAL": "`=`", "VBAR": "`|`", "DOT": "`.`", "RELATION": "`>` or `~`",
    "_FOR_ALL": "`for all`", "_FOR_NEAREST": "`for nearest`", "_EXISTS_NEAREST": "`exists nearest`", "SET": "`set of`", "_FOR": "`for`", "MINUS": "`-`", "SUPERSCRIPT": "`²`",
    "_ARROW": "`->`", "UNTIL": "`until`", "TEMPORAL": "`always`", "STEP": "`next`", "$END": "the end of the declaration",
}  # fmt: skip

_EXPRESSION = {"NAME", "NUMBER", "QUANTITY", "LPAR"}
_FORMULA = {"NOT", "TEMPORAL", "STEP", "WEAK", "_FOR_ALL", "_EXISTS", "_FOR_NEAREST", "_EXISTS_NEAREST"}
_OPERATORS = {
    "PLUS", "MINUS", "TIMES", "DIVIDE", "SUPERSCRIPT", "CIRCUMFLEX", "COMPARE", "IFF", "XOR", "IMPLIES", "OR", "AND", "UNTIL",
    "_IN", "DOT",
}  # fmt: skip
_CLAUSES = {f"_{word.upper()}" for words in CLAUSES.values() for word in words} | {
    "_FOR_ALL",
    "_EXISTS",
    "_FOR_NEAREST",
    "_EXISTS_NEAREST",
}
_KINDS = {"_POINT", "_POSE", "_MOVING", "_BODY", "_VEHICLE", "_TRAJECTORY", "_CORRIDOR", "_POLYLINE", "_BOOL"}


def spoken_kinds(terminals: set[str]) -> str:
    """The words that may stand for a type beside a unit, or the empty string."""
    return (
        ", ".join(sorted(name.lstrip("_").lower() for name in terminals & _KINDS))
        if "UNIT" in terminals
        else ""
    )


def spoken(terminals: set[str]) -> str:
    """A set of grammar terminals as words; the many that start or continue an expression as one."""
    names = set(terminals)
    words: list[str] = []
    if names >= _EXPRESSION:
        words.append("an expression")
        names -= _EXPRESSION | _FORMULA | {"MINUS", "_IF", "_CASE", "√", "_TRUE", "_FALSE", "_IN"}
        names = {name for name in names if not name.startswith("__")}
    elif len(names & _OPERATORS) > 2:
        words.append("an operator")
        names -= _OPERATORS | ({"NAME"} if "COMPARE" in names else set()) | {"LPAR"}
    clauses = names & _CLAUSES
    if len(clauses) > 2:
        names -= clauses
        words.append("a clause")
        clauses = set()
    words += sorted(_SPOKEN.get(name) or f"`{name.lstrip('_').lower()}`" for name in names)
    return _joined(words)


def _joined(words: list[str]) -> str:
    if not words:
        return "something else"
    if len(words) > 7:
        words = [*words[:6], "..."]
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " or " + words[-1]
