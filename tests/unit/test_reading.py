"""Formulas and sentences: every node in every form, the order of operations, long lines, names that are markup."""

from __future__ import annotations

import inspect
import json
import re
from pathlib import Path
from typing import Any, get_args
from xml.etree import ElementTree

import pytest
from jsonschema import Draft202012Validator

from support.mathml import Parser
from support.mathml import read as signs
from support.reading import RULES, demanded, examples, rule_of, spec_of
from support.supervised import everything
from trackmarshal import reading, typed
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import loads
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading import layout as at
from trackmarshal.reading import mathml, terminal, typst
from trackmarshal.reading.breaking import broad, lines
from trackmarshal.reading.data import data
from trackmarshal.reading.formulas import Formulas
from trackmarshal.reading.html import page
from trackmarshal.reading.rule import read
from trackmarshal.reading.sentences import Sentences
from trackmarshal.reading.sheet import Sheet
from trackmarshal.reading.telling import tell
from trackmarshal.reading.terminal import block, text
from trackmarshal.reading.text import lines as in_text
from trackmarshal.reading.words.english import ENGLISH
from trackmarshal.semantics.compile import compile_paths

ROOT = Path(__file__).resolve().parents[2]


def sheet(rule: RuleInfo, spec: Spec, expand: bool = False) -> Sheet:
    return Sheet(rule, ENGLISH, None, read(rule, spec, None, expand), tell(rule, spec, ENGLISH), None, ())


def printed(made: Any) -> list[dict[str, str]]:
    """All that is printed of formulas in a rule's data."""
    if isinstance(made, dict):
        own = [made] if "mathml" in made else []
        return [*own, *(one for value in made.values() for one in printed(value))]
    return [one for value in made for one in printed(value)] if isinstance(made, list) else []


def test_every_node_of_the_typed_tree_is_shown_in_every_form(tmp_path: Path) -> None:
    """Of the shipped rules, of the examples of the pages, and of a spec with the rest; what is printed is XML, and reads back."""
    made = spec_of(tmp_path, RULES)
    specs = [everything(), made]
    schema = Draft202012Validator(
        json.loads(Path(reading.__file__).with_name("show.schema.json").read_text("utf-8"))
    )
    for number, example in enumerate(examples()):
        path = tmp_path / f"example{number}.spec"
        path.write_text(example, "utf-8")
        specs.append(compile_paths([path], ROOT).spec)
    seen: set[type] = set()
    for spec in specs:
        for rule in spec.rules:
            if rule.typed is None:
                continue
            seen |= {type(node) for node in typed.below(rule.typed)}
            for expand in (
                (False, True) if spec is not everything() else (False,)
            ):  # those are read back, written out: test_printed_formulas
                whole = data(sheet(rule, spec, expand))
                schema.validate(whole)
                for one in printed(whole):
                    ElementTree.fromstring(one["mathml"])
                    assert one["typst"].startswith("$ ")
                    assert one["text"]
    nodes = {
        *get_args(typed.Value),
        *get_args(typed.Clause),
        typed.Range,
        typed.Window,
        typed.Machine,
        typed.Transition,
        typed.Keep,
    }
    assert {node.__name__ for node in nodes - seen} == set()


@pytest.mark.parametrize(
    ("condition", "shown"),
    [
        ("ego.v - (top - ego.v) <= top", "v_ego − (top − v_ego) ≤ top"),
        ("ego.v - top - ego.v <= top", "v_ego − top − v_ego ≤ top"),
        ("ego.v + (top + ego.v) <= top", "v_ego + (top + v_ego) ≤ top"),
        ("ego.v * (2 * 3) <= top", "v_ego · (2 · 3) ≤ top"),
        ("ego.v / (2 / 3) <= top", "v_ego/(2/3) ≤ top"),
        ("2 * (ego.v / 3) <= top", "2 · (v_ego/3) ≤ top"),
        ("-(ego.v + top) * 2 <= -top", "−(v_ego + top) · 2 ≤ −top"),
        ("ego.v - (-top) <= top", "v_ego − (−top) ≤ top"),
        ("(ego.v / top)^2 * (-2)^3 <= 1", "(v_ego/top)² · (−2)³ ≤ 1"),
        ("(2 m/s)^2 <= 2 m^2/s^2", "(2 m/s)² ≤ 2 m²/s²"),
        ("3 m / s <= 3 m/s", "(3 m)/s ≤ 3 m/s"),
        ("ego.v / (2 m) <= ego.v / 2 * 1 1/m", "v_ego/(2 m) ≤ v_ego/2 · 1 1/m"),
        ("abs(-(ego.v)) <= 60 km/h", "|−v_ego| ≤ 60 km/h"),
        ("ego.wet and (blue_flag or ego.v < top)", "wet_ego ∧ (b_flag ∨ v_ego < top)".replace("b_flag", "blue_flag")),
        ("(ego.wet and blue_flag) or ego.v < top", "wet_ego ∧ blue_flag ∨ v_ego < top"),
        ("not (ego.v < top) implies (ego.wet implies blue_flag)", "¬(v_ego < top) ⇒ (wet_ego ⇒ blue_flag)"),
        ("(for all o in objects: o.v < top) and ego.wet", "(∀ o ∈ objects: v_o < top) ∧ wet_ego"),
        ("exists o in objects where (exists p in plan: p.v < o.v): o.v < top", "∃ o ∈ objects where (∃ p ∈ plan: v_p < v_o): v_o < top"),
        ("ego.v <= (if ego.wet then top else 10 m/s)", "v_ego ≤ (if wet_ego then top else 10 m/s)"),
        ("sum(o.v + top for o in objects where o.v > top) <= top", "∑_{o ∈ objects: v_o > top} (v_o + top) ≤ top"),
        ("plan.first.v <= plan.last.v", "v_plan.first ≤ v_plan.last"),
        ("kappa * 100 m <= plan.first.kappa * 1 m", "κ · 100 m ≤ κ_plan.first · 1 m"),
        ("0 m/s <= ego.v < top", "0 m/s ≤ v_ego < top"),
        ("ego.v in [0 m/s, top + 1 m/s]", "v_ego ∈ [0 m/s, top + 1 m/s]"),
    ],
)  # fmt: skip
def test_parentheses_stand_where_the_order_of_operations_takes_them(
    condition: str, shown: str, tmp_path: Path
) -> None:
    assert demanded(tmp_path, condition) == shown


