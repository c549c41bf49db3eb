"""`trackmarshal serve`, and what `compile --process` writes for Python."""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.processes import PATIENCE, built
from support.shared import REPOSITORY, SUPERVISOR
from support.supervised import shipped
from trackmarshal.backends.c import build as compiling
from trackmarshal.backends.c.example import example
from trackmarshal.backends.c.process import emit
from trackmarshal.backends.c.process.emit import Emitted
from trackmarshal.backends.c.process.messages import SIZES
from trackmarshal.backends.c.source import generate, generated
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.cli import serve
from trackmarshal.cli.compile import _TAKEN
from trackmarshal.cli.main import main
from trackmarshal.errors import TrackmarshalError
from trackmarshal.process.copies import link
from trackmarshal.process.datagrams import Datagrams
from trackmarshal.process.messages import Layout, LinkError
from trackmarshal.process.serving import build
from trackmarshal.runtime.cycle import Limits

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")

#: What can be supervised.
PLAIN = """module plain
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
rule slow ""
  for all p in plan
  require p.v <= 30 m/s
"""
#: A planner that has nothing but Python and what was emitted.
PLANNER = """
import sys
sys.path.insert(0, sys.argv[1])
from link.client import Border, Client
from link.executing import Executing
from link.messages import Layout
from link.shared_memory import SharedMemory

layout = Layout.read(sys.argv[2])
client = Client(layout, SharedMemory(layout, sys.argv[3]), lambda: 0.0)
ear, executing = SharedMemory(layout, sys.argv[3], executing=True), Executing(layout, simulated=True)
left, right = Border([[-50, 6], [2000, 6]]), Border([[-50, -6], [2000, -6]])
t = [0.1 * k for k in range(30)]
zero = [0.0] * 30
driving = {"t": t, "s": [20 * x for x in t], "x": [20 * x for x in t], "y": zero, "heading": zero, "kappa": zero, "v": [20.0] * 30, "a": zero}
v = [max(0.0, 20 - 8 * x) for x in t]
s = [20 * x - 4 * x * x if x < 2.5 else 25.0 + 1e-4 * x for x in t]
emergency = {**driving, "s": s, "x": s, "v": v, "a": [-8.0 if x < 2.5 else 0.0 for x in t]}
signals = {
    "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0},
    "objects": {name: [] for name in ("x", "y", "heading", "v", "length", "width")},
    "obstacles": {name: [] for name in ("x", "y", "heading", "length", "width")},
    "track": {"left": left, "right": right},
}
decision = client.answer(client.send(0, 0.0, driving, emergency, signals), 20.0)
print(decision["safe"], layout.states[decision["state"]], len(decision.column("driving", "x")))
while executing.hear(ear.receive(20.0)) != "none" or executing.at(0.0).why == "unheard":
    pass
print(executing.at(0.05).action, executing.at(0.05).sample["x"])
print([name for name in sys.modules if name.startswith(("trackmarshal", "numpy"))])
"""


#: The command in a process of its own, which compiles as this one does: what is kept of the one is there for the other. `make acceptance` has what ships.
COMMAND = """
import sys
from trackmarshal.backends.c import build
from trackmarshal.cli.main import main
build.FAST = tuple(sys.argv.pop(1).split())
sys.exit(main())
"""


