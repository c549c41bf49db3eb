"""A recording as the cycles of a Supervisor, and what it decides about them once both candidates have been evaluated."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any, NoReturn

from trackmarshal.backends.over_run.history import Past
from trackmarshal.backends.over_run.keeping import Keeping
from trackmarshal.backends.over_run.program import Remembering
from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import remembers
from trackmarshal.runtime.contract import FOLLOWED
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.door import Admission, Door
from trackmarshal.runtime.door.lines import line as line_of
from trackmarshal.runtime.driven import MOST_LOST
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.lines import Line
from trackmarshal.runtime.program import NOTHING, Judged, Memory
from trackmarshal.runtime.record.reading import read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.scenarios.fields import ELSEWHERE, check_fit, further_names, own_names
from trackmarshal.scenarios.overrides import known_params
from trackmarshal.scenarios.recording import Cycle as RecordedCycle
from trackmarshal.scenarios.recording import Recording
from trackmarshal.supervision import rulebox
from trackmarshal.units import moment


def cycles(recording: Recording, declared: frozenset[str] = frozenset()) -> Iterator[Cycle]:
    """The cycles of a recording, counted from 0. Columns and records are the recording's own.

    declared: names (`ego.kappa`) that it may have besides those of its format and header, and of the spec that it is for.
    """
    if not isinstance(recording, Recording):
        raise wrong_type("a recording is what `load_recording` returns", recording)
    if not isinstance(declared, frozenset | set):
        raise wrong_type("`declared` is a set of names", declared)
    also = own_names(recording) | declared
    track = {
        name: line_of(line) if isinstance(line, list) and line and _is_line(line) else line
        for name, line in recording.track.items()
    }
    for number, cycle in enumerate(recording.cycles):
        signals: dict[str, Any] = {
            "ego": cycle.ego,
            "objects": cycle.objects,
            "obstacles": recording.standing(cycle),
            "track": track,
            **recording.always,
            **cycle.more,
        }
        driving, emergency = (cycle.candidates.get(name) for name in (DRIVING, EMERGENCY))
        yield Cycle(number, cycle.t, driving, emergency, signals, also)


def _is_line(points: list[Any]) -> bool:
    return all(
        isinstance(point, list | tuple) and len(point) == 2 and {float, int}.issuperset(map(type, point))
        for point in points
    )


#: Cycles that are evaluated together.
_CHUNK = 250


def supervised(
    recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any], watch: Callable[[Sequence[Any]], Iterable[Any]] = iter
) -> Iterator[tuple[float, Judged, Decision]]:  # fmt: skip
    """Every cycle of a recording through the Supervisor: its time, the verdicts about it, and the decision.

    What the door refuses is judged all the same, as far as it can be, to be shown. The car of a recording did not follow the
    decisions, so where it is says nothing about them (`Limits.open_loop`). `watch` wraps the chunks of work.
    """
    check_fit(recording, evaluator)
    box = rulebox(evaluator, known_params(recording, evaluator.spec), tables)
    clock = _Clock()
    supervisor = box.supervisor(box.open_loop, clock.read)
    given = list(cycles(recording, further_names(recording, evaluator)))
    chunks = watch([given[i : i + _CHUNK] for i in range(0, len(given), _CHUNK)])
    if any(map(remembers, evaluator.rules)):
        yield from _in_step(recording, supervisor, clock, chunks)
        return
    ahead = _Ahead(supervisor)
    for chunk in chunks:
        found = ahead.judged(chunk, evaluator)
        for cycle, judged in zip(chunk, found):
            clock.now = cycle.t
            yield cycle.t, judged, supervisor.step(cycle)


def frame_at(recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any], place: int) -> Frame:
    """One cycle, by its place in the recording, as rules see it in `supervised`; a candidate's part is `of` its name."""
    check_fit(recording, evaluator)
    box = rulebox(evaluator, known_params(recording, evaluator.spec), tables)
    door = box.supervisor(box.open_loop).door
    for cycle in islice(cycles(recording, further_names(recording, evaluator)), place + 1):
        frame = door.admit(-1, cycle, cycle.t).frame  # what came before counts
    return shown(frame)


def frames(recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any]) -> list[Frame]:
    """All cycles of a recording as rules see them in `supervised`; a candidate's part is `of` its name."""
    check_fit(recording, evaluator)
    box = rulebox(evaluator, known_params(recording, evaluator.spec), tables)
    door = box.supervisor(box.open_loop).door
    given = list(cycles(recording, further_names(recording, evaluator)))
    return [shown(one.frame) for one in door.admit_all(given)]


