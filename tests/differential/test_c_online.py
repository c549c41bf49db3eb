"""Rules judged a sample at a time in generated C against the same rules judged with the whole timeline at hand, by the reference."""

from __future__ import annotations

import ctypes
import math
import random
import struct
from functools import cache
from typing import Any

import numpy as np
import pytest

from support.agreement import compiled
from trackmarshal.backends.c.build import compiler, library
from trackmarshal.backends.c.functions.online import obstacle
from trackmarshal.backends.c.monitoring import Monitors
from trackmarshal.backends.c.report import context_bytes
from trackmarshal.backends.c.source import generate
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

HEAD = "module online\nsignal log : series { t: s increasing, p: 1, q: 1, hot: bool }\n"
FUTURE = ("[0 s, 0 s]", "[0 s, 1 s]", "[0.3 s, 2 s]", "[1.5 s, 1.5 s]", "[2 s, 7 s]", "[5 s, 9 s]")
PAST = ("", *FUTURE)
WRAPS = (
    "{}",
    "always ({} or p.hot)",
    "eventually ({} and p.q > 1)",
    "historically[0.2 s, 3 s] ({} xor p.p > 0)",
    "(next ({}) implies eventually[0.5 s, 2 s] ({}))",
)
NESTED = (
    "rising(p.p > 0)",
    "falling(p.p > 0)",
    "(next (p.p > 0))",
    "(weak next p.hot)",
    "(previous p.hot)",
    "(weak previous (p.q > p.p))",
    "always[0 s, 1 s] ((p.p > 0) implies eventually[0.2 s, 1 s] ((p.q > 0) since[0 s, 2 s] p.hot))",
    "(once (p.p > 1) iff (rising(p.hot) until[0.3 s, 4 s] falling(p.q > 0)))",
    "(p.p > 0 and not p.hot)",
)


def formulas() -> list[str]:
    found = [*NESTED]
    for window in FUTURE:
        found += [f"{op}{window} (p.p > 0)" for op in ("always", "eventually")]
        found += [f"((p.p > -1) until{window} (p.q > 0.5))"]
    for window in PAST:
        found += [f"{op}{window} (p.p > 0)" for op in ("historically", "once")]
        found += [f"((p.p > -1) since{window} (p.q > 0.5))"]
    wraps = [(WRAPS[0], WRAPS[1 + i % (len(WRAPS) - 1)]) for i in range(len(found))]
    return [wrap.replace("{}", formula) for formula, pair in zip(found, wraps) for wrap in pair]


@cache
def evaluator() -> Evaluator:
    rules = [
        f'rule r{i} "made up"\n  along log as p\n  require {text}\n' for i, text in enumerate(formulas())
    ]
    return Evaluator(compiled(HEAD + "\n".join(rules)), None, "reference")


