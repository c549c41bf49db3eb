"""The ids of requirements that tests name, held against those that the project demands."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

import pytest

VERIFIES = "verifies"


def names_ids(item: pytest.Item) -> bool:
    """Whether a test names what it verifies."""
    return any(name == VERIFIES for name, _ in item.user_properties)


def verified(item: pytest.Item) -> tuple[list[str], list[str]]:
    """The ids that a test names, nearest first, and what is wrong with them."""
    ids: dict[str, None] = {}
    wrong: list[str] = []
    for mark in item.iter_markers(VERIFIES):
        if mark.kwargs or not mark.args or not all(isinstance(id_, str) for id_ in mark.args):
            wrong.append('`verifies` takes ids of requirements: @pytest.mark.verifies("S-1-B-1")')
            continue
        ids |= dict.fromkeys(mark.args)
    known = _known(item.config) if ids else frozenset()
    other = _of_another(item) if ids else None
    if isinstance(known, str):
        wrong.append(known)
        ids = {}
    elif other is not None:  # which may have requirements of the same ids
        wrong.append(
            f"this verifies requirements of another project: run its tests by themselves, with --trackmarshal-project {other}"
        )
    else:
        wrong += [
            f"error[T336]: no requirement `{id_}` is demanded{_suggested(id_, known)}"
            for id_ in ids
            if id_ not in known
        ]
    if not wrong:  # where a test stands takes longer to find than all the rest
        return list(ids), []
    where = f"{item.location[0]}:{(item.location[1] or 0) + 1}"
    return list(ids), [f"{where}: {said}" for said in wrong]


def _suggested(id_: str, known: frozenset[str]) -> str:
    from trackmarshal.trace.findings import did_you_mean

    said = did_you_mean(id_, known)
    return f"; {said}" if said else ""


_KNOWN = pytest.StashKey[frozenset[str] | str]()


def _known(config: pytest.Config) -> frozenset[str] | str:
    """The ids of the project's requirements, or why they are not known."""
    if _KNOWN not in config.stash:
        from trackmarshal.trace import requirement_ids

        root = project(config)
        if root is None:
            said = f"no project is around {config.rootpath}; name one with --trackmarshal-project DIR"
            config.stash[_KNOWN] = said
        else:
            config.stash[_KNOWN] = frozenset(map(str, requirement_ids(root)))
    known: frozenset[str] | str = config.stash[_KNOWN]
    return known


def project(config: pytest.Config) -> Path | None:
    from trackmarshal.cli.project import MARKER, project_of

    named = config.getoption("--trackmarshal-project")
    if named is None:
        return project_of(config.rootpath)
    root: Path = (config.invocation_params.dir / named).resolve()
    if not (root / MARKER).is_file():
        raise pytest.UsageError(f"--trackmarshal-project: {root} has no {MARKER}")
    return root


def _of_another(item: pytest.Item) -> str | None:
    """Another project than that of this session in whose folder a test stands, from pytest's root directory; None where there is none."""
    own, root = _around(item.path.parent), project(item.config)
    return None if own is None or own == root else Path(os.path.relpath(own, item.config.rootpath)).as_posix()


@cache
def _around(folder: Path) -> Path | None:
    """The project that a folder is in, or None; asked for each test."""
    from trackmarshal.cli.project import project_of

    return project_of(folder)
