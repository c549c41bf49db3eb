"""trackmarshal: requirements that run.

    import trackmarshal as tm

    spec = tm.load(["specs/supervisor"])
    evaluator = tm.Evaluator(spec)
    recording = tm.load_recording("specs/scenarios/cut_in.tmrec.jsonl")
    run = tm.replay(recording, evaluator)

    supervisor = tm.supervisor(spec, record="run.arrows")
    decision = supervisor.step(tm.Cycle(number, t, driving, emergency, signals))

Importing this costs nothing: each name is imported when it is first used.
"""

from __future__ import annotations

import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackmarshal.errors import TrackmarshalError
    from trackmarshal.evaluation import Evaluator, load
    from trackmarshal.runtime.cycle import Cycle, Limits
    from trackmarshal.scenarios import load as load_recording
    from trackmarshal.scenarios.replay import replay
    from trackmarshal.scenarios.supervised import cycles
    from trackmarshal.supervision import supervisor

__path__ = pkgutil.extend_path(__path__, __name__)
__version__ = "0.1.0"
__all__ = [
    "Cycle", "Evaluator", "Limits", "TrackmarshalError", "cycles", "load", "load_recording", "replay", "supervisor",
]  # fmt: skip

_HOMES = {
    "Cycle": ("runtime.cycle", "Cycle"),
    "Evaluator": ("evaluation", "Evaluator"),
    "Limits": ("runtime.cycle", "Limits"),
    "TrackmarshalError": ("errors", "TrackmarshalError"),
    "cycles": ("scenarios.supervised", "cycles"),
    "load": ("evaluation", "load"),
    "load_recording": ("scenarios", "load"),
    "replay": ("scenarios.replay", "replay"),
    "supervisor": ("supervision", "supervisor"),
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(import_module(f"{__name__}.{module}"), attribute)
