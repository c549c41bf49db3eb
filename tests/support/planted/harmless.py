"""Edits of which nothing follows: comments, layout, titles, order, line ends, names, places."""

from __future__ import annotations

import re

from support.planted.documents import APART, ARGUED
from support.planted.edits import (
    Harmless,
    add,
    agreed,
    all_of,
    committed,
    cut,
    each,
    git,
    gone,
    moved,
    put,
    remade,
    swap,
)
from support.planted.evidence import CALM, DRIVE, GENERATED, OTHER_VERSION, REPORTED, ran
from support.planted.specs import BY_NAME

R, M, V, H, A = (
    f"requirements/{name}.yaml"
    for name in ("requirements", "system-model", "v-model", "hazards", "assurance")
)
S, C, N, B = "specs/rules.spec", "specs/vehicle.spec", "specs/signals.spec", "specs/order.spec"
F, STORE = "specs/scenarios/faults.yaml", "out/results/evidence.jsonl"


#: A demand of which a part is enough in place of one on everything.
HALF_ENOUGH = swap(
    V,
    '  - {stage: S-1-A, requirements: ["*"]}\n',
    "  - {stage: S-1-A, requirements: [S-1], at_least: partial}\n",
)


def _crlf(data: bytes) -> bytes:
    return data.replace(b"\n", b"\r\n")


def _blank_lines(data: bytes) -> bytes:
    return data.replace(b"\n  - ", b"\n\n  - ")


def _loose(data: bytes) -> bytes:
    return re.sub(rb"([-+*/]) ", rb"\1  ", data.replace(b"  require   ", b"  require\n      "))


#: A rule about a timeline at the sample where it begins, with its tests.
_FIRST = b"""module first

use signals

rule steady "No faster than the road is laid out for"
  satisfies S-2
  along     plan as p
  require   always p.v <= 20 m/s

test steady "at it"
  given  plan = line(v: 20 m/s)
  expect satisfied, margin 0 m/s

test steady "below"
  given  plan = line(v: 9 m/s)
  expect satisfied

test steady "above"
  given  plan = line(v: 21 m/s)
  expect violated
"""

