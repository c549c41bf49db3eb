"""Faults put into recordings: whether each was found as its campaign expects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.trace.files import Hashes, lacking, way_out
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec
from trackmarshal.units import moment


def verdict(case: FaultCase, spec: Spec) -> tuple[str, str]:
    """Status and sentence of a fault: covered when it was found as expected."""
    if case.open:
        return "missing", f"not put in: {case.open}"
    result = spec.fault_results.get((case.campaign, case.id))
    if result is None:
        return "missing", "not put in"
    if not case.fingerprint or result.fingerprint != case.fingerprint:
        return "stale", "the specs, the recording or the fault have changed since"
    if result.outcome != "passed":
        return "failed", result.message or result.outcome
    return "covered", said(result)


def said(result: FaultResult) -> str:
    """What was found, in one sentence."""
    if result.first is None:
        return "nothing fired, as expected"
    return f"{found_by(result)} at {moment(result.first)} s; driven instead: {driven(result)}"


def found_by(result: FaultResult) -> str:
    """The rule, or the fault with its code, that found it."""
    if not result.by:
        return "nothing"
    return f"{result.by[0]} ({result.code})" if result.code else result.by[0]


def driven(result: FaultResult) -> str:
    """What was driven in the first unsafe cycle, and what became of it."""
    match result.driven:
        case "previous_emergency":
            words = (
                "emergency trajectory"
                if result.since is None
                else f"emergency trajectory of {moment(result.since)} s"
            )
            return (
                words
                if result.lost_at is None
                else f"{words}; nothing from {moment(result.lost_at)} s ({result.lost})"
            )
        case "no_safe_trajectory":
            return f"nothing ({result.lost})" if result.lost else "nothing"
        case "drive":
            return "planned trajectory"
        case other:
            return other


def rows(cases: Sequence[FaultCase], results: Sequence[FaultResult]) -> list[dict[str, str]]:
    """A row a fault, for reports: what it is, what found it, in which cycle, what was driven, and whether that was expected."""
    spec = Spec((), (), (), (), fault_cases=cases, fault_results=results)
    table = []
    for case in spec.faults:
        status, detail = verdict(case, spec)
        result = spec.fault_results.get((case.campaign, case.id))
        known = result if result is not None and status in ("covered", "failed") else None
        fired = known is not None and known.first is not None
        table.append(
            {
                "campaign": case.campaign,
                "id": case.id,
                "title": case.title,
                "requirement": case.requirement,
                "by": "" if known is None else found_by(known),
                "also": "" if known is None else ", ".join(known.by[1:]),
                "cycle": f"{moment(known.first)} s" if known is not None and known.first is not None else "",
                "driven": "" if known is None else driven(known) if fired else "planned trajectory",
                "status": status,
                "detail": "" if status == "covered" else detail,
            }
        )
    return table


def check(project: Project, spec: Spec, hashes: Hashes) -> Iterator[Finding]:
    """What is wrong with campaigns and their results (T260 to T264)."""
    for path in project.campaigns:
        if hashes.get(path) is None:
            message = f"the campaign `{path}` {lacking(path, hashes)}"
            yield error("T264", message, path.place, way_out(path, hashes), path)
    # What is found of a fault may change with any rule, and with the recording.
    judged = (*spec.by_name, *(str(s.path) for s in project.scenarios))
    not_run: list[FaultCase] = []
    stale: list[FaultCase] = []
    for case in spec.faults:
        place = Place(case.campaign, case.line)
        requirement = project.by_id.get(case.requirement)
        if requirement is None or not requirement.demanded:
            message = f"the fault `{case.id}` is to violate `{case.requirement}`, which is not demanded"
            help_ = did_you_mean(case.requirement, project.by_id)
            yield Finding(
                "T263",
                "error",
                message,
                place,
                help_,
                case.id,
                about=(case.requirement, f"{case.campaign} {case.id}"),
            )
        status, detail = verdict(case, spec)
        if status == "failed":
            rests_on = (case.campaign, f"{case.campaign} {case.id}", case.requirement, *judged)
            yield Finding(
                "T260",
                "error",
                f"the fault `{case.id}` ({case.title}): {detail}",
                place,
                "",
                case.id,
                rests_on=rests_on,
            )
        elif status == "stale":
            stale.append(case)
        elif status == "missing" and not case.open:
            not_run.append(case)
    for found, code, one, more in (
        (stale, "T261", "the result of 1 fault is stale", "the results of {} faults are stale"),
        (not_run, "T262", "1 fault was not put in", "{} faults were not put in"),
    ):
        if found:
            message = one if len(found) == 1 else more.format(len(found))
            place = Place(found[0].campaign, found[0].line)
            others = tuple(case.id for case in found[1:])
            yield Finding(
                code, "warning", f"{message}, which counts as not covered", place, "run `trackmarshal assess`", found[0].id, about=others,
                rests_on=judged if code == "T261" else (),
            )  # fmt: skip
