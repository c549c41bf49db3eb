"""What must hold of any spec by the definitions of the language, for both evaluators.

Laws of logic and of time on verdicts and margins; what is unknown stays between what it could be; batches, other rules
and the order of objects change nothing; absence is no violation.
"""

from __future__ import annotations

import copy
import math
import os
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from property.strategies.specs import DrawnChoices, equivalents, repeatable, subjects
from support.agreement import compiled, differences, near_differences, read, results, same
from support.generated import (
    FormulaWriter,
    Inputs,
    Laws,
    ModuleWriter,
    RandomChoices,
    Scope,
    Subject,
    laws,
    subject,
)
from support.length import amount, shared_out
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.verdict import CaseResult, RuleResult

BACKENDS = ("reference", "numpy")
#: Of seeded ones, what each part has.
SEEDS = int(os.environ.get("TRACKMARSHAL_SEEDS", "4"))
#: Their examples are long, or cost several evaluations; seeded ones, which are cheaper, make up for it.
few = settings(repeatable, max_examples=amount(3, 5))
some = settings(repeatable, max_examples=amount(12, 20))
both = pytest.mark.parametrize("backend", BACKENDS)
Raw = dict[str, Any]


def evaluated(spec: Any, raw: Raw, backend: str) -> CaseResult:
    return results(spec, read(spec, [raw]), backend)[0]


# Two ways to say one thing --------------------------------------------------------------------------------------


def broken_laws(made: Laws, backend: str) -> list[str]:
    spec = compiled(made.text)
    cases = read(spec, made.cases)
    found = []
    for case, result in zip(cases, results(spec, cases, backend), strict=True):
        for index, (name, same_margins) in enumerate(made.laws):
            left, right = result.rules[f"left_{index}"], result.rules[f"right_{index}"]
            reads = [spec.rule(f"{side}_{index}").reads for side in ("left", "right")]  # type: ignore[union-attr]
            unusable = [case.unusable(read) is not None for read in reads]
            if unusable[0] != unusable[1]:
                continue  # one of them is undefined because of an input that the other does not read
            assert left.series is not None
            assert right.series is not None
            margins = zip(left.series[1], right.series[1], strict=True)
            if left.series[0] != right.series[0] or (
                same_margins and not all(same(a, b) for a, b in margins)
            ):
                found.append(f"{name}: {left.series} | {right.series}")
    return found


@both
@few
@given(equivalents())
def test_laws_of_logic_and_time(backend: str, made: Laws) -> None:
    assert not broken_laws(made, backend)


@both
@pytest.mark.parametrize("seed", shared_out(range(20), 2))
def test_laws_of_logic_and_time_on_seeded_formulas(backend: str, seed: int) -> None:
    assert not broken_laws(laws(RandomChoices(seed)), backend)


# What is unknown ------------------------------------------------------------------------------------------------


def places_of(raw: Raw) -> list[tuple[Any, Any]]:
    """All (container, key) at which a case holds a value of a signal."""
    places: list[tuple[Any, Any]] = []
    for name, signal in raw["signals"].items():
        if isinstance(signal, bool):
            places.append((raw["signals"], name))
        elif isinstance(signal, list):
            places += [(element, key) for element in signal for key in element if key != "id"]
        elif isinstance(signal, dict):
            for key, value in signal.items():
                places += (
                    [(value, index) for index in range(len(value))]
                    if isinstance(value, list)
                    else [(signal, key)]
                )
    return places


#: What a verdict may become when one more value of the input is unknown. What was out of range for sure may then be in it,
#: and if it does there what is demanded, the rule holds either way.
ALLOWED = {
    "satisfied": {"satisfied", "undefined"},
    "violated": {"violated", "undefined"},
    "undefined": {"undefined"},
    "inactive": {"inactive", "satisfied", "undefined"},
}


def unlearned(before: RuleResult, after: RuleResult) -> str | None:
    """What is wrong with a rule's result once something that it may depend on is unknown; None: nothing."""
    if after.verdict not in ALLOWED[before.verdict]:
        return f"{before.rule}: {before.verdict} became {after.verdict}"
    if before.verdict == after.verdict == "satisfied" and not after.margin <= before.margin:
        return f"{before.rule}: satisfied by {before.margin!r} became {after.margin!r}"
    if before.verdict == after.verdict == "violated" and not after.margin >= before.margin:
        return f"{before.rule}: violated by {before.margin!r} became {after.margin!r}"
    return None


