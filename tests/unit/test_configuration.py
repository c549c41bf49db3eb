"""Another vehicle is another file: configuration modules replace values of the same name, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.project import command
from support.shared import REPOSITORY
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import load

SPEC = """module rules
signal plan : series { t: s increasing, v: m/s }
param v_max : m/s = 50 m/s in [0, 100]
table limit(v: m/s) -> m/s^2 = linear clamp | 0 m/s: 5 m/s^2 |
rule slow for all p in plan require p.v <= v_max
"""


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "rules.spec"
    path.write_text(SPEC, encoding="utf-8")
    return path


def configured(spec: Path, text: str) -> float:
    settings = spec.with_name("vehicle.spec")
    settings.write_text("module vehicle\n" + text, encoding="utf-8")
    return load(spec, [settings]).params["rules.v_max"].value


def test_values_are_replaced_in_si_and_ranges_stay(spec: Path) -> None:
    assert configured(spec, "param v_max : km/h = 36 km/h\n") == 10.0
    assert load(spec).params["rules.v_max"].value == 50.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("param v_mx : m/s = 1 m/s\n", "declares no parameter `v_mx`"),
        ("param v_max : m = 1 m\n", "is in m, the spec declares it in m/s"),
        ("param v_max : m/s = 101 m/s\n", "outside the range"),
        ("table limit(v: m) -> m/s^2 = linear clamp | 0 m: 5 m/s^2 |\n", "other units"),
        ("zone pits = polygon (0 m, 0 m) (1 m, 0 m) (0 m, 1 m)\n", "declares no place `pits`"),
    ],
)
def test_what_does_not_fit_is_refused(spec: Path, text: str, said: str) -> None:
    with pytest.raises(TrackmarshalError, match="E402") as caught:
        configured(spec, text)
    assert said in caught.value.message


def test_a_configuration_changes_the_fingerprint(spec: Path) -> None:
    settings = spec.with_name("vehicle.spec")
    settings.write_text("module vehicle\nparam v_max : m/s = 49 m/s\n", encoding="utf-8")
    assert load(spec, [settings]).fingerprint != load(spec).fingerprint


def test_the_command_line_counts_more_than_the_recording() -> None:
    """The recording is of a car with more grip than the compact one."""
    recording = str(REPOSITORY / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    plain = command(REPOSITORY, "replay", recording)[1]
    compact = command(
        REPOSITORY, "replay", recording, "--with", str(REPOSITORY / "specs" / "vehicles" / "compact.spec")
    )[1]
    assert "friction" not in plain
    assert "friction" in compact
