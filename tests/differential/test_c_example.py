"""The emitted example is a complete Supervisor: from a file of cycles it decides what the Supervisor in Python decides."""

from __future__ import annotations

import math
import random
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

import trackmarshal as tm
from support import embedded
from support.cycles import PERIOD, cycle, mutate
from support.decision_lines import decision_lines
from support.emitted import SCENARIOS, emit, name_of
from support.length import amount, shared_out
from support.sanitized import FLAGS as SANITIZED
from support.sanitized import unit
from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal import scenarios
from trackmarshal.backends.c.build import EXACT
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.scenarios.overrides import known_tables

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
#: numpy has an arc tangent of its own, which this rule asks for (docs/generated-c.md, Agreement).
OWN = "heading_integrity"
#: One in so many scenarios is decided every day. Of these two, the files are spoilt.
EVERY, SPOILT = 5, ("debris", "wrong_way")
DAILY = SCENARIOS[::EVERY]


@pytest.fixture(scope="module")
def spec() -> Spec:
    return tm.load([SUPERVISOR], [REPOSITORY / "specs" / "tracks" / "northfield.spec"], REPOSITORY)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Program and files of the shipped scenarios that are asked for. The sanitizers watch over all that it does."""
    asked = [path for path in SCENARIOS if path in DAILY or name_of(path) in SPOILT]
    return built(emit(tmp_path_factory.mktemp("example"), recordings=amount(asked, SCENARIOS)))


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same for runs that name no track."""
    return built(emit(tmp_path_factory.mktemp("plain"), recordings=[]))


