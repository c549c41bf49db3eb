"""The link graph: what leads where, what a project's own schema asks for, and input that is meant to break it."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.trace.cases import HERE, TODAY, Small, apply
from support.length import amount
from support.project import command
from trackmarshal import trace
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records.faults import FaultCase
from trackmarshal.records.specs import PART_KINDS, Ref, SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph.checks import SUGGESTED
from trackmarshal.trace.graph.graph import Graph, Key, Link, Node
from trackmarshal.trace.graph.integrity import by_table_4
from trackmarshal.trace.graph.kinds import LINKS, NODES, WAYS
from trackmarshal.trace.graph.paths import named, paths
from trackmarshal.trace.graph.reviewed import reviewed, unreviewed
from trackmarshal.trace.graph.schema import Asking, default
from trackmarshal.trace.model import Need, Project, Reviewed, Way
from trackmarshal.trace.spec import Spec
from trackmarshal.trace.values import Placed

WAREHOUSE = HERE / "warehouse"
NOWHERE = Place("x.yaml", 1, 1)


@pytest.fixture(scope="module")
def warehouse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project that has nothing to do with cars, with stages and a schema of its own; its tests have been run."""
    root = tmp_path_factory.mktemp("warehouse") / "project"
    shutil.copytree(WAREHOUSE, root)
    command(root, "trace", "--accept-baseline")
    status, out, err = command(root, "trace", "--gate")
    assert status == 0, out + err
    return root


def edited(warehouse: Path, folder: Path, file: str, old: str, new: str) -> Path:
    root = folder / "project"
    shutil.copytree(warehouse, root)
    text = (root / file).read_text("utf-8")
    assert text.count(old) == 1
    (root / file).write_text(text.replace(old, new), "utf-8")
    return root


def findings(root: Path) -> list[str]:
    _, out, _ = command(root, "trace", "--as-is", "--format", "json")
    return [f"{found['code']} {found['message']}" for found in json.loads(out)["findings"]]


@pytest.mark.parametrize(
    ("file", "old", "new", "expected"),
    [
        ("needs.yaml", "    achieves: [SG-1]\n", "", "T150 `SYS-1` answers no safety goal and no customer"),
        ("needs.yaml", "    refines: [SYS-1]\n", "", "T150 `SYS-1` has no link `refined_by`"),
        ("needs.yaml", "refines: [SYS-1]", "refines: [SW-2]", "T155 `SW-1` may not have the link `refines` to `SW-2`"),
        ("needs.yaml", "refines: [SYS-2]", "refines: [SYS-2, SYS-9]", "T137 `SW-2` refines `SYS-9`, which does not exist"),
        ("needs.yaml", "person at more than 0.3 m/s", "person at more than 0.5 m/s", "T167 `SYS-1` has changed since the review `RV-1`"),
        ("needs.yaml", "person at more than 0.3 m/s", "person at more than 0.5 m/s",
         "T150 `SYS-1` has no link `reviewed_by` with `outcome` accepted"),
        ("people.yaml", "outcome: accepted", "outcome: open", "T150 `SYS-1` has no link `reviewed_by` with `outcome` accepted"),
        ("hazards.yaml", "severity: S2", "severity: S3", "T158 the hazard `HZ-1` has ASIL B; S3, E4, C2 make it C"),
        ("hazards.yaml", "prevents: [HZ-1]", "prevents: [HZ-2]", "T150 the hazard `HZ-1` has no link `prevented_by`"),
        ("design.yaml", "asil: B", "asil: A", "T164 the design element `DE-1` is developed to ASIL A, and `SW-1`, allocated to it, has B"),
        ("design.yaml", "owner: P-1", "owner: x", "T153 the design element `DE-1` belongs to `x`, who is none of the persons of the project"),
    ],
)  # fmt: skip
def test_another_project_has_other_rules(
    warehouse: Path, tmp_path: Path, file: str, old: str, new: str, expected: str
) -> None:
    assert expected in findings(edited(warehouse, tmp_path, f"requirements/{file}", old, new))


