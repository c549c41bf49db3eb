"""trackmarshal's own open format for recordings: one JSON Lines file, `*.tmrec.jsonl` (also packed, `.gz`).

The first line is the header, every further line a cycle; recording.schema.json describes both. Strict JSON: numbers
that are not finite are the texts "nan", "inf" and "-inf", and null is read as NaN (a missing value). Reading what
was written gives an equal recording.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import other_there, write_whole
from trackmarshal.json_text import BadJson, parse
from trackmarshal.scenarios import content, structure
from trackmarshal.scenarios.codes import Faults
from trackmarshal.scenarios.inputs import filled
from trackmarshal.scenarios.recording import Cycle, Recording
from trackmarshal.scenarios.structure import Wrong
from trackmarshal.units import moment

FORMAT = "trackmarshal-recording"
VERSION = 1


def write(recording: Recording, path: str | Path) -> None:
    """Write a recording; packed where the path ends in .gz. Raises D120 where that fails or something else is there, D124 for one that is too
    large to be read, D141 for what it cannot say.

    What is written is decoded once before it reaches the disk: a file that cannot be read again is never made. It is written whole or not at all:
    a part of one that ends with a line would be a shorter recording, and what stood there before would be gone.
    """
    path = Path(path)
    data = "".join(line + "\n" for line in encode(recording)).encode()
    if len(data) > content.MAX_BYTES:
        raise content.too_large(str(path), f"{len(data)} bytes")
    decode(data, str(path))
    if path.suffix == ".gz":
        data = content.gzipped(data)
    try:
        if not path.name.endswith((".tmrec.jsonl", ".tmrec.jsonl.gz")) and other_there(
            path, f'"{FORMAT}"'.encode()
        ):
            raise TrackmarshalError(
                "D120", "is there already, and is no recording", file=str(path), help="nothing was written; another name, such as one that ends in .tmrec.jsonl"
            )  # fmt: skip
        write_whole(path, data)
    except OSError as error:
        message = f"cannot be written: {error.strerror}"
        help_ = "check the path, its permissions and the space left"
        raise TrackmarshalError("D120", message, file=str(path), help=help_) from error


def moved(recording: Recording, declared: Path, path: Path) -> Recording:
    """The recording of a declaration as it is written to a path: what it uses from the declaration's folder is the same from there.

    A name would else lead nowhere, or to another spec. Names that lead nowhere from the declaration's folder are those of the project, and stay.
    """
    near, target = (os.path.realpath(each.parent) for each in (declared, path))
    if near == target:
        return recording

    def named(name: str) -> str:
        if os.path.isabs(name) or "\0" in name:
            return name  # which is refused, wherever it stands
        there = os.path.realpath(os.path.join(near, name))
        return Path(os.path.relpath(there, target)).as_posix() if os.path.isfile(there) else name

    return replace(recording, use=tuple(map(named, recording.use)))


def encode(recording: Recording) -> Iterator[str]:
    """The lines of the file, without line ends."""
    header: dict[str, Any] = {"format": FORMAT, "version": VERSION, "name": recording.name}
    header["track"] = recording.track
    for name in ("params", "tables", "obstacles", "use", "notes", "extra", "judged", "given", "because"):
        value = getattr(recording, name)
        if value:
            header[name] = value
    if recording.always:
        header["signals"] = recording.always
    yield _dump(header)
    for i, cycle in enumerate(recording.cycles):
        line: dict[str, Any] = {
            "t": cycle.t,
            "ego": cycle.ego,
            "objects": cycle.objects,
            "candidates": cycle.candidates,
        }
        if cycle.obstacles is not None:
            line["obstacles"] = cycle.obstacles
        if cycle.more:
            line["signals"] = cycle.more
        if recording.ground_truth:
            line["ground_truth"] = {name: truth[i] for name, truth in recording.ground_truth.items()}
        yield _dump(line)


def _dump(value: Any) -> str:
    try:
        return json.dumps(value, allow_nan=False, separators=(",", ":"))
    except ValueError:
        return json.dumps(_spelt(value), allow_nan=False, separators=(",", ":"))


def _spelt(value: Any) -> Any:
    """The same value with texts for the numbers that JSON does not have."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, dict):
        return {name: _spelt(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_spelt(item) for item in value]
    return value


def decode(data: bytes, shown: str) -> Recording:
    """The bytes of a file (unpacked) to a Recording; raises D126, D130, D140, D141 or D143 with the line."""
    numbered = enumerate(content.text(data, shown).split("\n"), start=1)
    lines = [(i, line) for i, line in numbered if line.strip()]
    faults = Faults()
    header: dict[str, Any] = {}
    cycles: list[Cycle] = []
    truths: list[dict[str, bool | None]] = []
    for number, text in lines:
        try:
            if not header:
                header = _header(_object(text, number, shown), number, shown)
                continue
            cycle, truth = structure.cycle(_object(text, number, shown))
            if cycles and cycle.t <= cycles[-1].t:
                message = f"time {moment(cycle.t)} s does not come after {moment(cycles[-1].t)} s"
                raise _error("D130", message, number, shown, "sort the cycles, take out those given twice")
            if truths and truth.keys() != truths[0].keys():
                raise _error("D141", "ground_truth differs from the first cycle's", number, shown, _SCHEMA)
            cycles.append(cycle)
            truths.append(truth)
        except Wrong as error:
            faults.add(_error("D141", str(error), number, shown, _SCHEMA))
        except TrackmarshalError as error:
            faults.add(error)
        if not header:
            break
    faults.check()
    if not cycles:
        raise _error("D130", "the recording has no cycles", lines[0][0], shown, "was it cut off?")
    truth_columns = {name: tuple(truth[name] for truth in truths) for name in truths[0]}
    return filled(Recording(source=shown, cycles=tuple(cycles), ground_truth=truth_columns, **header))


_SCHEMA = "recording.schema.json says what a line has"


def _error(code: str, message: str, line: int, shown: str, help: str) -> TrackmarshalError:
    return TrackmarshalError(code, message, file=shown, line=line, help=help)


def _object(text: str, number: int, shown: str) -> dict[str, Any]:
    try:
        value = parse(text)
    except BadJson as error:
        raise _error("D140", str(error), number, shown, "every line is one JSON object") from error
    if not isinstance(value, dict):
        raise _error("D140", "the line is not a JSON object", number, shown, "every line is one JSON object")
    return value


def _header(value: dict[str, Any], number: int, shown: str) -> dict[str, Any]:
    """The header's fields, checked, as arguments of Recording."""
    if value.get("format") != FORMAT:
        message = f'the first line has no `"format": "{FORMAT}"`'
        raise _error("D121", message, number, shown, "is this a recording of trackmarshal's own format?")
    version = value.get("version")
    if version != VERSION or type(version) is not int:
        raise _error("D143", f"version {version!r:.40} of the format", number, shown, f"known is {VERSION}")
    return structure.header(value)
