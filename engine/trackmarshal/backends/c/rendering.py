"""Whole files from templates: those of a program, of the example that comes with it, and of the Supervisor as a process."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.c.names import comment

if TYPE_CHECKING:
    from jinja2 import Environment

_FOLDER = Path(__file__).parent / "templates"


def render(template: str, context: Mapping[str, Any], folder: Path = _FOLDER) -> str:
    """The text of a template of a folder; every name in it has to be in the context."""
    return _environment(folder).get_template(template).render(context)


@cache
def _environment(folder: Path) -> Environment:
    from jinja2 import (
        Environment,
        FileSystemLoader,
        StrictUndefined,
    )  # takes longer to load than all that is here

    made = Environment(
        loader=FileSystemLoader(folder), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
        autoescape=False,
    )  # fmt: skip
    made.filters["as_comment"] = comment
    return made
