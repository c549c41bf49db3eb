"""Sets called like members of what generated C remembers of a run: it compiles without a warning, and decides the same.

The names are read off the header itself, so that a member that is added is tried as well.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

import trackmarshal as tm
from support.agreement import compiled
from support.length import at_length
from trackmarshal.backends.c import build
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.record.decided import decided
from trackmarshal.semantics.expressions.calls import built_in_names
from trackmarshal.syntax.keywords import RESERVED

pytestmark = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
STRICT = [
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
    "-ffp-contract=off",
    "-std=c99",
    "-fsyntax-only",
]
HEAD = """module names
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
course gone = ego for 0.4 s then plan
rule slows "" along gone as c require historically[0 s, 0.3 s] c.v <= 24 m/s
"""
#: What a set is asked: each keeps something of its own, back and ahead.
ASKED = (
    "not previous o.x > 4 m",
    "not once[0 s, 1 s] o.x > 4 m",
    "count(o.x > 2 m, last: 1 s) <= 3",
    "always[0 s, 0.2 s] o.x < 6 m",
)
#: The structs of what is remembered of the run, and of what looks ahead.
STRUCTS = ("tm_run", "tm_future")


def text(names: Sequence[str], lasting: bool, doored: bool) -> str:
    """A spec of sets with these names, each with a question, and pairs of neighbours."""
    made = HEAD if doored else "module names\n"
    ending = "capacity 3 forget 1 s" if lasting else "capacity 3"
    for name in names:
        made += f"signal {name} : set of object {{ x: m }} {ending}\n"
    for k, name in enumerate(names):
        made += f'rule q{k} "" for all o in {name} require {ASKED[k % len(ASKED)]}\n'
    for k, (one, other) in enumerate(zip(names[::2], names[1::2])):
        pair = f"for all o in {one} for all p in {other}"
        made += f'rule b{k} "" {pair} where o.x > p.x require not once[0 s, 1 s] o.x > p.x + 5 m\n'
        made += f'rule a{k} "" {pair} require always[0 s, 0.2 s] (o.x < p.x + 9 m or previous o.x > p.x)\n'
    return made


def generated(spec: Spec, doored: bool) -> Source:
    return generate(spec, Evaluator(spec, None, "reference").rules, "made", online=True, doored=doored)


def members(header: str) -> list[str]:
    """The members of these structs that a spec may call a set."""
    found: set[str] = set()
    for struct in STRUCTS:
        begin, end = (
            header.rfind("typedef struct {", 0, header.index(f"}} {struct};")),
            header.index(f"}} {struct};"),
        )
        found |= set(re.findall(r"(\w+)(?:\[[^;]*\])*;", header[begin:end]))
    return sorted(found - RESERVED - {"gone", *built_in_names()})


@pytest.mark.parametrize(
    ("lasting", "doored"),
    [(True, True), at_length(True, False), at_length(False, True), at_length(False, False)],
)
def test_sets_called_like_members(tmp_path: Path, lasting: bool, doored: bool) -> None:
    plain = generated(compiled(text(["aa", "bb", "cc", "dd"], lasting, doored)), doored)
    names = members(plain.header)
    assert {"now", "last", "missed", "parts", "crowded", "future", "pairs_1", "once_2", "t"} <= set(names)
    source = generated(compiled(text(names, lasting, doored)), doored)
    (tmp_path / "made.h").write_text(source.header, encoding="utf-8")
    (tmp_path / "made.c").write_text(source.source, encoding="utf-8")
    compiler = build.compiler()
    assert compiler is not None
    done = subprocess.run(
        [*compiler, *STRICT, "made.c"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[:3000]


def decisions(spec: Spec, names: Sequence[str], backend: str) -> list[list[object]]:
    now, said = 0.0, list[list[object]]()
    supervisor = tm.supervisor(spec, clock=lambda: now, backend=backend, limits={"budget": 60.0})
    plan = {"t": [0.0, 1.0], "x": [0.0, 2.5], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [5.0, 0.0]}
    for number in range(12):
        now = 0.1 * number
        sets = {
            name: {"id": [f"{k}", f"{name}"], "x": [float((number + k) % 7), 0.5 * k]}
            for k, name in enumerate(names)
        }
        signals = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 5.0}, **sets}
        decision = supervisor.step(Cycle(number, now, plan, plan, signals))
        assert decision.faults == ()
        *rest, driving, emergency = decided(decision)
        said.append([*map(repr, rest), *(float(margin).hex() for margin in (*driving, *emergency))])
    return said


def test_they_decide_the_same() -> None:
    names = ["now", "last", "once_2", "pairs_1", "missed", "future", "t", "parts"]
    spec = compiled(text(names, True, True))
    expected = decisions(spec, names, "reference")
    assert len({str(one) for one in expected}) > 3
    assert decisions(spec, names, "c") == expected