def test_what_is_written_out_keeps_variables_apart(tmp_path: Path) -> None:
    rule, spec = rule_of(
        tmp_path,
        'predicate nobody(v: m/s) = not (exists o in objects: o.v > v)\nrule r "r"\n  for all o in objects\n  require nobody(o.v)\n',
    )
    (_, demand) = read(rule, spec, None, True).clauses
    assert text(demand.formula) == "¬(∃ o′ ∈ objects: v_o′ > v_o)"


def test_one_sign_is_one_thing() -> None:
    """What a definition of another module is given has a prime where the spec's own parameter goes by the same name."""
    rule = everything().rule("safe_gap")
    assert rule is not None
    heads = {one.symbol.name: text(one.head) for one in read(rule, everything()).definitions}
    assert heads["rss_lateral_path"] == "rss_lateral_path(approach, response′, acceleration, braking)"
    assert heads["half_extent"] == "half_extent(length′, width′, angle)"


@pytest.mark.parametrize(
    ("declared", "before", "condition", "shown"),
    [
        ("param v_ego : m/s = 3 m/s\n", "", "ego.v <= v_ego", "v_ego ≤ made.v_ego"),
        ("param v_ego : m/s = 3 m/s\n", "", "v_ego <= ego.v", "v_ego ≤ ego.v"),
        ("", "  let v_ego = max(ego.v, 0 m/s)\n", "v_ego <= top", "v_ego′ ≤ top"),
    ],
)
def test_a_field_and_a_name_that_look_the_same_are_told_apart(
    declared: str, before: str, condition: str, shown: str, tmp_path: Path
) -> None:
    """`v_ego ≤ v_ego` says nothing, and was what a rule on `ego.v` and the parameter `v_ego` was shown as."""
    rule, spec = rule_of(tmp_path, f'{declared}rule r "r"\n{before}  require {condition}\n')
    assert text(read(rule, spec).clauses[-1].formula) == shown


def test_a_formula_of_300_signs_has_lines(tmp_path: Path) -> None:
    terms = " + ".join(f"plan.first.v^2 / ({k} m/s + abs(ego.v - {k} m/s))" for k in range(1, 60))
    rule, spec = rule_of(tmp_path, f'rule r "r"\n  require sqrt(({terms}) * top) <= top and ego.v < top\n')
    (demand,) = read(rule, spec).clauses
    for width in (40, 60, 100):
        assert max(map(len, block(demand.formula, width))) <= width
        made = lines(demand.formula, width, broad)
        assert len(made) > 10
        assert all(sum(map(broad, line.parts)) <= max(width - 2 * line.indent, 24) + 6 for line in made)
    whole = Parser(signs(mathml.formula(demand.formula, 10_000))).whole()
    assert Parser(signs(mathml.formula(demand.formula, 60))).whole() == whole


def test_arguments_of_a_call_that_is_too_wide_fill_lines() -> None:
    """What has lines of its own stands apart from them; nothing is left out, and nothing comes before what it stood behind."""
    names = tuple(at.Name(f"argument_{number}") for number in range(8))
    long = at.Call(
        at.Name("f"),
        (
            at.Chain(
                at.Name("first_of_all"),
                tuple(at.Joined(at.Sign("+"), at.Name("another_one")) for _ in range(4)),
            ),
        ),
    )
    assert block(at.Call(at.Name("call"), names), 60) == [
        "call(",
        "  argument_0, argument_1, argument_2, argument_3,",
        "  argument_4, argument_5, argument_6, argument_7",
        ")",
    ]
    assert block(at.Call(at.Name("call"), (*names[:2], long, *names[2:])), 60) == [
        "call(",
        "  argument_0, argument_1,",
        "  f(",
        "    first_of_all + another_one + another_one + another_one",
        "      + another_one",
        "  ),",
        "  argument_2, argument_3, argument_4, argument_5,",
        "  argument_6, argument_7",
        ")",
    ]


