"""The baseline through version control: acceptances are added, never rewritten.

Who edits what the baseline holds, and makes its hash again, leaves no trace in the file. The versions that git has of it show that: each has
the acceptances of the one before, and what it holds differs only where one was added.
"""

from __future__ import annotations

import json
import posixpath
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.git import answer, asking, cut, refused, surroundings

if TYPE_CHECKING:
    from trackmarshal.trace import Finding, Place
    from trackmarshal.trace.baseline import Acceptance, Change
    from trackmarshal.trace.baseline.file import Baseline

CODES = {
    "T380": (
        "acceptances were rewritten",
        "Acceptances of the baseline are only ever added to, by `--accept-baseline`, with who accepted what. Between two versions that git has of the file, or "
        "between the last one and that in the folder, something else was changed: what is held became another thing without an acceptance, or an earlier "
        "acceptance reads differently, or is gone; or a merge dropped what was accepted on a branch. `--rerun` looks for that in all versions that there are. "
        "Acceptances on top of such a change do not heal it; to restore the file does, and so does an acceptance by name of whatever is less since. "
        "Of two branches that both accepted something, a merge takes the baseline of either one, on top of which whatever the other one has is accepted again.",
    ),
    "T381": (
        "nobody knows who accepted the baseline",
        "People sign acceptances through version control, and it cannot be asked: the project is not in a git repository, or git refuses to read one of another owner, "
        "or its history is cut (a shallow clone, as continuous integration often makes one). Or the baseline has more than 1,000 versions: those before are not looked at.",
    ),
}  # fmt: skip
#: Where the V-model says which file is the baseline.
_MODEL = "requirements/v-model.yaml"
#: What git says of a link that leads to no file of the repository, before how long it is.
_NO_FILE = frozenset({b"dangling", b"symlink", b"loop", b"notdir"})
#: Entries by which a project is known again in another folder.
_OF_ITS_OWN = ("requirement ", "rule ", "assumption ", "test ", "interface ")
#: So many versions are looked at: each may have megabytes.
MOST = 1_000


def check(root: Path, baseline: str) -> Iterator[Finding]:
    """T380 and T381 for the baseline of a project, whose path is relative to its folder. Nothing where there is no baseline: that is told elsewhere."""
    from trackmarshal.trace.findings import Place, error, warning

    if not (root / baseline).is_file():
        return
    within = [root / baseline, *(root / one for one in Path(baseline).parents if str(one) != ".")]
    links = [path.relative_to(root).as_posix() for path in within if path.is_symlink()]
    if links:
        message = (
            f"who accepted the baseline cannot be told: `{links[0]}` is a link, and git has another file"
        )
        yield error("T380", message, Place(baseline), "put what it leads to in its place")
        return
    try:
        own, its = (
            _git(folder, "rev-parse", "--show-toplevel") for folder in (root, (root / baseline).parent)
        )
        if own != its:
            message = f"who accepted the baseline cannot be told: `{Path(baseline).parent.as_posix()}` is in another repository than the project, such as a submodule"
            help_ = "name a file in the project's own one, such as `baseline: baseline.json`, move it there, and commit it"
            yield error("T380", message, Place(baseline), help_)
            return
        filter_ = _kept_by(root, baseline)
        if filter_:
            message = f"who accepted the baseline cannot be told: `filter={filter_}` of `.gitattributes` keeps something else of it in git"
            help_ = f"add `/{baseline} -filter` to the `.gitattributes` of this folder, and commit it anew: `git add --renormalize {baseline}`"
            yield error("T380", message, Place(baseline), help_)
            return
        along = list(_along(root, baseline))
        yield from along
        # What is not known of the first versions says nothing of what was merged since.
        if all(one.level != "error" for one in along):
            yield from [one for one in _merged(root, baseline) if one not in along]
    except (OSError, subprocess.SubprocessError) as problem:
        refusal, help_ = refused(problem)
        message = f"who accepted the baseline is not known: {refusal}"
        help_ = help_ or "put it under version control, and commit it"
        yield warning("T381", message, Place(baseline), help_)


def _kept_by(root: Path, baseline: str) -> str:
    """The filter by which git has something else than a baseline in its place, as Git LFS the size and hash of a file; empty where there is none."""
    kept = _version(root, "HEAD", baseline)
    if not kept or not _is_none(kept):
        return ""
    filter_ = _git(root, "check-attr", "-z", "filter", "--", baseline).split("\0")[2]
    return "" if filter_ in ("unspecified", "unset") else filter_


