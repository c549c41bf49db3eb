"""A cycle of a recording may lack either candidate: the other one is judged, and what needs the missing one is undefined."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from support.length import at_length
from support.project import run_command
from support.shared import REPOSITORY
from trackmarshal.backends.c.build import compiler

SHIPPED = REPOSITORY / "specs" / "scenarios" / "late_brakes.tmrec.jsonl.gz"
BACKENDS = ["numpy", at_length("reference"), *(["c"] if compiler() else [])]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("gone", ["driving", "emergency"])
@pytest.mark.parametrize("spec", ["specs/supervisor", at_length("specs/fallback")])
def test_the_other_one_is_judged(
    spec: str, gone: str, backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if (spec, backend) == ("specs/supervisor", "reference"):
        pytest.skip("it takes seconds, and says of `specs/fallback` how it takes what is missing")
    monkeypatch.chdir(REPOSITORY)
    head, *cycles = gzip.decompress(SHIPPED.read_bytes()).decode().splitlines()[:4]
    header, lost = json.loads(head), json.loads(cycles[1])
    header["use"] = []
    del lost["candidates"][gone]
    path = tmp_path / "lost.tmrec.jsonl"
    path.write_text("\n".join([json.dumps(header), cycles[0], json.dumps(lost), cycles[2]]) + "\n")
    arguments: tuple[str, ...] = ("--spec", spec, "--backend", backend)
    if spec == "specs/supervisor":
        arguments = (*arguments, "--with", "specs/tracks/northfield.spec")
    status, out, err = run_command("replay", str(path), *arguments, "--format", "jsonl", "--exit-zero")
    assert status == 0, err
    found = [json.loads(line) for line in out.splitlines() if '"candidate"' in line]
    at = [line for line in found if line["t"] == lost["t"]]
    other = "emergency" if gone == "driving" else "driving"
    assert [line["candidate"] for line in at] == [other]
    verdicts = {name: rule["verdict"] for name, rule in at[0]["rules"].items()}
    if spec == "specs/supervisor":
        assert verdicts["friction"] == "satisfied"
    elif gone == "driving":
        assert verdicts["takeup_pose"] == "undefined"
