"""What is asked again and again is worked out once, and comes to the same: no work is done for objects that stay, nor for what nobody reads."""

from __future__ import annotations

import gc
import math
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.agreement import compiled, read
from support.cycles import cycle
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.source import generated
from trackmarshal.backends.over_run.keeping import past
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.backends.reference.functions import Env, Functions, Number, Value
from trackmarshal.backends.reference.geometry import curvilinear
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir import nodes as ir
from trackmarshal.ir import straight
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.door import lines
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.door.values import numbers
from trackmarshal.runtime.faults import Fault
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.geometry.corridor import Corridor, Polygon
from trackmarshal.runtime.verdict import Truth
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests
from trackmarshal.trace import sections

SPEC = """module made
signal plan : trajectory { t: s increasing, x: m }
signal ego : state { x: m }
signal other : set of object { x: m }
rule r "r"
  for all p in plan
  for all o in other where o.x > ego.x
  require abs(p.x - o.x) + abs(ego.x - o.x) > 1 m
"""


def in_a_process_of_its_own(source: str) -> str:
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    return done.stdout.strip()


SELDOM = """
import gc
from trackmarshal.cli.collecting import seldom
looks = []
{before}
usual, frozen = gc.get_threshold(), gc.get_freeze_count()
gc.callbacks.append(lambda phase, info: looks.append(phase))
with seldom():
    kept = [[] for _ in range(100_000)]
    circle = []
    circle.append(circle)
    del circle
more = [[] for _ in range(usual[0] // 2)]
print(len(looks) // 2, gc.get_threshold() == usual, (gc.get_freeze_count() > 1000) == (frozen > 1000), gc.collect() > 0)
"""


def test_what_stays_of_a_batch_of_work_is_not_looked_through_at_its_end() -> None:
    assert in_a_process_of_its_own(SELDOM.format(before="gc.collect()")) == "0 True True True"


def test_what_others_set_aside_stays_there() -> None:
    said = in_a_process_of_its_own(SELDOM.format(before="gc.collect(); gc.freeze()"))
    assert said.split()[1:3] == ["True", "True"]


AT_THE_END = """
import atexit, gc
class InACircle:
    def __del__(self):
        print("looked through")
atexit.register(lambda: print("ended"))  # what was asked for first comes last
{command}
circle = InACircle()
circle.itself = circle
del circle
"""


def test_what_a_command_leaves_behind_is_not_looked_through_at_its_end() -> None:
    assert in_a_process_of_its_own(AT_THE_END.format(command="")).split() == ["ended", "looked", "through"]
    command = "import trackmarshal.cli.main"
    assert in_a_process_of_its_own(AT_THE_END.format(command=command)) == "ended"


def test_a_cycle_is_read_while_somebody_else_imports_masked_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of which the module is there before what it holds: no cycle ends in an error of that."""
    monkeypatch.setitem(sys.modules, "numpy.ma", ModuleType("numpy.ma"))
    assert numbers(np.array([1.0, 2.0])).tolist() == [1.0, 2.0]
    assert numbers([1, None])[0] == 1.0


def test_cases_are_read_without_importing_masked_arrays() -> None:
    source = """
import sys
import numpy as np
of_numpy = "numpy.ma" in sys.modules  # before its version 2, it imports them itself
import trackmarshal as tm
from trackmarshal.runtime.door.values import is_array, is_masked, numbers
assert numbers(np.array([1, 2])).tolist() == [1.0, 2.0] and is_array(np.zeros(1)) and not is_array([0.0])
before = "numpy.ma" in sys.modules
hidden = np.ma.MaskedArray([1.0, 2.0], [False, True])
assert is_masked(hidden) and is_array(hidden) and not is_masked(np.zeros(1))
print(before == of_numpy, numbers(hidden).tolist())
"""
    assert in_a_process_of_its_own(source) == "True [1.0, nan]"


def test_specs_without_slips_wait_for_no_pattern_of_them() -> None:
    source = (
        f"import sys; from trackmarshal.evaluation import loads; loads({SPEC!r}); "
        "print('trackmarshal.syntax.slips' in sys.modules)"
    )
    assert in_a_process_of_its_own(source) == "False"


def test_the_cycles_of_a_test_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By both evaluators, and with the limit moved either way."""
    path = tmp_path / "made.spec"
    path.write_text(
        "module made\nsignal ego : state { v: m/s }\n"
        'rule calm "calm"\n  require historically[0 s, 1 s] ego.v <= 10 m/s\n'
        'test calm "just as fast"\n  given ego = { v: 10 m/s }\n  after 0.5 s\n  given ego = { v: 5 m/s }\n'
        "  expect satisfied, margin 0 m/s\n"
    )
    made = compile_paths([path])
    tests, found = prepare(made)
    assert found == []
    asked = list[Any]()
    read = Evaluator.read

    def counted(self: Evaluator, raw: Any) -> Frame:
        asked.append(raw)
        return read(self, raw)

    monkeypatch.setattr(Evaluator, "read", counted)
    (outcome,) = run_tests(made.spec, tests)
    assert (outcome.outcome, outcome.message, outcome.unmoved) == ("passed", "", "")
    assert [raw["signals"]["ego"]["v"] for raw in asked] == [10.0, 5.0]


