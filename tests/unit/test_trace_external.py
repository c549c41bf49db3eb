"""Tests of other runners, and markers in source code, as cells of the matrix."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from golden.trace.cases import Small
from trackmarshal import trace
from trackmarshal.records.results_file import ResultsFile, save
from trackmarshal.records.tests import ExternalTest
from trackmarshal.trace import outside, requirements
from trackmarshal.trace.baseline.content import reported
from trackmarshal.trace.cells import Cell

STAGE = '  - {id: S-3-B, title: verification, shows: its tests, applies_to: ["*"], counts: [test, run]}\n'
COUNTING = STAGE.replace("[test, run]", "[test, run, external test]")
PASSED = '<testcase classname="tests.test_a" name="{}"><properties><property name="verifies" value="{}"/></properties></testcase>'


def project(folder: Path, entry: str, stage: str = COUNTING) -> Small:
    small = Small.copy(folder)
    small.replace("requirements/v-model.yaml", "stages:\n", f"  {entry}\nstages:\n")
    small.replace("requirements/v-model.yaml", STAGE, stage)
    return small


def report(small: Small, *tests: str, path: str = "out/results.xml") -> Small:
    (small.root / path).parent.mkdir(parents=True, exist_ok=True)
    (small.root / path).write_text(f"<testsuite name='unit'>{''.join(tests)}</testsuite>", "utf-8")
    return small


def cell(small: Small, requirement: str, stage: str = "S-3-B") -> Cell:
    row = next(row for row in small.matrix().rows if row.requirement.id == requirement)
    return row.cells[stage]


def test_what_passed_covers_the_requirement_that_it_names(tmp_path: Path) -> None:
    small = report(
        project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]"), PASSED.format("door", "S-1-B-1")
    )
    found = cell(small, "S-1-B-1")
    assert found.status == "covered"
    assert [(item.kind, item.name, item.title, str(item.place)) for item in found.items] == [
        ("external test", "door", "tests.test_a", "out/results.xml:1")
    ]


def test_a_folder_of_reports_may_hold_records_too(tmp_path: Path) -> None:
    """As several jobs write them; what else runners leave there is none."""
    small = project(tmp_path, "junit: [{path: out, stage: S-3-B}]")
    small = report(small, PASSED.format("door", "S-1-B-1"), path="out/one/door.xml")
    (small.root / "out" / "coverage.json").write_text('{"totals": {}}', "utf-8")
    assert cell(small, "S-1-B-1").status == "covered"
    test = ExternalTest("tests/test_a.py", "test_lock", ("S-1-B-1",), "failed")
    save(small.root / "out" / "two.json", ResultsFile("external_tests", (test,), "0", "2026-01-01"))
    assert cell(small, "S-1-B-1").status == "failed"
    whole = (small.root / "out" / "two.json").read_text("utf-8")
    other = json.dumps(dict(reversed(json.loads(whole).items())))  # as a formatter leaves it
    (small.root / "out" / "two.json").write_text(other, "utf-8")
    assert cell(small, "S-1-B-1").status == "failed"
    (small.root / "out" / "two.json").write_text(whole[:-20], "utf-8")
    (broken,) = (f for f in small.matrix().findings if f.code == "T290")
    assert broken.place is not None
    assert (broken.place.file, "run its tests again" in broken.help) == ("out/two.json", True)


@pytest.mark.parametrize("path", ["out", "./out", "out//one", "./out/one/door.xml", "."])
def test_a_report_answers_a_method_however_its_path_is_written(path: str, tmp_path: Path) -> None:
    """T255 said that it was not run, and asked for nothing else while it may be missing."""
    entry = f"junit: [{{path: {path}, stage: S-3-B, if_there: true, methods: [measurement]}}]"
    small = report(project(tmp_path, entry), PASSED.format("door", "S-1-B-1"), path="out/one/door.xml")
    small.replace(
        "requirements/criteria.yaml", "verification: [review]", "verification: [review, measurement]"
    )
    assert [f.subject for f in small.matrix().findings if f.code in ("T122", "T255", "T330")] == []
    read = requirements.load(small.root, [])
    (held,) = reported(read, outside.load(small.root, read, (), [])).values()
    assert held == {"tests.test_a: door"}


@pytest.mark.parametrize("path", ["out/two", "out/o", "out/one/door", "two.xml"])
def test_a_report_answers_no_method_by_tests_of_another_one(path: str, tmp_path: Path) -> None:
    """Also where the one is called as the other begins."""
    entry = (
        f"junit: [{{path: out/one, stage: S-3-B}}, {{path: {path}, stage: S-3-B, methods: [measurement]}}]"
    )
    small = report(project(tmp_path, entry), PASSED.format("door", "S-1-B-1"), path="out/one/door.xml")
    report(small, PASSED.format("lock", "RR-1"), path=path if path.endswith(".xml") else f"{path}/lock.xml")
    small.replace(
        "requirements/criteria.yaml", "verification: [review]", "verification: [review, measurement]"
    )
    assert [(f.subject, f.level) for f in small.matrix().findings if f.code == "T255"] == [
        ("S-1-B-1:measurement", "error")
    ]


def test_what_runners_leave_beside_reports_is_passed_over(tmp_path: Path) -> None:
    """As Maven does with TestNG, and whoever measures coverage; a report that is named itself has to be one."""
    small = project(tmp_path, "junit: [{path: out, stage: S-3-B}]")
    small = report(small, PASSED.format("door", "S-1-B-1"), path="out/TEST-door.xml")
    beside = {
        "testng-results.xml": '<testng-results total="1" passed="1"/>',
        "testng-failed.xml": '<!DOCTYPE suite SYSTEM "https://testng.org/testng-1.0.dtd"><suite name="Failed"/>',
        "coverage.xml": '<?xml version="1.0" ?><coverage line-rate="1"/>',
    }
    for name, text in beside.items():
        (small.root / "out" / name).write_text(text, "utf-8")
    assert [f.code for f in small.matrix().findings if f.code in ("T330", "T332", "T333")] == []
    assert cell(small, "S-1-B-1").status == "covered"
    for other in ("<html/>", "<suite/>"):  # as a proxy answers, as somebody else writes
        (small.root / "out" / "other.xml").write_text(other, "utf-8")
        assert "T333" in [f.code for f in small.matrix().findings]
    (small.root / "out" / "other.xml").unlink()
    (small.root / "out" / "TEST-door.xml").unlink()
    assert "T330" in [f.code for f in small.matrix().findings]
    small.replace("requirements/v-model.yaml", "path: out,", "path: out/coverage.xml,")
    assert "T333" in [f.code for f in small.matrix().findings]


SUMMARY = """<?xml version="1.0" encoding="UTF-8"?>
<failsafe-summary xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" result="{}" timeout="{}">
  <completed>1</completed><errors>0</errors><failures>0</failures><skipped>0</skipped>{}
