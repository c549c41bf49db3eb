"""A Supervisor whose rules remember: what was is what was decided to be driven, and what was refused is a gap."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import pytest

from support.length import amount, at_length, shared_out
from trackmarshal.backends.c import step
from trackmarshal.backends.c.capacities import of_limits
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime import supervisor as parts
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import rulebox, supervisor

SIGNALS = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s in [-10, 150] }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m }
event flag
"""
PYTHON = ("reference", "numpy")
BACKENDS = (*PYTHON, "c")


def paired_in_c(ones: Sequence[str], others: Sequence[str]) -> list[Any]:
    """All of two kinds with each other; every day in C, where a compiler is asked for each, every second: each of both kinds."""
    return [
        at_length(one, other, backend) if backend == "c" and (i + j) % 2 else (one, other, backend)
        for i, one in enumerate(ones)
        for j, other in enumerate(others)
        for backend in BACKENDS
    ]


class Rig:
    """One Supervisor, its clock, and cycles every tenth of a second in which the car drives on straight."""

    def __init__(
        self,
        rules: str,
        backend: str,
        spec: str = SIGNALS,
        at: tuple[float, int] = (0.0, -1),
        **limits: Any,
    ) -> None:
        self.now, self.number = at
        self.supervisor: Any = supervisor(
            loads(spec + rules), None, backend, Limits(**limits), lambda: self.now
        )
        assert isinstance(self.supervisor, CSupervisor if backend == "c" else Supervisor)

    def step(self, v: float = 10.0, emergency: float = 10.0, **signals: Any) -> Any:
        """A cycle whose candidates begin at these speeds."""
        self.now, self.number = round(self.now + 0.1, 9), self.number + 1
        at = self.now * 10.0
        given = {
            "ego": {"x": at, "y": 0.0, "heading": 0.0, "v": 10.0},
            "objects": {"id": [], "x": []},
            "flag": False,
        }
        return self.supervisor.step(
            Cycle(self.number, self.now, _plan(at, v), _plan(at, emergency), {**given, **signals})
        )

    def missed(self) -> Any:
        self.now, self.number = round(self.now + 0.1, 9), self.number + 1
        return self.supervisor.step(None)


def _plan(x: float, v: float) -> dict[str, list[float]]:
    t = [0.0, 1.0, 2.0, 4.0]
    along = [x, x + 10.0, x + 20.0, x + 25.0]
    return {"t": t, "x": along, "y": [0.0] * 4, "heading": [0.0] * 4, "v": [v, 10.0, 5.0, 0.0]}


def names(decision: Any) -> list[tuple[str, str, str]]:
    return [(one.rule, one.candidate, one.verdict) for one in decision.violations]


@pytest.mark.parametrize("backend", BACKENDS)
def test_it_remembers_what_was_seen(backend: str) -> None:
    rig = Rig('rule once_flagged "" require not once[0.05 s, 0.25 s] flag\n', backend)
    assert rig.step(flag=True).safe
    assert names(rig.step()) == [
        ("once_flagged", "driving", "violated"),
        ("once_flagged", "emergency", "violated"),
    ]
    assert not rig.step().safe
    assert rig.step().safe


@pytest.mark.parametrize("saved", [False, True])
@pytest.mark.parametrize("backend", BACKENDS)
def test_cycles_that_were_lost_count_by_their_numbers(backend: str, saved: bool) -> None:
    """Of cycles that nobody saw to be missing, a count took one for all: three of them, and the one that was refused, may each have counted."""
    few = "".join(
        f'rule few_{most} ""\n  severity advisory\n  require count(flag) <= {most}\n' for most in range(6)
    )
    rig = Rig(few + 'rule steady "" require ego.v > 0 m/s\n', backend)
    for lost, missing in ((3, 4), (0, 4), (1, 6)):
        rig.step()
        rig.number += lost
        if lost:
            assert [name_of(fault) for fault in rig.step().faults] == ["skipped"]
        if saved and backend != "reference":
            lines = rig.supervisor.save()
            rig = Rig(few + 'rule steady "" require ego.v > 0 m/s\n', backend, at=(rig.now, rig.number))
            rig.supervisor.restore(lines)
        said = {one.rule for one in rig.step().advisories if one.verdict == "undefined"}
        assert said == {f"few_{most}" for most in range(missing)}


