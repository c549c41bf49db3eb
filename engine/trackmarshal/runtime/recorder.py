"""What keeps the cycles of a run with their decisions, as a Supervisor sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Frame


class Recorder(Protocol):
    """Keeps every cycle with its decision; where it fails, the decision stands."""

    def append(
        self, cycle: object, frame: Frame | None, decision: Decision, readings: tuple[float, float]
    ) -> None: ...

    def stopped(self) -> None:
        """A cycle that was read, and of which nothing was decided: its step was stopped."""

    def restored(self, lines: Sequence[str]) -> None:
        """The next cycles are decided from where another run was when these lines of a snapshot were saved."""

    def close(self) -> None: ...


def gone(recorder: Recorder) -> str:
    """Tell a recorder of a step that was stopped; why it could not be told, which stops nobody else, empty where it could."""
    try:
        recorder.stopped()
    except Exception as error:  # one that knows of no such steps, as well
        return f"{type(error).__name__}: {error}"
    return ""


def went_on(recorder: Recorder, lines: Sequence[str]) -> str:
    """Tell a recorder from where the run goes on; why it could not be told, empty where it could."""
    try:
        recorder.restored(lines)
    except Exception as error:  # one that knows of no snapshots, as well
        return f"{type(error).__name__}: {error}"
    return ""