def test_a_test_that_failed_shows_as_a_need_that_is_not_met(warehouse: Path, tmp_path: Path) -> None:
    root = edited(
        warehouse,
        tmp_path,
        "specs/robot.spec",
        "require   robot.v <= 0.3 m/s",
        "require   robot.v <= 0.2 m/s",
    )
    command(root, "trace")
    assert "T150 `SW-1` has no test below it with `outcome` passed" not in findings(
        root
    )  # one of them still passes
    shutil.rmtree(root / "out")
    assert "T150 `SW-1` has no test below it with `outcome` passed" in findings(root)


def rows(root: Path, *arguments: str) -> list[list[str]]:
    status, out, err = command(root, "trace", *arguments, "--format", "csv")
    assert status == 0, err
    return [line.split(",") for line in out.splitlines()[1:]]


def test_from_a_requirement_down_to_its_tests(warehouse: Path) -> None:
    found = rows(warehouse, "--from", "SYS-1", "--to", "test")
    assert [row[3] for row in found] == [
        "slow_near_people: just slow enough", "slow_near_people: slow", "slow_near_people: too fast"
    ]  # fmt: skip
    assert {row[4] for row in found} == {"passed"}
    _, out, _ = command(warehouse, "trace", "--from", "SYS-1", "--to", "test", "--format", "json")
    steps = json.loads(out)["paths"][0]["steps"]
    assert [(step["way"], step["kind"], step["id"]) for step in steps] == [
        ("refined_by", "requirement", "SW-1"), ("satisfied_by", "rule", "slow_near_people"),
        ("tested_by", "test", "slow_near_people: just slow enough"),
    ]  # fmt: skip


@pytest.mark.parametrize("question", [("--from", "SYS-1", "--to", "test"), ("--statistics",)])
@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("specs/robot.spec", "robot.v <= 0.3 m/s", "robot.w <= 0.3 m/s", "specs/robot.spec:8:13: error[E210]"),
        ("requirements/needs.yaml", "document:", "document: [", "requirements/needs.yaml:2"),
    ],
)  # fmt: skip
def test_an_answer_says_what_it_lacks(
    question: tuple[str, ...], file: str, old: str, new: str, said: str, warehouse: Path, tmp_path: Path
) -> None:
    """Of specs with errors there is no rule in the graph, and of a document that cannot be read nothing: that nothing leads to a test was the whole answer."""
    root = edited(warehouse, tmp_path, file, old, new)
    status, _, err = command(root, "trace", *question)
    assert (status, said in err) == (2, True), err


def test_from_a_test_up_to_what_may_harm_somebody(warehouse: Path) -> None:
    found = rows(warehouse, "--from", "test:slow_near_people: slow", "--to", "hazard")
    assert [(row[0], row[3]) for row in found] == [("test", "HZ-1")]
    found = rows(warehouse, "--from", "test", "--to", "safety-goal")
    assert {row[1].split(":")[0]: row[3] for row in found} == {"gentle": "", "slow_near_people": "SG-1"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--from", "SYS-9", "--to", "test"), "`SYS-9` is no kind of nodes, and no id in the project"),
        (("--from", "requirement"), "`--from` and `--to` belong together"),
        (("--from", "SYS-1", "--to", "test", "--format", "sarif"), "a question has no answer as sarif"),
        (("--from", "SYS-1", "--to", "test", "--gate"), "`--gate` says nothing beside a question"),
        (("--statistics", "--accept-baseline"), "`--accept-baseline` says nothing beside a question"),
        (("--statistics", "--rerun"), "`--rerun` says nothing beside a question"),
        (("--statistics", "--against", "HEAD"), "`--against` says nothing beside a question"),
        (
            ("--from", "rule", "--to", "test", "--statistics", "--format", "csv"),
            "paths and numbers are two tables, and CSV is one",
        ),
    ],
)
def test_questions_that_cannot_be_answered(warehouse: Path, arguments: tuple[str, ...], said: str) -> None:
    status, out, err = command(warehouse, "trace", *arguments)
    assert (status, out) == (2, "")
    assert f"error[T169]: {said}" in err


@pytest.mark.parametrize(
    "arguments", [("--by", "Ann"), ("--reason", "it is so", "--gate"), ("--by", "Ann", "--statistics")]
)
def test_who_accepts_accepts_something(warehouse: Path, arguments: tuple[str, ...]) -> None:
    status, out, err = command(warehouse, "trace", *arguments)
    assert (status, out) == (2, "")
    assert f"error[T378]: `{arguments[0]}` is of an acceptance, and nothing is accepted" in err


