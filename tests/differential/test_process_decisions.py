"""The Supervisor as a process decides what the same one decides in this process: every word of every decision."""

from __future__ import annotations

import random
import shutil
import socket
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle, mutate
from support.decision_lines import decision_lines
from support.emitted import SCENARIOS, emit, name_of
from support.length import at_length
from support.processes import PATIENCE, Served, free_port
from support.shared import REPOSITORY, SUPERVISOR
from support.supervised import shipped
from trackmarshal import scenarios
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.evaluation import Evaluator
from trackmarshal.process.client import Client
from trackmarshal.process.messages import Layout
from trackmarshal.process.serving import build
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.scenarios.overrides import known_tables
from trackmarshal.supervision import rulebox

pytestmark = [
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
    # What decides there has nothing of the planner but its messages.
    pytest.mark.verifies("S-1-B-1", "S-1-B-8"),
]
#: As `replay` holds recordings, with the capacities that hold by default: what is compiled for them is what broken cycles and others are judged by.
OPEN = replace(Limits.open_loop(), samples=128, elements=32, border=2048)


@pytest.fixture(scope="module")
def evaluator() -> Evaluator:
    spec = tm.load([SUPERVISOR], [REPOSITORY / "specs" / "tracks" / "northfield.spec"], REPOSITORY)
    return Evaluator(spec)


#: `make test` takes these; each has values of its own, and so a program of its own.
SOME = ("cut_in", "bad_reception")
RECORDINGS = [
    pytest.param(path, id=name_of(path), marks=() if name_of(path) in SOME else pytest.mark.acceptance)
    for path in SCENARIOS
]


@pytest.mark.parametrize("recording", RECORDINGS)
def test_the_shipped_scenarios(recording: Path, evaluator: Evaluator) -> None:
    """By turns over shared memory and over datagrams."""
    found, spec = scenarios.load(recording), evaluator.spec
    settings = rulebox(evaluator, found.params, known_tables(found, spec)[0]).settings
    program = build(spec, evaluator.rules, OPEN, settings)
    now = 0.0
    with Served(program, udp=SCENARIOS.index(recording) % 3 == 1) as served:
        client = Client(program.layout, served.channel(), lambda: now)
        remote = RemoteSupervisor(
            spec, evaluator.rules, client, OPEN, lambda: now, settings, patience=PATIENCE
        )
        local = CSupervisor(spec, evaluator.rules, OPEN, lambda: now, settings)
        driven = 0
        for given in tm.cycles(found):
            now = given.t
            said = remote.step(given)
            assert list(decision_lines(said)) == list(decision_lines(local.step(given)))
            driven += said.safe
        remote.close()
        assert driven > 60
        assert client.refused == {}


@pytest.mark.parametrize("udp", [at_length(False), True], ids=["shared memory", "datagrams"])
def test_broken_cycles(udp: bool, evaluator: Evaluator) -> None:
    """All faults that the door finds, with their places, and those that Python finds before it."""
    spec, rng, now, faults = evaluator.spec, random.Random(7), 0.0, set()
    limits, rules = Limits(budget=1e9), evaluator.rules
    program = build(spec, rules, limits)
    with Served(program, udp) as served:
        client = Client(program.layout, served.channel(), lambda: now)
        remote = RemoteSupervisor(spec, rules, client, limits, lambda: now, patience=PATIENCE)
        local = CSupervisor(spec, rules, limits, lambda: now)
        for number in range(300):
            given: Cycle | None = cycle(number, 1 + number % 4, 1 + number % 3)
            if number % 3 == 2 and given is not None:
                given = mutate(rng, given)[0]
            if number % 50 == 20:
                given = None
            now = number * PERIOD
            expected = local.step(given)
            said = remote.step(given)
            assert list(decision_lines(said)) == list(decision_lines(expected))
            assert said.reasons == expected.reasons
            faults |= {fault.code for fault in said.faults}
        remote.close()
    assert len(faults) > 12


