"""Strategies for every node of the syntax tree, as the parser could have built it."""

from __future__ import annotations

from functools import cache

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import CLAUSE_WORDS
from trackmarshal.syntax.keywords import DECLARATIONS, RESERVED
from trackmarshal.units import UNITS

#: Names that are Greek letters, units, words of other clauses, or look like keywords.
_TELLING = (
    "kappa", "mu", "mu_left", "Delta", "pi", "m", "s", "t", "kg", "rad", "about", "at", "as", "zone", "polygon", "linear", "inf",
    "margin", "starts", "when", "each", "sqrt", "set", "of", "trajectory", "requires", "android", "orbit", "inside", "e3",
    "increasing", "default", "clamp", "pose", "bool", *DECLARATIONS,
)  # fmt: skip


@cache
def names() -> SearchStrategy[str]:
    made = st.text("aeinorstZ_", min_size=1, max_size=6).filter(lambda name: name not in RESERVED)
    return st.one_of(st.sampled_from(("a", "b", "p", "v", *_TELLING)), made)


@cache
def predicates() -> SearchStrategy[str]:
    """Names of predicates; one that looks like a clause is refused where it starts a line."""
    # After a number, `to` is what a stretch leads to.
    return names().filter(lambda name: name != "to" and not close_matches(name, CLAUSE_WORDS, 0.75))


@cache
def ids() -> SearchStrategy[str]:
    part = st.text("Ab1o", min_size=1, max_size=3)
    return st.builds(
        lambda head, parts: "-".join((head, *parts)),
        st.sampled_from(["S", "A", "RR", "Ab1"]),
        st.lists(part, min_size=1, max_size=3),
    )


@cache
def labels() -> SearchStrategy[str]:
    return st.one_of(names(), ids())


@cache
def dotted() -> SearchStrategy[str]:
    return st.lists(names(), min_size=1, max_size=3).map(".".join)


@cache
def strings() -> SearchStrategy[str]:
    text = st.text(st.characters(exclude_characters="\n\r", exclude_categories=("Cs", "Cc")), max_size=20)
    return st.one_of(
        text, st.sampled_from(["", "why", '\\"', "a -- b", "\\", 'say "no"', "rule x", "x" * 150])
    )


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
        st.just("1"),
        literal_units(),
        product.map(lambda pair: pair[0] + "".join(sign + part for sign, part in pair[1])),
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
_SHAPES: dict[str, int] = {
    "leaf": 4, "binary": 8, "power": 1, "chained": 2, "unary": 3, "attribute": 2, "call": 3, "infix": 2, "if": 1, "within": 1, "zone": 1,
    "stretch": 1, "temporal": 2, "step": 1, "until": 1, "quantified": 2, "nearest": 1, "counted": 1, "folded": 2, "case": 1,
}  # fmt: skip
_WEIGHTED = [shape for shape, weight in _SHAPES.items() for _ in range(weight)]


