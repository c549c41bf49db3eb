"""`@pytest.mark.verifies`: what a run of pytest with the plugin writes, and what it refuses to collect."""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import io
import os
import shutil
import subprocess
import sys
import warnings
from pathlib import Path
from unittest import mock

import pytest

from golden.trace.cases import PROJECT
from trackmarshal.junit import reading
from trackmarshal.pytest_plugin.results import Results
from trackmarshal.records.results_file import load
from trackmarshal.records.tests import ExternalTest

TESTS = """
import pytest

pytestmark = pytest.mark.verifies("S-1-A-1")


@pytest.mark.verifies("S-1-B-1", "RR-2")
class TestDoor:
    def test_opens(self):
        pass

    @pytest.mark.verifies("RR-1")
    @pytest.mark.parametrize("side", [1, 2])
    def test_shuts(self, side):
        assert side == 1, "the other side"

    @pytest.mark.skip(reason="no lock")
    def test_locks(self):
        pass

    @pytest.mark.xfail(reason="known")
    def test_rusts(self):
        assert False

    @pytest.mark.xfail(reason="known")
    def test_recovers(self):
        pass


@pytest.fixture
def broken():
    raise OSError("no hinge")


@pytest.fixture
def falls():
    yield
    raise OSError("it falls off")


def test_broken(broken):
    pass


def test_falls(falls):
    pass
"""
OUTCOMES = {
    "test_broken": "error",
    "test_falls": "error",
    "TestDoor::test_opens": "passed",
    "TestDoor::test_shuts[1]": "passed",
    "TestDoor::test_shuts[2]": "failed",
    "TestDoor::test_locks": "skipped",
    "TestDoor::test_rusts": "skipped",
    "TestDoor::test_recovers": "skipped",
}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with tests in it, and nothing else that pytest would read."""
    shutil.copytree(PROJECT, tmp_path / "project")
    folder = tmp_path / "project" / "tests"
    folder.mkdir()
    (tmp_path / "project" / "pytest.ini").write_text("[pytest]\n", "utf-8")
    return tmp_path / "project"


def run(project: Path, tests: str, *arguments: str, apart: bool = False) -> subprocess.CompletedProcess[str]:
    """A run of pytest, whose files of tests are forgotten behind it. apart: in a process of its own, as each has with pytest-xdist."""
    (project / "tests" / "test_door.py").write_text(tests, "utf-8")
    words = ["-q", "-p", "trackmarshal.pytest_plugin", "-p", "no:cacheprovider", *arguments]
    # Not what else is installed beside it: to load that takes three times as long as all the rest of a run.
    alone = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    if apart or "-n" in arguments:
        command = [sys.executable, "-m", "pytest", *words, *(("-p", "xdist") if "-n" in arguments else ())]
        return subprocess.run(
            command, cwd=project, capture_output=True, text=True, errors="replace", check=False, env={**os.environ, **alone}
        )  # fmt: skip
    out, err = io.StringIO(), io.StringIO()
    importlib.invalidate_caches()
    with (
        mock.patch.dict(os.environ, alone), mock.patch.object(sys, "path", [*sys.path]), mock.patch.object(sys, "meta_path", [*sys.meta_path]),
        warnings.catch_warnings(), contextlib.chdir(project), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err),
    ):  # fmt: skip
        warnings.resetwarnings()  # this run's own are errors
        # Where faults of the interpreter are told, and what was never closed, is the business of the run around it.
        status = pytest.main([*words, "-p", "no:faulthandler", "-p", "no:unraisableexception"])
    for name, module in [*sys.modules.items()]:
        if (getattr(module, "__file__", None) or "").startswith(f"{project}{os.sep}"):
            del sys.modules[name]
    return subprocess.CompletedProcess(words, int(status), out.getvalue(), err.getvalue())


@pytest.mark.parametrize("more", [[], ["-n", "1"]], ids=["alone", "xdist"])
def test_of_an_inherited_test_both_files_are_held(project: Path, more: list[str]) -> None:
    checks = 'import pytest\n\n\nclass Checks:\n    @pytest.mark.verifies("RR-1")\n    def test_limit(self):\n        assert self.limit == 12\n'
    own = "from checks import Checks\n\n\nclass TestDoor(Checks):\n    limit = 12\n\n    def test_more(self): ...\n"
    (project / "tests" / "checks.py").write_text(checks, "utf-8")
    done = run(project, own, "--trackmarshal-results=out/a.json", *more)
    assert done.returncode == 0, done.stdout + done.stderr
    (test,) = load(project / "out" / "a.json").items
    assert isinstance(test, ExternalTest)
    assert (test.file, test.line, test.collected) == ("tests/checks.py", 5, "tests/test_door.py")
    assert test.file_hash == hashlib.sha256(checks.encode()).hexdigest()
    assert test.collected_hash == hashlib.sha256(own.encode()).hexdigest()


@pytest.mark.parametrize("more", [[], ["-n", "1"]], ids=["alone", "xdist"])
def test_a_file_is_held_as_it_was_collected_whatever_becomes_of_it_before_its_tests_run(
    project: Path, more: list[str]
) -> None:
    edits = 'from pathlib import Path\n\n\ndef test_it():\n    Path(__file__).with_name("test_door.py").write_text("def test_it(): assert False\\n")\n'
    (project / "tests" / "test_ahead.py").write_text(edits, "utf-8")
    own = 'import pytest\n\n\n@pytest.mark.verifies("RR-1")\ndef test_limit(): ...\n'
    done = run(project, own, "--trackmarshal-results=out/a.json", *more)
    assert done.returncode == 0, done.stdout + done.stderr
    (test,) = load(project / "out" / "a.json").items
    assert isinstance(test, ExternalTest)
    assert test.file_hash == hashlib.sha256(own.encode()).hexdigest()


def test_of_what_an_installed_package_runs_its_own_file_is_held(project: Path) -> None:
    """Where packages lie is not the same where the gate is asked."""
    own = (
        "import pytest\nfrom hypothesis.stateful import RuleBasedStateMachine, rule\n\n\nclass Door(RuleBasedStateMachine):\n"
        "    @rule()\n    def shuts(self): ...\n\n\nTestDoor = Door.TestCase\nTestDoor.pytestmark = [pytest.mark.verifies('RR-1')]\n"
    )
    done = run(project, own, "--trackmarshal-results=out/a.json")
    assert done.returncode == 0, done.stdout + done.stderr
    (test,) = load(project / "out" / "a.json").items
    assert isinstance(test, ExternalTest)
    assert (test.name, test.file, test.collected) == ("TestDoor::runTest", "tests/test_door.py", "")
    assert test.file_hash == hashlib.sha256(own.encode()).hexdigest()


@pytest.mark.parametrize("more", [[], ["-n", "2"]], ids=["alone", "xdist"])
def test_what_is_written(project: Path, more: list[str]) -> None:
    done = run(
        project, TESTS, "--strict-markers", "--junitxml=out/a.xml", "--trackmarshal-results=out/a.json", *more
    )
    assert done.returncode == 1, done.stdout + done.stderr
    tests = {
        test.name: test for test in load(project / "out" / "a.json").items if isinstance(test, ExternalTest)
    }
    assert {name: test.outcome for name, test in tests.items()} == OUTCOMES
    assert tests["TestDoor::test_shuts[2]"].requirements == ("RR-1", "S-1-B-1", "RR-2", "S-1-A-1")
    assert tests["test_broken"].requirements == ("S-1-A-1",)
    opens = tests["TestDoor::test_opens"]
    assert (opens.suite, opens.file, opens.line) == ("tests/test_door.py", "tests/test_door.py", 9)
    assert opens.file_hash == hashlib.sha256(TESTS.encode()).hexdigest()
    assert (opens.collected, opens.collected_hash) == ("", "")
    assert "the other side" in tests["TestDoor::test_shuts[2]"].message
    assert tests["TestDoor::test_locks"].message == "Skipped: no lock"
    # pytest's own report says the same of every test; one whose teardown fails it lists once, as an error.
    written = {test.name: test for test in reading.read(project / "out" / "a.xml", "a.xml")}
    assert {name: test.outcome for name, test in written.items()} == {
        name.removeprefix("TestDoor::"): outcome for name, outcome in OUTCOMES.items()
    }
    for name, test in tests.items():
        assert set(written[name.removeprefix("TestDoor::")].requirements) == set(test.requirements)


@pytest.mark.parametrize(
    ("mark", "said"),
    [
        (
            '"S-1-B-2"',
            "tests/test_door.py:2: error[T336]: no requirement `S-1-B-2` is demanded; did you mean `S-1-B-1`",
        ),
        ('"RR-9"', "no requirement `RR-9` is demanded"),  # obsolete
        ("", "`verifies` takes ids of requirements"),
        ("7", "`verifies` takes ids of requirements"),
        ('id="S-1-B-1"', "`verifies` takes ids of requirements"),
    ],
)
def test_what_is_not_collected(project: Path, mark: str, said: str) -> None:
    done = run(
        project,
        f"import pytest\n@pytest.mark.verifies({mark})\ndef test_it(): pass\n",
        "--trackmarshal-results=out/a.json",
    )
    assert done.returncode == 2
    assert "ERROR collecting tests/test_door.py" in done.stdout
    assert said in done.stdout
    assert load(project / "out" / "a.json").items == ()


def test_the_workers_of_xdist_refuse_it_too(project: Path) -> None:
    done = run(project, 'import pytest\n@pytest.mark.verifies("S-1-B-2")\ndef test_it(): pass\n', "-n", "1")
    assert done.returncode != 0
    assert "no requirement `S-1-B-2` is demanded" in done.stdout


def test_a_test_of_another_project_shows_nothing_of_this_one(project: Path) -> None:
    """Both have a requirement of that id."""
    shutil.copytree(project / "requirements", project / "cars" / "two" / "requirements")
    tests = project / "cars" / "two" / "tests"
    tests.mkdir()
    (tests / "test_two.py").write_text(
        'import pytest\n@pytest.mark.verifies("RR-1")\ndef test_it(): pass\n', "utf-8"
    )
    own = "def test_it(): pass\n"
    done = run(project, own, "--trackmarshal-results=out/a.json", "--ignore=tests")
    assert done.returncode == 2
    said = "cars/two/tests/test_two.py:2: this verifies requirements of another project: run its tests by themselves, with --trackmarshal-project cars/two"
    assert said in done.stdout
    assert load(project / "out" / "a.json").items == ()
    named = "--trackmarshal-project=cars/two"
    assert run(project, own, named, "--trackmarshal-results=out/b.json").returncode == 0
    assert len(load(project / "out" / "b.json").items) == 1


def test_without_a_project_nothing_is_verified(project: Path) -> None:
    tests = 'import pytest\n@pytest.mark.verifies("S-1-B-1")\ndef test_it(): pass\n'
    elsewhere = project.parent / "elsewhere"
    (elsewhere / "tests").mkdir(parents=True)
    (elsewhere / "pytest.ini").write_text("[pytest]\n", "utf-8")
    done = run(elsewhere, tests)
    assert done.returncode == 2
    assert "name one with --trackmarshal-project" in done.stdout
    assert run(elsewhere, tests, f"--trackmarshal-project={project}").returncode == 0
    assert run(elsewhere, tests, "--trackmarshal-project=.").returncode != 0
    assert run(elsewhere, "def test_it(): pass\n").returncode == 0


def test_results_of_asserts_that_do_nothing_are_none(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With -O and `--assert=plain`, what fails would pass."""
    monkeypatch.setenv("PYTHONOPTIMIZE", "1")
    tests = 'import pytest\n@pytest.mark.verifies("S-1-B-1")\ndef test_it(): assert False\n'
    done = run(project, tests, "--assert=plain", "--trackmarshal-results=out/a.json", apart=True)
    assert done.returncode == 4
    assert "Python runs with -O" in done.stdout + done.stderr
    assert not (project / "out" / "a.json").exists()


