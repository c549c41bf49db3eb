"""One generated subject of a test: a spec's text and a batch of cases for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from support.generated.choices import Choices
from support.generated.inputs import Inputs
from support.generated.modules import ModuleWriter


@dataclass(frozen=True)
class Subject:
    """A module as text, and cases as plain data."""

    text: str
    cases: tuple[dict[str, Any], ...]


def subject(
    choices: Choices,
    rules: int = 3,
    depth: int = 3,
    cases: int = 7,
    inexact: str = "no",
    geometry: bool = False,
) -> Subject:
    """A subject with up to so many rules and cases.

    inexact: which use of functions whose last digit depends on libm: "no", "gentle" (where their error does
    not grow), "any".
    """
    module = ModuleWriter(choices, inexact, geometry)
    module.declarations(depth - 1)
    for index in range(choices.integer(1, rules)):
        module.rule(f"rule{index}", depth)
    inputs = Inputs(choices, module.world)
    dirt = [choices.pick((0, 0, 0, 8, 8, 30)) for _ in range(choices.integer(1, cases))]
    return Subject(module.text, tuple(inputs.case(index, percent) for index, percent in enumerate(dirt)))
