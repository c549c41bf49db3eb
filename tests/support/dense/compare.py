"""What a run of the engine says against what the dense computation finds: which firings are confirmed, and what was missed.

A run is given as names of rules by cycle and candidate; nothing of the engine is asked here.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from support.dense.facts import Facts
from support.dense.recording import Recording

Key = tuple[int, str]

#: Rule or fault of the contract -> the facts of which any confirms it. What stands nowhere here is an error.
CONFIRMED_BY: dict[str, frozenset[str]] = {
    rule: frozenset(facts)
    for rule, facts in {
        "static_collision": ["off the road"],
        "friction": ["friction"],
        "turn_radius": ["radius"],
        "drive_acceleration": ["drive"],
        "braking_limit": ["brakes"],
        "speed_limit": ["fast"],
        "no_reversing": ["backwards"],
        "ends_at_rest": ["does not stop"],
        "contact": ["touches"],
        "safe_gap": ["ahead"],
        "safe_gap_oncoming": ["oncoming"],
        "safe_side": ["beside"],
        "safe_fallback": ["stops too late"],
        "fallback_collision": ["somebody in its way"],
        "fallback_line": ["into a line"],
        # Nobody comes towards the car in the recordings, or up from behind.
        "fallback_oncoming": [],
        "fallback_cut_in": [],
        # What is planned beside others fires where what is so already does; no fact says so of what is planned alone.
        "planned_side": ["beside", "ahead", "touches"],
        "cut_in": ["touches"],
        "fallback_brakes": ["does not stop"],
        "time_integrity": ["time"],
        "step_length": ["arc length"],
        "outlasts_cycle": ["other time"],
        "drift_match": ["turned", "off its path", "elsewhere"],
        "no_rolling": [],
        "driving_collision": [],
        "rss_eq1": ["printed"],
        "arc_length_integrity": ["arc length"],
        "heading_integrity": ["heading"],
        "curvature_integrity": ["curvature"],
        "acceleration_integrity": ["acceleration"],
        "pace_integrity": ["time"],
        "turn_integrity": ["headings turn"],
        "path_integrity": ["path turns"],
        "corner_integrity": ["path turns"],
        "swerve_integrity": ["path turns", "friction"],
        # Of the forces of a step, those along it and those across.
        "speed_integrity": ["speed jumps", "friction"],
        "pose_match": ["off its path", "elsewhere"],
        "pose_on_path": ["off its path", "elsewhere"],
        "place_match": ["elsewhere"],
        "stamp_match": ["other time"],
        "heading_match": ["turned", "off its path", "elsewhere"],
        "speed_match": ["other speed"],
        "contract: starts_elsewhere": ["starts elsewhere"],
        "contract: not_at_rest": ["does not stop"],
        "contract: out_of_range": ["out of range"],
        "contract: not_increasing": ["out of range"],
        # Nothing of these recordings can make them fire.
        "A-PERCEPTION": [],
        "A-LOCALISATION": [],
        "A-FRICTION": [],
        "obstacle_collision": [],
        "zone_speed_limit": [],
        "race_direction": [],
    }.items()
}
#: A fact that is certain -> rules of which one has to fire.
SEEN_BY: dict[str, frozenset[str]] = {
    fact: frozenset(rule for rule, facts in CONFIRMED_BY.items() if fact in facts)
    for fact in frozenset[str]().union(*CONFIRMED_BY.values())
}
#: Faults of the contract that concern a cycle as a whole: a fact about either candidate confirms them.
OF_THE_CYCLE = "contract: "


@dataclass
class Row:
    """Of one rule and candidate, times of the cycles in which it fires: confirmed, else in line with the planner's own warning, else neither."""

    confirmed: list[float] = field(default_factory=list)
    warned: list[float] = field(default_factory=list)
    unconfirmed: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Table:
    """rows: by rule and candidate. missed: facts that no rule saw, with times, by fact and candidate."""

    recording: str
    rows: Mapping[tuple[str, str], Row]
    missed: Mapping[tuple[str, str], list[float]]

    def unconfirmed(self) -> set[str]:
        """Rules that fire without a reason."""
        return {rule for (rule, _), row in self.rows.items() if row.unconfirmed}

    def __str__(self) -> str:
        lines = [
            f"{self.recording:28} {'candidate':10}{'confirmed':>10}{'warned':>8}{'neither':>8}  neither at s"
        ]
        for (rule, candidate), row in sorted(self.rows.items()):
            some = ", ".join(f"{t:g}" for t in row.unconfirmed[:6]) + (" .." if row.unconfirmed[6:] else "")
            counts = f"{len(row.confirmed):10}{len(row.warned):8}{len(row.unconfirmed):8}"
            lines.append(f"  {rule:26} {candidate:10}{counts}  {some}")
        for (fact, candidate), times in sorted(self.missed.items()):
            lines.append(f"  missed: {fact}, {candidate}, {len(times)} times, first at {times[0]:g} s")
        return "\n".join(lines)


def compare(
    recording: Recording,
    facts: Mapping[Key, Facts],
    fired: Mapping[Key, Collection[str]],
    judged: Collection[str],
    apart: Collection[str] = (),
) -> Table:
    """judged: the rules of the run; apart: those that are looked at elsewhere. Raises AssertionError for a rule that has no counterpart here."""
    strange = (
        {name for names in [judged, *fired.values()] for name in names} - CONFIRMED_BY.keys() - set(apart)
    )
    assert not strange, f"nothing here confirms or denies {sorted(strange)}: name the facts in CONFIRMED_BY"
    rows: dict[tuple[str, str], Row] = {}
    missed: dict[tuple[str, str], list[float]] = {}
    for (index, candidate), found in facts.items():
        cycle = recording.cycles[index]
        names = set(fired.get((index, candidate), ()))
        anywhere = found.possible.union(*(facts[index, other].possible for other in cycle.candidates))
        for rule in names - set(apart):
            row = rows.setdefault((rule, candidate), Row())
            reasons = anywhere if rule.startswith(OF_THE_CYCLE) else found.possible
            if CONFIRMED_BY[rule] & reasons:
                row.confirmed.append(cycle.t)
            elif cycle.warning:
                row.warned.append(cycle.t)
            else:
                row.unconfirmed.append(cycle.t)
        for fact in found.certain:
            if not names & SEEN_BY[fact]:
                missed.setdefault((fact, candidate), []).append(cycle.t)
    return Table(recording.name, rows, missed)