@pytest.mark.parametrize("backend", [*BACKENDS, "c in Python"])
def test_as_many_cycles_are_lost_as_numbers_tell_apart(backend: str) -> None:
    """All of 64 bits: with one that is refused, and one more, they are 1 where they are counted in as many."""
    rules = 'rule few "" require count(flag) <= 3\n'
    rig = Rig(rules, backend.removesuffix(" in Python"), at=(0.0, -(2**63)))
    if backend == "c in Python":
        box = rulebox(Evaluator(loads(SIGNALS + rules), None, "c"))
        rig.supervisor = box.supervisor(Limits(), lambda: rig.now)
    assert rig.step(flag=True).safe
    for number, refused in ((2**63 - 3, "skipped"), (-1, "out_of_order")):
        rig.number = number
        assert [name_of(fault) for fault in rig.step(flag=True).faults] == [refused]
        assert {one.verdict for one in rig.step(flag=True).violations} == {"undefined"}


@pytest.mark.parametrize(
    ("before", "after"), [("in [-10, 150]", "in [-10, 40]"), ("v: m/s }\nsignal objects", "v: m/s default 0 }\nsignal objects")]
)  # fmt: skip
@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_what_was_saved_under_other_inputs_is_not_restored(backend: str, before: str, after: str) -> None:
    """What is remembered was let in by another door; of the inputs, the spec's own fingerprint knows nothing."""
    few = 'rule few "" require count(flag) <= 3\n'
    rig = Rig(few, backend)
    rig.step()
    lines = rig.supervisor.save()
    assert before in SIGNALS
    with pytest.raises(TrackmarshalError, match="D164"):
        Rig(few, backend, SIGNALS.replace(before, after)).supervisor.restore(lines)
    Rig(few, backend).supervisor.restore(lines)


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_is_undefined_over_the_run_has_no_margin_that_is_shown(backend: str) -> None:
    """`margin nan 1` stood where a reason stands, of which there is none."""
    rig = Rig('rule before "" require not previous flag\n', backend)
    rig.step()
    rig.number += 1
    rig.step()
    found = rig.step()
    assert [str(one) for one in found.violations] == [
        "driving: before undefined",
        "emergency: before undefined",
    ]
    assert {(one["by"], one["where"], one["decided_by"], one["reason"]) for one in found.feedback} == {
        (None, None, None, "")
    }
    assert [one.witness for one in found.violations] == [None, None]


@pytest.mark.parametrize("backend", BACKENDS)
def test_cycles_that_were_seen_to_be_missing_are_counted_once(backend: str) -> None:
    """By a step without a cycle, and again by the number of the next one, which is refused; and one wrong number is no million of cycles."""
    rig = Rig('rule few "" require count(flag) <= 3\nrule fewer "" require count(flag) <= 2\n', backend)
    assert rig.step().safe
    rig.missed()
    rig.missed()
    assert not rig.step().safe
    assert {one.rule for one in rig.step().violations} == {"fewer"}
    rig = Rig('rule few "" require count(flag) <= 2\nrule fewer "" require count(flag) <= 1\n', backend)
    assert rig.step().safe
    rig.number += 10**6
    assert not rig.step().safe
    rig.number -= 10**6
    assert not rig.step().safe
    assert {one.rule for one in rig.step().violations} == {"fewer"}


@pytest.mark.parametrize(
    ("require", "clause", "backend"),
    paired_in_c(
        ("next not flag", "o.x > 3 m or next not flag"),
        ("exists o in objects", "for all o in objects", "for nearest o in objects by o.x"),
    ),
)
def test_who_was_there_is_known_again_where_it_is_decided_later(
    require: str, clause: str, backend: str
) -> None:
    """Also where what looks ahead is not about the element: generated C read the ids of a set of which it had none."""
    rig = Rig(f'rule later ""\n  {clause}\n  require {require}\n', backend)
    for ids in ([], [1], [2, 1], [2]):
        decision = rig.step(objects={"id": ids, "x": [float(one) for one in ids]})
        assert decision.faults == ()
    assert decision.safe
    decision = rig.step(objects={"x": [1.0]})
    assert [(name_of(fault), fault.signal, fault.field) for fault in decision.faults] == [
        ("missing", "objects", "id")
    ]


