"""What rulebooks say of candidates: violations, ranks, choices, and how `choose` tells them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.project import run_command
from trackmarshal.errors import TrackmarshalError
from trackmarshal.rulebooks.candidates import violations
from trackmarshal.rulebooks.violation import Violation, violation, worst
from trackmarshal.semantics.compile import compile_text

LANES = """module lanes

signal plan : trajectory { t: s increasing, v: m/s in [0, 60], gap: m, a: m/s^2 }
event certain

rule no_contact "Keeps clear of everybody"
  for all   p in plan
  require   p.gap > 0 m

rule town "Not faster than in town"
  for all   p in plan
  require   p.v <= 50 km/h

rule gentle "Brakes gently"
  severity  advisory
  for all   p in plan
  require   p.a >= -3 m/s^2

rule sure "Is certain"
  require   certain

rulebook lanes "Contact before manners"
  no_contact > town, no_contact > gentle

rulebook strict "A speed is worth more than comfort"
  refines lanes
  town > gentle > sure

rulebook as_one "Speed and comfort count as one"
  refines lanes
  town & gentle

rulebook careful "Certainty before everything"
  extends lanes
  sure > no_contact
"""


def case(
    name: str, v: float = 10.0, gap: float | None = 2.0, a: float = 0.0, certain: bool = True
) -> dict[str, Any]:
    plan = {"t": [0, 1], "v": [v, v], "gap": [gap, 2.0], "a": [a, a]}
    return {"id": name, "signals": {"plan": plan, "certain": certain}}


FAST, HARD, NEAR = case("fast", v=20.0), case("hard", a=-8.0), case("near", gap=-0.5)


def results(*cases: dict[str, Any], backend: str = "numpy") -> list[Any]:
    evaluator = tm.Evaluator(tm.loads(LANES), backend=backend)
    return [evaluator.case(each) for each in cases]


@pytest.mark.parametrize(
    ("verdict", "margin", "expected"),
    [
        ("satisfied", 3.0, (0, 0.0)),
        ("satisfied", -3.0, (0, 0.0)),
        ("inactive", math.inf, (0, 0.0)),
        ("open", -1.0, (0, 0.0)),
        ("open", math.nan, (0, 0.0)),
        ("violated", -2.5, (1, 2.5)),
        ("violated", 0.0, (1, 0.0)),
        ("violated", 1.0, (1, 0.0)),
        ("violated", -math.inf, (1, math.inf)),
        ("violated", math.nan, (1, math.inf)),
        ("undefined", math.nan, (2, math.inf)),
        ("undefined", 5.0, (2, math.inf)),
    ],
)
def test_a_violation_is_a_pair(verdict: str, margin: float, expected: tuple[int, float]) -> None:
    found = violation(verdict, margin)
    assert found == expected
    assert math.copysign(1.0, found.size) == 1.0


def test_a_verdict_that_is_none_is_no_violation() -> None:
    with pytest.raises(ValueError, match="perhaps"):
        violation("perhaps", 1.0)


def test_of_a_run_of_no_cycles_nothing_is_known() -> None:
    with pytest.raises(ValueError, match="empty"):
        worst([])
    book = tm.rulebook(tm.loads(LANES), "lanes")
    with pytest.raises(TrackmarshalError, match="no cycles") as error:
        tm.compare(book, [], results(FAST)[0])
    assert error.value.code == "E409"


@pytest.mark.parametrize("backend", ["numpy", "reference"])
def test_rules_that_are_not_ranked_are_not_weighed(backend: str) -> None:
    book = tm.rulebook(tm.loads(LANES), "lanes")
    fast, hard, near = results(FAST, HARD, NEAR, backend=backend)
    said = tm.compare(book, fast, hard)
    assert (said.outcome, said.for_, said.against) == ("incomparable", ("gentle",), ("town",))
    assert tm.compare(book, fast, near).outcome == "better"
    assert tm.compare(book, near, fast).for_ == ()
    choice = tm.choose(book, [near, hard, fast])
    assert (choice.best, choice.chosen, choice.alone) == ((1, 2), 1, False)


def test_a_refinement_decides_what_was_open() -> None:
    spec = tm.loads(LANES)
    fast, hard, near = results(FAST, HARD, NEAR)
    strict = tm.rulebook(spec, "strict")
    assert tm.compare(strict, hard, fast).outcome == "better"
    choice = tm.choose(strict, [fast, near, hard])
    assert (choice.best, choice.alone) == ((2,), True)


def test_rules_that_count_as_one_are_weighed_worst_first() -> None:
    """20 m/s is 6.1 m/s too fast, -8 m/s^2 is 5 m/s^2 too hard: in SI units, the first is more."""
    book = tm.rulebook(tm.loads(LANES), "as_one")
    fast, hard, both = results(FAST, HARD, case("both", v=20.0, a=-4.0))
    said = tm.compare(book, hard, fast)
    assert (said.outcome, said.for_) == ("better", ("town & gentle",))
    assert tm.compare(book, fast, both).outcome == "better"  # alike in the worst, and then `both` has more


def test_an_extension_may_take_a_preference_back() -> None:
    spec = tm.loads(LANES)
    fast, unsure = results(case("fast", v=20.0), case("unsure", v=12.0, certain=False))
    assert tm.compare(tm.rulebook(spec, "lanes"), unsure, fast).outcome == "better"
    assert tm.compare(tm.rulebook(spec, "careful"), unsure, fast).outcome == "worse"


def test_equal_ranks_do_not_make_up_for_each_other() -> None:
    spec = tm.loads(LANES + "\nrulebook level no_contact > town ~ gentle\n")
    fast, hard = results(FAST, HARD)
    assert tm.compare(tm.rulebook(spec, "level"), fast, hard).outcome == "incomparable"


def test_an_equal_shares_what_its_equals_outrank() -> None:
    """`town` ranks as `gentle`, which outranks `no_contact`: so `town` does, though nobody wrote it."""
    spec = tm.loads(LANES + "\nrulebook level town ~ gentle, gentle > no_contact\n")
    book = tm.rulebook(spec, "level")
    fast, near = results(FAST, NEAR)
    assert tm.compare(book, near, fast).outcome == "better"


def test_what_is_undefined_is_worse_than_any_violation() -> None:
    book = tm.rulebook(tm.loads(LANES), "lanes")
    blind, near, worse = results(case("blind", gap=None), NEAR, case("worse", gap=-99.0))
    assert violations(book, blind)["no_contact"] == Violation(2, math.inf)
    assert violations(book, blind)["town"] == Violation(0, 0.0)
    assert tm.compare(book, worse, blind).outcome == "better"
    assert tm.compare(book, near, worse).outcome == "better"
    assert tm.compare(book, blind, blind).outcome == "equal"


def test_outside_its_contract_nothing_is_good() -> None:
    """Rules are evaluated with a speed that the contract excludes; it is not preferred for what they say."""
    book = tm.rulebook(tm.loads(LANES), "lanes")
    backwards, fast = results(case("backwards", v=-1.0), FAST)
    assert backwards.rules["town"].verdict == "satisfied"
    assert set(violations(book, backwards).values()) == {Violation(2, math.inf)}
    assert tm.compare(book, fast, backwards).outcome == "better"


def test_of_a_broken_constraint_nothing_is_good() -> None:
    text = LANES + "\nparam low : 1 = 1\nparam high : 1 = 2\nconstrain low <= high\n"
    evaluator = tm.Evaluator(tm.loads(text))
    broken = evaluator.case({**case("broken"), "params": {"low": 3}})
    sound = evaluator.case(FAST)
    assert tm.compare(tm.rulebook(tm.loads(text), "lanes"), sound, broken).outcome == "better"


def test_a_run_is_as_bad_as_its_worst_cycle() -> None:
    book = tm.rulebook(tm.loads(LANES), "strict")
    fine, fast, faster = results(case("fine"), FAST, case("faster", v=30.0))
    assert tm.compare(book, [fine, faster], [fast, fast, fast]).outcome == "worse"
    assert tm.compare(book, [fine, fast], [fast]).outcome == "equal"


def test_a_batch_is_chosen_from() -> None:
    spec = tm.loads(LANES)
    cases = [FAST, HARD, NEAR, case("fine"), case("outside", v=-1.0), case("blind", gap=None)]
    columns = {
        name: np.array([each["signals"]["plan"][name] for each in cases], dtype=float)
        for name in ("t", "v", "gap", "a")
    }
    batch = tm.Evaluator(spec).batch({"plan": columns, "certain": np.ones(len(cases), dtype=bool)})
    for name in ("lanes", "strict", "as_one", "careful"):
        book = tm.rulebook(spec, name)
        one_by_one, at_once = tm.choose(book, results(*cases)), tm.choose(book, batch)
        assert at_once == one_by_one
    assert at_once.best == (3,)


def test_bare_verdicts_will_do() -> None:
    book = tm.rulebook(tm.loads(LANES), "lanes")
    fine = dict.fromkeys(book.rules, ("satisfied", 1.0))
    assert tm.compare(book, {**fine, "town": ("violated", -1.0)}, fine).outcome == "worse"
    with pytest.raises(TrackmarshalError, match="`gentle`") as error:
        tm.choose(book, [fine, {"no_contact": ("satisfied", 1.0), "town": ("satisfied", 1.0)}])
    assert error.value.code == "E409"
    with pytest.raises(TrackmarshalError, match="no candidate"):
        tm.choose(book, [])


def test_a_rulebook_that_is_none() -> None:
    spec = tm.loads(LANES)
    with pytest.raises(TrackmarshalError, match="no rulebook `carefull`") as error:
        tm.rulebook(spec, "carefull")
    assert (error.value.code, error.value.help) == ("E408", "did you mean `careful`?")


def test_two_rulebooks_of_one_name_are_not_guessed_between(tmp_path: Path) -> None:
    rules = 'module rules\n\nevent e\n\nrule r "R"\n  require e\n'
    (tmp_path / "rules.spec").write_text(rules)
    for name in ("one", "two"):
        (tmp_path / f"{name}.spec").write_text(f"module {name}\n\nuse rules\n\nrulebook same r\n")
    with pytest.raises(TrackmarshalError, match="more than one rulebook is called `same`") as error:
        tm.rulebook(tm.load(tmp_path), "same")
    assert error.value.code == "E408"


def test_a_rulebook_builds_on_one_of_another_module(tmp_path: Path) -> None:
    (tmp_path / "base.spec").write_text(LANES.replace("module lanes", "module base"))
    text = "module finer\n\nuse base\n\nrulebook finer\n  refines strict\n  no_contact > sure\n"
    (tmp_path / "finer.spec").write_text(text)
    book = tm.rulebook(tm.load(tmp_path), "finer")
    assert book.rules == ("no_contact", "town", "gentle", "sure")
    assert book.above == (frozenset(), frozenset({0}), frozenset({0, 1}), frozenset({0, 1, 2}))


def test_a_rule_by_itself_takes_part() -> None:
    book = tm.rulebook(tm.loads(LANES + "\nrulebook single\n  town, sure\n"), "single")
    assert book.groups == (("town",), ("sure",))


@pytest.mark.parametrize("line", ["town > gentle", "gentle > town", "town ~ gentle", "town & gentle"])
def test_what_refines_may_rank_what_was_not(line: str) -> None:
    assert compile_text(LANES + f"\nrulebook more\n  refines lanes\n  {line}\n").errors == []


# The command ------------------------------------------------------------------------------------------------------


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lanes.spec").write_text(LANES)
    return tmp_path


def written(*cases: dict[str, Any]) -> str:
    Path("cases.jsonl").write_text("".join(json.dumps(each) + "\n" for each in cases))
    return "cases.jsonl"


@pytest.mark.usefixtures("here")
def test_the_command_tells_who_beats_whom() -> None:
    status, out, err = run_command(
        "choose", "lanes.spec", written(FAST, HARD, NEAR, case("outside", v=-1.0)), "--rulebook", "lanes"
    )
    assert (status, err) == (1, "")
    assert out.splitlines() == [
        "rulebook lanes: Contact before manners",
        "violation of       fast        hard        near      outside",
        "no_contact         -           -           by 0.5 m  undefined",
        "town               by 22 km/h  -           -         undefined",
        "gentle (advisory)  -           by 5 m/s^2  -         undefined",
        "outside: input: D216 plan.v[0]: -1.0 m/s is outside [0, 60], and 1 more",
        "outside: all rules count as undefined, since what they say cannot be relied on",
        "fast and hard are incomparable: gentle for fast, town for hard",
        "fast is better than near: no_contact",
        "fast is better than outside: no_contact",
        "chosen: fast (UNSAFE), the first given of 2 that no other one beats",
    ]


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("backend", ["numpy", "reference", "auto"])
def test_the_command_in_json(backend: str) -> None:
    arguments = ("--rulebook", "strict", "--format", "json", "--backend", backend)
    status, out, _ = run_command("choose", "lanes.spec", written(FAST, HARD, NEAR), *arguments)
    said = json.loads(out)
    assert run_command("choose", "lanes.spec", "cases.jsonl", "--rulebook", "strict", "--json")[1] == out
    assert status == 0  # what is chosen brakes hard, which is advisory
    assert (said["rulebook"], said["best"], said["chosen"], said["alone"]) == ("strict", ["hard"], "hard", True)  # fmt: skip
    assert [each["safe"] for each in said["candidates"]] == [False, True, False]
    assert said["candidates"][2]["violations"]["no_contact"] == {"grade": 1, "size": 0.5}
    assert said["compared"][0] == {
        "first": "fast", "second": "hard", "outcome": "worse", "for": [], "against": ["town"],
    }  # fmt: skip


@pytest.mark.usefixtures("here")
def test_equal_candidates_are_said_to_be_equal() -> None:
    status, out, _ = run_command(
        "choose", "lanes.spec", written(case("one"), case("two")), "--rulebook", "lanes"
    )
    assert status == 0
    assert out.splitlines()[-2:] == [
        "one and two are equal",
        "chosen: one (safe), the first given of 2 that no other one beats",
    ]


@pytest.mark.usefixtures("here")
def test_the_only_rulebook_need_not_be_named() -> None:
    assert run_command("choose", "lanes.spec", written(FAST))[2].startswith(
        "error[E408]: the spec has more than one"
    )
    Path("lanes.spec").write_text(LANES[: LANES.index("rulebook strict")])
    assert run_command("choose", "lanes.spec", written(FAST))[:1] == (1,)
    Path("lanes.spec").write_text(LANES[: LANES.index("rulebook lanes")])
    assert "the spec has no rulebook" in run_command("choose", "lanes.spec", written(FAST))[2]


@pytest.mark.usefixtures("here")
def test_of_data_that_cannot_be_read_nothing_is_chosen() -> None:
    written(FAST, HARD)
    with Path("cases.jsonl").open("a") as stream:
        stream.write("{\n")
    status, out, err = run_command("choose", "lanes.spec", "cases.jsonl", "--rulebook", "lanes")
    assert (status, out) == (2, "")
    assert "error[D101]" in err
    for cases, words in (((), "there is no candidate"), ((FAST, FAST), "two candidates are called `fast`")):
        status, out, err = run_command("choose", "lanes.spec", written(*cases), "--rulebook", "lanes")
        assert (status, out) == (2, "")
        assert f"error[E409]: {words}" in err
    left_out = run_command("choose", "lanes.spec", written(FAST), "--rulebook", "lanes", "--rule", "town")
    assert left_out[0] == 2
    assert "nothing is said of `no_contact`, `gentle`" in left_out[2]


@pytest.mark.usefixtures("here")
def test_rules_over_the_run_are_not_those_of_a_case() -> None:
    Path("lanes.spec").write_text(LANES.replace("require   certain", "require   once certain"))
    status, _, err = run_command("choose", "lanes.spec", written(FAST), "--rulebook", "lanes")
    assert status == 2
    assert "error[E407]" in err
    chosen = ("--rule", "no_contact", "--rule", "town", "--rule", "gentle")
    assert run_command("choose", "lanes.spec", written(FAST), "--rulebook", "lanes", *chosen)[0] == 1


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("chosen", [(), ("--rule", "no_contact", "--rule", "gentle")])
def test_a_rule_over_the_run_that_is_ranked_is_not_to_be_left_out(chosen: tuple[str, ...]) -> None:
    """It was said to leave it out, and of whoever did to evaluate it: what compares by such a rulebook is a replay."""
    remembering = LANES.replace(
        "  for all   p in plan\n  require   p.v <=", "  require   once plan.last.v <="
    )
    Path("lanes.spec").write_text(remembering)
    status, _, err = run_command("choose", "lanes.spec", written(FAST), "--rulebook", "lanes", *chosen)
    assert status == 2
    assert "error[E407]: `town` is a rule over the run" in err
    assert "`trackmarshal replay ... --rulebook lanes`" in err
