"""A list of requirements as a person writes it in YAML: fields in their order, long texts folded, nothing in quotes that needs none."""

from __future__ import annotations

import json
import re

from trackmarshal.trace import tree
from trackmarshal.trace.documents import REQUIREMENTS
from trackmarshal.trace.exchange.content import FIELDS, PAIRS, Document
from trackmarshal.trace.exchange.refused import Refused
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.values import Reader, Table, resolved

_WIDTH = 122
_WORD = re.compile(r"[\w*][\w .()*-]*")


def write(document: Document) -> str:
    """The document's file; raises T352 where a text has no place in YAML."""
    table = document.table
    lines = ["document: requirements", *_field("title", table.text("title"), "")]
    if table.text("source"):
        lines += _field("source", table.text("source"), "")
    lines += ["", "requirements:" if document.requirements else "requirements: []"]
    for number, one in enumerate(document.requirements):
        lines += [""] if number else []
        said = []
        for field in FIELDS:
            said += (
                _pairs(field, one) if field in PAIRS else _said(field, one, "    ") if field in one else []
            )
        said += _pairs("foreign", one)
        lines += ["  - " + said[0][4:], *said[1:]]
    text = "\n".join(lines) + "\n"
    _as_it_was(text, document)
    return text


def _as_it_was(text: str, document: Document) -> None:
    """What was written is read again: what would come back as something else is not written."""
    found: list[Finding] = []
    shown = f"requirements/{document.name or 'list'}.yaml"
    try:
        node = tree.parse(text.encode("utf-8"), shown, found)
        table = None if node is None else Reader(shown, found).table(node, REQUIREMENTS, "the document")
    except UnicodeEncodeError as problem:
        raise Refused(
            "T352",
            f"half of a character, U+{ord(problem.object[problem.start]):04X}, is no text",
            shown,
            help="remove it there, and export again",
        ) from None
    if found or table != document.table:
        said = found[0].message if found else "it would come back as something else"
        raise Refused(
            "T352",
            f"a text cannot be written as YAML: {said}",
            shown,
            help="are there characters in it that nobody can see?",
        )


def _pairs(name: str, one: Table) -> list[str]:
    """Names with texts; nothing where there are none."""
    said = one.get(name, {})
    lines = [line for key, text in said.items() for line in _field(_key(key), text, "      ")]
    return [f"    {name}:", *lines] if lines else []


def _said(name: str, one: Table, indent: str) -> list[str]:
    value = one[name]
    if isinstance(value, str):
        return _field(name, value, indent)
    entries = [_entry(entry) for entry in value]
    flow = f"{indent}{name}: [{', '.join(entries)}]"
    if len(flow) <= _WIDTH + 8:
        return [flow]
    return [f"{indent}{name}:", *(f"{indent}  - {entry}" for entry in entries)]


def _field(name: str, text: str, indent: str) -> list[str]:
    head = f"{indent}{name}:"
    if text.isprintable():
        if _is_plain(text) and len(head) + 1 + len(text) <= _WIDTH:
            return [f"{head} {text}"]
        if len(head) + 1 + len(text) > _WIDTH and "  " not in text:
            return [f"{head} >-", *_folded(text, indent + "  ")]
    elif all(line.isprintable() and line == line.rstrip() for line in text.split("\n")):
        return [f"{head} |-", *(indent + "  " + line if line else "" for line in text.split("\n"))]
    return [f"{head} {_quoted(text)}"]


def _folded(text: str, indent: str) -> list[str]:
    lines = [""]
    for word in text.split(" "):
        if lines[-1] and len(indent) + len(lines[-1]) + 1 + len(word) > _WIDTH:
            lines.append(word)
        else:
            lines[-1] += f" {word}" if lines[-1] else word
    return [indent + line for line in lines]


def _is_plain(text: str) -> bool:
    """Whether a text can stand without quotes, and is taken for a text there."""
    found: list[Finding] = []
    try:
        node = tree.parse(f"a: {text}\n".encode(), "", found)
    except UnicodeEncodeError:
        return False
    value = node.entries.get("a") if isinstance(node, tree.Mapping) else None
    return (
        not found
        and isinstance(value, tree.Scalar)
        and value.plain
        and value.text == text
        and resolved(value) == "str"
    )


def _entry(text: str) -> str:
    return text if _WORD.fullmatch(text) and _is_plain(text) and not text.startswith("*") else _quoted(text)


def _key(text: str) -> str:
    return (
        text
        if re.fullmatch(r"[A-Za-z][\w. -]*", text)
        and text == text.strip()
        and resolved(tree.Scalar(text, True, 0, 0)) == "str"
        else _quoted(text)
    )


def _quoted(text: str) -> str:
    if text.isprintable() and "'" not in text:
        return f"'{text}'"
    return '"' + "".join(_character(char) for char in text) + '"'


def _character(char: str) -> str:
    if char in '"\\\n\r\t':
        return json.dumps(char)[1:-1]
    return char if char.isprintable() else f"\\U{ord(char):08X}"