#: Demands of a cycle and of those to come, and what is known of each in the first one.
AHEAD = [
    ("ego.x / flat > 1 and always[0 s, 0.5 s] not flag", "undefined"),
    ("always[0 s, 0.5 s] (not flag and ego.x / flat > 1)", "undefined"),
    ("not (ego.x / flat > 1 or eventually[0.1 s, 0.5 s] flag)", "undefined"),
    ("ego.x / flat > 1 iff next flag", "undefined"),
    ("(not flag) until[0 s, 0 s] ego.x / flat > 1 or (ego.x / flat > 1 and next flag)", "undefined"),
    ("(for all o in objects: ego.x / flat > 1) and next not flag", "undefined"),
    ("(exists o in objects where o.x / flat > 1: o.x > 0 m) and next not flag", "undefined"),
    ("ego.x / flat > 1 or always[0 s, 0.5 s] not flag", ""),
    ("always[0.1 s, 0.5 s] ego.x / flat > 1", ""),
    ("ego.x / flat > 1 until[0 s, 0.5 s] flag", "undefined"),
    ("(not flag) until[0 s, 0.5 s] ego.x / flat > 1", ""),
    ("for all o in objects where o.x > 100 m: (ego.x / flat > 1 and next flag)", ""),
    ("flag and always[0 s, 0.5 s] (ego.x / flat > 1)", "violated"),
]


@cache
def ahead(backend: str, demands: tuple[str, ...]) -> Any:
    """What is decided in a first cycle where all of them are demanded: a compiler is asked once for them."""
    rules = "".join(f'rule ahead_{n} "" require {demand}\n' for n, demand in enumerate(demands))
    return Rig(f"param flat : m = 0 m\n{rules}", backend).step(objects={"id": [1], "x": [2.0]})


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("require", "verdict"), AHEAD)
def test_what_nothing_to_come_can_make_hold_is_not_open(require: str, verdict: str, backend: str) -> None:
    """What is open makes nothing unsafe: a cycle with a NaN in it was driven until a window was over that could not change that.

    Every day those that are open stand in one spec, and the others in another one; at length, each stands alone.
    """
    alike = tuple(demand for demand, said in AHEAD if bool(said) == bool(verdict))
    demands = amount(alike, (require,))
    decision = ahead(backend, demands)
    rule = f"ahead_{demands.index(require)}"
    wanted = [(rule, "driving", verdict), (rule, "emergency", verdict)] if verdict else []
    assert [one for one in names(decision) if one[0] == rule] == wanted
    assert decision.safe == (not verdict)