def hold_what_is_unknown_against_what_it_was(made: Subject, choose: Any, backend: str) -> None:
    spec = compiled(made.text)
    for raw in made.cases:
        places = places_of(raw)
        if not read(spec, [raw]) or not places:
            continue
        before = evaluated(spec, raw, backend)
        hidden = copy.deepcopy(raw)
        for _ in range(choose.integer(1, 3)):
            container, key = choose.pick(places_of(hidden))
            container[key] = None
        after = evaluated(spec, hidden, backend)
        found = [unlearned(before.rules[name], after.rules[name]) for name in before.rules]
        assert not any(found), (found, before.faults, after.faults)
        assert set(before.faults) <= set(after.faults) or not after.safe
        assert before.safe or not after.safe


@both
@some
@given(subjects(), st.data())
def test_hiding_a_value_makes_nothing_safe(backend: str, made: Subject, data: st.DataObject) -> None:
    hold_what_is_unknown_against_what_it_was(made, DrawnChoices(data.draw), backend)


@both
@pytest.mark.parametrize("part", range(4))
def test_hiding_a_value_makes_no_seeded_spec_safe(backend: str, part: int) -> None:
    for seed in range(SEEDS * part, SEEDS * (part + 1)):
        choices = RandomChoices(seed)
        hold_what_is_unknown_against_what_it_was(subject(choices, inexact="any"), choices, backend)


# Objects --------------------------------------------------------------------------------------------------------


def objects_rule(choices: Any) -> tuple[str, Inputs]:
    """A rule about each object by itself: nothing else in it ranges over objects."""
    module = ModuleWriter(choices)
    module.signals()
    module.writer.domains = ("plan", "cones")
    scope = Scope().bind("o", module.world.signals["objects"].dimensions(), False)
    clauses = ["  for all o in objects"]
    if choices.chance(50):
        clauses[0] += f" where {module.writer.formula(2, scope)}"
    if choices.chance(30):
        clauses.append(f'  except {module.writer.formula(1, scope)} "why not"')
    module.lines += ['rule each "of them"', *clauses, f"  require {module.writer.formula(3, scope)}"]
    return module.text, Inputs(choices, module.world)


def hold_parts_against_the_whole(choices: Any, backend: str) -> None:
    text, inputs = objects_rule(choices)
    spec = compiled(text)
    case = inputs.case(0, choices.pick((0, 0, 10)))
    if not isinstance(case["signals"].get("objects"), list):
        return
    dirt = choices.pick((0, 0, 15))
    ahead, behind = inputs.objects("objects", dirt), inputs.objects("objects", dirt)
    cases = [
        case | {"signals": case["signals"] | {"objects": some}}
        for some in (ahead, behind, ahead + behind, [])
    ]
    if any(unread.unusable for unread in read(spec, cases)):
        return  # a field that is missing makes the rule undefined, not only for its object
    a, b, whole, none = (evaluated(spec, raw, backend).rules["each"] for raw in cases)
    assert none.verdict == "inactive"
    assert whole.verdict == joined(a.verdict, b.verdict)
    for part, other in ((a, b), (b, a)):
        if other.verdict == "inactive":
            assert same(whole.margin, part.margin)
    if a.verdict == b.verdict:
        assert same(whole.margin, min(a.margin, b.margin)) or a.verdict == "undefined"


def joined(*verdicts: str) -> str:
    """The verdict on all objects from the verdicts on parts of them; parts in which none counts do not matter."""
    for verdict in ("violated", "undefined", "satisfied"):
        if verdict in verdicts:
            return verdict
    return "inactive"


@both
@few
@given(st.data())
def test_the_whole_is_the_worst_of_its_parts(backend: str, data: st.DataObject) -> None:
    hold_parts_against_the_whole(DrawnChoices(data.draw), backend)


@both
def test_the_whole_is_the_worst_of_its_parts_on_seeded_rules(backend: str) -> None:
    for seed in range(3 * SEEDS):
        hold_parts_against_the_whole(RandomChoices(seed), backend)


