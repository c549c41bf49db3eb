"""The Supervisor as a process of its own: from sending a cycle to having its decision, in real time.

Seconds of the clock on the wall, not of the processor: what is waited for counts. So how busy the machine is counts too, and the fastest tenth
says what it takes where nothing else is in the way. A cycle has two trajectories of 50 points, 3 objects and borders of 2 x 1500 points, which
do not change; cycles come 2 ms after one another. TRACKMARSHAL_STEPS: how many (default 4000).
"""

from __future__ import annotations

import itertools
import math
import os
import subprocess
import tempfile
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from bench_supervisor import cycles

from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.example import example
from trackmarshal.backends.c.process.emit import Emitted
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import load
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.process.client import Client
from trackmarshal.process.datagrams import Datagrams
from trackmarshal.process.serving import Built, build, remove, shared_path, start
from trackmarshal.process.shared_memory import SharedMemory
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.frame import NO_SETTINGS
from trackmarshal.scenarios.cycle_file import _lines

ROOT = Path(__file__).resolve().parents[2]
STEPS = int(os.environ.get("TRACKMARSHAL_STEPS", "4000"))
#: Of cycles in a file.
FILED = 200
PERIOD = 0.002
MEMORY = "Process: shared memory, C client"
LIMITS = {
    f"{MEMORY}, to the decision": 150e-6,
    f"{MEMORY}, to the decision, 99.9 %": 1e-3,
}
#: The cycles say nothing about pace and pose.
FREE = replace(Limits.open_loop(), samples=128, elements=32, border=2048)
_PORT = 45_871


def measure() -> dict[str, float]:
    """Seconds by name; nothing where there is no compiler."""
    if compiler() is None:
        return {}
    spec = load([ROOT / "specs" / "supervisor"])
    rules = [rule for rule in spec.rules if rule.formula is not None]
    program = build(spec, rules, FREE)
    result: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        client = _client(folder, spec, rules)
        ways = [(MEMORY, "sleep", False), ("Process: datagrams, C client", "sleep", True)]
        if (
            os.getloadavg()[0] < 0.5
        ):  # two that spin keep two processors busy, and wait for each other where others want them
            ways.append((f"{MEMORY}, both spinning", "spin", False))
        for name, wait, udp in ways:
            result |= _in_c(name, program, client, folder, wait, udp)
    for name, udp in (
        ("Process: shared memory, Python client", False),
        ("Process: datagrams, Python client", True),
    ):
        result |= _in_python(name, program, spec, rules, udp)
    return result


def _client(folder: Path, spec: Spec, rules: list[RuleInfo]) -> Path:
    """`linked.c` with the emitted client, and a file of cycles."""
    source = generate(spec, rules, doored=True)
    made = Emitted(source, asdict(FREE))
    files = {
        **made.files,
        **example(source),
        "supervisor.h": source.header,
        "linked.c": Path(__file__).with_name("linked.c").read_text(),
    }
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    given = ((cycle, cycle.t, cycle.t) for cycle in itertools.islice(cycles(frozen=True), FILED))
    (folder / "some.cycles").write_text(
        "".join(f"{line}\n" for line in _lines(source, NO_SETTINGS, FREE, given))
    )
    units = ["linked.c", "client.c", "cycles.c", "mailbox.c", "messages.c"]
    command = compiler()
    assert command is not None
    sizes = [f"-D{name}={size}" for name, size in made.sizes.items()]
    subprocess.run(
        [*command, "-std=c99", "-O2", *sizes, "-o", "linked", *units, "-lm"], cwd=folder, check=True
    )
    return folder / "linked"


def _spent(process: int) -> float:
    """CPU seconds of a process."""
    words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def _in_c(name: str, program: Built, client: Path, folder: Path, wait: str, udp: bool) -> dict[str, float]:
    where: list[str] = ["--udp", str(_PORT)] if udp else ["--shm", str(folder / "memory")]
    served = (
        start(program, udp=_PORT, wait=wait) if udp else start(program, shm=str(folder / "memory"), wait=wait)
    )
    try:
        rounds = max(1, STEPS // FILED)
        before = _spent(served.pid)
        done = subprocess.run(
            [client, folder / "some.cycles", str(rounds), str(PERIOD), wait, *where],
            capture_output=True,
            text=True,
            check=True,
        )
        spent = _spent(served.pid) - before
    finally:
        served.kill()
        served.communicate()
    whole, arrived, inside = (
        np.array([line.split() for line in done.stdout.splitlines()], dtype=float).T / 1e6
    )
    result = _told(name, whole)
    result[f"{name}, of it until it has arrived"] = float(np.median(arrived))
    result[f"{name}, of it in the process"] = float(np.median(inside))
    if wait == "sleep":
        result[f"{name}, CPU of the process, a cycle"] = spent / len(whole)
    return result


def _in_python(name: str, program: Built, spec: Spec, rules: list[RuleInfo], udp: bool) -> dict[str, float]:
    shared = f"trackmarshal-bench-{os.getpid()}"
    served = start(program, udp=_PORT) if udp else start(program, shm=shared)
    channel: Any = (
        Datagrams(program.layout, _PORT) if udp else SharedMemory(program.layout, shared_path(shared))
    )
    supervisor = RemoteSupervisor(spec, rules, Client(program.layout, channel), FREE, patience=5.0)
    spent = np.ones(STEPS)
    try:
        given = cycles(frozen=True)
        for k in range(STEPS + 100):
            cycle = replace(next(given), t=time.monotonic())
            time.sleep(PERIOD)
            begin = time.perf_counter()
            decision = supervisor.step(cycle)
            took = time.perf_counter() - begin
            assert decision.safe, decision.reasons
            if k >= 100:
                spent[k - 100] = took
    finally:
        supervisor.close()
        served.kill()
        served.communicate()
        if not udp:
            remove(shared)
    return _told(name, spent)


def _told(name: str, spent: Any) -> dict[str, float]:
    tenth, middle, late = np.quantile(spent, [0.1, 0.5, 0.999])
    assert math.isfinite(late)
    return {
        f"{name}, to the decision": float(middle),
        f"{name}, to the decision, fastest tenth": float(tenth),
        f"{name}, to the decision, 99.9 %": float(late),
    }


if __name__ == "__main__":
    for what, value in measure().items():
        print(f"{value * 1e6:12.1f} us  {what}")
