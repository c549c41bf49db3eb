"""What a definition comes to with the same arguments is made once: nobody may notice, but by the time that it takes."""

from __future__ import annotations

import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from support.shared import REPOSITORY
from trackmarshal import typed
from trackmarshal.evaluation import Evaluator
from trackmarshal.node import Node
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.semantics.expressions.sharing import Shared
from trackmarshal.source import Span

HEAD = """module made
signal ego : state { x: m, v: m/s, heading: rad }
signal objects : set of object { x: m, v: m/s, heading: rad }
define twice(v: m/s) -> m/s = v + v
"""


def compiled(folder: Path, content: str) -> Compiled:
    path = folder / "made.spec"
    path.write_text(HEAD + content, "utf-8")
    return compile_paths([path], folder)


def said(node: object, seen: dict[int, int]) -> Any:
    """All that a node holds, places in files included; of what is there twice, that it is the same."""
    if isinstance(node, Span):
        return str(node)
    if isinstance(node, tuple):
        return [said(one, seen) for one in node]
    if not isinstance(node, Node):
        return repr(node)
    if id(node) in seen:
        return seen[id(node)]
    seen[id(node)] = len(seen)
    return [type(node).__name__, *[said(getattr(node, name), seen) for name in node.fields]]


def cores(made: Compiled) -> dict[str, Any]:
    return {rule.name: said(rule.formula, {}) for rule in made.spec.rules}


def unshared(patch: pytest.MonkeyPatch) -> Counter[str]:
    """Nothing is the same as anything else; how often it was asked."""
    asked = Counter[str]()

    def own(self: Shared, value: Any) -> Any:
        asked[type(value).__name__] += 1
        return value

    patch.setattr(Shared, "argument", own)
    patch.setattr(Shared, "range", own)
    return asked