def test_numbers(warehouse: Path) -> None:
    _, out, _ = command(warehouse, "trace", "--statistics", "--format", "json")
    found = json.loads(out)
    assert found["nodes"]["test"] == {"all": 6, "without a link": 0, "passed": 6}
    assert found["links"]["refines"] == {"all": 2, "covers": 2}
    assert found["requirements by ASIL"] == {
        "B": {"all": 2, "with no open cell": 2}, "QM": {"all": 2, "with no open cell": 2}
    }  # fmt: skip
    for format_ in ("text", "csv", "md"):
        _, out, _ = command(warehouse, "trace", "--statistics", "--format", format_)
        assert "without a link" in out


def test_a_requirement_of_which_nothing_is_asked_is_not_counted_as_done(
    warehouse: Path, tmp_path: Path
) -> None:
    """`SYS-1`, with ASIL B, has no cell then, so that none of its cells is open."""
    old = 'shows: that its tests pass, applies_to: ["*"]'
    project = edited(warehouse, tmp_path, "requirements/v-model.yaml", old, old.replace('"*"', "SW-*"))
    _, out, _ = command(project, "trace", "--as-is", "--statistics", "--format", "json")
    assert json.loads(out)["requirements by ASIL"]["B"] == {"all": 2, "with no open cell": 1}


def test_numbers_beside_paths_are_one_text_of_json(warehouse: Path) -> None:
    asked = ("--from", "SYS-1", "--to", "test", "--statistics")
    found = json.loads(command(warehouse, "trace", *asked, "--format", "json")[1])
    assert (found["format"], len(found["paths"])) == ("trackmarshal-paths", 3)
    assert found["statistics"]["nodes"]["test"]["all"] == 6
    said = command(warehouse, "trace", *asked)[1]
    assert "slow_near_people: slow" in said
    assert "without a link" in said


def test_all_kinds_of_documents_together_have_no_findings(tmp_path: Path) -> None:
    """The small project with hazards, goals, design, a decomposition that is argued, and a review."""
    small = Small.copy(tmp_path)
    apply(small, (HERE / "all_kinds.edits").read_text("utf-8").splitlines())
    before = (small.root / "requirements/baseline.json").read_bytes()
    with pytest.raises(
        TrackmarshalError, match="`Ann Author`, who is to accept it, is none of the persons"
    ) as refused:
        small.accept(by="Ann Author")
    assert refused.value.code == "T153"
    assert (small.root / "requirements/baseline.json").read_bytes() == before
    small.accept()
    matrix = small.matrix()
    assert [str(finding) for finding in matrix.findings] == []
    engine = {
        "parameter",
        "table",
        "signal",
        "place",
        "constraint",
        "rulebook",
        "fault",
        "external test",
        "code",
    }
    assert set(NODES) - engine - {"method"} == set(matrix.graph.by_kind)
    for link in matrix.graph.links:
        assert link.state == "covers", link


