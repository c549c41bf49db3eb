"""Specs of another revision: read out of git into a temporary folder, without touching the checkout."""

from __future__ import annotations

import shutil
import subprocess
import tarfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import IO

from trackmarshal.cli.git import asking, surroundings
from trackmarshal.errors import TrackmarshalError

CODES = {
    "T361": (
        "a revision that cannot be read",
        "What is compared is neither a file or folder here nor a revision that git has: the name is not known, git is not installed, this is no repository, or "
        "its history is cut (a shallow clone, as continuous integration often makes one).",
    ),
    "T362": (
        "nothing to compare",
        "The revision has no specs where they are looked for, or what is said to be renamed is no rule there. What would be compared is not what was asked for.",
    ),
}
#: What of a revision is read: specs, and what says where they are.
_SUFFIXES = (".spec", ".yaml", ".yml")
#: The largest file that is read, in bytes; specs are far smaller.
_MOST = 16_000_000
#: And the largest one of other files that are named.
_MOST_OF_ANY = 512_000_000
#: Paths that are named to git at once.
_CHUNK = 500


def commit_of(name: str, project: Path) -> str:
    """The commit that a name stands for; raises T361."""
    _git(project, "rev-parse", "--show-prefix", name=name)
    try:
        return _git(
            project, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}", name=name
        ).strip()
    except TrackmarshalError:
        shallow = _git(project, "rev-parse", "--is-shallow-repository", name=name).strip() == "true"
        help_ = (
            "the clone is shallow: `git fetch --unshallow`, or a deeper checkout in continuous integration"
            if shallow
            else "is it a path, or a revision as `git log` has them?"
        )
        raise TrackmarshalError(
            "T361", f"`{name}` is neither a file or folder here nor a revision", help=help_
        ) from None


def last_change(path: str, project: Path) -> str:
    """The commit that changed a file of the project last, as far as the history goes; empty where none did. Raises T361."""
    return _git(project, "log", "-1", "--format=%H", "--", path, name="HEAD").strip()


def read(name: str, project: Path, into: Path, *, called: str = "") -> Path:
    """A revision's specs and requirements, below `into`; the folder that stands for the project. `called`: what messages call it. Raises T361."""
    commit = commit_of(name, project)
    specs = [path for path in _files(commit, called or name, project) if path.endswith(_SUFFIXES)]
    if specs:  # else the folder may not be there, an error to git: what is lacking says whoever asked
        _read(commit, called or name, project, into, (), _of_specs)
    _left_out(commit, called or name, project, into, specs, _MOST)
    return into


def read_more(commit: str, project: Path, into: Path, paths: Iterable[str], *, called: str) -> None:
    """Files and folders of a commit, by their paths from the project, below `into`; those that it does not have are left out. Raises T361."""
    wanted = sorted({str(path) for path in paths})
    chunks = (wanted[n : n + _CHUNK] for n in range(0, len(wanted), _CHUNK))
    there = [path for chunk in chunks for path in _files(commit, called, project, chunk)]
    for chunk in (there[n : n + _CHUNK] for n in range(0, len(there), _CHUNK)):
        _read(commit, called, project, into, chunk, lambda member: member.size <= _MOST_OF_ANY)
    _left_out(commit, called, project, into, there, _MOST_OF_ANY)


def _files(commit: str, name: str, project: Path, paths: Sequence[str] = ()) -> list[str]:
    """The regular files of a commit in the project's folder, or in some folders and files of it."""
    said = _git(project, "ls-tree", "-r", "-z", commit, "--", *paths, name=name)
    entries = (entry.partition("\t") for entry in said.split("\0"))
    return [path for mode, _, path in entries if mode.startswith("100")]


def _left_out(commit: str, name: str, project: Path, into: Path, paths: Iterable[str], most: int) -> None:
    """Write what `.gitattributes` keeps out of archives: what a project says is not known without it."""
    for path in paths:
        if (into / path).exists() or ".." in Path(path).parts:
            continue
        asked = f"{commit}:./{path}"
        if int(_git(project, "cat-file", "-s", asked, name=name)) <= most:
            (into / path).parent.mkdir(parents=True, exist_ok=True)
            (into / path).write_bytes(_bytes(project, "cat-file", "--filters", asked, name=name))


def _of_specs(member: tarfile.TarInfo) -> bool:
    return member.name.endswith(_SUFFIXES) and member.size <= _MOST


def _read(
    commit: str,
    name: str,
    project: Path,
    into: Path,
    paths: Sequence[str],
    wanted: Callable[[tarfile.TarInfo], bool],
) -> Path:
    folder = _git(project, "rev-parse", "--show-prefix", name=name).strip()
    literal = [f":(literal){path}" for path in paths]
    # Of the tree: an archive of the commit begins with its hash, and one that holds nothing beside that is none to Python.
    command = asking(project, "archive", "--format=tar", f"{commit}^{{tree}}", "--", *literal)
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=surroundings()
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        cut = ""
        try:
            _unpack(process.stdout, into, wanted)
        except tarfile.TarError as problem:  # mostly git stopped, and says below why
            cut = str(problem)
        said = process.stderr.read().decode("utf-8", "replace").strip() or cut
    if process.returncode or cut:
        raise TrackmarshalError(
            "T361",
            f"git cannot read `{name}`{': ' + said.splitlines()[-1] if said else ''}",
            help="is the history complete?" + (f" `{folder}` has to be in it" if folder else ""),
        )
    return into


def _unpack(stream: IO[bytes], into: Path, wanted: Callable[[tarfile.TarInfo], bool]) -> None:
    with tarfile.open(fileobj=stream, mode="r|") as archive:
        for member in archive:
            if member.isfile() and wanted(member):
                path = Path(member.name)
                content = archive.extractfile(member)
                if content is None or path.is_absolute() or ".." in path.parts:
                    raise tarfile.ExtractError(f"`{path}` is no file of the project")
                # Not by `extract`, whose filter for what lies outside Python has from 3.11.4 on only.
                (into / path).parent.mkdir(parents=True, exist_ok=True)
                with content, (into / path).open("wb") as file:
                    shutil.copyfileobj(content, file)


def _git(project: Path, *arguments: str, name: str) -> str:
    return _bytes(project, *arguments, name=name).decode("utf-8", "replace")


def _bytes(project: Path, *arguments: str, name: str) -> bytes:
    if shutil.which("git") is None:
        raise TrackmarshalError(
            "T361",
            f"`{name}` is no file or folder here, and for a revision git is missing",
            help="install git, or name a path",
        )
    done = subprocess.run(
        asking(project, *arguments),
        capture_output=True,
        check=False,
        env=surroundings(),
    )
    if done.returncode:
        said = done.stderr.decode("utf-8", "replace").strip()
        raise TrackmarshalError(
            "T361",
            f"`{name}` is no file or folder here, and no revision: {said or 'git does not know it'}",
            help="name a path, or a revision inside a repository",
        )
    return done.stdout