def test_a_rule_with_40_definitions(tmp_path: Path) -> None:
    chain = "".join(f"define d{k}(v: m/s) -> m/s = d{k - 1}(v) + {k} m/s\n" for k in range(1, 41))
    rule, spec = rule_of(
        tmp_path, f'define d0(v: m/s) -> m/s = v\n{chain}rule r "r"\n  require d40(ego.v) <= top\n'
    )
    assert len(read(rule, spec).definitions) == 41
    assert len(tell(rule, spec, ENGLISH).definitions) == 41
    (demand,) = read(rule, spec, None, True).clauses
    assert text(demand.formula).count(" m/s") == 40
    assert "d40" in page([sheet(rule, spec)])


def test_what_grows_without_end_is_refused_and_not_written_out(tmp_path: Path) -> None:
    chain = "".join(f"define d{k}(v: m/s) -> m/s = d{k - 1}(v) + d{k - 1}(v)\n" for k in range(1, 12))
    rule, spec = rule_of(
        tmp_path, f'define d0(v: m/s) -> m/s = v\n{chain}rule r "r"\n  require d11(ego.v) <= top\n'
    )
    assert len(read(rule, spec).definitions) == 12
    with pytest.raises(TrackmarshalError) as caught:
        read(rule, spec, None, True)
    assert caught.value.code == "E490"
    assert caught.value.line is not None


EVIL = '</code><script>alert(1)</script> $ #panic("x") \\input{/etc/passwd} {{ 7 * 7 }} %n ”'


def test_markup_in_titles_is_text(tmp_path: Path) -> None:
    written = EVIL.replace('"', "'").replace("\\", "\\\\")
    rule, spec = rule_of(
        tmp_path,
        f'param size : m/s = 1 m/s source "{written}"\nrule r "{written}"\n  because "{written}"\n  for all o in objects\n'
        f'    except o.v > top "{written}"\n  require o.v <= size\n',
    )
    made = page([sheet(rule, spec)])
    assert "<script" not in made
    assert "&lt;script&gt;" in made
    assert "49" not in made
    assert made.count("<html") == 1


def test_numbers_in_sentences_have_six_digits_and_say_that_there_are_more(tmp_path: Path) -> None:
    rule, spec = rule_of(
        tmp_path,
        'param third : 1 = 1 / 3\nparam half : 1 = 1 / 2\nrule r "r"\n  require ego.v <= third * half * top\n',
    )
    (demand,) = tell(rule, spec, ENGLISH).demand
    assert "third (≈ 0.333333)" in demand
    assert "half (0.5)" in demand
    assert "top (180 km/h)" in demand
    (setting,) = [
        one for one in data(sheet(rule, spec))["formula"]["parameters"] if one["name"].endswith("third")
    ]
    assert setting["written"] == "0.3333333333333333"  # whole where parameters are listed


def test_names_beyond_ascii_are_shown_and_escaped() -> None:
    for piece in (at.Name('a"#b\\'), at.Word('"; #panic() //'), at.Index(at.Name("<b>"), at.Name("$x$"))):
        made = typst.formula(piece)
        assert made.count("$") == 2 + made.count('"$x$"') * 2
        inside = made.replace("\\\\", "").replace('\\"', "")
        assert inside.count('"') % 2 == 0
        assert all("#" not in part for part in inside.split('"')[::2])
        ElementTree.fromstring(mathml.formula(piece))
    assert "&lt;b&gt;" in mathml.formula(at.Name("<b>"))


def test_greek_letters_and_units_of_the_spec(tmp_path: Path) -> None:
    rule, spec = rule_of(
        tmp_path, 'param μ : 1 = 1.5\nrule r "ünïcödé – 速度"\n  require ego.v ≤ μ · 10 m/s²·1 s\n'
    )
    assert text(read(rule, spec).clauses[0].formula) == "v_ego ≤ μ · 10 m/s² · 1 s"
    assert '<mi mathvariant="normal">s</mi><mn>2</mn></msup>' in mathml.formula(
        read(rule, spec).clauses[0].formula
    )
    assert "ünïcödé – 速度" in page([sheet(rule, spec)])


def test_units_are_upright_and_letters_are_not() -> None:
    made = mathml.element(at.Digits("10", "m/s^2"))
    assert "<mn>10</mn>" in made
    assert made.count('mathvariant="normal"') == 2
    assert "mathvariant" not in mathml.element(at.Name("m"))
    assert (
        typst.content(at.Digits("10", "m/s^2"))
        == '"10" thin upright("m") class("normal", slash) attach(upright("s"), t: "2")'
    )


