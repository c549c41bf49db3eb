"""What the index says: what was assessed, its state in one sentence, what is missing, coverage, runs, tests."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trackmarshal.trace import verdict
from trackmarshal.trace.render.words import SIGNS
from trackmarshal.trace.report.reading import Run
from trackmarshal.trace.report.run_view import truth_words
from trackmarshal.trace.report.svg.bars import STATUSES, coverage_bar
from trackmarshal.trace.report.svg.timeline import strip
from trackmarshal.trace.report.words import clock, count, listed

LEVELS = {"error": "must be mended", "warning": "should be looked at", "note": "for information"}
#: Findings of one level that are shown at once; the rest unfold. Notes stand before the coverage, and nobody has to do anything about them.
SHOWN_AT_ONCE = {"error": 25, "warning": 25, "note": 3}


@dataclass(frozen=True, slots=True)
class State:
    """The whole assessment in one sentence. `look` is a status of cells, whose colours it has; `word`, with `sign`, says the same without colour."""

    look: str
    sign: str
    word: str
    sentence: str


def index_context(
    runs: Sequence[tuple[Run, str]], matrix_summary: Mapping[str, Any], missing: Sequence[Mapping[str, Any]],
    checks: Mapping[str, Any], meta: Mapping[str, Any], matrix: str | None, backed: Mapping[str, Mapping[str, str]],
) -> dict[str, Any]:  # fmt: skip
    """All that the index's template needs; `runs` come with the addresses of their pages. backed: as of `write_report`."""
    findings = [_finding(f) for f in missing]
    titles = {entry["id"]: entry["title"] for entry in matrix_summary.get("stages", [])}
    return {
        "meta": meta,
        "state": state([run for run, _ in runs], matrix_summary, findings, checks),
        "cards": _cards([run for run, _ in runs], matrix_summary, findings, checks),
        "matrix": matrix,
        "findings": [
            {"level": level, "words": words, "items": items, "shown": SHOWN_AT_ONCE[level]}
            for level, words in LEVELS.items()
            if (items := [f for f in _standing(findings) if f["level"] == level])
        ],
        "gaps": _gaps(matrix_summary),
        "signs": SIGNS,
        "waivers": [
            {**w, "now": w["granted"] <= matrix_summary["date"] <= w["expires"]}
            for w in matrix_summary.get("waivers", [])
        ],
        "stages": [
            _stage(name, entry, titles.get(name, ""))
            for name, entry in matrix_summary.get("coverage", {}).items()
        ],
        "statuses": STATUSES,
        "runs": [_run(run, page) for run, page in runs],
        "checks": checks,
        "assumptions": _assumptions([run for run, _ in runs], backed),
    }


def state(
    runs: Sequence[Run], matrix_summary: Mapping[str, Any], findings: Sequence[Mapping[str, Any]], checks: Mapping[str, Any]
) -> State:  # fmt: skip
    """The matrix's verdict, or a worse one where the pages show more that is wrong. What is wrong comes first; what was not done is never left unsaid."""
    tests = checks["tests"]
    errors = sum(f["level"] == "error" for f in findings)
    outside = [run.name for run in runs if any(not truth["inside"] for truth in run.record["truths"])]
    empty = [run.name for run in runs if not run.cycles]
    wrong = []
    if checks["errors"]:
        wrong.append(f"the specs have {count(checks['errors'], 'error')}")
    if tests and checks["failed"]:
        wrong.append(f"{checks['failed']} of {count(tests, 'test')} failed")
    if errors:
        wrong.append(f"{count(errors, 'finding')} must be mended")
    if outside:
        wrong.append(f"{_runs(outside)} outside {'its' if len(outside) == 1 else 'their'} ground truth")
    if empty:
        wrong.append(f"{listed(empty)} {'has' if len(empty) == 1 else 'have'} no cycles")
    undone = []
    if checks["errors"] is None:
        undone.append("the specs were not checked")
    if not tests:
        undone.append("no test was run")
    if not runs:
        undone.append("no scenario was replayed")
    if not matrix_summary.get("coverage"):
        undone.append("no coverage was computed")
    word = matrix_summary.get("verdict", verdict.NONE)
    if wrong:
        word = verdict.worse(word, verdict.FAIL)
        return _state(word, f"{_capital(listed(wrong))}{'; ' + listed(undone) if undone else ''}.")
    if undone:
        return _state(word, f"Nothing wrong was found, but not everything was done: {listed(undone)}.")
    held = []
    covered, asked, waived = (_total(matrix_summary, status) for status in ("covered", "of", "waived"))
    rest = asked - covered - waived
    parts = [f"{covered} of {asked} demands of the V-model are covered"]
    parts += [f"{waived} waived"] if waived else []
    parts += [f"{rest} not"] if rest else []
    held.append(", ".join(parts) if len(parts) == 1 else f"{parts[0]} ({' and '.join(parts[1:])})")
    held.append(f"all {tests} tests passed" if tests > 1 else "the only test passed")
    judged = [run for run in runs if run.record["truths"]]
    held.append(
        f"{len(judged)} of {count(len(runs), 'run')} could be held against ground truth and lie inside it"
        if judged
        else "no run has ground truth"
    )
    if checks["faults"] is not None:
        found, put_in = checks["faults"]
        held.append(f"{found} of {count(put_in, 'injected fault')} were found as expected")
    warnings = sum(f["level"] == "warning" for f in findings) + int(checks["warnings"])
    # Of what the matrix reserves its pass by, cells stand above, and warnings are counted with those of the specs.
    reserved = [
        what
        for what in matrix_summary.get("reservations", ())
        if " cell" not in what and "should be looked at" not in what
    ]
    reserved += [f"{count(warnings, 'warning')} should be looked at"] if warnings else []
    extra = f"; {listed(reserved)}" if reserved else ""
    return _state(word, f"{_capital(listed(held))}{extra}.")


