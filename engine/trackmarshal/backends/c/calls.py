"""Which functions generated code calls: what an integrator has to know of the C library that it will run with."""

from __future__ import annotations

import re

from trackmarshal.backends.c.functions.rules import RuleCode
from trackmarshal.backends.c.layout import shape_key
from trackmarshal.backends.c.setters import make
from trackmarshal.backends.c.source import Source
from trackmarshal.ir import nodes as ir

#: What every C library computes to the same last bit, as IEEE 754 and C99 define it; `isnan` and its like compute no number at all.
EXACT = frozenset(
    ("fabs", "fabsf", "sqrt", "floor", "ceil", "rint", "fmod", "remainder", "isnan", "isinf", "isfinite")
)
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_DEFINED = re.compile(r"^(?:static (?:inline )?)?[a-z_]\w* \*?(tm_\w+)\([^;{]*?\)\s*\{", re.MULTILINE)
_CALLED = re.compile(r"\b([a-z]\w*)\(")
_WORDS = frozenset(("if", "for", "while", "switch", "return", "sizeof", "defined"))


def calls(source: Source) -> dict[str, set[str]]:
    """Every function of the program, and what it calls itself."""
    code = _COMMENT.sub("", source.source)
    found = list(_DEFINED.finditer(code))
    ends = [match.start() for match in found[1:]] + [len(code)]
    return {
        match.group(1): set(_CALLED.findall(code[match.end() : end])) - _WORDS
        for match, end in zip(found, ends)
    }


def reached(graph: dict[str, set[str]], *functions: str) -> set[str]:
    """What functions call, also by way of others."""
    known: set[str] = set()
    waiting = list(functions)
    while waiting:
        for name in graph.get(waiting.pop(), ()):
            if name not in known:
                known.add(name)
                waiting.append(name)
    return known


def inexact(source: Source) -> dict[str, list[str]]:
    """Rules whose verdict and margin depend on what each C library computes in its own way: by rule, these functions of libm.

    Functions that prepare the lines and areas that a rule asks about count too. Raises AssertionError where the code of a rule
    is not found.
    """
    graph = calls(source)
    found = {code.rule.name: sorted(_libm(source, graph, code) - EXACT) for code in source.rules}
    return {name: functions for name, functions in found.items() if functions}


def _libm(source: Source, graph: dict[str, set[str]], code: RuleCode) -> set[str]:
    begun = [code.entry]
    for root in code.rule.roots:
        for node in ir.below(root):
            if isinstance(node, ir.Line | ir.Area | ir.OnLane) and shape_key(node) in source.plan.shapes:
                begun.append(make(source.plan.shape(node)).partition("(")[0])
    missing = [name for name in begun if name not in graph]
    if missing:
        raise AssertionError(f"{', '.join(missing)} not found in the generated code")
    return {name for name in reached(graph, *begun) if not name.startswith("tm_")}
