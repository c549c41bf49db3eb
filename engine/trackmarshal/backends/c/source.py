"""A whole program: header, source, and the binding that Python calls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from trackmarshal.backends.c import grids, parts
from trackmarshal.backends.c.courses import counts_samples
from trackmarshal.backends.c.functions.groups import GroupCode, group_codes
from trackmarshal.backends.c.functions.online import Monitor, monitors
from trackmarshal.backends.c.functions.rules import RuleCode, rule_code
from trackmarshal.backends.c.functions.types import CASES, FOLD, SEVERAL, TALLY, TRUTH
from trackmarshal.backends.c.header import header, numbered
from trackmarshal.backends.c.layout import Layout, layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.over_run.writing import joining, recalling, remembering
from trackmarshal.backends.c.places import initial, own_places
from trackmarshal.backends.c.rendering import render
from trackmarshal.backends.c.rulebooks import RANKS, BookCode, book_codes, declared, defined
from trackmarshal.backends.c.setters import calls, setters
from trackmarshal.backends.c.supervised import machine
from trackmarshal.backends.c.supervised.configuration import configuration
from trackmarshal.backends.c.supervised.contract import Supervised, supervised_layout
from trackmarshal.backends.c.supervised.door import Door
from trackmarshal.backends.c.supervised.judging import calls as rule_calls
from trackmarshal.backends.c.supervised.judging import judge
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec


@dataclass(frozen=True)
class Source:
    """The generated files' texts, and what they are made of."""

    plan: Layout
    rules: tuple[RuleCode, ...]
    header: str
    source: str
    name: str
    monitors: tuple[Monitor, ...]
    #: The input contract, where the program is a whole Supervisor and not the rules alone.
    supervised: Supervised | None

    @property
    def series(self) -> int:
        return max((code.series for code in self.rules), default=0)


#: What was generated last, by the ids of all that it was made of, which is kept beside it so that nothing else gets them: programs are made one
#: after the other, one a run.
_MADE: dict[tuple[int, ...], tuple[tuple[object, ...], Source]] = {}
_KEPT = 4


def generated(spec: Spec, rules: Sequence[RuleInfo], doored: bool = False) -> Source:
    """As `generate`, once for the same spec, in whose maps is still what was in them."""
    maps = (spec.signals, spec.events, spec.params, spec.tables, spec.places)
    parts = (spec, *rules, *(part for one in maps for entry in one.items() for part in entry))
    key = (doored, len(rules), *map(id, parts))
    made = _MADE.pop(key, None) or (parts, generate(spec, rules, doored=doored))
    _MADE[key] = made  # the last one that was asked for is the last one to go
    for old in list(_MADE)[:-_KEPT]:
        _MADE.pop(old, None)
    return made[1]


def generate(
    spec: Spec,
    rules: Sequence[RuleInfo],
    name: str = "supervisor",
    online: bool = False,
    doored: bool = False,
) -> Source:
    """C for the chosen rules; raises TrackmarshalError E470 for a rule that has no C counterpart.

    online: with a monitor, a sample at a time, of every rule along a timeline that can have one. doored: the whole Supervisor around
    the rules; raises E482 for a spec that cannot be supervised with, E404 where there is no rule.
    """
    supervised: Supervised | None = None
    if doored:
        if not rules:
            raise TrackmarshalError(
                "E404", "a Supervisor has no rule", help="without a rule, anything would be safe"
            )
        plan, supervised = supervised_layout(spec, rules)
    else:
        plan = layout(spec, rules)
    groups = group_codes(plan)
    grouped = {rule.name for group in groups for rule in group.rules}
    codes = tuple(rule_code(plan, rule, rule.name in grouped) for rule in plan.rules)
    series = max((code.series for code in codes), default=0)
    found = tuple(monitors(plan)) if online else ()
    books = book_codes(spec, codes)
    text = _source(plan, codes, groups, name, found, supervised, books)
    head = header(plan, codes, series, name, found, supervised, declared(books))
    return Source(plan, codes, numbered(head, text, name), text, name, found, supervised)