def test_a_long_document_is_known_to_say_something_by_its_beginning(monkeypatch: pytest.MonkeyPatch) -> None:
    looked = []
    legible = sections._legible

    def counted(character: str) -> bool:
        looked.append(character)
        return legible(character)

    monkeypatch.setattr(sections, "_legible", counted)
    assert not sections.silent(b"Nobody reads all of this.\n" * 10_000, markdown=True)
    assert len(looked) < 1000
    assert sections.silent(b"- " * 10_000 + b"T O D O" + b" -" * 10_000)
    assert not sections.silent(b"- " * 10_000 + b"T O D O s" + b" -" * 10_000)


EGO: dict[Any, Any] = {"x": 1.0, "y": 2.0, "heading": 0.5, "v": 3.0, "age": 0.0}


@pytest.mark.parametrize(
    "raw",
    [
        EGO,
        {**EGO, "kappa": 0.0, "a": 1.0},
        {**EGO, "hedaing": 1.0},
        {**EGO, 3: 1.0},
        {**EGO, "x": 1, "more": None},
        {**EGO, "x": None, "more": 1.0},
        {"x": 1.0, "more": 1.0},
    ],
)
def test_a_record_with_unknown_names_is_read_as_by_a_closer_look(raw: dict[Any, Any]) -> None:
    supervised = of_cycles(shipped(), shipped().rules)
    (signal,) = (one for one in supervised.signals if one.name == "ego")
    quickly, closely = list[Fault](), list[Fault]()
    one, other = ColumnsReader(signal).read(raw, quickly), ColumnsReader(signal)._closely(raw, closely)
    assert quickly == closely
    assert one.values.tobytes() == other.values.tobytes()
    assert (one.count, one.ids, one.absent) == (other.count, other.ids, other.absent)


def test_a_record_of_a_cycle_has_what_is_left_out_of_it_above() -> None:
    assert set(cycle(0).signals["ego"]) <= set(EGO)