def _merged(root: Path, baseline: str) -> Iterator[Finding]:
    """T380 where a merge dropped what was accepted on the other branch: along first parents that is as if it had never been.

    Of each line of acceptances that was merged and is not the one that goes on here, whatever is less now is named in this one.
    """
    from trackmarshal.trace.baseline import changes
    from trackmarshal.trace.findings import Place, error

    now = _held((root / baseline).read_bytes())
    commits, named, whole = _versions(root, baseline, along=False)
    held = [(commit, _held(_version(root, commit, named[commit]))) for commit in commits if commit in named]
    lines = {one.acceptances: (commit, one) for commit, one in reversed(held) if one is not None}
    for line, (commit, one) in lines.items():
        if now is None or any(_goes_on(other, line) for other in (*lines, now.acceptances)):
            continue
        both = _common(line, now.acceptances)
        lost = _unnamed(changes(one.content, now.content), now.acceptances[both:])
        if lost is not None:
            message = f"what was accepted in commit {commit[:12]} was merged, and dropped: nobody is named who accepted that {lost}"
            yield error("T380", message, Place(baseline), _restored(commit, named[commit], baseline))
            return
    if not whole:
        yield _older(Place(baseline))


def _older(place: Place) -> Finding:
    from trackmarshal.trace.findings import warning

    message = f"who accepted the baseline before its last {MOST} versions is not known: no more are looked at"
    return warning("T381", message, place, "whoever reads the history looks at what is older")


def _goes_on(line: tuple[Acceptance, ...], from_: tuple[Acceptance, ...]) -> bool:
    """Whether acceptances begin with all of others."""
    return line != from_ and line[: len(from_)] == from_


def _versions(root: Path, baseline: str, along: bool) -> tuple[list[str], dict[str, str], bool]:
    """The commits that changed the baseline, the last one first, by commit the file that it is there, and whether these are all: along the first parents, or beside them, on branches that were merged."""
    homes = _homes(root, baseline)
    changed = _log(root, _models(root, homes))
    moved = _moved(root, baseline, homes, changed)
    files = [*_models(root, homes), *moved] if moved else [baseline]
    found = _log(root, files, "--first-parent" if along else "--full-history")
    commits, whole = found[:MOST], max(len(found), len(changed)) <= MOST
    if not along:
        first = set(_git(root, "rev-list", "--first-parent", "HEAD").split())
        commits = [commit for commit in commits if commit not in first]
    return commits, _named(root, commits, homes) if moved else dict.fromkeys(commits, baseline), whole


def _homes(root: Path, baseline: str) -> list[str]:
    """The folders of the repository that the project was in, from its own, this one first: those whose V-model is gone, and that held most of what is held here since the first acceptance.

    A project that was copied has its own history where what it was copied from is still there.
    """
    gone = _gone(root)
    own = reversed(_log(root, [*_models(root), baseline])) if gone else ()
    held = next(filter(None, (_at(root, commit, ".") for commit in own)), None)
    found = ["."]
    for home, commit in gone.items() if held is not None else ():
        # A baseline that was taken away first is missed all the same.
        were = _git(
            root, "log", "--first-parent", f"--max-count={MOST}", "--format=%H", f"{commit}^", "--", home
        ).split()
        before = next(filter(None, (_at(root, one, home) for one in were)), None)
        names = set() if before is None else {key for key in before.content if key.startswith(_OF_ITS_OWN)}
        if held is not None and len(names & held.content.keys()) * 2 > len(names):
            found.append(home)
    return found


def _gone(root: Path) -> dict[str, str]:
    """The folders, from the project's own, that are those of a V-model no more, and the commits that removed it along the first parents; the last one first."""
    prefix = _git(root, "rev-parse", "--show-prefix").rstrip("\n")
    told = _git(
        root, "-c", "core.quotepath=off", "log", "--first-parent", "-m", "--no-renames", "--diff-filter=D", "--name-only", "--format=%H",
        "--", f":(top,glob)**/{_MODEL}",
    )  # fmt: skip
    found: dict[str, str] = {}
    commit = ""
    for line in filter(None, told.split("\n")):
        if not line.endswith(_MODEL):
            commit = line
            continue
        home = posixpath.relpath(line.removesuffix(_MODEL) or ".", prefix or ".")
        if home != "." and not _version(root, "HEAD", posixpath.join(home, _MODEL)):
            found.setdefault(home, commit)
    return found


