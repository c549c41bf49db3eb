"""Whatever a planner hands to a client of a process: nothing is safe there that a Supervisor in this process refuses, and what is refused is a LinkError."""

from __future__ import annotations

import copy
import pickle
import random
import shutil
import subprocess
from array import array
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.processes import PATIENCE, Served
from trackmarshal.cli.main import main
from trackmarshal.process.client import Border, Client
from trackmarshal.process.messages import LinkError
from trackmarshal.process.serving import build
from trackmarshal.runtime.cycle import Cycle

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
SPEC = """module m
enum gear { n, d, r }
enum kind { car, bike }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, gear: gear default d }
signal ego : state { x: m, y: m, heading: rad, v: m/s, lit: bool, gear: gear, wet: bool default false, grip: 1 default 1 }
signal objects : set of object { x: m, v: m/s, kind: kind default car, moving: bool } capacity 3
signal posts : set of object { x: m, on: bool default true } capacity 2
signal track : corridor { left: polyline, right: polyline }
signal stop : polyline
event yellow "a yellow flag is shown"
rule calm ""
  require not yellow or ego.lit or ego.v < 30 m/s
rule dry ""
  require not ego.gear is n and (not ego.wet or ego.v < 40 m/s) and ego.grip > 0.5
rule room ""
  for all o in objects
  require once[0 s, 1 s] (o.x - ego.x > 0 m or o.v >= 0 m/s or o.kind is bike or o.moving)
rule beside ""
  for all o in posts
  require not o.on or o.x > 0 m or ego.x < 3 m
rule gears ""
  for all p in plan
  require not p.gear is r
rule inner ""
  for all p in plan
  require swept_hull(p, 2 m, 1 m) inside track
rule far ""
  for all p in plan
  require distance_to(p, stop) >= 0 m
"""
#: Cases that are drawn of the table each day; `make acceptance` takes it all.
DRAWN = 60
Change = Callable[[Any], Any]


def given() -> dict[str, Any]:
    """A safe cycle, all its data new."""
    plan = {"t": [0.0, 0.4, 1.0, 2.0], "x": [0.0, 4.0, 8.0, 12.0], "y": [0.0] * 4, "heading": [0.0] * 4, "v": [10.0, 10.0, 5.0, 0.0]}  # fmt: skip
    return {
        "driving": {**plan, "gear": ["d"] * 4}, "emergency": {**plan, "gear": ["d"] * 4},
        "signals": {
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0, "lit": False, "gear": "d", "wet": False, "grip": 1.0},
            "objects": {"x": [50.0, 60.0], "v": [1.0, 2.0], "kind": ["car", "bike"], "moving": [True, False], "id": [7, 8]},
            "posts": {"x": [50.0, 60.0], "on": [True, True], "id": [1, 2]},
            "track": {"left": [[-50.0, 6.0], [90.0, 6.0]], "right": [[-50.0, -6.0], [90.0, -6.0]], "closed": False},
            "stop": [[80.0, -5.0], [80.0, 5.0]], "yellow": False,
        },
    }  # fmt: skip


def instead(one: Any) -> Change:
    return lambda _: one


#: What may stand in place of anything.
ANY: dict[str, Change] = {
    **{
        f"{type(one).__name__} {one!r}": instead(one)
        for one in (
            None, True, False, 0, 1, 2, -1, 0.0, 1.0, float("nan"), float("inf"), 10**400, 2**63, "", "d", "false", "nobody", b"1", (), 1j,
            Decimal(1), Fraction(1), np.True_, np.int64(1), np.float32(1.0), np.array(True), np.array(1), np.array(1.0), np.array("d"),
            np.array([True, False]), np.array([1.0]), np.datetime64(1, "s"), np.ma.masked,
        )
    },
    "list": lambda _: [],
    "dict": lambda _: {},
    "object": lambda _: object(),
    "in a list": lambda old: [old],
}  # fmt: skip


def at(place: int, one: Any) -> Change:
    return lambda old: [one if i == place % len(old) else each for i, each in enumerate(old)]


