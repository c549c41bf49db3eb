"""Scenarios from declarations: YAML in, a recording out, the same on every run.

python -m trackmarshal.scenarios.generate specs/scenarios/cut_in.yaml specs/scenarios/cut_in.tmrec.jsonl
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trackmarshal.scenarios.recording import Recording


def generate(path: str | Path, shown: str | None = None) -> Recording:
    """The recording that a declaration (`.yaml`) describes; docs/scenarios.md says how it is written.

    Deterministic: no randomness, no clock; numbers are rounded to micrometres and the like, so that platforms agree
    up to the last digit written. Raises D120, D124, D126, D150 to D152, D250 to D255. `shown` is the path that reports print.
    """
    from trackmarshal.scenarios.generate import declaration, run

    shown = shown or str(path)
    declared = declaration.load(Path(path), shown)
    recording = run.run(declared, shown)
    if not declared.specs:
        return recording
    from trackmarshal.scenarios.generate import further, rule_truth, words

    specs = words.Specs(declared.specs)
    recording = further.with_further(recording, declared.further, specs)
    return rule_truth.with_truth(recording, declared.truth, specs)