NEVER_DRIVEN = """state gear : { low, high } starts low
  becomes high from low when ego.v > 100 m/s
  becomes low from high when plan.last.v < 1 m/s
rule moves "" require ego.v > 3 m/s
rule quick "" require weak previous time_in(gear) <= 1 s
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_state_is_known_where_nothing_was_driven(backend: str) -> None:
    """The guard that asks for the plan does not lead from it: a Supervisor that did not start in its first cycle never did."""
    rig = Rig(NEVER_DRIVEN, backend)
    standing = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 2.0}
    assert names(rig.step(ego=standing)) == [
        ("moves", "driving", "violated"),
        ("moves", "emergency", "violated"),
    ]
    assert names(rig.step()) == []


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    "rule", ["ego.v < 3 m/s or plan.first.v < 20 m/s", "not (ego.v >= 3 m/s and plan.first.v >= 20 m/s)"]
)
def test_a_rule_says_where_what_was_driven_does_not_count(rule: str, backend: str) -> None:
    """Where nothing was, the rest of the formula may decide."""
    moves = 'rule moves "" require ego.v > 3 m/s\n'
    standing = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 2.0}
    for require, starts in (
        (f"historically[0 s, 1 s] ({rule})", True),
        ("historically[0 s, 1 s] plan.first.v < 20 m/s", False),
    ):
        rig = Rig(f'{moves}rule slow "" require {require}\n', backend)
        assert not rig.step(ego=standing).safe
        assert rig.step().safe == starts
        assert rig.step().safe == starts


@pytest.mark.parametrize("backend", BACKENDS)
def test_rules_are_told_in_which_cycles_something_was_driven(backend: str) -> None:
    """Of both candidates it is so that they would be driven; of a past cycle, what came of it, whatever somebody says in `signals`."""
    rig = Rig(
        'event driven ""\n'
        'rule moves "" require ego.v > 3 m/s\n'
        'rule would_be "" require driven\n'
        'rule never_twice "" require count(driven, last: 10 s) <= 3\n', backend,
    )  # fmt: skip
    standing = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 2.0}
    for told in ({"driven": True}, {"driven": False}):
        assert {rule for rule, _, _ in names(rig.step(ego=standing, **told))} == {"moves"}
    for told in ({"driven": True}, {"driven": False}, {}):
        assert rig.step(**told).safe
    decision = rig.step()
    assert names(decision) == [
        ("never_twice", "driving", "violated"),
        ("never_twice", "emergency", "violated"),
    ]
    assert decision.state == "previous_emergency"


@pytest.mark.parametrize(("name", "kind", "backend"), paired_in_c(("driven", "emergency"), ("record", "set")))
def test_a_signal_may_be_called_as_a_candidate_or_what_is_told(kind: str, name: str, backend: str) -> None:
    """A program in C was not compiled, which told the signal; of a set, ids of the candidate were looked for, and missing."""
    if kind == "set":
        spec = f"signal {name} : set of object {{ x: m }}\n"
        rule = f"for all o in {name}\n  require o.x < 5 m and not previous o.x > 6 m"
        cycles: list[dict[str, Any]] = [{"id": [1, 2], "x": [1.0, x]} for x in (4.0, 7.0, 4.0, 4.0)]
    else:
        spec = f"signal {name} : state {{ x: m, on: bool }}\n"
        rule = f"require {name}.x < 5 m and {name}.on and not previous {name}.x > 6 m"
        cycles = [{"x": x, "on": True} for x in (4.0, 7.0, 4.0, 4.0)]
    rig = Rig(f'{spec}rule small ""\n  {rule}\n', backend)
    said = []
    for number, given in enumerate(cycles):
        rig.now = number * 0.1
        ego = {"x": rig.now * 10.0, "y": 0.0, "heading": 0.0, "v": 10.0}
        plan = _plan(rig.now * 10.0, 10.0)
        said.append(rig.supervisor.step(Cycle(number, rig.now, plan, plan, {"ego": ego, name: given})).safe)
    assert said == [True, False, False, True]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("require", "safe"),
    [
        ("race.id < 5 and race.closed", [True, True, True, True]),
        ("for all o in things: o.id < 5 m", [True, False, False, True]),
        ("for all o in things: not once[0.1 s, 0.15 s] o.id > 6 m", [True, True, False, True]),
    ],
)
def test_a_field_may_be_called_id(require: str, safe: list[bool], backend: str) -> None:
    """A program in C was not compiled: it took a record for a set whose elements it is to know again, or had two members of that name."""
    spec = "signal race : state { id: 1, closed: bool }\nsignal things : set of object { id: m, x: m }\n"
    rig = Rig(f'{spec}rule named "" require {require}\n', backend)
    race = {"id": 4.0, "closed": True}
    things = [{"id": ids, "x": [1.0] * len(ids)} for ids in ([1, 2], [2, 7], [7], [])]
    assert [rig.step(race=race, things=each).safe for each in things] == safe


@pytest.mark.parametrize("backend", BACKENDS)
def test_both_candidates_see_what_was_driven(backend: str) -> None:
    """The plan of an earlier cycle is the one that was decided on: the driving trajectory where the cycle was safe, else the stored one."""
    rig = Rig(
        'rule slow "" require plan.first.v <= 11 m/s\n'
        'rule was_driven "" require not previous plan.first.v > 10.5 m/s\n', backend,
    )  # fmt: skip
    assert rig.step(v=10.8, emergency=10.7).safe
    # Both rules look at what was driven, 10.8 m/s: neither candidate of this cycle was.
    assert names(rig.step()) == [
        ("was_driven", "driving", "violated"),
        ("was_driven", "emergency", "violated"),
    ]
    # What is driven now is the stored emergency trajectory of 10.7 m/s, from its last due sample on.
    assert names(rig.step()) == [
        ("was_driven", "driving", "violated"),
        ("was_driven", "emergency", "violated"),
    ]


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_was_not_driven_is_not_remembered(backend: str) -> None:
    rig = Rig(
        'rule slow "" require plan.first.v <= 11 m/s\nrule was "" require not once[0.05 s, 1 s] plan.first.v > 11 m/s\n',
        backend,
    )
    assert rig.step().safe
    assert names(rig.step(v=11.2, emergency=10.9)) == [("slow", "driving", "violated")]
    assert rig.step().safe


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("refused", ["missed", "broken"])
def test_a_refused_cycle_is_a_gap(backend: str, refused: str) -> None:
    rig = Rig('rule f "" require not once[0.05 s, 0.25 s] flag\n', backend)
    assert rig.step().safe
    broken = rig.missed() if refused == "missed" else rig.step(ego={"x": 0.0})
    assert not broken.safe
    assert broken.faults
    if refused == "missed":
        assert rig.step().faults  # its number, and its time, say that one is missing
    # The gap ends with the stamp of the next accepted cycle, and lies in the windows of all that begin before.
    for _ in range(3):
        decision = rig.step()
        assert not decision.faults
        assert {verdict for _, _, verdict in names(decision)} == {"undefined"}
    assert rig.step().safe


@pytest.mark.parametrize("backend", PYTHON)
def test_a_cycle_of_which_a_part_did_not_answer_is_a_gap(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is sure about it: what it says is not remembered as what was, however harmless it looks."""
    rig = Rig('rule f "" require not once[0.05 s, 0.25 s] flag\n', backend)
    assert rig.step().safe
    with monkeypatch.context() as patch:
        patch.setattr(parts, "watch", lambda *_: None)
        assert "incomplete" in map(name_of, rig.step().faults)
    for _ in range(3):
        assert {verdict for _, _, verdict in names(rig.step())} == {"undefined"}
    assert rig.step().safe


