"""Modules to a Spec: every declaration checked, every rule typed and lowered, every error found."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from functools import cached_property, partial
from pathlib import Path
from typing import TypeVar

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic, Diagnostics, close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.spec import ConstraintInfo, PlaceInfo, RuleInfo, SignalType, Spec, TableInfo
from trackmarshal.node import Node
from trackmarshal.semantics.advice.bounds import Bounds
from trackmarshal.semantics.again import Before
from trackmarshal.semantics.causes import told_once
from trackmarshal.semantics.declarations.courses import check_course
from trackmarshal.semantics.declarations.definitions import check_definition
from trackmarshal.semantics.declarations.enums import check_enum
from trackmarshal.semantics.declarations.parameters import Parameters, constraint
from trackmarshal.semantics.declarations.places import check_stretch, place_info
from trackmarshal.semantics.declarations.rulebooks import Rulebooks
from trackmarshal.semantics.declarations.scales import check_scale
from trackmarshal.semantics.declarations.shapes import check_shape, own_fields
from trackmarshal.semantics.declarations.signals import check_signal
from trackmarshal.semantics.declarations.states import check_state
from trackmarshal.semantics.declarations.tables import table_info
from trackmarshal.semantics.elsewhere import Elsewhere
from trackmarshal.semantics.errors.declarations import SignalConflict
from trackmarshal.semantics.errors.names import Duplicate, UnknownReference
from trackmarshal.semantics.expressions.calls import built_in_names
from trackmarshal.semantics.expressions.checking import Expressions
from trackmarshal.semantics.expressions.context import Context, any_timeline
from trackmarshal.semantics.modules import Library
from trackmarshal.semantics.rules.building import RuleBuilder
from trackmarshal.semantics.scope import KINDS, Scope
from trackmarshal.semantics.warnings.vacuity import NeverAsked
from trackmarshal.source import NOWHERE, Span
from trackmarshal.syntax import ast

T = TypeVar("T", bound=ast.Item)


class Compiled(Node):
    """The outcome: a Spec of all that has a meaning, the modules it came from, and everything that was found."""

    spec: Spec
    library: Library
    #: The names of the modules that were asked for, and all in dependency order.
    asked: tuple[str, ...]
    order: tuple[str, ...]
    scopes: dict[str, Scope]
    expressions: Expressions
    found: tuple[Diagnostic, ...]
    failures: tuple[TrackmarshalError, ...]
    #: What made the numbers of its rules.
    interner: Interner

    @property
    def errors(self) -> list[Diagnostic]:
        return [d for d in self.found if d.level == "error"]

    def raise_errors(self) -> None:
        """Raise what is wrong, if anything is."""
        if self.failures:
            raise self.failures[0]
        if self.errors:
            raise Diagnostics(self.errors)

    def tests(self) -> list[ast.Test]:
        """The inline tests of all modules."""
        return [i for n in self.order for i in self.library.modules[n].tree.items if isinstance(i, ast.Test)]


def compile_paths(
    paths: Iterable[Path], shown_from: Path | None = None, before: Compiled | None = None
) -> Compiled:
    """Load and compile files and folders with all that they use; never raises for what is wrong with them.

    before: what was compiled with some of the same modules; their rules are taken from there where all that they rest on is the same.
    """
    library = Library(shown_from)
    asked = library.load(paths)
    return _Compiler(library, asked, before).run()


def compile_text(text: str, shown_from: Path | None = None, folder: Path | None = None) -> Compiled:
    """The same for a text in memory, which uses modules as a file of the folder (default: the current one) would."""
    library = Library(shown_from)
    asked = library.load_text(text, folder)
    return _Compiler(library, asked).run()


class _Compiler:
    def __init__(self, library: Library, asked: tuple[str, ...], before: Compiled | None = None) -> None:
        self._compiled_before = before
        self.library = library
        self.asked = asked
        self.order = library.order(asked)
        self.found: list[Diagnostic] = list(library.found)
        self.signals: dict[str, SignalType] = {}
        self.events: dict[str, Span] = {}
        self.tables: dict[str, TableInfo] = {}
        #: By SI unit where the scale of margins is declared first.
        self.scales: dict[str, ast.Scale] = {}
        self.places: dict[str, PlaceInfo] = {}
        self.constraints: list[ConstraintInfo] = []
        # Rules that are taken from there share their numbers with those that are made here.
        self.interner = Interner() if before is None else before.interner
        self.x = Expressions(self.signals, self.found)
        self.params = Parameters(self.x, self.interner)
        self.x.bounds = Bounds(self.signals, self.params.known, self.tables)
        self.scopes = self.x.scopes
        self.elsewhere = Elsewhere(library)

    def run(self) -> Compiled:
        for module in self.order:
            self._scope(module)
        for module in self.order:  # in a circle of modules, one uses a module that comes later
            self._uses(module)
            self.scopes[module].check_own()
        for step in (
            self._enums,
            self._fields_of_shapes,
            self._shapes,
            self._signals,
            self._courses,
            self._params,
            self._scales,
            self._tables,
            self._places,
            self._stretches,
            self._states,
            self._definitions,
            self._constraints,
        ):
            for module in self.order:
                step(module)
        rules = self._rules()
        broken = {name for scope in self.scopes.values() for name in scope.own_broken}
        names = {i.__dict__["name"] for i in self._items(ast.Rule, ast.Assume)} | broken
        silent = {rule.name for rule in rules if rule.formula is None}
        books = Rulebooks(self.scopes, names, silent, self.found)
        rulebooks = tuple(
            books.check(item, module) for module in self.order for item in self._own(module, ast.Rulebook)
        )
        self._targets(names)
        self._unasked()
        digest = hashlib.sha256("".join(r.fingerprint for r in rules).encode())
        for info in [*self.params.known.values(), *self.tables.values(), *self.places.values()]:
            digest.update(repr(info).encode())
        scales = tuple(sorted(self.x.scales.items()))
        if scales:  # of a spec without one, what is kept of runs rests on
            digest.update(repr(scales).encode())
        spec = Spec(
            self.signals,
            self.events,
            self.params.known,
            self.tables,
            self.places,
            tuple(self.constraints),
            tuple(rules),
            rulebooks,
            digest.hexdigest(),
            scales,
            tuple(self.x.courses.values()),
        )
        found = tuple(told_once(self.found))
        return Compiled(
            spec,
            self.library,
            self.asked,
            self.order,
            self.scopes,
            self.x,
            found,
            tuple(self.library.failures),
            self.interner,
        )

    @cached_property
    def _before(self) -> Before:
        """What is known of these modules already; asked for once everything is declared that rules may read."""
        wrong = self.found or self.library.failures
        return Before(
            None if wrong else self._compiled_before, self.library, self.order, self.signals, self.events, self.x.courses, self.x.scales
        )  # fmt: skip

    def _items(self, *kinds: type[ast.Item]) -> list[ast.Item]:  # type: ignore[explicit-any, unused-ignore]
        return [
            i
            for module in self.order
            for i in self.library.modules[module].tree.items
            if isinstance(i, kinds)
        ]

    def _scope(self, module: str) -> None:
        scope = self.scopes[module] = Scope(module, self.found, self.elsewhere.modules)
        loaded = self.library.modules[module]
        for item in loaded.tree.items:
            if type(item) in KINDS:
                scope.declare(item.__dict__["name"], item)
            if isinstance(item, (ast.Define, ast.Table)) and item.name in built_in_names():
                self.found.append(Duplicate(item.span.head, NOWHERE, "function", item.name))
        scope.own_broken = loaded.broken
        scope.broken = set(loaded.broken)
        scope.incomplete = not loaded.complete

    def _uses(self, module: str) -> None:
        for use in self.library.modules[module].uses:
            if use.name in self.scopes and use.name != module:
                self.scopes[module].use(self.scopes[use.name])
            elif use.name != module:
                self.scopes[module].incomplete = True

    def _context(self, module: str) -> Context:
        return Context(self.scopes[module], {}, 0, typed.THE_RUN, None, ())

    def _own(self, module: str, kind: type[T]) -> list[T]:
        """A module's declarations of a kind; those that were declared twice too, for the errors in them."""
        return [item for item in self.library.modules[module].tree.items if isinstance(item, kind)]

    def _each(self, module: str, kind: type[T], check: Callable[[T, Expressions, Context], None]) -> None:
        """Check each of a module's declarations of a kind, whatever is wrong with others."""
        ctx = self._context(module)
        for item in self._own(module, kind):
            self.x.attempt(partial(check, item, self.x, ctx), item.__dict__["span"].head)

    # Declarations ---------------------------------------------------------------------------------------------

    def _enums(self, module: str) -> None:
        for item in self._own(module, ast.Enum):
            check_enum(item, self.found)

    def _fields_of_shapes(self, module: str) -> None:
        self._each(module, ast.Shape, own_fields)

    def _shapes(self, module: str) -> None:
        self._each(module, ast.Shape, check_shape)

    def _signals(self, module: str) -> None:
        for event in self._own(module, ast.Event):
            self.events[event.name] = event.span
        self._each(module, ast.Signal, check_signal)
        for flag, span in self.events.items():
            same = self.signals.get(flag)
            if same is not None and same.span.file is not span.file:
                self.found.append(SignalConflict(span.head, same.span.head, flag))

    def _courses(self, module: str) -> None:
        self._each(module, ast.Course, check_course)

    def _params(self, module: str) -> None:
        self.params.declare(self.library.modules[module].tree.items, self._context(module))

    def _scales(self, module: str) -> None:
        self._each(module, ast.Scale, lambda item, x, _: check_scale(item, x, self.scales))

    def _tables(self, module: str) -> None:
        def declare(item: ast.Table, x: Expressions, ctx: Context) -> None:
            info = table_info(item, x, ctx)
            x.advice.units.setdefault(info.name, item.result)
            self.tables.setdefault(info.name, info)

        self._each(module, ast.Table, declare)

    def _places(self, module: str) -> None:
        def declare(item: ast.Place, x: Expressions, ctx: Context) -> None:
            info = place_info(item, x, ctx)
            self.places.setdefault(info.name, info)

        self._each(module, ast.Place, declare)

    def _stretches(self, module: str) -> None:
        ctx = self._context(module)
        for item in self._own(module, ast.Stretch):
            check = partial(check_stretch, item, self.x, ctx, self.params)
            if not self.x.attempt(check, item.span.head):
                self.x.failed.add(f"{module}.{item.name}")

    def _states(self, module: str) -> None:
        self._each(module, ast.State, check_state)

    def _definitions(self, module: str) -> None:
        if module in self._before.modules:
            return
        # A definition may use the rule's timeline: check it with one at hand.
        ctx = self._context(module).bind({}, 1, any_timeline(NOWHERE))
        for item in self._own(module, ast.Define):
            check_definition(item, self.x, ctx)

    def _constraints(self, module: str) -> None:
        def declare(item: ast.Constrain, x: Expressions, ctx: Context) -> None:
            self.constraints.append(constraint(item, x, ctx, self.interner))

        self._each(module, ast.Constrain, declare)

    def _rules(self) -> list[RuleInfo]:
        rules: list[RuleInfo] = []
        first: dict[str, ast.Item] = {}
        broken = {name for scope in self.scopes.values() for name in scope.own_broken}
        assumptions = {item.__dict__["name"] for item in self._items(ast.Assume)} | broken
        for module in self.order:
            for item in self.library.modules[module].tree.items:
                if not isinstance(item, (ast.Rule, ast.Assume)):
                    continue
                if item.name in first:
                    kind = "rule" if isinstance(item, ast.Rule) else "assumption"
                    self.found.append(
                        Duplicate(item.span.head, first[item.name].__dict__["span"].head, kind, item.name)
                    )
                rule = self._before.rule(module, item.name, assumptions)
                if rule is None:
                    rule = RuleBuilder(self.x, self._context(module), self.interner).build(item, assumptions)
                if rule is not None and item.name not in first:
                    rules.append(rule)
                first.setdefault(item.name, item)
        return rules

    def _unasked(self) -> None:
        """Warn of states that nothing depends on; where something is wrong, what it would ask for is not known."""
        if any(found.level == "error" for found in self.found) or self.library.failures:
            return
        for module in self.asked:
            for item in self._own(module, ast.State):
                if f"{module}.{item.name}" not in self.x.asked:
                    element = f"({item.binder})" if item.binder else ""
                    self.found.append(NeverAsked(item.span.head, item.name, element))

    def _targets(self, rules: set[str]) -> None:
        """Report tests that name no rule and no assumption."""
        for module in self.order:
            for test in self._own(module, ast.Test):
                if test.rule not in rules:
                    hint = close_matches(test.rule, rules)
                    hint = hint or "a test follows the rule that it is about, or uses its module"
                    at = test.span.head.word(test.rule)
                    self.found.append(UnknownReference(at, f"no rule `{test.rule}` to test", hint))


__all__ = ["Compiled", "compile_paths", "compile_text"]
