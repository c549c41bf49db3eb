"""What things are called in a formula: Greek letters, what follows the first underscore as an index, and never one sign for two things."""

from __future__ import annotations

from typing import Literal

from trackmarshal.reading import layout as at
from trackmarshal.reading.layout import Layout
from trackmarshal.source import Span
from trackmarshal.syntax import ast

#: Greek letters by their names.
GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "theta": "θ", "iota": "ι", "kappa": "κ",
    "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω",
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Sigma": "Σ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
#: What a name stands for; two things of one kind and one qualified name are one thing.
Kind = Literal["parameter", "table", "function", "predicate", "machine", "event", "local", "place", "state", "member"]  # fmt: skip


def layout(name: str) -> Layout:
    """A name as formulas show it: `kappa` as κ, `v_max` as v with the index max, longer names as they are."""
    first, _, rest = name.partition("_")
    letter = GREEK.get(first, first)
    if len(letter) != 1 or not letter.isalpha():
        return at.Name(name)
    if not rest:
        return at.Name(letter)
    return at.Index(at.Name(letter), at.Word(rest.replace("_", ", ")))


class Names:
    """The names of one rule. The first thing to be shown in some way keeps it; another one that would look the same has its full name."""

    def __init__(self) -> None:
        self._shown: dict[tuple[Kind, str], Layout] = {}
        self._taken: set[Layout] = set()

    def of(self, kind: Kind, qualified: str, name: str) -> Layout:
        """How a thing is shown; `qualified` is the name by which no other of its kind goes."""
        known = self._shown.get((kind, qualified))
        if known is not None:
            return known
        others = [at.Name(f"{name}′")] if kind == "local" else [at.Name(name), at.Name(qualified)]
        made = next(
            (one for one in (layout(name), *others) if one not in self._taken),
            at.Name(f"{qualified} ({kind})"),
        )
        self._taken.add(made)
        self._shown[(kind, qualified)] = made
        return made


def bridged(item: ast.State) -> str:
    """How long a gap is that a machine bridges, as it is written; empty where it bridges none."""
    if item.bridges is None:
        return ""
    span: Span = item.bridges.__dict__["span"]
    return span.text
