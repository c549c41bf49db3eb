"""Lists of requirements between here and other tools: documents, what other tools call their fields, and what they say beside them."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from trackmarshal.trace import reading, tree
from trackmarshal.trace.documents import REQUIREMENT, REQUIREMENTS
from trackmarshal.trace.findings import Finding, Place, error, warning
from trackmarshal.trace.shapes import Many, Pairs
from trackmarshal.trace.values import Reader, Table

#: What a requirement says of itself, in the order of the files; `foreign` is what others say.
FIELDS = tuple(field.name for field in REQUIREMENT.fields if field.name != "foreign")
LISTS = frozenset(field.name for field in REQUIREMENT.fields if isinstance(field.shape, Many))
#: Names with texts: in other tools, which have no such thing, one text in JSON.
PAIRS = frozenset(
    field.name for field in REQUIREMENT.fields if isinstance(field.shape, Pairs) and field.name != "foreign"
)
#: Between the entries of a list in formats that have texts only.
BETWEEN = "; "
ESCAPE = "foreign:"
#: The largest file that is read, in bytes.
MAX_BYTES = 64_000_000
#: The longest name of a foreign attribute; YAML's keys end at 1024.
MAX_NAME = 200

Value = str | list[str]


@dataclass(frozen=True, slots=True)
class Document:
    """One list of requirements; `name` is its path below `requirements/` without suffix, `table` has the fields of `documents.REQUIREMENTS`."""

    name: str
    table: Table

    @property
    def requirements(self) -> tuple[Table, ...]:
        return self.table.tables("requirements")


@dataclass(slots=True)
class Item:
    """A requirement as another tool has it: its attributes by their names in the exchange, lists or texts, and its line (0: not known)."""

    attributes: dict[str, Value]
    line: int = 0


@dataclass(slots=True)
class Draft:
    """A list of requirements as another tool has it."""

    name: str
    title: str
    source: str = ""
    items: list[Item] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Naming:
    """Which attribute of the other tool is which field, and what a field is where the other tool does not say it."""

    fields: Mapping[str, str] = field(default_factory=dict)  #: by field, the other tool's name
    defaults: Mapping[str, str] = field(default_factory=dict)  #: by field


def of_project(root: Path, found: list[Finding]) -> list[Document]:
    """The lists of requirements of a project; what is wrong with its files goes to `found` (T101 to T128)."""
    return [
        Document(PurePosixPath(shown).relative_to(reading.FOLDER).with_suffix("").as_posix(), table)
        for shown, kind, table in reading.documents(root, found).read
        if kind == "requirements"
    ]


def attributes(requirement: Table, reserved: Collection[str], ending: str = "\0") -> dict[str, Value]:
    """What a requirement says, by names that `taken` reads back: foreign names that a format has a meaning for are escaped."""
    said: dict[str, Value] = {}
    for name in FIELDS:
        if name in requirement:
            value = requirement[name]
            if name in PAIRS:
                value = json.dumps({key: str(text) for key, text in value.items()}, ensure_ascii=False)
            said[name] = str(value) if isinstance(value, str) else [str(entry) for entry in value]
    for name, value in requirement.get("foreign", {}).items():
        said[
            ESCAPE + name if name in reserved or name.startswith(ESCAPE) or name.endswith(ending) else name
        ] = str(value)
    return said


def taken(drafts: Iterable[Draft], naming: Naming, shown: str, found: list[Finding]) -> list[Document]:
    """Drafts as documents of a project; what does not fit goes to `found` (T120 to T128), with file and line."""
    drafts = list(drafts)
    lacking = _said_nowhere(drafts, naming, shown, found)
    found += _named_nowhere(drafts, naming, shown, lacking)
    found += _by_default(drafts, naming, shown)
    misfits: list[Finding] = []
    reader = Reader(shown, misfits)
    made = []
    for draft in drafts:
        node = _mapping({"document": "requirements", "title": draft.title, "source": draft.source}, 0)
        listing = tree.Listing(0, 0)
        listing.items = [_requirement(item, naming, shown, found) for item in draft.items]
        node.entries["requirements"], node.keys["requirements"] = (
            listing,
            tree.Scalar("requirements", False, 0, 0),
        )
        table = reader.table(node, REQUIREMENTS, "the document")
        if table is not None:
            made.append(Document(draft.name, table))
    told = {f"the requirement has no `{name}`" for name in lacking}
    found += [misfit for misfit in misfits if misfit.code != "T120" or misfit.message not in told]
    return made


def _said_nowhere(
    drafts: Iterable[Draft], naming: Naming, shown: str, found: list[Finding]
) -> Collection[str]:
    """The fields that no requirement in the file has: a column of another name is one error, and not one for each row."""
    items = [item for draft in drafts for item in draft.items]
    theirs = {name: None for item in items for name, value in item.attributes.items() if _says(value)}
    said = {*naming.defaults, *(_ours(name, naming) for name in theirs)}
    lacking = [field.name for field in REQUIREMENT.fields if field.required and field.name not in said]
    if not items or not lacking:
        return ()
    message = f"no requirement in the file has {', '.join(f'`{name}`' for name in lacking)}"
    there = [f"`{name[:40]}`" for name in theirs if _ours(name, naming) is None]
    named = f" (there is {', '.join(there[:12])})" if there else ""
    help_ = f"say what it is called there{named}, or what it is for all of them: `--field {lacking[0]}=NAME`, `--default {lacking[-1]}=TEXT`"
    found.append(error("T120", message, Place(shown, items[0].line), help_))
    return lacking


def _named_nowhere(
    drafts: Iterable[Draft], naming: Naming, shown: str, lacking: Collection[str]
) -> Iterator[Finding]:
    """T357 for what `--field` says of a field where no requirement has such a thing: a default stands for whatever they say by another name. Of those that
    are lacking then, there is an error."""
    items = [item for draft in drafts for item in draft.items]
    there = {name: None for item in items for name in item.attributes}
    for ours, theirs in naming.fields.items() if items else ():
        if theirs not in there and ours not in lacking:
            default = naming.defaults.get(ours)
            stands = "" if default is None else f": it is `{default[:40]}` by `--default` in all of them"
            message = f"no requirement in the file has `{theirs[:40]}`, which is to be `{ours}`{stands}"
            named = ", ".join(f"`{name[:40]}`" for name in list(there)[:12])
            yield warning("T357", message, Place(shown, items[0].line), f"there is {named}")


def _by_default(drafts: Iterable[Draft], naming: Naming, shown: str) -> Iterator[Finding]:
    """T357 where a field is what `--default` says, and the file says something by a name that is the field's but for capitals and blanks, where
    `--field` says no other one."""
    told: set[str] = set()
    for item in [item for draft in drafts for item in draft.items]:
        theirs = [name for name, value in item.attributes.items() if _says(value)]
        left = naming.defaults.keys() - naming.fields.keys() - {_ours(name, naming) for name in theirs}
        for name in theirs:
            field = "_".join(name.lower().split())
            if field in left and name not in told:
                told.add(name)
                message = f"`{name[:40]}` is not taken for `{field}`, which is `{naming.defaults[field][:40]}` by `--default`"
                help_ = f"is it the same? `--field {field}={name[:40]}`"
                yield warning("T357", message, Place(shown, item.line), help_)


def _ours(name: str, naming: Naming) -> str | None:
    """The field that an attribute of the other tool is; None where it has none here."""
    for ours, theirs in naming.fields.items():
        if theirs == name:
            return ours
    return name if name in FIELDS and name not in naming.fields else None


def _requirement(item: Item, naming: Naming, shown: str, found: list[Finding]) -> tree.Mapping:
    said: dict[str, Value] = {}
    foreign: dict[str, str] = {}
    for name, value in item.attributes.items():
        ours = _ours(name, naming)
        if not _says(value):
            continue
        if ours is None:
            foreign[name.removeprefix(ESCAPE)] = value if isinstance(value, str) else BETWEEN.join(value)
        else:
            said[ours] = value
    for name, text in naming.defaults.items():
        said.setdefault(name, text)
    for name in [name for name in foreign if len(name) > MAX_NAME or not name.strip()]:
        message = f"the attribute `{name[:40]}` is not taken over: its name is {'longer than ' + str(MAX_NAME) + ' characters' if name.strip() else 'blank'}"
        found.append(warning("T357", message, Place(shown, item.line), "give it another name there"))
        del foreign[name]
    entries: dict[str, Value | dict[str, str]] = {
        name: _shaped(name, said[name]) for name in FIELDS if name in said
    }
    if foreign:
        entries["foreign"] = foreign
    return _mapping(entries, item.line)


def _says(value: Value) -> bool:
    return bool(value.strip()) if isinstance(value, str) else any(entry.strip() for entry in value)


def _shaped(name: str, value: Value) -> Value | dict[str, str]:
    if name in PAIRS and isinstance(value, str):
        try:
            pairs = json.loads(value, object_pairs_hook=list)
            made = dict(pairs)
        except (ValueError, TypeError, RecursionError):
            return value  # which is refused as what it is
        fits = len(made) == len(pairs) and value.lstrip().startswith("{")  # no name twice
        return made if fits and all(isinstance(text, str) for text in made.values()) else value
    if name in LISTS and isinstance(value, str):
        # No id, method or name has a comma, which others put between them.
        return [entry.strip() for entry in re.split(r"[;,\n]", value) if entry.strip()]
    return value if name in LISTS or isinstance(value, str) else BETWEEN.join(value)


def _mapping(entries: Mapping[str, Value | dict[str, str]], line: int) -> tree.Mapping:
    node = tree.Mapping(line, 0)
    for name, value in entries.items():
        if value == "":
            continue
        node.keys[name] = tree.Scalar(name, False, line, 0)
        node.entries[name] = _node(value, line)
    return node


def _node(value: Value | dict[str, str], line: int) -> tree.Node:
    if isinstance(value, str):
        return tree.Scalar(value, False, line, 0)
    if isinstance(value, dict):
        return _mapping(value, line)
    listing = tree.Listing(line, 0)
    listing.items = [tree.Scalar(entry, False, line, 0) for entry in value]
    return listing
