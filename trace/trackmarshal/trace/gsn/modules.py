"""The argument in modules, each small enough for one picture: cut at goals, which are cited from elsewhere as away goals."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from trackmarshal.trace.gsn.case import Case, Element, Link, Module
from trackmarshal.trace.gsn.grouping import free, grouped
from trackmarshal.trace.gsn.statuses import below_first

#: The most elements in a picture, away ones counted.
LIMIT = 25
#: The widest and deepest that a picture may be, in elements side by side and one under another, where it can be cut: one of these, so that it
#: can be read on A4, lying or standing.
PAGES = ((7.0, 6), (4.5, 10))
#: With more elements than this below one, they stand in two rows.
ONE_ROW = 4


def in_modules(case: Case, groups: str, beginnings: Iterable[str]) -> Case:
    """The argument with its modules, always the same for the same argument.

    groups: as `grouping.grouped` takes it. beginnings: goals at which modules begin, where all below an element does not fit into one
    picture; those that stand for groups do so too.
    """
    tops = case.tops or list(case.elements.values())  # all of it in circles: the first that was made
    if not tops:
        return case
    top = next((e for e in tops if e.kind == "goal"), tops[0])
    whole = grouped(case, groups)
    added = whole.elements.keys() - case.elements.keys()
    cutting = _Cutting(whole, frozenset(beginnings) | added)
    cuts = cutting.cuts(top.id)
    return _assigned(cutting.case(), [top.id, *cuts])


class _Cutting:
    """Where to cut, found from the leaves up: what is below an element is cut as soon as it does not fit with it."""

    def __init__(self, case: Case, beginnings: frozenset[str]) -> None:
        self._case = case
        self._beginnings = beginnings
        self._elements = dict(case.elements)
        self._supports = {
            id_: [link for link in case.out.get(id_, ()) if link.kind == "supported_by" and link.target in case.elements]
            for id_ in case.elements
        }  # fmt: skip
        self._cut: set[str] = set()
        self._size: dict[str, int] = {}
        self._width: dict[str, float] = {}
        self._depth: dict[str, int] = {}

    def cuts(self, top: str) -> list[str]:
        """The goals at which modules begin, beside the top goal, in the order of the argument from the top."""
        above: dict[str, set[str]] = {}
        for id_, links in self._supports.items():
            for link in links:
                if link.cited:
                    continue  # it is to be public where it is: being cited does not make it so
                above.setdefault(link.target, set()).add(id_)
        shared = {id_ for id_, over in above.items() if len(over) > 1}
        self._cut = {id_ for id_ in shared if self._elements[id_].kind == "goal" and id_ != top}
        for id_ in below_first(self._case):
            self._measure(id_)
            if not self._fits(id_):
                self._cut |= self._next_beginnings(id_)
                self._again(id_)
            while not self._fits(id_) and self._one_more(id_):
                self._again(id_)
        return [id_ for id_ in _from(top, self._supports) if id_ in self._cut]

    def case(self) -> Case:
        """The argument, with the goals that had to be put between."""
        elements = self._case.elements  # links to nothing stay as they are, for the checks
        links = [k for k in self._case.links if k.kind != "supported_by" or k.source not in elements or k.target not in elements]  # fmt: skip
        own = [link for links in self._supports.values() for link in links]
        return replace(self._case, elements=self._elements, links=(*links, *own))

    def _fits(self, id_: str) -> bool:
        wide, deep = self._width[id_], self._depth[id_]
        return self._size[id_] <= LIMIT and any(wide <= w and deep <= d for w, d in PAGES)

    def _below(self, id_: str) -> list[str]:
        return [link.target for link in self._supports[id_] if not link.cited]

    def _measure(self, id_: str) -> None:
        """How many elements there are in the picture from here down, how many side by side, and how many one under another."""
        beside = self._case.targets(id_, "in_context_of")
        against = [link.source for link in self._case.into.get(id_, ()) if link.kind == "challenges"]
        below = [(1, 1.0, 1) if b in self._cut or b not in self._size else (self._size[b], self._width[b], self._depth[b]) for b in self._below(id_)]  # fmt: skip
        below += [(1, 1.0, 1) for link in self._supports[id_] if link.cited]
        here = 1 + len(beside) + len(against)
        rows = [below] if len(below) <= ONE_ROW else [below[::2], below[1::2]]
        self._size[id_] = here + sum(size for size, _, _ in below)
        self._width[id_] = max(float(here), *(sum(wide for _, wide, _ in row) + 0.5 * (len(rows) - 1) for row in rows))  # fmt: skip
        self._depth[id_] = 1 + sum(max((deep for _, _, deep in row), default=0) for row in rows)

    def _local(self, id_: str) -> list[str]:
        """What is below an element in the same picture, from the top down."""
        found: dict[str, None] = {}
        todo = [b for b in self._below(id_) if b not in self._cut]
        while todo:
            at = todo.pop(0)
            if at not in found and at != id_:
                found[at] = None
                todo += [b for b in self._below(at) if b not in self._cut]
        return list(found)

    def _next_beginnings(self, id_: str) -> set[str]:
        """The nearest goals below an element at which a module may begin, each on its way down."""
        found: set[str] = set()
        seen: set[str] = set()
        todo = self._below(id_)
        while todo:
            at = todo.pop(0)
            if at in seen or at in self._cut or at == id_:
                continue
            seen.add(at)
            if at in self._beginnings and self._elements[at].kind == "goal":
                found.add(at)
            else:
                todo += self._below(at)
        return found

    def _again(self, id_: str) -> None:
        for below in reversed(self._local(id_)):
            self._measure(below)
        self._measure(id_)

    def _one_more(self, id_: str) -> bool:
        """Cut at the goal that takes most out of the picture, of those that are next below; or put a goal over a strategy, and cut there."""
        goals: dict[str, None] = {}
        todo = self._below(id_)
        while todo:
            at = todo.pop(0)
            if at in self._cut or at == id_ or at in goals:
                continue
            if self._elements[at].kind == "goal":
                goals[at] = None
            else:
                todo += self._below(at)
        large = [goal for goal in goals if self._size.get(goal, 1) > 1]
        if large:
            self._cut.add(max(large, key=lambda goal: self._size[goal]))
            return True
        if self._size[id_] <= LIMIT:
            return False  # wide or deep, and nothing to be done about it
        # Over one that stands alone, another goal would take nothing out.
        strategies = [
            link for link in self._supports[id_]
            if self._elements[link.target].kind == "strategy" and self._size[id_] > 1 + self._size.get(link.target, 1)
        ]  # fmt: skip
        if not strategies:
            return False
        self._put_between(id_, max(strategies, key=lambda link: self._size.get(link.target, 1)))
        return True

    def _put_between(self, id_: str, link: Link) -> None:
        """A goal over a strategy, at which a module begins: a strategy cannot be cited from elsewhere."""
        at = self._elements[link.target]
        goal = Element(free(self._elements, at.id), "goal", f"What is argued for by this is met: {at.text}", at.place, at.origin)  # fmt: skip
        self._elements[goal.id] = goal
        self._supports[goal.id] = [link._replace(source=goal.id)]
        own = self._supports[id_]
        own[own.index(link)] = link._replace(target=goal.id)
        self._cut.add(goal.id)
        self._measure(goal.id)
        while not self._fits(goal.id) and self._one_more(goal.id):  # it is one element more than the strategy
            self._again(goal.id)


def _from(top: str, supports: dict[str, list[Link]]) -> Iterator[str]:
    """All elements below one, each once, nearer ones first."""
    seen = {top: None}
    todo = [top]
    for at in todo:  # grows while it is read
        for link in supports[at]:
            if link.target not in seen:
                seen[link.target] = None
                todo.append(link.target)
    return iter(seen)


def _assigned(case: Case, roots: Sequence[str]) -> Case:
    """Each element in the module of the first root that leads to it; what no root leads to, in modules beside."""
    home: dict[str, str] = {}
    begins = set(roots)
    for root in roots:
        todo = [root]
        while todo:
            at = todo.pop()
            if at in home or at not in case.elements:
                continue
            home[at] = root
            todo += [link.target for link in case.out.get(at, ()) if link.kind != "challenges" and link.target not in begins and not link.cited]  # fmt: skip
            todo += [link.source for link in case.into.get(at, ()) if link.kind == "challenges"]
    modules = [Module(root, root, case.elements[root].text) for root in roots]
    beside = [id_ for id_ in case.elements if id_ not in home]
    for start in range(0, len(beside), LIMIT):
        part = beside[start : start + LIMIT]
        modules.append(Module(f"Beside-{part[0]}", part[0], "What the top goal does not reach."))
        home.update(dict.fromkeys(part, modules[-1].name))
    elements = {
        id_: e._replace(module=home[id_], public=id_ in begins and id_ != roots[0]) for id_, e in case.elements.items()
    }  # fmt: skip
    return replace(case, elements=elements, modules=tuple(modules))


__all__ = ["LIMIT", "ONE_ROW", "in_modules"]
