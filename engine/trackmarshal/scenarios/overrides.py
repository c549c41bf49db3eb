"""What a recording has in place of the spec's own values, and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from trackmarshal.ir.spec import ParamInfo, Spec, TableInfo, short_name
from trackmarshal.scenarios.recording import Recording
from trackmarshal.units import in_full, to_si


@dataclass(frozen=True, slots=True)
class Override:
    """A parameter (kind "param") or a table (kind "table") by its qualified name; in words, what counts in its place and what the spec says.

    because: the recording's reason, empty where it gives none.
    """

    kind: str
    name: str
    value: str
    own: str
    because: str

    def __str__(self) -> str:
        why = f": {self.because}" if self.because else ""
        return f"{self.name} = {self.value} in place of {self.own}{why}"


def known_params(recording: Recording, spec: Spec) -> dict[str, float]:
    """The recording's parameters that are in force with a spec, in declared units.

    One with a reason is a property of how the recording was made, and means nothing to a spec that does not have it; one without is
    meant for this spec, which refuses what it does not know (D203).
    """
    known = spoken(spec.params)
    return {
        name: value
        for name, value in recording.params.items()
        if name in known or name not in recording.because
    }


def known_tables(recording: Recording, spec: Spec) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The recording's tables that the spec declares; a recording brings all that its car had."""
    names = spoken(spec.tables)
    known = {name: rows for name, rows in recording.tables.items() if name in names}
    return known, tuple(sorted(set(recording.tables) - set(known)))


def spoken(infos: Mapping[str, ParamInfo] | Mapping[str, TableInfo]) -> set[str]:
    """What a recording may call parameters or tables: as in their modules, or in full."""
    return {name for info in infos.values() for name in (info.name, short_name(info))}


def unknown_params(recording: Recording, spec: Spec) -> tuple[str, ...]:
    """Those that `known_params` leaves out."""
    return tuple(sorted(recording.params.keys() - known_params(recording, spec).keys()))


def overrides(recording: Recording, spec: Spec) -> Iterator[Override]:
    """What of a spec's own values another one stands for in a replay, in the order of the recording; what is the same as the spec's is none."""
    for name, value in known_params(recording, spec).items():
        for info in _named(spec.params, name):
            if to_si(value, info.unit) != info.value:
                yield Override(
                    "param",
                    info.name,
                    _shown(value, info),
                    in_full(info.value, info.unit),
                    recording.because.get(name, ""),
                )
    for name, rows in recording.tables.items():
        for table in _named(spec.tables, name):
            knots = tuple(tuple(to_si(x, unit) for x, unit in zip(row, table.units)) for row in rows)
            if knots != tuple(zip(table.knots, table.values)):
                yield Override(
                    "table",
                    table.name,
                    f"{len(rows)} knots",
                    f"{len(table.knots)} knots",
                    recording.because.get(name, ""),
                )


def hidden(recording: Recording, old: Spec, new: Spec) -> Iterator[tuple[str, str]]:
    """Values that two specs declare otherwise, and of which the recording shows nothing, since it has its own in place of both: by name (`param x`,
    `table x`), and in words."""
    for name, value in recording.params.items():
        for info in _named(new.params, name):
            before = old.params.get(info.name)
            if before is not None and before.value != info.value:
                both = f"{in_full(before.value, before.unit)} and {in_full(info.value, info.unit)}"
                yield f"param {info.name}", f"{info.name} = {_shown(value, info)} in place of {both}"
    for name in recording.tables:
        for table in _named(new.tables, name):
            was = old.tables.get(table.name)
            if was is not None and (was.knots, was.values) != (table.knots, table.values):
                yield f"table {table.name}", f"the table {table.name} in place of both"


def _named(infos: Any, name: str) -> Iterator[Any]:
    return (info for info in infos.values() if name in (info.name, short_name(info)))


def _shown(value: float, info: ParamInfo) -> str:
    return in_full(to_si(value, info.unit), info.unit)
