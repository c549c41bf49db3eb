"""Names in recordings: a misspelt one is refused with a suggestion, one that is declared somewhere and read nowhere is fine."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.project import run_command
from support.shared import REPOSITORY, shared
from support.supervised import shipped
from trackmarshal import scenarios
from trackmarshal.cli import operating
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import load
from trackmarshal.scenarios import recording_io
from trackmarshal.scenarios.fields import check_fields

SPEC = """module small
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s, delta: rad default 0 rad }
signal objects : set of object { x: m, v: m/s, age: s default 0 s }
table drag_max(v: m/s) -> m/s^2 = linear clamp | 0 m/s: 5 m/s^2 |
rule fast "Not too fast"
  for all p in plan
  require p.v <= 100 m/s
rule fresh "Fresh"
  for all o in objects
  require o.age <= 1 s
"""
OTHER = "module other\nsignal ego : state { x: m, omega: 1/s }\nrule odd require ego.omega <= 1 1/s\n"
V_MODEL = "document: v-model\ntitle: small\nproject:\n  name: small\n  specs: [specs]\n  default_spec: specs/small.spec\n"
PLAN = {
    "t": [0.0, 1.0],
    "x": [0.0, 9.0],
    "y": [0.0] * 2,
    "heading": [0.0] * 2,
    "kappa": [0.0] * 2,
    "v": [9.0, 0.0],
    "a": [0.0] * 2,
}
Lines = list[dict[str, Any]]


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("requirements", "specs"):
        (tmp_path / folder).mkdir()
    (tmp_path / "requirements" / "v-model.yaml").write_text(V_MODEL)
    (tmp_path / "specs" / "small.spec").write_text(SPEC)
    (tmp_path / "specs" / "other.spec").write_text(OTHER)
    monkeypatch.chdir(tmp_path)


def good() -> Lines:
    head = {
        "format": "trackmarshal-recording",
        "version": 1,
        "name": "made",
        "track": {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]},
    }
    other = {"id": "o", "x": 50.0, "y": 0.0, "heading": 0.0, "v": 0.0, "length": 4.0, "width": 2.0}
    cycles = [
        {
            "t": 0.1 * i,
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 9.0},
            "objects": [dict(other)],
            "candidates": {"driving": dict(PLAN), "emergency": dict(PLAN)},
        }
        for i in range(3)
    ]
    found: list[dict[str, Any]] = json.loads(
        json.dumps([{**head, "obstacles": [{k: v for k, v in other.items() if k != "v"}]}, *cycles])
    )
    return found


def replay(lines: Lines) -> tuple[int, str]:
    Path("run.tmrec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    status, out, err = run_command("replay", "run.tmrec.jsonl", "--spec", "specs/small.spec")
    return status, out + err


def put(*path: Any, value: Any) -> Callable[[Lines], None]:
    def change(lines: Lines) -> None:
        place: Any = lines
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value

    return change


MISSPELT = [
    (put(0, "PARAMS", value={}), "D141", "PARAMS", "did you mean `params`?"),
    (put(0, "data", value={}), "D141", "data", "known are "),
    (put(0, "zzz", value=1), "D141", "zzz", "known are "),
    (put(0, "track", "Closed", value=True), "D141", "Closed", "did you mean `closed`?"),
    (put(0, "extra", value={"Ego": ["x"]}), "D141", "Ego", "did you mean `ego`?"),
    (put(0, "extra", value={"ego": "x"}), "D141", "extra.ego", "list"),
    (put(0, "tables", value={"Ax_max": [[0, 1]]}), "D145", "Ax_max", "did you mean `ax_max`?"),
    (put(0, "tables", value={"drag_mx": [[0, 1]]}), "D145", "drag_mx", "did you mean `drag_max` or"),
    (put(0, "obstacles", 0, "Width", value=1.0), "D145", "Width", "did you mean `width`?"),
    (put(2, "Objects", value=[]), "D141", "Objects", "did you mean `objects`?"),
    (put(2, "zzz", value=1), "D141", "zzz", "known are "),
    (put(2, "ground_truth", value={"Dynamic": True}), "D141", "Dynamic", "did you mean `dynamic`?"),
    (put(2, "candidates", "Driving", value=PLAN), "D141", "Driving", "did you mean `driving`?"),
    (put(2, "ego", "Age", value=9), "D145", "Age", "did you mean `age`?"),
    (put(2, "ego", "zzz", value=9), "D145", "zzz", '"extra": {"ego": ["zzz"]}'),
    (put(2, "objects", 0, "agee", value=9), "D145", "agee", "did you mean `age`?"),
    (put(2, "objects", 0, "AGE", value=9), "D145", "AGE", "did you mean `age`?"),
    (put(3, "candidates", "emergency", "V", value=[1.0, 1.0]), "D145", "`V`", "did you mean `v`?"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "code", "name", "hint"), MISSPELT, ids=[case[2] + case[1] for case in MISSPELT]
)
def test_a_name_that_nobody_declares_is_refused(
    change: Callable[[Lines], None], code: str, name: str, hint: str
) -> None:
    lines = good()
    assert replay(lines)[0] == 0
    change(lines)
    status, text = replay(lines)
    assert status == 2
    assert f"error[{code}]" in text
    assert name in text
    assert hint in text


DECLARED = [
    put(2, "ego", "age", value=0.1),  # by the format
    put(2, "ego", "delta", value=0.1),  # by the spec, read by no rule
    put(2, "ego", "omega", value=0.1),  # by another spec of the project
    put(0, "tables", value={"ax_max": [[0, 1]], "grip": [[0, 1]]}),
]


@pytest.mark.parametrize("change", DECLARED)
def test_what_is_declared_and_not_read_is_fine(change: Callable[[Lines], None]) -> None:
    lines = good()
    change(lines)
    assert replay(lines)[0] == 0


def test_what_another_spec_declares_is_known_to_a_supervisor_in_c_too() -> None:
    """`replay` took such cycles, and the example in C refused them all (`unknown`)."""
    lines = good()
    put(2, "ego", "omega", value=0.1)(lines)
    assert replay(lines)[0] == 0
    words = ("compile", "specs/small.spec", "--cycles", "run.tmrec.jsonl", "--out", "c")
    status, out, err = run_command(*words)
    assert status == 0, out + err
    assert "unknown" not in Path("c/run.cycles").read_text("utf-8")
    put(2, "ego", "omegaa", value=0.1)(lines)
    Path("run.tmrec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    run_command(*words)
    assert "unknown ego omegaa" in Path("c/run.cycles").read_text("utf-8")


def test_the_header_declares_what_no_spec_does() -> None:
    lines = good()
    lines[0]["extra"] = {
        "ego": ["steering"],
        "objects": ["colour"],
        "plan": ["share"],
        "obstacles": ["kind"],
        "tables": ["tyres"],
    }
    lines[0]["tables"] = {"tyres": [[0, 1]]}
    lines[0]["obstacles"][0]["kind"] = 3
    lines[2]["ego"]["steering"] = 0.1
    lines[2]["objects"][0]["colour"] = 7
    lines[2]["candidates"]["driving"]["share"] = [1.0, 1.0]
    status, text = replay(lines)
    assert status == 0, text
    made = scenarios.load("run.tmrec.jsonl")
    assert made.cycles[1].ego["steering"] == 0.1  # passed on as it is
    assert made.signals(made.cycles[1], "driving")["objects"][0]["colour"] == 7
    again = recording_io.decode("\n".join(recording_io.encode(made)).encode(), "x")
    assert again == made
    assert again.extra == made.extra
    lines[2]["objects"][0]["steering"] = 0.1  # declared for another signal
    assert "error[D145]" in replay(lines)[1]


@pytest.mark.parametrize(
    "parts",
    [
        *(
            ("data", "planner", f"{name}.tmrec.jsonl.gz")
            for name in ("berlin", "berlin_cars", "modena", "modena_cars")
        ),
        *(
            ("data", "scenarios", f"modena_T1_{name}.saa")
            for name in ("cutin_collision", "infeasible", "valid")
        ),
    ],
    ids=lambda parts: parts[-1],
)
def test_shared_recordings_say_nothing_unknown(parts: tuple[str, ...]) -> None:
    recording = scenarios.load(shared(*parts))
    check_fields(recording, shipped(), list)


def test_shipped_recordings_say_nothing_unknown() -> None:
    spec = shipped()
    paths = sorted((REPOSITORY / "specs" / "scenarios").glob("*.jsonl*"))
    assert len(paths) == 11
    for path in paths:
        check_fields(scenarios.load(path), spec, list)


# Numbers that no double holds ------------------------------------------------------------------------------------

HUGE = int("9" * 400)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("path", "line"),
    [
        ((0, "params"), 1), ((0, "track", "left", 0, 0), 1), ((0, "tables"), 1), ((0, "obstacles", 0, "x"), 1), ((0, "version"), 1),
        ((2, "t"), 3), ((2, "ego", "v"), 3), ((2, "objects", 0, "x"), 3), ((2, "candidates", "driving", "v", 1), 3),
        ((2, "ground_truth"), 3),
    ],
)  # fmt: skip
def test_a_whole_number_of_hundreds_of_digits_is_refused(path: tuple[Any, ...], line: int, sign: int) -> None:
    values: dict[Any, Any] = {
        "params": {"x": sign * HUGE},
        "tables": {"ax_max": [[0, sign * HUGE]]},
        "ground_truth": {"static": sign * HUGE},
    }
    lines = good()
    put(*path, value=values.get(path[-1], sign * HUGE))(lines)
    status, text = replay(lines)
    assert status == 2
    assert "error[D14" in text
    assert f"run.tmrec.jsonl:{line}" in text
    assert "internal error" not in text


def test_numbers_of_other_readers() -> None:
    """Of declarations, campaigns of faults, requirements, results and cases."""
    digits = str(HUGE)
    for name in ("cut_in.yaml", "faults.yaml"):
        text = (REPOSITORY / "specs" / "scenarios" / name).read_text()
        Path(name).write_text(text.replace("version: 1", f"version: {digits}", 1))
    with pytest.raises(TrackmarshalError, match="D151"):
        scenarios.load("cut_in.yaml")
    from trackmarshal.scenarios.faults.declaration import load as load_faults

    with pytest.raises(TrackmarshalError, match="D151"):
        load_faults(Path("faults.yaml"), "faults.yaml")
    for long in (digits, digits * 20):
        Path("requirements/v-model.yaml").write_text(V_MODEL + f"  tests_per_rule:\n    satisfied: {long}\n")
        status, out, err = run_command("trace", "--as-is", "--gate")
        assert status == 1, err
        assert "error[T122]" in out
    from trackmarshal.records.results_file import load as load_results

    Path("runs.json").write_text(
        json.dumps({"format": "trackmarshal-results", "version": 1, "holds": "runs", "tool": "x", "created": "x", "items": [
            {"scenario": "a", "source_hash": "", "spec_fingerprint": "", "cycles": 1, "fired": False, "created": "x", "ground_truth": {},
             "rules": [{"rule": "a", "fingerprint": "", "first_violation": HUGE, "verdicts": {}, "candidates": {}}]}]})
    )  # fmt: skip
    with pytest.raises(TrackmarshalError, match="T290"):
        load_results(Path("runs.json"))


#: What recordings have in m/s, rad, 1/m and s.
IN_OTHER_UNITS = {
    "objects.v": ("x: m, v: m/s, age", "x: m, v: km/h, age"),
    "objects.heading": ("x: m, v: m/s, age", "x: m, heading: deg, v: m/s, age"),
    "plan.kappa": ("v: m/s }\nsignal ego", "v: m/s, kappa: 1/km }\nsignal ego"),
    "ego.kappa": ("delta: rad", "kappa: 1/km default 0 1/km, delta: rad"),
}


@pytest.mark.parametrize("name", IN_OTHER_UNITS)
def test_the_formats_own_numbers_are_not_taken_in_another_unit(name: str, tmp_path: Path) -> None:
    """25 m/s were 25 km/h, and "nobody is faster than 50 km/h" was satisfied."""
    lines = good()
    lines[2]["ego"]["kappa"] = 0.1
    Path("specs/small.spec").write_text(SPEC.replace(*IN_OTHER_UNITS[name]))
    status, text = replay(lines)
    assert status == 2
    assert f"error[D147]: the spec has `{name}` in " in text
    out = str(tmp_path / "c")
    compiled = run_command(
        "compile", "specs/small.spec", "--target", "c", "--out", out, "--cycles", "run.tmrec.jsonl"
    )
    assert compiled[0] == 2
    assert "D147" in compiled[2]


def test_what_no_recording_has_may_be_in_any_unit() -> None:
    """Neither a field of one's own, nor one that is given, in the declared unit, nor a default is taken for something else."""
    lines = good()
    lines[0] |= {"given": {"plan.grip": 90}, "because": {"plan.grip": "a dry track"}}
    lines[2]["ego"]["shown"] = 36.0
    spec = SPEC.replace("delta: rad", "shown: km/h default 0 km/h, delta: rad").replace(
        "age: s default 0 s", "age: ms default 0 s"
    )
    spec = spec.replace(
        "heading: rad, v: m/s }\nsignal ego", "heading: rad, v: m/s, grip: % in [0, 200] }\nsignal ego"
    )
    rules = 'rule shown "Shown"\n  require ego.shown <= 10 m/s\nrule grips "Grips"\n  for all p in plan\n  require p.grip >= 0.9\n'
    Path("specs/small.spec").write_text(spec + rules)
    assert replay(lines)[0] == 0
    recording = scenarios.load(Path("run.tmrec.jsonl"))
    assert operating.ranges(recording, load("specs/small.spec"))["ego.shown"] == (10.0, 10.0)
    lines[2]["ego"]["shown"] = 36.1
    assert replay(lines)[0] == 1
