"""What a command does not need does not run beside it, and is not imported."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.length import at_length
from support.shared import REPOSITORY

#: How many threads a process has after a command that evaluates with numpy.
COUNTED = """
import os, sys
from trackmarshal.cli.main import main
status = main(sys.argv[1:])
assert status == 0 and "numpy" in sys.modules, (status, "numpy" in sys.modules)
print("threads:", len(os.listdir("/proc/self/task")), os.environ["OPENBLAS_NUM_THREADS"])
"""


@pytest.mark.parametrize("asked", [None, at_length("2")])
def test_a_command_has_no_threads_that_nobody_asked_for(asked: str | None) -> None:
    if not Path("/proc/self/task").is_dir():
        pytest.skip("threads are counted in /proc")
    if len(os.sched_getaffinity(0)) < 2:
        pytest.skip("one core: numpy has no threads there")
    environment = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    if asked is not None:
        environment["OPENBLAS_NUM_THREADS"] = asked
    command = [
        sys.executable,
        "-c",
        COUNTED,
        "test",
        "--exit-zero",
        "--project",
        str(REPOSITORY),
        str(REPOSITORY / "specs" / "interstate"),
    ]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout.splitlines()[-1] == f"threads: {asked or 1} {asked or 1}"


def test_what_looks_at_specs_alone_does_without_numpy() -> None:
    """Tests in specs give parameters, tables and places values of their own, which are read as a caller's are."""
    program = (
        "import sys; from trackmarshal.cli.main import main; status = main(sys.argv[1:]); "
        "print(status, 'numpy' in sys.modules)"
    )
    command = [sys.executable, "-c", program, "check", "--quiet", "--project", str(REPOSITORY)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.stdout.splitlines()[-1:] == ["0 False"], found.stdout + found.stderr
