"""Faults in what shows that demands are met, and in what guards them: the V-model, recordings, results, documents, the baseline."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Any

from support.planted.edits import (
    BASELINE,
    STORE,
    Edit,
    Fault,
    accepted,
    add,
    agreed,
    all_of,
    committed,
    copied,
    cut,
    entry,
    git,
    gone,
    moved,
    put,
    remade,
    swap,
)

V, F, A = "requirements/v-model.yaml", "specs/scenarios/faults.yaml", "requirements/assurance.yaml"
LINKS = "requirements/links.yaml"
_METHODS = b"""document: link-schema
title: How this project verifies
nodes: []
methods:
  - {name: test, means: tests that passed, any_of: [{reaches: test, where: [{attribute: outcome, is: [passed]}]}]}
  - {name: analysis, means: worked out, any_of: [{reaches: analysis}]}
  - {name: review, means: one passed, any_of: [{reaches: test}, {reaches: scenario}, {reaches: assumption}]}
  - {name: scenario, means: one passed, any_of: [{reaches: test}, {reaches: scenario}, {reaches: assumption}]}
  - {name: fault injection, means: one passed, any_of: [{reaches: test}, {reaches: scenario}, {reaches: assumption}]}
  - {name: monitor, means: one passed, any_of: [{reaches: test}, {reaches: scenario}, {reaches: assumption}]}
reviewed:
  - {kind: requirement, from_asil: D}
