"""The vehicle of a declaration: as it stands there, from a file of its own, or what a spec says of the car that its rules are about."""

from __future__ import annotations

from pathlib import Path

from trackmarshal.library import shipped_values
from trackmarshal.scenarios import content
from trackmarshal.scenarios.generate import document, road
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.limits import Vehicle

_NEEDED = ("length", "width", "turn_radius", "brake", "grip", "drive")
_OF_A_SPEC = ("length", "width", "R_min", "b_max", "mu", "g", "drag", "mass", "drive_factor")


def vehicle(item: Item, folder: Path) -> Vehicle:
    """A map, or the path of a `.yaml` file with the same fields, or of a `.spec` with the parameters and the table of the shipped vehicles, or
    the module of one of these.

    Of a map or a `.yaml`, the recording overrides what the shipped vehicles are made of, or `params` and `tables` where these are given. Of
    a `.spec`, it overrides nothing, and its notes name the spec. Raises D120, D150, D151, and the diagnostics of a spec.
    """
    if item.is_map():
        return _of_fields(item.fields(_NEEDED, ("params", "tables")))
    name = item.text()
    shipped = shipped_values(name)
    if shipped is not None:
        return _of_spec(item, name, shipped)
    # What comes from elsewhere does not choose any file to be opened and quoted in a message.
    if Path(name).is_absolute() or Path(name).suffix not in (".yaml", ".yml", ".spec") or "\0" in name:
        raise item.wrong(
            f"`{name}` is no path of a vehicle",
            "a .yaml or .spec file, relative to this one, or a shipped module, `vehicles.devbot`",
        )
    if Path(name).suffix == ".spec":
        return _of_spec(item, name, folder / name)
    shown = str(Path(item.shown).parent / name)
    own = document.read(content.read(folder / name, shown), shown)
    return _of_fields(road.expect(own, "trackmarshal-vehicle", _NEEDED, ("params", "tables")))


def _of_fields(fields: dict[str, Item]) -> Vehicle:
    params, tables = (fields[key].any_fields() if key in fields else None for key in ("params", "tables"))
    return Vehicle(
        length=fields["length"].number(0.1, 50.0),
        width=fields["width"].number(0.1, 10.0),
        turn_radius=fields["turn_radius"].number(0.1, 1000.0),
        brake=fields["brake"].number(0.1, 100.0),
        grip=fields["grip"].number(0.1, 100.0),
        drive=fields["drive"].rows(),
        own_params=None if params is None else {name: value.number() for name, value in params.items()},
        own_tables=None if tables is None else {name: value.rows() for name, value in tables.items()},
    )


def _of_spec(item: Item, name: str, path: Path) -> Vehicle:
    from trackmarshal.ir.tables import LINEAR_CLAMP
    from trackmarshal.semantics.compile import compile_paths

    if not path.is_file():
        raise item.wrong(f"`{name}` is not there", "a .spec file, relative to this one, or a shipped module")
    compiled = compile_paths([path])
    compiled.raise_errors()
    values = {info.short: info.value for info in compiled.spec.params.values()}
    tables = {info.name.rpartition(".")[2]: info for info in compiled.spec.tables.values()}
    missing = [each for each in _OF_A_SPEC if each not in values] + ["ax_max"] * ("ax_max" not in tables)
    if missing:
        help_ = f"a vehicle has {', '.join(_OF_A_SPEC)} and the table ax_max"
        raise item.wrong(f"the vehicle of `{name}` has no `{missing[0]}`", help_)
    drive = tables["ax_max"]
    if drive.across is not None or drive.way != LINEAR_CLAMP:
        raise item.wrong(f"the table `ax_max` of `{name}` is not read linearly over speed", "`linear clamp`")
    return Vehicle(
        length=values["length"],
        width=values["width"],
        turn_radius=values["R_min"],
        brake=values["b_max"],
        grip=values["mu"] * values["g"],
        drive=[[v, values["drive_factor"] * a] for v, a in zip(drive.knots, drive.values)],
        drag=values["drag"] / values["mass"],
        own_params={},
        own_tables={},
        spec=name,
    )