def built(folder: Path) -> Path:
    """The example in a folder, compiled around an object that is kept."""
    name = "supervisor.c"
    files = {each: (folder / each).read_text("utf-8") for each in (name, "supervisor.h")}
    made = unit(files, name, "gcc")
    flags = [*EXACT, *embedded.STRICT, *SANITIZED]
    command = ["gcc", *flags, "main.c", "cycles.c", str(made), "-o", "example", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def said_of(run: Path, plain: Path, out: Path) -> list[str]:
    """What the example says of a record of a run, whose program is the one that is built."""
    made = emit(out, recordings=[run])
    assert all(
        (made / name).read_bytes() == (plain / name).read_bytes()
        for name in ("supervisor.c", "supervisor.h", "main.c", "cycles.c", "cycles.h")
    )
    return list(embedded.run(plain / "example", made / "run.cycles").lines)


def python_says(recording: Path, spec: Spec, backend: str) -> list[str]:
    found = scenarios.load(recording)
    now = math.nan
    supervisor = tm.supervisor(
        spec, backend=backend, limits=tm.Limits.open_loop(), clock=lambda: now, params=found.params,
        tables=known_tables(found, spec)[0],
    )  # fmt: skip
    lines: list[str] = []
    for given in tm.cycles(found):
        now = given.t
        lines += decision_lines(supervisor.step(given))
    return lines


def agree(said: list[str], expected: list[str], rules: list[str]) -> None:
    """Every word the same; the margins of one rule to the last digits."""
    assert len(said) == len(expected)
    for one, other in zip(said, expected):
        if one == other:
            continue
        a, b = one.split(), other.split()
        assert len(a) == len(b), (one, other)
        for place, (x, y) in enumerate(zip(a, b)):
            if x != y:
                rule = a[2] if a[0] == "rule" else rules[place - 2]
                assert (a[0] in ("driving", "emergency", "rule"), rule) == (True, OWN), (one, other)
                assert embedded.double(x) == pytest.approx(embedded.double(y), rel=0.0, abs=1e-15)


def names(spec: Spec) -> list[str]:
    return [rule.name for rule in spec.rules if rule.formula is not None]


@pytest.mark.parametrize("recording", shared_out(SCENARIOS, EVERY), ids=name_of)
def test_it_decides_as_python_on_the_shipped_scenarios(recording: Path, folder: Path, spec: Spec) -> None:
    said = embedded.run(folder / "example", folder / f"{name_of(recording)}.cycles")
    assert sum(line.startswith("decision drive ") for line in said.lines) > 60
    agree(list(said.lines), python_says(recording, spec, "numpy"), names(spec))


def test_it_reads_standard_input_as_well(folder: Path) -> None:
    cycles = folder / f"{name_of(SCENARIOS[0])}.cycles"
    with cycles.open("rb") as given:
        done = subprocess.run([folder / "example"], stdin=given, capture_output=True, text=True, check=True)
    assert tuple(done.stdout.splitlines()) == embedded.run(folder / "example", cycles).lines


def a_run(path: Path, spec: Spec, count: int) -> tuple[list[str], set[str]]:
    """A run with all sorts of broken cycles: its record goes to `path`. What Python decided, and the faults that it named."""
    now, rng, lines, faults = 0.0, random.Random(5), list[str](), set[str]()
    supervisor = tm.supervisor(
        spec, backend="numpy", limits=tm.Limits(budget=1e9), clock=lambda: now, record=path
    )
    for number in range(count):
        given: Cycle | None = cycle(number, 1 + number % 4, 1 + number % 3)
        if number % 3 == 2 and given is not None:
            given = mutate(rng, given)[0]
        if number % 50 == 20:
            given = None
        now = math.nan if number % 50 == 30 else number * PERIOD
        decision = supervisor.step(given)
        lines += decision_lines(decision)
        faults |= {line.split()[1] for line in decision_lines(decision) if line.startswith("fault ")}
    supervisor.close()
    assert supervisor.record_error == ""
    return lines, faults


@pytest.mark.acceptance  # what is compiled for it takes seconds
def test_it_decides_as_python_on_broken_cycles(tmp_path: Path, plain: Path) -> None:
    """A run's record, with the times that the clock showed."""
    spec = tm.load([SUPERVISOR], [], REPOSITORY)
    expected, faults = a_run(tmp_path / "run.arrows", spec, 400)
    assert {
        "missing_cycle",
        "bad_clock",
        "not_finite",
        "out_of_range",
        "repeated",
        "missing",
        "wrong_type",
    } <= faults
    assert len(faults) > 12
    agree(said_of(tmp_path / "run.arrows", plain, tmp_path / "out"), expected, names(spec))


def refused(folder: Path, text: str, tmp_path: Path) -> str:
    path = tmp_path / "given.cycles"
    path.write_text(text, encoding="utf-8")
    done = subprocess.run([folder / "example", path], capture_output=True, text=True, check=False)
    assert done.returncode == 2, done
    return done.stderr


def test_what_is_no_such_file_is_refused_with_its_line(folder: Path, tmp_path: Path) -> None:
    lines = (folder / "debris.cycles").read_text(encoding="utf-8").splitlines()[:400]
    first = next(number for number, line in enumerate(lines) if line.startswith("cycle "))

    def changed(number: int, line: str) -> str:
        return "\n".join([*lines[:number], line, *lines[number + 1 :], ""])

    assert "the file ends without `end`" in refused(folder, "\n".join(lines[:first]) + "\n", tmp_path)
    assert "line 1: `trackmarshal-cycle` stands where `trackmarshal-cycles`" in refused(
        folder, changed(0, "trackmarshal-cycle 1"), tmp_path
    )
    assert "line 1, at `2`: another version" in refused(folder, changed(0, "trackmarshal-cycles 2"), tmp_path)
    assert "line 2, at `abc`: these cycles are for another spec" in refused(
        folder, changed(1, "program abc"), tmp_path
    )
    assert "line 3: `longest_gap` stands where `shortest_gap` belongs" in refused(
        folder, changed(2, lines[3]), tmp_path
    )
    assert "at `0x1`: no number" in refused(folder, changed(2, "shortest_gap 0x1"), tmp_path)
    assert "at `11111111111111111`: no number" in refused(
        folder, changed(2, f"shortest_gap {'1' * 17}"), tmp_path
    )
    assert "a word is too long" in refused(folder, changed(2, "x" * 100), tmp_path)
    assert "nothing may follow" in refused(folder, "\n".join([*lines[:first], "end", "end", ""]), tmp_path)


def test_whatever_stands_in_a_file_the_example_keeps_to_its_memory(folder: Path, tmp_path: Path) -> None:
    """Words exchanged, lost, doubled or made up: it decides or refuses. Of what the sanitizers end, the status is that of a configuration that cannot
    stand: they say what they found."""
    rng = random.Random(3)
    lines = (folder / "wrong_way.cycles").read_text(encoding="utf-8").splitlines()
    starts = [number for number, line in enumerate(lines) if line.startswith("cycle ")]
    short = [*lines[: starts[2]], "end"]
    path = tmp_path / "spoilt.cycles"
    statuses = []
    for _ in range(150):
        words = [line.split(" ") for line in short]
        for _ in range(rng.randint(1, 3)):
            row = (
                words[rng.randrange(len(words))]
                if rng.random() < 0.3
                else rng.choice([w for w in words if len(w) < 12])
            )
            place = rng.randrange(len(row))
            made = rng.choice(
                ["-", "=", ":", "0", "ffffffffffffffff", "7ff0000000000000", "ffffff", "x" * 63, "end"]
            )
            row[place : place + rng.randint(0, 1)] = rng.choice([[], [made], [row[place]] * 2])
        path.write_text("\n".join([*map(" ".join, words), ""]), encoding="utf-8")
        done = subprocess.run([folder / "example", path], capture_output=True, text=True, check=False)
        statuses.append(done.returncode)
        assert done.returncode in (0, 1, 2), done.stderr
        assert "runtime error" not in done.stderr
        assert "Sanitizer" not in done.stderr
    assert {0, 2} <= set(statuses)


def test_a_configuration_that_cannot_stand_is_refused(folder: Path, tmp_path: Path) -> None:
    lines = (folder / "debris.cycles").read_text(encoding="utf-8").splitlines()
    place = next(number for number, line in enumerate(lines) if line.startswith("vehicles.devbot.mass "))
    (heavy,) = struct.unpack("<Q", struct.pack("<d", 1e9))
    lines[place] = f"vehicles.devbot.mass {heavy:x}"
    path = tmp_path / "heavy.cycles"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    done = subprocess.run([folder / "example", path], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "`vehicles.devbot.mass` cannot be so" in done.stderr


def test_more_than_there_is_room_for_is_a_fault(folder: Path, tmp_path: Path) -> None:
    """The example keeps to its memory, and the door says what was given."""
    lines = (folder / "debris.cycles").read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("driving "))
    count = int(lines[start].split()[1], 16)
    longer = [f"driving {5 * count:x}"]
    for line in lines[start + 1 : start + 10]:
        name, *values = line.split()
        longer.append(" ".join([f" {name}", *values * 5]))
    text = "\n".join([*lines[:start], *longer, *lines[start + 10 :], ""])
    path = tmp_path / "long.cycles"
    path.write_text(text, encoding="utf-8")
    said = embedded.run(folder / "example", path).lines
    assert "fault over_capacity driving - 80" in said
    assert sum(line.startswith("decision drive safe") for line in said) > 60


@pytest.mark.acceptance
def test_more_faults_than_a_decision_has_room_for(tmp_path: Path, plain: Path) -> None:
    spec = tm.load([SUPERVISOR], [], REPOSITORY)
    supervisor = tm.supervisor(
        spec, backend="numpy", limits=tm.Limits(budget=1e9), clock=lambda: 0.0, record=tmp_path / "run.arrows"
    )
    given = cycle(0)
    given.driving.update({f"made_up_{number}": [0.0] for number in range(90)})
    expected = list(decision_lines(supervisor.step(given)))
    supervisor.close()
    assert expected[-1] == "more"
    assert said_of(tmp_path / "run.arrows", plain, tmp_path / "out") == expected
