"""Specs with inputs, made up: typed spec text, cases as plain data. Knows the language, not the engine.

`subject(choices, ...)` makes one; `RandomChoices(seed)` makes it fast and repeatable, a hypothesis strategy
(`property/strategies/specs.py`) makes it shrink.
"""

from support.generated.choices import Choices, RandomChoices
from support.generated.inputs import Inputs
from support.generated.modules import ModuleWriter
from support.generated.subject import Subject, subject
from support.generated.vocabulary import World

__all__ = ["Choices", "Inputs", "ModuleWriter", "RandomChoices", "Subject", "World", "subject"]
