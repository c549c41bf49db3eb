"""The emitted Supervisor built and run, here and on an emulated Cortex-M7, and what both say held against each other."""

from __future__ import annotations

import shutil
import statistics
import struct
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from support.shared import REPOSITORY
from trackmarshal.backends.c.build import EXACT, FAST
from trackmarshal.backends.c.report import deepest
from trackmarshal.backends.c.source import Source

#: Start-up, linker script and probe of the board.
TARGET = REPOSITORY / "tests" / "embedded"
STRICT = ("-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror")
CORTEX_M7 = ("arm-none-eabi-gcc", "-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16")
EMULATOR = (
    "qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none", "-icount", "shift=6",
)  # fmt: skip
#: One instruction takes 2^6 ns of the emulated time, one tick of the board's clock of 25 MHz takes 40 ns.
NS_AN_INSTRUCTION, NS_A_TICK = 64, 40
TOOLS = ("arm-none-eabi-gcc", "arm-none-eabi-size", "arm-none-eabi-nm", "qemu-system-arm")


@dataclass(frozen=True)
class Ran:
    """What the example printed, and for each step the instructions and bytes of stack that it took (none here)."""

    lines: tuple[str, ...]
    instructions: tuple[int, ...] = ()
    stack: tuple[int, ...] = ()


@dataclass(frozen=True)
class Difference:
    """A line that is not the same; `rule` is empty where more than a margin differs."""

    line: int
    rule: str
    here: str
    there: str
    #: Whether it is a margin among the reasons, which stands with all margins too.
    of_reason: bool = False

    @property
    def size(self) -> float:
        """How far a margin is from the other."""
        return abs(double(self.here) - double(self.there))


def missing_tools() -> list[str]:
    return [name for name in TOOLS if shutil.which(name) is None]


def build(folder: Path, name: str = "supervisor", more: Sequence[str] = ()) -> Path:
    """The example for this machine."""
    sources = [f"{name}.c", "main.c", "cycles.c"]
    _call(["gcc", *EXACT, *FAST, *STRICT, *more, *sources, "-o", "example", "-lm"], folder)
    return folder / "example"


def cross_build(
    folder: Path, name: str = "supervisor", more: Sequence[str] = (), out: str = "target"
) -> Path:
    """The example for the board. What is generated has to pass strictly; start-up code speaks to the hardware."""
    flags = [*EXACT, *FAST, *more]
    mine = [f"{out}-{source}.o" for source in (name, "main", "cycles")]
    for source, made in zip((name, "main", "cycles"), mine):
        _call(
            [
                *CORTEX_M7,
                *flags,
                *STRICT,
                "-DTM_PROBE",
                f"-I{TARGET}",
                "-fstack-usage",
                "-c",
                f"{source}.c",
                "-o",
                made,
            ],
            folder,
        )
    board = [str(TARGET / source) for source in ("startup.c", "probe.c")]
    link = ["--specs=rdimon.specs", "-nostartfiles", "-T", str(TARGET / "an500.ld")]
    _call([*CORTEX_M7, *flags, *STRICT, *link, *mine, *board, "-o", f"{out}.elf", "-lm"], folder)
    return folder / f"{out}.elf"


def run(program: Path, cycles: Path) -> Ran:
    """The example here."""
    return Ran(tuple(_call([str(program), str(cycles)], cycles.parent).splitlines()))


def emulate(image: Path, cycles: Path) -> Ran:
    """The example on the board. Semihosting hands over the name of the file, which is read from the host."""
    arguments = f"enable=on,target=native,arg=supervisor,arg={cycles.name}"
    command = [*EMULATOR, "-semihosting-config", arguments, "-kernel", str(image)]
    said = _call(command, cycles.parent).splitlines()
    probes = [[int(word, 16) for word in line.split()[1:]] for line in said if line.startswith("probe ")]
    ticks = [(high << 32) + low for high, low, _ in probes]
    return Ran(
        tuple(line for line in said if not line.startswith("probe ")),
        tuple(round(n * NS_A_TICK / NS_AN_INSTRUCTION) for n in ticks),
        tuple(stack for _, _, stack in probes),
    )


def differences(here: Ran, there: Ran, rules: Sequence[str]) -> Iterator[Difference]:
    """Every line that is not the same. Of lines with margins, one difference a margin."""
    if len(here.lines) != len(there.lines):
        yield Difference(-1, "", f"{len(here.lines)} lines", f"{len(there.lines)} lines")
        return
    for number, (one, other) in enumerate(zip(here.lines, there.lines)):
        if one == other:
            continue
        a, b = one.split(), other.split()
        if (
            a[:1] == b[:1]
            and a[0] in ("driving", "emergency")
            and a[1] == b[1]
            and len(a) == len(b) == 2 + len(rules)
        ):
            for rule, x, y in zip(rules, a[2:], b[2:]):
                if x != y:
                    yield Difference(number, rule, x, y)
        elif a[:1] == ["rule"] and a[:-1] == b[:-1]:
            yield Difference(number, a[2], a[-1], b[-1], True)
        else:
            yield Difference(number, "", one, other)


def double(bits: str) -> float:
    """The number that the example printed."""
    (value,) = struct.unpack("<d", int(bits, 16).to_bytes(8, "little"))
    assert isinstance(value, float)
    return value


def instructions(runs: Sequence[Ran]) -> dict[str, int]:
    """What steps cost on the board: how many there were, and the instructions of the median one and of the longest."""
    found = [n for one in runs for n in one.instructions]
    return {"steps": len(found), "median": round(statistics.median(found)), "most": max(found)}


def sizes(folder: Path, image: Path, source: Source) -> dict[str, int]:
    """Bytes on the board. generated: code and constants of what was generated; context, decision: what a caller provides for it;
    image_flash, image_ram: with the example's own memory, the C library and start-up. stack_bound: the most that the generated
    functions can take together, from the compiler's figures of each, without those of libm."""
    name = source.name
    lines = _call(["arm-none-eabi-size", f"{image.stem}-{name}.o", image.name], folder).splitlines()
    own, whole = ([int(word) for word in line.split()[:3]] for line in lines[1:3])
    assert own[1:] == [0, 0], "generated code has no memory of its own"
    symbols = {
        words[3]: int(words[1], 16)
        for line in _call(["arm-none-eabi-nm", "-S", image.name], folder).splitlines()
        if len(words := line.split()) == 4
    }
    rows = [line.split("\t") for line in (folder / f"{image.stem}-{name}.su").read_text("utf-8").splitlines()]
    usage = {row[0].rpartition(":")[2].partition(".")[0]: int(row[1]) for row in rows}
    return {
        "generated": own[0], "context": symbols["context"], "decision": symbols["decision"],
        "image_flash": whole[0] + whole[1], "image_ram": whole[1] + whole[2], "stack_bound": deepest(source, usage)[0],
    }  # fmt: skip


def _call(command: Sequence[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=600)
    assert (done.returncode, done.stderr) == (0, ""), (
        f"{' '.join(command)}: {done.returncode}\n{done.stderr[:3000]}"
    )
    return done.stdout
