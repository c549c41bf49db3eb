"""Records: fields in order, defaults, equality without places, immutability, walks without recursion."""

from __future__ import annotations

import pickle
from typing import Any, ClassVar

import pytest

from trackmarshal.node import Node
from trackmarshal.source import NOWHERE, SourceFile, Span


class Leaf(Node):
    name: str
    span: Span = NOWHERE


class Pair(Node):
    left: Node
    right: Node
    more: tuple[Node, ...] = ()
    span: Span = NOWHERE


class Titled(Leaf):
    kind: ClassVar[str] = "titled"
    title: str = ""


SOMEWHERE = Span(SourceFile("a.spec", "abc"), 0, 1)


def test_fields_come_in_the_order_of_declaration_and_are_inherited() -> None:
    assert Pair.fields == ("left", "right", "more", "span")
    assert Titled.fields == ("name", "span", "title")
    assert Pair.compared == ("left", "right", "more")


def test_values_are_given_by_place_or_by_name() -> None:
    assert Titled("a", SOMEWHERE, "b") == Titled(name="a", title="b")
    assert Titled("a").title == ""
    assert Titled("a").span is NOWHERE


@pytest.mark.parametrize(
    ("args", "kwargs", "error"),
    [
        ((), {}, AttributeError),
        (("a", NOWHERE, "surplus"), {}, TypeError),
        (("a",), {"nme": "b"}, TypeError),
        (("a",), {"name": "b"}, TypeError),
        (("a", NOWHERE), {"name": "b"}, TypeError),
        ((), {"span": NOWHERE}, AttributeError),
    ],
)
def test_a_record_has_all_of_its_fields_once_and_no_other(
    args: tuple[Any, ...], kwargs: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error):
        Leaf(*args, **kwargs)


def test_places_are_not_compared() -> None:
    assert Leaf("a", SOMEWHERE) == Leaf("a")
    assert hash(Leaf("a", SOMEWHERE)) == hash(Leaf("a"))
    assert Leaf("a") != Leaf("b")
    assert Leaf("a") != Titled("a")
    assert (Leaf("a") == "a") is False


def test_a_record_cannot_be_changed() -> None:
    leaf = Leaf("a")
    with pytest.raises(AttributeError, match="immutable"):
        leaf.name = "b"  # type: ignore[misc]
    with pytest.raises(AttributeError, match="immutable"):
        leaf.extra = 1
    assert leaf.name == "a"


def test_children_are_the_nodes_in_fields_and_tuples() -> None:
    a, b, c = Leaf("a"), Leaf("b"), Leaf("c")
    pair = Pair(a, b, (c,))
    assert list(pair.children()) == [a, b, c]
    assert [getattr(node, "name", "pair") for node in Pair(pair, a).walk()] == [
        "pair",
        "pair",
        "a",
        "b",
        "c",
        "a",
    ]


def test_a_walk_goes_deeper_than_the_stack() -> None:
    node: Node = Leaf("end")
    for _ in range(50_000):
        node = Pair(node, Leaf("side"))
    assert sum(1 for _ in node.walk()) == 100_001


def test_a_record_shows_what_it_compares() -> None:
    assert repr(Pair(Leaf("a"), Leaf("b"))) == "Pair(left=Leaf(name='a'), right=Leaf(name='b'), more=())"


def test_a_record_survives_pickling() -> None:
    leaf = Titled("a", NOWHERE, "b")
    assert pickle.loads(pickle.dumps(leaf)) == leaf