def test_whatever_is_no_node_is_refused(tmp_path: Path) -> None:
    """The unions are closed for mypy; at run time, what is not in them raises, in every backend."""

    class Other(typed.NumberNode):
        """A node that nobody knows."""

    class OtherFormula(typed.FormulaNode):
        """Another one."""

    number: Any = Other((0, 0, 0), "")
    formula: Any = OtherFormula()
    for refuse in (
        lambda: Formulas().number(number), lambda: Formulas().formula(formula),
        lambda: Sentences(ENGLISH, {}, frozenset(), frozenset(), frozenset()).number(number), lambda: Sentences(ENGLISH, {}, frozenset(), frozenset(), frozenset()).formula(formula),
        lambda: mathml.element(number), lambda: typst.content(number), lambda: terminal.text(number), lambda: broad(number),
    ):  # fmt: skip
        with pytest.raises((AssertionError, AttributeError)):
            refuse()


def test_every_phrase_has_the_places_that_are_filled() -> None:
    """A phrase that forgets a part of what it says would say something else."""
    filled = {
        "comparisons": 0,
        "functions": 1,
        "temporal": 1,
        "until": 2,
        "steps": 1,
        "weak_steps": 1,
        "edges": 1,
        "folds": 1,
        "more": 1,
        "along": 2,
    }
    for name, least in filled.items():
        for phrases in getattr(ENGLISH, name).values():
            for phrase in phrases if isinstance(phrases, tuple) else (phrases,):
                assert phrase.count("{") >= least, phrase
    assert all(
        inspect.cleandoc(value) == value
        for value in vars(ENGLISH).values()
        if isinstance(value, str) and not value.endswith(" ")
    )


def test_sentences_say_what_could_be_heard_in_two_ways_by_letters(tmp_path: Path) -> None:
    rule, spec = rule_of(
        tmp_path,
        'rule r "r"\n  require (ego.v + top) * 2 - (top - ego.v) <= top and (ego.wet or not blue_flag)\n',
    )
    assert tell(rule, spec, ENGLISH).demand == (
        "A times 2 minus B is at most top (180 km/h) and condition C holds.",
        "Here, A is the speed of ego plus top; B is top minus the speed of ego; condition C is that either “wet” holds for ego or “blue flag” does not hold.",
    )


@pytest.mark.parametrize(
    ("declared", "condition"),
    [
        ("line A = (0 m, 0 m) (0 m, 9 m)\n", "distance_to(plan.last, A) <= {apart}"),
        ("zone A = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m)\n", "plan.last in zone A and 1 m <= {apart}"),
        ("enum class { A, B }\nsignal who : state { class: class }\n", "who.class is A or 1 m <= {apart}"),
        (
            "enum class { A, B }\nsignal who : state { class: class }\n",
            "(case who.class { A: {apart}, B: 2 m }) <= 1 m",
        ),
        ("signal A : state { x: m }\n", "A.x <= {apart}"),
        ("stretch A on border = 0 m to 9 m\n", "plan.last in stretch A and 1 m <= {apart}"),
        ("param A : shared = { x: 1 m }\nshape shared = { x: m }\n", "A.x <= {apart}"),
    ],
)
def test_a_letter_is_nothing_that_has_a_name(declared: str, condition: str, tmp_path: Path) -> None:
    """ "The distance from ego to A is at most the square root of A" was said of a line A."""
    demand = condition.replace("{apart}", "2 * (plan.last.x + 1 m)")
    rule, spec = rule_of(tmp_path, f'{declared}rule r "r"\n  require {demand}\n')
    told = tell(rule, spec, ENGLISH)
    whole = " ".join((*told.demand, *told.definitions))
    assert not re.search(r"\b(condition )?A is (that|x|the x-coordinate|A|1|2)", whole), whole


def test_what_is_raised_to_a_power_is_said_apart(tmp_path: Path) -> None:
    """`(-x)^4` and `-(x^4)`, `sqrt(x)^4` and `sqrt(x^4)`, `(x^4)^0.5` and `x^(4^0.5)`, `(3 m)^4` and `3 m^4` are not the same, and were said alike."""
    powers = (
        "(-kappa)^4", "-(kappa^4)", "sqrt(kappa)^4", "sqrt(kappa^4)", "abs(kappa)^4", "abs(kappa^4)", "pow(-2, 1.5)", "-pow(2, 1.5)", "(2^4)^0.5",
        "2^(4^0.5)", "2 + 3^4", "(2 + 3)^4", "2 * 3^4", "(2 * 3)^4",
    )  # fmt: skip
    said = []
    for power in powers:
        rule, spec = rule_of(tmp_path, f'rule r "r"\n  require {power} * 1 <= {power} * 1\n')
        told = " ".join(tell(rule, spec, ENGLISH).demand)
        assert re.findall(r"(\S+)(?: \([^)]*\))? to the power of", told), told
        assert not re.search(r"(minus|of|plus|times) \S+(?: \([^)]*\))? to the power of", told), told
        said.append(told)
    assert len(set(said)) == len(powers)


def test_what_a_machine_remembers_is_raised_by_its_letter(tmp_path: Path) -> None:
    """ "The u that the role of o remembers to the power of 4" was heard of what is remembered to a power."""
    rule, spec = rule_of(
        tmp_path,
        "state role : { free, final gone } for each o in objects starts free\n  becomes gone when o.v > 9 m/s remember u = o.v / (1 m/s)\n"
        'rule r "r"\n  for all o in objects\n  require role(o).u^4 <= 3\n',
    )
    assert tell(rule, spec, ENGLISH).demand == (
        "For every o in objects: A to the power of 4 is at most 3.",
        "Here, A is the u that the role of o remembers.",
    )


