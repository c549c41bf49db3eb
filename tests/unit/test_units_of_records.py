"""Numbers in the record of a run are of the units of then: under a spec that declares others they are not taken for these."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.cli.main import main
from trackmarshal.runtime import declared
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.record.arrow import Layout, layout_of
from trackmarshal.runtime.record.reading import Run, read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import box_of, rerun

#: 30 m/s is too fast.
SPEC = """module units
param top : m/s = 15 m/s
table most(x: m) -> m/s = linear clamp | 0 m: 20 m/s | 9 m: 20 m/s |
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, w: m/s }
signal ego : state { x: m, y: m, heading: rad, lane: 1 }

rule slow "Slow"
  for all p in plan
  require p.w <= min(top, most(p.x)) and ego.lane <= 2
"""
#: What is no SI is kept as it came in.
AS_IT_CAME = SPEC.replace("lane: 1 }", "lane: 1, far: km default 1 km }")
OTHER = {
    "plan.w": ("v: m/s, w: m/s", "v: m/s, w: km/h"),
    "top": ("top : m/s", "top : km/h"),
    "most": ("-> m/s", "-> km/h"),
    "ego.lane": ("signal ego : state { x: m, y: m, heading: rad, lane: 1", "enum lane { left, right, middle }\nsignal ego : state { x: m, y: m, heading: rad, lane: lane"),
}  # fmt: skip


def driven(path: Path, text: str) -> Run:
    """Two cycles, with values in place of the spec's own."""
    now = [0.0]
    given: dict[str, Any] = {"params": {"top": 25.0}, "tables": {"units.most": [[0.0, 25.0], [9.0, 25.0]]}}
    live = tm.supervisor(tm.loads(text), clock=lambda: now[0], record=path, **given)
    for number in range(2):
        now[0] = number * 0.1
        plan = {
            "t": [0.0, 1.0],
            "w": [30.0, 30.0],
            **{name: [0.0, 0.0] for name in ("x", "y", "heading", "v")},
        }
        ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "lane": 1.0}
        assert not live.step(tm.Cycle(number, now[0], plan, dict(plan), {"ego": ego})).safe
    live.close()
    return read(path.read_bytes(), str(path))


def test_a_record_of_the_public_classes_names_its_units(tmp_path: Path) -> None:
    """It named none, and was refused by the very spec of its run."""
    text = AS_IT_CAME.replace("w: m/s }", "w: km/h }")
    spec, path = tm.loads(text), tmp_path / "run.arrows"
    evaluator = tm.Evaluator(spec)
    live = Supervisor(spec, evaluator.program, clock=lambda: 0.0)
    live.recorder = Record(path, live.contract, live.limits, evaluator.program.identity)
    plan = {"t": [0.0, 1.0], "w": [30.0, 30.0], **{name: [0.0, 0.0] for name in ("x", "y", "heading", "v")}}
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "lane": 1.0}
    assert live.step(tm.Cycle(0, 0.0, plan, dict(plan), {"ego": ego})).safe
    live.close()
    run = read(path.read_bytes(), str(path))
    assert [(decision.safe, found) for decision, found in rerun(run, box_of(run, spec))] == [(True, [])]
    with pytest.raises(tm.TrackmarshalError, match=r"`plan[.]w` is in km/h in the record"):
        box_of(run, tm.loads(AS_IT_CAME))


@pytest.mark.parametrize("text", [SPEC, AS_IT_CAME])
@pytest.mark.parametrize("name", OTHER)
def test_a_number_is_not_taken_in_another_unit(
    name: str, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, spec = tmp_path / "run.arrows", tmp_path / "units.spec"
    run = driven(path, text)
    was, now = OTHER[name]
    other = text.replace(was, now).replace(
        "ego.lane <= 2", "ego.lane is left" if "enum" in now else "ego.lane <= 2"
    )
    with pytest.raises(tm.TrackmarshalError, match=f"D162.*`(units.)?{name}`"):
        box_of(run, tm.loads(other))
    with pytest.raises(tm.TrackmarshalError, match=f"D162.*`(units.)?{name}`"):
        tm.replay(tm.load_recording(path), tm.Evaluator(tm.loads(other)))
    spec.write_text(other)
    out = str(tmp_path / "c")
    for verb in (
        ["replay", str(path), "--spec", str(spec), "--quiet"],
        ["compile", str(spec), "--target", "c", "--out", out, "--cycles", str(path)],
    ):
        assert main(verb) == 2
        assert "D162" in capsys.readouterr().err, verb


@pytest.mark.parametrize("text", [SPEC, AS_IT_CAME])
def test_the_same_units_in_other_words_are_no_others(text: str, tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    run = driven(path, text)
    for other in (
        text,
        text.replace("lane: 1", "lane: rad"),
        text.replace("v: m/s, w: m/s", "new: km default 0 km, v: m/s, w: m*Hz"),
    ):
        again = list(rerun(run, box_of(run, tm.loads(other))))
        assert [(decision.safe, found) for decision, found in again] == [(False, [])] * 2
        outcome = tm.replay(tm.load_recording(path), tm.Evaluator(tm.loads(other)))
        assert not any(one.safe for each in outcome.cycles for one in each.results.values())


def test_units_that_nobody_said_are_not_guessed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Records of before: their heads do not say in which units their numbers are."""
    monkeypatch.setattr(declared, "unlisted", lambda units: None)
    run = driven(tmp_path / "run.arrows", SPEC)
    assert [decision.safe for decision, _ in rerun(run, box_of(run, tm.loads(SPEC)))] == [False] * 2
    for name in ("plan.w", "top", "most"):
        with pytest.raises(tm.TrackmarshalError, match=f"D162.*in which unit `(units.)?{name}`"):
            box_of(run, tm.loads(SPEC.replace(*OTHER[name])))


@pytest.mark.parametrize("units", [5, [5], [["field"]], [["field", "ego.x", 1]], [["field", "ego.x", "mph"]], [["field", "ego.x", "km^99999999"]]])  # fmt: skip
def test_a_head_with_units_that_are_none(units: Any, tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    driven(path, SPEC)
    layout, head = layout_of(path.read_bytes()) or pytest.fail("it has no head")
    head = {**head, "identity": {**head["identity"], "units": units}}
    del head["columns"]
    with pytest.raises(tm.TrackmarshalError, match="D162"):
        read(Layout(layout.columns, head).schema, "x")
