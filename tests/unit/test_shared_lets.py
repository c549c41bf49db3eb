"""What is bound by `let` and used twice is worked out once: a chain of such, written out, is twice as long with each of them."""

from __future__ import annotations

import pytest

from trackmarshal.backends.c.build import compiler
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
