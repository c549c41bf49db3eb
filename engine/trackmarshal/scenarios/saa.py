"""Recordings of the ScenarioArchitect (`.saa`): a ZIP with a semicolon text and tables.

The `.sas` part is a pickle, which could run any code when it is loaded: it is never opened. Conventions are
converted: heading 0 along +y becomes 0 along +x; arc length and time along the trajectories, which the format does
not have, are computed (see trajectory.py). Layout after the format as the recordings show it; false in the
`safety_*` columns is unsafe, null any verdict. Objects are given as of their cycle's time, so their age is 0 s.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import PurePath
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.json_text import BadJson, kind, number, parse
from trackmarshal.scenarios import content, saa_tables
from trackmarshal.scenarios.archive import Archive
from trackmarshal.scenarios.codes import Faults
from trackmarshal.scenarios.inputs import filled
from trackmarshal.scenarios.recording import Columns, Cycle, Recording
from trackmarshal.scenarios.structure import Wrong, plain
from trackmarshal.scenarios.trajectory import complete, wrap

_STATE = ("x", "y", "heading", "curv", "vel", "acc")
_PLANS = {"ego_traj": "driving", "ego_traj_em": "emergency"}
_TRUTHS = {"safety_dyn": "dynamic", "safety_stat": "static"}
_NEEDED = ("time", *_STATE, *_PLANS, "object_array")
_OBJECT = ("x", "y", "heading", "v", "length", "width")
_EXPORT = "export it anew with ScenarioArchitect"
#: Of npz, xlsx and what else is packed as those archives are.
_NO_ARCHIVE = "of archives, those of ScenarioArchitect (.saa) are read; `trackmarshal import log` makes a recording of a car's log (CSV, MCAP)"


def read(data: bytes, shown: str) -> Recording:
    """The bytes of a .saa archive to a Recording; raises D122 to D131. `shown` is the path that reports print."""
    return read_with(data, shown, ())[0]


def read_with(data: bytes, shown: str, wanted: Iterable[str]) -> tuple[Recording, dict[str, list[Any]]]:
    """The same, and those of the wanted columns that are there and are not the format's own: what JSON says in each cycle."""
    archive = Archive(data, shown)
    name = archive.name_of(".scn")
    if name is None:
        help_ = _EXPORT if PurePath(shown).suffix.lower() == ".saa" else _NO_ARCHIVE
        raise TrackmarshalError("D123", "no part of the archive ends in .scn", file=shown, help=help_)
    inside = f"{shown}!{name}"
    tables = saa_tables.read(archive)
    params, because = allowances(tables)
    given = _given(tables)
    scenario = _Scenario(content.text(archive.read(name), inside), inside, wanted)
    cycles, truth = scenario.cycles()
    recording = Recording(
        name=PurePath(name).stem,
        source=shown,
        cycles=cycles,
        track=scenario.track,
        params=params,
        tables=tables,
        ground_truth=truth,
        notes=tuple(scenario.notes),
        in_si=frozenset({("params", name) for name in params} | {("tables", name) for name in tables}),
        given={name: value for name, (value, _) in given.items()},
        because={**because, **{name: why for name, (_, why) in given.items()}},
    )
    return filled(recording), scenario.further


#: What the makers of these archives allow beyond the tables that come with them: their own supervisor, and so their ground truth, is of that.
ALLOWED = 1.15
_GRAVITY = 9.81


def allowances(tables: saa_tables.Tables) -> tuple[dict[str, float], dict[str, str]]:
    """What such a recording overrides in place of what its car can physically do, and why, for the tables that it has."""
    params: dict[str, float] = {}
    because: dict[str, str] = {}
    share = f"{100.0 * ALLOWED:g} %"
    if "grip" in tables:
        least = min(grip for _, grip in tables["grip"])
        params["mu"] = ALLOWED * least / _GRAVITY
        because["mu"] = (
            f"TrajectorySupervisor, for which it was made, allows {share} of the archive's grip, {least:g} m/s^2"
        )
    if "ax_max" in tables:
        params["drive_factor"] = ALLOWED
        because["drive_factor"] = (
            f"TrajectorySupervisor, for which it was made, allows {share} of the archive's ax_max_machines"
        )
    return params, because


