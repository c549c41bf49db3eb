"""What the matrix knows from outside of specs: results of other test runners, and what source code says it implements."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from trackmarshal.records.specs import SpecItem
from trackmarshal.trace import denials, external, sources
from trackmarshal.trace.denials import Denials
from trackmarshal.trace.external import External
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.model import Project
from trackmarshal.trace.sources import Marker
from trackmarshal.trace.spec import Spec


@dataclass(frozen=True, slots=True)
class Outside:
    """Tests and markers in the order of files and lines, and by the requirement that they name."""

    tests: tuple[External, ...] = ()
    markers: tuple[Marker, ...] = ()
    denials: Denials = field(default_factory=dict)  #: evidence that says that there is none
    tests_of: dict[str, list[External]] = field(default_factory=dict, repr=False, compare=False)
    markers_of: dict[str, list[Marker]] = field(default_factory=dict, repr=False, compare=False)


def load(root: Path, project: Project, items: Iterable[SpecItem], found: list[Finding]) -> Outside:
    """What the project's settings name; what is wrong with reading it goes to `found`."""
    tests, markers = external.load(root, project, found), sources.load(root, project, found)
    tests_of: dict[str, list[External]] = defaultdict(list)
    for test in tests:
        for id_ in test.test.requirements:
            tests_of[id_].append(test)
    markers_of: dict[str, list[Marker]] = defaultdict(list)
    for marker in markers:
        markers_of[marker.requirement].append(marker)
    own = tuple(map(str, project.denials))
    claimed = denials.claims(project, items, denials.denying(root, project, own))
    denied = denials.load(root, claimed, own)
    return Outside(tests, markers, denied, tests_of, markers_of)


def check(project: Project, spec: Spec, outside: Outside) -> Iterator[Finding]:
    """Loose ends of all of these (T253, T336 to T339, T342)."""
    yield from denials.check(project, spec.by_name.values(), outside.denials)
    yield from external.check(project, outside.tests)
    yield from sources.check(project, outside.markers)