def run_until(
    recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any], place: int
) -> tuple[Judged, list[Past], int]:
    """What rules say of a cycle, by its place in the recording, the cycles before it, and how many are missing after the last of those."""
    check_fit(recording, evaluator)
    clock = _Clock()
    box = rulebox(evaluator, known_params(recording, evaluator.spec), tables)
    supervisor = box.supervisor(box.open_loop, clock.read)
    kept = supervisor.program = Keeping(supervisor.program)
    steps = _in_step(
        recording,
        supervisor,
        clock,
        ([cycle] for cycle in islice(cycles(recording, further_names(recording, evaluator)), place + 1)),
    )
    for _ in islice(steps, place):
        pass
    before = list(kept.cycles)
    missing = kept.missed_since + recording.cycles[place].missing if before else 0
    _, judged, _ = next(steps)
    return judged, before, missing


def pass_gap(recording: Recording, supervisor: Supervisor, place: int) -> None:
    """Rules that remember are told of cycles of the run that are missing before one, by its place in the recording."""
    if missing := recording.cycles[place].missing:
        supervisor.memory = supervisor.program.missed(supervisor.memory, missing)


def _in_step(
    recording: Recording, supervisor: Supervisor, clock: _Clock, chunks: Iterable[Sequence[Cycle]]
) -> Iterator[tuple[float, Judged, Decision]]:
    """Cycle by cycle: what is remembered of one depends on what was decided in it. What does not is evaluated for a chunk at once."""
    door, program = _Admitted(supervisor.door), supervisor.program
    supervisor.door = door  # type: ignore[assignment]
    for chunk in chunks:
        frames = door.prepare(chunk)
        if isinstance(program, Remembering):
            program.ahead(frames)
        for cycle, frame in zip(chunk, frames):
            clock.now = cycle.t
            pass_gap(recording, supervisor, cycle.number)
            opened = supervisor.open(cycle)
            # Before the cycle is remembered as a gap: what remembers is never asked again about what it has left behind.
            refused = program.judge(supervisor.memory, shown(frame)) if opened.faults else None
            decision = supervisor.go_on(opened)
            yield cycle.t, refused or decision.judged or _failed(decision), decision


def _failed(decision: Decision) -> NoReturn:
    raise RuntimeError(f"the evaluator failed: {'; '.join(str(fault) for fault in decision.faults)}")


class _Admitted:
    """A door that has admitted cycles before they are shown to it."""

    def __init__(self, door: Door) -> None:
        self._door = door
        self._waiting: deque[Admission] = deque()

    def prepare(self, chunk: Sequence[Cycle]) -> list[Frame]:
        """Admit cycles, each at its stamp: their frames, as they are shown where they are refused."""
        admitted = self._door.admit_all(chunk)
        self._waiting.extend(admitted)
        return [shown(one.frame) if one.faults else one.frame for one in admitted]

    @property
    def last(self) -> tuple[int | None, float | None]:
        """As a Door's."""
        return self._door.last

    @last.setter
    def last(self, given: tuple[int | None, float | None]) -> None:
        self._door.last = given

    def admit(self, about: int, cycle: Cycle, now: float) -> Admission:
        if now != cycle.t:
            raise RuntimeError("this door knows what was said at the time of the stamp only")
        return replace(self._waiting.popleft(), about=about)


class _Ahead(_Admitted):
    """Door and program of a Supervisor whose cycles have been admitted, and judged together, before it asks."""

    def __init__(self, supervisor: Supervisor) -> None:
        super().__init__(supervisor.door)
        self.spec, self.rules = supervisor.program.spec, supervisor.program.rules
        self.identity = supervisor.program.identity
        self._judged: dict[int, Judged] = {}
        supervisor.door, supervisor.program = self, self  # type: ignore[assignment]

    def judged(self, chunk: Sequence[Cycle], evaluator: Evaluator) -> list[Judged]:
        """Admit and judge cycles."""
        found = evaluator.judge_all([shown(frame) for frame in self.prepare(chunk)])
        self._judged = {id(judged.about): judged for judged in found}
        return found

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        judged = self._judged[id(frame)]
        if judged.about is not frame:
            raise RuntimeError("this program knows what was said of the frames of its door only")
        return judged

    def start(self) -> Memory:
        return NOTHING

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        return memory

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        return memory


