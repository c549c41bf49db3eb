"""The suggested mapping as Python: a function that makes a cycle of the Supervisor from a cycle of the planner."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trackmarshal.integration.mapped import HELPERS, Mapped
from trackmarshal.integration.mapping import Column


def adapter(made: Mapped, raws: list[Any], header: Any = None) -> str:
    """The text of a module with `cycle_of(number, cycle)`, and `borders(header)` where borders come before the cycles. raws, header: what was read."""
    lines = [
        '"""Made by `trackmarshal check-planner`: look it over, it is yours now."""',
        "",
        "import trackmarshal as tm",
        "",
        "",
    ]
    lines += _trajectory(made, raws)
    in_header = made.left is not None and made.left in made.header.lines
    if made.left is not None and made.right is not None and in_header:
        lines += [
            "def borders(header):",
            '    """The track, once: its lines are read and checked only when they change."""',
        ]
        lines += [
            f'    return {{"left": tm.line({_get("header", [header], made.left)}), "right": tm.line({_get("header", [header], made.right)})}}',
            "",
            "",
        ]
    if made.objects is None and made.no_objects is not None:
        lines += [
            "def others(found):",
            '    """No cycle that was looked at had another vehicle: its fields have to be written down first."""',
            "    if found:",
            '        raise NotImplementedError("say here what the fields of another vehicle are")',
            "    return []",
            "",
            "",
        ]
    lines += [
        "def cycle_of(number, cycle, track=None):",
        '    """A cycle of the Supervisor; `track`: both borders, made once with tm.line."""',
    ]
    stamp = (
        "0.1 * number  # TODO: stamp the cycle"
        if made.stamp is None
        else made.stamp.code(_get("cycle", raws, made.stamp.column))
    )
    lines.append(f"    stamp = {stamp}")
    stamped = ", stamp" if made.absolute else ""
    for name, path in (("driving", made.driving), ("emergency", made.emergency)):
        value = "None  # TODO" if path is None else f"trajectory({_get('cycle', raws, path)}{stamped})"
        lines.append(f"    {name} = {value}")
    if made.emergency is not None:
        lines.append("    emergency = tm.cut_at_rest(emergency)")
    lines.append("    signals = {")
    if made.ego is not None:
        source = _get("cycle", raws, made.ego) if made.ego else "cycle"
        lines.append(f'        "ego": {_record(made.ego_fields, source)},')
    if made.objects is not None:
        lines.append(f'        "objects": {_set(made, raws, made.objects, made.object_fields)},')
    elif made.no_objects is not None:
        lines.append(f'        "objects": others({_get("cycle", raws, made.no_objects)}),')
    elif "objects" in made.contract:
        lines.append('        "objects": None,  # TODO: other vehicles, also where there are none')
    if made.obstacles is not None:
        lines.append(f'        "obstacles": {_set(made, raws, made.obstacles, made.obstacle_fields)},')
    elif "obstacles" in made.contract:
        lines.append('        "obstacles": [],  # TODO: what stands on the road')
    if made.left is not None and made.right is not None and not in_header:
        left, right = (_get("cycle", raws, path) for path in (made.left, made.right))
        lines.append(f'        "track": track or {{"left": tm.line({left}), "right": tm.line({right})}},')
    elif "track" in made.contract:
        lines.append('        "track": track,')
    lines += ["    }", "    return tm.Cycle(number, stamp, driving, emergency, signals)"]
    return "\n".join(lines) + "\n"


def _trajectory(made: Mapped, raws: list[Any]) -> list[str]:
    shape, keys = _shape(made, raws)
    lines = [
        f"def trajectory(plan{', stamp' if made.absolute else ''}):",
        '    """Columns as the contract has them."""',
    ]
    if shape == "records":
        lines.append("    plan = {name: [row[name] for row in plan] for name in plan[0]}")
    elif shape == "rows":
        lines.append("    plan = {str(i): list(column) for i, column in enumerate(zip(*plan))}")
    lines.append("    columns = {")
    for name, column in made.plan.items():
        source = f"plan[{keys.get(column.column, column.column)!r}]"
        if name == "t" and made.absolute:
            lines.append(
                f'        "t": [{column.code("z")} - stamp for z in {source}],  # {column.words}, from the stamp on'
            )
            continue
        if name != "heading" and column.converted:
            source = f"[{column.code('z')} for z in {source}]"
            lines.append(f'        "{name}": {source},  # {column.words}')
        else:
            lines.append(f'        "{name}": {column.code(source)},')
    lines.append("    }")
    missing = [name for name in HELPERS if name in made.computed]
    value = f"tm.complete(columns)  # {', '.join(missing)}" if missing else "columns"
    # What is completed has all columns, and the contract may have fewer.
    further = sorted({*made.plan, *(HELPERS if missing else ())} - made.contract["plan"])
    if further:
        lines.append(f"    columns = {value}")
        value = (
            f"{{name: columns[name] for name in columns if name not in {further}}}  # nothing declares these"
        )
    lines.append(f"    return {value}")
    return [*lines, "", ""]


def _record(fields: Mapping[str, Column], source: str) -> str:
    return "{" + ", ".join(f'"{n}": {c.code(f"{source}[{c.column!r}]")}' for n, c in fields.items()) + "}"


def _set(made: Mapped, raws: list[Any], path: str, fields: Mapping[str, Column]) -> str:
    source = _get("cycle", raws, path)
    if path in made.keyed:
        source = f'[{{"id": name, **one}} for name, one in {source}.items()]'
    return f"[{_record(fields, 'one')} for one in {source}]"


def _shape(made: Mapped, raws: list[Any]) -> tuple[str, Mapping[str, Any]]:
    """How the driving trajectory is written down, and its keys by the names of its columns, in the first cycle that has one."""
    columns = {column.column for column in made.plan.values()}
    for raw in raws:
        value, keys = raw, _keys(raw, made.driving or "")
        for key in keys or ():
            value = value[key]
        listed = value.tolist() if hasattr(value, "tolist") else value
        first = listed[0] if isinstance(listed, list | tuple) and listed else listed
        if isinstance(first, Mapping):
            named = {str(key): key for key in first}
            if keys is not None and columns <= named.keys():
                return "columns" if first is listed else "records", named
        elif first is not listed:
            return "rows", {}
    return "columns", {}


def _keys(value: Any, path: str) -> list[Any] | None:
    """The keys along a path, which may have dots in them, or be no texts; None where it leads nowhere."""
    if not path:
        return []
    for key in value if isinstance(value, Mapping) else ():
        name = str(key)
        if path == name:
            return [key]
        further = _keys(value[key], path[len(name) + 1 :]) if path.startswith(f"{name}.") else None
        if further is not None:
            return [key, *further]
    return None


def _get(source: str, raws: list[Any], path: str) -> str:
    """What stands at a path, in a program, by the keys that lead there in one of these."""
    found = next((keys for raw in raws if (keys := _keys(raw, path)) is not None), path.split("."))
    return source + "".join(f"[{key!r}]" for key in found)
