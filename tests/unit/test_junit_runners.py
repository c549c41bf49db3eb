"""Reports as runners wrote them, of tests that passed, failed, broke, were skipped, were expected to fail or were cut off: what the runner says of each
is what we say, and nothing that did not pass passes. Each report names its runner and the version."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.errors import TrackmarshalError
from trackmarshal.junit import reading

REPORTS = Path(__file__).parents[1] / "support" / "reports"
#: Outcomes by their first letters, in the order of the report.
WORDS = {"p": "passed", "f": "failed", "e": "error", "s": "skipped"}


@pytest.mark.parametrize(
    ("report", "outcomes"),
    [
        ("bats", "fsp"),
        ("catch2", "ppfessp"),
        ("catch2_crash", "e"),
        ("ctest", "pfpfssssffssfp"),
        ("gtest", "pfsfsspf"),
        ("gtest_environment_breaks", "pf"),
        ("gtest_environment_skips", "ss"),
        ("gtest_environment_skips_elsewhere", "ss"),
        ("jest", "spsfsppf"),
        ("meson", "pffpfe"),
        ("mocha_pending", "pfssspfpf"),
        ("mocha_xunit", "pfssspfpf"),
        ("node", "pfsssfp"),
        ("nose2", "psfsse"),
        ("pytest_8_3", "pfseefees"),
        ("pytest_subtests", "psfsfep"),
        ("unittest", "pfssee"),
        ("vitest", "pfsspfppspff"),
    ],
)
def test_what_the_runner_says_of_each(report: str, outcomes: str) -> None:
    found = [test.outcome for test in reading.read(REPORTS / f"{report}.xml", "report.xml")]
    assert found == [WORDS[letter] for letter in outcomes]


@pytest.mark.parametrize(
    ("report", "code", "what_to_do"),
    [
        ("bats_replaced", "T335", "lists a test that was killed"),
        ("catch2_should_fail", "T335", "take the tag away"),
        ("doctest", "T333", "let CTest run its tests"),
        ("meson_1_3", "T335", "let Meson 1.10 or later write it"),
        ("mocha", "T335", "includePending=true"),
        ("qt", "T333", "let CTest run its tests"),
        ("pytest_8_3_subtests", "T335", "have a newer one write it"),
    ],
)
def test_a_report_that_does_not_tell_what_came_of_its_tests(report: str, code: str, what_to_do: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        reading.read(REPORTS / f"{report}.xml", "report.xml")
    assert caught.value.code == code
    assert what_to_do in (caught.value.help or "")


def _of(tmp_path: Path, text: str) -> list[str]:
    path = tmp_path / "report.xml"
    path.write_text(text, "utf-8")
    return [test.outcome for test in reading.read(path, "report.xml")]


@pytest.mark.parametrize("place", ["setup", "teardown"])
def test_pytest_counts_twice_what_breaks_behind_a_test_and_nothing_else(place: str, tmp_path: Path) -> None:
    """One that is left out beside it is missed."""
    suite = '<testsuites><testsuite name="pytest" errors="1" failures="0" skipped="0" tests="{}">{}</testsuite></testsuites>'
    cases = (
        f'<testcase name="a"/><testcase name="b"><error message="failed on {place} with a word"/></testcase>'
    )
    whole = 3 if place == "teardown" else 2
    assert _of(tmp_path, suite.format(whole, cases)) == ["passed", "error"]
    with pytest.raises(TrackmarshalError, match=f"says it has {whole + 1} tests, and lists 2"):
        _of(tmp_path, suite.format(whole + 1, cases))
    # One that failed before is listed twice instead, and did not pass.
    failed = '<testcase name="a"/><testcase name="b"><failure/></testcase>'
    twice = suite.replace('failures="0"', 'failures="1"')
    again = failed + '<testcase name="b"><error message="failed on teardown with a word"/></testcase>'
    assert _of(tmp_path, twice.format(3, again)) == ["passed", "failed", "error"]
    with pytest.raises(TrackmarshalError, match="says it has 4 tests, and lists 3"):
        _of(tmp_path, twice.format(4, again))


def test_catch2_lists_what_it_counts_as_failed_and_skipped(tmp_path: Path) -> None:
    """Its counts are of assertions: version 3 counts each `SKIP()`, and what may fail is not among the failed ones."""
    suite = '<testsuites><testsuite name="c" errors="0" failures="{}" skipped="{}" tests="40" hostname="tbd">{}</testsuite></testsuites>'
    twice = '<testcase name="x"><skipped type="SKIP"/><skipped type="SKIP"/></testcase>'
    may = '<testcase name="y"><skipped message="TEST_CASE tagged with !mayfail"/><failure/></testcase>'
    assert _of(tmp_path, suite.format(0, 2, twice + may)) == ["skipped", "skipped"]
    assert _of(tmp_path, suite.format(1, 0, '<testcase name="x"><failure/></testcase>')) == ["failed"]
    for text in (suite.format(1, 0, may), suite.format(0, 3, twice)):
        with pytest.raises(TrackmarshalError, match="lists"):
            _of(tmp_path, text)


def test_pytest_counts_each_subtest_that_was_skipped_and_lists_it_in_its_test(tmp_path: Path) -> None:
    suite = '<testsuites name="pytest tests"><testsuite name="pytest" errors="0" failures="0" skipped="{}" tests="5">{}</testsuite></testsuites>'
    twice = '<testcase name="x"><skipped type="pytest.skip"/><skipped type="pytest.skip"/></testcase><testcase name="y"/>'
    assert _of(tmp_path, suite.format(2, twice)) == ["skipped", "passed"]
    with pytest.raises(TrackmarshalError, match="says that 3 tests were skipped, and lists 2"):
        _of(tmp_path, suite.format(3, twice))


def test_only_its_own_words_excuse_what_failed(tmp_path: Path) -> None:
    """What GoogleTest skips after it failed has failed, and no other runner knows the words of Catch2."""
    for skipped in (
        "<skipped/>",
        '<skipped message="TEST_CASE tagged with !mayfail"/>',
        '<skipped type="pytest.skip"/>',
    ):
        assert _of(tmp_path, f'<testsuite><testcase name="x">{skipped}<failure/></testcase></testsuite>') == [
            "failed"
        ]


@pytest.mark.parametrize(
    ("time", "outcome"),
    [
        ("1970-01-01T00:00:00.000", "skipped"), ("1970-01-01T05:45:00.000", "skipped"), ("1969-12-31T19:00:00", "skipped"),
        ("1970-01-01T00:00:03.250", "passed"), ("2026-06-01T12:00:00.000", "passed"), ("", "passed"),
    ],
)  # fmt: skip
def test_a_test_that_never_began(tmp_path: Path, time: str, outcome: str) -> None:
    """GoogleTest says `completed` of all tests where an Environment skips them."""
    test = f'<testcase name="x" status="run" result="completed" timestamp="{time}"/>'
    assert _of(tmp_path, f'<testsuite tests="1" skipped="0">{test}</testsuite>') == [outcome]


def test_what_is_to_do_is_looked_for_only_where_a_suite_lists_more_than_it_counts(tmp_path: Path) -> None:
    quick, slow = '<testcase name="x" time="0"/>', '<testcase name="y" time="0.2"/>'
    broke = '<testcase name="hook" time="0"><failure/><failure/></testcase>'
    suite = '<testsuites><testsuite tests="{}" failures="0">{}</testsuite></testsuites>'
    assert _of(tmp_path, suite.format(2, quick + slow)) == ["passed", "passed"]
    assert _of(tmp_path, suite.format(2, quick + slow + broke)) == ["passed", "passed", "failed"]
    assert _of(tmp_path, suite.format(1, quick + slow + broke)) == ["skipped", "passed", "failed"]
    assert _of(tmp_path, suite.format(0, quick)) == ["skipped"]
