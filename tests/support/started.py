"""Programs that are started, and end with the test at the latest."""

from __future__ import annotations

import contextlib
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any


@contextlib.contextmanager
def started(*arguments: str | Path, **streams: Any) -> Iterator[subprocess.Popen[bytes]]:
    """A program whose output is piped, and that Ctrl-C reaches; `streams` is what else Popen takes."""
    # Who was started in the background of a script ignores Ctrl-C, and so do those it starts: not here.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen([str(a) for a in arguments], stdout=subprocess.PIPE, **streams)
    finally:
        signal.signal(signal.SIGINT, before)
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()
