"""Two sets of rules on the same recordings: which rule is which, and what became of each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from trackmarshal.comparing.changes import EQUAL, GONE, NEW, Column, RuleChange, alone, changed
from trackmarshal.comparing.decisions import DecisionChange, decided
from trackmarshal.comparing.judged import Judged, judge
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.margins import SCALED, measured_units, own_unit
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.scenarios.recording import Recording


@dataclass(frozen=True, slots=True)
class Pair:
    """One recording, judged before and after."""

    old: Judged
    new: Judged


@dataclass(frozen=True, slots=True)
class Comparison:
    """What became of every rule, in the order of the new spec, those that are gone last, and of decisions."""

    rules: tuple[RuleChange, ...]
    decisions: tuple[DecisionChange, ...]

    @property
    def equal(self) -> bool:
        """Whether nothing differs, to the bit of margins."""
        return not self.decisions and all(
            rule.word == EQUAL and not (rule.changed or rule.was or rule.severity or rule.undecided)
            for rule in self.rules
        )


def compare(
    old: Evaluator, new: Evaluator, recordings: Iterable[Recording], renamed: Mapping[str, str] | None = None
) -> tuple[RuleChange, ...]:
    """What became of every rule on recordings (docs/diff.md), which are judged as the Supervisor does it, both candidates in every cycle.

    Otherwise as `compared`. Raises TrackmarshalError as a replay does.
    """
    return compared([Pair(judge(old, each), judge(new, each)) for each in recordings], renamed).rules


def compared(pairs: Sequence[Pair], renamed: Mapping[str, str] | None = None) -> Comparison:
    """What became of every rule, in the order of the new evaluator's rules, those that are gone last, and of decisions, on recordings that are
    judged: those of one side by evaluators of the same rules.

    renamed: new names by old ones; of others, a rule is taken for a renamed one where exactly one of the same formula is gone.
    """
    if not pairs:
        return Comparison((), ())
    old = {rule.name: rule for rule in pairs[0].old.evaluator.rules}
    new = {rule.name: rule for rule in pairs[0].new.evaluator.rules}
    was = _same(old, new, renamed or {})
    rules = [
        _changed(pairs, was[name], name) if name in was
        else alone(rule, NEW, [(pair.new.there, pair.new.codes[:, :, _place(pair.new, name)]) for pair in pairs])
        for name, rule in new.items()
    ]  # fmt: skip
    kept = set(was.values())
    rules += [
        alone(rule, GONE, [(pair.old.there, pair.old.codes[:, :, _place(pair.old, name)]) for pair in pairs])
        for name, rule in old.items() if name not in kept
    ]  # fmt: skip
    return Comparison(tuple(rules), tuple(one for pair in pairs for one in decided(pair.old, pair.new)))


def of_rule(pairs: Sequence[Pair], name: str) -> RuleChange | None:
    """What became of one rule over those recordings whose evaluators have it, before and after; None for none."""
    both = [pair for pair in pairs if _has(pair.old, name) and _has(pair.new, name)]
    if not both:
        return None
    return _changed(both, name, name)


def _changed(pairs: Sequence[Pair], before: str, after: str) -> RuleChange:
    """What became of a rule under its names, over recordings that are judged by the same rules."""
    first = pairs[0]
    old = first.old.evaluator.rules[_place(first.old, before)]
    new = first.new.evaluator.rules[_place(first.new, after)]
    alike = _measures(first.old, old) == _measures(first.new, new)
    return changed(old, new, [_column(pair, before, after) for pair in pairs], alike)


def _measures(judged: Judged, rule: RuleInfo) -> Mapping[str, float]:
    """Of a rule of several dimensions, their units in SI, each with what margins in it are divided by; nothing of one that has a unit."""
    if own_unit(rule.unit) or rule.formula is None:
        return {}
    scales = dict(judged.evaluator.spec.scales) if rule.unit == SCALED else {}
    return {unit: scales.get(unit, 1.0) for unit in measured_units(rule.formula)}


def _has(judged: Judged, name: str) -> bool:
    return any(rule.name == name for rule in judged.evaluator.rules)


def _same(
    old: Mapping[str, RuleInfo], new: Mapping[str, RuleInfo], renamed: Mapping[str, str]
) -> dict[str, str]:
    """Old names by new ones."""
    was = {name: name for name in new if name in old and name not in renamed}
    was |= {after: before for before, after in renamed.items() if before in old and after in new}
    left = {name: _meaning(rule) for name, rule in old.items() if name not in was.values()}
    fresh = {name: _meaning(rule) for name, rule in new.items() if name not in was}
    for name, meaning in fresh.items():
        before = [one for one, meant in left.items() if meant == meaning]
        after = [one for one, meant in fresh.items() if meant == meaning]
        if len(before) == len(after) == 1:
            was[name] = before[0]
    return was


def _meaning(rule: RuleInfo) -> tuple[str, ...]:
    """What is the same of a rule under another name; nodes of two specs are equal as they are written, places left out."""
    return rule.kind, rule.unit, repr(rule.formula), repr(rule.active)


def _place(judged: Judged, name: str) -> int:
    return next(place for place, rule in enumerate(judged.evaluator.rules) if rule.name == name)


def _column(pair: Pair, before: str, after: str) -> Column:
    old, new = _place(pair.old, before), _place(pair.new, after)
    return Column(
        pair.new.recording.name, pair.new.times, pair.old.there & pair.new.there, pair.old.codes[:, :, old], pair.new.codes[:, :, new],
        pair.old.margins[:, :, old].copy(), pair.new.margins[:, :, new].copy(),
    )  # fmt: skip
