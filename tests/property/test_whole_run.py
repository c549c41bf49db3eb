"""Rules over the run on many cycles at once say in every cycle what they say cycle by cycle, however the run is cut into pieces."""

from __future__ import annotations

import pickle
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from property.test_over_run import EXAMPLES, exact, loaded, rule, said
from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runs import Frames
from trackmarshal.runtime.verdict import VERDICTS, CaseResult

CUTS = st.lists(st.integers(1, 6), max_size=14)
#: Formulas about no elements of sets: what goes along the cycles.
_LEAVES = ["ego.v > 0 m/s", "ego.w <= 1 m/s", "flag", "ego.v >= ego.w", "ego.seen is yellow", "ego.on"]
_BOUNDS = st.tuples(st.integers(0, 8), st.integers(0, 12)).map(
    lambda ab: f"[{ab[0] / 10!r} s, {sum(ab) / 10!r} s]"
)


def _connected(one: st.SearchStrategy[str]) -> list[st.SearchStrategy[str]]:
    return [
        one.map(lambda p: f"(not {p})"),
        st.builds(
            lambda op, p, q: f"({p} {op} {q})",
            st.sampled_from(["and", "or", "implies", "iff", "xor"]),
            one,
            one,
        ),
    ]


def back(depth: int) -> st.SearchStrategy[str]:
    """Formulas that look back."""
    if depth == 0:
        return st.sampled_from(_LEAVES)
    one, maybe = back(depth - 1), _BOUNDS | st.just("")
    compared, number = st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), st.integers(0, 4)
    return st.one_of(
        st.sampled_from(_LEAVES),
        *_connected(one),
        st.builds(lambda op, w, p: f"({op}{w} {p})", st.sampled_from(["once", "historically"]), maybe, one),
        st.builds(lambda w, p, q: f"({p} since{w} {q})", maybe, one, one),
        st.builds(lambda op, p: f"({op} {p})", st.sampled_from(["previous", "weak previous"]), one),
        st.builds(lambda op, p: f"{op}({p})", st.sampled_from(["rising", "falling"]), one),
        st.builds(lambda p, op, n: f"(count({p}) {op} {n})", one, compared, number),
        st.builds(lambda p, b, op, n: f"({n} {op} count({p}, last: {b / 10!r} s))", one, number, compared, number),
        st.builds(lambda p, q, op, n: f"(count({p}, reset: {q}) {op} {n})", one, one, compared, number),
    )  # fmt: skip


def ahead(depth: int) -> st.SearchStrategy[str]:
    """Formulas that look ahead from the present cycle."""
    one = back(1)
    if depth == 0:
        return st.one_of(
            st.builds(lambda op, w, p: f"({op}{w} {p})", st.sampled_from(["eventually", "always"]), _BOUNDS, one),
            st.builds(lambda w, p, q: f"({p} until{w} {q})", _BOUNDS, one, one),
            st.builds(lambda op, p: f"({op} {p})", st.sampled_from(["next", "weak next"]), one),
            one,
        )  # fmt: skip
    return st.one_of(ahead(0), *_connected(ahead(depth - 1)))


def at_once(text: str, cycles: list[dict[str, Any] | None], cuts: list[int]) -> list[Any]:
    """What `said` gives, of frames in pieces."""
    evaluator = Evaluator(loaded(text))
    run, found = Frames(evaluator), list[Any]()
    missing = TrackmarshalError("D101", "no cycle")
    given = [missing if cycle is None else evaluator.read(cycle) for cycle in cycles]
    for size in (*cuts, len(given)):
        piece, given = given[:size], given[size:]
        for result in run.step(piece):
            if isinstance(result, CaseResult):
                one = result.rules["f"]
                found.append((one.verdict, exact(one.margin), [_about(each) for each in one.about]))
    found.append({name: [_about(one) for one in each] for name, each in run.end().items()})
    return found


def _about(one: Any) -> Any:
    return one.cycle, one.verdict, exact(one.margin), one.final


def same(text: str, cycles: list[dict[str, Any] | None], cuts: list[int]) -> None:
    found, given = at_once(text, cycles, cuts), pickle.dumps(cycles)
    assert found == _each(text, "numpy", given)
    assert found == _each(text, "reference", given)


@lru_cache(4)  # of cycles that are cut in several ways
def _each(text: str, backend: str, cycles: bytes) -> Any:
    """What is said of them one by one, which no cut changes."""
    return said(text, backend, pickle.loads(cycles))


@given(back(3), runs(), CUTS)
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_what_looks_back(formula: str, cycles: list[dict[str, Any] | None], cuts: list[int]) -> None:
    same(rule(f"require {formula}"), cycles, cuts)


@given(ahead(2), runs(), CUTS)
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_what_looks_ahead(formula: str, cycles: list[dict[str, Any] | None], cuts: list[int]) -> None:
    same(rule(f"require {formula}"), cycles, cuts)