@st.composite
def expressions(draw: st.DrawFn, depth: int = 3) -> ast.Expr:
    """Expressions that nest up to `depth` operators deep. (`st.recursive` prints itself, at exponential length.)"""
    shape = "leaf" if depth == 0 else draw(st.sampled_from(_WEIGHTED))

    def inner() -> ast.Expr:
        return draw(expressions(depth - 1))

    match shape:
        case "leaf":
            return draw(_leaves())
        case "binary":
            return ast.Binary(draw(st.sampled_from(_BINARY)), inner(), inner())
        case "chained":
            up = st.lists(st.sampled_from(("<", "<=")), min_size=2, max_size=3)
            ops = draw(st.one_of(up, up.map(lambda ops: [op.replace("<", ">") for op in ops])))
            return ast.Chained(tuple(inner() for _ in range(len(ops) + 1)), tuple(ops))
        case "power":
            return ast.Binary("^", inner(), ast.Number(draw(st.sampled_from("23"))))
        case "unary":
            return ast.Unary(draw(st.sampled_from(["-", "not"])), inner())
        case "attribute":
            return ast.Attribute(inner(), draw(names()))
        case "call":
            return draw(_calls(depth))
        case "infix":
            return ast.Infix(inner(), draw(predicates()), inner())
        case "if":
            return ast.IfElse(inner(), inner(), inner())
        case "case":
            member = names().map(ast.Member)
            some = st.lists(member, min_size=1, max_size=3).map(tuple)
            listed = [ast.Branch(draw(some), inner()) for _ in range(draw(st.integers(1, 3)))]
            listed += [ast.Branch((), inner()) for _ in range(draw(st.integers(0, 1)))]
            return ast.Case(inner(), tuple(listed))
        case "within":
            return ast.Within(inner(), inner(), inner())
        case "zone":
            return ast.InZone(inner(), draw(names()))
        case "stretch":
            if draw(st.booleans()):
                return ast.InStretch(inner(), draw(names()))
            return ast.BetweenStations(inner(), inner(), inner(), inner())
        case "temporal":
            op = draw(st.sampled_from(["always", "eventually", "historically", "once"]))
            return ast.Temporal(op, inner(), draw(_windows(depth)))
        case "step":
            return ast.Temporal(
                draw(st.sampled_from(["next", "previous"])), inner(), None, draw(st.booleans())
            )
        case "until":
            return ast.Until(
                draw(st.sampled_from(["until", "since"])), inner(), inner(), draw(_windows(depth))
            )
        case "quantified":
            quantifier, consecutive = draw(st.sampled_from(["for all", "exists"])), draw(st.booleans())
            where = inner() if draw(st.booleans()) else None
            return ast.Quantified(quantifier, consecutive, draw(_binders()), inner(), where, inner())
        case "nearest":
            quantifier, where = (
                draw(st.sampled_from(["for all", "exists"])),
                inner() if draw(st.booleans()) else None,
            )
            return ast.Quantified(quantifier, False, (draw(names()),), inner(), where, inner(), inner())
        case "counted":
            where = inner() if draw(st.booleans()) else None
            domain = ast.Name(
                draw(names().filter(lambda name: name not in ("zone", "stretch")))
            )  # `a in zone b`, `a in stretch b` are formulas
            return ast.Folded(draw(names()), None, False, (draw(names()),), domain, where, None)
        case "folded":
            where, otherwise = (inner() if draw(st.booleans()) else None for _ in range(2))
            return ast.Folded(
                draw(names()), inner(), draw(st.booleans()), draw(_binders()), inner(), where, otherwise
            )
    raise AssertionError(shape)


@cache
def _binders() -> SearchStrategy[tuple[str, ...]]:
    return st.lists(names(), min_size=1, max_size=3).map(tuple)


@st.composite
def _windows(draw: st.DrawFn, depth: int) -> ast.Window | None:
    if draw(st.booleans()):
        return None
    return ast.Window(draw(expressions(depth - 1)), draw(expressions(depth - 1)))


@st.composite
def _calls(draw: st.DrawFn, depth: int) -> ast.Call:
    function = draw(st.one_of(names(), st.just("sqrt")))
    named = draw(st.lists(st.booleans(), max_size=3))
    arguments = [draw(values(depth - 1)) if name else draw(expressions(depth - 1)) for name in named]
    return ast.Call(function, tuple(arguments), tuple(draw(names()) if name else "" for name in named))


@st.composite
def values(draw: st.DrawFn, depth: int = 2) -> ast.Expr:
    """Expressions, records and lists: what stands in tests and in named arguments."""
    shape = (
        "expression" if depth == 0 else draw(st.sampled_from(["expression", "expression", "record", "list"]))
    )
    if shape == "expression":
        return draw(expressions(depth))
    made = tuple(draw(st.lists(values(depth - 1), max_size=3)))
    return (
        ast.ListValue(made) if shape == "list" else ast.RecordValue(tuple(draw(names()) for _ in made), made)
    )


