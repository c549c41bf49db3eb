"""The matrix page: all of the graph is in its JSON, safe against whatever titles say; beside it rules, tests and entries of the evidence store."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from golden.trace.cases import HERE, Small, apply
from golden.trace.test_renders import broken
from support.project import command, copy_project
from support.safety_case import DAY, made_ready
from support.walk import Walk
from trackmarshal import trace

#: What a title may hold: ends of elements, comments, markup, LaTeX, line ends that scripts know.
HOSTILE = "</script><script>window.hit=1</script><!-- <b onclick=x>$\\frac{1}{2}$ \\u003c &lt; ${1} \u2028 '\" `code"


def edited(folder: Path) -> Small:
    """A project with everything wrong that the golden cases of the renders have."""
    small = Small.copy(folder)
    apply(small, (HERE / "all_kinds.edits").read_text("utf-8").splitlines())
    return small


def orphaned(folder: Path) -> Small:
    """A link to what there is not, a run that was not made, a fault, a waiver."""
    small = Small.copy(folder)
    return small.replace(
        "requirements/criteria.yaml", "    metrics: [friction]", "    metrics: [friction, slip]"
    )


def page_of(small: Small) -> tuple[trace.Matrix, Walk]:
    matrix = small.matrix()
    return matrix, Walk(trace.render(matrix, "html"))


@pytest.fixture(params=["passing", "all kinds", "orphaned", "broken"])
def small(request: pytest.FixtureRequest, tmp_path: Path) -> Small:
    return {"passing": lambda _: Small(), "all kinds": edited, "orphaned": orphaned, "broken": broken}[
        request.param
    ](tmp_path)


def test_every_node_is_there(small: Small) -> None:
    matrix, walk = page_of(small)
    assert list(walk.nodes) == list(matrix.graph.nodes)
    for key, node in matrix.graph.nodes.items():
        title, place, _, said = walk.nodes[key]
        assert (title, place) == (node.title, "" if node.place is None else str(node.place))
        assert said == {name: text for name, text in node.attributes.items() if text}


def test_every_link_is_there(small: Small) -> None:
    """As `trace --format json` lists them, where a result is called by its outcome."""
    matrix, walk = page_of(small)
    told = Counter(
        (kind, walk.nodes[source][3]["outcome"] if kind == "result" else source[1], target[1], state, place)
        for kind, source, target, state, place in walk.links
    )
    listed = [
        tuple(link[name] for name in ("kind", "source", "target", "state", "span"))
        for link in json.loads(trace.render(matrix, "json"))["links"]
    ]
    assert set(told) == set(listed)
    assert sum(told.values()) == len(matrix.graph.links)


def test_links_that_lead_nowhere_are_there_too(tmp_path: Path) -> None:
    _, walk = page_of(orphaned(tmp_path))
    lost = [link for link in walk.links if link[3] == "orphaned"]
    assert ("rule", "slip") in [target for _, _, target, _, _ in lost]


def test_cells_are_those_of_the_json(small: Small) -> None:
    matrix, walk = page_of(small)
    for requirement in json.loads(trace.render(matrix, "json"))["requirements"]:
        own = walk.cells[requirement["id"]]
        assert list(own) == list(requirement["stages"])
        for stage, cell in requirement["stages"].items():
            status, items = own[stage]
            assert status == cell["status"]
            assert [item[2:] for item in items] == [
                (item["status"], item["detail"]) for item in cell["items"]
            ]
            for (_, name, _, _), item in zip(items, cell["items"]):
                assert item["name"] in name, item


def test_what_counts_is_a_node(small: Small) -> None:
    """All that counts in a cell can be walked on from, but for reasons, which are texts, and what is not there."""
    matrix, walk = page_of(small)
    for cells in walk.data["cells"]:
        for _, _, items in cells:
            for _, _, node, *rest in items:
                if node < 0:
                    kind, name, *_ = rest
                    assert kind == "adoption" or (kind, name) not in matrix.graph.nodes
                    assert kind in (
                        "adoption",
                        "rule",
                        "interface",
                        "requirement",
                        "assumption",
                        "monitor",
                        "design element",
                        "analysis",
                        "external test",
                    )


def test_without_a_script_the_cells_stand_as_a_table(small: Small) -> None:
    matrix, walk = page_of(small)
    head, *rows = walk.elements.without
    assert [cell[: len(stage.id)] for cell, stage in zip(head[1:], matrix.stages, strict=True)] == [
        stage.id for stage in matrix.stages
    ]
    assert len(rows) == len(matrix.rows)
    for cells, row in zip(rows, matrix.rows):
        assert cells[0].startswith(row.requirement.id)
        assert row.requirement.title in cells[0]
        for cell, stage in zip(cells[1:], matrix.stages, strict=True):
            assert cell.split()[-1] == (row.cells[stage.id].status if stage.id in row.cells else "–")


def test_titles_are_text(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    title = json.dumps(HOSTILE, ensure_ascii=True)
    small.replace("requirements/criteria.yaml", "    title: Grip\n", f"    title: {title}\n")
    matrix, walk = page_of(small)
    assert any(node.title == HOSTILE for node in matrix.graph.nodes.values())
    plain = Walk(trace.render(Small().matrix(), "html"))
    assert [kind for kind, _ in walk.elements.scripts] == [kind for kind, _ in plain.elements.scripts]
    assert HOSTILE in [title for title, *_ in walk.nodes.values()]
    assert Counter(walk.elements.tags) - Counter(plain.elements.tags) == Counter()  # not one element more
    assert any(HOSTILE in cells[0] for cells in walk.elements.without)
    held = next(text for kind, text in walk.elements.scripts if kind == "application/json")
    assert "<" not in held


def test_places_on_the_page_are_there_once(small: Small) -> None:
    _, walk = page_of(small)
    assert all(number == 1 for number in Counter(walk.elements.ids).values())
    for href in walk.elements.hrefs:
        assert "=" in href or href.removeprefix("#") in walk.elements.ids, href


def test_addresses_name_what_is_there(small: Small) -> None:
    from urllib.parse import parse_qs

    _, walk = page_of(small)
    for href in walk.elements.hrefs:
        said = parse_qs(href.removeprefix("#")) if "=" in href else {}
        for at in said.get("at", []):
            assert tuple(at.split(":", 1)) in walk.nodes
        for stage in said.get("stage", []):
            assert stage in [one["id"] for one in walk.data["stages"]]
        for kind in (*said.get("kind", []), *said.get("to", [])):
            assert kind in {key[0] for key in walk.nodes}


def test_findings_are_at_what_they_are_about(tmp_path: Path) -> None:
    matrix, walk = page_of(broken(tmp_path))
    assert len(walk.data["findings"]) == len(matrix.findings)
    for number, (finding, about) in enumerate(zip(matrix.findings, walk.data["findings"]), 1):
        assert f"finding-{number}" in walk.elements.ids
        names = {walk.key(node)[1] for node in about}
        assert names <= {finding.subject, *finding.about}
        if any(key[1] == finding.subject and key[0] != "result" for key in walk.nodes):
            assert finding.subject in names
    assert sum(map(bool, walk.data["findings"])) > 5


def test_what_follows_is_counted_beside_what_it_follows_from(tmp_path: Path) -> None:
    """The verdict counted six errors, and the list of them four."""
    matrix = broken(tmp_path).matrix()
    page = trace.render(matrix, "html")
    page = page[page.index('<h2 id="findings">') :]
    heads = re.findall(r'<summary><span class="level \w+">(\d+) \w+</span>(?:; (\d+) more follow)?', page)
    assert any(more for _, more in heads)
    assert sum(int(number) + int(more or 0) for number, more in heads) == len(matrix.findings)


def test_the_same_inputs_make_the_same_bytes() -> None:
    assert trace.render(Small().matrix(), "html") == trace.render(Small().matrix(), "html")


def test_statistics_are_those_of_the_command(tmp_path: Path) -> None:
    from trackmarshal.trace.graph.statistics import numbers

    matrix = broken(tmp_path).matrix()
    page = trace.render(matrix, "html")
    section = page[
        page.index('<h2 id="statistics">') : page.index("<h2 id", page.index('<h2 id="statistics">') + 9)
    ]
    shown = Counter(re.findall(r'<td class="number">(\d+)</td>', section))
    counted = Counter(str(one.number) for one in numbers(matrix) if one.number and one.what != "covers")
    assert not counted - shown


def test_a_status_is_what_it_came_to(tmp_path: Path) -> None:
    _, walk = page_of(broken(tmp_path))
    status = {key: said[2] for key, said in walk.nodes.items()}
    assert status["test", "gap: outside"] == "failed"
    assert status["test", "turn: inside"] == "stale"
    assert status["test", "gap: inside"] == "covered"
    assert status["requirement", "RR-1"] == "stale"


def test_a_run_that_contradicts_its_truth_has_failed(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    case = (HERE / "findings" / "T243_outside_the_truth.case").read_text("utf-8").splitlines()
    before, walked = page_of(Small())[1], None
    apply(small, case[: case.index("expect")])
    _, walked = page_of(small)
    key = ("run", "scenarios/cut_in.jsonl")
    assert (before.nodes[key][2], walked.nodes[key][2]) == ("covered", "failed")


def test_the_status_of_what_comes_to_nothing_is_that_of_its_items(small: Small) -> None:
    """Of rules, interfaces and their like: as which they count in cells, all together."""
    _, walk = page_of(small)
    counted: dict[tuple[str, str], set[str]] = {}
    for cells in walk.cells.values():
        for _, items in cells.values():
            for kind, name, status, _ in items:
                counted.setdefault((kind, name), set()).add(status)
    seen = set()
    for key, (_, _, status, said) in walk.nodes.items():
        if key[0] == "requirement" or said.get("outcome"):
            continue
        found = counted.get(key, set())
        wanted = (
            "" if not found
            else "failed" if "failed" in found
            else "stale" if "stale" in found
            else "missing" if found == {"missing"}
            else "partial" if found & {"missing", "partial"}
            else "waived" if "waived" in found
            else "covered"
        )  # fmt: skip
        assert status == wanted, key
        seen.add(status)
    assert {"", "covered"} < seen


def test_what_counts_in_this_project_can_be_walked_to(tmp_path: Path) -> None:
    """Every kind of items that it has: rules, monitors, assumptions, tests, scenarios, faults, documents, design elements."""
    project = copy_project(tmp_path / "shipped")
    status, out, err = command(project, "trace", "--as-is", "--format", "html", "--day", DAY)
    assert status in (0, 1), err
    walk = Walk(out)
    kinds = set()
    for cells in walk.data["cells"]:
        for _, _, items in cells:
            for _, _, node, *rest in items:
                assert node >= 0 or rest[0] == "adoption", rest
                kinds.add(walk.key(node)[0] if node >= 0 else "adoption")
    assert {
        "rule",
        "assumption",
        "test",
        "scenario",
        "fault",
        "document",
        "design element",
        "interface",
        "requirement",
    } <= kinds


@pytest.fixture(scope="module")
def warehouse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_ready(tmp_path_factory.mktemp("matrix"))


def made(project: Path, *arguments: str) -> Walk:
    status, out, err = command(project, "trace", "--format", "html", "--day", DAY, *arguments)
    assert status == 0, err
    return Walk(out)


def test_rules_are_as_show_has_them(warehouse: Path) -> None:
    for arguments in ((), ("--as-is",), ("--as-is",)):  # of compiled specs; compiled for it; kept
        walk = made(warehouse, *arguments)
        rules = {**walk.of("rule", "rules"), **walk.of("assumption", "rules")}
        assert set(rules) == {id_ for kind, id_ in walk.nodes if kind in ("rule", "assumption")}
        for name, sheet in rules.items():
            status, out, err = command(warehouse, "show", name, "--json")
            assert status == 0, err
            shown = json.loads(out)
            assert sheet["spec"] == shown["spec"]
            if "formula" not in shown:
                continue
            assert [clause[3] for clause in sheet["clauses"]] == [
                one["mathml"] for one in shown["formula"]["clauses"]
            ]
            assert sheet.get("definitions", []) == [one["mathml"] for one in shown["formula"]["definitions"]]
            assert [one[2] for one in sheet.get("parameters", [])] == [
                one["written"] for one in shown["formula"]["parameters"]
            ]
            assert sheet["words"]["demand"] == shown["words"]["demand"]


def drawings(project: Path) -> tuple[dict[str, str], dict[str, str]]:
    """Of the matrix page of a project whose gate may fail: pictures, and why there is none."""
    status, out, err = command(project, "trace", "--format", "html", "--day", DAY, "--as-is")
    assert status in (0, 1), err
    walk = Walk(out)
    return tuple({**walk.of("rule", name), **walk.of("assumption", name)} for name in ("drawings", "undrawn"))  # type: ignore[return-value]


def test_drawings_that_are_kept_are_shown_and_none_that_is_stale(warehouse: Path, tmp_path: Path) -> None:
    import shutil

    project = tmp_path / "drawn"
    shutil.copytree(warehouse, project)
    assert drawings(project) == ({}, {})  # nothing was drawn for it
    command(project, "case", "--out", str(tmp_path / "out"), "--day", DAY, "--format", "html", "--quiet")
    drawn, undrawn = drawings(project)
    assert "slow_near_people" in drawn
    assert drawn.keys() | undrawn.keys() == set(re.findall(r"^rule (\w+)", (project / "specs/robot.spec").read_text("utf-8"), re.MULTILINE))  # fmt: skip
    assert all(reason.startswith("No drawing: ") for reason in undrawn.values())
    for rule, svg in drawn.items():
        status, shown, err = command(project, "show", rule, "--draw")
        assert (status, shown) == (0, svg + "\n"), err
    spec = project / "specs/robot.spec"
    text = spec.read_text("utf-8")
    assert text.count("require   robot.v <= 0.3 m/s") == 1
    spec.write_text(text.replace("require   robot.v <= 0.3 m/s", "require   robot.v <= 0.4 m/s"), "utf-8")
    now, _ = drawings(project)
    assert "slow_near_people" not in now
    assert now.items() < drawn.items()


def test_a_page_holds_so_many_letters_of_drawings(
    warehouse: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import shutil

    from trackmarshal.cli import beside

    project = tmp_path / "full"
    shutil.copytree(warehouse, project)
    command(project, "case", "--out", str(tmp_path / "out"), "--day", DAY, "--format", "html", "--quiet")
    drawn, undrawn = drawings(project)
    first, *others = drawn
    assert others
    monkeypatch.setattr(beside, "DRAWN", len(drawn[first]))
    assert drawings(project) == ({first: drawn[first]}, undrawn)


def test_what_is_said_over_and_over_stands_once() -> None:
    """Values of attributes: 10,000 requirements have few statuses, sources and methods."""
    _, walk = page_of(Small())
    said = Counter(text for *_, one in walk.nodes.values() for text in one.values())
    often = {text for text, times in said.items() if times > 1 and len(text) > 10}
    assert "approved" not in often
    assert {"paper, section V-A"} <= often
    held = next(text for kind, text in walk.elements.scripts if kind == "application/json")
    nodes = json.dumps(json.loads(held)["nodes"], ensure_ascii=False)
    assert [text for text in often if json.dumps(text, ensure_ascii=False) in nodes] == []


def test_tests_stand_as_they_are_written(warehouse: Path) -> None:
    walk = made(warehouse, "--as-is")
    texts = walk.of("test", "tests")
    assert set(texts) == {id_ for kind, id_ in walk.nodes if kind == "test"}
    for id_, text in texts.items():
        file, line, _ = walk.nodes["test", id_][1].split(":")
        lines = (warehouse / file).read_text("utf-8").splitlines()
        assert text.splitlines() == lines[int(line) - 1 : int(line) - 1 + len(text.splitlines())]
        assert "expect" in text.splitlines()[-1] or "after" in text


def test_entries_are_those_of_the_evidence_store(warehouse: Path) -> None:
    walk = made(warehouse, "--as-is")
    entries = walk.of("test", "evidence")
    assert set(entries) == {id_ for kind, id_ in walk.nodes if kind == "test"}
    stored = {}
    for line in (warehouse / "out" / "results" / "evidence.jsonl").read_bytes().splitlines():
        said = json.loads(line)
        rest = line.partition(b'", ')[2]
        assert hashlib.sha256(rest).hexdigest() == said["id"]
        stored[said["subject"]] = said
    for subject, (id_, day, maker, names) in entries.items():
        said = stored[subject]
        assert (id_, day, names) == (said["id"], said["made"], sorted(said["inputs"]))
        assert walk.data["makers"][maker] == [said["tool"], said["commit"], said["platform"]]


def test_rules_follow_their_specs(warehouse: Path, tmp_path: Path) -> None:
    """What is kept of rules is not told of another text, though it mean the same."""
    import shutil

    project = tmp_path / "copy"
    shutil.copytree(warehouse, project)
    made(project, "--as-is")
    spec = next(
        path for path in sorted((project / "specs").rglob("*.spec")) if "rule " in path.read_text("utf-8")
    )
    text = spec.read_text("utf-8")
    title = re.search(r'^rule \w+ "([^"]+)"', text, re.MULTILINE)
    assert title is not None
    spec.write_text(text.replace(title[1], "Quite another title"), "utf-8")
    assert any(
        "Quite another title" in sheet["spec"]
        for sheet in made(project, "--as-is").of("rule", "rules").values()
    )


def differences(page: str) -> list[str]:
    section = page[page.index('<h2 id="differences">') :].partition("</h2>")[2].partition("<h2 ")[0]
    return [re.sub(r"<[^>]+>", "", row).strip() for row in re.findall(r"<tr>(.*?)</tr>", section, re.DOTALL)][
        1:
    ]


def test_differences_between_baselines(warehouse: Path, tmp_path: Path) -> None:
    import shutil

    project = tmp_path / "held"
    shutil.copytree(warehouse, project)
    walk = made(project, "--as-is")
    assert "Nothing differs of what a baseline holds." in walk.html
    baseline = next((project / "requirements").glob("*baseline*.json"))
    old = tmp_path / "old.json"
    data = json.loads(baseline.read_text("utf-8"))
    gone = next(key for key in data["content"] if key.startswith("test "))
    requirement = next(key for key in data["content"] if key.startswith("requirement "))
    data["content"]["requirement GONE-1"] = data["content"][requirement]
    data["content"][requirement] = {**data["content"][requirement], "asil": "D"}
    del data["content"][gone]
    old.write_text(json.dumps(data), "utf-8")
    found = differences(made(project, "--as-is", "--against", str(old)).html)
    assert any("GONE-1" in row and "is gone" in row and "weaker?" in row for row in found), found
    assert any(requirement in row and "asil" in row and "from D" in row for row in found), found
    assert any(
        gone in row.replace("&#34;", '"') and "is new" in row and "weaker" not in row for row in found
    ), found
    assert len(found) == 3
    for both in (f"{old}..{baseline}", f"{baseline}..{old}"):
        assert len(differences(made(project, "--as-is", "--against", both).html)) == 3


def test_differences_between_revisions(warehouse: Path, tmp_path: Path) -> None:
    import shutil

    project = tmp_path / "revisions"
    shutil.copytree(warehouse, project)
    git = ["git", "-C", str(project), "-c", "user.name=a", "-c", "user.email=a@b"]
    for more in (["init", "-q"], ["add", "requirements", "specs"], ["commit", "-qm", "one"], ["tag", "one"]):
        subprocess.run([*git, *more], check=True, capture_output=True)
    baseline = next((project / "requirements").glob("*baseline*.json"))
    data = json.loads(baseline.read_text("utf-8"))
    data["content"].pop(next(key for key in data["content"] if key.startswith("requirement ")))
    baseline.write_text(json.dumps(data), "utf-8")
    subprocess.run([*git, "commit", "-qam", "two"], check=True, capture_output=True)
    page = made(project, "--as-is", "--against", "one..HEAD").html
    assert "Differences: one → HEAD" in page
    assert [("is gone" in row) for row in differences(page)] == [True]
    assert differences(made(project, "--as-is", "--against", "one").html) == []


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--format", "html", "--against", "no-such"], "T361", "neither a file or folder here nor a revision"),
        (["--format", "html", "--against", "specs.json"], "T364", "is no baseline"),
        (["--format", "html", "--against", ".."], "T364", "names no baseline"),
        (["--format", "md", "--against", "specs.json"], "T364", "add `--format html`"),
        (["--against", "specs.json"], "T364", "shows nothing as text"),
    ],
)  # fmt: skip
def test_what_is_no_baseline_is_refused(
    warehouse: Path, tmp_path: Path, arguments: list[str], code: str, words: str
) -> None:
    import shutil

    project = tmp_path / "refused"
    shutil.copytree(warehouse, project)
    subprocess.run(["git", "-C", str(project), "init", "-q"], check=True)
    (project / "specs.json").write_text('{"format": "something"}', "utf-8")
    status, _, err = command(project, "trace", "--as-is", "--day", DAY, *arguments)
    assert status == 2
    assert code in err
    assert words in err