@pytest.mark.verifies("S-1-B-3")
def test_it_serves_a_planner_that_has_nothing_of_trackmarshal(tmp_path: Path) -> None:
    messages, memory = tmp_path / "messages.json", tmp_path / "memory"
    for path, text in link().items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text, encoding="utf-8")
    command = [
        sys.executable, "-c", COMMAND, " ".join(compiling.FAST), "serve", str(SUPERVISOR), "--project", str(REPOSITORY), "--shm", str(memory),
        "--describe", str(messages), "--simulated",
    ]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == f"serves {memory}\n"
        words = [sys.executable, "-I", "-c", PLANNER, str(tmp_path), str(messages), str(memory)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=3 * PATIENCE, check=False)
        assert done.stdout.splitlines() == ["1 drive 30", "drive 1.0", "[]"], done.stderr
    finally:
        process.terminate()
        assert process.communicate()[1] == "note: in simulated time, which no vehicle drives in\n"
    assert process.returncode == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--shm", "x", "--limit", "bugdet=1"], "error[E481]: there is no limit `bugdet`"),
        (["--shm", "x", "--limit", "budget=soon"], "error[E481]: `soon` is no number for the limit `budget`"),
        (["--shm", "x", "--limit", "samples=1"], "error[E481]: the limit `samples` is 1"),
        (
            ["--shm", "x", "--limit", "budget=1", "--limit", "budget=2"],
            "error[E481]: the limit `budget` is given twice",
        ),
        (["--shm", "x", "--to", "7000"], "error[E477]: --to is for datagrams"),
        (["--udp", "70000"], "error[E477]: 70000 is no port"),
        (["--udp", "7000", "--to", "0"], "error[E477]: 0 is no port"),
        (
            ["--udp", "7000", "--to", "7001", "--to", "7000"],
            "error[E477]: cycles come to port 7000, and decisions would, too",
        ),
        (
            ["--udp", "7000", *(f"--to={port}" for port in range(7001, 7010))],
            "error[E477]: decisions would go to 9 other ports, and there is room for 8",
        ),
    ],
)
def test_what_it_refuses(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", str(SUPERVISOR), *words]) == 2
    assert said in capsys.readouterr().err


def test_there_is_room_for_as_many_ports_as_in_the_process() -> None:
    """The number stands in both; of one more, the process would print its own usage."""
    template = Path(emit.__file__).parent / "templates" / "process.c"
    assert f"#define MOST_LISTENERS {serve.MOST_LISTENERS}u\n" in template.read_text("utf-8")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        # In simulated time, each sign of life was answered by another one: 25,000 a second, beside which decisions were lost.
        ("--udp 7000 --to 7001 --to 7000 --simulated", "--to is another port than --udp"),
        # It served files without a name in the folder that it was started in.
        ("--shm", "--shm has a path"),
        # Who listened there heard nothing.
        ("--shm one --to 7001", "--to is for datagrams: in shared memory anybody may read decisions"),
    ],
)
def test_what_the_process_itself_refuses(words: str, said: str, tmp_path: Path) -> None:
    command = [str(built().path), *words.split()]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=PATIENCE
    )
    assert (done.returncode, done.stderr.split("\n")[0]) == (2, said)
    assert list(tmp_path.iterdir()) == []


def described(limits: Limits) -> dict[str, Any]:
    """The description of the shipped Supervisor's messages with other limits."""
    spec = shipped()
    source = generated(spec, [rule for rule in spec.rules if rule.formula is not None], doored=True)
    return Emitted(source, asdict(limits)).description


def test_a_message_that_no_datagram_takes() -> None:
    """A border of 4090 points is longer than 65,507 bytes."""
    assert described(Limits(border=4089))["datagrams"]
    layout = Layout(described(Limits(border=4090)))
    assert not layout.datagrams
    with pytest.raises(LinkError, match="a message is too long for a datagram"):
        Datagrams(layout, 7000)


