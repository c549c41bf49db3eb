"""Whole commands from process start: CPU seconds of the child, and its peak memory."""

from __future__ import annotations

import gzip
import json
import statistics
import tempfile
from pathlib import Path

from measuring import command

ROOT = Path(__file__).resolve().parents[2]
RECORDED = ROOT.parent / "shared" / "data" / "scenarios" / "modena_T1_cutin_collision.saa"
SHIPPED = ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl"

COLD = "check of the Supervisor's specs, empty cache"
WARM = "check of the Supervisor's specs"

LONG = "replay of ten minutes at 20 Hz"
#: Scenarios in which rules of racing remember much, and what state machines keep is asked for.
RACING = {
    name: f"replay of ten minutes at 20 Hz, racing rules beside the Supervisor's: {name}"
    for name in ("squeezed", "yellow_flag")
}

LIMITS = {
    COLD: 0.6,
    WARM: 0.30,
    "check of the shipped specs": 0.35,
    "check of 10,000 lines": 3.0,
    "check of 10,000 lines: peak memory": 200e6,
    "replay of a recording": 2.0,
    LONG: 10.0,
    **dict.fromkeys(RACING.values(), 10.0),
}


def long_spec(lines: int) -> str:
    """A spec of many rules, each different."""
    head = "module long\nsignal plan : trajectory { t: s increasing, x: m, y: m, v: m/s, a: m/s^2, kappa: 1/m }\n"
    rules: list[str] = []
    while 5 * len(rules) + 2 < lines:
        n = len(rules)
        rules.append(
            f'rule limit_{n} "Limit number {n}"\n  because "a rule of many"\n  for all p in plan where p.x >= {n} m\n'
            f"  let demand = sqrt(p.a^2 + (p.v^2 * p.kappa)^2)\n  require demand <= {10 + n / 1000} m/s^2 and p.v < {n % 80 + 1} m/s\n"
        )
    return head + "".join(rules)


def long_recording(cycles: int, path: Path = SHIPPED) -> str:
    """A shipped recording there and back again, so that nothing jumps, without its ground truth."""
    data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    head, *lines = data.decode().splitlines()
    header = json.loads(head)
    header["use"] = [str((path.parent / name).resolve().relative_to(ROOT)) for name in header["use"]]
    known = [json.loads(line) for line in lines]
    there_and_back = known + known[::-1]
    made = [json.dumps(header)]
    for number in range(cycles):
        cycle = there_and_back[number % len(there_and_back)] | {"t": round(number * 0.05, 6)}
        cycle.pop("ground_truth", None)
        made.append(json.dumps(cycle))
    return "\n".join(made)


def measure() -> dict[str, float]:
    """Medians of five runs, after one that fills the caches."""
    recording = RECORDED if RECORDED.exists() else SHIPPED
    results: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.spec"
        path.write_text(long_spec(10_000))
        commands = {
            "check of the shipped specs": ("check", "--quiet"),
            "check of 10,000 lines": ("check", "--quiet", str(path)),
            "replay of a recording": ("replay", "--quiet", str(recording)),
        }
        supervisor = ("check", "--quiet", "specs/supervisor")
        command(*supervisor)
        cold, warm = [], []
        for number in range(7):  # in turns, so that a slow spell of the machine falls on both
            cold.append(command(*supervisor, cache=str(Path(folder) / f"empty-{number}"))[0])
            warm.append(command(*supervisor)[0])
        results |= {COLD: statistics.median(cold), WARM: statistics.median(warm)}
        for name, arguments in commands.items():
            command(*arguments)
            runs = [command(*arguments) for _ in range(5)]
            results[name] = statistics.median(seconds for seconds, _ in runs)
            if name == "check of 10,000 lines":
                results[f"{name}: peak memory"] = statistics.median(memory for _, memory in runs)
        long = Path(folder) / "long.tmrec.jsonl"
        long.write_text(long_recording(12_000))
        results[LONG] = command("replay", "--quiet", str(long))[0]
        for name, shown in RACING.items():
            shipped = ROOT / "specs" / "scenarios" / "racing" / f"{name}.tmrec.jsonl.gz"
            long.write_text(long_recording(12_000, shipped))
            results[shown] = command("replay", "--quiet", "--spec", "specs/rulebooks", str(long))[0]
    return results
