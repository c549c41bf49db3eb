"""Declarations of logs: which column is what, in which unit and convention, and what is made of it; see docs/field.md."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from trackmarshal.scenarios import content
from trackmarshal.scenarios.generate import document
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.inputs import not_to_be_given
from trackmarshal.units import LENGTH as METRES
from trackmarshal.units import NUMBER, SPEED, TIME, Dimension, over, parse_unit

FORMAT = "trackmarshal-log-map"
VERSION = 1
_HASH_LENGTH = 64
#: s: up to when cycles are made, from the first row.
LATEST = 1e6

#: What a log's columns may be, with their dimension; the first five have to be there.
COLUMNS: dict[str, Dimension] = {
    "t": TIME, "x": METRES, "y": METRES, "heading": NUMBER, "v": SPEED, "yaw_rate": over(NUMBER, TIME),
}  # fmt: skip
#: What is written in logs and not in specs: multiplier and divisor to SI, as of `parse_unit`, and dimension. A mile is 1609.344 m.
OF_LOGS: dict[str, tuple[float, float, Dimension]] = {"ns": (1.0, 1e9, TIME), "mph": (1397.0, 3125.0, SPEED)}
NEEDED = ("t", "x", "y", "heading", "v")
#: The direction of a heading of zero, as an angle from +x in quarter turns.
ZEROS = {"+x": 0, "+y": 1, "-x": 2, "-y": 3}
#: What a vehicle's spec says of how it brakes, by which emergency trajectories are made.
BRAKING = ("mu", "g", "mass", "drag", "b_max")
_ONE_COLUMN = "the column `{}` is to be `{}`, too"
#: What a firing may be put down to by a person.
DECLARED_CAUSES = ("rule", "real")


@dataclass(frozen=True, slots=True)
class Column:
    """A column: its name in the header or, where there is no header, its number from 1; for MCAP `/topic.field.field`."""

    name: str | int
    unit: str
    line: int


@dataclass(frozen=True, slots=True)
class Named:
    """A file that the mapping names, with the hash that it must have; empty: any."""

    path: str
    sha256: str
    line: int


@dataclass(frozen=True, slots=True)
class Border:
    file: Named
    x: Column
    y: Column
    delimiter: str = ","


@dataclass(frozen=True, slots=True)
class Gap:
    """From begin to end, s, the map is known not to hold what was driven on."""

    begin: float
    end: float
    because: str


@dataclass(frozen=True, slots=True)
class Finding:
    """A person's word on the firings of a rule from begin to end, s."""

    rule: str
    begin: float
    end: float
    cause: str
    because: str


@dataclass(frozen=True, slots=True)
class Mapping:
    """Everything that is declared about a log, in SI. `source`: as messages call it; `path`: where it lies."""

    source: str
    path: Path
    name: str
    log: Named | None
    delimiter: str
    columns: dict[str, Column]
    heading_zero: int  #: quarter turns from +x
    heading_sign: int  #: 1: counter-clockwise
    forward: float  #: m: how far the vehicle's middle lies ahead of the logged point
    hold: float  #: s: how old a message of another topic may be
    begin: float
    end: float | None
    rate: float  #: Hz
    track: tuple[Border, Border]
    closed: bool
    vehicle: str
    use: tuple[str, ...]
    horizon: float  #: s
    step: float  #: s
    share: float  #: of the friction limit that the emergency trajectory takes
    smoother: bool
    noise: dict[str, float] = field(default_factory=dict)
    gaps: tuple[Gap, ...] = ()
    findings: tuple[Finding, ...] = ()
    #: Inputs that the log does not have, `plan.grip`, by name: the number for all cycles, and why.
    given: dict[str, tuple[float, str]] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """What paths are relative to."""
        return self.path.parent


def unit_of(text: str) -> tuple[float, float, Dimension]:
    """A unit of a log to (multiplier, divisor, dimension), see `parse_unit`; raises ValueError as it does."""
    return OF_LOGS[text] if text in OF_LOGS else parse_unit(text)


def read(path: Path, shown: str | None = None) -> Mapping:
    """Read a mapping; raises D120, D124, D126, D150 and D151, with the line."""
    shown = shown or str(path)
    root = document.read(content.read(path, shown), shown)
    return _mapping(root, path)


def _mapping(root: Item, path: Path) -> Mapping:
    root.expect(FORMAT)
    top = root.fields(
        ("format", "version", "name", "columns", "track", "vehicle", "plan", "emergency"),
        ("log", "delimiter", "pose", "time", "use", "smoother", "noise", "gaps", "findings", "hold", "given"),
    )
    if top["version"].count(0, 10**6) != VERSION:
        raise top["version"].wrong("this version is not known", f"known is {VERSION}", "D143")
    columns, zero, sign = _columns(top["columns"])
    time = top["time"].fields((), ("from", "to", "rate")) if "time" in top else {}
    begin = time["from"].number(0.0, LATEST) if "from" in time else 0.0
    end = time["to"].number(begin, LATEST) if "to" in time else None
    track = top["track"].fields(("left", "right"), ("closed",))
    plan = top["plan"].fields(("horizon", "step"))
    emergency = top["emergency"].fields(("share",))
    step = plan["step"].number(0.01, 1.0)
    pose = top["pose"].fields(("forward",)) if "pose" in top else {}
    return Mapping(
        root.shown, path, top["name"].text(), _named(top["log"]) if "log" in top else None,
        top["delimiter"].choice((",", ";", "tab")) if "delimiter" in top else ",", columns, zero, sign,
        pose["forward"].number(-20.0, 20.0) if pose else 0.0, top["hold"].number(0.0, 10.0) if "hold" in top else 0.1, begin, end,
        time["rate"].number(0.1, 1000.0) if "rate" in time else 10.0,
        (_border(track["left"]), _border(track["right"])), track["closed"].flag() if "closed" in track else False,
        top["vehicle"].text(), tuple(item.text() for item in top["use"].items()) if "use" in top else (),
        plan["horizon"].number(2 * step, 60.0), step, emergency["share"].number(0.05, 1.0),
        top["smoother"].choice(("rts", "none")) == "rts" if "smoother" in top else True,
        _noise(top["noise"]) if "noise" in top else {},
        tuple(_gap(item) for item in top["gaps"].items()) if "gaps" in top else (),
        _findings(top["findings"]) if "findings" in top else (),
        _given(top["given"]) if "given" in top else {},
    )  # fmt: skip


