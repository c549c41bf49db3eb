"""Rulebooks in C: what outranks what as constant tables, and comparisons of the results that `tm_check` gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.backends.c.functions.rules import RuleCode, constant
from trackmarshal.backends.c.names import comment, distinct
from trackmarshal.backends.c.rendering import render
from trackmarshal.ir.spec import Spec
from trackmarshal.rulebooks.order import Order, order

#: The table of a rulebook, as functions take it.
RANKS = """/* A rulebook: groups of rules that count as one, where each begins among `rule`, and which others outrank it. */
typedef struct {
  size_t groups;
  const size_t *first;
  const size_t *rule;
  const bool *above;
} tm_ranks;
"""


@dataclass(frozen=True)
class BookCode:
    """A rulebook as its tables: where groups begin, constants of rules, and a row of "true" and "false" a group."""

    c_name: str
    about: str
    first: tuple[str, ...]
    rules: tuple[str, ...]
    above: tuple[tuple[str, ...], ...]


def book_codes(spec: Spec, codes: Sequence[RuleCode]) -> tuple[BookCode, ...]:
    """The rulebooks of which all rules are compiled; there is none about the others, as nothing would be known of what was left out.

    Nor is there one of rules that count as one and have different scales: results do not know of these.
    """
    constants = {code.rule.name: constant(code.c_name) for code in codes}
    taken: set[str] = set()
    found = []
    for book in spec.rulebooks:
        ranks = order(book, spec)
        if not all(rule in constants for rule in book.rules) or _needs_scales(ranks):
            continue
        c_name = distinct([book.name], taken)[book.name]
        taken.add(c_name.casefold())
        begins = [0]
        for group in ranks.groups:
            begins.append(begins[-1] + len(group))
        found.append(
            BookCode(
                c_name,
                comment(f"{book.name} ({book.title or 'no title'}; {book.span})"),
                tuple(f"{begin}u" for begin in begins),
                tuple(constants[rule] for group in ranks.groups for rule in group),
                tuple(
                    tuple("true" if other in above else "false" for other in range(len(ranks.groups)))
                    for above in ranks.above
                ),
            )
        )
    return tuple(found)


def _needs_scales(ranks: Order) -> bool:
    return any(ranks.scale(rule, group) != 1.0 for group in ranks.groups for rule in group)


def declared(books: Sequence[BookCode]) -> str:
    """What the header says of them; empty where there is none."""
    return render("program/header/rulebooks.h.j2", {"books": books}).rstrip() if books else ""


def defined(books: Sequence[BookCode]) -> list[str]:
    """Tables and functions, for the end of the source."""
    return [render("program/source/rulebooks.c.j2", {"books": books}).rstrip() + "\n"] if books else []
