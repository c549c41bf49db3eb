"""The documents beside requirements, field by field: hazards and goals, design, what people did, and which links are needed."""

from __future__ import annotations

from trackmarshal.trace.graph.kinds import LINKS, NODES, WAYS
from trackmarshal.trace.shapes import (
    ASIL,
    HASH,
    ID,
    PATH,
    PATTERN,
    Count,
    Date,
    Field,
    Flag,
    Many,
    Record,
    Text,
    Word,
    optional,
)

TEXT = Text()
ANY_ID = Text(ID, "an id such as `H-1`")
NODE = Text(r"\S(.*\S)?", "the id of anything in the project, or `kind:id`")
PROJECT_PATH = Text(PATH, "a path inside the project, relative to its folder, with forward slashes")
#: An integrity level, or a decomposed one.
LEVEL = Text(ASIL, "QM, A, B, C or D, decomposed ones as `B(D)`")
PLAIN_LEVEL = Word(
    {"QM": "no safety goal is needed", "A": "the lowest", "B": "", "C": "", "D": "the highest"}
)
INTERVAL = Text(
    r"(?![0.]+ )[0-9]+(\.[0-9]+)? (ms|s|min|h)", "a time with its unit, above 0, such as `300 ms`"
)
_END = Text(
    r"-?[0-9]+(\.[0-9]+)?(e-?[0-9]+)?( [A-Za-z%1][A-Za-z0-9%*/^²³·-]*)?",
    "a number with its unit, such as `12 m/s`",
)
PERSONS = Many(ANY_ID, 1)
#: Which there are, the schema of links says.
METHOD = Text(r"[a-z]+([ -][a-z0-9]+)*", "a method in small letters such as `fault injection`")

DOMAIN = Record("domain", "Conditions under which the vehicle is meant to drive.", (
    Field("id", ANY_ID, "Unique, such as `ODD-1`."),
    Field("title", TEXT, "A few words."),
    Field("description", TEXT, "Roads, weather, speeds, other road users: what belongs to it, and what does not."),
    optional("ranges", Many(Record("range", "Between which values a quantity may be; the recordings of the project reach both ends.", (
        Field("quantity", Text(r"[^\W\d]\w*\.[^\W\d]\w*", "a signal and a field of it, such as `ego.v`"), "A field of a record, or of the elements of a set."),
        Field("from", _END, "The least value."),
        Field("to", _END, "The greatest value."),
    )), 1), "Ranges that are claimed, as far as signals tell."),
    optional("source", TEXT, "Where it is written."),
))  # fmt: skip

HAZARD = Record("hazard", "What may harm somebody, in which situation, and how bad that is.", (
    Field("id", ANY_ID, "Unique, such as `H-1`."),
    Field("title", TEXT, "A few words."),
    Field("situation", TEXT, "The hazardous event: what happens, in which situation."),
    optional("arises_from", Many(NODE, 1), "Issues or interfaces of the system model that it was found at."),
    optional("operates_in", Many(ANY_ID, 1), "The operational design domains in which it may happen."),
    Field("severity", Word({"S0": "no injuries", "S1": "light and moderate injuries", "S2": "severe injuries, survival probable",
                            "S3": "life-threatening injuries, survival uncertain"}), "How bad the harm is."),
    Field("exposure", Word({"E0": "incredible", "E1": "very low probability", "E2": "low probability", "E3": "medium probability",
                            "E4": "high probability"}), "How probable the situation is."),
    Field("controllability", Word({"C0": "controllable in general", "C1": "simply controllable", "C2": "normally controllable",
                                   "C3": "difficult to control or uncontrollable"}), "Whether the persons at risk can avoid the harm."),
    Field("asil", PLAIN_LEVEL, "The integrity level that follows from these three by ISO 26262-3, table 4; held against it."),
    Field("rationale", TEXT, "Why severity, exposure and controllability are what they are."),
    optional("owner", TEXT, "Who answers for it; where persons are declared, one of them, by id or name."),
    optional("source", TEXT, "Where it is written."),
))  # fmt: skip

