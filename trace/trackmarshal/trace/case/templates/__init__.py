"""The templates of the document, and a project's in their place: `document`, `blocks` and `section`, or one that has the name of a section."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.trace import look
from trackmarshal.trace.case.model import Section
from trackmarshal.trace.findings import did_you_mean

if TYPE_CHECKING:
    from jinja2 import BaseLoader, Environment, Template

_OURS = Path(__file__).parent
#: Templates besides those of sections, and styles.
_FRAME, _STYLES = ("document", "blocks", "section"), ("style.css", "shared.css")


def loader(folder: Path | None) -> BaseLoader:
    """A project's templates first; ours by their names, and as `ours/NAME` where a project's one builds on them."""
    from jinja2 import ChoiceLoader, FileSystemLoader, PrefixLoader

    ours = FileSystemLoader([_OURS, look.FOLDER])
    always = PrefixLoader({"ours": ours})
    return ChoiceLoader([*([FileSystemLoader(folder)] if folder is not None else []), ours, always])


def section_template(environment: Environment, section: Section, format_: str) -> Template:
    """The template of a section: the project's one of its name, or else the common one."""
    return environment.select_template([f"{section.id}.{format_}.j2", f"section.{format_}.j2"])


def unused(folder: Path, sections: Iterable[str]) -> Iterator[tuple[str, str]]:
    """The templates and styles of a project's folder that stand in place of none of ours, and that no other one there names; with the name that may be meant.

    sections: the names of all sections, also of those that a document leaves out.
    """
    names = [f"{name}.{format_}.j2" for name in (*_FRAME, *sections) for format_ in ("html", "typ")]
    ours = {*names, *_STYLES}
    texts = {
        path.relative_to(folder).as_posix(): path.read_text("utf-8", "replace")
        for path in sorted(folder.rglob("*"))
        if path.suffix in (".j2", ".css") and path.is_file()
    }
    for name in texts.keys() - ours:
        if "/" in name and name.endswith(".css"):  # a page's that is no safety case
            continue
        if not any(name in text for other, text in texts.items() if other != name):
            yield name, did_you_mean(name, ours)


__all__ = ["loader", "section_template", "unused"]
