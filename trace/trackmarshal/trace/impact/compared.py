"""The impact of an edit: two versions of a project held against each other."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

from trackmarshal.trace.baseline import Baseline
from trackmarshal.trace.graph.graph import Key
from trackmarshal.trace.impact.again import Task, tasks
from trackmarshal.trace.impact.changed import Changed, changed
from trackmarshal.trace.impact.resting import order, rests_on
from trackmarshal.trace.impact.version import Version

#: Kinds of what shows something about requirements, which is in doubt until it is made again. Others only have to be looked at.
_SHOWING = frozenset({"rule", "assumption", "test", "run", "fault", "external test"})
#: Stands for all rules and monitors, on which every fault rests.
_RULES: Key = ("rules", "")


@dataclass(frozen=True, slots=True)
class Impact:
    """What changed; what has to be done again, first what others rest on; and the requirements that this reaches.

    dark: why what the other version says is not all known, so that what rests on its specs counts as changed; empty where it is.
    """

    changed: tuple[Changed, ...]
    tasks: tuple[Task, ...]
    requirements: tuple[str, ...]
    dark: tuple[str, ...] = ()
    #: Which made the evidence of the other version (empty: not known), and which makes it now.
    engines: tuple[str, str] = ("", "")

    @property
    def reviews(self) -> tuple[Task, ...]:
        """The reviews that fall."""
        return tuple(task for task in self.tasks if task.do == "review")


def compared(before: Version, now: Version, baseline: Baseline | None = None) -> Impact:
    """What became of a project between two versions; `baseline` is the one that holds now."""
    found = [*_engine(before, now), *changed(before, now)]
    hit = {one.key for one in found if one.how != "gone"}
    # What is gone is in the graph of then alone; a scenario took its run with it.
    gone = {one.key for one in found if one.how == "gone"}
    gone |= {("run", id_) for kind, id_ in gone if kind == "scenario"}
    todo = list(tasks(before, now, hit, baseline))
    doubted = hit.union(task.key for task in todo if task.key[0] in _SHOWING)
    places = order(_below(now, todo))
    todo.sort(key=lambda task: places[task.key])
    return Impact(
        tuple(found),
        tuple(todo),
        tuple(sorted(_reached(now, doubted) | (_reached(before, gone) & _demanded(now)))),
        tuple(map(str, before.wrong)),
        (before.spec.engine, now.spec.engine),
    )


def _engine(before: Version, now: Version) -> Iterator[Changed]:
    """That results are made by another engine, on which all of them rest. Whether it shows less, nobody knows."""
    old, new = before.engine(now), now.spec.engine
    if old != new:
        yield Changed(
            ("engine", new.partition(" ")[0]), "changed", (f"it was {_of(old)}, and is {_of(new)}",), True
        )


def _of(engine: str) -> str:
    """Its version, and the hash of its sources."""
    return engine.partition(" ")[2] or engine


def _below(now: Version, todo: Iterable[Task]) -> dict[Key, set[Key]]:
    """By node what it rests on: by its links, by what its result is made from, and the baseline on all."""
    graph = now.graph
    below: dict[Key, set[Key]] = {key: set(rests_on(graph, key)) for key in graph.nodes}
    rules = {
        name: ("rule" if item.kind == "rule" else "assumption", name)
        for name, item in now.spec.by_name.items()
    }
    below[_RULES] = set(rules.values())
    for path, inputs in now.spec.run_inputs.items():
        named = (name.removeprefix("rule ") for name in inputs if name.startswith("rule "))
        below.setdefault(("run", path), set()).update(
            {("scenario", path), *(rules[name] for name in named if name in rules)}
        )
    for case in now.spec.faults:
        below.setdefault(("fault", f"{case.campaign} {case.id}"), set()).add(_RULES)
    for task in todo:
        if task.do == "accept":
            below[task.key] = {other.key for other in todo if other is not task}
        else:
            below.setdefault(task.key, set())
    return below


def _reached(version: Version, keys: Collection[Key]) -> set[str]:
    """The demanded requirements at or above any of these, of runs by the rules that they are made with, whether they were made yet or not."""
    graph = version.graph
    asked = {
        name.removeprefix("rule ")
        for kind, path in keys
        if kind == "run"
        for name in version.spec.run_inputs.get(path, ())
        if name.startswith("rule ")
    }
    found = {*keys, *((kind, name) for name in asked for kind in ("rule", "assumption"))}
    reached = graph.reaching([key for key in found if key in graph.nodes], down=True)
    return {id_ for kind, id_ in reached if kind == "requirement"} & _demanded(version)


def _demanded(version: Version) -> set[str]:
    return {id_ for id_, requirement in version.project.by_id.items() if requirement.demanded}
