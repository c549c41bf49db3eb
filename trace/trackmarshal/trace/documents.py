"""The documents of a requirements folder, field by field; `requirements/schema.json` is written from these tables."""

from __future__ import annotations

from trackmarshal.trace.documents_argument import ARGUMENT
from trackmarshal.trace.documents_safety import ASSURANCE, DESIGN, HAZARDS, LINK_SCHEMA, METHOD
from trackmarshal.trace.graph.kinds import OBSOLETE
from trackmarshal.trace.shapes import (
    ASIL,
    HASH,
    ID,
    INTERFACE,
    PATH,
    PATTERN,
    SUBSYSTEM,
    WORD,
    Count,
    Date,
    Field,
    Flag,
    Many,
    Pairs,
    Record,
    Text,
    Word,
    optional,
)

TEXT = Text()
REQUIREMENT_ID = Text(ID, "an id such as `S-1-A-4` or `RR-2`")
INTERFACE_ID = Text(INTERFACE, "an interface such as `AV-RO`")
SUBSYSTEM_ID = Text(SUBSYSTEM, "a subsystem such as `AV`")
STAGE_ID = Text(WORD, "a stage such as `S-2-B`, or `tests`: letters, digits, `-` and `_`")
PATTERNS = Many(Text(PATTERN, "an id, or a pattern such as `S-1-A-*`"), 1)
SUBJECT = Text(
    rf"{PATTERN}(:[a-z*][a-z0-9* -]*)?",
    "a name, a pattern such as `A-*`, or a requirement with a method such as `S-1:review`",
)
_WORD = r"[^\s|!?]+(\|[^\s|!?]+)*"
PHRASE = Text(
    rf"{_WORD}( ({_WORD}\??|!{_WORD}))*", "a phrase such as `still open`, or `not yet|ever been? seen`"
)
PROJECT_PATH = Text(PATH, "a path inside the project, relative to its folder, with forward slashes")
QUANTITY = Text(
    r"[0-9]+(\.[0-9]+)?(e-?[0-9]+)?( [A-Za-z%1][A-Za-z0-9%*/^²³·-]*)?",
    "a number with its unit, such as `1 cm`",
)
NAME = Text(r"[A-Za-z_\u0370-\u03ff][A-Za-z0-9_\u0370-\u03ff-]*", "the name of a rule or an assumption")

ISSUE = Record("issue", "One answer to the guiding question for an interface.", (
    Field("id", Text(rf"{INTERFACE}\.[0-9]+", "an id such as `AV-RO.1`"), "The interface, a dot, a number."),
    Field("text", TEXT, "What could go wrong at this interface, and why that endangers safe operation."),
    Field("leads_to", Many(REQUIREMENT_ID), "The criteria for safe operation that answer this issue."),
))  # fmt: skip

FLOW = Record("flow", "What passes over an interface.", (
    Field("kind", Word({"physical": "forces, contact, occupied space", "information": "what is perceived, signalled or transmitted"}),
          "A physical interaction or a flow of information."),
    Field("initiator", Text(rf"{SUBSYSTEM}|mutual", "a subsystem, or `mutual`"), "The subsystem that starts the interaction, or `mutual`."),
    Field("what", TEXT, "What passes."),
))  # fmt: skip

