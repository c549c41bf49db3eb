"""What of a baseline's entries counts as less than was accepted."""

from __future__ import annotations

import pytest

from trackmarshal.trace.baseline import Content, accepted, changes

STAGES: Content = {"stage S-1": {"counts": ["rule"]}, "stage S-2": {"counts": ["test"]}}
WHOLE: Content = {f"gate {stage}, covered": {"requirements": ["*"]} for stage in ("S-1", "S-2")}
ONE: Content = {"gate S-1, covered": {"requirements": ["*"]}}


def weaker(before: Content, now: Content) -> list[str]:
    return [str(change) for change in changes(before, now) if change.weaker]


@pytest.mark.parametrize(
    ("gate", "left"),
    [
        ({}, ""),
        (WHOLE, ""),
        (ONE, "S-2"),
        ({"gate S-1, partial": {"requirements": ["*"]}}, "S-1, S-2"),
        ({**WHOLE, "gate S-2, covered": {"requirements": ["R-1"]}}, "S-2"),
    ],
)
def test_a_gate_that_is_written_down_demands_no_less_than_none(gate: Content, left: str) -> None:
    said = [f"gate: it was every cell, and is less than that at {left}"] if left else []
    assert weaker(STAGES, {**STAGES, **gate}) == said


def test_without_a_gate_more_is_demanded_than_by_any() -> None:
    assert weaker({**STAGES, **ONE}, STAGES) == []
    assert weaker({**STAGES, **WHOLE}, {**STAGES, **ONE}) == ["gate S-2, covered is gone"]


REPORT: Content = {"report r.xml at S-1": {"tool": "ctest"}}
MISSING: Content = {"report r.xml at S-1": {"tool": "ctest", "may be missing": "yes"}}
CLAIMS = "(that it is evidence of this kind is for somebody to say)"
PAGE: Content = {"evidence docs/a.md at S-1": {"requirements": ["R-1"]}}
EXCUSES = "(it may be missing, and other evidence is not asked for then)"


def of_review(report: Content) -> Content:
    return {key: {**entry, "methods": ["review"]} for key, entry in report.items()}


@pytest.mark.parametrize(
    ("before", "now", "said"),
    [
        ({}, REPORT, ""),
        ({}, MISSING, f" is new {EXCUSES}"),
        ({}, PAGE, ""),
        ({}, of_review(PAGE), f" is new {CLAIMS}"),
        ({}, of_review(REPORT), f" is new {CLAIMS}"),
        (REPORT, MISSING, ": its may be missing changed from nothing to yes"),
        (REPORT, of_review(REPORT), f": in its methods `review` came {CLAIMS}"),
        (PAGE, of_review(PAGE), f": in its methods `review` came {CLAIMS}"),
        (of_review(PAGE), PAGE, ": in its methods `review` left"),
        (MISSING, of_review(MISSING), f": in its methods `review` came {EXCUSES}"),
        (of_review(MISSING), MISSING, ": in its methods `review` left"),
    ],
)
def test_a_report_that_may_be_missing_excuses_and_a_method_claims(
    before: Content, now: Content, said: str
) -> None:
    (name,) = now
    assert weaker(before, now) == [f"{name}{said}"] * bool(said)
    unasked = [change.unasked for change in changes(before, now) if change.told]
    assert unasked == [True] * said.endswith((EXCUSES, CLAIMS))  # older acceptances have no name for it


@pytest.mark.parametrize("key", ["method M-1", "work WK-1", "tool T-1"])
def test_a_title_is_held_from_the_next_acceptance_on(key: str) -> None:
    """A baseline that was accepted before titles were held is as good as ever."""
    assert list(changes({key: {"equations": "3"}}, {key: {"equations": "3", "title": "proof"}})) == []
    assert weaker({key: {"title": "proof"}}, {key: {"title": "a look"}}) == [
        f"{key}: its title changed from proof to a look"
    ]