@pytest.mark.acceptance
def test_the_process_knows_that_too() -> None:
    program = built(Limits(border=4090))
    done = subprocess.run(program.command(udp=7000), capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "a message is too long for a datagram" in done.stderr


def test_a_spec_that_cannot_supervise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "own.spec"
    spec.write_text('module own\nsignal ego : state { v: m/s }\nrule slow "Slow"\n  require ego.v <= 3 m/s\n')
    assert main(["serve", str(spec), "--shm", "x"]) == 2
    assert (
        "error[E477]: no Supervisor can be made of this spec: it declares no trajectory `plan`"
        in capsys.readouterr().err
    )
    assert main(["compile", str(spec), "--out", str(tmp_path / "out"), "--process"]) == 2
    assert "error[E477]" in capsys.readouterr().err
    assert main(["compile", str(spec), "--out", str(tmp_path / "out"), "--limit", "budget=1"]) == 2
    assert "error[E481]: limits are compiled in with --process only" in capsys.readouterr().err


@pytest.mark.parametrize("made", [build, CSupervisor])
def test_without_a_rule_there_is_no_supervisor(made: Any) -> None:
    """As where rules are chosen by names: of a list that a filter left empty, a process was built that found every cycle safe."""
    with pytest.raises(TrackmarshalError, match="without a rule, anything would be safe") as caught:
        made(shipped(), [])
    assert caught.value.code == "E404"


def test_it_says_why_no_supervisor_can_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A plan in km/h looks as if it could be supervised: neither a process nor tm_step came of it, and nothing said why."""
    spec = tmp_path / "own.spec"
    spec.write_text(
        'module own\nsignal plan : trajectory { t: s increasing, v: km/h }\nrule slow "Slow"\n  for all p in plan\n  require p.v <= 3 km/h\n'
    )
    why = "`plan.v` is declared in km/h, not in m/s"
    assert main(["serve", str(spec), "--shm", "x"]) == 2
    assert f"error[E477]: no Supervisor can be made of this spec: {why}" in capsys.readouterr().err
    assert main(["compile", str(spec), "--out", str(tmp_path / "out"), "--process"]) == 2
    assert f"so it cannot be a process: {why}" in capsys.readouterr().err
    assert main(["compile", str(spec), "--out", str(tmp_path / "out")]) == 0
    assert f"note: without a Supervisor, as {why}: rules alone" in capsys.readouterr().err


def test_a_name_by_which_nothing_could_be_built_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A header of the system was looked for in the folder, and found there; CMake, and the linker of `-lm`, know the others as something else."""
    out = tmp_path / "out"
    for name in ("math", "Stdio", "all", "help", "m", "mailbox"):
        assert main(["compile", str(SUPERVISOR), "--out", str(out), "--name", name]) == 2
        assert f"error[E474]: `{name}` is no name for a C file" in capsys.readouterr().err
    spec = tm.loads(PLAIN)
    source = generate(spec, list(spec.rules), "car", doored=True)
    texts = {
        "car.c": source.source, "car.h": source.header, **example(source, None), **Emitted(source, asdict(Limits())).files,
    }  # fmt: skip
    read = {name for text in texts.values() for name in re.findall(r"#include <(\w+)\.h>", text)}
    written = {name[:-2] for name in texts if name.endswith((".c", ".h"))} - {"car"}
    assert {"math", "poll"} < read
    assert {"main", "desk"} < written
    assert read | written <= _TAKEN


def test_a_context_that_no_machine_has_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is remembered of pairs grows with the square: 186,265 GiB stood in the report, and nowhere else."""
    text = (
        "module own\nsignal os : set of object {{ v: m/s }} capacity {capacity} forget 1000 s\n"
        'rule slow "Slow"\n  for all a in os\n  for all b in os\n  require not once[0 s, {window} s] (a.v > b.v and b.v > 3 m/s)\n'
    )
    spec = tmp_path / "own.spec"
    for capacity, window, told in ((1000, 100000, True), (8, 1, False)):
        spec.write_text(text.format(capacity=capacity, window=window))
        assert main(["compile", str(spec), "--out", str(tmp_path / "out")]) == 0
        assert ("note: the context takes 186,264.8 GiB" in capsys.readouterr().err) == told


def test_entries_stand_one_after_the_other() -> None:
    """Each at a multiple of its size, without gaps or overlaps, up to the length; all of them are explained."""
    for message in built().layout.said["messages"]:
        place = 0
        for entry in message["entries"]:
            size = SIZES[entry["type"]]
            assert entry["offset"] == place
            assert place % size == 0
            assert entry["about"]
            place += size * entry["count"]
        assert place == message["length"]
        assert place % 8 == 0


def test_what_makes_another_layout() -> None:
    """Limits and capacities, each by itself."""
    given = [Limits(), Limits(budget=0.04), Limits(samples=65), Limits(elements=33)]
    assert len({described(limits)["layout"] for limits in given}) == 4
    assert described(Limits())["layout"] == f"{built().layout.fingerprint:016x}"


@pytest.mark.verifies("S-1-B-2")
def test_nothing_is_allocated() -> None:
    """The process asks the C library for no memory."""
    listed = subprocess.run(["nm", "-u", built().path], capture_output=True, text=True, check=True).stdout
    wanted = re.findall(r"U (\w+)", listed)
    assert "mmap" in wanted
    assert [name for name in wanted if re.search("alloc|brk|free$|strdup|getline", name)] == []


def test_the_page_has_the_layout() -> None:
    """The tables of docs/process.md are those of the messages: entries that all specs have, kinds, causes."""
    page = (REPOSITORY / "docs" / "process.md").read_text("utf-8")
    said = built().layout.said
    for message in said["messages"]:
        assert f"| `{message['name']}` | {message['kind']} |" in page
    head = list(
        itertools.takewhile(lambda entry: entry["offset"] < said["head"], said["messages"][0]["entries"])
    )
    for entry in head:
        assert f"| {entry['offset']} | `{entry['name']}` | {entry['type']} |" in page
    for cause in said["causes"][1:]:
        assert f"| `{cause}` |" in page
