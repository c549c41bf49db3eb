"""What has to be made, read or judged again, each with the reason."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from trackmarshal.trace import faults
from trackmarshal.trace.baseline import Baseline, carried, changes
from trackmarshal.trace.external import STALE
from trackmarshal.trace.graph.graph import Key
from trackmarshal.trace.graph.said import called
from trackmarshal.trace.impact.resting import resting, rests_on
from trackmarshal.trace.impact.version import Version
from trackmarshal.trace.spec import changed as differing

#: What is to be done with nodes of a kind that rest on something that changed, or changed themselves. Tests, runs and faults are told by what they
#: are made from.
_DO = {
    "requirement": "compare", "issue": "compare", "hazard": "compare", "safety goal": "compare", "design element": "compare", "rule": "compare",
    "assumption": "compare", "code": "compare", "waiver": "compare", "external test": "run", "document": "read", "analysis": "make", "review": "review",
}  # fmt: skip
#: Why something that the other version does not tell has to be made again.
_UNKNOWN = "what it was made from then is not known"


class Task(NamedTuple):
    """Something to be done again. key: of the node; do: one of DOING; why: in words; made: a result of what there is now is there already."""

    key: Key
    do: str
    why: str
    made: bool = False


#: What is to be done, in words.
DOING = {
    "compare": "look again at", "run": "run", "put in": "put in", "import": "make from its log", "read": "read", "make": "make",
    "review": "make anew", "accept": "accept by name in",
}  # fmt: skip


#: So many changes are named that may weaken what the baseline holds.
_NAMED = 10


def tasks(before: Version, now: Version, hit: Collection[Key], baseline: Baseline | None) -> Iterator[Task]:
    """All of them, in no order. hit: the nodes that changed; what `before` has wrong in its specs makes all that is made from specs unknown."""
    dark = bool(before.wrong)
    yield from _tests(before, now, dark)
    yield from _runs(before, now, dark)
    yield from _faults(before, now, dark)
    done: set[Key] = set()
    for task in (*_themselves(before, now, hit, dark), *_resting(now, hit), *_ran_otherwise(now)):
        if task.key not in done:
            done.add(task.key)
            yield task
    if baseline is not None:
        weaker = [
            one for one in changes(baseline.content, carried(baseline.content, now.content, {})) if one.weaker
        ]
        if weaker:
            said = "1 change" if len(weaker) == 1 else f"{len(weaker)} changes"
            left = [f"and {len(weaker) - _NAMED} more"] if len(weaker) > _NAMED else []
            yield Task(
                ("baseline", str(now.project.baseline)),
                "accept",
                f"{said} may weaken what it holds: {'; '.join([*map(str, weaker[:_NAMED]), *left])}",
            )


def _why(before: Mapping[str, str] | None, now: Mapping[str, str], dark: bool) -> str:
    """Why something made from these inputs has to be made again; empty where it has not."""
    if dark:
        return _UNKNOWN
    return "new" if before is None else differing(before, now)


def _tests(before: Version, now: Version, dark: bool) -> Iterator[Task]:
    for (rule, title), test in now.spec.first_tests.items():
        item, old = now.spec.by_name.get(rule), before.spec.first_tests.get((rule, title))
        was = before.spec.by_name.get(rule)
        if item is None:
            continue  # a test of nothing, which is a finding
        inputs = None if old is None or was is None else old.made_from(was.inputs, before.engine(now))
        why = _why(inputs, test.made_from(item.inputs, now.spec.engine), dark)
        if why:
            result = now.spec.results.get((rule, title))
            yield Task(
                ("test", f"{rule}: {title}"),
                "run",
                why,
                result is not None and not now.spec.staleness(result),
            )


def _runs(before: Version, now: Version, dark: bool) -> Iterator[Task]:
    kept = {str(scenario.path) for scenario in now.project.scenarios if scenario.kept}
    for path, inputs in now.spec.run_inputs.items():
        was = before.spec.run_inputs.get(path)
        if was is not None and "engine" in was:
            was = {**was, "engine": before.engine(now)}
        why = _why(was, inputs, dark)
        if why:
            run = now.spec.runs.get(path)
            made = run is not None and not now.spec.run_staleness(run, now.hashes.get(path))
            yield Task(("run", path), "import" if path in kept else "run", why, made)


def _faults(before: Version, now: Version, dark: bool) -> Iterator[Task]:
    old = {(case.campaign, case.id): case for case in before.spec.faults}
    for case in now.spec.faults:
        was = old.get((case.campaign, case.id))
        same = was is not None and was.fingerprint == case.fingerprint
        if case.open or (same and not dark and before.engine(now) == now.spec.engine):
            continue
        why = (
            _UNKNOWN
            if dark
            else "new"
            if was is None
            else "the engine has changed since"
            if same
            else "the specs, the recording or the fault have changed since"
        )
        status, _ = faults.verdict(case, now.spec)
        yield Task(("fault", f"{case.campaign} {case.id}"), "put in", why, status in ("covered", "failed"))


def _themselves(before: Version, now: Version, hit: Collection[Key], dark: bool) -> Iterator[Task]:
    """What changed, and is itself something that somebody judged."""
    for name, item in now.spec.by_name.items():
        was = before.spec.by_name.get(name)
        key = ("rule" if item.kind == "rule" else "assumption", name)
        why = _why(None if was is None else was.inputs, item.inputs, dark)
        if why or key in hit:
            yield Task(key, "compare", why or "it has changed since")
    for key in sorted(hit):
        if key[0] in ("document", "analysis", "review", "waiver", "external test") and key in now.graph.nodes:
            yield Task(key, _DO[key[0]], "it has changed since, or is new")


def _resting(now: Version, hit: Collection[Key]) -> Iterator[Task]:
    """What rests directly on something that changed, and what was reviewed in another version. Whether more follows shows when it has been judged."""
    for changed in sorted(hit):
        for key in resting(now.graph, changed):
            # Of what was reviewed, what the fingerprint says counts: the gate holds a review by that, whatever else changed.
            if (
                key[0] in _DO
                and key[0] != "review"
                and key in now.graph.nodes
                and now.graph.nodes[key].demanded
            ):
                yield Task(key, _DO[key[0]], f"{called(changed)} has changed since")
    for link in now.graph.of_kind("reviews"):
        if link.state == "outdated":
            what = "has changed since" if link.target in hit else "is not what was reviewed"
            yield Task(link.source, "review", f"{called(link.target)} {what}")
    for changed in sorted(hit):  # code that was changed is what tests of it confirm
        for requirement in rests_on(now.graph, changed) if changed[0] == "code" else ():
            for link in now.graph.into(requirement):
                if link.kind == "confirms":
                    yield Task(
                        link.source,
                        "run",
                        f"{called(changed)}, which implements {called(requirement)}, has changed since",
                    )


def _ran_otherwise(now: Version) -> Iterator[Task]:
    """Tests of other runners whose result is of another version of their file: a report is of no revision, and may be the one of then."""
    for node in now.graph.by_kind.get("external test", ()):
        if node.attributes["outcome"] == STALE:
            yield Task(node.key, "run", node.title)


__all__ = ["DOING", "Task", "tasks"]
