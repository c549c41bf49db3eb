"""Whatever is taken away, the gate notices; whatever is put back, it passes again."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from golden.trace.cases import PROJECT, TODAY, Small
from support.project import command
from support.start import new_project
from trackmarshal import trace
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records.specs import SpecItem, SpecTest

ITEMS, TESTS, RESULTS, RUNS = Small().parts()
BASELINE = "requirements/baseline.json"
MODEL = "requirements/system-model.yaml"
CRITERIA = "requirements/criteria.yaml"


def fails(root: Path = PROJECT, items: list[SpecItem] = ITEMS, tests: list[SpecTest] = TESTS) -> list[str]:
    return [f.code for f in trace.gate(trace.build(root, items, tests, RESULTS, RUNS, TODAY))]


def test_it_passes_as_it_is() -> None:
    assert fails() == []


@pytest.mark.parametrize("index", range(len(ITEMS)), ids=[item.name for item in ITEMS])
def test_a_rule_taken_away_with_its_tests(index: int) -> None:
    name = ITEMS[index].name
    found = fails(items=[i for i in ITEMS if i.name != name], tests=[t for t in TESTS if t.rule != name])
    assert "T205" in found
    assert "T222" in found


@pytest.mark.parametrize("index", range(len(TESTS)), ids=[f"{t.rule}: {t.title}" for t in TESTS])
def test_a_test_taken_away(index: int) -> None:
    assert "T221" in fails(tests=[t for number, t in enumerate(TESTS) if number != index])


@pytest.mark.parametrize("index", range(len(TESTS)), ids=[f"{t.rule}: {t.title}" for t in TESTS])
def test_a_needed_test_taken_away_without_a_baseline(index: int, tmp_path: Path) -> None:
    small = Small.copy(tmp_path).replace(
        "requirements/v-model.yaml", "  baseline: requirements/baseline.json\n", ""
    )
    gone = TESTS[index]
    found = fails(small.root, tests=[t for t in TESTS if t is not gone])
    if gone.title == "inside":  # the boundary test expects `satisfied` too: only a baseline notices this one
        assert found == ["T220"]
    else:
        assert sorted(found) == ["T212", "T220"]


def test_links_taken_away() -> None:
    for number, item in enumerate(ITEMS):
        items = [*ITEMS[:number], replace(item, satisfies=()), *ITEMS[number + 1 :]]
        assert {"T202", "T206", "T227"} <= set(fails(items=items)), item.name


def derivations() -> list[tuple[str, str]]:
    text = (PROJECT / CRITERIA).read_text(encoding="utf-8")
    lists = re.findall(r"    derived_from: \[(.*)\]\n", text)
    return [(line, name) for line in dict.fromkeys(lists) for name in line.split(", ")]


@pytest.mark.parametrize(("line", "name"), derivations())
def test_a_derivation_taken_away(line: str, name: str, tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    path = small.root / CRITERIA
    left = ", ".join(other for other in line.split(", ") if other != name)
    text = path.read_text(encoding="utf-8").replace(f"derived_from: [{line}]", f"derived_from: [{left}]", 1)
    path.write_text(text, encoding="utf-8")
    assert {"T136", "T224"} <= set(fails(small.root))


@pytest.mark.parametrize("name", ["AV", "AV-TP", "AV-RO", "TP-RO"])
def test_an_interface_taken_away(name: str, tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    path = small.root / MODEL
    text = path.read_text(encoding="utf-8")
    head, _, body = text.partition("interfaces:\n")
    blocks = re.findall(r"  - id: .*\n(?:    .*\n)*", body)
    kept = [block for block in blocks if not block.startswith(f"  - id: {name}\n")]
    assert len(kept) == len(blocks) - 1
    path.write_text(head + "interfaces:\n" + "".join(kept), encoding="utf-8")
    assert {"T144", "T224"} <= set(fails(small.root))
    path.write_text(text, encoding="utf-8")
    assert fails(small.root) == []


def test_a_consistent_removal_on_both_sides_is_noticed_by_the_baseline(tmp_path: Path) -> None:
    """Interface and derivation are edited together, so that they agree: only what was accepted tells."""
    small = Small.copy(tmp_path)
    small.replace(CRITERIA, "derived_from: [AV, AV-RO]", "derived_from: [AV]")
    small.replace(
        MODEL,
        "{id: AV-RO.1, text: The tyres slide., leads_to: [S-1-A-5]}",
        "{id: AV-RO.1, text: They meet., leads_to: [S-1-A-1]}",
    )
    text = (small.root / CRITERIA).read_text(encoding="utf-8")
    first = "derived_from: [AV-TP]"
    (small.root / CRITERIA).write_text(
        text.replace(first, "derived_from: [AV-TP, AV-RO]", 1), encoding="utf-8"
    )
    assert set(fails(small.root)) == {"T224"}


def test_what_a_stage_must_show_is_held_by_the_baseline(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    small.accept()
    small.replace("requirements/v-model.yaml", "shows: no fire", "shows: whatever there is")
    assert [(f.code, f.subject) for f in trace.gate(small.matrix())] == [("T371", "S-4-B")]


def test_another_tool_in_place_of_one_that_was_argued_over_is_noticed(tmp_path: Path) -> None:
    """Its confidence was argued of the program that the title names; the version may be the same."""
    small = Small.copy(tmp_path)
    tool = "document: assurance\ntitle: tools\ntools: [{id: TL-1, title: %s, version: '13'}]\n"
    path = small.root / "requirements/tools.yaml"
    path.write_text(tool % "a compiler", "utf-8")
    small.accept()
    before = trace.gate(small.matrix())
    path.write_text(tool % "another compiler", "utf-8")
    assert [(f.code, f.subject) for f in trace.gate(small.matrix()) if f not in before] == [("T376", "TL-1")]


def test_another_vehicle_is_noticed_by_the_baseline(tmp_path: Path) -> None:
    """Which interfaces have to be analysed hangs on it: where all are, nothing else tells."""
    small = Small.copy(tmp_path)
    small.replace(
        MODEL,
        "    rationale: The vehicle takes no part.\n",
        "    issues: [{id: TP-RO.1, text: They leave it., leads_to: [S-1-A-5]}]\n  - id: RO\n    title: properties of the road\n"
        "    issues: [{id: RO.1, text: It is wet., leads_to: [S-1-A-5]}]\n",
    )
    small.replace(CRITERIA, "derived_from: [AV, AV-RO]", "derived_from: [AV, AV-RO, TP-RO, RO]")
    small.accept()
    assert trace.gate(small.matrix()) == []
    small.replace(MODEL, "role: vehicle", "role: environment")
    small.replace(MODEL, "title: road, role: environment", "title: road, role: vehicle")
    (found,) = trace.gate(small.matrix())
    assert (found.code, found.subject, len(found.also)) == ("T224", "AV", 1)


def test_what_became_weaker_is_accepted_by_somebody_for_a_reason(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    tests = [t for t in TESTS if (t.rule, t.title) != ("gap", "inside")]
    assert fails(small.root, tests=tests) == ["T221"]
    before = (small.root / BASELINE).read_bytes()
    for said in (
        {},
        {"by": "Ann Author"},
        {"reason": "because"},
        {"by": " ", "reason": "because"},
        {"by": "TBD", "reason": "because"},
        {"by": "Ann Author", "reason": "<TODO>"},
    ):
        with pytest.raises(TrackmarshalError) as caught:
            trace.accept_baseline(small.root, ITEMS, tests, **said)  # type: ignore[arg-type]
        assert caught.value.code == "T378"
        assert (small.root / BASELINE).read_bytes() == before
    path, weaker = trace.accept_baseline(
        small.root, ITEMS, tests, by="Ann Author", reason="the same twice", today=TODAY
    )
    assert path == small.root / BASELINE
    assert weaker == ["test gap: inside is gone"]
    assert fails(small.root, tests=tests) == []
    assert [p.name for p in path.parent.glob(".*")] == []
    done = json.loads(path.read_text("utf-8"))["acceptances"]
    assert len(done) == 2
    assert (done[1]["by"], done[1]["reason"], done[1]["weaker"]) == ("Ann Author", "the same twice", weaker)


HAZARD = (
    "document: hazards\ntitle: Hazards\nhazards:\n  - {id: H-1, title: A door closes, situation: At a stop., severity: S0, exposure: E4,\n"
    "     controllability: C1, asil: QM, rationale: It is soft.}\n"
)
READ = (
    "document: assurance\ntitle: Who\npersons: [{id: P-1, title: the maintainers}, {id: P-2, title: the safety manager}, {id: P-3, title: perception}, {id: P-4, title: Ben}]\n"
    "reviews: [{id: RV-1, of: [{id: H-1, fingerprint: '%s'}], by: [P-4], made: 2026-05-01, outcome: accepted}]\n"
)


def test_what_nobody_reviewed_is_accepted_by_somebody_for_a_reason(tmp_path: Path) -> None:
    """It is on a list that is closed, shown by number, and off it once it is reviewed."""
    small = Small.copy(tmp_path)
    before = json.loads((small.root / BASELINE).read_text("utf-8"))["content"]
    (small.root / "requirements" / "hazards.yaml").write_text(HAZARD, "utf-8")
    assert fails(small.root) == ["T382"]
    with pytest.raises(TrackmarshalError) as caught:
        trace.accept_baseline(small.root, ITEMS, TESTS)
    assert caught.value.code == "T378"
    _, weaker = trace.accept_baseline(
        small.root, ITEMS, TESTS, by="Ann Author", reason="next week", today=TODAY
    )
    assert weaker == ["unreviewed hazard H-1 is new"]
    after = json.loads((small.root / BASELINE).read_text("utf-8"))["content"]
    assert sorted(after.keys() - before.keys()) == ["hazard H-1", "unreviewed hazard H-1"]
    matrix = small.matrix()
    assert (matrix.passes, matrix.verdict) == (True, "pass with reservations")
    assert ("hazard", "H-1") in matrix.unreviewed
    assert f"nobody has reviewed {len(matrix.unreviewed)} things" in matrix.reservations
    said = hashlib.sha256(b"At a stop. S0 E4 C1 QM rationale: It is soft.").hexdigest()
    (small.root / "requirements" / "assurance.yaml").write_text(READ % said, "utf-8")
    matrix = small.matrix()
    assert ("hazard", "H-1") not in matrix.unreviewed
    assert [
        f.code for f in matrix.findings if "off the list of what nobody has reviewed: `H-1`" in f.message
    ] == ["T226"]


def test_what_is_new_is_accepted_without_a_word(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    more = [*TESTS, replace(TESTS[0], title="another")]
    assert trace.accept_baseline(small.root, ITEMS, more)[1] == []
    assert fails(small.root, tests=TESTS) == ["T221"]


@pytest.mark.parametrize(("old", "new"), [
    ('"test gap: inside"', '"test gap: inside."'), ('"meaning"', '"meant"'), ('"asil": "D"', '"asil": "QM"'), ('"expects": "violated"', '"expects": "satisfied"'),
], ids=["a title", "a field", "an asil", "an expectation"])  # fmt: skip
def test_a_baseline_that_was_edited_is_named(old: str, new: str, tmp_path: Path) -> None:
    """Whatever was changed in it, and also where it then agrees with the project."""
    small = Small.copy(tmp_path)
    path = small.root / BASELINE
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    assert "T379" in fails(small.root)


@pytest.mark.parametrize(("old", "new"), [
    ('"boundary tests a rule": "1"', '"boundary tests a rule": "one"'), ('"boundary tests a rule": "1"', '"boundary tests a rule": ["1"]'),
    ('"weaker": []', '"weaker": [1]'), ('"weaker": []', '"weaker": "rule gap is gone"'), ('"by": "Ann Author"', '"by": null'), ('"by": "Ann Author"', '"who": "Ann Author"'),
], ids=["a count", "a list", "no text", "no list", "nobody", "another field"])  # fmt: skip
def test_a_baseline_of_another_form_cannot_be_read(old: str, new: str, tmp_path: Path) -> None:
    """Whoever edits it may leave anything there."""
    small = Small.copy(tmp_path)
    path = small.root / BASELINE
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    matrix = small.matrix()
    said = [(f.code, f.message) for f in matrix.findings]
    assert said == [("T220", "the baseline cannot be read: it is not what `--accept-baseline` writes")]
    for kind in trace.FORMATS:
        trace.render(matrix, kind)


def test_accepting_the_same_again_changes_nothing(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    before = (small.root / "requirements/baseline.json").read_bytes()
    trace.accept_baseline(small.root, ITEMS[::-1], TESTS[::-1])
    assert (small.root / "requirements/baseline.json").read_bytes() == before


def test_no_baseline_is_accepted_from_unreadable_requirements(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    (small.root / "requirements/more.yaml").write_text("a: [", encoding="utf-8")
    with pytest.raises(TrackmarshalError, match="T105"):
        trace.accept_baseline(small.root, ITEMS, TESTS)


def test_a_test_that_is_missing_follows_from_no_method(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever had measured found out only then that the rule lacks a test."""
    root = tmp_path / "car"
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    new_project(root)
    (root / "specs" / "slow.spec").write_text(
        'module slow\n\nuse signals\n\nrule slow "never"\n  satisfies R-1\n  for all   p in plan\n  require   p.v >= 0 m/s\n',
        "utf-8",
    )
    document = root / "requirements" / "requirements.yaml"
    text = document.read_text("utf-8")
    document.write_text(text.replace("[test, scenario]", "[test, scenario, measurement]"), "utf-8")
    found = json.loads(command(root, "trace", "--format", "json")[1])["findings"]
    assert {f["code"] for f in found} >= {"T211", "T255"}
    assert [f["code"] for f in found if f["code"] == "T211" and f.get("cause")] == []
