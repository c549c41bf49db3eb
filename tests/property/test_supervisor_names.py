"""Names mean nothing: a Supervisor whose spec is written with other names decides the same, with every evaluator and in a process."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest

import trackmarshal as tm
from property.test_fourth_supervisor import OPEN
from support.length import amount
from support.processes import PATIENCE, Served
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir.reads import FOLLOWED, IS_DRIVEN, IS_EMERGENCY
from trackmarshal.ir.spec import Spec
from trackmarshal.process.client import Client
from trackmarshal.process.serving import build
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.contract import ID
from trackmarshal.runtime.cycle import Limits
from trackmarshal.semantics.expressions.calls import built_in_names
from trackmarshal.syntax.keywords import RESERVED

LIMITS = Limits(**OPEN)
needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")
#: Every place in which a spec may say a name of its own, each with a question of each sort.
PLAIN = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, A_field: 1 }
signal ego : state { x: m, y: m, heading: rad, v: m/s, B_field: m }
signal C_state : state { D_field: m/s, E_field: bool }
signal F_set : set of object { G_field: m, D_field: m } capacity 4 forget 0.2 s
signal M_list : series { t: s increasing, G_field: m }
event H_event "e"
param I_param : m = 5 m
define J_define(K_given: m) -> m = K_given + I_param - 5 m
predicate Q_any(K_given: m) = exists o in F_set: o.G_field > K_given
state N_mode : { O_low, P_high } starts O_low
  becomes P_high when Q_any(6 m)
  becomes O_low from P_high when not Q_any(6 m)
state W_each : { X_new, final Y_seen } for each o in F_set starts X_new
  becomes Y_seen when o.G_field > 3 m
rule R_one "x"
  require C_state.D_field < 5 m/s and C_state.E_field and not previous C_state.D_field > 6 m/s and (H_event or always[0 s, 0.2 s] C_state.D_field < 9 m/s)
rule S_two "x"
  for all L_element in F_set
  require J_define(L_element.G_field) < 5 m and not once[0.1 s, 0.3 s] L_element.D_field > 6 m and (next L_element.G_field < 9 m or not H_event)
rule T_three "x"
  for all p in plan
  require p.A_field <= 2
rule U_four "x"
  whenever N_mode is P_high
  require ego.B_field < 3 m
rule Z_five "x"
  for all o in F_set where W_each(o) is Y_seen
  require o.D_field < 6 m
rule V_five "x"
  along M_list as q
  require always[0 s, 1 s] q.G_field <= 6 m
"""
HOLE = re.compile(r"\b[A-Z]_[a-z]+\b")
HOLES = sorted(set(HOLE.findall(PLAIN)))
#: Words of the language that are no keywords, and of what is told, written and generated around a spec.
WORDS = (
    "id", "count", "length", "number", "stamp", "emergency", "driven", "driving", "closed", "present",
    "absent", "value", "track", "left", "right", "signals", "params", "context", "future", "slot", "now", "last", "missed", "parts",
    "crowded", "lives", "run", "frame", "cycle", "state", "rule", "memory", "NULL", "int", "double", "inline", "main", "errno", "self", "None_",
    "lambda", "def", "class", "yield", "import", "print", "len", "object_", "dict", "np", "columns", "keys", "items", "get", "there", "u", "i", "k",
    "place", "first", "second", "hope", "known", "table", "row", "axis", "kappa", "a", "b", "c", "T", "TM_INF", "tm_step", "fault", "reason",
)  # fmt: skip
POOL = [word for word in WORDS if word not in RESERVED and word not in built_in_names()]


def others(seed: int) -> dict[str, str]:
    """Other names, by those of PLAIN. By its name a Supervisor knows what it tells, two events and the trajectory that is followed,
    and by what elements are known again."""
    dice = random.Random(seed)
    while True:
        names = dict(zip(HOLES, dice.sample(POOL, len(HOLES))))
        signals = {names[hole] for hole in ("C_state", "F_set", "M_list")}
        told = names["H_event"] in (IS_EMERGENCY, IS_DRIVEN) or FOLLOWED in signals
        if not told and ID not in (names["D_field"], names["G_field"]):
            return names


def named(names: dict[str, str]) -> Spec:
    return loads(re.sub(HOLE, lambda hole: names[hole[0]], PLAIN))


def decided(spec: Spec, names: dict[str, str], backend: str, seed: int) -> list[Any]:
    """What is said of some cycles, in the words of PLAIN."""
    now = [0.0]
    if backend != "process":
        return said_by(
            tm.supervisor(spec, backend=backend, clock=lambda: now[0], limits=LIMITS), now, names, seed
        )
    rules = Evaluator(spec).rules
    program = build(spec, rules, LIMITS)
    with Served(program) as served:
        client = Client(program.layout, served.channel(), lambda: now[0])
        remote = RemoteSupervisor(spec, rules, client, LIMITS, lambda: now[0], patience=PATIENCE)
        said = said_by(remote, now, names, seed)
        remote.close()
    return said


def said_by(supervisor: Any, now: list[float], names: dict[str, str], seed: int) -> list[Any]:
    meant = {name: hole for hole, name in names.items()}
    dice, said = random.Random(seed), []
    for number in range(24):
        now[0] = 0.1003 * number
        ids = [name for name in (1, 2, 3) if dice.random() < 0.6]
        lengths = [[dice.choice([1.0, 1.0, 3.5, 7.0]) for _ in ids] for _ in range(2)]
        plan = {"t": [0.0, 1.0], "x": [0.0, 4.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [4.0, 4.0]}
        given = {
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 4.0, names["B_field"]: dice.choice([1.0, 4.0])},
            names["C_state"]: {names["D_field"]: dice.choice([4.0, 4.0, 7.0]), names["E_field"]: dice.random() < 0.9},
            names["F_set"]: {"id": ids, names["G_field"]: lengths[0], names["D_field"]: lengths[1]},
            names["M_list"]: {"t": [0.0, 0.4, 0.8], names["G_field"]: [1.0, dice.choice([1.0, 1.0, 7.0]), 1.0]},
            names["H_event"]: dice.random() < 0.5,
        }  # fmt: skip
        driving, emergency = (
            {**plan, names["A_field"]: [1.0, dice.choice([1.0, 1.0, 3.0])]} for _ in range(2)
        )
        decision = supervisor.step(tm.Cycle(number, now[0], driving, emergency, given))
        assert decision.faults == ()
        against = [
            (meant[one.rule], one.candidate, one.verdict, one.margin.hex()) for one in decision.violations
        ]
        said.append((decision.state, sorted(against)))
    return said


@pytest.mark.parametrize(
    ("backend", "seeds"),
    [
        ("numpy", range(amount(3, 100))),
        ("reference", range(amount(2, 30))),
        pytest.param("c", range(amount(1, 30)), marks=needs_compiler),
        pytest.param("process", range(10), marks=[needs_compiler, pytest.mark.acceptance]),
    ],
)
def test_other_names(backend: str, seeds: range) -> None:
    plain = loads(PLAIN)
    same = {hole: hole for hole in HOLES}
    seen = set()
    for seed in seeds:
        names = others(seed)
        expected = decided(plain, same, "numpy", seed)
        assert decided(named(names), names, backend, seed) == expected, (seed, names)
        seen |= {rule for _, against in expected for rule, *_ in against}
    assert seen == {hole for hole in HOLES if f"rule {hole} " in PLAIN}, seen
