"""The shape of a diagnostic: code, title, message, up to two places, help, and an explanation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

from trackmarshal.errors import TrackmarshalError
from trackmarshal.node import Node
from trackmarshal.source import Span


class Diagnostic(Node):
    """One finding at one place. Subclasses add typed fields; `{field}` in the texts is filled in from them."""

    #: Stable across releases.
    code: ClassVar[str] = ""
    title: ClassVar[str] = ""
    level: ClassVar[str] = "error"
    #: What is said at the top.
    text: ClassVar[str] = ""
    #: What is written under the carets.
    label: ClassVar[str] = ""
    #: What is written at the second place, the field `other`, where there is one. Further places of the same thing, in a field
    #: `others`, need no words of their own.
    other_label: ClassVar[str] = ""
    #: What would mend it; empty for nothing certain.
    remedy: ClassVar[str] = ""
    #: A paragraph for `trackmarshal explain CODE`.
    explanation: ClassVar[str] = ""

    span: Span

    def _filled(self, template: str) -> str:
        return template.format_map(_Fields(self.__dict__)) if "{" in template else template

    @property
    def message(self) -> str:
        return self._filled(self.text)

    @property
    def pointer(self) -> str:
        return self._filled(self.label)

    @property
    def help(self) -> str:
        return self._filled(self.remedy)

    @property
    def related(self) -> tuple[tuple[Span, str], ...]:
        other, others = self.__dict__.get("other"), self.__dict__.get("others", ())
        first = () if other is None else ((other, self._filled(self.other_label)),)
        return (*first, *((span, "here too") for span in others))


class _Fields(dict[str, Any]):
    """Fields for templates: spans print as places."""

    def __missing__(self, key: str) -> str:
        raise KeyError(f"diagnostic template names an unknown field {key!r}")


class Diagnostics(TrackmarshalError):
    """Raised with everything that is wrong with an input, in the order of places."""

    def __init__(self, items: Iterable[Diagnostic]) -> None:
        self.items = tuple(sorted(items, key=lambda d: (d.span.file.path, d.span.start, d.code)))
        first = self.items[0]
        super().__init__(
            first.code,
            first.message,
            file=first.span.file.path,
            line=first.span.line,
            help=first.help or None,
        )


def close_matches(word: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """A "did you mean" sentence, or the empty string."""
    names = list(known)
    found = [name for name in names if name.lower() == word.lower() and name != word]
    if found:
        listed = " or ".join(f"`{name}`" for name in found)
        return f"did you mean {listed}? Capital and small letters differ"
    from difflib import get_close_matches  # which nobody else waits for

    found = get_close_matches(
        word, [name for name in names if _of_like_length(word, name)], n=3, cutoff=cutoff
    )
    if not found:
        return ""
    return "did you mean " + " or ".join(f"`{name}`" for name in found) + "?"


def _of_like_length(word: str, name: str) -> bool:
    """Whether shared letters say anything: with the letters of `red`, more than twice as many are `proceed`, which is its contrary."""
    short, long = sorted((word, name), key=len)
    return len(long) <= 2 * len(short) or long.startswith(short)
