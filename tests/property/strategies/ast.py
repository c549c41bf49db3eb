"""Strategies for every node of the syntax tree, as the parser could have built it."""

from __future__ import annotations

from functools import cache

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from trackmarshal.syntax import ast
from trackmarshal.syntax.keywords import DECLARATIONS, RESERVED
from trackmarshal.units import UNITS

#: Names that are Greek letters, units, words of other clauses, or look like keywords.
_TELLING = (
    "kappa", "mu", "mu_left", "Delta", "pi", "m", "s", "t", "kg", "rad", "about", "at", "as", "zone", "polygon", "linear", "inf",
    "margin", "starts", "when", "each", "sqrt", "all", "set", "of", "trajectory", "requires", "android", "orbit", "inside", "e3",
    "increasing", "default", "clamp", "pose", "bool", *DECLARATIONS,
)  # fmt: skip


@cache
def names() -> SearchStrategy[str]:
    made = st.text("aeinorstZ_", min_size=1, max_size=6).filter(lambda name: name not in RESERVED)
    return st.one_of(st.sampled_from(("a", "b", "p", "v", *_TELLING)), made)


@cache
def ids() -> SearchStrategy[str]:
    part = st.text("Ab1o", min_size=1, max_size=3)
    return st.builds(lambda head, parts: "-".join((head, *parts)), st.sampled_from(["S", "A", "RR", "Ab1"]), st.lists(part, min_size=1, max_size=3))


@cache
def labels() -> SearchStrategy[str]:
    return st.one_of(names(), ids())


@cache
def dotted() -> SearchStrategy[str]:
    return st.lists(names(), min_size=1, max_size=3).map(".".join)


@cache
def strings() -> SearchStrategy[str]:
    text = st.text(st.characters(exclude_characters="\n\r", exclude_categories=("Cs", "Cc")), max_size=20)
    return st.one_of(text, st.sampled_from(["", "why", '\\"', "a -- b", "\\", 'say "no"', "rule x", "x" * 150]))


@cache
def digits() -> SearchStrategy[str]:
    return st.one_of(
        st.integers(0, 10**6).map(str),
        st.sampled_from(["2", "3", "1", "0", "0.5", ".5", "1.50", "1e3", "2E-3", "1.5e+10", ".5e1", "007"]),
    )


@cache
def _unit_parts() -> SearchStrategy[str]:
    exponent = st.sampled_from(["", "", "^2", "^3", "^-1", "^22", "^4"])
    return st.builds(str.__add__, st.sampled_from(sorted(UNITS)), exponent)


@cache
def literal_units() -> SearchStrategy[str]:
    """Units of numbers: quotients without products."""
    quotient = st.lists(_unit_parts(), min_size=1, max_size=3).map("/".join)
    return st.one_of(quotient, quotient.map(lambda unit: f"1/{unit}"))


@cache
def units() -> SearchStrategy[str]:
    """Units of declarations."""
    product = st.tuples(_unit_parts(), st.lists(st.tuples(st.sampled_from("*/"), _unit_parts()), max_size=2))
    return st.one_of(
        st.just("1"), literal_units(), product.map(lambda pair: pair[0] + "".join(sign + part for sign, part in pair[1]))
    )


@cache
def numbers() -> SearchStrategy[ast.Number]:
    return st.builds(ast.Number, digits(), st.one_of(st.just(""), literal_units()))


@cache
def name_nodes() -> SearchStrategy[ast.Name]:
    return st.builds(ast.Name, names())


@cache
def label_nodes() -> SearchStrategy[ast.Name]:
    return st.builds(ast.Name, labels())


@cache
def bounds() -> SearchStrategy[ast.Expr]:
    plain = st.one_of(numbers(), st.just(ast.Name("inf")))
    return st.one_of(plain, st.builds(ast.Unary, st.just("-"), plain))


@cache
def _leaves() -> SearchStrategy[ast.Expr]:
    return st.one_of(numbers(), st.builds(ast.Boolean, st.booleans()), name_nodes(), bounds())


_BINARY = ("+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!=", "and", "or", "implies", "iff", "xor")


def _calls(inner: SearchStrategy[ast.Expr]) -> SearchStrategy[ast.Call]:
    argument = st.one_of(st.tuples(st.just(""), inner), st.tuples(names(), st.one_of(inner, values(inner))))
    function = st.one_of(names(), st.just("sqrt"))
    return st.builds(
        lambda function, args: ast.Call(function, tuple(a[1] for a in args), tuple(a[0] for a in args)),
        function,
        st.lists(argument, max_size=3),
    )