def test_whoever_strikes_all_persons_is_still_one_of_them(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    apply(small, (HERE / "all_kinds.edits").read_text("utf-8").splitlines())
    small.accept()
    for file in sorted((small.root / "requirements").glob("*.yaml")):
        text = file.read_text("utf-8")
        file.write_text(re.sub(r"(?m)^persons:\n(?:[ -].*\n)+", "", text), "utf-8")
    with pytest.raises(TrackmarshalError, match="is none of the persons") as refused:
        small.accept(by="Nobody Else")
    assert refused.value.code == "T153"
    assert "`the safety manager`" in (refused.value.help or "")
    small.accept(by="the safety manager")


#: ISO 26262-3, table 4, as it is printed: by severity and exposure, for C1, C2, C3.
TABLE_4 = {
    ("S1", "E1"): "QM QM QM", ("S1", "E2"): "QM QM QM", ("S1", "E3"): "QM QM A", ("S1", "E4"): "QM A B",
    ("S2", "E1"): "QM QM QM", ("S2", "E2"): "QM QM A", ("S2", "E3"): "QM A B", ("S2", "E4"): "A B C",
    ("S3", "E1"): "QM QM A", ("S3", "E2"): "QM A B", ("S3", "E3"): "A B C", ("S3", "E4"): "B C D",
}  # fmt: skip


def test_table_4() -> None:
    for (severity, exposure), levels in TABLE_4.items():
        for controllability, level in zip(("C1", "C2", "C3"), levels.split()):
            assert by_table_4(severity, exposure, controllability) == level
    for classes in (("S0", "E4", "C3"), ("S3", "E0", "C3"), ("S3", "E4", "C0")):
        assert by_table_4(*classes) == "QM"
    for classes in (
        ("S4", "E4", "C3"),
        ("S3", "E5", "C3"),
        ("S3", "E4", "C4"),
        ("E3", "E4", "C3"),
        ("", "E4", "C3"),
    ):
        with pytest.raises(ValueError, match="is no class"):
            by_table_4(*classes)


PARTS = ["QM", "A", "B", "C", "D"]
#: The decompositions that ISO 26262-9 prints for each level, into two.
PRINTED = {"D": {"C A", "B B", "D QM"}, "C": {"B A", "C QM"}, "B": {"A A", "B QM"}, "A": {"A QM"}}


@pytest.mark.parametrize("level", PRINTED)
def test_decompositions_into_two_are_those_that_are_printed_or_more(level: str, tmp_path: Path) -> None:
    for first in range(5):
        for second in range(first + 1):
            pair = f"{PARTS[first]} {PARTS[second]}"
            least = any(
                first >= PARTS.index(a) and second >= PARTS.index(b)
                for a, b in (p.split() for p in PRINTED[level])
            )
            graph = decomposed(level, f"{PARTS[first]}({level})", f"{PARTS[second]}({level})")
            codes = {finding.code for finding in trace_integrity(graph)}
            assert (codes == set()) == least, (level, pair, codes)


def trace_integrity(graph: Graph) -> list[trace.Finding]:
    from trackmarshal.trace.graph import integrity

    return list(integrity.check(graph))


def requirement(name: str, asil: str) -> Node:
    return Node("requirement", name, "", NOWHERE, {"asil": asil, "status": "approved"})


def decomposed(level: str, *parts: str) -> Graph:
    nodes = [requirement("R-0", level), *(requirement(f"R-{n}", part) for n, part in enumerate(parts, 1))]
    links = [Link("refines", node.key, nodes[0].key, "covers", NOWHERE) for node in nodes[1:]]
    links.append(Link("independence", nodes[0].key, ("analysis", "AN-1"), "covers", NOWHERE))
    return Graph({node.key: node for node in nodes}, links)


def test_a_decomposed_part_is_decomposed_again() -> None:
    """D into C(D) + A(D), and C(D) into B(D) + A(D): the level in brackets is still that of the whole."""
    names = {"R-0": "D", "R-1": "C(D)", "R-2": "A(D)", "R-3": "B(D)", "R-4": "A(D)"}
    nodes = {node.key: node for node in (requirement(name, asil) for name, asil in names.items())}
    above = {"R-1": "R-0", "R-2": "R-0", "R-3": "R-1", "R-4": "R-1"}
    links = [
        Link("refines", ("requirement", a), ("requirement", b), "covers", NOWHERE) for a, b in above.items()
    ]
    links += [
        Link("independence", ("requirement", name), ("analysis", "AN-1"), "covers", NOWHERE)
        for name in ("R-0", "R-1")
    ]
    assert trace_integrity(Graph(nodes, links)) == []


def test_a_part_that_is_demanded_no_longer_makes_up_nothing() -> None:
    graph = decomposed("D", "B(D)", "B(D)")
    gone = graph.nodes["requirement", "R-2"]
    assert trace_integrity(graph) == []
    nodes = {**graph.nodes, gone.key: gone._replace(attributes={**gone.attributes, "status": "obsolete"})}
    assert [f.code for f in trace_integrity(Graph(nodes, graph.links))] == ["T161"]


def by_hand(graph: Graph, down: bool) -> dict[Key, set[Key]]:
    """What each node reaches, by adding one link at a time until nothing changes."""
    step = {
        (link.source, link.target) if LINKS[link.kind].down is down else (link.target, link.source)
        for link in graph.links
    }
    reached: dict[Key, set[Key]] = {key: set() for key in graph.nodes}
    while True:
        before = sum(map(len, reached.values()))
        for source, target in step:
            reached[source] |= {target} | reached[target]
        if sum(map(len, reached.values())) == before:
            return reached


@settings(max_examples=amount(20, 300), deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, 7), st.integers(0, 7), st.sampled_from(["refines", "leads_to"])), max_size=20
    ),
    st.data(),
)
def test_paths_lead_where_links_lead(edges: list[tuple[int, int, str]], data: st.DataObject) -> None:
    """Any graph, circles and links to oneself included: paths are shortest, their steps are links, and none is missing."""
    nodes = {node.key: node for node in (requirement(f"R-{n}", "D") for n in range(8))}
    keys = list(nodes)
    graph = Graph(nodes, [Link(kind, keys[a], keys[b], "covers", NOWHERE) for a, b, kind in edges])
    sources = data.draw(st.lists(st.sampled_from(keys), min_size=1, unique=True))
    targets = data.draw(st.lists(st.sampled_from(keys), min_size=1, unique=True))
    found = paths(graph, sources, targets)
    below, above = by_hand(graph, True), by_hand(graph, False)
    expected = {(s, t) for s in sources for t in targets if s != t and t in below[s] | above[s]}
    assert {(path.source, path.target) for path in found if path.target is not None} == expected
    assert {path.source for path in found} == set(sources)
    for path in found:
        at = path.source
        for step in path.steps:
            assert {at, step.node} == {step.link.source, step.link.target}
            kind, outward = WAYS[step.way]
            assert kind == step.link.kind
            assert (step.link.source if outward else step.link.target) == at
            at = step.node
        assert at == (path.target or path.source)


