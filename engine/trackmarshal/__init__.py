"""trackmarshal: requirements that run.

    import trackmarshal as tm

    spec = tm.load(["specs/supervisor"])
    evaluator = tm.Evaluator(spec)
    result = evaluator.case({"signals": {...}})  # one case
    batch = evaluator.batch({"plan": {"t": t, "v": v}})  # arrays of many

    recording = tm.load_recording("specs/scenarios/cut_in.tmrec.jsonl")
    run = tm.replay(recording, evaluator)

    supervisor = tm.supervisor(spec, record="run.arrows")
    decision = supervisor.step(tm.Cycle(number, t, driving, emergency, signals))

docs/python.md shows each of them. Importing this costs nothing: each name is imported when it is first used.
"""

from __future__ import annotations

import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackmarshal.batches import Batch
    from trackmarshal.errors import TrackmarshalError
    from trackmarshal.evaluation import Evaluator, load, loads
    from trackmarshal.integration.planner import check_planner
    from trackmarshal.rulebooks.candidates import choose, compare
    from trackmarshal.rulebooks.order import rulebook
    from trackmarshal.runtime.cycle import Cycle, Limits
    from trackmarshal.runtime.decision import Decision
    from trackmarshal.runtime.door.lines import line
    from trackmarshal.scenarios import load as load_recording
    from trackmarshal.scenarios.replay import replay
    from trackmarshal.scenarios.supervised import cycles
    from trackmarshal.supervision import supervisor
    from trackmarshal.trajectories.public import (
        acceleration_along,
        arc_length,
        complete,
        curvature_along,
        cut_at_rest,
        direction_along,
        heading_from,
        resample,
        time_along,
    )

__path__ = pkgutil.extend_path(__path__, __name__)
__version__ = "0.3.0.dev0"
__all__ = [
    "Batch", "Cycle", "Decision", "Evaluator", "Limits", "TrackmarshalError", "acceleration_along", "arc_length", "check_planner", "choose",
    "compare", "complete", "curvature_along", "cut_at_rest", "cycles", "direction_along", "heading_from", "line", "load", "load_recording", "loads", "replay", "resample",
    "rulebook", "supervisor", "time_along",
]  # fmt: skip

_OF_TRAJECTORIES = (
    "acceleration_along", "arc_length", "complete", "curvature_along", "cut_at_rest", "direction_along", "heading_from", "resample", "time_along",
)  # fmt: skip
_HOMES = {
    "Batch": ("batches", "Batch"),
    "Cycle": ("runtime.cycle", "Cycle"),
    "Decision": ("runtime.decision", "Decision"),
    "Evaluator": ("evaluation", "Evaluator"),
    "Limits": ("runtime.cycle", "Limits"),
    "TrackmarshalError": ("errors", "TrackmarshalError"),
    "check_planner": ("integration.planner", "check_planner"),
    "choose": ("rulebooks.candidates", "choose"),
    "compare": ("rulebooks.candidates", "compare"),
    "cycles": ("scenarios.supervised", "cycles"),
    "line": ("runtime.door.lines", "line"),
    "load": ("evaluation", "load"),
    "load_recording": ("scenarios", "load"),
    "loads": ("evaluation", "loads"),
    "replay": ("scenarios.replay", "replay"),
    "rulebook": ("rulebooks.order", "rulebook"),
    "supervisor": ("supervision", "supervisor"),
    **{name: ("trajectories.public", name) for name in _OF_TRAJECTORIES},
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(import_module(f"{__name__}.{module}"), attribute)


def __dir__() -> list[str]:
    """The public names, whether they were used before or not."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