def _at(root: Path, commit: str, home: str) -> Baseline | None:
    """What a project in a folder held at a commit."""
    named = _named(root, [commit], [home]).get(commit)
    return None if named is None else _held(_version(root, commit, named))


def _along(root: Path, baseline: str) -> Iterator[Finding]:
    """T380 and T381 along the first parents."""
    from trackmarshal.trace.findings import Place, error, warning

    path = root / baseline
    place = Place(baseline)
    commits, named, whole = _versions(root, baseline, along=True)
    versions = [
        ("", _in_lines(path.read_bytes())),
        *(
            (commit, _in_lines(_version(root, commit, named[commit])))
            for commit in commits
            if commit in named
        ),
    ]
    there = [each for each in versions[1:] if each[1]]
    versions = [versions[0], *(each for each in there if not _is_none(each[1]))]
    if versions[1:] and there[-1] is not versions[-1]:
        message = f"who accepted the baseline before commit {versions[-1][0][:12]} is not known: what git has of it from then is no baseline"
        yield warning("T381", message, place, "whoever reads the history looks at what it was then")
    if not versions[1:]:
        yield warning(
            "T381", "who accepted the baseline is not known: it was never committed", place, "commit it"
        )
        return
    now = _held(versions[0][1])
    number, accepted = 0, False
    while number + 1 < len(versions):
        commit, newer = versions[number]
        if versions[number + 1][1] == newer:
            number += 1
            continue
        same = [n for n in range(number + 2, len(versions)) if versions[n][1] == newer]
        dropped = next((n for n in same if _came_of(versions, n)), None)
        if dropped is not None:
            while _came_of(versions, dropped):
                dropped -= 1
            if not (accepted and _made_good(_held(versions[dropped][1]), now)):
                message = f"the baseline was taken back{_since(commit)} to what it was before an acceptance that is gone with that"
                then = versions[dropped][0]
                yield error("T380", message, place, _restored(then, named[then], baseline))
                return
        if same:  # restored: what was in between does not count any more
            number = same[-1]
            continue
        # What is no baseline of today's format takes no acceptance back; one of another version of the program does where it is the first.
        older = next((n for n in range(number + 1, len(versions)) if _held(versions[n][1])), None)
        before = None if older is None else _held(versions[older][1])
        after = _held(newer)
        if older is None or before is None:
            return  # what is here was accepted anew
        why = "it cannot be read" if after is None else _rewritten(before, after)
        restored = None if why is None or after is None else _restored_and_accepted(versions, number, after)
        if restored is not None:
            number, accepted = restored, True
            continue
        if why is not None and _other_line_goes_on(
            root, commit, named.get(commit, baseline), before, after, now
        ):
            number = older
            continue
        if why is not None and not (accepted and _made_good(before, now)):
            then = versions[older][0]
            message = f"the baseline was changed{_since(commit)} without an acceptance: {why}"
            yield error("T380", message, place, _restored(then, named[then], baseline))
            return
        # An acceptance is on top of what there was: who edited that by hand, and has something else accepted afterwards, is found all the same.
        number, accepted = older, True
    if cut(root):
        yield warning(
            "T381",
            "who accepted the baseline is not known: the history of the clone is cut",
            place,
            "`git fetch --unshallow`",
        )
    elif not whole:
        yield _older(place)


def _other_line_goes_on(
    root: Path, commit: str, file: str, before: Baseline, after: Baseline | None, now: Baseline | None
) -> bool:
    """Whether a merge goes on with the acceptances of a branch that was merged, and not with those of its first parent, and names whatever is less by that.

    Of two branches that both accepted something, one line of acceptances has to be begun anew on top of the other one, whichever of them is the first parent
    later. The branch has to come properly of what both had in common.
    """
    from trackmarshal.trace.baseline import changes

    if after is None or now is None:
        return False
    if commit:
        merged = _git(root, "rev-list", "--parents", "--max-count=1", commit).split()[2:]
    else:  # a merge that is not committed yet
        merged = _git(root, "rev-parse", "--revs-only", "MERGE_HEAD").split()
    if not any(_comes_of_common(root, parent, file, before, after) for parent in merged):
        return False
    both = _common(before.acceptances, now.acceptances)
    return _unnamed(changes(before.content, now.content), now.acceptances[both:]) is None