@pytest.mark.parametrize("shipped", ["supervisor", "rulebooks"])
def test_the_core_is_the_same_as_without(
    shipped: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From two folders: what is compiled from one is kept by the tests for whoever compiles it again."""
    made = []
    for name in ("with", "without"):
        folder = tmp_path / name
        shutil.copytree(REPOSITORY / "specs", folder / "specs", ignore=lambda at, names: [n for n in names if n.endswith((".gz", ".arrows", ".json", ".saa"))])  # fmt: skip
        with monkeypatch.context() as patch:
            asked = unshared(patch) if name == "without" else Counter[str]()
            made.append(compile_paths([folder / "specs" / shipped], folder))
    assert asked["Range"] > 10
    assert asked.total() > 100
    with_it, without = made
    assert len(with_it.spec.rules) > 5
    assert cores(with_it) == cores(without)
    assert [(d.code, str(d.span)) for d in with_it.found] == [(d.code, str(d.span)) for d in without.found]


def test_each_call_is_warned_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    content = (
        "define turned(o: rad) -> 1 = sin(o)\n"
        "rule one\n  require turned(3) + turned(3) <= ego.heading\n"
        'rule other\n  require turned(3) <= ego.heading\n  allow W302 because "it is about turns"\n'
    )
    found = compiled(tmp_path, content).found
    unshared(monkeypatch)
    again = compiled(tmp_path, content).found
    assert [(d.code, str(d.span)) for d in found] == [(d.code, str(d.span)) for d in again]
    assert [d.code for d in found] == ["W302"] * len(found)
    assert len(found) > 1


def test_each_difference_is_warned_of_where_it_stands(tmp_path: Path) -> None:
    """Not where it stood first, in a rule that may allow it."""
    content = (
        "predicate small(o: rad) = abs(o) <= 1 rad\n"
        "define same(o: rad) -> rad = o\n"
        'rule one\n  for all o in objects\n  require small(o.heading - ego.heading)\n  allow W310 because "none crosses it"\n'
        "rule two\n  for all o in objects\n  require small(o.heading - ego.heading)\n"
        "rule three\n  for all o in objects\n  require abs(same(o.heading - ego.heading)) <= 1 rad\n"
        "rule four\n  for all o in objects\n  require abs(same(o.heading - ego.heading)) <= 1 rad\n"
    )
    found = compiled(tmp_path, content).found
    assert [(d.code, d.span.line) for d in found] == [("W310", line) for line in (13, 16, 19)]


def test_the_same_words_about_something_else(tmp_path: Path) -> None:
    """Names of one rule are not those of another one, and an inner one is not the outer one."""
    content = (
        "rule one\n  let a = ego.v + 1 m/s\n  require twice(a) <= 9 m/s\n"
        "rule two\n  let a = ego.v + 2 m/s\n  require twice(a) <= 9 m/s\n"
        "rule three\n  for all o in objects\n  require twice(o.v) <= 9 m/s\n"
        "rule four\n  for all p in objects\n  for all o in objects\n  require twice(o.v) <= twice(p.v)\n"
        "rule again\n  let b = ego.v\n  require twice(b) <= 9 m/s\n"
        "rule and_again\n  let b = ego.v\n  require twice(b) <= 9 m/s\n"
        "rule five\n  require (for all o in objects: twice(o.v) <= 9 m/s) and (exists o in objects: twice(o.v) >= 3 m/s)\n"
    )
    made = compiled(tmp_path, content)
    assert [d.code for d in made.found] == []
    ego = {"x": 0.0, "v": 3.25, "heading": 0.0}
    objects = [{"x": 0.0, "v": 2.0, "heading": 0.0}, {"x": 0.0, "v": 4.0, "heading": 0.0}]
    for backend in ("reference", "numpy"):
        case = Evaluator(made.spec, None, backend).case({"signals": {"ego": ego, "objects": objects}})
        assert {name: result.margin for name, result in case.rules.items()} == {
            "one": 0.5, "two": -1.5, "three": 1.0, "four": -4.0, "again": 2.5, "and_again": 2.5, "five": 1.0,
        }  # fmt: skip


def test_the_same_call_along_nothing(tmp_path: Path) -> None:
    """A sample that is the same is along its timeline in one rule, and in the other one there is none."""
    content = (
        "signal plan : trajectory { t: s increasing, v: m/s }\n"
        "predicate soon(v: m/s) = eventually v <= 3 m/s\n"
        "rule one\n  along plan as p\n  require soon(p.v)\n"
        "rule two\n  for all p in plan\n  require soon(p.v)\n"
    )
    found = compiled(tmp_path, content).found
    assert [(d.code, d.span.line) for d in found] == [("E223", 12)]


def test_it_counts_as_often_as_it_is_written_out(tmp_path: Path) -> None:
    """Nine times 1009 definitions are fewer than 10000 and ten times are more, however often they were made."""
    chain = "define d0(v: m/s) -> m/s = v\n" + "".join(
        f"define d{i}(v: m/s) -> m/s = d{i - 1}(v) + d{i - 1}(v)\n" for i in range(1, 6)
    )
    chain += f"define e(v: m/s) -> m/s = {' + '.join(['d5(v)'] * 16)}\n"
    for count, codes in ((9, []), (10, ["E221"])):
        rule = f"rule r\n  require {' + '.join(['e(ego.v)'] * count)} <= 1 m/s\n"
        assert [d.code for d in compiled(tmp_path, chain + rule).found] == codes


def test_it_is_as_deep_as_it_stands(tmp_path: Path) -> None:
    """50 inside each other are the most, also where 49 of them were made for another rule."""
    chain = "define d0 -> m/s = ego.v\n" + "".join(
        f"define d{i} -> m/s = d{i - 1} + 1 m/s\n" for i in range(1, 50)
    )
    assert [d.code for d in compiled(tmp_path, f"{chain}rule r\n  require d49 <= 1 m/s\n").found] == []
    deeper = f"{chain}rule r\n  require d48 <= 1 m/s\ndefine d50 -> m/s = d49 + 1 m/s\nrule s\n  require d50 <= 1 m/s\n"
    found = compiled(tmp_path, deeper).found
    assert [d.code for d in found] == ["E221"]
    again = "define e -> m/s = d48 + 1 m/s\ndefine f -> m/s = e + 1 m/s\n"
    again += "rule q\n  require d48 + e <= 1 m/s\nrule r\n  require f <= 1 m/s\n"
    assert [d.code for d in compiled(tmp_path, chain + again).found] == ["E221"]


def test_it_is_made_once(tmp_path: Path) -> None:
    """Otherwise, nobody would notice that nothing is shared."""
    content = (
        "rule one\n  require twice(ego.v) <= 5 m/s or twice(ego.v) >= 7 m/s\n"
        "rule two\n  require twice(ego.v) <= 9 m/s\n"
        "rule three\n  for all o in objects\n  require twice(o.v) <= 9 m/s\n"
        "rule four\n  for all o in objects\n  require twice(o.v) <= 8 m/s\n"
        "rule five\n  for all p in objects\n  require twice(p.v) <= 9 m/s\n"
    )
    made = compiled(tmp_path, content)
    assert [d.code for d in made.found] == []
    bodies = {
        rule.name: {node.body for node in typed.below(rule.typed) if isinstance(node, typed.CalledNumber)}
        for rule in made.spec.rules
        if rule.typed is not None
    }
    assert all(len(found) == 1 for found in bodies.values())
    assert bodies["one"] == bodies["two"]
    assert bodies["three"] == bodies["four"]
    assert bodies["three"] != bodies["five"]
