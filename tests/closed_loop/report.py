"""The kept results as a page: `python -m closed_loop.report` writes docs/closed-loop-results.md."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from typing import Any

from closed_loop import places
from closed_loop.condition import FAULTS
from closed_loop.origin import alike, origins
from closed_loop.result import CONTACT, OFF

PAGE = places.REPOSITORY / "docs" / "closed-loop-results.md"
Run = dict[str, Any]


def page(kept: dict[str, Any], sha256: str) -> str:
    """The page; a pure function of the kept results."""
    runs: list[Run] = kept["runs"]
    inside = [run for run in runs if not run["beyond"]]
    bad = [run for run in inside if run["outcome"] in (OFF, CONTACT)]
    lines = [
        "# What faults in the closed loop came to",
        "",
        "Made by `python -m closed_loop.report` of `tests/closed_loop/results.json`; [closed-loop.md](closed-loop.md) says what was run.",
        "Results and what they were made from, by SHA-256:",
        "",
        "| what | hash |",
        "|---|---|",
        f"| `tests/closed_loop/results.json` | `{sha256}` |",
        *(f"| {what} | `{value}` |" for what, value in kept["origin"].items()),
        "",
        f"{len(runs)} runs, {len(inside)} of them with no more wrong than the Supervisor answers for; of these {len(bad)} left the road "
        "or ended in contact.",
        "",
        "Reaction: from when the Supervisor has the first faulty cycle to its first unsafe decision, s, least to most, and in how many of the "
        "runs; `below`: runs in which the layer below stopped the car by itself. Clearance: least distance of the body to a border, m; "
        "gap: to another car.",
        "",
        "| fault | requirement | reaction | found by | below | outcomes | clearance | gap |",
        "|---|---|---|---|---:|---|---:|---:|",
        *(_row(fault, [run for run in runs if run["fault"] == fault]) for fault in FAULTS),
    ]  # fmt: skip
    if bad:
        lines += ["", "Off the road or in contact:", "", *map(_bad, bad)]
    unclean = [run for run in runs if run["unsafe_before"]]
    if unclean:
        names = ", ".join(sorted({run["name"].split(".", 1)[1] for run in unclean}))
        lines += ["", f"In {len(unclean)} runs a cycle was unsafe before anything was wrong: {names}."]
    return "\n".join(lines) + "\n"


def _row(fault: str, runs: Sequence[Run]) -> str:
    kind = FAULTS[fault]
    delays = sorted(run["reaction"]["after"] for run in runs if run["reaction"])
    reaction = f"{delays[0]:.2f} to {delays[-1]:.2f} ({len(delays)} of {len(runs)})" if delays else "none"
    found = _counted(
        [run["reaction"]["found"][0] for run in runs if run["reaction"] and run["reaction"]["found"]]
    )
    below = sum(run["reaction"] is None and run["below"] is not None for run in runs)
    outcomes = _counted([run["outcome"] for run in runs])
    gaps = [run["gap"] for run in runs if run["gap"] is not None]
    gap = f"{min(gaps):.1f}" if gaps else ""
    title = f"{kind.title} (beyond {kind.beyond})" if kind.beyond else kind.title
    return (
        f"| {fault} {title} | {kind.requirement} | {reaction} | {found} | {below or ''} | {outcomes} | "
        f"{min(run['clearance'] for run in runs):.2f} | {gap} |"
    )  # fmt: skip


def _counted(words: Sequence[str]) -> str:
    counts = {word: words.count(word) for word in sorted(set(words))}
    return ", ".join(f"{word} {count}" for word, count in sorted(counts.items(), key=lambda pair: -pair[1]))


def _bad(run: Run) -> str:
    approved = run["approved_clearance"]
    was = "there was none" if approved is None else f"its clearance was {approved:.2f} m"
    what = run["contact"] or f"{-run['clearance']:.2f} m off the road"
    return f"- {run['name']}: {what}; the emergency trajectory that was approved last: {was}"


def main() -> int:
    text = places.RESULTS.read_bytes()
    kept = json.loads(text)
    PAGE.write_text(page(kept, hashlib.sha256(text).hexdigest()), encoding="utf-8")
    stale = [what for what, value in alike(origins()).items() if kept["origin"].get(what) != value]
    if stale:
        print(f"the results are stale: changed since are {', '.join(stale)}", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
