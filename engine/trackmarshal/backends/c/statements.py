"""C statements in nested blocks, what each assigns and reads, and the removal of those that nothing reads."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

#: Names that the generator makes up are a letter or two and a number; only they are tracked. Members of structs are none.
_MADE = re.compile(r"(?<![\w.])(?<!->)[a-z]{1,2}\d+\b")


@dataclass(eq=False)
class Statement:
    """One statement; `target` is the made-up name that it declares or assigns, if that is all it does."""

    text: str
    target: str | None = None
    note: str = ""
    uses: frozenset[str] = frozenset()


@dataclass(eq=False)
class Block:
    """Statements between braces behind `head`; `binds` maps axes to the C expression of their index."""

    head: str
    parent: Block | None = None
    binds: dict[object, str] = field(default_factory=dict)
    body: list[Statement | Block] = field(default_factory=list)
    #: What was computed in this block already: key -> C name(s).
    known: dict[object, object] = field(default_factory=dict)
    #: Inner blocks that are being written; what is added meanwhile stands before them.
    opened: list[Block] = field(default_factory=list)

    def add(self, text: str, target: str | None = None, note: str = "") -> None:
        """Append a statement, or a declaration of `target`."""
        uses = frozenset(_MADE.findall(text))
        self._insert(Statement(text, target, note, uses - {target} if target is not None else uses))

    def _insert(self, item: Statement | Block) -> None:
        place = self.body.index(self.opened[-1]) if self.opened else len(self.body)
        self.body.insert(place, item)

    def open(self, head: str) -> Block:
        """Append an inner block; `close` says that it is written."""
        block = Block(head, self)
        self._insert(block)
        self.opened.append(block)
        return block

    def close(self, block: Block) -> None:
        """End the inner block that was opened last."""
        last = self.opened.pop()
        assert last is block

    def chain(self) -> Iterator[Block]:
        """This block and those around it, the innermost first."""
        block: Block | None = self
        while block is not None:
            yield block
            block = block.parent

    def statements(self) -> Iterator[Statement]:
        """All statements, inner blocks' included."""
        for item in self.body:
            if isinstance(item, Block):
                yield from item.statements()
            else:
                yield item


def prune(root: Block) -> None:
    """Remove assignments to names that nothing else reads, and inner blocks that are left empty."""
    while True:
        read: set[str] = set(_MADE.findall(root.head))
        for block in _blocks(root):
            read |= set(_MADE.findall(block.head))
        for statement in root.statements():
            read |= statement.uses
        if not _drop(root, read):
            return


def _blocks(block: Block) -> Iterator[Block]:
    for item in block.body:
        if isinstance(item, Block):
            yield item
            yield from _blocks(item)


def _drop(block: Block, read: set[str]) -> bool:
    kept: list[Statement | Block] = []
    changed = False
    for item in block.body:
        if isinstance(item, Block):
            changed |= _drop(item, read)
            if item.body:
                kept.append(item)
            else:
                changed = True
        elif item.target is not None and item.target not in read:
            changed = True
        else:
            kept.append(item)
    block.body = kept
    return changed


def render(block: Block, depth: int = 0) -> Iterator[str]:
    """The block's lines."""
    pad = "  " * depth
    yield f"{pad}{block.head} {{" if block.head else pad + "{"
    for item in block.body:
        if isinstance(item, Block):
            yield from render(item, depth + 1)
        else:
            note = f" /* {item.note} */" if item.note else ""
            yield f"{pad}  {item.text}{note}"
    yield pad + "}"