def _windows(inner: SearchStrategy[ast.Expr]) -> SearchStrategy[ast.Window | None]:
    return st.one_of(st.none(), st.builds(ast.Window, inner, inner))


def _nested(inner: SearchStrategy[ast.Expr]) -> SearchStrategy[ast.Expr]:
    bounded = st.sampled_from(["always", "eventually", "historically", "once"])
    binder = (st.sampled_from(["for all", "exists"]), st.booleans(), st.lists(names(), min_size=1, max_size=3).map(tuple))
    return st.one_of(
        st.builds(ast.Binary, st.sampled_from(_BINARY), inner, inner),
        st.builds(ast.Binary, st.just("^"), inner, st.sampled_from([ast.Number("2"), ast.Number("3")])),
        st.builds(ast.Unary, st.sampled_from(["-", "not"]), inner),
        st.builds(ast.Attribute, inner, names()),
        _calls(inner),
        st.builds(ast.Infix, inner, names(), inner),
        st.builds(ast.IfElse, inner, inner, inner),
        st.builds(ast.Within, inner, inner, inner),
        st.builds(ast.InZone, inner, names()),
        st.builds(ast.Temporal, bounded, inner, _windows(inner)),
        st.builds(ast.Temporal, st.sampled_from(["next", "previous"]), inner, st.none(), st.booleans()),
        st.builds(ast.Until, st.sampled_from(["until", "since"]), inner, inner, _windows(inner)),
        st.builds(ast.Quantified, *binder, inner, st.one_of(st.none(), inner), inner),
    )


def expressions(max_leaves: int = 12) -> SearchStrategy[ast.Expr]:
    return st.recursive(_leaves(), _nested, max_leaves=max_leaves)


def values(inner: SearchStrategy[ast.Expr]) -> SearchStrategy[ast.Expr]:
    """Records and lists, which stand in tests and in named arguments."""
    return st.recursive(
        inner,
        lambda value: st.one_of(
            st.lists(st.tuples(names(), value), max_size=3).map(
                lambda entries: ast.RecordValue(tuple(e[0] for e in entries), tuple(e[1] for e in entries))
            ),
            st.builds(ast.ListValue, st.lists(value, max_size=3).map(tuple)),
        ),
        max_leaves=4,
    )


@cache
def _source_clauses() -> SearchStrategy[ast.SourceClause]:
    numbered = st.builds(lambda word, n: f"{word} {', '.join(n)}", names(), st.lists(digits(), min_size=1, max_size=3))
    return st.one_of(
        st.builds(ast.SourceClause, st.none(), strings(), st.just(True)),
        st.builds(ast.SourceClause, name_nodes(), st.one_of(st.just(""), numbered), st.just(False)),
        st.builds(ast.SourceClause, name_nodes(), strings(), st.just(True)),
    )


@cache
def clauses() -> SearchStrategy[ast.Clause]:
    expr = expressions()
    id_lists = st.lists(label_nodes(), min_size=1, max_size=20).map(tuple)
    binder = (st.sampled_from(["for all", "exists"]), st.booleans(), st.lists(names(), min_size=1, max_size=3).map(tuple))
    return st.one_of(
        st.builds(ast.Satisfies, id_lists),
        st.builds(ast.Assuming, id_lists),
        _source_clauses(),
        st.builds(ast.Because, strings()),
        st.builds(ast.Severity, names()),
        st.builds(ast.Evidence, strings()),
        st.builds(ast.Owner, strings()),
        st.builds(ast.Bind, *binder, expr, st.one_of(st.none(), expr)),
        st.builds(ast.Except, expr, strings()),
        st.builds(ast.Let, names(), expr),
        st.builds(ast.Along, name_nodes(), names()),
        st.builds(ast.Whenever, expr),
        st.builds(ast.WithinTime, expr),
        st.builds(ast.Require, st.sampled_from(["require", "monitor"]), expr),
    )


@cache
def ranges() -> SearchStrategy[ast.Range | None]:
    return st.one_of(st.none(), st.builds(ast.Range, bounds(), bounds()))


