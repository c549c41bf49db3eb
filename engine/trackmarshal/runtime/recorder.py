"""What keeps the cycles of a run with their decisions, as a Supervisor sees it."""

from __future__ import annotations

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

    def close(self) -> None: ...


def gone(recorder: Recorder) -> str:
    """Tell a recorder of a step that was stopped; why it could not be told, which stops nobody else, empty where it could."""
    try:
        recorder.stopped()
    except Exception as error:  # one that knows of no such steps, as well
        return f"{type(error).__name__}: {error}"
    return ""
