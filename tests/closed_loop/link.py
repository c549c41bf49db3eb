"""The planner's process, seen from the loop: requests and answers as JSON lines over pipes."""

from __future__ import annotations

import json
import os
import subprocess
from types import TracebackType
from typing import Any

from closed_loop import places


class PlannerFailed(Exception):
    """The planner raised, its process ended, or it has no environment."""


class PlannerProcess:
    """A planner for one track, in its own environment. Starting it takes seconds, the first time minutes: it lays out its lattice."""

    def __init__(self, track: str) -> None:
        script = places.HERE / "planner" / "process.py"
        places.BUILD.mkdir(parents=True, exist_ok=True)
        if not places.PLANNER_PYTHON.exists():
            raise PlannerFailed(
                "the planner has no environment yet: `make closed-loop` and `make acceptance` make it"
            )
        command = [places.PLANNER_PYTHON, script, places.race_line(track), places.PARAMS, places.graph(track)]
        self._process = subprocess.Popen(
            list(map(str, command)),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONHASHSEED": "0"},
        )
        self._read()

    def ask(self, what: str, **content: Any) -> dict[str, Any]:
        """One request and its answer; raises PlannerFailed."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps({"do": what, **content}).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise PlannerFailed("the planner's process ended") from None
        return self._read()

    def _read(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise PlannerFailed(f"the planner's process ended with status {self._process.wait()}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise PlannerFailed(answer["error"])
        return answer

    def close(self) -> None:
        """Ends the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()

    def __enter__(self) -> PlannerProcess:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
