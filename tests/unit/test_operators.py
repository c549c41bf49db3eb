"""The table of operators and the closed unions of nodes: what is in them, everybody knows; what is not, nobody takes."""

from __future__ import annotations

import inspect
import math
import struct
from itertools import product
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from support.agreement import compiled
from trackmarshal import typed
from trackmarshal.backends.c import build, parts
from trackmarshal.backends.c.functions.operators import called
from trackmarshal.backends.c.layout import layout
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.source import generate
from trackmarshal.backends.numpy import steps
from trackmarshal.backends.witness import Descent
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import arithmetic, operators
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import COMPARISONS, FUNCTIONS, Dimensions
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime import kleene
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.semantics.expressions.calls import built_in_names

HEAD = "module ops\nsignal ego : state { a: 1, b: 1 }\nsignal trace : series { t: s increasing, u: 1 }\n"
VALUES = (0.0, -0.0, 0.3, -0.5, 0.5, 1.0, -1.0, 1.5, 2.5, -2.5, 3.0, 1e200, math.inf, -math.inf, math.nan)


def bits(value: float) -> bytes:
    return struct.pack("<d", math.nan if math.isnan(value) else value)


def of_kind(kind: object) -> set[str]:
    return set(get_args(kind))


@pytest.mark.parametrize(
    ("kind", "table"),
    [
        (operators.FunctionName, operators.FUNCTIONS), (operators.ComparisonOp, operators.COMPARISONS),
        (operators.ArithmeticOp, operators.ARITHMETIC), (operators.ConnectiveOp, operators.CONNECTIVES),
        (operators.Quantifier, operators.QUANTIFIERS), (operators.TemporalOp, operators.TEMPORAL),
        (operators.UntilOp, operators.UNTIL), (typed.Comparing, typed.COMPARISONS), (typed.Joining, typed.CONNECTIVES),
        (typed.Stepping, typed.STEPS), (typed.Changing, typed.EDGES),
    ],
)  # fmt: skip
def test_every_name_has_an_entry(kind: object, table: object) -> None:
    assert of_kind(kind) == set(table)  # type: ignore[call-overload]


def test_every_node_is_in_one_of_the_unions() -> None:
    classes = {
        made
        for made in vars(ir).values()
        if inspect.isclass(made) and issubclass(made, ir.IR) and made is not ir.IR
    }
    kinds = [set(get_args(kind)) for kind in (ir.Num, ir.Formula)] + [{ir.Axis, ir.Line, ir.Area, ir.Machine}]
    assert set.union(*kinds) == classes == set(get_args(ir.AnyNode))
    assert sum(map(len, kinds)) == len(classes)


def calls() -> str:
    """A spec with a rule for every function of the table, and one along a timeline, so that monitors have it, too."""
    rules = []
    for name, function in FUNCTIONS.items():
        args = ", ".join(("ego.a", "ego.b")[: function.arity])
        # The value itself is the margin's better part: whatever is not finite is undefined on all sides.
        rules.append(f'rule r_{name} "made up"\n  require {name}({args}) >= 0\n')
        inner = ", ".join(("p.u", "0.5")[: function.arity])
        rules.append(
            f'rule t_{name} "made up"\n  along trace as p\n  require historically {name}({inner}) > 0\n'
        )
    return HEAD + "".join(rules)


@pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
def test_every_function_of_the_table_is_in_the_language_and_in_every_evaluator() -> None:
    spec = compiled(calls())
    assert {rule.name for rule in spec.rules} == {f"{k}_{name}" for name in FUNCTIONS for k in "rt"}
    reference, numpy = Evaluator(spec, None, "reference"), Evaluator(spec, None, "numpy")
    program = CProgram(spec, reference.rules)
    assert len(generate(spec, reference.rules, online=True).monitors) == len(FUNCTIONS)
    raw = [
        {"signals": {"ego": {"a": a, "b": b}, "trace": {"t": [0.0, 1.0], "u": [a, b]}}}
        for a, b in product(VALUES, VALUES)
        if not (math.isnan(a) or math.isnan(b))
    ]
    cases = [reference.read(case) for case in raw]
    runs = program.rate_all(cases)
    evaluated = zip(reference.evaluate(cases), numpy.evaluate(cases), runs, strict=True)
    for index, (one, two, run) in enumerate(evaluated):
        for rule in reference.rules:
            wanted, fast = one.rules[rule.name], two.rules[rule.name]
            given = VERDICTS[run.verdicts[program.number(rule)]], run.margins[program.number(rule)]
            at = (rule.name, raw[index])
            assert (given[0], bits(given[1])) == (wanted.verdict, bits(wanted.margin)), at
            assert fast.verdict == wanted.verdict, at
            if FUNCTIONS[rule.name[2:]].libm and math.isfinite(wanted.margin):  # type: ignore[index]
                assert fast.margin == pytest.approx(wanted.margin, rel=1e-14, abs=1e-300), at
            else:
                assert bits(fast.margin) == bits(wanted.margin), at