def _state(word: str, sentence: str) -> State:
    return State(verdict.LOOKS[word], verdict.SIGNS[word], word, sentence)


def _cards(
    runs: Sequence[Run], matrix_summary: Mapping[str, Any], findings: Sequence[Mapping[str, Any]], checks: Mapping[str, Any]
) -> list[tuple[str, str]]:  # fmt: skip
    """Four numbers at a glance, each with what it counts."""
    tests, failed = checks["tests"], checks["failed"]
    judged = [run for run in runs if run.record["truths"]]
    inside = sum(all(truth["inside"] for truth in run.record["truths"]) for run in judged)
    levels = {level: sum(f["level"] == level for f in findings) for level in LEVELS}
    return [
        (
            f"{_total(matrix_summary, 'covered')} of {_total(matrix_summary, 'of')}",
            f"demands of the V-model covered; {_total(matrix_summary, 'waived')} waived",
        ),
        (
            f"{tests - failed} of {tests}" if tests else "none",
            "tests in specs passed",
        ),
        (
            f"{inside} of {len(judged)}",
            f"runs inside their ground truth; {count(len(runs) - len(judged), 'run')} without",
        ),
        (
            str(levels["error"]),
            f"to be mended; {count(levels['warning'], 'warning')}, {count(levels['note'], 'note')}",
        ),
    ]


def fault_context(faults: Sequence[Mapping[str, str]]) -> dict[str, Any]:
    """The table of injected faults, with its state in one sentence."""
    looks = {
        "covered": ("good", "✓ yes"),
        "failed": ("bad", "✕ no"),
        "stale": ("bad", "stale"),
        "missing": ("soft", "not put in"),
    }
    rows = [
        {
            **row,
            "driven": re.sub(r"(?<=\d) (?=s\b)", "\N{NO-BREAK SPACE}", row["driven"]),
            "look": looks[row["status"]][0],
            "word": looks[row["status"]][1],
        }
        for row in faults
    ]
    number = {status: sum(row["status"] == status for row in rows) for status in looks}
    done = number["covered"] + number["failed"]
    said = f"{number['covered']} of {count(done, 'fault')} were found as expected"
    for status, words in (("stale", "with stale results"), ("missing", "not put in")):
        if number[status]:
            said += f"; {number[status]} {words}"
    return {"faults": rows, "faults_said": f"{said}." if rows else ""}


def _total(matrix_summary: Mapping[str, Any], what: str) -> int:
    return sum(int(stage.get(what, 0)) for stage in matrix_summary.get("coverage", {}).values())