# fmt: off
EDITS = [
    # comments
    Harmless("a comment in a spec", add(S, "\n-- nothing\n")),
    Harmless("a comment in a rule", swap(S, "  require   p.v <= v_max\n", "  -- the permit\n  require   p.v <= v_max\n")),
    Harmless("a comment struck", swap(S, "-- From rear bumper to front bumper, along the road.\n", "")),
    Harmless("a comment in requirements", add(R, "# nothing\n")),
    Harmless("a comment in the V-model", swap(V, "gate:\n", "# what is demanded\ngate:\n")),
    Harmless("a comment in a campaign", add(F, "# nothing\n")),
    # layout
    Harmless("blank lines in a spec", each(S, "\n\n", "\n\n\n")),
    Harmless("another layout of a rule", remade(S, _loose)),
    Harmless("a rule in one line", swap(S, "  for all   p in plan\n  require   p.v <= v_max\n", "  for all p in plan require p.v <= v_max\n")),
    Harmless("a parameter in another layout", swap(C, "param length     : m     = 5 m        in [3, 8]     source", "param length : m = 5 m in [3, 8] source")),
    Harmless("a table in another layout", swap(C, "linear clamp\n  | 0 m/s", "linear clamp | 0 m/s")),
    Harmless("parentheses", swap(S, "require   p.v <= v_max", "require   (p.v) <= (v_max)")),
    Harmless("blank lines in requirements", remade(R, _blank_lines)),
    Harmless("a list in lines of its own", swap(R, "    verification: [test, scenario]\n", "    verification:\n      - test\n      - scenario\n")),
    Harmless("a statement in quotes", swap(R, "statement: The shuttle shall drive no faster than 12 m/s.", 'statement: "The shuttle shall drive no faster than 12 m/s."')),
    Harmless("a statement in two lines", swap(R, "statement: The shuttle shall drive no faster than 12 m/s.", "statement: >-\n      The shuttle shall drive\n      no faster than 12 m/s.")),
    Harmless("a list in one line", swap(V, "    stages: [S-4-B]\n", "    stages:\n    - S-4-B\n")),
    Harmless("blanks at line ends", each(V, "\n", "  \n")),
    # line ends and marks
    Harmless("CRLF in a spec", remade(S, _crlf)),
    Harmless("CRLF in signals", remade(N, _crlf)),
    Harmless("CRLF in requirements", remade(R, _crlf)),
    Harmless("CRLF in the V-model", remade(V, _crlf)),
    Harmless("CRLF in the hazard analysis", remade(H, _crlf)),
    Harmless("CRLF in a campaign", remade(F, _crlf)),
    Harmless("CRLF in documents", all_of(*(remade(f"docs/{name}.md", _crlf) for name in ("planner", "sensors", "independence")))),
    Harmless("CRLF in recordings", all_of(*(remade(f"specs/scenarios/{name}.tmrec.jsonl", _crlf) for name in ("calm", "hurry")))),
    Harmless("CRLF in a declared scenario and its track", all_of(agreed(GENERATED), remade("specs/scenarios/hurry.yaml", _crlf), remade("specs/tracks/avenue.yaml", _crlf))),
    Harmless("CRLF in the evidence store", remade(STORE, _crlf)),
    Harmless("a byte order mark", remade(R, lambda data: b"\xef\xbb\xbf" + data)),
    Harmless("no line end at the end", remade(R, bytes.rstrip)),
    # titles and reasons
    Harmless("an interface of others with their like", swap(M, "  - id: TP-RO\n", "  - {id: TP, title: properties of others, rationale: Theirs.}\n  - {id: TP-TP, title: others among themselves, rationale: The shuttle takes no part.}\n  - id: TP-RO\n")),
    Harmless("a reason why two never meet, said at an interface", all_of(agreed(APART), swap(M, "  - {between: TP-LA, reason: They are far apart.}\n", ""), swap(M, "infeasible:\n", "  - {id: TP-LA, title: others and lake, rationale: They are far apart.}\ninfeasible:\n"))),
    Harmless("covered where a part was enough", all_of(agreed(HALF_ENOUGH), swap(V, "{stage: S-1-A, requirements: [S-1], at_least: partial}", "{stage: S-1-A, requirements: [S-1]}"))),
    Harmless("one of two covered where a part was enough", all_of(agreed(swap(V, "  - {stage: S-1-A, requirements: [\"*\"]}\n", "  - {stage: S-1-A, requirements: [S-1, S-2], at_least: partial}\n")), swap(V, "  - {stage: S-1-A, requirements: [S-1, S-2], at_least: partial}\n", "  - {stage: S-1-A, requirements: [S-2], at_least: partial}\n  - {stage: S-1-A, requirements: [\"*\"]}\n"))),
    Harmless("a stage that asks also where there is nothing", all_of(agreed(swap(V, "counts: [assumption]}", "counts: [assumption], if_any: true}")), swap(V, ", if_any: true}", "}"))),
    Harmless("a report that has to be there", all_of(agreed(all_of(REPORTED, ran("fast"))), swap(V, ", if_there: true}", "}"))),
    Harmless("more that passes over an interface", swap(M, "what: tyre forces}]", "what: tyre forces}, {kind: information, initiator: RO, what: painted lines}]")),
    Harmless("a title of a requirement", swap(R, "title: Permitted speed", "title: Speed")),
    Harmless("a title of a rule", swap(S, '"No faster than the campus permits"', '"Speed"')),
    Harmless("a title of a test", swap(S, '"coasting"', '"rolling on"')),
    Harmless("a title of a stage", swap(V, "title: rules,", "title: rules and monitors,")),
    Harmless("an objection, where there was none", ARGUED),
    Harmless("what faults are put into made a scenario", all_of(agreed(swap(V, f"    - {{path: {CALM}, title: {DRIVE}\n", "")), swap(V, "  campaigns:", f"    - {{path: {CALM}, title: {DRIVE}\n  campaigns:"))),
    Harmless("a title of a scenario", swap(V, "title: A calm drive", "title: Nothing happens")),
    Harmless("a title of a document", swap(R, "title: What the shuttle has to keep to", "title: Requirements")),
    Harmless("a rationale", swap(R, "rationale: The avenue is laid out for that.", "rationale: So it was laid out.")),
    Harmless("the reason of an assumption", swap(S, "What is not seen cannot be kept clear of.", "Nobody keeps clear of what is not seen.")),
    Harmless("the reason of a constraint", swap(C, "what is comfortable is not more than the brakes can do", "brakes end there")),
    Harmless("the source of a parameter", swap(C, "permit of the campus, 2", "permit of the campus, section 2")),
    Harmless("the title of a fault", swap(F, "A bus stands right ahead", "A bus stands in the way")),
    # order
    Harmless("keys in another order", swap(R, "    asil: B(C)\n    verified_by: [M-1]\n", "    verified_by: [M-1]\n    asil: B(C)\n")),
    Harmless("elements in another order", swap(R, "allocated_to: [DE-1, DE-2]", "allocated_to: [DE-2, DE-1]")),
    Harmless("demands in another order", swap(V, "  - {stage: S-1-A, requirements: [\"*\"]}\n  - {stage: S-2-A, requirements: [S-31]}\n", "  - {stage: S-2-A, requirements: [S-31]}\n  - {stage: S-1-A, requirements: [\"*\"]}\n")),
    Harmless("tests in another order", all_of(cut(S, 'test braking "coasting"', 'test braking "harder"'), add(S, '\ntest braking "coasting"\n  given  plan = line(v: 5 m/s)\n  expect satisfied\n'))),
    Harmless("rules in another order", all_of(cut(S, "rule speed_limit", "rule braking"), add(S, '\nrule speed_limit "No faster than the campus permits"\n  satisfies S-1\n  source    concept eq 1\n  for all   p in plan\n  require   p.v <= v_max\n'))),
    Harmless("parameters in another order", all_of(swap(C, "param v_max      : m/s   = 12 m/s     in [1, 20]    source \"permit of the campus, 2\"\n", ""), swap(C, "-- How hard", "param v_max      : m/s   = 12 m/s     in [1, 20]    source \"permit of the campus, 2\"\n\n-- How hard"))),
    Harmless("lines of the store in another order", remade(STORE, lambda data: b"\n".join(sorted(data.split(b"\n")[:-1])) + b"\n")),
    Harmless("fields of a signal in another order", swap(N, "signal ego     : state { x: m, y: m,", "signal ego     : state { y: m, x: m,")),
    Harmless("fields of an object of a test in another order", swap(S, "objects = [{ x: 60 m, length: 5 m }]", "objects = [{ length: 5 m, x: 60 m }]")),
    Harmless("what a test gives in another order", swap(S, '"far away"\n  given  ego = { x: 0 m, v: 6 m/s }\n  given  objects = [{ x: 60 m, length: 5 m }]\n', '"far away"\n  given  objects = [{ x: 60 m, length: 5 m }]\n  given  ego = { x: 0 m, v: 6 m/s }\n')),
    # names and places
    Harmless("another unit in a test", all_of(swap(S, "[{ age: 200 ms }]", "[{ age: 0.2 s }]"), swap(S, "given  plan = line(v: 9 m/s)\n  expect satisfied, margin 3 m/s", "given  plan = line(v: 32.4 km/h)\n  expect satisfied, margin 10.8 km/h"))),
    Harmless("a name for what a test gives", all_of(swap(S, "with v[3] = 13 m/s", "with v[3] = much"), add(S, "\ndefine much = 13 m/s\n"))),
    Harmless("another name for what a test gives", all_of(agreed(add(S, f"\ndefine much = 13 m/s\n{BY_NAME}")), each(S, "much", "plenty"))),
    Harmless("a variable under another name, and in the test that says where", all_of(swap(S, "  for all   p in plan\n  require   p.v <= v_max", "  for all   q in plan\n  require   q.v <= v_max"), swap(S, "at p = 3", "at q = 3"))),
    Harmless("a timeline's sample under another name", all_of(agreed(put("specs/first.spec", _FIRST)), each("specs/first.spec", "p.v", "q.v"), swap("specs/first.spec", "plan as p", "plan as q"))),
    Harmless("a tolerance in another unit", swap(H, "tolerance: 500 ms", "tolerance: 0.5 s")),
    Harmless("a range in another unit", swap(H, "from: 36 km/h, to: 11 m/s", "from: 10 m/s, to: 39.6 km/h")),
    Harmless("a variable under another name", swap(S, "  for all   p in plan\n  require   -p.a <= min(b_max, bite(p.v))", "  for all   q in plan\n  require   -q.a <= min(b_max, bite(q.v))")),
    Harmless("Greek and signs", swap(S, "  for all   p in plan\n  require   p.v <= v_max\n", "  for all   p in plan\n  require   p.v ≤ v_max\n")),
    Harmless("another unit of the same value", swap(C, "= 200 ms", "= 0.2 s ")),
    Harmless("a document in a folder of its own", moved(H, "requirements/safety/hazards.yaml")),
    Harmless("a requirement in a file of its own", all_of(cut(R, "  - id: S-9\n", ""), put("requirements/old.yaml", (
        b"document: requirements\ntitle: Old\nrequirements:\n  - id: S-9\n    title: No overtaking\n    statement: The shuttle shall not overtake.\n    rationale: Once so, not any more.\n"
        b"    adopted: An earlier permit.\n    status: obsolete\n    asil: C\n    verification: [test]\n    source: permit of the campus, issue 1\n")))),
    Harmless("a page that is evidence in a folder of its own", all_of(moved("docs/planner.md", "docs/plans/planner.md"), swap(V, "path: docs/planner.md", "path: docs/plans/planner.md"))),
    Harmless("a recording in a folder of its own", all_of(moved("specs/scenarios/hurry.tmrec.jsonl", "specs/drives/hurry.tmrec.jsonl"), swap(V, "path: specs/scenarios/hurry.tmrec.jsonl", "path: specs/drives/hurry.tmrec.jsonl"))),
    Harmless("a page that is no evidence", put("docs/notes.md", b"# Notes\n")),
    Harmless("a spec's file moved, with its name", all_of(moved(B, "specs/books/order.spec"), swap("specs/books/order.spec", "module order", "module books.order"))),
    Harmless("an unrelated rule with its tests", put("specs/doors.spec", (
        b"module doors\n\nuse signals\n\n"
        b'rule no_reverse "Not backwards"\n  satisfies S-2\n  for all   p in plan\n  require   p.v >= 0 m/s\n\n'
        b'test no_reverse "at rest"\n  given  plan = { v: [0 m/s, 0 m/s] }\n  expect satisfied, margin 0 m/s\n\n'
        b'test no_reverse "on"\n  given  plan = line(v: 3 m/s)\n  expect satisfied\n\n'
        b'test no_reverse "back"\n  given  plan = { v: [1 m/s, -1 m/s] }\n  expect violated\n'))),
    Harmless("one more test", add(S, '\ntest braking "soft"\n  given  plan = { v: [5 m/s, 4 m/s], a: [-2 m/s^2, 0 m/s^2] }\n  expect satisfied\n')),
    Harmless("tests of another runner, with other names and parameters", all_of(REPORTED, agreed(ran("fast", "slow[1]", "slow[2]")), ran("faster", "slow[3]", "slower"))),
    Harmless("a test of another runner more, and one beside it that names nothing", all_of(REPORTED, agreed(ran("fast", skipped="idle")), ran("fast", "slow", skipped="idle"))),
    # around it
    Harmless("no results yet", gone("out")),
    Harmless("a folder without git", gone(".git")),
    Harmless("committed", all_of(add("docs/notes.md", "# Notes\n"), git("add", "."), committed("notes"))),
    Harmless("the title of a domain", swap(H, "title: the avenue", "title: avenue")),
    Harmless("a result of another version of the tool", OTHER_VERSION),
    Harmless("a store with an empty line", add(STORE, "\n")),
]
# fmt: on
