"""The kinds of nodes and links, as tables. Nothing here depends on a project: which links one needs, its schema says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

#: The status of a requirement that is demanded no longer.
OBSOLETE = "obsolete"
#: Kinds of nodes, and what a node of each is.
NODES = {
    "subsystem": "a part of the world, or the vehicle",
    "interface": "how two subsystems meet",
    "issue": "what could go wrong at an interface",
    "operational design domain": "conditions under which the vehicle is meant to drive",
    "hazard": "what may harm somebody",
    "safety goal": "what has to be reached so that a hazard is tolerable",
    "requirement": "what is demanded",
    "stage": "a step of the V-model",
    "design element": "a part of the design",
    "method": "a way to verify something",
    "rule": "what evaluates a requirement",
    "assumption": "what is taken for granted about inputs",
    "constraint": "a constraint of a spec on its parameters",
    "parameter": "a parameter of rules",
    "table": "a table of rules",
    "signal": "an input of rules",
    "place": "a zone or a line of rules",
    "rulebook": "an order of rules",
    "test": "a test written in a spec",
    "result": "what a test came to",
    "scenario": "a recording that is replayed",
    "run": "what a replayed scenario showed",
    "fault": "a fault that is put into a recording",
    "external test": "a test of another runner",
    "code": "a file of source code that says what it implements",
    "document": "a file that is evidence",
    "indicator": "a number that shows in operation whether a claim holds",
    "work": "what rules cite as their source: a paper, a regulation",
    "analysis": "an argument made by somebody",
    "review": "a second person's reading",
    "waiver": "a gap that somebody answers for",
    "person": "somebody who answers for something",
    "tool": "a program whose results are relied on",
    "malfunction": "what a fault of a tool could do, and how it would be noticed",
}  # fmt: skip

#: covers: both ends stand. orphaned: there is no such target. outdated: made from an older text of its target.
#: unwanted: the target asks for nothing of the kind. ambiguous: more than one thing has the target's name.
STATES = ("covers", "orphaned", "outdated", "unwanted", "ambiguous")


class Said(NamedTuple):
    """A finding about a link. In its texts `{source}` and `{target}` are ids, `{it}` is the source with its kind.

    help: "" for a suggestion of similar names. also: what is said of the target's place, if anything. of_target: it is about the target.
    """

    code: str
    message: str
    help: str = ""
    also: str = ""
    of_target: bool = False


class LinkKind(NamedTuple):
    """A kind of links. Each stands at its source; `down`: its target lies below it, as what is evidence lies below a requirement.

    sources, targets: kinds of nodes at its ends, none: any. converse: its name as seen from the target. findings: by state; `twice` is
    a link that is there already. circular: what is said of links that lead round in a circle (`{path}`); None where that cannot be, or does no harm.
    """

    converse: str
    sources: tuple[str, ...]
    targets: tuple[str, ...]
    down: bool = False
    findings: Mapping[str, Said] = {}
    circular: Said | None = None


_UNKNOWN = Said("T151", "{it} has the link `{link}` to `{target}`, and there is no such {targets}")
_TWICE = Said("T142", "{it} has the link `{link}` to `{target}` twice", "name it once")
_GIVEN = {"orphaned": _UNKNOWN, "twice": _TWICE}
_MANY = {
    **_GIVEN,
    "ambiguous": Said("T152", "{it} has the link `{link}` to `{target}`, and more than one thing is called so", "write its kind before it, as in `rule:{target}`"),
}  # fmt: skip


def _listed(said: str, field: str) -> dict[str, Said]:
    return {
        "twice": Said("T142", f"{{it}} lists `{{target}}` twice under `{field}`", "list it once"),
        "orphaned": Said("T205", f"{{it}} names `{{target}}` under `{field}`, but there is no such {said}",
                         f"restore the {said}, or strike it from `{field}`", of_target=True),
        "unwanted": Said("T206", f"{{it}} names `{{target}}` under `{field}`, but `{{target}}` does not satisfy {{it}}",
                         "add `satisfies {source}` to it", "`{target}` is here", of_target=True),
    }  # fmt: skip


ANY: tuple[str, ...] = ()
#: Kinds of links, by name.
LINKS = {
    "joins": LinkKind("joined_by", ("interface",), ("subsystem",)),
    "found_at": LinkKind("analysed_by", ("issue",), ("interface",)),
    "leads_to": LinkKind("answers", ("issue",), ("requirement",), True, {
        "twice": Said("T142", "{it} leads to `{target}` twice", "name it once"),
        "orphaned": Said("T137", "{it} leads to `{target}`, which does not exist"),
        "unwanted": Said("T136", "`{at}` leads to `{target}`, but `{target}` is not derived from `{at}`",
                         "add `{at}` to its `derived_from`, or drop it here", "`{target}` is here", of_target=True),
    }),
    "derived_from": LinkKind("source_of", ("requirement",), ("interface",), False, {
        "twice": Said("T142", "{it} is derived from `{target}` twice", "name it once"),
        "orphaned": Said("T132", "{it} is derived from the interface `{target}`, which does not exist"),
        "unwanted": Said("T135", "{it} is derived from `{target}`, but no issue of `{target}` leads to {it}",
                         "add the issue that it answers, or drop the link", "`{target}` is analysed here"),
    }),
    "refines": LinkKind("refined_by", ("requirement",), ("requirement",), False, {
        "twice": Said("T142", "{it} refines `{target}` twice", "name it once"),
        "orphaned": Said("T137", "{it} refines `{target}`, which does not exist"),
    }, Said("T138", "requirements refine each other in a circle: {path}",
            "a requirement cannot refine itself, however far around; drop one of the links")),
    "achieves": LinkKind("achieved_by", ("requirement",), ("safety goal",), False, _GIVEN),
    "prevents": LinkKind("prevented_by", ("safety goal",), ("hazard",), False, _GIVEN),
    "arises_from": LinkKind("gives_rise_to", ("hazard",), ("issue", "interface"), False, _MANY),
    "operates_in": LinkKind("domain_of", ("hazard",), ("operational design domain",), False, _GIVEN),
    "satisfies": LinkKind("satisfied_by", ("rule", "assumption"), ("requirement",), False, {
        "twice": Said("T210", "{it} satisfies `{target}` twice", "name it once"),
        "orphaned": Said("T201", "{it} satisfies `{target}`, which is no requirement"),
        "unwanted": Said("T203", "{it} satisfies `{target}`, which is demanded no longer", "drop the link, or the rule"),
    }),
    "metrics": LinkKind("metric_of", ("requirement",), ("rule",), True, _listed("rule", "metrics")),
    "assumptions": LinkKind("assumed_for", ("requirement",), ("assumption",), True, _listed("assumption", "assumptions")),
    "assuming": LinkKind("assumed_by", ("rule", "assumption"), ("assumption",), True, {
        "orphaned": Said("T204", "{it} relies on `{target}`, which is no assumption"),
        "unwanted": Said("T204", "{it} relies on `{target}`, which is no assumption"),
    }),
    "uses": LinkKind("used_by", ("rule", "assumption"), ("parameter", "table", "signal", "place"), True),
    "tests": LinkKind("tested_by", ("test",), ("rule", "assumption")),
    "result": LinkKind("came_to", ("result",), ("test",)),
    "shows": LinkKind("shown_by", ("scenario",), ("requirement",)),
    "replays": LinkKind("replayed_by", ("run",), ("scenario",)),
    "evaluates": LinkKind("evaluated_in", ("run",), ("rule", "assumption")),
    "challenges": LinkKind("challenged_by", ("fault",), ("requirement",)),
    "confirms": LinkKind("confirmed_by", ("external test",), ("requirement",)),
    "implements": LinkKind("implemented_by", ("code",), ("requirement",)),
    "evidence": LinkKind("evidenced_by", ("document",), ("requirement",)),
    "backed_by": LinkKind("backs", ("assumption", "analysis", "review", "design element", "malfunction"), ("document",), True),
    "at": LinkKind("stage_of", ("scenario", "document"), ("stage",)),
    "excuses": LinkKind("excused_by", ("waiver",), ("requirement",)),
    "allocated_to": LinkKind("allocates", ("requirement",), ("design element",), True, _GIVEN),
    "part_of": LinkKind("consists_of", ("design element",), ("design element",), False, _GIVEN,
                         Said("T157", "design elements are parts of each other in a circle: {path}", "drop one of the links")),
    "verified_by": LinkKind("verifies", ("requirement",), ("method",), True, _GIVEN),
    "independence": LinkKind("independence_of", ("requirement",), ("analysis",), True, _GIVEN),
    "examines": LinkKind("examined_by", ("analysis",), ANY, False, _MANY),
    "reviews": LinkKind("reviewed_by", ("review",), ANY, False, _MANY),
    "used_for": LinkKind("made_with", ("tool",), ANY, False, _MANY),
    "malfunction_of": LinkKind("may_do", ("malfunction",), ("tool",), True, _GIVEN),
    "made_by": LinkKind("made", ("analysis", "review"), ("person",), True, _GIVEN),
    "owned_by": LinkKind("owns", ("requirement", "hazard", "safety goal", "design element", "assumption", "indicator", "waiver"), ("person",), True, {
        **_GIVEN,
        "orphaned": Said("T153", "{it} belongs to `{target}`, who is none of the persons of the project",
                         "name a person by id or by name; they are declared under `persons`"),
    }),
    "indicates": LinkKind("indicated_by", ("indicator",), ANY, False, _MANY),
    "restricts": LinkKind("restricted_by", ("constraint",), ("parameter", "table")),
    "cites": LinkKind("cited_by", ("rule", "assumption"), ("work",)),
    "approved_by": LinkKind("approves", ("waiver",), ("person",), True, {
        **_GIVEN,
        "orphaned": Said("T153", "{it} is approved by `{target}`, who is none of the persons of the project",
                         "name a person by id or by name; they are declared under `persons`"),
    }),
}  # fmt: skip

#: Every link as seen from either of its ends: the kind of links, and whether it leads out of the node.
WAYS = {
    **{name: (name, True) for name in LINKS},
    **{kind.converse: (name, False) for name, kind in LINKS.items()},
}
if len(WAYS) != 2 * len(LINKS):
    raise AssertionError("two kinds of links have a name in common")

__all__ = ["LINKS", "NODES", "STATES", "WAYS", "LinkKind", "Said"]
