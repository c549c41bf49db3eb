"""Names of fields in a recording: one that nobody declares is a misspelt one, and would be lost without a word."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import ParamInfo, Spec, TableInfo, short_name
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.contract.tracks import elsewhere, places_of
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.declared import check_numbers
from trackmarshal.scenarios.inputs import SIGNALS, records_of
from trackmarshal.scenarios.overrides import spoken
from trackmarshal.scenarios.recording import COLUMNS, Recording
from trackmarshal.units import is_si, moment, parse_unit, show

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator

#: What the format has by itself, by signal, and the tables that readers and the generator make.
_POSE = ("x", "y", "heading")
OWN: dict[str, tuple[str, ...]] = {
    "plan": (*COLUMNS, "grip"),
    "ego": (*_POSE, "v", "kappa", "a", "age"),
    "objects": ("id", *_POSE, "v", "length", "width", "age"),
    "obstacles": ("id", *_POSE, "length", "width"),
    "tables": ("ax_max", "grip"),
}
#: Signals that the format has places of its own for.
ELSEWHERE = {
    "ego": "`ego` of the cycle", "objects": "`objects` of the cycle", "obstacles": "`obstacles` of the first line, or of the cycle",
    "track": "`track` of the first line", "plan": "a candidate of the cycle", DRIVING: "`candidates` of the cycle",
    EMERGENCY: "which candidate it is",
}  # fmt: skip


def own_names(recording: Recording) -> frozenset[str]:
    """The names, `objects` and `ego.kappa`, that a recording may have whatever specs declare: the format's, and those of its header."""
    names = {"ego", "objects", "obstacles", "track"}
    for where, fields in OWN.items():
        signals = ("plan", DRIVING, EMERGENCY) if where == "plan" else (where,)
        names |= {
            f"{signal}.{field}" for signal in signals for field in (*fields, *recording.extra.get(where, ()))
        }
    return frozenset(names)


def declared_names(specs: Iterable[Spec]) -> frozenset[str]:
    """The names of signals and their fields that specs declare; those of `plan` for each candidate too."""
    names: set[str] = set()
    for spec in specs:
        names |= {*spec.signals, *spec.events}
        for signal in spec.signals.values():
            labels = ("plan", DRIVING, EMERGENCY) if signal.name == "plan" else (signal.name,)
            names |= {f"{label}.{field.name}" for label in labels for field in signal.fields_}
    return frozenset(names)


def further_names(recording: Recording, evaluator: Evaluator) -> frozenset[str]:
    """What else is declared, where a recording has names that neither it nor the evaluator's spec declares: looked for only then."""
    known = own_names(recording) | declared_names([evaluator.spec])
    names = {f"{where}.{name}" for where, name, _ in _names(recording) if where != "tables"}
    names |= {name for name, _ in _signals(recording)}
    return frozenset() if names <= known else evaluator.declared()


def suggestion(name: str, known: Iterable[str]) -> str:
    """A "did you mean" sentence, also for capitals; or the empty string."""
    names = list(known)
    same = next((each for each in names if each.casefold() == name.casefold()), None)
    return f"did you mean `{same}`?" if same is not None else close_matches(name, names)


def check_fields(recording: Recording, spec: Spec, others: Callable[[], Iterable[Spec]]) -> None:
    """Raise D145 for a field, column or table that neither the format, a spec nor the recording's header declares.

    `spec` is the one at hand; `others` gives further specs of the project, and is called only where that one does not say it all.
    """
    known = {where: {*names, *recording.extra.get(where, ())} for where, names in OWN.items()}
    _declare(known, spec)
    asked = False
    declared = {*spec.signals, *spec.events}
    for name, at in _signals(recording):
        if name not in declared:
            declared |= {each for other in others() for each in (*other.signals, *other.events)}
        if name not in declared:
            help_ = suggestion(name, sorted(declared)) or "a module has to declare it: `signal`, or `event`"
            message = f"the signal `{name}` is declared nowhere{at}"
            raise TrackmarshalError("D145", message, file=recording.source, help=help_)
    for where, name, at in _names(recording):
        if name in known[where]:
            continue
        if not asked:
            asked = True
            for other in others():
                _declare(known, other)
        if name not in known[where]:
            shown = "a table" if where == "tables" else f"a field of `{where}`"
            help_ = suggestion(name, sorted(known[where]))
            declare = f'`"extra": {{"{where}": ["{name}"]}}` in the first line declares what no spec reads'
            raise TrackmarshalError(
                "D145",
                f"`{name}` is declared nowhere as {shown}{at}",
                file=recording.source,
                help=f"{help_} {declare}".strip(),
            )


