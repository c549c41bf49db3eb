"""A revision has what its links lead to, and its submodules: specs that are shared so are specs of the project."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.planted.edits import run_git
from trackmarshal.cli import revisions
from trackmarshal.cli.git import asking
from trackmarshal.errors import TrackmarshalError

NOW = "module a\n# now\n"
THEN = "module a\n# then\n"


def put(root: Path, name: str, text: str) -> None:
    (root / name).parent.mkdir(parents=True, exist_ok=True)
    (root / name).write_text(text, "utf-8")


def commit(root: Path) -> None:
    run_git(root, "add", "-A")
    run_git(root, "commit", "-qm", "more")


@pytest.fixture
def car(tmp_path: Path) -> Path:
    """A project in a folder of a repository, which has a spec of its own."""
    root = tmp_path / "repository" / "car"
    put(root, "specs/own.spec", "module own\n")
    run_git(root.parent, "init", "-q")
    return root


def then(car: Path, *more: str) -> dict[str, str]:
    """What the last commit has, by path from the project, and what is named of it."""
    into = car.parent.parent / "then"
    into.mkdir()
    revisions.read("HEAD", car, into)
    if more:
        revisions.read_more(revisions.commit_of("HEAD", car), car, into, more, called="HEAD")
    found = [path for path in sorted(into.rglob("**/*")) if path.is_file()]
    # Python before 3.13 does not follow links to folders here, and later ones do.
    found += [
        path
        for link in into.rglob("*")
        if link.is_symlink() and link.is_dir()
        for path in link.iterdir()
        if path.is_file()
    ]
    return {path.relative_to(into).as_posix(): path.read_text("utf-8") for path in found}


@pytest.mark.parametrize(
    ("at", "target", "file"),
    [
        ("specs/a.spec", "../../common/a.spec", "common/a.spec"),
        ("specs/a.spec", "../shared/a.spec", "car/shared/a.spec"),
        ("specs/a.spec", "b.link", "car/shared/a.spec"),
        ("specs/lib", "../../common", "common/a.spec"),
        ("specs/lib", "../shared", "car/shared/a.spec"),
        ("specs/lib", "b.link", "car/shared/a.spec"),
    ],
)
def test_specs_behind_a_link(at: str, target: str, file: str, car: Path) -> None:
    """They were missing: to `trace --impact`, all of their rules were new, and no baseline's specs were at hand."""
    put(car.parent, file, THEN)
    (car / at).symlink_to(target)
    (car / "specs" / "b.link").symlink_to("../shared" if at == "specs/lib" else "../shared/a.spec")
    commit(car.parent)
    put(car.parent, file, NOW)
    found = then(car)
    assert found["specs/own.spec"] == "module own\n"
    assert found[at if at.endswith(".spec") else f"{at}/a.spec"] == THEN


def test_a_folder_of_the_project_stays_one_folder(car: Path) -> None:
    """As in the checkout: in two, each of its modules would be there twice."""
    put(car, "specs/v2/a.spec", THEN)
    (car / "specs" / "current").symlink_to("v2")
    commit(car.parent)
    then(car)
    into = car.parent.parent / "then"
    assert (into / "specs" / "current").resolve() == (into / "specs" / "v2").resolve()


def test_links_that_lead_to_nothing_that_is_read(car: Path, tmp_path: Path) -> None:
    put(car, "pictures/a.svg", "<svg/>")
    for name, target in (
        ("pictures", "../pictures"),
        ("none", "../none"),
        ("loop", "loop"),
        ("a.md", "own.spec/a"),
    ):
        (car / "specs" / name).symlink_to(target)
    put(tmp_path, "elsewhere.spec", NOW)
    (car / "specs" / "elsewhere.spec").symlink_to(tmp_path / "elsewhere.spec")
    commit(car.parent)
    assert then(car) == {"specs/own.spec": "module own\n", "specs/elsewhere.spec": NOW}


@pytest.mark.parametrize(("at", "target"), [("here", "."), ("specs/car", ".."), ("specs/all", "../..")])
def test_a_link_to_the_project_or_around_it(at: str, target: str, car: Path) -> None:
    """Was an internal error."""
    (car / at).symlink_to(target)
    commit(car.parent)
    assert then(car)["specs/own.spec"] == "module own\n"


@pytest.mark.parametrize("kept", ["kept", "../kept"])
@pytest.mark.parametrize("named", ["logs", "logs/of"])
def test_a_folder_that_is_named_and_is_behind_a_link(named: str, kept: str, car: Path) -> None:
    """It was missing; of one below it, git was asked for the link that it is not (T361), and beside a spec or document, nothing else of it was there."""
    put(car, f"{kept}/of/log.jsonl", THEN)
    put(car, f"{kept}/of/about.yaml", THEN)
    (car / "logs").symlink_to(kept)
    commit(car.parent)
    into = car.parent.parent / "then"
    then(car, named)
    assert (into / "logs" / "of" / "log.jsonl").read_text("utf-8") == THEN
    assert (into / "logs" / "of" / "about.yaml").read_text("utf-8") == THEN