@pytest.mark.parametrize("backend", BACKENDS)
def test_where_nothing_was_driven_the_plan_is_undefined(backend: str) -> None:
    rig = Rig(
        'rule slow "" require plan.first.v <= 11 m/s\nrule f "" require weak previous plan.first.v <= 11 m/s\n',
        backend,
    )
    assert rig.step(v=11.2, emergency=10.9).driven is None
    assert {one[::2] for one in names(rig.step())} == {("f", "undefined")}


@pytest.mark.parametrize("backend", PYTHON)
def test_a_late_violation_makes_its_cycle_unsafe(backend: str) -> None:
    rig = Rig('rule reacts "" whenever flag within 0.2 s require ego.v < 5 m/s\n', backend)
    assert rig.step(flag=True).safe
    assert rig.step().safe
    late = rig.step()
    assert names(late) == [("reacts", "driving", "violated"), ("reacts", "emergency", "violated")]
    about = late.violations[0].explain().about
    assert [(one.cycle, one.verdict, one.final) for one in about] == [
        (2, "inactive", True),
        (0, "violated", True),
    ]
    assert rig.step().safe


@pytest.mark.parametrize("backend", BACKENDS)
def test_objects_have_ids(backend: str) -> None:
    rig = Rig('rule f "" for all o in objects require weak previous o.x < 5 m\n', backend)
    assert not rig.step(objects={"x": [1.0]}).safe
    assert rig.step(objects={"id": ["a"], "x": [6.0]}).safe
    assert names(rig.step(objects={"id": ["a"], "x": [1.0]}))
    assert rig.step(objects={"id": ["b"], "x": [6.0]}).safe
    assert rig.step(objects={"id": ["a"], "x": [1.0]}).safe


