"""The next piece of a project: files that pass `trackmarshal check` at once, with a TODO where their author has to write."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import below, read_regular
from trackmarshal.start.subject import subject
from trackmarshal.start.writing import render, write_new

if TYPE_CHECKING:
    from trackmarshal.semantics.compile import Compiled

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_REQUIREMENT = re.compile(r"[A-Z][A-Za-z0-9]*(-[A-Za-z0-9]+)+")
_TRACK = re.compile(r"^format: *trackmarshal-track\b", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Place:
    """Where pieces go: the project's folder, the one that its modules' names start in, and what its specs say now."""

    root: Path
    specs: Path
    #: All files and folders of its specs.
    paths: tuple[Path, ...]
    compiled: Compiled
    #: The ids of its requirements.
    requirements: frozenset[str]


@dataclass(frozen=True, slots=True)
class Piece:
    """What was written, and what its author does next."""

    written: list[Path]
    next: tuple[str, ...]


def rule(place: Place, name: str, satisfies: tuple[str, ...] = ()) -> Piece:
    """A rule about the first signal that has a number, in a module of its own. Raises E412, E413, E414."""
    _word(name, "rule")
    if any(known.name == name for known in place.compiled.spec.rules):
        raise _there(f"a rule `{name}`")
    for missing in satisfies:
        if missing not in place.requirements:
            raise TrackmarshalError(
                "E413",
                f"the project has no requirement {missing}",
                help=f"`trackmarshal new requirement {missing}` writes it",
            )
    about = subject(place.compiled)
    text = render(
        "pieces/rule.spec.j2", name=name, module=about.module, satisfies=", ".join(satisfies), about=about
    )
    written = _new_spec(place, f"{name}.spec", text)
    gaps = "a requirement that it satisfies, and " if not satisfies else ""
    return Piece(
        written,
        (
            f"write what must hold in {_shown(place, written[0])}, and its tests; `trackmarshal test` says when they are enough",
            f"until then `trackmarshal trace --gate` is red, as it should be: it asks for {gaps}tests on both sides",
        ),
    )


def requirement(place: Place, name: str) -> Piece:
    """A requirement in a file of its own. Raises E412, E413."""
    if not _REQUIREMENT.fullmatch(name):
        raise TrackmarshalError(
            "E413",
            f"`{name}` is no id of a requirement",
            help="a capital first, then parts with hyphens between: R-2, S-1-A-4",
        )
    if name in place.requirements:
        raise _there(f"a requirement {name}")
    path = f"requirements/{name.lower()}.yaml"
    written = write_new(place.root, {path: render("pieces/requirement.yaml.j2", name=name)})
    return Piece(
        written,
        (
            f"write what is demanded, and why, in {path}",
            f"`trackmarshal new rule NAME --satisfies {name}` writes a rule for it",
            "until rules, tests and scenarios cover it, `trackmarshal trace --gate` is red, as it should be",
        ),
    )


def rulebook(place: Place, name: str) -> Piece:
    """An order of all rules that the project has, all equal to begin with. Raises E412, E413, E414."""
    _word(name, "rulebook")
    if any(known.name == name for known in place.compiled.spec.rulebooks):
        raise _there(f"a rulebook `{name}`")
    rules = [known for known in place.compiled.spec.rules if known.kind == "rule"]
    if not rules:
        raise TrackmarshalError(
            "E414", "there is no rule to put into an order", help="`trackmarshal new rule NAME` writes one"
        )
    files = {rule.span.file.path for rule in rules}
    modules = place.compiled.library.modules
    used = [module for module in place.compiled.order if modules[module].file.path in files]
    text = render("pieces/rulebook.spec.j2", name=name, modules=used, rules=[rule.name for rule in rules])
    written = _new_spec(place, f"rulebooks/{name}.spec", text)
    return Piece(
        written,
        (f"put the rules into their order in {_shown(place, written[0])}: `>` outranks, `~` ranks equal",),
    )


def scenario(place: Place, name: str) -> Piece:
    """A scenario on the project's first road, or on a straight one that is written too. Raises E412, E413."""
    _word(name, "scenario")
    folder = place.specs / "scenarios"
    track = next(filter(_is_track, below(place.specs, (".yaml",))[0]), None)
    texts = {}
    if track is None:
        track = place.specs / "tracks" / "straight.yaml"
        texts[str(track.relative_to(place.root))] = render("project/straight.yaml")
    path = (folder / f"{name}.yaml").relative_to(place.root).as_posix()
    road = Path(os.path.relpath(track, folder)).as_posix()
    texts = {path: render("pieces/scenario.yaml.j2", name=name, track=road), **texts}
    written = write_new(place.root, texts)
    return Piece(
        written,
        (
            f"write what happens in {path}: docs/scenarios.md of trackmarshal has every key",
            f"`trackmarshal replay {path}` runs it, and says what the rules say of it",
            f"to make it evidence, name it under `scenarios` in requirements/v-model.yaml: {{path: {path}, title: ..., stage: ..., "
            "expect: ground_truth, origin: synthetic}",
        ),
    )


def _word(name: str, what: str) -> None:
    if not _WORD.fullmatch(name) or name == "prelude":  # `use prelude` means the tool's
        raise TrackmarshalError(
            "E413",
            f"`{name}` is no name for a {what}",
            help="letters, digits and _, no digit first: keep_left",
        )


def _there(what: str) -> TrackmarshalError:
    return TrackmarshalError("E412", f"the project has {what} already", help="choose another name")


def _new_spec(place: Place, name: str, text: str) -> list[Path]:
    """Write a module of the project, laid out; one that the language does not take is taken back, and raises E413."""
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.source import of_text
    from trackmarshal.syntax.format import format_text

    path = (place.specs / name).relative_to(place.root).as_posix()
    try:
        laid_out = format_text(of_text(text))
    except TrackmarshalError as error:
        raise _unusable(name, str(error).splitlines()[0]) from error
    written = write_new(place.root, {path: laid_out})
    errors = compile_paths(place.paths, place.root).errors
    if errors:
        written[0].unlink()
        raise _unusable(name, errors[0].message)
    return written


def _unusable(name: str, why: str) -> TrackmarshalError:
    return TrackmarshalError(
        "E413",
        f"the language has another use for `{Path(name).stem}`: {why}",
        help="nothing was written; choose another name",
    )


def _shown(place: Place, path: Path) -> str:
    return path.relative_to(place.root).as_posix()


def _is_track(path: Path) -> bool:
    return _TRACK.search(read_regular(path).decode("utf-8", "replace")) is not None