SYSTEM_MODEL = Record("system-model", "The vehicle, its environment, and how they meet.", (
    Field("document", Word({"system-model": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where the model comes from."),
    Field("subsystems", Many(Record("subsystem", "A part of the world that the vehicle drives in, or the vehicle.", (
        Field("id", SUBSYSTEM_ID, "A short name in capitals."),
        Field("title", TEXT, "The name."),
        Field("role", Word({"vehicle": "the vehicle under supervision, exactly one", "environment": "all else"}), "Vehicle or environment."),
        Field("description", TEXT, "What belongs to it."),
    )), 1), "All subsystems."),
    Field("interfaces", Many(Record("interface", "How two subsystems meet, or properties of one.", (
        Field("id", INTERFACE_ID, "The two subsystems with a hyphen between them, or one for its own properties."),
        Field("title", TEXT, "What the interface is."),
        optional("flows", Many(FLOW), "What passes, and who starts it."),
        optional("issues", Many(ISSUE, 1), "The analysis: what kind of issue with this interface could pose a risk to safe operation?"),
        optional("rationale", TEXT, "For interfaces without analysis: why there is none."),
    )), 1), "All interfaces."),
    optional("infeasible", Many(Record("infeasible", "Two subsystems that do not meet.", (
        Field("between", Text(rf"{SUBSYSTEM}-{SUBSYSTEM}", "two subsystems such as `TI-RO`"), "The two subsystems with a hyphen between them."),
        Field("reason", TEXT, "Why they don't."),
    ))), "Pairs of subsystems without an interface."),
))  # fmt: skip

REQUIREMENT = Record("requirement", "One requirement.", (
    Field("id", REQUIREMENT_ID, "Unique, never used again for another requirement."),
    Field("title", TEXT, "A few words."),
    Field("statement", TEXT, "One sentence with one `shall`."),
    Field("rationale", TEXT, "Why it is demanded."),
    optional("derived_from", Many(INTERFACE_ID), "The interfaces of the system model whose issues it answers."),
    optional("refines", Many(REQUIREMENT_ID), "The requirements above it."),
    optional("achieves", Many(REQUIREMENT_ID, 1), "The safety goals that it serves."),
    optional("allocated_to", Many(REQUIREMENT_ID, 1), "The design elements that meet it."),
    optional("verified_by", Many(REQUIREMENT_ID, 1), "The declared methods that show that it is met."),
    optional("not_verified_by", Pairs(), "Declared methods that are not used for it although its ASIL asks for them, each with the reason."),
    optional("independence", Many(REQUIREMENT_ID, 1), "For a requirement whose ASIL is decomposed among those that refine it: the analyses that argue that they are independent."),
    optional("owner", TEXT, "Who answers for it; where persons are declared, one of them, by id or name."),
    optional("adopted", TEXT, "For a requirement with neither interface nor parent: why it stands all the same."),
    Field("status", Word({"draft": "being written", "approved": "agreed", OBSOLETE: "demanded no longer; kept so that its id is not used again"}),
          "How far it has come."),
    Field("asil", Text(ASIL, "QM, A, B, C or D, decomposed ones as `B(D)`"), "Integrity level after ISO 26262."),
    Field("verification", Many(METHOD, 1), "How it is verified: methods of the schema of links, each of which evidence of its kind answers."),
    optional("metrics", Many(NAME), "The rules that S-2-B designs for it. Rules may satisfy it without being listed."),
    optional("assumptions", Many(NAME), "The input assumptions (S-2-C) that handle it, or part of it."),
    Field("source", TEXT, "Where it is written: paper and section, regulation and clause."),
    optional("foreign", Pairs(Text(verbatim=True)), "What another tool says of it and is kept for it, by the other tool's names; `import requirements` writes it."),
))  # fmt: skip

REQUIREMENTS = Record("requirements", "A list of requirements.", (
    Field("document", Word({"requirements": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where the list comes from."),
    Field("requirements", Many(REQUIREMENT), "The requirements."),
))  # fmt: skip

COUNTS = Word({
    "interface": "the interfaces that a requirement is derived from, each analysed and leading to it",
    "parent": "the requirements that it refines",
    "adoption": "the reason why it is adopted without interface or parent",
    "document": "entries of `evidence`",
    "rule": "rules that satisfy it",
    "monitor": "monitors of assumptions that satisfy it",
    "assumption": "assumptions that satisfy it, with owner, monitor and evidence",
    "test": "tests of its rules and monitors, with their results",
    "run": "replayed scenarios in which its rules were evaluated",
    "fault": "faults of campaigns that name it, each found as expected",
    "external test": "tests of other runners that name it, with their results",
    "code": "source code that says it implements it",
    "design": "design elements that it is allocated to, each with a section about it in the element's document",
    "analysis": "analyses of independence that it names, with nothing left open",
})  # fmt: skip
DEGREE = Word({"covered": "nothing less than covered", "partial": "covered or partial"})

PROJECT = Record("project", "Settings of the project.", (
    Field("name", TEXT, "The project's name, for headings."),
    Field("specs", Many(PROJECT_PATH, 1), "The folders with .spec files."),
    Field("default_spec", PROJECT_PATH, "The spec that scenarios are replayed with."),
    optional("results", PROJECT_PATH, "The folder in which results are found; `out/results` if not given."),
    optional("baseline", PROJECT_PATH, "The file of what was accepted last; against it, removals are noticed."),
    optional("tests_per_rule", Record("tests_per_rule", "How many tests every rule needs at least.", (
        optional("satisfied", Count(), "Expecting `satisfied`; 1 if not given."),
        optional("violated", Count(), "Expecting `violated`; 1 if not given."),
        optional("boundary", Count(), "On the boundary, for rules that compare numbers: about 0, and failing where limits move; 1 if not given."),
    )), "How many tests every rule needs at least."),
    optional("boundary_distance", Many(QUANTITY, 1), "By how much limits are moved to see that boundary tests fail, one a dimension; 0.01 SI units where none is given."),
    optional("scenarios", Many(Record("scenario", "A scenario and what it is evidence for.", (
        Field("path", PROJECT_PATH, "The recording."),
        Field("stage", STAGE_ID, "The stage that it is evidence at."),
        Field("expect", Word({
            "ground_truth": "every verdict lies within the recording's ground truth",
            "no_fire": "no cycle is rated unsafe",
            "fire": "a cycle is rated unsafe, by the rules in `by`",
        }), "What the run must show."),
        Field("origin", Word({"field": "recorded on a vehicle", "simulated": "from a simulation", "synthetic": "written by hand or generated"}),
              "Where the recording comes from; only `field` can fully cover a no-fire stage."),
        optional("by", Many(NAME, 1), "For `fire`: the rules that must be violated."),
        optional("requirements", PATTERNS, "The requirements that it is evidence for; all if not given. One that no rule evaluates has to be named, beside `*`."),
        optional("title", TEXT, "What happens in it."),
        optional("with", Many(PROJECT_PATH, 1), "Specs beside `default_spec` whose rules it is replayed with, such as variants of rules."),
        optional("kept", PROJECT_PATH, "For a log that is not part of the project: its run, kept in this file by `import log --keep`; `assess` does not replay it."),
    ))), "The scenarios that `assess` replays."),
    optional("campaigns", Many(PROJECT_PATH, 1), "Files of faults that `assess` puts into recordings."),
    optional("junit", Many(Record("report", "Results of another test runner.", (
        Field("path", PROJECT_PATH, "The JUnit XML, what `pytest --trackmarshal-results` wrote (.json), or a folder of such files."),
        Field("stage", STAGE_ID, "The stage that its tests are evidence at."),
        optional("tool", TEXT, "The test runner."),
        optional("names", TEXT, "A regular expression that finds ids in `suite::name` of a test, `_` standing for `-`; its first group, if it has one."),
        optional("if_there", Flag(), "true: it is made by other commands than those of the gate, and where it is not there, its tests were not run, which is a warning."),
        optional("methods", Many(METHOD, 1), "The methods of verification, beside `test`, that its tests are evidence of."),
    )), 1), "Reports of other test runners, whose tests name requirements."),
    optional("sources", Many(PROJECT_PATH, 1), "Folders of source code with comments such as `implements S-1-B-4`."),
    optional("denials", Many(PHRASE, 1), "Phrases by which a document says that it is no evidence, beside those that come with the program; `a|b` is the one word or the other, one with `?` behind it may be missing, what stands behind `!` may not follow."),
    optional("closed_loop", PROJECT_PATH, "Kept results of runs in a closed loop (`trackmarshal-closed-loop`), for the safety case."),
    optional("case_words", TEXT, "The language of the safety case, such as `de`, or the path of a file of words; English if not given."),
    optional("case_templates", PROJECT_PATH, "A folder with templates of the safety case in place of those that come with the program."),
))  # fmt: skip

V_MODEL = Record("v-model", "What each stage of the development must show, and what the gate demands.", (
    Field("document", Word({"v-model": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where the stages come from."),
    Field("project", PROJECT, "Settings of the project."),
    Field("stages", Many(Record("stage", "A step of the V-model; a column of the matrix.", (
        Field("id", STAGE_ID, "The name of the step."),
        Field("title", TEXT, "A few words."),
        Field("shows", TEXT, "What this stage must show about a requirement."),
        Field("applies_to", PATTERNS, "The requirements that have a cell here."),
        Field("counts", Many(COUNTS, 1), "The kinds of items that count."),
        optional("if_any", Flag(), "true: a requirement with no such item has no cell here, instead of an uncovered one."),
    )), 1), "The stages, in order."),
    optional("evidence", Many(Record("evidence", "A document that is evidence.", (
        Field("path", PROJECT_PATH, "The document."),
        Field("title", TEXT, "What it is."),
        Field("stage", STAGE_ID, "The stage that it is evidence at."),
        Field("requirements", PATTERNS, "The requirements that it is evidence for."),
        optional("sha256", Text(HASH, "64 hexadecimal digits"), "The hash of the reviewed version; the evidence is stale when it differs."),
        optional("methods", Many(METHOD, 1), "The methods of verification that it is evidence of, for these requirements."),
    ))), "Documents that count as evidence."),
    optional("assumptions", Many(Record("backing", "Evidence for an assumption whose spec is not part of the project, such as one of the library.", (
        Field("name", NAME, "The assumption."),
        Field("evidence", PROJECT_PATH, "The document that backs it here."),
        optional("owner", TEXT, "Who answers for it here; who the spec says if not given."),
    )), 1), "Evidence for assumptions of specs that are not part of the project."),
    optional("gate", Many(Record("demand", "Cells that must be covered for the gate to pass.", (
        Field("stage", STAGE_ID, "The stage."),
        Field("requirements", PATTERNS, "The requirements."),
        optional("at_least", DEGREE, "How much is demanded; `covered` if not given."),
    )), 1), "What the gate demands; without it, every cell must be covered."),
    optional("waivers", Many(Record("waiver", "Somebody answers for a gap, for a while.", (
        Field("id", Text(ID, "an id such as `W-1`"), "Unique."),
        optional("stages", Many(STAGE_ID, 1), "Waive missing or partial cells: at these stages ..."),
        optional("requirements", PATTERNS, "... of these requirements."),
        optional("codes", Many(Text(r"T2[0-9]{2}", "a code such as `T212`"), 1), "Or waive findings: with these codes ..."),
        optional("subjects", Many(SUBJECT, 1), "... about these rules or assumptions, or methods of requirements."),
        Field("justification", TEXT, "Why the gap is bearable."),
        Field("residual_risk", TEXT, "What may still happen while the gap is open, and what keeps it bearable."),
        Field("owner", TEXT, "Who answers for it."),
        Field("approver", TEXT, "Who accepted the residual risk: another one than the owner."),
        Field("granted", Date(), "Since when."),
        Field("expires", Date(), "The last day on which it holds: a year after `granted` at the latest."),
    ))), "Gaps that are known and accepted for a while."),
))  # fmt: skip

DOCUMENTS = {
    "system-model": SYSTEM_MODEL, "requirements": REQUIREMENTS, "v-model": V_MODEL, "hazards": HAZARDS, "design": DESIGN,
    "assurance": ASSURANCE, "link-schema": LINK_SCHEMA, "argument": ARGUMENT,
}  # fmt: skip
