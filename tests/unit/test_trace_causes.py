"""Which finding follows from which: in time, whatever a document lacks."""

from __future__ import annotations

import pytest

from trackmarshal.trace import causes as folding
from trackmarshal.trace.causes import causes
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.graph import Graph, Link, Node


def test_what_many_records_lack_is_not_held_against_all_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a list of requirements that a program wrote: of 200 that each lacked five fields `trace` took 12 s, and the time grew as the square of that."""
    asked = 0
    explains = folding._explains

    def counting(other: Finding, finding: Finding) -> bool:
        nonlocal asked
        asked += 1
        return explains(other, finding)

    monkeypatch.setattr(folding, "_explains", counting)
    lacking = [
        Finding("T120", "error", "`title` is missing", Place("requirements/all.yaml", line, 5))
        for line in range(1, 501)
    ]
    absent = [Finding("T137", "error", "nothing of this id", None, subject=f"R-{n}") for n in range(200)]
    found = causes([*lacking, *absent], Graph({}, ()))
    assert found == dict.fromkeys(absent, lacking[0])  # what was not read may be why things are not there
    assert asked < 10 * (len(lacking) + len(absent))


def test_nothing_follows_from_itself() -> None:
    """By way of another one either: whoever asked what it follows from in the end would ask for ever."""
    changed, contract, missing = (
        Finding(f"T{number}", "error", "x", Place("a.yaml", line), subject=subject, gone=True)
        for line, (number, subject) in enumerate([(380, "a"), (372, "a"), (379, "")], 1)
    )
    found = causes([changed, contract, missing], Graph({}, ()))
    assert {found.get(contract), found.get(changed)} & {changed, missing}
    assert all(cause not in found for cause in found.values())


def test_what_follows_from_one_of_many_alike_follows_from_the_first() -> None:
    """Also where those that come before it follow from something themselves."""
    page = "requirements/all.yaml"
    broken = Finding("T105", "error", "not YAML", Place(page, 1))
    alike = [Finding("T120", "error", f"{n}", Place(page, n)) for n in range(2, 6)]
    later = Finding("T218", "error", "a result of no test", Place(page, 9))
    assert causes([later, *alike], Graph({}, ())) == {later: alike[0]}
    assert causes([later, *alike, broken], Graph({}, ())) == dict.fromkeys([later, *alike], broken)


def test_a_file_that_was_written_while_it_was_read_stands_for_itself() -> None:
    """That a mistake is in the same file does not explain it, and it explains none."""
    page = "requirements/all.yaml"
    written = Finding("T296", "error", "was written while it was read", Place(page))
    broken = Finding("T105", "error", "not YAML", Place(page, 1))
    later = Finding("T218", "error", "a result of no test", Place(page, 9))
    assert causes([written, broken], Graph({}, ())) == {}
    assert causes([written, later], Graph({}, ())) == {}


def test_nobody_has_reviewed_a_hazard_whatever_the_recordings_reach() -> None:
    """That a scenario is gone since, which is why they reach less, was the reason for everything that is read by nobody."""
    place = Place("requirements/hazards.yaml", 1)
    nodes = [Node(kind, id_, "t", place, {}) for kind, id_ in (("operational design domain", "ODD-1"), ("hazard", "H-1"))]  # fmt: skip
    link = Link("operates_in", nodes[1].key, nodes[0].key, "covers", place)
    graph = Graph({node.key: node for node in nodes}, [link])
    gone = Finding(
        "T228", "error", "a scenario is gone", None, subject="a.yaml", about=("at S-4",), gone=True
    )
    claimed = Finding("T254", "error", "claims more", None, subject="ODD-1", rests_on=("at S-4",))
    unread = Finding("T382", "error", "nobody has reviewed it", None, subject="H-1")
    assert causes([gone, claimed, unread], graph) == {claimed: gone}


def test_what_a_sibling_lacks_explains_nothing_of_the_other_one() -> None:
    """Two parts of one goal that are both below it: that the one lacks a field hid the other one, which is to be mended for itself."""
    page = "requirements/all.yaml"
    places = {"A": Place(page, 1), "B": Place(page, 9)}
    nodes = [Node("requirement", name, "", place, {}) for name, place in places.items()]
    goal = Node("safety goal", "SG", "", Place("requirements/goals.yaml", 1), {})
    links = tuple(Link("achieves", node.key, goal.key, "covers", places[node.id]) for node in nodes)
    graph = Graph({node.key: node for node in (*nodes, goal)}, links)
    lacks = Finding("T120", "error", "`asil` is missing", Place(page, 2))
    below, other = (
        Finding("T160", "error", "below its goal", node.place, subject=node.id, about=("SG",))
        for node in nodes
    )
    assert causes([lacks, below, other], graph) == {below: lacks}


@pytest.mark.parametrize("code", ["T211", "T212", "T222", "T372"])
def test_no_document_takes_from_specs_but_the_one_that_names_them(code: str) -> None:
    """A hazard without an ASIL was said to be why a rule is gone, and why another one has no test: neither was shown until the hazard was mended."""
    settings, spec = "requirements/v-model.yaml", "specs/truck.spec"
    stage = Node("stage", "S-1", "rules", Place(settings, 20), {})
    graph = Graph({stage.key: stage}, ())
    lost = Finding(code, "error", "not there", None, subject="a_rule", gone=code not in ("T211", "T212"))
    lacking = [
        Finding("T120", "error", f"the hazard has no `{field}`", Place("requirements/hazards.yaml", 4))
        for field in ("asil", "exposure")
    ]
    assert causes([*lacking, lost], graph) == {}
    broken = Finding("E301", "error", "cannot compare", Place(spec, 7))
    assert causes([*lacking, broken, lost], graph) == {lost: broken}
    named = Finding("T121", "error", "the project has no field `spec`", Place(settings, 7))
    assert causes([named, lost], graph) == ({} if code == "T211" else {lost: named})
    fewer = Finding("T371", "error", "fewer specs are read", Place("requirements/baseline.json"))
    assert causes([fewer, lost], graph) == ({lost: fewer} if lost.gone else {})
