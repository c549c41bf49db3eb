"""How much a column is called like a field of the contract."""

from __future__ import annotations

import re
from difflib import SequenceMatcher

#: Words that stand for a field; the first is its own name.
WORDS: dict[str, tuple[str, ...]] = {
    "x": ("x", "px", "posx", "east", "easting", "xpos"),
    "y": ("y", "py", "posy", "north", "northing", "ypos"),
    "s": ("s", "station", "arc", "arclength", "dist", "distance", "path"),
    "t": ("t", "time", "times", "stamp", "timestamp", "trel", "dt"),
    "heading": ("heading", "psi", "yaw", "theta", "phi", "orientation", "head", "direction", "course", "cog", "hdg"),
    "kappa": ("kappa", "curv", "curvature", "k"),
    "v": ("v", "vel", "velocity", "speed", "vx", "vlong", "kmh", "kph", "mps", "sog"),
    "a": ("a", "acc", "ax", "accel", "acceleration", "along"),
    "length": ("length", "len", "l"),
    "width": ("width", "wid", "w"),
    "age": ("age", "delay", "latency"),
    "id": ("id", "name", "uuid", "track", "mmsi"),
    "left": ("left", "l", "inner", "bound", "boundl"),
    "right": ("right", "r", "outer", "bound", "boundr"),
    "ego": ("ego", "pose", "car", "state", "vehicle", "self", "localisation", "localization", "odometry"),
    "driving": ("driving", "drive", "nominal", "performance", "plan", "trajectory", "traj", "planned", "straight"),
    "emergency": ("emergency", "em", "emerg", "fallback", "stop", "safe", "brake", "braking"),
    "objects": ("objects", "object", "obj", "others", "opponents", "vehicles", "agents", "cars", "dynamic"),
    "obstacles": ("obstacles", "obstacle", "static", "barriers"),
}  # fmt: skip
#: Words that say a unit: the field is in the others.
_UNITS = {
    "m",
    "mps",
    "ms",
    "rad",
    "deg",
    "kmh",
    "kph",
    "kn",
    "kts",
    "mps2",
    "mss",
    "radpm",
    "1pm",
    "radm",
    "sec",
    "ns",
    "us",
}


def likeness(name: str, field: str) -> float:
    """From 0 to 1: 1 where it is the field's own name, or another word for it."""
    words = WORDS[field]
    parts = [
        part for part in re.split(r"[^a-z0-9]+", re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower()) if part
    ]
    joined = "".join(part for part in parts if part not in _UNITS or len(parts) == 1)
    if name.lower() in words or joined in words:
        return 1.0
    if any(part in words for part in parts if part not in _UNITS or len(parts) == 1):
        return 0.8
    best = max((SequenceMatcher(None, joined, word).ratio() for word in words if len(word) > 2), default=0.0)
    return 0.6 * best if best > 0.7 else 0.0
