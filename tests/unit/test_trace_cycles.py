"""Cycles are found at any depth, and the order of work does not depend on recursion."""

from __future__ import annotations

from trackmarshal.trace import cycles


def test_none() -> None:
    assert cycles.cycles({"a": ["b"], "b": ["c"], "c": []}) == []
    assert cycles.cycles({"a": ["b", "c"], "b": ["d"], "c": ["d"], "d": []}) == []  # a diamond is none


def test_the_path_is_that_of_the_cycle() -> None:
    assert cycles.cycles({"top": ["a"], "a": ["b"], "b": ["c"], "c": ["a"]}) == [["a", "b", "c"]]
    assert cycles.cycles({"a": ["a"]}) == [["a"]]
    assert cycles.cycles({"a": ["b"], "b": ["a"], "c": ["c"]}) == [["a", "b"], ["c"]]


def test_names_that_do_not_exist_close_nothing() -> None:
    assert cycles.cycles({"a": ["ghost"]}) == []


def test_shown() -> None:
    assert cycles.shown(["a", "b"]) == "a -> b -> a"
    assert (
        cycles.shown([f"r{n}" for n in range(5000)])
        == "r0 -> r1 -> r2 -> r3 -> (4994 more) -> r4998 -> r4999 -> r0"
    )


def test_a_long_cycle_is_found_without_recursion() -> None:
    ring = {f"r{n}": [f"r{(n + 1) % 5000}"] for n in range(5000)}
    assert [len(cycle) for cycle in cycles.cycles(ring)] == [5000]
    assert sorted(cycles.children_first(ring)) == sorted(ring)


def test_children_come_first() -> None:
    parents = {"top": [], "a": ["top"], "b": ["top"], "leaf": ["a", "b"]}
    order = cycles.children_first(parents)
    assert sorted(order) == sorted(parents)
    for name, above in parents.items():
        assert all(order.index(name) < order.index(parent) for parent in above)


def test_a_long_chain() -> None:
    chain = {f"r{n}": [f"r{n + 1}"] for n in range(20_000)} | {"r20000": []}
    assert cycles.children_first(chain)[0] == "r0"
    assert cycles.cycles(chain) == []


def test_the_list_of_cycles_is_bounded() -> None:
    assert len(cycles.cycles({f"r{n}": [f"r{n}"] for n in range(1000)})) == cycles.LISTED
