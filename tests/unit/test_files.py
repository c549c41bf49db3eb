"""What is opened at all, and what of a folder is found: nothing that is there may be left out without a word."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from support.project import copy_project, run_command
from support.shared import REPOSITORY
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import UNMERGED, unmerged
from trackmarshal.scenarios.generate import document
from trackmarshal.source import decode
from trackmarshal.store import FILE, Entry, Store
from trackmarshal.trace import tree
from trackmarshal.trace.baseline import file as baseline_file
from trackmarshal.trace.findings import Finding

GOOD = 'module {name}\nsignal ego : state {{ v: m/s }}\nrule {name} "{name}"\n  require ego.v < 3 m/s\n'
RECORDING = REPOSITORY / "specs" / "scenarios" / "free_lap.tmrec.jsonl"


@pytest.fixture(autouse=True)
def nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(autouse=True)
def no_waiting() -> Iterator[None]:
    """Whoever waits for a pipe is interrupted."""

    def stop(*_: object) -> None:
        raise AssertionError("the command waits")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def spec(path: Path, name: str | None = None) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(GOOD.format(name=name or path.stem), encoding="utf-8")
    return path


def checked(*arguments: str) -> str:
    """How many modules and rules `check` saw; it finds nothing wrong."""
    status, out, err = run_command("check", *arguments)
    assert status == 0, err
    return out


# Folders -------------------------------------------------------------------------------------------------------


def test_a_linked_folder_counts(tmp_path: Path) -> None:
    spec(tmp_path / "specs" / "a.spec")
    spec(tmp_path / "elsewhere" / "deep" / "b.spec")
    (tmp_path / "specs" / "more").symlink_to(tmp_path / "elsewhere")
    assert "2 modules, 2 rules" in checked("specs")
    assert "1 module, 1 rule" in checked("specs/more")


def test_links_in_a_circle_end(tmp_path: Path) -> None:
    spec(tmp_path / "specs" / "in" / "a.spec")
    (tmp_path / "specs" / "in" / "up").symlink_to(tmp_path / "specs")
    (tmp_path / "specs" / "self").symlink_to("self2")
    (tmp_path / "specs" / "self2").symlink_to("in")
    (tmp_path / "specs" / "twice").symlink_to("in")
    assert "1 module, 1 rule" in checked("specs")


def test_a_module_behind_a_link_is_found_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "specs").mkdir()
    (tmp_path / "elsewhere" / "b.spec").write_text("module more.b\nuse more.c\nparam x : m = 2 m\n")
    (tmp_path / "elsewhere" / "c.spec").write_text("module more.c\nparam y : m = 2 m\n")
    (tmp_path / "specs" / "more").symlink_to(tmp_path / "elsewhere")
    assert "2 modules" in checked("specs")


def test_what_a_link_leads_to_is_laid_out_and_the_link_stays(tmp_path: Path) -> None:
    """The link became a file of its own, and what others read by theirs was as before."""
    shared = tmp_path / "shared.spec"
    shared.write_text("module shared\nparam  x:m = 2 m\n")
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "shared.spec").symlink_to(shared)
    assert run_command("fmt", "specs")[0] == 0
    assert (tmp_path / "specs" / "shared.spec").readlink() == shared
    assert shared.read_text() == "module shared\n\nparam x : m = 2 m\n"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["shared.spec", "shared.spec", "specs"]


@pytest.mark.parametrize("name", ["b.SPEC", "b.Spec"])
@pytest.mark.parametrize("verb", ["check", "test", "fmt"])
def test_a_suffix_in_capitals_is_refused(name: str, verb: str, tmp_path: Path) -> None:
    spec(tmp_path / "specs" / "a.spec")
    spec(tmp_path / "specs" / name)
    status, _, err = run_command(verb, "specs")
    assert status == 2
    assert "error[E007]" in err
    assert f"specs/{name}" in err
    assert "rename it to `b.spec`" in err


def test_a_link_that_leads_nowhere_is_refused(tmp_path: Path) -> None:
    spec(tmp_path / "specs" / "a.spec")
    (tmp_path / "specs" / "more").symlink_to(tmp_path / "gone")
    status, _, err = run_command("check", "specs")
    assert status == 2
    assert "error[E001]" in err
    assert "leads nowhere" in err


def test_a_spec_that_an_editor_has_open_is_read_as_it_is_saved(tmp_path: Path) -> None:
    """Emacs puts a link beside it that leads nowhere; any other link that does is named as what it is."""
    spec(tmp_path / "specs" / "a.spec")
    (tmp_path / "specs" / ".#a.spec").symlink_to("ann@here.4711:1760000000")
    assert run_command("check", "--quiet", "specs") == (0, "", "")
    (tmp_path / "specs" / "b.spec").symlink_to(tmp_path / "gone")
    status, _, err = run_command("check", "specs")
    assert status == 2
    assert "leads nowhere" in err
    assert "specs/b.spec" in err
    (tmp_path / "specs" / "b.spec").unlink()
    (tmp_path / "specs" / ".#b.spec").write_text("module m\nuse nothing\n", "utf-8")
    assert "nothing" in run_command("check", "specs")[2]  # a file of that name is a spec


def test_a_submodule_that_is_not_checked_out_is_the_cause(tmp_path: Path) -> None:
    (tmp_path / ".gitmodules").write_text('[submodule "x"]\n\tpath = specs/shared\n\turl = ../x\n', "utf-8")
    (tmp_path / "specs" / "shared").mkdir(parents=True)
    how = "git submodule update --init specs/shared"
    path = tmp_path / "specs" / "a.spec"
    path.write_text("module a\nuse shared.b\n", "utf-8")
    for arguments in (["check", "specs"], ["check", "specs/shared"], ["check", "specs/shared/in/b.spec"]):
        assert how in "".join(run_command(*arguments)[1:]), arguments
    (tmp_path / "specs" / "shared" / "README").touch()
    for arguments in (["check", "specs"], ["check", "specs/shared"], ["check", "specs/shared/in/b.spec"]):
        assert "submodule" not in "".join(run_command(*arguments)[1:]), arguments


def test_requirements_behind_a_link_and_in_capitals(tmp_path: Path) -> None:
    project = copy_project(tmp_path / "project")
    folder = str(project / "specs" / "supervisor")  # its rules satisfy RR-1
    rules = ("check", "--project", str(project), "--quiet", folder)
    (tmp_path / "more").mkdir()
    os.rename(project / "requirements" / "race-rules.yaml", tmp_path / "more" / "race-rules.yaml")
    status, _, err = run_command(*rules)
    assert status == 1
    assert "error[E206]" in err  # nobody demands RR-1 any more
    (project / "requirements" / "more").symlink_to(tmp_path / "more")
    assert run_command(*rules)[0] == 0
    (project / "requirements" / "extra.YAML").write_text("document: requirements\n")
    status, _, err = run_command(*rules)
    assert status == 2
    assert "error[T101]" in err
    assert "requirements/extra.YAML" in err


# What is no regular file ---------------------------------------------------------------------------------------


def pipe(path: Path) -> None:
    os.mkfifo(path)


def listening(path: Path) -> None:
    with contextlib.closing(socket.socket(socket.AF_UNIX)) as made:
        made.bind(os.path.relpath(path))  # whole paths may be too long for it


def device(path: Path) -> None:
    path.symlink_to("/dev/null")


@pytest.mark.parametrize("make", [pipe, listening, device])
@pytest.mark.parametrize(
    ("name", "command", "code"),
    [
        ("specs/b.spec", ("check", "specs"), "E001"),
        ("b.spec", ("check", "b.spec"), "E001"),
        ("b.spec", ("fmt", "b.spec"), "E001"),
        ("b.spec", ("eval", "b.spec", "--data", "cases.jsonl"), "E001"),
        ("b.spec", ("eval", "specs/a.spec", "--data", "cases.jsonl", "--with", "b.spec"), "E001"),
        ("cases", ("eval", "specs/a.spec", "--data", "cases"), "D102"),
        ("run.tmrec.jsonl", ("replay", "run.tmrec.jsonl", "--spec", "specs/a.spec"), "D120"),
        ("run.saa", ("replay", "run.saa", "--spec", "specs/a.spec"), "D120"),
        ("run.yaml", ("replay", "run.yaml", "--spec", "specs/a.spec"), "D120"),
        ("run.yaml", ("scenario", "run.yaml"), "D120"),
        ("project/requirements/more.yaml", ("check", "--project", "project", "specs"), "T101"),
        ("project/requirements/v-model.yaml", ("check", "--project", "project", "specs"), "E410"),
    ],
)
def test_what_is_no_regular_file_is_refused_and_never_waited_for(
    name: str, command: tuple[str, ...], code: str, make: Callable[[Path], None], tmp_path: Path
) -> None:
    spec(tmp_path / "specs" / "a.spec")
    (tmp_path / "cases.jsonl").write_text('{"signals": {"ego": {"v": 1}}}\n')
    (tmp_path / "project" / "requirements").mkdir(parents=True)
    if "v-model" not in name:
        v_model = "document: v-model\ntitle: small\nproject:\n  name: small\n  specs: [specs]\n"
        (tmp_path / "project" / "requirements" / "v-model.yaml").write_text(v_model)
    make(tmp_path / name)
    status, out, err = run_command(*command)
    assert status == 2, (out, err)
    assert f"error[{code}]" in out + err
    assert code == "E410" or "not a regular file" in out + err


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("name", ["a.spec", "requirements.yaml", "scenario.yaml", "baseline.json", "evidence.jsonl"])  # fmt: skip
def test_a_merge_that_nobody_finished_is_called_so(name: str, end: str, tmp_path: Path) -> None:
    """Wherever git leaves both sides, whatever the text would be said to be otherwise; and it is said once."""
    lines = ["a", "<<<<<<< HEAD", "b", "||||||| 1a2b3c4", "=======", "c", ">>>>>>> theirs", "<<<<<<< HEAD", "=======", ">>>>>>> theirs", ""]  # fmt: skip
    (tmp_path / name).write_bytes(end.join(lines).encode())
    data = (tmp_path / name).read_bytes()
    told: list[tuple[str, int | None]] = []
    found: list[Finding] = []
    try:
        match name:
            case "a.spec":
                decode(name, data)
            case "requirements.yaml":
                tree.parse(data, name, found)
                told = [(one.message, one.place.line) for one in found if one.place]
            case "scenario.yaml":
                document.read(data, name)
            case "baseline.json":
                baseline_file.read(tmp_path / name)
            case _:
                told = [(one.why, one.line) for one in Store(tmp_path).broken if one.why == UNMERGED]
    except TrackmarshalError as error:
        told = [(error.message, error.line)]
    except ValueError as refused:
        told = [(str(refused).removeprefix("line 2: "), 2)]
    assert told == [(UNMERGED, 2)]


def test_both_sides_of_an_unfinished_merge_of_the_store_hold(tmp_path: Path) -> None:
    one, two = (Entry("test", name, {}, {}, "tool", "c0ffee", "here", "2026-01-01") for name in "ab")
    lines = [b"<<<<<<< HEAD", one.text(), b"=======", two.text(), b">>>>>>> theirs", b""]
    (tmp_path / FILE).write_bytes(b"\n".join(lines))
    store = Store(tmp_path)
    assert [(broken.line, broken.why) for broken in store.broken] == [(1, UNMERGED)]
    assert all(store.latest("test", name) is not None for name in "ab")


@pytest.mark.parametrize(
    "text", ["a\n=======\nb\n", "<<<<<<<\n", ">>>>>>> a\n<<<<<<< b\n", " <<<<<<< a\n >>>>>>> b\n", "<<<<<<<<\n>>>>>>>>\n"]
)  # fmt: skip
def test_what_is_no_conflict_of_a_merge(text: str) -> None:
    assert unmerged(text.encode()) == 0
