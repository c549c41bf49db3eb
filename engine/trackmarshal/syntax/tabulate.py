"""The parser's tables out of the grammar: `python -m trackmarshal.syntax.tabulate` writes them anew.

Lark finds the states, and the order in which each state tries its terminals. What comes out is plain data that tables.py reads and
lalr.py runs: it depends on no version of lark, and reading it takes milliseconds where making it takes seconds.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from re import _constants, _parser
from typing import TYPE_CHECKING, Any

from trackmarshal.syntax.grammar import START, WORD_CHARACTERS, WORD_END, make_parser
from trackmarshal.syntax.tables import END, GATHERED, NODE, SHIPPED, TOKEN, seal

if TYPE_CHECKING:
    from lark import Lark


def tabulate() -> bytes:
    """The file of tables for the grammar as it is now; raises AssertionError for a grammar that lalr.py cannot run."""
    return seal(_text(_tables(make_parser())))


def _text(tables: dict[str, Any]) -> bytes:
    """One line an entry, so that a change of the grammar is a change of some lines."""
    parts = []
    for name, value in tables.items():
        if isinstance(value, list):
            rows = ",\n".join(json.dumps(row, ensure_ascii=True, separators=(",", ":")) for row in value)
            parts.append(f'"{name}":[\n{rows}\n]')
        else:
            parts.append(f'"{name}":{json.dumps(value)}')
    return ("{" + ",\n".join(parts) + "}\n").encode("ascii")


def _tables(made: Lark) -> dict[str, Any]:
    machine: Any = made.parser
    table, lexer = machine.parser._parse_table, machine.lexer
    terminals = list(lexer.root_lexer.terminals)
    number = {terminal.name: index for index, terminal in enumerate(terminals)} | {END: len(terminals)}
    rules = sorted(
        {arg for row in table.states.values() for _, arg in row.values() if not isinstance(arg, int)}, key=str
    )
    nonterminals = {name: n for n, name in enumerate(sorted({rule.origin.name for rule in rules}))}
    rule_number = {rule: index for index, rule in enumerate(rules)}
    scanners: list[list[int]] = [[number[terminal.name] for terminal in terminals]]
    _check_ignored(terminals, lexer.root_lexer.ignore_types)
    _check_texts(terminals)
    order_of_states = _reached(table.states, table.start_states[START])
    renumbered = {state: index for index, state in enumerate(order_of_states)}
    states = []
    for state in order_of_states:
        order = [number[terminal.name] for terminal in lexer.lexers[state].terminals]
        if order not in scanners:
            scanners.append(order)
        actions, gotos = [], []
        for name, (_, arg) in sorted(table.states[state].items()):
            if name in nonterminals:
                gotos += [nonterminals[name], renumbered[arg]]
            else:
                actions += [
                    number[name],
                    renumbered[arg] + 1 if isinstance(arg, int) else -rule_number[arg] - 1,
                ]
        states.append([scanners.index(order), actions, gotos])
    return {
        "start": renumbered[table.start_states[START]],
        "end": renumbered[table.end_states[START]],
        "word_characters": WORD_CHARACTERS,
        "ignored": [number[name] for name in sorted(lexer.root_lexer.ignore_types)],
        "terminals": [_terminal(terminal) for terminal in terminals],
        "scanners": scanners,
        "nonterminals": list(nonterminals),
        "rules": [_rule(rule, nonterminals) for rule in rules],
        "states": states,
    }


def _reached(states: dict[int, dict[str, tuple[Any, Any]]], start: int) -> list[int]:
    """The states in an order that does not depend on how lark numbered them: as they are reached from the first one."""
    order = {start: None}
    for state in (waiting := [start]):
        for _, (_, arg) in sorted(states[state].items()):
            if isinstance(arg, int) and arg not in order:
                order[arg] = None
                waiting.append(arg)
    if len(order) != len(states):
        raise AssertionError("a state that nothing leads to")
    return list(order)


def _terminal(terminal: Any) -> list[str]:
    """Name, kind, what it matches, and all characters it may start with."""
    pattern = terminal.pattern
    if pattern.flags:
        raise AssertionError(f"{terminal.name}: flags are not tabulated")
    if pattern.type == "str":
        return [terminal.name, "text", pattern.value, pattern.value[0]]
    word = pattern.value.removesuffix(WORD_END)
    if word != pattern.value and re.fullmatch("[a-z]+", word):
        return [terminal.name, "word", word, word[0]]
    return [terminal.name, "pattern", pattern.to_regexp(), "".join(sorted(_firsts(pattern.to_regexp())))]


def _rule(rule: Any, nonterminals: dict[str, int]) -> list[Any]:
    """Its nonterminal, its length, the node it makes, whether one child stands for itself, and what becomes of the symbols.

    Of the last: its number and its kind (NODE, TOKEN, GATHERED), or None for what is absent. The node is an empty text where the
    rule only gathers children for the rule that it stands in.
    """
    options, size = rule.options, len(rule.expansion)
    if not size:
        raise AssertionError(f"{rule}: empty rules are not tabulated")
    absent = (
        [len(run) for run in "".join(str(int(b)) for b in options.empty_indices).split("0")]
        if options.empty_indices
        else [0] * (size + 1)
    )
    taken: list[list[int] | None] = []
    for index, symbol in enumerate(rule.expansion):
        taken += [None] * absent[index]
        if options.keep_all_tokens or not (symbol.is_term and symbol.filter_out):
            kind = TOKEN if symbol.is_term else GATHERED if symbol.name.startswith("_") else NODE
            taken.append([index, kind])
    taken += [None] * absent[size]
    origin = rule.origin.name
    node = rule.alias or ("" if origin.startswith("_") else str(origin))
    return [nonterminals[origin], size, node, bool(options.expand1 and not rule.alias), taken]


def _check_ignored(terminals: Iterable[Any], ignored: Iterable[str]) -> None:
    """Blanks and comments are skipped before a terminal is looked for: nothing that could start like one may come first."""
    before: list[Any] = []
    for terminal in terminals:
        if terminal.name not in ignored:
            before.append(terminal)
            continue
        for other in before:
            if _firsts(other.pattern.to_regexp()) & _firsts(terminal.pattern.to_regexp()):
                raise AssertionError(f"{other.name} would be tried before {terminal.name}")


def _check_texts(terminals: list[Any]) -> None:
    """Lark prefers a text to a pattern of its priority that matches all of it; the tables know no such exception."""
    for text in (t for t in terminals if t.pattern.type == "str"):
        for other in (t for t in terminals if t.pattern.type == "re" and t.priority == text.priority):
            if re.fullmatch(other.pattern.to_regexp(), text.pattern.value):
                raise AssertionError(f"{text.name} and {other.name} match the same text")


def _firsts(pattern: str) -> set[str]:
    """All characters that a match of a pattern may start with, or more."""
    found, empty = _first_of(_parser.parse(pattern))
    if empty:
        raise AssertionError(f"{pattern} matches the empty text")
    return found


def _first_of(parsed: Any) -> tuple[set[str], bool]:
    """The first characters of a sequence of a parsed pattern, and whether it may be empty."""
    found: set[str] = set()
    for op, arg in parsed:
        firsts, empty = _first(op, arg)
        found |= firsts
        if not empty:
            return found, False
    return found, True


def _first(op: Any, arg: Any) -> tuple[set[str], bool]:
    match op:
        case _constants.LITERAL:
            return {chr(arg)}, False
        case _constants.IN:
            return {c for kind, value in arg for c in _class(kind, value)}, False
        case _constants.BRANCH:
            parts = [_first_of(branch) for branch in arg[1]]
            return set().union(*(part[0] for part in parts)), any(part[1] for part in parts)
        case _constants.SUBPATTERN:
            return _first_of(arg[3])
        case _constants.MAX_REPEAT:
            firsts, empty = _first_of(arg[2])
            return firsts, empty or arg[0] == 0
        case _constants.ASSERT_NOT:
            return set(), True
        case _:
            raise AssertionError(f"no first characters known of {op}")


def _class(kind: Any, value: Any) -> Iterable[str]:
    match kind:
        case _constants.LITERAL:
            return chr(value)
        case _constants.RANGE:
            return map(chr, range(value[0], value[1] + 1))
        case _:
            raise AssertionError(f"no first characters known of a class with {kind}")


if __name__ == "__main__":
    make_parser(
        strict=True
    )  # raises where terminals collide; it takes seconds, so the tests of every day trust the tables
    SHIPPED.write_bytes(tabulate())
    print(f"{SHIPPED}: written")