def test_links_that_do_not_hold_lead_nowhere() -> None:
    nodes = {node.key: node for node in (requirement("R-0", "D"), requirement("R-1", "D"))}
    a, b = nodes
    for state, found in (
        ("covers", b),
        ("outdated", b),
        ("unwanted", None),
        ("ambiguous", None),
        ("orphaned", None),
    ):
        graph = Graph(nodes, [Link("refines", a, b, state, NOWHERE)])
        assert [path.target for path in paths(graph, [a], [b])] == [found], state


@pytest.mark.parametrize(
    ("reviews", "stands"),
    [
        ([], False),
        ([("accepted", "2026-03-01")], True),
        ([("open", "2026-03-01")], False),
        ([("open", "2026-03-01"), ("accepted", "2026-03-02")], True),
        ([("open", "2026-03-02"), ("accepted", "2026-03-01")], False),
        ([("open", "2026-03-01"), ("accepted", "2026-03-01")], False),
        ([("accepted", "2026-03-01"), ("open", "2026-03-02"), ("accepted", "2026-03-03")], True),
    ],
)
@pytest.mark.parametrize("state", ["covers", "outdated"])
def test_the_last_review_of_the_present_version_counts(
    reviews: list[tuple[str, str]], stands: bool, state: str
) -> None:
    """Who finds it open later, or on the same day, takes an acceptance back; and none of an earlier version counts."""
    read = requirement("R-0", "D")
    made = [
        Node("review", f"RV-{n}", "", NOWHERE, {"outcome": outcome, "made": day})
        for n, (outcome, day) in enumerate(reviews)
    ]
    links = [Link("reviews", one.key, read.key, state, NOWHERE) for one in made]
    graph = Graph({node.key: node for node in (read, *made)}, links)
    assert reviewed(graph, read) == (stands and state == "covers")


@pytest.mark.parametrize(
    ("readers", "least", "met"),
    [
        (["A"], 1, True), (["A"], 2, False), (["A", "A"], 1, True), (["A", "A"], 2, False), (["A", "B"], 2, True), (["A", "A", "B"], 3, False),
        (["AB"], 2, False), (["AB", "A"], 2, True),
    ],
)  # fmt: skip
def test_who_reads_a_thing_twice_is_no_second_reader(readers: list[str], least: int, met: bool) -> None:
    """Each letter is a person, each entry a review: two reviews were asked for, and one person had written both."""
    read = requirement("R-0", "D")
    persons = [Node("person", name, name, NOWHERE, {}) for name in "AB"]
    made = [Node("review", f"RV-{n}", "", NOWHERE, {"outcome": "accepted"}) for n, _ in enumerate(readers)]
    links = [Link("reviews", one.key, read.key, "covers", NOWHERE) for one in made]
    for one, by in zip(made, readers):
        links += [Link("made_by", one.key, ("person", name), "covers", NOWHERE) for name in by]
    graph = Graph({node.key: node for node in (read, *persons, *made)}, links)
    none = Placed.at("", NOWHERE)
    way = Way(NOWHERE, Placed.at("reviewed_by", NOWHERE), none, none, (), (), least)
    assert Asking(graph, Project()).met(read, [way]) == met


