"""The ground truth of single rules, as a declaration gives it: stretches of time by hand, or expressions that read no rule."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.words import Specs, Words, values
from trackmarshal.scenarios.labels import Label
from trackmarshal.scenarios.recording import CANDIDATES, TRUTHS, Recording
from trackmarshal.units import moment

_SLACK = 1e-9
#: Stretches [from, to] in s, both included, or an expression.
When = list[tuple[float, float, Item]] | Words


@dataclass(frozen=True, slots=True)
class GivenTruth:
    """When a rule has to fire, and when it may; else it must not. With a `kind`, it is judged by that of the generator."""

    label: Label
    item: Item
    kind: str
    unsafe: When
    free: When


def entries(items: list[Item]) -> tuple[GivenTruth, ...]:
    """What a declaration says of single rules; raises D151 and D255."""
    found: list[GivenTruth] = []
    for item in items:
        each = _entry(item)
        for other in found:
            same = other.label.rule == each.label.rule
            if same and (other.label == each.label or other.kind or each.kind):
                raise item.wrong(
                    f"the truth about `{each.label.rule}` is given twice", "keep one of them", "D255"
                )
        found.append(each)
    return tuple(found)


def _entry(item: Item) -> GivenTruth:
    fields = item.fields(("rule",), ("candidate", "object", "unsafe", "free", "as"))
    candidate = fields["candidate"].choice(CANDIDATES) if "candidate" in fields else ""
    about = fields["object"].text() if "object" in fields else ""
    made = Label(fields["rule"].text(), candidate, about)
    if "as" in fields:
        if len(fields) > 2:
            raise item.wrong("`as` stands beside something else", "leave that out, or `as`", "D255")
        return GivenTruth(made, item, fields["as"].choice(TRUTHS), [], [])
    if "unsafe" not in fields:
        help_ = "`unsafe: []` where it never has to; or `as: static`"
        raise item.wrong("it is not said when the rule has to fire", help_, "D255")
    unsafe, free = (_when(fields[key], bool(about)) if key in fields else [] for key in ("unsafe", "free"))
    if isinstance(unsafe, list) and isinstance(free, list):
        for begin, end, _ in unsafe:
            for first, last, at in free:
                if begin <= last and first <= end:
                    raise at.wrong(
                        f"from {first:g} to {last:g} s it is free, and unsafe", "keep one of them", "D255"
                    )
    return GivenTruth(made, item, "", unsafe, free)


def _when(item: Item, each: bool) -> When:
    if not item.is_list():
        return Words(item.text(), item, None, each)
    found = []
    for stretch in item.items():
        numbers = [number.number(0.0) for number in stretch.items()]
        if len(numbers) != 2 or numbers[0] > numbers[1]:
            raise stretch.wrong("this is no stretch", "two times in s, both included: [4, 6]")
        found.append((numbers[0], numbers[1], stretch))
    return found


def with_truth(recording: Recording, given: Sequence[GivenTruth], specs: Specs) -> Recording:
    """The recording with the ground truth of single rules; raises D252, D253 and D255."""
    truths, judged = dict(recording.ground_truth), {}
    ids = {each["id"] for cycle in recording.cycles for each in cycle.objects}
    for one in given:
        rule = specs.spec.rule(one.label.rule)
        if rule is None or rule.formula is None:
            what = "no rule of the specs" if rule is None else "an assumption without a monitor"
            help_ = close_matches(one.label.rule, [each.name for each in specs.spec.rules])
            raise one.item.wrong(
                f"`{one.label.rule}` is {what}", help_ or "name its spec under `specs`", "D255"
            )
        if one.label.object and one.label.object not in ids:
            help_ = close_matches(one.label.object, ids) or "one of `others`, by its `id`"
            raise one.item.wrong(f"there is no object `{one.label.object}`", help_, "D255")
        if one.kind:
            judged[one.label.rule] = one.kind
            continue
        unsafe, free = (_cycles(when, one.label, recording, specs) for when in (one.unsafe, one.free))
        # What has to fire has to, whatever else is said of it.
        truths[str(one.label)] = tuple(
            False if has_to else None if may else True for has_to, may in zip(unsafe, free)
        )
    return replace(recording, ground_truth=truths, judged=judged)


def _cycles(when: When, label: Label, recording: Recording, specs: Specs) -> list[bool]:
    """Whether it is so in each cycle; by an expression, of either candidate."""
    if isinstance(when, Words):
        candidates = [label.candidate] if label.candidate else list(CANDIDATES)
        alone = label.object or None
        columns = [[row[0] for row in values(specs, [when], recording, name, alone)] for name in candidates]
        return [any(row) for row in zip(*columns)]
    times = [cycle.t for cycle in recording.cycles]
    for begin, end, item in when:
        if not any(begin - _SLACK <= t <= end + _SLACK for t in times):
            raise item.wrong(
                "no cycle lies in this stretch",
                f"cycles are from {moment(times[0])} to {moment(times[-1])} s",
                "D255",
            )
    return [any(begin - _SLACK <= t <= end + _SLACK for begin, end, _ in when) for t in times]