GOAL = Record("safety_goal", "What has to be reached so that a hazard is tolerable.", (
    Field("id", ANY_ID, "Unique, such as `SG-1`."),
    Field("title", TEXT, "A few words."),
    Field("statement", TEXT, "One sentence with one `shall`."),
    Field("prevents", Many(ANY_ID, 1), "The hazards that it answers."),
    Field("asil", PLAIN_LEVEL, "At least that of each of its hazards."),
    Field("safe_state", TEXT, "The state without unreasonable risk that is reached when something fails."),
    Field("tolerance", INTERVAL, "The fault-tolerant time interval: how long a fault may last before somebody is harmed."),
    optional("owner", TEXT, "Who answers for it; where persons are declared, one of them, by id or name."),
    optional("source", TEXT, "Where it is written."),
))  # fmt: skip

HAZARDS = Record("hazards", "What may harm somebody, and the goals that follow.", (
    Field("document", Word({"hazards": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where the analysis comes from."),
    optional("domains", Many(DOMAIN, 1), "Operational design domains."),
    optional("hazards", Many(HAZARD, 1), "Hazards."),
    optional("safety_goals", Many(GOAL, 1), "Safety goals."),
))  # fmt: skip

DESIGN = Record("design", "What the system consists of, and the methods that show something about it.", (
    Field("document", Word({"design": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where it is written."),
    optional("elements", Many(Record("element", "A part of the design that requirements are allocated to.", (
        Field("id", ANY_ID, "Unique, such as `DE-1`."),
        Field("title", TEXT, "A few words."),
        optional("description", TEXT, "What it does."),
        optional("part_of", Many(ANY_ID, 1), "The elements that it is a part of."),
        optional("document", PROJECT_PATH, "The Markdown file that says how it meets each requirement allocated to it, in a section whose heading names the requirement."),
        optional("asil", LEVEL, "The integrity level that it is developed to; at least that of every requirement allocated to it."),
        optional("owner", TEXT, "Who answers for it; where persons are declared, one of them, by id or name."),
    )), 1), "Design elements."),
    optional("methods", Many(Record("method", "A way to verify something.", (
        Field("id", ANY_ID, "Unique, such as `M-1`."),
        Field("title", TEXT, "A few words."),
        optional("description", TEXT, "How it is done."),
        optional("highly_recommended_from", Word({"A": "", "B": "", "C": "", "D": ""}), "The lowest ASIL for which a standard highly recommends it."),
        optional("source", TEXT, "Where it is written."),
    )), 1), "Methods."),
))  # fmt: skip

#: Classes of tools by ISO 26262-8, 11.4.5.
IMPACT = {"TI1": "no fault of it can do so", "TI2": "a fault of it can do so"}
DETECTION = {"TD1": "high confidence", "TD2": "medium confidence", "TD3": "less than that"}

_MADE = (
    Field("by", PERSONS, "The persons who made it."),
    Field("made", Date(), "The day on which it was finished."),
    optional("document", PROJECT_PATH, "The file in which it is written down."),
)

ASSURANCE = Record("assurance", "Who did what: persons, tools, analyses, reviews.", (
    Field("document", Word({"assurance": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("persons", Many(Record("person", "Somebody who answers for something.", (
        Field("id", ANY_ID, "Unique, such as `P-1`."),
        Field("title", TEXT, "The name, as it stands where specs and waivers name an owner."),
        optional("role", TEXT, "What the person does in the project."),
        optional("organisation", TEXT, "Where the person belongs."),
    )), 1), "Persons. Where there are any, every owner is one of them."),
    optional("tools", Many(Record("tool", "A program whose results are relied on.", (
        Field("id", ANY_ID, "Unique, such as `T-1`."),
        Field("title", TEXT, "The name."),
        Field("version", TEXT, "The version that is used."),
        optional("used_for", Many(NODE, 1), "What it makes or checks."),
        optional("impact", Word(IMPACT), "The tool impact: whether a fault of it could put an error into what is delivered, or keep one from being found."),
        optional("detection", Word(DETECTION), "The tool error detection: how sure it is that such a fault is prevented or noticed."),
        optional("confidence", Word({"TCL1": "no qualification needed", "TCL2": "qualification of medium rigour", "TCL3": "qualification of high rigour"}),
                 "The tool confidence level that follows from these two by ISO 26262-8, table 3; held against them."),
        optional("rationale", TEXT, "Why impact and detection are what they are."),
        optional("open", Many(TEXT, 1), "What keeps more confidence from being claimed, each in a sentence."),
    )), 1), "Tools, or parts of a chain of tools."),
    optional("malfunctions", Many(Record("malfunction", "What a fault of a tool could do, and how it would be noticed.", (
        Field("id", ANY_ID, "Unique, such as `MF-1`."),
        Field("title", TEXT, "What the tool would do wrong."),
        Field("of_tool", Many(ANY_ID, 1), "The tools that it could be a fault of."),
        Field("effect", TEXT, "What could come of it in what is delivered."),
        Field("noticed", TEXT, "How it is prevented, or noticed; what would not be noticed, too."),
        optional("shown_in", Many(PROJECT_PATH, 1), "The files that show so: tests, reports, pages."),
    )), 1), "Malfunctions of tools."),
    optional("indicators", Many(Record("indicator", "A number that shows in operation whether what is claimed still holds.", (
        Field("id", ANY_ID, "Unique, such as `SPI-1`."),
        Field("title", TEXT, "What is counted or measured."),
        Field("threshold", Text(r"(at most|at least) [0-9](?!.* in [0.]+( |$)).*", "such as `at most 1 in 1000 km`"), "From where on somebody has to act."),
        Field("data", TEXT, "Where the data comes from: which log, which signal, how often."),
        Field("claims", Many(NODE, 1), "The goals, requirements or assumptions that it is about."),
        optional("owner", TEXT, "Who looks at it; where persons are declared, one of them, by id or name."),
    )), 1), "Performance indicators in operation."),
    optional("works", Many(Record("work", "What rules cite as their source.", (
        Field("id", ANY_ID, "Unique, such as `WK-1`."),
        Field("title", TEXT, "The text of the `reference` by which specs cite it."),
        optional("equations", Count(), "How many numbered equations it has: a rule that cites another one cites nothing."),
    )), 1), "Works that rules cite: papers, regulations, concepts."),
    optional("analyses", Many(Record("analysis", "An argument over something, made by somebody.", (
        Field("id", ANY_ID, "Unique, such as `AN-1`."),
        Field("title", TEXT, "A few words."),
        Field("method", Word({
            "hazard analysis": "what may harm somebody", "fault tree": "from a hazard down to its causes", "failure modes": "from parts up to effects",
            "dependent failures": "common causes and cascades: the argument of independence", "triggering conditions": "what the intended function cannot cope with",
            "timing": "how long things take", "other": "something else, which the title says",
        }), "What kind of analysis it is."),
        Field("of", Many(NODE, 1), "What it is about."),
        optional("open", Many(TEXT, 1), "What it does not show, each in a sentence; until there is none, what it is to show is not covered."),
        *_MADE,
    )), 1), "Analyses."),
    optional("reviews", Many(Record("review", "A second person's reading of something.", (
        Field("id", ANY_ID, "Unique, such as `RV-1`."),
        optional("title", TEXT, "A few words."),
        Field("of", Many(Record("reviewed", "What was read, and which version of it.", (
            Field("id", NODE, "What was read."),
            Field("fingerprint", Text(HASH, "64 hexadecimal digits"), "Of the version that was read; the message about another one gives it."),
        )), 1), "What was read."),
        *_MADE,
        Field("outcome", Word({"accepted": "it may stand as it is", "open": "something has to change"}), "What came of it."),
    )), 1), "Reviews."),
))  # fmt: skip

_WHERE = Many(Record("condition", "What the node at the other end has to be like.", (
    Field("attribute", TEXT, "An attribute of it, such as `outcome`, `stage` or `status`."),
    Field("is", Many(TEXT, 1), "The values that fit; `*` stands for any characters."),
)), 1)  # fmt: skip

WAY = Record("way", "One way to meet a need: links, a field, or something that is reached.", (
    optional("link", Word(dict.fromkeys(WAYS, "")), "Links of this kind, or their converse: those of the node itself."),
    optional("reaches", Word(dict.fromkeys(NODES, "")), "Nodes of this kind below it, over any number of links."),
    optional("field", TEXT, "An attribute of the node that is filled in."),
    optional("kinds", Many(Word(dict.fromkeys(NODES, "")), 1), "With `link`: only nodes of these kinds count."),
    optional("where", _WHERE, "Only nodes count of which all of this is true."),
    optional("at_least", Count(), "How many are needed; 1 if not given. Of reviews, by so many persons."),
    optional("every", TEXT, "With `link`: an attribute of nodes at its other end that is an ASIL; every node of which it is no higher than that of the node itself is wanted."),
    optional("unless", TEXT, "With `every`: an attribute of the node that lists those that are not wanted."),
    optional("at_most", Count(), "More than so many are a finding of their own."),
))  # fmt: skip

NEED = Record("need", "What a node of some kind needs.", (
    Field("any_of", Many(WAY, 1), "The need is met where one of these ways is."),
    optional("ids", Many(Text(PATTERN, "an id, or a pattern such as `S-1-A-*`"), 1), "Only of nodes with these ids."),
    optional("from_asil", PLAIN_LEVEL, "Only of nodes with this integrity level, or a higher one."),
    optional("stages", Many(Text(PATTERN, "a stage, or a pattern"), 1), "Only of requirements that one of these stages asks something of."),
    optional("counts", TEXT, "Only of requirements that a stage asks something of which counts items of this kind, such as `rule`."),
    optional("if_any", Word(dict.fromkeys(NODES, "")), "Only in projects that have a node of this kind."),
    optional("obsolete", Flag(), "true: also of what is demanded no longer."),
    optional("where", _WHERE, "Only of nodes of which all of this is true."),
    optional("level", Word({"error": "fails the gate", "warning": "is told", "note": "is told quietly"}), "What an unmet need is; `error` if not given."),
    optional("code", Text(r"T[0-9]{3}", "a code such as `T150`"), "The code of the finding; T150 if not given."),
    optional("says", TEXT, "The finding's message, in which `{it}` is the node and `{id}` its id."),
    optional("help", TEXT, "What to do about it; `{id}` is the node's id."),
))  # fmt: skip

LINK_SCHEMA = Record("link-schema", "Which links a node needs: what stands under `nodes` is all that is asked, in place of the schema that comes with the program.", (
    Field("document", Word({"link-schema": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where these rules come from."),
    Field("nodes", Many(Record("node_kind", "A kind of nodes, and what they need.", (
        Field("kind", Word(dict.fromkeys(NODES, "")), "The kind."),
        Field("needs", Many(NEED, 1), "What each node of this kind needs."),
    ))), "Kinds of nodes that need something."),
    optional("permitted", Many(Record("permitted", "Ends that links of a kind may have.", (
        Field("link", Word(dict.fromkeys(LINKS, "")), "The kind of links."),
        Field("from", Many(Text(PATTERN, "an id, or a pattern"), 1), "Ids that it may stand at."),
        Field("to", Many(Text(PATTERN, "an id, or a pattern"), 1), "Ids that it may lead to."),
    )), 1), "Which levels may be linked: where a kind of links is named here, each link of it fits one of its entries."),
    optional("methods", Many(Record("verification_method", "A method that requirements name under `verification`, and what is evidence of its kind.", (
        Field("name", METHOD, "The word that stands under `verification`."),
        Field("means", TEXT, "What is done."),
        optional("any_of", Many(WAY, 1), "What answers it: one of these ways, seen from the requirement. Evidence that names the method under `methods` always does."),
    )), 1), "Methods of verification, in place of those that come with the program."),
    optional("reviewed", Many(Record("reviewed_kind", "Nodes that a person is to have reviewed.", (
        Field("kind", Word(dict.fromkeys(NODES, "")), "The kind."),
        optional("ids", Many(Text(PATTERN, "an id, or a pattern such as `S-1-A-*`"), 1), "Only nodes with these ids."),
        optional("from_asil", PLAIN_LEVEL, "Only nodes with this integrity level, or a higher one."),
    ))), "What a person is to have reviewed, in place of what comes with the program; what nobody reviewed, the baseline lists."),
))  # fmt: skip

__all__ = ["ASSURANCE", "DESIGN", "HAZARDS", "LINK_SCHEMA", "METHOD"]
