"""The argument as a whole: it says what the matrix says, from leaves up to the top goal, in modules that fit into pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.gsn.cases import HERE, argued, argument
from support.length import amount
from trackmarshal.trace.gates import falls_short
from trackmarshal.trace.gsn.case import (
    RESERVED,
    STATUSES,
    SUPPORTED,
    UNSUPPORTED,
    Case,
    Element,
    Evidence,
    Link,
    worst,
)
from trackmarshal.trace.gsn.checks import check
from trackmarshal.trace.gsn.grouping import SIDE_BY_SIDE
from trackmarshal.trace.gsn.modules import LIMIT, in_modules
from trackmarshal.trace.gsn.picture.content import content
from trackmarshal.trace.gsn.statuses import below_first, with_statuses
from trackmarshal.trace.matrix import Matrix, Row

#: Edits of results and documents after which the templates still make a whole argument.
STATES = ["T413_failed_test", "T419_test_not_run", "T419_stale_test", "T419_expired_waiver", "T419_requirement_without_rule"]  # fmt: skip


def of_row(matrix: Matrix, row: Row) -> str:
    """How far a requirement is supported, worked out of its cells alone, which have what is below in them."""
    found = [SUPPORTED]
    stages = {str(stage.id): stage for stage in matrix.stages}
    for name, cell in row.cells.items():
        if cell.status == "covered":
            continue
        short = falls_short(row.requirement, stages[name], cell, matrix.demands)
        found.append(UNSUPPORTED if short or cell.status in ("failed", "stale") else RESERVED)
    return worst(found)


@pytest.mark.parametrize("name", ["", *STATES])
def test_goals_say_what_the_matrix_says(name: str, tmp_path: Path) -> None:
    edits = (HERE / f"{name}.case").read_text("utf-8").partition("expect\n")[0] if name else ""
    matrix, case = argument(argued(tmp_path, edits))
    statuses = {
        str(row.requirement.id): (case.elements[f"G-{row.requirement.id}"].status, of_row(matrix, row)) for row in matrix.rows
    }  # fmt: skip
    assert {id_: argued_ for id_, (argued_, _) in statuses.items()} == {id_: said for id_, (_, said) in statuses.items()}  # fmt: skip
    assert case.elements["G-Top"].status == (UNSUPPORTED if name else RESERVED)


@pytest.mark.parametrize(
    ("name", "leaf", "way"),
    [
        ("T413_failed_test", "Sn-S-1-A-2.S-3-B", ["G-S-1-A-2.S-3-B", "G-S-1-A-2", "G-SG-1", "G-H-1", "S-Hazards", "G-Top"]),
        ("T419_stale_test", "Sn-S-1-A-2.S-3-B", ["G-S-1-A-2.S-3-B", "G-S-1-A-2", "G-SG-1", "G-H-1", "S-Hazards", "G-Top"]),
        ("T419_test_not_run", "G-S-1-A-2.S-3-B-Open", ["G-S-1-A-2.S-3-B", "G-S-1-A-2", "G-SG-1", "G-H-1", "S-Hazards", "G-Top"]),
        ("T419_expired_waiver", "G-S-1-B-1.S-3-B-Open", ["G-S-1-B-1.S-3-B", "G-S-1-B-1", "S-Requirements", "G-Top"]),
    ],
)  # fmt: skip
def test_a_leaf_shows_up_to_the_top_goal_and_nowhere_else(name: str, leaf: str, way: list[str], tmp_path: Path) -> None:  # fmt: skip
    edits = (HERE / f"{name}.case").read_text("utf-8").partition("expect\n")[0]
    _, sound = argument(argued(tmp_path / "sound"))
    _, case = argument(argued(tmp_path / "planted", edits))
    assert sound.elements["G-Top"].status == RESERVED
    assert all(case.elements[id_].status == UNSUPPORTED for id_ in [leaf, *way])
    above = {leaf}
    for id_ in below_first(case):
        if above.intersection(case.targets(id_, "supported_by")):
            above.add(id_)
    elsewhere = sound.elements.keys() - above
    assert {i: case.elements[i].status for i in elsewhere if i in case.elements} == {
        i: sound.elements[i].status for i in elsewhere if i in case.elements
    }


def test_a_waived_gap_is_a_reservation_with_its_justification(tmp_path: Path) -> None:
    _, case = argument(argued(tmp_path))
    cell = "G-S-1-B-1.S-3-B"
    assert case.elements[cell].status == RESERVED
    assert case.targets(cell, "in_context_of") == ["J-W-1"]
    assert case.elements[f"{cell}-Open"].undeveloped
    assert case.elements["J-W-1"].text == "Waiver W-1 (the maintainers, until 2026-12-31): Nothing runs in a vehicle yet."  # fmt: skip


def test_a_claim_about_evidence_that_nobody_argues_for_is_not_supported(tmp_path: Path) -> None:
    """It was as supported as the evidence is, to which nothing leads any more."""
    old = "-   - name: evidence\n-     element: solution\n"
    new = old.replace("-   -", "+   -").replace(
        "-     element: solution", "+     element: goal\n+     undeveloped: always"
    )
    _, case = argument(argued(tmp_path, f"edit requirements/argument.yaml\n{old}{new}"))
    claims = [e for e in case.elements.values() if e.about is not None and e.about[0] == "evidence"]
    assert len(claims) > 5
    assert {(e.kind, e.undeveloped, e.status) for e in claims} == {("goal", True, UNSUPPORTED)}


def test_every_solution_names_its_evidence_by_hash(tmp_path: Path) -> None:
    _, case = argument(argued(tmp_path / "one"))
    held = [one for e in case.elements.values() for one in e.evidence]
    assert {one.kind for one in held} >= {"interface", "requirement", "adoption", "document", "rule", "monitor", "assumption", "test", "run"}  # fmt: skip
    by_meaning = {"rule", "monitor", "assumption"}  # whose fingerprints are made up in this project
    assert all(len(one.sha256) == (8 if one.kind in by_meaning else 64) for one in held)
    architecture = next(one for one in held if one.kind == "document")
    assert architecture.sha256 == "3853cd4feee093744d733b9cb2d5e5286450fa58823df4b7d9bdbe904f87d986"
    edits = (HERE / "T413_failed_test.case").read_text("utf-8").partition("expect\n")[0]
    _, other = argument(argued(tmp_path / "other", edits))
    before = {(one.kind, one.name): one.sha256 for one in held}
    now = {(one.kind, one.name): one.sha256 for e in other.elements.values() for one in e.evidence}
    assert [key for key in before if before[key] != now[key]] == [("test", "gap: inside")]


def test_defeaters_answered_upheld_and_open(tmp_path: Path) -> None:
    statuses = {}
    for state, more in (("open", ""), ("answered", ", answer: They are of this week."), ("upheld", "")):
        entry = (
            f"{{id: D-1, challenges: S-1-A-2, text: Maps are old., owner: Ada Reader, state: {state}{more}}}"
        )
        edits = f"edit requirements/argument.yaml\n- top: top\n+ defeaters:\n+   - {entry}\n+ top: top\n"
        _, case = argument(argued(tmp_path / state, edits))
        assert case.targets("CG-D-1", "challenges") == ["G-S-1-A-2"]
        statuses[state] = case.elements["G-S-1-A-2"].status, case.elements["G-SG-1"].status
    assert statuses == {"open": (RESERVED, RESERVED), "answered": (SUPPORTED, RESERVED), "upheld": (UNSUPPORTED, UNSUPPORTED)}  # fmt: skip


def test_what_is_said_against_something_beside_a_claim_is_said_against_the_claim(tmp_path: Path) -> None:
    """A gap is bearable because of its waiver: where that justification is defeated, nothing bears it."""
    cell, found = "G-S-1-B-1.S-3-B", {}
    for state, more in (("open", ""), ("answered", ", answer: It does not."), ("upheld", "")):
        entry = (
            f"{{id: D-1, challenges: W-1, text: It drives already., owner: Ada Reader, state: {state}{more}}}"
        )
        edits = f"edit requirements/argument.yaml\n- top: top\n+ defeaters:\n+   - {entry}\n+ top: top\n"
        _, case = argument(argued(tmp_path / state, edits))
        assert case.targets("CG-D-1", "challenges") == ["J-W-1"]
        codes = {finding.code for finding in case.findings if "J-W-1" in finding.message}
        found[state] = case.elements[cell].status, codes
    assert found == {"open": (RESERVED, {"T413"}), "answered": (RESERVED, set()), "upheld": (UNSUPPORTED, {"T414"})}  # fmt: skip


def test_the_baseline_knows_defeaters_and_templates(tmp_path: Path) -> None:
    entry = "{id: D-1, challenges: S-1-A-2, text: Maps are old., owner: Ada Reader, state: open}"
    small = argued(
        tmp_path, f"edit requirements/argument.yaml\n- top: top\n+ defeaters:\n+   - {entry}\n+ top: top\n"
    )
    small.accept()
    assert not [f for f in small.matrix().findings if f.code == "T376"]
    answered = entry.replace("state: open", "state: answered, answer: They are not.")
    for old, new, said in (
        (entry, answered, "of the defeater `D-1` changed since the baseline was accepted"),
        (f"defeaters:\n  - {answered}\n", "", "the defeater `D-1` is gone"),
        (
            'text: "{summary}."',
            "text: It was seen.",
            "the `templates` of the argument changed since the baseline was accepted",
        ),
    ):
        small.replace("requirements/argument.yaml", old, new)
        told = [f.message for f in small.matrix().findings if f.code == "T376"]
        assert any(said in message for message in told), told


def test_a_project_without_hazards_begins_at_requirements(tmp_path: Path) -> None:
    small = argued(tmp_path)
    (small.root / "requirements" / "hazards.yaml").unlink()
    small.replace("requirements/criteria.yaml", "    title: Limits\n", "    title: Limits\n    adopted: So it is.\n")  # fmt: skip
    _, case = argument(small)
    assert case.targets("G-Top", "supported_by") == ["S-Requirements"]
    assert {"G-S-1-A-1", "G-S-1-A-2", "G-S-1-A-5", "G-S-1-B-1"} <= case.elements.keys()
    assert case.findings == ()


def test_the_program_s_templates_are_those_of_a_project_without_its_own(tmp_path: Path) -> None:
    own = argued(tmp_path)
    _, with_own = argument(own)
    (own.root / "requirements" / "argument.yaml").unlink()
    _, without = argument(own)

    def strip(case: Any) -> dict[str, Any]:
        return {i: e._replace(origin=None) for i, e in case.elements.items()}

    assert strip(with_own) == strip(without)


# Arguments of any form: trees and graphs of goals, strategies and solutions.
FOUND = (Evidence("test", "a: b", "covered", "0" * 64, None),)


class Drawn(NamedTuple):
    """A case that says little of itself: hypothesis prints what it draws."""

    case: Case

    def __repr__(self) -> str:
        return "; ".join(f"{link.source} {link.kind} {link.target}" for link in self.case.links)[:4000]


@st.composite
def cases(draw: st.DrawFn) -> Drawn:
    number = draw(st.integers(1, 120))
    kinds = ["goal", *(draw(st.lists(st.sampled_from(["goal", "goal", "strategy", "solution", "context"]), min_size=number, max_size=number)))]  # fmt: skip
    elements = {
        f"E{n}": Element(f"E{n}", kind, "A text.", None, None, leaf=draw(st.sampled_from(STATUSES)), evidence=FOUND if kind == "solution" else ())
        for n, kind in enumerate(kinds)
    }  # fmt: skip
    links: dict[Link, None] = {}
    narrow = draw(st.sampled_from([1, 3, 40]))
    for n in range(1, len(kinds)):
        for _ in range(draw(st.sampled_from([1, 1, 1, 2]))):
            above = [m for m in range(max(0, n - narrow * 8), n) if kinds[m] in ("goal", "strategy")]
            at = above[draw(st.integers(0, max(0, min(len(above), narrow) - 1)))] if above else 0
            kind = "in_context_of" if kinds[n] == "context" else "supported_by"
            links[Link(kind, f"E{at}", f"E{n}", None)] = None
    return Drawn(Case("any", elements, tuple(links)))


def leaves(case: Case, top: str) -> dict[str, str]:
    """What is below an element with nothing below it, over all modules, with its status."""
    seen, todo, found = {top}, [top], {}
    while todo:
        at = todo.pop()
        below = case.targets(at, "supported_by")
        if not below:
            found[at] = case.elements[at].status
        for other in below:
            if other not in seen:
                seen.add(other)
                todo.append(other)
    return found


@settings(max_examples=amount(10, 60), deadline=None)
@given(cases())
def test_modules_fit_into_pictures_and_change_nothing(drawn: Drawn) -> None:
    case = drawn.case
    whole = with_statuses(case)
    made = with_statuses(in_modules(case, "", {f"E{n}" for n in range(0, 120, 7)}))
    top = "E0"
    assert leaves(made, top) == leaves(whole, top)
    assert {i: made.elements[i].status for i in case.elements} == {
        i: e.status for i, e in whole.elements.items()
    }
    assert all(len(made.targets(i, "supported_by")) <= SIDE_BY_SIDE for i in made.elements)
    names = [module.name for module in made.modules]
    assert len(names) == len(set(names))
    assert {e.module for e in made.elements.values()} <= set(names)
    most = max(len(made.targets(i, "in_context_of")) for i in made.elements)
    for module in made.modules:
        shown = content(made, module).shown
        assert len(shown) <= max(LIMIT, most + 1 + SIDE_BY_SIDE), module
        assert all(one.element.public for one in shown.values() if one.away and one.element.kind == "goal")
    again = with_statuses(in_modules(case, "", {f"E{n}" for n in range(0, 120, 7)}))
    assert (made.elements, made.links, made.modules) == (again.elements, again.links, again.modules)


def test_a_goal_put_over_a_strategy_fits_with_it() -> None:
    """Strategies cannot be cited; each of these fits into a picture by itself, and not with a goal above it."""
    elements = {"E0": Element("E0", "goal", "A text.", None, None)}
    links = []
    for s in range(3):
        elements[f"S{s}"] = Element(f"S{s}", "strategy", "A text.", None, None)
        links.append(Link("supported_by", "E0", f"S{s}", None))
        for g in range(6):
            elements[f"G{s}{g}"] = Element(f"G{s}{g}", "goal", "A text.", None, None)
            links.append(Link("supported_by", f"S{s}", f"G{s}{g}", None))
            for n in range(3):
                id_ = f"Sn{s}{g}{n}"
                elements[id_] = Element(
                    id_, "solution", "A text.", None, None, leaf=SUPPORTED, evidence=FOUND
                )
                links.append(Link("supported_by", f"G{s}{g}", id_, None))
        for c in range(17):
            elements[f"C{s}{c}"] = Element(f"C{s}{c}", "context", "A text.", None, None)
            links.append(Link("in_context_of", f"S{s}", f"C{s}{c}", None))
    made = in_modules(Case("strategies", elements, tuple(links)), "", ())
    assert max(len(content(made, module).shown) for module in made.modules) <= LIMIT
    assert with_statuses(made).elements["E0"].status == SUPPORTED


def chain(number: int) -> Case:
    """Goals each supported by the next."""
    elements = {f"E{n}": Element(f"E{n}", "goal", "A text.", None, None) for n in range(number)}
    elements["E-end"] = Element("E-end", "solution", "A text.", None, None, leaf=UNSUPPORTED, evidence=FOUND)
    names = list(elements)
    return Case("deep", elements, tuple(Link("supported_by", a, b, None) for a, b in zip(names, names[1:])))


def star(number: int) -> Case:
    """One goal, with everything below it."""
    elements = {f"E{n}": Element(f"E{n}", "solution", "A text.", None, None, leaf=SUPPORTED, evidence=FOUND) for n in range(number)}  # fmt: skip
    elements["E0"] = Element("E0", "goal", "A text.", None, None)
    return Case("wide", elements, tuple(Link("supported_by", "E0", f"E{n}", None) for n in range(1, number)))


#: More than Python nests calls.
MANY = amount(2_500, 10_000)


@pytest.mark.parametrize(("case", "status"), [(chain(MANY), UNSUPPORTED), (star(MANY), SUPPORTED)])
def test_thousands_of_elements_below_and_beside_each_other(case: Case, status: str) -> None:
    made = with_statuses(in_modules(case, "", ()))
    assert made.elements["E0"].status == status
    assert max(len(content(made, module).shown) for module in made.modules) <= LIMIT
    assert len(leaves(made, "E0")) == len(leaves(with_statuses(case), "E0"))
    assert all(f.code == "T419" for f in check(made))
