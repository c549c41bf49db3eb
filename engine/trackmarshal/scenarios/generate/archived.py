"""Archives of the ScenarioArchitect with more than a car's own signals: a declaration says which columns are which, and what else is true."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from trackmarshal.scenarios import content, saa
from trackmarshal.scenarios.generate import document, given, road, rule_truth
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.further import Further, with_further
from trackmarshal.scenarios.generate.given import Given, GivenSignal
from trackmarshal.scenarios.generate.words import Specs
from trackmarshal.scenarios.recording import Recording

FORMAT = "trackmarshal-archive"


def load(path: Path, shown: str) -> Recording:
    """The archive that a declaration names, with the signals and truths that it gives; raises D120 to D131, D150, D151, D175, D250 to D255."""
    fields = road.expect(
        document.read(content.read(path, shown), shown),
        FORMAT,
        ("archive", "specs"),
        ("name", "sha256", "signals", "ego", "truth", "use", "notes", "params", "tables"),
    )
    specs = given.specs(list(fields["specs"].items()), path.parent)
    if not specs:
        raise fields["specs"].wrong("no spec is named", "name those that declare the signals")
    further = Further(
        given.signals(fields["signals"]) if "signals" in fields else (),
        given.fields(fields["ego"]) if "ego" in fields else (),
    )
    truth = rule_truth.entries(list(fields["truth"].items()) if "truth" in fields else [])
    recording, columns = _archive(fields, path.parent, further)
    use = tuple(item.text() for item in _list(fields, "use"))
    notes = tuple(item.said() for item in _list(fields, "notes"))
    params = fields["params"].any_fields() if "params" in fields else {}
    tables = fields["tables"].any_fields() if "tables" in fields else {}
    recording = replace(
        recording,
        name=fields["name"].text() if "name" in fields else recording.name,
        source=shown,
        use=use,
        notes=(*recording.notes, *notes),
        params={**recording.params, **{name: value.number() for name, value in params.items()}},
        because={name: why for name, why in recording.because.items() if name not in params},
        tables={**recording.tables, **{name: value.rows() for name, value in tables.items()}},
        in_si=recording.in_si - {("params", name) for name in params} - {("tables", name) for name in tables},
    )
    known = Specs(specs)
    return rule_truth.with_truth(with_further(recording, further, known, columns), truth, known)


def _list(fields: dict[str, Item], name: str) -> Iterable[Item]:
    return fields[name].items() if name in fields else ()


def _archive(
    fields: dict[str, Item], folder: Path, further: Further
) -> tuple[Recording, dict[str, list[object]]]:
    """What the archive says, and the columns that are asked for."""
    item = fields["archive"]
    name = item.text()
    # What comes from elsewhere does not choose any file to be opened and quoted in a message.
    if Path(name).is_absolute() or Path(name).suffix != ".saa" or "\0" in name:
        raise item.wrong(f"`{name}` is no path of an archive", "a .saa file, relative to this one")
    shown = str(Path(item.shown).parent / name)
    data = content.read(folder / name, shown)
    wanted = fields["sha256"].text() if "sha256" in fields else ""
    if wanted and hashlib.sha256(data).hexdigest() != wanted:
        message = "this is not the archive that is named: its hash is another"
        raise fields["sha256"].wrong(message, f"it is {hashlib.sha256(data).hexdigest()}", "D175")
    return saa.read_with(data, shown, {each.column for each in _all(further) if each.column})


def _all(further: Further) -> Iterator[Given]:
    yield from further.ego
    for signal in further.signals:
        yield from _parts(signal)


def _parts(signal: GivenSignal) -> Iterator[Given]:
    if signal.whole is not None:
        yield signal.whole
    yield from signal.fields
