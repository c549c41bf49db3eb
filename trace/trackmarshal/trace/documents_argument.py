"""The document `argument`, field by field: templates that the argument is made of, defeaters that people raise, confidence points."""

from __future__ import annotations

from trackmarshal.trace.graph.kinds import NODES, WAYS
from trackmarshal.trace.gsn.kinds import ALL, ANSWERED, ITSELF, KINDS, OPEN, SUBJECTS, UPHELD, WALKS
from trackmarshal.trace.shapes import ID, Field, Flag, Many, Record, Text, Word, optional

TEXT = Text()
NAME = Text(r"[a-z][a-z0-9-]*", "a name in small letters such as `safety-goal`")
CONDITION = Record("subject_condition", "What an attribute of the thing has to be.", (
    Field("attribute", TEXT, "An attribute, such as `asil`, `status` or `outcome`."),
    Field("is", Many(TEXT, 1), "The values that fit; `*` stands for any characters."),
))  # fmt: skip

STEP = Record("step", "Elements that a template's element is linked to: one for each thing that the step leads to.", (
    optional("template", NAME, "The template of these elements."),
    optional("over", Word(dict.fromkeys((ITSELF, ALL, *WALKS, *WAYS), "")),
             "Links of the graph (or their converse), `itself`, `all` things of the template's kind, or what is in a cell: `cells`, `evidence`, `gaps`, `failures`, `waivers`."),
    optional("where", Many(CONDITION, 1), "Only to things of which all of this is true."),
    optional("without", Many(Word(dict.fromkeys(WAYS, "")), 1), "Only to things that have none of these links."),
    optional("if_any", Word(dict.fromkeys(NODES, "")), "Only in projects that have a thing of this kind."),
    optional("cites", TEXT, "In place of a template: the id of an element that another template makes."),
    optional("module", TEXT, "With `cites`: the module in which it has to be, as a public goal."),
))  # fmt: skip
_STEPS = Many(STEP, 1)

TEMPLATE = Record("template", "An element of the argument, for each thing that steps lead to with it. In its texts, `{id}`, `{title}` and any attribute of the thing stand for what it says.", (
    Field("name", NAME, "Unique in the document."),
    Field("element", Word(KINDS), "The kind of element."),
    Field("about", Word(SUBJECTS), "The kind of things that it is about."),
    Field("id", TEXT, "The element's id. gsn2x reads the kind off its first letters: G, S, Sn, C, A, J, CG, CSn."),
    Field("text", TEXT, "What it says."),
    optional("supported_by", _STEPS, "What supports it."),
    optional("in_context_of", _STEPS, "Contexts, assumptions and justifications."),
    optional("challenged_by", _STEPS, "Counter goals and counter solutions against it."),
    optional("undeveloped", Word({"never": "an end without support is an error", "open": "where nothing supports it", "always": "whatever supports it",
                              "left-out": "the element is left out where nothing supports it"}),
             "Whether it is marked as undeveloped; `never` if not given."),
    optional("module", Flag(), "true: where the argument does not fit into one picture, a module begins here."),
))  # fmt: skip

DEFEATER = Record("defeater", "Somebody says that an element of the argument does not hold.", (
    Field("id", Text(ID, "an id such as `D-1`"), "Unique."),
    Field("challenges", TEXT, "The element, by its id, or the thing that it is about: an id, or `kind:id`."),
    Field("text", TEXT, "Why it does not hold."),
    optional("evidence", Flag(), "true: it refers to evidence, and is drawn as a counter solution."),
    Field("owner", TEXT, "Who answers for it."),
    Field("state", Word({OPEN: "nobody has answered", ANSWERED: "it does not defeat the element, and `answer` says why", UPHELD: "the element is defeated"}), "What came of it."),
    optional("answer", TEXT, "Why the element holds all the same."),
))  # fmt: skip

POINT = Record("confidence", "An assurance claim point: where confidence is argued for by itself.", (
    Field("id", Text(ID, "an id such as `ACP-1`"), "Unique."),
    Field("at", TEXT, "The element, by its id."),
    optional("to", TEXT, "For a link: the element at its other end."),
    Field("text", TEXT, "Why there is confidence in it."),
))  # fmt: skip

ARGUMENT = Record("argument", "How the argument is made, in place of the templates that come with the program; what people say against it.", (
    Field("document", Word({"argument": "this document"}), "Says which document this is."),
    Field("title", TEXT, "The title."),
    optional("source", TEXT, "Where it comes from."),
    optional("top", NAME, "The template of the top goal, which is about the project."),
    optional("groups", TEXT, "What a goal says that stands for several, where there are many side by side: `{first}` and `{last}` are ids, `{number}` says how many."),
    optional("templates", Many(TEMPLATE, 1), "Templates; those of the program if not given."),
    optional("defeaters", Many(DEFEATER, 1), "What people say against the argument."),
    optional("confidence", Many(POINT, 1), "Confidence points."),
))  # fmt: skip
