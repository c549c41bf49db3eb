"""Greek letters and their spelled names: κ and kappa are one identifier, mu_left and μ_left are one too.

Letters that look like Latin ones in every font (omicron, most capitals) are not part of identifiers.
"""

from __future__ import annotations

GREEK = {
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "ε": "epsilon", "ζ": "zeta", "η": "eta", "θ": "theta",
    "ι": "iota", "κ": "kappa", "λ": "lambda", "μ": "mu", "ν": "nu", "ξ": "xi", "π": "pi",
    "ρ": "rho", "σ": "sigma", "τ": "tau", "υ": "upsilon", "φ": "phi", "χ": "chi", "ψ": "psi", "ω": "omega",
    "Γ": "Gamma", "Δ": "Delta", "Θ": "Theta", "Λ": "Lambda", "Ξ": "Xi", "Π": "Pi", "Σ": "Sigma", "Φ": "Phi", "Ψ": "Psi",
    "Ω": "Omega",
}  # fmt: skip
_LETTERS = {name: letter for letter, name in GREEK.items()}
# Other code points that keyboards give for the same letters: micro sign, increment, ohm, final sigma, variants.
GREEK.update(
    {
        "\u00b5": "mu",
        "\u2206": "Delta",
        "\u2126": "Omega",
        "ς": "sigma",
        "ϕ": "phi",
        "ϑ": "theta",
        "ϵ": "epsilon",
    }
)


def spelled(name: str) -> str:
    """The identifier with every Greek letter spelled out."""
    if name.isascii():
        return str(name)
    return "".join(GREEK.get(char, char) for char in name)


def lettered(name: str) -> str:
    """The identifier with every part (between underscores) that names a Greek letter as that letter."""
    return "_".join(_LETTERS.get(part, part) for part in name.split("_"))
