"""Warnings are about the text alone: they change no verdict, and what allows one allows it for one rule."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from support.shared import REPOSITORY
from trackmarshal.cli.check import examine
from trackmarshal.evaluation import BACKENDS, Evaluator
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.semantics.warnings.codes import WARNINGS
from trackmarshal.source import SourceFile
from trackmarshal.syntax.format import format_text

HEAD = """module made
signal ego : state { v: m/s, heading: rad }
predicate standing() = ego.v == 0 m/s
"""
ALLOW = '  allow     W301 because "why"\n'


def compiled(folder: Path, content: str) -> Compiled:
    path = folder / "made.spec"
    path.write_text(HEAD + content, "utf-8")
    return compile_paths([path], folder)


def rule(name: str, formula: str, clauses: str = "") -> str:
    return f'rule {name} "r"\n{clauses}  require   {formula}\n'


def test_the_shipped_specs_are_free_of_warnings() -> None:
    assert examine(compile_paths([REPOSITORY / "specs"], REPOSITORY), REPOSITORY) == []


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_warning_changes_no_verdict(backend: str, tmp_path: Path) -> None:
    """A bare number is a number of rad, as it was."""
    content = rule("bare", "ego.heading <= 1.5 and ego.v == 3 m/s") + rule(
        "tagged", "ego.heading <= 1.5 rad and ego.v == 3 m/s", ALLOW
    )
    made = compiled(tmp_path, content)
    assert [f.code for f in made.found] == ["W302", "W301"]
    assert made.errors == []
    evaluator = Evaluator(made.spec, None, backend)
    for heading, v in ((1.0, 3.0), (2.0, 3.0), (1.0, 3.5)):
        case = evaluator.read({"signals": {"ego": {"heading": heading, "v": v}}})
        (result,) = evaluator.evaluate([case])
        bare, tagged = result.rules["bare"], result.rules["tagged"]
        assert (bare.verdict, bare.margin) == (tagged.verdict, tagged.margin)
        assert bare.verdict == ("satisfied" if (heading, v) == (1.0, 3.0) else "violated")


def test_what_one_rule_allows_is_not_allowed_to_another(tmp_path: Path) -> None:
    """Even where the text is the same: that of a definition."""
    assert compiled(tmp_path, rule("a", "standing", ALLOW)).found == ()
    assert compiled(tmp_path, "").found == ()
    made = compiled(tmp_path, rule("a", "standing", ALLOW) + rule("b", "not standing"))
    assert [(f.code, f.span.text) for f in made.found] == [("W301", "ego.v == 0 m/s")]


STATE = """state moving : { resting, rolling } starts resting
  becomes rolling when ego.v != 0 m/s
    remember v = if ego.v == 1 m/s then 0 m/s else ego.v
  becomes resting when ego.v < 0.1 m/s