def timeline(seed: int) -> dict[str, list[Any]]:
    r = random.Random(seed)
    count = r.choice([1, 2, 3, 20, 60, 100])
    times = [r.uniform(-5.0, 5.0)]
    while len(times) < count:
        times.append(times[-1] + r.choice([0.1, 0.1, 0.3, 1.0, 0.05, 4.0 if seed % 5 == 0 else 0.1]))
    ties = r.random() < 0.5
    p, q = ([float(r.randint(-2, 2)) if ties else r.gauss(0, 1) for _ in times] for _ in "pq")
    hot: list[bool | None] = [r.random() < 0.2 for _ in times]
    for _ in range(r.choice([0, 0, 1, count // 2])):
        r.choice([p, q])[r.randrange(count)] = r.choice([math.nan, math.inf])
        hot[r.randrange(count)] = None
    return {"t": times, "p": p, "q": q, "hot": hot}


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def columns(log: dict[str, list[Any]]) -> dict[str, Any]:
    flags = np.array([-1 if value is None else int(value) for value in log["hot"]], dtype=np.int8)
    return {name: np.array(log[name], dtype=float) for name in "tpq"} | {"hot": flags}


def test_every_sample_has_the_value_that_the_whole_timeline_gives_it() -> None:
    rules = evaluator().rules
    monitors = Monitors(evaluator().spec, rules, 256)
    assert set(monitors.names) == {rule.name for rule in rules}
    logs = [timeline(seed) for seed in range(9)]
    cases = [evaluator().read({"signals": {"log": log}}) for log in logs]
    found, compared = [], 0
    for log, case, expected in zip(logs, cases, evaluator().evaluate(cases, True), strict=True):
        given = columns(log) | {name: np.array(case.columns["log"].column(name)) for name in "pq"}
        for rule in rules:
            outcomes, whole = monitors.run(rule.name, given)
            wanted = expected.rules[rule.name]
            assert wanted.series is not None
            top = _top_operand(rule.name)
            if top is None:
                verdicts, margins = wanted.series
                got = [("satisfied", "violated", "undefined")[v] for v in outcomes["verdict"]]
                if got != verdicts or list(map(bits, outcomes["margin"])) != list(map(bits, margins)):
                    found.append(f"{rule.name} {formulas()[int(rule.name[1:])]}")
                compared += len(margins)
            if (whole[0], bits(whole[1])) != (wanted.verdict, bits(wanted.margin)):
                found.append(
                    f"{rule.name} {formulas()[int(rule.name[1:])]}: {whole} | {wanted.verdict} {wanted.margin}"
                )
    assert not found, found[:5]
    assert compared > 10_000


def _top_operand(name: str) -> str | None:
    """The operator over all of the timeline; a monitor's samples then have the values of what stands in it."""
    text = formulas()[int(name[1:])]
    return next((op for op in ("always", "eventually") if text.startswith(f"{op} (")), None)


def test_windows_are_of_whole_nanoseconds() -> None:
    """0.1 s after 0.7 s is 0.8 s, whichever of the doubles near it stands there; times that are infinite in nanoseconds stand at one place."""
    spec = compiled(
        HEAD
        + 'rule ahead "made up"\n  along log as p\n  require eventually[100 ms, 100 ms] (p.p > 0)\n'
        + 'rule back "made up"\n  along log as p\n  require once[100 ms, 100 ms] (p.p > 0)\n'
        + 'rule here "made up"\n  along log as p\n  require eventually[0 ms, 0 ms] (p.p > 0)\n'
    )
    monitors = Monitors(spec, spec.rules, 64)

    def held(name: str, t: list[float], p: list[float]) -> list[bool]:
        return [
            bool(code == 0) for code in monitors.run(name, {"t": np.array(t), "p": np.array(p)})[0]["verdict"]
        ]

    t = [0.7, 0.7 + 0.1, 0.8 + 2e-10, 0.9]
    assert t[1] < 0.8
    assert (
        held("ahead", t, [0.0, 1.0, 0.0, 0.0])
        == held("ahead", t, [0.0, 0.0, 1.0, 0.0])
        == [True, False, False, False]
    )
    assert held("back", t, [1.0, 0.0, 0.0, 0.0]) == [False, True, True, False]
    assert held("here", t, [0.0, 0.0, 1.0, 0.0]) == [False, True, True, False]
    assert held("here", [-1.7e308, -1e305, 0.0, 1.7e308], [0.0, 1.0, 0.0, 0.0]) == [True, True, False, False]


def test_samples_beyond_the_capacity_are_refused_not_guessed() -> None:
    spec = compiled(HEAD + 'rule r "made up"\n  along log as p\n  require always[0 s, 10 s] (p.p > 0)\n')
    rules = Evaluator(spec, None, "reference").rules
    log = {"t": np.arange(200) * 0.1, "p": np.ones(200)}
    assert Monitors(spec, rules, 128).run("r", log)[1] == ("satisfied", 1.0)
    with pytest.raises(TrackmarshalError, match="E473"):
        Monitors(spec, rules, 64).run("r", log)
    with pytest.raises(TrackmarshalError, match="E473"):
        Monitors(spec, rules, 128).run(
            "r", log | {"t": np.concatenate([np.arange(50), np.arange(150)]) * 0.1}
        )


def signs(text: str) -> Any:
    """A number a sample, by its sign."""
    return np.array([1.0 if one == "+" else -1.0 for one in text])


@pytest.mark.parametrize(
    ("operator", "p", "q", "expected"),
    [
        # Between where a window begins and where q holds, p fails; what is new in the window is put together by itself.
        ("until", "++++-+++", "------+-", "-----++-"),
        ("until", "++++++++", "----+---", "-++++---"),
        ("since", "+-+-+-++++", "++--+-----", "+++-+-----"),
        ("since", "+++-++++++", "++--------", "+++-------"),
    ],
)
def test_what_fails_on_the_way_is_on_the_way_of_all_that_is_beyond_it(
    operator: str, p: str, q: str, expected: str
) -> None:
    """By hand: in windows of 3 s, samples a second, of which each leaves as another one comes."""
    rules = "".join(
        f'rule all_{op} "made up"\n  along log as p\n  require (p.p > 0) {op}[0 s, 3 s] (p.q > 0)\n'
        for op in ("until", "since")
    )
    spec = compiled(HEAD + rules)
    log = {"t": np.arange(len(p)) * 1.0, "p": signs(p), "q": signs(q)}
    outcomes, _ = Monitors(spec, spec.rules, 64).run(f"all_{operator}", log)
    assert outcomes["margin"].tolist() == signs(expected).tolist()
    assert (outcomes["verdict"] == 0).tolist() == (signs(expected) > 0).tolist()


@pytest.mark.parametrize(("window", "fits"), [("[0 s, 10 s]", False), ("", True)])
def test_what_a_window_back_still_asks_for_is_not_overwritten(window: str, fits: bool) -> None:
    """Of 100 samples in 10 s, in a ring of 64, more are refused; without a beginning, none is asked for again."""
    texts = (
        f"historically{window} (p.p > 0)",
        f"once{window} (p.p < 0)",
        f"(p.p > -9) since{window} (p.p < 0)",
    )
    rules = "".join(
        f'rule r{i} "made up"\n  along log as p\n  require {text}\n' for i, text in enumerate(texts)
    )
    spec, p = compiled(HEAD + rules), np.where(np.arange(200) == 3, -1.0, 1.0)
    monitors = Monitors(spec, spec.rules, 64)
    for name, holds in (("r0", np.arange(200) < 3), ("r1", np.arange(200) >= 3), ("r2", np.arange(200) >= 3)):
        log = {"t": np.arange(200) * 0.1, "p": p}
        if fits:
            assert (monitors.run(name, log)[0]["verdict"] == 0).tolist() == holds.tolist()
        else:
            with pytest.raises(TrackmarshalError, match="E473"):
                monitors.run(name, log)


def test_memory_does_not_grow_with_the_timeline() -> None:
    """A window of 30 samples in a ring of 64, over 20,000 samples."""
    spec = compiled(
        HEAD
        + 'rule r "made up"\n  along log as p\n  require eventually[0 s, 3 s] ((p.p > 1) since[0 s, 2 s] (p.q > 1))\n'
    )
    made = Evaluator(spec, None, "numpy")
    rng = np.random.default_rng(1)
    log = {"t": np.arange(20_000) * 0.1, "p": rng.normal(size=20_000), "q": rng.normal(size=20_000)}
    outcomes, _ = Monitors(spec, made.rules, 64).run("r", log)
    raw = {name: column.tolist() for name, column in log.items()}
    series = next(iter(made.evaluate([made.read({"signals": {"log": raw}})], True))).rules["r"].series
    assert series is not None
    assert outcomes["margin"].tolist() == series[1]


def test_the_report_says_what_a_context_and_a_monitor_take() -> None:
    """By the header alone, as a program around the generated code sees it: that is what the code itself takes."""
    made = generate(evaluator().spec, evaluator().rules[:3], online=True)
    dll = ctypes.CDLL(str(library(made, {})))
    assert context_bytes(made) == (dll.tmg_size(), [dll.tmg_online_size(each) for each in range(3)])


def test_a_sample_before_or_after_takes_no_more_room_with_every_sample() -> None:
    """A monitor that asks for the one before went undefined with the sample that filled its memory, however old the others were."""
    texts = ("rising(p.hot)", "(next (p.p > 0))", "once[0 s, 0.2 s] (weak previous (p.p > 0))")
    rules = "".join(
        f'rule r{i} "made up"\n  along log as p\n  require {text}\n' for i, text in enumerate(texts)
    )
    spec, n = compiled(HEAD + rules), 100
    p = np.where(np.arange(n) % 7 < 3, 1.0, -1.0)
    log = {"t": np.arange(n) * 0.1, "p": p, "hot": (p > 0).astype(np.int8)}
    before, after = np.roll(p, 1) > 0, np.roll(p, -1) > 0
    before[0], after[-1] = False, False
    lately = before | np.roll(before, 1) | np.roll(before, 2)
    lately[:3] = True  # nothing is before the first, which is weak
    wanted = [(p > 0) & ~before, after, lately]
    monitors = Monitors(spec, spec.rules, 16)
    for i, holds in enumerate(wanted):
        verdicts = monitors.run(f"r{i}", log)[0]["verdict"]
        assert (verdicts == 0).tolist() == holds.tolist(), texts[i]


@pytest.mark.parametrize(
    ("formula", "why"),
    [("p.p > 0 and eventually (p.q > 0)", "upper bound"), ("p.p > log.first.p", "present sample"),
     ("for all r in log: (r.p > 0)", "present sample")],
)  # fmt: skip
def test_what_a_sample_at_a_time_cannot_say_is_named(formula: str, why: str) -> None:
    spec = compiled(HEAD + f'rule r "made up"\n  along log as p\n  require {formula}\n')
    assert why in str(obstacle(spec.rules[0]))
    assert Monitors(spec, spec.rules).names == ()