def test_what_a_worker_took_with_it_is_not_left_out(pytestconfig: pytest.Config, tmp_path: Path) -> None:
    """pytest-xdist tells it so of a test for which a worker ended while it was set up; what it verifies, nobody knows."""
    results = Results(pytestconfig, tmp_path / "a.json")
    file, crashed = (
        "tests/test_door.py",
        "worker 'gw0' crashed while running 'tests/test_door.py::test_falls'",
    )
    taken = pytest.TestReport(f"{file}::test_falls", (file, None, file), {}, "failed", crashed, "???")  # type: ignore[arg-type]
    other = pytest.TestReport(f"{file}::test_opens", (file, 3, "test_opens"), {}, "failed", "no", "call")
    for report in (taken, other):
        results.pytest_runtest_logreport(report)
    results.pytest_sessionfinish()
    (test,) = load(tmp_path / "a.json").items
    assert isinstance(test, ExternalTest)
    assert (test.suite, test.name, test.outcome, test.requirements) == (file, "test_falls", "error", ())
    assert test.message == crashed


#: Tests that pass for pytest and for unittest, but for what they name: half of them never ask anything.
EMPTY = """
import sys
import threading
import unittest
import warnings

import pytest

pytestmark = [pytest.mark.verifies("S-1-B-1"), pytest.mark.filterwarnings("ignore")]


def threaded(function):
    thread = threading.Thread(target=function)
    thread.start()
    thread.join()


def divides():
    threaded(lambda: 1 / 0)


@pytest.fixture
def dividing():
    divides()


@pytest.fixture
def dividing_at_last():
    yield
    divides()


def test_returns():
    return 1 == 2


def test_in_a_thread():
    divides()


def test_in_a_thread_that_is_caught():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        divides()


def test_a_thread_is_through():
    threaded(sys.exit)


def test_a_thread_gives_up():
    threaded(lambda: sys.exit("no door"))


def test_set_up_in_a_thread(dividing):
    assert True


def test_torn_down_in_a_thread(dividing_at_last):
    assert True


def test_says_so():
    assert 1 == 1


class Door(unittest.TestCase):
    async def test_is_not_awaited(self):
        assert False

    def test_yields(self):
        yield
        assert False

    def test_opens(self):
        assert True

    @unittest.skip("no lock")
    async def test_locks(self):
        assert False


class Gate(unittest.IsolatedAsyncioTestCase):
    async def test_is_awaited(self):
        assert True

    async def test_fails(self):
        assert False


class Deferring(unittest.TestCase):
    def run(self, result):  # as that of Twisted, which waits for what a test returns
        result.startTest(self)
        assert getattr(self, self._testMethodName)() == 12
        result.stopTest(self)

    def test_returns(self):
        return 12
"""