@pytest.fixture(scope="module")
def emitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `compile --process` writes, with cycles of a run in which all sorts of them are broken, compiled as it stands."""
    folder = tmp_path_factory.mktemp("emitted")
    now, rng = 0.0, random.Random(5)
    recorded = tm.supervisor(shipped(), clock=lambda: now, record=folder / "run.arrows")
    for number in range(200):
        given: Cycle | None = cycle(number, 1 + number % 4, 1 + number % 3)
        if number % 3 == 2 and given is not None:
            given = mutate(rng, given)[0]
        now = number * PERIOD
        recorded.step(None if number % 50 == 20 else given)
    recorded.close()
    made = emit(folder / "out", "--process", recordings=[folder / "run.arrows"])
    flags = [
        "-std=c99",
        "-O0",
        "-ffp-contract=off",
        "-pedantic",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Werror",
    ]
    subprocess.run(["cc", *flags, "-c", *[f"{path.name}" for path in made.glob("*.c")]], cwd=made, check=True)
    for name, units in {
        "process": ("desk", "mailbox", "messages", "process"),
        "client": ("client", "client_example", "cycles", "mailbox", "messages"),
        "example": ("main", "cycles"),
    }.items():
        objects = [f"{unit}.o" for unit in ("supervisor", *units)]
        subprocess.run(["cc", "-o", name, *objects, "-lm"], cwd=made, check=True)
    return made


@pytest.mark.parametrize("udp", [False, at_length(True)], ids=["shared memory", "datagrams"])
def test_the_client_in_c(udp: bool, emitted: Path) -> None:
    """It prints what the emitted example prints of the same cycles."""
    cycles = emitted / "run.cycles"
    example = subprocess.run([emitted / "example", cycles], capture_output=True, text=True, check=True)
    where = ["--udp", str(free_port())] if udp else ["--shm", str(emitted / "memory")]
    process = subprocess.Popen(
        [emitted / "process", *where, "--simulated"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("serves ")
        said = subprocess.run(
            [emitted / "client", cycles, *where], capture_output=True, text=True, check=False
        )
        assert (said.returncode, said.stderr) == (0, "")
        unknown = 0
        for one, other in zip(said.stdout.splitlines(), example.stdout.splitlines(), strict=True):
            if "?" in one.split():  # a name that the spec does not know has no number in a message
                unknown += 1
                words = [b if a == "?" else a for a, b in zip(one.split(), other.split(), strict=True)]
                assert words == other.split()
            else:
                assert one == other
        assert unknown < 10
        assert said.stdout.count("decision drive") > 60
        assert said.stdout.count("\nfault ") > 30
    finally:
        process.kill()
        process.communicate()


#: A planner that says that time has passed, and prints the number of the cycle in the decision that it takes for the one about that.
ASKING = """
#include "client.h"
#include <stdio.h>
#include <stdlib.h>
static tml_client client;
static tml_message said;
int main(int count, char **words) {
  const char *why = "";
  const bool asked = (count == 2) && tml_client_datagrams(&client, (unsigned)atoi(words[1]), &why) && tml_client_tick(&client);
  printf("%d\\n", (asked && tml_client_answer(&client, 1u, 10.0, &said)) ? (int)said.decision.number : -1);
  return 0;
}
"""


def test_the_client_in_c_takes_no_decision_about_the_cycle_of_another_planner(emitted: Path) -> None:
    """All planners count their messages from 1: that of one that was replaced may be decided while the next one waits."""
    (emitted / "asking.c").write_text(ASKING, encoding="utf-8")
    units = [f"{unit}.o" for unit in ("client", "mailbox", "messages", "supervisor")]
    subprocess.run(
        ["cc", "-std=c99", "-O0", "-o", "asking", "asking.c", *units, "-lm"], cwd=emitted, check=True
    )
    layout = Layout.read(emitted / "messages.json")
    kind = layout.kinds["decision"]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as supervisor:
        supervisor.bind(("127.0.0.1", 0))
        supervisor.settimeout(PATIENCE)
        port = str(supervisor.getsockname()[1])
        with subprocess.Popen([emitted / "asking", port], stdout=subprocess.PIPE, text=True) as planner:
            data, address = supervisor.recvfrom(1 << 16)
            _, tick = layout.look(data, up=True)
            assert tick is not None
            for number, session, sequence in (
                (7, tick.head.session - 1, 1),
                (8, tick.head.session, 2),
                (9, tick.head.session, 1),
            ):
                message = bytearray(kind.length)
                for name, value in {
                    "serial": 1,
                    "number": number,
                    "about_session": session,
                    "about_sequence": sequence,
                }.items():
                    kind.put(message, name, value)
                layout.seal(message, kind, 1, number, 0.0)
                supervisor.sendto(message, address)
            assert planner.communicate(timeout=PATIENCE)[0] == "9\n"


FORKS = """
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "client.h"
static tml_client client;
static tml_message decision;
int main(int count, char **words) {
  const char *why = "";
  tm_cycle cycle;
  pid_t child;
  uint64_t sent;
  int status = 0;
  (void)memset(&cycle, 0, sizeof(cycle));
  if (!tml_client_memory(&client, words[count - 1], TML_WAIT_POLL, &why)) { (void)puts(why); return 2; }
  child = fork();
  if (child == 0) { _exit((tml_client_send(&client, &cycle) == 0u) && !tml_client_tick(&client) ? 3 : 4); }
  (void)waitpid(child, &status, 0);
  sent = tml_client_send(&client, &cycle);
  (void)printf("%d %d %d\\n", WEXITSTATUS(status), (int)sent, (int)tml_client_answer(&client, sent, 5.0, &decision));
  return 0;
}
"""


def test_a_fork_has_no_client_in_c(emitted: Path) -> None:
    """It would count on with the same numbers as the process that connected, and take a decision about the other one's cycle."""
    (emitted / "forks.c").write_text(FORKS)
    objects = [f"{unit}.o" for unit in ("supervisor", "client", "mailbox", "messages")]
    subprocess.run(["cc", "-O0", "-o", "forks", "forks.c", *objects, "-lm"], cwd=emitted, check=True)
    memory = str(emitted / "forked")
    process = subprocess.Popen([emitted / "process", "--shm", memory], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("serves ")
        said = subprocess.run([emitted / "forks", memory], capture_output=True, text=True, check=True)
        assert said.stdout.split() == ["3", "1", "1"]
    finally:
        process.kill()
        process.communicate()
