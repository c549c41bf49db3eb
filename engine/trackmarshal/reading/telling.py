"""A rule in sentences: what it demands, what the letters in it mean, and each definition that it calls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import assert_never

from trackmarshal import typed
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.node import Node
from trackmarshal.reading.phrases import called, parameters_of, plain
from trackmarshal.reading.sentences import ADDED, OPEN, SINGLE, TOGETHER, Sentences
from trackmarshal.reading.words import Words
from trackmarshal.syntax import ast
from trackmarshal.units import about, in_full


class Told(Node):
    """A rule in words: paragraphs of what it demands, and of what it calls."""

    demand: tuple[str, ...]
    definitions: tuple[str, ...]


def tell(rule: RuleInfo, spec: Spec, words: Words) -> Told:
    """A rule with a condition, in words."""
    assert rule.typed is not None, "a rule without a condition says nothing"
    reached = list(typed.below(rule.typed))
    measured = frozenset(
        node.symbol.name
        for node in reached
        if isinstance(node, typed.CalledNumber | typed.CalledFormula | typed.Machine)
    )
    said = Sentences(words, spec.params, frozenset(_names(reached)), _shared(reached, spec), measured)
    demand = tuple(_demand(rule.typed, said))
    settings = _settings(reached, spec, said)
    return Told(
        demand, (*_events(reached, said), *_definitions(reached, said), *settings, *_machines(reached, said))
    )


def _names(reached: Sequence[typed.Typed]) -> Iterator[str]:
    """All that an author called by a name: in the rule, in what it calls, and in the input."""
    for node in reached:
        held = node.__dict__
        yield str(held.get("name", ""))
        yield from (*held.get("names", ()), *held.get("members", ()))
        if held.get("signal") is not None:
            yield held["signal"].name
        if held.get("symbol") is not None:
            yield from held["symbol"].qualified.split(".")  # of a record of parameters, its own name too


def _shared(reached: Sequence[typed.Typed], spec: Spec) -> frozenset[str]:
    """The names by which several things go: each by its own in its module, and in the rule only through what it calls."""
    things: dict[str, set[str]] = {}
    for node in reached:
        symbol = node.__dict__.get("symbol")
        if symbol is not None:
            known = spec.params.get(symbol.qualified)
            things.setdefault(known.short if known else symbol.name, set()).add(symbol.qualified)
        own = (
            node.names
            if isinstance(node, typed.Range)
            else (node.name,)
            if isinstance(node, typed.Let)
            else ()
        )
        for name in own:  # has no other name, as what is declared has
            things.setdefault(name, set()).add("")
    return frozenset(name for name, meant in things.items() if len(meant) > 1)


def _demand(rule: typed.Rule, said: Sentences) -> Iterator[str]:
    """One sentence of all clauses, and another one of what is called how in it."""
    words, heads, meant = said.words, list[str](), list[str]()
    body, existing, deadline = "", False, ""
    for clause in rule.clauses:
        match clause:
            case typed.Along():
                heads.append(
                    words.along[clause.place].format(
                        a=clause.range.names[0], b=said.signal(clause.range.domain)
                    )
                )
            case typed.Whenever():
                heads.append(words.whenever.format(a=said.formula(clause.condition, TOGETHER)))
            case typed.Deadline():
                deadline = words.deadline.format(a=said.number(clause.limit, ADDED))
            case typed.ForEach():
                ranged = said.quantifier(clause.quantifier, clause.range, clause.where, clause.by)
                if existing:  # else it would be heard of another one for each that follows
                    ranged = words.existing.format(a=words.comma.join(heads), b=ranged)
                    heads.clear()
                heads.append(ranged)
                existing = clause.quantifier == "exists"
            case typed.Except():
                every = clause.of.quantifier == "for all" and clause.of.by is None
                why = words.except_why if every else words.leaving_out
                heads.append(why.format(a=said.formula(clause.condition, SINGLE), b=clause.reason))
            case typed.Let():
                meant.append(_let(clause, said))
            case typed.Require():
                body = said.formula(clause.condition)
            case _:
                assert_never(clause)
    if deadline and any(isinstance(clause, typed.ForEach) for clause in rule.clauses):  # of each by itself
        body = f"{deadline}{words.comma}{body}"
    elif deadline:
        heads.append(deadline)
    head = words.comma.join(heads)
    whole = body if not heads else (words.existing if existing else words.colon).format(a=head, b=body)
    yield _sentence(whole)
    meant += said.meanings()
    if meant:
        yield _here(meant, said)


def _let(clause: typed.Let, said: Sentences) -> str:
    """What a name stands for."""
    value, words = clause.value, said.words
    if isinstance(value, typed.FormulaNode):
        return words.if_.format(a=f"“{plain(clause.name)}”", b=said.formula(value))
    shown = said.number(value) if isinstance(value, typed.NumberNode) else said.value(value)
    return words.is_.format(a=called(clause.name), b=shown)


def _here(meant: Sequence[str], said: Sentences) -> str:
    return said.words.here.format(a="; ".join(meant))


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."


def _definitions(reached: Sequence[typed.Typed], said: Sentences) -> Iterator[str]:
    seen = set()
    words = said.words
    for node in reached:
        if (
            isinstance(node, typed.InStretch)
            and node.symbol is not None
            and node.symbol.qualified not in seen
        ):
            seen.add(node.symbol.qualified)
            text = words.stretch.format(a=said.short(node.symbol), b=said.ends(node))
            yield _with_meanings(_sentence(text), said)
        if not isinstance(node, typed.CalledNumber | typed.CalledFormula) or node.symbol.qualified in seen:
            continue
        seen.add(node.symbol.qualified)
        given = [called(name) for name in parameters_of(node.symbol)]
        if isinstance(node, typed.CalledNumber):
            name = called(said.short(node.symbol))
            head = words.of.format(a=name, b=said.listed(given)) if given else name
            text = words.is_.format(a=head, b=said.number(node.body))
        else:
            name = plain(said.short(node.symbol))
            head = (
                words.holds_for[0].format(a=name, b=said.listed(given))
                if given
                else words.holds[0].format(a=name)
            )
            text = words.when.format(
                a=head, b=said.formula(node.body, SINGLE if _conditional(node.body) else OPEN)
            )
        yield _with_meanings(_sentence(text), said)


def _conditional(node: typed.Formula) -> bool:
    """Whether a sentence begins with `if`, or has one in it that would be taken for that of a definition."""
    return isinstance(node, typed.Connective) and node.op in ("implies", "iff", "xor")


def _events(reached: Sequence[typed.Typed], said: Sentences) -> Iterator[str]:
    """What an author says that an event of the input means."""
    seen = set()
    for node in reached:
        if isinstance(node, typed.Event) and node.symbol.qualified not in seen:
            seen.add(node.symbol.qualified)
            assert isinstance(node.symbol.item, ast.Event)
            if node.symbol.item.text:
                yield said.words.event.format(a=plain(said.short(node.symbol)), b=node.symbol.item.text)


def _settings(reached: Sequence[typed.Typed], spec: Spec, said: Sentences) -> Iterator[str]:
    """The values of records of parameters that are given to definitions, which say the names of these alone."""
    records: dict[str, dict[str, str]] = {}
    for node in reached:
        if isinstance(node, typed.Parameter) and isinstance(node.record, typed.NamedRecord):
            info = spec.params[node.symbol.qualified]
            record, _, name = (info.name if info.short in said.shared else info.short).rpartition(".")
            value = about(in_full(info.value, node.written or info.unit))
            records.setdefault(record, {})[name] = said.words.setting.format(a=called(name), b=value)
    for record, values in records.items():
        yield _sentence(said.words.record.format(a=called(record), b=said.listed(list(values.values()))))


def _machines(reached: Sequence[typed.Typed], said: Sentences) -> Iterator[str]:
    seen = set()
    for node in reached:
        if not isinstance(node, typed.Machine) or node.symbol.qualified in seen:
            continue
        seen.add(node.symbol.qualified)
        parts = [said.starts(node)]
        for one in node.transitions:
            parts += [said.becomes(one), *said.kept(one)]
        if len(node.transitions) > 1:
            parts.append(said.words.in_order)
        yield _with_meanings(" ".join(parts), said)


def _with_meanings(text: str, said: Sentences) -> str:
    meant = said.meanings()
    return f"{text} {_here(meant, said)}" if meant else text
