"""What the command prints for machines, held against the JSON schemas beside what makes it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from typing import Any, NoReturn

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

from support.length import amount
from support.shared import REPOSITORY

#: By command, the schema of what `--format json` or `jsonl` prints. A flag behind a verb: with it, another one.
SCHEMAS = {
    "check": "check", "test": "test", "eval": "eval", "replay": "replay", "choose": "choose", "check-planner": "check-planner", "diff": "diff",
    "show": "show", "import": "import-log", "gsn": "gsn", "bench": "bench", "trace": "matrix", "trace --impact": "impact", "trace --from": "paths",
    "trace --to": "paths", "trace --statistics": "statistics",
}  # fmt: skip
#: So many outputs of a kind are looked at in a process, and so many lines of one from its beginning and its end: it takes longer than what prints them.
MOST, LINES = 12, 4
#: So many plain values of a list are held as they stand: of a series of a thousand numbers, all others say the same of its schema.
PLAIN = 8

_held: Counter[str] = Counter()


@cache
def schemas() -> dict[str, Any]:
    """By its name, each schema that is shipped."""
    found = [*(REPOSITORY / "engine").rglob("*.schema.json"), *(REPOSITORY / "trace").rglob("*.schema.json")]
    return {path.name: json.loads(path.read_text("utf-8")) for path in found}


@cache
def validator(name: str) -> Draft202012Validator:
    registry: Registry[Any] = Registry().with_resources(
        (file, Resource.from_contents(schema)) for file, schema in schemas().items()
    )
    return Draft202012Validator(schemas()[f"{name}.schema.json"], registry=registry)


def schema_of(arguments: Sequence[str]) -> str | None:
    """The schema of what a command prints; None where it is for people, or of a format that others define."""
    machine = "--json" in arguments or any(
        pair in (("--format", "json"), ("--format", "jsonl")) for pair in pairwise(arguments)
    )
    verb = next((word for word in arguments if word in SCHEMAS), None)
    if not machine or verb is None or (verb == "import" and "log" not in arguments):
        return None
    return next((SCHEMAS[f"{verb} {word}"] for word in arguments if f"{verb} {word}" in SCHEMAS), SCHEMAS[verb])  # fmt: skip


def hold(arguments: Sequence[str], out: str) -> None:
    """Raises where a command printed for machines what its schema does not say."""
    name = schema_of([*map(str, arguments)])
    if name is None or not out or _held[name] >= MOST:
        return
    _held[name] += 1
    for value in values(arguments, out):
        validator(name).validate(amount(brief(value), value))


def brief(value: Any) -> Any:
    """The same, but of long lists of plain values only the first ones, each other word and kind of value, and the least and the greatest number."""
    if isinstance(value, dict):
        return {name: brief(one) for name, one in value.items()}
    if not isinstance(value, list):
        return value
    if len(value) <= PLAIN or any(isinstance(one, dict | list) for one in value):
        return [brief(one) for one in value]
    # Of floats, whole ones are integers to a schema.
    kinds = {
        one if isinstance(one, str) else (type(one), isinstance(one, float) and one.is_integer()): one
        for one in value[PLAIN:]
    }
    numbers = [one for one in value if isinstance(one, int | float)]
    return [*value[:PLAIN], *kinds.values(), *({min(numbers), max(numbers)} if numbers else ())]


def values(arguments: Sequence[str], out: str) -> Iterator[Any]:
    """What was printed; of lines, those at both ends. Raises ValueError for what is no strict JSON."""
    if "jsonl" not in arguments:
        yield strict(out)
        return
    lines = out.splitlines()
    yield from map(strict, lines if len(lines) <= 2 * LINES else [*lines[:LINES], *lines[-LINES:]])


def strict(text: str) -> Any:
    return json.loads(text, parse_constant=_no_number)


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is no number of JSON")
