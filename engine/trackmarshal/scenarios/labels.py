"""What a ground truth judges: all rules of a kind, or one rule, of a candidate or of both, about all objects or one."""

from __future__ import annotations

import re
from typing import NamedTuple

from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.scenarios.recording import CANDIDATES, Recording

#: First names of the modules of which the generator's own ground truth knows what they ask: collisions, and what car and road allow.
KNOWN = ("supervisor", "fallback", "variants")
_LABEL = re.compile(rf"rule (\S+)(?: of ({'|'.join(CANDIDATES)}))?(?: for (.+))?", re.DOTALL)


class Label(NamedTuple):
    """A rule; the candidate, "" for either; the object by its id, "" for all of them."""

    rule: str
    candidate: str = ""
    object: str = ""

    def __str__(self) -> str:
        of = f" of {self.candidate}" if self.candidate else ""
        return f"rule {self.rule}{of}" + (f" for {self.object}" if self.object else "")


def label(name: str) -> Label | None:
    """The label that a name of a ground truth is: `rule R`, `rule R of driving`, `rule R for blue`; None where it is none."""
    found = _LABEL.fullmatch(name)
    return None if found is None else Label(found[1], found[2] or "", found[3] or "")


def labels(recording: Recording) -> dict[str, Label]:
    """The labels among the names of a recording's ground truth."""
    found = {name: label(name) for name in recording.ground_truth}
    return {name: each for name, each in found.items() if each is not None}


def kind_of(rule: RuleInfo, spec: Spec) -> str:
    """`dynamic` for a rule that reads moving objects (a set whose elements have a speed), else `static`."""
    for signal, _ in rule.reads:
        info = spec.signals.get(signal)
        if info is not None and info.many and info.field("v") is not None:
            return "dynamic"
    return "static"


def judged_by(rule: RuleInfo, spec: Spec, recording: Recording) -> tuple[str, ...]:
    """The names of the ground truths that judge a rule; none for a rule that nothing is known of.

    A rule with a truth of its own is judged by that alone. Where a recording says anything of rules by name, the kinds judge the rules
    that the generator knows of and those that it names; where it says nothing of the sort, all.
    """
    own = labels(recording)
    named = tuple(name for name, each in own.items() if each.rule == rule.name)
    if named:
        return named
    if rule.name in recording.judged:
        return (recording.judged[rule.name],)
    if (own or recording.judged) and not known(rule):
        return ()
    return (kind_of(rule, spec),)


def known(rule: RuleInfo) -> bool:
    """Whether the generator's ground truth knows what a rule asks."""
    return rule.module.partition(".")[0] in KNOWN
