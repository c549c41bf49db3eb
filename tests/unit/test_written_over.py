"""What verbs write takes the place of nothing but a file of its kind: who mistypes a name does not lose a spec, a log or the record of a drive."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

import trackmarshal as tm
from support import field_logs
from support.project import run_command
from trackmarshal.files import other_there
from trackmarshal.records.results_file import ResultsFile, save

SPEC = """module m
signal plan : trajectory { t: s increasing, v: m/s in [0, 100] }
rule slow "Slow"
  for all p in plan
  require p.v <= 50 m/s
test slow "at the limit"
  given plan = line(v: 50 m/s)
  expect satisfied, margin 0 m/s
"""


@pytest.fixture
def spec(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "m.spec"
    path.write_text(SPEC)
    return path


def refused(path: Path, code: str, *arguments: str) -> None:
    before = path.read_bytes()
    status, _, err = run_command(*arguments)
    assert (status, code in err, path.name in err, "choose another" in err or "another name" in err) == (
        2,
        True,
        True,
        True,
    ), err
    assert path.read_bytes() == before


@pytest.mark.parametrize("packed", [False, True])
def test_the_log_of_a_drive(packed: bool, tmp_path: Path) -> None:
    mapping, log = field_logs.write(tmp_path, field_logs.straight(30.0, 10.0))
    if packed:
        file = log.with_suffix(".csv.gz")
        file.write_bytes(gzip.compress(log.read_bytes()))
        log = file
    command = ("import", "log", str(log), "--map", str(mapping), "--no-report", "--quiet", "--out")
    refused(log, "D120", *command, str(log))
    refused(mapping, "D120", *command, str(mapping))
    for name in ("drive.tmrec.jsonl.gz", *([] if packed else ["drive"])):
        for _ in range(2):  # a recording is written again
            assert run_command(*command, str(tmp_path / name))[0] == 0
    refused(log, "E435", "import", "log", "--map", str(mapping), "--keep", str(log))
    results = tmp_path / "tests.json"  # of tests, not of a run
    save(results, ResultsFile("test_results", (), "1", "2026-01-02T03:04:05+00:00"))
    refused(results, "E435", "import", "log", "--map", str(mapping), "--keep", str(results))


def test_the_record_of_a_run(tmp_path: Path) -> None:
    writing = pytest.importorskip("mcap.writer", reason="writes MCAP")
    written, record, other = tmp_path / "m.spec", tmp_path / "run.arrows", tmp_path / "run.mcap"
    written.write_text(f"{SPEC}signal ego : state {{ x: m, y: m, heading: rad, v: m/s }}\n")
    supervisor = tm.supervisor(tm.load(written), clock=lambda: 0.0, record=record)
    supervisor.step(None)
    supervisor.close()
    command = ("replay", str(record), "--spec", str(written), "--mcap")
    refused(record, "D120", *command, str(record))
    for _ in range(2):
        assert run_command(*command, str(other))[0] == 0
        assert other.read_bytes()[1:5] == b"MCAP"
    drive = tmp_path / "drive.mcap"  # what the vehicle logged
    with drive.open("wb") as file:
        writer = writing.Writer(file)
        writer.start()
        writer.finish()
    refused(drive, "D120", *command, str(drive))


def test_a_spec(spec: Path) -> None:
    show = ("show", "slow", "--spec", "m.spec")
    for more in ((), ("--draw",), ("--format", "html"), ("--json",), ("--as", "spec")):
        refused(spec, "E412", *show, *more, "--out", "m.spec")


@pytest.mark.parametrize(
    ("more", "name", "begins"),
    [
        (("--draw",), "slow.svg", "<svg"),
        (("--over", "p.v"), "slow.svg", "<svg"),
        (("--format", "html"), "slow.html", "<!doctype html>"),
        (("--json",), "slow.json", '{"rule": "slow"'),
    ],
)
def test_show_writes_what_it_says(more: tuple[str, ...], name: str, begins: str, spec: Path) -> None:
    """`--out slow.html` of a page held a picture."""
    command = ("show", "slow", "--spec", "m.spec", *more)
    for _ in range(2):
        assert run_command(*command, "--out", name) == (0, "", "")
    text = Path(name).read_text("utf-8")
    assert text.startswith(begins)
    assert run_command(*command) == (0, text, "")


def test_show_writes_a_text(spec: Path) -> None:
    """A second time too, where nothing is lost: the same text is there."""
    command = ("show", "slow", "--spec", "m.spec", "--as", "formula")
    for _ in range(2):
        assert run_command(*command, "--out", "slow.txt") == (0, "", "")
    assert run_command(*command) == (0, Path("slow.txt").read_text("utf-8"), "")
    refused(Path("slow.txt"), "E412", "show", "slow", "--spec", "m.spec", "--out", "slow.txt")


def test_requirements(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where requirements are written by hand, each has a `statement` too: a table stood in place of all of them."""
    assert run_command("init", str(tmp_path / "car"))[0] == 0
    monkeypatch.chdir(tmp_path / "car")
    source = Path("requirements/requirements.yaml")
    for form, name in (("csv", "r.csv"), ("reqif", "r.reqif"), ("needs", "needs.json")):
        command = ("export", "requirements", "--format", form, "--out")
        refused(source, "E412", *command, str(source))
        for _ in range(2):
            assert run_command(*command, name)[0] == 0


def test_a_folder_with_a_program_of_its_own(spec: Path) -> None:
    Path("src").mkdir()
    own = Path("src/main.c")
    own.write_text("int main(void) { return 0; }\n")
    Path("src/own.h").write_text("#define OWN 1\n")
    command = ("compile", "m.spec", "--quiet", "--out")
    refused(own, "E474", *command, "src")
    assert sorted(path.name for path in own.parent.iterdir()) == ["main.c", "own.h"]
    for name in ("supervisor", "supervisor", "other"):  # what was generated is generated again
        assert run_command(*command, "build", "--name", name)[0] == 0


def test_an_empty_file_is_nothing(tmp_path: Path) -> None:
    """As `mktemp` makes one; and what is no file, such as a terminal, is for whoever names it."""
    path = tmp_path / "new"
    assert not other_there(path, None)
    path.touch()
    assert not other_there(path, None)
    assert not other_there(Path("/dev/null"), None)
    path.write_text("mine")
    assert other_there(path, None)
    assert other_there(path, b"its")
    assert not other_there(path, b"mine")
    path.write_bytes(b"\x1f\x8b no gzip")
    assert other_there(path, b"mine")