def test_what_never_asked_anything_has_failed(project: Path) -> None:
    """pytest and unittest let it pass, with a warning, which a project may have turned off."""
    (project / "pytest.ini").write_text("[pytest]\nfilterwarnings = ignore\n", "utf-8")
    done = run(project, EMPTY, "--trackmarshal-results=out/a.json", "--junitxml=out/a.xml")
    assert done.returncode == 1, done.stdout + done.stderr
    tests = [test for test in load(project / "out" / "a.json").items if isinstance(test, ExternalTest)]
    came = {
        "test_returns": "failed", "test_in_a_thread": "failed", "test_in_a_thread_that_is_caught": "failed",
        "test_a_thread_is_through": "passed", "test_a_thread_gives_up": "failed",
        "test_set_up_in_a_thread": "error", "test_torn_down_in_a_thread": "error", "test_says_so": "passed", "Door::test_is_not_awaited": "failed", "Door::test_yields": "failed", "Door::test_opens": "passed",
        "Door::test_locks": "skipped", "Gate::test_is_awaited": "passed", "Gate::test_fails": "failed", "Deferring::test_returns": "passed",
    }  # fmt: skip
    assert {test.name: test.outcome for test in tests} == came
    said = {test.name: test.message for test in tests}
    assert said["test_returns"].endswith("it returned something (bool), which asserts nothing: `assert` it")
    assert said["Door::test_yields"].endswith("it returned something (generator) whose body never began")
    assert "nothing awaited it" in said["Door::test_is_not_awaited"]
    in_xml = reading.read(project / "out" / "a.xml", "a.xml")
    assert sorted((test.name, test.outcome) for test in in_xml) == sorted(
        (name.rpartition("::")[2], outcome) for name, outcome in came.items()
    )


