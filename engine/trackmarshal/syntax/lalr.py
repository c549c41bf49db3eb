"""Runs the tables: text to what a builder makes of it, bottom up, one terminal ahead.

It does what lark does with the same grammar, and the tests hold it against lark: each state looks only for the terminals that it
has an action for, in lark's order. Chains of rules that only pass a value on (an expression has a dozen) are taken in one step.
"""

from __future__ import annotations

from typing import Any

from trackmarshal.syntax.tables import GATHERED, TOKEN, Rule, Tables, tables


class Token(str):
    """The text of a terminal, with its name and its place."""

    __slots__ = ("start_pos", "type")

    type: str
    start_pos: int


class Unexpected(Exception):
    """The text cannot go on like this at `start`.

    `found` is the terminal there, empty at the end of the text, None where no terminal of the language matches.
    """

    def __init__(self, start: int, found: str | None, wanted: set[str]) -> None:
        super().__init__(start, found)
        self.start = start
        self.found = found
        #: What was looked for, where no terminal matches.
        self.wanted = wanted


def parse(text: str, builder: Any, limit: int) -> Any:
    """What `builder` makes of a whole text; raises Unexpected, and what the builder raises.

    The builder has a method for each node of the grammar: it gets the place (where it starts and ends, in characters) and the list
    of children. Of a tree higher than `limit` the place goes to `builder.too_high`, which raises. Without a builder (None), the
    text is only checked.
    """
    return _Run(text, builder, limit).run(True)


def accepted(text: str) -> set[str]:
    """The names of the terminals that may follow the start of a text."""
    run = _Run(text, None, 0)
    try:
        run.run(False)
    except Unexpected as error:
        return error.wanted
    return run.accepted()


class _Run:
    """The stacks of one parse."""

    def __init__(self, text: str, builder: Any, limit: int) -> None:
        self.tables: Tables = tables()
        self.text = text
        self.builder = builder
        self.limit = limit
        self.states = [self.tables.start]
        #: Of each symbol on the stack: what it became, from where to where it reaches, how high its tree is.
        self.values: list[Any] = []
        self.starts: list[int] = []
        self.ends: list[int] = []
        self.heights: list[int] = []

    def run(self, whole: bool) -> Any:
        """Read the text, and finish the node if it is a `whole` one; raises Unexpected."""
        text, known, states, builder = self.text, self.tables, self.states, self.builder
        values, starts, ends, heights = self.values, self.starts, self.ends, self.heights
        skip, starting, actions, after, rules = (
            known.skip,
            known.starting_in,
            known.actions,
            known.after,
            known.rules,
        )
        kinds, names, in_word = len(rules), len(known.names), known.in_word
        stop, length = 0, len(text)
        state = states[-1]
        while True:
            skipped = skip(text, stop)
            at = stop = skipped.end() if skipped else stop
            if at == length:
                if not whole:
                    return None
                terminal = known.end_terminal
            else:
                candidates = starting[state].get(text[at])
                if candidates is None:
                    candidates = known.candidates(known.scanner[state], text[at])
                for terminal, literal, word, match in candidates:  # noqa: B007 - the one that matches is used below
                    if match is not None:
                        found = match(text, at)
                        if found is not None:
                            stop = found.end()
                            break
                    elif text.startswith(literal, at):
                        stop = at + len(literal)
                        if not word or in_word(text, stop) is None:
                            break
                else:
                    raise self._unknown(at, state)
            # All reductions that this terminal decides, then it is shifted.
            while (action := actions[state].get(terminal, 0)) < 0:
                rule = rules[-action - 1]
                size = rule.size
                first = len(values) - size
                if not rule.identity:
                    # The values of the rule's symbols become one.
                    height = heights[first] if size == 1 else max(heights[first:])
                    value = None
                    if builder is not None:
                        value = self._children(rule, first)
                        if rule.single and len(value) == 1:
                            value = value[0]
                        elif rule.node:
                            place = (starts[first], ends[-1])
                            height += rule.height
                            if height > self.limit:
                                builder.too_high(place)
                            value = getattr(builder, rule.node)(place, value)
                    if size > 1:
                        ends[first] = ends[-1]
                        del values[first + 1 :], starts[first + 1 :], ends[first + 1 :], heights[first + 1 :]
                    values[first] = value
                    heights[first] = height
                del states[-size:]
                state = after.get((states[-1] * kinds + rule.nonterminal) * names + terminal, -1)
                if state < 0:
                    state = known.goto(states[-1], rule, terminal)
                states.append(state)
                if at == length and state == known.end:
                    return values[0]
            if not action:
                raise Unexpected(at, text[at:stop], set())
            state = action - 1
            states.append(state)
            values.append(terminal)
            starts.append(at)
            ends.append(stop)
            heights.append(-1)

    def _unknown(self, at: int, state: int) -> Unexpected:
        """What is wrong where nothing matches that the state has an action for: a terminal of another place, or none at all."""
        known, text = self.tables, self.text
        for _, literal, word, match in known.candidates(0, text[at]):
            found = match(text, at) if match is not None else None
            if found is not None:
                return Unexpected(at, found.group(), set())
            if (
                match is None
                and text.startswith(literal, at)
                and not (word and known.in_word(text, at + len(literal)))
            ):
                return Unexpected(at, literal, set())
        wanted = {
            known.names[index] for index in known.scanners[known.scanner[state]] if index not in known.ignored
        }
        return Unexpected(at, None, wanted)

    def _children(self, rule: Rule, first: int) -> list[Any]:
        """What a rule takes of its symbols, the first of which is at this place of the stack."""
        values = self.values
        children: list[Any] = []
        for taken in rule.taken:
            if taken is None:
                children.append(None)
                continue
            index, kind = taken
            index += first
            value = values[index]
            if kind == TOKEN:
                start = self.starts[index]
                token = Token(self.text[start : self.ends[index]])
                token.type = self.tables.names[value]
                token.start_pos = start
                children.append(token)
            elif kind != GATHERED:
                children.append(value)
            elif children:
                children += value
            else:
                children = value  # a long list grows in place
        return children

    def accepted(self) -> set[str]:
        """The terminals that could really be shifted next; states that were merged promise more."""
        names = self.tables.names
        return {
            names[terminal] for terminal in self.tables.actions[self.states[-1]] if self._shiftable(terminal)
        }

    def _shiftable(self, terminal: int) -> bool:
        known, states = self.tables, [*self.states]
        while (action := known.actions[states[-1]].get(terminal, 0)) < 0:
            rule = known.rules[-action - 1]
            del states[-rule.size :]
            states.append(known.goto(states[-1], rule, terminal))
            if terminal == known.end_terminal and states[-1] == known.end:
                return True
        return action > 0
