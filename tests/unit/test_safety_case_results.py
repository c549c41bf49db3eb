"""Results in the safety case: faults that were put in, runs in a closed loop, drives of real vehicles. Every number is counted again from the evidence."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from support.project import command
from support.safety_case import DAY, Page, edit, html
from trackmarshal.cli import assessment
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.trace.case import loop as results


def under(page: Page, beginning: str) -> dict[str, str]:
    return {id_: text for id_, text in page.numbers if id_.startswith(beginning)}


def picture(page: Page, name: str) -> str:
    """The chart whose name begins so."""
    found: str
    (found,) = [svg for svg in re.findall(r"<svg.*?</svg>", page.html, re.DOTALL) if f"<title>{name}" in svg]
    return found


def words(svg: str) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


# Tests of other runners.


def test_a_report_in_whose_names_nothing_can_be_looked_for_is_not_read(warehouse: Path) -> None:
    """And so it is not one in which no test names a requirement."""
    junit = "  junit: [{path: door.xml, stage: TST-1, names: '(a+)+'}]"
    edit(warehouse, "requirements/v-model.yaml", "  specs: [specs]\n", f"  specs: [specs]\n{junit}\n")
    (warehouse / "door.xml").write_text('<testsuite><testcase name="a"/></testsuite>', "utf-8")
    page = html(warehouse, expect=1).html
    assert "T340" in page
    assert "none that name a requirement" not in page
    assert "nothing is known here: " in page


# Closed loop.


def counted(runs: list[dict[str, Any]]) -> dict[str, str]:
    """All numbers that the document has of runs, counted from the file."""
    found: dict[str, str] = {"loop/all/runs": str(len(runs))}
    inside = [run for run in runs if run["beyond"] == ""]
    found["loop/inside/runs"] = str(len(inside))
    found["loop/inside/bad"] = str(sum(run["outcome"] in ("off_road", "contact") for run in inside))
    for fault in {run["fault"] for run in runs}:
        own = [run for run in runs if run["fault"] == fault]
        begin = f"loop/{fault}"
        found[f"{begin}/runs"] = str(len(own))
        found |= {
            f"{begin}/{outcome}": str(n) for outcome, n in Counter(run["outcome"] for run in own).items()
        }
        finders = Counter(
            run["reaction"]["found"][0] for run in own if run["reaction"] and run["reaction"]["found"]
        )
        found |= {f"{begin}/found/{by}": str(n) for by, n in finders.items()}
        below = sum(run["reaction"] is None and run["below"] is not None for run in own)
        if below:
            found[f"{begin}/below"] = str(below)
        after = [run["reaction"]["after"] for run in own if run["reaction"]]
        if after:
            found[f"{begin}/reaction/least"] = f"{min(after):.2f}"
            if min(after) != max(after):
                found[f"{begin}/reaction/most"] = f"{max(after):.2f}"
        found[f"{begin}/clearance"] = f"{min(run['clearance'] for run in own):.2f}"
        gaps = [run["gap"] for run in own if run["gap"] is not None]
        if gaps:
            found[f"{begin}/gap"] = f"{min(gaps):.1f}"
    return found


def loop(project: Path, these: list[dict[str, Any]], **more: Any) -> Path:
    """A project with kept results."""
    said = {"format": "trackmarshal-closed-loop", "version": 1, "faults": {"P-1": "The planner <hangs>"}, "runs": these, **more}  # fmt: skip
    (project / "loop.json").write_text(json.dumps(said), "utf-8")
    edit(project, "requirements/v-model.yaml", "  specs: [specs]\n", "  specs: [specs]\n  closed_loop: loop.json\n")  # fmt: skip
    return project


RUN = {
    "fault": "P-1", "requirement": "SYS-1", "beyond": "", "track": "hall", "traffic": False, "place": "aisle", "speed": 1.5, "below": None,
    "reaction": {"after": 0.25, "found": ["slow_near_people"]}, "outcome": "stopped", "clearance": 0.5, "gap": None,
}  # fmt: skip


def test_a_run_that_ends_badly_is_counted_and_drawn_as_failed(warehouse: Path) -> None:
    runs = [
        RUN,
        {
            **RUN,
            "place": "dock",
            "outcome": "contact",
            "reaction": None,
            "below": 0.5,
            "gap": 0.125,
            "clearance": -0.25,
        },
    ]
    page = html(loop(warehouse, runs))
    assert under(page, "loop/") == counted(runs)
    assert page.numbers.count(("loop/inside/bad", "1")) == 1
    svg = picture(page, "What became of the car")
    assert "P-1, hall, alone, 1.5 m/s: contact" in svg
    assert re.search(r"<title>P-1, hall, alone, 1.5 m/s: contact</title><rect[^>]*#fbdfe1", svg)
    assert "The planner &lt;hangs&gt;" in svg
    assert "<hangs>" not in page.html


def test_of_several_runs_in_one_situation_the_worst_is_drawn(warehouse: Path) -> None:
    """As of a fault that is put in twice at one place: what came of the last one hid what came of the first."""
    bad = {**RUN, "speed": 2.5, "outcome": "contact"}
    svg = picture(html(loop(warehouse, [RUN, bad, {**RUN, "outcome": "drives_on"}])), "What became of the car")  # fmt: skip
    assert "P-1, hall, alone, 2.5 m/s: contact" in svg
    assert "drives on" not in re.sub(r"<text.*?</text>", "", svg)


def reviewed(project: Path, path: str, sha256: str) -> None:
    """As evidence whose contents somebody has reviewed."""
    entry = f'  - {{path: {path}, title: Runs, stage: TST-1, requirements: [SYS-1], sha256: "{sha256}"}}\n'
    file = project / "requirements" / "v-model.yaml"
    text = file.read_text("utf-8")
    before, found, after = text.partition("\nevidence:\n")
    file.write_text(
        f"{before}\nevidence:\n{entry}{after}" if found else f"{text}\nevidence:\n{entry}", "utf-8"
    )


def standing(page: Page) -> str:
    """What is said of the results where they stand, before what they are, without tags."""
    said = page.html.partition("Runs in a closed loop</h")[2].partition("What became of the car")[0]
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", said))


def test_results_that_nobody_has_reviewed_are_said_to_be_such(warehouse: Path) -> None:
    assert "Whether these results are stale is not known" in standing(html(loop(warehouse, [RUN])))


@pytest.mark.parametrize("changed", [False, True])
def test_results_that_have_changed_since_their_review_are_stale(warehouse: Path, changed: bool) -> None:
    """`trace` has them as changed; here they stood like any others."""
    project = loop(warehouse, [RUN])
    reviewed(project, "loop.json", hashlib.sha256((project / "loop.json").read_bytes()).hexdigest())
    if changed:
        again = (project / "loop.json").read_text("utf-8").replace("stopped", "drives_on")
        (project / "loop.json").write_text(again, "utf-8")
    said = standing(html(project))
    assert ("stale: loop.json has changed since it was reviewed." in said) is changed
    assert ("These results are those that were reviewed, by loop.json." in said) is not changed


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("", "These results are those that were reviewed, by runs.md."),
        ("page", "stale: runs.md has changed since it was reviewed."),
        ("results", "stale: runs.md, which was reviewed, gives another hash of them"),
    ],
)
def test_results_are_those_of_the_page_that_was_reviewed(warehouse: Path, change: str, expected: str) -> None:
    project = loop(warehouse, [RUN])
    held = hashlib.sha256((project / "loop.json").read_bytes()).hexdigest()
    page = project / "runs.md"
    page.write_text(f"SYS-1: the car came to rest.\n\n| `loop.json` | `{held}` |\n", "utf-8")
    reviewed(project, "runs.md", hashlib.sha256(page.read_bytes()).hexdigest())
    if change == "page":
        page.write_text(page.read_text("utf-8") + "More.\n", "utf-8")
    elif change == "results":
        again = (project / "loop.json").read_text("utf-8").replace("stopped", "drives_on")
        (project / "loop.json").write_text(again, "utf-8")
    assert expected in standing(html(project))


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("nightly-loop.json", False), ("old/loop.json", False), ("loop.json.gz", False), ("loop.json", True), ("../loop.json", True),
        ("[loop.json].", True), ("./loop.json:", True),
    ],
)  # fmt: skip
def test_a_page_of_other_results_says_nothing_of_these(warehouse: Path, name: str, known: bool) -> None:
    """A reviewed page that gives the hash of `nightly-loop.json` made `loop.json` stale."""
    project = loop(warehouse, [RUN])
    (project / "runs.md").write_text(f"SYS-1: the car came to rest, in {name} ({'0' * 64})\n", "utf-8")
    assert results.read(project, "loop.json", "1" * 64, ["runs.md"]).pages == (
        {"runs.md": False} if known else {}
    )


@pytest.mark.parametrize(
    ("runs", "more", "said"),
    [
        ([{**RUN, "outcome": "fine"}], {}, "the outcome of run 1 is 'fine'"),
        ([RUN, {**RUN, "speed": "fast"}], {}, "`speed` of run 2 is no finite number"),
        ([{**RUN, "clearance": None}], {}, "`clearance` of run 1"),
        ([{**RUN, "reaction": {"after": 1}}], {}, "the reaction of run 1 does not say what found the fault"),
        ([{**RUN, "reaction": {"found": ["x"], "after": None}}], {}, "`after` of run 1"),
        ([{key: value for key, value in RUN.items() if key != "track"}], {}, "run 1 lacks"),
        ([{**RUN, "traffic": 0}], {}, "run 1 lacks"),
        ([3], {}, "run 1 is no object"),
        ([RUN, {**RUN, "place": "dock"}, RUN], {}, "a run of `P-1` on hall is there twice"),
        ([RUN], {"version": 2}, "`version` 1"),
        ([RUN], {"runs": {}}, "`runs` is to be a list"),
    ],
)
def test_results_that_lack_something_are_refused(
    warehouse: Path, runs: list[Any], more: dict[str, Any], said: str
) -> None:
    loop(warehouse, runs, **more)
    status, _, err = command(warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY)
    assert status == 2
    assert "error[T437]" in err
    assert "loop.json" in err
    assert said in err


def test_an_outcome_that_is_said_twice_is_refused(warehouse: Path) -> None:
    """Readers of JSON take the last one: a contact was counted, and drawn, as a stop."""
    path = loop(warehouse, [RUN]) / "loop.json"
    path.write_text(
        path.read_text("utf-8").replace('"outcome": ', '"outcome": "contact", "outcome": '), "utf-8"
    )
    status, _, err = command(warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY)
    assert (status, "`outcome` is there twice" in err) == (2, True)


def test_not_a_number_in_results_is_refused(warehouse: Path) -> None:
    loop(warehouse, [{**RUN, "speed": float("nan")}])
    assert command(warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY)[0] == 2
    (warehouse / "loop.json").write_text("{", "utf-8")
    assert command(warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY)[0] == 2
    (warehouse / "loop.json").unlink()
    status, _, err = command(warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY)
    assert (status, "error[T437]" in err) == (2, True)


def test_a_project_without_a_closed_loop_is_said_to_have_none(warehouse: Path) -> None:
    assert "No results of a closed loop are declared." in html(warehouse).html


# Faults.


def with_faults(monkeypatch: pytest.MonkeyPatch, cases: list[FaultCase], results: list[FaultResult]) -> None:
    """As if a campaign had been run."""
    real = assessment.assess

    def made(root: Path, **how: Any) -> Any:
        found = real(root, **how)
        found.facts = replace(found.facts, fault_cases=cases)
        found.fault_results = results
        return found

    monkeypatch.setattr(assessment, "assess", made)


def test_each_fault_says_what_found_it_and_how_soon(warehouse: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (warehouse / "one.yaml").write_text("", "utf-8")
    case = [
        FaultCase("one.yaml", f"F-{n}", f"fault {n}", requirement, n, "f" * 64, begin=2.0)
        for n, requirement in enumerate(["SW-1", "SW-1", "SW-2", "SW-2"], 1)
    ]
    case.append(FaultCase("one.yaml", "F-5", "fault 5", "SW-2", 5, "", open="there is no target yet"))
    case.append(FaultCase("two.yaml", "F-1", "another one", "SW-1", 1, "f" * 64, begin=1.0))
    results = [
        FaultResult("one.yaml", "F-1", "passed", "f" * 64, ("slow_near_people",), "", 2.3, 2.5, "previous_emergency", 1.9),
        FaultResult("one.yaml", "F-2", "passed", "f" * 64, ("slow_near_people", "gentle"), "", 2.0, 2.5, "no_safe_trajectory"),
        FaultResult("one.yaml", "F-3", "failed", "f" * 64, (), "", None, None, message="nothing fired"),
        FaultResult("one.yaml", "F-4", "passed", "f" * 64),
        FaultResult("two.yaml", "F-1", "passed", "f" * 64, ("gentle",), "", 1.3, 1.5, "no_safe_trajectory"),
    ]  # fmt: skip
    with_faults(monkeypatch, case, results)
    page = html(warehouse)
    assert under(page, "node/fault/") == {
        "node/fault/one.yaml F-1/after": "0.3", "node/fault/one.yaml F-2/after": "0", "node/fault/two.yaml F-1/after": "0.3",
    }  # fmt: skip
    assert under(page, "nodes/fault/") == {
        "nodes/fault/all": "6", "nodes/fault/covered": "4", "nodes/fault/failed": "1", "nodes/fault/open": "1",
    }  # fmt: skip
    told = picture(page, "Faults by").partition("<desc>")[2].partition("</desc>")[0].split("; ")
    assert told == [
        "SW-1, 0 s: 1", "SW-1, 0.3 s: 2", "SW-2, let pass: 1", "SW-2, otherwise: 1", "SW-2, impossible: 1",
    ]  # fmt: skip
    rows = re.findall(
        r'<td data-label="fault"><code>(F-\d)</code> <span class="given">(.*?)</span></td>.*?<td data-label="found by">(.*?)</td>',
        page.html,
    )
    assert [(id_, title, re.sub("<.*?>", "", by)) for id_, title, by in rows] == [
        ("F-1", "fault 1", "slow_near_people"), ("F-2", "fault 2", "slow_near_people"), ("F-3", "fault 3", "nothing"), ("F-4", "fault 4", "nothing"),
        ("F-5", "fault 5", ""), ("F-1", "another one", "gentle"),
    ]  # fmt: skip
