"""The typed tree keeps what is written, with names resolved, dimensions and spans."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest

from support import written
from support.generated import RandomChoices, laws, subject
from trackmarshal import typed
from trackmarshal.node import Node
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.source import NOWHERE
from trackmarshal.syntax import ast
from trackmarshal.units import ACCELERATION, LENGTH, NUMBER, SPEED

ROOT = Path(__file__).parents[2]
HEAD = """module made
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s, a: m/s^2, hot: bool }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m }
signal track : corridor
event blue_flag "shown"
param top : m/s = 180 km/h
table ax_max(v: m/s) -> m/s^2 = linear clamp
  | 0 m/s: 6 m/s^2 | 50 m/s: 2 m/s^2 |
define ahead(p: moving, o: moving) -> m = (o.x - p.x) + 0 m
predicate behind(o: moving, p: moving) = ahead(o, p) > 0 m
"""
RULE = """rule whole "everything"
  whenever blue_flag
  along plan as p
  for all o in objects where o.v >= 1 m/s
    except o behind p "it looks out for itself"
  let fast = p.v^2 / 2
  require always[0 s, 1 s] (p.v > top implies rising(p.hot) or 0 m <= ahead(p, o) < 5 m)
      and p.a in [-8 m/s^2, ax_max(p.v)] and fast < 100 m^2/s^2 and clear_of(swept_footprint(p, 5 m, 2 m), footprint(o))