def shown(frame: Frame) -> Frame:
    """A frame without the candidates that a recording does not have; there is nothing to say about them."""
    gone = {
        f.signal for f in frame.faults if name_of(f) == "missing" and f.field == ""
    } & frame.candidates.keys()
    for name in gone:
        columns = frame.candidates.pop(name)
        if name == FOLLOWED:  # the other candidate's rules may read it: they find it missing
            frame.columns[FOLLOWED] = columns
    return frame


#: The track of a run whose rules ask for no borders.
_NO_TRACK: Mapping[str, Any] = {"left": [], "right": [], "closed": False}


def recording_of(data: bytes, name: str, shown: str) -> Recording:
    """The cycles of a run's record that passed the door, as a recording; raises D161, D162, or D130 where there are none.

    A recording has one track: cycles after a change of it are left out. What is left out, the notes say.
    """
    run = read(data, shown)
    kept: list[RecordedCycle] = []
    track: dict[str, Any] = {}
    obstacles: list[dict[str, Any]] = []
    notes: list[str] = []
    last: int | None = None
    since = 0  # rows that are left out
    for one in run.cycles:
        cycle = one.cycle
        if type(cycle) is not Cycle or one.value("faults") != "[]":
            since += 1
            continue
        signals = _plain(cycle.signals)
        given = _known(signals.get("track"))
        standing = _elements(signals.get("obstacles"))
        if kept and _changes(track, given):
            notes.append(f"the track changes at {moment(cycle.t)} s; what follows is left out")
            break
        if not kept:
            track, obstacles = given, standing
        # Numbers tell of those that were lost on the way, and rows of steps that got none.
        missing = 0 if last is None else min(max(since, cycle.number - last - 1), MOST_LOST)
        last, since = cycle.number, 0
        kept.append(
            RecordedCycle(
                cycle.t,
                signals["ego"],
                _elements(signals.get("objects")),
                {DRIVING: _plain(cycle.driving), EMERGENCY: _plain(cycle.emergency)},
                {name: value for name, value in signals.items() if name not in ELSEWHERE},
                None if standing == obstacles else standing,
                missing,
            )
        )
    if not kept:
        raise TrackmarshalError(
            "D130", "the record has no cycle that passed the door", file=shown, help="replay it as it is"
        )
    if any(cycle.obstacles is not None for cycle in kept):
        notes.append("its obstacles are not the same in all cycles; drawn are those of the first one")
    gaps = [cycle.t for cycle in kept if cycle.missing]
    if gaps:
        more = f", and before {len(gaps) - 1} later ones" if len(gaps) > 1 else ""
        notes.append(f"cycles are missing before the one at {moment(gaps[0])} s{more}")
    if run.went_on:
        notes.append(f"{run.went_on}; what rules remembered of that is not known here")
    if run.damage:
        notes.append(run.damage)
    left_out = len(run.cycles) - len(kept)
    if left_out:
        notes.append(f"{left_out} of {len(run.cycles)} cycles of the record are left out")
    params, tables = run.identity.get("params", {}), run.identity.get("tables", {})
    track = track if "left" in track else {**_NO_TRACK, **track}
    return Recording(
        name, shown, tuple(kept), track, params, tables, obstacles=obstacles, notes=tuple(notes), of_run=replace(run, cycles=(), snapshots=())
    )  # fmt: skip


def _known(track: Any) -> dict[str, Any]:
    """What a cycle says of the track; nothing where that is none, which passes the door where rules ask for no borders."""
    return (
        {name: part for name, part in track.items() if part is not None} if isinstance(track, Mapping) else {}
    )


def _changes(track: Mapping[str, Any], given: Mapping[str, Any]) -> bool:
    """Whether another cycle has another track: one that was kept as it came in may lack what its columns would have, and have what they would not."""
    was, now = ((bool(one.get("closed")), one.get("name")) for one in (track, given))
    return was != now or any(track[each] != given[each] for each in track.keys() & given.keys() - {"closed"})


def _plain(value: Any) -> Any:
    """What a record has, of any kind and as it came in, as lists."""
    if isinstance(value, Line):
        return value.points.tolist()
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _elements(given: Any) -> list[dict[str, Any]]:
    """The elements of a set, given as records or as columns; ids are texts, and those without one are counted, as the door does."""
    if isinstance(given, Mapping):
        listed = {name: column for name, column in given.items() if column is not None}
        given = [dict(zip(listed, values)) for values in zip(*listed.values())]
    each = list(given or ())
    ids = values.ids([str(place) if one.get("id") is None else one["id"] for place, one in enumerate(each)])
    return [{**one, "id": id_} for one, id_ in zip(each, ids)]


class _Clock:
    now = 0.0

    def read(self) -> float:
        return self.now
