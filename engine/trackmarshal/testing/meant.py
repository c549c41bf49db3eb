"""What a test gives and expects, as text in which the way it is written does not count: neither units, the names of definitions, nor the order in which
things are given that are told apart by name.

Its numbers are those in SI that definitions come to. A parameter stands by its name, so that another value of it is a change of the parameter alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.description import describe
from trackmarshal.syntax import ast


class Meant:
    """Notes of one test, made while it is prepared."""

    def __init__(self) -> None:
        #: By the identity of an expression of the test's tree, which lives as long as that, what it comes to.
        self._numbers: dict[int, str] = {}
        self._names: dict[int, str] = {}
        #: The parameters that its numbers are made of, by their full names.
        self.reads: set[str] = set()

    def number(self, written: ast.Expr, core: ir.Num | None, value: float) -> None:
        """Note that an expression comes to a value in SI, by way of this core; None: it is no more than that value."""
        if core is None:
            self._numbers[id(written)] = repr(value)
            return
        params = {node.name for node in ir.below(core) if isinstance(node, ir.Param)}
        self.reads |= params
        self._numbers[id(written)] = describe(core) if params else repr(value)

    def name(self, given: ast.Given, full: str) -> None:
        """Note what is given under a name, as it is called everywhere."""
        self._names[id(given)] = full

    def text(self, test: ast.Test, variables: Sequence[str], unit: str | None) -> str:
        """The whole test; variables: those of its rule in their order, by which the one is told that `at` names; unit: that of the expected margin."""
        cycles: list[tuple[str, Mapping[str, object]]] = []
        after, given = "", dict[str, object]()
        for step in test.steps:
            if isinstance(step, ast.After):
                cycles.append((after, given))
                after, given = self._of(step.time), {}
                continue
            changes = [
                (change.field, change.index and float(change.index), self._of(change.value))
                for change in step.changes
            ]
            given[self._names[id(step)]] = (self._of(step.value), changes)
        cycles.append((after, given))
        expect = test.expect
        margin = None if expect.margin is None else (self._of(expect.margin), unit)
        tolerance = None if expect.tolerance is None or margin is None else self._of(expect.tolerance)
        which = variables.index(expect.binder) if expect.binder in variables else expect.binder
        place = expect.at if expect.at is None or expect.at.startswith('"') else float(expect.at)
        return repr(
            (
                [(t, sorted(said.items())) for t, said in cycles],
                expect.verdict,
                margin,
                tolerance,
                which,
                place,
            )
        )

    def _of(self, value: ast.Expr) -> str:
        noted = self._numbers.get(id(value))
        if noted is not None:
            return noted
        match value:
            case ast.ListValue():
                return repr([self._of(each) for each in value.values])
            case ast.RecordValue():
                return repr(sorted((name, self._of(each)) for name, each in zip(value.names, value.values)))
            case ast.Call():
                return repr(
                    (
                        value.function,
                        sorted((name, self._of(each)) for name, each in zip(value.names, value.args)),
                    )
                )
            case _:
                return repr(value)  # a word: `true`, a member, `nan`


class Told:
    """A test's text, and what that comes to: made when somebody asks, as the matrix does and `check` does not."""

    def __init__(self, test: ast.Test, meant: Meant, variables: Sequence[str], unit: str | None) -> None:
        """variables, unit: of `Meant.text`."""
        self._test, self._meant = test, meant
        self._variables, self._unit = variables, unit

    @cached_property
    def said(self) -> str:
        """The test's syntax tree without the title, of which neither layout nor comments are part."""
        return repr((self._test.steps, self._test.expect))

    @cached_property
    def meant(self) -> str:
        return self._meant.text(self._test, self._variables, self._unit)

    @property
    def reads(self) -> frozenset[str]:
        """The parameters that its numbers are made of, by their full names."""
        return frozenset(self._meant.reads)
