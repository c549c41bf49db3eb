"""Configurations: modules whose parameters, tables and places replace those of a spec, and are refused where they do not fit (E402)."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import ParamInfo, PlaceInfo, Spec, TableInfo, short_name
from trackmarshal.units import parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.compile import Compiled
    from trackmarshal.syntax import ast

CODES = {
    "E402": (
        "a configuration that does not fit",
        "A configuration is a module whose parameters, tables, zones and lines replace those of the same name in the spec; each "
        "must exist there, in one module of those that rules, constraints and what they rest on read, with the same unit's dimension, and lie inside the "
        "range that the spec declares. Of a folder, no two modules set one name otherwise. Rules, constraints and whatever else demands something would "
        "not be in force there, and are refused.",
    ),
}


def configured(
    compiled: Compiled, configuration: str | Path | Iterable[str | Path], shown_from: Path | None
) -> Spec:
    """A compiled spec with the values of configuration modules put in; raises Diagnostics for what is wrong with any of them."""
    compiled.raise_errors()
    spec = compiled.spec
    all_settings = [_settings(path, shown_from, compiled) for path in paths_of(configuration)]
    given = {short_name(info) for settings in all_settings for info in settings.params.values()}
    for settings in all_settings:
        spec = configure(spec, settings, given)
    return spec


def setting_names(paths: Iterable[Path], configuration: Sequence[Path]) -> set[str]:
    """The names of everything that configuration modules set in a spec, in full and as in its module; raises as `load` does."""
    from trackmarshal.semantics.compile import compile_paths

    if not configuration:
        return set()
    compiled = compile_paths(paths)
    compiled.raise_errors()
    found = [_settings(path, None, compiled) for path in configuration]
    short = {
        short_name(info)
        for settings in found
        for kind in (settings.params, settings.tables, settings.places)
        for info in kind.values()
    }
    own = compiled.spec
    infos = (info for kind in (own.params, own.tables, own.places) for info in kind.values())
    return short | {info.name for info in infos if short_name(info) in short}


def configure(spec: Spec, settings: Spec, given: Collection[str] = ()) -> Spec:
    """The spec with the values of another module's parameters, tables and places in place of its own.

    given: the parameters that others set beside it, whichever comes first, by their names in a module.
    """
    given = {*given, *(short_name(info) for info in settings.params.values())}
    params, tables, places = dict(spec.params), dict(spec.tables), dict(spec.places)
    kinds: tuple[tuple[str, dict[str, Any], Mapping[str, Any]], ...] = (
        ("parameter", params, settings.params), ("table", tables, settings.tables), ("place", places, settings.places)
    )  # fmt: skip
    for kind, target, source in kinds:
        for info in source.values():
            _refuse_several(spec, given, kind, target, info)
            _refuse_contradicted(kind, source, info)
            _replace(kind, target, info)
    digest = hashlib.sha256(spec.fingerprint.encode())
    for setting in (*params.values(), *tables.values(), *places.values()):
        digest.update(repr(setting).encode())
    return Spec(
        spec.signals,
        spec.events,
        params,
        tables,
        places,
        spec.constraints,
        spec.rules,
        spec.rulebooks,
        digest.hexdigest(),
        spec.scales,
        spec.courses,
    )


def _settings(path: Path, shown_from: Path | None, compiled: Compiled) -> Spec:
    """What a configuration module sets; raises Diagnostics, and E402 for what it holds that would be left out.

    Modules of the spec that it uses are in force already, with the values that they have there.
    """
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.semantics.modules import from_prelude

    made = compile_paths([path], shown_from)
    made.raise_errors()
    known = {module.path.resolve() for module in compiled.library.modules.values()}
    own = [module for module in made.library.modules.values() if module.path.resolve() not in known]
    _refuse_ignored([module.tree for module in own if not from_prelude(module)])
    files = {module.file.path for module in (*own, *(made.library.modules[name] for name in made.asked))}
    params, tables, places = made.spec.params, made.spec.tables, made.spec.places
    return Spec(
        {},
        {},
        {name: info for name, info in params.items() if info.span.file.path in files},
        {name: info for name, info in tables.items() if info.span.file.path in files},
        {name: info for name, info in places.items() if info.span.file.path in files},
        (),
        (),
        (),
        made.spec.fingerprint,
    )


def _refuse_ignored(trees: Sequence[ast.Module]) -> None:
    """Refuse everything in configuration modules that demands something, or means to: only values of theirs are used."""
    from trackmarshal.syntax import ast

    items = [item for tree in trees for item in tree.items]
    values = [
        item
        for item in items
        if isinstance(item, (ast.Param, ast.ParamRecord, ast.Table, ast.Place, ast.Define))
    ]
    nodes = [node for item in values for node in item.walk()]
    called = {node.function for node in nodes if isinstance(node, ast.Call)}
    called |= {node.name for node in nodes if isinstance(node, ast.Name)}
    for item in items:
        match item:
            case (
                ast.ModuleName()
                | ast.Use()
                | ast.Reference()
                | ast.Param()
                | ast.ParamRecord()
                | ast.Table()
                | ast.Place()
            ):
                continue
            case ast.Define():
                if item.name in called:
                    continue
                what = f"the {item.keyword} `{item.name}`"
            case ast.Rule():
                what = f"the rule `{item.name}`"
            case ast.Assume():
                what = f"the assumption `{item.name}`"
            case ast.Constrain():
                what = "a `constrain`"
            case ast.Shape():
                what = f"the shape `{item.name}`"
            case ast.Scale():
                what = "a `scale`"
            case ast.Signal():
                what = f"the signal `{item.name}`"
            case ast.Event():
                what = f"the event `{item.name}`"
            case ast.Course():
                what = f"the course `{item.name}`"
            case ast.Enum():
                what = f"the enumeration `{item.name}`"
            case ast.Stretch():
                what = f"the stretch `{item.name}`"
            case ast.State():
                what = f"the state `{item.name}`"
            case ast.Rulebook():
                what = f"the rulebook `{item.name}`"
            case ast.Test():
                what = f"a test of `{item.rule}`"
            case _:
                raise AssertionError(f"unknown declaration {type(item).__name__}")
        raise TrackmarshalError(
            "E402",
            f"a configuration holds {what}, which would not be in force",
            file=item.span.file.path,
            line=item.span.line,
            help="a configuration only sets values; move it to the spec, or name this file as a part of the spec",
        )


def _refuse_several(
    spec: Spec, given: Collection[str], kind: str, target: Mapping[str, ParamInfo | TableInfo | PlaceInfo], info: ParamInfo | TableInfo | PlaceInfo
) -> None:  # fmt: skip
    """Raise E402 for a name of several declarations that rules read: which of them is meant, nobody can tell, as of data (D203)."""
    short = short_name(info)
    # The configuration may be a module of the spec; another file of that module's name is none.
    itself = info.span.file.text
    meant = [
        name for name, old in target.items() if short_name(old) == short and old.span.file.text != itself
    ]
    if len(meant) < 2:  # mostly
        return
    formulas = [formula for rule in spec.rules for formula in (rule.formula, rule.active)]
    formulas += [constraint.formula for constraint in spec.constraints]
    read = {
        node.table if isinstance(node, ir.Lookup | ir.GridLookup) else node.name
        for formula in formulas
        if formula is not None
        for node in ir.below(formula)
        if isinstance(node, ir.Param | ir.Lookup | ir.GridLookup | ir.Area | ir.Line)
    }
    # What a parameter is made of is read for it, unless it is set, too.
    left = list(read)
    for name in left:
        if name in spec.params and short_name(spec.params[name]) not in given:
            left += [each for each in spec.params[name].made_of if each not in read]
            read.update(left)
    several = sorted(read.intersection(meant))
    if len(several) > 1:
        raise TrackmarshalError(
            "E402",
            f"{kind} `{short}` is declared in several modules: {' and '.join(f'`{name}`' for name in several)}",
            file=f"{info.span.file.path}",
            line=info.span.line,
            help="rename all but the one that the configuration is to replace",
        )


def _refuse_contradicted(
    kind: str,
    source: Mapping[str, ParamInfo | TableInfo | PlaceInfo],
    info: ParamInfo | TableInfo | PlaceInfo,
) -> None:
    """Raise E402 where another module of a configuration, such as of a folder of vehicles, sets the same name otherwise: nobody said which one counts."""
    short = short_name(info)
    for other in source.values():
        if short_name(other) == short and _set(other) != _set(info):
            raise TrackmarshalError(
                "E402",
                f"{kind} `{short}` is set otherwise at {other.span}, in the same configuration",
                file=f"{info.span.file.path}",
                line=info.span.line,
                help="name the one file that is to count; of several that are named one by one, the last one does",
            )


def _set(info: ParamInfo | TableInfo | PlaceInfo) -> object:
    """What a configuration sets, in SI."""
    if isinstance(info, ParamInfo):
        return info.value
    return (info.knots, info.values, info.across) if isinstance(info, TableInfo) else info.points


def _replace(kind: str, target: dict[str, Any], info: ParamInfo | TableInfo | PlaceInfo) -> None:
    """Put a value in place of those of its name; raises E402 where there is none, or it does not fit one."""
    short = short_name(info)
    matches = [known for known, old in target.items() if short_name(old) == short]
    place = f"{info.span.file.path}"
    if not matches:
        shorts = [short_name(old) for old in target.values()]
        raise TrackmarshalError(
            "E402",
            f"the spec declares no {kind} `{short}`",
            file=place,
            line=info.span.line,
            help=close_matches(short, shorts) or f"it declares {', '.join(shorts) or 'none'}",
        )
    for match in matches:
        old = target[match]
        problem = ""
        if isinstance(info, ParamInfo):
            low, high = old.lower, old.upper
            if parse_unit(info.unit)[2] != parse_unit(old.unit)[2]:
                problem = f"`{short}` is in {info.unit}, the spec declares it in {old.unit}"
            elif (low is not None and info.value < low) or (high is not None and info.value > high):
                problem = f"`{short}` is outside the range declared at {old.span}"
            new: Any = ParamInfo(match, info.value, old.unit, low, high, info.source, info.span, old.record)
        elif isinstance(info, TableInfo):
            if [parse_unit(u)[2] for u in info.units] != [parse_unit(u)[2] for u in old.units]:
                problem = f"table `{short}` has other units than the one declared at {old.span}"
            elif _ways(info) != _ways(old):
                problem = f"table `{short}` is read in another way than the one declared at {old.span}"
            new = TableInfo(match, info.knots, info.values, old.units, info.span, info.way, info.across)
        elif isinstance(info, PlaceInfo):
            if info.kind != old.kind:
                problem = f"`{short}` is a {info.kind}, the spec declares a {old.kind}"
            new = PlaceInfo(match, info.kind, info.points, info.span, info.track)
        else:
            raise AssertionError(f"unknown setting {type(info).__name__}")
        if problem:
            help_ = "a configuration changes values, within what the spec declares"
            raise TrackmarshalError("E402", problem, file=place, line=info.span.line, help=help_)
        target[match] = new


def _ways(info: TableInfo) -> list[Any]:
    """What a configuration cannot change of a table: how many arguments it has, of which dimension the second is, and how it is read."""
    second = info.across
    axes = (
        [(info.way, None)] if second is None else [(info.way, None), (second.way, parse_unit(second.unit)[2])]
    )
    return [(way.steps, way.clamped, way.length > 0.0, dimension) for way, dimension in axes]


def paths_of(given: str | Path | Iterable[str | Path]) -> list[Path]:
    """One path or several; raises TypeError."""
    paths = [given] if isinstance(given, (str, Path)) else given
    if not isinstance(paths, Iterable):
        raise wrong_type("files and folders are a path or a list of paths", given)
    paths = list(paths)
    for path in paths:
        if not isinstance(path, (str, Path)):
            raise wrong_type("a path is a text or a `Path`", path)
    return [Path(path) for path in paths]