def _comes_of_common(root: Path, parent: str, file: str, before: Baseline, after: Baseline) -> bool:
    """Whether a version has acceptances more, each properly along the first parents of a commit, than one whose acceptances another version has, too."""
    changed = _git(root, "log", "--first-parent", f"--max-count={MOST}", "--format=%H", parent, "--", file)
    newer = after
    for commit in [parent, *changed.split()]:
        older = _held(_in_lines(_version(root, commit, file)))
        if older is None:
            return False
        if older != newer:
            if _rewritten(older, newer) is not None:
                return False
            if _common(older.acceptances, before.acceptances) == len(older.acceptances):
                return _is_accepted(older)
        newer = older
    return False


def _common(one: Sequence[Acceptance], other: Sequence[Acceptance]) -> int:
    """How many acceptances both begin with."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other)))


def _restored_and_accepted(versions: list[tuple[str, bytes]], number: int, after: Baseline) -> int | None:
    """The version from which one comes properly that does not come of the one before it; None where there is none, or an acceptance in between is gone with that."""
    for older in range(number + 2, len(versions)):
        if _came_of(versions, older):
            return None
        before = _held(versions[older][1])
        if before is not None and _rewritten(before, after) is None:
            return older
    return None


def _made_good(before: Baseline | None, now: Baseline | None) -> bool:
    """Whether whatever is less now than in a version, from which it does not come properly, is in acceptances by name that came after it."""
    from trackmarshal.trace.baseline import changes

    if before is None or now is None:
        return False
    later = now.acceptances[len(before.acceptances) :]
    return _unnamed(changes(before.content, now.content), later) is None


def _came_of(versions: list[tuple[str, bytes]], number: int) -> bool:
    """Whether the version that came after one is another one with one proper acceptance more; the first version is the last one that there was."""
    if number < 2:
        return False
    before, after = _held(versions[number][1]), _held(versions[number - 1][1])
    return before is not None and after is not None and _rewritten(before, after) is None


def _since(commit: str) -> str:
    return f" in commit {commit[:12]}" if commit else " since the last commit"


def _restored(commit: str, was: str, baseline: str) -> str:
    how = (
        f"checkout {commit[:12]} -- {was}" if was == baseline else f"show {commit[:12]}:./{was} > {baseline}"
    )
    return f"restore it: `git {how}`, and accept what is there now"


def _log(root: Path, files: list[str], how: str = "--first-parent") -> list[str]:
    """The commits that changed files, the last one first, and no more than one beyond those that are looked at."""
    return _git(root, "log", how, f"--max-count={MOST + 1}", "--format=%H", "--", *files).split()


def _models(root: Path, homes: Sequence[str] = (".",)) -> list[str]:
    """The V-model, wherever it was, and the file in the project that it is a link to."""
    target = (root / _MODEL).resolve()
    inside = target.is_relative_to(root.resolve())
    there = [posixpath.normpath(posixpath.join(home, _MODEL)) for home in homes]
    return list(dict.fromkeys([*there, *([target.relative_to(root.resolve()).as_posix()] if inside else [])]))


def _moved(root: Path, baseline: str, homes: Sequence[str], changed: Sequence[str]) -> list[str]:
    """All files that the V-model, which these commits changed, named as its baseline at some time, where it is not this one alone."""
    asked = ["HEAD", *changed, *(f"{commit}^" for commit in changed)]
    named = {*_named(root, asked, homes).values(), baseline}
    return sorted(named) if len(named) > 1 else []


def _named(root: Path, commits: list[str], homes: Sequence[str] = (".",)) -> dict[str, str]:
    """By commit the file that its V-model names as the baseline, read as the project's is, in the first of these folders that has one; without those that name none."""
    found: dict[str, str] = {}
    for home in homes:
        there = _named_in(root, [commit for commit in commits if commit not in found], home)
        found |= {
            commit: file if home == "." else posixpath.normpath(posixpath.join(home, file))
            for commit, file in there.items()
        }
    return found


