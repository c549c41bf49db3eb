"""Kinds of elements and links of an argument, and what it may be about, as tables. Words after the GSN Community Standard, version 3."""

from __future__ import annotations

from trackmarshal.trace.graph.kinds import NODES

#: Kinds of elements, and what an element of each says.
KINDS = {
    "goal": "a claim",
    "strategy": "how a claim follows from others",
    "solution": "the evidence that a claim rests on",
    "context": "what has to be known to understand a claim",
    "assumption": "what is taken for granted",
    "justification": "why it may be argued so",
    "counter goal": "a claim that something does not hold",
    "counter solution": "evidence that something does not hold",
}
#: What stands beside a goal or a strategy.
BESIDE = frozenset({"context", "assumption", "justification"})
COUNTER = frozenset({"counter goal", "counter solution"})
#: Kinds of links: from what is supported, from what has the context, from what challenges.
LINKS = ("supported_by", "in_context_of", "challenges")
#: What came of a defeater.
OPEN, ANSWERED, UPHELD = "open", "answered", "upheld"
#: What is no node of the link graph, and may have an element of the argument all the same.
BEYOND = {
    "project": "the project as a whole",
    "cell": "what a stage of the V-model asks of a requirement: a cell of the matrix",
    "evidence": "what there is in a cell",
    "gap": "what is missing in a cell",
    "failure": "what failed in a cell",
}
SUBJECTS = {**NODES, **BEYOND}
#: Ways from a thing to others beside the links of the graph: what stands at their start (none: anything), and what they lead to.
WALKS: dict[str, tuple[str, str]] = {
    "cells": ("requirement", "cell"),
    "evidence": ("cell", "evidence"),
    "gaps": ("cell", "gap"),
    "failures": ("cell", "failure"),
    "waivers": ("cell", "waiver"),
}
#: The thing itself, and all things of the kind that the template is about.
ITSELF, ALL = "itself", "all"
