"""Up to which value of a number a rule holds: solved, and held against the reference, or found on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading.sheet import Limit
from trackmarshal.reading.solving.algebra import Place, Reason, Unsolvable, place
from trackmarshal.reading.words import Words
from trackmarshal.testing.cases import PreparedTest
from trackmarshal.units import written

CODES = {
    "E491": (
        "a number that the rule does not have",
        "`--solve` names a number that the rule's demand depends on: a field by its name (`v`), by its record (`p.v`), or a parameter.",
    ),
    "E492": (
        "sympy is not installed",
        "Rules are solved for a number with sympy, which is installed by `pip install trackmarshal[solve]`. All other forms do without it.",
    ),
}
#: In how many tests a boundary is looked for.
_TESTS = 3


def solve(
    rule: RuleInfo, spec: Spec, tests: Sequence[PreparedTest], name: str, words: Words
) -> Iterator[Limit]:
    """What is said of each number of a rule that goes by a name: a formula, or what was found in tests of the rule.

    Raises TrackmarshalError E491 where there is none, E492 without sympy.
    """
    try:
        import sympy  # noqa: F401
    except ImportError as error:
        raise TrackmarshalError(
            "E492", "sympy is not installed", help="pip install 'trackmarshal[solve]'"
        ) from error
    for target in _named(rule, spec, name):
        yield from _solved(rule, spec, tests, target, words)


def _named(rule: RuleInfo, spec: Spec, name: str) -> list[Place]:
    """The numbers of a rule that a name stands for."""
    assert rule.typed is not None
    known: dict[str, list[Place]] = {}
    for node in typed.below(rule.typed):
        if isinstance(node, typed.Parameter):
            at_, names = (
                Place("", "", 0, node.symbol.qualified),
                [spec.params[node.symbol.qualified].short, node.symbol.qualified],
            )
        elif isinstance(node, typed.Field):
            try:
                at_ = place(node)
            except Unsolvable:
                continue
            names = [at_.name, f"{at_.record}.{at_.name}"]
        else:
            continue
        for one in names:
            places = known.setdefault(one, [])
            if at_ not in places:
                places.append(at_)
    if name not in known:
        short = [one for one in known if one.count(".") < 2]
        raise TrackmarshalError(
            "E491", f"`{rule.name}` has no number `{name}`", file=str(rule.span.file.path), line=rule.span.line,
            help=close_matches(name, known) or f"it has {', '.join(sorted(short)) or 'none'}",
        )  # fmt: skip
    return known[name]


def _solved(
    rule: RuleInfo, spec: Spec, tests: Sequence[PreparedTest], target: Place, words: Words
) -> Iterator[Limit]:
    from trackmarshal.reading.solving.claims import CHECKED, Solver

    shown = f"{target.record}.{target.name}" if target.record else spec.params[target.name].short
    try:
        solver = Solver(rule, spec, target)
        claimed = [tuple(solver.printed(claim)) for claim in solver.claims()]
        if not claimed:
            raise Unsolvable("unproved")
    except Unsolvable as why:
        yield from _found(rule, spec, tests, target, shown, why.reason, words)
        return
    for formulas in claimed:
        yield Limit(words.solved.format(a=shown, n=f"{CHECKED:,}"), formulas)


def _found(
    rule: RuleInfo, spec: Spec, tests: Sequence[PreparedTest], target: Place, shown: str, reason: Reason, words: Words
) -> Iterator[Limit]:  # fmt: skip
    """What the evaluator says in the inputs of tests."""
    from trackmarshal.reading.solving.boundaries import PLACES, Boundary, boundary
    from trackmarshal.reading.solving.inputs import limits

    said = words.unsolved.format(a=shown, b=words.reasons[reason])
    usable = [
        one
        for one in tests
        if one.rule.name == rule.name and not one.later and one.verdict in ("satisfied", "violated")
    ]
    found: list[Boundary] = []
    bounds = limits(spec, target)
    for test in usable:
        made = boundary(rule, spec, test, target, bounds) if len(found) < _TESTS else None
        if made is not None:
            found.append(made)
    if not found:
        yield Limit(f"{said} {words.untested}", ())
        return
    yield Limit(said, ())
    unit = _unit(spec, target)
    everywhere = f"{target.signal}.{target.name}" if target.record else shown
    for one in found:
        ranges = [
            words.interval.format(a=written(a, unit, "", 9), b=written(b, unit, "", 9)) for a, b in one.holds
        ]
        whole = one.holds == ((one.lower, one.upper),)
        holds = words.everywhere if whole else words.comma.join(ranges) or words.nowhere
        low, high = written(one.lower, unit, "", 9), written(one.upper, unit, "", 9)
        yield Limit(words.found.format(a=one.test, b=everywhere, c=low, d=high, e=holds, n=PLACES), ())


def _unit(spec: Spec, target: Place) -> str:
    """The SI unit of a number."""
    from trackmarshal.units import parse_unit, show

    field = spec.field(target.signal, target.name) if target.record else None
    unit = spec.params[target.name].unit if field is None else field.unit
    return show(parse_unit(unit)[2])