def check_fit(recording: Recording, evaluator: Evaluator) -> None:
    """Raise D146 where rules read places of another track than the one that the recording names, D147 where the spec has numbers in other units
    than recordings, and D162 where what rules may read of the record of a run is in another unit than the spec's, or a member that an old
    one does not name."""
    if recording.of_run is None:
        _check_si(recording, evaluator)
    else:
        contract = of_cycles(evaluator.spec, evaluator.rules)
        check_numbers(recording.of_run, evaluator.spec, contract, recording.params, recording.tables)
    name = recording.track.get("name")
    problem = elsewhere(places_of(evaluator.spec, evaluator.rules), name) if isinstance(name, str) else ""
    if problem:
        help_ = f"name a module `tracks.{name}` with them: in the recording's `use`, or with --with"
        raise TrackmarshalError("D146", problem, file=recording.source, help=help_)


def _check_si(recording: Recording, evaluator: Evaluator) -> None:
    """Raise D147 for a number of the format's own, or of what was made in SI, that would be taken in another unit."""
    spec = evaluator.spec
    for name in SIGNALS:
        for field in spec.signals[name].fields_ if name in spec.signals else ():
            # What is given is in the declared unit.
            own = field.name in OWN[name] and f"{name}.{field.name}" not in recording.given
            if own and field.kind == "number" and not is_si(field.unit):
                if any(field.name in each for each in records_of(recording, name)):
                    raise _not_si(recording, f"{name}.{field.name}", field.unit)
    for kind, name in sorted(recording.in_si):
        if name not in (recording.params if kind == "params" else recording.tables):
            continue  # what the command line says counts more
        infos: Mapping[str, ParamInfo | TableInfo] = spec.params if kind == "params" else spec.tables
        for info in infos.values():
            units = info.units if isinstance(info, TableInfo) else (info.unit,)
            for unit in units if name in (info.name, short_name(info)) else ():
                if not is_si(unit):
                    raise _not_si(recording, name, unit)


def _not_si(recording: Recording, name: str, unit: str) -> TrackmarshalError:
    wanted = show(parse_unit(unit)[2])
    return TrackmarshalError(
        "D147",
        f"the spec has `{name}` in {unit}, and recordings have it in {wanted}",
        file=recording.source,
        help=f"declare it in {wanted}; what rules ask of it may be in any unit",
    )


def unnamed_track(recording: Recording, evaluator: Evaluator) -> str:
    """What nobody can check, in words: places of a named track on a recording that does not name its own; empty where there are none."""
    places = places_of(evaluator.spec, evaluator.rules)
    if not places or isinstance(recording.track.get("name"), str):
        return ""
    tracks = " and ".join(f"`{track}`" for track in dict.fromkeys(track for _, track in places))
    return f"it names no track; taken is that it is on {tracks}, where the places are that rules read"


def other_spec(recording: Recording, evaluator: Evaluator) -> str:
    """What is said where a recording was the record of a run under another spec than the one at hand; empty for all others."""
    return "" if recording.of_run is None else recording.of_run.other_spec(evaluator.spec)


def _declare(known: dict[str, set[str]], spec: Spec) -> None:
    for where, names in known.items():
        signal = spec.signals.get(where)
        if signal is not None:
            names.update(field.name for field in signal.fields_)
    known["tables"] |= spoken(spec.tables)


def _signals(recording: Recording) -> Iterator[tuple[str, str]]:
    """Every signal besides the format's once: its name, and when for the first time."""
    seen: set[str] = set()
    rows = [
        ("", recording.always),
        *((f", at t = {moment(cycle.t)} s", cycle.more) for cycle in recording.cycles),
    ]
    for at, signals in rows:
        for name in signals.keys() - seen:
            seen.add(name)
            yield name, at


def _names(recording: Recording) -> Iterator[tuple[str, str, str]]:
    """Every name once: where it stands, the name, and when for the first time."""
    seen: set[tuple[str, str]] = set()
    for name in recording.tables:
        yield "tables", name, ""
    for obstacle in recording.obstacles:
        for name in obstacle:
            if ("obstacles", name) not in seen:
                seen.add(("obstacles", name))
                yield "obstacles", name, ""
    for cycle in recording.cycles:
        records = [("ego", cycle.ego), *(("objects", each) for each in cycle.objects)]
        records += [("obstacles", each) for each in cycle.obstacles or ()]
        records += [("plan", columns) for columns in cycle.candidates.values()]
        for where, record in records:
            for name in record:
                if (where, name) not in seen:
                    seen.add((where, name))
                    yield where, name, f", at t = {moment(cycle.t)} s"
