"""Cause and consequence: of findings that one edit brings about, which one is to be mended, and which follow from it.

A finding follows from another one where it is about the same thing, or about something that rests on it by the links of the graph, and where what
it says comes later: that a cell is open comes after the test that failed, that after the rule that was changed, and that after the file that
cannot be read. Nothing is taken away by this: what follows is a finding as before, and fails the gate as before.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Collection, Iterable, Iterator, Sequence

from trackmarshal.trace.findings import LEVELS, Finding, Place
from trackmarshal.trace.graph.graph import Graph
from trackmarshal.trace.graph.kinds import LINKS

#: Steps of what comes from what, from first to last.
(
    UNREADABLE,
    DOUBLE,
    UNUSABLE,
    UNFIT,
    DEMANDS,
    GONE,
    LOOSE,
    ONE_SIDED,
    WRONG,
    CHANGED,
    UNREAD,
    FORGED,
    LACKING,
    UNREVIEWED,
    OUTCOME,
    OPEN,
) = range(16)
_STEPS = {
    UNREADABLE: "T101 T102 T103 T104 T105 T106 T107 T108 T109 T110 T111 T113 T379 T380",
    UNUSABLE: "T112 T114 T120 T121 T122 T123 T124 T125 T126 T128 T129 T148 T240 T250 T256 T264",
    UNFIT: "T127",
    DOUBLE: "T130 T131 T209",
    DEMANDS: "T371",
    LOOSE: "T132 T133 T134 T137 T138 T142 T145 T146 T147 T151 T152 T153 T155 T156 T157 T201 T203 T204 T205 T210 T213 T263 T336 T342",
    ONE_SIDED: "T135 T136 T206",
    CHANGED: "T221 T222 T223 T224 T225 T227 T228 T265 T370 T372 T373 T374 T375 T376 T377",
    FORGED: "T293 T294",
    LACKING: "E423 T139 T144 T149 T150 T171 T172 T173 T178 T179 T154 T202 T207 T211 T212 T217 T255",
    UNREVIEWED: "T382",
    OUTCOME: "T141 T229 T249 T167 T168 T215 T216 T218 T241 T242 T243 T244 T245 T246 T247 T260 T261 T262 T337 T338",
    OPEN: "T230 T232",
}
_STEP_OF = {code: step for step, codes in _STEPS.items() for code in codes.split()}
#: What these say may come of anything that was not read: a thing is not there, or nothing was run.
_OF_ABSENCE = frozenset(
    [
        "T112",
        "T132",
        "T134",
        "T135",
        "T136",
        "T137",
        "T139",
        "T144",
        "T145",
        "T146",
        "T148",
        "T149",
        "T150",
        "T151",
        "T153",
        "T178",
        "T201",
        "T202",
        "T204",
        "T205",
        "T206",
        "T207",
        "T208",
        "T211",
        "T212",
        "T213",
        "T217",
        "T230",
        "T232",
        "T241",
        "T254",
        "T255",
        "T262",
        "T263",
        "T336",
        "T342",
        "T382",
    ]
)
#: What something came to when it was run, and of findings of documents those that change that: a page that is not there does not make a test fail.
_CAME_OUT = frozenset({"T215", "T229", "T249", "T243", "T244", "T245", "T260"})
_BEFORE = frozenset(["T214", "T222", "T228", "T240", "T263", "T264", "T265", "T370", "T372", "T374", "T375"])
#: What is said of files that declare nothing: where a recording or a page is not there, no rule and no requirement is gone since.
_OF_FILES = frozenset({"T240", "T250"})
#: Nothing was run.
_NOT_RUN = frozenset({"T241", "T262"})
#: What is said of reviews themselves.
_OF_REVIEWS = frozenset({"T167", "T168", "T382"})
#: Of these, what a review came to: nothing answers a method because a review fell, and not the other way round.
_FALLEN = frozenset({"T167", "T168"})
#: What is lacking of tests and readers is not lacking since a scenario is to show something else.
_OF_TESTS = frozenset({"T211", "T212"})
_OF_TESTS_AND_READERS = _OF_TESTS | {"T382"}
#: Beside errors of specs, what may be why a rule has no test: tests stand in specs, and no document, contract or scenario takes one away.
_TAKES_TESTS = frozenset({"T202", "T213", "T221", "T222", "T374"})
#: What is said of what stands in specs alone. Of all documents, only that of the V-model takes it away: it names the specs, and how many tests a rule needs.
_OF_SPECS = _OF_TESTS | {"T222", "T372"}
#: So many links away something is looked for that a finding may rest on: a run rests on rules, and these on parameters.
_FAR = 2
#: Steps of which two findings about one thing are told as one.
_TOGETHER = frozenset({DEMANDS, GONE, LOOSE, ONE_SIDED, CHANGED, LACKING})
#: What these say is said of the record in which they stand, beside their subject.
_OF_RECORD = frozenset({"T148"})
#: Links whose source rests on its target although it lies below it.
_UPWARD = frozenset({"tests", "evaluates", "replays", "reviews", "examines", "used_for"})

#: What findings that are alike have in common.
_Kind = tuple[object, ...]


def causes(
    findings: Sequence[Finding], graph: Graph, demands: Iterable[tuple[Place, str]] = ()
) -> dict[Finding, Finding]:
    """By finding that follows from another one, the one that it follows from in the end. Notes, forged results and a missing baseline are neither.

    demands: of the gate, which is no part of the graph, where each stands and how the baseline calls it.
    """
    # Whoever changes results does so beside whatever else was changed; and that there is no baseline, or that files were written meanwhile, says
    # nothing about documents.
    apart = [*_STEPS[FORGED].split(), "T220", "T296"]
    told = [f for f in findings if f.level != "note" and f.code not in apart]
    return _Folding(told, graph, demands).done()


class _Folding:
    def __init__(
        self, findings: Sequence[Finding], graph: Graph, demands: Iterable[tuple[Place, str]]
    ) -> None:
        self._graph = graph
        #: What a place in a document belongs to: by file, where things begin there.
        self._records: dict[str, list[tuple[Place, str]]] = defaultdict(list)
        for node in graph.nodes.values():
            if node.place is not None:
                self._records[node.place.file].append((node.place, node.id))
        for place, name in demands:
            self._records[place.file].append((place, name))
        for places in self._records.values():
            places.sort()
        self._about = {finding: self._subjects(finding) for finding in findings}
        # Of a test that is gone, the rule is there, and what is wrong in a spec may be why the test is not.
        left = [finding for finding in findings if finding.gone and finding.code != "T221"]
        gone = {name for finding in left for name in self._about[finding]}
        # A value that is not what is declared comes before whatever does not fit to either.
        self._key = {
            f: (_step(f, gone), number + len(findings) * (f.code != "E302"))
            for number, f in enumerate(findings)
        }
        self._found = sorted(findings, key=self._key.__getitem__)
        settings = {
            node.place.file
            for node in graph.nodes.values()
            if node.kind == "stage" and node.place is not None
        }
        #: The first two, and the first two that may be why something is not there that stands in specs.
        self._first = self._found[:2]
        self._first_of_specs = [f for f in self._found if _takes_specs(f, settings)][:2]
        #: By name of what findings are about, those that are alike in all that decides whether others follow from them, the earliest first.
        self._alike: dict[str, dict[_Kind, deque[Finding]]] = defaultdict(dict)
        #: And by name those that follow from something, one for each that they follow from: a document may have thousands of them.
        self._following: dict[str, dict[_Kind, Finding]] = defaultdict(dict)
        for finding in self._found:
            kind = (self._key[finding][0], finding.code, finding.level, finding.subject)
            for name in self._about[finding]:
                self._alike[name].setdefault(kind, deque()).append(finding)
        self._below: dict[str, list[str]] | None = None
        self._cause: dict[Finding, Finding] = {}

    def done(self) -> dict[Finding, Finding]:
        if len(self._found) < 2:
            return {}
        again = True
        while again:  # what follows from something may itself be what something else follows from
            again = False
            for finding in self._found:
                if finding not in self._cause:
                    cause = self._of(finding)
                    if cause is not None and self._root(cause) is not finding:  # nothing follows from itself
                        self._cause[finding] = cause
                        again = True
                        for name in self._about[finding]:
                            kind = (self._key[finding][0], finding.code, cause)
                            self._following[name].setdefault(kind, finding)
        return {finding: self._root(finding) for finding in self._cause}

    def _root(self, finding: Finding) -> Finding:
        way = []
        while (cause := self._cause.get(finding)) is not None:
            way.append(finding)
            finding = cause
        for one in way[
            :-1
        ]:  # the next time it is one step: a chain of thousands is asked for at each of its links
            self._cause[one] = finding
        return finding

    def _subjects(self, finding: Finding) -> tuple[str, ...]:
        """What a finding is about: by name, or by its place in a document."""
        names = [name for name in (finding.subject, *finding.about) if name]
        of_settings = finding.code == "T371" and not finding.subject
        if finding.place is not None and (not names or of_settings or finding.code in _OF_RECORD):
            line = finding.place.line
            before = [name for place, name in self._records.get(finding.place.file, ()) if place.line <= line]
            names += (finding.place.file, *before[-1:])
        return tuple(dict.fromkeys(names))

    def _of(self, finding: Finding) -> Finding | None:
        """What a finding follows from: the nearest that comes earlier, and of those the first."""
        seen: set[Finding] = set()
        step = self._key[finding][0]
        for own, names in self._nearer(finding):
            best = None
            for name in names:
                for other in self._named(name):
                    root = self._root(other)
                    if (
                        root is finding
                        or root in seen
                        # Nothing was changed, and no test is lacking, since a cell is open.
                        or (self._key[other][0] == OPEN and (step <= UNREAD or finding.code in _OF_TESTS))
                        or not _explains(other, finding)
                        # Of two parts that are below one goal, what the one follows from says nothing of the other.
                        or (other is not root and _siblings(other, finding))
                        # A contract of which a rule that is gone reads nothing any more is to all others what it was.
                        or (other.code == "T372" and root.code == "T222")
                        # A run comes out as it does whether rules have tests or not: only cells that hold such a rule are open for want of one.
                        or (step == OPEN and other.code in _OF_TESTS and name not in finding.rests_on)
                        or (step == OPEN == self._key[other][0] and name not in finding.rests_on)
                    ):
                        continue
                    seen.add(root)
                    if self._precedes(root, finding, own) and (
                        best is None or self._key[root] < self._key[best]
                    ):
                        best = root
            if best is not None:
                return best
        return self._unread(finding)

    def _named(self, name: str) -> Iterator[Finding]:
        """Findings about a name: of those that are alike and follow from nothing the first, since another one follows from that if from any."""
        for alike in self._alike.get(name, {}).values():
            while alike and alike[0] in self._cause:
                alike.popleft()
            if alike:
                yield alike[0]
        yield from self._following.get(name, {}).values()

    def _precedes(self, other: Finding, finding: Finding, same_thing: bool) -> bool:
        """Whether a finding may be the cause of another one, which is about the same thing or rests on it."""
        before, own = self._key[other], self._key[finding]
        if LEVELS.index(other.level) > LEVELS.index(finding.level):
            return False  # no error hides behind a warning
        if not _explains(other, finding):
            return False
        if before[0] != own[0]:
            return before < own
        if not same_thing:
            return own[0] == OPEN and other.subject != finding.subject  # what is open below is open above
        if own[0] == UNUSABLE and not (other.code.startswith("T") or finding.code.startswith("T")):
            return before < own  # one declaration that is not sound makes others so
        same = (other.code, other.subject) == (finding.code, finding.subject) != (finding.code, "")
        return before < own and (same or own[0] in _TOGETHER)

    def _nearer(self, finding: Finding) -> Iterator[tuple[bool, Sequence[str]]]:
        """Names that a finding is about (True) or rests on, the nearest first."""
        step, own = self._key[finding][0], self._about[finding]
        if step != OPEN:
            yield True, own
        if step in (LACKING, UNREVIEWED) or finding.code[:3] in ("T16", "T14"):
            yield True, self._neighbours(finding.subject)
        if step == ONE_SIDED:
            yield True, [name for end in own for name in self._neighbours(end)]
        if finding.rests_on or step >= OUTCOME:
            yield False, finding.rests_on
            for names in self._resting((*finding.rests_on, *(() if step == OPEN else own))):
                yield False, names
        if step == OPEN:
            yield False, own
            yield False, self._neighbours(finding.subject)

    def _unread(self, finding: Finding) -> Finding | None:
        """What was not read, where that explains that something is not there."""
        if finding.code in _NOT_RUN:  # specs with errors are not run, whatever the errors come of
            broken = next((other for other in self._found if not other.code.startswith("T")), None)
            if broken is not None:
                return self._root(broken)
        for judge in self._found[:2]:  # against what nobody accepted, differences say little
            if judge.code in ("T379", "T380") and self._key[finding][0] in (DEMANDS, GONE, CHANGED, UNREAD):
                return judge
        if not (finding.gone or finding.code in _OF_ABSENCE):
            return None
        # A file that cannot be read comes first; else that fewer specs are read.
        for first in self._first_of_specs if finding.code in _OF_SPECS else self._first:
            read = (self._key[first][0] <= UNUSABLE and first.code not in _OF_FILES) or (
                finding.gone and first.code == "T371" and not first.subject
            )
            if read and _explains(first, finding) and self._key[first][0] < self._key[finding][0]:
                return first
        return None

    def _neighbours(self, name: str) -> list[str]:
        """What a thing is linked with, whether the links hold or not."""
        keys = [node.key for node in self._graph.by_id.get(name, ())]
        links = [link for key in keys for link in (*self._graph.out_of(key), *self._graph.into(key))]
        return list(dict.fromkeys(end[1] for link in links for end in (link.source, link.target)))

    def _resting(self, names: Sequence[str]) -> Iterator[Sequence[str]]:
        """What these rest on, a step further each time."""
        if self._below is None:
            self._below = defaultdict(list)
            for link in self._graph.links:
                up, down = link.source[1], link.target[1]
                if not (LINKS[link.kind].down or link.kind in _UPWARD):
                    up, down = down, up
                self._below[up].append(down)
        seen, now = set(names), list(names)
        for _ in range(_FAR):
            following = [down for name in now for down in self._below.get(name, ()) if down not in seen]
            seen.update(following)
            now = list(dict.fromkeys(following))
            yield now


def _takes_specs(finding: Finding, settings: Collection[str]) -> bool:
    """Whether what cannot be read may be specs: itself, or the document of the V-model, which names them and is one of `settings` where it could be read.

    That it demands less than the baseline (T371) is said of the baseline.
    """
    if not finding.code.startswith("T") or finding.code == "T371" or finding.place is None or not settings:
        return True
    return finding.place.file in settings


def _explains(other: Finding, finding: Finding) -> bool:
    """Whether what one finding says can make what another one says so. It is asked of each step from a cause to what follows from it."""
    if other.code == "T375" and finding.code in _OF_TESTS_AND_READERS:
        return False
    if other.code == "T255" and finding.code in _OF_TESTS | _FALLEN:
        return False  # a side of a boundary is not tested, and a review fell, whatever method nothing answers
    if finding.code in _CAME_OUT and other.code.startswith("T") and other.code not in _BEFORE:
        return False
    if finding.code == "T211" and other.code.startswith("T") and other.code not in _TAKES_TESTS:
        return False
    if other.code == "T254" and finding.code in _OF_REVIEWS:
        return (
            False  # that recordings do not reach as far as a domain claims takes no reader from its hazards
        )
    # No cell is open for want of a reader.
    return other.code != "T382" or finding.code in _OF_REVIEWS


def _siblings(one: Finding, other: Finding) -> bool:
    """Whether two findings say the same of two things that share what their integrity level is held against."""
    return one.code == other.code and one.code in ("T143", "T160") and one.subject != other.subject


def _step(finding: Finding, gone: set[str]) -> int:
    """How early a finding comes. What else is found in a spec comes first, but where it misses what the baseline says is gone."""
    known = _STEP_OF.get(finding.code)
    if finding.gone and finding.code not in ("T371", "T221"):
        return UNREAD if finding.code == "T372" else GONE
    if known is not None:
        return known
    if finding.code.startswith(("E0", "E1")):
        return UNREADABLE
    if not finding.code.startswith("T"):
        missed = {name for name in finding.about if name.rpartition(".")[2] != finding.subject}
        return LACKING if gone & missed else UNUSABLE
    return WRONG


__all__ = ["causes"]
