"""The parser's tables as they are shipped: plain data, used only for the grammar that they were made from.

The file's first line holds two hashes, of the grammar and of the rest of the file. Where either does not fit (somebody works on the
grammar, or the file is damaged), the tables are made anew by lark, which takes seconds, and kept in the user's cache.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from trackmarshal.cache import cache_folder, replace
from trackmarshal.syntax.grammar import grammar

SHIPPED = Path(__file__).with_name("spec.tables")
#: Counted up when the form of the file changes.
FORM = 1
END = "$END"
#: What a rule takes of a symbol: the node it became, its text, the children it gathered.
NODE, TOKEN, GATHERED = range(3)
#: Parentheses leave no node behind, so they add nothing to a tree's height.
PARENTHESES = "parenthesised"


class Rule(NamedTuple):
    """How the values of symbols become one; `node` is empty where they are only gathered."""

    nonterminal: int
    size: int
    node: str
    single: bool
    taken: tuple[tuple[int, int] | None, ...]
    #: One symbol that stands for itself.
    identity: bool
    #: What the rule adds to the height of a tree.
    height: int


class Candidate(NamedTuple):
    """A terminal that may stand at a place: a text, which ends at a word's end if `word`; or a pattern."""

    terminal: int
    text: str
    word: bool
    match: Callable[[str, int], re.Match[str] | None] | None


class Tables:
    """States, rules and terminals by number."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.start: int = data["start"]
        self.end: int = data["end"]
        self.names: list[str] = [row[0] for row in data["terminals"]] + [END]
        self.end_terminal = len(self.names) - 1
        self.rules = [_rule(*row) for row in data["rules"]]
        self.scanner: list[int] = [row[0] for row in data["states"]]
        #: Terminal -> where to shift, plus one; or the rule to reduce by, negative, minus one.
        self.actions: list[dict[int, int]] = [dict(zip(row[1][::2], row[1][1::2])) for row in data["states"]]
        self.gotos: list[dict[int, int]] = [dict(zip(row[2][::2], row[2][1::2])) for row in data["states"]]
        self.scanners: list[list[int]] = data["scanners"]
        self.ignored = frozenset(data["ignored"])
        self._terminals: list[list[str]] = data["terminals"]
        blank = "|".join(self._terminals[index][2] for index in data["ignored"])
        self.skip = re.compile(f"(?:{blank})*").match
        self.in_word = re.compile(f"[{data['word_characters']}]").match
        self.starting: list[dict[str, tuple[Candidate, ...]]] = [{} for _ in self.scanners]
        #: The same by state.
        self.starting_in = [self.starting[scanner] for scanner in self.scanner]
        self.after: dict[int, int] = {}
        self._candidates: dict[int, Candidate] = {}

    def candidates(self, scanner: int, character: str) -> tuple[Candidate, ...]:
        """The terminals that may start with a character, in the order in which they are tried."""
        found = tuple(
            self._candidate(index)
            for index in self.scanners[scanner]
            if character in self._terminals[index][3] and index not in self.ignored
        )
        self.starting[scanner][character] = found
        return found

    def _candidate(self, index: int) -> Candidate:
        if index not in self._candidates:
            _, kind, text, _ = self._terminals[index]
            pattern = re.compile(text).match if kind == "pattern" else None
            self._candidates[index] = Candidate(index, text, kind == "word", pattern)
        return self._candidates[index]

    def goto(self, state: int, rule: Rule, terminal: int) -> int:
        """Where a reduction leads: past all that would only pass its value on, since the terminal after it decides that."""
        key = (state * len(self.rules) + rule.nonterminal) * len(self.names) + terminal
        found = self.after.get(key)
        if found is None:
            found = self.gotos[state][rule.nonterminal]
            while True:
                action = self.actions[found].get(terminal, 0)
                if action >= 0 or not self.rules[-action - 1].identity or found == self.end:
                    break
                found = self.gotos[state][self.rules[-action - 1].nonterminal]
            self.after[key] = found
        return found


def _rule(nonterminal: int, size: int, node: str, single: bool, taken: list[list[int] | None]) -> Rule:
    identity = single and size == 1 and taken == [[0, NODE]]
    kept = tuple(None if one is None else (one[0], one[1]) for one in taken)
    return Rule(nonterminal, size, node, single, kept, identity, int(node not in ("", PARENTHESES)))


@cache
def tables() -> Tables:
    """The tables of the grammar."""
    data = _opened(SHIPPED)
    if data is not None:
        return Tables(data)
    folder = cache_folder()
    kept = None if folder is None else folder / f"tables-{grammar_hash()[:32]}.json"
    data = None if kept is None else _opened(kept)
    if data is None:
        from trackmarshal.syntax.tabulate import tabulate

        made = tabulate()
        data = _unsealed(made)
        if data is None:
            raise AssertionError("tables that were just made do not fit the grammar")
        if kept is not None:
            replace(kept, made)
    return Tables(data)


def seal(body: bytes) -> bytes:
    """The file of tables: their form, the hash of the grammar, and the hash of the tables themselves, above the tables."""
    return f"{_head(body)}\n".encode() + body


def _head(body: bytes) -> str:
    return f"trackmarshal tables {FORM} {grammar_hash()} {hashlib.sha256(body).hexdigest()}"


@cache
def grammar_hash() -> str:
    return hashlib.sha256(grammar().encode()).hexdigest()


def _opened(path: Path) -> dict[str, Any] | None:
    try:
        return _unsealed(path.read_bytes())
    except OSError:
        return None


def _unsealed(data: bytes) -> dict[str, Any] | None:
    """The tables of a file, or None if they are damaged or of another grammar."""
    head, _, body = data.partition(b"\n")
    if head != _head(body).encode():
        return None
    read: dict[str, Any] = json.loads(body)
    return read
