"""What becomes of a car when a process dies or a message is lost, cut, changed, out of order or of another version (docs/process.md).

In simulated time: a cycle each tenth of a second, decisions valid for 0.15 s, a Supervisor that is silent for 0.05 s is taken for dead.
Two things hold everywhere: what was decided before is never taken for fresh, and nothing is safe without a cycle.
"""

from __future__ import annotations

import ctypes
import math
import os
import resource
import shutil
import signal
import socket
import struct
import subprocess
import threading
import time
from array import array
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle
from support.processes import PATIENCE, Rig, Served, built, free_port
from support.supervised import shipped
from trackmarshal.errors import TrackmarshalError
from trackmarshal.process.client import Block, Border, Client
from trackmarshal.process.datagrams import Datagrams
from trackmarshal.process.executing import DRIVE, FALLBACK, NOTHING, Executing
from trackmarshal.process.messages import Kind, LinkError, Message
from trackmarshal.process.serving import build, shared_path, start
from trackmarshal.process.shared_memory import Region, SharedMemory
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.frame import NO_SETTINGS, Settings
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.record.reading import read

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
BOTH = pytest.mark.parametrize("udp", [False, True], ids=["shared memory", "datagrams"], indirect=True)


class Mangled:
    """A channel of which single messages are changed, dropped or kept back: `next_one` says what becomes of the next cycle."""

    def __init__(self, channel: Any) -> None:
        self._channel = channel
        self.next_one: Callable[[bytearray], list[bytes | bytearray]] | None = None

    def send(self, box: str, message: bytearray) -> bool:
        mangle = self.next_one if box == "cycle" else None
        if mangle is None:
            return bool(self._channel.send(box, message))
        self.next_one = None
        for one in mangle(message):
            self._channel.send(box, one)
        return True

    def receive(self, seconds: float) -> bytes | None:
        found: bytes | None = self._channel.receive(seconds)
        return found

    def close(self) -> None:
        self._channel.close()


@pytest.fixture
def udp(request: pytest.FixtureRequest) -> bool:
    return bool(getattr(request, "param", False))


@pytest.fixture
def rig(udp: bool) -> Iterator[Rig]:
    """Over what `udp` says; three cycles have been driven."""
    with Served(built(), udp) as served:
        made = Rig(served, Mangled)
        for number in range(3):
            assert made.step(number)["safe"] == 1 or (udp and number == 0)
        assert made.at(made.now).action == DRIVE
        yield made
        made.close()


def faults(message: Message) -> list[str]:
    names = message.layout.faults
    kinds = zip(message["reason_kind"], message["reason_name"])
    return [names[name] for kind, name in list(kinds)[: message["reason_count"]] if kind == 0]


def channel(rig: Rig) -> Mangled:
    found: Mangled = rig.client.channel  # type: ignore[assignment]
    return found


def lose(message: bytearray) -> list[bytes | bytearray]:
    return []


def unanswered(rig: Rig, number: int) -> None:
    """A cycle is sent, and nothing is decided about it; what was decided before is driven meanwhile."""
    rig.now = number / 10
    sequence = rig.send(number)
    assert rig.client.answer(sequence, 0.05) is None
    rig.listen()


# A process dies -------------------------------------------------------------------------------------------------------


@pytest.mark.verifies("S-1-B-3")
@BOTH
def test_the_planner_dies(rig: Rig) -> None:
    """Nobody sends cycles: the Supervisor says that one is missing, and the stored emergency trajectory is driven."""
    assert rig.later(0.34) is None  # 0.14 s after the last one
    assert (rig.at(0.34).action, rig.at(0.34).why) == (DRIVE, "decided")
    # Whoever executes does not even need to hear of it.
    assert (rig.at(0.36).action, rig.at(0.36).why) == (FALLBACK, "outdated")
    said = rig.later(0.36)
    assert said is not None
    assert (said["about_sequence"], said["safe"], faults(said)) == (0, 0, ["missing_cycle"])
    assert said.layout.states[said["state"]] == "previous_emergency"
    found = rig.at(0.36)
    assert (found.action, found.why, found.number) == (FALLBACK, "decided", 2)
    assert found.sample is not None
    assert found.sample["v"] < 20.0
    for now in (0.5, 0.6, 0.69):
        rig.later(now)
        assert rig.at(now).action == FALLBACK
    # Poses come with cycles: `blind` after the last one, the Supervisor gives the trajectory up.
    said = rig.later(0.9)
    assert said is not None
    assert said.layout.faults[said["lost"]] == "unconfirmed"
    assert (rig.at(0.9).action, rig.at(0.9).why) == (NOTHING, "decided")
    # A planner that is there again is driven by as soon as a cycle is safe.
    assert rig.step(10)["safe"] == 0  # it is late
    assert rig.step(11)["safe"] == 1


@pytest.mark.parametrize("seconds", [2**32 / 1e3, 1e10, math.inf])
def test_who_listens_for_as_long_as_it_takes_hears_datagrams(seconds: float) -> None:
    """A socket takes no time that the system's clock cannot count (OverflowError), and with such a patience nothing was ever driven; of 50 days, it
    takes what an int has for the milliseconds: none."""
    port = free_port()
    with (
        closing(Datagrams(built().layout, port, executing=True)) as ear,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as planner,
    ):
        later = threading.Timer(0.1, planner.sendto, [b"one", ("127.0.0.1", port)])
        later.start()
        assert ear.receive(seconds) == b"one"
        later.join()


class Deaf:
    """A channel over which, as long as somebody says so, nothing comes; what was sent meanwhile is answered all the same."""

    def __init__(self, channel: Any) -> None:
        self._channel, self.deaf = channel, False
        self.send, self.close = channel.send, channel.close

    def receive(self, seconds: float) -> bytes | None:
        found: bytes | None = None if self.deaf else self._channel.receive(seconds)
        return found


@pytest.mark.verifies("S-1-B-4")
@pytest.mark.parametrize("udp", [False, True], ids=["shared memory", "datagrams"])
def test_of_a_supervisor_that_does_not_answer_nothing_is_known(udp: bool) -> None:
    """A step without an answer drives nothing, and neither does one that would drive what was stored meanwhile: only its own process knows that."""
    spec, now = shipped(), 0.0
    rules = [rule for rule in spec.rules if rule.formula is not None]
    with Served(built(), udp) as served:
        channel = Deaf(served.channel())
        client = Client(served.program.layout, channel, lambda: now)
        remote = RemoteSupervisor(spec, rules, client, clock=lambda: now)
        stepper: Any = remote.stepper
        for number, deaf, given, state, driven in (
            (0, False, cycle(0), "drive", 0),
            (1, True, cycle(1), "no_safe_trajectory", None),
            (2, False, replace(cycle(2), driving=None), "no_safe_trajectory", None),  # its process falls back
            (3, False, cycle(3), "drive", 3),
            (4, False, replace(cycle(4), driving=None), "previous_emergency", 3),
            (5, True, None, "no_safe_trajectory", None),
        ):
            now, channel.deaf, stepper._patience = number / 10, deaf, 0.02 if deaf else PATIENCE
            said = remote.step(given)
            assert (said.state, said.safe) == (state, state == "drive")
            assert (said.driven and said.driven.number) == driven
            assert ("incomplete" in map(name_of, said.faults)) == (driven is None)
            assert any("no decision within 0.02 s" in fault.message for fault in said.faults) == deaf
        served.process.kill()
        channel.deaf, stepper._patience = False, 0.02
        for given in (cycle(6), None, cycle(7)):
            now += 0.1
            said = remote.step(given)
            assert (said.state, said.driven, said.safe) == ("no_safe_trajectory", None, False)
        remote.close()