def _named_in(root: Path, commits: list[str], home: str) -> dict[str, str]:
    """The same of one folder."""
    from trackmarshal.trace import tree

    asked = "".join(f"{commit}:./{posixpath.join(home, _MODEL)}\n" for commit in commits)
    known: dict[bytes, str] = {}
    found: dict[str, str] = {}
    rest = _batch(root, asked, "--follow-symlinks")
    for commit in commits:
        head, _, rest = rest.partition(b"\n")
        if head.endswith(b" missing"):
            continue
        name, *_, size = head.split()
        if name in _NO_FILE:
            rest = rest[int(size) + 1 :]
            continue
        if name not in known:
            model = tree.parse(rest[: int(size)], _MODEL, [])
            for key in ("project", "baseline"):
                model = model.entries.get(key) if isinstance(model, tree.Mapping) else None
            known[name] = model.text if isinstance(model, tree.Scalar) else ""
        rest = rest[int(size) + 1 :]
        if known[name]:
            found[commit] = known[name]
    return found


def _in_lines(data: bytes) -> bytes:
    """With the ends of lines that it was written with, whatever a checkout made of them: no string of JSON has one."""
    return data.replace(b"\r\n", b"\n")


def _is_none(data: bytes) -> bool:
    """Whether it is no baseline of any format: a file that was cut, or emptied, takes no acceptance back."""
    try:
        said = json.loads(data)
        return not isinstance(said, dict) or not isinstance(said.get("version"), int)
    except (ValueError, RecursionError):
        return True


def _version(root: Path, commit: str, baseline: str) -> bytes:
    """What a file held in a commit, empty where there was none. Raises CalledProcessError where git cannot read it, as in a clone that has no contents."""
    head, _, rest = _batch(root, f"{commit}:./{baseline}\n").partition(b"\n")
    return b"" if head.endswith(b" missing") else rest[:-1]


def _batch(root: Path, asked: str, *how: str) -> bytes:
    """What git has by these names, one a line."""
    return subprocess.run(
        asking(root, "cat-file", "--batch", *how), input=asked.encode("utf-8", "surrogateescape"), capture_output=True, check=True, timeout=60, env=surroundings()
    ).stdout  # fmt: skip


def _git(root: Path, *words: str) -> str:
    return answer(root, *words, errors="surrogateescape", timeout=60.0)  # paths are asked for again


@lru_cache(maxsize=8)  # each is asked for as what came before one version and after another
def _held(data: bytes) -> Baseline | None:
    """What a version holds, with its acceptances; None for what is no baseline of today's format."""
    from trackmarshal.trace.baseline.file import checked

    try:
        return checked(json.loads(data))
    except (ValueError, RecursionError):
        return None


def _rewritten(before: Baseline, after: Baseline) -> str | None:
    """How a version does not come of the one before; None where it has acceptances more, of what it holds, that name whatever became less."""
    from trackmarshal.trace.baseline import changes

    old, new = before.acceptances, after.acceptances
    if new[: len(old)] != old:
        return "an earlier acceptance reads differently, or is gone"
    if len(new) == len(old):
        same = before.content == after.content
        return "something beside what it holds was changed" if same else "it holds something else than before"
    if not _is_accepted(after):
        return "what it holds is not what was accepted last"
    lost = _unnamed(changes(before.content, after.content), new[len(old) :])
    return None if lost is None else f"nobody is named who accepted that {lost}"


def _is_accepted(version: Baseline) -> bool:
    """Whether what a version holds is what was accepted last in it."""
    from trackmarshal.trace.baseline.file import digest

    return bool(version.acceptances) and version.acceptances[-1].after == digest(version.content)


def _unnamed(found: Iterable[Change], accepted: Iterable[Acceptance]) -> Change | None:
    """The first change by which something is less and that no acceptance by name tells."""
    from trackmarshal.trace.baseline import accepted as is_named
    from trackmarshal.trace.sections import lettered

    proper = [one for one in accepted if lettered(one.by) and lettered(one.reason)]
    named = [said for one in proper for said in one.weaker]
    for change in found:
        # What nobody was asked for once, somebody has accepted who gave a name to something.
        by_somebody = change.unasked and bool(proper)
        if change.weaker and not by_somebody and not is_named(change, named):
            return change
    return None


__all__ = ["CODES", "check"]