def _gaps(matrix_summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Requirements by stage and status, worst first, as far as they are not covered."""
    found: dict[tuple[str, str], list[str]] = {}
    for requirement in matrix_summary.get("requirements", []):
        for stage, cell in requirement.get("stages", {}).items():
            if cell["status"] != "covered":
                found.setdefault((cell["status"], stage), []).append(requirement["id"])
    worst = ("failed", "stale", "missing", "partial", "waived")
    if unknown := {status for status, _ in found} - set(worst):
        raise ValueError(f"unknown status {sorted(unknown)}")
    stages = list(matrix_summary.get("coverage", {}))
    order = sorted(found.items(), key=lambda item: (worst.index(item[0][0]), stages.index(item[0][1])))
    return [{"status": status, "stage": stage, "requirements": ids} for (status, stage), ids in order]


def _runs(names: Sequence[str]) -> str:
    return (
        f"{names[0]} lies"
        if len(names) == 1
        else f"{len(names)} runs ({listed(names[:4])}{' …' if len(names) > 4 else ''}) lie"
    )


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


def _standing(findings: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Findings that stand for themselves, each with those that follow from it: one cause is mended once."""
    known = {f["id"] for f in findings} - {None}
    following: dict[int, list[dict[str, Any]]] = {}
    for f in findings:
        if f["cause"] in known:
            following.setdefault(f["cause"], []).append(f)
    return [{**f, "following": following.get(f["id"], [])} for f in findings if f["cause"] not in known]


def _finding(raw: Mapping[str, Any]) -> dict[str, Any]:
    """A finding with its place as text: `place`, or `span`, or `file` and `line`."""
    level = raw.get("level", "error")
    if level not in LEVELS:
        raise ValueError(f"unknown level {level!r}")
    place = raw.get("place") or raw.get("span")
    if not place and raw.get("file"):
        place = f"{raw['file']}:{raw['line']}" if raw.get("line") else raw["file"]
    return {
        "code": str(raw.get("code", "")), "level": level, "message": str(raw.get("message", "")),
        "place": "" if place is None else str(place), "help": str(raw.get("help") or ""), 
        "id": raw.get("id"), "cause": raw.get("cause"), "following": [],
    }  # fmt: skip


def _stage(name: str, entry: Mapping[str, Any], title: str) -> dict[str, Any]:
    """One stage: how many of its demands have which status; what no status is given for is `not covered`."""
    counts = {status: int(entry.get(status, 0)) for status in STATUSES if status != "other"}
    of = int(entry["of"])
    counts["other"] = of - sum(counts.values())
    if counts["other"] < 0:
        raise ValueError(f"stage {name} counts more demands than the {of} it has")
    spoken = ", ".join(f"{n} {STATUSES[status]}" for status, n in counts.items() if n)
    return {
        "name": name, "title": title, "covered": counts["covered"], "of": of,
        "words": spoken or "nothing demanded", "bar": coverage_bar(name, counts, of),
        "percent": f"{100 * counts['covered'] // of} %" if of else "–",
    }  # fmt: skip


def _run(run: Run, page: str) -> dict[str, Any]:
    found = run.first_firing()
    return {
        "run": run,
        "page": page,
        "strip": strip(run),
        "safe": run.cycles - run.unsafe_cycles,
        "unsafe": run.unsafe_cycles,
        "truths": [truth_words(run, truth) for truth in run.record["truths"]],
        "first": None
        if found is None
        else {"rule": found[0].name, "t": clock(run.t[found[2]["cycles"][0]]), "candidate": found[1]},
        "fired": len(run.fired),
        "end": f"{clock(run.t[-1] - run.t[0])} {run.time_unit}" if run.cycles else "",
    }


def _assumptions(runs: Sequence[Run], backed: Mapping[str, Mapping[str, str]]) -> list[dict[str, Any]]:
    """Assumptions of all runs by name, with the runs in which their monitor fired, and in how many others it held somewhere: without what it is about, it says nothing."""
    found: dict[str, dict[str, Any]] = {}
    for run in runs:
        fired = {rule.name for rule in run.rules if rule.fired}
        held = {rule.name for rule in run.rules if any("s" in lane.verdict for lane in rule.lanes.values())}
        for entry in run.record["assumptions"]:
            known = found.setdefault(
                entry["name"], {**entry, **backed.get(entry["name"], {}), "broken": [], "held": 0}
            )
            if entry["name"] in fired:
                known["broken"].append(run.name)
            elif entry["name"] in held:
                known["held"] += 1
    return list(found.values())
