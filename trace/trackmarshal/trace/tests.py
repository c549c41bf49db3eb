"""Tests of rules: every rule has them, on both sides of its boundary and on it, and what came of them is known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.records.specs import SpecItem, SpecTest
from trackmarshal.records.tests import apart, not_on_it
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error, warning
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec, item_place


def check(project: Project, spec: Spec) -> Iterator[Finding]:
    """What is wrong with tests and their results (T211 to T218)."""
    for item in spec.by_name.values():
        if item.monitored or item.kind == "rule":
            yield from _item(item, dict(project.tests_per_rule), spec)
    first: dict[tuple[str, str], SpecTest] = {}
    not_run: list[SpecTest] = []
    for test in spec.tests:
        key = (test.rule, test.title)
        if test.rule not in spec.by_name:
            help_ = did_you_mean(test.rule, spec.by_name)
            yield error(
                "T213", f"a test of `{test.rule}`, which does not exist", item_place(test), help_, test.rule
            )
        if key in first:
            also = ((item_place(first[key]), "the other one"),)
            message = f'two tests of `{test.rule}` are called "{test.title}"; a result of one cannot be told from the other\'s'
            yield Finding(
                "T214", "error", message, item_place(test), "give it a title of its own", test.rule, also, (f"{test.rule}: {test.title}",)
            )  # fmt: skip
        elif key not in spec.results:
            not_run.append(test)
        first.setdefault(key, test)
    yield from _results(spec, set(first))
    if not_run:
        said = "1 test has" if len(not_run) == 1 else f"{len(not_run)} tests have"
        message = f"{said} not been run, which counts as not covered"
        yield warning("T218", message, item_place(not_run[0]), "run `trackmarshal assess`")


def _item(item: SpecItem, needs: dict[str, int], spec: Spec) -> Iterator[Finding]:
    tests = spec.tests_of.get(item.name, [])
    said = f"the {'rule' if item.kind == 'rule' else 'monitor of'} `{item.name}`"
    if not tests and any(needs.values()):
        yield error(
            "T211", f"{said} has no test", item_place(item), f'write one: `test {item.name} "..."`', item.name
        )
        return
    tests, again = apart(tests, lambda test: test.fingerprint)
    on_it, beside = _on_boundary(tests, spec)
    have = {
        "satisfied": sum(test.expects == "satisfied" for test in tests),
        "violated": sum(test.expects == "violated" for test in tests),
        "boundary": on_it,
    }
    wording = {
        "satisfied": "that expects `satisfied`",
        "violated": "that expects `violated`",
        "boundary": "exactly on its boundary",
    }
    for verdict, number in needs.items():
        if have[verdict] < number and (verdict != "boundary" or item.compares):
            if number == 1:
                counted = f"no test {wording[verdict]}"
            else:
                counted = f"{have[verdict]} of {number} tests {wording[verdict].replace('expects', 'expect')}"
                counted = "; ".join([counted, *again])
            help_ = "a rule is tested on both sides of its boundary and, where it compares numbers, on it"
            if verdict == "boundary":
                counted = "; ".join([counted, *beside])
            yield error("T212", f"{said} has {counted}", item_place(item), help_, item.name)


def _on_boundary(tests: Sequence[SpecTest], spec: Spec) -> tuple[int, list[str]]:
    """How many tests stand on the boundary of their rule, and why others that expect a margin of about 0 do not.

    Of what was not run, or is stale, it is only known what it expects; that it has to be run is said elsewhere.
    """
    number, beside = 0, []
    for test in tests:
        result = spec.results.get((test.rule, test.title))
        unmoved = "" if result is None or spec.staleness(result) else result.unmoved
        why = (
            not_on_it(test.title, test.boundary, test.distance, test.within, unmoved) if test.distance else ""
        )
        if why:
            beside.append(why)
        number += bool(test.boundary and not why)
    return number, beside


def _results(spec: Spec, known: set[tuple[str, str]]) -> Iterator[Finding]:
    for key, result in sorted(spec.results.items()):
        place = Place(result.file, result.line)
        if key not in known:
            message = f'a result of the test "{result.title}" of `{result.rule}`, which does not exist'
            yield warning("T217", message, place, "run `trackmarshal assess` again", result.rule)
            continue
        stale = spec.staleness(result)
        if stale:
            message = f'the result of the test "{result.title}" of `{result.rule}` is stale: {stale}'
            yield warning("T216", message, place, "run `trackmarshal assess` again", result.rule)
        elif result.outcome in ("failed", "error"):
            came = "failed" if result.outcome == "failed" else "could not be run"
            why = f": {result.message}" if result.message else ""
            message = f'the test "{result.title}" of `{result.rule}` {came}{why}'
            yield Finding(
                "T215", "error", message, place, "", result.rule, about=(f"{result.rule}: {result.title}",)
            )
        elif result.outcome != "passed":
            raise ValueError(f"unknown outcome {result.outcome!r}")
