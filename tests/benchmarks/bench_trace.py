"""`trace` on 10,000 items with 22,500 links, a third of them rules and tests, and its matrix page; and 10,000 requirements read from YAML. CPU
seconds, memory of the command, and size of the page."""

from __future__ import annotations

import json
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from measuring import command

MIXED = "trace --as-is, 10,000 items with 22,500 links"
MEMORY = f"{MIXED}: memory"
PAGE = f"{MIXED}, as the matrix page"
SIZE = f"{PAGE}: size"
READ = "10,000 requirements read"
LIMITS = {MIXED: 2.5, MEMORY: 150e6, PAGE: 4.0, SIZE: 9.5e6, READ: 1.3}
_READ = """
import sys, time
from pathlib import Path
from trackmarshal.trace import requirements
start, found = time.process_time(), []
assert len(requirements.load(Path(sys.argv[1]), found).requirements) == 10_000 and not found
print(time.process_time() - start)
"""


def measure() -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        mixed, alone = Path(folder) / "mixed", Path(folder) / "alone"
        project(mixed, 6667, 1667)
        project(alone, 10_000, 0)
        trace = ["trace", "--project", str(mixed)]
        command(*trace)  # runs the tests
        runs = [command(*trace, "--as-is") for _ in range(5)]
        file = Path(folder) / "page.html"
        page = [*trace, "--as-is", "--format", "html"]
        command(*page, out=file)  # keeps what rules look like
        size = file.stat().st_size
        pages = [command(*page) for _ in range(5)]
        read = [sys.executable, "-c", _READ, str(alone)]
        seconds = [
            float(subprocess.run(read, check=True, capture_output=True, text=True).stdout) for _ in range(5)
        ]
    return {
        MIXED: statistics.median(cpu for cpu, _ in runs),
        MEMORY: max(memory for _, memory in runs),
        PAGE: statistics.median(cpu for cpu, _ in pages),
        SIZE: size,
        READ: statistics.median(seconds),
    }


def project(root: Path, number: int, rules: int) -> None:
    """Requirements in a hierarchy, each of which refines two; the last of them have a rule each, which satisfies more, with a test."""
    chosen = random.Random(1)
    (root / "requirements").mkdir(parents=True)
    (root / "specs").mkdir()
    lines = ["document: requirements", "title: many", "requirements:"]
    for n in range(number):
        above = sorted({chosen.randrange(max(0, n // 4 - 40), n // 4 + 1) for _ in range(2)})
        parents = f"refines: [{', '.join(f'R-{p}' for p in above)}]" if n >= 10 else "derived_from: [AV]"
        lines += [
            f"  - id: R-{n}", f"    title: Requirement number {n}",
            f"    statement: In case {n} the vehicle shall stay within its limits, whatever the others do.",
            "    rationale: Because something could happen otherwise, and nobody would know.", f"    {parents}",
            "    status: approved", "    asil: D", "    verification: [test]",
            *([f"    metrics: [rule_{n - number + rules}]"] if n >= number - rules else []), "    source: a book, section 3.1",
        ]  # fmt: skip
    (root / "requirements" / "all.yaml").write_text("\n".join(lines) + "\n", "utf-8")
    leads = [f"R-{n}" for n in range(10)]
    model = {
        "document": "system-model", "title": "t", "subsystems": [{"id": "AV", "title": "t", "role": "vehicle", "description": "d"}],
        "interfaces": [{"id": "AV", "title": "t", "issues": [{"id": "AV.1", "text": "t", "leads_to": leads}]}],
    }  # fmt: skip
    stage = {"title": "t", "shows": "s", "applies_to": ["*"]}
    v_model = {
        "document": "v-model", "title": "t",
        "project": {"name": "many", "specs": ["specs"], "default_spec": "specs",
                    "tests_per_rule": {"satisfied": 1, "violated": 0, "boundary": 0}},
        "stages": [{"id": "S-1-A", "counts": ["interface", "parent"], **stage}, {"id": "S-2-B", "counts": ["rule"], **stage},
                   {"id": "S-3-B", "counts": ["test"], **stage}],
    }  # fmt: skip
    for name, data in (("model.yaml", model), ("v-model.yaml", v_model)):
        (root / "requirements" / name).write_text(json.dumps(data), "utf-8")
    spec = ["module many", "", "signal ego : state { v: m/s }", ""]
    for n in range(rules):
        ids = dict.fromkeys([number - rules + n, *(chosen.randrange(number) for _ in range(2))])
        spec += [f'rule rule_{n} "Speed in case {n}"', f"  satisfies {', '.join(f'R-{k}' for k in ids)}", f"  require ego.v <= {n + 1} m/s", "",
                 f'test rule_{n} "below"', "  given  ego = { v: 0 m/s }", "  expect satisfied", ""]  # fmt: skip
    (root / "specs" / "many.spec").write_text("\n".join(spec), "utf-8")