def _given(tables: saa_tables.Tables) -> dict[str, tuple[float, str]]:
    """Inputs that the format does not have, each with the reason for its value."""
    given = {"ego.age": (0.0, "simulated: the state of the car is that of the cycle's time")}
    if "grip" in tables:
        given["plan.grip"] = (1.0, "simulated: the road has the grip of the archive's ggv everywhere")
    return given


class _Scenario:
    """The .scn text of a scenario: comments with the borders, a header, a row per cycle."""

    def __init__(self, text: str, shown: str, wanted: Iterable[str]) -> None:
        self.shown = shown
        self.further: dict[str, list[Any]] = {name: [] for name in wanted}
        self.notes: list[str] = []
        self.dropped: dict[str, int] = {}
        numbered = [(i, line.rstrip("\r")) for i, line in enumerate(text.split("\n"), start=1)]
        comments = [(i, line) for i, line in numbered if line.startswith("#")]
        lines = [(i, line) for i, line in numbered if line.strip() and not line.startswith("#")]
        self.track = {
            "left": self._border(comments, "bound_l"),
            "right": self._border(comments, "bound_r"),
            "closed": False,
        }
        if not lines:
            raise self._error("D127", "no header line", None, _EXPORT)
        self._header(*lines[0])
        self.rows = lines[1:]
        if not self.rows:
            raise self._error("D130", "no cycles", None, _EXPORT)

    def _error(self, code: str, message: str, line: int | None, help: str) -> TrackmarshalError:
        return TrackmarshalError(code, message, file=self.shown, line=line, help=help)

    def _border(self, comments: list[tuple[int, str]], name: str) -> list[list[float]]:
        said = [(line, comment.lstrip("# ").partition(":")) for line, comment in comments]
        found = [(line, value) for line, (key, _, value) in said if key.strip() == name]
        if not found:
            raise self._error("D127", f"no comment line `# {name}:`", None, _EXPORT)
        if len(found) > 1:  # the track may be as wide as either
            raise self._error("D127", f"more than one comment line `# {name}:`", found[1][0], _EXPORT)
        line, value = found[0]
        try:
            points = [_numbers(point, ("x", "y")) for point in _list(parse(value))]
        except BadJson as error:
            raise self._error("D128", f"{name}: {error}", line, "points are [x, y]") from error
        if len(points) < 2 or not all(math.isfinite(z) for point in points for z in point):
            raise self._error("D128", f"{name} needs two or more finite points", line, _EXPORT)
        return points

    def _header(self, line: int, header: str) -> None:
        self.columns = [name.strip() for name in header.split(";")]
        missing = [name for name in _NEEDED if name not in self.columns]
        if missing:
            raise self._error("D127", f"missing columns: {', '.join(missing)}", line, _EXPORT)
        if len(set(self.columns)) != len(self.columns):
            raise self._error("D127", "a column stands twice in the header", line, _EXPORT)
        own = (*_NEEDED, *_TRUTHS)
        self.further = {name: [] for name in self.further if name in self.columns and name not in own}
        for name in self.columns:
            if name not in (*own, *self.further):
                self.notes.append(f"column `{name}` is not known here and was not read")

    def cycles(self) -> tuple[tuple[Cycle, ...], dict[str, tuple[bool | None, ...]]]:
        """All cycles, and ground truth for the columns that are there; raises D127 to D130."""
        faults = Faults()
        cycles: list[Cycle] = []
        truths: dict[str, list[bool | None]] = {
            truth: [] for column, truth in _TRUTHS.items() if column in self.columns
        }
        for line, row in self.rows:
            try:
                cells = self._cells(line, row)
                cycle = self._cycle(line, cells)
                if cycles and cycle.t <= cycles[-1].t:
                    message = f"time {cycle.t:g} s does not come after {cycles[-1].t:g} s"
                    raise self._error("D130", message, line, "sort the rows, take out those given twice")
                for column, truth in _TRUTHS.items():
                    if truth in truths:
                        truths[truth].append(self._truth(line, column, cells[column]))
                for name, found in self.further.items():
                    found.append(self._further(line, name, cells[name]))
                cycles.append(cycle)
            except TrackmarshalError as error:
                faults.add(error)
        faults.check()
        for name, count in self.dropped.items():
            self.notes.append(f"{name}: {count} samples after the first at rest were dropped")
        return tuple(cycles), {name: tuple(values) for name, values in truths.items()}

    def _cells(self, line: int, row: str) -> dict[str, Any]:
        texts = row.split(";")
        if len(texts) != len(self.columns):
            message = f"{len(texts)} cells, the header has {len(self.columns)} columns"
            raise self._error("D127", message, line, "was the file cut off?")
        cells = {}
        for name, text in zip(self.columns, texts):
            if name in _NEEDED or name in _TRUTHS or name in self.further:
                try:
                    cells[name] = parse(text, constants=True)
                except BadJson as error:
                    raise self._error("D128", f"{name}: {error}", line, _EXPORT) from error
        return cells

    def _cycle(self, line: int, cells: dict[str, Any]) -> Cycle:
        column = "time"
        try:
            t = number(cells["time"])
            x, y, psi, kappa, v, a = (_finite(number(cells[column])) for column in _STATE)
            column = "object_array"
            objects = [_object(item) for item in _list(cells[column])]
            if len({item["id"] for item in objects}) != len(objects):
                raise BadJson("an object stands twice in one cycle")
        except BadJson as error:
            raise self._error("D128", f"{column}: {error}", line, _EXPORT) from error
        if not math.isfinite(t):
            raise self._error("D130", "the time is not a finite number", line, _EXPORT)
        ego = {"x": x, "y": y, "heading": _heading(psi), "kappa": kappa, "v": v, "a": a}
        plans = {name: self._plan(line, column, cells[column]) for column, name in _PLANS.items()}
        return Cycle(t, ego, objects, plans)

    def _plan(self, line: int, column: str, value: Any) -> Columns:
        try:
            rows = [_numbers(row, _STATE) for row in _list(value)]
        except BadJson as error:
            raise self._error("D129", f"{column}: {error}", line, _EXPORT) from error
        if not rows:
            raise self._error("D129", f"{column} has no samples", line, "a cycle needs both trajectories")
        x, y, psi, kappa, v, a = (list(values) for values in zip(*rows))
        heading = [_heading(value) for value in psi]
        plan, dropped = complete({"x": x, "y": y, "heading": heading, "kappa": kappa, "v": v, "a": a})
        if dropped:
            name = _PLANS[column]
            self.dropped[name] = self.dropped.get(name, 0) + dropped
        return plan

    def _further(self, line: int, column: str, value: Any) -> Any:
        try:
            return plain(value, column)
        except Wrong as error:
            raise self._error("D128", str(error), line, _EXPORT) from error

    def _truth(self, line: int, column: str, value: Any) -> bool | None:
        if value is None or isinstance(value, bool):
            return value
        message = f"{column}: {kind(value)} stands where true, false or null is expected"
        raise self._error("D128", message, line, _EXPORT)


def _heading(psi: float) -> float:
    """ScenarioArchitect's heading (0 along +y) to 0 along +x, in (-pi, pi]."""
    return wrap(psi + math.pi / 2.0)


def _finite(value: float) -> float:
    """Infinite is as undefined as NaN, and written as NaN."""
    return value if math.isfinite(value) else math.nan


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise BadJson(f"{kind(value)} stands where a list is expected")
    return value


def _numbers(value: Any, names: tuple[str, ...]) -> list[float]:
    """A list of as many numbers as there are names."""
    if len(_list(value)) != len(names):
        raise BadJson(f"{kind(value)} stands where the {len(names)} numbers {', '.join(names)} are expected")
    return [_finite(number(item)) for item in value]


def _object(value: Any) -> dict[str, Any]:
    """["id", [x, y, heading, v, length, width]] to an object of a cycle."""
    if len(_list(value)) != 2 or not isinstance(value[0], str):
        raise BadJson(f"{kind(value)} stands where an object's name and state are expected")
    state = dict(zip(_OBJECT, _numbers(value[1], _OBJECT)))
    state["heading"] = _heading(state["heading"])
    return {"id": value[0], **state, "age": 0.0}