</failsafe-summary>
"""


@pytest.mark.parametrize(
    ("result", "timeout", "said", "told"),
    [
        ("null", "false", '<failureMessage xsi:nil="true"/>', []),
        ("254", "false", "<failureMessage></failureMessage>", []),
        ("254", "false", "<failureMessage>The forked VM ended.</failureMessage>", ["T335"]),
        ("null", "false", "<failureMessage>The forked VM ended.</failureMessage>", ["T335"]),
        ("255", "false", '<failureMessage xsi:nil="true"/>', ["T335"]),
        ("null", "true", '<failureMessage xsi:nil="true"/>', ["T335"]),
    ],
)
def test_what_failsafe_says_of_the_run_as_a_whole(
    result: str, timeout: str, said: str, told: list[str], tmp_path: Path
) -> None:
    """Beside the reports of each class. Of a run in which nothing broke, as there was no test in one of several modules, that is no error; that one broke off,
    no report tells."""
    small = project(tmp_path, "junit: [{path: target/failsafe-reports, stage: S-3-B}]")
    small = report(small, PASSED.format("door", "S-1-B-1"), path="target/failsafe-reports/TEST-DoorIT.xml")
    summary = small.root / "target" / "failsafe-reports" / "failsafe-summary.xml"
    summary.write_text(SUMMARY.format(result, timeout, said), "utf-8")
    assert [f.code for f in small.matrix().findings if "T330" <= f.code <= "T335"] == told
    assert cell(small, "S-1-B-1").status == "covered"


@pytest.mark.parametrize(
    ("names", "number"),
    [
        (("test_it[1]", "test_it[2]", "test_it[a[b]", "TestDoor::test_it[]]"), 2),
        (("opens(int, Door)[1]", "opens(int, Door)[2]"), 1),
        (("[R-1] stops [wet]", "[R-1] holds [dry]", "[R-1] begins"), 3),
        (("stops [wet [or icy]]", "stops [dry]", "stops]"), 2),
        (("[R-1]", "[R-2]"), 2),
    ],
)
def test_what_is_held_of_names_is_all_but_parameters(
    names: tuple[str, ...], number: int, tmp_path: Path
) -> None:
    small = report(
        project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]"),
        *(PASSED.format(name, "S-1-B-1") for name in names),
    )
    read = requirements.load(small.root, [])
    (held,) = reported(read, outside.load(small.root, read, (), [])).values()
    assert len(held) == number


def test_another_stage_knows_nothing_of_it(tmp_path: Path) -> None:
    small = report(
        project(tmp_path, "junit: [{path: out/results.xml, stage: S-2-A}]"), PASSED.format("door", "S-1-B-1")
    )
    assert cell(small, "S-1-B-1").status == "waived"


def test_what_passed_with_another_version_of_its_file_is_stale(tmp_path: Path) -> None:
    """Results of another checkout, or of a test that was weakened or broken since, show nothing of what is here."""
    small = project(tmp_path, "junit: [{path: out/pytest.json, stage: S-3-B}]")
    file = small.root / "tests" / "test_door.py"
    file.parent.mkdir()
    file.write_text("def test_door(): ...\n", "utf-8")
    held = hashlib.sha256(file.read_bytes()).hexdigest()
    test = ExternalTest(
        "tests/test_door.py",
        "test_door",
        ("S-1-B-1",),
        "passed",
        file="tests/test_door.py",
        line=1,
        file_hash=held,
    )
    save(small.root / "out" / "pytest.json", ResultsFile("external_tests", (test,), "0", "2026-01-01"))
    assert cell(small, "S-1-B-1").status == "covered"
    file.write_bytes(b"def test_door(): ...\r\n")  # as another system checks it out
    assert cell(small, "S-1-B-1").status == "covered"
    file.write_text("def test_door(): pass\n", "utf-8")
    found = cell(small, "S-1-B-1")
    assert (found.status, found.items[-1].detail) == ("stale", "its file has changed since it ran")
    said = [f for f in small.matrix().findings if f.code == "T216"]
    assert [(f.level, f.subject, str(f.place)) for f in said] == [
        ("warning", "test_door", "tests/test_door.py:1")
    ]
    file.unlink()
    assert cell(small, "S-1-B-1").items[-1].detail == "`tests/test_door.py` is not there"
    assert cell(small, "S-1-B-1").status == "stale"


def test_what_a_class_sets_for_tests_that_it_inherits_counts_too(tmp_path: Path) -> None:
    """The test stands in one file, and what it is held against in another one."""
    small = project(tmp_path, "junit: [{path: out/pytest.json, stage: S-3-B}]")
    (small.root / "tests").mkdir()
    files = {name: small.root / "tests" / name for name in ("checks.py", "test_door.py")}
    for file in files.values():
        file.write_text("limit = 12\n", "utf-8")
    held = hashlib.sha256(b"limit = 12\n").hexdigest()
    test = ExternalTest(
        "tests/test_door.py",
        "TestDoor::test_limit",
        ("S-1-B-1",),
        "passed",
        file="tests/checks.py",
        file_hash=held,
        collected="tests/test_door.py",
        collected_hash=held,
    )
    save(small.root / "out" / "pytest.json", ResultsFile("external_tests", (test,), "0", "2026-01-01"))
    assert cell(small, "S-1-B-1").status == "covered"
    for file in files.values():
        file.write_text("limit = 13\n", "utf-8")
        assert cell(small, "S-1-B-1").status == "stale"
        file.write_text("limit = 12\n", "utf-8")
    assert cell(small, "S-1-B-1").status == "covered"


def test_each_of_several_counts(tmp_path: Path) -> None:
    small = project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]")
    bad = PASSED.format("late", "S-1-B-1").replace("</testcase>", "<failure/></testcase>")
    assert cell(report(small, PASSED.format("door", "S-1-B-1"), bad), "S-1-B-1").status == "failed"
    skipped = bad.replace("failure", "skipped")
    one = cell(report(small, PASSED.format("door", "S-1-B-1"), skipped), "S-1-B-1")
    assert [item.status for item in one.items if item.kind == "external test"] == ["covered", "missing"]
    assert one.status == "waived"  # partial, for which somebody answers


@pytest.mark.parametrize("order", [("a", "b"), ("b", "a")])
def test_of_one_test_in_two_reports_the_worse_outcome_is_told(order: tuple[str, str], tmp_path: Path) -> None:
    """`trace --to "external test"` and the safety case said that it passed, and the cell that it failed."""
    small = project(tmp_path, "junit: [{path: out/reports, stage: S-3-B}]")
    passed = PASSED.format("door", "S-1-B-1")
    failed = passed.replace("</testcase>", "<failure message='stuck'/></testcase>")
    for name, test in zip(order, (passed, failed), strict=True):
        report(small, test, path=f"out/reports/{name}.xml")
    assert cell(small, "S-1-B-1").status == "failed"
    (node,) = small.matrix().graph.by_kind["external test"]
    assert (node.attributes["outcome"], node.title) == ("failed", "stuck")


def test_what_fails_below_shows_above(tmp_path: Path) -> None:
    small = project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]")
    bad = PASSED.format("grip", "RR-2").replace("</testcase>", "<error/></testcase>")
    assert cell(report(small, bad), "S-1-A-5").status == "failed"


def test_ids_in_names_of_tests(tmp_path: Path) -> None:
    entry = "junit: [{path: out, stage: S-3-B, names: '(?:^|_)(S_1_[AB]_[0-9]+)(?![0-9])'}]"
    small = report(
        project(tmp_path, entry), '<testcase name="test_S_1_B_1_and_S_1_A_2"/>', path="out/deep/a.xml"
    )
    assert [item.name for item in cell(small, "S-1-B-1").items] == ["test_S_1_B_1_and_S_1_A_2"]
    assert "external test" in [item.kind for item in cell(small, "S-1-A-2").items]
    assert [finding for finding in small.matrix().findings if finding.code.startswith(("T33", "T34"))] == []


def test_the_place_of_a_test_is_its_own_where_the_project_has_the_file(tmp_path: Path) -> None:
    small = project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]")
    tests = [
        PASSED.format(name, "S-1-B-1").replace("<testcase", f'<testcase file="{file}" line="7"')
        for name, file in (
            ("a", "docs/seen.md"),
            ("b", small.root / "docs" / "seen.md"),
            ("c", "/etc/hostname"),
            ("d", "../x.py"),
        )
    ]
    places = [str(item.place) for item in cell(report(small, *tests), "S-1-B-1").items]
    assert places == ["docs/seen.md:7", "docs/seen.md:7", "out/results.xml:1", "out/results.xml:1"]


def test_records_of_the_plugin(tmp_path: Path) -> None:
    small = project(tmp_path, "junit: [{path: out/pytest.json, stage: S-3-B}]")
    item = {"suite": "tests/test_a.py", "name": "test_door", "requirements": ["S-1-B-1"], "outcome": "passed"}
    file = {
        "format": "trackmarshal-results", "version": 1, "tool_version": "0", "created": "2026-06-01T12:00:00+00:00",
        "holds": "external_tests", "items": [item],
    }  # fmt: skip
    (small.root / "out").mkdir()
    (small.root / "out" / "pytest.json").write_text(json.dumps(file), "utf-8")
    assert cell(small, "S-1-B-1").status == "covered"
    links = small.matrix().graph.links
    assert "confirms" in {link.kind for link in links if link.target == ("requirement", "S-1-B-1")}
    (small.root / "out" / "pytest.json").write_text("{}", "utf-8")
    assert [f.code for f in small.matrix().findings if f.code == "T290"] == ["T290"]


def test_hashes_and_times_are_kept(tmp_path: Path) -> None:
    from trackmarshal.trace import external

    small = report(
        project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B, tool: ctest}]"),
        PASSED.format("door", "S-1-B-1"),
    )
    (found,) = external.load(small.root, trace.load(small.root)[0], [])
    assert found.test.report_hash == hashlib.sha256((small.root / "out/results.xml").read_bytes()).hexdigest()
    assert found.test.tool == "ctest"


CODED = STAGE.replace("[test, run]", "[code]")


@pytest.mark.parametrize(
    ("file", "text", "place"),
    [
        ("a.py", "x = 1  # implements S-1-B-1\n", "engine/a.py:1:21"),
        ("a.py", "#: implements: S-1-B-1: the door\n", None),
        ("a.py", "# implements S-1-A-2, S-1-B-1: the door\n", "engine/a.py:1:14"),
        ("a.py", 'x = "# implements S-1-B-1"\n', None),
        ("a.py", '"""\n# implements S-1-B-1\n"""\n', None),
        ("a.py", "# it implements S-1-B-1\n", None),
        ("a.py", "# implements the door\n", None),
        ("a.py", "# implements S-1-B-1's half of the door\n", None),
        ("a.py", "# implements S-1-B-1.open\n", None),
        ("a.c", "/* It sums up,\n * implements Cooley-Tukey.\n * implements `Kahan-Babuska`: */\n", None),
        ("a.c", "int door(void); // implements S-1-B-1\n", "engine/a.c:1:31"),
        ("a.c", "/* A door.\n * implements S-1-B-1\n */\n", "engine/a.c:2:15"),
        ("a.c", '/* implements S-1-B-1 */ char *s = "/* implements S-1-A-2 */";\n', "engine/a.c:1:15"),
        ("a.c", 'char *s = "// implements S-1-B-1";\n', None),
        ("a.rs", "fn door<'a>(x: &'a str) {} // implements S-1-B-1\n", "engine/a.rs:1:42"),
        ("a.cpp", 'auto s = R"x(\n" // implements S-1-B-1\n)x";\n', None),
        ("a.cpp", 'auto s = R"(//)"; // implements S-1-B-1\n', "engine/a.cpp:1:33"),
        ("a.rs", 'let s = "\n// implements S-1-B-1\n";\n', None),
        ("a.rs", 'let s = r#"\n" // implements S-1-B-1\n"#;\n', None),
        ("a.go", "var s = `\n// implements S-1-B-1\n`\n", None),
        ("a.go", "var s = `\\` // implements S-1-B-1\n", "engine/a.go:1:27"),
        ("a.ts", "let s = `\n\\` // implements S-1-B-1\n`;\n", None),
        ("a.java", 'String s = """\n" // implements S-1-B-1\n""";\n', None),
        ("a.java", 'String s = ""; // implements S-1-B-1\n', "engine/a.java:1:30"),
        ("a.cs", 'var s = @"\\"; // implements S-1-B-1\n', "engine/a.cs:1:29"),
        ("a.cs", 'var s = @"\n// implements S-1-B-1\n";\n', None),
        ("a.yaml", "door: 1\n# implements S-1-B-1\n", "engine/a.yaml:2:14"),
        ("a.txt", "# implements S-1-B-1\n", None),
    ],
)
def test_markers_in_source_code(tmp_path: Path, file: str, text: str, place: str | None) -> None:
    small = project(tmp_path, "sources: [engine]", CODED)
    (small.root / "engine").mkdir()
    (small.root / "engine" / file).write_text(text, "utf-8")
    found = cell(small, "S-1-B-1")
    assert [str(item.place) for item in found.items if item.kind == "code"] == ([place] if place else [])
    assert found.status == ("covered" if place else "waived")
    assert [f.code for f in small.matrix().findings if f.code.startswith(("T33", "T34"))] == []