def test_a_link_in_a_folder_that_is_named(car: Path) -> None:
    put(car, "logs/a.jsonl", NOW)
    put(car, "more", THEN)
    (car / "logs" / "b.jsonl").symlink_to("../more")
    commit(car.parent)
    assert then(car, "logs")["logs/b.jsonl"] == THEN


def test_a_file_behind_a_link_of_which_git_keeps_something_else(car: Path) -> None:
    """As Git LFS does: the pointer stood for the recording."""
    for way, said in (("clean", "s/then/kept/"), ("smudge", "s/kept/then/")):
        run_git(car.parent, "config", f"filter.other.{way}", f"sed {said}")
    put(car.parent, ".gitattributes", "car/kept/* filter=other\n")
    put(car, "kept/log.jsonl", THEN)
    (car / "log.jsonl").symlink_to("kept/log.jsonl")
    commit(car.parent)
    assert "kept" in run_git(car, "show", "HEAD:./kept/log.jsonl")
    assert then(car, "log.jsonl")["log.jsonl"] == THEN


def test_git_is_not_asked_of_each_link(car: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processes for every link there was, whatever it leads to."""
    (car / "modules").mkdir()
    put(car, "program", "")
    for number in range(20):
        (car / "modules" / str(number)).symlink_to("../program")
    commit(car.parent)
    asked = []

    def counted(folder: Path, *words: str) -> list[str]:
        asked.append(words)
        return asking(folder, *words)

    monkeypatch.setattr("trackmarshal.cli.revisions.asking", counted)
    then(car)
    assert 0 < len(asked) < 20


@pytest.mark.parametrize("at", ["log.jsonl", "logs/log.jsonl", "lib/log.jsonl", "lib/logs/log.jsonl"])
def test_what_is_named_behind_a_link_or_in_a_submodule(at: str, car: Path, tmp_path: Path) -> None:
    submodule(car, tmp_path, "logs/log.jsonl")
    (car / "log.jsonl").symlink_to("kept/log.jsonl")
    (car / "logs").symlink_to("kept")
    put(car, "kept/log.jsonl", THEN)
    put(car, "lib/log.jsonl", THEN)
    commit(car / "lib")
    commit(car.parent)
    put(car, "kept/log.jsonl", NOW)
    put(car, "lib/log.jsonl", NOW)
    put(car, "lib/logs/log.jsonl", NOW)
    assert then(car, at, "specs/none.jsonl")[at] == THEN


def submodule(car: Path, folder: Path, file: str) -> Path:
    """A submodule of the project, with a file."""
    put(folder / "origin", file, THEN)
    run_git(folder / "origin", "init", "-q")
    commit(folder / "origin")
    add = ("-c", "protocol.file.allow=always", "submodule", "add", "-q", str(folder / "origin"), "car/lib")
    run_git(car.parent, *add)
    commit(car.parent)
    return car / "lib"


def test_specs_in_a_submodule(car: Path, tmp_path: Path) -> None:
    lib = submodule(car, tmp_path, "specs/a.spec")
    put(lib, "specs/a.spec", NOW)
    commit(lib)
    assert then(car)["lib/specs/a.spec"] == THEN


def test_a_link_into_a_submodule(car: Path, tmp_path: Path) -> None:
    """To git it leads nowhere: the specs were missing."""
    lib = submodule(car, tmp_path, "all/a.spec")
    (car / "specs" / "lib").symlink_to("../lib/all")
    (car / "specs" / "none").symlink_to("../lib/none")
    commit(car.parent)
    put(lib, "all/a.spec", NOW)
    assert then(car)["specs/lib/a.spec"] == THEN


def test_a_folder_of_a_submodule(car: Path, tmp_path: Path) -> None:
    """Beside a document, nothing else of it was there."""
    lib = submodule(car, tmp_path, "logs/log.jsonl")
    put(lib, "logs/about.yaml", THEN)
    commit(lib)
    commit(car.parent)
    assert then(car, "lib/logs")["lib/logs/log.jsonl"] == THEN


def test_a_submodule_that_lacks_the_commit(car: Path, tmp_path: Path) -> None:
    """As where it was checked out without its history: that its rules were missing in the revision was not true."""
    lib = submodule(car, tmp_path, "specs/a.spec")
    run_git(car.parent, "update-index", "--cacheinfo", f"160000,{'1' * 40},car/lib")
    run_git(car.parent, "commit", "-qm", "another")
    with pytest.raises(TrackmarshalError, match="of the submodule `lib`, which is not here") as caught:
        then(car)
    assert caught.value.code == "T361"
    (lib / "specs" / "a.spec").unlink()  # what has no specs is asked for none
    (car.parent.parent / "then").rename(car.parent.parent / "before")
    assert then(car) == {"specs/own.spec": "module own\n"}


def test_a_submodule_that_is_not_checked_out(car: Path, tmp_path: Path) -> None:
    submodule(car, tmp_path, "specs/a.spec")
    run_git(car.parent, "submodule", "deinit", "-f", "car/lib")
    assert then(car) == {"specs/own.spec": "module own\n"}
