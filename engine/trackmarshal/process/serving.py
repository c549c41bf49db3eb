"""Building and starting a Supervisor as a process of its own."""

# implements S-1-B-3: a process of its own, which shares messages with the planner and nothing else

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from trackmarshal.backends.c.build import program
from trackmarshal.backends.c.process.emit import UNITS, Emitted
from trackmarshal.backends.c.source import Source, generated
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.process.messages import Layout
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.frame import NO_SETTINGS, Settings
from trackmarshal.supervision import limits_with, with_limits

#: Where POSIX shared memory is a folder of files; a name without a slash stands for a file there.
_SHARED = Path("/dev/shm")


@dataclass(frozen=True)
class Built:
    """A program, and the description of its messages."""

    path: Path
    layout: Layout

    def command(self, *, shm: str | None = None, udp: int | None = None, to: Sequence[int] = (), wait: str = "sleep",
                simulated: bool = False) -> list[str]:  # fmt: skip
        """Its command line: over shared memory of a name, or datagrams to a port; decisions also go to the ports `to`."""
        words = [str(self.path), "--wait", wait]
        words += ["--shm", shared_path(shm)] if shm is not None else ["--udp", str(udp)]
        for port in to:
            words += ["--to", str(port)]
        return [*words, "--simulated"] if simulated else words


def build(
    spec: Spec, rules: list[RuleInfo], limits: Limits | None = None, settings: Settings = NO_SETTINGS
) -> Built:
    """The process for a spec, compiled once for its content and kept in the user's cache, as `backends.c.build` does.

    Raises TrackmarshalError E470 to E472 for what generated C cannot do, E476 for what its messages cannot, E482 for a spec that cannot be
    supervised with, E404 where there is no rule, E473 for places in settings, E403 where limits break a constraint of the spec.
    """
    if settings.places:
        raise TrackmarshalError(
            "E473", "a generated Supervisor has the places of its spec", help="put them into the spec"
        )
    source = generated(spec, rules, doored=True)
    made = emitted(source, limits or limits_with(spec, {}, settings), settings)
    path = program(source, made.files, UNITS, made.sizes)
    return Built(path, Layout(made.description))


def emitted(source: Source, limits: Limits, settings: Settings) -> Emitted:
    """What is compiled, and the description of its messages; raises TrackmarshalError E403 where limits break a constraint of the spec."""
    held = {name: float(value) for name, value in asdict(limits).items()}
    return Emitted(source, held, with_limits(source.plan.spec, limits, settings))


def shared_path(name: str) -> str:
    """The beginning of the names of the files that shared memory of a name has; raises TrackmarshalError E477 where there can be none."""
    if "/" in name:
        return name
    if not _SHARED.is_dir():
        raise TrackmarshalError(
            "E477", f"this system has no {_SHARED}", help="name a path, such as /tmp/supervisor"
        )
    if not name or name.startswith("."):
        raise TrackmarshalError("E477", f"`{name}` is no name for shared memory", help="letters and digits")
    return str(_SHARED / name)


def start(built: Built, *, shm: str | None = None, udp: int | None = None, to: Sequence[int] = (), wait: str = "sleep",
          simulated: bool = False) -> subprocess.Popen[str]:  # fmt: skip
    """Start the process, and wait until it serves; raises TrackmarshalError E477 where it does not."""
    command = built.command(shm=shm, udp=udp, to=to, wait=wait, simulated=simulated)
    started = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert started.stdout is not None
    assert started.stderr is not None
    said = started.stdout.readline()
    if not said.startswith("serves "):
        started.kill()
        error = started.communicate()[1].strip()
        raise TrackmarshalError("E477", f"the Supervisor does not start: {error}", help="see docs/process.md")
    return started


def remove(name: str) -> None:
    """The files of shared memory, once nobody uses them."""
    for ending in ("cycles", "decisions", "lock"):
        path = Path(f"{shared_path(name)}.{ending}")
        if path.exists():
            os.unlink(path)
