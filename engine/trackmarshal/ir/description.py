"""A formula's structure as text, which fingerprints are made of."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from trackmarshal.ir import nodes as ir

#: What was described, as long as the formula is there: specs that differ in a value share most formulas, and each is asked for by several.
_KNOWN: WeakKeyDictionary[ir.IR, dict[bool, str]] = WeakKeyDictionary()


def describe(root: ir.IR, names: bool = True) -> str:
    """A formula's structure as text, each shared node once: equal texts, equal meanings.

    names: with what its variables are called, which reports name; without, another name says the same.
    """
    known = _KNOWN.setdefault(root, {})
    if names not in known:
        known[names] = _described(root, names)
    return known[names]


def _described(root: ir.IR, names: bool) -> str:
    numbers: dict[ir.IR, int] = {}
    lines: list[str] = []

    def visit(node: ir.IR) -> int:
        known = numbers.get(node)
        if known is not None:
            return known
        parts = []
        said = node.__dict__
        if isinstance(node, ir.Compare):  # told as written: what is kept rests on fingerprints
            said = {**said, **dict(zip(("op", "left", "right"), node.written))}
        for name in node.compared:
            value = said[name]
            called = name == "names" or (name == "name" and isinstance(node, ir.At))
            if name == "shown" or (called and not names):
                continue  # how a comparison is shown is no part of what a formula means
            if (
                name == "turned"
            ):  # of a comparison it is told by how it is written; of a count, on which side the number stands is what it asks
                if value and not isinstance(node, ir.Compare):
                    parts.append("turned")
                continue
            if name in ("forget", "capacity", "bridges") and isinstance(node, ir.Axis | ir.Machine):
                if value:  # most sets remember nothing of what is absent, most machines bridge nothing, and say nothing of it
                    parts.append(f"{name} {value}")
                continue
            if isinstance(value, ir.IR):
                parts.append(f"#{visit(value)}")
            elif isinstance(value, tuple):
                parts.append(
                    "(" + " ".join(f"#{visit(v)}" if isinstance(v, ir.IR) else repr(v) for v in value) + ")"
                )
            else:
                parts.append(repr(value))
        number = numbers[node] = len(numbers)
        lines.append(f"{type(node).__name__} {' '.join(parts)}")
        return number

    visit(root)
    return "\n".join(lines)
