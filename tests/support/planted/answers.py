"""Faults in what only people and evidence of the right kind can show: reviews, and methods of verification."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from support.planted.edits import (
    BASELINE,
    TODAY,
    Edit,
    Fault,
    Harmless,
    accepted,
    add,
    agreed,
    all_of,
    committed,
    cut,
    git,
    gone,
    moved,
    put,
    remade,
    run_git,
    swap,
)
from support.planted.evidence import REPORT, REPORTED, ran
from support.project import command

R, V, H, D, A = (
    f"requirements/{name}.yaml" for name in ("requirements", "v-model", "hazards", "design", "assurance")
)
F = "specs/scenarios/faults.yaml"
CLOSING = "  - {id: HZ-2, title: A door closes, situation: At a stop., severity: S0, exposure: E4, controllability: C1, asil: QM, rationale: It is soft.}\n"
REVIEW = "  - id: RV-2\n    of: [{id: S-1, fingerprint: 'e2170c78b48f76517eb82d661f903478668ddf28e558c68825098bafc90806f8'}]\n    by: [P-4]\n    made: 2026-05-01\n    outcome: accepted\n"
ANALYSED = "  - id: RV-3\n    of: [{id: AN-1, fingerprint: '43c60a51f4b963df81ac53acc556cfdaac03c5034bcbf6bc0f3ca6cc827b302e'}]\n    by: [P-4]\n    made: 2026-05-01\n    outcome: accepted\n"
RATED = "  - id: RV-4\n    of: [{id: HZ-1, fingerprint: 'e8b470acd1c4e7332316f91ed94c0a1244a9a08221e41ec9bd4fa63848de28bd'}]\n    by: [P-4]\n    made: 2026-05-01\n    outcome: accepted\n"
DOORS = (
    "document: requirements\ntitle: Doors\nrequirements:\n"
    "  - id: S-5\n    title: Doors\n    statement: The shuttle shall drive with its doors closed.\n    rationale: Nobody falls out.\n"
    "    refines: [S-1]\n    allocated_to: [DE-1]\n    owner: P-1\n    status: approved\n    asil: C\n    verified_by: [M-1, M-2]\n"
    "    verification: [analysis]\n    source: concept of the drive, 6\n"
)


_COUNTED = swap(V, "counts: [test, fault]", "counts: [test, fault, external test]")
_SECOND = "  - {stage: S-4-A, requirements: [S-4], at_least: partial}\n"


def _in_braces(name: str) -> Edit:
    """The V-model's settings as YAML in braces, with another file as the baseline."""

    def edit(root: Path) -> None:
        said = yaml.safe_load((root / V).read_text("utf-8"))
        said["project"]["baseline"] = f"requirements/{name}"
        parts = (f"{key}: {json.dumps(value, default=str)}" for key, value in said.items())
        (root / V).write_text("\n".join(parts) + "\n", "utf-8")

    return edit


def _listed(key: str) -> Callable[[dict[str, Any]], None]:
    def change(said: dict[str, Any]) -> None:
        said["content"][f"unreviewed {key}"] = {}

    return change


def _off(key: str) -> Callable[[dict[str, Any]], None]:
    def change(said: dict[str, Any]) -> None:
        del said["content"][f"unreviewed {key}"]

    return change


def _also(old: str, method: str, id_: str) -> Fault:
    """One more method under `verification`, which nothing answers."""
    edit = swap(R, f"verification: [{old}]", f"verification: [{old}, {method}]")
    return Fault(f"{method} that nothing answers", edit, "T255", f"{id_}:{method}")


def _answers_doors(held: dict[str, Any]) -> None:
    """That the planner's page is about doors, too, is in the baseline already."""
    held["content"]["evidence docs/planner.md at S-2-A"]["requirements"] = ["S-31", "S-5"]
    held["content"]["evidence docs/planner.md at S-2-A"]["unnamed"] = ["S-31", "S-5"]
    held["content"]["evidence docs/planner.md at S-2-A"]["answers"] = ["S-31: analysis", "S-5: analysis"]


def _anew(root: Path) -> None:
    """What is there is accepted in a baseline without any history."""
    (root / BASELINE).unlink()
    agreed(lambda _: None)(root)


def _by_nobody(held: dict[str, Any]) -> None:
    """One more acceptance, written by hand, that names nothing of what is less."""
    del held["content"]["requirement S-9"]
    held["acceptances"].append({**held["acceptances"][-1], "by": "", "reason": ""})


def _said_otherwise(*texts: str) -> Callable[[dict[str, Any]], None]:
    """The last acceptance, as if somebody had been told something else."""

    def change(held: dict[str, Any]) -> None:
        held["acceptances"][-1]["weaker"] = list(texts)

    return change


def _claimed_by_nobody(held: dict[str, Any]) -> None:
    """A method that a document is said to answer, in an acceptance that names nobody."""
    held["content"]["evidence docs/planner.md at S-2-A"]["methods"] = ["analysis", "review"]
    held["acceptances"].append({**held["acceptances"][-1], "by": "", "reason": "", "weaker": []})