@pytest.mark.parametrize(
    ("key", "field", "called"),
    [
        ("evidence docs/a.md at S-1", "sha256", "contents"),
        ("scenario s.yaml", "recording", "contents"),
        ("analysis AN-1", "evidence sha256", "evidence"),
        ("assumption A-1", "evidence sha256", "evidence"),
    ],
)
def test_a_file_that_is_gone_is_told_where_it_is_missed_or_here(key: str, field: str, called: str) -> None:
    before: Content = {key: {field: "a" * 64}}
    assert list(changes(before, {key: {}})) == []
    said = [f"{key}: its {called} changed (there is none any more)"]
    assert [str(change) for change in changes(before, {key: {}}, missed=False)] == said


def case(text: str, meant: str = "", title: str = "at it") -> Content:
    """A rule with one test, as baselines of before held it, or with what that comes to."""
    return {
        "rule slow": {},
        f"test slow: {title}": {
            "expects": "satisfied",
            "text": text,
            **({"text, worked out": meant} if meant else {}),
        },
    }


@pytest.mark.parametrize(
    ("before", "now", "less"),
    [
        (case("a"), case("a", "x"), False),
        (case("a"), case("a", "x", "on it"), False),
        (case("a"), case("b", "x"), True),
        (case("a", "x"), case("b", "x"), False),
        (case("a", "x"), case("b", "x", "on it"), False),
        (case("a", "x"), case("a", "y"), True),
        (case("a", "x"), case("a", "y", "on it"), True),
        (case("a", "x"), case("a"), True),
    ],
)
def test_what_a_test_comes_to_is_held_from_the_next_acceptance_on(
    before: Content, now: Content, less: bool
) -> None:
    """Until then what is written of it counts; afterwards it may be written in another way."""
    assert len(weaker(before, now)) == less


@pytest.mark.parametrize(
    "ways",
    [
        # What is said is what somebody was told, step by step; less that was accepted may be more again.
        [{"asil": "D"}, {"asil": "A"}, {"asil": "B"}],
        [{"asil": "D"}, {"asil": "C"}, {"asil": "A"}],
        [{"statement": "a"}, {"statement": "b"}, {"statement": "c"}],
        [{"refines": ["R-1", "R-2"]}, {"refines": ["R-2"]}, {"refines": ["R-3"]}],
        [{"refines": ["R-1", "R-2"]}, {"refines": ["R-2"]}, {"refines": ["R-2", "R-3"]}],
    ],
)
def test_steps_that_were_accepted_lead_all_the_way(ways: list[dict[str, str | list[str]]]) -> None:
    steps: list[Content] = [{"requirement R-9": dict(one)} for one in ways]
    named = [text for before, now in zip(steps, steps[1:]) for text in weaker(before, now)]
    less = [one for one in changes(steps[0], steps[-1]) if one.weaker]
    assert less
    assert all(accepted(one, named) for one in less)
    assert not any(accepted(one, named[:0]) for one in less)


@pytest.mark.parametrize(
    ("text", "enough"),
    [
        ("requirement R-9: its asil changed from D to A", True),
        ("requirement R-9: its asil changed from D to QM", True),
        ("requirement R-9: its asil changed from D to B", False),
        ("requirement R-9: its status changed from approved to A", False),
        ("requirement R-9: in its refines `R-1` left", False),
        ("requirement R-9: it says something else", False),
        ("requirement R-9: its asil changed from D to 2026-01-01", False),
        ("requirement R-9 is gone", True),
        ("requirement R-90 is gone", False),
        ("requirement R-9 is new", False),
    ],
)
def test_an_acceptance_says_what_became_less(text: str, enough: bool) -> None:
    (less,) = changes({"requirement R-9": {"asil": "D"}}, {"requirement R-9": {"asil": "A"}})
    assert accepted(less, [text]) is enough


