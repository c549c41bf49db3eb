"""What a client of a process leaves out is missing, as to a Supervisor in this process: also of clients before which no door stands, as of those in C."""

from __future__ import annotations

import shutil
from typing import Any

import pytest

import trackmarshal as tm
from support.processes import PATIENCE, Served
from trackmarshal.process.client import Client
from trackmarshal.process.messages import LinkError
from trackmarshal.process.serving import build
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.faults import name_of

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
SPEC = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s, lit: bool }
signal objects : set of object { x: m, v: m/s, shy: bool default false } capacity 4
event yellow "a yellow flag is shown"
rule calm "" require not yellow or ego.lit or ego.v < 30 m/s
rule room ""
  for all o in objects
  require once[0 s, 1 s] (o.x - ego.x > 0 m or o.v >= 0 m/s or o.shy)
"""
COLUMN = {
    "t": [0.0, 0.4, 2.0],
    "x": [0.0, 4.0, 12.0],
    "y": [0.0] * 3,
    "heading": [0.0] * 3,
    "v": [10.0, 10.0, 0.0],
}
GIVEN: dict[str, Any] = {
    "driving": COLUMN, "emergency": COLUMN, "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0, "lit": False},
    "objects": {"id": [7, 8], "x": [50.0, 60.0], "v": [1.0, 2.0]}, "yellow": False,
}  # fmt: skip
LEFT_OUT = [
    "", "driving", "emergency", "driving.v", "emergency.t", "ego", "ego.v", "objects", "objects.x", "objects.v", "objects.id", "objects.x v",
    "objects.x v id", "driving.t x y heading v", "driving.x y", "ego.lit", "yellow",
]  # fmt: skip


@pytest.fixture
def served() -> Any:
    spec = tm.loads(SPEC)
    with Served(build(spec, list(spec.rules))) as served:  # compiled once for all
        yield served


@pytest.mark.parametrize("left_out", LEFT_OUT)
def test_what_is_left_out_is_missing(left_out: str, served: Served) -> None:
    signal, _, field = left_out.partition(".")
    given = {name: value for name, value in GIVEN.items() if field or name != signal}
    if field:
        given[signal] = {name: column for name, column in GIVEN[signal].items() if name not in field.split()}
    driving, emergency = given.pop("driving", None), given.pop("emergency", None)
    now = 0.0
    client = Client(served.program.layout, served.channel(), lambda: now)
    local = tm.supervisor(tm.loads(SPEC), backend="numpy", clock=lambda: now)
    expected = local.step(Cycle(0, 0.0, driving, emergency, given))
    said = client.answer(client.send(0, 0.0, driving, emergency, given), PATIENCE)
    client.close()
    assert said is not None
    layout = said.layout
    reasons = range(said["reason_count"])
    found = [
        (layout.faults[said["reason_name"][i]], layout.signals[said["reason_signal"][i]], layout.fields[said["reason_field"][i]])
        for i in reasons if said["reason_kind"][i] == 0
    ]  # fmt: skip
    wanted = [(name_of(fault), fault.signal, fault.field) for fault in expected.faults]
    if left_out in (
        "ego.v",
        "ego.lit",
        "yellow",
    ):  # of what is one value, a message does not say whether it was given
        wanted = [("not_finite", signal, field) for _, signal, field in wanted]
    assert found == wanted
    assert bool(said["safe"]) == expected.safe == (left_out == "")


def test_when_samples_are_due(served: Served) -> None:
    """Of what is driven and of what is stored, by the clock, and not by the stamp of its cycle."""
    now = 100.0
    client = Client(served.program.layout, served.channel(), lambda: now)
    said = client.answer(client.send(0, 99.95, COLUMN, COLUMN, {"ego": GIVEN["ego"], "objects": GIVEN["objects"], "yellow": False}), PATIENCE)  # fmt: skip
    client.close()
    assert said is not None
    assert said["safe"] == 1
    for which in ("driving", "fallback"):
        count = said[f"{which}/count"]
        assert list(said[f"{which}/due"][:count]) == [t + 99.95 for t in COLUMN["t"]]


@pytest.mark.parametrize(
    "objects",
    [
        {"x": [], "v": [1.0, 2.0]}, {"x": [50.0, 60.0], "v": []}, {"x": [], "v": []}, {"id": [], "x": [50.0], "v": [1.0]}, {"id": [7]}, {},
        {"shy": []}, {"x": [50.0, 60.0], "v": None}, {"x": None, "v": None}, {"id": [], "x": [], "v": None}, {"id": [], "x": [], "v": []},
    ],
    ids=str,
)  # fmt: skip
def test_columns_of_different_lengths_are_not_safe(objects: dict[str, Any], served: Served) -> None:
    """Of a column without elements beside one with some, elements at x = 0 were made, or none at all."""
    given = {**GIVEN, "objects": {**GIVEN["objects"], **objects}}
    driving, emergency = given.pop("driving"), given.pop("emergency")
    client = Client(served.program.layout, served.channel(), lambda: 0.0)
    local = tm.supervisor(tm.loads(SPEC), backend="numpy", clock=lambda: 0.0)
    expected = local.step(Cycle(0, 0.0, driving, emergency, given))
    try:
        sent = client.send(0, 0.0, driving, emergency, given)
    except LinkError:
        assert "wrong_length" in map(name_of, expected.faults)
    else:
        said = client.answer(sent, PATIENCE)
        assert said is not None
        assert bool(said["safe"]) == expected.safe
    client.close()


@pytest.mark.parametrize(("lit", "ids"), [(True, [7, 8]), (False, [7, 8]), (None, [7, 8]), (True, [])])
def test_what_passed_the_door_of_this_process(lit: bool | None, ids: list[int], served: Served) -> None:
    """Frames have flags as numbers, which are none to a client, and sets without elements, to which no id belongs: both are sent."""
    spec = tm.loads(SPEC)
    objects = {name: column[: len(ids)] for name, column in GIVEN["objects"].items()}
    given = {**GIVEN, "ego": {**GIVEN["ego"], "lit": lit, "v": 40.0}, "objects": objects, "yellow": True}
    driving, emergency = given.pop("driving"), given.pop("emergency")
    client = Client(served.program.layout, served.channel(), lambda: 0.0)
    remote = RemoteSupervisor(spec, list(spec.rules), client, clock=lambda: 0.0, patience=PATIENCE)
    local = tm.supervisor(spec, backend="numpy", clock=lambda: 0.0)
    cycle = Cycle(0, 0.0, driving, emergency, given)
    said, expected = (supervisor.step(cycle) for supervisor in (remote, local))
    assert said.faults == expected.faults
    assert (said.safe, expected.safe) == (lit is True, lit is True)
    remote.close()
