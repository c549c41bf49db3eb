"""State machines in runs: an overtaking with its roles, cycle by cycle; in the Supervisor, in replays of lines, and in memory that does not grow."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.backends.over_run.machines import begun, stepped
from trackmarshal.cli.main import main
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.kleene import FALSE
from trackmarshal.runtime.verdict import Truth
from unit.test_supervisor_remembers import Rig, names

BACKENDS = ("reference", "numpy", "c")
#: Who attacks and who defends, from positions, speeds and flags alone.
OVERTAKING = """module t
signal ego : state { x: m, y: m, v: m/s }
signal objects : set of object { x: m, y: m, v: m/s }
event yellow "no overtaking"

state flag : { clear, caution } starts clear
  becomes caution when yellow
  becomes clear when not once[0 s, 0.2 s] yellow

state role : { neutral, offence, defence, final passed } for each o in objects starts neutral
  becomes offence from neutral when o.x - ego.x in [0 m, 30 m] and ego.v > o.v
    remember side = ego.y - o.y
  becomes defence from neutral when ego.x - o.x in [0 m, 30 m] and o.v > ego.v
  becomes passed from offence, defence when abs(o.x - ego.x) > 40 m

predicate attacked(o: point) = role(o) is offence

rule no_attack "Under caution, nobody is attacked for longer than 0.1 s"
  for all o in objects
  require flag is caution implies not (attacked(o) and time_in(role(o)) > 0.1 s)

rule one_side "An attack stays on its side"
  for all o in objects where role(o) is offence
  require abs((ego.y - o.y) - role(o).side) <= 2 m

rule defends "Whoever is attacked does not move over"
  for all o in objects where role(o) is defence
  require abs(ego.y) <= 1 m

rule gone "Whoever is passed stays so"
  for all o in objects where role(o) is passed
  require abs(o.x - ego.x) > 40 m
"""


def test_only_ways_out_of_a_state_are_asked() -> None:
    rule = loads(OVERTAKING).rule("gone")
    assert rule is not None
    assert rule.formula is not None
    (machine,) = {node.machine for node in ir.below(rule.formula) if isinstance(node, ir.InState)}
    asked = []

    def guard(place: int) -> Truth:
        asked.append(place)
        return FALSE

    after = stepped(machine, begun(machine, 0), 1, guard, lambda _: 0.0)
    assert after == begun(machine, 0)
    assert asked == [0, 1]  # nobody passes whom they neither attack nor defend against


def cycle(
    t: float, ego: tuple[float, float, float], objects: dict[str, tuple[float, float, float]], yellow: bool
) -> Any:
    columns = {name: [one[place] for one in objects.values()] for place, name in enumerate(("x", "y", "v"))}
    return {
        "id": t, "t": t,
        "signals": {"ego": dict(zip(("x", "y", "v"), ego)), "objects": {"id": [*objects], **columns}, "yellow": yellow},
    }  # fmt: skip


#: What each cycle is, and what `no_attack`, `one_side`, `defends` and `gone` say of it.
RUN: tuple[tuple[Any, tuple[str, str, str, str]], ...] = (
    (cycle(0.0, (0, 0, 30), {"a": (50, 0, 20), "b": (-60, 0, 40)}, False), ("satisfied", "inactive", "inactive", "inactive")),
    # We come near a: the side on which it is attacked is that of this cycle.
    (cycle(0.1, (0, 3, 30), {"a": (25, 0, 20), "b": (-60, 0, 40)}, False), ("satisfied", "satisfied", "inactive", "inactive")),
    (cycle(0.2, (0, 5.5, 30), {"a": (20, 0, 20), "b": (-60, 0, 40)}, False), ("satisfied", "violated", "inactive", "inactive")),
    # A yellow flag after 0.2 s of attack; b comes near from behind.
    (cycle(0.3, (0, 3, 30), {"a": (15, 0, 20), "b": (-20, 0, 40)}, True), ("violated", "satisfied", "violated", "inactive")),
    # It counts for 0.2 s. a is gone for a cycle, and is another one when it is back.
    (cycle(0.4, (0, 0, 30), {"b": (-10, 0, 40)}, False), ("satisfied", "inactive", "satisfied", "inactive")),
    (cycle(0.5, (0, 0, 30), {"a": (10, 0, 20), "b": (-10, 0, 40)}, False), ("satisfied", "satisfied", "satisfied", "inactive")),
    (cycle(0.6, (0, 0, 30), {"a": (5, 0, 20), "b": (45, 0, 40)}, False), ("satisfied", "satisfied", "inactive", "satisfied")),
    (cycle(0.7, (0, 0, 30), {"b": (30, 0, 40)}, False), ("satisfied", "inactive", "inactive", "violated")),
)  # fmt: skip
RULES = ("no_attack", "one_side", "defends", "gone")


@pytest.mark.parametrize("backend", BACKENDS)
def test_overtaking(backend: str) -> None:
    evaluator = Evaluator(loads(OVERTAKING), backend=backend)
    run = evaluator.over_run()
    for given, wanted in RUN:
        rules = run.step(evaluator.read(given)).rules
        assert tuple(rules[name].verdict for name in RULES) == wanted, given["t"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_lines_of_a_run(backend: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`eval --run`; a line that cannot be read is a gap, after which nothing is known of who could have changed."""
    spec, data = tmp_path / "t.spec", tmp_path / "cycles.jsonl"
    spec.write_text(OVERTAKING, "utf-8")
    lines = [json.dumps(given) for given, _ in RUN]
    command = [
        "eval",
        str(spec),
        "--data",
        str(data),
        "--run",
        "--backend",
        backend,
        "--format",
        "jsonl",
        "--exit-zero",
    ]
    data.write_text("\n".join(lines), "utf-8")
    assert main(command) == 0
    said = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    found = [tuple(one["rules"][name]["verdict"] for name in RULES) for one in said if "rules" in one]
    assert found == [wanted for _, wanted in RUN]
    data.write_text("\n".join([*lines[:3], "{", *lines[4:]]), "utf-8")
    main(command)
    said = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    found = [tuple(one["rules"][name]["verdict"] for name in RULES) for one in said if "rules" in one]
    assert found[:3] == [wanted for _, wanted in RUN[:3]]
    # b was neutral before the gap, and may have been attacked or passed in it since; a, which is new, is known.
    assert found[3][2:] == ("satisfied", "undefined")


