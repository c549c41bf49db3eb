"""A Supervisor that is a process of its own, with a planner and an executing layer around it, in simulated time."""

from __future__ import annotations

import itertools
import os
import socket
import subprocess
import time
from collections.abc import Callable
from functools import cache
from typing import Any

from support.cycles import PERIOD, cycle
from support.supervised import shipped
from trackmarshal.process.client import Border, Client
from trackmarshal.process.datagrams import Datagrams
from trackmarshal.process.executing import Executing, Setpoint
from trackmarshal.process.messages import Message
from trackmarshal.process.serving import Built, build, remove, shared_path, start
from trackmarshal.process.shared_memory import SharedMemory
from trackmarshal.runtime.cycle import Cycle, Limits

#: Real seconds that a busy machine may take for anything.
PATIENCE = 20.0
_names = itertools.count(1)


@cache
def built(limits: Limits | None = None) -> Built:
    """The shipped Supervisor as a process."""
    spec = shipped()
    return build(spec, [rule for rule in spec.rules if rule.formula is not None], limits)


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        asked.bind(("127.0.0.1", 0))
        return int(asked.getsockname()[1])


class Served:
    """A process that serves, over shared memory or over datagrams; `with` ends it."""

    def __init__(
        self, program: Built, udp: bool = False, simulated: bool = True, wait: str = "sleep"
    ) -> None:
        self.program, self.simulated, self._wait = program, simulated, wait
        self.name = None if udp else f"trackmarshal-test-{os.getpid()}-{next(_names)}"
        self.port, self.listener = (free_port(), free_port()) if udp else (0, 0)
        self.process: subprocess.Popen[str]
        self.start()

    def start(self) -> None:
        if self.name is not None:
            self.process = start(self.program, shm=self.name, simulated=self.simulated, wait=self._wait)
        else:
            self.process = start(
                self.program, udp=self.port, to=[self.listener], simulated=self.simulated, wait=self._wait
            )

    def channel(self, program: Built | None = None) -> Any:
        """For a planner."""
        layout = (program or self.program).layout
        return (
            Datagrams(layout, self.port)
            if self.name is None
            else SharedMemory(layout, shared_path(self.name))
        )

    def listening(self) -> Any:
        """For an executing layer."""
        if self.name is None:
            return Datagrams(self.program.layout, self.listener, executing=True)
        return SharedMemory(self.program.layout, shared_path(self.name), executing=True)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        self.process.stdout.close()
        self.process.stderr.close()

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
        if self.name is not None:
            remove(self.name)


class Rig:
    """A planner on a straight road, one cycle each tenth of a second, and an executing layer: `now` is what their clocks show."""

    def __init__(self, served: Served, wrap: Callable[[Any], Any] = lambda channel: channel) -> None:
        self.served, self._wrap = served, wrap
        self.now = 0.0
        self._ear = served.listening()
        self.executing = Executing(served.program.layout, simulated=served.simulated)
        self.connect()

    def connect(self) -> None:
        """A planner that has just started."""
        self.client = Client(self.served.program.layout, self._wrap(self.served.channel()), lambda: self.now)
        self._borders: dict[str, Border] = {}

    def send(self, number: int, given: Cycle | None = None) -> int:
        """Send a cycle; the sequence of its message."""
        given = cycle(number) if given is None else given
        signals = dict(given.signals)
        for name in ("objects", "obstacles"):
            signals[name] = {field: column for field, column in signals[name].items() if field != "id"}
        for name in ("left", "right"):
            self._borders.setdefault(name, Border(signals["track"][name]))
        signals["track"] = dict(self._borders)
        return self.client.send(given.number, given.t, given.driving, given.emergency, signals)

    def step(self, number: int, given: Cycle | None = None) -> Message:
        """A cycle at its time, its decision, which the executing layer has heard too."""
        self.now = number * PERIOD if given is None else given.t
        message = self.client.answer(self.send(number, given), PATIENCE)
        assert message is not None
        self.heard(message)
        return message

    def later(self, now: float) -> Message | None:
        """Time passes without a cycle; a decision that follows from that, where one does."""
        self.now = now
        sequence, found = self.client.tick(), None
        until = time.monotonic() + PATIENCE
        while not self._told(sequence):
            message = self.client.hear(PATIENCE)
            assert message is not None
            assert time.monotonic() < until
            if message.kind.name == "decision":
                found = message
        if found is not None:
            self.heard(found)
        self.listen(sequence)
        return found

    def heard(self, decision: Message) -> None:
        """Let the executing layer hear all up to a decision."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            data = self._ear.receive(PATIENCE)
            assert data is not None
            self.executing.hear(data)
            if data == decision.data:
                return
        raise AssertionError("the decision did not come to the executing layer")

    def listen(self, sequence: int = 0) -> None:
        """Let the executing layer hear all that there is, and in any case a sign of life that a message was heard."""
        layout, told = self.client.layout, sequence == 0
        while (data := self._ear.receive(0.0 if told else PATIENCE)) is not None:
            self.executing.hear(data)
            message = layout.look(data, up=False)[1]
            if (
                message is not None
                and message.kind.name == "beat"
                and message["client"] == self.client.session
            ):
                told = told or message["heard"] >= sequence
        assert told

    def refused(self) -> dict[str, int]:
        """What the process has refused so far, by cause, once it has taken a further tick."""
        self.later(self.now)
        assert self.client.beat is not None
        counts = self.client.beat["refused"].tolist()
        return {cause: count for cause, count in zip(self.client.layout.causes, counts) if count}

    def at(self, now: float) -> Setpoint:
        return self.executing.at(now)

    def _told(self, sequence: int) -> bool:
        """Whether a sign of life says that a message was heard."""
        beat = self.client.beat
        return beat is not None and beat["client"] == self.client.session and beat["heard"] >= sequence

    def close(self) -> None:
        self.client.close()
        self._ear.close()
