"""Reports of test runners as each of them writes them: what came of each test, and which requirements it names."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.growth import grows
from trackmarshal.errors import TrackmarshalError
from trackmarshal.junit import reading
from trackmarshal.junit.writing import Line, render
from trackmarshal.records.tests import ExternalTest

PYTEST = """<?xml version="1.0" encoding="utf-8"?><testsuites name="pytest tests"><testsuite name="pytest" errors="1" failures="1" skipped="1" tests="4" time="0.034" timestamp="2026-06-01T12:00:00.123456+00:00" hostname="here"><testcase classname="tests.test_a" name="test_good" time="0.001"><properties><property name="verifies" value="S-1-B-1" /><property name="verifies" value="S-1-B-4" /></properties></testcase><testcase classname="tests.test_a" name="test_bad" time="0.002"><failure message="assert 1 == 2">def test_bad():
&gt;       assert 1 == 2</failure></testcase><testcase classname="tests.test_a" name="test_left_out" time="0.000"><skipped type="pytest.skip" message="no compiler">tests/test_a.py:9: no compiler</skipped></testcase><testcase classname="tests.test_a" name="test_broken" time="0.000"><error message="failed on setup with &quot;OSError&quot;">...</error></testcase></testsuite></testsuites>"""
GTEST = """<?xml version="1.0" encoding="UTF-8"?>
<testsuites tests="3" failures="1" disabled="1" errors="0" time="0.01" timestamp="2026-06-01T12:00:00.123" name="AllTests">
  <testsuite name="Door" tests="3" failures="1" disabled="1" skipped="0" errors="0" time="0.01" timestamp="2026-06-01T12:00:00.124" verifies="S-1-B-4">
    <testcase name="Opens" file="/build/door.cc" line="7" status="run" result="completed" time="0." timestamp="2026-06-01T12:00:00.125" classname="Door">
      <properties>
        <property name="verifies" value="S-1-B-1, S-1-B-4"/>
      </properties>
    </testcase>
    <testcase name="Shuts" file="/build/door.cc" line="11" status="run" result="completed" time="0.001" classname="Door">
      <failure message="door.cc:12&#x0A;Expected equality" type=""><![CDATA[door.cc:12
Expected equality]]></failure>
      <failure message="door.cc:13" type=""><![CDATA[door.cc:13]]></failure>
    </testcase>
    <testcase name="DISABLED_Locks" status="notrun" result="suppressed" time="0." classname="Door" />
  </testsuite>
</testsuites>"""
CTEST = """<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="Linux-c++" tests="4" failures="1" disabled="1" skipped="1" hostname="" time="1" timestamp="2026-06-01T12:00:00">
  <testcase name="kernel" classname="kernel" time="0.5" status="run"><properties><property name="verifies" value="S-1-B-1"/></properties><system-out>ok &lt;failure/&gt;</system-out></testcase>
  <testcase name="door" classname="door" time="0.4" status="fail"><failure message="Exit code 1"/><system-out/></testcase>
  <testcase name="later" classname="later" time="0" status="disabled"/>
  <testcase name="board" classname="board" time="0" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/></testcase>
</testsuite>"""
JEST = """<?xml version="1.0" encoding="UTF-8"?>
<testsuites name="jest tests" tests="2" failures="0" errors="0" time="1.2">
  <testsuite name="door" errors="0" failures="0" skipped="1" timestamp="2026-06-01T12:00:00" time="0.9" tests="2">
    <testcase classname="door opens S-1-B-1" name="door opens S-1-B-1" time="0.002">
    </testcase>
    <testcase classname="door shuts" name="door shuts" time="0"><skipped/></testcase>
  </testsuite>
</testsuites>"""
SUREFIRE = """<?xml version="1.0" encoding="UTF-8"?>
<testsuite xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://maven.apache.org/surefire/maven-surefire-plugin/xsd/surefire-test-report-3.0.xsd" version="3.0" name="org.door.DoorTest" time="1,234.5" tests="3" errors="1" skipped="0" failures="0">
  <properties><property name="java.version" value="21"/></properties>
  <testcase name="opens" classname="org.door.DoorTest" time="1,234.4"/>
  <testcase name="shuts" classname="org.door.DoorTest" time="0.1"><error message="boom" type="java.lang.IllegalStateException"><![CDATA[java.lang.IllegalStateException: boom]]></error><system-err>x</system-err><rerunError message="boom" type="x"><stackTrace>at</stackTrace><system-out>y</system-out></rerunError></testcase>
  <testcase name="locks" classname="org.door.DoorTest" time="0"><flakyFailure message="late" type="x"><stackTrace>at</stackTrace></flakyFailure></testcase>
