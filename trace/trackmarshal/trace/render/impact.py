"""The impact of an edit: for a terminal, as JSON, and as a comment for a merge request."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any, NamedTuple

from trackmarshal.trace.graph.graph import Key
from trackmarshal.trace.graph.said import called
from trackmarshal.trace.impact import Changed, Impact, Task
from trackmarshal.trace.impact.again import DOING
from trackmarshal.trace.render.table import escaped
from trackmarshal.trace.render.words import printable

FORMATS = ("text", "json", "md")
#: Of alike tasks, so many are named one by one, but for JSON, which has all.
NAMED = 3


class Between(NamedTuple):
    """What was compared: the revision as it was named, its commit, the commit that is here (`+` behind it: with changes), the project."""

    revision: str
    commit: str
    now: str
    project: str


def render(impact: Impact, between: Between, format: str) -> str:
    """The impact in one of FORMATS; raises ValueError for another."""
    match format:
        case "text":
            return "\n".join(map(printable, _text(impact, between))) + "\n"
        case "json":
            return json.dumps(_data(impact, between), ensure_ascii=False, allow_nan=False, indent=1) + "\n"
        case "md":
            return "\n".join(_markdown(impact, between)) + "\n"
        case _:
            raise ValueError(f"unknown format {format!r}, known are {', '.join(FORMATS)}")


def _text(impact: Impact, between: Between) -> list[str]:
    lines = [f"impact on {between.project}: {_versions(between)}", _sum(impact)]
    if impact.dark:
        lines += [
            "",
            _DARK.format(between.revision),
            *(f"  {line}" for line in "\n".join(impact.dark).split("\n")),
        ]
    if not impact.engines[0]:
        lines += ["", _ENGINE.format(between.revision)]
    if impact.changed:
        lines += ["", "changed:", *(f"  {_what(one)}" for one in impact.changed)]
    if impact.tasks:
        lines += ["", "again, in this order:"]
        groups = _groups(impact.tasks)
        width = len(str(len(groups)))
        lines += [
            f"  {number:>{width}}. {_said(group)}: {_why(group)}" for number, group in enumerate(groups, 1)
        ]
    if impact.reviews:
        lines += ["", f"reviews that fall: {', '.join(task.key[1] for task in impact.reviews)}"]
    if impact.requirements:
        lines += ["", f"requirements above: {', '.join(impact.requirements)}"]
    return lines


def _markdown(impact: Impact, between: Between) -> list[str]:
    lines = [
        f"### Impact on {escaped(between.project)}",
        "",
        f"{escaped(_versions(between))}. {escaped(_sum(impact))}",
    ]
    if impact.dark:
        lines += ["", escaped(_DARK.format(between.revision), code=True), ""]
        lines += [f"- {escaped(line)}" for line in impact.dark]
    if not impact.engines[0]:
        lines += ["", escaped(_ENGINE.format(between.revision), code=True)]
    if impact.changed:
        lines += ["", "| changed | | |", "|---|---|---|"]
        lines += [
            f"| {escaped(_name(one.key), code=True)} | {one.how} | {escaped('; '.join(one.what), code=True)} |"
            for one in impact.changed
        ]
    if impact.tasks:
        lines += [
            "",
            "<details open><summary>Again, in this order</summary>",
            "",
            "| | what | why |",
            "|---|---|---|",
        ]
        lines += [
            f"| {number} | {escaped(_said(group), code=True)} | {escaped(_why(group), code=True)} |"
            for number, group in enumerate(_groups(impact.tasks), 1)
        ]
        lines += ["", "</details>"]
    if impact.reviews:
        lines += ["", f"Reviews that fall: {escaped(', '.join(task.key[1] for task in impact.reviews))}"]
    if impact.requirements:
        lines += ["", f"Requirements above: {escaped(', '.join(impact.requirements))}"]
    return lines


def _data(impact: Impact, between: Between) -> dict[str, Any]:
    return {
        "format": "trackmarshal-impact", "version": 1, "project": between.project, "revision": between.revision, "commit": between.commit,
        "now": between.now, "unknown": list(impact.dark),
        "engine": {"before": impact.engines[0] or None, "now": impact.engines[1]},
        "changed": [{**_key(one.key), "how": one.how, "what": list(one.what), "weaker": one.weaker} for one in impact.changed],
        "again": [
            {"place": place, **_key(task.key), "do": task.do, "why": task.why, "made": task.made}
            for place, task in enumerate(impact.tasks, 1)
        ],
        "reviews": [task.key[1] for task in impact.reviews],
        "requirements": list(impact.requirements),
    }  # fmt: skip


_MANY = {"analysis": "analyses", "code": "source files"}
_DARK = "`{}` does not say all that it is to say, so everything that rests on its specs counts as changed:"


_ENGINE = "which engine made the evidence of `{}` is not known, so it is taken for the one that runs"


def _versions(between: Between) -> str:
    here = between.now.removesuffix("+")
    now = f"{here[:12]}{' with changes that are not committed' if between.now.endswith('+') else ''}"
    return f"{between.revision} ({between.commit[:12]}) to what is here ({now})"


def _sum(impact: Impact) -> str:
    if not (impact.changed or impact.tasks):
        return "nothing means something else than there"
    kinds: dict[str, int] = {}
    for task in impact.tasks:
        kinds[task.key[0]] = kinds.get(task.key[0], 0) + 1
    again = ", ".join(_number(count, kind) for kind, count in kinds.items()) or "nothing"
    made = sum(task.made for task in impact.tasks)
    there = f"; of {made} of them what there is now has a result" if made else ""
    return f"{_number(len(impact.changed), 'change')}; again: {again}{there}"


def _number(count: int, what: str) -> str:
    return f"{count} {what if count == 1 else _MANY.get(what, what + 's')}"


def _groups(tasks: Sequence[Task]) -> list[list[Task]]:
    """Tasks that follow each other and are of one kind, of one rule or campaign, for one reason."""

    def alike(task: Task) -> tuple[object, ...]:
        kind, id_ = task.key
        of = id_.partition(": ")[0] if kind == "test" else id_.partition(" ")[0] if kind == "fault" else ""
        return kind, of, task.do, task.why, task.made

    return [list(group) for _, group in groupby(tasks, alike)]


def _said(group: Sequence[Task]) -> str:
    first = group[0]
    kind, id_ = first.key
    doing = DOING[first.do]
    if len(group) == 1:
        return f"{doing} {_name(first.key)}"
    if kind == "test":
        rule = id_.partition(": ")[0]
        return f"{doing} {len(group)} tests of `{rule}`"
    named = ", ".join(f"`{task.key[1]}`" for task in group[:NAMED])
    more = f" and {len(group) - NAMED} more" if len(group) > NAMED else ""
    return f"{doing} {_number(len(group), kind)}: {named}{more}"


def _why(group: Iterable[Task]) -> str:
    first = next(iter(group))
    return f"{first.why}{' (there is a result of what there is now)' if first.made else ''}"


def _what(one: Changed) -> str:
    return f"{_name(one.key)}: {'; '.join(one.what) or one.how}"


def _name(key: Key) -> str:
    kind, id_ = key
    return called(key).removeprefix("the ") if id_ else f"{kind}'s settings"


def _key(key: Key) -> dict[str, str]:
    return {"kind": key[0], "id": key[1]}


__all__ = ["FORMATS", "Between", "render"]
