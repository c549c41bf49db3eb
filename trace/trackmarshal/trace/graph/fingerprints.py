"""What nodes say, as fingerprints: by these, links and reviews know whether what they were made for still says the same."""

from __future__ import annotations

import hashlib

from trackmarshal.trace.graph.graph import Node

#: What is decided of hazards and goals, and read by whoever reviews them.
_RATED = {
    "hazard": ("severity", "exposure", "controllability", "asil"),
    "safety goal": ("asil", "safe_state", "tolerance"),
}
#: And what else is read by whoever judges whether what is demanded, or rated, is right: each by its name, so that nothing moves from the one to the other.
#: Titles and owners name things and people; links are the baseline's.
_READ = {
    "requirement": ("asil", "verification", "source", "adopted", "rationale"),
    "hazard": ("rationale",),
    "analysis": ("open",),
}
#: Of these, all that is declared is read.
_DECLARED = (
    "operational design domain",
    "design element",
    "method",
    "tool",
    "malfunction",
    "indicator",
    "work",
    "waiver",
)


def fingerprint(node: Node) -> str:
    """The fingerprint of what a node says: the engine's or the file's; else the SHA-256 of its statement, situation, description or title, with what hazards
    and goals are rated as, and what else is read of requirements and hazards.

    How the lines of a text are broken does not matter, nor the order of methods.
    """
    said = node.attributes
    texts = (said.get(name, "") for name in ("statement", "situation", "description"))
    text = next(filter(None, texts), node.title)
    more = [said[name] for name in _RATED.get(node.kind, ()) if name in said]
    more += [
        f"{name}: {', '.join(sorted(said[name].split(', '))) if name == 'verification' else said[name]}"
        for name in _READ.get(node.kind, ())
        if said.get(name)
    ]
    text = "\n".join((text, *more))
    return said.get("fingerprint") or hashlib.sha256(" ".join(text.split()).encode()).hexdigest()


def version(node: Node) -> str:
    """The fingerprint that a review names of what it read: that of the node, and, where this is of its text alone, of what else it says."""
    more = [node.says] if node.says else []
    if node.kind in _DECLARED:
        more += [f"{name}: {text}" for name, text in sorted(node.attributes.items()) if name != "owner"]
    own = fingerprint(node)
    return hashlib.sha256("\n".join([own, *more]).encode()).hexdigest() if more else own