def test_what_is_not_in_the_table_nobody_takes() -> None:
    """Least of all C, which would leave such a rule to another evaluator."""
    spec = compiled(HEAD + 'rule r "made up"\n  require tanh(ego.a) >= 0\n')
    rule = spec.rules[0]
    assert isinstance(rule.formula, ir.Compare)
    compare = rule.formula
    odd = ir.Compare("<=", compare.left, ir.Func("sinh", compare.right.args), "1", compare.span)  # type: ignore
    with pytest.raises(AssertionError, match="sinh"):
        generate(spec, [changed(rule, odd)])
    for function in (steps._function, arithmetic._function, called):
        with pytest.raises(AssertionError, match="sinh"):
            function("sinh")  # type: ignore[arg-type]
    nand = ir.Connective("nand", compare, compare)  # type: ignore[arg-type]
    with pytest.raises(AssertionError, match="nand"):
        generate(spec, [changed(rule, nand)])
    with pytest.raises(AssertionError, match="nand"):
        kleene.connect("nand", kleene.TRUE, kleene.TRUE)  # type: ignore[arg-type]


def test_a_node_outside_the_unions_nobody_takes() -> None:
    class Sorcery(ir.IR):
        pass

    spec = compiled(HEAD + 'rule r "made up"\n  require tanh(ego.a) >= 0\n')
    with pytest.raises(AssertionError, match="Sorcery"):
        layout(spec, [changed(spec.rules[0], Sorcery())])  # type: ignore[arg-type]
    with pytest.raises(AssertionError, match="Sorcery"):
        Descent(None).find(Sorcery())  # type: ignore[arg-type]


def changed(rule: RuleInfo, formula: ir.Formula) -> RuleInfo:
    fields = {**rule.__dict__, "formula": formula, "active": None}
    return RuleInfo(*(fields[name] for name in RuleInfo.fields))


def test_a_function_is_compiled_as_a_call_of_libm_where_the_table_says_so() -> None:
    """Else the compiler would compute it, of constants, with its own digits."""
    flags = {flag.removeprefix("-fno-builtin-") for flag in build.EXACT if flag.startswith("-fno-builtin-")}
    assert flags == {name for name, function in FUNCTIONS.items() if function.libm}
    assert flags == {"sin", "cos", "tan", "asin", "acos", "atan2", "tanh", "exp", "log", "pow"}


def test_functions_of_our_own_are_there() -> None:
    for name in FUNCTIONS:
        function, _ = called(name)
        assert not function.startswith("tm_") or function in parts.functions()


def test_every_file_of_c_is_listed() -> None:
    """Its functions would be in no program."""
    folder = Path(parts.__file__).parent
    there = {path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.c")}
    assert there == {*parts.FILES, parts.STEP.stem}


@pytest.mark.parametrize("op", COMPARISONS)
def test_what_holds_at_zero_is_what_the_comparison_says(op: operators.ComparisonOp) -> None:
    assert arithmetic.compare(op, 1.0, 1.0) is COMPARISONS[op].holds_at_zero
    for a, b in ((1.0, 2.0), (2.0, 1.0)):
        assert arithmetic.compare(op, a, b) is (arithmetic.margin(op, a, b) > 0.0)


def spec_of(expression: str, unit: str) -> Spec:
    head = f"module dims\nsignal ego : state {{ a: {unit}, b: {unit} }}\n"
    return compiled(f'{head}rule r "made up"\n  require {expression}\n')


@pytest.mark.parametrize("name", FUNCTIONS)
def test_dimensions(name: operators.FunctionName) -> None:
    """Of metres: a function keeps them, takes their root, drops them, or wants plain numbers."""
    function = FUNCTIONS[name]
    call = f"{name}({', '.join(('ego.a', 'ego.b')[: function.arity])})"
    assert name in built_in_names()
    for unit, given in (("1", "0"), ("m^2", "0 m^2")):
        wanted = {
            Dimensions.KEPT: given, Dimensions.DROPPED: "0", Dimensions.PLAIN: "0" if unit == "1" else None,
            Dimensions.ROOT: "0" if unit == "1" else "0 m",
        }[function.dimensions]  # fmt: skip
        if wanted is None:
            with pytest.raises(Exception, match="plain number"):
                spec_of(f"{call} >= 0", unit)
        else:
            assert spec_of(f"{call} >= {wanted}", unit).rules


def test_arguments_of_hypot_have_one_dimension() -> None:
    with pytest.raises(Exception, match="take the hypot of"):
        compiled(
            'module dims\nsignal ego : state { a: m, b: s }\nrule r "made up"\n  require hypot(ego.a, ego.b) >= 0 m\n'
        )


def test_neutral_elements_change_nothing() -> None:
    for extreme, join in ((operators.Extreme.LEAST, min), (operators.Extreme.GREATEST, max)):
        holds, margin = extreme.neutral
        assert [join(holds, value) for value in (False, True)] == [False, True]
        assert [join(margin, value) for value in (-1.0, 2.0)] == [-1.0, 2.0]


def test_whole_numbers_keep_the_sign_of_zero_in_numpy_too() -> None:
    for name in ("floor", "ceil", "round"):
        for x in (-0.0, 0.0, -0.3, 0.3, -0.5, 0.5, 1.5, 2.5, -2.5, 1e300, math.inf):
            wanted = arithmetic.apply(name, [x])
            assert bits(float(steps.CALLS[name](np.float64(x)))) == bits(wanted), (name, x)