def test_what_is_denied_ends_where_the_denial_does(tmp_path: Path) -> None:
    """ "It is not so that condition A holds and the speed .." was heard as the denial of both, which demands less."""
    rule, spec = rule_of(
        tmp_path,
        'rule r "r"\n  require not once[0 s, 3 s] blue_flag and ego.v <= top and not (not ego.wet)\n',
    )
    assert tell(rule, spec, ENGLISH).demand == (
        "Condition A does not hold, the speed of ego is at most top (180 km/h), and condition B does not hold.",
        "Here, condition A is that at some time in the last 3 s, “blue flag” holds; condition B is that “wet” does not hold for ego.",
    )


def test_a_deadline_is_told_where_it_is_one_for_each_that_a_quantifier_ranges_over(tmp_path: Path) -> None:
    rule, spec = rule_of(
        tmp_path,
        'rule r "r"\n  whenever blue_flag\n  within 2 s\n  exists o in objects where o.v < 1 m/s\n  require o.x >= 5 m\n',
    )
    assert tell(rule, spec, ENGLISH).demand == (
        "Whenever “blue flag” holds, there is at least one o in objects for which the speed of o is less than 1 m/s, such that "
        "within 2 s at the latest, the x-coordinate of o is at least 5 m.",
    )
    assert [clause.kind for clause in read(rule, spec).clauses] == [
        "whenever",
        "each",
        "where",
        "within",
        "require",
    ]


def test_of_which_quantifier_another_one_is_a_part_is_said(tmp_path: Path) -> None:
    """ "There is at least one sample p of plan, for every o in objects: .." was heard of a sample for each o."""
    rule, spec = rule_of(
        tmp_path,
        'rule r "r"\n  whenever blue_flag\n  exists p in plan\n  for all o in objects where o.x > 0 m\n  require p.v <= o.v\n',
    )
    assert tell(rule, spec, ENGLISH).demand == (
        "Whenever “blue flag” holds, there is at least one sample p of plan, such that for every o in objects for which "
        "the x-coordinate of o is greater than 0 m: the speed of p is at most the speed of o.",
    )


@pytest.mark.parametrize(
    ("quantifier", "said"),
    [
        (
            "for all o in objects",
            "For every o in objects, except where the speed of o is less than 1 m/s (parked): the",
        ),
        (
            "for nearest o in objects by o.x where o.y > 0 m",
            "For that one o in objects of which the x-coordinate of o is least, of those for which the y-coordinate of o is greater than 0 m, "
            "leaving out those for which the speed of o is less than 1 m/s (parked): the",
        ),
        (
            "exists o in objects",
            "There is at least one o in objects, leaving out those for which the speed of o is less than 1 m/s (parked), such that the",
        ),
    ],
)
def test_what_is_left_out_is_not_the_nearest_and_not_found(
    quantifier: str, said: str, tmp_path: Path
) -> None:
    """ "That one of which the distance is least, except where it is parked" was heard to demand nothing beside a parked one, and "at least one, except where" too."""
    rule, spec = rule_of(
        tmp_path, f'rule r "r"\n  {quantifier}\n  except o.v < 1 m/s "parked"\n  require o.x >= 5 m\n'
    )
    (sentence,) = tell(rule, spec, ENGLISH).demand
    assert sentence == f"{said} x-coordinate of o is at least 5 m."


@pytest.mark.parametrize("expand", [False, True])
def test_a_variable_is_shown_as_nothing_else(expand: bool, tmp_path: Path) -> None:
    """The rule does not see the parameter `d` that comes with what it calls: "x_d < d" was said of both."""
    (tmp_path / "low.spec").write_text(
        "module low\nshape there = { x: m }\nparam d : m = 3 m\npredicate close(o: there) = o.x < d\n",
        "utf-8",
    )
    (tmp_path / "mid.spec").write_text(
        "module mid\nuse low\nshape here = { x: m }\npredicate near(o: here) = close(o)\n", "utf-8"
    )
    head = "module made\nuse mid\nsignal objects : set of object { x: m, v: m/s }\n"
    rule, spec = rule_of(tmp_path, 'rule r "r"\n  for all d in objects\n  require near(d)\n', head)
    made = read(rule, spec, None, expand)
    shown = [text(one.formula) for one in made.clauses] + [text(one.body) for one in made.definitions]
    assert shown == (
        ["∀ d ∈ objects", "x_d < low.d"]
        if expand
        else ["∀ d ∈ objects", "near(d)", "close(o)", "x_o < low.d"]
    )