"""
HURRY, CALM = "specs/scenarios/hurry.tmrec.jsonl", "specs/scenarios/calm.tmrec.jsonl"
DRIVEN = "specs/scenarios/driven.tmrec.jsonl"
L = "specs/limits.spec"
LIMITS = put(
    L,
    b'module supervisor.limits\n\nparam start_distance : m = 0.05 m in [0, 100] source "planner, 2"\nparam oldest : s = 0.1 s in [0, 1] source "timing, 1"\n',
)
GENERATED = swap(
    V,
    f"    - {{path: {CALM}",
    f"    - {{path: specs/scenarios/hurry.yaml, title: The same made again, stage: S-4-A, expect: ground_truth, origin: synthetic}}\n    - {{path: {CALM}",
)
#: A recording that uses a configuration, and the configuration with a value.
USES = remade(
    HURRY, lambda data: data.replace(b'"name":"hurry",', b'"name":"hurry","use":["conf/permit.spec"],', 1)
)
OTHER = "specs/scenarios/other.tmrec.jsonl"
#: The campaign on a recording that is no scenario.
ON_ANOTHER = all_of(
    copied(CALM, OTHER), swap(F, "recording: calm.tmrec.jsonl", "recording: other.tmrec.jsonl")
)


#: A report of another runner, as `make test` writes one that need not be there.
REPORT = "out/tests.xml"
REPORTED = all_of(
    swap(
        V,
        "  campaigns:",
        f"  junit: [{{path: {REPORT}, stage: S-3-B, tool: ctest, if_there: true}}]\n  campaigns:",
    ),
    swap(V, "counts: [test, fault]", "counts: [test, fault, external test]"),
)


def ran(*names: str, skipped: str = "") -> Edit:
    """What another runner found of tests of two requirements, all of which passed; and of one that names none, and was skipped."""
    tests = "".join(
        f'<testcase classname="drive" name="{name}"><properties><property name="verifies" value="S-1, S-2"/></properties></testcase>'
        for name in names
    )
    tests += f'<testcase classname="drive" name="{skipped}"><skipped/></testcase>' if skipped else ""
    return put(REPORT, f'<testsuite name="unit">{tests}</testsuite>'.encode())


#: A gap at the stage of that report that somebody answers for: a fault that nobody can put in yet.
HALF = all_of(
    swap(F, "  - id: F-2\n", "  - {id: F-3, title: Brakes without oil, requirement: S-2, open: there are no brakes yet}\n  - id: F-2\n"),
    add(V, "  - {id: W-2, stages: [S-3-B], requirements: [S-2], justification: There are no brakes yet., residual_risk: They may be slow., owner: Dana Driver, approver: Sam Safety, granted: 2026-01-01, expires: 2026-12-31}\n"),
)  # fmt: skip


def verifying(came: str) -> Edit:
    """A report with two tests of S-2, of which the second came to that."""
    says = '<properties><property name="verifies" value="S-2"/></properties>'
    tests = f'<testcase classname="drive" name="fast">{says}</testcase><testcase classname="drive" name="slow">{says}{came}</testcase>'
    return put(REPORT, f'<testsuite name="unit">{tests}</testsuite>'.encode())


#: The same in a folder of reports, which is not written as its files are named.
_FOLDER = all_of(REPORTED, swap(V, f"{{path: {REPORT},", "{path: ./out//reports,"))


def _ran(*names: str) -> Edit:
    def edit(root: Path) -> None:
        ran(*names)(root)
        moved(REPORT, "out/reports/unit.xml")(root)

    return edit


def _permit(value: str) -> Edit:
    """The configuration with a value, or with none."""
    said = f'param v_max : m/s = {value} m/s in [1, 20] source "permit, 2"\n' if value else ""
    return put("conf/permit.spec", f"module permit\n\n{said}".encode())


#: A second recording of the planner in a hurry.
AGAIN = "specs/scenarios/again.tmrec.jsonl"


def _hurry_again(root: Path) -> None:
    (root / AGAIN).write_text(
        (root / HURRY).read_text("utf-8").replace('"name":"hurry"', '"name":"again"', 1), "utf-8"
    )


#: A spec of its own for a rule, and one that uses all.
_SPLIT = all_of(
    swap(V, "default_spec: specs", "default_spec: specs/whole.spec"),
    put("specs/whole.spec", b"module whole\n\nuse rules\nuse doors\n"),
    put("specs/doors.spec",
        b"module doors\n\nuse signals\n\n"
        b'rule no_reverse "Not backwards"\n  satisfies S-2\n  for all   p in plan\n  require   p.v >= 0 m/s\n\n'
        b'test no_reverse "at rest"\n  given  plan = { v: [0 m/s, 0 m/s] }\n  expect satisfied, margin 0 m/s\n\n'
        b'test no_reverse "on"\n  given  plan = line(v: 3 m/s)\n  expect satisfied\n\n'
        b'test no_reverse "back"\n  given  plan = { v: [1 m/s, -1 m/s] }\n  expect violated\n'),
)  # fmt: skip
SCENARIO = "A planner in a hurry, stage: S-4-A, expect: ground_truth, origin: synthetic}"
DRIVE = "A calm drive, stage: S-4-B, expect: no_fire, origin: synthetic, requirements: [S-1]}"


def _of(*path: str, to: Any) -> Any:
    """A change of one value of nested tables."""

    def change(said: dict[str, Any]) -> None:
        for name in path[:-1]:
            said = said[name]
        said[path[-1]] = to

    return change


def _without(*path: str) -> Any:
    def change(said: dict[str, Any]) -> None:
        for name in path[:-1]:
            said = said[name]
        del said[path[-1]]

    return change


def _rules_of_run(said: dict[str, Any]) -> None:
    for facts in said["result"]["rules"]:
        facts["counts"] = {candidate: {"satisfied": 11} for candidate in facts["counts"]}


def _linked_as(name: str) -> Edit:
    """A recording under a second path, as a link."""

    def edit(root: Path) -> None:
        (root / name).symlink_to(Path(CALM).name)

    return edit


def _another(path: str) -> Edit:
    """One more scenario, as one from the field, which closes the gap that is waived."""
    again = f"    - {{path: {path}, title: A drive on the avenue, stage: S-4-B, expect: no_fire, origin: field, requirements: [S-1]}}\n"
    return all_of(swap(V, f"    - {{path: {CALM}", f"{again}    - {{path: {CALM}"), cut(V, "waivers:", ""))


def _tool(said: dict[str, Any]) -> None:
    said["tool"] = "trackmarshal 0.0.1"
    said["inputs"]["engine"] = "0" * 64


def _accepted_by_nobody(root: Path) -> None:
    """What is there is accepted by somebody, who is struck from that afterwards."""
    agreed(lambda _: None)(root)
    accepted(lambda held: held["acceptances"][-1].update(by="", reason="", weaker=[]), rehash=False)(root)


# fmt: off
FAULTS = [
    # the gate and its stages
    Fault("a scenario named a second time as one from the field", swap(V, SCENARIO, SCENARIO + "\n    - {path: " + HURRY + ", title: " + SCENARIO.replace("synthetic", "field")), "T130", HURRY),
    Fault("a copy of a recording under another name as one from the field", all_of(copied(CALM, DRIVEN), remade(DRIVEN, lambda data: data.replace(b'"name":"calm"', b'"name":"real"')), _another(DRIVEN)), "T375", DRIVEN),
    Fault("a copy of a recording as one from the field", all_of(copied(CALM, DRIVEN), _another(DRIVEN)), "T130", CALM),
    Fault("a link to a recording as one from the field", all_of(_linked_as(DRIVEN), _another(DRIVEN)), "T130", CALM),
    Fault("a scenario that is generated as one from the field", _another("specs/scenarios/calm.yaml"), "T127", "specs/scenarios/calm.yaml"),
    Fault("the gate cut to one stage", cut(V, "  - {stage: S-2-A, requirements: [S-31]}\n", "waivers:"), "T371", "S-2-A, covered"),
    Fault("a stage left out of the gate", swap(V, "  - {stage: S-4-B, requirements: [S-1]}\n", ""), "T371", "S-4-B, covered"),
    Fault("a requirement left out of the gate", swap(V, "{stage: S-4-A, requirements: [S-32, S-4], at_least: partial}", "{stage: S-4-A, requirements: [S-32], at_least: partial}"), "T371", "S-4-A, partial"),
    Fault("a gate where there was none", all_of(agreed(cut(V, "gate:\n", "waivers:")), swap(V, "waivers:\n", "gate:\n  - {stage: S-1-A, requirements: ['*']}\nwaivers:\n")), "T371", "gate"),
    Fault("a demand of nothing", swap(V, "{stage: S-4-A, requirements: [S-1]}", "{stage: S-4-A, requirements: []}"), "T126"),
    Fault("a demand of no id", swap(V, "{stage: S-4-A, requirements: [S-1]}", "{stage: S-4-A, requirements: [S 1]}"), "T124"),
    Fault("no specs named", swap(V, "  specs: [specs]\n", ""), "T120"),
    Fault("less at least", swap(V, "{stage: S-4-A, requirements: [S-1]}", "{stage: S-4-A, requirements: [S-1], at_least: partial}"), "T371", "S-4-A, covered"),
    Fault("a stage struck", all_of(swap(V, "  - {id: S-2-C, title: assumptions, shows: what it takes for granted, applies_to: [S-4], counts: [assumption]}\n", ""), swap(V, "  - {stage: S-2-C, requirements: [S-4]}\n", "")), "T371", "S-2-C, covered"),
    Fault("a stage for fewer", swap(V, "shows: that tests pass and faults are found, applies_to: [S-1, S-2, S-32, S-4]", "shows: that tests pass and faults are found, applies_to: [S-1, S-2, S-32]"), "T371", "S-3-B"),
    Fault("a stage that counts less", swap(V, "counts: [test, fault]", "counts: [test]"), "T371", "S-3-B"),
    Fault("a stage that asks only where there is something", swap(V, "counts: [assumption]}", "counts: [assumption], if_any: true}"), "T371", "S-2-C"),
    Fault("no tests needed", swap(V, "{satisfied: 1, violated: 1, boundary: 1}", "{satisfied: 0, violated: 0, boundary: 0}"), "T371"),
    Fault("no boundary needed", swap(V, "boundary: 1", "boundary: 0"), "T371"),
    Fault("fewer specs", swap(V, "  specs: [specs]", "  specs: [specs/rules.spec]"), "T371"),
    Fault("no campaign", swap(V, "  campaigns: [specs/scenarios/faults.yaml]\n", ""), "T371"),
    Fault("another schema of links", put("requirements/links.yaml", b"document: link-schema\ntitle: None\nnodes: []\n"), "T376"),
    Fault("methods that are answered by less", all_of(agreed(put(LINKS, _METHODS)), swap(LINKS, "is: [passed]", "is: [passed, failed]")), "T376"),
    Fault("no reviews asked for any more, in a schema of links", all_of(agreed(put(LINKS, _METHODS)), swap(LINKS, "reviewed:\n  - {kind: requirement, from_asil: D}", "reviewed: []")), "T376"),
    Fault("no baseline any more", swap(V, "  baseline: requirements/baseline.json\n", ""), "T220"),
    Fault("the baseline removed", gone(BASELINE), "T220"),
    Fault("the baseline cut off", remade(BASELINE, lambda data: data[: len(data) // 2]), "T220"),
    Fault("a conflict in the baseline", remade(BASELINE, lambda data: data.replace(b' "version"', b'<<<<<<< ours\n "version"', 1)), "T220"),
    Fault("an entry of the baseline removed", accepted(_without("content", "rule braking"), rehash=False), "T379"),
    Fault("an ASIL of the baseline lowered", accepted(_of("content", "requirement S-1", "asil", to="QM"), rehash=False), "T379"),
    Fault("an ASIL and that of the baseline lowered", all_of(accepted(_of("content", "requirement S-31", "asil", to="QM(C)"), rehash=False), swap("requirements/requirements.yaml", "asil: A(C)", "asil: QM(C)"), swap("requirements/requirements.yaml", "asil: B(C)", "asil: C(C)")), "T379"),
    Fault("an entry of the baseline removed, its hash made again", all_of(accepted(_without("content", "waiver W-1"), rehash=True), committed("tidy")), "T380", rerun=True),
    Fault("a reason rewritten", all_of(accepted(lambda held: held["acceptances"][0].update(reason="as always"), rehash=False), committed("tidy")), "T380", rerun=True),
    Fault("acceptances struck", all_of(accepted(lambda held: held["acceptances"].insert(0, {**held["acceptances"][0], "by": "Somebody"}), rehash=False), committed("tidy")), "T380", rerun=True),
    # what the Supervisor is held to, what scenarios are made of, and what the safety case prints
    Fault("a limit of the Supervisor moved", all_of(agreed(LIMITS), swap(L, "= 0.05 m", "= 90 m")), "T372", "start_distance"),
    Fault("a limit of the Supervisor in place of the default", put(L, b"module supervisor.limits\n\nparam start_distance : m = 90 m in [0, 100] source \"wish\"\n"), "T372", "start_distance"),
    Fault("limits of the Supervisor struck", all_of(agreed(LIMITS), gone(L)), "T372", "start_distance"),
    Fault("the track of a scenario that is generated", all_of(agreed(GENERATED), swap("specs/tracks/avenue.yaml", "width: 8", "width: 9")), "T375", "specs/scenarios/hurry.yaml"),
    Fault("templates of the safety case that print nothing", all_of(swap(V, "  campaigns:", "  case_templates: docs/case\n  campaigns:"), put("docs/case/open.html.j2", b"\n")), "T371"),
    Fault("a template of the safety case edited", all_of(put("docs/case/open.html.j2", b"{% extends 'ours/section.html.j2' %}\n"), agreed(swap(V, "  campaigns:", "  case_templates: docs/case\n  campaigns:")), put("docs/case/open.html.j2", b"\n")), "T371"),
    Fault("other words of the safety case", all_of(swap(V, "  campaigns:", "  case_words: docs/words.yaml\n  campaigns:"), put("docs/words.yaml", b"format: trackmarshal-case-words\n")), "T371"),
    Fault("results of a closed loop edited", all_of(put("docs/loop.json", b"{}"), agreed(swap(V, "  campaigns:", "  closed_loop: docs/loop.json\n  campaigns:")), put("docs/loop.json", b"[]")), "T371"),
    # tests of another runner
    Fault("a test of another runner that is not in the report any more", all_of(REPORTED, agreed(ran("fast", "slow[1]", "slow[2]")), ran("fast")), "T221", f"S-1 in {REPORT} at S-3-B"),
    Fault("one of two tests of another runner whose names begin and end in brackets", all_of(REPORTED, agreed(ran("[R-1] stops [wet]", "[R-1] holds [dry]")), ran("[R-1] stops [wet]")), "T221", f"S-1 in {REPORT} at S-3-B"),
    Fault("a test of another runner that names its requirements no more, and another one that does", all_of(REPORTED, agreed(ran("fast", "slow[1]")), ran("fast", "easy", skipped="slow[1]")), "T221", f"S-1 in {REPORT} at S-3-B"),
    Fault("tests of another runner that name their requirements no more, accepted by nobody", all_of(REPORTED, agreed(ran("fast", "slow")), git("add", "."), committed("report"), ran("fast", "easy", skipped="slow"), _accepted_by_nobody), "T380", rerun=True),
    Fault("tests of another runner, accepted without the report, and then fewer", all_of(REPORTED, agreed(ran("fast", "slow")), gone(REPORT), agreed(add("docs/planner.md", "\nmore\n")), ran("slow")), "T221", f"S-1 in {REPORT} at S-3-B"),
    Fault("a test of another runner that is not in the folder of reports any more, however that is written", all_of(_FOLDER, agreed(_ran("fast", "slow")), _ran("fast")), "T221", "S-1 in ./out//reports at S-3-B"),
    Fault("a report of another runner under another path", all_of(agreed(all_of(REPORTED, ran("fast"))), swap(V, "if_there: true}]", "if_there: true}, {path: ./out//tests.xml, stage: S-3-B, tool: ctest}]")), "T130", "./out//tests.xml"),
    Fault("a campaign under another path", swap(V, "campaigns: [specs/scenarios/faults.yaml]", "campaigns: [specs/scenarios/faults.yaml, ./specs/scenarios/faults.yaml]"), "T130", "./specs/scenarios/faults.yaml"),
    Fault("a copy of a campaign", all_of(copied(F, "specs/scenarios/again.yaml"), swap(V, "campaigns: [specs/scenarios/faults.yaml]", "campaigns: [specs/scenarios/faults.yaml, specs/scenarios/again.yaml]")), "T130", "specs/scenarios/again.yaml"),
    Fault("a report of another runner struck", all_of(REPORTED, agreed(ran("fast")), swap(V, f"  junit: [{{path: {REPORT}, stage: S-3-B, tool: ctest, if_there: true}}]\n", "")), "T373", f"{REPORT} at S-3-B"),
    Fault("a report of another runner that has no test", all_of(REPORTED, agreed(ran("fast")), ran()), "T330", REPORT),
    Fault("a test of another runner that failed among its properties", all_of(REPORTED, agreed(ran("fast")), remade(REPORT, lambda data: data.replace(b"</properties>", b'<failure message="it hit the wall"/></properties>'))), "T337", "fast"),
    Fault("names that one long name is tried against for ever", all_of(REPORTED, agreed(ran("fast")), swap(V, "if_there: true}", "if_there: true, names: (_?S)+}")), "T340", REPORT),
    # faults that are put in
    Fault("a fault that changes nothing", add(F, '  - id: F-3\n    title: "The planner drives faster"\n    requirement: S-1\n    begin: 0.1\n    end: 0.2\n    change:\n      - {column: driving.v, add: 0}\n    expect: {}\n'), "T260", "F-3"),
    # waivers
    Fault("a waiver until 9999", swap(V, "expires: 2026-12-31", "expires: 9999-12-31"), "T235", "W-1"),
    Fault("a waiver for everything by x", add(V, "  - {id: W-2, stages: [S-1-A, S-2-A, S-2-B, S-2-C, S-3-B, S-4-A, S-4-B], requirements: ['*'], justification: none, residual_risk: none, owner: x, approver: Sam Safety, granted: 2026-01-01, expires: 9999-12-31}\n"), "T153", "W-2"),
    Fault("a waiver for more", swap(V, "    stages: [S-4-B]\n    requirements: [S-1]", "    stages: [S-4-B, S-4-A]\n    requirements: [S-1]"), "T377", "W-1"),
    Fault("a waiver for other requirements", swap(V, "    stages: [S-4-B]\n    requirements: [S-1]", "    stages: [S-4-B]\n    requirements: [S-1, S-2]"), "T377", "W-1"),
    Fault("another reason for a waiver", swap(V, "The shuttle has not been on the avenue yet.", "It is fine."), "T377", "W-1"),
    Fault("another owner of a waiver", swap(V, "owner: Dana Driver", "owner: Ola Observer"), "T377", "W-1"),
    Fault("another approver of a waiver", swap(V, "approver: Sam Safety", "approver: Vera Verifier"), "T377", "W-1"),
    Fault("another residual risk of a waiver", swap(V, "residual_risk: Something", "residual_risk: Nothing"), "T377", "W-1"),
    Fault("a waiver approved by its owner", swap(V, "approver: Sam Safety", "approver: P-1"), "T234", "W-1"),
    Fault("a waiver approved by x", swap(V, "approver: Sam Safety", "approver: x"), "T153", "W-1"),
    Fault("a waiver approved by its owner under another id", all_of(swap(A, "  - {id: P-4,", "  - {id: P-5, title: dana  Driver, role: safety}\n  - {id: P-4,"), agreed(swap(V, "approver: Sam Safety", "approver: P-5"))), "T130", "P-5"),
    Fault("a reviewer with the name of the owner", swap(A, "title: Vera Verifier", "title: Dana Driver"), "T130", "P-4"),
    Fault("a waiver for all requirements", swap(V, "    stages: [S-4-B]\n    requirements: [S-1]", "    stages: [S-4-B]\n    requirements: ['*']"), "T236", "W-1"),
    Fault("a waiver for every method of all requirements", agreed(add(V, "  - {id: W-2, codes: [T255], subjects: ['S-*:*'], justification: none, residual_risk: none, owner: Dana Driver, approver: Sam Safety, granted: 2026-01-01, expires: 2026-12-31}\n")), "T236", "W-2"),
    Fault("a waiver of no stage", swap(V, "    stages: [S-4-B]\n    requirements: [S-1]", "    stages: []\n    requirements: [S-1]"), "T126"),
    Fault("a waiver that nobody approved", swap(V, "    approver: Sam Safety\n", ""), "T120"),
    Fault("a waiver that holds longer", swap(V, "granted: 2026-01-01\n    expires: 2026-12-31", "granted: 2026-03-01\n    expires: 2027-02-28"), "T377", "W-1"),
    Fault("a waiver that has expired", swap(V, "expires: 2026-12-31", "expires: 2026-05-31"), "T231", "W-1"),
    Fault("the day after the waiver", lambda root: None, "T231", "W-1", today=date(2027, 1, 1)),
    Fault("a waiver from tomorrow", swap(V, "granted: 2026-01-01", "granted: 2026-06-03"), "T231", "W-1"),
    Fault("a waiver struck", cut(V, "waivers:", ""), "T230", "S-1"),
    Fault("a waiver of what cannot be waived", add(V, "  - {id: W-2, codes: [T215], subjects: [braking], justification: none, residual_risk: none, owner: Dana Driver, approver: Sam Safety, granted: 2026-01-01, expires: 2026-12-31}\n"), "T233", "W-2"),
    Fault("a waiver of nobody's", swap(V, "    owner: Dana Driver\n", ""), "T120"),
    # scenarios and recordings
    Fault("a scenario struck", swap(V, "    - {path: specs/scenarios/hurry.tmrec.jsonl, title: " + SCENARIO + "\n", ""), "T228", HURRY),
    Fault("a scenario struck that faults are put into", swap(V, f"    - {{path: {CALM}, title: {DRIVE}\n", ""), "T228", CALM),
    Fault("a scenario without a stage that faults are put into", swap(V, "title: A calm drive, stage: S-4-B,", "title: A calm drive,"), "T120"),
    Fault("what faults are put into edited, and made a scenario", all_of(agreed(swap(V, f"    - {{path: {CALM}, title: {DRIVE}\n", "")), swap(V, "  campaigns:", f"    - {{path: {CALM}, title: {DRIVE}\n  campaigns:"), remade(CALM, lambda data: data.replace(b'"v":10.0', b'"v":10.1', 1))), "T265", F),
    Fault("synthetic made field", swap(V, DRIVE, DRIVE.replace("synthetic", "field")), "T375", CALM),
    Fault("a scenario that is to show less", swap(V, SCENARIO, SCENARIO.replace("expect: ground_truth", "expect: fire, by: [speed_limit]")), "T375", HURRY),
    Fault("a scenario that may not fire, and does", swap(V, SCENARIO, SCENARIO.replace("expect: ground_truth", "expect: no_fire")), "T375", HURRY),
    Fault("a scenario for fewer requirements", swap(V, SCENARIO, SCENARIO.replace("}", ", requirements: [S-1]}")), "T375", HURRY),
    Fault("a scenario at another stage", swap(V, SCENARIO, SCENARIO.replace("stage: S-4-A", "stage: S-4-B")), "T375", HURRY),
    Fault("a recording that is not there", gone(HURRY), "T240", HURRY),
    Fault("a recording truncated by a line", remade(CALM, lambda data: data[: data.rstrip().rindex(b"\n") + 1]), "T375", CALM),
    Fault("a recording truncated in a line", remade(CALM, lambda data: data[:-100]), "D140", status=2),
    Fault("a speed of a recording changed", remade(HURRY, lambda data: data.replace(b'"v":11.0,"length"', b'"v":10.9,"length"', 1)), "T375", HURRY),
    Fault("the ground truth of a recording changed", remade(HURRY, lambda data: data.replace(b'"rule speed_limit":false', b'"rule speed_limit":true', 1)), "T375", HURRY),
    Fault("no ground truth in a recording", remade(HURRY, lambda data: data.replace(b'"ground_truth"', b'"notes_"')), "D141", status=2),
    Fault("a recording that is none", put(HURRY, b"hello\n"), "D140", status=2),
    Fault("a value of a configuration that a recording uses", all_of(agreed(all_of(USES, _permit("12"))), _permit("12.3")), "T375", HURRY),
    Fault("a value of a configuration that had none", all_of(agreed(all_of(USES, _permit(""))), _permit("12.3")), "T375", HURRY),
    Fault("a value of a configuration struck", all_of(agreed(all_of(USES, _permit("11.9"))), _permit("")), "T375", HURRY),
    Fault("an expectation misspelt", swap(V, SCENARIO, SCENARIO.replace("ground_truth", "ground_thruth")), "T123"),
    Fault("no expectation", swap(V, SCENARIO, SCENARIO.replace("expect: ground_truth, ", "")), "T120"),
    # faults
    Fault("faults that begin later in the drive", swap(F, "lead: 0.1", "lead: 0"), "T265", F),
    Fault("faults put into another recording", ON_ANOTHER, "T265", F),
    Fault("the recording that faults are put into edited", all_of(agreed(ON_ANOTHER), remade(OTHER, lambda data: data.replace(b'"id":"bus","x":80.0', b'"id":"bus","x":80.1'))), "T265", F),
    Fault("a fault struck", cut(F, "  - id: F-2\n", ""), "T265", "specs/scenarios/faults.yaml F-2"),
    Fault("a fault put in no longer", all_of(cut(F, "    begin: 0.1\n    end: 0.2\n    change:\n      - {place", ""), add(F, "    open: there is no time\n")), "T265", "specs/scenarios/faults.yaml F-2"),
    Fault("a fault of another requirement", swap(F, "requirement: S-32", "requirement: S-1"), "T265", "specs/scenarios/faults.yaml F-2"),
    Fault("a fault of no requirement", swap(F, "requirement: S-32", "requirement: S-77"), "T263", "F-2"),
    Fault("a fault that is not found", swap(F, "set: -8", "set: -3"), "T265", F + " F-1"),
    Fault("a fault that is expected to be harmless", swap(F, "    expect: {by: braking, first: 0.1, last: 0.2, driven: previous_emergency, from: 0}", "    expect: {}"), "T265", F + " F-1"),
    Fault("a fault made harmless, and expected to be", all_of(swap(F, "set: -8", "set: -3"), swap(F, "    expect: {by: braking, first: 0.1, last: 0.2, driven: previous_emergency, from: 0}", "    expect: {}")), "T265", F + " F-1"),
    Fault("a campaign that is not there", gone(F), "T264", F),
    # documents
    Fault("evidence replaced by x", put("docs/planner.md", b"x"), "T373", "docs/planner.md at S-2-A"),
    Fault("evidence that is not there", gone("docs/planner.md"), "T250", "docs/planner.md"),
    Fault("evidence of an assumption that is not there", gone("docs/sensors.md"), "T252", "A-SEEN"),
    Fault("evidence of an assumption replaced by x", put("docs/sensors.md", b"x"), "T373", "A-SEEN"),
    Fault("evidence that says that there is none", put("docs/sensors.md", b"# Sensors\n\nThere is no evidence for this yet.\n"), "T253", "A-SEEN"),
    Fault("an argument that is not there", gone("docs/independence.md"), "T250", "docs/independence.md"),
    Fault("evidence of a requirement that says that there is none", put("docs/planner.md", b"# How the planner keeps room\n\nThis has yet to be written.\n"), "T253", "S-31"),
    Fault("an argument that was not made yet", agreed(swap("docs/independence.md", "They run on two computers, with two supplies.", "The analysis has not been done yet.")), "T253", "AN-1"),
    Fault("an argument replaced by x", put("docs/independence.md", b"x"), "T373", "AN-1"),
    Fault("evidence for fewer", cut(V, "evidence:\n", "gate:"), "T373", "docs/planner.md at S-2-A"),
    Fault("evidence that is empty", put("docs/planner.md", b""), "T250", "docs/planner.md"),
    Fault("evidence that is empty, accepted", agreed(put("docs/planner.md", b"")), "T250", "docs/planner.md"),
    Fault("evidence of a mark and blanks alone", agreed(put("docs/planner.md", b"\xef\xbb\xbf \n\n")), "T250", "docs/planner.md"),
    Fault("evidence of characters that nobody sees", agreed(put("docs/planner.md", "# \u200b\u2060\u00ad\n\u3164 \u2800...\n".encode())), "T250", "docs/planner.md"),
    Fault("evidence that was not fetched", agreed(put("docs/planner.md", b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n")), "T250", "docs/planner.md"),
    Fault("evidence that git-annex did not fetch", agreed(put("docs/planner.md", b"/annex/objects/SHA256E-s12--4d7a.md\n")), "T250", "docs/planner.md"),
    Fault("evidence of headings alone", agreed(put("docs/planner.md", b"# Planner\n\n## How it keeps room\n\n## S-31\n")), "T250", "docs/planner.md"),
    Fault("evidence of what programs read alone", agreed(put("docs/planner.md", b"---\ntitle: Planner\nauthor: P-1\n---\n\n[1]: https://campus.example/planner\n```\n```\n")), "T250", "docs/planner.md"),
    Fault("evidence that was put off", agreed(put("docs/planner.md", b"# Planner\n\n*T.B.D.*\n")), "T250", "docs/planner.md"),
    Fault("an argument in a comment that nobody sees", agreed(put("docs/independence.md", b"<!-- They do not\nfail together. -->\n")), "T250", "docs/independence.md"),
    Fault("evidence of an assumption that is empty", agreed(put("docs/sensors.md", b" \n")), "T252", "A-SEEN"),
    Fault("a section of the design in a comment", agreed(all_of(put("docs/design.md", b"# Design\n\nIt plans.\n\n## S-31\n\n<!-- to be written -->\n"), swap("requirements/design.yaml", "{id: DE-2,", "{id: DE-2, document: docs/design.md,"), swap(V, "counts: [document]", "counts: [document, design]"))), "T230", "S-31"),
    Fault("a section of the design in a comment that nothing ends", all_of(agreed(all_of(put("docs/design.md", b"# Design\n\nIt plans.\n\n## S-31\n\nIt keeps room.\n"), swap("requirements/design.yaml", "{id: DE-2,", "{id: DE-2, document: docs/design.md,"), swap(V, "counts: [document]", "counts: [document, design]"))), swap("docs/design.md", "It plans.\n", "It plans.\n\n<!--\n")), "T373", "docs/design.md#S-31"),
    Fault("a section of the design struck that was accepted", all_of(agreed(all_of(put("docs/design.md", b"# Design\n\nIt plans.\n\n## S-31\n\nIt keeps room.\n"), swap("requirements/design.yaml", "{id: DE-2,", "{id: DE-2, document: docs/design.md,"), swap(V, "counts: [document]", "counts: [document, design]"))), cut("docs/design.md", "## S-31", "")), "T373", "docs/design.md#S-31"),
    Fault("a section of the design that quotes that it is to do", agreed(all_of(put("docs/design.md", b"# Design\n\nIt plans.\n\n## S-31\n\n> - [ ] TODO\n"), swap("requirements/design.yaml", "{id: DE-2,", "{id: DE-2, document: docs/design.md,"), swap(V, "counts: [document]", "counts: [document, design]"))), "T253", "S-31"),
    Fault("a section of the design that is to do", agreed(all_of(put("docs/design.md", b"# Design\n\nIt plans.\n\n## S-31\n\nTODO\n"), swap("requirements/design.yaml", "{id: DE-2,", "{id: DE-2, document: docs/design.md,"), swap(V, "counts: [document]", "counts: [document, design]"))), "T253", "S-31"),
    Fault("a run that fires by a rule of another requirement", all_of(swap(V, "  - {stage: S-4-A, requirements: [S-1]}\n", "  - {stage: S-4-A, requirements: [S-1, S-32]}\n"), _hurry_again, swap(V, "    - {path: specs/scenarios/calm", f"    - {{path: {AGAIN}, title: B, stage: S-4-A, expect: fire, by: [speed_limit], origin: synthetic}}\n    - {{path: specs/scenarios/calm")), "T230", "S-32"),
    Fault("a rule taken out of the spec that scenarios are replayed with", all_of(agreed(_SPLIT), put("specs/whole.spec", b"module whole\n\nuse rules\n")), "T375", "specs/scenarios/calm.tmrec.jsonl"),
    # results, edited by hand
    Fault("a result of a test edited", entry("test", "braking: harder", _of("result", "message", to="all is well"), rehash=False), "T293", "braking: harder"),
    Fault("a result of a run edited", entry("run", HURRY, _of("result", "fired", to=False), rehash=False), "T293", HURRY),
    Fault("a result of a fault edited", entry("fault", F + " F-1", _of("result", "first", to=0.2), rehash=False), "T293", F + " F-1"),
    Fault("a store cut in a line", remade(STORE, lambda data: data[:-20]), "T293"),
    Fault("a store that is no store", put(STORE, b"{}\n"), "T293"),
    Fault("a result of a test edited, its hash made again", entry("test", "braking: harder", _of("result", "message", to="all is well"), rehash=True), "T294", "braking: harder", rerun=True),
    Fault("counts of a run edited, its hash made again", entry("run", HURRY, _rules_of_run, rehash=True), "T294", HURRY, rerun=True),
    Fault("cycles of a run edited, its hash made again", entry("run", HURRY, _of("result", "cycles", to=9999), rehash=True), "T294", HURRY, rerun=True),
    Fault("ground truth of a run edited, its hash made again", entry("run", HURRY, _of("result", "ground_truth", to={}), rehash=True), "T294", HURRY, rerun=True),
    Fault("a run that did not fire, its hash made again", entry("run", HURRY, _of("result", "fired", to=False), rehash=True), "T294", HURRY, rerun=True),
    Fault("a result of a fault edited, its hash made again", entry("fault", F + " F-1", _of("result", "first", to=0.0), rehash=True), "T294", F + " F-1", rerun=True),
]
# fmt: on
#: Results of another version of the tool are made again, and say nothing of themselves.
OTHER_VERSION = entry("test", "braking: harder", _tool, rehash=True)