def test_an_inline_test_is_the_first_cycle_of_a_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = tmp_path / "t.spec"
    spec.write_text(
        "module t\nevent yellow\nstate flag : { clear, caution } starts clear\n  becomes caution when yellow\n"
        '  becomes clear when not yellow\nrule f "" require flag is clear\n'
        'test f "a flag" given yellow = true expect violated\ntest f "none" given yellow = false expect satisfied\n',
        "utf-8",
    )
    assert main(["test", str(spec)]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("backend", BACKENDS)
def test_both_candidates_start_from_what_was_driven(backend: str) -> None:
    """A state that a candidate would have led to, and which was not driven, is not remembered."""
    rig = Rig(
        'state fast : { no, yes } starts no\n  becomes yes when plan.first.v > 11 m/s\n  becomes no when flag\n'
        'rule slow "" require plan.first.v <= 15 m/s\nrule f "" require fast is no\n', backend,
    )  # fmt: skip
    assert rig.step().safe
    # The driving candidate would make it fast; what is driven is the stored emergency trajectory.
    assert names(rig.step(v=11.2, emergency=10.9)) == [("f", "driving", "violated")]
    assert rig.step().safe


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("refused", ["missed", "broken"])
def test_a_gap_leaves_every_state_open_that_it_may_have_led_to(backend: str, refused: str) -> None:
    rig = Rig(
        'state seen : { no, yes } starts no\n  becomes yes when flag\n  becomes no when flag\nrule f "" require seen is no\n',
        backend,
    )
    assert rig.step().safe
    assert not rig.step(flag=True).safe
    assert rig.step(flag=True).safe
    assert not (rig.missed() if refused == "missed" else rig.step(ego={"x": 0.0})).safe
    if refused == "missed":
        assert rig.step().faults  # its number, and its time, say that one is missing
    for flag in (False, True, False):
        assert {verdict for _, _, verdict in names(rig.step(flag=flag))} == {"undefined"}


def test_memory_does_not_grow() -> None:
    """A machine has one entry a state for each object that is there, whatever the length of the run."""
    evaluator = Evaluator(loads(OVERTAKING), backend="numpy")
    run = evaluator.over_run()
    sizes = []
    for number in range(400):
        there = {f"o{number // 7 % 50}": (20.0, 0.0, 20.0), f"p{number}": (-20.0, 0.0, 40.0)}
        run.step(evaluator.read(cycle(number / 10, (0.0, 0.0, 30.0), there, number % 9 == 0)))
        memory: Any = run._memory
        cells = memory.state.cells
        sizes.append(sum(len(held) for held in cells._held.values()))
        assert all(
            len(possible) <= 4
            for held in cells._held.values()
            for possible in held.values()
            if isinstance(possible, dict)
        )
    assert max(sizes[10:]) == max(sizes[-10:])


def test_generated_c_waits_for_states() -> None:
    """A machine can be asked, and so can operators that look ahead."""
    machine = "module t\nevent e\nstate m : { a, b } starts a\n  becomes b when e\n  becomes a when not e\n"
    for rule in ("m is a", "time_in(m) < 3 s"):
        for asked in (rule, f"eventually[0 s, 1 s] {rule}"):
            assert Evaluator(loads(f'{machine}rule f "" require {asked}\n'), backend="c").program