def test_what_has_one_name_in_two_modules_is_told_apart_in_words(tmp_path: Path) -> None:
    """A rule sees one of both; the other one comes with what it calls, and "g" and "the gap of x" were said of both."""
    (tmp_path / "low.spec").write_text(
        "module low\nparam g : m/s^2 = 9.81 m/s^2\ndefine gap(x: m) -> m = x + 1 m\n"
        "predicate fine(v: m/s, x: m) = v^2 / g <= gap(x)\n",
        "utf-8",
    )
    (tmp_path / "mid.spec").write_text(
        "module mid\nuse low\npredicate okay(v: m/s, x: m) = fine(v, x)\n", "utf-8"
    )
    head = "module made\nuse mid\nsignal ego : state { x: m, v: m/s }\nparam g : m/s^2 = 1.62 m/s^2\ndefine gap(x: m) -> m = x - 1 m\n"
    rule, spec = rule_of(
        tmp_path, 'rule r "r"\n  require okay(ego.v, ego.x) and ego.v^2 / g <= gap(ego.x)\n', head
    )
    told = tell(rule, spec, ENGLISH)
    assert told.demand == (
        "“okay” holds for the speed of ego and the x-coordinate of ego and the square of the speed of ego divided by made.g (1.62 m/s^2) "
        "is at most the made.gap of the x-coordinate of ego.",
    )
    assert told.definitions[1:] == (
        "“fine” holds for v and x exactly when the square of v divided by low.g (9.81 m/s^2) is at most the low.gap of x.",
        "The low.gap of x is x plus 1 m.",
        "The made.gap of x is x minus 1 m.",
    )


def test_two_sides_of_if_and_only_if_hold_together(tmp_path: Path) -> None:
    """ "A and b if and only if c" is heard of `a and (b iff c)` too."""
    said = set()
    for condition in ("(ego.wet and blue_flag) iff ego.v < top", "ego.wet and (blue_flag iff ego.v < top)"):
        rule, spec = rule_of(tmp_path, f'rule r "r"\n  require {condition}\n')
        said.add(tell(rule, spec, ENGLISH).demand[0])
    assert said == {
        "Condition A holds if and only if the speed of ego is less than top (180 km/h).",
        "“wet” holds for ego and condition A holds.",
    }


@pytest.mark.parametrize(
    ("along", "condition", "said"),
    [
        (
            "",
            "3 >= count(ego.wet, reset: blue_flag) and ego.v < top",
            "The number of times up to now at which “wet” holds for ego, counted since last “blue flag” holds, is at most 3 and the speed of ego",
        ),
        (
            "  along plan as p\n",
            "count(p.hot) < 2",
            "At the first sample p of plan: the number of times up to now at which “hot” holds for p is less than 2.",
        ),
        (
            "  along plan as p\n",
            "p.hot until p.v < top",
            "At the first sample p of plan: “hot” holds for p, until, at some time from now on, the speed of p",
        ),
        (
            "  along plan as p at last\n",
            "p.hot since p.v < top",
            "At the last sample p of plan: “hot” holds for p, ever since, at some time up to now, the speed of p",
        ),
    ],
)
def test_what_is_counted_and_what_has_to_come_is_said(
    along: str, condition: str, said: str, tmp_path: Path
) -> None:
    """A count is that of times up to now, and none of the whole timeline; `until` is violated where what ends it never comes."""
    rule, spec = rule_of(tmp_path, f'rule r "r"\n{along}  require {condition}\n')
    sentence = tell(rule, spec, ENGLISH).demand[0]
    assert sentence.startswith(said), sentence


def test_where_a_stretch_lies_is_shown(tmp_path: Path) -> None:
    """A name alone does not say where a rule applies, and nothing else of what a reader is shown does."""
    rule, spec = rule_of(
        tmp_path,
        "param braking : m = 4900 m\nstretch chicane on track = braking to 120 m\n"
        'rule r "r"\n  whenever ego in stretch chicane\n  require ego.v <= top\n',
    )
    made = sheet(rule, spec)
    assert "chicane = stretch(track, braking, 120 m)" in map(str.strip, in_text(made))
    assert [one["text"] for one in data(made)["formula"]["definitions"]] == [
        "chicane = stretch(track, braking, 120 m)"
    ]
    assert tell(rule, spec, ENGLISH).definitions == (
        "The stretch chicane is the one of the centre line of track from braking (4900 m) to 120 m.",
    )
    whenever, _ = read(rule, spec, None, True).clauses
    assert text(whenever.formula) == "ego ∈ stretch(track, braking, 120 m)"


def test_of_what_a_state_machine_is_is_said(tmp_path: Path) -> None:
    """Its transitions speak of `o`, which stood for nothing: "The role is one of .." """
    rule, spec = rule_of(
        tmp_path,
        "state role : { free, final gone } for each o in objects starts free\n  becomes gone when o.v > 9 m/s\n"
        'rule r "r"\n  for all z in objects\n  require role(z) is free\n',
    )
    assert tell(rule, spec, ENGLISH).definitions == (
        "The role of o is one of “free” and “gone”; it starts as “free”. It becomes “gone” from “free” when the speed of o is greater than 9 m/s.",
    )


