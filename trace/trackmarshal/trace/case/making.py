"""Printing through templates: whatever is wrong with one of a project's becomes an error that names it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from trackmarshal.errors import TrackmarshalError


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


__all__ = ["guarded", "unknown"]
