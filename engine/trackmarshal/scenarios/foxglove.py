"""A run's record as an MCAP file, so that Foxglove shows it: decisions and cycles as JSON, and the scene in its own terms.

Topics: `/decision` (everything that the record has, as it has it), `/cycle` (the same, of what passes the door when it is run again), `/scene`
(foxglove.SceneUpdate: what is driven; borders, both candidates, the car and the objects, of what passes it: in SI units, whatever the record keeps). Needs the package `mcap`, which is imported when this is called.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import other_there
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.lines import Line
from trackmarshal.runtime.record.decided import decided_by_name
from trackmarshal.runtime.record.raw import Opaque
from trackmarshal.runtime.record.reading import Recorded, Run

FRAME = "map"
_LIBRARY = "trackmarshal"
#: How a file of ours begins: the header has its size, no profile, and who wrote it. A log of the vehicle is MCAP too.
_OWN = b"\x89MCAP0\r\n\x01" + struct.pack("<QII", 8 + len(_LIBRARY), 0, len(_LIBRARY)) + _LIBRARY.encode()
_GREY, _GREEN, _ORANGE, _RED, _BLUE = (
    (0.6, 0.6, 0.6), (0.1, 0.7, 0.2), (1.0, 0.6, 0.0), (0.9, 0.1, 0.1), (0.2, 0.4, 0.9),
)  # fmt: skip
#: Size of the car where its parameters do not say, m.
_LENGTH, _WIDTH = 4.7, 2.0
_POSE = ("x", "y", "heading")
_OBJECT = {"type": "object"}


def write(run: Run, decisions: Iterable[Decision], path: str | Path) -> None:
    """Write a record, with scenes by what its cycles came to when they were run again. Raises E484 without the package, D120 where the file cannot be written or something else is there."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        message = "MCAP needs the package `mcap`"
        raise TrackmarshalError("E484", message, help="pip install trackmarshal[mcap]") from error
    try:
        if other_there(Path(path), _OWN):
            raise TrackmarshalError(
                "D120", "is there already, and is no MCAP of a record", file=str(path), help="nothing was written; another name, such as run.mcap"
            )  # fmt: skip
        with Path(path).open("wb") as file:
            writer: Any = Writer(file)
            writer.start(library=_LIBRARY)
            writer.add_metadata("trackmarshal", {"identity": json.dumps(run.identity)})
            channels = {topic: _channel(writer, topic, name) for topic, name in _TOPICS.items()}
            for number, (recorded, decision) in enumerate(zip(run.cycles, decisions)):
                at = _nanoseconds(recorded.readings[0])
                for topic, message in _messages(run, recorded, decision).items():
                    data = json.dumps(message, allow_nan=False).encode()
                    writer.add_message(channels[topic], at, data, at, number)
            writer.finish()
    except OSError as error:
        raise TrackmarshalError(
            "D120", f"cannot be written: {error.strerror}", file=str(path), help="check the path"
        ) from error


_TOPICS = {
    "/decision": "trackmarshal.Decision",
    "/cycle": "trackmarshal.Cycle",
    "/scene": "foxglove.SceneUpdate",
}


def _channel(writer: Any, topic: str, name: str) -> int:
    schema = writer.register_schema(name, "jsonschema", json.dumps({"title": name, **_OBJECT}).encode())
    channel: int = writer.register_channel(topic, "json", schema)
    return channel


def _messages(run: Run, recorded: Recorded, decision: Decision) -> dict[str, Any]:
    stamp = _stamp(recorded.readings[0])
    messages = {"/decision": {"timestamp": stamp, "t": _spelt(decision.t), **_spelt(recorded.by_name)}}
    cycle, entities = recorded.cycle, [_driven(recorded, decision, stamp)]
    if type(cycle) is Cycle and decision.judged is not None and not decision.faults:
        messages["/cycle"] = _spelt({
            "timestamp": stamp, "number": cycle.number, DRIVING: cycle.driving, EMERGENCY: cycle.emergency, **cycle.signals
        })  # fmt: skip
        entities += _entities(run, decision.judged.about, stamp)
    return {**messages, "/scene": {"deletions": [], "entities": entities}}


