"""A language of the document, read from a file of words: whole, with the same places to fill in, and without a number."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from string import Formatter
from typing import NoReturn

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace import tree, verdict
from trackmarshal.trace.findings import Finding, did_you_mean
from trackmarshal.trace.graph.kinds import NODES
from trackmarshal.trace.render.words import LIKE, MEANINGS

FORMAT, VERSION = "trackmarshal-case-words", "1"
_HERE = Path(__file__).parent
#: Languages that come with the program.
SHIPPED = tuple(sorted(path.stem for path in _HERE.glob("*.yaml")))
#: More names than these of one fault are not told one by one.
_TOLD = 12
_LANGUAGE = re.compile(r"[a-z]{2,3}(-[A-Z]{2})?")
_NUMBER = re.compile(r"[0-9]")


@cache
def english() -> Mapping[str, str]:
    """English, which says what names there are. What verdicts, statuses and kinds mean, and what they are called, is said where every page takes it from."""
    found = _words(_HERE / "en.yaml", "en.yaml")
    return {
        **{name: text for name, (text, _) in found.items()},
        **{f"status.{word}": word for word in LIKE},
        **{f"meaning.{word}": said for word, said in {**verdict.MEANINGS, **MEANINGS}.items()},
        **{f"thing.{kind}": kind for kind in NODES},
        **{f"what.{kind}": said for kind, said in NODES.items()},
    }


def words(named: str, folder: Path) -> Mapping[str, str]:
    """The words of a language that comes with the program, by its code, or of a file, by its path from a folder.

    Raises TrackmarshalError T434 for what is no such file, T435 where it lacks words, T436 for words that do not fit.
    """
    if named == "en":
        return english()
    if named in SHIPPED:
        return _checked(_HERE / f"{named}.yaml", f"{named}.yaml")
    if not Path(named).suffix:
        raise TrackmarshalError(
            "T434", f"there is no language `{named}`", help=f"known are {', '.join(SHIPPED)}; or name a file of words, such as `words.fr.yaml`"
        )  # fmt: skip
    return _checked(folder / named, named)


def _checked(path: Path, shown: str) -> Mapping[str, str]:
    found, wanted = _words(path, shown), english()
    missing = [name for name in wanted if name not in found]
    if missing:
        raise TrackmarshalError(
            "T435", f"words are missing: {_listed(missing)}", file=shown, line=1, help="add them; en.yaml of the program has them in English"
        )  # fmt: skip
    for name, (text, line) in found.items():
        if name not in wanted:
            _misfit(shown, line, f"there is no word `{name}`", did_you_mean(name, wanted) or "strike it")
        places, here = _places(wanted[name]), _places(text)
        if here is None:
            _misfit(shown, line, f"the braces of `{name}` do not pair", "write `{{` for a brace of its own")
        if here != places:
            said = ", ".join(f"`{{{place}}}`" for place in sorted(places or ())) or "nothing"
            _misfit(
                shown,
                line,
                f"`{name}` has other places to fill in than in English",
                f"to be filled in are {said}, each once",
            )
        if _NUMBER.search(text):
            _misfit(shown, line, f"`{name}` has a number in it", "numbers come from the link graph alone")
    return {name: text for name, (text, _) in found.items()}


def _words(path: Path, shown: str) -> Mapping[str, tuple[str, int]]:
    """By name, text and line."""
    problems: list[Finding] = []
    data = tree.read(path, shown, problems)
    root = None if data is None else tree.parse(data, shown, problems)
    for problem in problems:
        place = problem.place
        raise TrackmarshalError(
            "T434", f"a file of words that cannot be read: {problem.message}", file=shown, line=place.line or None if place else None, help=problem.help or None
        )  # fmt: skip
    help_ = f"begin with `format: {FORMAT}`, `version: {VERSION}` and `words:`"
    if not isinstance(root, tree.Mapping) or set(root.entries) != {"format", "version", "words"}:
        raise TrackmarshalError("T434", "this is no file of words", file=shown, line=1, help=help_)
    for name, wanted in (("format", FORMAT), ("version", VERSION)):
        entry = root.entries[name]
        if not isinstance(entry, tree.Scalar) or entry.text != wanted:
            raise TrackmarshalError(
                "T434", f"`{name}` is to be `{wanted}`", file=shown, line=entry.line, help=help_
            )
    table = root.entries["words"]
    if not isinstance(table, tree.Mapping):
        raise TrackmarshalError("T434", "`words` is to be a mapping", file=shown, line=table.line, help=help_)
    found: dict[str, tuple[str, int]] = {}
    for name, node in table.entries.items():
        if not isinstance(node, tree.Scalar):
            _misfit(shown, node.line, f"`{name}` is to be a text", "write it in quotes")
        found[name] = (node.text, node.line)
    said, line = found.get("language", ("en", 1))
    if not _LANGUAGE.fullmatch(said):
        _misfit(shown, line, f"`{said}` is no language", "a code of two letters, such as `de`")
    return found


def _places(text: str) -> list[str] | None:
    """The places of a text that are filled in, in order of their names; None where braces do not pair."""
    try:
        return sorted(place for _, place, _, _ in Formatter().parse(text) if place is not None)
    except ValueError:
        return None


def _listed(names: list[str]) -> str:
    said = ", ".join(f"`{name}`" for name in names[:_TOLD])
    return f"{said} and {len(names) - _TOLD} more" if len(names) > _TOLD else said


def _misfit(shown: str, line: int, message: str, help_: str) -> NoReturn:
    raise TrackmarshalError("T436", message, file=shown, line=line, help=help_)


__all__ = ["SHIPPED", "english", "words"]