def test_of_several_transitions_that_may_be_it_is_said_which_one_is_taken(tmp_path: Path) -> None:
    """In a cycle that is wet and has the flag, the machine becomes `stopped`: two sentences without an order said that it becomes either."""
    rule, spec = rule_of(
        tmp_path,
        "state mode : { rolling, slowed, stopped } starts rolling\n  becomes stopped when blue_flag\n  becomes slowed when ego.wet\n"
        '  becomes rolling from slowed, stopped when ego.v > 9 m/s\nrule r "r"\n  require mode is rolling\n',
    )
    _, machine = tell(rule, spec, ENGLISH).definitions
    assert machine.startswith(
        "The mode is one of “rolling”, “slowed”, and “stopped”; it starts as “rolling”. It becomes “stopped” from"
    )
    assert machine.endswith("In each cycle, only the first of these changes that applies takes place.")


def test_how_bad_it_is_stands_above_every_form(tmp_path: Path) -> None:
    """A formula and a sentence say the same of a rule that warns and of one that decides."""
    rule, spec = rule_of(tmp_path, 'rule r "r"\n  severity advisory\n  require ego.v <= top\n')
    made = sheet(rule, spec)
    assert next(in_text(made)) == "r: r"
    assert list(in_text(made))[1] == "  severity: advisory"
    assert data(made)["said"] == {"severity": "advisory"}
    assert "<dt>severity</dt><dd>advisory</dd>" in page([made])


@pytest.mark.parametrize(
    ("declared", "condition", "said"),
    [
        (
            "shape moved = { v: m/s }\ndefine speed(o: moved) -> m/s = abs(o.v)\n",
            "ego.v <= speed(ego)",
            "The v of ego is at most the speed of ego.",
        ),
        (
            "signal other : state { v: m/s, speed: m/s }\n",
            "other.v <= other.speed",
            "The v of other is at most the speed of other.",
        ),
        (
            "signal other : state { room: m, x: m }\nshape there = { x: m }\ndefine room(o: there) -> m = o.x - 1 m\n",
            "other.room <= room(other)",
            "The field room of other is at most the room of other.",
        ),
        (
            "signal other : state { v: m/s, heading: rad }\ndefine heading(v: m/s) -> 1 = v / top\n",
            "other.heading <= heading(other.v)",
            "The field heading of other is at most the heading of the speed of other.",
        ),
    ],
)
def test_a_field_is_called_by_no_name_of_something_else(
    declared: str, condition: str, said: str, tmp_path: Path
) -> None:
    """ "The speed of ego is at most the speed of ego" was said of `ego.v` and a definition `speed`."""
    rule, spec = rule_of(tmp_path, f'{declared}rule r "r"\n  require {condition}\n')
    assert tell(rule, spec, ENGLISH).demand == (said,)


def test_what_is_given_to_a_definition_has_one_name_in_its_sentence(tmp_path: Path) -> None:
    """Of a shipped rule, "approach_other" was given, and “approach other” counted."""
    rule, spec = rule_of(
        tmp_path,
        "define later(this_one: moving, how_long: s) -> m = this_one.v * how_long\n"
        'rule r "r"\n  require later(ego, 2 s) <= 3 m\n',
    )
    assert tell(rule, spec, ENGLISH).definitions == (
        "The later of “this one” and “how long” is the speed of “this one” times “how long”.",
    )


@pytest.mark.parametrize(
    ("name", "shown"), [("b_rear", "low_down.b_rear"), ("too_far", "“low_down.too far”")]
)
def test_what_is_told_apart_by_its_module_is_called_as_elsewhere(
    name: str, shown: str, tmp_path: Path
) -> None:
    """`b_rear` was “low down.b rear” beside another one of its name: of a module that there is not, and in other words."""
    (tmp_path / "low_down.spec").write_text(
        f"module low_down\nparam {name} : m = 3 m\npredicate close(x: m) = x < {name}\n", "utf-8"
    )
    (tmp_path / "mid.spec").write_text("module mid\nuse low_down\npredicate near(x: m) = close(x)\n", "utf-8")
    head = f"module made\nuse mid\nsignal ego : state {{ x: m }}\nparam {name} : m = 4 m\n"
    rule, spec = rule_of(tmp_path, f'rule r "r"\n  require near(ego.x) and ego.x > {name}\n', head)
    assert tell(rule, spec, ENGLISH).definitions[1] == (
        f"“close” holds for x exactly when x is less than {shown} (3 m)."
    )


def test_a_boolean_field_is_told_from_a_predicate_of_its_name(tmp_path: Path) -> None:
    """“wet” holds for p exactly when “wet” holds for ego" was said of a shipped rule."""
    rule, spec = rule_of(
        tmp_path, 'predicate wet(p: moving) = ego.wet and p.v > 3 m/s\nrule r "r"\n  for all p in plan\n  require wet(p) and not ego.wet\n'
    )  # fmt: skip
    told = tell(rule, spec, ENGLISH)
    assert told.demand == (
        "For every sample p of plan: “wet” holds for p and the field “wet” does not hold for ego.",
    )
    assert told.definitions == (
        "“wet” holds for p exactly when the field “wet” holds for ego and the speed of p is greater than 3 m/s.",
    )