"""


def test_what_a_state_is_made_of_is_the_rules_that_ask_for_it(tmp_path: Path) -> None:
    asked = "moving is rolling implies moving.v >= 0 m/s"
    made = compiled(tmp_path, STATE + rule("a", asked))
    assert [(f.code, f.span.text) for f in made.found] == [
        ("W301", "ego.v != 0 m/s"),
        ("W301", "ego.v == 1 m/s"),
    ]
    assert compiled(tmp_path, STATE + rule("a", asked, ALLOW)).found == ()
    assert len(compiled(tmp_path, STATE + rule("a", asked, ALLOW) + rule("b", asked)).found) == 2
    assert [f.code for f in compiled(tmp_path, STATE).found] == ["W304"]


def test_a_reason_is_part_of_what_a_rule_says(tmp_path: Path) -> None:
    prints = set()
    for clauses in ("", ALLOW, ALLOW.replace("why", "because")):
        made = compiled(tmp_path, rule("a", "standing", clauses)).spec.rule("a")
        assert made is not None
        prints.add(made.fingerprint)
    assert len(prints) == 3


def test_every_warning_can_be_explained() -> None:
    from trackmarshal.cli.catalogue import catalogue

    numbers = range(301, 319)
    assert {"E220", *(f"W{number}" for number in numbers)} == WARNINGS
    assert catalogue().keys() >= WARNINGS


def test_an_allowance_is_laid_out_as_the_clauses_beside_it() -> None:
    text = 'rule a\n  allow W301,W302   because\n "why"\n  require a < b\n'
    laid = 'rule a\n  allow     W301, W302 because "why"\n  require   a < b\n'
    assert format_text(SourceFile("t.spec", text)) == laid
    assert format_text(SourceFile("t.spec", laid)) == laid


def test_what_is_shared_is_looked_at_once(tmp_path: Path) -> None:
    """Written out, the last of these has more than 10^18 operands."""
    lets = "".join(f"  let x{i + 1} = x{i} + x{i}\n  let y{i + 1} = y{i} + y{i}\n" for i in range(60))
    first = "  let x0 = ego.v\n  let y0 = ego.heading\n"
    made = compiled(tmp_path, rule("a", "x60 == 1 m/s and y60 < 90", first + lets))
    assert [f.code for f in made.found] == ["W301", "W302"]
    for step in ("{0} * {0}", "max({0}, {0})", "if ego.v > 1 m/s then {0} else {0}"):
        first = "  let z0 = ego.heading - 90 deg\n  let w0 = 90\n"
        lets = "".join(
            f"  let {x}{i + 1} = {step.format(f'{x}{i}')}\n" for i in range(60) for x in ("z", "w")
        )
        made = compiled(tmp_path, rule("a", "w60 < z60", first + lets))
        assert {f.code for f in made.found} >= {"W310"}


@pytest.mark.parametrize(
    ("formula", "word"),
    [
        ("for all o in objects: o.v < ego.v implies fast", "for all"),
        ("for all o in objects: o.v < ego.v iff fast", "for all"),
        ("exists o in objects: o.v < ego.v xor fast", "exists"),
        ("exists nearest o in objects by o.v: o.v < ego.v implies fast", "exists"),
        ("fast and for all o in objects: o.v < ego.v implies ego.v > 1 m/s", "for all"),
        ("fast or not for all o in objects: exists p in objects: p.v < o.v implies fast", "for all"),
        ("always[0 s, 3 s] fast implies ego.v > 1 m/s", "always"),
        ("for all o in objects: (o.v < ego.v implies fast)", ""),
        ("(for all o in objects: o.v < ego.v) implies fast", ""),
        ("for all o in objects: (o.v < ego.v) implies fast", ""),
        ("for all o in objects: o.v < ego.v and fast", ""),
        ("exists o in objects: o.v < ego.v or fast", ""),
        ("fast implies for all o in objects: o.v < ego.v", ""),
        ("once[0 s, 3 s] fast implies ego.v > 1 m/s", ""),
        ("min(o.v for o in objects else 1 m/s) > 0 m/s implies fast", ""),
    ],
)
def test_where_a_quantifier_ends_is_asked(formula: str, word: str, tmp_path: Path) -> None:
    more = 'signal objects : set of object { v: m/s }\nevent fast "f"\n'
    made = compiled(tmp_path, more + rule("a", formula))
    assert made.errors == []
    assert [(found.code, found.message.split("`")[1]) for found in made.found] == (
        [("W307", word)] if word else []
    )
    allowed = compiled(tmp_path, more + rule("a", formula, '  allow     W307 because "why"\n'))
    assert [found.code for found in allowed.found] == ([] if word else ["W303"])


@pytest.mark.parametrize(
    ("formula", "joined"),
    [
        ("fast implies ego.v <= 3 m/s and slow implies ego.v <= 1 m/s", "ego.v <= 3 m/s and slow"),
        ("fast implies ego.v <= 3 m/s or slow implies ego.v <= 1 m/s", "ego.v <= 3 m/s or slow"),
        ("fast implies slow implies fast and slow implies ego.v <= 1 m/s", "fast and slow"),
        ("fast iff ego.v <= 3 m/s and slow iff ego.v <= 1 m/s", "ego.v <= 3 m/s and slow"),
        ("fast implies ego.v <= 3 m/s and slow iff ego.v <= 1 m/s", "ego.v <= 3 m/s and slow"),
        ("fast xor slow and fast implies ego.v <= 1 m/s", "slow and fast"),
        ("previous fast implies not fast and slow implies ego.v <= 1 m/s", "not fast and slow"),
        ("(fast implies ego.v <= 3 m/s) and (slow implies ego.v <= 1 m/s)", ""),
        ("fast implies (ego.v <= 3 m/s and slow) implies ego.v <= 1 m/s", ""),
        ("fast implies (ego.v <= 3 m/s and slow implies ego.v <= 1 m/s)", ""),
        ("fast and slow implies ego.v <= 3 m/s and slow", ""),
        ("fast implies slow implies ego.v <= 1 m/s and slow", ""),
    ],
)
def test_whether_two_consequences_are_meant_is_asked(formula: str, joined: str, tmp_path: Path) -> None:
    """`a implies b and c implies d` reads as two demands, and demands nothing of b; before the formatter and after it."""
    more = 'event fast "f"\nevent slow "s"\n'
    made = compiled(tmp_path, more + rule("a", formula))
    assert made.errors == []
    assert [(found.code, found.span.text) for found in made.found] == ([("W311", joined)] if joined else [])
    (tmp_path / "made.spec").write_text(
        format_text(SourceFile("made.spec", HEAD + more + rule("a", formula))), "utf-8"
    )
    again = compile_paths([tmp_path / "made.spec"], tmp_path)
    assert [found.code for found in again.found] == (["W311"] if joined else [])


@pytest.mark.parametrize(
    ("formula", "word"),
    [
        ("previous(ego.v) - ego.v <= 3 m/s", "previous"),
        ("previous(ego.v) <= ego.v", "previous"),
        ("fast and not once[0 s, 3 s] (ego.v) * 2 > ego.v", "once"),
        ("weak previous(ego.v) <= ego.v <= 9 m/s", "previous"),
        ("previous(ego.v) <= 3 m/s", ""),
        ("previous (ego.v + 1 m/s) * 2 <= 3 m/s", ""),
        ("previous ((ego.v) - ego.v <= 3 m/s)", ""),
        ("previous ego.v - ego.v <= 3 m/s", ""),
        ("previous(ego.v > 3 m/s) and ego.v > 1 m/s", ""),
        ("previous(fast) iff fast", ""),
    ],
)
def test_how_far_a_temporal_operator_goes_is_asked(formula: str, word: str, tmp_path: Path) -> None:
    made = compiled(tmp_path, 'event fast "f"\n' + rule("a", formula))
    assert made.errors == []
    assert [(found.code, found.message.split("`")[1]) for found in made.found] == (
        [("W308", word)] if word else []
    )


OBJECTS = 'signal objects : set of object { v: m/s, x: m }\nevent fast "f"\n'


@pytest.mark.parametrize(
    ("clauses", "formula", "word"),
    [
        ("", "exists o in objects: (o.v > ego.v implies o.x > 3 m)", "exists"),
        ("", "fast or exists o in objects: ((o.v > ego.v implies o.x > 3 m))", "exists"),
        ("  exists    o in objects\n", "o.v > ego.v implies o.x > 3 m", "exists"),
        ("  for all   o in objects\n  exists    q in objects\n", "q.v > o.v implies o.x > q.x", "exists"),
        ("  for all   o in objects where o.v > ego.v implies fast\n", "o.x > 3 m", "where"),
        ("", "for all o in objects where (o.v > ego.v implies fast): (o.x > 3 m)", "where"),
        ("", "count(o in objects where o.v > ego.v implies fast) <= 3", "where"),
        ("  whenever  ego.v > 3 m/s implies fast\n", "ego.v <= 5 m/s", "whenever"),
        ('  for all   o in objects\n  except    o.v > ego.v implies fast "x"\n', "o.x > 3 m", "except"),
        ("", "once[0 s, 3 s] (fast implies ego.v > 3 m/s)", "once"),
        ("", "eventually[0 s, 3 s] (fast implies ego.v > 3 m/s)", "eventually"),
        ("  whenever  fast\n  within    3 s\n", "ego.v > 3 m/s implies ego.heading > 1 rad", "within"),
        ("", "fast until[0 s, 3 s] (ego.v > 3 m/s implies ego.heading > 1 rad)", "until"),
        ("", "fast since[0 s, 3 s] (ego.v > 3 m/s implies ego.heading > 1 rad)", "since"),
        ("", "count(fast implies ego.v > 3 m/s, last: 3 s) >= 2", "count"),
        ("", "count(fast, reset: ego.v > 3 m/s implies ego.heading > 1 rad) <= 2", "reset"),
        ("", "(ego.v > 3 m/s implies ego.heading > 1 rad) until[0 s, 3 s] fast", ""),
        ("", "(ego.v > 3 m/s implies ego.heading > 1 rad) since[0 s, 3 s] fast", ""),
        ("  for all   o in objects\n", "o.v > ego.v implies o.x > 3 m", ""),
        ("", "for all o in objects: (o.v > ego.v implies o.x > 3 m)", ""),
        ("", "exists o in objects: (o.v > ego.v and (fast implies o.x > 3 m))", ""),
        ("", "exists o in objects: (not (o.v > ego.v) or o.x > 3 m)", ""),
        ("", "exists nearest o in objects by o.x: (o.v > ego.v implies o.x > 3 m)", ""),
        ("  exists    nearest o in objects by o.x\n", "o.v > ego.v implies o.x > 3 m", ""),
        ("  exists    q in objects\n  for all   o in objects\n", "q.v > o.v implies o.x > q.x", ""),
        ("", "always[0 s, 3 s] (fast implies ego.v > 3 m/s)", ""),
        ("", "(exists o in objects: o.v > ego.v) implies fast", ""),
        ("  whenever  fast iff ego.v > 3 m/s\n", "ego.v <= 5 m/s", ""),
        ("", "exists o in objects: (fast implies o.x > 3 m)", ""),
        ("  exists    o in objects\n", "fast implies o.x > 3 m", ""),
        ("  for all   o in objects\n  exists    q in objects\n", "o.v > ego.v implies o.x > q.x", ""),
        ("  exists    o in objects\n  exists    q in objects\n", "o.v > ego.v implies o.x > q.x", "exists"),
        (
            "  exists    o in objects\n  let far = o.x\n  let off = far - 3 m\n",
            "off > 3 m implies fast",
            "exists",
        ),
    ],
)
def test_an_implies_that_others_meet_is_asked_about(
    clauses: str, formula: str, word: str, tmp_path: Path
) -> None:
    """One of which the left side is not so is enough for an `exists`, and is in the range of a `where`."""
    made = compiled(tmp_path, OBJECTS + rule("a", formula, clauses))
    assert made.errors == []
    assert [(found.code, found.message.split("`")[3]) for found in made.found] == (
        [("W313", word)] if word else []
    )
    allow = '  allow     W313 because "why"\n'
    allowed = compiled(tmp_path, OBJECTS + rule("a", formula, allow + clauses))
    assert [found.code for found in allowed.found] == ([] if word else ["W303"])


ALONG = (
    'signal plan : trajectory { t: s increasing, v: m/s }\nevent fast "f"\n'
    "predicate recent = once[0 s, 10 s] fast\npredicate quick(v: m/s) = v > 3 m/s\n"
)


@pytest.mark.parametrize(
    ("formula", "word"),
    [
        ("once[0 s, 10 s] fast implies always p.v <= 3 m/s", "once"),
        ("recent implies always p.v <= 3 m/s", "once"),
        ("always p.v <= 3 m/s or rising(fast)", "rising"),
        ("always (p.v <= 3 m/s or previous fast)", "previous"),
        ("eventually ego.v <= 3 m/s", "eventually"),
        ("eventually quick(plan.last.v)", "eventually"),
        ("p.v <= 3 m/s until fast", "until"),
        ("fast since[0 s, 3 s] p.v <= 3 m/s", "since"),
        ("count(fast, last: 3 s) <= 2", "count"),
        ("count(p.v > 3 m/s, reset: fast) <= 2", "count"),
        ("always (fast implies p.v <= 3 m/s)", ""),
        ("always (not quick(p.v))", ""),
        ("fast implies eventually[0 s, 2 s] p.v <= ego.v", ""),
        ("always eventually p.v <= 3 m/s", ""),
        ("true until p.v <= 3 m/s", ""),
        ("always (count(p.v > 3 m/s) <= 2)", ""),
    ],
)
def test_what_does_not_change_along_a_timeline_is_asked_about(
    formula: str, word: str, tmp_path: Path
) -> None:
    """`once[0 s, 10 s] fast` along a plan is `fast`: what was ten seconds ago, no sample of the plan knows."""
    clause = "  along     plan as p\n"
    made = compiled(tmp_path, ALONG + rule("a", formula, clause))
    assert made.errors == []
    assert [(found.code, found.message.split("`")[1]) for found in made.found] == (
        [("W314", word)] if word else []
    )
    allowed = compiled(tmp_path, ALONG + rule("a", formula, '  allow     W314 because "why"\n' + clause))
    assert [found.code for found in allowed.found] == ([] if word else ["W303"])


@pytest.mark.parametrize("formula", ["recent", "rising(fast)", "count(fast, last: 3 s) <= 2"])
def test_over_the_run_it_changes(formula: str, tmp_path: Path) -> None:
    assert compiled(tmp_path, ALONG + rule("a", formula)).found == ()


@pytest.mark.parametrize(
    ("way", "clauses", "v"),
    [
        ("linear", "", 0.0),
        ("linear", "  whenever  car.v >= 2 m/s\n", 40.0),
        ("linear", "  for all   o in cars where o.v <= 10 m/s\n", 0.0),
        ("step", "", 0.0),
        ("step", "  whenever  car.v >= 2 m/s\n", None),
        ("linear", "  whenever  car.v in [2 m/s, 16 m/s]\n", None),
        ("linear clamp", "", None),
        ("step clamp", "", None),
        ("linear wrap 20 m/s", "", None),
    ],
)
def test_a_table_that_has_no_value_for_an_input_is_asked_about(
    way: str, clauses: str, v: float | None, tmp_path: Path
) -> None:
    """By what the evaluator says of the speed that is named, and not by how tables are read."""
    head = (
        "signal car : state { v: m/s in [0, 40] }\nsignal cars : set of object { v: m/s in [0, 40] }\n"
        f"table distance(v: m/s) -> m = {way}\n  | 2 m/s: 2 m | 16 m/s: 26 m |\n"
    )
    who = "o" if "cars" in clauses else "car"
    demand = f"distance({who}.v) <= 30 m"
    made = compiled(tmp_path, head + rule("a", demand, clauses))
    assert [found.code for found in made.found] == ([] if v is None else ["W315"])
    evaluator = Evaluator(made.spec, None, "reference")
    speeds = [0.0, 1.9, 2.0, 9.0, 16.0, 16.1, 40.0]
    signals = [{"ego": {"v": 0, "heading": 0}, "car": {"v": one}, "cars": [{"v": one}]} for one in speeds]
    results = evaluator.evaluate([evaluator.read({"signals": each}) for each in signals])
    undefined = [one for one, result in zip(speeds, results) if result.rules["a"].verdict == "undefined"]
    assert bool(undefined) == (v is not None)
    if v is not None:
        assert v in undefined
        assert made.found[0].message.endswith(f"may be {v:g} m/s")


WITHIN = "car.v in [2 m/s, 16 m/s]"


@pytest.mark.parametrize(
    ("demand", "clauses"),
    [
        (f"distance(car.v) <= 30 m or not ({WITHIN})", ""),
        (f"distance(car.v) <= 30 m and {WITHIN}", ""),
        (f"({WITHIN} implies distance(car.v) <= 30 m) and car.v <= 60 m/s", ""),
        (f"({WITHIN} implies distance(car.v) <= 30 m) and (car.v > 10 m/s implies car.v <= 60 m/s)", ""),
        ("car.v <= 60 m/s", "  whenever  car.v < 2 m/s or car.v > 16 m/s or distance(car.v) <= 20 m\n"),
        ("o.v <= 60 m/s", "  for all   o in cars where distance(o.v) <= 20 m and o.v in [2 m/s, 16 m/s]\n"),
        ("distance(car.v) <= 30 m", ""),
        ("car.v <= 60 m/s", "  whenever  distance(car.v) <= 20 m\n"),
        ("car.v <= 60 m/s", "  whenever  car.v < 2 m/s or distance(car.v) <= 20 m\n"),
        ("car.v <= (if distance(car.v) <= 20 m then 30 m/s else 39 m/s)", ""),
        ("exists o in cars where distance(o.v) <= 20 m: o.v <= 60 m/s", ""),
    ],
)
def test_a_table_is_asked_about_where_it_decides(demand: str, clauses: str, tmp_path: Path) -> None:
    """What decides without it may stand on either side, and in a condition as well as in a demand: as the evaluator says, so the warning."""
    head = (
        "signal car : state { v: m/s in [0, 40] }\nsignal cars : set of object { v: m/s in [0, 40] }\n"
        "table distance(v: m/s) -> m = linear\n  | 2 m/s: 2 m | 16 m/s: 26 m |\n"
    )
    made = compiled(tmp_path, head + rule("a", demand, clauses))
    evaluator = Evaluator(made.spec, None, "reference")
    signals = [{"car": {"v": v}, "cars": [{"v": v}]} for v in (0.0, 1.9, 2.0, 9.0, 16.0, 16.1, 40.0)]
    results = evaluator.evaluate([evaluator.read({"signals": each}) for each in signals])
    undefined = any(result.rules["a"].verdict == "undefined" for result in results)
    assert ["W315" for found in made.found if found.code == "W315"] == ["W315"] * undefined


@pytest.mark.parametrize("long", [False, True], ids=["on a line", "on several lines"])
@pytest.mark.parametrize(
    "formula",
    [
        "for all o in objects: o.v < ego.v implies fast",
        "for all o in objects: o.v < ego.v iff fast",
        "fast xor exists o in objects: o.v < ego.v xor fast",
        "fast implies for all o in objects: o.v < ego.v implies ego.v > 1 m/s",
        "fast and for all o in objects: o.v < ego.v implies ego.v > 1 m/s",
        "fast or not for all o in objects: exists p in objects: p.v < o.v implies fast",
    ],
)
def test_the_formatter_does_not_answer_where_a_quantifier_ends(
    formula: str, long: bool, tmp_path: Path
) -> None:
    """It wrote the parentheses that the author is asked for, and the warning was gone."""
    if long:
        formula = formula.replace("ego.v", "min(ego.v, " + "100000 m/s, " * 10 + "1 m/s)", 1).replace(
            "p.v", "min(p.v, " + "100000 m/s, " * 10 + "1 m/s)"
        )
    more = 'signal objects : set of object { v: m/s }\nevent fast "f"\n'
    made = compiled(tmp_path, more + rule("a", formula))
    assert [found.code for found in made.found] == ["W307"]
    laid = format_text(SourceFile("made.spec", HEAD + more + rule("a", formula)))
    assert (len(laid.partition("require")[2].strip().splitlines()) > 1) == long
    (tmp_path / "made.spec").write_text(laid, "utf-8")
    again = compile_paths([tmp_path / "made.spec"], tmp_path)
    assert [found.code for found in again.found] == ["W307"]


def test_where_a_quantifier_ends_makes_the_difference(tmp_path: Path) -> None:
    """What the warning is about: of two cars, one is ahead. With what is written first, nothing is demanded."""
    more = 'signal objects : set of object { v: m/s }\nevent fast "f"\n'
    early = rule("early", "for all o in objects: o.v < ego.v implies fast")
    all_of_it = rule("all_of_it", "for all o in objects: (o.v < ego.v implies fast)")
    evaluator = Evaluator(compiled(tmp_path, more + early + all_of_it).spec, None, "reference")
    signals = {"ego": {"v": 2.0, "heading": 0.0}, "objects": [{"v": 1.0}, {"v": 3.0}], "fast": False}
    (result,) = evaluator.evaluate([evaluator.read({"signals": signals})])
    assert {name: one.verdict for name, one in result.rules.items()} == {
        "early": "satisfied",
        "all_of_it": "violated",
    }


COUNTED = """enum flag { green, yellow }
signal truck : state { load: %, steering: deg, flag: flag, v: m/s, a: m, b: m }
event wet "it rains"
table turns(v: m/s) -> 1 = linear clamp | 0: 35 | 20: 5 |
predicate full(part: %) = part <= 0.9
"""


@pytest.mark.parametrize(
    ("demand", "said"),
    [
        ("truck.steering <= case truck.flag { green: 20, yellow: 10 }", ["W302 20", "W302 10"]),
        ("truck.steering <= (if wet then 5 else 10 deg)", ["W302 5"]),
        ("truck.steering <= max(5 deg, min(10, 20 deg))", ["W302 10"]),
        ("truck.steering <= turns(truck.v)", ["W302 turns(truck.v)"]),
        ("truck.load <= (if wet then 80 else 90)", ["W309 80", "W309 90"]),
        ("truck.load <= limit", ["W309 80"]),
        ("full(if wet then 50 else 60)", ["E302 50"]),
        ("truck.steering <= case truck.flag { green: 20 deg, yellow: 0 }", []),
        ("truck.load <= (if wet then 0.8 else 90 %)", []),
        ("full(if wet then truck.load else 50 %)", []),
        ("full(min(truck.a / truck.b, 1))", []),
    ],
)
def test_a_bare_number_is_one_wherever_it_is_chosen(demand: str, said: list[str], tmp_path: Path) -> None:
    """A limit for each flag is written without a unit as easily as one for all of them, and is 57 times or a hundred times as high."""
    let = "  let limit = if wet then 80 else 90 %\n" if "limit" in demand else ""
    made = compiled(tmp_path, COUNTED + rule("a", demand, let))
    assert [f"{found.code} {found.span.text}" for found in made.found] == said


SAID = """signal truck : state { charge: 1, steering: deg, a: m, b: m, v: m/s }
define left -> % = truck.a / truck.b
define slip -> deg = truck.b / truck.a
define part -> 1 = truck.a / truck.b
define turned -> 1 = truck.steering / 1 deg
predicate low(of: %) = of <= 20
predicate low_by(of: %, limit: 1) = of <= limit
predicate sharp(angle: deg) = angle > 30
predicate many(number: 1) = number > 30
"""


@pytest.mark.parametrize(
    ("demand", "said"),
    [
        ("left >= 20", ["W309 20"]),
        ("left + 5 >= 20 %", ["W309 5"]),
        ("slip <= 5", ["W302 5"]),
        ("low(truck.charge)", ["W309 20"]),
        ("sharp(truck.a / truck.b)", ["W302 30"]),
        ("max(5, 20 %) > left", ["W309 5"]),
        ("turned <= 30", []),
        ("truck.steering / 1 deg <= 30", []),
        ("truck.steering * 180 / pi <= 30", []),
        ("truck.steering / pi * 180 + 180 / pi * truck.steering <= 30", []),
        ("truck.steering / (pi / 180) <= 30", []),
        ("truck.steering / (2 * pi) <= 80 %", []),
        ("truck.steering * pi / 180 <= 30", ["W302 30"]),
        ("truck.steering / 2 <= 30", ["W302 30"]),
        ("part <= 20 and many(truck.charge)", []),
        ("left >= 20 % and left <= 1 and slip <= 5 deg and slip > 0", []),
        ("low_by(truck.charge, 0.2)", []),
    ],
)
def test_what_a_definition_says_of_a_number_is_what_it_is(
    demand: str, said: list[str], tmp_path: Path
) -> None:
    """Whatever it is made of: of a quotient, nothing else says whether it is a share, an angle or neither."""
    made = compiled(tmp_path, SAID + rule("a", demand))
    assert [f"{found.code} {found.span.text}" for found in made.found] == said


READ = """signal truck : state { load: %, level: 1, v: m/s }
param most : 1 = 5
table wear(part: %) -> m/s = linear clamp | 0: 20 m/s | 100: 5 m/s |
table grip(lean: deg, part: %) -> m/s = linear clamp | part: 0, 100 | 0: 20 m/s, 10 m/s | 45: 5 m/s, 2 m/s |
"""


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("wear(50)", ["E302 50"]),
        ("wear(max(truck.load, 50))", ["W309 50"]),
        ("grip(10 deg, 50)", ["E302 50"]),
        ("grip(30, 50 %)", ["E302 30"]),
        ("grip(most, 50 %)", ["W302 most"]),
        ("wear(50 %) + wear(truck.load) + wear(truck.level) + wear(0) + grip(0, most)", []),
    ],
)
def test_what_a_table_is_asked_for_is_in_its_unit(asked: str, said: list[str], tmp_path: Path) -> None:
    """As what a definition is given: `wear(50)` was read at 5000 %, where `clamp` has an answer to everything."""
    made = compiled(tmp_path, READ + rule("a", f"truck.v <= {asked}"))
    assert [f"{found.code} {found.span.text}" for found in made.found] == said


@pytest.mark.parametrize(
    ("formula", "clauses", "word"),
    [
        ("always p.v <= 3 m/s and p.v >= 1 m/s", "along", "and"),
        ("fast or not always p.v <= 3 m/s or quick(p.v)", "along", "or"),
        ("always[0 s, 3 s] ego.v <= 3 m/s and fast", "", "and"),
        ("for all o in objects: always[0 s, 3 s] o.v <= 3 m/s or fast", "", ""),
        ("(always p.v <= 3 m/s) and p.v >= 1 m/s", "along", ""),
        ("always (p.v <= 3 m/s and p.v >= 1 m/s)", "along", ""),
        ("p.v >= 1 m/s and always p.v <= 3 m/s", "along", ""),
        ("always p.v <= 3 m/s and ego.v >= 1 m/s", "along", ""),
        ("always p.v <= 3 m/s and eventually p.v <= 1 m/s", "along", ""),
        ("always p.v <= 3 m/s or rising(p.v <= 1 m/s)", "along", ""),
        ("once[0 s, 3 s] fast and ego.v <= 3 m/s", "", ""),
    ],
)
def test_where_always_ends_before_and_is_asked(formula: str, clauses: str, word: str, tmp_path: Path) -> None:
    """What stands behind `and` is demanded of the present sample alone, which nobody sees where it is about the sample."""
    more = ALONG + "signal objects : set of object { v: m/s }\n"
    text = more + rule("a", formula, clauses and "  along     plan as p\n")
    said = [("W307", f"`always` ends before `{word}`")] if word else []
    made = compiled(tmp_path, text)
    assert [(found.code, found.message) for found in made.found] == said
    (tmp_path / "made.spec").write_text(format_text(SourceFile("made.spec", HEAD + text)), "utf-8")
    again = compile_paths([tmp_path / "made.spec"], tmp_path)
    assert [(found.code, found.message) for found in again.found] == said


def test_where_always_ends_makes_the_difference(tmp_path: Path) -> None:
    """The second sample is too slow: what is written first does not say so."""
    along = "  along     plan as p\n"
    early = rule("early", "always p.v <= 3 m/s and p.v >= 1 m/s", along)
    all_of_it = rule("all_of_it", "always (p.v <= 3 m/s and p.v >= 1 m/s)", along)
    evaluator = Evaluator(compiled(tmp_path, ALONG + early + all_of_it).spec, None, "reference")
    signals = {"plan": {"t": [0.0, 1.0], "v": [2.0, 0.0]}}
    (result,) = evaluator.evaluate([evaluator.read({"signals": signals})])
    assert [result.rules[name].verdict for name in ("early", "all_of_it")] == ["satisfied", "violated"]


TURNING = """signal plan : trajectory { t: s increasing, heading: rad, kappa: 1/m, v: m/s }
line axis = (0 m, 0 m) (1 m, 0 m)
signal car : state { x: m, y: m, heading: deg, steering: deg }
define wide -> rad = 10 deg
define size(o: rad) -> rad = abs(o - car.heading)
"""


@pytest.mark.parametrize(
    ("demand", "said"),
    [
        ("abs((q.heading - p.heading) / (q.t - p.t)) <= 1 rad/s", ["q.heading - p.heading"]),
        ("(q.heading - p.heading)^2 <= 0.1 rad", ["q.heading - p.heading"]),
        ("p.v * (q.heading - p.heading) <= 1 m/s", ["q.heading - p.heading"]),
        ("p.heading <= car.heading + wide", ["p.heading <= car.heading + wide"]),
        ("car.heading - wide <= p.heading <= 3 rad", ["car.heading - wide <= p.heading"]),
        ("p.heading in [car.heading - 9 deg, car.heading + 9 deg]", ["p.heading in [car.heading - 9 deg, car.heading + 9 deg]"]),
        ("direction(car, axis) >= p.heading", ["direction(car, axis) >= p.heading"]),
        ("abs(atan2(car.y, car.x) - p.heading) <= 30 deg", ["atan2(car.y, car.x) - p.heading"]),
        ("p.heading <= atan2(car.y, car.x) + 9 deg", ["p.heading <= atan2(car.y, car.x) + 9 deg"]),
        ("atan2(car.y, car.x) - 9 deg <= 30 deg and atan2(car.y, car.x) <= car.steering", []),
        ("abs(atan2(car.y, car.x) - atan2(car.x, car.y)) <= 30 deg", []),
        ("p.heading <= 90 deg and p.heading <= car.steering + 10 deg", []),
        ("abs(sin(q.heading - p.heading) / (q.t - p.t)) <= 1 rad/s", []),
        ("min(abs(q.heading - p.heading), 2 * pi - abs(q.heading - p.heading)) <= 1 rad", []),
        ("min(360 deg - abs(q.heading - p.heading), abs(q.heading - p.heading)) <= 1 rad", []),
        ("min(q.heading - p.heading, 360 deg - (q.heading - p.heading)) <= 1 rad", ["q.heading - p.heading"]),
        ("min(abs(q.heading - p.heading), 180 deg - abs(q.heading - p.heading)) <= 1 rad", ["q.heading - p.heading"]),
        ("min(abs(q.heading - p.heading), 360 deg - abs(q.heading - car.heading)) <= 1 rad", ["q.heading - p.heading"]),
        ("min(size(q.heading), 2 * pi - size(q.heading)) <= 1 rad", []),
        ("min(size(q.heading), 2 * pi - size(p.heading)) <= 1 rad", ["o - car.heading"]),
        ("p.heading / car.heading <= 3 and p.heading + car.heading <= car.heading", []),
    ],
)  # fmt: skip
def test_headings_turn_over_however_they_are_compared(demand: str, said: list[str], tmp_path: Path) -> None:
    clause = "  for all   consecutive p, q in plan\n"
    made = compiled(tmp_path, TURNING + rule("a", demand, clause))
    assert [found.span.text for found in made.found if found.code == "W310"] == said
    assert {found.code for found in made.found} <= {"W310", "E220"}


@pytest.mark.parametrize(
    ("kind", "apart", "told"),
    [
        ("deg in [0, 360]", [359.0, 1.0], "from 359 deg to 1 deg, this is 358 deg"),
        ("deg in [0, 359.9]", [359.0, 1.0], "from 359 deg to 1 deg, this is 358 deg"),
        ("rad in [-3.1416, 3.1416]", [3.1, -3.1], "from 179 deg to -179 deg, this is 358 deg"),
        ("deg in [-90, 90]", [89.0, -89.0], ""),  # a latitude
        ("deg in [-720, 720]", [359.0, 1.0], ""),  # a steering wheel, which has turned by that
        ("m in [0, 6.28]", [6.2, 0.1], ""),
        ("deg", [359.0, 1.0], ""),  # nothing is known of it
    ],
)
def test_an_angle_of_a_whole_turn_turns_over_whatever_it_is_called(
    kind: str, apart: list[float], told: str, tmp_path: Path
) -> None:
    """By what comes of it: beside where they start anew, two courses are almost alike, and their numbers a whole turn apart."""
    ships = f"signal one : state {{ course: {kind} }}\nsignal other : state {{ course: {kind} }}\n"
    unit = kind.split(maxsplit=1)[0]
    made = compiled(tmp_path, ships + rule("a", f"abs(one.course - other.course) <= 3 {unit}"))
    assert [found.pointer for found in made.found] == ([told] if told else [])
    evaluator = Evaluator(made.spec, None, "reference")
    signals = {name: {"course": value} for name, value in zip(("one", "other"), apart)}
    (result,) = evaluator.evaluate([evaluator.read({"signals": signals})])
    assert result.rules["a"].verdict == "violated"


@pytest.mark.parametrize(
    ("demand", "warned"),
    [
        ("abs(ship.course - 180 deg) <= 30 deg", False),  # at most half a turn off, as it should be
        ("abs(180 deg - ship.course) <= 30 deg", False),
        ("abs(ship.course - 350 deg) <= 30 deg", True),  # 10 deg is 20 deg off
        ("ship.course <= 5 deg or ship.course >= 355 deg", False),
        ("abs(ship.course - atan2(ship.y, ship.x)) <= 30 deg", True),
        ("ship.course - ship.rudder <= 30 deg", False),
    ],
)
def test_a_course_and_a_constant_are_told_where_it_turns_over(
    demand: str, warned: bool, tmp_path: Path
) -> None:
    ship = "signal ship : state { x: m, y: m, course: deg in [0, 360], rudder: deg in [-35, 35] }\n"
    found = compiled(tmp_path, ship + rule("a", demand)).found
    assert [each.code for each in found] == (["W310"] if warned else [])


def test_a_car_that_turns_on_through_180_degrees_turns_no_faster(tmp_path: Path) -> None:
    """What the warning is about: at 5 deg/s all along, the rate of the numbers is that of almost a whole turn."""
    clause = "  for all   consecutive p, q in plan\n"
    numbers = rule("numbers", "abs((q.heading - p.heading) / (q.t - p.t)) <= 10 deg/s", clause)
    angles = rule("angles", "abs(angle_difference(q.heading, p.heading) / (q.t - p.t)) <= 10 deg/s", clause)
    path = tmp_path / "made.spec"
    path.write_text(HEAD.replace("\n", "\nuse prelude.frames\n", 1) + TURNING + numbers + angles, "utf-8")
    made = compile_paths([path], tmp_path)
    assert [(found.code, found.span.text) for found in made.found] == [("W310", "q.heading - p.heading")]
    evaluator = Evaluator(made.spec, None, "reference")
    heading = [math.radians(degrees) for degrees in (170.0, 175.0, -180.0, -175.0)]
    (result,) = evaluator.evaluate(
        [evaluator.read({"signals": {"plan": {"t": [0, 1, 2, 3], "heading": heading}}})]
    )
    assert [result.rules[name].verdict for name in ("numbers", "angles")] == ["violated", "satisfied"]


@pytest.mark.parametrize(
    ("clauses", "warned"),
    [
        ('  exists    o in objects\n  except    fast "x"\n', True),
        ('  exists    nearest o in objects by o.x\n  except    fast "x"\n', True),
        ('  for all   p in objects\n  exists    o in objects\n  except    p.v > ego.v "x"\n', True),
        ('  for all   o in objects\n  except    fast "x"\n', False),
        ('  exists    o in objects\n  except    o.v > ego.v "x"\n', False),
        (
            '  exists    o in objects\n  let near = o.x < 3 m\n  let far = not near\n  except    far "x"\n',
            False,
        ),
        ('  exists    p in objects\n  for all   o in objects\n  except    fast "x"\n', False),
    ],
)
def test_an_exception_that_leaves_nothing_to_be_found_is_asked_about(
    clauses: str, warned: bool, tmp_path: Path
) -> None:
    """As the evaluator says: what is left out of an `exists` altogether violates the rule, and of a `for all` it demands nothing."""
    made = compiled(tmp_path, OBJECTS + rule("a", "o.x >= -100 m", clauses))
    assert made.errors == []
    assert ("W316" in {found.code for found in made.found}) == warned
    if "fast" in clauses and "exists    p" not in clauses:
        evaluator = Evaluator(made.spec, None, "reference")
        signals = {"ego": {"v": 2.0, "heading": 0.0}, "objects": [{"v": 1.0, "x": 1.0}], "fast": True}
        (result,) = evaluator.evaluate([evaluator.read({"signals": signals})])
        assert result.rules["a"].verdict == ("violated" if warned else "inactive")


@pytest.mark.parametrize(
    ("text", "help_"),
    [
        (rule("a", "truck.load <= 50 m"), "write a number in %, such as `50 %`"),
        (rule("a", "ego.heading <= 90 m/s"), "write a number in rad, such as `90 rad`"),
        (rule("a", "truck.level <= 3 m"), "leave the unit out: `3`"),
        (rule("a", "wear(50 m) <= truck.v"), "write a number in %, such as `50 %`"),
        ("param steep : deg = 5 m\n", "write a number in deg, such as `5 deg`"),
        ("param least : % = 0.2\n", "write the unit: `0.2 %`, or `20 %` where it is a share of a whole"),
        ("param least : % = 20\n", "write the unit: `20 %`"),
        (rule("a", "truck.load <= 1.2"), "write `1.2 %`, or `120 %` where it is so many times the whole"),
        (rule("a", "truck.load <= -2"), "write `-2 %`, or `-200 %` where it is so many times the whole"),
        (rule("a", "truck.load <= 5"), "write `5 %`"),
    ],
)
def test_no_help_leads_to_a_number_that_is_another_one(text: str, help_: str, tmp_path: Path) -> None:
    """Who leaves out the unit beside a percentage, as was told, has a limit that is a hundred times as high."""
    (found,) = compiled(tmp_path, READ + text).found
    assert found.help == help_


@pytest.mark.parametrize(
    ("ways", "clauses", "said"),
    [
        ("linear", "", ["below 2 m/s", "above 1200 kg"]),
        ("linear clamp, step", "", []),
        ("linear clamp, linear", "", ["above 1200 kg"]),
        ("step, linear clamp", "", ["below 2 m/s"]),
        ("linear, linear clamp", "  whenever  car.v in [2 m/s, 40 m/s]\n", []),
        ("linear", "  whenever  car.v in [2 m/s, 40 m/s] and car.mass <= 1200 kg\n", []),
    ],
)
def test_a_table_of_two_arguments_is_asked_about_along_both(
    ways: str, clauses: str, said: list[str], tmp_path: Path
) -> None:
    head = (
        "signal car : state { v: m/s in [0, 40], mass: kg in [900, 1400] }\n"
        f"table braking(v: m/s, mass: kg) -> m/s^2 = {ways}\n"
        "  | mass: 900 kg, 1200 kg | 2 m/s: 9 m/s^2, 8 m/s^2 | 40 m/s: 7 m/s^2, 6 m/s^2 |\n"
    )
    made = compiled(tmp_path, head + rule("a", "braking(car.v, car.mass) >= 5 m/s^2", clauses))
    assert {found.code for found in made.found} == ({"W315"} if said else set())
    assert [found.message.split(" has no value ")[1].split(",")[0] for found in made.found] == said
    evaluator = Evaluator(made.spec, None, "reference")
    signals = [{"car": {"v": v, "mass": mass}} for v in (0.0, 2.0, 40.0) for mass in (900.0, 1200.0, 1400.0)]
    results = evaluator.evaluate([evaluator.read({"signals": each}) for each in signals])
    assert any(result.rules["a"].verdict == "undefined" for result in results) == bool(said)


@pytest.mark.parametrize(
    ("heading", "warned"),
    [
        ("(1 - share) * p.heading + share * q.heading", True),
        ("p.heading + share * (q.heading - p.heading)", True),
        ("(q.heading - p.heading) * 2 / 4 + p.heading", True),
        ("(p.heading + q.heading) / 2", True),
        ("0.5 * (p.heading + q.heading)", True),
        ("p.heading + share * angle_difference(q.heading, p.heading)", False),
        ("p.heading + angle_difference(q.heading, p.heading) / 2", False),
        ("p.heading + car.steering", False),
        ("2 * p.heading - car.steering", False),
    ],
)
def test_what_lies_between_two_headings_is_asked_about(heading: str, warned: bool, tmp_path: Path) -> None:
    """By what comes of it: halfway from 175 deg to -175 deg, a car heads for 180 deg, and not for 0 deg."""
    path = tmp_path / "made.spec"
    clause = f"  for all   consecutive p, q in plan\n  let       share = 0.5\n  let       on = {heading}\n"
    clause = clause if "share" in heading else clause.replace("  let       share = 0.5\n", "")
    text = HEAD.replace("\n", "\nuse prelude.frames\n", 1) + TURNING
    path.write_text(text + rule("a", "cos(angle_difference(on, 180 deg)) > 0.9", clause), "utf-8")
    made = compile_paths([path], tmp_path)
    assert [found.code for found in made.found] == (["W310"] if warned else [])
    evaluator = Evaluator(made.spec, None, "reference")
    plan = {"t": [0, 1], "heading": [math.radians(175.0), math.radians(-175.0)]}
    signals = {"plan": plan, "car": {"x": 0, "y": 0, "heading": 0, "steering": 2}}
    (result,) = evaluator.evaluate([evaluator.read({"signals": signals})])
    if "steering" not in heading:
        assert result.rules["a"].verdict == ("violated" if warned else "satisfied")


@pytest.mark.parametrize("angle", [0.1, -0.1])
def test_who_leads_is_lost_over_the_finish_line(angle: float, tmp_path: Path) -> None:
    """What the warning is about: of two cars 10 m apart on a ring, the one ahead is so wherever they are."""
    text = """module made
signal ego : state { x: m, y: m }
signal other : state { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
rule numbers "r"
  require   station(other, track) - station(ego, track) > 0 m
rule gap "r"
  require   station_gap(track, station(ego, track), station(other, track)) > 0 m
"""
    (tmp_path / "made.spec").write_text(text, "utf-8")
    made = compile_paths([tmp_path / "made.spec"], tmp_path)
    assert [(found.code, found.span.line) for found in made.found] == [("W317", 6)]
    ring = [2 * math.pi * i / 64 for i in range(64)]
    left, right = ([[r * math.cos(a), r * math.sin(a)] for a in ring] for r in (94.0, 106.0))
    at = [{"x": 100 * math.cos(a), "y": 100 * math.sin(a)} for a in (angle - 0.05, angle + 0.15)]
    evaluator = Evaluator(made.spec, None, "reference")
    signals = {"ego": at[0], "other": at[1], "track": {"left": left, "right": right, "closed": True}}
    (result,) = evaluator.evaluate([evaluator.read({"signals": signals})])
    assert result.rules["gap"].verdict == "satisfied"
    assert result.rules["numbers"].verdict == ("satisfied" if angle > 0.0 else "violated")