def _taken_back(root: Path) -> None:
    """A requirement more, accepted and committed; then it is gone, and so is the version of the baseline that held it."""
    before = (root / BASELINE).read_bytes()
    more = put("requirements/doors.yaml", DOORS.encode())
    asked = swap(V, "requirements: [S-31], methods", "requirements: [S-31, S-5], methods")
    all_of(agreed(all_of(more, asked)), git("add", "."), committed("doors"))(root)
    unasked = swap(V, "requirements: [S-31, S-5], methods", "requirements: [S-31], methods")
    all_of(gone("requirements/doors.yaml"), unasked, put(BASELINE, before), committed("tidy"))(root)


#: What a project is made of, beside what is kept of it.
_PARTS = ("requirements", "specs", "docs")


def _from_a_folder(*steps: Edit, whole: bool = True) -> Edit:
    """The project was in a folder of its repository, and is moved out of it; what is done then is in one commit with that, or each step in one of its own.

    whole: of what was in the folder, nothing stays there while the steps are done.
    """

    def edit(root: Path) -> None:
        shutil.rmtree(root / ".git")
        run_git(root, "init", "-q")
        for part in _PARTS:
            moved(part, f"campus/{part}")(root)
        run_git(root, "add", "campus")
        run_git(root, "commit", "-qm", "The shuttle")
        for part in _PARTS:
            shutil.copytree(root / "campus" / part, root / part)
        if whole:
            shutil.rmtree(root / "campus")
        for step in steps:
            step(root)
            run_git(root, "add", "-A", ".")
            run_git(root, "commit", "-qm", "moved")

    return edit


#: Less is demanded, and accepted in a baseline that begins anew.
_LESS_ANEW = all_of(cut(R, "  - id: S-9\n", ""), _anew)


def _beside_another(root: Path) -> None:
    """Another project was in the repository, and is not any more when this one begins anew."""
    named = json.loads((root / BASELINE).read_text("utf-8"))
    named["content"] = {"requirement T-1": {"asil": "QM"}, "requirement S-9": {"asil": "QM"}}
    put(
        "tram/requirements/v-model.yaml",
        b"document: v-model\nproject:\n  baseline: requirements/baseline.json\n",
    )(root)
    put("tram/requirements/baseline.json", json.dumps(named).encode())(root)
    all_of(git("add", "tram"), committed("tram"), gone("tram"), committed("no tram"))(root)
    run_git(root, "rm", "-qr", "--cached", *_PARTS)
    all_of(committed("nothing"), git("add", *_PARTS), committed("again"))(root)


def _merged(
    how: str,
    *,
    beside: Edit | None = None,
    again: str = "",
    changed: Edit | None = None,
    done: bool = True,
    back: bool = False,
) -> Edit:
    """A branch, on which something may be accepted as well, that merges what was meanwhile accepted where it began, so or so.

    again: what is there after it is accepted anew, on top of the baseline of this revision: HEAD, the branch's own; MERGE_HEAD, where it began.
    changed: what is done to the baseline in the merge. done: whether that is committed. back: the branch is merged where it began.
    """

    def edit(root: Path) -> None:
        begun = run_git(root, "rev-parse", "--abbrev-ref", "HEAD").strip()
        run_git(root, "checkout", "-qb", "branch")
        all_of(add("docs/notes.md", "# Notes\n"), git("add", "."), committed("notes"))(root)
        if beside is not None:
            all_of(agreed(beside), committed("beside"))(root)
        run_git(root, "checkout", "-q", begun)
        more = put("requirements/doors.yaml", DOORS.encode())
        asked = swap(V, "requirements: [S-31], methods", "requirements: [S-31, S-5], methods")
        all_of(agreed(all_of(more, asked)), git("add", "."), committed("doors"))(root)
        run_git(root, "checkout", "-q", "branch")
        run_git(root, "merge", "-q", *how.split(), *(["--no-commit"] if again else ["-m", "merged"]), begun)
        if again:
            own = git("checkout", "-q", again, "--", BASELINE)
            all_of(own, agreed(lambda _: None), changed or (lambda _: None))(root)
        if again and done:
            committed("merged")(root)
        if back:
            run_git(root, "checkout", "-q", begun)
            run_git(root, "merge", "-q", "--no-ff", "-m", "merged back", "branch")

    return edit


def _as_a_link(root: Path) -> None:
    """The V-model as a link to a file beside the requirements, from the first commit on."""
    (root / V).rename(root / "v-model.yaml")
    (root / V).symlink_to("../v-model.yaml")
    all_of(git("add", "."), git("commit", "--amend", "-qm", "The shuttle"))(root)


def _linked_from_the_start(root: Path) -> None:
    """The baseline as a link to a file beside it, from the first commit on."""
    (root / BASELINE).rename(root / "requirements" / "accepted.json")
    (root / BASELINE).symlink_to("accepted.json")
    all_of(git("add", "."), git("commit", "--amend", "-qm", "The shuttle"))(root)