def test_the_matrix_with_all_of_it_fits_its_schema(tmp_path: Path) -> None:
    from jsonschema import Draft202012Validator

    entry = "junit: [{path: out/results.xml, stage: S-3-B}]\n  sources: [engine]"
    small = project(tmp_path, entry, COUNTING.replace("external test", "external test, code"))
    report(small, PASSED.format("door", "S-1-B-1"))
    (small.root / "engine").mkdir()
    (small.root / "engine" / "a.py").write_text("# implements S-1-B-1\n", "utf-8")
    matrix = small.matrix()
    made = json.loads(trace.render(matrix, "json"))
    folder = Path(trace.__file__).parent / "render"
    Draft202012Validator(json.loads((folder / "matrix.schema.json").read_text("utf-8"))).validate(made)
    kinds = {link["kind"] for link in made["links"] if link["target"] == "S-1-B-1"}
    assert kinds >= {"confirms", "implements"}
    assert (made["counts"]["external_tests"], made["counts"]["code_links"]) == (1, 1)
    assert "1 external test, 1 code link" in trace.render(matrix, "text")


def test_the_graph_leads_to_both(tmp_path: Path) -> None:
    from trackmarshal.trace.graph.paths import named, paths

    small = project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]\n  sources: [engine]")
    report(small, PASSED.format("door", "S-1-B-1"))
    (small.root / "engine").mkdir()
    (small.root / "engine" / "a.py").write_text("# implements S-1-B-1\n", "utf-8")
    graph = small.matrix().graph
    for kind, wanted in (
        ("external test", "tests.test_a: door"),
        ("external-test", "tests.test_a: door"),
        ("code", "engine/a.py"),
    ):
        (found,) = paths(graph, named(graph, "S-1-B-1"), named(graph, kind))
        assert wanted in str(found)