def _source(
    plan: Layout,
    codes: Sequence[RuleCode],
    groups: Sequence[GroupCode],
    name: str,
    found: Sequence[Monitor],
    supervised: Supervised | None,
    books: Sequence[BookCode],
) -> str:
    """The text of the source file."""
    data = render("program/source/data.c.j2", _data(plan)).removesuffix("\n")
    types: list[str] = []
    memory = remembering(plan, supervised is not None)
    if supervised is None:
        tail = [*memory, _check(plan, codes, groups, data), *setters(plan)]
    else:
        door = Door(supervised, calls(plan, supervised.lines))
        types = list(machine.types(supervised, door.parts))
        tail = [
            data, *setters(plan, True), "", *door.functions, *memory, *judge(plan, supervised, codes, groups),
            *machine.functions(supervised), *configuration(plan, supervised),
        ]  # fmt: skip
    tail += defined(books)
    if books:
        types.append(RANKS)
    bodies = [
        *recalling(plan), *joining(plan), *(code.text for code in codes), *(group.text for group in groups), *(monitor.text for monitor in found)
    ]  # fmt: skip
    known = parts.functions()
    if any(isinstance(node, ir.Fold) for node in plan.nodes):
        types.append(FOLD)
    types += grids.types(plan)
    if not plan.remembers and counts_samples(plan.nodes):
        types.append(TALLY)
    several = [SEVERAL] if any("tm_several " in body for body in bodies) else []
    context = {
        "plan": plan, "name": name, "types": [*types, TRUTH, *several, *([] if found or plan.remembers else [CASES])],  # the header has it where it has what is made of them
        "functions": _functions([known[function] for function in parts.needed([*bodies, *tail])]), "bodies": bodies,
        "tail": "\n".join(tail),
    }  # fmt: skip
    # The source switches off one analysis of gcc: 12.2 at -O2 takes a series that was written anew for the one before, as what a function
    # writes is lost from its summary when constants are propagated into it. Seen by comparison with the reference; clang, -O1 and
    # the sanitizers agree with it.
    return render("program/source.c.j2", context)


def _functions(texts: Sequence[str]) -> list[str]:
    """Functions, those for several samples at once only where a target takes several."""
    found = list[str]()
    for several, some in groupby(texts, lambda text: "_several" in text or "TM_SEVERAL" in text):
        text = "\n".join(some)
        found.append(f"#if TM_SEVERAL > 1u\n{text}#endif\n" if several else text)
    return found


def _data(plan: Layout) -> dict[str, Any]:
    """The spec's own tables and places."""
    spec = plan.spec
    tables = []
    for table, c_name in plan.tables.items():
        info = spec.tables[table]
        numbers = {"knots": [literal(v) for v in info.knots], "numbers": [literal(v) for v in info.values]}
        tables.append({"name": c_name, "about": f"{comment(table)} {comment(str(info.span))}", **numbers})
    points = []
    for shape in own_places(plan):
        place = spec.places[shape.key[1]]
        flat = [literal(v) for point in place.points for v in point]
        about = f"{comment(place.name)} {comment(str(place.span))}"
        points.append({"name": shape.c_name, "about": about, "numbers": flat})
    return {"tables": tables, "points": points}


def _check(plan: Layout, codes: Sequence[RuleCode], groups: Sequence[GroupCode], data: str) -> str:
    """What rules alone have in place of a Supervisor: one check of all of them, and the start."""
    params = []
    for name, c_name in plan.params.items():
        param = plan.spec.params[name]
        about = f"{comment(name)} {comment(str(param.span))}"
        params.append({"name": c_name, "value": literal(param.value), "about": about})
    context = {
        "columns": [(i.c_name, i.signal is not None and i.signal.sequence) for i in plan.inputs.values() if i.kind == "columns"],
        "calls": list(rule_calls(plan, codes, groups)), "data": data, "params": params, "tables": _data(plan)["tables"],
        "shapes": list(initial(plan)), "over_run": plan.remembers,
    }  # fmt: skip
    return render("program/source/check.c.j2", context).removesuffix("\n")
