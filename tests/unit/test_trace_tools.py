"""Confidence in tools: the level by the table of the standard, what is not described, what is not there; and how the safety case says it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import yaml

from support.project import command
from support.safety_case import DAY, Page, html
from trackmarshal.trace.graph.tools import by_table_3

#: ISO 26262-8, table 3, row by row: TI1 and TI2; columns TD1 to TD3.
TABLE = (("TCL1", "TCL1", "TCL1"), ("TCL1", "TCL2", "TCL3"))


TOOL: dict[str, object] = {"id": "TL-1", "title": "the planner's compiler", "version": "13.2", "impact": "TI2", "detection": "TD2", "confidence": "TCL2", "rationale": "Nobody <looked> closer."}  # fmt: skip
FAULT: dict[str, object] = {"id": "MF-1", "title": "It drops a branch", "of_tool": ["TL-1"], "effect": "The robot does not stop.", "noticed": "By tests.", "shown_in": ["requirements/needs.yaml"]}  # fmt: skip


def tools(project: Path, tools: list[dict[str, object]], malfunctions: list[dict[str, object]]) -> list[str]:
    """Findings about tools, code and message, of a project with these."""
    said: dict[str, object] = {"document": "assurance", "title": "tools", "tools": tools}
    if malfunctions:
        said["malfunctions"] = malfunctions
    (project / "requirements/tools.yaml").write_text(json.dumps(said), "utf-8")
    _, out, _ = command(project, "trace", "--as-is", "--format", "json", "--day", DAY)
    found = json.loads(out)["findings"]
    return [f"{one['code']} {one['message']}" for one in found if one["level"] == "error"]


def without(record: dict[str, object], *names: str) -> dict[str, object]:
    return {name: value for name, value in record.items() if name not in names}


def test_the_level_is_that_of_the_table() -> None:
    for row, impact in zip(TABLE, ("TI1", "TI2"), strict=True):
        for level, detection in zip(row, ("TD1", "TD2", "TD3"), strict=True):
            assert by_table_3(impact, detection) == level
    assert by_table_3("TI1", "") == "TCL1"
    assert by_table_3("TI2", "") == ""
    for wrong in (("TI3", "TD1"), ("TI2", "TD4"), ("", "TD1")):
        with pytest.raises(ValueError, match="no classes"):
            by_table_3(*wrong)


def test_a_tool_that_is_argued_over_is_fine(warehouse: Path) -> None:
    assert tools(warehouse, [TOOL], [FAULT]) == []
    assert tools(warehouse, [{**TOOL, "impact": "TI1", "confidence": "TCL1"}], []) == []
    # Confidence that is claimed and not argued is shown as it stands.
    assert tools(warehouse, [without(TOOL, "impact", "detection")], []) == []


@pytest.mark.parametrize(
    ("tool", "malfunctions", "expected"),
    [
        ({**TOOL, "confidence": "TCL1"}, [FAULT], "T176 the tool `TL-1` has the confidence level TCL1; TI2 and TD2 make it TCL2"),
        ({**TOOL, "impact": "TI1"}, [FAULT], "T176 the tool `TL-1` has the confidence level TCL2; TI1 makes it TCL1"),
        (without(TOOL, "confidence"), [FAULT], "T176 the tool `TL-1` has no confidence level; TI2 and TD2 make it TCL2"),
        (without(TOOL, "detection"), [FAULT], "T176 the tool `TL-1` has the impact TI2, and no error detection is given"),
        (TOOL, [], "T177 a fault of the tool `TL-1` could do harm, and no malfunction of it is described"),
        (TOOL, [{**FAULT, "shown_in": ["docs/nowhere.md"]}], "T250 the document `docs/nowhere.md` of the malfunction `MF-1` is not there"),
        (TOOL, [FAULT, {**FAULT, "id": "MF-2", "of_tool": ["TL-2"]}], "T151 the malfunction `MF-2` has the link `malfunction_of` to `TL-2`, and there is no such tool"),
    ],
)  # fmt: skip
def test_what_does_not_hold_is_one_error(
    warehouse: Path, tool: dict[str, object], malfunctions: list[dict[str, object]], expected: str
) -> None:
    found = tools(warehouse, [tool], malfunctions)
    assert len(found) == 1, found
    assert found[0] == expected


def part(page: Page, id_: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", page.html.partition(f'id="{id_}"')[2].partition('<div class="part')[0]).split())  # fmt: skip


def test_the_case_says_what_a_fault_could_do_and_how_it_is_noticed(warehouse: Path) -> None:
    tools(
        warehouse,
        [TOOL, {**TOOL, "id": "TL-2", "title": "its linker"}],
        [{**FAULT, "of_tool": ["TL-1", "TL-2"]}],
    )
    page = html(warehouse)
    tool, fault = part(page, "tool-TL-1"), part(page, "malfunction-MF-1")
    assert "Nobody &lt;looked&gt; closer." in tool
    assert "TCL2 qualification is needed" in tool
    assert "needed at this level, and not recorded" in tool
    assert "not reviewed" in tool
    assert "✎ The robot does not stop." in fault
    assert "✎ By tests." in fault
    assert '<a href="#document-requirements-needs-yaml">requirements/needs.yaml</a>' in page.html
    # The fault stands once, and the second tool leads to it.
    assert page.html.count('id="malfunction-MF-1"') == 1
    assert re.search(
        r'id="tool-TL-2".*?<dt>see also</dt><dd><a href="#malfunction-MF-1">', page.html, re.DOTALL
    )


def test_a_tool_without_malfunctions_is_said_to_have_none(warehouse: Path) -> None:
    tools(warehouse, [TOOL], [])
    assert "What a fault of it could do is not described." in html(warehouse).html


def test_results_of_tests_stand_behind_their_files(warehouse: Path) -> None:
    (warehouse / "checks").mkdir()
    (warehouse / "checks/test_a.py").write_text("def test_a(): pass\n", "utf-8")
    cases = "".join(
        f'<testcase classname="checks.test_a" name="t{n}" file="checks/test_a.py" line="1"><properties><property name="verifies" value="SW-1"/></properties>{inner}</testcase>'
        for n, inner in enumerate(["", "", '<failure message="no"/>'])
    )  # fmt: skip
    (warehouse / "report.xml").write_text(f'<testsuite name="s" tests="3">{cases}</testsuite>', "utf-8")
    model = warehouse / "requirements/v-model.yaml"
    text = model.read_text("utf-8").replace("  specs: [specs]\n", "  specs: [specs]\n  junit: [{path: report.xml, stage: TST-1, tool: t}]\n")  # fmt: skip
    model.write_text(text.replace("counts: [test]", "counts: [test, external test]"), "utf-8")
    tools(warehouse, [TOOL], [{**FAULT, "shown_in": ["checks/test_a.py"]}])
    numbers = dict(html(warehouse).numbers)
    assert numbers["tests/checks/test_a.py/passed"] == "2"
    assert numbers["tests/checks/test_a.py/failed"] == "1"


def test_the_example_of_the_page_is_fine(warehouse: Path) -> None:
    page = (Path(__file__).parents[2] / "docs/safety-case.md").read_text("utf-8")
    (example,) = re.findall(r"```yaml\n(tools:\n.*?)```", page, re.DOTALL)
    (warehouse / "tests").mkdir()
    (warehouse / "tests/test_evaluators.py").write_text("def test_both(): pass\n", "utf-8")
    said = yaml.safe_load(example)
    assert tools(warehouse, said["tools"], said["malfunctions"]) == []
    assert "Both evaluators are held against each other." in part(html(warehouse), "malfunction-MF-3")