def _columns(item: Item) -> tuple[dict[str, Column], int, int]:
    found = item.fields(NEEDED, [name for name in COLUMNS if name not in NEEDED])
    columns: dict[str, Column] = {}
    zero = sign = 0
    for name, entry in found.items():
        more = ("zero", "turns") if name == "heading" else ()
        fields = entry.fields(("column", "unit", *more))
        columns[name] = _column(fields["column"], fields["unit"], COLUMNS[name])
        if more:
            zero = ZEROS[fields["zero"].choice(tuple(ZEROS))]
            sign = 1 if fields["turns"].choice(("left", "right")) == "left" else -1
    first: dict[str | int, str] = {}
    for name, column in columns.items():
        other = first.setdefault(column.name, name)
        if other != name:
            raise found[name].wrong(_ONE_COLUMN.format(column.name, other), "each is a column of its own")
    return columns, zero, sign


def _column(item: Item, unit: Item, dimension: Dimension) -> Column:
    text = unit.text()
    try:
        actual = unit_of(text)[2]
    except ValueError as error:
        help_ = f"units are written as in specs: m, km/h, deg, rad/s, us, ...; and {', '.join(OF_LOGS)}"
        raise unit.wrong(f"`{error}` is not a unit", help_) from error
    if actual != dimension:
        wanted = {METRES: "m", TIME: "s", SPEED: "m/s", NUMBER: "rad"}.get(dimension, "rad/s")
        raise unit.wrong(f"{text} does not measure what this column is", f"a unit like {wanted}")
    return Column(_column_name(item), text, item.line)


def _column_name(item: Item) -> str | int:
    """A name, or the number of a column where it is nothing but digits."""
    text = item.said()
    return item.count(1, 10_000) if text.isascii() and text.isdigit() else text


def _named(item: Item) -> Named:
    fields = item.fields(("path",), ("sha256",))
    digest = fields["sha256"].text() if "sha256" in fields else ""
    if digest and (len(digest) != _HASH_LENGTH or set(digest) - set("0123456789abcdef")):
        raise fields["sha256"].wrong("this is no sha256", "64 digits 0 to 9 and a to f")
    return Named(fields["path"].text(), digest, item.line)


def _border(item: Item) -> Border:
    fields = item.fields(("path", "x", "y"), ("sha256", "unit", "delimiter"))
    unit = fields["unit"].text() if "unit" in fields else "m"
    try:
        fits = parse_unit(unit)[2] == METRES
    except ValueError:
        fits = False
    if not fits:
        raise fields["unit"].wrong(f"{unit} is no length", "a unit like m")
    digest = fields["sha256"].text() if "sha256" in fields else ""
    x, y = (Column(_column_name(fields[name]), unit, fields[name].line) for name in ("x", "y"))
    if x.name == y.name:
        raise fields["y"].wrong(_ONE_COLUMN.format(x.name, "x"), "each is a column of its own")
    delimiter = fields["delimiter"].choice((",", ";", "tab")) if "delimiter" in fields else ","
    return Border(Named(fields["path"].text(), digest, item.line), x, y, delimiter)


def _noise(item: Item) -> dict[str, float]:
    known = ("along", "across", "heading", "speed", "yaw_rate", "jerk", "lateral_jerk")
    return {name: entry.number(1e-9, 1e3) for name, entry in item.fields((), known).items()}


def _span(fields: dict[str, Item]) -> tuple[float, float]:
    begin = fields["from"].number(0.0)
    return begin, fields["to"].number(begin)


def _gap(item: Item) -> Gap:
    fields = item.fields(("from", "to", "because"))
    return Gap(*_span(fields), fields["because"].said())


def _given(item: Item) -> dict[str, tuple[float, str]]:
    found = {}
    for name, entry in item.any_fields().items():
        problem = not_to_be_given(name)
        if problem:
            raise entry.wrong(problem, "a field that a log does not have: `plan.grip`, `ego.age`")
        fields = entry.fields(("value", "because"))
        if not fields["because"].text().strip():
            raise fields["because"].wrong("the reason is empty", "say where the number is from")
        found[name] = fields["value"].number(), fields["because"].said()
    return found


def _findings(item: Item) -> tuple[Finding, ...]:
    """Persons' words, of which no two put the same firing down to different causes: nobody would see that the second one counts for nothing."""
    found: list[Finding] = []
    for entry in item.items():
        made = _finding(entry)
        for other in found:
            begin, end = max(made.begin, other.begin), min(made.end, other.end)
            both = begin < end or (made.begin, made.end) == (other.begin, other.end)
            if made.rule == other.rule and made.cause != other.cause and both:
                message = f"from {begin:g} to {end:g} s, `{made.rule}` is put down to `{other.cause}` and to `{made.cause}`"
                raise entry.wrong(message, "agree on one of both")
        found.append(made)
    return tuple(found)


def _finding(item: Item) -> Finding:
    fields = item.fields(("rule", "from", "to", "cause", "because"))
    cause = fields["cause"].choice(DECLARED_CAUSES)
    return Finding(fields["rule"].text(), *_span(fields), cause, fields["because"].said())