@BOTH
def test_a_line_is_no_border_that_somebody_has_sent_before(rig: Rig) -> None:
    """Both have numbers, which are counted apart: whoever sent a cycle by hand, and had a RemoteSupervisor take the next ones, had them judged
    between the borders of the first."""
    spec, given = shipped(), cycle(4)
    rules = [rule for rule in spec.rules if rule.formula is not None]
    lines = {side: tm.line([(-50.0, y), (2000.0, y)]) for side, y in (("left", 0.5), ("right", -0.5))}
    for side in ("left", "right"):
        rig._borders[side] = Border(given.signals["track"][side])
        rig._borders[side].number = lines[side].number
    assert rig.step(3)["safe"] == 1
    rig.now = given.t
    supervisor = RemoteSupervisor(spec, rules, rig.client, clock=lambda: rig.now, patience=PATIENCE)
    narrow = replace(given, signals={**given.signals, "track": lines})
    assert not supervisor.step(narrow).safe


SEEN = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { v: m/s } capacity 3
rule seen ""
  for all o in objects
  require once[0 s, 1 s] o.v > 5 m/s
"""


@pytest.mark.parametrize("anew", [True, False])
def test_what_is_known_of_elements_is_not_that_of_others_of_the_planner_before(anew: bool) -> None:
    """Each RemoteSupervisor numbered its ids from 1 on, and the process remembers by numbers: what another object had done counted as this one's,
    where a planner was started anew within a cycle, or made another RemoteSupervisor for its client."""
    spec, now = tm.loads(SEEN), 0.0
    plan = {
        "t": [0.0, 1.0, 2.0],
        "x": [0.0, 5.0, 7.0],
        "y": [0.0] * 3,
        "heading": [0.0] * 3,
        "v": [10.0, 5.0, 0.0],
    }

    def clock() -> float:
        return now

    ego = {name: plan[name][0] for name in ("x", "y", "heading", "v")}
    rules, limits = list(spec.rules), replace(Limits.of(spec), budget=1e3)
    with Served(build(spec, rules, limits)) as served:
        client = Client(served.program.layout, served.channel(), clock)
        for number, (name, v) in enumerate([("a", 9.0), ("b", 0.0)]):
            if number == 1 and anew:
                client.close()
                client = Client(served.program.layout, served.channel(), clock)
            now = number * PERIOD
            remote = RemoteSupervisor(spec, rules, client, limits, clock=clock, patience=PATIENCE)
            objects = {"id": [name], "v": [v]}
            given = Cycle(number, now, plan, plan, {"ego": ego, "objects": objects})
            decision = remote.step(given)
            assert decision.safe == (name == "a"), decision.reasons
        client.close()


def test_what_is_known_of_elements_lasts_through_a_cycle_that_is_refused() -> None:
    """Who was not in that one is not gone: the process has not looked at it. Under another number, what it had done before was nobody's."""
    spec, now = tm.loads(SEEN), 0.0
    plan = {"t": [0.0, 1.0, 2.0], "x": [0.0, 5.0, 7.0], "y": [0.0] * 3, "heading": [0.0] * 3, "v": [10.0, 5.0, 0.0]}  # fmt: skip
    ego = {name: plan[name][0] for name in ("x", "y", "heading", "v")}
    rules, limits = list(spec.rules), replace(Limits.of(spec), budget=1e3)
    with Served(build(spec, rules, limits)) as served:
        client = Client(served.program.layout, served.channel(), lambda: now)
        remote = RemoteSupervisor(spec, rules, client, limits, clock=lambda: now, patience=PATIENCE)
        for number, (driving, speeds, safe) in enumerate([(plan, {"a": 9.0}, True), (None, {}, False), (plan, {"a": 0.0}, True)]):  # fmt: skip
            now = number * PERIOD
            objects = {"id": list(speeds), "v": list(speeds.values())}
            decision = remote.step(Cycle(number, now, driving, plan, {"ego": ego, "objects": objects}))
            assert decision.safe == safe, decision.reasons
        remote.close()