def _driven(recorded: Recorded, decision: Decision, stamp: Mapping[str, int]) -> dict[str, Any]:
    """What is driven, in every cycle: what was drawn in the one before goes only where something stands in its place. Nothing where the replay drives
    something else than was driven in the run, as by another spec, or where an error has not come again."""
    given, again = recorded.by_name, decided_by_name(decision)
    same = all(
        str(given[name]) == str(again[name]) for name in ("safe", "driven", "driven_number", "driven_t")
    )
    samples = decision.samples if same else None
    if samples is None:
        return _entity("driven", stamp)
    colour = _GREEN if decision.safe else _RED
    return _entity("driven", stamp, lines=[_line(zip(samples["x"], samples["y"]), colour, 0.5)])


def _entities(run: Run, frame: Frame, stamp: Mapping[str, int]) -> Iterable[dict[str, Any]]:
    borders = [line.points.tolist() for (signal, _), line in frame.lines.items() if signal == "track"]
    yield _entity("track", stamp, lines=[_line(points, _GREY, 0.15) for points in borders])
    for name, colour in ((DRIVING, _BLUE), (EMERGENCY, _ORANGE)):
        plan = frame.candidates[name]
        yield _entity(name, stamp, lines=[_line(zip(plan.listed("x"), plan.listed("y")), colour, 0.2)])
    size = {n: run.identity.get("params", {}).get(n, d) for n, d in (("length", _LENGTH), ("width", _WIDTH))}
    yield _entity(
        "ego", stamp, cubes=[_box({**size, **each}, _BLUE) for each in _records(frame, "ego", _POSE)]
    )
    for signal, colour in (("objects", _RED), ("obstacles", _GREY)):
        found = _records(frame, signal, (*_POSE, "length", "width"))
        yield _entity(signal, stamp, cubes=[_box(each, colour) for each in found])


def _records(frame: Frame, signal: str, fields: tuple[str, ...]) -> Iterable[dict[str, float]]:
    """The entries of a signal of which all these fields are known: whatever else there is has no place in a scene."""
    columns = frame.columns.get(signal)
    if columns is None or not set(fields) <= set(columns.names.numbers):
        return
    for values in zip(*map(columns.listed, fields)):
        if all(map(math.isfinite, values)):
            yield dict(zip(fields, values))


def _entity(name: str, stamp: Mapping[str, int], **parts: Any) -> dict[str, Any]:
    return {
        "timestamp": stamp, "frame_id": FRAME, "id": name, "lifetime": {"sec": 0, "nsec": 0}, "frame_locked": True, "metadata": [],
        **{kind: parts.get(kind, []) for kind in ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")},
    }  # fmt: skip


def _line(points: Iterable[Any], colour: tuple[float, ...], thickness: float) -> dict[str, Any]:
    return {
        "type": 0, "pose": _pose(0.0, 0.0, 0.0), "thickness": thickness, "scale_invariant": False,
        "points": [{"x": float(x), "y": float(y), "z": 0.0} for x, y in points], "color": _colour(colour), "colors": [], "indices": [],
    }  # fmt: skip


def _box(record: Mapping[str, float], colour: tuple[float, ...]) -> dict[str, Any]:
    return {
        "pose": _pose(record["x"], record["y"], record["heading"]),
        "size": {"x": record["length"], "y": record["width"], "z": 1.2}, "color": _colour(colour),
    }  # fmt: skip


def _pose(x: float, y: float, heading: float) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}
    return {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}


def _colour(colour: tuple[float, ...]) -> dict[str, float]:
    return dict(zip("rgba", (*colour, 1.0)))


def _nanoseconds(reading: float) -> int:
    return max(0, round(reading * 1e9)) if math.isfinite(reading) else 0


def _stamp(reading: float) -> dict[str, int]:
    seconds, rest = divmod(_nanoseconds(reading), 10**9)
    return {"sec": seconds, "nsec": rest}


def _spelt(value: Any) -> Any:
    """Strict JSON: arrays and borders as lists, numbers that are not finite as words; of what no format has a word for, what it was."""
    if isinstance(value, Line):
        value = value.points
    if isinstance(value, Opaque):
        return value.kind
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(name): _spelt(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_spelt(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
