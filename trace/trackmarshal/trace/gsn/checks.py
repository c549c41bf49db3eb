"""Whether an argument is well formed, after the GSN Community Standard, version 3; everything that is not so is a finding."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from trackmarshal.trace import cycles
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.gsn.case import UNSUPPORTED, Case, Element, Link, a_kind
from trackmarshal.trace.gsn.kinds import BESIDE, COUNTER, KINDS, OPEN
from trackmarshal.trace.gsn.statuses import defeated, way_down
from trackmarshal.trace.matrix import Matrix

#: What may support what.
SUPPORTS = {
    "goal": frozenset({"goal", "strategy", "solution"}),
    "strategy": frozenset({"goal", "solution"}),
    "counter goal": frozenset({"counter goal", "counter solution"}),
}
#: So many names are listed in a finding.
LISTED = 4
_HOLE = re.compile(r"\{[A-Za-z_][A-Za-z0-9_ -]*\}")


def check(case: Case, whole: bool = True) -> Iterator[Finding]:
    """All rules, over all modules (T401 to T419, T422). `whole`: nothing was left out for faults of templates, so that what is missing is so. Raises ValueError for a kind of elements or of links that there is not."""
    for element in case.elements.values():
        if element.kind not in KINDS:
            raise ValueError(f"unknown kind of elements {element.kind!r}")
    for rule in _RULES:
        yield from rule(case)
    if whole:
        yield from _verdict(case)


def of_requirements(case: Case, matrix: Matrix) -> Iterator[Finding]:
    """Requirements that are demanded, and that no element is about (T421)."""
    about = {e.about for e in case.elements.values()}
    missed = [row.requirement for row in matrix.rows if ("requirement", str(row.requirement.id)) not in about]
    if missed:
        named = ", ".join(f"`{r.id}`" for r in missed[:LISTED])
        more = f" and {len(missed) - LISTED} more" if len(missed) > LISTED else ""
        help_ = "let a step of the argument lead there, or link it to what is argued for"
        yield error("T421", f"the argument says nothing about {named}{more}", missed[0].place, help_, missed[0].id)  # fmt: skip


def folded(found: Iterable[Finding]) -> list[Finding]:
    """Findings of one code at one place as one: a template makes many elements, and each of them has its fault."""
    by_cause: dict[tuple[str, Place | None], list[Finding]] = {}
    for finding in found:
        by_cause.setdefault((finding.code, finding.place), []).append(finding)
    return [
        first if not more else replace(first, message=f"{first.message} (and {len(more)} more like it)")
        for first, *more in by_cause.values()
    ]


def _tops(case: Case) -> Iterator[Finding]:
    tops = case.tops
    goals = [e for e in tops if e.kind == "goal"]
    if not goals and case.elements:
        yield error("T401", "the argument has no top goal", _any(case), "one goal supports nothing, and all else leads up to it")  # fmt: skip
    for other in goals[1:]:
        message = f"`{other.id}` supports nothing, and `{goals[0].id}` is the top goal already"
        yield _at("T401", message, other, "let it support something")


def _reached(case: Case) -> Iterator[Finding]:
    goals = [e for e in case.tops if e.kind == "goal"]
    todo = [goals[0].id] if goals else []
    seen = set(todo)
    while todo:
        at = todo.pop()
        near = [link.target for link in case.out.get(at, ()) if link.kind != "challenges"]
        near += [link.source for link in case.into.get(at, ()) if link.kind == "challenges"]
        for other in near:
            if other not in seen:
                seen.add(other)
                todo.append(other)
    for element in case.elements.values():
        lost = element.id not in seen and element not in goals[1:]
        if (
            goals and lost and element.kind not in COUNTER
        ):  # of a defeater it is said that it challenges nothing
            yield _at("T402", f"{_called(element)} is not reached from the top goal", element, "link it, or strike it")  # fmt: skip


def _circles(case: Case) -> Iterator[Finding]:
    below = {id_: case.targets(id_, "supported_by") for id_ in case.elements}
    for cycle in cycles.cycles(below):
        message = f"elements support each other in a circle: {cycles.shown(cycle)}"
        yield _at(
            "T403", message, case.elements[cycle[0]], "a claim cannot rest on itself, however far around"
        )


def _links(case: Case) -> Iterator[Finding]:
    """Ends of links: there (T410), not the same (T417), of kinds that go together (T404, T405, T408, T412, T422)."""
    seen: set[tuple[str, str, str]] = set()
    for link in case.links:
        source, target = case.elements.get(link.source), case.elements.get(link.target)
        if source is None or target is None:
            lost = link.source if source is None else link.target
            code = "T411" if link.cited else "T412" if link.kind == "challenges" else "T410"
            here = link.target if source is None else link.source
            in_module = f", in the module `{link.cited}`" if link.cited else ""
            yield error(code, f"`{here}` is linked to `{lost}`{in_module}, and there is no such element", link.place, did_you_mean(lost, case.elements))  # fmt: skip
            continue
        key = (link.kind, link.source, link.target)
        if key in seen or link.source == link.target:
            what = "to itself" if link.source == link.target else f"to `{link.target}` twice"
            yield error("T417", f"`{link.source}` is linked {what}", link.place, "strike the link")
        seen.add(key)
        yield from _ends(link, source, target)


def _ends(link: Link, source: Element, target: Element) -> Iterator[Finding]:
    said = f"{_called(source)} {link.kind.replace('_', ' ')} {_called(target)}"
    match link.kind:
        case "supported_by":
            if source.kind in ("solution", "counter solution"):
                help_ = "what needs support is a goal"
                yield error("T408", f"{_called(source)} is supported by {_called(target)}", link.place, help_)
            elif target.kind not in SUPPORTS.get(source.kind, ()):
                allowed = ", ".join(sorted(SUPPORTS.get(source.kind, ()))) or "nothing"
                code = "T422" if target.kind in COUNTER else "T404"
                yield error(code, f"{_called(source)} is supported by {_called(target)}", link.place, f"{a_kind(source.kind)} may be supported by {allowed}")  # fmt: skip
        case "in_context_of":
            if source.kind not in ("goal", "strategy") or target.kind not in BESIDE:
                message = f"{_called(target)} stands in the context of {_called(source)}"
                yield error("T405", message, link.place, "contexts, assumptions and justifications stand beside goals and strategies")  # fmt: skip
        case "challenges":
            if source.kind not in COUNTER:
                yield error("T422", said, link.place, "counter goals and counter solutions do")
            elif target.kind in COUNTER:
                yield error(
                    "T412", said, link.place, "a defeater challenges an element of the argument itself"
                )
        case other:
            raise ValueError(f"unknown kind of links {other!r}")


def _leaves(case: Case) -> Iterator[Finding]:
    for e in case.elements.values():
        held = case.targets(e.id, "supported_by")
        if e.kind in ("goal", "strategy") and not held and not e.undeveloped:
            yield _at("T406", f"nothing supports {_called(e)}, and it is not marked as undeveloped", e, "support it, or mark it")  # fmt: skip
        if e.undeveloped and held:
            yield _at("T407", f"{_called(e)} is marked as undeveloped, and `{held[0]}` supports it", e, "strike one of the two")  # fmt: skip
        if e.kind == "solution":
            if not e.evidence:
                yield _at("T409", f"{_called(e)} leads to no evidence", e, "let it be about evidence")
            for one in [one for one in e.evidence if not one.sha256][:1]:
                message = f"{_called(e)} leads to the {one.kind} `{one.name}`, of which no hash is known"
                yield _at("T409", message, e, "what is evidence is there, and does not change unnoticed")


def _away(case: Case) -> Iterator[Finding]:
    """Goals of other modules: public, and where they are said to be."""
    names = {module.name for module in case.modules}
    for link in case.links:
        source, target = case.elements.get(link.source), case.elements.get(link.target)
        if source is None or target is None:
            continue
        if link.cited and link.cited not in names:
            yield error("T411", f"`{link.source}` cites the module `{link.cited}`, and there is none of this name", link.place, did_you_mean(link.cited, names))  # fmt: skip
        elif link.cited and target.module != link.cited:
            message = f"`{link.source}` cites `{link.target}` in the module `{link.cited}`, and it is in `{target.module}`"
            yield error("T411", message, link.place, f"name the module `{target.module}`")
        elif link.cited and not target.public:
            message = f"`{link.source}` cites `{link.target}`, which is no public goal"
            yield error("T411", message, link.place, "cite a goal at which a module begins")
        elif source.module != target.module and link.kind == "supported_by":
            if target.kind == "goal" and not target.public:
                yield error("T411", f"`{link.source}` relies on `{link.target}` of another module, which is not public", link.place)  # fmt: skip
            if target.kind == "strategy":
                message = (
                    f"`{link.source}` relies on the strategy `{link.target}` of the module `{target.module}`"
                )
                yield error("T411", message, link.place, "a strategy cannot be cited: cite the goal above it")


def _defeaters(case: Case) -> Iterator[Finding]:
    for e in case.elements.values():
        if e.kind in COUNTER and e.state == OPEN:
            against = case.targets(e.id, "challenges")
            if against:
                message = f"{_called(e)} against `{against[0]}` is open: {e.text}"
                yield _at("T413", message, e, "mend what it names, answer it, or uphold it")
        if e.kind not in COUNTER and defeated(case, e.id):
            for link in case.into.get(e.id, ()):
                if link.kind != "challenges":
                    what = "supports" if link.kind == "supported_by" else "stands beside"
                    message = f"{_called(e)} is defeated, and {what} `{link.source}`"
                    yield _at("T414", message, e, "argue it anew, or take it out")


def _filled(case: Case) -> Iterator[Finding]:
    for e in case.elements.values():
        hole = _HOLE.search(e.text) or _HOLE.search(e.id)
        if hole:
            message = f"{_called(e)} is not filled in: what `{hole[0]}` stands for is not said"
            yield _at("T415", message, e, "say it where the element comes from, or change the template")


def _points(case: Case) -> Iterator[Finding]:
    seen: set[str] = set()
    for point in case.points:
        where = f"`{point.at}`" + (f" to `{point.to}`" if point.to else "")
        lost = next((i for i in (point.at, point.to) if i and i not in case.elements), "")
        if lost:
            yield error("T418", f"the confidence point `{point.id}` is at {where}, and there is no `{lost}`", point.place, did_you_mean(lost, case.elements), point.id)  # fmt: skip
        elif point.to and not any(point.to == link.target for link in case.out.get(point.at, ())):
            yield error("T418", f"the confidence point `{point.id}` is at the link from {where}, and there is none", point.place, "", point.id)  # fmt: skip
        if point.id in seen:
            yield error("T416", f"`{point.id}` is the id of two confidence points", point.place, "give it another id", point.id)  # fmt: skip
        seen.add(point.id)


def _verdict(case: Case) -> Iterator[Finding]:
    goals = [e for e in case.tops if e.kind == "goal"]
    if goals and goals[0].status == UNSUPPORTED:
        path = way_down(case, goals[0].id)
        end = case.elements[path[-1]]
        message = f"the top goal is not supported: {_path(path)}: {end.text}"
        yield _at(
            "T419", message, end, "mend what is named there; a gap that is bearable for a while can be waived"
        )


_RULES: tuple[Callable[[Case], Iterator[Finding]], ...] = (
    _tops, _reached, _circles, _links, _leaves, _away, _defeaters, _filled, _points,
)  # fmt: skip


def _path(path: list[str]) -> str:
    """The way down, its middle left out where it is long."""
    return " <- ".join(path if len(path) < 7 else [*path[:3], "...", *path[-3:]])


def _called(element: Element) -> str:
    return f"the {element.kind} `{element.id}`"


def _any(case: Case) -> Place | None:
    return next((e.origin for e in case.elements.values()), None)


def _at(code: str, message: str, element: Element, help_: str = "") -> Finding:
    """A finding where the thing stands that the element is about, or else where its template does; the template is named beside it."""
    place = element.place or element.origin
    also = ((element.origin, "made by this template"),) if element.origin and element.origin != place else ()
    return Finding(code, "error", message, place, help_, element.id, also)


__all__ = ["SUPPORTS", "check", "folded", "of_requirements"]