@BOTH
@pytest.mark.parametrize("where", ["send", "receive"])
def test_a_step_that_is_stopped_behind_its_cycle_is_missing_in_the_record(
    where: str, rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process has decided about its cycle, so that the next one is not skipped, as it is to whoever runs the record again."""
    spec, path = shipped(), tmp_path / "run.arrows"
    rules = [rule for rule in spec.rules if rule.formula is not None]
    rig.client.close()
    rig.connect()
    supervisor = RemoteSupervisor(spec, rules, rig.client, clock=lambda: rig.now, patience=PATIENCE)
    supervisor.recorder = Record(path, supervisor.contract, supervisor.limits, {}, saving=None)

    def step(number: int) -> bool:
        rig.now = number * PERIOD
        return supervisor.step(cycle(number)).safe

    assert step(3)
    going = getattr(rig.client.channel, where)

    def stop(*given: Any) -> None:
        if where == "send":
            going(*given)
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(rig.client.channel, where, stop)
        with pytest.raises(KeyboardInterrupt):
            step(4)
    # In shared memory, the next one would take its place before it is looked at.
    assert rig.client.answer(rig.client._sequence, PATIENCE) is not None
    assert step(5)
    supervisor.recorder.close()
    run = read(path.read_bytes(), str(path))
    assert (len(run.cycles), run.missed, run.damage, run.ended) == (2, 1, "", True)


@pytest.mark.verifies("S-1-B-4")
@BOTH
def test_the_supervisor_dies(rig: Rig) -> None:
    """No sign of life for 0.05 s: the emergency trajectory that was stored last is driven to its end."""
    alive = rig.now
    rig.served.kill()
    sequence = rig.send(3)
    assert rig.client.answer(sequence, 0.05) is None
    rig.listen()
    assert rig.at(alive + 0.049).action == DRIVE
    found = rig.at(alive + 0.051)
    assert (found.action, found.why, found.number) == (FALLBACK, "silent", 2)
    assert rig.at(alive + 2.4).action == FALLBACK
    assert rig.at(alive + 2.6).action == NOTHING
    rig.served.start()  # for whoever ends it


@BOTH
def test_the_supervisor_starts_anew(rig: Rig) -> None:
    """What it had stored is driven until its first decision; that is safe once it knows the borders, which datagrams have to bring again."""
    rig.served.kill()
    rig.served.start()
    rig.later(0.25)  # it is there, and has decided nothing
    found = rig.at(0.25)
    assert (found.action, found.why) == (FALLBACK, "restarted")
    said = rig.step(3)
    if rig.served.name is None:
        assert (said["safe"], said["wanted"], faults(said)) == (0, 0b11, ["bad_border", "bad_border"])
        assert (rig.at(rig.now).action, rig.at(rig.now).why, rig.at(rig.now).number) == (
            FALLBACK,
            "restarted",
            2,
        )
        said = rig.step(4)
    assert (said["safe"], said["wanted"], said.head.sequence) == (1, 0, said.head.sequence)
    assert (rig.at(rig.now).action, rig.at(rig.now).number) == (DRIVE, said["number"])


@pytest.mark.verifies("S-1-B-3")
@BOTH
def test_the_planner_starts_anew(rig: Rig) -> None:
    """It counts from 0 again: the first cycle is out of order and not safe, the second is."""
    rig.client.close()
    rig.connect()
    said = rig.step(0, replace(cycle(3), number=0))
    assert (said["safe"], faults(said)) == (0, ["out_of_order"])
    assert rig.at(rig.now).action == FALLBACK
    said = rig.step(1, replace(cycle(4), number=1))
    assert said["safe"] == 1
    assert rig.at(rig.now).action == DRIVE


@BOTH
def test_both_start_anew(rig: Rig) -> None:
    rig.served.kill()
    rig.client.close()
    rig.served.start()
    rig.connect()
    said = rig.step(0, replace(cycle(3), number=0))
    assert (said["safe"], said["wanted"]) == (1, 0)  # a planner that starts sends its borders first
    assert rig.at(rig.now).action == DRIVE


@BOTH
def test_a_tick_of_before_is_no_time_to_a_supervisor_that_starts(rig: Rig) -> None:
    """It stands in shared memory still; whoever simulates anew begins at 0 s."""
    rig.later(100.0)
    rig.served.kill()
    rig.client.close()
    rig.served.start()
    rig.connect()
    assert rig.step(0)["safe"] == 1


def test_who_sends_no_message_gets_no_answer() -> None:
    """What is sent goes to the planner of the last message that was taken, whoever else has sent something to the port."""
    with (
        Served(built(), udp=True) as served,
        closing(Rig(served)) as rig,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        rig.step(0)
        rig.refused()
        stranger.sendto(b"who is there?", ("127.0.0.1", served.port))
        beat = rig.client.hear(PATIENCE)
        assert beat is not None
        assert sum(beat["refused"]) == 1


def test_a_planner_that_was_replaced_is_not_heard() -> None:
    """Two planners send: the one that started later counts."""
    with Served(built(), udp=True) as served:
        rig = Rig(served)
        rig.step(0)
        old = rig.client
        rig.connect()
        rig.step(0, replace(cycle(1), number=0))
        new, rig.client = rig.client, old
        sequence = rig.send(2)
        assert old.answer(sequence, 0.05) is None
        rig.client = new
        assert rig.refused() == {"session": 3}  # two borders and a cycle
        old.close()
        rig.close()


@BOTH
def test_a_forked_planner_has_no_client(rig: Rig) -> None:
    """Both would count on with the same numbers: a decision about the one's cycle was the answer to the other's, which nobody judged."""
    child = os.fork()
    if child == 0:
        try:
            rig.send(3)
        except LinkError as error:
            os._exit(3 if "another process" in str(error) else 4)
        finally:
            os._exit(5)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3
    assert rig.step(3)["safe"] == 1
    assert rig.refused() == {}


def test_a_supervisor_in_a_fork_says_why_nothing_is_driven() -> None:
    """A step raises no exception, whatever becomes of what it is asked with."""
    spec = shipped()
    rules = [rule for rule in spec.rules if rule.formula is not None]
    with Served(built()) as served:
        client = Client(served.program.layout, served.channel(), lambda: 0.0)
        remote = RemoteSupervisor(spec, rules, client, clock=lambda: 0.0, patience=PATIENCE)
        assert remote.step(cycle(0)).safe
        child = os.fork()
        if child == 0:
            try:
                given: tuple[Any, ...] = (cycle(1), None, 7, cycle(2))
                told = [
                    (said.state, any("that of another process" in fault.message for fault in said.faults))
                    for said in map(remote.step, given)
                ]
                os._exit(3 if told == [("no_safe_trajectory", True)] * 4 else 4)
            finally:
                os._exit(5)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3
        assert remote.step(replace(cycle(1), t=0.0)).faults[0].name == "repeated"
        remote.close()


@pytest.mark.verifies("S-1-B-3")
def test_borders_of_a_planner_that_starts_are_not_for_the_cycle_of_the_one_before() -> None:
    """The cycle waits; a new planner has put its borders there, which count from 1 as those of before did, and no cycle yet."""
    with Served(built()) as served:
        rig = Rig(served)
        rig.step(2)
        rig.close()
        rig.connect()
        given = cycle(3)
        track = given.signals["track"]
        beside = np.asarray(track["left"], float) - [0.0, 5.5]  # the car is on this border
        os.kill(served.process.pid, signal.SIGSTOP)
        rig.now = given.t
        sequence = rig.send(3, replace(given, signals={**given.signals, "track": {**track, "left": beside}}))
        rig.client.channel._cycles.close()  # type: ignore[attr-defined]  # it dies, and its ears stay
        old, rig._ear = rig.client, served.listening()
        rig.connect()
        for slot, (_, field) in enumerate(rig.client.layout.lines):
            assert rig.client._version(slot, Border(track[field])) == 1
        os.kill(served.process.pid, signal.SIGCONT)
        said = old.answer(sequence, PATIENCE)
        assert said is not None
        assert (said["safe"], said["driven"]) == (0, 2)
        assert rig.step(4, replace(cycle(4), number=4))["about_session"] == rig.client.session
        rig.close()


@pytest.mark.verifies("S-1-B-3")
def test_a_planner_that_dies_while_it_writes(rig: Rig) -> None:
    """Half a message in a slot: nobody takes it, and the next one is whole."""
    region = channel(rig)._channel._cycles
    box = region._boxes["cycle"]
    following = region.latest("cycle") + 1
    slot = box["first"] + following % box["slots"] * box["step"]
    region._words[slot // 8] = 2 * following - 1
    region._bytes[slot + 64 : slot + 1064] = b"\xff" * 1000
    assert rig.later(0.21) is None
    # One that even says that it is whole: nothing of it is taken, but the count tells of it.
    region._words[box["place"] // 8] = following
    assert rig.later(0.22) is None
    assert rig.refused() == {"torn": 1}
    said = rig.step(3)
    assert said["safe"] == 1


# Messages -------------------------------------------------------------------------------------------------------------


@BOTH
def test_a_cycle_is_lost(rig: Rig) -> None:
    """The next one is not safe, since one was skipped; the one after is."""
    channel(rig).next_one = lose
    unanswered(rig, 3)
    said = rig.step(4)
    assert (said["safe"], "skipped" in faults(said)) == (0, True)
    assert rig.at(rig.now).action == FALLBACK
    assert rig.step(5)["safe"] == 1
    assert rig.at(rig.now).action == DRIVE


def test_cycles_come_in_another_order() -> None:
    """The later one was skipped to; the earlier one comes too late and is not looked at; then all is well."""
    with Served(built(), udp=True) as served:
        rig = Rig(served, Mangled)
        for number in range(3):
            rig.step(number)
        kept: list[bytearray] = []

        def keep(message: bytearray) -> list[bytes | bytearray]:
            kept.append(message)
            return []

        channel(rig).next_one = keep
        rig.now = 0.3
        sequence = rig.send(3)
        said = rig.step(4)
        assert (said["safe"], "skipped" in faults(said)) == (0, True)
        channel(rig)._channel.send("cycle", kept[0])
        assert rig.client.answer(sequence, 0.05) is None
        assert rig.refused() == {"sequence": 1}
        assert rig.step(5)["safe"] == 1
        rig.close()


@BOTH
def test_a_cycle_comes_twice(rig: Rig) -> None:
    """It is decided about once."""
    channel(rig).next_one = lambda message: [message, message]
    said = rig.step(3)
    assert said["safe"] == 1
    serial = said["serial"]
    if rig.served.name is None:  # in shared memory, the first may never have been looked at
        assert rig.refused() == {"sequence": 1}
    assert rig.step(4)["serial"] == serial + 1


@pytest.mark.parametrize("left", [0, 1, 40, 47, 48, 100, -8, -1])
@pytest.mark.verifies("S-1-B-9")
def test_a_cut_datagram(left: int) -> None:
    with Served(built(), udp=True) as served:
        rig = Rig(served, Mangled)
        rig.step(0)
        rig.step(1)
        channel(rig).next_one = lambda message: [bytes(message[:left])]
        unanswered(rig, 2)
        assert rig.refused() == {"size": 1}
        said = rig.step(3)
        assert (said["safe"], "skipped" in faults(said)) == (0, True)
        rig.close()


@pytest.mark.verifies("S-1-B-9")
def test_a_datagram_that_is_too_long() -> None:
    with Served(built(), udp=True) as served:
        rig = Rig(served, Mangled)
        rig.step(0)
        rig.step(1)
        for more in (1, 20_000, 40_000):

            def longer(message: bytearray, more: int = more) -> list[bytes | bytearray]:
                return [bytes(message) + bytes(more)]

            channel(rig).next_one = longer
            unanswered(rig, 2)
        # Nothing that a message has room for is left of it.
        layout = served.program.layout
        line = layout.kinds["line"]
        assert line.length == layout.longest
        longest = bytearray(line.length)
        line.put(longest, "line_version", 9)
        layout.seal(longest, line, rig.client.session, 9, rig.now)
        channel(rig).send("line_0", longest + b"\0")
        assert rig.refused() == {"size": 4}
        rig.close()


@BOTH
@pytest.mark.verifies("S-1-B-9")
def test_a_cycle_is_changed(rig: Rig) -> None:
    """One bit anywhere: it is refused, by its head or by its CRC."""
    places = {
        0: "magic",
        4: "crc",
        8: "version",
        10: "kind",
        12: "length",
        16: "layout",
        24: "crc",
        32: "crc",
        40: "crc",
        60: "crc",
        4000: "crc",
    }
    for place in places:

        def flip(message: bytearray, place: int = place) -> list[bytes | bytearray]:
            changed = bytearray(message)
            changed[place] ^= 8
            return [changed]

        channel(rig).next_one = flip
        unanswered(rig, 3)
        rig.later(rig.now)  # in shared memory, a message is there until the next one
    wanted: dict[str, int] = {}
    for cause in places.values():
        wanted[cause] = wanted.get(cause, 0) + 1
    assert rig.refused() == wanted
    assert rig.at(rig.now).action == DRIVE  # until the decision before is outdated
    assert rig.at(0.36).action == FALLBACK


@BOTH
@pytest.mark.verifies("S-1-B-9")
def test_a_message_of_another_version(rig: Rig) -> None:
    """A head with another version or layout, even with a CRC that fits."""
    for place, form, value in ((8, "<H", 2), (16, "<Q", 1)):

        def other(
            message: bytearray, place: int = place, form: str = form, value: int = value
        ) -> list[bytes | bytearray]:
            import zlib

            changed = bytearray(message)
            struct.pack_into(form, changed, place, value)
            struct.pack_into("<I", changed, 4, zlib.crc32(changed[8:]))
            return [changed]

        channel(rig).next_one = other
        unanswered(rig, 3)
        rig.later(rig.now)
    assert rig.refused() == {"version": 1, "layout": 1}


def test_a_client_of_another_layout_finds_no_supervisor() -> None:
    """Other limits are another layout: shared memory is not opened, datagrams are refused."""
    other = built(Limits(budget=0.04))
    with Served(built()) as served:
        assert served.name is not None
        with pytest.raises(LinkError, match="is for another spec, other rules, capacities or limits"):
            SharedMemory(other.layout, shared_path(served.name))
    with Served(built(), udp=True) as served:
        rig = Rig(served)
        rig.step(0)
        foreign = Rig.__new__(Rig)
        foreign.served, foreign._wrap, foreign.now = served, lambda channel: channel, 0.1
        foreign.client = type(rig.client)(other.layout, served.channel(), lambda: 0.1)
        foreign._borders = {}
        sequence = foreign.send(1)
        assert foreign.client.answer(sequence, 0.05) is None
        assert rig.refused() == {"layout": 3}  # two borders and a cycle
        foreign.client.close()
        rig.close()


def test_a_supervisor_of_something_else_is_not_spoken_for() -> None:
    """Its rules have the same names; what is said of its decisions, and recorded, would be of other limits, values or formulas."""
    spec, program = shipped(), built()
    rules = [rule for rule in spec.rules if rule.formula is not None]
    with Served(program) as served:
        client = Client(program.layout, served.channel())
        for changed, given, settings in (
            ("limits", Limits(budget=0.04), NO_SETTINGS),
            ("capacities", Limits(samples=64), NO_SETTINGS),
            ("params", None, Settings({"supervisor.trajectory.d_loc": 12.0})),
        ):
            with pytest.raises(LinkError, match=f"the process has other {changed}: start it anew"):
                RemoteSupervisor(spec, rules, client, given, settings=settings)
        with pytest.raises(LinkError, match="the process has other rules and"):
            RemoteSupervisor(spec, rules[1:], client)
        RemoteSupervisor(spec, rules, client).close()


@BOTH
@pytest.mark.verifies("S-1-B-9")
def test_entries_that_cannot_be(rig: Rig) -> None:
    """A message that is whole, of a sender that is wrong: nothing of it is taken."""
    kind = rig.client.layout.kinds["cycle"]
    for name, value in (
        ("came", 2),
        ("found_count", 66),
        ("driving/present", 7),
        ("signals.track/closed", 3),
    ):

        def wrong(message: bytearray, name: str = name, value: int = value) -> list[bytes | bytearray]:
            changed = bytearray(message)
            kind.put(changed, name, value)
            rig.client.layout.seal(changed, kind, rig.client.session, 10**6, rig.now)
            return [changed]

        channel(rig).next_one = wrong
        unanswered(rig, 3)
        rig.later(rig.now)
    assert rig.refused() == {"content": 4}
    assert rig.step(3)["safe"] == 1


def test_what_a_masked_array_hides_is_missing(rig: Rig) -> None:
    """As to the door of a Supervisor in this process: what stands below the mask is no number of anybody."""
    given = cycle(3)
    objects = given.signals["objects"]
    for hides, safe in ((False, 1), (True, 0)):
        hidden = np.ma.masked_array(np.asarray(objects["x"], float), mask=[hides, False])
        signals = {**given.signals, "objects": {**objects, "x": hidden}}
        said = rig.step(3 + hides, replace(cycle(3 + hides), signals=signals))
        assert (said["safe"], faults(said)) == (safe, ["not_finite"] * hides)
    plain = np.ma.masked_array(np.asarray(given.driving["v"], float))
    assert rig.step(5)["safe"] == 1
    assert rig.step(6, replace(cycle(6), driving={**cycle(6).driving, "v": plain}))["safe"] == 1


#: Entries for so many numbers, and Booleans, as a description of messages has them.
SAID = {
    "name": "cycle", "kind": 1, "from": "planner", "length": 72, "entries": [
        {"name": "v", "offset": 0, "type": "f64", "count": 8, "array": True, "unit": "m/s"},
        {"name": "ready", "offset": 64, "type": "i8", "count": 8, "array": True},
    ],
}  # fmt: skip


def put(name: str, column: Any) -> list[float]:
    """What is sent of a column of three."""
    kind = Kind(SAID)
    message = bytearray(kind.length)
    kind.put(message, name, column)
    return list(kind.get(message, name)[:3])


@pytest.mark.parametrize(
    "column",
    [
        array("d", [1.0, 2.0, 3.0]).tobytes(), bytearray(24), "123", {1.0, 2.0, 3.0}, {1.0: 0, 2.0: 0, 3.0: 0}, [1.0, True, 3.0], ["1", 2.0],
        [1.0, np.True_], np.array([True, False]), np.array([1j, 2.0]), [1.0, 2j], np.array([1, 2], "m8[ns]"), np.array([1, 2], "M8[ns]"),
        [np.timedelta64(1, "ns")], np.array(["1", "2"]), np.ones((2, 2)), [[1.0], [2.0]],
    ],
    ids=str,
)  # fmt: skip
def test_what_is_no_column_to_the_door_is_sent_by_nobody(column: Any) -> None:
    """A client takes what the door of a Supervisor in this process takes: bytes, an order that a set makes up or the real part of something are
    guesses."""
    with pytest.raises(LinkError, match="`v`"):
        put("v", column)


@pytest.mark.parametrize("form", [list, tuple, np.array, np.float32, np.int16, ">f8", np.uint8, object])
def test_columns_of_numbers_of_any_kind(form: Any) -> None:
    made = form((1.0, 2.0, 3.0)) if form in (list, tuple, np.array) else np.array([1, 2, 3], form)
    assert put("v", made) == [1.0, 2.0, 3.0]


def test_single_entries_that_are_missing_and_flags_of_numpy() -> None:
    assert [math.isnan(one) for one in put("v", [1.0, None, np.float32(3.0)])] == [False, True, False]
    assert put("ready", np.array([True, False, True])) == put("ready", [True, np.False_, True]) == [1, 0, 1]
    assert put("ready", [True, None, False]) == [1, -1, 0]


@pytest.mark.parametrize(
    "points",
    [
        [[0.0, 6.0, 1.0], [100.0, 6.0, 1.0]], np.ones((4, 3)), [[0.0, 1.0, 2.0], [3.0]], [["0", "6"], ["1", "6"]], ["06", "16"],
        np.array([[True, False], [True, True]]), np.array([[0, 6], [1, 6]], "M8[ns]"), np.ones(4), [[0.0, None], [1.0, 6.0]],
    ],
    ids=str,
)  # fmt: skip
def test_a_border_of_something_else_than_pairs_of_numbers(points: Any) -> None:
    """Points with a height, one after the other, would be other points."""
    with pytest.raises(LinkError, match="points are pairs"):
        Border(points)


@pytest.mark.parametrize(("short", "far"), [(np.float32, 131_072.0), (np.float16, 16.0), (">f4", 5.3e6)])
@pytest.mark.parametrize("made", [np.array, lambda points, short: list(np.array(points, short))])
def test_a_border_of_short_floats_that_lie_far_apart_there(made: Any, short: Any, far: float) -> None:
    """As to the door: a survey's northing in float32 is rounded to half a metre, which is the car's way across its border."""
    near = far / 2 if far < 1e6 else 100.0
    assert Border(made([[0.0, near], [10.0, near]], short)).points[1] == near
    with pytest.raises(LinkError, match="nearer than 1 cm"):
        Border(made([[0.0, far], [10.0, far]], short))
    assert Border([[0.0, far], [10.0, far]]).count == 2


@pytest.mark.parametrize(
    "row",
    [
        lambda row: array("f", row),
        lambda row: (ctypes.c_float * 2)(*row),
        lambda row: memoryview(np.array(row, np.float32)),  # type: ignore[arg-type]
    ],
)
def test_a_border_of_rows_that_hold_short_floats(row: Any) -> None:
    """What a buffer hands out is a double already; what it holds was rounded before."""
    far = 5334572.0
    assert Border([row([0.0, 100.0]), row([10.0, 100.0])]).count == 2
    with pytest.raises(LinkError, match="nearer than 1 cm"):
        Border([row([0.0, far]), row([10.0, far])])


#: Holders of short floats of which each number, by itself, no longer says so, or which have more to them than numbers.
HOLDERS = (
    np.asarray,
    list,
    lambda column: np.array(list(column), object),
    lambda column: np.ma.array(column, mask=np.zeros(len(column), bool)),
    lambda column: array("f", column.tolist()),
    memoryview,
    lambda column: (ctypes.c_float * len(column))(*column.tolist()),
)


@pytest.mark.parametrize("made", HOLDERS)
@pytest.mark.parametrize("north", [5334572.0, -131072.0])
def test_a_column_of_short_floats_whatever_holds_it(made: Any, north: float) -> None:
    kinds = built().layout.kinds.values()
    kind = next(kind for kind in kinds if any(one.unit == "m" and one.array for one in kind.entries.values()))
    entry = next(one for one in kind.entries.values() if one.unit == "m" and one.array)
    into = bytearray(kind.length)
    kind.put(into, entry.name, made(np.full(3, 1.5, np.float32)))
    with pytest.raises(LinkError, match="is of short floats"):
        kind.put(into, entry.name, made(np.full(3, north, np.float32)))


@pytest.mark.parametrize("made", [iter, lambda column: 5.0, lambda column: np.array(5.0)])
def test_what_is_no_column(made: Any, rig: Rig) -> None:
    """A generator is empty once somebody has counted it."""
    given = cycle(3)
    with pytest.raises(LinkError, match=r"`driving\.v` is no column of numbers"):
        rig.step(3, replace(given, driving={**given.driving, "v": made(given.driving["v"])}))


@pytest.mark.parametrize("made", [np.asarray, list, lambda column: np.array(list(column), object)])
def test_lengths_of_short_floats_that_lie_far_apart_there(made: Any, rig: Rig) -> None:
    """As to the door, of a candidate, a set and the car itself; what is no length is taken."""
    north = 5334572.0
    given = cycle(3)

    def short(column: Any) -> Any:
        return made((np.asarray(column, float) + north).astype(np.float32))

    with pytest.raises(LinkError, match=r"`driving\.y` is of short floats"):
        rig.step(3, replace(given, driving={**given.driving, "y": short(given.driving["y"])}))
    for name, said in (
        ("objects", {**given.signals["objects"], "x": short(given.signals["objects"]["x"])}),
        ("ego", {**given.signals["ego"], "x": np.float32(north)}),
    ):
        with pytest.raises(LinkError, match=rf"`signals\.{name}\.x` is of short floats"):
            rig.step(3, replace(given, signals={**given.signals, name: said}))
    slow = {name: made(np.asarray(column, np.float32)) for name, column in given.driving.items()}
    assert rig.step(4, replace(cycle(3), driving=slow))["about_sequence"] > 0


def test_views_of_bytes_and_numbers_beyond_a_double_are_no_column() -> None:
    for column in (memoryview(b"123"), [1.0, 10**400, 3.0]):
        with pytest.raises(LinkError, match="`v`"):
            put("v", column)
    assert put("v", memoryview(array("d", [1.0, 2.0, 3.0]))) == [1.0, 2.0, 3.0]


def test_numbers_of_elements_may_be_an_array(rig: Rig) -> None:
    """Also where no rule knows elements again, and nobody reads them."""
    objects = {**cycle(3).signals["objects"], "id": np.array([7, 8])}
    assert rig.client.send(3, 0.3, None, None, {"objects": objects}) > 0


@pytest.mark.parametrize(
    ("number", "t"), [(2**70, 0.3), (1.5, 0.3), (3, 10**400)], ids=["long", "part", "stamp"]
)
def test_what_an_entry_has_no_room_for(number: Any, t: Any, rig: Rig) -> None:
    with pytest.raises(LinkError, match="cannot be that"):
        rig.client.send(number, t, None, None, {})


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"ego": {"Age": 9.0}}, "the program reads no `signals.ego.Age`: `age`?"),
        ({"objects": {"widht": [2.0]}}, "the program reads no `signals.objects.widht`: `width`?"),
        ({"track": {"rigth": None}}, "the program reads no `signals.track.rigth`: `right`?"),
        ({"objets": {}}, "the program reads no `signals.objets`: `signals.objects`?"),
        ({"ego": {None: 1.0}}, "the program reads no `signals.ego.None`"),
        ({"ego": [1.0, 2.0]}, "`signals.ego` is given field by field, not as list"),
        ({"objects": [{"x": 1.0}]}, "`signals.objects` is given field by field, not as list"),
        ({"track": Border([(0.0, 6.0), (100.0, 6.0)])}, "`signals.track` is given field by field, not as Border"),
        ({"track": Block()}, "`signals.track` is given field by field, not as Block"),
        ({"ego": Border([(0.0, 6.0), (100.0, 6.0)])}, "`signals.ego` is given field by field, not as Border"),
        ({"ego": Block()}, "`signals.ego` is given field by field, not as Block"),
        ({"track": {"left": [(0.0, 6.0), (100.0, 6.0)]}}, "`signals.track.left` is a Border, which is made once of its points"),
    ],
)  # fmt: skip
def test_names_that_nobody_reads(changed: dict[str, Any], said: str, rig: Rig) -> None:
    """Of a field that is misspelt, the default would count: the Supervisor's own door says `unknown`."""
    with pytest.raises(LinkError) as raised:
        rig.client.send(3, 0.3, None, None, changed)
    assert str(raised.value) == said


def test_a_candidate_of_other_fields(rig: Rig) -> None:
    given = cycle(3)
    with pytest.raises(LinkError, match=r"the program reads no `driving\.speed`"):
        rig.step(3, replace(given, driving={**given.driving, "speed": given.driving["v"]}))


def test_a_fault_that_nobody_knows(rig: Rig) -> None:
    with pytest.raises(LinkError, match=r"no fault is called `not_finit`: `not_finite`\?"):
        rig.client.send(3, 0.3, None, None, {}, [("not_finit", "ego", "v", None)])


class Kept:
    """A channel that keeps what is sent, by mailbox; `full`: one over which nothing goes."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, bytes]] = []
        self.full = ""

    def send(self, box: str, message: bytearray) -> bool:
        self.sent.append((box, bytes(message)))
        return box != self.full

    def receive(self, seconds: float) -> bytes | None:
        return None

    def close(self) -> None:
        pass


def test_a_cycle_names_the_borders_that_were_sent() -> None:
    """One that did not go out is none to its cycle, and goes out with the next one, under a number of its own; without a cycle, none does."""
    channel, layout = Kept(), built().layout
    client, kind = Client(layout, channel, lambda: 0.0), layout.kinds["cycle"]
    left, right, other = (Border([(0.0, y), (100.0, y)]) for y in (6.0, -6.0, 7.0))

    def boxes(left: Border, right: Border, full: str = "", came: bool = True) -> tuple[list[str], list[int]]:
        channel.sent, channel.full = [], full
        client.send(0, 0.0, None, None, {"track": {"left": left, "right": right}}, came=came)
        data = channel.sent[-1][1]
        names = ("signals.track/present", "signals.track.left", "signals.track.right")
        return [box for box, _ in channel.sent], [kind.get(data, name) for name in names]

    assert boxes(left, right, came=False) == (["cycle"], [0, 0, 0])
    assert boxes(left, right) == (["line_0", "line_1", "cycle"], [1, 1, 1])
    assert boxes(left, right) == (["cycle"], [1, 1, 1])
    assert boxes(other, right) == (["line_0", "cycle"], [1, 2, 1])
    assert boxes(other, left, full="line_1") == (["line_1", "cycle"], [1, 2, 0])
    assert boxes(other, left) == (["line_1", "cycle"], [1, 2, 3])


def test_faults_that_were_found_are_told_as_they_are() -> None:
    """Those for which there is room; what has no name there has the one behind all, and what is nowhere is at no place."""
    channel, layout = Kept(), built().layout
    client, kind = Client(layout, channel, lambda: 0.0), layout.kinds["cycle"]
    most = kind.entries["found_name"].room
    given = [
        ("not_finite", "ego", "v", None),
        ("missing", "nobody", "nothing", 0),
        *[("missing", "ego", "x", 7)] * most,
    ]
    client.send(None, None, None, None, {}, given)
    ((_, data),) = channel.sent
    assert kind.get(data, "found_count") == most
    for name, expected in (
        ("name", [layout.faults.index(one[0]) for one in given]),
        ("signal", [layout.signals.index("ego"), len(layout.signals), layout.signals.index("ego")]),
        ("field", [layout.fields.index("v"), len(layout.fields), layout.fields.index("x")]),
        ("index", [-1, 0, 7]),
    ):
        assert list(kind.get(data, f"found_{name}"))[:3] == expected[:3], name


@pytest.mark.parametrize("closed", ["false", math.nan, 2, [True]])
def test_a_flag_that_is_none(closed: Any, rig: Rig) -> None:
    left = Border([(0.0, 6.0), (100.0, 6.0)])
    with pytest.raises(LinkError, match=r"`signals[.]track[.]closed` is True or False, not"):
        rig.client.send(3, 0.3, None, None, {"track": {"left": left, "right": left, "closed": closed}})


def test_borders_that_are_lost_are_sent_again() -> None:
    with Served(built(), udp=True) as served:

        class Deaf(Mangled):
            lost = 1

            def send(self, box: str, message: bytearray) -> bool:
                if box == "line_1" and Deaf.lost:
                    Deaf.lost -= 1
                    return True
                return super().send(box, message)

        rig = Rig(served, Deaf)
        said = rig.step(0)
        assert (said["safe"], said["wanted"], faults(said)) == (0, 0b10, ["bad_border"])
        said = rig.step(1)
        assert (said["safe"], said["wanted"]) == (1, 0)
        rig.close()


# Whoever executes -----------------------------------------------------------------------------------------------------


@pytest.mark.verifies("S-1-B-7")
def test_a_decision_of_before_is_not_taken_for_a_fresh_one(rig: Rig) -> None:
    """An earlier decision, the same again, one of a Supervisor that was replaced, one that nobody decided: all are refused."""
    executing, old = rig.executing, rig.step(3)
    new = rig.step(4)
    for data in (old.data, new.data, old.data):
        assert executing.hear(data) == "sequence"
    rig.served.kill()
    rig.served.start()
    rig.step(5)
    assert executing.hear(new.data) == "session"
    made_up = bytearray(rig.step(6).data)
    decision = rig.client.layout.kinds["decision"]
    decision.put(made_up, "about_sequence", 0)  # safe, and about no cycle
    rig.client.layout.seal(made_up, decision, new.head.session + 10**12, 1, rig.now)
    assert executing.hear(bytes(made_up)) == "content"
    assert executing.refused == {"sequence": 3, "session": 1, "content": 1}
    assert rig.at(rig.now).number == 6


def sealed(message: Message, session: int, sent: float, **changes: int) -> bytes:
    """A decision as another Supervisor, the first thing that it says, would have sent it then."""
    layout, kind = message.layout, message.kind
    data = bytearray(message.data)
    for name, value in changes.items():
        kind.put(data, name, value)
    layout.seal(data, kind, session, 1, sent)
    return bytes(data)


class Given:
    """A channel over which messages come that are at hand."""

    def __init__(self, *messages: bytes) -> None:
        self._messages = list(messages)

    def receive(self, seconds: float) -> bytes | None:
        return self._messages.pop(0) if self._messages else None

    def send(self, box: str, message: bytearray) -> bool:
        return True

    def close(self) -> None:
        pass


def test_a_decision_about_the_cycle_of_another_planner_is_no_answer(rig: Rig) -> None:
    """All planners count their messages from 1: that of one that was replaced may be decided while the next one waits."""
    said = rig.step(3)
    sequence, layout = said["about_sequence"], said.layout
    others = sealed(said, said.head.session, said.head.sent, about_session=rig.client.session - 1)
    client = Client(layout, Given(others, others))
    client.session = rig.client.session
    assert client.answer(sequence, 0.0) is None
    client.channel = Given(others, said.data)
    answer = client.answer(sequence, 0.0)
    assert answer is not None
    assert answer.data == said.data


def test_a_supervisor_whose_clock_starts_anew_is_not_alive_by_the_one_before(rig: Rig) -> None:
    """After it has said nothing for 0.05 s it is taken for dead, however late on its own clock another one was heard before."""
    said = rig.step(3)
    executing, session = Executing(said.layout, simulated=True), said.head.session
    assert executing.hear(sealed(said, session, 100.0)) == "none"
    assert executing.hear(sealed(said, session + 1, rig.now)) == "none"
    assert (executing.at(rig.now).action, executing.at(rig.now + 0.04).action) == (DRIVE, DRIVE)
    assert (executing.at(rig.now + 0.06).action, executing.at(rig.now + 0.06).why) == (FALLBACK, "silent")


@pytest.mark.verifies("S-1-B-6", "S-1-B-7")
def test_decisions_do_not_come(rig: Rig) -> None:
    """The Supervisor lives, its decisions are lost on their way: the fallback of the last one that came, until another one comes."""
    rig.now = 0.34
    assert rig.client.answer(rig.send(3, replace(cycle(3), t=0.3)), PATIENCE) is not None
    lost: list[bytes] = []
    alive = False
    while not (lost and alive):
        data = rig._ear.receive(PATIENCE)
        assert data is not None
        message = rig.client.layout.look(data, up=False)[1]
        assert message is not None
        if message.kind.name == "decision":
            lost.append(data)
        else:
            rig.executing.hear(data)
            alive = message.head.sent == 0.34
    assert rig.at(0.345).action == DRIVE
    found = rig.at(0.36)
    assert (found.action, found.why, found.number) == (FALLBACK, "outdated", 2)
    assert rig.executing.hear(lost[0]) == "none"
    assert (rig.at(0.36).action, rig.at(0.36).number) == (DRIVE, 3)


@pytest.mark.verifies("S-1-B-6")
def test_what_was_left_is_not_taken_up_again(rig: Rig) -> None:
    """The Supervisor was silent and is heard again: its last decision is still valid, and is not driven any more."""
    assert rig.at(rig.now + 0.06).why == "silent"
    rig.later(rig.now + 0.07)
    found = rig.at(rig.now)
    assert (found.action, found.why) == (FALLBACK, "left")
    rig.step(3)
    assert rig.at(rig.now).action == DRIVE


def test_a_decision_is_driven_from_its_time_on_by_who_read_the_clock_before_it_came(rig: Rig) -> None:
    """A controller looks at the clock, and takes what has come since: it has left nothing that was decided after that look."""
    rig.step(3)
    found = rig.at(rig.now - 1e-4)
    assert (found.action, found.why) == (FALLBACK, "outdated")
    found = rig.at(rig.now)
    assert (found.action, found.why, found.number) == (DRIVE, "decided", 3)


def test_simulated_decisions_are_not_for_a_car(rig: Rig) -> None:
    real = Executing(rig.client.layout)
    assert real.hear(rig.step(3).data) == "content"
    assert (real.at(rig.now).action, real.at(rig.now).why) == (NOTHING, "unheard")


def test_an_executing_layer_that_starts_hears_nothing_of_before(rig: Rig) -> None:
    late = rig.served.listening()
    executing = Executing(rig.client.layout, simulated=True)
    rig.later(0.21)
    while (data := late.receive(0.0)) is not None:
        executing.hear(data)
    assert executing.at(0.21).action == NOTHING
    late.close()


# Real time ------------------------------------------------------------------------------------------------------------

#: A busy machine is no fault here.
SLOW = Limits(shortest_gap=0.0, oldest=1.0, longest_gap=math.inf, budget=5.0)
#: As far as its rules look then.
LOOKS = Settings({"supervisor.trajectory.t_next": 1.2, "supervisor.collision.t_unseen": 1.2})


@pytest.mark.verifies("S-1-B-4")
def test_a_supervisor_that_hangs() -> None:
    """It is stopped and goes on later: the fallback is driven meanwhile, and the cycle that waited for it is stale."""
    spec = shipped()
    made = build(spec, [rule for rule in spec.rules if rule.formula is not None], SLOW, LOOKS)
    with Served(made, simulated=False) as served:
        rig = Rig(served)
        rig.executing = Executing(served.program.layout, silence=0.5)
        for number in range(2):
            rig.now = time.monotonic()
            answer = rig.client.answer(rig.send(number, replace(cycle(number), t=rig.now)), PATIENCE)
            assert answer is not None
            said = answer
        rig.listen()
        assert said["safe"] == 1
        assert said["simulated"] == 0
        assert rig.now <= said["now"] <= said["finished"] <= time.monotonic()
        os.kill(served.process.pid, signal.SIGSTOP)
        rig.now = time.monotonic()
        sequence = rig.send(2, replace(cycle(2), t=rig.now))
        assert rig.client.answer(sequence, 1.2) is None
        rig.listen()
        found, end = rig.at(time.monotonic()), said["fallback/due"][said["fallback/count"] - 1]
        assert found.why == "silent"
        assert (found.action, found.number) == ((FALLBACK, 1) if time.monotonic() <= end else (NOTHING, 0))
        os.kill(served.process.pid, signal.SIGCONT)
        answer = rig.client.answer(sequence, PATIENCE)
        assert answer is not None
        assert (answer["safe"], faults(answer)) == (0, ["stale"])
        rig.listen()
        assert rig.at(time.monotonic()).action != DRIVE
        rig.close()


@pytest.mark.parametrize("udp", [False, True], ids=["shared memory", "datagrams"])
def test_a_supervisor_that_hears_nothing_lives_and_says_that_a_cycle_is_missing(udp: bool) -> None:
    """In real time, by itself: whoever executes takes it for dead 0.05 s after its last sign of life, and cycles come less often than that."""
    spec = tm.loads(SEEN)
    made = build(spec, list(spec.rules), replace(Limits.of(spec), budget=1e3))
    with Served(made, udp, simulated=False) as served:
        client = Client(made.layout, served.channel())
        sequence, until = client.send(0, time.monotonic(), None, None, {}), time.monotonic() + PATIENCE
        beats, found = set[int](), dict[int, list[str]]()
        while len(beats) < 3 or 0 not in found:
            message = client.hear(PATIENCE)
            assert message is not None
            assert time.monotonic() < until
            if message.kind.name == "beat":
                beats.add(message.head.sequence)
            else:
                found[message["about_sequence"]] = faults(message)
        assert found[0] == ["missing_cycle"]
        assert found.keys() <= {0, sequence}
        client.close()


def test_it_ends_when_it_is_told_to() -> None:
    with Served(built()) as served:
        served.process.terminate()
        assert served.process.wait(PATIENCE) == 0


def test_files_of_shared_memory_have_their_room_from_the_start(tmp_path: Path) -> None:
    """Else a full disk ends whoever writes into them first, while it drives. On a disk, where no locked page has it taken anyway."""
    program, name = built(), str(tmp_path / "one")
    served = start(program, shm=name, simulated=True)
    served.kill()
    served.communicate()
    for file in program.layout.said["memory"]["files"]:
        about = os.stat(f"{name}.{file['name']}")
        assert about.st_size == file["size"] <= about.st_blocks * 512
        assert about.st_mode & 0o077 == 0  # whoever may write there can pose as the planner


def mailboxes(folder: Path) -> tuple[Region, Region]:
    """What a Supervisor of the shipped spec makes for cycles, opened by who writes there and by who reads."""
    layout = built().layout
    memory = layout.said["memory"]
    size = next(file["size"] for file in memory["files"] if file["name"] == "cycles")
    begin = struct.pack("<IIQQ", memory["magic"], memory["version"], layout.fingerprint, size)
    (folder / "one").write_bytes(begin.ljust(size, b"\0"))
    writing, reading = (Region(layout, "cycles", str(folder / "one"), own) for own in (True, False))
    return writing, reading


class Slots:
    """Words of a slot, of which one changes once its turn was looked at: a writer that is faster than its reader."""

    def __init__(self, words: Any, place: int, turn: int) -> None:
        self.words, self.place, self.turns = words, place, [turn]

    def __getitem__(self, place: int) -> int:
        return self.turns.pop() if place == self.place and self.turns else int(self.words[place])


class Written:
    """Memory that tells when it is written into."""

    def __init__(self, tell: Callable[[], None]) -> None:
        self.tell = tell

    def __setitem__(self, place: slice, value: Any) -> None:
        self.tell()

    def release(self) -> None:
        pass


def test_a_slot_that_is_written_while_it_is_read_is_not_taken(tmp_path: Path) -> None:
    """Not what was whole before and is not any more, nor what is not whole yet; it is not looked at again until another one comes."""
    writing, reading = mailboxes(tmp_path)
    box = reading._boxes["tick"]
    length = reading._lengths[box["message"]]
    writing.put("tick", bytearray(b"a" * length))
    assert reading.get("tick", 0) == (1, b"a" * length)
    assert reading.get("tick", 1) == (1, None)
    place, words = (box["first"] + box["step"]) // 8, reading._words
    for turn in (1, 2 * box["slots"] + 1):  # for the first time, or by one that is a round ahead
        writing._words[place] = turn
        assert reading.get("tick", 0) == (1, None)
        reading._words = Slots(words, place, 2)  # type: ignore[assignment]
        assert reading.get("tick", 0) == (1, None)
        reading._words = words
    following, seen = (box["first"] + 2 % box["slots"] * box["step"]) // 8, list[int]()
    into = writing._bytes
    writing._bytes = Written(lambda: seen.append(writing._words[following]))  # type: ignore[assignment]
    writing.put("tick", bytearray(b"b" * length))
    writing._bytes = into
    assert seen == [3]  # odd: message 2 is being written
    writing.close()
    reading.close()


class Told:
    """A part of memory that tells of what is written into it, in order."""

    def __init__(self, part: Any, name: str, told: list[tuple[str, Any]]) -> None:
        self.part, self.name, self.told = part, name, told

    def __getitem__(self, place: Any) -> Any:
        return self.part[place]

    def __setitem__(self, place: Any, value: Any) -> None:
        self.told.append((self.name, place))
        self.part[place] = value


def test_a_message_is_whole_before_it_is_the_newest_and_the_bell_rings_last(tmp_path: Path) -> None:
    """From Python, too: who looked between two writes lost it, or slept on as it came."""
    writing, reading = mailboxes(tmp_path)
    box, told = reading._boxes["tick"], list[tuple[str, Any]]()
    length, slot = reading._lengths[box["message"]], box["first"] + box["step"]
    names = ("_words", "_bytes", "_halves")
    own = [getattr(writing, name) for name in names]
    for name, part in zip(names, own):
        setattr(writing, name, Told(part, name, told))
    writing.put("tick", bytearray(length))
    assert told == [
        ("_words", slot // 8), ("_bytes", slice(slot + 64, slot + 64 + length)), ("_words", slot // 8), ("_words", box["place"] // 8),
        ("_halves", writing._bell),
    ]  # fmt: skip
    for name, part in zip(names, own):
        setattr(writing, name, part)
    writing.close()
    reading.close()


def test_the_bell_begins_anew(tmp_path: Path) -> None:
    """After 2^32 messages, in 32 bits: 7 years of 20 cycles a second."""
    writing, reading = mailboxes(tmp_path)
    length = reading._lengths[reading._boxes["tick"]["message"]]
    writing._halves[writing._bell] = 0xFFFF_FFFF
    heard = reading.heard
    writing.put("tick", bytearray(length))
    assert (heard, reading.heard) == (0xFFFF_FFFF, 0)
    begin = time.monotonic()
    reading.wait(heard, 60.0)  # it has rung
    assert time.monotonic() - begin < PATIENCE
    writing.close()
    reading.close()


def test_shared_memory_without_room_says_why(tmp_path: Path) -> None:
    def small() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

    done = subprocess.run(
        built().command(shm=str(tmp_path / "one")),
        capture_output=True, text=True, check=False, preexec_fn=small, restore_signals=False, timeout=PATIENCE,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")  # as of every verb: nothing was found, nothing began
    assert done.stderr == f"{tmp_path}/one.cycles cannot be made: File too large\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.lock"]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="nobody says how much is locked")
def test_it_serves_however_much_memory_may_be_locked(tmp_path: Path) -> None:
    """Where all but its shared memory fitted, that could not be mapped: the lock was on whatever came behind it, too."""
    program, most = built(), resource.getrlimit(resource.RLIMIT_MEMLOCK)[1]

    def served(limit: int) -> dict[str, int]:
        """Bytes that it takes, and that are locked."""

        def limited() -> None:
            # PR_CAPBSET_DROP, CAP_IPC_LOCK: the limit is for root, too.
            ctypes.CDLL(None).prctl(24, 14, 0, 0, 0)
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (limit, limit))

        command = program.command(shm=str(tmp_path / "one"))
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, preexec_fn=limited  # noqa: PLW1509
        ) as process:  # fmt: skip
            assert process.stdout is not None
            try:
                assert process.stdout.readline() == f"serves {tmp_path}/one\n", limit
                lines = Path(f"/proc/{process.pid}/status").read_text("ascii").splitlines()
            finally:
                process.kill()
        sizes = (line.split() for line in lines if line.startswith(("VmSize", "VmLck")))
        return {name.rstrip(":"): int(size) * 1024 for name, size, _ in sizes}

    none = served(0)
    assert none["VmLck"] == 0
    shared = sum(file["size"] for file in program.layout.said["memory"]["files"])
    for limit in range(none["VmSize"] - 2 * shared, none["VmSize"], 2 * shared // 3):
        served(limit)
    enough = 2 * none["VmSize"]
    if most in (resource.RLIM_INFINITY, max(most, enough)):
        assert served(enough)["VmLck"] > shared


@pytest.mark.parametrize("dies", [True, False])
def test_a_planner_connects_anew_whoever_it_has_forked(dies: bool, tmp_path: Path) -> None:
    """A worker that lived on had the file open as well, and with it the lock: "is written by another client", the planner was told, also the next
    one, of one that had died. What the worker closes is not the planner's."""
    writing, reading = mailboxes(tmp_path)
    writing.close()
    (begin, end), (told, tell) = os.pipe(), os.pipe()
    planner = os.fork()
    if planner == 0:
        own = Region(built().layout, "cycles", writing.path, True)
        if os.fork() == 0:
            own.close()
            os.write(tell, b"!")
            os.close(end)
            os.read(begin, 1)  # for as long as the test goes on
            os._exit(0)
        os.read(told, 1)
        if not dies:
            try:
                Region(built().layout, "cycles", writing.path, True)
            except LinkError:
                own.close()
                Region(built().layout, "cycles", writing.path, True)
                os._exit(10)
        os._exit(10 if dies else 11)
    assert os.waitstatus_to_exitcode(os.waitpid(planner, 0)[1]) == 10
    Region(built().layout, "cycles", writing.path, True).close()
    for pipe in (end, begin, told, tell):
        os.close(pipe)
    reading.close()


def test_one_supervisor_and_one_planner_for_a_name() -> None:
    with Served(built()) as served:
        other = Served.__new__(Served)
        other.program, other.simulated, other._wait, other.name = served.program, True, "sleep", served.name
        with pytest.raises(TrackmarshalError, match="another Supervisor serves") as caught:
            other.start()
        assert caught.value.code == "E477"
        first = served.channel()
        with pytest.raises(LinkError, match="is written by another client"):
            served.channel()
        first.close()
    with pytest.raises(LinkError, match="no Supervisor has made it"):
        served.channel()