@given(back(1), ahead(1), st.booleans(), runs(), CUTS)
@settings(max_examples=2 * EXAMPLES, deadline=None)
def test_with_a_condition(
    whenever: str, formula: str, within: bool, cycles: list[dict[str, Any] | None], cuts: list[int]
) -> None:
    deadline = "within 0.3 s\n  " if within else ""
    same(rule(f"whenever {whenever}\n  {deadline}require {formula}"), cycles, cuts)


@given(formulas(), runs(), CUTS)
@settings(max_examples=EXAMPLES, deadline=None)
def test_whatever_the_formula(formula: str, cycles: list[dict[str, Any] | None], cuts: list[int]) -> None:
    same(rule(f"require {formula}"), cycles, cuts)


_NUMBER = st.sampled_from([-2.0, -1.0, 0.0, 0.5, 1.0, 2.0, -2.0, 1.0, float("nan"), float("inf")])
_ROWS = st.lists(
    st.tuples(_NUMBER, _NUMBER, st.sampled_from([True, False, None, True]), st.sampled_from([0, 0, 0, 1, 3]), st.sampled_from([1, 1, 1, 2, 4])),
    min_size=1, max_size=20,
)  # fmt: skip


@given(ahead(1) | back(2), _ROWS, CUTS, st.booleans())
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_arrays_are_the_same_as_cycles(formula: str, rows: list[Any], cuts: list[int], clean: bool) -> None:
    if clean:
        rows = [(*(x if abs(x) < 9 else 0.5 for x in row[:2]), bool(row[2]), *row[3:]) for row in rows]
    text = rule(f"require {formula}") + 'rule g "x"\n  require ego.v <= 1 m/s or flag\n'
    evaluator = Evaluator(loads(text))
    stepped, whole = evaluator.over_run(), evaluator.whole_run()
    stamps = np.cumsum([row[4] * 100_000_000 for row in rows]).astype(np.int64)
    wanted: dict[str, list[Any]] = {"f": [], "g": []}
    safe, abouts = [], list[Any]()
    for number, (stamp, row) in enumerate(zip(stamps.tolist(), rows)):
        for _ in range(row[3]):
            stepped.missed()
        signals = {"ego": {"v": row[0], "w": row[1], "on": True}, "flag": row[2]}
        result = stepped.step(evaluator.read({"id": number, "t": stamp / 1e9, "signals": signals}))
        safe.append(result.safe)
        for name, found in wanted.items():
            found.append((result.rules[name].verdict, exact(result.rules[name].margin)))
        abouts += [(number, *_about(one)) for one in result.rules["f"].about]
    begin, got, got_safe, got_abouts = 0, {"f": list[Any](), "g": list[Any]()}, [], list[Any]()
    for size in (*cuts, len(rows)):
        part = rows[begin : begin + size]
        if not part:
            continue
        signals = {
            "ego": {"v": np.array([row[0] for row in part]), "w": np.array([row[1] for row in part])},
            "flag": np.array([row[2] for row in part], dtype=object),
        }
        missed = np.array([row[3] for row in part])
        piece = whole.step(stamps[begin : begin + size], signals, {}, missed)
        begin += len(part)
        got_safe += piece.safe.tolist()
        for name, found in got.items():
            found += zip(piece.verdicts[name].tolist(), map(exact, piece.margins[name].tolist()))
        of = piece.about("f")
        got_abouts += [
            (cycle, about, VERDICTS[code], exact(margin), final)
            for cycle, about, code, margin, final in zip(*(each.tolist() for each in (of.cycle, of.about, of.codes, of.margins, of.final)))
        ]  # fmt: skip
    assert got == wanted
    assert got_safe == safe
    if evaluator.spec.rules[0].name == "f" and abouts:
        assert got_abouts == abouts
    end = {name: [_about(one) for one in each] for name, each in stepped.end().items()}
    assert {name: [_about(one) for _, one in each.listed()] for name, each in whole.end().items()} == end


def test_which_go_cycle_by_cycle() -> None:
    spec = loads(
        SIGNALS + 'rule a "" require once[0 s, 1 s] flag\n'
        'rule b "" for all o in objects require once[0 s, 1 s] o.v > 1 m/s\n'
        'rule c "" require once[0 s, 1 s] eventually[0 s, 1 s] flag\n'
        "signal plan : trajectory { t: s increasing, v: m/s }\ncourse lived = ego for 1 s then plan\n"
        'rule d "" along lived as c require historically[0 s, 1 s] c.v <= 1 m/s\n'
    )
    assert Evaluator(spec).whole_run().by_cycle == {
        "b": "it has a history for each element of a set",
        "c": "it looks ahead from other cycles than the present one",
        "d": "it lives along a course",
    }


@pytest.mark.parametrize(
    ("t", "code"), [([0.0, 1.0], "D206"), ([0, 0], "D206"), ([2, 1], "D206"), ([1], "D205"), ([], "D206")]
)
def test_what_stamps_are_not(t: list[Any], code: str) -> None:
    run = Evaluator(loads(rule("require once[0 s, 1 s] ego.v > 0 m/s"))).whole_run()
    with pytest.raises(TrackmarshalError) as error:
        run.step(np.array(t), {"ego": {"v": np.array([1.0, 2.0])}})
    assert error.value.code == code
