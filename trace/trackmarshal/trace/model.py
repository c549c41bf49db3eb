"""What a requirements folder says, as typed records: the system model, the requirements, the V-model, the settings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import date
from functools import lru_cache
from typing import TYPE_CHECKING

from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph.kinds import OBSOLETE
from trackmarshal.trace.values import Placed

if TYPE_CHECKING:
    from trackmarshal.trace.gsn.document import Argument


@dataclass(frozen=True, slots=True)
class Subsystem:
    """A part of the world, or the vehicle."""

    id: Placed
    title: str
    role: str  #: "vehicle" or "environment"
    description: str


@dataclass(frozen=True, slots=True)
class Flow:
    """What passes over an interface, and who starts it (a subsystem or `mutual`)."""

    kind: str  #: "physical" or "information"
    initiator: Placed
    what: str


@dataclass(frozen=True, slots=True)
class Issue:
    """One answer to the guiding question."""

    id: Placed
    text: str
    leads_to: tuple[Placed, ...]


@dataclass(frozen=True, slots=True)
class Infeasible:
    """Two subsystems that do not meet (`TI-RO`), and why."""

    between: Placed
    reason: str


@dataclass(frozen=True, slots=True)
class Interface:
    """How two subsystems meet, or the properties of one."""

    id: Placed
    title: str
    flows: tuple[Flow, ...]
    issues: tuple[Issue, ...]
    rationale: str

    @property
    def ends(self) -> tuple[str, ...]:
        return tuple(self.id.split("-"))

    @property
    def leads_to(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(str(target) for issue in self.issues for target in issue.leads_to))


@dataclass(frozen=True, slots=True)
class Requirement:
    """One requirement; `place` is where its record begins."""

    id: Placed
    title: str
    statement: Placed
    rationale: str
    derived_from: tuple[Placed, ...]
    refines: tuple[Placed, ...]
    adopted: str
    status: str
    asil: Placed
    verification: tuple[Placed, ...]
    metrics: tuple[Placed, ...]
    assumptions: tuple[Placed, ...]
    source: str
    owner: str = ""
    links: tuple[tuple[str, Placed], ...] = ()  #: further ones, with their kinds
    not_verified_by: tuple[tuple[str, str], ...] = ()  #: methods that are not used, and why

    @property
    def place(self) -> Place:
        return self.id.place

    @property
    def demanded(self) -> bool:
        return self.status != OBSOLETE


@dataclass(frozen=True, slots=True)
class Entry:
    """What a document says of a thing whose meaning lies in its links: a hazard, a person, a review, a design element ..."""

    kind: str  #: of nodes
    id: Placed
    title: str
    attributes: Mapping[str, str]
    links: tuple[tuple[str, Placed], ...]  #: with their kinds
    made: date | None = None
    versions: tuple[tuple[Placed, str], ...] = ()  #: of what a review is, and the fingerprint that it had
    ranges: tuple[tuple[Placed, str, str], ...] = ()  #: of a domain: signal and field, from, to


@dataclass(frozen=True, slots=True)
class Condition:
    """What an attribute has to be: one of these values, in which `*` stands for any characters."""

    attribute: str
    values: tuple[Placed, ...]


@dataclass(frozen=True, slots=True)
class Way:
    """One way to meet a need: by links (or their converse), by what is reached below, or by a field."""

    place: Place = field(repr=False)  # not what it says
    link: Placed
    reaches: Placed
    field: Placed
    kinds: tuple[Placed, ...]
    where: tuple[Condition, ...]
    at_least: int = 1
    at_most: int | None = None
    every: str = ""  #: an attribute of what is linked: the integrity level from which on all nodes of the kind are wanted
    unless: str = ""  #: an attribute that lists those that are not


@dataclass(frozen=True, slots=True)
class Need:
    """What a node of a kind needs, and of which nodes it is asked."""

    kind: str
    place: Place = field(repr=False)  # not what it says
    any_of: tuple[Way, ...]
    ids: tuple[Placed, ...]
    from_asil: str
    stages: tuple[Placed, ...]
    counts: str
    if_any: str
    obsolete: bool
    where: tuple[Condition, ...]
    level: str
    code: Placed
    says: str
    help: str


@dataclass(frozen=True, slots=True)
class Permitted:
    """Ends that links of a kind may have, as patterns of ids."""

    link: str
    sources: tuple[Placed, ...]
    targets: tuple[Placed, ...]


@dataclass(frozen=True, slots=True)
class Method:
    """A method that requirements name under `verification`, and what answers it: one of these ways, beside evidence that names it."""

    name: Placed
    means: str
    any_of: tuple[Way, ...]


@dataclass(frozen=True, slots=True)
class Reviewed:
    """Nodes that a person is to have reviewed."""

    kind: str
    ids: tuple[Placed, ...]
    from_asil: str


@dataclass(frozen=True, slots=True)
class Schema:
    """Which links nodes need, and which they may have; what answers methods of verification; what a person is to have reviewed.

    methods, reviewed: None where a project's own schema leaves them as they come with the program.
    """

    needs: tuple[Need, ...] = ()
    permitted: tuple[Permitted, ...] = ()
    methods: tuple[Method, ...] | None = None
    reviewed: tuple[Reviewed, ...] | None = None


@dataclass(frozen=True, slots=True)
class Stage:
    """A step of the V-model."""

    id: Placed
    title: str
    shows: str
    applies_to: tuple[Placed, ...]
    counts: tuple[str, ...]
    if_any: bool


@dataclass(frozen=True, slots=True)
class Scenario:
    """A recording and what its run is evidence for."""

    path: Placed
    stage: Placed
    expect: str  #: "ground_truth", "no_fire" or "fire"
    origin: str
    by: tuple[Placed, ...]
    requirements: tuple[Placed, ...]
    title: str
    specs: tuple[Placed, ...] = ()  #: beside the project's default one
    kept: Placed | None = None  #: the file of its run, where it cannot be made again at any time


@dataclass(frozen=True, slots=True)
class Evidence:
    """A document that counts at a stage."""

    path: Placed
    title: str
    stage: Placed
    requirements: tuple[Placed, ...]
    sha256: str
    methods: tuple[Placed, ...] = ()  #: of verification that it is evidence of


@dataclass(frozen=True, slots=True)
class Backing:
    """Evidence for an assumption whose spec is not part of the project, and who answers for it here (empty: who the spec says)."""

    name: Placed
    evidence: Placed
    owner: str = ""


@dataclass(frozen=True, slots=True)
class TestReport:
    """A report of another test runner, or a folder of them, and the stage that its tests are evidence at."""

    path: Placed
    stage: Placed
    tool: str
    names: Placed  #: a regular expression that finds ids in names of tests; empty: names are names
    if_there: bool = False  #: it may be missing, and its tests were not run then
    methods: tuple[Placed, ...] = ()  #: of verification that its tests are evidence of


@dataclass(frozen=True, slots=True)
class Demand:
    """What the gate demands of cells."""

    stage: Placed
    requirements: tuple[Placed, ...]
    at_least: str


@dataclass(frozen=True, slots=True)
class Waiver:
    """A gap that somebody answers for: cells (stages and requirements) or findings (codes and subjects)."""

    id: Placed
    stages: tuple[Placed, ...]
    requirements: tuple[Placed, ...]
    codes: tuple[Placed, ...]
    subjects: tuple[Placed, ...]
    justification: str
    residual_risk: str
    owner: str
    approver: Placed
    granted: date | None  #: None where it does not say a day, as was reported
    expires: date | None

    def holds(self, day: date) -> bool:
        """Whether it excuses anything on a day; without both of its days, it never does."""
        return self.granted is not None and self.expires is not None and self.granted <= day <= self.expires


def day_said(day: date | None) -> str:
    """A day as readers see it, YYYY-MM-DD, and `?` where none could be read."""
    return "?" if day is None else day.isoformat()


@dataclass(frozen=True, slots=True)
class Project:
    """All documents of a project, in the order of files and of lines in them."""

    name: str = ""
    specs: tuple[Placed, ...] = ()
    default_spec: str = ""
    results: str = "out/results"
    baseline: Placed | None = None
    tests_per_rule: tuple[tuple[str, int], ...] = (("satisfied", 1), ("violated", 1), ("boundary", 1))
    boundary_distance: tuple[
        Placed, ...
    ] = ()  #: how far limits are moved to see that boundary tests fail, one a dimension
    subsystems: tuple[Subsystem, ...] = ()
    interfaces: tuple[Interface, ...] = ()
    infeasible: tuple[Infeasible, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    stages: tuple[Stage, ...] = ()
    scenarios: tuple[Scenario, ...] = ()
    campaigns: tuple[Placed, ...] = ()
    junit: tuple[TestReport, ...] = ()
    sources: tuple[Placed, ...] = ()  #: folders of code that says what it implements
    denials: tuple[Placed, ...] = ()  #: further phrases by which a page says that it is no evidence
    closed_loop: Placed | None = None  #: kept results of runs in a closed loop
    case_words: Placed | None = None  #: the language of the safety case, or a file of words
    case_templates: Placed | None = None  #: the folder of its own templates of the safety case
    evidence: tuple[Evidence, ...] = ()
    backing: tuple[Backing, ...] = ()  #: of assumptions of other people's specs
    gate: tuple[Demand, ...] = ()
    waivers: tuple[Waiver, ...] = ()
    place: Place | None = None  #: where its settings are
    entries: tuple[Entry, ...] = ()  #: hazards, goals, design, persons, reviews and their like
    schema: Schema | None = None  #: the project's own, where it has one
    argument: Argument | None = None  #: its own templates, and what people say against the argument
    modelled: Place | None = None  #: where the system model is, if there is one
    by_id: dict[str, Requirement] = field(default_factory=dict, repr=False, compare=False)

    @property
    def vehicle(self) -> str:
        """The id of the vehicle; empty when the model names none."""
        return next((str(s.id) for s in self.subsystems if s.role == "vehicle"), "")


@lru_cache(maxsize=4096)
def _pattern(patterns: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile("|".join(map(_expression, patterns)), re.DOTALL)


def _expression(pattern: str) -> str:
    """A pattern as a regular expression, which takes no longer for more stars: what stands between two is found at the first place where it is, and nowhere else."""
    first, *rest = map(re.escape, pattern.split("*"))
    if not rest:
        return first
    between = "".join(f"(?>.*?{part})" for part in rest[:-1] if part)
    return f"{first}{between}.*{rest[-1]}"


def matches(name: str, patterns: Iterable[str]) -> bool:
    """Whether an id is one of these, where `*` stands for any characters; no patterns match nothing."""
    wanted = tuple(patterns)
    return bool(wanted) and _pattern(wanted).fullmatch(name) is not None