@cache
def _source_clauses() -> SearchStrategy[ast.SourceClause]:
    numbered = st.builds(
        lambda word, n: f"{word} {', '.join(n)}", names(), st.lists(digits(), min_size=1, max_size=3)
    )
    return st.one_of(
        st.builds(ast.SourceClause, st.none(), strings(), st.just(True)),
        st.builds(ast.SourceClause, name_nodes(), st.one_of(st.just(""), numbered), st.just(False)),
        st.builds(ast.SourceClause, name_nodes(), strings(), st.just(True)),
    )


@cache
def clauses() -> SearchStrategy[ast.Clause]:
    expr = expressions()
    id_lists = st.lists(label_nodes(), min_size=1, max_size=20).map(tuple)
    binder = (st.sampled_from(["for all", "exists"]), st.booleans(), _binders())
    return st.one_of(
        st.builds(ast.Satisfies, id_lists),
        st.builds(ast.Assuming, id_lists),
        _source_clauses(),
        st.builds(ast.Because, strings()),
        st.builds(ast.Severity, names()),
        st.builds(ast.Allow, st.lists(name_nodes(), min_size=1, max_size=9).map(tuple), strings()),
        st.builds(ast.Evidence, strings()),
        st.builds(ast.Owner, strings()),
        st.builds(ast.Bind, *binder, expr, st.one_of(st.none(), expr)),
        st.builds(ast.Except, expr, strings()),
        st.builds(ast.Let, names(), expr),
        st.builds(ast.Along, name_nodes(), names(), st.one_of(st.none(), name_nodes())),
        st.builds(ast.Whenever, expr),
        st.builds(ast.WithinTime, expr),
        st.builds(ast.Require, st.sampled_from(["require", "monitor"]), expr),
    )


@cache
def ranges() -> SearchStrategy[ast.Range | None]:
    return st.one_of(st.none(), st.builds(ast.Range, bounds(), bounds()))


@cache
def _signals() -> SearchStrategy[ast.Signal]:
    kinds = st.sampled_from(["trajectory", "series", "state", "object", "corridor", "polyline", "lane"])
    types = st.one_of(
        units(), st.sampled_from(["polyline", "bool"]), names().filter(lambda n: n not in UNITS)
    )
    defaults = st.one_of(st.none(), bounds(), name_nodes(), st.builds(ast.Boolean, st.booleans()))
    field = st.builds(ast.Field, names(), types, st.booleans(), ranges(), defaults)
    some = st.one_of(st.none(), bounds())
    return st.builds(
        ast.Signal, names(), kinds, st.booleans(), st.lists(field, max_size=12).map(tuple), some, some
    )


def _pairs(least: int) -> SearchStrategy[tuple[tuple[ast.Expr, ast.Expr], ...]]:
    return st.lists(st.tuples(bounds(), bounds()), min_size=least, max_size=9).map(tuple)


@cache
def _param_records() -> SearchStrategy[ast.ParamRecord]:
    entries = st.builds(ast.ParamField, names(), expressions(), ranges(), st.none() | strings())
    shapes = names().filter(lambda n: n not in UNITS) | st.sampled_from(["pose", "moving", "vehicle"])
    return st.builds(ast.ParamRecord, names(), shapes, st.lists(entries, min_size=1, max_size=6).map(tuple))


@cache
def _shapes() -> SearchStrategy[ast.Shape]:
    fields = st.builds(
        ast.Field,
        names(),
        units() | names().filter(lambda n: n not in UNITS) | st.sampled_from(["bool", "polyline"]),
    )
    bases = names() | st.sampled_from(["", "point", "pose", "moving", "body", "vehicle"])
    return st.builds(
        ast.Shape, names(), strings(), bases, st.lists(fields, min_size=1, max_size=9).map(tuple)
    )