#: What may stand in place of a column, or of points.
COLUMNS: dict[str, Change] = {
    "shorter": lambda old: old[:-1],
    "longer": lambda old: old + old[-1:],
    "beyond capacity": lambda old: old * 80,
    "repeated": lambda old: old[:1] * len(old),
    "backwards": lambda old: old[::-1],
    "tuple": tuple,
    "array": np.array,
    "objects": lambda old: np.array(old, dtype=object),
    "two axes": lambda old: np.array([old]).T,
    "whole": lambda old: [int(one) for one in old],
    "bytes as numbers": lambda old: np.array(old, dtype=np.int8),
    "flags": lambda old: [bool(one) for one in old],
    "flags of numpy": lambda old: np.array(old, dtype=bool),
    "masked": lambda old: np.ma.array(old, mask=[True] + [False] * (len(old) - 1)),
    "dict": lambda old: {each: i for i, each in enumerate(old)},
    "set": set,
    "text": lambda old: "d" * len(old),
    "bytes": lambda old: b"d" * len(old),
    "times": lambda old: np.array(old).astype("datetime64[s]"),
    "iterator": iter,
    "array.array": lambda old: array("d", old),
    **{
        f"{one!r} at {place}": at(place, one)
        for place in (0, -1)
        for one in (
            None, True, 1, 1.0, 0, 2, float("nan"), 10**400, "nobody", b"1", 1j, Decimal(1), [1], object, np.array(1.0), np.array("d"),
            np.datetime64(1, "s"),
        )
    },
}  # fmt: skip
#: What a client takes and the Supervisor's own door does not: the numbers are the same (docs/process.md).
ALSO_TAKEN = {"array.array", "iterator"}
#: Numbers and texts of numpy without axes, in lists of ids, are taken by a client as they are everywhere else.
WITHOUT_AXES = "array("
#: Ids are whole numbers to rules that know elements again by them.
IDS = "signals.objects.id"
#: What was sent as something else than it was.
KNOWN = [
    ("signals.objects.x", "list"), ("signals.posts.x", "list"), ("signals.posts.x", "shorter"), ("signals.posts.on", "bytes as numbers"),
    ("signals.objects.moving", "1 at 0"), ("signals.objects.moving", "0 at -1"), ("signals.ego.lit", "int 1"), ("signals.ego.wet", "int 0"),
    ("signals.yellow", "int 0"), ("signals.yellow", "float 0.0"), ("signals.yellow", "Decimal Decimal('1')"), ("signals.track.closed", "NoneType None"),
    ("signals.track.closed", "int 0"), ("signals.objects.kind", "dict"), ("signals.objects.kind", "set"), ("driving.gear", "True at 0"),
    ("driving.gear", "b'1' at 0"), ("driving.gear", "text"), ("driving.gear", "[1] at 0"), ("signals.ego.grip", "Fraction Fraction(1, 1)"),
    ("signals.ego.lit", "bool True"), ("signals.ego.lit", f"{type(np.True_).__name__} {np.True_!r}"), ("signals.ego.gear", "ndarray array('d', dtype='<U1')"),
    ("signals.posts.id", "repeated"), ("signals.posts.id", "longer"), ("signals.posts.id", "None at 0"), (IDS, "int 1"), (IDS, "set"),
    ("signals", "NoneType None"), ("signals.stop", "dict"), ("signals.track.left", "str ''"),
]  # fmt: skip


