"""Formulas over the run at random, and runs at random: objects that come and go, gaps, numbers that are missing."""

from __future__ import annotations

from functools import cache
from typing import Any

from hypothesis import strategies as st

SIGNALS = """module m
enum shade { green, yellow, red }
signal ego : state { v: m/s, w: m/s, seen: shade default green, on: bool default true }
signal objects : set of object { v: m/s, seen: shade default red }
event flag
"""
_PAST = ("once", "historically")
_AHEAD = ("eventually", "always")
_BOUNDS = st.tuples(st.integers(0, 8), st.integers(0, 12)).map(lambda ab: (ab[0] / 10, (ab[0] + ab[1]) / 10))

_COMPARED = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
_LAST = st.integers(0, 12).map(lambda tenths: tenths / 10)


def _window(bounds: tuple[float, float]) -> str:
    return f"[{bounds[0]!r} s, {bounds[1]!r} s]"


def _leaf(inside: bool) -> st.SearchStrategy[str]:
    leaves = [
        "ego.v > 0 m/s", "ego.w <= 1 m/s", "flag", "ego.v >= ego.w", "ego.seen is yellow", "ego.on",
        "case ego.seen { green: ego.v > 0 m/s, else: flag }",
        "ego.v <= case ego.seen { green, red: 1 m/s, yellow: ego.w }",
    ]  # fmt: skip
    own = ["o.v > 0 m/s", "o.v <= ego.v", "o.seen is red", "o.seen is ego.seen"]
    return st.sampled_from([*leaves, *(own * 3 if inside else [])])


@cache
def formulas(inside: bool = False, ahead: bool = True, depth: int = 3) -> st.SearchStrategy[str]:
    """A formula as text; with the variable `o` where it is `inside` of a quantifier."""
    if depth == 0:
        return _leaf(inside)
    one = formulas(inside, ahead, depth - 1)
    windows = _BOUNDS.map(_window)
    kinds = [
        _leaf(inside),
        one.map(lambda p: f"(not {p})"),
        st.builds(
            lambda op, p, q: f"({p} {op} {q})",
            st.sampled_from(["and", "or", "implies", "iff", "xor"]),
            one,
            one,
        ),
        st.builds(lambda op, w, p: f"({op}{w} {p})", st.sampled_from(_PAST), windows | st.just(""), one),
        st.builds(lambda w, p, q: f"({p} since{w} {q})", windows | st.just(""), one, one),
        st.builds(lambda op, p: f"({op} {p})", st.sampled_from(["previous", "weak previous"]), one),
        st.builds(lambda op, p: f"{op}({p})", st.sampled_from(["rising", "falling"]), one),
    ]
    back = formulas(inside, False, depth - 1)
    kinds += [
        st.builds(lambda p, op, n: f"(count({p}) {op} {n})", back, _COMPARED, st.integers(0, 4)),
        st.builds(
            lambda p, b, op, n: f"({n} {op} count({p}, last: {b!r} s))",
            one,
            _LAST,
            _COMPARED,
            st.integers(0, 4),
        ),
        st.builds(
            lambda p, q, op, n: f"(count({p}, reset: {q}) {op} {n})", back, back, _COMPARED, st.integers(0, 4)
        ),
    ]
    if ahead:
        kinds += [
            st.builds(lambda op, w, p: f"({op}{w} {p})", st.sampled_from(_AHEAD), windows, one),
            st.builds(lambda w, p, q: f"({p} until{w} {q})", windows, one, one),
            st.builds(lambda op, p: f"({op} {p})", st.sampled_from(["next", "weak next"]), one),
        ]
    if not inside:
        body = formulas(True, ahead, depth - 1)
        kinds += [
            st.builds(lambda q, p: f"({q} o in objects: {p})", st.sampled_from(["for all", "exists"]), body),
            st.builds(
                lambda q, g, p: f"({q} o in objects where {g}: {p})",
                st.sampled_from(["for all", "exists"]),
                body,
                body,
            ),
        ]
    return st.one_of(kinds)


_STEPS = st.sampled_from([0.1, 0.1, 0.1, 0.2, 0.4])
_FLAGS = st.sampled_from([True, False, None])
_THERE = st.lists(st.sampled_from("abc"), unique=True)
_NUMBERS = st.sampled_from([-2.0, -1.0, 0.0, 0.5, 1.0, 2.0, None])


#: Names, places, nothing, and what is no member, which is the same to all but never safe; "": it is left out.
_SEEN = st.sampled_from(["green", "yellow", "red", "yellow", 0, 1.0, 2, None, "", 1.5, -1, 99])
_CYCLE = st.tuples(
    _STEPS, st.integers(0, 6), _THERE, _NUMBERS, _NUMBERS, st.tuples(_NUMBERS, _NUMBERS, _NUMBERS), _FLAGS,
    st.tuples(_SEEN, _SEEN, _SEEN, _SEEN),
)  # fmt: skip


def runs() -> st.SearchStrategy[list[dict[str, Any] | None]]:
    """Cycles as cases; None: one that is refused."""
    return st.lists(_CYCLE, min_size=1, max_size=14).map(_cycles)


def _cycles(drawn: list[Any]) -> list[dict[str, Any] | None]:
    t, cycles = 0.0, list[dict[str, Any] | None]()
    for number, (step, refused, there, v, w, speeds, flag, seen) in enumerate(drawn):
        t += step
        signals = {
            "ego": {"v": v, "w": w} | ({} if seen[0] == "" else {"seen": seen[0], "on": flag}),
            "objects": {"id": there, "v": list(speeds[: len(there)])},
            "flag": flag,
        }
        if "" not in seen[1:]:
            signals["objects"]["seen"] = list(seen[1 : 1 + len(there)])
        cycles.append({"id": number, "t": round(t, 9), "signals": signals} if refused else None)
    return cycles