@cache
def _tables() -> SearchStrategy[ast.Table]:
    ways = st.builds(ast.Way, st.sampled_from(["linear", "step"]), st.sampled_from(["", "clamp"]))
    ways |= st.builds(ast.Way, st.sampled_from(["linear", "step"]), st.just("wrap"), bounds())
    cells = st.lists(bounds(), min_size=1, max_size=5).map(tuple)
    rows = st.lists(st.tuples(bounds(), cells).map(lambda row: (row[0], *row[1])), min_size=1, max_size=6)
    labels = names().filter(lambda name: name != "inf")  # a row that begins with it is one of values
    second = st.builds(ast.Second, names(), units(), labels, cells)
    second |= st.builds(ast.Second, names(), units(), st.just(""), st.just(()))
    return st.builds(
        ast.Table, names(), names(), units(), units(), rows.map(tuple), st.none() | strings(),
        st.lists(ways, min_size=1, max_size=2).map(tuple), st.none() | second,
    )  # fmt: skip


@cache
def _definitions() -> SearchStrategy[ast.Define]:
    shapes = st.sampled_from(
        ["point", "pose", "moving", "body", "vehicle", "trajectory", "corridor", "polyline"]
    )
    defaults = st.one_of(st.none(), expressions(1))
    one = st.builds(
        ast.Parameter, names(), st.one_of(units(), shapes, names().filter(lambda n: n not in UNITS)), defaults
    )
    parameters = st.lists(one, max_size=4).map(tuple)
    result = st.one_of(st.none(), units())
    return st.one_of(
        st.builds(ast.Define, st.just("define"), names(), parameters, result, expressions()),
        st.builds(ast.Define, st.just("predicate"), names(), parameters, st.none(), expressions()),
    )


@cache
def _states() -> SearchStrategy[ast.State]:
    states = st.lists(st.builds(ast.StateName, names(), st.booleans()), min_size=1, max_size=4).map(tuple)
    word = names().map(ast.Name)
    sources = st.lists(word, max_size=3).map(tuple)
    kept = st.lists(st.builds(ast.Keep, names(), expressions()), max_size=2).map(tuple)
    transitions = st.lists(
        st.builds(ast.Transition, word, sources, expressions(), kept), min_size=1, max_size=3
    ).map(tuple)
    binder = st.one_of(st.just(("", "")), st.tuples(names(), names()))
    return st.builds(
        lambda name, listed, bound, *rest: ast.State(name, listed, *bound, *rest),
        names(), states, binder, word, transitions, st.one_of(st.none(), expressions()),
    )  # fmt: skip


@cache
def _rulebooks() -> SearchStrategy[ast.Rulebook]:
    def chain(names: list[ast.Name], relations: list[str]) -> ast.Chain:
        return ast.Chain(tuple(names), tuple(relations[: len(names) - 1]))

    relations = st.lists(st.sampled_from("~>&"), min_size=15, max_size=15)
    base = st.none() | st.builds(ast.Base, st.sampled_from(("refines", "extends")), names().map(ast.Name))
    chains = st.builds(chain, st.lists(label_nodes(), min_size=1, max_size=15), relations)
    listed = st.lists(chains, min_size=1, max_size=3).map(tuple)
    return st.builds(ast.Rulebook, names(), strings(), base, listed)


@cache
def _tests() -> SearchStrategy[ast.Test]:
    expr = expressions(2)
    index = st.one_of(st.none(), st.integers(0, 99).map(str))
    changes = st.lists(st.builds(ast.Change, names(), index, expr), max_size=3).map(tuple)
    given = st.builds(ast.Given, names(), values(), changes)
    givens = st.lists(st.one_of(given, given, st.builds(ast.After, expressions(1))), max_size=4).map(tuple)
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
        st.builds(ast.Course, names(), name_nodes(), expressions(), name_nodes()),
        st.builds(
            ast.Enum,
            names(),
            strings(),
            st.lists(names().map(ast.Member), min_size=1, max_size=40).map(tuple),
        ),
        st.builds(ast.Param, names(), units(), expressions(), ranges(), optional),
        st.builds(ast.Constrain, expressions(), optional),
        _tables(),
        st.builds(ast.Scale, units(), bounds()),
        _shapes(),
        _param_records(),
        st.builds(ast.Place, st.sampled_from(["zone", "line"]), names(), strings(), places),
        st.builds(ast.Stretch, names(), strings(), expressions(1), expressions(1), expressions(1)),
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
