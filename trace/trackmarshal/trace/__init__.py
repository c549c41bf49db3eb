"""From requirement to evidence: the traceability matrix, its reports, and the gate.

`build` makes the matrix of a project from its requirements folder and the engine's records; `render` prints it; `gate`
says what fails it. Nothing here evaluates a rule: what the engine found comes in as `trackmarshal.records`.

Importing this costs nothing: each name is imported when it is first used.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackmarshal.trace.baseline import Tell
    from trackmarshal.trace.codes import CODES
    from trackmarshal.trace.faults import rows as fault_rows
    from trackmarshal.trace.findings import Finding, Place
    from trackmarshal.trace.matrix import Matrix
    from trackmarshal.trace.model import Project
    from trackmarshal.trace.render import FORMATS, render
    from trackmarshal.trace.whole import accept_baseline, build, gate, load, requirement_ids

#: Where each name is, and what it is called there, if not the same.
_PLACES = {
    "CODES": ("codes", "CODES"),
    "FORMATS": ("render", "FORMATS"),
    "Finding": ("findings", "Finding"),
    "Matrix": ("matrix", "Matrix"),
    "Place": ("findings", "Place"),
    "Project": ("model", "Project"),
    "Tell": ("baseline", "Tell"),
    "accept_baseline": ("whole", "accept_baseline"),
    "build": ("whole", "build"),
    "fault_rows": ("faults", "rows"),
    "gate": ("whole", "gate"),
    "load": ("whole", "load"),
    "render": ("render", "render"),
    "requirement_ids": ("whole", "requirement_ids"),
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, there = _PLACES[name]
    found = globals()[name] = getattr(import_module(f"{__name__}.{module}"), there)
    return found


class _Room(ModuleType):
    """`render` is what prints the matrix, also once the folder of that name is imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(
            name, value.render if name == "render" and isinstance(value, ModuleType) else value
        )


sys.modules[__name__].__class__ = _Room

__all__ = [
    "CODES",
    "FORMATS",
    "Finding",
    "Matrix",
    "Place",
    "Project",
    "Tell",
    "accept_baseline",
    "build",
    "fault_rows",
    "gate",
    "load",
    "render",
    "requirement_ids",
]
