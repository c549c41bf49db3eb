"""The pages of an assessment: well formed, self-contained, safe against hostile names, true to the records."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest

from support.report_runs import cycle, large, other, overtaking, record, recording
from trackmarshal import trace
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import RuleFacts, RunSummary
from trackmarshal.trace.report import write_report
from trackmarshal.trace.report.codes import CODES
from trackmarshal.trace.report.firings import firing_rows
from trackmarshal.trace.report.pages import page_names
from trackmarshal.trace.report.reading import read_run
from trackmarshal.trace.runs import _fired, _unexpected

#: Elements of HTML that have no end tag.
VOID = {"meta", "br", "input", "img", "link", "hr"}
HOSTILE = '<script>alert("x")</script>&\'{{ 7*7 }}'
SUMMARY: dict[str, Any] = {
    "coverage": {"S-2-B": {"covered": 5, "of": 8, "waived": 1, "failed": 2}, "S-3": {"covered": 0, "of": 0}, "S-4": {"covered": 1, "of": 2}},
    "stages": [{"id": "S-2-B", "title": "Rules"}],
    "requirements": [{"id": "R-2", "title": "Keep your distance"}],
}  # fmt: skip
COVERED: dict[str, Any] = {"coverage": {"S": {"covered": 1, "of": 1}}, "verdict": "pass"}
MISSING: list[dict[str, Any]] = [
    {"code": "T201", "level": "error", "message": "R-9 is covered by nothing", "span": "requirements/r.yaml:4:3", "help": "write a rule"},
    {"code": "T202", "level": "warning", "message": "old evidence", "file": "a.yaml", "line": 3, "help": None},
    {"code": "T203", "level": "note", "message": "for your information", "span": None},
]  # fmt: skip
CHECKS = {"modules": 1, "rules": 5, "errors": 0, "warnings": 0, "tests": 12, "failed": 0}
META = {
    "project": "demo",
    "created": "2020-01-02T03:04:05+00:00",
    "tool": "trackmarshal 9",
    "python": "3.11",
    "spec_fingerprint": "abc",
}


class Document(HTMLParser):
    """Checks that elements nest, and collects what a test asks for."""

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.words: list[str] = []
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not {"style", "script"} & set(self.open):
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))


def checked(path: Path) -> Document:
    """A page that nests, whose pictures are XML, and which asks nothing of a network."""
    page = path.read_text("utf-8")
    document = Document(page)
    for picture in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        ET.fromstring(picture)
    for tag, name, value in document.attributes:
        if name in ("src", "href", "action", "data", "poster", "srcset"):
            assert not re.match(r"[a-z]+:|//", value, re.IGNORECASE), f"{tag} {name}={value}"
        assert name != "style" or "url(" not in value
        assert not name.startswith("on")
    bare = page.replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert "http://" not in bare
    assert "https://" not in bare
    assert not re.search(r"@import|url\((?!#)", page)
    ids = [value for _, name, value in document.attributes if name == "id"]
    assert len(ids) == len(set(ids))
    links = [
        value[1:]
        for tag, name, value in document.attributes
        if tag == "a" and name == "href" and value.startswith("#")
    ]
    assert set(links) <= set(ids)
    return document


def written(
    folder: Path, runs: list[dict[str, Any]], matrix: str | None = "matrix.html", summary: Mapping[str, Any] = SUMMARY,
    missing: list[dict[str, Any]] | None = None, checks: Mapping[str, Any] = CHECKS,
) -> tuple[Document, list[Document]]:  # fmt: skip
    """The index and the pages of the runs."""
    index = write_report(
        folder / "out", runs, matrix, summary, MISSING if missing is None else missing, checks, META
    )
    assert index == folder / "out" / "index.html"
    return checked(index), [checked(page) for page in sorted((folder / "out" / "runs").glob("*.html"))]


def test_index_says_what_was_assessed_what_is_missing_and_where(tmp_path: Path) -> None:
    index, _ = written(
        tmp_path,
        [record(tmp_path, overtaking(ground_truth={"dynamic": (None,) * 10 + (False,) * 21 + (None,) * 9}))],
    )
    for words in ("Assessment of demo", "2020-01-02T03:04:05+00:00", "trackmarshal 9, Python 3.11", "abc"):
        assert words in index.text
    for words in (
        "error T201",
        "R-9 is covered by nothing",
        "requirements/r.yaml:4:3",
        "write a rule",
        "a.yaml:3",
    ):
        assert words in index.text
    assert "5 of 8" in index.text
    assert "5 covered, 1 waived, 2 failed" in index.text
    assert "1 covered, 1 not covered" in index.text
    assert "nothing demanded" in index.text
    assert "✓ dynamic: inside 21 judged" in index.text
    assert "1 s: near (driving; 1 rule in all)" in index.text
    assert ("a", "href", "matrix.html") in index.attributes
    assert ("a", "href", "runs/run.html") in index.attributes
    assert "A-WHO" in index.text


def test_what_follows_from_a_finding_stands_below_it(tmp_path: Path) -> None:
    """As in every other output: of one cause, the first screen had its consequences, and it came last."""
    missing = [
        {**MISSING[0], "message": "K-1 is open", "id": 1, "cause": 3},
        {**MISSING[1], "message": "old evidence", "id": 2, "cause": 3},
        {**MISSING[0], "message": "the scenario is another one", "id": 3, "cause": None},
        {**MISSING[0], "message": "a rule has no test", "id": 4, "cause": None},
    ]
    index, _ = written(tmp_path, [record(tmp_path, overtaking())], summary=COVERED, missing=missing)
    assert "3 findings must be mended" in index.text
    assert "2 errors: must be mended; 2 more follow from them" in index.text
    below = index.text.index("and 2 that follow from it")
    assert index.text.index("the scenario is another one") < below < index.text.index("K-1 is open")
    assert index.text.index("old evidence") < index.text.index("a rule has no test")


@pytest.mark.parametrize(
    ("change", "word", "sentence"),
    [
        ({}, "✓ PASS", "1 of 1 demands of the V-model are covered, all 12 tests passed and 1 of 1 run could be held"),
        ({"missing": [MISSING[0]]}, "✗ FAIL", "1 finding must be mended"),
        ({"missing": [MISSING[1]], "summary": {**COVERED, "verdict": "pass with reservations"}}, "⚑ PASS WITH RESERVATIONS", "1 warning should be looked at"),
        ({"summary": {**COVERED, "verdict": "pass with reservations", "reservations": ["1 cell is waived", "3 findings are waived", "nobody has reviewed 4 things"]}},
         "⚑ PASS WITH RESERVATIONS", "; 3 findings are waived and nobody has reviewed 4 things."),
        ({"checks": {**CHECKS, "failed": 2}}, "✗ FAIL", "2 of 12 tests failed"),
        ({"checks": {**CHECKS, "errors": 3}}, "✗ FAIL", "The specs have 3 errors"),
        ({"checks": {**CHECKS, "tests": 0}}, "✓ PASS", "Nothing wrong was found, but not everything was done: no test was run"),
        ({"checks": {}}, "✓ PASS", "not everything was done: the specs were not checked and no test was run"),
        ({"summary": {}}, "○ NO VERDICT", "no coverage was computed"),
        ({"summary": {"coverage": {"S": {"covered": 0, "of": 1}}, "verdict": "fail"}}, "✗ FAIL", "0 of 1 demands"),
    ],
)  # fmt: skip
def test_overall_state(tmp_path: Path, change: dict[str, Any], word: str, sentence: str) -> None:
    run = record(tmp_path, overtaking(ground_truth={"dynamic": (None,) * 10 + (False,) * 21 + (None,) * 9}))
    plain: dict[str, Any] = {"summary": COVERED, "missing": []}
    index, _ = written(tmp_path, [run], **{**plain, **change})
    assert word in index.text
    assert sentence in index.text


def test_run_outside_its_ground_truth_is_never_complete(tmp_path: Path) -> None:
    run = record(tmp_path, overtaking(ground_truth={"dynamic": (True,) * 40, "static": (True,) * 40}))
    index, (page,) = written(
        tmp_path, [run], summary={"coverage": {"S": {"covered": 1, "of": 1}}}, missing=[]
    )
    assert "✗ FAIL" in index.text
    assert "Run lies outside its ground truth" in index.text
    assert "✕ dynamic: outside" in page.text
    assert "false alarm at 1 to 3 s" in page.text
    assert "✓ static: inside" in page.text


def test_demands_that_are_not_covered_are_named_even_when_the_gate_passes(tmp_path: Path) -> None:
    cells = {
        "R-1": {"S-4": {"status": "missing"}},
        "R-2": {"S-4": {"status": "waived"}, "S-3": {"status": "covered"}},
    }
    summary = {
        "coverage": {"S-3": {"covered": 1, "of": 1}, "S-4": {"covered": 0, "of": 2, "waived": 1, "missing": 1}},
        "requirements": [{"id": name, "title": "", "stages": stages} for name, stages in cells.items()],
    }  # fmt: skip
    index, _ = written(tmp_path, [], summary=summary, missing=[])
    assert "○ missing S-4 R-1 ⚑ waived S-4 R-2" in index.text
    assert ("a", "href", "matrix.html#at=requirement%3AR-1") in index.attributes
    assert "1 of 3 demands of the V-model covered; 1 waived" in index.text


def test_one_is_no_plural_and_nothing_is_said_of_every_rule_where_there_is_none(tmp_path: Path) -> None:
    one = {"modules": 1, "rules": 0, "errors": 1, "warnings": 1, "tests": 0, "failed": 0, "uncovered": []}
    index, _ = written(tmp_path, [], missing=[], checks=one)
    assert "1 module, 0 rules" in index.text
    assert "1 error, 1 warning " in index.text
    assert "every rule has tests" not in index.text


@pytest.mark.parametrize(
    ("granted", "expires", "said"),
    [
        ("2026-01-01", "2026-06-02", "Maria 2026-01-01 until"),
        ("2026-01-01", "2026-06-01", "Maria ✕ not now 2026-01-01 until"),
        ("2026-06-03", "2026-07-01", "Maria ✕ not now 2026-06-03 until"),
    ],
)
def test_a_waiver_that_does_not_hold_is_told_apart(
    tmp_path: Path, granted: str, expires: str, said: str
) -> None:
    """It stood under "Waived", as if it excused anything on the day of the assessment."""
    one = {
        "id": "W-1", "stages": ["S-4"], "requirements": ["R-1"], "codes": [], "subjects": [], "justification": "later", "residual_risk": "", "owner": "Rolf",
        "approver": "Maria", "granted": granted, "expires": expires,
    }  # fmt: skip
    index, _ = written(tmp_path, [], summary={**SUMMARY, "date": "2026-06-02", "waivers": [one]}, missing=[])
    assert said in index.text
    assert "Waived" not in index.text


def test_without_runs_the_index_says_so(tmp_path: Path) -> None:
    index, pages = written(tmp_path, [], matrix=None, missing=[])
    assert pages == []
    assert "No scenario was replayed" in index.text
    assert not any(value == "matrix.html" for _, _, value in index.attributes)


def test_run_page_has_every_firing_with_its_reason(tmp_path: Path) -> None:
    _, (page,) = written(tmp_path, [record(tmp_path, overtaking(), "feed")])
    assert "In 21 of 40 cycles the planned trajectory is not driven" in page.text
    assert (
        "near R-2 driving and emergency 1 to 3 −10 m at 2 o: blue in objects (x = 40 m, y = 3 m) small.spec:27:11"
        in page.text
    )
    assert "require abs(o.x - ego.x) > 10 m" in page.text
    assert "Keep your distance" in page.text
    assert "feed" in page.text
    assert "near driving violated: 1 to 3" in page.text


def test_pictures_come_at_two_sizes_and_with_words(tmp_path: Path) -> None:
    _, (page,) = written(tmp_path, [record(tmp_path, overtaking())])
    classes = [value for tag, name, value in page.attributes if name == "class" and tag == "div"]
    assert classes.count("wide") == classes.count("narrow") >= 4
    assert "Positions as a table" in page.text
    assert "Verdicts as a table" in page.text


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    run = record(tmp_path, overtaking(HOSTILE, notes=(HOSTILE,)))
    run["source"] = run["vehicle_note"] = HOSTILE
    for rule in run["rules"]:
        rule.update(
            name=HOSTILE + rule["name"],
            title=HOSTILE,
            text=HOSTILE,
            source=HOSTILE,
            because=HOSTILE,
            requirements=[HOSTILE],
            unit=HOSTILE,
        )
        for lane in rule["candidates"].values():
            for firing in lane["firings"]:
                firing["worst"].update(reason=HOSTILE, line=HOSTILE, span=HOSTILE, unit=HOSTILE)
                firing["worst"]["where"][0].update(name=HOSTILE, value=HOSTILE, signal=HOSTILE)
    for entry in run["objects"]:
        entry["id"] = HOSTILE
    for assumption in run["assumptions"]:
        assumption.update(name=HOSTILE, title=HOSTILE, owner=HOSTILE, evidence=HOSTILE)
    finding = {"code": HOSTILE, "level": "error", "message": HOSTILE, "span": HOSTILE, "help": HOSTILE}
    checks = {
        **CHECKS,
        "failed": 1,
        "failures": [{"rule": HOSTILE, "title": HOSTILE, "message": HOSTILE, "place": HOSTILE}],
        "uncovered": [HOSTILE],
    }
    summary = {
        "coverage": {HOSTILE: {"covered": 1, "of": 1}}, "stages": [{"id": HOSTILE, "title": HOSTILE}],
        "requirements": [{"id": HOSTILE, "title": HOSTILE}],
    }  # fmt: skip
    index, pages = written(tmp_path, [run], summary=summary, missing=[finding], checks=checks)
    for document in (index, *pages):
        assert HOSTILE in document.text
    for path in (tmp_path / "out").rglob("*.html"):
        page = path.read_text("utf-8")
        assert "alert(" in page
        assert not re.search(r"<script>\s*alert", page)
        assert "{{ 7*7 }}" in page
        (data,) = re.findall(r'id="run-data">(.*?)</script>', page, re.DOTALL) or ["{}"]
        json.loads(data)


def test_a_kept_run_is_told_beside_those_that_were_replayed(tmp_path: Path) -> None:
    """Cells are covered by it, and it has no page."""
    kept = [{"path": HOSTILE, "title": "A drive", "cycles": 5636, "fired": False, "day": "2026-11-29"}]
    run = record(tmp_path, overtaking(count=2))
    page = write_report(tmp_path / "out", [run], "matrix.html", SUMMARY, [], CHECKS, META, kept=kept)
    text = Document(page.read_text("utf-8")).text
    assert f"{HOSTILE} A drive: nothing fired in 5636 cycles (run of 2026-11-29)" in text


@pytest.mark.parametrize(
    ("others", "said"),
    [
        ((0,), "evaluated in no run"),
        ((1, 0), "held in 1 of 2 runs, and was not evaluated in the others"),
        ((1, 1), "held in all runs"),
    ],
)
def test_an_assumption_held_where_its_monitor_said_so(
    others: tuple[int, ...], said: str, tmp_path: Path
) -> None:
    """Where there are no objects, nothing was shown of how old they are."""
    runs = [
        record(tmp_path, recording([cycle(0.0, 0.0, [other("near", 30.0)] * number)], f"run {index}"))
        for index, number in enumerate(others)
    ]
    index, _ = written(tmp_path, runs)
    assert said in index.text


def test_names_of_pages_are_safe_and_different() -> None:
    assert page_names(["../../etc/passwd", "a b", "a/b", "A-B", "", "...", "ü", "con.x", "x" * 300]) == [
        "etc-passwd", "a-b", "a-b-2", "A-B-3", "run", "run-2", "run-3", "con.x", "x" * 80,
    ]  # fmt: skip


def test_runs_of_one_name_have_a_page_each_and_link_to_their_neighbours(tmp_path: Path) -> None:
    run = record(tmp_path, overtaking(count=2))
    _, pages = written(tmp_path, [run, run, run])
    assert sorted(p.name for p in (tmp_path / "out" / "runs").iterdir()) == [
        "run-2.html",
        "run-3.html",
        "run.html",
    ]
    middle = pages[0]
    assert {("a", "href", "run.html"), ("a", "href", "run-3.html")} <= set(middle.attributes)


@pytest.mark.parametrize(
    "run",
    [
        pytest.param(recording([]), id="no cycle"),
        pytest.param(recording([cycle(0.0, 0.0)]), id="one cycle"),
        pytest.param(recording([cycle(0.0, 0.0), cycle(0.1, 2.0)]), id="no objects"),
        pytest.param(recording([cycle(0.0, float("nan")), cycle(0.1, float("nan"))]), id="pose unknown"),
        pytest.param(recording([cycle(0.0, 0.0), cycle(0.1, float("nan")), cycle(0.2, 4.0)]), id="pose lost"),
        pytest.param(recording([cycle(0.1 * i, 0.0, v=0.0) for i in range(30)]), id="standing still"),
        pytest.param(recording([cycle(0.0, 0.0, [other("o", float("inf")), other("p", 5.0, length=float("nan"))])]), id="bad objects"),
        pytest.param(recording([cycle(0.0, 0.0), cycle(5.0, 9.0), cycle(5.1, 9.2), cycle(5.2, 9.4)]), id="gap in time"),
        pytest.param(recording([cycle(0.0, 0.0)], track={"left": [], "right": [], "closed": False}), id="no track"),
        pytest.param(recording([cycle(1e9, 1e7), cycle(1e9 + 0.1, 1e7)]), id="far away"),
        pytest.param(recording([cycle(0.0, 0.0)], obstacles=[{"id": "cone", "x": 9.0, "y": 1.0, "heading": 0.0, "length": 0.3, "width": 0.3}]), id="obstacle"),
    ],
)  # fmt: skip
def test_unusual_runs(tmp_path: Path, run: Any) -> None:
    made = record(tmp_path, run)
    index, (page,) = written(tmp_path, [made])
    assert "run" in index.text
    for path in (tmp_path / "out").rglob("*.html"):
        assert not re.search(
            r'(?:d|x|y|cx|cy|width|height|points)="[^"]*(?:nan|inf)', path.read_text("utf-8")
        )
    if not run.cycles:
        assert "nothing was checked" in page.text
        assert "has no cycles" in index.text


def test_margins_that_are_not_finite(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking(count=5))
    lane = next(r for r in made["rules"] if r["name"] == "near")["candidates"]["driving"]
    lane["verdict"] = "vsvus"
    lane["margin"] = ["-inf", "inf", -2.0, "nan", 1e300]
    worst = {**lane["least"], "margin": "-inf", "verdict": "violated", "cycle": 0, "t": 0.0}
    lane["least"] = worst
    lane["firings"] = [{"from": 0.0, "to": 0.0, "cycles": [0, 0], "verdicts": ["violated"], "worst": worst}]
    _, (page,) = written(tmp_path, [made])
    assert "−∞" in page.text
    assert "undefined" in page.text


def test_times_that_cannot_be_used_become_numbers_of_cycles(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking(count=4))
    made["t"] = [0.0, 0.2, 0.1, "nan"]
    _, (page,) = written(tmp_path, [made])
    assert "the record's times cannot be used" in page.text


def test_faults_of_the_input_contract_are_listed(tmp_path: Path) -> None:
    made = record(tmp_path, recording([cycle(0.0, 0.0, [other("o", 40.0, age=99.0)])]))
    assert made["candidates"]["driving"]["safe"] == [False]
    _, (page,) = written(tmp_path, [made])
    assert "Input contract broken: driving trajectory, 1 cycle" in page.text
    assert "objects.age[0]" in page.text


def test_large_run_is_a_page_of_less_than_two_megabytes(tmp_path: Path) -> None:
    base = record(tmp_path, overtaking(count=2))
    made = large(base, 1000, 30, lambda rule, i: 5.0 + rule - ((i * (rule + 1)) % 500) / 40)
    index, _ = written(tmp_path, [made])
    assert (tmp_path / "out" / "runs" / "large.html").stat().st_size < 2_000_000
    assert "large" in index.text


def test_flickering_run_is_summed_up(tmp_path: Path) -> None:
    base = record(tmp_path, overtaking(count=2))
    made = large(base, 400, 3, lambda rule, i: -1.0 if i % 2 else 1.0)
    _, (page,) = written(tmp_path, [made])
    assert "194 more stretches inside this interval" in page.text


@pytest.mark.parametrize(("limits", "said"), [(4, "3 more moments in which"), (7, "3 of 6 more moments in which")])  # fmt: skip
def test_moments_that_are_not_shown_are_counted(tmp_path: Path, limits: int, said: str) -> None:
    """Each limit is passed in a cycle of its own; four are drawn from near."""
    base = record(tmp_path, overtaking(count=2))
    made = large(base, 40, limits, lambda rule, i: 2.5 + 3 * rule - i)
    _, (page,) = written(tmp_path, [made])
    assert page.text.count(" s, from near: ") == 4
    assert said in page.text


def test_what_is_summed_up_says_that_some_of_it_is_undefined(tmp_path: Path) -> None:
    """It had the verdict of the stretch with the least margin, and an undefined one has none."""
    made = large(record(tmp_path, overtaking(count=2)), 40, 1, lambda rule, i: -1.0 if i % 2 else 1.0)
    firing = made["rules"][0]["candidates"]["driving"]["firings"][10]
    firing |= {
        "verdicts": ["undefined"],
        "worst": {**firing["worst"], "margin": "nan", "verdict": "undefined"},
    }
    row = next(one for one in firing_rows(read_run(made)) if one["more"] and "driving" in one["candidate"])
    assert row["verdicts"] == "violated and undefined"


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("format", "else", "format"),
        ("version", 99, "version is 99"),
        ("t", [0.0], "entries for 1 cycles"),
        ("decision", ["drive"], "decision has 1 entries"),
        ("decision", ["jump", "drive"], "unknown decisions"),
        ("ego", None, "AttributeError"),
        ("rules", [{}], "KeyError"),
    ],
)
def test_what_is_no_record_is_refused(tmp_path: Path, field: str, value: Any, said: str) -> None:
    made = record(tmp_path, overtaking(count=2))
    made[field] = value
    with pytest.raises(TrackmarshalError) as caught:
        write_report(tmp_path / "out", [made], None, {}, [], {}, {})
    assert caught.value.code == "T291"
    assert said in caught.value.message
    assert caught.value.code in CODES
    assert not (tmp_path / "out").exists()


def test_unknown_verdict_letter_is_refused(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking(count=2))
    made["rules"][0]["candidates"]["driving"]["verdict"] = "sx"
    with pytest.raises(TrackmarshalError, match="unknown verdicts"):
        write_report(tmp_path / "out", [made], None, {}, [], {}, {})


def test_folder_that_cannot_be_written_is_an_error_with_its_path(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file", encoding="utf-8")
    with pytest.raises(TrackmarshalError) as caught:
        write_report(tmp_path / "out", [], None, {}, [], {}, {})
    assert caught.value.code == "T292"
    assert "out" in str(caught.value.file)
    assert caught.value.code in CODES


def test_equal_input_makes_equal_pages(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking())
    pages = []
    for name in ("a", "b"):
        write_report(tmp_path / name, [made], "matrix.html", SUMMARY, MISSING, CHECKS, META)
        pages.append(
            {p.relative_to(tmp_path / name): p.read_bytes() for p in (tmp_path / name).rglob("*.html")}
        )
    assert pages[0] == pages[1]


def test_stage_that_counts_more_than_it_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="S-9"):
        write_report(tmp_path / "out", [], None, {"coverage": {"S-9": {"covered": 3, "of": 2}}}, [], {}, {})


def test_surrogates_in_paths_do_not_stop_the_report(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking(count=2))
    made["source"] = "odd\udcff.saa"
    written(tmp_path, [made])


def test_injected_faults_are_a_table(tmp_path: Path) -> None:
    cases = [
        FaultCase("f.yaml", "F-1", "no <objects>", "S-1-A-1", 3, "a"),
        FaultCase("f.yaml", "F-2", "too fast", "RR-1", 9, "b"),
        FaultCase("f.yaml", "F-3", "nothing", "RR-4", 12, "c"),
        FaultCase("f.yaml", "F-4", "bits flip", "S-1-B-4", 15, "", "no computer yet"),
        FaultCase("f.yaml", "F-5", "out of date", "RR-1", 18, "e"),
    ]
    results = [
        FaultResult("f.yaml", "F-1", "passed", "a", ("missing", "late"), "D211", 2.0, 2.2, "previous_emergency", 1.9, "apart", 2.1),
        FaultResult("f.yaml", "F-2", "failed", "b", ("friction",), "", 2.0, 2.0, "no_safe_trajectory", None, "none_stored", 2.0,
                    "found by friction, expected speed_limit"),
        FaultResult("f.yaml", "F-3", "passed", "c", driven="drive"),
        FaultResult("f.yaml", "F-5", "passed", "old", ("speed_limit",), "", 2.0, 2.2, "previous_emergency", 1.9),
    ]  # fmt: skip
    rows = trace.fault_rows(cases, results)
    index = write_report(tmp_path, [], None, SUMMARY, [], CHECKS, META, faults=rows)
    checked(index)
    page = index.read_text("utf-8")
    table = page[page.index("Injected faults") : page.index("Checks and tests")].replace(
        "\N{NO-BREAK SPACE}", " "
    )
    assert "2 of 3 faults were found as expected; 1 with stale results; 1 not put in." in table
    shown = [re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", row)).strip() for row in table.split("<tr>")[2:]]
    assert [row.removesuffix(" Checks and tests") for row in shown] == [
        "F-1 no &lt;objects&gt; S-1-A-1 missing (D211) and late 2 s emergency trajectory of 1.9 s; nothing from 2.1 s (apart) ✓ yes",
        "F-2 too fast found by friction, expected speed_limit RR-1 friction 2 s nothing (none_stored) ✕ no",
        "F-3 nothing RR-4 nothing – planned trajectory ✓ yes",
        "F-4 bits flip not put in: no computer yet S-1-B-4 – – – not put in",
        "F-5 out of date the specs, the recording or the fault have changed since RR-1 – – – stale",
    ]


def test_faults_in_recordings_of_the_clock_of_unix_are_told_apart() -> None:
    """Six digits made one time of all of them, 1.7e+09 s."""
    at = 1700000012.25
    case = FaultCase("f.yaml", "F-1", "late", "RR-1", 3, "a")
    result = FaultResult("f.yaml", "F-1", "passed", "a", ("late",), "", at, at, "previous_emergency", at - 0.25, "apart", at + 0.25)  # fmt: skip
    (row,) = trace.fault_rows([case], [result])
    assert row["cycle"] == "1700000012.25 s"
    assert row["driven"] == "emergency trajectory of 1700000012 s; nothing from 1700000012.5 s (apart)"
    fired = RuleFacts("quick", "f", {"driving": {"violated": 1}}, at)
    run = RunSummary("a.jsonl", "h", "s", 3, (fired,), {}, True, "now", unexpected=(at,))
    assert _fired(run) == "fired: `quick` at 1700000012.25 s"
    assert _unexpected(run).startswith("unsafe at 1700000012.25 s, ")


def test_without_faults_there_is_no_table(tmp_path: Path) -> None:
    index = write_report(tmp_path, [], None, SUMMARY, [], CHECKS, META)
    assert "Injected faults" not in index.read_text("utf-8")
