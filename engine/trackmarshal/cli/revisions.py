"""Specs of another revision: read out of git into a temporary folder, without touching the checkout."""

from __future__ import annotations

import posixpath
import shlex
import shutil
import subprocess
import tarfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import IO, NamedTuple

from trackmarshal.cli.git import asking, refused, surroundings
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
#: Modes of what stands for something else: a link, and a submodule's commit.
_LINK, _SUBMODULE = "120000", "160000"


class _Entry(NamedTuple):
    """What a commit has at a path from the project."""

    mode: str
    id: str
    path: str


class _Led(NamedTuple):
    """What a commit has where the links on a path lead."""

    path: str
    kind: str
    id: str
    size: int


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
    entries = _entries(commit, called or name, project)
    specs = [path for path in _files(entries) if path.endswith(_SUFFIXES)]
    if specs:  # else the folder may not be there, an error to git: what is lacking says whoever asked
        _read(commit, called or name, project, into, (), _of_specs)
    _left_out(commit, called or name, project, into, specs, _MOST)
    for one in entries:
        if one.mode == _SUBMODULE and _is_checked_out(one, called or name, project):
            read(one.id, project / one.path, into / one.path, called=called or name)
    _behind(commit, called or name, project, into, _links(entries), (), _of_specs)
    return into


def read_more(commit: str, project: Path, into: Path, paths: Iterable[str], *, called: str) -> None:
    """Files and folders of a commit, by their paths from the project, below `into`; those that it does not have are left out. Raises T361."""
    wanted = sorted({str(path) for path in paths})
    chunks = (wanted[n : n + _CHUNK] for n in range(0, len(wanted), _CHUNK))
    entries = [one for chunk in chunks for one in _entries(commit, called, project, chunk)]
    there = _files(entries)
    for chunk in (there[n : n + _CHUNK] for n in range(0, len(there), _CHUNK)):
        _read(commit, called, project, into, chunk, _of_any)
    _left_out(commit, called, project, into, there, _MOST_OF_ANY)
    links = _links(entries)
    found = {str(one) for path in there for one in (Path(path), *Path(path).parents)}
    left = [path for path in wanted if str(Path(path)) not in found and ".." not in Path(path).parts]
    _behind(commit, called, project, into, links, [path for path in left if path not in links], _of_any)
    for one in _entries(commit, called, project) if left else ():
        within = [path.removeprefix(f"{one.path}/") for path in left if path.startswith(f"{one.path}/")]
        if one.mode == _SUBMODULE and within and _is_checked_out(one, called, project):
            read_more(one.id, project / one.path, into / one.path, within, called=called)


def _entries(commit: str, name: str, project: Path, paths: Sequence[str] = ()) -> list[_Entry]:
    """What a commit has in the project's folder, or in some folders and files of it."""
    said = _git(project, "ls-tree", "-r", "-z", commit, "--", *paths, name=name)
    parts = (entry.partition("\t") for entry in said.split("\0") if entry)
    return [_Entry(about.split()[0], about.split()[2], path) for about, _, path in parts]


def _files(entries: Iterable[_Entry]) -> list[str]:
    """The regular files."""
    return [one.path for one in entries if one.mode.startswith("100")]


def _links(entries: Iterable[_Entry]) -> list[str]:
    return [one.path for one in entries if one.mode == _LINK]


def _behind(
    commit: str,
    name: str,
    project: Path,
    into: Path,
    links: Sequence[str],
    over: Sequence[str],
    wanted: Callable[[tarfile.TarInfo], bool],
) -> None:
    """Write what a commit has at paths that are links, or lead over one. Of specs, a link to a folder of the project stays one, so that it stays one folder.

    What lies outside of the repository is the same in all revisions.
    """
    made: list[Path] = []
    known = set(links)
    for one in _led_to(commit, name, project, [*links, *over]):
        place = into / one.path
        stays = place.exists() or place.is_symlink()
        member = tarfile.TarInfo(one.path)
        member.size = one.size
        if one.kind == "tree" and wanted is _of_any:
            _read_tree(one.id, name, project, place, wanted)
        elif stays or (one.kind == "blob" and not wanted(member)):
            continue
        elif one.kind == "blob":
            place.parent.resolve().mkdir(parents=True, exist_ok=True)
            at = _target(commit, name, project, one.path) if one.path in known else one.path
            place.write_bytes(_filtered(one.id, name, project, at))
        elif one.kind == "symlink" and (project / one.path).exists():
            place.parent.resolve().mkdir(parents=True, exist_ok=True)
            place.symlink_to((project / one.path).resolve())
        elif one.path in known and one.kind in ("tree", "dangling"):
            target = _target(commit, name, project, one.path)
            if target.partition("/")[0] != "..":
                place.parent.resolve().mkdir(parents=True, exist_ok=True)
                place.symlink_to(into / target, target_is_directory=True)
                made.append(place)
            elif one.kind == "tree":
                _read_tree(one.id, name, project, place, wanted)
    for place in made:
        if not place.exists():  # nothing of what it leads to was wanted, or is there
            place.unlink()