@pytest.mark.parametrize(("kind", "field", "before", "now"), [
    ("requirement", "refines", ["a", "b"], []), ("waiver", "stages", [], ["a", "b"]), ("evidence", "requirements", [], ["a", "b"]),
])  # fmt: skip
@pytest.mark.parametrize(("said", "enough"), [
    (["`a`"], False), (["`a`, `c`"], False), (["`a`, `b`"], True), (["`b`", "`a`"], True), (["`a`", "`a`"], False), ([], False),
])  # fmt: skip
def test_an_acceptance_names_each_of_a_list(
    kind: str, field: str, before: list[str], now: list[str], said: list[str], enough: bool
) -> None:
    """Who accepted that one of them left, or came, has accepted nothing of the others; and what left has not come."""
    own = {"methods": ["review"]}
    (less,) = (c for c in changes({f"{kind} x": {**own, field: before}}, {f"{kind} x": {**own, field: now}}) if c.weaker)  # fmt: skip
    verb, other = ("left", "came") if before else ("came", "left")
    assert accepted(less, [f"{kind} x: in its {field} {names} {verb}" for names in said]) is enough
    assert not accepted(less, [f"{kind} x: in its {field} `a`, `b` {other}"])


def test_a_count_that_was_accepted_may_be_more_again() -> None:
    (less,) = changes(
        {"project": {"boundary tests a rule": "3"}}, {"project": {"boundary tests a rule": "2"}}
    )
    for text, enough in (("3 to 1", True), ("3 to 2", True), ("4 to 3", False), ("3 to 2026-01-01", False)):
        assert accepted(less, [f"project: its boundary tests a rule changed from {text}"]) is enough


@pytest.mark.parametrize(
    "text",
    ["rule x: its meaning changed", "rule x: it says something else (weaker: 3 of 9 recorded cycles differ)"],
)
def test_words_of_earlier_versions_count(text: str) -> None:
    (less,) = changes({"rule x": {"meaning": "a" * 64}}, {"rule x": {"meaning": "b" * 64}})
    assert accepted(less, [text])


def test_parts_of_the_world_are_held_by_what_belongs_to_them() -> None:
    """One that is gone takes pairs with it, of which each is told; and of one that is new, its pairs are new."""
    part: Content = {"subsystem TP": {"title": "others", "description": "busses, cars"}}
    other: Content = {"subsystem TP": {"title": "others", "description": "busses"}}
    assert list(changes({}, part)) == []
    assert weaker(part, other) == ["subsystem TP: its description changed from busses, cars to busses"]
    assert list(changes(part, {})) == []
    assert [change.after for change in changes({}, part, missed=False)] == ["there"]


def test_which_part_is_the_vehicle_is_held_from_the_next_acceptance_on() -> None:
    earlier: Content = {"subsystem TP": {"title": "others"}}
    others: Content = {"subsystem TP": {"title": "others", "role": "environment"}}
    vehicle: Content = {"subsystem TP": {"title": "others", "role": "vehicle"}}
    assert list(changes(earlier, vehicle)) == []
    assert weaker(others, vehicle) == ["subsystem TP: its role changed from environment to vehicle"]


@pytest.mark.parametrize(
    ("number", "ran", "said"),
    [
        ("5", "5", []),
        ("5", "4", ["its number of those that were not skipped changed from 5 to 4"]),
        ("6", "5", []),  # one more, which is skipped
        ("4", "4", ["its number changed from 5 to 4"]),  # told once
        ("4", "3", ["its number changed from 5 to 4", "its number of those that were not skipped changed from 5 to 3"]),
    ],
)  # fmt: skip
def test_tests_of_another_runner_that_are_skipped(number: str, ran: str, said: list[str]) -> None:
    key = "external-tests R-1 in r.xml at S-1"
    report: Content = {"report r.xml at S-1": {"tool": "ctest"}}
    before: Content = {**report, key: {"number": "5", "not skipped": "5"}}
    now: Content = {**report, key: {"number": number, "not skipped": ran}}
    assert sorted(weaker(before, now)) == [f"{key}: {one}" for one in said]
    earlier: Content = {**report, key: {"number": "5"}}  # which does not hold it
    assert weaker(earlier, now) == [f"{key}: {one}" for one in said if one.startswith("its number changed")]