</testsuite>"""
NODE = """<?xml version="1.0" encoding="utf-8"?>
<testsuites>
	<testcase name="opens" time="0.001" classname="test"/>
	<testsuite name="inner" time="0.001" disabled="0" errors="0" tests="1" failures="1" skipped="0" hostname="h">
		<testcase name="shuts" time="0.001" classname="test" failure="no"><failure type="testCodeFailure" message="no">trace</failure></testcase>
	</testsuite>
	<!-- tests 2 -->
</testsuites>"""


def read(tmp_path: Path, text: str | bytes, tool: str = "") -> tuple[ExternalTest, ...]:
    path = tmp_path / "results.xml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return reading.read(path, "out/results.xml", tool)


@pytest.mark.parametrize(
    ("report", "outcomes"),
    [
        (PYTEST, ["passed", "failed", "skipped", "error"]),
        (GTEST, ["passed", "failed", "skipped"]),
        (CTEST, ["passed", "failed", "skipped", "skipped"]),
        (JEST, ["passed", "skipped"]),
        (SUREFIRE, ["passed", "error", "failed"]),
        (NODE, ["passed", "failed"]),
    ],
    ids=["pytest", "gtest", "ctest", "jest", "surefire", "node"],
)
def test_what_came_of_each(tmp_path: Path, report: str, outcomes: list[str]) -> None:
    assert [test.outcome for test in read(tmp_path, report)] == outcomes


def test_all_that_is_known_of_a_test(tmp_path: Path) -> None:
    first = read(tmp_path, PYTEST, "pytest 9")[0]
    assert first == ExternalTest(
        "tests.test_a", "test_good", ("S-1-B-1", "S-1-B-4"), "passed", "", "", 0, 0.001, "pytest 9",
        "2026-06-01T12:00:00.123456+00:00", "out/results.xml", 1, hashlib.sha256(PYTEST.encode()).hexdigest(),
    )  # fmt: skip
    opens, shuts, locks = read(tmp_path, GTEST)
    assert (opens.file, opens.line, opens.created) == ("/build/door.cc", 7, "2026-06-01T12:00:00.125")
    assert opens.requirements == ("S-1-B-1", "S-1-B-4")
    assert shuts.requirements == locks.requirements == ("S-1-B-4",)  # of the suite
    assert shuts.message == "door.cc:12\nExpected equality"
    assert read(tmp_path, CTEST)[3].message == "SKIP_RETURN_CODE=77"
    assert [test.duration for test in read(tmp_path, SUREFIRE)] == [1234.4, 0.1, 0.0]
    assert read(tmp_path, SUREFIRE)[2].message == "passed only when it was repeated: late"


def test_properties_of_a_suite_hold_for_all_in_it_wherever_they_stand(tmp_path: Path) -> None:
    report = """<testsuites><properties><property name="verifies">RR-1</property></properties>
    <testsuite name="a"><testcase name="x"/><testsuite name="b"><testcase name="y"/>
    <properties><property name="verifies" value="RR-2"/><property name="other" value="RR-3"/></properties></testsuite></testsuite>
    <testsuite name="c"><testcase name="z"/></testsuite></testsuites>"""
    found = {test.name: (test.suite, test.requirements) for test in read(tmp_path, report)}
    assert found == {"x": ("a", ("RR-1",)), "y": ("b", ("RR-2", "RR-1")), "z": ("c", ("RR-1",))}


@pytest.mark.parametrize(
    ("inner", "outcome"),
    [
        ('<testcase name="x" status="fine"/>', "error"),
        ('<testcase name="x" result="Failed"/>', "failed"),
        ('<testcase name="x"><inconclusive/></testcase>', "error"),
        ('<testcase name="x"><skipped/><failure/></testcase>', "failed"),
        ('<testcase name="x"><failure/><error/></testcase>', "error"),
        ('<testcase name="x"><testcase name="y"/></testcase>', "error"),
        ('<error message="no fixture"/>', "error"),
        ('<testcase name="x"><system-out><failure/></system-out></testcase>', "passed"),
    ],
)
def test_what_is_not_known_is_no_pass(tmp_path: Path, inner: str, outcome: str) -> None:
    (test,) = read(tmp_path, f'<testsuite name="s">{inner}</testsuite>')
    assert test.outcome == outcome


@pytest.mark.parametrize(
    ("counts", "refused"),
    [
        ('tests="2"', False), ('tests="3"', True), ('failures="1" errors="0"', False), ('failures="1" errors="1"', True),
        ('failures="2"', True), ("", False), ('tests=""', False), ('tests="1"', False),
    ],
)  # fmt: skip
def test_a_suite_that_lacks_what_it_counts(tmp_path: Path, counts: str, refused: bool) -> None:
    report = f'<testsuites {counts}><testsuite><testcase name="x"/><testcase name="y"><failure/></testcase></testsuite></testsuites>'
    if not refused:
        assert len(read(tmp_path, report)) == 2
        return
    with pytest.raises(TrackmarshalError) as caught:
        read(tmp_path, report)
    assert caught.value.code == "T335"


@pytest.mark.parametrize(
    ("counts", "refused"),
    [
        ('skipped="2"', False), ('skipped="3"', True), ('skipped="2" disabled="2"', False), ('disabled="3"', True), ('skipped="0"', False),
    ],
)  # fmt: skip
def test_a_test_that_was_skipped_is_not_listed_as_if_it_had_run(
    tmp_path: Path, counts: str, refused: bool
) -> None:
    """Also one that was skipped and broke afterwards counts as skipped, and one that says so by its status."""
    broke = '<testcase name="y"><skipped/><error/></testcase>'
    report = (
        f'<testsuite {counts}><testcase name="x"/>{broke}<testcase name="z" status="notrun"/></testsuite>'
    )
    if not refused:
        assert [test.outcome for test in read(tmp_path, report)] == ["passed", "error", "skipped"]
        return
    with pytest.raises(TrackmarshalError) as caught:
        read(tmp_path, report)
    assert caught.value.code == "T335"


@pytest.mark.parametrize("count", ["skip", "skips", "ignored", "pending", "notrun", "not_run", "suppressed", "inconclusive", "todo"])  # fmt: skip
def test_tests_that_were_left_out_in_the_words_of_other_runners(tmp_path: Path, count: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        read(tmp_path, f'<testsuite tests="1" {count}="1"><testcase name="x"/></testsuite>')
    assert caught.value.code == "T335"
    left_out = '<testcase name="x"><skipped/></testcase>'
    (test,) = read(tmp_path, f'<testsuite tests="1" {count}="1">{left_out}</testsuite>')
    assert test.outcome == "skipped"


@pytest.mark.parametrize(
    ("said", "outcome"),
    [
        ('skipped="true"', "skipped"), ('ignored="True"', "skipped"), ('disabled="1"', "skipped"), ('executed="False"', "skipped"), ('success="false"', "failed"),
        ('passed="no"', "failed"), ('failed="true"', "failed"), ('skipped="perhaps"', "error"), ('skipped="false" executed="True" success="True"', "passed"),
        ('outcome="failed"', "failed"), ('verdict="FAIL"', "failed"), ('conclusion="success"', "passed"), ('outcome="timed out"', "error"), ('aborted="true"', "failed"),
        ('timedout="1"', "failed"), ('status="Inconclusive"', "skipped"),
    ],
)  # fmt: skip
def test_what_an_attribute_says_of_a_test(tmp_path: Path, said: str, outcome: str) -> None:
    (test,) = read(tmp_path, f'<testsuite><testcase name="x" {said}/></testsuite>')
    assert test.outcome == outcome


@pytest.mark.parametrize(
    ("says", "refused"),
    [
        ('result="failed"', True), ('status="aborted"', True), ('outcome="Failure"', True), ('success="false"', True), ('verdict="skipped"', True),
        ('aborted="true"', True), ('timeouts="1"', True), ('failed="1"', True), ('error="1"', True), ('errors="1"', True), ('flakes="1"', True),
        ('result="passed" status="run" aborted="false" timeouts="0" failed="0" success="1" passed="1"', False), ('passed="0"', False),
    ],
)  # fmt: skip
def test_what_a_suite_alone_says_of_its_tests(tmp_path: Path, says: str, refused: bool) -> None:
    """A run that broke off, or failed as a whole, is no evidence; where a test of it says so too, that one has failed."""
    ran, broke = '<testcase name="x"/>', '<testcase name="y"><failure/></testcase>'
    for outer in ("<testsuite {}>{}</testsuite>", "<testsuites {}><testsuite>{}</testsuite></testsuites>"):
        if refused:
            with pytest.raises(TrackmarshalError, match="suite") as caught:
                read(tmp_path, outer.format(says, ran))
            assert caught.value.code == "T335"
        else:
            assert [test.outcome for test in read(tmp_path, outer.format(says, ran))] == ["passed"]
        if "skipped" not in says:
            assert [test.outcome for test in read(tmp_path, outer.format(says, ran + broke))] == [
                "passed",
                "failed",
            ]


@pytest.mark.parametrize("succeeded", ["true", "false"])
def test_ginkgo_says_of_a_suite_that_it_ran_out_of_time(tmp_path: Path, succeeded: str) -> None:
    inner = f'<properties><property name="SuiteSucceeded" value="{succeeded}"/></properties><testcase name="x" status="passed"/>'
    report = f'<testsuites tests="1" errors="0" failures="0"><testsuite name="Door" tests="1">{inner}</testsuite></testsuites>'
    if succeeded == "true":
        assert [test.outcome for test in read(tmp_path, report)] == ["passed"]
        return
    with pytest.raises(TrackmarshalError, match="SuiteSucceeded"):
        read(tmp_path, report)


def test_entities_are_refused_before_they_grow(tmp_path: Path) -> None:
    lines = [f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, 30)]
    report = f'<!DOCTYPE t [<!ENTITY e0 "x">{"".join(lines)}]><testsuite name="&e29;"/>'
    outer = '<!DOCTYPE t SYSTEM "file:///etc/hostname"><testsuite/>'
    for text in (report, outer, "<!DOCTYPE testsuite><testsuite/>"):
        with pytest.raises(TrackmarshalError) as caught:
            read(tmp_path, text)
        assert caught.value.code == "T332"


def test_depth_on_both_sides_of_its_limit(tmp_path: Path) -> None:
    def nested(depth: int) -> str:
        return "<testsuite>" * depth + "</testsuite>" * depth

    assert read(tmp_path, nested(reading.MAX_DEPTH)) == ()
    with pytest.raises(TrackmarshalError) as caught:
        read(tmp_path, nested(reading.MAX_DEPTH + 1))
    assert caught.value.code == "T334"


def test_a_large_report(tmp_path: Path) -> None:
    """Hundreds of thousands of tests with pages of output are read in one pass, and keep nothing of the output."""
    one = '<testcase classname="c" name="n" time="0.1"><failure>' + "x" * 3_000 + "</failure></testcase>"
    found = read(tmp_path, "<testsuite>" + one * 10_000 + "</testsuite>")
    assert len(found) == 10_000
    assert {len(test.message) for test in found} == {1_000}


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf8", "UTF8", "utf_8", "utf-16", "iso-8859-1", "windows-1252"]
)
def test_encodings(tmp_path: Path, encoding: str) -> None:
    """UTF-8 also by the names that Python has of it: with letters beyond ASCII, the report was said to be no XML."""
    text = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}"?><testsuite><testcase name="Größe"/></testsuite>'
    assert read(tmp_path, text.encode(encoding))[0].name == "Größe"


def test_an_encoding_that_is_not_read_is_said_to_be_none(tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        read(
            tmp_path,
            '<?xml version="1.0" encoding="gbk"?><testsuite><testcase name="漢"/></testsuite>'.encode("gbk"),
        )
    assert (caught.value.code, (caught.value.help or "")[:37]) == (
        "T331",
        "have the test runner write UTF-8; its",
    )


@pytest.mark.parametrize(
    "data", [b"", b"\xff\xfe", b"<testsuite>", b'<?xml version="1.0" encoding="x-none"?><a/>', b"\0" * 9]
)
def test_what_is_no_xml(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        read(tmp_path, data)
    assert caught.value.code == "T331"


@given(st.binary(max_size=200) | st.text(st.sampled_from('<>/="& tesuicafl'), max_size=80).map(str.encode))
def test_any_bytes_are_read_or_refused(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    folder = tmp_path_factory.getbasetemp()
    for whole in (data, b"<testsuite><testcase>" + data + b"</testcase></testsuite>"):
        try:
            read(folder, whole)
        except TrackmarshalError as error:
            assert error.code in ("T331", "T332", "T333", "T334", "T335")


WORDS = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=20)
IDS = st.lists(st.sampled_from(["S-1-B-1", "RR-2", "CR-3"]), unique=True).map(tuple)
LINES = st.builds(
    Line,
    WORDS,
    WORDS,
    WORDS,
    st.sampled_from(["passed", "failed", "error", "skipped"]),
    WORDS,
    WORDS,
    WORDS,
    st.integers(0, 9),
    IDS,
)


@given(st.lists(LINES, max_size=6))
def test_what_we_write_is_read_as_it_was(tmp_path_factory: pytest.TempPathFactory, lines: list[Line]) -> None:
    found = read(tmp_path_factory.getbasetemp(), render("ours", lines))
    suites = list(dict.fromkeys(line.suite for line in lines))
    wanted = [(line.outcome, line.verifies) for suite in suites for line in lines if line.suite == suite]
    assert [(test.outcome, test.requirements) for test in found] == wanted


@pytest.mark.parametrize("name", ["failure", "error", "skipped"])
@pytest.mark.parametrize(
    ("where", "text"),
    [
        ("properties", '<properties><property name="verifies" value="S-1"/><{} message="no"/></properties>'),
        (
            "property",
            '<properties><property name="verifies" value="S-1"><{} message="no"/></property></properties>',
        ),
    ],
)
def test_what_came_of_a_test_counts_among_properties_too(
    name: str, where: str, text: str, tmp_path: Path
) -> None:
    inside = text.format(name)
    (test,) = read(tmp_path, f'<testsuite name="s"><testcase name="t">{inside}</testcase></testsuite>')
    said = f"<{name}> in <{where}> is not known, so it is not known what came of it"
    assert (test.outcome, test.message, test.requirements) == ("error", said, ("S-1",))
    with pytest.raises(TrackmarshalError) as caught:
        read(tmp_path, f'<testsuite name="s">{inside}<testcase name="t"/></testsuite>')
    assert (caught.value.code, caught.value.message) == ("T333", f"<{name}> in <{where}> is not known")


def test_what_else_stands_among_properties_is_passed_over(tmp_path: Path) -> None:
    inside = '<properties><note>none</note><property name="a"><b/></property></properties>'
    (test,) = read(tmp_path, f'<testsuite name="s"><testcase name="t">{inside}</testcase></testsuite>')
    assert test.outcome == "passed"


def test_suites_that_name_more_than_there_is_room_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A suite that names many requirements, of many tests: of 200 kB it took 200 MB, since each test has all of them."""
    monkeypatch.setattr(reading, "MAX_NAMED", 500)
    path = tmp_path / "report.xml"
    for tests in (10, 20):
        named, cases = " ".join(f"R-{n}" for n in range(50)), "<testcase name='t' classname='c'/>" * tests
        path.write_text(f"<testsuite name='s' verifies='{named}'>{cases}</testsuite>", encoding="utf-8")
        if tests == 10:
            assert [len(test.requirements) for test in reading.read(path, "report.xml")] == [50] * 10
    with pytest.raises(TrackmarshalError, match=r"T334.*more than 500 times"):
        reading.read(path, "report.xml")


def test_suites_of_suites_that_name_something_are_read_in_one_pass(tmp_path: Path) -> None:
    """Each of them made all of its tests anew, with all that the inner ones had named: of 140 kB it took more than a minute."""
    path = tmp_path / "report.xml"

    def nested(depth: int) -> None:
        named, cases = " ".join(f"R-{n}" for n in range(100)), "<testcase name='t' classname='c'/>" * 100
        text = f"<testsuite name='s' verifies='{named}'>{cases}</testsuite>"
        for n in range(depth):
            text = f"<testsuite name='s{n}' verifies='Q-{n} R-0'>{text}</testsuite>"
        path.write_text(text, encoding="utf-8")
        expected = (*(f"R-{n}" for n in range(100)), *(f"Q-{n}" for n in range(depth)))
        assert {test.requirements for test in reading.read(path, "report.xml")} == {expected}

    assert grows(nested, 5, 50) < 4  # anew at each level, 10
