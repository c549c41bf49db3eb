"""Emitted C whose rules remember, as a whole: the example that reads cycles, the process with its client in C, and the rules alone."""

from __future__ import annotations

import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle, mutate
from support.decision_lines import decision_lines
from support.emitted import emit
from support.length import AT_LENGTH, shared_out
from support.processes import PATIENCE, Served
from support.remembering import remembering
from support.sanitized import FLAGS as SANITIZED
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.process.client import Border, Client
from trackmarshal.process.serving import build
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Cycle, Limits

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")

FLAGS = ["-std=c99", "-O0", "-ffp-contract=off", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror"]


def cycles(count: int) -> list[Cycle | None]:
    """Some are broken, some do not come; objects come and go."""
    rng, found = random.Random(5), list[Cycle | None]()
    for number in range(count):
        given: Cycle | None = cycle(number, 1 + (number // 7) % 4, 1 + number % 3)
        if number % 11 == 2 and given is not None:
            given = mutate(rng, given)[0]
        found.append(None if number % 50 == 20 else given)
    return found


def test_a_process_remembers(tmp_path: Path) -> None:
    spec, now, limits = remembering(tmp_path, pairs=True), 0.0, Limits(budget=1e9)
    rules = Evaluator(spec).rules
    program = build(spec, rules, limits)
    with Served(program, False) as served:
        client = Client(program.layout, served.channel(), lambda: now)
        remote = RemoteSupervisor(spec, rules, client, limits, lambda: now, patience=PATIENCE)
        local = CSupervisor(spec, rules, limits, lambda: now)
        safe = 0
        for number, given in enumerate(cycles(200)):
            now = number * PERIOD
            said = remote.step(given)
            assert list(decision_lines(said)) == list(decision_lines(local.step(given)))
            safe += said.safe
        remote.close()
    assert 10 <= safe < 190


@pytest.mark.parametrize(
    ("count", "ids"), shared_out([(2, [7, 7]), (2, []), (2, None), (2, [7]), (1, None), (1, [7, 8])], 6),
    ids=["alike", "empty", "none", "too few", "none of one", "too many"],
)  # fmt: skip
def test_a_client_that_does_not_say_which_is_which(count: int, ids: list[int] | None, tmp_path: Path) -> None:
    """Rules know elements again by their ids: where not each of them has one of its own, the cycle is refused."""
    spec, limits, now = remembering(tmp_path, pairs=True), Limits(budget=1e9), 0.0  # as above: compiled once
    program = build(spec, Evaluator(spec, None, "c").rules, limits)
    with Served(program, False) as served:
        client = Client(program.layout, served.channel(), lambda: now)
        found = []
        for number, given_ids in enumerate(([7, 8][:count], ids)):
            now, given = number * PERIOD, cycle(number, count)
            signals: dict[str, Any] = {
                name: {key: value for key, value in given.signals[name].items() if key != "id"}
                for name in ("ego", "objects", "obstacles")
            }
            signals["obstacles"]["id"] = range(len(signals["obstacles"]["x"]))
            if given_ids is not None:
                signals["objects"]["id"] = given_ids
            signals["track"] = {side: Border(given.signals["track"][side]) for side in ("left", "right")}
            sent = client.send(number, now, given.driving, given.emergency, signals)
            answer = client.answer(sent, PATIENCE)
            assert answer is not None
            found.append(
                {program.layout.faults[name] for name in answer["reason_name"][: answer["reason_count"]]}
            )
    assert not {"missing", "duplicate"} & found[0]
    assert {"missing", "duplicate"} & found[1]


@pytest.mark.acceptance
def test_the_example_and_the_client_in_c(tmp_path: Path) -> None:
    """Both say of a record of a run what Python decided, and compile without a warning."""
    spec, now, expected = remembering(tmp_path, pairs=True), 0.0, list[str]()
    recorded = tm.supervisor(
        spec, backend="numpy", limits=Limits(budget=1e9), clock=lambda: now, record=tmp_path / "run.arrows"
    )
    for number, given in enumerate(cycles(200)):
        now = number * PERIOD
        expected += decision_lines(recorded.step(given))
    recorded.close()
    own = tmp_path / "specs" / "supervisor"
    made = emit(tmp_path / "out", "--process", recordings=[tmp_path / "run.arrows"], spec=own, root=tmp_path)
    subprocess.run(["cc", *FLAGS, "-c", *[path.name for path in made.glob("*.c")]], cwd=made, check=True)
    for name, units in {
        "process": ("desk", "mailbox", "messages", "process"),
        "client": ("client", "client_example", "cycles", "mailbox", "messages"),
        "example": ("main", "cycles"),
    }.items():
        objects = [f"{unit}.o" for unit in ("supervisor", *units)]
        subprocess.run(["cc", "-o", name, *objects, "-lm"], cwd=made, check=True)
    example = subprocess.run(
        [made / "example", made / "run.cycles"], capture_output=True, text=True, check=True
    )
    if AT_LENGTH:
        command = ["cc", *FLAGS, *SANITIZED, "supervisor.c", "main.c", "cycles.c", "-o", "sanitized", "-lm"]
        subprocess.run(command, cwd=made, check=True)
        again = subprocess.run(
            [made / "sanitized", made / "run.cycles"], capture_output=True, text=True, check=True
        )
        assert (again.stdout, again.stderr) == (example.stdout, "")
    decisions = [line.split() for line in example.stdout.splitlines() if line.startswith("decision ")]
    wanted = [line.split() for line in expected if line.startswith("decision ")]
    assert [words[:2] for words in decisions] == [words[:2] for words in wanted]
    assert len({words[1] for words in wanted}) >= 2
    process = subprocess.Popen(
        [made / "process", "--shm", made / "memory", "--simulated"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("serves ")
        said = subprocess.run(
            [made / "client", made / "run.cycles", "--shm", made / "memory"],
            capture_output=True,
            text=True,
            check=True,
        )
    finally:
        process.kill()
        process.communicate()
    mine = [line for line in said.stdout.splitlines() if "?" not in line.split()]
    theirs = set(example.stdout.splitlines())
    assert len(mine) > 200
    assert all(line in theirs for line in mine)


def test_rules_alone(tmp_path: Path) -> None:
    """The check that is emitted for rules by themselves compiles and runs."""
    spec = tmp_path / "m.spec"
    spec.write_text(
        "module m\nsignal ego : state { v: m/s }\nsignal objects : set of object { x: m }\nevent flag\n"
        'rule a "" require not once[0 s, 1 s] flag\nrule b "" for all o in objects require weak previous o.x < 100 m\n'
        'rule c "" require count(ego.v > 1 m/s, last: 2 s) <= 3\n',
        encoding="utf-8",
    )
    made = emit(tmp_path / "out", recordings=[], spec=spec, root=tmp_path)
    subprocess.run(["cc", *FLAGS, "supervisor.c", "main.c", "-o", "check", "-lm"], cwd=made, check=True)
    said = subprocess.run([made / "check"], capture_output=True, text=True, check=True).stdout
    assert [line.split()[:2] for line in said.splitlines()] == [
        ["a", "satisfied"],
        ["b", "satisfied"],
        ["c", "satisfied"],
    ]


CALLED_SO = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal emergency : set of object { x: m } capacity 4 forget 0.3 s
signal driven : state { v: m/s }
rule near ""
  for all o in emergency
  require not once[0.1 s, 0.5 s] o.x > 6 m
rule slow "" require driven.v < 5 m/s
"""


@pytest.mark.acceptance
def test_signals_that_are_called_as_a_candidate_is_and_as_what_is_told() -> None:
    spec, now, limits = loads(CALLED_SO), 0.0, Limits(budget=1e9)
    rules = Evaluator(spec).rules
    program = build(spec, rules, limits)
    plan = {name: [1.0 * (name == "t") * k for k in range(2)] for name in ("t", "x", "y", "heading", "v")}
    ego = dict.fromkeys(("x", "y", "heading", "v"), 0.0)
    states = []
    with Served(program, False) as served:
        client = Client(program.layout, served.channel(), lambda: now)
        remote = RemoteSupervisor(spec, rules, client, limits, lambda: now, patience=PATIENCE)
        local = CSupervisor(spec, rules, limits, lambda: now)
        for number, ids in enumerate(([1, 2], [2, 1], [2], [1], [], [5])):
            now = number * 0.1
            there = {"id": ids, "x": [7.0 if one == 2 and not number else 1.0 for one in ids]}
            signals = {"ego": ego, "emergency": there, "driven": {"v": 9.0 if number == 5 else 1.0}}
            given = Cycle(number, now, plan, plan, signals)
            said = remote.step(given)
            assert list(decision_lines(said)) == list(decision_lines(local.step(given)))
            states.append(said.state)
        remote.close()
    # In the fourth, who is there was not in the third: what it was is not known.
    assert states == ["drive", *["previous_emergency"] * 3, "drive", "previous_emergency"]
