"""Shared memory: two files, one written by the planner's side alone, one by the Supervisor alone, with mailboxes for messages.

A mailbox has a few slots, of which the newest message has the next one: whoever reads finds a whole message, even where a writer died
in the middle of one. Nobody writes to what another one writes to, and both map the other's file for reading only.
"""

from __future__ import annotations

from dataclasses import dataclass

from trackmarshal.backends.c.process.messages import Table

#: "TMSR", and the version of this layout of memory.
MAGIC, VERSION = 0x5253_4D54, 1
#: What processors fetch at once: head of a file, of a mailbox, of a slot each have such a line.
LINE = 64
#: Where a file's bell stands: it counts all messages in the file, and is what a reader sleeps on.
BELL = 32


@dataclass(frozen=True)
class Mailbox:
    """A mailbox in a file: the place in bytes of `latest`, of its first slot, how many bytes lie between slots, how many there are."""

    name: str
    message: str
    place: int
    slots: int
    step: int

    @property
    def first(self) -> int:
        return self.place + LINE

    @property
    def end(self) -> int:
        return self.first + self.slots * self.step


@dataclass(frozen=True)
class Region:
    """A file of mailboxes."""

    name: str
    mailboxes: tuple[Mailbox, ...]

    @property
    def size(self) -> int:
        return self.mailboxes[-1].end


def regions(table: Table) -> tuple[Region, Region]:
    """What the planner's side writes, and what the Supervisor writes."""
    lines = [(f"line_{slot}", "line", 2) for slot in range(len(table.lines))]
    return (
        _region("cycles", table, [("cycle", "cycle", 4), ("tick", "tick", 2), *lines]),
        _region("decisions", table, [("decision", "decision", 4), ("beat", "beat", 2)]),
    )


def _region(name: str, table: Table, wanted: list[tuple[str, str, int]]) -> Region:
    place, found = LINE, []
    for own, message, slots in wanted:
        length = table.message(message).length
        step = LINE + length + -length % LINE  # a line for the slot's turn
        found.append(Mailbox(own, message, place, slots, step))
        place = found[-1].end
    return Region(name, tuple(found))
