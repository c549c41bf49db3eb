"""Syntax trees as plain data: nothing in it is run, and reading it makes nodes and places only.

A node is a list of the number of its class, the start and the end of its place, and its fields; any other list is a tuple. A class
that is counted down from -1 stands in parentheses.
"""

from __future__ import annotations

import json
from typing import Any

from trackmarshal.node import Node
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax import ast

_CLASSES = [kind for kind in vars(ast).values() if isinstance(kind, type) and issubclass(kind, Node)]
_NUMBERS = {kind: number for number, kind in enumerate(_CLASSES)}


def pack(tree: ast.Module) -> bytes:
    """A tree as bytes; raises TypeError for what is no part of a tree."""
    return json.dumps(_plain(tree), separators=(",", ":")).encode("ascii")


def unpack(data: bytes, file: SourceFile) -> ast.Module:
    """The tree of a file; raises ValueError where the data is no tree of it."""
    try:
        tree = _node(json.loads(data), file)
    except (ValueError, TypeError, LookupError, RecursionError) as error:
        raise ValueError("no tree") from error
    if not isinstance(tree, ast.Module) or tree.span.end != len(file.text):
        raise ValueError("no tree of this file")
    return tree


#: What is plain data already.
_PLAIN = frozenset({str, bool, type(None)})


def _plain(value: Any) -> Any:
    kind = type(value)
    if kind is tuple:
        return [item if type(item) in _PLAIN else _plain(item) for item in value]
    number = _NUMBERS.get(kind)
    if number is None:
        if isinstance(value, str):  # a token
            return value
        raise TypeError(f"a {kind.__name__} is no part of a tree")
    fields = value.__dict__
    span = fields["span"]
    if type(span) is ast.Parenthesised:
        number = -number - 1
    elif type(span) is not Span:
        raise TypeError(f"a {type(span).__name__} is no place of a tree")
    row = [number, span.start, span.end]
    for name in value.compared:
        item = fields[name]
        row.append(item if type(item) in _PLAIN else _plain(item))
    return row


def _node(row: list[Any], file: SourceFile) -> Node:
    number, start, end, *values = row
    place = Span
    if number < 0:
        number, place = -number - 1, ast.Parenthesised
    kind = _CLASSES[number]
    names = kind.compared
    if len(names) != len(values):
        raise ValueError(f"a {kind.__name__} of {len(values)} fields")
    node: Node = object.__new__(kind)
    fields = node.__dict__
    for name, value in zip(names, values):
        fields[name] = _value(value, file) if type(value) is list else value
    fields["span"] = place(file, start, end)
    return node


def _value(row: list[Any], file: SourceFile) -> Any:
    if row and type(row[0]) is int:
        return _node(row, file)
    return tuple([_value(item, file) if type(item) is list else item for item in row])
