"""Where `eval` says that something is wrong with a line of data."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.cli.main import main

SPEC = """module m
signal ego : state { v: m/s }
rule steady "" require not (ego.v < 1 m/s and once[0 s, 1 s] ego.v > 2 m/s)
"""


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_a_line_without_an_id_is_called_by_its_number(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], backend: str
) -> None:
    (tmp_path / "m.spec").write_text(SPEC, "utf-8")
    cycle = '{{"t": {}, "signals": {{"ego": {{"v": 3}}}}{}\n'
    lines = cycle.format(0, "}") + "\n" + cycle.format(0, "}") + cycle.format(1, "")
    (tmp_path / "run.jsonl").write_text(lines, "utf-8")
    data = str(tmp_path / "run.jsonl")
    assert main(["eval", str(tmp_path / "m.spec"), "--data", data, "--run", "--backend", backend]) == 2
    said = capsys.readouterr().out
    assert "case 1: safe" in said
    assert (
        f"case 3: error[D206]: the cycle stamp 0.0 s does not come after the one before\n  --> {data}:3\n"
        in said
    )
    assert f"in column {len(cycle.format(1, ''))}\n  --> {data}:4\n" in said