def places(data: dict[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, one in data.items():
        yield before + name, one
        if isinstance(one, dict):
            yield from places(one, f"{before}{name}.")


def table() -> list[tuple[str, str]]:
    return [
        (place, form)
        for place, old in places(given())
        for form in {**ANY, **(COLUMNS if isinstance(old, list) else {})}
    ]


def changed(place: str, form: str) -> dict[str, Any] | None:
    """The cycle with something else at a place; None where that cannot be made."""
    data = given()
    *way, last = place.split(".")
    within = data
    for name in way:
        within = within[name]
    columns = isinstance(within[last], list) and form in COLUMNS
    try:
        within[last] = (COLUMNS if columns else ANY)[form](within[last])
    except (TypeError, ValueError, np.ma.MaskError):  # no such array of texts or points
        return None
    return data


class Pair:
    """A process and a Supervisor here, of one spec, that are given the same."""

    def __init__(self, served: Served) -> None:
        self.number, self.now = 0, 0.0
        self.client = Client(served.program.layout, served.channel(), lambda: self.now)
        self._local = tm.supervisor(tm.loads(SPEC), backend="numpy", clock=lambda: self.now)
        self._borders: dict[str, Border] = {}

    def step(self, make: Callable[[], dict[str, Any] | None]) -> tuple[bool | str, bool] | None:
        """Whether a cycle is safe there, or the LinkError, and here. It is made for each: some data can be read once."""
        here, there = make(), make()
        if here is None or there is None:
            return None
        self.number, self.now = self.number + 1, self.now + 0.1
        try:
            said: bool | str = self._sent(there)
        except LinkError as error:
            said = str(error)
            assert self._sent(given())  # the next one is not skipped
        return said, self._local.step(Cycle(self.number, self.now, **here)).safe

    def _sent(self, data: dict[str, Any]) -> bool:
        signals = data["signals"]
        if isinstance(signals, dict):
            signals = {**signals, "stop": self._border(signals.get("stop"))}
            if isinstance(track := signals.get("track"), dict):
                signals["track"] = {name: one if name == "closed" else self._border(one) for name, one in track.items()}  # fmt: skip
        sequence = self.client.send(self.number, self.now, data["driving"], data["emergency"], signals)
        message = self.client.answer(sequence, PATIENCE)
        assert message is not None
        return bool(message["safe"])

    def _border(self, points: Any) -> Border | None:
        if points is None:
            return None
        if type(points) is not list:
            return Border(points)
        return self._borders.get(repr(points)) or self._borders.setdefault(repr(points), Border(points))


@pytest.fixture(scope="module")
def pair() -> Iterator[Pair]:
    spec = tm.loads(SPEC)
    with Served(build(spec, list(spec.rules))) as served:
        yield Pair(served)


def hold(pair: Pair, cases: list[tuple[str, str]]) -> None:
    assert pair.step(given) == (True, True)
    for place, form in cases:
        found = pair.step(lambda place=place, form=form: changed(place, form))  # type: ignore[misc]
        if found is None:
            continue
        there, here = found
        if there is True:
            same = form in ALSO_TAKEN or (place.endswith(".id") and form.startswith(WITHOUT_AXES))
            assert here or same, (place, form)
        elif here:  # a planner is not stopped for nothing: what it gave has a form that docs/process.md names
            assert place == IDS or "given field by field" in str(there), (place, form, there)
    assert pair.step(given) == (True, True)


def test_what_was_sent_as_something_else(pair: Pair) -> None:
    hold(pair, KNOWN)


def test_a_draw_of_all_forms_at_all_places(pair: Pair) -> None:
    hold(pair, random.Random(1).sample(table(), DRAWN))


@pytest.mark.acceptance
def test_all_forms_at_all_places(pair: Pair) -> None:
    hold(pair, table())


@pytest.mark.parametrize("number", [False, True, 0.0, "", (), np.array(0.0), np.array([1, 2])])
def test_a_number_that_is_none(number: Any, pair: Pair) -> None:
    """Of which the first ones were sent as 0, which the first cycle has."""
    with pytest.raises(LinkError, match="`number` cannot be that"):
        pair.client.send(number, pair.now, None, None, {})


@pytest.mark.parametrize("came", [None, 1, "no"])
def test_a_cycle_that_came_or_not(came: Any, pair: Pair) -> None:
    with pytest.raises(LinkError, match="`came` is True or False"):
        pair.client.send(0, pair.now, None, None, {}, came=came)


@pytest.mark.parametrize(
    "found",
    [None, "missing", [("missing",)], [("none", "ego", "v", None)], [("missing", "ego", "v", -5)], [("missing", "ego", "v", "3")]],
)  # fmt: skip
def test_faults_that_are_none(found: Any, pair: Pair) -> None:
    """The process refuses a message with a fault that is none, or at a place that is none: its cycle was lost without a word."""
    with pytest.raises(LinkError):
        pair.client.send(0, pair.now, None, None, {}, found)


@pytest.mark.parametrize(
    "points", [{(0.0, 0.0), (1.0, 0.0)}, [{0.0, 1.0}], [b"ab"], {(0.0, 1.0): 1}, [[10**400, 0]], "", {}]
)
def test_points_that_are_none(points: Any) -> None:
    with pytest.raises(LinkError, match="points are pairs"):
        Border(points)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_border_of_another_process(copied: Callable[[Border], Border]) -> None:
    """It is no border that this one has sent, though both count from 1 on."""
    one = Border([[0.0, 1.0], [2.0, 3.0]])
    other = copied(one)
    assert other.points.tolist() == one.points.tolist()
    assert other.number != one.number


def test_points_do_not_change() -> None:
    """A border is sent once: who changed it would be judged by what it was."""
    points: Any = Border([[0.0, 1.0]]).points
    with pytest.raises(TypeError):
        points[0] = 5.0


#: What a client in C sends of cycles, by the kinds of its messages: one each for a line and a cycle.
SENDING = """
#include "client.h"
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

int main(void) {
  static tml_client client;
  static tml_message heard;
  static const double points[6] = {0.0, 1.0, 2.0, 3.0, 4.0, 5.0};
  tm_in_stop stop = {{points, 2u, 7u}};
  static const tm_fault nameless[1] = {{TM_FAULT_NONE, NULL, NULL, 3u}};
  tm_cycle cycle;
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_DGRAM, 0, ends) != 0) { return 1; }
  client.process = getpid();
  client.session = 1u;
  client.fixed = 0.0;
  client.socket = ends[0];
  (void)memset(&cycle, 0, sizeof(cycle));
  cycle.came = true;
  cycle.signals.stop = &stop;
  for (size_t k = 0u; k < 4u; ++k) {
    if (k == 1u) { stop.line.count = 3u; }
    if (k == 2u) { cycle.found_count = 2u; }
    if (k == 3u) { cycle.found = nameless; cycle.found_count = 1u; }
    (void)tml_client_send(&client, &cycle);
    while (recv(ends[1], heard.bytes, sizeof(heard.bytes), MSG_DONTWAIT) > 0) {
      if (tml_sound(&heard) != TML_CAUSE_NONE) { return 1; }
      if (heard.head.kind == TML_LINE) { (void)printf("line of %d\\n", (int)heard.line.count); }
      if (heard.head.kind == TML_CYCLE) { (void)printf("cycle, %d found\\n", (int)heard.cycle.found_count); }
    }
  }
  return 0;
}
"""


@pytest.mark.acceptance
def test_what_a_client_in_c_sends(tmp_path: Path) -> None:
    """A line with the id of the one before and another count is another one, as to `tm_step`, and so are faults that are not there a fault, and
    one without a name: the process would have said nothing of its cycle."""
    (tmp_path / "m.spec").write_text(SPEC, encoding="utf-8")
    assert main(["compile", str(tmp_path / "m.spec"), "--process", "--out", str(tmp_path)]) == 0
    (tmp_path / "sending.c").write_text(SENDING, encoding="utf-8")
    sources = [str(tmp_path / f"{name}.c") for name in ("sending", "client", "messages", "mailbox")]
    subprocess.run(["cc", "-Werror", "-O0", *sources, "-o", str(tmp_path / "sending"), "-lm"], check=True)
    done = subprocess.run([str(tmp_path / "sending")], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["line of 2", "cycle, 0 found", "line of 3", "cycle, 0 found", "cycle, 1 found", "cycle, 1 found"]  # fmt: skip
