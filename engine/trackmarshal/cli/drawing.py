"""Drawings of the boundaries of a project's rules, kept from one start to the next: what they are made from is the same."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal import cache
from trackmarshal.cli.facts import Facts

if TYPE_CHECKING:
    from trackmarshal.cli.sources import Sources
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.records.specs import SpecItem
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.testing.boundary import Distances

#: Of so many rules and assumptions, in the order of the specs, boundaries are drawn: more of them nobody looks through, and each takes 30 ms.
MOST = 200
CODES = {
    "E494": (
        "a rule without a drawing",
        "`--draw` shows where a demand on numbers ceases to be met. What a rule asks about shapes in the plane, about whether something is so, about many "
        "things at once, or about the run so far, is no such demand; the message says which.",
    ),
}


def drawings(
    root: Path, facts: Facts, sheets: Mapping[str, Mapping[str, Any]], sources: Callable[[], Sources]
) -> dict[str, Mapping[str, Any]]:
    """By rule and assumption what `trackmarshal.reading.drawing` says of it, and `sha`, that of all that it is made from; of the first `MOST` of them.

    sheets: what `show` says of each of them: inputs have the names that they have there. sources: asked for where something has to be drawn anew.
    """
    path = cache.of_project("drawings", root)
    keys = _keys(facts, sheets)
    found = _under(keys, path)
    missing = [name for name in keys if name not in found]
    if missing:
        found |= _made(missing, facts, sources())
        if path is not None:
            cache.keep(path, {keys[name]: drawing for name, drawing in found.items()})
    return {name: {**drawing, "sha": keys[name]} for name, drawing in found.items()}


def kept_drawings(
    root: Path, facts: Facts, sheets: Mapping[str, Mapping[str, Any]]
) -> dict[str, Mapping[str, Any]]:
    """Those of `drawings` that were made once and are made from what is there now; nothing is drawn."""
    path = cache.of_project("drawings", root)
    return _under(_keys(facts, sheets), path) if path is not None and path.is_file() else {}


def _under(keys: Mapping[str, str], path: Path | None) -> dict[str, Mapping[str, Any]]:
    """By name, what is kept under its key."""
    kept = (None if path is None else cache.kept(path)) or {}
    return {name: kept[key] for name, key in keys.items() if key in kept}


def recordings(facts: Facts, sources: Sources) -> list[tuple[Recording, Evaluator]]:
    """The project's recordings that are there, each with the rules that it is replayed with."""
    return [one for shown, one in sources.recorded.items() if "recording" in facts.run_inputs.get(shown, {})]


def of_project(root: Path) -> tuple[list[tuple[Recording, Evaluator]], Distances]:
    """A project's recordings with the rules that they are replayed with, and by how much it moves limits."""
    from trackmarshal.cli.sources import Sources
    from trackmarshal.trace import requirements

    sources = Sources(root, requirements.load(root, []))
    return recordings(sources.facts(), sources), sources.distances


def _made(names: Sequence[str], facts: Facts, sources: Sources) -> dict[str, Mapping[str, Any]]:
    from trackmarshal.reading.drawing.making import drawings as made

    rules = [rule for rule in sources.compiled.spec.rules if rule.name in names]
    found = made(
        rules, sources.compiled.spec, sources.prepared, recordings(facts, sources), sources.distances
    )
    # As it is read again: the first time is like all others.
    return {name: json.loads(json.dumps(drawing)) for name, drawing in found}


def _keys(facts: Facts, sheets: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """By name of all that are drawn, what the drawing is kept under."""
    tests: dict[str, list[Any]] = {}
    for one in facts.tests:
        tests.setdefault(one.rule, []).append([one.title, one.fingerprint, one.boundary])
    items = [item for item in facts.items if item.name in sheets]
    return {
        item.name: _key(item, facts, sheets[item.name], tests.get(item.name, [])) for item in items[:MOST]
    }


def _key(item: SpecItem, facts: Facts, sheet: Mapping[str, Any], tests: Sequence[Any]) -> str:
    """One hash of the rule with all that it reads and is called, its tests, the recordings that it is replayed with, and the engine."""
    from trackmarshal.meaning.tool import tool

    own = f"rule {item.name}"
    runs = {
        shown: {name: sha for name, sha in inputs.items() if name == own or not name.startswith("rule ")}
        for shown, inputs in facts.run_inputs.items()
        if own in inputs and "recording" in inputs
    }
    said = json.dumps([tool(), sheet, dict(item.inputs), tests, runs], sort_keys=True)
    return hashlib.sha256(said.encode()).hexdigest()
