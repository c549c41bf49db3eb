"""Faults in the documents of a project: ids, fields, texts, links, levels, people."""

from __future__ import annotations

from pathlib import Path

from support.planted.edits import Fault, add, agreed, all_of, cut, each, gone, moved, put, remade, swap

R, M, V, H, D, A = (
    f"requirements/{name}.yaml"
    for name in ("requirements", "system-model", "v-model", "hazards", "design", "assurance")
)
MORE = "requirements/more.yaml"
_FAST = "It is faster than the avenue is laid out for., leads_to: [S-1]}"


#: A subsystem that meets nothing.
def _circle(root: Path) -> None:
    """The planner's page leads to itself."""
    (root / "docs" / "planner.md").symlink_to("planner.md")


APART = all_of(
    swap(
        M, "interfaces:\n", "  - {id: LA, title: lake, role: environment, description: Water.}\ninterfaces:\n"
    ),
    add(
        M,
        "infeasible:\n"
        + "".join(f"  - {{between: {one}-LA, reason: They are far apart.}}\n" for one in ("SH", "TP", "RO")),
    ),
)
#: Whatever would have to be analysed of the road, were it the vehicle.
_ALL_ANALYSED = all_of(
    swap(
        M,
        "    rationale: The shuttle takes no part.\n",
        "    issues: [{id: TP-RO.1, text: Others leave it., leads_to: [S-1]}]\n  - id: RO\n    title: properties of the road\n"
        "    issues: [{id: RO.1, text: It is not laid out for much., leads_to: [S-1]}]\n",
    ),
    swap(R, "derived_from: [SH-RO]", "derived_from: [SH-RO, TP-RO, RO]"),
)
#: An interface with one issue, and with two that lead to the same requirement.
SLIDES = (_FAST, f"{_FAST}\n      - {{id: SH-RO.2, text: It slides in the rain., leads_to: [S-1]}}")


def another(
    id_: str,
    fields: str = "adopted: Because it is so.",
    statement: str = "The shuttle shall ring.",
    asil: str = "QM",
) -> str:
    """A document with one more requirement."""
    return (
        "document: requirements\ntitle: One more\nrequirements:\n"
        f"  - id: {id_}\n    title: A bell\n    statement: {statement}\n    rationale: So that it is heard.\n    {fields}\n"
        f"    status: approved\n    asil: {asil}\n    verification: [review]\n    source: a note\n"
    )


#: What is said against the argument, and where there is confidence in it.
ARGUED = put(
    "requirements/argument.yaml",
    b"document: argument\ntitle: What is said of it\ndefeaters:\n"
    b"  - {id: D-1, challenges: S-1, text: Nobody has driven there., evidence: true, owner: P-1, state: answered, answer: Somebody will.}\n"
    b"confidence:\n  - {id: ACP-1, at: S-1, text: Two people found the same.}\n  - {id: ACP-2, at: S-2, text: The brakes were measured.}\n",
)
_ARGUMENT = "requirements/argument.yaml"

