"""Rules for readers as the pages show them: what `show` says of each, and the lines of each test."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal import cache
from trackmarshal.cli.kept import kept

if TYPE_CHECKING:
    from trackmarshal.cli.sources import Sources
    from trackmarshal.ir.spec import Spec
    from trackmarshal.trace import Project


@dataclass(frozen=True)
class Sheets:
    """By rule or assumption what `show RULE --format json` says, without C; by rule and title the lines of a test; the words of kinds of clauses."""

    rules: Mapping[str, Mapping[str, Any]]
    tests: Mapping[tuple[str, str], str]
    clauses: Mapping[str, str]


def sheets(root: Path, project: Project, sources: Sources | None = None, state: str = "", fresh: bool = False) -> Sheets:  # fmt: skip
    """Those of a project: of `sources` where they are compiled already; else those that are kept, or made now.

    state: one hash of all that the project's facts were made from, the specs among them; empty where it is not known. fresh: they were made
    from these `sources`, so that the sheets of these are of that state, too.
    """
    from trackmarshal.trace import reading

    path = cache.of_project("sheets", root) if state else None
    if sources is not None:
        made = _of(sources)
        if path is not None and fresh:
            cache.keep(path, {"of": state, **_said(made)})
        return made
    if path is not None:
        said = cache.kept(path)
        try:
            if said["of"] == state:
                return _read(said)
        except (KeyError, TypeError, ValueError):
            pass  # kept by itself, or nothing is

    def make() -> Sheets:
        from trackmarshal.cli.sources import Sources

        return _of(Sources(root, project))

    folders = [*map(str, project.specs or ["specs"]), reading.FOLDER]
    return kept("sheets", root, folders, (), make, _said, _read)[0]


def rule_sheets(spec: Spec, names: Iterable[str]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Of each of these rules that the spec has, its name and what `show` says of it."""
    from trackmarshal.reading.data import data
    from trackmarshal.reading.rule import read
    from trackmarshal.reading.sheet import Sheet, spec_text
    from trackmarshal.reading.telling import tell
    from trackmarshal.reading.words.english import ENGLISH

    rules = {rule.name: rule for rule in reversed(spec.rules)}
    for name in names:
        rule = rules.get(name)
        if rule is not None:
            has = rule.typed is not None
            sheet = Sheet(
                rule, ENGLISH, spec_text(rule), read(rule, spec) if has else None, tell(rule, spec, ENGLISH) if has else None, None, ()
            )  # fmt: skip
            yield name, data(sheet)


def _of(sources: Sources) -> Sheets:
    from trackmarshal.meaning import whole
    from trackmarshal.reading.words.english import ENGLISH

    spec = sources.compiled.spec
    tests: dict[tuple[str, str], str] = {}
    for test in sources.compiled.tests():
        tests.setdefault((test.rule, test.title), test.span.text.rstrip())
    names = [rule.name for rule in spec.rules if whole(spec, rule)]
    return Sheets(
        dict(rule_sheets(spec, names)), tests, {str(kind): word for kind, word in ENGLISH.clauses.items()}
    )


def _said(made: Sheets) -> Mapping[str, Any]:
    return {
        "rules": made.rules,
        "tests": [[*key, text] for key, text in made.tests.items()],
        "clauses": dict(made.clauses),
    }


def _read(said: Any) -> Sheets:
    return Sheets(
        said["rules"], {(rule, title): text for rule, title, text in said["tests"]}, said["clauses"]
    )


__all__ = ["Sheets", "rule_sheets", "sheets"]
