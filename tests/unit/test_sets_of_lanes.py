"""Sets of lanes that come with the cycle: what rules read of each, at every door, and what is refused."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.emitted import emit
from support.length import amount
from support.project import run_command
from support.sanitized import FLAGS as SANITIZED
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.glue import glue
from trackmarshal.backends.c.source import generate
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.faults import name_of
from trackmarshal.supervision import supervisor

TEXT = """module made.lanes

enum lane_kind { driving, shoulder }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal cars : set of object { x: m, y: m, heading: rad, length: m, width: m }
signal lanes : set of lane {
  left: polyline, right: polyline, limit: km/h default 180 km/h, kind: lane_kind default driving, ahead: 1 default -1, open: bool default true
}
event emergency "the candidate is the emergency trajectory"

define width_at(p: point, road: corridor, left: polyline, right: polyline) -> m =
  distance_to(p, left) + distance_to(p, right) + 0 * offset(p, road)

"""
#: Three lanes to the east, 4 m wide each, the first one at the bottom.
LANES: list[dict[str, Any]] = [
    {"left": [[0.0, 4.0], [100.0, 4.0]], "right": [[0.0, 0.0], [100.0, 0.0]], "limit": 72.0},
    {"left": [[0.0, 8.0], [50.0, 8.0], [100.0, 8.0]], "right": [[0.0, 4.0], [100.0, 4.0]]},
    {"left": [[0.0, 12.0], [100.0, 12.0]], "right": [[0.0, 8.0], [100.0, 8.0]], "kind": "shoulder", "open": False},
]  # fmt: skip
EGO = {"x": 20.0, "y": 2.0, "heading": 0.0, "v": 21.0}
PLAN = {
    "t": [0.0, 1.0], "x": [20.0, 41.0], "y": [2.0, 2.0], "heading": [0.0, 0.0], "kappa": [0.0, 0.0], "v": [21.0, 21.0],
}  # fmt: skip
SIGNALS: dict[str, Any] = {"ego": EGO, "plan": PLAN, "cars": [], "lanes": LANES, "emergency": False}
BACKENDS = [
    "reference",
    "numpy",
    pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
]


def made(rule: str) -> tm.Spec:
    return loads(f'{TEXT}rule made "made up"\n  {rule}\n')


def judged(rule: str, backend: str, **signals: Any) -> Any:
    result = Evaluator(made(rule), backend=backend).case({"signals": {**SIGNALS, **signals}})
    return result.rules["made"]


#: Rules, and what each says.
ROADS = [
    ("for all l in lanes where footprint(ego, 4 m, 2 m) meets l require ego.v <= l.limit", "violated", -1),
    ("exists l in lanes require footprint(ego, 4 m, 2 m) inside l", "satisfied", 1),
    ("exists l in lanes where l.kind is shoulder require footprint(ego, 4 m, 2 m) inside l", "violated", -7),
    ("for all l in lanes where l.kind is shoulder require not (footprint(ego, 4 m, 2 m) meets l)", "satisfied", 5),
    ("for all l in lanes where l.open require station(ego, l) == 20 m", "satisfied", 0),
    ("for all l in lanes where not l.open require offset(ego, l) >= -8 m", "satisfied", 0),
    ("for all l in lanes require direction(ego, l) == 0", "satisfied", 0),
    ("for all l in lanes where l.limit < 100 km/h require distance_to(ego, l.left) == 2 m", "satisfied", 0),
    ("for all l in lanes where l.limit < 100 km/h require distance_to(ego, l.right) >= 3 m", "violated", -1),
    ("for all l in lanes where l.limit < 100 km/h require width_at(ego, l, l.left, l.right) == 4 m", "satisfied", 0),
    ("for all l in lanes require distance_to(ego, l) <= 7 m", "violated", -1),
    ("for all l in lanes require station_gap(l, 90 m, 5 m) == -85 m", "satisfied", 0),
    ("for all l in lanes require ego in stretch(l, 10 m, 25 m)", "satisfied", 5),
    ("for all l in lanes require ego in stretch(l.left, 10 m, 15 m)", "violated", -5),
    ("for nearest l in lanes by distance_to(ego, l) require l.limit <= 20 m/s", "satisfied", 0),
    ("require count(l in lanes where footprint(ego, 4 m, 4 m) meets l) == 2", "satisfied", 0),
    ("exists l in lanes require for all p in plan: (swept_footprint(p, 4 m, 2 m) inside l)", "satisfied", 1),
    ("let box = footprint(ego, 4 m, 2 m)\n  exists l in lanes\n  let here = l\n  require box inside here", "satisfied", 1),
]  # fmt: skip


@cache
def roads(backend: str, rules: tuple[str, ...]) -> Mapping[str, Any]:
    """What such rules say, of one spec: a compiler is asked once for all of them."""
    laid_out = (rule.replace(" require ", "\n  require ") for rule in rules)
    text = "".join(f'rule road_{n} "made up"\n  {rule}\n' for n, rule in enumerate(laid_out))
    found = Evaluator(loads(TEXT + text), backend=backend).case({"signals": SIGNALS}).rules
    return {rule: found[f"road_{n}"] for n, rule in enumerate(rules)}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("rule", "verdict", "margin"), ROADS)
def test_each_lane_is_a_road(backend: str, rule: str, verdict: str, margin: float) -> None:
    """At length, each rule in a spec of its own."""
    found = roads(backend, amount(tuple(rule for rule, *_ in ROADS), (rule,)))[rule]
    assert (found.verdict, found.margin) == (verdict, margin)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("y", "margin"), [(2, 3), (-1, 0), (-1.5, -0.5), (5, 0), (math.nextafter(5, 9), 5 - math.nextafter(5, 9))]
)
def test_edges_that_touch_meet(backend: str, y: float, margin: float) -> None:
    found = judged(
        "exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l",
        backend,
        ego={**EGO, "y": y},
        lanes=LANES[:1],
    )
    if y == 2:
        assert (found.verdict, found.margin > 0) == ("satisfied", True)
    else:
        assert (found.verdict, found.margin) == ("satisfied" if margin >= 0 else "violated", margin)


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_lane(backend: str) -> None:
    assert (
        judged("exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l", backend, lanes=[]).verdict
        == "violated"
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_columns_and_arrays(backend: str) -> None:
    columns = {
        side: [np.array(lane[side]) if k else tm.line(lane[side]) for k, lane in enumerate(LANES)]
        for side in ("left", "right")
    }
    rule = "for all l in lanes where footprint(ego, 4 m, 2 m) meets l\n  require ego.v <= l.limit"
    found = judged(rule, backend, lanes={**columns, "limit": [72.0, 90.0, 90.0]})
    assert (found.verdict, found.margin) == ("violated", -1)


@pytest.mark.parametrize("backend", BACKENDS)
def test_cases_with_lanes_of_their_own(backend: str) -> None:
    spec = made("for all l in lanes where footprint(ego, 4 m, 2 m) meets l\n  require ego.v <= l.limit")
    cases = [
        {"signals": {**SIGNALS, "lanes": lanes}} for lanes in (LANES, LANES[1:], [], LANES[::-1], LANES[:1])
    ]
    evaluator = Evaluator(spec, backend=backend)
    verdicts = [result.rules["made"].verdict for result in evaluator.evaluate(evaluator.read_all(cases))]
    assert verdicts == ["violated", "inactive", "inactive", "violated", "violated"]


CROSSING = {"left": [[0, 0], [9, 0]], "right": [[0, 4], [5, -1], [9, 4]]}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("lane", "fault", "text"),
    [
        (CROSSING, "bad_border", "left border meets right border near (5.800, 0.000)"),
        (
            {**CROSSING, "right": [[0, 4]]},
            "bad_border",
            "right border has fewer than 2 distinct points",
        ),
        (
            {**CROSSING, "right": [[0, 4], [1, math.nan]]},
            "bad_border",
            "right border: point 1 is (1, nan), not finite or beyond 1e+09 m",
        ),
        ({**CROSSING, "right": None}, "missing", "it is not there"),
        ({"left": [[0, 0], [9, 0]]}, "missing", "it is not there"),
    ],
)
def test_what_is_no_lane_is_a_fault(backend: str, lane: dict[str, Any], fault: str, text: str) -> None:
    spec = made("exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l")
    result = Evaluator(spec, backend=backend).case({"signals": {**SIGNALS, "lanes": [*LANES, lane]}})
    assert result.rules["made"].verdict == "undefined"
    assert not result.safe
    assert len(result.faults) == 1
    assert text in str(result.faults[0])
    assert "3" in str(result.faults[0])


@pytest.mark.parametrize(
    ("lanes", "code", "text"),
    [
        ([{**LANES[0], "left": [[0, 0], [1]]}], "D202", "lanes.left[0]: point 1: not a point [x, y]"),
        ([{**LANES[0], "left": "here"}], "D202", "lanes.left[0]: not a list of points"),
        ([{**LANES[0], "lft": []}], "D203", "did you mean `left`?"),
        (7, "D202", "lanes"),
    ],
)
def test_what_cannot_be_read_is_refused(lanes: Any, code: str, text: str) -> None:
    with pytest.raises(TrackmarshalError) as raised:
        judged("exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l", "numpy", lanes=lanes)
    assert raised.value.code == code
    assert text in str(raised.value) + str(raised.value.help)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("beside", [[], ["other"]])
@pytest.mark.parametrize(
    ("limit", "kind", "verdict"),
    [(None, "shoulder", "satisfied"), (None, "driving", "undefined"), (math.nan, "shoulder", "satisfied")],
)  # fmt: skip
def test_a_lane_without_a_limit_leaves_undefined_what_asks_for_it(
    backend: str, beside: list[str], limit: float | None, kind: str, verdict: str
) -> None:
    """Whether another rule measures on the lanes is no matter to one that reads a number of each."""
    rule = "for all l in lanes where {}l.kind is driving\n  require ego.v <= l.limit + 30 m/s"
    spec = loads(
        f'{TEXT}rule made "made up"\n  {rule.format("")}\n\n'
        f'rule other "made up"\n  {rule.format("footprint(ego, 4 m, 2 m) meets l and ")}\n'
    )
    lanes = [*LANES[:2], {**LANES[2], "limit": limit, "kind": kind}]
    ego = {**EGO, "y": 7.5}  # over the second and the third
    result = Evaluator(spec, ["made", *beside], backend=backend).case(
        {"signals": {**SIGNALS, "lanes": lanes, "ego": ego}}
    )
    assert {name: found.verdict for name, found in result.rules.items()} == dict.fromkeys(
        ["made", *beside], verdict
    )
    assert not result.safe


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("lanes", "said"),
    [
        (None, ["D211 lanes: it is not there"]),
        ([CROSSING, LANES[0], CROSSING], ["D217 lanes[0]: left border meets right border near (5.800, 0.000), and 1 more"]),
        ([{}, {"left": LANES[0]["left"]}], ["D211 lanes.left[0]: it is not there", "D211 lanes.right[0]: it is not there, and 1 more"]),
        ({"left": [LANES[0]["left"]], "right": [LANES[0]["right"]] * 2}, ["D212 lanes.right[1]: 2 entries, 1 elsewhere", "D211 lanes.left[1]: it is not there"]),
    ],
)  # fmt: skip
def test_each_kind_of_fault_is_said_once(backend: str, lanes: Any, said: list[str]) -> None:
    spec = made("exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l")
    result = Evaluator(spec, backend=backend).case({"signals": {**SIGNALS, "lanes": lanes}})
    assert result.rules["made"].verdict == "undefined"
    assert list(result.faults) == said


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_car_that_is_nowhere(backend: str) -> None:
    found = judged(
        "exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l", backend, ego={**EGO, "x": None}
    )
    assert found.verdict == "undefined"
    assert "ego.x" in str(found)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_rules_alone_in_c(tmp_path: Path) -> None:
    """Emitted, without a warning; a lane that nobody has set is one of which nothing is known."""
    spec = tmp_path / "m.spec"
    spec.write_text(
        "module m\nsignal ego : state { x: m, y: m, heading: rad }\nsignal lanes : set of lane { left: polyline, right: polyline }\n"
        'rule a "" exists l in lanes require footprint(ego, 4 m, 2 m) inside l\n'
        'rule b "" for all l in lanes require distance_to(ego, l.left) >= 1 m and station(ego, l) >= 0 m\n'
        'rule c "" for all l in lanes require footprint(ego, 4 m, 2 m) meets l\n',
        encoding="utf-8",
    )
    made = emit(tmp_path / "out", recordings=[], spec=spec, root=tmp_path)
    flags = [
        "-std=c99",
        "-O0",
        "-ffp-contract=off",
        "-pedantic",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Werror",
    ]
    subprocess.run(
        ["cc", *flags, *SANITIZED, "supervisor.c", "main.c", "-o", "check", "-lm"], cwd=made, check=True
    )
    said = subprocess.run([made / "check"], capture_output=True, text=True, check=True).stdout
    assert [line.split()[:2] for line in said.splitlines()] == [[name, "satisfied"] for name in "abc"]
    main = (
        (made / "main.c")
        .read_text(encoding="utf-8")
        .replace("tm_set_lanes(&context, 0u,", "tm_set_lanes(&context, 1u,")
    )
    (made / "main.c").write_text(main, encoding="utf-8")
    subprocess.run(["cc", *flags, "supervisor.c", "main.c", "-o", "check", "-lm"], cwd=made, check=True)
    said = subprocess.run([made / "check"], capture_output=True, text=True, check=True).stdout
    assert [line.split()[:2] for line in said.splitlines()] == [[name, "undefined"] for name in "abc"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_histories_go_by_the_ids_of_lanes(backend: str) -> None:
    spec = made(
        "for all l in lanes where footprint(ego, 4 m, 2 m) meets l\n"
        "  require once[1 s, 2 s] (footprint(ego, 4 m, 2 m) inside l)"
    )
    run = Evaluator(spec, backend=backend)
    over = run.over_run()
    lanes = [{**lane, "id": f"lane{k}"} for k, lane in enumerate(LANES)]
    verdicts = []
    for k, y in enumerate((2.0, 2.0, 3.5, 6.0, 6.0)):
        there = lanes[:: 1 if k % 2 else -1]  # in another order in each cycle
        case = {"t": float(k), "signals": {**SIGNALS, "ego": {**EGO, "y": y}, "lanes": there}}
        verdicts.append(over.step(run.read(case)).rules["made"].verdict)
    assert verdicts == ["violated", "satisfied", "violated", "violated", "satisfied"]


def supervised(tmp_path: Path, cycles: list[dict[str, Any]], backend: str) -> list[tm.Decision]:
    spec = made("for all l in lanes where footprint(ego, 4 m, 2 m) meets l\n  require ego.v <= l.limit")
    now = [0.0]
    box = supervisor(
        spec, backend=backend, limits={"budget": 1e9}, clock=lambda: now[0], record=tmp_path / "run.arrows"
    )
    shared = {name: value for name, value in SIGNALS.items() if name not in ("plan", "emergency")}
    stop = {**PLAN, "v": [21.0, 0.0]}
    decisions = []
    for k, each in enumerate(cycles):
        now[0] = 0.1 * k
        decisions.append(box.step(tm.Cycle(k, now[0], PLAN, stop, {**shared, **each})))
    box.close()
    return decisions


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_supervisor_and_its_record(backend: str, tmp_path: Path) -> None:
    cycles: list[dict[str, Any]] = [
        {"lanes": LANES[1:]}, {"lanes": LANES}, {"lanes": [CROSSING]}, {"lanes": LANES[2:]},
    ]  # fmt: skip
    decisions = supervised(tmp_path, cycles, backend)
    assert [[name_of(fault) for fault in decision.faults] for decision in decisions] == [
        [],
        [],
        ["bad_border"],
        [],
    ]
    assert [decision.safe for decision in decisions] == [True, False, False, True]
    recording = tm.load_recording(tmp_path / "run.arrows")
    assert [cycle.more["lanes"] for cycle in recording.cycles][:2] == [LANES[1:], LANES]


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_recording(backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("made.spec").write_text(
        f"{TEXT.replace('module made.lanes', 'module made')}"
        'rule made "m"\n  for all l in lanes where footprint(ego, 4 m, 2 m) meets l\n  require ego.v <= l.limit\n'
    )
    head = {"format": "trackmarshal-recording", "version": 1, "name": "made", "track": {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]}, "signals": {"lanes": LANES}}  # fmt: skip
    plan = {**PLAN, "a": [0.0, 0.0]}
    cycle = {"ego": EGO, "objects": [], "candidates": {"driving": plan, "emergency": {**plan, "v": [21.0, 0.0]}}}  # fmt: skip
    changes: list[dict[str, Any]] = [{}, {"lanes": LANES[1:]}, {"lanes": [CROSSING]}]
    made_ = [{"t": float(k), **cycle, "signals": {**each, "cars": []}} for k, each in enumerate(changes)]
    Path("run.tmrec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in [head, *made_]))
    status, out, err = run_command(
        "replay",
        "run.tmrec.jsonl",
        "--spec",
        "made.spec",
        "--format",
        "jsonl",
        "--exit-zero",
        "--backend",
        backend,
    )
    assert status == 0, err
    verdicts = [
        line["rules"]["made"]["verdict"]
        for line in map(json.loads, out.splitlines())
        if line.get("candidate") == "driving"
    ]
    assert verdicts == ["violated", "inactive", "undefined"]
    assert "D217" in out


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_more_lanes_than_c_has_memory_for() -> None:
    spec = made("exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l")
    many = {**SIGNALS, "lanes": LANES * 100}
    for backend in ("c", "auto"):
        assert Evaluator(spec, backend=backend).case({"signals": many}).rules["made"].verdict == "satisfied"
    left = tm.line([[k / 10.0, 4.0] for k in range(5000)])  # which is read once
    many["lanes"] = {"left": [left] * 100, "right": [tm.line([[0.0, 0.0], [500.0, 0.0]])] * 100}
    with pytest.raises(TrackmarshalError, match="more than 256 MiB") as caught:
        Evaluator(spec, backend="c").case({"signals": many})
    assert caught.value.code == "E473"


@pytest.mark.parametrize("backend", BACKENDS)
def test_more_borders_than_lanes(backend: str) -> None:
    """C has memory for 32 lanes, or as many as there are: of two with 40 borders it said that its geometry refuses them (E473)."""
    evaluator = Evaluator(
        made("exists l in lanes where l.limit > 0 km/h\n  require footprint(ego, 2 m, 2 m) meets l"),
        backend=backend,
    )
    for count, verdict in ((2, "satisfied"), (40, "undefined"), (2, "satisfied")):
        sides = {side: [LANES[0][side]] * count for side in ("left", "right")}
        result = evaluator.case({"signals": {**SIGNALS, "lanes": {**sides, "limit": [72.0, 72.0]}}})
        assert result.rules["made"].verdict == verdict
        assert {fault[:4] for fault in result.faults} == ({"D212"} if count == 40 else set())


def test_supervisors_in_two_threads_have_no_lanes_in_common() -> None:
    """Python is let go on while C takes a step: what the library kept for one would be judged by in the step of another one of the same program."""
    spec = made("exists l in lanes\n  require footprint(ego, 2 m, 2 m) meets l")
    source = generate(spec, [rule for rule in spec.rules if rule.formula is not None], doored=True)
    text = re.sub(r"/\*.*?\*/", "", f"{source.source}\n{glue(source)}", flags=re.DOTALL)
    assert "lanes_lanes" in text
    assert re.findall(r"^\s*static (?!const |inline )[^(;]*[;=]", text, re.MULTILINE) == []