@pytest.mark.parametrize(
    ("field", "old", "new", "less"),
    [
        ("severity", "S2", "S3", False),
        ("severity", "S3", "S2", True),
        ("exposure", "E1", "E4", False),
        ("controllability", "C3", "C0", True),
        ("severity", "S3", "", True),
    ],
)
def test_a_hazard_rated_higher_is_no_less(field: str, old: str, new: str, less: bool) -> None:
    assert bool(weaker({"hazard H-1": {field: old}}, {"hazard H-1": {field: new}})) == less


@pytest.mark.parametrize(
    ("key", "field"), [("stage S-1", "only if there is any"), ("report r.xml at S-1", "may be missing")]
)
def test_what_lets_something_off_may_go(key: str, field: str) -> None:
    assert weaker({key: {"tool": "ctest", field: "yes"}}, {key: {"tool": "ctest"}}) == []
    assert weaker({key: {"tool": "ctest"}}, {key: {"tool": "ctest", field: "yes"}}) != []


@pytest.mark.parametrize(
    ("covered", "partial", "less"),
    [
        (["R-1", "R-2"], [], []),
        (["*"], [], []),
        (["R-1"], ["R-2"], []),
        (["R-1"], [], ["gate S-1, partial is gone"]),
        ([], ["R-2"], ["gate S-1, partial: in its requirements `R-1` left"]),
        (["R-3"], ["R-1"], ["gate S-1, partial: in its requirements `R-2` left"]),
    ],
)
def test_to_be_covered_is_more_than_in_part(covered: list[str], partial: list[str], less: list[str]) -> None:
    before: Content = {"gate S-1, partial": {"requirements": ["R-1", "R-2"]}}
    parts = {"gate S-1, covered": covered, "gate S-1, partial": partial, "gate S-2, covered": ["*"]}
    now: Content = {key: {"requirements": list(value)} for key, value in parts.items() if value}
    assert weaker(before, now) == less


@pytest.mark.parametrize(("origin", "named"), [("field", True), ("synthetic", False), ("simulated", False)])
def test_that_a_new_recording_comes_from_the_field_is_for_somebody_to_say(origin: str, named: bool) -> None:
    """What it is made of does not tell: a generated one with another name in its first line is another file."""
    now: Content = {"scenario real.tmrec.jsonl": {"origin": origin, "expect": "no_fire"}}
    said = ["scenario real.tmrec.jsonl is new (that it was recorded on a vehicle is for somebody to say)"]
    assert weaker({}, now) == said * named
    assert [change.unasked for change in changes({}, now)] == [named]
    assert weaker(now, now) == []


@pytest.mark.parametrize(("kind", "field", "old", "new", "less"), [
    ("hazard", "severity", "S2", "S3", False), ("hazard", "severity", "S3", "S2", True), ("hazard", "exposure", "E4", "", True),
    ("hazard", "controllability", "C2", "S3", True), ("hazard", "situation", "a" * 64, "a" * 63 + "b", True),
    ("hazard", "rationale", "a" * 63 + "b", "a" * 64, True), ("safety-goal", "severity", "S2", "S3", True),
    ("waiver", "expires", "2026-12-31", "2027-01-01", True), ("waiver", "expires", "2027-01-01", "2026-12-31", False),
    ("waiver", "granted", "2026-02-01", "2026-01-01", True),
    ("rule", "source", "a paper", "another paper", False), ("rule", "source", "a paper", "TBD", True), ("rule", "source", "a paper", "", True),
])  # fmt: skip
def test_what_has_an_order_is_less_in_one_direction_alone(
    kind: str, field: str, old: str, new: str, less: bool
) -> None:
    """And of a text, which has none, nobody knows."""
    before, now = ({"kept": "a", **({field: text} if text else {})} for text in (old, new))
    found = [c for c in changes({f"{kind} X-1": {**before}}, {f"{kind} X-1": {**now}}) if c.field == field]
    assert [c.weaker for c in found] == [less]