def _read_tree(
    tree: str, name: str, project: Path, into: Path, wanted: Callable[[tarfile.TarInfo], bool]
) -> None:
    """Write a folder, wherever in the repository it is."""
    top = Path(_git(project, "rev-parse", "--show-toplevel", name=name).rstrip("\n"))
    _read(tree, name, top, into, (), wanted)


def _filtered(blob: str, name: str, project: Path, path: str) -> bytes:
    """A file as a checkout has it, at a path from the project, by which it has its attributes: Git LFS keeps something else in its place."""
    prefix = _git(project, "rev-parse", "--show-prefix", name=name).rstrip("\n")
    at = posixpath.normpath(posixpath.join(prefix, path))
    return _bytes(project, "cat-file", "--filters", f"--path={at}", blob, name=name)


def _target(commit: str, name: str, project: Path, path: str) -> str:
    """Where the link at a path leads, from the project."""
    said = _git(project, "cat-file", "blob", f"{commit}:./{path}", name=name)
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), said))


def _led_to(commit: str, name: str, project: Path, paths: Sequence[str]) -> Iterator[_Led]:
    """What a commit has where links lead: `symlink` where that is outside of the repository, `dangling` where it is in a submodule, or nowhere."""
    named = [path for path in paths if "\n" not in path]
    if not named:
        return
    asked = "".join(f"{commit}:./{path}\n" for path in named)
    rest = _bytes(project, "cat-file", "--batch-check", "--follow-symlinks", name=name, given=asked.encode())
    for path in named:
        head, _, rest = rest.partition(b"\n")
        if head.endswith(b" missing"):
            continue
        about = head.decode().split()
        if len(about) == 2:  # what a link leads to that leads to nothing here
            yield _Led(path, about[0], "", 0)
            rest = rest[int(about[1]) + 1 :]
        else:
            yield _Led(path, about[1], about[0], int(about[2]))


def _is_checked_out(submodule: _Entry, name: str, project: Path) -> bool:
    """Whether a submodule is here to be read from; raises T361 where it is, has specs, and lacks the commit."""
    there = project / submodule.path
    if not (there / ".git").exists():
        return False
    try:
        commit_of(submodule.id, there)
        return True
    except TrackmarshalError:
        if next(there.rglob("*.spec"), None) is None:
            return False
    # Where git refuses the submodule itself, as of another owner, this says so.
    shallow = _git(there, "rev-parse", "--is-shallow-repository", name=name).strip() == "true"
    message = (
        f"`{name}` has commit {submodule.id[:12]} of the submodule `{submodule.path}`, which is not here"
    )
    fetch = f"git -C {shlex.quote(submodule.path)} fetch{' --unshallow' * shallow}"
    raise TrackmarshalError("T361", message, help=f"`{fetch}`")


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


def _of_any(member: tarfile.TarInfo) -> bool:
    return member.size <= _MOST_OF_ANY


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


def _bytes(project: Path, *arguments: str, name: str, given: bytes = b"") -> bytes:
    if shutil.which("git") is None:
        raise TrackmarshalError(
            "T361",
            f"`{name}` is no file or folder here, and for a revision git is missing",
            help="install git, or name a path",
        )
    done = subprocess.run(
        asking(project, *arguments),
        input=given,
        capture_output=True,
        check=False,
        env=surroundings(),
    )
    if done.returncode:
        why, help_ = refused(subprocess.CalledProcessError(done.returncode, "git", stderr=done.stderr))
        raise TrackmarshalError(
            "T361",
            f"`{name}` is no file or folder here, and no revision: {why}",
            help=help_ or "name a path, or a revision inside a repository",
        )
    return done.stdout
