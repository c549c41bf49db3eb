"""The parameters and tables that decide in a run: what they are, where that comes from, and which rules read them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import ParamInfo, RuleInfo, Spec, TableInfo, short_name
from trackmarshal.scenarios.overrides import Override, known_params, overrides
from trackmarshal.scenarios.recording import Recording
from trackmarshal.units import in_full, to_si

_MODULE = re.compile(r"^module[ \t]+([\w.]+)", re.MULTILINE)


def in_force(recording: Recording, spec: Spec, rules: Iterable[RuleInfo]) -> Iterator[dict[str, Any]]:
    """What the rules read of the settings of a spec, as they are in a recording, by kind (`param`, `table`) and name.

    value: of a parameter in SI, of a table None. written: as its author would write it. source: of the value in force; empty where nobody
    gives one. span: where the spec or a configuration has it. module: of the configuration that replaced the spec's own value, empty where
    none did. own: what the recording replaced, empty where it did not. rules: those that read it.
    """
    readers: dict[str, list[str]] = {}
    for rule in rules:
        for name in _settings(rule.formula) | _settings(rule.active):
            readers.setdefault(name, []).append(rule.name)
    replaced = {(one.kind, one.name): one for one in overrides(recording, spec)}
    given = known_params(recording, spec)
    for name, info in sorted(spec.params.items()):
        if name in readers:
            value = given.get(info.name, given.get(info.short))
            number = info.value if value is None else to_si(value, info.unit)
            one = replaced.get(("param", name))
            yield _entry(info, number, in_full(number, info.unit), one, readers[name])
    for name, table in sorted(spec.tables.items()):
        if name in readers:
            rows = recording.tables.get(name, recording.tables.get(short_name(table), table.knots))
            yield _entry(table, None, f"{len(rows)} knots", replaced.get(("table", name)), readers[name])


def _entry(
    info: ParamInfo | TableInfo,
    value: float | None,
    written: str,
    replaced: Override | None,
    rules: list[str],
) -> dict[str, Any]:
    own = info.name.removesuffix(f".{short_name(info)}")
    said = _MODULE.search(info.span.file.text)
    module = own if said is None else said[1]
    source = getattr(info, "source", None) or ""
    return {
        "kind": "param" if isinstance(info, ParamInfo) else "table", "name": info.name, "value": value, "written": written,
        "source": source if replaced is None else replaced.because, "span": str(info.span), "module": "" if module == own else module,
        "own": "" if replaced is None else replaced.own, "rules": rules,
    }  # fmt: skip


@lru_cache(maxsize=1024)
def _settings(formula: ir.Formula | None) -> frozenset[str]:
    """The parameters and tables that a formula reads."""
    nodes = () if formula is None else ir.below(formula)
    found = set()
    for node in nodes:
        if isinstance(node, ir.Param):
            found.add(node.name)
        elif isinstance(node, ir.Lookup | ir.GridLookup):
            found.add(node.table)
    return frozenset(found)