def test_what_a_hook_passes_and_never_calls_has_failed(project: Path) -> None:
    """So projects make a dry run, in a hook of which pytest asks nothing more."""
    (project / "tests" / "conftest.py").write_text(
        "import pytest\n\n@pytest.hookimpl(tryfirst=True)\ndef pytest_pyfunc_call(pyfuncitem):\n    return True\n", "utf-8"
    )  # fmt: skip
    mark = '@pytest.mark.verifies("S-1-B-1")\n'
    tests = f"import pytest\n{mark}def test_it(): assert False\n{mark}async def test_waits(): assert False\ndef test_other(): ...\n"
    done = run(project, tests, "--trackmarshal-results=out/a.json")
    assert done.returncode == 1, done.stdout + done.stderr
    found = [test for test in load(project / "out" / "a.json").items if isinstance(test, ExternalTest)]
    assert [(test.name, test.outcome, "nothing called it" in test.message) for test in found] == [
        ("test_it", "failed", True),
        ("test_waits", "failed", True),
    ]


def test_a_coroutine_that_a_plugin_awaits_is_a_test(project: Path) -> None:
    """As anyio does, which asks whether a function is one; what nothing awaits, pytest fails by itself, or skips before its version 8.4."""
    (project / "tests" / "conftest.py").write_text(
        "import asyncio, inspect, pytest\n\n@pytest.hookimpl(tryfirst=True)\ndef pytest_pyfunc_call(pyfuncitem):\n"
        "    if inspect.iscoroutinefunction(pyfuncitem.obj) and 'left' not in pyfuncitem.name:\n"
        "        asyncio.run(pyfuncitem.obj())\n        return True\n", "utf-8"
    )  # fmt: skip
    mark = '@pytest.mark.verifies("S-1-B-1")\nasync '
    tests = f"import pytest\n{mark}def test_fails(): assert 1 == 2\n{mark}def test_holds(): ...\n{mark}def test_is_left(): ...\n{mark}def test_returns(): return 1\n"
    run(project, tests, "--trackmarshal-results=out/a.json")
    found = [test for test in load(project / "out" / "a.json").items if isinstance(test, ExternalTest)]
    outcomes = {test.name: test.outcome for test in found}
    assert outcomes.pop("test_is_left") in ("failed", "skipped")
    assert outcomes == {"test_fails": "failed", "test_holds": "passed", "test_returns": "failed"}


