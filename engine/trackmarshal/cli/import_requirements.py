"""Requirements of another tool as files of the project (docs/exchange.md)."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from trackmarshal.cli.output import count, say
from trackmarshal.cli.project import from_project, optional_project
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import write_whole
from trackmarshal.json_text import named_twice
from trackmarshal.trace import exchange
from trackmarshal.trace.exchange import Document, Naming
from trackmarshal.trace.findings import Finding


def run(args: argparse.Namespace) -> int:
    """Write the requirements; 2 where something keeps them from being taken over, and then nothing is written."""
    from trackmarshal.trace import load

    path = Path(args.file)
    found: list[Finding] = []
    naming = Naming(_named(args.fields), _pairs(args.defaults, "--default"))
    documents = exchange.read(
        exchange.load(path, args.file), args.format or exchange.format_of(path), args.file, naming, found
    )
    root = optional_project(args)
    targets = _targets(documents, path, root, args.out)
    project = load(root)[0] if root is not None and (root / "requirements").is_dir() else None
    written = {from_project(root, target) for target in targets} if root is not None else set()
    beside = not any(target.startswith("requirements/") for target in written)
    found += exchange.check(documents, project, written, beside)
    there = [target for target in targets if os.path.lexists(target)]
    found += exchange.lost(
        documents, [(one, str(one) if root is None else from_project(root, one)) for one in there]
    )
    for finding in dict.fromkeys(found):
        if finding.level == "error" or not args.quiet:
            say(*str(finding).split("\n"), file=sys.stderr)
    if any(finding.level == "error" for finding in found):
        return 2
    texts = {target: exchange.yaml(document) for target, document in zip(targets, documents)}
    if there and not args.force:
        raise TrackmarshalError(
            "E412",
            f"{there[0]} is there already",
            file=str(there[0]),
            help="nothing was written; choose another name with `--out`, or write over it with `--force`",
        )
    for target, text in texts.items():
        _write(target, text)
    if not args.quiet:
        for target, document in zip(targets, documents):
            say(f"{target}: {count(len(document.requirements), 'requirement')}")
    return 0


def _targets(documents: list[Document], path: Path, root: Path | None, out: str | None) -> list[Path]:
    """Where each list goes: one into a file, several into a folder, by their names."""
    folder = (root or Path()) / "requirements"
    to_file = out is not None and Path(out).suffix.lower() in (".yaml", ".yml")
    if not documents:
        raise exchange.Refused(
            "T354", "there are no requirements in the file", str(path), help="what was exported?"
        )
    if len(documents) == 1 and (out is None or to_file):
        return [folder / f"{_name(path.stem)}.yaml" if out is None else Path(out)]
    if to_file:
        raise exchange.Refused(
            "T360",
            f"the file holds {len(documents)} lists, and `{out}` is one file",
            str(path),
            help="let `--out` name a folder",
        )
    targets = [
        (folder if out is None else Path(out)) / f"{_name(document.name)}.yaml" for document in documents
    ]
    twice = named_twice(targets)
    if twice is not None:
        raise exchange.Refused(
            "T360",
            f"two of the lists would be `{twice}`",
            str(path),
            help="give them names of their own in the other tool",
        )
    return targets


def _name(name: str) -> str:
    """A list's name as a path without a way out of its folder."""
    parts = [re.sub(r"[^\w.-]+", "-", part).strip(".-") for part in name.split("/")]
    return "/".join(part for part in parts if part) or "requirements"


def _write(target: Path, text: str) -> None:
    """The whole file, or what was there."""
    target.parent.mkdir(parents=True, exist_ok=True)
    write_whole(target, text.encode("utf-8"))


def _named(given: Sequence[str]) -> dict[str, str]:
    """What the other tool calls each field; raises T360 for a name that stands for two, of which one would go without."""
    pairs = _pairs(given, "--field")
    twice = named_twice(pairs.values())
    if twice is not None:
        named = " and ".join(f"`{field}`" for field, name in pairs.items() if name == twice)
        raise exchange.Refused(
            "T360",
            f"`{twice}` is to be {named}",
            "",
            help="name one field, and give the other one by `--default`, or write it there",
        )
    return pairs


def _pairs(given: Sequence[str], option: str) -> dict[str, str]:
    twice = named_twice(text.partition("=")[0] for text in given)
    if twice is not None:
        raise exchange.Refused(
            "T360", f"`{option} {twice}=..` is given twice", "", help="leave out one of both"
        )
    pairs = dict(text.partition("=")[::2] for text in given)
    for name, text in pairs.items():
        if name not in exchange.FIELDS or not text:
            raise exchange.Refused(
                "T360",
                f"`{option} {name}={text}` names no field and what it is",
                "",
                help="fields are " + ", ".join(exchange.FIELDS),
            )
    return pairs
