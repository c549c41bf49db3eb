"""The rulebook `interstate` in every cycle of 60 runs, against the verdicts of an independent monitor: where both differ is listed, with why.

The monitor's verdict is true where its robustness is zero or more; ours where a rule is satisfied or demands nothing.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path

import pytest

from support.interstate import RULES, Cycle, Scene, cycles, measured, scenes
from support.shared import REPOSITORY
from trackmarshal.backends.c.build import compiler
from trackmarshal.cli.main import main
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.verdict import About

SPECS = REPOSITORY / "specs" / "interstate"
HOLDS = {"satisfied": "T", "inactive": "T", "violated": "F"}
#: Where stations, offsets and headings come from: as the oracle has them, or measured on the map by `trackmarshal.lanes`.
SOURCES: dict[str, Callable[[Scene, int, int, int], list[Cycle]]] = {"stored": cycles, "measured": measured}

SINGLE = (
    "the paper's single_lane is to occupy one lane, and so is the monitor's Boolean one; its robustness is negative where the box protrudes over the "
    "outer edge of the road, although nothing is there to occupy"
)
TOUCH = "the box touches the other lane's lanelet by 5 mm, and so has cut in; the monitor's robustness goes by smoothed bounds, which it does not reach"
CONTACT = "first contact with a lane, by millimetres: the monitor's robustness goes by smoothed bounds, not by the lanelets that are touched"
STATION = "whether the rear of one has passed the front of the other, by centimetres: the monitor's stations are along a smoothed middle, ours along the middle as mapped"
HEADING = "one heads 2e-6 rad to the left of its lane in the one cycle in which it comes in, as the monitor has the lane's direction, which is that of the piece ahead; ours turns evenly"
#: By source: where we differ (scene, ego, rule), in which cycles, and why.
Listed = dict[tuple[str, int, str], tuple[list[int], str]]
STORED: Listed = {
    ("USA_US101-15_1_T-1+signs", 446, "R_G1"): ([34], CONTACT),
    ("USA_US101-15_1_T-1+signs", 438, "R_I2"): ([59], CONTACT),
    ("USA_US101-5_1_T-1", 449, "R_I2"): ([31], CONTACT),
    ("USA_US101-5_1_T-1", 554, "R_I4"): ([*range(54, 71), 77, 78], SINGLE),
    ("USA_US101-8_1_T-1", 51, "R_G1"): ([*range(19, 35)], TOUCH),
    ("SYN_D_emerg-2", 7, "R_I4"): ([9, 10, *range(13, 20)], SINGLE),
}
MEASURED: Listed = {
    ("USA_US101-15_1_T-1+signs", 438, "R_I2"): ([55, 59], f"59: {CONTACT}; 55: {STATION}"),
    ("USA_US101-5_1_T-1", 445, "R_I2"): ([48], STATION),
    ("USA_US101-5_1_T-1", 464, "R_G1"): ([18, 19], HEADING),
}
LISTED = {"stored": STORED, "measured": {**STORED, **MEASURED}}

PAIRS = [(scene, place) for scene in range(19) for place in range(4)]
#: The share of every day, by place of the scene and of its run: one of each kind, and one in which something is listed.
DAILY = {(5, 0), (9, 1), (18, 0)}
IN_PYTHON = {(5, 0, "stored"), (9, 1, "measured")}
SHARE = [
    pytest.param(*pair, marks=[] if pair in DAILY else [pytest.mark.acceptance], id=f"{pair[0]}-{pair[1]}")
    for pair in PAIRS
]


@cache
def spec(folder: Path) -> Spec:
    """The rulebook, with room for its relations in generated C."""
    limits = folder / "supervisor" / "limits.spec"
    limits.parent.mkdir(exist_ok=True)
    limits.write_text("module supervisor.limits\nparam elements : 1 = 256 in [2, 100000]\n", "utf-8")
    return load([SPECS, limits])


@pytest.fixture(scope="module")
def evaluator(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Evaluator]:
    folder = tmp_path_factory.mktemp("interstate")
    return cache(lambda backend, rules=RULES: Evaluator(spec(folder), list(rules), backend=backend))


def pair(scene: int, place: int) -> tuple[Scene, Scene]:
    """A scene, and what the oracle says of one ego in it; the test is skipped where there are fewer."""
    one = scenes()[scene]
    if place >= len(one["verdicts"]):
        pytest.skip("this scene has fewer runs")
    return one, one["verdicts"][place]


@lru_cache(16)  # as many as every day has: two tests ask for each
def taken(source: str, scene: int, place: int) -> list[Cycle]:
    """The cycles of one run."""
    one, wanted = pair(scene, place)
    return SOURCES[source](one, wanted["ego"], wanted["t0"], wanted["n"])


def decided(judge: Evaluator, taken: list[Cycle]) -> dict[str, list[str]]:
    """By rule and cycle, what was decided of it in the end."""
    run, found = judge.over_run(), {rule.name: [""] * len(taken) for rule in judge.rules}

    def say(rule: str, about: About) -> None:
        assert isinstance(about.cycle, int)
        found[rule][about.cycle] = about.verdict

    for k, one in enumerate(taken):
        result = run.step(judge.read(one))
        assert not result.faults
        for rule, said in result.rules.items():
            for about in said.about:
                say(rule, about)
            if not said.about:
                found[rule][k] = said.verdict
    for rule, abouts in run.end().items():
        for about in abouts:
            say(rule, about)
    return found


def differing(found: dict[str, list[str]], wanted: Scene) -> dict[str, list[int]]:
    """By rule, the cycles in which we say something else than the monitor."""
    told = {rule: [HOLDS[verdict] for verdict in verdicts] for rule, verdicts in found.items()}
    return {
        rule: [k for k, (own, other) in enumerate(zip(each, wanted["rules"][rule]["truth"], strict=True)) if own != other]
        for rule, each in told.items()
    }  # fmt: skip


def listed(source: str, scene: Scene, wanted: Scene, rules: tuple[str, ...]) -> dict[str, list[int]]:
    nothing: tuple[list[int], str] = ([], "")
    return {rule: LISTED[source].get((scene["name"], wanted["ego"], rule), nothing)[0] for rule in rules}


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize(("scene", "place"), SHARE)
def test_all_rules_online_in_c(
    evaluator: Callable[..., Evaluator], scene: int, place: int, source: str
) -> None:
    one, wanted = pair(scene, place)
    found = decided(evaluator("c", (*RULES, "complete")), taken(source, scene, place))
    assert set(found.pop("complete")) == {"satisfied"}
    assert differing(found, wanted) == listed(source, one, wanted, RULES)


@pytest.mark.parametrize(
    ("scene", "place", "source"),
    [
        pytest.param(*pair, source, marks=[] if (*pair, source) in IN_PYTHON else [pytest.mark.acceptance])
        for pair in PAIRS
        for source in SOURCES
        if source == "stored" or pair[1] == 0 or pair in DAILY
    ],
)
def test_all_rules_in_python(
    evaluator: Callable[..., Evaluator], scene: int, place: int, source: str
) -> None:
    """With the inputs fitting together in every cycle; of what is measured, one run of each scene."""
    one, wanted = pair(scene, place)
    found = decided(evaluator("numpy", (*RULES, "complete")), taken(source, scene, place))
    assert set(found.pop("complete")) == {"satisfied"}
    assert differing(found, wanted) == listed(source, one, wanted, RULES)


@pytest.mark.parametrize("scene", [15, pytest.param(6, marks=pytest.mark.acceptance)])
def test_the_reference_says_the_same_to_the_bit(evaluator: Callable[..., Evaluator], scene: int) -> None:
    one, wanted = pair(scene, 0)
    said: dict[str, list[list[tuple[str, str]]]] = {}
    for backend in ("reference", "numpy"):
        judge = evaluator(backend)
        run = judge.over_run()
        said[backend] = [
            [(rule.verdict, float(rule.margin).hex()) for rule in run.step(judge.read(each)).rules.values()]
            for each in measured(one, wanted["ego"], wanted["t0"], 3)
        ]
    assert said["reference"] == said["numpy"]


def test_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`eval --run`: lines of JSON in, lines of JSON out."""
    one, wanted = pair(12, 0)
    data = tmp_path / "cycles.jsonl"
    taken = measured(one, wanted["ego"], wanted["t0"], wanted["n"])
    data.write_text("".join(json.dumps(each) + "\n" for each in taken), "utf-8")
    main(
        [
            "eval",
            str(SPECS),
            "--run",
            "--data",
            str(data),
            "--rule",
            "R_I5",
            "--rule",
            "R_G3",
            "--format",
            "jsonl",
        ]
    )
    said: dict[str, dict[int, str]] = {"R_I5": {}, "R_G3": {}}
    for line in map(json.loads, capsys.readouterr().out.splitlines()):
        for rule, verdict in line.get("rules", {}).items():
            for about in verdict.get("about", [{"cycle": line.get("id"), **verdict}]):
                said[rule][about["cycle"]] = HOLDS.get(about["verdict"], "?")
    for rule, told in said.items():
        assert "".join(told[k] for k in range(len(taken))) == wanted["rules"][rule]["truth"]


def test_what_is_listed_is_about_these_runs() -> None:
    """Every entry is of a run that is there, in cycles that it has; and of each source, no more than this."""
    runs = {(scene["name"], one["ego"]): one for scene in scenes() for one in scene["verdicts"]}
    assert sum(one["n"] for one in runs.values()) * len(RULES) == 30_663
    counts = Counter[str]()
    for source, entries in LISTED.items():
        for (scene, ego, rule), (cycles_, reason) in entries.items():
            assert reason
            assert rule in RULES
            assert cycles_ == sorted(set(cycles_))
            assert set(cycles_) <= set(range(runs[scene, ego]["n"]))
            counts[source] += len(cycles_)
    assert counts == {"stored": 47, "measured": 51}
