"""Kept results of runs in a closed loop, as the document reads them: which fault, in which situation, what found it and when, and what became of the car."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import read_regular
from trackmarshal.json_text import named_twice, strict

FORMAT, VERSION = "trackmarshal-closed-loop", 1
#: What became of a car, from best to worst, with the status that it looks like.
OUTCOMES = {"drives_on": "covered", "resumed": "waived", "stopped": "covered", "off_road": "failed", "contact": "failed"}  # fmt: skip


_SHA256 = re.compile(r"\b[0-9a-f]{64}\b")


@dataclass(frozen=True, slots=True)
class LoopRun:
    """speed: of the car when the fault began, m/s; after: from the first faulty cycle that the Supervisor had to its first unsafe decision, s, and
    None where there was none; clearance, gap: the least to a border and to another car, m."""

    fault: str
    requirement: str
    beyond: str  #: the assumption that the fault breaks; "" for what the Supervisor answers for
    track: str
    traffic: bool
    place: str
    speed: float
    after: float | None
    found: str  #: the rule or fault that made that decision unsafe
    below: bool  #: whether the layer below stopped the car by itself
    outcome: str
    clearance: float
    gap: float | None


@dataclass(frozen=True, slots=True)
class Loop:
    """All runs of a campaign, in the order of the file. titles: by fault; it may lack some. pages: those of evidence that give a hash of the file, and
    whether it is this one."""

    path: str
    sha256: str
    titles: Mapping[str, str]
    runs: tuple[LoopRun, ...]
    pages: Mapping[str, bool]


def read(root: Path, path: str, sha256: str, reviewed: Iterable[str] = ()) -> Loop:
    """The results in a file of the project. reviewed: evidence whose contents somebody has reviewed, which may be a page of these results. Raises
    TrackmarshalError T437 where the file holds something else."""
    try:
        said = strict(read_regular(root / path))
    except (OSError, ValueError) as problem:
        _refused(path, str(problem) or type(problem).__name__)
    if not isinstance(said, dict) or said.get("format") != FORMAT or said.get("version") != VERSION:
        _refused(path, f"`format` is to be `{FORMAT}` and `version` {VERSION}")
    runs, titles = said.get("runs"), said.get("faults", {})
    if not isinstance(runs, list) or not isinstance(titles, dict):
        _refused(path, "`runs` is to be a list, and `faults` an object")
    made = tuple(_run(path, n, run) for n, run in enumerate(runs, 1))
    again = named_twice(made)
    if again is not None:
        _refused(
            path, f"a run of `{again.fault}` on {again.track} is there twice, so that it would count twice"
        )
    pages = {page: sha256 in given for page in reviewed if (given := _hashes(root / page, path))}
    return Loop(path, sha256, {str(id_): str(title) for id_, title in titles.items()}, made, pages)


def _hashes(page: Path, path: str) -> set[str]:
    """The hashes in lines of a page that name a file, and no other one whose name ends or begins so."""
    named = re.compile(rf"(?<![\w./-])(?:\.{{1,2}}/)*{re.escape(path)}(?![\w/-]|\.\w)")
    try:
        lines = read_regular(page).decode("utf-8", "replace").splitlines()
    except (OSError, ValueError):
        return set()
    return {found for line in lines if named.search(line) for found in _SHA256.findall(line)}


def _run(path: str, number: int, said: Any) -> LoopRun:
    if not isinstance(said, dict):
        _refused(path, f"run {number} is no object")
    texts = [said.get(name) for name in ("fault", "requirement", "beyond", "track", "place", "outcome")]
    if not all(isinstance(text, str) for text in texts) or type(said.get("traffic")) is not bool:
        _refused(path, f"run {number} lacks what it was of, or what came of it")
    if said["outcome"] not in OUTCOMES:
        _refused(path, f"the outcome of run {number} is {said['outcome']!r}; known are {', '.join(OUTCOMES)}")
    reaction, found, after = said.get("reaction"), "", None
    if reaction is not None:
        names = reaction.get("found") if isinstance(reaction, dict) else None
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            _refused(path, f"the reaction of run {number} does not say what found the fault")
        found, after = (names[0] if names else ""), _number(path, number, reaction, "after")
    gap = None if said.get("gap") is None else _number(path, number, said, "gap")
    return LoopRun(
        said["fault"], said["requirement"], said["beyond"], said["track"], said["traffic"], said["place"], _number(path, number, said, "speed"),
        after, found, reaction is None and said.get("below") is not None, said["outcome"], _number(path, number, said, "clearance"), gap,
    )  # fmt: skip


def _number(path: str, number: int, said: Mapping[str, Any], name: str) -> float:
    value = said.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        _refused(path, f"`{name}` of run {number} is no finite number")
    return float(value)


def _refused(path: str, why: str) -> NoReturn:
    raise TrackmarshalError(
        "T437", f"results of a closed loop that cannot be used: {why}", file=path, help="`closed_loop` in v-model.yaml names what `closed_loop.campaign --keep` wrote"
    )  # fmt: skip


__all__ = ["OUTCOMES", "Loop", "LoopRun", "read"]