def test_a_definition_reads_of_the_record_that_it_is_given(tmp_path: Path) -> None:
    """What `needed` comes to was shown as made of `limits`, also where it is given `wet`, of which the values were said nowhere."""
    rule, spec = rule_of(
        tmp_path,
        "shape rss = { response: s, braking: m/s^2 }\n"
        "param limits : rss = { response: 0.5 s, braking: 4 m/s^2 }\nparam wet : rss = { response: 0.7 s, braking: 2 m/s^2 }\n"
        "define needed(v: m/s, l: rss) -> m = v * l.response + v^2 / l.braking\n"
        'rule r "r"\n  require needed(ego.v, limits) <= 120 m and needed(ego.v, wet) <= 90 m and limits.response <= wet.response\n',
    )
    (definition,) = read(rule, spec).definitions
    assert text(definition.body) == "v · response_l + v²/braking_l"
    told = tell(rule, spec, ENGLISH)
    assert told.demand[0].endswith("and limits.response (0.5 s) is at most wet.response (0.7 s).")
    assert told.definitions == (
        "The needed of v and l is v times the response of l plus the square of v divided by the braking of l.",
        "Limits has the response 0.5 s and the braking 4 m/s^2.",
        "Wet has the response 0.7 s and the braking 2 m/s^2.",
    )
    (clause,) = read(rule, spec, None, True).clauses
    assert text(clause.formula) == (
        "v_ego · limits.response + v_ego²/limits.braking ≤ 120 m ∧ v_ego · wet.response + v_ego²/wet.braking ≤ 90 m "
        "∧ limits.response ≤ wet.response"
    )


def test_of_several_conditions_of_a_choice_the_first_is_said_to_count(tmp_path: Path) -> None:
    """At 12 m/s, both hold below: "3 m/s if .., 2 m/s if .." said two limits of one car."""
    rule, spec = rule_of(
        tmp_path,
        'rule r "r"\n  require ego.x / (1 s) <= (if ego.v > 10 m/s then 3 m/s else if ego.v > 5 m/s then 2 m/s else 1 m/s)\n',
    )
    assert tell(rule, spec, ENGLISH).demand[1] == (
        "Here, A is 3 m/s if the speed of ego is greater than 10 m/s, else 2 m/s if the speed of ego is greater than 5 m/s, and otherwise 1 m/s."
    )
    (demand,) = read(rule, spec).clauses
    for shown in (mathml.formula(demand.formula), typst.formula(demand.formula), text(demand.formula)):
        assert [
            " ".join(word.split())
            for word in re.findall(r"else if|if|else", shown.replace("\xa0", " ").replace("&#xa0;", " "))
        ] == ["if", "else if", "else"]


#: How a table is read, its rows, and what stands of that in front of them.
TABLES = {
    "step": ("(h: h) -> km/h = step\n  | 6 h: 25 | 22 h: 15 |", "limit(ego.h)"),
    "linear": ("(h: h) -> km/h = linear\n  | 6 h: 25 | 22 h: 15 |", "limit(ego.h)"),
    "linear clamp": ("(h: h) -> km/h = linear clamp\n  | 6 h: 25 | 22 h: 15 |", "limit(ego.h)"),
    "step wrap 24 h": ("(h: h) -> km/h = step wrap 24 h\n  | 6 h: 25 | 22 h: 15 |", "limit(ego.h)"),
    "step, linear wrap 0.5 km": (
        "(h: h, s: km) -> km/h = step, linear wrap 500 m\n  | s: 0 km, 0.2 km\n  | 6 h: 25, 20 |",
        "limit(ego.h, ego.s)",
    ),
    "linear clamp, linear clamp": (
        "(h: h, s: km) -> km/h = linear clamp\n  | s: 0 km, 0.2 km\n  | 6 h: 25, 20 | 9 h: 20, 10 |",
        "limit(ego.h, ego.s)",
    ),
}


@pytest.mark.parametrize("way", TABLES)
def test_how_a_table_is_read_stands_beside_its_rows(way: str) -> None:
    """Rows alone are the same for steps and for lines between them, and what is outside of them is a value or none."""
    table, asked = TABLES[way]
    spec = loads(
        f"module made\nsignal ego : state {{ v: m/s, h: h, s: km }}\ntable limit{table}\n"
        f'rule slow "s"\n  require ego.v <= {asked}\n'
    )
    made = sheet(spec.rule("slow") or pytest.fail("the rule is gone"), spec)
    (described,) = data(made)["formula"]["tables"]
    assert described["way"] == way
    assert f"limit: {way}" in map(str.strip, in_text(made))
    assert f"</math>: {way}</p>" in page([made])


def test_a_table_a_zone_and_a_state_are_listed() -> None:
    made = read(everything().rule("zone_speed_limit") or pytest.fail("the rule is gone"), everything())
    assert [place.name for place in made.places] == ["tracks.modena.pit_lane"]
    made = read(everything().rule("drive_acceleration") or pytest.fail("the rule is gone"), everything())
    assert [info.name for _, info in made.tables] == ["vehicles.devbot.ax_max"]
    made = read(everything().rule("gives_back") or pytest.fail("the rule is gone"), everything())
    (machine,) = made.machines
    assert (machine.states, machine.start, machine.bridges, len(machine.moves)) == (
        ("free", "ahead", "behind", "won"),
        "free",
        "1 s",
        7,
    )
