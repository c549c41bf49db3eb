"""What is bound by `let` and used twice is worked out once: a chain of such, written out, is twice as long with each of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.backends.c.build import compiler
from trackmarshal.cli.main import main
from trackmarshal.evaluation import Evaluator, loads

#: Written out, a sum of 2 ** 200 terms.
DEEP = 200
CHAIN = "".join(f"  let a{i} = a{i - 1} + a{i - 1}\n" for i in range(1, DEEP + 1))
MOST = f"a{DEEP} <= 1e70 m/s"
NEEDS_C = pytest.mark.skipif(compiler() is None, reason="no C compiler")


@pytest.mark.parametrize("backend", ["reference", "numpy", pytest.param("c", marks=NEEDS_C)])
@pytest.mark.parametrize(
    ("signal", "clause", "start", "given"),
    [
        ("signal ego : state { v: m/s }", "", "ego.v", {"ego": {"v": 1.5}}),
        ("signal plan : trajectory { t: s, v: m/s }", "  for all p in plan\n", "p.v", {"plan": {"t": [0.0, 1.0], "v": [1.0, 1.5]}}),
    ],
    ids=["a number", "a sample"],
)  # fmt: skip
def test_a_chain_ends(signal: str, clause: str, start: str, given: object, backend: str) -> None:
    spec = loads(f"module m\n{signal}\nrule r\n{clause}  let a0 = {start}\n{CHAIN}  require {MOST}\n")
    result = Evaluator(spec, None, backend).case({"signals": given}).rules["r"]
    assert result.verdict == "satisfied"
    assert result.margin == 1e70 - 1.5 * 2.0**DEEP


@pytest.mark.parametrize("backend", ["reference", "numpy", pytest.param("c", marks=NEEDS_C)])
def test_a_number_that_a_count_is_compared_with_ends(backend: str) -> None:
    limit = f"{'(' * 60}one{')^2' * 60}"
    spec = loads(f"module m\nevent e\nparam one : 1 = 1\nrule r\n  require count(e) <= {limit}\n")
    evaluator = Evaluator(spec, None, backend)
    result = evaluator.over_run().step(evaluator.read({"t": 0.0, "signals": {"e": True}})).rules["r"]
    assert (result.verdict, result.margin) == ("satisfied", 0.0)


def test_it_is_solved_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, count = tmp_path / "chain.spec", 40
    chain = "".join(f"  let a{i} = a{i - 1} + a{i - 1}\n" for i in range(1, count + 1))
    test = 'test r "t"\n  given ego = { v: 3 m/s }\n  expect satisfied\n'
    path.write_text(
        f"module m\nsignal ego : state {{ v: m/s }}\nrule r\n  let a0 = ego.v\n{chain}  require a{count} <= {2**count * 5} m/s\n{test}", "utf-8"
    )  # fmt: skip
    assert main(["show", "r", "--spec", str(path), "--solve", "v"]) == 0
    assert "v_ego ≤ 5" in capsys.readouterr().out
    assert main(["show", "r", "--spec", str(path), "--draw"]) == 0
    assert capsys.readouterr().out.startswith("<svg")
