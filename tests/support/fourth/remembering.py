"""State machines at random, and what rules ask of them."""

from __future__ import annotations

from dataclasses import replace

from support.fourth.meaning import COMPARISONS, Clause, Formula, Num, Range, comparison
from support.fourth.states import Machine, Way
from support.fourth.writing import ACC, ONE, SPEED, M, S, Scope, Writer

STATES = ("calm", "keen", "wild", "gone")


def machine(writer: Writer, number: int, depth: int) -> Machine:
    """Declared, and from now on asked by what is written; guards ask for those that were declared before."""
    dice = writer.dice
    each = f"e{number}" if dice.random() < 0.6 else ""
    scope = Scope((("ego", "ego"), *([(each, "objects")] if each else [])), time=True, ahead=False)
    states = STATES[: dice.randint(2, 4)]
    ends = dice.random() < 0.3
    # Each state is led to, and out of; the last one may be final.
    pairs = list(zip(states, (*states[1:], states[0])))[: len(states) - ends]
    routes: list[tuple[str, tuple[str, ...]]] = [(after, (before,)) for before, after in pairs]
    for _ in range(dice.randint(0, 2)):
        to = dice.choice(states)
        sources = [one for one in states[: len(states) - ends] if one != to]
        chosen = tuple(
            dice.sample(sources, dice.randint(0 if not ends else min(1, len(sources)), len(sources)))
        )
        if chosen or not ends:
            routes.append((to, chosen))
    dice.shuffle(routes)
    names = [(f"k{number}{i}", dice.choice([M, SPEED, ONE, ACC])) for i in range(dice.randint(0, 2))]
    still = replace(scope, time=False)
    ways = []
    for to, origins in routes:
        noted = [(name, writer.number(dim, still, 1)) for name, dim in names if dice.random() < 0.6]
        ways.append(Way(to, origins, writer.formula(scope, depth), tuple(noted)))
    bridges = writer.time() if dice.random() < 0.6 else None
    made = Machine(f"machine{number}", states, tuple(ways), each, bridges)
    writer.declared.append(made.text)

    def ask(scope: Scope) -> Formula | None:
        given = [name for name, of in scope.records if of == "objects"] if each else [""]
        return asked(writer, made, dice.choice(given), scope) if given else None

    writer.asks.append(ask)
    return made


def plain(writer: Writer, made: Machine, name: str) -> tuple[str, list[Clause], Formula]:
    """A rule that asks a machine and nothing else, so that nothing covers what it says."""
    clauses = [Clause("for all", rng=Range((name,), "objects"))] if made.each else []
    scope = Scope((("ego", "ego"), *((name, "objects") for _ in clauses)))
    require = asked(writer, made, name if made.each else "", scope)
    text = "\n  ".join([f'rule {name} "x"', *(one.text for one in clauses), f"require {require.text}"])
    return text, clauses, require


def asked(writer: Writer, made: Machine, given: str, scope: Scope) -> Formula:
    dice = writer.dice
    numbers = made.numbers
    how = dice.choice(["is", "is", "time", "kept"])
    if how == "is" or (how == "kept" and not numbers):
        return made.is_in(given, dice.choice(made.states))
    number: Num
    if how == "time":
        number = made.time_in(given)
        text, ns = writer.time()
        other = Num(text, 4, S, lambda env: ns / 1e9)
    else:
        number = made.kept(given, dice.choice(sorted(numbers)))
        other = writer.number(number.dim, replace(scope, time=False), 1)
    return comparison(number, dice.choice(COMPARISONS), other)