SHOWN: Content = {
    "evidence docs/a.md at S-1": {
        "sha256": "a" * 64,
        "requirements": ["R-1"],
        "methods": ["review"],
        "answers": ["R-1: review"],
    }
}


@pytest.mark.parametrize(("before", "name", "changed", "gone"), [
    (SHOWN, "evidence docs/b.md at S-1", {}, False), (SHOWN, "evidence docs/b.md at S-2", {}, True),
    (SHOWN, "evidence docs/b.md at S-1", {"answers": ["R-1: analysis"]}, True), (SHOWN, "evidence docs/b.md at S-1", {"sha256": "b" * 64}, True),
    ({"evidence docs/a.md at S-1": {"requirements": ["R-1"]}}, "evidence docs/b.md at S-1", {}, True),
    ({"requirement R-1": {"statement": "a" * 64}}, "requirement R-2", {}, True), ({"rule x": {"meaning": "a" * 64}}, "rule y", {}, True),
    ({"fault a.yaml x": {"put in": "a"}}, "fault a.yaml y", {}, True), ({"stage S-1": {"counts": ["rule"]}}, "stage S-2", {}, True),
])  # fmt: skip
def test_what_is_called_otherwise_is_gone_unless_its_name_says_nothing(
    before: Content, name: str, changed: dict[str, str | list[str]], gone: bool
) -> None:
    """A page that shows the same is the same one elsewhere, as far as all else of it is; an id is never given up without a word."""
    ((key, entry),) = before.items()
    assert weaker(before, {name: {**entry, **changed}})[: 1 if gone else None] == [f"{key} is gone"] * gone


def replayed(*rules: str) -> Content:
    return {"scenario s.yaml": {"rules": list(rules)}}


@pytest.mark.parametrize(("there", "less"), [(["slow"], True), (["slow", "near"], True), ([], False)])
def test_a_scenario_replayed_without_a_rule_that_is_there_shows_less(there: list[str], less: bool) -> None:
    """Also where another rule that it was replayed with is gone, which is told of that."""
    rules: Content = {f"rule {name}": {} for name in ("slow", "near")}
    now: Content = {**replayed(), **{f"rule {name}": {} for name in there}}
    said = [one for one in weaker({**replayed("near", "slow"), **rules}, now) if one.startswith("scenario")]
    assert said == ["scenario s.yaml: in its rules `near`, `slow` left"] * less


@pytest.mark.parametrize("kind", ["rule", "assumption"])
def test_a_test_that_is_gone_is_told_where_what_it_tests_is_there(kind: str) -> None:
    test: Content = {"test slow: at it": {"expects": "satisfied"}}
    there: Content = {f"{kind} slow": {}}
    assert weaker({**there, **test}, there) == ["test slow: at it is gone"]
    assert weaker({**there, **test}, {}) == [f"{kind} slow is gone"]


def test_of_two_tests_alike_one_that_is_left_under_another_title_is_one() -> None:
    assert weaker({**case("a", "x", "at it"), **case("a", "x", "on it")}, case("a", "x", "there")) == [
        "test slow: on it is gone"
    ]


def test_what_a_test_was_is_not_there_under_another_title_while_it_is_another_one() -> None:
    assert weaker(case("a", "x"), {**case("b", "y"), **case("a", "x", "on it")}) == [
        "test slow: at it: it was x, and is y"
    ]


@pytest.mark.parametrize("key", ["link-schema", "argument", "waiver W-1", "unreviewed requirement R-1"])
def test_what_takes_the_place_of_more_or_excuses_is_less_where_it_is_new(key: str) -> None:
    assert weaker({}, {key: {"says": "a" * 64}}) == [f"{key} is new"]


def test_an_objection_that_is_gone_is_less() -> None:
    assert weaker({"defeater D-1": {"state": "open"}}, {}) == ["defeater D-1 is gone"]
