"""Two functions while they are written: the lines of each, the variables that these set, and the objects that they name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from trackmarshal.ir import nodes as ir


class Writing:
    """What has been written so far of what no case changes, and of what varies: there, one block at a time is only done where a guard holds."""

    def __init__(self, named: dict[str, Any]) -> None:
        #: Objects that the source names.
        self.named = named
        self.fixed: list[str] = []
        self.varying: list[str] = []
        #: Lines of the block that is being written.
        self.block: list[str] | None = None
        #: The variables that `fixed` leaves behind.
        self.left: list[str] = []
        #: Nodes that no case changes.
        self.unchanged: set[ir.IR] = set()
        #: The variables of numbers.
        self.numbers: dict[ir.IR, str] = {}
        #: Names of objects and of variables that are set once, by what they are of.
        self.names: dict[Any, str] = {}
        self._free: list[str] = []
        self._made = 0  # variables of numbers

    def line(self, node: ir.IR, text: str) -> None:
        """A line about a node."""
        (self.fixed if node in self.unchanged else self.lines(self.block is not None)).append(text)

    def lines(self, within: bool) -> list[str]:
        """Where what varies is written: within the block that is being written, or before it."""
        if not within:
            return self.varying
        assert self.block is not None
        return self.block

    @contextmanager
    def before_the_block(self) -> Iterator[None]:
        """What is written meanwhile stands before the block, where variables that it has let go are not free yet."""
        block, free = self.block, self._free
        self.block, self._free = None, [] if block is not None else free
        yield
        self.block, self._free = block, free

    def number(self, node: ir.Num, expression: str) -> str:
        """The variable of a number, set to an expression."""
        if node not in self.unchanged and self._free:
            name = self._free.pop()
        else:
            name = f"x{self._made}"
            self._made += 1
            if node in self.unchanged:
                self.left.append(name)
        self.numbers[node] = name
        self.line(node, f"{name} = {expression}")
        return name

    def release(self, node: ir.IR) -> None:
        """Nobody needs a number any more: another may have its variable, and its memory is free then."""
        if node in self.numbers and node not in self.unchanged and self.numbers[node] not in self._free:
            self._free.append(self.numbers[node])

    def forget(self, node: ir.IR) -> None:
        """The next block works a number out anew."""
        if node in self.numbers and node not in self.unchanged:
            self._free.append(self.numbers.pop(node))

    def hold(self, thing: Any, key: Any = None) -> str:
        """The name of an object, or of one that is equal by key."""
        key = ("object", id(thing)) if key is None else key
        if key not in self.names:
            self.names[key] = f"k{len(self.names)}"
            self.named[self.names[key]] = thing
        return self.names[key]

    def once(self, prefix: str, key: Any, expression: str, within: bool = False) -> str:
        """A variable of something of the batch, set where it is first needed. within: it is of a block that is being written."""
        if (prefix, key) not in self.names:
            self.names[prefix, key] = f"{prefix}{len(self.names)}"
            self.lines(within).append(f"{self.names[prefix, key]} = {expression}")
        return self.names[prefix, key]


def tuple_of(names: Iterable[str]) -> str:
    """A tuple, to make or to take apart."""
    return f"({''.join(f'{name}, ' for name in names)})"