@cache
def _signals() -> SearchStrategy[ast.Signal]:
    kinds = st.sampled_from(["trajectory", "series", "state", "object", "corridor", "polyline"])
    types = st.one_of(units(), st.sampled_from(["polyline", "bool"]))
    field = st.builds(ast.Field, names(), types, st.booleans(), ranges(), st.one_of(st.none(), bounds()))
    return st.builds(ast.Signal, names(), kinds, st.booleans(), st.lists(field, max_size=12).map(tuple))


def _pairs(least: int) -> SearchStrategy[tuple[tuple[ast.Expr, ast.Expr], ...]]:
    return st.lists(st.tuples(bounds(), bounds()), min_size=least, max_size=9).map(tuple)


@cache
def _definitions() -> SearchStrategy[ast.Define]:
    shapes = st.sampled_from(["point", "pose", "moving", "body", "vehicle", "trajectory", "corridor", "polyline"])
    parameters = st.lists(st.builds(ast.Parameter, names(), st.one_of(units(), shapes)), max_size=4).map(tuple)
    result = st.one_of(st.none(), units())
    return st.one_of(
        st.builds(ast.Define, st.just("define"), names(), parameters, result, expressions()),
        st.builds(ast.Define, st.just("predicate"), names(), parameters, st.none(), expressions()),
    )


@cache
def _states() -> SearchStrategy[ast.State]:
    transitions = st.lists(st.builds(ast.Transition, names(), expressions()), min_size=1, max_size=3).map(tuple)
    binder = st.one_of(st.just(("", "")), st.tuples(names(), names()))
    return st.builds(lambda name, bound, *rest: ast.State(name, *bound, *rest), names(), binder, names(), transitions)


@cache
def _rulebooks() -> SearchStrategy[ast.Rulebook]:
    def chain(names: list[ast.Name], relations: list[str]) -> ast.Chain:
        return ast.Chain(tuple(names), tuple(relations[: len(names) - 1]))

    relations = st.lists(st.sampled_from("~>"), min_size=15, max_size=15)
    chains = st.builds(chain, st.lists(label_nodes(), min_size=1, max_size=15), relations)
    return st.builds(ast.Rulebook, names(), strings(), st.lists(chains, min_size=1, max_size=3).map(tuple))


@cache
def _tests() -> SearchStrategy[ast.Test]:
    expr = expressions(6)
    index = st.one_of(st.none(), st.integers(0, 99).map(str))
    changes = st.lists(st.builds(ast.Change, names(), index, expr), max_size=3).map(tuple)
    givens = st.lists(st.builds(ast.Given, names(), values(expr), changes), max_size=3).map(tuple)
    margin = st.one_of(st.just((None, None)), st.tuples(expr, st.one_of(st.none(), expr)))
    quoted_text = st.sampled_from(['"o1"', '""', '"a b"'])
    place = st.one_of(st.just((None, None)), st.tuples(names(), st.one_of(digits(), quoted_text)))
    expect = st.builds(lambda verdict, m, at: ast.Expect(verdict, *m, *at), names(), margin, place)
    return st.builds(ast.Test, labels(), strings(), givens, expect)


@cache
def items() -> SearchStrategy[ast.Item]:
    clause_lists = st.lists(clauses(), max_size=5).map(tuple)
    optional = st.one_of(st.none(), strings())
    places = _pairs(1)
    return st.one_of(
        st.builds(ast.ModuleName, dotted()),
        st.builds(ast.Use, dotted()),
        st.builds(ast.Reference, names(), strings()),
        _signals(),
        st.builds(ast.Event, names(), strings()),
        st.builds(ast.Param, names(), units(), expressions(), ranges(), optional),
        st.builds(ast.Constrain, expressions(), optional),
        st.builds(ast.Table, names(), names(), units(), units(), _pairs(1), optional),
        st.builds(ast.Place, st.sampled_from(["zone", "line"]), names(), strings(), places),
        _definitions(),
        st.builds(ast.Assume, labels(), strings(), clause_lists),
        st.builds(ast.Rule, labels(), strings(), clause_lists),
        _states(),
        _rulebooks(),
        _tests(),
    )


@cache
def modules() -> SearchStrategy[ast.Module]:
    return st.builds(ast.Module, st.lists(items(), max_size=5).map(tuple), st.booleans())


#: Comments to put into generated texts.
COMMENTS = ("--", "-- why", '-- a "quoted', "--- )", "--rule x", "-- | }  ", "-- ≤ κ")