@pytest.mark.parametrize("backend", PYTHON)
def test_memory_that_is_lost_makes_nothing_safe(backend: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig('rule f "" require weak previous ego.v < 50 m/s\n', backend)
    assert rig.step().safe
    engine = rig.supervisor.program._engine

    def fails(*_: Any) -> Any:
        raise OSError("no room")

    with monkeypatch.context() as patch:
        patch.setattr(engine, "commit", fails)
        assert not rig.step().safe
    # That is a gap: the cycle after it does not know what came before.
    assert {verdict for _, _, verdict in names(rig.step())} == {"undefined"}
    assert rig.step().safe
    with monkeypatch.context() as patch:
        patch.setattr(engine, "commit", fails)
        patch.setattr(engine, "missed", fails)
        assert not rig.step().safe
    assert not rig.step().safe
    assert not rig.step().safe


@pytest.mark.parametrize("formula", ["not once[0 s, 2 s] flag", "historically[0.3 s, 2 s] not flag",
                                     "not flag since[0.2 s, 2 s] ego.v > 1 m/s", "count(flag, last: 2 s) <= 0"])  # fmt: skip
def test_more_cycles_than_windows_have_room_for(formula: str) -> None:
    """Two cycles a second have room, and ten come: what finds none is not known, and never taken for what was not."""
    rules = f'rule f "" require {formula}\n'
    plenty, few = Rig(rules, "numpy"), Rig(rules, "c", rate=2)
    seen = set()
    for number in range(60):
        flag = number in (11, 12, 40)
        wanted = {verdict for _, _, verdict in names(plenty.step(flag=flag))} or {"satisfied"}
        mine = {verdict for _, _, verdict in names(few.step(flag=flag))} or {"satisfied"}
        seen |= mine
        assert mine in (wanted, {"undefined"}), number
    assert "undefined" in seen


@pytest.mark.parametrize("formula", shared_out(["always[0 s, 2 s] not flag", "eventually[1 s, 2 s] not flag",
                                     "not (flag until[0.5 s, 2 s] ego.v > 1 m/s)", "once (always[0 s, 2 s] not flag) or not flag"], 2))  # fmt: skip
def test_more_cycles_than_what_looks_ahead_has_room_for(formula: str) -> None:
    """From the cycle on that is lost, nothing is sure until its windows would have been over."""
    rules = f'rule f "" require {formula}\n'
    plenty, few = Rig(rules, "numpy"), Rig(rules, "c", rate=2)
    seen = list[set[str]]()
    for number in range(80):
        flag = number in (11, 12, 40)
        wanted = {verdict for _, _, verdict in names(plenty.step(flag=flag))} or {"satisfied"}
        mine = {verdict for _, _, verdict in names(few.step(flag=flag))} or {"satisfied"}
        seen.append(mine)
        assert mine in (wanted, {"undefined"}), number
    assert {"undefined"} in seen
    assert {"satisfied"} in seen


def test_less_room_than_a_set_declares_refuses_what_exceeds_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Capacities are macros of whoever compiles: the door went by the declared one, and C wrote behind the end of what it remembers."""
    monkeypatch.setattr(step, "of_limits", lambda *args: {**of_limits(*args), "TM_MAX_ELEMENTS": 2})
    signals = SIGNALS.replace("object { x: m }", "object { x: m } capacity 4 forget 1 s")
    rig = Rig('rule far "" for all o in objects require not once[0 s, 1 s] o.x > 5 m\n', "c", spec=signals)
    for count in (0, 1, 2, 3, 4, 5, 2):
        decision = rig.step(objects={"id": [str(i) for i in range(count)], "x": [0.0] * count})
        assert [name_of(fault) for fault in decision.faults] == ["over_capacity"] * (count > 2), count


def test_a_memory_that_is_too_large_is_refused() -> None:
    with pytest.raises(TrackmarshalError) as caught:
        Rig('rule f "" require not once[0 s, 100 h] flag\n', "c", rate=1000)
    assert caught.value.code == "E473"


@pytest.mark.parametrize("backend", BACKENDS)
def test_who_is_absent_for_a_while_keeps_its_history(backend: str) -> None:
    """Of objects that are absent for up to 0.3 s; after more, it is another one. More than the capacity are a fault."""
    signals = SIGNALS.replace("object { x: m }", "object { x: m } capacity 2 forget 0.35 s")
    rules = 'rule far "" for all o in objects require not once o.x > 5 m\n'
    rig = Rig(rules, backend, spec=signals)

    def step(**there: float) -> Any:
        return rig.step(objects={"id": list(there), "x": list(there.values())})

    assert not step(a=9.0).safe
    assert step().safe  # nobody is there
    assert [one[2] for one in names(step(a=0.0))] == ["violated"] * 2  # it was there 0.2 s ago
    assert [step().safe for _ in range(3)] == [True] * 3
    assert step(a=0.0).safe  # after 0.4 s, it is a new one
    assert step(b=0.0, c=0.0).violations  # b has a place, c has none
    decision = step(a=0.0, b=0.0, c=0.0)
    assert [(fault.signal, fault.index) for fault in decision.faults] == [("objects", 2)]