def _kept_elsewhere_from_the_start(root: Path) -> None:
    """The baseline in a store of its own, as Git LFS has them, from the first commit on: git has its hash."""
    put(".gitattributes", b"*.json filter=elsewhere\n")(root)
    kept = all_of(
        git("config", "filter.elsewhere.clean", "git hash-object --stdin"),
        git("add", "--renormalize", "."),
        git("add", "."),
    )
    all_of(kept, git("commit", "--amend", "-qm", "The shuttle"))(root)


_WITHOUT_ONE = accepted(lambda held: held["content"].pop("waiver W-1"), rehash=True)


def _by_what_nobody_sees(root: Path) -> None:
    """An acceptance by a space of no width, which is none."""
    who = ("--by", "\u200b", "--reason", "\u3164.", "--day", TODAY.isoformat())
    assert command(root, "trace", "--accept-baseline", *who)[0] == 2


def _cut_off(root: Path) -> None:
    """A history of one commit, as a file on this machine says."""
    head = run_git(root, "rev-parse", "HEAD")
    put(".git/info/grafts", head.encode())(root)


_ANALYSIS = swap(R, "verification: [test, fault injection]\n    metrics: [braking]", "verification: [test, fault injection, analysis]\n    metrics: [braking]")  # fmt: skip
_STRUCK = cut(R, "  - id: S-9\n", "")
_STRUCK_BY_HAND = all_of(
    _STRUCK, accepted(lambda held: held["content"].pop("requirement S-9"), rehash=True), committed("tidy")
)
_STRUCK_BY_HAND_THERE = all_of(
    _STRUCK, accepted(lambda held: held["content"].pop("requirement S-9"), rehash=True)
)
_ONE_MORE = all_of(
    agreed(
        add(
            "specs/rules.spec",
            '\ntest braking "soft"\n  given  plan = { v: [5 m/s, 4 m/s], a: [-2 m/s^2, 0 m/s^2] }\n  expect satisfied\n',
        )
    ),
    committed("one more test"),
)
_ANOTHER_REASON = swap(
    R,
    "not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [test, scenario]",
    "not_verified_by: {M-2: It takes long.}\n    verification: [test, scenario]",
)
_ADOPTED = swap(
    R, "    derived_from: [SH-RO]\n", "    derived_from: [SH-RO]\n    adopted: The campus asks for it.\n"
)
_OWN_WORDS = "  denials: [steht|stehen noch aus]\n"
_OWN = swap(V, "  campaigns:", f"{_OWN_WORDS}  campaigns:")
_REVIEWED = swap(A, "works:\n", f"{REVIEW}works:\n")
_ANALYSED = swap(A, "works:\n", f"{ANALYSED}works:\n")
_SHARED = put("docs/independence.md", b"# Independence\n\nPlanner and supervisor share one computer.\n")

# fmt: off
#: A page that is said to answer a method of one requirement, and none of another one.
_TWO_ENTRIES = all_of(
    add("docs/planner.md", "\nS-32 is met by that, too.\n"),
    swap(
        V,
        "methods: [analysis]}\n",
        "methods: [analysis]}\n  - {path: docs/planner.md, title: And how it is watched, stage: S-2-A, requirements: [S-32]}\n",
    ),
    swap(V, "applies_to: [S-31]", "applies_to: [S-31, S-32]"),
)
def _laundered(root: Path) -> None:
    """Less was accepted by name; a branch has it in its baseline by hand, has an acceptance of something else written on top of that, and takes the name away when it is merged."""
    begun = run_git(root, "rev-parse", "--abbrev-ref", "HEAD").strip()
    less, by_hand = cut(R, "  - id: S-9\n", ""), accepted(lambda held: held["content"].pop("requirement S-9"), rehash=False)
    run_git(root, "checkout", "-qb", "branch")
    on_top = accepted(lambda held: held["acceptances"].append({**held["acceptances"][-1], "weaker": []}), rehash=True)
    all_of(less, by_hand, committed("less"), on_top, committed("more"))(root)
    run_git(root, "checkout", "-q", begun)
    all_of(agreed(less), committed("less, by name"))(root)
    run_git(root, "merge", "-q", "--no-commit", "-X", "theirs", "branch")
    all_of(git("checkout", "-q", "MERGE_HEAD", "--", BASELINE), committed("merged"))(root)


