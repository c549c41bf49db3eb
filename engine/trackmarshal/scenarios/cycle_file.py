"""Recordings, and records of runs, as files of cycles for the example that comes with a Supervisor in C."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from trackmarshal.backends.c.cycles import Arrival, CycleWriter
from trackmarshal.backends.c.source import Source
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.declared import check_numbers
from trackmarshal.runtime.door.door import stamp_of
from trackmarshal.runtime.door.reading import CycleReader
from trackmarshal.runtime.frame import Settings
from trackmarshal.runtime.record.reading import Run
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.supervised import cycles

#: A step: the cycle, or None where one was due and did not come, and the clock at the arrival and when all rules were checked.
Given = tuple[Cycle | None, float, float]


def of_recording(
    recording: Recording, source: Source, settings: Settings, declared: frozenset[str] = frozenset()
) -> Iterator[str]:
    """The lines of a file. Every cycle arrives at its stamp, and takes no time; limits are those of `replay`, and so is what else is `declared`."""
    given = ((cycle, cycle.t, cycle.t) for cycle in cycles(recording, declared))
    return _lines(source, settings, Limits.open_loop(source.plan.spec, settings.params), given)


def of_run(run: Run, source: Source, settings: Settings) -> Iterator[str]:
    """The lines of a file: cycles at the times that the clock showed, with the limits of the run. Raises D162."""
    assert source.supervised is not None
    check_numbers(run, source.plan.spec, source.supervised.contract)
    steps = ((_cycle(one.cycle), *one.readings) for one in run.cycles)
    return _lines(source, settings, run.limits, steps)


def _cycle(recorded: object) -> Cycle | None:
    """What C can be handed: anything that is no cycle at all did not come."""
    return recorded if isinstance(recorded, Cycle) else None


def _lines(source: Source, settings: Settings, limits: Limits, given: Iterable[Given]) -> Iterator[str]:
    assert source.supervised is not None
    writer = CycleWriter(source, source.supervised)
    reader = CycleReader(source.supervised.contract, settings)
    yield from writer.head(settings, limits)
    for cycle, now, finished in given:
        if cycle is None:
            yield from writer.cycle(Arrival(None, None, None, now, finished))
            continue
        stamp = stamp_of(cycle)
        frame, structure = reader.read(cycle)
        yield from writer.cycle(
            Arrival(frame, stamp.number, stamp.t, now, finished, (*stamp.faults, *structure))
        )
    yield from writer.end()
