"""Printing through templates, the same way in each format: whatever is wrong with one of a project's becomes an error that names it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace.case.model import Document
from trackmarshal.trace.case.templates import loader, section_template
from trackmarshal.trace.render.words import LIKE, SIGNS


def printed(
    document: Document, format_: str, folder: Path | None, filters: Mapping[str, Callable[..., Any]], known: Mapping[str, Any] | None = None,
    finalize: Callable[[Any], Any] | None = None,
) -> str:  # fmt: skip
    """The document by the templates of a format (`html`, `typ`), those of a project's folder in place of ours.

    filters, known: what templates of the format know besides what all do. finalize: what becomes of all that they write. Raises T430.
    """
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    with guarded(folder is not None):
        environment = Environment(
            loader=loader(folder), autoescape=True, finalize=finalize, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        )  # fmt: skip
        environment.filters.update(ready=Markup, **filters)
        environment.globals.update(
            words=document.words, signs=SIGNS, like=LIKE, unknown=unknown,
            template_of=lambda section: section_template(environment, section, format_), **(known or {}),
        )  # fmt: skip
        return environment.get_template(f"document.{format_}.j2").render(document=document).rstrip() + "\n"


@contextmanager
def guarded(own: bool) -> Iterator[None]:
    """Errors of templates as T430, where a project has some of its own; in ours they are defects."""
    from jinja2 import TemplateError, TemplateSyntaxError

    try:
        yield
    except (TemplateError, UnicodeDecodeError) as problem:
        if not own:
            raise
        syntax = isinstance(problem, TemplateSyntaxError)
        file = problem.filename or problem.name if isinstance(problem, TemplateSyntaxError) else None
        message = (problem.message or "" if isinstance(problem, TemplateError) else str(problem)) or type(
            problem
        ).__name__
        raise TrackmarshalError(
            "T430", f"a template of the safety case: {message}", file=file, line=problem.lineno if isinstance(problem, TemplateSyntaxError) else None,
            help="correct it" if syntax else "`section` has `id`, `title`, `anchor` and `blocks`; see docs/safety-case.md",
        ) from problem  # fmt: skip


def unknown(kind: object) -> NoReturn:
    """For templates, in place of a block that they do not know."""
    raise TypeError(f"unknown block {kind!r}")


__all__ = ["guarded", "printed", "unknown"]
