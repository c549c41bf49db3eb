"""A baseline of specs of which one cannot be read: what it does not say would not even be missed."""

from __future__ import annotations

from pathlib import Path

from support.project import run_command


def test_no_baseline_is_accepted_while_a_spec_cannot_be_read(tmp_path: Path) -> None:
    car = tmp_path / "car"
    assert run_command("init", str(car), "--quiet")[0] == 0
    baseline = car / "requirements" / "baseline.json"
    before = baseline.read_bytes()
    (car / "specs" / "broken.spec").write_text('module broken\n\nrule x "y"\n  requier 1 > 0\n', "utf-8")
    status, out, err = run_command("trace", "--project", str(car), "--gate")
    assert status == 1
    assert "T375" not in out + err  # the files that the scenario names are what they were
    status, _, err = run_command(
        "trace", "--project", str(car), "--accept-baseline", "--by", "Ann", "--reason", "as the help says"
    )
    assert (status, baseline.read_bytes()) == (2, before)
    assert "error[E107]: a spec cannot be read, so that no baseline is accepted" in err