"""


def compiled(folder: Path, text: str) -> Compiled:
    path = folder / "made.spec"
    path.write_text(text, "utf-8")
    made = compile_paths([path], folder)
    assert [found.code for found in made.errors] == []
    return made


def rules(made: Compiled) -> Iterator[tuple[typed.Rule, ast.Rule | ast.Assume]]:
    """The typed rules, each with its syntax tree."""
    for name in made.order:
        for item in made.library.modules[name].tree.items:
            if not isinstance(item, (ast.Rule, ast.Assume)):
                continue
            rule = made.spec.rule(item.name)
            if rule is not None and rule.typed is not None:
                yield rule.typed, item


def of_kind(root: typed.Typed, kind: type) -> list[typed.Typed]:
    return [node for node in typed.below(root) if isinstance(node, kind)]


def test_every_node_is_in_one_of_the_unions() -> None:
    bases = {
        typed.Typed, typed.NumberNode, typed.FormulaNode, typed.SignalNode, typed.RecordNode, typed.LineNode, typed.AreaNode,
        typed.RegionNode, typed.MemberNode,
    }  # fmt: skip
    classes = {
        made for made in vars(typed).values() if inspect.isclass(made) and issubclass(made, typed.Typed)
    } - bases
    kinds = [
        set(get_args(typed.Value)),
        set(get_args(typed.Clause)),
        {
            typed.Range,
            typed.TheRun,
            typed.Window,
            typed.Machine,
            typed.Transition,
            typed.Keep,
            typed.Rule,
            typed.NumberBranch,
            typed.FormulaBranch,
        },
    ]
    assert set.union(*kinds) == classes
    assert sum(map(len, kinds)) == len(classes)
    assert all(made.__doc__ and issubclass(made, Node) for made in classes)
    assert all(made.fields[-1] == "span" for made in classes - {typed.TheRun})  # which is written nowhere


def test_nothing_of_the_shipped_rules_is_lost() -> None:
    made = compile_paths([ROOT / "specs"], ROOT)
    pairs = list(rules(made))
    assert len(pairs) == sum(rule.formula is not None for rule in made.spec.rules) > 30
    assert [found for rule, item in pairs for found in written.differences(rule, item)] == []


@pytest.mark.parametrize("seed", range(12))
def test_nothing_of_made_up_rules_is_lost(seed: int, tmp_path: Path) -> None:
    choices = RandomChoices(30_000 + seed)
    text = (
        laws(choices).text if seed % 4 == 3 else subject(choices, inexact="any", geometry=seed % 2 == 0).text
    )
    pairs = list(rules(compiled(tmp_path, text)))
    assert pairs
    assert [found for rule, item in pairs for found in written.differences(rule, item)] == []


def test_a_deadline_is_kept_as_it_is_written(tmp_path: Path) -> None:
    ego = "signal ego : state { v: m/s }\n"
    rule = 'rule soon "soon"\n  whenever blue_flag\n  within 5 s\n  require ego.v < top\n'
    ((made, item),) = rules(compiled(tmp_path, HEAD + ego + rule))
    assert [type(clause).__name__ for clause in made.clauses] == ["Whenever", "Deadline", "Require"]
    assert written.differences(made, item) == []


def test_clauses_stand_in_the_order_written_and_exceptions_with_their_reasons(tmp_path: Path) -> None:
    ((rule, item),) = rules(compiled(tmp_path, HEAD + RULE))
    assert written.differences(rule, item) == []
    assert [type(clause).__name__ for clause in rule.clauses] == [
        "Whenever", "Along", "ForEach", "Except", "Let", "Require",
    ]  # fmt: skip
    each = rule.clauses[2]
    assert isinstance(each, typed.ForEach)
    left_out = rule.clauses[3]
    assert isinstance(left_out, typed.Except)
    assert left_out.of is each
    assert left_out.reason == "it looks out for itself"
    assert left_out.condition.span.text == "o behind p"
    along = rule.clauses[1]
    assert isinstance(along, typed.Along)
    assert (along.range.depth, each.range.depth) == (0, 1)
    for node in typed.below(rule.condition):
        if isinstance(node, (typed.Temporal, typed.Edge)):
            assert node.axis is along.range


def test_definitions_tables_parameters_and_names_are_still_there(tmp_path: Path) -> None:
    ((rule, _),) = rules(compiled(tmp_path, HEAD + RULE))
    calls = of_kind(rule, typed.CalledNumber)
    assert [node.symbol.qualified for node in calls if isinstance(node, typed.CalledNumber)] == [
        "made.ahead"
    ] * 2
    (behind,) = of_kind(rule, typed.CalledFormula)
    assert isinstance(behind, typed.CalledFormula)
    assert behind.infix
    assert behind.body.span.text == "ahead(o, p) > 0 m"
    inner = next(node for node in of_kind(behind.body, typed.NamedRecord))
    assert isinstance(inner, typed.NamedRecord)
    assert (inner.name, inner.kind) == ("o", "moving")
    assert inner.value in behind.arguments
    assert [
        node.span.text for node in of_kind(rule, typed.Parameter) if isinstance(node, typed.Parameter)
    ] == ["top"]
    assert len(of_kind(rule, typed.TableValue)) == 1
    let = next(clause for clause in rule.clauses if isinstance(clause, typed.Let))
    uses = [
        node for node in of_kind(rule.condition, typed.NamedNumber) if isinstance(node, typed.NamedNumber)
    ]
    assert [(use.name, use.value, use.span.text) for use in uses if use.span.text == use.name == "fast"] == [
        ("fast", let.value, "fast")
    ]


def test_every_number_has_its_dimension_and_the_unit_it_is_written_in(tmp_path: Path) -> None:
    ((rule, _),) = rules(compiled(tmp_path, HEAD + RULE))
    found = {}
    for node in typed.below(rule):
        if isinstance(node, typed.NumberNode):
            found[node.__dict__["span"].text] = (node.dimension, node.written)
    assert found["top"] == (SPEED, "km/h")
    assert found["p.v^2"] == ((LENGTH[0] * 2, SPEED[1] * 2, LENGTH[2]), "")
    assert found["ax_max(p.v)"] == (ACCELERATION, "m/s^2")
    assert found["ahead(p, o)"] == (LENGTH, "m")
    assert found["2"] == (NUMBER, "")


def test_everything_has_a_place_in_a_file() -> None:
    made = compile_paths([ROOT / "specs"], ROOT)
    files = {module.file.path for module in made.library.modules.values()}
    for rule, _ in rules(made):
        for node in typed.below(rule):
            if isinstance(node, typed.TheRun):  # which is written nowhere
                continue
            span = node.__dict__["span"]
            assert span is not NOWHERE
            assert span.file.path in files
            if isinstance(node, typed.Literally):
                assert span.text.startswith(node.text)


def test_what_is_shared_is_looked_at_once(tmp_path: Path) -> None:
    """Names for names: written out, the last one is 2^60 numbers."""
    lets = "".join(f"  let d{k} = d{k - 1} + d{k - 1}\n" for k in range(1, 60))
    text = f'{HEAD}rule r "r"\n  let d0 = plan.first.v\n{lets}  require d59 < 1 m/s\n'
    ((rule, _),) = rules(compiled(tmp_path, text))
    assert sum(1 for _ in typed.below(rule)) < 400
