"""Decomposed requirements: whether a goal is served by enough of the parts, and whether these are argued to be independent (ISO 26262-9, clause 5)."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from support.planted.project import SOURCE
from support.project import command
from support.safety_case import edit, html

NEEDS, DESIGN, PEOPLE, HAZARDS = (
    f"requirements/{name}.yaml" for name in ("requirements", "design", "assurance", "hazards")
)
WHOLE = "    derived_from: [SH-TP]\n    achieves: [SG-1]\n    allocated_to: [DE-1, DE-2]\n"
PLANNED = "    refines: [S-3]\n    allocated_to: [DE-2]\n"
SUPERVISED = "    refines: [S-3]\n    allocated_to: [DE-1]\n"
BRAKES = "    derived_from: [SH]\n    achieves: [SG-1]\n    allocated_to: [DE-1]\n    owner: P-1\n    status: approved\n    asil: C\n    verified_by: [M-1]\n    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [test, fault injection]\n    metrics: [braking]\n"
_RATED = "title: A bag falls, situation: A bag falls from the rack., severity: S1, exposure: E2, controllability: C1, asil: QM, rationale: It is light."
LOAD = "".join(f"  - {{id: HZ-{number}, {_RATED}}}\n" for number in (2, 3))
HELD = "  - {id: SG-2, title: Bags stay, statement: The shuttle shall hold bags., prevents: [HZ-2], asil: QM, safe_state: at rest, tolerance: 1 s}\n"


@pytest.fixture
def shuttle(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SOURCE, tmp_path / "shuttle"))


def findings(project: Path, *codes: str) -> list[str]:
    _, out, _ = command(project, "trace", "--as-is", "--format", "json")
    return [f"{f['code']} {f['message']}" for f in json.loads(out)["findings"] if f["code"] in codes]


def serving(project: Path, *texts: str) -> None:
    """The goal is served by these parts of S-3, and by S-3 no longer."""
    edit(project, NEEDS, WHOLE, WHOLE.replace("    achieves: [SG-1]\n", ""))
    for text in texts:
        edit(project, NEEDS, text, f"    achieves: [SG-1]\n{text}")


def test_a_part_alone_serves_no_goal_above_it(shuttle: Path) -> None:
    serving(shuttle, PLANNED)
    lone = "T160 `S-31` has ASIL A(C), below the safety goal `SG-1`, which it serves, with C; neither what it is a part of serves it, nor enough of the other parts"
    assert findings(shuttle, "T160") == [lone]


def test_all_parts_together_serve_the_goal_of_the_whole(shuttle: Path) -> None:
    serving(shuttle, PLANNED, SUPERVISED)
    assert findings(shuttle, "T160") == []


def test_a_part_may_name_the_goal_that_the_whole_serves(shuttle: Path) -> None:
    edit(shuttle, NEEDS, PLANNED, f"    achieves: [SG-1]\n{PLANNED}")
    assert findings(shuttle, "T160") == []


def test_what_is_demanded_no_longer_serves_no_goal_for_its_parts(shuttle: Path) -> None:
    edit(shuttle, NEEDS, PLANNED, f"    achieves: [SG-1]\n{PLANNED}")
    text = (shuttle / NEEDS).read_text("utf-8")
    whole = text[text.index("  - id: S-3\n") : text.index("  - id: S-31\n")]
    edit(shuttle, NEEDS, whole, whole.replace("status: approved", "status: obsolete"))
    assert [said.split()[1] for said in findings(shuttle, "T160")] == ["`S-31`"]


def test_parts_of_parts_count_for_what_they_make_together(shuttle: Path) -> None:
    serving(shuttle, PLANNED)
    text = (shuttle / NEEDS).read_text("utf-8")
    part = text[text.index("  - id: S-32\n") : text.index("  - id: S-4\n")]
    below = part.replace("    metrics: [keeps_clear]\n", "").replace("asil: B(C)", "asil: A(C)")
    below = below.replace("refines: [S-3]\n", "refines: [S-32]\n    achieves: [SG-1]\n")
    one, other = (below.replace("id: S-32\n", f"id: S-3{number}\n") for number in (3, 4))
    (shuttle / NEEDS).write_text(text.replace(part, part + one + other), "utf-8")
    assert findings(shuttle, "T160") == []
    (shuttle / NEEDS).write_text(text.replace(part, part + one), "utf-8")
    assert [said.split()[1] for said in findings(shuttle, "T160")] == ["`S-31`", "`S-33`"]


def further(project: Path, below: Callable[[str], list[str]]) -> None:
    """Further requirements, made of the part S-32."""
    text = (project / NEEDS).read_text("utf-8")
    part = text[text.index("  - id: S-32\n") : text.index("  - id: S-4\n")]
    made = below(part.replace("    metrics: [keeps_clear]\n", ""))
    (project / NEEDS).write_text(text.replace(part, part + "".join(made)), "utf-8")


def test_a_part_of_two_parts_counts_once(shuttle: Path) -> None:
    serving(shuttle)
    both = "refines: [S-31, S-32]\n    achieves: [SG-1]\n"
    further(shuttle, lambda part: [part.replace("S-32", "S-33").replace("refines: [S-3]\n", both)])
    assert [said.split()[1] for said in findings(shuttle, "T160")] == ["`S-33`"]


@pytest.mark.acceptance
def test_parts_of_parts_may_go_deeper_than_the_stack(shuttle: Path) -> None:
    serving(shuttle)

    def chain(part: str) -> list[str]:
        ids = ["S-32", *(f"S-{number}" for number in range(1000, 2200))]
        made = [part.replace("S-32", id_).replace("[S-3]", f"[{above}]") for above, id_ in pairwise(ids)]
        return [*made[:-1], made[-1].replace("    refines", "    achieves: [SG-1]\n    refines")]

    further(shuttle, chain)
    assert [said.split()[1] for said in findings(shuttle, "T160")] == ["`S-2199`"]


def test_independence_is_argued_by_an_analysis_of_dependent_failures(shuttle: Path) -> None:
    edit(shuttle, PEOPLE, "method: dependent failures", "method: timing")
    said = "T162 the ASIL of `S-3` is decomposed, and what it names under `independence` is no analysis of dependent failures: `AN-1` (timing)"
    assert findings(shuttle, "T162") == [said]


@pytest.mark.parametrize(("level", "wrong"), [("B(C)", True), ("B", True), ("C", False)])
def test_parts_on_one_element_fail_together(shuttle: Path, level: str, wrong: bool) -> None:
    edit(shuttle, NEEDS, PLANNED, PLANNED.replace("DE-2", "DE-1"))
    edit(shuttle, DESIGN, "It judges every plan., asil: C", f"It judges every plan., asil: {level}")
    said = f"T162 `S-31` and `S-32`, parts of `S-3` with C, both stand and fall with the design element `DE-1`, which is developed to {level}"
    assert findings(shuttle, "T162") == [said] * wrong


@pytest.mark.parametrize(("level", "wrong"), [("B(C)", True), ("QM(C)", False)])
def test_what_is_left_to_a_part_says_whether_advice_is_enough(shuttle: Path, level: str, wrong: bool) -> None:
    edit(shuttle, NEEDS, "    asil: B(C)\n", f"    asil: {level}\n")
    edit(shuttle, "specs/rules.spec", "  satisfies S-32\n", "  satisfies S-32\n  severity  advisory\n")
    assert bool(findings(shuttle, "T219")) == wrong


def test_parts_may_have_an_element_in_common_beside_their_own(shuttle: Path) -> None:
    edit(shuttle, DESIGN, "elements:\n", "elements:\n  - {id: DE-3, title: bus, asil: B(C), owner: P-1}\n")
    edit(shuttle, NEEDS, PLANNED, PLANNED.replace("[DE-2]", "[DE-2, DE-3]"))
    edit(shuttle, NEEDS, SUPERVISED, SUPERVISED.replace("[DE-1]", "[DE-1, DE-3]"))
    assert findings(shuttle, "T162") == []


@pytest.mark.parametrize("emptied", [False, True])
def test_an_analysis_that_nobody_wrote_down_answers_no_method(shuttle: Path, emptied: bool) -> None:
    lacking = "T255 `S-3` is to be verified by analysis"
    assert not [said for said in findings(shuttle, "T255") if said.startswith(lacking)]
    if emptied:
        (shuttle / "docs/independence.md").write_text("# Independence\n", "utf-8")
    else:
        edit(shuttle, PEOPLE, "    document: docs/independence.md\n", "")
    assert [said for said in findings(shuttle, "T255") if said.startswith(lacking)]
    assert "its document is not there, so that independence is not shown" in html(shuttle).html


def test_a_goal_for_what_needs_none_is_argued_for(shuttle: Path) -> None:
    """A hazard rated QM may have a goal all the same; what serves that goal alone is a part of the argument."""
    edit(shuttle, HAZARDS, "safety_goals:\n", LOAD + "safety_goals:\n" + HELD)
    edit(shuttle, NEEDS, BRAKES, BRAKES.replace("SG-1", "SG-2"))
    _, out, err = command(shuttle, "gsn", "--format", "json")
    made = json.loads(out)
    assert not [f for f in made["findings"] if f["code"] in ("T402", "T406", "T421")], err
    found = {element["id"]: element for element in made["elements"]}
    assert "G-SG-2" in found
    assert "J-HZ-2" not in found
    assert "J-HZ-3" in found


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("document: docs/independence.md", "S, finished on 2026-02-11."),
        ("document: docs/independence.md, open: [Fog.]", "S, as it was on 2026-02-11. It leaves open: Fog."),
        ("open: [Fog.]", "S, as it was on 2026-02-11. It leaves open: Fog."),
        ("owner", "S, of 2026-02-11, which nobody wrote down."),
    ],
)
def test_the_argument_says_how_far_the_hazards_were_analysed(shuttle: Path, more: str, said: str) -> None:
    """Of an analysis that leaves something open, it said that it was finished."""
    entry = f"  - {{id: AN-2, title: S, method: hazard analysis, of: [HZ-1], by: [P-2], made: 2026-02-11, {more}}}\n"
    edit(shuttle, PEOPLE, "analyses:\n", "analyses:\n" + entry.replace(", owner}", "}"))
    _, out, _ = command(shuttle, "gsn", "--format", "json")
    (text,) = [element["text"] for element in json.loads(out)["elements"] if element["id"] == "J-AN-2"]
    assert text == f"The hazards were found by the hazard analysis AN-2, {said}"
