"""What all pages have in common: colours and signs of statuses, in light and dark, and how their templates are read. Every page's own style goes on
from here."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

#: Folder of `shared.css`, for the loaders of templates.
FOLDER = Path(__file__).parent


@cache
def environment(templates: Path) -> Environment:
    """Templates of a page, with `shared.css` beside them, and `marked` as a filter. What they write is escaped; a name that nobody gave raises.

    The same for all pages of a process, so that each template is compiled once: what a page is about is given to `render`, never kept here.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    made = Environment(
        loader=FileSystemLoader([templates, FOLDER]), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True,
    )  # fmt: skip
    made.filters["marked"] = marked
    return made


def marked(text: str) -> Markup:
    """Text, escaped, with what stands between backquotes as code."""
    from markupsafe import Markup, escape

    parts = text.split("`")
    if len(parts) % 2 == 0:  # a backquote without its partner
        return escape(text)
    return Markup("").join(
        Markup("<code>{}</code>").format(part) if number % 2 else escape(part)
        for number, part in enumerate(parts)
    )


__all__ = ["FOLDER", "environment", "marked"]
