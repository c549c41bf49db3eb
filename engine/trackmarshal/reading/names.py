"""What things are called in a formula: Greek letters, what follows the first underscore as an index, and never one sign for two things."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from trackmarshal.reading import layout as at
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.terminal import text
from trackmarshal.source import Span
from trackmarshal.syntax import ast

#: Greek letters by their names.
GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "theta": "θ", "iota": "ι", "kappa": "κ",
    "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω",
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Sigma": "Σ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
#: What a name stands for; two things of one kind and one qualified name are one thing.
Kind = Literal["parameter", "table", "function", "predicate", "machine", "event", "local", "place", "state", "member", "field"]  # fmt: skip


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
        #: As a line of text has them: `v_ego` looks the same as a name of its own and as the v of ego.
        self._taken: set[str] = set()

    def of(self, kind: Kind, qualified: str, name: str) -> Layout:
        """How a thing is shown; `qualified` is the name by which no other of its kind goes."""
        others = [at.Name(f"{name}′")] if kind == "local" else [at.Name(name), at.Name(qualified)]
        return self._first(kind, qualified, (layout(name), *others))

    def field(self, record: Layout, name: str) -> Layout:
        """`v` of `p`, with the record as its index."""
        of, full = layout(name), f"{text(record)}.{name}"
        index = (
            at.Row((of.index, at.Sign(","), record)) if isinstance(of, at.Index) else record
        )  # one index, not an index of an index
        return self._first(
            "field", full, (at.Index(of.base if isinstance(of, at.Index) else of, index), at.Name(full))
        )

    def _first(self, kind: Kind, qualified: str, ways: Sequence[Layout]) -> Layout:
        """The first way to show a thing in which no other one is shown."""
        known = self._shown.get((kind, qualified))
        if known is not None:
            return known
        made = next((one for one in ways if text(one) not in self._taken), at.Name(f"{qualified} ({kind})"))
        self._taken.add(text(made))
        self._shown[(kind, qualified)] = made
        return made


def bridged(item: ast.State) -> str:
    """How long a gap is that a machine bridges, as it is written; empty where it bridges none."""
    if item.bridges is None:
        return ""
    span: Span = item.bridges.__dict__["span"]
    return span.text
