"""The compiler's own safeguards: bounds, order, and that nothing is left out silently."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import pytest

from trackmarshal.cli.check import examine
from trackmarshal.diagnostics import text
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.semantics.modules import _modules_below

GOLDEN = Path(__file__).parents[1] / "golden" / "semantics"


def compiled(folder: Path, content: str, name: str = "made") -> Compiled:
    path = folder / f"{name}.spec"
    path.write_text(f"module {name}\n{content}", "utf-8")
    return compile_paths([path], folder)


def codes(result: Compiled) -> list[str]:
    return [found.code for found in result.found]


def nested(inner: str, depth: int) -> str:
    return "abs(" * depth + inner + ")" * depth


def test_what_would_exhaust_the_stack_is_reported_with_its_place(tmp_path: Path) -> None:
    """Each of these is fine by itself; written out into each other they are not."""
    definitions = [f"define d{i}(x: m) -> m = {nested(f'd{i - 1}(x)', 50)}" for i in range(1, 12)]
    head = "signal ego : state { x: m }\ndefine d0(x: m) -> m = x\n"
    result = compiled(
        tmp_path, head + "\n".join(definitions) + '\nrule deep "deep"\n  require d11(ego.x) < 1 m\n'
    )
    assert codes(result) == ["E221"]
    assert result.found[0].span.text.startswith("define d")
    rule = f'rule deep "deep"\n  let y = {nested("d1(ego.x)", 55)}\n  require {nested("d1(ego.y)", 55)} < missing\n'
    shallow = compiled(tmp_path, head + definitions[0] + "\n" + rule, "other")
    assert codes(shallow) == ["E210", "E201"]


def test_a_chain_of_definitions_is_evaluated_as_deep_as_it_may_be(tmp_path: Path) -> None:
    from trackmarshal.evaluation import BACKENDS, Evaluator

    chain = "".join(f"define d{i}(x: m) -> m = d{i - 1}(x) + 1 m\n" for i in range(1, 50))
    content = f'signal ego : state {{ x: m }}\ndefine d0(x: m) -> m = x\n{chain}rule deep "deep"\n  require d49(ego.x) < 50 m\n'
    result = compiled(tmp_path, content)
    assert result.found == ()
    for backend in BACKENDS:
        evaluator = Evaluator(result.spec, None, backend)
        outcome = next(iter(evaluator.evaluate([evaluator.read({"signals": {"ego": {"x": 0.5}}})])))
        assert outcome.rules["deep"].margin == 0.5


@pytest.mark.parametrize(
    "content",
    [
        "param a : m = b\nparam b : m = 1 m\n",
        "param a : m = a\n",
        "param a : m = 1 s\nparam b : m = a\n",
        "param a : m = wrong\n",
        "table a(x: m) -> m = linear clamp | 1 m: 0 m | 0 m: 1 m |\n",
        "zone a = polygon (0 m, 0 m)\n",
        "define a(x: m) -> m = x * x\n",
        "signal a : state { x: m in [3, 2] }\n",
        "constrain 1 m < 2 s\n",
    ],
)
def test_what_is_left_out_of_the_spec_was_reported(content: str, tmp_path: Path) -> None:
    assert codes(compiled(tmp_path, content))


def test_two_errors_that_read_alike_are_both_reported(tmp_path: Path) -> None:
    rules = "".join(f'rule r{i} "r"\n  require ego.v < 3\n' for i in range(5))
    result = compiled(tmp_path, f"signal ego : state {{ v: m/s }}\n{rules}")
    assert codes(result) == ["E301"] * 5


@pytest.mark.parametrize(
    "case", ["rule_in_two_modules", "signals_that_differ", "ambiguous_names", "cycle_of_three"]
)
def test_the_order_of_paths_does_not_change_what_is_found(case: str) -> None:
    folder = GOLDEN / case
    counts = {
        len(examine(compile_paths(order, folder), None))
        for order in permutations(sorted(folder.glob("*.spec")))
    }
    assert len(counts) == 1


def test_files_that_cannot_be_read_do_not_hide_the_errors_of_others(tmp_path: Path) -> None:
    (tmp_path / "a.spec").write_bytes(b"\xff")
    (tmp_path / "b.spec").write_text("module b\nparam x : m = 1 s\n")
    shown = text.render(examine(compile_paths([tmp_path], tmp_path), None))
    assert "error[E004]" in shown
    assert "error[E302]" in shown


def test_the_search_for_similar_modules_has_an_end(tmp_path: Path) -> None:
    for i in range(30):
        folder = tmp_path / f"d{i:02}"
        folder.mkdir()
        for j in range(20):
            (folder / f"m{j}.spec").touch()
    (tmp_path / ".hidden").mkdir()
    (tmp_path / ".hidden" / "x.spec").touch()
    every = _modules_below(tmp_path)
    assert len(every) == 600
    assert "d00.m0" in every
    assert len(_modules_below(tmp_path, most=100)) < 200


def test_a_name_that_is_broken_in_a_used_module_is_not_reported_again(tmp_path: Path) -> None:
    (tmp_path / "parts.spec").write_text("module parts\nparam width : m == 2 m\nrulee odd\n")
    content = 'use parts\nsignal ego : state { x: m }\nrule r "r"\n  require ego.x < width\n'
    assert codes(compiled(tmp_path, content)) == ["E101", "E103"]


@pytest.mark.parametrize(("count", "found"), [(200, []), (400, ["E221"]), (2000, ["E221"])])
def test_a_chain_of_lets_is_as_deep_as_everybody_can_go(tmp_path: Path, count: int, found: list[str]) -> None:
    from trackmarshal.evaluation import BACKENDS, Evaluator

    chain = "".join(f"  let y{i} = y{i - 1} + 1 m\n" for i in range(1, count))
    content = f'signal ego : state {{ x: m }}\nrule deep "deep"\n  let y0 = ego.x\n{chain}  require y{count - 1} < 7 m\n'
    result = compiled(tmp_path, content)
    assert codes(result) == found
    if found:
        assert result.found[0].span.text == 'rule deep "deep"'
        return
    for backend in BACKENDS:
        evaluator = Evaluator(result.spec, backend=backend)
        (one,) = evaluator.evaluate([evaluator.read({"t": 0.0, "signals": {"ego": {"x": 1.0}}})])
        assert one.rules["deep"].margin == 6.0 - count + 1
