"""Shapes of one's own: whatever has their fields fits, and definitions read numbers, Booleans and members through them."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.evaluation import Evaluator, load, loads
from trackmarshal.semantics.compile import compile_text

BACKENDS = ("reference", "numpy", "c")
SPEC = """module made

enum flag { green, yellow, red }

shape marked "whatever has a flag" = { flag: flag }
shape car = vehicle with { lane: 1, braking: bool }
shape racing = car with { flag: flag, d: m }

signal ego : state { x: m, y: m, heading: rad, v: m/s, length: m, width: m, lane: 1, braking: bool, flag: flag, d: m }
signal cars : set of object { d: m, flag: flag, x: m, y: m, heading: rad, v: m/s, length: m, width: m, braking: bool, lane: 1 }

define bound(o: marked) -> m/s = case o.flag { green: 80 m/s, yellow: 40 m/s, red: 0 m/s }
predicate slow(o: car) = o.braking or o.v < 10 m/s
predicate follows(o: racing, other: car) = o.lane == other.lane and not (o slower other)
predicate slower(a: moving, b: moving) = a.v < b.v
predicate held(o: racing) = o.flag is red or slow(o)

rule ours "Our own car keeps to its flag"
  require   ego.v <= bound(ego)

rule others "Whoever follows us slows down, or is held"
  allow     W301 because "lanes are numbers of lanes"
  for all   o in cars where follows(o, ego)
  require   slow(o) or held(o) or o.v <= bound(o)
"""


def element(v: float, lane: int, braking: bool, flag: str) -> dict[str, object]:
    return {
        "x": 0, "y": 0, "heading": 0, "v": v, "length": 4, "width": 2, "lane": lane, "braking": braking, "flag": flag, "d": 0,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("ego", "cars", "ours", "others"),
    [
        (element(30, 1, False, "yellow"), [], ("satisfied", 10.0), "inactive"),
        (element(41, 1, False, "yellow"), [element(50, 1, False, "yellow")], ("violated", -1.0), "violated"),
        (element(0, 1, False, "red"), [element(50, 1, True, "yellow")], ("satisfied", 0.0), "satisfied"),
        (element(0, 1, False, "red"), [element(50, 1, False, "red")], ("satisfied", 0.0), "satisfied"),
        (element(0, 1, False, "red"), [element(50, 2, False, "yellow")], ("satisfied", 0.0), "inactive"),
    ],
)  # fmt: skip
def test_fields_of_every_kind(
    ego: dict[str, object], cars: list[dict[str, object]], ours: tuple[str, float], others: str
) -> None:
    spec = loads(SPEC)
    for backend in BACKENDS:
        rules = Evaluator(spec, backend=backend).case({"signals": {"ego": ego, "cars": cars}}).rules
        assert (rules["ours"].verdict, rules["ours"].margin) == ours
        assert rules["others"].verdict == others


def test_it_means_what_it_means_written_out() -> None:
    """A shape is looked at when a spec is compiled, and is gone afterwards."""
    body = "{ x: m, v: m/s, braking: bool }"
    text = f"module made\n\nsignal ego : state {body}\n\nshape car = {body}\n\npredicate slow(o: car) = o.braking or o.v < 10 m/s\n"
    called, written = (
        loads(f'{text}\nrule r "r"\n  require   {demand}\n')
        for demand in ("slow(ego)", "ego.braking or ego.v < 10 m/s")
    )
    for v, braking in ((9.0, False), (10.0, False), (11.0, True)):
        case = {"signals": {"ego": {"x": 0, "v": v, "braking": braking}}}
        one, other = (Evaluator(spec).case(case).rules["r"] for spec in (called, written))
        assert (one.verdict, one.margin) == (other.verdict, other.margin)


def test_shapes_and_enumerations_of_other_modules(tmp_path: Path) -> None:
    (tmp_path / "shapes.spec").write_text(
        "module shapes\nenum flag { green, red }\nshape marked = { flag: flag }\nshape car = moving with { braking: bool }\n",
        "utf-8",
    )
    (tmp_path / "made.spec").write_text(
        "module made\nuse shapes\nsignal ego : state { x: m, y: m, heading: rad, v: m/s, braking: bool, flag: flag }\n"
        "shape both = car with { flag: flag }\npredicate stops(o: both) = o.braking and o.flag is red\n"
        'rule r "r"\n  require   stops(ego)\n',
        "utf-8",
    )
    spec = load([tmp_path / "made.spec"])
    for braking, flag, verdict in (
        (True, "red", "satisfied"),
        (True, "green", "violated"),
        (False, "red", "violated"),
    ):
        ego = {"x": 0, "y": 0, "heading": 0, "v": 0, "braking": braking, "flag": flag}
        assert Evaluator(spec).case({"signals": {"ego": ego}}).rules["r"].verdict == verdict


@pytest.mark.parametrize(
    ("fields", "fits"),
    [("v: m/s, a: bool", True), ("v: km/h, a: bool", True), ("v: m, a: bool", False), ("v: m/s, a: 1", False), ("v: m/s", False)],
)  # fmt: skip
def test_what_fits_has_the_fields_by_name_and_kind(fields: str, fits: bool) -> None:
    text = (
        f"module made\nsignal ego : state {{ {fields}, more: kg }}\nshape one = {{ v: m/s, a: bool }}\n"
        'predicate p(o: one) = o.a or o.v > 3 m/s\nrule r "r"\n  require   p(ego)\n'
    )
    assert [d.code for d in compile_text(text).errors] == ([] if fits else ["E211"])
