"""The baseline's file: what was accepted, and by whom."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from datetime import date
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import UNMERGED, read_regular, unmerged, write_whole
from trackmarshal.json_text import strict
from trackmarshal.trace.baseline.changes import Tell, changes
from trackmarshal.trace.baseline.content import Content, carried, counted
from trackmarshal.trace.findings import Finding, Place, error
from trackmarshal.trace.model import Project
from trackmarshal.trace.sections import lettered
from trackmarshal.trace.shapes import put_off

FORMAT = "trackmarshal-baseline"
VERSION = 2
MAX_BYTES = 64_000_000
DEFAULT = "requirements/baseline.json"
#: A number of things.
_COUNT = re.compile("[0-9]{1,9}")


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Who accepted what, and why. after: the hash of the content that was there then. engine: the one that made the evidence; empty where nobody said."""

    on: str
    by: str
    reason: str
    weaker: tuple[str, ...]
    after: str
    engine: str = ""


@dataclass(frozen=True, slots=True)
class Baseline:
    """What was accepted, and how it came to that, the last acceptance last."""

    content: Content
    acceptances: tuple[Acceptance, ...]


def accept(
    root: Path,
    project: Project,
    now: Content,
    by: str,
    reason: str,
    today: date,
    tell: Tell | None = None,
    engine: str = "",
    there: Mapping[str, frozenset[str]] | None = None,
) -> tuple[Path, list[str]]:
    """Write the baseline of a project anew, whole or not at all; returns its path, and what became weaker by that.

    there: all tests of other runners by report, as `carried` takes them. tell: whether rules got weaker or stronger, which stays in the acceptance. Raises T378 where something became weaker and nobody says who accepts it, or why, T153 where who does is none of the persons that the project declares; T220 for a baseline that cannot be read, T379 for one that was changed by hand.
    """
    found: list[Finding] = []
    path = root / (project.baseline or DEFAULT)
    before = load(root, project, found) if path.is_file() else None
    for finding in found:  # accepting on top of what nobody accepted would hide it
        raise TrackmarshalError(
            finding.code, finding.message, file=finding.place and finding.place.file, help=finding.help
        )
    now = carried({} if before is None else before.content, now, there or {})
    weaker = (
        []
        if before is None
        else [str(change) for change in changes(before.content, now, tell) if change.weaker]
    )
    # What was accepted once with such words stays: of histories, it is asked that somebody is named.
    if weaker and not all(lettered(said) and not put_off(said) for said in (by, reason)):
        more = f", and {len(weaker) - 1} more" if len(weaker) > 1 else ""
        raise TrackmarshalError(
            "T378", f"less is demanded or shown than was accepted: {weaker[0]}{more}",
            help='say who accepts that, and why: `--by "NAME" --reason "..."`',
        )  # fmt: skip
    # Those of before, too: whoever strikes all persons is not free to be nobody.
    known = [*now.items(), *({} if before is None else before.content).items()]
    persons = {key.removeprefix("person "): said["title"] for key, said in known if key.startswith("person ")}
    if weaker and persons and by.strip() not in {*persons, *persons.values()}:
        raise TrackmarshalError(
            "T153", f"less is demanded or shown than was accepted, and `{by.strip()}`, who is to accept it, is none of the persons of the project",
            help=f"`--by` one of {', '.join(f'`{title}`' for title in dict.fromkeys(persons.values()))}, or add who does to `persons`",
        )  # fmt: skip
    done = () if before is None else before.acceptances
    if before is not None and before.content == now and done[-1].engine == engine:
        return path, []
    made = Acceptance(today.isoformat(), by.strip(), reason.strip(), tuple(weaker), digest(now), engine)
    said = {
        "format": FORMAT,
        "version": VERSION,
        "content": now,
        "acceptances": [_record(one) for one in (*done, made)],
    }
    write_whole(path, (json.dumps(said, indent=1, ensure_ascii=False) + "\n").encode("utf-8"))
    return path, weaker


def _record(one: Acceptance) -> dict[str, Any]:
    """An acceptance as it stands in the file; those of before stay as they are."""
    return {name: value for name, value in asdict(one).items() if value or name != "engine"}


def digest(content: Content) -> str:
    """One hash of all that was accepted."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, ensure_ascii=False).encode()).hexdigest()


def load(root: Path, project: Project, found: list[Finding]) -> Baseline | None:
    """The accepted baseline; None where the project has none, or one that cannot be used, which is a finding (T220, T379)."""
    named = project.baseline
    help_ = "accept one with `trackmarshal trace --accept-baseline`"
    if named is None and project.place is None:
        return None  # that there is no v-model was told
    if named is None:
        message = "the project names no baseline, so nothing is noticed that weakens"
        found.append(error("T220", message, project.place, f"add `baseline: {DEFAULT}`, and {help_}"))
        return None
    try:
        made = read(root / named)
    except FileNotFoundError:
        found.append(error("T220", "the project names a baseline, but there is none", named.place, help_))
        return None
    except (OSError, ValueError, RecursionError) as problem:
        said = problem.strerror if isinstance(problem, OSError) else str(problem) or type(problem).__name__
        message = f"the baseline cannot be read: {said}"
        help_ = "restore it from version control"
        if UNMERGED in message:
            help_ = "take the whole file of one side, such as by `git checkout --ours`, and accept what is there now"
        found.append(error("T220", message, Place(str(named)), help_))
        return None
    if made.acceptances[-1].after != digest(made.content):
        message = "the baseline is not what was accepted last: it was changed by hand, or merged"
        help_ = "restore it from version control, and accept what is there now"
        found.append(error("T379", message, Place(str(named)), help_))
    return made


def read(path: Path) -> Baseline:
    """The baseline in a file; raises OSError, ValueError or RecursionError for what is none."""
    if path.stat().st_size > MAX_BYTES:
        raise ValueError(f"larger than {MAX_BYTES // 1_000_000} MB")
    data = read_regular(path)
    if begins := unmerged(data):
        raise ValueError(f"line {begins}: {UNMERGED}")
    return checked(strict(data))


def checked(data: Any) -> Baseline:
    """What a baseline's JSON says; raises ValueError for what is none of today's format."""
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError(f"its format is not `{FORMAT}`")
    if data.get("version") != VERSION:
        raise ValueError(f"its version is not {VERSION}: restore what it guards, and accept it anew")
    content, acceptances = data.get("content"), data.get("acceptances")
    if content is None or acceptances is None or not (_is_content(content) and _are_acceptances(acceptances)):
        raise ValueError("it is not what `--accept-baseline` writes")
    done = tuple(Acceptance(**{**one, "weaker": tuple(one["weaker"])}) for one in acceptances)
    return Baseline(content, done)


def _are_acceptances(said: object) -> bool:
    """Whether each has the fields of an acceptance, and they are texts; earlier ones have no engine."""
    names = {field.name for field in fields(Acceptance)}
    return bool(said) and isinstance(said, list) and all(
        isinstance(one, dict)
        and names - {"engine"} <= one.keys() <= names
        and all(_are_texts(value) if name == "weaker" else isinstance(value, str) for name, value in one.items())
        for one in said
    )  # fmt: skip


def _is_content(content: object) -> bool:
    return isinstance(content, dict) and all(
        isinstance(entry, dict) and all(_is_value(key, field, value) for field, value in entry.items())
        for key, entry in content.items()
    )


def _is_value(key: str, field: str, value: object) -> bool:
    if counted(key.partition(" ")[0], field):
        return isinstance(value, str) and _COUNT.fullmatch(value) is not None
    return isinstance(value, str) or _are_texts(value)


def _are_texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(text, str) for text in value)