def test_a_border_of_floats_is_read_without_a_look_at_each_point(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(lines, "points_of")
    raw = [[0.5, -0.0], (math.inf, 2.0), [math.nan, 1e300]]
    found = lines.LineReader().read(raw).points
    assert [repr(number) for number in found.ravel().tolist()] == [
        "0.5",
        "-0.0",
        "inf",
        "2.0",
        "nan",
        "1e+300",
    ]


@pytest.mark.parametrize(
    "raw",
    [
        [],
        [[]],
        [[1.0, 2.0, 3.0]],
        [[1.0, 2.0], [3.0]],
        [[1.0], [2.0, 3.0, 4.0]],
        [[1, 2.0]],
        [[10**400, 2.0]],
        [[1.0, None]],
        [[1.0, True]],
        [["1", 2.0]],
        [1.0, 2.0],
    ],
)
def test_any_other_border_is_read_point_by_point(raw: Any) -> None:
    def told(read: Callable[[Any], Any]) -> object:
        try:
            return repr(read(raw).tolist())
        except lines.NoLineError as error:
            return error.name, error.index, error.message

    assert told(lambda given: lines.LineReader().read(given).points) == told(lines.points_of)


def test_a_point_on_an_axis_is_looked_for_along_a_line_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    closely = curvilinear._project

    def counted(x: float, y: float, line: curvilinear.Line) -> tuple[float, float, float]:
        asked.append((repr(x), repr(y)))
        return closely(x, y, line)

    monkeypatch.setattr(curvilinear, "_project", counted)
    line = curvilinear.Line([(-10.0, 0.0), (0.0, 0.0), (-5.0, 10.0)])
    offsets = [curvilinear.project(5.0, y, line)[1] for y in (0.0, -0.0, 0.0, -0.0)]
    assert offsets == [offsets[0], -offsets[0]] * 2
    assert asked == [("5.0", "0.0"), ("5.0", "-0.0")]


class Counted(Functions):
    """How often each formula and each number is worked out."""

    def __init__(self, often: bool = False) -> None:
        super().__init__(often)
        self.made: Counter[ir.Formula | ir.Num] = Counter()

    def _number(self, node: ir.Num) -> Number:
        of = super()._number(node)

        def counted(case: Reference, env: Env) -> float:
            self.made[node] += 1
            return of(case, env)

        return counted

    def _truth(self, node: ir.Formula) -> Value:
        of = super()._truth(node)

        def counted(case: Reference, env: Env) -> Truth:
            self.made[node] += 1
            return of(case, env)

        return counted


@pytest.mark.parametrize("often", [False, True])
def test_a_formula_is_worked_out_once_for_what_its_own_variables_stand_for(often: bool) -> None:
    spec = compiled(SPEC)
    plan = {"t": [0.0, 1.0, 2.0], "x": [0.0, 1.5, 9.0]}
    others = [{"x": -1.0}, {"x": 2.0}, {"x": 5.0}, {"x": 8.5}]
    (case,) = read(spec, ({"id": 0, "signals": {"plan": plan, "ego": {"x": 0.0}, "other": others}},))
    functions = Counted(often)
    values = Reference(spec, case, functions=functions)
    formula = spec.rules[0].formula
    assert formula is not None
    truth = values.truth(formula, {})
    assert (truth.verdict, truth.margin) == ("satisfied", 1.5)
    compared = sorted(times for node, times in functions.made.items() if isinstance(node, ir.Compare))
    # Whether an element is in range depends on no sample: of 3 x 4 pairs, 4 are asked about; 3 elements are in range of 3 samples.
    assert compared == [4, 9]
    # How far an object is from the vehicle depends on no sample either.
    measured = sorted(times for node, times in functions.made.items() if isinstance(node, ir.Func))
    assert measured == [3, 9]


def test_formulas_that_follow_no_curve_are_not_gone_through_for_data_without_curvatures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []
    closely = straight._straight

    def counted(root: ir.Formula, absent: straight.Fields) -> ir.Formula:
        asked.append(root)
        return closely(root, absent)

    monkeypatch.setattr(straight, "_straight", counted)
    rules = shipped().rules
    absent = straight.curvatures(rules)
    made = [straight.straightened(rule, absent) for rule in rules]
    changed = {
        part
        for rule, one in zip(rules, made)
        for part, other in ((rule.formula, one.formula), (rule.active, one.active))
        if part is not other
    }
    assert set(asked) == changed
    assert 0 < len(changed) < len(rules)


def test_no_grid_is_made_of_what_nobody_looks_for_in_one() -> None:
    corridor = Corridor([[0.0, 2.0], [50.0, 2.0]], [[0.0, -2.0], [50.0, -2.0]])
    assert corridor.centre.project(np.array([1.0]), np.array([0.5]))[1].tolist() == [0.5]
    zone = Polygon([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    assert zone.signed_distance([1.0], [0.5]).tolist() == [0.5]
    for area in (corridor, zone):
        assert area._region is not None
        assert "cells" not in vars(area._region)
    assert corridor.margin_inside(5.0, 0.0, 0.0, 6.0, 0.0, 0.0, 4.0, 2.0).tolist() == [1.0]
    assert "cells" in vars(corridor._region)


@pytest.mark.acceptance
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_c_is_generated_once_for_a_spec_and_not_taken_for_another() -> None:
    """Of many specs that come and go, one like the other, each program judges by its own limit, and each of some of its rules."""
    one = loads(SPEC)
    assert generated(one, one.rules) is generated(one, list(one.rules))
    for metres in range(1, 5):
        spec = loads(SPEC.replace("> 1 m", f"> {metres} m") + 'rule s "s"\n  require ego.x > 3 m\n')
        for rules in (None, ["r"], ["s"]):
            judge = tm.Evaluator(spec, rules, backend="c")
            given = {"plan": {"t": [0.0, 1.0], "x": [0.0, 0.0]}, "ego": {"x": 0.0}, "other": [{"x": 3.0}]}
            found = judge.case({"signals": given}).rules
            assert {name: result.margin for name, result in found.items()} == {
                name: margin for name, margin in {"r": 6.0 - metres, "s": -3.0}.items() if rules is None or name in rules
            }  # fmt: skip
        del spec, judge
        gc.collect()  # whose ids are another's next


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("backend", ["c", "numpy", "reference"])
def test_what_was_put_into_a_spec_since_counts(backend: str) -> None:
    """A spec is held together by maps, in which somebody may have put another parameter, or a field with another range."""
    spec = loads(
        'module m\nsignal ego : state { v: m/s in [0, 50] }\nparam most : m/s = 30 m/s\nrule r "r"\n  require ego.v <= most\n'
    )
    given = {"signals": {"ego": {"v": 20.0}}}
    assert tm.Evaluator(spec, backend=backend).case(given).safe
    other = loads(
        'module m\nsignal ego : state { v: m/s in [0, 15] }\nparam most : m/s = 10 m/s\nrule r "r"\n  require ego.v <= most\n'
    )
    spec.params["m.most"] = other.params["m.most"]
    assert not tm.Evaluator(spec, backend=backend).case(given).safe


def test_cycles_that_are_remembered_share_the_functions_of_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[ir.Formula]()
    of = Functions._truth

    def counted(self: Functions, node: ir.Formula) -> Value:
        made.append(node)
        return of(self, node)

    spec = loads(
        'module made\nsignal ego : state { v: m/s }\nrule calm "calm"\n  require once[0 s, 1 s] ego.v <= 10 m/s\n'
    )
    evaluator = Evaluator(spec, backend="numpy")
    monkeypatch.setattr(Functions, "_truth", counted)
    functions = Functions()
    formula = spec.rules[0].formula
    assert formula is not None
    (leaf,) = [node for node in formula.children() if isinstance(node, ir.Compare)]
    for t in (0.0, 0.5):
        frame = evaluator.read({"t": t, "signals": {"ego": {"v": 20.0}}})
        past(spec, frame, 0, functions).leaf(leaf, ())
    assert made == [leaf]
