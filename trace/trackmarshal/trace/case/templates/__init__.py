"""The templates of the document, and a project's in their place: `document`, `blocks` and `section`, or one that has the name of a section."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.trace import look
from trackmarshal.trace.case.model import Section

if TYPE_CHECKING:
    from jinja2 import BaseLoader, Environment, Template

_OURS = Path(__file__).parent


def loader(folder: Path | None) -> BaseLoader:
    """A project's templates first; ours by their names, and as `ours/NAME` where a project's one builds on them."""
    from jinja2 import ChoiceLoader, FileSystemLoader, PrefixLoader

    ours = FileSystemLoader([_OURS, look.FOLDER])
    always = PrefixLoader({"ours": ours})
    return ChoiceLoader([*([FileSystemLoader(folder)] if folder is not None else []), ours, always])


def section_template(environment: Environment, section: Section, format_: str) -> Template:
    """The template of a section: the project's one of its name, or else the common one."""
    return environment.select_template([f"{section.id}.{format_}.j2", f"section.{format_}.j2"])


__all__ = ["loader", "section_template"]