@pytest.mark.parametrize(
    ("names", "repeats"),
    [
        ("(a+)+$", True),
        ("(?:a|a)*b", True),
        ("(a?){40}b", True),
        ("(a+)(?#again)+", True),
        ("(?x)(a+) +", True),
        ("S_1_[AB]_[0-9]+", False),
        (r"\)+", False),
        ("[()]+", False),
        ("[^]()*]+", False),
        (r"[\])]+", False),
        ("(?:^|_)(S_[0-9]+)(?![0-9])", False),
        ("(S-[0-9]+)?", False),
    ],
)
def test_names_that_repeat_a_group_are_refused(names: str, repeats: bool, tmp_path: Path) -> None:
    """A long name that does not fit would be tried for ever."""
    made = project(tmp_path, f"junit: [{{path: out/results.xml, stage: S-3-B, names: '{names}'}}]")
    found = report(made, f'<testcase name="{"a" * 40}!"/>').matrix().findings
    said = [finding.message for finding in found if finding.code == "T340"]
    assert (
        said == [f"`{names}` repeats a group, so that one long name may be tried in endless ways"] * repeats
    )


def test_of_all_tests_of_what_is_not_demanded_one_finding_tells(tmp_path: Path) -> None:
    """A requirement that is struck, or whose file cannot be read, may be named by hundreds."""
    small = project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]")
    cases = "".join(PASSED.format(f"door_{number}", "S-9") for number in range(300))
    (found,) = (finding for finding in report(small, cases).matrix().findings if finding.code == "T336")
    assert (
        found.message
        == "the test `door_0` of `tests.test_a` and 299 more verify `S-9`, which is no requirement"
    )
    assert (found.subject, len(found.about)) == ("S-9", 301)


def test_who_answers_for_one_of_them_has_not_answered_for_the_others(tmp_path: Path) -> None:
    """A waiver's subject is the requirement where a test names one, and the test where it names several."""
    small = project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]")
    cases = PASSED.format("door", "S-8") + PASSED.format("gate", "S-8, S-9")
    found = [finding for finding in report(small, cases).matrix().findings if finding.code == "T336"]
    assert [finding.subject for finding in found] == ["S-8", "gate"]


def test_a_test_that_names_thousands_that_there_are_not_is_told_once(tmp_path: Path) -> None:
    """Of findings about one thing, each is held against each other one: the gate took minutes."""
    ids = ", ".join(["S-1-B-1", *(f"S-{n}" for n in range(1000, 5000))])
    small = report(
        project(tmp_path, "junit: [{path: out/results.xml, stage: S-3-B}]"), PASSED.format("door", ids)
    )
    (found,) = (finding for finding in small.matrix().findings if finding.code == "T336")
    said = "the test `door` of `tests.test_a` verifies `S-1000`, `S-1001`, `S-1002` and 3997 more, which are no requirements"
    assert found.message == said
