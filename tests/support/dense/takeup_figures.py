"""The figures of docs/takeup.md, as tables: `PYTHONPATH=tests python -m support.dense.takeup_figures FOLDER EVERY NAME ...`, minutes each."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from support.dense import car as cars
from support.dense import recording, sweep
from support.dense.delayed import delayed
from support.dense.facts import facts
from support.dense.takeup import TakeUp, Terms, at_the_limit, take_up

#: Reserves to look at: m/s, m.
RESERVES = ((2.0, 5.0), (4.0, 10.0), (6.0, 15.0), (7.0, 18.0), (8.0, 20.0), (np.inf, np.inf))
#: Of the emergency trajectory that brakes late: as long as the window, and a little for its samples.
LATER = 0.25


def _row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _quantiles(values: Sequence[float]) -> str:
    return ", ".join(f"{q:.2f}" for q in np.quantile(values, [0.5, 0.9, 0.99, 1.0]))


def tables(folder: Path, every: int, names: Sequence[str]) -> Iterator[str]:
    """Lines of Markdown, of every so many cycles of each recording."""
    planned = cars.read(folder / "ltpl_car.spec")
    car = planned.allowed(0.01)
    for name in names:
        data = recording.read(folder, name)
        road = sweep.road(data)
        said = facts(data, car, data.cycles[::every])
        good = [
            cycle
            for cycle in data.cycles[::every]
            if not any(said[cycle.index, candidate].certain for candidate in cycle.candidates)
        ]
        yield f"\n{name}: {len(data.cycles[::every])} cycles, {len(good)} with nothing else against them\n"
        for seconds in (0.1, 0.3):
            for begin, where in ((0.0, "first sample"), (None, "car")):
                terms = Terms(seconds, 0.0)
                found = [at_the_limit(cycle, road, car, terms, begin) for cycle in good]
                lost = sum(limit.asks > 1.0 or not limit.on_road for limit in found)
                columns = [[getattr(limit, key) for limit in found] for key in ("dv", "ahead", "overrun")]
                yield _row(name, f"{seconds} s from the {where}", *map(_quantiles, columns), lost)
        for disturbed in (0.0, 0.2):
            terms = Terms(slip=disturbed, push=disturbed)
            as_is = [take_up(cycle, road, car, terms) for cycle in good]
            mended = [take_up(delayed(cycle, planned, LATER), road, car, terms) for cycle in good]
            for label, taken in (("as planned", as_is), ("braking later", mended)):
                yield from _refused(f"{name}, {label}, disturbed by {disturbed:g}", taken, terms)


def _refused(label: str, taken: Sequence[TakeUp], terms: Terms) -> Iterator[str]:
    for dv, ds in RESERVES:
        reserve = Terms(terms.period, terms.longest_gap, ds, dv, slip=terms.slip, push=terms.push)
        causes = [one.causes(reserve) for one in taken]
        count = Counter(cause for some in causes for cause in some)
        by_cause = ", ".join(f"{cause} {n}" for cause, n in sorted(count.items()))
        yield _row(label, f"{dv:g}", f"{ds:g}", sum(map(bool, causes)), by_cause)
    steady = [one for one in taken if one.grip <= 1.0 and np.isfinite(one.overrun)]
    if steady:
        yield _row(
            label, "needs", f"dv {max(o.dv for o in steady):.2f}", f"ds {max(o.overrun for o in steady):.2f}"
        )
    yield _row(label, "grip", _quantiles([one.grip for one in taken]))


if __name__ == "__main__":
    for line in tables(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]):
        print(line, flush=True)
