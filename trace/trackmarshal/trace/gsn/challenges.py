"""What people say against an argument, and where they have confidence in it: entries of the document, put into the argument."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from trackmarshal.trace.findings import Finding, did_you_mean, error
from trackmarshal.trace.gsn.case import Case, Element, Link, Point
from trackmarshal.trace.gsn.document import Argument, Defeater
from trackmarshal.trace.gsn.filling import safe
from trackmarshal.trace.gsn.kinds import ANSWERED


def with_challenges(case: Case, argument: Argument, persons: Collection[str] = ()) -> Case:
    """The argument with the defeaters and the confidence points of the document; what is wrong with them is among the findings (T153, T412, T416, T423).

    persons: ids and names of those that the project declares; where there are any, each owner is one of them.
    """
    elements, links = dict(case.elements), list(case.links)
    found: list[Finding] = list(case.findings)
    raised: list[tuple[str, Defeater]] = []
    for defeater in argument.defeaters:
        prefix = "CSn" if defeater.evidence else "CG"
        id_ = safe(f"{prefix}-{defeater.id}")
        if id_ in elements:
            found.append(error("T416", f"`{id_}` is the id of two elements of the argument", defeater.id.place, "give the defeater another id"))  # fmt: skip
            continue
        elements[id_] = _counter(id_, defeater)
        found += _of_answer(defeater)
        if persons and defeater.owner and defeater.owner not in persons:
            message = f"the defeater `{defeater.id}` belongs to `{defeater.owner}`, who is none of the persons of the project"
            help_ = did_you_mean(defeater.owner, persons) or "name a person by id or by name"
            found.append(error("T153", message, defeater.id.place, help_, defeater.id))
        raised.append((id_, defeater))
    with_them = replace(case, elements=elements)
    for id_, defeater in raised:
        targets = named(with_them, defeater.challenges)
        links += [Link("challenges", id_, target, defeater.challenges.place) for target in targets[:1]]
        if not targets:
            help_ = did_you_mean(defeater.challenges, _names(case)) or "name an element of the argument, or what one is about"  # fmt: skip
            message = f"the defeater `{defeater.id}` challenges `{defeater.challenges}`, which the argument does not have"
            found.append(error("T412", message, defeater.challenges.place, help_, defeater.id))
    points = tuple(Point(str(i), str(at), str(to), text, i.place) for i, at, to, text in argument.confidence)
    return replace(case, elements=elements, links=tuple(links), points=points, findings=tuple(found))


def named(case: Case, word: str) -> Sequence[str]:
    """The elements that a word names: an id in the argument, or the thing that elements are about, as `id` or `kind:id`; goals first."""
    if word in case.elements:
        return [word]
    kind, _, rest = word.partition(":")
    wanted = (kind.replace("-", " "), rest.strip())
    about = [
        e for e in case.elements.values() if e.about is not None and (e.about[1] == word or e.about == wanted)
    ]
    return [e.id for e in sorted(about, key=lambda e: e.kind != "goal")]


def _names(case: Case) -> list[str]:
    return [*case.elements, *{e.about[1] for e in case.elements.values() if e.about is not None}]


def _counter(id_: str, defeater: Defeater) -> Element:
    said = f"{defeater.text} ({defeater.owner})"
    if defeater.state == ANSWERED and defeater.answer:
        said += f" Answered: {defeater.answer}"
    kind = "counter solution" if defeater.evidence else "counter goal"
    place = defeater.id.place
    return Element(
        id_, kind, said, place, place, undeveloped=not defeater.evidence, state=str(defeater.state)
    )


def _of_answer(defeater: Defeater) -> Iterator[Finding]:
    if (defeater.state == ANSWERED) != bool(defeater.answer):
        why = (
            "is answered, and does not say how"
            if not defeater.answer
            else f"has an answer, and is {defeater.state}"
        )
        help_ = "write the `answer`" if not defeater.answer else "it is `answered` then"
        yield error("T423", f"the defeater `{defeater.id}` {why}", defeater.id.place, help_, defeater.id)


__all__ = ["named", "with_challenges"]
