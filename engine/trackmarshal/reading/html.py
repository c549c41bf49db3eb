"""A rule for readers as a page of its own: no script, nothing from elsewhere, for screens and paper."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.reading import mathml
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.sheet import (
    Sheet,
    about,
    beside,
    bounds,
    equation,
    grid,
    origin,
    placed,
    value,
    way,
)

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATES = Path(__file__).parent / "templates"


def page(sheets: list[Sheet]) -> str:
    """One page of one rule or of several, all in one language."""
    return (
        _environment()
        .get_template("rule.html.j2")
        .render(sheets=sheets, words=sheets[0].words, labels=sheets[0].words.labels)
    )


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    def math(piece: Layout) -> Markup:
        """MathML is markup already: all that an author wrote in it is escaped."""
        return Markup(mathml.formula(piece))

    def inline(piece: Layout) -> Markup:
        return Markup(mathml.formula(piece, display=False))

    made = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters.update(math=math, inline=inline)
    made.globals.update(
        about=about,
        beside=beside,
        bounds=bounds,
        equation=equation,
        grid=grid,
        origin=origin,
        placed=placed,
        value=value,
        way=way,
    )
    return made