def test_a_message_that_no_file_can_hold_is_written_all_the_same(project: Path) -> None:
    """Nothing was written, and what an earlier session had written stayed."""
    mark = '@pytest.mark.verifies("S-1-B-1")\n'
    raises = 'raise FileNotFoundError(os.fsdecode(b"caf\\xe9"))'
    done = run(
        project, f"import os, pytest\n{mark}def test_it(): {raises}\n", "--trackmarshal-results=out/a.json"
    )
    assert done.returncode == 1, done.stdout + done.stderr
    (test,) = load(project / "out" / "a.json").items
    assert isinstance(test, ExternalTest)
    assert (test.outcome, "caf\\udce9" in test.message) == ("failed", True)


def test_what_an_earlier_session_wrote_does_not_outlive_one_that_is_killed(project: Path) -> None:
    mark = '@pytest.mark.verifies("S-1-B-1")\n'
    tests = f"import os, pytest\n{mark}def test_it(): 'DIE' in os.environ and os._exit(1)\n"
    assert run(project, tests, "--trackmarshal-results=out/a.json").returncode == 0
    assert load(project / "out" / "a.json").items
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DIE", "1")
        assert run(project, tests, "--trackmarshal-results=out/a.json", apart=True).returncode == 1
    assert not (project / "out" / "a.json").exists()


REPEATS = """
from _pytest.runner import runtestprotocol

def pytest_runtest_protocol(item, nextitem):
    reports = runtestprotocol(item, nextitem=nextitem, log=False)
    if any(report.failed for report in reports):
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    return True
"""


def test_what_passes_only_when_it_is_repeated_has_failed(project: Path) -> None:
    """Reports in XML have the last run of a test alone, so it says so in a property."""
    (project / "tests" / "conftest.py").write_text(REPEATS, "utf-8")
    mark = '@pytest.mark.verifies("S-1-B-1")\n'
    tests = f"import pytest\nN = []\n{mark}def test_flaky():\n    N.append(1)\n    assert len(N) > 1\n{mark}def test_good(): pass\n"
    done = run(project, tests, "--junitxml=out/a.xml")
    assert done.returncode == 0, done.stdout + done.stderr
    written = {test.name: test.outcome for test in reading.read(project / "out" / "a.xml", "a.xml")}
    assert written == {"test_flaky": "failed", "test_good": "passed"}


@pytest.mark.parametrize("option", ["--setup-only", "--setup-plan"])
def test_what_was_set_up_and_never_called_shows_nothing(project: Path, option: str) -> None:
    """pytest writes of it what it writes of any test that passed."""
    mark = '@pytest.mark.verifies("S-1-B-1")\n'
    tests = (
        f"import pytest\n{mark}def test_it(): assert False\n{mark}@pytest.mark.skip\ndef test_other(): pass\n"
    )
    assert run(project, tests, option, "--junitxml=out/a.xml").returncode == 0
    written = {test.name: test.outcome for test in reading.read(project / "out" / "a.xml", "a.xml")}
    assert written == {"test_it": "error", "test_other": "skipped"}


def test_reports_in_xml_of_asserts_that_do_nothing_show_nothing(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONOPTIMIZE", "1")
    tests = 'import pytest\n@pytest.mark.verifies("S-1-B-1")\ndef test_it(): assert False\n'
    assert run(project, tests, "--assert=plain", "--junitxml=out/a.xml", apart=True).returncode == 0
    (test,) = reading.read(project / "out" / "a.xml", "a.xml")
    assert (test.requirements, test.outcome) == (("S-1-B-1",), "skipped")