# fmt: off
FAULTS = [
    # 1: ids
    Fault("an id twice", put(MORE, another("S-2").encode()), "T130", "S-2"),
    Fault("an id twice in one document", swap(R, "- id: S-2\n", "- id: S-1\n"), "T130", "S-1"),
    Fault("an id of a requirement and of a hazard", swap(H, "- id: HZ-1\n", "- id: S-1\n"), "T130", "S-1"),
    Fault("an id twice among persons", swap(A, "{id: P-3,", "{id: P-2,"), "T130", "P-2"),
    Fault("an interface twice", swap(M, "- id: TP-RO\n", "- id: SH-RO\n"), "T130", "SH-RO"),
    Fault("an issue twice", swap(M, "{id: SH-TP.2,", "{id: SH-TP.1,"), "T130", "SH-TP.1"),
    Fault("a stage twice", swap(V, "{id: S-4-B, title: field", "{id: S-4-A, title: field"), "T130", "S-4-A"),
    Fault("a waiver twice", add(V, "  - {id: W-1, codes: [T208], subjects: [A-SEEN], justification: none, residual_risk: none, owner: Dana Driver, approver: Sam Safety, granted: 2026-01-01, expires: 2026-12-31}\n"), "T130", "W-1"),
    Fault("ids that differ by O and 0", put(MORE, (another("S-O") + another("S-0").partition("requirements:\n")[2]).encode()), "T131", "S-0"),
    Fault("ids that differ by case", put(MORE, (another("S-Bell") + another("S-bell").partition("requirements:\n")[2]).encode()), "T131", "S-bell"),
    Fault("an id with a Cyrillic letter", put(MORE, another("Ѕ-7").encode()), "T124"),
    Fault("an id without a number", put(MORE, another("bell").encode()), "T124"),
    Fault("an id used again for something else", swap(R, "The shuttle shall not overtake.", "The shuttle shall ring at each stop."), "T225", "S-9"),
    Fault("a requirement that is demanded no longer, demanded again", swap(R, "status: obsolete", "status: approved"), "T376", "S-9"),
    # 2: mandatory fields
    Fault("no statement", swap(R, "    statement: The shuttle shall drive no faster than 12 m/s.\n", ""), "T120"),
    Fault("no ASIL", swap(R, "    asil: B(C)\n", ""), "T120"),
    Fault("no rationale", swap(R, "    rationale: The avenue is laid out for that.\n", ""), "T120"),
    Fault("no status", swap(R, "    status: obsolete\n", ""), "T120"),
    Fault("no verification", swap(R, "    verification: [monitor]\n", ""), "T120"),
    Fault("no source", swap(R, "    source: permit of the campus, 2\n", ""), "T120"),
    Fault("no title", swap(R, "    title: Permitted speed\n", ""), "T120"),
    Fault("no safe state", swap(H, "    safe_state: at rest on the avenue\n", ""), "T120"),
    Fault("an empty rationale", swap(R, "rationale: The avenue is laid out for that.", "rationale: ''"), "T126"),
    Fault("a misspelt field", swap(R, "    source: concept of the drive, 5\n", "    source: concept of the drive, 5\n    asill: D\n"), "T121"),
    # 3: types
    Fault("a list for a text", swap(R, "title: Brakes", "title: [Brakes]"), "T122"),
    Fault("a text for a list", swap(R, "verification: [monitor]", "verification: monitor"), "T122"),
    Fault("an unknown status", swap(R, "status: obsolete", "status: forgotten"), "T123"),
    Fault("an unknown ASIL", swap(R, "asil: B(C)", "asil: E"), "T124"),
    Fault("an unknown method", swap(R, "verification: [monitor]", "verification: [faith]"), "T123"),
    Fault("a range of a unit that there is not", swap(H, "from: 36 km/h, to: 11 m/s", "from: 36 knots, to: 11 m/s"), "T124", "ODD-1"),
    Fault("a range of two dimensions", swap(H, "from: 36 km/h, to: 11 m/s", "from: 36 km/h, to: 11 s"), "T127", "ODD-1"),
    Fault("a range of one quantity twice", swap(H, "      - {quantity: objects.length", "      - {quantity: ego.v, from: 10.5 m/s, to: 11 m/s}\n      - {quantity: objects.length"), "T130", "ODD-1"),
    Fault("a range upside down", swap(H, "from: 36 km/h, to: 11 m/s", "from: 11 m/s, to: 36 km/h"), "T127", "ODD-1"),
    Fault("a time without a unit", swap(H, "tolerance: 500 ms", "tolerance: '500'"), "T124"),
    Fault("a Boolean for a text", swap(R, "title: Brakes", "title: no"), "T128"),
    Fault("no day", swap(V, "expires: 2026-12-31", "expires: next year"), "T125"),
    Fault("a day that is none", swap(V, "expires: 2026-12-31", "expires: 2026-02-30"), "T125"),
    Fault("a count that is none", swap(V, "satisfied: 1", "satisfied: -1"), "T122"),
    # 4: wording
    Fault("two demands in one", swap(R, "than its brakes can do.", "than its brakes can do, and it shall ring."), "T140", "S-2"),
    Fault("no demand", swap(R, "The shuttle shall ask for no more", "The shuttle asks for no more"), "T140", "S-2"),
    Fault("a weak word", swap(R, "no more than its brakes can do.", "no more than is appropriate."), "T225", "S-2"),
    Fault("another number in a statement", swap(R, "no faster than 12 m/s", "no faster than 13 m/s"), "T225", "S-1"),
    # 5: links
    Fault("an unknown interface", swap(R, "derived_from: [SH-RO]", "derived_from: [SH-RX]"), "T132", "S-1"),
    Fault("an unknown parent", swap(R, "refines: [S-3]\n    allocated_to: [DE-2]", "refines: [S-7]\n    allocated_to: [DE-2]"), "T137", "S-31"),
    Fault("an issue struck whose requirement another one leads to", all_of(agreed(swap(M, SLIDES[0], SLIDES[1])), swap(M, SLIDES[1], SLIDES[0])), "T224", "SH-RO.2"),
    Fault("an issue made harmless", swap(M, "It is faster than the avenue is laid out for.", "Nothing much happens there."), "T224", "SH-RO.1"),
    Fault("an issue that is still to be written", swap(M, "text: It is faster than the avenue is laid out for.", "text: TODO"), "T126"),
    Fault("an issue that leads to nothing", swap(M, "leads_to: [S-1]", "leads_to: [S-11]"), "T137", "SH-RO.1"),
    Fault("an issue that leads nowhere", swap(M, "leads_to: [S-1]", "leads_to: []"), "T134", "SH-RO.1"),
    Fault("a page that is a link to itself", all_of(gone("docs/planner.md"), _circle), "T250", "docs/planner.md"),
    Fault("issues that lead to each other's requirements", all_of(swap(M, "leads_to: [S-3]", "leads_to: [S-0]"), swap(M, "leads_to: [S-4]", "leads_to: [S-3]"), swap(M, "leads_to: [S-0]", "leads_to: [S-4]")), "T224", "SH-TP.1"),
    Fault("an issue that leads elsewhere", swap(M, "leads_to: [S-4]", "leads_to: [S-2]"), "T135", "S-4"),
    Fault("an unknown rule", swap(R, "metrics: [braking]", "metrics: [breaking]"), "T205", "breaking"),
    Fault("an unknown assumption", swap(R, "assumptions: [A-SEEN]", "assumptions: [A-SENSE]"), "T205", "A-SENSE"),
    Fault("a rule of another requirement", swap(R, "metrics: [braking]", "metrics: [braking, speed_limit]"), "T206", "speed_limit"),
    Fault("an unknown goal", swap(R, "derived_from: [SH-RO]\n    achieves: [SG-1]", "derived_from: [SH-RO]\n    achieves: [SG-7]"), "T151", "S-1"),
    Fault("an unknown element", swap(R, "allocated_to: [DE-1, DE-2]", "allocated_to: [DE-1, DE-7]"), "T151", "S-3"),
    Fault("an unknown hazard", swap(H, "prevents: [HZ-1]", "prevents: [HZ-7]"), "T151", "SG-1"),
    Fault("an unknown domain", swap(H, "operates_in: [ODD-1]", "operates_in: [ODD-7]"), "T151", "HZ-1"),
    Fault("an unknown stage", swap(V, "How the planner keeps room, stage: S-2-A", "How the planner keeps room, stage: S-2-X"), "T148", "S-2-X"),
    Fault("an owner who is nobody", swap(V, "owner: Dana Driver", "owner: x"), "T153", "W-1"),
    Fault("an interval that is over before a fault is answered", agreed(swap(H, "tolerance: 500 ms", "tolerance: 200 ms")), "T173", "SG-1"),
    Fault("a reviewed requirement of nobody", agreed(swap(R, "    verified_by: [M-3]\n    owner: P-1", "    verified_by: [M-3]")), "T179", "S-3"),
    Fault("a requirement of nobody", swap(R, "    verified_by: [M-2]\n    owner: P-1", "    verified_by: [M-2]\n    owner: Somebody"), "T153", "S-31"),
    Fault("a subsystem that there is not", swap(M, "initiator: SH, what: tyre forces", "initiator: TX, what: tyre forces"), "T147", "SH-RO"),
    # 6 and 7: kinds of links, and links that say nothing
    Fault("a link to itself", swap(R, "refines: [S-3]\n    allocated_to: [DE-2]", "refines: [S-3, S-31]\n    allocated_to: [DE-2]"), "T138", "S-31"),
    Fault("a link twice", swap(R, "derived_from: [SH-RO]", "derived_from: [SH-RO, SH-RO]"), "T142", "S-1"),
    Fault("a goal twice", swap(R, "derived_from: [SH]\n    achieves: [SG-1]", "derived_from: [SH]\n    achieves: [SG-1, SG-1]"), "T142", "S-2"),
    # 8: circles
    Fault("two requirements refine each other", swap(R, "derived_from: [SH-TP]\n    achieves: [SG-1]\n    allocated_to: [DE-1, DE-2]", "derived_from: [SH-TP]\n    refines: [S-31]\n    achieves: [SG-1]\n    allocated_to: [DE-1, DE-2]"), "T138", "S-3"),
    Fault("parts of each other", all_of(swap(D, "asil: C, owner: P-1}\n  - {id: DE-2", "asil: C, owner: P-1, part_of: [DE-2]}\n  - {id: DE-2"), swap(D, "It plans., asil: C", "It plans., part_of: [DE-1], asil: C")), "T157", "DE-1"),
    # 21 and 33: methods and indicators
    Fault("a method that is not used any more", swap(R, "    verified_by: [M-1]\n    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [monitor]", "    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [monitor]"), "T376", "S-4"),
    Fault("a method given up for a reason", swap(R, "    verified_by: [M-1]\n    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [monitor]", "    not_verified_by: {M-1: It takes long., M-2: Tests and scenarios show more than reading does.}\n    verification: [monitor]"), "T376", "S-4"),
    Fault("a reason struck", swap(R, "    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [monitor]", "    verification: [monitor]"), "T171", "S-4"),
    Fault("a method asked for from a lower level on", swap(D, "title: proof, highly_recommended_from: D", "title: proof, highly_recommended_from: C"), "T376", "M-3"),
    Fault("a method that is something else", swap(D, "title: proof,", "title: a quick look,"), "T376", "M-3"),
    Fault("a work under another title", swap(A, "issue 3\", equations", "issue 3.\", equations"), "T376", "WK-1"),
    Fault("a work that nothing cites", swap(A, "works:\n", "works:\n  - {id: WK-2, title: A paper}\n"), "T178", "WK-2", status=0),
    Fault("an unknown method of a project", swap(R, "verified_by: [M-2]", "verified_by: [M-7]"), "T151", "S-31"),
    Fault("an indicator without a threshold", swap(A, "threshold: at most 1 in 100 km, ", ""), "T120"),
    Fault("an indicator without data", swap(A, "data: the supervisor's log of each drive, ", ""), "T120"),
    Fault("an indicator of no claim", swap(A, "claims: [SG-1], owner", "claims: [SG-7], owner"), "T151", "SPI-1"),
    Fault("an indicator with another threshold", swap(A, "at most 1 in 100 km", "at most 1 in 10 km"), "T376", "SPI-1"),
    Fault("an indicator struck", cut(A, "indicators:\n", ""), "T376", "SPI-1"),
    # 23: conditions
    Fault("conditions that no recording has", swap(H, "to: 11 m/s", "to: 12 m/s"), "T254", "ODD-1"),
    Fault("conditions of which no recording says anything", swap(H, "{quantity: objects.length,", "{quantity: objects.height,"), "T254", "ODD-1"),
    Fault("conditions claimed no longer", swap(H, "      - {quantity: objects.length, from: 5 m, to: 5 m}\n", ""), "T376", "ODD-1"),
    # 9: parents
    Fault("a requirement from nowhere", put(MORE, another("S-7", "owner: P-1").encode()), "T139", "S-7"),
    # 10 and 19, 20: links that are needed
    Fault("a requirement without an element", swap(R, "    refines: [S-3]\n    allocated_to: [DE-2]\n", "    refines: [S-3]\n"), "T376", "S-31"),
    Fault("a hazard without a goal", swap(H, "safety_goals:\n", "  - {id: HZ-2, title: Doors close on somebody, situation: At a stop., severity: S2, exposure: E4, controllability: C2, asil: B, rationale: It happens.}\nsafety_goals:\n"), "T150", "HZ-2"),
    Fault("a goal that no requirement serves", add(H, "  - {id: SG-2, title: Doors, statement: The doors shall not close on anybody., prevents: [HZ-1], asil: C, safe_state: open doors, tolerance: 1 s}\n"), "T150", "SG-2"),
    Fault("an interface that is not analysed", swap(M, "    issues:\n      - {id: SH-RO.1, text: It is faster than the avenue is laid out for., leads_to: [S-1]}\n", "    rationale: Nothing happens there.\n"), "T133", "SH-RO"),
    Fault("an interface taken away", cut(M, "  - id: TP-RO\n", ""), "T224", "TP-RO"),
    Fault("what passes over an interface struck", swap(M, "    flows: [{kind: physical, initiator: SH, what: tyre forces}]\n", ""), "T224", "SH-RO"),
    Fault("what passes over an interface said otherwise", swap(M, "what: tyre forces", "what: nothing much"), "T224", "SH-RO"),
    Fault("another reason why an interface is not analysed", swap(M, "The shuttle takes no part.", "x"), "T224", "TP-RO"),
    Fault("another reason why two never meet, said at an interface", all_of(agreed(APART), swap(M, "  - {between: TP-LA, reason: They are far apart.}\n", ""), swap(M, "infeasible:\n", "  - {id: TP-LA, title: others and lake, rationale: x}\ninfeasible:\n")), "T224", "TP-LA"),
    Fault("less that belongs to a part of the world", swap(M, "description: Busses and cars on the avenue.", "description: Busses on the avenue."), "T224", "TP"),
    Fault("a part of the world that is something else", swap(M, "title: others, role", "title: parked busses, role"), "T224", "TP"),
    Fault("two that meet, and never meet", add(M, "infeasible:\n  - {between: RO-TP, reason: They do not meet.}\n"), "T130", "RO-TP"),
    Fault("two that never meet for two reasons", all_of(agreed(APART), add(M, "  - {between: TP-LA, reason: Nobody looked.}\n")), "T130", "TP-LA"),
    Fault("an interface in both orders", swap(M, "  - id: TP-RO\n", "  - {id: RO-TP, title: road and others, rationale: Nobody looked.}\n  - id: TP-RO\n"), "T130", "TP-RO"),
    Fault("another reason why two never meet", all_of(agreed(APART), swap(M, "SH-LA, reason: They are far apart.", "SH-LA, reason: x")), "T224", "SH-LA"),
    Fault("no vehicle", swap(M, "role: vehicle", "role: environment"), "T145"),
    Fault("two vehicles", swap(M, "title: road, role: environment", "title: road, role: vehicle"), "T145"),
    Fault("what a stage must show said otherwise", swap(V, "shows: that nothing fires", "shows: what there is"), "T371", "S-4-B"),
    Fault("another vehicle", all_of(agreed(_ALL_ANALYSED), swap(M, "role: vehicle", "role: environment"), swap(M, "title: road, role: environment", "title: road, role: vehicle")), "T224", "RO"),
    # 30 and 31: what is said of the argument
    Fault("why there is confidence in it, said otherwise", all_of(agreed(ARGUED), swap(_ARGUMENT, "Two people found the same.", "Trust us.")), "T376", "ACP-1"),
    Fault("confidence in something else", all_of(agreed(ARGUED), swap(_ARGUMENT, "id: ACP-1, at: S-1", "id: ACP-1, at: S-3")), "T376", "ACP-1"),
    Fault("confidence in two things under one id", all_of(agreed(ARGUED), swap(_ARGUMENT, "id: ACP-2", "id: ACP-1")), "T130", "ACP-1"),
    Fault("two objections under one id", all_of(agreed(ARGUED), swap(_ARGUMENT, "confidence:\n", "  - {id: D-1, challenges: S-2, text: It may snow., evidence: true, owner: P-2, state: open}\nconfidence:\n")), "T130", "D-1"),
    Fault("a template of the argument of its own", all_of(agreed(ARGUED), swap(_ARGUMENT, "defeaters:\n", "groups: All of them.\ndefeaters:\n")), "T376"),
    Fault("templates of the argument struck", all_of(agreed(all_of(ARGUED, swap(_ARGUMENT, "defeaters:\n", "groups: All of them.\ndefeaters:\n"))), swap(_ARGUMENT, "groups: All of them.\n", "")), "T376"),
    Fault("confidence struck", all_of(agreed(ARGUED), cut(_ARGUMENT, "  - {id: ACP-2", "")), "T376", "ACP-2"),
    Fault("a challenge that is without evidence from now on", all_of(agreed(ARGUED), swap(_ARGUMENT, "evidence: true, ", "")), "T376", "D-1"),
    # 16 and 15: reviews
    Fault("a review by the owner", swap(A, "by: [P-4]", "by: [P-1]"), "T166", "RV-1"),
    Fault("a review of tomorrow", swap(A, "made: 2026-03-01", "made: 2026-06-03"), "T165", "RV-1"),
    Fault("an analysis of next year", swap(A, "made: 2026-02-10", "made: 2027-02-10"), "T165", "AN-1"),
    Fault("a review that is open", swap(A, "outcome: accepted", "outcome: open"), "T376", "RV-1"),
    Fault("a review struck", cut(A, "reviews:\n", "works:\n"), "T376", "RV-1"),
    Fault("a review of another version", swap(A, "{id: S-3, fingerprint: '", "{id: S-2, fingerprint: '"), "T376", "RV-1"),
    # 17: levels
    Fault("an ASIL lowered", swap(R, "asil: C\n    verified_by: [M-1]\n    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [test, scenario]", "asil: A\n    verified_by: [M-1]\n    not_verified_by: {M-2: Tests and scenarios show more than reading does.}\n    verification: [test, scenario]"), "T160", "S-1"),
    Fault("all ASILs lowered", all_of(each(R, "asil: C\n", "asil: A\n"), each(H, "asil: C\n", "asil: A\n"), swap(H, "severity: S3", "severity: S1"), swap(R, "asil: A(C)", "asil: QM(A)"), swap(R, "asil: B(C)", "asil: A(A)")), "T376", "HZ-1"),
    Fault("an element below its requirement", swap(D, "It plans., asil: C", "It plans., asil: QM"), "T164", "DE-2"),
    Fault("a goal below its hazard", swap(H, "    prevents: [HZ-1]\n    asil: C", "    prevents: [HZ-1]\n    asil: B"), "T159", "SG-1"),
    Fault("a hazard's ASIL lowered", swap(H, "controllability: C2\n    asil: C", "controllability: C2\n    asil: A"), "T158", "HZ-1"),
    Fault("a hazard's exposure lowered", swap(H, "exposure: E4", "exposure: E2"), "T158", "HZ-1"),
    # 18: decomposition
    Fault("a decomposition that does not add up", swap(R, "asil: B(C)", "asil: A(C)"), "T161", "S-3"),
    Fault("a decomposition that the standard does not know", swap(R, "asil: A(C)", "asil: QM(C)"), "T161", "S-3"),
    Fault("a decomposition that forgets its level", swap(R, "asil: B(C)", "asil: B(B)"), "T163", "S-32"),
    Fault("independence that nobody argues", swap(R, "    independence: [AN-1]\n", ""), "T162", "S-3"),
    Fault("independence argued by an analysis of something else", agreed(swap(A, "method: dependent failures", "method: timing")), "T162", "S-3"),
    Fault("parts that fail with one element", agreed(all_of(swap(R, "refines: [S-3]\n    allocated_to: [DE-2]", "refines: [S-3]\n    allocated_to: [DE-3]"), swap(R, "refines: [S-3]\n    allocated_to: [DE-1]", "refines: [S-3]\n    allocated_to: [DE-3]"), swap(D, "methods:\n", "  - {id: DE-3, title: unit, asil: B(C), owner: P-1}\nmethods:\n"))), "T162", "S-3"),
    Fault("a decomposition into one part", swap(R, "asil: A(C)", "asil: C"), "T161", "S-3"),
    # what cannot be read
    Fault("a conflict of a merge", swap(R, "    title: Brakes\n", "<<<<<<< ours\n    title: Brakes\n=======\n    title: Stopping\n>>>>>>> theirs\n"), "T105", status=2),
    Fault("a conflict in the V-model", swap(V, "  name: campus shuttle\n", "<<<<<<< ours\n  name: campus shuttle\n=======\n  name: a shuttle\n>>>>>>> theirs\n"), "T105", status=2),
    Fault("a document cut off", remade(R, lambda data: data[: data.index(b"[SH-TP]") + 3]), "T105", status=2),
    Fault("a document emptied", put(R, b""), "T103", status=2),
    Fault("a document in Latin-1", remade(R, lambda data: data.replace(b"What the shuttle has", "Was das Gefährt".encode("latin-1"))), "T104", status=2),
    Fault("a tab", swap(R, "    title: Brakes\n", "\ttitle: Brakes\n"), "T105", status=2),
    Fault("a key twice", swap(R, "    title: Brakes\n", "    title: Brakes\n    title: Stopping\n"), "T109", status=2),
    Fault("an alias", swap(R, "title: Brakes", "title: &a Brakes"), "T107", status=2),
    Fault("a text that looks like another one", swap(V, "The shuttle has not been on the avenue yet.", "The shuttle has \u202eeunev\u202c seen it."), "T105", status=2),
    Fault("two documents in one", add(H, "---\ndocument: hazards\ntitle: More\n"), "T106", status=2),
    Fault("a document that is none", swap(H, "document: hazards", "document: hazard"), "T113", status=2),
    Fault("a suffix in capitals", moved(H, "requirements/hazards.YAML"), "T101", status=2),
    Fault("no V-model", gone(V), "E410", status=2),
    Fault("the V-model in another file", all_of(moved(V, "requirements/model.yaml"), moved(H, V)), "T112", status=2),
    Fault("a second system model", put("requirements/world.yaml", b"document: system-model\ntitle: Another\nsubsystems: [{id: X, title: x, role: vehicle, description: x}]\ninterfaces: [{id: X, title: x, rationale: x}]\n"), "T129"),
    # documents taken away
    Fault("a requirement struck", cut(R, "  - id: S-9\n", ""), "T223", "S-9"),
    Fault("a requirement struck whose gap is waived", cut(R, "  - id: S-1\n", "  - id: S-2\n"), "T223", "S-1"),
    Fault("a requirement struck with all that it holds", cut(R, "  - id: S-2\n", "  - id: S-3\n"), "T223", "S-2"),
    Fault("a hazard analysis thrown away", gone(H), "T376", "HZ-1"),
    Fault("design thrown away", gone(D), "T376", "DE-1"),
    Fault("a method of verification struck", swap(R, "verification: [test, fault injection]\n    metrics: [braking]", "verification: [test]\n    metrics: [braking]"), "T376", "S-2"),
    Fault("a derivation struck on both sides", all_of(swap(R, "    derived_from: [SH]\n", ""), swap(M, "leads_to: [S-2]", "leads_to: [S-4]"), swap(R, "    derived_from: [SH-TP]\n    achieves: [SG-1]\n    allocated_to: [DE-1]\n", "    derived_from: [SH-TP, SH]\n    achieves: [SG-1]\n    allocated_to: [DE-1]\n")), "T224", "S-2"),
    Fault("made obsolete", swap(R, "    owner: P-1\n    status: approved\n    asil: A(C)", "    owner: P-1\n    status: obsolete\n    asil: A(C)"), "T376", "S-31"),
]
# fmt: on