FAULTS = [
    Fault("one requirement more of a page that answers a method", all_of(_ANALYSIS, swap(V, "requirements: [S-31], methods", "requirements: [S-31, S-2], methods")), "T373", "docs/planner.md at S-2-A"),
    Fault("a method of one entry of a page, and not of another one of it, answered by both", all_of(agreed(_TWO_ENTRIES), swap(V, "requirements: [S-32]}\n", "requirements: [S-32], methods: [analysis]}\n")), "T373", "docs/planner.md at S-2-A"),
    Fault("two entries of a page made one, which answers the method of either", all_of(agreed(_TWO_ENTRIES), swap(V, "requirements: [S-31], methods", "requirements: [S-31, S-32], methods"), cut(V, "  - {path: docs/planner.md, title: And", "gate:\n")), "T373", "docs/planner.md at S-2-A"),
    Fault("one requirement more of an analysis", all_of(_ANALYSIS, swap(A, "of: [S-3]", "of: [S-3, S-2]")), "T373", "AN-1"),
    Fault("accepted by a name that nobody sees", all_of(_STRUCK, _by_what_nobody_sees), "T223", "S-9"),
    Fault("found open after it was accepted", all_of(agreed(_REVIEWED), swap(A, "works:\n", f"{REVIEW.replace('RV-2', 'RV-5').replace('2026-05-01', '2026-05-02').replace('accepted', 'open')}works:\n")), "T382", "S-1"),
    Fault("a review before what it is of was made", swap(A, "works:\n", f"{ANALYSED.replace('2026-05-01', '2026-01-01')}works:\n"), "T165", "RV-3"),
    Fault("an analysis made anew since it was reviewed", all_of(agreed(_ANALYSED), agreed(all_of(_SHARED, swap(A, "made: 2026-02-10", "made: 2026-05-20")))), "T167", "RV-3", status=0),
    Fault("a baseline that is a link from the first commit", _linked_from_the_start, "T380", rerun=True),
    Fault("a baseline that git has the hash of, from the first commit on, and an entry removed", all_of(_kept_elsewhere_from_the_start, _WITHOUT_ONE, committed("tidy")), "T380", rerun=True),
    Fault("a baseline of which git had the hash alone before it had what is here", all_of(_kept_elsewhere_from_the_start, put(".gitattributes", b""), git("add", "--renormalize", "."), committed("in git")), "T381", rerun=True, status=0),
    # methods: each kind that comes with the program
    _also("test, scenario", "review", "S-1"),
    _also("test, scenario", "analysis", "S-1"),
    _also("test, scenario", "fault injection", "S-1"),
    _also("test, scenario", "field run", "S-1"),
    _also("test, scenario", "monitor", "S-1"),
    _also("monitor", "measurement", "S-4"),
    _also("monitor", "back-to-back test", "S-4"),
    Fault("tests that nothing answers", swap(R, "asil: A(C)\n    verification: [analysis]", "asil: A(C)\n    verification: [analysis, test]"), "T255", "S-31:test"),
    Fault("tests on the boundary that nothing answers", swap(R, "asil: A(C)\n    verification: [analysis]", "asil: A(C)\n    verification: [analysis, boundary test]"), "T255", "S-31:boundary test"),
    Fault("scenarios that nothing answers", swap(R, "asil: A(C)\n    verification: [analysis]", "asil: A(C)\n    verification: [analysis, scenario]"), "T255", "S-31:scenario"),
    # a baseline that begins anew, with what is there now
    Fault("another file named as the baseline", agreed(swap(V, "baseline: requirements/baseline.json", "baseline: requirements/accepted.json")), "T380", rerun=True),
    Fault("another file named as the baseline, committed", all_of(agreed(swap(V, "baseline: requirements/baseline.json", "baseline: requirements/accepted.json")), git("add", "."), committed("tidy")), "T380", rerun=True),
    Fault("another file named as the baseline, the V-model a link", all_of(_as_a_link, agreed(swap("v-model.yaml", "baseline: requirements/baseline.json", "baseline: requirements/accepted.json")), git("add", "."), committed("tidy")), "T380", rerun=True),
    Fault("another file named as the baseline, always written in braces", all_of(_in_braces("baseline.json"), git("add", "."), git("commit", "--amend", "-qm", "The shuttle"), agreed(_in_braces("accepted.json")), git("add", "."), committed("tidy")), "T380", rerun=True),
    Fault("the baseline removed in one commit, and accepted anew in another", all_of(gone(BASELINE), committed("tidy"), agreed(lambda root: None), git("add", "."), committed("again")), "T380", rerun=True),
    Fault("the baseline emptied in one commit, and accepted anew in another", all_of(put(BASELINE, b""), committed("tidy"), gone(BASELINE), agreed(lambda root: None), git("add", "."), committed("again")), "T380", rerun=True),
    Fault("the baseline of another version in one commit, and accepted anew in another", all_of(put(BASELINE, b'{"format": "trackmarshal-baseline", "version": 1}'), committed("tidy"), _anew, git("add", "."), committed("again")), "T380", rerun=True),
    Fault("the baseline removed and accepted anew, behind a history put in place of what is recorded", all_of(gone(BASELINE), committed("tidy"), agreed(lambda root: None), git("add", "."), committed("again"), git("replace", "--graft", "HEAD")), "T380", rerun=True),
    Fault("the baseline removed and accepted anew, behind a history that a file of grafts cuts off", all_of(gone(BASELINE), committed("tidy"), agreed(lambda root: None), git("add", "."), committed("again"), _cut_off), "T380", rerun=True),
    Fault("another folder of the repository, and a baseline that begins anew there", _from_a_folder(_LESS_ANEW), "T380", rerun=True),
    Fault("another folder of the repository, the project removed in a commit before", _from_a_folder(gone(*_PARTS), all_of(git("checkout", "-q", "HEAD~1", "--", "campus"), *(moved(f"campus/{part}", part) for part in _PARTS), _LESS_ANEW)), "T380", rerun=True),
    Fault("another folder of the repository, the project removed in a commit afterwards", _from_a_folder(_LESS_ANEW, gone("campus"), whole=False), "T380", rerun=True),
    Fault("another folder of the repository, the baseline removed in a commit before", _from_a_folder(gone("campus/" + BASELINE, *_PARTS), all_of(*(moved(f"campus/{part}", part) for part in _PARTS), cut(R, "  - id: S-9\n", ""), agreed(lambda _: None)), whole=False), "T380", rerun=True),
    Fault("another folder of the repository, and a baseline only in a commit afterwards", _from_a_folder(all_of(gone(BASELINE), swap(V, "  baseline: requirements/baseline.json\n", "")), all_of(swap(V, "  default_spec: specs\n", "  default_spec: specs\n  baseline: requirements/baseline.json\n"), cut(R, "  - id: S-9\n", ""), agreed(lambda _: None))), "T380", rerun=True),
    Fault("another folder of the repository, and an entry of the baseline removed", _from_a_folder(_STRUCK_BY_HAND_THERE), "T380", rerun=True),
    Fault("the baseline taken back over an acceptance", _taken_back, "T380", rerun=True),
    Fault("the baseline taken back over an acceptance, and one more commit", all_of(_taken_back, add("docs/planner.md", ""), git("commit", "--allow-empty", "-qm", "more")), "T380", rerun=True),
    Fault("a requirement struck by an acceptance that names nothing", all_of(_STRUCK, accepted(_by_nobody, rehash=True), committed("tidy")), "T380", rerun=True),
    Fault("a requirement struck by somebody, for no reason", all_of(agreed(_STRUCK), accepted(lambda held: held["acceptances"][-1].update(reason="..."), rehash=False), committed("tidy")), "T380", rerun=True),
    Fault("an acceptance of less taken back, with all that it was about", all_of(agreed(_STRUCK), committed("less"), git("checkout", "HEAD~1", "--", BASELINE, R), committed("tidy")), "T380", rerun=True),
    Fault("the baseline taken back over an acceptance, and something else accepted on top of it", all_of(_taken_back, _ONE_MORE), "T380", rerun=True),
    Fault("a requirement struck with its entry, and something else accepted on top of it", all_of(_STRUCK_BY_HAND, _ONE_MORE), "T380", rerun=True),
    Fault("a requirement struck with its entry, and two things accepted on top of it", all_of(_STRUCK_BY_HAND, _ONE_MORE, agreed(add("docs/planner.md", "\nmore\n")), committed("more")), "T380", rerun=True),
    Fault("an acceptance of something else of the same entry", all_of(agreed(swap(V, "{satisfied: 1, violated: 1, boundary: 1}", "{satisfied: 0, violated: 0, boundary: 0}")), accepted(_said_otherwise("project: in its denials nothing of weight changed"), rehash=False)), "T380", rerun=True),
    Fault("an acceptance of less than was struck", all_of(agreed(swap(R, "verification: [test, scenario]", "verification: [review]")), accepted(_said_otherwise("requirement S-1: in its verification `test` left", "unreviewed requirement S-1 is new"), rehash=False)), "T380", rerun=True),
    Fault("an acceptance of another value", all_of(agreed(swap(V, "{satisfied: 1, violated: 1, boundary: 1}", "{satisfied: 1, violated: 1, boundary: 0}")), accepted(_said_otherwise("project: its boundary tests a rule changed from 2 to 1"), rehash=False)), "T380", rerun=True),
    Fault("an acceptance dropped by a merge", _merged("-s ours"), "T380", rerun=True),
    Fault("an acceptance dropped by a branch that is merged where it began", _merged("-s ours", beside=add("docs/planner.md", "\nmore\n"), again="HEAD", back=True), "T380", rerun=True),
    Fault("another name under an acceptance of a branch that is merged where it began", _merged("-X theirs", beside=add("docs/planner.md", "\nmore\n"), again="HEAD", changed=accepted(lambda held: held["acceptances"][-2].update(by="Eve Else"), rehash=False), back=True), "T380", rerun=True),
    Fault("a name taken away from what was accepted, by a branch that has it by hand", _laundered, "T380", rerun=True),
    Fault("an acceptance dropped by a merge, beside another one", _merged("-s ours", beside=add("docs/planner.md", "\nmore\n")), "T380", rerun=True),
    # a demand taken away that stood beside another one on its stage
    Fault("a demand of two on a stage", all_of(agreed(swap(V, "[S-32, S-4], at_least: partial}", "[S-32], at_least: partial}\n" + _SECOND.rstrip())), swap(V, _SECOND, "")), "T371", "S-4-A, partial"),
    # a report for which methods would wait as long as it is missing
    Fault("a report that may be missing", all_of(agreed(all_of(_COUNTED, ran("fast"))), swap(V, "  campaigns:", f"  junit: [{{path: {REPORT}, stage: S-3-B, if_there: true}}]\n  campaigns:")), "T373", f"{REPORT} at S-3-B"),
    Fault("one more method of a report that may be missing", all_of(agreed(all_of(REPORTED, ran("fast"))), swap(V, "if_there: true}", "if_there: true, methods: [review]}")), "T373", f"{REPORT} at S-3-B"),
    # evidence of a kind taken away, and what remains when somebody accepted that
    Fault("evidence that is said to be a review", swap(V, "methods: [analysis]", "methods: [analysis, review]"), "T373", "docs/planner.md at S-2-A"),
    Fault("a page that names what it is evidence of where nobody sees it", all_of(put("docs/brakes.md", b"# Brakes\n\nThey brake.\n\n<!-- S-2 -->\n"), swap(V, "methods: [analysis]}", "methods: [analysis]}\n  - {path: docs/brakes.md, title: Brakes, stage: S-2-B, requirements: [S-2]}")), "T373", "docs/brakes.md at S-2-B"),
    Fault("a page that is evidence of what it does not name", swap(V, "methods: [analysis]}", "methods: [analysis]}\n  - {path: docs/planner.md, title: The same, stage: S-2-B, requirements: [S-2]}"), "T373", "docs/planner.md at S-2-B"),
    Fault("a page that is evidence of one requirement more, which it does not name", all_of(agreed(all_of(put("docs/clear.md", b"# Clear\n\nS-31 is met: 3 m/s^2 are asked for.\n"), swap(V, "applies_to: [S-31]", "applies_to: [S-31, S-32]"), swap(V, "methods: [analysis]}", "methods: [analysis]}\n  - {path: docs/clear.md, title: Clear, stage: S-2-A, requirements: [S-31]}"))), swap(V, "title: Clear, stage: S-2-A, requirements: [S-31]", "title: Clear, stage: S-2-A, requirements: [S-31, S-32]")), "T373", "docs/clear.md at S-2-A"),
    Fault("evidence that is said to be a review by a second entry", swap(V, "methods: [analysis]}", "methods: [analysis]}\n  - {path: docs/planner.md, title: The same, stage: S-2-B, requirements: [S-31], methods: [review]}"), "T373", "docs/planner.md at S-2-B"),
    Fault("evidence that is said to be a review, accepted by nobody", all_of(swap(V, "methods: [analysis]", "methods: [analysis, review]"), accepted(_claimed_by_nobody, rehash=True), committed("more")), "T380", rerun=True),
    Fault("evidence that is no analysis any more", swap(V, ", methods: [analysis]", ""), "T373", "docs/planner.md at S-2-A"),
    Fault("evidence that is no analysis any more, accepted", agreed(swap(V, ", methods: [analysis]", "")), "T255", "S-31:analysis"),
    Fault("evidence of another method", swap(V, "methods: [analysis]", "methods: [review]"), "T373", "docs/planner.md at S-2-A"),
    Fault("evidence of another method, accepted", agreed(swap(V, "methods: [analysis]", "methods: [review]")), "T255", "S-31:analysis"),
    Fault("evidence of a method that there is not", swap(V, "methods: [analysis]", "methods: [analysis, faith]"), "T123"),
    Fault("an analysis that leaves something open", swap(A, "    made: 2026-02-10\n", "    made: 2026-02-10\n    open: [Both have one clock.]\n"), "T376", "AN-1"),
    Fault("an analysis that leaves something open, accepted", agreed(swap(A, "    made: 2026-02-10\n", "    made: 2026-02-10\n    open: [Both have one clock.]\n")), "T255", "S-3:analysis"),
    Fault("the fault of a requirement struck, accepted", agreed(cut(F, "  - id: F-2\n", "")), "T255", "S-32:fault injection"),
    # pages that say that they are no evidence
    Fault("evidence that holds a place", put("docs/sensors.md", b"# Sensors\n\nThis page is a placeholder.\n"), "T253", "A-SEEN"),
    Fault("evidence that is still to come", put("docs/sensors.md", b"# Sensors\n\nThe latency has **not yet been\nmeasured**.\n"), "T253", "A-SEEN"),
    Fault("evidence that says so in words of the project", all_of(_OWN, put("docs/sensors.md", b"# Sensors\n\nDer Bericht steht noch aus.\n")), "T253", "A-SEEN"),
    Fault("a phrase of the project struck", all_of(agreed(_OWN), swap(V, _OWN_WORDS, "")), "T371"),
    Fault("a phrase that is none", swap(V, "  campaigns:", "  denials: ['|']\n  campaigns:"), "T124"),
    Fault("a method of another name", swap(R, "verification: [test, scenario]", "verification: [test, scenarios]"), "T123"),
    Fault("a fault that changes nothing, for faults that are put in", all_of(swap(R, "verification: [test, scenario]", "verification: [test, scenario, fault injection]"), add(F, "  - id: F-3\n    title: Nothing at all\n    requirement: S-1\n    begin: 0.1\n    end: 0.2\n    change: []\n    expect: {}\n")), "T255", "S-1:fault injection"),
    # reviews: the list is closed
    Fault("a hazard that nobody reviewed", swap(H, "safety_goals:\n", f"{CLOSING}safety_goals:\n"), "T382", "HZ-2"),
    Fault("a requirement that nobody reviewed", all_of(put("requirements/doors.yaml", DOORS.encode()), swap(V, "requirements: [S-31], methods", "requirements: [S-31, S-5], methods"), accepted(_answers_doors, rehash=True)), "T382", "S-5"),
    Fault("a goal that nobody reviewed", all_of(swap(R, "derived_from: [SH-RO]\n    achieves: [SG-1]", "derived_from: [SH-RO]\n    achieves: [SG-1, SG-2]"), add(H, "  - {id: SG-2, title: Slowly, statement: The shuttle shall not hit anybody hard., prevents: [HZ-1], asil: C, safe_state: at rest, tolerance: 1 s}\n")), "T382", "SG-2"),
    Fault("an analysis that nobody reviewed", swap(A, "reviews:\n", "  - {id: AN-2, title: Braking, method: timing, of: [S-2], by: [P-2], made: 2026-02-11}\nreviews:\n"), "T382", "AN-2"),
    Fault("the rationale of what was reviewed", swap(R, "rationale: Running into somebody is the harm.", "rationale: None at all."), "T382", "S-3"),
    Fault("the source of what was reviewed", swap(R, "source: concept of the drive, 4\n", "source: a talk over lunch\n"), "T382", "S-3"),
    Fault("one more method for what was reviewed", all_of(agreed(_REVIEWED), swap(R, "verification: [test, scenario]", "verification: [test, boundary test, scenario]")), "T382", "S-1"),
    Fault("the rationale of a hazard that was reviewed, accepted", all_of(agreed(swap(A, "works:\n", f"{RATED}works:\n")), agreed(swap(H, "it drives all day;", "it drives on Sundays;"))), "T167", "RV-4", status=0),
    Fault("the text of what was reviewed", swap(R, "keep enough room to stop behind", "keep some metres behind"), "T225", "S-3"),
    Fault("the text of what was reviewed, accepted before it was on the list", all_of(agreed(swap(R, "keep enough room to stop behind", "keep ten metres behind")), accepted(_off("requirement S-3"), rehash=True)), "T382", "S-3"),
    Fault("the document of an analysis that was reviewed", all_of(agreed(_ANALYSED), _SHARED), "T373", "AN-1"),
    Fault("the document of an analysis that was reviewed, accepted before it was on the list", all_of(agreed(all_of(_ANALYSED, _SHARED)), accepted(_off("analysis AN-1"), rehash=True)), "T382", "AN-1"),
    Fault("a hazard that was reviewed, rated otherwise and accepted", all_of(agreed(swap(A, "works:\n", f"{RATED}works:\n")), agreed(all_of(swap(H, "exposure: E4", "exposure: E3"), swap(H, "    asil: C\n    rationale", "    asil: B\n    rationale")))), "T167", "RV-4", status=0),
    Fault("somebody who answers for something, of another name", swap(A, "title: Ola Observer", "title: Ola Other"), "T153", "A-SEEN"),
    Fault("a reviewer of another name", swap(A, "title: Vera Verifier", "title: Prof. Important"), "T376", "P-4"),
    Fault("another thing that an indicator counts", swap(A, "title: refused plans", "title: sunny days"), "T376", "SPI-1"),
    Fault("another reason for which a method is not used", _ANOTHER_REASON, "T376", "S-1"),
    Fault("another reason for which a requirement is adopted", all_of(agreed(_ADOPTED), swap(R, "The campus asks for it.", "x")), "T376", "S-1"),
    Fault("a review with another hash", swap(A, "cc44ee222fd73c84", "cc44ee222fd73c80"), "T376", "RV-1"),
    Fault("reviewed, accepted, and the review struck", all_of(agreed(_REVIEWED), cut(A, "  - id: RV-2\n", "works:\n")), "T376", "RV-2"),
    Fault("a baseline with two contents", remade(BASELINE, lambda data: data.replace(b'"content": {', b'"content": {}, "content": {', 1)), "T220"),
    Fault("an entry struck from the list", accepted(_off("requirement S-1"), rehash=False), "T379"),
    Fault("an entry struck from the list, its hash made again", accepted(_off("requirement S-1"), rehash=True), "T382", "S-1"),
    Fault("an entry put on the list by hand", all_of(swap(H, "safety_goals:\n", f"{CLOSING}safety_goals:\n"), accepted(_listed("hazard HZ-2"), rehash=False)), "T379"),
    Fault("an entry put on the list by hand, its hash made again", all_of(swap(H, "safety_goals:\n", f"{CLOSING}safety_goals:\n"), accepted(_listed("hazard HZ-2"), rehash=True)), "T380", rerun=True),
]
EDITS = [
    Harmless("the baseline moved with all that was accepted", all_of(swap(V, "baseline: requirements/baseline.json", "baseline: requirements/accepted.json"), moved(BASELINE, "requirements/accepted.json"), git("add", "."), committed("moved"))),
    Harmless("another folder of the repository, with all that was accepted", _from_a_folder(add("docs/notes.md", "# Notes\n"))),
    Harmless("another folder of the repository, and something accepted", _from_a_folder(agreed(cut(R, "  - id: S-9\n", "")))),
    Harmless("another project in the repository, which is gone", _beside_another),
    Harmless("the baseline with the ends of lines of Windows", remade(BASELINE, lambda data: data.replace(b"\n", b"\r\n"))),
    Harmless("the baseline taken back over an acceptance, restored, and less accepted by name", all_of(_taken_back, git("checkout", "HEAD~1", "--", BASELINE), agreed(lambda root: None), committed("less, by name"))),
    Harmless("a requirement struck with its entry, there again, and struck by name", all_of(_STRUCK_BY_HAND, git("checkout", "HEAD~1", "--", R), agreed(lambda root: None), committed("there again"), agreed(_STRUCK), committed("less, by name"))),
    Harmless("an acceptance merged", _merged("")),
    Harmless("acceptances of two branches, and one more of both", _merged("-X theirs", beside=add("docs/planner.md", "\nmore\n"), again="HEAD")),
    Harmless("acceptances of two branches, and one more of both, merged where they began", _merged("-X theirs", beside=add("docs/planner.md", "\nmore\n"), again="HEAD", back=True)),
    Harmless("acceptances of two branches, and one more on top of the other's", _merged("-X theirs", beside=add("docs/planner.md", "\nmore\n"), again="MERGE_HEAD")),
    Harmless("acceptances of two branches, and one more on top of the other's, not committed", _merged("-X theirs", beside=add("docs/planner.md", "\nmore\n"), again="MERGE_HEAD", done=False)),
    Harmless("acceptances of two branches, and one more on top of the other's, merged where they began", _merged("-X theirs", beside=add("docs/planner.md", "\nmore\n"), again="MERGE_HEAD", back=True)),
    Harmless("less accepted twice, and more again, in one commit", all_of(agreed(swap(R, "verification: [test, scenario]", "verification: [test]")), agreed(swap(V, "boundary: 1", "boundary: 0")), agreed(swap(V, "satisfied: 1, ", "satisfied: 0, ")), committed("less"))),
    Harmless("a report that may be missing, accepted when nobody was asked for a name", all_of(agreed(all_of(REPORTED, ran("fast"))), accepted(lambda held: held["acceptances"][-1].update(weaker=[one for one in held["acceptances"][-1]["weaker"] if "report" not in one]), rehash=False), committed("report"))),
    Harmless("a baseline of before, which does not hold what a page does not name", accepted(lambda held: held["content"]["evidence docs/planner.md at S-2-A"].pop("unnamed"), rehash=True)),
    Harmless("two entries of a page with the same methods made one", all_of(agreed(all_of(_TWO_ENTRIES, swap(V, "requirements: [S-32]}\n", "requirements: [S-32], methods: [analysis]}\n"))), swap(V, "requirements: [S-31], methods", "requirements: [S-31, S-32], methods"), cut(V, "  - {path: docs/planner.md, title: And", "gate:\n"))),
    Harmless("a page somewhere else since a baseline of before", all_of(accepted(lambda held: held["content"]["evidence docs/planner.md at S-2-A"].pop("answers"), rehash=True), moved("docs/planner.md", "docs/of/planner.md"), swap(V, "path: docs/planner.md", "path: docs/of/planner.md"))),
    Harmless("one more review", _REVIEWED),
    Harmless("methods of what was reviewed in another order, and another title", all_of(agreed(_REVIEWED), swap(R, "verification: [test, scenario]", "verification: [scenario, test]"), swap(R, "title: Permitted speed", "title: Speed"))),
    Harmless("a review of an analysis", _ANALYSED),
    Harmless("a method that is answered already", swap(R, "verification: [test, scenario]", "verification: [test, boundary test, scenario]")),
    Harmless("a hazard that nobody reviewed, accepted by name", agreed(swap(H, "safety_goals:\n", f"{CLOSING}safety_goals:\n"))),
    Harmless("phrases of the project", _OWN),
    Harmless("methods in another order", swap(R, "verification: [test, scenario]", "verification: [scenario, test]")),
]
# fmt: on
