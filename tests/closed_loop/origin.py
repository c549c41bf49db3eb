"""What results were made from, as hashes: a change of any of it makes them stale."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path

import trackmarshal as tm
from closed_loop import places
from closed_loop.supervising import LIMITS

#: Of this folder, what reads results and makes none.
READERS = ("report.py", "campaign.py")


def sha256(paths: Iterable[Path]) -> str:
    """Of files in the order of their names, names included."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def origins() -> dict[str, str]:
    """Hash by what it is of. Raises OSError where something is not here."""
    here = places.HERE
    loop = [
        path for path in here.glob("*.py") if path.name not in READERS and not path.name.startswith("test_")
    ]
    spec = tm.load([places.RULES], [places.CAR_SPEC, places.TRACK_SPEC])
    engine = places.REPOSITORY / "engine" / "trackmarshal"
    supervisor = [
        path
        for room in ("runtime", "backends/c", "ir", "semantics")
        for path in (engine / room).rglob("*")
        if path.suffix in (".py", ".c", ".h", ".j2")
    ]
    return {
        "loop": sha256(loop),
        "planner": sha256([*(here / "planner").glob("*.py"), here / "planner" / "requirements.txt"]),
        "planner configuration": sha256(places.PARAMS.glob("*.ini")),
        "race lines": sha256(map(places.race_line, places.TRACKS)),
        "rules": spec.fingerprint,
        "limits": hashlib.sha256(json.dumps(dict(LIMITS), sort_keys=True).encode()).hexdigest(),
        "supervisor": sha256(supervisor),
    }


def alike(origin: dict[str, str]) -> dict[str, str]:
    """What has to be the same for results to be those of the same question: all but the Supervisor's own source.

    Whether that still comes to the same results, the declared runs show: they are run again, and compared.
    """
    return {what: value for what, value in origin.items() if what != "supervisor"}


def key(origin: dict[str, str]) -> str:
    """One short name for all of it."""
    return hashlib.sha256(json.dumps(origin, sort_keys=True).encode()).hexdigest()[:12]
