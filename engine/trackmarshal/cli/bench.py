"""The benchmarks of the project: median CPU times, with the limit that each must stay under and the ratio to it.

A benchmark is a module tests/benchmarks/bench_*.py with `measure() -> dict[str, float]` (seconds, bytes for names that end
in "memory" or "size", plain numbers for those that end in "(ratio)") and, for the names it promises something about, `LIMITS`.
"""

from __future__ import annotations

import argparse
import importlib.util
import platform
import sys
from pathlib import Path
from types import ModuleType

from trackmarshal.cli.output import dump, number, say, table
from trackmarshal.cli.project import find_project
from trackmarshal.errors import TrackmarshalError

CODES = {
    "E461": (
        "no benchmarks",
        "`bench` runs the modules tests/benchmarks/bench_*.py of the project; this one has none of that name.",
    ),
}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="only these: `temporal` for bench_temporal.py (default: all)"
    )
    parser.add_argument("--format", choices=("text", "json"), default="text")


def run(args: argparse.Namespace) -> int:
    folder = find_project(args) / "tests" / "benchmarks"
    files = sorted(folder.glob("bench_*.py"))
    known = {file.stem.removeprefix("bench_"): file for file in files}
    lacking = [name for name in args.names if name not in known]
    if lacking or not files:
        raise TrackmarshalError(
            "E461",
            f"no benchmark{''.join(f' {name}' for name in lacking)} in {folder}",
            help=", ".join(known)
            or "write a module bench_NAME.py there, with `measure()`: `trackmarshal bench --help`",
        )
    if args.names:
        files = [file for name, file in known.items() if name in args.names]
    rows = []
    for file in files:
        if not args.quiet:
            print(f"{file.stem} ...", file=sys.stderr)
        module = _load(file)
        limits: dict[str, float] = getattr(module, "LIMITS", {})
        for name, value in module.measure().items():
            rows.append((name, float(value), limits.get(name)))
    if args.format == "json":
        results = [
            {
                "name": n,
                "value": number(v),
                "unit": _unit(n),
                "limit": None if limit is None else number(limit),
            }
            for n, v, limit in rows
        ]
        print(dump({"machine": _machine(), "results": results}))
    else:
        shown = [
            [
                n,
                _figure(n, v),
                "" if limit is None else _figure(n, limit),
                "" if limit is None else f"{v / limit:.2f}",
            ]
            for n, v, limit in rows
        ]
        say(_machine(), *table(shown, ["benchmark", "median", "limit", "ratio"]))
    return 1 if any(limit is not None and value > limit for _, value, limit in rows) else 0


def _load(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    if str(file.parent) not in sys.path:  # benchmarks may share what they measure with
        sys.path.append(str(file.parent))
    spec.loader.exec_module(module)
    return module


def _unit(name: str) -> str:
    return "bytes" if name.endswith(("memory", "size")) else "1" if name.endswith("(ratio)") else "s"


def _figure(name: str, value: float) -> str:
    if _unit(name) == "1":
        return f"{value:.2f}"
    if _unit(name) == "bytes":
        return f"{value / 1e6:.0f} MB"
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if abs(value) >= factor:
            return f"{value / factor:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def _machine() -> str:
    """What the figures were measured on."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        names = [
            line.partition(":")[2].strip()
            for line in info.read_text().splitlines()
            if line.startswith("model name")
        ]
        model = names[0] if names else model
    return f"{model}, Python {platform.python_version()}, {platform.system()}"