@both
@some
@given(subjects(), st.data())
def test_the_order_of_objects_does_not_matter(backend: str, made: Subject, data: st.DataObject) -> None:
    spec = compiled(made.text)
    for raw in made.cases:
        shuffled = copy.deepcopy(raw)
        for name in ("objects", "cones"):
            if shuffled["signals"].get(name):
                shuffled["signals"][name] = data.draw(st.permutations(shuffled["signals"][name]))
        if read(spec, [raw]):
            before, after = evaluated(spec, raw, backend), evaluated(spec, shuffled, backend)
            for name, rule in before.rules.items():
                assert rule.verdict == after.rules[name].verdict
                assert same(rule.margin, after.rules[name].margin)


# Context --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", [False, True], ids=["plain", "geometry"])
@pytest.mark.parametrize("part", range(3))
def test_a_batch_is_its_cases_one_by_one(part: int, geometry: bool) -> None:
    """To the last bit; up to that where numpy takes another way to an inexact function for one number than for many."""
    for seed in range(SEEDS * part, SEEDS * (part + 1)):
        made = subject(RandomChoices(seed), inexact="gentle", geometry=geometry)
        spec = compiled(made.text)
        cases = read(spec, made.cases)
        together = results(spec, cases, "numpy")
        for case, result in zip(cases, together, strict=True):
            assert not near_differences(spec, case, result, results(spec, [case], "numpy")[0]), seed


@both
def test_a_rule_does_not_depend_on_the_rules_beside_it(backend: str) -> None:
    for seed in range(3 * SEEDS // 2):
        made = subject(RandomChoices(seed), inexact="any")
        spec = compiled(made.text)
        together = results(spec, read(spec, made.cases), backend)
        for rule in spec.rules:
            alone = Evaluator(spec, [rule.name], backend)
            reading = [raw for raw in made.cases if read(spec, [raw])]
            cases = [alone.read(raw) for raw in reading]
            for result, other in zip(alone.evaluate(cases), together, strict=True):
                one, two = result.rules[rule.name], other.rules[rule.name]
                # A timeline whose times others need, and that has none, is no timeline for anybody.
                untimed = [f"D211 {signal}.t: it is not there" for signal, _ in rule.reads]
                if two.verdict == "undefined" and set(untimed) & set(other.faults):
                    continue
                assert one.verdict == two.verdict, seed
                assert same(one.margin, two.margin), seed
                assert set(result.faults) <= set(other.faults), seed


@both
def test_overriding_a_parameter_by_its_own_value_changes_nothing(backend: str) -> None:
    overridden = 0
    for seed in range(2 * SEEDS):
        made = subject(RandomChoices(seed))
        spec = compiled(made.text)
        own = {info.name: info.value for info in spec.params.values() if info.unit in ("1", "m", "s", "m/s")}
        for raw in made.cases:
            plain = {key: value for key, value in raw.items() if key != "params"}
            if own and read(spec, [plain]):
                overridden += 1
                assert not differences(
                    evaluated(spec, plain, backend), evaluated(spec, plain | {"params": own}, backend)
                ), seed
    assert overridden > SEEDS


def test_the_generators_reach_all_verdicts() -> None:
    """The properties above say little if hardly any generated rule is ever decided."""
    counts = dict.fromkeys(ALLOWED, 0)
    finite = 0
    for seed in range(3 * SEEDS):
        made = subject(RandomChoices(seed))
        spec = compiled(made.text)
        for result in results(spec, read(spec, made.cases), "numpy", series=False):
            for rule in result.rules.values():
                counts[rule.verdict] += 1
                finite += math.isfinite(rule.margin)
    total = sum(counts.values())
    assert all(count > total / 20 for count in counts.values()), counts
    assert finite > total / 5


def test_a_writer_without_domains_writes_no_quantifier() -> None:
    module = ModuleWriter(RandomChoices(1))
    module.signals()
    writer = FormulaWriter(RandomChoices(2), module.world)
    writer.domains = ()
    texts = [writer.formula(4, Scope()) for _ in range(200)]
    assert not any(word in text for text in texts for word in ("for all", "exists", "∀", "∃"))
