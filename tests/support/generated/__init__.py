"""Specs with inputs, made up: typed spec text, cases as plain data. Knows the language, not the engine.

`subject(choices, ...)` makes one; `RandomChoices(seed)` makes it fast and repeatable, a hypothesis strategy
(`property/strategies/specs.py`) makes it shrink.
"""

from support.generated.choices import Choices, RandomChoices
from support.generated.formulas import FormulaWriter, Scope
from support.generated.inputs import Inputs
from support.generated.laws import Laws, laws
from support.generated.modules import ModuleWriter
from support.generated.subject import Subject, subject
from support.generated.vocabulary import SETS, World

__all__ = [
    "SETS", "Choices", "FormulaWriter", "Inputs", "Laws", "ModuleWriter", "RandomChoices", "Scope", "Subject", "World",
    "laws", "subject",
]  # fmt: skip