def test_of_reviews_that_are_too_many_it_does_not_count_by_whom_they_are() -> None:
    """With `at_most: 1`, two reviews by one person were one."""
    read, person = requirement("R-0", "D"), Node("person", "A", "A", NOWHERE, {})
    made = [Node("review", f"RV-{n}", "", NOWHERE, {"outcome": "accepted"}) for n in range(2)]
    links = [Link("reviews", one.key, read.key, "covers", NOWHERE) for one in made]
    links += [Link("made_by", one.key, person.key, "covers", NOWHERE) for one in made]
    none = Placed.at("", NOWHERE)
    way = Way(NOWHERE, Placed.at("reviewed_by", NOWHERE), none, none, (), (), 1, 1)
    graph = Graph({node.key: node for node in (read, person, *made)}, links)
    need = Need("requirement", NOWHERE, (way,), (), "", (), "", "", False, (), "error", none, "", "")
    assert [found.code for found in Asking(graph, Project()).need(need)] == ["T154"]


_OWNED = """document: link-schema
title: Who answers for what
nodes: [{kind: requirement, needs: [{any_of: [{field: owner}], ids: [S-1-B-1], from_asil: %s}]}]
"""


@pytest.mark.parametrize(("own", "from_asil", "asked"), [
    ("QM", "QM", True), ("QM", "A", False), ("A", "B", False), ("B", "B", True), ("C", "B", True), ("D", "D", True), ("B(D)", "B", True), ("A(D)", "B", False),
])  # fmt: skip
def test_a_need_is_asked_from_a_level_on(own: str, from_asil: str, asked: bool, tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    (small.root / "requirements" / "links.yaml").write_text(_OWNED % from_asil, "utf-8")
    text = "status: %s\n    asil: %s\n    verification: [review]"
    small.replace("requirements/criteria.yaml", text % ("approved", "D"), text % ("approved", own))
    assert [f.subject for f in small.matrix().findings if f.code == "T150"] == ["S-1-B-1"] * asked
    small.replace("requirements/criteria.yaml", text % ("approved", own), text % ("obsolete", own))
    assert [f.subject for f in small.matrix().findings if f.code == "T150"] == []


@pytest.mark.parametrize(("ids", "from_asil", "expected"), [
    ((), "", ["R-A", "R-BD", "R-C", "R-QM", "R-none"]), ((), "QM", ["R-A", "R-BD", "R-C", "R-QM"]), ((), "A", ["R-A", "R-BD", "R-C"]),
    ((), "B", ["R-BD", "R-C"]), ((), "C", ["R-C"]), ((), "D", []), (("R-A", "R-C"), "B", ["R-C"]), (("R-Q*",), "", ["R-QM"]), (("R-Q*",), "A", []),
])  # fmt: skip
def test_what_is_to_be_reviewed_is_of_these_ids_and_from_this_level_on(
    ids: tuple[str, ...], from_asil: str, expected: list[str]
) -> None:
    """Of what is decomposed, what is left to it; what is demanded no longer need not be read."""
    levels = {"R-A": "A", "R-BD": "B(D)", "R-C": "C", "R-QM": "QM", "R-none": ""}
    gone = Node("requirement", "R-C-2", "", NOWHERE, {"asil": "D", "status": "obsolete"})
    nodes = [*(Node("requirement", id_, "", NOWHERE, {"asil": level}) for id_, level in levels.items()), gone]
    asked = Reviewed("requirement", tuple(Placed.at(one, NOWHERE) for one in ids), from_asil)
    graph = Graph({node.key: node for node in nodes}, [])
    assert [id_ for _, id_ in unreviewed(graph, [asked])] == expected


def test_what_rules_read_is_a_node_of_whatever_kind_it_is() -> None:
    """A part of each kind that the engine tells of; a rule is linked to those that it is made from."""
    parts = [SpecPart(kind, f"m.{kind}", "f", "shown", "a.spec", 7, 1) for kind in PART_KINDS]
    inputs = {f"{part.kind} {part.name}": "f" for part in parts} | {"constraints": "f", "rule turn": "f"}
    items = [SpecItem("rule", "turn", "t", (Ref("RR-1", 2, 9),), (), "a.spec", 1, 1, "f", inputs=inputs)]
    graph = trace.build(Small().root, items, [], [], [], TODAY, parts=parts).graph
    used = {link.target for link in graph.of_kind("uses")}
    assert {node.key for kind in LINKS["uses"].targets for node in graph.by_kind[kind]} <= used
    assert {graph.nodes[key].place for key in used} == {Place("a.spec", 7, 1)}
    assert [path.target for path in paths(graph, named(graph, "RR-1"), named(graph, "m.param"))] == [
        ("parameter", "m.param")
    ]
    assert [node.id for node in graph.by_kind["constraint"]] == ["m.constraint"]


def test_a_link_of_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown kind of links 'likes'"):
        Graph({}, [Link("likes", ("a", "b"), ("a", "c"), "covers", NOWHERE)])


def test_a_name_is_a_kind_or_an_id_or_both() -> None:
    graph = Small().matrix().graph
    assert [key[0] for key in named(graph, "AV")] == ["subsystem", "interface"]
    assert named(graph, "interface:AV") == [("interface", "AV")]
    assert named(graph, "S-1-A-*") == [("requirement", name) for name in ("S-1-A-1", "S-1-A-2", "S-1-A-5")]
    assert named(graph, "safety_goal") == []
    with pytest.raises(TrackmarshalError, match="`rule:tu` is no kind of nodes, and no id in the project"):
        named(graph, "rule:tu")


def test_the_default_schema_asks_what_it_is_said_to_ask() -> None:
    asked = {(need.kind, str(need.code) or "T150") for need in default().needs}
    assert {code for _, code in asked} == {"T134", "T139", "T150", "T171", "T172", "T202", "T207"}
    assert default() is default()


def star(number: int) -> tuple[list[SpecItem], list[SpecTest], list[TestResult]]:
    """As many rules as that, all for one requirement."""
    items = [
        SpecItem("rule", f"r{n}", "t", (Ref("RR-1", n + 1, 9),), (), "a.spec", n + 1, 1, "f")
        for n in range(number)
    ]
    return items, [], []


def test_very_many_links_to_one_node() -> None:
    number = amount(5_000, 100_000)
    items, tests, results = star(number)
    graph = trace.build(Small().root, items, tests, results, [], TODAY).graph
    assert len(graph.into(("requirement", "RR-1"))) == number
    some = named(graph, f"r{number // 10 - 1}*")
    assert len(some) == 11
    assert len(paths(graph, named(graph, "RR-1"), some)) == 11
    every = [path for path in paths(graph, named(graph, "RR-1"), named(graph, "rule")) if path.target]
    assert len(every) == number


def test_too_long_an_answer_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a star every node leads to every other one: as many rows as there are pairs."""
    monkeypatch.setattr("trackmarshal.trace.graph.paths.ROWS", 30)
    nodes = {node.key: node for node in (requirement(f"R-{n}", "D") for n in range(6))}
    top, *others = nodes
    links = [Link("refines", a, b, "covers", NOWHERE) for key in others for a, b in ((key, top), (top, key))]
    graph = Graph(nodes, links)
    assert len(paths(graph, list(nodes), list(nodes))) == 30
    monkeypatch.setattr("trackmarshal.trace.graph.paths.ROWS", 29)
    with pytest.raises(TrackmarshalError, match="more than 29 rows"):
        paths(graph, list(nodes), list(nodes))


def test_a_title_of_a_megabyte_is_shown_in_one_line(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    small.replace("requirements/criteria.yaml", "title: Grip", f"title: {'grip ' * 200_000}")
    matrix = small.matrix()
    assert matrix.passes
    assert max(map(len, trace.render(matrix, "text").splitlines())) < 200


def test_very_many_names_of_nothing_take_no_longer_than_they_have_to() -> None:
    """Suggestions are looked for a few times, not for each of them."""
    items = [
        SpecItem("rule", f"r{n}", "t", (Ref(f"X-{n}", n + 1, 9),), (), "a.spec", n + 1, 1, "f")
        for n in range(5_000)
    ]
    matrix = trace.build(Small().root, items, [], [], [], TODAY)
    assert sum(finding.code == "T201" for finding in matrix.findings) == 5_000
    helped = [finding for finding in matrix.findings if finding.code == "T201" and finding.help]
    assert len(helped) <= SUGGESTED


def test_what_is_read_again_is_what_is_there(tmp_path: Path) -> None:
    """Documents are parsed once as long as their bytes stay; an edit of the same length is another document."""
    small = Small.copy(tmp_path)
    before, _ = trace.load(small.root)
    again, _ = trace.load(small.root)
    assert again is before
    small.replace("requirements/criteria.yaml", "title: Grip", "title: Grap")
    after, _ = trace.load(small.root)
    assert [str(r.title) for r in after.requirements if r.id == "RR-2"] == ["Grap"]


def test_the_spec_is_not_needed_for_a_graph() -> None:
    from trackmarshal.trace.graph.building import build

    project, _ = trace.load(Small().root)
    graph = build(project, Spec([], [], [], []), {})
    assert {link.state for link in graph.of_kind("metrics")} == {"orphaned"}


#: What a second person may read beside requirements, hazards, goals and analyses: a way to say something else under the same title.
READ = {
    "scenarios/cut_in.jsonl": ("scenarios/cut_in.jsonl", "\n", "\n\n"),
    "scenarios/skid.jsonl": (
        "requirements/v-model.yaml",
        "expect: fire, by: [friction]",
        "expect: fire, by: [gap]",
    ),
    "W-1": ("requirements/v-model.yaml", "expires: 2026-12-31", "expires: 2027-12-31"),
    "ODD-1": ("requirements/domain.yaml", "to: 60 km/h", "to: 120 km/h"),
    "test: gap: exactly on the boundary": ("", "a" * 64, "b" * 64),
    "fault: faults.yaml F-1": ("", "a" * 64, "b" * 64),
}


@pytest.mark.parametrize("id_", READ)
def test_a_review_falls_with_what_was_read_whatever_that_is(id_: str, tmp_path: Path) -> None:
    """Of tests, scenarios, faults, domains and waivers, the fingerprint was that of the title: what they say could be another, and the review stood."""
    small = Small.copy(tmp_path)
    domain = "{id: ODD-1, title: the road, description: Dry., ranges: [{quantity: ego.v, from: 0 km/h, to: 60 km/h}]}"
    (small.root / "requirements/domain.yaml").write_text(
        f"document: hazards\ntitle: Conditions\ndomains: [{domain}]\n", "utf-8"
    )
    items, tests, *_ = small.parts()

    def fallen(read: str, says: str) -> list[str]:
        review = f"{{id: RV-1, of: [{{id: '{id_}', fingerprint: '{read}'}}], by: [P-1], made: 2026-03-01, outcome: accepted}}"
        (small.root / "requirements/people.yaml").write_text(
            f"document: assurance\ntitle: Who did what\npersons: [{{id: P-1, title: Ann Author}}]\nreviews:\n  - {review}\n",
            "utf-8",
        )
        told = [replace(test, fingerprint=says) for test in tests]
        fault = FaultCase("faults.yaml", "F-1", "a jump", "RR-1", 1, "", says=says)
        found = trace.build(small.root, items, told, [], [], TODAY, fault_cases=[fault]).findings
        assert not [f.message for f in found if "RV-1" in f.message and f.code != "T167"]
        return [f.help for f in found if f.code == "T167"]

    (said,) = fallen("0" * 64, "a" * 64)
    read = re.findall(r"'(\w+)'", said)[0]
    assert fallen(read, "a" * 64) == []
    file, was, now = READ[id_]
    if file:
        path = small.root / file
        path.write_text(path.read_text("utf-8").replace(was, now), "utf-8")
    assert len(fallen(read, "a" * 64 if file else now)) == 1
